# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens stmap`: the lens's picture of a pattern made the pinhole's by the map, and the other way; Blender's Map UV node too."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.command_line import assert_complains

LENS, FILM, PIXELS, DEPTH_M = "fisheye-nikkor-16-f2.8", (36.0, 24.0), (192, 128), 3.0
OPTIONS = ("--film", "36x24", "--pixels", "192x128", "--focus-distance", str(1000.0 * DEPTH_M), "--f-number", "11")
#: Pixels of a block in which a shift is looked for.
BLOCK = 16


def taken(picture: np.ndarray, st: np.ndarray) -> np.ndarray:
    """A picture looked up by a map, between the middles of its pixels."""
    height, width = picture.shape[:2]
    x, y = st[..., 0] * width - 0.5, st[..., 1] * height - 0.5
    x, y = np.clip(x, 0, width - 1.001), np.clip(y, 0, height - 1.001)
    i, j = x.astype(int), y.astype(int)
    u, v = (x - i)[..., None], (y - j)[..., None]
    low = picture[j, i] * (1 - u) + picture[j, i + 1] * u
    high = picture[j + 1, i] * (1 - u) + picture[j + 1, i + 1] * u
    return low * (1 - v) + high * v


def shifts(found: np.ndarray, wanted: np.ndarray, is_known: np.ndarray) -> np.ndarray:
    """By block, in pixels: how far one picture lies from the other, by least squares over its slopes."""
    slope_y, slope_x = np.gradient(wanted)
    lengths = []
    for y in range(BLOCK, wanted.shape[0] - 2 * BLOCK + 1, BLOCK):
        for x in range(BLOCK, wanted.shape[1] - 2 * BLOCK + 1, BLOCK):
            at = np.s_[y : y + BLOCK, x : x + BLOCK]
            if is_known[at].all():
                slopes = np.stack([slope_x[at].ravel(), slope_y[at].ravel()], axis=1)
                step, *_ = np.linalg.lstsq(slopes, (wanted - found)[at].ravel(), rcond=None)
                lengths.append(math.hypot(*step))
    return np.array(lengths)


def pattern(bpy, scenes):
    """A wall with waves of light both ways, some 15 pixels long in the pinhole's picture."""
    material, tree, surface = scenes.material("Waves")
    nodes, links = tree.nodes, tree.links
    place = nodes.new("ShaderNodeNewGeometry")
    parts = nodes.new("ShaderNodeSeparateXYZ")
    links.new(place.outputs["Position"], parts.inputs[0])

    def math_node(operation, *inputs):
        node = nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, inputs, strict=False):
            if isinstance(value, float):
                socket.default_value = value
            else:
                links.new(value, socket)
        return node.outputs[0]

    waves = [math_node("SINE", math_node("MULTIPLY", parts.outputs[axis], 11.0)) for axis in ("X", "Z")]
    light = math_node("MULTIPLY_ADD", math_node("ADD", *waves), 0.2, 0.5)
    glow = nodes.new("ShaderNodeEmission")
    links.new(light, glow.inputs["Strength"])
    links.new(glow.outputs[0], surface)
    scenes.square("Wall", (0.0, DEPTH_M, 0.0), 60.0, material)


@pytest.fixture
def pictures(blender, tmp_path):
    """Of the wall by the lens and by the pinhole that frames the same, first rows at the bottom."""
    from support import scenes

    scene = scenes.set_up(*PIXELS, samples=64, model="LENS")
    scene.petzval.filter_width = 0.0
    # Brightness is not what the map is about.
    scene.petzval.effects.vignetting = "OFF"
    camera = scene.camera.data
    own = camera.petzval
    own.lens_file, own.wide_open, own.f_number = LENS, False, 11.0
    own.spectrum, own.film_mode, own.film_width, own.film_height = "SINGLE", "SIZE", *FILM
    camera.dof.focus_distance = DEPTH_M
    pattern(blender, scenes)
    assert blender.ops.petzval.match_viewport() == {"FINISHED"}
    by_lens = scenes.render(tmp_path, "lens.exr")[..., :3].copy()
    own.model = "PINHOLE"
    by_pinhole = scenes.render(tmp_path, "pinhole.exr")[..., :3].copy()
    return by_lens, by_pinhole


@pytest.fixture
def maps(blender, petzval_cli, tmp_path):
    from support import scenes

    made = {}
    for direction in ("undistort", "distort"):
        out = tmp_path / f"{direction}.exr"
        done = petzval_cli("lens", "stmap", LENS, *OPTIONS, "--direction", direction, "-o", out)
        assert done.returncode == 0, done.stderr
        made[direction] = scenes.read(out)
    return made


