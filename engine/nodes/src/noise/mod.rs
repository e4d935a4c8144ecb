//! The Noise texture: Perlin noise summed over octaves in one of five ways, Musgrave's among them.

mod perlin;

use crate::choice::choices;
use crate::hash::{unit1, unit2};
use glam::{Vec2, Vec3A, Vec4};
use std::ops::{Add, Mul};

pub(crate) use perlin::noise3;

choices! {
    /// The combination of octaves.
    pub(crate) Fractal {
        Sum = "FBM",
        Multifractal = "MULTIFRACTAL",
        Ridged = "RIDGED_MULTIFRACTAL",
        Hybrid = "HYBRID_MULTIFRACTAL",
        Terrain = "HETERO_TERRAIN",
    }
}

choices! {
    /// Number of coordinates that a texture reads.
    pub(crate) Dimensions { One = "1D", Two = "2D", Three = "3D", Four = "4D" }
}

/// The settings that do not depend on the place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Octaves {
    pub(crate) fractal: Fractal,
    pub(crate) normalize: bool,
    pub(crate) detail: f32,
    pub(crate) roughness: f32,
    pub(crate) lacunarity: f32,
    pub(crate) offset: f32,
    pub(crate) gain: f32,
}

/// Octaves beyond this many would be finer than single precision.
const MOST_DETAIL: f32 = 15.0;

impl Octaves {
    /// The whole octaves after the first, and the share of one more. With a roughness of 0 none after the first has a weight.
    fn counts(&self) -> (i32, f32) {
        if self.roughness == 0.0 {
            return (0, 0.0);
        }
        (self.detail as i32, self.detail - self.detail.floor())
    }

    fn sum<P: Copy + Mul<f32, Output = P>>(&self, p: P, noise: impl Fn(P) -> f32) -> f32 {
        match self.fractal {
            Fractal::Sum => self.fbm(p, noise),
            Fractal::Multifractal => self.multifractal(p, noise),
            Fractal::Ridged => self.ridged(p, noise),
            Fractal::Hybrid => self.hybrid(p, noise),
            Fractal::Terrain => self.terrain(p, noise),
        }
    }

    fn fbm<P: Copy + Mul<f32, Output = P>>(&self, p: P, noise: impl Fn(P) -> f32) -> f32 {
        let (whole, rest) = self.counts();
        let (mut frequency, mut amplitude, mut most, mut sum) = (1.0, 1.0, 0.0, 0.0);
        for _ in 0..=whole {
            sum += noise(p * frequency) * amplitude;
            most += amplitude;
            amplitude *= self.roughness;
            frequency *= self.lacunarity;
        }
        let level = |sum: f32, most: f32| if self.normalize { 0.5 * sum / most + 0.5 } else { sum };
        if rest == 0.0 {
            return level(sum, most);
        }
        let finer = sum + noise(p * frequency) * amplitude;
        (1.0 - rest) * level(sum, most) + rest * level(finer, most + amplitude)
    }

    fn multifractal<P: Copy + Mul<f32, Output = P>>(&self, mut p: P, noise: impl Fn(P) -> f32) -> f32 {
        let (whole, rest) = self.counts();
        let (mut value, mut power) = (1.0, 1.0);
        for _ in 0..=whole {
            value *= power * noise(p) + 1.0;
            power *= self.roughness;
            p = p * self.lacunarity;
        }
        if rest != 0.0 {
            value *= rest * power * noise(p) + 1.0;
        }
        value
    }

    fn terrain<P: Copy + Mul<f32, Output = P>>(&self, mut p: P, noise: impl Fn(P) -> f32) -> f32 {
        let (whole, rest) = self.counts();
        let mut power = self.roughness;
        let mut value = self.offset + noise(p);
        p = p * self.lacunarity;
        for _ in 1..=whole {
            value += (noise(p) + self.offset) * power * value;
            power *= self.roughness;
            p = p * self.lacunarity;
        }
        if rest != 0.0 {
            value += rest * (noise(p) + self.offset) * power * value;
        }
        value
    }

    fn hybrid<P: Copy + Mul<f32, Output = P>>(&self, mut p: P, noise: impl Fn(P) -> f32) -> f32 {
        // Below this weight further octaves are left out.
        const LEAST_WEIGHT: f32 = 0.001;
        let (whole, rest) = self.counts();
        let (mut power, mut value, mut weight) = (1.0, 0.0, 1.0_f32);
        for _ in 0..=whole {
            if weight <= LEAST_WEIGHT {
                break;
            }
            weight = weight.min(1.0);
            let signal = (noise(p) + self.offset) * power;
            power *= self.roughness;
            value += weight * signal;
            weight *= self.gain * signal;
            p = p * self.lacunarity;
        }
        if rest != 0.0 && weight > LEAST_WEIGHT {
            value += rest * weight.min(1.0) * (noise(p) + self.offset) * power;
        }
        value
    }

