//! Forbes's aspheres of slope-orthogonal (Qbfs) and conic-based (Qcon) polynomials, as powers of the distance from the axis.
//!
//! With u = r / r_max and x = u² the sags beside the base are (Forbes, *Shape specification for axially symmetric optical surfaces*,
//! Optics Express 15, 5218, 2007):
//!
//! - Qcon: u⁴ Σ aₘ Pₘ⁽⁰,⁴⁾(2 x − 1), P the Jacobi polynomials (equation 4), which is a polynomial.
//! - Qbfs: x (1 − x) / cos φ Σ aₘ Qₘ(x) (equation 12), φ the slope of the base. Forbes's base is a sphere, 1/cos φ = 1 / √(1 − c² r²); on
//!   a conicoid, as OpticStudio has it, 1/cos φ = √((1 − k c² r²) / (1 − (1 + k) c² r²)). That factor is no polynomial: it is interpolated.

use std::f64::consts::PI;

use crate::surface::{Conic, LAST_POWER};

/// A fit that misses the sag by more than this is none, mm: a nanometre.
const WORST_FIT_MM: f64 = 1e-6;

/// A polynomial asphere: pairs of a power of the distance from the axis and its coefficient in mm^(1 − power).
pub(super) type Terms = Vec<(u32, f64)>;

/// The asphere of Qcon polynomials with coefficients in mm, normalized to a radius.
pub(super) fn conic_based(coefficients_mm: &[f64], radius_mm: f64) -> Terms {
    let mut sum = vec![0.0; coefficients_mm.len()];
    // Jacobi polynomials in x by their recurrence (DLMF 18.9.2), α = 0, β = 4, the argument 2 x − 1.
    let (mut before, mut here) = (vec![0.0], vec![1.0]);
    for (m, a) in coefficients_mm.iter().enumerate() {
        add(&mut sum, &here, *a);
        let n = (m + 1) as f64;
        let whole = 2.0 * n + 4.0;
        let scale = 2.0 * n * (n + 4.0) * (whole - 2.0);
        let slope = (whole - 1.0) * whole * (whole - 2.0) / scale;
        let constant = -(whole - 1.0) * 16.0 / scale;
        let last = 2.0 * (n - 1.0) * (n + 3.0) * whole / scale;
        let mut next = times_linear(&here, constant - slope, 2.0 * slope);
        add(&mut next, &before, -last);
        (before, here) = (here, next);
    }
    powers(&sum, 4, radius_mm)
}

/// The asphere of Qbfs polynomials with coefficients in mm, normalized to a radius, on a base, out to a clear radius; and by how much its
/// sag misses Forbes's, mm. `None` if the base ends before the clear radius or powers up to r²⁰ do not follow the sag.
pub(super) fn slope_orthogonal(
    coefficients_mm: &[f64],
    radius_mm: f64,
    base: Conic,
    clear_mm: f64,
) -> Option<(Terms, f64)> {
    let sum = best_fit_sum(coefficients_mm);
    let squared = (base.curvature * radius_mm).powi(2);
    let factor = |x: f64| ((1.0 - base.conic * squared * x) / (1.0 - (1.0 + base.conic) * squared * x)).sqrt();
    let widest = (clear_mm / radius_mm).powi(2);
    // Divided by x.
    let sag = |x: f64| (1.0 - x) * factor(x) * value(&sum, x);
    let count = (LAST_POWER / 2) as usize;
    let fit = interpolate(sag, widest, count);
    let misses = |i: usize| {
        let x = widest * i as f64 / 200.0;
        (x * (value(&fit, x) - sag(x))).abs()
    };
    let miss_mm = (0..=200).map(misses).fold(0.0, f64::max);
    // Not a number where the base has ended.
    ((0..=200).all(|i| misses(i) <= WORST_FIT_MM)).then(|| (powers(&fit, 2, radius_mm), miss_mm))
}

/// Σ aₘ Qₘ(x) as a polynomial in x (Forbes 2007, appendix A: the recurrence of Qbfs with its auxiliary f, g and h).
fn best_fit_sum(coefficients: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; coefficients.len().max(1)];
    let mut f = vec![2.0, 0.5 * 19f64.sqrt()];
    let mut g = vec![-0.5];
    let mut orthogonal = [vec![2.0], vec![6.0, -8.0]];
    let mut slopes: Vec<Vec<f64>> = vec![vec![1.0], vec![13.0 / 19f64.sqrt(), -16.0 / 19f64.sqrt()]];
    for m in 2..coefficients.len() {
        let order = m as f64;
        let h = -order * (order - 1.0) / (2.0 * f[m - 2]);
        g.push(-(1.0 + g[m - 2] * h) / f[m - 1]);
        f.push((order * (order + 1.0) + 3.0 - g[m - 1].powi(2) - h * h).sqrt());
        let mut next = times_linear(&orthogonal[1], 2.0, -4.0);
        add(&mut next, &orthogonal[0], -1.0);
        let mut slope = next.clone();
        add(&mut slope, &slopes[m - 1], -g[m - 1]);
        add(&mut slope, &slopes[m - 2], -h);
        slope.iter_mut().for_each(|a| *a /= f[m]);
        slopes.push(slope);
        orthogonal = [std::mem::take(&mut orthogonal[1]), next];
    }
    for (a, slope) in coefficients.iter().zip(&slopes) {
        add(&mut sum, slope, *a);
    }
    sum
}

