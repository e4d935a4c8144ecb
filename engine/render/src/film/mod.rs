//! The light that has reached the film: sums by pixel, in tiles that are filled by one thread at a time.
//!
//! A tile keeps the light of its own samples, also light that fell beyond its edge: each pixel is the sum of the light that the tiles
//! about it gave, each divided by its own count of samples. So the picture is right at any moment, however far the
//! tiles are. Light that fell farther is kept by pixel alone ([`splats`]). Where pixels are to have different counts, tiles
//! are smaller, and each is in two [`halves`].
//!
//! Pixel (0, 0) is the lower left corner of the picture.

pub mod cryptomatte;
pub mod data;
mod gather;
mod groups;
pub mod halves;
mod kept;
mod packed;
mod parked;
mod pieces;
pub mod splats;
mod variance;

use crate::Rgb;
use crate::integrator::path::FirstSurface;
use cryptomatte::{MatteLayer, MatteNotes, MatteSums, Mattes};
use data::{DataSums, VectorSums};
use glam::{DVec4, Vec4};
use halves::{BLOCK_SIZE, BLOCK_SPREAD, Half, half_of};
pub use kept::FilmState;
use parked::Parked;
pub use pieces::{FilmPiece, KeptFilm, KeptTile, NotThisFilm};
use serde::{Deserialize, Serialize};
use splats::SplatSums;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use variance::{BatchSquares, SquareSums, scattered};

/// Side of a tile in pixels. Larger tiles leave threads idle at the end of a pass; smaller ones cost messages.
pub const TILE_SIZE: u32 = 32;
/// Distance beyond its edge, in pixels, within which a tile keeps its own light, where light spreads at all: a larger one costs memory, a
/// smaller one sends more to the sums by pixel, which are slower. Less than a tile.
pub const SPREAD: u32 = 8;

/// A part of the picture: lower left corner and size, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TileRect {
    /// Column of the left edge.
    pub x: u32,
    /// Row of the lower edge.
    pub y: u32,
    /// Width of the part, pixels.
    pub width: u32,
    /// Height of the part, pixels.
    pub height: u32,
}

impl TileRect {
    /// The part of a picture of that size within `margin` of this.
    fn grown(&self, margin: u32, width: u32, height: u32) -> Self {
        let (x, y) = (self.x.saturating_sub(margin), self.y.saturating_sub(margin));
        let right = (self.x + self.width + margin).min(width);
        let top = (self.y + self.height + margin).min(height);
        Self { x, y, width: right - x, height: top - y }
    }

    /// The pixels of the rectangle that belong to a half.
    pub fn pixels_of(self, half: usize) -> impl Iterator<Item = (u32, u32)> {
        let pixels =
            (self.y..self.y + self.height).flat_map(move |y| (self.x..self.x + self.width).map(move |x| (x, y)));
        pixels.filter(move |&(x, y)| half_of(x, y) == half)
    }

    /// Number of pixels of a half.
    pub fn count_of(self, half: usize) -> u64 {
        self.pixels_of(half).count() as u64
    }

    /// The index of a pixel in a list of the rows from below; `None` outside.
    #[inline]
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        // A pixel to the left is far to the right of everything.
        let (column, row) = (x.wrapping_sub(self.x), y.wrapping_sub(self.y));
        (column < self.width && row < self.height).then(|| (row * self.width + column) as usize)
    }
}

/// The data that a film keeps beside light.
#[derive(Clone, Debug, Default)]
pub struct FilmChannels {
    /// True to keep the surfaces that the pixels see.
    pub surfaces: bool,
    /// True to keep the motion over the picture of the surfaces that the pixels see.
    pub vectors: bool,
    /// The mattes to keep: objects or materials of the surfaces that the pixels see.
    pub mattes: Mattes,
    /// True to keep counts of samples that differ, in [`halves`].
    pub halves: bool,
    /// Groups of emitters whose light is kept for itself as well.
    pub groups: u16,
    /// Parts of paths that are, by their places.
    pub parts: usize,
    /// True to keep the sums that [`Film::variances`] needs.
    pub variance: bool,
}

