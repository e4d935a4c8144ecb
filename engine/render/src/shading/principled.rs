//! Blender's Principled BSDF (4.x, 5.x): metal, glass, and a dielectric coat over a diffuse base, mixed in the
//! order and with the energy bookkeeping that Cycles has, so that scenes look alike in both.

use super::albedo::{AlbedoTable, give_back};
use super::energy;
use super::fresnel::{self, F82Tint};
use super::microfacet::{Ggx, reflect, refract};
use super::parted::MeanSums;
use super::{BsdfSample, Caustics, Features, LobeDecomposition, LobeShares, Scattering, SurfaceMeans, normal};
use crate::sampler::warp;
use crate::scene::plain::{Plain, PlainValues};
use crate::scene::visibility::Rays;
use crate::surface::SurfacePoint;
use crate::{Rgb, average};
use glam::{Vec3A, Vec4};
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

/// Tables of a plain surface, which depend on its index of refraction alone: made once for each index in a scene.
#[derive(Clone, Debug)]
pub struct PrincipledTables {
    /// Relative index of the specular coat, after the specular level.
    coat_eta: f32,
    /// Reflectance of the coat at normal incidence, before the tint.
    coat_f0: f32,
    ior: f32,
    /// True if the base is coated, as in [`Plain`].
    is_coated: bool,
    reflection: Arc<AlbedoTable>,
    coat: AlbedoTable,
    // Entering and leaving; `None` where nothing is transmitted.
    boundary: Option<[AlbedoTable; 2]>,
}

impl PrincipledTables {
    /// `reflection` is [`AlbedoTable::reflection`], shared by all.
    pub fn new(plain: &Plain, reflection: Arc<AlbedoTable>) -> Self {
        let ior = plain.ior;
        let mut coat_f0 = fresnel::f0_from_ior(ior);
        let mut coat_eta = ior;
        if plain.specular_ior_level != 0.5 {
            coat_f0 = (coat_f0 * 2.0 * plain.specular_ior_level).min(0.99);
            let eta = fresnel::ior_from_f0(coat_f0);
            coat_eta = if ior < 1.0 { 1.0 / eta } else { eta };
        }
        Self {
            coat_eta,
            coat_f0,
            ior,
            is_coated: plain.is_coated,
            reflection,
            coat: AlbedoTable::dielectric_reflection(coat_eta),
            boundary: plain.may_transmit.then(|| [ior, 1.0 / ior].map(AlbedoTable::dielectric_boundary)),
        }
    }

    /// A key that is the same for plain surfaces with the same tables.
    pub fn key(plain: &Plain) -> (u32, u32, bool, bool) {
        (plain.ior.to_bits(), plain.specular_ior_level.to_bits(), plain.may_transmit, plain.is_coated)
    }
}

/// The BSDF of one point seen from one direction.
#[derive(Clone)]
pub struct Bsdf {
    /// Axes about the normal of the facets, where there are any, else of the diffuse base.
    frame: [Vec3A; 3],
    /// The normal of the diffuse base in these axes. That of facets is turned, where a mirror would send light into the surface.
    base_normal: Vec3A,
    geometric_normal: Vec3A,
    /// Cosine of `wo` to the normal.
    cos_o: f32,
    eta: f32,
    diffuse: Rgb,
    // Chance of each lobe: metal, glass, coat, diffuse.
    chance: [f32; 4],
    /// The lobes of facets; `None` if the surface is diffuse only, as most are.
    facets: Option<FacetData>,
}

/// The data of lobes of facets.
#[derive(Clone)]
struct FacetData {
    ggx: Ggx,
    /// The view in the axes of the frame.
    wo: Vec3A,
    /// [`Ggx::lambda`] of the view `wo`.
    lambda_o: f32,
    metal: F82Tint,
    metal_weight: Rgb,
    glass_weight: Rgb,
    glass_tint: Rgb,
    glass_reflection_tint: Rgb,
    coat_weight: f32,
    coat_f0: Rgb,
    coat_eta: f32,
}

