# SPDX-License-Identifier: GPL-3.0-or-later
"""A uniform world of radiance one: the whole path from the pupil map to the film's exposure, with a known answer.

On the axis the answer is one, by the definition of brightness; away from it, what brute force through the lens finds.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from petzval import lens_library
from support.photograph import chart, native, truth
from support.places import ROOT

LENSES = sorted((ROOT / "lenses").glob("*.lens"))
OPENINGS = {"wide open": {}, "f/8": {"f_number": 8.0}, "f/8, five blades": {"f_number": 8.0, "blades": 5}}
WIDTH, HEIGHT, SAMPLES = 6, 4, 256
#: The eye whose gradients take 20 s to be ready for any opening: the smallest one with blades stands for the others in `make test`.
SLOW = "eye-liou-brennan"
#: The number of the opening with blades.
BLADES = 1


def each_lens(number: int | None = None) -> list:
    """All lenses; those that `make test` leaves out are recipes. Test `number`, 0 to 2, of three tests of all lenses has every third one in
    `make test`; without a number it has all. The slow one has its turn with the blades alone."""

    def is_left_out(i: int, lens: Path) -> bool:
        if lens.stem == SLOW:
            return number != BLADES
        return number is not None and i % 3 != number

    recipe = pytest.mark.recipe
    return [pytest.param(lens, id=lens.stem, marks=[recipe] * is_left_out(i, lens)) for i, lens in enumerate(LENSES)]


def assert_white(picture: np.ndarray, tolerance: float) -> None:
    """Every channel's mean is one within `tolerance` and four standard errors of the picture's own noise."""
    pixels = picture.reshape(-1, 3)
    noise = pixels.std(axis=0) / np.sqrt(len(pixels))
    assert np.all(np.abs(pixels.mean(axis=0) - 1.0) < tolerance + 4.0 * noise), (pixels.mean(axis=0), noise)


def small_film(lens: Path) -> dict[str, float]:
    """A film of 1/500 of the focal length: over it nothing falls off by more than some 1e-5."""
    efl = abs(native.info(native.camera(lens, film_width_mm=1.0, film_height_mm=1.0), WIDTH, HEIGHT)["efl_mm"])
    return {"film_width_mm": efl / 500.0, "film_height_mm": efl / 500.0}


# The exposure of the axis is known to a millionth; a few samples in ten thousand fall between the steps of the pupil
# map's boundary: a thousandth is room enough, and far below what an eye or a histogram tells.
@pytest.mark.once
@pytest.mark.parametrize(
    ("lens", "opening"),
    [
        pytest.param(*lens.values, opening, id=f"{lens.id}-{opening}", marks=lens.marks)
        for opening, number in zip(OPENINGS, (None, 0, BLADES), strict=True)
        for lens in each_lens(number)
    ],
)
def test_white_is_one_on_the_axis_of_every_lens(lens, opening):
    camera = native.camera(lens, **small_film(lens), **OPENINGS[opening])
    assert_white(native.white_world(camera, WIDTH, HEIGHT, SAMPLES), 1e-3)


# By wavelength the weights of the samples differ by their colour, which are white only on average: that is the noise.
@pytest.mark.once
@pytest.mark.parametrize("lens", each_lens(2))
def test_white_is_white_on_the_axis_of_every_lens(lens):
    camera = native.camera(lens, **small_film(lens), wavelength_nm=None)
    assert_white(native.white_world(camera, WIDTH, HEIGHT, SAMPLES), 1e-3)


@pytest.mark.first_only("name")
@pytest.mark.parametrize("spectrum", ["SINGLE", "THREE", "VISIBLE"])
@pytest.mark.parametrize("name", ["wide-angle-smith-f3.4", "double-gauss-f2-tronnier"])
def test_white_is_one_in_blender(blender, tmp_path, name, spectrum):
    studio = chart.Studio(blender, tmp_path, (WIDTH, HEIGHT), samples=SAMPLES)
    studio.lens(name, (0.2, 0.2), None)
    studio.data.petzval.spectrum = spectrum
    studio.white_world()
    assert_white(studio.shoot(), 1e-3)


#: Lens, film (mm), f-number, blades: strong vignetting, a mirror lens with its obstruction, a fisheye.
OFF_AXIS = {
    "wide angle": ("wide-angle-smith-f3.4", (120.0, 80.0), None, 0),
    "wide angle, five blades": ("wide-angle-smith-f3.4", (120.0, 80.0), 4.5, 5),
    "double Gauss": ("double-gauss-f2-tronnier", (36.0, 24.0), None, 0),
    "mirror lens": ("reflex-nikkor-500-f8", (36.0, 24.0), None, 0),
    "fisheye": ("laikin-fisheye-170", (10.0, 10.0), None, 0),
}
COLUMNS, ROWS = 15, 11


@pytest.mark.once
@pytest.mark.parametrize("case", OFF_AXIS)
def test_vignetting_is_that_of_brute_force(case):
    name, film, f_number, blades = OFF_AXIS[case]
    lens = next(path for path in LENSES if path.stem == name)
    height_mm = min(film[1], film[0] * ROWS / COLUMNS)
    picture_mm = (height_mm * COLUMNS / ROWS, height_mm)
    camera = native.camera(
        lens, film_width_mm=picture_mm[0], film_height_mm=picture_mm[1], f_number=f_number, blades=blades
    )
    exact = truth.Camera(
        lens=lens,
        film_z_mm=native.info(camera, COLUMNS, ROWS)["film_z_mm"],
        picture_mm=picture_mm,
        pixels=(COLUMNS, ROWS),
        f_number=f_number,
        blades=blades,
    )
    picture = native.white_world(camera, COLUMNS, ROWS, 2048)[:, :, 1]
    # Four points with the spread of a pixel's filter.
    around = [(dx, dy) for dx in (-0.27, 0.27) for dy in (-0.27, 0.27)]
    axis = exact.exposure([(COLUMNS / 2.0 + dx, ROWS / 2.0 + dy) for dx, dy in around], fine=60)
    for column, row in ((COLUMNS // 2, ROWS // 2), (3, 6), (0, ROWS - 1)):
        expected = exact.exposure([(column + 0.5 + dx, row + 0.5 + dy) for dx, dy in around]) / axis
        # 2 / 40^1.5 / sqrt(4) = 0.4 % for brute force; the render's noise and the bend of the vignetting inside of a
        # pixel, each about 0.2 %.
        assert picture[row, column] == pytest.approx(expected, abs=0.01, rel=0.0), (column, row)


FIRST_CHOICE = [entry["id"] for entry in lens_library.entries() if entry["is_first_choice"]]


@pytest.mark.once
@pytest.mark.parametrize("focal_lengths", [None, 25.0], ids=["far", "near"])
@pytest.mark.parametrize("name", FIRST_CHOICE)
def test_no_corner_is_black_through_a_lens_of_the_first_choice(name, focal_lengths):
    lens = next(path for path in LENSES if path.stem == name)
    entry = next(entry for entry in lens_library.entries() if entry["id"] == name)
    width_mm, height_mm = entry["film_mm"]
    settings = {"film_width_mm": width_mm, "film_height_mm": height_mm}
    if focal_lengths is not None:
        settings["focus_distance"] = focal_lengths * entry["focal_length_mm"] / 1000.0
    columns, rows = 9, round(9 * height_mm / width_mm)
    picture = native.white_world(native.camera(lens, **settings), columns, rows, 64)[:, :, 1]
    # Pixels of the corner lie a little inside of it, where the optics' own tests ask for a tenth.
    assert picture.min() > 0.1, picture
    # No lens of glass gathers more off the axis than on it; 64 samples leave a noise of 3 %.
    assert picture.max() < 1.1, picture
