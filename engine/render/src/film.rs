//! What has reached the film: sums by pixel, in tiles that are filled by one thread at a time.
//!
//! Pixel (0, 0) is the lower left corner of the picture.

use crate::Rgb;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Side of a tile in pixels. Larger tiles leave threads idle at the end of a pass; smaller ones cost messages.
pub const TILE_SIZE: u32 = 32;

/// A tile's place: lower left corner and size, pixels.
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

/// Sums of one tile.
#[derive(Clone, Debug)]
pub struct TileSums {
    /// Radiance and alpha by pixel, rows from below.
    pub sums: Vec<[f32; 4]>,
    /// Samples in every pixel's sum.
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
    tiles: Vec<(TileRect, Mutex<TileSums>)>,
}

impl Film {
    /// An empty film; tiles in order of their distance from the centre, where one looks first.
    pub fn new(width: u32, height: u32) -> Self {
        let mut rects = Vec::new();
        for y in (0..height).step_by(TILE_SIZE as usize) {
            for x in (0..width).step_by(TILE_SIZE as usize) {
                rects.push(TileRect { x, y, width: TILE_SIZE.min(width - x), height: TILE_SIZE.min(height - y) });
            }
        }
        let from_centre = |r: &TileRect| {
            let dx = (2 * r.x + r.width) as i64 - width as i64;
            let dy = (2 * r.y + r.height) as i64 - height as i64;
            dx * dx + dy * dy
        };
        rects.sort_by_key(from_centre);
        let tiles = rects
            .into_iter()
            .map(|rect| {
                let sums = vec![[0.0; 4]; (rect.width * rect.height) as usize];
                (rect, Mutex::new(TileSums { sums, samples: 0, passes: 0, changed: false }))
            })
            .collect();
        Self { width, height, tiles }
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

    /// A tile's sums, for as long as the guard lives.
    pub fn tile(&self, tile: usize) -> MutexGuard<'_, TileSums> {
        // A panic elsewhere leaves sums of whole passes behind: still good.
        self.tiles[tile].1.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Samples that every pixel has.
    pub fn samples_everywhere(&self) -> u32 {
        (0..self.tiles.len()).map(|i| self.tile(i).samples).min().unwrap_or(0)
    }

    /// The tiles that changed since the last call.
    pub fn take_changed(&self) -> Vec<TilePixels> {
        let mut out = Vec::new();
        for (i, (rect, _)) in self.tiles.iter().enumerate() {
            let mut tile = self.tile(i);
            if std::mem::take(&mut tile.changed) {
                out.push(TilePixels { rect: *rect, pixels: tile.means() });
            }
        }
        out
    }

    /// The whole picture as it is now, rows from below; black where nothing arrived yet.
    pub fn picture(&self) -> Vec<[f32; 4]> {
        let mut out = vec![[0.0; 4]; self.width as usize * self.height as usize];
        for (i, (rect, _)) in self.tiles.iter().enumerate() {
            let means = self.tile(i).means();
            for (row, line) in means.chunks_exact(rect.width as usize).enumerate() {
                let start = (rect.y as usize + row) * self.width as usize + rect.x as usize;
                out[start..start + line.len()].copy_from_slice(line);
            }
        }
        out
    }
}

impl TileSums {
    /// Adds one pass of `samples` a pixel.
    pub fn add_pass(&mut self, pass: &[[f32; 4]], samples: u32) {
        for (sum, add) in self.sums.iter_mut().zip(pass) {
            for (s, a) in sum.iter_mut().zip(add) {
                *s += a;
            }
        }
        self.samples += samples;
        self.passes += 1;
        self.changed = true;
    }

    fn means(&self) -> Vec<[f32; 4]> {
        let scale = if self.samples > 0 { 1.0 / self.samples as f32 } else { 0.0 };
        self.sums.iter().map(|s| s.map(|v| v * scale)).collect()
    }
}

/// A sum's entry for one sample.
pub fn contribution(radiance: Rgb, alpha: f32) -> [f32; 4] {
    [radiance.x, radiance.y, radiance.z, alpha]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_picture_once() {
        for (w, h) in [(1, 1), (32, 32), (33, 31), (160, 90)] {
            let film = Film::new(w, h);
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
        let film = Film::new(40, 8);
        film.tile(0).add_pass(&vec![[2.0, 4.0, 6.0, 2.0]; 256], 2);
        film.tile(0).add_pass(&vec![[2.0, 0.0, 0.0, 2.0]; 256], 2);
        let changed = film.take_changed();
        assert_eq!(changed.len(), 1);
        assert_eq!(changed[0].pixels[0], [1.0, 1.0, 1.5, 1.0]);
        assert!(film.take_changed().is_empty());
        assert_eq!(film.samples_everywhere(), 0);
        assert_eq!(film.picture().iter().filter(|p| p[3] > 0.0).count(), 256);
    }
}
