# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 11: a wide-angle lens wide open, with the rings of its spherical aberration in every blurred lamp, and at f/8, round, with five
blades, and with six."""

from __future__ import annotations

import numpy as np

from .blur import edge, harmonics, profile
from .figure import Caption, Figure, Shot, Taken, claim
from .rays import Rays
from .scene import in_lens_space, places_mm

LENS, FOCAL_MM, FOCUS_MM = "wide-angle-smith-f3.4", 100.0, 1250.0
#: A lamp that no other is near to, where its image is on the film, mm, and its width.
LAMP, AT_MM, LAMP_RADIUS_MM = "Lamp in the hedge 10", (9.52, 7.26), 9372.0 * 0.0030 * 0.35
#: Kind, label, options, width of the film on which one blurred lamp is seen alone, mm.
KINDS = (
    ("open", "wide open, f/3.4", (), 4.2),
    ("round", "f/8", ("--f-number", "8"), 2.1),
    ("five", "f/8, five blades", ("--f-number", "8", "--blades", "5"), 2.1),
    ("six", "f/8, six blades", ("--f-number", "8", "--blades", "6"), 2.1),
)
#: Pictures of one lamp: name, samples, denoising.
NEAR = (("near", 1536, "off"), ("denoised", 96, "high"))
#: Pixels across a denoised picture from which on it is measured. At 240 it passes the checks; at 60 the ring is smoothed, and correlates with
#: exact rays by 0.947. Sizes between were not tried.
LEAST_WIDTH = 200
_PLAIN = ("--effect", "ghosts=off", "--effect", "glare=off", "--effect", "diffraction=off")


def _shots() -> list[Shot]:
    shots = []
    focus = ("--focal-length", f"{FOCAL_MM:g}", "--focus-distance", f"{FOCUS_MM:g}")
    for kind, label, options, film_mm in KINDS:
        many = ("--min-samples", "64", "--noise-threshold", "0.03")
        shots.append(
            Shot(
                f"fig-11-{kind}",
                "lights",
                LENS,
                (*focus, *options, *many),
                "points",
                label,
                samples=8.0,
                is_only_shown=True,
            )
        )
        near = ("--film", f"{film_mm:g}x{film_mm / 1.5:g}", "--shift", f"{AT_MM[0]:g},{AT_MM[1]:g}", *_PLAIN)
        for name, samples, denoise in NEAR:
            wish = (*focus, *options, *near, "--samples", str(samples), "--denoise", denoise)
            text, is_hidden = f"a lamp, {label}", denoise != "off"
            text += f", denoised, {samples} samples" if is_hidden else ""
            shots.append(
                Shot(f"fig-11-{kind}-{name}", "lights", LENS, wish, "points", text, width=0.5, is_hidden=is_hidden)
            )
    # Shown are whole pictures, then parts of them; denoised ones are measured alone.
    order = (0, 3, 6, 9, 1, 7, 10, 4)
    return [*(shots[i] for i in order), *(shots[i] for i in range(2, 12, 3))]


def foretold(blend) -> tuple[np.ndarray, float]:
    """Radii from the middle at which exact rays of the lamp hit the film, mm, wide open, and the lamp's radius there."""
    rays = Rays(LENS, FOCUS_MM, focal_length_mm=FOCAL_MM)
    place = places_mm(blend, LAMP)[LAMP]
    hits = rays.on_film(in_lens_space(place, rays.pupil_z), 0.0, 20000)
    magnification = FOCAL_MM / place[2]
    return np.hypot(*(hits - hits.mean(0)).T), LAMP_RADIUS_MM * magnification


