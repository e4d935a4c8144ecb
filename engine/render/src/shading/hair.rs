//! Hair shaders of Blender as lobes.

use super::lobe::{FibreShape, Lobe, RoughFibre};
use super::mixture::Mixture;
use crate::Rgb;
use crate::scene::closure::{HairModel, Pigment, PrincipledHair};
use glam::Vec3A;

/// Absorption along a radius of hair with nothing but dark or red melanin (d'Eon et al. 2011, "An energy-conserving hair reflectance
/// model", section 6.1).
const EUMELANIN: Rgb = Rgb::new(0.506, 0.841, 1.653);
const PHEOMELANIN: Rgb = Rgb::new(0.343, 0.733, 1.924);

/// Flatter fibres have no more digits.
const LEAST_ASPECT: f32 = 1e-2;

impl Mixture {
    /// Adds the lobe of the Hair shader.
    pub(super) fn add_hair(&mut self, weight: Rgb, roughness: [f32; 2], tilt: f32, through: bool) {
        let Some((strand, tangent)) = self.strand() else { return };
        let (along, tilt) = match (tangent, strand.edge) {
            (Some(tangent), _) => (tangent, tilt),
            // As in Cycles.
            (None, Some(edge)) => (edge, 0.0),
            (None, None) => (strand.along, tilt),
        };
        let wo = self.here.wo;
        let frame = frame(along, wo);
        self.push(Lobe::fibre(weight, through, -tilt, roughness, frame, wo));
    }

    pub(super) fn add_principled_hair(&mut self, weight: f32, hair: &PrincipledHair<Rgb, f32>) {
        let Some((strand, axis)) = self.strand() else { return };
        let wo = self.here.wo;
        let mut frame = frame(strand.along, wo);
        // The sine of the angle between the view and the normal, across the fibre.
        let offset = strand.offset.unwrap_or_else(|| -self.here.geometric_normal.dot(frame[1]));
        let vary = 1.0 + 2.0 * (hair.random - 0.5) * hair.random_roughness;
        if hair.model == HairModel::Huang {
            let roughness = (hair.roughness * vary).clamp(0.0, 1.0);
            let coverage = if self.pixel_width > 0.0 { 0.5 * self.pixel_width / strand.radius } else { 1.0 };
            let mut aspect = hair.aspect.max(LEAST_ASPECT);
            if let Some(axis) = axis.filter(|_| aspect != 1.0 && strand.offset.is_some()) {
                let minor = axis.cross(strand.along);
                frame = if aspect > 1.0 { [-axis, minor, strand.along] } else { [minor, axis, strand.along] };
                aspect = aspect.min(1.0 / aspect);
            }
            let fibre = RoughFibre {
                sigma: absorption(hair, roughness),
                alpha: roughness,
                ior: hair.ior.max(1e-3),
                tilt: hair.offset,
                parts: [hair.reflection, hair.transmission, hair.secondary_reflection].map(|part| part.max(0.0)),
                offset,
                coverage: if strand.radius.is_finite() { coverage } else { 1.0 },
                aspect,
            };
            self.push(Lobe::huang(Rgb::splat(weight), &fibre, frame, wo));
            return;
        }
        let roughness = [hair.roughness * vary, hair.radial_roughness * vary];
        let shape = FibreShape {
            sigma: absorption(hair, roughness[1]),
            roughness,
            coat: hair.coat,
            ior: hair.ior.max(1e-3),
            tilt: hair.offset,
            offset,
        };
        self.push(Lobe::chiang(Rgb::splat(weight), &shape, frame, wo));
    }
}

/// The frame of a fibre: z along the fibre, x across it on the viewer's side.
fn frame(along: Vec3A, wo: Vec3A) -> [Vec3A; 3] {
    let y = along.cross(wo).try_normalize().unwrap_or_else(|| along.any_orthonormal_vector());
    [y.cross(along), y, along]
}

/// Absorption along a radius.
fn absorption(hair: &PrincipledHair<Rgb, f32>, radial_roughness: f32) -> Rgb {
    match hair.pigment {
        Pigment::Absorption => hair.color.max(Rgb::ZERO),
        Pigment::Color => of_reflectance(hair.color, radial_roughness),
        Pigment::Melanin => {
            let vary = 1.0 + 2.0 * (hair.random - 0.5) * hair.random_color.clamp(0.0, 1.0);
            let amount = -(1.0 - hair.melanin * vary).max(1e-4).ln();
            let melanin = EUMELANIN * (1.0 - hair.melanin_redness) + PHEOMELANIN * hair.melanin_redness;
            melanin * amount + of_reflectance(hair.color, radial_roughness)
        }
    }
}

/// Absorption of hair that has that colour together (Chiang et al. 2016, section 4.2).
fn of_reflectance(color: Rgb, radial_roughness: f32) -> Rgb {
    let x = radial_roughness;
    let per_logarithm = ((((0.245 * x + 5.574) * x - 10.73) * x + 2.532) * x - 0.215) * x + 5.969;
    let color = color.max(Rgb::splat(1e-5));
    let root = Rgb::new(color.x.ln(), color.y.ln(), color.z.ln()) / per_logarithm;
    root * root
}
