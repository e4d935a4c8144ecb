//! What has reached the film: sums by pixel, in tiles that are filled by one thread at a time.
//!
//! A tile keeps the light of its own samples, also what fell beyond its edge: each pixel is the sum of what the tiles
//! about it gave, each divided by its own count of samples. So the picture is right at any moment, however far the
//! tiles are. Light that fell farther is kept by pixel alone ([`splats`]).
//!
//! Pixel (0, 0) is the lower left corner of the picture.

pub mod cryptomatte;
pub mod data;
pub mod splats;

use crate::Rgb;
use crate::integrator::path::FirstSurface;
use cryptomatte::{MatteLayer, MatteNotes, MatteSums, Mattes};
use data::{DataSums, VectorSums};
use glam::Vec4;
use splats::SplatSums;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Side of a tile in pixels. Larger tiles leave threads idle at the end of a pass; smaller ones cost messages.
pub const TILE_SIZE: u32 = 32;
/// How far beyond its edge, in pixels, a tile keeps its own light, where light spreads at all: more costs memory, less
/// sends more to the sums by pixel, which are slower. Less than a tile.
const SPREAD: u32 = 8;

/// A part of the picture: lower left corner and size, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// Left edge.
    pub x: u32,
    /// Lower edge.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
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

    /// Where a pixel lies in a list of the rows from below; `None` outside.
    #[inline]
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        // A pixel to the left is far to the right of everything.
        let (column, row) = (x.wrapping_sub(self.x), y.wrapping_sub(self.y));
        (column < self.width && row < self.height).then(|| (row * self.width + column) as usize)
    }
}

/// What a film keeps beside light.
#[derive(Clone, Debug, Default)]
pub struct Keep {
    /// What surfaces the pixels see.
    pub surfaces: bool,
    /// How these move over the picture.
    pub vectors: bool,
    /// Which objects or materials they are.
    pub mattes: Mattes,
}

/// Light on a part of the picture, while one thread gathers it.
#[derive(Clone, Debug)]
pub struct Patch {
    rect: TileRect,
    /// Radiance and alpha by pixel, rows from below.
    sums: Vec<[f32; 4]>,
    /// What fell outside.
    far: Vec<(u32, u32, Rgb)>,
    /// By pixel, as the sums; empty if nobody asked.
    data: Vec<DataSums>,
    /// The same.
    vectors: Vec<VectorSums>,
    mattes: Option<Box<MatteNotes>>,
}

impl Patch {
    fn new(rect: TileRect, keep: &Keep) -> Self {
        let pixels = (rect.width * rect.height) as usize;
        Self {
            rect,
            sums: vec![[0.0; 4]; pixels],
            far: Vec::new(),
            data: if keep.surfaces { vec![DataSums::default(); pixels] } else { Vec::new() },
            vectors: if keep.vectors { vec![VectorSums::default(); pixels] } else { Vec::new() },
            mattes: (!keep.mattes.is_empty()).then(|| Box::new(MatteNotes::new(pixels))),
        }
    }

    /// Notes what a ray of a pixel of the tile found, if anybody asked.
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

    /// Notes how what a ray of a pixel of the tile found moves over the picture, if anybody asked.
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

    /// The same for radiance with a 0 behind it.
    #[inline]
    pub fn add_wide(&mut self, x: u32, y: u32, radiance: Vec4) {
        match self.rect.index(x, y) {
            Some(i) => {
                let sum = &mut self.sums[i];
                *sum = (Vec4::from_array(*sum) + radiance).to_array();
            }
            None => self.far.push((x, y, radiance.truncate())),
        }
    }

    /// Adds alpha to a pixel of the tile.
    #[inline]
    pub fn add_alpha(&mut self, x: u32, y: u32, alpha: f32) {
        if let Some(i) = self.rect.index(x, y) {
            self.sums[i][3] += alpha;
        }
    }
}

