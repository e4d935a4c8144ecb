# SPDX-License-Identifier: GPL-3.0-or-later
"""Modules of a crate that stand beside each other, at any depth, import each other in no circle; the package and the add-on neither."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.places import ROOT

pytestmark = pytest.mark.once

CRATES = ("files", "fourier", "gpu", "nodes", "optics", "pictures", "proof", "python", "render")

Module = tuple[str, ...]


def program_text(source: str) -> str:
    """Rust source without comments and without the tests at its end."""
    source = re.split(r"^#\[cfg\(test\)\]\s*(?:#\[[^\]]*\]\s*)*mod ", source, flags=re.MULTILINE)[0]
    return re.sub(r"//[^\n]*", "", source)


def modules(source: Path) -> dict[Module, str]:
    found = {}
    for file in source.rglob("*.rs"):
        parts = file.relative_to(source).with_suffix("").parts
        if "tests" not in parts:
            found[parts[:-1] if parts[-1] in ("mod", "lib", "main") else parts] = program_text(file.read_text("utf-8"))
    return found


def opened(tree: str, before: str = "") -> Iterator[str]:
    """The paths of a tree of `use`."""
    group = re.match(r"([\w:]*)\{(.*)\}$", tree.strip(), re.DOTALL)
    if not group:
        yield before + tree.strip().split(" as ")[0]
        return
    depth, start, inner = 0, 0, group[2] + ","
    for i, letter in enumerate(inner):
        depth += (letter == "{") - (letter == "}")
        if letter == "," and depth == 0:
            if part := inner[start:i].strip():
                yield from opened(part, before + group[1])
            start = i + 1


def paths(text: str) -> Iterator[str]:
    """All paths of a program, those of `use` opened."""
    use = re.compile(r"\buse\s+([^;]+);")
    for tree in use.findall(text):
        yield from opened(tree)
    yield from re.findall(r"\b[a-z_]\w*(?:::\w+)+", use.sub("", text))


def target(path: str, of: Module, known: dict[Module, str]) -> Module | None:
    """The module that a path begins with."""
    first, *rest = path.split("::")
    base = of
    if first == "crate":
        base = ()
    elif first == "super":
        base = of[:-1]
        while rest and rest[0] == "super":
            base, rest = base[:-1], rest[1:]
    elif first != "self":
        if (*of, first) not in known:
            return None
        rest = [first, *rest]
    while rest and (*base, rest[0]) in known:
        base, rest = (*base, rest[0]), rest[1:]
    return base


def circles(arrows: dict[str, set[str]]) -> list[tuple[str, ...]]:
    """Sets of names that reach each other."""
    reached = {name: {name} for name in arrows}
    for name, seen in reached.items():
        waiting = [name]
        while waiting:
            for other in arrows.get(waiting.pop(), ()):
                if other not in seen:
                    seen.add(other)
                    waiting.append(other)
    same = {tuple(sorted(b for b in seen if a in reached.get(b, ()))) for a, seen in reached.items()}
    return sorted(one for one in same if len(one) > 1)


def circles_of(crate: str) -> set[tuple[str, Module, tuple[str, ...]]]:
    known = modules(ROOT / "engine" / crate / "src")
    beside: dict[Module, dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for of, text in known.items():
        for path in paths(text):
            to = target(path, of, known)
            shared = 0
            while to and shared < min(len(of), len(to)) and of[shared] == to[shared]:
                shared += 1
            if to and shared < min(len(of), len(to)):
                beside[of[:shared]][of[shared]].add(to[shared])
    return {(crate, parent, one) for parent, arrows in beside.items() for one in circles(arrows)}


def test_circles_are_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set()}) == [("a", "b", "c")]
    known = {("a",): "", ("b",): "", ("b", "c"): ""}
    assert target("crate::b::c::Thing", ("a",), known) == ("b", "c")
    assert target("super::super::a::f", ("b", "c"), known) == ("a",)
    assert list(opened("crate::{a::{X, Y as Z}, b}")) == ["crate::a::X", "crate::a::Y", "crate::b"]


def test_modules_beside_each_other_form_no_circle():
    found = set().union(*(circles_of(crate) for crate in CRATES))
    assert not found


def test_the_package_does_not_know_the_add_on():
    """The add-on imports the package; the package loads the add-on where Blender is, and imports none of its modules."""
    for file in (ROOT / "engine/python/petzval").rglob("*.py"):
        tree = ast.parse(file.read_text("utf-8"))
        names = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        names += [one.name for node in ast.walk(tree) if isinstance(node, ast.Import) for one in node.names]
        assert not [name for name in names if name.split(".")[0] in ("addon", "petzval_addon")], file
        assert "spec_from_file_location" not in file.read_text("utf-8") or file.name in ("places.py", "_native.py"), (
            file
        )


def test_folders_of_the_add_on_form_no_circle_and_have_few_arrows():
    """The add-on's folders, and the modules at its root, each as one room."""
    root, arrows = ROOT / "addon", defaultdict(set)
    for file in root.rglob("*.py"):
        own = file.relative_to(root).with_suffix("").parts
        if own[0] == "presets":
            continue
        package = own[:-1]
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = package[: len(package) - node.level + 1]
                for name in (one.name for one in node.names):
                    to = (*base, *(node.module.split(".") if node.module else ()), name)[0]
                    if to != own[0] and own[0] != "__init__":
                        arrows[own[0]].add(to)
    assert circles(arrows) == []
    assert sum(map(len, arrows.values())) <= 60
