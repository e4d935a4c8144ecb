# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of panoramic cameras, and what nodes and passes know of them, against Cycles in the same Blender."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest

WIDTH, HEIGHT, SAMPLES = 48, 24, 256

#: A projection, and its settings.
PROJECTIONS = {
    "equirectangular": ("EQUIRECTANGULAR", {}),
    "a part of the sphere": (
        "EQUIRECTANGULAR",
        {"longitude_min": -0.6, "longitude_max": 1.1, "latitude_min": 0.1, "latitude_max": 0.8},
    ),
    "cube map": ("EQUIANGULAR_CUBEMAP_FACE", {}),
    "mirror ball": ("MIRRORBALL", {}),
    "equidistant": ("FISHEYE_EQUIDISTANT", {"fisheye_fov": radians(220)}),
    "equisolid": ("FISHEYE_EQUISOLID", {"fisheye_lens": 8.0, "fisheye_fov": radians(170)}),
    "equisolid, fitted to the height": (
        "FISHEYE_EQUISOLID",
        {"fisheye_lens": 8.0, "fisheye_fov": pi, "sensor_fit": "VERTICAL", "sensor_height": 20.0},
    ),
    "polynomial": ("FISHEYE_LENS_POLYNOMIAL", {"fisheye_fov": radians(150)}),
    "cylinder": (
        "CENTRAL_CYLINDRICAL",
        {
            "central_cylindrical_range_v_max": 0.7,
            "central_cylindrical_range_u_min": -2.0,
            "central_cylindrical_radius": 0.8,
        },
    ),
}


@pytest.fixture
def round_about(blender):
    """Cubes that glow around a camera that stands askew, in a sky of a colour for each direction."""
    from support import scenes as parts

    scene = parts.set_up(WIDTH, HEIGHT, SAMPLES)
    dice = np.random.default_rng(3)
    for index in range(14):
        towards = dice.normal(size=3)
        blender.ops.mesh.primitive_cube_add(
            size=0.9, location=2.5 * towards / np.linalg.norm(towards), rotation=dice.uniform(0, pi, 3)
        )
        colour = tuple(dice.uniform(0.2, 1.0, 3))
        blender.context.object.data.materials.append(parts.emitter(colour, 1.0, name=f"Glow {index}"))
    tree = scene.world.node_tree
    coordinates, absolute = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeVectorMath")
    absolute.operation = "ABSOLUTE"
    tree.links.new(coordinates.outputs["Generated"], absolute.inputs[0])
    tree.links.new(absolute.outputs[0], tree.nodes["Background"].inputs["Color"])
    scene.camera.data.type = "PANO"
    scene.camera.location, scene.camera.rotation_euler = (0.2, -0.1, 0.1), (1.2, 0.3, 0.7)
    return scene


def look_by(camera, name: str) -> None:
    kind, settings = PROJECTIONS[name]
    camera.panorama_type = kind
    for key, value in settings.items():
        setattr(camera, key, value)


def alike(folder, **more) -> np.ndarray:
    """Each pixel is as Cycles has it: 256 samples of edges between glowing colours."""
    from support import beside_cycles

    return beside_cycles.alike(folder, SAMPLES, side=1, mean=0.005, block=0.1, floor=0.5, **more)


@pytest.mark.parametrize("name", PROJECTIONS)
def test_projections(round_about, tmp_path, name):
    look_by(round_about.camera.data, name)
    alike(tmp_path)


def test_rays_beyond_the_circle_are_told(round_about, tmp_path):
    """No lens loses them: a circle covers a quarter of pi of the square about it."""
    from support import scenes as parts

    look_by(round_about.camera.data, "equidistant")
    parts.render(tmp_path)
    last = parts.part("render.statistics").last(round_about.name)
    assert "lens" not in " ".join(last.lines())
    told = next(line for line in last.lines() if line.endswith("outside of the projection"))
    assert float(told.split()[0]) == pytest.approx(100.0 * (1.0 - pi / 4.0), abs=0.5)


def test_shift_and_pixels_that_are_not_square(round_about, tmp_path):
    look_by(round_about.camera.data, "equisolid")
    round_about.camera.data.shift_x, round_about.camera.data.shift_y = 0.1, -0.05
    round_about.render.pixel_aspect_x = 1.3
    alike(tmp_path)


def test_clipping_counts_the_distance(round_about, tmp_path):
    """All around, the near halves of the cubes and what lies beyond them are cut away."""
    round_about.camera.data.clip_start, round_about.camera.data.clip_end = 2.4, 2.9
    look_by(round_about.camera.data, "equirectangular")
    alike(tmp_path)


