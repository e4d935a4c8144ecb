# SPDX-License-Identifier: GPL-3.0-or-later
"""Data sets of pictures with ground truth: `petzval dataset`.

`spec` reads the specification; `in_blender` renders it picture by picture; `assembling` writes the files that are about all pictures.
Camera poses are matrices from camera space to world space, (4, 4), Blender's axes: x right, y up, the view along -z.
"""
