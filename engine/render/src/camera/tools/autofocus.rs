//! Focus found instead of set: on the hit of a point of the picture, or on three points of the world at once.

use crate::accel::Ray;
use crate::camera::lens::beam;
use crate::camera::lens::mount::Mount;
use crate::camera::lens::setup::D_LINE_NM;
use crate::camera::{CameraDescription, CameraError, Model};
use glam::{DVec3, Vec2};
use petzval_optics::autofocus::{Autofocus, PHOTOPIC, SharpPlaneError, Subject};
use petzval_optics::focus::{Anchor, FilmPlane, Focusing, magnification};
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::system::System;
use petzval_optics::trace::{Ray as LensRay, Tracer};
use serde::Serialize;

/// Rays whose mean is the direction in which a picture point looks.
const RAYS: u32 = 256;
/// Number of times that the subject is looked up again from the film that was found. Then it stays, lest it jump between two things at an
/// edge.
const LOOKS: usize = 4;
/// Steps for the film to settle.
const MOST_STEPS: usize = 100;
/// Part of the film's place that is no step.
const SETTLED: f64 = 1e-9;
/// Steps for moving groups to settle: a secant needs four or five.
const MOST_SECANTS: usize = 30;
/// Infinity for a lens of first order, mm.
const FAR_MM: f64 = 1e12;

/// A focus that was found: the settings that say the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SharpFilm {
    /// Distance from the last vertex to the film's middle, before it is shifted, mm.
    pub film_distance_mm: f64,
    /// The focus distance that puts the film there, counted as the camera does; `None` is infinity. A film nearer to
    /// the lens than its focal plane has a negative one.
    pub focus_scale_mm: Option<f64>,
    /// Turn of the film about its horizontal axis.
    pub tilt_rad: f64,
    /// Turn of the film about its vertical axis.
    pub swing_rad: f64,
    /// True if groups inside of the lens have moved, not the film: only the focus distance says so.
    pub moves_groups: bool,
    /// Root mean square radius of the spot on the film, the largest of three.
    pub rms_spot_mm: f64,
    /// The sharp point, world space; `None` if it is infinitely far.
    pub subject_world: Option<DVec3>,
}

/// Focuses on the hit of the picture point `p`: `distance_to` says how far along a ray (render space) there is something,
/// `None` if nothing is. The camera's own focus does not count; its tilt, swing, diaphragm and wavelengths do.
///
/// # Errors
/// [`CameraError`].
pub fn on_picture_point(
    d: &CameraDescription,
    [width, height]: [u32; 2],
    p: Vec2,
    distance_to: impl Fn(&Ray) -> Option<f32>,
) -> Result<SharpFilm, CameraError> {
    let mut finder = Finder::new(d, width, height)?;
    let info = &finder.mount.info;
    let half = [0.5 * info.picture_width_mm, 0.5 * info.picture_height_mm];
    let tracer = finder.system.at_wavelength(finder.line_nm);
    // The exit pupil hardly changes with the film's place: one map serves all.
    let map = PupilMap::new(&tracer, &finder.system, &finder.mount.film, half[0], half[1]);
    let mut seen = finder.look(p, &tracer, &map, &distance_to)?;
    for step in 1..MOST_STEPS {
        let (film, rms_spot_mm) = finder.sharpest(seen)?;
        let is_settled = finder.put(film);
        if step >= LOOKS && is_settled {
            let subject_world = match seen {
                SubjectHit::Point(point) => Some(point + d.position()),
                SubjectHit::Sky(_) => None,
            };
            let found = if finder.mount.info.focuses_inside {
                finder.by_groups(seen, [width, height])?
            } else {
                finder.found(rms_spot_mm)
            };
            return Ok(SharpFilm { subject_world, ..found });
        }
        if step < LOOKS {
            seen = finder.look(p, &tracer, &map, &distance_to)?;
        }
    }
    Err(d.error("no focus settles on the autofocus point; choose another point"))
}

