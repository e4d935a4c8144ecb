# SPDX-License-Identifier: GPL-3.0-or-later
"""Tiles (UDIM), image sequences and movies show what they show in Cycles."""

from __future__ import annotations

import numpy as np
import pytest

WIDTH, HEIGHT, SAMPLES = 48, 32, 64
#: What surfaces that glow by an image have of noise: pixels' samples fall on other places of the image.
MEAN, BLOCK = 0.005, 0.04


@pytest.fixture
def stage(blender):
    """A dark scene before a camera that looks along +y."""
    from support import scenes as parts

    scene = parts.set_up(WIDTH, HEIGHT, SAMPLES)
    scene.world = parts.grey_world(0.0)
    return parts


def sheet(parts, image, low, high, *, socket: str = "Color", cells: int = 36, **settings):
    """A plane that fills the picture and glows by an image, its UV from `low` to `high`. In small faces: Cycles leaves out tiles in which
    no face has a corner. Gives the material's tree and its image node."""
    made, tree, surface = parts.material("Sheet")
    texture, glow = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
    texture.image = image
    for name, value in settings.items():
        setattr(texture, name, value)
    tree.links.new(texture.outputs[socket], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], surface)
    steps = np.linspace(0.0, 1.0, cells + 1)
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))
    places = np.stack([3.0 * u - 1.5, np.full_like(u, 3.0), 2.0 * v - 1.0], -1)
    row = cells + 1
    faces = [(i, i + 1, i + 1 + row, i + row) for j in range(cells) for i in range(j * row, j * row + cells)]
    uv = np.asarray(low) + np.stack([u, v], -1) * (np.asarray(high) - low)
    parts.mesh_object("Sheet", places, faces, made, uv=[uv[i] for face in faces for i in face])
    return tree, texture


def alike(folder, *, warns: str = "", mean: float = MEAN, block: float = BLOCK) -> np.ndarray:
    from support import beside_cycles

    return beside_cycles.alike(folder, SAMPLES, side=4, mean=mean, block=block, warns=warns)


def three_tiles(folder, *, has_alpha: bool = False):
    """Three tiles of different sizes and one whose file is missing."""
    from support import image_files as files

    sizes = {1001: (16, 16), 1002: (8, 4), 1011: (64, 32)}
    tiles = {n: files.picture(*size, seed=n, has_alpha=has_alpha) for n, size in sizes.items()}
    return files.tiled(folder, {**tiles, 1012: None})


