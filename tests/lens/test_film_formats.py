# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of film formats against the films that carry them, and how a format reaches the camera."""

from __future__ import annotations

import argparse
from math import hypot

import pytest

from petzval import film_formats, render_command

NAMES = [film.name for film in film_formats.FILM_FORMATS]

#: Film width and frame pitch (mm, perforations times their distance) along the sides of the frame, wider side first:
#: ISO 1700 (Super 8), ISO 69 (16 mm), ISO 491 (35 mm), ISO 3023 (65 mm), ISO 1007 (135), ISO 732 (120), and cut sheets.
ROOM = {
    "super8": (8.0, 4.234),
    "16mm": (16.0, 7.62),
    "super16": (16.0, 7.62),
    "academy35": (35.0, 4 * 4.75),
    "super35": (35.0, 4 * 4.75),
    "vistavision": (8 * 4.75, 35.0),
    "65mm": (65.0, 5 * 4.75),
    "imax": (15 * 4.75, 65.0),
    "full-frame": (8 * 4.75, 35.0),
    "half-frame": (35.0, 4 * 4.75),
    "645": (61.5, 45.0),
    "6x6cm": (61.5, 61.5),
    "6x7cm": (75.0, 61.5),
    "6x8cm": (80.0, 61.5),
    "6x9cm": (90.0, 61.5),
    "6x17cm": (175.0, 61.5),
    "4x5in": (127.0, 101.6),
    "5x7in": (177.8, 127.0),
    "8x10in": (254.0, 203.2),
}


@pytest.mark.once
@pytest.mark.parametrize("name", ROOM)
def test_a_frame_fits_its_film(name):
    film = film_formats.by_name(name)
    # Never larger, and not so small that another format is meant: sound track and perforations take up to a third.
    for side, room in zip((film.width_mm, film.height_mm), ROOM[name], strict=True):
        assert 0.6 * room < side < room


@pytest.mark.once
def test_inches_in_the_source_are_the_millimetres_of_the_table():
    checked = 0
    for film in film_formats.FILM_FORMATS:
        if not film.source.endswith(" in"):
            continue
        width, height = film.source.removesuffix(" in").split(", ")[-1].split(" x ")
        # Inches are given to a thousandth.
        for inches, mm in ((width, film.width_mm), (height, film.height_mm)):
            assert float(inches) * 25.4 == pytest.approx(mm, abs=0.018), film.name
        checked += 1
    assert checked > 5


@pytest.mark.once
def test_diagonals_in_the_source_are_those_of_the_table():
    checked = 0
    for film in film_formats.FILM_FORMATS:
        if "diagonal" in film.source:
            # Given to a millimetre.
            assert hypot(film.width_mm, film.height_mm) == pytest.approx(float(film.source.split()[-2]), abs=0.6)
            checked += 1
    assert checked == 3


@pytest.mark.once
def test_names_and_sizes_lead_back_to_the_format():
    assert len(set(NAMES)) == len(NAMES)
    for film in film_formats.FILM_FORMATS:
        assert film.width_mm >= film.height_mm
        assert film_formats.by_name(film.name.upper()) is film
        assert film_formats.of_size(film.width_mm, film.height_mm) is film
    assert film_formats.by_name("no-such") is None and film_formats.of_size(36.0, 24.1) is None


@pytest.mark.once
def test_a_diagonal_keeps_the_shape():
    width, height = film_formats.with_diagonal(4.0, 3.0, 10.0)
    assert (width, height) == pytest.approx((8.0, 6.0))
    assert hypot(*film_formats.with_diagonal(16.0, 9.0, 43.27)) == pytest.approx(43.27)


def arguments(*words):
    parser = argparse.ArgumentParser()
    render_command.add_parser(parser.add_subparsers())
    return parser.parse_args(["render", "SCENE.blend", *words])


@pytest.mark.once
def test_the_command_takes_names_and_sizes():
    assert arguments("--film", "Super8").film == [6.22, 4.22]
    assert arguments("--film", "6x7cm").film == [69.5, 56.0]
    assert arguments("--film", "60x70").film == [60.0, 70.0]
    # Without a unit it is mm, though there is a film of that name in cm.
    assert arguments("--film", "6x7").film == [6.0, 7.0]
    assert arguments("--film-diagonal", "30").film_diagonal == 30.0
