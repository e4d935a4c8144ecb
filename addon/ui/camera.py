# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's Lens panel with its parts."""

from __future__ import annotations

import bpy

from petzval.description import OF_LENS_FILE

from ..data import favourites, film_formats
from ..queries import calibrations, lens_info, viewport_camera
from .camera_parts import AperturePart, CameraPanel, LensPart, complain, fact
from .focus import PETZVAL_CAMERA_PT_focus, PETZVAL_CAMERA_PT_sharp
from .lens_data import PETZVAL_CAMERA_PT_info
from .lens_drawing import PETZVAL_CAMERA_PT_drawing
from .lens_gallery import PETZVAL_PT_lens_gallery
from .lens_menu import GROUP_MENUS, PETZVAL_MT_lenses
from .mixin import columns
from .preset_panels import PETZVAL_PT_camera_presets, PETZVAL_PT_lens_presets
from .scale import PETZVAL_CAMERA_PT_scale

#: Models with the blur of a thin lens.
HAVE_THIN_LENS = ("THIN", "CALIBRATED")
#: Models that have one wavelength, whichever spectrum is chosen.
ONE_WAVELENGTH = ("THICK", "IMAGE_BASED")


class PETZVAL_CAMERA_PT_lens(CameraPanel, bpy.types.Panel):
    bl_label = "Lens"

    def draw_header(self, context):
        self.layout.prop(context.camera.petzval, "through_lens", text="")

    def draw_header_preset(self, context):
        row = self.layout.row(align=True)
        row.emboss = "NONE"
        row.popover(PETZVAL_PT_camera_presets.__name__, text="", icon="CAMERA_DATA")
        row.popover(PETZVAL_PT_lens_presets.__name__, text="", icon="PRESET")

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings = camera.petzval
        layout.prop(settings, "model")
        if camera.type != "PERSP" or settings.model not in OF_LENS_FILE:
            layout.prop(camera, "type")
        if camera.type == "ORTHO":
            layout.prop(camera, "ortho_scale")
            if settings.model != "PINHOLE":
                layout.label(text="No lens takes an orthographic picture", icon="INFO")
        if camera.type == "PANO":
            _panorama(layout, camera)
            if settings.model in OF_LENS_FILE:
                layout.label(text="No lens takes a panoramic picture", icon="INFO")
        if settings.model == "CALIBRATED" and camera.type == "PERSP":
            _calibration(context, layout)
            return
        if settings.model not in OF_LENS_FILE:
            if camera.type == "PERSP" or (camera.type == "PANO" and settings.model == "THIN"):
                layout.prop(camera, "lens")
            _blenders_film(layout, camera)
            column = layout.column(align=True)
            column.prop(camera, "shift_x", text="Shift X")
            column.prop(camera, "shift_y", text="Y")
            return
        _chosen_lens(context, layout)
        layout.prop(settings, "focal_mode")
        if settings.focal_mode == "LENGTH":
            layout.prop(settings, "focal_length")
        elif settings.focal_mode == "SCALE":
            layout.prop(settings, "focal_scale")
        row = layout.row()
        row.active = settings.model not in ONE_WAVELENGTH or settings.spectrum == "SINGLE"
        row.prop(settings, "spectrum")
        if settings.spectrum == "SINGLE":
            layout.prop(settings, "wavelength")
        if settings.model == "LENS":
            layout.prop(settings, "precision")


#: Settings of each panoramic projection that has any: columns of Blender's properties, and of their labels where they are not their own.
PANORAMAS = {
    "EQUIRECTANGULAR": (
        {"latitude_min": "Latitude Min", "latitude_max": "Max"},
        {"longitude_min": "Longitude Min", "longitude_max": "Max"},
    ),
    "FISHEYE_EQUIDISTANT": ({"fisheye_fov": "Field of View"},),
    "FISHEYE_EQUISOLID": ({"fisheye_lens": "Lens"}, {"fisheye_fov": "Field of View"}),
    "FISHEYE_LENS_POLYNOMIAL": (
        {"fisheye_fov": "Field of View"},
        {f"fisheye_polynomial_k{power}": f"K{power}" for power in range(5)},
    ),
    "CENTRAL_CYLINDRICAL": (
        {"central_cylindrical_range_v_min": "Height Min", "central_cylindrical_range_v_max": "Max"},
        {"central_cylindrical_range_u_min": "Longitude Min", "central_cylindrical_range_u_max": "Max"},
        {"central_cylindrical_radius": "Cylinder Radius"},
    ),
}


def _panorama(layout, camera) -> None:
    """The settings of a panoramic camera, as Blender's own panel has them."""
    layout.prop(camera, "panorama_type")
    for group in PANORAMAS.get(camera.panorama_type, ()):
        column = layout.column(align=True)
        for name, label in group.items():
            column.prop(camera, name, text=label)


