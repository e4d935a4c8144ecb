//! The real lens: from a point of the film, every ray is traced exactly through every surface.
//!
//! Radiance is conserved along a ray, so a film point's exposure is the integral of radiance over the clear pupil
//! with the weight cos(film) cos(pupil) / distance^2; it is divided by what the middle of the film gets from a
//! uniform world of radiance one.

use super::packet::Packets;
use super::scene_side::SceneSide;
use super::{CameraDescription, CameraError, CameraRay, Spectrum};
use crate::accel::Ray;
use crate::spectrum::FilmSpectrum;
use glam::{DMat3, DVec3, Vec2};
use petzval_optics::entrance_map::EntranceMap;
use petzval_optics::focus::{self, FilmFrame, FilmPlane, FilmPoint, FocusError, Focusing, GroupsError, Relation};
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::prescription::moving::MovingGaps;
use petzval_optics::pupil_map::{PupilMap, on_axis_throughput};
use petzval_optics::system::{FocalLength, System, SystemError, SystemSettings};
use petzval_optics::trace::{Ray as LensRay, Tracer};
use std::sync::OnceLock;
use std::time::Instant;

/// Yellow helium line, where lenses are focused and measured, nm.
pub(super) const D_LINE_NM: f64 = 587.5618;

/// What a lens does in a camera: for panels, reports, and a viewport that frames the same picture.
#[derive(Clone, Debug)]
pub struct LensInfo {
    /// From the lens file.
    pub lens_name: String,
    /// Surfaces, the diaphragm among them.
    pub surfaces: usize,
    /// At the d line, mm; `None` for an afocal lens.
    pub efl_mm: Option<f64>,
    /// Last vertex to image focal point, mm.
    pub bfd_mm: Option<f64>,
    /// In force.
    pub f_number: f64,
    /// What the clear apertures allow.
    pub widest_f_number: f64,
    /// The f-number asked for is wider than that.
    pub f_number_was_clamped: bool,
    /// Film's middle in lens space, mm.
    pub film_z_mm: f64,
    /// Film's middle from the last vertex, mm.
    pub film_distance_mm: f64,
    /// From the entrance pupil to what is sharp, mm; `None` is infinity.
    pub focus_distance_mm: Option<f64>,
    /// The same as the camera counts it: the focus distance that it would have to be set to.
    pub focus_scale_mm: Option<f64>,
    /// Image over object height; negative is upside down on the film.
    pub magnification: f64,
    /// Whole angles that the picture sees, by exact rays; `None` where they are lost.
    pub fov_horizontal_rad: Option<f64>,
    /// As before.
    pub fov_vertical_rad: Option<f64>,
    /// As before.
    pub fov_diagonal_rad: Option<f64>,
    /// The part of the film that the picture takes, mm.
    pub picture_width_mm: f64,
    /// As before.
    pub picture_height_mm: f64,
    /// A pinhole of this focal length over that width frames the same picture, mm.
    pub viewport_focal_length_mm: f64,
    /// Blender's shift of that pinhole, in units of the picture's larger side.
    pub viewport_shift: [f64; 2],
    /// mm.
    pub entrance_pupil_diameter_mm: Option<f64>,
    /// Focal lengths that a zoom lens is made for, mm.
    pub zoom_range_mm: Option<[f64; 2]>,
    /// Groups inside of the lens move to focus it, not the film.
    pub focuses_inside: bool,
}

/// A lens set, focused and put before its film: all that a panel needs.
pub(super) struct Setup {
    pub(super) info: LensInfo,
    system: System,
    film: FilmPlane,
    /// The point of the axis that stands at the camera's origin.
    origin_z_mm: f64,
}