impl Bsdf {
    /// The BSDF at a point; `wo` is the unit direction back along the path. `values.weight` is not in it: [`Self::scale`].
    #[inline]
    pub fn new(tables: &PrincipledTables, values: &PlainValues, point: &SurfacePoint, wo: Vec3A) -> Self {
        Self::with_caustics(tables, values, point, wo, Caustics::ALL)
    }

    /// The BSDF without those lobes that mirror or refract light, where caustics are left out.
    #[inline]
    pub fn with_caustics(
        tables: &PrincipledTables,
        values: &PlainValues,
        point: &SurfacePoint,
        wo: Vec3A,
        caustics: Caustics,
    ) -> Self {
        let has_facets = values.metallic > 0.0 || values.transmission > 0.0 || tables.is_coated;
        let normal = if has_facets {
            normal::reflecting(point.geometric_normal, point.shading_normal, wo)
        } else {
            point.shading_normal
        };
        let frame = warp::frame(normal);
        let is_turned = normal != point.shading_normal;
        let mut bsdf = Self {
            frame,
            base_normal: if is_turned { warp::to_local(&frame, point.shading_normal) } else { Vec3A::Z },
            geometric_normal: point.geometric_normal,
            cos_o: normal.dot(wo),
            eta: if point.backfacing { 1.0 / tables.ior } else { tables.ior },
            diffuse: values.base_color,
            chance: [0.0, 0.0, 0.0, 1.0],
            facets: None,
        };
        if has_facets {
            bsdf.add_facets(tables, values, point.backfacing, warp::to_local(&frame, wo), caustics);
        } else if average(bsdf.diffuse) <= 0.0 {
            bsdf.chance = [0.0; 4];
        }
        bsdf
    }

    /// Metal, glass and coat, and the light that they leave to the diffuse base.
    fn add_facets(
        &mut self,
        tables: &PrincipledTables,
        values: &PlainValues,
        backfacing: bool,
        wo: Vec3A,
        Caustics { reflective, refractive }: Caustics,
    ) {
        let cos = wo.z.max(1e-4);
        let ggx = Ggx::from_roughness(values.roughness);
        let r = values.roughness;
        // A diffuse base alone may be brighter than white, as in Cycles.
        let base = values.base_color.min(Rgb::ONE);
        let dielectric = 1.0 - values.metallic;
        let opaque = dielectric * (1.0 - values.transmission);
        let has_coat = tables.is_coated && opaque > 0.0 && reflective;
        // What single scattering loses is given back in proportion.
        let (single, mean) = if values.metallic > 0.0 || has_coat {
            (tables.reflection.at(r, cos), tables.reflection.average(r))
        } else {
            (1.0, 1.0)
        };
        let restored = |fresnel_average: Rgb| give_back(fresnel_average, single, mean);

        let (mut metal, mut metal_weight, mut metal_chance) = (F82Tint::default(), Rgb::ZERO, 0.0);
        if values.metallic > 0.0 && reflective {
            metal = F82Tint::new(base, Rgb::ONE);
            metal_weight = restored(metal.average()) * values.metallic;
            metal_chance = average(metal.at(cos)) * values.metallic;
        }

        let glass_chance = if reflective || refractive { dielectric * values.transmission } else { 0.0 };
        let (mut glass_weight, mut glass_tint) = (Rgb::ZERO, Rgb::ZERO);
        if glass_chance > 0.0 {
            glass_tint = Rgb::from(base.to_array().map(f32::sqrt));
            // What passes is most of it.
            let restored = tables.boundary.as_ref().map_or(Rgb::ONE, |b| {
                let table = &b[usize::from(backfacing)];
                give_back(glass_tint, table.at(r, cos), table.average(r))
            });
            glass_weight = restored * glass_chance;
            if !refractive {
                glass_tint = Rgb::ZERO;
            }
        }

        let (mut coat_weight, mut coat_albedo) = (0.0, 0.0);
        if has_coat {
            let give_back = restored(Rgb::splat(fresnel::dielectric_average(tables.coat_eta))).x;
            coat_weight = opaque * give_back;
            coat_albedo = (tables.coat.at(r, cos) * give_back).min(1.0);
        }
        self.diffuse = values.base_color * (opaque * (1.0 - coat_albedo));
        let chance = Vec4::new(metal_chance, glass_chance, coat_albedo * opaque, average(self.diffuse));
        let total = (chance.x + chance.y) + (chance.z + chance.w);
        self.chance = if total > 0.0 { (chance / total).to_array() } else { [0.0; 4] };
        self.facets = Some(FacetData {
            ggx,
            wo,
            lambda_o: ggx.lambda(wo),
            metal,
            metal_weight,
            glass_weight,
            glass_tint,
            glass_reflection_tint: if reflective { Rgb::ONE } else { Rgb::ZERO },
            coat_weight,
            coat_f0: Rgb::splat(tables.coat_f0).min(Rgb::ONE),
            coat_eta: tables.coat_eta,
        });
    }

