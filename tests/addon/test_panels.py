# SPDX-License-Identifier: GPL-3.0-or-later
"""Every panel draws in every setting; what of Blender's and Cycles's settings is read can be seen; all of it has words.

The window's own drawing is in test_window.py: here a layout that only notes stands for it, in every Blender.
"""

from __future__ import annotations

import json
import re
from types import SimpleNamespace

import pytest

MODELS = ("LENS", "IMAGE_BASED", "PARAXIAL", "THICK", "THIN", "PINHOLE", "CALIBRATED")


@pytest.fixture
def layout(blender):
    from support import panel_layout

    return panel_layout


# Drawing -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("focus", ["CAMERA", "AUTO", "FILM", "INFINITY"])
def test_the_cameras_panels(blender, parts, layout, model, focus):
    scene = parts.set_up(model=model)
    own = scene.camera.data.petzval
    own.focus_mode = focus
    now = layout.context(camera=scene.camera.data, object=scene.camera)
    drawn = layout.draw("data", now)
    assert ("Camera", "clip_start") in drawn.shown and ("PetzvalCamera", "through_lens") in drawn.shown
    assert {("PetzvalCamera", name) for name in ("use_sensor", "sensor", "raw_file")} <= set(drawn.shown)
    assert (("PetzvalCamera", "lens_file") in drawn.shown) == (model not in ("THIN", "PINHOLE", "CALIBRATED"))
    # With all that opens further rows.
    own.film_mode, own.focal_mode, own.spectrum, own.wide_open, own.scale_locked = (
        "SIZE",
        "LENGTH",
        "SINGLE",
        False,
        False,
    )
    scene.camera.data.type = "ORTHO"
    drawn = layout.draw("data", now)
    assert ("Camera", "ortho_scale") in drawn.shown
    # A camera that is in no scene, a lens that is not there.
    layout.draw("data", layout.context(camera=blender.data.cameras.new("Alone")))
    own.lens_file = "no-such.lens"
    layout.draw("data", now)


def test_every_setting_of_a_panorama_can_be_seen(blender, parts, layout):
    """All that Blender's camera has for its projections, each with its projection."""
    scene = parts.set_up(model="THIN")
    camera = scene.camera.data
    camera.type = "PANO"
    seen = {}
    for kind in [item.identifier for item in camera.bl_rna.properties["panorama_type"].enum_items]:
        camera.panorama_type = kind
        drawn = layout.draw("data", layout.context(camera=camera, object=scene.camera))
        seen[kind] = {name for owner, name in drawn.shown if owner == "Camera"}
    words = ("panorama", "fisheye", "latitude", "longitude", "central_cylindrical")
    wanted = {one.identifier for one in camera.bl_rna.properties if one.identifier.startswith(words)}
    assert len(wanted) > 15 and wanted <= set().union(*seen.values())
    assert "fisheye_fov" not in seen["EQUIRECTANGULAR"] and {"lens", "shift_x"} <= seen["MIRRORBALL"]
    camera.petzval.model = "LENS"
    assert any("panoramic" in text for text in layout.draw("data", layout.context(camera=camera)).said)


def test_a_missing_lens_is_told_where_it_is_chosen(blender, parts, layout):
    """In the Lens panel itself, which is open: drawing and data, which say why they are empty, are closed at first."""
    scene = parts.set_up(model="LENS")
    scene.camera.data.petzval.lens_file = "no-such.lens"
    whole = layout.Layout()
    cls = parts.part("ui.camera").PETZVAL_CAMERA_PT_lens
    cls.draw(SimpleNamespace(layout=whole), layout.context(camera=scene.camera.data, object=scene.camera))
    assert "no such lens: no-such.lens" in " ".join(whole.said)


