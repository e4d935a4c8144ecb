# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages by task, docs/how-to: their commands are typed, their options exist, and their labels stand in Blender's window."""

from __future__ import annotations

import re
import shlex

import pytest

from support.places import ROOT

PAGES = sorted((ROOT / "docs" / "how-to").glob("*.md"))
TEXT = "\n".join(page.read_text() for page in PAGES)
#: Inline code and indented blocks that begin with the command's name; two words at least.
COMMANDS = sorted(
    {
        found.split(" #")[0].strip()
        for found in re.findall(r"`(petzval [^`]+ [^`]+)`|^    (petzval .+)$", TEXT, re.M)
        for found in found
        if found
    }
)
#: The words that stand for what a user has.
STANDS_FOR = {
    "FILE": "double-gauss-f2-available",
    "DEG": "10",
    "MM": "2000",
    "1-240": "1-2",
    "1-240,4": "1-2",
    "1920x1280": "48x32",
}
SMALL = {"render": ("--resolution", "24x16", "--samples", "1"), "tolerance": ("--trials", "4")}


def test_pages_have_commands():
    assert len(COMMANDS) >= 8, COMMANDS


@pytest.mark.once
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_of_the_pages_work(command, petzval_cli, cli_scenes, tmp_path):
    words = [STANDS_FOR.get(word, word) for word in shlex.split(command)[1:]]
    words = [str(cli_scenes / "scene.blend") if word == "SCENE.blend" else word for word in words]
    output = words.index("-o") + 1 if "-o" in words else None
    if output:
        words[output] = str(tmp_path / words[output])
    done = petzval_cli(*words, *SMALL.get(words[0], SMALL.get(words[1], ())))
    assert done.returncode == 0, (command, done.stderr)
    if output:
        pattern = words[output].rsplit("/", 1)[1].replace("####", "*")
        assert list(tmp_path.glob(pattern)), (command, list(tmp_path.iterdir()))
    else:
        assert done.stdout.strip(), command


def test_options_of_the_pages_exist(petzval_cli):
    known = "".join(
        petzval_cli(*words, "--help").stdout
        for words in (
            ("render",),
            ("lens", "tolerance"),
            ("lens", "mtf"),
            ("lens", "info"),
            ("lens", "spots"),
            ("lens", "ghosts"),
            ("lens", "stmap"),
        )
    )
    asked = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", TEXT))
    assert len(asked) > 15
    assert asked - set(re.findall(r"--[a-z][a-z-]+", known)) == set()


def labels(bpy) -> set[str]:
    """Names of properties, of their choices, of panels, menus and operators, and what the add-on draws."""
    found = set()
    for name in dir(bpy.types):
        kind = getattr(bpy.types, name)
        found.add(getattr(kind, "bl_label", ""))
        for one in kind.bl_rna.properties if hasattr(kind, "bl_rna") else ():
            found.add(one.name)
            found |= {item.name for item in getattr(one, "enum_items_static", ())}
    for source in (ROOT / "addon").rglob("*.py"):
        found |= set(re.findall(r'"([^"\n]+)"', source.read_text()))
    return found


def test_labels_of_the_pages_are_blenders(blender):
    italic = {word.strip(" .:") for word in re.findall(r"(?<!\*)\*([A-Z][^*]+)\*(?!\*)", TEXT)}
    assert len(italic) > 25
    assert {" ".join(word.split()) for word in italic} - labels(blender) == set()
