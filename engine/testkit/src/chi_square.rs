//! Pearson's test of counts against expectations.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Cells with fewer expected samples than this are taken together: below, the statistic is not chi-square.
const LEAST_EXPECTED: f64 = 5.0;

/// The probability that counts differ from their expectations by this much or more if the expectations are right.
///
/// `expected` are counts, too, and need not add up to the observed total: the rest is a cell of its own
/// (samples that were refused). Near 0 the expectations are wrong; a test over n cases asks for more than 0.01 / n
/// (Sidak's correction, nearly).
///
/// # Panics
/// If the two lists differ in length or an expectation is negative or not finite.
pub fn p_value(observed: &[u64], expected: &[f64]) -> f64 {
    assert_eq!(observed.len(), expected.len());
    assert!(expected.iter().all(|e| e.is_finite() && *e >= 0.0));
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let (mut statistic, mut cells) = (0.0, 0u32);
    let (mut pool_observed, mut pool_expected) = (0.0, 0.0);
    let mut add = |o: f64, e: f64| {
        statistic += (o - e) * (o - e) / e;
        cells += 1;
    };
    for i in order {
        let (o, e) = (observed[i] as f64, expected[i]);
        if e >= LEAST_EXPECTED {
            add(o, e);
        } else {
            pool_observed += o;
            pool_expected += e;
            if pool_expected >= LEAST_EXPECTED {
                add(pool_observed, pool_expected);
                (pool_observed, pool_expected) = (0.0, 0.0);
            }
        }
    }
    // A rest of the pool that nothing was expected in must be empty, rounding aside.
    if pool_expected < 1e-3 && pool_observed > 0.0 {
        return 0.0;
    }
    if cells < 2 {
        return 1.0;
    }
    let degrees = f64::from(cells - 1);
    1.0 - ChiSquared::new(degrees).expect("at least one degree of freedom").cdf(statistic)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small generator of its own: this crate tests samplers and should not lean on one.
    fn numbers(mut state: u64) -> impl Iterator<Item = f64> {
        std::iter::from_fn(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            Some((state >> 11) as f64 / (1u64 << 53) as f64)
        })
    }

    fn counts(n: usize, power: i32) -> Vec<u64> {
        let mut list = vec![0; 20];
        for u in numbers(9).take(n) {
            list[(u.powi(power) * 20.0) as usize] += 1;
        }
        list
    }

    #[test]
    fn right_expectations_pass_and_wrong_ones_fail() {
        let even = vec![500.0; 20];
        assert!(p_value(&counts(10_000, 1), &even) > 0.01);
        assert!(p_value(&counts(10_000, 2), &even) < 1e-6);
    }

    #[test]
    fn rare_cells_are_taken_together() {
        let mut expected = vec![1000.0; 10];
        expected.extend([0.5; 20]);
        let mut observed = vec![1000; 10];
        observed.extend([0, 1].repeat(10));
        assert!(p_value(&observed, &expected) > 0.5);
        // Something where nothing can be.
        assert_eq!(p_value(&[1000, 1000, 7], &[1000.0, 1000.0, 0.0]), 0.0);
    }
}