/// The polynomial in x of `count` coefficients that agrees with a function at the Chebyshev points of 0 to `end`.
fn interpolate(of: impl Fn(f64) -> f64, end: f64, count: usize) -> Vec<f64> {
    let angle = |i: usize| PI * (i as f64 + 0.5) / count as f64;
    let values: Vec<f64> = (0..count).map(|i| of(end * 0.5 * (1.0 + angle(i).cos()))).collect();
    let mut sum = vec![0.0; count];
    // Chebyshev polynomials of t = 2 x / end − 1.
    let (mut before, mut here) = (vec![-1.0, 2.0 / end], vec![1.0]);
    for order in 0..count {
        let part: f64 = values.iter().enumerate().map(|(i, value)| value * (order as f64 * angle(i)).cos()).sum();
        let weight = if order == 0 { 1.0 } else { 2.0 } / count as f64;
        add(&mut sum, &here, weight * part);
        let next = match order {
            0 => before.clone(),
            _ => {
                let mut next = times_linear(&here, -2.0, 4.0 / end);
                add(&mut next, &before, -1.0);
                next
            }
        };
        (before, here) = (here, next);
    }
    sum
}

/// Adds a multiple of a polynomial; terms beyond the length of the sum are those of polynomials that it does not have.
fn add(sum: &mut Vec<f64>, polynomial: &[f64], factor: f64) {
    if sum.len() < polynomial.len() {
        sum.resize(polynomial.len(), 0.0);
    }
    for (sum, a) in sum.iter_mut().zip(polynomial) {
        *sum += factor * a;
    }
}

/// A polynomial times (constant + slope x).
fn times_linear(polynomial: &[f64], constant: f64, slope: f64) -> Vec<f64> {
    let mut product = vec![0.0; polynomial.len() + 1];
    for (i, a) in polynomial.iter().enumerate() {
        product[i] += constant * a;
        product[i + 1] += slope * a;
    }
    product
}

fn value(polynomial: &[f64], x: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, a| sum * x + a)
}

/// The terms of u^first times a polynomial in u², u = r / radius.
fn powers(polynomial: &[f64], first: u32, radius_mm: f64) -> Terms {
    let power = |i: usize| first + 2 * i as u32;
    polynomial.iter().enumerate().map(|(i, a)| (power(i), a / radius_mm.powi(power(i) as i32))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sag(terms: &Terms, r: f64) -> f64 {
        terms.iter().map(|(power, a)| a * r.powi(*power as i32)).sum()
    }

    /// The first polynomials as Forbes prints them (2007, equations 5 and 13).
    #[test]
    fn polynomials_are_those_of_the_paper() {
        let (radius_mm, u) = (8.0, 0.7f64);
        let x = u * u;
        let one = |m: usize| (0..=m).map(|i| if i == m { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
        let printed = [
            1.0,
            -(5.0 - 6.0 * x),
            15.0 - 14.0 * x * (3.0 - 2.0 * x),
            -(35.0 - 12.0 * x * (14.0 - x * (21.0 - 10.0 * x))),
        ];
        for (m, q) in printed.iter().enumerate() {
            let found = sag(&conic_based(&one(m), radius_mm), u * radius_mm);
            assert!((found - x * x * q).abs() < 1e-14, "Qcon {m}: {found}");
        }
        let printed = [
            1.0,
            (13.0 - 16.0 * x) / 19f64.sqrt(),
            (2.0f64 / 95.0).sqrt() * (29.0 - 4.0 * x * (25.0 - 19.0 * x)),
            (2.0f64 / 2545.0).sqrt() * (207.0 - 4.0 * x * (315.0 - x * (577.0 - 320.0 * x))),
        ];
        for (m, q) in printed.iter().enumerate() {
            let found = value(&best_fit_sum(&one(m)), x);
            assert!((found - q).abs() < 1e-13, "Qbfs {m}: {found} for {q}");
        }
    }

    #[test]
    fn a_base_that_ends_has_no_terms() {
        let base = Conic { curvature: 0.05, conic: 0.0 };
        assert!(slope_orthogonal(&[0.1], 25.0, base, 21.0).is_none());
        let (terms, miss_mm) = slope_orthogonal(&[0.1, -0.02], 25.0, base, 10.0).unwrap();
        let (r, x) = (9.0f64, (9.0f64 / 25.0).powi(2));
        let expected =
            x * (1.0 - x) * (0.1 - 0.02 * (13.0 - 16.0 * x) / 19f64.sqrt()) / (1.0 - (0.05 * r).powi(2)).sqrt();
        assert!((sag(&terms, r) - expected).abs() <= miss_mm.max(1e-15) && miss_mm < 1e-8, "{miss_mm}");
    }
}
