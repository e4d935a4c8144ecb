# SPDX-License-Identifier: GPL-3.0-or-later
"""The house rules that no compiler holds: who may use whom, and what must not stand in a tracked file.

Data goes one way. Crates depend downward: python, render and pictures, then optics and nodes. Inside a crate a module uses only those above it in
the list with arrows of its `lib.rs`. The add-on's modules form no circle, and its plain ones know no Blender. A test imports from tests/support, never from another test.
"""

from __future__ import annotations

import ast
import graphlib
import re
import shutil
import subprocess
import tomllib
import warnings
from itertools import pairwise
from pathlib import Path

import pytest

from support.places import ROOT, TESTS

pytestmark = pytest.mark.once

CRATES = ("files", "optics", "nodes", "pictures", "proof", "render", "gpu")

# A longer file is asked whether it is one subject.
LONG_FILE_LINES = 450


def tracked_files() -> list[Path]:
    listing = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listing.returncode:
        pytest.skip(f"not a git checkout: {listing.stderr.strip()}")
    return [ROOT / name for name in listing.stdout.split("\0") if name and (ROOT / name).is_file()]


# Rust ------------------------------------------------------------------------------------------------------------


def module_order(crate: str) -> list[str]:
    """The modules of `lib.rs`'s own list, [`first`] → [`second`] → ..., first to last."""
    text = (ROOT / "engine" / crate / "src/lib.rs").read_text()
    comment = " ".join(line.removeprefix("//!").strip() for line in text.splitlines() if line.startswith("//!"))
    chain = re.search(r"\[`\w+`\](?:\s*→\s*\[`\w+`\])+", comment)
    return re.findall(r"\[`(\w+)`\]", chain.group()) if chain else []


def program_text(source: str) -> str:
    """Rust source without comments and without the tests at its end."""
    source = re.split(r"^#\[cfg\(test\)\]\s*(?:#\[[^\]]*\]\s*)*mod ", source, flags=re.MULTILINE)[0]
    return re.sub(r"//[^\n]*", "", source)


def used_modules(source: str, root_word: str) -> set[str]:
    """First names after `crate::` (or `super::` where that is the crate), braces opened."""
    names = set(re.findall(rf"\b{root_word}::(\w+)", source))
    for group in re.finditer(rf"\b{root_word}::\{{", source):
        depth, start, position = 1, group.end(), group.end()
        while depth:
            character = source[position]
            depth += (character == "{") - (character == "}")
            if (depth == 1 and character == ",") or depth == 0:
                names.add(re.match(r"\s*(\w*)", source[start:position]).group(1))
                start = position + 1
            position += 1
    return names


@pytest.mark.parametrize("crate", CRATES)
def test_every_module_has_its_place_in_the_list(crate):
    text = program_text((ROOT / "engine" / crate / "src/lib.rs").read_text())
    modules = set(re.findall(r"^(?:pub(?:\([^)]*\))? )?mod (\w+);", text, flags=re.MULTILINE))
    order = module_order(crate)
    assert order, f"engine/{crate}/src/lib.rs lists no order: write [`first`] → [`second`] → ... in its comment"
    assert set(order) == modules, f"engine/{crate}/src/lib.rs: its list and its modules differ"
    assert len(order) == len(set(order))


@pytest.mark.parametrize("crate", CRATES)
def test_a_module_uses_only_those_above_it(crate):
    source_folder = ROOT / "engine" / crate / "src"
    order = module_order(crate)
    wrong = []
    for path in sorted(source_folder.rglob("*.rs")):
        inside = path.relative_to(source_folder)
        module = inside.parts[0].removesuffix(".rs")
        if module == "lib" or "tests" in (path.stem, *inside.parts) or module not in order:
            continue
        text = program_text(path.read_text())
        used = used_modules(text, "crate")
        if len(inside.parts) == 1 or inside.parts[1:] == ("mod.rs",):
            used |= used_modules(text, "super")
        below = {name for name in used if name in order and order.index(name) > order.index(module)}
        wrong += [f"{path.relative_to(ROOT)} uses {name}, which stands below {module}" for name in sorted(below)]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("crate", "forbidden"),
    [
        (
            "files",
            {
                "petzval-optics",
                "petzval-nodes",
                "petzval-render",
                "petzval-pictures",
                "petzval-python",
                "pyo3",
                "petzval-testkit",
            },
        ),
        ("fourier", {"petzval-optics", "petzval-nodes", "petzval-render", "petzval-python", "pyo3", "petzval-testkit"}),
        ("optics", {"petzval-render", "petzval-python", "pyo3", "numpy", "petzval-testkit"}),
        ("nodes", {"petzval-optics", "petzval-render", "petzval-python", "pyo3", "numpy", "petzval-testkit"}),
        (
            "pictures",
            {"petzval-optics", "petzval-nodes", "petzval-render", "petzval-python", "pyo3", "numpy", "petzval-testkit"},
        ),
        ("proof", {"petzval-render", "petzval-python", "pyo3", "numpy", "petzval-testkit"}),
        ("render", {"petzval-python", "pyo3", "numpy", "petzval-testkit"}),
        ("gpu", {"petzval-render", "petzval-python", "pyo3", "numpy", "petzval-testkit"}),
        ("testkit", {"petzval-python", "pyo3", "numpy"}),
        ("python", {"petzval-testkit"}),
    ],
)
def test_crates_depend_downward(crate, forbidden):
    manifest = tomllib.loads((ROOT / "engine" / crate / "Cargo.toml").read_text())
    assert not forbidden & set(manifest.get("dependencies", {}))


