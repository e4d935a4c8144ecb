//! Lobes of hair: light about a fibre, wherever it goes.
//!
//! All directions in the fibre's frame: z along it, x across it on the viewer's side.

use crate::Rgb;
use crate::luminance;
use crate::shading::fresnel;
use glam::Vec3A;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_8, LN_2, PI, TAU};

/// Light that a fibre reflects or transmits: a Cauchy distribution about the cone of the mirrored ray (the Hair shader).
#[derive(Clone, Copy, Debug)]
pub(super) struct Fibre {
    through: bool,
    /// Tilt of the cone, radians.
    tilt: f32,
    /// Width of the cone's wall, radians.
    width: f32,
    /// Spread about the fibre.
    spread: f32,
    /// Angle of the view to the plane across the fibre.
    view_rad: f32,
    /// The tangents' angle at the low end of the angles' distribution, and its extent.
    low: f32,
    span: f32,
}

impl Fibre {
    /// `roughness` along and about the fibre.
    pub(super) fn new(through: bool, tilt: f32, roughness: [f32; 2], wo: Vec3A) -> Self {
        let [width, spread] = roughness.map(|r| r.clamp(1e-3, 1.0));
        let view_rad = wo.z.clamp(-1.0, 1.0).asin();
        let end = |end: f32| ((0.5 * (end + view_rad) - tilt) / width).atan();
        let (low, high) = (end(-FRAC_PI_2), end(FRAC_PI_2));
        Self { through, tilt, width, spread, view_rad, low, span: high - low }
    }

    pub(super) fn is_through(&self) -> bool {
        self.through
    }

    /// Value times cosine, which is also the density.
    pub(super) fn evaluate(&self, wi: Vec3A) -> f32 {
        let angle = wi.z.clamp(-1.0, 1.0).asin();
        if FRAC_PI_2 - angle.abs() < 1e-3 {
            return 0.0;
        }
        let from_cone = 0.5 * (angle + self.view_rad) - self.tilt;
        let along = self.width / (2.0 * (from_cone * from_cone + self.width * self.width) * self.span * angle.cos());
        let turn = wi.y.atan2(wi.x).abs();
        let about = if self.through {
            let from_far = PI - turn;
            if from_far > FRAC_PI_2 {
                return 0.0;
            }
            self.spread / (self.turns() * (from_far * from_far + self.spread * self.spread))
        } else {
            // Half of π in single precision is beyond half of π.
            (0.5 * (turn / self.spread).min(PI)).cos().max(0.0) * 0.25 / self.spread
        };
        along * about
    }

    /// The normalization of the distribution about the fibre.
    fn turns(&self) -> f32 {
        2.0 * (FRAC_PI_2 / self.spread).atan()
    }

    pub(super) fn sample(&self, u: [f32; 2]) -> Vec3A {
        let from_cone = self.width * (u[0] * self.span + self.low).tan();
        let angle = 2.0 * (from_cone + self.tilt) - self.view_rad;
        let turn = if self.through {
            PI + self.spread * (self.turns() * (u[1] - 0.5)).tan()
        } else {
            2.0 * (1.0 - 2.0 * u[1]).clamp(-1.0, 1.0).asin() * self.spread
        };
        direction(angle.sin(), angle.cos(), turn)
    }
}

fn direction(sin: f32, cos: f32, turn: f32) -> Vec3A {
    Vec3A::new(cos * turn.cos(), cos * turn.sin(), sin)
}

/// Ways through a fibre: mirrored, straight through, mirrored once inside, and all others together.
const WAYS: usize = 4;

/// Factors of the variances along the fibre, by way: facets that bend light once tilt it half as much as a mirror, and each mirroring
/// inside twice as much.
const VARIANCE_FACTORS: [f32; WAYS] = [1.0, 0.25, 4.0, 4.0];

/// Hair of Chiang, Bitterli, Tappan and Burley 2016 ("A practical and controllable hair and fur model for production path
/// tracing"), for one offset from the fibre's middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chiang {
    /// The part of the light that goes each way, and the probability of choosing that way.
    parts: [(Rgb, f32); WAYS],
    /// Variances along the fibre.
    variances: [f32; WAYS],
    /// Sines and cosines by which the scales turn each.
    tilts: [[f32; 2]; WAYS],
    /// The turns about the fibre of the first three, and the scale of the logistic distribution about these.
    turns: [f32; WAYS - 1],
    scale: f32,
    sin_o: f32,
    cos_o: f32,
}

