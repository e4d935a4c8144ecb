//! The gaps of a lens that may be adjusted.

use super::{GapsToFit, LensFitError, Tolerance};
use crate::glass::Medium;
use crate::prescription::moving::Part;
use crate::prescription::{NextMedium, Prescription};

/// The gaps that are adjusted: surface, gap and tolerance, mm.
pub(super) fn gaps_of(
    lens: &Prescription,
    asked: &GapsToFit,
    scale: f64,
) -> Result<Vec<(usize, f64, f64)>, LensFitError> {
    let (Tolerance::Millimetres(size) | Tolerance::Part(size)) = asked.tolerance;
    let is_part = matches!(asked.tolerance, Tolerance::Part(_));
    if !(size > 0.0 && size.is_finite()) || (is_part && size >= 1.0) {
        return Err(LensFitError::Tolerance(size));
    }
    let air = NextMedium::Medium(Medium::air());
    let moves =
        |surface: usize| lens.moving.as_ref().is_some_and(|moving| moving.parts().contains(&Part::gap(surface)));
    let inside = 0..lens.surfaces.len() - 1;
    let is_gap = |i: &usize| {
        let row = &lens.surfaces[*i];
        row.behind == air && row.thickness_mm > 0.0 && !moves(*i)
    };
    let there: Vec<usize> = inside.filter(is_gap).collect();
    let wanted = asked.surfaces.clone().unwrap_or_else(|| there.clone());
    let one = |surface: usize| {
        if !there.contains(&surface) {
            let there = there.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            return Err(LensFitError::NoGap { surface, there });
        }
        let gap_mm = lens.surfaces[surface].thickness_mm;
        // Elements do not run into each other by more than most of their gap.
        let tolerance = if is_part { size * gap_mm } else { (size * scale).min(0.9 * gap_mm) };
        Ok((surface, gap_mm, tolerance))
    };
    wanted.into_iter().map(one).collect()
}
