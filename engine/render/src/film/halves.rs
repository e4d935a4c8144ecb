//! Pixels with different counts of samples: a tile's pixels in two halves, as the squares of a chessboard, each with a
//! count of its own.
//!
//! The number of samples of a half is decided by the other half's light, never by its own: so each of its pixels is the mean of a number of
//! samples that does not depend on them, and true in the mean. For the other half's word, samples may be needed beyond a half's own count:
//! they are seen, for the error, but not counted in the picture.
//!
//! The error is that of the means of batches. Of K batches with N samples a pixel in all, S_k their sums, Q = Σ |S_k|² / n_k
//! over the channels and S = Σ S_k, a pixel's squared error is v = 3 (Q - |S|² / N) / (N (K - 1)): that of the sum of the
//! channels, if they err together. It counts relative to the brightness s, the sum of the channels, as Cycles has it:
//! e² = mean of v / max(s, s², 0.003) over the half, so that e is relative to the square root of s for dark pixels, to s for
//! bright ones. A half's light may land in the pixels of the other, so s is that of the pixels about: their light of
//! this half, divided by how many of them start it. Light that lands farther from its tile than is kept by pixel counts
//! by its squares alone, relative to the mean of the half.

use super::variance::sample_variance;
use super::{TileAccumulator, TileRect};
use serde::{Deserialize, Serialize};

/// Pixels on a side of the tiles whose counts are decided together: small enough to follow an edge that is unsharp, large
/// enough to know their error from few samples.
pub(crate) const BLOCK_SIZE: u32 = 8;
/// Distance beyond its edge, in pixels, within which a block keeps its light pixel by pixel.
pub(super) const BLOCK_SPREAD: u32 = 2;
/// Brightness, sum of channels, below which nothing needs to be truer: a third of it is the step of eight bits near white.
const DARK: f32 = 0.003;

/// The half that a pixel belongs to.
#[inline]
pub fn half_of(x: u32, y: u32) -> usize {
    ((x + y) & 1) as usize
}

/// The sums of a half.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Half {
    /// Pixels that start samples.
    pub pixels: u32,
    /// The sums of radiance and alpha, as in a patch; empty before the first batch.
    #[serde(with = "super::packed")]
    pub sums: Vec<[f32; 4]>,
    /// Colours beyond the patch by number of the pixel in the picture, in rising order.
    pub far: Vec<(u32, [f32; 3])>,
    /// Samples of each of its pixels in `sums`.
    pub samples: u32,
    error: Error,
}

/// Sums for the error, over all samples, also those that are not counted.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Error {
    /// Q, by pixel of the patch.
    #[serde(with = "super::packed")]
    squares: Vec<f32>,
    /// S, by pixel of the patch, once there are samples that are not counted.
    sums: Option<Sums>,
    samples: u32,
    batches: u32,
    /// Samples of the largest batch.
    largest: u32,
    /// Light that is not in the patch: squares and sum of the colours.
    scattered: [f64; 2],
}

/// Sums by pixel of a patch.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Sums(#[serde(with = "super::packed")] Vec<[f32; 4]>);

impl Half {
    /// One that has no samples yet.
    pub(super) fn new(pixels: u32) -> Self {
        Self { pixels, sums: Vec::new(), far: Vec::new(), samples: 0, error: Error::default() }
    }

    /// Makes room for the first batch.
    pub(super) fn begin(&mut self, patch_pixels: usize) {
        self.sums = vec![[0.0; 4]; patch_pixels];
        self.error.squares = vec![0.0; patch_pixels];
    }

    /// True if it is a half of so many pixels, begun, of a tile with a patch of so many, in a picture of so many.
    pub(super) fn is_of(&self, pixels: u32, patch_pixels: usize, picture_pixels: usize) -> bool {
        let error = &self.error;
        self.pixels == pixels
            && self.sums.len() == patch_pixels
            && error.squares.len() == patch_pixels
            && error.sums.as_ref().is_none_or(|sums| sums.0.len() == patch_pixels)
            && self.far.iter().all(|&(pixel, _)| (pixel as usize) < picture_pixels)
    }

