# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings and descriptions that the engine is given: plain typed data, no bpy and no engine.

This is the one declaration in Python. The engine deserializes cameras, render settings, shutters and lens settings whole into its own
types of the same fields (`engine/render/src/camera/description.rs` and others; tests/test_types.py compares the lists); materials, lamps and
worlds it reads by attribute. Colours are scene-linear Rec.709. Angles are in radians.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

#: Models of the camera that are made from a lens file.
OF_LENS_FILE = ("LENS", "IMAGE_BASED", "PARAXIAL", "THICK")

#: Kinds of ray that things may be hidden from.
RAYS = ("CAMERA", "DIFFUSE", "GLOSSY", "TRANSMISSION", "VOLUME_SCATTER", "SHADOW")
#: No limit on a number of bounces.
NO_LIMIT = 2**32 - 1
#: The most blades of a diaphragm that users are offered.
MOST_BLADES = 24

Colour = tuple[float, float, float]
Matrix4 = tuple[tuple[float, float, float, float], ...]
#: A camera at the world's origin that looks along -z.
IDENTITY: Matrix4 = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))
#: The focal length that a lens is scaled to: {"MILLIMETRES": f} or {"SCALE": factor}.
FocalLength = Literal["AS_PUBLISHED"] | dict[str, float]


def focal_length(millimetres: float | None) -> FocalLength:
    """The focal length, mm; None: as published."""
    return "AS_PUBLISHED" if millimetres is None else {"MILLIMETRES": millimetres}


@dataclass(frozen=True)
class ApertureMask:
    """A square grey picture over the diameter of the stop; light passes where it is brighter than half."""

    name: str
    side: int
    values: bytes = field(repr=False)  # side x side, rows from below


@dataclass(frozen=True)
class LensSettings:
    """The settings of a lens; None: as published."""

    focal_length: FocalLength = "AS_PUBLISHED"
    f_number: float | None = None  # None: wide open
    pupil_diameter_mm: float | None = None  # of the entrance pupil; goes before the f-number
    blades: int = 0  # fewer than 3: a round opening
    blade_rotation_rad: float = 0.0
    blade_curvature: float = 0.0  # 0: straight blades, 1: a round opening
    aperture_mask: ApertureMask | None = None  # the opening's shape instead of blades; turned like them
    coating: str | None = None  # wherever glass meets air, by name or layer by layer; None: as the lens file has it


@dataclass(frozen=True)
class LensReportSettings:
    """The light and the film of a report on a lens."""

    fields_deg: tuple[float, ...] = ()  # angles to the axis, counted at the entrance pupil; none: the report's own
    wavelengths_nm: tuple[float, ...] = ()  # in vacuum, that nearest the d line the main one; none: F, d and C
    azimuth_deg: float = 90.0  # of the fields, from right to up
    focus_distance_mm: float | None = None
    # The film where the spot of the axis is smallest, instead of where paraxial rays of the main wavelength meet.
    best_focus: bool = False
    defocus_mm: float = 0.0  # and so far behind that


@dataclass(frozen=True)
class Perspective:
    """The perspective of Blender's own camera."""

    focal_length_mm: float = 50.0
    film_width_mm: float = 36.0  # of the whole picture on Blender's sensor
    shift: tuple[float, float] = (0.0, 0.0)  # in units of the picture's larger side
    aperture_ratio: float = 1.0  # height over width of what a thin lens has out of focus


@dataclass(frozen=True)
class Focusing:
    """The meaning of a focus distance."""

    anchor: str = "ENTRANCE_PUPIL"  # ENTRANCE_PUPIL | FRONT_VERTEX | FILM
    relation: str = "EXACT"  # EXACT | THIN


@dataclass(frozen=True)
class FocusSettings:
    """The focus of a lens; a film distance goes before a point, a point before a distance."""

    distance: float | None = None  # Blender units; None: infinity
    focusing: Focusing = Focusing()
    point_world: tuple[float, float, float] | None = None
    film_distance_mm: float | None = None  # from the last vertex to the film's middle
    autofocus: tuple[float, float] | None = None  # picture point, 0 to 1 from the lower left; for the render to resolve


@dataclass(frozen=True)
class FilmSettings:
    """The film behind a lens."""

    width_mm: float = 36.0
    height_mm: float = 24.0
    tilt_rad: float = 0.0  # about its horizontal axis
    swing_rad: float = 0.0  # about its vertical axis
    shift_mm: tuple[float, float] = (0.0, 0.0)  # of the lens to the right and up against the film


