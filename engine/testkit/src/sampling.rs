//! The harness for everything that is sampled: samples follow the density that is said of them (Pearson's chi-square test over cells), and
//! estimates have the mean that they should (a z-test).
//!
//! Random numbers are independent, as both tests take for granted, and not the stratified ones of the renderer. They are the same in every
//! run, but where the environment variable `PETZVAL_TEST_SEED` is set (`make test-long` sets it anew each time); `PETZVAL_TEST_ALL` takes
//! sixteen times as many. A sampler fails if three tests in a row, with other numbers each, have a p-value below 1e-3: of right samplers one
//! in 1e9 does.

use crate::chi_square;
use crate::is_thorough;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::PI;

/// The p-value below which a test is repeated.
const SUSPICIOUS: f64 = 1e-3;
/// Tests in a row that all have to be suspicious.
const ROUNDS: u32 = 3;
/// The part of the samples that a sampler may refuse more or less often than its density says, and what its integral may be above 1:
/// roundings, steps of tables, and edges of the density between points of the integral.
const REST_ERROR: f64 = 1e-3;
/// Samples that are expected in a cell at least, for the density there to count as found.
const LEAST_RESOLVED: f64 = 1e-2;

/// The seed of the run, `PETZVAL_TEST_SEED` or 0.
///
/// # Panics
/// If the variable is no whole number.
pub fn seed() -> u64 {
    std::env::var("PETZVAL_TEST_SEED").map_or(0, |text| text.parse().expect("PETZVAL_TEST_SEED is a whole number"))
}

/// Independent random numbers: SplitMix64 (Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators").
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The numbers of a test, by its name and the [`seed`] of the run.
    pub fn new(name: &str) -> Self {
        Self::of_round(name, 0)
    }

    fn of_round(name: &str, round: u32) -> Self {
        // FNV-1a.
        let hash =
            name.bytes().fold(0xCBF2_9CE4_8422_2325u64, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3));
        let mut own = Self(hash ^ seed().wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (u64::from(round) << 56));
        own.next_bits();
        own
    }

    fn next_bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    }

    /// A number, 0 ≤ u < 1.
    pub fn number(&mut self) -> f64 {
        (self.next_bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Numbers in single precision, 0 ≤ u < 1.
    pub fn numbers<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| (self.next_bits() >> 40) as f32 / (1u32 << 24) as f32)
    }
}

/// The number of samples of a test whose quick run takes `quick`.
pub fn samples(quick: u64) -> u64 {
    if is_thorough() { 16 * quick } else { quick }
}

/// Fails if a test is suspicious in every round. It is given random numbers and the number of the round, and gives a p-value and what is
/// farthest off.
fn judge(name: &str, mut test: impl FnMut(&mut Random, u32) -> (f64, String)) {
    let mut found = Vec::new();
    for round in 0..ROUNDS {
        let (p, worst) = test(&mut Random::of_round(name, round), round);
        if p >= SUSPICIOUS {
            return;
        }
        found.push(format!("{p:.1e} ({worst})"));
    }
    panic!("{name}: p-values {}; PETZVAL_TEST_SEED={}", found.join(", "), seed());
}

/// A rectangle that is cut into cells.
#[derive(Clone, Copy, Debug)]
pub struct Cells {
    /// Lower and upper bound along each axis.
    pub bounds: [[f64; 2]; 2],
    /// Cells along each axis.
    pub counts: [usize; 2],
}

impl Cells {
    /// The cell of a place; that at the edge where the place is beyond it.
    fn cell(&self, place: [f64; 2]) -> usize {
        let [row, column] = [0, 1].map(|axis| {
            let [low, high] = self.bounds[axis];
            let at = (place[axis] - low) / (high - low) * self.counts[axis] as f64;
            (at as usize).min(self.counts[axis] - 1)
        });
        row * self.counts[1] + column
    }

    /// The bounds of a cell.
    fn bounds_of(&self, cell: usize) -> [[f64; 2]; 2] {
        let of = |axis: usize, number: usize| {
            let [low, high] = self.bounds[axis];
            [0, 1].map(|more| low + (high - low) * (number + more) as f64 / self.counts[axis] as f64)
        };
        [of(0, cell / self.counts[1]), of(1, cell % self.counts[1])]
    }

