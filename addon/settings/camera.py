# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's settings kept in the .blend: `Camera.petzval`. Unit, range and tooltip each."""

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
from petzval.sensor_options import SENSORS

from ..data.choices import (
    ANCHORS,
    FILM_MODES,
    FOCUS_MODES,
    FOCUS_RELATIONS,
    MODELS,
)
from ..queries import calibrations, viewport_camera
from .lens import RELATIVE_PATH, LensProperties, changed


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


def _cameras_in_file(settings: PetzvalCamera, _context: bpy.types.Context, _typed: str) -> list[str]:
    found = calibrations.of_camera(settings.id_data)
    return [one["name"] for one in found.get("cameras") or found.get("lenses", ())]


def _bodies_in_file(settings: PetzvalCamera, _context: bpy.types.Context, _typed: str) -> list[str]:
    return list(calibrations.of_camera(settings.id_data).get("bodies", ()))


def _shipped_sensors(_settings: PetzvalCamera, _context: bpy.types.Context, _typed: str) -> list[str]:
    return list(SENSORS)


class PetzvalCamera(LensProperties, bpy.types.PropertyGroup):
    """`Camera.petzval`."""

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
    calibration_file: StringProperty(
        name="Calibration",
        description="A file of camera calibrations: OpenCV's or ROS's YAML or JSON, COLMAP's cameras.txt, Kalibr's camchain, Basalt's or "
        "NVIDIA's JSON, 3DEqualizer's nodes for Nuke; an ST map (.exr) that distorts a picture; or a lensfun database (.xml, or a folder), "
        "the word lensfun for the installed one",
        subtype="FILE_PATH",
        options=RELATIVE_PATH,
    )
    calibration_camera: StringProperty(
        name="Camera in File",
        description="The name or number of the camera in the file, or the lens of a lensfun database. Empty: the only one",
        search=_cameras_in_file,
    )
    calibration_body: StringProperty(
        name="Body",
        description="The camera body in a lensfun database, whose sensor the picture is on. Empty: Blender's own sensor",
        search=_bodies_in_file,
    )
    aperture_mask: PointerProperty(
        name="Mask",
        description="A square picture of the opening, as wide as the stop: light passes where it is brighter than half. "
        "It stands instead of the blades",
        type=bpy.types.Image,
    )
    focus_mode: EnumProperty(name="Focus", description="What is sharp", items=FOCUS_MODES, update=changed)
    anchor: EnumProperty(
        name="Camera at",
        description="What stands at the camera's place and stays there while focusing. Focus distances count from it",
        items=ANCHORS,
        update=changed,
    )
    focus_relation: EnumProperty(
        name="Relation",
        description="How a focus distance moves the film. A focus object is focused on exactly",
        items=FOCUS_RELATIONS,
        update=changed,
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
        update=changed,
    )
    film_mode: EnumProperty(name="Film", description="How large the film is", items=FILM_MODES, update=changed)
    film_width: FloatProperty(
        name="Width",
        description="Width of the film",
        default=36.0,
        min=1e-3,
        max=1e6,
        soft_min=1.0,
        soft_max=300.0,
        subtype="DISTANCE_CAMERA",
        update=changed,
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
        update=changed,
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
        update=changed,
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
        update=changed,
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
        update=changed,
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
        update=changed,
    )
    scale_from_scene: BoolProperty(
        name="From the Scene",
        description="The lens has its true size: 1000 millimetres to a metre, by the scene's unit scale",
        default=True,
        update=changed,
    )
    scale_locked: BoolProperty(
        name="Locked Together", description="One scale for all three axes: the first", default=True, update=changed
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
        update=changed,
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
    use_sensor: BoolProperty(
        name="Sensor",
        description="A sensor that counts photons sees the picture: its colours where the lens parts wavelengths, and a raw file with its noise. "
        "Off: an ideal film",
        default=False,
    )
    sensor: StringProperty(
        name="Sensor File",
        description="A sensor's file, or a shipped sensor: sony-a7r2, nikon-d700",
        default="sony-a7r2",
        search=_shipped_sensors,
        search_options={"SUGGESTION"},
    )
    raw_file: StringProperty(
        name="Raw File",
        description="Where final renders write what the sensor says: .dng, .png or .exr, with the frame's number for ####. Empty: nowhere",
        default="",
        subtype="FILE_PATH",
    )
    match_viewport: BoolProperty(
        name="Viewport Follows",
        description="Set Blender's focal length (and sensor, where the film has a size of its own) so that the camera "
        "view frames what the lens will photograph",
        default=True,
        update=changed,
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
    blender_camera: FloatVectorProperty(
        description="Blender's own focal length and sensor width (mm) and its shift, as they were before they followed the lens",
        size=4,
        options={"HIDDEN"},
    )
    blender_sensor_fit: StringProperty(
        description="Blender's own sensor fit, likewise; empty: nothing follows the lens", options={"HIDDEN"}
    )
    version: IntProperty(
        description="Number of the defaults by which the lens was set up; 0: those of version 0.1", options={"HIDDEN"}
    )
    in_step: BoolProperty(
        description="The lens was set up here: Blender's camera may be kept in step", options={"HIDDEN"}
    )
