# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens osl`: Cycles with the script as its camera takes the pictures that Petzval takes; its rays are the lens's."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from petzval import _native
from support.command_line import assert_complains

W, H, FILM = 96, 64, (36.0, 24.0)
DEPTH_M = 3.0
#: Of a block of the picture.
BLOCK = 8


@pytest.fixture
def osl(blender, petzval_cli, tmp_path):
    """Writes a script by the command line; needs a Blender whose cameras take one."""
    if blender.app.version < (4, 5, 0):
        pytest.skip("cameras of scripts came with Blender 4.5")

    def write(lens, *options, film="36x24"):
        out = tmp_path / f"{lens}.osl"
        done = petzval_cli("lens", "osl", lens, "--film", film, "--pixels", f"{W}x{H}", *options, "-o", out)
        assert done.returncode == 0, done.stderr
        return out

    return write


@pytest.fixture
def scene(blender):
    from support import beside_cycles, scenes

    made = scenes.set_up(W, H, model="LENS")
    beside_cycles.without_tricks(256)
    own = made.camera.data.petzval
    own.match_viewport, own.film_mode, own.film_width, own.film_height = False, "SIZE", *FILM
    own.spectrum = "SINGLE"
    # What a script of rays knows.
    scenes.straight(made)
    made.camera.data.dof.focus_distance = DEPTH_M
    return made


def by_cycles(scene, script, tmp_path, **parameters) -> np.ndarray:
    from support import scenes

    camera = scene.camera.data
    engine, scene.render.engine = scene.render.engine, "CYCLES"
    camera.type, camera.custom_mode, camera.custom_filepath = "CUSTOM", "EXTERNAL", str(script)
    for name in list(camera.cycles_custom.keys()):
        del camera.cycles_custom[name]
    for name, value in parameters.items():
        camera.cycles_custom[name] = value
    try:
        return scenes.render(tmp_path, "cycles.exr")[..., :3].copy()
    finally:
        scene.render.engine, camera.type = engine, "PERSP"


def by_petzval(scene, tmp_path) -> np.ndarray:
    from support import scenes

    return scenes.render(tmp_path, "petzval.exr")[..., :3].copy()


def means(picture) -> np.ndarray:
    return picture.reshape(H // BLOCK, BLOCK, W // BLOCK, BLOCK, -1).mean(axis=(1, 3))


def waves(scenes, depth: float, size: float, lines_per_m: float):
    """A wall with waves of light both ways, on a dark world."""
    made, tree, surface = scenes.material("Waves")
    nodes, links = tree.nodes, tree.links
    place, parts = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeSeparateXYZ")
    links.new(place.outputs["Position"], parts.inputs[0])
    total = None
    for axis in ("X", "Z"):
        wave = nodes.new("ShaderNodeMath")
        wave.operation = "MULTIPLY"
        wave.inputs[1].default_value = 2.0 * math.pi * lines_per_m
        links.new(parts.outputs[axis], wave.inputs[0])
        sine = nodes.new("ShaderNodeMath")
        sine.operation = "SINE"
        links.new(wave.outputs[0], sine.inputs[0])
        if total is None:
            total = sine.outputs[0]
        else:
            both = nodes.new("ShaderNodeMath")
            links.new(total, both.inputs[0])
            links.new(sine.outputs[0], both.inputs[1])
            total = both.outputs[0]
    scaled = nodes.new("ShaderNodeMath")
    scaled.operation = "MULTIPLY_ADD"
    scaled.inputs[1].default_value, scaled.inputs[2].default_value = 0.2, 0.5
    links.new(total, scaled.inputs[0])
    glow = nodes.new("ShaderNodeEmission")
    links.new(scaled.outputs[0], glow.inputs["Strength"])
    links.new(glow.outputs[0], surface)
    return scenes.square("Wall", (0.0, depth, 0.0), size, made)


def places(scenes, depth: float):
    """A wall that shows its own coordinates, ten added."""
    made, tree, surface = scenes.material("Places")
    place = tree.nodes.new("ShaderNodeNewGeometry")
    raised = tree.nodes.new("ShaderNodeVectorMath")
    raised.inputs[1].default_value = (10.0, 10.0, 10.0)
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(place.outputs["Position"], raised.inputs[0])
    tree.links.new(raised.outputs[0], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], surface)
    return scenes.square("Wall", (0.0, depth, 0.0), 20.0, made)


