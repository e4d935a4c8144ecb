# SPDX-License-Identifier: GPL-3.0-or-later
"""Choosing a lens in the panel: favourites, search, pictures, files of other programs; and the live drawing."""

from __future__ import annotations

import json
from math import atan2, cos, hypot, sin

import numpy as np
import pytest

from petzval import _native
from support.photograph.chart import LENSES


@pytest.fixture
def scene(parts):
    made = parts.set_up(model="LENS")
    made.camera.data.petzval.lens_file = "double-gauss-f2-tronnier.lens"
    return made


# Favourites --------------------------------------------------------------------------------------------------------


def test_a_favourite_is_kept_for_every_file(blender, parts, scene, tmp_path, monkeypatch):
    favourites, gallery = parts.part("data.favourites"), parts.part("ui.lens_gallery")
    monkeypatch.setattr(blender.utils, "user_resource", lambda *_, **__: str(tmp_path))
    favourites.load()
    own = scene.camera.data.petzval
    assert blender.ops.petzval.favourite_lens() == {"FINISHED"}
    own.lens_file = str(LENSES / "cooke-triplet-50mm.lens")
    blender.ops.petzval.favourite_lens()
    favourites.load()
    wanted = ["double-gauss-f2-tronnier.lens", str(LENSES / "cooke-triplet-50mm.lens")]
    assert favourites.all_of_them() == wanted
    assert [gallery.key_of(entry) for entry in gallery.chosen("FAVOURITES", "")] == wanted
    # A name without its ending is the same lens.
    own.lens_file = "double-gauss-f2-tronnier"
    blender.ops.petzval.favourite_lens()
    favourites.load()
    assert favourites.all_of_them() == wanted[1:]
    assert blender.ops.petzval.set_lens(lens=wanted[0]) == {"FINISHED"} and own.lens_file == wanted[0]


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"lenses": 3}', '{"lenses": [1, null]}'])
def test_a_file_of_favourites_that_is_none_of_ours_is_none(blender, parts, tmp_path, monkeypatch, text):
    favourites = parts.part("data.favourites")
    (tmp_path / "favourite-lenses.json").write_text(text)
    monkeypatch.setattr(blender.utils, "user_resource", lambda *_, **__: str(tmp_path))
    favourites.load()
    assert favourites.all_of_them() == []


# The gallery -------------------------------------------------------------------------------------------------------


def test_lenses_are_found_by_name_group_and_focal_length(blender, parts):
    gallery, files = parts.part("ui.lens_gallery"), parts.part("data.lens_files")

    def ids(words, group="ALL"):
        return {entry["id"] for entry in gallery.chosen(group, words)}

    everything = ids("")
    assert everything == {path.stem for path in LENSES.glob("*.lens")}
    assert ids("NIKKOR 28 F/1.4") == {"nikkor-28-f1.4"} == ids("wide 28.41 mm")
    assert ids("100mm tessar") == {"tessar-100-f3.5"} or len(ids("100mm tessar")) == 1
    assert ids("no such words") == set()
    for group in files.groups():
        assert ids("", group) == {entry["id"] for entry in files.shipped() if entry["group"] == group}
        assert ids(group) >= ids("", group)
    # So does Blender's own search, which looks at names alone.
    items = {key: name for key, name, _ in parts.part("operators.common")._shipped_items(None, None)}
    assert "wide angle, 28.41 mm, f/1.45" in items["nikkor-28-f1.4.lens"]


@pytest.mark.once
def test_every_lens_has_a_thumbnail(blender, parts):
    """Something is drawn in the middle, nothing at the corners' very edge, colours never beyond their coverage."""
    thumbnails, files = parts.part("drawing.thumbnails"), parts.part("data.lens_files")
    for entry in files.shipped():
        picture = thumbnails.pixels(files.file_name(entry))
        assert picture.shape == (thumbnails.SIDE_PX, thumbnails.SIDE_PX, 4) and np.isfinite(picture).all()
        assert 0.01 < (picture[..., 3] > 0.1).mean() < 0.9, entry["id"]
        assert (picture[..., :3] <= picture[..., 3:] + 1e-5).all() and picture.min() >= 0.0 and picture.max() <= 1.0


def test_a_thumbnail_is_drawn_by_the_timer(blender, parts):
    thumbnails = parts.part("drawing.thumbnails")
    thumbnails.forget()
    key, missing = "cooke-triplet-50mm.lens", "no-such.lens"
    thumbnails.icon(key)
    thumbnails.icon(missing)
    assert blender.app.timers.is_registered(thumbnails._draw_some)
    blender.app.timers.unregister(thumbnails._draw_some)
    thumbnails.icon(key)
    assert blender.app.timers.is_registered(thumbnails._draw_some)
    while thumbnails._draw_some() is not None:
        pass
    blender.app.timers.unregister(thumbnails._draw_some)
    kept = np.array(thumbnails._icons[key].image_pixels_float[:]).reshape(thumbnails.SIDE_PX, thumbnails.SIDE_PX, 4)
    # Blender keeps a byte a channel.
    assert np.abs(kept - thumbnails.pixels(key)).max() < 1.1 / 255.0
    assert missing not in thumbnails._icons
    thumbnails.icon(missing)
    assert not blender.app.timers.is_registered(thumbnails._draw_some), "it would fail again and again"


