# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window, driven by a timer: looks at the panels, renders, breaks renders off by Escape.

Started by test_window.py: blender --python window_steps.py -- FOLDER ADD-ON. What it saw goes to FOLDER/seen.json,
pictures of the screen and of the renders beside it.
"""

import importlib
import json
import math
import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy

FOLDER, ADDON = Path(sys.argv[-2]), sys.argv[-1]
# How often it is looked whether a render has ended, after Escape.
LOOK_SECONDS = 0.01
seen = {}
progress = []
drawn_s = {}
#: Names of the panels that are shown; empty: all.
shown = set()


def part(name):
    return importlib.import_module(f"{ADDON}.{name}")


def picture(name):
    """A picture of the whole screen: bpy's own screenshot is black without a graphics card."""
    subprocess.run(["import", "-window", "root", str(FOLDER / f"{name}.png")], check=True)


def set_preferences():
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.render_display_type = "AREA"
    preferences.view.show_developer_ui = False


def open_panels():
    """Every panel of the add-on unfolded, and the time to draw each written down."""
    names = ("camera", "render", "effects", "render_shapes", "render_film", "render_results", "light", "material")
    for module in [part(f"ui.{name}") for name in (*names, "objects", "world", "view_layer")]:
        module.unregister()
        for cls in module.CLASSES:
            cls.bl_options = set(getattr(cls, "bl_options", ())) - {"DEFAULT_CLOSED"}
            cls.draw = timed(cls.bl_label, cls.draw)
            if issubclass(cls, bpy.types.Panel):
                cls.poll = chosen(cls.__name__, getattr(cls, "poll", lambda _: True))
        module.register()


def chosen(name, poll):
    """Shows a panel where it stood, if it is one of `shown` or these are empty."""
    return classmethod(lambda _, context: (not shown or name in shown) and poll(context))


def show_only(*names):
    """Shows these parts of the lens's panel, so that they need not be scrolled to; none: all panels."""
    shown.clear()
    shown.update(f"PETZVAL_CAMERA_PT_{name}" for name in (*names, *(("lens",) if names else ())))
    for area in areas("PROPERTIES"):
        area.tag_redraw()


def timed(name, draw):
    def drawing(self, context):
        began = time.perf_counter()
        draw(self, context)
        drawn_s.setdefault(name, []).append(time.perf_counter() - began)

    return drawing


def make_scene():
    """A few balls in a row under a lamp, some near, some far."""
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 480, 320, 100
    for one in list(bpy.data.objects):
        if one.type == "MESH":
            bpy.data.objects.remove(one)
    bpy.ops.mesh.primitive_plane_add(size=60)
    colours = [(0.75, 0.08, 0.05), (0.85, 0.45, 0.05), (0.1, 0.35, 0.1), (0.06, 0.15, 0.5), (0.4, 0.1, 0.4)]
    for index, colour in enumerate(colours):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, segments=48, ring_count=24)
        ball = bpy.context.object
        ball.location = (1.15 * (index - 2), 1.6 * (index - 2), 0.5)
        bpy.ops.object.shade_smooth()
        material = bpy.data.materials.new("Paint")
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (*colour, 1.0)
        shader.inputs["Roughness"].default_value = 0.25
        ball.data.materials.append(material)
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.45, 0.55, 0.7, 1.0)
    holder = scene.camera
    holder.location, holder.rotation_euler = (0.0, -9.0, 1.5), (math.radians(84), 0.0, 0.0)
    own = holder.data.petzval
    own.lens_file = "double-gauss-f2-tronnier.lens"
    own.focal_mode = "LENGTH"
    own.focal_length = 85.0
    holder.data.dof.focus_distance = 9.0
    own.scale_from_scene = False
    own.scale = (200.0,) * 3


def areas(kind):
    return [area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == kind]


def split_view():
    """A second, tall properties editor between the view and the usual column."""
    window = bpy.context.window_manager.windows[0]
    view = areas("VIEW_3D")[0]
    with bpy.context.temp_override(window=window, screen=window.screen, area=view, region=view.regions[-1]):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.66)


def show(tab):
    bpy.context.view_layer.objects.active = bpy.context.scene.camera
    for area in areas("PROPERTIES"):
        area.spaces.active.context = tab


def boxes(kind):
    """Places of the areas of a kind on the screen, (x, y from the top, width, height)."""
    height = bpy.context.window_manager.windows[0].height
    return [(area.x, height - area.y - area.height, area.width, area.height) for area in areas(kind)]


def start_render():
    window = bpy.context.window_manager.windows[0]
    view = areas("VIEW_3D") or areas("IMAGE_EDITOR")
    with bpy.context.temp_override(window=window, screen=window.screen, area=view[0], region=view[0].regions[-1]):
        bpy.ops.render.render("INVOKE_DEFAULT")


