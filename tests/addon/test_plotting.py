# SPDX-License-Identifier: GPL-3.0-or-later
"""The plotter that draws reports in Blender: areas against their formulas, lines against where their data are."""

from __future__ import annotations

import numpy as np
import pytest

from petzval.plotting import colour_maps, figure, raster, strokes, ticks

pytestmark = pytest.mark.once


class Bars:
    """Letters that are all bars."""

    def outline(self, text):
        bar = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 1.0], [0.0, 1.0]])
        return [bar + (0.6 * i, 0.0) for i in range(len(text))], 0.6 * len(text)


def circle(x, y, radius, corners=400):
    turn = 2.0 * np.pi * np.arange(corners) / corners
    return np.stack([x + radius * np.cos(turn), y + radius * np.sin(turn)], axis=1)


def covered(*polygons, size=(64, 48)):
    canvas = raster.Canvas(*size)
    canvas.fill(list(polygons), (0.0, 0.0, 0.0))
    return 1.0 - canvas.pixels[:, :, 0]


def test_areas_are_covered_as_much_as_they_are():
    # A pixel's coverage is told on eight lines: a dot that meets six of them is told less well.
    for radius, share in ((0.4, 0.04), (3.3, 0.01), (17.0, 0.002)):
        assert covered(circle(30.2, 22.7, radius)).sum() == pytest.approx(np.pi * radius**2, rel=share)
    ring = covered(circle(30, 22, 15.0), circle(30, 22, 9.0)[::-1])
    assert ring.sum() == pytest.approx(np.pi * (15.0**2 - 9.0**2), rel=0.01)
    assert ring[22, 30] == 0.0 and ring[22, 42] == 1.0


def test_what_overlaps_is_one_area_and_what_is_outside_is_not_drawn():
    twice = covered(circle(30, 22, 10.0), circle(30, 22, 10.0))
    # Where two edges lie in one pixel it is as dark as both.
    assert twice.max() == 1.0 and twice.sum() == pytest.approx(np.pi * 100.0, rel=0.05)
    half = covered(circle(0, 24, 10.0))
    assert half.sum() == pytest.approx(np.pi * 50.0, rel=0.01)
    assert covered(circle(-50, 0, 10.0)).sum() == 0.0 and covered(circle(500, 500, 10.0)).sum() == 0.0


def test_a_stroke_has_its_width_and_dashes_their_share():
    line = np.array([[5.0, 10.3], [50.0, 33.9]])
    length = np.hypot(45.0, 23.6)
    assert covered(*strokes.stroke(line, 2.5)).sum() == pytest.approx(2.5 * length, rel=0.01)
    dashes = [shape for piece in strokes.dashed(line, (4.0, 2.0)) for shape in strokes.stroke(piece, 2.5)]
    assert covered(*dashes).sum() == pytest.approx(2.5 * length * 2.0 / 3.0, rel=0.05)


def test_lines_are_cut_at_the_edge_of_the_plot():
    pieces = strokes.clipped(
        np.array([[-5.0, 5.0], [5.0, 5.0], [5.0, 20.0], [8.0, 20.0], [8.0, 2.0]]), (0, 0), (10, 10)
    )
    assert [piece.tolist() for piece in pieces] == [[[0, 5], [5, 5], [5, 10]], [[8, 10], [8, 2]]]


def test_a_curve_lies_where_its_data_are():
    page = figure.Figure((4.0, 3.0), Bars())
    axes = page.subplots()
    x = np.linspace(0.0, 2.0, 101)
    axes.plot(x, 1.0 + x**2, color="#c0392b", linewidth=2.0)
    axes.set_xlim(0.0, 2.0)
    axes.set_ylim(0.0, 6.0)
    axes.set_xlabel("mm")
    axes.set_title("a title")
    pixels = page.drawn()
    redness = np.maximum(pixels[:, :, 0] - pixels[:, :, 2], 0.0)
    left, low, right, high = axes.box
    assert 0 < left < right <= page.width and 0 < low < high < page.height
    for at in (0.3, 1.0, 1.7):
        column = redness[:, int(left + (right - left) * at / 2.0)]
        middle = (column * (np.arange(page.height) + 0.5)).sum() / column.sum()
        # The pixel's column is up to half a pixel from the place asked for; the curve's slope is up to 1.7.
        assert middle == pytest.approx(low + (high - low) * (1.0 + at**2) / 6.0, abs=2.0)


