"""The types of the compiled module: the engine's interface for Python.

Lens space is in millimetres: z along the optical axis in the direction of the light, z = 0 at the first
vertex, x right and y up as seen from behind the film. Camera space is Blender's: x right, y up, looking along -z.
World space and all lengths without a unit in their name are in Blender units. Angles are in radians.
Every error is a subclass of `PetzvalError`; its message is one line: the fault, its place, the remedy.
"""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, final

import numpy as np
import numpy.typing as npt

from .description import (
    BakeDescription,
    CameraDescription,
    DenoisingDescription,
    LensReportSettings,
    LensSettings,
    LightDescription,
    MaterialDescription,
    Panorama,
    SettingsDescription,
    ShutterDescription,
    WorldDescription,
)

__all__ = [
    "CameraError",
    "Checkpoint",
    "FileReplacement",
    "Job",
    "Lens",
    "LensError",
    "PROCESSOR",
    "PetzvalError",
    "Plan",
    "Scene",
    "SceneBuilder",
    "SceneDraft",
    "SceneError",
    "__version__",
    "autofocus_by_json",
    "autofocus_json",
    "camera_info_json",
    "check_exr",
    "check_exposure",
    "check_replaceable",
    "checkpoint_problem",
    "calibration_json",
    "calibration_remarks",
    "calibration_text",
    "coverage_json",
    "distortion_map",
    "effects_json",
    "evaluate_graph",
    "denoising_seconds",
    "expose_pixels_json",
    "expose_sensor_json",
    "film_bytes_a_pixel",
    "film_of_lens_mm",
    "fitted_camera_json",
    "fitted_lens_json",
    "framing_json",
    "free_memory_bytes",
    "glass_json",
    "glasses_json",
    "lens_drawing_json",
    "lens_ghosts_json",
    "lens_groups",
    "lens_proof_json",
    "lens_reality_json",
    "lens_report_json",
    "merge_pictures_json",
    "osl_camera",
    "photographic_lens_json",
    "pointiness",
    "random_per_island",
    "read_bounded",
    "sensor_json",
    "sharp_points_json",
    "sharpness_json",
    "trace_surfaces_json",
    "write_calibration_map",
    "write_photographic_map",
    "write_distortion_map",
    "write_png",
]

_Matrix4 = tuple[tuple[float, float, float, float], ...]

class PetzvalError(Exception): ...
class LensError(PetzvalError): ...
class SceneError(PetzvalError): ...
class CameraError(PetzvalError): ...

__version__: str
PROCESSOR: str
"""The processor level that the engine was compiled for: "x86-64-v3", or the kind of processor where there is one engine for all."""

@final
class Lens:
    """A checked lens prescription, of a file of any kind that `petzval lens convert` reads."""

    def __new__(cls, path: str) -> Lens: ...
    @property
    def name(self) -> str: ...
    @property
    def remarks(self) -> list[str]:
        """The parts of the file that are not in the lens, or were taken for something else: lines `FILE:LINE:COLUMN: remark`."""
    def identity(self) -> str:
        """All numbers of the lens and its glasses: two lenses of one text are one lens."""
    def range_notes(self, wavelengths_nm: Sequence[float] = ...) -> list[str]:
        """A sentence on each glass whose index is not known at all of these wavelengths, or between them; of none given, at those
        that are seen, 380 to 780 nm. Beyond the known range they keep the index of its end."""
    def written(self, kind: str) -> tuple[str, list[str]]:
        """The text of a `lens` or `zmx` file, and the parts of the lens that cannot stand in one."""
    @property
    def surface_count(self) -> int: ...
    def summary_json(self) -> str:
        """The lens's object of `petzval lens list --json`: its header, focal length, f-number of the beam that comes through wide open and
        back focus at the d line, and those numbers beside the source's (`published`)."""
    def info_json(
        self,
        settings: LensSettings | None = None,
        *,
        wavelength_nm: float = ...,
        focus_distance_mm: float | None = None,
    ) -> str:
        """The object of `petzval lens info --json`. `focus_distance_mm` is measured along the axis from the
        entrance pupil's centre to the plane of sharp focus; None or inf is infinity. A lens that focuses by groups inside
        does so, the eye's lens too; of others the film moves. `pupil_diameter_mm`, of the entrance pupil, goes before `f_number`.

        `f_number` counts the circle that holds the opening, `f_number_by_area` a round one of the opening's area
        `stop_area_mm2`. Beside the keys' names: `film_z_mm` and `total_track_mm` are those of the film in force; `seidel` and
        `chromatic` are sums of `seidel_by_surface` and `chromatic_by_surface` (mm) for a chief ray at
        `seidel_field_deg`; field angles are measured from the axis before the lens, at the present opening:
        up to `vignetting_free_field_deg` no rim but the stop's cuts any of the beam, at
        `half_vignetted_field_deg` half as much of the stop's area is filled as on the axis, beyond
        `largest_field_deg` nothing comes through. `axial_beam_cut_by_surface`: the index of a surface that cuts
        the beam on the axis; the first angle is then 0. `seidel_missing`: the reason why there are no sums. Values that are infinite or do
        not exist are null."""
    def trace_json(
        self,
        rays_json: str,
        settings: LensSettings | None = None,
        *,
        from_film: bool = False,
        precision: str = "f64",
        focus: tuple[float, float] | None = None,
    ) -> str:
        """The input and output of `petzval lens trace`; `precision` is "f64" or "f32". `focus`, the distance as for `info_json`, mm, and a wavelength,
        nm, moves the groups of a lens that focuses by them; others have the same surfaces at every distance."""

def lens_groups() -> list[str]:
    """The words that `# group:` of a lens file may have, in the order of lists."""

