# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipes of the Makefile, typed as a user types them, at a small size; and the closing report of `make demo`."""

from __future__ import annotations

import json
import re
import shutil
import subprocess

import demo_report
import fuzz
import pytest

from support.places import ROOT

pytestmark = pytest.mark.once

#: Targets that other steps of `make test` or `make test-all` run whole, or that would run these tests.
RUN_ELSEWHERE = {
    "test",
    "test-all",
    # Hours of what the others run.
    "test-long",
    "lint",
    "setup",
    "build",
    "wheels",
    "extension",
    "docs",
    "pages-again",
    # By .github/workflows: six builds of the engine, and all Rust tests again.
    "wheels-all",
    "extensions-all",
    "release",
    "test-platforms",
}
#: Small runs of the others, by `make test-all`: the target's variables.
RECIPES = {
    "accuracy-cost": ["ACCURACY_COST_OPTIONS=--seconds 3"],
    "coatings": [],
    "denoising": ["DENOISING_OPTIONS=--only demo --samples 4 --reference 16 --height 36"],
    "diffraction": ["DIFFRACTION_OPTIONS=--quick"],
    "figures": ["FIGURES_OPTIONS=--size smallest --only fig-14 --check"],
    "fuzz": ["FUZZ_SECONDS=1", "FUZZ_OPTIONS=coating ies"],
    "ghosts": ["GHOSTS_OPTIONS=--only price --samples 2 --rounds 1"],
    "growth": ["GROWTH_OPTIONS=--only triangles lens-surfaces --most 1000 --samples 2 --rounds 1"],
    "gpu": ["GPU_OPTIONS=--quick"],
    "instructions": [],
    "lens-index": [],
    "other-programs": [],
    "reality": ["LENSFUN=tests/reference/lensfun/lenses.xml", "REALITY_OPTIONS=--only nikkor-z-24-70-f4"],
    "newcomer": [],
    "numerics": [],
    "other-scenes": ["SCENES=tests/scenes", "OTHER_SCENES_OPTIONS=--only demo --samples 9 --size 64x36"],
    "panel-pictures": [],
    "parity": ["PARITY_OPTIONS=--only sun --samples 4 --size 32x24"],
    "price": ["PRICE_OPTIONS=--quick"],
    "proofs": ["PROOFS_OPTIONS=--only biconvex-50mm --seconds 5"],
    "profile": ["SCENES=tests/scenes", "PROFILE_OPTIONS=--only demo"],
    "settings": ["SETTINGS_OPTIONS=--only scene.cycles.film_exposure world.color --samples 8 --looks 1"],
    "soak": ["SOAK_OPTIONS=--edits 60 --renders 20 --frames 20 --kills 1"],
    "speed": ["SPEED_OPTIONS=--quick"],
    "ui-pictures": ["UI_SAMPLES=4"],
    "viewport-price": ["VIEWPORT_PRICE_OPTIONS=--divide 16 --repeats 1"],
}


def make(*arguments, timeout_s: float = 1200.0) -> subprocess.CompletedProcess[str]:
    """`make ARGUMENTS...` in the checkout, with the build of `make test` instead of the release wheel."""
    if shutil.which("make") is None:
        pytest.skip("no make")
    command = ["make", "--no-print-directory", "ENGINE=build", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=timeout_s, check=False)


def targets() -> set[str]:
    """The Makefile's targets that `make help` lists."""
    return set(re.findall(r"^([a-z][a-z-]*):.*##", (ROOT / "Makefile").read_text(), re.MULTILINE))


def test_the_demo_ends_with_its_picture_and_its_report(tmp_path):
    done = make("demo", "DEMO_OPTIONS=--resolution 64x36 --samples 2", f"OUTPUT={tmp_path}")
    assert done.returncode == 0, done.stderr
    rows = dict(re.findall(r"^(\w+) {2,}(.*)$", done.stdout, re.MULTILINE))
    assert rows["image"] == f"{tmp_path}/demo.png" and (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")
    assert rows["resolution"] == "64 x 36" and rows["samples"] == "2"
    assert rows["lens"].startswith("Wide angle f/3.4")
    assert 0.0 < float(rows["lost"].split()[0]) < 50.0
    stats = json.loads((tmp_path / "demo.json").read_text())
    total = float(rows["seconds"].split(":")[0])
    # The phases, each rounded to a tenth, make up the total.
    parts = [float(part.split()[-1]) for part in rows["seconds"].split(": ")[1].split(", ")]
    assert total == pytest.approx(sum(parts), abs=0.05 * (len(parts) + 1))
    planned = [row["effect"].replace("_", " ") for row in stats["plan"]]
    said = [line.strip() for line in done.stdout.split("\neffects\n")[1].splitlines()]
    assert len(planned) > 10 and [line[: len(name)] for line, name in zip(said, planned, strict=True)] == planned


def test_seconds_of_stray_light_are_added_up():
    """The statistics hold a table of seconds for stray light, one for each of its passes."""
    seconds = {"sync": 1.0, "plan": None, "render": 20.0, "strays": {"ghosts": 3.0, "diffraction": 0.5}}
    assert demo_report.phases(seconds) == [
        ("reading the scene", 1.0), ("rendering", 20.0), ("ghosts", 3.0), ("diffraction", 0.5)
    ]  # fmt: skip


def test_bench_quick_ends_with_its_page():
    page = ROOT / "output/bench/performance.md"
    page.unlink(missing_ok=True)
    done = make("bench", "BENCH_OPTIONS=--quick")
    assert done.returncode == 0, done.stdout + done.stderr
    text = page.read_text()
    assert "Petzval" in text and "Cycles" in text and "Made by `make bench`" in text


@pytest.fixture
def docs_put_back(tmp_path):
    """docs/ and README.md are after the test as they were before: recipes write their pages there."""
    kept = tmp_path / "kept"
    shutil.copytree(ROOT / "docs", kept / "docs")
    shutil.copy2(ROOT / "README.md", kept)
    yield
    shutil.rmtree(ROOT / "docs")
    shutil.copytree(kept / "docs", ROOT / "docs")
    shutil.copy2(kept / "README.md", ROOT)


@pytest.mark.recipe
@pytest.mark.parametrize("target", RECIPES)
def test_a_small_run_ends_well(target, docs_put_back):
    needs = {"instructions": "valgrind", "profile": "perf"}.get(target)
    if needs is not None and shutil.which(needs) is None:
        pytest.skip(f"no {needs}: install it")
    if target == "fuzz" and (why := fuzz.missing()):
        pytest.skip(why)
    done = make(target, *RECIPES[target], timeout_s=2400.0)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]


def test_every_target_is_run():
    here = {"help", "demo", "bench", "pages", "clean"}
    assert targets() == {*RECIPES, *RUN_ELSEWHERE, *here}


def test_pages_are_listed():
    done = make("pages")
    assert done.returncode == 0, done.stderr
    assert "docs/accuracy-cost.md" in done.stdout


def test_clean_names_what_it_removes():
    """`make clean` itself would take the build away from the tests beside this one."""
    done = make("--dry-run", "clean")
    assert done.returncode == 0 and "cargo clean" in done.stdout and ".venv" not in done.stdout


def test_help_lists_what_each_target_makes():
    done = make("help")
    assert done.returncode == 0
    assert {line.split()[0] for line in done.stdout.splitlines()} == targets()
