//! The variance of the pixels of a picture, estimated from batches of their samples.
//!
//! A pixel has K batches of n_k samples, N in all, with sums S_k. Q = Σ |S_k|² / n_k over the channels, S = Σ S_k, and n the
//! largest n_k. The variance of the mean S / N is taken for v = (Q - |S|² / N) / (N (N / n - 1)), summed over the channels. Of equal
//! batches N / n - 1 is K - 1, and v is the unbiased estimate; of others v is larger. So a single bright sample is never taken
//! for less noise than it is: the square of its part of the mean.
//!
//! The samples of a render come in passes that double until they have their full size. A pass that is as large as all before it makes
//! one batch of these, so that batches stay about equal.

use super::splats::SplatSums;
use super::{Film, TileAccumulator};
use serde::{Deserialize, Serialize};

/// Squares of the sums of batches, where all pixels of a tile have the same count of samples.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct BatchSquares {
    /// Q, by pixel of the patch; empty before the first batch.
    #[serde(with = "super::packed")]
    squares: Vec<f32>,
    /// Samples of the largest batch.
    largest: u32,
}

impl BatchSquares {
    /// The sums of no batch.
    pub(super) fn new() -> Self {
        Self { squares: Vec::new(), largest: 0 }
    }

    /// Makes room for the first batch.
    pub(super) fn begin(&mut self, patch_pixels: usize) {
        self.squares = vec![0.0; patch_pixels];
    }

    /// Number of pixels.
    pub(super) fn len(&self) -> usize {
        self.squares.len()
    }

    /// Adds a batch of `samples` to those before it, of which these are the sums and the count.
    pub(super) fn add(&mut self, batch: &[[f64; 4]], samples: u32, before: &[[f64; 4]], count: u32) {
        if samples >= count {
            let one = |sum: &[f64; 4]| if count > 0 { square(sum) / f64::from(count) } else { 0.0 };
            self.squares.iter_mut().zip(before).for_each(|(to, sum)| *to = one(sum) as f32);
            self.largest = count;
        }
        let each = self.squares.iter_mut().zip(batch);
        each.for_each(|(to, sum)| *to += (square(sum) / f64::from(samples)) as f32);
        self.largest = self.largest.max(samples);
    }

    /// The variance of the mean of pixel number `i`, which has this sum of `samples` samples; `None` if one batch has all samples.
    fn variance(&self, i: usize, sum: &[f64; 4], samples: u32) -> Option<f32> {
        sample_variance(self.squares[i], square(sum) as f32, samples, self.largest).map(|v| v / samples as f32)
    }
}

fn square(&[r, g, b, _]: &[f64; 4]) -> f64 {
    r * r + g * g + b * b
}

/// The variance of a sample: of Q, |S|², N and n; `None` if one batch has all samples.
pub(super) fn sample_variance(squares: f32, square_of_sum: f32, samples: u32, largest: u32) -> Option<f32> {
    let (samples, largest) = (samples as f32, largest as f32);
    (samples > largest).then(|| (squares - square_of_sum / samples).max(0.0) / (samples / largest - 1.0))
}

impl Film {
    /// Adds the squares of light that no tile keeps.
    pub(super) fn add_squares<'a>(&self, half: usize, light: impl Iterator<Item = &'a (u32, u32, crate::Rgb)>) {
        if self.keep.variance {
            for &(x, y, radiance) in light {
                self.squares[half].add(self.number(x, y), [radiance.length_squared()]);
            }
        }
    }

    /// The estimated variance of each pixel of [`Film::picture`], summed over the channels, rows from below; infinite where the samples
    /// are too few to tell. Nothing if the film was not to keep it.
    pub fn variances(&self) -> Vec<f32> {
        if !self.keep.variance {
            return Vec::new();
        }
        let mut out = vec![0.0; self.width as usize * self.height as usize];
        for i in 0..self.tiles.len() {
            let (own, tile) = (self.rect(i), self.tile(i));
            let rect = tile.light.rect;
            for at in 0..(rect.width * rect.height) as usize {
                let variance = match (&tile.halves, &tile.squares) {
                    (Some(halves), _) => halves.iter().map(|half| half.variance(at)).sum(),
                    (None, Some(squares)) if tile.samples > 0 => {
                        squares.variance(at, &tile.light.sums[at], tile.samples)
                    }
                    _ => None,
                };
                let (x, y) = (rect.x + at as u32 % rect.width, rect.y + at as u32 / rect.width);
                let is_unknown = variance.is_none() && own.index(x, y).is_some();
                out[self.number(x, y)] += variance.unwrap_or(if is_unknown { f32::INFINITY } else { 0.0 });
            }
        }
        self.add_scattered(&mut out);
        for (i, variance) in out.iter_mut().enumerate() {
            let gain = self.gains.get(i).map_or(1.0, |&gain| gain) * self.exposure;
            // Infinity times nothing is undefined.
            *variance = if gain > 0.0 { *variance * gain * gain } else { 0.0 };
        }
        out
    }

    /// Adds the variance of light that no tile keeps: each contribution is taken for independent of the others.
    fn add_scattered(&self, out: &mut [f32]) {
        if self.squares.iter().all(SquareSums::is_empty) {
            return;
        }
        let (counts, scales) = (self.sample_counts(), self.scattered().scales);
        for (half, sums) in self.squares.iter().enumerate() {
            for (i, (variance, &count)) in out.iter_mut().zip(&counts).enumerate() {
                let scale = if self.keep.halves { scales[half] } else { 1.0 / f64::from(count.max(1)) };
                *variance += (sums.get(i)[0] * scale * scale) as f32;
            }
        }
    }
}

