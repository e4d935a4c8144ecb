# SPDX-License-Identifier: GPL-3.0-or-later
"""The render that ground truth comes from: its settings in Blender, and their restoration. Needs Blender."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from .. import render_in_blender as rendering
from ..description import OF_LENS_FILE
from ..errors import CommandError
from . import cameras
from .ground_truth import Passes
from .spec import Labels

#: A filter so narrow that a pixel's rays go through its middle; 0 would be a box of a pixel.
_NARROW_PX = 0.01
#: Old names of the pass of indices.
_INDICES = ("Object Index", "IndexOB")
#: Renders for the pixels whose rays were lost: of a lens that loses a tenth of its rays, 1e-8 are lost in all; and the distance of their
#: seeds.
_MOST_ROUNDS, _BETWEEN_SEEDS = 8, 7919
_LAYER_PASSES = ("use_pass_z", "use_pass_position", "use_pass_normal", "use_pass_object_index")


class _Settings:
    """Settings of Blender that are changed for a while."""

    def __init__(self) -> None:
        self._before: list[tuple[Any, str, bool, Any]] = []

    def set(self, owner: Any, name: str, value: Any) -> None:
        """Sets a setting where the owner has it."""
        if owner is None or not hasattr(owner, name):
            return
        self._before.append((owner, name, owner.is_property_set(name), getattr(owner, name)))
        setattr(owner, name, value)

    def back(self) -> None:
        """Restores all settings: those that were never set count as never set again."""
        for owner, name, was_set, value in reversed(self._before):
            if was_set:
                setattr(owner, name, value)
            else:
                owner.property_unset(name)


def sharp(holder: Any, f_number: float) -> Any:
    """A copy of a camera with a small opening, for one wavelength; for `removed` afterwards."""
    import bpy

    made = holder.copy()
    made.data = holder.data.copy()
    bpy.context.scene.collection.objects.link(made)
    own = made.data.petzval
    if own.model == "THIN":
        own.model = "PINHOLE"
    elif own.model in OF_LENS_FILE:
        own.wide_open, own.pupil_diameter, own.f_number = False, 0.0, f_number
        own.aperture_mask, own.blades = None, 0
        own.spectrum, own.wavelength = "SINGLE", cameras.WAVELENGTH_NM
        own.physical_exposure = False
    return made


def removed(holder: Any) -> None:
    """Takes a camera that `sharp` has made out of the file."""
    import bpy

    data = holder.data
    bpy.data.objects.remove(holder)
    bpy.data.cameras.remove(data)


@contextlib.contextmanager
def _set(scene: Any, layer: Any, asked: Labels, *, with_flow: bool) -> Iterator[None]:
    settings = _Settings()
    own, cycles = scene.petzval, getattr(scene, "cycles", None)
    try:
        for other in scene.view_layers:
            settings.set(other, "use", other == layer)
        for name in _LAYER_PASSES:
            settings.set(layer, name, True)
        settings.set(layer, "use_pass_vector", with_flow)
        settings.set(scene.render, "use_motion_blur", False)
        # Of the number of samples and the filter nothing is left to Cycles.
        for name, value in (("samples", asked.samples), ("use_noise_threshold", False), ("time_limit", 0.0), ("integrator", "PATH"),
                            ("use_light_tracing", False), ("use_blue_noise", False), ("pipeline", "FILM")):  # fmt: skip
            settings.set(own, name, value)
        if asked.rays == "centre":
            settings.set(own, "filter_width", _NARROW_PX)
        for name in ("diffraction", "glare", "ghosts"):
            settings.set(own.effects, name, "OFF")
        settings.set(cycles, "use_denoising", False)
        settings.set(cycles, "use_layer_samples", "IGNORE")
        settings.set(cycles, "max_bounces", 0)
        yield
    finally:
        settings.back()


def taken(scene: Any, addon: Any, asked: Labels, *, beside: Any, number_of: Any) -> Passes | None:
    """Renders the passes of the scene's camera; None where the render was broken off. `beside`: the neighbouring pictures, for flow;
    `number_of` numbers instances. Raises `CommandError`.

    Of the single rays of a lens some are lost in it, others for each seed: pixels without a hit are looked at again, until nothing new is found.
    """
    layer = next(one for one in scene.view_layers if one.use)
    rounds = _MOST_ROUNDS if asked.rays == "centre" and scene.camera.data.petzval.model in OF_LENS_FILE else 1
    found: Passes | None = None
    seed = scene.petzval.seed
    try:
        with _set(scene, layer, asked, with_flow=beside is not None):
            for number in range(rounds):
                scene.petzval.seed = (seed + number * _BETWEEN_SEEDS) % 2**31
                more = _once(scene, addon, layer, beside, number_of)
                if more is None:
                    return None
                if found is not None and not found.fill(more):
                    break
                found = more if found is None else found
                if found.is_full:
                    break
    finally:
        scene.petzval.seed = seed
    return found


def _once(scene: Any, addon: Any, layer: Any, beside: Any, number_of: Any) -> Passes | None:
    """One render of the passes."""
    watch, numbers = addon.render.loop.WATCH, addon.export.object_info.NUMBERS
    found: dict[str, Any] = {}

    def keep(of_layer: str, _view: str, name: str, pixels: Any) -> None:
        if of_layer == layer.name:
            found[name] = np.flipud(pixels).astype(np.float64)

    watch.taken, watch.beside, numbers.of = keep, beside, number_of
    try:
        problem = rendering.take(scene, watch, writes=False)
    finally:
        watch.taken, watch.beside, numbers.of = None, None, None
    if problem is not None:
        raise CommandError(problem)
    if watch.stop.is_set():
        return None
    index = next((found[name] for name in _INDICES if name in found), None)
    if index is None:
        raise CommandError("no ground truth came of the render: look at what Blender said")
    shape = index.shape[:2]
    return Passes(
        found["Depth"].reshape(shape), found["Position"], found["Normal"], index.reshape(shape), found.get("Vector")
    )