@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
def test_tiles(stage, blender, tmp_path, extension, interpolation):
    """Tiles, a missing one, and beyond them on all sides: below 0 the first tiles go on, else nothing is there."""
    if (
        extension == "MIRROR"
        and "MIRROR" not in blender.types.ShaderNodeTexImage.bl_rna.properties["extension"].enum_items
    ):
        pytest.skip("this Blender mirrors no images")
    sheet(stage, three_tiles(tmp_path), (-1.3, -0.6), (3.2, 2.4), extension=extension, interpolation=interpolation)
    # Closest pixels have edges, and 4 x 4 pixels of the picture few of them.
    found = alike(tmp_path, warns="tile 1012, cannot be read", block=BLOCK if interpolation == "Linear" else 0.08)
    assert np.allclose(found[HEIGHT // 2 + 4, -2], (1.0, 0.0, 1.0), atol=1e-5)


@pytest.mark.parametrize("alpha_mode", ["STRAIGHT", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("socket", ["Color", "Alpha"])
def test_tiles_with_alpha(stage, blender, tmp_path, socket, alpha_mode):
    image = three_tiles(tmp_path, has_alpha=True)
    image.alpha_mode = alpha_mode
    sheet(stage, image, (0.0, 0.0), (2.2, 2.0), socket=socket)
    alike(tmp_path, warns="tile 1012, cannot be read")


@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
@pytest.mark.parametrize("alpha_mode", ["STRAIGHT", "CHANNEL_PACKED"])
@pytest.mark.parametrize("is_tiled", [False, True])
def test_colours_of_a_node_whose_alpha_is_used(stage, blender, tmp_path, is_tiled, alpha_mode, interpolation):
    """Colours are divided by alpha after the pixels are blended: the colour of a pixel that is all transparent neither shows nor bleeds into
    its neighbours."""
    from support import image_files as files

    pixels = files.picture(16, 16, 1)
    pixels[..., 3] = np.clip(np.linspace(-0.5, 1.5, 16), 0.25, 1.0)
    pixels[:, :5, :3], pixels[:, :5, 3] = (1.0, 0.8, 0.6), 0.0
    image = files.tiled(tmp_path, {1001: pixels})
    if not is_tiled:
        image.source, image.filepath = "FILE", str(tmp_path / "tile.1001.png")
    image.alpha_mode = alpha_mode
    tree, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), interpolation=interpolation)
    more = tree.nodes.new("ShaderNodeMath")
    more.inputs[1].default_value = 1.0
    tree.links.new(texture.outputs["Alpha"], more.inputs[0])
    glow = next(node for node in tree.nodes if node.type == "EMISSION")
    tree.links.new(more.outputs[0], glow.inputs["Strength"])
    found = alike(tmp_path, block=BLOCK if interpolation == "Linear" else 0.08)
    clear = found[HEIGHT // 2, WIDTH // 8]
    assert np.allclose(clear, 0.0 if alpha_mode == "STRAIGHT" else (1.0, 0.6038, 0.3185), atol=1e-3)


@pytest.mark.parametrize("space", ["sRGB", "Non-Color"])
@pytest.mark.parametrize("ending", ["png", "jpg", "exr"])
@pytest.mark.parametrize("is_packed", [False, True])
def test_files_of_tiles(stage, blender, tmp_path, ending, space, is_packed):
    """JPEG's own loss is in the file that both read. The tiles have many pixels: floats in sRGB are linear in Blender when they are
    interpolated, and in Cycles not yet."""
    from support import image_files as files

    tiles = {1001: files.picture(64, 64, 1), 1012: files.picture(96, 48, 2)}
    image = files.tiled(tmp_path, tiles, f"tile_<UDIM>.{ending}")
    image.colorspace_settings.name = space
    if is_packed:
        image.pack()
        for path in tmp_path.glob("tile_*"):
            path.unlink()
    sheet(stage, image, (0.0, 0.0), (2.0, 2.0))
    alike(tmp_path)


def test_names_of_tiles_by_column_and_row(stage, blender, tmp_path):
    from support import image_files as files

    for column, row in ((1, 1), (2, 1), (1, 2)):
        files.save(tmp_path / f"tile_u{column}_v{row}.png", files.picture(16, 8, column + 3 * row))
    image = files.tiled(tmp_path, {1001: files.picture(4, 4, 0)})
    image.filepath = str(tmp_path / "tile_<UVTILE>.png")
    for number in (1002, 1011):
        if number not in {tile.number for tile in image.tiles}:
            image.tiles.new(number)
    sheet(stage, image, (0.0, 0.0), (2.0, 2.0))
    alike(tmp_path)


def test_a_box_has_one_tile(stage, blender, tmp_path):
    image = three_tiles(tmp_path)
    tree, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), projection="BOX", projection_blend=0.3)
    place, scaled = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
    scaled.inputs["Location"].default_value = (1.1, 0.5, 0.6)
    scaled.inputs["Scale"].default_value = (0.8, 0.8, 0.8)
    tree.links.new(place.outputs["Object"], scaled.inputs["Vector"])
    tree.links.new(scaled.outputs[0], texture.inputs["Vector"])
    alike(tmp_path)


@pytest.mark.parametrize("is_packed", [False, True])
def test_an_environment_has_no_tiles(stage, blender, tmp_path, is_packed):
    from support import image_files as files

    tree = blender.context.scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = files.tiled(tmp_path, {1001: files.picture(16, 16, 1), 1002: files.picture(24, 8, 2)})
    if is_packed:
        texture.image.pack()
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    alike(tmp_path, warns="has no tiles")


def test_tiles_of_a_bump_and_of_holes(stage, blender, tmp_path):
    """A Bump node looks beside the point, where another tile may be; alpha makes holes, by a node of its own: of one that gives both
    Cycles multiplies heights by alpha."""
    tree, texture = sheet(stage, three_tiles(tmp_path, has_alpha=True), (0.0, 0.0), (2.0, 1.0), extension="EXTEND")
    new, link = tree.nodes.new, tree.links.new
    holes = new("ShaderNodeTexImage")
    holes.image = texture.image
    bump, shader = new("ShaderNodeBump"), new("ShaderNodeBsdfPrincipled")
    bump.inputs["Distance"].default_value = 0.3
    link(texture.outputs["Color"], bump.inputs["Height"])
    link(bump.outputs[0], shader.inputs["Normal"])
    link(holes.outputs["Alpha"], shader.inputs["Alpha"])
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    link(shader.outputs[0], output.inputs["Surface"])
    sun = blender.data.lights.new("Sun", "SUN")
    sun.energy = 3.0
    holder = blender.data.objects.new("Sun", sun)
    holder.rotation_euler = (1.1, 0.2, 0.3)
    blender.context.scene.collection.objects.link(holder)
    stage.square("Back", (0.0, 4.0, 0.0), 8.0, stage.emitter((0.1, 0.3, 0.1), name="Back"))
    # Sharp highlights beside shadow, and 64 samples.
    alike(tmp_path, warns="tile 1012, cannot be read", mean=0.02, block=0.15)


def test_tiles_that_displace(stage, blender, tmp_path):
    tree, texture = sheet(stage, three_tiles(tmp_path), (0.0, 0.0), (2.0, 1.0), extension="EXTEND")
    blender.data.materials["Sheet"].displacement_method = "DISPLACEMENT"
    displacement = tree.nodes.new("ShaderNodeDisplacement")
    displacement.inputs["Scale"].default_value = 0.6
    tree.links.new(texture.outputs["Color"], displacement.inputs["Height"])
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(displacement.outputs[0], output.inputs["Displacement"])
    # The edges of the displaced sheet cross pixels.
    alike(tmp_path, warns="tile 1012, cannot be read", mean=0.01, block=0.1)


#: Of an image user: how it follows the scene's frame, and the scene's frames that are looked at. The files are of frames 3 to 7.
TIMINGS = {
    "from its start": ({"frame_start": 2, "frame_duration": 5, "frame_offset": 2}, (0, 1, 2, 4, 6, 9)),
    "again and again": (
        {"frame_start": 2, "frame_duration": 5, "frame_offset": 2, "use_cyclic": True},
        (-6, 1, 2, 6, 7, 23),
    ),
    "not refreshed": ({"frame_duration": 5, "frame_offset": 2, "use_auto_refresh": False}, (1, 3)),
    "nothing": ({"frame_duration": 0, "frame_offset": 4}, (1, 4)),
}
COLOURS = {frame: (0.1 * frame, 0.9 - 0.1 * frame, 0.2 + 0.05 * frame) for frame in range(1, 8)}


def use(texture, settings):
    texture.image_user.use_auto_refresh = True
    for name, value in settings.items():
        setattr(texture.image_user, name, value)


def same(parts, blender, folder, frame: int, columns=slice(None)) -> np.ndarray:
    """These columns of both programs' pictures of a frame, which show plain colours, are the same; gives the first's colour."""
    from support import beside_cycles

    blender.context.scene.frame_set(frame)
    beside_cycles.prepare(1)
    own, theirs = (scene_picture(parts, blender, folder, engine)[:, columns] for engine in ("PETZVAL", "CYCLES"))
    # The table of sRGB is exact to a ten-thousandth.
    assert np.allclose(own, theirs, rtol=2e-4, atol=1e-6), (frame, own[4, 0], theirs[4, 0])
    return own[4, 0]


def scene_picture(parts, blender, folder, engine):
    blender.context.scene.render.engine = engine
    found = parts.render(folder, f"{engine}.exr")[..., :3]
    blender.context.scene.render.engine = "PETZVAL"
    return found


@pytest.mark.parametrize("timing", TIMINGS)
def test_sequences(stage, blender, tmp_path, timing):
    """Frame by frame: before the first, between, after the last, whose files are missing too."""
    from support import image_files as files

    image = files.sequence(tmp_path, {frame: files.plain(COLOURS[frame]) for frame in range(3, 8)})
    _, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), cells=1)
    settings, frames = TIMINGS[timing]
    use(texture, settings)
    seen = {frame: tuple(same(stage, blender, tmp_path, frame)) for frame in frames}
    assert len(set(seen.values())) > (timing != "nothing")