    /// Adds a batch: samples for the picture, and others behind them for the error alone, each with their number a pixel. The
    /// error is of the batch as a whole, so that it does not depend on where the count ends. `width` is the picture's.
    pub(super) fn add(
        &mut self,
        counted: Option<(&TileAccumulator, u32)>,
        beyond: Option<(&TileAccumulator, u32)>,
        width: u32,
    ) {
        let error = &mut self.error;
        let batch: u32 = counted.iter().chain(&beyond).map(|(_, samples)| samples).sum();
        for (i, square) in error.squares.iter_mut().enumerate() {
            let parts = counted.iter().chain(&beyond).map(|(patch, _)| patch.sums[i]);
            let [r, g, b] = parts.fold([0.0; 3], |[r, g, b], part| [r + part[0], g + part[1], b + part[2]]);
            *square += (r * r + g * g + b * b) as f32 / batch as f32;
        }
        for (patch, samples) in counted.iter().chain(&beyond) {
            for (_, _, colour) in patch.far.iter().chain(patch.anywhere.iter().flatten()) {
                error.scattered[0] += f64::from(colour.length_squared());
                error.scattered[1] += f64::from(colour.element_sum());
            }
            error.samples += samples;
        }
        error.batches += 1;
        error.largest = error.largest.max(batch);
        if let Some((patch, samples)) = counted {
            self.samples += samples;
            add(&mut self.sums, &patch.sums);
            self.add_far(patch, width);
        }
        if let Some((patch, _)) = beyond {
            add(&mut self.error.sums.get_or_insert_with(|| Sums(self.sums.clone())).0, &patch.sums);
        }
    }

    fn add_far(&mut self, patch: &TileAccumulator, width: u32) {
        if patch.far.is_empty() {
            return;
        }
        self.far.extend(patch.far.iter().map(|&(x, y, colour)| (y * width + x, colour.to_array())));
        // Stable: the order of the terms, and with it the bits, is that of the samples.
        self.far.sort_by_key(|&(pixel, _)| pixel);
        self.far.dedup_by(|(pixel, add), (kept, sum)| {
            let same = pixel == kept;
            if same {
                sum.iter_mut().zip(*add).for_each(|(s, a)| *s += a);
            }
            same
        });
    }

    /// The variance of the mean of the counted samples in pixel number `i` of the patch ([`sample_variance`]); `None` if one batch has all
    /// samples.
    pub(super) fn variance(&self, i: usize) -> Option<f32> {
        if self.pixels == 0 {
            return Some(0.0);
        }
        let error = &self.error;
        let &[r, g, b, _] = error.sums.as_ref().map_or(&self.sums, |sums| &sums.0).get(i)?;
        let of_sample = sample_variance(error.squares[i], r * r + g * g + b * b, error.samples, error.largest);
        of_sample.map(|v| v / self.samples as f32)
    }