def lens_drawing_json(
    lens: Lens,
    settings: LensSettings | None = None,
    fields_deg: Sequence[float] = ...,
    rays: int = 7,
    *,
    wavelength_nm: float = ...,
    focus_distance_mm: float | None = None,
) -> str:
    """The data of the drawing of `petzval lens draw`, in the y-z plane; places are [z, y] in lens space, mm. surfaces: a row each (points
    from the lower rim to the upper, hole_mm, is_mirror, glass_behind or null); stop, its surface's index, and stop_semi_diameter_mm;
    fields: angle_deg and rays, each a list of places from before the lens to the film, `rays` from each field evenly over the light that
    comes through, none where nothing does; film, a line; and of `info_json` name, wavelength_nm, efl_mm, f_number, focus_distance_mm,
    film_z_mm, the principal planes and the pupils. Without fields: the axis, 0.7 of the design's half field, and that."""

def lens_report_json(
    name: str, lens: Lens, lens_settings: LensSettings, settings: LensReportSettings, options: dict[str, Any]
) -> str:
    """A report by its name, with its own options; `petzval/lens_reports` has a file for each.

    Every report is an object with name, efl_mm, f_number, focus_distance_mm, film_z_mm, wavelengths_nm, main_wavelength (its index),
    azimuth_deg, airy_radius_mm, half_field_deg, and the keys below. Pairs are [sagittal, tangential]. A field from which nothing
    comes has is_dark and no more. Without fields: 0, 0.7 and all of the half field, or `count` evenly over it.

    spots (rays over the width of a beam, defocus_mm): defocus: for each of `defocus_mm` fields: angle_deg, centroid_mm from the film's
    middle, chief_mm, rms_mm and largest_mm from the centroid, lines: wavelength_nm, rms_mm about its own centroid_mm, points_mm.

    fans (rays): fields: angle_deg, tangential and sagittal, each a list by wavelength of pupil (in radii of the stop), error_mm from the
    main wavelength's ray through the stop's middle, path_waves, longer than the middle ray's of that wavelength.

    mtf (highest_per_mm, steps, heights, height_step_per_mm): frequencies_per_mm, steps + 1 from 0, and fields: angle_deg, height_mm,
    sagittal and tangential (the frequency's direction), each contrast, geometric (rays alone) and limit (diffraction alone).
    height_frequencies_per_mm, 0 to 4 steps, and heights: the same from the axis to the largest field.

    psf: fields: angle_deg, height_mm, strehl by wavelength; a picture of side x side values, step_mm apart, rows from below, the middle
    one where the middle of all rays' light lies, all wavelengths together, in units of the brightest that this pupil makes without
    aberrations; and the part of the light that is encircled within radii_mm. A field that is spread too far for waves has spread_mm and
    spread_times, over λN, instead.

    distortion (count): height_by_slope_mm and fields: angle_deg, and of the ray through the middle of the stop height_mm,
    straight_height_mm (by the tangent; null from 90 degrees on), even_height_mm (by the angle), tangential_focus_mm and
    sagittal_focus_mm from the film, along z, colour_mm: by wavelength, from the main one's height.

    illumination (count): fields that are lit: angle_deg, height_mm, relative to the axis (null where that is dark), projected_sr.

    transmission (spectrum_nm): the light of these wavelengths that passes: fields, each angle_deg, parts (by wavelength, the mean of the
    light that no rim stops; null where nothing comes through) and is_dark; t_number (of white light in the film's middle; null where that
    is dark), coating_is_assumed (the file says nothing of it), coatings, each name, before (the medium behind the first surface that has
    it) and reflected (at right angles, by wavelength), and unknown_absorption: glasses that count as clear."""

def lens_ghosts_json(
    lens: Lens,
    settings: LensSettings,
    *,
    angle_deg: float = 0.0,
    azimuth_deg: float = 90.0,
    wavelength_nm: float = 550.0,
    focus_distance_mm: float | None = None,
    film_mm: tuple[float, float] | None = None,
    reflections: int = 2,
    brute_force_rays: int = 0,
    seed: int = 0,
) -> str:
    """The answer of `petzval lens ghosts` for a far source at an angle to the axis, up at an azimuth of 90 degrees, whose light has the
    irradiance one before the lens. ghosts, the brightest first: surfaces (that reflect, in the order of the light, the first of the
    lens is 0), irradiance (of an even disc as wide), radius_mm (of that), centre_mm (in the picture, right and up from its middle),
    light_mm2 (irradiance times area) that gets to the film's plane, and on_film_mm2 of it; on_film_mm2 of all; and of the setting name,
    wavelength_nm, f_number, focus_distance_mm, angle_deg, azimuth_deg, film_mm (by default the lens file's, or 36 by 24), reflections.
    brute_force (null unless asked for): rays, on_film_mm2 by the number of reflections, and its standard error_mm2."""

def lens_proof_json(lens: Lens, settings: LensSettings, options: dict[str, Any]) -> str:
    """What `petzval lens prove` proves of all rays between film and lens: the certificate of docs/proofs.md without its hashes. Options:
    film_radius_mm (or null), focus_distance_mm (or null), wavelengths_nm (two), undecided (part of the volume), seconds, threads."""

