# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair of particle systems as strands. Blender hands it over key by key; all else is done for whole arrays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Any, NamedTuple

import bpy
import numpy as np

from . import attributes
from .curves import CurveArrays


class System(NamedTuple):
    """A particle system whose hair is drawn."""

    modifier: bpy.types.ParticleSystemModifier
    hair: bpy.types.ParticleSystem
    #: The numbers of the particles that are drawn: the children, where there are any, instead of their parents.
    particles: range
    keys_each: int

    @property
    def settings(self) -> bpy.types.ParticleSettings:
        return self.hair.settings


def systems(place: bpy.types.DepsgraphObjectInstance, is_render: bool) -> Iterator[System]:
    """The hair of an object in Cycles's order."""
    holder = place.object
    if not place.show_particles or holder.mode in ("EDIT", "PARTICLE_EDIT"):
        return
    for modifier in holder.modifiers:
        if modifier.type != "PARTICLE_SYSTEM" or not (modifier.show_render if is_render else modifier.show_viewport):
            continue
        hair = modifier.particle_system
        settings = hair.settings
        if settings is None or settings.type != "HAIR" or settings.render_type != "PATH":
            continue
        parents, children = len(hair.particles), len(hair.child_particles)
        has_children = settings.child_type != "NONE" and children > 0
        particles = range(parents if has_children else 0, parents + children)
        steps = settings.render_step if is_render else settings.display_step
        extra = settings.kink_extra_steps if settings.kink == "SPIRAL" else 0
        if len(particles) > 0:
            yield System(modifier, hair, particles, (1 << steps) + 1 + extra)


def places(holder: bpy.types.Object, system: System) -> np.ndarray:
    """The keys, (strands, keys each, 3), object space."""
    strands, each = len(system.particles), system.keys_each
    co_hair = system.hair.co_hair
    keys = (co_hair(holder, particle_no=i, step=step) for i in system.particles for step in range(each))
    world = np.fromiter(chain.from_iterable(keys), np.float64, strands * each * 3).reshape(strands, each, 3)
    # A strand that was cut short has no more keys: the last one stands for them.
    for step in range(1, each):
        missing = ~world[:, step].any(1)
        world[missing, step] = world[missing, step - 1]
    to_object = np.array(holder.matrix_world.inverted_safe())
    return (world @ to_object[:3, :3].T + to_object[:3, 3]).astype(np.float32)


def keys(holder: bpy.types.Object, system: System) -> np.ndarray:
    """Places and radii, (strands, keys each, 4), object space."""
    at = places(holder, system)
    return np.concatenate([at, _radii(at, system.settings)[:, :, np.newaxis]], 2, dtype=np.float32)


def extract(
    holder: bpy.types.Object, system: System, wanted: Iterable[str], drawn: dict[str, Any], first_number: int
) -> CurveArrays:
    """The strands of a system, with the attributes that are wanted of the mesh that they grow from."""
    balls = keys(holder, system)
    strands, each = balls.shape[:2]
    arrays = CurveArrays(
        balls.reshape(-1, 4), np.arange(strands + 1, dtype=np.int32) * np.int32(each), drawn, first_number
    )
    mesh = holder.data
    if not isinstance(mesh, bpy.types.Mesh):
        return arrays
    maps = sorted(enumerate(mesh.uv_layers), key=lambda numbered: not numbered[1].active_render)
    for number, layer in maps:
        arrays.uv_maps[layer.name] = _on_emitter(system, system.hair.uv_on_emitter, 2, uv_no=number)
    colours = [a.name for a in mesh.color_attributes if a.domain == "CORNER" and a.data_type == "BYTE_COLOR"]
    for name in sorted(wanted):
        if name == attributes.GENERATED:
            arrays.attributes[name] = (False, attributes.in_box(mesh, balls[:, 0, :3]))
        elif name in colours:
            encoded = _on_emitter(system, system.hair.mcol_on_emitter, 3, vcol_no=colours.index(name))
            values = np.ones((strands, 4), np.float32)
            values[:, :3] = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
            arrays.attributes[name] = (False, values)
    return arrays


def _radii(at: np.ndarray, settings: bpy.types.ParticleSettings) -> np.ndarray:
    """The radii by strand and key: from the root's to the tip's, by the key's place along the strand."""
    steps = np.linalg.norm(np.diff(at, axis=1), axis=2)
    along = np.concatenate([np.zeros((len(at), 1), np.float32), steps.cumsum(1)], 1)
    share = along / np.where(along[:, -1:] > 0.0, along[:, -1:], 1.0)
    shape = settings.shape
    left = np.maximum(1.0 - share, 0.0)
    left = left ** (1.0 + shape) if shape < 0.0 else left ** (1.0 / max(1.0 - shape, 1e-6))
    root, tip = (0.5 * settings.radius_scale * radius for radius in (settings.root_radius, settings.tip_radius))
    radii = tip + (root - tip) * left
    if settings.use_close_tip:
        radii[:, -1] = 0.0
    return radii


def _on_emitter(system: System, read: Any, width: int, **which: int) -> np.ndarray:
    """The values of the emitter's mesh at the strands' roots, (strands, width)."""
    particles = system.hair.particles
    parents = len(particles)
    values = (
        read(system.modifier, particle=particles[i if i < parents else 0], particle_no=i, **which)[:width]
        for i in system.particles
    )
    count = len(system.particles) * width
    return np.fromiter(chain.from_iterable(values), np.float32, count).reshape(-1, width)
