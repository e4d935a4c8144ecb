"""Things on and around the desk: every function returns a `Shape` standing on Z = 0, or a list of them.

Slots are numbered per prop and named in the docstrings; `make_demo.py` gives them materials.
"""

import math

import numpy as np

from demo_mesh import (
    Shape,
    ball,
    box,
    circle_outline,
    frame,
    grid,
    icosphere,
    join,
    lathe,
    lens_profile,
    prism,
    smooth_path,
    soft_box,
    square_outline,
    tube,
    unit_grid,
)


def knurled(profile, teeth=48, depth=0.0006, round_radius=0.0008):
    """A turned knob whose rim is fluted; UV as `lathe`."""
    shape = lathe(profile, teeth * 4, round_radius, steps=2)
    rim = max(p[0] for p in profile)
    x, y = shape.verts[:, 0], shape.verts[:, 1]
    radius = np.hypot(x, y)
    flute = (np.cos(np.arctan2(y, x) * teeth) - 1) * depth * (radius > 0.9 * rim)
    scale = np.where(radius > 1e-9, (radius + flute) / np.maximum(radius, 1e-9), 1.0)
    shape.verts = shape.verts * np.stack([scale, scale, np.ones_like(scale)], axis=-1)
    return shape


def knob(radius, thickness):
    """A fluted brass knob along Z with a domed face."""
    return knurled(
        [(0, 0), (radius * 0.5, 0), (radius * 0.5, thickness * 0.3), (radius, thickness * 0.35)]
        + [(radius, thickness), (radius * 0.6, thickness * 1.1), (0, thickness * 1.15)],
        teeth=30,
    )


def screw(radius=0.003):
    """A domed screw head with a slot, along Z."""
    dome = lathe([(radius, 0), (radius, radius * 0.3), (radius * 0.7, radius * 0.6), (0, radius * 0.7)], 20)
    return join([dome, box(radius * 1.7, radius * 0.25, radius * 0.2, 0).at(z=radius * 0.64).slot(1)])


def portrait_lens():
    """A brass portrait lens along +Z from its flange: 0 brass, 1 black, 2 glass, 3 engraved brass."""
    outer = lathe(
        [(0.030, 0.0), (0.056, 0.0), (0.056, 0.006), (0.0415, 0.007), (0.0415, 0.030), (0.0445, 0.0315)]
        + [(0.0445, 0.034), (0.0405, 0.036), (0.0405, 0.052)],
        128,
        0.0012,
    )
    ring = knurled([(0.0405, 0.052), (0.0448, 0.0525), (0.0448, 0.066), (0.0405, 0.0665)], 64, 0.0009)
    barrel = lathe([(0.0405, 0.0665), (0.0405, 0.098), (0.0472, 0.102), (0.0472, 0.108)], 128, 0.0012)
    name = lathe([(0.0472, 0.108), (0.0472, 0.134)], 128).uv(1, 1 / 0.026).slot(3)
    lip = lathe([(0.0472, 0.134), (0.0486, 0.1345), (0.0486, 0.1385), (0.0455, 0.1390), (0.0445, 0.131)], 128, 0.0008)
    retainer = knurled([(0.0445, 0.131), (0.0445, 0.124), (0.0402, 0.1235), (0.0392, 0.1190)], 60, 0.0005)
    tube_inside = lathe(
        [(0.0392, 0.119), (0.0392, 0.100), (0.037, 0.098), (0.037, 0.070), (0.026, 0.068), (0.026, 0.066)]
        + [(0.037, 0.064), (0.037, 0.02), (0.0, 0.02)],
        96,
    ).slot(1)
    glass = [
        lathe(lens_profile(0.0388, 0.017, 0.006, 24), 128).at(z=0.1125).slot(2),
        lathe(lens_profile(0.036, 0.013, 0.005, 20), 96).at(z=0.040).slot(2),
    ]
    parts = [outer, ring, barrel, name, lip, retainer, tube_inside, *glass]
    for k in range(3):
        t = 2 * math.pi * k / 3 + 0.5
        parts.append(screw(0.0032).at(0.0495 * math.cos(t), 0.0495 * math.sin(t), 0.006))
    shaft = lathe([(0.004, 0), (0.004, 0.016)], 24)
    pinion = join([shaft, knob(0.0115, 0.008).at(z=0.016), box(0.03, 0.02, 0.007, 0.002).at(z=0.0015)])
    parts.append(pinion.at(z=0.083, x=0.039, ry=90))
    return join(parts)


def bellows(front, back, y_front, y_back, pleats=12, depth=0.017):
    """A tapering square bellows along Y with cut corners, folds as real pleats; UV in metres."""
    rows, around = pleats * 10 + 1, 4 * 22
    t = np.linspace(0, 1, rows)[:, None]
    turn = (np.arange(around) / around * 2 * math.pi)[None, :]
    c, s = np.cos(turn), np.sin(turn)
    power = 9.0
    unit = 1 / (np.abs(c) ** power + np.abs(s) ** power) ** (1 / power)
    wave = 1 - np.abs(((t * pleats) % 1) * 2 - 1) ** 2.2
    # The folds flatten towards the cut corners.
    corner = np.abs(np.sin(2 * turn))
    fold = (wave - 0.5) * depth * (1 - 0.35 * corner**8)
    half = back * t + front * (1 - t)
    radius = (half + fold) * unit
    sag = -0.006 * np.sin(math.pi * t) * np.ones_like(turn)
    points = np.stack([radius * c, (y_front + (y_back - y_front) * t) * np.ones_like(turn), radius * s + sag], axis=-1)
    u, v = np.meshgrid(np.linspace(0, 0.8, around + 1), np.linspace(0, 0.4, rows))
    return grid(points, np.stack([u, v], axis=-1), closed_u=True)


