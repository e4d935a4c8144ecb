# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes wrong on a farm: the merged picture is right, or a line says which part is to be rendered again. No file of a job leads out of its
folder."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
import tomllib
import zlib

import pytest

from support.command_line import assert_complains
from support.exr_bytes import assert_same_picture
from support.places import ROOT

pytestmark = pytest.mark.once

FILM = "parts/0001.film"
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"].encode()


def with_header(film: bytes, change) -> bytes:
    """A film whose header is another one, with the checksum that fits."""
    length = int.from_bytes(film[16:20], "little")
    header = change(film[20 : 20 + length])
    assert header != film[20 : 20 + length]
    begin = film[:16] + len(header).to_bytes(4, "little") + header
    return begin + zlib.crc32(header).to_bytes(4, "little") + film[24 + length :]


def flipped(film: bytes) -> bytes:
    middle = len(film) // 2
    return film[:middle] + bytes([film[middle] ^ 4]) + film[middle + 1 :]


#: What is done to the film of part 1, and what the merge says of it.
DAMAGES = {
    "truncated": (lambda job, film: film[:-1000], ""),
    "a bit": (lambda job, film: flipped(film), "it is damaged"),
    "empty": (lambda job, film: b"", ""),
    "no film": (lambda job, film: b"x" * len(film), "it is no checkpoint"),
    "another part": (lambda job, film: (job / "parts/0002.film").read_bytes(), "it is of another part of the picture"),
    "another picture": (lambda job, film: with_header(film, lambda h: h.replace(h[-20:-12], b"01234567")), "another picture"),
    "another version": (lambda job, film: with_header(film, lambda h: h.replace(VERSION, b"0.0.9")), "another version"),
    "an older layout": (lambda job, film: film[:15] + b"4" + film[16:], "another version of Petzval"),
    "unfinished": (lambda job, film: with_header(film, lambda h: h[:-1] + b"\0"), "it is not finished"),
}  # fmt: skip


def test_a_bad_part_is_named_and_rendered_again(finished_job, tmp_path, commands):
    """Each kind of damage in a copy of a job of its own, where the marker of the part believes in the file."""
    jobs, several = {}, []
    for number, (name, (damage, _)) in enumerate(DAMAGES.items()):
        jobs[name] = job = tmp_path / f"job{number}"
        shutil.copytree(finished_job[0], job)
        film = job / FILM
        film.write_bytes(damage(job, film.read_bytes()))
        marker = job / "parts/0001.json"
        if name not in ("truncated", "empty"):
            told = json.loads(marker.read_text())
            told["films"] = {film.name: film.stat().st_size}
            marker.write_text(json.dumps(told))
        several += [["farm", "merge", job], ["farm", "part", job, "1"], ["farm", "merge", job]]
    done = iter(commands(*several))
    for name, job in jobs.items():
        first, part, second = next(done), next(done), next(done)
        said = DAMAGES[name][1]
        assert first.returncode == 75, (name, first.stderr)
        assert f"petzval farm part {job} 1" in first.stderr and said in first.stderr, (name, first.stderr)
        assert (part.returncode, second.returncode) == (0, 0), (name, part.stderr, second.stderr)
        assert_same_picture(job / "pictures/small.exr", finished_job[1])


def change_job(job, change) -> None:
    told = json.loads((job / "job.json").read_text())
    change(told)
    (job / "job.json").write_text(json.dumps(told))


