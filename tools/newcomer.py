# SPDX-License-Identifier: GPL-3.0-or-later
"""A newcomer's path in Blender's window, timed: the engine, a lens, F12. `make newcomer` installs the extension and runs it."""

import importlib
import os
import sys
import time
import traceback

import bpy

ADDON = "bl_ext.user_default.petzval"
LENS = "double-gauss-f2-tronnier.lens"
began = float(os.environ["PETZVAL_BEGAN"])


def told(what):
    print(f"{time.time() - began:6.1f} s  {what}", flush=True)


def path():
    told("Blender's window is there")
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    bpy.context.view_layer.objects.active = scene.camera
    with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
        bpy.ops.petzval.choose_lens("EXEC_DEFAULT", lens=LENS)
        told(f"F12, through {scene.camera.data.petzval.lens_file}")
        loop = importlib.import_module(f"{ADDON}.render.loop")
        first = []

        def on_progress(_part, text):
            if "Sample 1/" in text and not first:
                first.append(text)
                told("the first sample of every pixel is there")

        loop.WATCH.on_progress = on_progress
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield 1.0
    while bpy.app.is_job_running("RENDER"):
        yield 0.2
    last = importlib.import_module(f"{ADDON}.render.statistics").last(scene.name)
    told(f"{last.stats['width']} x {last.stats['height']} pixels of {last.stats['samples_mean']:.0f} samples are done")


steps = path()


def tick():
    try:
        return next(steps)
    except StopIteration:
        status = 0
    except Exception:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    # Blender would ask whether to save.
    os._exit(status)


bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.render_display_type = "AREA"
bpy.app.timers.register(tick, first_interval=0.5)
