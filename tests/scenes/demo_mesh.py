"""Geometry helpers of the demo scene: polygon shapes built with numpy and bmesh, with UV maps.

A `Shape` is a bag of vertices, polygons, UV coordinates (one per polygon corner) and material slots.
Lengths are metres; UV coordinates are metres as well unless a function says otherwise, so that one
texture keeps its scale over all objects that use it.
"""

import math
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

SMOOTH_ANGLE = math.radians(38.0)
# Coordinates are rounded to powers of two: the file compresses better.
VERTEX_GRAIN = 2.0**-20
UV_GRAIN = 2.0**-13


@dataclass
class Shape:
    """Vertices (n, 3), polygons as index tuples, UVs per corner in polygon order, slot per polygon."""

    verts: np.ndarray
    faces: list
    uvs: np.ndarray
    slots: np.ndarray

    def moved(self, matrix):
        """A copy transformed by a 4x4 matrix."""
        m = np.array(matrix)
        verts = self.verts @ m[:3, :3].T + m[:3, 3]
        return Shape(verts, self.faces, self.uvs, self.slots)

    def at(self, x=0.0, y=0.0, z=0.0, rx=0.0, ry=0.0, rz=0.0):
        """A copy rotated (degrees, XYZ order) and then translated."""
        return self.moved(placement(x, y, z, rx, ry, rz))

    def slot(self, index):
        """A copy with every polygon in one material slot."""
        return Shape(self.verts, self.faces, self.uvs, np.full(len(self.faces), index, np.int32))

    def uv(self, scale_u=1.0, scale_v=1.0, shift_u=0.0, shift_v=0.0):
        """A copy with scaled and shifted UVs."""
        uvs = self.uvs * [scale_u, scale_v] + [shift_u, shift_v]
        return Shape(self.verts, self.faces, uvs, self.slots)


def placement(x=0.0, y=0.0, z=0.0, rx=0.0, ry=0.0, rz=0.0):
    """Translation times Euler rotation in degrees."""
    turn = Matrix.Rotation(math.radians(rz), 4, "Z")
    turn = turn @ Matrix.Rotation(math.radians(ry), 4, "Y") @ Matrix.Rotation(math.radians(rx), 4, "X")
    return Matrix.Translation((x, y, z)) @ turn


def join(shapes):
    """One shape out of many."""
    verts, faces, uvs, slots, base = [], [], [], [], 0
    for shape in shapes:
        verts.append(shape.verts)
        faces.extend(tuple(i + base for i in face) for face in shape.faces)
        uvs.append(shape.uvs)
        slots.append(shape.slots)
        base += len(shape.verts)
    return Shape(np.concatenate(verts), faces, np.concatenate(uvs), np.concatenate(slots))


def box_uvs(verts, faces):
    """Project every polygon along the dominant axis of its normal; UVs in metres.

    The long way of the face (local Z where it has one, else Y) becomes V.
    """
    uvs = []
    for face in faces:
        points = verts[list(face)]
        # Newell's normal copes with any polygon.
        nxt = np.roll(points, -1, axis=0)
        normal = np.abs(np.cross(points, nxt).sum(axis=0))
        axis = int(np.argmax(normal))
        u, v = ((1, 2), (0, 2), (0, 1))[axis]
        uvs.append(points[:, [u, v]])
    return np.concatenate(uvs)


def from_bmesh(bm):
    """Take over a bmesh (and free it), with box projected UVs."""
    bm.verts.index_update()
    verts = np.array([v.co[:] for v in bm.verts])
    faces = [tuple(v.index for v in f.verts) for f in bm.faces]
    bm.free()
    return Shape(verts, faces, box_uvs(verts, faces), np.zeros(len(faces), np.int32))


def box(sx, sy, sz, bevel=0.002, segments=2, grain=None):
    """A bevelled box centred on the origin. `grain` ("x" or "y") turns the UVs so that V runs that way."""
    bm = bmesh.new()
    bmesh.ops.create_cube(bm, size=1.0)
    for vert in bm.verts:
        vert.co = Vector((vert.co.x * sx, vert.co.y * sy, vert.co.z * sz))
    bevel = min(bevel, 0.45 * min(sx, sy, sz))
    if bevel > 0:
        bmesh.ops.bevel(
            bm, geom=bm.edges[:], offset=bevel, segments=segments, profile=0.5, affect="EDGES", clamp_overlap=True
        )
    shape = from_bmesh(bm)
    if grain:
        order = {"x": [1, 2, 0], "y": [2, 0, 1]}[grain]
        shape.uvs = box_uvs(shape.verts[:, order], shape.faces)
    return shape


