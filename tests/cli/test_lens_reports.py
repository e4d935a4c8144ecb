# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens spots|fans|mtf|psf|distortion|illumination`: pictures, and the numbers that they show."""

import json
import struct
from pathlib import Path
from xml.etree import ElementTree

import pytest

pytestmark = pytest.mark.once
LENS = "double-gauss-f2-tronnier"
#: Options by which a report takes less time.
QUICK = {"tolerance": ("--trials", "20")}
REFERENCE = Path(__file__).resolve().parent.parent / "reference"


def reported(petzval_cli, tmp_path, kind, *more, name="report.json"):
    out = tmp_path / name
    done = petzval_cli("lens", kind, *more, "-o", out)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(out))
    return out, done


def numbers(petzval_cli, tmp_path, kind, *more):
    return json.loads(reported(petzval_cli, tmp_path, kind, *more)[0].read_text())


@pytest.mark.parametrize(
    "kind, words",
    [
        ("spots", ["15.4°", "sagittal", "Airy", "RMS"]),
        ("fans", ["22°", "tangential", "place in the stop", "µm"]),
        ("mtf", ["line pairs per mm", "diffraction alone", "20 per mm", "22° tangential"]),
        ("psf", ["Strehl", "sagittal", "light within", "decades", "rays say all"]),
        ("distortion", ["field curvature", "f tan θ", "lateral colour", "486.1 nm"]),
        ("illumination", ["per cent of the middle", "cos⁴", "stops"]),
        (
            "tolerance",
            ["20 lenses", "RMS spot over the fields", "lenses at least as good", "the deviations that do most"],
        ),
    ],
)
def test_a_report_is_a_picture_that_names_what_it_shows(petzval_cli, tmp_path, kind, words):
    out, _ = reported(petzval_cli, tmp_path, kind, LENS, *QUICK.get(kind, ()), name="report.svg")
    text = out.read_text()
    assert ElementTree.fromstring(text).tag.endswith("svg")
    missing = [word for word in ["Tronnier", "f = 100.72 mm", "F/2.03", *words] if word not in text]
    assert not missing
    # No line of the file longer than a reader bears.
    assert len(text) < 400_000
    if kind != "spots":
        # All reports are laid out and written the same way.
        return
    again, _ = reported(petzval_cli, tmp_path, kind, LENS, name="again.svg")
    assert again.read_bytes() == out.read_bytes()
    png, _ = reported(petzval_cli, tmp_path, kind, LENS, name="report.png")
    width, height = struct.unpack(">II", png.read_bytes()[16:24])
    assert width > 900 and height > 500


@pytest.mark.parametrize(
    "kind", ["spots", "fans", "mtf", "psf", "distortion", "illumination", "transmission", "tolerance"]
)
def test_a_report_without_a_picture_prints_its_table(petzval_cli, kind):
    done = petzval_cli("lens", kind, LENS, *QUICK.get(kind, ()))
    assert done.returncode == 0, done.stderr
    title, _, _, headings, *rows = done.stdout.splitlines()
    assert "Tronnier" in title and "F/2.03" in title
    assert len(rows) >= 3 and all(len(row) <= len(max([headings, *rows], key=len)) for row in rows)
    assert any(character.isdigit() for character in rows[0])


def test_a_table_has_the_numbers_of_the_report(petzval_cli):
    printed = petzval_cli("lens", "spots", LENS).stdout.splitlines()[4:]
    found = json.loads(petzval_cli("lens", "spots", LENS, "--json").stdout)
    for row, field in zip(printed, found["defocus"][0]["fields"], strict=True):
        numbers = [float(cell) for cell in row.split()]
        assert numbers[1:4] == pytest.approx([field["angle_deg"], field["rms_mm"], field["largest_mm"]], rel=1e-3)


