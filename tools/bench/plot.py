# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise over CPU time, one panel a camera."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import NullFormatter  # noqa: E402

from .noise import Convergence  # noqa: E402
from .programs import CAMERAS, CYCLES, LLVM, NAMES, PETZVAL, SCALAR  # noqa: E402

LOOKS = {PETZVAL: ("#c1272d", "o"), CYCLES: ("#0072b2", "s"), SCALAR: ("#777777", "^"), LLVM: ("#222222", "v")}


def draw(found: dict, targets: tuple[float, ...], path: Path) -> None:
    """Writes PATH.png and PATH.svg."""
    cameras = [camera for camera in CAMERAS if camera in found["noise"]]
    # Both kinds of the exact lens in one panel: no other program has the spectrum.
    panels = [[camera] for camera in cameras if not camera.startswith("lens")]
    panels += [lenses] if (lenses := [camera for camera in cameras if camera.startswith("lens")]) else []
    plt.rcParams |= {"font.size": 9, "svg.hashsalt": "petzval", "axes.spines.top": False, "axes.spines.right": False}
    figure, all_axes = plt.subplots(1, len(panels), figsize=(3.6 * len(panels), 3.6), sharey=True, squeeze=False)
    for axes, panel in zip(all_axes[0], panels, strict=True):
        for camera in panel:
            for program, one in found["noise"][camera].items():
                _line(axes, program, camera, one)
        for target in targets:
            axes.axhline(target, color="#bbbbbb", linewidth=0.8, zorder=0)
        axes.set(xscale="log", yscale="log", xlabel="CPU seconds")
        # Whole decades, so that each axis has a number at least at its ends.
        low, high = np.log10(axes.get_xlim())
        axes.set_xlim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set_title("exact lens" if panel[0].startswith("lens") else CAMERAS[panel[0]])
        axes.legend(frameon=False, fontsize=7)
    all_axes[0][0].set_ylabel("relMSE, trimmed")
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path.with_suffix(".png"), dpi=130, metadata={"Software": None})
    figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
    plt.close(figure)


def _line(axes, program: str, camera: str, one: dict) -> None:
    colour, marker = LOOKS[program]
    fitted = Convergence(one["error_samples"], one["seconds_per_sample"])
    samples = np.array(one["samples"], float)
    name = NAMES[program] + (", spectrum" if camera == "lens" else "")
    style = "--" if camera == "lens" else "-"
    seconds = samples * fitted.seconds_per_sample
    axes.plot(seconds, one["errors"], marker, color=colour, markersize=4, fillstyle="none" if camera == "lens" else "full")  # fmt: skip
    ends = np.array([0.6 * samples[0], 1.6 * samples[-1]])
    axes.plot(ends * fitted.seconds_per_sample, fitted.error_samples / ends, style, color=colour, linewidth=1, label=name)  # fmt: skip
