# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of arguments of the command line: each is a function that reads its text, or says the form that it should have."""

from __future__ import annotations

import argparse
import math
import re

from . import film_formats
from .effects import EFFECTS, WORDS

FILM_NAMES = ", ".join(film.name for film in film_formats.FILM_FORMATS)


def number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"not a finite number: {text}")
    return value


def degrees(text: str) -> float:
    """An angle in degrees, as radians."""
    return math.radians(number(text))


def positive(text: str) -> float:
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"must be above zero: {text}")
    return value


def part(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"must be from 0 to 1: {text}")
    return value


def threshold(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 10.0:
        raise argparse.ArgumentTypeError(f"must be from 0 to 10: {text}")
    return value


def quality(text: str) -> float:
    value = number(text)
    if not 0.01 <= value <= 1000.0:
        raise argparse.ArgumentTypeError(f"quality {text}: must be from 0.01 to 1000")
    return value


def distance(text: str) -> float:
    value = float(text)
    if math.isnan(value) or value <= 0.0:
        raise argparse.ArgumentTypeError(f"not a distance: {text}")
    return value


def natural(text: str) -> int:
    value = int(text)
    if not 0 <= value < 2**31:
        raise argparse.ArgumentTypeError(f"must be from 0 to 2^31 - 1: {text}")
    return value


def count(text: str) -> int:
    value = natural(text)
    if value == 0:
        raise argparse.ArgumentTypeError("must be at least 1")
    return value


#: Blender's first and last frame.
_FRAMES = 1_048_574


def frame(text: str) -> int:
    value = int(text)
    if not -_FRAMES <= value <= _FRAMES:
        raise argparse.ArgumentTypeError(f"must be from {-_FRAMES} to {_FRAMES}: {text}")
    return value


def frames(text: str) -> list[int]:
    """ "1-24", "1-240,4" (every fourth), "-10-10", or one number."""
    found = re.fullmatch(r"(-?\d+)(?:-(-?\d+)(?:,(\d+))?)?", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"must be FIRST-LAST or FIRST-LAST,STEP: {text}")
    first, last = frame(found[1]), frame(found[2] or found[1])
    step = count(found[3] or "1")
    if last < first:
        raise argparse.ArgumentTypeError(f"ends before it begins: {text}")
    return list(range(first, last + 1, step))


def _split(text: str, separator: str, count: int) -> list[str]:
    parts = text.lower().split(separator)
    if len(parts) != count:
        raise argparse.ArgumentTypeError(f"must be {count} values with '{separator}' between them: {text}")
    return parts


def size_mm(text: str) -> list[float]:
    return [positive(one) for one in _split(text, "x", 2)]


def film(text: str) -> list[float] | str:
    if text.lower() == "lens":
        return "lens"
    known = film_formats.by_name(text)
    if known is not None:
        return [known.width_mm, known.height_mm]
    if "x" not in text.lower():
        raise argparse.ArgumentTypeError(f"no such film: {text}: give WIDTHxHEIGHT in mm, lens, or one of {FILM_NAMES}")
    return size_mm(text)


def pixels(text: str) -> list[int]:
    return [count(one) for one in _split(text, "x", 2)]


def pair(text: str) -> list[float]:
    return [number(one) for one in _split(text, ",", 2)]


def place(text: str) -> list[float]:
    at = pair(text)
    if not all(0.0 <= one <= 1.0 for one in at):
        raise argparse.ArgumentTypeError(f"must be from 0 to 1: {text}")
    return at


def point(text: str) -> list[float]:
    return [number(one) for one in _split(text, ",", 3)]


def triple(text: str) -> list[float]:
    return [positive(one) for one in _split(text, ",", 3)]


def wavelengths(text: str) -> str | float:
    words = {"visible": "VISIBLE", "rgb": "THREE"}
    return words.get(text) or positive(text)


def effect(text: str) -> tuple[str, str]:
    name, _, word = text.partition("=")
    names = [one.name for one in EFFECTS]
    if name not in names or word not in WORDS:
        raise argparse.ArgumentTypeError(f"{text}: give NAME=auto|on|off, NAME one of {', '.join(names)}")
    return name, word


for _type, _name in ((number, "number"), (degrees, "number"), (positive, "number"), (part, "number"), (quality, "number"), (distance, "distance"),
                     (threshold, "number"), (frame, "number"), (frames, "range of frames"), (natural, "number"), (count, "number"), (size_mm, "size"), (film, "film"),
                     (pixels, "size"), (pair, "pair"), (triple, "triple"), (effect, "effect"),
                     (wavelengths, "spectrum"), (place, "place"), (point, "point")):  # fmt: skip
    # argparse names the type in its message: "invalid number value: 'x'".
    _type.__name__ = _name
