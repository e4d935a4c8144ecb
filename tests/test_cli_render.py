# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`, driven as a user would: options, pictures, statistics, errors, Ctrl-C."""

from __future__ import annotations

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

MAKE = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
import scene_parts as parts
scene = parts.set_up(48, 32, 4)
parts.square("Square", (0.1, 5, 0.2), 0.6, parts.emitter((1.0, 0.5, 0.2), 2.0))
for frame, x in ((1, 0.1), (2, 0.9)):
    bpy.data.objects["Square"].location.x = x
    bpy.data.objects["Square"].keyframe_insert("location", frame=frame)
# A picture that is not Petzval's to make, and a text that must never run.
scene.render.engine = "CYCLES"
text = bpy.data.texts.new("startup.py")
text.write("open({ran!r}, 'w').write('ran')")
text.use_module = True
driver = scene.camera.data.driver_add("clip_end").driver
driver.type = "SCRIPTED"
driver.expression = "open({ran!r}, 'w').write('ran') and 100.0"
bpy.ops.wm.save_as_mainfile(filepath={path!r})
scene.camera = None
bpy.ops.wm.save_as_mainfile(filepath={no_camera!r})
sys.stdout.flush()
os._exit(0)
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder with scene.blend and no-camera.blend; a script in it would write `ran`."""
    pytest.importorskip("bpy")
    folder = tmp_path_factory.mktemp("cli-render")
    script = MAKE.format(
        tests=str(ROOT / "tests"), path=str(folder / "scene.blend"), no_camera=str(folder / "no-camera.blend"),
        ran=str(folder / "ran"),
    )  # fmt: skip
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert (folder / "no-camera.blend").exists(), done.stdout + done.stderr
    (folder / "ran").unlink(missing_ok=True)
    return folder


@pytest.fixture
def render(petzval_cli, made, tmp_path):
    """`render(options...)` into out.exr: (finished process, picture, statistics)."""

    def run(*options, name: str = "out.exr", scene: str = "scene.blend"):
        out, stats = tmp_path / name, tmp_path / f"{name}.json"
        done = petzval_cli("render", made / scene, *options, "-o", out, "--stats", stats)
        return done, out, json.loads(stats.read_text()) if stats.exists() else None

    return run


def picture(path: Path):
    import bpy  # noqa: F401

    sys.path.insert(0, str(ROOT / "tests"))
    import scene_parts

    return scene_parts.read(path)


def test_statistics_as_promised(render):
    done, out, stats = render("--camera", "pinhole", "--samples", 3, "--seed", 5, "--threads", 1)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert out.exists()
    number = (int, float)
    wanted = {
        "samples": int, "camera_rays": int, "camera_rays_lost": int, "rays": int, "peak_memory_mb": number,
        "plan": list, "seed": int, "threads": int, "non_finite_samples": int,
    }  # fmt: skip
    for key, kind in wanted.items():
        assert isinstance(stats[key], kind) and not isinstance(stats[key], bool), key
    assert set(stats["seconds"]) >= {"sync", "bvh", "plan", "render"}
    assert all(isinstance(value, number) and value >= 0.0 for value in stats["seconds"].values())
    assert (stats["samples"], stats["seed"], stats["threads"]) == (3, 5, 1)
    assert stats["camera_rays"] == 3 * 48 * 32 and stats["camera_rays_lost"] == 0
    assert stats["rays"] >= stats["camera_rays"]
    assert stats["non_finite_samples"] == 0
    assert 50.0 < stats["peak_memory_mb"] < 5000.0


@pytest.mark.parametrize("model", ["thick", "paraxial"])
def test_a_lens_to_first_order(render, model):
    """Nothing is lost in it, and far from the corners its picture is the lens's own, aberrations apart."""
    lens = ("--lens", "tessar-brendel", "--film", "6x4", "--f-number", 8, "--samples", 64)
    done, out, stats = render(*lens, "--camera", model)
    assert done.returncode == 0, done.stderr
    assert stats["camera_rays_lost"] == 0 and stats["lens"]
    done, exact, _ = render(*lens, name="exact.exr")
    assert done.returncode == 0, done.stderr
    first_order, exact = picture(out)[..., :3], picture(exact)[..., :3]
    # Noise alone: 64 samples of 48 x 32 pixels.
    assert abs(first_order.mean() / exact.mean() - 1.0) < 0.02


