//! Focusing by exact rays: the film on which the spot of a point is smallest, and the turned film on which three points
//! are sharp at once (selective focusing, Wu et al. 2011, §4).
//!
//! The beam of a point is traced through the lens as it is set. On a film that moves along the axis each of its rays
//! lands where a straight line says, so the mean square of the spot is a parabola in the film's place and its minimum
//! a quotient of two sums. Paraxial conjugates put the film where rays near the axis converge; spherical aberration, field
//! curvature and colour move the smallest spot away from there.

mod plane;

use glam::DVec3;
use thiserror::Error;

use crate::entrance_map::EntranceMap;
use crate::focus::FilmPlane;
use crate::system::System;
use crate::trace::{Ray, Tracer, Travel};

pub use plane::SharpPlaneError;

/// Wavelengths (nm) and weights that stand for the light that the eye sees: the luminous efficiency V(λ) of CIE 1924.
pub const PHOTOPIC: [(f64, f64); 5] = [(470.0, 0.091), (510.0, 0.503), (555.0, 1.0), (610.0, 0.503), (650.0, 0.107)];

/// Rays of a wavelength; and of a second try, where nearly all of the first are lost.
const RAYS: [u32; 2] = [1024, 65_536];
/// Least number of rays of all wavelengths together: fewer say nothing about a spot.
const FEWEST_RAYS: usize = 12;
/// Infinity, in radii of the front glass: nearer, defocus would be seen; farther, roundings.
const FAR: f64 = 1e8;
/// An image farther behind the lens than this many of its lengths is at infinity.
const FARTHEST_IMAGE: f64 = 1e5;
/// Steps along a curved film; each leaves a hundredth of the last one's error or less.
const CURVED_STEPS: usize = 16;

/// The subject that is to be sharp, in lens space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subject {
    /// A point of the scene in lens space, mm.
    Point(DVec3),
    /// Infinitely far in this direction, seen from the lens: a unit vector.
    Direction(DVec3),
}

/// An error by which no film makes a point sharp.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AutofocusError {
    /// All of the point's rays are lost.
    #[error("no light of it gets through the lens; choose a point that the lens sees, or open the diaphragm")]
    NothingThrough,
    /// The point's rays leave the lens parallel or diverging.
    #[error("the lens forms no real image of it; choose a point farther away")]
    NoRealImage,
}

/// The film on which a point is sharpest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sharpest {
    /// The z of the film on the axis, lens space.
    pub film_z_mm: f64,
    /// Root of the mean square distance of the rays from their middle, on that film.
    pub rms_mm: f64,
    /// The middle of the rays on that film, lens space.
    pub image_mm: DVec3,
}

/// A lens ready to be focused.
#[derive(Clone, Debug)]
pub struct Autofocus {
    /// The lens at each wavelength, with the weight of the wavelength.
    lines: Vec<(Tracer, f64)>,
    entrance: EntranceMap,
    far_mm: f64,
    last_z_mm: f64,
    towards_film: f64,
    length_mm: f64,
}

/// A ray behind the lens, and its weight.
type Weighted = (Ray, f64);

impl Autofocus {
    /// A lens for light of these vacuum wavelengths (nm) and weights, such as [`PHOTOPIC`].
    pub fn new(system: &System, wavelengths: &[(f64, f64)]) -> Self {
        let lines: Vec<_> = wavelengths.iter().map(|&(nm, weight)| (system.at_wavelength(nm), weight)).collect();
        let of_map = [0, lines.len() / 2, lines.len().saturating_sub(1)];
        let tracers: Vec<Tracer> = match lines.len() {
            0 | 1 => lines.iter().map(|(tracer, _)| tracer.clone()).collect(),
            _ => of_map.map(|i| lines[i].0.clone()).to_vec(),
        };
        let size = |s: &crate::system::Surface| s.thickness_mm.abs() + s.semi_diameter_mm;
        Self {
            entrance: EntranceMap::new(&tracers, system),
            lines,
            far_mm: FAR * system.surfaces()[0].semi_diameter_mm,
            last_z_mm: system.last_vertex_z_mm(),
            towards_film: system.light_direction_at_film(),
            length_mm: system.surfaces().iter().map(size).sum(),
        }
    }

    /// The film turned, shifted and curved as `film`, whose z does not count, on which the subject's spot is smallest.
    /// On a curved film the spot is that on the plane which touches it there.
    ///
    /// # Errors
    /// [`AutofocusError`].
    pub fn film(&self, subject: Subject, film: &FilmPlane) -> Result<Sharpest, AutofocusError> {
        self.of_beam(&self.beam(subject)?, film)
    }

