//! Illumination of the film over the field.

use super::{Fields, LensReport, MOST, ReportError, ReportedLens, evenly, within};
use petzval_optics::analysis::illumination::Illumination as FieldIllumination;
use serde::Deserialize;

/// Options of the report on illumination.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IlluminationOptions {
    /// Number of fields where none are given, evenly from the axis to the half field.
    count: usize,
}

impl LensReport for IlluminationOptions {
    const NAME: &'static str = "illumination";
    type Found = Fields<FieldIllumination>;

    fn parts(&self) -> Vec<f64> {
        evenly(self.count)
    }

    fn check(&self) -> Result<(), ReportError> {
        within(self.count, MOST, "fields")
    }

    fn find(&self, subject: ReportedLens<'_>) -> Result<Self::Found, ReportError> {
        Ok(Fields { fields: subject.analysis.illumination(&subject.fields_deg) })
    }
}