def lens_reality_json(
    lens: Lens,
    settings: LensSettings,
    *,
    lensfun: str | PathLike[str] | None = None,
    product: str | None = None,
    marked_mm: float | None = None,
    crop_factor: float | None = None,
    f_numbers: Sequence[float] = ...,
    focus_distance_mm: float | None = None,
    sensor: str = ...,
    colour_f_number: float = 8.0,
    count: int = 21,
) -> str:
    """The answer of `petzval lens reality`: the lens by rays beside the calibration of its product in a lensfun database. name, efl_mm,
    f_number, focus_distance_mm; product and place (its file and line there), marked_mm (the focal length of the calibration),
    crop_factor, corner_mm. distortion (null where none was measured): scale_mm, the free scale; rms_mm (over the area) and worst_mm
    apart; own_mm, the lens's largest distortion; rows: angle_deg, height_mm by rays, measured_mm, and rays_part and measured_part
    of the height without distortion. vignetting: by f_number, apart (0: measured there), rows: angle_deg, height_mm, rays_stops,
    measured_stops. colour, at colour_f_number through the channels of `sensor`: angle_deg, height_mm, red_mm, blue_mm,
    measured_red_mm, measured_blue_mm, from green, outwards."""

def glass_json(name: str, catalogue: str | None, wavelengths_nm: Sequence[float], thickness_mm: float) -> str:
    """A glass of the shipped catalogues, or of the .agf or .yml file `catalogue`: name, source, makers (that have one of this name, the
    first is taken), formula and coefficients (null for vacuum), range_nm ([0, null] for all), nd, abbe (null: no dispersion),
    transmittance_is_known, remarks, range_note (on wavelengths where the index is not known; null: there are none), and indices, a row
    a wavelength: wavelength_nm, index, is_known (else it is that at the end of the range) and transmittance, of `thickness_mm` inside
    (null: not known)."""

def glasses_json(catalogue: str | None) -> str:
    """glasses: token, nd and abbe (null: no dispersion) of each of a catalogue; and remarks."""

def trace_surfaces_json(cases_json: str, *, precision: str = "f64") -> str:
    """The input and output of `petzval surface trace`; `precision` is "f64", "f32" or "printed"."""

def camera_info_json(camera: CameraDescription, width: int, height: int) -> str:
    """The facts of a lens for the panel and the viewport: efl_mm, bfd_mm, f_number (in force), widest_f_number, t_number (null: dark),
    coatings (names), coating_is_assumed (the file says nothing of it), unknown_absorption (glasses that count as clear),
    film_z_mm, film_distance_mm, focus_distance_mm (from the entrance pupil; null: infinity), focus_scale_mm (the same as
    the camera's anchor and relation count it), magnification, fov_horizontal_rad,
    fov_vertical_rad, fov_diagonal_rad, widest_angle_rad, picture_width_mm, picture_height_mm (the used part of the film),
    viewport_focal_length_mm with picture_width_mm and viewport_shift (a Blender camera that frames the same picture),
    entrance_pupil_diameter_mm, lens_name, surfaces, zoom_range_mm (null: no zoom lens), focuses_inside (groups inside of
    the lens focus it, not the film), remarks (on rows of the lens file that could not be used), beyond_range (glasses that are not known
    for all of the light: of wavelength_nm, or all visible)."""

def calibration_json(path: str) -> str:
    """The content of a file of calibrations, or of a lensfun database ("lensfun": the installed one): format, remarks, and for each of
    cameras name, model, size_px, parameters by name, covered (the part of the picture that shows something), reason (why the rest does not;
    null), horizontal_field_deg, vertical_field_deg (null: an edge shows nothing), largest_angle_deg, valid_to_deg (from the axis; null:
    everywhere), focal_px (null: straight ahead is not seen). Of a lensfun database also lenses: name, mounts, focal_range_mm, crop_factors,
    measured (numbers of measurements of distortion, vignetting, lateral colour); and bodies, the names of the camera bodies."""

def photographic_lens_json(camera: CameraDescription, width: int, height: int) -> str:
    """The lens of a lensfun database that is the camera's calibration, at its setting: as one of `calibration_json`'s cameras, and marked_mm
    (the focal length on the lens), film_width_mm, corner_stops (illumination of the corner; null: not measured), corner_lateral_px (red and
    blue outside of green in the corner; null: not measured), remarks."""

def calibration_text(path: str, camera: str | None, format: str) -> str:
    """A file's cameras, or the one of that name, as opencv-yaml, opencv-json, ros or colmap."""

def write_calibration_map(
    path: str, camera: str | None, size: tuple[int, int] | None, undistorts: bool, comments: str, output: str
) -> float:
    """A calibration's ST map into an OpenEXR file, as `write_distortion_map`; the share of its pixels that have a source. The other picture
    is that of the pinhole with the same middle and scale there, as large."""

def write_photographic_map(
    camera: CameraDescription, size: tuple[int, int], undistorts: bool, comments: str, output: str
) -> float:
    """`write_calibration_map` of the lens of a lensfun database that is the camera's calibration."""

def calibration_remarks(camera: CameraDescription, width: int, height: int) -> list[str]:
    """Sentences on a calibrated camera: the part of its picture that shows nothing and why, and the effects of its lens that were not
    measured."""

def fitted_camera_json(
    camera: CameraDescription,
    size: tuple[int, int],
    options: Mapping[
        str, Any
    ],  # model, coefficients (None: those that the lens's symmetry leaves), centre ("PUPIL" | "NEAREST")
    name: str,
    format: str | None,  # as `calibration_text`
    ray_map: tuple[str, str] | None,  # file and comments
    residual_map: tuple[str, str] | None,
) -> tuple[str, str | None]:
    """The answer of `petzval lens calibrate`, and the calibration's text in that format. name, efl_mm, wavelength_nm, focus_distance_mm
    (null: infinity), size_px, picture_mm; model, parameters by name, free (those that were found); lit (the part of the picture that chief
    rays light, in which the model was fitted), rms_px, worst_px, worst_at_px, worst_angle_deg, largest_angle_deg; covered, reason,
    horizontal_field_deg, vertical_field_deg, valid_to_deg as `calibration_json`; centre_z_mm and pupil_z_mm (from the first vertex),
    wander_mm (of the chief rays' crossings, from the centre), elsewhere (rms_px and worst_px at other distance_mm), rays, steps."""