def prism(outline, depth, bevel=0.0015, segments=2, holes=()):
    """Extrude a closed outline of (x, z) points along Y, centred on Y = 0, edges bevelled.

    With one hole of as many points as the outline, the two are bridged into a frame.
    """
    bm = bmesh.new()

    def ring(points, y):
        return [bm.verts.new((x, y, z)) for x, z in points]

    front, back = ring(outline, -depth / 2), ring(outline, depth / 2)
    count = len(outline)
    for i in range(count):
        bm.faces.new((front[i], front[(i + 1) % count], back[(i + 1) % count], back[i]))
    if holes:
        hole = holes[0]
        hole_front, hole_back = ring(hole, -depth / 2), ring(hole, depth / 2)
        for i in range(count):
            j = (i + 1) % count
            bm.faces.new((hole_front[j], hole_front[i], hole_back[i], hole_back[j]))
            bm.faces.new((front[j], front[i], hole_front[i], hole_front[j]))
            bm.faces.new((back[i], back[j], hole_back[j], hole_back[i]))
    else:
        bm.faces.new(front[::-1])
        bm.faces.new(back)
    bmesh.ops.recalc_face_normals(bm, faces=bm.faces[:])
    if bevel > 0:
        sharp = [e for e in bm.edges if e.calc_face_angle(0.0) > 0.6]
        bmesh.ops.bevel(
            bm, geom=sharp, offset=bevel, segments=segments, profile=0.5, affect="EDGES", clamp_overlap=True
        )
    return from_bmesh(bm)


def rectangle(width, height, cx=0.0, cz=0.0):
    """Outline of a rectangle for `prism`."""
    w, h = width / 2, height / 2
    return [(cx - w, cz - h), (cx + w, cz - h), (cx + w, cz + h), (cx - w, cz + h)]


def circle_outline(radius, count=64, cx=0.0, cz=0.0):
    """Outline of a circle for `prism`."""
    turns = np.arange(count) * (2 * math.pi / count)
    return [(cx + radius * math.cos(t), cz + radius * math.sin(t)) for t in turns]


def square_outline(half, count=64):
    """Outline of a square with `count` points, matching `circle_outline` point by point."""
    points = []
    for t in np.arange(count) * (2 * math.pi / count):
        c, s = math.cos(t), math.sin(t)
        k = half / max(abs(c), abs(s))
        points.append((k * c, k * s))
    return points


def frame(width, height, border, depth, bevel=0.002):
    """A rectangular frame standing in the XZ plane, made of four mitred rails."""
    return prism(
        rectangle(width, height),
        depth,
        bevel,
        holes=[rectangle(width - 2 * border, height - 2 * border)],
    )


def grid(points, uvs, closed_u=False, closed_v=False):
    """A quad mesh from an (nv, nu, 3) array; UVs are given as (nv + closed_v, nu + closed_u, 2)."""
    nv, nu = points.shape[:2]
    rows = nv if closed_v else nv - 1
    columns = nu if closed_u else nu - 1
    j, i = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    j1, i1 = (j + 1) % nv, (i + 1) % nu
    quads = np.stack([j * nu + i, j * nu + i1, j1 * nu + i1, j1 * nu + i], axis=-1).reshape(-1, 4)
    corners = np.stack([uvs[j, i], uvs[j, i + 1], uvs[j + 1, i + 1], uvs[j + 1, i]], axis=2)
    faces = [tuple(q) for q in quads.tolist()]
    return Shape(points.reshape(-1, 3).astype(float), faces, corners.reshape(-1, 2), np.zeros(len(faces), np.int32))


def unit_grid(nu, nv):
    """Parameters u, v in 0..1 as (nv, nu) arrays and the same stacked as UVs."""
    u, v = np.meshgrid(np.linspace(0, 1, nu), np.linspace(0, 1, nv))
    return u, v, np.stack([u, v], axis=-1)


