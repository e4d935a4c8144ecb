//! A film as it can be kept and had again, bit by bit.

use super::splats::{SplatState, SplatSums};
use super::variance::{BatchSquares, SquareSums};
use super::{Film, TileSums};
use serde::{Deserialize, Serialize};
use std::sync::PoisonError;

/// All that has reached a film, and the films of its light groups.
#[derive(Debug, Serialize, Deserialize)]
pub struct FilmState {
    own: OwnState,
    /// A light group has no groups of its own: a file cannot nest them without end.
    groups: Vec<OwnState>,
}

/// All that has reached a film, without its light groups.
#[derive(Debug, Serialize, Deserialize)]
struct OwnState {
    tiles: Vec<TileSums>,
    far: SplatState,
    anywhere: [SplatState; 2],
    squares: [SplatState; 2],
}

/// The kept sums are those of a film of another size, or of one that keeps other things.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is of another film")]
pub struct NotThisFilm;

impl Film {
    /// The present state of the film; no other thread may add to it meanwhile.
    pub fn state(&self) -> FilmState {
        FilmState { own: self.own_state(), groups: self.groups.iter().map(Self::own_state).collect() }
    }

    fn own_state(&self) -> OwnState {
        OwnState {
            tiles: (0..self.tiles.len()).map(|tile| self.tile(tile).clone()).collect(),
            far: self.far.state(),
            anywhere: self.anywhere.each_ref().map(SplatSums::state),
            squares: self.squares.each_ref().map(SquareSums::state),
        }
    }

    /// An empty film of the same kind becomes what it was when its state was taken.
    ///
    /// # Errors
    /// [`NotThisFilm`], with the film unchanged or half restored: it is no use then.
    pub fn restore(&mut self, state: FilmState) -> Result<(), NotThisFilm> {
        if self.groups.len() != state.groups.len() {
            return Err(NotThisFilm);
        }
        self.restore_own(state.own)?;
        self.groups.iter_mut().zip(state.groups).try_for_each(|(group, state)| group.restore_own(state))
    }

    fn restore_own(&mut self, state: OwnState) -> Result<(), NotThisFilm> {
        if self.tiles.len() != state.tiles.len() {
            return Err(NotThisFilm);
        }
        for ((_, here), kept) in self.tiles.iter_mut().zip(state.tiles) {
            let here = here.get_mut().unwrap_or_else(PoisonError::into_inner);
            if !here.is_like(&kept) {
                return Err(NotThisFilm);
            }
            // All of it is to be shown.
            *here = TileSums { changed: true, ..kept };
        }
        let pixels = self.width as usize * self.height as usize;
        let sums = |state| SplatSums::restored(pixels, state).ok_or(NotThisFilm);
        self.far = sums(state.far)?;
        let [first, second] = state.anywhere;
        self.anywhere = [sums(first)?, sums(second)?];
        let sums = |state| SquareSums::restored(pixels, state).ok_or(NotThisFilm);
        let [first, second] = state.squares;
        self.squares = [sums(first)?, sums(second)?];
        Ok(())
    }
}

impl TileSums {
    /// True if both are of the same tile, and keep the same things of it.
    fn is_like(&self, other: &Self) -> bool {
        let (here, there) = (&self.light, &other.light);
        let halves = match (&self.halves, &other.halves) {
            (Some(here), Some(there)) => here.iter().zip(there.iter()).all(|(a, b)| a.is_like(b)),
            (None, None) => true,
            _ => false,
        };
        halves
            && self.squares.as_ref().map(BatchSquares::len) == other.squares.as_ref().map(BatchSquares::len)
            && here.rect == there.rect
            && here.sums.len() == there.sums.len()
            && here.data.len() == there.data.len()
            && here.vectors.len() == there.vectors.len()
    }
}