def test_a_calibration_is_told_of_where_it_is_chosen(blender, parts, layout):
    """Its camera, if there are several, what it leaves black, and what is wrong with it; blur has its panels when it is on."""
    from support.places import ROOT

    scene = parts.set_up(model="CALIBRATED")
    camera = scene.camera.data
    own = camera.petzval

    def drawn():
        return layout.draw("data", layout.context(camera=camera, object=scene.camera))

    assert any("no calibration" in text for text in drawn().said)
    own.calibration_file = str(ROOT / "tests/reference/calibrations/cameras.txt")
    whole = drawn()
    assert {("PetzvalCamera", "calibration_file"), ("PetzvalCamera", "calibration_camera")} <= set(whole.shown)
    assert any("choose one of 1, 2, 3, 4" in " ".join(whole.said) for _ in (0,))
    assert ("PetzvalCamera", "f_number") not in whole.shown and (
        "PetzvalCamera",
        "physical_exposure",
    ) not in whole.shown
    own.calibration_camera = "4"
    assert "of the picture is black" in " ".join(drawn().said)
    own.calibration_camera, camera.dof.use_dof = "2", True
    whole = drawn()
    assert "opencv" in whole.said and "96 x 64" in whole.said and not any("black" in text for text in whole.said)
    assert ("CameraDOFSettings", "aperture_fstop") in whole.shown and (
        "CameraDOFSettings",
        "focus_distance",
    ) in whole.shown
    search = parts.part("settings.camera")._cameras_in_file
    assert search(own, blender.context, "") == ["1", "2", "3", "4"]


def test_a_lens_of_lensfun_is_told_of(blender, parts, layout):
    from support.places import ROOT

    scene = parts.set_up(model="CALIBRATED")
    camera = scene.camera.data
    own = camera.petzval
    own.calibration_file = str(ROOT / "tests/reference/lensfun/lenses.xml")

    def drawn():
        return layout.draw("data", layout.context(camera=camera, object=scene.camera))

    assert "choose one" in " ".join(drawn().said)
    assert "Nikon Nikkor Z 24-70mm f/4 S" in parts.part("settings.camera")._cameras_in_file(own, blender.context, "")
    own.calibration_camera, camera.lens, camera.dof.aperture_fstop = "Nikkor Z 24-70mm f/4 S", 24.0, 4.0
    whole = drawn()
    assert {("PetzvalCamera", "calibration_body"), ("Camera", "lens"), ("CameraDOFSettings", "aperture_fstop")} <= set(
        whole.shown
    )
    # The corner by the row of lenses.xml that is nearest, of 24 mm and F/4: 1 - 0.444 - 0.876 + 0.463 is 0.143.
    (corner,) = [float(text.split()[0]) for text in whole.said if text.endswith(" stops")]
    assert abs(corner - -2.8) < 0.02
    camera.lens = 80.0
    assert "goes from 24 to 70 mm" in " ".join(drawn().said)
    own.calibration_body = "Nikon Z 6"
    assert "no camera body in the lensfun database" in " ".join(drawn().said)


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN", "AREA"])
def test_the_lights_panels(blender, parts, layout, kind):
    parts.set_up()
    light = blender.data.lights.new("Lamp", kind)
    for shape in ("SQUARE", "RECTANGLE", "DISK", "ELLIPSE") if kind == "AREA" else ("",):
        if shape:
            light.shape = shape
        drawn = layout.draw("data", layout.context(light=light))
    names = {name for _, name in drawn.shown}
    assert {"color", "energy", "use_shadow", "max_bounces"} <= names
    assert ({"spread", "size_y"} <= names) == (kind == "AREA") and ("spot_blend" in names) == (kind == "SPOT")


def test_the_other_tabs(blender, parts, layout):
    scene = parts.set_up(model="LENS")
    made, *_ = parts.material()
    square = parts.square("Square", (0.0, 5.0, 0.0), 1.0, made)
    holder = {"object": square, "material": made, "world": scene.world}
    for tab in ("render", "view_layer", "object", "material", "world"):
        assert layout.draw(tab, layout.context(**holder)).shown
    # And without any.
    scene.camera = None
    for tab in ("render", "view_layer", "object", "material", "world"):
        layout.draw(tab, layout.context(world=None))
    scene.petzval.integrator, scene.petzval.use_noise_threshold = "BIDIRECTIONAL", True
    layout.draw("render", layout.context())


