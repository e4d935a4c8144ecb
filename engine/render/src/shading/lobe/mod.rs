//! One lobe of a mixture: its sampled directions, and the light that it scatters.

mod facets;
mod hair;
mod huang;
mod matte;

use super::microfacet::{reflect, refract};
use super::subsurface::{Body, Entry};
use crate::sampler::warp;
use crate::scene::visibility::Rays;
use crate::{Rgb, average};
use facets::Facets;
pub(super) use facets::{Fresnel, Slopes};
use glam::Vec3A;
pub(super) use hair::FibreShape;
use hair::{Chiang, Fibre};
use huang::Huang;
pub(super) use huang::RoughFibre;
use matte::{AshikhminShirley, Microfiber, OrenNayar, Toon, Velvet};
use std::f32::consts::FRAC_1_PI;

/// The scattering model of a lobe.
#[derive(Clone, Copy, Debug)]
enum LobeModel {
    Lambert,
    OrenNayar(OrenNayar),
    /// Lambert's on the far side.
    Translucent,
    Velvet(Velvet),
    Microfiber(Microfiber),
    Toon(Toon),
    AshikhminShirley(AshikhminShirley),
    Facets(Facets),
    Body(Body),
    Fibre(Fibre),
    Chiang(Chiang),
    Huang(Huang),
}

/// A direction that a lobe chose, in its frame.
pub(super) struct LobeDirection {
    /// The direction that the lobe chose, unit.
    pub(super) wi: Vec3A,
    /// True if the direction is meant to go through the surface; a mirrored one that does is lost.
    pub(super) transmitted: bool,
    /// The value of a mirror in that direction, and the probability of that choice within the lobe.
    pub(super) single: Option<(Rgb, f32)>,
    /// The value over the density, of a lobe that does not know the density of its directions.
    pub(super) estimate: Option<Rgb>,
}

impl LobeDirection {
    /// A direction of a lobe that has a density.
    fn of_density(wi: Vec3A, transmitted: bool) -> Self {
        Self { wi, transmitted, single: None, estimate: None }
    }
}

/// One lobe seen from one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// Weight of the lobe.
    pub(super) weight: Rgb,
    /// Probability of the lobe's choice, up to a factor; of all lobes together 1 in the end.
    pub(super) chance: f32,
    frame: [Vec3A; 3],
    /// The view, in the frame.
    wo: Vec3A,
    kind: LobeModel,
}

impl Lobe {
    fn new(weight: Rgb, frame: [Vec3A; 3], wo: Vec3A, kind: impl FnOnce(Vec3A) -> LobeModel) -> Self {
        let wo = warp::to_local(&frame, wo);
        Self { weight, chance: average(weight), frame, wo, kind: kind(wo) }
    }

    pub(super) fn lambert(weight: Rgb, normal: Vec3A, wo: Vec3A) -> Self {
        Self::new(weight, warp::frame(normal), wo, |_| LobeModel::Lambert)
    }

    /// `weight` holds the albedo, too.
    pub(super) fn oren_nayar(weight: Rgb, albedo: Rgb, roughness: f32, normal: Vec3A, wo: Vec3A) -> Self {
        // As smooth as Lambert's.
        if roughness < 1e-5 {
            return Self::lambert(weight, normal, wo);
        }
        let kind = |wo: Vec3A| LobeModel::OrenNayar(OrenNayar::new(albedo, roughness, wo.z));
        Self::new(weight, warp::frame(normal), wo, kind)
    }

    pub(super) fn translucent(weight: Rgb, normal: Vec3A, wo: Vec3A) -> Self {
        Self::new(weight, warp::frame(normal), wo, |_| LobeModel::Translucent)
    }

    pub(super) fn velvet(weight: Rgb, sigma: f32, normal: Vec3A, wo: Vec3A) -> Self {
        Self::new(weight, warp::frame(normal), wo, |_| LobeModel::Velvet(Velvet::new(sigma)))
    }