def field_camera():
    """A folding field camera looking along -Y: 0 mahogany, 1 brass, 2 bellows, 3 black, 4 glass, 5 engraved."""
    mahogany, brass_parts, others = [], [], []
    axis_z, front_y, back_y = 0.160, -0.125, 0.135
    mahogany += [
        box(0.176, 0.40, 0.014, 0.003, grain="y").at(z=0.011),
        box(0.016, 0.40, 0.012, 0.002, grain="y").at(x=0.080, z=0.024),
        box(0.016, 0.40, 0.012, 0.002, grain="y").at(x=-0.080, z=0.024),
        box(0.150, 0.05, 0.012, 0.002, grain="x").at(y=front_y, z=0.025),
        box(0.25, 0.07, 0.014, 0.003, grain="x").at(y=back_y, z=0.025),
        frame(0.262, 0.262, 0.024, 0.052, 0.003).at(y=back_y, z=0.032 + 0.131),
        frame(0.240, 0.240, 0.018, 0.018, 0.002).at(y=back_y + 0.036, z=0.032 + 0.131),
        box(0.215, 0.006, 0.215, 0.001).at(y=back_y + 0.022, z=0.032 + 0.131),
        frame(0.192, 0.192, 0.017, 0.020, 0.002).at(y=front_y, z=axis_z),
        prism(square_outline(0.080), 0.012, 0.0015, holes=[circle_outline(0.034)]).at(y=front_y - 0.006, z=axis_z),
    ]
    pleats = bellows(0.076, 0.103, front_y + 0.012, back_y - 0.028).at(z=axis_z + 0.001).slot(2)
    lens = portrait_lens()
    lens_slots = np.array([1, 3, 4, 5])[lens.slots]
    lens = Shape(lens.verts, lens.faces, lens.uvs, lens_slots.astype(np.int32)).at(y=front_y - 0.012, z=axis_z, rx=90)
    for side in (-1, 1):
        brass_parts += [
            box(0.004, 0.40, 0.003, 0.0008).at(x=side * 0.080, z=0.0315),
            box(0.005, 0.020, 0.185, 0.001).at(x=side * 0.1005, y=front_y, z=0.118),
            box(0.005, 0.034, 0.014, 0.001).at(x=side * 0.1005, y=front_y, z=0.032),
            box(0.003, 0.024, 0.30, 0.001).at(x=side * 0.1335, y=back_y - 0.055, z=0.150, rx=24),
            knob(0.013, 0.009).at(x=side * 0.103, y=front_y, z=0.160, ry=side * 90),
            knob(0.010, 0.007).at(x=side * 0.103, y=front_y, z=0.050, ry=side * 90),
            knob(0.012, 0.009).at(x=side * 0.135, y=back_y - 0.008, z=0.215, ry=side * 90),
            knob(0.017, 0.012).at(x=side * 0.096, y=0.02, z=0.016, ry=side * 90),
            lathe([(0.005, 0), (0.005, 0.02)], 24).at(x=side * 0.078, y=0.02, z=0.016, ry=side * 90),
        ]
        for k in range(88):
            brass_parts.append(box(0.007, 0.0022, 0.0028, 0).at(x=side * 0.066, y=-0.19 + k * 0.0043, z=0.0195))
        for z in (0.045, 0.105, 0.197):
            brass_parts.append(screw(0.0028).at(x=side * 0.1031, y=front_y, z=z, ry=side * 90))
        for y in (-0.185, -0.06, 0.06, 0.185):
            brass_parts.append(screw(0.0026).at(x=side * 0.080, y=y, z=0.0328))
        for top in (-1, 1):
            corner = prism(
                [(0, 0), (0.034, 0), (0.034, -0.010), (0.018, -0.014), (0.014, -0.018), (0.010, -0.034), (0, -0.034)],
                0.002,
                0.0006,
            )
            flip = corner.verts * [-side, 1, top]
            plate = Shape(flip, corner.faces, corner.uvs, corner.slots)
            x, z = side * 0.130, 0.163 + top * 0.130
            brass_parts.append(plate.at(x, back_y - 0.0266, z))
            for dx, dz in ((0.006, 0.006), (0.028, 0.005), (0.005, 0.028)):
                brass_parts.append(screw(0.0022).at(x - side * dx, back_y - 0.0274, z - top * dz, rx=90))
            lens_corner = box(0.014, 0.0016, 0.014, 0.0005).at(side * 0.072, front_y - 0.0126, axis_z + top * 0.072)
            brass_parts += [
                lens_corner,
                screw(0.0022).at(side * 0.072, front_y - 0.0134, axis_z + top * 0.072, rx=90),
            ]
    brass_parts.append(box(0.05, 0.004, 0.012, 0.001).at(y=front_y - 0.012, z=axis_z + 0.090))
    strap = smooth_path([(-0.075, 0, 0), (-0.06, 0, 0.016), (0, 0, 0.024), (0.06, 0, 0.016), (0.075, 0, 0)], 40)
    handle = tube(strap, 0.0055, 12)
    handle.verts = handle.verts * [1, 1.9, 1]
    others.append(handle.at(y=back_y, z=0.294).slot(2))
    for side in (-1, 1):
        brass_parts.append(
            lathe([(0.011, 0), (0.011, 0.003), (0.005, 0.006), (0, 0.0065)], 32).at(side * 0.075, back_y, 0.293)
        )
    feet = [
        lathe([(0, 0), (0.009, 0), (0.009, 0.005), (0, 0.005)], 24).at(x, y, -0.001)
        for x in (-0.07, 0.07)
        for y in (-0.17, 0.17)
    ]
    brass_shape = join(brass_parts + feet)
    brass_shape.slots = np.where(brass_shape.slots == 1, 3, 1).astype(np.int32)
    return join([join(mahogany).slot(0), brass_shape, pleats, lens, *others])


