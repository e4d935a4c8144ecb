# SPDX-License-Identifier: GPL-3.0-or-later
"""The lens library from outside: the list, the page with its drawings, the add-on's menu. What the lenses do is tested in
engine/optics/tests/all/library.rs."""

from __future__ import annotations

import json
import subprocess
import sys
from xml.etree import ElementTree

import pytest

from support.command_line import answer
from support.places import ROOT

LENSES = sorted(path.stem for path in (ROOT / "lenses").glob("*.lens"))


@pytest.fixture
def listed(petzval_cli):
    return answer(petzval_cli("lens", "list", "--json"))


@pytest.mark.once
def test_the_list_has_every_lens_once_by_groups(listed):
    entries = listed["lenses"]
    assert sorted(entry["id"] for entry in entries) == LENSES
    places = [listed["groups"].index(entry["group"]) for entry in entries]
    assert places == sorted(places) and len(set(places)) == len(listed["groups"])
    for group in listed["groups"]:
        chosen = [entry["is_first_choice"] for entry in entries if entry["group"] == group]
        assert chosen == sorted(chosen, reverse=True), group
    names = [entry["name"] for entry in entries]
    assert len(set(names)) == len(names)


@pytest.mark.once
def test_the_list_says_what_info_computes(petzval_cli, listed):
    """The eye is in a medium of 1.336: its focal length on the side of the scene is that in air."""
    entries = {entry["id"]: entry for entry in listed["lenses"]}
    for name, index in (("cooke-triplet-50mm", 1.0), ("eye-le-grand", 1.336), ("newtonian-f5", 1.0)):
        info = answer(petzval_cli("lens", "info", name, "--json"))
        assert entries[name]["focal_length_mm"] * index == pytest.approx(info["efl_mm"], rel=1e-9), name
        assert entries[name]["back_focus_mm"] == pytest.approx(info["bfd_mm"], rel=1e-12), name
    assert entries["nikkor-z-24-70-f4"]["zoom_range_mm"] == [24.72, 67.91]
    assert entries["kreitzer-tele"]["f_number"] == pytest.approx(5.63, abs=0.01), "the front rim, not the diaphragm"


@pytest.mark.once
def test_the_printed_list_begins_with_the_first_choice(petzval_cli):
    done = petzval_cli("lens", "list")
    assert done.returncode == 0 and done.stderr == ""
    lines = done.stdout.splitlines()
    assert lines[2] == "First choice"
    first = lines[3 : 3 + lines[3:].index("")]
    assert len(first) == 12 and any(line.startswith("nikkor-z-50-f1.8 ") for line in first)
    assert "Fisheye" in lines and "Others" not in lines


@pytest.mark.once
def test_page_and_table_are_of_today_and_every_lens_has_its_drawing():
    command = [sys.executable, ROOT / "tools/lens_index.py", "--check"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    for name in LENSES:
        root = ElementTree.parse(ROOT / f"docs/images/lenses/{name}.svg").getroot()
        assert root.tag.endswith("svg") and root.get("viewBox"), name


def test_the_menu_has_a_place_for_every_group(blender):
    from petzval.places import load_addon

    addon = load_addon()
    files, menu = addon.data.lens_files, addon.ui.lens_menu
    assert 0 < len(files.groups()) <= menu.MOST_GROUPS
    camera = blender.data.cameras.new("Camera")
    holder = blender.data.objects.new("Camera", camera)
    blender.context.scene.collection.objects.link(holder)
    blender.context.scene.camera = holder
    for entry in files.shipped():
        assert blender.ops.petzval.choose_lens("EXEC_DEFAULT", lens=files.file_name(entry)) == {"FINISHED"}
        assert camera.petzval.lens_file == f"{entry['id']}.lens"
        assert files.description(entry)[0].isupper() and json.dumps(entry)
    for kind in (menu.PETZVAL_MT_lenses, *menu.GROUP_MENUS):
        assert hasattr(blender.types, kind.bl_idname)


@pytest.mark.once
def test_the_readme_counts_the_lenses():
    assert f" {len(LENSES)} lenses come with it" in (ROOT / "README.md").read_text(encoding="utf-8")
