//! The rays of a film point through all of the clear pupil, spread evenly: their mean is the direction in which the point looks.

use glam::DVec3;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::trace::{Bundle, Ray, Tracer, Travel};

/// Adds that many rays from a film point (lens space) to a bundle from the film.
pub(in crate::camera) fn push(bundle: &mut Bundle, map: &PupilMap, film: DVec3, rays: u32) {
    for i in 0..rays {
        let u = [(f64::from(i) + 0.5) / f64::from(rays), (f64::from(i) * 0.618_033_988_75).fract()];
        bundle.push(Ray { origin: film, direction: (map.sample(film, u).target - film).normalize() });
    }
}

/// Rays of a film point before the lens: those of `rays` that get through.
pub(in crate::camera) fn through(tracer: &Tracer, map: &PupilMap, film: DVec3, rays: u32) -> Vec<Ray> {
    let mut bundle = tracer.bundle(Travel::FromFilm);
    push(&mut bundle, map, film, rays);
    tracer.trace(&mut bundle);
    (0..bundle.len()).filter_map(|i| bundle.result(i).ok()).collect()
}

/// The mean of rays that got through; `None` of none.
pub(in crate::camera) fn mean<'a>(rays: impl Iterator<Item = &'a Ray>) -> Option<Ray> {
    let add = |(origin, direction, n): (DVec3, DVec3, f64), ray: &Ray| {
        (origin + ray.origin, direction + ray.direction, n + 1.0)
    };
    let (origin, direction, count) = rays.fold((DVec3::ZERO, DVec3::ZERO, 0.0), add);
    Some(Ray { origin: origin / count, direction: direction.try_normalize()? })
}
