//! Films of several shares of a picture, written and joined.
//!
//! The joined film is that of one render of the whole picture, to its bits, in all passes and with a noise threshold, too: a tile's sums are of
//! its own samples alone and come in the order of its passes, light that falls far away is added in whole quanta, and counts of
//! samples are decided block by block. So denoising and stray light follow as after one render.

use super::adaptive::{Adaptive, AdaptiveState};
use super::film_file::{self, CheckpointHeader, Unusable};
use super::share::{self, Share};
use super::{Job, Shared, lock};
use crate::film::KeptTile;
use std::path::Path;
use std::time::Duration;

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
        // What was joined is in other files.
        if shared.film.has_parked() {
            return Err(KeepError::Unfinished);
        }
        let header = CheckpointHeader::new(fingerprint, shared.share, true);
        Ok(self.on_threads(|| film_file::write(file, &header, shared.body(0.0).0, true))?)
    }

    /// Adds the film of another share, once this render has ended; the reason why it is not taken, if there is one: the film is as it was then.
    pub fn join_film(&self, file: &Path, fingerprint: &str, share: Share) -> Option<String> {
        self.wait(Duration::MAX);
        self.on_threads(|| self.shared.join_film(file, fingerprint, share)).err().map(|why| why.to_string())
    }
}

/// True if a render of these passes comes to the state of a tile that is in a file: the first sample and the count of each pass, or the plans of
/// one whose pixels get as many samples as they need, with the decisions that are in the file.
pub(super) fn may_come_to(
    tile: KeptTile,
    passes: &[(u32, u32)],
    adaptive: Option<(&Adaptive, &AdaptiveState)>,
    is_together: bool,
) -> bool {
    if let Some((adaptive, state)) = adaptive {
        return adaptive.may_come_to(state, tile, is_together);
    }
    let last = tile.passes.checked_sub(1).and_then(|last| passes.get(last as usize));
    last.is_some_and(|(first, count)| tile.samples == [first + count; 2])
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
        let (tiles, _) = share::own(share, &self.film, &self.tiles);
        let is_adaptive = body.progress.adaptive.is_some() == self.adaptive.is_some();
        let adaptive = self.adaptive.as_ref().zip(body.progress.adaptive.as_ref());
        let is_together = self.settings.denoising.is_some();
        let is_state = |tile| may_come_to(tile, &self.passes, adaptive, is_together);
        if !is_adaptive || self.film.join_kept(body.film, &tiles, &is_state).is_err() {
            return Err(Unusable::Damaged);
        }
        if let (Some(adaptive), Some(state)) = (&self.adaptive, &body.progress.adaptive)
            && !adaptive.join(state, &tiles)
        {
            return Err(Unusable::Damaged);
        }
        lock(&self.counts).add(&body.progress.counts);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