def fitted_lens_json(lens: Lens, settings: LensSettings, options: Mapping[str, Any]) -> tuple[str, str, list[str]]:
    """The answer of `petzval lens fit`, the text of the fitted lens file, and the parts of the lens that cannot stand in one. Options:
    calibration (its path), camera (None: the only one), pixel_pitch_um and film_mm (pairs, or None), wavelength_nm, focus_distance_mm
    (None: infinity), adjust (names), gaps (None, or {"MILLIMETRES" | "PART": tolerance}) and surfaces (before them; None: all). The answer:
    name, calibration, model, size_px, pixel_pitch_um, wavelength_nm, compared (part of the picture), points; before and after: rms_px,
    worst_px, worst_at_px, rms_um, worst_um, efl_mm, focus_distance_mm (null: infinity), film_distance_mm; scale; gaps: surface, before_mm,
    after_mm, tolerance_mm, is_at_end, effect_px (of all of the tolerance); alike (pairs that do the same to the picture), steps."""

def sensor_json(sensor: str, iso: float | None) -> str:
    """The data of a sensor, by the name of a shipped one or a file, at a film speed (None: its own): name, source, licence, pixel_source,
    assumed, pixel_pitch_um, mosaic, bits, black_level_dn, base_iso, saturation_iso, peak_quantum_efficiency, is_efficiency_found; at that speed
    iso, gain_dn_per_e, saturation_e, read_noise_e, dynamic_range_stops, dark_current_e_per_s, dsnu_e, prnu_percent, white_e_per_lx_s (by
    channel), channels_from_xyz (rows; null: no colours), visible_below_lx_s (where the noise of white is 1 % of it)."""

def check_exposure(sensor: str, exposure: dict[str, Any]) -> None:
    """Raises where a sensor or its exposure is none."""

def expose_sensor_json(sensor: str, exposure: dict[str, Any], picture: str, output: str) -> str:
    """Photographs an OpenEXR picture (R, G and B, scene-linear Rec.709) into a raw file: .dng, .png or .exr. `exposure` has fields of the engine's
    `ExposureRequest`: iso, shutter_s, picture_iso, lux_seconds, nits, f_number, photons, wavelength_nm, temperature_c, exit_pupil_mm, pitch_um,
    mosaic, seed, frame, noiseless. Gives size, iso, gain_dn_per_e, white_e, dark_e, saturated, below_zero, numbers."""

def expose_pixels_json(sensor: str, exposure: dict[str, Any], pixels: npt.NDArray[np.float32], output: str) -> str:
    """As `expose_sensor_json`, for a picture in memory: (height, width, 4), rows from below."""

def write_png(pixels: npt.NDArray[np.uint16], output: str) -> None:
    """A picture of 16 bits as PNG: (height, width, 3), or 1 for grey, first row at the top."""

def coverage_json(camera: CameraDescription, width: int, height: int) -> str:
    """The part of the picture that the lens lights, by exact rays: dark_part (0 to 1), lit_diameter_mm (of the circle on an upright film,
    no more than the picture's diagonal), complaint (the dark part, its cause and the remedy; null if the lens lights the picture)."""

def film_of_lens_mm(camera: CameraDescription, width: int, height: int) -> tuple[float, float]:
    """Width and height in mm of the film for which the lens is made, at its present size: by its file, or if that has none, a film of the
    picture's shape whose corners see the half field of its design. The description's own film has no part in it."""

def framing_json(camera: CameraDescription, width: int, height: int, by: str) -> str:
    """The settings with which the lens, focused as it is, has the frame of the pinhole of the description's own focal length, sensor width
    and shift: by "FOCAL_LENGTH" (the film is then that sensor) or "FILM": focal_length_mm (null: as it was), film_width_mm, film_height_mm,
    shift_mm, angle_rad along the larger side, and reaches_edges: light through the middle of the pupil reaches the film's edges."""

def distortion_map(
    camera: CameraDescription, width: int, height: int, wavelength_nm: float, direction: str
) -> npt.NDArray[np.float32]:
    """(height, width, 4), first row at the bottom: the place in the other picture to take a pixel from, x and y from 0 to 1 from the
    lower left, and twice 1 where that is in the other picture, else 0; all 0 where the lens sees nothing. "DISTORT": the pixels are the lens's and
    the other picture the pinhole's that frames the same; "UNDISTORT": the other way. By the mean rays of the clear pupil."""

def write_distortion_map(
    camera: CameraDescription,
    width: int,
    height: int,
    maps: Sequence[tuple[str, float]],  # names of layers and wavelengths; "": the file's own picture
    direction: str,
    comments: str,
    output: str,
) -> list[float]:
    """Writes the distortion map into a file; returns the share of each map's pixels that have a source."""

def osl_camera(camera: CameraDescription, width: int, height: int) -> str:
    """The lens as a camera of Cycles: the text of a script. Unsupported features are refused with the surface that has them."""

def autofocus_json(scene: Scene, camera: CameraDescription, width: int, height: int, point: tuple[float, float]) -> str:
    """The focus on the hit of a picture point, (0, 0) lower left to (1, 1) upper right, by the smallest spot of exact
    rays: film_distance_mm, focus_scale_mm (the focus distance that says the same; null: infinity), moves_groups (groups
    inside of the lens have moved, not the film: only the distance says so), tilt_rad, swing_rad, rms_spot_mm, subject_world (null: nothing is there, the focus is at infinity). The camera's own focus
    does not count."""