def book(depth, height, thickness, cell, wobble=0.0):
    """An upright book, spine towards -Y, thickness along X: 0 cover (atlas cell), 1 pages."""
    board, hinge, arc = 0.0026, 0.006, []
    steps = 9
    bulge = min(0.010, thickness * 0.22)
    for k in range(steps + 1):
        t = k / steps
        arc.append((thickness * t, -bulge * math.sin(math.pi * t)))
    outer = [(0, depth), (0, hinge), *arc, (thickness, hinge), (thickness, depth)]
    inner = [(thickness - board, depth), (thickness - board, hinge)]
    inner += [
        (board + (thickness - 2 * board) * (1 - k / 4), board * 0.9 - bulge * 0.8 * math.sin(math.pi * k / 4))
        for k in range(5)
    ]
    inner += [(board, hinge), (board, depth)]
    cover = prism(outer + inner, height, 0.0008, 2)
    # The prism runs along Y: stand it up so that the outline lies in XY.
    v = cover.verts
    cover.verts = np.stack([v[:, 0], v[:, 2], v[:, 1] + height / 2], axis=-1)
    column, row = cell % 4, 3 - cell // 4
    uvs = []
    for face in cover.faces:
        p = cover.verts[list(face)]
        middle = p.mean(axis=0)
        along, z = p[:, 1] / depth, p[:, 2] / height
        on_spine = middle[1] < hinge * 0.8 and 0.12 < middle[0] / thickness < 0.88
        if on_spine or middle[1] < -0.0005:
            u = 0.4 + 0.2 * np.clip(p[:, 0] / thickness, 0, 1)
        elif middle[0] < thickness / 2:
            u = 0.4 * (1 - np.clip(along, 0, 1))
        else:
            u = 0.6 + 0.4 * np.clip(along, 0, 1)
        uvs.append(np.stack([(column + 0.01 + 0.98 * u) / 4, (row + 0.01 + 0.98 * np.clip(z, 0, 1)) / 4], axis=-1))
    cover.uvs = np.concatenate(uvs)
    block = box(thickness - 2 * board - 0.0004, depth - 0.012, height - 0.007, 0.0007, 1)
    block = block.at(thickness / 2, depth / 2 + 0.001, height / 2).slot(1)
    bands = []
    if thickness > 0.028:
        for z in (0.16, 0.34, 0.52, 0.70, 0.86):
            path = [(thickness * t, -bulge * math.sin(math.pi * t) - 0.0002, 0) for t in np.linspace(0.03, 0.97, 12)]
            band = tube(path, 0.0016, 8).at(z=z * height)
            u_band = (column + 0.5 + 0.0 * band.uvs[:, 0]) / 4
            band.uvs = np.stack([u_band, np.full(len(u_band), (row + z) / 4)], axis=-1)
            bands.append(band)
    shape = join([cover, block, *bands])
    if wobble:
        shape.verts = shape.verts + wobble * np.sin(shape.verts[:, [2, 0, 1]] * 25)
    return shape


def open_notebook(width=0.30, height=0.21):
    """An open notebook lying flat: 0 spread (UV 0..1), 1 page edges, 2 leather cover, 3 ribbon."""
    u, v, uvs = unit_grid(65, 25)
    x = (u - 0.5) * width
    t = np.abs(u - 0.5) * 2
    rise = 0.004 + 0.013 * np.exp(-((t - 0.28) ** 2) / 0.05) * (1 - np.exp(-t * 14)) + 0.004 * (1 - t)
    curl = 0.010 * np.clip(u - 0.93, 0, 1) * 14 * v**3
    top = np.stack([x, (v - 0.5) * height, rise + curl], axis=-1)
    pages = grid(top, uvs)
    edge = []
    for line, axis in ((top[0], 0), (top[-1], 0), (top[:, 0], 1), (top[:, -1], 1)):
        low = line * [1, 1, 0] + [0, 0, 0.003]
        along = line[:, axis]
        strip_uvs = np.stack([np.stack([along, along * 0 + v0], -1) for v0 in (0.0, 0.02)])
        edge.append(grid(np.stack([low, line]), strip_uvs).slot(1))
    cover = box(width + 0.012, height + 0.012, 0.003, 0.0012).at(z=0.0016).slot(2)
    ribbon = smooth_path(
        [
            (0.002, height / 2, 0.014),
            (0.01, 0, 0.016),
            (0.03, -height / 2, 0.012),
            (0.05, -height / 2 - 0.04, 0.001),
            (0.06, -height / 2 - 0.07, 0.001),
        ],
        60,
    )
    strip = tube(ribbon, 0.003, 6).slot(3)
    return join([pages, *edge, cover, strip])


