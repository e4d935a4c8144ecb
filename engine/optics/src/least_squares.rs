//! Nonlinear least squares for few parameters: the method of Levenberg (1944) and Marquardt (1963) with Moré's (1978) scaling, dense, with
//! bounds.

/// Derivatives are taken over this part of a parameter's scale: the third root of the last bit, for central differences.
const DIFFERENCE: f64 = 6e-6;
/// The search ends where a step lowers the sum of squares by less than this part of it, or moves all parameters by less than this part of
/// their scales.
const ENOUGH: f64 = 1e-13;
const STILL: f64 = 1e-12;
/// Damping at the start, parts of the scaled diagonal; its bounds.
const FIRST_DAMPING: f64 = 1e-3;
const MOST_DAMPING: f64 = 1e12;
const LEAST_DAMPING: f64 = 1e-15;
/// The most steps.
const MOST_STEPS: usize = 200;

/// A parameter that is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// The value to start from, within the bounds.
    pub start: f64,
    /// A change of it that counts; above zero.
    pub scale: f64,
    /// The least and the largest value.
    pub bounds: [f64; 2],
}

impl Parameter {
    /// A parameter without bounds.
    pub fn free(start: f64, scale: f64) -> Self {
        Self { start, scale, bounds: [f64::NEG_INFINITY, f64::INFINITY] }
    }
}

/// A minimum of a sum of squares.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The parameters.
    pub values: Vec<f64>,
    /// The residuals there.
    pub residuals: Vec<f64>,
    /// Derivatives of the residuals there, by parameter, then residual.
    pub slopes: Vec<Vec<f64>>,
    /// Sum of the squares of the residuals.
    pub sum: f64,
    /// Steps that were taken.
    pub steps: usize,
}

/// The parameters of least sum of squared `residuals`, as many as there are for every set of parameters. `None` from the function is a
/// place where there are none: the search stays away. `None` as the result: there are none at the start.
pub fn minimise(parameters: &[Parameter], residuals: impl Fn(&[f64]) -> Option<Vec<f64>>) -> Option<Minimum> {
    let all_finite = |found: Vec<f64>| found.iter().all(|value| value.is_finite()).then_some(found);
    let at = |values: &[f64]| residuals(values).and_then(all_finite);
    let mut values: Vec<f64> = parameters.iter().map(|p| p.start).collect();
    let mut found = at(&values)?;
    let mut sum = squares(&found);
    let mut slopes = slopes_at(parameters, &values, &found, &at);
    let mut largest = vec![0.0; parameters.len()];
    let (mut damping, mut steps) = (FIRST_DAMPING, 0);
    'search: while steps < MOST_STEPS {
        let normal = Normal::new(&slopes, &found, &mut largest);
        loop {
            let Some(step) = normal.step(damping, parameters, &values) else { break 'search };
            let next: Vec<f64> = (values.iter().zip(&step).zip(parameters))
                .map(|((value, step), p)| (value + step).clamp(p.bounds[0], p.bounds[1]))
                .collect();
            let moved = next.iter().zip(&values).zip(parameters).map(|((a, b), p)| ((a - b) / p.scale).abs());
            if moved.fold(0.0, f64::max) < STILL {
                break 'search;
            }
            if let Some(lower) = at(&next).filter(|next| squares(next) < sum) {
                let before = sum;
                (values, sum, found) = (next, squares(&lower), lower);
                slopes = slopes_at(parameters, &values, &found, &at);
                damping = (damping * 0.1).max(LEAST_DAMPING);
                steps += 1;
                if before - sum <= ENOUGH * before {
                    break 'search;
                }
                break;
            }
            damping *= 8.0;
            if damping > MOST_DAMPING {
                break 'search;
            }
        }
    }
    Some(Minimum { values, residuals: found, slopes, sum, steps })
}

fn squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

/// Derivatives by central differences, one-sided where a bound or a place without residuals is near.
fn slopes_at(
    parameters: &[Parameter],
    values: &[f64],
    here: &[f64],
    at: &impl Fn(&[f64]) -> Option<Vec<f64>>,
) -> Vec<Vec<f64>> {
    let of = |(i, p): (usize, &Parameter)| {
        let step = DIFFERENCE * p.scale;
        let beside = |by: f64| {
            let mut moved = values.to_vec();
            moved[i] += by;
            let is_within = moved[i] >= p.bounds[0] && moved[i] <= p.bounds[1];
            is_within.then(|| at(&moved)).flatten().map(|found| (moved[i], found))
        };
        let (a, b) = match (beside(-step), beside(step)) {
            (Some(a), Some(b)) => (a, b),
            (Some(a), None) => (a, (values[i], here.to_vec())),
            (None, Some(b)) => ((values[i], here.to_vec()), b),
            // Nothing can be said of it, so it stays.
            (None, None) => return vec![0.0; here.len()],
        };
        a.1.iter().zip(&b.1).map(|(low, high)| (high - low) / (b.0 - a.0)).collect()
    };
    parameters.iter().enumerate().map(of).collect()
}

