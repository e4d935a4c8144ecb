//! Light that lands anywhere in the picture, from any thread, in any order: sums that come out the same to the last bit.
//!
//! Sums of whole numbers do not depend on the order of their terms. A value is kept as a multiple of 2^-36; large ones,
//! as rare as lamps seen through a caustic, as a multiple of 2^-12 beside it.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicI64, Ordering};

/// Quanta of small values in one.
const FINE: f64 = (1u64 << 36) as f64;
/// Quanta of large values in one.
const COARSE: f64 = (1u64 << 12) as f64;
/// Values are large from here on: 2^17 of them overflow no sum, and a coarse quantum is at most 2^-22 of them.
const LARGE: f64 = 1024.0;
/// The value that brighter ones are clamped to: a million of these overflow no sum.
const BRIGHTEST: f64 = (1u64 << 31) as f64;

/// Sums of colours by pixel, or of so many other numbers.
#[derive(Default)]
pub struct SplatSums<const CHANNELS: usize = 3> {
    /// The sums, the channels pixel by pixel; made when light first arrives.
    fine: OnceLock<Box<[AtomicI64]>>,
    coarse: OnceLock<Box<[AtomicI64]>>,
    pixels: usize,
}

/// Sums as they are kept: quanta, the channels pixel by pixel, where any light has arrived.
#[derive(Debug, Default)]
pub struct SplatState {
    fine: Option<Vec<i64>>,
    coarse: Option<Vec<i64>>,
}

impl SplatState {
    /// The sums that are there, each with true if they are the coarse ones.
    pub(super) fn both(&self) -> impl Iterator<Item = (bool, &[i64])> {
        [(false, &self.fine), (true, &self.coarse)]
            .into_iter()
            .filter_map(|(is_coarse, sums)| Some((is_coarse, sums.as_deref()?)))
    }
}

impl<const CHANNELS: usize> SplatSums<CHANNELS> {
    /// Sums of zero for so many pixels.
    pub fn new(pixels: usize) -> Self {
        Self { pixels, ..Self::default() }
    }

    /// Adds a finite colour to a pixel.
    pub fn add(&self, pixel: usize, colour: [f32; CHANNELS]) {
        for (channel, value) in colour.into_iter().enumerate() {
            let value = f64::from(value).clamp(-BRIGHTEST, BRIGHTEST);
            let (sums, quanta) = if value.abs() < LARGE { (&self.fine, FINE) } else { (&self.coarse, COARSE) };
            let sums = sums.get_or_init(|| (0..CHANNELS * self.pixels).map(|_| AtomicI64::new(0)).collect());
            sums[CHANNELS * pixel + channel].fetch_add((value * quanta).round_ties_even() as i64, Ordering::Relaxed);
        }
    }

    /// The present sums; no other thread may add meanwhile.
    pub fn state(&self) -> SplatState {
        let read = |sums: &OnceLock<Box<[AtomicI64]>>| {
            sums.get().map(|sums| sums.iter().map(|sum| sum.load(Ordering::Relaxed)).collect())
        };
        SplatState { fine: read(&self.fine), coarse: read(&self.coarse) }
    }

    /// Number of sums of each size.
    pub(super) fn length(&self) -> usize {
        CHANNELS * self.pixels
    }

    /// Adds kept sums from number `first` on.
    pub(super) fn join(&self, is_coarse: bool, first: usize, values: &[i64]) {
        let sums = if is_coarse { &self.coarse } else { &self.fine };
        let sums = sums.get_or_init(|| (0..self.length()).map(|_| AtomicI64::new(0)).collect());
        for (sum, &add) in sums[first..].iter().zip(values).filter(|(_, add)| **add != 0) {
            sum.fetch_add(add, Ordering::Relaxed);
        }
    }

    /// True if nothing has arrived anywhere.
    pub fn is_empty(&self) -> bool {
        self.fine.get().is_none() && self.coarse.get().is_none()
    }

    /// The sum of the colours that a pixel got.
    pub fn get(&self, pixel: usize) -> [f64; CHANNELS] {
        let read = |sums: &OnceLock<Box<[AtomicI64]>>, at: usize, quanta: f64| {
            sums.get().map_or(0.0, |sums| sums[at].load(Ordering::Relaxed) as f64 / quanta)
        };
        std::array::from_fn(|c| {
            let at = CHANNELS * pixel + c;
            read(&self.fine, at, FINE) + read(&self.coarse, at, COARSE)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_come_back_as_they_were() {
        let sums: SplatSums = SplatSums::new(3);
        sums.add(2, [0.25, 5000.0, -1e-3]);
        let back: SplatSums = SplatSums::new(3);
        let state = sums.state();
        assert_eq!(state.both().count(), 2);
        // In parts, too.
        for (is_coarse, sums) in state.both() {
            back.join(is_coarse, 0, &sums[..4]);
            back.join(is_coarse, 4, &sums[4..]);
        }
        assert_eq!([0, 1, 2].map(|i| back.get(i)), [0, 1, 2].map(|i| sums.get(i)));
        assert_eq!((sums.length(), SplatSums::<3>::new(3).state().both().count()), (9, 0));
    }

    #[test]
    fn the_order_does_not_matter() {
        let values: Vec<f32> = (0..10_000).map(|i| ((i as f32 * 0.37).sin() * 20.0).exp()).collect();
        let (a, b): (SplatSums, SplatSums) = (SplatSums::new(2), SplatSums::new(2));
        assert!(a.is_empty());
        values.iter().for_each(|&v| a.add(1, [v, -v, 1.0]));
        std::thread::scope(|scope| {
            for part in values.chunks(1000).rev() {
                let b = &b;
                scope.spawn(move || part.iter().rev().for_each(|&v| b.add(1, [v, -v, 1.0])));
            }
        });
        assert_eq!(a.get(1), b.get(1));
        let exact: f64 = values.iter().map(|&v| f64::from(v)).sum();
        assert!((a.get(1)[0] / exact - 1.0).abs() < 1e-7 && a.get(1)[2] == 10_000.0);
        assert_eq!(a.get(0), [0.0; 3]);
        // Nor where the sum is parted.
        let whole: SplatSums = SplatSums::new(2);
        for part in [&a, &b] {
            part.state().both().for_each(|(is_coarse, sums)| whole.join(is_coarse, 0, sums));
        }
        assert_eq!(whole.get(1), a.get(1).map(|sum| 2.0 * sum));
    }
}
