//! The points of `sobol_burley`, bit for bit, in a third of its time: the sequence is linear in the bits of the index, so
//! that a table for each byte of it stands for the loop over its bits; and parts that depend on the seed alone are kept for all points of a
//! seed.

use sobol_burley::parts::{Int4, hash, hash_int4, owen_scramble_int4_rev, owen_scramble_rev, sobol_int4_rev};
use std::sync::LazyLock;

/// The contributions of the bits of each byte of the reversed index, the higher first.
struct ByteTables([[[u32; 4]; 256]; 2]);

static TABLES: LazyLock<ByteTables> = LazyLock::new(|| {
    let byte = |shift: u32| std::array::from_fn(|i| sobol_int4_rev((i as u32) << shift, 0).into());
    ByteTables([byte(24), byte(16)])
});

/// The Owen scramble of the first four dimensions for one seed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scramble {
    /// Scrambles the index.
    order: u32,
    /// Scrambles each dimension.
    dimensions: Int4,
}

impl Scramble {
    #[inline]
    pub(super) fn new(seed: u32) -> Self {
        let seeds = Int4::from([seed.wrapping_mul(0x9c8f_2d3b); 4]);
        let dimensions = hash_int4(seeds ^ Int4::from([0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8]));
        Self { order: hash(seed ^ 0x79c6_8e4a), dimensions }
    }

    /// [`sobol_burley::sample_4d`] of the first four dimensions; `index` below 2^16.
    #[inline]
    pub(super) fn point(&self, index: u32) -> [f32; 4] {
        let ByteTables([high, low]) = &*TABLES;
        let shuffled = owen_scramble_rev(index.reverse_bits(), self.order);
        let (a, b) = (high[(shuffled >> 24) as usize], low[(shuffled >> 16 & 0xff) as usize]);
        let sobol = Int4::from(a) ^ Int4::from(b);
        owen_scramble_int4_rev(sobol, self.dimensions).reverse_bits().to_f32_norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_are_the_librarys() {
        for i in 0..20_000u32 {
            let (index, seed) = (i.wrapping_mul(40_503) & 0xffff, i.wrapping_mul(0x9e37_79b9));
            assert_eq!(Scramble::new(seed).point(index), sobol_burley::sample_4d(index, 0, seed));
        }
    }
}
