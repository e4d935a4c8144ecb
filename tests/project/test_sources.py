# SPDX-License-Identifier: GPL-3.0-or-later
"""Kept pictures of Cycles count as long as the sources of their test are the same: which these are (tests/support/sources.py)."""

from __future__ import annotations

from pathlib import Path

import pytest

from support import sources
from support.places import TESTS

pytestmark = pytest.mark.once

FILES = {
    "conftest.py": "@fixture\ndef base():\n    from support import scenes\n\n@fixture\ndef other():\n    from support import balls\n",
    "lamps/conftest.py": "@fixture\ndef studio(base):\n    from support.studio import set_up\n",
    "lamps/test_lamps.py": "from support.lamps import lamp\n\ndef test_it(studio):\n    import gallery.room\n",
    "support/__init__.py": "",
    "support/scenes.py": "",
    "support/balls.py": "",
    "support/studio.py": "from support import nodes\n",
    "support/nodes.py": "",
    "support/lamps.py": "",
    "support/beside.py": "",
    "gallery/__init__.py": "",
    "gallery/room.py": "",
    "gallery/hall.py": "",
    "gallery/cellar.py": "from . import door\nfrom .stairs import step\n",
    "gallery/door.py": "",
    "gallery/stairs.py": "",
}
#: Files of which each line counts; of conftest.py the fixtures alone that are asked for.
COUNT = ("lamps/test_lamps.py", "support/scenes.py", "support/studio.py", "support/nodes.py", "support/lamps.py", "gallery/hall.py", "gallery/cellar.py")  # fmt: skip
DO_NOT_COUNT = ("support/balls.py", "support/beside.py", "conftest.py", "lamps/conftest.py")


@pytest.fixture
def tree(tmp_path, monkeypatch) -> Path:
    """A folder of tests with helpers."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(sources, "TESTS", tmp_path)
    monkeypatch.setattr(sources, "_FOLDERS", (tmp_path,))
    return tmp_path


def digest(tree: Path, name: str = "lamps/test_lamps.py") -> str:
    return sources.digest.__wrapped__(tree / name)


@pytest.mark.parametrize("name", [*COUNT, *DO_NOT_COUNT])
def test_what_a_test_imports_and_asks_for_counts(tree, name):
    before = digest(tree)
    (tree / name).write_text("# Another line.\n" + FILES[name])
    assert (digest(tree) != before) == (name in COUNT)


def test_of_a_chapter_what_it_imports_counts(tree):
    """Of a package, the chapter of the scene, what it imports from beside it, and what the test names."""

    def digest(name: str) -> str:
        return sources.digest.__wrapped__(tree / "test_gallery.py", tree / "gallery" / name)

    (tree / "test_gallery.py").write_text("from gallery import room\n")
    before = {chapter: digest(chapter) for chapter in ("cellar.py", "hall.py")}
    changed = {}
    for name in ("__init__", "room", "hall", "cellar", "door", "stairs"):
        text = (tree / f"gallery/{name}.py").read_text()
        (tree / f"gallery/{name}.py").write_text("# Another line.\n" + text)
        changed[name] = [chapter for chapter, old in before.items() if digest(chapter) != old]
        (tree / f"gallery/{name}.py").write_text(text)
    both = ["cellar.py", "hall.py"]
    assert changed == {
        "__init__": both,
        "room": both,
        "hall": both[1:],
        "cellar": both[:1],
        "door": both[:1],
        "stairs": both[:1],
    }


@pytest.mark.parametrize(("name", "old"), [("lamps/conftest.py", "studio(base)"), ("conftest.py", "base()")])
def test_fixtures_that_are_asked_for_count(tree, name, old):
    before = digest(tree)
    (tree / name).write_text(FILES[name].replace(f"{old}:\n", f"{old}:\n    # Another line.\n"))
    assert digest(tree) != before


def test_fixtures_of_its_own_stand_for_those_of_the_folder(tree):
    file = tree / "lamps/test_lamps.py"
    file.write_text("@fixture\ndef studio():\n    pass\n" + FILES["lamps/test_lamps.py"])
    before = digest(tree)
    (tree / "support/studio.py").write_text("# Another line.\n")
    assert digest(tree) == before


def test_its_folder_does_not_count(tree):
    before = digest(tree)
    (tree / "lamps").rename(tree / "lights")
    (tree / "support").joinpath("more").mkdir()
    assert digest(tree, "lights/test_lamps.py") == before
    assert sources.without_folder("tests/lamps/test_lamps.py::test_it[a/b]") == "test_lamps.py::test_it[a/b]"


def test_pictures_beside_cycles_depend_on_their_scenes():
    """Through fixtures of the folder and of the root, and helpers of helpers."""
    found = sources.imported(sources.fixtures_of(TESTS / "parity/test_lamps.py"))
    assert TESTS / "support/lamp_studio.py" in found
