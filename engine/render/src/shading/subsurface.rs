//! Subsurface scattering: the entry of light into a body, and its free paths and scatterings there.

use super::microfacet::{Ggx, refract};
use crate::Rgb;
use crate::sampler::warp;
use crate::scene::closure::SubsurfaceMethod;
use glam::Vec3A;
use std::f32::consts::FRAC_1_PI;

/// The medium in a body, by channel.
#[derive(Clone, Copy, Debug)]
pub struct Medium {
    /// Extinction per Blender unit.
    pub extinction: Rgb,
    /// Albedo of a single scattering.
    pub albedo: Rgb,
    /// Henyey and Greenstein's g.
    pub anisotropy: f32,
}

impl Medium {
    /// The medium that scatters to all sides alike, and looks the same after many scatterings (similarity theory).
    pub fn even(&self) -> Self {
        let scattering = self.albedo * (1.0 - self.anisotropy);
        let kept = Rgb::ONE - self.albedo * self.anisotropy;
        Self { extinction: self.extinction * kept, albedo: scattering / kept, anisotropy: 0.0 }
    }
}

/// Light on its way into a body.
#[derive(Clone, Copy, Debug)]
pub enum Entry {
    /// Light walks through the body.
    Walk {
        /// Direction into the body, unit.
        direction: Vec3A,
        /// Light that the path carries.
        light: Rgb,
        /// The medium of the walk.
        medium: Medium,
    },
    /// Light comes out beside, by a profile.
    Beside {
        /// Light that the path carries.
        light: Rgb,
        /// The distribution of distances, by channel.
        profile: Profile,
        /// Random numbers for distance and direction.
        u: [f32; 2],
    },
}

/// A body that light enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    inside: BodyTransport,
    /// 1 for channels that go far enough in to be told from a surface's, else 0.
    pub(super) channels: Rgb,
}

/// The transport of light in a body.
#[derive(Clone, Copy, Debug)]
enum BodyTransport {
    Walk {
        medium: Medium,
        /// Factor that makes up for channels whose albedo is too low for the walk, over the surface's albedo.
        scale: Rgb,
        ior: f32,
        alpha: f32,
        is_skin: bool,
    },
    Profile(Profile),
}

/// Free paths shorter than this are a surface's, Blender units.
const LEAST_RADIUS: f32 = 1e-8;

/// The free path of Christensen and Burley's profile and of the legacy walk over the radius: 1 / 4 π, as in Cycles
/// (`bssrdf_setup_radius`), so that they look like the older profiles.
const LEGACY_PATH: f32 = 0.25 * FRAC_1_PI;

impl Body {
    /// The body of a surface's albedo and the radius by channel; `None` where no channel has any.
    pub(super) fn new(
        albedo: Rgb,
        radius: Rgb,
        ior: f32,
        roughness: f32,
        anisotropy: f32,
        method: SubsurfaceMethod,
    ) -> Option<Self> {
        let channels = Rgb::from(radius.to_array().map(|r| f32::from(u8::from(r >= LEAST_RADIUS))));
        if channels == Rgb::ZERO {
            return None;
        }
        let ior = ior.clamp(1.01, 3.8);
        let is_skin = method == SubsurfaceMethod::Skin;
        let (free_path, is_fit) = match method {
            SubsurfaceMethod::Burley => {
                let profile = Profile { scale: radius * LEGACY_PATH * channels };
                return Some(Self { inside: BodyTransport::Profile(profile), channels });
            }
            SubsurfaceMethod::RandomWalk => (radius, false),
            // The fit knows no backward scattering.
            SubsurfaceMethod::LegacyWalk => (radius * LEGACY_PATH, anisotropy >= 0.0),
            // Of skin the radius is that of the light that comes out; else it is the free path itself.
            SubsurfaceMethod::Skin => (radius * diffusion(albedo, ior), anisotropy >= 0.0),
        };
        let g = anisotropy.clamp(-0.99, if method == SubsurfaceMethod::RandomWalk { 0.99 } else { 0.9 });
        let mut single = Rgb::ZERO;
        let mut scale = Rgb::ZERO;
        for c in 0..3 {
            let alpha = if is_fit { single_albedo(albedo[c], g) } else { van_de_hulst(albedo[c], g) };
            // A walk of a lower albedo would end at once.
            single[c] = alpha.max(0.2);
            scale[c] = if albedo[c] > 0.0 { alpha / single[c] / albedo[c] } else { 0.0 };
        }
        let extinction = Rgb::ONE / (free_path * if is_fit { 1.0 - g } else { 1.0 }).max(Rgb::splat(1e-16));
        let medium = Medium { extinction, albedo: single, anisotropy: g };
        let alpha = if is_skin { 1.0 } else { roughness * roughness };
        Some(Self { inside: BodyTransport::Walk { medium, scale, ior, alpha, is_skin }, channels })
    }

    /// True if light comes out beside the place where it goes in, by a profile.
    pub(super) fn is_profile(&self) -> bool {
        matches!(self.inside, BodyTransport::Profile(_))
    }

