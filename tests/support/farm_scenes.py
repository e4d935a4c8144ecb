# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for a render farm: small, with all that has to be packed and all that a merge must bring together."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from support.places import ROOT, TESTS

#: A lens file whose glass stands in a catalogue beside it.
LENS = """\
# name: Doublet of its own glass
# catalogue: own.agf
#radius thickness glass diameter conic isstop
50 4 OWN 20 0 0
-50 5 air 20 0 0
0 5 air 10 0 1
0 44 air 20 0 0
"""
CATALOGUE = """\
CC test
NM OWN 2 517642 1.5168 64.17 0 1
ED 7.1 8.3 2.51 -0.0009 0
CD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653 0 0 0 0
LD 0.3 2.5
"""

#: A calibration in a file of COLMAP's kind.
CALIBRATION = "1 SIMPLE_RADIAL 96 64 100 48 32 -0.2\n"

MAKE = """
import os, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
folder = Path({folder!r})
import bpy
import numpy as np
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
from support import scenes as parts


def picture(path, colour):
    image = bpy.data.images.new(path.stem, 8, 8)
    image.pixels.foreach_set(np.tile(np.float32([*colour, 1.0]), 64))
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    return image


def textured(name, image):
    material = bpy.data.materials.new(name)
    tree = parts.with_nodes(material)
    out, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs[0], shader.inputs[0])
    tree.links.new(shader.outputs[0], out.inputs[0])
    return material


# A library with a picture of its own, by an absolute path.
for name in ("shots/scene", "library", "textures"):
    (folder / name).mkdir(parents=True)
own = picture(folder / "textures/green.png", (0.2, 0.8, 0.3))
thing = parts.square("Thing", (0.9, 4.0, -0.3), 0.5, textured("Green", own))
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library/things.blend"))

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = parts.set_up(160, 96, 6)
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "shots/scene/shot.blend"))
with bpy.data.libraries.load("//../../library/things.blend", link=True, relative=True) as (source, target):
    target.objects = ["Thing"]
scene.collection.objects.link(target.objects[0])
wall = picture(folder / "textures/wall.png", (0.7, 0.5, 0.4))
wall.filepath = "//../../textures/wall.png"
parts.square("Wall", (0.0, 8.0, 0.0), 6.0, textured("Wall", wall))
# A sequence: the picture of each frame.
for frame in (1, 2, 3):
    picture(folder / f"textures/film_{{frame:03d}}.png", (0.2 * frame, 0.1, 0.9))
film = bpy.data.images.load(str(folder / "textures/film_001.png"))
film.source = "SEQUENCE"
film.filepath = "//../../textures/film_001.png"
screen = textured("Screen", film)
node = next(one for one in screen.node_tree.nodes if one.type == "TEX_IMAGE")
node.image_user.frame_duration, node.image_user.use_auto_refresh = 3, True
parts.square("Screen", (-0.9, 5.0, 0.2), 0.6, screen)
lamp = parts.square("Lamp", (0.3, 5.0, 0.5), 0.05, parts.emitter((1.0, 0.8, 0.6), 400.0))
for frame, x in ((1, 0.3), (3, -0.4)):
    lamp.location.x = x
    lamp.keyframe_insert("location", frame=frame)
camera = scene.camera.data.petzval
camera.model, camera.lens_file = "LENS", str(folder / "shots/own.lens")
scene.camera.data.dof.focus_distance = 5.0
camera.focus_mode = "CAMERA"
for effect in ("ghosts", "glare"):
    setattr(scene.petzval.effects, effect, "ON")
scene.petzval.ghost_reflections = "2"
layer = scene.view_layers[0]
layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = layer.use_pass_vector = True
layer.use_pass_cryptomatte_object = layer.use_pass_diffuse_direct = layer.use_pass_diffuse_color = True
layer.use_pass_mist = layer.use_pass_uv = layer.use_pass_object_index = True
second = scene.view_layers.new("Second")
second.samples = 3
scene.cycles.use_layer_samples = "USE"
if hasattr(scene.cycles, "use_denoising"):
    scene.cycles.use_denoising, scene.cycles.denoising_quality = True, "FAST"
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "shots/scene/shot.blend"))

# One layer, and nothing else: for what is not about the picture.
scene.view_layers.remove(second)
scene.cycles.use_denoising = False
parts.straight(scene)
scene.render.resolution_x, scene.render.resolution_y = 96, 64
camera.lens_file = "cooke-triplet-50mm.lens"
# For who asks for a calibrated camera.
camera.calibration_file = str(folder / "shots/camera.txt")
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "shots/scene/small.blend"))
# What catches shadows needs two renders more.
wall = bpy.data.objects["Wall"]
wall.is_shadow_catcher = True
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "shots/scene/catcher.blend"))
sys.stdout.flush()
os._exit(0)
"""


def save(folder: Path) -> None:
    """Saves shots/scene/shot.blend, small.blend and catcher.blend with all that they name."""
    (folder / "shots").mkdir(parents=True)
    (folder / "shots/own.lens").write_text(LENS)
    (folder / "shots/own.agf").write_text(CATALOGUE)
    (folder / "shots/camera.txt").write_text(CALIBRATION)
    script = MAKE.format(tests=str(TESTS), folder=str(folder))
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=120, cwd=ROOT
    )
    assert (folder / "shots/scene/catcher.blend").exists(), done.stdout + done.stderr
