# SPDX-License-Identifier: GPL-3.0-or-later
"""A long room with a window at its end and a landscape behind it; things at 2, 3, 5 and 10 m. Made of numbers; CC0.

python tests/scenes/gallery/room.py room.blend

The camera looks along +Y from the origin, level, so depths along its axis are Y. The vase (2 m), the books (3 m), the
cushion (5 m) and the painting (10 m) carry the same print, as fine for the camera on each, so that their sharpness can be
compared. A lens of 100 mm on film 48 mm wide sees all four.
"""

from __future__ import annotations

import math

import numpy as np
from landscape import build_land
from parts import Stage, day_sky, main, packed_image, principled, print_pattern

import demo_props as props
import demo_room as house
from demo_mesh import box, frame, grid, join, lathe, placement, smooth_path, soft_box, tube, unit_grid
from demo_room import slab

EYE = 1.05
LEFT, RIGHT, BACK, FRONT, TOP = -2.15, 2.0, 10.1, -2.2, 3.0
WINDOW = (-1.75, 0.05, 0.32, 2.55)
SIDE_WINDOWS = ((0.6, 2.0), (3.2, 4.6), (5.8, 7.2))
# The print repeats once in so many metres for each metre of distance.
PRINT_PER_METRE = 0.075


def _print(name, ground, ink, accent, seed):
    return packed_image(name, print_pattern((1024, 1024), ground, ink, accent, seed))


def _walls(stage: Stage) -> None:
    x0, x1, z0, z1 = WINDOW
    thick = 0.35
    parts = [
        slab(LEFT - 0.2, x0, BACK, BACK + thick, 0, TOP),
        slab(x1, RIGHT + 0.2, BACK, BACK + thick, 0, TOP),
        slab(x0, x1, BACK, BACK + thick, 0, z0),
        slab(x0, x1, BACK, BACK + thick, z1, TOP),
        slab(RIGHT, RIGHT + 0.2, FRONT, BACK, 0, TOP),
        slab(LEFT - 0.2, RIGHT + 0.2, FRONT - 0.2, FRONT, 0, TOP),
    ]
    y = FRONT
    for y0, y1 in SIDE_WINDOWS:
        parts += [
            slab(LEFT - 0.2, LEFT, y, y0, 0, TOP),
            slab(LEFT - 0.2, LEFT, y0, y1, 0, 0.8),
            slab(LEFT - 0.2, LEFT, y0, y1, 2.5, TOP),
        ]
        y = y1
    parts.append(slab(LEFT - 0.2, LEFT, y, BACK, 0, TOP))
    stage.put(join(parts), "Walls", ["plaster"])
    stage.put(slab(LEFT - 0.2, RIGHT + 0.2, FRONT - 0.2, BACK + thick, TOP, TOP + 0.2), "Ceiling", ["ceiling"])
    boards, rng = [], np.random.default_rng(4)
    for x in np.arange(LEFT, RIGHT, 0.16):
        y = FRONT - rng.uniform(0, 2)
        while y < BACK:
            long = rng.uniform(1.6, 2.8)
            plank = box(0.158, long - 0.002, 0.02, 0.0015, 1).uv(1, 1, rng.uniform(0, 3), rng.uniform(0, 3))
            boards.append(plank.at(x + 0.08, y + long / 2, -0.01))
            y += long
    stage.put(join(boards), "Floor", ["floor"])
    skirting = [
        slab(LEFT, LEFT + 0.02, FRONT, BACK, 0, 0.14, 0.006),
        slab(RIGHT - 0.02, RIGHT, FRONT, BACK, 0, 0.14, 0.006),
        slab(LEFT, RIGHT, BACK - 0.02, BACK, 0, 0.14, 0.006),
        slab(LEFT, RIGHT, BACK - 0.07, BACK, TOP - 0.08, TOP, 0.02),
    ]
    # Casing, sashes' bars and the sill of the window.
    w, h, cx, cz = x1 - x0, z1 - z0, (x0 + x1) / 2, (z0 + z1) / 2
    joinery = [
        *skirting,
        frame(w + 0.2, h + 0.2, 0.11, 0.04, 0.008).at(cx, BACK - 0.01, cz),
        frame(w, h, 0.06, 0.07, 0.005).at(cx, BACK + 0.25, cz),
        slab(x0 - 0.15, x1 + 0.15, BACK - 0.1, BACK + 0.3, z0 - 0.04, z0 + 0.004, 0.008),
        slab(cx - 0.035, cx + 0.035, BACK + 0.22, BACK + 0.28, z0, z1, 0.005),
        slab(x0, x1, BACK + 0.22, BACK + 0.28, z0 + 0.72 * h - 0.025, z0 + 0.72 * h + 0.025, 0.005),
    ]
    for k in (1, 3):
        x = x0 + w * k / 4
        joinery.append(slab(x - 0.013, x + 0.013, BACK + 0.23, BACK + 0.27, z0, z1, 0.004))
    joinery.append(slab(x0, x1, BACK + 0.23, BACK + 0.27, z0 + 0.36 * h - 0.013, z0 + 0.36 * h + 0.013, 0.004))
    stage.put(join(joinery), "Joinery", ["paint"])
    for side, x in ((-1, x0 - 0.36), (1, x1 - 0.02)):
        cloth = props.curtain(0.38, 2.62, 5, 0.05, 3 + side, 0.0)
        stage.put(cloth, f"Curtain {side}", ["curtain"], x=x, y=BACK - 0.13, z=0.04)
    rod = lathe([(0.014, 0), (0.014, 2.9)], 20).at(ry=90).at(cx - 1.45, BACK - 0.13, 2.68)
    stage.put(rod, "Curtain rod", ["brass"])


