//! Principled with all its sockets, as lobes of a mixture: sheen over coat over metal, glass, and a dielectric over its
//! diffuse base, each leaving to those below the light that it does not scatter, in the order and with the energy bookkeeping of
//! Cycles.

use super::Caustics;
use super::energy;
use super::fresnel;
use super::lobe::{Fresnel, Lobe};
use super::mixture::{Boundary, Mixture, dielectric, mean_roughness, metal, restored_seen, slopes, stretched};
use super::subsurface::Body;
use super::thin_film::RelativeFilm;
use crate::Rgb;
use crate::scene::closure::{Distribution, MetalKind, Principled, SubsurfaceMethod};
use glam::Vec3A;

/// Least weight that counts.
const LEAST: f32 = 1e-5;

impl Mixture {
    /// Adds all of Principled about one normal, but for the coat, which has its own; light that its alpha lets through is counted
    /// elsewhere.
    pub(super) fn add_principled(&mut self, weight: f32, p: &Principled<Rgb, f32>, normal: Vec3A) {
        let here = self.here;
        let mut left = Rgb::splat(weight * p.alpha.clamp(0.0, 1.0));
        let distribution = if p.multiscatter { Distribution::MultiscatterGgx } else { Distribution::Ggx };
        let base = p.base_color.clamp(Rgb::ZERO, Rgb::ONE);
        let tint = p.specular_tint.max(Rgb::ZERO);
        let facing = here.reflecting(normal);
        let cos = facing.dot(here.wo);
        let alpha = stretched(p.roughness, p.anisotropic);

        if p.sheen_weight > LEAST {
            let tinted = left * p.sheen_tint.max(Rgb::ZERO) * p.sheen_weight;
            if let Some(cloth) = Lobe::microfiber(tinted, p.sheen_roughness, normal, here.wo) {
                left = beneath(left, cloth.weight);
                self.push(cloth);
            }
        }
        if p.coat_weight > LEAST {
            left = self.add_coat(left, p, here.reflecting(here.coat_normal));
        }
        let Caustics { reflective, refractive } = here.caustics;
        let metallic = p.metallic.clamp(0.0, 1.0);
        if metallic > LEAST && reflective {
            let (law, average) = metal(MetalKind::Tinted, base, tint.min(Rgb::ONE), &p.film);
            let restored = here.restored(alpha, facing, distribution, || average);
            let frame = here.frame(facing, p.anisotropic_rotation);
            let albedo = law.at(cos, 1.0).0;
            self.push(here.facets(left * metallic * restored, albedo, alpha, distribution, law, frame));
        }
        left *= 1.0 - metallic;
        let transmission = p.transmission.clamp(0.0, 1.0);
        if transmission > LEAST && (reflective || refractive) {
            let f0 = tint * fresnel::f0_from_ior(p.ior.max(1e-5));
            let tints = [Rgb::ONE, Rgb::from(base.to_array().map(f32::sqrt))];
            let boundary = Boundary { f0, ior: p.ior, roughness: p.roughness, distribution, film: p.film };
            let mut glass = here.glass(transmission, here.caustic(tints), &boundary, normal);
            glass.weight *= left;
            glass.chance *= left.element_sum() / 3.0;
            self.push(glass);
        }
        left *= 1.0 - transmission;
        if reflective {
            left = self.add_dielectric(left, p, tint, facing, alpha, distribution);
        }
        let inner = p.subsurface_weight.clamp(0.0, 1.0);
        if inner > LEAST {
            let ior =
                if p.subsurface_method == SubsurfaceMethod::Skin { p.subsurface_ior } else { specular_index(p).1 };
            let radius = p.subsurface_radius.max(Rgb::ZERO) * p.subsurface_scale;
            let roughness = p.roughness.clamp(0.0, 1.0);
            let body = Body::new(base, radius, ior, roughness, p.subsurface_anisotropy, p.subsurface_method);
            self.add_body(left * base * inner, body, normal);
            left *= 1.0 - inner;
        }
        self.push(Lobe::oren_nayar(left * p.base_color.max(Rgb::ZERO), base, p.diffuse_roughness, normal, here.wo));
    }