/// Bytes of memory that each pixel takes of a film that keeps these: data of the surfaces that pixels see, motion vectors, mattes,
/// light in halves, and so many groups and parts of the light.
pub fn bytes_a_pixel(surfaces: bool, vectors: bool, mattes: bool, halves: bool, groups: usize) -> usize {
    // Light that falls far from its tile has sums of two sizes, three colours each.
    let light = size_of::<[f64; 4]>() + 6 * size_of::<i64>();
    // Squares for the variance: of what falls far from its tile they have two sizes, too.
    let variance = size_of::<f32>() + 2 * size_of::<i64>();
    let surfaces = if surfaces { size_of::<data::DataSums>() } else { 0 };
    let vectors = if vectors { size_of::<data::VectorSums>() } else { 0 };
    // How many names cover a pixel differs; four, of number and count each, are many.
    let mattes = if mattes { 4 * 8 } else { 0 };
    (light + if halves { light } else { 0 }) * (1 + groups) + variance + surfaces + vectors + mattes
}

/// Light on a part of the picture, while one thread gathers it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TileAccumulator {
    rect: TileRect,
    /// Radiance and alpha by pixel, rows from below. In double precision sums of samples are exact, but for ranges of brightness
    /// beyond 2^29 in one pixel: so they do not depend on how the samples are parted.
    #[serde(with = "packed")]
    sums: Vec<[f64; 4]>,
    /// Light that fell outside.
    far: Vec<(u32, u32, Rgb)>,
    /// Light that may fall anywhere, independent of the pixel that started it, if it is kept apart.
    anywhere: Option<Vec<(u32, u32, Rgb)>>,
    /// Light of rays that lights sent to the lens, which is no error of the pixels in whose turn they were sent.
    #[serde(skip)]
    aimed: Vec<(u32, u32, Rgb)>,
    /// Data of the surfaces by pixel; empty if not asked for.
    #[serde(with = "packed")]
    data: Vec<DataSums>,
    /// Motion vectors by pixel; empty if not asked for.
    #[serde(with = "packed")]
    vectors: Vec<VectorSums>,
    #[serde(skip)]
    mattes: Option<Box<MatteNotes>>,
    /// The light of each group of emitters, while it is gathered; each group's sums are a film of their own.
    #[serde(skip)]
    groups: Vec<TileAccumulator>,
}

impl TileAccumulator {
    fn new(rect: TileRect, keep: &FilmChannels) -> Self {
        let pixels = (rect.width * rect.height) as usize;
        Self {
            sums: vec![[0.0; 4]; pixels],
            data: if keep.surfaces { vec![DataSums::default(); pixels] } else { Vec::new() },
            vectors: if keep.vectors { vec![VectorSums::default(); pixels] } else { Vec::new() },
            mattes: (!keep.mattes.is_empty()).then(|| Box::new(MatteNotes::new(pixels))),
            ..Self::unbegun(rect, keep)
        }
    }

    /// One without room for light.
    fn unbegun(rect: TileRect, keep: &FilmChannels) -> Self {
        Self {
            rect,
            sums: Vec::new(),
            far: Vec::new(),
            anywhere: keep.halves.then(Vec::new),
            aimed: Vec::new(),
            data: Vec::new(),
            vectors: Vec::new(),
            mattes: None,
            groups: Vec::new(),
        }
    }

    /// Adds the surface data of a hit of a ray of a pixel of the tile, if they are kept.
    #[inline]
    pub fn add_data(&mut self, x: u32, y: u32, found: Option<FirstSurface>) {
        let Some(i) = self.rect.index(x, y) else { return };
        if let Some(sums) = self.data.get_mut(i) {
            sums.add(found);
        }
        if let Some(mattes) = &mut self.mattes {
            mattes.add(i, found.map(|surface| [surface.instance, surface.material]));
        }
    }