def test_every_setting_of_a_bake_can_be_seen(blender, parts, layout):
    """All that Blender keeps of bakes, each with the types that it is of; the operator bakes the type that is chosen."""
    scene = parts.set_up()
    bake, own = scene.render.bake, scene.petzval
    kinds = [item.identifier for item in own.bl_rna.properties["bake_type"].enum_items]
    if hasattr(scene, "cycles"):
        theirs = scene.cycles.bl_rna.properties["bake_type"].enum_items
        ours = own.bl_rna.properties["bake_type"].enum_items
        assert {(one.identifier, one.value) for one in ours} == {(one.identifier, one.value) for one in theirs}
    bake.use_selected_to_active = bake.use_cage = True
    seen = {}
    for kind in kinds:
        own.bake_type = kind
        drawn = layout.draw("render", layout.context())
        assert "object.bake" in drawn.operators and "object.bake_image" not in drawn.operators
        seen[kind] = {name for owner, name in drawn.shown if owner == "BakeSettings"}
    assert "normal_space" in seen["NORMAL"] and "normal_space" not in seen["COMBINED"]
    assert "use_pass_emit" in seen["COMBINED"] and "use_pass_emit" not in seen["DIFFUSE"]
    assert "use_pass_color" in seen["DIFFUSE"] and "view_from" in seen["EMIT"] and "view_from" not in seen["AO"]
    # Tangents and texture coordinates are extended by one rule.
    assert "margin_type" in seen["AO"] and "margin_type" not in seen["UV"] | seen["NORMAL"]
    holder = bake if hasattr(bake, "use_multires") else scene.render
    setattr(holder, "use_multires" if holder is bake else "use_bake_multires", True)
    drawn = layout.draw("render", layout.context())
    assert "object.bake_image" in drawn.operators and "object.bake" not in drawn.operators
    seen["multires"] = {name for owner, name in drawn.shown if owner == "BakeSettings"}
    if holder is bake:
        bake.type = "VECTOR_DISPLACEMENT"
        drawn = layout.draw("render", layout.context())
        seen["vector"] = {name for owner, name in drawn.shown if owner == "BakeSettings"}
        # Of files that Blender's operator writes by itself, and of its script alone.
        apart = {"rna_type", "image_settings", "filepath", "width", "height", "save_mode", "use_split_materials"}
        apart |= {"use_automatic_name", "pass_filter"}
        wanted = {one.identifier for one in bake.bl_rna.properties} - apart
        assert wanted <= set().union(*seen.values()), wanted - set().union(*seen.values())
    # Without a camera nothing can be seen from it.
    setattr(holder, "use_multires" if holder is bake else "use_bake_multires", False)
    own.bake_type, scene.camera = "COMBINED", None
    assert "view_from" in layout.draw("render", layout.context()).active_parts


def test_the_gallery_and_the_menus(blender, parts, layout):
    from types import SimpleNamespace

    parts.set_up(model="LENS")
    gallery = parts.part("ui.lens_gallery").PETZVAL_PT_lens_gallery
    settings = blender.context.window_manager.petzval_gallery
    for group, words, least in (
        ("FIRST", "", 10),
        ("ALL", "", 30),
        ("eye", "", 5),
        ("FIRST", "nikkor", 5),
        ("ALL", "zzz", 0),
    ):
        settings.group, settings.words = group, words
        whole = layout.Layout()
        gallery.draw(SimpleNamespace(layout=whole), layout.context())
        assert whole.operators.count("petzval.set_lens") >= least
    menu = parts.part("ui.lens_menu").PETZVAL_MT_lenses
    whole = layout.Layout()
    menu.draw(SimpleNamespace(layout=whole), layout.context())
    assert "petzval.import_lens" in whole.operators


# Cycles's settings -------------------------------------------------------------------------------------------------