    /// The squared relative error of the samples of this half, of that number, of a tile, with the rectangle of its sums, in a
    /// picture with that exposure; `None` where it cannot be told.
    pub(super) fn squared_error(&self, half: usize, tile: TileRect, patch: TileRect, exposure: f32) -> Option<f32> {
        let error = &self.error;
        if self.pixels == 0 || error.batches < 2 {
            return None;
        }
        let (n, pixels) = (error.samples as f32, self.pixels as f32);
        let sums = error.sums.as_ref().map_or(&self.sums, |sums| &sums.0);
        let brightness: Vec<f32> = sums.iter().map(|&[r, g, b, _]| exposure * (r + g + b) / n).collect();
        let [squares, scattered] = error.scattered.map(|sum| sum as f32 / (pixels * n));
        let scattered = exposure * scattered;
        let mean = brightness.iter().sum::<f32>() / pixels + scattered;
        let mut relative = squares / n / weight(mean);
        for (i, (&[r, g, b, _], square)) in sums.iter().zip(&error.squares).enumerate() {
            let (x, y) = (patch.x + i as u32 % patch.width, patch.y + i as u32 / patch.width);
            let (mut light, mut starts) = (0.0, 0.0);
            for (x, y) in (y.saturating_sub(1)..=y + 1).flat_map(|y| (x.saturating_sub(1)..=x + 1).map(move |x| (x, y)))
            {
                light += patch.index(x, y).map_or(0.0, |k| brightness[k]);
                starts += f32::from(u8::from(half_of(x, y) == half && tile.index(x, y).is_some()));
            }
            let s = if starts > 0.0 { light / starts + scattered } else { mean };
            let spread = (square - (r * r + g * g + b * b) / n).max(0.0) / (error.batches - 1) as f32;
            relative += spread / (n * pixels) / weight(s);
        }
        Some(3.0 * exposure * exposure * relative)
    }
}

fn add(sums: &mut [[f32; 4]], more: &[[f64; 4]]) {
    for (sum, add) in sums.iter_mut().zip(more) {
        sum.iter_mut().zip(add).for_each(|(s, a)| *s += *a as f32);
    }
}

/// The reference of a relative squared error at a brightness.
pub(crate) fn weight(brightness: f32) -> f32 {
    brightness.max(brightness * brightness).max(DARK)
}

#[cfg(test)]
mod tests {
    use super::super::{Film, FilmChannels};
    use crate::Rgb;
    use crate::sampler::mix;

    fn number(k: u32) -> f32 {
        (mix(k) >> 8) as f32 / (1u32 << 24) as f32
    }

    /// The estimate is the squared error that means of so many samples have, whether light stays in its pixel or is
    /// scattered, whether samples are counted or not; it is that of the picture, with its exposure.
    #[test]
    fn the_error_is_that_of_the_mean() {
        for (scatters, bright, exposure) in [(false, 0.5, 1.0), (false, 3.0, 1.0), (true, 0.5, 1.0), (false, 0.5, 8.0)]
        {
            let keep = FilmChannels { halves: true, ..FilmChannels::default() };
            let film = Film::keeping(64, 64, scatters, keep).exposed(exposure);
            let (mut sum, mut blocks) = (0.0, 0);
            for tile in 0..film.tile_count() {
                let r = film.rect(tile);
                for batch in 0..8u32 {
                    let mut patch = film.patch(tile);
                    for (x, y) in r.pixels_of(1) {
                        for i in 0..4 {
                            // Once in four times four times as bright: the variance is three squares.
                            let u = number((x + 64 * y) * 32 + 4 * batch + i);
                            let value = if u < 0.25 { 4.0 * bright / exposure } else { 0.0 };
                            if scatters {
                                patch.add_anywhere(x ^ 32, y, Rgb::splat(value / 3.0));
                            } else {
                                patch.add(x, y, Rgb::splat(value / 3.0));
                            }
                        }
                    }
                    let part = Some((&patch, 4));
                    let (counted, beyond) = if batch < 5 { (part, None) } else { (None, part) };
                    film.add_batch(tile, 1, counted, beyond);
                }
                sum += film.squared_error(tile, 1).unwrap();
                blocks += 1;
            }
            assert_eq!(film.tile(0).halves.as_ref().unwrap()[1].samples, 20);
            // Of 32 samples; scattered light counts by its squares.
            let variance = if scatters { 4.0 } else { 3.0 } * bright * bright;
            let expected = variance / 32.0 / bright.max(bright * bright);
            let found = sum / blocks as f32;
            // 2048 pixels with 7 degrees of freedom; the brightness about a pixel is known to a fifth, and
            // what is relative to less than the truth counts more.
            assert!((0.95..1.15).contains(&(found / expected)), "{found} {expected}");
        }
    }
}
