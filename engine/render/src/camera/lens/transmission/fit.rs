//! Polynomials of a ray, fitted by least squares.

use std::ops::Range;
use wide::f32x8;

/// Largest powers, of a lens without symmetry and of one with it, whose numbers are themselves of the second power.
const LARGEST: [usize; 2] = [4, 6];
/// Rays must be so many times the terms.
const RAYS_PER_TERM: usize = 4;
/// The error below which no more terms are needed.
const GOOD: f64 = 2e-3;

/// A polynomial of the numbers of a ray.
#[derive(Clone, Debug)]
pub(super) struct Polynomial {
    is_symmetric: bool,
    /// One over the largest distance from the axis, mm, and over the largest cosine.
    scale: [f32; 2],
    /// The largest sum of the powers of a term.
    degree: usize,
    /// The powers of the numbers, by term.
    powers: Vec<[u8; 4]>,
    /// The powers of the terms, laid out for [`Self::values`].
    runs: Vec<Run>,
    tails: Vec<[u8; 2]>,
}

/// Terms next to each other with the same powers of the first two numbers.
#[derive(Clone, Debug)]
struct Run {
    powers: [u8; 2],
    tails: Range<usize>,
}

impl Polynomial {
    fn new(is_symmetric: bool, scale: [f32; 2], degree: usize) -> Self {
        let powers = powers(is_symmetric, degree);
        let mut runs: Vec<Run> = Vec::new();
        for (i, &[a, b, ..]) in powers.iter().enumerate() {
            match runs.last_mut() {
                Some(run) if run.powers == [a, b] => run.tails.end = i + 1,
                _ => runs.push(Run { powers: [a, b], tails: i..i + 1 }),
            }
        }
        let tails = powers.iter().map(|&[_, _, c, d]| [c, d]).collect();
        Self { is_symmetric, scale, degree, powers, runs, tails }
    }

    /// Fits the polynomial to `values`, one list for each wavelength, at rays given by their crossing of a plane and their direction there;
    /// the last `judges` of them only judge. Also returns the coefficients by wavelength, and the largest error.
    pub(super) fn fit(
        is_symmetric: bool,
        rays: &[[f64; 4]],
        values: &[Vec<f64>],
        judges: usize,
    ) -> (Self, Vec<Vec<f64>>, f64) {
        let largest = |a: usize, b: usize| rays.iter().map(|r| r[a].hypot(r[b])).fold(1e-12, f64::max);
        let scale = [largest(0, 1), largest(2, 3)].map(|x| x.recip() as f32);
        let fitted = rays.len().saturating_sub(judges).max(1).min(rays.len());
        let mut best: Option<(Self, Vec<Vec<f64>>, f64)> = None;
        for degree in 0..=LARGEST[usize::from(is_symmetric)] {
            let one = Self::new(is_symmetric, scale, degree);
            if degree > 0 && one.terms() * RAYS_PER_TERM > fitted {
                break;
            }
            let rows: Vec<Vec<f64>> = rays.iter().map(|ray| one.row(*ray)).collect();
            let Some(coefficients) = least_squares(&rows[..fitted], values) else { break };
            let error = |line: &Vec<f64>, values: &Vec<f64>| {
                let value = |row: &Vec<f64>| row.iter().zip(line).map(|(a, b)| a * b).sum::<f64>();
                rows.iter().zip(values).map(|(row, v)| (value(row) - v).abs()).fold(0.0, f64::max)
            };
            let worst = coefficients.iter().zip(values).map(|(line, values)| error(line, values)).fold(0.0, f64::max);
            if best.as_ref().is_none_or(|(_, _, least)| worst < *least) {
                best = Some((one, coefficients, worst));
            }
            if worst < GOOD {
                break;
            }
        }
        best.unwrap_or_else(|| {
            let one = Self::new(is_symmetric, scale, 0);
            (one, vec![vec![1.0]; values.len()], 0.0)
        })
    }

    pub(super) fn terms(&self) -> usize {
        self.powers.len()
    }

    /// The terms of one ray.
    fn row(&self, ray: [f64; 4]) -> Vec<f64> {
        let numbers = self.numbers(ray.map(|n| f32x8::splat(n as f32))).map(|n| f64::from(n.to_array()[0]));
        let power = |powers: &[u8; 4]| numbers.iter().zip(powers).map(|(n, p)| n.powi(i32::from(*p))).product();
        self.powers.iter().map(power).collect()
    }

    /// The numbers whose powers the terms are.
    #[inline(always)]
    fn numbers(&self, [x, y, dx, dy]: [f32x8; 4]) -> [f32x8; 4] {
        let [at, along] = self.scale;
        let (x, y, dx, dy) = (x * at, y * at, dx * along, dy * along);
        if self.is_symmetric { [x * x + y * y, x * dx + y * dy, dx * dx + dy * dy, f32x8::ONE] } else { [x, y, dx, dy] }
    }

