//! Pixels from sums: the light of the tiles in and about a part of the picture, each divided by its own counts.

use super::splats::SplatSums;
use super::{Film, TILE_SIZE, TilePixels, TileRect, TileSums, cut};
use rayon::prelude::*;
use std::collections::HashSet;

/// Light that is kept neither by tile nor divided yet, where counts differ.
#[derive(Default)]
pub(super) struct GatheredLight {
    /// The light by pixel of the picture, if there is any.
    far: Vec<[f32; 3]>,
    /// Factor of each half's sums of light from anywhere.
    pub scales: [f64; 2],
}

/// Number of samples of the tile that a part of the picture is in, and the divisor of [`Film::sums`].
#[derive(Clone, Copy)]
pub(super) struct CountsAbout {
    pub own: u32,
    pub divisor: f64,
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
    pub(super) fn part(&self, tile: TileRect) -> TileRect {
        let (x, y) = (tile.x / TILE_SIZE * TILE_SIZE, tile.y / TILE_SIZE * TILE_SIZE);
        TileRect { x, y, width: TILE_SIZE.min(self.width - x), height: TILE_SIZE.min(self.height - y) }
    }

    /// The whole picture as it is now, rows from below; black where nothing arrived yet. In parallel on the current rayon pool.
    pub fn picture(&self) -> Vec<[f32; 4]> {
        if let Some(picture) = self.parked_picture() {
            return picture;
        }
        let scattered = self.scattered();
        let width = self.width as usize;
        let mut out = vec![[0.0; 4]; width * self.height as usize];
        let rows = out.par_chunks_mut(width * TILE_SIZE as usize).enumerate();
        rows.for_each(|(row, out)| {
            let y = row as u32 * TILE_SIZE;
            for x in (0..self.width).step_by(TILE_SIZE as usize) {
                let rect = self.part(TileRect { x, y, width: 1, height: 1 });
                for (line, means) in self.means(rect, &scattered).chunks_exact(rect.width as usize).enumerate() {
                    out[line * width + x as usize..][..means.len()].copy_from_slice(means);
                }
            }
        });
        out
    }

