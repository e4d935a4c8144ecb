# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of figures."""

from __future__ import annotations

from .kernels import GROUPS
from .measure import Plan, middle, ratio
from .noise import FLOOR, TRIMMED, Convergence
from .programs import CAMERAS, CYCLES, LLVM, NAMES, SCALAR

TARGETS = (0.01, 0.005)
#: The most that converged pictures may differ: about 5 % of a pixel's value.
AGREE = 0.003


def page(found: dict, plan: Plan, about: dict, image: str) -> str:
    """Markdown. `about`: versions, triangles, missing."""
    parts = [
        _head(plan, about),
        _speed(found, plan),
        _memory(found, plan),
        _noise(found, plan, image),
        _agreement(found, plan),
        _places(found, plan),
        _threads(found, plan),
        _kernels(found),
    ]
    return "\n".join(part for part in parts if part)


def _head(plan: Plan, about: dict) -> str:
    scenes = ", ".join(f"{name} ({about['triangles'][name]:,} triangles)" for name in plan.scenes)
    text = f"""# Petzval beside Cycles and Mitsuba

The same scene in three renderers: {about["versions"]}.

Twenty bumpy bodies (diffuse, rough metal, glass) at 0.8 to 30 m on a ground before a wall, 24 small lamps, a sky:
{scenes}. 50 mm on 36 x 20.25 mm of film, f/2, focused at 2 m. Eight bounces, a box filter of one pixel; no clamping, no
adaptive sampling, no denoiser. Two threads. Every figure is from a process of its own, programs in turns; medians of
{plan.rounds} {"round" if plan.rounds == 1 else "rounds"}. Times are user CPU seconds, which suffer less from what else the
machine does than wall time; within a table compare the ratios. Petzval and Cycles run inside the same Blender. The exact
lens is a double Gauss f/2 with 11 surfaces; in Cycles it is an OSL camera script at one wavelength that traces the same
surfaces (`tools/bench/double_gauss.py`). Mitsuba has no such camera. The `llvm` variant of Mitsuba is a wave-front renderer
with Embree, the `scalar` one traces path by path as Petzval and Cycles do.
"""
    if about["missing"]:
        text += "\nCould not run:\n\n" + "".join(f"- {line}\n" for line in about["missing"])
    return text


