# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine as Blender drives it: registered, rendering, cropped, layered, saved and loaded."""

from __future__ import annotations

import numpy as np
import pytest

from support.multilayer import exr_channels

BALL = "ball-lens-10mm.lens"


def engines(bpy) -> str:
    """The engine list, as Blender names it when asked for one that is not there."""
    with pytest.raises(TypeError) as caught:
        bpy.context.scene.render.engine = "NOT THERE"
    return str(caught.value)


def test_the_engine_is_in_the_list(blender):
    assert "'PETZVAL'" in engines(blender)
    blender.context.scene.render.engine = "PETZVAL"
    assert blender.context.engine == "PETZVAL"


def test_unregistering_leaves_nothing_behind(blender, parts):
    def classes():
        return {name for name in dir(blender.types) if "petzval" in name.lower()}

    def handlers():
        every = (getattr(blender.app.handlers, name) for name in dir(blender.app.handlers))
        return [f for group in every if isinstance(group, list) for f in group if "petzval" in f.__module__]

    def panels():
        kept = (getattr(panel, "COMPAT_ENGINES", ()) for panel in blender.types.Panel.__subclasses__())
        # Classes that were unregistered live on until Python forgets them.
        return [engines for engines in kept if "PETZVAL" in engines and engines != {"PETZVAL"}]

    addon = parts.addon()
    assert classes() and handlers() and panels()
    try:
        for _ in range(2):
            addon.unregister()
            assert not classes()
            assert not handlers()
            assert not panels()
            assert "PETZVAL" not in engines(blender)
            assert not hasattr(blender.types.Camera, "petzval")
            assert not hasattr(blender.types.Scene, "petzval")
            addon.register()
    finally:
        if not hasattr(blender.types.Scene, "petzval"):
            addon.register()
    assert classes() and handlers() and panels()


def test_a_render_shows_the_scene(parts, tmp_path):
    parts.set_up()
    parts.square("Red", (0, 5, 0), 1.0, parts.emitter((1.0, 0.0, 0.0), 3.0))
    picture = parts.render(tmp_path)
    assert picture.shape == (32, 48, 4)
    assert np.allclose(picture[16, 24, :3], (3.0, 0.0, 0.0), atol=1e-3)
    assert np.allclose(picture[1, 1, :3], 0.5, rtol=1e-3)


@pytest.mark.once
def test_one_seed_gives_one_picture(parts, tmp_path):
    scene = parts.set_up(model="LENS")
    parts.square("Square", (0.1, 5, 0), 1.0, parts.emitter())
    first, again = parts.render(tmp_path, "1.exr"), parts.render(tmp_path, "2.exr")
    assert np.array_equal(first, again)
    scene.petzval.seed = 1
    assert not np.array_equal(first, parts.render(tmp_path, "3.exr"))


