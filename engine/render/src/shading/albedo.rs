//! Albedo of a rough boundary, by roughness and angle: tables for the light that one layer leaves to another, and to restore the
//! energy that single scattering between facets loses.

use super::fresnel;
use super::microfacet::{Ggx, reflect, refract};
use crate::Rgb;
use glam::Vec3A;

/// Steps of roughness and of the cosine. Twice as many change the white furnace by less than 0.001.
const STEPS: usize = 24;
/// Points of the integral at each entry. The points lost below the horizon are a few percent: with a quarter
/// of these, a metal of roughness 0.4 comes out one percent too dark at each bounce.
const POINTS: u32 = 1024;

/// Numbers of a table.
pub const NUMBERS: usize = STEPS * STEPS + STEPS;

/// A place of all tables: the steps before it in roughness and cosine, and the parts of the way to the next.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    roughness: (usize, f32),
    cos: (usize, f32),
}

impl Entry {
    /// The place of a roughness and a cosine.
    #[inline]
    pub fn new(roughness: f32, cos: f32) -> Self {
        let step = |share: f32| {
            let place = share * (STEPS - 1) as f32;
            let before = (place as u32 as usize).min(STEPS - 2);
            (before, place - before as f32)
        };
        Self { roughness: step(roughness.clamp(0.0, 1.0)), cos: step(cos.clamp(0.0, 1.0).sqrt()) }
    }
}

/// Directional albedo over roughness and cosine, interpolated linearly.
#[derive(Clone, Debug, PartialEq)]
pub struct AlbedoTable {
    values: [[f32; STEPS]; STEPS],
    // Cosine-weighted, by roughness.
    averages: [f32; STEPS],
}

impl AlbedoTable {
    /// The table of facets that reflect everything: 1 less the loss between them.
    pub fn reflection() -> Self {
        Self::reflecting(|_| 1.0)
    }

    /// The table of dielectric reflection alone, relative index `eta`.
    pub fn dielectric_reflection(eta: f32) -> Self {
        Self::reflecting(|cos| fresnel::dielectric(cos, eta))
    }

    /// The table of reflection by a law of the cosine of light to a facet.
    pub fn reflecting(law: impl Fn(f32) -> f32) -> Self {
        Self::new(|ggx, wo, h| {
            let wi = reflect(wo, h);
            if wi.z > 0.0 { law(wo.dot(h)) * ggx.masking_shadowing(wo, wi) / ggx.masking(wo) } else { 0.0 }
        })
    }

    /// The table of a dielectric boundary, reflection and transmission together, into relative index `eta`.
    pub fn dielectric_boundary(eta: f32) -> Self {
        Self::new(|ggx, wo, h| {
            let f = fresnel::dielectric(wo.dot(h), eta);
            let wi = reflect(wo, h);
            let mut sum = 0.0;
            if wi.z > 0.0 {
                sum += f * ggx.masking_shadowing(wo, wi);
            }
            if let Some(wt) = refract(wo, h, eta).filter(|wt| wt.z < 0.0) {
                sum += (1.0 - f) * ggx.masking_shadowing(wo, wt);
            }
            sum / ggx.masking(wo)
        })
    }

    fn new(weight: impl Fn(&Ggx, Vec3A, Vec3A) -> f32) -> Self {
        let points: Vec<[f32; 4]> = (0..POINTS).map(|i| sobol_burley::sample_4d(i, 0, 0)).collect();
        let mut values = [[0.0; STEPS]; STEPS];
        for (i, row) in values.iter_mut().enumerate() {
            let ggx = Ggx::from_roughness(i as f32 / (STEPS - 1) as f32);
            for (j, value) in row.iter_mut().enumerate() {
                // The cosine is tabled by its square root: albedos change fast near grazing.
                let cos = (j as f32 / (STEPS - 1) as f32).powi(2).max(1e-4);
                let wo = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let sum: f32 = points.iter().map(|u| weight(&ggx, wo, ggx.sample_visible(wo, [u[0], u[1]]))).sum();
                *value = sum / POINTS as f32;
            }
        }
        let mut table = Self { values, averages: [0.0; STEPS] };
        for i in 0..STEPS {
            table.averages[i] = table.integrate(i as f32 / (STEPS - 1) as f32);
        }
        table
    }

