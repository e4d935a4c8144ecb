"""The rooms around the desk: walls, window, doorway, bookcase and what stands far away."""

import numpy as np

from demo_mesh import box, catenary, frame, join, lathe, tube
from demo_props import book

# The study. The camera stands at the origin of X, a little in front of the desk, and looks along +Y.
LEFT, RIGHT, NEAR, BACK = -1.9, 2.7, -2.6, 4.2
CEILING = 2.75
WALL = 0.20
# Two windows in the left wall, (y0, y1, z0, z1): the first lights the desk, the second is in the picture.
WINDOWS = ((-0.95, 0.95, 0.80, 2.35), (1.75, 3.95, 0.80, 2.38))
DOOR = (-1.22, -0.30, 2.12)
# The far room behind the doorway.
FAR_LEFT, FAR_RIGHT, FAR_BACK = -2.05, 2.4, 10.7


def slab(x0, x1, y0, y1, z0, z1, bevel=0.0):
    """A box between coordinates."""
    shape = box(x1 - x0, y1 - y0, z1 - z0, bevel, 2)
    return shape.at((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)


def walls():
    """All masonry; rounded reveals. One slot."""
    parts, y = [], NEAR
    for y0, y1, z0, z1 in WINDOWS:
        parts.append(slab(LEFT - WALL, LEFT, y, y0, 0, CEILING, 0.008))
        parts.append(slab(LEFT - WALL, LEFT, y0 - 0.01, y1 + 0.01, 0, z0, 0.008))
        parts.append(slab(LEFT - WALL, LEFT, y0 - 0.01, y1 + 0.01, z1, CEILING, 0.008))
        y = y1
    parts.append(slab(LEFT - WALL, LEFT, y, BACK + WALL, 0, CEILING, 0.008))
    x0, x1, top = DOOR
    parts += [
        slab(LEFT - 0.01, x0, BACK, BACK + WALL, 0, CEILING, 0.008),
        slab(x1, RIGHT + WALL, BACK, BACK + WALL, 0, CEILING, 0.008),
        slab(x0 - 0.01, x1 + 0.01, BACK, BACK + WALL, top, CEILING, 0.008),
        slab(RIGHT, RIGHT + WALL, NEAR, BACK, 0, CEILING),
        slab(LEFT - WALL, RIGHT + WALL, NEAR - WALL, NEAR, 0, CEILING),
        slab(FAR_LEFT - WALL, FAR_LEFT, BACK, FAR_BACK, 0, CEILING),
        slab(FAR_RIGHT, FAR_RIGHT + WALL, BACK + WALL, FAR_BACK, 0, CEILING),
        slab(FAR_LEFT - WALL, FAR_RIGHT + WALL, FAR_BACK, FAR_BACK + WALL, 0, CEILING),
    ]
    return join(parts)


def ceilings():
    """The ceilings of both rooms, with beams."""
    parts = [
        slab(LEFT - WALL, RIGHT + WALL, NEAR - WALL, BACK + WALL, CEILING, CEILING + 0.1),
        slab(FAR_LEFT - WALL, FAR_RIGHT + WALL, BACK, FAR_BACK + WALL, CEILING, CEILING + 0.1),
    ]
    return join(parts)


def floor():
    """Boards one by one, each a bevelled plank. Texture V along the boards (Y); one slot."""
    rng = np.random.default_rng(4)
    parts, width = [], 0.145
    for x in np.arange(FAR_LEFT - WALL, RIGHT, width):
        y = NEAR - rng.uniform(0, 2)
        while y < FAR_BACK:
            length = rng.uniform(1.6, 2.8)
            plank = box(width - 0.002, length - 0.002, 0.02, 0.0015, 1)
            plank = plank.uv(1, 1, rng.uniform(0, 3), rng.uniform(0, 3))
            parts.append(plank.at(x + width / 2, y + length / 2, -0.01 + rng.normal(0, 0.0004)))
            y += length
    return join(parts)


def window_joinery(y0, y1, z0, z1, columns=3, rows=3):
    """Casing, open sashes' bars and the sill of a window in the left wall (no panes: it stands open)."""
    w, h = y1 - y0, z1 - z0
    casing = frame(w + 0.16, h + 0.16, 0.09, 0.03, 0.006).at(rz=90).at(LEFT + 0.012, (y0 + y1) / 2, (z0 + z1) / 2)
    outer = frame(w, h, 0.055, 0.06, 0.004).at(rz=90).at(LEFT - 0.14, (y0 + y1) / 2, (z0 + z1) / 2)
    sill = slab(LEFT - WALL, LEFT + 0.07, y0 - 0.10, y1 + 0.10, z0 - 0.035, z0 + 0.004, 0.006)
    parts = [casing, outer, sill]
    for k in range(1, columns):
        wide = 0.05 if columns % 2 == 0 and k == columns // 2 else 0.022
        parts.append(
            slab(
                LEFT - 0.16,
                LEFT - 0.12,
                y0 + w * k / columns - wide / 2,
                y0 + w * k / columns + wide / 2,
                z0,
                z1,
                0.004,
            )
        )
    for k in range(1, rows):
        parts.append(
            slab(LEFT - 0.155, LEFT - 0.125, y0, y1, z0 + h * k / rows - 0.011, z0 + h * k / rows + 0.011, 0.004)
        )
    return join(parts)


def door_casing():
    """Architrave around the doorway, on both faces of the wall."""
    x0, x1, top = DOOR
    parts = []
    for y in (BACK - 0.014, BACK + WALL + 0.014):
        parts += [
            slab(x0 - 0.11, x0, y - 0.014, y + 0.014, 0, top, 0.005),
            slab(x1, x1 + 0.11, y - 0.014, y + 0.014, 0, top, 0.005),
            slab(x0 - 0.13, x1 + 0.13, y - 0.018, y + 0.018, top, top + 0.12, 0.006),
            slab(x0 - 0.15, x1 + 0.15, y - 0.028, y + 0.028, top + 0.12, top + 0.15, 0.006),
        ]
    parts += [
        slab(x0 - 0.004, x0 + 0.02, BACK - 0.01, BACK + WALL + 0.01, 0, top, 0.004),
        slab(x1 - 0.02, x1 + 0.004, BACK - 0.01, BACK + WALL + 0.01, 0, top, 0.004),
        slab(x0, x1, BACK - 0.01, BACK + WALL + 0.01, top - 0.02, top + 0.004, 0.004),
    ]
    return join(parts)


def bookcase(width, height, depth, shelves):
    """An open bookcase, its back at Y = 0 and front at Y = -depth; returns (shape, shelf heights)."""
    parts = [
        slab(0, 0.032, -depth, 0, 0, height, 0.004),
        slab(width - 0.032, width, -depth, 0, 0, height, 0.004),
        slab(-0.03, width + 0.03, -depth - 0.03, 0, height, height + 0.035, 0.010),
        slab(-0.015, width + 0.015, -depth - 0.015, 0, height - 0.03, height + 0.001, 0.006),
        slab(0.01, width - 0.01, -0.015, -0.003, 0, height),
        slab(width / 2 - 0.014, width / 2 + 0.014, -depth + 0.01, 0, 0.05, height, 0.003),
    ]
    heights = []
    for k in range(shelves):
        z = 0.08 + k * (height - 0.12) / shelves
        parts.append(slab(0.02, width - 0.02, -depth + 0.006, -0.005, z, z + 0.026, 0.003).uv(1, 1, 0.3 * k, 0))
        heights.append(z + 0.026)
    return join(parts), heights


def book_prototypes(count, seed):
    """Book shapes of many sizes and bindings: list of (shape, thickness, height, depth)."""
    rng = np.random.default_rng(seed)
    result = []
    for k in range(count):
        height = rng.choice([0.185, 0.21, 0.235, 0.26]) * rng.uniform(0.97, 1.03)
        thickness = rng.uniform(0.018, 0.055)
        depth = height * rng.uniform(0.64, 0.72)
        result.append((book(depth, height, thickness, k % 16), thickness, height, depth))
    return result


def table(width, depth, height):
    """A heavy table: top of four boards on turned legs, front edge at -Y. Grain along X; one slot."""
    parts, boards = [], 4
    rng = np.random.default_rng(7)
    for k in range(boards):
        y = (k + 0.5) * depth / boards - depth / 2
        plank = box(width + rng.normal(0, 0.001), depth / boards - 0.0009, 0.036, 0.0022, 3, grain="x")
        # Keep each board within its own quarter of the texture.
        parts.append(
            plank.uv(1, 1, rng.uniform(0, 2), rng.uniform(0, 2)).at(0, y, height - 0.018 + rng.normal(0, 0.0002))
        )
    parts.append(box(width - 0.14, depth - 0.12, 0.10, 0.004, grain="x").at(z=height - 0.086))
    leg = lathe(
        [
            (0, 0),
            (0.026, 0),
            (0.034, 0.03),
            (0.022, 0.05),
            (0.030, 0.20),
            (0.040, 0.42),
            (0.024, 0.50),
            (0.042, 0.53),
            (0.042, height - 0.05),
            (0, height - 0.05),
        ],
        48,
        0.012,
    ).uv(0.2, 1)
    parts += [
        leg.at(x, y) for x in (-width / 2 + 0.09, width / 2 - 0.09) for y in (-depth / 2 + 0.09, depth / 2 - 0.09)
    ]
    return join(parts)


def hung_lights(path_points, spacing, start=0.0):
    """Points at equal steps along a polyline, and the steps' arc lengths."""
    path = np.array(path_points)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    at = np.arange(start, length[-1], spacing)
    return np.stack([np.interp(at, length, path[:, k]) for k in range(3)], axis=-1)


def spans(anchors, sags, per_span=40):
    """A cable over several anchors, each span a catenary."""
    pieces = [catenary(a, b, s, per_span) for a, b, s in zip(anchors, anchors[1:], sags, strict=False)]
    return np.concatenate([pieces[0], *[p[1:] for p in pieces[1:]]])


def wire(path, radius=0.0015):
    """The cable itself."""
    return tube(path, radius, 6)


def wall_clock(radius=0.16):
    """A round clock facing -Y, centred: 0 wood case, 1 brass bezel, 2 dial (UV 0..1)."""
    case = lathe(
        [(0, -0.05), (radius * 1.2, -0.05), (radius * 1.25, -0.02), (radius * 1.1, 0.0), (radius, 0.0)], 96, 0.012
    )
    bezel = lathe(
        [(radius * 1.02, 0.0), (radius * 1.02, 0.014), (radius * 0.95, 0.012), (radius * 0.94, 0.002)], 96, 0.004
    ).slot(1)
    dial = lathe([(radius * 0.96, 0.002), (0, 0.002)], 72).slot(2)
    dial.uvs = np.concatenate([dial.verts[list(f)][:, :2] / (2 * radius * 0.96) + 0.5 for f in dial.faces])
    # Turned to face -Y with 12 up: the lathe's Z becomes -Y and its Y becomes Z.
    return join([case, bezel, dial]).at(rx=90)