impl Setup {
    pub(super) fn new(d: &CameraDescription, width: u32, height: u32) -> Result<Self, CameraError> {
        if let Some(nm) = d.wavelength_nm.filter(|nm| !(100.0..=20_000.0).contains(nm)) {
            return Err(d.error(format!("the wavelength is {nm} nm; visible light is 380 to 780 nm")));
        }
        let prescription = lens::read(&d.lens_path, Catalogue::shipped())?;
        let name = prescription.name.clone();
        let wrong = |source: SystemError| CameraError::System { lens: name.clone(), source };
        let focal_length = match (d.focal_length_mm, d.focal_scale) {
            (Some(mm), _) => FocalLength::Millimetres(mm),
            (None, Some(scale)) => FocalLength::Scale(scale),
            (None, None) => FocalLength::AsPublished,
        };
        let settings = SystemSettings {
            focal_length,
            f_number: d.f_number,
            blades: d.blades,
            blade_rotation_rad: d.blade_rotation_rad,
            blade_curvature: d.blade_curvature,
        };
        let line = d.wavelength_nm.unwrap_or(D_LINE_NM);
        let (mut system, film_z_mm) = focused(d, &prescription, &settings, line)?;
        if let Some(mask) = &d.aperture_mask {
            system = system.with_aperture_mask(mask.clone(), d.blade_rotation_rad).map_err(wrong)?;
        }
        // The lens moved to the right is the film moved to the left.
        let shift_mm = d.shift_mm.map(|s| -s);
        let curvature_per_mm = system.film_radius_mm().map_or(0.0, f64::recip);
        let film =
            FilmPlane { z_mm: film_z_mm, tilt_rad: d.tilt_rad, swing_rad: d.swing_rad, shift_mm, curvature_per_mm };
        let paraxial = Paraxial::new(&system, line);
        let origin_z_mm = d.focusing.origin_z_mm(&system, line, film_z_mm);

        // The largest part of the film with the picture's shape.
        let aspect = width as f64 / height as f64;
        let picture_width_mm = d.film_width_mm.min(d.film_height_mm * aspect);
        let picture_height_mm = picture_width_mm / aspect;

        let corners =
            [-0.5, 0.5].map(|x| [-0.5, 0.5].map(|y| film.reaches(x * picture_width_mm, y * picture_height_mm)));
        if !corners.into_iter().flatten().all(|reaches| reaches) {
            let radius = system.film_radius_mm().unwrap_or(0.0).abs();
            return Err(d.error(format!(
                "a film of {picture_width_mm:.1} x {picture_height_mm:.1} mm is larger than the retina of radius {radius:.1} mm; make it smaller"
            )));
        }

        let distance = focus::focus_distance_for_film_mm(&system, line, film_z_mm);
        let magnification = focus::magnification(&system, line, film_z_mm);
        let efl = paraxial.efl_mm;
        let scale = d.focusing.distance_mm(&system, line, film_z_mm);
        // A pinhole at the camera's origin that frames the plane that is sharp; from the entrance pupil, all others too.
        let pupil_z_mm = paraxial.entrance_pupil.z_mm.unwrap_or(0.0);
        let viewport_focal_length_mm = if distance.is_finite() && magnification != 0.0 {
            (magnification * (distance + origin_z_mm - pupil_z_mm)).abs()
        } else {
            efl.map_or(50.0, f64::abs)
        };
        let chief = ChiefRays { tracer: system.at_wavelength(line), film, exit_z_mm: paraxial.exit_pupil.z_mm };
        let (hw, hh) = (0.5 * picture_width_mm, 0.5 * picture_height_mm);
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
            picture_width_mm,
            picture_height_mm,
            viewport_focal_length_mm,
            viewport_shift: d.shift_mm.map(|s| s / picture_width_mm.max(picture_height_mm)),
            entrance_pupil_diameter_mm: paraxial.entrance_pupil.diameter_mm,
            zoom_range_mm: prescription.moving.as_ref().and_then(MovingGaps::zoom_range_mm),
            focuses_inside: prescription.moving.as_ref().is_some_and(MovingGaps::focuses),
        };
        Ok(Self { info, system, film, origin_z_mm })
    }
}

/// The lens, and where the film's middle is to stand, lens space. Groups that focus move instead of the film, but where
/// its place was asked for.
fn focused(
    d: &CameraDescription,
    prescription: &Prescription,
    settings: &SystemSettings,
    line_nm: f64,
) -> Result<(System, f64), CameraError> {
    let system_error = |source| CameraError::System { lens: prescription.name.clone(), source };
    if d.film_distance_mm.is_none() && prescription.moving.as_ref().is_some_and(MovingGaps::focuses) {
        let (focusing, distance_mm) = d.focus_request()?;
        let done = focusing.by_groups(prescription, settings, line_nm, distance_mm).map_err(|error| match error {
            GroupsError::System(source) => system_error(source),
            GroupsError::Focus(source) => CameraError::Focus { camera: d.object_name.clone(), source },
        })?;
        return Ok((done.system, done.film_z_mm));
    }
    let system = System::new(prescription, settings).map_err(system_error)?;
    let film_z_mm = film_z(d, &system, line_nm)?;
    Ok((system, film_z_mm))
}

