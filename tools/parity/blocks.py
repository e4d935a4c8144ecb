# SPDX-License-Identifier: GPL-3.0-or-later
"""Two pictures compared by the means of blocks. Needs no Blender."""

from __future__ import annotations

import numpy as np


def block_ratios(ours: np.ndarray, theirs: np.ndarray, columns: int = 4, rows: int = 3) -> np.ndarray:
    """Means over blocks of the picture, ours over theirs: (rows, columns, 3). Blocks that are darker than a hundredth of the
    picture are compared with that hundredth, lest the noise of black be a difference."""

    def means(picture):
        height, width = picture.shape[:2]
        cut = picture[: height // rows * rows, : width // columns * columns, :3].astype(np.float64)
        return cut.reshape(rows, height // rows, columns, width // columns, 3).mean((1, 3))

    ours, theirs = means(ours), means(theirs)
    floor = max(theirs.mean() * 0.01, 1e-12)
    return 1.0 + (ours - theirs) / np.maximum(theirs, floor)
