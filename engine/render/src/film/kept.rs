//! A film as it is at a moment, copied while no thread adds to it, to be written to a file beside the render that goes on.

use super::splats::{SplatState, SplatSums};
use super::{Film, TileSums};

/// All that has reached a film, and the films of its light groups.
#[derive(Debug)]
pub struct FilmState {
    /// The film's own, then those of its groups.
    pub(super) films: Vec<OwnState>,
}

/// All that has reached a film, without its light groups.
#[derive(Debug)]
pub(super) struct OwnState {
    /// The tiles to which a pass has been added, by their numbers.
    pub tiles: Vec<(u32, TileSums)>,
    /// Light that no tile keeps, in the order of [`Film::scattered_sums`].
    pub splats: [SplatState; 5],
}

/// Sums of light that no tile keeps, of any number of channels.
pub(super) trait Splats {
    /// The present sums; no other thread may add meanwhile.
    fn state(&self) -> SplatState;
    /// True if numbers from `first` on are some of its sums.
    fn has(&self, first: usize, count: usize) -> bool;
    /// Adds kept sums from number `first` on, which it has.
    fn join(&self, is_coarse: bool, first: usize, sums: &[i64]);
}

impl Film {
    /// The present state of the film; no other thread may add to it meanwhile.
    pub fn state(&self) -> FilmState {
        let begun: Vec<usize> = (0..self.tiles.len()).filter(|&tile| self.tile(tile).passes > 0).collect();
        FilmState { films: std::iter::once(self).chain(&self.groups).map(|film| film.own_state(&begun)).collect() }
    }

    fn own_state(&self, begun: &[usize]) -> OwnState {
        OwnState {
            tiles: begun.iter().map(|&tile| (tile as u32, self.tile(tile).clone())).collect(),
            splats: self.scattered_sums().map(Splats::state),
        }
    }

    /// Light that no tile keeps, and its squares.
    pub(super) fn scattered_sums(&self) -> [&dyn Splats; 5] {
        let [first, second] = &self.anywhere;
        let [squares, other_squares] = &self.squares;
        [&self.far, first, second, squares, other_squares]
    }
}

impl<const CHANNELS: usize> Splats for SplatSums<CHANNELS> {
    fn state(&self) -> SplatState {
        Self::state(self)
    }

    fn has(&self, first: usize, count: usize) -> bool {
        first.checked_add(count).is_some_and(|end| end <= self.length())
    }

    fn join(&self, is_coarse: bool, first: usize, sums: &[i64]) {
        Self::join(self, is_coarse, first, sums);
    }
}
