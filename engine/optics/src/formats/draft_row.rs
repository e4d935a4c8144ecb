//! A surface of a lens while it is read.

use crate::glass::Medium;
use crate::prescription::{NextMedium, Place};

/// A surface.
#[derive(Clone, Debug)]
pub(super) struct DraftRow {
    pub(super) place: Place,
    pub(super) curvature: f64,
    pub(super) conic: f64,
    /// Pairs (power, coefficient).
    pub(super) terms: Vec<(u32, f64)>,
    /// The radius in the x-z plane, if it is another; 0 flat.
    pub(super) radius_x_mm: Option<f64>,
    pub(super) thickness_mm: f64,
    pub(super) behind: NextMedium,
    pub(super) semi_diameter_mm: Option<f64>,
    /// True if the file means that the rim stops light, not only that the beam is so wide.
    pub(super) has_rim: bool,
    pub(super) obstruction_mm: f64,
}

impl DraftRow {
    /// A plane in air.
    pub(super) fn new(place: Place) -> Self {
        Self {
            place,
            curvature: 0.0,
            conic: 0.0,
            terms: Vec::new(),
            radius_x_mm: None,
            thickness_mm: 0.0,
            behind: NextMedium::Medium(Medium::air()),
            semi_diameter_mm: None,
            has_rim: false,
            obstruction_mm: 0.0,
        }
    }
}
