# SPDX-License-Identifier: GPL-3.0-or-later
"""What the engine is told of a scene: plain typed data, no bpy.

Colours are scene-linear Rec.709. The engine reads these objects by attribute.
"""

from __future__ import annotations

from dataclasses import dataclass, field

#: Models of the camera that are made from a lens file.
OF_LENS_FILE = ("LENS", "IMAGE_BASED", "PARAXIAL", "THICK")

#: Kinds of ray that things may be hidden from.
RAYS = ("CAMERA", "DIFFUSE", "GLOSSY", "TRANSMISSION", "VOLUME_SCATTER", "SHADOW")
#: Bounces that nobody counts.
NO_LIMIT = 2**32 - 1

Colour = tuple[float, float, float]
Matrix4 = tuple[tuple[float, float, float, float], ...]


@dataclass
class MaterialDescription:
    """A material: its shader nodes, as JSON of what `export/graph.py` makes of them."""

    name: str
    graph: str
    pass_index: int = 0
    displacement_method: str = "BUMP"  # BUMP | DISPLACEMENT | BOTH
    # What its nodes give out beside: a graph likewise, whose layers glow with them, and the numbers of these.
    aovs: tuple[str, list[int]] | None = None


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
    color: Colour = (0.0, 0.0, 0.0)  # times strength
    image: int | None = None  # equirectangular, as Blender maps it; multiplied by `color`
    # Rotation of a Mapping node: world direction to texture direction, 3 x 3.
    rotation: tuple[tuple[float, float, float], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    hidden_from: tuple[str, ...] = ()  # of RAYS
    light_group: int = 0  # its number; 0 is none
    # Instead of colour and image: the nodes, as JSON of what `export/graph.py` makes of them.
    graph: str | None = None


@dataclass(frozen=True)
class ApertureMask:
    """A square grey picture over the diameter of the stop; light passes where it is brighter than half."""

    name: str
    side: int
    values: bytes = field(repr=False)  # side x side, rows from below


@dataclass
class CameraDescription:
    object_name: str
    matrix_world: Matrix4
    model: str = "LENS"  # LENS | IMAGE_BASED | PARAXIAL | THICK | THIN | PINHOLE | ORTHOGRAPHIC
    pinhole_focal_length_mm: float = 50.0
    pinhole_film_width_mm: float = 36.0
    pinhole_shift: tuple[float, float] = (0.0, 0.0)
    pixel_aspect: float = 1.0  # the height of a pixel over its width
    lens_path: str = ""
    focal_length_mm: float | None = None
    focal_scale: float | None = None
    f_number: float | None = None
    pupil_diameter_mm: float | None = None
    blades: int = 0
    blade_rotation_rad: float = 0.0
    blade_curvature: float = 0.0  # 0: straight blades, 1: a round opening
    aperture_mask: ApertureMask | None = None  # the opening's shape instead of blades; turned like them
    roughness_nm: float = 2.0  # of the lens's surfaces, rms
    cleanliness: float = 300.0  # dust on them: level of IEST-STD-CC1246; 0: none
    veiling_index: float = 0.01  # barrel and film: part of an even world's light
    coating: str | None = None  # wherever glass meets air, by name or layer by layer; None: as the lens file has it
    exposes_by_f_number: bool = False  # what the lens takes of the light makes the picture darker
    focus_distance: float | None = None
    anchor: str = "ENTRANCE_PUPIL"  # ENTRANCE_PUPIL | FRONT_VERTEX | FILM
    focus_relation: str = "EXACT"  # EXACT | THIN
    autofocus: tuple[float, float] | None = None  # picture point, 0 to 1 from the lower left; for the render to resolve
    focus_point_world: tuple[float, float, float] | None = None
    film_distance_mm: float | None = None
    film_width_mm: float = 36.0
    film_height_mm: float = 24.0
    tilt_rad: float = 0.0
    swing_rad: float = 0.0
    shift_mm: tuple[float, float] = (0.0, 0.0)
    scale_mm_per_unit: tuple[float, float, float] = (1000.0, 1000.0, 1000.0)
    wavelength_nm: float | None = None  # None: all that `spectrum` says
    spectrum: str = "VISIBLE"  # VISIBLE | THREE
    precision: str = "AUTO"  # AUTO | F32 | F64: of the numbers in which rays leave through the lens
    # Shutter (s), ISO, lumens of a watt; None: radiance one is one in the middle of the picture.
    exposure: tuple[float, float, float] | None = None
    orthographic_width: float = 1.0  # of the whole picture, Blender units
    clip: tuple[float, float] = (0.0, float("inf"))  # depths between which camera rays see, Blender units


def focused(camera: CameraDescription, found: dict) -> dict:
    """The settings that give `camera` the focus that the engine found: by its film, or by groups inside of the lens."""
    if not found["moves_groups"]:
        return {"film_distance_mm": found["film_distance_mm"]}
    far = found["focus_scale_mm"]
    distance = None if far is None else far / camera.scale_mm_per_unit[2]
    return {"focus_distance": distance, "focus_point_world": None, "film_distance_mm": None}


@dataclass
class ShutterDescription:
    """How the shutter opens, and where the camera stands meanwhile."""

    openness: list[float] = field(default_factory=list)  # at even times over the exposure; empty: open all the time
    rolling: float | None = None  # from the top down, each row for this part of the exposure; None: all at once
    camera_keys: list[Matrix4] = field(default_factory=list)  # at even times over the exposure; empty: it stands still


@dataclass
class SettingsDescription:
    width: int
    height: int
    samples: int = 64
    noise_threshold: float = 0.0  # relative error at which a pixel has samples enough; 0: all get the same
    min_samples: int = 0  # before a pixel's error is first looked at; 0: 16
    seed: int = 0
    film_exposure: float = 1.0  # what the finished light is multiplied by
    blue_noise: bool = False  # the errors of neighbouring pixels cancel; ranges of samples then do not make the whole
    # Left, bottom, width, height in pixels: the part that is looked at, with light missing near its edge; None: all.
    window: tuple[int, int, int, int] | None = None
    sample_offset: int = 0
    threads: int = 0
    max_bounces: int = 12
    # Of those, how many of each kind.
    diffuse_bounces: int = NO_LIMIT
    glossy_bounces: int = NO_LIMIT
    transmission_bounces: int = NO_LIMIT
    volume_bounces: int = NO_LIMIT
    transparent_bounces: int = NO_LIMIT
    transparent_shadows: int = NO_LIMIT  # surfaces passed by shadow rays, those of the path before included
    # After a diffuse bounce.
    reflective_caustics: bool = True
    refractive_caustics: bool = True
    # Most radiance, in the mean of its channels, that light may add to a sample; 0: no limit.
    clamp_direct: float = 0.0  # seen by the camera, or scattered once
    clamp_indirect: float = 0.0  # scattered more often
    filter: str = "BLACKMAN_HARRIS"  # BOX: one pixel | GAUSSIAN | BLACKMAN_HARRIS, as Cycles defines them
    filter_width_px: float = 1.5  # of the last two, as Cycles counts it
    # Surfaces are rougher for paths that were scattered with less than this density per steradian; 0: none are.
    filter_glossy: float = 0.0
    # OFF | REPLACE: ambient occlusion instead of the bounces from that number on | ADD: besides all light.
    fast_gi: str = "OFF"
    fast_gi_bounces: int = 1
    fast_gi_distance: float = 10.0  # how far it looks
    fast_gi_factor: float = 1.0  # what the world counts, or the light that is added
    transparent_film: bool = False
    with_data: bool = False  # keep what `Job.data` gives
    pipeline: str = "AUTO"  # AUTO | FILM | SCENE | HERO
    integrator: str = "PATH"  # PATH | BIDIRECTIONAL


@dataclass
class Report:
    """What the export could not hand over, told to the user once each."""

    warnings: list[str] = field(default_factory=list)

    def warn(self, text: str) -> None:
        if text not in self.warnings:
            self.warnings.append(text)
