# SPDX-License-Identifier: GPL-3.0-or-later
"""The Vector pass: against Cycles through a pinhole, and through lenses against how the picture itself moves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.multilayer import mattes, photograph, vectors

FRAMES = ((0, 0.0), (1, 0.02), (2, 0.05))


def animate(holder, path: str, value) -> None:
    """Gives a property `value(t)` at each frame."""
    for frame, t in FRAMES:
        setattr(holder, path, value(t))
        holder.keyframe_insert(path, frame=frame)


def test_as_cycles_has_it(parts, blender, tmp_path):
    """Things that move, turn and bend, before a camera that walks, turns and zooms."""
    scene = parts.set_up(width=48, height=32)
    scene.world = parts.grey_world(0.0)
    glow = parts.emitter()
    wall = parts.square("Wall", (0.5, 5, 0.2), 1.5, glow)
    animate(wall, "location", lambda t: (0.3 + 10 * t, 5, 0.2))
    spin = parts.square("Spin", (-1.2, 4, -0.3), 0.9, glow)
    animate(spin, "rotation_euler", lambda t: (0.3, 10 * t, 5 * t))
    bend = parts.square("Bend", (1.0, 3.5, -0.6), 0.8, glow)
    bend.shape_key_add(name="Basis")
    up = bend.shape_key_add(name="Up")
    for i in (2, 3):
        up.data[i].co.z += 0.5
    animate(up, "value", lambda t: 10 * t)
    group = blender.data.collections.new("Group")
    group.objects.link(parts.square("Part", (0.0, 0.0, 0.0), 0.5, glow))
    placed = blender.data.objects.new("Placed", None)
    placed.instance_type, placed.instance_collection = "COLLECTION", group
    scene.collection.objects.link(placed)
    animate(placed, "location", lambda t: (-0.8 + 5 * t, 4.0, 0.9 - 5 * t))
    scene.collection.objects.unlink(group.objects[0])
    camera = scene.camera
    animate(camera, "rotation_euler", lambda t: (math.pi / 2, t, t))
    animate(camera, "location", lambda t: (3 * t, t, -2 * t))
    animate(camera.data, "lens", lambda t: 50 + 40 * t)
    scene.frame_set(1)
    scene.view_layers[0].use_pass_vector = True
    theirs, _ = photograph(parts, scene, tmp_path / "cycles.exr", "CYCLES")
    ours, _ = photograph(parts, scene, tmp_path / "petzval.exr")
    assert scene.frame_current == 1
    whole = (ours["combined.g"] == 1.0) & (theirs["combined.g"] == 1.0)
    assert whole.sum() > 350
    error = np.abs(vectors(ours) - vectors(theirs))[whole]
    assert np.abs(vectors(theirs)[whole]).max() > 3.0
    # Where one thing overlaps another, each engine has its own noise.
    assert np.quantile(error, 0.9) < 0.01


def test_the_background_turns_with_the_camera(parts, blender, tmp_path):
    """It lies infinitely far: walking does not move it, turning by an angle moves its directions by it."""
    scene = parts.set_up(width=48, height=32)
    camera = scene.camera
    animate(camera, "rotation_euler", lambda t: (math.pi / 2, 0.0, 3 * t))
    animate(camera, "location", lambda t: (9 * t, -5 * t, 2 * t))
    scene.frame_set(1)
    scene.view_layers[0].use_pass_vector = True
    ours, _ = photograph(parts, scene, tmp_path / "petzval.exr", samples=16)
    focal_px = 48 * 50 / 36
    place = np.arange(48) - 23.5
    expected = [
        focal_px * np.tan(np.arctan(place / focal_px) + 3 * turn) - place for turn in (FRAMES[0][1] - 0.02, 0.05 - 0.02)
    ]
    # The row through the middle, where the tangent's change over a pixel's own filter cancels to 1e-3.
    row = vectors(ours)[15:17].mean(axis=0)
    assert np.abs(row[:, 0] - expected[0]).max() < 0.02
    assert np.abs(row[:, 2] + expected[1]).max() < 0.02
    scene.render.use_motion_blur = True
    blurred, _ = photograph(parts, scene, tmp_path / "blurred.exr", samples=1)
    assert not vectors(blurred).any()


def centre(coverage: np.ndarray) -> np.ndarray:
    """The centroid of a matte, pixels right and up."""
    rows, columns = np.indices(coverage.shape)
    return np.array([(coverage * columns).sum(), (coverage * rows).sum()]) / coverage.sum()


def of_the_background(coverage: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """The vectors of what lies behind all: a lens that is refocused magnifies it otherwise, evenly about the middle."""
    rows, columns = np.indices(coverage.shape)
    terms = np.stack([np.ones(coverage.shape), columns, rows], axis=-1)
    alone = coverage == 0.0
    fit, *_ = np.linalg.lstsq(terms[alone], vector[alone], rcond=None)
    return terms @ fit


@pytest.mark.once
@pytest.mark.parametrize(
    ("model", "lens", "focal_length", "focus", "pipeline", "place"),
    [
        ("LENS", "double-gauss-f2-tronnier.lens", 85.0, 2.0, "HERO", (0.15, 2.0, 0.1)),
        ("LENS", "double-gauss-f2-tronnier.lens", 85.0, 1.0, "HERO", (0.15, 2.0, 0.1)),
        ("LENS", "double-gauss-f2-tronnier.lens", 85.0, 1.2, "SCENE", (0.15, 2.0, 0.1)),
        ("LENS", "laikin-fisheye-170.lens", 12.0, 1.0, "FILM", (1.5, 0.9, 0.5)),
        ("PARAXIAL", "double-gauss-f2-tronnier.lens", 85.0, 1.0, "FILM", (0.15, 2.0, 0.1)),
        ("THIN", "", 85.0, 1.0, "FILM", (0.15, 2.0, 0.1)),
    ],
)
def test_the_picture_moves_so(parts, blender, tmp_path, model, lens, focal_length, focus, pipeline, place):
    """Of a thing alone, sharp or blurred, that nears and crosses while the lens is refocused: the mean of its vectors is
    how far the middle of its picture goes from frame to frame."""
    scene = parts.set_up(width=36, height=24, model=model)
    scene.world = parts.grey_world(0.0)
    scene.petzval.pipeline = pipeline
    own = scene.camera.data.petzval
    if lens:
        own.lens_file = lens
        own.film_mode, own.film_width, own.film_height = "SIZE", 36.0, 24.0
        own.focal_mode, own.focal_length = "LENGTH", focal_length
    else:
        scene.camera.data.lens = focal_length
        scene.camera.data.dof.use_dof = True
        own.wide_open, own.f_number = False, 2.0
    is_fisheye = focal_length < 20.0
    # Small before a fisheye, which shows its two halves in different sizes.
    size = (2.0 if is_fisheye else 6.0) / focal_length * math.dist(place, (0, 0, 0))
    thing = parts.square("Thing", place, size, parts.emitter())
    thing.rotation_euler.z = -math.atan2(place[0], place[1])
    x, y, z = place
    pace = 0.3 if is_fisheye else 1.0
    animate(thing, "location", lambda t: (x - 10 * x * pace * t, y - 8 * y * pace * t, z - 12 * x * pace * t))
    scene.camera.data.dof.focus_distance = focus
    if not is_fisheye:
        animate(scene.camera.data.dof, "focus_distance", lambda t: focus * (1 + 3 * t))
    layer = scene.view_layers[0]
    layer.use_pass_vector = layer.use_pass_cryptomatte_object = True
    found = {}
    for frame, _ in FRAMES:
        scene.frame_set(frame)
        channels, _ = photograph(parts, scene, tmp_path / f"{frame}.exr", samples=128)
        found[frame] = next(iter(mattes(channels, "Object").values())), vectors(channels)
    coverage, vector = found[1]
    way = (vector - (1 - coverage)[..., None] * of_the_background(coverage, vector)).sum(axis=(0, 1)) / coverage.sum()
    middle = {frame: centre(found[frame][0]) for frame in found}
    expected = np.concatenate([middle[0] - middle[1], middle[1] - middle[2]])
    assert np.linalg.norm(expected) > 1.0
    # Some thousand rays over a few pixels put a centroid within 0.04.
    assert np.abs(way - expected).max() < 0.08