    fn ridged<P: Copy + Mul<f32, Output = P>>(&self, mut p: P, noise: impl Fn(P) -> f32) -> f32 {
        let ridge = |p: P| {
            let height = self.offset - noise(p).abs();
            height * height
        };
        let mut power = self.roughness;
        let mut signal = ridge(p);
        let mut value = signal;
        for _ in 1..=self.counts().0 {
            p = p * self.lacunarity;
            signal = ridge(p) * (signal * self.gain).clamp(0.0, 1.0);
            value += signal * power;
            power *= self.roughness;
        }
        value
    }
}

/// The texture at a place already scaled: its value, or with `colour` three values of which it is the first.
pub(crate) fn noise_texture(
    dimensions: Dimensions,
    mut octaves: Octaves,
    p: Vec3A,
    w: f32,
    distortion: f32,
    colour: bool,
) -> Vec3A {
    octaves.detail = octaves.detail.clamp(0.0, MOST_DETAIL);
    octaves.roughness = octaves.roughness.max(0.0);
    match dimensions {
        Dimensions::One => {
            let mut x = w;
            if distortion != 0.0 {
                x += perlin::noise1(x + shift1(0.0)) * distortion;
            }
            three(|i| octaves.sum(x + shift1(i), perlin::noise1), octaves.sum(x, perlin::noise1), 1.0, colour)
        }
        Dimensions::Two => {
            let mut x = Vec2::new(p.x, p.y);
            let moved = |x: Vec2, seed: f32| x + Vec2::new(shift2(seed, 0.0), shift2(seed, 1.0));
            if distortion != 0.0 {
                let amount = [0.0, 1.0].map(|seed| perlin::noise2(moved(x, seed)) * distortion);
                x += Vec2::from_array(amount);
            }
            let sum = |x| octaves.sum(x, perlin::noise2);
            three(|seed| sum(moved(x, seed)), sum(x), 2.0, colour)
        }
        Dimensions::Three => {
            let mut x = p;
            let moved = |x: Vec3A, seed: f32| x + Vec3A::from_array([0.0, 1.0, 2.0].map(|axis| shift2(seed, axis)));
            if distortion != 0.0 {
                x += Vec3A::from_array([0.0, 1.0, 2.0].map(|seed| perlin::noise3(moved(x, seed)) * distortion));
            }
            let sum = |x| octaves.sum(x, perlin::noise3);
            three(|seed| sum(moved(x, seed)), sum(x), 3.0, colour)
        }
        Dimensions::Four => {
            let mut x = p.extend(w);
            let moved = |x: Vec4, seed: f32| x + Vec4::from_array([0.0, 1.0, 2.0, 3.0].map(|axis| shift2(seed, axis)));
            if distortion != 0.0 {
                let amount = [0.0, 1.0, 2.0, 3.0].map(|seed| perlin::noise4(moved(x, seed)) * distortion);
                x = x.add(Vec4::from_array(amount));
            }
            let sum = |x| octaves.sum(x, perlin::noise4);
            three(|seed| sum(moved(x, seed)), sum(x), 4.0, colour)
        }
    }
}

/// The value alone, or a colour whose second and third part are the noise elsewhere.
fn three(elsewhere: impl Fn(f32) -> f32, value: f32, first_seed: f32, colour: bool) -> Vec3A {
    if colour { Vec3A::new(value, elsewhere(first_seed), elsewhere(first_seed + 1.0)) } else { Vec3A::splat(value) }
}

fn shift1(seed: f32) -> f32 {
    100.0 + unit1(seed) * 100.0
}

fn shift2(seed: f32, axis: f32) -> f32 {
    100.0 + unit2(seed, axis) * 100.0
}

/// Summed octaves from 0 to 1, as Wave distorts itself with.
pub(crate) fn fbm3(p: Vec3A, detail: f32, roughness: f32, lacunarity: f32) -> f32 {
    let octaves = Octaves {
        fractal: Fractal::Sum,
        normalize: true,
        detail: detail.clamp(0.0, MOST_DETAIL),
        roughness: roughness.max(0.0),
        lacunarity,
        offset: 0.0,
        gain: 0.0,
    };
    octaves.fbm(p, noise3)
}
