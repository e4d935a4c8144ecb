//! From sums to pixels: the light of the tiles in and about a part of the picture, each divided by its own counts.

use super::{Film, TILE_SIZE, TilePixels, TileRect, cut};
use std::collections::HashSet;

/// Light that is kept neither by tile nor divided yet, where counts differ.
#[derive(Default)]
struct Scattered {
    /// By pixel of the picture, if there is any.
    far: Vec<[f32; 3]>,
    /// What each half's sums of light from anywhere are to be multiplied by.
    scales: [f64; 2],
}

impl Film {
    /// The parts of the picture that changed since the last call.
    pub fn take_changed(&self) -> Vec<TilePixels> {
        let mut changed: Vec<TileRect> = (0..self.tiles.len())
            .filter(|&i| std::mem::take(&mut self.tile(i).changed))
            .map(|i| self.part(self.rect(i)))
            .collect();
        // Those of small tiles are the same for several.
        let mut seen = HashSet::new();
        changed.retain(|rect| seen.insert((rect.x, rect.y)));
        if changed.is_empty() {
            return Vec::new();
        }
        let scattered = self.scattered();
        changed.into_iter().map(|rect| TilePixels { rect, pixels: self.means(rect, &scattered) }).collect()
    }

    /// The part of the picture that a tile is shown with.
    fn part(&self, tile: TileRect) -> TileRect {
        let (x, y) = (tile.x / TILE_SIZE * TILE_SIZE, tile.y / TILE_SIZE * TILE_SIZE);
        TileRect { x, y, width: TILE_SIZE.min(self.width - x), height: TILE_SIZE.min(self.height - y) }
    }

    /// The whole picture as it is now, rows from below; black where nothing arrived yet.
    pub fn picture(&self) -> Vec<[f32; 4]> {
        let scattered = self.scattered();
        let mut out = vec![[0.0; 4]; self.width as usize * self.height as usize];
        for rect in cut(self.width, self.height, TILE_SIZE) {
            let means = self.means(rect, &scattered);
            for (row, line) in means.chunks_exact(rect.width as usize).enumerate() {
                let start = (rect.y as usize + row) * self.width as usize + rect.x as usize;
                out[start..start + line.len()].copy_from_slice(line);
            }
        }
        out
    }

    /// What no tile keeps, where counts differ.
    fn scattered(&self) -> Scattered {
        let mut out = Scattered::default();
        if !self.keep.halves {
            return out;
        }
        let (mut pixels, mut started) = ([0.0; 2], [0.0; 2]);
        for i in 0..self.tiles.len() {
            let tile = self.tile(i);
            for (half, of_half) in tile.halves.iter().flat_map(|halves| halves.iter().enumerate()) {
                pixels[half] += f64::from(of_half.pixels);
                started[half] += f64::from(of_half.pixels) * f64::from(of_half.samples);
                if of_half.far.is_empty() {
                    continue;
                }
                out.far.resize(self.width as usize * self.height as usize, [0.0; 3]);
                for (pixel, colour) in &of_half.far {
                    let to = &mut out.far[*pixel as usize];
                    to.iter_mut().zip(colour).for_each(|(to, sum)| *to += sum / of_half.samples as f32);
                }
            }
        }
        // Light that comes as likely from any pixel: a half stands for its part of them, whichever have how many.
        out.scales = [0, 1].map(|half| if started[half] > 0.0 { pixels[half] / started[half] } else { 0.0 });
        out
    }

    /// The pixels of a part of the picture, as large as a tile at most: what the tiles in it and about it gave.
    fn means(&self, rect: TileRect, scattered: &Scattered) -> Vec<[f32; 4]> {
        let mut out = vec![[0.0f32; 4]; (rect.width * rect.height) as usize];
        let columns = self.width.div_ceil(self.tile_size);
        let rows = self.height.div_ceil(self.tile_size);
        let about = |from: u32, size: u32, count: u32| {
            (from / self.tile_size).saturating_sub(1)..((from + size - 1) / self.tile_size + 2).min(count)
        };
        for j in about(rect.y, rect.height, rows) {
            for i in about(rect.x, rect.width, columns) {
                let from = self.tile(self.places[(j * columns + i) as usize]);
                if let Some(halves) = &from.halves {
                    for half in halves.iter().filter(|half| half.samples > 0) {
                        give((from.light.rect, &half.sums), 1.0 / half.samples as f32, rect, &mut out);
                    }
                } else if from.samples > 0 {
                    give((from.light.rect, &from.light.sums), 1.0 / from.samples as f32, rect, &mut out);
                }
            }
        }
        let number = |i: usize| {
            let (x, y) = (rect.x as usize + i % rect.width as usize, rect.y as usize + i / rect.width as usize);
            y * self.width as usize + x
        };
        if !self.far.is_empty() {
            let tile = self.places[(rect.y / TILE_SIZE * columns + rect.x / TILE_SIZE) as usize];
            let samples = self.tile(tile).samples.max(1);
            for (i, pixel) in out.iter_mut().enumerate() {
                let sum = self.far.get(number(i));
                pixel.iter_mut().zip(sum).for_each(|(p, s)| *p += (s / f64::from(samples)) as f32);
            }
        }
        if !scattered.far.is_empty() {
            for (i, pixel) in out.iter_mut().enumerate() {
                pixel.iter_mut().zip(scattered.far[number(i)]).for_each(|(p, s)| *p += s);
            }
        }
        for (sums, scale) in self.anywhere.iter().zip(scattered.scales).filter(|(sums, _)| !sums.is_empty()) {
            for (i, pixel) in out.iter_mut().enumerate() {
                pixel.iter_mut().zip(sums.get(number(i))).for_each(|(p, s)| *p += (s * scale) as f32);
            }
        }
        if !self.gains.is_empty() {
            for (i, pixel) in out.iter_mut().enumerate() {
                let gain = self.gains[number(i)];
                pixel[..3].iter_mut().for_each(|part| *part *= gain);
            }
        }
        if self.exposure != 1.0 {
            out.iter_mut().flat_map(|pixel| &mut pixel[..3]).for_each(|part| *part *= self.exposure);
        }
        out
    }
}

/// Adds what of a tile's light, sums in their own rectangle, falls on `rect` to its pixels.
fn give((from, sums): (TileRect, &[[f32; 4]]), scale: f32, rect: TileRect, to: &mut [[f32; 4]]) {
    let columns = from.x.max(rect.x)..(from.x + from.width).min(rect.x + rect.width);
    for y in from.y.max(rect.y)..(from.y + from.height).min(rect.y + rect.height) {
        for x in columns.clone() {
            if let (Some(a), Some(b)) = (from.index(x, y), rect.index(x, y)) {
                to[b].iter_mut().zip(sums[a]).for_each(|(to, sum)| *to += sum * scale);
            }
        }
    }
}
