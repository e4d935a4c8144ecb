# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising by Open Image Denoise, as Blender ships it: held against converged pictures."""

from __future__ import annotations

import numpy as np
import pytest

from support import multilayer

WIDTH, HEIGHT = 96, 64


@pytest.fixture
def room(parts, blender):
    """A box lit by one small lamp: noisy at few samples."""
    scene = parts.set_up(WIDTH, HEIGHT, samples=4)
    scene.world = parts.grey_world(0.02)
    blender.ops.mesh.primitive_cube_add(size=8.0, location=(0.0, 3.0, 0.0))
    blender.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0.3, 3.5, -0.6))
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "AREA"))
    lamp.data.energy, lamp.data.size = 60.0, 0.3
    lamp.location = (0.8, 3.0, 1.8)
    scene.collection.objects.link(lamp)
    return scene


def picture(parts, scene, folder, name, *, samples: int, denoise: bool, **cycles) -> np.ndarray:
    scene.petzval.samples, scene.cycles.use_denoising = samples, denoise
    for key, value in cycles.items():
        setattr(scene.cycles, key, value)
    return parts.render(folder, f"{name}.exr")[..., :3]


def error(ours: np.ndarray, truth: np.ndarray) -> float:
    """Relative mean square error, the brightest hundredth of the pixels left out: noise of few samples has outliers."""
    each = ((ours - truth) ** 2 / (truth**2 + 0.01 * truth.mean() ** 2)).mean(axis=-1)
    return float(np.sort(each.ravel())[: int(0.99 * each.size)].mean())


@pytest.mark.parametrize("model", ["PINHOLE", "LENS"])
def test_a_denoised_picture_is_nearer_the_truth(parts, room, tmp_path, model):
    room.camera.data.petzval.model = model
    truth = picture(parts, room, tmp_path, "truth", samples=1024, denoise=False)
    noisy = picture(parts, room, tmp_path, "noisy", samples=4, denoise=False)
    clean = picture(parts, room, tmp_path, "clean", samples=4, denoise=True)
    # Four samples as good as sixteen at least; measured, it is more.
    assert error(clean, truth) < 0.25 * error(noisy, truth)
    assert abs(clean.mean() / truth.mean() - 1.0) < 0.05