def autofocus_by_json(
    camera: CameraDescription,
    width: int,
    height: int,
    point: tuple[float, float],
    distance_to: Callable[[tuple[float, float, float], tuple[float, float, float]], float | None],
) -> str:
    """The focus on a picture point by the caller's rays: `distance_to(origin, direction)` in world space, the direction
    a unit vector; None: nothing is there. Called a few times, in the caller's thread; its exceptions come back."""

def sharpness_json(
    camera: CameraDescription,
    width: int,
    height: int,
    columns: int,
    rows: int,
    confusion_mm: float | None = None,
) -> str:
    """The surface of sharp focus of a camera with a lens: confusion_mm, the circle of confusion's diameter (by default 1/1500 of the
    picture's diagonal); points, row by row from below over a grid whose outer lines are the picture's edges, null where no light comes
    from: place (from the picture's middle, in its width and height), from and towards (the mean ray, world space), and distances along it
    in Blender units: sharp (null: infinity), near (null: nowhere sharp enough) and far (null: infinity, or as near); pupil, the middle of
    the entrance pupil (world; null: at infinity), and pupil_radii, across and up."""

def sharp_points_json(
    camera: CameraDescription, width: int, height: int, points_world: Sequence[tuple[float, float, float]]
) -> str:
    """The film that shows three points sharp: the same keys; tilt_rad and swing_rad are found, too, and rms_spot_mm is
    the largest of three."""

def free_memory_bytes() -> int | None:
    """The memory that this process may still take of the machine's, or of its container's, bytes; None: the system does not say."""

#: The domain of values ("POINT": vertices, "CORNER": corners of faces, as `loops` number them, "TRIANGLE"), and these, one a row.
_Values = tuple[str, npt.NDArray[np.float32]]

@final
class SceneBuilder:
    """Takes a scene apart from Python, piece by piece; `build` checks it and builds the trees."""

    def __new__(cls) -> SceneBuilder: ...
    def add_image(
        self,
        name: str,
        pixels: npt.NDArray[np.float32] | npt.NDArray[np.uint8],  # (height, width, 4), first row at the bottom
        *,
        srgb: bool,  # values are sRGB-encoded (uint8 or float); False: linear or non-colour
    ) -> int: ...
    def add_tiles(self, name: str, tiles: Sequence[tuple[int, int]]) -> int:
        """An image of tiles (UDIM): the number of each, 1001 + column + 10 row, and its index among the images. Returns its own index; the
        images that it is made of may be forgotten then."""
    def add_material(self, material: MaterialDescription) -> int:
        """The material's index."""
    def add_mesh(
        self,
        name: str,
        positions: npt.NDArray[np.float32],  # (vertices, 3), object space
        triangles: npt.NDArray[np.uint32] | npt.NDArray[np.int32],  # (triangles, 3), vertex indices
        *,
        loops: npt.NDArray[np.uint32] | npt.NDArray[np.int32] | None = None,  # (triangles, 3), corners of faces
        corner_normals: _Values | None = None,  # rows of 3, object space
        uv_maps: dict[str, _Values] | None = None,  # rows of 2
        attributes: dict[str, _Values] | None = None,  # rows of 4
        material_slots: npt.NDArray[np.int32] | None = None,  # (triangles,) slot of each triangle
        moved_positions: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]] | None = None,  # a frame before, after
        # Vertices and, if it has them, corner normals, at even times over the exposure.
        poses: Sequence[tuple[npt.NDArray[np.float32], _Values | None]] | None = None,
        grids: Sequence[Any] | None = None,  # fields of a volume, as `addon/export/grids.py` makes them
        keeps_opacity: bool = False,  # the volume is as opaque however large the object is
        # True for pixels of the viewport, False for units; the length of an edge; the off-screen scale; the most halvings of an edge;
        # the triangles that there is room for.
        dicing: tuple[bool, float, float, int, int] | None = None,
    ) -> int:
        """Triangles with a non-finite corner or without area are left out and counted in `warnings`."""
    def add_curves(
        self,
        name: str,
        keys: npt.NDArray[np.float32],  # (keys, 4), object space, and the radius
        first_keys: npt.NDArray[np.int32],  # (strands + 1,), indices of keys; the last is how many there are
        shape: str,  # RIBBON, THICK, THICK_LINEAR
        *,
        pieces: int = 1,  # of a ribbon's segment
        first_number: int = 0,  # of the first strand: by theirs they get random numbers
        uv_maps: dict[str, npt.NDArray[np.float32]] | None = None,  # name -> (strands, 2), where roots are
        attributes: dict[str, tuple[bool, npt.NDArray[np.float32]]] | None = None,  # by key, else by strand; 4 each
        moved_keys: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]] | None = None,  # keys, before and after
        poses: Sequence[npt.NDArray[np.float32]] | None = None,  # as `keys`, at even times over the exposure
    ) -> int:
        """Hair and other curves; `add_instance` takes their index as it takes a mesh's. Strands with a key that is not finite are
        left out and counted in `warnings`."""
    def add_points(
        self,
        name: str,
        points: npt.NDArray[np.float32],  # (points, 4), object space, and the radius
        *,
        attributes: dict[str, npt.NDArray[np.float32]] | None = None,  # name -> (points, 4)
        moved_points: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]
        | None = None,  # (points, 3), before, after
        poses: Sequence[npt.NDArray[np.float32]] | None = None,  # as `points`, at even times over the exposure
    ) -> int:
        """A point cloud, as `add_curves`. Points that are not finite are left out and counted in `warnings`."""
    def add_instance(
        self,
        object_name: str,
        mesh: int,
        matrix_world: Sequence[Sequence[float]],
        materials: Sequence[int],
        *,
        hidden_from: Sequence[str] = ...,
        links: tuple[int, int, int, int] | None = None,  # `Links.of` of `addon/export/linking.py`
        asset_name: str | None = None,
        moved: tuple[Sequence[Sequence[float]], Sequence[Sequence[float]]] | None = None,
        keys: Sequence[Sequence[Sequence[float]]] | None = None,  # matrices at even times over the exposure
        info: tuple[tuple[float, float, float, float], int, float] | None = None,  # colour, pass index, random
        light_group: int = 0,  # its number; 0 is none
        shadow_terminator: tuple[float, float] = ...,  # Blender's geometry and shading offsets of shadow terminators
        is_holdout: bool = False,  # the camera sees a hole instead
        is_catcher: bool = False,  # its shadows alone are wanted: for `Job.shadow`
        is_baked: bool = False,  # its surface is what `Job` bakes
        occlusion_distance: float = 0.0,  # of rays that leave it, instead of the settings' `fast_gi_distance`; 0: none
        others: tuple[npt.NDArray[np.float64], npt.NDArray[np.float32]] | None = None,  # (n, 4, 4) and (n,)
    ) -> None:
        """`materials[slot]` is a material index; slots past its end take the last; empty: the default grey.

        `asset_name`: the topmost parent; `moved`: `matrix_world` a frame before and a frame after; `others`: `matrix_world` and the random
        number of further instances that are alike but for these."""
    def add_light(self, light: LightDescription) -> None:
        """Adds a lamp."""
    def set_world(self, world: WorldDescription) -> None:
        """Never called: a black world."""
    def set_viewport(
        self,
        object_name: str,
        matrix_world: Sequence[Sequence[float]],
        # The focal length in widths and heights of the picture, or 1 over these of an orthographic one, Blender units; and where the axis
        # meets the picture, from 0 to 1.
        frame: tuple[tuple[float, float], tuple[float, float]],
        pixels: tuple[int, int],
        panorama: Panorama | None = None,  # instead of `frame`
        is_orthographic: bool = False,
        dices: bool = False,  # another camera's, by whose pixels alone meshes are diced
    ) -> None:
        """Sets the frame of Blender's own camera, for shader graphs that ask for it, and meshes that are diced."""
    def warnings(self) -> list[str]: ...
    def build(
        self, camera_position: tuple[float, float, float], threads: int = 0, previous: Scene | None = None
    ) -> Scene:
        """Builds the trees, from those of a previous scene where only shapes and places differ. The builder is empty
        afterwards. The camera's position keeps f32 exact near it."""

    # For a scene that is edited: one builder for all of its scenes.
    def forget_image(self, index: int) -> None:
        """Frees an image's index for the next that is added; all that names it is to be forgotten or replaced, too."""
    def forget_material(self, index: int) -> None: ...
    def forget_mesh(self, index: int) -> None:
        """Curves and points likewise."""
    def draft(self, origin: tuple[float, float, float]) -> SceneDraft:
        """The scene that was told, without its trees. Images, materials and meshes stay in the builder, at their indices; instances,
        lights and the world are to be added again for the next."""

