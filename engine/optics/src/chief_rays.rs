//! Chief rays of film points: from a point of the film through the middle of the stop into the scene.
//!
//! The ray is looked for from the film, where a lens of any field has one for every point that it lights: at wide angles the pupil wanders and
//! turns on the side of the scene alone. Rims do not count for the aim, and are asked afterwards.

use glam::{DMat2, DVec2, DVec3};
use thiserror::Error;

use crate::focus::{FilmFrame, FilmPlane};
use crate::paraxial::Paraxial;
use crate::system::{Element, System};
use crate::trace::{Ray, Tracer};
use crate::vector::Vector;

/// Rays are aimed at the stop's middle to this part of its radius.
const AIMED: f64 = 1e-10;
/// The residual that rounding leaves is good enough where no step brings the ray nearer.
const GOOD: f64 = 1e-7;
/// Newton's method is done or lost after so many steps, each halved so often before it is given up.
const MOST_STEPS: u32 = 30;
const MOST_HALVINGS: u32 = 12;
/// Slopes are taken over this change of the ray's own.
const DIFFERENCE: f64 = 1e-7;
/// Places on the way from the middle of the film at which a ray is looked for that is not found at once.
const PLACES: u32 = 24;

/// The reason why a lens has no chief rays to speak of.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ChiefRayError {
    /// The lens has a mirror.
    #[error("lens '{0}' has mirrors, which may hide its chief rays; they are followed through lenses without mirrors")]
    Mirror(String),
    /// The lens has no power.
    #[error("lens '{0}' has no focal length (its power is 0), so it forms no picture of a scene")]
    Afocal(String),
    /// The entrance pupil lies at infinity.
    #[error("lens '{0}' has its entrance pupil at infinity: it has no centre of projection")]
    Telecentric(String),
}

/// A chief ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmChiefRay {
    /// The ray in front of the lens, lens space; it leaves the first surface at its origin and looks into the scene.
    pub scene: Ray,
    /// The slopes before the film, along x and y by −z: a start for the neighbours.
    pub slope: DVec2,
    /// Changes of the hit on the stop by those of the slopes, radii of the stop.
    pub stop_by_slope: DMat2,
}

/// The chief rays of a lens before a film, at one wavelength.
pub struct FilmChiefRays {
    tracer: Tracer,
    open: Tracer,
    frame: FilmFrame,
    film: FilmPlane,
    exit_z_mm: Option<f64>,
    /// Index of the stop counted from the film, its place and its radius.
    stop: usize,
    stop_z_mm: f64,
    stop_radius_mm: f64,
    stop_surface: crate::system::Surface,
}

impl FilmChiefRays {
    /// The chief rays at a vacuum wavelength, nm.
    ///
    /// # Errors
    /// [`ChiefRayError`].
    pub fn new(system: &System, wavelength_nm: f64, film: FilmPlane) -> Result<Self, ChiefRayError> {
        let name = || system.name().to_owned();
        if system.surfaces().iter().any(|s| matches!(s.element, Element::Reflect { .. })) {
            return Err(ChiefRayError::Mirror(name()));
        }
        let paraxial = Paraxial::new(system, wavelength_nm);
        if paraxial.efl_mm.is_none() {
            return Err(ChiefRayError::Afocal(name()));
        }
        if paraxial.entrance_pupil.z_mm.is_none() {
            return Err(ChiefRayError::Telecentric(name()));
        }
        let tracer = system.at_wavelength(wavelength_nm);
        let stop_surface = system.surfaces()[system.stop()].clone();
        Ok(Self {
            open: tracer.without_rims(),
            tracer,
            frame: film.frame(),
            film,
            exit_z_mm: paraxial.exit_pupil.z_mm,
            stop: system.surface_count() - 1 - system.stop(),
            stop_z_mm: stop_surface.z_mm,
            // However far the lens is stopped down, its middle is the same.
            stop_radius_mm: stop_surface.semi_diameter_mm,
            stop_surface,
        })
    }

    /// The chief ray of the film point (u, v), mm; `None`: there is none. `near`: one of a point beside it.
    pub fn at(&self, point: DVec2, near: Option<&FilmChiefRay>) -> Option<FilmChiefRay> {
        if !self.film.reaches(point.x, point.y) {
            return None;
        }
        near.and_then(|near| self.beside(point, near))
            .or_else(|| self.search(point, self.paraxial_slope(point)))
            .or_else(|| self.along_line_from_middle(point))
    }

