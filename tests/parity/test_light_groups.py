# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups against Cycles in the same Blender, block by block, and against pictures of one emitter alone."""

from __future__ import annotations

import numpy as np
import pytest

from support.lamp_studio import SIDE, lamp, panel
from support.multilayer import exr_channels

#: Pixels of a block's side.
BLOCK = 8
NAMES = ("Key light", "Panel", "Sky")


@pytest.fixture
def stage(studio, blender):
    """A lamp, a mesh that glows and a world with a bright side, a group each; and a group that nothing is in."""
    scene = blender.context.scene
    rows, columns = np.mgrid[0:32, 0:64] / 32.0
    sky = np.stack([0.2 + 0.3 * rows, 0.2 + 0.2 * columns, 0.4 + 0.0 * rows, 1.0 + 0.0 * rows], axis=-1)
    sky[18:24, 10:16, :3] = 6.0
    tree = studio.with_nodes(scene.world)
    image = tree.nodes.new("ShaderNodeTexEnvironment")
    image.image = studio.image("Sky", sky.astype(np.float32), is_float=True)
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Strength"].default_value = 0.4
    tree.links.new(image.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    blender.data.objects["Wall"].scale.z = 0.25
    glowing = panel(studio)
    glowing.data.materials[0] = studio.emitter((0.4, 0.7, 1.0), 12.0)
    for name in (*NAMES, "Nobody's"):
        scene.view_layers[0].lightgroups.add(name=name)
    glowing.lightgroup, scene.world.lightgroup = "Panel", "Sky"
    scene.petzval.filter_width = scene.petzval.clamp_indirect = 0.0
    scene.cycles.film_exposure = 0.7
    studio.panel = glowing
    return studio


def key_light(blender, kind: str):
    holder = lamp(blender, kind)
    holder.lightgroup = "Key light"
    return holder


def prepare(parts, scene) -> None:
    """Sets both programs to the same but for their samples, and the file to one of all passes."""
    parts.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    cycles = scene.cycles
    cycles.device, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", False, False
    cycles.sample_clamp_indirect, cycles.blur_glossy, cycles.pixel_filter_type = 0.0, 0.0, "BOX"
    scene.camera.data.dof.use_dof = False


def photograph(parts, blender, path, engine: str = "PETZVAL") -> dict[str, np.ndarray]:
    """Combined and its groups, RGB, by the names of the passes."""
    from support import kept_references

    scene = blender.context.scene
    prepare(parts, scene)
    scene.render.filepath = str(path)
    scene.render.engine = engine
    try:
        kept_references.render_still()
    finally:
        scene.render.engine = "PETZVAL"
    channels = {name.partition(".")[2]: pixels for name, pixels in exr_channels(path).items()}
    names = {name.partition(".")[0] for name in channels if name.startswith("Combined")}
    return {name: np.stack([channels[f"{name}.{c}"] for c in "RGB"], axis=-1) for name in names}


def grouped(pictures) -> np.ndarray:
    return sum(one for name, one in pictures.items() if name != "Combined")


def apart(ours, theirs, mean: float = 0.01, block: float = 0.02) -> float:
    """In parts of the limits: in the mean; and block by block, by each and the mean together: far from its light a group is dim
    and has noise."""
    blocks = [p.reshape(SIDE // BLOCK, BLOCK, SIDE // BLOCK, BLOCK, 3).mean((1, 3)) for p in (ours, theirs)]
    worst = (np.abs(blocks[0] - blocks[1]) / (blocks[1] + blocks[1].mean())).max()
    means = np.abs(ours.mean((0, 1)) / theirs.mean((0, 1)) - 1.0).max()
    print(f"mean {means:.4f}, worst block {worst:.4f}")
    return float(max(means / mean, worst / block))


def same(ours, theirs) -> None:
    assert apart(ours, theirs) < 1.0


def as_in_cycles(parts, blender, folder, samples: int, more=lambda _: {}) -> tuple[dict, dict]:
    """Asserts that every group is, and what else `more` makes of the pictures; gives Petzval's pictures and Cycles'."""
    from support import beside_cycles

    def compared(pictures) -> dict[str, np.ndarray]:
        return {name: pictures[f"Combined_{name}"] for name in NAMES} | more(pictures)

    prepare(parts, blender.context.scene)
    beside_cycles.small_sky_table()
    take = lambda engine: photograph(parts, blender, folder / f"{engine.lower()}.exr", engine)  # noqa: E731
    for _, share, ours, theirs in beside_cycles.looks(samples, take):
        assert ours.keys() == theirs.keys()
        one, other = compared(ours), compared(theirs)
        off = {name: apart(one[name], other[name]) for name in one}
        if max(off.values()) < share:
            break
    assert max(off.values()) < 1.0, off
    return ours, theirs


def sums_up(pictures) -> None:
    """To single precision's rounding of a thousand terms."""
    combined = pictures["Combined"]
    assert np.abs(grouped(pictures) - combined).max() < 2e-5 * combined.max()


def look_through_a_lens(scene, pipeline: str) -> None:
    own = scene.camera.data.petzval
    own.model, own.lens_file = "LENS", "double-gauss-f2-tronnier.lens"
    own.film_mode, own.film_width, own.film_height = "SIZE", 24.0, 24.0
    own.focal_mode, own.focal_length = "LENGTH", 30.0
    scene.camera.data.dof.focus_distance = 8.0
    scene.petzval.pipeline = pipeline
    # What strays comes from the whole picture, not from groups.
    from support import scenes

    scenes.straight(scene)


@pytest.mark.once
@pytest.mark.parametrize(
    ("kind", "transparent"),
    [("AREA", False), ("AREA", True), ("SUN", True), ("POINT, soft", False), ("POINT without size", False)],
)
def test_as_cycles_has_them(stage, blender, tmp_path, kind, transparent):
    """And what is in no group that the view layer names is in none."""
    key_light(blender, kind)
    for group, place in (("", (-3.0, -1.0, 2.0)), ("Nowhere", (3.0, 1.0, 1.0))):
        other = lamp(blender, "POINT")
        other.data.energy, other.location, other.lightgroup = 60.0, place, group
    blender.context.scene.render.film_transparent = transparent

    def rest(pictures) -> dict[str, np.ndarray]:
        return {"rest": pictures["Combined"] - grouped(pictures)}

    ours, theirs = as_in_cycles(stage, blender, tmp_path, 2048, rest)
    warnings = stage.part("render.statistics").last("Scene").warnings
    assert not warnings, warnings
    assert ours.keys() == theirs.keys() == {"Combined", "Combined_Nobody's", *(f"Combined_{name}" for name in NAMES)}
    # The camera sees the sky above the wall.
    assert ours["Combined_Sky"][-1].any() != transparent
    assert not ours["Combined_Nobody's"].any() and not theirs["Combined_Nobody's"].any()
    assert rest(theirs)["rest"].mean() > 0.02 * theirs["Combined"].mean()


#: Pipeline (none is the pinhole), noise threshold, clamp.
WAYS = [
    ("", 0.0, 0.0), ("", 0.05, 0.5), ("FILM", 0.0, 0.0), ("HERO", 0.0, 0.0), ("HERO", 0.1, 0.0), ("SCENE", 0.0, 0.5),
    ("SCENE", 0.1, 0.0),
]  # fmt: skip


@pytest.mark.first_only("pipeline", "threshold", "clamp")
@pytest.mark.parametrize(("pipeline", "threshold", "clamp"), WAYS)
def test_the_groups_sum_up_to_combined(stage, blender, tmp_path, pipeline, threshold, clamp):
    scene = blender.context.scene
    key_light(blender, "AREA")
    if pipeline:
        look_through_a_lens(scene, pipeline)
    scene.petzval.samples = 64
    scene.petzval.use_noise_threshold, scene.petzval.noise_threshold = threshold > 0.0, threshold or 0.01
    scene.petzval.clamp_indirect = clamp
    found = []
    for threads in (1, 3):
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
        found.append(photograph(stage, blender, tmp_path / f"{threads}.exr"))
        sums_up(found[-1])
    assert all(found[0][f"Combined_{name}"].mean() > 0.05 * found[0]["Combined"].mean() for name in NAMES)
    assert all(np.array_equal(found[0][name], found[1][name]) for name in found[0])


@pytest.mark.once
@pytest.mark.parametrize("pipeline", ["FILM", "HERO", "SCENE"])
def test_a_group_is_the_picture_with_its_emitters_alone(stage, blender, tmp_path, pipeline):
    """Through a lens, where Cycles has none."""
    scene = blender.context.scene
    holder = key_light(blender, "AREA")
    look_through_a_lens(scene, pipeline)
    both = photograph(stage, blender, tmp_path / "both.exr")
    # Black, but as much in the way as it was.
    stage.panel.data.materials[0] = stage.emitter((0.0, 0.0, 0.0))
    scene.world = None
    same(both["Combined_Key light"], photograph(stage, blender, tmp_path / "lamp.exr")["Combined"])
    blender.data.objects.remove(holder)
    stage.panel.data.materials[0] = stage.emitter((0.4, 0.7, 1.0), 12.0)
    same(both["Combined_Panel"], photograph(stage, blender, tmp_path / "panel.exr")["Combined"])


def test_instances_are_in_the_group_of_their_object(stage, blender, tmp_path):
    scene = blender.context.scene
    holder = key_light(blender, "POINT")
    shelf = blender.data.collections.new("Shelf")
    for one in (stage.panel, holder):
        scene.collection.objects.unlink(one)
        shelf.objects.link(one)
    for shift in (0.0, -1.5):
        placed = blender.data.objects.new("Placed", None)
        placed.instance_type, placed.instance_collection, placed.location.x = "COLLECTION", shelf, shift
        # Not its own.
        placed.lightgroup = "Nobody's"
        scene.collection.objects.link(placed)
    ours, _ = as_in_cycles(stage, blender, tmp_path, scene.petzval.samples)
    sums_up(ours)


def test_each_view_layer_has_its_own(stage, blender, tmp_path):
    scene = blender.context.scene
    key_light(blender, "AREA")
    scene.petzval.samples = 16
    other = scene.view_layers.new("Other")
    other.lightgroups.add(name="Sky")
    stage.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.filepath = str(tmp_path / "layers.exr")
    blender.ops.render.render(write_still=True)
    channels = exr_channels(tmp_path / "layers.exr")
    first = scene.view_layers[0].name
    assert {name for name in channels if ".Combined_" in name and name.endswith(".R")} == {
        f"{first}.Combined_Nobody's.R", "Other.Combined_Sky.R", *(f"{first}.Combined_{name}.R" for name in NAMES)
    }  # fmt: skip
    # The same random numbers, whatever the group's number.
    assert np.array_equal(channels["Other.Combined_Sky.G"], channels[f"{first}.Combined_Sky.G"])


@pytest.mark.once
def test_bidirectional_paths_say_that_they_cannot(stage, blender, tmp_path):
    scene = blender.context.scene
    key_light(blender, "AREA")
    look_through_a_lens(scene, "HERO")
    scene.petzval.integrator, scene.petzval.samples = "BIDIRECTIONAL", 4
    pictures = photograph(stage, blender, tmp_path / "picture.exr")
    assert pictures["Combined"].any() and not grouped(pictures).any()
    assert any("light groups" in one for one in stage.part("render.statistics").last("Scene").warnings)