@final
class SceneDraft:
    def build(self, threads: int = 0, previous: Scene | None = None, *, is_final: bool = False) -> Scene:
        """Builds the scene, once. Takes the unchanged parts from the previous draft's scene: rays are slower then than in
        `SceneBuilder.build`'s scenes. Not so where it is final: trees are as that builds them."""

@final
class Scene:
    def warnings(self) -> list[str]:
        """The parts that were left out when the scene was built."""
    @property
    def triangle_count(self) -> int: ...
    @property
    def segment_count(self) -> int: ...
    @property
    def point_count(self) -> int: ...
    @property
    def instance_count(self) -> int: ...
    @property
    def moving_count(self) -> int:
        """Instances that move or change their shape while the shutter is open."""
    @property
    def bvh_seconds(self) -> float: ...

@final
class Plan:
    """The simulated effects of a camera's lens in one picture, and why."""

    def __new__(
        cls,
        scene: Scene,
        camera: CameraDescription,
        settings: SettingsDescription,
        over_the_shutter: Sequence[CameraDescription] = ...,
        *,
        effects: dict[str, str] = ...,  # name: "auto" | "on" | "off"; what is not named is auto
        quality: float = 1.0,  # tolerances are divided by it
        ghost_reflections: int = 2,  # 2 | 4
        shutter: ShutterDescription | None = None,  # where anything but the lens moves
    ) -> Plan: ...
    def json(self) -> str:
        """effects: a row each (effect, measure, is_unbounded, unit, tolerance, word, decision "on" | "off", is_available,
        is_uncertain, predicted_cost, why), measure null where it is not measured or unbounded; quality; camera (model "exact" |
        "gaussian" | "pinhole" | "as given", wavelengths, pipeline, round_f_number); look (depths in Blender units, open_part,
        exposure, brightest: towards, irradiance, part, place or null; coincident_faces: objects, part of the picture, text);
        seconds."""
    def window(self, border: tuple[int, int, int, int], size: tuple[int, int]) -> tuple[int, int, int, int] | None:
        """The part of a picture (left, bottom, width, height) to render for a border of it, in which no light of the rest belongs; None: all."""
    def forecast(self, scene: Scene, camera: CameraDescription, settings: SettingsDescription) -> str:
        """The plan of `json` with predicted (seconds, after_seconds of them for stray light, samples, threads, camera_part) and each row's
        predicted_cost, a part of the time without the effect: renders a little for that, about 0.1 s."""