@pytest.mark.parametrize("name", ["{}.png", "a2b.{:03d}.png", "shot_{:02d}_v.exr", "1001-{:04d}.jpg"])
def test_names_of_frames(stage, blender, tmp_path, name):
    """The last digits of a name are the frame."""
    from support import image_files as files

    image = files.sequence(tmp_path, {frame: files.plain(COLOURS[frame]) for frame in (6, 7)}, name)
    image.colorspace_settings.name = "Non-Color"
    _, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), cells=1)
    use(texture, {"frame_duration": 2, "frame_offset": 5})
    first, second = (same(stage, blender, tmp_path, frame) for frame in (1, 2))
    # JPEG loses some of a colour.
    assert np.allclose(first, COLOURS[6], atol=0.02) and np.allclose(second, COLOURS[7], atol=0.02)


def test_a_frame_whose_file_is_missing(stage, blender, tmp_path):
    from support import image_files as files

    image = files.sequence(tmp_path, {frame: files.plain(COLOURS[frame]) for frame in (1, 3)})
    _, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), cells=1)
    use(texture, {"frame_duration": 3})
    told = lambda: stage.part("render.statistics").last("Scene").warnings  # noqa: E731
    assert same(stage, blender, tmp_path, 1).max() < 1.0 and not told()
    assert tuple(same(stage, blender, tmp_path, 2)) == (1.0, 0.0, 1.0)
    assert len(told()) == 1 and "frame 2" in told()[0] and "frame_0002.png" in told()[0]
    assert same(stage, blender, tmp_path, 3).max() < 1.0 and not told()