/// The properties of a fibre.
#[derive(Clone, Copy, Debug)]
pub(in crate::shading) struct FibreShape {
    /// Absorption along a radius, by channel.
    pub(in crate::shading) sigma: Rgb,
    /// Roughness along and about the fibre, 0 to 1.
    pub(in crate::shading) roughness: [f32; 2],
    /// Reduction of the roughness for mirrored light, 0 to 1.
    pub(in crate::shading) coat: f32,
    pub(in crate::shading) ior: f32,
    /// Tilt of the scales, radians.
    pub(in crate::shading) tilt: f32,
    /// -1 to 1: where across its width the fibre is hit.
    pub(in crate::shading) offset: f32,
}

impl Chiang {
    pub(super) fn new(shape: &FibreShape, wo: Vec3A) -> Self {
        let FibreShape { sigma, coat, ior, tilt, .. } = *shape;
        let [along, about] = shape.roughness.map(|r| r.clamp(1e-3, 1.0));
        let mirrored = (along * (1.0 - coat.clamp(0.0, 1.0))).clamp(1e-3, 1.0);
        let (v, v_mirrored) = (variance(along), variance(mirrored));
        let scale = (0.265 * about + 1.194 * about * about + 5.372 * about.powi(22)) * FRAC_PI_8.sqrt();

        let sin_o = wo.z.clamp(-1.0, 1.0);
        let cos_o = across(sin_o);
        let sin_h = shape.offset.clamp(-1.0, 1.0);
        let sin_t = sin_o / ior;
        let sin_h_t = (sin_h * cos_o / (ior * ior - sin_o * sin_o).max(1e-12).sqrt()).clamp(-1.0, 1.0);
        let (gamma_o, gamma_t) = (sin_h.asin(), sin_h_t.asin());
        let through = exp(-sigma * (2.0 * across(sin_h_t) / across(sin_t).max(1e-6)));
        let f = fresnel::dielectric(cos_o * across(sin_h), ior);
        let straight = through * ((1.0 - f) * (1.0 - f));
        let once = straight * through * f;
        let inner = through * f;
        let others = once * inner / (Rgb::ONE - inner).max(Rgb::splat(1e-6));
        let amounts = [Rgb::splat(f), straight, once, others];
        let total: f32 = amounts.iter().map(|&part| luminance(part)).sum();
        let parts = amounts.map(|part| (part, luminance(part) / total.max(1e-30)));

        let turned = |turns: f32| <[f32; 2]>::from((turns * tilt).sin_cos());
        Self {
            parts,
            variances: std::array::from_fn(|way| VARIANCE_FACTORS[way] * if way == 0 { v_mirrored } else { v }),
            tilts: [turned(2.0), turned(-1.0), turned(-4.0), [0.0, 1.0]],
            turns: [0.0, 1.0, 2.0].map(|p| 2.0 * p * gamma_t - 2.0 * gamma_o + p * PI),
            scale,
            sin_o,
            cos_o,
        }
    }

    /// Makes the variances along it and the scale about it at least so large, as Cycles does (`bsdf_hair_chiang_blur` in
    /// bsdf_principled_hair_chiang.h).
    pub(super) fn widen(&mut self, least: f32) {
        for (variance, factor) in self.variances.iter_mut().zip(VARIANCE_FACTORS) {
            *variance = variance.max(factor * least);
        }
        self.scale = self.scale.max(least);
    }

    /// Albedo of the fibre.
    pub(super) fn albedo(&self) -> Rgb {
        self.parts.iter().map(|part| part.0).sum()
    }

    /// Value times cosine, and density.
    pub(super) fn evaluate(&self, wi: Vec3A) -> (Rgb, f32) {
        let sin_i = wi.z.clamp(-1.0, 1.0);
        let cos_i = across(sin_i);
        let turn = wi.y.atan2(wi.x);
        let (mut value, mut pdf) = (Rgb::ZERO, 0.0);
        for (way, &(part, chance)) in self.parts.iter().enumerate() {
            let [s, c] = self.tilts[way];
            let (sin, cos) = (sin_i * c + cos_i * s, (cos_i * c - sin_i * s).abs());
            let along = along_fibre(sin * self.sin_o, cos * self.cos_o, self.variances[way]);
            let about = self.turns.get(way).map_or(1.0 / TAU, |&middle| logistic(wrapped(turn - middle), self.scale));
            value += part * (along * about);
            pdf += chance * along * about;
        }
        (value, pdf)
    }