@pytest.mark.first_only("lens", "f_number")
@pytest.mark.parametrize(
    ("lens", "f_number"),
    [("double-gauss-f2-tronnier", 2.0), ("phone-4.1-f1.8", 1.9), ("reflex-nikkor-500-f8", 8.5)],
)
def test_its_rays_are_those_of_the_lens(blender, osl, scene, tmp_path, lens, f_number):
    """Where each ray meets two walls says how it leaves; the engine's own trace takes it back to its point of the film."""
    from petzval.places import find_lens
    from support import scenes

    film = FILM if "phone" not in lens else (3.6, 2.4)
    script = osl(lens, "--f-number", f_number, "--spectrum", "587.5618", *(("--focal-length", "500") if "500" in lens else ()), film=f"{film[0]}x{film[1]}")  # fmt: skip
    scene.world = scenes.grey_world(0.0)
    scene.cycles.samples, scene.cycles.filter_width, scene.cycles.pixel_filter_type = 1, 0.01, "BLACKMAN_HARRIS"
    aim = (
        {"one_ray": 1, "pupil_x": 0.62, "pupil_y": 0.44}
        if "500" not in lens
        else {"one_ray": 1, "pupil_x": 0.9, "pupil_y": 0.5}
    )
    sizes = {"film_width": film[0], "film_height": film[1]}
    met = []
    for depth in (2.0, 8.0):
        wall = places(scenes, depth)
        met.append(by_cycles(scene, script, tmp_path, **aim, **sizes).reshape(-1, 3) - 10.0)
        blender.data.objects.remove(wall)
    is_lit = (met[0][:, 1] > 0.0) & (met[1][:, 1] > 0.0)
    assert is_lit.mean() > 0.5
    from petzval.description import LensSettings, focal_length

    settings = LensSettings(focal_length(500.0 if "500" in lens else None), f_number)

    native = _native.Lens(str(find_lens(lens)))
    info = json.loads(native.info_json(settings))
    # World (x right, y ahead, z up) in metres to lens space in mm; the camera stands at the entrance pupil.
    pupil_z = info["entrance_pupil"]["z_mm"]
    near, far = (np.stack([m[:, 0], m[:, 2], -m[:, 1]], axis=1) * 1000.0 + (0.0, 0.0, pupil_z) for m in met)
    direction = near - far
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    rays = [{"origin": o.tolist(), "direction": d.tolist(), "wavelength_nm": 587.5618} for o, d in zip(near[is_lit], direction[is_lit], strict=True)]  # fmt: skip
    back = json.loads(native.trace_json(json.dumps({"rays": rays}), settings))["rays"]
    passed = np.array([one["status"] == "ok" for one in back])
    assert passed.mean() > 0.98
    origin = np.array([one["origin"] for one in back if one["status"] == "ok"])
    out = np.array([one["direction"] for one in back if one["status"] == "ok"])
    on_film = origin + out * ((info["film_z_mm"] - origin[:, 2]) / out[:, 2])[:, None]
    rows, columns = np.divmod(np.flatnonzero(is_lit)[passed], W)
    wanted = np.stack([-((columns + 0.5) / W - 0.5) * film[0], -((rows + 0.5) / H - 0.5) * film[1]], axis=1)
    off_px = (on_film[:, :2] - wanted) * W / film[0]
    # Single precision of the walls' places, metres away: the longer the lens, the more of a pixel it is. What Cycles adds by its
    # filter, a hundredth of a pixel wide, is less.
    assert np.abs(off_px).max() < 3e-3, np.abs(off_px).max()
    assert np.abs(off_px.mean(axis=0)).max() < 3e-4


@pytest.mark.once
def test_a_white_world_is_as_bright(blender, osl, scene, tmp_path):
    """Vignetting and the sampling of the pupil, wide open and stopped down by the script's own parameter."""
    from support import scenes

    scene.world = scenes.grey_world(1.0)
    own = scene.camera.data.petzval
    own.lens_file = "double-gauss-f2-tronnier"
    script = osl(own.lens_file, "--focus-distance", "3000", "--spectrum", "587.5618")
    for f_number in (5.6, 1.0):
        own.wide_open, own.f_number = f_number == 1.0, f_number
        wanted = means(by_petzval(scene, tmp_path))
        found = means(by_cycles(scene, script, tmp_path, f_number=f_number))
        # 256 samples of 64 pixels leave a noise of 0.1 % of a block.
        assert np.abs(found / wanted - 1.0).max() < 0.006, f_number
    assert wanted.min() < 0.9 * wanted.max()