def _speed(found: dict, plan: Plan) -> str:
    width, height = plan.size
    count = width * height * plan.samples
    lines = [
        f"## Time of {plan.samples} samples a pixel, {width} x {height}\n",
        "The samples alone; *once* is what a render call does beside them (sync, trees, start-up), in CPU seconds too.\n",
        "| scene | camera | program | CPU s | µs a sample | over Mitsuba scalar | over Cycles | once | rays lost |",
        "|---|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for scene, cameras in found["speed"].items():
        for camera, by_program in cameras.items():
            for program, rounds in by_program.items():
                seconds = middle(rounds, "sampling_s")
                over = [
                    number(ratio(rounds, by_program[base]), 2) if base in by_program else "–"
                    for base in (SCALAR, CYCLES)
                ]
                lost = middle(rounds, "lost")
                cells = [scene, CAMERAS[camera], NAMES[program], number(seconds, 2), number(1e6 * seconds / count, 2),
                         *over, number(middle(rounds, "once_s"), 2) if program not in (SCALAR, LLVM) else "–",
                         "–" if lost is None else f"{100 * lost:.1f} %"]  # fmt: skip
                lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _memory(found: dict, plan: Plan) -> str:
    width, height = plan.size
    lines = [
        f"## Memory and preparation, pinhole, {width} x {height}\n",
        "Peak of the process; *beyond Blender*: less that of a Blender that has only opened the scene. Mitsuba's seconds are",
        "of reading its files and building the tree; Cycles does not say its own.\n",
        "| scene | program | peak MB | beyond Blender | sync s | trees s |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for scene, cameras in found["speed"].items():
        for program, rounds in cameras.get("pinhole", {}).items():
            peak = middle(rounds, "peak_mb")
            base = found["memory"].get(scene)
            inside = program not in (SCALAR, LLVM) and base is not None
            cells = [scene, NAMES[program], number(peak, 0), number(peak - base, 0) if inside else "–",
                     number(middle(rounds, "sync_s"), 2), number(middle(rounds, "tree_s"), 2)]  # fmt: skip
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _noise(found: dict, plan: Plan, image: str) -> str:
    width, height = plan.noise_size
    lines = [
        f"## Equal noise, {plan.scenes[0]}, {width} x {height}\n",
        f"CPU seconds until the relative mean squared error, mean((a - r)² / (r² + ε²)) with ε = {FLOOR:.0%} of the",
        f"reference's mean and without the worst {TRIMMED:.1%} of the pixels, is down to a limit. Each program against its own",
        f"picture of {plan.reference_samples} samples, whose own noise is taken off. Error as c / samples through",
        f"{', '.join(map(str, plan.noise_samples))} samples; seconds by the slope over samples, start-up left out.\n",
        f"![Noise over CPU time]({image})\n",
        "| camera | program | " + " | ".join(f"to {target:g}" for target in TARGETS) + " | samples to "
        f"{TARGETS[0]:g} | over Cycles | over Mitsuba llvm |",
        "|---|---|" + "---:|" * (len(TARGETS) + 3),
    ]
    for camera, by_program in found["noise"].items():
        fitted = {
            program: Convergence(one["error_samples"], one["seconds_per_sample"]) for program, one in by_program.items()
        }
        for program, one in fitted.items():
            seconds = [one.seconds_to(target) for target in TARGETS]
            over = [
                number(seconds[0] / fitted[base].seconds_to(TARGETS[0]), 2) if base in fitted else "–"
                for base in (CYCLES, LLVM)
            ]
            cells = [CAMERAS[camera], NAMES[program], *(number(value, 2) for value in seconds),
                     number(one.error_samples / TARGETS[0], 0), *over]  # fmt: skip
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _agreement(found: dict, plan: Plan) -> str:
    lines = [
        "## Do they render the same picture?\n",
        f"Converged pictures ({plan.reference_samples} samples) against each other: trimmed relMSE, the noise of both taken off;",
        f"it should stay under {AGREE:g}. Blender's Glossy is a Principled metal in Petzval, which is brighter at its edges.\n",
        "| camera | pictures | relMSE | of it noise | the difference | mean brightness |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for one in found["agreement"]:
        left = one["measured"] - one["noise"]
        cells = [CAMERAS[one["camera"]], " and ".join(NAMES[program] for program in one["programs"]),
                 number(one["measured"], 5), number(one["noise"], 5),
                 number(max(left, 0.0), 5) + ("" if left <= AGREE else " (!)"), number(one["mean_ratio"], 4)]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _places(found: dict, plan: Plan) -> str:
    if not found.get("places"):
        return ""
    width, height = plan.noise_size
    lines = [
        f"## Three places, pinhole, {width} x {height}, {plan.noise_samples[-1]} samples\n",
        "A *meadow* under sun and sky with 120,000 blades of grass and 3,000 leaves that their material cuts out, by instances; a *room* that sun and",
        "sky light through its window; a street at *night* with seventy lamps in fog (`tools/bench/places.py`). As scenes by others are measured:",
        "the quickest of all renders, noise as the relative variance of a pixel between seeds.\n",
        "| place | Petzval, µs a sample | Cycles | over | mean over Cycles' | noise over Cycles' | time to equal noise over Cycles' |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, one in found["places"].items():
        numbers = [one["petzval_us"], one["cycles_us"], one["petzval_us"] / one["cycles_us"]]
        cells = [name, *(number(value, 2) for value in numbers), number(one["mean"], 3), number(one["noise"], 2), number(one["time"], 2)]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _threads(found: dict, plan: Plan) -> str:
    if not plan.threads:
        return ""
    lines = [
        f"## Two threads against one, thin lens, {plan.scenes[0]}\n",
        "| program | wall s, one | wall s, two | faster | CPU s, two over one |",
        "|---|---:|---:|---:|---:|",
    ]
    for program, by_count in found["threads"].items():
        if {"1", "2"} <= by_count.keys():
            one, two = by_count["1"], by_count["2"]
            cells = [NAMES[program], number(one["wall_s"], 2), number(two["wall_s"], 2),
                     number(one["wall_s"] / two["wall_s"], 2), number(two["user_s"] / one["user_s"], 2)]  # fmt: skip
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _kernels(found: dict) -> str:
    rays, kernels = dict(found.get("rays", {})), found.get("kernels", {})
    lines = ["## Kernels, one thread\n"]
    tree = kernels.get("tree", {})
    if rays or tree:
        lines.append(
            "Nanoseconds a ray; Embree's are random rays of the pinhole's picture and of a cosine bounce where they"
        )
        lines.append(
            f"hit, {int(rays.get('rays', 0)):,} at a time, called by Mitsuba, in the scene *{rays.get('scene', '')}*."
        )
        lines.append(f"Petzval's are of `{GROUPS['tree']}`, on the scene of that bench.\n")
        lines += ["| rays | Petzval | Embree |", "|---|---:|---:|"]
        works = ("build", "refit")
        names = [name for name in {**tree, **rays} if "/" in name and not name.endswith(works)]
        lines += [f"| {name} | {number(tree.get(name), 0)} | {number(rays.get(name), 0)} |" for name in names]
        made = [name for name in tree if name.endswith(works)]
        lines += [f"| {name}, ns a triangle, two threads | {number(tree[name], 0)} | – |" for name in made]
        lines.append("")
    camera = kernels.get("camera sample", {})
    if camera:
        lines += [f"Nanoseconds a camera sample (`{GROUPS['camera sample']}`):\n", "| camera | ns |", "|---|---:|"]
        lines += [f"| {name} | {value:.0f} |" for name, value in camera.items()]
        lines.append("")
    absent = [command for group, command in GROUPS.items() if group not in kernels]
    if absent:
        lines.append("Not measured yet here: " + ", ".join(f"`{command}`" for command in absent) + ".\n")
    return "\n".join(lines)


def number(value: float | None, places: int) -> str:
    """The cells of a row, with a dash for missing values."""
    return "–" if value is None else f"{value:.{places}f}"