    /// Adds the motion over the picture of a hit of a ray of a pixel of the tile, if it is kept.
    pub fn add_vector(&mut self, x: u32, y: u32, vector: [f32; 4]) {
        if let Some(sums) = self.rect.index(x, y).and_then(|i| self.vectors.get_mut(i)) {
            sums.add(vector);
        }
    }

    /// Adds radiance to a pixel of the picture.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, radiance: Rgb) {
        self.add_wide(x, y, radiance.extend(0.0));
    }

    /// Adds radiance, with a 0 as the fourth number, to a pixel of the picture.
    #[inline]
    pub fn add_wide(&mut self, x: u32, y: u32, radiance: Vec4) {
        match self.rect.index(x, y) {
            Some(i) => {
                let sum = &mut self.sums[i];
                *sum = (DVec4::from_array(*sum) + radiance.as_dvec4()).to_array();
            }
            None => self.far.push((x, y, radiance.truncate())),
        }
    }

    /// Adds radiance that is as likely to come from any other pixel's samples.
    pub fn add_anywhere(&mut self, x: u32, y: u32, radiance: Rgb) {
        match &mut self.anywhere {
            Some(list) => list.push((x, y, radiance)),
            None => self.add(x, y, radiance),
        }
    }

    /// Adds radiance of a ray that a light sent to the lens: from anywhere, too, but samples of the pixel that started it do not make it
    /// less noisy.
    pub fn add_aimed(&mut self, x: u32, y: u32, radiance: Rgb) {
        match &self.anywhere {
            Some(_) => self.aimed.push((x, y, radiance)),
            None => self.add(x, y, radiance),
        }
    }

    /// Adds alpha to a pixel of the tile.
    #[inline]
    pub fn add_alpha(&mut self, x: u32, y: u32, alpha: f32) {
        // All four numbers, as radiance is added: a processor waits where four are read of which one was just written.
        if let Some(i) = self.rect.index(x, y) {
            let sum = &mut self.sums[i];
            *sum = (DVec4::from_array(*sum) + DVec4::new(0.0, 0.0, 0.0, f64::from(alpha))).to_array();
        }
    }
}

/// Sums of one tile. Its lists have no room before the first pass: a machine that renders some tiles of a picture needs that of these alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TileSums {
    light: TileAccumulator,
    mattes: MatteSums,
    /// The light instead, if counts of samples differ.
    halves: Option<Box<[Half; 2]>>,
    /// The squares of its batches, if the variance is kept and counts do not differ.
    squares: Option<BatchSquares>,
    /// Samples of each of its pixels; the fewer, if they differ.
    pub samples: u32,
    /// Passes that have been added.
    pub passes: u32,
    changed: bool,
}

/// A finished part of the picture.
#[derive(Clone, Debug)]
pub struct TilePixels {
    /// The rectangle of the pixels.
    pub rect: TileRect,
    /// Scene-linear RGBA, rows from below.
    pub pixels: Vec<[f32; 4]>,
}

/// All tiles of a picture.
pub struct Film {
    width: u32,
    height: u32,
    tile_size: u32,
    /// The tiles, by distance from the centre.
    tiles: Vec<(TileRect, Mutex<TileSums>)>,
    /// The tiles in rows from below.
    places: Vec<usize>,
    far: SplatSums,
    /// Light from anywhere, of each half's samples.
    anywhere: [SplatSums; 2],
    /// Squares of the light that no tile keeps, of each half's samples; the first has all where counts do not differ.
    squares: [SquareSums; 2],
    keep: FilmChannels,
    /// Factor of the light when it is read.
    exposure: f32,
    /// A further factor for each pixel, rows from below; empty: 1 everywhere.
    gains: Arc<[f32]>,
    groups: Vec<Film>,
    /// Light that was joined, in its packed form until a picture of it is asked for.
    parked: Option<Parked>,
}

impl Film {
    /// An empty film; tiles in order of their distance from the centre, where one looks first. `spreads` if samples
    /// give light to other pixels than their own.
    /// `with_data` if it shall also keep data of the surfaces that pixels see.
    pub fn new(width: u32, height: u32, spreads: bool, with_data: bool) -> Self {
        Self::keeping(width, height, spreads, FilmChannels { surfaces: with_data, ..FilmChannels::default() })
    }

