//! A film as it can be kept and had again, bit by bit, and films of other tiles of one picture joined.

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
    /// The sums of each tile; `None` where no pass has been added.
    tiles: Vec<Option<TileSums>>,
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
        let is_begun: Vec<bool> = (0..self.tiles.len()).map(|tile| self.tile(tile).passes > 0).collect();
        let groups = self.groups.iter().map(|group| group.own_state(&is_begun)).collect();
        FilmState { own: self.own_state(&is_begun), groups }
    }

    fn own_state(&self, is_begun: &[bool]) -> OwnState {
        let sums = |(tile, begun): (usize, &bool)| begun.then(|| self.tile(tile).clone());
        OwnState {
            tiles: is_begun.iter().enumerate().map(sums).collect(),
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
            let Some(kept) = kept else { continue };
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

    /// Adds the sums of tiles that this film has not begun: `tiles`, all of them and no others. No other thread may add meanwhile.
    ///
    /// # Errors
    /// [`NotThisFilm`], with the film unchanged.
    pub fn join_state(&self, state: FilmState, tiles: &[usize]) -> Result<(), NotThisFilm> {
        let is_like = self.groups.len() == state.groups.len()
            && self.may_join(&state.own, tiles)
            && self.groups.iter().zip(&state.groups).all(|(group, state)| group.may_join(state, tiles));
        if !is_like {
            return Err(NotThisFilm);
        }
        self.join_own(state.own);
        self.groups.iter().zip(state.groups).for_each(|(group, state)| group.join_own(state));
        Ok(())
    }

    fn may_join(&self, state: &OwnState, tiles: &[usize]) -> bool {
        let given = state.tiles.iter().flatten().count();
        let is_new = |&tile: &usize| match state.tiles.get(tile) {
            Some(Some(kept)) => self.tile(tile).passes == 0 && self.tile(tile).is_like(kept),
            _ => false,
        };
        state.tiles.len() == self.tiles.len()
            && given == tiles.len()
            && tiles.iter().all(is_new)
            && self.far.fits(&state.far)
            && self.anywhere.iter().zip(&state.anywhere).all(|(here, there)| here.fits(there))
            && self.squares.iter().zip(&state.squares).all(|(here, there)| here.fits(there))
    }

    fn join_own(&self, state: OwnState) {
        for (tile, kept) in state.tiles.into_iter().enumerate() {
            if let Some(kept) = kept {
                *self.tile(tile) = TileSums { changed: true, ..kept };
            }
        }
        self.far.join(&state.far);
        self.anywhere.iter().zip(&state.anywhere).for_each(|(here, there)| here.join(there));
        self.squares.iter().zip(&state.squares).for_each(|(here, there)| here.join(there));
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
