#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of accuracy, in three scenes through three lenses each: runs `petzval cost` nine times, and writes
docs/accuracy-cost.md. Run by `make accuracy-cost` in .venv-bench, which has matplotlib; renders where bpy is."""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

import pages

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "output" / "accuracy-cost"
#: The origin of the last run's numbers.
MADE = WORK / "made.json"
sys.path.insert(0, str(ROOT / "engine/python"))

from petzval.cost import plot, tables  # noqa: E402
from petzval.cost.advice import percent, seconds  # noqa: E402

#: The options of each scene, and its description.
SCENES = {
    "demo": (["--resolution", "120x68"], "the desk of the demo scene: defocus from near to far, many lamps, noisy"),
    "landscape": (
        ["--resolution", "180x120"],
        "hills and trees far away in sunlight: all of it in focus, hardly noisy",
    ),
    "room": (["--resolution", "180x120"], "a room in a window's light, focused at 2.2 m"),
}
#: Lens: how it is scaled, so that all see about as much; one is stopped down, for blades have no say in a lens that is wide open.
LENSES = {
    "wide-angle-smith-f3.4": ["--focal-length", "35", "--film", "36x24"],
    "double-gauss-f2-tronnier": ["--focal-length", "50", "--film-diagonal", "38", "--f-number", "2.8", "--blades", "6"],
    "cellphone-5.6mm-f3.5": ["--film-diagonal", "5.6"],
}
#: The openings of these lenses, for the reader.
OPENINGS = {"double-gauss-f2-tronnier": "at f/2.8, with six blades"}
#: The scenes and lenses with a picture on the page.
DRAWN = (("demo", "wide-angle-smith-f3.4"), ("landscape", "cellphone-5.6mm-f3.5"), ("room", "double-gauss-f2-tronnier"))
SECONDS = 75


def main() -> int:
    asked = argparse.ArgumentParser(prog="accuracy_cost", description="Writes docs/accuracy-cost.md.")
    asked.add_argument("--python", help="one that has petzval and bpy; default: the checkout's")
    asked.add_argument("--seconds", type=float, default=SECONDS, help="for each of the nine")
    asked.add_argument("--page", action="store_true", help="write the page of the last run again")
    options = asked.parse_args()
    python = options.python or next(
        (str(path) for version in ("52", "45") if (path := ROOT / f".venv-bpy{version}/bin/python").exists()), None
    )
    if not options.page:
        if python is None:
            print("petzval: no environment with bpy: make build", file=sys.stderr)
            return 1
        began, made = time.monotonic(), pages.made("docs/accuracy-cost.md")
        try:
            _measure(python, options.seconds)
        except subprocess.CalledProcessError as error:
            print(f"petzval: {error.cmd[-1]}: it ended with {error.returncode}: see above", file=sys.stderr)
            return 1
        MADE.write_text(json.dumps(made.took(time.monotonic() - began)))
    found = {pair: json.loads(_file(*pair).read_text()) for pair in _pairs() if _file(*pair).exists()}
    if len(found) < len(_pairs()) or not MADE.exists():
        print(f"petzval: not all of it is measured yet: see {WORK.relative_to(ROOT)}", file=sys.stderr)
        return 1
    for scene, lens in DRAWN:
        plot.draw(found[scene, lens], [ROOT / "docs" / _picture(scene, lens)])
    origin = pages.Made(*json.loads(MADE.read_text()))
    (ROOT / "docs/accuracy-cost.md").write_text(pages.stamped(_page(found), origin))
    readme = ROOT / "README.md"
    readme.write_text(pages.filled(readme.read_text(), "accuracy", _small(found)))
    print("petzval: wrote docs/accuracy-cost.md, and its table in README.md")
    return 0


def _pairs() -> list[tuple[str, str]]:
    return [(scene, lens) for scene in SCENES for lens in LENSES]


def _file(scene: str, lens: str) -> Path:
    return WORK / f"{scene}-{lens}" / "costs.json"


def _picture(scene: str, lens: str) -> str:
    return f"images/accuracy-cost-{scene}-{lens}.png"


def _measure(python: str, seconds: float) -> None:
    WORK.mkdir(parents=True, exist_ok=True)
    paths = [os.environ.get("PYTHONPATH", ""), str(ROOT / "tests"), str(ROOT / "tests/scenes")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    made = [scene for scene in SCENES if scene != "demo"]
    subprocess.run(
        [python, "-m", "plan_scenes", str(WORK), *made], check=True, env=environment, stdout=subprocess.DEVNULL
    )
    for scene, lens in _pairs():
        blend = ROOT / "tests/scenes/demo.blend" if scene == "demo" else WORK / f"{scene}.blend"
        print(f"petzval: {scene} through {lens}", flush=True)
        command = [python, "-m", "petzval", "cost", str(blend), "--lens", str(ROOT / f"lenses/{lens}.lens")]
        command += [*LENSES[lens], *SCENES[scene][0], "--seconds", str(seconds), "--threads", "1", "--samples", "64"]
        command += ["-o", str(_file(scene, lens).parent)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def _page(found: dict[tuple[str, str], dict]) -> str:
    some = next(iter(found.values()))
    rows = [{row["key"]: row for row in one["rungs"] if row["is_measured"]} for one in found.values()]
    parts = [
        "# What accuracy costs",
        "Each picture was taken by every camera that Petzval has, from the pinhole to all that a lens does, and held against "
        "the truth: everything on, all wavelengths, many samples. Stray light is laid over a finished picture; it has rows of its own, "
        "held against the truth with it. An error is how far a pixel is off, of its brightness; what "
        "of it no samples mend is *for good*. `petzval cost SCENE.blend --lens FILE -o DIR` makes such a page of your own "
        f"picture. Here: {some['threads']} thread, {some['samples']} samples a pixel.",
        "## What one learns",
        "\n".join(f"- {line}" for line in _lessons(rows, list(found.values()))),
        "## All nine",
        _summary(found),
        "## Effect by effect",
        _effects(list(found.values())),
        "## One by one",
    ]
    for (scene, lens), one in found.items():
        chapter = tables.markdown(one, level=3, picture=None)
        title, rest = chapter.split("\n\n", 1)
        title = re.sub("What accuracy costs: ", "", title)
        parts.append(f"{title}\n\nThe scene: {SCENES[scene][1]}. The lens: {OPENINGS.get(lens, 'wide open')}.")
        if (scene, lens) in DRAWN:
            parts.append(f"![Error over time, a dot a camera]({_picture(scene, lens)})")
        parts.append(f"<details><summary>All numbers</summary>\n\n{rest.strip()}\n\n</details>")
    return "\n\n".join(parts) + "\n"


def _lessons(rows: list[dict[str, dict]], found: list[dict]) -> list[str]:
    """Sentences with the range over all pictures that have both cameras."""

    def over(first: str, second: str, what: str = "us_a_sample") -> list[float]:
        return [one[first][what] / one[second][what] - 1.0 for one in rows if first in one and second in one]

    def to_equal_noise(first: str, second: str) -> list[float]:
        return [
            one[first]["us_a_sample"] * one[first]["noise_of_one_sample"]
            / (one[second]["us_a_sample"] * one[second]["noise_of_one_sample"]) for one in rows
        ]  # fmt: skip

    def bias(key: str) -> str:
        values = sorted(one[key]["bias"] for one in rows if key in one)
        if values[-1] == 0.0:
            return "nothing that can be told from noise"
        return f"up to {percent(values[-1])}" if values[0] == 0.0 else f"{percent(values[0])} to {percent(values[-1])}"

    quotients = [abs(one["auto"]["predicted_over_measured"] - 1.0) for one in found]
    pairs = [
        (f"without {row['effect'].replace('_', ' ')}", row["bias"])
        for one in rows for row in one.values() if row["group"] == "effect"
    ]  # fmt: skip
    worst = max(pairs, key=lambda pair: pair[1])
    strays = [
        (row["name"].removeprefix("with "), row["bias"])
        for one in rows
        for row in one.values()
        if row["group"] == "stray"
    ]
    stray = max(strays, key=lambda pair: pair[1])
    return [
        f"Tracing every ray through every surface of the lens, at one wavelength, changes the time of a sample by "
        f"{_range(over('one-f32', 'pinhole'))} against a pinhole's. In double precision it is {_range(over('one-f64', 'one-f32'))} more.",
        f"All wavelengths by the hero pipeline cost {_range(over('hero', 'one-f32'))} on top of one wavelength; three indices, "
        f"{_range(over('rgb', 'one-f32'))}.",
        f"For the same noise, film-first takes {_times(to_equal_noise('film', 'hero'))} hero's time, and scene-first "
        f"{_times(to_equal_noise('scene', 'hero'))}.",
        f"What the plan chooses takes {_times(to_equal_noise('auto', 'hero'))} the time of everything on for the same noise, "
        f"and {_range(over('auto', 'pinhole'))} more than a pinhole for a sample.",
        f"Off for good, however many samples: the pinhole {bias('pinhole')}; the thin lens {bias('thin')}; the thick lens "
        f"{bias('thick')}; the paraxial lens {bias('paraxial')}; the exact lens at one wavelength {bias('one-f32')}; "
        f"the plan's choice {bias('auto')}.",
        f"Of a single effect most is lost {worst[0]}: {percent(worst[1])}. Of light that strays, without {stray[0]}: {percent(stray[1])}.",
        f"The plan's forecast was off by {100.0 * median(quotients):.0f} % in the middle of these pictures, and by "
        f"{100.0 * max(quotients):.0f} % at most.",
    ]


def _range(values: list[float]) -> str:
    low, high = 100.0 * min(values), 100.0 * max(values)
    return f"{round(low)} to {round(high)} %" if round(low) != round(high) else f"{round(low)} %"


def _times(values: list[float]) -> str:
    low, high = f"{min(values):.2f}", f"{max(values):.2f}"
    return f"{low} to {high} times" if low != high else f"{low} times"


def _effects(found: list[dict]) -> str:
    """A row for every effect that there is: its price when it is on, and the error when it is off, over all pictures."""
    lines = [
        "Each effect alone, the range over these pictures. *On*: the time of a sample beside that of everything on without it, or for stray "
        "light the seconds that it takes once. *Off*: how far pixels are off for good.",
        "",
        "| effect | on: time a sample | on: once a picture | off: pixels are off by | the plan simulates it |",
        "|---|---:|---:|---:|---:|",
    ]
    for effect in (row["effect"] for row in found[0]["auto"]["effects"]):
        pairs = [
            (row, next(top for top in one["rungs"] if top["key"] == "hero"))
            for one in found for row in one["rungs"]
            if row["effect"] == effect and row["is_measured"]
        ]  # fmt: skip
        planned = [next(row for row in one["auto"]["effects"] if row["effect"] == effect) for one in found]
        name = "transmission (coatings, glass)" if effect == "transmission" else effect.replace("_", " ")
        if not pairs:
            reason = "in none of these pictures" if planned[0]["is_available"] else "cannot be simulated yet"
            lines.append(f"| {name} | – | – | {reason} | – |")
            continue
        a_sample, once = "–", "–"
        if pairs[0][0]["group"] == "stray":
            times = [row["stray_s"] for row, _ in pairs]
            once = _between(seconds(min(times)), seconds(max(times)))
        else:
            a_sample = _range([top["us_a_sample"] / row["us_a_sample"] - 1.0 for row, top in pairs])
        biases = sorted(row["bias"] for row, _ in pairs)
        low = percent(biases[0]) if biases[0] > 0.0 else "nothing that is seen"
        off = _between(low, percent(biases[-1]) if biases[-1] > 0.0 else low)
        count = sum(row["decision"] == "on" for row in planned)
        lines.append(f"| {name} | {a_sample} | {once} | {off} | {count} of {len(found)} |")
    return "\n".join(lines)


#: The cameras of the README's table.
SMALL = ("pinhole", "thin", "thick", "paraxial", "one-f32", "one-f64", "rgb", "hero", "auto")


def _small(found: dict[tuple[str, str], dict]) -> list[str]:
    """The README's table: each camera's time beside the pinhole's and its error, then the stray light; medians and ranges over all pictures."""
    rows = [{row["key"]: row for row in one["rungs"] if row["is_measured"]} for one in found.values()]
    lines = [
        f"Over {len(found)} pictures: the time of a sample beside a pinhole's (median), and how far pixels stay off, however many samples.",
        "",
        "| camera | time | off for good |",
        "|---|---:|---:|",
    ]
    for key in SMALL:
        pairs = [(one[key], one["pinhole"]) for one in rows if key in one]
        if not pairs:
            continue
        ratio = median(row["us_a_sample"] / base["us_a_sample"] for row, base in pairs)
        name = "as the plan of effects decides" if key == "auto" else pairs[0][0]["name"]
        lines.append(f"| {name} | {ratio:.2f} | {_off([row['bias'] for row, _ in pairs])} |")
    for key in ("with-ghosts", "with-glare", "with-diffraction"):
        strays = [one[key] for one in rows if key in one]
        if strays:
            times = sorted(row["stray_s"] for row in strays)
            once = f"{_between(seconds(times[0]), seconds(times[-1]))} a picture"
            lines.append(
                f"| {strays[0]['effect']}, laid over the picture | {once} | without: {_off([row['bias'] for row in strays])} |"
            )
    scene, lens = DRAWN[0]
    lines += ["", f"![Error over time, a dot a camera](docs/{_picture(scene, lens)})", ""]
    lines.append(
        "*The demo scene through the lens of figure 3: error over time, a dot a camera. [All pictures](docs/accuracy-cost.md).*"
    )
    return lines


