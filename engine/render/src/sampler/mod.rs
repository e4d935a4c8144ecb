//! Point sets for Monte Carlo integration: the source of the numbers ([`PathSampler`]), the shapes that they are
//! bent into ([`warp`]), tables of arbitrary density ([`distribution`]), directions
//! in which media scatter ([`phase`]), which pixel gets which ([`pattern`]), and the
//! picture's pixels ([`raster`]).
//!
//! Every random choice comes in threes: `sample_x` takes uniform numbers to a value, `x_pdf` gives its density.

pub mod distribution;
pub mod evenly;
pub mod hashed;
pub mod pattern;
pub mod phase;
mod points;
pub mod raster;
pub mod warp;

use points::Scramble;

/// Owen-scrambled Sobol points, four dimensions at a time, each set of four scrambled by itself (Burley 2020,
/// "Practical Hash-based Owen Scrambling", padding). The numbers depend on pixel, sample and seed alone, never
/// on threads or tiles.
#[derive(Clone, Debug)]
pub struct PathSampler {
    index: u32,
    seed: u32,
    set: u32,
}

impl PathSampler {
    /// The points of sample number `index` in pixel (x, y).
    pub fn new(x: u32, y: u32, index: u32, seed: u32) -> Self {
        pattern::Pattern::independent(seed).pixel(x, y).sampler(index)
    }

    /// The points of one of many samples that belong to no pixel, by its number among all: together they are stratified over the whole
    /// picture.
    pub fn numbered(number: u32, seed: u32) -> Self {
        // The sequence has 2^16 points.
        Self { index: number & 0xffff, seed: mix(seed ^ mix(number >> 16)), set: 0 }
    }

    /// The next four uniform numbers in [0, 1).
    #[inline]
    pub fn next_4d(&mut self) -> [f32; 4] {
        let key = self.next_key();
        Scramble::new(mix(key)).point(self.index)
    }

    /// [`Self::next_4d`] for many samplers one after the other: quicker where pixels near each other ask for the same set.
    #[inline]
    pub fn next_4d_kept(&mut self, kept: &mut KeptScramble) -> [f32; 4] {
        let key = self.next_key();
        if kept.key != key {
            *kept = KeptScramble { key, scramble: Scramble::new(mix(key)) };
        }
        kept.scramble.point(self.index)
    }

    /// Passes over the next four numbers, which nobody looks at: zeros in their place.
    #[inline]
    pub fn skipped_4d(&mut self) -> [f32; 4] {
        self.set += 1;
        [0.0; 4]
    }

    /// The number that tells the next set of four from all others.
    #[inline]
    fn next_key(&mut self) -> u32 {
        let key = self.seed.wrapping_add(self.set.wrapping_mul(0x9e37_79b9));
        self.set += 1;
        key
    }

    /// Goes to a fixed set of dimensions, so that branches of different length before it do not shift the
    /// numbers that come after it.
    #[inline]
    pub fn jump_to(&mut self, set: u32) {
        self.set = set;
    }

    /// A sampler of 1024 more sets of the same sample, which belong to the present set alone: for a walk of many steps within one.
    #[inline]
    pub fn aside(&self) -> Self {
        Self { set: 1 << 31 | self.set << 10, ..self.clone() }
    }
}

/// The scramble of the set of four numbers that was asked for last.
#[derive(Clone, Copy, Debug)]
pub struct KeptScramble {
    key: u32,
    scramble: Scramble,
}

impl Default for KeptScramble {
    fn default() -> Self {
        Self { key: 0, scramble: Scramble::new(mix(0)) }
    }
}

/// A bijective integer hash with good avalanche (the "lowbias32" constants, C. Wellons 2018).
#[inline]
pub fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_path_gets_the_same_numbers() {
        let mut a = PathSampler::new(3, 5, 7, 11);
        let mut b = PathSampler::new(3, 5, 7, 11);
        for _ in 0..10 {
            assert_eq!(a.next_4d(), b.next_4d());
        }
        assert_ne!(a.next_4d(), PathSampler::new(4, 5, 7, 11).next_4d());
        assert_ne!(PathSampler::new(3, 5, 7, 11).next_4d(), PathSampler::new(3, 5, 7 + 65536, 11).next_4d());
    }

    /// The numbers do not depend on scrambles kept from other samplers.
    #[test]
    fn kept_scrambles_are_those_of_their_set() {
        let mut kept = KeptScramble::default();
        for i in 0..1000 {
            let mut one = pattern::Pattern::shared(5, 16).pixel(i % 80, i / 80).sampler(i % 16);
            one.jump_to(i % 3);
            assert_eq!(one.clone().next_4d_kept(&mut kept), one.next_4d(), "{i}");
        }
    }

    /// 256 points of one pixel are stratified: each of 256 equal intervals of each dimension holds one.
    #[test]
    fn points_are_stratified_in_every_dimension() {
        for set in 0..8 {
            let mut hits = [[0u32; 256]; 4];
            for i in 0..256 {
                let mut sampler = PathSampler::new(10, 20, i, 1);
                sampler.jump_to(set);
                for (d, u) in sampler.next_4d().into_iter().enumerate() {
                    assert!((0.0..1.0).contains(&u));
                    hits[d][(u * 256.0) as usize] += 1;
                }
            }
            assert!(hits.iter().flatten().all(|&n| n == 1), "set {set}");
        }
    }
}