    /// A sampled direction, and true if it is mirrored. The way is chosen by `u_choice`.
    pub(super) fn sample(&self, u_choice: f32, u: [f32; 2]) -> (Vec3A, bool) {
        let (mut way, mut left) = (0, u_choice);
        while way + 1 < WAYS && left >= self.parts[way].1 {
            left -= self.parts[way].1;
            way += 1;
        }
        let left = (left / self.parts[way].1.max(1e-30)).clamp(1e-5, 1.0);
        let v = self.variances[way];
        let toward = 1.0 + v * (left + (1.0 - left) * (-2.0 / v).exp()).ln();
        let untilted = -toward * self.sin_o + across(toward) * (TAU * u[1]).cos() * self.cos_o;
        let cos = across(untilted);
        let [s, c] = self.tilts[way];
        let (sin_i, cos_i) = (untilted * c - cos * s, (cos * c + untilted * s).abs());
        let turn = self.turns.get(way).map_or(TAU * u[0], |&middle| middle + sample_logistic(u[0], self.scale));
        (direction(sin_i, cos_i, turn), way == 0)
    }
}

/// Variance of the distribution along a fibre of a roughness.
fn variance(roughness: f32) -> f32 {
    (0.726 * roughness + 0.812 * roughness * roughness + 3.7 * roughness.powi(20)).powi(2)
}

pub(super) fn across(sin: f32) -> f32 {
    (1.0 - sin * sin).max(0.0).sqrt()
}

pub(super) fn exp(exponents: Rgb) -> Rgb {
    Rgb::new(exponents.x.exp(), exponents.y.exp(), exponents.z.exp())
}

/// d'Eon's spread along the fibre, from the products of sines and of cosines (d'Eon et al. 2011).
pub(super) fn along_fibre(sines: f32, cosines: f32, variance: f32) -> f32 {
    let inverse = 1.0 / variance;
    let log = log_bessel(cosines * inverse) - sines * inverse;
    if variance <= 0.1 {
        // The hyperbolic sine is half of the exponential.
        (log - inverse + LN_2 + (0.5 * inverse).ln()).exp()
    } else {
        log.exp() / (inverse.sinh() * 2.0 * variance)
    }
}

/// Logarithm of the modified Bessel function of the first kind of order 0.
fn log_bessel(x: f32) -> f32 {
    if x > 12.0 {
        // Abramowitz and Stegun, 9.7.1; the term left out is below 4e-5. (In pbrt and Cycles the first one is halved.)
        let inverse = 1.0 / x;
        return x - 0.5 * (TAU * x).ln() + inverse * (0.125 + 0.0625 * inverse);
    }
    let quarter = 0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    // At 12 the last is less than a millionth of the sum.
    for i in 1..32 {
        term *= quarter / (i * i) as f32;
        sum += term;
        if term < 1e-8 * sum {
            break;
        }
    }
    sum.ln()
}

/// The angle taken to -pi to pi.
fn wrapped(angle: f32) -> f32 {
    angle - TAU * ((angle + PI) / TAU).floor()
}

/// Density of the logistic distribution within -pi to pi.
fn logistic(x: f32, scale: f32) -> f32 {
    let e = (-x.abs() / scale).exp();
    e / (scale * (1.0 + e) * (1.0 + e)) / (1.0 - 2.0 * below(scale))
}

/// The part of the whole distribution below -pi.
fn below(scale: f32) -> f32 {
    1.0 / (1.0 + (PI / scale).exp())
}