@pytest.mark.once
def test_the_maps_turn_one_picture_into_the_other(pictures, maps):
    by_lens, by_pinhole = (picture[..., 1] for picture in pictures)
    cases = {"undistort": (by_lens, by_pinhole), "distort": (by_pinhole, by_lens)}
    for direction, (source, wanted) in cases.items():
        st = maps[direction]
        found = taken(source[..., None], st)[..., 0]
        off = shifts(found, wanted, st[..., 3] > 0.0)
        assert len(off) > 20
        # Looking up between pixels smooths waves of some pixels, which is no shift; noise of 64 samples is less.
        assert off.max() < 0.12, (direction, off.max())
    # Without the maps the pictures lie many pixels apart.
    st = maps["undistort"]
    height, width = st.shape[:2]
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    assert np.hypot((st[..., 0] - x) * width, (st[..., 1] - y) * height).max() > 20.0


@pytest.mark.once
def test_there_and_back_is_where_one_was(maps):
    there = maps["undistort"]
    back = taken(maps["distort"], there)
    height, width = there.shape[:2]
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    inner = there[..., 3] > 0.0
    inner[:4] = inner[-4:] = inner[:, :4] = inner[:, -4:] = False
    off = np.hypot((back[..., 0] - x) * width, (back[..., 1] - y) * height)[inner]
    # Between the pixels of one map the other is not straight: a hundredth of a pixel.
    assert off.max() < 0.05


@pytest.mark.once
def test_blenders_map_uv_node_takes_them(blender, pictures, maps, tmp_path):
    from support import scenes

    scene = blender.context.scene
    scene.camera.data.petzval.model = "PINHOLE"
    scene.petzval.samples = 1
    images = [blender.data.images.load(str(tmp_path / name)) for name in ("lens.exr", "undistort.exr")]
    images[1].colorspace_settings.name, images[1].alpha_mode = "Non-Color", "CHANNEL_PACKED"
    if blender.app.version >= (5, 0, 0):
        tree = blender.data.node_groups.new("Composite", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        scene.compositing_node_group = tree
        out = tree.nodes.new("NodeGroupOutput").inputs[0]
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        out = tree.nodes.new("CompositorNodeComposite").inputs[0]
    warp = tree.nodes.new("CompositorNodeMapUV")
    for image, name in zip(images, ("Image", "UV"), strict=True):
        node = tree.nodes.new("CompositorNodeImage")
        node.image = image
        tree.links.new(node.outputs[0], warp.inputs[name])
    tree.links.new(warp.outputs[0], out)
    scene.render.use_compositing = True
    found = scenes.render(tmp_path, "composed.exr")
    off = shifts(found[..., 1], pictures[1][..., 1], maps["undistort"][..., 3] > 0.0)
    # Blender's filter of this node is not the plain one between pixels.
    assert len(off) > 20 and off.max() < 0.25, off.max()


def test_the_operator_writes_the_same_map(blender, maps, tmp_path):
    from support import scenes

    scene = scenes.set_up(*PIXELS, model="LENS")
    own = scene.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = LENS, False, 11.0
    own.film_mode, own.film_width, own.film_height = "SIZE", *FILM
    scene.camera.data.dof.focus_distance = DEPTH_M
    out = tmp_path / "mine.exr"
    assert blender.ops.petzval.export_stmap(filepath=str(out), direction="DISTORT") == {"FINISHED"}
    # The wavelength and the focus of a Blender file are kept in single precision.
    assert np.abs(scenes.read(out) - maps["distort"]).max() < 1e-5


@pytest.mark.once
def test_colours_have_layers_of_their_own_and_what_is_wrong_is_said(blender, petzval_cli, tmp_path):
    from support import scenes

    out = tmp_path / "colours.exr"
    done = petzval_cli("lens", "stmap", "pbrt-wide-22mm", *OPTIONS[:4], "--colours", "-o", out)
    assert done.returncode == 0, done.stderr
    head = out.read_bytes()[:4000]
    for name in (b"red.R", b"green.G", b"blue.A", b"Mean rays of the clear pupil at 587.562 nm"):
        assert name in head
    assert_complains(petzval_cli("lens", "stmap", LENS, *OPTIONS, "-o", tmp_path / "map.png"), "its ending is not .exr")
    assert_complains(petzval_cli("lens", "stmap", LENS, *OPTIONS, "-o", tmp_path / "no" / "map.exr"), "no such folder")
    done = petzval_cli("lens", "stmap", LENS, *OPTIONS, "--wavelength", "5", "-o", out)
    assert_complains(done, "wavelength is 5 nm")
    # More film than the lens covers: what is dark has no source.
    done = petzval_cli(
        "lens", "stmap", LENS, "--film", "90x60", "--pixels", "90x60", "--direction", "distort", "-o", out
    )
    assert done.returncode == 0
    found = scenes.read(out)
    assert (found[0, 0] == 0.0).all() and found[30, 45, 3] == 1.0 and np.isfinite(found).all()