    /// Multiplies all that the BSDF scatters.
    #[inline]
    pub fn scale(&mut self, factor: f32) {
        if factor == 1.0 {
            return;
        }
        self.diffuse *= factor;
        if factor <= 0.0 {
            self.chance = [0.0; 4];
        }
        if let Some(f) = &mut self.facets {
            f.metal_weight *= factor;
            f.glass_weight *= factor;
            f.coat_weight *= factor;
        }
    }

    /// Makes facets at least so wide. Their albedos, and the probabilities of the lobes, stay those of their own width, as in Cycles
    /// (`bsdf_blur` in bsdf.h).
    pub fn widen(&mut self, alpha: f32) {
        let Some(f) = self.facets.as_mut().filter(|f| f.ggx.width() < alpha) else { return };
        // Where glass passes light all but unbent, half vectors would be lost to rounding.
        if f.ggx.is_mirror() && f.glass_weight != Rgb::ZERO && (self.eta - 1.0).abs() < 1e-4 {
            return;
        }
        f.ggx = Ggx::of_width(alpha);
        f.lambda_o = f.ggx.lambda(f.wo);
    }

    /// Keeps only the lobes that light of these kinds reaches; the probabilities of the others are lost.
    fn keep(&mut self, rays: Rays) {
        if !rays.any_of(Rays::DIFFUSE) {
            (self.diffuse, self.chance[3]) = (Rgb::ZERO, 0.0);
        }
        let Some(f) = &mut self.facets else { return };
        if !rays.any_of(Rays::GLOSSY) {
            (f.metal_weight, f.coat_weight, self.chance[0], self.chance[2]) = (Rgb::ZERO, 0.0, 0.0, 0.0);
        }
        if !rays.any_of(Rays::GLOSSY.and(Rays::TRANSMISSION)) {
            (f.glass_weight, self.chance[1]) = (Rgb::ZERO, 0.0);
        }
    }

    /// Albedos of metal, glass, glass on its far side, and coat.
    fn facet_albedos(&self) -> [Rgb; 4] {
        let Some(f) = &self.facets else { return [Rgb::ZERO; 4] };
        let (roughness, cos) = (f.ggx.width().sqrt(), f.wo.z.max(0.0));
        let kept = energy::reflection().at(roughness, cos);
        let passing = if f.glass_weight == Rgb::ZERO { 1.0 } else { energy::boundary(self.eta, roughness, cos).0 };
        let rise = |eta: f32| energy::rise(eta, roughness, cos);
        let f0 = fresnel::f0_from_ior(self.eta);
        let mirrored = f0 + (1.0 - f0) * if f.glass_weight == Rgb::ZERO { 0.0 } else { rise(self.eta) };
        let coat = if f.coat_weight > 0.0 { f.coat_f0 + (Rgb::ONE - f.coat_f0) * rise(f.coat_eta) } else { Rgb::ZERO };
        [
            f.metal.of(energy::metal_terms(roughness, cos)) * f.metal_weight * kept,
            f.glass_reflection_tint * f.glass_weight * (mirrored * passing),
            f.glass_tint * f.glass_weight * ((1.0 - mirrored) * passing),
            coat * (f.coat_weight * kept),
        ]
    }