#: Changes of job.json, and words of what every command says then.
CHANGES = {
    "no job": (lambda told: told.update(format="something"), "plan it again"),
    "up and out": (lambda told: told.update(scene="../scene.blend"), "no path inside of the job's folder"),
    "absolute": (lambda told: told.update(scene="/etc/passwd"), "no path inside of the job's folder"),
    "a file outside": (lambda told: told["files"].update({"scene/../../x": [1, "0"]}), "no path inside of the job's folder"),
    "a lens outside": (lambda told: told["options"].update(lens="/etc/passwd"), "lens is not among the files"),
    "a picture elsewhere": (lambda told: told.update(picture="../../x.exr"), "no name of a file"),
    "an option of the machine": (lambda told: told["options"].update(blender="/bin/sh"), "unknown options"),
    "an option that writes": (lambda told: told["options"].update(stats="/tmp/x"), "unknown options"),
    "a value that is none": (lambda told: told["options"].update(samples={"a": 1}), "no option's value"),
    "a part too few": (lambda told: told["parts"].pop(), "do not make a whole"),
    "a part twice": (lambda told: told["parts"].append(told["parts"][0]), "do not make a whole"),
    "parts without end": (lambda told: told["parts"][0].update(end=1 << 70), "not of the slots"),
    "a negative part": (lambda told: told["parts"][0].update(first=-1), "no natural number"),
    "another version": (lambda told: told.update(engine="0.0.9"), "install that version here"),
    "another system": (lambda told: told.update(system="plan9"), "planned on plan9"),
    "another processor": (lambda told: told.update(processor="x86-64-v9"), "leave it to other machines"),
    "a changed file": (lambda told: told["files"]["scene/shots/scene/small.blend"].__setitem__(1, "0" * 40), "copy the job's folder again"),
    "a short file": (lambda told: told["files"]["scene/shots/scene/small.blend"].__setitem__(0, 5), "copy the job's folder again"),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_a_job_that_was_tampered_with_is_refused(name, job, monkeypatch, capsys):
    from petzval import cli

    change, said = CHANGES[name]
    change_job(job, change)
    (job / "parts/0001.json").unlink()
    for words in (["part", str(job), "1"], ["merge", str(job)]):
        assert cli.run_command(["farm", *words]) == 1
        assert said in capsys.readouterr().err, words
    assert not (job / "pictures/small.exr").exists() and not (job / "parts/0001.json").exists()


def test_a_link_out_of_the_folder_is_refused(job, tmp_path, capsys):
    from petzval import cli

    file = job / "scene/shots/scene/small.blend"
    shutil.move(file, tmp_path / "small.blend")
    file.symlink_to(tmp_path / "small.blend")
    assert cli.run_command(["farm", "merge", str(job)]) == 1
    assert "leads out of the job's folder" in capsys.readouterr().err


def test_another_blender_is_refused(job, petzval_cli):
    change_job(job, lambda told: told.update(blender="4.0.0"))
    done = petzval_cli("farm", "part", job, "1", "--again")
    assert done.returncode == 1 and "planned with Blender 4.0.0" in done.stderr


def test_bad_usage(job, farm_scenes_folder, petzval_cli, commands):
    assert_complains(petzval_cli("farm", "part", job, "3"), "there is no part 3")
    assert_complains(petzval_cli("farm", "merge", job.parent), "no job in")
    assert_complains(petzval_cli("farm", "plan", farm_scenes_folder / "small.blend", "-o", job), "not empty")
    assert_complains(petzval_cli("farm", "run", job), "bad usage", status=2)
    scene, new = farm_scenes_folder / "small.blend", job.parent / "new"
    (done,) = commands(["farm", "plan", scene, "--noise-threshold", "0.05", "--denoise", "fast", "-o", new])
    assert done.returncode == 1 and "looks at the whole picture" in done.stderr and not new.exists()


def start(*words, **more) -> subprocess.Popen:
    command = [sys.executable, "-m", "petzval", "farm", *map(str, words)]
    return subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more
    )


