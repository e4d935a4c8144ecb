# SPDX-License-Identifier: GPL-3.0-or-later
"""The sources of the tests' own that decide what a file of tests shows, and their digest. Needs no Blender.

These are the file, the fixtures of conftest.py that it asks for, and what all of these import of the tests' own. Where a file lies
counts nowhere: its name alone does.
"""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path

from support.places import ROOT, SCENES, SUPPORT, TESTS

#: Folders of modules of the tests' own.
_FOLDERS = (TESTS, SCENES)
#: Modules that keep pictures; they decide nothing of what is in them.
_KEEPERS = {SUPPORT / f"{name}.py" for name in ("kept_references", "stored_blocks", "sources", "places")}


def file_of(test: str) -> Path:
    """The file of a test, of its name as pytest has it."""
    return ROOT / test.partition("::")[0]


def without_folder(test: str) -> str:
    """The name of a test without the folder of its file."""
    file, colons, rest = test.partition("::")
    return file.rpartition("/")[2] + colons + rest


@functools.cache
def digest(file: Path, chapter: Path | None = None) -> str:
    """A digest of the sources of a file of tests; of the modules beside `chapter`, in a package, only those that the chapter imports, or the
    file by name."""
    made, fixtures = hashlib.blake2b(), fixtures_of(file)
    beside = set() if chapter is None else _beside(file, chapter)
    known = set(beside)
    waiting = [file, *imported(fixtures)]
    while waiting:
        one = waiting.pop()
        if one not in known and one not in _KEEPERS:
            known.add(one)
            waiting += imported([_tree(one)])
    for one in sorted(known - beside, key=lambda one: (one.name, one.read_bytes())):
        made.update(one.name.encode() + one.read_bytes())
    for text in sorted(fixtures.values()):
        made.update(text.encode())
    return made.hexdigest()


def _beside(file: Path, chapter: Path) -> set[Path]:
    """The modules beside a chapter that neither the chapter, nor those that it imports, nor a file of tests imports."""
    package = chapter.parent
    waiting, needed = [package / "__init__.py", chapter], set()
    for node in ast.walk(_tree(file)):
        if isinstance(node, ast.ImportFrom) and node.module == package.name:
            waiting += [package / f"{alias.name}.py" for alias in node.names]
    while waiting:
        one = waiting.pop()
        if one in needed or not one.exists():
            continue
        needed.add(one)
        for node in ast.walk(_tree(one)):
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                names = [node.module] if node.module else [alias.name for alias in node.names]
                waiting += [package / f"{name}.py" for name in names]
    return set(package.glob("*.py")) - needed


def imported(trees: Iterable[ast.AST]) -> list[Path]:
    """The tests' own modules that are named in imports, wherever in a tree; packages whole, but `support` by module."""
    names: set[str] = set()
    for tree in trees:
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    # With the packages that they lie in: modules of one import each other by dots.
    names = {name.rsplit(".", i)[0] for name in names for i in range(name.count(".") + 1)} - {SUPPORT.name}
    found = []
    for place in (folder.joinpath(*name.split(".")) for folder in _FOLDERS for name in sorted(names)):
        if place.with_suffix(".py").exists():
            found.append(place.with_suffix(".py"))
        if (place / "__init__.py").exists():
            found += sorted(place.rglob("*.py"))
    return found


def fixtures_of(file: Path) -> dict[ast.FunctionDef, str]:
    """The fixtures of conftest.py, from the file's folder up, that a file of tests asks for, and those that these ask for: their
    trees and texts."""
    tree = _tree(file)
    own = {name for name, function in _functions(tree).items() if name not in _asked(function)}
    asked, found = _asked(tree) - own, {}
    for folder in (one for one in file.parents if one.is_relative_to(TESTS)):
        conftest = folder / "conftest.py"
        there = _functions(_tree(conftest)) if conftest.exists() else {}
        # One may ask for another of the same conftest.py.
        while more := [there.pop(name) for name in sorted(asked & there.keys())]:
            found |= {one: _text(conftest, one) for one in more}
            asked = asked.union(*map(_asked, more))
    return found


def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def _functions(tree: ast.Module) -> dict[str, ast.FunctionDef]:
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def _text(file: Path, function: ast.FunctionDef) -> str:
    first = min([function.lineno, *(one.lineno for one in function.decorator_list)])
    return "".join(file.read_text(encoding="utf-8").splitlines(keepends=True)[first - 1 : function.end_lineno])


def _asked(tree: ast.AST) -> set[str]:
    """Names of arguments of functions, and of the fixtures that `usefixtures` names."""
    found = {one.arg for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) for one in node.args.args}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "usefixtures":
            found |= {one.value for one in node.args if isinstance(one, ast.Constant)}
    return found