def test_plots_that_share_a_scale_show_the_same_and_do_not_overlap():
    page = figure.Figure((8.0, 4.0), Bars())
    one, other = page.subplots(1, 2, sharey=True)
    one.plot([0, 1], [0, 10])
    other.plot([0, 1], [-5, 3])
    page.drawn()
    assert one._seen("y") == other._seen("y") == (-5.75, 10.75)
    assert one.box[2] < other.box[0] and one.box[1] == other.box[1]


def test_equal_lengths_are_equal():
    page = figure.Figure((6.0, 3.0), Bars(), has_grid=False)
    axes = page.add_axes((0.1, 0.1, 0.8, 0.8))
    axes.set_xlim(0.0, 10.0)
    axes.set_ylim(0.0, 10.0)
    axes.set_aspect("equal")
    page.drawn()
    left, low, right, high = axes.box
    assert right - left == pytest.approx(high - low)


def test_numbers_on_scales_are_round():
    assert ticks.even(0.0, 1.0, 5) == pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
    assert ticks.names(ticks.even(-0.5, 0.5, 4)) == ["−0.50", "−0.25", "0.00", "0.25", "0.50"]
    assert ticks.names([0.0, 50.0, 100.0]) == ["0", "50", "100"]
    assert ticks.by_power(0.08, 1.3, 6) == pytest.approx([0.1, 0.2, 0.5, 1.0])
    assert ticks.even(1.0, 1.0, 5) == [1.0]


def test_an_image_shows_each_number_over_its_own_part():
    page = figure.Figure((2.0, 2.0), Bars(), dpi=100.0, has_grid=False)
    axes = page.add_axes((0.1, 0.1, 0.8, 0.8))
    axes.set_axis_off()
    values = np.array([[0.0, 1.0], [0.5, 0.25]])
    axes.imshow(values, extent=(-1.0, 1.0, -1.0, 1.0), cmap="inferno", vmin=0.0, vmax=1.0)
    pixels = page.drawn()
    colours = colour_maps.coloured(values, "inferno")
    for row in (0, 1):
        for column in (0, 1):
            part = pixels[20 + 80 * row : 100 + 80 * row, 20 + 80 * column : 100 + 80 * column, :3]
            assert np.abs(part - colours[row, column]).max() < 1e-6
    assert (pixels[:19, :, :3] == 1.0).all()
    # A part of it, larger.
    axes.set_xlim(-1.0, 0.0)
    axes.set_ylim(0.0, 1.0)
    assert np.abs(page.drawn()[20:180, 20:180, :3] - colours[1, 0]).max() < 1e-6


def test_colours_are_matplotlibs():
    matplotlib = pytest.importorskip("matplotlib")
    parts = np.linspace(0.0, 1.0, 256)
    # Linear between 52 places: within one step of 255.
    assert (
        np.abs(colour_maps.coloured(parts, "inferno") - matplotlib.colormaps["inferno"](parts)[:, :3]).max()
        < 1.0 / 255.0
    )


def test_a_plot_may_take_a_whole_row_of_a_grid():
    page = figure.Figure((6.0, 4.0), Bars(), dpi=50.0)
    grid = page.add_gridspec(2, 3)
    above = [page.add_subplot(grid[0, column]) for column in range(3)]
    below = page.add_subplot(grid[1, :])
    page.drawn()
    assert below.box[0] == pytest.approx(above[0].box[0]) and below.box[2] == pytest.approx(above[2].box[2])
    assert below.box[3] < above[0].box[1] and above[0].box[2] < above[1].box[0]
