//! Spot diagrams: the rays of points on the film.

use super::{FieldResult, LensReport, ReportError, ReportedLens, within};
use petzval_optics::analysis::spot::Spot;
use serde::{Deserialize, Serialize};

const MOST_RAYS_OF_A_SIDE: usize = 500;

/// Options of spot diagrams.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Spots {
    /// Number of rays over the width of a beam.
    rays: usize,
    /// Places of the film, from the focus, mm.
    defocus_mm: Vec<f64>,
}

/// The spots on each place of the film.
#[derive(Serialize)]
pub(super) struct SpotsOverFocus {
    defocus: Vec<SpotPlace>,
}

/// The spots on a film.
#[derive(Serialize)]
struct SpotPlace {
    defocus_mm: f64,
    fields: Vec<FieldResult<Spot>>,
}

impl LensReport for Spots {
    const NAME: &'static str = "spots";
    type Found = SpotsOverFocus;

    fn check(&self) -> Result<(), ReportError> {
        within(self.rays, MOST_RAYS_OF_A_SIDE, "rays over the width of a beam")
    }

    fn find(&self, subject: ReportedLens<'_>) -> Result<SpotsOverFocus, ReportError> {
        let ReportedLens { mut analysis, fields_deg, .. } = subject;
        let film_z_mm = analysis.film().z_mm;
        let mut defocus = Vec::new();
        for &defocus_mm in &self.defocus_mm {
            analysis = analysis.with_film_at(film_z_mm + defocus_mm);
            let field = |&angle: &f64| FieldResult::new(angle, analysis.spot(angle, self.rays));
            defocus.push(SpotPlace { defocus_mm, fields: fields_deg.iter().map(field).collect() });
        }
        Ok(SpotsOverFocus { defocus })
    }
}
