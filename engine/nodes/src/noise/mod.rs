//! The Noise texture: Perlin noise summed over octaves in one of five ways, Musgrave's among them.

mod perlin;
mod perlin_lanes;

use crate::choice::choices;
use crate::hash::{unit1, unit2};
use crate::lanes::Number;
use glam::Vec3A;

/// Perlin's gradient noise of a number, or of those of eight places at once.
pub(crate) trait Perlin: Number {
    fn noise1(p: [Self; 1]) -> Self;
    fn noise2(p: [Self; 2]) -> Self;
    fn noise3(p: [Self; 3]) -> Self;
    fn noise4(p: [Self; 4]) -> Self;
}

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

    fn sum<N: Number, const D: usize>(&self, p: [N; D], noise: impl Fn([N; D]) -> N) -> N {
        match self.fractal {
            Fractal::Sum => self.fbm(p, noise),
            Fractal::Multifractal => self.multifractal(p, noise),
            Fractal::Ridged => self.ridged(p, noise),
            Fractal::Hybrid => self.hybrid(p, noise),
            Fractal::Terrain => self.terrain(p, noise),
        }
    }

    fn fbm<N: Number, const D: usize>(&self, p: [N; D], noise: impl Fn([N; D]) -> N) -> N {
        let (whole, rest) = self.counts();
        let (mut frequency, mut amplitude, mut most, mut sum) = (1.0, 1.0, 0.0, N::of(0.0));
        for _ in 0..=whole {
            sum = sum + noise(scaled(p, frequency)) * N::of(amplitude);
            most += amplitude;
            amplitude *= self.roughness;
            frequency *= self.lacunarity;
        }
        let half = N::of(0.5);
        let level = |sum: N, most: f32| if self.normalize { half * sum / N::of(most) + half } else { sum };
        if rest == 0.0 {
            return level(sum, most);
        }
        let finer = sum + noise(scaled(p, frequency)) * N::of(amplitude);
        N::of(1.0 - rest) * level(sum, most) + N::of(rest) * level(finer, most + amplitude)
    }

    fn multifractal<N: Number, const D: usize>(&self, mut p: [N; D], noise: impl Fn([N; D]) -> N) -> N {
        let (whole, rest) = self.counts();
        let (mut value, mut power) = (N::of(1.0), 1.0);
        for _ in 0..=whole {
            value = value * (N::of(power) * noise(p) + N::of(1.0));
            power *= self.roughness;
            p = scaled(p, self.lacunarity);
        }
        if rest != 0.0 {
            value = value * (N::of(rest * power) * noise(p) + N::of(1.0));
        }
        value
    }

    fn terrain<N: Number, const D: usize>(&self, mut p: [N; D], noise: impl Fn([N; D]) -> N) -> N {
        let (whole, rest) = self.counts();
        let mut power = self.roughness;
        let mut value = N::of(self.offset) + noise(p);
        p = scaled(p, self.lacunarity);
        for _ in 1..=whole {
            value = value + (noise(p) + N::of(self.offset)) * N::of(power) * value;
            power *= self.roughness;
            p = scaled(p, self.lacunarity);
        }
        if rest != 0.0 {
            value = value + N::of(rest) * (noise(p) + N::of(self.offset)) * N::of(power) * value;
        }
        value
    }

    fn hybrid<N: Number, const D: usize>(&self, mut p: [N; D], noise: impl Fn([N; D]) -> N) -> N {
        let (least, zero, one) = (N::of(LEAST_WEIGHT), N::of(0.0), N::of(1.0));
        let (whole, rest) = self.counts();
        let (mut power, mut value, mut weight) = (1.0, zero, one);
        for _ in 0..=whole {
            let bounded = weight.if_below(one, weight, one);
            let signal = (noise(p) + N::of(self.offset)) * N::of(power);
            power *= self.roughness;
            // A place whose weight is gone stays as it is.
            value = value + least.if_below(weight, bounded * signal, zero);
            weight = least.if_below(weight, bounded * (N::of(self.gain) * signal), weight);
            p = scaled(p, self.lacunarity);
        }
        if rest != 0.0 {
            let bounded = weight.if_below(one, weight, one);
            let last = N::of(rest) * bounded * (noise(p) + N::of(self.offset)) * N::of(power);
            value = value + least.if_below(weight, last, zero);
        }
        value
    }

    fn ridged<N: Number, const D: usize>(&self, mut p: [N; D], noise: impl Fn([N; D]) -> N) -> N {
        let ridge = |p: [N; D]| {
            let height = N::of(self.offset) - noise(p).abs();
            height * height
        };
        let mut power = self.roughness;
        let mut signal = ridge(p);
        let mut value = signal;
        for _ in 1..=self.counts().0 {
            p = scaled(p, self.lacunarity);
            signal = ridge(p) * (signal * N::of(self.gain)).saturated();
            value = value + signal * N::of(power);
            power *= self.roughness;
        }
        value
    }
}

/// The weight below which [`Fractal::Hybrid`] leaves further octaves out.
const LEAST_WEIGHT: f32 = 0.001;

#[inline(always)]
fn scaled<N: Number, const D: usize>(p: [N; D], factor: f32) -> [N; D] {
    p.map(|part| part * N::of(factor))
}

/// A place moved to another, independent part of the noise.
#[inline(always)]
fn moved<N: Number, const D: usize>(p: [N; D], seed: f32) -> [N; D] {
    let mut axis = -1.0;
    p.map(|part| {
        axis += 1.0;
        part + N::of(if D == 1 { shift1(seed) } else { shift2(seed, axis) })
    })
}

/// The texture at a place already scaled: its value, or with `colour` three values of which it is the first.
pub(crate) fn noise_texture<N: Perlin>(
    dimensions: Dimensions,
    mut octaves: Octaves,
    [x, y, z]: [N; 3],
    w: N,
    distortion: f32,
    colour: bool,
) -> [N; 3] {
    octaves.detail = octaves.detail.clamp(0.0, MOST_DETAIL);
    octaves.roughness = octaves.roughness.max(0.0);
    match dimensions {
        Dimensions::One => octaves.texture([w], N::noise1, distortion, colour),
        Dimensions::Two => octaves.texture([x, y], N::noise2, distortion, colour),
        Dimensions::Three => octaves.texture([x, y, z], N::noise3, distortion, colour),
        Dimensions::Four => octaves.texture([x, y, z, w], N::noise4, distortion, colour),
    }
}

impl Octaves {
    fn texture<N: Number, const D: usize>(
        &self,
        mut p: [N; D],
        noise: impl Fn([N; D]) -> N + Copy,
        distortion: f32,
        colour: bool,
    ) -> [N; 3] {
        if distortion != 0.0 {
            let mut seed = -1.0;
            let amount = p.map(|_| {
                seed += 1.0;
                noise(moved(p, seed)) * N::of(distortion)
            });
            p = std::array::from_fn(|axis| p[axis] + amount[axis]);
        }
        let value = self.sum(p, noise);
        if !colour {
            return [value; 3];
        }
        // The second and third part are the noise elsewhere.
        let elsewhere = |seed: f32| self.sum(moved(p, seed), noise);
        let first = D as f32;
        [value, elsewhere(first), elsewhere(first + 1.0)]
    }
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
    octaves.fbm(p.to_array(), f32::noise3)
}