@pytest.fixture
def board(parts, blender):
    """A board of squares of half a pixel and larger under a sun: fine detail, and little noise."""
    scene = parts.set_up(WIDTH, HEIGHT, samples=64)
    scene.world = parts.grey_world(0.1)
    blender.ops.mesh.primitive_plane_add(size=60.0, location=(0.0, 20.0, -1.0))
    material = blender.data.materials.new("Squares")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    squares = nodes.new("ShaderNodeTexChecker")
    squares.inputs["Scale"].default_value = 9.0
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Position"], squares.inputs["Vector"])
    links.new(squares.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    blender.context.object.data.materials.append(material)
    sun = blender.data.objects.new("Sun", blender.data.lights.new("Sun", "SUN"))
    sun.rotation_euler = (0.5, 0.2, 0.0)
    scene.collection.objects.link(sun)
    return scene


@pytest.mark.parametrize("model", ["PINHOLE", "LENS"])
@pytest.mark.parametrize("threshold", [0.0, 0.02])
def test_detail_is_kept_where_there_is_little_noise(parts, board, tmp_path, model, threshold):
    """Denoised alone, without what is taken back from the noisy picture, its error would be 0.9 to 2.8 times that of noise."""
    board.camera.data.petzval.model = model
    board.petzval.seed = 1
    truth = picture(parts, board, tmp_path, "truth", samples=1024, denoise=False)
    board.petzval.seed = 0
    board.petzval.use_noise_threshold, board.petzval.noise_threshold = threshold > 0.0, threshold or 0.1
    noisy = picture(parts, board, tmp_path, "noisy", samples=256, denoise=False)
    clean = picture(parts, board, tmp_path, "clean", samples=256, denoise=True)
    assert error(clean, truth) < 0.8 * error(noisy, truth)


def adaptive(parts, scene, folder, name, threshold: float, **own) -> tuple[np.ndarray, float]:
    """A picture of at most 512 samples by a noise threshold, and its mean samples a pixel."""
    scene.petzval.use_noise_threshold, scene.petzval.noise_threshold = True, threshold
    for key, value in own.items():
        setattr(scene.petzval, key, value)
    found = picture(parts, scene, folder, name, samples=512, denoise=True)
    return found, parts.part("render.statistics").last(scene.name).stats["samples_mean"]


def told_error(ours: np.ndarray, truth: np.ndarray) -> float:
    """What a noise threshold is for: the error relative to the square root of brightness where that is below 1, without the worst hundredth."""
    bright = truth.sum(axis=-1)
    squares = 3.0 * ((ours - truth) ** 2).sum(axis=-1) / np.maximum(np.maximum(bright, bright**2), 0.003)
    return float(np.sqrt(np.sort(squares.ravel())[: int(0.99 * squares.size)].mean()))


@pytest.mark.parametrize("model", ["PINHOLE", "LENS"])
def test_a_noise_threshold_is_for_what_denoising_leaves(parts, room, tmp_path, model):
    room.camera.data.petzval.model, threshold = model, 0.03
    room.petzval.seed = 1
    truth = picture(parts, room, tmp_path, "truth", samples=1024, denoise=False)
    room.petzval.seed = 0
    by_samples, many = adaptive(parts, room, tmp_path, "samples", threshold, use_threshold_after_denoising=False)
    by_picture, few = adaptive(parts, room, tmp_path, "picture", threshold, use_threshold_after_denoising=True)
    assert few < 0.5 * many
    # The forecast of a block is right to about a third.
    assert told_error(by_samples, truth) < told_error(by_picture, truth) < 1.3 * threshold
    # It is not the noise that keeps the threshold.
    room.petzval.use_noise_threshold = False
    noisy = picture(parts, room, tmp_path, "noisy", samples=int(few), denoise=False)
    assert told_error(noisy, truth) > 1.5 * threshold


@pytest.mark.once
def test_samples_by_what_denoising_leaves_are_the_same_on_any_number_of_threads(parts, room, tmp_path):
    room.render.threads_mode, found = "FIXED", []
    for threads in (1, 3):
        room.render.threads = threads
        found.append(adaptive(parts, room, tmp_path, f"{threads}", 0.05)[0])
    assert np.array_equal(*found)


@pytest.mark.once
def test_where_nothing_can_be_denoised_the_threshold_is_for_the_noise(parts, room, tmp_path, monkeypatch):
    by_samples = adaptive(parts, room, tmp_path, "samples", 0.1, use_threshold_after_denoising=False)[1]
    no_library = tmp_path / "none.so"
    no_library.write_text("no library")
    monkeypatch.setattr(parts.part("data.denoiser"), "library", lambda: no_library)
    assert adaptive(parts, room, tmp_path, "broken", 0.1, use_threshold_after_denoising=True)[1] == by_samples


#: As the wheels of bpy 5.2.3 from PyPI have it, and Blender for Windows.
LAYOUTS = (
    ("linux", "bpy/lib/libOpenImageDenoise.so.2", "bpy/5.2"),
    ("win32", "bpy/OpenImageDenoise.dll", "bpy/5.2"),
    ("win32", "Blender 5.2/blender.shared/OpenImageDenoise.dll", "Blender 5.2/5.2"),
    ("darwin", "bpy/lib/libOpenImageDenoise.dylib", "bpy/5.2"),
    ("darwin", "Blender.app/Contents/Resources/lib/libOpenImageDenoise.dylib", "Blender.app/Contents/Resources/5.2"),
)


@pytest.mark.once
@pytest.mark.parametrize(("system", "library", "scripts"), LAYOUTS)
def test_blenders_own_library_is_found_on_every_system(parts, blender, tmp_path, monkeypatch, system, library, scripts):
    denoiser, file = parts.part("data.denoiser"), tmp_path / library
    file.parent.mkdir(parents=True)
    file.write_text("")
    monkeypatch.setattr("petzval.denoiser_library.sys.platform", system)
    monkeypatch.setattr(denoiser, "_local", lambda: str(tmp_path / scripts))
    denoiser.library.cache_clear()
    try:
        assert denoiser.library() == file
    finally:
        denoiser.library.cache_clear()


@pytest.mark.once
def test_qualities_prefilters_and_guides_are_cycles_own(parts, room, tmp_path):
    noisy = picture(parts, room, tmp_path, "noisy", samples=4, denoise=False)
    seen = [noisy]
    for name, change in (
        ("usual", {}),
        ("no guides", {"denoising_input_passes": "RGB"}),
        ("by albedo", {"denoising_input_passes": "RGB_ALBEDO"}),
        ("fast prefilter", {"denoising_input_passes": "RGB_ALBEDO_NORMAL", "denoising_prefilter": "FAST"}),
        ("no prefilter", {"denoising_prefilter": "NONE"}),
        ("balanced", {"denoising_prefilter": "ACCURATE", "denoising_quality": "BALANCED"}),
    ):
        seen.append(picture(parts, room, tmp_path, name, samples=4, denoise=True, **change))
        assert all(not np.array_equal(seen[-1], before) for before in seen[:-1]), name


@pytest.mark.once
def test_at_high_quality_what_is_turned_round_is_denoised_alike(parts, blender, tmp_path):
    """Each pixel of a picture without any randomness is one of an image's, which is then turned by 180 degrees."""
    scene = parts.set_up(WIDTH, HEIGHT, samples=1)
    scene.camera.data.petzval.model, scene.petzval.filter_width = "PINHOLE", 0.0
    scene.world = blender.data.worlds.new("Image")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    shown, place = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeTexCoord")
    shown.interpolation = "Closest"
    links.new(place.outputs["Window"], shown.inputs["Vector"])
    links.new(shown.outputs["Color"], nodes["Background"].inputs["Color"])
    light = np.random.default_rng(1).uniform(0.1, 1.0, (HEIGHT, WIDTH, 4)).astype(np.float32)
    differ = {}
    for quality in ("HIGH", "BALANCED"):
        found = []
        for name, pixels in (("upright", light), ("turned", light[::-1, ::-1])):
            shown.image = blender.data.images.new(name, WIDTH, HEIGHT, float_buffer=True)
            shown.image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
            how = {"denoising_quality": quality, "denoising_input_passes": "RGB"}
            found.append(picture(parts, scene, tmp_path, f"{quality} {name}", samples=1, denoise=True, **how))
        assert abs(found[0] - light[..., :3]).mean() > 0.05, "nothing is denoised"
        differ[quality] = abs(found[0] - found[1][::-1, ::-1]).max()
    assert differ["HIGH"] < 1e-5 < 1e-3 < differ["BALANCED"]


@pytest.mark.once
def test_the_same_seed_gives_the_same_bits_on_any_number_of_threads(parts, room, tmp_path):
    room.render.threads_mode, found = "FIXED", []
    for threads in (1, 2, 3):
        room.render.threads = threads
        found.append(picture(parts, room, tmp_path, f"{threads}", samples=4, denoise=True))
    assert np.array_equal(found[0], found[1]) and np.array_equal(found[0], found[2])


@pytest.mark.once
def test_bidirectional_paths_are_denoised_without_guides(parts, room, tmp_path):
    room.petzval.integrator, room.camera.data.petzval.model = "BIDIRECTIONAL", "LENS"
    truth = picture(parts, room, tmp_path, "truth", samples=512, denoise=False)
    noisy = picture(parts, room, tmp_path, "noisy", samples=4, denoise=False)
    clean = picture(parts, room, tmp_path, "clean", samples=4, denoise=True)
    assert error(clean, truth) < 0.5 * error(noisy, truth)


@pytest.mark.once
def test_the_forecast_has_the_time_of_denoising(parts, room, tmp_path):
    """By the last picture's, so that it is that of this machine; a third is what times of half a second differ by on a busy one, where it
    does not begin or end something else meanwhile: then the next picture tells."""
    room.render.resolution_x, room.render.resolution_y = 480, 320
    said = []
    for name in ("first", "second", "third", "fourth"):
        picture(parts, room, tmp_path, name, samples=16, denoise=True)
        stats = parts.part("render.statistics").last(room.name).stats
        said.append((stats["planned"]["predicted"]["after_seconds"], stats["seconds"]["denoise"]))
        if len(said) > 1:
            assert said[-1][0] == pytest.approx(said[-2][1], rel=0.05)
            if said[-1][1] == pytest.approx(said[-2][1], rel=0.33):
                break
    assert said[-1][1] == pytest.approx(said[-2][1], rel=0.33), said


@pytest.mark.once
def test_a_layer_that_is_not_to_be_denoised_is_not(parts, blender, room, tmp_path):
    noisy = picture(parts, room, tmp_path, "noisy", samples=4, denoise=False)
    blender.context.view_layer.cycles.use_denoising = False
    assert np.array_equal(picture(parts, room, tmp_path, "layer", samples=4, denoise=True), noisy)


@pytest.mark.once
@pytest.mark.parametrize("size", [(4, 4), (7, 5)])
def test_small_pictures(parts, room, tmp_path, size):
    # Blender has no smaller ones.
    room.render.resolution_x, room.render.resolution_y = size
    found = picture(parts, room, tmp_path, "small", samples=4, denoise=True)
    assert found.shape[:2] == size[::-1] and np.isfinite(found).all() and found.max() > 0.0


@pytest.mark.once
def test_a_part_of_a_picture_is_denoised_without_its_black_outside(parts, room, tmp_path):
    render = room.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.25, 0.75
    noisy = picture(parts, room, tmp_path, "noisy", samples=64, denoise=False)
    clean = picture(parts, room, tmp_path, "clean", samples=64, denoise=True)
    edge = np.ones(clean.shape[:2], bool)
    edge[1:-1, 1:-1] = False
    assert abs(clean[edge].mean() / noisy[edge].mean() - 1.0) < 0.05


@pytest.mark.once
def test_one_pixel(parts, room, tmp_path):
    render = room.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x = 10.1 / WIDTH, 11.1 / WIDTH
    render.border_min_y, render.border_max_y = 10.1 / HEIGHT, 11.1 / HEIGHT
    found = picture(parts, room, tmp_path, "pixel", samples=64, denoise=True)
    assert found.shape[:2] == (1, 1) and np.isfinite(found).all() and found.max() > 0.0


@pytest.mark.once
def test_passes_keep_both_pictures(parts, blender, room, tmp_path):
    """Named as Cycles names them; the noisy picture is that of the samples, to the bit."""
    blender.context.view_layer.cycles.denoising_store_passes = True
    noisy, _ = multilayer.photograph(parts, room, tmp_path / "noisy.exr", samples=4)
    both, _ = multilayer.photograph(parts, room, tmp_path / "both.exr", samples=4, denoise=True)
    cycles, _ = multilayer.photograph(parts, room, tmp_path / "cycles.exr", "CYCLES", samples=1, denoise=True)
    added = {name for name in both if name not in noisy}
    assert added == {f"noisy image.{channel}" for channel in "rgba"} and added <= cycles.keys()
    for channel in "rgba":
        assert np.array_equal(both[f"noisy image.{channel}"], noisy[f"combined.{channel}"])
    assert not np.array_equal(both["combined.r"], noisy["combined.r"])
    for name in ("denoising albedo.r", "denoising normal.x", "denoising depth.z"):
        assert np.array_equal(both[name], noisy[name])


@pytest.mark.once
@pytest.mark.parametrize("is_transparent", [True, False])
def test_a_caught_shadow_is_denoised(parts, room, tmp_path, is_transparent):
    room.objects["Cube"].is_shadow_catcher = True
    room.render.film_transparent = is_transparent

    def taken(name: str, samples: int, *, denoise: bool) -> np.ndarray:
        found, _ = multilayer.photograph(parts, room, tmp_path / f"{name}.exr", samples=samples, denoise=denoise)
        if denoise:
            noisy = multilayer.photograph(parts, room, tmp_path / f"{name}2.exr", samples=samples)[0]
            assert np.array_equal(found["noisy image.a"], noisy["combined.a"])
            assert np.array_equal(found["noisy image.r"], noisy["combined.r"])
        return found["combined.a" if is_transparent else "combined.r"]

    truth = taken("truth", 1024, denoise=False)
    noisy, clean = taken("noisy", 4, denoise=False), taken("clean", 4, denoise=True)
    error = [float(((one - truth) ** 2).mean()) for one in (noisy, clean)]
    assert error[1] < 0.5 * error[0], error


@pytest.mark.once
@pytest.mark.parametrize("library", [None, "/no/such/library.so", __file__])
def test_without_the_library_the_picture_is_there_and_it_is_said(parts, room, tmp_path, monkeypatch, library, capfd):
    noisy = picture(parts, room, tmp_path, "noisy", samples=4, denoise=False)
    monkeypatch.setattr(parts.part("data.denoiser"), "library", lambda: library)
    assert np.array_equal(picture(parts, room, tmp_path, "same", samples=4, denoise=True), noisy)
    said = capfd.readouterr().out
    assert "Not denoised: " in said and ("pip install pyoidn" in said if library is None else str(library) in said)