def test_a_lens_as_a_table(render):
    """Sample by sample the picture of the lens itself, at the table's wavelength."""
    lens = (
        "--lens",
        "tessar-brendel",
        "--film",
        "60x40",
        "--tilt",
        3,
        "--samples",
        16,
        "--effect",
        "lateral_colour=off",
    )
    done, out, stats = render(*lens, "--camera", "image-based")
    assert done.returncode == 0, done.stderr
    assert stats["lens"]
    done, exact, of_lens = render(*lens, name="exact.exr")
    assert done.returncode == 0, done.stderr
    table, exact = picture(out)[..., :3], picture(exact)[..., :3]
    # The same random numbers, rays within hundredths of a pixel: only where one meets an edge a path may part.
    assert abs(table.mean() / exact.mean() - 1.0) < 2e-3
    assert (abs(table - exact) < 0.02 * exact.max()).mean() > 0.99
    assert abs(stats["camera_rays_lost"] - of_lens["camera_rays_lost"]) < 1e-3 * stats["camera_rays"]


@pytest.mark.once
def test_light_paths(blender, render):
    lens = ("--lens", "cooke-triplet-50mm", "--samples", 64)
    done, one, stats = render(*lens)
    assert done.returncode == 0 and stats["integrator"] == "path"
    done, two, stats = render(*lens, "--integrator", "bdpt", name="both.exr")
    assert done.returncode == 0 and stats["integrator"] == "bdpt"
    # Two ways to one picture: means of thousands of pixels, with the noise of a few hundredths in each.
    assert picture(two)[..., :3].mean() == pytest.approx(picture(one)[..., :3].mean(), rel=0.02)


def test_scripts_in_a_file_never_run(render, made):
    done, _, _ = render("--camera", "pinhole", "--samples", 1)
    assert done.returncode == 0, done.stderr
    assert not (made / "ran").exists()


def test_formats(blender, render):
    for name in ("a.exr", "a.png", "A.PNG"):
        done, out, _ = render("--camera", "pinhole", "--resolution", "40x20", name=name)
        assert done.returncode == 0, done.stderr
        assert picture(out).shape[:2] == (20, 40)
    assert out.read_bytes()[:4] == b"\x89PNG"


def test_the_frame(blender, render):
    first, second = (picture(render("--camera", "pinhole", "--frame", frame)[1]) for frame in (1, 2))
    assert first[..., 0].argmax(axis=1).max() < second[..., 0].argmax(axis=1).max()


@pytest.mark.once
def test_seed_and_offset(blender, render):
    options = ("--lens", "cooke-triplet-50mm", "--samples", 2)
    same = [picture(render(*options, "--seed", 3)[1]) for _ in range(2)]
    assert (same[0] == same[1]).all()
    assert (same[0] != picture(render(*options, "--seed", 4)[1])).any()
    # Two halves make the whole.
    halves = [picture(render(*options, "--seed", 3, "--sample-offset", offset)[1]) for offset in (0, 2)]
    whole = picture(render("--lens", "cooke-triplet-50mm", "--samples", 4, "--seed", 3)[1])
    assert abs((halves[0] + halves[1]) / 2 - whole).max() < 1e-4 * max(whole.max(), 1.0)


