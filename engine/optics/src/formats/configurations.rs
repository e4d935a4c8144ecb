//! Configurations of a design program's file, as it states them: gaps, object distances and beams.

use std::collections::BTreeMap;

use crate::prescription::Place;

use super::beams::StatedBeam;

/// A file with more is no lens.
pub(super) const MOST: usize = 100;

/// Configurations as a file states them. A quantity that a configuration does not state is that of the surfaces. Lengths in mm.
pub(super) struct Configurations {
    pub(super) count: usize,
    /// The one in which the surfaces stand.
    pub(super) active: usize,
    pub(super) place: Place,
    /// The gaps behind rows, by row and configuration.
    pub(super) gaps_mm: BTreeMap<usize, Vec<Option<f64>>>,
    pub(super) objects_mm: Vec<Option<f64>>,
    pub(super) beams: Vec<Option<StatedBeam>>,
    /// True if the film stands at the image of first order in each.
    pub(super) image_follows: bool,
}

impl Configurations {
    /// A table of so many configurations; `active` counts from 0.
    pub(super) fn new(count: usize, active: usize, place: Place) -> Self {
        let nothing = vec![None; count];
        Self {
            count,
            active,
            place,
            gaps_mm: BTreeMap::new(),
            objects_mm: nothing,
            beams: vec![None; count],
            image_follows: false,
        }
    }

    pub(super) fn gap(&mut self, row: usize, configuration: usize, mm: f64) {
        let all = self.gaps_mm.entry(row).or_insert_with(|| vec![None; self.count]);
        if let Some(gap) = all.get_mut(configuration) {
            *gap = Some(mm);
        }
    }

    pub(super) fn object(&mut self, configuration: usize, mm: f64) {
        if let Some(object) = self.objects_mm.get_mut(configuration) {
            *object = Some(mm);
        }
    }

    pub(super) fn beam(&mut self, configuration: usize, beam: StatedBeam) {
        if let Some(stated) = self.beams.get_mut(configuration) {
            *stated = Some(beam);
        }
    }

    /// Makes millimetres of lengths in units of `mm`.
    pub(super) fn scale(&mut self, mm: f64) {
        self.gaps_mm.values_mut().flatten().chain(&mut self.objects_mm).flatten().for_each(|length| *length *= mm);
        for beam in self.beams.iter_mut().flatten() {
            if let StatedBeam::EntrancePupil(diameter) = beam {
                *diameter *= mm;
            }
        }
    }
}