/// Where the film's middle is to stand, lens space.
fn film_z(d: &CameraDescription, system: &System, line_nm: f64) -> Result<f64, CameraError> {
    let wrong = |source: FocusError| CameraError::Focus { camera: d.object_name.clone(), source };
    if let Some(distance) = d.film_distance_mm {
        if !(distance.is_finite() && distance * system.light_direction_at_film() > 0.0) {
            return Err(d.error(format!("the film distance is {distance} mm; the film must stand behind the lens")));
        }
        return Ok(system.last_vertex_z_mm() + distance);
    }
    let (focusing, distance_mm) = d.focus_request()?;
    focusing.film_z_mm(system, line_nm, distance_mm).map_err(wrong)
}

impl CameraDescription {
    /// What distance is to be sharp, mm, and how it is meant.
    fn focus_request(&self) -> Result<(Focusing, f64), CameraError> {
        let distance_mm = self.focus_depth()?.map_or(f64::INFINITY, |units| units * self.scale_mm_per_unit.z);
        // A point of the world is to be sharp, whichever relation numbers follow.
        let relation = if self.focus_point_world.is_some() { Relation::Exact } else { self.focusing.relation };
        Ok((Focusing { relation, ..self.focusing }, distance_mm))
    }
}

/// Rays from film points through the middle of the exit pupil.
struct ChiefRays {
    tracer: Tracer,
    film: FilmPlane,
    exit_z_mm: Option<f64>,
}

impl ChiefRays {
    /// The angle between the scene directions of two film points.
    fn angle_between(&self, a: [f64; 2], b: [f64; 2]) -> Option<f64> {
        let direction = |[u, v]: [f64; 2]| {
            let p = self.film.point(u, v);
            let through = match self.exit_z_mm {
                Some(z) => DVec3::new(0.0, 0.0, z) - p,
                None => DVec3::NEG_Z,
            };
            // An exit pupil behind the film is looked at backwards.
            let d = through.normalize_or(DVec3::NEG_Z);
            let d = if d.dot(self.film.normal()) < 0.0 { -d } else { d };
            self.tracer.from_film(LensRay { origin: p, direction: d }).ok().map(|r| r.direction)
        };
        let (a, b) = (direction(a)?, direction(b)?);
        let angle = a.cross(b).length().atan2(a.dot(b));
        // Fisheyes: more than half a turn when both look backwards.
        Some(if a.z > 0.0 && b.z > 0.0 { std::f64::consts::TAU - angle } else { angle })
    }
}

/// A film behind a lens, and where both stand.
pub(super) struct Mount {
    pub(super) info: LensInfo,
    pub(super) film: FilmPlane,
    pub(super) frame: FilmFrame,
    /// Lens space to render space.
    axes: DMat3,
    origin_z_mm: f64,
    per_unit: DVec3,
}

impl Mount {
    /// With the lens that was set up for it.
    pub(super) fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<(Self, System), CameraError> {
        let Setup { info, system, film, origin_z_mm } = Setup::new(d, width, height)?;
        let frame = film.frame();
        Ok((Self { info, film, frame, axes, origin_z_mm, per_unit: d.scale_mm_per_unit }, system))
    }

    pub(super) fn axes(&self) -> &DMat3 {
        &self.axes
    }

    /// The film point of a picture point, lens space: the picture on the film is turned by half a turn.
    #[inline]
    pub(super) fn film_at(&self, p: Vec2) -> FilmPoint {
        self.frame.at(-p.x as f64 * self.info.picture_width_mm, -p.y as f64 * self.info.picture_height_mm)
    }

    /// The picture point where a ray from the lens meets the film.
    #[inline]
    pub(super) fn picture_point(&self, ray: &LensRay) -> Option<Vec2> {
        let [u, v] = self.frame.meet(ray)?;
        Some(Vec2::new((-u / self.info.picture_width_mm) as f32, (-v / self.info.picture_height_mm) as f32))
    }

    /// Millimetres of lens space in a unit of render space; `None` if they differ between the axes.
    pub(super) fn scale(&self) -> Option<f64> {
        let s = self.per_unit;
        (s.x == s.y && s.y == s.z).then_some(s.x)
    }

    /// A direction of render space in lens space, where all axes have one scale.
    pub(super) fn direction_to_lens(&self, d: DVec3) -> DVec3 {
        (self.axes.transpose() * d).normalize()
    }

    /// The same, back.
    pub(super) fn direction_to_render(&self, d: DVec3) -> DVec3 {
        (self.axes * d).normalize()
    }

