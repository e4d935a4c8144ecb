//! Rays through a lens as Gaussian optics has them: heights and slopes change linearly, in x and y apart.
//!
//! The model of the thick lens (Kolb, Mitchell and Hanrahan 1995, §3.4) and of any ABCD tracer: perfect images. It
//! keeps the planes and pupils of a lens (Wu et al. 2011, §3.2.2), and leaves out its rims: at the angles where they
//! matter, heights that grow with the tangent would have them cut far too much.

use glam::{DVec2, DVec3};

use crate::first_order::{Matrix, between_vertices, rear_of};
use crate::surface::Section;
use crate::system::System;
use crate::trace::Ray;

/// A lens at one wavelength as two matrices, one a section.
#[derive(Clone, Debug)]
pub struct GaussianLens {
    /// Matrices from the first vertex plane to the last, in x and y.
    whole: [Matrix; 2],
    /// Matrices from the stop to the last vertex plane.
    rear: [Matrix; 2],
    last_z: f64,
    /// Signed index before the film.
    image_index: f64,
}

impl GaussianLens {
    /// The lens at a vacuum wavelength in nm.
    pub fn new(system: &System, wavelength_nm: f64) -> Self {
        let sections = [Section::X, Section::Y].map(|section| system.thin_in(section, wavelength_nm));
        Self {
            whole: sections.each_ref().map(|thin| between_vertices(thin)),
            rear: sections.each_ref().map(|thin| rear_of(thin, system.stop())),
            last_z: system.last_vertex_z_mm(),
            image_index: sections[0].last().map_or(1.0, |s| s.to),
        }
    }

    /// The slopes dx/dz and dy/dz before the film of the ray through the film point `film` (lens space, mm) and the
    /// point `stop` (mm) of the opening.
    pub fn slopes(&self, film: DVec3, stop: DVec2) -> DVec2 {
        let slope = |axis: usize| {
            let Matrix { d, .. } = self.rear[axis];
            (d * film[axis] - stop[axis]) / self.spread(axis, film.z)
        };
        DVec2::new(slope(0), slope(1))
    }

    /// The point of the opening through which the ray with these slopes reaches the film point, mm.
    pub fn stop_point(&self, film: DVec3, slopes: DVec2) -> DVec2 {
        let point = |axis: usize| self.rear[axis].d * film[axis] - slopes[axis] * self.spread(axis, film.z);
        DVec2::new(point(0), point(1))
    }

    /// The part of the square of slopes that a mm² of the opening fills, seen from a film at `film_z_mm`.
    pub fn slopes_per_mm2(&self, film_z_mm: f64) -> f64 {
        1.0 / (self.spread(0, film_z_mm) * self.spread(1, film_z_mm)).abs()
    }

    /// −d stop / d slope, for a film at `film_z_mm`.
    fn spread(&self, axis: usize, film_z_mm: f64) -> f64 {
        let Matrix { b, d, .. } = self.rear[axis];
        d * (film_z_mm - self.last_z) + b * self.image_index
    }

    /// The ray into the scene that reaches the film point `film` with these slopes, its origin in the first vertex plane.
    pub fn into_scene(&self, film: DVec3, slopes: DVec2) -> Ray {
        let height = film.truncate() - slopes * (film.z - self.last_z);
        let reduced = slopes * self.image_index;
        // The medium before the first surface is air: there the reduced slope is the slope.
        let [x, y] = [0, 1].map(|axis| inverse(self.whole[axis]).apply(height[axis], reduced[axis]));
        Ray { origin: DVec3::new(x[0], y[0], 0.0), direction: DVec3::new(-x[1], -y[1], -1.0).normalize() }
    }

    /// The ray before the film, its origin in the last vertex plane, of a ray from the scene.
    pub fn from_scene(&self, ray: &Ray) -> Ray {
        let slopes = ray.direction.truncate() / ray.direction.z;
        let height = ray.origin.truncate() - slopes * ray.origin.z;
        let [x, y] = [0, 1].map(|axis| self.whole[axis].apply(height[axis], slopes[axis]));
        let after = DVec3::new(x[1], y[1], self.image_index) / self.image_index;
        Ray { origin: DVec3::new(x[0], y[0], self.last_z), direction: after.normalize() * self.image_index.signum() }
    }
}

/// The inverse of a matrix whose determinant is 1.
fn inverse(m: Matrix) -> Matrix {
    Matrix { a: m.d, b: -m.b, c: -m.c, d: m.a }
}