    fn evaluate_local(&self, wi: Vec3A, above: bool) -> (Rgb, f32) {
        let mut value = Rgb::ZERO;
        let mut pdf = 0.0;
        // The triangle itself and its interpolated normal must agree on the side.
        if above {
            let cos = self.base_normal.dot(wi);
            if self.chance[3] > 0.0 && cos > 0.0 {
                value += self.diffuse * (cos * FRAC_1_PI);
                pdf += self.chance[3] * warp::cosine_hemisphere_pdf(cos);
            }
            if wi.z > 0.0
                && let Some(f) = self.rough_facets()
            {
                let h = (f.wo + wi).normalize_or(Vec3A::Z);
                let cos = f.wo.dot(h);
                if cos > 0.0 {
                    let facets = f.ggx.density(h) / (4.0 * f.wo.z);
                    let (reflected, reflects) = self.reflected(f, cos);
                    value += reflected * (facets / (1.0 + f.lambda_o + f.ggx.lambda(wi)));
                    pdf += reflects * facets / (1.0 + f.lambda_o);
                }
            }
        } else if wi.z < 0.0
            && self.chance[1] > 0.0
            && let Some(f) = self.rough_facets()
        {
            let half = wi * self.eta + f.wo;
            if let Some(h) = half.try_normalize() {
                let h = if h.z < 0.0 { -h } else { h };
                let (co, ci) = (f.wo.dot(h), wi.dot(h));
                if co > 0.0 && ci < 0.0 {
                    let fresnel = fresnel::dielectric(co, self.eta);
                    let jacobian = -ci / (ci + co / self.eta).powi(2);
                    let through = (1.0 - fresnel) * f.ggx.density(h) * co / f.wo.z * jacobian;
                    value += f.glass_tint * (f.glass_weight * through / (1.0 + f.lambda_o + f.ggx.lambda(wi)));
                    pdf += self.chance[1] * through / (1.0 + f.lambda_o);
                }
            }
        }
        (value, pdf)
    }

    /// The facets where a light sample may find them.
    #[inline]
    fn rough_facets(&self) -> Option<&FacetData> {
        self.facets.as_ref().filter(|f| !f.ggx.is_mirror() && self.cos_o > 0.0)
    }

    /// The light that a facet at a cosine reflects in all lobes, and the probability of reflecting there. A material seldom has all lobes.
    #[inline]
    fn reflected(&self, f: &FacetData, cos: f32) -> (Rgb, f32) {
        let mut value = Rgb::ZERO;
        let mut chance = self.chance[0] + self.chance[2];
        if f.metal_weight != Rgb::ZERO {
            value += f.metal.at(cos) * f.metal_weight;
        }
        if f.glass_weight != Rgb::ZERO {
            let fresnel = fresnel::dielectric(cos, self.eta);
            value += f.glass_reflection_tint * (f.glass_weight * fresnel);
            chance += self.chance[1] * fresnel;
        }
        if f.coat_weight > 0.0 {
            value += f.coat_fresnel(cos) * f.coat_weight;
        }
        (value, chance)
    }

    fn finish(&self, wi: Vec3A, transmit: bool, matte: bool) -> Option<BsdfSample> {
        let world = warp::to_world(&self.frame, wi).normalize();
        let above = self.geometric_normal.dot(world) > 0.0;
        // A tilted facet can bend light back to the side it came from, or mirror it below the surface: that
        // light would hit another facet, which the restored energy accounts for.
        if above == transmit || (!matte && (wi.z > 0.0) == transmit) {
            return None;
        }
        let (value, pdf) = self.evaluate_local(wi, above);
        (pdf > 0.0 && value.is_finite() && pdf.is_finite()).then(|| BsdfSample {
            wi: world,
            weight: value / pdf,
            pdf,
            mirror: false,
            transmitted: !above,
            matte,
        })
    }

