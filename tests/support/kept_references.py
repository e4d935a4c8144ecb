# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' pictures, kept from one run of the tests to the next. Imported inside of tests: it needs bpy.

The same Cycles takes the same picture of the same scene, so that only Petzval's has to be taken again. A picture is kept in
.cache/cycles under the name of its test, and counts as long as Blender's version, the test's `sources`, the .blend that is open, the
meshes and the camera are what they were. PETZVAL_CYCLES_AGAIN=1 has all of them taken anew.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from pathlib import Path

import bpy
import numpy as np

from support import sources
from support.places import ROOT

KEPT = ROOT / ".cache" / "cycles"

#: The test that is running, and how many pictures Cycles has been asked for in it.
_running, _asked = "", 0


def render_still() -> None:
    """Renders the scene into its file; what Cycles is known to take of it is copied there."""
    scene = bpy.context.scene
    kept = _place() if scene.render.engine == "CYCLES" and is_reproducible() else None
    if kept is not None and kept.exists() and not os.environ.get("PETZVAL_CYCLES_AGAIN"):
        shutil.copyfile(kept, scene.render.filepath)
        return
    bpy.ops.render.render(write_still=True)
    if kept is not None:
        KEPT.mkdir(parents=True, exist_ok=True)
        for old in KEPT.glob(f"{kept.name.rpartition('-')[0]}-*"):
            old.unlink(missing_ok=True)
        # Other runs read it whole or not at all.
        part = kept.with_suffix(f".{os.getpid()}.part")
        shutil.copyfile(scene.render.filepath, part)
        part.replace(kept)


def is_reproducible() -> bool:
    """False if Blender makes the scene otherwise in each process: children of particles grow at other places."""
    return not any(one.particle_systems for one in bpy.data.objects)


def _place() -> Path | None:
    """The file of the running test's next picture; `None` outside of tests."""
    global _running, _asked
    test = os.environ.get("PYTEST_CURRENT_TEST")
    if test is None:
        return None
    if test != _running:
        _running, _asked = test, 0
    _asked += 1
    name = test.rpartition(" ")[0]
    # Names of tests may be longer than those of files.
    told = hashlib.blake2b(f"{sources.without_folder(test)} {_asked}".encode(), digest_size=6).hexdigest()
    short = re.sub(r"\W+", "-", name.partition("::")[2])[:80]
    return KEPT / f"{short}-{told}-{'.'.join(map(str, bpy.app.version[:2]))}-{digest(_asked)}.exr"


def digest(*more: object, chapter: Path | None = None) -> str:
    """The digest of all data that decide Cycles' next picture in the running test; `more` tells the pictures of a test apart, `chapter` is the
    one module of its package that the scene is from."""
    test = os.environ["PYTEST_CURRENT_TEST"]
    made = hashlib.blake2b(digest_size=12)
    for part in (*_state(), _meshes(), sources.digest(sources.file_of(test), chapter)):
        made.update(repr(part).encode())
    made.update(repr((sources.without_folder(test), *more)).encode())
    return made.hexdigest()


#: Meshes of more vertices come from files, which count themselves.
_MOST_VERTICES = 100_000


def _meshes() -> bytes:
    """A digest of the meshes in memory: what bmesh cuts comes in another order each time that Blender runs.

    Even of a sphere the faces do; their order counts only where something goes by it.
    """
    digest = hashlib.blake2b(digest_size=12)
    ordered = _go_by_order()
    for mesh in sorted(bpy.data.meshes, key=lambda mesh: mesh.name_full):
        if 0 < len(mesh.vertices) <= _MOST_VERTICES:
            places, corners = np.empty(3 * len(mesh.vertices), np.float32), np.empty(len(mesh.loops), np.int32)
            mesh.vertices.foreach_get("co", places)
            mesh.loops.foreach_get("vertex_index", corners)
            digest.update(places.tobytes())
            digest.update(corners.tobytes() if mesh.name_full in ordered or ordered is EVERY else _faces(mesh, corners))
    return digest.digest()


#: The value in place of names of meshes.
EVERY = frozenset({""})


def _go_by_order() -> frozenset[str]:
    """The meshes of which faces are counted or chosen by number: by modifiers, particles, attributes of faces, and nodes that tell
    islands apart, which may be of any material."""
    trees = [*(m.node_tree for m in bpy.data.materials if m.node_tree), *bpy.data.node_groups]
    if any(out.is_linked for t in trees for n in t.nodes for out in n.outputs if out.name == "Random Per Island"):
        return EVERY
    made = {o.data.name_full for o in bpy.data.objects if o.type == "MESH" and (o.modifiers or o.particle_systems)}
    own = {m.name_full for m in bpy.data.meshes if any(a.domain == "FACE" and not a.is_internal and a.name not in ("sharp_face", "material_index") for a in m.attributes)}  # fmt: skip
    return frozenset(made | own)


def _faces(mesh: bpy.types.Mesh, corners: np.ndarray) -> bytes:
    """The corners of each face and its material, the faces sorted."""
    starts, materials = (np.empty(len(mesh.polygons), np.int32) for _ in range(2))
    mesh.polygons.foreach_get("loop_start", starts)
    mesh.polygons.foreach_get("material_index", materials)
    faces = np.split(corners, starts[1:]) if len(starts) else []
    return repr(sorted((*face.tolist(), -1 - m) for face, m in zip(faces, materials.tolist(), strict=True))).encode()


def _state() -> tuple:
    """The state of Blender that decides a picture beside the test's sources."""
    scene = bpy.context.scene
    render, holder = scene.render, scene.camera
    camera = holder.data if holder else None
    seen = camera and (camera.type, camera.lens, camera.shift_x, camera.shift_y, camera.sensor_width, camera.clip_end)
    place = holder and tuple(tuple(row) for row in holder.matrix_world)
    opened = Path(bpy.data.filepath) if bpy.data.filepath else None
    data = hashlib.blake2b(opened.read_bytes()).hexdigest() if opened and opened.exists() else None
    numbers = (render.resolution_x, render.resolution_y, render.resolution_percentage, scene.frame_current)
    return (
        bpy.app.version_string,
        bpy.app.build_hash,
        numbers,
        scene.cycles.samples,
        scene.cycles.seed,
        seen,
        place,
        data,
    )