def test_one_sequence_in_two_nodes(stage, blender, tmp_path):
    """Two image users of one image, in a material and in the world."""
    from support import image_files as files

    image = files.sequence(tmp_path, {frame: files.plain(COLOURS[frame]) for frame in range(1, 8)})
    tree, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), cells=1)
    use(texture, {"frame_duration": 7})
    other, mixed = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMixRGB")
    other.image, mixed.blend_type = image, "ADD"
    mixed.inputs[0].default_value = 1.0
    use(other, {"frame_duration": 7, "frame_offset": 4})
    glow = next(node for node in tree.nodes if node.type == "EMISSION")
    for number, node in ((1, texture), (2, other)):
        tree.links.new(node.outputs["Color"], mixed.inputs[number])
    tree.links.new(mixed.outputs[0], glow.inputs["Color"])
    sky = blender.context.scene.world.node_tree
    backdrop = sky.nodes.new("ShaderNodeTexEnvironment")
    backdrop.image = image
    use(backdrop, {"frame_duration": 7, "frame_offset": 2})
    sky.links.new(backdrop.outputs[0], next(node for node in sky.nodes if node.type == "BACKGROUND").inputs["Color"])
    blender.data.objects["Sheet"].scale.x = 0.5
    # The sky beside the sheet, and the sheet.
    for frame in (1, 2):
        same(stage, blender, tmp_path, frame, [0, 4, 20, 24, 28])


def test_a_movie(stage, blender, tmp_path):
    from support import image_files as files

    image = files.movie(tmp_path / "movie.avi", [COLOURS[frame] for frame in range(1, 7)])
    assert image.source == "MOVIE" and image.frame_duration == 6
    _, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), cells=1)
    use(texture, {"frame_duration": 6, "frame_start": 2})
    seen = [tuple(same(stage, blender, tmp_path, frame)) for frame in (-1, 2, 3, 7, 9)]
    assert len(set(seen)) == 3
    told = lambda: stage.part("render.statistics").last("Scene").warnings  # noqa: E731
    with pytest.MonkeyPatch.context() as patch:
        # As in Blender 4.2.
        patch.setattr(stage.part("export.image_parts"), "READS_MOVIES", False)
        assert np.allclose(scene_picture(stage, blender, tmp_path, "PETZVAL"), (1.0, 0.0, 1.0))
        assert "an image sequence does not" in told()[0]
    (tmp_path / "movie.avi").unlink()
    image.reload()
    blender.context.scene.frame_set(4)
    assert np.allclose(scene_picture(stage, blender, tmp_path, "PETZVAL"), (1.0, 0.0, 1.0))
    assert "movie.avi" in told()[0] and "restore the file" in told()[0]


def test_floats_in_a_sequence(stage, blender, tmp_path):
    """Brighter than 1, in linear light."""
    from support import image_files as files

    frames = {frame: files.plain((0.5 * frame, 3.0, 0.25)) for frame in (1, 2)}
    image = files.sequence(tmp_path, frames, "light.{:04d}.exr")
    image.colorspace_settings.name = "Linear Rec.709"
    _, texture = sheet(stage, image, (0.0, 0.0), (1.0, 1.0), cells=1)
    use(texture, {"frame_duration": 2})
    for frame in (1, 2):
        # Blender turns colours by a matrix in single precision, whose inverse wrote the file.
        assert np.allclose(same(stage, blender, tmp_path, frame), (0.5 * frame, 3.0, 0.25), rtol=1e-4)


def test_tiles_that_were_never_saved(stage, blender, tmp_path):
    """The first is what was painted in Blender; of another there is nothing."""
    from support import image_files as files

    image = blender.data.images.new("Painted", 16, 16, tiled=True)
    image.pixels.foreach_set(files.picture(16, 16, 4).astype(np.float32).ravel())
    image.update()
    image.tiles.new(1002)
    sheet(stage, image, (0.0, 0.0), (2.0, 1.0))
    found = alike(tmp_path, warns="tile 1002, cannot be read")
    assert np.allclose(found[8, -4], (1.0, 0.0, 1.0), atol=1e-5) and found[8, 8].max() < 0.95
