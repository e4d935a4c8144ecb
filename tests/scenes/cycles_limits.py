# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes in which Cycles with its default settings is not exact: `LIMITS`, by name.

Each is rendered several ways. One way is the truth: Cycles with the approximation switched off. Petzval does not imitate the
approximation; comparisons with Cycles switch it off, or name it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from parity_scenes import photograph
from parity_scenes.studio import WHITE, Tree, ball, cube, grey_world, lamp, material, plane, put
from parity_scenes.volumes import bounces, filled, scatter

#: Of a picture, pixels.
SIZE = (96, 72)


@dataclass(frozen=True)
class Way:
    """One way to render a scene, and what is true of its picture."""

    label: str
    #: `PETZVAL` or `CYCLES`.
    engine: str
    #: Changes the scene that is open.
    change: Callable[[], None]
    #: Whether the picture is the truth that the others are held against.
    is_truth: bool = False
    #: Samples a pixel over those of the scene.
    samples: int = 1


@dataclass(frozen=True)
class Limit:
    """A scene in which Cycles with its default settings is not exact."""

    name: str
    title: str
    #: What Cycles does there, and how it is known to be wrong: a paragraph.
    evidence: str
    fill: Callable[[], None]
    ways: tuple[Way, ...]
    samples: int
    #: The part of the samples by which a quick test tells the ways apart; 0 if it takes all of them.
    quick: float
    #: How far Petzval's mean may be from the truth, relative; absolute where the truth is 0.
    tolerance: float
    #: How far Cycles' default mean is from the truth at least, in the same measure.
    error: float

    def open(self, way: Way, part: float = 1.0) -> None:
        """Makes it the scene that is open, as that way renders it with this part of its samples."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.context.scene.render.engine = "CYCLES"
        self.fill()
        photograph.prepare(*SIZE, max(round(part * self.samples * way.samples), 1))
        way.change()

    def error_of(self, mean: float, truth: float) -> float:
        """How far a picture's mean is from the truth, in the measure of `tolerance`."""
        return abs(mean - truth) / (truth or 1.0)


LIMITS: dict[str, Limit] = {}


def limit(title: str, evidence: str, ways: tuple[Way, ...], samples: int, quick: float, tolerance: float, error: float):
    """Registers the function below it, which fills the scene, under its own name."""

    def added(fill: Callable[[], None]):
        LIMITS[fill.__name__] = Limit(fill.__name__, title, evidence, fill, ways, samples, quick, tolerance, error)
        return fill

    return added


def _as_it_is() -> None:
    pass


def _watched_from(location, rotation=(0.0, 0.0, 0.0), **settings) -> None:
    """A camera; `rotation` in degrees."""
    data = bpy.data.cameras.new("Camera")
    for name, value in settings.items():
        setattr(data, name, value)
    bpy.context.scene.camera = put(bpy.data.objects.new("Camera", data), location, rotation)


def _glowing(radiance: float):
    return material(lambda t: t.shows(t.node("Emission", Color=WHITE, Strength=radiance).outputs[0]), "Glowing")


def _not_sampled() -> None:
    for one in bpy.data.materials:
        one.cycles.emission_sampling = "NONE"


#: The angle from the normal of the glass, on the far side of the camera, at which the ball stands, degrees.
BALL_DEG = 100.0


@limit(
    "Rough glass lit at an angle that light cannot take",
    "A camera looks straight down on a plane of rough Glass (roughness 0.7, IOR 1.45). Below the plane is a small ball that "
    "glows, 100 degrees from the normal: 80 degrees off the way on which the view goes on. Refraction into such glass turns "
    "light by at most 90° − asin(1 / 1.45) = 46.4 degrees, whatever the slope of a facet, so none of the ball's light can reach the "
    "camera. Cycles' own directions never meet the ball: with Emission Sampling off its picture is black. With Emission "
    "Sampling, the default, its light samples find light there.",
    (
        Way("Cycles, Emission Sampling *None*", "CYCLES", _not_sampled, is_truth=True),
        Way("Cycles, default", "CYCLES", _as_it_is),
        Way("Petzval", "PETZVAL", _as_it_is),
    ),
    samples=64,
    quick=1 / 4,
    tolerance=1e-7,
    error=1e-3,
)
def rough_refraction():
    glass = material(lambda t: t.shows(t.node("BsdfGlass", {"distribution": "GGX"}, Color=WHITE, Roughness=0.7, IOR=1.45).outputs[0]))  # fmt: skip
    plane(glass, size=0.2)
    angle = np.radians(BALL_DEG)
    ball(_glowing(100.0), 4.0 * np.array([np.sin(angle), 0.0, np.cos(angle)]), 0.5)
    _watched_from((0.0, 0.0, 2.0), type="ORTHO", ortho_scale=0.1)


