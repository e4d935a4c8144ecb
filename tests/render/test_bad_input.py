# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot be photographed: one line that says what, where and what to do; the process stays up, and the next good
photograph is as good as ever."""

from __future__ import annotations

import re
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest

from petzval.description import ApertureMask
from support.photograph import native
from support.photograph.chart import LENSES, Studio

ROW = "50 4 1.5168/64.17 20 0 0\n"
STOP = "0 5 air 10 0 1\n"
LAST = "-50 45 air 20 0 0\n"
GOOD = ROW + STOP + LAST

#: A lens file's text, and what its message must hold besides the file's name: its line, then words.
BAD_LENSES = {
    "unknown glass": (ROW + "-50 5 XYZZY9 20 0 0\n" + STOP, "2", "XYZZY9"),
    "too few columns": (ROW + "-50 5 air 20 0\n" + STOP, "2", ""),
    "too many columns": (ROW + "-50 5 air 20 0 0 7\n" + STOP, "2", ""),
    "not a number": (ROW + STOP + "-50 five air 20 0 0\n", "3", "five"),
    "NaN": ("nan 4 1.5 20 0 0\n" + STOP, "1", ""),
    "negative diameter": (ROW + "-50 5 air -20 0 0\n" + STOP, "2", "diameter"),
    "no stop": (ROW + "-50 5 air 20 0 0\n", None, "stop"),
    "two stops": (ROW + STOP + STOP, "3", "stop"),
    "empty": ("", None, ""),
    "a diverging lens": ("-50 4 1.5168/64.17 20 0 0\n" + STOP + "50 45 air 20 0 0\n", None, "real image"),
}


@pytest.fixture
def studio(blender, tmp_path) -> Studio:
    """A glowing lamp in the dark and a lens that photographs it."""
    studio = Studio(blender, tmp_path, (24, 16), samples=4)
    studio.lens("double-gauss-f2-tronnier", (36.0, 24.0), 2.0)
    studio.lamp((0.0, 0.0, -2.0), 0.2)
    return studio


def complaint(studio: Studio) -> str:
    """What Blender tells the user when a render cannot be made: one line. The picture is black, and is there."""
    with pytest.raises(RuntimeError) as raised:
        studio.shoot()
    lines = [line for line in str(raised.value).splitlines() if line.strip()]
    assert len(lines) == 1, raised.value
    assert "Traceback" not in lines[0]
    return lines[0].removeprefix("Error: ")


class Before:
    """A good photograph before and after: the same."""

    def __init__(self, studio: Studio) -> None:
        self.studio, self.picture = studio, studio.shoot()
        assert self.picture.max() > 0.05

    def __enter__(self) -> None:
        own, self.film = self.studio.data.petzval, {}
        for name in ("lens_file", "film_width", "film_mode", "focus_mode", "model", "film_distance"):
            self.film[name] = getattr(own, name)
        self.focus = self.studio.data.dof.focus_distance

    def __exit__(self, *_error) -> None:
        if _error[0] is not None:
            return
        for name, value in self.film.items():
            setattr(self.studio.data.petzval, name, value)
        self.studio.data.dof.focus_distance = self.focus
        self.studio.data.dof.focus_object = None
        self.studio.scene.camera = self.studio.holder
        assert np.array_equal(self.studio.shoot(), self.picture)


@pytest.fixture
def good_before_and_after(studio):
    with Before(studio):
        yield studio


def names(message: str, path: Path, line: str | None) -> bool:
    where = f"{path.name}:{line}" if line else path.name
    return bool(re.search(re.escape(where) + r"\b", message)) or (line is not None and f"line {line}" in message)


@pytest.mark.once
@pytest.mark.parametrize("case", BAD_LENSES)
def test_a_bad_lens_file_is_named_with_its_line(good_before_and_after, tmp_path, case):
    text, line, words = BAD_LENSES[case]
    path = tmp_path / "bad.lens"
    path.write_text(text)
    good_before_and_after.data.petzval.lens_file = str(path)
    message = complaint(good_before_and_after)
    assert case == "a diverging lens" or names(message, path, line), message
    assert words in message


@pytest.mark.once
def test_a_binary_lens_file_is_refused(good_before_and_after, tmp_path):
    path = tmp_path / "picture.lens"
    path.write_bytes(bytes(range(256)) * 4)
    good_before_and_after.data.petzval.lens_file = str(path)
    message = complaint(good_before_and_after)
    assert "picture.lens" in message
    assert message.isprintable()


def test_a_missing_lens_file_is_named_with_its_camera(good_before_and_after, tmp_path):
    good_before_and_after.data.petzval.lens_file = str(tmp_path / "gone.lens")
    message = complaint(good_before_and_after)
    assert "Camera" in message and "gone.lens" in message


@pytest.mark.once
def test_a_stop_wider_than_the_glass_is_a_lens(studio, tmp_path):
    """Its glass then limits the light; brightness is still one for a white world, and wide open is what the file says."""
    path = tmp_path / "wide-stop.lens"
    path.write_text(ROW + "0 5 air 40 0 1\n" + LAST)
    camera = native.camera(path, film_width_mm=0.1, film_height_mm=0.1)
    assert native.white_world(camera, 6, 4, 256).mean() == pytest.approx(1.0, abs=2e-3)
    studio.data.petzval.lens_file = str(path)
    assert studio.shoot().max() > 0.05


def test_a_scene_without_a_camera(good_before_and_after):
    good_before_and_after.scene.camera = None
    message = complaint(good_before_and_after)
    assert "camera" in message.lower()


def test_a_camera_that_is_none(good_before_and_after):
    lamp = next(one for one in good_before_and_after.scene.objects if one.name.startswith("Lamp"))
    good_before_and_after.scene.camera = lamp
    message = complaint(good_before_and_after)
    assert lamp.name in message and "camera" in message


def test_a_focus_object_behind_the_camera(good_before_and_after, blender):
    target = blender.data.objects.new("Target", None)
    target.location = (0.0, 0.0, 3.0)
    good_before_and_after.scene.collection.objects.link(target)
    good_before_and_after.data.dof.focus_object = target
    message = complaint(good_before_and_after)
    assert "Camera" in message and "behind" in message


def test_a_focus_too_close(good_before_and_after):
    good_before_and_after.data.dof.focus_distance = 0.05
    message = complaint(good_before_and_after)
    assert "Camera" in message and "too close" in message and "mm" in message


def test_a_camera_without_size(good_before_and_after):
    """Blender's own properties keep films and distances above zero; a scale of zero they allow."""
    own = good_before_and_after.data.petzval
    own.film_mode = "SIZE"
    own.film_width = 0.0
    assert own.film_width > 0.0
    good_before_and_after.holder.scale = (0.0, 0.0, 0.0)
    message = complaint(good_before_and_after)
    assert "Camera" in message and "scale" in message
    good_before_and_after.holder.scale = (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("setting", "value", "words"),
    [
        ("film_width_mm", 0.0, "film width"),
        ("film_height_mm", nan, "film height"),
        ("tilt_rad", nan, "film's tilt is NaN"),
        ("swing_rad", inf, "film's swing is inf"),
        ("focus_distance", -1.0, "focus distance"),
        ("focus_distance", nan, "focus distance"),
        ("film_distance_mm", -20.0, "film distance"),
        ("f_number", 0.0, "f-number"),
        ("focal_length_mm", inf, "focal length"),
        ("blades", 1000, "blades"),
        ("blade_curvature", 1.5, "curvature"),
        ("blade_curvature", nan, "curvature"),
        ("blade_rotation_rad", inf, "rotation"),
        ("aperture_mask", ApertureMask("Dark", 2, bytes(4)), "'Dark'.* dark"),
        ("aperture_mask", ApertureMask("Odd", 2, bytes(3)), "'Odd'.* square"),
        ("wavelength_nm", 5.0, "wavelength"),
        ("scale_mm_per_unit", (0.0, 1.0, 1.0), "scale"),
    ],
)
@pytest.mark.once
def test_the_engine_refuses_what_blender_would_not_let_through(setting, value, words):
    from petzval import _native

    camera = native.camera(LENSES / "double-gauss-f2-tronnier.lens", **{setting: value})
    with pytest.raises(_native.PetzvalError, match=words) as raised:
        native.white_world(camera, 6, 4, 1)
    assert "\n" not in str(raised.value)


