//! Light by groups of emitters, and parts of it: a film for each, whose samples are those of the whole.

use super::{Film, FilmChannels, TileAccumulator};

impl Film {
    /// The films of the groups and parts that are kept.
    pub(super) fn of_groups(width: u32, height: u32, spreads: bool, keep: &FilmChannels) -> Vec<Self> {
        let of_light = FilmChannels { halves: keep.halves, ..FilmChannels::default() };
        (0..usize::from(keep.groups) + keep.parts)
            .map(|_| Self::keeping(width, height, spreads, of_light.clone()))
            .collect()
    }

    /// The films of groups number 1 and on; their alpha is 0.
    pub fn groups(&self) -> &[Self] {
        &self.groups[..usize::from(self.keep.groups)]
    }

    /// The films of parts, by their places; not divided by their bases.
    pub fn parts(&self) -> &[Self] {
        &self.groups[usize::from(self.keep.groups)..]
    }
}

/// The light of group number `place` + 1 in a patch, with the patch's number of samples; parts come after groups.
pub(super) fn of_group(part: Option<(&TileAccumulator, u32)>, place: usize) -> Option<(&TileAccumulator, u32)> {
    part.map(|(light, samples)| (&light.groups[place], samples))
}

impl TileAccumulator {
    /// Number of groups and parts whose light is kept.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The light of group number `place` + 1; parts come after groups.
    pub fn group(&mut self, place: usize) -> &mut Self {
        &mut self.groups[place]
    }
}