def _vase(stage: Stage) -> None:
    """A vase at 2 m, upon the table."""
    profile = [
        (0, 0), (0.048, 0), (0.054, 0.006), (0.05, 0.02), (0.075, 0.09), (0.088, 0.16), (0.08, 0.22), (0.05, 0.262),
        (0.034, 0.285), (0.032, 0.305), (0.046, 0.328), (0.044, 0.331), (0.028, 0.306), (0.03, 0.28), (0, 0.27),
    ]  # fmt: skip
    period = 2 * PRINT_PER_METRE
    picture = _print("vase print", (0.86, 0.87, 0.85), (0.1, 0.18, 0.47), (0.2, 0.36, 0.66), 61)
    glaze = principled(
        "Glazed print", color=(picture, (round(2 * math.pi * 0.075 / period), 1 / period)), roughness=0.16
    )
    stage.put(lathe(profile, 96, 0.012, steps=4), "Vase at 2 m", [glaze], x=-0.27, y=2.0, z=0.78)
    rng = np.random.default_rng(8)
    sprigs = []
    for k in range(7):
        turn, out = k * 2.4, 0.03 + 0.02 * (k % 3)
        line = [(0.01 * math.cos(turn), 0.01 * math.sin(turn), 0.28)]
        line += [
            (out * t * 2.2 * math.cos(turn), out * t * 2.2 * math.sin(turn), 0.30 + 0.2 * t) for t in (0.3, 0.7, 1.0)
        ]
        path = smooth_path(line, 20)
        sprigs.append(tube(path, np.linspace(0.0018, 0.001, 20), 6).slot(1))
        for j in range(5):
            at = path[6 + 3 * j if j < 4 else 19]
            blade = props.leaf_blade(0.062, 0.026, rng.uniform(0.4, 1.0), 0.15, rng)
            sprigs.append(blade.at(rx=rng.uniform(10, 60)).at(*at, rz=rng.uniform(0, 360)))
    stage.put(join(sprigs), "Sprigs", ["leaf", "stem"], x=-0.27, y=2.0, z=0.78)


def _books(stage: Stage) -> None:
    """Books at 3 m: a pile; the front of its box carries the print."""
    period = 3 * PRINT_PER_METRE
    picture = _print("book print", (0.8, 0.72, 0.55), (0.36, 0.1, 0.07), (0.1, 0.24, 0.22), 62)
    cloth = principled("Printed cloth", color=(picture, (1 / period, 1 / period)), roughness=0.7)
    z, rng = 0.78, np.random.default_rng(2)
    front = 3.0
    for k, (cell, thick, high) in enumerate(((3, 0.045, 0.30), (8, 0.035, 0.27), (1, 0.05, 0.26))):
        shape = props.book(high * 0.7, high, thick, cell).at(ry=90).at(rz=0)
        # The spine towards the camera, the length across.
        shape.verts = shape.verts - [shape.verts[:, 0].mean(), shape.verts[:, 1].min(), shape.verts[:, 2].min()]
        stage.put(shape, f"Book {k}", ["books", "pages"], x=-0.06, y=front + 0.01 * k, z=z, rz=rng.normal(0, 2.0))
        z += thick
    box_shape = box(0.24, 0.17, 0.15, 0.004, 2)
    stage.put(box_shape, "Books at 3 m", [cloth], x=-0.06, y=front + 0.085, z=z + 0.075)
    stage.put(props.candlestick(), "Candlestick", ["brass", "white", "black", "white"], x=-0.35, y=4.1, z=0.78)