    /// A way in for light that counts `weight`, which holds the surface's albedo; all in world space.
    pub(super) fn enter(&self, weight: Rgb, frame: &[Vec3A; 3], wo: Vec3A, mut u: [f32; 2]) -> Option<Entry> {
        let (medium, scale, ior, alpha, is_skin) = match self.inside {
            BodyTransport::Profile(profile) => return Some(Entry::Beside { light: weight, profile, u }),
            BodyTransport::Walk { medium, scale, ior, alpha, is_skin } => (medium, scale, ior, alpha, is_skin),
        };
        let light = weight * scale;
        let local = if is_skin && u[0] < 0.5 {
            -warp::sample_cosine_hemisphere([2.0 * u[0], u[1]])
        } else {
            if is_skin {
                u[0] = 2.0 * (u[0] - 0.5);
            }
            let wo = warp::to_local(frame, wo);
            if wo.z <= 0.0 {
                return None;
            }
            let facet = Ggx::from_roughness(alpha.sqrt()).sample_visible(wo, u);
            refract(wo, facet, ior)?
        };
        Some(Entry::Walk { direction: warp::to_world(frame, local).normalize(), light, medium })
    }
}

/// Christensen and Burley's profile of the light about the place where it goes in (2015, "Approximate Reflectance Profiles for
/// Efficient Subsurface Scattering", equation 3), cut off as in Cycles (`bssrdf.h`).
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    /// d of the equation by channel, Blender units; 0 where the channel does not take part.
    scale: Rgb,
}

impl Profile {
    /// Beyond so many d there is no light.
    const CUT: f32 = 16.0;
    /// The part of the light within [`Self::CUT`].
    const WITHIN: f32 = 0.996_379;

    /// A distance by a channel that a uniform number chooses, and the farthest there is for the channel.
    pub(crate) fn sample(&self, u: f32) -> (f32, f32) {
        let scales = self.scale.to_array();
        let count = scales.iter().filter(|&&d| d > 0.0).count();
        let at = u * count as f32;
        let number = (at as usize).min(count.saturating_sub(1));
        let d = scales.into_iter().filter(|&d| d > 0.0).nth(number).unwrap_or(0.0);
        (d * distance_within((at - number as f32) * Self::WITHIN), d * Self::CUT)
    }

    /// The light at a distance, per unit of it, by channel.
    pub(crate) fn at(&self, distance: f32) -> Rgb {
        let one = |d: f32| {
            if d <= 0.0 || distance >= Self::CUT * d {
                return 0.0;
            }
            let third = (-distance / (3.0 * d)).exp();
            (third * third * third + third) / (4.0 * d * Self::WITHIN)
        };
        Rgb::from(self.scale.to_array().map(one))
    }

    /// Probability density of [`Profile::sample`].
    pub(crate) fn pdf(&self, distance: f32) -> f32 {
        let count = self.scale.to_array().iter().filter(|&&d| d > 0.0).count();
        self.at(distance).element_sum() / count.max(1) as f32
    }
}

/// The distance in d within which that part of the light is: the inverse of 1 − e^−r / 4 − 3 e^(−r/3) / 4. With x = e^(−r/3) it is the
/// root of x³ + 3 x = 4 (1 − u), by Cardano's formula.
fn distance_within(u: f32) -> f32 {
    let half = 2.0 * (1.0 - u);
    let root = (half + (half * half + 1.0).sqrt()).cbrt();
    -3.0 * (root - 1.0 / root).max(f32::MIN_POSITIVE).ln()
}

/// The albedo of a single scattering with which a half space has that albedo (van de Hulst's approximation, inverted).
fn van_de_hulst(albedo: f32, g: f32) -> f32 {
    let a = albedo.clamp(0.0, 1.0);
    let s = 4.09712 + 4.20863 * a - (9.59217 + 41.6808 * a + 17.7126 * a * a).sqrt();
    ((1.0 - s * s) / (1.0 - g * s * s)).clamp(0.0, 0.999_999)
}

/// The albedo of a single scattering with which a body of many scatterings has that albedo: Chiang, Kutz and Burley's
/// fit for all g.
fn single_albedo(albedo: f32, g: f32) -> f32 {
    let a = albedo.clamp(0.0, 1.0);
    let sum = |c: [f32; 8]| c.iter().rev().fold(0.0, |s, c| s * g + c);
    let p = sum([1.826_052_4, -1.284_510_6, -1.799_046_3, 9.193_933, -22.821_56, 32.023_487, -23.626_48, 7.210_67]);
    let q = 4.985_112
        + 0.127_355_96
            * sum([0.0, 31.149_158, -201.847_02, 841.576, -2_018.092_9, 2_731.715_6, -1_935.414_2, 559.009_05]).exp();
    let r = sum([1.096_861, -0.394_704_06, 1.052_581_2, -8.839_637, 28.864_323, -46.880_29, 38.540_284, -12.718_104]);
    let s = sum([0.496_310_2, 0.360_146_58, -2.151_393, 17.889_69, -55.298_4, 82.065_98, -58.510_6, 15.847_83]);
    let t = 4.231_903
        + 0.003_106_039_5
            * sum([0.0, 76.731_63, -594.356_8, 2_448.883_4, -5_576.685, 7_116.602, -4_763.545, 1_303.531_8]).exp();
    let v = sum([2.406_03, -2.518_148_4, 9.184_949, -79.219_17, 259.082_87, -403.613_8, 302.857_12, -87.437_05]);
    let blend = a.powf(0.25);
    let alpha = (1.0 - blend) * p * (q * a).atan().powf(r) + blend * s * (t * a).atan().powf(v);
    alpha.clamp(0.0, 0.999_999)
}

