//! A lens set, focused and put before its film: the facts for a panel, and the parts of a camera.

use crate::camera::{CameraDescription, CameraError, t_number};
use glam::DVec3;
use petzval_optics::focus::{self, FilmPlane, FocusError, Focusing, GroupsError, Relation};
use petzval_optics::glass::{Medium, VISIBLE_NM};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::prescription::moving::MovingParts;
use petzval_optics::system::{FocalLength, System};
use petzval_optics::trace::{Ray as LensRay, Tracer};
use serde::Serialize;

/// Yellow helium line, where lenses are focused and measured, nm.
pub const D_LINE_NM: f64 = 587.5618;

/// Relative difference of focal lengths that is rounding of a zoom's table.
const SAME_FOCAL_LENGTH: f64 = 2e-3;

/// Data of a lens in a camera: for panels, reports, and a viewport that frames the same picture.
#[derive(Clone, Debug, Serialize)]
pub struct LensInfo {
    /// The lens's name in its file.
    pub lens_name: String,
    /// Surfaces, the diaphragm among them.
    pub surfaces: usize,
    /// Focal length at the d line, mm; `None` for an afocal lens.
    pub efl_mm: Option<f64>,
    /// Last vertex to image focal point, mm.
    pub bfd_mm: Option<f64>,
    /// The f-number after clamping.
    pub f_number: f64,
    /// The f-number that the clear apertures allow.
    pub widest_f_number: f64,
    /// True if the f-number asked for is wider than [`Self::widest_f_number`].
    pub f_number_was_clamped: bool,
    /// The f-number of a lens that loses nothing and is as bright: for white light in the film's middle, by reflection and absorption;
    /// `None` where that is dark.
    pub t_number: Option<f64>,
    /// The names of the coatings on its surfaces in air, each once.
    pub coatings: Vec<String>,
    /// True if nothing is known of some coating, so that one was assumed.
    pub coating_is_assumed: bool,
    /// Glasses whose absorption is not known and that count as clear.
    pub unknown_absorption: Vec<String>,
    /// Film's middle in lens space, mm.
    pub film_z_mm: f64,
    /// Film's middle from the last vertex, mm.
    pub film_distance_mm: f64,
    /// Distance from the entrance pupil to the sharp plane, mm; `None` is infinity.
    pub focus_distance_mm: Option<f64>,
    /// The sharp distance as the camera counts it: the focus distance that it would have to be set to, mm; `None` is infinity.
    pub focus_scale_mm: Option<f64>,
    /// Image over object height; negative is upside down on the film.
    pub magnification: f64,
    /// Whole horizontal angle that the picture sees, by exact rays; `None` where they are lost.
    pub fov_horizontal_rad: Option<f64>,
    /// Whole vertical angle that the picture sees, by exact rays; `None` where they are lost.
    pub fov_vertical_rad: Option<f64>,
    /// Whole diagonal angle that the picture sees, by exact rays; `None` where they are lost.
    pub fov_diagonal_rad: Option<f64>,
    /// The largest angle between the axis and the direction in which a corner of the picture looks, with the film shifted and turned as it
    /// is; `None` where a corner sees nothing.
    pub widest_angle_rad: Option<f64>,
    /// Width of the part of the film that the picture takes, mm.
    pub picture_width_mm: f64,
    /// Height of the part of the film that the picture takes, mm.
    pub picture_height_mm: f64,
    /// A pinhole of this focal length over that width frames the same picture, mm.
    pub viewport_focal_length_mm: f64,
    /// Blender's shift of that pinhole, in units of the picture's larger side.
    pub viewport_shift: [f64; 2],
    /// Diameter of the entrance pupil, mm.
    pub entrance_pupil_diameter_mm: Option<f64>,
    /// Focal lengths that a zoom lens is made for, mm.
    pub zoom_range_mm: Option<[f64; 2]>,
    /// True if groups inside of the lens move to focus it, not the film.
    pub focuses_inside: bool,
    /// Remarks on parts of its file that could not be used, line by line, and on the end of a zoom that stands for its marking.
    pub remarks: Vec<String>,
    /// Glasses whose index is not known for all of the light: of the camera's wavelength, or if it has none, all visible.
    pub beyond_range: Vec<String>,
}

