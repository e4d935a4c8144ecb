//! The distance from the middle up to which a distortion can be inverted: where it first folds back.

use super::planar::Distortion;
use glam::DVec2;
use std::f64::consts::TAU;

/// Numbers of steps in which a fold is looked for: along the one line of a radial distortion, and along each of several lines.
const STEPS_ALONE: u32 = 4096;
const STEPS_EACH: u32 = 512;
/// Number of lines on which a distortion that is not radial is looked at. A point between two lines is judged by its own derivative.
const LINES: usize = 64;
/// Part of a radius by which the fold may lie elsewhere between two lines than on both; a table ends at the corners of its picture.
const BETWEEN: f64 = 0.05;
const BETWEEN_OF_TABLE: f64 = 0.25;

/// The points about the middle at which a distortion has a value that it takes there alone: on every line from the middle up to the first
/// point at which the derivative's determinant is not positive.
#[derive(Clone, Debug)]
pub(super) enum Limit {
    /// A disc of this radius.
    Radius(f64),
    /// Radii at even angles from the x axis on, and between them up to this part more or less.
    Radii(Vec<f64>, f64),
}

impl Limit {
    /// The limit of a distortion on a plane of radius `reach`, which may be infinite, whose picture is about `size` large.
    pub(super) fn new(distortion: &Distortion, reach: f64, size: f64) -> Self {
        match distortion {
            Distortion::Radial(radial) => {
                let slope = |r: f64| {
                    let (ratio, slope) = radial.at(r);
                    slope.min(ratio)
                };
                Self::Radius(first_fold(slope, reach, size, STEPS_ALONE).unwrap_or(reach))
            }
            _ => {
                let fold = |line: usize| {
                    let along = DVec2::from_angle(TAU * line as f64 / LINES as f64);
                    let determinant = |r: f64| distortion.at(along * r).1.determinant();
                    first_fold(determinant, reach, size, STEPS_EACH).unwrap_or(reach)
                };
                let is_table = matches!(distortion, Distortion::StMap(_));
                let between = if is_table { BETWEEN_OF_TABLE } else { BETWEEN };
                Self::Radii((0..LINES).map(fold).collect(), between)
            }
        }
    }

    /// True if the distortion can be turned round at a point.
    pub(super) fn holds(&self, distortion: &Distortion, q: DVec2) -> bool {
        match self {
            Self::Radius(limit) => q.length_squared() < limit * limit,
            Self::Radii(limits, between) => {
                let r = q.length();
                let line = q.to_angle().rem_euclid(TAU) / TAU * LINES as f64;
                let first = line as usize % LINES;
                let (a, b) = (limits[first], limits[(first + 1) % LINES]);
                let (least, most) = (a.min(b) * (1.0 - between), a.max(b) * (1.0 + between));
                r < least || (r < most && distortion.at(q).1.determinant() > 0.0)
            }
        }
    }

    /// The largest circle about the middle in which the distortion can be turned round; infinite if there is no end.
    pub(super) fn least(&self) -> f64 {
        match self {
            Self::Radius(limit) => *limit,
            Self::Radii(limits, _) => limits.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }

    /// True if a fold ends it anywhere.
    pub(super) fn is_fold(&self, reach: f64) -> bool {
        self.least() < reach
    }
}

/// The first zero of `slope` between 0 and `reach`; half of the steps are within `size`. `None`: it is positive everywhere.
fn first_fold(slope: impl Fn(f64) -> f64, reach: f64, size: f64, steps: u32) -> Option<f64> {
    let last = reach.min(size * f64::from(steps));
    // From 0 to infinity, or to the end.
    let radius = |t: f64| {
        let r = size * t / (1.0 - t).max(1e-300);
        if reach.is_finite() { reach * t } else { r.min(last) }
    };
    let place = |i: u32| f64::from(i) / f64::from(steps);
    let is_positive = |t: f64| slope(radius(t)) > 0.0;
    let mut before = [slope(0.0), slope(0.0)];
    for i in 1..=steps {
        let now = slope(radius(place(i)));
        if !(now > 0.0) {
            return Some(radius(crossing(&is_positive, place(i - 1), place(i))));
        }
        // A short fold may hide about a minimum.
        if i >= 2
            && before[1] < before[0]
            && before[1] < now
            && let Some(low) = lowest_not_positive(&|t| slope(radius(t)), place(i - 2), place(i))
        {
            return Some(radius(crossing(&is_positive, place(i - 2), low)));
        }
        before = [before[1], now];
    }
    None
}

/// The place where a condition that holds at `a` and not at `b` ends.
fn crossing(holds: &impl Fn(f64) -> bool, mut a: f64, mut b: f64) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (a + b);
        if middle <= a || middle >= b {
            break;
        }
        if holds(middle) {
            a = middle;
        } else {
            b = middle;
        }
    }
    a
}

/// A place between `a` and `b`, which enclose a minimum of `f`, where `f` is not positive.
fn lowest_not_positive(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> Option<f64> {
    // Golden section (Kiefer 1953).
    let part = 0.5 * (3.0 - 5.0f64.sqrt());
    let (mut x, mut y) = (a + part * (b - a), b - part * (b - a));
    let (mut at_x, mut at_y) = (f(x), f(y));
    for _ in 0..40 {
        if !(at_x > 0.0) {
            return Some(x);
        }
        if !(at_y > 0.0) {
            return Some(y);
        }
        if at_x < at_y {
            (b, y, at_y) = (y, x, at_x);
            x = a + part * (b - a);
            at_x = f(x);
        } else {
            (a, x, at_x) = (x, y, at_y);
            y = b - part * (b - a);
            at_y = f(y);
        }
    }
    None
}