@pytest.mark.parametrize("percent", [50, 33, 150])
def test_resolution_percentage(parts, tmp_path, percent):
    scene = parts.set_up(width=50, height=30)
    scene.render.resolution_percentage = percent
    picture = parts.render(tmp_path)
    assert picture.shape[:2] == (30 * percent // 100, 50 * percent // 100)


@pytest.mark.first_only("model")
@pytest.mark.parametrize("border", [(0.25, 0.75, 0.25, 0.75), (0.1, 0.37, 0.53, 0.99), (0.0, 1.0, 0.9, 1.0)])
@pytest.mark.parametrize("model", ["PINHOLE", "LENS"])
def test_a_border_is_the_crop_of_the_whole(parts, tmp_path, border, model):
    scene = parts.set_up(width=61, height=43, model=model)
    parts.square("Square", (0.1, 5, 0.2), 1.5, parts.emitter((1.0, 0.4, 0.1)))
    whole = parts.render(tmp_path, "whole.exr")
    render = scene.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = border
    cropped = parts.render(tmp_path, "crop.exr")
    render.use_crop_to_border = False
    framed = parts.render(tmp_path, "frame.exr")

    window = parts.part("data.tiles").region(61, 43, border)
    rows, columns = slice(window.y, window.y + window.height), slice(window.x, window.x + window.width)
    assert cropped.shape == (window.height, window.width, 4)
    assert np.array_equal(cropped, whole[rows, columns])
    assert framed.shape == whole.shape
    assert np.array_equal(framed[rows, columns], whole[rows, columns])
    outside = np.ones(whole.shape[:2], bool)
    outside[rows, columns] = False
    assert not framed[outside].any()
    last = parts.part("render.statistics").last(scene.name)
    assert last.stats["samples"] == last.stats["samples_most"] == scene.petzval.samples


@pytest.mark.once
def test_a_border_renders_no_more_than_itself(parts, blender):
    """But for whole tiles, and with what strays over the picture all of it."""
    scene = parts.set_up(width=320, height=320, samples=2, model="LENS")
    parts.straight(scene)
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.1, 0.2
    scene.render.border_min_y, scene.render.border_max_y = 0.1, 0.2

    def rays() -> int:
        blender.ops.render.render()
        return parts.part("render.statistics").last("Scene").stats["camera_rays"]

    # A tile has 32 x 32 pixels; a border of 32 touches up to nine of the hundred.
    assert rays() <= 2 * 9 * 32 * 32
    scene.petzval.effects.glare = "ON"
    assert rays() >= 2 * 320 * 320


def test_a_transparent_film(parts, tmp_path):
    scene = parts.set_up()
    parts.square("Square", (0, 5, 0), 1.0, parts.emitter())
    scene.render.film_transparent = True
    picture = parts.render(tmp_path)
    assert np.allclose(picture[16, 24], 1.0, atol=1e-3)
    assert not picture[1, 1].any()
    scene.render.film_transparent = False
    assert np.allclose(parts.render(tmp_path)[1, 1, 3], 1.0)


def test_png(parts, tmp_path):
    scene = parts.set_up()
    parts.square("Square", (0, 5, 0), 1.0, parts.emitter((1.0, 0.0, 0.0)))
    parts.exr(scene, "PNG")
    scene.view_settings.view_transform = "Standard"
    picture = parts.render(tmp_path, "picture.png")
    assert picture.shape[:2] == (32, 48)
    assert np.allclose(picture[16, 24, :3], (1.0, 0.0, 0.0), atol=0.01)


def test_view_layers_and_multilayer_exr(parts, blender, tmp_path):
    scene = parts.set_up()
    scene.view_layers[0].name = "Both"
    left = parts.square("Left", (-0.7, 5, 0), 0.6, parts.emitter((1.0, 0.0, 0.0)))
    parts.square("Right", (0.7, 5, 0), 0.6, parts.emitter((0.0, 1.0, 0.0)))
    shelf = blender.data.collections.new("Left only")
    scene.collection.children.link(shelf)
    scene.collection.objects.unlink(left)
    shelf.objects.link(left)
    less = scene.view_layers.new("Less")
    less.layer_collection.children["Left only"].exclude = True
    parts.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.filepath = str(tmp_path / "layers.exr")
    blender.ops.render.render(write_still=True)

    layers = exr_layers(tmp_path / "layers.exr")
    assert {"Both", "Less"} <= set(layers)
    both, less = layers["Both"], layers["Less"]
    assert both[16, 14, 0] == pytest.approx(1.0, abs=1e-3) and both[16, 14, 1] == pytest.approx(0.0, abs=1e-3)
    assert less[16, 14, :3] == pytest.approx([0.5] * 3, abs=1e-3)
    assert np.array_equal(both[:, 30:], less[:, 30:])


@pytest.mark.parametrize("model", ["PINHOLE", "LENS"])
def test_passes_of_data(parts, blender, tmp_path, model):
    """A wall that stands slanted, out of focus: depth, place and normal lie on it, and the picture is still there."""
    scene = parts.set_up()
    wall = parts.square("Wall", (0.1, 6, 0), 9.0, parts.emitter((0.2, 0.6, 0.4)))
    wall.rotation_euler.z += 0.4
    scene.camera.data.petzval.model = model
    scene.camera.data.dof.focus_distance = 2.0
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_position = layer.use_pass_normal = True
    parts.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(tmp_path / "passes.exr")
    blender.ops.render.render(write_still=True)

    channels = {name.partition(".")[2]: pixels for name, pixels in exr_channels(tmp_path / "passes.exr").items()}
    place = np.stack([channels[f"Position.{c}"] for c in "XYZ"], axis=-1)
    normal = np.stack([channels[f"Normal.{c}"] for c in "XYZ"], axis=-1)
    to_world = np.array(wall.matrix_world)
    facing = to_world[:3, 1] / np.linalg.norm(to_world[:3, 1])
    # Single precision at six units, half of it in the file's own rounding.
    assert np.abs((place - to_world[:3, 3]) @ facing).max() < 1e-4
    assert np.abs(np.abs(normal @ facing) - 1.0).max() < 1e-4
    eye = np.array(scene.camera.matrix_world)
    depth = channels.get("Depth.Z", channels.get("Depth.V"))
    assert np.abs(depth - (eye[:3, 3] - place) @ eye[:3, 2]).max() < 1e-3
    # Through a lens a few samples have the colours of a few wavelengths.
    assert channels["Combined.G"][12:20, 20:28].mean() == pytest.approx(0.6, abs=0.05)


def exr_layers(path) -> dict[str, np.ndarray]:
    """Combined of every layer of an uncompressed multilayer EXR, (height, width, RGBA), first row at the bottom."""
    channels = exr_channels(path)
    layers = {name.removesuffix(".Combined.R") for name in channels if name.endswith(".Combined.R")}
    return {layer: np.stack([channels[f"{layer}.Combined.{c}"] for c in "RGBA"], axis=-1) for layer in layers}


@pytest.mark.once
@pytest.mark.parametrize("model", ["PINHOLE", "LENS"])
def test_errors_of_neighbours_cancel_with_blue_noise(parts, blender, tmp_path, model):
    """A wall in the half shadow of a bar before a large lamp."""
    scene = parts.set_up(width=32, height=32, samples=16, model=model)
    scene.camera.data.petzval.lens_file = "double-gauss-f2-tronnier.lens"
    scene.world = parts.grey_world(0.0, "Dark")
    scene.petzval.filter_width = 0.0
    parts.square("Wall", (0.0, 4.0, 0.0), 8.0)
    lamp = blender.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 500.0, 2.0
    holder = blender.data.objects.new("Lamp", lamp)
    holder.location, holder.rotation_euler = (3.0, -1.0, 0.0), (np.pi / 2, 0.0, 0.6)
    scene.collection.objects.link(holder)
    parts.square("Bar", (1.6, 1.5, 0.0), 0.6, parts.emitter((0.0, 0.0, 0.0)))

    def pictures(seeds, samples, blue):
        scene.petzval.use_blue_noise, scene.petzval.samples = blue, samples
        found = []
        for seed in seeds:
            scene.petzval.seed = seed
            found.append(parts.render(tmp_path, "picture.exr")[..., :3])
        return np.stack(found)

    # Its errors are to those of 16 samples as 1 to 128, squared.
    truth = pictures([100], 2048, False)
    own, shared = pictures(range(8), 16, False) - truth, pictures(range(8), 16, True) - truth

    def seen(error):
        # Blocks of 4 x 4 pixels, as an eye at a distance sees them.
        return (error.reshape(8, 8, 4, 8, 4, 3).mean(axis=(2, 4)) ** 2).mean()

    assert truth.mean() > 0.1
    # Smooth light through three or four dimensions: far below the sixteenth of errors that know nothing of each other.
    assert seen(shared) < 0.6 * seen(own)
    # A pixel alone is no worse, to what 8192 pixels tell; and no light is lost.
    assert (shared**2).mean() < 1.15 * (own**2).mean()
    assert abs(shared.mean()) < 0.002 * truth.mean()


def test_every_setting_survives_saving(parts, blender, tmp_path):
    scene = parts.set_up()

    def all_settings(scene):
        return {"camera": scene.camera.data.petzval, "scene": scene.petzval, "effects": scene.petzval.effects}

    holders = all_settings(scene)
    wanted = {}
    for name, holder in holders.items():
        for prop in holder.bl_rna.properties:
            if prop.identifier in {"rna_type", "name", "effects"}:
                continue
            value = another_value(prop, getattr(holder, prop.identifier))
            setattr(holder, prop.identifier, value)
            wanted[name, prop.identifier] = plain(getattr(holder, prop.identifier))
            assert wanted[name, prop.identifier] == pytest.approx(plain(value)), prop.identifier
    # Setting one must not have moved another.
    wanted = {key: plain(getattr(holders[key[0]], key[1])) for key in wanted}
    path = tmp_path / "kept.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(path))
    blender.ops.wm.read_factory_settings(use_empty=True)
    blender.ops.wm.open_mainfile(filepath=str(path))
    holders = all_settings(blender.context.scene)
    assert {key: plain(getattr(holders[key[0]], key[1])) for key in wanted} == wanted
    assert len(wanted) > 20
    for name, key in wanted:
        assert holders[name].is_property_set(key), key


def another_value(prop, now):
    """A value of the property that it does not have yet."""
    if prop.type == "ENUM":
        return next(item.identifier for item in prop.enum_items if item.identifier != now)
    if prop.type == "BOOLEAN":
        return not now
    if prop.type == "STRING":
        return "cooke-triplet-50mm.lens"
    if prop.type == "POINTER":
        import bpy

        is_image = prop.fixed_type.identifier == "Image"
        return bpy.data.images.new("Mask", 4, 4) if is_image else bpy.data.objects.new(prop.identifier, None)
    if prop.type == "INT":
        return now + 3
    if prop.is_array:
        # Within its range: a place in the picture ends at 1.
        step = min(1.5, 0.2 * (prop.hard_max - prop.hard_min))
        return tuple(value + step * (1 + index) for index, value in enumerate(now))
    return now + 0.25


def plain(value):
    if hasattr(value, "name_full"):  # a datablock: its address does not outlive the file
        return value.name_full
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def test_every_setting_says_what_it_is(parts):
    scene = parts.set_up()
    for holder in (scene.camera.data.petzval, scene.petzval):
        for prop in holder.bl_rna.properties:
            if prop.identifier in {"rna_type", "name"} or prop.is_hidden:
                continue
            assert prop.name and prop.description, prop.identifier
            assert not prop.description.endswith("."), f"Blender adds the full stop itself: {prop.identifier}"


@pytest.mark.parametrize(
    ("break_it", "words"),
    [
        (lambda scene: setattr(scene.camera.data.petzval, "lens_file", "no-such.lens"), "no such lens: "),
        (lambda scene: setattr(scene.camera.data.petzval, "lens_file", __file__), "test_engine.py:2"),
    ],
)
def test_what_goes_wrong_is_a_report_and_a_black_picture(parts, blender, tmp_path, break_it, words):
    scene = parts.set_up(model="LENS")
    break_it(scene)
    scene.render.filepath = str(tmp_path / "picture.exr")
    with pytest.raises(RuntimeError) as caught:
        blender.ops.render.render(write_still=True)
    message = str(caught.value).strip()
    assert words in message
    assert "\n" not in message
    if (tmp_path / "picture.exr").exists():
        assert not parts.read(tmp_path / "picture.exr")[..., :3].any()


def test_no_camera_is_blenders_own_error(parts, blender):
    scene = parts.set_up()
    scene.camera = None
    with pytest.raises(RuntimeError, match="[Cc]amera"):
        blender.ops.render.render()


def test_a_render_stops_at_once_and_keeps_what_is_there(parts, blender, tmp_path):
    import threading
    import time

    scene = parts.set_up(width=320, height=200, samples=1_000_000, model="LENS")
    watch = parts.part("render.loop").WATCH
    asked = []

    def ask():
        asked.append(time.monotonic())
        watch.stop.set()

    timer = threading.Timer(2.0, ask)
    timer.start()
    try:
        picture = parts.render(tmp_path)
    finally:
        timer.cancel()
        watch.stop.clear()
    # Half of it is Blender's own: writing the picture. A busy machine may take longer than the promised 0.3 s.
    assert asked and time.monotonic() - asked[0] < 3.0
    last = parts.part("render.statistics").last(scene.name)
    assert last.stopped and 1 <= last.stats["samples"] < 1_000_000
    # In the middle: wide open the default lens vignettes as its product does.
    assert picture[90:110, 150:170, :3].mean() == pytest.approx(0.5, rel=0.1)


def test_the_statistics_of_the_last_render_are_kept(parts, blender):
    parts.set_up(samples=3, model="LENS")
    blender.ops.render.render()
    last = parts.part("render.statistics").last("Scene")
    assert last.stats["samples"] == 3
    assert last.stats["camera_rays"] >= 3 * 48 * 32
    assert last.stats["non_finite_samples"] == 0
    assert set(last.stats["seconds"]) >= {"sync", "bvh", "plan", "render"}
    assert not last.stopped
    assert all("\n" not in line for line in last.lines())
