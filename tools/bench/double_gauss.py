# SPDX-License-Identifier: GPL-3.0-or-later
"""The double Gauss as a camera script for Cycles: rays from the film through the exit pupil, traced back through every
surface at one wavelength; those that do not get out through all of them are black."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

WAVELENGTH_UM = 0.5875618
#: Rays are aimed at a disc somewhat larger than the paraxial exit pupil: the real one wanders towards the corners.
AIM = 1.05


@dataclass
class Lens:
    """Millimetres, the light from -z to +z; surfaces front to back, the film behind them."""

    vertex_z: np.ndarray
    radius: np.ndarray  # 0: flat
    aperture: np.ndarray  # semi-diameters
    index_before: np.ndarray
    index_behind: np.ndarray
    film_z: float
    pupil_z: float
    pupil_radius: float
    entrance_z: float


def glass_index(name: str, catalogues: Path) -> float:
    """The index of a glass at the wavelength of the script."""
    if name == "air":
        return 1.0
    for file in sorted(catalogues.glob("*.json")):
        glass = json.loads(file.read_text())["glasses"].get(name)
        if glass is not None and glass["formula"] == "sellmeier":
            first, *terms = glass["coefficients"]
            square = WAVELENGTH_UM**2
            pairs = zip(terms[::2], terms[1::2], strict=True)
            return float(np.sqrt(1.0 + first + sum(b * square / (square - c) for b, c in pairs)))
    raise LookupError(f"no Sellmeier formula for {name} in {catalogues}")


def focal_length(radius: np.ndarray, thickness: np.ndarray, behind: np.ndarray) -> float:
    """The focal length by a paraxial ray along the axis."""
    height, slope, index = 1.0, 0.0, 1.0
    for r, t, after in zip(radius, thickness, behind, strict=True):
        bend = 0.0 if r == 0.0 else height * (after - index) / r
        slope, index = (index * slope - bend) / after, after
        height += t * slope
    return -1.0 / (index * slope)


def read(path: Path, info: dict) -> Lens:
    """The lens from a file of spheres, and the answer of `petzval lens info --json` at the wanted size and focus."""
    lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    radius, thickness, diameter = (np.array([float(line[k]) for line in lines]) for k in (0, 1, 3))
    behind = np.array([glass_index(line[2], path.parent / "glass") for line in lines])
    is_stop = np.array([line[5] == "1" for line in lines])
    scale = info["efl_mm"] / focal_length(radius, thickness, behind)
    aperture = 0.5 * scale * diameter
    aperture[is_stop] = 0.5 * info["stop_diameter_mm"]
    return Lens(
        vertex_z=scale * np.concatenate([[0.0], np.cumsum(thickness[:-1])]),
        radius=scale * radius,
        aperture=aperture,
        index_before=np.concatenate([[1.0], behind[:-1]]),
        index_behind=behind,
        film_z=info["film_z_mm"],
        pupil_z=info["exit_pupil"]["z_mm"],
        pupil_radius=0.5 * info["exit_pupil"]["diameter_mm"],
        entrance_z=info["entrance_pupil"]["z_mm"],
    )


def trace(lens: Lens, origin: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays (n, 3) from behind the lens out of its front: places, directions and which got through."""
    place, way = origin.astype(float), direction.astype(float)
    through = np.ones(len(place), bool)
    with np.errstate(invalid="ignore"):
        for k in reversed(range(len(lens.radius))):
            radius, z = lens.radius[k], lens.vertex_z[k]
            if radius == 0.0:
                place = place + way * ((z - place[:, 2]) / way[:, 2])[:, None]
                normal = np.broadcast_to((0.0, 0.0, -1.0), place.shape)
            else:
                from_centre = place - (0.0, 0.0, z + radius)
                along = (from_centre * way).sum(1)
                root = np.sqrt(along**2 - (from_centre**2).sum(1) + radius**2)
                # The side of the sphere that the vertex is on.
                distance = -along + np.copysign(root, radius)
                place = place + way * distance[:, None]
                normal = (place - (0.0, 0.0, z + radius)) / radius
            through &= np.hypot(place[:, 0], place[:, 1]) <= lens.aperture[k]
            ratio = lens.index_behind[k] / lens.index_before[k]
            cosine = (way * normal).sum(1)
            bent = np.sqrt(1.0 - ratio**2 * (1.0 - cosine**2))
            way = ratio * way + (bent - ratio * cosine)[:, None] * normal
            through &= np.isfinite(way).all(1)
    return place, way, through


