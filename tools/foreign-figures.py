# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of two public optical design packages for the lens files in tests/reference/foreign: figures.json there.

Run it in an environment of its own, for it needs neither Blender nor the engine:

    python3 -m venv packages && packages/bin/pip install rayoptics optiland
    packages/bin/python tools/foreign-figures.py

tolerances.json holds the effects of deviations of two of these lenses by optiland, at fields that no rim cuts.

reports.json holds the results of optiland for lenses of tests/reference/lenses: distortion and field curvature, their indices at d as the
reference has them, rays aimed at the stop.

Focal lengths are those at the file's reference wavelength. Rays start 10 units before the first surface; of each the hit on every
surface is kept, in the coordinates of that surface, and the last direction. Lengths are in the file's own units.
"""

from __future__ import annotations

import json
import math
import warnings
from importlib.metadata import version
from pathlib import Path
from typing import Any

warnings.filterwarnings("ignore")

FOLDER = Path(__file__).resolve().parent.parent / "tests" / "reference" / "foreign"
#: Rays: height over the pupil's radius, azimuth and field in degrees.
RAYS = [(0.0, 0.0, 0.0), (0.3, 90.0, 0.0), (0.8, 90.0, 0.0), (0.8, 20.0, 0.0), (0.2, 200.0, 0.15), (0.5, 300.0, 0.3)]
BEFORE = 10.0
#: Lenses whose deviations are tried: the field in degrees, and the part of the pupil to which they are stopped down, so that no rim cuts
#: their beams, and their pupils have little aberration.
TOLERANCED = {"cooke-triplet-50mm": (5.0, 0.8), "double-gauss-f2-available": (3.0, 0.4)}


def by_rayoptics(path: Path) -> dict:
    """Focal lengths and rays."""
    from rayoptics.gui import appcmds
    from rayoptics.raytr import raytrace

    model = appcmds.open_model(str(path))
    model.update_model()
    sequence, specification = model["seq_model"], model["optical_spec"]
    first_order = model["analysis_results"]["parax_data"].fod
    wavelength = specification["wvls"].central_wvl
    figures = {
        "wavelength_nm": wavelength,
        "efl": float(first_order.efl),
        "bfl": float(first_order.bfl),
        "entrance_pupil_radius": float(first_order.enp_radius),
        "rays": [],
    }
    pupil = float(first_order.enp_radius)
    sequence.gaps[0].thi = BEFORE
    sequence.update_model()
    for height, azimuth, field in RAYS:
        turn, tilt = math.radians(azimuth), math.radians(field)
        start = [height * pupil * math.cos(turn), height * pupil * math.sin(turn), 0.0]
        direction = [0.0, math.sin(tilt), math.cos(tilt)]
        import numpy as np

        ray, _, _ = raytrace.trace(sequence, np.array(start), np.array(direction), wavelength, check_apertures=False)
        figures["rays"].append(
            {
                "origin": [start[0], start[1], -BEFORE],
                "direction": direction,
                "hits": [[float(x) for x in segment[0]] for segment in ray[1:-1]],
                "out": [float(x) for x in ray[-2][1]],
            }
        )
    return figures


def _spot(optic: Any, part: float) -> dict:
    """The spot at a part of the field: of rays to the middle of the paraxial entrance pupil and six rings in it, the last at 0.95 of its
    radius."""
    import numpy as np

    places = [(0.0, 0.0)]
    for ring in range(1, 7):
        turns = np.arange(6 * ring) * (2.0 * math.pi / (6 * ring))
        places += [(0.95 * ring / 6.0 * math.cos(turn), 0.95 * ring / 6.0 * math.sin(turn)) for turn in turns]
    x, y = (np.array(values) for values in zip(*places, strict=True))
    rays = optic.trace_generic(0.0, part, x, y, float(optic.primary_wavelength))
    x, y = np.asarray(rays.x), np.asarray(rays.y)
    distances = np.hypot(x - x.mean(), y - y.mean())
    return {
        "field_deg": part * float(optic.fields.max_field),
        "rms": float(np.sqrt((distances**2).mean())),
        "largest": float(distances.max()),
    }


def by_optiland(path: Path) -> dict:
    """Focal lengths of the lenses that it reads, and spots on the axis and at half of the field, of 127 rays."""
    from optiland import fileio

    read = {".zmx": "load_zemax_file", ".len": "load_oslo_file", ".seq": "load_codev_file"}[path.suffix]
    optic = getattr(fileio, read)(str(path))
    figures = {
        "wavelength_nm": float(optic.primary_wavelength) * 1000.0,
        "efl": float(optic.paraxial.f2()),
        "entrance_pupil_radius": float(optic.paraxial.EPD()) / 2.0,
    }
    spots = [_spot(optic, part) for part in (0.0, 0.5)]
    # It loses rays where it has not understood the file.
    if all(math.isfinite(value) for spot in spots for value in spot.values()):
        figures["spots"] = spots
    return figures


def write_oslo() -> None:
    """A lens as optiland writes it for OSLO: its triplet after Cooke."""
    from optiland import fileio
    from optiland.samples.objectives import CookeTriplet

    fileio.save_oslo_file(CookeTriplet(), str(FOLDER / "cooke.len"))


def _read(name: str) -> tuple[list[list[str]], list[float], float]:
    """The rows of a lens of the reference data, its indices at d, and the diameter of its entrance pupil."""
    reference = FOLDER.parent
    lines = (reference / "lenses" / f"{name}.lens").read_text().splitlines()
    rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    indices = json.loads((reference / "rays" / f"{name}.json").read_text())["n"]["d"]
    pupil = float(json.loads((reference / "paraxial.json").read_text())[name]["d"]["enp_diameter"])
    return rows, [float(index) for index in indices], pupil


def _built(rows: list[list[str]], indices: list[float], pupil: float, field_deg: float) -> Any:
    """A lens in optiland, its rays aimed at the stop."""
    import numpy as np
    from optiland.materials import IdealMaterial
    from optiland.optic import Optic

    optic = Optic()
    optic.add_surface(index=0, thickness=np.inf)
    for i, (row, index) in enumerate(zip(rows, indices, strict=True), start=1):
        optic.add_surface(
            index=i, radius=float(row[0]) or np.inf, thickness=float(row[1]), conic=float(row[4]),
            material=IdealMaterial(float(index)), is_stop=row[5] == "1",
        )  # fmt: skip
    optic.add_surface(index=len(rows) + 1)
    optic.set_aperture("EPD", pupil)
    optic.set_field_type("angle")
    for field in (0.0, field_deg):
        optic.add_field(y=field)
    optic.add_wavelength(0.5875618, is_primary=True)
    optic.set_ray_aiming("iterative")
    return optic


def _stopped_down(rows: list[list[str]], indices: list[float], pupil: float, stop_mm: float, field_deg: float) -> Any:
    """A lens whose diaphragm has a diameter of its own, whatever becomes of its entrance pupil."""
    optic = _built(rows, indices, pupil, field_deg)
    optic.surface_group.surfaces[optic.surface_group.stop_index].set_semi_aperture(0.5 * stop_mm)
    optic.set_aperture("float_by_stop_size", stop_mm)
    return optic


def _measured(optic: Any) -> dict:
    """Root mean square spot over the axis and both sides of the field, and the distortion, of a lens whose elements may be out of place."""
    import numpy as np

    side = 41
    at = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    x, y = (axis.ravel() for axis in np.meshgrid(at, at))
    inside = x * x + y * y <= 1.0
    nm = float(optic.primary_wavelength)

    def square(part: float) -> float:
        rays = optic.trace_generic(0.0, part, x[inside], y[inside], nm)
        across, up = np.asarray(rays.x), np.asarray(rays.y)
        return float(((across - across.mean()) ** 2 + (up - up.mean()) ** 2).mean())

    def height(part: float) -> float:
        return float(np.asarray(optic.trace_generic(0.0, part, 0.0, 0.0, nm).y).ravel()[0])

    field_deg, little = float(optic.fields.max_field), 1e-3
    slopes = [
        (height(part) - height(-part)) / math.tan(math.radians(part * field_deg)) for part in (1.0, little / field_deg)
    ]
    return {
        "rms_mm": math.sqrt(sum(square(part) for part in (0.0, 1.0, -1.0)) / 3.0),
        "distortion_percent": 100.0 * (slopes[0] / slopes[1] - 1.0),
    }


#: Deviations as `petzval lens tolerance` has them by default.
RADIUS, THICKNESS_MM, INDEX, DECENTER_MM, TILT_DEG = 1.001, 0.05, 0.0005, 0.03, 0.0167


def tolerances_by_optiland(name: str, field_deg: float, part: float) -> dict:
    """The effects of deviations of radii, thicknesses and indices on a lens of the reference data, and of elements out of place, its film
    left where it was. Elements are runs of surfaces with glass between them."""
    rows, indices, pupil = _read(name)
    pupil *= part
    nominal = _built(rows, indices, pupil, field_deg)
    heights, _ = nominal.paraxial.marginal_ray()
    stop_mm = 2.0 * abs(float(heights[nominal.surface_group.stop_index].item()))
    found = []

    def built(rows: list[list[str]], indices: list[float]) -> Any:
        return _stopped_down(rows, indices, pupil, stop_mm, field_deg)

    def add(kind: str, first: int, last: int, optic: Any) -> None:
        found.append({"kind": kind, "first": first, "last": last, **_measured(optic)})

    def with_row(i: int, column: int, change: Any) -> list[list[str]]:
        changed = [list(row) for row in rows]
        changed[i][column] = repr(change(float(changed[i][column])))
        return changed

    for i in range(len(rows)):
        if float(rows[i][0]):
            add("radius", i, i, built(with_row(i, 0, lambda r: r * RADIUS), indices))
        if i + 1 < len(rows):
            add("thickness", i, i, built(with_row(i, 1, lambda t: t + THICKNESS_MM), indices))
        if indices[i] != 1.0:
            other = [index + INDEX * (k == i) for k, index in enumerate(indices)]
            add("index", i, i, built(rows, other))
    first = None
    for i, index in enumerate(indices):
        if index != 1.0:
            first = i if first is None else first
        elif first is not None:
            for kind in ("decenter_y", "tilt_x"):
                optic, behind = built(rows, indices), 0.0
                turn = math.radians(TILT_DEG)
                for k in range(first, i + 1):
                    place = optic.surface_group.surfaces[k + 1].geometry.cs
                    if kind == "decenter_y":
                        place.y = place.y + DECENTER_MM
                    else:
                        place.rx = place.rx + turn
                        place.y = place.y - behind * math.sin(turn)
                        place.z = place.z - behind * (1.0 - math.cos(turn))
                    behind += float(rows[k][1])
                add(kind, first, i, optic)
            first = None
    return {
        "film_from_last_vertex_mm": float(rows[-1][1]),
        "field_deg": field_deg,
        "pupil_diameter_mm": pupil,
        "nominal": _measured(built(rows, indices)),
        "deviations": found,
    }


def report_by_optiland(name: str, field_deg: float) -> dict:
    """Distortion in per cent and the foci behind the film, over evenly spaced fields, of a lens of the reference data."""
    import numpy as np
    from optiland.analysis import Distortion, FieldCurvature

    rows, indices, pupil = _read(name)
    optic = _built(rows, indices, pupil, field_deg)
    count = 6
    curvature = np.array(FieldCurvature(optic, wavelengths=[0.5875618], num_points=count).data)[0]
    return {
        "wavelength_nm": 587.5618,
        "film_from_last_vertex_mm": float(rows[-1][1]),
        "fields_deg": [field_deg * i / (count - 1) for i in range(count)],
        "distortion_percent": np.array(Distortion(optic, wavelengths=[0.5875618], num_points=count).data)
        .ravel()
        .tolist(),
        "tangential_focus_mm": curvature[0].tolist(),
        "sagittal_focus_mm": curvature[1].tolist(),
    }


def main() -> None:
    lenses = {
        "cooke-triplet-50mm": 14.0,
        "petzval-kodak": 8.0,
        "double-gauss-f2-available": 10.0,
        "tessar-brendel": 15.0,
    }
    reports = {name: report_by_optiland(name, field) for name, field in lenses.items()}
    reports["_packages"] = {"optiland": version("optiland")}
    (FOLDER / "reports.json").write_text(json.dumps(reports, indent=1) + "\n")
    tolerances: dict[str, Any] = {name: tolerances_by_optiland(name, *how) for name, how in TOLERANCED.items()}
    tolerances["_packages"] = {"optiland": version("optiland")}
    (FOLDER / "tolerances.json").write_text(json.dumps(tolerances, indent=1) + "\n")
    write_oslo()
    figures = {"_packages": {name: version(name) for name in ("rayoptics", "optiland")}}
    for path in sorted(FOLDER.glob("*.*")):
        if path.suffix not in (".zmx", ".seq", ".len"):
            continue
        entry = {}
        for name, of in (("rayoptics", by_rayoptics), ("optiland", by_optiland)):
            try:
                entry[name] = of(path)
            except Exception as error:  # noqa: BLE001 - whatever a package cannot read it says nothing about
                print(f"{path.name}: {name}: {type(error).__name__}: {error}")
        figures[path.name] = entry
        print(path.name, {name: round(values["efl"], 6) for name, values in entry.items()})
    (FOLDER / "figures.json").write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
