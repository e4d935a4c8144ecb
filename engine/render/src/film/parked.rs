//! Light groups and parts of a picture that is joined: they wait as they were in the files, a fraction of their size, and are unpacked tile by
//! tile when one is looked at.

use super::cryptomatte::MatteSums;
use super::gather::{CountsAbout, GatheredLight, give};
use super::halves::Half;
use super::packed::{self, unpack_into};
use super::splats::SplatSums;
use super::variance::BatchSquares;
use super::{Film, TILE_SIZE, TileRect};
use crate::Rgb;
use rayon::prelude::*;
use serde::Deserialize;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Rows of tiles whose pixels are gathered together: those next to them are unpacked once more.
const BAND: u32 = 4;

/// Light that was joined to a film, in the packed pieces of its files.
pub(super) struct Parked {
    pieces: Mutex<Vec<Vec<u8>>>,
    spreads: bool,
}

impl Parked {
    /// Adds a piece that was checked.
    pub(super) fn add(&self, piece: Vec<u8>) {
        self.pieces().push(piece);
    }

    fn pieces(&self) -> MutexGuard<'_, Vec<Vec<u8>>> {
        self.pieces.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A part of the picture that is gathered.
struct Gathering {
    rect: TileRect,
    counts: CountsAbout,
    sums: Vec<[f64; 4]>,
}

impl Film {
    /// This film, for joining alone: nothing is added to it but the sums of other films. `spreads` as it was made with.
    #[must_use]
    pub fn for_joining(mut self, spreads: bool) -> Self {
        for group in &mut self.groups {
            group.parked = Some(Parked { pieces: Mutex::default(), spreads });
        }
        self
    }

    /// True if light was joined to groups of this film that its own state would lack.
    pub fn has_parked(&self) -> bool {
        self.groups.iter().any(|group| group.parked.as_ref().is_some_and(|parked| !parked.pieces().is_empty()))
    }

    /// [`Self::picture`] of the joined films; `None` if the film has its light itself.
    pub(super) fn parked_picture(&self) -> Option<Vec<[f32; 4]>> {
        let parked = self.parked.as_ref()?;
        let pieces = parked.pieces();
        if self.keep.halves {
            let whole = Self::keeping(self.width, self.height, parked.spreads, self.keep.clone())
                .exposed(self.exposure)
                .shaded(self.gains.clone());
            pieces.par_iter().for_each(|piece| whole.add_piece(piece));
            return Some(whole.picture());
        }
        let width = self.width as usize;
        let far = SplatSums::new(width * self.height as usize);
        let tiles = pieces.par_iter().flat_map_iter(|bytes| match postcard::from_bytes(bytes) {
            Ok(PackedPiece::Tiles { tiles, .. }) => tiles,
            Ok(PackedPiece::Splats { is_coarse, first, sums, .. }) => {
                // Of a film without halves there is no other scattered light.
                far.join(is_coarse, first as usize, &sums);
                Vec::new()
            }
            Err(_) => {
                debug_assert!(false, "the piece was checked");
                Vec::new()
            }
        });
        let mut there: Vec<Option<PackedTile<'_>>> = (0..self.tiles.len()).map(|_| None).collect();
        for (number, tile) in tiles.collect::<Vec<_>>() {
            there[number as usize] = Some(tile);
        }
        let mut out = vec![[0.0; 4]; width * self.height as usize];
        let bands = out.par_chunks_mut(width * (BAND * TILE_SIZE) as usize).enumerate();
        bands.for_each_init(Vec::new, |light, (band, out)| {
            self.gather_band(band as u32 * BAND * TILE_SIZE, &there, &far, light, out);
        });
        Some(out)
    }

