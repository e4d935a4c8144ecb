//! Shares of a picture: each of several machines renders some of its tiles, and one of them joins what they found.
//!
//! The joined film is that of one render of the whole picture, to its bits, in all passes and with a noise threshold, too: a tile's sums are of
//! its own samples alone and come in the order of its passes, light that falls far away is added in whole quanta, and counts of
//! samples are decided block by block. So denoising and stray light follow as after one render.

use super::checkpoint::film_file::{self, CheckpointHeader, Unusable};
use super::{Job, Settings, SettingsError, Shared, lock};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Duration;

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

    /// Its tiles among those of a picture, which are in their order.
    pub(super) fn of(self, tiles: Vec<usize>) -> Vec<usize> {
        let is_own = |place: usize| (self.first..self.end).contains(&((place as u64 % u64::from(self.of)) as u32));
        tiles.into_iter().enumerate().filter(|(place, _)| is_own(*place)).map(|(_, tile)| tile).collect()
    }
}

/// A film that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum KeepError {
    /// The render was stopped, or goes on.
    #[error("the render is not finished")]
    Unfinished,
    /// The disk refuses.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl Job {
    /// Writes the film of a finished share, for [`Self::join_film`] of a render of the same fingerprint.
    ///
    /// # Errors
    /// [`KeepError`]; a file that was there stays then.
    pub fn write_film(&self, file: &Path, fingerprint: &str) -> Result<(), KeepError> {
        let shared = &self.shared;
        if !self.wait(Duration::ZERO) || !shared.own.iter().all(|&tile| shared.is_complete(tile)) {
            return Err(KeepError::Unfinished);
        }
        let header = CheckpointHeader::new(fingerprint, shared.share, true);
        Ok(film_file::write(file, &header, &shared.body(0.0).0)?)
    }

    /// Adds the film of another share, once this render has ended; the reason why it is not taken, if there is one: the film is as it was then.
    pub fn join_film(&self, file: &Path, fingerprint: &str, share: Share) -> Option<String> {
        self.wait(Duration::MAX);
        self.shared.join_film(file, fingerprint, share).err().map(|why| why.to_string())
    }
}

impl Shared {
    /// True if all passes of a tile are there.
    fn is_complete(&self, tile: usize) -> bool {
        let passes = self.adaptive.as_ref().map_or(self.passes.len(), |adaptive| adaptive.passes.len());
        self.film.tile(tile).passes as usize == passes
    }

    fn join_film(&self, file: &Path, fingerprint: &str, share: Share) -> Result<(), Unusable> {
        let nothing = || std::io::Error::from(std::io::ErrorKind::NotFound);
        let (header, body, _) = film_file::read(file, fingerprint)?.ok_or_else(nothing)?;
        if header.share != share {
            return Err(Unusable::Share);
        }
        if !header.is_complete {
            return Err(Unusable::Unfinished);
        }
        let of_picture =
            if self.adaptive.is_some() { (0..self.film.tile_count()).collect() } else { self.tiles.clone() };
        let tiles = share.of(of_picture);
        let is_adaptive = body.adaptive.is_some() == self.adaptive.is_some();
        if !is_adaptive || self.film.join_state(body.film, &tiles).is_err() {
            return Err(Unusable::Damaged);
        }
        if let (Some(adaptive), Some(state)) = (&self.adaptive, &body.adaptive)
            && !adaptive.join(state, &tiles)
        {
            return Err(Unusable::Damaged);
        }
        lock(&self.counts).add(&body.counts);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