def _chosen_lens(context, layout) -> None:
    """The lens's name, and below it the ways to choose another: in a narrow panel there is no room for them in one row."""
    camera = context.camera
    settings = camera.petzval
    column = layout.column(align=True)
    info = _lens_info(context)
    column.menu(PETZVAL_MT_lenses.bl_idname, text=info.get("lens_name") or "Choose a Lens", icon="CAMERA_DATA")
    row = column.row(align=True)
    row.popover(PETZVAL_PT_lens_gallery.__name__, text="Gallery", icon="IMGDISPLAY")
    row.operator("petzval.choose_lens", text="Search", icon="VIEWZOOM")
    is_liked = favourites.has(favourites.key(settings.lens_file, camera.library))
    row.operator("petzval.favourite_lens", text="", icon="SOLO_ON" if is_liked else "SOLO_OFF")
    column.prop(settings, "lens_file", placeholder="Automatic")
    if "error" in info:
        complain(context, layout, info["error"])


def _calibration(context, layout) -> None:
    """The file of calibrations, the camera in it, and its facts; with depth of field or an ST map, Blender's sensor and focal length."""
    camera = context.camera
    settings = camera.petzval
    found, chosen = calibrations.of_camera(camera), calibrations.chosen_in(camera)
    column = layout.column(align=True)
    column.prop(settings, "calibration_file")
    is_lensfun = bool(found.get("lenses"))
    if len(found.get("cameras", ())) > 1 or is_lensfun or settings.calibration_camera:
        column.prop(settings, "calibration_camera", text="Lens" if is_lensfun else None)
    if is_lensfun or settings.calibration_body:
        column.prop(settings, "calibration_body", placeholder="Blender's Sensor")
    is_map = found.get("format") == "ST map"
    if "error" in chosen:
        complain(context, layout, chosen["error"])
    elif is_lensfun:
        _photographic(context, layout, chosen)
    elif chosen:
        width, height = chosen["size_px"]
        fact(layout, "Model", chosen["model"])
        fact(layout, "Calibrated At", f"{width} x {height}")
        _black_part(context, layout, chosen)
    if is_map or is_lensfun:
        layout.prop(camera, "lens")
    layout.prop(camera.dof, "use_dof", text="Depth of Field")
    if is_lensfun and not camera.dof.use_dof:
        layout.prop(camera.dof, "aperture_fstop")
    if is_map or (camera.dof.use_dof and not is_lensfun) or (is_lensfun and not settings.calibration_body):
        _blenders_film(layout, camera)
    if is_map:
        column = layout.column(align=True)
        column.prop(camera, "shift_x", text="Shift X")
        column.prop(camera, "shift_y", text="Y")


def _photographic(context, layout, chosen: dict) -> None:
    """The measurements of a lens of a lensfun database, at the camera's setting."""
    fact(layout, "Focal Length", f"{chosen['marked_mm']:.4g} mm")
    stops, lateral = chosen["corner_stops"], chosen["corner_lateral_px"]
    if stops is not None:
        fact(layout, "Corner", f"{stops:+.2f} stops")
    if lateral is not None:
        fact(layout, "Red, Blue in the Corner", f"{lateral[0]:+.2f}, {lateral[1]:+.2f} px")
    for remark in chosen["remarks"]:
        complain(context, layout, remark)
    _black_part(context, layout, chosen)


def _black_part(context, layout, chosen: dict) -> None:
    """The part of the picture in which a calibration sees nothing, and the reason, if there is one."""
    if chosen["covered"] < 1.0:
        dark = 100.0 * (1.0 - chosen["covered"])
        complain(context, layout, f"{dark:.1f} % of the picture is black: {chosen['reason']}")


def _lens_info(context) -> dict:
    """The engine's numbers of the lens, or its complaint; nothing of a camera that is not in the scene."""
    holder = viewport_camera.camera_object(context.camera, context.scene)
    return lens_info.for_panel(holder, context.scene) if holder is not None else {}


def _coverage(context) -> str:
    """The part of the picture that the lens does not light; empty if it lights all."""
    holder = viewport_camera.camera_object(context.camera, context.scene)
    return lens_info.coverage(holder, context.scene) if holder is not None else ""


def _blenders_film(layout, camera: bpy.types.Camera) -> None:
    layout.prop(camera, "sensor_fit")
    layout.prop(camera, "sensor_height" if camera.sensor_fit == "VERTICAL" else "sensor_width", text="Size")


class PETZVAL_CAMERA_PT_clip(CameraPanel, bpy.types.Panel):
    bl_label = "Clipping"
    bl_parent_id = PETZVAL_CAMERA_PT_lens.__name__
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = columns(self).column(align=True)
        column.prop(context.camera, "clip_start", text="Clip Start")
        column.prop(context.camera, "clip_end", text="End")
        if context.camera.clip_end <= context.camera.clip_start:
            column.label(text="It ends before it begins: nothing is clipped", icon="INFO")