@dataclass(frozen=True)
class Scattering:
    """Scattering in a lens."""

    roughness_nm: float = 2.0  # of its surfaces, rms
    cleanliness: float = 300.0  # dust on them: level of IEST-STD-CC1246; 0: none
    veiling_index: float = 0.01  # barrel and film: part of an even world's light


@dataclass(frozen=True)
class PhysicalExposure:
    """Exposure as a photographer sets it, beside the f-number."""

    shutter_s: float
    iso: float
    lumens_per_watt: float


@dataclass(frozen=True)
class Panorama:
    """The picture of a panoramic camera."""

    # A name, or {name: settings}: EQUIRECTANGULAR {"longitude_rad", "latitude_rad"} | EQUIANGULAR_CUBEMAP_FACE | MIRROR_BALL |
    # FISHEYE_EQUIDISTANT {"field_rad"} | FISHEYE_EQUISOLID {"focal_length_mm", "field_rad", "sensor_mm"} |
    # FISHEYE_LENS_POLYNOMIAL {"coefficients", "field_rad", "sensor_mm"} | CENTRAL_CYLINDRICAL {"longitude_rad", "height"}
    projection: str | dict[str, dict[str, Any]]
    shift: tuple[float, float] = (0.0, 0.0)  # in widths and heights of the picture


#: The word that stands for the installed lensfun database where a file of calibrations is named.
INSTALLED_LENSFUN = "lensfun"


@dataclass(frozen=True)
class CalibrationSettings:
    """The calibration of a calibrated camera."""

    # Of the file of calibrations, an ST map (.exr), a lensfun database (.xml, or a folder); or "lensfun": the installed one.
    path: str
    camera: str | None = None  # its name in the file, or the lens's in a lensfun database; None: the only one
    body: str | None = None  # in a lensfun database: the picture's diagonal is its sensor's; None: Blender's sensor
    f_number: float = 2.8  # of the vignetting of a lens in a lensfun database


@dataclass(frozen=True)
class SphericalStereo:
    """One eye of a pair that turns with the ray about the upright axis, a panoramic camera's or else the world's."""

    offset: float  # to the right of the ray, Blender units; a left eye has it negative
    convergence: float | None = None  # distance at which both eyes see the same in one place; None: parallel rays
    # Angles from the horizon at which the eyes begin to draw together, and are one; None: they keep their distance.
    pole_merge_rad: tuple[float, float] | None = None


@dataclass(frozen=True)
class CameraDescription:
    """The settings of a camera."""

    object_name: str
    matrix_world: Matrix4
    model: str = (
        "LENS"  # LENS | IMAGE_BASED | PARAXIAL | THICK | THIN | PINHOLE | ORTHOGRAPHIC | PANORAMIC | CALIBRATED
    )
    perspective: Perspective = Perspective()
    pixel_aspect: float = 1.0  # the height of a pixel over its width
    lens_path: str = ""
    lens: LensSettings = LensSettings()
    focus: FocusSettings = FocusSettings()
    film: FilmSettings = FilmSettings()
    scale_mm_per_unit: tuple[float, float, float] = (1000.0, 1000.0, 1000.0)
    wavelength_nm: float | None = None  # None: all that `spectrum` says
    spectrum: str = "VISIBLE"  # VISIBLE | THREE
    film_sensor: str | None = None  # the sensor whose channels see the wavelengths; None: the observer sees them
    scattering: Scattering = Scattering()
    exposes_by_f_number: bool = False  # what the lens takes of the light makes the picture darker
    white_balance: bool = True  # white is white in the middle of the picture
    precision: str = "AUTO"  # AUTO | F32 | F64: of the numbers in which rays leave through the lens
    exposure: PhysicalExposure | None = None  # None: radiance one is one in the middle of the picture
    orthographic_width: float = 1.0  # of the whole picture, Blender units
    panorama: Panorama | None = None
    calibration: CalibrationSettings | None = None
    spherical_stereo: SphericalStereo | None = None  # of a camera without a lens file; None: no stereo, or plain
    clip: tuple[float, float] = (0.0, float("inf"))  # depths between which camera rays see, Blender units


@dataclass(frozen=True)
class Caustics:
    """The caustics that are computed: light that surfaces reflect or refract after a diffuse scattering."""

    reflective: bool = True
    refractive: bool = True


@dataclass(frozen=True)
class KindLimits:
    """The most bounces of each kind, of all that there may be."""

    diffuse: int = NO_LIMIT
    glossy: int = NO_LIMIT
    transmission: int = NO_LIMIT
    volume: int = NO_LIMIT
    transparent: int = NO_LIMIT
    transparent_shadows: int = NO_LIMIT  # surfaces passed by shadow rays, those of the path before included
    caustics: Caustics = Caustics()


