//! The pipeline of a render, and whether its lights send rays to the lens.

use super::{Settings, Shared};
use crate::camera::Camera;
use crate::camera::lens::real_lens::RealLens;
use crate::camera::shutter::Exposure;
use crate::film::TileRect;
use crate::integrator::aimed::AimedLights;
use crate::integrator::{Integrator, PreparedScene};
use crate::pipeline::Pipeline;
use crate::pipeline::aiming::{self, AimedReport, AimingContext};
use std::sync::Arc;

impl Shared {
    /// The part of the picture's pixels that has samples.
    fn rendered_part(&self) -> f32 {
        if self.adaptive.is_some() {
            return 1.0;
        }
        let area = |rect: TileRect| rect.width as f32 * rect.height as f32;
        let rendered: f32 = self.tiles.iter().map(|&tile| area(self.film.rect(tile))).sum();
        rendered / (self.settings.width as f32 * self.settings.height as f32)
    }

    /// The lights that send rays to the lens, and the decision on them.
    pub(super) fn find_aimed(&self) -> (Option<Arc<AimedLights>>, AimedReport) {
        let s = &self.settings;
        let knows_densities = s.integrator == Integrator::Bidirectional || self.pipeline == Pipeline::Hero;
        let lens = aimable(&self.cameras, s).filter(|_| knows_densities);
        let Some(lens) = lens else { return Default::default() };
        let context = AimingContext {
            stage: &self.stage,
            lens,
            exposure: self.exposure.as_ref(),
            clip: self.clip,
            raster: &self.raster,
            limits: &self.limits(),
            film_exposure: s.film_exposure,
            rendered: self.rendered_part(),
            seed: s.seed,
        };
        let (aimed, report) = context.choose();
        (aimed.map(Arc::new), report)
    }
}

/// The pipeline of a render.
pub(super) fn pipeline(
    stage: &PreparedScene,
    cameras: &[Camera],
    first: &Camera,
    s: &Settings,
    exposure: Option<&Exposure>,
) -> Pipeline {
    if s.integrator == Integrator::Bidirectional {
        return Pipeline::Hero.with(first);
    }
    let found = s.pipeline.with(first);
    if found != Pipeline::FilmFirst || s.pipeline == Pipeline::FilmFirst {
        return found;
    }
    // With one wavelength both are the same, but hero knows the densities of its rays.
    let lens = aimable(cameras, s);
    let may_aim = lens.is_some_and(|lens| aiming::may_be_worth_it(stage, lens, exposure));
    if may_aim { Pipeline::Hero } else { found }
}

/// The lens to which lights may send rays, if the render is one that can have that: through one lens that is traced.
fn aimable<'a>(cameras: &'a [Camera], s: &Settings) -> Option<&'a Arc<RealLens>> {
    let [Camera::Lens(lens)] = cameras else { return None };
    (s.light_tracing && lens.takes_light_paths()).then_some(lens)
}