    /// An empty film that keeps the data that `keep` names; tiles in order of their distance from the centre. `spreads` if samples give
    /// light to other pixels than their own.
    pub fn keeping(width: u32, height: u32, spreads: bool, keep: FilmChannels) -> Self {
        let tile_size = if keep.halves { BLOCK_SIZE } else { TILE_SIZE };
        let rects = cut(width, height, tile_size);
        let from_centre = |i: &usize| {
            let r = &rects[*i];
            let dx = (2 * r.x + r.width) as i64 - width as i64;
            let dy = (2 * r.y + r.height) as i64 - height as i64;
            dx * dx + dy * dy
        };
        let mut order: Vec<usize> = (0..rects.len()).collect();
        order.sort_by_key(from_centre);
        let mut places = vec![0; rects.len()];
        order.iter().enumerate().for_each(|(tile, &place)| places[place] = tile);
        let margin = match (spreads, keep.halves) {
            (false, _) => 0,
            (true, false) => SPREAD,
            (true, true) => BLOCK_SPREAD,
        };
        let tile = |&place: &usize| {
            let light = TileAccumulator::unbegun(rects[place].grown(margin, width, height), &keep);
            let halves =
                keep.halves.then(|| Box::new([0, 1].map(|half| Half::new(rects[place].count_of(half) as u32))));
            let mattes = MatteSums::default();
            let squares = (keep.variance && !keep.halves).then(BatchSquares::new);
            let sums = TileSums { light, mattes, halves, squares, samples: 0, passes: 0, changed: false };
            (rects[place], Mutex::new(sums))
        };
        let sums = || SplatSums::new(width as usize * height as usize);
        let tiles = order.iter().map(tile).collect();
        let groups = Self::of_groups(width, height, spreads, &keep);
        let (far, anywhere) = (sums(), [sums(), sums()]);
        let squares = [0, 1].map(|_| SquareSums::new(width as usize * height as usize));
        let (exposure, gains) = (1.0, Arc::default());
        let parked = None;
        Self { width, height, tile_size, tiles, places, far, anywhere, squares, keep, exposure, gains, groups, parked }
    }

    /// This film with all its light multiplied by a factor, that of groups too.
    #[must_use]
    pub fn exposed(self, exposure: f32) -> Self {
        let groups = self.groups.into_iter().map(|group| group.exposed(exposure)).collect();
        Self { exposure, groups, ..self }
    }

    /// This film with each pixel's light multiplied by a factor of its own, rows from below, that of groups too; an empty list multiplies
    /// by one.
    #[must_use]
    pub fn shaded(self, gains: Arc<[f32]>) -> Self {
        let groups = self.groups.into_iter().map(|group| group.shaded(gains.clone())).collect();
        Self { gains, groups, ..self }
    }

    /// Factors of the film's light: one for the whole film, and one for each pixel; empty: 1 everywhere.
    pub fn scales(&self) -> (f32, &[f32]) {
        (self.exposure, &self.gains)
    }

    /// Width and height of the picture, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Number of tiles that the picture is divided into.
    pub fn tile_count(&self) -> usize {
        self.tiles.len()
    }

    /// The tiles, in their order, that overlap a part of the picture (left, bottom, width and height); of light that spreads, as near
    /// as [`SPREAD`] pixels too. One at least.
    pub fn tiles_about(&self, [x, y, width, height]: [u32; 4], spreads: bool) -> Vec<usize> {
        let margin = if spreads { SPREAD } else { 0 };
        let overlaps = |(begin, side): (u32, u32), (from, length): (u32, u32)| {
            begin < from.saturating_add(length).saturating_add(margin) && from < begin + side + margin
        };
        let is_near = |tile: &usize| {
            let rect = self.rect(*tile);
            overlaps((rect.x, rect.width), (x, width)) && overlaps((rect.y, rect.height), (y, height))
        };
        let near: Vec<usize> = (0..self.tile_count()).filter(is_near).collect();
        if near.is_empty() { vec![0] } else { near }
    }