@pytest.mark.once
@pytest.mark.parametrize(
    ("lens", "options", "depth"),
    [
        (
            "double-gauss-f2-tronnier",
            {"f_number": 2.8, "blades": 6, "blade_curvature": 0.3, "blade_rotation": 0.2},
            3.0,
        ),
        ("double-gauss-f2-tronnier", {"tilt": 0.12, "shift_x": 3.0, "shift_y": -2.0, "f_number": 4.0}, 4.5),
        ("nikkor-z-24-70-f4", {"f_number": 5.6, "focal_mode": "LENGTH", "focal_length": 35.0}, 3.0),
    ],
)
def test_pictures_are_those_of_petzval(blender, osl, scene, tmp_path, lens, options, depth):
    """A wall of waves, sharp or not: the same means by block, so the same place, blur and brightness of all."""
    from support import scenes

    scene.world = scenes.grey_world(0.0)
    waves(scenes, depth, 8.0, 12.0 if lens.startswith("double") else 5.0)
    own = scene.camera.data.petzval
    own.lens_file, own.wide_open = lens, False
    for name, value in options.items():
        setattr(own, name, value)
    asked = ["--focus-distance", "3000", "--f-number", options["f_number"], "--spectrum", "587.5618"]
    asked += ["--focal-length", options["focal_length"]] if "focal_length" in options else []
    if "blades" in options:
        rotation = math.degrees(options["blade_rotation"])
        asked += ["--blades", options["blades"], "--blade-curvature", options["blade_curvature"], "--blade-rotation", rotation]  # fmt: skip
    if "tilt" in options:
        asked += ["--tilt", math.degrees(options["tilt"]), "--shift=3,-2"]
    script = osl(lens, *asked)
    wanted, found = by_petzval(scene, tmp_path), by_cycles(scene, script, tmp_path)
    # And by pixels: where a picture lies aside by a part of a pixel, waves of some ten pixels differ by more than noise.
    slope_y, slope_x = np.gradient(wanted[..., 1])
    slopes = np.stack([slope_x.ravel(), slope_y.ravel()], axis=1)
    aside, *_ = np.linalg.lstsq(slopes, (wanted - found)[..., 1].ravel(), rcond=None)
    assert np.abs(means(found) / means(wanted) - 1.0).max() < 0.02
    assert np.abs(aside).max() < 0.03


@pytest.mark.once
def test_focus_is_a_parameter(blender, osl, scene, tmp_path):
    from support import scenes

    scene.world = scenes.grey_world(0.0)
    waves(scenes, 1.5, 4.0, 24.0)
    own = scene.camera.data.petzval
    own.lens_file = "double-gauss-f2-tronnier"
    scene.camera.data.dof.focus_distance = 1.5
    script = osl(own.lens_file, "--spectrum", "587.5618")
    wanted = by_petzval(scene, tmp_path)
    found = by_cycles(scene, script, tmp_path, focus_distance=1.5)
    assert np.abs(means(found) / means(wanted) - 1.0).max() < 0.02
    assert found[..., 1].std() == pytest.approx(wanted[..., 1].std(), rel=0.03)
    # Where the script stands at infinity the waves are gone.
    assert by_cycles(scene, script, tmp_path)[..., 1].std() < 0.8 * wanted[..., 1].std()


@pytest.mark.once
def test_three_wavelengths_have_their_colours(blender, osl, scene, tmp_path):
    from support import scenes

    scene.world = scenes.grey_world(0.0)
    # An edge far off the axis: lateral colour.
    glow = scenes.emitter()
    scenes.square("Lamp", (0.6, DEPTH_M, 0.3), 0.4, glow)
    own = scene.camera.data.petzval
    own.lens_file, own.spectrum, own.wide_open, own.f_number = "biconvex-50mm", "THREE", False, 8.0
    # By itself the plan would leave out what is less than half a pixel.
    scene.petzval.effects.lateral_colour = scene.petzval.effects.axial_colour = "ON"
    script = osl(own.lens_file, "--focus-distance", "3000", "--f-number", "8")
    wanted, found = means(by_petzval(scene, tmp_path)), means(by_cycles(scene, script, tmp_path))
    lit = wanted.min(axis=-1) > 0.02
    assert lit.sum() > 4
    assert np.abs(found[lit] / wanted[lit] - 1.0).max() < 0.03
    apart = np.ptp(wanted, axis=-1)[lit].max()
    assert apart > 0.002
    assert np.abs((found - wanted)[lit]).max() < 0.02


@pytest.mark.once
def test_what_it_cannot_do_is_refused_by_name(petzval_cli, tmp_path):
    def write(lens, out="lens.osl", *options):
        return petzval_cli("lens", "osl", lens, "--film", "10x8", "--pixels", "96x64", *options, "-o", tmp_path / out)

    assert_complains(write("anamorphic-2x-double-gauss"), "surface", "cylinder or toroid")
    assert_complains(write("eye-liou-brennan"), "surface")
    assert_complains(write("biconvex-50mm", "lens.txt"), "its ending is not .osl")


def test_the_operator_writes_and_uses_it(blender, osl, scene, tmp_path):
    own = scene.camera.data.petzval
    own.lens_file = "biconvex-50mm"
    out = tmp_path / "mine.osl"
    assert blender.ops.petzval.export_osl(filepath=str(out), assign=True) == {"FINISHED"}
    assert scene.camera.data.type == "CUSTOM" and scene.camera.data.custom_filepath == str(out)
    assert "shader lens_camera" in out.read_text()
    own.lens_file = "anamorphic-2x-double-gauss"
    with pytest.raises(RuntimeError, match="cylinder or toroid"):
        blender.ops.petzval.export_osl(filepath=str(out))
