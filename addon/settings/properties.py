# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings kept in the .blend: `Scene.petzval`, a view layer's, and `Camera.petzval` of camera_properties.py. Unit, range and
tooltip each.
"""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from ..data.choices import BAKE_TYPES, INTEGRATORS, PIPELINES, PIXEL_SIZES
from ..data.effects import EFFECTS, REFLECTIONS, WORDS
from .camera import PetzvalCamera


class PetzvalEffects(bpy.types.PropertyGroup):
    """`Scene.petzval.effects`: the user's wish for each effect."""

    __annotations__ = {
        effect.name: EnumProperty(name=effect.label, description=effect.tooltip, items=WORDS) for effect in EFFECTS
    }


class PetzvalScene(bpy.types.PropertyGroup):
    """`Scene.petzval`."""

    effects: PointerProperty(type=PetzvalEffects, name="Effects", description="What is simulated of the lens")
    quality: FloatProperty(
        name="Quality",
        description="What is too small to be simulated: at 1, half a pixel, a fiftieth of a stop, a 255th of the exposure. "
        "At 2, half as much",
        default=1.0,
        min=0.01,
        max=1000.0,
        soft_min=0.25,
        soft_max=8.0,
        precision=2,
    )

    ghost_reflections: EnumProperty(
        name="Ghost Reflections",
        description="How often light is reflected in the lens, at most, to be simulated as a ghost",
        items=REFLECTIONS,
        default="2",
    )

    settings_version: IntProperty(
        name="Version of Settings",
        description="Number of the version of Petzval's settings by which the file was saved",
        default=0,
        min=0,
        options={"HIDDEN"},
    )

    samples: IntProperty(
        name="Samples",
        description="Camera rays for each pixel; with a noise threshold, the most that a pixel gets. Where none of these was set, "
        "Cycles's sampling counts",
        default=64,
        min=1,
        max=1 << 24,
        soft_max=4096,
    )
    preview_samples: IntProperty(
        name="Viewport Samples",
        description="Camera rays for each pixel of a 3D view in rendered shading; zero goes on without end. Where it was never set, "
        "Cycles's viewport sampling counts",
        default=256,
        min=0,
        max=1 << 24,
        soft_max=4096,
    )
    preview_pixel_size: EnumProperty(
        name="Pixel Size",
        description="Pixels of the screen along the side of one that is rendered in a 3D view: larger ones are coarser, and quicker. "
        "Where it was never set, Blender's own counts",
        items=PIXEL_SIZES,
        default="1",
    )
    use_noise_threshold: BoolProperty(
        name="Noise Threshold",
        description="Give each part of the picture as many samples as its noise asks for, rather than all the same",
        default=False,
    )
    noise_threshold: FloatProperty(
        name="Noise Threshold",
        description="Error of a pixel, relative to the square root of its brightness, that is small enough: its own unit. "
        "Cycles has the same noise at about a third of the number. 0.01 can hardly be seen; half as much takes up to four times the samples",
        default=0.01,
        min=0.0,
        max=10.0,
        soft_min=0.001,
        soft_max=0.5,
        precision=4,
    )
    use_threshold_after_denoising: BoolProperty(
        name="After Denoising",
        description="Where the picture is denoised, the noise threshold is for what denoising leaves: far fewer samples are "
        "needed. Off: for the noise of the samples, as in Cycles",
        default=True,
    )
    min_samples: IntProperty(
        name="Min Samples",
        description="Camera rays for each pixel before its noise is first looked at; zero is 16. More find rare bright "
        "paths more surely",
        default=0,
        min=0,
        max=1 << 24,
        soft_max=4096,
    )
    time_limit: FloatProperty(
        name="Time Limit",
        description="Seconds after which the render of a view layer ends with the samples that it has, not counting the time that "
        "reading the scene takes. Zero is no limit. Which samples these are then depends on the machine",
        default=0.0,
        min=0.0,
        soft_max=3600.0,
        step=100,
        precision=1,
        subtype="TIME_ABSOLUTE",
    )
    seed: IntProperty(
        name="Seed",
        description="Of all random choices: the same seed gives the same picture to the last bit. Where it was never set, Cycles's seed counts",
        default=0,
        min=0,
    )
    use_blue_noise: BoolProperty(
        name="Blue Noise",
        description=(
            "Spread the noise so that the errors of neighbouring pixels cancel: finer grain for the eye and for "
            "denoisers at the same cost. Each number of samples has points of its own, so that it does nothing with a sample "
            "offset, in layers that are mergeable, with a noise threshold, and with the pipeline From the Scene"
        ),
        default=True,
    )
    use_checkpoints: BoolProperty(
        name="Checkpoints",
        description=(
            "Keep a final render on disk while it goes on, every eight seconds. When it was stopped, or Blender crashed, the same "
            "render of the same scene goes on from there, to the same picture; when it is done the file is deleted"
        ),
        default=True,
    )
    memory_limit: FloatProperty(
        name="Memory Limit",
        description="Most memory, in gigabytes, that the picture or the scene's meshes may take; one that needs more is not rendered, and says so. "
        "Zero takes what the machine has free",
        default=0.0,
        min=0.0,
        soft_max=256.0,
        precision=1,
    )
    sample_offset: IntProperty(
        name="Sample Offset",
        description="Number of the first sample, so that renders of one seed can be joined later",
        default=0,
        min=0,
        max=1 << 24,
    )
    max_bounces: IntProperty(
        name="Max Bounces",
        description="Bounces of light after the first surface",
        default=12,
        min=0,
        max=1024,
        soft_max=64,
    )
    clamp_indirect: FloatProperty(
        name="Clamp Indirect",
        description="Most radiance that light which is scattered more than once may add to a sample: fewer bright specks, but light is lost. "
        "Zero keeps all of it, and the picture true. Where it was never set, Cycles's counts",
        default=0.0,
        min=0.0,
        soft_max=100.0,
    )
    integrator: EnumProperty(name="Integrator", description="From where light is looked for", items=INTEGRATORS)
    use_light_tracing: BoolProperty(
        name="Light Tracing",
        description=(
            "Trace small lights far out of focus from the light to the lens, where few camera rays would hit them: the same picture, with "
            "less noise in their discs. Lights are chosen by a measurement before the render"
        ),
        default=True,
    )
    pipeline: EnumProperty(name="Pipeline", description="Which way light is followed", items=PIPELINES)
    bake_type: EnumProperty(
        name="Bake Type", description="What is baked of the surface", items=BAKE_TYPES, default="COMBINED"
    )
    filter_width: FloatProperty(
        name="Filter Width",
        description="Width of the Blackman-Harris pixel filter; zero is a box of one pixel. Where it was never set, Cycles's pixel filter counts",
        default=1.5,
        min=0.0,
        max=10.0,
        soft_max=3.0,
        subtype="PIXEL",
    )


