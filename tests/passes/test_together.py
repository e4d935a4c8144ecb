# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of light through a lens, in view layers and borders, joined, and in the compositor."""

from __future__ import annotations

import numpy as np
import pytest

from support.multilayer import exr_channels


@pytest.fixture
def room(blender):
    import bpy

    from support import render_passes

    scene = render_passes.room()
    layer = scene.view_layers[0]
    render_passes.ask_for_light(layer)
    layer.use_pass_mist = layer.use_pass_uv = layer.use_pass_object_index = layer.use_pass_z = True
    layer.cycles.denoising_store_passes = True
    one = layer.aovs.add()
    one.name, one.type = "Tint", "COLOR"
    own = bpy.data.materials["Matte"].node_tree.nodes.new("ShaderNodeOutputAOV")
    own.aov_name, own.inputs["Color"].default_value = "Tint", (0.2, 0.4, 0.8, 1.0)
    return render_passes


def look_through_a_lens(pipeline: str) -> None:
    import bpy

    scene = bpy.context.scene
    own = scene.camera.data.petzval
    own.model, own.lens_file = "LENS", "double-gauss-f2-tronnier.lens"
    own.film_mode, own.film_width, own.film_height = "SIZE", 24.0, 18.0
    own.focal_mode, own.focal_length = "LENGTH", 30.0
    scene.camera.data.dof.focus_distance = 3.0
    scene.petzval.pipeline = pipeline
    passes = scene.view_layers[0].petzval
    passes.use_pass_ghosts = passes.use_pass_glare = passes.use_pass_diffraction = True


#: Pipeline and noise threshold.
WAYS = [("FILM", 0.0), ("HERO", 0.0), ("HERO", 0.1), ("SCENE", 0.0)]


@pytest.mark.first_only("pipeline", "threshold")
@pytest.mark.parametrize(("pipeline", "threshold"), WAYS)
def test_through_a_lens_light_adds_up(room, blender, tmp_path, pipeline, threshold):
    """And colours are not dimmed by the lens: the floor's is as it is."""
    scene = blender.context.scene
    look_through_a_lens(pipeline)
    scene.petzval.use_noise_threshold, scene.petzval.noise_threshold = threshold > 0.0, threshold or 0.01
    found = []
    for threads in (1, 2):
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
        found.append(room.photograph(tmp_path / f"{threads}.exr", samples=32))
    ours, again = found
    for name in ours:
        assert np.array_equal(ours[name], again[name]), name
    combined = ours["Combined"][..., :3]
    # What of the light is divided by nearly nothing and multiplied again is rounded; sums by halves are of single precision.
    assert np.abs(room.summed(ours) - combined).max() < 3e-5 * combined.max()
    # Where all rays see the floor; light that other pixels' rays send there may be of other things.
    floor = ours["Tint"][..., 3] == 1.0
    assert floor.mean() > 0.03
    np.testing.assert_allclose(ours["Tint"][floor].mean(0), (0.2, 0.4, 0.8, 1.0), atol=1e-5)
    np.testing.assert_allclose(ours["Diffuse Color"][floor].mean(0), (0.7, 0.5, 0.3), atol=0.01)


def test_a_border_cuts_all_passes_alike(room, blender, tmp_path):
    scene = blender.context.scene
    whole = room.photograph(tmp_path / "whole.exr", samples=8)
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.25, 0.75
    for crop in (False, True):
        scene.render.use_crop_to_border = crop
        part = room.photograph(tmp_path / "part.exr", samples=8)
        assert part.keys() == whole.keys()
        inside = (slice(12, 36), slice(16, 48))
        for name, pixels in part.items():
            assert np.array_equal(pixels if crop else pixels[inside], whole[name][inside]), (crop, name)


def test_view_layers_have_their_own(room, blender, tmp_path):
    import bpy

    from support import scenes

    scene = bpy.context.scene
    other = scene.view_layers.new("Other")
    other.use_pass_combined = True
    other.use_pass_diffuse_color = other.use_pass_uv = True
    other.material_override = room.surface("Override", "BsdfDiffuse", Color=(0.1, 0.2, 0.3, 1.0))
    channels_of = {}
    for engine in ("PETZVAL", "CYCLES"):
        room.photograph(tmp_path / f"{engine}.exr", engine, samples=32)
        channels_of[engine] = {
            name: pixels
            for name, pixels in exr_channels(tmp_path / f"{engine}.exr").items()
            if name.startswith("Other")
        }
    ours, theirs = channels_of.values()
    assert ours.keys() == theirs.keys()
    color = next(name for name in ours if "Diff" in name and name.endswith(".R"))
    assert abs(ours[color].mean() - theirs[color].mean()) < 0.002
    first = exr_channels(tmp_path / "PETZVAL.exr")
    assert any(name.startswith(scene.view_layers[0].name) and "Gloss" in name for name in first)
    assert not scenes.part("render.statistics").last("Scene").warnings


