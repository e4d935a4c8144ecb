# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of cameras whose objects are mirrored, sheared or without scale, against Cycles in the same Blender."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

WIDTH, HEIGHT, SAMPLES = 48, 27, 256

#: What the camera object's matrix is multiplied by, by rows.
MATRICES = {
    "mirrored to the side": ((-1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "upside down in the mirror": ((1, 0, 0), (0, -2, 0), (0, 0, 1)),
    "looking back": ((1, 0, 0), (0, 1, 0), (0, 0, -1)),
    "mirrored in all axes, and scaled": ((-3, 0, 0), (0, -0.5, 0), (0, 0, -2)),
    "sheared": ((1, 0.6, 0), (0, 1, 0.3), (0, 0, 1)),
}


@pytest.fixture
def askew(blender):
    """A camera that stands askew among cubes that glow, no two in one colour, and can be multiplied by a matrix."""
    from mathutils import Euler, Matrix

    from support import scenes as parts

    scene = parts.set_up(WIDTH, HEIGHT, SAMPLES)
    dice = np.random.default_rng(5)
    for index in range(40):
        towards = dice.normal(size=3)
        blender.ops.mesh.primitive_cube_add(
            size=0.9, location=3.0 * towards / np.linalg.norm(towards), rotation=dice.uniform(0, pi, 3)
        )
        colour = tuple(dice.uniform(0.2, 1.0, 3))
        blender.context.object.data.materials.append(parts.emitter(colour, 1.0, name=f"Glow {index}"))
    camera = scene.camera
    camera.location, camera.rotation_euler = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    camera.data.lens = 24.0
    camera.data.clip_start = 0.01
    camera.parent = blender.data.objects.new("Holder", None)
    scene.collection.objects.link(camera.parent)

    def multiply(rows) -> None:
        place = Matrix.Translation((0.2, -0.1, 0.1)) @ Euler((1.2, 0.3, 0.7)).to_matrix().to_4x4()
        camera.matrix_parent_inverse = place @ Matrix(rows).to_4x4()

    return scene, multiply


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO", "PANO"])
@pytest.mark.parametrize("name", MATRICES)
def test_matrices(askew, tmp_path, kind, name):
    from support import beside_cycles

    scene, multiply = askew
    scene.camera.data.type = kind
    multiply(MATRICES[name])
    # Edges between glowing colours; each pixel is as Cycles has it.
    beside_cycles.alike(tmp_path, SAMPLES, side=1, mean=0.005, block=0.1, floor=0.5)


@pytest.mark.parametrize("axis", range(3))
def test_no_scale_along_an_axis(askew, tmp_path, axis):
    """The picture is that of the camera without any scale, to the rounding of a rotation, and the user is told."""
    import bpy

    from support import scenes as parts

    scene, multiply = askew
    warnings = parts.part("export.report").Report()
    describe = parts.part("export.camera").describe
    pictures = []
    for scale in (1.0, 0.0):
        rows = np.eye(3)
        rows[axis, axis] = scale
        multiply(rows.tolist())
        bpy.context.view_layer.update()
        describe(scene.camera, scene, WIDTH, HEIGHT, warnings)
        assert len(warnings.warnings) == (scale == 0.0)
        pictures.append(parts.render(tmp_path))
    assert np.abs(pictures[0] - pictures[1]).mean() < 1e-3
    assert "its scale is 0 along an axis" in warnings.warnings[0]