def tumbler():
    """A cut whisky tumbler; returns (glass, liquid). The liquid overlaps the glass by a hair."""
    glass = lathe(
        [(0, 0), (0.034, 0), (0.0365, 0.004), (0.040, 0.090), (0.0385, 0.0915), (0.0372, 0.090)]
        + [(0.0342, 0.020), (0.031, 0.0165), (0, 0.0155)],
        144,
        0.0022,
        steps=6,
    )
    v = glass.verts
    radius, angle = np.hypot(v[:, 0], v[:, 1]), np.arctan2(v[:, 1], v[:, 0])
    outside = (radius > 0.0345) & (v[:, 2] > 0.006) & (v[:, 2] < 0.056) & (radius > 0.0346 + 0.03 * (v[:, 2] - 0.02))
    facet = np.abs(np.sin(angle * 9 + v[:, 2] * 55)) + np.abs(np.sin(angle * 9 - v[:, 2] * 55))
    cut = np.where(outside, 1 - 0.0011 * (2 - facet) / np.maximum(radius, 1e-6), 1.0)
    glass.verts = v * np.stack([cut, cut, np.ones_like(cut)], axis=-1)
    liquid = lathe(
        [
            (0, 0.0152),
            (0.0312, 0.0162),
            (0.0345, 0.020),
            (0.0353, 0.0445),
            (0.0348, 0.0432),
            (0.033, 0.0428),
            (0, 0.0428),
        ],
        96,
        0.001,
    )
    return glass, liquid


def decanter():
    """A stoppered bottle of clear glass; returns (glass, liquid)."""
    glass = lathe(
        [(0, 0.004), (0.03, 0.0), (0.047, 0.001), (0.052, 0.012), (0.050, 0.115), (0.040, 0.145), (0.0165, 0.165)]
        + [(0.0150, 0.205), (0.0215, 0.211), (0.0205, 0.215), (0.0115, 0.214), (0.0110, 0.170), (0.035, 0.142)]
        + [(0.0455, 0.113), (0.0475, 0.020), (0.043, 0.011), (0, 0.013)],
        96,
        0.008,
        steps=6,
    )
    stopper = lathe(
        [
            (0, 0.19),
            (0.0095, 0.19),
            (0.0108, 0.215),
            (0.010, 0.222),
            (0.022, 0.240),
            (0.023, 0.250),
            (0.014, 0.268),
            (0, 0.270),
        ],
        12,
        0.001,
    )
    liquid = lathe(
        [(0, 0.0128), (0.0432, 0.0108), (0.0478, 0.020), (0.0467, 0.085), (0.046, 0.0835), (0, 0.0835)], 96, 0.002
    )
    return join([glass, stopper]), liquid


def loupe():
    """A magnifying glass lying down, handle along -Y: 0 brass, 1 glass, 2 dark wood."""
    ring = lathe([(0.043, -0.004), (0.0475, -0.004), (0.0475, 0.004), (0.043, 0.004)], 128, 0.001, closed=True)
    glass = lathe(lens_profile(0.0434, 0.011, 0.003, 20), 128).slot(1)
    ferrule = lathe(
        [(0, 0.045), (0.005, 0.046), (0.0065, 0.052), (0.005, 0.060), (0.0075, 0.064), (0.0075, 0.078)], 48, 0.001
    ).at(rx=90)
    grip = (
        lathe(
            [(0.0068, 0.078), (0.0085, 0.095), (0.0075, 0.120), (0.0095, 0.150), (0.0085, 0.166), (0, 0.170)], 48, 0.006
        )
        .at(rx=90)
        .slot(2)
    )
    return join([ring, glass, ferrule, grip]).at(z=0.0085)


def optical_element(radius, centre, edge):
    """A loose lens in a thin brass cell lying flat: 0 glass, 1 brass."""
    glass = lathe(lens_profile(radius, centre, edge, 12), 80).at(z=edge / 2 + 0.002)
    cell = lathe(
        [(radius - 0.0004, 0.0), (radius + 0.002, 0.0), (radius + 0.002, edge + 0.002), (radius - 0.0006, edge + 0.002)],
        96, 0.0005, closed=True,
    )  # fmt: skip
    return join([glass, cell.slot(1)])


def pocket_watch():
    """A pocket watch lying open face up: 0 brass, 1 dial (UV 0..1), 2 glass."""
    case = lathe(
        [
            (0, 0),
            (0.012, 0.0005),
            (0.021, 0.004),
            (0.0235, 0.007),
            (0.0235, 0.0085),
            (0.0215, 0.0115),
            (0.0200, 0.0118),
            (0.0198, 0.010),
            (0, 0.0098),
        ],
        128,
        0.0012,
    )
    dial = lathe([(0.0197, 0.0102), (0, 0.0102)], 96).slot(1)
    dial.uvs = np.concatenate([dial.verts[list(f)][:, :2] / (2 * 0.0197) + 0.5 for f in dial.faces])
    glass = lathe(
        [
            (0.0200, 0.0115),
            (0.018, 0.0128),
            (0.010, 0.0138),
            (0, 0.0141),
            (0, 0.0134),
            (0.010, 0.0131),
            (0.018, 0.0121),
            (0.0195, 0.0113),
        ],
        96,
        0.001,
    ).slot(2)
    stem = join(
        [
            lathe([(0.0024, 0), (0.0024, 0.004)], 24),
            knurled([(0, 0.004), (0.0042, 0.0042), (0.0042, 0.0085), (0, 0.0092)], 24, 0.0004),
        ]
    )
    stem = stem.at(y=0.0225, z=0.0075, rx=-90)
    turn = np.linspace(-2.2, 2.2, 40)
    bow = tube(
        np.stack([0.0085 * np.sin(turn), 0.0335 + 0.0075 * np.cos(turn), np.full(40, 0.0075)], axis=-1), 0.0010, 12
    )
    return join([case, dial, glass, stem, bow])


