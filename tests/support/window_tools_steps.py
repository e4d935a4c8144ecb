# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window, driven by a timer: picks the focus with the mouse, leaves it by Escape, opens a report.

Started by test_window_tools.py: blender --python window_tools_steps.py -- FOLDER ADD-ON. What it saw goes to FOLDER/seen.json.
"""

import importlib
import json
import os
import subprocess
import sys
import traceback
from pathlib import Path

import bpy

FOLDER, ADDON = Path(sys.argv[-2]), sys.argv[-1]
seen = {}


def window():
    return bpy.context.window_manager.windows[0]


def view():
    area = next(area for area in window().screen.areas if area.type == "VIEW_3D")
    return area, next(region for region in area.regions if region.type == "WINDOW")


def in_view():
    area, region = view()
    return bpy.context.temp_override(window=window(), area=area, region=region)


def mouse(across, up):
    """Moves the mouse to a part of the view's width and height."""
    _, region = view()
    x, y = region.x + across * region.width, window().height - (region.y + up * region.height)
    subprocess.run(["xdotool", "mousemove", str(round(x)), str(round(y))], check=True)


def focus():
    return bpy.context.scene.camera.data.dof.focus_distance


def steps():
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    own = scene.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = "cooke-triplet-50mm", False, 11.0
    area, _ = view()
    area.spaces.active.region_3d.view_perspective = "CAMERA"
    yield 1.0
    seen["before"] = focus()
    with in_view():
        bpy.ops.petzval.pick_focus("INVOKE_DEFAULT")
    yield 0.5
    mouse(0.5, 0.45)
    yield 0.5
    subprocess.run(["xdotool", "key", "Escape"], check=True)
    yield 1.0
    seen["after escape"] = focus()
    seen["modal"] = [one.bl_idname for one in getattr(window(), "modal_operators", ())]
    with in_view():
        bpy.ops.petzval.pick_focus("INVOKE_DEFAULT")
    yield 0.5
    # The cube stands in the middle of the factory scene's picture.
    mouse(0.5, 0.5)
    yield 0.5
    subprocess.run(["xdotool", "click", "1"], check=True)
    yield 1.0
    seen["picked"] = focus()
    with in_view():
        bpy.ops.petzval.pick_focus(point=(0.5, 0.5))
    seen["by number"] = focus()
    with in_view():
        seen["report"] = list(bpy.ops.petzval.lens_report(kind="DRAWING"))
    yield 1.5
    seen["shown"] = [
        area.spaces.active.image.name
        for one in bpy.context.window_manager.windows
        for area in one.screen.areas
        if area.ui_type == "IMAGE_EDITOR" and area.spaces.active.image is not None
    ]
    with in_view():
        bpy.ops.wm.call_menu(name="VIEW3D_MT_object")
    yield 0.7


walk = steps()


def step():
    try:
        return next(walk)
    except StopIteration:
        pass
    except BaseException:
        seen["error"] = traceback.format_exc()
    (FOLDER / "seen.json").write_text(json.dumps(seen))
    importlib.import_module(ADDON).unregister()
    os._exit(0)


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(step, first_interval=1.5)
