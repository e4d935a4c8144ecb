//! Textures without state: Wave, Magic, Gradient, Checker, Brick and White Noise.

use crate::choice::choices;
use crate::hash::{colour1, colour2, colour3, colour4, unit1, unit2, unit3, unit4};
use crate::noise::{Dimensions, fbm3};
use glam::{Vec2, Vec3A};
use std::f32::consts::{FRAC_PI_2, TAU};

choices! {
    /// The direction of waves: an axis, a diagonal, or out from an axis or a point.
    pub(crate) WaveAxis { X = "X", Y = "Y", Z = "Z", All = "DIAGONAL" | "SPHERICAL" }
}
choices! { pub(crate) WaveKind { Bands = "BANDS", Rings = "RINGS" } }
choices! { pub(crate) WaveProfile { Sine = "SIN", Saw = "SAW", Triangle = "TRI" } }
choices! {
    pub(crate) GradientKind {
        Linear = "LINEAR",
        Quadratic = "QUADRATIC",
        Easing = "EASING",
        Diagonal = "DIAGONAL",
        Radial = "RADIAL",
        QuadraticSphere = "QUADRATIC_SPHERE",
        Sphere = "SPHERICAL",
    }
}

/// Blender draws places on a cell's border a little away from it, the same on all sides.
fn off_the_border(p: Vec3A) -> Vec3A {
    (p + 0.000_001) * 0.999_999
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Wave {
    pub(crate) kind: WaveKind,
    pub(crate) axis: WaveAxis,
    pub(crate) profile: WaveProfile,
    pub(crate) distortion: f32,
    pub(crate) detail: f32,
    pub(crate) detail_scale: f32,
    pub(crate) detail_roughness: f32,
    pub(crate) phase: f32,
}

impl Wave {
    /// The wave at a place already scaled.
    pub(crate) fn at(&self, p: Vec3A) -> f32 {
        let p = off_the_border(p);
        let mut n = match self.kind {
            WaveKind::Bands => match self.axis {
                WaveAxis::X => p.x * 20.0,
                WaveAxis::Y => p.y * 20.0,
                WaveAxis::Z => p.z * 20.0,
                WaveAxis::All => (p.x + p.y + p.z) * 10.0,
            },
            WaveKind::Rings => {
                let flat = match self.axis {
                    WaveAxis::X => p * Vec3A::new(0.0, 1.0, 1.0),
                    WaveAxis::Y => p * Vec3A::new(1.0, 0.0, 1.0),
                    WaveAxis::Z => p * Vec3A::new(1.0, 1.0, 0.0),
                    WaveAxis::All => p,
                };
                flat.length() * 20.0
            }
        };
        n += self.phase;
        if self.distortion != 0.0 {
            let noise = fbm3(p * self.detail_scale, self.detail, self.detail_roughness, 2.0);
            n += self.distortion * (noise * 2.0 - 1.0);
        }
        match self.profile {
            WaveProfile::Sine => 0.5 + 0.5 * (n - FRAC_PI_2).sin(),
            WaveProfile::Saw => {
                let turns = n / TAU;
                turns - turns.floor()
            }
            WaveProfile::Triangle => {
                let turns = n / TAU;
                (turns - (turns + 0.5).floor()).abs() * 2.0
            }
        }
    }
}

/// Magic at a place already scaled.
pub(crate) fn magic(p: Vec3A, distortion: f32, depth: u8) -> Vec3A {
    // The sums of folded coordinates give the same sines, and keep their digits.
    let [a, b, c] = p.to_array().map(|part| part % TAU);
    let mut x = ((a + b + c) * 5.0).sin();
    let mut y = ((-a + b - c) * 5.0).cos();
    let mut z = -((-a - b + c) * 5.0).cos();
    if depth > 0 {
        (x, y, z) = (x * distortion, y * distortion, z * distortion);
        y = -(x - y + z).cos() * distortion;
    }
    for step in 1..depth.min(10) {
        match step {
            1 => x = (x - y - z).cos() * distortion,
            2 => z = (-x - y - z).sin() * distortion,
            3 => x = -(-x + y - z).cos() * distortion,
            4 => y = -(-x + y + z).sin() * distortion,
            5 => y = -(-x + y + z).cos() * distortion,
            6 => x = (x + y + z).cos() * distortion,
            7 => z = (x + y - z).sin() * distortion,
            8 => x = -(-x - y + z).cos() * distortion,
            _ => y = -(x - y + z).sin() * distortion,
        }
    }
    let folded = Vec3A::new(x, y, z);
    Vec3A::splat(0.5) - if distortion == 0.0 { folded } else { folded / (2.0 * distortion) }
}

pub(crate) fn gradient(kind: GradientKind, p: Vec3A) -> f32 {
    let sphere = || (0.999_999 - p.length()).max(0.0);
    let value = match kind {
        GradientKind::Linear => p.x,
        GradientKind::Quadratic => p.x.max(0.0).powi(2),
        GradientKind::Easing => {
            let t = p.x.clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        }
        GradientKind::Diagonal => (p.x + p.y) * 0.5,
        GradientKind::Radial => p.y.atan2(p.x) / TAU + 0.5,
        GradientKind::QuadraticSphere => sphere().powi(2),
        GradientKind::Sphere => sphere(),
    };
    value.clamp(0.0, 1.0)
}

/// True if the first colour shows, at a place already scaled.
pub(crate) fn checker(p: Vec3A) -> bool {
    let odd = |part: f32| (part.floor() as i32).unsigned_abs() % 2 == 1;
    let p = off_the_border(p);
    (odd(p.x) == odd(p.y)) == odd(p.z)
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Brick {
    pub(crate) mortar_size: f32,
    pub(crate) mortar_smooth: f32,
    pub(crate) bias: f32,
    pub(crate) width: f32,
    pub(crate) row_height: f32,
    pub(crate) offset: f32,
    pub(crate) squash: f32,
    pub(crate) offset_frequency: i32,
    pub(crate) squash_frequency: i32,
}

impl Brick {
    /// The brick's tint from first to second colour, and the mortar's share; at a place already scaled.
    pub(crate) fn at(&self, p: Vec3A) -> (f32, f32) {
        let (mut width, mut offset) = (self.width, 0.0);
        let row = (p.y / self.row_height).floor() as i32;
        if self.offset_frequency != 0 && self.squash_frequency != 0 {
            if row % self.squash_frequency == 0 {
                width *= self.squash;
            }
            if row % self.offset_frequency == 0 {
                offset = width * self.offset;
            }
        }
        let brick = ((p.x + offset) / width).floor() as i32;
        let x = p.x + offset - width * brick as f32;
        let y = p.y - self.row_height * row as f32;
        let noise = brick_noise((row.wrapping_shl(16)).wrapping_add(brick & 0xffff) as u32);
        let tint = (noise + self.bias).clamp(0.0, 1.0);
        let to_edge = x.min(y).min((width - x).min(self.row_height - y));
        if to_edge >= self.mortar_size {
            return (tint, 0.0);
        }
        if self.mortar_smooth == 0.0 {
            return (tint, 1.0);
        }
        let depth = 1.0 - to_edge / self.mortar_size;
        let t = (depth / self.mortar_smooth).clamp(0.0, 1.0);
        (tint, if depth < self.mortar_smooth { t * t * (3.0 - 2.0 * t) } else { 1.0 })
    }
}

fn brick_noise(number: u32) -> f32 {
    let n = number.wrapping_add(1013) & 0x7fff_ffff;
    let n = (n >> 13) ^ n;
    let mixed = n.wrapping_mul(n.wrapping_mul(n).wrapping_mul(60_493).wrapping_add(19_990_303));
    let mixed = mixed.wrapping_add(1_376_312_589) & 0x7fff_ffff;
    0.5 * (mixed as f32 / 1_073_741_824.0)
}

pub(crate) fn white_noise(dimensions: Dimensions, p: Vec3A, w: f32) -> f32 {
    match dimensions {
        Dimensions::One => unit1(w),
        Dimensions::Two => unit2(p.x, p.y),
        Dimensions::Three => unit3(p.x, p.y, p.z),
        Dimensions::Four => unit4(p.x, p.y, p.z, w),
    }
}

pub(crate) fn white_noise_colour(dimensions: Dimensions, p: Vec3A, w: f32) -> Vec3A {
    match dimensions {
        Dimensions::One => colour1(w),
        Dimensions::Two => colour2(Vec2::new(p.x, p.y)),
        Dimensions::Three => colour3(p),
        Dimensions::Four => colour4(p.extend(w)),
    }
}