def effects_json() -> str:
    """The closed list: name, unit, is_available, tolerance at quality 1, in the order of reports."""

#: Settings; of each pixel, rows from below, its triangle (below 0: none), the weights of the first and second corner there (pixels, 2), how these
#: change from column to column and from row to row, first the first (pixels, 4), and a number that chooses its random numbers (None: its own).
_Bake = tuple[
    BakeDescription,
    npt.NDArray[np.int32],
    npt.NDArray[np.float32],
    npt.NDArray[np.float32],
    npt.NDArray[np.uint32] | None,
]

@final
class Job:
    """One render. Starts at once in threads of its own; every method returns without waiting unless it says so."""

    def __new__(
        cls,
        scene: Scene,
        camera: CameraDescription,
        settings: SettingsDescription,
        over_the_shutter: Sequence[CameraDescription] = ...,
        *,
        plan: Plan | None = None,  # without one, the camera as it is described
        mattes: Sequence[str] = ...,  # OBJECT | MATERIAL | ASSET | OBJECT_INDEX | MATERIAL_INDEX
        matte_levels: int = 6,
        neighbours: tuple[CameraDescription, CameraDescription] | None = None,
        light_groups: int = 0,
        parts: Sequence[str] = ...,  # of light, for `part`
        mist: tuple[float, float, float] = ...,  # start, depth, power of the falloff: 0, 1, 1
        catches: bool = False,  # keeps what `shadow` and `over_photograph` need
        checkpoint: tuple[str, str, float] | None = None,  # file, fingerprint of the picture, seconds between two
        shutter: ShutterDescription | None = None,  # where anything but the lens moves
        occlusion_distance: float | None = None,  # length of the rays of AMBIENT_OCCLUSION; None: without end
        bake: _Bake | None = None,  # instead of a picture; of what else is asked only camera and settings count then
        share: tuple[
            int, int, int
        ] = ...,  # the tiles that are rendered: from one slot to before another, of so many; 0, 1, 1
    ) -> Job:
        """`over_the_shutter`: the camera at the middles of equal parts of the exposure, where it changes meanwhile.

        `mattes` are kept for `matte`, so many names a pixel; `neighbours`, the camera a frame before and a frame after, for
        `data("VECTOR")`."""
    def baked(self, alone: Job | None = None) -> npt.NDArray[np.float32]:
        """The baked values, (height, width, 4), first row at the bottom. `alone`: for shadows, the finished COMBINED bake of the same
        object in a scene without anything that casts shadows on it."""
    def data(self, name: str) -> npt.NDArray[np.float32]:
        """DEPTH (one channel, along the camera's axis, 1e10 for the background), POSITION or NORMAL (world space), VECTOR
        (pixels: to where it was a frame before; from where it will be a frame after), (height, width, channels), first row
        at the bottom; asked for by `SettingsDescription.with_data`. SAMPLES (one channel): the pixel's number of samples. REMAINDER and
        REMAINDER_FINE (four): the remainders that the picture's numbers times the samples leave out of the sums."""
    def matte(self, layer: str) -> npt.NDArray[np.float32]:
        """The channels (id, coverage, id, coverage) of all passes of a layer of Cryptomatte, (height, width, 4 passes),
        first row at the bottom."""
    def light_group(self, number: int) -> npt.NDArray[np.float32]:
        """The light of a group, by its number from 1, (height, width, 3), first row at the bottom."""
    def index(self, layer: str) -> npt.NDArray[np.float32]:
        """The pass index that most of a pixel's rays hit, of OBJECT_INDEX or MATERIAL_INDEX, (height, width, 1), first row at the
        bottom."""
    def part(self, name: str) -> npt.NDArray[np.float32]:
        """DIFFUSE_DIRECT, _INDIRECT, _COLOR, the same of GLOSSY and TRANSMISSION, VOLUME_DIRECT, VOLUME_INDIRECT, EMISSION,
        ENVIRONMENT, AMBIENT_OCCLUSION, DENOISING_ALBEDO, DENOISING_NORMAL, DENOISING_DEPTH, UV, MIST, AOV_0 and so on: (height, width, 3), first
        row at the bottom. Light of a kind of lobe is divided by its colour."""
    def shadow(self, alone: Job) -> npt.NDArray[np.float32]:
        """The part of the light that is left on shadow catchers, (height, width, 3), 1 where nothing is seen, by the finished render
        of these alone. For a job with `catches`."""
    def over_photograph(
        self, alone: Job, sky: Job | None, *, is_opaque: bool, is_apart: bool, is_noisy: bool = False
    ) -> npt.NDArray[np.float32]:
        """The picture to be laid over a photograph, (height, width, 4): shadow catchers are transparent, and the mean of their shadow
        is alpha, but where that is a pass of its own (`is_apart`). It is laid over the finished render of the `sky`, if there is
        one. `is_noisy`: as it is without `denoise`."""
    def matte_metadata(self, layer: str, name: str) -> list[tuple[str, str]]:
        """The metadata of a file about a layer that is called `name` in it: keys and values."""
    def wait(self, timeout_s: float) -> bool:
        """Waits, with the interpreter's lock free, until finished or time is up; True: finished."""
    def progress(self) -> float:  # 0..1
        ...
    def samples_done(self) -> int:
        """Whole samples per pixel that every pixel has which is not to have fewer."""
    def take_tiles(self) -> list[tuple[int, int, int, int, npt.NDArray[np.float32]]]:
        """(x, y, width, height, pixels (height, width, 4) scene-linear Rec.709 RGBA, first row at the bottom)
        of every tile that changed since the last call; x, y count from the lower left corner."""
    def image(self) -> npt.NDArray[np.float32]:
        """The picture as it is now, (height, width, 4)."""
    def stop(self) -> None:
        """Asks to stop; finished samples stay. The job ends within 0.1 s."""
    def denoise(self, how: DenoisingDescription) -> None:
        """Takes the noise out of the picture, after the end and before `develop`; `image` then has none. Raises the errors of the library;
        the picture then is as it was. `developed` and `stop_developing` are about it, too."""
    def denoised_image(self, how: DenoisingDescription) -> npt.NDArray[np.float32]:
        """`image` without its noise and without the light that strays. The render may go on meanwhile, and keeps its noise. Raises as
        `denoise`."""
    def noisy_image(self) -> npt.NDArray[np.float32]:
        """`image` as it is without `denoise`."""
    def develop(self) -> None:
        """After the end: finds the light that strays in the lens, if the plan has any simulated; `image` then has it. Takes its time."""
    def stop_developing(self) -> None:
        """Ends `develop` in another thread without a result."""
    def developed(self) -> float:
        """The part of `develop` that is done, 0 to 1."""
    def stray(self, name: str) -> npt.NDArray[np.float32]:
        """A part of the stray light, of shape (height, width, 3), already in `image`: GHOSTS, GLARE or DIFFRACTION; black where it was not
        found."""
    def end_checkpoints(self) -> Checkpoint | None:
        """Waits, after the end, until the last checkpoint is written; the checkpoint that this render has written or taken up."""
    def write_film(self, file: str, fingerprint: str) -> None:
        """Writes the film of a finished share, for `join_film` of a job of the same fingerprint. Raises `OSError`."""
    def join_film(self, file: str, fingerprint: str, share: tuple[int, int, int]) -> str | None:
        """After the end: adds the film of another share; the reason why it is not taken, if there is one. A job that joins shares renders none
        itself: its own is 0, 0, 1."""
    def stats_json(self) -> str:
        """{"seconds": {"bvh", "render", "plan"}, "samples" (that every pixel has), "samples_mean", "samples_most", "camera_rays", "camera_rays_lost", "rays",
        "lens_share" (part of the render time spent in the lens), "non_finite_samples", "seed", "threads",
        "lens", "width", "height"}."""