CHANGES = {
    "focal length": ("--focal-length", 30),
    "f-number": ("--f-number", 16),
    "focus": ("--focus-distance", 700),
    "infinity": ("--focus-distance", "inf"),
    "film": ("--film", "24x16"),
    "film format": ("--film", "aps-c"),
    "film diagonal": ("--film-diagonal", 30),
    "blades": ("--f-number", 8, "--blades", 3, "--blade-curvature", 0.5, "--blade-rotation", 20),
    "tilt": ("--tilt", 12),
    "swing": ("--swing", -12),
    "shift": ("--shift", "2,-3"),
    "scale": ("--scale", "100,100,100"),
    "one wavelength": ("--effect", "lateral_colour=off", "--effect", "axial_colour=off"),
    "another lens": ("--lens", "tessar-brendel"),
    "pinhole": ("--camera", "pinhole"),
    "thin": ("--camera", "thin", "--f-number", 0.1),
}


@pytest.fixture
def plain(blender, render):
    """What the changes are seen against."""
    return picture(render("--lens", "cooke-triplet-50mm", "--samples", 2, name="plain.exr")[1])


@pytest.mark.once
@pytest.mark.slow
def test_options_reach_the_lens(plain, render):
    for what, options in CHANGES.items():
        lens = () if {"--lens", "--camera"} & set(options) else ("--lens", "cooke-triplet-50mm")
        done, out, stats = render(*lens, *options, "--samples", 2)
        assert done.returncode == 0, f"{what}: {done.stderr}"
        assert abs(picture(out) - plain).mean() > 1e-4, what
        assert stats["non_finite_samples"] == 0


