# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render --sensor`, and its raw files beside the picture."""

from __future__ import annotations

import json

import numpy as np
import pytest

from support.raw_files import read_png
from support.render_commands import one_line, picture

SIZE = ("--resolution", "48x32", "--samples", 16, "--pipeline", "film")


def test_raw_files_are_those_of_the_picture(cli_renders, petzval_cli, tmp_path):
    """A raw file beside a render is, to the byte, what `petzval sensor expose` makes of the picture; of two frames each has its own noise."""
    raw, numbered = tmp_path / "raw.dng", tmp_path / "numbered_##.png"
    lens = (
        "--lens",
        "tessar-brendel",
        "--f-number",
        8,
        "--iso",
        400,
        "--shutter",
        0.002,
        "--sensor",
        "sony-a7r2",
        *SIZE,
    )
    one, both = cli_renders((*lens, "--raw", raw), (*lens, "--raw", numbered, "--frames", "1-2"))
    assert one.returncode == both.returncode == 0, one.stderr + both.stderr
    again = tmp_path / "again.dng"
    same = ("--iso", 400, "--shutter", 0.002, "--f-number", 8, "--noise-frame", 1, "--sensor", "sony-a7r2")
    # Blender keeps the camera's numbers in single precision.
    shutter = float(np.float32(0.002))
    same = [shutter if value == 0.002 else value for value in same]
    done = petzval_cli("sensor", "expose", one.out, *same, "-o", again)
    assert done.returncode == 0, done.stderr
    assert again.read_bytes() == raw.read_bytes()
    first, second = (read_png(tmp_path / f"numbered_0{frame}.png") for frame in (1, 2))
    assert (first != second).mean() > 0.5


def test_a_sensor_sees_colours_as_they_are(cli_renders):
    """Without a lens, or through one that parts no wavelengths, a sensor changes no pixel. Through glass it changes edges, where colours part, and
    leaves the picture's mean: white is white."""
    by_glass = (
        "--lens",
        "biconvex-50mm",
        "--f-number",
        8,
        "--effect",
        "lateral_colour=on",
        "--effect",
        "axial_colour=on",
        *SIZE,
    )
    plain, sensor, glass, seen = cli_renders(
        *(("--camera", "pinhole", *more, *SIZE) for more in ((), ("--sensor", "nikon-d700"))),
        *((*by_glass, *more) for more in ((), ("--sensor", "nikon-d700"))),
    )
    for one in (plain, sensor, glass, seen):
        assert one.returncode == 0, one.stderr
    assert (picture(plain.out) == picture(sensor.out)).all()
    without, through = picture(glass.out)[..., :3], picture(seen.out)[..., :3]
    assert (without != through).any()
    # The same rays of the same seed; wavelengths are chosen with other chances, so that both have noise of their own.
    assert through.mean(axis=(0, 1)) == pytest.approx(without.mean(axis=(0, 1)), rel=0.03)


def test_what_is_no_sensor(cli_renders, tmp_path):
    """Refused before the render, in one line; no picture is written."""
    bad = tmp_path / "bad.json"
    bad.write_text("{")
    raw = tmp_path / "raw.dng"
    asked = [
        (("--sensor", "box-brownie"), "no such sensor: box-brownie"),
        (("--sensor", bad), "bad.json: EOF"),
        (("--raw", raw), "name one with --sensor"),
        (("--sensor", "sony-a7r2", "--raw", tmp_path / "raw.tif"), "unknown raw format"),
        (("--sensor", "sony-a7r2", "--raw", tmp_path / "none" / "raw.dng"), "no such folder"),
    ]
    for done, (_, words) in zip(cli_renders(*((*one, *SIZE) for one, _ in asked)), asked, strict=True):
        assert done.returncode in (1, 2)
        assert words in one_line(done)
        assert not done.out.exists()
    assert not raw.exists()


def test_a_full_disk_keeps_the_picture(blender, parts, tmp_path, monkeypatch):
    """A raw file that cannot be written is said, and the picture stays."""
    scene = parts.set_up(24, 16, 2)
    own = scene.camera.data.petzval
    own.use_sensor, own.raw_file = True, str(tmp_path / "raw.dng")
    writer = parts.part("render.raw").engine()

    def full(*_):
        raise writer.PetzvalError("raw.dng: cannot be written: no space left")

    monkeypatch.setattr(writer, "expose_pixels_json", full)
    pixels = parts.render(tmp_path)
    assert pixels.shape[:2] == (16, 24)
    assert "no space left" in parts.part("render.loop").WATCH.raw_problem


def test_the_plan_says_whether_noise_shows(cli_scenes, petzval_cli):
    """The row's measure is the noise of a grey card, by the numbers of `petzval sensor info`; at a high speed it is above its tolerance, and no word
    takes it out."""
    scene = cli_scenes / "scene.blend"
    lens = ("--lens", "tessar-brendel", "--resolution", "48x32", "--json")

    def row(*more):
        done = petzval_cli("plan", scene, *lens, *more)
        assert done.returncode == 0, done.stderr
        return next(one for one in json.loads(done.stdout)["effects"] if one["effect"] == "sensor")

    off = row()
    assert (off["measure"], off["decision"]) == (0.0, "off")
    for iso, shows in ((100.0, False), (1600.0, True)):
        found = row("--sensor", "sony-a7r2", "--iso", iso)
        info = json.loads(petzval_cli("sensor", "info", "sony-a7r2", "--iso", iso, "--json").stdout)
        white = np.array(info["white_e_per_lx_s"]) * 78.0 / iso
        noise = (np.sqrt(0.18 * white + info["read_noise_e"] ** 2) / white).max()
        assert found["measure"] == pytest.approx(noise, rel=1e-6)
        assert found["decision"] == "on"
        assert (found["measure"] > found["tolerance"]) == shows
    done = petzval_cli("plan", scene, *lens, "--effect", "sensor=on")
    assert done.returncode == 1
    assert "sensor" in one_line(done)
