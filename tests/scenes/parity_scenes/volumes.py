# SPDX-License-Identifier: GPL-3.0-or-later
"""What fills space: fog, smoke, fire, coloured glass."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

from . import scene
from .studio import (
    CREAM,
    RED,
    WHITE,
    Tree,
    ball,
    cube,
    empty_studio,
    lamp,
    material,
    monkey,
    plain,
    plane,
    put,
)


def filled(volume: Callable[[Tree], object], surface: Callable[[Tree], object] | None = None, name: str = "Filled"):
    """A material whose volume, and surface if it has one, are the outputs that these give."""

    def build(t: Tree):
        if surface is not None:
            t.shows(surface(t))
        fills(t, volume(t))

    return material(build, name)


def fills(t: Tree, output) -> None:
    """Links a shader to the volume of a tree's output node."""
    t.tree.links.new(output, t._surface.node.inputs["Volume"])


def bounces(count: int) -> None:
    """How often light may be scattered in volumes after the first time."""
    bpy.context.scene.cycles.volume_bounces = count


def scatter(t: Tree, density: float, colour=WHITE, **inputs):
    return t.node("VolumeScatter", Color=colour, Density=density, **inputs).outputs[0]


@scene("A cube of fog, with a thing in it", noise=0.015)
def fog_cube():
    empty_studio(strength=0.2)
    bounces(3)
    monkey(plain(CREAM), (-0.2, 0.0, 0.95), 1.5, turn=20)
    fog = cube(filled(lambda t: scatter(t, 0.5)), (0.0, 0.0, 1.21), 2.4)
    fog.name = "Fog"


@scene("Light scattered once", noise=0.015)
def fog_single():
    empty_studio(strength=0.05)
    bounces(0)
    cube(filled(lambda t: scatter(t, 0.7, (0.9, 0.8, 0.6, 1.0))), (0.0, 0.0, 1.21), 2.4)


@scene("Glass that absorbs: light through it by paths that meet the lamp", noise=0.025)
def absorbing_glass():
    empty_studio()
    glass = filled(
        lambda t: t.node("VolumeAbsorption", Color=(0.2, 0.7, 0.3, 1.0), Density=1.2).outputs[0],
        lambda t: t.node("BsdfGlass", Roughness=0.0, IOR=1.45).outputs[0],
    )
    monkey(glass, (-0.75, 0.0, 0.85), 1.7, turn=20)
    ball(glass, (1.15, -0.3, 0.8), 0.8)


@scene("Coloured light scattered forwards and backwards", noise=0.015)
def coloured_scatter():
    empty_studio()
    bounces(8)
    forwards = filled(lambda t: scatter(t, 2.0, (0.9, 0.5, 0.2, 1.0), Anisotropy=0.7))
    backwards = filled(lambda t: scatter(t, 1.5, (0.3, 0.6, 0.9, 1.0), Anisotropy=-0.5))
    ball(forwards, (-0.95, 0.0, 0.95), 0.9)
    ball(backwards, (1.05, -0.2, 0.95), 0.9)


@scene("Fire: emission and a black body", noise=0.015)
def fire():
    empty_studio(strength=0.05, lit=False)

    def flame(t: Tree):
        height = t.node("SeparateXYZ", Vector=t.coordinates("Generated")).outputs["Z"]
        where = t.coordinates("Object")
        noise = t.node("TexNoise", Vector=where, Scale=2.0, Detail=1.0).outputs[0]
        strength = t.math("MULTIPLY", t.math("SUBTRACT", 1.0, height), t.math("MULTIPLY", noise, 3.0))
        return t.node("Emission", Color=(1.0, 0.35, 0.08, 1.0), Strength=strength).outputs[0]

    def glow(t: Tree):
        return t.node(
            "VolumePrincipled", Color=(0.3, 0.3, 0.3, 1.0), Density=0.6, Blackbody_Intensity=1.0, Temperature=2100.0
        ).outputs[0]

    ball(filled(flame), (-0.95, 0.0, 1.05), 0.95)
    cube(filled(glow), (1.05, -0.2, 0.85), 1.4)


@scene("A cloud of noise", noise=0.015)
def noise_density():
    empty_studio()
    bounces(4)

    def cloud(t: Tree):
        noise = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=1.6, Detail=2.0).outputs[0]
        thick = t.math("MULTIPLY", t.math("MAXIMUM", t.math("SUBTRACT", noise, 0.45), 0.0), 22.0)
        return scatter(t, thick)

    ball(filled(cloud), (0.0, 0.0, 1.35), 1.3)


@scene("Principled smoke, densest below", noise=0.015)
def principled_smoke():
    empty_studio()
    bounces(4)

    def smoke(t: Tree):
        height = t.node("SeparateXYZ", Vector=t.coordinates("Generated")).outputs["Z"]
        density = t.math("MULTIPLY", t.math("SUBTRACT", 1.0, height), 3.0)
        return t.node(
            "VolumePrincipled",
            Color=(0.6, 0.5, 0.4, 1.0),
            Absorption_Color=(0.5, 0.2, 0.1, 1.0),
            Anisotropy=0.4,
            Density=density,
        ).outputs[0]

    cube(filled(smoke), (0.0, 0.0, 1.1), 2.0)