class PetzvalViewLayer(bpy.types.PropertyGroup):
    """The settings of a view layer."""

    use_pass_mergeable: BoolProperty(
        name="Mergeable",
        description=(
            "Passes that say how many samples each pixel has and what its numbers leave out: renders with other samples "
            "(Sample Offset, or Seed) can be joined by `petzval merge` to the picture of one render with all of them"
        ),
        default=False,
    )
    use_pass_ghosts: BoolProperty(
        name="Ghosts",
        description=(
            "Light reflected between the surfaces of the lens, where the plan simulates it. It is in the picture already: subtract it, "
            "and add as much of it as you like"
        ),
        default=False,
    )
    use_pass_glare: BoolProperty(
        name="Glare",
        description=(
            "Light scattered in the lens, where the plan simulates it; negative where it is taken away. It is in the picture already"
        ),
        default=False,
    )
    use_pass_diffraction: BoolProperty(
        name="Diffraction",
        description=(
            "What the wave nature of light changes, where the plan simulates it; negative where light is taken away. It is in the "
            "picture already"
        ),
        default=False,
    )


CLASSES = (PetzvalCamera, PetzvalEffects, PetzvalScene, PetzvalViewLayer)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Camera.petzval = PointerProperty(type=PetzvalCamera, name="Petzval", description="The real lens")
    bpy.types.Scene.petzval = PointerProperty(type=PetzvalScene, name="Petzval", description="Render settings")
    bpy.types.ViewLayer.petzval = PointerProperty(type=PetzvalViewLayer, name="Petzval", description="Passes")


def unregister() -> None:
    del bpy.types.ViewLayer.petzval
    del bpy.types.Scene.petzval
    del bpy.types.Camera.petzval
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
