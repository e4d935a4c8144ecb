//! Visible facets of Beckmann's distribution of width one: their area, and samples of their slopes.
//!
//! Slopes are Gaussian: their sums are error functions.

use glam::Vec3A;
use std::f32::consts::FRAC_2_SQRT_PI;

const INVERSE_SQRT_PI: f32 = 0.5 * FRAC_2_SQRT_PI;
/// Sines below which a direction counts as that of the normal: the projected area of a facet does not depend on its slope.
const STRAIGHT: f32 = 1e-6;
/// Newton's steps at most; three are the rule.
const MOST_STEPS: usize = 12;
/// Error of the cumulative distribution at which they end.
const CLOSE: f32 = 3e-7;

/// Area of the facets visible from `w`, projected along `w`, over that of the surface: cos θ (1 + Λ) with the exact Λ of Smith's masking
/// (Walter et al. 2007, eq. 26). z > 0; for a `w` that is not of unit length, times its length.
pub(super) fn visible_area(w: Vec3A) -> f32 {
    let sin = (w.x * w.x + w.y * w.y).sqrt();
    if sin < STRAIGHT * w.z {
        return w.z;
    }
    let cot = w.z / sin;
    0.5 * (w.z * (1.0 + libm::erff(cot)) + sin * INVERSE_SQRT_PI * (-cot * cot).exp())
}

/// The slopes dz/dx and dz/dy of a facet visible from the unit direction `w`, z > 0, with a density in proportion to the facet's area
/// projected along `w`.
///
/// The slope towards `w` is found where its cumulative distribution is `u[0]`, by Newton's method in erf(slope), where that is nearly
/// straight: neighbouring numbers give neighbouring facets (Jakob 2014, "An Improved Visible Normal Sampling Routine for the Beckmann
/// Distribution").
pub(super) fn sample_slopes(w: Vec3A, u: [f32; 2]) -> [f32; 2] {
    let sin = (w.x * w.x + w.y * w.y).sqrt();
    let across = inverse_erf(2.0 * u[1] - 1.0);
    if sin < STRAIGHT {
        return [inverse_erf(2.0 * u[0] - 1.0), across];
    }
    let (tan, cot) = (sin / w.z, w.z / sin);
    // Facets of steeper slopes face away from `w`.
    let most = libm::erff(cot);
    let area = |x: f32, slope: f32| 1.0 + x + INVERSE_SQRT_PI * tan * (-slope * slope).exp();
    let wanted = u[0] * area(most, cot);
    let (mut low, mut high) = (-1.0, most);
    // A first guess: as if all facets that face `w` had the same projected area.
    let mut x = most - (most + 1.0) * libm::erff((-u[0].max(1e-12).ln()).max(0.0).sqrt());
    let mut slope = inverse_erf(x);
    for _ in 0..MOST_STEPS {
        let beyond = area(x, slope) - wanted;
        if beyond.abs() < CLOSE * (1.0 + tan) {
            break;
        }
        if beyond > 0.0 {
            high = x
        } else {
            low = x
        }
        let next = x - beyond / (1.0 - slope * tan);
        // A step that leaves the interval, or that is not a number, halves it.
        x = if next > low && next < high { next } else { 0.5 * (low + high) };
        slope = inverse_erf(x);
    }
    [(w.x * slope - w.y * across) / sin, (w.y * slope + w.x * across) / sin]
}