    /// So many numbers of each pixel, pixel by pixel, rows from below: `write` gets the pixel's tile, its place in that tile's lists, and its
    /// numbers, which are zero. In parallel on the current rayon pool.
    pub(super) fn of_pixels<T: Copy + Default + Send>(
        &self,
        channels: usize,
        write: impl Fn(&TileSums, usize, &mut [T]) + Sync,
    ) -> Vec<T> {
        let (width, side) = (self.width as usize, self.tile_size as usize);
        let mut out = vec![T::default(); channels * width * self.height as usize];
        if channels == 0 {
            return out;
        }
        let columns = width.div_ceil(side);
        out.par_chunks_mut(channels * width * side).enumerate().for_each(|(row, out)| {
            for &tile in &self.places[row * columns..(row + 1) * columns] {
                let (rect, sums) = (self.rect(tile), self.tile(tile));
                for (y, x) in (0..rect.height).flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (y, x))) {
                    if let Some(at) = sums.light.rect.index(x, rect.y + y) {
                        write(&sums, at, &mut out[channels * (y as usize * width + x as usize)..][..channels]);
                    }
                }
            }
        });
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

    /// The pixels of a part of the picture, as large as a tile at most: the light of the tiles in it and about it.
    fn means(&self, rect: TileRect, scattered: &GatheredLight) -> Vec<[f32; 4]> {
        let (sums, samples) = self.sums(rect, scattered);
        sums.iter().map(|sum| sum.map(|s| (s / samples) as f32)).collect()
    }

    /// The pixels of a part of the picture as sums, and their divisor: the sample count of the tile where all tiles that give light to it
    /// have the same count, so that nothing is rounded before the division; else one.
    fn sums(&self, rect: TileRect, scattered: &GatheredLight) -> (Vec<[f64; 4]>, f64) {
        let mut out = vec![[0.0f64; 4]; (rect.width * rect.height) as usize];
        let counts = self.counts_about(rect, |tile| self.tile(tile).samples);
        for tile in self.about(rect) {
            let from = self.tile(tile);
            if let Some(halves) = &from.halves {
                for half in halves.iter().filter(|half| half.samples > 0) {
                    give(from.light.rect, &half.sums, f64::from(half.samples), rect, &mut out);
                }
            } else if from.samples > 0 {
                give(from.light.rect, &from.light.sums, f64::from(from.samples) / counts.divisor, rect, &mut out);
            }
        }
        self.add_scattered_light(rect, counts, &self.far, scattered, &mut out);
        (out, counts.divisor)
    }

    /// The tiles in a part of the picture and next to it, row by row from below.
    pub(super) fn about(&self, rect: TileRect) -> impl Iterator<Item = usize> {
        let columns = self.width.div_ceil(self.tile_size);
        let rows = self.height.div_ceil(self.tile_size);
        let about = |from: u32, size: u32, count: u32| {
            (from / self.tile_size).saturating_sub(1)..((from + size - 1) / self.tile_size + 2).min(count)
        };
        let across = about(rect.x, rect.width, columns);
        about(rect.y, rect.height, rows)
            .flat_map(move |j| across.clone().map(move |i| (j, i)))
            .map(move |(j, i)| self.places[(j * columns + i) as usize])
    }

    /// The counts by which the light of the tiles about a part of the picture is divided; `samples` gives those of a tile.
    pub(super) fn counts_about(&self, rect: TileRect, samples: impl Fn(usize) -> u32) -> CountsAbout {
        let columns = self.width.div_ceil(self.tile_size);
        let own = samples(self.places[(rect.y / self.tile_size * columns + rect.x / self.tile_size) as usize]);
        let is_even = !self.keep.halves && own > 0 && self.about(rect).all(|tile| samples(tile) == own);
        CountsAbout { own, divisor: if is_even { f64::from(own) } else { 1.0 } }
    }

    /// Adds light that no tile keeps to the sums of a part of the picture, and multiplies by the film's factors.
    pub(super) fn add_scattered_light(
        &self,
        rect: TileRect,
        counts: CountsAbout,
        far: &SplatSums,
        scattered: &GatheredLight,
        out: &mut [[f64; 4]],
    ) {
        let number = |i: usize| {
            let (x, y) = (rect.x as usize + i % rect.width as usize, rect.y as usize + i / rect.width as usize);
            y * self.width as usize + x
        };
        // A tile that has not begun is black; how the light that falls there is to be divided is not known yet.
        if !far.is_empty() && counts.own > 0 {
            let by = f64::from(counts.own) / counts.divisor;
            for (i, pixel) in out.iter_mut().enumerate() {
                pixel.iter_mut().zip(far.get(number(i))).for_each(|(p, s)| *p += s / by);
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

/// Adds the part of a tile's light, sums in their own rectangle, that falls on `rect` to its pixels, divided.
pub(super) fn give<T: Copy>(from: TileRect, sums: &[[T; 4]], by: f64, rect: TileRect, to: &mut [[f64; 4]])
where
    f64: From<T>,
{
    let (left, right) = (from.x.max(rect.x), (from.x + from.width).min(rect.x + rect.width));
    for y in from.y.max(rect.y)..(from.y + from.height).min(rect.y + rect.height) {
        let place = |of: TileRect, x: u32| ((y - of.y) * of.width + x - of.x) as usize;
        if left >= right {
            return;
        }
        let from = &sums[place(from, left)..][..(right - left) as usize];
        for (to, sum) in to[place(rect, left)..].iter_mut().zip(from) {
            to.iter_mut().zip(sum).for_each(|(to, &sum)| *to += f64::from(sum) / by);
        }
    }
}
