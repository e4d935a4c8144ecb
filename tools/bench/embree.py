# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of a ray in Embree, by way of Mitsuba: the rays of a first view, and those of a first diffuse bounce."""

from __future__ import annotations

import resource
from statistics import median

import drjit as dr
import mitsuba as mi

RAYS = 1 << 20
ROUNDS = 7


def measure(scene: mi.Scene) -> dict[str, float]:
    """Nanoseconds a ray, closest hits and shadows alike, user time of the one thread that Dr.Jit was given."""
    dice = mi.PCG32(RAYS)
    place = mi.Point2f(dice.next_float32(), dice.next_float32())
    primary, _ = scene.sensors()[0].sample_ray(0.0, 0.5, place, mi.Point2f(0.5))
    dr.eval(primary)
    hit = scene.ray_intersect(primary)
    # From the side that was seen.
    facing = dr.select(dr.dot(hit.n, primary.d) < 0.0, hit.n, -hit.n)
    turned = mi.Frame3f(facing).to_world(
        mi.warp.square_to_cosine_hemisphere(mi.Point2f(dice.next_float32(), dice.next_float32()))
    )
    kept = dr.compress(hit.is_valid())
    origin = [dr.gather(mi.Float, part, kept) for part in hit.p + 1e-4 * facing]
    bounce = mi.Ray3f(mi.Point3f(*origin), mi.Vector3f(*(dr.gather(mi.Float, part, kept) for part in turned)))
    dr.eval(bounce)
    dr.sync_thread()
    return {
        "closest/primary": _time(lambda: scene.ray_intersect_preliminary(primary, coherent=False).t, RAYS),
        "closest/bounce": _time(lambda: scene.ray_intersect_preliminary(bounce, coherent=False).t, len(kept)),
        "any/bounce": _time(lambda: scene.ray_test(bounce, coherent=False), len(kept)),
        "rays": float(RAYS),
    }


def _time(what, rays: int) -> float:
    seconds = []
    # The first compiles.
    for _ in range(1 + ROUNDS):
        before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        dr.eval(what())
        dr.sync_thread()
        seconds.append(resource.getrusage(resource.RUSAGE_SELF).ru_utime - before)
    return 1e9 * median(seconds[1:]) / rays