#: What the export reads of settings that Blender or Cycles keep, by tab: where no panel of every engine has it.
READ = {
    "render": [
        ("CyclesRenderSettings", name)
        for name in (
            "max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces",
            "transparent_max_bounces", "caustics_reflective", "caustics_refractive", "blur_glossy",
            "film_exposure", "film_transparent_glass", "film_transparent_roughness", "texture_limit", "texture_limit_render", "use_fast_gi", "fast_gi_method", "ao_bounces", "ao_bounces_render",
            "pixel_filter_type", "filter_width", "sample_clamp_direct", "sample_clamp_indirect", "seed", "use_animated_seed", "blur_glossy", "use_fast_gi",
            "rolling_shutter_type", "rolling_shutter_duration", "dicing_rate", "preview_dicing_rate",
            "offscreen_dicing_scale", "max_subdivisions", "dicing_camera", "use_camera_cull", "camera_cull_margin", "use_distance_cull",
            "distance_cull_margin", "samples", "use_adaptive_sampling", "adaptive_threshold", "adaptive_min_samples",
            "time_limit", "use_sample_subset", "sample_offset", "sample_subset_length", "preview_samples",
            "use_preview_adaptive_sampling", "preview_adaptive_threshold", "preview_adaptive_min_samples",
        )
    ]
    + [("WorldLighting", name) for name in ("ao_factor", "distance")]
    + [("CyclesCurveRenderSettings", name) for name in ("shape", "subdivisions")]
    + [
        ("RenderSettings", name)
        for name in (
            "film_transparent", "use_simplify", "simplify_subdivision_render", "simplify_child_particles_render", "use_motion_blur", "motion_blur_position", "motion_blur_shutter", "motion_blur_shutter_curve",
            "threads_mode", "threads", "use_persistent_data", "preview_pixel_size",
        )
    ],
    "object": [
        ("Object", name)
        for name in (
            "visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission", "visible_volume_scatter",
            "visible_shadow", "is_shadow_catcher", "is_holdout", "hide_render", "lightgroup",
        )
    ]
    + [("CyclesObjectSettings", name) for name in ("use_motion_blur", "motion_steps", "use_deform_motion", "ao_distance", "use_camera_cull", "use_distance_cull")],
    "material": [("Material", "displacement_method"), ("Material", "pass_index"), ("Material", "use_transparent_shadow"), ("ShaderNodeTree", "Volume")]
    + [("ShaderNodeTree", "Surface"), ("ShaderNodeTree", "Displacement"), ("CyclesMaterialSettings", "use_bump_map_correction")],
    "world": [("CyclesVisibilitySettings", name) for name in ("camera", "diffuse", "glossy", "transmission", "scatter")]
    + [("CyclesWorldSettings", name) for name in ("sampling_method", "max_bounces")]
    + [("WorldMistSettings", name) for name in ("start", "depth", "falloff")]
    + [("ShaderNodeTree", "Surface"), ("ShaderNodeTree", "Volume"), ("World", "lightgroup")],
    "view_layer": [
        ("ViewLayer", name)
        for name in ("use_sky", "use_solid", "use_strand", "use_volumes", "use_motion_blur", "material_override", "samples")
    ]
    + [("CyclesRenderSettings", "use_layer_samples")],
}  # fmt: skip


@pytest.mark.parametrize("tab", READ)
def test_what_is_read_can_be_seen(blender, parts, layout, tab):
    scene = parts.set_up(model="LENS")
    made, *_ = parts.material()
    square = parts.square("Square", (0.0, 5.0, 0.0), 1.0, made)
    blender.context.view_layer.use_pass_mist = True
    scene.render.film_transparent = True
    # Cycles' sampling is read until Petzval's own is set.
    if hasattr(scene, "cycles"):
        blender.ops.petzval.cycles_sampling(of="RENDER")
    drawn = layout.draw(tab, layout.context(object=square, material=made, world=scene.world))
    wanted = READ[tab]
    if not hasattr(scene, "cycles"):
        wanted = [one for one in wanted if not one[0].startswith("Cycles")]
    assert set(wanted) <= set(drawn.shown), set(wanted) - set(drawn.shown)


def test_every_setting_of_our_own_can_be_seen(blender, parts, layout):
    """But what is told to be hidden."""
    scene = parts.set_up(model="LENS")
    own = scene.camera.data.petzval
    seen = set()
    scene.petzval.use_noise_threshold, scene.petzval.preview_samples, scene.petzval.preview_pixel_size = True, 64, "2"
    for focus in ("CAMERA", "AUTO", "FILM"):
        for size in ("LENGTH", "SCALE"):
            own.focus_mode, own.focal_mode, own.spectrum, own.wide_open, own.film_mode = (
                focus,
                size,
                "SINGLE",
                False,
                "SIZE",
            )
            now = layout.context(camera=scene.camera.data, object=scene.camera)
            for tab in ("render", "data", "view_layer"):
                seen |= set(layout.draw(tab, now).shown)
    own.model, own.calibration_camera, own.calibration_body = "CALIBRATED", "1", "1"
    seen |= set(layout.draw("data", now).shown)
    for holder in (own, scene.petzval, scene.petzval.effects, blender.context.view_layer.petzval):
        rna = holder.bl_rna
        for one in rna.properties:
            if one.identifier in ("rna_type", "name", "effects") or one.is_hidden:
                continue
            if rna.identifier == "PetzvalScene" and one.identifier in (
                "max_bounces",
                "filter_width",
                "seed",
                "clamp_indirect",
            ):
                continue  # Cycles's own is shown until this one was set
            assert (rna.identifier, one.identifier) in seen, f"{rna.identifier}.{one.identifier}"


