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
/// What a brighter value counts as: a million of these overflow no sum.
const BRIGHTEST: f64 = (1u64 << 31) as f64;

/// Sums of colours by pixel.
#[derive(Default)]
pub struct SplatSums {
    /// Made when first light arrives: three numbers a pixel.
    fine: OnceLock<Box<[AtomicI64]>>,
    coarse: OnceLock<Box<[AtomicI64]>>,
    pixels: usize,
}

impl SplatSums {
    /// Nothing yet.
    pub fn new(pixels: usize) -> Self {
        Self { pixels, ..Self::default() }
    }

    /// Adds a finite colour to a pixel.
    pub fn add(&self, pixel: usize, colour: [f32; 3]) {
        for (channel, value) in colour.into_iter().enumerate() {
            let value = f64::from(value).clamp(-BRIGHTEST, BRIGHTEST);
            let (sums, quanta) = if value.abs() < LARGE { (&self.fine, FINE) } else { (&self.coarse, COARSE) };
            let sums = sums.get_or_init(|| (0..3 * self.pixels).map(|_| AtomicI64::new(0)).collect());
            sums[3 * pixel + channel].fetch_add((value * quanta).round_ties_even() as i64, Ordering::Relaxed);
        }
    }

    /// True if nothing has arrived anywhere.
    pub fn is_empty(&self) -> bool {
        self.fine.get().is_none() && self.coarse.get().is_none()
    }

    /// A pixel's sum.
    pub fn get(&self, pixel: usize) -> [f64; 3] {
        let read = |sums: &OnceLock<Box<[AtomicI64]>>, at: usize, quanta: f64| {
            sums.get().map_or(0.0, |sums| sums[at].load(Ordering::Relaxed) as f64 / quanta)
        };
        [0, 1, 2].map(|c| read(&self.fine, 3 * pixel + c, FINE) + read(&self.coarse, 3 * pixel + c, COARSE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_does_not_matter() {
        let values: Vec<f32> = (0..10_000).map(|i| ((i as f32 * 0.37).sin() * 20.0).exp()).collect();
        let (a, b) = (SplatSums::new(2), SplatSums::new(2));
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
    }
}
