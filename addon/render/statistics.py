# SPDX-License-Identifier: GPL-3.0-or-later
"""The statistics of the last render of each scene; kept in memory, for the panels and for programs. No bpy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from .progress import in_short

#: The words for the place where camera rays are lost that no lens takes, by the camera model.
_OUTSIDE = {"panoramic": "outside of the projection", "calibrated": "outside of the calibration"}
#: The last renders by the scene's name.
_last: dict[str, LastRender] = {}


@dataclass
class LastRender:
    """`stats` is the engine's `Job.stats_json`, with the seconds of `sync` added, and `camera`: the camera of the picture, in a line."""

    stats: dict[str, Any]
    warnings: list[str] = field(default_factory=list)
    stopped: bool = False

    def lines(self) -> list[str]:
        """The statistics in words."""
        seconds = self.stats["seconds"]
        lost = self.stats["camera_rays_lost"] / max(self.stats["camera_rays"], 1)
        where = _OUTSIDE.get(self.stats["lens"], "lost in the lens")
        samples = f"{self.stats['samples']} samples"
        if self.stats.get("samples_most", self.stats["samples"]) != self.stats["samples"]:
            least, mean, most = self.stats["samples"], self.stats["samples_mean"], self.stats["samples_most"]
            samples = f"{least} to {most} samples, {mean:.1f} in the mean"
        lines = [
            *([self.stats["camera"]] if "camera" in self.stats else []),
            f"{self.stats['lens']}, {self.stats['width']} x {self.stats['height']}, {samples}"
            + (" (stopped)" if self.stopped else " (time was up)" if self.was_late() else ""),
            *([self.stats["sampling"]] if self.stats.get("sampling") else []),
            _seconds(seconds),
            f"{100.0 * lost:.2f} % of the camera rays {where}",
        ]
        if seconds["render"] > 0.0:
            speed = f"{in_short(self.stats['rays'] / seconds['render'])} rays a second"
            peak = self.stats.get("peak_memory_bytes")
            lines.append(f"{speed}, at most {peak / 2**30:.2f} GB of memory" if peak else speed)
        if predicted := (self.stats.get("planned") or {}).get("predicted"):
            after = predicted["after_seconds"]
            of_it = f", {after:.1f} s of it after the samples" if after else ""
            lines.append(f"the plan foretold {predicted['seconds']:.1f} s{of_it}")
        traced = self.stats["light_tracing"]
        if traced["aimed"]:
            lines.append(
                f"{traced['aimed']} of {traced['lights']} lights are traced to the lens, {traced['rays_per_sample']:.2g} rays a sample: "
                f"camera rays would hit the smallest {traced['camera_hits']:.2g} times a sample in its disc"
            )
        if kept := (self.stats.get("checkpoint") or {}).get("resumed_samples"):
            seconds = self.stats["checkpoint"]["resumed_seconds"]
            lines.append(f"taken up at {kept:.1f} samples, which had taken {seconds:.0f} s")
        if precision := self.stats.get("precision"):
            lines.append(_precision(precision))
        return lines

    def was_late(self) -> bool:
        """True if the time limit was up before the render had all samples."""
        limit = self.stats.get("time_limit_s") or 0.0
        return 0.0 < limit <= self.stats["seconds"]["render"] and not self.stopped


def _seconds(seconds: dict[str, Any]) -> str:
    """The time of each step and of all together, in words."""
    strays = sum((seconds.get("strays") or {}).values())
    parts = {"sync": seconds["sync"], "trees": seconds["bvh"], "samples": seconds["render"]}
    if "denoise" in seconds:
        parts["denoising"] = seconds["denoise"]
    if strays:
        parts["ghosts, glare and diffraction"] = strays
    said = ", ".join(f"{name} {value:.2f} s" for name, value in parts.items())
    return f"{said}; {sum(parts.values()):.2f} s in all"


def _precision(precision: dict[str, Any]) -> str:
    number = {"f32": "single", "f64": "double"}[precision["chosen"]]
    error = precision["f32_error_px"]
    moved = "loses rays" if error is None else f"moves them by up to {error:.2g} pixels"
    return f"rays leave through the lens in {number} precision; single {moved}"


def keep(scene_name: str, render: LastRender) -> None:
    """Remembers a render as the scene's last."""
    _last[scene_name] = render


def last(scene_name: str) -> LastRender | None:
    """The scene's last render in this session."""
    return _last.get(scene_name)


def forget() -> None:
    """Drops all statistics."""
    _last.clear()
