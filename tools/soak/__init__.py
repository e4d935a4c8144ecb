# SPDX-License-Identifier: GPL-3.0-or-later
"""Soak tests: what Blender with Petzval keeps of memory, open files and threads after thousands of edits, renders and frames."""
