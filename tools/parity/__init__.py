# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval and Cycles on the same scenes, picture beside picture: the program of `make parity`."""

#: The beginning of a line of JSON among Blender's output.
MARK = "PARITY "