/// A lens set, focused and put before its film: all that a panel needs.
pub(in crate::camera) struct Setup {
    pub(in crate::camera) info: LensInfo,
    pub(in crate::camera) system: System,
    pub(in crate::camera) film: FilmPlane,
    /// The point of the axis that stands at the camera's origin.
    pub(in crate::camera) origin_z_mm: f64,
}

impl Setup {
    #[expect(clippy::too_many_lines, reason = "a field for each fact")]
    pub(in crate::camera) fn new(d: &CameraDescription, width: u32, height: u32) -> Result<Self, CameraError> {
        if let Some(nm) = d.wavelength_nm.filter(|nm| !(100.0..=20_000.0).contains(nm)) {
            return Err(d.error(format!("the wavelength is {nm} nm; visible light is 380 to 780 nm")));
        }
        let reading = d.lens_file()?;
        let prescription = &reading.prescription;
        let line = d.wavelength_nm.unwrap_or(D_LINE_NM);
        let (system, film_z_mm) = focused(d, prescription, line)?;
        let coating_is_assumed = d.lens.coating.is_none() && prescription.assumes_coatings();
        // The lens moved to the right is the film moved to the left.
        let shift_mm = d.film.shift_mm.map(|s| -s);
        let curvature_per_mm = system.film_radius_mm().map_or(0.0, f64::recip);
        let film = FilmPlane {
            z_mm: film_z_mm,
            tilt_rad: d.film.tilt_rad,
            swing_rad: d.film.swing_rad,
            shift_mm,
            curvature_per_mm,
        };
        let paraxial = Paraxial::new(&system, line);
        let origin_z_mm = d.focus.focusing.origin_z_mm(&system, line, film_z_mm);

        let [picture_width_mm, picture_height_mm] = picture_mm(d, width, height);
        check_retina(d, &system, &film, [picture_width_mm, picture_height_mm])?;

        let distance = focus::focus_distance_for_film_mm(&system, line, film_z_mm);
        let magnification = focus::magnification(&system, line, film_z_mm);
        let efl = paraxial.efl_mm;
        let scale = d.focus.focusing.distance_mm(&system, line, film_z_mm);
        // A pinhole at the camera's origin that frames the plane that is sharp; from the entrance pupil, all others too.
        let pupil_z_mm = paraxial.entrance_pupil.z_mm.unwrap_or(0.0);
        let viewport_focal_length_mm = if distance.is_finite() && magnification != 0.0 {
            (magnification * (distance + origin_z_mm - pupil_z_mm)).abs()
        } else {
            efl.map_or(50.0, f64::abs)
        };
        let chief = FilmChiefRays { tracer: system.at_wavelength(line), film, exit_z_mm: paraxial.exit_pupil.z_mm };
        let (hw, hh) = (0.5 * picture_width_mm, 0.5 * picture_height_mm);
        let [shortest_nm, longest_nm] = d.wavelength_nm.map_or(VISIBLE_NM, |nm| [nm; 2]);
        let beyond_range = prescription.media_beyond(shortest_nm, longest_nm).into_iter();
        let info = LensInfo {
            lens_name: system.name().to_owned(),
            surfaces: system.surface_count(),
            efl_mm: efl,
            bfd_mm: paraxial.bfd_mm,
            f_number: system.f_number(),
            widest_f_number: system.widest_f_number(),
            f_number_was_clamped: system.f_number_was_clamped(),
            film_z_mm,
            film_distance_mm: film_z_mm - system.last_vertex_z_mm(),
            focus_distance_mm: distance.is_finite().then_some(distance),
            focus_scale_mm: scale.is_finite().then_some(scale),
            magnification,
            fov_horizontal_rad: chief.angle_between([-hw, 0.0], [hw, 0.0]),
            fov_vertical_rad: chief.angle_between([0.0, -hh], [0.0, hh]),
            fov_diagonal_rad: chief.angle_between([-hw, -hh], [hw, hh]),
            widest_angle_rad: [[-hw, -hh], [hw, -hh], [-hw, hh], [hw, hh]]
                .into_iter()
                .try_fold(0.0, |widest: f64, corner| Some(widest.max(chief.angle_off_axis(corner)?))),
            picture_width_mm,
            picture_height_mm,
            viewport_focal_length_mm,
            viewport_shift: d.film.shift_mm.map(|s| s / picture_width_mm.max(picture_height_mm)),
            t_number: t_number(&system, line, film_z_mm),
            coatings: system.coatings(),
            coating_is_assumed,
            unknown_absorption: system.glasses_of_unknown_absorption().into_iter().map(str::to_owned).collect(),
            entrance_pupil_diameter_mm: paraxial.entrance_pupil.diameter_mm,
            zoom_range_mm: prescription.moving.as_ref().and_then(MovingParts::zoom_range_mm),
            focuses_inside: prescription.moving.as_ref().is_some_and(MovingParts::focuses),
            remarks: reading.remarks.iter().map(ToString::to_string).chain(end_of_zoom(d, prescription)).collect(),
            beyond_range: beyond_range.map(Medium::range_note).collect(),
        };
        Ok(Self { info, system, film, origin_z_mm })
    }
}

