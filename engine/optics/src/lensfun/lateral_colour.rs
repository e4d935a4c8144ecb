//! Lateral colour models of lensfun (there "TCA"), on points of the film.

use glam::DVec2;

use super::Sensor;

/// The formula of lateral colour: its terms for red and for blue, from green.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LateralColourModel {
    /// r' = k r.
    Linear([f64; 2]),
    /// r' = r (v + c r + b r²); v, c, b, each for red and blue.
    Poly3([[f64; 2]; 3]),
    /// Adobe's camera model: a scale α₀, three radial terms and two tangential ones (y, then x), each for red and blue; radii in focal
    /// lengths.
    Adobe([[f64; 2]; 6]),
}

impl LateralColourModel {
    /// The terms, pair by pair.
    pub(super) fn terms(&self) -> &[[f64; 2]] {
        match self {
            Self::Linear(terms) => std::slice::from_ref(terms),
            Self::Poly3(terms) => terms,
            Self::Adobe(terms) => terms,
        }
    }

    /// This model with other terms; as many as it has.
    pub(super) fn with_terms(&self, of: impl Fn(usize) -> [f64; 2]) -> Self {
        match self {
            Self::Linear(_) => Self::Linear(of(0)),
            Self::Poly3(_) => Self::Poly3(std::array::from_fn(of)),
            Self::Adobe(_) => Self::Adobe(std::array::from_fn(of)),
        }
    }

    /// The power of the focal length that the interpolation multiplies a term by (`__parameter_scales` in lensfun's `lens.cpp`).
    pub(super) fn scale_power(&self, term: usize) -> f64 {
        match self {
            Self::Linear(_) | Self::Poly3(_) if term == 0 => 0.0,
            Self::Linear(_) | Self::Poly3(_) => 1.0,
            Self::Adobe(_) if (1..4).contains(&term) => 1.0 - 2.0 * term as f64,
            Self::Adobe(_) => 0.0,
        }
    }
}

/// A channel of a camera beside green, to which the others refer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    Red,
    /// Blue.
    Blue,
}

/// Steps of the inverse, whose map is within some thousandths of the identity.
const MOST_STEPS: u32 = 50;

/// Lateral colour of a lens at a focal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralColour {
    /// The formula, as the database has it.
    pub model: LateralColourModel,
    /// The focal length that the lens is marked with at this setting, mm.
    pub focal_mm: f64,
    /// The focal length by the measurement of distortion, mm; Adobe's radii count in it.
    pub real_focal_mm: f64,
    /// The sensor of the calibration.
    pub sensor: Sensor,
}

impl LateralColour {
    /// The place in a channel of the light that is at this point in green, both mm in the real picture.
    pub fn place_mm(&self, channel: Channel, green_mm: DVec2) -> DVec2 {
        let i = usize::from(channel == Channel::Blue);
        let r = green_mm.length();
        match self.model {
            LateralColourModel::Linear(k) => green_mm * k[i],
            LateralColourModel::Poly3([v, c, b]) => {
                let r = r / self.sensor.half_short_side_mm();
                green_mm * (v[i] + r * (c[i] + r * b[i]))
            }
            LateralColourModel::Adobe([scale, k1, k2, k3, y_term, x_term]) => {
                let f = self.real_focal_mm;
                let p = green_mm / f;
                let r2 = p.length_squared();
                let common = 1.0 + r2 * (k1[i] + r2 * (k2[i] + r2 * k3[i])) + 2.0 * (y_term[i] * p.y + x_term[i] * p.x);
                (p * common + DVec2::new(x_term[i], y_term[i]) * r2) * (scale[i] * f)
            }
        }
    }

    /// The point in green of the light that a channel shows at a place, both mm in the real picture; `None`: the formula has none near.
    pub fn green_mm(&self, channel: Channel, place_mm: DVec2) -> Option<DVec2> {
        let enough = 4.0 * f64::EPSILON * place_mm.length();
        let mut green = place_mm;
        for _ in 0..MOST_STEPS {
            let off = place_mm - self.place_mm(channel, green);
            if !off.is_finite() {
                return None;
            }
            if off.length() <= enough {
                return Some(green);
            }
            green += off;
        }
        let off = (place_mm - self.place_mm(channel, green)).length();
        (off <= 1e-9 * place_mm.length()).then_some(green)
    }
}
