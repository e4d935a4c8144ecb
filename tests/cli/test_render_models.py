# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`: camera models, and the options that set the lens up."""

from __future__ import annotations

import pytest

from support.render_commands import picture


@pytest.mark.once
def test_lenses_to_first_order(cli_renders):
    """Nothing is lost in them, and far from the corners their pictures are the lens's own, aberrations apart."""
    lens = ("--lens", "tessar-brendel", "--film", "6x4", "--f-number", 8, "--samples", 64)
    exact, *simpler = cli_renders(lens, (*lens, "--camera", "thick"), (*lens, "--camera", "paraxial"))
    assert exact.returncode == 0, exact.stderr
    for one in simpler:
        assert one.returncode == 0, one.stderr
        assert one.stats["camera_rays_lost"] == 0 and one.stats["lens"]
        # Noise alone: 64 samples of 48 x 32 pixels.
        assert abs(picture(one.out)[..., :3].mean() / picture(exact.out)[..., :3].mean() - 1.0) < 0.02


@pytest.mark.once
@pytest.mark.parametrize("film", [("--film", "18x12"), ("--film-diagonal", "21.6333")])
def test_film_of_a_camera_without_a_lens(cli_renders, film):
    """Half of the focal length before half of the film sees the same, ray by ray."""
    whole, half = cli_renders(
        ("--camera", "pinhole", "--focal-length", 40, "--film", "36x24", "--samples", 4),
        ("--camera", "pinhole", "--focal-length", 20, *film, "--samples", 4),
    )
    assert whole.returncode == half.returncode == 0, whole.stderr + half.stderr
    # A diagonal is told to six digits.
    assert (abs(picture(whole.out) - picture(half.out)) < 1e-3).mean() > 0.999


@pytest.mark.once
def test_a_lens_as_a_table(cli_renders):
    """Sample by sample the picture of the lens itself, at the table's wavelength."""
    lens = ("--lens", "tessar-brendel", "--film", "60x40", "--tilt", 3, "--samples", 16)
    for effect in ("lateral_colour", "transmission", "ghosts", "glare", "diffraction"):  # what the table has not
        lens = (*lens, "--effect", f"{effect}=off")
    of_table, of_lens = cli_renders((*lens, "--camera", "image-based"), lens)
    for one in (of_table, of_lens):
        assert one.returncode == 0, one.stderr
    assert of_table.stats["lens"]
    table, exact = (picture(one.out)[..., :3] for one in (of_table, of_lens))
    # The same random numbers, rays within hundredths of a pixel: only where one meets an edge a path may part.
    assert abs(table.mean() / exact.mean() - 1.0) < 2e-3
    assert (abs(table - exact) < 0.02 * exact.max()).mean() > 0.99
    lost = of_table.stats["camera_rays_lost"] - of_lens.stats["camera_rays_lost"]
    assert abs(lost) < 1e-3 * of_table.stats["camera_rays"]


@pytest.mark.once
def test_light_paths(blender, cli_renders):
    lens = ("--lens", "cooke-triplet-50mm", "--samples", 64)
    one, two, plain = cli_renders(lens, (*lens, "--integrator", "bdpt"), (*lens, "--light-tracing", "off"))
    assert one.returncode == 0 and one.stats["integrator"] == "path"
    assert two.returncode == 0 and two.stats["integrator"] == "bdpt"
    assert plain.returncode == 0 and plain.stats["light_tracing"]["aimed"] == 0
    # Two ways to one picture: means of thousands of pixels, with the noise of a few hundredths in each.
    assert picture(two.out)[..., :3].mean() == pytest.approx(picture(one.out)[..., :3].mean(), rel=0.02)


CHANGES = {
    "focal length": ("--focal-length", 30),
    "f-number": ("--f-number", 16),
    "focus": ("--focus-distance", 700),
    "infinity": ("--focus-distance", "inf"),
    "film": ("--film", "24x16"),
    "film format": ("--film", "aps-c"),
    "film diagonal": ("--film-diagonal", 30),
    "blades": ("--f-number", 8, "--blades", 3, "--blade-curvature", 0.5, "--blade-rotation", 20),
    "tilt": ("--tilt", 12),
    "swing": ("--swing", -12),
    "shift": ("--shift", "2,-3"),
    "scale": ("--scale", "100,100,100"),
    # So small a picture does not call for it.
    "all wavelengths": ("--effect", "lateral_colour=on"),
    "no vignetting": ("--effect", "vignetting=off"),
    "no distortion": ("--effect", "distortion=off"),
    "no aberrations": ("--effect", "aberration=off"),
    "no blur": ("--effect", "defocus=off"),
    "another lens": ("--lens", "tessar-brendel"),
    "pinhole": ("--camera", "pinhole"),
    "thin": ("--camera", "thin", "--f-number", 0.1),
}