def rendering():
    return bpy.app.is_job_running("RENDER")


def writable():
    """True if Blender lets the scene be changed: for a moment after a render it does not."""
    own = bpy.context.scene.petzval
    try:
        own.samples = own.samples
    except AttributeError:
        return False
    return True


def save_result(name):
    settings = bpy.context.scene.render.image_settings
    settings.file_format = "OPEN_EXR"
    settings.color_depth = "32"
    bpy.data.images["Render Result"].save_render(str(FOLDER / f"{name}.exr"))


def escape_after(seconds):
    """Steps of a long render that Escape ends `seconds` after its start; yields, and at last the seconds it took."""
    yield writable, 10.0
    bpy.context.scene.petzval.samples = 100_000
    start_render()
    yield rendering, 10.0
    yield seconds
    running = rendering()
    # Told by the render's own thread when it has ended, the window may still be busy with drawing.
    ended = []
    bpy.app.handlers.render_cancel.append(lambda *_: ended.append(time.monotonic()))
    keys = subprocess.Popen(["xdotool", "key", "Escape"])
    asked = time.monotonic()
    while rendering() and time.monotonic() - asked < 10.0:
        yield LOOK_SECONDS
    keys.wait()
    took = time.monotonic() - asked
    bpy.app.handlers.render_cancel.pop()
    seen["escapes"].append(
        {
            "running": running,
            "stopped": not rendering(),
            "window_s": took,
            "ended_s": ended[0] - asked if ended else None,
            # Progress is told until the engine learns of the key, and once more when it has ended: Blender looks at the
            # keyboard between two drawings.
            "engine_s": ended[0] - progress[-2][2] if ended else None,
        }
    )


def failing_render(info):
    """A render without a lens: Blender's message to its user, as its Info editor lists it."""
    yield writable, 10.0
    bpy.context.scene.camera.data.petzval.lens_file = "no-such.lens"
    try:
        start_render()
    except RuntimeError as error:
        # Where Blender ends the operator at once, it tells its caller.
        seen["error_told"] = str(error)
    yield 2.0
    picture("error")
    seen["rendering_after_error"] = rendering()
    info.type = "INFO"
    yield 0.5
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen, area=info, region=info.regions[-1]):
        info.spaces.active.show_report_error = True
        bpy.ops.info.select_all(action="SELECT")
        bpy.ops.info.report_copy()
    seen["told"] = bpy.context.window_manager.clipboard


def focus_panel(own):
    """The timer finds what autofocus would; three points turn the film, and undo turns it back."""
    autofocus = part("queries.autofocus")
    autofocus.forget()
    drawn_s.clear()
    own.focus_mode = "AUTO"
    context = bpy.context
    asked = context.scene.camera, context.scene, context.view_layer
    yield lambda: getattr(autofocus.for_panel(*asked), "is_current", False), 20.0
    yield 1.0
    seen["autofocus"] = autofocus.for_panel(*asked).answer
    seen["drawn_s"] = drawn_s
    show_only("focus")
    yield 0.5
    picture("panel-autofocus")
    own.focus_mode = "CAMERA"
    show_only("focus", "sharp")
    balls = [one for one in bpy.context.scene.objects if one.type == "MESH" and one.location.z > 0.0]
    own.sharp_object_1, own.sharp_object_2, own.sharp_object_3 = balls[0], balls[2], balls[3]
    balls[2].location.z += 0.5
    bpy.context.view_layer.update()
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen, area=areas("PROPERTIES")[0]):
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.petzval.sharp_points("EXEC_DEFAULT", True)
    yield 1.0
    seen["turned"] = [own.tilt, own.swing, own.focus_mode]
    picture("panel-sharp")
    with bpy.context.temp_override(window=window, screen=window.screen, area=areas("PROPERTIES")[0]):
        bpy.ops.ed.undo()
    yield 0.5
    own = bpy.context.scene.camera.data.petzval
    seen["turned_back"] = [own.tilt, own.swing, own.focus_mode]
    show_only()
    # Back onto the floor for the render.
    own.sharp_object_2.location.z -= 0.5


def lens_pictures():
    """The drawing of the lens follows its settings, and the gallery has a picture of each lens."""
    live, thumbnails = part("drawing.live_drawing"), part("drawing.thumbnails")

    def drawn():
        return [one.drawn for one in live._kept.values() if one.drawn.icon]

    yield lambda: bool(drawn()), 10.0
    before = drawn()
    show_only("drawing")
    own = bpy.context.scene.camera.data.petzval
    own.wide_open, own.f_number = False, 11.0
    yield lambda: drawn() != before, 10.0
    yield 0.5
    seen["drawing"] = [drawn()[-1].icon, drawn()[-1].fields]
    picture("panel-drawing")
    show_only()
    own.wide_open = True
    window, area = bpy.context.window_manager.windows[0], areas("PROPERTIES")[0]
    with bpy.context.temp_override(window=window, screen=window.screen, area=area, region=area.regions[-1]):
        bpy.ops.wm.call_panel(name="PETZVAL_PT_lens_gallery")
    yield 1.5
    picture("gallery")
    seen["thumbnails"] = [thumbnails.icon(key) for key in thumbnails._icons]
    subprocess.run(["xdotool", "key", "Escape"], check=True)
    yield 0.5