def read(taken: dict[str, Taken]) -> Caption:
    caption = Caption(head=("picture", "corners counted", "strongest harmonic of the edge", "next"))
    is_large = taken["fig-11-open-denoised"].size[0] >= LEAST_WIDTH
    names = [name for name, _, denoise in NEAR if denoise == "off" or is_large]
    # Rings: light by radius, against exact rays.
    rings = {name: _ring(taken[f"fig-11-open-{name}"]) for name in names}
    limit, brightest, rim, alike = rings["near"]
    denoised = rings.get("denoised")
    after = f"; denoised, of {NEAR[1][1]} samples, {denoised[2][0]:.2f} times and {denoised[3]:.3f}" if denoised else ""
    caption.sentences = [
        f"The wide-angle lens at {FOCAL_MM:g} mm, focused at {FOCUS_MM / 1000.0:g} m; the lamp by itself is {9.372:g} m away. Wide open, spherical "
        f"aberration draws a ring: at {brightest[0]:.2f} of the blur's radius ({brightest[1]:.2f} by exact rays, radius {limit:.2f} mm) it has "
        f"{rim[0]:.2f} times the light of the middle ({rim[1]:.2f} by exact rays); light over radius follows exact rays with a correlation of "
        f"{alike:.3f}{after}. At f/8 the diaphragm's shape is left: its corners are counted as the harmonics of the edge's radius over the angle.",
    ]
    for kind, corners in (("round", 0), ("five", 5), ("six", 6)):
        for name in names:
            caption.rows.append(_corners(taken[f"fig-11-{kind}-{name}"], corners))
    return caption


def _ring(picture: Taken) -> tuple[float, tuple[float, float], tuple[float, float], float]:
    """The radius of a lamp's blur, mm; the part of it at which the ring is brightest and the ring's light over that of the middle, both
    measured and by exact rays; the correlation of light over radius with exact rays."""
    radii, lamp = foretold(picture.blend)
    mm_per_px = KINDS[0][3] / picture.size[0]
    limit = float(np.quantile(radii, 0.999))
    at, light = profile(picture.light, mm_per_px, 1.3 * limit, 26)
    count, _ = np.histogram(spread(radii, lamp), bins=np.linspace(0.0, 1.3 * limit, 27))
    ring = np.diff(np.linspace(0.0, 1.3 * limit, 27) ** 2)
    expected = count / ring / (count / ring)[:4].mean()
    light = light / light[:4].mean()
    alike = float(np.corrcoef(light, expected)[0, 1])
    inner = at < 0.95 * limit
    brightest = [float(at[inner][values[inner].argmax()] / limit) for values in (light, expected)]
    rim = [float(values[inner].max()) for values in (light, expected)]
    claim(alike > 0.97, f"light by radius in a blurred lamp and that of exact rays correlate by {alike:.3f} only")
    claim(
        abs(rim[0] / rim[1] - 1.0) < 0.15,
        f"the brightest ring has {rim[0]:.2f} times the light of the middle, by exact rays {rim[1]:.2f}",
    )
    return limit, (brightest[0], brightest[1]), (rim[0], rim[1]), alike


def _corners(one: Taken, corners: int) -> tuple[str, ...]:
    """The row of a picture of a lamp through a diaphragm with so many corners."""
    found = harmonics(edge(one.light))
    first, second = sorted(found, key=lambda k: -found[k])[:2]
    counted = first if found[first] > 0.02 else 0
    claim(counted == corners, f"{one.shot.label}: {counted} corners counted, harmonics {found}")
    # Measured of regular pentagons and hexagons blurred as these are; noise makes about a half of a hundredth.
    claim(
        corners == 0 or found[first] > 2.0 * found[second],
        f"{one.shot.label}: corners are not told from noise: {found}",
    )
    return (
        one.shot.label.removeprefix("a lamp, "),
        str(counted),
        f"{100.0 * found[first]:.1f} % at {first}",
        f"{100.0 * found[second]:.1f} % at {second}",
    )


def spread(radii: np.ndarray, lamp: float) -> np.ndarray:
    """Radii of rays that come from all of a round lamp, whose image has that radius: each is moved by places evenly over it."""
    i = np.arange(64) + 0.5
    turn, part = i * np.pi * (3.0 - np.sqrt(5.0)), lamp * np.sqrt(i / 64)
    x = radii[:, None] + (part * np.cos(turn))[None, :]
    return np.hypot(x, (part * np.sin(turn))[None, :]).ravel()


FIGURE = Figure("fig-11", "Figure 11: apertures", tuple(_shots()), read)