    /// The sample of a surface that is purely diffuse: value over density is the colour.
    fn finish_lambert(&self, wi: Vec3A) -> Option<BsdfSample> {
        let world = warp::to_world(&self.frame, wi).normalize();
        let seen = wi.z > 0.0 && self.geometric_normal.dot(world) > 0.0;
        let pdf = warp::cosine_hemisphere_pdf(wi.z);
        seen.then_some(BsdfSample {
            wi: world,
            weight: self.diffuse,
            pdf,
            mirror: false,
            transmitted: false,
            matte: true,
        })
    }
}

impl LobeDecomposition for Bsdf {
    #[cold]
    #[inline(never)]
    fn shares(&self, wi: Vec3A, reaches: Rays, is_beyond: bool) -> LobeShares {
        let on = |rays: Rays| {
            let (value, _) = if is_beyond { self.evaluate_smooth(wi, rays) } else { self.evaluate_some(wi, rays) };
            value
        };
        let diffuse = if reaches.any_of(Rays::DIFFUSE) { on(Rays::DIFFUSE) } else { Rgb::ZERO };
        let rest = (on(reaches) - diffuse).max(Rgb::ZERO);
        let is_above = self.frame[2].dot(wi) > 0.0;
        let [glossy, transmission] = if is_above { [rest, Rgb::ZERO] } else { [Rgb::ZERO, rest] };
        LobeShares { diffuse, glossy, transmission }
    }

    #[cold]
    #[inline(never)]
    fn albedos(&self) -> [Rgb; 3] {
        let [metal, glass, through, coat] = self.facet_albedos();
        [self.diffuse, metal + glass + coat, through]
    }

    fn mean_alpha_squared(&self, wi: Vec3A) -> f32 {
        let Some(f) = self.rough_facets() else { return 1.0 };
        let wi = warp::to_local(&self.frame, wi);
        let (_, pdf) = self.evaluate_local(wi, wi.z > 0.0);
        let diffuse = self.chance[3] * warp::cosine_hemisphere_pdf(self.base_normal.dot(wi).max(0.0));
        let part = if pdf > 0.0 { (diffuse / pdf).min(1.0) } else { 1.0 };
        part + (1.0 - part) * f.ggx.width().powi(2)
    }

    #[cold]
    #[inline(never)]
    fn features(&self) -> Features {
        let (mut found, mut broad) = (Features::default(), 0.0);
        let [metal, glass, through, coat] = self.facet_albedos();
        let width = self.facets.as_ref().map_or(1.0, |f| f.ggx.width());
        let albedos = [metal, glass + through, coat, self.diffuse];
        for (lobe, (albedo, chance)) in albedos.into_iter().zip(self.chance).enumerate() {
            let width_squared = if lobe == 3 { 1.0 } else { width * width };
            found.add(albedo, chance, self.frame[2], width_squared, &mut broad);
        }
        found.finished(broad, self.chance.iter().sum())
    }

    #[cold]
    #[inline(never)]
    fn means(&self) -> SurfaceMeans {
        let mut sums = MeanSums::default();
        let base = warp::to_world(&self.frame, self.base_normal);
        sums.add(average(self.diffuse), base, None);
        if let Some(f) = &self.facets {
            let roughness = f.ggx.width().sqrt();
            for weight in [average(f.metal_weight), average(f.glass_weight), f.coat_weight] {
                sums.add(weight, self.frame[2], Some(roughness));
            }
        }
        sums.means(base)
    }

    fn diffuse(&self) -> (Rgb, Vec3A) {
        (self.diffuse, warp::to_world(&self.frame, self.base_normal))
    }
}

impl Scattering for Bsdf {
    fn receiving_normal(&self) -> Option<Vec3A> {
        // No light is left out that either normal sees.
        (self.chance[1] == 0.0 && self.base_normal == Vec3A::Z).then_some(self.frame[2])
    }

    fn is_mirror(&self) -> bool {
        self.chance[3] == 0.0 && self.facets.as_ref().is_none_or(|f| f.ggx.is_mirror())
    }

