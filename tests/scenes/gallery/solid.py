# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies given by a signed distance, and the mesh of their surface by surface nets (S. F. Gibson, "Constrained elastic
surface nets", MICCAI 1998). Points are arrays (n, 3); all lengths are metres."""

from __future__ import annotations

import numpy as np
from parts import Stage  # noqa: F401  (sets the path to demo_mesh)

from demo_mesh import Shape


def ellipsoid(p, centre, radii):
    """About the distance to an ellipsoid."""
    q = (p - centre) / radii
    k0 = np.linalg.norm(q, axis=1)
    k1 = np.linalg.norm(q / radii, axis=1)
    return k0 * (k0 - 1.0) / np.maximum(k1, 1e-9)


def ball(p, centre, radius):
    """A sphere."""
    return np.linalg.norm(p - centre, axis=1) - radius


def limb(p, a, b, ra, rb=None):
    """A rod with round ends whose radius changes evenly."""
    a, b, rb = np.asarray(a, float), np.asarray(b, float), ra if rb is None else rb
    along = b - a
    t = np.clip((p - a) @ along / (along @ along), 0.0, 1.0)
    return np.linalg.norm(p - a - t[:, None] * along, axis=1) - (ra + (rb - ra) * t)


def join(a, b, k):
    """The union of both, blended over a width of k."""
    h = np.maximum(k - np.abs(a - b), 0.0) / k
    return np.minimum(a, b) - h * h * k * 0.25


def cut(a, b, k):
    """The first without the second, the edge rounded over k."""
    return -join(-a, b, k)


def within(a, b, k):
    """The part that both share."""
    return -join(-a, -b, k)


def surface(distance, low, high, step) -> Shape:
    """The surface where `distance` is 0, in quads about `step` wide. It is evaluated only near by."""
    coarse = 5
    low = np.asarray(low, float)
    cells = (np.ceil((np.asarray(high, float) - low) / (step * coarse)).astype(int)) * coarse
    blocks = cells // coarse
    wide = step * coarse
    centres = np.stack(np.meshgrid(*[np.arange(n) for n in blocks], indexing="ij"), -1).reshape(-1, 3)
    near = np.abs(distance(low + (centres + 0.5) * wide)) < 1.6 * wide
    field = np.full(cells + 1, np.inf, np.float32)
    offsets = np.stack(np.meshgrid(*[np.arange(coarse + 1)] * 3, indexing="ij"), -1).reshape(-1, 3)
    index = (centres[near][:, None, :] * coarse + offsets[None]).reshape(-1, 3)
    flat = np.unique(np.ravel_multi_index(index.T, field.shape))
    index = np.stack(np.unravel_index(flat, field.shape), -1)
    for part in np.array_split(np.arange(len(index)), max(1, len(index) // 400000)):
        i = index[part]
        field[i[:, 0], i[:, 1], i[:, 2]] = distance(low + i * step)

    corners = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    nx, ny, nz = cells

    def at(i, j, k):
        return field[i : nx + i, j : ny + j, k : nz + k]

    inside = np.zeros((nx, ny, nz), np.int8)
    known = np.ones((nx, ny, nz), bool)
    for c in corners:
        inside += at(*c) < 0
        known &= np.isfinite(at(*c))
    crossed = known & (inside > 0) & (inside < 8)
    cell = np.argwhere(crossed)
    number = np.full((nx, ny, nz), -1, np.int64)
    number[crossed] = np.arange(len(cell))
    # A vertex is the mean of the crossings of its cell's edges.
    total, count = np.zeros((len(cell), 3)), np.zeros(len(cell))
    for axis in range(3):
        for c in corners:
            if c[axis]:
                continue
            d = list(c)
            d[axis] = 1
            fa, fb = (field[tuple((cell + e).T)].astype(float) for e in (c, d))
            hit = (fa < 0) != (fb < 0)
            t = np.where(hit, fa / np.where(hit, fa - fb, 1.0), 0.0)
            place = np.tile(np.array(c, float), (len(cell), 1))
            place[:, axis] = t
            total += place * hit[:, None]
            count += hit
    verts = low + (cell + total / count[:, None]) * step
    # And is drawn onto the surface itself.
    for _ in range(3):
        f, e = distance(verts), 0.2 * step
        slope = np.stack([(distance(verts + e * d) - distance(verts - e * d)) / (2 * e) for d in np.eye(3)], -1)
        move = slope * (f / np.maximum((slope**2).sum(1), 0.05))[:, None]
        far = np.linalg.norm(move, axis=1) / (0.4 * step)
        verts = verts - move / np.maximum(far, 1.0)[:, None]
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        a = cell[cell[:, u].astype(bool) & cell[:, v].astype(bool)]
        b = a.copy()
        b[:, axis] += 1
        fa, fb = field[tuple(a.T)], field[tuple(b.T)]
        hit = ((fa < 0) != (fb < 0)) & np.isfinite(fa) & np.isfinite(fb)
        a, out = a[hit], fa[hit] < 0
        around = []
        for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0)):
            c = a.copy()
            c[:, u] -= du
            c[:, v] -= dv
            around.append(number[tuple(c.T)])
        quad = np.stack(around, -1)
        quad[~out] = quad[~out][:, ::-1]
        faces.append(quad[(quad >= 0).all(1)])
    quads = np.concatenate(faces)
    uvs = verts[quads.ravel()][:, [0, 2]]
    return Shape(verts, [tuple(q) for q in quads.tolist()], uvs, np.zeros(len(quads), np.int32))