/// The free path of skin over its radius: the diffusion length of a dipole of that albedo (Jensen et al. 2001).
fn diffusion(albedo: Rgb, ior: f32) -> Rgb {
    let inverse = 1.0 / ior;
    let internal = inverse * (-1.44 * inverse + 0.71) + 0.668 + 0.0636 * ior;
    let boundary = 4.0 / 3.0 * (1.0 + internal) / (1.0 - internal);
    let reflected = |a: f32| {
        let s = (3.0 * (1.0 - a)).sqrt();
        0.5 * a * (1.0 + (-boundary * s).exp()) * (-s).exp()
    };
    let one = |albedo: f32| {
        let (mut low, mut high) = (0.0f32, 1.0f32);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            if reflected(middle) < albedo { low = middle } else { high = middle }
        }
        (3.0 * (1.0 - 0.5 * (low + high))).max(1e-6).sqrt()
    };
    Rgb::new(one(albedo.x), one(albedo.y), one(albedo.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    /// Distances of samples follow the profile, of one channel and of three that reach differently far.
    #[test]
    fn distances_follow_their_density() {
        for scale in [Rgb::new(0.0, 1.0, 0.0), Rgb::new(1.0, 0.3, 0.05)] {
            let profile = Profile { scale };
            let sample = |random: &mut sampling::Random| Some(profile.sample(random.numbers::<1>()[0]).0.into());
            let density = |distance: f64| profile.pdf(distance as f32).into();
            sampling::values(&format!("profile of {scale}"), 1 << 16, [0.0, 16.0], sample, density);
        }
    }

    /// The brighter a body, the whiter its medium; and black and white stay the same.
    #[test]
    fn single_albedos_rise_with_the_bodys() {
        type Fit = fn(f32, f32) -> f32;
        let cases: [(Fit, &[f32]); 2] = [(van_de_hulst, &[-0.5, 0.0, 0.5]), (single_albedo, &[0.0, 0.5])];
        for (fit, all_g) in cases {
            for &g in all_g {
                // The fits are off by about this at their ends.
                assert!(
                    fit(0.0, g).abs() < 0.01 && (fit(1.0, g) - 1.0).abs() < 0.01,
                    "{} {}",
                    fit(0.0, g),
                    fit(1.0, g)
                );
                // Near white one of them is held just below 1.
                for i in 0..18 {
                    let (a, b) = (i as f32 / 20.0, (i + 1) as f32 / 20.0);
                    assert!(fit(a, g) < fit(b, g), "{a} at {g}");
                }
            }
        }
    }

    /// The even medium absorbs as much, and turns as much of the light.
    #[test]
    fn an_even_medium_is_alike() {
        let medium = Medium { extinction: Rgb::new(1.0, 2.0, 9.0), albedo: Rgb::new(0.5, 0.9, 0.99), anisotropy: 0.7 };
        let even = medium.even();
        let absorbs = |m: &Medium| m.extinction * (Rgb::ONE - m.albedo);
        let turns = |m: &Medium| m.extinction * m.albedo * (1.0 - m.anisotropy);
        assert!((absorbs(&medium) - absorbs(&even)).abs().max_element() < 1e-5);
        assert!((turns(&medium) - turns(&even)).abs().max_element() < 1e-5 && even.anisotropy == 0.0);
    }

    /// The distances of a profile have the density that it says, which adds up to 1.
    #[test]
    fn distances_of_a_profile_follow_it() {
        let profile = Profile { scale: Rgb::new(0.3, 0.0, 1.5) };
        let n = 20_000;
        let distances: Vec<f32> = (0..n).map(|i| profile.sample((i as f32 + 0.5) / n as f32).0).collect();
        let mut sum = 0.0;
        let step = 0.01;
        for i in 0..2400 {
            let below = distances.iter().filter(|&&r| r < step * i as f32).count() as f32 / n as f32;
            // Sums of steps of 0.01 by the midpoint; the profile's slope at 0 is 1 / d².
            assert!((below - sum).abs() < 2e-3, "{i}: {below} {sum}");
            sum += profile.pdf((i as f32 + 0.5) * step) * step;
        }
        assert!((sum - 1.0).abs() < 2e-3, "{sum}");
        assert_eq!(profile.at(0.1).y, 0.0);
    }
}