    /// True if counts of samples may differ, in [`halves`].
    pub fn has_halves(&self) -> bool {
        self.keep.halves
    }

    /// The rectangle of a tile.
    pub fn rect(&self, tile: usize) -> TileRect {
        self.tiles[tile].0
    }

    /// An empty patch for the samples of a tile.
    pub fn patch(&self, tile: usize) -> TileAccumulator {
        let patch = TileAccumulator::new(self.tile(tile).light.rect, &self.keep);
        TileAccumulator { groups: self.groups.iter().map(|group| group.patch(tile)).collect(), ..patch }
    }

    /// A tile's sums, for as long as the guard lives.
    pub fn tile(&self, tile: usize) -> MutexGuard<'_, TileSums> {
        // A panic elsewhere leaves sums of whole passes behind: still good.
        self.tiles[tile].1.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds pass number `pass` of a tile, of `samples` a pixel, if the passes before it are there; else gives it back.
    pub fn add_pass(
        &self,
        tile: usize,
        pass: u32,
        light: TileAccumulator,
        samples: u32,
    ) -> Result<(), Box<TileAccumulator>> {
        let mut sums = self.tile(tile);
        if sums.passes != pass {
            return Err(Box::new(light));
        }
        self.join(&mut sums, &light, samples);
        // While nobody else can add to this tile: in the same order.
        for (group, light) in self.groups.iter().zip(&light.groups) {
            group.join(&mut group.tile(tile), light, samples);
        }
        Ok(())
    }

    fn join(&self, sums: &mut TileSums, light: &TileAccumulator, samples: u32) {
        sums.begin(&self.keep);
        if let Some(squares) = &mut sums.squares {
            squares.add(&light.sums, samples, &sums.light.sums, sums.samples);
        }
        for (sum, add) in sums.light.sums.iter_mut().zip(&light.sums) {
            for (s, a) in sum.iter_mut().zip(add) {
                *s += a;
            }
        }
        sums.join_data(&self.keep, light);
        for &(x, y, radiance) in &light.far {
            self.far.add(self.number(x, y), radiance.to_array());
        }
        self.add_squares(0, light.far.iter());
        sums.samples += samples;
        sums.passes += 1;
        sums.changed = true;
    }

    /// Adds a batch for each pixel of a half of a tile: samples for the picture, and others behind them for the error alone,
    /// each with how many. Batches of a tile must come in their order.
    pub fn add_batch(
        &self,
        tile: usize,
        half: usize,
        counted: Option<(&TileAccumulator, u32)>,
        beyond: Option<(&TileAccumulator, u32)>,
    ) {
        let mut sums = self.tile(tile);
        sums.begin(&self.keep);
        let Some(halves) = &mut sums.halves else { return };
        halves[half].add(counted, beyond, self.width);
        for (place, group) in self.groups.iter().enumerate() {
            group.add_batch(tile, half, groups::of_group(counted, place), groups::of_group(beyond, place));
        }
        let Some((light, _)) = counted else { return };
        let fewer = halves.iter().filter(|h| h.pixels > 0).map(|h| h.samples).min();
        sums.samples = fewer.unwrap_or(0);
        sums.changed = true;
        sums.join_data(&self.keep, light);
        for &(x, y, radiance) in light.anywhere.iter().flatten().chain(&light.aimed) {
            self.anywhere[half].add(self.number(x, y), radiance.to_array());
        }
        self.add_squares(half, scattered(light));
    }