    /// The lobe of cloth by transformed cosines; `None` if there is nothing to see of it.
    pub(super) fn microfiber(weight: Rgb, roughness: f32, normal: Vec3A, wo: Vec3A) -> Option<Self> {
        let (cloth, albedo) = Microfiber::new(roughness, normal.dot(wo));
        let x = (wo - normal * normal.dot(wo)).normalize_or(warp::frame(normal)[0]);
        let frame = [x, normal.cross(x), normal];
        let lobe = Self::new(weight * albedo, frame, wo, |_| LobeModel::Microfiber(cloth));
        (cloth.is_valid() && albedo > 1e-5).then_some(lobe)
    }

    pub(super) fn toon(weight: Rgb, size: f32, smooth: f32, glossy: bool, normal: Vec3A, wo: Vec3A) -> Self {
        Self::new(weight, warp::frame(normal), wo, |_| LobeModel::Toon(Toon::new(size, smooth, glossy)))
    }

    /// `alpha` along the frame's x and y.
    pub(super) fn ashikhmin_shirley(weight: Rgb, alpha: [f32; 2], frame: [Vec3A; 3], wo: Vec3A) -> Self {
        Self::new(weight, frame, wo, |_| LobeModel::AshikhminShirley(AshikhminShirley::new(alpha)))
    }

    /// A lobe of facets. `albedo` is an approximation of its albedo, for the probability of its choice.
    pub(super) fn facets(
        weight: Rgb,
        albedo: Rgb,
        slopes: Slopes,
        fresnel: Fresnel,
        eta: f32,
        frame: [Vec3A; 3],
        wo: Vec3A,
    ) -> Self {
        let kind = |wo: Vec3A| LobeModel::Facets(Facets::new(slopes, fresnel, eta, wo));
        let lobe = Self::new(weight, frame, wo, kind);
        Self { chance: average(weight * albedo), ..lobe }
    }

    /// `frame`: across the fibre on the viewer's side, and along it.
    pub(super) fn fibre(
        weight: Rgb,
        through: bool,
        tilt: f32,
        roughness: [f32; 2],
        frame: [Vec3A; 3],
        wo: Vec3A,
    ) -> Self {
        Self::new(weight, frame, wo, |wo| LobeModel::Fibre(Fibre::new(through, tilt, roughness, wo)))
    }

    /// `frame` as of [`Lobe::fibre`].
    pub(super) fn chiang(weight: Rgb, shape: &FibreShape, frame: [Vec3A; 3], wo: Vec3A) -> Self {
        let mut albedo = Rgb::ONE;
        let lobe = Self::new(weight, frame, wo, |wo| {
            let fibre = Chiang::new(shape, wo);
            albedo = fibre.albedo();
            LobeModel::Chiang(fibre)
        });
        Self { chance: average(weight * albedo), ..lobe }
    }

    /// `frame` as of [`Lobe::fibre`].
    pub(super) fn huang(weight: Rgb, fibre: &RoughFibre, frame: [Vec3A; 3], wo: Vec3A) -> Self {
        let mut albedo = Rgb::ONE;
        let lobe = Self::new(weight, frame, wo, |wo| {
            let fibre = Huang::new(fibre, wo);
            albedo = fibre.albedo();
            LobeModel::Huang(fibre)
        });
        Self { chance: average(weight * albedo), ..lobe }
    }

    /// `weight` holds the albedo, too.
    pub(super) fn body(weight: Rgb, body: Body, normal: Vec3A, wo: Vec3A) -> Self {
        Self::new(weight, warp::frame(normal), wo, |_| LobeModel::Body(body))
    }

    /// A way into the body, as far as the lobe is one; in world space.
    pub(super) fn enter(&self, u: [f32; 2]) -> Option<Entry> {
        let LobeModel::Body(body) = &self.kind else { return None };
        body.enter(self.weight / self.chance, &self.frame, self.in_world(self.wo), u)
    }

    pub(super) fn normal(&self) -> Vec3A {
        self.frame[2]
    }

    /// Index of refraction beyond the surface over that before it; `None` if the lobe does not refract.
    pub(super) fn relative_index(&self) -> Option<f32> {
        if let LobeModel::Facets(facets) = &self.kind { facets.transmits().then_some(facets.eta) } else { None }
    }