def test_an_empty_scene_is_black_and_no_error(blender, tmp_path):
    studio = Studio(blender, tmp_path, (24, 16), samples=4)
    studio.lens("double-gauss-f2-tronnier", (36.0, 24.0), 2.0)
    assert not studio.shoot().any()


def test_broken_meshes_are_left_out(studio, blender):
    """Triangles without area or with corners that are no numbers, objects without size, meshes without faces."""
    before = studio.shoot()
    shapes = {
        "Point": ([(0.1, 0.1, -1.0)] * 3, [(0, 1, 2)]),
        "Line": ([(0.0, 0.0, -1.0), (1.0, 0.0, -1.0), (2.0, 0.0, -1.0)], [(0, 1, 2)]),
        "NaN": ([(nan, 0.0, -1.0), (1.0, 0.0, -1.0), (0.0, 1.0, -1.0)], [(0, 1, 2)]),
        "Far": ([(inf, 0.0, -1.0), (1.0, 0.0, -1.0), (0.0, 1.0, -1.0)], [(0, 1, 2)]),
        "Nothing": ([], []),
        "Edges": ([(0.0, 0.0, -1.0), (1.0, 0.0, -1.0)], []),
    }
    for name, (corners, faces) in shapes.items():
        mesh = blender.data.meshes.new(name)
        mesh.from_pydata(corners, [], faces)
        studio.scene.collection.objects.link(blender.data.objects.new(name, mesh))
    studio.lamp((0.0, 0.0, -1.0), 0.0)
    after = studio.shoot()
    assert np.isfinite(after).all()
    assert np.array_equal(before, after)


