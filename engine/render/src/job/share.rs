//! Shares of a picture: some of its tiles, for one of several machines.

use super::{Settings, SettingsError};
use crate::film::Film;
use serde::{Deserialize, Serialize};

/// Some tiles of a picture. Its tiles are dealt in turns to slots, in their order from the middle outwards, so that each slot has tiles from all
/// over the picture; a share is the slots from `first` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    /// Number of the first slot.
    pub first: u32,
    /// Number of the slot behind the last.
    pub end: u32,
    /// Number of slots, at least 1.
    pub of: u32,
}

impl Default for Share {
    /// The whole picture.
    fn default() -> Self {
        Self { first: 0, end: 1, of: 1 }
    }
}

impl Share {
    /// Checks that it is a share, and one whose samples are known without the other tiles.
    pub(super) fn check(self, settings: &Settings) -> Result<(), SettingsError> {
        let Self { first, end, of } = self;
        if of == 0 || first > end || end > of {
            return Err(SettingsError::Share { first, end, of });
        }
        let needs_all = settings.noise_threshold > 0.0 && settings.denoising.is_some();
        let is_part = 0 < end - first && end - first < of;
        if is_part && needs_all { Err(SettingsError::ShareAfterDenoising) } else { Ok(()) }
    }

    /// The tiles of the share among those of a picture, which are in their order.
    pub(super) fn of(self, tiles: Vec<usize>) -> Vec<usize> {
        let is_own = |place: usize| (self.first..self.end).contains(&((place as u64 % u64::from(self.of)) as u32));
        tiles.into_iter().enumerate().filter(|(place, _)| is_own(*place)).map(|(_, tile)| tile).collect()
    }
}

/// The tiles that a render of a share takes, and their number of pixels.
pub(super) fn own(share: Share, film: &Film, tiles: &[usize]) -> (Vec<usize>, u64) {
    let all = if film.has_halves() { (0..film.tile_count()).collect() } else { tiles.to_vec() };
    let own = share.of(all);
    let pixels = own.iter().map(|&tile| u64::from(film.rect(tile).width * film.rect(tile).height)).sum();
    (own, pixels)
}

#[cfg(test)]
mod tests {
    use super::super::tests::settings;
    use super::*;

    #[test]
    fn shares_are_checked() {
        let settings = settings(4, 1);
        for (first, end, of) in [(0, 0, 0), (2, 1, 3), (0, 4, 3)] {
            assert!(matches!(Share { first, end, of }.check(&settings), Err(SettingsError::Share { .. })));
        }
        assert_eq!(Share { first: 1, end: 3, of: 4 }.of((10..20).collect()), [11, 12, 15, 16, 19]);
    }
}
