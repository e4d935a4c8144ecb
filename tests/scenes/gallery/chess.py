# SPDX-License-Identifier: GPL-3.0-or-later
"""A chess table in a room, and a row of pieces at one depth. Made of numbers; CC0.

python tests/scenes/gallery/chess.py chess.blend [table|row]

table: a game from a metre and a half, things all round, for pictures of 17 to 67 degrees across.
row: eight pieces side by side at one depth, 0.9 m from the camera.
"""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Matrix
from parts import Stage, main, packed_image, paint, plain_world, principled, turned

import demo_props as props
import demo_room as house
from demo_mesh import box, grid, icosphere, join, lathe, prism, unit_grid
from demo_room import slab

SQUARE = 0.055
BORDER = 0.045
THICK = 0.024
TABLE = 0.72

# Profiles of (radius, height) in units of the piece's base radius; the base is common to all.
BASE = [(0, 0), (1.0, 0), (1.0, 0.14), (0.93, 0.22), (0.96, 0.30), (0.86, 0.42), (0.66, 0.50), (0.60, 0.60)]


def _turned(body, radius):
    return lathe([(r * radius, z * radius) for r, z in [*BASE, *body]], 56, 0.05 * radius, steps=3)


def pawn():
    """Stem, collar and ball."""
    r = 0.0155
    ball = [(0.5 * math.sin(t), 2.42 - 0.5 * math.cos(t)) for t in np.linspace(0.62, math.pi, 16)]
    return _turned([(0.36, 1.35), (0.32, 1.72), (0.6, 1.82), (0.62, 1.92), (0.34, 2.0), *ball[:-1], (0, 2.92)], r)


def rook():
    """A tower with six battlements."""
    r = 0.0175
    tower = _turned(
        [(0.5, 1.5), (0.46, 2.0), (0.66, 2.12), (0.68, 2.25), (0.56, 2.32), (0.56, 2.5), (0.74, 2.62), (0.74, 2.86),
         (0.52, 2.86), (0.52, 2.7), (0, 2.7)], r,
    )  # fmt: skip
    teeth = []
    for k in range(6):
        a0, a1 = math.tau * (k + 0.16) / 6, math.tau * (k + 0.84) / 6
        arc = np.linspace(a0, a1, 7)
        outline = [(0.74 * r * math.cos(a), 0.74 * r * math.sin(a)) for a in arc]
        outline += [(0.53 * r * math.cos(a), 0.53 * r * math.sin(a)) for a in arc[::-1]]
        tooth = prism(outline, 0.3 * r, 0.0004, 1)
        teeth.append(tooth.at(rx=90).at(z=2.98 * r))
    return join([tower, *teeth])


def knight():
    """A horse's head, cut from a board and rounded, on the common base."""
    r = 0.0178
    foot = _turned([(0.62, 0.72), (0.70, 0.82), (0.60, 0.92), (0, 0.94)], r)
    head = [
        (-0.55, 0.9), (-0.60, 1.3), (-0.46, 1.75), (-0.16, 2.05), (-0.42, 1.98), (-0.72, 1.90), (-0.93, 1.98), (-0.98, 2.20),
        (-0.88, 2.42), (-0.60, 2.72), (-0.42, 3.02), (-0.20, 3.22), (-0.10, 3.48), (0.06, 3.24), (0.30, 3.06), (0.52, 2.70),
        (0.64, 2.25), (0.66, 1.75), (0.58, 1.3), (0.55, 0.9),
    ]  # fmt: skip
    fine = []
    for k in range(len(head)):
        p0, p1, p2, p3 = (np.array(head[(k + j) % len(head)]) for j in (-1, 0, 1, 2))
        for t in (0.0, 0.34, 0.67):
            fine.append(
                0.5
                * (2 * p1 + (p2 - p0) * t + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t**2 + (3 * p1 - p0 - 3 * p2 + p3) * t**3)
            )
    shape = prism([(x * r, z * r) for x, z in fine], 0.78 * r, 0.19 * r, 4)
    # Narrow at the muzzle and the ears, full at the neck.
    x, z = shape.verts[:, 0] / r, shape.verts[:, 2] / r
    slim = (
        1.0
        - 0.35 * np.clip((-x - 0.2) / 0.7, 0, 1)
        - 0.45 * np.clip((z - 2.9) / 0.6, 0, 1)
        + 0.3 * np.clip((1.5 - z) / 0.6, 0, 1)
    )
    shape.verts = shape.verts * np.stack([np.ones_like(slim), slim, np.ones_like(slim)], -1)
    eyes = [icosphere(0.085 * r, 2).at(-0.42 * r, side * 0.31 * r, 2.52 * r) for side in (-1, 1)]
    mane = [
        box(0.10 * r, 0.86 * r, 0.06 * r, 0.02 * r).at(x_ * r, 0, z_ * r, ry=turn)
        for x_, z_, turn in (
            (0.34, 2.95, -40),
            (0.50, 2.65, -58),
            (0.60, 2.32, -75),
            (0.64, 1.98, -88),
            (0.63, 1.64, -95),
        )
    ]
    return join([foot, shape, *eyes, *mane])