def fillet(points, radius, steps=4):
    """Round the inner corners of a polyline."""
    points = [np.array(p, float) for p in points]
    result = [points[0]]
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        la, lb = np.linalg.norm(before - corner), np.linalg.norm(after - corner)
        reach = min(radius, 0.48 * la, 0.48 * lb)
        if reach < 1e-6:
            result.append(corner)
            continue
        a = corner + (before - corner) * (reach / la)
        b = corner + (after - corner) * (reach / lb)
        for t in np.linspace(0, 1, steps + 1):
            result.append((1 - t) ** 2 * a + 2 * t * (1 - t) * corner + t**2 * b)
    result.append(points[-1])
    return [tuple(p) for p in result]


def lathe(profile, segments=64, round_radius=0.0, closed=False, steps=2):
    """Turn a profile of (radius, z) about Z. A radius of 0 at an end becomes a pole.

    UVs: U runs once around in 0..1, V is the arc length in metres.
    """
    if round_radius:
        profile = fillet(profile, round_radius, steps)
    if closed:
        profile = [*profile, profile[0]]
    r = np.array([p[0] for p in profile])
    z = np.array([p[1] for p in profile])
    length = np.concatenate([[0], np.cumsum(np.hypot(np.diff(r), np.diff(z)))])
    turn = np.arange(segments) * (2 * math.pi / segments)
    points = np.stack(
        [np.outer(r, np.cos(turn)), np.outer(r, np.sin(turn)), np.repeat(z[:, None], segments, 1)], axis=-1
    )
    u, v = np.meshgrid(np.arange(segments + 1) / segments, length)
    shape = grid(points, np.stack([u, v], axis=-1), closed_u=True)
    return shape


def tube(path, radius, sides=8, closed=False, caps=True):
    """Sweep a circle along a polyline; `radius` is a number or one per point. UVs in metres."""
    path = np.array(path, float)
    count = len(path)
    radii = np.broadcast_to(np.asarray(radius, float), (count,))
    if closed:
        tangent = np.roll(path, -1, 0) - np.roll(path, 1, 0)
    else:
        tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True) + 1e-12
    side = np.cross(tangent[0], [0, 0, 1.0])
    if np.linalg.norm(side) < 1e-3:
        side = np.cross(tangent[0], [0, 1.0, 0])
    side /= np.linalg.norm(side)
    turn = np.arange(sides) * (2 * math.pi / sides)
    rings = []
    for p, t, r in zip(path, tangent, radii, strict=True):
        side = side - t * side.dot(t)
        side /= np.linalg.norm(side)
        up = np.cross(t, side)
        rings.append(p + r * (np.outer(np.cos(turn), side) + np.outer(np.sin(turn), up)))
    points = np.array(rings)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    length = np.concatenate([[0], np.cumsum(steps)])
    if closed:
        length = np.append(length, length[-1] + np.linalg.norm(path[0] - path[-1]))
    u, v = np.meshgrid(np.arange(sides + 1) / sides * 2 * math.pi * radii.mean(), length)
    shape = grid(points, np.stack([u, v], axis=-1), closed_u=True, closed_v=closed)
    if caps and not closed:
        last = (count - 1) * sides
        ends = [tuple(range(sides))[::-1], tuple(range(last, last + sides))]
        flat = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * radii.mean()
        shape.faces = shape.faces + ends
        shape.uvs = np.concatenate([shape.uvs, flat[::-1], flat])
        shape.slots = np.zeros(len(shape.faces), np.int32)
    return shape


def smooth_path(points, count):
    """Catmull-Rom curve through the points, resampled to equal steps."""
    p = np.array(points, float)
    p = np.vstack([2 * p[0] - p[1], p, 2 * p[-1] - p[-2]])
    dense = []
    for a, b, c, d in zip(p, p[1:], p[2:], p[3:], strict=False):
        for t in np.linspace(0, 1, 40, endpoint=False):
            dense.append(
                0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (-a + 3 * b - 3 * c + d) * t**3)
            )
    dense.append(p[-2])
    dense = np.array(dense)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    at = np.linspace(0, length[-1], count)
    return np.stack([np.interp(at, length, dense[:, k]) for k in range(3)], axis=-1)


def catenary(a, b, sag, count):
    """A cable hung between two points with the given sag."""
    t = np.linspace(0, 1, count)[:, None]
    line = np.array(a) * (1 - t) + np.array(b) * t
    line[:, 2] -= (sag * 4 * t * (1 - t))[:, 0]
    return line