    /// A ray in front of the lens, from lens space to render space: camera space has the lens's axes, with the anchor of
    /// the focus as origin.
    pub(super) fn to_render(&self, ray: &LensRay) -> Ray {
        let origin = (ray.origin - DVec3::new(0.0, 0.0, self.origin_z_mm)) / self.per_unit;
        let direction = (ray.direction / self.per_unit).normalize();
        Ray::new((self.axes * origin).as_vec3a(), (self.axes * direction).as_vec3a())
    }

    /// A point of render space in lens space.
    pub(super) fn to_lens(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * point * self.per_unit + DVec3::new(0.0, 0.0, self.origin_z_mm)
    }

    /// Puts another film behind the lens, and another point of the axis at the camera's origin. Of `info` nothing changes
    /// but by [`Setup::new`].
    pub(super) fn refocus(&mut self, film: FilmPlane, origin_z_mm: f64) {
        (self.film, self.frame, self.origin_z_mm) = (film, film.frame(), origin_z_mm);
    }
}

/// The wavelengths that a film sees: all, three, or one: that which was asked for, or any if the lens treats all alike.
pub(super) fn film_spectrum(d: &CameraDescription, system: &System) -> FilmSpectrum {
    match (d.wavelength_nm, d.spectrum) {
        (Some(nm), _) => FilmSpectrum::single(nm),
        (None, _) if !system.is_dispersive() => FilmSpectrum::single(D_LINE_NM),
        (None, Spectrum::Three) => FilmSpectrum::three(),
        (None, Spectrum::Visible) => FilmSpectrum::visible(),
    }
}

/// Why no light at all arrives.
pub(super) fn dark(d: &CameraDescription, lens_name: &str) -> CameraError {
    d.error(format!(
        "no light gets through '{lens_name}' to the middle of the film; open the diaphragm or change the focus"
    ))
}

/// A real lens before its film, ready to photograph.
pub struct RealLens {
    pub(super) mount: Mount,
    pub(super) spectrum: FilmSpectrum,
    /// By wavelength of the film.
    pub(super) lines: Vec<Line>,
    pub(super) map: PupilMap,
    map_seconds: f64,
    packets: Packets,
    system: System,
    /// Made when rays first start in the scene.
    scene_side: OnceLock<SceneSide>,
    entrance: OnceLock<EntranceMap>,
}

/// One wavelength of the film.
pub(super) struct Line {
    pub(super) tracer: Tracer,
    /// The picture's value for the irradiance that radiance one makes: by default one over that of the film's middle.
    pub(super) gain: f64,
    /// The index of the medium before the film, squared: what etendue is counted in.
    pub(super) index_squared: f64,
}

/// A ray from the film into the scene, at one wavelength.
pub(super) struct Lead {
    /// In front of the lens, lens space.
    pub(super) out: LensRay,
    /// The density of its choice, for each mm² sr of projected solid angle at the film point.
    pub(super) density: f64,
}

impl RealLens {
    pub(super) fn new(d: &CameraDescription, axes: DMat3, width: u32, height: u32) -> Result<Self, CameraError> {
        let (mount, system) = Mount::new(d, axes, width, height)?;
        let Mount { info, film, .. } = &mount;
        let spectrum = film_spectrum(d, &system);
        let tracers: Vec<Tracer> = spectrum.wavelengths().iter().map(|w| system.at_wavelength(w.nm)).collect();
        let half = [0.5 * info.picture_width_mm, 0.5 * info.picture_height_mm];
        let middle = tracers.len() / 2;
        let representative: Vec<Tracer> = if tracers.len() == 1 {
            tracers.clone()
        } else {
            [0, middle, tracers.len() - 1].map(|i| tracers[i].clone()).to_vec()
        };
        let start = Instant::now();
        let map = PupilMap::for_tracers(&representative, &system, film, half[0], half[1]);
        let map_seconds = start.elapsed().as_secs_f64();
        let gains = gains(&tracers, &spectrum, &system, film.z_mm);
        if !gains.iter().all(|g| g.is_finite()) {
            return Err(dark(d, &info.lens_name));
        }
        let brightness = d.brightness(gains[middle].recip());
        let packets = Packets::new(&tracers, &spectrum);
        let line = |(tracer, gain): (Tracer, f64)| {
            let index_squared = system.image_index(tracer.wavelength_nm()).powi(2);
            Line { tracer, gain: gain * brightness, index_squared }
        };
        let lines = tracers.into_iter().zip(gains).map(line).collect();
        let (scene_side, entrance) = (OnceLock::new(), OnceLock::new());
        Ok(Self { mount, spectrum, lines, map, map_seconds, packets, system, scene_side, entrance })
    }

