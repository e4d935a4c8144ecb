# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a camera's lens, kept in the .blend as part of `Camera.petzval`. Unit, range and tooltip each."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from petzval.description import OF_LENS_FILE

from ..data.choices import COATINGS, FOCAL_MODES, MODELS, PRECISIONS, SPECTRA
from ..queries import viewport_camera

# A path may begin with //, and newer Blenders want to be told so.
RELATIVE_PATH = {"ANIMATABLE"} | ({"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set())


def changed(settings: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Told by a property whose value the view of the camera follows."""
    viewport_camera.lens_changed(settings.id_data, context.scene)


def _lens_chosen(settings: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    # Who chooses a lens wants it as it is, unless a size was chosen before.
    if settings.lens_file.strip() and not settings.is_property_set("focal_mode"):
        settings.focal_mode = "PUBLISHED"
    changed(settings, context)


def _model_changed(settings: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    if viewport_camera.is_switching():
        return
    if settings.model in OF_LENS_FILE and settings.lens_model != settings.model:
        settings.lens_model = settings.model
    changed(settings, context)


class LensProperties:
    """All of a camera's settings that belong to the lens and that a preset of it keeps, in this order. A picture of the diaphragm cannot be in
    a preset's text: it is one of the camera's own."""

    lens_file: StringProperty(
        name="Lens File",
        description="A lens file (.lens, .zmx, .seq, .len, .dat, a table of the Optical Bench), or the name of a lens that comes with "
        "Petzval. Empty: a lens made for what Blender's camera sees, a normal lens of 50 mm where it sees as much",
        subtype="FILE_PATH",
        options=RELATIVE_PATH,
        update=_lens_chosen,
    )
    model: EnumProperty(
        name="Model", description="How the camera takes its picture", items=MODELS, update=_model_changed
    )
    focal_mode: EnumProperty(
        name="Lens Size",
        description="How large the whole lens is",
        items=FOCAL_MODES,
        default="BLENDER",
        update=changed,
    )
    focal_length: FloatProperty(
        name="Focal Length",
        description="Radii, thicknesses and apertures are all scaled to reach this focal length",
        default=50.0,
        min=0.01,
        max=1e6,
        soft_min=1.0,
        soft_max=1000.0,
        step=100,
        subtype="DISTANCE_CAMERA",
        update=changed,
    )
    focal_scale: FloatProperty(
        name="Scale",
        description="Radii, thicknesses and apertures are all multiplied by this",
        default=1.0,
        min=1e-4,
        max=1e4,
        soft_min=0.1,
        soft_max=10.0,
        precision=3,
        update=changed,
    )
    wide_open: BoolProperty(
        name="Wide Open",
        description="The diaphragm as far open as the lens allows. A thin lens takes Blender's own f-stop instead",
        default=True,
        update=changed,
    )
    f_number: FloatProperty(
        name="F-Number",
        description="Focal length over the diameter of the entrance pupil. It never opens past the clear apertures",
        default=5.6,
        min=0.05,
        max=1000.0,
        soft_min=0.95,
        soft_max=32.0,
        step=10,
        precision=2,
        update=changed,
    )
    pupil_diameter: FloatProperty(
        name="Pupil",
        description="Diameter of the entrance pupil in mm, as of an eye's, instead of the f-number. 0: by the f-number",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        step=10,
        precision=2,
        update=changed,
    )
    blades: IntProperty(
        name="Blades",
        description="Blades of the diaphragm; fewer than three make a round opening",
        default=0,
        min=0,
        max=24,
    )
    blade_rotation: FloatProperty(
        name="Rotation", description="The diaphragm turned about the axis", default=0.0, subtype="ANGLE"
    )
    blade_curvature: FloatProperty(
        name="Curvature",
        description="How far the blades' edges bulge between the corners: zero is straight, one makes the opening round",
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    glare_roughness: FloatProperty(
        name="Roughness",
        description="How rough the polished surfaces of the lens are, root mean square in nanometres: it scatters light near bright places",
        default=2.0,
        min=0.0,
        max=100.0,
        soft_max=10.0,
        step=10,
        precision=2,
    )
    glare_cleanliness: FloatProperty(
        name="Dust",
        description="Cleanliness level of the lens's surfaces, a number by IEST-STD-CC1246: about the size of the largest speck in "
        "thousandths of mm. 0: no dust",
        default=300.0,
        min=0.0,
        max=2000.0,
        soft_max=1000.0,
        step=1000,
        precision=0,
    )
    glare_veil: FloatProperty(
        name="Veil",
        description="Veiling glare index of barrel and film (ISO 9358): the part of an even world's light that is laid evenly over "
        "the picture",
        default=0.01,
        min=0.0,
        max=1.0,
        soft_max=0.1,
        step=0.1,
        precision=4,
    )
    coating: EnumProperty(
        name="Coating",
        description="Thin films on the lens's glass: how much of the light its surfaces reflect, and in which colours",
        items=COATINGS,
        update=changed,
    )
    exposes_by_f_number: BoolProperty(
        name="Expose by F-Number",
        description="What glass and coatings take makes the picture darker. Off: exposed by the T-number, its middle stays as "
        "bright as if nothing were lost, and only the tint is seen",
        default=False,
    )
    white_balance: BoolProperty(
        name="White Balance",
        description="White is white in the middle of the picture. Off: the lens's own colour is seen, a green or yellow cast of many coatings "
        "and glasses",
        default=True,
    )
    spectrum: EnumProperty(
        name="Spectrum", description="The wavelengths in which the picture is taken", items=SPECTRA, update=changed
    )
    wavelength: FloatProperty(
        name="Wavelength",
        description="The one wavelength in which the lens is traced; the picture's colours stay as they are",
        default=587.5618,
        min=380.0,
        max=780.0,
        step=100,
        precision=5,
        subtype="WAVELENGTH",
        update=changed,
    )
    precision: EnumProperty(
        name="Precision",
        description="Of the numbers in which rays leave through the lens; the statistics say what single precision changes",
        items=PRECISIONS,
        update=changed,
    )
