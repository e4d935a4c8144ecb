# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m plan_scenes FOLDER [NAME ...]`: writes FOLDER/NAME.blend, with Petzval's settings left as they are by default."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

import petzval
from plan_scenes import SCENES


def main() -> None:
    folder, *names = sys.argv[1:]
    petzval.load_addon().register()
    for name in names or SCENES:
        one = SCENES[name]
        one.open()
        scene = bpy.context.scene
        scene.render.engine = "PETZVAL"
        # Few enough to be quick; light that is bounced more often is not what these scenes are about.
        scene.petzval.samples, scene.petzval.max_bounces = 64, 4
        scene.cycles.use_denoising = False
        if one.focus_m is None:
            scene.camera.data.petzval.focus_mode = "INFINITY"
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder).absolute() / f"{name}.blend"))
    # bpy with a render engine hangs or crashes when Python ends by itself.
    sys.stdout.flush()
    os._exit(0)


main()