    /// The table of these numbers, in the order of [`Self::numbers`].
    pub fn of(numbers: &[f32; NUMBERS]) -> Self {
        let (values, averages) = numbers.split_at(STEPS * STEPS);
        let mut table = Self { values: [[0.0; STEPS]; STEPS], averages: [0.0; STEPS] };
        table.values.as_flattened_mut().copy_from_slice(values);
        table.averages.copy_from_slice(averages);
        table
    }

    /// All numbers: for each roughness those of the cosines, then the averages.
    pub fn numbers(&self) -> impl Iterator<Item = f32> + '_ {
        self.values.as_flattened().iter().chain(&self.averages).copied()
    }

    /// The albedo seen at that cosine.
    #[inline]
    pub fn at(&self, roughness: f32, cos: f32) -> f32 {
        self.at_entry(&Entry::new(roughness, cos))
    }

    /// The albedo at a place of the table.
    #[inline]
    pub fn at_entry(&self, &Entry { roughness: (i, tx), cos: (j, ty) }: &Entry) -> f32 {
        let row = |i: usize| self.values[i][j] * (1.0 - ty) + self.values[i][j + 1] * ty;
        row(i) * (1.0 - tx) + row(i + 1) * tx
    }

    /// The cosine-weighted average at that roughness.
    #[inline]
    pub fn average(&self, roughness: f32) -> f32 {
        self.average_at(&Entry::new(roughness, 1.0))
    }

    /// The cosine-weighted average of the roughness of a place of the table.
    #[inline]
    pub fn average_at(&self, &Entry { roughness: (i, part), .. }: &Entry) -> f32 {
        self.averages[i] + (self.averages[i + 1] - self.averages[i]) * part
    }

    fn integrate(&self, roughness: f32) -> f32 {
        let n = 64;
        (0..n)
            .map(|k| {
                let cos = (k as f32 + 0.5) / n as f32;
                2.0 * cos * self.at(roughness, cos) / n as f32
            })
            .sum()
    }
}

/// The share of single scattering, `kept` at this angle and `average` over all, together with all that goes on between
/// facets of mean reflectance `fresnel`, over single scattering alone (Turquin 2019, Kulla and Conty 2017).
#[inline]
pub fn give_back(fresnel: Rgb, kept: f32, average: f32) -> Rgb {
    let kept = kept.clamp(1e-3, 1.0);
    let fresnel = fresnel.clamp(Rgb::ZERO, Rgb::ONE);
    Rgb::ONE + fresnel * average / (Rgb::ONE - fresnel * (1.0 - average)) * ((1.0 - kept) / kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrors_lose_nothing_and_rough_facets_some() {
        let table = AlbedoTable::reflection();
        assert!((table.at(0.0, 0.5) - 1.0).abs() < 1e-4);
        assert!((table.at(0.3, 1.0) - 1.0).abs() < 0.01);
        // Alpha = 1 seen from above has a closed form: half vectors are cosine-distributed, and the integral of
        // 2 - 1/x over x = cos^2 from 1/2 to 1 is 1 - ln 2.
        assert!((table.at(1.0, 1.0) - (1.0 - std::f32::consts::LN_2)).abs() < 0.003);
        let glass = AlbedoTable::dielectric_boundary(1.5);
        assert!((glass.at(0.0, 0.7) - 1.0).abs() < 1e-4);
        assert!(glass.at(1.0, 0.7) < 1.0);
    }

    #[test]
    fn a_smooth_dielectric_reflects_what_fresnel_says() {
        let table = AlbedoTable::dielectric_reflection(1.5);
        assert!((table.at(0.0, 1.0) - 0.04).abs() < 1e-4);
        for cos in [0.1f32, 0.3, 0.5, 0.8] {
            // Linear interpolation between the table's steps.
            assert!((table.at(0.0, cos) - fresnel::dielectric(cos, 1.5)).abs() < 0.02, "{cos}");
        }
    }
}
