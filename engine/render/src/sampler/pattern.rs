//! The choice of the points of the sequence that a pixel gets: such that the errors of neighbours differ, and cancel
//! for an eye that sees several pixels at once (blue noise).
//!
//! A square of pixels shares one sequence, laid along a Z-shaped curve whose turns are random at every level (Ahmed and
//! Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels").
//! Each pixel gets a stretch of as many points as it has samples planned. Four neighbours have four stretches that
//! follow each other, and together they are spread as evenly as the points of one pixel with four times the samples; so
//! do sixteen, and so on. The sequence has 2^16 points: the fewer samples, the larger the squares.

use super::{PathSampler, mix};

/// log2 of the sequence's length.
const SEQUENCE: u32 = 16;

/// The distribution of a sequence's points over the pixels of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Pattern {
    seed: u32,
    /// log2 of a pixel's stretch; as long as the whole sequence where pixels have nothing to do with each other.
    bits: u32,
}

impl Pattern {
    /// Every pixel has a sequence of its own, independent of all others.
    pub fn independent(seed: u32) -> Self {
        Self { seed, bits: SEQUENCE }
    }

    /// Neighbours share a sequence, for so many samples a pixel. More may be asked for; they are then spread anew.
    pub fn shared(seed: u32, samples: u32) -> Self {
        let bits = samples.clamp(1, 1 << SEQUENCE).next_power_of_two().ilog2();
        Self { seed, bits }
    }

    /// This pattern with other numbers.
    pub fn apart(self, salt: u32) -> Self {
        Self { seed: self.seed ^ salt, ..self }
    }

    /// The points of pixel (x, y).
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> PixelPattern {
        // log2 of a square's side.
        let side = (SEQUENCE - self.bits) / 2;
        let square = [x >> side, y >> side];
        let mask = (1 << side) - 1;
        let turns = self.square_seed(square, 0);
        let first = place_on_curve([x & mask, y & mask], side, turns) << self.bits;
        PixelPattern { pattern: *self, square, seed: turns, first }
    }

    fn square_seed(&self, [x, y]: [u32; 2], round: u32) -> u32 {
        mix(x ^ mix(y ^ mix(self.seed ^ mix(round | (SEQUENCE - self.bits) << 24))))
    }
}

/// The points of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct PixelPattern {
    pattern: Pattern,
    square: [u32; 2],
    /// Seed of the pixel's square, for the first round of samples.
    seed: u32,
    /// First point of the pixel's stretch.
    first: u32,
}

impl PixelPattern {
    /// The points of sample number `index`.
    #[inline]
    pub fn sampler(&self, index: u32) -> PathSampler {
        let round = index >> self.pattern.bits;
        let seed = if round == 0 { self.seed } else { self.pattern.square_seed(self.square, round) };
        PathSampler { index: self.first | index & ((1 << self.pattern.bits) - 1), seed, set: 0 }
    }
}

/// The index of a pixel of a square of 2^levels on the curve, whose four quarters are in random order at every level.
fn place_on_curve([x, y]: [u32; 2], levels: u32, seed: u32) -> u32 {
    let mut place = 0;
    for level in (0..levels).rev() {
        let quarter = (y >> level & 1) << 1 | x >> level & 1;
        // By level and by the quarters entered so far.
        let order = ORDERS[((u64::from(mix(seed ^ mix(place | (level + 1) << 24))) * 24) >> 32) as usize];
        place = place << 2 | u32::from(order >> (2 * quarter) & 3);
    }
    place
}