@pytest.mark.once
def test_options_reach_the_lens(blender, cli_renders):
    commands = [("--lens", "cooke-triplet-50mm")]
    for options in CHANGES.values():
        commands.append(options if {"--lens", "--camera"} & set(options) else (*commands[0], *options))
    plain, *changed = cli_renders(*((*options, "--samples", 2) for options in commands))
    assert plain.returncode == 0, plain.stderr
    for what, one in zip(CHANGES, changed, strict=True):
        assert one.returncode == 0, f"{what}: {one.stderr}"
        assert abs(picture(one.out) - picture(plain.out)).mean() > 1e-4, what
        assert one.stats["non_finite_samples"] == 0


@pytest.mark.once
def test_a_mask_from_a_file_shapes_the_blur(blender, cli_renders, tmp_path):
    names = ("left", "right", "open")
    for name, column in zip(names, (0, 1, None), strict=True):
        image = blender.data.images.new(name, 2, 2)
        pixels = [[float(column in (None, i % 2))] * 3 + [1.0] for i in range(4)]
        image.pixels.foreach_set([number for pixel in pixels for number in pixel])
        image.filepath_raw, image.file_format = str(tmp_path / f"{name}.png"), "PNG"
        image.save()
    # From the scene the entrance pupil is aimed at, and the mask met on the way back.
    pipelines = ("film", "scene", "hero")
    # The middles are 0.508 pixels apart: of 64 samples they have a noise of 0.013, of 256 one of 0.006.
    lens = ("--lens", "cooke-triplet-50mm", "--focus-distance", 600, "--samples", 256, "--aperture-mask")
    done = cli_renders(
        *((*lens, tmp_path / f"{name}.png") for name in names),
        *((*lens, tmp_path / "right.png", "--pipeline", pipeline) for pipeline in pipelines),
    )
    for one in done:
        assert one.returncode == 0, one.stderr
    found = [picture(one.out)[..., 0] for one in done]
    masks = dict(zip(names, found, strict=False))

    def middle(found):
        return (found.sum(axis=0) * range(found.shape[1])).sum() / found.sum()

    # The square lies behind what is sharp: seen from further right it stands further right against it. The two halves
    # are as bright as the whole, which is their mean.
    assert middle(masks["right"]) - middle(masks["left"]) > 0.5
    mean = (masks["left"] + masks["right"]) / 2
    assert abs(mean - masks["open"]).mean() < 0.05 * masks["open"].mean()
    for pipeline, one in zip(pipelines, found[3:], strict=True):
        assert one.sum() == pytest.approx(masks["right"].sum(), rel=0.02), pipeline
        assert middle(one) == pytest.approx(middle(masks["right"]), abs=0.2), pipeline


@pytest.mark.once
def test_without_lens_or_camera_the_file_decides(blender, cli_render):
    # The scene was saved with a pinhole.
    done, _, stats = cli_render("--samples", 1)
    assert done.returncode == 0 and stats["lens"] == "pinhole"


@pytest.mark.once
def test_precision(cli_renders):
    """Chosen by what it changes; the other one is as good as the same picture."""
    lens = ("--lens", "tessar-brendel", "--film", "60x40", "--samples", 16)
    ways = (((), "f32"), (("--precision", "f64"), "f64"), (("--precision", "f32"), "f32"))
    *done, pinhole = cli_renders(*((*lens, *asked) for asked, _ in ways), ("--camera", "pinhole", "--samples", 1))
    for one, (asked, chosen) in zip(done, ways, strict=True):
        assert one.returncode == 0, one.stderr
        precision = one.stats["precision"]
        assert (precision["asked"], precision["chosen"]) == (asked[1] if asked else "auto", chosen)
        # 48 x 32 pixels: far fewer than single precision tells apart.
        assert 0.0 < precision["f32_error_px"] < 1e-3 and precision["tolerance_px"] == 0.01
    auto, double, single = (picture(one.out)[..., :3] for one in done)
    assert (auto == single).all() and (auto != double).any()
    # The same random numbers, rays within thousandths of a pixel: only where one meets an edge a path may part.
    assert abs(auto.mean() / double.mean() - 1.0) < 1e-3
    assert (abs(auto - double) < 0.01 * double.max()).mean() > 0.99
    assert pinhole.returncode == 0 and pinhole.stats["precision"] is None