    /// True if any light comes through the surface.
    pub(super) fn transmits(&self) -> bool {
        matches!(self.kind, LobeModel::Translucent) || self.is_hair() || self.relative_index().is_some()
    }

    /// True if the lobe scatters about a fibre, independent of the surface's sides.
    #[inline]
    pub(super) fn is_hair(&self) -> bool {
        matches!(self.kind, LobeModel::Fibre(_) | LobeModel::Chiang(_) | LobeModel::Huang(_))
    }

    /// True if the lobe does not know the density of its directions: these carry their weight ([`LobeDirection::estimate`]).
    pub(super) fn is_estimated(&self) -> bool {
        matches!(self.kind, LobeModel::Huang(_))
    }

    /// True if light that it takes comes out elsewhere.
    pub(super) fn is_body(&self) -> bool {
        matches!(self.kind, LobeModel::Body(_))
    }

    /// True if the lobe has single directions alone.
    pub(super) fn is_mirror(&self) -> bool {
        match &self.kind {
            LobeModel::Facets(facets) => facets.is_mirror(),
            // No light sample can find a way through a body.
            LobeModel::Body(_) => true,
            _ => false,
        }
    }

    /// True if a path that it scatters counts as diffuse.
    pub(super) fn scatters_evenly(&self) -> bool {
        use LobeModel::{Body, Lambert, Microfiber, OrenNayar, Translucent, Velvet};
        match &self.kind {
            Lambert | OrenNayar(_) | Translucent | Velvet(_) | Microfiber(_) | Body(_) => true,
            LobeModel::Toon(toon) => !toon.is_glossy(),
            LobeModel::AshikhminShirley(_) | LobeModel::Facets(_) => false,
            LobeModel::Fibre(_) | LobeModel::Chiang(_) | LobeModel::Huang(_) => false,
        }
    }

    /// The kinds of ray of which a light must reach one to be scattered here. Velvet and even transmission count
    /// otherwise than their paths do.
    pub(super) fn rays(&self) -> Rays {
        match &self.kind {
            LobeModel::Velvet(_) | LobeModel::AshikhminShirley(_) => Rays::GLOSSY,
            LobeModel::Toon(toon) if toon.is_glossy() => Rays::GLOSSY,
            LobeModel::Fibre(fibre) if fibre.is_through() => Rays::TRANSMISSION,
            LobeModel::Fibre(_) => Rays::GLOSSY,
            LobeModel::Chiang(_) | LobeModel::Huang(_) => Rays::GLOSSY.and(Rays::TRANSMISSION),
            LobeModel::Facets(facets) => match (facets.reflects(), facets.transmits()) {
                (_, false) => Rays::GLOSSY,
                (false, true) => Rays::TRANSMISSION,
                (true, true) => Rays::GLOSSY.and(Rays::TRANSMISSION),
            },
            _ => Rays::DIFFUSE,
        }
    }

    /// Albedos of the lobe, mirrors included: in all or of reflection, and of transmission where that is told apart.
    pub(super) fn albedos(&self) -> [Rgb; 2] {
        let both = match &self.kind {
            LobeModel::Facets(facets) => facets.albedos(self.wo),
            LobeModel::Chiang(fibre) => [fibre.albedo(), Rgb::ZERO],
            LobeModel::Huang(fibre) => [fibre.albedo(), Rgb::ZERO],
            _ => [Rgb::ONE, Rgb::ZERO],
        };
        both.map(|albedo| albedo * self.weight)
    }

    /// The product of the widths of facets; 1 for broad lobes.
    pub(super) fn width_squared(&self) -> f32 {
        if let LobeModel::Facets(facets) = &self.kind { facets.width_squared() } else { 1.0 }
    }

