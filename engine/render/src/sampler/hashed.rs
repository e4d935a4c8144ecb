//! Random numbers that are not stratified, for choices of which there is no telling how many a path needs.

/// A stream of uniform numbers, the same for the same seed.
pub(crate) struct HashedNumbers(u64);

impl HashedNumbers {
    /// The stream seeded by numbers of a path's sampler.
    pub(crate) fn new(u: [f32; 3]) -> Self {
        let bits = |i: usize| u64::from(u[i].to_bits());
        Self::seeded(bits(0) ^ (bits(1) << 21) ^ (bits(2) << 42))
    }

    /// The stream of that seed.
    pub(crate) fn seeded(seed: u64) -> Self {
        Self(seed ^ 0x9e37_79b9_7f4a_7c15)
    }

    /// The next number, 0 to 1 (Steele, Lea and Flood 2014, splitmix).
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
}
