# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Bevel makes other corners in each process: a job has its result."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from support import render_commands
from support.exr_bytes import assert_same_picture
from support.places import ROOT

pytestmark = pytest.mark.once

#: A bevelled head, hidden in 3D views, and another one in a library.
MAKE = """
import bpy
def head(x):
    bpy.ops.mesh.primitive_monkey_add(location=(x, 5.0, 0.0))
    made = bpy.context.object.modifiers.new("Bevel", "BEVEL")
    made.segments, made.width = 3, 0.03
    bpy.context.object.modifiers.new("Subdivision", "SUBSURF").render_levels = 1
    return bpy.context.object
bpy.ops.wm.read_factory_settings(use_empty=True)
head(1.2)
bpy.ops.wm.save_as_mainfile(filepath={library!r})
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
scene.camera.rotation_euler = (1.5708, 0.0, 0.0)
scene.collection.objects.link(scene.camera)
scene.world = bpy.data.worlds.new("World")
own = head(-1.2)
own.hide_viewport = True
with bpy.data.libraries.load({library!r}, link=True) as (there, here):
    here.objects = there.objects
scene.collection.objects.link(here.objects[0])
bpy.ops.wm.save_as_mainfile(filepath={scene!r}, relative_remap=True)
"""


def run(folder, *words):
    (done,) = render_commands.many([list(words)], folder)
    assert done.returncode == 0, done.stderr
    return done


def test_parts_of_bevelled_meshes(tmp_path):
    """Parts in processes of their own agree, and make the picture of the packed scene."""
    pytest.importorskip("bpy")
    scene, job, whole = tmp_path / "scene.blend", tmp_path / "job", tmp_path / "whole.exr"
    script = MAKE.format(library=str(tmp_path / "library.blend"), scene=str(scene))
    subprocess.run([sys.executable, "-c", script + "import os; os._exit(0)"], cwd=ROOT, timeout=120, check=True)
    options = ["--camera", "pinhole", "--resolution", "64x48", "--samples", "4", "--denoise", "off"]
    planned = run(tmp_path, "farm", "plan", scene, *options, "--parts", "2", "-o", job)
    assert "Bevel" not in planned.stderr
    for number in (0, 1):
        run(tmp_path, "farm", "part", job, str(number))
    run(tmp_path, "farm", "merge", job)
    run(tmp_path, "render", job / "scene/scene.blend", *options, "-o", whole)
    assert_same_picture(job / "pictures/scene.exr", whole)


@pytest.fixture
def bevelled(blender, parts):
    parts.set_up()
    blender.ops.mesh.primitive_cube_add()
    one = blender.context.object
    one.modifiers.new("Array", "ARRAY").count = 2
    one.modifiers.new("Bevel", "BEVEL").segments = 3
    one.modifiers.new("Subdivision", "SUBSURF").levels = 1
    return one


def corners(blender, one):
    graph = blender.context.evaluated_depsgraph_get()
    mesh = one.evaluated_get(graph).to_mesh()
    found = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", found)
    return np.array(sorted(map(tuple, found.reshape(-1, 3).round(5))))


def test_modifiers_up_to_the_bevel_are_applied(blender, bevelled):
    from petzval.farm import bevels

    before = corners(blender, bevelled)
    bevelled.modifiers.new("Weighted", "WEIGHTED_NORMAL")
    bevelled.modifiers["Subdivision"].render_levels = 1
    assert bevels.apply_all(blender, 1, moves=True) == (["Cube"], [])
    assert [one.name for one in bevelled.modifiers] == ["Weighted"]
    assert len(bevelled.data.vertices) > 2 * 8 * 3
    assert np.allclose(corners(blender, bevelled), before, atol=1e-5)
    assert [one.name for one in blender.data.scenes] == ["Scene"]


@pytest.mark.parametrize("what", ["an animated modifier", "a modifier by another object", "particles"])
def test_what_is_not_the_same_at_all_times_stays(blender, bevelled, what):
    from petzval.farm import bevels

    if what == "an animated modifier":
        bevelled.modifiers["Array"].keyframe_insert("count", frame=1)
    elif what == "a modifier by another object":
        made = bevelled.modifiers.new("Hook", "HOOK")
        made.object = blender.data.objects["Camera"]
        bevelled.modifiers.move(len(bevelled.modifiers) - 1, 0)
    else:
        bevelled.modifiers.new("Hair", "PARTICLE_SYSTEM")
    assert bevels.apply_all(blender, 1, moves=True) == ([], ["Cube"])
    # At one time alone they may be applied, unless particles grow from the mesh as it was.
    done, _ = bevels.apply_all(blender, 1, moves=False)
    assert done == ([] if what == "particles" else ["Cube"])


def test_a_bevel_that_no_render_shows_stays(blender, bevelled):
    from petzval.farm import bevels

    bevelled.modifiers["Bevel"].show_render = False
    assert bevels.apply_all(blender, 1, moves=False) == ([], [])
    assert len(bevelled.modifiers) == 3


def test_adaptive_subdivision_is_left_to_the_render(blender, bevelled):
    """Before Blender 5 the object has the setting, and only while features are experimental."""
    from petzval.farm import bevels

    subdivision = bevelled.modifiers["Subdivision"]
    blender.context.scene.render.engine = "CYCLES"
    if hasattr(subdivision, "use_adaptive_subdivision"):
        subdivision.use_adaptive_subdivision = True
    else:
        bevelled.cycles.use_adaptive_subdivision = True
    assert bevels.apply_all(blender, 1, moves=True) == (["Cube"], [])
    assert [one.name for one in bevelled.modifiers] == ["Subdivision"]
