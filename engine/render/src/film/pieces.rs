//! A film's state in pieces, each some of its tiles or some of its scattered light: so a file of it is written and read in parallel, and films
//! are joined without a second one in memory.

use super::kept::FilmState;
use super::packed::{self, MOST_ROWS};
use super::{Film, TileSums};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Pixels, edges of the tiles counted, of a piece's tiles, about.
const PIXELS: u32 = 1 << 15;

/// A film's state as it is in a file.
#[derive(Debug)]
pub struct KeptFilm {
    /// Number of films: its own and those of its groups.
    pub films: u32,
    /// The pieces, in any order.
    pub pieces: Vec<Vec<u8>>,
}

/// The passes and samples of a tile, as a file has them.
#[derive(Clone, Copy, Debug)]
pub struct KeptTile {
    /// The tile's number.
    pub tile: usize,
    /// Passes that were added.
    pub passes: u32,
    /// Samples of the pixels of each half; of a film whose counts do not differ, of all of them twice.
    pub samples: [u32; 2],
}

/// The kept sums are those of a film of another size, of one that keeps other things, or of other tiles.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is of another film")]
pub struct NotThisFilm;

/// A piece that is written. Variants and fields are those of [`Piece`].
#[derive(Serialize)]
enum WrittenPiece<'a> {
    Tiles {
        film: u32,
        tiles: &'a [(u32, TileSums)],
    },
    Splats {
        film: u32,
        place: u32,
        is_coarse: bool,
        first: u64,
        #[serde(serialize_with = "packed::serialize")]
        sums: &'a [i64],
    },
}

/// A piece that was read.
#[derive(Deserialize)]
enum Piece {
    /// Some tiles of a film.
    Tiles { film: u32, tiles: Vec<(u32, TileSums)> },
    /// Sums of scattered light, from number `first` on, by their place in [`Film::scattered_sums`].
    Splats {
        film: u32,
        place: u32,
        is_coarse: bool,
        first: u64,
        #[serde(deserialize_with = "packed::deserialize")]
        sums: Vec<i64>,
    },
}

/// A piece of a [`FilmState`] that is not written yet.
pub struct FilmPiece<'a>(WrittenPiece<'a>);

impl FilmPiece<'_> {
    /// The bytes of the piece.
    ///
    /// # Errors
    /// Those of the serialiser; there is no cause for one.
    pub fn bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(&self.0)
    }
}

impl FilmState {
    /// Number of films: the film's own and those of its groups.
    pub fn film_count(&self) -> u32 {
        self.films.len() as u32
    }

    /// The pieces of the state.
    pub fn pieces(&self) -> Vec<FilmPiece<'_>> {
        let mut pieces = Vec::new();
        for (film, state) in (0..).zip(&self.films) {
            let pixels = state.tiles.first().map_or(1, |(_, tile)| tile.light.rect.width * tile.light.rect.height);
            let some = state.tiles.chunks((PIXELS / pixels).max(1) as usize);
            pieces.extend(some.map(|tiles| FilmPiece(WrittenPiece::Tiles { film, tiles })));
            let sums =
                (0..).zip(&state.splats).flat_map(|(place, splats)| splats.both().map(move |both| (place, both)));
            for (place, (is_coarse, sums)) in sums {
                let some = sums.chunks(MOST_ROWS).enumerate();
                // The first says that there are some.
                let some = some.filter(|(i, sums)| *i == 0 || sums.iter().any(|&sum| sum != 0));
                pieces.extend(some.map(|(i, sums)| {
                    FilmPiece(WrittenPiece::Splats { film, place, is_coarse, first: (i * MOST_ROWS) as u64, sums })
                }));
            }
        }
        pieces
    }
}

impl Film {
    /// An empty film of the same kind takes the state that was kept; `is_state` tells whether a render comes to passes and samples of a tile.
    ///
    /// # Errors
    /// [`NotThisFilm`], with the film unchanged.
    pub fn restore(&mut self, kept: KeptFilm, is_state: &(dyn Fn(KeptTile) -> bool + Sync)) -> Result<(), NotThisFilm> {
        self.check(&kept, None, is_state)?;
        self.add_pieces(kept.pieces);
        Ok(())
    }

    /// Adds the sums of tiles that this film has not begun: `tiles`, all of them and no others. No other thread may add meanwhile. `is_state`
    /// as of [`Self::restore`].
    ///
    /// # Errors
    /// [`NotThisFilm`], with the film unchanged.
    pub fn join_kept(
        &self,
        kept: KeptFilm,
        tiles: &[usize],
        is_state: &(dyn Fn(KeptTile) -> bool + Sync),
    ) -> Result<(), NotThisFilm> {
        self.check(&kept, Some(tiles), is_state)?;
        self.add_pieces(kept.pieces);
        Ok(())
    }

    /// Checks all pieces before the first is added: that they are of this film, and of the same tiles in each group, which are these if they
    /// are known.
    fn check(
        &self,
        kept: &KeptFilm,
        tiles: Option<&[usize]>,
        is_state: &(dyn Fn(KeptTile) -> bool + Sync),
    ) -> Result<(), NotThisFilm> {
        let mut found = vec![Vec::new(); self.groups.len() + 1];
        if kept.films as usize != found.len() {
            return Err(NotThisFilm);
        }
        let of_pieces = kept.pieces.par_iter().map(|bytes| self.tiles_of(bytes, is_state)).collect::<Option<Vec<_>>>();
        for (film, tiles) in of_pieces.ok_or(NotThisFilm)? {
            found[film].extend(tiles);
        }
        found.iter_mut().for_each(|tiles| tiles.sort_unstable());
        let is_once = found[0].windows(2).all(|two| two[0] < two[1]);
        let is_known = tiles.is_none_or(|tiles| {
            let mut tiles = tiles.to_vec();
            tiles.sort_unstable();
            tiles == found[0]
        });
        if is_once && is_known && found.iter().all(|tiles| *tiles == found[0]) { Ok(()) } else { Err(NotThisFilm) }
    }

