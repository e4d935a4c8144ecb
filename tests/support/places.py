# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders of the checkout that tests read. Needs no Blender."""

from __future__ import annotations

from pathlib import Path

SUPPORT = Path(__file__).resolve().parent
TESTS = SUPPORT.parent
ROOT = TESTS.parent
#: .blend files, and the scripts that make scenes.
SCENES = TESTS / "scenes"
#: Numbers that were computed by other programs.
REFERENCE = TESTS / "reference"
