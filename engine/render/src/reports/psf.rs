//! Point spread: the light of a point with diffraction and aberrations.

use super::{FieldResult, Fields, LensReport, ReportError, ReportedLens};
use petzval_optics::analysis::psf::{Psf as FieldPsf, PsfError};
use serde::{Deserialize, Serialize};

/// Options of point spread: none.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PsfOptions {}

/// The point spread of a field, or its width where waves do not reach so far.
#[derive(Serialize)]
#[serde(untagged)]
pub(super) enum Spread {
    Found(FieldPsf),
    TooWide { angle_deg: f64, spread_mm: f64, spread_times: f64 },
}

impl LensReport for PsfOptions {
    const NAME: &'static str = "psf";
    type Found = Fields<FieldResult<Spread>>;

    fn find(&self, subject: ReportedLens<'_>) -> Result<Self::Found, ReportError> {
        let field = |&angle_deg: &f64| {
            let found = match subject.analysis.psf(angle_deg) {
                Ok(psf) => Some(Spread::Found(psf)),
                Err(PsfError::Dark) => None,
                Err(PsfError::TooWide { spread_mm, times, .. }) => {
                    Some(Spread::TooWide { angle_deg, spread_mm, spread_times: times })
                }
            };
            FieldResult::new(angle_deg, found)
        };
        Ok(Fields { fields: subject.fields_deg.iter().map(field).collect() })
    }
}
