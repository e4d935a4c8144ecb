# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window: a 3D view in rendered shading while its scene is edited, undone, saved, loaded, and the add-on is turned
off and on.

Started by test_window_viewport.py: blender --python window_viewport_steps.py -- FOLDER ADD-ON SCENE. What it saw goes to
FOLDER/seen.json, pictures of the screen beside it.
"""

import importlib
import json
import os
import subprocess
import sys
import threading
import time
import traceback
import weakref
from pathlib import Path

import addon_utils
import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Euler, Vector

FOLDER, ADDON, SCENE = Path(sys.argv[-3]), sys.argv[-2], sys.argv[-1]
TURNS = 20 if os.environ.get("PETZVAL_TEST_ALL") else 12
# A test takes few; for pictures that are shown `make ui-pictures` asks for more.
SAMPLES = int(os.environ.get("PETZVAL_PICTURE_SAMPLES", "4"))
PIXEL_SIZE = "4" if SAMPLES == 4 else "2"
# A folder with pyoidn, for a Blender without Open Image Denoise; pictures that are shown are denoised then.
PACKAGES = os.environ.get("PETZVAL_PICTURE_PACKAGES", "")
seen = {"shown": {}, "seconds": {}}
views, sessions = [], []


def part(name):
    return importlib.import_module(f"{ADDON}.{name}")


def watch_views():
    """Every view that is rendered from now on is noted."""
    cls = part("viewport.rendered_view").RenderedView
    begin = cls.__init__

    def noted(self, host):
        begin(self, host)
        # Not to keep it alive.
        views.append(weakref.ref(self))
        sessions.append(weakref.ref(self.session))

    cls.__init__ = noted


def picture(name):
    subprocess.run(["import", "-window", "root", str(FOLDER / f"{name}.png")], check=True)


def view():
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")


def override():
    window, area = bpy.context.window_manager.windows[0], view()
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window, screen=window.screen, area=area, region=region)


def shade(kind):
    view().spaces.active.shading.type = kind


def session():
    return views[-1]().session


def threads():
    return [one for one in threading.enumerate() if one.name == "petzval viewport"]


def at_rest():
    """The last picture is finished and on the screen."""
    found = views[-1]() if views else None
    if found is None or found.session.is_busy or found.session.picture is None:
        return False
    return found._drawn is found.session.picture


def note(name):
    """Notes the picture of the view."""
    pixels = session().picture.pixels[..., :3]
    seen["shown"][name] = [float(pixels.mean()), *map(float, pixels.mean(axis=(0, 1)))]
    seen["seconds"][name] = dict(session().seconds)
    picture(name)


def look(name):
    view().tag_redraw()
    yield 0.3
    yield at_rest, 60.0
    note(name)


def resident_mb():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def on_screen(place):
    """Pixels from the upper left corner."""
    region = next(region for region in view().regions if region.type == "WINDOW")
    at = location_3d_to_region_2d(region, view().spaces.active.region_3d, place)
    return int(region.x + at.x), int(bpy.context.window_manager.windows[0].height - region.y - at.y)


def mouse(*arguments):
    subprocess.run(["xdotool", *map(str, arguments)], check=True)


def drag_focus():
    """The ring on the camera's axis is taken at its rim and drawn from 4 to 5 units."""
    holder = bpy.context.scene.camera
    own, dof = holder.data.petzval, holder.data.dof
    own.show_focus, own.focus_mode, dof.focus_object, dof.focus_distance = True, "CAMERA", None, 4.0
    with override():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.context.view_layer.objects.active = holder
        holder.select_set(True)
    place, turn = holder.matrix_world.translation, holder.matrix_world.to_quaternion()
    axis = turn @ Vector((0.0, 0.0, -1.0))
    region_3d = view().spaces.active.region_3d
    region_3d.view_perspective = "PERSP"
    # From the side and above.
    region_3d.view_rotation = turn @ Euler((-0.5, 0.9, 0.0)).to_quaternion()
    region_3d.view_location, region_3d.view_distance = place + 4.0 * axis, 9.0
    view().tag_redraw()
    yield 1.0
    picture("focus-ring")
    end = on_screen(place + 5.0 * axis)
    for beside in (8, 12, 16, 20, 24):
        begin = on_screen(place + 4.0 * axis)
        mouse("mousemove", begin[0] + beside, begin[1])
        yield 0.4
        mouse("mousedown", 1)
        yield 0.2
        mouse("mousemove", (begin[0] + end[0]) // 2, (begin[1] + end[1]) // 2)
        yield 0.2
        mouse("mousemove", *end)
        yield 0.2
        mouse("mouseup", 1)
        yield 0.5
        if abs(dof.focus_distance - 4.0) > 0.1:
            break
    seen["dragged"] = dof.focus_distance


def show_sequence(world, colours):
    """The sky has the colour of the scene's frame, by an image sequence."""
    for frame, colour in colours.items():
        made = bpy.data.images.new("made", 4, 4)
        made.pixels.foreach_set([*colour, 1.0] * 16)
        made.filepath_raw, made.file_format = str(FOLDER / f"sky_{frame:04d}.png"), "PNG"
        made.save()
        bpy.data.images.remove(made)
    tree = world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(str(FOLDER / "sky_0001.png"))
    texture.image.source, texture.image_user.frame_duration = "SEQUENCE", len(colours)
    texture.image_user.use_auto_refresh = True
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 1.0
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def steps():
    bpy.ops.wm.open_mainfile(filepath=SCENE, load_ui=False)
    yield 1.0
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    scene.petzval.preview_samples, scene.petzval.preview_pixel_size = SAMPLES, PIXEL_SIZE
    if PACKAGES:
        sys.path.append(PACKAGES)
        scene.cycles.use_preview_denoising, scene.cycles.preview_denoising_start_sample = True, SAMPLES
        scene.cycles.preview_denoising_input_passes = "RGB_ALBEDO_NORMAL"
    watch_views()
    view().spaces.active.region_3d.view_perspective = "CAMERA"
    with override():
        bpy.ops.view3d.view_center_camera()
    yield 0.5
    began = time.monotonic()
    shade("RENDERED")
    yield (lambda: views and session().picture is not None), 60.0
    seen["seconds"]["entered"] = time.monotonic() - began
    yield from look("viewport-camera")
    seen["frame"] = [session().picture.wanted.settings.width, session().picture.wanted.settings.height]

    # Edits, with what they send.
    own = scene.camera.data.petzval
    seen["f_number"] = own.f_number
    own.wide_open, own.f_number = False, 16.0
    yield from look("viewport-stopped-down")
    with override():
        bpy.ops.ed.undo_push(message="stopped down")
    for lamp in bpy.data.lights:
        lamp.energy *= 0.1
    yield from look("viewport-dark")
    with override():
        bpy.ops.ed.undo_push(message="dark")
        bpy.ops.ed.undo()
    yield from look("viewport-undone")
    scene = bpy.context.scene
    chosen = next(one for one in scene.objects if one.type == "MESH")
    with override():
        bpy.ops.object.select_all(action="DESELECT")
        bpy.context.view_layer.objects.active = chosen
        chosen.select_set(True)
    chosen.hide_viewport = True
    yield from look("viewport-hidden")
    chosen.hide_viewport = False

    # An image sequence in the sky follows the frame.
    show_sequence(scene.world, {1: (1.0, 0.1, 0.1), 2: (0.1, 0.1, 1.0)})
    for frame in (1, 2):
        scene.frame_set(frame)
        yield from look(f"viewport-frame-{frame}")

    # Another look: Blender's own perspective, and along parallel lines.
    view().spaces.active.region_3d.view_perspective = "PERSP"
    yield from look("viewport-perspective")
    view().spaces.active.region_3d.view_perspective = "ORTHO"
    yield from look("viewport-orthographic")

    # A lens that is missing is told, and nothing hangs.
    view().spaces.active.region_3d.view_perspective = "CAMERA"
    scene.camera.data.petzval.lens_file = "no-such.lens"
    view().tag_redraw()
    yield 1.5
    seen["told"] = next(iter(views[-1]()._told.values()), session().error)
    picture("viewport-missing")
    with override():
        bpy.ops.ed.undo_push(message="missing")

    # Saved, and loaded again.
    scene.camera.data.petzval.lens_file = "double-gauss-f2-tronnier.lens"
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / "saved.blend"))
    shade("SOLID")
    yield 0.5
    yield (lambda: not threads()), 20.0
    seen["left"] = [sum(one() is not None for one in ones) for ones in (views, sessions)]
    bpy.ops.wm.open_mainfile(filepath=str(FOLDER / "saved.blend"), load_ui=False)
    yield 1.0
    seen["loaded"] = [bpy.context.scene.render.engine, bpy.context.scene.camera.data.petzval.lens_file]
    shade("RENDERED")
    yield from look("viewport-loaded")

    # Off and on. Without our engine the view would be EEVEE's, which takes minutes here to compile its shaders.
    memory = []
    shade("SOLID")
    # A scene that is soon built.
    bpy.data.batch_remove([one for one in bpy.data.objects if one.type == "MESH" and len(one.data.polygons) > 500])
    yield 0.5
    for _ in range(TURNS):
        addon_utils.disable(ADDON)
        yield 0.1
        addon_utils.enable(ADDON)
        bpy.context.scene.render.engine = "PETZVAL"
        watch_views()
        shade("RENDERED")
        yield (lambda: session().picture is not None), 60.0
        shade("SOLID")
        yield (lambda: not threads()), 60.0
        memory.append(resident_mb())
    seen["memory_mb"] = memory
    seen["panels"] = len([one for one in bpy.types.Panel.__subclasses__() if "petzval" in one.__name__.lower()])
    shade("RENDERED")
    yield from look("viewport-again")
    seen["threads"] = len(threads())
    shade("SOLID")
    yield 0.5
    yield from drag_focus()


walk = steps()
condition = None
patience_ends = 0.0


def end():
    (FOLDER / "seen.json").write_text(json.dumps(seen))
    # Where Blender will not be told to quit, it must not keep the test waiting.
    bpy.app.timers.register(lambda: os._exit(0), first_interval=10.0, persistent=True)
    bpy.ops.wm.quit_blender()


def tick():
    global condition, patience_ends
    try:
        if condition is not None:
            if not condition():
                if time.monotonic() < patience_ends:
                    return 0.05
                raise TimeoutError(f"nothing came of {condition}; last: {list(seen['shown'])}")
            condition = None
        wait = next(walk)
        if isinstance(wait, tuple):
            condition, patience_ends = wait[0], time.monotonic() + wait[1]
            return 0.05
        return wait
    except StopIteration:
        end()
    except Exception:
        seen["error"] = traceback.format_exc()
        end()
    return None


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(tick, first_interval=2.0, persistent=True)
