# SPDX-License-Identifier: GPL-3.0-or-later
"""One plot: lines, areas and words over two scales. Its methods are named and mean as in matplotlib."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import ticks
from .colour_maps import coloured
from .legend import Legend
from .lines import Line, colour_of
from .strokes import stroke

if TYPE_CHECKING:
    from .figure import Figure

#: Points: of ticks, from them to their numbers, from those to the axis's name, above the plot to its title.
_TICK, _TO_NUMBER, _TO_NAME, _TO_TITLE = 3.0, 3.0, 4.0, 5.0
_NUMBER_COLOUR, _EDGE, _GRID = "#444444", "#8a939a", "#e3e7ea"
#: The margin of the limits about the data, as a part of their span.
_MARGIN = 0.05
#: Marks whose line is not drawn.
_FORMATS = {"o": "o", "*": "*", "<": "<"}


#: A place in a figure's grid: the row, the first and the last column.
Place = tuple[int, int, int]


@dataclass
class _Image:
    """Numbers as colours, rows from below."""

    values: npt.NDArray[np.float64]
    #: Left, right, low, high, of the data.
    extent: tuple[float, float, float, float]
    colours: str
    limits: tuple[float, float]


@dataclass
class _Spine:
    visible: bool
    color: str = _EDGE

    def set_color(self, color: str) -> None:
        self.color = color


class _Spines(dict[Any, Any]):
    """The spines by name, or by a list of names all at once."""

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, list):
            return _Several([dict.__getitem__(self, name) for name in key])
        return dict.__getitem__(self, key)


@dataclass
class _Several:
    spines: list[_Spine]

    def set_visible(self, visible: bool) -> None:
        for spine in self.spines:
            spine.visible = visible


@dataclass
class _Scale:
    """One axis: its range, its ticks and its words."""

    limits: list[float | None] = field(default_factory=lambda: [None, None])
    is_log: bool = False
    places: list[float] | None = None
    words: list[str] | None = None
    name: str = ""
    name_look: dict[str, Any] = field(default_factory=dict)

    def part(self, value: Any, low: float, high: float) -> Any:
        """The place of a value between low, 0, and high, 1."""
        if self.is_log:
            value = np.log10(np.maximum(value, 1e-300))
            low, high = math.log10(low), math.log10(high)
        return (np.asarray(value, dtype=float) - low) / (high - low)


@dataclass
class _RightAxis:
    """A second scale on the right, at the places of the first."""

    scale: _Scale = field(default_factory=_Scale)

    def set_yticks(self, places: Sequence[float], words: Sequence[str]) -> None:
        self.scale.places, self.scale.words = list(places), list(words)

    def set_ylabel(self, text: str, **_look: Any) -> None:
        self.scale.name = text


class Axes:
    """A plot of a figure; its place is that in the figure's grid."""

    transAxes = object()  # noqa: N815

    def __init__(self, figure: Figure, place: Place | None) -> None:
        self.figure, self.place = figure, place
        self.box = (0.0, 0.0, 1.0, 1.0)
        self.share_x = self.share_y = self
        self.names_x = self.names_y = True
        self.lines: list[Line] = []
        self.spines = _Spines({name: _Spine(not figure.has_grid or name in ("left", "bottom")) for name in ("left", "right", "top", "bottom")})  # fmt: skip
        self._x, self._y = _Scale(), _Scale()
        self._title: tuple[str, dict[str, Any]] = ("", {})
        self._areas: list[tuple[float, Any]] = []
        self._texts: list[tuple[float, float, str, dict[str, Any]]] = []
        self._legend: tuple[Legend, str, tuple[float, float]] | None = None
        self._right: _RightAxis | None = None
        self._image: _Image | None = None
        self._has_grid = figure.has_grid
        self._is_equal, self._number_size, self._has_axes = False, 9.0, True

    # What is drawn.

    def plot(self, x: Any, y: Any, style: str = "", **look: Any) -> list[Line]:
        """A line through points, or marks at them."""
        marker = look.pop("marker", _FORMATS.get(style, ""))
        has_line = style not in _FORMATS and look.pop("linestyle", "-") != "none"
        known = {key: look[key] for key in ("color", "linewidth", "dashes", "label", "markersize", "alpha", "zorder") if key in look}  # fmt: skip
        hollow = look.get("markerfacecolor") == "none" or look.get("fillstyle") == "none"
        line = Line(np.atleast_1d(x), np.atleast_1d(y), marker=marker, has_line=has_line, hollow=hollow, **known)
        self.lines.append(line)
        return [line]

    def axhline(self, y: float, **look: Any) -> None:
        """All across."""
        self.lines.append(Line(0.0, y, endless="y", **look))

    def axvline(self, x: float, **look: Any) -> None:
        """Adds a vertical line over the whole height."""
        self.lines.append(Line(x, 0.0, endless="x", **look))

    def fill(
        self, x: Any, y: Any, *, facecolor: str, edgecolor: str, linewidth: float = 1.0, zorder: float = 1.0
    ) -> None:
        """An area and its edge."""
        corners = np.stack([np.asarray(x, dtype=float), np.asarray(y, dtype=float)], axis=1)
        self._areas.append((zorder, (corners, facecolor, edgecolor, linewidth)))

    def imshow(
        self, values: Any, *, extent: tuple[float, float, float, float], cmap: str, vmin: float | None = None,
        vmax: float | None = None, **_look: Any,
    ) -> None:  # fmt: skip
        """Numbers as colours, the first row below, each over its own part of the extent: left, right, low, high."""
        numbers = np.asarray(values, dtype=float)
        limits = (numbers.min() if vmin is None else vmin, numbers.max() if vmax is None else vmax)
        self._image = _Image(numbers, extent, cmap, limits)

    def text(self, x: float, y: float, text: str, **look: Any) -> None:
        """Words at a place of the data, or of the plot with `transform=transAxes`."""
        self._texts.append((x, y, text, look))

    # How it looks.

    def set_xlim(self, low: Any = None, high: Any = None) -> None:
        """Sets the range of x that is seen."""
        self.share_x._x.limits = [low, high]

    def set_ylim(self, low: Any = None, high: Any = None) -> None:
        """Sets the range of y that is seen."""
        self.share_y._y.limits = [low, high]

    def set_xscale(self, kind: str) -> None:
        """linear or log."""
        self.share_x._x.is_log = kind == "log"

    def set_yscale(self, kind: str) -> None:
        """linear or log."""
        self.share_y._y.is_log = kind == "log"

    def set_xticks(self, places: Sequence[float], words: Sequence[str] | None = None) -> None:
        """Sets the places of numbers or words along x."""
        self._x.places, self._x.words = list(places), None if words is None else list(words)

    def set_yticks(self, places: Sequence[float], words: Sequence[str] | None = None) -> None:
        """Sets the places of numbers or words along y."""
        self._y.places, self._y.words = list(places), None if words is None else list(words)

    def set_xlabel(self, text: str, **look: Any) -> None:
        """The axis's name."""
        self._x.name, self._x.name_look = text, look

    def set_ylabel(self, text: str, **look: Any) -> None:
        """The axis's name."""
        self._y.name, self._y.name_look = text, look

    def set_title(self, text: str, **look: Any) -> None:
        """Sets the title above the axes."""
        self._title = text, look

    def set_aspect(self, _kind: str) -> None:
        """One length is as long both ways."""
        self._is_equal = True

    def grid(self, visible: bool) -> None:
        """Lines at the ticks."""
        self._has_grid = visible

    def set_axis_off(self) -> None:
        """No scales."""
        self._has_axes = False

    def tick_params(self, *, labelsize: float | None = None, **_look: Any) -> None:
        """Sets the size of the ticks' numbers."""
        self._number_size = labelsize or self._number_size

    def secondary_yaxis(self, _side: str) -> _RightAxis:
        """A scale on the right."""
        self._right = _RightAxis()
        return self._right

    def legend(
        self, *, loc: str, fontsize: float = 8.0, ncols: int = 1, bbox_to_anchor: tuple[float, float] | None = None,
        **_look: Any,
    ) -> None:  # fmt: skip
        """Names of the lines that have one: in a corner, where it covers least ("best"), or below the plot by an anchor."""
        lines = [line for line in self.lines if line.label]
        if lines:
            self._legend = Legend(lines, fontsize, ncols), loc, bbox_to_anchor or (0.0, 0.0)

    # Where everything comes to stand.

    def margins(self) -> tuple[float, float, float, float]:
        """Pixels left, below, right and above the box for the words there."""
        px, size = self.figure.pixels, self.figure.font_size
        number, line = px(self._number_size), px(size)
        left = low = right = high = 0.0
        if self._has_axes:
            left = px(_TICK + _TO_NUMBER) + (self._widest(self._y, self._seen("y")) if self.names_y else 0.0)
            low = px(_TICK + _TO_NUMBER) + (number if self.names_x else 0.0)
        if self._y.name:
            left += px(_TO_NAME) + 1.15 * line * (1 + self._y.name.count("\n"))
        if self._x.name:
            low += px(_TO_NAME) + line
        if self._title[0]:
            high = px(_TO_TITLE) + 1.1 * line
        if self._right:
            words = max((self.figure.measure(word, self._number_size) for word in self._right.scale.words or []), default=0.0)  # fmt: skip
            right = px(_TICK + _TO_NUMBER + 2.0 * _TO_NAME) + words + line
        if self._legend and self._legend[2][1] < 0.0:
            low += self._legend[0].size(self.figure)[1] + px(4.0)
        return left, low, max(right, 0.6 * number), max(high, 0.5 * number)

    def _widest(self, scale: _Scale, seen: tuple[float, float]) -> float:
        _, words = self._ticks(scale, seen, 8)
        return max((self.figure.measure(word, self._number_size) for word in words), default=0.0)

    def _ticks(self, scale: _Scale, seen: tuple[float, float], most: int) -> tuple[list[float], list[str]]:
        if scale.places is not None:
            places = scale.places
            return places, scale.words if scale.words is not None else ticks.names(places)
        if scale.is_log:
            places = ticks.by_power(*seen, max(most, 3))
            return places, [ticks.plain(place) for place in places]
        places = ticks.even(*seen, most)
        return places, ticks.names(places)

    def _seen(self, axis: str) -> tuple[float, float]:
        """The limits of an axis, set or by the data of all plots that share it."""
        owner = self.share_x if axis == "x" else self.share_y
        scale = owner._x if axis == "x" else owner._y
        low, high = scale.limits
        if (low is None or high is None) and owner._image is not None:
            extent = owner._image.extent[:2] if axis == "x" else owner._image.extent[2:]
            low, high = (extent[0] if low is None else low), (extent[1] if high is None else high)
        if low is None or high is None:
            sharers = [one for one in self.figure.axes if (one.share_x if axis == "x" else one.share_y) is owner]
            lines = [line for one in sharers for line in one.lines if line.endless in ("", axis)]
            ends = [np.atleast_1d(line.x if axis == "x" else line.y).astype(float) for line in lines]
            values = np.concatenate([np.zeros(0), *ends])
            values = values[np.isfinite(values)]
            least, most = (values.min(), values.max()) if len(values) else (0.0, 1.0)
            if scale.is_log:
                room = (most / least) ** _MARGIN if least > 0.0 else 1.0
                found = (least / room, most * room)
            else:
                room = _MARGIN * ((most - least) or abs(most) or 1.0)
                found = (least - room, most + room)
            low, high = (found[0] if low is None else low), (found[1] if high is None else high)
        return (low, high) if high > low else (low, low + (abs(low) or 1.0))

    def _fit(self) -> None:
        """Shrinks the box so that a length has the same size both ways."""
        if not self._is_equal:
            return
        (x0, x1), (y0, y1) = self._seen("x"), self._seen("y")
        left, low, right, high = self.box
        unit = min((right - left) / (x1 - x0), (high - low) / (y1 - y0))
        wide, tall = unit * (x1 - x0), unit * (y1 - y0)
        x, y = 0.5 * (left + right - wide), 0.5 * (low + high - tall)
        self.box = (x, y, x + wide, y + tall)

    def to_pixels(self, x: Any, y: Any) -> Any:
        """Places of the data, (n, 2)."""
        left, low, right, high = self.box
        across = left + self.share_x._x.part(x, *self._seen("x")) * (right - left)
        up = low + self.share_y._y.part(y, *self._seen("y")) * (high - low)
        return np.stack(np.broadcast_arrays(across, up), axis=-1).astype(float)

    # Drawing.

    def draw(self) -> None:
        """Draws the axes into the figure's picture."""
        self._fit()
        left, low, right, high = self.box
        if self._image is not None:
            self._draw_image(self._image)
        if self._has_axes:
            self._draw_scales()
        drawings: list[tuple[float, Callable[[Any], None], Any]] = [
            (zorder, self._draw_area, area) for zorder, area in self._areas
        ]
        drawings += [(line.zorder, self._draw_line, line) for line in self.lines]
        for _, paint, thing in sorted(drawings, key=lambda drawing: drawing[0]):
            paint(thing)
        for x, y, text, look in self._texts:
            words = {key: value for key, value in look.items() if key != "transform"}
            is_of_box = look.get("transform") is not None
            at_x, at_y = (left + x * (right - left), low + y * (high - low)) if is_of_box else self.to_pixels(x, y)
            self.figure.write(at_x, at_y, text, **words)
        if self._legend:
            self._draw_legend(*self._legend)

    def _draw_image(self, image: _Image) -> None:
        """Each pixel of the box has the colour of the number under its middle; beyond the extent there is none."""
        left, low, right, high = self.box
        columns, rows = np.arange(round(left), round(right)), np.arange(round(low), round(high))
        (x0, x1), (y0, y1) = self._seen("x"), self._seen("y")
        begin, end, bottom, top = image.extent
        tall, wide = image.values.shape
        across = np.floor(((x0 + (columns + 0.5 - left) / (right - left) * (x1 - x0)) - begin) / (end - begin) * wide)
        up = np.floor(((y0 + (rows + 0.5 - low) / (high - low) * (y1 - y0)) - bottom) / (top - bottom) * tall)
        is_across, is_up = (across >= 0) & (across < wide), (up >= 0) & (up < tall)
        if not (is_across.any() and is_up.any()):
            return
        shown = image.values[np.ix_(up[is_up].astype(int), across[is_across].astype(int))]
        least, most = image.limits
        parts = (shown - least) / ((most - least) or 1.0)
        self.figure.canvas.pixels[np.ix_(rows[is_up], columns[is_across])] = coloured(parts, image.colours)

    def _draw_area(self, area: Any) -> None:
        points, face, edge, width = area
        places = self.to_pixels(points[:, 0], points[:, 1])
        self.figure.canvas.fill([places], colour_of(face))
        self.figure.canvas.fill(stroke(places, self.figure.pixels(width), closed=True), colour_of(edge))

    def _draw_line(self, line: Line) -> None:
        left, low, right, high = self.box
        if line.endless:
            place = self.to_pixels(line.x if line.endless == "x" else self._seen("x")[0], line.y if line.endless == "y" else self._seen("y")[0])  # fmt: skip
            ends = [[place[0], low], [place[0], high]] if line.endless == "x" else [[left, place[1]], [right, place[1]]]
            line.paint(self.figure, np.array(ends), self.box[:2], self.box[2:])
            return
        x, y = np.asarray(line.x, dtype=float), np.asarray(line.y, dtype=float)
        is_good = np.isfinite(x) & np.isfinite(y)
        if is_good.any():
            line.paint(self.figure, self.to_pixels(x[is_good], y[is_good]), self.box[:2], self.box[2:])

    def _draw_scales(self) -> None:
        figure, px = self.figure, self.figure.pixels
        left, low, right, high = self.box
        number = self._number_size

        def rule(ends: list[list[float]], colour: str, width: float) -> None:
            figure.canvas.fill(stroke(np.array(ends), max(px(width), 0.9)), colour_of(colour))

        x_places, x_words = self._ticks(self._x if self._x.places else self.share_x._x, self._seen("x"), max(2, int((right - left) / (4.6 * px(number)))))  # fmt: skip
        y_places, y_words = self._ticks(self._y if self._y.places is not None else self.share_y._y, self._seen("y"), max(2, min(9, int((high - low) / (2.2 * px(number))))))  # fmt: skip
        seen_x, seen_y = self._seen("x"), self._seen("y")
        x_at = [(self.to_pixels(v, seen_y[0])[0], w) for v, w in zip(x_places, x_words, strict=True) if seen_x[0] - 1e-9 <= v <= seen_x[1] * (1 + 1e-9) + 1e-9]  # fmt: skip
        y_at = [(self.to_pixels(seen_x[0], v)[1], w) for v, w in zip(y_places, y_words, strict=True)]
        y_at = [(y, word) for y, word in y_at if low - 1.0 <= y <= high + 1.0]
        if self._has_grid:
            for x, _ in x_at:
                rule([[x, low], [x, high]], _GRID, 0.7)
            for y, _ in y_at:
                rule([[left, y], [right, y]], _GRID, 0.7)
        corners = {"left": [[left, low], [left, high]], "right": [[right, low], [right, high]], "bottom": [[left, low], [right, low]], "top": [[left, high], [right, high]]}  # fmt: skip
        for name, ends in corners.items():
            if self.spines[name].visible or (name == "right" and self._right):
                rule(ends, self.spines[name].color, 0.8)
        tick, to = px(_TICK), px(_TICK + _TO_NUMBER)
        for x, word in x_at:
            rule([[x, low - tick], [x, low]], _EDGE, 0.8)
            if self.names_x:
                figure.write(x, low - to, word, fontsize=number, color=_NUMBER_COLOUR, ha="center", va="top")
        for y, word in y_at:
            rule([[left - tick, y], [left, y]], _EDGE, 0.8)
            if self.names_y:
                figure.write(left - to, y, word, fontsize=number, color=_NUMBER_COLOUR, ha="right", va="center")
        self._draw_names(y_at)
        if self._right:
            self._draw_right(self._right, rule)

    def _draw_names(self, y_at: list[tuple[float, str]]) -> None:
        figure, px = self.figure, self.figure.pixels
        left, low, right, high = self.box
        size = figure.font_size
        if self._x.name:
            below = px(_TICK + _TO_NUMBER + _TO_NAME) + (px(self._number_size) if self.names_x else 0.0)
            at_right = self._x.name_look.get("loc") == "right"
            x, ha = (right, "right") if at_right else (0.5 * (left + right), "center")
            figure.write(x, low - below, self._x.name, color=_NUMBER_COLOUR, ha=ha, va="top")
        if self._y.name:
            widest = max((figure.measure(word, self._number_size) for _, word in y_at), default=0.0)
            aside = px(_TICK + _TO_NUMBER + _TO_NAME) + (widest if self.names_y else 0.0)
            colour = self._y.name_look.get("color", _NUMBER_COLOUR)
            place = left - aside
            figure.write(place, 0.5 * (low + high), self._y.name, color=colour, ha="center", va="bottom", turned=True)
        title, look = self._title
        if title:
            at_left = look.get("loc") == "left"
            x, ha = (left, "left") if at_left else (0.5 * (left + right), "center")
            shown = {"fontsize": look.get("fontsize", size + 0.5), "color": look.get("color", "black")}
            figure.write(x, high + px(_TO_TITLE), title, ha=ha, **shown)

    def _draw_right(self, axis: _RightAxis, rule: Any) -> None:
        figure, px = self.figure, self.figure.pixels
        _, low, right, high = self.box
        scale, widest = axis.scale, 0.0
        for value, word in zip(scale.places or [], scale.words or [], strict=True):
            y = self.to_pixels(self._seen("x")[0], value)[1]
            if low - 1.0 <= y <= high + 1.0:
                rule([[right, y], [right + px(_TICK), y]], _EDGE, 0.8)
                place = right + px(_TICK + _TO_NUMBER)
                figure.write(place, y, word, fontsize=self._number_size, color=_NUMBER_COLOUR, va="center")
                widest = max(widest, figure.measure(word, self._number_size))
        place = right + px(_TICK + _TO_NUMBER + _TO_NAME) + widest
        figure.write(place, 0.5 * (low + high), scale.name, color=_NUMBER_COLOUR, ha="center", va="top", turned=True)

    def _draw_legend(self, legend: Legend, loc: str, anchor: tuple[float, float]) -> None:
        anchor_x, anchor_y = anchor
        left, low, right, high = self.box
        width, height = legend.size(self.figure)
        inset = self.figure.pixels(6.0)
        if anchor_y < 0.0:
            below = self.margins()[1]
            x = left + anchor_x * (right - left) - 0.5 * width
            # Not beside the picture.
            x = min(max(x, 0.0), self.figure.width - width)
            legend.draw(self.figure, x, low - below + height)
            return
        corners = {
            f"{up} {side}": (left + inset if side == "left" else right - inset - width, high - inset if up == "upper" else low + inset + height)
            for up in ("upper", "lower") for side in ("left", "right")
        }  # fmt: skip
        if loc not in corners:
            loc = min(corners, key=lambda name: self._covered(corners[name], (width, height)))
        legend.draw(self.figure, *corners[loc])

    def _covered(self, corner: tuple[float, float], size: tuple[float, float]) -> int:
        """Points of lines that a legend there would cover."""
        x, y = corner
        count = 0
        for line in self.lines:
            if not line.endless and len(np.atleast_1d(line.x)):
                points = self.to_pixels(np.asarray(line.x, dtype=float), np.asarray(line.y, dtype=float))
                places = np.linspace(0, len(points) - 1, 200)
                points = np.stack([np.interp(places, np.arange(len(points)), points[:, i]) for i in (0, 1)], axis=1)
                inside = (points[:, 0] > x) & (points[:, 0] < x + size[0]) & (points[:, 1] < y) & (points[:, 1] > y - size[1])  # fmt: skip
                count += int(inside.sum())
        return count