    /// The sum of all terms, none below 0, with coefficients for each ray. Rays as their crossing and direction.
    #[inline(always)]
    pub(super) fn values(&self, rays: [f32x8; 4], coefficient: impl Fn(usize) -> f32x8) -> f32x8 {
        let numbers = self.numbers(rays);
        let mut powers = [[f32x8::ONE; LARGEST[1] + 1]; 4];
        for (powers, number) in powers.iter_mut().zip(numbers) {
            for p in 1..=self.degree {
                powers[p] = powers[p - 1] * number;
            }
        }
        let [first, second, third, fourth] = &powers;
        let mut sum = f32x8::ZERO;
        // Terms stand in runs that share the powers of the first two numbers.
        let mut term = 0;
        for run in &self.runs {
            let mut inner = f32x8::ZERO;
            for &[c, d] in &self.tails[run.tails.clone()] {
                let number = if self.is_symmetric {
                    third[usize::from(c)]
                } else {
                    third[usize::from(c)] * fourth[usize::from(d)]
                };
                inner += coefficient(term) * number;
                term += 1;
            }
            sum += inner * (first[usize::from(run.powers[0])] * second[usize::from(run.powers[1])]);
        }
        // Not a number where there is no ray: nothing.
        sum.max(f32x8::ZERO)
    }
}

/// Powers whose sum is at most the degree.
fn powers(is_symmetric: bool, degree: usize) -> Vec<[u8; 4]> {
    let most = degree as u8;
    let last = if is_symmetric { 0 } else { most };
    let mut all = Vec::new();
    for a in 0..=most {
        for b in 0..=most - a {
            for c in 0..=most - a - b {
                for d in 0..=last.min(most - a - b - c) {
                    all.push([a, b, c, d]);
                }
            }
        }
    }
    all
}

/// The coefficients that come nearest to each list of values: by turning the columns at right angles to each other, twice over
/// (Björck, *BIT* 7, 1, 1967; Giraud and Langou, 2002). `None` where columns depend on each other.
fn least_squares(rows: &[Vec<f64>], values: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let terms = rows.first()?.len();
    let mut columns: Vec<Vec<f64>> = (0..terms).map(|k| rows.iter().map(|row| row[k]).collect()).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut upper = vec![vec![0.0; terms]; terms];
    let mut is_used = vec![true; terms];
    for k in 0..terms {
        let (before, rest) = columns.split_at_mut(k);
        let column = &mut rest[0];
        let size = dot(column, column).sqrt();
        for _ in 0..2 {
            for (j, other) in before.iter().enumerate().filter(|(j, _)| is_used[*j]) {
                let along = dot(other, column);
                upper[j][k] += along;
                column.iter_mut().zip(other).for_each(|(a, b)| *a -= along * b);
            }
        }
        let left = dot(column, column).sqrt();
        // What is nothing but others is left out.
        if left.is_nan() || left <= 1e-9 * size {
            is_used[k] = false;
            continue;
        }
        upper[k][k] = left;
        column.iter_mut().for_each(|a| *a /= left);
    }
    let solve = |values: &Vec<f64>| {
        let mut rest: Vec<f64> = values[..rows.len()].to_vec();
        let mut right = vec![0.0; terms];
        for k in (0..terms).filter(|k| is_used[*k]) {
            right[k] = dot(&columns[k], &rest);
            rest.iter_mut().zip(&columns[k]).for_each(|(a, b)| *a -= right[k] * b);
        }
        let mut found = vec![0.0; terms];
        for k in (0..terms).rev().filter(|k| is_used[*k]) {
            let known: f64 = (k + 1..terms).map(|j| upper[k][j] * found[j]).sum();
            found[k] = (right[k] - known) / upper[k][k];
        }
        found
    };
    let all: Vec<Vec<f64>> = values.iter().map(solve).collect();
    all.iter().flatten().all(|c| c.is_finite()).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polynomial comes back as it was, with and without symmetry.
    #[test]
    fn what_is_a_polynomial_is_found() {
        let point = |i: usize| [1, 2, 3, 5].map(|k| ((i * i * k + 7 * i) % 101) as f64 / 50.0 - 1.0);
        let rays: Vec<[f64; 4]> =
            (0..500).map(point).map(|[x, y, a, b]| [9.0 * x, 9.0 * y, 0.3 * a, 0.3 * b]).collect();
        let symmetric = |r: &[f64; 4]| 0.8 + 1e-3 * (r[0] * r[0] + r[1] * r[1]) - 0.05 * (r[0] * r[2] + r[1] * r[3]);
        let other = |r: &[f64; 4]| 0.8 + 1e-2 * r[0] - 0.2 * r[1] * r[3];
        for (is_symmetric, value) in [(true, &symmetric as &dyn Fn(&[f64; 4]) -> f64), (false, &other)] {
            let values: Vec<f64> = rays.iter().map(value).collect();
            let (shape, lines, worst) = Polynomial::fit(is_symmetric, &rays, &[values], 50);
            assert!(worst < 1e-5, "{worst}");
            let found =
                shape.values(rays[3].map(|n| f32x8::splat(n as f32)), |term| f32x8::splat(lines[0][term] as f32));
            assert!((f64::from(found.to_array()[5]) - value(&rays[3])).abs() < 1e-5);
        }
    }
}
