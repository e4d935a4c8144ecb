# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window, driven by a timer: looks at the panels, renders, breaks a long render off.

Started by test_window.py: blender --python window_steps.py -- FOLDER. What it saw goes to FOLDER/seen.json, pictures
of the screen beside it.
"""

import json
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
seen = {}


def picture(name):
    """Of the whole screen: bpy's own screenshot is black without a graphics card."""
    subprocess.run(["import", "-window", "root", str(FOLDER / f"{name}.png")], check=True)


def prepare():
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.render_display_type = "AREA"
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 160, 100, 100
    scene.petzval.samples = 4


def properties_area():
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "PROPERTIES")


def show(tab):
    bpy.context.view_layer.objects.active = bpy.context.scene.camera
    properties_area().spaces.active.context = tab


def start_render():
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen):
        bpy.ops.render.render("INVOKE_DEFAULT")


def rendering():
    return bpy.app.is_job_running("RENDER")


def steps():
    """Yields after each step the seconds to wait, or a condition with the seconds that it may take."""
    prepare()
    for tab in ("RENDER", "DATA"):
        show(tab)
        yield 1.5
        picture(f"panel-{tab.lower()}")
    ended = []
    bpy.app.handlers.render_complete.append(lambda *_: ended.append("complete"))
    bpy.app.handlers.render_cancel.append(lambda *_: ended.append("cancel"))
    start_render()
    yield (lambda: ended and not rendering()), 60.0
    yield 1.0
    picture("rendered")
    seen["rendered"] = ended == ["complete"]

    bpy.context.scene.petzval.samples = 100_000
    start_render()
    yield rendering, 10.0
    yield 3.0
    seen["running_before_escape"] = rendering()
    asked = time.monotonic()
    while rendering() and time.monotonic() - asked < 15.0:
        subprocess.run(["xdotool", "key", "Escape"], check=True)
        yield 0.3
    seen["stopped_after_s"] = time.monotonic() - asked
    seen["stopped"] = not rendering()
    picture("stopped")


walk = steps()
condition = None
patience_ends = 0.0


def end():
    (FOLDER / "seen.json").write_text(json.dumps(seen))
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


bpy.app.timers.register(tick, first_interval=2.0)
