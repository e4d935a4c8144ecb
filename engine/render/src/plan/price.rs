//! What a sample of a camera costs, by kind of camera and by lens: so that of two ways to the same picture the cheaper is
//! taken, and the price of an effect is known before it is paid.
//!
//! Times are nanoseconds on the machine of docs/accuracy-cost.md, one thread; their ratios hold elsewhere. They are constants,
//! so that the same scene has the same plan on every machine and at every load.

use crate::camera::survey::LensShape;

/// How a camera makes its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Price {
    /// Every ray through one point.
    Pinhole,
    /// By Gaussian optics.
    Gaussian,
    /// Every ray through every surface, in f32 or f64.
    Exact {
        /// f32.
        is_single: bool,
        /// Wavelengths that a path carries.
        carried: usize,
    },
}

/// Without what every sample costs, whatever the camera.
const PINHOLE_NS: f64 = 4.0;
const GAUSSIAN_NS: f64 = 90.0;
/// Choosing a point of the pupil, and into the scene.
const AIM_NS: f64 = 14.0;
/// A ray through a sphere or plane, in lanes of f32 and of f64.
const SURFACE_NS: [f64; 2] = [1.1, 2.2];
/// The same through an asphere: Newton's steps.
const ASPHERE_NS: [f64; 2] = [9.0, 18.0];
/// Where a wavelength that did not lead arrives, what density it would have led with, and its light on the film.
const ARRIVAL_NS: f64 = 22.0;

/// Nanoseconds that a sample takes in the camera.
pub(super) fn sample_ns(price: Price, lens: LensShape) -> f64 {
    match price {
        Price::Pinhole => PINHOLE_NS,
        Price::Gaussian => GAUSSIAN_NS,
        Price::Exact { is_single, carried } => {
            let through = |kind: usize| lens.plain as f64 * SURFACE_NS[kind] + lens.aspheres as f64 * ASPHERE_NS[kind];
            let out = AIM_NS + through(usize::from(!is_single));
            // The way back is in f32 for all that is carried, the leader too.
            let back = if carried > 1 { carried as f64 * (through(0) + ARRIVAL_NS) } else { 0.0 };
            out + back
        }
    }
}
