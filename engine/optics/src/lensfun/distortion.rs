//! Distortion models of lensfun, on points of the film.

use glam::DVec2;

use super::Sensor;

/// The formula of a distortion and its terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DistortionModel {
    /// r' = r (1 − k₁ + k₁ r²).
    Poly3([f64; 1]),
    /// r' = r (1 + k₁ r² + k₂ r⁴).
    Poly5([f64; 2]),
    /// r' = r (a r³ + b r² + c r + 1 − a − b − c); terms a, b, c.
    PtLens([f64; 3]),
    /// Adobe's camera model: three radial terms k₁ to k₃ and two tangential ones k₄ (y) and k₅ (x), radii in focal lengths.
    Adobe([f64; 5]),
}

impl DistortionModel {
    /// The terms that belong to powers of the field, by which lensfun interpolates them.
    pub(super) fn terms(&self) -> &[f64] {
        match self {
            Self::Poly3(terms) => terms,
            Self::Poly5(terms) => terms,
            Self::PtLens(terms) => terms,
            Self::Adobe(terms) => terms,
        }
    }

    /// This model with other terms; as many as it has.
    pub(super) fn with_terms(&self, of: impl Fn(usize) -> f64) -> Self {
        match self {
            Self::Poly3(_) => Self::Poly3(std::array::from_fn(of)),
            Self::Poly5(_) => Self::Poly5(std::array::from_fn(of)),
            Self::PtLens(_) => Self::PtLens(std::array::from_fn(of)),
            Self::Adobe(_) => Self::Adobe(std::array::from_fn(of)),
        }
    }

    /// The power of the focal length that the interpolation multiplies a term by (`__parameter_scales` in lensfun's `lens.cpp`).
    pub(super) fn scale_power(&self, term: usize) -> f64 {
        match self {
            Self::Adobe(_) if term < 3 => 1.0 - 2.0 * (term as f64 + 1.0),
            Self::Adobe(_) => 0.0,
            _ => 1.0,
        }
    }

    /// Scale on the axis of the formula as it is measured: the scale of the distorted picture over that of the straight one.
    pub fn central_scale(&self) -> f64 {
        match *self {
            Self::Poly3([k1]) => 1.0 - k1,
            Self::PtLens([a, b, c]) => 1.0 - a - b - c,
            Self::Poly5(_) | Self::Adobe(_) => 1.0,
        }
    }
}

/// Distortion of a lens at a focal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distortion {
    /// The formula, as the database has it.
    pub model: DistortionModel,
    /// The focal length that the lens is marked with at this setting, mm.
    pub focal_mm: f64,
    /// The focal length by the measurement, mm: scale of the picture on the axis.
    pub real_focal_mm: f64,
    /// The sensor of the calibration; beyond its half diagonal the formula goes on unmeasured.
    pub sensor: Sensor,
}

/// Steps of the search for the radius at which a distortion folds back.
const STEPS: usize = 512;
/// The largest radius that is looked at, in half diagonals of the calibration's sensor.
const FARTHEST: f64 = 4.0;
/// Steps of Newton's method for the inverse: a bracket holds it, so each is at least a bisection.
const MOST_NEWTON: usize = 200;

impl Distortion {
    /// Coefficients of r, r², …, r⁵ of the distorted radius, mm, by the straight one, mm; the first is 1. Tangential terms are apart.
    fn radial(&self) -> [f64; 5] {
        let unit = self.sensor.half_short_side_mm();
        let d = self.model.central_scale();
        match self.model {
            DistortionModel::Poly3([k1]) => [1.0, 0.0, k1 / (d.powi(3) * unit.powi(2)), 0.0, 0.0],
            DistortionModel::Poly5([k1, k2]) => [1.0, 0.0, k1 / unit.powi(2), 0.0, k2 / unit.powi(4)],
            DistortionModel::PtLens([a, b, c]) => {
                [1.0, c / (d.powi(2) * unit), b / (d.powi(3) * unit.powi(2)), a / (d.powi(4) * unit.powi(3)), 0.0]
            }
            // The sixth power of the radius stands apart, in `distorted_mm`.
            DistortionModel::Adobe([k1, k2, ..]) => {
                let f = self.real_focal_mm;
                [1.0, 0.0, k1 / f.powi(2), 0.0, k2 / f.powi(4)]
            }
        }
    }

    /// The term of r⁷, mm^−6.
    fn seventh(&self) -> f64 {
        match self.model {
            DistortionModel::Adobe([_, _, k3, ..]) => k3 / self.real_focal_mm.powi(6),
            _ => 0.0,
        }
    }

    /// The formula with lengths in the focal length of the measurement: coefficients of r² to r⁷ of the distorted radius by the straight one, that
    /// of r being 1, and the tangential terms `p1`, `p2` of `x += 2 p1 x y + p2 (r² + 2 x²)`, `y += p1 (r² + 2 y²) + 2 p2 x y`.
    pub fn in_focal_lengths(&self) -> ([f64; 6], [f64; 2]) {
        let f = self.real_focal_mm;
        let [_, c2, c3, c4, c5] = self.radial();
        let radial = [c2 * f, c3 * f.powi(2), c4 * f.powi(3), c5 * f.powi(4), 0.0, self.seventh() * f.powi(6)];
        let tangential = match self.model {
            DistortionModel::Adobe([.., k4, k5]) => [k4, k5],
            _ => [0.0; 2],
        };
        (radial, tangential)
    }

