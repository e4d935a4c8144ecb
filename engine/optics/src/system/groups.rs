//! Lenses whose groups move: where they stand for a focal length and a focus.

use super::{FocalLength, LensSettings, System, SystemError, focal_length_mm, image_index, place};
use crate::glass::line_nm;
use crate::prescription::Prescription;
use crate::prescription::moving::MovingParts;

/// A focal length this much beyond the end of a zoom, relative, still means the end: lenses are marked with round numbers, 24-70 mm for 24.7 to
/// 67.9 mm.
const MARKING: f64 = 0.04;

impl System {
    /// [`Self::new`] with groups inside moved to focus nearer: 0 is infinity, 1 the nearest distance of the table.
    ///
    /// The scale and the opening of the diaphragm stay those at infinity, and so does the f-number that it is called by.
    pub fn with_travel(prescription: &Prescription, settings: &LensSettings, travel: f64) -> Result<Self, SystemError> {
        match &prescription.moving {
            Some(moving) => Self::with_groups(prescription, moving, settings, travel),
            None => Self::new(prescription, settings),
        }
    }

    /// The prescription with its groups where the settings have them and at a travel of the focus, from then on standing still, and the
    /// settings that are left for it.
    ///
    /// # Errors
    /// [`SystemError`].
    pub fn standing(
        prescription: &Prescription,
        settings: &LensSettings,
        travel: f64,
    ) -> Result<(Prescription, LensSettings), SystemError> {
        let Some(moving) = &prescription.moving else { return Ok((prescription.clone(), settings.clone())) };
        let (zoom_mm, settings) = zoomed(prescription, moving, settings)?;
        Ok((prescription.at_position(zoom_mm, travel), settings))
    }

    pub(super) fn with_groups(
        prescription: &Prescription,
        moving: &MovingParts,
        settings: &LensSettings,
        travel: f64,
    ) -> Result<Self, SystemError> {
        let (zoom_mm, settings) = zoomed(prescription, moving, settings)?;
        let at_rest = Self::new(&prescription.at_position(zoom_mm, 0.0), &settings)?;
        if travel == 0.0 {
            return Ok(at_rest);
        }
        let scaled = LensSettings { focal_length: FocalLength::Scale(at_rest.scale), ..settings };
        let moved = Self::new(&prescription.at_position(zoom_mm, travel), &scaled)?;
        Ok(Self { surfaces: moved.surfaces, ..at_rest })
    }
}

/// The nominal focal length of a zoom that the settings ask for, and the settings without it.
fn zoomed(
    prescription: &Prescription,
    moving: &MovingParts,
    settings: &LensSettings,
) -> Result<(f64, LensSettings), SystemError> {
    super::check_settings(settings)?;
    let (zoom_mm, focal_length) = match (settings.focal_length, moving.zoom_range_mm()) {
        (FocalLength::Millimetres(mm), Some(range)) => (zoom_for(prescription, range, mm)?, FocalLength::AsPublished),
        (other, _) => (moving.first_zoom_mm(), other),
    };
    Ok((zoom_mm, LensSettings { focal_length, ..settings.clone() }))
}

/// The nominal focal length at which the computed one is `asked_mm`; an end of the range if that is only marked as such.
fn zoom_for(prescription: &Prescription, [from, to]: [f64; 2], asked_mm: f64) -> Result<f64, SystemError> {
    let computed = |zoom_mm: f64| {
        let surfaces = place(&prescription.at_position(zoom_mm, 0.0), 1.0);
        let efl = focal_length_mm(&surfaces).ok_or(SystemError::Afocal)?;
        Ok::<f64, SystemError>((efl * image_index(&surfaces, line_nm::D)).abs())
    };
    let (shortest, longest) = (computed(from)?, computed(to)?);
    let beyond = SystemError::BeyondZoom { asked_mm, from_mm: shortest, to_mm: longest };
    if asked_mm < shortest * (1.0 - MARKING) || asked_mm > longest * (1.0 + MARKING) {
        return Err(beyond);
    }
    // Computed focal lengths rise with nominal ones, or the table is none of a zoom.
    let (mut low, mut high) = (from, to);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if computed(middle)? < asked_mm { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}