/// Turns the film and puts it where three points of the world are sharp at once. The camera's own focus, tilt and swing do
/// not count. Models to first order get the film of the lens itself.
///
/// # Errors
/// [`CameraError`].
pub fn on_three_points(
    d: &CameraDescription,
    [width, height]: [u32; 2],
    points_world: [DVec3; 3],
) -> Result<SharpFilm, CameraError> {
    let mut finder = Finder::new(d, width, height)?;
    let wrong = |source: SharpPlaneError| CameraError::SharpPlane { camera: d.object_name.clone(), source };
    if finder.mount.film.curvature_per_mm != 0.0 {
        return Err(d.error("its film is a retina, which cannot be turned; choose a lens with a flat film"));
    }
    if !points_world.iter().all(|p| p.is_finite()) {
        return Err(d.error("a sharp point is not finite; give three points of the world"));
    }
    for _ in 0..MOST_STEPS {
        // Where the lens moves with the focus, the points move for it.
        let points = points_world.map(|p| Subject::Point(finder.mount.to_lens(p - d.position())));
        let film = finder.auto.film_through(points).map_err(wrong)?;
        let shift_mm = finder.mount.film.shift_mm;
        if finder.put(FilmPlane { shift_mm, ..film }) {
            let spot = |subject| finder.auto.film(subject, &film).map_or(0.0, |sharpest| sharpest.rms_mm);
            return Ok(finder.found(points.map(spot).into_iter().fold(0.0, f64::max)));
        }
    }
    Err(wrong(SharpPlaneError::Unsettled))
}

/// The subject at a picture point.
#[derive(Clone, Copy, Debug)]
enum SubjectHit {
    /// A point, render space.
    Point(DVec3),
    /// No hit, in this direction of lens space.
    Sky(DVec3),
}

/// A camera on its way to its focus.
struct Finder<'a> {
    d: &'a CameraDescription,
    mount: Mount,
    system: System,
    auto: Autofocus,
    line_nm: f64,
}

impl<'a> Finder<'a> {
    /// A finder of a lens that is focused at infinity.
    fn new(d: &'a CameraDescription, width: u32, height: u32) -> Result<Self, CameraError> {
        if !d.model.is_of_lens() {
            return Err(d.error("only a lens can be focused so; choose a camera model that is made from a lens file"));
        }
        d.check(width, height)?;
        let far = d.clone().with(|c| {
            c.focus.distance = None;
            c.focus.point_world = None;
            c.focus.film_distance_mm = None;
        });
        let (mount, system) = Mount::new(&far, d.axes()?, width, height)?;
        let line_nm = d.wavelength_nm.unwrap_or(D_LINE_NM);
        let auto = Self::autofocus(d, &system);
        Ok(Self { d, mount, system, auto, line_nm })
    }

    fn autofocus(d: &CameraDescription, system: &System) -> Autofocus {
        match d.wavelength_nm {
            None if system.is_dispersive() => Autofocus::new(system, &PHOTOPIC),
            nm => Autofocus::new(system, &[(nm.unwrap_or(D_LINE_NM), 1.0)]),
        }
    }

    /// The subject that a picture point sees from the present film, by the mean of its rays.
    fn look(
        &self,
        p: Vec2,
        tracer: &Tracer,
        map: &PupilMap,
        distance_to: impl Fn(&Ray) -> Option<f32>,
    ) -> Result<SubjectHit, CameraError> {
        let film = self.mount.film_at(p).point;
        let Some(mean) = beam::mean(beam::through(tracer, map, film, RAYS).iter()) else {
            return Err(self
                .d
                .error("the autofocus point gets no light; choose a point nearer to the picture's middle"));
        };
        let ray = self.mount.to_render(&mean);
        Ok(match distance_to(&ray) {
            Some(t) => SubjectHit::Point((ray.origin + ray.direction * t).as_dvec3()),
            None => SubjectHit::Sky(mean.direction),
        })
    }

    /// The film on which that is sharp, and the radius of its spot.
    fn sharpest(&self, seen: SubjectHit) -> Result<(FilmPlane, f64), CameraError> {
        let film = self.mount.film;
        let subject = match seen {
            SubjectHit::Point(point) => Subject::Point(self.mount.to_lens(point)),
            SubjectHit::Sky(direction) => Subject::Direction(direction),
        };
        if matches!(self.d.model, Model::Thick | Model::Paraxial) {
            return Ok((self.first_order(subject)?, 0.0));
        }
        let wrong = |source| CameraError::Autofocus { camera: self.d.object_name.clone(), source };
        let sharpest = self.auto.film(subject, &film).map_err(wrong)?;
        Ok((FilmPlane { z_mm: sharpest.film_z_mm, ..film }, sharpest.rms_mm))
    }