    /// True if no rim stops the chief ray of a film point.
    pub fn is_through(&self, point: DVec2, chief: &FilmChiefRay) -> bool {
        self.tracer.from_film(self.ray(point, chief.slope)).is_ok()
    }

    fn ray(&self, point: DVec2, slope: DVec2) -> Ray {
        Ray { origin: self.frame.at(point.x, point.y).point, direction: slope.extend(-1.0).normalize() }
    }

    fn paraxial_slope(&self, point: DVec2) -> DVec2 {
        let from = self.frame.at(point.x, point.y).point;
        self.exit_z_mm.map_or(DVec2::ZERO, |z| -from.truncate() / (from.z - z))
    }

    /// The ray in front of the lens, and its hit on the stop, radii from the middle.
    fn pass(&self, point: DVec2, slope: DVec2) -> Option<(Ray, DVec2)> {
        let mut hits = Vec::with_capacity(self.stop + 1);
        let scene = self.open.from_film_recording(self.ray(point, slope), &mut hits).ok()?;
        let hit = *hits.get(self.stop)?;
        let from_vertex = Vector::<f64>::from_f64(hit.with_z(hit.z - self.stop_z_mm));
        Some((scene, self.stop_surface.pose.point_in(from_vertex).of(0).truncate() / self.stop_radius_mm))
    }

    /// The chief ray of a point beside another one, found by steps with the slopes of that, which hardly change; `None` where they do.
    fn beside(&self, point: DVec2, near: &FilmChiefRay) -> Option<FilmChiefRay> {
        let back = near.stop_by_slope.inverse();
        let mut slope = near.slope;
        let mut missed = f64::INFINITY;
        for _ in 0..6 {
            let (scene, off) = self.pass(point, slope)?;
            if off.length() <= AIMED {
                return Some(FilmChiefRay { scene, slope, stop_by_slope: near.stop_by_slope });
            }
            if !(off.length() < 0.3 * missed) {
                return None;
            }
            missed = off.length();
            slope -= back * off;
        }
        None
    }

    /// The chief ray of a point, found by Newton's method with steps that are halved until they bring the ray nearer; `None`: there is none.
    fn search(&self, point: DVec2, start: DVec2) -> Option<FilmChiefRay> {
        let mut slope = start;
        let (mut scene, mut off) = self.pass(point, slope)?;
        for _ in 0..MOST_STEPS {
            let by = |axis: DVec2| Some((self.pass(point, slope + axis * DIFFERENCE)?.1 - off) / DIFFERENCE);
            let stop_by_slope = DMat2::from_cols(by(DVec2::X)?, by(DVec2::Y)?);
            if off.length() <= AIMED {
                return Some(FilmChiefRay { scene, slope, stop_by_slope });
            }
            let step = stop_by_slope.inverse() * -off;
            if !step.is_finite() {
                return None;
            }
            let nearer = |halvings: u32| {
                let next = slope + step * 0.5f64.powi(halvings as i32);
                let (scene, missed) = self.pass(point, next)?;
                (missed.length() < off.length()).then_some((next, scene, missed))
            };
            match (0..MOST_HALVINGS).find_map(nearer) {
                Some(found) => (slope, scene, off) = found,
                None => return (off.length() < GOOD).then_some(FilmChiefRay { scene, slope, stop_by_slope }),
            }
        }
        None
    }

    fn along_line_from_middle(&self, point: DVec2) -> Option<FilmChiefRay> {
        // The axis of the lens, where the film is shifted.
        let begin = -DVec2::from(self.film.shift_mm);
        let mut here = self.search(begin, self.paraxial_slope(begin))?;
        for i in 1..=PLACES {
            here = self.search(begin.lerp(point, f64::from(i) / f64::from(PLACES)), here.slope)?;
        }
        Some(here)
    }
}