/// Sums of squares of light by pixel.
pub(super) type SquareSums = SplatSums<1>;

/// The light of a patch that no tile keeps where counts differ.
pub(super) fn scattered(light: &TileAccumulator) -> impl Iterator<Item = &(u32, u32, crate::Rgb)> {
    light.far.iter().chain(light.anywhere.iter().flatten()).chain(&light.aimed)
}

#[cfg(test)]
mod tests {
    use crate::Rgb;
    use crate::film::{Film, FilmChannels};
    use crate::sampler::mix;

    const SIDE: u32 = 64;
    const PASSES: [u32; 6] = [1, 1, 2, 4, 8, 16];

    /// A film of pixels whose samples are 4 with probability 1/4, in all channels; they land in their pixel or half a picture away.
    fn film(halves: bool, scatters: bool) -> Film {
        let keep = FilmChannels { halves, variance: true, ..FilmChannels::default() };
        let film = Film::keeping(SIDE, SIDE, scatters, keep);
        for tile in 0..film.tile_count() {
            let (rect, mut first) = (film.rect(tile), 0);
            for (pass, samples) in PASSES.into_iter().enumerate() {
                let patch = |half: Option<usize>| {
                    let mut patch = film.patch(tile);
                    for (x, y) in [0, 1]
                        .into_iter()
                        .filter(|h| half.is_none_or(|half| half == *h))
                        .flat_map(|h| rect.pixels_of(h))
                    {
                        for i in first..first + samples {
                            let is_bright = mix((x + SIDE * y) * 32 + i) < u32::MAX / 4;
                            let light = Rgb::splat(if is_bright { 4.0 } else { 0.0 });
                            patch.add_anywhere(if scatters { x ^ 32 } else { x }, y, light);
                        }
                    }
                    patch
                };
                if halves {
                    for half in [0, 1] {
                        film.add_batch(tile, half, Some((&patch(Some(half)), samples)), None);
                    }
                } else {
                    film.add_pass(tile, pass as u32, patch(None), samples).unwrap();
                }
                first += samples;
            }
        }
        film
    }

    #[test]
    fn the_variance_is_that_of_the_mean() {
        for (halves, scatters) in [(false, false), (false, true), (true, true)] {
            let film = film(halves, scatters);
            // The mean is 1, so the error of the picture is known.
            let errors =
                film.picture().iter().map(|p| p[..3].iter().map(|x| (x - 1.0) * (x - 1.0)).sum::<f32>()).sum::<f32>();
            let found: f32 = film.variances().iter().sum();
            // Light that no tile keeps counts by its squares: 4 for each sample and channel, where its variance is 3.
            let factor = if scatters { 4.0 / 3.0 } else { 1.0 };
            assert!((0.93..1.07).contains(&(found / errors / factor)), "{halves} {scatters} {found} {errors}");
        }
    }

    /// Batches of the halves are unequal here: the estimate is larger than the truth, never smaller.
    #[test]
    fn a_bright_sample_counts_as_noise() {
        for halves in [false, true] {
            for bright in 0..32 {
                let keep = FilmChannels { halves, variance: true, ..FilmChannels::default() };
                let film = Film::keeping(8, 8, false, keep);
                let mut first = 0;
                for (pass, samples) in PASSES.into_iter().enumerate() {
                    let mut patch = film.patch(0);
                    if (first..first + samples).contains(&bright) {
                        patch.add(4, 4, Rgb::new(64.0, 0.0, 0.0));
                    }
                    if halves {
                        [0, 1].into_iter().for_each(|half| film.add_batch(0, half, Some((&patch, samples)), None));
                    } else {
                        film.add_pass(0, pass as u32, patch, samples).unwrap();
                    }
                    first += samples;
                }
                let variance = film.variances()[4 * 8 + 4];
                // Its part of the mean is 2, in each of the halves that got it here.
                let least = if halves { 8.0 } else { 4.0 };
                assert!(variance >= least - 1e-4, "{halves} {bright} {variance}");
                assert!(halves || variance < 4.0 + 1e-4, "{bright} {variance}");
            }
        }
    }

    #[test]
    fn one_batch_says_nothing() {
        let film = Film::keeping(8, 8, false, FilmChannels { variance: true, ..FilmChannels::default() });
        assert!(film.variances().iter().all(|v| *v == f32::INFINITY));
        film.add_pass(0, 0, film.patch(0), 1).unwrap();
        assert!(film.variances().iter().all(|v| *v == f32::INFINITY));
        film.add_pass(0, 1, film.patch(0), 1).unwrap();
        assert!(film.variances().iter().all(|v| *v == 0.0));
        assert!(Film::new(8, 8, false, false).variances().is_empty());
    }
}
