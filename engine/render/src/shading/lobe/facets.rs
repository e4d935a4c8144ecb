//! Facets that mirror and bend: GGX and Beckmann, round or stretched along the tangent.
//!
//! All directions in the lobe's own frame, +z its normal.

use super::super::beckmann;
use super::super::energy;
use super::super::fresnel::{self, F82Tint};
use super::super::microfacet::{MIRROR_BELOW, reflect, refract};
use super::super::thin_film::RelativeFilm;
use super::LobeDirection;
use crate::Rgb;
use crate::scene::closure::Distribution;
use glam::Vec3A;
use std::f32::consts::{PI, TAU};

/// The distribution of microfacets: GGX (Walter et al. 2007) or Beckmann's, `alpha` wide along x and y.
#[derive(Clone, Copy, Debug)]
pub(in crate::shading) struct Slopes {
    alpha: [f32; 2],
    distribution: Distribution,
}

impl Slopes {
    pub(in crate::shading) fn new(alpha: [f32; 2], distribution: Distribution) -> Self {
        Self { alpha: alpha.map(|a| a.clamp(0.0, 1.0)), distribution }
    }

    #[inline(always)]
    fn is_beckmann(&self) -> bool {
        self.distribution == Distribution::Beckmann
    }

    /// The perceptual roughness of round facets that are as wide on the whole.
    fn roughness(&self) -> f32 {
        (self.alpha[0] * self.alpha[1]).sqrt().sqrt()
    }

    fn is_mirror(&self) -> bool {
        self.alpha[0] * self.alpha[1] < MIRROR_BELOW * MIRROR_BELOW
    }

    /// Density of facets about `h`, per steradian and unit area.
    fn density(&self, h: Vec3A) -> f32 {
        let [ax, ay] = self.alpha;
        let (x, y) = (h.x / ax, h.y / ay);
        let slope2 = x * x + y * y;
        if self.is_beckmann() {
            let cos2 = h.z * h.z;
            (-slope2 / cos2).exp() / (PI * ax * ay * cos2 * cos2)
        } else {
            let t = h.z * h.z + slope2;
            1.0 / (PI * ax * ay * t * t)
        }
    }

    /// Smith's lambda: the area of the facets that are hidden from `w` over that of the visible ones.
    fn lambda(&self, w: Vec3A) -> f32 {
        let [ax, ay] = self.alpha;
        let (x, y) = (ax * w.x, ay * w.y);
        let slope2 = (x * x + y * y) / (w.z * w.z);
        if !self.is_beckmann() {
            return 0.5 * ((1.0 + slope2).sqrt() - 1.0);
        }
        // Walter's rational fit.
        let a = 1.0 / slope2.sqrt();
        if a < 1.6 { (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a) } else { 0.0 }
    }

    /// Area of the facets visible from `w`, projected along `w`, over that of the surface, for a `w` of that [`Slopes::lambda`]. Beckmann's
    /// is exact, where `lambda` is a fit: it normalizes the density of [`Slopes::sample`].
    fn visible_area(&self, w: Vec3A, lambda: f32) -> f32 {
        if !self.is_beckmann() {
            return w.z * (1.0 + lambda);
        }
        let [ax, ay] = self.alpha;
        beckmann::visible_area(Vec3A::new(ax * w.x, ay * w.y, w.z))
    }

    /// The normal of a facet visible from `wo`.
    fn sample(&self, wo: Vec3A, u: [f32; 2]) -> Vec3A {
        let [ax, ay] = self.alpha;
        let stretched = Vec3A::new(ax * wo.x, ay * wo.y, wo.z).normalize();
        if self.is_beckmann() {
            let [x, y] = beckmann::sample_slopes(stretched, u);
            return Vec3A::new(-ax * x, -ay * y, 1.0).normalize();
        }
        let (sin, cos) = (TAU * u[0]).sin_cos();
        // A spherical cap seen from the stretched direction (Dupuy and Benyoub 2023).
        let z = (1.0 - u[1]) * (1.0 + stretched.z) - stretched.z;
        let r = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let h = Vec3A::new(r * cos, r * sin, z) + stretched;
        Vec3A::new(ax * h.x, ay * h.y, h.z.max(0.0)).normalize_or(Vec3A::Z)
    }
}