@scene("All space full of fog, and a spot in it", noise=0.03)
def world_fog():
    empty_studio(strength=0.4, lit=False)
    bounces(0)
    tree = bpy.context.scene.world.node_tree
    fog = Tree(tree, tree.get_output_node("CYCLES").inputs["Surface"])
    fills(fog, scatter(fog, 0.08, Anisotropy=0.3))
    lamp("SPOT", 900.0, (-2.5, -1.5, 4.0), (35, -35, 0), spot_size=np.radians(40), shadow_soft_size=0.1)
    lamp("POINT", 150.0, (2.5, -3.0, 3.0), colour=(0.7, 0.8, 1.0), shadow_soft_size=0.3)
    ball(plain(RED), (1.15, 0.3, 0.8), 0.8)


@scene(
    "Fog of the world that lies low",
    tolerance=0.02,
    why="Cycles loses light in worlds whose fog varies: the same fog in a large box agrees",
)
def world_low_fog():
    empty_studio(strength=0.1)
    bounces(1)
    tree = bpy.context.scene.world.node_tree
    fog = Tree(tree, tree.get_output_node("CYCLES").inputs["Surface"])
    height = fog.node("SeparateXYZ", Vector=fog.node("NewGeometry").outputs["Position"]).outputs["Z"]
    density = fog.node("MapRange", Value=height, _1=0.0, _2=1.6, _3=0.5, _4=0.0)
    fills(fog, scatter(fog, density.outputs[0]))
    monkey(plain(CREAM), (-0.2, 0.0, 0.95), 1.5, turn=20)


@scene("One in another, and one through another", noise=0.015)
def nested():
    empty_studio()
    bounces(4)
    cube(filled(lambda t: scatter(t, 0.4), name="Fog"), (0.0, 0.0, 1.21), 2.4)
    ball(filled(lambda t: scatter(t, 3.0, (0.9, 0.2, 0.1, 1.0)), name="Core"), (-0.4, 0.0, 1.2), 0.5)
    absorbing = lambda t: t.node("VolumeAbsorption", Color=(0.2, 0.3, 0.9, 1.0), Density=1.5).outputs[0]  # noqa: E731
    ball(filled(absorbing, name="Ink"), (1.2, -0.2, 1.0), 0.6)


@scene("The camera stands in fog", noise=0.015)
def camera_inside():
    empty_studio()
    bounces(2)
    monkey(plain(CREAM), (-0.75, 0.0, 0.85), 1.7, turn=20)
    room = cube(filled(lambda t: scatter(t, 0.08, (0.8, 0.9, 1.0, 1.0)), name="Room"), (0.0, -2.0, 2.0), 1.0, turn=0)
    room.scale = (6.0, 11.0, 3.9)


@scene("Mixed and added, with coefficients", noise=0.015)
def mixed_volumes():
    empty_studio()
    bounces(4)

    def build(t: Tree):
        share = t.node("SeparateXYZ", Vector=t.coordinates("Generated")).outputs["X"]
        mixed = t.mix(share, scatter(t, 2.0, RED), t.node("VolumeAbsorption", Density=2.0).outputs[0])
        glow = t.node("Emission", Color=(0.2, 0.3, 1.0, 1.0), Strength=0.15).outputs[0]
        return t.node("AddShader", _0=mixed, _1=glow).outputs[0]

    cube(filled(build, name="Mixed"), (-0.9, 0.0, 0.9), 1.4)

    def coefficients(t: Tree):
        if not hasattr(bpy.types, "ShaderNodeVolumeCoefficients"):
            return scatter(t, 1.0)
        return t.node(
            "VolumeCoefficients",
            Absorption_Coefficients=(0.2, 0.6, 1.5),
            Scatter_Coefficients=(1.5, 0.8, 0.4),
            Emission_Coefficients=(0.0, 0.05, 0.0),
        ).outputs[0]

    cube(filled(coefficients, name="Coefficients"), (1.1, -0.2, 0.85), 1.3)


def _phases(*kinds: dict) -> None:
    """A row of balls that a lamp behind shines through."""
    empty_studio(strength=0.15, lit=False)
    bounces(2)
    lamp("AREA", 250.0, (0.0, 3.0, 3.5), (-55, 0, 0), size=1.5)
    for number, settings in enumerate(kinds):

        def build(t: Tree, settings=settings):
            inputs = {name: value for name, value in settings.items() if name != "phase"}
            named = (
                {"phase": settings["phase"]} if "phase" in bpy.types.ShaderNodeVolumeScatter.bl_rna.properties else {}
            )
            return t.node("VolumeScatter", named, Color=CREAM, Density=2.0, **inputs).outputs[0]

        ball(filled(build, name=settings["phase"]), (1.5 * number - 1.5, 0.0, 0.9), 0.65)