@pytest.mark.parametrize("name", ["cooke-triplet-50mm", "double-gauss-f2-available"])
def test_deviations_do_what_they_do_in_optiland(petzval_cli, name):
    """One by one, the film left where it was: the spots over the axis and both sides of a field, and the distortion."""
    wanted = json.loads((REFERENCE / "foreign/tolerances.json").read_text())[name]
    lens, asked = REFERENCE / "lenses" / f"{name}.lens", ("--wavelengths", "587.5618", "--fields", "0")
    bfd_mm = json.loads(petzval_cli("lens", "info", lens, "--json").stdout)["bfd_mm"]
    done = petzval_cli(
        "lens", "tolerance", lens, *asked, wanted["field_deg"], f"--film-shift={wanted['film_from_last_vertex_mm'] - bfd_mm}",
        "--pupil-diameter", wanted["pupil_diameter_mm"], "--compensator", "none", "--trials", "2", "--rays", "41", "--json",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    ours = {(one["kind"], one["first"], one["last"]): one for one in found["sensitivities"]}
    nominal = wanted["nominal"]["rms_mm"]
    # Its grid of rays lies in the entrance pupil, ours in the beam before the lens: spots differ by a fifth of a per cent,
    # and small ones by some hundredths of a micrometre.
    assert found["nominal"]["rms_mm"] == pytest.approx(nominal, rel=0.004)
    for theirs in wanted["deviations"]:
        plus, minus = (ours[theirs["kind"], theirs["first"], theirs["last"]][side] for side in ("plus", "minus"))
        assert plus["rms_mm"] == pytest.approx(theirs["rms_mm"], rel=0.004, abs=5e-5), theirs
        assert plus["distortion_percent"] == pytest.approx(theirs["distortion_percent"], rel=1e-4, abs=2e-6), theirs
        if theirs["kind"] in ("decenter_y", "tilt_x"):
            assert minus["rms_mm"] == pytest.approx(plus["rms_mm"], rel=1e-6)
    # Both programs name the same ones as the worst.
    worst = max(wanted["deviations"], key=lambda one: one["rms_mm"])
    first = max(found["sensitivities"], key=lambda one: one["plus"]["rms_mm"])
    assert (first["kind"], first["first"]) == (worst["kind"], worst["first"])


def test_a_negative_number_may_be_written_in_any_way(petzval_cli):
    said = [petzval_cli("lens", "spots", LENS, "--film-shift", text).stdout for text in ("-0.05", "-5e-2", "-.05")]
    assert "film mm" in said[0] and said[0] == said[1] == said[2]


def test_spots_grow_with_defocus_and_shrink_at_best_focus(petzval_cli, tmp_path):
    found = numbers(petzval_cli, tmp_path, "spots", LENS, "--defocus", "-1", "0", "1", "--wavelengths", "587.5618")
    on_axis = [place["fields"][0]["rms_mm"] for place in found["defocus"]]
    # A film 1 mm off shows the cone's section, of radius 1 / 2N and a root mean square of that over the root of 2.
    cone = 1.0 / (2.0 * found["f_number"]) / 2.0**0.5
    assert min(on_axis) == on_axis[1]
    assert on_axis[0] == pytest.approx(cone, rel=0.25) and on_axis[2] == pytest.approx(cone, rel=0.25)
    best = numbers(petzval_cli, tmp_path, "spots", LENS, "--best-focus", "--wavelengths", "587.5618")
    assert best["defocus"][0]["fields"][0]["rms_mm"] < 0.98 * on_axis[1]
    assert best["film_z_mm"] != found["film_z_mm"]


def test_a_stopped_down_lens_is_as_sharp_as_diffraction_lets_it(petzval_cli, tmp_path):
    open_, closed = (
        numbers(petzval_cli, tmp_path, "mtf", LENS, "--f-number", n, "--wavelengths", "550", "--fields", "0")["fields"][
            0
        ]
        for n in ("2.03", "22")
    )
    assert open_["sagittal"]["limit"][-1] > 0.8 > closed["sagittal"]["limit"][-1]
    shortfall = [
        limit - got for limit, got in zip(closed["sagittal"]["limit"], closed["sagittal"]["contrast"], strict=True)
    ]
    assert min(shortfall) > -1e-9 and max(shortfall) < 0.03
    assert open_["sagittal"]["contrast"][-1] < 0.3


def test_a_mirror_makes_airys_pattern_and_blades_make_spikes(petzval_cli, tmp_path):
    asked = ("--f-number", "8", "--wavelengths", "550", "--fields", "0")
    found = numbers(petzval_cli, tmp_path, "psf", "newtonian-f5", *asked)
    field = found["fields"][0]
    assert field["strehl"][0] == pytest.approx(1.0, abs=1e-3)
    # 83.8 % of the light lie in the first dark ring; radii are steps of a fifth of it.
    ring = [part for radius, part in zip(field["radii_mm"], field["encircled"], strict=True)
            if radius <= found["airy_radius_mm"]][-1]  # fmt: skip
    assert ring == pytest.approx(0.838, abs=0.015)
    round_one = field
    six = numbers(petzval_cli, tmp_path, "psf", "newtonian-f5", *asked, "--blades", "6")["fields"][0]
    middle, far = six["side"] // 2, int(0.9 * (six["side"] // 2))
    along = lambda psf, x, y: psf["values"][(middle + y) * psf["side"] + middle + x]  # noqa: E731
    # Corners lie right and left, edges above and below: a spike goes up, none to the right.
    up, right = (max(along(six, *place(d)) for d in range(far - 8, far)) for place in
                 (lambda d: (0, d), lambda d: (d, 0)))  # fmt: skip
    assert up > 20.0 * right
    assert max(along(round_one, 0, d) for d in range(far - 8, far)) < 0.2 * up


def test_fields_of_the_drawing_and_of_the_reports_agree(petzval_cli, tmp_path):
    info = json.loads(petzval_cli("lens", "info", LENS, "--json").stdout)
    found = numbers(petzval_cli, tmp_path, "distortion", LENS, "--fields", "0.01")
    # So near the axis there is no distortion: the height is that of the focal length, to a part in 10⁷.
    assert found["height_by_slope_mm"] == pytest.approx(info["efl_mm"], rel=1e-7)
    assert found["fields"][0]["height_mm"] == pytest.approx(found["fields"][0]["straight_height_mm"], rel=1e-6)
    lit = numbers(petzval_cli, tmp_path, "illumination", LENS, "--f-numbers", "2.03", "8", "--count", "5")
    assert [round(setting["f_number"], 2) for setting in lit] == [2.03, 8.0]
    corner = [setting["fields"][-1]["relative"] for setting in lit]
    assert corner[0] < 0.3 < corner[1]
    # The axis as bright as its cone: π sin² of half of the angle, that of the f-number for a lens without coma.
    for setting in lit:
        n = setting["f_number"]
        assert setting["fields"][0]["projected_sr"] == pytest.approx(3.14159 / (4 * n * n), rel=0.03)


def test_fans_of_paths_and_of_rays(petzval_cli, tmp_path):
    found = numbers(petzval_cli, tmp_path, "fans", LENS, "--fields", "0", "--rays", "5", "--wavelengths", "587.5618")
    fan = found["fields"][0]["tangential"][0]
    middle = fan["pupil"].index(min(fan["pupil"], key=abs))
    assert fan["pupil"][middle] == pytest.approx(0.0, abs=1e-6)
    assert fan["error_mm"][middle] == pytest.approx(0.0, abs=1e-9) and fan["path_waves"][middle] == pytest.approx(
        0, abs=1e-6
    )
    reported(petzval_cli, tmp_path, "fans", LENS, "--path", name="paths.svg")
    assert "waves" in (tmp_path / "paths.svg").read_text()


def test_what_is_dark_or_cannot_be_said_is_named(petzval_cli, tmp_path):
    out, done = reported(petzval_cli, tmp_path, "spots", LENS, "--fields", "0", "60", name="dark.svg")
    assert "note: no light from 60 degrees comes to the film" in done.stderr and ">dark<" in out.read_text()
    for more, words in (
        (["mtf", LENS, "--frequency", "0"], "give more than 0"),
        (["mtf", LENS, "--frequency", "1", "--steps", "1000"], "too near each other"),
        (["fans", LENS, "--rays", "1"], "give 2 to 2000"),
        (["spots", LENS, "--wavelengths", "5"], "wavelength 5 nm"),
        (["distortion", LENS, "--fields", "400"], "give angles from -180 to 180"),
        (["spots", "no-such-lens"], "no-such-lens"),
    ):
        done = petzval_cli("lens", *more, "-o", tmp_path / "x.json")
        assert done.returncode == 1 and done.stderr.count("\n") == 1 and words in done.stderr, done.stderr
    done = petzval_cli("lens", "illumination", LENS, "--f-number", "4", "--f-numbers", "4", "-o", tmp_path / "x.json")
    assert done.returncode == 2 and "leave out the one" in done.stderr
    done = petzval_cli("lens", "mtf", LENS, "-o", tmp_path / "x.gif")
    assert done.returncode == 1 and "change --output" in done.stderr