fn sample_logistic(u: f32, scale: f32) -> f32 {
    let low = below(scale);
    let part = (u * (1.0 - 2.0 * low) + low).clamp(1e-30, 1.0);
    (-scale * (1.0 / part - 1.0).ln()).clamp(-PI, PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    const SQUARES: [[f32; 2]; 3] = [[0.1, 0.2], [0.3, 0.3], [0.9, 0.6]];

    fn numbers(i: u32) -> [f32; 4] {
        sobol_burley::sample_4d(i, 0, 7)
    }

    fn views() -> impl Iterator<Item = Vec3A> {
        [0.0f32, 0.4, -1.2].into_iter().map(|angle| direction(angle.sin(), angle.cos(), 0.0))
    }

    fn fibres(tilt: f32) -> impl Iterator<Item = Chiang> {
        let shapes = [(-0.9, 0.0), (0.0, 0.0), (0.5, 0.8)].into_iter().flat_map(move |(offset, coat)| {
            let shape = move |roughness| FibreShape { sigma: Rgb::ZERO, roughness, coat, ior: 1.55, tilt, offset };
            SQUARES.map(shape)
        });
        shapes.flat_map(|shape| views().map(move |wo| Chiang::new(&shape, wo)))
    }

    /// The integral over all directions, by their angles along the fibre and about it.
    fn integral(of: impl Fn(Vec3A) -> f32) -> f32 {
        let n = 400;
        let step = |i: u32| (i as f32 + 0.5) / n as f32;
        let part = |i: u32| {
            let (sin, cos) = (PI * step(i / n) - FRAC_PI_2).sin_cos();
            of(direction(sin, cos, TAU * step(i % n) - PI)) * cos
        };
        (0..n * n).map(part).sum::<f32>() * PI * TAU / (n * n) as f32
    }

    /// Light that a white fibre does not absorb comes out, and the density integrates to one.
    #[test]
    fn a_clear_fibre_keeps_all_light() {
        for (tilt, fibre) in [0.0, 0.035].into_iter().flat_map(|tilt| fibres(tilt).map(move |fibre| (tilt, fibre))) {
            let light = integral(|wi| fibre.evaluate(wi).0.x);
            let density = integral(|wi| fibre.evaluate(wi).1);
            // As published, a tilt changes the angle along the fibre and not the measure: that is a few per cent at steep views.
            let most = if tilt == 0.0 { 0.01 } else { 0.09 };
            assert!((light - 1.0).abs() < most && (density - 1.0).abs() < most, "{light} {density} {fibre:?}");
        }
    }

    /// Directions fall where the density says, of fibres that were made wider, too.
    #[test]
    fn samples_follow_their_density() {
        let widened = |mut fibre: Chiang| {
            fibre.widen(0.4);
            fibre
        };
        for fibre in fibres(0.0).flat_map(|fibre| [fibre, widened(fibre)]) {
            sampling::directions(
                &format!("{fibre:?}"),
                1 << 17,
                |random| {
                    let [u_choice, u, v] = random.numbers();
                    Some(fibre.sample(u_choice, [u, v]).0.to_array())
                },
                |wi| fibre.evaluate(Vec3A::from_array(wi)).1.into(),
            );
        }
    }

    #[test]
    fn a_dark_fibre_mirrors_alone() {
        let shape =
            FibreShape { sigma: Rgb::splat(1e6), roughness: [0.3; 2], coat: 0.0, ior: 1.55, tilt: 0.0, offset: 0.3 };
        let fibre = Chiang::new(&shape, Vec3A::X);
        let mirrored = fresnel::dielectric(across(0.3), 1.55);
        assert!((fibre.albedo().x - mirrored).abs() < 1e-6);
        assert!((0..64).all(|i| fibre.sample(numbers(i)[2], [numbers(i)[0], numbers(i)[1]]).1));
    }

    /// The Hair shader's density is that of its directions.
    #[test]
    fn hair_goes_where_its_density_says() {
        for (through, wo, roughness) in [false, true]
            .into_iter()
            .flat_map(|through| views().flat_map(move |wo| SQUARES.map(|roughness| (through, wo, roughness))))
        {
            let fibre = Fibre::new(through, 0.1, roughness, wo);
            sampling::directions(
                &format!("Hair shader, through: {through}, {roughness:?} from {wo}"),
                1 << 17,
                |random| {
                    let wi = fibre.sample(random.numbers());
                    (fibre.evaluate(wi) > 0.0).then(|| wi.to_array())
                },
                |wi| fibre.evaluate(Vec3A::from_array(wi)).into(),
            );
        }
    }
}