    /// The number of the film that a piece is of, and its tiles; `None` where it cannot be added.
    fn tiles_of(&self, bytes: &[u8], is_state: &(dyn Fn(KeptTile) -> bool + Sync)) -> Option<(usize, Vec<usize>)> {
        // Before the lists are unpacked, which may be a thousand times as long as their bytes.
        if tile_count_of(bytes).is_some_and(|count| count as usize > self.tiles.len()) {
            return None;
        }
        match piece(bytes)? {
            Piece::Tiles { film, tiles } => {
                let of = self.numbered(film as usize)?;
                // A group has its light by the samples of the film.
                let is_whole = film == 0;
                let fits = |(tile, kept): &(u32, TileSums)| {
                    let samples = match &kept.halves {
                        Some(halves) => [halves[0].samples, halves[1].samples],
                        None => [kept.samples; 2],
                    };
                    let state = KeptTile { tile: *tile as usize, passes: kept.passes, samples };
                    of.may_take(*tile as usize, kept) && (!is_whole || is_state(state))
                };
                tiles.iter().all(fits).then(|| (film as usize, tiles.iter().map(|(tile, _)| *tile as usize).collect()))
            }
            Piece::Splats { film, place, first, sums, .. } => {
                let splats = *self.numbered(film as usize)?.scattered_sums().get(place as usize)?;
                splats.has(usize::try_from(first).ok()?, sums.len()).then(|| (film as usize, Vec::new()))
            }
        }
    }

    /// The film of that number: itself, or that of a group.
    fn numbered(&self, film: usize) -> Option<&Self> {
        film.checked_sub(1).map_or(Some(self), |group| self.groups.get(group))
    }

    /// True if a tile has not begun, and these sums are of it and keep the data that this film keeps.
    fn may_take(&self, tile: usize, kept: &TileSums) -> bool {
        if tile >= self.tiles.len() {
            return false;
        }
        let here = self.tile(tile);
        let (rect, light) = (here.light.rect, &kept.light);
        let pixels = (rect.width * rect.height) as usize;
        let or_none = |is_kept: bool| if is_kept { pixels } else { 0 };
        let halves = match (&here.halves, &kept.halves) {
            (Some(here), Some(kept)) => here
                .iter()
                .zip(kept.iter())
                .all(|(here, kept)| kept.is_of(here.pixels, pixels, self.width as usize * self.height as usize)),
            (None, None) => true,
            _ => false,
        };
        halves
            && here.passes == 0
            && rect == light.rect
            && here.squares.is_some() == kept.squares.is_some()
            && kept.squares.as_ref().is_none_or(|squares| squares.len() == pixels)
            && light.sums.len() == or_none(here.halves.is_none())
            && light.data.len() == or_none(self.keep.surfaces)
            && light.vectors.len() == or_none(self.keep.vectors)
            && kept.mattes.fits(&self.keep.mattes, pixels)
    }

    /// Adds pieces that were checked.
    fn add_pieces(&self, pieces: Vec<Vec<u8>>) {
        pieces.into_par_iter().for_each(|bytes| {
            let film = film_of(&bytes).and_then(|film| self.numbered(film));
            match film.map(|film| (film, &film.parked)) {
                Some((_, Some(parked))) => parked.add(bytes),
                Some((film, None)) => film.add_piece(&bytes),
                None => debug_assert!(false, "the piece was checked"),
            }
        });
    }

    /// Adds a piece of this film that was checked.
    pub(super) fn add_piece(&self, bytes: &[u8]) {
        match piece(bytes) {
            Some(Piece::Tiles { tiles, .. }) => {
                for (tile, kept) in tiles {
                    // All of it is to be shown.
                    *self.tile(tile as usize) = TileSums { changed: true, ..kept };
                }
            }
            Some(Piece::Splats { place, is_coarse, first, sums, .. }) => {
                self.scattered_sums()[place as usize].join(is_coarse, first as usize, &sums);
            }
            None => debug_assert!(false, "the piece was checked"),
        }
    }
}

fn piece(bytes: &[u8]) -> Option<Piece> {
    let (piece, rest) = postcard::take_from_bytes(bytes).ok()?;
    rest.is_empty().then_some(piece)
}

/// The number of tiles of a piece of such.
fn tile_count_of(bytes: &[u8]) -> Option<u32> {
    // Variant, film, length of the list.
    let ((variant, _, count), _) = postcard::take_from_bytes::<(u32, u32, u32)>(bytes).ok()?;
    (variant == 0).then_some(count)
}

/// The number of the film that a piece is of.
fn film_of(bytes: &[u8]) -> Option<usize> {
    // Of both kinds of pieces it stands behind the variant.
    let ((_, film), _) = postcard::take_from_bytes::<(u32, u32)>(bytes).ok()?;
    Some(film as usize)
}
