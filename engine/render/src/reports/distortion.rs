//! Distortion, field curvature and lateral colour over the field.

use super::{FieldResult, LensReport, MOST, ReportError, ReportedLens, evenly, within};
use petzval_optics::analysis::distortion::ChiefRay;
use serde::{Deserialize, Serialize};

/// Options of the report on distortion.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DistortionOptions {
    /// Number of fields where none are given, evenly from the axis to the half field.
    count: usize,
}

/// The chief rays of the fields.
#[derive(Serialize)]
pub(super) struct ChiefRays {
    /// Height on the film by the tangent of the field, mm.
    height_by_slope_mm: f64,
    fields: Vec<FieldResult<ChiefRay>>,
}

impl LensReport for DistortionOptions {
    const NAME: &'static str = "distortion";
    type Found = ChiefRays;

    fn parts(&self) -> Vec<f64> {
        evenly(self.count)
    }

    fn check(&self) -> Result<(), ReportError> {
        within(self.count, MOST, "fields")
    }

    fn find(&self, subject: ReportedLens<'_>) -> Result<ChiefRays, ReportError> {
        let analysis = &subject.analysis;
        let fields =
            subject.fields_deg.iter().map(|&angle| FieldResult::new(angle, analysis.chief_ray(angle))).collect();
        Ok(ChiefRays { height_by_slope_mm: analysis.height_by_slope_mm(), fields })
    }
}