def bishop():
    """A mitre with its cleft."""
    r = 0.0175
    mitre = [
        (0.40, 2.55),
        (0.52, 2.75),
        (0.54, 2.98),
        (0.44, 3.25),
        (0.24, 3.52),
        (0.12, 3.58),
        (0.16, 3.68),
        (0.12, 3.8),
        (0, 3.84),
    ]
    body = _turned(
        [(0.42, 1.5), (0.32, 2.1), (0.60, 2.2), (0.62, 2.3), (0.40, 2.38), (0.5, 2.44), (0.5, 2.5), *mitre], r
    )
    cleft = box(0.07 * r, 0.5 * r, 0.5 * r, 0).at(0.30 * r, 0, 3.2 * r, ry=32).slot(1)
    return join([body, cleft])


def queen():
    """A coronet of nine points and a ball."""
    r = 0.0195
    body = _turned(
        [(0.46, 1.6), (0.34, 2.5), (0.62, 2.62), (0.64, 2.74), (0.42, 2.82), (0.52, 2.9), (0.50, 2.98), (0.40, 3.06),
         (0.50, 3.45), (0.66, 3.72), (0.52, 3.70), (0.36, 3.66), (0, 3.80)], r,
    )  # fmt: skip
    points = [
        icosphere(0.105 * r, 2).at(0.60 * r * math.cos(t), 0.60 * r * math.sin(t), 3.72 * r)
        for t in np.arange(9) * math.tau / 9
    ]
    return join([body, *points, icosphere(0.17 * r, 3).at(z=3.93 * r)])


def king():
    """A closed crown with its cross."""
    r = 0.0205
    body = _turned(
        [(0.48, 1.7), (0.36, 2.6), (0.64, 2.74), (0.66, 2.87), (0.44, 2.96), (0.54, 3.04), (0.52, 3.12), (0.42, 3.2),
         (0.52, 3.6), (0.60, 3.86), (0.50, 3.98), (0.16, 4.08), (0.10, 4.14), (0, 4.15)], r,
    )  # fmt: skip
    arms = [
        box(0.13 * r, 0.11 * r, 0.56 * r, 0.015 * r).at(z=4.4 * r),
        box(0.42 * r, 0.11 * r, 0.13 * r, 0.015 * r).at(z=4.46 * r),
    ]
    return join([body, *arms])


PIECES = {"pawn": pawn, "rook": rook, "knight": knight, "bishop": bishop, "queen": queen, "king": king}