    /// Gathers the pixels of a band of rows that begins at row `bottom`. `light` is room for a tile's.
    fn gather_band(
        &self,
        bottom: u32,
        tiles: &[Option<PackedTile<'_>>],
        far: &SplatSums,
        light: &mut Vec<[f64; 4]>,
        out: &mut [[f32; 4]],
    ) {
        let (width, top) = (self.width as usize, (bottom + BAND * TILE_SIZE).min(self.height));
        let columns = self.width.div_ceil(TILE_SIZE) as usize;
        let samples = |tile: usize| tiles[tile].as_ref().map_or(0, |tile| tile.samples);
        let corners = (bottom..top).step_by(TILE_SIZE as usize);
        let corners = corners.flat_map(|y| (0..self.width).step_by(TILE_SIZE as usize).map(move |x| (x, y)));
        let mut parts: Vec<Gathering> = corners
            .map(|(x, y)| {
                let rect = self.part(TileRect { x, y, width: 1, height: 1 });
                let sums = vec![[0.0; 4]; (rect.width * rect.height) as usize];
                Gathering { rect, counts: self.counts_about(rect, samples), sums }
            })
            .collect();
        // Row by row from below: each pixel gets the terms of its sum in the order of `Film::sums`.
        let whole = TileRect { x: 0, y: bottom, width: self.width, height: top - bottom };
        for tile in self.about(whole) {
            let Some(packed) = tiles[tile].as_ref().filter(|tile| tile.samples > 0) else { continue };
            if unpack_into(packed.light.sums, light).is_none() {
                debug_assert!(false, "the piece was checked");
                continue;
            }
            let own = self.rect(tile);
            let near = |from: u32, begin: u32, end: usize| {
                let place = (i64::from(from) - i64::from(begin)) / i64::from(TILE_SIZE);
                (place - 1).max(0)..(place + 2).min(end as i64)
            };
            for row in near(own.y, bottom, parts.len() / columns) {
                for column in near(own.x, 0, columns) {
                    let part = &mut parts[row as usize * columns + column as usize];
                    let by = f64::from(packed.samples) / part.counts.divisor;
                    give(packed.light.rect, light, by, part.rect, &mut part.sums);
                }
            }
        }
        for Gathering { rect, counts, mut sums } in parts {
            self.add_scattered_light(rect, counts, far, &GatheredLight::default(), &mut sums);
            for (row, line) in sums.chunks_exact(rect.width as usize).enumerate() {
                let begin = ((rect.y - bottom) as usize + row) * width + rect.x as usize;
                let to = out[begin..begin + line.len()].iter_mut();
                to.zip(line).for_each(|(to, sum)| *to = sum.map(|s| (s / counts.divisor) as f32));
            }
        }
    }
}

/// A piece whose tiles are not unpacked yet. Variants and fields are those of `Piece`.
#[derive(Deserialize)]
#[expect(dead_code, reason = "what is not read stands before what is")]
enum PackedPiece<'a> {
    Tiles {
        film: u32,
        #[serde(borrow)]
        tiles: Vec<(u32, PackedTile<'a>)>,
    },
    Splats {
        film: u32,
        place: u32,
        is_coarse: bool,
        first: u64,
        #[serde(deserialize_with = "packed::deserialize")]
        sums: Vec<i64>,
    },
}

/// The fields of `TileSums`.
#[derive(Deserialize)]
#[expect(dead_code, reason = "what is not read stands before what is")]
struct PackedTile<'a> {
    #[serde(borrow)]
    light: PackedLight<'a>,
    mattes: MatteSums,
    halves: Option<Box<[Half; 2]>>,
    squares: Option<BatchSquares>,
    samples: u32,
    passes: u32,
    changed: bool,
}

/// The fields of `TileAccumulator`.
#[derive(Deserialize)]
#[expect(dead_code, reason = "what is not read stands before what is")]
struct PackedLight<'a> {
    rect: TileRect,
    sums: &'a [u8],
    far: Vec<(u32, u32, Rgb)>,
    anywhere: Option<Vec<(u32, u32, Rgb)>>,
    data: &'a [u8],
    vectors: &'a [u8],
}