@dataclass(frozen=True)
class Approximations:
    """Approximations of indirect light."""

    # Surfaces are rougher for paths that were scattered with less than this density per steradian; 0: none are.
    filter_glossy: float = 0.0
    # The growth of footprints, over which bumps are computed, after a diffuse scattering: widths per length.
    widening: float = 0.0
    # {"REPLACE": {"bounces", "distance", "factor"}}: ambient occlusion instead of the bounces from that number on;
    # {"ADD": {"distance", "factor"}}: besides all light.
    fast_gi: Literal["OFF"] | dict[str, dict[str, float]] = "OFF"


@dataclass(frozen=True)
class SettingsDescription:
    """The settings of a render."""

    width: int
    height: int
    samples: int = 64
    noise_threshold: float = 0.0  # relative error at which a pixel has samples enough; 0: all get the same
    denoising: DenoisingDescription | None = None  # the error is what this leaves; None: it is that of the samples
    min_samples: int = 0  # before a pixel's error is first looked at; 0: 16
    seed: int = 0
    blue_noise: bool = False  # the errors of neighbouring pixels cancel, where all samples are rendered at once
    independent_pixels: bool = False  # neighbours share no noise, as denoising needs; through a lens each has more
    film_exposure: float = 1.0  # what the finished light is multiplied by
    # Left, bottom, width, height in pixels: the part that is looked at, with light missing near its edge; None: all.
    window: tuple[int, int, int, int] | None = None
    sample_offset: int = 0
    threads: int = 0
    max_bounces: int = 12
    kinds: KindLimits = KindLimits()
    # Most radiance, in the mean of its channels, that light may add to a sample; 0: no limit.
    clamp_direct: float = 0.0  # seen by the camera, or scattered once
    clamp_indirect: float = 0.0  # scattered more often
    approximations: Approximations = Approximations()
    # "BOX": one pixel | {"GAUSSIAN": width} | {"BLACKMAN_HARRIS": width}, as Cycles defines them and counts the width.
    filter: Literal["BOX"] | dict[str, float] = field(default_factory=lambda: {"BLACKMAN_HARRIS": 1.5})
    transparent_film: bool = False
    transparent_glass: float | None = None  # the most roughness of glass that the film is seen through; None: of none
    pipeline: str = "AUTO"  # AUTO | FILM | SCENE | HERO
    with_data: bool = False  # keep what `Job.data` gives
    integrator: str = "PATH"  # PATH | BIDIRECTIONAL
    light_tracing: bool = True  # small lights far out of focus send rays to the lens, where that is worth it


@dataclass(frozen=True)
class ShutterDescription:
    """The opening of the shutter, and the camera's matrices meanwhile."""

    openness: list[float] = field(default_factory=list)  # at even times over the exposure; empty: open all the time
    rolling: float | None = None  # from the top down, each row for this part of the exposure; None: all at once
    camera_keys: list[Matrix4] = field(default_factory=list)  # at even times over the exposure; empty: it stands still


@dataclass(frozen=True)
class BakeDescription:
    """A bake of an object's surface, as Blender names it. The choice of light is for COMBINED, and for DIFFUSE, GLOSSY and TRANSMISSION."""

    object_name: str
    # COMBINED | AO | SHADOW | POSITION | NORMAL | UV | ROUGHNESS | EMIT | ENVIRONMENT | DIFFUSE | GLOSSY | TRANSMISSION
    kind: str
    from_camera: bool = False  # the surface is seen from the camera, not from straight above
    direct: bool = True  # light that comes straight from emitters
    indirect: bool = True  # light that was scattered before
    color: bool = True  # light is as it is; else it is divided by the colour of its lobes
    diffuse: bool = True  # COMBINED: light of diffuse lobes
    glossy: bool = True  # of lobes of reflection
    transmission: bool = True  # of lobes of transmission
    emission: bool = True  # and of the surface itself


@dataclass(frozen=True)
class DenoisingDescription:
    """The denoising of a finished picture."""

    library: str  # the file of Open Image Denoise
    by_albedo: bool = True  # DENOISING_ALBEDO guides, where the render keeps it
    by_normal: bool = True  # and DENOISING_NORMAL beside it
    prefilter: str = "ACCURATE"  # NONE | FAST | ACCURATE: what becomes of the noise of both
    quality: str = "HIGH"  # FAST | BALANCED | HIGH
    use_gpu: bool = False  # where there is one
    memory_mb: int = 0  # that the filter may take; 0: as it wants