def _marched() -> None:
    cycles = bpy.context.scene.cycles
    # Blender before 5.0 always marches.
    if hasattr(cycles, "volume_biased"):
        cycles.volume_biased = True
    cycles.volume_step_rate = 0.01
    cycles.volume_max_steps = 65536


@limit(
    "Small spots in a volume that glows",
    "A cube of 1 m glows where a noise of scale 80 is over 0.8: spots of a few millimetres. Since Blender 5.0 Cycles samples volumes by null "
    "scattering, and skips cells in which it found nothing before the render. Marching (*Biased*) in steps of a hundredth of the "
    "default is the truth; twice the step gives the same.",
    (
        Way("Cycles, marching at Step Rate 0.01", "CYCLES", _marched, is_truth=True),
        Way("Cycles, default", "CYCLES", _as_it_is, samples=4),
        Way("Petzval", "PETZVAL", _as_it_is, samples=16),
    ),
    samples=16,
    quick=1 / 2,
    # Two seeds of Petzval differ by 2 %.
    tolerance=0.05,
    error=0.1,
)
def glowing_spots():
    def spots(t: Tree):
        noise = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=80.0, Detail=0.0).outputs[0]
        strength = t.math("MULTIPLY", t.math("GREATER_THAN", noise, 0.8), 100.0)
        return t.node("Emission", Color=WHITE, Strength=strength).outputs[0]

    cube(filled(spots), (0.0, 0.0, 0.0), 1.0, turn=0.0)
    _watched_from((0.0, -3.0, 0.0), (90.0, 0.0, 0.0))


def _without_mis() -> None:
    for light in bpy.data.lights:
        light.cycles.use_multiple_importance_sampling = False


@limit(
    "A lamp within fog",
    "A point lamp of radius 0.1 m in a cube of fog (2 per metre, one scattering more). With *Multiple Importance* of the lamp off, Cycles takes its "
    "light by light samples alone; with it, the default, rays that fog scatters find the lamp, too, and the weights of both do not add up "
    "to one.",
    (
        Way("Cycles, without Multiple Importance", "CYCLES", _without_mis, is_truth=True, samples=4),
        Way("Cycles, default", "CYCLES", _as_it_is, samples=4),
        Way("Petzval", "PETZVAL", _as_it_is),
    ),
    samples=512,
    quick=0.0,
    # Two seeds of either differ by 0.5 %.
    tolerance=0.01,
    error=0.012,
)
def lamp_in_fog():
    bounces(1)
    cube(filled(lambda t: scatter(t, 2.0)), (0.0, 0.0, 1.6), 3.1)
    lamp("POINT", 200.0, (0.5, 0.5, 1.5), shadow_soft_size=0.1)
    _watched_from((0.0, -6.5, 2.3), (77.5, 0.0, 0.0))


#: The lamp: its radius, m, and its power, W.
RADIUS, POWER = 0.25, 100.0


def _shadow_caustics() -> None:
    for thing in bpy.context.scene.objects:
        if thing.type == "LIGHT":
            thing.data.cycles.is_caustics_light = True
        elif thing.name == "Sphere":
            thing.cycles.is_caustics_caster = True
        else:
            thing.cycles.is_caustics_receiver = True


def _a_ball_as_the_lamp() -> None:
    was = next(one for one in bpy.context.scene.objects if one.type == "LIGHT")
    place = tuple(was.location)
    bpy.data.objects.remove(was)
    # What a point lamp of that power and radius radiates: W, over its surface and pi.
    thing = ball(_glowing(POWER / (4.0 * np.pi**2 * RADIUS**2)), place, RADIUS)
    thing.visible_camera = False


