# SPDX-License-Identifier: GPL-3.0-or-later
"""The export of Blender's evaluated scene to the engine's builder: one file per kind of datablock.

Reads only; nothing here changes the scene, and the report lists, once each, the things that cannot be handed over.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

from petzval.description import WorldDescription

from ..data import passes
from . import curves, dicing, visibility, world
from .aovs import Aovs
from .baking import Baked
from .image import Images
from .image_limit import ImageLimit
from .instances import Stage
from .kept import Kept
from .light_groups import LightGroups
from .material import Materials
from .motion import Motion
from .report import Report
from .shutter import Blur


def send_scene(
    depsgraph: bpy.types.Depsgraph,
    builder: Any,
    report: Report,
    check_stop: Callable[[], None],
    motion: Motion | None = None,
    blur: Blur | None = None,
    *,
    only_catchers: bool = False,
    kept: Kept | None = None,
    seen_in: bpy.types.SpaceView3D | None = None,
    camera: bpy.types.Object | None = None,
    baked: Baked | None = None,
) -> bool:
    """Fills a `SceneBuilder`. `check_stop` is called between objects and may raise. With `only_catchers` objects that
    do not catch shadows hold out, and are there for the camera alone. `kept`: the pieces that the builder holds already; `seen_in`:
    the view whose own choice of objects counts; `camera`: that of a view in stereo, instead of the scene's. `baked`: the object whose surface is wanted, its triangles as Blender has them. True where something is to catch shadows."""
    kept = Kept(builder) if kept is None else kept
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    images = Images(kept, report, scene.frame_current, _image_limit(depsgraph))
    aovs = Aovs(layer)
    materials = Materials(kept, images, aovs, report, layer.material_override)
    groups = LightGroups(layer)
    own = sky_of(depsgraph)
    builder.set_world(_sky(depsgraph, images, groups, aovs))
    stage = Stage(
        kept, materials, images, groups, report, check_stop, motion, blur, only_catchers=only_catchers, baked=baked
    )
    stage.send(depsgraph, seen_in, camera)
    # Bakes follow paths, whatever takes the pictures.
    is_bidirectional = scene.petzval.integrator == "BIDIRECTIONAL" and baked is None
    if is_bidirectional:
        unknown = {
            "passes of light, of mist, UV and shaders' outputs: these are black": passes.wanted_parts(
                layer, bpy.app.version
            ),
            "holdout, what holds out is seen": stage.holds_out,
            "light linking": stage.links_light,
            "limits of single kinds of bounces, only of all": visibility.limits_kinds(scene),
            "caustics that are switched off, these are shown": visibility.leaves_out_caustics(scene),
            "light groups, their passes are black": groups.names,
            "volumes, space is empty": kept.fills_space or world.fills_space(own),
            "shadow catchers, these are shown": stage.catches_shadows,
            "Transparent Glass, the sky is seen through it": scene.render.film_transparent
            and getattr(getattr(scene, "cycles", None), "film_transparent_glass", False),
        }
        for what, is_there in unknown.items():
            if is_there:
                report.warn(f"Scene '{scene.name}': bidirectional paths know of no {what}")
    if stage.catches_shadows and (kept.fills_space or world.fills_space(own)):
        report.warn(
            f"Scene '{scene.name}': shadow catchers behind volumes are not as in Cycles yet, and volumes catch no shadows"
        )
    _name_what_is_missing(scene, report)
    return stage.catches_shadows and not is_bidirectional


def _name_what_is_missing(scene: bpy.types.Scene, report: Report) -> None:
    """Warns of settings of the scene that would show and are not done."""
    own = getattr(scene, "cycles", None)
    missing = {
        "Pixel Jitter is not supported yet, samples are spread by the pixel filter": getattr(
            own, "use_pixel_jitter", False
        ),
        "Freestyle lines are not supported yet, they are left out": scene.render.use_freestyle,
    }
    for what, is_asked in missing.items():
        if is_asked:
            report.warn(f"Scene '{scene.name}': {what}")


def shared_settings(depsgraph: bpy.types.Depsgraph, *, is_render: bool) -> tuple:
    """The settings that every image, material and mesh depends on beside its own datablocks: where one changes, all are sent again."""
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    return (
        depsgraph.scene.session_uid,
        layer.name,
        layer.material_override,
        bpy.data.filepath,
        tuple(curves.shape(scene).items()),
        scene.render.hair_type,
        scene.render.hair_subdiv,
        hasattr(scene, "cycles"),
        dicing.of_scene(scene, is_render=is_render),
        ImageLimit.of(scene, is_render=is_render),
        tuple((one.name, one.type) for one in layer.aovs) if is_render else (),
    )


def _image_limit(depsgraph: bpy.types.Depsgraph) -> ImageLimit:
    return ImageLimit.of(depsgraph.scene_eval, is_render=depsgraph.mode == "RENDER")


def sky_of(depsgraph: bpy.types.Depsgraph) -> bpy.types.World | None:
    """The world of a view layer."""
    layer = depsgraph.view_layer_eval
    # Blender 5 lets a layer have another.
    own = getattr(layer, "world_override", None) or depsgraph.scene_eval.world
    return own if layer.use_sky else None


def send_sky(depsgraph: bpy.types.Depsgraph, builder: Any, report: Report) -> None:
    """Fills a `SceneBuilder` with the world alone."""
    groups = LightGroups(depsgraph.view_layer_eval)
    images = Images(Kept(builder), report, depsgraph.scene_eval.frame_current, _image_limit(depsgraph))
    builder.set_world(_sky(depsgraph, images, groups, Aovs(depsgraph.view_layer_eval)))


def _sky(depsgraph: bpy.types.Depsgraph, images: Images, groups: LightGroups, aovs: Aovs) -> WorldDescription:
    own = sky_of(depsgraph)
    sky = world.describe(own, images, aovs)
    sky.light_group = groups.number(own)
    return sky