    /// Roughness as materials give it, by which Cycles's roughness pass counts the lobe; `None`: it does not count.
    pub(super) fn roughness(&self) -> Option<f32> {
        use LobeModel::{Body, Lambert, Microfiber, Translucent};
        match &self.kind {
            Lambert | Translucent | Microfiber(_) | Body(_) => None,
            LobeModel::Toon(toon) if !toon.is_glossy() => None,
            LobeModel::OrenNayar(lobe) => Some(lobe.roughness()),
            LobeModel::Facets(facets) => Some(facets.width_squared().sqrt().sqrt()),
            _ => Some(1.0),
        }
    }

    /// Makes the lobe at least so wide, of those that Cycles blurs (`bsdf_blur` in bsdf.h): facets and Principled Hair.
    pub(super) fn widen(&mut self, alpha: f32) {
        match &mut self.kind {
            LobeModel::Facets(facets) => facets.widen(alpha, self.wo),
            LobeModel::AshikhminShirley(lobe) => lobe.widen(alpha),
            LobeModel::Chiang(fibre) => fibre.widen(alpha),
            LobeModel::Huang(fibre) => fibre.widen(alpha),
            _ => {}
        }
    }

    /// True if the lobe is broad enough for the shadows of a bent normal to show.
    fn is_matte(&self) -> bool {
        use LobeModel::{Lambert, Microfiber, OrenNayar, Toon, Velvet};
        matches!(self.kind, Lambert | OrenNayar(_) | Velvet(_) | Microfiber(_) | Toon(_))
    }

    /// Weighted value times cosine, and the density of its own choice. `above`: `wi` leaves on the viewer's side of the
    /// triangle, whose smooth normal is `smooth`, with whether a bump on it dims the light that grazes it.
    pub(super) fn evaluate(&self, wi: Vec3A, above: bool, (smooth, dims): (Vec3A, bool)) -> (Rgb, f32) {
        let world = wi;
        let (wo, wi) = (self.wo, warp::to_local(&self.frame, wi));
        if self.is_hair() {
            return self.about_fibre(wi);
        }
        // The triangle itself and the lobe's normal must agree on the side.
        if (wi.z > 0.0) != above || wi.z == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let (value, pdf) = match &self.kind {
            LobeModel::Translucent if !above => {
                let pdf = -wi.z * FRAC_1_PI;
                (Rgb::splat(pdf), pdf)
            }
            LobeModel::Facets(facets) if (above || facets.transmits()) && wo.z > 0.0 && !facets.is_mirror() => {
                facets.evaluate(wo, wi)
            }
            _ if !above => return (Rgb::ZERO, 0.0),
            LobeModel::Lambert => (Rgb::splat(wi.z * FRAC_1_PI), wi.z * FRAC_1_PI),
            LobeModel::OrenNayar(rough) => (rough.evaluate(wo, wi), wi.z * FRAC_1_PI),
            LobeModel::Velvet(velvet) => (Rgb::splat(velvet.evaluate(wo, wi)), Velvet::PDF),
            LobeModel::Microfiber(cloth) => {
                let pdf = cloth.density(wi);
                (Rgb::splat(pdf), pdf)
            }
            LobeModel::Toon(toon) => {
                let (value, pdf) = toon.evaluate(wo, wi);
                (Rgb::splat(value), pdf)
            }
            LobeModel::AshikhminShirley(lobe) if wo.z > 0.0 => {
                let (value, pdf) = lobe.evaluate(wo, wi);
                (Rgb::splat(value), pdf)
            }
            _ => return (Rgb::ZERO, 0.0),
        };
        let lit = if self.is_matte() && self.normal() != smooth {
            terminator(smooth, self.normal(), world, dims)
        } else {
            1.0
        };
        (self.weight * value * lit, pdf)
    }

    #[cold]
    fn about_fibre(&self, wi: Vec3A) -> (Rgb, f32) {
        match &self.kind {
            LobeModel::Fibre(fibre) => {
                let pdf = fibre.evaluate(wi);
                (self.weight * pdf, pdf)
            }
            LobeModel::Chiang(fibre) => {
                let (value, pdf) = fibre.evaluate(wi);
                (self.weight * value, pdf)
            }
            LobeModel::Huang(fibre) => (self.weight * fibre.evaluate(wi), Huang::PDF),
            _ => (Rgb::ZERO, 0.0),
        }
    }