    /// What the lens does in this camera.
    pub fn info(&self) -> &LensInfo {
        &self.mount.info
    }

    /// Wall time that the map of the pupil took, s.
    pub fn map_seconds(&self) -> f64 {
        self.map_seconds
    }

    /// A ray for a picture point, or `None` where it is lost in the lens.
    #[inline]
    pub fn sample(&self, p: Vec2, u_lens: [f32; 2], u_wavelength: f32) -> Option<CameraRay> {
        let index = self.spectrum.sample(u_wavelength);
        self.lead(index, p, u_lens).map(|lead| self.weighted(index, &lead))
    }

    /// What a ray at the film's wavelength number `index` counts.
    #[inline]
    pub(super) fn weighted(&self, index: usize, lead: &Lead) -> CameraRay {
        let exposure = self.lines[index].gain / lead.density;
        let weight = self.spectrum.wavelengths()[index].response * exposure as f32;
        CameraRay { ray: self.mount.to_render(&lead.out), weight }
    }

    /// A ray for a picture point at the film's wavelength number `index`.
    #[inline]
    pub(super) fn lead(&self, index: usize, p: Vec2, u_lens: [f32; 2]) -> Option<Lead> {
        let (ray, density) = self.aim_out(p, u_lens);
        self.lines[index].tracer.from_film(ray).ok().map(|out| Lead { out, density })
    }

    /// A ray from a picture point to the lens, lens space, and the density of its choice as [`Lead`] has it.
    #[inline]
    pub(super) fn aim_out(&self, p: Vec2, u_lens: [f32; 2]) -> (LensRay, f64) {
        let film = self.mount.film_at(p);
        let aim = self.map.sample(film.point, u_lens.map(f64::from));
        let to = aim.target - film.point;
        let distance2 = to.length_squared();
        let direction = to / distance2.sqrt();
        let cosines = film.normal.dot(direction).abs() * direction.z.abs();
        (LensRay { origin: film.point, direction }, aim.pdf_per_mm2 * distance2 / cosines)
    }

    /// The density of [`Self::lead`] for the picture point `p` and a ray that comes to it from the lens.
    #[inline]
    pub(super) fn lead_density(&self, p: Vec2, ray: &LensRay) -> f64 {
        let film = self.mount.film_at(p);
        let to_plane = (self.map.reference_plane_z() - film.point.z) / ray.direction.z;
        let target = film.point + ray.direction * to_plane;
        let cosines = (film.normal.dot(ray.direction) * ray.direction.z).abs();
        self.map.pdf(film.point, target) * to_plane * to_plane / cosines
    }

    /// For rays that start in the scene.
    pub(super) fn scene_side(&self) -> &SceneSide {
        self.scene_side.get_or_init(|| SceneSide::new(self, &self.system))
    }

    /// Where to aim at from the scene, for all wavelengths; made when first asked for.
    pub(super) fn entrance(&self) -> &EntranceMap {
        self.entrance.get_or_init(|| {
            let middle = self.lines.len() / 2;
            let mut picked = vec![0, middle, self.lines.len() - 1];
            picked.dedup();
            let tracers: Vec<Tracer> = picked.into_iter().map(|i| self.lines[i].tracer.clone()).collect();
            EntranceMap::new(&tracers, &self.system)
        })
    }

    /// For rays that are carried at several wavelengths.
    pub(super) fn packets(&self) -> &Packets {
        &self.packets
    }
}

/// One over the exposure of the film's middle at each wavelength. It changes smoothly, so a parabola through
/// three wavelengths serves for all.
fn gains(tracers: &[Tracer], spectrum: &FilmSpectrum, system: &System, film_z_mm: f64) -> Vec<f64> {
    let exact = |i: usize| on_axis_throughput(&tracers[i], system, film_z_mm);
    if tracers.len() < 3 {
        return (0..tracers.len()).map(|i| 1.0 / exact(i)).collect();
    }
    let nodes = [0, tracers.len() / 2, tracers.len() - 1];
    let lines = spectrum.wavelengths();
    let x = nodes.map(|i| lines[i].nm);
    let y = nodes.map(exact);
    lines
        .iter()
        .map(|line| {
            let at = line.nm;
            let term =
                |i: usize, j: usize, k: usize| y[i] * (at - x[j]) * (at - x[k]) / ((x[i] - x[j]) * (x[i] - x[k]));
            1.0 / (term(0, 1, 2) + term(1, 2, 0) + term(2, 0, 1))
        })
        .collect()
}
