# SPDX-License-Identifier: GPL-3.0-or-later
"""The lens's settings kept in the .blend: `Camera.petzval`. Unit, range and tooltip each."""

from __future__ import annotations

from math import pi, radians

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from petzval.description import OF_LENS_FILE

from ..data.choices import (
    ANCHORS,
    COATINGS,
    FILM_MODES,
    FOCAL_MODES,
    FOCUS_MODES,
    FOCUS_RELATIONS,
    MODELS,
    PRECISIONS,
    SPECTRA,
)
from ..queries import viewport_camera

# A path may begin with //, and newer Blenders want to be told so.
_RELATIVE_PATH = {"ANIMATABLE"} | ({"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set())


def _changed(settings: PetzvalCamera, context: bpy.types.Context) -> None:
    viewport_camera.lens_changed(settings.id_data, context.scene)


def _model_changed(settings: PetzvalCamera, context: bpy.types.Context) -> None:
    if viewport_camera.is_switching():
        return
    if settings.model in OF_LENS_FILE and settings.lens_model != settings.model:
        settings.lens_model = settings.model
    _changed(settings, context)


def _is_through_lens(settings: PetzvalCamera) -> bool:
    return settings.model in OF_LENS_FILE


def _look_through_lens(settings: PetzvalCamera, through: bool) -> None:
    """Animation and drivers come here, too, while Blender evaluates the scene: nothing else is to be touched."""
    if through != _is_through_lens(settings):
        with viewport_camera.switching():
            if not through:
                settings.lens_model = settings.model
            settings.model = settings.lens_model if through else "PINHOLE"


def _switched(settings: PetzvalCamera, context: bpy.types.Context) -> None:
    viewport_camera.switched(settings.id_data, context.scene)


def _is_not_the_camera(settings: PetzvalCamera, chosen: bpy.types.Object) -> bool:
    return chosen.data is None or chosen.data != settings.id_data


class PetzvalCamera(bpy.types.PropertyGroup):
    """`Camera.petzval`."""

    model: EnumProperty(
        name="Model", description="How the camera takes its picture", items=MODELS, update=_model_changed
    )
    through_lens: BoolProperty(
        name="Through the Lens",
        description="Off: an ordinary perspective camera with the same framing, everything sharp. The model comes back when "
        "it is turned on again",
        get=_is_through_lens,
        set=_look_through_lens,
        update=_switched,
    )
    lens_model: EnumProperty(
        name="Model of the Lens",
        description="The model that Through the Lens turns on",
        items=MODELS,
        options={"HIDDEN"},
    )
    lens_file: StringProperty(
        name="Lens File",
        description="A lens file (.lens, .zmx, .seq, .len, .dat, a table of the Optical Bench), or the name of a lens that comes with Petzval",
        default="wide-angle-smith-f3.4.lens",
        subtype="FILE_PATH",
        options=_RELATIVE_PATH,
        update=_changed,
    )
    focal_mode: EnumProperty(
        name="Lens Size", description="How large the whole lens is", items=FOCAL_MODES, update=_changed
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
        update=_changed,
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
        update=_changed,
    )
    wide_open: BoolProperty(
        name="Wide Open",
        description="The diaphragm as far open as the lens allows. A thin lens takes Blender's own f-stop instead",
        default=True,
        update=_changed,
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
        update=_changed,
    )
    pupil_diameter: FloatProperty(
        name="Pupil",
        description="Diameter of the entrance pupil in mm, as of an eye's, instead of the f-number. 0: by the f-number",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        step=10,
        precision=2,
        update=_changed,
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
    aperture_mask: PointerProperty(
        name="Mask",
        description="A square picture of the opening, as wide as the stop: light passes where it is brighter than half. "
        "It stands instead of the blades",
        type=bpy.types.Image,
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
        update=_changed,
    )
    exposes_by_f_number: BoolProperty(
        name="Expose by F-Number",
        description="What glass and coatings take makes the picture darker. Off: exposed by the T-number, its middle stays as "
        "bright as if nothing were lost, and only the tint is seen",
        default=False,
    )
    focus_mode: EnumProperty(name="Focus", description="What is sharp", items=FOCUS_MODES, update=_changed)
    anchor: EnumProperty(
        name="Camera at",
        description="What stands at the camera's place and stays there while focusing. Focus distances count from it",
        items=ANCHORS,
        update=_changed,
    )
    focus_relation: EnumProperty(
        name="Relation",
        description="How a focus distance moves the film. A focus object is focused on exactly",
        items=FOCUS_RELATIONS,
        update=_changed,
    )
    autofocus_point: FloatVectorProperty(
        name="Autofocus Point",
        description="Where to look, as parts of the picture's width and height from its lower left corner",
        size=2,
        default=(0.5, 0.5),
        min=0.0,
        max=1.0,
        step=5,
        precision=3,
    )
    sharp_object_1: PointerProperty(
        name="Object 1",
        description="The first of three objects whose origins the film can be turned to have sharp",
        type=bpy.types.Object,
        poll=_is_not_the_camera,
    )
    sharp_object_2: PointerProperty(
        name="Object 2",
        description="The second of three objects whose origins the film can be turned to have sharp",
        type=bpy.types.Object,
        poll=_is_not_the_camera,
    )
    sharp_object_3: PointerProperty(
        name="Object 3",
        description="The third of three objects whose origins the film can be turned to have sharp",
        type=bpy.types.Object,
        poll=_is_not_the_camera,
    )
    film_distance: FloatProperty(
        name="Film Distance",
        description="From the last vertex of the lens to the middle of the film. Negative behind an odd number of mirrors",
        default=50.0,
        min=-1e6,
        soft_min=1e-3,
        max=1e6,
        soft_max=1000.0,
        step=10,
        precision=3,
        subtype="DISTANCE_CAMERA",
        update=_changed,
    )
    film_mode: EnumProperty(name="Film", description="How large the film is", items=FILM_MODES, update=_changed)
    film_width: FloatProperty(
        name="Width",
        description="Width of the film",
        default=36.0,
        min=1e-3,
        max=1e6,
        soft_min=1.0,
        soft_max=300.0,
        subtype="DISTANCE_CAMERA",
        update=_changed,
    )
    film_height: FloatProperty(
        name="Height",
        description="Height of the film",
        default=24.0,
        min=1e-3,
        max=1e6,
        soft_min=1.0,
        soft_max=300.0,
        subtype="DISTANCE_CAMERA",
        update=_changed,
    )
    tilt: FloatProperty(
        name="Tilt",
        description="The film turned about its horizontal axis, so that the plane of sharp focus leans",
        default=0.0,
        min=radians(-80.0),
        max=radians(80.0),
        soft_min=-pi / 6,
        soft_max=pi / 6,
        subtype="ANGLE",
        update=_changed,
    )
    swing: FloatProperty(
        name="Swing",
        description="The film turned about its vertical axis",
        default=0.0,
        min=radians(-80.0),
        max=radians(80.0),
        soft_min=-pi / 6,
        soft_max=pi / 6,
        subtype="ANGLE",
        update=_changed,
    )
    shift_x: FloatProperty(
        name="Shift",
        description="The lens moved to the right against the film: more of the scene's right side comes into the picture",
        default=0.0,
        min=-1e6,
        max=1e6,
        soft_min=-50.0,
        soft_max=50.0,
        step=10,
        precision=3,
        subtype="DISTANCE_CAMERA",
        update=_changed,
    )
    shift_y: FloatProperty(
        name="Rise",
        description="The lens moved up against the film: more of what is high comes into the picture",
        default=0.0,
        min=-1e6,
        max=1e6,
        soft_min=-50.0,
        soft_max=50.0,
        step=10,
        precision=3,
        subtype="DISTANCE_CAMERA",
        update=_changed,
    )
    scale_from_scene: BoolProperty(
        name="From the Scene",
        description="The lens has its true size: 1000 millimetres to a metre, by the scene's unit scale",
        default=True,
        update=_changed,
    )
    scale_locked: BoolProperty(
        name="Locked Together", description="One scale for all three axes: the first", default=True, update=_changed
    )
    scale: FloatVectorProperty(
        name="World to Lens",
        description="Millimetres in the lens for one Blender unit, along the camera's x, y and z",
        size=3,
        default=(1000.0, 1000.0, 1000.0),
        min=1e-6,
        max=1e9,
        soft_min=0.1,
        soft_max=1e5,
        precision=2,
        subtype="XYZ",
        update=_changed,
    )
    spectrum: EnumProperty(
        name="Spectrum", description="The wavelengths in which the picture is taken", items=SPECTRA, update=_changed
    )
    precision: EnumProperty(
        name="Precision",
        description="Of the numbers in which rays leave through the lens; the statistics say what single precision changes",
        items=PRECISIONS,
        update=_changed,
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
        update=_changed,
    )
    physical_exposure: BoolProperty(
        name="Physical Exposure",
        description="Brightness by shutter, film speed and f-number, as in a camera. Off: by the light alone, as in Cycles",
        default=False,
    )
    shutter: FloatProperty(
        name="Shutter",
        description="How long the film is exposed, seconds. It sets the brightness; motion blur has its own shutter",
        default=1.0 / 125.0,
        min=1e-6,
        max=1e5,
        soft_min=1.0 / 8000.0,
        soft_max=30.0,
        precision=5,
        subtype="TIME_ABSOLUTE",
    )
    iso: FloatProperty(
        name="ISO",
        description="Speed of the film: where it saturates, by ISO 12232",
        default=100.0,
        min=0.01,
        max=1e7,
        soft_min=6.0,
        soft_max=25600.0,
        precision=0,
    )
    lumens_per_watt: FloatProperty(
        name="Lumens per Watt",
        description="Light that one watt of Blender's white lamps stands for; 683 is what its exchange formats use",
        default=683.0,
        min=0.01,
        max=1e6,
        soft_max=683.0,
        precision=0,
    )
    match_viewport: BoolProperty(
        name="Viewport Follows",
        description="Set Blender's focal length (and sensor, where the film has a size of its own) so that the camera "
        "view frames what the lens will photograph",
        default=True,
        update=_changed,
    )
    show_focus: BoolProperty(
        name="Show Focus",
        description="Draw into 3D views where this camera is sharp: the surface of focus green, from where on it is sharp enough blue, "
        "to where orange, and the entrance pupil violet",
        default=False,
    )
    confusion: FloatProperty(
        name="Circle of Confusion",
        description="Diameter of the blur on the film, in mm, that still counts as sharp. Zero is the picture's diagonal by 1500",
        default=0.0,
        min=0.0,
        soft_max=0.5,
        step=1,
        precision=4,
    )
    in_step: BoolProperty(
        description="The lens was set up here: Blender's camera may be kept in step", options={"HIDDEN"}
    )
