//! Optical path lengths of the light of a point: the angle characteristic of the rays behind the lens.
//!
//! A ray's *path* is its optical path from the source (from its plane wave, at infinity) to the foot of the perpendicular on it from the
//! place Q of the film. As a function W(α, β) of the ray's direction cosines, times the index before the film, in the plane that touches
//! the film at Q, it is Hamilton's mixed characteristic: its slopes are the places where the rays cross that plane, ∂W/∂α = −x, ∂W/∂β = −y
//! (Born and Wolf, Principles of Optics, 7th ed., section 4.1), and the light near Q is the sum of the plane waves exp 2πi W / λ, without
//! an approximation of small angles.

use crate::system::{Element, System};
use crate::trace::{Ray, Tracer};

use super::Touching;
use glam::DVec2;

/// Rays of one wavelength, and their optical path lengths.
pub(super) struct Eikonal<'a> {
    tracer: &'a Tracer,
    /// Indices before each surface, and before the film.
    indices: Vec<f64>,
    touching: Touching,
}

/// A ray behind the lens.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageRay {
    pub(super) out: Ray,
    /// Optical path length to the foot of the perpendicular from the film's place.
    pub(super) path_mm: f64,
    /// The point at which it crosses the plane that touches the film there: sagittal and tangential, mm.
    pub(super) crossing: DVec2,
    /// Length of the perpendicular.
    miss_mm: f64,
    image_index: f64,
}

impl<'a> Eikonal<'a> {
    pub(super) fn new(system: &System, tracer: &'a Tracer, touching: Touching) -> Self {
        let nm = tracer.wavelength_nm();
        let before = |element: &Element| match element {
            Element::Refract { from, .. } => from.index(nm),
            Element::Reflect { medium } => medium.index(nm),
        };
        let mut indices: Vec<f64> = system.surfaces().iter().map(|s| before(&s.element)).collect();
        indices.push(system.image_index(nm).abs());
        Self { tracer, indices, touching }
    }

    /// The path of a ray on the scene's side, which starts at its source, or for one at infinity on the plane wave through the first
    /// vertex. `None`: it does not come through.
    pub(super) fn of(&self, ray: Ray) -> Option<ImageRay> {
        let mut lengths = Vec::with_capacity(self.indices.len());
        let out = self.tracer.from_scene_measuring(ray, &mut lengths).ok()?;
        let image_index = *self.indices.last()?;
        let through: f64 = lengths.iter().zip(&self.indices).map(|(length, index)| length * index).sum();
        let to_film = self.touching.point - out.origin;
        let along = to_film.dot(out.direction);
        Some(ImageRay {
            out,
            path_mm: through + image_index * along,
            crossing: self.touching.crossing(&out),
            miss_mm: (to_film - out.direction * along).length(),
            image_index,
        })
    }

    /// The index before the film.
    pub(super) fn image_index(&self) -> f64 {
        self.indices.last().copied().unwrap_or(1.0)
    }

    /// The plane at the film.
    pub(super) fn touching(&self) -> &Touching {
        &self.touching
    }
}

impl ImageRay {
    /// The path to the sphere of that radius about the film's place, as long for a ray through that place as `path_mm` is. The radius is
    /// negative if light comes to the sphere after the film, infinite for a plane.
    pub(super) fn to_sphere_mm(self, radius_mm: f64) -> f64 {
        // R − √(R² − m²); a ray that misses the sphere comes nearest to it at m = R.
        let radius = radius_mm.abs();
        let m = self.miss_mm.min(radius);
        let sag = if radius.is_finite() { m * m / (radius + (radius * radius - m * m).sqrt()) } else { 0.0 };
        self.path_mm + self.image_index * sag.copysign(radius_mm)
    }
}