# Files of other programs -------------------------------------------------------------------------------------------


def test_a_lens_file_is_imported(blender, parts, scene, tmp_path):
    own = scene.camera.data.petzval
    text, _ = _native.Lens(str(LENSES / "cooke-triplet-50mm.lens")).written("zmx")
    (tmp_path / "triplet.zmx").write_text(text)
    assert blender.ops.petzval.import_lens(filepath=str(tmp_path / "triplet.zmx")) == {"FINISHED"}
    assert own.lens_file == str(tmp_path / "triplet.zmx")
    info = parts.part("queries.lens_info").of_camera(scene.camera, scene)
    assert info["efl_mm"] == pytest.approx(50.0, rel=0.02)
    # Beside a saved file by its relative path.
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    blender.ops.petzval.import_lens(filepath=str(tmp_path / "triplet.zmx"))
    assert own.lens_file == "//triplet.zmx"
    before = own.lens_file
    (tmp_path / "broken.zmx").write_text("SURF nothing")
    with pytest.raises(RuntimeError, match=r"broken\.zmx"):
        blender.ops.petzval.import_lens(filepath=str(tmp_path / "broken.zmx"))
    assert own.lens_file == before


def test_all_endings_that_the_engine_reads_are_asked_for(blender, parts):
    operators = parts.part("operators.lens")
    glob = blender.ops.petzval.import_lens.get_rna_type().properties["filter_glob"].default
    assert glob.split(";") == [f"*{ending}" for ending in operators.ENDINGS]
    for ending in operators.PETZVAL_FH_lens.bl_file_extensions.split(";"):
        assert ending in operators.ENDINGS


# The canvas --------------------------------------------------------------------------------------------------------


def canvas(parts, width=64, height=48, view=(0.0, 64.0, 0.0, 48.0), fine=4):
    return parts.part("drawing.canvas").Canvas(width, height, view, fine)


def test_a_polygon_covers_its_area(blender, parts):
    made = canvas(parts)
    made.fill([[[10.25, 5.0], [50.75, 12.5], [40.0, 40.0], [8.0, 33.0]]], (1.0, 0.5, 0.25, 1.0))
    x, y = np.array([10.25, 50.75, 40.0, 8.0]), np.array([5.0, 12.5, 40.0, 33.0])
    area = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    # A rim of about 110 pixels, each known to a sixteenth.
    assert made.pixels[..., 3].sum() == pytest.approx(area, rel=0.01)
    assert made.pixels[20, 30] == pytest.approx([1.0, 0.5, 0.25, 1.0])
    assert not made.pixels[0].any() and not made.pixels[:, 63].any()


def test_a_polygon_with_a_hole_by_crossing_itself_is_even_and_odd(blender, parts):
    made = canvas(parts)
    made.fill(
        [[[5, 5], [55, 5], [55, 45], [5, 45], [5, 5], [20, 15], [40, 15], [40, 35], [20, 35], [20, 15]]], (1, 1, 1, 1)
    )
    assert made.pixels[10, 10, 3] == 1.0 and made.pixels[25, 30, 3] == 0.0
    assert made.pixels[..., 3].sum() == pytest.approx(50 * 40 - 20 * 20, rel=0.01)


def test_a_line_is_as_wide_as_asked_and_may_leave_the_picture(blender, parts):
    made = canvas(parts, fine=4)
    made.draw([[[-1e9, 24.0], [10.0, 24.0], [90.0, 24.0]]], (0, 0, 1, 1), 3.0)
    assert made.pixels[:, 40, 3].sum() == pytest.approx(3.0, abs=0.6)
    assert made.pixels[24, 5, 3] == 0.0, "a ray that misses everything is left out"
    made.draw([[[float("nan"), 0.0], [5.0, 5.0]]], (0, 0, 1, 1), 1.0)
    assert np.isfinite(made.pixels).all()


# The live drawing --------------------------------------------------------------------------------------------------


def drawing(parts, scene):
    return parts.part("drawing.live_drawing").of_camera(scene.camera, scene)


