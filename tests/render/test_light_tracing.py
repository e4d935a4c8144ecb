# SPDX-License-Identifier: GPL-3.0-or-later
"""Light tracing: a small lamp far out of focus, held against the light that it sends through the lens."""

from __future__ import annotations

import numpy as np
import pytest

WIDTH, HEIGHT, SAMPLES = 96, 64, 8
#: Metres, watts.
DISTANCE, RADIUS, POWER = 6.0, 0.002, 0.4


@pytest.fixture
def night(parts, blender):
    """A lamp in the dark, before a 50 mm lens that is focused near."""
    scene = parts.set_up(WIDTH, HEIGHT, SAMPLES, model="LENS")
    scene.world = parts.grey_world(0.0)
    parts.straight(scene)
    own = scene.camera.data.petzval
    own.lens_file, own.wide_open = "double-gauss-f2-tronnier.lens", True
    scene.camera.data.dof.focus_distance = 0.8
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.data.shadow_soft_size = POWER, RADIUS
    lamp.location = (0.0, DISTANCE, 0.0)
    # Blender hides a new lamp from the camera.
    lamp.visible_camera = True
    scene.collection.objects.link(lamp)
    return scene


def picture(parts, scene, folder, name: str, *, is_traced: bool = True, seed: int = 0) -> np.ndarray:
    scene.petzval.use_light_tracing, scene.petzval.seed = is_traced, seed
    return parts.render(folder, f"{name}.exr")[..., :3].mean(axis=-1)


def middle(light: np.ndarray) -> float:
    return float((light.sum(axis=0) * np.arange(WIDTH)).sum() / light.sum())


def test_all_of_a_lamps_light_arrives(parts, night, tmp_path):
    """A film point gets the lamp's radiance from the part of the pupil that sees the lamp. So over the film, in units of what the whole
    pupil would give, the sum is the radiance times the area of the lamp's image as one point of the pupil has it: W / 4 pi² r² times
    pi r² m², the magnification m in pixels measured by moving the lamp."""
    lamp, own = night.objects["Lamp"], night.camera.data.petzval
    own.wide_open, own.f_number = False, 5.6
    night.petzval.samples = 64
    seen = picture(parts, night, tmp_path, "middle")
    traced = parts.part("render.statistics").last(night.name)
    assert traced.stats["light_tracing"]["aimed"] == 1
    assert any(line.startswith("1 of 1 lights are traced to the lens") for line in traced.lines())
    lamp.location.x = 0.2
    aside = picture(parts, night, tmp_path, "aside")
    pixels_per_unit = (middle(aside) - middle(seen)) / 0.2
    expected = POWER / (4.0 * np.pi) * pixels_per_unit**2
    # The aberrations of the pupil change the magnification over it: wide open 2.7 %, at f/5.6 less than 1 %.
    assert seen.sum() == pytest.approx(expected, rel=0.02)


@pytest.mark.once
def test_its_disc_has_little_noise(parts, night, tmp_path):
    night.petzval.samples = 1024
    truth = picture(parts, night, tmp_path, "truth", seed=9)
    lit = truth > 0.5 * truth.max()

    def error(is_traced: bool) -> float:
        found = [picture(parts, night, tmp_path, "one", is_traced=is_traced, seed=seed) for seed in range(4)]
        return float(np.sqrt(np.mean([((one - truth)[lit] ** 2).mean() for one in found])) / truth[lit].mean())

    night.petzval.samples = SAMPLES
    traced = error(True)
    assert parts.part("render.statistics").last(night.name).stats["light_tracing"]["aimed"] == 1
    plain = error(False)
    assert parts.part("render.statistics").last(night.name).stats["light_tracing"]["aimed"] == 0
    # Eight rays a pixel, stratified. The camera's hit the lamp once in 8000: hardly ever, which is an error of 1, or one is far too bright.
    assert lit.sum() > 20 and traced < 0.4 and plain > 0.95, (lit.sum(), traced, plain)