def test_no_panel_stands_twice(blender, parts):
    """None of Blender's own of the same name beside ours, in the same tab."""
    import bpy

    def all_of(cls):
        for one in cls.__subclasses__():
            yield one
            yield from all_of(one)

    found = {}
    for cls in set(all_of(bpy.types.Panel)):
        engines = getattr(cls, "COMPAT_ENGINES", ())
        if (
            getattr(cls, "bl_space_type", "") == "PROPERTIES"
            and "PETZVAL" in engines
            and getattr(cls, "is_registered", True)
        ):
            key = getattr(cls, "bl_context", ""), getattr(cls, "bl_parent_id", ""), getattr(cls, "bl_label", "")
            if cls.__name__.startswith(
                ("PETZVAL_", "DATA_PT_light", "OBJECT_PT_vis", "RENDER_PT_", "WORLD_PT_", "EEVEE_")
            ):
                found.setdefault(key, []).append(cls.__name__)
    twice = {
        key: names for key, names in found.items() if len(names) > 1 and any(n.startswith("PETZVAL_") for n in names)
    }
    assert not twice, twice


# Greyed or explained -----------------------------------------------------------------------------------------------


def test_settings_that_make_no_sense_together_are_explained(blender, parts, layout):
    scene = parts.set_up(model="LENS")
    own = scene.camera.data.petzval
    scene.camera.data.type = "ORTHO"
    drawn = layout.draw("data", layout.context(camera=scene.camera.data))
    assert any("orthographic" in text for text in drawn.said)
    scene.camera.data.type, scene.camera.data.clip_start, scene.camera.data.clip_end = "PERSP", 10.0, 1.0
    drawn = layout.draw("data", layout.context(camera=scene.camera.data))
    assert any("nothing is clipped" in text for text in drawn.said)
    scene.render.use_motion_blur, scene.petzval.effects.motion_blur = True, "OFF"
    drawn = layout.draw("render", layout.context())
    assert any("Effects panel" in text for text in drawn.said)
    own.model, own.spectrum = "THICK", "VISIBLE"
    assert "spectrum" in layout.draw("data", layout.context(camera=scene.camera.data)).active_parts
    own.model = "LENS"
    assert "use_blue_noise" not in layout.draw("render", layout.context()).active_parts
    scene.petzval.sample_offset = 4
    assert "use_blue_noise" in layout.draw("render", layout.context()).active_parts
    scene.petzval.sample_offset, scene.petzval.use_noise_threshold = 0, True
    assert "use_blue_noise" in layout.draw("render", layout.context()).active_parts


# Words -------------------------------------------------------------------------------------------------------------

#: A number without a unit of Blender's says it in words, or has none.
UNITS = re.compile(
    r"\b(mm|seconds|nanometres|gigabytes|pixels?|degrees|samples|rays|parts?|times|factor|multiplied|number|bounces?|blades|"
    r"f-number|radiance|relative|of the film|of all random|first sample|half a pixel|millimetres|lumens|watt)\b", re.IGNORECASE
)  # fmt: skip
WITHOUT_UNIT = {"f_number", "blade_curvature", "iso", "samples", "seed", "mask"}


def groups(bpy):
    for holder in (bpy.types.Camera, bpy.types.Scene, bpy.types.ViewLayer):
        yield holder.bl_rna.properties["petzval"].fixed_type
    yield bpy.types.Scene.bl_rna.properties["petzval"].fixed_type.properties["effects"].fixed_type
    yield bpy.types.WindowManager.bl_rna.properties["petzval_gallery"].fixed_type