def _off(biases: list[float]) -> str:
    """The range of errors for good; zero is an error that noise hides."""
    low, high = min(biases), max(biases)
    if high == 0.0:
        return "nothing that is seen"
    return f"up to {percent(high)}" if low == 0.0 else _between(percent(low), percent(high))


def _between(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"


def _summary(found: dict[tuple[str, str], dict]) -> str:
    head = ("scene", "lens", "the plan took", "pinhole", "exact, one", "hero", "auto", "thick lens is off", "auto is off",
            "forecast over clock")  # fmt: skip
    lines = ["| " + " | ".join(head) + " |", "|---|---|---" + "|---:" * (len(head) - 3) + "|"]
    for (scene, _), one in found.items():
        row = {row["key"]: row for row in one["rungs"] if row["is_measured"]}
        camera = one["auto"]["camera"]
        count = camera["wavelengths"]
        chosen = f"{camera['model']}, {count} wavelength{'s' if count > 1 else ''}"
        times = [
            f"{row[key]['us_a_sample']:.2f}" if key in row else "–" for key in ("pinhole", "one-f32", "hero", "auto")
        ]
        biases = [
            percent(row[key]["bias"])
            if row[key]["bias"] > 0.0
            else f"under {percent(3.0 * row[key]['bias_uncertainty'])}"
            for key in ("thick", "auto")
        ]
        quotient = f"{one['auto']['predicted_over_measured']:.2f}"
        lines.append("| " + " | ".join([scene, one["lens"], chosen, *times, *biases, quotient]) + " |")
    return "\n".join(lines) + "\n\nTimes are µs a sample; what is off is off for good."


if __name__ == "__main__":
    sys.exit(main())
