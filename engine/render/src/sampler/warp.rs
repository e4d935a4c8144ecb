//! Shapes sampled by two uniform numbers. Directions are about +z unless a frame is given.

use glam::{Vec2, Vec3, Vec3A};
use serde::Deserialize;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI, TAU};

/// The unit disk, uniformly, by the concentric map (Shirley and Chiu 1997): neighbours stay neighbours.
#[inline]
pub fn sample_disk(u: [f32; 2]) -> Vec2 {
    let x = 2.0 * u[0] - 1.0;
    let y = 2.0 * u[1] - 1.0;
    // Which is larger is no branch: any processor would guess it wrong half of the time.
    let wide = x.abs() > y.abs();
    let (large, small) = if wide { (x, y) } else { (y, x) };
    let ratio = if large == 0.0 { 0.0 } else { small / large };
    let (sin, cos) = sin_cos_to_eighth(FRAC_PI_4 * ratio);
    let (along, across) = (large * cos, large * sin);
    if wide { Vec2::new(along, across) } else { Vec2::new(across, along) }
}

/// Sine and cosine of an angle up to an eighth of a turn, by their series: the terms left out are below 3e-8.
#[inline]
fn sin_cos_to_eighth(a: f32) -> (f32, f32) {
    let q = a * a;
    let sin = a * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0 + q * (1.0 / 362_880.0)))));
    let cos = 1.0 + q * (-0.5 + q * (1.0 / 24.0 + q * (-1.0 / 720.0 + q * (1.0 / 40_320.0))));
    (sin, cos)
}

/// The upper hemisphere by the cosine of the angle to +z.
#[inline]
pub fn sample_cosine_hemisphere(u: [f32; 2]) -> Vec3A {
    let d = sample_disk(u);
    Vec3A::new(d.x, d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`sample_cosine_hemisphere`] per steradian.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// A cone about +z of the half angle whose 1 - cosine is given (small angles keep their digits), uniformly.
#[inline]
pub fn sample_cone(u: [f32; 2], one_minus_cos_max: f32) -> Vec3A {
    let one_minus_cos = u[0] * one_minus_cos_max;
    let sin = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
    let (s, c) = (TAU * u[1]).sin_cos();
    Vec3A::new(sin * c, sin * s, 1.0 - one_minus_cos)
}

/// Density of [`sample_cone`] per steradian.
#[inline]
pub fn cone_pdf(one_minus_cos_max: f32) -> f32 {
    1.0 / (TAU * one_minus_cos_max)
}

/// Barycentric coordinates (of the second and third corner) of a triangle, uniformly by area, with low
/// distortion (Heitz 2019).
#[inline]
pub fn sample_triangle(u: [f32; 2]) -> [f32; 2] {
    if u[0] < u[1] {
        let a = 0.5 * u[0];
        [a, u[1] - a]
    } else {
        let b = 0.5 * u[1];
        [u[0] - b, b]
    }
}

/// A point of the unit sphere, sampled uniformly.
#[inline]
pub fn sample_sphere(u: [f32; 2]) -> Vec3A {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = (TAU * u[1]).sin_cos();
    Vec3A::new(r * c, r * s, z)
}

/// Density of [`sample_sphere`] per steradian.
pub const SPHERE_PDF: f32 = 0.25 / PI;

/// A right-handed frame about a unit normal: columns tangent, bitangent, normal (Duff et al. 2017).
#[inline]
pub fn frame(n: Vec3A) -> [Vec3A; 3] {
    let sign = 1.0f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [Vec3A::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3A::new(b, sign + n.y * n.y * a, -n.y), n]
}

/// A direction in the axes of `frame` to where the frame stands.
#[inline]
pub fn to_world(frame: &[Vec3A; 3], v: Vec3A) -> Vec3A {
    frame[0] * v.x + frame[1] * v.y + frame[2] * v.z
}

/// The inverse of [`to_world`].
#[inline]
pub fn to_local(frame: &[Vec3A; 3], v: Vec3A) -> Vec3A {
    Vec3A::new(frame[0].dot(v), frame[1].dot(v), frame[2].dot(v))
}

/// The shape of a pixel filter, as Cycles defines it; widths in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Filter {
    /// A constant over one pixel.
    Box,
    /// A Gaussian function, e⁻⁸ at the width's distance from the pixel's centre; it ends at one and a half times that.
    Gaussian(f32),
    /// The Blackman-Harris window; it ends at the width's distance from the pixel's centre.
    BlackmanHarris(f32),
}