@pytest.mark.parametrize("sent", ["use_solid", "use_sky", "samples"])
def test_view_layers_leave_out_what_they_say(room, blender, tmp_path, sent):
    scene = blender.context.scene
    layer = scene.view_layers[0]
    if sent == "samples":
        scene.cycles.use_layer_samples, layer.samples = "USE", 5
        layer.cycles.pass_debug_sample_count = True
        found = [room.photograph(tmp_path / "petzval.exr", samples=64)]
        assert (found[0]["Debug Sample Count"] == 5).all()
        return
    setattr(layer, sent, False)
    ours = room.photograph(tmp_path / "petzval.exr", samples=64)["Combined"]
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=64)["Combined"]
    assert np.abs(room.blocks(ours) - room.blocks(theirs)).max() < 0.03


def test_out_of_focus_data_are_as_cycles_has_them(room, blender, tmp_path):
    """Through thin lenses alike. Of depth and place Cycles has one ray a pixel: means of blocks."""
    from support import scenes

    scene = blender.context.scene
    scenes.square("Wall", (0.0, 8.0, 0.0), 30.0, scenes.emitter((0.2, 0.2, 0.2), name="Wall"))
    layer = scene.view_layers[0]
    layer.use_pass_position = layer.use_pass_cryptomatte_object = True
    camera = scene.camera.data
    camera.petzval.model = "THIN"
    camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 8.0, 0.2
    ours = room.photograph(tmp_path / "petzval.exr", samples=128)
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=128)
    sharp = np.abs(np.diff(ours["UV"][..., 0], axis=1)).max()
    print("sharpest edge", sharp)
    for name, within in (("Depth", 0.15), ("Position", 0.15), ("UV", 0.01), ("Mist", 0.01), ("Denoising Normal", 0.02)):
        off = np.abs(room.blocks(ours[name]) - room.blocks(theirs[name])).max()
        print(name, off)
        assert off < within, name
    cover = [one["CryptoObject00"][..., 1].mean() + one["CryptoObject00"][..., 3].mean() for one in (ours, theirs)]
    assert cover[0] == pytest.approx(cover[1], abs=0.003)


@pytest.mark.once
def test_joined_renders_still_add_up(room, blender, petzval_cli, tmp_path):
    scene = blender.context.scene
    scene.view_layers[0].petzval.use_pass_mergeable = True
    whole = room.photograph(tmp_path / "whole.exr", samples=12)
    for name, first, count in (("a", 0, 8), ("b", 8, 4)):
        scene.petzval.sample_offset = first
        room.photograph(tmp_path / f"{name}.exr", samples=count)
    done = petzval_cli("merge", tmp_path / "a.exr", tmp_path / "b.exr", "-o", tmp_path / "ab.exr")
    assert done.returncode == 0, done.stderr
    joined = room.read(tmp_path / "ab.exr")
    assert joined.keys() == whole.keys()
    combined = whole["Combined"][..., :3]
    assert np.abs(room.summed(joined) - combined).max() < 3e-5 * combined.max()
    for name in (
        "Diffuse Direct",
        "Glossy Indirect",
        "Transmission Color",
        "Emission",
        "Environment",
        "Mist",
        "UV",
        "Tint",
    ):
        np.testing.assert_allclose(joined[name], whole[name], rtol=1e-4, atol=1e-4, err_msg=name)
    assert (joined["Object Index"] == whole["Object Index"]).mean() > 0.98


def test_the_compositor_takes_noise_out(room, blender, tmp_path):
    """Its Denoise node with our albedo and normal: nearer to a clean picture than the render is."""
    import bpy

    from support import scenes

    scene = bpy.context.scene
    clean = room.photograph(tmp_path / "clean.exr", samples=512)["Combined"][..., :3]
    noisy = room.photograph(tmp_path / "noisy.exr", samples=2)["Combined"][..., :3]
    is_new = bpy.app.version >= (5, 0, 0)
    if is_new:
        tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        scene.compositing_node_group = tree
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        end = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        end = tree.nodes.new("CompositorNodeComposite")
    layers, denoise = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeDenoise")
    tree.links.new(layers.outputs["Image"], denoise.inputs["Image"])
    tree.links.new(layers.outputs["Denoising Albedo"], denoise.inputs["Albedo"])
    tree.links.new(layers.outputs["Denoising Normal"], denoise.inputs["Normal"])
    tree.links.new(denoise.outputs[0], end.inputs[0])
    scene.render.use_compositing = True
    scenes.exr(scene)
    found = scenes.render(tmp_path, "denoised.exr")[..., :3]
    before, after = (np.abs(one - clean).mean() for one in (noisy, found))
    print(before, after)
    assert after < 0.7 * before


def test_the_command_line_writes_them(room, petzval_cli, blender, tmp_path):
    blender.context.scene.view_layers[0].name = "Of light"
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "room.blend"))
    options = ("--camera", "pinhole", "--samples", 2, "--passes", "-o", tmp_path / "room.exr")
    done = petzval_cli("render", tmp_path / "room.blend", *options)
    assert done.returncode == 0, done.stderr
    said = (tmp_path / "room.exr").read_bytes()
    for name in ("Combined", "Diffuse Direct", "Emission", "Mist", "UV", "Object Index", "Denoising Albedo", "Tint"):
        old = next((old for old, new in room.OLD.items() if new == name), name)
        assert any(f"Of light.{one}.".encode() in said for one in (name, old)), name
    done = petzval_cli("render", tmp_path / "room.blend", "--passes", "-o", tmp_path / "room.png")
    assert done.returncode == 2 or "needs an EXR" in done.stderr