@dataclass
class MaterialDescription:
    """A material: its shader nodes, as the JSON of the add-on's `export/graph.py`."""

    name: str
    graph: str
    pass_index: int = 0
    displacement_method: str = "BUMP"  # BUMP | DISPLACEMENT | BOTH
    # What its nodes give out beside: a graph likewise, whose layers glow with them, and the numbers of these.
    aovs: tuple[str, list[int]] | None = None
    transparent_shadows: bool = True  # light samples go through what is transparent
    corrects_bumps: bool = True  # bent normals reflect into no surface, and light is dimmed where it grazes a bump
    emission_sampling: str = "AUTO"  # AUTO | NONE | FRONT | BACK | FRONT_BACK: light samples of its emission


@dataclass
class LightDescription:
    """A lamp. `matrix_world` maps the lamp's axes to the world; it shines along its -z."""

    object_name: str
    kind: str  # POINT | SPOT | SUN | AREA
    matrix_world: Matrix4
    color: Colour  # times energy: watts, for SUN watts per square metre
    radius: float = 0.0  # POINT, SPOT
    soft_falloff: bool = False  # POINT, SPOT: a disk that faces whoever looks at it, rather than a sphere
    angle_rad: float = 0.0  # SUN: full angular diameter
    shape: str = "RECTANGLE"  # AREA: RECTANGLE | ELLIPSE
    size: tuple[float, float] = (1.0, 1.0)  # AREA: full sides
    spread_rad: float = 3.141592653589793  # AREA
    spot_angle_rad: float = 0.785  # SPOT: full cone
    spot_blend: float = 0.15
    # What the colour is multiplied by: the nodes, as JSON of what `export/graph.py` makes of them.
    graph: str | None = None
    hidden_from: tuple[str, ...] = ()  # of RAYS: as an object, and so what it does not light
    sets: tuple[int, int] = (0, 0)  # of objects that it lights, and that throw shadows in its light
    light_group: int = 0  # its number; 0 is none
    max_bounces: int = 1024  # after which it lights nothing
    cast_shadow: bool = True


@dataclass
class WorldDescription:
    """The world."""

    color: Colour = (0.0, 0.0, 0.0)  # times strength
    image: int | None = None  # equirectangular, as Blender maps it; multiplied by `color`
    # Rotation of a Mapping node: world direction to texture direction, 3 x 3.
    rotation: tuple[tuple[float, float, float], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    hidden_from: tuple[str, ...] = ()  # of RAYS
    light_group: int = 0  # its number; 0 is none
    max_bounces: int = 1024  # scatterings of a path beyond which the sky is not sampled as a light
    cast_shadow: bool = True  # objects throw shadows in its light samples
    has_image: bool = False  # the nodes look an image up, or one that is missing
    # Instead of colour and image: the nodes, as JSON of what `export/graph.py` makes of them.
    graph: str | None = None
    # The graph of its AOV Output nodes, likewise, and the numbers of their values.
    aovs: tuple[str, list[int]] | None = None


Settings = TypeVar("Settings")


def changed(settings: Settings, changes: Mapping[str, Any]) -> Settings:
    """The settings with other values by name; "lens.f_number" is a value of the settings' own settings."""
    own: dict[str, Any] = {}
    inner: dict[str, dict[str, Any]] = {}
    for name, value in changes.items():
        first, dot, rest = name.partition(".")
        if dot:
            inner.setdefault(first, {})[rest] = value
        else:
            own[first] = value
    for first, values in inner.items():
        own[first] = changed(own.get(first, getattr(settings, first)), values)
    return dataclasses.replace(settings, **own)  # type: ignore[type-var]


def opened(focal_length_mm: float, pupil_diameter_mm: float) -> dict[str, Any]:
    """The change of a camera by which a thin lens of this focal length has an entrance pupil of this diameter."""
    return {"lens.f_number": focal_length_mm / pupil_diameter_mm}


def focused(camera: CameraDescription, found: Mapping[str, Any]) -> CameraDescription:
    """The camera with the focus that the engine found: by its film, or by groups inside of the lens."""
    if not found["moves_groups"]:
        return changed(camera, {"focus.film_distance_mm": found["film_distance_mm"]})
    far = found["focus_scale_mm"]
    distance = None if far is None else far / camera.scale_mm_per_unit[2]
    return changed(camera, {"focus.distance": distance, "focus.point_world": None, "focus.film_distance_mm": None})


def flat(settings: Any, prefix: str = "") -> dict[str, Any]:
    """Every value of nested settings by its dotted name."""
    found: dict[str, Any] = {}
    for one in dataclasses.fields(settings):
        value = getattr(settings, one.name)
        name = f"{prefix}{one.name}"
        if dataclasses.is_dataclass(value) and not isinstance(value, ApertureMask):
            found |= flat(value, f"{name}.")
        else:
            found[name] = value
    return found