def test_depth_of_field(round_about, tmp_path, monkeypatch):
    """Of a thin lens that turns to each direction; in focus at a distance, not at a depth."""
    from support import beside_cycles

    camera = round_about.camera.data
    look_by(camera, "equirectangular")
    camera.petzval.model = "THIN"

    def focus(*_arguments):
        camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 1.0, 0.05

    # The comparison is without depth of field else.
    plain = beside_cycles.without_tricks
    monkeypatch.setattr(beside_cycles, "without_tricks", lambda samples: (plain(samples), focus()))
    alike(tmp_path)


#: What nodes know of the camera, and whether the mirror ball, whose space is another, is tried.
def _window(tree):
    return tree.nodes.new("ShaderNodeTexCoord").outputs["Window"]


def _camera(tree):
    return tree.nodes.new("ShaderNodeTexCoord").outputs["Camera"]


def _view(tree):
    return tree.nodes.new("ShaderNodeCameraData").outputs["View Vector"]


def _depth(tree):
    return tree.nodes.new("ShaderNodeCameraData").outputs["View Z Depth"]


@pytest.mark.parametrize("read", [_window, _camera, _view, _depth])
@pytest.mark.parametrize("name", ["equirectangular", "mirror ball", "equisolid"])
@pytest.mark.first_only("name")
def test_nodes(round_about, blender, tmp_path, name, read):
    """On the cubes and, from behind them, in the sky."""
    look_by(round_about.camera.data, name)
    trees = [material.node_tree for material in blender.data.materials if material.name.startswith("Glow")]
    for tree in (*trees, round_about.world.node_tree):
        shader = next(node for node in tree.nodes if node.type in {"EMISSION", "BACKGROUND"})
        bounded = tree.nodes.new("ShaderNodeVectorMath")
        bounded.operation = "FRACTION"
        scaled = tree.nodes.new("ShaderNodeVectorMath")
        scaled.operation, scaled.inputs["Scale"].default_value = "SCALE", 0.24
        shifted = tree.nodes.new("ShaderNodeVectorMath")
        shifted.inputs[1].default_value = (0.5, 0.5, 0.5)
        tree.links.new(read(tree), scaled.inputs[0])
        tree.links.new(scaled.outputs[0], shifted.inputs[0])
        tree.links.new(shifted.outputs[0], bounded.inputs[0])
        tree.links.new(bounded.outputs[0], shader.inputs["Color"])
        shader.inputs["Strength"].default_value = 1.0
    alike(tmp_path)


def test_passes(round_about, blender, tmp_path):
    """Mist and places; vectors of cubes before a camera that walks and turns."""
    from support import scenes as parts
    from support.multilayer import photograph, vectors

    scene = round_about
    look_by(scene.camera.data, "equidistant")
    for frame, t in ((0, 0.0), (1, 0.02), (2, 0.05)):
        scene.camera.location, scene.camera.rotation_euler = (0.2 + 3 * t, t, -2 * t), (1.2, 0.3 + 2 * t, 0.7)
        scene.camera.keyframe_insert("location", frame=frame)
        scene.camera.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_set(1)
    layer = scene.view_layers[0]
    layer.use_pass_vector = layer.use_pass_z = layer.use_pass_mist = True
    scene.world.mist_settings.start, scene.world.mist_settings.depth = 1.5, 2.0
    scene.render.film_transparent, scene.render.resolution_x, scene.render.resolution_y = True, 3 * WIDTH, 3 * HEIGHT
    theirs, _ = photograph(parts, scene, tmp_path / "cycles.exr", "CYCLES")
    ours, _ = photograph(parts, scene, tmp_path / "petzval.exr")
    # At an edge each version of Cycles counts the sky in its own way.
    whole = (ours["combined.a"] == 1.0) & (theirs["combined.a"] == 1.0)
    assert whole.sum() > 300
    depths = [next(value for name, value in one.items() if name.startswith("depth")) for one in (ours, theirs)]
    # Cycles has the depth of a pixel's first sample, and a pixel is nearly two degrees wide.
    assert np.quantile(np.abs(depths[0] - depths[1])[whole], 0.5) < 0.02
    error = np.abs(vectors(ours) - vectors(theirs))[whole]
    print("vector", np.quantile(error, [0.5, 0.9, 1.0]), np.abs(vectors(theirs)[whole]).max(), whole.sum())
    assert np.abs(vectors(theirs)[whole]).max() > 0.5
    assert np.quantile(error, 0.9) < 0.02
    mist = [next(value for name, value in one.items() if name.startswith("mist")) for one in (ours, theirs)]
    assert np.quantile(np.abs(mist[0] - mist[1]), 0.9) < 0.02