/// The parts of light that a facet reflects and transmits.
#[derive(Clone, Copy, Debug)]
pub(in crate::shading) enum Fresnel {
    /// All, as far as it is not refracted.
    Mirror,
    /// All light is transmitted; totally reflected light is lost.
    Through,
    /// A dielectric's by Fresnel's law, each part with a tint.
    Dielectric { f0: Rgb, reflection: Rgb, transmission: Rgb },
    /// A metal of two colours.
    Tinted(F82Tint),
    /// A metal's index of refraction and extinction coefficient.
    Conductor([Rgb; 2]),
    /// A film's over metal.
    Film(RelativeFilm),
    /// A film's over a dielectric.
    FilmedDielectric { film: RelativeFilm, f0: Rgb, reflection: Rgb, transmission: Rgb },
}

impl Fresnel {
    /// Reflectance and transmittance at that cosine, into relative index `eta`.
    pub(in crate::shading) fn at(&self, cos: f32, eta: f32) -> (Rgb, Rgb) {
        match *self {
            Self::Mirror => (Rgb::ONE, Rgb::ZERO),
            Self::Through => {
                let passes = fresnel::dielectric(cos, eta) < 1.0;
                (Rgb::ZERO, if passes { Rgb::ONE } else { Rgb::ZERO })
            }
            Self::Dielectric { f0, reflection, transmission } => {
                let f = f0 + (Rgb::ONE - f0) * fresnel::dielectric_rise(cos, eta);
                (f * reflection, (Rgb::ONE - f) * transmission)
            }
            Self::Tinted(metal) => (metal.at(cos), Rgb::ZERO),
            Self::Film(film) => (film.at(cos), Rgb::ZERO),
            Self::FilmedDielectric { film, f0, reflection, transmission } => {
                let f = film.tinted(cos, fresnel::f0_from_ior(eta), f0);
                (f * reflection, (Rgb::ONE - f) * transmission)
            }
            Self::Conductor([n, k]) => (fresnel::conductor(cos, n, k), Rgb::ZERO),
        }
    }
}

/// A lobe of facets seen from one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facets {
    slopes: Slopes,
    fresnel: Fresnel,
    /// Index of refraction beyond the surface over that before it.
    pub(super) eta: f32,
    lambda_o: f32,
    /// [`Slopes::visible_area`] from the direction of the view.
    visible_area: f32,
}

impl Facets {
    pub(super) fn new(slopes: Slopes, fresnel: Fresnel, eta: f32, wo: Vec3A) -> Self {
        let mut made = Self { slopes, fresnel, eta, lambda_o: 0.0, visible_area: wo.z };
        made.look_from(wo);
        made
    }

    /// Computes the masking from `wo`, of facets that are no mirror.
    fn look_from(&mut self, wo: Vec3A) {
        if !self.slopes.is_mirror() {
            self.lambda_o = self.slopes.lambda(wo);
            self.visible_area = self.slopes.visible_area(wo, self.lambda_o);
        }
    }

    /// Makes the facets at least so wide along both axes.
    pub(super) fn widen(&mut self, alpha: f32, wo: Vec3A) {
        self.slopes.alpha = self.slopes.alpha.map(|own| own.max(alpha));
        self.look_from(wo);
    }

    /// Albedos of reflection and transmission, seen from `wo`. The weight of those that restore the multiple scattering between facets
    /// holds that, which here is in the table, too.
    pub(super) fn albedos(&self, wo: Vec3A) -> [Rgb; 2] {
        let (cos, roughness) = (wo.z, self.slopes.roughness());
        let (reflected, through) = match self.fresnel {
            Fresnel::Dielectric { f0, reflection, transmission } => {
                let f = f0 + (Rgb::ONE - f0) * energy::rise(self.eta, roughness, cos);
                (f * reflection, (Rgb::ONE - f) * transmission)
            }
            Fresnel::Tinted(metal) => (metal.of(energy::metal_terms(roughness, cos)), Rgb::ZERO),
            Fresnel::Conductor([n, k]) => {
                // Its own curve, and of one that is near it what the tilts of facets change.
                let tinted = fresnel::conductor_as_tinted(n, k);
                let change = tinted.of(energy::metal_terms(roughness, cos)) - tinted.at(cos);
                ((fresnel::conductor(cos, n, k) + change).clamp(Rgb::ZERO, Rgb::ONE), Rgb::ZERO)
            }
            _ => self.fresnel.at(cos, self.eta),
        };
        let kept = match self.slopes.distribution {
            Distribution::MultiscatterGgx if !self.transmits() => energy::reflection().at(roughness, cos),
            Distribution::MultiscatterGgx => energy::boundary(self.eta, roughness, cos).0,
            _ => 1.0,
        };
        [reflected * kept, through * kept]
    }

