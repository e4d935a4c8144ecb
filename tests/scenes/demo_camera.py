"""The demo's camera as Petzval has it: the lens, its film, and how the picture is sampled.

    HOME=/ python tests/scenes/demo_camera.py tests/scenes/demo.blend

sets an existing file, in a Python with bpy and petzval.
"""

import sys
from pathlib import Path

import bpy

LENS = "wide-angle-smith-f3.4"
EXPOSURE_STOPS = 0.4
SAMPLES = 96
# Bright specks from lamps seen in brass twice over would take thousands of samples to even out.
CLAMP_INDIRECT = 10.0
RESOLUTION_PERCENT = 75


def set_camera(scene):
    """Needs the add-on registered; leaves what Cycles uses as it is."""
    import petzval

    if not hasattr(bpy.types.Scene, "petzval"):
        petzval.load_addon().register()
    own = scene.camera.data.petzval
    own.model = "LENS"
    own.lens_file = LENS
    scene.petzval.samples = SAMPLES
    scene.petzval.clamp_indirect = CLAMP_INDIRECT
    # The lens darkens the corners; the middle may be brighter for it.
    scene.view_settings.exposure = EXPOSURE_STOPS
    scene.render.resolution_percentage = RESOLUTION_PERCENT
    scene.render.engine = "PETZVAL"


def main(path):
    """Opens, sets and saves a file."""
    import petzval

    petzval.load_addon().register()
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
    set_camera(bpy.context.scene)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=path, compress=True)


if __name__ == "__main__":
    main(str(Path(sys.argv[1]).resolve()))
    # bpy with a render engine registered does not end by itself.
    import os

    sys.stdout.flush()
    os._exit(0)