/// The direction from the origin to where a ray is at a distance, mm, `None` for infinity: on the plane across z if `is_flat`, else on the
/// sphere about the origin. The ray is in camera space (x right, y down, z ahead). `None`: it does not come there.
pub fn direction_at(origin_mm: DVec3, direction: DVec3, distance_mm: Option<f64>, is_flat: bool) -> Option<DVec3> {
    let Some(distance) = distance_mm else { return Some(direction) };
    let way = if is_flat {
        (distance - origin_mm.z) / direction.z
    } else {
        let along = origin_mm.dot(direction);
        -along + (along * along - origin_mm.length_squared() + distance * distance).sqrt()
    };
    (way > 0.0 && way.is_finite()).then(|| (origin_mm + direction * way).normalize())
}

/// A vector of lens space in camera space, or back: x right, y down, z ahead.
pub fn turned(v: DVec3) -> DVec3 {
    DVec3::new(v.x, -v.y, -v.z)
}

/// The point of the axis that is nearest to some rays, by least squares of their distances, z in lens space; `None`: all run along the axis.
pub fn nearest_on_axis_mm<'a>(rays: impl IntoIterator<Item = &'a Ray>) -> Option<f64> {
    // The distance of (0, 0, z) from a ray, squared: |(o - z) - d (d . (o - z))|^2.
    let (mut along, mut against) = (0.0, 0.0);
    for ray in rays {
        let across = |v: DVec3| v - ray.direction * v.dot(ray.direction);
        let axis = across(DVec3::Z);
        along += axis.length_squared();
        against += axis.dot(across(ray.origin));
    }
    let z = against / along;
    z.is_finite().then_some(z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::{Catalogue, line_nm};
    use crate::system::LensSettings;
    use std::path::Path;

    fn system(name: &str) -> System {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses").join(name);
        let lens = lens::read(&path, Catalogue::shipped()).unwrap();
        System::new(&lens, &LensSettings::default()).unwrap()
    }

    /// Rays run back from the scene to the film point, and cross the axis at the stop's middle.
    #[test]
    fn chief_rays_come_back() {
        for name in ["double-gauss-f2-tronnier.lens", "laikin-fisheye-170.lens"] {
            let system = system(name);
            let film = FilmPlane { tilt_rad: 0.02, ..FilmPlane::upright(Paraxial::new(&system, line_nm::D).film_z_mm) };
            let rays = FilmChiefRays::new(&system, line_nm::D, film).unwrap();
            let open = system.at_wavelength(line_nm::D).without_rims();
            let mut near = None;
            for i in 0..40 {
                let point = DVec2::new(0.13 * f64::from(i), -0.06 * f64::from(i));
                let found = rays.at(point, near.as_ref()).unwrap_or_else(|| panic!("{name} {point}"));
                let alone = rays.at(point, None).unwrap();
                assert!((found.scene.direction - alone.scene.direction).length() < 1e-9);
                let back = Ray { origin: found.scene.origin, direction: -found.scene.direction };
                let mut hits = Vec::new();
                let out = open.from_scene_recording(back, &mut hits).unwrap();
                let [u, v] = film.frame().meet(&out).unwrap();
                assert!((DVec2::new(u, v) - point).length() < 1e-8, "{name} {point}: {u} {v}");
                assert!(hits[system.stop()].truncate().length() < 1e-7, "{name}");
                near = Some(found);
            }
        }
    }

    #[test]
    fn rays_through_a_point_of_the_axis_meet_there() {
        let at = DVec3::new(0.0, 0.0, 12.5);
        let ray = |x: f64, y: f64| {
            let direction = DVec3::new(x, y, -1.0).normalize();
            Ray { origin: at + direction * 30.0, direction }
        };
        let rays = [ray(0.1, 0.2), ray(-0.3, 0.0), ray(0.5, -0.7)];
        assert!((nearest_on_axis_mm(&rays).unwrap() - 12.5).abs() < 1e-12);
        assert_eq!(nearest_on_axis_mm(&[ray(0.0, 0.0)]), None);
    }

    #[test]
    fn what_has_none_is_named() {
        let wrong = |name: &str| {
            let system = system(name);
            FilmChiefRays::new(&system, line_nm::D, FilmPlane::upright(100.0)).err().unwrap()
        };
        assert!(matches!(wrong("cassegrain-f12.lens"), ChiefRayError::Mirror(_)));
    }
}