    /// The film through the subject's paraxial image.
    fn first_order(&self, subject: Subject) -> Result<FilmPlane, CameraError> {
        let wrong = |source| CameraError::Focus { camera: self.d.object_name.clone(), source };
        let point = match subject {
            Subject::Point(point) => point,
            Subject::Direction(direction) => direction * FAR_MM,
        };
        let from_vertex = Focusing { anchor: Anchor::FrontVertex, ..Focusing::default() };
        let z_mm = from_vertex.film_z_mm(&self.system, self.line_nm, -point.z).map_err(wrong)?;
        let image = point.truncate() * magnification(&self.system, self.line_nm, z_mm);
        // The film as it is turned and curved, moved until its point there is the image.
        let film = FilmPlane { z_mm: 0.0, ..self.mount.film };
        let along = LensRay { origin: image.extend(-FAR_MM.sqrt()), direction: DVec3::Z };
        let sag = film.frame().meet(&along).map_or(0.0, |[u, v]| film.point(u, v).z);
        Ok(FilmPlane { z_mm: z_mm - sag, ..film })
    }

    /// Puts the film, and the lens with it where the film is the anchor; true if it hardly moved.
    fn put(&mut self, film: FilmPlane) -> bool {
        let before = std::mem::replace(&mut self.mount.film, film);
        self.mount.refocus(film, self.d.focus.focusing.origin_z_mm(&self.system, self.line_nm, film.z_mm));
        let turned = (film.tilt_rad - before.tilt_rad).abs() + (film.swing_rad - before.swing_rad).abs();
        (film.z_mm - before.z_mm).abs() + turned < SETTLED * film.z_mm.abs().max(1.0)
    }

    fn found(&self, rms_spot_mm: f64) -> SharpFilm {
        let film = &self.mount.film;
        let scale = self.d.focus.focusing.distance_mm(&self.system, self.line_nm, film.z_mm);
        SharpFilm {
            film_distance_mm: film.z_mm - self.system.last_vertex_z_mm(),
            focus_scale_mm: scale.is_finite().then_some(scale),
            tilt_rad: film.tilt_rad,
            swing_rad: film.swing_rad,
            moves_groups: false,
            rms_spot_mm,
            subject_world: None,
        }
    }

    /// The focus at which the groups of the lens make the target sharpest on the film, where that stands: a secant over
    /// the nearness, from infinity and from the target itself.
    fn by_groups(&self, seen: SubjectHit, [width, height]: [u32; 2]) -> Result<SharpFilm, CameraError> {
        let per_unit = self.d.scale_mm_per_unit.z;
        let at = |nearness_per_mm: f64| -> Result<(Finder<'a>, f64, f64), CameraError> {
            let near = self.d.clone().with(|c| {
                c.focus.distance = (nearness_per_mm > 0.0).then(|| (nearness_per_mm * per_unit).recip());
                c.focus.point_world = None;
                c.focus.film_distance_mm = None;
            });
            let (mount, system) = Mount::new(&near, self.d.axes()?, width, height)?;
            let auto = Finder::autofocus(self.d, &system);
            let finder = Finder { d: self.d, mount, system, auto, line_nm: self.line_nm };
            let (film, rms_spot_mm) = finder.sharpest(seen)?;
            let behind = film.z_mm - finder.mount.film.z_mm;
            Ok((finder, behind, rms_spot_mm))
        };
        let (mut finder, mut error, mut rms_spot_mm) = at(0.0)?;
        if let SubjectHit::Point(point) = seen {
            let (mut before, mut then) = (0.0, error);
            let depth_mm = -self.mount.axes().z_axis.dot(point) * per_unit;
            let mut now = depth_mm.max(1.0).recip();
            for _ in 0..MOST_SECANTS {
                (finder, error, rms_spot_mm) = at(now)?;
                let step = error * (now - before) / (error - then);
                if !step.is_finite() || error.abs() < SETTLED * finder.mount.film.z_mm.abs().max(1.0) {
                    break;
                }
                (before, then) = (now, error);
                // Not beyond infinity, and not at once to where the lens cannot follow.
                now = (now - step).clamp(0.5 * now, 2.0 * now);
            }
        }
        Ok(SharpFilm { moves_groups: true, ..finder.found(rms_spot_mm) })
    }
}

#[cfg(test)]
mod tests;