def _chair(stage: Stage) -> None:
    """The chair at 5 m: an armchair with a cushion that leans in it."""
    stage.put(props.armchair(), "Armchair", ["leather", "dark wood", "brass"], x=0.62, y=5.32, rz=-12)
    period = 5 * PRINT_PER_METRE
    picture = _print("cushion print", (0.82, 0.78, 0.66), (0.14, 0.28, 0.3), (0.62, 0.22, 0.1), 63)
    cloth = principled("Printed linen", color=(picture, (1 / period, 1 / period)), roughness=0.9)
    cushion = soft_box(0.46, 0.15, 0.42, 4.5, 18, 0.10, 0.004, 3)
    stage.put(cushion, "Cushion at 5 m", [cloth], x=0.56, y=5.06, z=0.69, rx=-14, rz=-12)
    stage.put(props.floor_lamp(1.62), "Floor lamp", ["brass", "linen"], x=1.35, y=6.3)
    stage.put(grid(*_flat_rug(1.9, 3.4)), "Rug", ["rug"], x=0.35, y=6.3, z=0.006)


def _flat_rug(w, d):
    u, v, uvs = unit_grid(17, 33)
    z = 0.002 * np.sin(9 * u * w) * np.sin(7 * v * d)
    return np.stack([(u - 0.5) * w, (v - 0.5) * d, z], -1), uvs


def _far_wall(stage: Stage) -> None:
    """The wall at 10 m: a framed print beside the window, a chest below it."""
    period = 10 * PRINT_PER_METRE
    picture = _print("wall print", (0.84, 0.8, 0.7), (0.2, 0.16, 0.2), (0.56, 0.3, 0.12), 64)
    w, h = 0.98, 1.24
    canvas = principled("Printed canvas", color=(picture, (w / period, h / period)), roughness=0.8)
    stage.put(props.picture(w, h, 0.09), "Painting at 10 m", ["brass", canvas], x=1.12, y=10.0, z=1.62)
    stage.put(house.table(1.35, 0.42, 0.80), "Console", ["dark wood"], x=1.12, y=BACK - 0.26)
    stage.put(props.plant(5), "Plant", ["leaf", "stem", "terracotta", "soil"], x=1.55, y=BACK - 0.28, z=0.8)
    stage.put(
        props.plant(14, 10, 0.75, 0.3, 0.13, 0.4, 4), "Palm", ["leaf", "stem", "terracotta", "soil"],
        x=-1.78, y=8.9, z=0.0,
    )  # fmt: skip
    seat = stage.mesh(props.chair(), "Chair", ["dark wood"])
    stage.again(seat, "Chair by the window", placement(-0.55, 8.6, 0, rz=28))


def _light(stage: Stage) -> None:
    day_sky(stage, 1.5)
    build_land(stage, nearest=11.0, half_angle=0.34, drop=1.3, trees=(45.0, 320.0), count=16, open_view=(-0.135, 0.0))
    for k, (y0, y1) in enumerate(SIDE_WINDOWS):
        stage.lamp(
            f"Daylight {k}", "AREA", (LEFT - 0.12, (y0 + y1) / 2, 1.65), 240.0, (0.92, 0.96, 1.0),
            aim=(0.0, (y0 + y1) / 2, 1.2), shape="RECTANGLE", size=y1 - y0, size_y=1.7,
        )  # fmt: skip
    stage.lamp(
        "Daylight behind", "AREA", (0.5, FRONT + 0.05, 1.9), 120.0, (1.0, 0.95, 0.88),
        aim=(0.0, 4.0, 1.0), shape="RECTANGLE", size=2.5, size_y=1.6,
    )  # fmt: skip


def build() -> Stage:
    """The room."""
    stage = Stage("Room")
    _walls(stage)
    table = house.table(1.05, 3.2, 0.78)
    stage.put(table, "Table", ["walnut"], x=-0.42, y=3.15)
    _vase(stage)
    _books(stage)
    _chair(stage)
    _far_wall(stage)
    _light(stage)
    stage.camera((0.0, 0.0, EYE), (0.0, 10.0, EYE), 100.0, (48.0, 32.0), 3.0, 1.4)
    # The faces that the camera sees: the vase's is 8 cm before its axis.
    stage.targets(
        **{
            "Vase at 2 m": (-0.27, 1.92, EYE),
            "Books at 3 m": (-0.06, 3.0, EYE),
            "Cushion at 5 m": (0.56, 5.0, 0.7),
            "Painting at 10 m": (1.12, 10.0, 1.6),
        }
    )
    return stage


if __name__ == "__main__":
    main(build)
