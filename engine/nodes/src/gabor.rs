//! The Gabor texture: sparse waves of one frequency, each under a bell, scattered over cells.
//!
//! Method: A. Lagae et al., "Procedural Noise using Sparse Gabor Convolution", SIGGRAPH 2009; the phasor after T. Tricard
//! et al., "Procedural Phasor Noise", SIGGRAPH 2019.

use crate::choice::choices;
use crate::hash::{unit3, unit4};
use glam::{Vec2, Vec3A};
use std::f32::consts::{PI, TAU};

choices! { pub(crate) GaborKind { Flat = "2D", Solid = "3D" } }

/// Waves in each cell.
const WAVES: u8 = 8;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Gabor {
    pub(crate) frequency: f32,
    pub(crate) anisotropy: f32,
    pub(crate) orientation_rad: f32,
    pub(crate) direction: Vec3A,
}

/// The outputs of the node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waves {
    pub(crate) value: f32,
    pub(crate) phase: f32,
    pub(crate) intensity: f32,
}

/// One wave at a distance from its middle: sine and cosine under the bell.
fn wave(square: f32, turns: f32) -> Vec2 {
    let bell = (-PI * square).exp() * (0.5 + 0.5 * (PI * square).cos());
    let (sine, cosine) = (TAU * turns).sin_cos();
    Vec2::new(cosine, sine) * bell
}

impl Gabor {
    /// The waves at a place already scaled.
    pub(crate) fn at(&self, kind: GaborKind, p: Vec3A) -> Waves {
        let isotropy = 1.0 - self.anisotropy.clamp(0.0, 1.0);
        let frequency = self.frequency.max(0.001);
        // The mean square of a bell of either kind, integrated.
        let (sum, bell) = match kind {
            GaborKind::Flat => (self.flat(Vec2::new(p.x, p.y), frequency, isotropy), 0.25),
            GaborKind::Solid => (self.solid(p, frequency, isotropy), 0.25 * std::f32::consts::FRAC_1_SQRT_2),
        };
        // Six standard deviations hold nearly all values; half of all waves' energy is in the sine.
        let range = 6.0 * (f32::from(WAVES) * 0.5 * bell).sqrt();
        Waves {
            value: sum.y / range * 0.5 + 0.5,
            phase: (sum.y.atan2(sum.x) + PI) / TAU,
            intensity: sum.length() / range,
        }
    }

    fn flat(&self, p: Vec2, frequency: f32, isotropy: f32) -> Vec2 {
        let middle = p.floor();
        let mut sum = Vec2::ZERO;
        for number in 0..9 {
            let step = Vec2::new((number % 3) as f32 - 1.0, (number / 3) as f32 - 1.0);
            let cell = middle + step;
            let local = p - middle - step;
            for i in 0..WAVES {
                let seed = |which: u8| f32::from(3 * i + which);
                let centre = Vec2::new(unit3(cell.x, cell.y, seed(1)), unit3(seed(1), cell.x, cell.y));
                let away = local - centre;
                let square = away.length_squared();
                if square >= 1.0 {
                    continue;
                }
                let turn = (unit3(cell.x, cell.y, seed(0)) - 0.5) * PI;
                let along = Vec2::from_angle(self.orientation_rad + turn * isotropy);
                let sign = if unit3(cell.x, cell.y, seed(2)) < 0.5 { -1.0 } else { 1.0 };
                sum += wave(square, frequency * away.dot(along)) * sign;
            }
        }
        sum
    }

    fn solid(&self, p: Vec3A, frequency: f32, isotropy: f32) -> Vec2 {
        let middle = p.floor();
        let direction = self.direction.normalize_or_zero();
        let mut sum = Vec2::ZERO;
        for number in 0..27 {
            let digit = |place: i32| (number / place % 3) as f32 - 1.0;
            let step = Vec3A::new(digit(1), digit(3), digit(9));
            let cell = middle + step;
            let local = p - middle - step;
            for i in 0..WAVES {
                let seed = |which: u8| f32::from(3 * i + which);
                let unit = |x: f32, y: f32, z: f32, w: f32| unit4(x, y, z, w);
                let [x, y, z] = cell.to_array();
                let at = seed(1);
                let centre = Vec3A::new(unit(x, y, z, at), unit(z, x, at, y), unit(at, z, y, x));
                let away = local - centre;
                let square = away.length_squared();
                if square >= 1.0 {
                    continue;
                }
                let along = if isotropy == 0.0 {
                    direction
                } else {
                    let turns = Vec2::new(unit(x, y, z, seed(0)), unit(z, x, seed(0), y)) * (PI * isotropy);
                    let azimuth =
                        if direction.x == 0.0 && direction.y == 0.0 { 0.0 } else { direction.y.atan2(direction.x) };
                    let (sine, cosine) = (direction.z.clamp(-1.0, 1.0).acos() + turns.x).sin_cos();
                    let around = Vec2::from_angle(azimuth + turns.y) * sine;
                    Vec3A::new(around.x, around.y, cosine)
                };
                let sign = if unit(x, y, z, seed(2)) < 0.5 { -1.0 } else { 1.0 };
                sum += wave(square, frequency * away.dot(along)) * sign;
            }
        }
        sum
    }
}