    /// Pearson's test: places of samples (`None`: refused) against integrals of a density over each cell.
    fn judge(
        &self,
        name: &str,
        quick: u64,
        mut sample: impl FnMut(&mut Random) -> Option<[f64; 2]>,
        density: impl Fn([f64; 2]) -> f64,
    ) {
        let n = samples(quick);
        let count = self.counts[0] * self.counts[1];
        judge(name, |random, round| {
            // An edge of the density that the points of one round miss is found by those of the next.
            let share = |cell| integral(&density, self.bounds_of(cell), 2 * round + 1);
            let shares: Vec<f64> = (0..count).map(share).collect();
            let rest = 1.0 - shares.iter().sum::<f64>();
            let mut observed = vec![0u64; count + 1];
            for _ in 0..n {
                observed[sample(random).map_or(count, |place| self.cell(place))] += 1;
            }
            let expected: Vec<f64> = shares.iter().map(|share| share * n as f64).collect();
            let n = n as f64;
            let refused = [observed[count] as f64, rest.max(0.0) * n];
            let of_refused = p_of_mean([refused[0], refused[1].max(1.0)], refused[1], REST_ERROR * n);
            // Slivers of the density that lie between points of the integral.
            let is_empty = |cell: usize| expected[cell] < LEAST_RESOLVED;
            let strays: u64 = (0..count).filter(|&cell| is_empty(cell)).map(|cell| observed[cell]).sum();
            if strays as f64 <= REST_ERROR * n {
                (0..count).filter(|&cell| is_empty(cell)).for_each(|cell| observed[cell] = 0);
            }
            let of_cells = chi_square::p_value(&observed[..count], &expected);
            let p = if rest < -REST_ERROR { 0.0 } else { (2.0 * of_cells.min(of_refused)).min(1.0) };
            let off = |cell: &usize| (observed[*cell] as f64 - expected[*cell]).abs() / expected[*cell].max(1.0).sqrt();
            let worst = (0..count).max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
            (
                p,
                format!(
                    "{} for {:.1} in {:.3?}, {} for {:.1} refused",
                    observed[worst],
                    expected[worst],
                    self.bounds_of(worst),
                    refused[0],
                    refused[1]
                ),
            )
        });
    }
}

/// The integral of a function over a rectangle, to about 2e-5 where its values are of a density: by Gauss and Legendre's points, in ever
/// smaller parts where these do not agree with the whole. It is halved `least` times along each axis whatever they say, and one time more.
fn integral(f: &impl Fn([f64; 2]) -> f64, bounds: [[f64; 2]; 2], least: u32) -> f64 {
    /// Halvings where parts do not agree, beside those that are always done.
    const MORE: u32 = 5;
    fn part(
        f: &impl Fn([f64; 2]) -> f64,
        bounds: [[f64; 2]; 2],
        whole: f64,
        tolerance: f64,
        [depth, least]: [u32; 2],
    ) -> f64 {
        let middle = bounds.map(|[low, high]| 0.5 * (low + high));
        let quarters: [[[f64; 2]; 2]; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|axis| {
                let [low, high] = bounds[axis];
                if i >> axis & 1 == 0 { [low, middle[axis]] } else { [middle[axis], high] }
            })
        });
        let values = quarters.map(|quarter| gauss(f, quarter));
        let sum: f64 = values.iter().sum();
        if depth >= least + MORE || depth >= least && (sum - whole).abs() <= tolerance {
            return sum;
        }
        let parts = quarters.iter().zip(values);
        parts.map(|(quarter, value)| part(f, *quarter, value, 0.5 * tolerance, [depth + 1, least])).sum()
    }
    part(f, bounds, gauss(f, bounds), 2e-5, [0, least])
}

