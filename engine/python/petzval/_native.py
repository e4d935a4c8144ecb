# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for the compiled module until somebody imports it; then loads the engine for this processor in its place.

Its shape is in `_native.pyi`. Where a wheel holds one engine only, that is `_native.abi3.so` beside this file, and
Python never comes here: a compiled module goes before a file of the same name.
"""

import importlib.util
import sys
from importlib.machinery import ExtensionFileLoader
from types import ModuleType

from .processors import engine_file


def _load() -> ModuleType:
    """The engine under this module's own name, wherever its file lies."""
    file = str(engine_file())
    loader = ExtensionFileLoader(__name__, file)
    spec = importlib.util.spec_from_file_location(__name__, file, loader=loader)
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


# The import system hands out what stands here once this file has run.
sys.modules[__name__] = _load()
