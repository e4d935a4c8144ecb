//! Vignetting models of lensfun.

use super::Sensor;

/// The formula of vignetting and its terms k₁ to k₃: light = 1 + k₁ r² + k₂ r⁴ + k₃ r⁶.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VignettingModel {
    /// Radii in halves of the sensor's diagonal (Pablo d'Angelo's model).
    Pa([f64; 3]),
    /// Radii in focal lengths (Adobe's camera model).
    Adobe([f64; 3]),
}

impl VignettingModel {
    /// k₁ to k₃.
    pub fn terms(&self) -> &[f64; 3] {
        match self {
            Self::Pa(terms) | Self::Adobe(terms) => terms,
        }
    }

    /// This model with other terms.
    pub(super) fn with_terms(&self, terms: [f64; 3]) -> Self {
        match self {
            Self::Pa(_) => Self::Pa(terms),
            Self::Adobe(_) => Self::Adobe(terms),
        }
    }

    /// The power of the focal length that the interpolation multiplies a term by (`__parameter_scales` in lensfun's `lens.cpp`).
    pub(super) fn scale_power(&self, term: usize) -> f64 {
        match self {
            Self::Pa(_) => 0.0,
            Self::Adobe(_) => -2.0 * (term as f64 + 1.0),
        }
    }
}

/// Vignetting of a lens at a focal length, an f-number and a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vignetting {
    /// The formula, as the database has it.
    pub model: VignettingModel,
    /// The focal length by the measurement of distortion, mm; Adobe's radii count in it.
    pub real_focal_mm: f64,
    /// The sensor of the calibration.
    pub sensor: Sensor,
    /// The distance of the nearest measurement, in lensfun's measure: 0 at a measurement, 1 from one end of the zoom to the other, or
    /// from f/4 to f/2.
    pub apart: f64,
}

impl Vignetting {
    /// Light at this distance from the middle of the film, over that in the middle; `None` where the formula leaves none, which is beyond
    /// the measurement.
    pub fn illumination(&self, radius_mm: f64) -> Option<f64> {
        let unit_mm = match self.model {
            VignettingModel::Pa(_) => self.sensor.half_diagonal_mm(),
            VignettingModel::Adobe(_) => self.real_focal_mm,
        };
        let [k1, k2, k3] = *self.model.terms();
        let r2 = (radius_mm / unit_mm).powi(2);
        let light = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        (light > 0.0).then_some(light)
    }
}
