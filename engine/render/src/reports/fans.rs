//! Ray fans: the errors of rays across the pupil.

use super::{Field, Fields, LensReport, MOST, ReportError, Subject, within};
use petzval_optics::analysis::fan::FanLine;
use serde::{Deserialize, Serialize};

/// Options of ray fans.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fans {
    /// Number of rays of a fan.
    rays: usize,
}

/// The two fans of a field, by wavelength.
#[derive(Serialize)]
pub(super) struct FieldFans {
    angle_deg: f64,
    tangential: Vec<Columns>,
    sagittal: Vec<Columns>,
}

/// A fan in one wavelength: [`petzval_optics::analysis::fan::FanRay`], column by column.
#[derive(Serialize)]
struct Columns {
    wavelength_nm: f64,
    pupil: Vec<f64>,
    error_mm: Vec<f64>,
    path_waves: Vec<f64>,
}

impl Columns {
    fn new(line: &FanLine) -> Self {
        Self {
            wavelength_nm: line.wavelength_nm,
            pupil: line.rays.iter().map(|ray| ray.pupil).collect(),
            error_mm: line.rays.iter().map(|ray| ray.error_mm).collect(),
            path_waves: line.rays.iter().map(|ray| ray.path_waves).collect(),
        }
    }
}

impl LensReport for Fans {
    const NAME: &'static str = "fans";
    type Found = Fields<Field<FieldFans>>;

    fn check(&self) -> Result<(), ReportError> {
        within(self.rays, MOST, "rays of a fan")
    }

    fn find(&self, subject: Subject<'_>) -> Result<Self::Found, ReportError> {
        let columns = |lines: &[FanLine]| lines.iter().map(Columns::new).collect();
        let field = |&angle_deg: &f64| {
            let found = subject.analysis.fans(angle_deg, self.rays).map(|fans| FieldFans {
                angle_deg,
                tangential: columns(&fans.tangential),
                sagittal: columns(&fans.sagittal),
            });
            Field::new(angle_deg, found)
        };
        Ok(Fields { fields: subject.fields_deg.iter().map(field).collect() })
    }
}
