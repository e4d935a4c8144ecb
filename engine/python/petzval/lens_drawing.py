# SPDX-License-Identifier: GPL-3.0-or-later
"""The drawing of a lens, from the engine's surfaces and rays: by matplotlib, or in Blender by `plotting`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .lens_reports.page import DARK, FIELDS, PALE, facts, field_colour, save

#: Points [z, y], mm.
_Line = list[list[float]]

_GLASS, _RIM, _MIRROR = "#d3e5f2", "#33566f", "#20262b"
_WIDTH_IN, _LEAST_IN, _MOST_IN = 10.0, 3.2, 8.0
#: Room above and below the lens.
_BESIDE_IN = 1.0
#: The stop's marks, of the lens's height, and the room about all, of its.
_MARK, _ROOM = 0.09, 0.06
#: Names of planes that are nearer, parts of the picture's width, would stand on one another.
_NEAR = 0.03


def write(found: dict[str, Any], out: Path) -> None:
    """Writes `lens_drawing_json`'s object, drawn or as it is. Raises `CommandError`."""

    def make(pyplot: Any) -> Any:
        figure = pyplot.figure(figsize=size_in(found))
        lay_out(found, figure)
        return figure

    save(found, out, {}, make)


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """The size of the page."""
    left, right, low, high = _extent(found)
    return _WIDTH_IN, min(max(_WIDTH_IN * (high - low) / (right - left), _LEAST_IN), _MOST_IN) + _BESIDE_IN


def lay_out(found: dict[str, Any], figure: Any) -> None:
    """The whole page into a figure of that size."""
    height = size_in(found)[1]
    axes = figure.add_axes((0.03, 0.55 / height, 0.94, (height - _BESIDE_IN - 0.05) / height))
    draw(found, axes)
    figure.legend(loc="lower left", bbox_to_anchor=(0.02, 0.0), ncols=len(FIELDS), frameon=False, handlelength=1.4)
    figure.text(0.03, 0.985, found["name"], fontsize=11, weight="bold", va="top")
    said = f"{facts(found)}   {found['wavelength_nm']:.4g} nm"
    figure.text(0.97, 0.985, said, color=DARK, va="top", ha="right")


def draw(found: dict[str, Any], axes: Any) -> None:
    """Draws the lens into a matplotlib axes."""
    left, right, low, high = _extent(found)
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    axes.set_aspect("equal")
    axes.axhline(0.0, color=PALE, linewidth=0.6, dashes=(12, 3, 2, 3), zorder=0)
    _elements(found, axes)
    for field, colour in zip(found["fields"], _colours(found), strict=True):
        for ray in field["rays"]:
            axes.plot(*zip(*ray, strict=True), color=colour, linewidth=0.6, zorder=4, solid_joinstyle="bevel")
    if len(found["film"]) > 1:
        axes.plot(*zip(*found["film"], strict=True), color=_MIRROR, linewidth=1.8, zorder=5)
    _stop(found, axes)
    _planes(found, axes, (left, right), high - low)
    for field, colour in zip(found["fields"], _colours(found), strict=True):
        said = f"{field['angle_deg']:.4g}°" + ("" if field["rays"] else " (dark)")
        axes.plot([], [], color=colour, linewidth=1.5, label=said)
    axes.spines[["top", "left", "right"]].set_visible(False)
    axes.set_yticks([])
    axes.set_xlabel("mm from the first vertex", loc="right", color=DARK)
    axes.tick_params(axis="x", colors=DARK, length=3)
    axes.spines["bottom"].set_color(PALE)


def _colours(found: dict[str, Any]) -> list[str]:
    return [field_colour(i) for i in range(len(found["fields"]))]


def _extent(found: dict[str, Any]) -> tuple[float, float, float, float]:
    """Left, right, low and high of the drawing, with room about it."""
    places = [place for surface in found["surfaces"] for place in surface["points"]]
    places += [place for field in found["fields"] for ray in field["rays"] for place in ray]
    places += [*found["film"], [found["film_z_mm"], 0.0]]
    depths, heights = zip(*places, strict=True)
    left, right = min(depths), max(depths)
    high = max(max(heights), -min(heights), 0.05 * (right - left)) * (1.0 + 2.0 * _ROOM)
    room = 0.02 * (right - left)
    return left - room, right + room, -high, high


