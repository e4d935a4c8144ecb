# SPDX-License-Identifier: GPL-3.0-or-later
"""One picture on many machines: a job is a folder with everything that its parts need, which any machine can render one by one.

`planning` makes the folder, `part` renders one of its parts, `merging` joins them to the picture that one machine would have made, to the
bit. `engines` writes the files that hand a job to the farm's own scheduler; `local` and `dask` run one from here. Nothing here loads
Blender but `in_blender` and `packing`, which run where it is.
"""