/// The integral by three points along each axis.
fn gauss(f: &impl Fn([f64; 2]) -> f64, [[x0, x1], [y0, y1]]: [[f64; 2]; 2]) -> f64 {
    const POINTS: [(f64, f64); 3] =
        [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
    let at = |low: f64, high: f64, place: f64| 0.5 * (low + high) + 0.5 * (high - low) * place;
    let sum: f64 = POINTS
        .iter()
        .flat_map(|x| POINTS.iter().map(move |y| (x, y)))
        .map(|((x, wx), (y, wy))| wx * wy * f([at(x0, x1, *x), at(y0, y1, *y)]))
        .sum();
    0.25 * (x1 - x0) * (y1 - y0) * sum
}

/// The cells of the sphere, by polar angle and azimuth: even steps of the polar angle resolve lobes at the poles, as those of its cosine do
/// not.
const SPHERE: Cells = Cells { bounds: [[0.0, PI], [-PI, PI]], counts: [16, 24] };

/// A function of directions as one over [`SPHERE`].
fn by_angles(f: impl Fn([f32; 3]) -> f64) -> impl Fn([f64; 2]) -> f64 {
    move |[theta, phi]| {
        let direction = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        f(direction.map(|x| x as f32)) * theta.sin()
    }
}

/// The integral of a function over all directions, to about 1e-5.
pub fn over_directions(f: impl Fn([f32; 3]) -> f64) -> f64 {
    let f = by_angles(f);
    (0..SPHERE.counts[0] * SPHERE.counts[1]).map(|cell| integral(&f, SPHERE.bounds_of(cell), 2)).sum()
}

/// Fails if sampled directions (`None`: refused) do not follow a density per steradian.
pub fn directions(
    name: &str,
    quick: u64,
    mut sample: impl FnMut(&mut Random) -> Option<[f32; 3]>,
    density: impl Fn([f32; 3]) -> f64,
) {
    let place = |[x, y, z]: [f32; 3]| {
        let [x, y, z] = [x, y, z].map(f64::from);
        [x.hypot(y).atan2(z), y.atan2(x)]
    };
    SPHERE.judge(name, quick, |random| sample(random).map(place), by_angles(density));
}

/// Fails if sampled places (`None`: refused) do not follow a density over a rectangle of these bounds along each axis.
pub fn places(
    name: &str,
    quick: u64,
    bounds: [[f64; 2]; 2],
    mut sample: impl FnMut(&mut Random) -> Option<[f32; 2]>,
    density: impl Fn([f32; 2]) -> f64,
) {
    let cells = Cells { bounds, counts: [16, 16] };
    cells.judge(
        name,
        quick,
        |random| sample(random).map(|place| place.map(f64::from)),
        |place| density(place.map(|x| x as f32)),
    );
}

/// Fails if sampled numbers (`None`: refused) do not follow a density over an interval.
pub fn values(
    name: &str,
    quick: u64,
    bounds: [f64; 2],
    mut sample: impl FnMut(&mut Random) -> Option<f64>,
    density: impl Fn(f64) -> f64,
) {
    let cells = Cells { bounds: [bounds, [0.0, 1.0]], counts: [100, 1] };
    cells.judge(name, quick, |random| sample(random).map(|x| [x, 0.5]), |[x, _]| density(x));
}

/// Fails if sampled indices (`None`: refused) do not have these probabilities.
pub fn choices(name: &str, quick: u64, probabilities: &[f64], mut sample: impl FnMut(&mut Random) -> Option<usize>) {
    let n = samples(quick);
    let rest = 1.0 - probabilities.iter().sum::<f64>();
    assert!(rest > -REST_ERROR, "{name}: the probabilities add to {}", 1.0 - rest);
    let none = probabilities.len();
    let expected: Vec<f64> = probabilities.iter().chain([&rest.max(0.0)]).map(|p| p * n as f64).collect();
    judge(name, |random, _| {
        let mut observed = vec![0u64; expected.len()];
        (0..n).for_each(|_| observed[sample(random).unwrap_or(none)] += 1);
        if observed[none] as f64 - expected[none] < REST_ERROR * n as f64 {
            observed[none] = expected[none] as u64;
        }
        (chi_square::p_value(&observed, &expected), String::new())
    });
}

/// Mean and its variance, of some estimates.
fn mean(n: u64, mut estimate: impl FnMut() -> f64) -> [f64; 2] {
    // Welford's way: nothing large cancels.
    let (mut mean, mut squares) = (0.0, 0.0);
    for i in 0..n {
        let x = estimate();
        let off = x - mean;
        mean += off / (i + 1) as f64;
        squares += off * (x - mean);
    }
    [mean, squares / n as f64 / (n - 1) as f64]
}

/// The probability of a mean that lies so far away, or farther, from the right one, which is known to `error`.
fn p_of_mean([mean, variance]: [f64; 2], truth: f64, error: f64) -> f64 {
    let apart = ((mean - truth).abs() - error).max(0.0);
    // Also of NaN.
    if !(apart > 0.0) {
        return if mean.is_nan() { 0.0 } else { 1.0 };
    }
    2.0 * Normal::standard().sf(apart / variance.sqrt())
}

/// Fails if the mean of estimates is not the truth, which is known to an error.
pub fn mean_is(name: &str, quick: u64, mut estimate: impl FnMut(&mut Random) -> f64, truth: f64, error: f64) {
    let n = samples(quick);
    judge(name, |random, _| {
        let found = mean(n, || estimate(random));
        (p_of_mean(found, truth, error), format!("{} ± {:.1e} for {truth}", found[0], found[1].sqrt()))
    });
}

/// Fails if two ways of estimating do not have the same mean, but for a known error of either.
pub fn means_agree(
    name: &str,
    quick: u64,
    mut one: impl FnMut(&mut Random) -> f64,
    mut other: impl FnMut(&mut Random) -> f64,
    error: f64,
) {
    let n = samples(quick);
    judge(name, |random, _| {
        let [a, b] = [mean(n, || one(random)), mean(n, || other(random))];
        let variance = a[1] + b[1];
        (p_of_mean([a[0], variance], b[0], error), format!("{} and {}, ± {:.1e}", a[0], b[0], variance.sqrt()))
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use std::panic::catch_unwind;

    fn sphere(random: &mut Random) -> Option<[f32; 3]> {
        let (z, phi) = (1.0 - 2.0 * random.number(), TAU * random.number());
        let r = (1.0 - z * z).sqrt();
        Some([r * phi.cos(), r * phi.sin(), z].map(|x| x as f32))
    }

    #[test]
    fn right_densities_pass_and_wrong_ones_fail() {
        let even = 0.25 / PI;
        directions("even", 1 << 14, sphere, |_| even);
        // A tenth more on one side, and the same integral.
        assert!(
            catch_unwind(|| directions("wrong", 1 << 16, sphere, |d| even * (1.0 + 0.1 * f64::from(d[0].signum()))))
                .is_err()
        );
        // Five of a hundred are refused and nobody says so.
        let refusing = |random: &mut Random| if random.number() < 0.05 { None } else { sphere(random) };
        assert!(catch_unwind(|| directions("refusing", 1 << 14, refusing, |_| even)).is_err());
        directions("refusing as said", 1 << 14, refusing, |_| 0.95 * even);
        // Too much.
        assert!(catch_unwind(|| directions("more than one", 1 << 10, sphere, |_| 1.1 * even)).is_err());
    }

    #[test]
    fn narrow_and_cut_densities_are_integrated() {
        let narrow = |[x, y]: [f64; 2]| (-0.5 * (x * x + y * y) / 1e-4).exp() / (TAU * 1e-4);
        assert!((integral(&narrow, [[-0.07, 0.09], [-0.08, 0.05]], 1) - 1.0).abs() < 1e-4);
        let disc = |[x, y]: [f64; 2]| if x * x + y * y < 0.25 { 4.0 / PI } else { 0.0 };
        assert!((integral(&disc, [[0.0, 0.6], [0.0, 0.6]], 1) - 0.25).abs() < 1e-4);
        values("ramp", 1 << 14, [0.0, 1.0], |random| Some(random.number().sqrt()), |x| 2.0 * x);
        places("square", 1 << 14, [[0.0, 1.0]; 2], |random| Some(random.numbers()), |_| 1.0);
        choices("coin", 1 << 14, &[0.25, 0.75], |random| Some(usize::from(random.number() > 0.25)));
        assert!(
            catch_unwind(|| choices("false coin", 1 << 14, &[0.25, 0.75], |random| Some(usize::from(
                random.number() > 0.3
            ))))
            .is_err()
        );
    }

    #[test]
    fn means_are_held_to_their_noise() {
        mean_is("mean", 1 << 14, Random::number, 0.5, 0.0);
        assert!(catch_unwind(|| mean_is("off", 1 << 16, Random::number, 0.51, 0.0)).is_err());
        mean_is("off by a known error", 1 << 16, Random::number, 0.51, 0.02);
        assert!(catch_unwind(|| mean_is("undefined", 1 << 8, |_| f64::NAN, 0.5, 0.0)).is_err());
        means_agree("two ways", 1 << 14, Random::number, |random| 1.0 - random.number(), 0.0);
    }
}
