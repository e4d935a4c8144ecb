# SPDX-License-Identifier: GPL-3.0-or-later
"""Real films and sensors: the image area that a camera exposes, in mm, the wider side first.

Of cinema film it is the camera's aperture by the SMPTE standard of its gauge, not the smaller part that is projected; of
roll film what the named camera leaves free, which differs by a millimetre or two between makers; of sheet film what
remains of the sheet in its holder, as lens makers count it for the diagonal that a lens has to cover; of sensors what
the maker publishes of the named camera.

A second published table confirms the sizes, but for aps-c, 44x33, 6x7cm, 5x7in, 8x10in and VistaVision's height, and for the
sides of 4x5in, of which it gives the diagonal alone. Two tables differ where they mean different things: Super 8's 5.79 x
4.01 mm, for one, is near the projected size.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot


@dataclass(frozen=True)
class FilmFormat:
    """One format."""

    name: str  # as the command line takes it
    title: str  # as the panel shows it
    width_mm: float
    height_mm: float
    source: str


FILM_FORMATS = (
    FilmFormat("super8", "Super 8", 6.22, 4.22, "SMPTE ST 157, 0.245 x 0.166 in"),
    FilmFormat("16mm", "16 mm", 10.26, 7.49, "SMPTE ST 7, 0.404 x 0.295 in"),
    FilmFormat("super16", "Super 16", 12.35, 7.42, "SMPTE ST 201, 0.486 x 0.292 in"),
    FilmFormat("micro-four-thirds", "Micro Four Thirds", 17.3, 13.0, "Four Thirds standard"),
    FilmFormat("academy35", "Academy 35 mm", 21.95, 16.0, "SMPTE ST 59, 0.864 x 0.630 in"),
    FilmFormat("aps-c-canon", "APS-C (Canon)", 22.3, 14.9, "Canon EOS 77D, specification"),
    FilmFormat("aps-c", "APS-C", 23.5, 15.6, "Fujifilm X-T3, Sony ILCE-6400, specifications"),
    FilmFormat("half-frame", "Half Frame", 24.0, 18.0, "ISO 1007, two frames for one"),
    FilmFormat("super35", "Super 35 (Full Aperture)", 24.89, 18.66, "SMPTE ST 59, 0.980 x 0.735 in"),
    FilmFormat("aps-h", "APS-H", 27.9, 18.6, "Canon EOS-1D Mark IV, specification"),
    FilmFormat("full-frame", "Full Frame (135)", 36.0, 24.0, "ISO 1007"),
    FilmFormat("vistavision", "VistaVision (35 mm, 8 Perforations)", 37.72, 24.92, "ASC manual, 1.485 x 0.981 in"),
    FilmFormat("digital-44x33", "Medium Format Sensor 44 x 33", 43.8, 32.9, "Fujifilm GFX, specification"),
    FilmFormat("65mm", "65 mm, 5 Perforations", 52.48, 23.01, "SMPTE ST 215, 2.066 x 0.906 in"),
    FilmFormat("imax", "IMAX (65 mm, 15 Perforations)", 70.41, 52.63, "ASC manual, 2.772 x 2.072 in"),
    FilmFormat("645", "6 x 4.5 cm", 56.0, 41.5, "ISO 732, Mamiya 645"),
    FilmFormat("6x6cm", "6 x 6 cm", 56.0, 56.0, "ISO 732"),
    FilmFormat("6x7cm", "6 x 7 cm", 69.5, 56.0, "Mamiya RB67, manual"),
    FilmFormat("6x8cm", "6 x 8 cm", 76.0, 56.0, "Fujifilm GX680, manual"),
    FilmFormat("6x9cm", "6 x 9 cm", 84.0, 56.0, "ISO 732"),
    FilmFormat("6x17cm", "6 x 17 cm", 168.0, 56.0, "Fujifilm GX617, manual"),
    FilmFormat("4x5in", "4 x 5 in", 120.0, 96.0, "Schneider-Kreuznach, diagonal 154 mm"),
    FilmFormat("5x7in", "5 x 7 in", 170.0, 120.0, "Schneider-Kreuznach, diagonal 208 mm"),
    FilmFormat("8x10in", "8 x 10 in", 245.0, 194.0, "Schneider-Kreuznach, diagonal 312 mm"),
)


def by_name(name: str) -> FilmFormat | None:
    """The format of that name, upper or lower case."""
    return next((film for film in FILM_FORMATS if film.name == name.strip().lower()), None)


def of_size(width_mm: float, height_mm: float) -> FilmFormat | None:
    """The format with these sides, to a hundredth of a millimetre."""
    sides = (width_mm, height_mm)
    return next(
        (film for film in FILM_FORMATS if max(abs(film.width_mm - sides[0]), abs(film.height_mm - sides[1])) < 5e-3),
        None,
    )


def with_diagonal(width: float, height: float, diagonal_mm: float) -> tuple[float, float]:
    """Sides in mm of a film of that diagonal with the shape `width` to `height`."""
    factor = diagonal_mm / hypot(width, height)
    return width * factor, height * factor