def full(most_bytes: int):
    """A limit on the size of files stands for a full disk."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    return limit


def test_a_full_disk_is_tried_again(job, petzval_cli, finished_job):
    for file in (job / "parts").glob("0001.*"):
        file.unlink()
    part = start("part", job, "1", preexec_fn=full(4_000))
    _, said = part.communicate(timeout=120)
    assert part.returncode == 75 and "cannot write" in said and FILM in said, said
    assert not [file for file in (job / "parts").iterdir() if file.name.startswith(("0001", "."))]
    assert petzval_cli("farm", "part", job, "1").returncode == 0
    assert (job / FILM).read_bytes()[-4:] != b""


def test_a_full_disk_leaves_the_picture_before(job, petzval_cli, finished_job):
    picture = job / "pictures/small.exr"
    picture.parent.mkdir(exist_ok=True)
    picture.write_bytes(b"the one before")
    merge = start("merge", job, "--again", preexec_fn=full(4_000))
    _, said = merge.communicate(timeout=120)
    assert merge.returncode == 1 and "cannot write" in said and picture.name in said, said
    assert picture.read_bytes() == b"the one before" and [one.name for one in picture.parent.iterdir()] == [
        picture.name
    ]
    assert len(list((job / "parts").glob("*.json"))) == 3
    assert petzval_cli("farm", "merge", job).returncode == 0
    assert_same_picture(picture, finished_job[1])


def test_a_full_disk_leaves_no_job(farm_scenes_folder, tmp_path):
    new = tmp_path / "new"
    plan = start("plan", farm_scenes_folder / "small.blend", "-o", new, preexec_fn=full(10_000))
    _, said = plan.communicate(timeout=120)
    assert plan.returncode == 1 and "cannot pack" in said and not new.exists(), said


def test_a_full_disk_leaves_no_job_of_half_a_scene(farm_scenes_folder, tmp_path):
    """A disk with room for all but the end of the .blend itself, which Blender saves compressed and says nothing of."""
    new, scene = tmp_path / "new", farm_scenes_folder / "small.blend"
    room = (farm_scenes_folder / "../../library/things.blend").stat().st_size + 100
    assert room < scene.stat().st_size
    plan = start("plan", scene, "-o", new, preexec_fn=full(room))
    _, said = plan.communicate(timeout=120)
    assert plan.returncode == 1 and "cannot pack" in said and scene.name in said and not new.exists(), said


def test_a_wrong_clock_changes_nothing(job, finished_job, petzval_cli):
    """Machines whose clocks are decades off: a part that seems older than the picture is joined all the same, and is not joined twice."""
    marker, picture = job / "parts/0001.json", job / "pictures/small.exr"
    told = marker.read_bytes()
    marker.unlink()
    for number, file in enumerate(sorted(file for file in job.rglob("*") if file.is_file())):
        os.utime(file, (moment := 4e9 * (number % 2), moment))
    assert petzval_cli("farm", "merge", job).returncode == 75
    marker.write_bytes(told)
    os.utime(marker, (1.0, 1.0))
    assert petzval_cli("farm", "merge", job).returncode == 0
    assert_same_picture(picture, finished_job[1])
    before = picture.stat().st_mtime_ns
    assert petzval_cli("farm", "merge", job).returncode == 0 and picture.stat().st_mtime_ns == before


def test_a_slow_folder_shows_a_film_after_its_marker(job, finished_job, petzval_cli):
    film, away = job / FILM, job.parent / "not seen yet"
    whole = film.read_bytes()
    for there in (None, whole[: len(whole) // 2]):
        film.rename(away)
        if there is not None:
            film.write_bytes(there)
        done = petzval_cli("farm", "status", job)
        assert done.returncode == 75 and f"petzval farm part {job} 1" in done.stderr, done.stderr
        away.rename(film)
    # What was seen late is not rendered again.
    assert petzval_cli("farm", "merge", job).returncode == 0
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_a_slow_folder_shows_half_of_an_agreement(blender, parts, tmp_path):
    """The first part's word on the scene, before it is whole; and one that never becomes it."""
    shares = __import__("petzval_addon.render.shares", fromlist=["agree"])
    loop = __import__("petzval_addon.render.loop", fromlist=["Share"])
    errors = __import__("petzval_addon.export.errors", fromlist=["ExportError"])
    stereo = __import__("petzval_addon.export.stereo", fromlist=["ONLY"])
    parts.set_up()
    depsgraph = blender.context.evaluated_depsgraph_get()

    class Found:
        def pieces(self):
            return {"mesh 0 'Wall'": "01"}

    def agree(fingerprint: str) -> None:
        shares.agree(loop.Share(agreement=str(file)), Found(), fingerprint, depsgraph, stereo.ONLY)

    file = tmp_path / "still.scene"
    agree("one")
    whole = file.read_text()
    for first in ("one", "two"):
        file.write_text(whole[:20])
        later = threading.Timer(0.4, file.write_text, [whole])
        later.start()
        if first == "one":
            agree("one")
        else:
            with pytest.raises(errors.ExportError, match="the scene is not the one of the parts before"):
                agree("two")
        later.join()
    file.write_text(whole[:20])
    agree("two")
    assert json.loads(file.read_text())["fingerprint"] == "two" and (tmp_path / "still.scene.damaged").exists()


