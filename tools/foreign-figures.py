# SPDX-License-Identifier: GPL-3.0-or-later
"""What two public optical design packages make of the lens files in tests/reference/foreign: figures.json there.

Run it in an environment of its own, for it needs neither Blender nor the engine:

    python3 -m venv packages && packages/bin/pip install rayoptics optiland
    packages/bin/python tools/foreign-figures.py

reports.json holds what optiland says of lenses of tests/reference/lenses: distortion and field curvature, their indices at d as the
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
    """Of a part of the field: of rays to the middle of the paraxial entrance pupil and six rings in it, the last at 0.95 of its radius."""
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
    """Focal lengths, of what it reads, and spots on the axis and at half of the field, of 127 rays."""
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


def report_by_optiland(name: str, field_deg: float) -> dict:
    """Distortion in per cent and the foci behind the film, over evenly spaced fields, of a lens of the reference data."""
    import numpy as np
    from optiland.analysis import Distortion, FieldCurvature
    from optiland.materials import IdealMaterial
    from optiland.optic import Optic

    reference = FOLDER.parent
    lines = (reference / "lenses" / f"{name}.lens").read_text().splitlines()
    rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    indices = json.loads((reference / "rays" / f"{name}.json").read_text())["n"]["d"]
    pupil = float(json.loads((reference / "paraxial.json").read_text())[name]["d"]["enp_diameter"])
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