def test_a_missing_texture_is_magenta(studio, blender, tmp_path):
    image = blender.data.images.new("Lost", 4, 4)
    image.source = "FILE"
    image.filepath = str(tmp_path / "lost.png")
    material = studio.glow("Textured", (1.0, 1.0, 1.0))
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    emission = next(node for node in material.node_tree.nodes if node.type == "EMISSION")
    material.node_tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    # Instead of the white lamp.
    next(one for one in studio.scene.objects if one.name.startswith("Lamp")).data.materials[0] = material
    red, green, blue = studio.shoot().sum(axis=(0, 1))
    assert red > 0.0
    assert green == 0.0
    assert blue == pytest.approx(red, rel=1e-4)


# The command ---------------------------------------------------------------------------------------------------


@pytest.fixture
def scene_file(studio, tmp_path) -> Path:
    path = tmp_path / "scene.blend"
    studio.bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def assert_one_line(done, status: int, *words: str) -> None:
    assert done.returncode == status, (done.returncode, done.stderr, done.stdout)
    lines = done.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("petzval: "), done.stderr
    for word in words:
        assert word in lines[0]


@pytest.mark.once
@pytest.mark.parametrize("case", ["unknown glass", "not a number", "two stops"])
def test_the_command_names_a_bad_lens_with_its_line(petzval_cli, scene_file, tmp_path, case):
    text, line, words = BAD_LENSES[case]
    path, output = tmp_path / "bad.lens", tmp_path / "out.exr"
    path.write_text(text)
    done = petzval_cli("render", scene_file, "--lens", path, "-o", output)
    assert_one_line(done, 1, f"bad.lens:{line}", words)


def test_the_command_renders_a_good_scene(petzval_cli, scene_file, studio, tmp_path):
    from support.photograph.chart import read_exr

    output = tmp_path / "out.exr"
    done = petzval_cli("render", scene_file, "-o", output)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert np.array_equal(read_exr(studio.bpy, output), studio.shoot())


def test_the_command_without_a_camera(petzval_cli, studio, tmp_path):
    studio.scene.camera = None
    path = tmp_path / "dark.blend"
    studio.bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert_one_line(petzval_cli("render", path, "-o", tmp_path / "out.exr"), 1, "camera", "dark.blend")


@pytest.mark.first_only("case")
@pytest.mark.parametrize("case", ["empty", "another file", "cut"])
def test_the_command_with_a_broken_scene(petzval_cli, scene_file, tmp_path, case):
    path = tmp_path / "broken.blend"
    half = scene_file.read_bytes()[: scene_file.stat().st_size // 2]
    path.write_bytes({"empty": b"", "another file": b"not a scene at all", "cut": half}[case])
    assert_one_line(petzval_cli("render", path, "-o", tmp_path / "out.exr"), 1, "broken.blend")


@pytest.mark.once
def test_the_command_cannot_write(petzval_cli, scene_file, tmp_path):
    (tmp_path / "folder.exr").mkdir()
    for place in (tmp_path / "folder.exr", "/proc/out.exr"):  # no one may make files in the second
        assert_one_line(petzval_cli("render", scene_file, "-o", place), 1, "cannot write", str(place), "name another")
    stats = tmp_path / "folder.exr"
    done = petzval_cli("render", scene_file, "-o", tmp_path / "out.exr", "--stats", stats)
    assert_one_line(done, 1, "cannot write", "folder.exr")
    assert not (tmp_path / "out.exr").exists()


@pytest.mark.once
@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (("gone.blend",), 1, "gone.blend"),
        (("SCENE", "--lens", "no-such-lens"), 1, "no-such-lens"),
        (("SCENE", "-o", "no/such/folder.exr"), 1, "folder"),
        (("SCENE", "-o", "picture.txt"), 1, "picture.txt"),
        (("SCENE", "--blades", "2"), 1, "blades"),
        ((), 2, "--help"),
        (("SCENE", "--samples", "0"), 2, "samples"),
        (("SCENE", "--samples", "many"), 2, "many"),
        (("SCENE", "--blade-curvature", "1.5"), 2, "blade-curvature"),
        (("SCENE", "--aperture-mask", "no-such.png"), 1, "no-such.png"),
        (("SCENE", "--aperture-mask", "a.png", "--blades", "5"), 2, "--blades"),
        (("SCENE", "--blade-curvature", "nan"), 2, "blade-curvature"),
        (("SCENE", "--film", "36"), 2, "film"),
        (("SCENE", "--film", "0x24"), 2, "film"),
        (("SCENE", "--focus-distance", "nan"), 2, "focus-distance"),
        (("SCENE", "--resolution", "10x0"), 2, "resolution"),
        (("SCENE", "--tilt", "inf"), 2, "tilt"),
        (("SCENE", "--no-such-option"), 2, "--no-such-option"),
        (("SCENE", "--lens", "biotar-1927", "--camera", "pinhole"), 2, "--camera"),
    ],
)
def test_the_command_refuses_before_it_opens_blender(petzval_cli, tmp_path, arguments, status, words):
    scene = tmp_path / "scene.blend"
    scene.write_bytes(b"never opened")
    given = [str(scene) if word == "SCENE" else word for word in arguments]
    assert_one_line(petzval_cli("render", *given), status, words)


