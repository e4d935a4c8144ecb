//! Light by groups of emitters: a film for each, whose samples are those of the whole.

use super::{Film, Keep, Patch};

impl Film {
    /// The films of the groups that are kept.
    pub(super) fn of_groups(width: u32, height: u32, spreads: bool, keep: &Keep) -> Vec<Self> {
        let of_light = Keep { halves: keep.halves, ..Keep::default() };
        (0..keep.groups).map(|_| Self::keeping(width, height, spreads, of_light.clone())).collect()
    }

    /// The films of groups number 1 and on; their alpha is 0.
    pub fn groups(&self) -> &[Self] {
        &self.groups
    }
}

/// What of samples, with how many they are, is the light of group number `place` + 1.
pub(super) fn of_group(part: Option<(&Patch, u32)>, place: usize) -> Option<(&Patch, u32)> {
    part.map(|(light, samples)| (&light.groups[place], samples))
}

impl Patch {
    /// How many groups' light is kept for itself.
    pub fn group_count(&self) -> u16 {
        self.groups.len() as u16
    }

    /// The light of group number `place` + 1.
    pub fn group(&mut self, place: usize) -> &mut Self {
        &mut self.groups[place]
    }
}
