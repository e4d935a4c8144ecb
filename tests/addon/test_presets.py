# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of cameras, lenses and sampling: those that come along load and make sense, the user's own are kept and removed."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.places import ROOT

KINDS = ("camera", "lens", "sampling")
FILES = sorted((ROOT / "addon/presets/petzval").glob("*/*.py"))


@pytest.fixture
def scene(parts):
    return parts.set_up(model="LENS")


def load(blender, file):
    panel = f"PETZVAL_PT_{Path(file).parent.name}_presets"
    assert blender.ops.script.execute_preset(filepath=str(file), menu_idname=panel) == {"FINISHED"}


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}-{file.stem}")
def test_a_shipped_preset_says_all_and_makes_sense(blender, parts, scene, file):
    """Each setting that its kind has is in it, and the engine takes the lens, which covers the film."""
    operators = parts.part("operators.presets")
    names = {
        "camera": (*operators.OF_LENS, *operators.OF_BODY),
        "lens": operators.OF_LENS,
        "sampling": operators.OF_SAMPLING,
    }[file.parent.name]
    text = file.read_text()
    assert [line.split()[0] for line in text.splitlines() if line.startswith("petzval.")] == [
        f"petzval.{n}" for n in names
    ]
    own = scene.camera.data.petzval
    own.model, own.blades, own.focal_scale = "THIN", 7, 3.0
    load(blender, file)
    holder = scene.petzval if file.parent.name == "sampling" else own
    for line in text.splitlines():
        if line.startswith("petzval."):
            name, value = line.removeprefix("petzval.").split(" = ")
            assert getattr(holder, name) == pytest.approx(eval(value)), name
    if file.parent.name == "sampling":
        return
    info = parts.part("queries.lens_info").of_camera(scene.camera, scene)
    assert "error" not in info, info
    if file.parent.name == "camera":
        assert parts.part("data.film_formats").of_size(own.film_width, own.film_height) or file.stem in ("Phone", "Eye")
        assert info["fov_diagonal_rad"] is not None, "the lens lights the film's corners"


@pytest.mark.parametrize("kind", KINDS)
def test_those_that_come_along_are_found(blender, parts, scene, kind):
    operators = parts.part("operators.presets")
    names = {file.name for file in operators.shipped(kind)}
    assert len(names) >= 4
    if operators.CAN_REGISTER:
        found = {
            file.name for folder in blender.utils.preset_paths(f"petzval/{kind}") for file in Path(folder).iterdir()
        }
        assert found >= names


@pytest.mark.parametrize("kind", KINDS)
def test_a_preset_is_added_loaded_and_removed(blender, parts, scene, kind):
    own, add = scene.camera.data.petzval, getattr(blender.ops.petzval, f"{kind}_preset")
    own.lens_file, own.wide_open, own.f_number = "cooke-triplet-50mm.lens", False, 9.0
    own.film_mode, own.film_width = "SIZE", 41.0
    scene.petzval.samples = 123
    assert add(name=f"My own {kind}") == {"FINISHED"}
    file = blender.utils.preset_find(f"My_own_{kind}", f"petzval/{kind}")
    assert file
    own.f_number, own.film_width, scene.petzval.samples = 4.0, 36.0, 9
    load(blender, file)
    assert (own.f_number == 9.0) == (kind != "sampling")
    assert (own.film_width == 41.0) == (kind == "camera")
    assert (scene.petzval.samples == 123) == (kind == "sampling")
    assert add(name=f"My own {kind}", remove_name=True) == {"FINISHED"}
    assert not blender.utils.preset_find(f"My_own_{kind}", f"petzval/{kind}")


def test_one_that_comes_along_stays(blender, parts, scene):
    for name in ("35mm_Still", "35mm Still"):
        assert blender.ops.petzval.camera_preset(name=name, remove_name=True) == {"CANCELLED"}
    assert any(file.stem == "35mm_Still" for file in FILES) and all(file.exists() for file in FILES)


def test_a_path_beside_the_file_is_kept_whole(blender, parts, scene, tmp_path):
    lens = tmp_path / "own.lens"
    lens.write_text((ROOT / "lenses/cooke-triplet-50mm.lens").read_text())
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    own = scene.camera.data.petzval
    own.lens_file = "//own.lens"
    blender.ops.petzval.lens_preset(name="Beside")
    file = blender.utils.preset_find("Beside", "petzval/lens")
    assert repr(str(lens)) in Path(file).read_text() and own.lens_file == "//own.lens"
    blender.ops.petzval.lens_preset(name="Beside", remove_name=True)


def test_blender_4_2_is_shown_them_by_the_panel(blender, parts, scene, monkeypatch):
    """It cannot be told of a folder: the panel lists the files itself, before the user's own."""
    from types import SimpleNamespace

    from support import panel_layout

    monkeypatch.setattr(parts.part("operators.presets"), "CAN_REGISTER", False)
    asked = []
    for cls in parts.part("ui.preset_panels").CLASSES:
        whole = panel_layout.Layout()
        names = ("preset_subdir", "preset_operator", "preset_add_operator")
        panel = SimpleNamespace(**{name: getattr(cls, name) for name in names}, layout=whole)
        panel.path_menu = lambda *paths, **_: asked.append(paths)
        cls.draw(panel, panel_layout.context())
        kind = cls.preset_subdir.rpartition("/")[2]
        assert whole.operators == ["script.execute_preset"] * len([file for file in FILES if file.parent.name == kind])
    assert len(asked) == len(KINDS)
    assert "35mm Still" in {blender.path.display_name(file.stem, title_case=False) for file in FILES}
