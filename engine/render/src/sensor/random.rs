//! Random numbers by place: the same for the same photosite, frame and seed, whoever asks and in which order.

use std::f64::consts::TAU;

/// Means from which on transformed rejection is exact; below, its constants are none of that paper.
const REJECTION_FROM: f64 = 10.0;

/// A stream of random numbers of one photosite.
///
/// The state is a hash of seed, frame and place, and steps as SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number
/// generators").
#[derive(Clone, Debug)]
pub struct Stream(u64);

/// Mixes the bits of a number: the finalizer of SplitMix64.
fn mixed(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

impl Stream {
    /// The stream of a place in a frame. Frame `None` is the sensor's own, which is the same in all pictures.
    pub fn new(seed: u64, frame: Option<u64>, place: u64) -> Self {
        let frame = frame.map_or(0, |frame| mixed(frame).wrapping_add(0x5851_f42d_4c95_7f2d));
        Self(mixed(mixed(mixed(seed ^ 0x9e37_79b9_7f4a_7c15) ^ frame).wrapping_add(place)))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.0)
    }

    /// A uniform number between 0 and 1, neither of them.
    pub fn uniform(&mut self) -> f64 {
        ((self.bits() >> 12) as f64 + 0.5) * (1.0 / (1_u64 << 52) as f64)
    }

    /// Two independent numbers of the normal distribution with mean 0 and standard deviation 1 (Box and Muller 1958).
    pub fn normal_pair(&mut self) -> [f64; 2] {
        let radius = (-2.0 * libm::log(self.uniform())).sqrt();
        let (sin, cos) = libm::sincos(TAU * self.uniform());
        [radius * cos, radius * sin]
    }

    /// A number of the Poisson distribution with a mean that is at least 0 and finite; exact at any mean.
    pub fn poisson(&mut self, mean: f64) -> f64 {
        if mean < REJECTION_FROM { self.poisson_by_product(mean) } else { self.poisson_by_rejection(mean) }
    }

    /// A Poisson number by the product of uniform numbers (Knuth, "The Art of Computer Programming", volume 2, 3.4.1 F).
    fn poisson_by_product(&mut self, mean: f64) -> f64 {
        let limit = libm::exp(-mean);
        let (mut count, mut product) = (0.0, self.uniform());
        while product > limit {
            count += 1.0;
            product *= self.uniform();
        }
        count
    }

    /// A Poisson number by transformed rejection with squeeze, PTRS (Hörmann 1993, "The transformed rejection method for generating Poisson
    /// random variables").
    fn poisson_by_rejection(&mut self, mean: f64) -> f64 {
        let root = mean.sqrt();
        let b = 0.931 + 2.53 * root;
        let a = -0.059 + 0.024_83 * b;
        let inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
        let squeeze = 0.9277 - 3.6224 / (b - 2.0);
        loop {
            let u = self.uniform() - 0.5;
            let v = self.uniform();
            let side = 0.5 - u.abs();
            let count = ((2.0 * a / side + b) * u + mean + 0.43).floor();
            if side >= 0.07 && v <= squeeze {
                return count;
            }
            if count < 0.0 || (side < 0.013 && v > side) {
                continue;
            }
            let left = libm::log(v * inverse_alpha / (a / (side * side) + b));
            if left <= count * libm::log(mean) - mean - libm::lgamma(count + 1.0) {
                return count;
            }
        }
    }
}