def chain(path, link=0.0055, wire=0.0007):
    """A curb chain along a path of points on the table."""
    count = int(np.linalg.norm(np.diff(np.array(path), axis=0), axis=1).sum() / (link * 0.78))
    points = smooth_path(path, count)
    turn = np.linspace(0, 2 * math.pi, 12, endpoint=False)
    oval = np.stack([link * 0.55 * np.cos(turn), link * 0.34 * np.sin(turn), np.zeros(12)], axis=-1)
    ring = tube(oval, wire, 6, closed=True)
    links = []
    for k in range(count):
        direction = points[min(k + 1, count - 1)] - points[max(k - 1, 0)]
        yaw = math.degrees(math.atan2(direction[1], direction[0]))
        links.append(ring.at(rx=20 + 70 * (k % 2)).at(*points[k], rz=yaw).at(z=0.0014))
    return join(links)


def fountain_pen():
    """A capped-off pen along +X: 0 black resin, 1 brass."""
    body = lathe(
        [
            (0, -0.068),
            (0.0035, -0.0675),
            (0.0062, -0.05),
            (0.0066, 0.0),
            (0.0062, 0.03),
            (0.0045, 0.036),
            (0.0042, 0.052),
            (0.003, 0.054),
        ],
        48,
        0.004,
    )
    rings = [
        lathe([(r, z), (r + 0.0006, z + 0.0003), (r + 0.0006, z + 0.0014), (r, z + 0.0017)], 48).slot(1)
        for r, z in ((0.0063, 0.024), (0.0064, -0.048), (0.0044, 0.038))
    ]
    u, v, uvs = unit_grid(9, 17)
    width = 0.0032 * (1 - v) ** 0.7 + 0.0001
    nib = grid(
        np.stack(
            [(u - 0.5) * 2 * width, -0.0028 * (1 - (2 * u - 1) ** 2 * 0.8) * (1 - v * 0.8), 0.052 + 0.022 * v], axis=-1
        ),
        uvs,
    ).slot(1)
    return join([body, *rings, nib]).at(ry=90).at(z=0.007)


def pencil(length=0.17):
    """A hexagonal pencil along +Z: 0 paint, 1 bare wood, 2 lead."""
    body = lathe([(0, 0), (0.0036, 0.0004), (0.0036, length - 0.02)], 6)
    cone = lathe([(0.0036, length - 0.02), (0.0011, length - 0.004)], 24).slot(1)
    lead = lathe([(0.0011, length - 0.004), (0.0002, length), (0, length)], 16).slot(2)
    return join([body, cone, lead])


def desk_lamp():
    """A brass desk lamp, shade towards -X and open below: 0 brass, 1 shade outside, 2 shade inside, 3 bulb."""
    base = lathe(
        [
            (0, 0),
            (0.075, 0),
            (0.078, 0.004),
            (0.074, 0.012),
            (0.045, 0.018),
            (0.018, 0.024),
            (0.010, 0.034),
            (0.0065, 0.05),
        ],
        96,
        0.004,
    )
    stem_path = smooth_path(
        [(0, 0, 0.045), (0, 0, 0.20), (0.004, 0, 0.33), (-0.02, 0, 0.412), (-0.075, 0, 0.445), (-0.13, 0, 0.428)], 80
    )
    stem = tube(stem_path, 0.0055, 20)
    collars = [
        lathe([(0.0055, -0.006), (0.009, -0.005), (0.0095, 0), (0.009, 0.005), (0.0055, 0.006)], 48, 0.002).at(z=z)
        for z in (0.06, 0.18, 0.30)
    ]
    shade_profile = [(0.018, 0.052), (0.024, 0.046), (0.040, 0.030), (0.078, -0.030), (0.090, -0.048)]
    outside = lathe(shade_profile + [(0.0915, -0.0495), (0.0905, -0.0510)], 96, 0.008).slot(1)
    inside = lathe(
        [(0.0905, -0.0510)] + [(r - 0.0016, z - 0.0012) for r, z in shade_profile[::-1]] + [(0, 0.051)], 96, 0.004
    ).slot(2)
    cap = lathe([(0.0185, 0.050), (0.0185, 0.066), (0.012, 0.074), (0.007, 0.086), (0, 0.088)], 64, 0.003)
    rim = tube(
        np.stack(
            [
                0.0908 * np.cos(np.linspace(0, 2 * math.pi, 96, endpoint=False)),
                0.0908 * np.sin(np.linspace(0, 2 * math.pi, 96, endpoint=False)),
                np.full(96, -0.0503),
            ],
            -1,
        ),
        0.0014,
        8,
        closed=True,
    )
    bulb = icosphere(0.030, 3).at(z=-0.008).slot(3)
    head = join([outside, inside, cap, rim, bulb]).at(-0.148, 0, 0.372, ry=12)
    return join([base, stem, *collars, head])


def globe():
    """A table globe: 0 map (UV 0..1), 1 brass, 2 dark wood."""
    sphere = ball(0.115, 80, 36).at(rx=23).at(z=0.235)
    turn = np.linspace(-1.75, 1.75, 72)
    arc = np.stack([0.128 * np.cos(turn), np.zeros(72), 0.128 * np.sin(turn)], axis=-1)
    meridian = tube(arc, 0.0045, 10)
    meridian.verts = meridian.verts * [1, 0.6, 1]
    meridian = meridian.at(rz=90).at(rx=23).at(z=0.235).slot(1)
    foot = lathe(
        [
            (0, 0),
            (0.075, 0),
            (0.08, 0.006),
            (0.07, 0.016),
            (0.03, 0.026),
            (0.014, 0.045),
            (0.020, 0.065),
            (0.010, 0.085),
            (0.009, 0.105),
            (0, 0.106),
        ],
        72,
        0.005,
    ).slot(2)
    pins = (
        join([lathe([(0, 0), (0.007, 0), (0.007, 0.008), (0, 0.012)], 24).at(z=z) for z in (0.113, -0.124)])
        .at(rx=23)
        .at(z=0.235)
        .slot(1)
    )
    return join([sphere, meridian, foot, pins])