impl Filter {
    /// The distance at which it ends, pixels.
    fn reach(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Gaussian(width) => 1.5 * width,
            Self::BlackmanHarris(width) => width,
        }
    }

    /// The filter's value at a part of its reach, in any unit.
    fn value(self, part: f64) -> f64 {
        match self {
            Self::Box => 1.0,
            Self::Gaussian(_) => (-18.0 * part * part).exp(),
            Self::BlackmanHarris(_) => {
                let v = std::f64::consts::PI * (1.0 + part);
                0.35875 - 0.48829 * v.cos() + 0.14128 * (2.0 * v).cos() - 0.01168 * (3.0 * v).cos()
            }
        }
    }
}

/// A pixel filter sampled by its own density, so that every sample weighs the same.
#[derive(Clone, Debug)]
pub struct PixelFilter {
    // Inverse of the cumulative distribution at equal steps: offsets in pixels.
    inverse: Vec<f32>,
    // The same within the first step, where the inverse is steep; empty for the box.
    tail: Vec<f32>,
    reach: f32,
    // Densities at equal steps from the centre to the reach.
    densities: Vec<f32>,
    steps_per_pixel: f32,
}

impl PixelFilter {
    const STEPS: usize = 1024;

    /// The tables of a filter.
    pub fn new(filter: Filter) -> Self {
        let reach = filter.reach();
        if filter == Filter::Box {
            return Self {
                inverse: vec![-0.5, 0.5],
                tail: Vec::new(),
                reach,
                densities: vec![1.0; 2],
                steps_per_pixel: 2.0,
            };
        }
        let fine = 8192;
        let mut cumulative = vec![0.0];
        for i in 0..fine {
            cumulative.push(cumulative[i] + filter.value((2.0 * i as f64 + 1.0) / fine as f64 - 1.0));
        }
        let total = cumulative[fine];
        let offset = |share: f64| {
            let target = total * share;
            let i = cumulative.partition_point(|&c| c < target).clamp(1, fine);
            let part = (target - cumulative[i - 1]) / (cumulative[i] - cumulative[i - 1]);
            (((i - 1) as f64 + part.clamp(0.0, 1.0)) / fine as f64 - 0.5) as f32 * 2.0 * reach
        };
        let up_to =
            |most: f64| (0..=Self::STEPS).map(move |k| most * k as f64 / Self::STEPS as f64).map(offset).collect();
        let (inverse, tail) = (up_to(1.0), up_to(1.0 / Self::STEPS as f64));
        let mean = total / fine as f64;
        let density = |k: usize| filter.value(k as f64 / Self::STEPS as f64) / (mean * 2.0 * f64::from(reach));
        let densities = (0..=Self::STEPS).map(|k| density(k) as f32).collect();
        Self { inverse, tail, reach, densities, steps_per_pixel: Self::STEPS as f32 / reach }
    }

    /// Largest offset of a sample from its pixel's centre along an axis, pixels.
    #[inline]
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// True for all filters but the box.
    pub fn is_smooth(&self) -> bool {
        self.densities.len() > 2
    }

    /// The density of an offset, per pixel.
    #[inline]
    pub fn density(&self, offset: f32) -> f32 {
        let at = offset.abs() * self.steps_per_pixel;
        let i = at as usize;
        match self.densities.get(i..i + 2) {
            Some(&[here, next]) => here + (next - here) * (at - i as f32),
            _ if offset.abs() <= self.reach => self.densities[self.densities.len() - 1],
            _ => 0.0,
        }
    }

    /// Offset from the pixel's centre in pixels.
    #[inline]
    pub fn sample(&self, u: f32) -> f32 {
        // By way of 32 bits, which a processor converts to in one step.
        let steps = self.inverse.len() - 1;
        let x = u * steps as u32 as f32;
        let i = (x as i32).clamp(0, steps as i32 - 1);
        if i == 0 || i == steps as i32 - 1 {
            return self.outermost(x, steps as f32);
        }
        between(&self.inverse, x)
    }

    /// The offset in the first and the last of the steps.
    #[cold]
    fn outermost(&self, x: f32, steps: f32) -> f32 {
        if self.tail.is_empty() {
            return between(&self.inverse, x);
        }
        let last = (self.tail.len() - 1) as f32;
        if x < 1.0 { between(&self.tail, x * last) } else { -between(&self.tail, (steps - x).max(0.0) * last) }
    }
}

/// The value of a table at a place in steps, straight between two.
#[inline(always)]
fn between(table: &[f32], x: f32) -> f32 {
    let i = (x as i32).clamp(0, table.len() as i32 - 2);
    let part = x - i as f32;
    let [here, next] = [0, 1].map(|step| table[i as usize + step]);
    here * (1.0 - part) + next * part
}