def soft_box(sx, sy, sz, power=6.0, res=20, bulge=0.0, wrinkle=0.0, seed=0):
    """A cushion: a superellipsoid of the given size, faces bulging, with low wrinkles."""
    rng = np.random.default_rng(seed)
    bm = bmesh.new()
    bmesh.ops.create_cube(bm, size=2.0)
    bmesh.ops.subdivide_edges(bm, edges=bm.edges[:], cuts=res, use_grid_fill=True)
    shape = from_bmesh(bm)
    p = shape.verts
    # Equalise the spacing, then pull the cube's points onto the superellipsoid.
    p = p / (np.abs(p) ** power).sum(axis=1, keepdims=True) ** (1 / power)
    half = np.array([sx, sy, sz]) / 2
    if bulge:
        q = p**2
        p = p + p * bulge * (1 - np.clip(q[:, [1, 2, 0]], 0, 1)) * (1 - np.clip(q[:, [2, 0, 1]], 0, 1))
    p = p * half
    if wrinkle:
        for _ in range(9):
            k = rng.normal(0, 14, 3)
            direction = rng.normal(0, 1, 3)
            direction /= np.linalg.norm(direction)
            p = p + direction * (wrinkle / 6 * np.sin(p @ k + rng.uniform(0, 6)))[:, None]
    uvs = box_uvs(p, shape.faces)
    return Shape(p, shape.faces, uvs, shape.slots)


def icosphere(radius, subdivisions=2):
    """A geodesic ball."""
    bm = bmesh.new()
    bmesh.ops.create_icosphere(bm, subdivisions=subdivisions, radius=radius)
    return from_bmesh(bm)


def ball(radius, segments=32, rings=16):
    """A latitude-longitude ball whose UVs cover 0..1 once (for the globe)."""
    u, v, uvs = unit_grid(segments + 1, rings + 1)
    turn, lat = u * 2 * math.pi, (v - 0.5) * math.pi
    points = radius * np.stack([np.cos(turn) * np.cos(lat), np.sin(turn) * np.cos(lat), np.sin(lat)], axis=-1)
    return grid(points, uvs)


def lens_profile(radius, centre, edge, count=14):
    """Closed profile of a biconvex lens about Z = 0: centre and edge thickness."""
    sag = (centre - edge) / 2
    r = np.linspace(0, radius, count)
    curve = edge / 2 + sag * (1 - (r / radius) ** 2)
    top = list(zip(r, curve, strict=True))
    bottom = [(a, -b) for a, b in top[::-1]]
    return top + bottom


def to_mesh(shape, name, weld=True):
    """Write a shape into a new mesh: outward normals, smooth with sharp edges beyond an angle."""
    mesh = bpy.data.meshes.new(name)
    verts = np.round(shape.verts / VERTEX_GRAIN) * VERTEX_GRAIN
    mesh.from_pydata(verts.tolist(), [], shape.faces)
    layer = mesh.uv_layers.new(name="UVMap")
    uvs = np.round(shape.uvs / UV_GRAIN) * UV_GRAIN
    layer.uv.foreach_set("vector", uvs.astype(np.float32).ravel())
    mesh.polygons.foreach_set("material_index", shape.slots.astype(np.int32))
    bm = bmesh.new()
    bm.from_mesh(mesh)
    if weld:
        bmesh.ops.remove_doubles(bm, verts=bm.verts[:], dist=1e-6)
        bmesh.ops.dissolve_degenerate(bm, edges=bm.edges[:], dist=1e-7)
    bmesh.ops.recalc_face_normals(bm, faces=bm.faces[:])
    bm.to_mesh(mesh)
    bm.free()
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    mesh.set_sharp_from_angle(angle=SMOOTH_ANGLE)
    mesh.update()
    return mesh


def to_object(shape, name, materials, collection, matrix=None, weld=True):
    """Build a mesh object with its materials and link it."""
    mesh = to_mesh(shape, name, weld)
    for material in materials:
        mesh.materials.append(material)
    return instance(mesh, name, collection, matrix)


def instance(mesh, name, collection, matrix=None):
    """Another object on the same mesh."""
    obj = bpy.data.objects.new(name, mesh)
    if matrix is not None:
        obj.matrix_world = matrix
    collection.objects.link(obj)
    return obj