def denoising_seconds(how: DenoisingDescription, pixels: int, threads: int) -> float:
    """Wall time that `Job.denoise` will take, s, about: by the last picture of this quality."""

def film_bytes_a_pixel(
    *, surfaces: bool = False, vectors: bool = False, mattes: bool = False, halves: bool = False, groups: int = 0
) -> int:
    """Bytes of memory that each pixel takes of a film that keeps these: as `Job` is asked for them; `groups`: of light and its parts
    together."""

@final
class Checkpoint:
    """The checkpoint that a render has written or taken up."""

    path: str
    def delete(self) -> bool:
        """Removes it, unless another render has replaced it meanwhile; True where it was removed."""

def checkpoint_problem(file: str | PathLike[str]) -> str | None:
    """The reason why a file may not be replaced by a checkpoint; None where there is no file, or where it is empty or a checkpoint."""

@final
class FileReplacement:
    """A temporary file that is to replace another one; without `commit`, the old file stays. Raises `OSError`."""

    part: str
    def __new__(cls, place: str | PathLike[str]) -> FileReplacement: ...
    def commit(self) -> None:
        """Brings the temporary file to the disk, and renames it into place."""
    def abandon(self) -> None:
        """Removes the temporary file."""

def check_replaceable(file: str | PathLike[str]) -> None:
    """Raises `OSError` where a file cannot be replaced, or made."""

def read_bounded(file: str | PathLike[str], most: int) -> bytes:
    """The bytes of a regular file of at most `most` bytes; raises `OSError`, also for a longer file, a device or a pipe."""

def check_exr(file: str | PathLike[str]) -> tuple[int, int]:
    """Width and height of an OpenEXR file all of whose pixels are there; raises `PetzvalError` where some are missing."""

def merge_pictures_json(files: Sequence[str], output: str) -> str:
    """Joins renders of one picture with other samples: {"samples" (mean a pixel), "is_exact"}. Pictures that do not fit into the
    memory that is free are refused."""

def random_per_island(vertices: int, edges: npt.NDArray[np.int32]) -> npt.NDArray[np.float32]:
    """A number from 0 to 1 by vertex, Blender's, the same for all that edges join."""

def pointiness(
    positions: npt.NDArray[np.float32], normals: npt.NDArray[np.float32], edges: npt.NDArray[np.int32]
) -> npt.NDArray[np.float32]:
    """The pointiness of a mesh by vertex, as Blender has it: 0 to 1, one half where it is flat."""

def evaluate_graph(
    graph_json: str,
    points: dict[str, npt.NDArray[np.float32]],
    *,
    images: list[npt.NDArray[np.float32]] = ...,
    world_to_object: npt.NDArray[np.float64] | None = None,
    world_to_camera: npt.NDArray[np.float64] | None = None,
) -> dict[str, Any]:
    """A shader graph (`addon/export/graph.py`) at points that are given by hand, each (n, 3) or (n, 4).

    `points` by the names of the fields that a program reads ("position", "normal", "generated", ...), of attributes with
    their kind ("uv:UVMap", "tangent:", "geometry:name"), and of how one changes over a pixel ("position/x", "position/y").
    `images` are (height, width, 4), linear, lowest row first. Gives
    {"surface": [{"kind", "weight" (n, 3), "inputs": {identifier: (n, 3)}, "options"}], "volume": [...],
    "displacement": (n, 3) or None, "reports": [text], "instructions": count}.
    """
