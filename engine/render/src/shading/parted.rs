//! Scattering by kinds of lobe: for passes of light and colour, and for the denoiser's features.

use crate::Rgb;
use crate::scene::visibility::Rays;
use glam::Vec3A;

/// The light that the lobes of each kind scatter in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LobeShares {
    /// Light of lobes without a peak, on either side.
    pub diffuse: Rgb,
    /// Light of lobes about a peak, on the side of the lobe's normal.
    pub glossy: Rgb,
    /// Light of all other lobes.
    pub transmission: Rgb,
}

impl LobeShares {
    /// The shares of a single direction, mirrored or refracted.
    pub fn mirror(transmitted: bool) -> Self {
        let [glossy, transmission] = if transmitted { [Rgb::ZERO, Rgb::ONE] } else { [Rgb::ONE, Rgb::ZERO] };
        Self { glossy, transmission, ..Self::default() }
    }

    /// Adds the light that a lobe scatters. `rays`: the kinds that reach it; `is_above`: on the side of its normal.
    pub(super) fn add(&mut self, value: Rgb, rays: Rays, is_above: bool) {
        let to = match (rays.any_of(Rays::DIFFUSE), rays.any_of(Rays::GLOSSY), rays.any_of(Rays::TRANSMISSION)) {
            (true, ..) => &mut self.diffuse,
            (_, true, false) => &mut self.glossy,
            (_, true, true) if is_above => &mut self.glossy,
            _ => &mut self.transmission,
        };
        *to += value;
    }

    /// The diffuse and the glossy part of all, 0 to 1.
    pub fn parts(&self) -> [Rgb; 2] {
        let all = self.diffuse + self.glossy + self.transmission;
        let part = |of: Rgb| Rgb::select(all.cmpgt(Rgb::ZERO), of / all.max(Rgb::splat(f32::MIN_POSITIVE)), Rgb::ZERO);
        [part(self.diffuse), part(self.glossy)]
    }
}

/// The features of a surface for a denoiser.
#[derive(Clone, Copy, Debug, Default)]
pub struct Features {
    /// Albedo of the lobes that are no mirrors, or nearly mirrors.
    pub albedo: Rgb,
    /// Albedo of the mirrors.
    pub mirrored: Rgb,
    /// The mean of their normals.
    pub normal: Vec3A,
    /// True if mirrors are most of the surface, by the probability of their choice: the mirrored surface tells more.
    pub goes_on: bool,
}

/// Facets of less than this squared width count as a mirror there, as in Cycles.
const NARROW: f32 = 0.075 * 0.075;

impl Features {
    /// Adds a lobe: its albedo, the probability with which it is chosen, its normal and the square of its width.
    pub(super) fn add(&mut self, albedo: Rgb, chance: f32, normal: Vec3A, width_squared: f32, broad: &mut f32) {
        self.normal += normal * chance;
        if width_squared > NARROW {
            self.albedo += albedo;
            *broad += chance;
        } else {
            self.mirrored += albedo;
        }
    }

    /// Once all are added, `broad` of those that count `all` being no mirrors.
    pub(super) fn finished(self, broad: f32, all: f32) -> Self {
        let goes_on = all > 0.0 && broad * 4.0 <= all;
        Self { normal: if all > 0.0 { self.normal / all } else { Vec3A::ZERO }, goes_on, ..self }
    }
}

/// Means of a surface's closures, each as much as it weighs.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceMeans {
    /// Shading normal, unit.
    pub normal: Vec3A,
    /// Roughness as materials give it, 0 to 1; 1 where no closure has one, as in Cycles.
    pub roughness: f32,
}

/// Sums for [`SurfaceMeans`], closure by closure.
#[derive(Default)]
pub(super) struct MeanSums {
    normal: Vec3A,
    roughness: f32,
    rough: f32,
}

impl MeanSums {
    /// Adds a closure by its weight, with the roughness that it has; `None` of closures without.
    pub(super) fn add(&mut self, weight: f32, normal: Vec3A, roughness: Option<f32>) {
        self.normal += normal * weight;
        if let Some(roughness) = roughness {
            self.roughness += roughness * weight;
            self.rough += weight;
        }
    }

    /// The means; the surface's own normal stands in where there is none.
    pub(super) fn means(&self, own_normal: Vec3A) -> SurfaceMeans {
        let roughness = if self.rough > 0.0 { self.roughness / self.rough } else { 1.0 };
        SurfaceMeans { normal: self.normal.try_normalize().unwrap_or(own_normal), roughness }
    }
}

/// A BSDF that can tell its lobes apart.
pub trait LobeDecomposition {
    /// Light of the lobes from `wi`, as [`super::Scattering::evaluate_some`] does, or if it `is_beyond` the triangle's horizon
    /// [`super::Scattering::evaluate_smooth`]. Mirrors count nothing.
    fn shares(&self, wi: Vec3A, reaches: Rays, is_beyond: bool) -> LobeShares;

    /// Albedos of the lobes for white light from everywhere: diffuse, glossy, transmission. As a surface without roughness where no table
    /// says better, as Cycles has it.
    fn albedos(&self) -> [Rgb; 3];

    /// The mean square of the widths alpha of the lobes, mirrors left out, by the density with which each chooses `wi`; 1 for broad lobes.
    fn mean_alpha_squared(&self, wi: Vec3A) -> f32;

    /// The features for a denoiser.
    fn features(&self) -> Features;

    /// The means of the closures.
    fn means(&self) -> SurfaceMeans;

    /// The colours of the diffuse lobes that scatter here and not elsewhere, together, and the mean of their normals by these.
    fn diffuse(&self) -> (Rgb, Vec3A);
}