def _elements(found: dict[str, Any], axes: Any) -> None:
    surfaces = found["surfaces"]
    for surface, after in zip(surfaces, surfaces[1:], strict=False):
        if surface["glass_behind"] is not None:
            depths, heights = zip(*_outline(surface["points"], after["points"]), strict=True)
            axes.fill(depths, heights, facecolor=_GLASS, edgecolor=_RIM, linewidth=0.8, zorder=2)
    for i, surface in enumerate(surfaces):
        if surface["is_mirror"]:
            for part in _beside(surface["points"], surface["hole_mm"]):
                axes.plot(*zip(*part, strict=True), color=_MIRROR, linewidth=2.4, zorder=3, solid_capstyle="butt")
        elif surface["hole_mm"] > 0.0 and i != found["stop"]:
            # Something dark in the middle.
            inside = [place for place in surface["points"] if abs(place[1]) <= surface["hole_mm"]]
            if len(inside) > 1:
                axes.plot(*zip(*inside, strict=True), color=_MIRROR, linewidth=2.4, zorder=3, solid_capstyle="butt")


def _outline(front: _Line, back: _Line) -> _Line:
    """About the glass between two surfaces: the smaller one's rim goes straight out to the larger one's height."""

    def out_to(rim: list[float], other: list[float]) -> _Line:
        return [[rim[0], other[1]]] if abs(other[1]) > abs(rim[1]) else []

    return [
        *out_to(front[0], back[0]), *front, *out_to(front[-1], back[-1]),
        *out_to(back[-1], front[-1]), *reversed(back), *out_to(back[0], front[0]),
    ]  # fmt: skip


def _beside(points: _Line, hole_mm: float) -> list[_Line]:
    """A surface's line, in two where its middle is missing."""
    if hole_mm <= 0.0:
        return [points]
    parts = [[place for place in points if side * place[1] >= hole_mm] for side in (-1.0, 1.0)]
    return [part for part in parts if len(part) > 1]


def _stop(found: dict[str, Any], axes: Any) -> None:
    surface, opening = found["surfaces"][found["stop"]], found["stop_semi_diameter_mm"]
    height = 2.0 * max(abs(place[1]) for surface in found["surfaces"] for place in surface["points"])
    if not surface["points"]:
        return
    for side in (-1.0, 1.0):
        z = min(surface["points"], key=lambda place: abs(place[1] - side * opening))[0]
        ends = [side * opening, side * (opening + _MARK * height)]
        axes.plot([z, z], ends, color="black", linewidth=2.2, zorder=6, solid_capstyle="butt")


def _planes(found: dict[str, Any], axes: Any, seen: tuple[float, float], height: float) -> None:
    """Principal planes and pupils that lie in the picture."""
    short = 0.5 * height
    planes = {"H": found["object_principal_plane_mm"], "H′": found["image_principal_plane_mm"]}
    planes = {name: z for name, z in planes.items() if z is not None and seen[0] < z < seen[1]}
    are_near = len(planes) == 2 and abs(planes["H"] - planes["H′"]) < _NEAR * (seen[1] - seen[0])
    for name, z in planes.items():
        is_first = (z, name) == min((z, name) for name, z in planes.items())
        side = ("right" if is_first else "left") if are_near else "center"
        axes.plot([z, z], [-0.82 * short, 0.82 * short], color=PALE, linewidth=0.8, dashes=(5, 3), zorder=1)
        axes.text(z, 0.84 * short, name, color="#555555", ha=side, va="bottom")
    for key, name in (("entrance_pupil", "EP"), ("exit_pupil", "XP")):
        z, diameter = found[key]["z_mm"], found[key]["diameter_mm"]
        if z is None or diameter is None or not seen[0] < z < seen[1] or diameter > height:
            continue
        for half in (-0.5, 0.5):
            axes.plot(z, half * diameter, marker="_", markersize=9, color="#7d3c98", zorder=6)
        axes.plot([z, z], [-0.5 * diameter, 0.5 * diameter], color="#7d3c98", linewidth=0.7, dashes=(2, 2), zorder=1)
        axes.text(z, -0.5 * diameter - 0.012 * height, name, color="#7d3c98", ha="center", va="top", fontsize=8)
