//! The sky of Hosek and Wilkie, "An Analytic Model for Full Spectral Sky-Dome Radiance", SIGGRAPH 2012, by their data for
//! CIE XYZ.

use crate::spectral::rec709;
use glam::Vec3A;
use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

/// Numbers of the formula, and the brightness.
const NUMBERS: usize = 10;
const TURBIDITIES: usize = 10;

type Polynomial = [f32; 6];

/// The formula's polynomials by channel, albedo (0, 1), turbidity (1 to 10) and number.
static DATA: LazyLock<Vec<Polynomial>> = LazyLock::new(|| {
    let lines = include_str!("../../data/hosek-wilkie-xyz.txt").lines().filter(|line| !line.starts_with('#'));
    let polynomial = |line: &str| {
        let mut numbers = line.split(' ').map(|number| number.parse().expect("the file holds numbers"));
        std::array::from_fn(|_| numbers.next().expect("six a line"))
    };
    lines.map(polynomial).collect()
});

#[derive(Clone, Debug)]
pub(crate) struct Hosek {
    sun: Vec3A,
    /// The formula's numbers, and the brightness, by channel.
    channels: [[f32; NUMBERS]; 3],
}

/// Bernstein's polynomial of the fifth degree.
fn bernstein(coefficients: &Polynomial, x: f32) -> f32 {
    const BINOMIALS: Polynomial = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let term = |i: usize| BINOMIALS[i] * x.powi(i as i32) * (1.0 - x).powi(5 - i as i32) * coefficients[i];
    (0..6).map(term).sum()
}

impl Hosek {
    /// The sky for the sun in a direction, at the horizon if it is below; turbidity 1 to 10, albedo of the ground 0 to 1.
    pub(crate) fn new(sun: Vec3A, turbidity: f32, albedo: f32) -> Self {
        let sun = sun.normalize_or(Vec3A::Z);
        let elevation_rad = sun.z.clamp(0.0, 1.0).asin();
        let x = (elevation_rad / FRAC_PI_2).cbrt();
        let turbidity = turbidity.clamp(1.0, TURBIDITIES as f32) - 1.0;
        let (low, share) = (turbidity as usize, turbidity.fract());
        let at = |channel: usize, albedo: usize, turbidity: usize, number: usize| {
            let turbidity = turbidity.min(TURBIDITIES - 1);
            bernstein(&DATA[((channel * 2 + albedo) * TURBIDITIES + turbidity) * NUMBERS + number], x)
        };
        let mixed = |channel, number| {
            let of_albedo = |albedo| {
                at(channel, albedo, low, number) * (1.0 - share) + at(channel, albedo, low + 1, number) * share
            };
            of_albedo(0) * (1.0 - albedo) + of_albedo(1) * albedo
        };
        Self { sun, channels: std::array::from_fn(|c| std::array::from_fn(|n| mixed(c, n))) }
    }

    /// The colour of a direction; below the horizon, the horizon's.
    pub(crate) fn at(&self, direction: Vec3A) -> Vec3A {
        // Blender's unit of brightness: watts, over the luminous efficacy of 683 lm/W.
        const UNIT: f32 = TAU / 683.0;
        let direction = direction.normalize_or(Vec3A::Z);
        // The formula has no value at the horizon itself.
        let cos_zenith = direction.z.max(0.001);
        let cosine = direction.dot(self.sun).clamp(-1.0, 1.0);
        let angle_rad = cosine.acos();
        let parts = self.channels.map(|[a, b, c, d, e, f, g, h, i, brightness]| {
            let aureole = (1.0 + cosine * cosine) / (1.0 + i * i - 2.0 * i * cosine).powf(1.5);
            let gradient = 1.0 + a * (b / (cos_zenith + 0.01)).exp();
            let around = c + d * (e * angle_rad).exp() + f * cosine * cosine + g * aureole + h * cos_zenith.sqrt();
            gradient * around * brightness
        });
        rec709(Vec3A::from(parts) * UNIT).max(Vec3A::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_data_is_whole() {
        assert_eq!(DATA.len(), 3 * 2 * TURBIDITIES * NUMBERS);
        assert!(DATA.iter().flatten().all(|number| number.is_finite()));
    }

    #[test]
    fn it_is_blue_above_and_brightest_at_the_sun() {
        let sun = Vec3A::new(0.0, 0.6, 0.8);
        let sky = Hosek::new(sun, 2.2, 0.3);
        let above = sky.at(Vec3A::Z);
        assert!(above.z > above.y && above.y > above.x && above.x > 0.0, "{above}");
        assert!(sky.at(sun).y > 2.0 * sky.at(Vec3A::new(0.0, -0.6, 0.8)).y);
    }
}