    /// The number of a pixel in lists of the whole picture.
    fn number(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// Ends a pass of a tile whose halves have got their batches.
    pub fn end_pass(&self, tile: usize) {
        self.tile(tile).passes += 1;
    }

    /// The squared relative error of the samples of half of a tile, for the mean over its pixels; `None` if unknown.
    pub fn squared_error(&self, tile: usize, half: usize) -> Option<f32> {
        let (sums, rect) = (self.tile(tile), self.rect(tile));
        sums.halves.as_ref().and_then(|halves| halves[half].squared_error(half, rect, sums.light.rect, self.exposure))
    }

    /// Number of samples of each pixel, rows from below.
    pub fn sample_counts(&self) -> Vec<u32> {
        let mut out = vec![0; self.width as usize * self.height as usize];
        for (i, &(rect, _)) in self.tiles.iter().enumerate() {
            let tile = self.tile(i);
            for (half, (x, y)) in [0, 1].into_iter().flat_map(|half| rect.pixels_of(half).map(move |at| (half, at))) {
                let count = tile.halves.as_ref().map_or(tile.samples, |halves| halves[half].samples);
                out[y as usize * self.width as usize + x as usize] = count;
            }
        }
        out
    }

    /// Samples that every pixel of some tiles has.
    pub fn samples_everywhere(&self, tiles: &[usize]) -> u32 {
        tiles.iter().map(|&i| self.tile(i).samples).min().unwrap_or(0)
    }

    /// The data of the surfaces that each pixel sees, rows from below; zeros if the film was not to keep them.
    pub fn data(&self) -> Vec<DataSums> {
        self.of_pixels(1, |tile, at, out| {
            if let Some(sums) = tile.light.data.get(at) {
                out[0] = *sums;
            }
        })
    }

    /// The motion vectors of each pixel, rows from below; zeros if the film was not to keep them.
    pub fn vectors(&self) -> Vec<VectorSums> {
        self.of_pixels(1, |tile, at, out| {
            if let Some(sums) = tile.light.vectors.get(at) {
                out[0] = *sums;
            }
        })
    }

    /// The mattes that are kept.
    pub fn mattes(&self) -> &Mattes {
        &self.keep.mattes
    }

    /// A layer of mattes: all of its passes' channels pixel by pixel, rows from below.
    pub fn matte(&self, layer: MatteLayer) -> Vec<f32> {
        self.of_pixels(4 * self.keep.mattes.passes(), |tile, at, channels| {
            self.keep.mattes.write(layer, &tile.mattes, at, channels);
        })
    }

    /// The pass index that most of each pixel's rays hit, rows from below.
    pub fn most_seen(&self, layer: MatteLayer) -> Vec<f32> {
        self.of_pixels(1, |tile, at, out| out[0] = tile.mattes.most_seen(&self.keep.mattes, layer, at) as i32 as f32)
    }
}

impl TileSums {
    /// Makes room before the first pass.
    fn begin(&mut self, keep: &FilmChannels) {
        let pixels = (self.light.rect.width * self.light.rect.height) as usize;
        if self.has_begun(pixels) {
            return;
        }
        let TileAccumulator { sums, data, vectors, .. } = TileAccumulator::new(self.light.rect, keep);
        (self.light.data, self.light.vectors) = (data, vectors);
        match &mut self.halves {
            Some(halves) => halves.iter_mut().for_each(|half| half.begin(pixels)),
            None => self.light.sums = sums,
        }
        if let Some(squares) = &mut self.squares {
            squares.begin(pixels);
        }
    }

    fn has_begun(&self, pixels: usize) -> bool {
        self.halves.as_ref().map_or(self.light.sums.len(), |halves| halves[0].sums.len()) == pixels
    }

    fn join_data(&mut self, keep: &FilmChannels, from: &TileAccumulator) {
        for (sums, add) in self.light.data.iter_mut().zip(&from.data) {
            sums.join(add);
        }
        for (sums, add) in self.light.vectors.iter_mut().zip(&from.vectors) {
            sums.join(add);
        }
        if let Some(notes) = &from.mattes {
            self.mattes.join(&keep.mattes, notes);
        }
    }
}

/// A picture in tiles, rows from below.
fn cut(width: u32, height: u32, size: u32) -> Vec<TileRect> {
    let rows = (0..height).step_by(size as usize);
    let tile = |x, y| TileRect { x, y, width: size.min(width - x), height: size.min(height - y) };
    rows.flat_map(|y| (0..width).step_by(size as usize).map(move |x| tile(x, y))).collect()
}

#[cfg(test)]
mod tests;
