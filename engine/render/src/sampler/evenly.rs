//! Points that fill a cube evenly, however many of them are taken: for measures that must come out the same each time.

/// The additive recurrence by powers of the inverse of the root of x^(N+1) = x + 1 (Roberts 2018, "The Unreasonable
/// Effectiveness of Quasirandom Sequences").
pub struct Evenly<const N: usize>([f64; N]);

impl<const N: usize> Default for Evenly<N> {
    fn default() -> Self {
        let mut root = 1.5f64;
        // It contracts by more than half each time.
        for _ in 0..64 {
            root = (1.0 + root).powf(1.0 / (N as f64 + 1.0));
        }
        Self(std::array::from_fn(|k| root.powi(-(k as i32 + 1))))
    }
}

impl<const N: usize> Evenly<N> {
    /// Point number `i`, each number in [0, 1).
    pub fn point(&self, i: u32) -> [f64; N] {
        self.0.map(|step| (0.5 + step * f64::from(i)).fract())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The golden ratio in one dimension; the plastic number's inverse in two.
    #[test]
    fn steps_are_the_known_numbers() {
        assert!((Evenly::<1>::default().0[0] - 0.618_033_988_749_895).abs() < 1e-14);
        let two = Evenly::<2>::default().0;
        assert!((two[0] - 0.754_877_666_246_693).abs() < 1e-14 && (two[1] - 0.569_840_290_998_053).abs() < 1e-14);
    }

    /// Every cell of a grid of 16 x 16 has its share of 4096 points, to a third.
    #[test]
    fn they_fill_the_square() {
        let points = Evenly::<2>::default();
        let mut cells = [0; 256];
        for i in 0..4096 {
            let [u, v] = points.point(i);
            assert!((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v));
            cells[(u * 16.0) as usize * 16 + (v * 16.0) as usize] += 1;
        }
        assert!(cells.iter().all(|n| (11..=21).contains(n)), "{cells:?}");
    }
}