def test_cargo_test_needs_no_python():
    workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]
    assert "engine/python" not in workspace["default-members"]


def test_module_and_tests_share_compiled_crates():
    """Every crate of the Python module has the same features in the workspace with its tests, else it is compiled twice."""
    if shutil.which("cargo") is None:
        pytest.skip("no cargo")

    def features(*selection: str) -> set[str]:
        command = ["cargo", "tree", "--locked", "--prefix", "none", "--format", "{p} [{f}]", *selection]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        return {line.removesuffix(" (*)") for line in done.stdout.splitlines()}

    module = features("--package", "petzval-python", "--edges", "normal,build")
    assert module <= features("--workspace", "--edges", "normal,build,dev"), "see engine/python/Cargo.toml"


# Python ----------------------------------------------------------------------------------------------------------


def imports(path: Path, package: str, *, everywhere: bool) -> set[str]:
    """Full names that a file of `package` imports: at its top level, or `everywhere`, in functions too.

    What stands under `if TYPE_CHECKING:` is not an import.
    """
    tree = ast.parse(path.read_text(), str(path))
    found: set[str] = set()
    parts = package.split(".")
    nodes = ast.walk(tree) if everywhere else tree.body
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = (
                ".".join([*parts[: len(parts) - node.level + 1], *filter(None, [node.module])])
                if node.level
                else node.module
            )
            found |= {base, *(f"{base}.{alias.name}" for alias in node.names)}
    return found


def python_modules(folder: Path, package: str) -> dict[str, tuple[Path, str]]:
    """Module name to (file, the package that it counts its dots from)."""
    modules = {}
    for path in sorted(folder.rglob("*.py")):
        inside = path.relative_to(folder)
        if "_bundled" in inside.parts or "presets" in inside.parts:
            continue
        parts = [package, *inside.with_suffix("").parts]
        if parts[-1] == "__init__":
            parts = parts[:-1]
            modules[".".join(parts)] = (path, ".".join(parts))
        else:
            modules[".".join(parts)] = (path, ".".join(parts[:-1]))
    return modules


@pytest.mark.parametrize(("folder", "package"), [("addon", "addon"), ("engine/python/petzval", "petzval")])
def test_python_modules_form_no_circle(folder, package):
    modules = python_modules(ROOT / folder, package)
    graph = {
        # A package's own __init__ is loaded before its modules whatever they import; it stands above them.
        name: {
            used
            for used in imports(path, base, everywhere=False)
            if used in modules and used != name and not name.startswith(f"{used}.")
        }
        for name, (path, base) in modules.items()
    }
    try:
        tuple(graphlib.TopologicalSorter(graph).static_order())
    except graphlib.CycleError as error:
        pytest.fail("a circle of imports: " + " → ".join(error.args[1]))


def top_names(names: set[str]) -> set[str]:
    return {name.split(".")[0] for name in names}


@pytest.mark.parametrize("name", ["data/tiles.py", "data/effects.py", "data/film_formats.py", "drawing/canvas.py"])
def test_plain_parts_of_the_addon_know_no_blender(name):
    path = ROOT / "addon" / name
    assert not {"bpy", "gpu", "mathutils"} & top_names(imports(path, f"addon.{name.split('/')[0]}", everywhere=True))


def test_the_package_loads_no_blender_by_itself():
    for name, (path, base) in python_modules(ROOT / "engine/python/petzval", "petzval").items():
        # Plots without matplotlib are made in Blender alone, whose Python has numpy; data sets are arrays, and their command loads them
        # when it is asked for. So does that of proofs their checker.
        has_arrays = name.startswith(("petzval.plotting", "petzval.dataset", "petzval.proof_check"))
        allowed = {"numpy"} if has_arrays else set()
        assert not ({"bpy", "numpy", "petzval_addon"} - allowed) & top_names(imports(path, base, everywhere=False)), (
            name
        )


def test_the_addon_does_not_use_the_command_line():
    for name, (path, base) in python_modules(ROOT / "addon", "addon").items():
        used = imports(path, base, everywhere=True)
        assert not {one for one in used if re.match(r"petzval\.(cli|\w+_command)\b", one)}, name


# Tests -----------------------------------------------------------------------------------------------------------