    /// Adds the clear coat; returns the part of the light that is left below it.
    fn add_coat(&mut self, left: Rgb, p: &Principled<Rgb, f32>, normal: Vec3A) -> Rgb {
        let here = self.here;
        let eta = p.coat_ior.max(1.0);
        let roughness = p.coat_roughness.clamp(0.0, 1.0);
        let alpha = [roughness * roughness; 2];
        let cos = normal.dot(here.wo);
        let f0 = fresnel::f0_from_ior(eta);
        let average = Rgb::splat(fresnel::dielectric_average(eta));
        let seen = energy::Seen::new(roughness, cos);
        let weight = left * p.coat_weight * restored_seen(&seen, average);
        let albedo = seen.kept * (f0 + (1.0 - f0) * seen.rise(eta));
        let law = Fresnel::Dielectric { f0: Rgb::splat(f0), reflection: Rgb::ONE, transmission: Rgb::ZERO };
        let slopes = slopes(alpha, Distribution::MultiscatterGgx);
        let albedo = Rgb::splat(albedo);
        let mut below = left;
        if here.caustics.reflective {
            self.push(Lobe::facets(weight, albedo, slopes, law, eta, here.frame(normal, 0.0), here.wo));
            below = beneath(left, weight * albedo);
        }
        // Beer's law over the way through a coat of thickness 1 that bends the ray.
        let bent = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(1e-6).sqrt();
        let tint = Rgb::from(p.coat_tint.max(Rgb::ZERO).to_array().map(|t| t.powf(1.0 / bent)));
        below * (Rgb::ONE + (tint - Rgb::ONE) * p.coat_weight)
    }

    /// Adds the dielectric over the diffuse base; returns the part of the light that is left to the base.
    fn add_dielectric(
        &mut self,
        left: Rgb,
        p: &Principled<Rgb, f32>,
        tint: Rgb,
        normal: Vec3A,
        alpha: [f32; 2],
        distribution: Distribution,
    ) -> Rgb {
        let here = self.here;
        let (f0, eta) = specular_index(p);
        let is_filmed = p.film.thickness_nm > RelativeFilm::LEAST_NM;
        if (eta == 1.0 && !is_filmed) || left.max_element() <= LEAST {
            return left;
        }
        let cos = normal.dot(here.wo);
        let tinted = (tint * f0).min(Rgb::ONE);
        let rises = |rise: f32| tinted + (Rgb::ONE - tinted) * rise;
        let real_f0 = fresnel::f0_from_ior(eta);
        let average = || rises(((fresnel::dielectric_average(eta) - real_f0) / (1.0 - real_f0)).clamp(0.0, 1.0));
        let seen = energy::Seen::new(mean_roughness(alpha), cos);
        let restored =
            if distribution == Distribution::MultiscatterGgx { restored_seen(&seen, average()) } else { Rgb::ONE };
        let weight = left * restored;
        let law = dielectric(tinted, [Rgb::ONE, Rgb::ZERO], eta, &p.film);
        let mean = if is_filmed { law.at(cos, eta).0 } else { rises(seen.rise(eta)) };
        let albedo = mean * seen.kept;
        let frame = here.frame(normal, p.anisotropic_rotation);
        self.push(Lobe::facets(weight, albedo, slopes(alpha, distribution), law, eta, frame, here.wo));
        // Without multiple scattering Cycles keeps from the base what the facets lose, too (`bsdf_microfacet_estimate_albedo`).
        beneath(left, weight * if distribution == Distribution::Ggx { mean } else { albedo })
    }
}

/// Reflectance at normal incidence and relative index of the dielectric, as its level has them.
fn specular_index(p: &Principled<Rgb, f32>) -> (f32, f32) {
    let ior = p.ior.max(1e-5);
    let f0 = fresnel::f0_from_ior(ior);
    if p.specular_ior_level == 0.5 {
        return (f0, ior);
    }
    let f0 = f0 * 2.0 * p.specular_ior_level.max(0.0);
    let eta = fresnel::ior_from_f0(f0);
    (f0, if ior < 1.0 { 1.0 / eta } else { eta })
}

/// The weight below a layer of an albedo: the layer's brightest channel takes from all alike.
fn beneath(weight: Rgb, albedo: Rgb) -> Rgb {
    let part = |a: f32, w: f32| if w > 0.0 { a / w } else { 0.0 };
    let taken = part(albedo.x, weight.x).max(part(albedo.y, weight.y)).max(part(albedo.z, weight.z));
    weight * (1.0 - taken).clamp(0.0, 1.0)
}
