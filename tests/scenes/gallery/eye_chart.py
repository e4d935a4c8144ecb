# SPDX-License-Identifier: GPL-3.0-or-later
"""Eye charts at 6 m in a round room, straight ahead and 10 and 20 degrees aside. Made of numbers; CC0.

python tests/scenes/gallery/eye_chart.py chart.blend

The camera is the eye: all charts face it and stand 6 m away, so that rows are as large for it on each. A letter of the row
named 1.0 is 5 minutes of arc tall and its strokes 1 minute; the row 0.1 ten times that (International Council of
Ophthalmology, Visual Acuity Measurement Standard, 1984).
"""

from __future__ import annotations

import math

import bpy
import numpy as np
from parts import Stage, main, plain_world, turned

import demo_props as props
from demo_mesh import Shape, box, frame, grid, join, lathe, unit_grid

AWAY = 6.0
EYE = 1.25
ANGLES = (-20.0, -10.0, 0.0, 10.0, 20.0)
ACUITIES = (0.05, 0.1, 0.16, 0.25, 0.4, 0.63, 1.0, 1.6)
MINUTE = math.radians(1.0 / 60.0)
# Letters are 5 by 5 strokes.
GLYPHS = {
    "E": ("#####", "#....", "#####", "#....", "#####"),
    "M": ("#####", "#.#.#", "#.#.#", "#.#.#", "#.#.#"),
    "3": ("#####", "....#", "#####", "....#", "#####"),
    "W": ("#.#.#", "#.#.#", "#.#.#", "#.#.#", "#####"),
}


def _letter(glyph: str, x: float, z: float, tall: float):
    """Rectangles of one letter in the plane of Y = 0, about its middle: runs of strokes along each line."""
    stroke, points = tall / 5.0, []
    for row, line in enumerate(GLYPHS[glyph]):
        start = None
        for column, mark in enumerate([*line, "."]):
            if mark == "#" and start is None:
                start = column
            if mark != "#" and start is not None:
                x0, x1 = x + (start - 2.5) * stroke, x + (column - 2.5) * stroke
                z1, z0 = z + (2.5 - row) * stroke, z + (1.5 - row) * stroke
                points += [(x0, 0, z0), (x1, 0, z0), (x1, 0, z1), (x0, 0, z1)]
                start = None
    return points


def _chart(seed: int):
    """Rows of tumbling letters on a card 1 m wide, facing -Y: 0 card, 1 ink, 2 frame."""
    rng = np.random.default_rng(seed)
    points, z = [], 0.42
    for acuity in ACUITIES:
        tall = AWAY * 5.0 * MINUTE / acuity
        z -= tall / 2
        count = max(2, min(7, int(0.80 / (2.0 * tall)) + 1))
        for k in range(count):
            x = (k - (count - 1) / 2) * 2.0 * tall
            points += _letter("EM3W"[rng.integers(4)], x, z, tall)
        z -= tall / 2 + max(0.045, 0.5 * tall)
    count = len(points) // 4
    faces = [(4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3) for k in range(count)]
    ink = Shape(np.array(points, float), faces, np.zeros((4 * count, 2)), np.ones(count, np.int32))
    card = box(0.94, 0.008, 0.96, 0.002, 2)
    rim = frame(0.99, 1.01, 0.028, 0.026, 0.004).slot(2)
    return join([card, ink.at(y=-0.0046), rim])


def _room(stage: Stage) -> None:
    radius, wide = AWAY + 0.06, math.radians(62.0)
    angle = np.linspace(-wide, wide, 97)

    def band(z0, z1, r, repeat):
        z = np.array([z0, z1])
        points = np.stack([
            np.tile(r * np.sin(angle), (2, 1)), np.tile(r * np.cos(angle), (2, 1)), np.repeat(z[:, None], len(angle), 1),
        ], -1)  # fmt: skip
        u, v = np.meshgrid(angle * r * repeat, z * repeat)
        return grid(points, np.stack([u, v], -1))

    stage.put(band(0.0, 3.2, radius, 1.0), "Wall", ["plaster"])
    stage.put(join([band(0.0, 0.16, radius - 0.02, 1.0), band(2.72, 2.80, radius - 0.03, 1.0)]), "Skirting", ["paint"])
    u, v, uvs = unit_grid(2, 2)
    floor = grid(np.stack([(u - 0.5) * 14, (v - 0.3) * 12, 0 * u], -1), uvs * (14.0, 12.0))
    stage.put(floor, "Floor", ["floor"])
    stage.put(grid(np.stack([(u - 0.5) * 14, (v - 0.3) * 12, 0 * u + 3.2], -1), uvs), "Ceiling", ["ceiling"])
    side = box(0.2, 12, 3.2, 0)
    stage.put(join([side.at(x=s * 5.2, y=2.4, z=1.6) for s in (-1, 1)]), "Side walls", ["plaster"])
    stage.put(box(11, 0.2, 3.2, 0).at(y=-1.5, z=1.6), "Wall behind", ["plaster"])
    seat = stage.mesh(props.chair(), "Chair", ["mahogany"])
    for k, degrees in enumerate((-15.0, 5.0, 15.0)):
        t = math.radians(degrees)
        stage.again(seat, f"Chair {k}", turned((5.4 * math.sin(t), 5.4 * math.cos(t), 0), -degrees + (12, -8, 20)[k]))
    t = math.radians(-5.2)
    palm = props.plant(14, 10, 0.5, 0.2, 0.09, 0.25, 4)
    stage.put(palm, "Palm", ["leaf", "stem", "terracotta", "soil"], x=5.5 * math.sin(t), y=5.5 * math.cos(t), z=0.0)
    pot = lathe([(0, 0), (0.14, 0), (0.17, 0.28), (0.15, 0.28), (0, 0.25)], 48, 0.01)
    stage.put(pot, "Umbrella stand", ["brass"], x=5.6 * math.sin(0.44), y=5.6 * math.cos(0.44))


def build() -> Stage:
    """The room of charts."""
    stage = Stage("Eye chart")
    _room(stage)
    card = bpy.data.materials.new("Card")
    card.use_nodes = True
    card.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.82, 0.81, 0.77, 1.0)
    card.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.9
    for k, degrees in enumerate(ANGLES):
        t = math.radians(degrees)
        at = (AWAY * math.sin(t), AWAY * math.cos(t), EYE)
        stage.put(
            _chart(k),
            f"Chart at {degrees:+.0f} degrees",
            [card, "black", "dark wood"],
            x=at[0],
            y=at[1],
            z=at[2],
            rz=-degrees,
        )
    for k, x in enumerate((-2.6, 0.0, 2.6)):
        stage.lamp(
            f"Lamp {k}",
            "AREA",
            (x, 1.6, 2.6),
            150.0,
            (1.0, 0.95, 0.88),
            aim=(x * 1.2, 5.4, 1.2),
            shape="RECTANGLE",
            size=1.8,
            size_y=0.8,
        )
    plain_world(stage, (0.6, 0.65, 0.7), 0.05)
    # The eye's film: 17 mm of focal length, and 45 degrees of the room.
    stage.camera((0.0, 0.0, EYE), (0.0, AWAY, EYE), 17.0, (14.0, 7.0), AWAY, 4.0)
    stage.targets(
        **{
            f"Chart at {d:+.0f} degrees": (AWAY * math.sin(math.radians(d)), AWAY * math.cos(math.radians(d)), EYE)
            for d in ANGLES
        }
    )
    return stage


if __name__ == "__main__":
    main(build)
