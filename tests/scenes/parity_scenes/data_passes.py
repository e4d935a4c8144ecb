# SPDX-License-Identifier: GPL-3.0-or-later
"""What the camera sees that is no light: places, normals, names, indices, outputs of shaders."""

from __future__ import annotations

import bpy

from . import scene
from .motion import FRAME, animate
from .studio import BLUE, CREAM, RED, ball, cube, empty_studio, material, monkey, plain


def _group() -> list[bpy.types.Object]:
    empty_studio()
    return [
        monkey(plain(CREAM), (0.0, 0.0, 0.9), 1.7),
        ball(plain(RED), (-1.5, -1.5, 0.6), 0.6),
        cube(plain(BLUE), (1.6, 1.2, 0.6), 1.2),
    ]


def _asks(*names: str) -> None:
    for name in names:
        setattr(bpy.context.view_layer, f"use_pass_{name}", True)


@scene("Where things are", passes=("Depth", "Position", "Normal"))
def places():
    _group()
    _asks("z", "position", "normal")


@scene("How things move over the picture, before a camera that turns and walks", passes=("Vector",))
def ways():
    head, one, box = _group()
    animate(head, "rotation_euler", lambda t: (0.0, 0.0, 0.2 * t))
    animate(one, "location", lambda t: (-1.5 + 0.3 * t, -1.5, 0.6))
    animate(box, "scale", lambda t: (1.0, 1.0, 1.0 + 0.2 * t))
    camera = bpy.context.scene.camera
    turn, place = camera.rotation_euler.copy(), camera.location.copy()
    animate(camera, "rotation_euler", lambda t: (turn.x, turn.y, 0.04 * t))
    animate(camera, "location", lambda t: (place.x, place.y + 0.3 * t, place.z))
    bpy.context.scene.frame_set(FRAME)
    _asks("vector")


@scene("UV coordinates, and mist", passes=("UV", "Mist"))
def uv_and_mist():
    _group()
    mist = bpy.context.scene.world.mist_settings
    mist.start, mist.depth, mist.falloff = 4.0, 7.0, "QUADRATIC"
    _asks("uv", "mist")


@scene(
    "Indices of objects and materials",
    passes=("Object Index", "Material Index"),
    tolerance=0.025,
    why="at edges Cycles has what its first ray met, and this what most met",
)
def indices():
    for number, one in enumerate(_group(), 1):
        one.pass_index, one.data.materials[0].pass_index = number, 4 - number
    _asks("object_index", "material_index")


@scene("Names as Cryptomatte, each in its colour", passes=("CryptoObject", "CryptoMaterial", "CryptoAsset"))
def cryptomatte():
    head, one, _ = _group()
    one.parent = head
    one.matrix_parent_inverse = head.matrix_basis.inverted()
    _asks("cryptomatte_object", "cryptomatte_material", "cryptomatte_asset")


@scene("Outputs of shaders", passes=("Paint", "Height"))
def shader_outputs():
    def build(t):
        place = t.node("NewGeometry").outputs["Position"]
        colour = t.node("TexNoise", Vector=place, Scale=2.0).outputs["Color"]
        height = t.node("SeparateXYZ", Vector=place).outputs["Z"]
        t.node("OutputAOV", {"aov_name": "Paint"}, Color=colour)
        t.node("OutputAOV", {"aov_name": "Height"}, Value=height)
        t.shows(t.diffuse(CREAM))

    for one in _group()[:2]:
        one.data.materials[0] = material(build)
    for name, kind in (("Paint", "COLOR"), ("Height", "VALUE")):
        made = bpy.context.view_layer.aovs.add()
        made.name, made.type = name, kind


@scene("What denoisers ask for", passes=("Denoising Albedo", "Denoising Normal", "Denoising Depth"), noise=0.02)
def for_denoisers():
    _group()[0].data.materials[0] = plain(CREAM, Metallic=1.0, Roughness=0.05)
    bpy.context.view_layer.cycles.denoising_store_passes = True
