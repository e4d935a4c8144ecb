# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Bake with Petzval as the engine, beside Cycles in the same Blender: every type, from where and of which light, into what."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

ALL = {"DIRECT", "INDIRECT", "COLOR", "DIFFUSE", "GLOSSY", "TRANSMISSION", "EMIT"}


@pytest.fixture
def baking(blender):
    from support import baking

    return baking


@pytest.fixture
def tile(baking):
    return baking.set_up()


@pytest.fixture
def image(baking, tile):
    return baking.image()


# Types -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "samples"),
    [("NORMAL", 64), ("ROUGHNESS", 16), ("UV", 64), ("EMIT", 16), ("ENVIRONMENT", 64), ("AO", 512)],
)
def test_what_the_surface_is(baking, tile, image, kind, samples):
    """Nothing of it depends on lamps."""
    baking.same(*baking.both(lambda engine, seed: baking.bake(tile, image, kind, engine, samples, seed)))


@pytest.mark.parametrize("kind", ["COMBINED", "DIFFUSE", "GLOSSY", "TRANSMISSION"])
def test_light(baking, tile, image, kind):
    baking.same(*baking.both(lambda engine, seed: baking.bake(tile, image, kind, engine, 1024, seed)))


def test_positions(baking, tile, image):
    """Of one sample: Cycles 5.2 gives the sum of all samples instead of their mean."""
    ours, theirs = (baking.bake(tile, image, "POSITION", engine, 1) for engine in ("PETZVAL", "CYCLES"))
    assert np.abs(ours - theirs).max() < 1e-5
    many = baking.bake(tile, image, "POSITION", "PETZVAL", 64)
    # The mean over a pixel, whose side is a sixteenth, or over what of it is in one triangle.
    assert 1e-4 < np.abs(many - ours).max() < 1 / 32


def test_shadows(baking, tile, image):
    """Of what is transparent, Cycles counts the hole twice: there it has 1 - 2 h of a shadow where ours has 1 - h."""
    ours, theirs, error = baking.both(lambda engine, seed: baking.bake(tile, image, "SHADOW", engine, 1024, seed))
    hole = 0.4 * (0.9 + 0.9 + 1.0) / 3
    rows = baking.SIDE // baking.BLOCK
    veil = (slice(-rows, None), slice(-rows, None), slice(3))
    theirs[veil] = 1 + (theirs[veil] - 1) * (1 - hole) / (1 - 2 * hole)
    error[veil] *= (1 - hole) / (1 - 2 * hole)
    baking.same(ours, theirs, error)


@pytest.mark.first_only("kind", "wanted")
@pytest.mark.parametrize(
    ("kind", "wanted"),
    [
        ("DIFFUSE", {"COLOR"}),
        ("GLOSSY", {"COLOR"}),
        ("TRANSMISSION", {"COLOR"}),
        ("DIFFUSE", {"DIRECT"}),
        ("GLOSSY", {"DIRECT", "INDIRECT"}),
        ("DIFFUSE", {"INDIRECT", "COLOR"}),
        # Cycles counts all of glass where one of both of its lobes is wanted, and where emission is not wanted it leaves out some of the
        # light of all that glows: neither is asked for here.
        ("COMBINED", ALL - {"INDIRECT"}),
        ("COMBINED", ALL - {"DIRECT"}),
        ("COMBINED", ALL - {"DIFFUSE"}),
        ("COMBINED", ALL - {"GLOSSY", "TRANSMISSION"}),
    ],
)
def test_parts_of_the_light(baking, tile, image, kind, wanted):
    samples = 64 if wanted == {"COLOR"} else 1024
    ours, theirs, error = baking.both(
        lambda engine, seed: baking.bake(tile, image, kind, engine, samples, seed, pass_filter=wanted)
    )
    if wanted == {"INDIRECT", "COLOR"}:
        # Cycles leaves alpha at 1 here, and in no other bake of light.
        theirs[..., 3] = ours[..., 3]
    # Indirect light alone is a tenth of all, and as noisy.
    baking.same(ours, theirs, error, noise=0.04 if "DIRECT" in wanted or wanted == {"COLOR"} else 0.06)


