# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of costs.json, from the measurements of the rungs.

Time is processor time over threads: the wall time of a machine with nothing else to do. Errors are relative squared
ones (`accuracy`), for the picture's number of samples: the bias stays, the noise falls with it.
"""

from __future__ import annotations

import math
from statistics import median
from typing import Any

from . import accuracy, flip, intervals
from .ladder import AUTO, TOP, effect_of, is_camera

#: Errors whose price is told.
TARGETS = (1e-2, 1e-3)


def of(measured: Any) -> dict[str, Any]:
    """The object of costs.json."""
    settings, subject = measured.settings, measured.subject
    samples = settings.samples
    pixels = settings.width * settings.height
    rows = [_row(one, measured, samples, pixels) for one in measured.runs.values()]
    strays = _add_strays(rows, measured)
    _mark_front(rows)
    top = measured.runs[TOP]
    noise = accuracy.error(top.pictures, measured.truth).noise * top.samples / measured.truth_samples
    return {
        "lens": top.stats["lens"],
        "size": [settings.width, settings.height],
        "samples": samples,
        "threads": top.stats["threads"],
        "integrator": top.stats["integrator"],
        "rounds": measured.rounds,
        "settled": measured.settled(),
        "settled_width": intervals.SETTLED,
        "confidence": intervals.CONFIDENCE,
        "seconds": {"sync": subject.sync_seconds, "bvh": subject.scene.bvh_seconds, "all": measured.elapsed()},
        "truth": {"samples": measured.truth_samples, "rel_mse": noise},
        "base": measured.base().rung.key,
        "targets": list(TARGETS),
        "rungs": rows,
        "strays": strays,
        "auto": _forecast(measured, samples),
    }


def _row(one: Any, measured: Any, samples: int, pixels: int) -> dict[str, Any]:
    rung = one.rung
    row: dict[str, Any] = {"key": rung.key, "name": rung.name, "group": rung.group, "effect": effect_of(rung.key)}
    if one.why_not is not None or one.pictures.count < 2:
        return row | {"is_measured": False, "why_not": one.why_not or "broken off"}
    threads = one.stats["threads"]
    a_sample = median(one.processor_s) / (threads * one.samples * pixels)
    ratio, low, high = intervals.median_interval(measured.ratios(one))
    setup = median(one.setup_s)
    error = accuracy.error(one.pictures, measured.truth)
    noise_of_one = error.noise * one.samples
    seconds = setup + a_sample * samples * pixels

    def seconds_to(target: float) -> float | None:
        left = target - error.sure_bias
        return setup + a_sample * pixels * max(noise_of_one / left, 1.0) if left > 0.0 else None

    exposure = 2.0**measured.exposure_stops
    truth = 0.5 * (measured.truth[0].mean() + measured.truth[1].mean())
    stats = one.stats
    return row | {
        "is_measured": True,
        "samples_measured": one.samples * one.pictures.count,
        "us_a_sample": a_sample * 1e6,
        "wall_us_a_sample": median(one.wall_s) / (one.samples * pixels) * 1e6,
        "ratio": ratio,
        "ratio_interval": [low, high] if math.isfinite(high) else None,
        "setup_s": setup,
        "seconds": seconds,
        "rel_mse": error.sure_bias + noise_of_one / samples,
        "bias": error.sure_bias,
        "bias_estimate": error.bias,
        "bias_uncertainty": error.bias_uncertainty,
        "noise_of_one_sample": noise_of_one,
        "flip": flip.flip(one.pictures.mean() * exposure, truth * exposure),
        "seconds_to": [seconds_to(target) for target in TARGETS],
        "pipeline": stats["pipeline"],
        "model": one.plan["camera"]["model"],
        "wavelengths": one.plan["camera"]["wavelengths"],
        "rays_a_sample": stats["rays"] / max(stats["camera_rays"], 1),
        "lost": stats["camera_rays_lost"] / max(stats["camera_rays"], 1),
        "lens_share": stats["lens_share"],
    }


def _add_strays(rows: list[dict[str, Any]], measured: Any) -> dict[str, Any] | None:
    """Puts the cost and the change of each kind of stray light into its row, and returns those of all kinds together.

    Each is held against the truth with everything on, all stray light with it. The rungs know that light apart from the picture, so it is
    not lost in the picture's noise.
    """
    kinds = {row["key"]: measured.runs[row["key"]] for row in rows if row["group"] == "stray" and row["is_measured"]}
    if not kinds:
        return None
    exposure = 2.0**measured.exposure_stops
    straight = 0.5 * (measured.truth[0].mean() + measured.truth[1].mean())
    together = sum(one.strayed.mean() for one in kinds.values())
    truth = straight + together
    for row in rows:
        if row["key"] in kinds:
            one = kinds[row["key"]]
            error = accuracy.change(one.strayed, truth)
            row |= {
                "bias": error.sure_bias,
                "bias_estimate": error.bias,
                "bias_uncertainty": error.bias_uncertainty,
                "stray_s": median(one.stray_s),
                "flip": flip.flip((truth - one.strayed.mean()) * exposure, truth * exposure),
            }
    # Different kinds are from different pictures, so their noise is not alike.
    each = [accuracy.change(one.strayed, truth) for one in kinds.values()]
    noise = sum(error.noise / one.strayed.count for error, one in zip(each, kinds.values(), strict=True))
    return {
        "bias": max(accuracy.size(together, truth) - noise, 0.0),
        "stray_s": sum(median(one.stray_s) for one in kinds.values()),
        "flip": flip.flip(straight * exposure, truth * exposure),
        "planned": [
            row["effect"] for row in measured.planned if row["decision"] == "on" and f"with-{row['effect']}" in kinds
        ],
    }


def _mark_front(rows: list[dict[str, Any]]) -> None:
    """Marks the cameras for which no other is both faster and nearer to the truth."""
    cameras = [row for row in rows if row["is_measured"] and is_camera(row)]
    for row in rows:
        row["is_on_front"] = row in cameras and not any(
            (other["seconds"], other["rel_mse"]) != (row["seconds"], row["rel_mse"])
            and other["seconds"] <= row["seconds"]
            and other["rel_mse"] <= row["rel_mse"]
            for other in cameras
        )


def _forecast(measured: Any, samples: int) -> dict[str, Any]:
    """The plan's forecast of its render's time, beside the measured time; for the picture's samples, wall clock."""
    one = measured.runs[AUTO]
    scale = samples / one.samples
    # Both in the same round: the machine may be slower in one than in another.
    quotients = [said / was for said, was in zip(one.predicted_s, one.wall_s, strict=False)]
    quotient, low, high = intervals.median_interval(quotients)
    return {
        "predicted_s": median(one.predicted_s) * scale,
        "measured_s": median(one.wall_s) * scale,
        "predicted_over_measured": quotient,
        "interval": [low, high] if math.isfinite(high) else None,
        "quotients": quotients,
        "effects": measured.planned,
        "camera": one.plan["camera"],
    }