def leaf_blade(length, width, droop, curl, rng):
    """One leaf from the origin along +Y, rising then drooping; UV 0..1."""
    u, v, uvs = unit_grid(9, 17)
    outline = np.sin(math.pi * v**0.72) ** 0.9 + 0.02
    x = (u - 0.5) * width * outline
    bend = droop * v
    y = length * np.where(bend > 1e-3, np.sin(bend) / np.maximum(droop, 1e-3), v)
    z = -length * (1 - np.cos(bend)) / max(droop, 1e-3)
    z = z + curl * width * (np.abs(u - 0.5) * 2) ** 1.4 * outline
    z = z + 0.03 * width * np.sin(v * 19 + rng.uniform(0, 6)) * np.abs(u - 0.5) * 4
    return grid(np.stack([x, y, z], axis=-1), uvs)


def plant(seed, stems=9, height=0.26, leaf_length=0.11, leaf_width=0.06, spread=0.16, per_stem=5):
    """A potted plant: 0 leaves, 1 stems, 2 terracotta, 3 soil."""
    rng = np.random.default_rng(seed)
    pot_r, pot_h = 0.062, 0.105
    pot = lathe(
        [
            (0, 0),
            (pot_r * 0.70, 0),
            (pot_r * 0.94, pot_h * 0.74),
            (pot_r * 1.08, pot_h * 0.75),
            (pot_r * 1.12, pot_h),
            (pot_r, pot_h),
            (pot_r * 0.92, pot_h * 0.86),
        ],
        72,
        0.003,
    ).slot(2)
    u, v, uvs = unit_grid(25, 9)
    r, turn = v * pot_r * 0.93, u * 2 * math.pi
    soil = grid(
        np.stack([r * np.cos(turn), r * np.sin(turn), pot_h * 0.87 + 0.004 * np.sin(r * 300 + 5 * turn)], -1), uvs
    ).slot(3)
    parts = [pot, soil]
    for k in range(stems):
        azimuth = 2 * math.pi * (k + rng.uniform(-0.3, 0.3)) / stems
        out, up = spread * rng.uniform(0.35, 1.0), height * rng.uniform(0.6, 1.05)
        d = np.array([math.cos(azimuth), math.sin(azimuth)])
        path = smooth_path(
            [
                (*(d * 0.012), pot_h * 0.85),
                (*(d * out * 0.22), pot_h + up * 0.5),
                (*(d * out * 0.6), pot_h + up * 0.85),
                (*(d * out), pot_h + up * rng.uniform(0.85, 1.05)),
            ],
            28,
        )
        parts.append(tube(path, np.linspace(0.0026, 0.0011, 28), 7).slot(1))
        for j in range(per_stem):
            at = path[int(27 * (0.35 + 0.65 * j / max(per_stem - 1, 1)))]
            size = rng.uniform(0.7, 1.15) * (1.0 if j < per_stem - 1 else 1.1)
            blade = leaf_blade(
                leaf_length * size, leaf_width * size, rng.uniform(0.5, 1.4), rng.uniform(0.05, 0.30), rng
            )
            yaw = math.degrees(azimuth) - 90 + rng.uniform(-75, 75) * (j < per_stem - 1)
            parts.append(blade.at(rx=rng.uniform(5, 50), ry=rng.uniform(-20, 20)).at(*at, rz=yaw))
    return join(parts)


def kilim(length=0.62, width=0.36, seed=0):
    """A small rug on the desk, slightly rumpled, with fringes at both ends: 0 rug (UV 0..1), 1 fringe."""
    rng = np.random.default_rng(seed)
    u, v, uvs = unit_grid(97, 65)
    x, y = (u - 0.5) * length, (v - 0.5) * width
    z = 0.003 + 0.0016 * np.sin(9 * x + 3) * np.sin(13 * y) + 0.0035 * np.exp(-(((x + 0.8 * y - 0.20) / 0.02) ** 2))
    sway = 0.004 * np.sin(x * 11)
    top = grid(np.stack([x, y + sway, z], axis=-1), uvs)
    parts = [top]
    for side in (-1, 1):
        for k in range(90):
            y0 = (k / 89 - 0.5) * width * 0.99
            x0 = side * length / 2
            end = rng.normal(0, 0.004)
            sway0 = 0.004 * math.sin(x0 * 11)
            path = [
                (x0 - side * 0.002, y0 + sway0, 0.0034),
                (x0 + side * 0.010, y0 + sway0 + end * 0.3, 0.0026),
                (x0 + side * rng.uniform(0.019, 0.026), y0 + sway0 + end, 0.0010),
            ]
            parts.append(tube(path, 0.0010, 5).slot(1))
    return join(parts)


def cup_of_pencils(seed=3):
    """A brass cup with pencils and a brush: 0 brass, 1 paint, 2 wood, 3 lead."""
    rng = np.random.default_rng(seed)
    cup = lathe(
        [
            (0, 0),
            (0.034, 0),
            (0.036, 0.003),
            (0.034, 0.010),
            (0.034, 0.092),
            (0.036, 0.096),
            (0.034, 0.098),
            (0.0325, 0.094),
            (0.0325, 0.006),
            (0, 0.006),
        ],
        96,
        0.0015,
    )
    parts = [cup]
    for k in range(9):
        lean, turn = rng.uniform(6, 13), rng.uniform(0, 360)
        p = pencil(rng.uniform(0.13, 0.18))
        p.slots = p.slots + 1
        t = math.radians(turn)
        parts.append(p.at(0.006 * math.cos(t) * k / 9, 0.006 * math.sin(t), 0.008, ry=lean).at(rz=turn))
    return join(parts)