    fn evaluate(&self, wi: Vec3A) -> (Rgb, f32) {
        let above = self.geometric_normal.dot(wi) > 0.0;
        if self.facets.is_some() {
            return self.evaluate_local(warp::to_local(&self.frame, wi), above);
        }
        let cos = self.frame[2].dot(wi);
        if !(above && cos > 0.0) {
            return (Rgb::ZERO, 0.0);
        }
        (self.diffuse * (cos * FRAC_1_PI), self.chance[3] * warp::cosine_hemisphere_pdf(cos))
    }

    #[cold]
    #[inline(never)]
    fn evaluate_some(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32) {
        let mut part = self.clone();
        part.keep(rays);
        part.evaluate(wi)
    }

    #[cold]
    #[inline(never)]
    fn evaluate_smooth(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32) {
        let mut part = self.clone();
        part.keep(rays);
        part.geometric_normal = part.frame[2];
        part.evaluate(wi)
    }

    fn sample(&self, u_split: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if self.cos_o <= 0.0 && self.facets.is_some() {
            return None;
        }
        let (mut lobe, mut below) = (0, 0.0);
        while lobe < 3 && u[0] >= below + self.chance[lobe] {
            below += self.chance[lobe];
            lobe += 1;
        }
        if self.chance[lobe] <= 0.0 {
            return None;
        }
        let u = [((u[0] - below) / self.chance[lobe]).min(1.0 - f32::EPSILON), u[1]];
        if lobe == 3 {
            let mut wi = warp::sample_cosine_hemisphere(u);
            if self.base_normal != Vec3A::Z {
                wi = warp::to_world(&warp::frame(self.base_normal), wi);
            }
            return if self.facets.is_some() { self.finish(wi, false, true) } else { self.finish_lambert(wi) };
        }
        let f = self.facets.as_ref()?;
        let h = f.ggx.sample_visible(f.wo, u);
        let cos = f.wo.dot(h);
        if cos <= 0.0 {
            return None;
        }
        let transmit = lobe == 1 && u_split >= fresnel::dielectric(cos, self.eta);
        let wi = if transmit { refract(f.wo, h, self.eta)? } else { reflect(f.wo, h) };
        if !f.ggx.is_mirror() {
            return self.finish(wi, transmit, false);
        }
        // Mirrors: the chance of the choice is all the density there is.
        let weight = match lobe {
            0 => f.metal.at(cos) * f.metal_weight / self.chance[0],
            1 if transmit => f.glass_tint * f.glass_weight / self.chance[1],
            1 => f.glass_reflection_tint * f.glass_weight / self.chance[1],
            _ => f.coat_fresnel(cos) * f.coat_weight / self.chance[2],
        };
        let world = warp::to_world(&self.frame, wi).normalize();
        let above = self.geometric_normal.dot(world) > 0.0;
        (above != transmit).then_some(BsdfSample {
            wi: world,
            weight,
            pdf: 0.0,
            mirror: true,
            transmitted: transmit,
            matte: false,
        })
    }

    fn mirror(&self, transmitted: bool, _wi: Vec3A) -> (Rgb, f32) {
        let Some(f) = self.facets.as_ref().filter(|f| self.cos_o > 0.0 && f.ggx.is_mirror()) else {
            return (Rgb::ZERO, 0.0);
        };
        if transmitted {
            let through = 1.0 - fresnel::dielectric(self.cos_o, self.eta);
            (f.glass_tint * (f.glass_weight * through), self.chance[1] * through)
        } else {
            self.reflected(f, self.cos_o)
        }
    }

    fn relative_index(&self) -> f32 {
        self.eta
    }

    fn cosine(&self, d: Vec3A) -> f32 {
        self.frame[2].dot(d).abs()
    }
}

impl FacetData {
    #[inline]
    fn coat_fresnel(&self, cos: f32) -> Rgb {
        let rise = fresnel::dielectric_rise(cos, self.coat_eta);
        self.coat_f0 + (Rgb::ONE - self.coat_f0) * rise
    }
}

#[cfg(test)]
mod tests;