#: Where a file of tests could be imported from by its name alone.
FOLDERS_OF_TESTS = {"", "tests", *(path.name for path in TESTS.iterdir() if path.is_dir())}
#: Functions that import a module named by a text.
IMPORTERS = {"import_module", "__import__", "importorskip", "spec_from_file_location", "run_path"}


def is_of_tests(name: str) -> bool:
    """True of the name of a file of tests or of a conftest.py, and of a name that stands in one."""
    return any(part == "conftest" or part.startswith("test_") for part in re.split(r"[./]", name))


def imports_of_tests(source: str) -> set[str]:
    """Files of tests that a Python source imports, wherever in it."""
    named: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            named |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            named.add(module)
            # Of another module, a name is what stands in it.
            if module.rpartition(".")[2] in FOLDERS_OF_TESTS:
                named |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in IMPORTERS:
            named |= {one.value for one in node.args if isinstance(one, ast.Constant) and isinstance(one.value, str)}
    return {name for name in named if is_of_tests(name)}


def test_no_test_imports_from_another():
    wrong = [
        f"{path.relative_to(ROOT)} imports {name}: put it into tests/support or a conftest.py"
        for path in sorted(TESTS.rglob("*.py"))
        for name in sorted(imports_of_tests(path.read_text(encoding="utf-8")))
    ]
    assert not wrong, "\n".join(wrong)


def test_files_of_tests_have_names_of_their_own():
    """Stored pictures and kept times go by the name alone."""
    names = [path.name for path in TESTS.rglob("test_*.py")]
    assert len(names) > 50
    assert len(names) == len(set(names)), sorted(name for name in set(names) if names.count(name) > 1)


def test_every_test_lies_in_a_folder_by_subject():
    assert not list(TESTS.glob("test_*.py"))
    assert not list((TESTS / "support").rglob("test_*.py"))


# Tracked files ---------------------------------------------------------------------------------------------------

# One letter stands in a class of its own, so that this file does not trip over itself.
MACHINE_PATHS = re.compile(r"(?<![\w.])/([r]oot/|[h]ome/[a-z]|[w]ork/|[U]sers/)")
REGISTRY_HOSTS = re.compile(r"pypi[.]org|pythonhosted[.]org|deb[.]debian[.]org|static[.]crates[.]io")


def tracked_texts():
    for path in tracked_files():
        try:
            yield path.relative_to(ROOT), path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue


def test_no_path_of_a_machine_and_no_registry_in_tracked_files():
    wrong = [
        f"{path}:{number}: {line.strip()[:120]}"
        for path, text in tracked_texts()
        for number, line in enumerate(text.splitlines(), 1)
        if MACHINE_PATHS.search(line) or REGISTRY_HOSTS.search(line)
    ]
    assert not wrong, "\n".join(wrong)


def test_one_version():
    cargo = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    extension = tomllib.loads((ROOT / "addon/blender_manifest.toml").read_text())["version"]
    assert extension == cargo


def test_long_files_are_named():
    for path, text in tracked_texts():
        if path.suffix in (".rs", ".py") and (lines := text.count("\n")) > LONG_FILE_LINES:
            warnings.warn(f"{path} has {lines} lines: is it one subject?", stacklevel=1)


# The rules themselves --------------------------------------------------------------------------------------------


def test_used_modules_opens_braces():
    source = "use crate::{film::{Film, Tile}, job, scene::Scene};\nuse crate::lights::Light; // crate::no\n"
    assert used_modules(program_text(source), "crate") == {"film", "job", "scene", "lights"}


def test_program_text_leaves_tests_out():
    assert "job" not in program_text("use crate::film;\n#[cfg(test)]\nmod tests {\n    use crate::job;\n}\n")


def test_module_order_is_read():
    order = module_order("render")
    assert len(order) > 3
    assert all(first != second for first, second in pairwise(order))


def test_machine_paths_are_found():
    assert MACHINE_PATHS.search("see /ho" + "me/ann/lens.txt")
    assert not MACHINE_PATHS.search("engine/wo" + "rk/x and docs/ho" + "me/a")


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("from test_lamps import lamp", {"test_lamps"}),
        ("def test_it():\n    import test_lamps as lamps", {"test_lamps"}),
        ("from tests.parity.test_lamps import lamp", {"tests.parity.test_lamps"}),
        ("from tests.parity import test_lamps", {"test_lamps"}),
        ("from parity import test_lamps", {"test_lamps"}),
        ("from . import test_lamps", {"test_lamps"}),
        ("from .test_lamps import lamp", {"test_lamps"}),
        ("from conftest import blender", {"conftest"}),
        ("import_module('tests.parity.test_lamps')", {"tests.parity.test_lamps"}),
        ("importlib.import_module('test_lamps')", {"test_lamps"}),
        ("from support import scenes\nfrom support.lamp_studio import lamp\nimport testkit", set()),
        # A function of a helper, not a module.
        ("from parity_scenes.studio import test_card", set()),
    ],
)
def test_imports_of_tests_are_found(source, found):
    assert imports_of_tests(source) == found
