# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval and Cycles on the same scenes, picture beside picture: what `make parity` runs."""

#: Begins a line of JSON among what Blender says.
MARK = "PARITY "
