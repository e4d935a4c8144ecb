# SPDX-License-Identifier: GPL-3.0-or-later
"""The steps from a scene of Blender to the engine's scene that a render and a measurement share."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from typing import Any

import bpy

from petzval.description import OF_LENS_FILE, CameraDescription, focused

from .. import export
from ..data import lens_words
from ..export import aperture_mask, dicing, viewport
from ..export import camera as camera_export
from ..export.baking import Baked
from ..export.kept import Kept
from ..export.motion import Motion
from ..export.report import Report
from ..export.shutter import Blur
from ..export.stereo import Eye


def camera(
    scene: bpy.types.Scene, width: int, height: int, report: Report, eye: Eye | None = None
) -> CameraDescription:
    """The scene's camera, or that of a view in stereo, with the mask of its diaphragm."""
    holder = scene.camera if eye is None else eye.holder
    found = camera_export.describe(holder, scene, width, height, report, eye=eye)
    return aperture_mask.added(found, holder.data)


def tell_of_lens(native: Any, camera: CameraDescription, width: int, height: int, report: Report) -> None:
    """Warns of the rows of the lens's file that could not be used, and of glasses that are not known at the camera's own wavelength."""
    if camera.model == "PINHOLE":
        return
    if camera.model == "CALIBRATED":
        # A complaint that there is no calibration comes when the camera is made.
        with contextlib.suppress(native.PetzvalError):
            for remark in native.calibration_remarks(camera, width, height):
                report.warn(remark)
        return
    try:
        info = json.loads(native.camera_info_json(camera, width, height))
        coverage = json.loads(native.coverage_json(camera, width, height))
    except native.PetzvalError:
        return  # said when the camera is made
    for note in [*info["remarks"], *(info["beyond_range"] if camera.wavelength_nm is not None else [])]:
        report.warn(note)
    if coverage["complaint"]:
        report.warn(coverage["complaint"])


def in_a_line(native: Any, camera: CameraDescription, width: int, height: int, by: str) -> str:
    """The camera of the picture, in a line; `by`: the source of its focus, if not the user."""
    info = None
    if camera.model in OF_LENS_FILE:
        # A complaint comes when the camera is made.
        with contextlib.suppress(native.PetzvalError):
            info = json.loads(native.camera_info_json(camera, width, height))
    return lens_words.in_a_line(camera, info, by)


def fill(
    builder: Any,
    depsgraph: bpy.types.Depsgraph,
    seen_by: CameraDescription,
    size: tuple[int, int],
    report: Report,
    check_stop: Callable[[], None] = lambda: None,
    motion: Motion | None = None,
    blur: Blur | None = None,
    *,
    only_catchers: bool = False,
    kept: Kept | None = None,
    seen_in: bpy.types.SpaceView3D | None = None,
    eye: Eye | None = None,
    baked: Baked | None = None,
) -> bool:
    """Tells the engine's `SceneBuilder` all that the camera may see; returns True if something catches shadows. `only_catchers`: objects
    that do not are holes for the camera, and nothing to all else. `eye`: of a view in stereo. `kept`, `seen_in` and `baked` as
    `export.send_scene` has them."""
    catches = export.send_scene(
        depsgraph,
        builder,
        report,
        check_stop,
        motion,
        blur,
        only_catchers=only_catchers,
        kept=kept,
        seen_in=seen_in,
        camera=None if eye is None else eye.holder,
        baked=baked,
    )
    viewport.send(builder, seen_by, *size)
    if (dicing_camera := dicing.camera(depsgraph)) is not None:
        scene = depsgraph.scene_eval
        dicing_seen = camera_export.describe(dicing_camera, scene, *size, report, model="PINHOLE")
        viewport.send(builder, dicing_seen, *size, dices=True)
    return catches


def fill_sky(
    builder: Any, depsgraph: bpy.types.Depsgraph, seen_by: CameraDescription, size: tuple[int, int], report: Report
) -> None:
    """Tells a `SceneBuilder` of the sky alone."""
    export.send_sky(depsgraph, builder, report)
    viewport.send(builder, seen_by, *size)


def place(of: CameraDescription) -> tuple[float, float, float]:
    """The position of a camera in the world."""
    return tuple(row[3] for row in of.matrix_world[:3])


def focus(
    native: Any, scene: Any, of: CameraDescription, width: int, height: int
) -> tuple[CameraDescription, dict[str, Any]]:
    """The camera with its film where the subject of its autofocus point is sharpest, and the engine's `autofocus_json`."""
    found = json.loads(native.autofocus_json(scene, of, width, height, of.focus.autofocus))
    return focused(of, found), found
