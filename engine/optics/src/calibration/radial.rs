//! Distortions that depend on the distance from the middle alone.

use glam::{DMat2, DVec2};

/// Even powers that a polynomial may have beyond the first power.
pub(super) const EVEN_POWERS: usize = 6;
/// Highest power of a polynomial of all powers.
pub(super) const HIGHEST_POWER: usize = 8;
/// The angle below which the model of Devernay and Faugeras is a pinhole's, to double precision.
const SMALLEST_OMEGA: f64 = 1e-7;

/// A function of the distance from the middle, zero there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Radial {
    /// The distance itself.
    Identity,
    /// `r (1 + k1 r^2 + k2 r^4 + ...)`.
    Even([f64; EVEN_POWERS]),
    /// `r (1 + n1 r^2 + n2 r^4 + n3 r^6) / (1 + d1 r^2 + d2 r^4 + d3 r^6)`.
    Rational([f64; 3], [f64; 3]),
    /// `c1 r + c2 r^2 + ...`.
    Powers([f64; HIGHEST_POWER]),
    /// `atan(2 r tan(omega / 2)) / omega` (Devernay and Faugeras 2001, eq. 13).
    Fov(f64),
}

/// `1 + c1 x + c2 x^2 + ...` and its derivative.
fn one_and_powers(coefficients: &[f64], x: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for c in coefficients.iter().rev() {
        slope = slope * x + value;
        value = value * x + c;
    }
    (1.0 + value * x, value + slope * x)
}

impl Radial {
    /// Value over distance, and slope, at a distance from the middle. Where a denominator is not positive there is no value: the slope is
    /// minus infinity there, so that the range of the function ends.
    pub(super) fn at(&self, r: f64) -> (f64, f64) {
        let r2 = r * r;
        match self {
            Self::Identity => (1.0, 1.0),
            Self::Even(k) => {
                let (ratio, by_r2) = one_and_powers(k, r2);
                (ratio, ratio + 2.0 * r2 * by_r2)
            }
            Self::Rational(n, d) => {
                let (n, n_slope) = one_and_powers(n, r2);
                let (d, d_slope) = one_and_powers(d, r2);
                if !(d > 0.0) {
                    return (0.0, f64::NEG_INFINITY);
                }
                let ratio = n / d;
                (ratio, ratio + 2.0 * r2 * (n_slope - ratio * d_slope) / d)
            }
            Self::Powers(c) => {
                // c1 + c2 r + ..., and its derivative
                let (ratio, by_r) = one_and_powers(&c[1..], r);
                let ratio = ratio - 1.0 + c[0];
                (ratio, ratio + r * by_r)
            }
            Self::Fov(omega) if omega.abs() < SMALLEST_OMEGA => (1.0, 1.0),
            Self::Fov(omega) => {
                let stretch = 2.0 * (0.5 * omega).tan();
                let x = stretch * r;
                let slope = stretch / (omega * (1.0 + x * x));
                // atan(x) / x = 1 - x^2 / 3 + ...
                let ratio = if x < 1e-4 { stretch / omega * (1.0 - x * x / 3.0) } else { x.atan() / (omega * r) };
                (ratio, slope)
            }
        }
    }

    /// The distorted point, and the derivative.
    pub(super) fn of_point(&self, q: DVec2) -> (DVec2, DMat2) {
        let r = q.length();
        let (ratio, slope) = self.at(r);
        let unit = q.try_normalize().unwrap_or(DVec2::ZERO);
        let along = DMat2::from_cols(unit * unit.x, unit * unit.y);
        (q * ratio, DMat2::from_diagonal(DVec2::splat(ratio)) + along * (slope - ratio))
    }
}