class PETZVAL_CAMERA_PT_aperture(AperturePart, bpy.types.Panel):
    bl_label = "Aperture"
    of_blur = True

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings = camera.petzval
        if settings.model in OF_LENS_FILE:
            layout.prop(settings, "wide_open")
        else:
            layout.prop(settings, "wide_open", text="Blender's F-Stop")
        if not settings.wide_open:
            row = layout.row()
            row.active = settings.model not in OF_LENS_FILE or settings.pupil_diameter == 0.0
            row.prop(settings, "f_number")
            if settings.model in OF_LENS_FILE:
                layout.prop(settings, "pupil_diameter")
        elif settings.model in HAVE_THIN_LENS:
            layout.prop(camera.dof, "aperture_fstop")
        column = layout.column(align=True)
        has_mask = settings.aperture_mask is not None
        blades = settings.blades
        if settings.model in HAVE_THIN_LENS and blades == 0:
            blades = camera.dof.aperture_blades
        for name, matters in (
            ("blades", not has_mask),
            ("blade_rotation", has_mask or blades >= 3),
            ("blade_curvature", not has_mask and blades >= 3),
        ):
            row = column.row(align=True)
            row.active = matters
            row.prop(settings, name)
        column.template_ID(settings, "aperture_mask", open="image.open", text="Mask")
        if settings.model in HAVE_THIN_LENS:
            layout.prop(camera.dof, "aperture_ratio")
        if settings.model in OF_LENS_FILE:
            column = layout.column(align=True)
            column.prop(settings, "coating")
            column.prop(settings, "exposes_by_f_number")
            column.prop(settings, "white_balance")


class PETZVAL_CAMERA_PT_glare(AperturePart, bpy.types.Panel):
    bl_label = "Glare"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        settings = context.camera.petzval
        column = columns(self).column(align=True)
        column.active = settings.model == "LENS"
        for name in ("glare_roughness", "glare_cleanliness", "glare_veil"):
            column.prop(settings, name)


class PETZVAL_CAMERA_PT_exposure(AperturePart, bpy.types.Panel):
    bl_label = "Physical Exposure"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.camera.petzval, "physical_exposure", text="")

    def draw(self, context):
        layout = columns(self)
        settings = context.camera.petzval
        layout.active = settings.physical_exposure
        layout.prop(settings, "shutter")
        layout.prop(settings, "iso")
        layout.prop(settings, "lumens_per_watt", text="Lumens / Watt")


class PETZVAL_CAMERA_PT_sensor(CameraPanel, bpy.types.Panel):
    bl_label = "Sensor"
    bl_parent_id = PETZVAL_CAMERA_PT_lens.__name__
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.camera.petzval, "use_sensor", text="")

    def draw(self, context):
        layout = columns(self)
        settings = context.camera.petzval
        layout.active = settings.use_sensor
        layout.prop(settings, "sensor")
        layout.prop(settings, "raw_file")


class PETZVAL_CAMERA_PT_film(LensPart, bpy.types.Panel):
    bl_label = "Film & Movements"

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings = camera.petzval
        layout.prop(settings, "film_mode")
        column = layout.column(align=True)
        if settings.film_mode == "SIZE":
            film = film_formats.of_size(settings.film_width, settings.film_height)
            # As a property's row is split, with room for the dot of its keyframes.
            line = column.row(align=True)
            row = line.split(factor=0.4, align=True)
            row.alignment = "RIGHT"
            row.label(text="Format")
            row.operator_menu_enum("petzval.choose_film", "film", text=film.title if film else "Choose")
            line.label(icon="BLANK1")
            column.prop(settings, "film_width")
            column.prop(settings, "film_height")
        elif settings.film_mode == "SENSOR":
            _blenders_film(column, camera)
        complaint = _coverage(context)
        if complaint:
            complain(context, layout, complaint)
        column = layout.column(align=True)
        column.prop(settings, "tilt")
        column.prop(settings, "swing")
        column = layout.column(align=True)
        column.prop(settings, "shift_x")
        column.prop(settings, "shift_y")
        layout.prop(settings, "match_viewport")
        row = layout.row()
        row.active = not (settings.match_viewport and settings.in_step)
        row.operator("petzval.match_viewport")


CLASSES = (
    *GROUP_MENUS,
    PETZVAL_MT_lenses,
    PETZVAL_CAMERA_PT_lens,
    PETZVAL_CAMERA_PT_drawing,
    PETZVAL_CAMERA_PT_info,
    PETZVAL_CAMERA_PT_aperture,
    PETZVAL_CAMERA_PT_exposure,
    PETZVAL_CAMERA_PT_sensor,
    PETZVAL_CAMERA_PT_glare,
    PETZVAL_CAMERA_PT_focus,
    PETZVAL_CAMERA_PT_sharp,
    PETZVAL_CAMERA_PT_film,
    PETZVAL_CAMERA_PT_scale,
    PETZVAL_CAMERA_PT_clip,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
