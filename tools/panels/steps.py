# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window, driven by a timer: shows some of the add-on's panels at a time, each by itself, and photographs
the screen.

Started by __main__.py: blender --in-window demo.blend --python steps.py -- FOLDER ADD-ON. The places of the panels go to FOLDER/seen.json:
for each picture the part of the screen, or, at the end, the error.
"""

import importlib
import json
import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy

FOLDER, ADDON = Path(sys.argv[-2]), sys.argv[-1]
#: Name of the picture, the tab, and its panels: module, class without its prefix, each after its parent.
PICTURES = (
    ("lens", "DATA", (("camera", "CAMERA_PT_lens"), ("lens_drawing", "CAMERA_PT_drawing"))),
    (
        "aperture",
        "DATA",
        (("camera", "CAMERA_PT_aperture"), ("camera", "CAMERA_PT_glare"), ("camera", "CAMERA_PT_exposure")),
    ),
    ("focus", "DATA", (("focus", "CAMERA_PT_focus"), ("focus", "CAMERA_PT_sharp"))),
    ("film", "DATA", (("camera", "CAMERA_PT_film"), ("scale", "CAMERA_PT_scale"))),
    ("effects", "RENDER", (("effects", "RENDER_PT_effects"), ("effects", "RENDER_PT_effects_why"))),
    (
        "render",
        "RENDER",
        (
            ("render", "RENDER_PT_sampling"),
            ("render", "RENDER_PT_sampling_viewport"),
            ("render", "RENDER_PT_sampling_advanced"),
            ("render", "RENDER_PT_light_paths"),
        ),
    ),
)
#: The objects in which three points are made sharp.
SHARP = ("Pocket watch", "Decanter", "Desk lamp")
#: The view's part of the width; the panels of effects have room for the cost of each.
VIEW_SHARE = 0.62
LONGEST_PLAN_S = 240.0
seen = {}


def part(name):
    return importlib.import_module(f"{ADDON}.{name}")


def areas(kind):
    return [area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == kind]


def in_area(area):
    window = bpy.context.window_manager.windows[0]
    region = next(one for one in area.regions if one.type == "WINDOW")
    return bpy.context.temp_override(window=window, screen=window.screen, area=area, region=region)


def clear():
    """All panels of the properties editor away, Blender's too: children first."""
    panels = [one for one in bpy.types.Panel.__subclasses__() if getattr(one, "is_registered", False)]
    panels = [one for one in panels if getattr(one, "bl_space_type", "") == "PROPERTIES"]
    for cls in sorted(panels, key=lambda one: not getattr(one, "bl_parent_id", "")):
        bpy.utils.unregister_class(cls)


def opened(module, name, names):
    """A panel, unfolded; without the parent that is not in the picture."""
    cls = getattr(part(f"ui.{module}"), f"PETZVAL_{name}")
    cls.bl_options = set(getattr(cls, "bl_options", ())) - {"DEFAULT_CLOSED"}
    if getattr(cls, "bl_parent_id", "").removeprefix("PETZVAL_") not in names:
        cls.bl_parent_id = ""
    bpy.utils.register_class(cls)
    return cls


def set_scene():
    """Sets the values that the rows show."""
    scene = bpy.context.scene
    own = scene.camera.data.petzval
    own.wide_open, own.f_number = False, 4.0
    own.blades, own.blade_curvature = 7, 0.6
    own.physical_exposure = True
    own.focus_mode = "AUTO"
    own.sharp_object_1, own.sharp_object_2, own.sharp_object_3 = (scene.objects[name] for name in SHARP)
    bpy.context.view_layer.objects.active = scene.camera


def steps():
    """Yields after each step the seconds to wait, or a condition with the seconds that it may take."""
    set_scene()
    yield 1.0
    view = areas("VIEW_3D")[0]
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen, area=view, region=view.regions[-1]):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=VIEW_SHARE)
    yield 0.5
    editor = max(areas("VIEW_3D"), key=lambda area: area.x)
    editor.type = "PROPERTIES"
    # A new editor has no tabs before it was drawn.
    yield 1.0
    planning, scene = part("render.planning"), bpy.context.scene
    with in_area(editor):
        bpy.ops.petzval.plan_effects()
    yield (lambda: planning.last(scene.name) is not None), LONGEST_PLAN_S
    clear()
    for picture, tab, panels in PICTURES:
        editor.spaces.active.context = tab
        names = [name for _, name in panels]
        shown = [opened(module, name, names) for module, name in panels]
        editor.tag_redraw()
        # Autofocus and the drawing are asked for by their panels.
        yield 4.0
        subprocess.run(["import", "-window", "root", str(FOLDER / f"{picture}.png")], check=True)
        region = next(one for one in editor.regions if one.type == "WINDOW")
        top = window.height - region.y - region.height
        seen[picture] = [region.x, top, region.x + region.width, top + region.height]
        for cls in reversed(shown):
            bpy.utils.unregister_class(cls)


walk = steps()
condition = None
patience_ends = 0.0


def end():
    (FOLDER / "seen.json").write_text(json.dumps(seen))
    # Without its panels Blender need not put itself in order.
    os._exit(0)


def tick():
    global condition, patience_ends
    try:
        if condition is not None:
            if not condition():
                if time.monotonic() < patience_ends:
                    return 0.1
                raise TimeoutError("effects were not measured in time")
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


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(tick, first_interval=2.0)