    pub(super) fn width_squared(&self) -> f32 {
        self.slopes.alpha[0] * self.slopes.alpha[1]
    }

    pub(super) fn reflects(&self) -> bool {
        !matches!(self.fresnel, Fresnel::Through)
    }

    pub(super) fn transmits(&self) -> bool {
        match self.fresnel {
            Fresnel::Through => true,
            Fresnel::Dielectric { transmission, .. } | Fresnel::FilmedDielectric { transmission, .. } => {
                transmission != Rgb::ZERO
            }
            _ => false,
        }
    }

    /// True if the lobe has nothing but single directions.
    pub(super) fn is_mirror(&self) -> bool {
        // Where light passes all but unbent, half vectors are lost to rounding.
        self.slopes.is_mirror() || (self.transmits() && (self.eta - 1.0).abs() < 1e-4)
    }

    /// Value times cosine, and density.
    pub(super) fn evaluate(&self, wo: Vec3A, wi: Vec3A) -> (Rgb, f32) {
        let mirrored = wi.z > 0.0;
        let half = if mirrored { wo + wi } else { -(wi * self.eta + wo) };
        let Some(h) = half.try_normalize() else { return (Rgb::ZERO, 0.0) };
        // Into a thinner medium the half vector of refraction points the other way.
        let h = if h.z < 0.0 { -h } else { h };
        let (co, ci) = (wo.dot(h), wi.dot(h));
        if co <= 0.0 || (ci > 0.0) != mirrored || h.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let (reflected, through) = self.fresnel.at(co, self.eta);
        let (value, share) = if mirrored { (reflected, reflected) } else { (through, through) };
        let (share, total) = (share.element_sum(), (reflected + through).element_sum());
        if share <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let share = share / total;
        // Of facets seen to steradians of `wi`.
        let jacobian = if mirrored { 0.25 / co } else { -ci / (ci + co / self.eta).powi(2) };
        let both = 1.0 + self.lambda_o + self.slopes.lambda(wi);
        // Over the area of all facets that are seen: the density of `Slopes::sample`.
        let seen = self.slopes.density(h) * co * jacobian;
        (value * (seen / (wo.z * both)), share * seen / self.visible_area)
    }

    /// A direction; `u_choice` chooses between mirrored and refracted.
    pub(super) fn sample(&self, wo: Vec3A, u_choice: f32, u: [f32; 2]) -> Option<LobeDirection> {
        let h = if self.is_mirror() { Vec3A::Z } else { self.slopes.sample(wo, u) };
        let cos = wo.dot(h);
        if cos <= 0.0 {
            return None;
        }
        let (reflected, through) = self.fresnel.at(cos, self.eta);
        let total = (reflected + through).element_sum();
        if total <= 0.0 {
            return None;
        }
        let mirrored = u_choice * total < reflected.element_sum();
        let wi = if mirrored { reflect(wo, h) } else { refract(wo, h, self.eta)? };
        let single = self.is_mirror().then(|| self.single(!mirrored, wo));
        Some(LobeDirection { single, ..LobeDirection::of_density(wi, !mirrored) })
    }

    /// The value of a mirror along its mirrored or refracted direction, and the probability of that choice.
    pub(super) fn single(&self, transmitted: bool, wo: Vec3A) -> (Rgb, f32) {
        let (reflected, through) = self.fresnel.at(wo.z, self.eta);
        let total = (reflected + through).element_sum();
        let value = if transmitted { through } else { reflected };
        (value, if total > 0.0 { value.element_sum() / total } else { 0.0 })
    }
}
