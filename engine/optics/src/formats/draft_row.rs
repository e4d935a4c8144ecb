//! A surface of a lens while it is read.

use glam::DAffine3;

use crate::glass::Medium;
use crate::prescription::{NextMedium, Place};
use crate::surface::Pose;

/// A surface as the file states it. Lengths in mm, curvature in 1/mm.
#[derive(Clone, Debug)]
pub(super) struct DraftRow {
    pub(super) place: Place,
    pub(super) curvature: f64,
    pub(super) conic: f64,
    /// Terms of the asphere: pairs of a power p of the distance from the axis and its coefficient in mm^(1 − p).
    pub(super) terms: Vec<(u32, f64)>,
    /// The radius in the x-z plane, if it is another; 0 flat.
    pub(super) radius_x_mm: Option<f64>,
    pub(super) thickness_mm: f64,
    pub(super) behind: NextMedium,
    pub(super) semi_diameter_mm: Option<f64>,
    /// True if the file means that the rim stops light, not only that the beam is so wide.
    pub(super) has_rim: bool,
    /// True if the width is the designer's: else it may be that of the beams in one configuration.
    pub(super) is_width_fixed: bool,
    pub(super) obstruction_mm: f64,
    /// The change of coordinates from the place that the row before leaves to this surface, mm.
    pub(super) before: DAffine3,
    /// The change of coordinates behind this surface, before its thickness.
    pub(super) after: DAffine3,
    /// The pose beside the axis, once the frames are unfolded.
    pub(super) pose: Pose,
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
            is_width_fixed: false,
            obstruction_mm: 0.0,
            before: DAffine3::IDENTITY,
            after: DAffine3::IDENTITY,
            pose: Pose::identity(),
        }
    }
}