def test_the_drawing_is_of_the_lens_as_it_is_set(parts, scene):
    own = scene.camera.data.petzval
    before = drawing(parts, scene)
    own.focal_mode, own.focal_length = "LENGTH", 50.0
    own.wide_open, own.f_number = False, 8.0
    after = drawing(parts, scene)
    assert before["efl_mm"] != pytest.approx(50.0, rel=0.1) and after["efl_mm"] == pytest.approx(50.0, rel=1e-6)
    assert after["entrance_pupil"]["diameter_mm"] == pytest.approx(50.0 / 8.0, rel=1e-6)
    info = parts.part("queries.lens_info").of_camera(scene.camera, scene)
    half = np.degrees(info["fov_diagonal_rad"]) / 2.0
    assert [field["angle_deg"] for field in after["fields"]] == pytest.approx([0.0, 0.7 * half, half])


@pytest.mark.parametrize("focus", ["DISTANCE", "INFINITY", "FILM"])
def test_rays_and_film_meet_where_the_film_stands(parts, scene, focus):
    """The axis' rays meet at the film when the lens is focused; turned and shifted, all of them end on its plane."""
    own = scene.camera.data.petzval
    scene.camera.data.dof.focus_distance = 0.8
    own.film_distance = parts.part("queries.lens_info").of_camera(scene.camera, scene)["film_distance_mm"] * 1.02
    own.focus_mode = {"DISTANCE": "CAMERA"}.get(focus, focus)
    info = parts.part("queries.lens_info").of_camera(scene.camera, scene)
    found = drawing(parts, scene)
    ends = np.array([ray[-1] for ray in found["fields"][0]["rays"]])
    assert ends[:, 0] == pytest.approx(info["film_z_mm"], abs=1e-9)
    # Wide open at f/2, spherical aberration spreads them by some tenths of a millimetre.
    assert np.abs(ends[:, 1]).max() < 0.5
    own.tilt, own.shift_y = 0.3, 4.0
    turned = drawing(parts, scene)
    (z0, y0), (z1, y1) = turned["film"]
    assert hypot(z1 - z0, y1 - y0) == pytest.approx(hypot(info["picture_width_mm"], info["picture_height_mm"]))
    assert atan2(z1 - z0, y1 - y0) == pytest.approx(0.3)
    # Blender keeps the angle in f32.
    for field in turned["fields"]:
        for z, y in (ray[-1] for ray in field["rays"]):
            assert (z - info["film_z_mm"]) * cos(0.3) - y * sin(0.3) == pytest.approx(0.0, abs=1e-5)
    # The lens went up, so the film's middle is below the axis.
    assert (y0 + y1) / 2.0 == pytest.approx(-4.0 * cos(0.3))


def test_glass_stop_and_film_are_where_they_are(parts, scene):
    lens_drawing = parts.part("drawing.lens_drawing")
    found = drawing(parts, scene)
    for field in found["fields"]:
        field["rays"] = []
    found["film"] = [[found["film_z_mm"], -10.0], [found["film_z_mm"], 10.0]]
    side = 400
    picture = lens_drawing.picture(found, side, side)
    left, right, low, high = lens_drawing.with_shape(lens_drawing.view_of(found), 1.0)

    def at(z, y):
        return picture[int((y - low) / (high - low) * side), int((z - left) / (right - left) * side), 3]

    first, second = found["surfaces"][0]["points"], found["surfaces"][1]["points"]
    middle = (first[32][0] + second[32][0]) / 2.0
    assert at(middle, 3.0) > 0.3, "glass"
    assert at(first[32][0] - 5.0, 3.0) == 0.0, "nothing before the lens"
    assert at(found["film_z_mm"], 5.0) > 0.5


def test_the_timer_draws_once_for_each_setting(blender, parts, scene, monkeypatch):
    import time

    live = parts.part("drawing.live_drawing")
    live.forget()
    place = scene.camera, scene, blender.context.view_layer, 200
    assert live.for_panel(*place) is None and blender.app.timers.is_registered(live._draw)
    # Opening a file takes timers away.
    blender.app.timers.unregister(live._draw)
    assert live.for_panel(*place) is None and blender.app.timers.is_registered(live._draw)
    now = time.monotonic()
    monkeypatch.setattr(live.time, "monotonic", lambda: now + 1.0)
    assert live._draw() is None
    drawn = live.for_panel(*place)
    assert drawn.is_current and not drawn.error and len(drawn.fields) == 3 and not live._wanted
    scene.camera.data.petzval.wide_open = False
    assert not live.for_panel(*place).is_current
    # Another size does not take turns with it.
    live.for_panel(*place[:3], 300)
    monkeypatch.setattr(live.time, "monotonic", lambda: now + 2.0)
    assert live._draw() is None and live.for_panel(*place).is_current and live.for_panel(*place[:3], 300).is_current
    # The camera may go anywhere.
    scene.camera.location.x += 1.0
    blender.context.view_layer.update()
    assert live.for_panel(*place).is_current
    for size in range(400, 410):
        live.for_panel(*place[:3], size)
    monkeypatch.setattr(live.time, "monotonic", lambda: now + 3.0)
    live._draw()
    assert len(live._kept) == 4
    scene.camera.data.petzval.lens_file = "no-such.lens"
    live.for_panel(*place)
    monkeypatch.setattr(live.time, "monotonic", lambda: now + 4.0)
    live._draw()
    assert "no-such.lens" in live.for_panel(*place).error
    blender.app.timers.unregister(live._draw)
    assert json.dumps(live.for_panel(*place).fields) == "[]"


