# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`: camera models, and the options that set the lens up."""

from __future__ import annotations

import pytest

from cli_render_parts import picture


@pytest.mark.parametrize("model", ["thick", "paraxial"])
def test_a_lens_to_first_order(cli_render, model):
    """Nothing is lost in it, and far from the corners its picture is the lens's own, aberrations apart."""
    lens = ("--lens", "tessar-brendel", "--film", "6x4", "--f-number", 8, "--samples", 64)
    done, out, stats = cli_render(*lens, "--camera", model)
    assert done.returncode == 0, done.stderr
    assert stats["camera_rays_lost"] == 0 and stats["lens"]
    done, exact, _ = cli_render(*lens, name="exact.exr")
    assert done.returncode == 0, done.stderr
    first_order, exact = picture(out)[..., :3], picture(exact)[..., :3]
    # Noise alone: 64 samples of 48 x 32 pixels.
    assert abs(first_order.mean() / exact.mean() - 1.0) < 0.02


def test_a_lens_as_a_table(cli_render):
    """Sample by sample the picture of the lens itself, at the table's wavelength."""
    lens = (
        "--lens",
        "tessar-brendel",
        "--film",
        "60x40",
        "--tilt",
        3,
        "--samples",
        16,
        "--effect",
        "lateral_colour=off",
    )
    done, out, stats = cli_render(*lens, "--camera", "image-based")
    assert done.returncode == 0, done.stderr
    assert stats["lens"]
    done, exact, of_lens = cli_render(*lens, name="exact.exr")
    assert done.returncode == 0, done.stderr
    table, exact = picture(out)[..., :3], picture(exact)[..., :3]
    # The same random numbers, rays within hundredths of a pixel: only where one meets an edge a path may part.
    assert abs(table.mean() / exact.mean() - 1.0) < 2e-3
    assert (abs(table - exact) < 0.02 * exact.max()).mean() > 0.99
    assert abs(stats["camera_rays_lost"] - of_lens["camera_rays_lost"]) < 1e-3 * stats["camera_rays"]


@pytest.mark.once
def test_light_paths(blender, cli_render):
    lens = ("--lens", "cooke-triplet-50mm", "--samples", 64)
    done, one, stats = cli_render(*lens)
    assert done.returncode == 0 and stats["integrator"] == "path"
    done, two, stats = cli_render(*lens, "--integrator", "bdpt", name="both.exr")
    assert done.returncode == 0 and stats["integrator"] == "bdpt"
    # Two ways to one picture: means of thousands of pixels, with the noise of a few hundredths in each.
    assert picture(two)[..., :3].mean() == pytest.approx(picture(one)[..., :3].mean(), rel=0.02)


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


@pytest.fixture
def plain(blender, cli_render):
    """What the changes are seen against."""
    return picture(cli_render("--lens", "cooke-triplet-50mm", "--samples", 2, name="plain.exr")[1])


@pytest.mark.once
@pytest.mark.slow
def test_options_reach_the_lens(plain, cli_render):
    for what, options in CHANGES.items():
        lens = () if {"--lens", "--camera"} & set(options) else ("--lens", "cooke-triplet-50mm")
        done, out, stats = cli_render(*lens, *options, "--samples", 2)
        assert done.returncode == 0, f"{what}: {done.stderr}"
        assert abs(picture(out) - plain).mean() > 1e-4, what
        assert stats["non_finite_samples"] == 0


def test_a_mask_from_a_file_shapes_the_blur(blender, cli_render, plain, tmp_path):
    masks = {}
    for name, column in (("left", 0), ("right", 1), ("open", None)):
        image = blender.data.images.new(name, 2, 2)
        pixels = [[float(column in (None, i % 2))] * 3 + [1.0] for i in range(4)]
        image.pixels.foreach_set([number for pixel in pixels for number in pixel])
        image.filepath_raw, image.file_format = str(tmp_path / f"{name}.png"), "PNG"
        image.save()
        done, out, _ = cli_render(
            "--lens", "cooke-triplet-50mm", "--focus-distance", 600, "--samples", 64, "--aperture-mask",
            tmp_path / f"{name}.png", name=f"{name}.exr",
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        masks[name] = picture(out)[..., 0]

    def middle(found):
        return (found.sum(axis=0) * range(found.shape[1])).sum() / found.sum()

    # The square lies behind what is sharp: seen from further right it stands further right against it. The two halves
    # are as bright as the whole, which is their mean.
    assert middle(masks["right"]) - middle(masks["left"]) > 0.5
    mean = (masks["left"] + masks["right"]) / 2
    assert abs(mean - masks["open"]).mean() < 0.05 * masks["open"].mean()
    # From the scene the entrance pupil is aimed at, and the mask met on the way back.
    for pipeline in ("film", "scene", "hero"):
        done, out, _ = cli_render(
            "--lens", "cooke-triplet-50mm", "--focus-distance", 600, "--samples", 64, "--aperture-mask",
            tmp_path / "right.png", "--pipeline", pipeline, name=f"{pipeline}.exr",
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        found = picture(out)[..., 0]
        assert found.sum() == pytest.approx(masks["right"].sum(), rel=0.02), pipeline
        assert middle(found) == pytest.approx(middle(masks["right"]), abs=0.2), pipeline


def test_without_lens_or_camera_the_file_decides(blender, cli_render):
    # The scene was saved with a pinhole.
    done, _, stats = cli_render("--samples", 1)
    assert done.returncode == 0 and stats["lens"] == "pinhole"


@pytest.mark.once
def test_precision(cli_render):
    """Chosen by what it changes; the other one is as good as the same picture."""
    lens = ("--lens", "tessar-brendel", "--film", "60x40", "--samples", 16)
    pictures = {}
    for asked, chosen in ((), "f32"), (("--precision", "f64"), "f64"), (("--precision", "f32"), "f32"):
        done, out, stats = cli_render(*lens, *asked, name=f"{len(pictures)}.exr")
        assert done.returncode == 0, done.stderr
        precision = stats["precision"]
        assert (precision["asked"], precision["chosen"]) == (asked[1] if asked else "auto", chosen)
        # 48 x 32 pixels: far fewer than single precision tells apart.
        assert 0.0 < precision["f32_error_px"] < 1e-3 and precision["tolerance_px"] == 0.01
        pictures[asked] = picture(out)[..., :3]
    auto, double, single = pictures.values()
    assert (auto == single).all() and (auto != double).any()
    # The same random numbers, rays within thousandths of a pixel: only where one meets an edge a path may part.
    assert abs(auto.mean() / double.mean() - 1.0) < 1e-3
    assert (abs(auto - double) < 0.01 * double.max()).mean() > 0.99
    done, _, stats = cli_render("--camera", "pinhole", "--samples", 1)
    assert done.returncode == 0 and stats["precision"] is None