def other_tabs():
    """Shows the tabs of a light, a shape, its material and the world."""
    scene = bpy.context.scene
    light = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    scene.collection.objects.link(light)
    ball = next(one for one in scene.objects if one.type == "MESH" and one.data.materials)
    for holder, tab in ((light, "DATA"), (ball, "OBJECT"), (ball, "MATERIAL"), (ball, "WORLD"), (ball, "VIEW_LAYER")):
        bpy.context.view_layer.objects.active = holder
        yield 0.4
        for area in areas("PROPERTIES"):
            area.spaces.active.context = tab
        yield 1.0
        picture(f"panel-{tab.lower()}" if holder is ball else "panel-light")
    bpy.data.objects.remove(light)
    show("DATA")
    yield 0.5


def steps():
    """Yields after each step the seconds to wait, or a condition with the seconds that it may take."""
    make_scene()
    part("render.loop").WATCH.on_progress = lambda done, text: progress.append((done, text, time.monotonic()))
    open_panels()
    yield 1.0
    split_view()
    yield 0.5
    right = max(areas("VIEW_3D"), key=lambda area: area.x)
    right.type = "PROPERTIES"
    # A new editor has no tabs before it was drawn.
    yield 1.0
    for tab in ("RENDER", "DATA"):
        show(tab)
        show_only(*(("focus", "film", "scale") if tab == "DATA" else ()))
        yield 1.5
        picture(f"panel-{tab.lower()}")
    show_only()
    yield 0.5
    seen["properties"] = boxes("PROPERTIES")
    yield from lens_pictures()
    yield from other_tabs()
    own = bpy.context.scene.camera.data.petzval
    for model in ("THIN", "PINHOLE", "LENS"):
        own.model = model
        yield 1.0
        picture(f"panel-{model.lower()}")
    own.lens_file = "no-such.lens"
    yield 1.0
    picture("panel-missing")
    own.lens_file = "double-gauss-f2-tronnier.lens"
    yield from focus_panel(own)
    # Undo has made it anew.
    own = bpy.context.scene.camera.data.petzval

    # To the end.
    scene = bpy.context.scene
    # Long enough for two pictures on an idle machine, and not too long on a busy one.
    scene.petzval.samples = 48
    start_render()
    yield rendering, 10.0
    yield 1.5
    picture("rendering-1")
    seen["view"] = boxes("IMAGE_EDITOR")
    yield 2.0
    picture("rendering-2")
    seen["while_rendering"] = rendering()
    yield (lambda: not rendering()), 150.0
    yield 1.0
    picture("rendered")
    save_result("rendered")
    seen["rendered"] = part("render.statistics").last(scene.name).stats
    seen["progress"] = list(progress)

    # Broken off, soon and late.
    seen["escapes"] = []
    for seconds in (0.6, 2.0, 4.0):
        yield from escape_after(seconds)
        yield 0.5
    picture("stopped")
    save_result("stopped")
    seen["stopped"] = part("render.statistics").last(scene.name).stopped
    seen["stopped_samples"] = part("render.statistics").last(scene.name).stats["samples"]

    # What goes wrong is said. Blender itself loses a report that comes just when its operator ends: then once more.
    info = areas("OUTLINER")[0]
    for _ in range(3):
        yield from failing_render(info)
        if "no-such.lens" in seen["told"] + seen.get("error_told", ""):
            break


# Before the window is drawn for the first time: the splash would be there already.
set_preferences()
walk = steps()
condition = None
patience_ends = 0.0


def end():
    (FOLDER / "seen.json").write_text(json.dumps(seen))
    # Where Blender will not be told to quit, it must not keep the test waiting.
    bpy.app.timers.register(lambda: os._exit(0), first_interval=10.0)
    bpy.ops.wm.quit_blender()


def tick():
    global condition, patience_ends
    try:
        if condition is not None:
            if not condition():
                if time.monotonic() < patience_ends:
                    return 0.1
                raise TimeoutError(f"nothing came of {condition}")
            condition = None
        wait = next(walk)
        if isinstance(wait, tuple):
            condition, patience_ends = wait[0], time.monotonic() + wait[1]
            return 0.1
        return wait
    except StopIteration:
        end()
    except Exception:
        seen["error"] = traceback.format_exc()
        end()
    return None


# Before the window first draws, or the splash hides the rest.
bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.render_display_type = "AREA"
bpy.app.timers.register(tick, first_interval=2.0)