def test_the_parts_add_up(baking, tile, image):
    """Direct and indirect, lobe by lobe, and emission are the whole light, to rounding: all of one render's samples."""
    whole = baking.bake(tile, image, "COMBINED", "PETZVAL", 16)
    parts = [
        baking.bake(tile, image, "COMBINED", "PETZVAL", 16, pass_filter=one)
        for one in (
            {"DIRECT", "INDIRECT", "DIFFUSE"},
            {"DIRECT", "INDIRECT", "GLOSSY"},
            {"DIRECT", "INDIRECT", "TRANSMISSION"},
            {"EMIT"},
        )
    ]
    lobes = [baking.bake(tile, image, kind, "PETZVAL", 16) for kind in ("DIFFUSE", "GLOSSY", "TRANSMISSION", "EMIT")]
    for found in (parts, lobes):
        assert np.allclose(sum(one[..., :3] for one in found), whole[..., :3], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("is_orthographic", [False, True])
def test_seen_from_the_camera(baking, blender, tile, image, is_orthographic):
    if is_orthographic:
        blender.context.scene.camera.data.type = "ORTHO"
    take = lambda engine, seed: baking.bake(tile, image, "GLOSSY", engine, 1024, seed, view_from="ACTIVE_CAMERA")  # noqa: E731
    found = baking.both(take)
    baking.same(*found)
    above = baking.blocks(baking.bake(tile, image, "GLOSSY", "PETZVAL", 256))
    assert np.abs(above - found[0]).max() > 0.1


def test_occlusion_ends_at_its_distance(baking, blender, tile, image):
    blender.context.scene.world.light_settings.distance = 0.3
    found = baking.both(lambda engine, seed: baking.bake(tile, image, "AO", engine, 512, seed))
    baking.same(*found)
    blender.context.scene.world.light_settings.distance = 10.0
    assert baking.bake(tile, image, "AO", "PETZVAL", 64).mean() < found[0].mean() - 0.1


@pytest.mark.parametrize("method", ["BUMP", "DISPLACEMENT"])
def test_normals_of_displaced_surfaces(baking, tile, image, method):
    """Pixels are coarse here: a displacement bends normals by its slope over a tenth of one."""
    from support.node_tree import Tree

    for material in tile.data.materials:
        ends = [node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL"]
        made = Tree(material.node_tree, ends[0].inputs["Surface"])
        noise = made.node("TexNoise", None, Scale=3.0).outputs[0]
        made.lifts(made.node("Displacement", None, Height=noise, Scale=0.3).outputs[0])
        material.displacement_method = method
    baking.same(*baking.both(lambda engine, seed: baking.bake(tile, image, "NORMAL", engine, 128, seed)), limit=0.003)


# Into what ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def low(baking, tile):
    """A flat square close to the tile, and its image; the tile is baked into it."""
    from support import scenes as parts

    grey = baking.plain("Low", "BsdfDiffuse")
    corners = [(0.2, 0.2, 0.35), (2.8, 0.2, 0.35), (2.8, 1.8, 0.35), (0.2, 1.8, 0.35)]
    made = parts.mesh_object("Low", corners, [(0, 1, 2, 3)], grey, uv=[(0, 0), (1, 0), (1, 1), (0, 1)])
    made.rotation_euler, made.location = tile.rotation_euler, tile.location
    tile["baked_from"] = True
    image = baking.new_image("Low", 32, 32)
    baking.show(grey, image)
    return made, image


@pytest.mark.first_only("has_cage")
@pytest.mark.parametrize("has_cage", [False, True])
@pytest.mark.parametrize(("kind", "samples"), [("NORMAL", 64), ("COMBINED", 1024), ("DIFFUSE", 1024)])
def test_from_selected_to_active(baking, blender, low, kind, samples, has_cage):
    square, image = low
    settings = {"use_selected_to_active": True, "cage_extrusion": 0.8, "max_ray_distance": 2.0}
    if has_cage:
        cage = square.copy()
        cage.data, cage.name, cage.hide_render = square.data.copy(), "Cage", True
        for vertex in cage.data.vertices:
            vertex.co.z += 1.0
        blender.context.scene.collection.objects.link(cage)
        settings = {"use_selected_to_active": True, "use_cage": True, "cage_object": cage}
    space = "TANGENT" if kind == "NORMAL" else "OBJECT"
    take = lambda engine, seed: baking.bake(  # noqa: E731
        square, image, kind, engine, samples, seed, normal_space=space, **settings
    )
    baking.same(*baking.both(take))


@pytest.mark.first_only("domain")
@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
@pytest.mark.parametrize(("kind", "samples"), [("NORMAL", 16), ("COMBINED", 1024), ("AO", 1024)])
def test_into_vertex_colours(baking, tile, domain, kind, samples):
    colours = tile.data.color_attributes.new("Baked", "FLOAT_COLOR", domain)
    tile.data.color_attributes.active_color = colours

    def take(engine: str, seed: int) -> np.ndarray:
        baking.bake(tile, None, kind, engine, samples, seed, target="VERTEX_COLORS")
        found = np.empty((len(colours.data), 4), np.float32)
        colours.data.foreach_get("color", found.reshape(-1))
        return found

    ours, theirs = ([take(engine, seed) for seed in (0, 7)] for engine in ("PETZVAL", "CYCLES"))
    error = np.sqrt((0.25 * (ours[0] - ours[1]) ** 2 + 0.25 * (theirs[0] - theirs[1]) ** 2).mean(0))
    off = 0.5 * np.abs(ours[0] + ours[1] - theirs[0] - theirs[1])
    print(off.mean(0), error, off.max(0))
    # Single points are noisy, as there are no blocks of them: the mean is not, and none is off by what its noise does not explain. Noise is
    # uneven, a metal's most: ten times the mean square is what one of hundreds may have.
    scale = np.abs(theirs[0]).mean(0)
    assert (
        np.abs((ours[0] + ours[1] - theirs[0] - theirs[1]).mean(0)) <= 0.02 * scale + 8 * error / len(off) ** 0.5
    ).all()
    assert (off.max(0) <= 10 * error + 0.01 * scale).all()


def test_corners_of_a_vertex_have_the_same_noise(baking, tile):
    """Blender gives them one seed: a colour of corners is as smooth as one of vertices."""
    colours = tile.data.color_attributes.new("Baked", "FLOAT_COLOR", "CORNER")
    tile.data.color_attributes.active_color = colours
    baking.bake(tile, None, "AO", "PETZVAL", 4, target="VERTEX_COLORS")
    found = np.empty((len(colours.data), 4), np.float32)
    colours.data.foreach_get("color", found.reshape(-1))
    at = np.array([loop.vertex_index for loop in tile.data.loops])
    spread = [np.ptp(found[at == vertex, 0]) for vertex in np.unique(at)]
    # Corners lie a little within their faces: some rays meet what others miss. With noise of their own a quarter is usual.
    assert np.mean(spread) < 0.05


def test_margins(baking, tile, image):
    """Blender's own, from what the engine leaves."""
    uv = tile.data.uv_layers[0].uv
    found = np.empty((len(uv), 2), np.float32)
    uv.foreach_get("vector", found.reshape(-1))
    uv.foreach_set("vector", (0.25 + 0.5 * found).astype(np.float32).reshape(-1))
    for margin in (0, 4):
        take = lambda engine, margin=margin: baking.bake(tile, image, "ROUGHNESS", engine, 16, margin=margin)  # noqa: E731
        ours, theirs = take("PETZVAL"), take("CYCLES")
        assert np.abs(ours - theirs)[..., :3].max() < 1e-4
        if margin == 0:
            bare = (ours[..., :3] == 0.0).all(-1).mean()
    assert 0.6 < bare < 0.8 and (ours[..., :3] == 0.0).all(-1).mean() < bare - 0.1


def test_materials_may_have_images_of_their_own(baking, tile, image):
    second = baking.new_image("Second", 20, 24)
    for material in list(tile.data.materials)[::2]:
        baking.show(material, second)
    found = {}
    for engine in ("PETZVAL", "CYCLES"):
        baking.bake(tile, image, "UV", engine, 16)
        found[engine] = baking.pixels(image), baking.pixels(second)
    for ours, theirs in zip(*found.values(), strict=True):
        assert np.abs(ours - theirs)[..., :3].max() < 0.02
        assert 0.3 < (ours[..., 2] == 1.0).mean() < 0.7


def test_a_copy_elsewhere_is_not_what_is_baked(baking, blender, tile, image):
    """An instance of the same object, by a collection: of a place that is not its own."""
    before = baking.bake(tile, image, "POSITION", "PETZVAL", 1)
    collection = blender.data.collections.new("Copies")
    collection.objects.link(tile)
    shows = blender.data.objects.new("Shows", None)
    shows.instance_type, shows.instance_collection, shows.location = "COLLECTION", collection, (0.0, 0.0, 50.0)
    # The copy stands before the tile itself in Blender's list.
    objects = blender.context.scene.collection.objects
    objects.unlink(tile)
    objects.link(shows)
    objects.link(tile)
    assert np.array_equal(baking.bake(tile, image, "POSITION", "PETZVAL", 1), before)


# Always ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["COMBINED", "NORMAL", "AO", "SHADOW"])
def test_the_same_bits_for_any_number_of_threads(baking, blender, tile, image, kind):
    render = blender.context.scene.render
    render.threads_mode = "FIXED"
    found = []
    for threads in (1, 2):
        render.threads = threads
        found.append(baking.bake(tile, image, kind, "PETZVAL", 20, 3))
    assert np.isfinite(found[0]).all() and np.array_equal(*found)
    if kind != "NORMAL":
        assert not np.array_equal(found[0], baking.bake(tile, image, kind, "PETZVAL", 20, 4))


def test_noise_is_taken_out_where_cycles_takes_it(baking, blender, tile, image, monkeypatch):
    """Of combined light and of shadows, where the scene's pictures are denoised; and of nothing else."""
    from support import scenes

    if scenes.part("data.denoiser").library() is None:
        pytest.skip("no Open Image Denoise here")
    plain = baking.same_for_both

    def denoised(samples: int, seed: int) -> None:
        plain(samples, seed)
        blender.context.scene.cycles.use_denoising = True

    def error(kind: str, engine: str, **settings) -> float:
        found = [baking.bake(tile, image, kind, engine, 16, seed, **settings) for seed in (0, 7)]
        return np.abs(found[0] - found[1]).mean()

    some = {"DIRECT", "INDIRECT", "DIFFUSE"}
    for kind, settings, is_cleaned in (
        ("COMBINED", {}, True),
        ("COMBINED", {"pass_filter": some}, True),
        ("SHADOW", {}, True),
        ("DIFFUSE", {}, False),
    ):
        for engine in ("PETZVAL", "CYCLES"):
            monkeypatch.setattr(baking, "same_for_both", plain)
            noisy = error(kind, engine, **settings)
            monkeypatch.setattr(baking, "same_for_both", denoised)
            assert (error(kind, engine, **settings) < 0.6 * noisy) == is_cleaned, (kind, engine)


def test_what_is_not_rendered_is_named(baking, blender, tile, image):
    """The view layer shows no surfaces: there is nothing to bake."""
    before = baking.pixels(image)
    blender.context.view_layer.use_solid = False
    with pytest.raises(RuntimeError, match="object 'Tile': nothing of it is rendered"):
        baking.bake(tile, image, "AO", "PETZVAL", 4)
    assert np.array_equal(baking.pixels(image)[..., :3], before[..., :3])


def test_a_bake_can_be_stopped(baking, tile, image, monkeypatch):
    """Long before its samples are there."""
    import threading
    import time

    from support import scenes

    stop = scenes.part("render.loop").WATCH.stop
    timer = threading.Timer(0.5, stop.set)
    timer.start()
    began = time.monotonic()
    try:
        with contextlib.suppress(RuntimeError):
            baking.bake(tile, image, "COMBINED", "PETZVAL", 1 << 20)
    finally:
        timer.cancel()
        stop.clear()
    assert time.monotonic() - began < 10.0