def aimed(lens: Lens, film_x: float, film_y: float, count: int = 20000) -> tuple[np.ndarray, np.ndarray]:
    """Rays from a point of the film evenly over the disc that the script aims at: origins and directions."""
    i = np.arange(count)
    distance, turn = AIM * lens.pupil_radius * np.sqrt((i + 0.5) / count), i * np.pi * (3.0 - np.sqrt(5.0))
    target = np.stack(
        [distance * np.cos(turn), distance * np.sin(turn), np.full(count, lens.pupil_z - lens.film_z)], -1
    )
    way = target - (film_x, film_y, 0.0)
    origin = np.broadcast_to((film_x, film_y, lens.film_z), way.shape)
    return origin, way / np.linalg.norm(way, axis=1, keepdims=True)


def exposure(lens: Lens, film_x: float, film_y: float) -> tuple[float, float]:
    """Mean weight of a point of the film before it is normalised, and the part of its rays that are lost."""
    origin, way = aimed(lens, film_x, film_y)
    through = trace(lens, origin, way)[2]
    return float((way[:, 2] ** 4 * through).mean()), float(1.0 - through.mean())


def script(lens: Lens, film_width_mm: float, film_height_mm: float) -> str:
    """OSL. A world of radiance 1 is 1 in the middle of the film."""

    def listed(values: np.ndarray) -> str:
        return "{" + ", ".join(f"{value:.9g}" for value in values) + "}"

    count = len(lens.radius)
    middle = exposure(lens, 0.0, 0.0)[0]
    return f"""\
shader camera(output point position = 0.0, output vector direction = 0.0, output color throughput = 0.0)
{{
  float vertex_z[{count}] = {listed(lens.vertex_z)};
  float radius[{count}] = {listed(lens.radius)};
  float aperture[{count}] = {listed(lens.aperture)};
  float ratio[{count}] = {listed(lens.index_behind / lens.index_before)};

  point raster = camera_shader_raster_position();
  vector chance = camera_shader_random_sample();
  /* The picture stands on its head on the film. */
  point place = point((0.5 - raster[0]) * {film_width_mm:.9g}, (0.5 - raster[1]) * {film_height_mm:.9g}, {lens.film_z:.9g});
  float off_axis = sqrt(chance[0]) * {AIM * lens.pupil_radius:.9g};
  point aim = point(off_axis * cos(M_2PI * chance[1]), off_axis * sin(M_2PI * chance[1]), {lens.pupil_z:.9g});
  vector way = normalize(aim - place);
  float weight = way[2] * way[2];

  for (int k = {count - 1}; k >= 0; k--) {{
    vector facing = vector(0.0, 0.0, -1.0);
    if (radius[k] == 0.0) {{
      place += way * ((vertex_z[k] - place[2]) / way[2]);
    }}
    else {{
      point centre = point(0.0, 0.0, vertex_z[k] + radius[k]);
      vector from_centre = place - centre;
      float along = dot(from_centre, way);
      float radicand = along * along - dot(from_centre, from_centre) + radius[k] * radius[k];
      if (radicand < 0.0)
        return;
      float root = sqrt(radicand);
      place += way * (radius[k] > 0.0 ? root - along : -root - along);
      facing = (place - centre) / radius[k];
    }}
    if (place[0] * place[0] + place[1] * place[1] > aperture[k] * aperture[k])
      return;
    if (ratio[k] != 1.0) {{
      float cosine = dot(way, facing);
      float bent = 1.0 - ratio[k] * ratio[k] * (1.0 - cosine * cosine);
      if (bent < 0.0)
        return;
      way = normalize(ratio[k] * way + (sqrt(bent) - ratio[k] * cosine) * facing);
    }}
  }}
  /* Blender's camera looks along +z here, and stands in the entrance pupil. */
  position = point(place[0], place[1], {lens.entrance_z:.9g} - place[2]) * 1e-3;
  direction = vector(way[0], way[1], -way[2]);
  throughput = color(weight * weight / {middle:.9g});
}}
"""
