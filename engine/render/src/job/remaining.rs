//! The error that denoising leaves, for adaptive sampling: a look at it while the render goes on.

use super::Shared;
use super::adaptive::{Adaptive, Pass};
use super::denoise::Denoising;
use crate::film::TileRect;
use crate::film::halves::{BLOCK_SIZE, half_of, weight};
use petzval_denoise::{DenoiseError, Prefilter, Quality};
use std::sync::PoisonError;

/// The part of a pixel's squared error that is taken to be left at least. Of blocks less is not told from nothing; measured, denoising
/// leaves a tenth to a third where it does best (docs/design/adaptive-sampling.md).
const LEAST_LEFT: f32 = 0.15;
/// Distance, in blocks, of those that count beside a block.
const REACH: usize = 4;

/// The squared relative errors of a block: of the samples of each half; `None` for a half without pixels.
pub(super) type Words = [Option<f32>; 2];

impl Shared {
    /// Decides how all blocks go on after pass number `number`, once they have ended it; false if another thread is about it, or they have
    /// not, or the render is to stop.
    pub(super) fn decide_together(
        &self,
        adaptive: &Adaptive,
        (number, pass): (u32, Pass),
        stopped: &dyn Fn() -> bool,
    ) -> bool {
        let Ok(_alone) = self.deciding.try_lock() else { return false };
        let tiles = self.film.tile_count();
        if adaptive.has_decided(tiles - 1, pass) {
            return true;
        }
        let Some(how) = &self.settings.denoising else { return false };
        if (0..tiles).any(|tile| self.film.tile(tile).passes <= number) {
            return false;
        }
        let words = match self.errors_after_denoising(how, &|_| !stopped()) {
            Ok(words) => words,
            Err(DenoiseError::Stopped) => return false,
            // The picture will not be denoised either, and that is reported then: what counts is its noise.
            Err(_) => (0..tiles).map(|tile| [0, 1].map(|half| self.film.squared_error(tile, half))).collect(),
        };
        // A checkpoint holds all of the decisions or none.
        let _shared = self.gate.read().unwrap_or_else(PoisonError::into_inner);
        words.into_iter().enumerate().for_each(|(tile, errors)| adaptive.look(&self.film, tile, pass, errors));
        true
    }

    /// The squared relative error that denoising would leave of each block, by the measure of [`crate::film::halves`].
    fn errors_after_denoising(&self, how: &Denoising, watch: &dyn Fn(f64) -> bool) -> Result<Vec<Words>, DenoiseError> {
        let how = Denoising { quality: Quality::Fast, prefilter: Prefilter::Fast, ..how.clone() };
        let (variance, noisy, columns) = (self.film.variances(), self.colour(), self.film.size().0 as usize);
        let clean = self.cleaned(&how, &noisy, watch)?;
        let clean_moved = self.cleaned(&how, &petzval_denoise::moved(&noisy, &variance), watch)?;
        let errors = petzval_denoise::remaining(&noisy, &clean, &clean_moved, &variance, columns);
        let relative = |i: usize| {
            let of = 1.0 / weight(clean[i].iter().sum::<f32>().max(0.0));
            [errors[i] * of, variance[i] * of]
        };
        let blocks: Vec<[Sums; 2]> =
            (0..self.film.tile_count()).map(|tile| sums(self.film.rect(tile), columns, relative)).collect();
        Ok(smoothed(&blocks, |tile| self.film.rect(tile), self.film.size()))
    }
}

/// Sums over the pixels of a half: of the error that is left, of the variance, and the count.
type Sums = [f32; 3];

fn sums(rect: TileRect, columns: usize, relative: impl Fn(usize) -> [f32; 2]) -> [Sums; 2] {
    let mut out = [[0.0; 3]; 2];
    for (x, y) in [0, 1].into_iter().flat_map(|half| rect.pixels_of(half)) {
        let [error, variance] = relative(y as usize * columns + x as usize);
        let sums = &mut out[half_of(x, y)];
        sums.iter_mut().zip([error, variance, 1.0]).for_each(|(sum, add)| *sum += add);
    }
    out
}

