//! The cost of a sample of a camera, by kind of camera and by lens: so that of two ways to the same picture the cheaper is taken, and the
//! price of an effect is known before it is paid.
//!
//! Times are nanoseconds on the machine of docs/accuracy-cost.md, one thread; their ratios hold elsewhere. They are constants,
//! so that the same scene has the same plan on every machine and at every load.

use crate::camera::tools::survey::LensShape;
use crate::stray::ghosts::Glimpse;

/// The way in which a camera makes its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Price {
    /// Every ray through one point.
    Pinhole,
    /// Rays by Gaussian optics.
    Gaussian,
    /// Every ray through every surface, in f32 or f64.
    Exact {
        /// True for f32, false for f64.
        is_single: bool,
        /// Wavelengths that a path carries.
        carried: usize,
    },
}

/// Costs of a sample of simple cameras, without the part that every camera has.
const PINHOLE_NS: f64 = 4.0;
const GAUSSIAN_NS: f64 = 90.0;
/// Choosing a point of the pupil, and into the scene.
const AIM_NS: f64 = 14.0;
/// A ray through a sphere or plane, in lanes of f32 and of f64.
const SURFACE_NS: [f64; 2] = [1.1, 2.2];
/// A ray through an asphere, by Newton's steps, in lanes of f32 and of f64.
const ASPHERE_NS: [f64; 2] = [9.0, 18.0];
/// The arrival of a wavelength that did not lead, the density with which it would have led, and its light on the film.
const ARRIVAL_NS: f64 = 22.0;

/// Looking for a path's ghost of a source.
const GHOST_LOOK_S: f64 = 1.5e-4;
/// Tracing a ghost and laying it on a picture of so many pixels.
const GHOST_S: f64 = 5e-3;
const GHOST_PX: f64 = 4e5;

/// Seconds that all ghosts of so many sources take in a picture of so many pixels, by a look at some of them.
pub(super) fn ghosts_s(sources: usize, look: &Glimpse, pixels: f64) -> f64 {
    let per_source = look.simulated as f64 / look.sources.max(1) as f64;
    let traced = per_source * GHOST_S * (0.5 + 0.5 * pixels / GHOST_PX);
    sources as f64 * (look.paths as f64 * GHOST_LOOK_S + traced)
}

/// Cost of a pixel of the finished picture, with one kernel for all of it, in two transforms of a picture six times as large.
const DIFFRACTION_NS: f64 = 1_200.0;
const GLARE_NS: f64 = 700.0;

/// Seconds that diffraction takes of a finished picture of so many pixels.
pub(super) fn diffraction_s(pixels: f64) -> f64 {
    1e-9 * DIFFRACTION_NS * pixels
}

/// Seconds that glare takes of a finished picture of so many pixels.
pub(super) fn glare_s(pixels: f64) -> f64 {
    1e-9 * GLARE_NS * pixels
}

/// The lens's transmission along a ray, and for each wavelength that a path carries: a polynomial of some ten terms.
const TRANSMISSION_NS: [f64; 2] = [25.0, 14.0];

/// Nanoseconds more where surfaces and glasses take their part.
pub(super) fn transmission_ns(price: Price) -> f64 {
    let [alone, each] = TRANSMISSION_NS;
    match price {
        Price::Exact { carried, .. } if carried > 1 => alone + each * carried as f64,
        Price::Exact { .. } => alone,
        Price::Pinhole | Price::Gaussian => 0.0,
    }
}

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
