# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of accuracy: one picture by every camera from the pinhole to the full lens, timed and compared with the truth.

`ladder` says which cameras, `runs` renders them where Blender is, `intervals` says when the times have settled, `accuracy`
parts an error into noise and bias, `flip` sees as an eye does; `results` makes numbers of it all, `advice` the sentence at
the end, `tables` and `plot` the text and the picture. numpy comes with bpy, and is loaded when it is needed.
"""