/// The remark on a zoom lens that does not reach the focal length of its marking.
fn end_of_zoom(d: &CameraDescription, prescription: &Prescription) -> Option<String> {
    let FocalLength::Millimetres(asked_mm) = d.lens.focal_length else { return None };
    prescription.moving.as_ref().and_then(MovingParts::zoom_range_mm)?;
    // At infinity: groups that focus change the focal length.
    let at_rest = System::with_travel(prescription, &d.lens, 0.0).ok()?;
    let reached_mm = Paraxial::new(&at_rest, D_LINE_NM).efl_mm?.abs();
    let is_end = (reached_mm / asked_mm - 1.0).abs() > SAME_FOCAL_LENGTH;
    is_end.then(|| {
        format!("'{}': {asked_mm} mm is the end of its zoom, {reached_mm:.1} mm by its surfaces", prescription.name)
    })
}

/// Width and height of the largest part of the film with the picture's shape, mm.
fn picture_mm(d: &CameraDescription, width: u32, height: u32) -> [f64; 2] {
    let aspect = f64::from(width) / d.rows_high(height);
    let picture_width_mm = d.film.width_mm.min(d.film.height_mm * aspect);
    [picture_width_mm, picture_width_mm / aspect]
}

/// Checks that a curved film has all of the picture.
fn check_retina(
    d: &CameraDescription,
    system: &System,
    film: &FilmPlane,
    [width_mm, height_mm]: [f64; 2],
) -> Result<(), CameraError> {
    let corners = [-0.5, 0.5].map(|x| [-0.5, 0.5].map(|y| film.reaches(x * width_mm, y * height_mm)));
    if corners.into_iter().flatten().all(|reaches| reaches) {
        return Ok(());
    }
    let radius = system.film_radius_mm().unwrap_or(0.0).abs();
    Err(d.error(format!(
        "a film of {width_mm:.1} x {height_mm:.1} mm is larger than the retina of radius {radius:.1} mm; make it smaller"
    )))
}

impl Setup {
    /// The angle between the directions in which two film points look at the camera's wavelength, as [`LensInfo::fov_horizontal_rad`] but
    /// of the lens without its rims and its stop: there is one, too, where all light is cut off.
    pub(in crate::camera) fn angle_without_rims(&self, d: &CameraDescription, a: [f64; 2], b: [f64; 2]) -> Option<f64> {
        let line = d.wavelength_nm.unwrap_or(D_LINE_NM);
        let exit_z_mm = Paraxial::new(&self.system, line).exit_pupil.z_mm;
        let tracer = self.system.at_wavelength(line).without_rims();
        FilmChiefRays { tracer, film: self.film, exit_z_mm }.angle_between(a, b)
    }
}

