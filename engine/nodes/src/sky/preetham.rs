//! The sky of Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999.

use crate::spectral::rec709;
use glam::Vec3A;
use std::f32::consts::{FRAC_PI_2, PI};

/// A sky for one place of the sun: brightness and colour (Y, x, y) by direction.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Preetham {
    sun: Vec3A,
    /// The five numbers of Perez's formula, for Y, x and y.
    shape: [[f32; 5]; 3],
    /// The value overhead, over that of the formula there.
    zenith: [f32; 3],
}

/// Perez's formula for the angles from the zenith and from the sun.
fn perez([a, b, c, d, e]: [f32; 5], from_zenith_rad: f32, from_sun_rad: f32) -> f32 {
    let cosine = from_sun_rad.cos();
    (1.0 + a * (b / from_zenith_rad.cos()).exp()) * (1.0 + c * (d * from_sun_rad).exp() + e * cosine * cosine)
}

impl Preetham {
    pub(crate) fn new(sun: Vec3A, turbidity: f32) -> Self {
        let sun = sun.normalize_or(Vec3A::Z);
        let t = turbidity;
        let angle_rad = sun.z.clamp(-1.0, 1.0).acos();
        let shape = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let cubic = |c: [f32; 4]| ((c[0] * angle_rad + c[1]) * angle_rad + c[2]) * angle_rad + c[3];
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * angle_rad);
        // Blender's unit of brightness, from the paper's kilocandela per square metre.
        const UNIT: f32 = 0.06;
        let zenith = [
            ((4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192) * UNIT,
            cubic([0.00166, -0.00375, 0.00209, 0.0]) * t * t
                + cubic([-0.02903, 0.06377, -0.03202, 0.00394]) * t
                + cubic([0.11693, -0.21196, 0.06052, 0.25886]),
            cubic([0.00275, -0.00610, 0.00317, 0.0]) * t * t
                + cubic([-0.04214, 0.08970, -0.04153, 0.00516]) * t
                + cubic([0.15346, -0.26756, 0.06670, 0.26688]),
        ];
        let zenith = std::array::from_fn(|i| zenith[i] / perez(shape[i], 0.0, angle_rad));
        Self { sun, shape, zenith }
    }

    /// The colour of a direction; below the horizon, the horizon's.
    pub(crate) fn at(&self, direction: Vec3A) -> Vec3A {
        let direction = direction.normalize_or(Vec3A::Z);
        let from_zenith = direction.z.clamp(-1.0, 1.0).acos();
        let from_sun = direction.dot(self.sun).clamp(-1.0, 1.0).acos();
        // Perez's formula has no value at the horizon itself.
        let from_zenith = from_zenith.min(FRAC_PI_2 - 0.001);
        let [luminance, x, y] = std::array::from_fn(|i| self.zenith[i] * perez(self.shape[i], from_zenith, from_sun));
        if y == 0.0 {
            return Vec3A::ZERO;
        }
        rec709(Vec3A::new(x / y, 1.0, (1.0 - x - y) / y) * luminance)
    }
}
