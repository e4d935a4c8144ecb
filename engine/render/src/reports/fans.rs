//! Ray fans: the errors of rays across the pupil.

use super::{FieldResult, Fields, LensReport, MOST, ReportError, ReportedLens, within};
use petzval_optics::analysis::fan::FanLine;
use serde::{Deserialize, Serialize};

/// Options of ray fans.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FanOptions {
    /// Number of rays of a fan.
    rays: usize,
}

/// The two fans of a field, by wavelength.
#[derive(Serialize)]
pub(super) struct FieldFans {
    angle_deg: f64,
    tangential: Vec<FanColumns>,
    sagittal: Vec<FanColumns>,
}

/// A fan in one wavelength: [`petzval_optics::analysis::fan::FanRay`], column by column.
#[derive(Serialize)]
struct FanColumns {
    wavelength_nm: f64,
    pupil: Vec<f64>,
    error_mm: Vec<f64>,
    path_waves: Vec<f64>,
}

impl FanColumns {
    fn new(line: &FanLine) -> Self {
        Self {
            wavelength_nm: line.wavelength_nm,
            pupil: line.rays.iter().map(|ray| ray.pupil).collect(),
            error_mm: line.rays.iter().map(|ray| ray.error_mm).collect(),
            path_waves: line.rays.iter().map(|ray| ray.path_waves).collect(),
        }
    }
}

impl LensReport for FanOptions {
    const NAME: &'static str = "fans";
    type Found = Fields<FieldResult<FieldFans>>;

    fn check(&self) -> Result<(), ReportError> {
        within(self.rays, MOST, "rays of a fan")
    }

    fn find(&self, subject: ReportedLens<'_>) -> Result<Self::Found, ReportError> {
        let columns = |lines: &[FanLine]| lines.iter().map(FanColumns::new).collect();
        let field = |&angle_deg: &f64| {
            let found = subject.analysis.fans(angle_deg, self.rays).map(|fans| FieldFans {
                angle_deg,
                tangential: columns(&fans.tangential),
                sagittal: columns(&fans.sagittal),
            });
            FieldResult::new(angle_deg, found)
        };
        Ok(Fields { fields: subject.fields_deg.iter().map(field).collect() })
    }
}