/// Sums of one tile.
#[derive(Clone, Debug)]
pub struct TileSums {
    light: Patch,
    mattes: MatteSums,
    /// Samples of each of its pixels.
    pub samples: u32,
    /// Passes that have been added.
    pub passes: u32,
    changed: bool,
}

/// A finished part of the picture.
#[derive(Clone, Debug)]
pub struct TilePixels {
    /// Where.
    pub rect: TileRect,
    /// Scene-linear RGBA, rows from below.
    pub pixels: Vec<[f32; 4]>,
}

/// All tiles of a picture.
pub struct Film {
    width: u32,
    height: u32,
    /// By distance from the centre.
    tiles: Vec<(TileRect, Mutex<TileSums>)>,
    /// The tiles in rows from below.
    places: Vec<usize>,
    far: SplatSums,
    keep: Keep,
}

impl Film {
    /// An empty film; tiles in order of their distance from the centre, where one looks first. `spreads` if samples
    /// give light to other pixels than their own.
    /// `with_data` if it shall also keep what surfaces the pixels see.
    pub fn new(width: u32, height: u32, spreads: bool, with_data: bool) -> Self {
        Self::keeping(width, height, spreads, Keep { surfaces: with_data, ..Keep::default() })
    }

    /// The same, with all that it shall keep.
    pub fn keeping(width: u32, height: u32, spreads: bool, keep: Keep) -> Self {
        let mut rects = Vec::new();
        for y in (0..height).step_by(TILE_SIZE as usize) {
            for x in (0..width).step_by(TILE_SIZE as usize) {
                rects.push(TileRect { x, y, width: TILE_SIZE.min(width - x), height: TILE_SIZE.min(height - y) });
            }
        }
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
        let margin = if spreads { SPREAD } else { 0 };
        let tile = |&place: &usize| {
            let light = Patch::new(rects[place].grown(margin, width, height), &keep);
            let mattes = MatteSums::default();
            (rects[place], Mutex::new(TileSums { light, mattes, samples: 0, passes: 0, changed: false }))
        };
        let far = SplatSums::new(width as usize * height as usize);
        Self { width, height, tiles: order.iter().map(tile).collect(), places, far, keep }
    }

    /// Columns and rows.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// How many tiles there are.
    pub fn tile_count(&self) -> usize {
        self.tiles.len()
    }

    /// Where a tile lies.
    pub fn rect(&self, tile: usize) -> TileRect {
        self.tiles[tile].0
    }

    /// An empty patch for the samples of a tile.
    pub fn patch(&self, tile: usize) -> Patch {
        Patch::new(self.tile(tile).light.rect, &self.keep)
    }

    /// A tile's sums, for as long as the guard lives.
    pub fn tile(&self, tile: usize) -> MutexGuard<'_, TileSums> {
        // A panic elsewhere leaves sums of whole passes behind: still good.
        self.tiles[tile].1.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds pass number `pass` of a tile, of `samples` a pixel, if the passes before it are there; else gives it back.
    pub fn add_pass(&self, tile: usize, pass: u32, light: Patch, samples: u32) -> Result<(), Box<Patch>> {
        let mut sums = self.tile(tile);
        if sums.passes != pass {
            return Err(Box::new(light));
        }
        for (sum, add) in sums.light.sums.iter_mut().zip(&light.sums) {
            for (s, a) in sum.iter_mut().zip(add) {
                *s += a;
            }
        }
        for (sums, add) in sums.light.data.iter_mut().zip(&light.data) {
            sums.join(add);
        }
        for (sums, add) in sums.light.vectors.iter_mut().zip(&light.vectors) {
            sums.join(add);
        }
        if let Some(notes) = &light.mattes {
            sums.mattes.join(&self.keep.mattes, notes);
        }
        for &(x, y, radiance) in &light.far {
            self.far.add(y as usize * self.width as usize + x as usize, radiance.to_array());
        }
        sums.samples += samples;
        sums.passes += 1;
        sums.changed = true;
        Ok(())
    }

