//! Modulation transfer: the contrast of lines, by frequency and by height in the picture.

use super::{FieldResult, LensReport, MOST, ReportError, ReportedLens, evenly, within};
use petzval_optics::analysis::mtf::{Mtf as FieldMtf, MtfError};
use serde::{Deserialize, Serialize};

/// Frequencies over the height: 0 to 4 steps.
const BY_HEIGHT: usize = 5;

/// Options of modulation transfer.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MtfOptions {
    /// The highest frequency, line pairs/mm.
    highest_per_mm: f64,
    /// Number of steps to it.
    steps: usize,
    /// Number of heights in the picture.
    heights: usize,
    /// The step of frequency over the height, line pairs/mm; 1 to 4 times so many are shown.
    height_step_per_mm: f64,
}

/// The contrast by frequency, and by height.
#[derive(Serialize)]
pub(super) struct Contrast {
    frequencies_per_mm: Vec<f64>,
    fields: Vec<FieldResult<FieldMtf>>,
    height_frequencies_per_mm: Vec<f64>,
    heights: Vec<FieldResult<FieldMtf>>,
}

impl LensReport for MtfOptions {
    const NAME: &'static str = "mtf";
    type Found = Contrast;

    fn check(&self) -> Result<(), ReportError> {
        within(self.steps, MOST, "steps of the frequency")?;
        within(self.heights, MOST, "heights")?;
        let is_good = |frequency: f64| (1e-6..=1e6).contains(&frequency);
        let (highest, step) = (self.highest_per_mm, self.height_step_per_mm);
        let what =
            || ReportError::OutOfRange(format!("frequencies to {highest} and {step} lines/mm: give more than 0"));
        (is_good(highest) && is_good(step)).then_some(()).ok_or_else(what)
    }

    fn find(&self, subject: ReportedLens<'_>) -> Result<Contrast, ReportError> {
        let field = |angle: f64, step_per_mm: f64, count: usize| match subject.analysis.mtf(angle, step_per_mm, count) {
            Ok(found) => Ok(FieldResult::new(angle, Some(found))),
            Err(MtfError::Dark) => Ok(FieldResult::new(angle, None)),
            Err(error) => {
                let lens = subject.system.name().to_owned();
                Err(ReportError::Lens { lens, why: error.to_string() })
            }
        };
        let step = self.highest_per_mm / self.steps as f64;
        let fields = subject.fields_deg.iter().map(|&angle| field(angle, step, self.steps + 1));
        let fields = fields.collect::<Result<_, _>>()?;
        let half = subject.fields_deg.iter().fold(0.0, |most: f64, angle| most.max(angle.abs()));
        let parts = if half > 0.0 { evenly(self.heights) } else { vec![0.0] };
        let heights = parts.iter().map(|part| field(part * half, self.height_step_per_mm, BY_HEIGHT));
        let heights = heights.collect::<Result<_, _>>()?;
        let frequencies = |step: f64, count: usize| (0..count).map(|i| i as f64 * step).collect();
        Ok(Contrast {
            frequencies_per_mm: frequencies(step, self.steps + 1),
            fields,
            height_frequencies_per_mm: frequencies(self.height_step_per_mm, BY_HEIGHT),
            heights,
        })
    }
}
