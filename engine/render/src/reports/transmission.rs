//! Transmission by colour and field, and the reflection of coatings.

use super::{LensReport, MOST, ReportError, ReportedLens, check_wavelength, within};
use crate::camera::t_number;
use petzval_optics::analysis::transmission::FieldTransmission;
use petzval_optics::glass::line_nm;
use petzval_optics::system::System;
use serde::{Deserialize, Serialize};

/// Options of the report on transmission.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TransmissionOptions {
    /// Vacuum wavelengths at which the transmission is found.
    spectrum_nm: Vec<f64>,
}

/// The transmission of a lens.
#[derive(Serialize)]
pub(super) struct Transmitted {
    spectrum_nm: Vec<f64>,
    /// T-number of white light in the film's middle; `None` where that is dark.
    t_number: Option<f64>,
    coating_is_assumed: bool,
    coatings: Vec<Reflection>,
    /// Glasses that count as clear.
    unknown_absorption: Vec<String>,
    fields: Vec<FieldTransmitted>,
}

/// The reflection of a coating.
#[derive(Serialize)]
struct Reflection {
    name: String,
    /// The medium behind the first surface that has it.
    before: String,
    /// The part of light at right angles, by wavelength.
    reflected: Vec<f64>,
}

/// The transmission of a field.
#[derive(Serialize)]
struct FieldTransmitted {
    #[serde(flatten)]
    found: FieldTransmission,
    is_dark: bool,
}

impl LensReport for TransmissionOptions {
    const NAME: &'static str = "transmission";
    type Found = Transmitted;

    fn check(&self) -> Result<(), ReportError> {
        within(self.spectrum_nm.len(), MOST, "wavelengths")?;
        self.spectrum_nm.iter().try_for_each(|&nm| check_wavelength(nm))
    }

    fn find(&self, subject: ReportedLens<'_>) -> Result<Transmitted, ReportError> {
        let ReportedLens { system, analysis, fields_deg, main_nm, coating_is_assumed, .. } = subject;
        let fields = analysis.transmission(&fields_deg, &self.spectrum_nm).into_iter();
        Ok(Transmitted {
            spectrum_nm: self.spectrum_nm.clone(),
            t_number: t_number(system, main_nm, analysis.film().z_mm),
            coating_is_assumed,
            coatings: reflections(system, &self.spectrum_nm),
            unknown_absorption: system.glasses_of_unknown_absorption().into_iter().map(str::to_owned).collect(),
            fields: fields.map(|found| FieldTransmitted { is_dark: found.parts.is_none(), found }).collect(),
        })
    }
}

/// The reflection of each coating at right angles, on the first surface that has it.
fn reflections(system: &System, spectrum_nm: &[f64]) -> Vec<Reflection> {
    let mut coatings: Vec<Reflection> = Vec::new();
    for surface in system.surfaces() {
        let is_known = coatings.iter().any(|known| known.name == surface.coating.name());
        if is_known || surface.split(line_nm::D, 1.0, true).reflected.iter().all(|r| *r == 0.0) {
            continue;
        }
        coatings.push(Reflection {
            name: surface.coating.name().to_owned(),
            before: surface.element.behind().name().to_owned(),
            reflected: spectrum_nm.iter().map(|nm| surface.split(*nm, 1.0, true).mean_reflected()).collect(),
        });
    }
    coatings
}