    /// The density of [`Self::evaluate`] alone.
    #[cold]
    pub(super) fn density(&self, wi: Vec3A, above: bool, smooth: (Vec3A, bool)) -> f32 {
        if self.is_estimated() { Huang::PDF } else { self.evaluate(wi, above, smooth).1 }
    }

    /// A direction that the lobe samples; `u_choice` chooses between reflection and refraction.
    pub(super) fn sample(&self, u_choice: f32, u: [f32; 2]) -> Option<LobeDirection> {
        let (wo, broad) = (self.wo, |wi| Some(LobeDirection::of_density(wi, false)));
        match &self.kind {
            LobeModel::Lambert | LobeModel::OrenNayar(_) => broad(warp::sample_cosine_hemisphere(u)),
            LobeModel::Translucent => {
                let wi = -warp::sample_cosine_hemisphere(u);
                Some(LobeDirection::of_density(wi, true))
            }
            LobeModel::Velvet(_) => broad(Velvet::sample(u)),
            LobeModel::Microfiber(cloth) => broad(cloth.sample(u)),
            LobeModel::Toon(toon) => broad(toon.sample(wo, u)),
            LobeModel::AshikhminShirley(lobe) if wo.z > 0.0 => broad(lobe.sample(wo, u)),
            LobeModel::Facets(facets) if wo.z > 0.0 => facets.sample(wo, u_choice, u),
            LobeModel::Fibre(fibre) => Some(LobeDirection::of_density(fibre.sample(u), fibre.is_through())),
            LobeModel::Chiang(fibre) => {
                let (wi, mirrored) = fibre.sample(u_choice, u);
                Some(LobeDirection::of_density(wi, !mirrored))
            }
            LobeModel::Huang(fibre) => {
                let (wi, estimate) = fibre.sample(u_choice, u)?;
                // As in Cycles, all ways count as reflections.
                Some(LobeDirection { wi, transmitted: false, single: None, estimate: Some(estimate) })
            }
            _ => None,
        }
    }

    /// The value of a mirror along `wi`, if that is its direction, and the probability of the choice.
    pub(super) fn single(&self, transmitted: bool, wi: Vec3A) -> Option<(Rgb, f32)> {
        let LobeModel::Facets(facets) = &self.kind else { return None };
        if !facets.is_mirror() || self.wo.z <= 0.0 {
            return None;
        }
        let own = if transmitted { refract(self.wo, Vec3A::Z, facets.eta)? } else { reflect(self.wo, Vec3A::Z) };
        // Both ends of a mirror are known to about a thousandth of a degree.
        let same = self.in_world(own).dot(wi) > 1.0 - 1e-6;
        same.then(|| facets.single(transmitted, self.wo))
    }

    pub(super) fn in_world(&self, d: Vec3A) -> Vec3A {
        warp::to_world(&self.frame, d).normalize()
    }
}

/// The part of light along `wi` that is left where a bump bends the smooth normal to `bent`: the shadows that facets of such slopes cast
/// on each other, without which those of the bumps would end at a hard edge (Conty Estevez, Lecocq and Stein 2019, "A microfacet-based
/// shadowing function to solve the bump terminator problem"). Without `dims` only light from the other side is left out.
fn terminator(smooth: Vec3A, bent: Vec3A, wi: Vec3A, dims: bool) -> f32 {
    let (across, cos) = (smooth.dot(bent), smooth.dot(wi));
    if cos * across * bent.dot(wi) <= 0.0 {
        // It comes from the other side of the surface.
        return 0.0;
    }
    if !dims {
        return 1.0;
    }
    let tangent_squared = |cos: f32| (1.0 - cos * cos).max(0.0) / (cos * cos).max(1e-12);
    let alpha_squared = (0.125 * tangent_squared(across)).min(1.0);
    2.0 / (1.0 + (1.0 + alpha_squared * tangent_squared(cos)).sqrt())
}
