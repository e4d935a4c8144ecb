# SPDX-License-Identifier: GPL-3.0-or-later
"""Work for an engine that counts its own branches and calls: `python tools/train_engine.py FOLDER`, in bpy.

The compiler lays the release out by the counts (tools/build-wheel.sh). The parity scenes have each node, lamp and surface; the demo scene
goes through each kind of camera and pipeline; lens reports are made. Code that never runs here is compiled for size, and slower.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

import bpy

from parity import in_blender
from parity_scenes import SCENES, photograph
from petzval import render_command, render_in_blender
from petzval.cli import run_command

TOP = Path(__file__).resolve().parents[1]
DEMO = TOP / "tests" / "scenes" / "demo.blend"
WIDTH, HEIGHT, SAMPLES = 120, 68, 16
#: Options of `petzval render` on the demo scene.
RENDERS = (
    "--lens wide-angle-smith-f3.4",
    "--lens wide-angle-smith-f3.4 --noise-threshold 0.1 --min-samples 4",
    "--lens nikkor-z-24-70-f4 --focal-length 35 --passes",
    "--lens phone-4.1-f1.8 --film lens --autofocus 0.5,0.5",
    "--lens anamorphic-2x-double-gauss --spectrum rgb",
    "--lens double-gauss-f2-available --spectrum 550 --precision f32",
    "--lens double-gauss-f2-available --spectrum 550 --precision f64 --tilt 3",
    "--lens double-gauss-f2-available --pipeline film",
    "--lens double-gauss-f2-available --pipeline scene",
    "--lens double-gauss-f2-available --integrator bdpt",
    "--lens double-gauss-f2-available --f-number 11 --blades 6 --effect ghosts=on --effect glare=on --effect diffraction=on",
    "--lens reflex-nikkor-500-f8 --focus-distance inf --film lens",
    "--camera thin --f-number 2",
    "--camera thick --lens double-gauss-f2-available",
    "--camera paraxial --lens double-gauss-f2-available",
    "--camera image-based --lens double-gauss-f2-available",
)
#: Commands on lenses.
LENSES = ("double-gauss-f2-available", "nikkor-z-24-70-f4", "cellphone-5.6mm-f3.5")
REPORTS = ("spots", "fans", "mtf", "psf", "distortion", "illumination", "transmission", "ghosts", "info")


def options_of_render(options: str, out: Path) -> dict[str, Any]:
    """The options that `petzval render` makes of these words on the demo scene."""
    parser = argparse.ArgumentParser()
    render_command.add_parser(parser.add_subparsers())
    common = ["--resolution", f"{WIDTH}x{HEIGHT}", "--samples", str(SAMPLES), "--checkpoint", "off", "-o", str(out)]
    return render_command.options_of(parser.parse_args(["render", str(DEMO), *common, *options.split()]))


def main(folder: Path) -> int:
    in_blender.registered()
    for name, scene in SCENES.items():
        scene.open()
        photograph.prepare(WIDTH, HEIGHT, SAMPLES)
        bpy.context.scene.petzval.samples = SAMPLES
        try:
            photograph.looks("PETZVAL", folder, scene.passes, scene.frames)
        except RuntimeError as error:
            # An older Blender does not have all that the scenes ask for.
            print(f"{name}: {error}", flush=True)
    commands = [["lens", report, lens] for lens in LENSES for report in REPORTS]
    commands += [["lens", "tolerance", LENSES[0], "--trials", "20"]]
    failed = [" ".join(command) for command in commands if run_command(command)]
    # The command itself would end the process.
    failed += [
        options for options in RENDERS if render_in_blender.render(options_of_render(options, folder / "demo.exr"))
    ]
    print(f"failed: {failed}" if failed else "the engine is trained", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    # Not os._exit: the counts are written when the process ends by itself.
    os.chdir(sys.argv[1])
    sys.exit(main(Path(sys.argv[1])))