def test_a_folder_that_knows_no_case(job, blender, parts, tmp_path, petzval_cli):
    """No two names of a job's folder are one where upper and lower case are the same; what would be is refused."""
    assert petzval_cli("farm", "merge", job).returncode == 0
    names = [str(file.relative_to(job)) for file in job.rglob("*")]
    assert len({name.casefold() for name in names}) == len(names) > 10
    parts.set_up()
    for name in ("Wall.png", "wall.png"):
        image = blender.data.images.new(name, 4, 4)
        image.filepath_raw, image.file_format, image.use_fake_user = str(tmp_path / name), "PNG", True
        image.save()
    if len(list(tmp_path.glob("*.png"))) < 2:
        pytest.skip("this folder knows no case itself")
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"))
    done = petzval_cli("farm", "plan", tmp_path / "two.blend", "-o", tmp_path / "new")
    assert done.returncode == 1 and "differ by upper and lower case alone" in done.stderr, done.stderr
    assert not (tmp_path / "new").exists()


def test_a_part_twice_at_once(job, finished_job, petzval_cli):
    """Two machines render one part at the same time."""
    before = (job / FILM).stat().st_mtime_ns
    both = [start("part", job, "1", "--again") for _ in range(2)]
    assert [one.wait(timeout=120) for one in both] == [0, 0], [one.stderr.read() for one in both]
    assert (job / FILM).stat().st_mtime_ns > before
    assert petzval_cli("farm", "merge", job).returncode == 0
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_a_killed_part_goes_on(farm_scenes_folder, tmp_path, petzval_cli, commands):
    """Killed at once, and stopped: the next try goes on, and the picture is that of one machine."""
    scene, job, whole = farm_scenes_folder / "small.blend", tmp_path / "job", tmp_path / "whole.exr"
    options = ["--samples", "1500", "--resolution", "48x32"]
    planned, rendered = commands(
        ["farm", "plan", scene, *options, "--parts", "1", "-o", job], ["render", scene, *options, "-o", whole]
    )
    assert (planned.returncode, rendered.returncode) == (0, 0), planned.stderr + rendered.stderr
    kept = job / "work/0000.checkpoint"
    for number, status in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGTERM, 130)):
        part = start("part", job, "0", "--checkpoint-every", "0.1")
        before = kept.stat().st_mtime_ns if kept.exists() else 0
        began = time.monotonic()
        while (kept.stat().st_mtime_ns if kept.exists() else 0) == before:
            assert part.poll() is None and time.monotonic() - began < 60.0
            time.sleep(0.01)
        part.send_signal(number)
        part.communicate(timeout=60)
        assert part.returncode == status
        assert not (job / "parts/0000.json").exists() and kept.exists()
    done = petzval_cli("farm", "part", job, "0")
    assert done.returncode == 0 and not kept.exists(), done.stderr
    assert petzval_cli("farm", "merge", job).returncode == 0
    assert_same_picture(job / "pictures/small.exr", whole)


def test_a_scene_that_is_random_is_found_before_it_is_rendered(job, petzval_cli):
    """The part that came first says which scene it was."""
    agreement = job / "work/still.scene"
    told = json.loads(agreement.read_text())
    name = next(one for one in told["pieces"] if "Wall" in one and one.startswith("mesh"))
    told["fingerprint"], told["pieces"][name] = "0" * 64, "0" * 16
    agreement.write_text(json.dumps(told))
    for words in (("part", job, "1", "--again"), ("merge", job)):
        done = petzval_cli("farm", *words)
        assert done.returncode == 1 and "mesh" in done.stderr and "'Wall'" in done.stderr, done.stderr
    assert not (job / "pictures/small.exr").exists()


def test_a_time_limit_is_tried_again(job, petzval_cli):
    change_job(job, lambda told: (told["options"].update(samples=1_000_000), told["limits"].update(seconds=0.5)))
    (job / "work/still.scene").unlink()
    (job / "parts/0001.json").unlink()
    done = petzval_cli("farm", "part", job, "1")
    assert done.returncode == 75 and "takes longer than 0.5 s" in done.stderr, done.stderr
    assert not (job / "parts/0001.json").exists()