/// The words of the blocks: the part of the noise that is left about a block, of its own noise. One block has too few pixels to know that
/// part; its neighbours count by 1 / (1 + d² / 8), d the distance in blocks.
fn smoothed(blocks: &[[Sums; 2]], rect: impl Fn(usize) -> TileRect, (width, height): (u32, u32)) -> Vec<Words> {
    let (columns, rows) = (width.div_ceil(BLOCK_SIZE) as usize, height.div_ceil(BLOCK_SIZE) as usize);
    let place = |tile: usize| ((rect(tile).x / BLOCK_SIZE) as usize, (rect(tile).y / BLOCK_SIZE) as usize);
    let mut tiles = vec![0; columns * rows];
    (0..blocks.len()).for_each(|tile| tiles[place(tile).1 * columns + place(tile).0] = tile);
    let near = |at: usize, count: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(count);
    let word = |tile: usize, half: usize| {
        let (column, row) = place(tile);
        let [_, own, count] = blocks[tile][half];
        let mut all = [0.0f32; 2];
        for (x, y) in near(row, rows).flat_map(|y| near(column, columns).map(move |x| (x, y))) {
            let [left, variance, _] = blocks[tiles[y * columns + x]][half];
            let weight = 1.0 / (1.0 + (x.abs_diff(column).pow(2) + y.abs_diff(row).pow(2)) as f32 / 8.0);
            // What is not known says nothing of others.
            if left.is_finite() && variance.is_finite() {
                all[0] += weight * left;
                all[1] += weight * variance;
            }
        }
        let part = if all[1] > 0.0 { (all[0] / all[1]).clamp(LEAST_LEFT, 1.0) } else { 1.0 };
        // Each channel counts as if all erred together, as in `squared_error`.
        (count > 0.0).then(|| 3.0 * part * own / count)
    };
    (0..blocks.len()).map(|tile| [word(tile, 0), word(tile, 1)]).collect()
}

/// Waits a little for a decision of another thread.
pub(super) fn wait() {
    std::thread::sleep(std::time::Duration::from_millis(2));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_counts_with_those_about_it() {
        let rect = |tile: usize| TileRect { x: tile as u32 % 3 * 8, y: tile as u32 / 3 * 8, width: 8, height: 8 };
        // All have the same noise, of which 1.8 times as much is left in the middle and nothing elsewhere.
        let mut blocks = vec![[[0.0, 64.0, 32.0]; 2]; 9];
        blocks[4][0][0] = 1.8 * 64.0;
        let words = smoothed(&blocks, rect, (24, 24));
        let about: f32 = 1.0 + 4.0 / (1.0 + 1.0 / 8.0) + 4.0 / (1.0 + 2.0 / 8.0);
        assert!((words[4][0].unwrap() - 3.0 * 2.0 * f32::max(1.8 / about, LEAST_LEFT)).abs() < 1e-5);
        // Never less than a part of its own noise.
        assert!((words[4][1].unwrap() - 3.0 * LEAST_LEFT * 2.0).abs() < 1e-5);
        // More is never left than there is; what is not known is what it was.
        blocks.iter_mut().for_each(|block| block[1] = [100.0, 64.0, 32.0]);
        blocks[8][1] = [f32::INFINITY, f32::INFINITY, 32.0];
        let words = smoothed(&blocks, rect, (24, 24));
        assert!((words[0][1].unwrap() - 3.0 * 2.0).abs() < 1e-5);
        assert_eq!(words[8][1], Some(f32::INFINITY));
        assert_eq!(smoothed(&[[[0.0; 3], [1.0, 1.0, 1.0]]], rect, (1, 1))[0], [None, Some(3.0)]);
    }
}