/// The 24 orders of four, two bits a place.
const ORDERS: [u8; 24] = {
    let mut orders = [0; 24];
    let (mut count, mut code) = (0, 0u32);
    while code < 256 {
        let taken = 1 << (code & 3) | 1 << (code >> 2 & 3) | 1 << (code >> 4 & 3) | 1 << (code >> 6);
        if taken == 0b1111 {
            orders[count] = code as u8;
            count += 1;
        }
        code += 1;
    }
    orders
};

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    /// The pixels of a square, and the squares within, have stretches that follow each other, each pixel its own.
    #[test]
    fn pixels_of_a_square_share_out_the_sequence() {
        let pattern = Pattern::shared(3, 64);
        for size in [2u32, 4, 32] {
            let mut places: Vec<u32> =
                (0..size * size).map(|i| pattern.pixel(32 + i % size, 64 + i / size).first).collect();
            places.sort_unstable();
            let first = places[0];
            assert_eq!(first % (size * size * 64), 0);
            assert!(places.iter().zip(0..).all(|(&place, i)| place == first + i * 64), "{size}");
        }
        // The next square has a seed of its own.
        assert_ne!(pattern.pixel(0, 0).seed, pattern.pixel(32, 0).seed);
    }

    /// A sample has its numbers whatever was asked before, and no two samples share them.
    #[test]
    fn samples_differ_within_and_beyond_the_plan() {
        for pattern in [Pattern::shared(1, 10), Pattern::independent(1)] {
            let numbers = |x, index| pattern.pixel(x, 7).sampler(index).next_4d().map(f32::to_bits);
            let mut all: Vec<_> = (0..4).flat_map(|x| (0..100).map(move |i| numbers(x, i))).collect();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), 400);
        }
        let beyond = Pattern::independent(1).pixel(3, 5);
        assert_ne!(beyond.sampler(7).next_4d(), beyond.sampler(7 + 65536).next_4d());
    }

    /// The purpose of the pattern: the mean over 4 x 4 pixels is as good as that of 16 times the samples, the pixel
    /// alone as good as ever.
    #[test]
    fn errors_of_neighbours_cancel() {
        let [alone, together] = mean_squares(|seed| Pattern::shared(seed, 16), 16);
        let [own, own_together] = mean_squares(Pattern::independent, 16);
        assert!((alone / own - 1.0).abs() < 0.05, "{alone} {own}");
        // Independent errors: a sixteenth. An edge, by points that are even: n^-1.5, a quarter of that again.
        assert!((own_together / own * 16.0 - 1.0).abs() < 0.15, "{own_together} {own}");
        assert!(together < 0.35 * own_together, "{together} {own_together}");
    }

    /// Pixels that leave points of their stretch out are no worse together than independent ones: the order of the points is random
    /// (`PathSampler`), and neighbours leave out different ones.
    #[test]
    fn errors_of_neighbours_do_not_add_up_where_samples_are_fewer() {
        for (planned, samples) in [(24, 24), (12, 12), (256, 20)] {
            let [alone, together] = mean_squares(|seed| Pattern::shared(seed, planned), samples);
            let [own, own_together] = mean_squares(Pattern::independent, samples);
            println!("{samples} of {planned}: {} {}", alone / own, together / own_together);
            assert!((alone / own - 1.0).abs() < 0.05, "{samples} of {planned}: {alone} {own}");
            assert!(together < own_together, "{samples} of {planned}: {together} {own_together}");
        }
    }

    /// Mean squares of the errors of pixels, and of the means of blocks of 4 x 4 pixels, of a shadow's edge.
    fn mean_squares(pattern: impl Fn(u32) -> Pattern, samples: u32) -> [f64; 2] {
        const SQUARES: u32 = 128;
        // A bent edge through two dimensions, as a shadow has it; its mean is π / 4.
        let value = |mut sampler: PathSampler| {
            let [a, b, ..] = sampler.next_4d();
            f64::from(u8::from(a * a + b * b < 1.0))
        };
        let (mut alone, mut together) = (0.0, 0.0);
        // Of many squares of 64 x 64 pixels, for the pixels of one have much in common.
        for square in 0..SQUARES {
            let pattern = pattern(square);
            for block in 0..256 {
                let mut sum = 0.0;
                for i in 0..16 {
                    let pixel = pattern.pixel(block % 16 * 4 + i % 4, block / 16 * 4 + i / 4);
                    let mean = (0..samples).map(|s| value(pixel.sampler(s))).sum::<f64>() / f64::from(samples);
                    alone += (mean - FRAC_PI_4).powi(2) / 16.0;
                    sum += mean / 16.0;
                }
                together += (sum - FRAC_PI_4).powi(2);
            }
        }
        [alone, together].map(|sum| sum / f64::from(256 * SQUARES))
    }
}