/// The inverse of the error function, to a few roundings (Giles 2010, "Approximating the erfinv function"); finite for all of [-1, 1].
fn inverse_erf(x: f32) -> f32 {
    const MIDDLE: [f32; 9] = [
        2.810_226_4e-8,
        3.432_739_4e-7,
        -3.523_387_7e-6,
        -4.391_506_5e-6,
        2.185_808_7e-4,
        -1.253_725e-3,
        -4.177_681_6e-3,
        0.246_640_73,
        1.501_409_4,
    ];
    const TAILS: [f32; 9] = [
        -2.002_142_6e-4,
        1.009_505_6e-4,
        1.349_343_2e-3,
        -3.673_428_4e-3,
        5.739_507_7e-3,
        -7.622_461_3e-3,
        9.438_870_5e-3,
        1.001_674,
        2.832_976_8,
    ];
    let x = x.clamp(-1.0 + f32::EPSILON / 2.0, 1.0 - f32::EPSILON / 2.0);
    let w = -((1.0 - x) * (1.0 + x)).ln();
    let (w, terms) = if w < 5.0 { (w - 2.5, MIDDLE) } else { (w.sqrt() - 3.0, TAILS) };
    x * terms.into_iter().fold(0.0, |sum, term| sum * w + term)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_inverse_is_that_of_the_error_function() {
        for i in -999..1000 {
            let x = i as f32 / 1000.0;
            assert!((libm::erff(inverse_erf(x)) - x).abs() < 3e-7, "{x}");
        }
        for x in [-1.0f32, 1.0] {
            assert!(inverse_erf(x).is_finite() && inverse_erf(x).abs() > 3.5);
        }
    }

    /// The projected areas of the facets that face a direction, summed over slopes.
    fn counted(w: Vec3A) -> f64 {
        let (n, reach) = (2000, 5.0);
        let step = 2.0 * reach / f64::from(n);
        let mut sum = 0.0;
        for i in 0..n {
            // Slopes across do not matter to the area, and their density integrates to one.
            let slope = (f64::from(i) + 0.5) * step - reach;
            let area = f64::from(w.z) - slope * f64::from(w.x);
            sum += area.max(0.0) * (-slope * slope).exp() / PI.sqrt() * step;
        }
        sum
    }

    #[test]
    fn areas_are_those_of_the_facets() {
        for degrees in [0.0f32, 1.0, 30.0, 60.0, 80.0, 89.0, 89.99] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let w = Vec3A::new(sin, 0.0, cos);
            assert!(
                (f64::from(visible_area(w)) / counted(w) - 1.0).abs() < 2e-5,
                "{degrees}: {} {}",
                visible_area(w),
                counted(w)
            );
        }
    }

    /// The cumulative distribution at each sample is the number that it was made of, by a sum over slopes.
    #[test]
    fn slopes_are_where_the_distribution_is_the_number() {
        for degrees in [0.0f32, 20.0, 60.0, 85.0, 89.9] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let w = Vec3A::new(sin, 0.0, cos);
            let all = counted(w);
            for i in 0..20 {
                let u = (i as f32 + 0.5) / 20.0;
                let [slope, across] = sample_slopes(w, [u, 0.5]);
                assert!(across.abs() < 1e-6);
                let (n, low) = (20_000, -5.0);
                let step = (f64::from(slope) - low) / f64::from(n);
                let part: f64 = (0..n)
                    .map(|k| {
                        let at = low + (f64::from(k) + 0.5) * step;
                        let area = f64::from(cos) - at * f64::from(sin);
                        area.max(0.0) * (-at * at).exp() / PI.sqrt() * step
                    })
                    .sum();
                assert!((part / all - f64::from(u)).abs() < 3e-5, "{degrees} {u}: {}", part / all);
            }
        }
    }

    #[test]
    fn all_numbers_give_visible_facets() {
        for degrees in [0.0f32, 1e-4, 45.0, 89.0, 89.999] {
            for phi in [0.0f32, 2.0, 4.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let w = Vec3A::new(sin * phi.cos(), sin * phi.sin(), cos);
                for i in 0..=100 {
                    for v in [0.0, 0.3, 1.0 - f32::EPSILON] {
                        let [x, y] = sample_slopes(w, [(i as f32 / 100.0).min(1.0 - f32::EPSILON), v]);
                        assert!(x.is_finite() && y.is_finite());
                        // Up to rounding at the last of them.
                        assert!(w.z - x * w.x - y * w.y > -1e-5, "{degrees} {phi} {i} {v}");
                    }
                }
            }
        }
    }
}