    /// Samples that every pixel has.
    pub fn samples_everywhere(&self) -> u32 {
        (0..self.tiles.len()).map(|i| self.tile(i).samples).min().unwrap_or(0)
    }

    /// The tiles that changed since the last call.
    pub fn take_changed(&self) -> Vec<TilePixels> {
        let changed: Vec<usize> =
            (0..self.tiles.len()).filter(|&i| std::mem::take(&mut self.tile(i).changed)).collect();
        changed.into_iter().map(|i| TilePixels { rect: self.rect(i), pixels: self.means(i) }).collect()
    }

    /// The whole picture as it is now, rows from below; black where nothing arrived yet.
    pub fn picture(&self) -> Vec<[f32; 4]> {
        let mut out = vec![[0.0; 4]; self.width as usize * self.height as usize];
        for (i, (rect, _)) in self.tiles.iter().enumerate() {
            let means = self.means(i);
            for (row, line) in means.chunks_exact(rect.width as usize).enumerate() {
                let start = (rect.y as usize + row) * self.width as usize + rect.x as usize;
                out[start..start + line.len()].copy_from_slice(line);
            }
        }
        out
    }

    /// What each pixel sees, rows from below; nothing if the film was not to keep it.
    pub fn data(&self) -> Vec<DataSums> {
        let mut out = vec![DataSums::default(); self.width as usize * self.height as usize];
        self.each_pixel(|tile, at, pixel| {
            if let Some(sums) = tile.light.data.get(at) {
                out[pixel] = *sums;
            }
        });
        out
    }

    /// How what each pixel sees moves over the picture, rows from below.
    pub fn vectors(&self) -> Vec<VectorSums> {
        let mut out = vec![VectorSums::default(); self.width as usize * self.height as usize];
        self.each_pixel(|tile, at, pixel| {
            if let Some(sums) = tile.light.vectors.get(at) {
                out[pixel] = *sums;
            }
        });
        out
    }

    /// The mattes that are kept.
    pub fn mattes(&self) -> &Mattes {
        &self.keep.mattes
    }

    /// A layer of mattes: all of its passes' channels pixel by pixel, rows from below.
    pub fn matte(&self, layer: MatteLayer) -> Vec<f32> {
        let channels = 4 * self.keep.mattes.passes();
        let mut out = vec![0.0; channels * self.width as usize * self.height as usize];
        self.each_pixel(|tile, at, pixel| {
            self.keep.mattes.write(layer, &tile.mattes, at, &mut out[channels * pixel..][..channels]);
        });
        out
    }

    /// Calls `what` with each pixel's tile, its place in that tile's lists, and its place in the picture.
    fn each_pixel(&self, mut what: impl FnMut(&TileSums, usize, usize)) {
        for (i, (rect, _)) in self.tiles.iter().enumerate() {
            let tile = self.tile(i);
            for (x, y) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (rect.x + x, rect.y + y))) {
                if let Some(at) = tile.light.rect.index(x, y) {
                    what(&tile, at, y as usize * self.width as usize + x as usize);
                }
            }
        }
    }

    /// A tile's pixels: its own light and what the tiles about it gave.
    fn means(&self, tile: usize) -> Vec<[f32; 4]> {
        let rect = self.rect(tile);
        let mut out = vec![[0.0f32; 4]; (rect.width * rect.height) as usize];
        let columns = self.width.div_ceil(TILE_SIZE);
        let rows = self.height.div_ceil(TILE_SIZE);
        let (column, row) = (rect.x / TILE_SIZE, rect.y / TILE_SIZE);
        for j in row.saturating_sub(1)..(row + 2).min(rows) {
            for i in column.saturating_sub(1)..(column + 2).min(columns) {
                let from = self.tile(self.places[(j * columns + i) as usize]);
                if from.samples > 0 {
                    give(&from.light, 1.0 / from.samples as f32, rect, &mut out);
                }
            }
        }
        if !self.far.is_empty() {
            let samples = self.tile(tile).samples.max(1);
            for (i, pixel) in out.iter_mut().enumerate() {
                let (x, y) = (rect.x as usize + i % rect.width as usize, rect.y as usize + i / rect.width as usize);
                let sum = self.far.get(y * self.width as usize + x);
                pixel.iter_mut().zip(sum).for_each(|(p, s)| *p += (s / f64::from(samples)) as f32);
            }
        }
        out
    }
}

