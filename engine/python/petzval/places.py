# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of the lenses and of the add-on: in the checkout when run from one, else inside the installed package."""

from __future__ import annotations

import difflib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

from .errors import CommandError

_PACKAGE = Path(__file__).resolve().parent
# petzval, python, engine: the checkout is what holds all three.
_CHECKOUT = _PACKAGE.parents[2]

#: The name under which the add-on's package stands in `sys.modules` outside of Blender's own extensions.
ADDON_MODULE = "petzval_addon"


def _folder(name: str) -> Path:
    # The checkout comes first: a copy for the wheel may lie in the package there too, and may be older.
    in_checkout = _PACKAGE == _CHECKOUT / "engine" / "python" / "petzval" and (_CHECKOUT / "pyproject.toml").is_file()
    return _CHECKOUT / name if in_checkout else _PACKAGE / "_bundled" / name


def lenses_folder() -> Path:
    """The folder of the shipped lenses (`NAME.lens`)."""
    return _folder("lenses")


def addon_folder() -> Path:
    """The folder of the Blender add-on's package."""
    return _folder("addon")


def find_lens(name_or_path: str) -> Path:
    """The lens file: the path itself if there is such a file, else the shipped lens of that name.

    Raises `CommandError` when it is neither.
    """
    path = Path(name_or_path)
    if path.is_file():
        return path
    if path.exists():
        raise CommandError(f"not a file: {path}: name a lens file, or a shipped lens")
    shipped = {file.stem: file for file in sorted(lenses_folder().glob("*.lens"))}
    name = name_or_path.removesuffix(".lens")
    if name in shipped:
        return shipped[name]
    near = difflib.get_close_matches(path.stem, shipped, n=3, cutoff=0.4) or list(shipped)[:3]
    advice = f"name a file, or a shipped lens such as {', '.join(near)}" if near else "name an existing file"
    raise CommandError(f"no such lens: {name_or_path}: {advice}")


def load_addon() -> ModuleType:
    """The add-on's package, loaded once as `petzval_addon`; its `register()` is the caller's to call.

    Needs bpy. Blender itself loads the add-on as an extension, under another name, without this.
    """
    if ADDON_MODULE in sys.modules:
        return sys.modules[ADDON_MODULE]
    folder = addon_folder()
    spec = importlib.util.spec_from_file_location(
        ADDON_MODULE, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    if spec is None or spec.loader is None:
        raise ImportError(f"{folder}: cannot load the add-on from here")
    module = importlib.util.module_from_spec(spec)
    sys.modules[ADDON_MODULE] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[ADDON_MODULE]
        raise
    return module
