# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports as pictures in memory: the pages of `lens_reports` and `lens_drawing`, without matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import lens_drawing
from ..lens_reports import page
from .figure import Figure, Lettering

Picture = npt.NDArray[np.float32]


def report(
    found: Any, size_in: tuple[float, float], title: str, draw: Callable[[Any, Any], None], lettering: Lettering
) -> Picture:
    """The picture of a report, as `lens_reports.page.write` draws it: (height, width, 4), first row at the bottom, sRGB."""
    width, height = size_in[0], size_in[1] + page.HEAD_IN
    figure = Figure((width, height), lettering)
    left, low, right, high = figure.room
    figure.room = (left, low, right, high - page.HEAD_IN * figure.dpi)
    draw(found, figure)
    page.head(found, title, figure, height)
    return figure.drawn()


def drawing(found: dict[str, Any], lettering: Lettering) -> Picture:
    """The picture of a lens, as `lens_drawing.write` draws it."""
    figure = Figure(lens_drawing.size_in(found), lettering, has_grid=False)
    lens_drawing.lay_out(found, figure)
    return figure.drawn()