/// The normal equations of a step.
struct Normal {
    /// Products of the slopes.
    matrix: Vec<Vec<f64>>,
    /// Products of slopes and residuals: half the gradient.
    gradient: Vec<f64>,
    /// The largest diagonal so far, for scaling.
    diagonal: Vec<f64>,
}

impl Normal {
    fn new(slopes: &[Vec<f64>], residuals: &[f64], largest: &mut [f64]) -> Self {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let matrix: Vec<Vec<f64>> = slopes.iter().map(|a| slopes.iter().map(|b| dot(a, b)).collect()).collect();
        for (i, most) in largest.iter_mut().enumerate() {
            *most = most.max(matrix[i][i]);
        }
        let gradient = slopes.iter().map(|a| dot(a, residuals)).collect();
        Self { matrix, gradient, diagonal: largest.to_vec() }
    }

    /// The damped step; parameters that a bound holds stay. `None`: no parameter can move.
    fn step(&self, damping: f64, parameters: &[Parameter], values: &[f64]) -> Option<Vec<f64>> {
        let is_free = |i: &usize| {
            let [low, high] = parameters[*i].bounds;
            let downhill = -self.gradient[*i];
            self.diagonal[*i] > 0.0 && !(values[*i] <= low && downhill < 0.0 || values[*i] >= high && downhill > 0.0)
        };
        let free: Vec<usize> = (0..parameters.len()).filter(is_free).collect();
        if free.is_empty() {
            return None;
        }
        // Each parameter in units in which its column has length one.
        let unit: Vec<f64> = free.iter().map(|&i| self.diagonal[i].sqrt()).collect();
        let mut matrix: Vec<Vec<f64>> = (free.iter().zip(&unit))
            .map(|(&i, a)| free.iter().zip(&unit).map(|(&j, b)| self.matrix[i][j] / (a * b)).collect())
            .collect();
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] += damping;
        }
        let right = free.iter().zip(&unit).map(|(&i, unit)| -self.gradient[i] / unit).collect();
        let solved = solve(matrix, right)?;
        let mut step = vec![0.0; parameters.len()];
        for ((&i, unit), part) in free.iter().zip(&unit).zip(solved) {
            step[i] = part / unit;
        }
        Some(step)
    }
}

/// The solution of a symmetric positive system by Cholesky's method; `None`: it has none in these numbers.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = right.len();
    for i in 0..n {
        for j in 0..=i {
            let rest = matrix[i][j] - (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum::<f64>();
            if i == j {
                // Rounding makes a pivot of nothing: the smallest is that of the damping.
                matrix[i][i] = rest.max(f64::EPSILON * 1e-3).sqrt();
            } else {
                matrix[i][j] = rest / matrix[j][j];
            }
        }
    }
    for i in 0..n {
        let known: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    right.iter().all(|value| value.is_finite()).then_some(right)
}

#[cfg(test)]
mod tests {
    use super::{Parameter, minimise};

    /// Misra1a of NIST's Statistical Reference Datasets, whose certified parameters have eleven digits.
    #[test]
    fn the_certified_minimum_of_misra() {
        let y = [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78];
        let x = [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0];
        let residuals =
            |b: &[f64]| Some(x.iter().zip(y).map(|(x, y)| b[0] * (1.0 - (-b[1] * x).exp()) - y).collect::<Vec<_>>());
        let start = [Parameter::free(500.0, 100.0), Parameter::free(1e-4, 1e-4)];
        let found = minimise(&start, residuals).unwrap();
        // The minimum is flat: rounding of the sum leaves its place open to the square root of the last bit.
        assert!((found.values[0] / 2.389_421_291_8e2 - 1.0).abs() < 1e-7, "{found:?}");
        assert!((found.values[1] / 5.501_564_318_1e-4 - 1.0).abs() < 1e-7, "{found:?}");
        assert!((found.sum / 1.245_513_889_4e-1 - 1.0).abs() < 1e-9);
    }

    /// Rosenbrock's valley, whose floor is at (1, 1); with the first bounded by 0.5 it ends at (0.5, 0.25).
    #[test]
    fn bounds_hold() {
        let residuals = |v: &[f64]| Some(vec![10.0 * (v[1] - v[0] * v[0]), 1.0 - v[0]]);
        let start = [Parameter::free(-1.2, 1.0), Parameter::free(1.0, 1.0)];
        let floor = minimise(&start, residuals).unwrap().values;
        assert!((floor[0] - 1.0).abs() < 1e-9 && (floor[1] - 1.0).abs() < 1e-9, "{floor:?}");
        let held = [Parameter { bounds: [-2.0, 0.5], ..start[0] }, start[1]];
        let found = minimise(&held, residuals).unwrap().values;
        assert!(found[0] == 0.5 && (found[1] - 0.25).abs() < 1e-6, "{found:?}");
    }

    /// A search ends before places without residuals.
    #[test]
    fn places_without_residuals_are_left_alone() {
        let residuals = |v: &[f64]| (v[0] < 2.0).then(|| vec![v[0] - 3.0]);
        let found = minimise(&[Parameter::free(0.0, 1.0)], residuals).unwrap().values[0];
        assert!((1.9..2.0).contains(&found), "{found}");
        assert!(minimise(&[Parameter::free(2.5, 1.0)], residuals).is_none());
    }
}