@scene("Fog's, dust's and the air's ways to scatter: Mie, Draine, Rayleigh", noise=0.02)
def phases():
    _phases(
        {"phase": "MIE", "Diameter": 8.0}, {"phase": "DRAINE", "Anisotropy": 0.5, "Alpha": 0.8}, {"phase": "RAYLEIGH"}
    )


@scene(
    "The sea's way to scatter: Fournier and Forand; small and large droplets",
    why="one block is 1 to 2 % darker than in Cycles beside the largest droplets, not understood",
    noise=0.02,
)
def phases_of_water():
    _phases(
        {"phase": "FOURNIER_FORAND", "IOR": 1.2, "Backscatter": 0.1},
        {"phase": "MIE", "Diameter": 1.0},
        {"phase": "MIE", "Diameter": 3.0},
    )


@scene("Fog around lamps, a glowing thing and a window", noise=0.02)
def lamps_in_fog():
    empty_studio(strength=0.1, lit=False)
    bounces(2)
    lamp("POINT", 60.0, (-0.7, -0.2, 1.4), colour=(1.0, 0.8, 0.6), shadow_soft_size=0.15)
    ball(plain(WHITE, Emission_Color=(0.3, 0.6, 1.0, 1.0), Emission_Strength=4.0), (0.7, 0.0, 0.9), 0.25)
    cube(filled(lambda t: scatter(t, 0.4, Anisotropy=0.4)), (0.0, 0.0, 1.21), 2.4, turn=0)
    pane = material(lambda t: t.shows(t.node("BsdfTransparent", Color=(0.9, 0.5, 0.5, 1.0)).outputs[0]))
    plane(pane, (0.0, -1.6, 1.0), 1.4, (90, 0, 0))


def _openvdb():
    """Blender's own module; in bpy it lies beside the paths that are searched."""
    folder = Path(
        bpy.utils.resource_path("LOCAL"), "python", "lib", f"python{sys.version_info.major}.{sys.version_info.minor}"
    )
    sys.path.append(str(folder / "site-packages"))
    try:
        import openvdb
    finally:
        sys.path.pop()
    return openvdb


def _grids(path: Path) -> None:
    """Writes a round cloud, hot in the middle, red on one side."""
    vdb = _openvdb()
    side = 24
    z, y, x = np.mgrid[0:side, 0:side, 0:side].astype(np.float32) / (side - 1) * 2 - 1
    radius = np.sqrt(x * x + y * y + z * z)
    density = np.clip(1.2 - 1.2 * radius + 0.25 * np.sin(7 * x) * np.cos(6 * y), 0, None) * (radius < 1)
    colour = np.stack([0.5 + 0.4 * x, 0.5 + 0 * x, 0.5 - 0.4 * x], 3)
    made = []
    for name, kind, values in (
        ("density", vdb.FloatGrid, density),
        ("temperature", vdb.FloatGrid, np.clip(1 - 2 * radius, 0, None)),
        ("colour", vdb.Vec3SGrid, colour * (radius < 1)[..., None]),
    ):
        grid = kind()
        grid.name = name
        grid.copyFromArray(np.ascontiguousarray(values, np.float32))
        grid.transform = vdb.createLinearTransform(2.0 / side)
        made.append(grid)
    vdb.write(str(path), grids=made)


def _cloud_object(build: Callable[[Tree], object], location, scale: float) -> bpy.types.Object:
    path = Path(tempfile.mkdtemp(prefix="petzval-volume-")) / "cloud.vdb"
    _grids(path)
    data = bpy.data.volumes.new("Cloud")
    data.filepath = str(path)
    data.materials.append(filled(build, name="Cloud"))
    return put(bpy.data.objects.new("Cloud", data), location, (0, 0, 20), scale)


@scene("An OpenVDB file: density, colour and heat by name", noise=0.015)
def volume_object():
    empty_studio()
    bounces(3)

    def smoke(t: Tree):
        node = t.node("VolumePrincipled", Density=6.0, Blackbody_Intensity=0.7, Temperature=2400.0)
        node.inputs["Color Attribute"].default_value = "colour"
        return node.outputs[0]

    _cloud_object(smoke, (-2.0, -0.8, 0.15), 1.0)

    def by_nodes(t: Tree):
        info = t.node("VolumeInfo").outputs
        colour = t.node("Attribute", {"attribute_name": "colour"}).outputs["Color"]
        glow = t.node("Emission", Color=(1.0, 0.4, 0.1, 1.0), Strength=info["Temperature"]).outputs[0]
        cloud = t.node("VolumeScatter", Color=colour, Density=t.math("MULTIPLY", info["Density"], 5.0)).outputs[0]
        return t.node("AddShader", _0=cloud, _1=glow).outputs[0]

    _cloud_object(by_nodes, (0.6, -0.6, 0.3), 0.8)