def wedge(width, depth, height):
    """A little wooden stand with a slanting front (towards -Y)."""
    outline = [(-depth * 0.65, 0), (depth, 0), (depth, height), (depth * 0.45, height)]
    return prism(outline, width, 0.0015).at(rz=90)


def candlestick():
    """A brass candlestick with a burning candle: 0 brass, 1 wax, 2 wick, 3 flame."""
    stick = lathe(
        [
            (0, 0),
            (0.052, 0),
            (0.055, 0.004),
            (0.050, 0.010),
            (0.028, 0.016),
            (0.014, 0.028),
            (0.010, 0.050),
            (0.018, 0.062),
            (0.010, 0.074),
            (0.008, 0.115),
        ]
        + [
            (0.015, 0.125),
            (0.030, 0.132),
            (0.032, 0.135),
            (0.028, 0.137),
            (0.0135, 0.137),
            (0.0135, 0.160),
            (0.0155, 0.162),
            (0.0145, 0.164),
            (0.0115, 0.163),
            (0.0115, 0.14),
        ],
        96,
        0.004,
    )
    wax = lathe(
        [(0, 0.14), (0.0112, 0.14), (0.0112, 0.226), (0.010, 0.232), (0.007, 0.228), (0, 0.227)], 48, 0.003
    ).slot(1)
    wick = tube([(0, 0, 0.226), (0.0004, 0, 0.233), (0.002, 0, 0.238)], 0.0008, 6).slot(2)
    flame = lathe([(0, 0.2315), (0.0035, 0.2335), (0.0052, 0.239), (0.0042, 0.248), (0.0018, 0.258), (0, 0.266)], 12)
    return join([stick, wax, wick, flame.slot(3)])


def telescope():
    """A brass telescope on a wooden tripod looking along -X: 0 brass, 1 dark wood, 2 black, 3 glass."""
    tubes = lathe(
        [
            (0.0, -0.40),
            (0.012, -0.40),
            (0.016, -0.395),
            (0.016, -0.37),
            (0.011, -0.365),
            (0.011, -0.31),
            (0.020, -0.305),
            (0.020, -0.20),
            (0.024, -0.195),
        ]
        + [
            (0.024, -0.185),
            (0.037, -0.18),
            (0.037, 0.40),
            (0.043, 0.405),
            (0.043, 0.50),
            (0.046, 0.503),
            (0.046, 0.512),
            (0.040, 0.512),
            (0.039, 0.42),
            (0, 0.41),
        ],
        72,
        0.002,
    )
    bands = [
        lathe([(0.037, z), (0.0395, z + 0.002), (0.0395, z + 0.014), (0.037, z + 0.016)], 72)
        for z in (-0.12, 0.02, 0.16, 0.30)
    ]
    sleeve = lathe([(0.0376, -0.10), (0.0376, 0.30)], 72).slot(1)
    glass = lathe(lens_profile(0.0395, 0.012, 0.004, 16), 72).at(z=0.485).slot(3)
    body = join([tubes, *bands, sleeve, glass]).at(ry=-90).at(ry=14).at(z=1.32)
    legs = []
    for k in range(3):
        t = 2 * math.pi * k / 3 + 0.4
        foot = np.array([0.40 * math.cos(t), 0.40 * math.sin(t), 0.0])
        side = np.array([-math.sin(t), math.cos(t), 0.0])
        hub = np.array([0.045 * math.cos(t), 0.045 * math.sin(t), 1.18])
        for s in (-1, 1):
            legs.append(tube([hub + side * 0.03 * s, hub * 0.45 + foot * 0.55 + side * 0.018 * s], 0.010, 12).slot(1))
        legs.append(tube([hub * 0.55 + foot * 0.45, foot], 0.011, 12).slot(1))
        legs.append(lathe([(0, 0), (0.006, 0.02), (0.014, 0.03), (0.014, 0.06), (0, 0.06)], 24).at(*foot))
    head = lathe(
        [
            (0, 1.14),
            (0.05, 1.145),
            (0.055, 1.16),
            (0.055, 1.20),
            (0.022, 1.21),
            (0.018, 1.25),
            (0.026, 1.26),
            (0.026, 1.285),
            (0, 1.29),
        ],
        64,
        0.004,
    )
    return join([body, head, *legs])


def armchair():
    """A leather club chair, seat towards -Y: 0 leather, 1 dark wood, 2 brass nails."""
    seat = soft_box(0.60, 0.62, 0.17, 5.0, 16, 0.16, 0.006, 1).at(z=0.40)
    back = soft_box(0.66, 0.20, 0.62, 5.0, 30, 0.10, 0.004, 2)
    buttons = []
    for row in range(4):
        for column in range(5 - row % 2):
            bx, bz = (column - (4 - row % 2) / 2) * 0.125, (row - 1.5) * 0.125
            d = np.hypot(back.verts[:, 0] - bx, back.verts[:, 2] - bz)
            back.verts[:, 1] += np.where(back.verts[:, 1] < 0, 0.030 * np.exp(-((d / 0.035) ** 2)), 0)
            buttons.append(icosphere(0.010, 2).at(bx, -0.085, bz))
    back = join([back, *buttons]).at(y=0.30, z=0.66, rx=-9)
    arms = [
        soft_box(0.17, 0.72, 0.32, 3.2, 14, 0.05, 0.004, 5 + side).at(x=side * 0.375, y=-0.02, z=0.45)
        for side in (-1, 1)
    ]
    rolls = [
        soft_box(0.20, 0.74, 0.16, 2.6, 12, 0.0, 0.003, 9 + side).at(x=side * 0.385, y=-0.02, z=0.60)
        for side in (-1, 1)
    ]
    skirt = soft_box(0.80, 0.70, 0.20, 9.0, 6).at(z=0.24)
    feet = [
        lathe([(0, 0), (0.016, 0), (0.030, 0.08), (0.026, 0.14), (0, 0.14)], 32, 0.006).at(x, y).slot(1)
        for x in (-0.34, 0.34)
        for y in (-0.28, 0.28)
    ]
    nails = [
        icosphere(0.006, 1).at(side * (0.30 + 0.15 * k / 9), -0.376, 0.66).slot(2)
        for side in (-1, 1)
        for k in range(10)
    ]
    return join([seat, back, *arms, *rolls, skirt, *feet, *nails])


