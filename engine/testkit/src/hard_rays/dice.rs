//! Random numbers that are the same everywhere: nothing here or after it calls a function that rounds in its own way.

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(super) struct Dice(u64);

impl Dice {
    /// Independent of every other stream, seed and index.
    pub(super) fn new(seed: u64, stream: u64, index: u64) -> Self {
        let mut dice = Self(seed);
        for part in [stream, index] {
            dice.0 = dice.next() ^ part.wrapping_mul(0xd6e8_feb8_6659_fd93);
        }
        dice.next();
        dice
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in [0, 1).
    pub(super) fn part(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a number spread evenly over [low, high).
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.part()
    }

    /// Returns a number whose logarithm is spread evenly, nearly: within an octave it is even in the number.
    pub(super) fn log_between(&mut self, low: f64, high: f64) -> f64 {
        exponential(self.between(logarithm(low), logarithm(high)))
    }

    /// −1 or 1, each as likely.
    pub(super) fn sign(&mut self) -> f64 {
        if self.one_in(2) { 1.0 } else { -1.0 }
    }

    /// True once in `n` times.
    pub(super) fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    /// 0 to n − 1.
    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// A place in the unit disc.
    pub(super) fn in_disc(&mut self) -> [f64; 2] {
        loop {
            let [x, y] = [self.between(-1.0, 1.0), self.between(-1.0, 1.0)];
            if x * x + y * y < 1.0 {
                return [x, y];
            }
        }
    }

    /// Cosine and sine of any angle.
    pub(super) fn angle(&mut self) -> [f64; 2] {
        loop {
            let [x, y] = self.in_disc();
            let length = (x * x + y * y).sqrt();
            if length > 0.1 {
                return [x / length, y / length];
            }
        }
    }

    /// A unit vector, all directions as likely.
    pub(super) fn direction(&mut self) -> [f64; 3] {
        let z = self.between(-1.0, 1.0);
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        let [cos, sin] = self.angle();
        [r * cos, r * sin, z]
    }
}

/// The binary logarithm, linear between powers of two.
fn logarithm(x: f64) -> f64 {
    let bits = x.to_bits();
    let fraction = (bits & ((1 << 52) - 1)) as f64 / (1u64 << 52) as f64;
    (bits >> 52) as f64 - 1023.0 + fraction
}

/// The inverse of [`logarithm`].
fn exponential(y: f64) -> f64 {
    let whole = y.floor();
    f64::from_bits(((whole + 1023.0) as u64) << 52) * (1.0 + (y - whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_in_their_range_and_fill_it() {
        let mut dice = Dice::new(1, 2, 3);
        let list: Vec<f64> = (0..10_000).map(|_| dice.log_between(1e-15, 1e-1)).collect();
        assert!(list.iter().all(|x| (1e-15..=1e-1).contains(x)));
        for decade in -15..-1 {
            let low = format!("1e{decade}").parse::<f64>().unwrap();
            let count = list.iter().filter(|x| (low..low * 10.0).contains(x)).count();
            assert!((500..1000).contains(&count), "{count} in the decade of {low:e}");
        }
    }

    #[test]
    fn every_index_is_a_stream_of_its_own() {
        let first = |seed, stream, index| Dice::new(seed, stream, index).next();
        let list = [first(1, 0, 0), first(0, 1, 0), first(0, 0, 1), first(0, 0, 0), first(1, 1, 1)];
        for (i, a) in list.iter().enumerate() {
            assert!(list[..i].iter().all(|b| a != b));
        }
    }
}