def _board(stage: Stage, top: float) -> None:
    """Squares of two woods set in a frame, letters and numbers inlaid; its upper face at `top`, its middle at the origin."""
    half, rng = 4 * SQUARE, np.random.default_rng(3)
    for name, wood, parity in (("Light squares", "maple", 1), ("Dark squares", "walnut", 0)):
        tiles = []
        for i in range(8):
            for j in range(8):
                if (i + j) % 2 == parity:
                    tile = box(SQUARE - 0.0002, SQUARE - 0.0002, 0.004, 0.0002, 1).uv(
                        1, 1, rng.uniform(0, 2), rng.uniform(0, 2)
                    )
                    tiles.append(tile.at(-half + (i + 0.5) * SQUARE, -half + (j + 0.5) * SQUARE, top - 0.002))
        stage.put(join(tiles), name, [wood])
    edge, middle = half + BORDER, half + BORDER / 2
    rails = [
        box(2 * edge, BORDER, THICK, 0.003, 3, "x").at(y=s * middle, z=top - THICK / 2 + 0.0008) for s in (-1, 1)
    ] + [box(BORDER, 2 * half, THICK, 0.003, 3).at(x=s * middle, z=top - THICK / 2 + 0.0008) for s in (-1, 1)]
    stage.put(join(rails), "Board frame", ["mahogany"])
    stage.put(slab(-half, half, -half, half, top - THICK, top - 0.0045), "Board bottom", ["dark wood"])
    string = [box(2 * half + 0.006, 0.002, 0.0012, 0).at(y=s * (half + 0.002), z=top + 0.0004) for s in (-1, 1)]
    string += [box(0.002, 2 * half + 0.006, 0.0012, 0).at(x=s * (half + 0.002), z=top + 0.0004) for s in (-1, 1)]
    stage.put(join(string), "Stringing", ["brass"])
    for k in range(8):
        at = -half + (k + 0.5) * SQUARE
        for text, x, y, turn in (
            ("abcdefgh"[k], at, -middle, 0.0), ("abcdefgh"[k], at, middle, 180.0),
            (str(k + 1), -middle, at, 0.0), (str(k + 1), middle, at, 180.0),
        ):  # fmt: skip
            curve = bpy.data.curves.new(f"Letter {text}", "FONT")
            curve.body, curve.size, curve.align_x, curve.align_y = text, 0.024, "CENTER", "CENTER"
            curve.materials.append(stage.material("brass"))
            made = bpy.data.objects.new(curve.name, curve)
            made.matrix_world = turned((x, y, top + 0.0012), turn)
            stage.collection.objects.link(made)


def _pieces(stage: Stage):
    """Meshes by (colour, kind)."""
    made = {}
    for colour, wood in (("white", "boxwood"), ("black", "ebony")):
        for kind, shape in PIECES.items():
            made[colour, kind] = stage.mesh(shape(), f"{colour} {kind}", [wood, "black"])
    return made


# A quiet game after the tenth move, square by square.
POSITION = (
    "r..q.rk.",
    "ppp..ppp",
    "..np.n..",
    "..b.p.B.",
    "..B.P.b.",
    "..NP.N..",
    "PPP..PPP",
    "R..Q.RK.",
)
KINDS = {"p": "pawn", "r": "rook", "n": "knight", "b": "bishop", "q": "queen", "k": "king"}


def _game(stage: Stage, top: float) -> None:
    meshes, rng = _pieces(stage), np.random.default_rng(6)
    taken = {"white": 0, "black": 0}
    for row, line in enumerate(POSITION):
        for column, one in enumerate(line):
            if one == ".":
                continue
            colour, kind = ("white" if one.isupper() else "black"), KINDS[one.lower()]
            x, y = (column - 3.5) * SQUARE, (3.5 - row) * SQUARE
            turn = {"white": -65.0, "black": 118.0}[colour] if kind == "knight" else rng.uniform(0, 360)
            spot = (x + rng.normal(0, 0.0012), y + rng.normal(0, 0.0012), top)
            stage.again(meshes[colour, kind], f"{colour.capitalize()} {kind} {column}{row}", turned(spot, turn))
    # A taken pawn of each lies beside the board.
    for colour, x, y in (("black", -0.335, -0.20), ("white", 0.345, 0.16)):
        lying = (
            Matrix.Translation((x, y, TABLE + 0.0155))
            @ Matrix.Rotation(0.7 + taken[colour], 4, "Z")
            @ Matrix.Rotation(math.pi / 2, 4, "Y")
        )
        stage.again(meshes[colour, "pawn"], f"Taken {colour} pawn", lying)