/// The lens, and the place of the film's middle, lens space. Groups that focus move instead of the film, but where
/// its place was asked for.
fn focused(d: &CameraDescription, prescription: &Prescription, line_nm: f64) -> Result<(System, f64), CameraError> {
    let system_error = |source| CameraError::System { lens: prescription.name.clone(), source };
    if d.focus.film_distance_mm.is_none() && prescription.moving.as_ref().is_some_and(MovingParts::focuses) {
        let (focusing, distance_mm) = d.focus_request()?;
        let done = focusing.by_groups(prescription, &d.lens, line_nm, distance_mm).map_err(|error| match error {
            GroupsError::System(source) => system_error(source),
            GroupsError::Focus(source) => CameraError::Focus { camera: d.object_name.clone(), source },
        })?;
        return Ok((done.system, done.film_z_mm));
    }
    let system = System::new(prescription, &d.lens).map_err(system_error)?;
    let film_z_mm = film_z(d, &system, line_nm)?;
    Ok((system, film_z_mm))
}

/// The z of the film's middle, lens space, mm.
fn film_z(d: &CameraDescription, system: &System, line_nm: f64) -> Result<f64, CameraError> {
    let wrong = |source: FocusError| CameraError::Focus { camera: d.object_name.clone(), source };
    if let Some(distance) = d.focus.film_distance_mm {
        if !(distance.is_finite() && distance * system.light_direction_at_film() > 0.0) {
            return Err(d.error(format!("the film distance is {distance} mm; the film must stand behind the lens")));
        }
        return Ok(system.last_vertex_z_mm() + distance);
    }
    let (focusing, distance_mm) = d.focus_request()?;
    focusing.film_z_mm(system, line_nm, distance_mm).map_err(wrong)
}

impl CameraDescription {
    /// The distance that is to be sharp, mm, and the meaning of that distance.
    fn focus_request(&self) -> Result<(Focusing, f64), CameraError> {
        let distance_mm = self.focus_depth()?.map_or(f64::INFINITY, |units| units * self.scale_mm_per_unit.z);
        // A point of the world is to be sharp, whichever relation numbers follow.
        let relation = if self.focus.point_world.is_some() { Relation::Exact } else { self.focus.focusing.relation };
        Ok((Focusing { relation, ..self.focus.focusing }, distance_mm))
    }
}

/// Rays from film points through the middle of the exit pupil.
struct FilmChiefRays {
    tracer: Tracer,
    film: FilmPlane,
    exit_z_mm: Option<f64>,
}

impl FilmChiefRays {
    /// The scene direction of a film point.
    fn direction(&self, [u, v]: [f64; 2]) -> Option<DVec3> {
        let p = self.film.point(u, v);
        let through = match self.exit_z_mm {
            Some(z) => DVec3::new(0.0, 0.0, z) - p,
            None => DVec3::NEG_Z,
        };
        // An exit pupil behind the film is looked at backwards.
        let d = through.normalize_or(DVec3::NEG_Z);
        let d = if d.dot(self.film.normal()) < 0.0 { -d } else { d };
        self.tracer.from_film(LensRay { origin: p, direction: d }).ok().map(|r| r.direction)
    }

    /// The angle between the axis and the scene direction of a film point.
    fn angle_off_axis(&self, point: [f64; 2]) -> Option<f64> {
        self.direction(point).map(|d| d.truncate().length().atan2(-d.z))
    }

    /// The angle between the scene directions of two film points.
    fn angle_between(&self, a: [f64; 2], b: [f64; 2]) -> Option<f64> {
        let (a, b) = (self.direction(a)?, self.direction(b)?);
        let angle = a.cross(b).length().atan2(a.dot(b));
        // Fisheyes: more than half a turn when both look backwards.
        Some(if a.z > 0.0 && b.z > 0.0 { std::f64::consts::TAU - angle } else { angle })
    }
}
