# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render` of simulated fluids, which end the process of Blender as a Python module where a render frees them."""

from __future__ import annotations

import subprocess
import sys

import pytest

from support.places import TESTS
from support.render_commands import picture

MAKE = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
from support import scenes as parts
parts.set_up(48, 32, 4)
parts.square("Square", (0.1, 5, 0.2), 0.6, parts.emitter((1.0, 0.5, 0.2), 2.0))
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 7, 0))
bpy.context.object.name = "Smoke"
domain = bpy.context.object.modifiers.new("Fluid", "FLUID")
domain.fluid_type = "DOMAIN"
domain.domain_settings.resolution_max = 16
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, location=(0, 7, 0))
bpy.context.object.modifiers.new("Fluid", "FLUID").fluid_type = "FLOW"
bpy.ops.wm.save_as_mainfile(filepath={path!r})
sys.stdout.flush()
os._exit(0)
"""

pytestmark = pytest.mark.once


def test_a_fluid_does_not_end_the_render(blender, petzval_cli, tmp_path):
    """Beyond the first frame, where the solver has begun; that it simulates nothing is said."""
    scene, out = tmp_path / "fluid.blend", tmp_path / "out.exr"
    script = MAKE.format(tests=str(TESTS), path=str(scene))
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, timeout=120)
    asked = ("--camera", "pinhole", "--frame", 3, "--samples", 2, "--resolution", "48x32", "-o", out)
    done = petzval_cli("render", scene, *asked)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "'Smoke'" in done.stderr and "simulates no fluid" in done.stderr
    assert picture(out).max() > 0.5
