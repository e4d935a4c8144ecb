# SPDX-License-Identifier: GPL-3.0-or-later
"""Light reflected between a lens's surfaces: against brute force, against the sequential trace, as a pass, and in the plan."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

LENS = "double-gauss-f2-tronnier"
#: One wavelength, so that the picture's sum is one number's.
LINE_NM = 550.0
FILM_MM, PIXELS = (24.0, 16.0), (384, 256)
FOCAL_MM, F_NUMBER, SUN_DEG, SUN_STRENGTH = 50.0, 4.0, 8.0, 5.0
SETTING = ("--focal-length", str(FOCAL_MM), "--f-number", str(F_NUMBER))


def told(petzval_cli, *options) -> dict:
    done = petzval_cli("lens", "ghosts", *options, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.once
@pytest.mark.parametrize(
    ("lens", "angle", "rays"),
    [(LENS, "8", "40000"), ("cooke-triplet-50mm", "0", "80000"), ("fisheye-nikkor-16-f2.8", "10", "60000")],
)
def test_the_light_is_that_of_brute_force(petzval_cli, lens, angle, rays):
    """A hundredth, and twice the standard error of chance."""
    found = told(petzval_cli, lens, "--angle", angle, "--f-number", "4", "--brute-force", rays)
    brute = found["brute_force"]
    expected, error = brute["on_film_mm2"][2], brute["error_mm2"][2]
    assert error < 0.01 * expected
    assert found["on_film_mm2"] == pytest.approx(expected, rel=0.01, abs=2.0 * error)
    # A reflection more or less is a way back to the scene.
    assert brute["on_film_mm2"][1] == brute["on_film_mm2"][3] == 0.0


@pytest.mark.once
def test_the_table_says_what_the_numbers_say(petzval_cli):
    found = told(petzval_cli, LENS, "--angle", "8")
    done = petzval_cli("lens", "ghosts", LENS, "--angle", "8", "--count", "3")
    first = found["ghosts"][0]
    rows = [line for line in done.stdout.splitlines() if f"{first['irradiance']:.3e}" in line]
    assert len(rows) == 1 and "-".join(map(str, first["surfaces"])) in rows[0]
    assert f"and {len(found['ghosts']) - 3} weaker ones" in done.stdout
    lit = [ghost["irradiance"] for ghost in found["ghosts"]]
    assert lit == sorted(lit, reverse=True)
    # Light from above has its ghosts on the axis through the picture's middle, up and down.
    assert all(abs(ghost["centre_mm"][0]) < 0.05 for ghost in found["ghosts"][:8])


@pytest.mark.once
@pytest.mark.parametrize(
    ("options", "said"),
    [(("--angle", "120"), "120 degrees"), (("--reflections", "3"), "reflections"), (("--brute-force", "-5"), "-5")],
)
def test_what_cannot_be_is_said(petzval_cli, options, said):
    done = petzval_cli("lens", "ghosts", LENS, *options)
    assert done.returncode in {1, 2} and said in done.stderr


@pytest.fixture
def sun(blender):
    """A sun above a camera with a lens, before nothing at all."""
    from support import scenes

    scene = scenes.set_up(*PIXELS, samples=4, model="LENS")
    own = scene.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = LENS, False, F_NUMBER
    own.focal_mode, own.focal_length = "LENGTH", FOCAL_MM
    own.film_mode, own.film_width, own.film_height = "SIZE", *FILM_MM
    own.focus_mode, own.spectrum, own.wavelength = "INFINITY", "SINGLE", LINE_NM
    lamp = blender.data.lights.new("Sun", "SUN")
    lamp.energy, lamp.angle = SUN_STRENGTH, 0.0
    made = blender.data.objects.new("Sun", lamp)
    scene.collection.objects.link(made)
    # A sun shines along its -z; the camera looks along +y, and up is +z.
    from mathutils import Vector

    towards = Vector((0.0, math.cos(math.radians(SUN_DEG)), math.sin(math.radians(SUN_DEG))))
    made.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    scene.world = scenes.grey_world(0.01)
    # Hardly any ghost is too weak.
    scene.petzval.quality = 100.0
    blender.context.view_layer.update()
    return scene


def passes(scene, path, word: str) -> dict[str, np.ndarray]:
    from support import render_passes

    scene.petzval.effects.ghosts = word
    return render_passes.photograph(path, samples=4)


@pytest.mark.once
def test_the_pass_has_the_light_of_the_sequential_trace(blender, sun, petzval_cli, tmp_path):
    """The sum of the pass is the irradiance of the sun, times what `lens ghosts` has of it on the film, times what a picture counts
    irradiance: one over the projected solid angle of the light cone in its middle."""
    sun.view_layers[0].petzval.use_pass_ghosts = True
    found, without = passes(sun, tmp_path / "on.exr", "ON"), passes(sun, tmp_path / "off.exr", "OFF")
    ghosts = found["Ghosts"]
    assert not without["Ghosts"].any()
    # The same samples: what is more is the pass, but for rounding.
    np.testing.assert_allclose(found["Combined"][..., :3], without["Combined"][..., :3] + ghosts, rtol=1e-5, atol=1e-7)

    film = "x".join(f"{side:g}" for side in FILM_MM)
    expected = told(petzval_cli, LENS, *SETTING, "--angle", str(SUN_DEG), "--wavelength", str(LINE_NM), "--film", film)
    done = petzval_cli(
        "lens",
        "illumination",
        LENS,
        *SETTING,
        "--fields",
        "0",
        "--wavelengths",
        str(LINE_NM),
        "-o",
        tmp_path / "lit.json",
    )
    assert done.returncode == 0, done.stderr
    cone_sr = json.loads((tmp_path / "lit.json").read_text())[0]["fields"][0]["projected_sr"]
    mm2_per_px = FILM_MM[0] * FILM_MM[1] / (PIXELS[0] * PIXELS[1])
    # A sun of strength 1 has an irradiance of 1 W/m² and a white wall in it the radiance 1/π: Blender's units of radiance.
    # The camera makes up for what the lens takes of the light.
    done = petzval_cli("lens", "transmission", LENS, *SETTING, "--wavelengths", str(LINE_NM), "-o", tmp_path / "t.json")
    assert done.returncode == 0, done.stderr
    lost = json.loads((tmp_path / "t.json").read_text())
    let_through = (lost["f_number"] / lost["t_number"]) ** 2
    light = SUN_STRENGTH * expected["on_film_mm2"] / (cone_sr * let_through)
    # A pixel's centre stands for the pixel: a hundredth.
    assert float(ghosts[..., 1].sum() * mm2_per_px) == pytest.approx(light, rel=0.01)
    # The brightest of those in the picture is where the trace has it: its middle in the brightest tenth.
    lit = [
        ghost
        for ghost in expected["ghosts"]
        if all(abs(at) < 0.4 * side for at, side in zip(ghost["centre_mm"], FILM_MM, strict=True))
    ]
    lit = [ghost for ghost in lit if ghost["radius_mm"] > 3.0 * math.sqrt(mm2_per_px)]
    right, up = lit[0]["centre_mm"]
    column, row = int((right / FILM_MM[0] + 0.5) * PIXELS[0]), int((up / FILM_MM[1] + 0.5) * PIXELS[1])
    assert ghosts[row, column, 1] >= np.quantile(ghosts[..., 1], 0.6)


@pytest.mark.once
def test_four_reflections_add_what_the_trace_has_of_them(blender, sun, petzval_cli, tmp_path):
    """In a lens without coatings, that they have light worth the name."""
    sun.camera.data.petzval.coating = "NONE"
    sun.view_layers[0].petzval.use_pass_ghosts = True
    sums = []
    for count in ("2", "4"):
        sun.petzval.ghost_reflections = count
        sums.append(float(passes(sun, tmp_path / f"{count}.exr", "ON")["Ghosts"][..., 1].sum()))
    film = "x".join(f"{side:g}" for side in FILM_MM)
    bare = (LENS, *SETTING, "--coating", "none", "--angle", str(SUN_DEG), "--wavelength", str(LINE_NM), "--film", film)
    two, four = (told(petzval_cli, *bare, "--reflections", count)["on_film_mm2"] for count in ("2", "4"))
    assert 0.01 * two < four < 0.2 * two
    # Each sum is right to a hundredth, and those of four are left out where all of them lie below a bound.
    assert sums[1] / sums[0] - 1.0 == pytest.approx(four / two, rel=0.1)


def test_the_plan_asks_what_shines(blender, sun):
    """A sun above the camera is called for; in an even world nothing is bright."""
    rows = plan(sun)
    assert rows["ghosts"]["decision"] == "on" and rows["ghosts"]["measure"] > rows["ghosts"]["tolerance"]
    blender.data.objects.remove(blender.data.objects["Sun"])
    rows = plan(sun)
    assert rows["ghosts"]["decision"] == "off"


def plan(scene) -> dict[str, dict]:
    import bpy

    from support import scenes

    told = scenes.part("operators.plan").plan(scene, bpy.context.evaluated_depsgraph_get())
    return {row["effect"]: row for row in told["effects"]}


@pytest.mark.once
def test_the_same_bits_for_any_threads(blender, sun, tmp_path):
    sun.view_layers[0].petzval.use_pass_ghosts = True
    found = []
    for threads in (1, 2):
        sun.render.threads_mode, sun.render.threads = "FIXED", threads
        found.append(passes(sun, tmp_path / f"{threads}.exr", "ON"))
    for name, pixels in found[0].items():
        assert np.array_equal(pixels, found[1][name]), name
