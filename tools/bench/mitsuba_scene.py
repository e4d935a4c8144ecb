# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as Mitsuba takes it. Imported where mitsuba is, with a variant chosen."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from . import scene


def write_meshes(folder: Path) -> None:
    """One PLY an object beside the plain data, unless they are there."""
    about, arrays = scene.read(folder)
    for one in about["objects"]:
        target = folder / f"{one['name']}.ply"
        if not target.exists():
            name = one["name"]
            parts = (arrays[f"{name}.{part}"] for part in ("vertices", "normals", "triangles"))
            target.write_bytes(_ply(*parts))


def _ply(vertices: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> bytes:
    """Binary, little endian."""
    names = ("x", "y", "z", "nx", "ny", "nz")
    header = "\n".join(
        [
            "ply",
            "format binary_little_endian 1.0",
            f"element vertex {len(vertices)}",
            *(f"property float {name}" for name in names),
            f"element face {len(triangles)}",
            "property list uchar int vertex_indices",
            "end_header\n",
        ]
    )
    faces = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    return header.encode() + np.hstack([vertices, normals]).astype("<f4").tobytes() + faces.tobytes()


def _bsdf(facts: dict) -> dict[str, Any]:
    if facts["kind"] == "glass":
        return {"type": "dielectric", "int_ior": facts["ior"], "ext_ior": 1.0}
    colour = {"type": "rgb", "value": list(facts["rgb"])}
    if facts["kind"] == "diffuse":
        one_sided: dict[str, Any] = {"type": "diffuse", "reflectance": colour}
    else:
        # No material: it reflects all, times the colour, as Blender's Glossy does.
        one_sided = {
            "type": "roughconductor",
            "material": "none",
            "distribution": "ggx",
            "alpha": facts["alpha"],
            "specular_reflectance": colour,
        }
    return {"type": "twosided", "bsdf": one_sided}


def description(folder: Path, size: tuple[int, int], thin: bool) -> dict[str, Any]:
    """The description of the scene for `mitsuba.load_dict`."""
    about, arrays = scene.read(folder)
    camera = about["camera"]
    eye = list(camera["eye"])
    sensor = {
        "type": "thinlens" if thin else "perspective",
        "fov_axis": "x",
        "fov": 2.0 * math.degrees(math.atan(0.5 * camera["film_width_mm"] / camera["focal_length_mm"])),
        "near_clip": 0.01,
        "far_clip": 1000.0,
        "to_world": mi.ScalarTransform4f().look_at(origin=eye, target=[eye[0], eye[1] + 1.0, eye[2]], up=[0, 0, 1]),
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent"},
    }
    if thin:
        sensor["aperture_radius"] = 0.5e-3 * camera["focal_length_mm"] / camera["f_number"]
        sensor["focus_distance"] = camera["focus_m"]
    made: dict[str, Any] = {
        "type": "scene",
        # The light that is seen directly counts as depth one, and the last bounce still meets a light.
        "integrator": {"type": "path", "max_depth": camera["bounces"] + 2},
        "sensor": sensor,
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(arrays["sky"]),
            "to_world": mi.ScalarTransform4f().rotate(axis=[1, 0, 0], angle=90),
        },
    }
    for name, facts in about["materials"].items():
        made[f"material_{name}"] = _bsdf(facts)
    for one in about["objects"]:
        shape: dict[str, Any] = {"type": "ply", "filename": str(folder / f"{one['name']}.ply")}
        if one["emits"]:
            shape["face_normals"] = True
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": one["emits"]}}
            shape["bsdf"] = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0, 0.0, 0.0]}}
        else:
            shape["bsdf"] = {"type": "ref", "id": f"material_{one['material']}"}
        made[one["name"]] = shape
    return made