def test_a_mask_from_a_file_shapes_the_blur(blender, render, plain, tmp_path):
    masks = {}
    for name, column in (("left", 0), ("right", 1), ("open", None)):
        image = blender.data.images.new(name, 2, 2)
        pixels = [[float(column in (None, i % 2))] * 3 + [1.0] for i in range(4)]
        image.pixels.foreach_set([number for pixel in pixels for number in pixel])
        image.filepath_raw, image.file_format = str(tmp_path / f"{name}.png"), "PNG"
        image.save()
        done, out, _ = render(
            "--lens", "cooke-triplet-50mm", "--focus-distance", 600, "--samples", 64, "--aperture-mask",
            tmp_path / f"{name}.png", name=f"{name}.exr",
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        masks[name] = picture(out)[..., 0]

    def middle(found):
        return (found.sum(axis=0) * range(found.shape[1])).sum() / found.sum()

    # The square lies behind what is sharp: seen from further right it stands further right against it. The two halves
    # are as bright as the whole, which is their mean.
    assert middle(masks["right"]) - middle(masks["left"]) > 0.5
    mean = (masks["left"] + masks["right"]) / 2
    assert abs(mean - masks["open"]).mean() < 0.05 * masks["open"].mean()
    # From the scene the entrance pupil is aimed at, and the mask met on the way back.
    for pipeline in ("film", "scene", "hero"):
        done, out, _ = render(
            "--lens", "cooke-triplet-50mm", "--focus-distance", 600, "--samples", 64, "--aperture-mask",
            tmp_path / "right.png", "--pipeline", pipeline, name=f"{pipeline}.exr",
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        found = picture(out)[..., 0]
        assert found.sum() == pytest.approx(masks["right"].sum(), rel=0.02), pipeline
        assert middle(found) == pytest.approx(middle(masks["right"]), abs=0.2), pipeline


def test_a_mask_that_is_no_picture_is_said(made, petzval_cli, tmp_path):
    (tmp_path / "text.png").write_text("this is no picture")
    done = petzval_cli("render", made / "scene.blend", "--camera", "thin", "--aperture-mask", tmp_path / "text.png",
                       "-o", tmp_path / "out.exr")  # fmt: skip
    assert done.returncode == 1
    assert "text.png" in one_line(done)


def test_without_lens_or_camera_the_file_decides(blender, render):
    # The scene was saved with a pinhole.
    done, _, stats = render("--samples", 1)
    assert done.returncode == 0 and stats["lens"] == "pinhole"


@pytest.mark.once
def test_the_default_output(petzval_cli, made, tmp_path):
    command = [sys.executable, "-m", "petzval", "render", str(made / "scene.blend"), "--samples", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scene.png").exists()


BAD_USAGE = {
    "no scene": [],
    "both": ["S", "--lens", "cooke-triplet-50mm", "--camera", "pinhole"],
    "unknown option": ["S", "--colour", "red"],
    "not a number": ["S", "--f-number", "wide"],
    "nan": ["S", "--focal-length", "nan"],
    "negative": ["S", "--focal-length", "-50"],
    "zero samples": ["S", "--samples", "0"],
    "huge samples": ["S", "--samples", "99999999999999"],
    "size": ["S", "--resolution", "100"],
    "film": ["S", "--film", "no-such-film"],
    "pair": ["S", "--shift", "1,2,3"],
    "effect": ["S", "--effect", "rainbows=on"],
    "effect word": ["S", "--effect", "ghosts=maybe"],
    "camera": ["S", "--camera", "camera-obscura"],
    "pipeline": ["S", "--pipeline", "oil"],
    "integrator": ["S", "--integrator", "photon"],
    "frame": ["S", "--frame", "first"],
}


@pytest.mark.once
@pytest.mark.parametrize("case", BAD_USAGE)
def test_bad_usage(petzval_cli, made, case):
    done = petzval_cli("render", *(made / "scene.blend" if word == "S" else word for word in BAD_USAGE[case]))
    assert done.returncode == 2, done.stderr
    assert one_line(done)


def one_line(done) -> str:
    assert done.stderr.startswith("petzval: ") and done.stderr.count("\n") == 1, done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr


ERRORS = {
    "no such scene": (["nowhere.blend"], "nowhere.blend"),
    "no such lens": (["S", "--lens", "no-such"], "no such lens: no-such"),
    "a folder": (["S", "-o", "no/such/folder/a.png"], "no such folder"),
    "a format": (["S", "-o", "a.jpg"], ".exr or .png"),
    "blades": (["S", "--blades", "2"], "2 blades"),
    "light paths without a lens": (["S", "--camera", "pinhole", "--integrator", "bdpt"], "choose the lens as camera"),
    "stretched axes": (
        ["S", "--lens", "cooke-triplet-50mm", "--scale", "1000,1000,2000", "--integrator", "bdpt"],
        "one scale for all three axes",
    ),
    "no such Blender": (["S", "--blender", "no-such-blender"], "no-such-blender"),
    "a Blender that is none": (["S", "--blender", "/bin/false"], "/bin/false"),
    "one that does nothing": (["S", "--blender", "/bin/true"], "/bin/true"),
    "effect": (["S", "--lens", "cooke-triplet-50mm", "--effect", "ghosts=on"], "ghosts=on"),
    "no camera": (["N", "--camera", "pinhole"], "no camera"),
    "no blend": (["T"], "cannot open"),
}


@pytest.mark.parametrize("case", ERRORS)
def test_errors(petzval_cli, made, tmp_path, case):
    words, wanted = ERRORS[case]
    (tmp_path / "text.blend").write_text("this is no scene")
    names = {"S": made / "scene.blend", "N": made / "no-camera.blend", "T": tmp_path / "text.blend"}
    output = [] if "-o" in words else ["-o", tmp_path / "out.png"]
    done = petzval_cli("render", *(names.get(word, word) for word in words), *output)
    assert done.returncode == 1, done.stderr
    assert wanted in one_line(done)


def test_a_broken_lens_names_file_line_and_column(petzval_cli, made, tmp_path):
    lens = tmp_path / "broken.lens"
    lens.write_text("#radius thickness glass diameter conic isstop\n50 5 BK7 20 0 0\n-50 x air 20 0 1\n")
    done = petzval_cli("render", made / "scene.blend", "--lens", lens, "-o", tmp_path / "a.png")
    assert done.returncode == 1
    assert f"{lens}:3:" in one_line(done)


@pytest.mark.once
def test_a_picture_that_cannot_be_written(petzval_cli, made):
    done = petzval_cli("render", made / "scene.blend", "--samples", 1, "-o", "/proc/out.png")
    assert done.returncode == 1
    assert "/proc/out.png" in one_line(done)


def start_long(scene: Path, folder: Path, *more, **how) -> subprocess.Popen:
    """A render that takes for ever."""
    return subprocess.Popen(
        [
            sys.executable, "-m", "petzval", "render", str(scene), "--lens", "cooke-triplet-50mm",
            "--samples", "1000000", "--resolution", "200x150", "-o", str(folder / "out.exr"),
            "--stats", str(folder / "stats.json"), *map(str, more),
        ],
        cwd=ROOT, **how,
    )  # fmt: skip


def interrupted_well(folder: Path) -> None:
    stats = json.loads((folder / "stats.json").read_text())
    assert stats["interrupted"] is True
    assert 1 <= stats["samples"] < 1_000_000
    kept = picture(folder / "out.exr")
    assert kept.shape[:2] == (150, 200)
    assert kept[..., :3].mean() > 0.05


def wait_for_samples(stream: int, seconds: float = 60.0) -> bytes:
    """What was said until some samples were done; not every number is told."""
    seen, ends = b"", time.monotonic() + seconds
    while not re.search(rb"Sample [1-9]\d*/", seen):
        assert time.monotonic() < ends, seen
        if select.select([stream], [], [], 0.2)[0]:
            seen += os.read(stream, 4096)
    return seen


def test_ctrl_c_keeps_the_picture(blender, made, tmp_path):
    """On a terminal, with its progress bar."""
    master, slave = pty.openpty()
    process = start_long(made / "scene.blend", tmp_path, stdin=slave, stdout=subprocess.DEVNULL, stderr=slave)
    os.close(slave)
    try:
        # The whole bar, some way on.
        seen = wait_for_samples(master)
        assert re.search(rb"\[[#.]{30}\] +\d+%  Sample \d+/1000000", seen), seen
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        # A terminal that nobody reads fills up.
        while process.poll() is None:
            assert time.monotonic() - began < 20.0
            if select.select([master], [], [], 0.1)[0]:
                try:
                    seen += os.read(master, 4096)
                except OSError:
                    break
        assert process.wait(20) == 130
    finally:
        process.kill()
        os.close(master)
    assert b"Traceback" not in seen
    interrupted_well(tmp_path)


@pytest.fixture(scope="module")
def old_scene(run_blender, made) -> Path:
    """Made by the real Blender, which may be older than bpy: its start-up scene."""
    path = made / "old.blend"
    keep = f"import bpy; bpy.ops.wm.save_as_mainfile(filepath={str(path)!r})"
    done = run_blender("-b", "--factory-startup", "--python-expr", keep)
    assert path.exists(), done.stdout
    return path


@pytest.mark.real_blender
@pytest.mark.once
def test_the_real_blender_renders_the_same(blender, old_scene, render):
    options = ("--camera", "pinhole", "--samples", 4, "--resolution", "48x32")
    done, out, stats = render(*options, name="bpy.exr", scene="old.blend")
    assert done.returncode == 0, done.stderr
    again, real, real_stats = render(*options, "--blender", ROOT / "tools/blender", name="real.exr", scene="old.blend")
    assert again.returncode == 0, again.stderr
    assert again.stderr == ""
    assert stats["camera_rays"] == real_stats["camera_rays"]
    assert (picture(out) == picture(real)).all()


@pytest.mark.real_blender
@pytest.mark.once
def test_errors_in_the_real_blender(run_blender, petzval_cli, made, tmp_path):
    done = petzval_cli(
        "render", made / "no-camera.blend", "--camera", "pinhole", "--blender", ROOT / "tools/blender",
        "-o", tmp_path / "a.png",
    )  # fmt: skip
    assert done.returncode == 1
    assert "no camera" in one_line(done) or "cannot open" in one_line(done)


@pytest.mark.real_blender
@pytest.mark.once
def test_ctrl_c_in_the_real_blender(blender, old_scene, tmp_path):
    process = start_long(
        old_scene, tmp_path, "--blender", ROOT / "tools/blender",
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        wait_for_samples(process.stdout.fileno())
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
        assert process.returncode == 130, err
        assert err == b""
    finally:
        process.kill()
    interrupted_well(tmp_path)