def _clock():
    """A chess clock facing -Y: 0 wood, 1 dial (UV 0..1), 2 brass."""
    parts = [box(0.2, 0.055, 0.10, 0.012, 4).at(z=0.05)]
    for x in (-0.048, 0.048):
        dial = lathe([(0.036, 0.002), (0, 0.002)], 48).slot(1)
        dial.uvs = np.concatenate([dial.verts[list(f)][:, :2] / 0.072 + 0.5 for f in dial.faces])
        rim = lathe([(0.0355, 0), (0.039, 0.001), (0.039, 0.005), (0.0355, 0.006)], 48, 0.0008).slot(2)
        parts.append(join([dial, rim]).at(rx=90).at(x, -0.0275, 0.052))
        parts.append(
            lathe([(0.006, 0), (0.006, 0.01), (0.008, 0.012), (0.008, 0.016), (0, 0.017)], 24).at(x, 0, 0.099).slot(2)
        )
    return join(parts)


def _room(stage: Stage) -> None:
    stage.put(slab(-2.6, 2.6, -2.4, 2.6, -0.02, 0.0), "Floor under the boards", ["dark wood"])
    boards, rng = [], np.random.default_rng(4)
    for x in np.arange(-2.6, 2.6, 0.15):
        y = -2.4 - rng.uniform(0, 2)
        while y < 2.6:
            long = rng.uniform(1.6, 2.8)
            plank = box(0.148, long - 0.002, 0.02, 0.0015, 1).uv(1, 1, rng.uniform(0, 3), rng.uniform(0, 3))
            boards.append(plank.at(x + 0.075, y + long / 2, 0.0))
            y += long
    stage.put(join(boards), "Floor", ["floor"])
    walls = [slab(-2.8, -2.6, -2.4, 2.6, 0, 2.8), slab(2.6, 2.8, -2.4, 2.6, 0, 2.8), slab(-2.8, 2.8, 2.6, 2.8, 0, 2.8)]
    stage.put(join([*walls, slab(-2.8, 2.8, -2.6, -2.4, 0, 2.8)]), "Walls", ["plaster"])
    stage.put(slab(-2.8, 2.8, -2.6, 2.8, 2.8, 3.0), "Ceiling", ["ceiling"])
    stage.put(slab(-2.6, 2.6, 2.58, 2.6, 0.01, 0.16, 0.005), "Skirting", ["paint"])
    u, v, uvs = unit_grid(17, 33)
    rug = grid(np.stack([(u - 0.5) * 2.1, (v - 0.5) * 3.1, 0.012 + 0.001 * np.sin(9 * u)], -1), uvs)
    stage.put(rug, "Rug", ["rug"], rz=90, y=0.15)
    seat = stage.mesh(props.chair(), "Chair", ["mahogany"])
    stage.again(seat, "Chair of black", turned((0.06, 0.78, 0.01), 8.0))
    stage.again(seat, "Chair of white", turned((1.15, -0.25, 0.01), -112.0))
    shape, shelves = house.bookcase(1.7, 2.1, 0.32, 5)
    stage.put(shape, "Bookcase", ["dark wood"], x=-2.25, y=2.58, z=0.01)
    kinds = [
        (stage.mesh(s, f"Book {k}", ["books", "pages"]), t, d)
        for k, (s, t, _, d) in enumerate(house.book_prototypes(20, 4))
    ]
    for level, z in enumerate(shelves):
        for x_from, x_to in ((-2.2, -1.43), (-1.37, -0.6)):
            x = x_from
            while x < x_to - 0.06 - (0.2 if (level + (x_from > -2)) % 3 == 0 else 0):
                mesh, thick, deep = kinds[rng.integers(len(kinds))]
                stage.again(mesh, f"Book on shelf {level}", turned((x, 2.32 + rng.uniform(0, 0.02), z + 0.012), 0.0))
                x += thick + 0.0015
    stage.put(props.picture(0.8, 0.6, 0.08), "Painting", ["brass", "painting"], x=0.62, y=2.57, z=1.62)
    stage.put(house.table(1.1, 0.4, 0.82), "Console", ["dark wood"], x=0.62, y=2.36)
    stage.put(props.globe(), "Globe", ["globe", "brass", "dark wood"], x=0.35, y=2.36, z=0.82, rz=40)
    stage.put(props.plant(5), "Plant", ["leaf", "stem", "terracotta", "soil"], x=0.95, y=2.36, z=0.82)
    stage.put(props.armchair(), "Armchair", ["leather", "dark wood", "brass"], x=1.75, y=1.75, rz=-38)
    stage.put(props.floor_lamp(1.6), "Floor lamp", ["brass", "linen"], x=1.4, y=2.3)


