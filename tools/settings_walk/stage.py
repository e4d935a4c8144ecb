# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene in which settings are changed: something for each of them to act on, and little noise. Built in bpy."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from parity_scenes.hair import grown
from parity_scenes.studio import (
    BLUE,
    CREAM,
    GOLD,
    GREEN,
    RED,
    WHITE,
    Tree,
    ball,
    cube,
    lamp,
    material,
    plain,
    plane,
    put,
    test_card,
    world,
)
from support import scenes

WIDTH, HEIGHT = 48, 32


def build() -> bpy.types.Scene:
    """Fills an empty file with the stage."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    _settings(scene)
    _sky()
    _lamps()
    _floor()
    _balls()
    _shapes()
    _strands()
    _fog()
    _moving()
    _collection(scene)
    _camera(scene)
    scene.frame_set(1)
    bpy.context.view_layer.update()
    return scene


def _settings(scene: bpy.types.Scene) -> None:
    """Sets both programs to be exact, each setting of Petzval's own that has one of Cycles' in its place left unset."""
    render, cycles = scene.render, scene.cycles
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    render.threads_mode, render.threads = "FIXED", 1
    scenes.exr(scene)
    cycles.device = "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    # Bounces that the stage has light for, and few enough for noise.
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces = 6, 3, 3, 6
    cycles.volume_bounces = 1
    scene.petzval.use_blue_noise = scene.petzval.use_checkpoints = False


def _sky() -> None:
    """An even sky: both programs make a table of one that is not, for each picture anew. That is for settings which need it."""

    def uneven(t: Tree) -> None:
        up = t.node("SeparateXYZ", Vector=t.coordinates("Generated")).outputs["Z"]
        colour = t.ramp(up, (0.6, (0.02, 0.03, 0.05, 1.0)), (0.7, (1.5, 1.4, 1.2, 1.0)))
        t.shows(t.node("Background", Color=colour, Strength=1.0).outputs[0])

    world(uneven)
    uneven_one = bpy.context.scene.world
    uneven_one.name, uneven_one.use_fake_user = "Uneven", True
    uneven_one.cycles.sampling_method, uneven_one.cycles.sample_map_resolution = "MANUAL", 64
    world(lambda t: t.shows(t.node("Background", Color=(0.4, 0.42, 0.5, 1.0), Strength=0.5).outputs[0]))


def _lamps() -> None:
    lamp("POINT", 60.0, (-2.6, -1.5, 2.2), shadow_soft_size=0.3)
    lamp("SUN", 0.5, (0, 0, 5), (35, 25, 0), angle=0.2)
    lamp("SPOT", 150.0, (3.2, -1.6, 3.6), (30, 30, 0), shadow_soft_size=0.3, spot_size=1.0, spot_blend=0.4)
    lamp("AREA", 60.0, (0.5, -2.2, 3.8), (20, 0, 0), shape="RECTANGLE", size=1.4, size_y=0.9, spread=2.2)


def _floor() -> None:
    image = scenes.image("Card", test_card(32), space="Non-Color")

    def nodes(t: Tree) -> None:
        at = t.node("Mapping", Vector=t.coordinates("UV"), Scale=(3.0, 3.0, 1.0)).outputs[0]
        height = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=1.5).outputs[0]
        bent = t.node("Bump", Height=height, Strength=1.0, Distance=1.0).outputs[0]
        t.shows(t.diffuse(t.node("TexImage", {"image": image}, Vector=at).outputs["Color"], Normal=bent))

    made = material(nodes, "Floor")
    plane(made, size=14.0).name = "Floor"


def _balls() -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=14, ring_count=8, radius=0.55, location=(-2.2, 0.3, 0.56))
    coarse = bpy.context.object
    bpy.ops.object.shade_smooth()
    coarse.name = "Ball"
    coarse.color = RED
    coarse.data.materials.append(material(lambda t: t.shows(t.diffuse(t.node("ObjectInfo").outputs["Color"])), "Own"))
    ball(plain(GOLD, Metallic=1.0, Roughness=0.3), (-0.95, 0.7, 0.56), 0.55).name = "Metal"
    glass = material(lambda t: t.shows(t.node("BsdfGlass", Color=WHITE, Roughness=0.3, IOR=1.4).outputs[0]), "Glass")
    ball(glass, (0.25, 0.5, 0.56), 0.55).name = "Glass"
    skin = plain(CREAM, Subsurface_Weight=1.0, Subsurface_Radius=(0.6, 0.3, 0.2), Subsurface_Scale=0.5)
    ball(skin, (1.45, 0.7, 0.56), 0.55).name = "Skin"


def _shapes() -> None:
    veil = material(lambda t: t.shows(t.mix(0.5, t.node("BsdfTransparent").outputs[0], t.diffuse(GREEN))), "Veil")
    plane(veil, (2.6, -0.6, 0.75), 1.1, (70, 0, 20)).name = "Veil"
    glow = material(lambda t: t.shows(t.node("Emission", Color=GOLD, Strength=4.0).outputs[0]), "Glow")
    plane(glow, (-3.2, 1.6, 0.8), 1.0, (90, 0, 40)).name = "Glow"

    def relief(t: Tree) -> None:
        wave = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=2.5).outputs[0]
        t.shows(t.diffuse(CREAM))
        t.lifts(t.node("Displacement", Height=wave, Midlevel=0.5, Scale=1.1).outputs[0])

    raised = material(relief, "Relief")
    raised.displacement_method = "DISPLACEMENT"
    hill = plane(raised, (-0.4, 3.0, 0.9), 3.4, (50, 0, 0))
    hill.name = "Relief"
    modifier = hill.modifiers.new("Adaptive", "SUBSURF")
    modifier.subdivision_type = "SIMPLE"
    if hasattr(modifier, "use_adaptive_subdivision"):
        modifier.use_adaptive_subdivision = True
    soft = cube(plain(BLUE), (3.0, 1.3, 0.6), 1.2)
    soft.name = "Soft"
    divided = soft.modifiers.new("Divided", "SUBSURF")
    divided.levels = divided.render_levels = 3


def _strands() -> None:
    hair = grown(50, 4, 0.9, 0.12, plain(CREAM, Roughness=0.5), bend=1.6)
    hair.name, hair.location, hair.scale = "Hair", (-1.2, -1.2, 0.35), (0.55,) * 3
    head = ball(plain(RED), (0.2, -1.5, 0.3), 0.25)
    head.name = "Head"
    head.data.materials.append(plain(GOLD))
    head.modifiers.new("Grown", "PARTICLE_SYSTEM")
    made = head.particle_systems[0].settings
    made.type, made.count, made.hair_length, made.material = "HAIR", 40, 0.3, 2
    made.child_type, made.rendered_child_count, made.radius_scale = "INTERPOLATED", 8, 0.02


def _fog() -> None:
    """Even: Cycles takes seconds for each picture of an uneven medium. Smoke, thicker to one side, is for settings that need it."""

    def filled(density: Callable[[Tree], object]) -> Callable[[Tree], None]:
        def nodes(t: Tree) -> None:
            fog = t.node("VolumeScatter", Color=WHITE, Density=density(t), Anisotropy=0.2)
            out = next(one for one in t.tree.nodes if one.type == "OUTPUT_MATERIAL")
            t.tree.links.new(fog.outputs[0], out.inputs["Volume"])

        return nodes

    def across(t: Tree) -> object:
        return t.math("MULTIPLY", t.node("SeparateXYZ", Vector=t.coordinates("Generated")).outputs["X"], 3.0)

    cube(material(filled(lambda t: 1.5), "Fog"), (1.6, -1.4, 0.5), 0.95, 20.0).name = "Fog"
    material(filled(across), "Smoke").use_fake_user = True


def _moving() -> None:
    """The coarse ball rides along on a thing that slides and turns, and swells."""
    rail = put(bpy.data.objects.new("Rail", None), (-2.2, 0.3, 0.56))
    holder = bpy.data.objects["Ball"]
    holder.parent, holder.location = rail, (0.0, 0.0, 0.0)
    holder.shape_key_add(name="Basis")
    swollen = holder.shape_key_add(name="Swollen")
    for corner in swollen.data:
        corner.co.z *= 1.6
    for frame, share in ((0, -1.0), (2, 1.0)):
        rail.location.x, rail.rotation_euler.z = -2.2 + 0.5 * share, 0.5 * share
        rail.keyframe_insert("location", frame=frame)
        rail.keyframe_insert("rotation_euler", frame=frame)
        swollen.value = 0.5 + 0.5 * share
        swollen.keyframe_insert("value", frame=frame)


def _collection(scene: bpy.types.Scene) -> None:
    things = bpy.data.collections.new("Things")
    scene.collection.children.link(things)
    for name in ("Ball", "Skin"):
        thing = bpy.data.objects[name]
        things.objects.link(thing)
        scene.collection.objects.unlink(thing)


def _camera(scene: bpy.types.Scene) -> None:
    holder = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.camera = put(holder, (0.0, -6.6, 2.6), (72.0, 0.0, 0.0))
    dolly = holder.parent = put(bpy.data.objects.new("Dolly", None))
    for frame, share in ((0, -1.0), (2, 1.0)):
        dolly.location.x = 0.15 * share
        dolly.keyframe_insert("location", frame=frame)
    camera = holder.data
    camera.lens, camera.dof.focus_distance, camera.dof.aperture_fstop = 36.0, 5.5, 0.05
    camera.petzval.model, camera.petzval.wide_open = "PINHOLE", True
    scene.petzval.effects.diffraction = "OFF"
    # What settings name, and is nowhere.
    material(lambda t: t.shows(t.diffuse(BLUE)), "Override").use_fake_user = True
    scenes.grey_world(0.02, "Night").use_fake_user = True
    far = bpy.data.objects.new("Far Camera", bpy.data.cameras.new("Far Camera"))
    put(far, (0.0, -60.0, 25.0), (70.0, 0.0, 0.0))