    /// Distorted radius by the straight one, both mm, without tangential terms, and its derivative.
    pub fn radius_mm(&self, straight_mm: f64) -> (f64, f64) {
        let r = straight_mm;
        let [c1, c2, c3, c4, c5] = self.radial();
        let c7 = self.seventh();
        let value = r * (c1 + r * (c2 + r * (c3 + r * (c4 + r * (c5 + r * r * c7)))));
        let slope = c1 + r * (2.0 * c2 + r * (3.0 * c3 + r * (4.0 * c4 + r * (5.0 * c5 + r * r * 7.0 * c7))));
        (value, slope)
    }

    /// The place of a point of the straight picture in the real one, mm.
    pub fn distorted_mm(&self, straight_mm: DVec2) -> DVec2 {
        let r = straight_mm.length();
        if r == 0.0 {
            return DVec2::ZERO;
        }
        let around = straight_mm * (self.radius_mm(r).0 / r);
        match self.model {
            DistortionModel::Adobe([_, _, _, k4, k5]) => {
                let f = self.real_focal_mm;
                let DVec2 { x, y } = straight_mm;
                around + (straight_mm * (2.0 * (k4 * y + k5 * x)) + DVec2::new(k5, k4) * (r * r)) / f
            }
            _ => around,
        }
    }

    /// The radius of the straight picture at which the real one turns back on itself, mm: beyond, two fields would share a place. Infinite
    /// where it does not.
    pub fn turning_mm(&self) -> f64 {
        let end = FARTHEST * self.sensor.half_diagonal_mm();
        let step = end / STEPS as f64;
        let slope = |r: f64| self.radius_mm(r).1;
        let Some(i) = (1..=STEPS).find(|&i| !(slope(step * i as f64) > 0.0)) else { return f64::INFINITY };
        let (mut low, mut high) = (step * (i - 1) as f64, step * i as f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if slope(middle) > 0.0 { low = middle } else { high = middle }
        }
        low
    }

    /// The place of a point of the real picture in the straight one, mm; `None`: no field comes there, or only such as lie beyond
    /// [`Distortion::turning_mm`] or four half diagonals of the calibration's sensor.
    pub fn straight_mm(&self, distorted_mm: DVec2) -> Option<DVec2> {
        let target = distorted_mm.length();
        if target == 0.0 {
            return Some(DVec2::ZERO);
        }
        let radius = self.straight_radius_mm(target)?;
        let start = distorted_mm * (radius / target);
        match self.model {
            DistortionModel::Adobe([.., k4, k5]) if k4 != 0.0 || k5 != 0.0 => self.straight_beside(distorted_mm, start),
            _ => Some(start),
        }
    }

    /// The straight radius of a distorted one, both mm, without tangential terms.
    fn straight_radius_mm(&self, target_mm: f64) -> Option<f64> {
        let (mut low, mut high) = (0.0, self.turning_mm().min(FARTHEST * self.sensor.half_diagonal_mm()));
        if !(self.radius_mm(high).0 >= target_mm) {
            return None;
        }
        let mut r = target_mm.min(high);
        for _ in 0..MOST_NEWTON {
            let (value, slope) = self.radius_mm(r);
            let error = value - target_mm;
            if error > 0.0 {
                high = r
            } else {
                low = r
            }
            let next = r - error / slope;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            // The last bits go back and forth.
            if (next - r).abs() <= 2.0 * f64::EPSILON * r {
                return Some(next);
            }
            r = next;
        }
        Some(r)
    }

    /// The inverse with tangential terms: they add little, so that this is subtracted again and again.
    fn straight_beside(&self, distorted_mm: DVec2, start: DVec2) -> Option<DVec2> {
        let mut at = start;
        for _ in 0..MOST_NEWTON {
            let error = distorted_mm - self.distorted_mm(at);
            if error.length() <= 4.0 * f64::EPSILON * distorted_mm.length() {
                return Some(at);
            }
            at += error / self.radius_mm(at.length()).1.max(0.1);
        }
        ((self.distorted_mm(at) - distorted_mm).length() < 1e-9).then_some(at)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::{Distortion, DistortionModel};
    use crate::lensfun::Sensor;

    fn distortion(model: DistortionModel) -> Distortion {
        let sensor = Sensor { crop_factor: 1.5, aspect_ratio: 1.5 };
        Distortion { model, focal_mm: 35.0, real_focal_mm: 34.5, sensor }
    }

    #[test]
    fn the_inverse_comes_back() {
        let models = [
            DistortionModel::Poly3([-0.02]),
            DistortionModel::Poly5([0.03, -0.004]),
            DistortionModel::PtLens([0.02, -0.06, 0.05]),
            DistortionModel::Adobe([-0.1, 0.05, -0.02, 1e-3, -2e-3]),
        ];
        for model in models {
            let distortion = distortion(model);
            for at in [DVec2::ZERO, DVec2::new(1e-9, 0.0), DVec2::new(-3.0, 4.0), DVec2::new(11.0, 7.0)] {
                let back = distortion.straight_mm(distortion.distorted_mm(at)).unwrap();
                assert!((back - at).length() < 1e-12, "{model:?} {at} {back}");
            }
        }
    }

    /// r − r³ / 3 in halves of the short side turns at r = 1 there, and comes to 2/3.
    #[test]
    fn a_picture_that_turns_back_ends() {
        let distortion = distortion(DistortionModel::Poly5([-1.0 / 3.0, 0.0]));
        let unit = distortion.sensor.half_short_side_mm();
        assert!((distortion.turning_mm() - unit).abs() < 1e-9, "{} {unit}", distortion.turning_mm());
        assert!(distortion.straight_mm(DVec2::new(0.66 * unit, 0.0)).is_some());
        assert_eq!(distortion.straight_mm(DVec2::new(0.67 * unit, 0.0)), None);
    }
}
