# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of ground truth of one picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import coco, ground_truth, raster_files
from .cameras import Intrinsics
from .ground_truth import Passes
from .instances import Instances
from .records import Record
from .spec import Spec, Write


def needs_passes(write: Write) -> bool:
    """True if a file is written that comes from the passes of a render."""
    return (
        any(one != "off" for one in (write.depth, write.normal, write.position, write.flow, write.coco))
        or write.instances
        or write.classes
        or write.points > 0
    )


def write_passes(
    folder: Path,
    spec: Spec,
    record: Record,
    passes: Passes,
    table: Instances,
    has_before: bool,
    has_after: bool,
    colours: list[Any],
) -> None:
    """Writes all that is asked for of a picture's passes, and names it in its record. Raises `OSError`."""
    write = spec.write
    pose = np.array(record.pose)
    ids = np.where(passes.hits, np.rint(passes.index), 0).astype(np.uint16)

    def file(kind: str, end: str) -> Path:
        (folder / kind).mkdir(exist_ok=True)
        record.files[kind] = f"{kind}/{record.name}.{end}"
        return folder / record.files[kind]

    if write.depth != "off":
        depth = ground_truth.depth_m(passes, pose, write.depth_along, record.metres_per_unit)
        if write.depth == "exr":
            way = {"axis": "the camera's axis", "ray": "the ray"}[write.depth_along]
            # Luminance: of a file with Z alone OpenCV and Blender 4.5 read no pixel.
            raster_files.write_exr(file("depth", "exr"), {"Y": depth}, f"Metres along {way}; 1e10: nothing")
        else:
            raster_files.write_png(file("depth", "png"), ground_truth.depth_levels(depth, write.depth_scale))
    if write.normal != "off":
        values = ground_truth.normals(passes, pose, write.normal_frame)
        if write.normal == "exr":
            axes = {"camera": "camera space, x right, y down, z forward", "world": "world space"}[write.normal_frame]
            raster_files.write_exr(file("normal", "exr"), _rgb(values), f"Unit normals in {axes}; 0: nothing")
        else:
            raster_files.write_png(file("normal", "png"), ground_truth.normal_levels(values, passes.hits))
    if write.position != "off":
        places = np.where(passes.hits[..., None], passes.position * record.metres_per_unit, 0.0)
        raster_files.write_exr(file("position", "exr"), _rgb(places), "World space, metres; 0, 0, 0: nothing")
    if write.instances:
        raster_files.write_png(file("instances", "png"), ids)
    if write.classes:
        raster_files.write_png(file("classes", "png"), table.classes_of(ids))
    if passes.vector is not None:
        for direction, is_there in (("forward", has_after), ("backward", has_before)):
            if direction in write.flow_directions and is_there:
                _write_flow(write.flow, f"flow_{direction}", file, passes, ground_truth.flow(passes.vector, direction))
    if write.coco != "off":
        record.annotations = coco.annotated(ids, table.category_of, write.coco, write.least_area)
    if record.intrinsics is not None and spec.labels.rays == "centre" and passes.hits.any():
        record.reprojection_px = _reprojection(record, passes)
    if write.points:
        record.points = _points(record, passes, write.points, colours)


def _write_flow(form: str, kind: str, file: Any, passes: Passes, values: npt.NDArray[np.float64]) -> None:
    known = ground_truth.known_flow(values, passes.hits)
    if form == "flo":
        raster_files.write_flo(file(kind, "flo"), values.astype(np.float32), known)
    elif form == "exr":
        raster_files.write_exr(
            file(kind, "exr"), _rgb(np.dstack([values, known])), "Pixels: R right, G down; B 1: known"
        )
    else:
        raster_files.write_png(file(kind, "png"), ground_truth.kitti_flow(values, known)[0])


def _reprojection(record: Record, passes: Passes) -> list[float]:
    """The distances of the picture's places, as the written parameters project them, from the middles of their pixels: median and largest,
    pixels."""
    assert record.intrinsics is not None
    rows, columns = np.nonzero(passes.hits)
    seen = ground_truth.in_camera(passes.position[rows, columns], np.array(record.pose))
    shown = Intrinsics.of_json(record.intrinsics).project(seen)
    off = np.linalg.norm(shown - np.stack([columns + 0.5, rows + 0.5], axis=1), axis=1)
    return [float(np.median(off)), float(np.max(off))]


def _rgb(values: npt.NDArray[np.float64]) -> dict[str, npt.NDArray[np.float64]]:
    """Three channels by the names that viewers show as colours."""
    return {name: values[..., i] for i, name in enumerate("RGB")}


def _points(record: Record, passes: Passes, count: int, colours: list[Any]) -> list[list[float]]:
    """Places that a picture shows, with colours and pixels, at random by the picture's number: x, y, z in metres, r, g, b, x and y in pixels."""
    rows, columns = np.nonzero(passes.hits)
    if not len(rows):
        return []
    chance = np.random.default_rng(int(record.key[:12], 16))
    chosen = np.sort(chance.choice(len(rows), min(count, len(rows)), replace=False))
    rows, columns = rows[chosen], columns[chosen]
    seen = np.full((len(rows), 3), 128.0)
    if colours:
        # As a screen shows it, by sRGB alone.
        linear = np.clip(colours[0][rows, columns, :3].astype(float), 0.0, 1.0)
        seen = np.rint(255.0 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))
    places = passes.position[rows, columns] * record.metres_per_unit
    pixels = np.stack([columns + 0.5, rows + 0.5], axis=1)
    found: list[list[float]] = np.concatenate([places, seen, pixels], axis=1).tolist()
    return found