    fn of_beam(&self, beam: &[Weighted], film: &FilmPlane) -> Result<Sharpest, AutofocusError> {
        let mut sharpest = self.smallest(beam, film.normal(), DVec3::ZERO)?;
        if film.curvature_per_mm == 0.0 {
            return Ok(sharpest);
        }
        for _ in 0..CURVED_STEPS {
            let frame = FilmPlane { z_mm: sharpest.film_z_mm, shift_mm: [0.0; 2], ..*film }.frame();
            // The film's point below the image, and the plane that touches it there.
            let direction = DVec3::Z * self.towards_film;
            let from = Ray { origin: sharpest.image_mm - direction * self.length_mm, direction };
            let Some([u, v]) = frame.meet(&from) else { return Err(AutofocusError::NoRealImage) };
            let place = frame.at(u, v);
            sharpest = self.smallest(beam, place.normal, place.point - DVec3::Z * sharpest.film_z_mm)?;
        }
        Ok(sharpest)
    }

    /// The rays of the subject's light that get through: evenly over the solid angle.
    fn beam(&self, subject: Subject) -> Result<Vec<Weighted>, AutofocusError> {
        let from = match subject {
            Subject::Point(point) => point,
            Subject::Direction(towards) => self.entrance.middle() + towards * self.far_mm,
        };
        for rays in RAYS {
            let mut beam = Vec::new();
            for (tracer, weight) in &self.lines {
                let mut bundle = tracer.bundle(Travel::FromScene);
                let mut weights = Vec::with_capacity(rays as usize);
                for i in 0..rays {
                    let u = [(f64::from(i) + 0.5) / f64::from(rays), (f64::from(i) * 0.618_033_988_75).fract()];
                    if let Some(aim) = self.entrance.sample(from, u) {
                        bundle.push(Ray { origin: from, direction: aim.direction });
                        weights.push(weight / aim.pdf_per_sr);
                    }
                }
                tracer.trace(&mut bundle);
                beam.extend(weights.iter().enumerate().filter_map(|(i, &w)| Some((bundle.result(i).ok()?, w))));
            }
            let sum: f64 = beam.iter().map(|(_, weight)| weight).sum();
            if beam.len() >= FEWEST_RAYS && sum > 0.0 && sum.is_finite() {
                beam.iter_mut().for_each(|(_, weight)| *weight /= sum);
                return Ok(beam);
            }
        }
        Err(AutofocusError::NothingThrough)
    }

    /// The smallest spot on planes of that normal that go through the axis at z and through z + `offset`.
    fn smallest(&self, beam: &[Weighted], normal: DVec3, offset: DVec3) -> Result<Sharpest, AutofocusError> {
        // Seen from the plane's own point, a ray lands at a + b z.
        let landing = |ray: &Ray| {
            let nearing = ray.direction.dot(normal);
            let a = ray.origin - offset;
            let ahead = nearing * normal.z * self.towards_film > 0.0;
            ahead.then(|| {
                let slope = ray.direction / nearing;
                (a - slope * a.dot(normal), slope * normal.z - DVec3::Z)
            })
        };
        let (mut weight, mut a, mut b) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for ((of_a, of_b), w) in beam.iter().filter_map(|(ray, w)| Some((landing(ray)?, w))) {
            (weight, a, b) = (weight + w, a + of_a * *w, b + of_b * *w);
        }
        let (a, b) = (a / weight, b / weight);
        let [mut aa, mut ab, mut bb] = [0.0; 3];
        for ((of_a, of_b), w) in beam.iter().filter_map(|(ray, w)| Some((landing(ray)?, w))) {
            let (from_a, from_b) = (of_a - a, of_b - b);
            aa += w * from_a.length_squared();
            ab += w * from_a.dot(from_b);
            bb += w * from_b.length_squared();
        }
        let film_z_mm = -ab / bb;
        let image_mm = a + b * film_z_mm + offset + DVec3::Z * film_z_mm;
        let behind = (image_mm.z - self.last_z_mm) * self.towards_film;
        // Also where no ray nears the film or the beam has no width: then they are NaN.
        if !(film_z_mm.is_finite() && behind > 0.0 && behind < FARTHEST_IMAGE * self.length_mm) {
            return Err(AutofocusError::NoRealImage);
        }
        let square = (aa + film_z_mm * (2.0 * ab + film_z_mm * bb)) / weight;
        Ok(Sharpest { film_z_mm, rms_mm: square.max(0.0).sqrt(), image_mm })
    }
}

#[cfg(test)]
mod tests;
