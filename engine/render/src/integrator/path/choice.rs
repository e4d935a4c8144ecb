//! The choice of a ray, and the weight of the light that it finds beside light samples.

use crate::integrator::mis::power_heuristic;
use crate::lights::Source;
use crate::lights::receiver::LightSampleContext;

/// The choice of the ray between the lens and the first surface, which determines the weight of the light that it finds beside
/// [`AimedLights`](crate::integrator::aimed::AimedLights).
#[derive(Clone, Copy, Debug)]
pub(super) enum LensStrategy {
    /// The camera chose the ray, and nothing competes.
    CameraAlone,
    /// The camera chose the ray.
    Camera {
        /// The density of the choice, per unit of etendue.
        density: f32,
    },
    /// This source sent the ray.
    Aimed(Source),
}

impl LensStrategy {
    /// True for a ray that a source sent.
    #[inline(always)]
    pub(super) fn is_aimed(self) -> bool {
        matches!(self, Self::Aimed(_))
    }
}

/// The choice of the current ray, which determines the weight of the light that it finds.
#[derive(Clone, Copy)]
pub(super) enum MisContext {
    /// The camera or a mirror chose the ray: no light sample competes.
    Alone,
    /// A surface's scattering chose the ray, with this density per steradian; with the place at which a light sample
    /// competed.
    WithPdf(f32, LightSampleContext),
}

impl MisContext {
    /// The weight of light found by this ray that a light sample finds with density `light_pdf`.
    pub(super) fn weight(self, light_pdf: f32) -> f32 {
        match self {
            Self::Alone => 1.0,
            Self::WithPdf(pdf, _) => power_heuristic(pdf, light_pdf),
        }
    }

    /// The place at which a light sample competed.
    pub(super) fn receiver(&self) -> Option<&LightSampleContext> {
        match self {
            Self::Alone => None,
            Self::WithPdf(_, to) => Some(to),
        }
    }
}
