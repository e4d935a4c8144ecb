# SPDX-License-Identifier: GPL-3.0-or-later
"""Intrinsic parameters of a camera: exact for cameras without a lens file, fitted to the exact rays of those with one."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _native
from ..description import OF_LENS_FILE, CameraDescription, changed
from ..errors import CommandError
from . import lens_fit

#: Blender's cameras without a lens file that project centrally.
_CENTRAL = ("PINHOLE", "THIN")
#: The wavelength of the rays of ground truth: the d line.
WAVELENGTH_NM = 587.5618
#: The f-number of a lens for rays that go through the middle of its diaphragm. At larger ones rays that are aimed at the diaphragm
#: begin to miss.
F_NUMBER = 100.0
#: Pixels along the longer side at which a lens's rays are looked up for a fit.
_LOOKED_UP = 24


@dataclass(frozen=True)
class Intrinsics:
    """The projection of a camera: points of camera space (x right, y down, z forward) to pixels, right and down from the picture's upper
    left corner: the middle of the first pixel is (0.5, 0.5), as COLMAP counts."""

    #: A key of `lens_fit.DISTORTION`.
    model: str
    #: fx, fy, cx, cy and those of the model, as `lens_fit.project` takes them.
    parameters: tuple[float, ...]
    width: int
    height: int
    #: Distances between the model and the camera, pixels: root mean square and largest; 0 where the model is the camera.
    rms_px: float = 0.0
    largest_px: float = 0.0

    @property
    def named(self) -> dict[str, float]:
        """The parameters by OpenCV's names, with pixel coordinates of the corner."""
        return dict(zip(("fx", "fy", "cx", "cy", *lens_fit.DISTORTION[self.model]), self.parameters, strict=True))

    def project(self, points: lens_fit.Array) -> lens_fit.Array:
        """Pixels (n, 2) of points (n, 3)."""
        return lens_fit.project(self.model, np.array(self.parameters), points)

    @classmethod
    def of_json(cls, told: dict[str, Any]) -> Intrinsics:
        """The intrinsics that `as_json` gave."""
        names = ("fx", "fy", "cx", "cy", *lens_fit.DISTORTION[told["model"]])
        parameters = tuple(told[name] for name in names)
        return cls(told["model"], parameters, told["width"], told["height"], told["fit_rms_px"], told["fit_largest_px"])

    def as_json(self) -> dict[str, Any]:
        """The intrinsics as they stand in cameras.json."""
        return {
            "model": self.model, "width": self.width, "height": self.height, **self.named,
            "fit_rms_px": self.rms_px, "fit_largest_px": self.largest_px,
        }  # fmt: skip


def intrinsics(camera: CameraDescription, width: int, height: int) -> Intrinsics:
    """The parameters of a camera. Raises `CommandError` where no model of these shows as it does."""
    if camera.model in _CENTRAL:
        return Intrinsics("PINHOLE", _of_perspective(camera, width, height), width, height)
    if camera.model not in OF_LENS_FILE:
        raise CommandError(
            f"camera '{camera.object_name}' is {camera.model.lower()}, which COLMAP, NeRF and KITTI have no camera for: make it a "
            "perspective camera, or leave out cameras"
        )
    return _of_lens(camera, width, height)


def _of_perspective(camera: CameraDescription, width: int, height: int) -> tuple[float, ...]:
    """fx, fy, cx, cy of Blender's perspective camera: the shift is in parts of the picture's longer side, that of the view, so that the
    axis goes the other way."""
    own, aspect = camera.perspective, camera.pixel_aspect
    focal_px = own.focal_length_mm / own.film_width_mm * width
    larger = max(width, height * aspect)
    shift_x, shift_y = own.shift
    return focal_px, focal_px / aspect, width / 2 - shift_x * larger, height / 2 + shift_y * larger / aspect


def _of_lens(camera: CameraDescription, width: int, height: int) -> Intrinsics:
    """OpenCV's model of five coefficients, or its fisheye model where that is nearer, fitted to the rays of the lens through the
    middle of its diaphragm."""
    anchor = camera.focus.focusing.anchor
    if anchor != "ENTRANCE_PUPIL":
        raise CommandError(
            f"camera '{camera.object_name}' stands where its {anchor.lower().replace('_', ' ')} is, and its pictures are projected through the entrance "
            'pupil: set anchor = "entrance-pupil", or leave out cameras'
        )
    wavelength_nm = camera.wavelength_nm or WAVELENGTH_NM
    camera = changed(camera, {"wavelength_nm": wavelength_nm, "lens.f_number": F_NUMBER})
    looked_up = min(_LOOKED_UP / max(width, height), 1.0)
    across, down = max(round(width * looked_up), 8), max(round(height * looked_up), 8)
    try:
        info = json.loads(_native.camera_info_json(camera, width, height))
        # Where the pinhole that frames the same shows what a pixel of the lens sees.
        found = _native.distortion_map(camera, across, down, wavelength_nm, "DISTORT").astype(float)
    except _native.PetzvalError as error:
        raise CommandError(f"camera '{camera.object_name}': no intrinsic parameters: {error}") from None
    seen = (found[..., :2] != 0.0).any(axis=-1)
    rows, columns = np.nonzero(seen)
    if len(rows) < 32:
        raise CommandError(
            f"camera '{camera.object_name}': the lens shows nothing that a pinhole could: leave out cameras"
        )
    pixels = np.stack([(columns + 0.5) / across * width, height - (rows + 0.5) / down * height], axis=1)
    focal = info["viewport_focal_length_mm"]
    sides = np.array([info["picture_width_mm"], info["picture_height_mm"]])
    larger = max(sides)
    shift = np.array(info["viewport_shift"]) * larger
    # Right and up on the pinhole's film, before it.
    places = (found[rows, columns, :2] - 0.5) * sides + shift
    directions = np.stack([places[:, 0] / focal, -places[:, 1] / focal, np.ones(len(places))], axis=1)
    start = np.array([focal / sides[0] * width, focal / sides[1] * height, width / 2, height / 2])
    start[2:] -= shift * np.array([width, -height]) / sides
    fitted = []
    for model in ("OPENCV", "OPENCV_FISHEYE"):
        parameters, off = lens_fit.fit(model, pixels, directions, start)
        fitted.append((float(np.max(off)), model, parameters, float(math.sqrt((off * off).mean()))))
    # Its own equations are those of most programs: the other one has to be better by much.
    largest, model, parameters, rms = (
        fitted[1] if fitted[1][0] < 0.5 * fitted[0][0] and fitted[0][0] > 0.05 else fitted[0]
    )
    return Intrinsics(model, tuple(map(float, parameters)), width, height, rms, largest)