def test_every_setting_has_words_and_numbers_a_unit(blender):
    for rna in groups(blender):
        for one in rna.properties:
            where = f"{rna.identifier}.{one.identifier}"
            if one.identifier in ("rna_type", "name"):
                continue
            assert len(one.description) >= 10, where
            assert not one.description.endswith("."), f"{where}: Blender adds the stop"
            assert one.is_hidden or one.name, where
            if one.type == "ENUM" and one.enum_items:
                assert all(item.description and item.name for item in one.enum_items), where
            if one.type in ("FLOAT", "INT") and one.identifier not in WITHOUT_UNIT:
                has_unit = getattr(one, "unit", "NONE") != "NONE" or one.subtype not in ("NONE", "XYZ")
                assert has_unit or UNITS.search(one.description), f"{where}: {one.description}"


def test_every_operator_has_words(blender):
    found = [getattr(blender.ops.petzval, name) for name in dir(blender.ops.petzval)]
    assert len(found) >= 12
    for operator in found:
        rna = operator.get_rna_type()
        assert len(rna.description) >= 10 and not rna.description.endswith("."), rna.identifier
        assert rna.name, rna.identifier
        for one in rna.properties:
            if one.identifier != "rna_type" and not one.is_hidden:
                assert one.description or one.type == "ENUM", f"{rna.identifier}.{one.identifier}"


def test_every_panel_has_a_name(blender, layout):
    for cls in layout.panels():
        assert cls.bl_label, cls.__name__


# Animation ---------------------------------------------------------------------------------------------------------


def numbers(bpy):
    for one in bpy.types.Camera.bl_rna.properties["petzval"].fixed_type.properties:
        if one.type in ("FLOAT", "INT", "BOOLEAN", "ENUM") and not one.is_hidden:
            yield one


def test_every_number_can_be_animated_and_driven(blender, parts):
    scene = parts.set_up(model="LENS")
    camera = scene.camera.data
    for one in numbers(blender):
        assert one.is_animatable, one.identifier
        if one.identifier in ("model", "through_lens"):
            continue  # the one sets the other: in test_lens_panels.py
        path = f"petzval.{one.identifier}"
        index = 0 if getattr(one, "is_array", False) else -1
        assert camera.keyframe_insert(path, index=index, frame=1), path
        camera.animation_data_clear()
        curve = camera.driver_add(path, index)
        is_step = one.type in ("BOOLEAN", "ENUM")
        # Within the setting's range, and another number than its default.
        wanted = (0 if one.default else 1) if one.type == "BOOLEAN" else 1 if is_step else _other(one)
        curve.driver.expression = repr(wanted)
        scene.frame_set(scene.frame_current + 1)
        evaluated = scene.camera.evaluated_get(blender.context.evaluated_depsgraph_get()).data.petzval
        value = getattr(evaluated, one.identifier)
        value = value[0] if index == 0 else value
        if one.type == "ENUM":
            assert one.enum_items[value].value == wanted, path
        else:
            assert float(value) == pytest.approx(wanted, rel=1e-5), path
        camera.animation_data_clear()
        camera.petzval.property_unset(one.identifier)


def _other(one) -> float:
    value = one.default_array[0] if getattr(one, "is_array", False) else one.default
    for other in (value * 0.5, value + 1.0, value + 0.25):
        other = float(round(other)) if one.type == "INT" else other
        if other != value and one.hard_min <= other <= one.hard_max:
            return other
    raise AssertionError(one.identifier)


def test_animated_numbers_reach_the_engine(blender, parts):
    """Not only Blender's own copy: the f-number of the second frame is the engine's."""
    scene = parts.set_up(model="LENS")
    own = scene.camera.data.petzval
    own.wide_open = False
    for frame, number in ((1, 4.0), (2, 11.0)):
        own.f_number = number
        own.keyframe_insert("f_number", frame=frame)
    for frame, number in ((1, 4.0), (2, 11.0)):
        scene.frame_set(frame)
        info = parts.part("queries.lens_info").of_camera(scene.camera, scene)
        assert info["f_number"] == pytest.approx(number, rel=1e-6), json.dumps(info["f_number"])