/// Adds what of a tile's light falls on `rect` to its pixels.
fn give(light: &Patch, scale: f32, rect: TileRect, to: &mut [[f32; 4]]) {
    let columns = light.rect.x.max(rect.x)..(light.rect.x + light.rect.width).min(rect.x + rect.width);
    for y in light.rect.y.max(rect.y)..(light.rect.y + light.rect.height).min(rect.y + rect.height) {
        for x in columns.clone() {
            if let (Some(a), Some(b)) = (light.rect.index(x, y), rect.index(x, y)) {
                to[b].iter_mut().zip(light.sums[a]).for_each(|(to, sum)| *to += sum * scale);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_picture_once() {
        for (w, h) in [(1, 1), (32, 32), (33, 31), (160, 90)] {
            let film = Film::new(w, h, true, false);
            let mut seen = vec![0; (w * h) as usize];
            for i in 0..film.tile_count() {
                let r = film.rect(i);
                for y in r.y..r.y + r.height {
                    for x in r.x..r.x + r.width {
                        seen[(y * w + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn means_and_changes() {
        let film = Film::new(40, 8, false, false);
        for green in [4.0, 0.0] {
            let mut patch = film.patch(0);
            let r = film.rect(0);
            for (x, y) in (0..r.height).flat_map(|y| (0..r.width).map(move |x| (x, y))) {
                patch.add(x, y, Rgb::new(2.0, green, 1.5 * green));
                patch.add_alpha(x, y, 2.0);
            }
            assert!(film.add_pass(0, 7, patch.clone(), 2).is_err());
            film.add_pass(0, if green > 0.0 { 0 } else { 1 }, patch, 2).unwrap();
        }
        let changed = film.take_changed();
        assert_eq!(changed.len(), 1);
        assert_eq!(changed[0].pixels[0], [1.0, 1.0, 1.5, 1.0]);
        assert!(film.take_changed().is_empty());
        assert_eq!(film.samples_everywhere(), 0);
        assert_eq!(film.picture().iter().filter(|p| p[3] > 0.0).count(), 256);
    }

    /// Tiles that are at different counts of samples: light beyond an edge is divided by the count of where it came from.
    #[test]
    fn light_beyond_an_edge_counts_once() {
        let film = Film::new(70, 40, true, false);
        let mut expected = vec![0.0f32; 70 * 40];
        for tile in 0..film.tile_count() {
            let samples = 1 + tile as u32;
            let (r, mut patch) = (film.rect(tile), film.patch(tile));
            for k in 0..200u32 {
                // Near and far places.
                let (dx, dy) = ((k * 7919) % 90, (k * 104_729) % 31);
                let (x, y) = ((r.x + dx).saturating_sub(40).min(69), (r.y + dy).saturating_sub(10).min(39));
                patch.add(x, y, Rgb::splat(samples as f32));
                if patch.rect.index(x, y).is_some() {
                    expected[(y * 70 + x) as usize] += 1.0;
                } else {
                    // Divided by the receiving tile's own count.
                    let to = (0..film.tile_count()).find(|&t| film.rect(t).index(x, y).is_some()).unwrap();
                    expected[(y * 70 + x) as usize] += samples as f32 / (1 + to) as f32;
                }
            }
            film.add_pass(tile, 0, patch, samples).unwrap();
        }
        for (pixel, expected) in film.picture().iter().zip(expected) {
            assert!((pixel[0] - expected).abs() < 1e-4, "{pixel:?} {expected}");
        }
    }
}
