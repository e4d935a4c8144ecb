# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval: renders Blender scenes through real lenses.

The engine is the compiled module `petzval._native`; nothing is computed in Python. Importing this package loads
neither the engine nor Blender: `from petzval import _native` loads the one, compiled for this processor where the wheel
has several; `load_addon()` asks for the other.
"""

from .places import addon_folder, lenses_folder, load_addon

__all__ = ["addon_folder", "lenses_folder", "load_addon"]