# Through the lens --------------------------------------------------------------------------------------------------


def project(parts, blender, scene, model=None):
    """Where the picture's corners look, in the camera's axes: by the engine's lens where there is one, by Blender's camera."""
    import numpy as np

    holder = scene.camera
    frame = holder.data.view_frame(scene=scene)
    corners = np.array([tuple(corner) for corner in frame])
    return corners / -corners[:, 2:]


@pytest.mark.parametrize("model", ["LENS", "PARAXIAL", "THICK", "IMAGE_BASED"])
@pytest.mark.parametrize("shift", [0.0, 4.0])
def test_without_the_lens_the_framing_stays(blender, parts, scene, model, shift):
    """The corners' directions of Blender's camera and of the engine's info agree to a pixel, and the model comes back."""
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    own = scene.camera.data.petzval
    own.model, own.shift_x, own.film_mode = model, shift, "SIZE"
    info = parts.part("queries.lens_info").of_camera(scene.camera, scene)
    # As someone has set it by hand meanwhile.
    scene.camera.data.lens, scene.camera.data.shift_x = 17.0, 0.3
    own.through_lens = False
    assert own.model == "PINHOLE" and not own.through_lens
    described = parts.part("export.camera").describe(
        scene.camera, scene, 960, 540, parts.part("export.report").Report()
    )
    assert described.model == "PINHOLE"
    seen = project(parts, blender, scene)
    slope = info["picture_width_mm"] / info["viewport_focal_length_mm"]
    wanted = slope * (np.array([0.5, -0.5]) + info["viewport_shift"][0])
    pixel = slope / 960
    assert sorted([seen[:, 0].max(), seen[:, 0].min()]) == pytest.approx(sorted(wanted), abs=pixel)
    own.through_lens = True
    assert own.model == model
    again = parts.part("queries.lens_info").of_camera(scene.camera, scene)
    assert again == info


def test_the_picture_without_the_lens_shows_the_same_place(blender, parts, scene, tmp_path):
    """Rendered: a bright square's edges stand where they stood, to a pixel."""
    own = scene.camera.data.petzval
    own.wide_open, own.f_number, own.focus_mode = False, 16.0, "CAMERA"
    scene.camera.data.dof.focus_distance = 5.0
    scene.render.resolution_x, scene.render.resolution_y = 192, 128
    scene.petzval.samples, scene.world = 16, parts.grey_world(0.0)
    parts.square("Square", (0.2, 5.0, 0.1), 0.6, parts.emitter())
    seen = []
    for through in (True, False):
        own.through_lens = through
        picture = parts.render(tmp_path)[..., 1]
        columns, rows = np.flatnonzero(picture.max(axis=0) > 0.5), np.flatnonzero(picture.max(axis=1) > 0.5)
        seen.append([columns[0], columns[-1], rows[0], rows[-1]])
    assert np.abs(np.subtract(*seen)).max() <= 1, seen


@pytest.mark.parametrize("kind", ["keys", "driver"])
def test_the_switch_can_be_animated(blender, parts, scene, kind):
    camera = scene.camera.data
    own = camera.petzval
    own.model = "THICK"
    lens = camera.lens
    if kind == "keys":
        own.keyframe_insert("through_lens", frame=1)
        own.through_lens = False
        own.keyframe_insert("through_lens", frame=5)
    else:
        own.driver_add("through_lens").driver.expression = "frame < 5"
    for frame, model in ((1, "THICK"), (4, "THICK"), (5, "PINHOLE"), (9, "PINHOLE"), (2, "THICK")):
        scene.frame_set(frame)
        evaluated = scene.camera.evaluated_get(blender.context.evaluated_depsgraph_get())
        report = parts.part("export.report").Report()
        assert parts.part("export.camera").describe(evaluated, scene, 48, 32, report).model == model, frame
        assert own.model == model and camera.lens == pytest.approx(lens, rel=1e-4)


def test_a_pinhole_that_was_chosen_turns_into_the_last_lens(blender, parts, scene):
    own = scene.camera.data.petzval
    own.model = "PARAXIAL"
    own.model = "THIN"
    assert not own.through_lens
    own.through_lens = True
    assert own.model == "PARAXIAL"