def test_nodes_in_a_circle_are_cut_and_named(studio, blender, tmp_path):
    """A shader that mixes itself with another, and numbers that need each other."""
    from support import scenes as parts

    made, tree, surface = parts.material("Circle")
    first, second, mix = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Math", "Math", "MixShader"))
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    for source, target in (
        (first.outputs[0], second.inputs[0]), (second.outputs[0], first.inputs[0]), (first.outputs[0], diffuse.inputs[0]),
        (mix.outputs[0], mix.inputs[1]), (diffuse.outputs[0], mix.inputs[2]), (mix.outputs[0], surface),
    ):  # fmt: skip
        tree.links.new(source, target)
    parts.square("Wall", (0.0, 3.0, 0.0), 4.0, made)
    picture = parts.render(tmp_path)
    assert np.isfinite(picture).all()
    (warning,) = parts.part("render.statistics").last("Scene").warnings
    assert "Material 'Circle'" in warning and "Mix Shader" in warning and "itself" in warning


@pytest.mark.once
def test_twenty_thousand_lamps(blender, tmp_path):
    """As many as instances of one: together as bright as one that has all their power."""
    from support import scenes as parts

    scene, count = parts.set_up(samples=16), 20_000
    scene.world = parts.grey_world(0.0)
    places = np.random.default_rng(3).normal(0.0, 1.0, (count, 3)) * 0.01 + (0.0, 1.0, 0.0)
    mesh = blender.data.meshes.new("Places")
    mesh.vertices.add(count)
    mesh.vertices.foreach_set("co", places.astype(np.float32).reshape(-1))
    holder = blender.data.objects.new("Places", mesh)
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    lamp.data.shadow_soft_size = 0.0
    for one in (holder, lamp):
        scene.collection.objects.link(one)
    made, tree, surface = parts.material("Plain")
    tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], surface)
    parts.square("Wall", (0.0, 3.0, 0.0), 4.0, made)
    lamp.data.energy, lamp.location = 100.0, (0.0, 1.0, 0.0)
    one = parts.render(tmp_path, "one.exr")[..., :3].mean()
    lamp.data.energy, lamp.location = 100.0 / count, (0.0, 0.0, 0.0)
    lamp.parent, holder.instance_type = holder, "VERTS"
    many = parts.render(tmp_path, "many.exr")[..., :3].mean()
    # The cloud of lamps is a hundredth of its distance wide.
    assert many == pytest.approx(one, rel=0.02)


@pytest.mark.once
def test_more_triangles_than_memory(studio, blender):
    """A mesh that does not fit: the object, what it needs and what there is; and nothing is lost."""
    from petzval import _native

    rings = 230
    with Before(studio):
        blender.ops.mesh.primitive_uv_sphere_add(
            segments=rings, ring_count=rings, radius=0.1, location=(0.3, 0.0, -2.0)
        )
        sphere = blender.context.object
        sphere.name = "Fine sphere"
        blender.context.scene.petzval.memory_limit = 0.01
        said = complaint(studio)
        # Two fans, and two triangles for each of the other faces.
        assert f"'Fine sphere': with its {2 * rings * (rings - 1):,} triangles" in said
        assert "0.026 GB" in said and "Memory Limit is 0.01 GB" in said
        blender.context.scene.petzval.memory_limit = 0.0
        assert studio.shoot().max() > 0.05
        blender.data.objects.remove(sphere)
    assert _native.free_memory_bytes() > 1e8


@pytest.mark.once
@pytest.mark.skipif(not Path("/proc/meminfo").exists(), reason="needs /proc/meminfo")
def test_free_memory_is_no_more_than_the_system_says():
    from petzval import _native

    (line,) = [line for line in Path("/proc/meminfo").read_text().splitlines() if line.startswith("MemAvailable")]
    # Others take and give while this is asked.
    assert 0 < _native.free_memory_bytes() < 1.2 * int(line.split()[1]) * 1024