def floor_lamp(height=1.55, shade_radius=0.19, shade_height=0.24):
    """A standing lamp, shade open above and below: 0 brass, 1 shade. The light goes in the middle of it."""
    base = lathe([(0, 0), (0.14, 0), (0.145, 0.008), (0.13, 0.022), (0.04, 0.035), (0.014, 0.06)], 72, 0.006)
    stem = tube([(0, 0, 0.05), (0, 0, height - shade_height * 0.6)], 0.010, 16)
    knobs = [
        lathe([(0.01, -0.02), (0.02, -0.008), (0.02, 0.008), (0.01, 0.02)], 48, 0.006).at(z=z)
        for z in (0.35, 0.8, height - 0.30)
    ]
    shade = drum_shade(shade_radius, shade_height).at(z=height - shade_height).slot(1)
    return join([base, stem, *knobs, shade])


def drum_shade(radius, height, pleats=40):
    """A pleated fabric shade, open above and below; UV in metres around and up."""
    turn = np.linspace(0, 2 * math.pi, pleats * 4, endpoint=False)
    rows = []
    for z, r in ((0, 1.0), (0.02, 1.0), (0.98, 0.77), (1.0, 0.77)):
        wave = 1 + 0.010 * np.cos(turn * pleats) * (0.02 < z < 0.98)
        rows.append(
            np.stack(
                [radius * r * wave * np.cos(turn), radius * r * wave * np.sin(turn), np.full_like(turn, z * height)], -1
            )
        )
    points = np.array(rows)
    u, v = np.meshgrid(np.linspace(0, 2 * math.pi * radius, len(turn) + 1), points[:, 0, 2])
    return grid(points, np.stack([u, v], -1), closed_u=True)


def curtain(width, height, folds, depth=0.05, seed=0, tie=0.0, rows=41):
    """A hanging curtain in the XZ plane from Z = height to 0, folds along Y; `tie` gathers the middle. UV in metres."""
    rng = np.random.default_rng(seed)
    u, v, _ = unit_grid(folds * 12 + 1, rows)
    phase = (
        2 * math.pi * folds * u + 0.7 * np.sin(2 * math.pi * u * 1.7 + rng.uniform(0, 6)) + 0.35 * np.sin(3 * v + 9 * u)
    )
    open_up = 0.55 + 0.45 * (1 - v)
    y = depth * open_up * np.sin(phase) + 0.25 * depth * np.sin(2.3 * phase + 4 * v)
    gather = 1 - tie * np.exp(-(((v - 0.42) / 0.22) ** 2))
    x = width * u * gather + 0.008 * np.sin(7 * v + 20 * u)
    cloth = width * folds * 0.11
    uvs = np.stack([u * max(cloth, width * 1.6), v * height], axis=-1)
    return grid(np.stack([x, y, v * height + 0.004 * np.sin(phase) * (1 - v)], axis=-1), uvs)


def picture(width, height, border=0.05):
    """A framed picture in the XZ plane facing -Y, centred: 0 gilt frame, 1 canvas (UV 0..1)."""
    rails = join(
        [
            frame(width + 2 * border, height + 2 * border, border * 0.55, 0.03, 0.006),
            frame(width + border, height + border, border * 0.6, 0.018, 0.004).at(y=-0.004),
        ]
    )
    u, v, uvs = unit_grid(9, 9)
    canvas = grid(np.stack([(u - 0.5) * width, 0 * u, (v - 0.5) * height], -1), uvs).slot(1)
    return join([rails, canvas])


def chair():
    """A plain wooden chair facing -Y: slot 0 only."""
    parts = [soft_box(0.42, 0.42, 0.035, 7.0, 10).at(z=0.45)]
    for x in (-0.18, 0.18):
        parts.append(tube([(x, -0.18, 0), (x * 0.95, -0.17, 0.44)], [0.014, 0.018], 12))
        parts.append(tube(smooth_path([(x * 1.05, 0.20, 0), (x, 0.18, 0.45), (x * 0.95, 0.25, 0.95)], 20), 0.016, 12))
    for z in (0.62, 0.76, 0.90):
        parts.append(soft_box(0.36, 0.018, 0.07, 5, 6).at(y=0.205 + 0.16 * (z - 0.45) * 0.8, z=z, rx=-8))
    return join(parts)


def bulbs(points, radii, detail_within=None):
    """Bulbs as small geodesic balls: fine ones (320 triangles) for points where detail_within says so, else 80."""
    fine, coarse = icosphere(1.0, 3), icosphere(1.0, 2)
    parts = []
    for k, (p, r) in enumerate(zip(points, radii, strict=True)):
        ball_shape = fine if detail_within is not None and detail_within[k] else coarse
        parts.append(Shape(ball_shape.verts * r * [1, 1, 1.15] + p, ball_shape.faces, ball_shape.uvs, ball_shape.slots))
    return join(parts)