@limit(
    "Shadow caustics",
    "A ball of glass (Refraction BSDF, roughness 0) hangs between a point lamp of radius 0.25 m and a floor. Without *Shadow Caustics* "
    "paths that leave the floor find the lamp through the ball, and so they do where a ball that glows takes the lamp's place: both give "
    "the same light. With *Shadow Caustics* (lamp, ball and floor marked) those paths are left out, and what is put in their place "
    "follows light through at most one way for each lamp sample: most of the focus is missing.",
    (
        Way("Cycles, a glowing ball in the lamp's place", "CYCLES", _a_ball_as_the_lamp, is_truth=True, samples=4),
        Way("Cycles, without Shadow Caustics", "CYCLES", _as_it_is, samples=4),
        Way("Cycles, Shadow Caustics", "CYCLES", _shadow_caustics),
        Way("Petzval", "PETZVAL", _as_it_is, samples=4),
        Way("Petzval, Shadow Caustics marked", "PETZVAL", _shadow_caustics, samples=4),
    ),
    samples=256,
    quick=1 / 16,
    tolerance=0.05,
    error=0.2,
)
def shadow_caustics():
    grey_world(0.0)
    plane(material(lambda t: t.shows(t.diffuse(WHITE))), size=6.0)
    glass = material(lambda t: t.shows(t.node("BsdfRefraction", Color=WHITE, Roughness=0.0, IOR=1.5).outputs[0]))
    ball(glass, (0.0, 0.0, 1.6), 1.0)
    lamp("POINT", POWER, (0.0, 0.0, 5.0), shadow_soft_size=RADIUS)
    # Of the floor alone, from below the ball.
    _watched_from((0.0, 0.0, 0.5), type="ORTHO", ortho_scale=2.0)


def _one_of_two_faces() -> None:
    bpy.data.objects.remove(bpy.data.objects["Twin"])


@limit(
    "Faces that lie on each other",
    "A square of 2 m under a lamp, and the same square once more, turned over: as after a Mirror modifier across the thing's own middle, or a "
    "boolean. A shadow ray of Cycles leaves out the face that it starts on, and finds the other at no distance: parts of both are dark, as rounding has it. One square without its twin is the truth.",
    (
        Way("Cycles, one square", "CYCLES", _one_of_two_faces, is_truth=True),
        Way("Cycles, both", "CYCLES", _as_it_is),
        Way("Petzval, both", "PETZVAL", _as_it_is),
    ),
    samples=64,
    quick=1 / 4,
    tolerance=0.01,
    error=0.1,
)
def doubled_faces():
    grey = material(lambda t: t.shows(t.diffuse(WHITE)))
    plane(grey, (0.3, 0.2, 0.7), rotation=(20.0, 0.0, 0.0))
    plane(grey, (0.3, 0.2, 0.7), rotation=(200.0, 0.0, 0.0)).name = "Twin"
    lamp("POINT", 100.0, (0.5, -0.5, 3.0), shadow_soft_size=0.1)
    _watched_from((0.3, -3.5, 3.0), (55.0, 0.0, 0.0))


#: The scale of a displaced object.
SCALE = 10.0


def _scale_applied() -> None:
    thing = bpy.data.objects["Plane"]
    thing.data.transform(thing.matrix_basis.to_3x3().to_4x4())
    thing.scale = (1.0, 1.0, 1.0)
    for node in thing.data.materials[0].node_tree.nodes:
        if node.bl_idname == "ShaderNodeDisplacement":
            node.inputs["Scale"].default_value *= SCALE


@limit(
    "*Displacement and Bump* on an object with a scale",
    "A square of 0.2 m with an object scale of 10, displaced by a wave of which the mesh is too coarse to show anything: what is seen is the "
    "bump. Cycles takes the heights of this bump in the world and the distances between them in the object: its slopes are ten times too "
    "steep. With the scale applied to the mesh and to the displacement, which changes no shape, its slopes are right: that is the truth.",
    (
        Way("Cycles, scale applied", "CYCLES", _scale_applied, is_truth=True),
        Way("Cycles, object scale of 10", "CYCLES", _as_it_is),
        Way("Petzval, object scale of 10", "PETZVAL", _as_it_is),
    ),
    samples=64,
    quick=1 / 4,
    tolerance=0.01,
    error=0.03,
)
def scaled_displacement():
    def wavy(t: Tree):
        wave = t.node("TexWave", Vector=t.coordinates("UV"), Scale=2.0, Distortion=0.0)
        moved = t.node("Displacement", {"space": "OBJECT"}, Height=wave.outputs[0], Midlevel=0.5, Scale=0.002)
        t.tree.links.new(moved.outputs[0], t._surface.node.inputs["Displacement"])
        t.shows(t.diffuse(WHITE))

    waves = material(wavy)
    waves.displacement_method = "BOTH"
    thing = plane(waves, size=0.2)
    thing.scale = (SCALE,) * 3
    lamp("SUN", 3.0, (0.0, 0.0, 3.0), (50.0, 0.0, 60.0), angle=0.01)
    _watched_from((0.0, 0.0, 3.0))
