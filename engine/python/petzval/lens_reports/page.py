# SPDX-License-Identifier: GPL-3.0-or-later
"""The page that a report stands on: the head with the lens's data, colours, files. Only writing of files needs matplotlib."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import CommandError, writing

#: The formats of the files by ending.
PICTURES = (".svg", ".png", ".pdf")
PALE, DARK, GRID = "#8a939a", "#444444", "#e3e7ea"
#: Colours by field, as designers have them: the axis blue, then green and red.
FIELDS = ("#1f5fae", "#2d8a3e", "#c0392b", "#8e44ad", "#c77700", "#128a8a")
#: Colours from short to long waves.
_LINES = ("#7b3fa0", "#1f5fae", "#128a8a", "#2d8a3e", "#c77700", "#c0392b", "#7a1f1f")
_BLUE, _GREEN, _RED = _LINES[1], _LINES[3], _LINES[5]
#: Settings of axes, beside those of every picture.
_STYLE = {
    "axes.edgecolor": PALE, "axes.labelcolor": DARK, "xtick.color": DARK, "ytick.color": DARK, "axes.titlesize": 9.5,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": GRID,
    "grid.linewidth": 0.7, "axes.axisbelow": True, "legend.frameon": False,
}  # fmt: skip
#: Inches above a report for its head.
HEAD_IN = 0.75


def check(out: Path) -> None:
    """Raises `CommandError` where no file of that ending can be written."""
    if out.suffix.lower() not in (*PICTURES, ".json"):
        raise CommandError(f"cannot draw into {out}: its ending is not .svg, .png, .pdf or .json: change --output")
    if out.suffix.lower() != ".json":
        try:
            import matplotlib  # noqa: F401
        except ImportError as error:
            raise CommandError(
                f"cannot draw {out}: matplotlib cannot be had ({error}): pip install matplotlib"
            ) from None


def save(found: Any, out: Path, style: dict[str, Any], make: Callable[[Any], Any]) -> None:
    """Writes a report: the figure that `make(pyplot)` makes in that style; or it as it is, into .json. Raises `CommandError`."""
    from .. import atomic_files

    kind = out.suffix.lower()
    with writing(out):
        if kind == ".json":
            atomic_files.write_json(out, found)
            return
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        with pyplot.rc_context({"font.size": 9, "svg.hashsalt": "petzval", "svg.fonttype": "none", **style}):
            figure = make(pyplot)
            metadata = {".svg": {"Date": None}, ".png": {"Software": None}, ".pdf": {"CreationDate": None}}
            # In memory first: the writer of PDF files fails in other ways, too, where a disk is full.
            drawn = io.BytesIO()
            figure.savefig(drawn, format=kind[1:], dpi=150, metadata=metadata[kind])
            pyplot.close(figure)
        data = drawn.getvalue()
        if kind == ".svg":
            data = _with_steady_names(data.decode("utf-8")).encode("utf-8")
        atomic_files.write_bytes(out, data)


def _with_steady_names(svg: str) -> str:
    """The SVG with the names of its shared parts numbered as they come: matplotlib makes some of them from addresses in memory,
    and a report is to be the same file again."""
    numbers: dict[str, int] = {}
    return re.sub(
        r"(?<![0-9A-Za-z])[A-Zmp][0-9a-f]{10}(?![0-9A-Za-z])",
        lambda name: f"{name[0][0]}{numbers.setdefault(name[0], len(numbers))}",
        svg,
    )


def _fix_layout(figure: Any) -> None:
    """Lays a figure out, and rounds the places of its axes. The solver of the layout adds up in the order of addresses in memory: the
    last bits of its results differ from process to process, and a report is to be the same file again."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        left, bottom, width, height = axes.get_position(original=True).bounds
        axes.set_position([round(part, 9) for part in (left, bottom, width, height)])


def write(found: Any, out: Path, size_in: tuple[float, float], title: str, draw: Callable[[Any, Any], None]) -> None:
    """Writes a report: its picture, `draw(found, figure)`, that size without its head; or it as it is, into .json."""

    def make(pyplot: Any) -> Any:
        width, height = size_in
        figure = pyplot.figure(figsize=(width, height + HEAD_IN), layout="constrained")
        figure.get_layout_engine().set(rect=(0.01, 0.01, 0.98, height / (height + HEAD_IN) - 0.01))
        draw(found, figure)
        head(found, title, figure, height + HEAD_IN)
        _fix_layout(figure)
        return figure

    save(found, out, _STYLE, make)


def head(found: Any, title: str, figure: Any, height_in: float) -> None:
    """Draws the head of a report, on a page that high."""
    top = found[0] if isinstance(found, list) else found
    figure.text(0.02, 1.0 - 0.12 / height_in, top["name"], fontsize=11, weight="bold", va="top")
    figure.text(0.02, 1.0 - 0.36 / height_in, title, color=DARK, va="top")
    figure.text(0.98, 1.0 - 0.36 / height_in, facts(top), color=DARK, va="top", ha="right")


def facts(found: dict[str, Any]) -> str:
    """Focal length, f-number, focus; of a glass index and Abbe number."""
    if "nd" in found:
        abbe = "no dispersion" if found["abbe"] is None else f"V = {found['abbe']:.2f}"
        return f"n = {found['nd']:.6f}   {abbe}"
    said = []
    if found["efl_mm"] is not None:
        said.append(f"f = {found['efl_mm']:.5g} mm")
    if found["f_number"] is not None:
        said.append(f"F/{found['f_number']:.3g}")
    distance = found["focus_distance_mm"]
    said.append("focused at infinity" if distance is None else f"focused at {distance:.5g} mm")
    return "   ".join(said)


def field_colour(i: int) -> str:
    """The colour of the field of that number."""
    return FIELDS[i % len(FIELDS)]


def line_colours(wavelengths_nm: list[float]) -> list[str]:
    """The colours by wavelength: the shorter the bluer, three of them as F, d and C are drawn."""
    order = sorted(range(len(wavelengths_nm)), key=lambda i: wavelengths_nm[i])
    few = {1: [_GREEN], 2: [_BLUE, _RED], 3: [_BLUE, _GREEN, _RED]}.get(len(order))
    colours = [""] * len(order)
    for rank, i in enumerate(order):
        colours[i] = few[rank] if few else _LINES[round(rank * (len(_LINES) - 1) / (len(order) - 1))]
    return colours


def line_names(wavelengths_nm: list[float]) -> list[str]:
    """The names by wavelength."""
    return [f"{nm:.4g} nm" for nm in wavelengths_nm]


def degrees(angle: float) -> str:
    """An angle in words."""
    return f"{angle:.4g}°"


def lengths(largest_mm: float) -> tuple[float, str]:
    """The factor from mm to the unit of display, and that unit."""
    return (1e3, "µm") if largest_mm < 0.5 else (1.0, "mm")