def _table(stage: Stage) -> None:
    top = lathe([(0, 0.0), (0.50, 0.0), (0.52, 0.008), (0.52, 0.022), (0.50, 0.03), (0, 0.03)], 128, 0.006, steps=4)
    top.uvs = np.concatenate([top.verts[list(f)][:, [1, 0]] for f in top.faces])
    stage.put(top, "Table top", ["oak"], z=TABLE - 0.03)
    foot = lathe(
        [(0, 0), (0.30, 0), (0.30, 0.03), (0.10, 0.07), (0.05, 0.12), (0.075, 0.25), (0.06, 0.4), (0.045, 0.5), (0.12, 0.66), (0.2, 0.69), (0, 0.69)],
        64, 0.02, steps=4,
    )  # fmt: skip
    stage.put(foot, "Table foot", ["oak"], z=0.01)


def _light(stage: Stage) -> None:
    stage.lamp(
        "Window", "AREA", (-2.5, -0.2, 1.7), 300.0, (0.9, 0.95, 1.0), aim=(0.2, 0.1, 0.7),
        shape="RECTANGLE", size=1.6, size_y=1.7,
    )  # fmt: skip
    stage.lamp("Lamp", "POINT", (1.4, 2.3, 1.5), 40.0, (1.0, 0.68, 0.4), shadow_soft_size=0.09)
    stage.lamp("Behind", "AREA", (1.4, -2.2, 2.2), 110.0, (1.0, 0.88, 0.72), aim=(0, 0.3, 0.8), shape="DISK", size=1.0)
    plain_world(stage, (0.5, 0.6, 0.8), 0.08)


def build(view: str) -> Stage:
    """The game in its room, or the row."""
    stage = Stage("Chess")
    top = TABLE + THICK
    _table(stage)
    _board(stage, top)
    _room(stage)
    if view == "table":
        _game(stage, top)
        dial = principled("Dial", color=packed_image("dial", paint.clock_face(512)), roughness=0.3)
        stage.put(_clock(), "Clock", ["mahogany", dial, "brass"], x=-0.37, y=0.08, z=TABLE, rz=62)
        glass = lathe(
            [(0, 0), (0.028, 0), (0.031, 0.004), (0.036, 0.095), (0.034, 0.095), (0.029, 0.01), (0, 0.008)], 64, 0.002
        )
        stage.put(glass, "Cup", ["white"], x=0.36, y=-0.12, z=TABLE)
        stage.camera((0.0, -1.22, 1.38), (0.0, 0.02, 0.765), 80.0, (48.0, 36.0), None, 8.0)
        stage.targets(board=(0.0, 0.0, top))
    else:
        meshes = _pieces(stage)
        order = ("rook", "knight", "bishop", "queen", "king", "bishop", "knight", "rook")
        for k, kind in enumerate(order):
            colour = "white" if k % 2 == 0 else "black"
            spot = ((k - 3.5) * SQUARE, -0.5 * SQUARE, top)
            stage.again(
                meshes[colour, kind], f"{kind.capitalize()} {k}", turned(spot, 18.0 if kind == "knight" else 0.0)
            )
        # A strip of marquetry on edge before the row: detail of one kind at one depth, from side to side.
        woods = np.array([(0.30, 0.21, 0.15), (0.75, 0.63, 0.46), (0.52, 0.27, 0.19)])
        cells = np.random.default_rng(8).integers(0, 3, (7, 250))
        inlay = packed_image("strip", np.kron(woods[cells], np.ones((8, 8, 1))))
        u, v, uvs = unit_grid(2, 2)
        face = np.stack([(u - 0.5) * 0.5, 0 * u, 0.014 * v], -1)
        paper = principled("Marquetry", color=inlay, roughness=0.5)
        stage.put(grid(face, uvs), "Strip", [paper], y=-1.0 * SQUARE, z=top)
        stage.camera((0.0, -0.5 * SQUARE - 0.9, 1.0), (0.0, -0.5 * SQUARE, top + 0.032), 80.0, (40.0, 20.0), None, 2.0)
        stage.targets(row=(0.0, -0.5 * SQUARE, top + 0.032))
    _light(stage)
    return stage


if __name__ == "__main__":
    main(build, ("table", "row"))
