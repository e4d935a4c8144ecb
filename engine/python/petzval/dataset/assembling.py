# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that are about all pictures of a data set, from the records of those that are whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .. import atomic_files
from . import camera_files, coco
from .cameras import Intrinsics
from .records import Record
from .spec import Spec


def assemble(folder: Path, spec: Spec, records: list[Record]) -> None:
    """Writes cameras.json and those of COLMAP's, NeRF's, KITTI's and COCO's files that are asked for. Raises `OSError`."""
    write = spec.write
    atomic_files.write_json(
        folder / "cameras.json",
        [
            {"name": one.name, "camera": one.camera, "frame": one.frame, "time_s": one.time_s, "camera_to_world": one.pose,
             "metres_per_unit": one.metres_per_unit, "intrinsics": one.intrinsics, "reprojection_px": one.reprojection_px, "files": one.files}
            for one in records
        ],
        indent=1,
    )  # fmt: skip
    if write.cameras and records:
        views = [_view(one) for one in records]
        if "colmap" in write.cameras:
            model = folder / "colmap" / "sparse" / "0"
            model.mkdir(parents=True, exist_ok=True)
            camera_files.write_colmap(model, views, _points(records))
        if "nerf" in write.cameras:
            camera_files.write_nerf(folder / "transforms.json", views)
        if "kitti" in write.cameras:
            (folder / "kitti").mkdir(exist_ok=True)
            camera_files.write_kitti(folder / "kitti", views)
    if write.coco != "off":
        images = [
            {
                "id": number,
                "file_name": _picture(one).removeprefix("pictures/"),
                "width": one.width,
                "height": one.height,
            }
            for number, one in enumerate(records, 1)
        ]
        categories = [{"id": one.id, "name": one.name, "supercategory": one.supercategory} for one in spec.classes]
        told = coco.whole(images, [one.annotations for one in records], categories)
        atomic_files.write_json(folder / "annotations.json", told)


def _picture(record: Record) -> str:
    """The picture's file; its name alone where no pictures are written."""
    return record.files.get("picture", f"pictures/{record.name}.png")


def _view(record: Record) -> camera_files.View:
    assert record.intrinsics is not None
    return camera_files.View(
        _picture(record), record.camera, Intrinsics.of_json(record.intrinsics), np.array(record.pose), record.metres_per_unit,
        record.time_s,
    )  # fmt: skip


def _points(records: list[Record]) -> list[camera_files.Point]:
    found: list[camera_files.Point] = []
    for number, record in enumerate(records, 1):
        for x, y, z, r, g, b, u, v in record.points:
            found.append((x, y, z, int(r), int(g), int(b), number, u, v))
    return found