/// [`Vec3`] to the aligned form used in shading.
#[inline]
pub fn aligned(v: Vec3) -> Vec3A {
    Vec3A::from(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling::{self, Random};

    fn grid() -> impl Iterator<Item = [f32; 2]> {
        (0..128 * 128).map(|i| [(i % 128) as f32 / 128.0 + 1.0 / 256.0, (i / 128) as f32 / 128.0 + 1.0 / 256.0])
    }

    /// Means over a fine grid against closed forms; a 128 x 128 midpoint grid integrates these to 1e-3.
    #[test]
    fn first_moments_are_right() {
        let n = (128 * 128) as f32;
        let r2 = grid().map(|u| sample_disk(u).length_squared()).sum::<f32>() / n;
        assert!((r2 - 0.5).abs() < 1e-3, "disk {r2}");
        let z = grid().map(|u| sample_cosine_hemisphere(u).z).sum::<f32>() / n;
        assert!((z - 2.0 / 3.0).abs() < 1e-3, "cosine {z}");
        let b = grid().map(|u| sample_triangle(u)[0]).sum::<f32>() / n;
        assert!((b - 1.0 / 3.0).abs() < 1e-3, "triangle {b}");
        let z2 = grid().map(|u| sample_sphere(u).z.powi(2)).sum::<f32>() / n;
        assert!((z2 - 1.0 / 3.0).abs() < 1e-3, "sphere {z2}");
        let zc = grid().map(|u| sample_cone(u, 0.2).z).sum::<f32>() / n;
        assert!((zc - 0.9).abs() < 1e-3, "cone {zc}");
    }

    #[test]
    fn shapes_are_filled_by_their_density() {
        let disk = |p: [f32; 2]| if Vec2::from_array(p).length() < 1.0 { f64::from(FRAC_1_PI) } else { 0.0 };
        sampling::places("disk", 1 << 16, [[-1.0, 1.0]; 2], |r| Some(sample_disk(r.numbers()).to_array()), disk);
        let corner = |p: [f32; 2]| if p[0] + p[1] < 1.0 { 2.0 } else { 0.0 };
        sampling::places("triangle", 1 << 16, [[0.0, 1.0]; 2], |r| Some(sample_triangle(r.numbers())), corner);
        let even = |_: [f32; 3]| SPHERE_PDF.into();
        sampling::directions("sphere", 1 << 16, |r| Some(sample_sphere(r.numbers()).to_array()), even);
        let cosine = |d: [f32; 3]| cosine_hemisphere_pdf(d[2]).into();
        let hemisphere = |r: &mut Random| Some(sample_cosine_hemisphere(r.numbers()).to_array());
        sampling::directions("hemisphere", 1 << 16, hemisphere, cosine);
        for one_minus_cos in [0.02, 0.5, 1.7] {
            let sample = |r: &mut Random| Some(sample_cone(r.numbers(), one_minus_cos).to_array());
            let inside = |d: [f32; 3]| if d[2] > 1.0 - one_minus_cos { cone_pdf(one_minus_cos).into() } else { 0.0 };
            sampling::directions(&format!("cone of {one_minus_cos}"), 1 << 16, sample, inside);
        }
        for filter in [Filter::Box, Filter::Gaussian(0.7), Filter::BlackmanHarris(1.5), Filter::BlackmanHarris(0.01)] {
            let table = PixelFilter::new(filter);
            let reach = f64::from(table.reach());
            let sample = |r: &mut Random| Some(table.sample(r.numbers::<1>()[0]).into());
            let density = |x: f64| table.density(x as f32).into();
            sampling::values(&format!("{filter:?}"), 1 << 16, [-reach, reach], sample, density);
        }
    }

    #[test]
    fn frames_are_orthonormal() {
        for u in grid().step_by(37) {
            let n = sample_sphere(u);
            let [t, b, n] = frame(n);
            assert!(t.dot(b).abs() < 1e-5 && t.dot(n).abs() < 1e-5 && b.dot(n).abs() < 1e-5);
            assert!((t.cross(b) - n).length() < 1e-5);
        }
    }

    #[test]
    fn the_filter_is_centred_and_bounded() {
        let filter = PixelFilter::new(Filter::BlackmanHarris(1.5));
        let mean: f32 = (0..1000).map(|i| filter.sample((i as f32 + 0.5) / 1000.0)).sum::<f32>() / 1000.0;
        assert!(mean.abs() < 1e-4);
        assert!(filter.sample(0.0) >= -1.5 && filter.sample(0.999_999) <= 1.5);
        // A window narrower than its support: half of the weight within about a quarter of the width.
        assert!(filter.sample(0.75) < 0.4);
        assert!((PixelFilter::new(Filter::Box).sample(0.25) + 0.25).abs() < 1e-6);
    }
}
