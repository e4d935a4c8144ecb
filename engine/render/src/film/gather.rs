//! Pixels from sums: the light of the tiles in and about a part of the picture, each divided by its own counts.

use super::{Film, TILE_SIZE, TilePixels, TileRect, cut};
use std::collections::HashSet;

/// Light that is kept neither by tile nor divided yet, where counts differ.
#[derive(Default)]
pub(super) struct GatheredLight {
    /// The light by pixel of the picture, if there is any.
    far: Vec<[f32; 3]>,
    /// Factor of each half's sums of light from anywhere.
    pub scales: [f64; 2],
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

    /// The light that no tile keeps, where sample counts differ.
    pub(super) fn scattered(&self) -> GatheredLight {
        let mut out = GatheredLight::default();
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
    fn means(&self, rect: TileRect, scattered: &GatheredLight) -> Vec<[f32; 4]> {
        let (sums, samples) = self.sums(rect, scattered);
        sums.iter().map(|sum| sum.map(|s| (s / samples) as f32)).collect()
    }

    /// The pixels of a part of the picture as sums, and their divisor: the sample count of the tile where all tiles that give light to it
    /// have the same count, so that nothing is rounded before the division; else one.
    fn sums(&self, rect: TileRect, scattered: &GatheredLight) -> (Vec<[f64; 4]>, f64) {
        let mut out = vec![[0.0f64; 4]; (rect.width * rect.height) as usize];
        let columns = self.width.div_ceil(self.tile_size);
        let rows = self.height.div_ceil(self.tile_size);
        let about = |from: u32, size: u32, count: u32| {
            (from / self.tile_size).saturating_sub(1)..((from + size - 1) / self.tile_size + 2).min(count)
        };
        let about: Vec<usize> = about(rect.y, rect.height, rows)
            .flat_map(|j| about(rect.x, rect.width, columns).map(move |i| (j, i)))
            .map(|(j, i)| self.places[(j * columns + i) as usize])
            .collect();
        let own =
            self.tile(self.places[(rect.y / self.tile_size * columns + rect.x / self.tile_size) as usize]).samples;
        let is_even = !self.keep.halves && own > 0 && about.iter().all(|&tile| self.tile(tile).samples == own);
        let divisor = if is_even { f64::from(own) } else { 1.0 };
        for tile in about {
            let from = self.tile(tile);
            if let Some(halves) = &from.halves {
                for half in halves.iter().filter(|half| half.samples > 0) {
                    let sums = half.sums.iter().map(|sum| sum.map(f64::from));
                    give(from.light.rect, sums, f64::from(half.samples), rect, &mut out);
                }
            } else if from.samples > 0 {
                let by = f64::from(from.samples) / divisor;
                give(from.light.rect, from.light.sums.iter().copied(), by, rect, &mut out);
            }
        }
        let number = |i: usize| {
            let (x, y) = (rect.x as usize + i % rect.width as usize, rect.y as usize + i / rect.width as usize);
            y * self.width as usize + x
        };
        // A tile that has not begun is black; how the light that falls there is to be divided is not known yet.
        if !self.far.is_empty() && own > 0 {
            let by = f64::from(own) / divisor;
            for (i, pixel) in out.iter_mut().enumerate() {
                pixel.iter_mut().zip(self.far.get(number(i))).for_each(|(p, s)| *p += s / by);
            }
        }
        if !scattered.far.is_empty() {
            for (i, pixel) in out.iter_mut().enumerate() {
                pixel.iter_mut().zip(scattered.far[number(i)]).for_each(|(p, s)| *p += f64::from(s));
            }
        }
        for (sums, scale) in self.anywhere.iter().zip(scattered.scales).filter(|(sums, _)| !sums.is_empty()) {
            for (i, pixel) in out.iter_mut().enumerate() {
                pixel.iter_mut().zip(sums.get(number(i))).for_each(|(p, s)| *p += s * scale);
            }
        }
        for (i, pixel) in out.iter_mut().enumerate() {
            let gain = self.gains.get(number(i)).map_or(1.0, |&gain| f64::from(gain)) * f64::from(self.exposure);
            pixel[..3].iter_mut().for_each(|part| *part *= gain);
        }
        (out, divisor)
    }

    /// The rounding of the picture's numbers: the rest of the sums of its samples, rows from below, by pixel as two numbers of single
    /// precision for each channel. With c the picture's number, n the samples and r, s these two, the sum is c n + r + s, exactly; so
    /// ranges of samples that are joined ([`Film::picture`] of each) make the whole to the last bit. Nothing where counts differ.
    pub fn remainders(&self) -> Vec<[[f32; 4]; 2]> {
        let mut out = vec![[[0.0; 4]; 2]; self.width as usize * self.height as usize];
        if self.keep.halves {
            return out;
        }
        let (scattered, counts) = (self.scattered(), self.sample_counts());
        for rect in cut(self.width, self.height, TILE_SIZE) {
            let (sums, divisor) = self.sums(rect, &scattered);
            for (i, sum) in sums.iter().enumerate() {
                let (x, y) = (rect.x as usize + i % rect.width as usize, rect.y as usize + i / rect.width as usize);
                let number = y * self.width as usize + x;
                let samples = f64::from(counts[number]);
                for (channel, sum) in sum.iter().enumerate() {
                    // Where the tiles about have other counts there is a mean alone.
                    let whole = if divisor == samples { *sum } else { sum / divisor * samples };
                    let rest = whole - f64::from((sum / divisor) as f32) * samples;
                    let first = rest as f32;
                    out[number][0][channel] = first;
                    out[number][1][channel] = (rest - f64::from(first)) as f32;
                }
            }
        }
        out
    }
}

/// Adds what of a tile's light, sums in their own rectangle, falls on `rect` to its pixels, divided.
fn give(from: TileRect, sums: impl Iterator<Item = [f64; 4]>, by: f64, rect: TileRect, to: &mut [[f64; 4]]) {
    for (i, sum) in sums.enumerate() {
        let (x, y) = (from.x + i as u32 % from.width, from.y + i as u32 / from.width);
        if let Some(pixel) = rect.index(x, y) {
            to[pixel].iter_mut().zip(sum).for_each(|(to, sum)| *to += sum / by);
        }
    }
}
