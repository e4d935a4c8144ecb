# SPDX-License-Identifier: GPL-3.0-or-later
"""The specification of a data set, in TOML: read and checked as far as it can be without Blender."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import argument_types as types
from . import cameras, options, pose_files, poses
from .tables import Table


@dataclass(frozen=True)
class CameraSpec:
    """One camera of a rig."""

    name: str
    #: The camera of the scene that it is made from; empty: the scene's active one.
    based_on: str
    #: The options as `render_in_blender.apply` takes them.
    options: dict[str, Any]
    #: The pose in the rig's axes, which are those of a camera.
    in_rig: poses.Pose


@dataclass(frozen=True)
class Listed:
    """Poses that are written down, as matrices once the names of targets are known."""

    poses: tuple[poses.Pose, ...]


@dataclass(frozen=True)
class FromFile:
    """Poses of a file, whose lengths are metres."""

    file: Path
    format: str


@dataclass(frozen=True)
class Path_:
    """Poses of an object of the scene in each frame, or along a curve."""

    object: str
    target: poses.Vector | str | None


@dataclass(frozen=True)
class Orbit:
    """Poses on a circle."""

    centre: poses.Vector | str
    radius: float
    elevation_deg: float
    count: int
    start_deg: float


@dataclass(frozen=True)
class Random:
    """Poses by chance, in a box or in a shell about a centre, none inside of or near to objects."""

    count: int
    seed: int
    #: Lower and upper corner; None: a shell.
    box: tuple[poses.Vector, poses.Vector] | None
    centre: poses.Vector | str
    radius: tuple[float, float]
    elevation_deg: tuple[float, float]
    target: poses.Vector | str | None
    #: The largest turn of the direction from the target, degrees.
    jitter_deg: float
    clearance: float
    rejects_inside: bool


@dataclass(frozen=True)
class ClassSpec:
    """A class of objects: those for which any of these conditions holds."""

    name: str
    id: int
    supercategory: str
    objects: tuple[str, ...]
    collections: tuple[str, ...]
    materials: tuple[str, ...]
    pass_index: int | None
    #: The name of a custom property, and its value as text; empty: any.
    property: tuple[str, str] | None


@dataclass(frozen=True)
class Write:
    """The files to write, and their formats."""

    picture: str
    depth: str
    depth_along: str
    depth_scale: float
    normal: str
    normal_frame: str
    position: str
    instances: bool
    classes: bool
    flow: str
    flow_directions: tuple[str, ...]
    cameras: tuple[str, ...]
    points: int
    coco: str
    least_area: int


@dataclass(frozen=True)
class Labels:
    """The rays of ground truth: one through the middle of each pixel and of the diaphragm, or as many as make the picture."""

    rays: str
    samples: int
    #: The f-number of the lens for rays through the middle.
    f_number: float = cameras.F_NUMBER


@dataclass(frozen=True)
class Spec:
    """The whole specification."""

    file: Path
    scene: Path
    output: Path
    frames: tuple[int, ...] | None
    cameras: tuple[CameraSpec, ...]
    source: Listed | FromFile | Path_ | Orbit | Random
    classes: tuple[ClassSpec, ...]
    labels: Labels
    write: Write


_SOURCES = ("pose", "poses", "path", "orbit", "random")


def read(file: Path) -> Spec:
    """The specification of a file. Raises `CommandError` with the line, the key and the remedy."""
    table, folder = Table.read(file), file.parent
    scene, output = table.text("scene"), table.text("output")
    if scene is None or output is None:
        raise table.wrong(f"{'scene' if scene is None else 'output'} is missing: name the {'.blend file' if scene is None else 'folder that is written'}")  # fmt: skip
    if not (folder / scene).is_file():
        raise table.wrong(f"no such scene: {folder / scene}: name a .blend file", "scene")
    frames = _frames(table)
    cameras = _cameras(table, folder / scene, folder)
    source = _source(table, folder)
    classes = tuple(_classes(table))
    labels = _labels(table)
    write = _write(table)
    table.end()
    if isinstance(source, Path_) and frames is None:
        raise table.wrong('[path] needs frames: frames = "1-10"')
    return Spec(file, folder / scene, folder / output, frames, cameras, source, classes, labels, write)


def _frames(table: Table) -> tuple[int, ...] | None:
    value = table.take("frames")
    if value is None:
        return None
    try:
        if isinstance(value, list):
            return tuple(types.frame(str(one)) for one in value)
        return tuple(types.frames(str(value)))
    except (argparse.ArgumentTypeError, ValueError) as error:
        raise table.wrong(f'must be "FIRST-LAST", "FIRST-LAST,STEP" or a list of frames: {error}', "frames") from None


def _cameras(table: Table, scene: Path, folder: Path) -> tuple[CameraSpec, ...]:
    render = table.table("render")
    words = {} if render is None else options.words_of(render, options.OF_RENDER, folder)
    if render is not None:
        options.checked(scene, words, render)
        render.end()
    found: list[CameraSpec] = []
    tables = table.tables("camera")
    for own in tables:
        name = own.text("name", f"camera{len(found)}" if len(tables) > 1 else "camera") or ""
        if not name.replace("-", "").replace("_", "").isalnum() or not name.isascii():
            raise own.wrong("must be of letters, digits, - and _: it stands in names of files", "name")
        if name in (one.name for one in found):
            raise own.wrong(f"there are two cameras of the name {name}", "name")
        based_on = own.text("from", None) or ""
        in_rig = _pose(own, is_of_rig=True)
        of_camera = options.words_of(own, (*options.OF_CAMERA, "resolution"), folder)
        own.end()
        found.append(CameraSpec(name, based_on, options.checked(scene, words | of_camera, own), in_rig))
    if not found:
        found.append(CameraSpec("camera", "", options.checked(scene, words, render or table), poses.Pose()))
    return tuple(found)


def _vector(table: Table, key: str, default: poses.Vector | None = None) -> poses.Vector | None:
    found = table.numbers(key, 3, default)
    return None if found is None else (found[0], found[1], found[2])


def _place(table: Table, key: str, default: poses.Vector | None = None) -> poses.Vector | str | None:
    """A place, or the name of an object."""
    value = table.take(key, default)
    if value is None or (isinstance(value, str) and value):
        return value
    if not isinstance(value, list | tuple) or len(value) != 3 or not all(isinstance(one, int | float) for one in value):
        raise table.wrong("must be a list of 3 numbers, or the name of an object", key)
    return (float(value[0]), float(value[1]), float(value[2]))


def _pose(table: Table, *, is_of_rig: bool = False) -> poses.Pose:
    location = _vector(table, "location", (0.0, 0.0, 0.0) if is_of_rig else None)
    rotation, quaternion = _vector(table, "rotation"), table.numbers("quaternion", 4)
    target = None if is_of_rig else _place(table, "target")
    frame = None if is_of_rig else table.whole("frame", None, -1_048_574, 1_048_574)
    up = (0.0, 0.0, 1.0) if is_of_rig else _vector(table, "up", (0.0, 0.0, 1.0))
    if location is None:
        raise table.wrong("location is missing: location = [x, y, z]")
    if (rotation, quaternion, target).count(None) < (2 if not is_of_rig or rotation or quaternion else 2):
        raise table.wrong(
            "rotation, quaternion and target say different things of the direction: leave out all but one"
        )
    if not is_of_rig and (rotation, quaternion, target).count(None) == 3:
        raise table.wrong("a direction is missing: give rotation (degrees), quaternion (w, x, y, z) or target")
    pose = poses.Pose(location, rotation, quaternion, target, up or (0.0, 0.0, 1.0), None, frame)
    try:
        if not isinstance(target, str):
            pose.resolved(lambda _: (0.0, 0.0, 0.0))
    except ValueError as error:
        raise table.wrong(str(error)) from None
    return pose


def _source(table: Table, folder: Path) -> Listed | FromFile | Path_ | Orbit | Random:
    asked = [name for name in _SOURCES if name in table]
    # Known, and not unknown keys, whichever is taken.
    if len(asked) != 1:
        said = ", ".join(f"[{name}]" for name in asked) if asked else "nothing"
        raise table.wrong(
            f"{said} says where the camera stands: give one of [[pose]], [poses], [path], [orbit] and [random]"
        )
    kind = asked[0]
    if kind == "pose":
        found = []
        for own in table.tables("pose"):
            found.append(_pose(own))
            own.end()
        if len({one.frame is None for one in found}) > 1:
            raise table.wrong("give all poses a frame, or none", "pose")
        return Listed(tuple(found))
    its_own = table.table(kind)
    assert its_own is not None
    readers: dict[str, Callable[[Table, Path], FromFile | Path_ | Orbit | Random]] = {
        "poses": _from_file, "path": _path, "orbit": _orbit, "random": _random,
    }  # fmt: skip
    source = readers[kind](its_own, folder)
    its_own.end()
    return source


def _from_file(own: Table, folder: Path) -> FromFile:
    name = own.text("file")
    if name is None:
        raise own.wrong("file is missing: name a file of poses")
    kind = own.word("format", pose_files.FORMATS, pose_files.format_of(Path(name)) or "")
    if not (folder / name).is_file():
        raise own.wrong(f"no such file: {folder / name}", "file")
    return FromFile(folder / name, kind)


def _path(own: Table, _: Path) -> Path_:
    name = own.text("object")
    if name is None:
        raise own.wrong("object is missing: name a camera, another object or a curve of the scene")
    return Path_(name, _place(own, "target"))


def _orbit(own: Table, _: Path) -> Orbit:
    centre, count = _place(own, "centre", (0.0, 0.0, 0.0)), own.whole("count", None, 1, 1_000_000)
    if count is None or "radius" not in own:
        raise own.wrong(f"{'count' if count is None else 'radius'} is missing")
    return Orbit(
        centre or (0.0, 0.0, 0.0), own.number("radius", 1.0, above=0.0), own.number("elevation", 0.0), count, own.number("start", 0.0)
    )  # fmt: skip


def _random(own: Table, _: Path) -> Random:
    count = own.whole("count", None, 1, 1_000_000)
    if count is None:
        raise own.wrong("count is missing")
    if ("box" in own) == ("radius" in own):
        raise own.wrong("give box = [[x, y, z], [x, y, z]], or radius = [least, most] about centre")
    box = own.take("box")
    if box is not None:
        try:
            low, high = ((float(x), float(y), float(z)) for x, y, z in box)
        except (TypeError, ValueError):
            raise own.wrong("must be two corners: [[x, y, z], [x, y, z]]", "box") from None
        if any(a > b for a, b in zip(low, high, strict=True)):
            raise own.wrong("its first corner must be the lower one in x, y and z", "box")
        box = (low, high)
    radius = own.numbers("radius", 2, (1.0, 1.0)) or (1.0, 1.0)
    if not 0.0 < radius[0] <= radius[1]:
        raise own.wrong("must be [least, most], above 0", "radius")
    elevation = own.numbers("elevation", 2, (-90.0, 90.0)) or (-90.0, 90.0)
    if not -90.0 <= elevation[0] <= elevation[1] <= 90.0:
        raise own.wrong("must be [least, most], from -90 to 90 degrees", "elevation")
    centre = _place(own, "centre", (0.0, 0.0, 0.0)) or (0.0, 0.0, 0.0)
    target = _place(own, "target")
    return Random(
        count, own.whole("seed", 0) or 0, box, centre, (radius[0], radius[1]), (elevation[0], elevation[1]), target,
        own.number("jitter", 0.0), own.number("clearance", 0.1), own.switch("rejects-inside", True),
    )  # fmt: skip


def _classes(table: Table) -> list[ClassSpec]:
    own = table.table("classes")
    found: list[ClassSpec] = []
    for name in own.keys() if own is not None else ():
        assert own is not None
        one = own.table(name)
        assert one is not None
        number = one.whole("id", max((c.id for c in found), default=0) + 1, 1, 65535)
        said = one.text("property")
        by = tuple(said.partition("=")[::2]) if said else None
        made = ClassSpec(
            name, number or 0, one.text("supercategory", name) or name, one.texts("objects"), one.texts("collections"),
            one.texts("materials"), one.whole("pass-index"), (by[0].strip(), by[1].strip()) if by else None,
        )  # fmt: skip
        if not (made.objects or made.collections or made.materials or made.property or made.pass_index is not None):
            raise one.wrong(
                "says of nothing that it belongs here: give objects, collections, materials, pass-index or property"
            )
        if made.id in (c.id for c in found):
            raise one.wrong(f"another class has the number {made.id}", "id")
        one.end()
        found.append(made)
    return found


def _labels(table: Table) -> Labels:
    own = table.table("labels")
    if own is None:
        return Labels("centre", 1)
    rays = own.word("rays", ("centre", "picture"), "centre")
    for key, only in (("samples", "picture"), ("f-number", "centre")):
        if key in own and rays != only:
            raise own.wrong(f'is for rays = "{only}": leave it out', key)
    samples = own.whole("samples", 1 if rays == "centre" else 16, 1, 65536) or 1
    made = Labels(rays, samples, own.number("f-number", cameras.F_NUMBER, above=0.0))
    own.end()
    return made


def _write(table: Table) -> Write:
    own = table.table("write")
    if own is None:
        raise table.wrong('[write] is missing: say what is written, as picture = "png"')
    write = Write(
        picture=own.word("picture", ("off", "png", "exr"), "off"),
        depth=own.word("depth", ("off", "exr", "png"), "off"),
        depth_along=own.word("depth-along", ("axis", "ray"), "axis"),
        depth_scale=own.number("depth-scale", 1000.0, above=0.0),
        normal=own.word("normal", ("off", "exr", "png"), "off"),
        normal_frame=own.word("normal-frame", ("camera", "world"), "camera"),
        position=own.word("position", ("off", "exr"), "off"),
        instances=own.switch("instances", False),
        classes=own.switch("classes", False),
        flow=own.word("flow", ("off", "flo", "exr", "kitti"), "off"),
        flow_directions=own.words("flow-directions", ("forward", "backward"), ("forward",)),
        cameras=own.words("cameras", ("colmap", "nerf", "kitti"), ()),
        points=own.whole("points", 0, 0, 100_000) or 0,
        coco=own.word("coco", ("off", "rle", "polygons"), "off"),
        least_area=own.whole("least-area", 1, 1) or 1,
    )
    own.end()
    if (write.classes or write.coco != "off") and "classes" not in table._known:
        raise own.wrong("classes and coco need [classes]")
    return write
