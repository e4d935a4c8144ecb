//! Sensitivity: the change of the result when one number of a case moves by one unit in its last place.

use super::big::{Big, to_f64};
use super::case::Case;
use super::local::{Local, Triple, dot, norm, plus_times};
use super::trace::{Hit, Status, Truth};
use super::ulp::{Precision, ulp_of};

/// The largest changes when one number of a case (origin, direction, shape, indices) moves by one unit in its last
/// place, up or down. No tracer that rounds its input can be expected to do better.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// Change of the hit, in mm; 0 if there is none.
    pub point: f64,
    /// Change of the unit direction afterwards; 0 if there is none. Where the ray is lost after some of the changes, those count as far as
    /// it lasts: to the tangent, or to the critical angle.
    pub direction: f64,
    /// True if such a change turns the status.
    pub status_flips: bool,
}

/// The sensitivity of the outcome of `case`, given its `truth`, in numbers of `precision`.
///
/// Not by tracing again: the surface is taken as a quadric about the hit, and the new crossing, normal, cosine and
/// radicand are solved for with the change in place, which holds at tangents and at the critical angle, where
/// derivatives are infinite. Tracing again gives the same to two digits, as long as changes are small against the
/// terms of the surface beyond the square. For a miss only `status_flips` says something, from the margins. 2 to 5 µs.
pub fn sensitivity(case: &Case, truth: &Truth, precision: Precision) -> Sensitivity {
    let last_place = match precision {
        Precision::F32 => f64::from(f32::EPSILON),
        Precision::F64 => f64::EPSILON,
    };
    let lost = Sensitivity { status_flips: truth.margins.nearest() < last_place, ..Sensitivity::default() };
    let Some(about) = truth.hit.as_ref().and_then(|hit| About::new(case, hit, truth.status)) else { return lost };
    let mut worst = Sensitivity::default();
    about.for_each_change(precision, |change| {
        for sign in [1.0, -1.0] {
            let moved = about.after(&change.times(sign));
            worst.point = worst.point.max(moved.point);
            worst.direction = worst.direction.max(moved.direction);
            worst.status_flips |= moved.status_flips;
        }
    });
    worst
}

/// The change by a change of one number, before anything is solved for.
#[derive(Clone, Copy, Default)]
struct Change {
    /// Change of the ray's place at the old t.
    place: Triple,
    /// Change of the ray's unit direction.
    direction: Triple,
    /// Change of the surface's function at the old hit.
    value: f64,
    /// Change of the function's gradient at the old hit.
    gradient: Triple,
    /// Change of the second derivative along the ray.
    bend: f64,
    /// Relative change of n1 / n2.
    ratio: f64,
}

impl Change {
    fn times(&self, x: f64) -> Self {
        Self {
            place: self.place.map(|v| v * x),
            direction: self.direction.map(|v| v * x),
            value: self.value * x,
            gradient: self.gradient.map(|v| v * x),
            bend: self.bend * x,
            ratio: self.ratio * x,
        }
    }
}

/// A hit in machine numbers.
struct About<'a> {
    case: &'a Case,
    status: Status,
    local: Local,
    t: f64,
    point: Triple,
    /// Distance from the hit outwards to the rim, and to the rim of the obstruction, in mm.
    to_rim: Option<f64>,
    to_obstruction: f64,
    /// The ray's unit direction.
    direction: Triple,
    /// N, from the exact numbers.
    gradient: Triple,
    /// N · D: the derivative of the surface's function along the ray.
    slope: f64,
    /// The second derivative along the ray.
    bend: f64,
    cosine: f64,
    radicand: Option<f64>,
}

impl<'a> About<'a> {
    fn new(case: &'a Case, hit: &Hit, status: Status) -> Option<Self> {
        let point = to_f64(&hit.point);
        let length = hit.gradient.to_f64();
        let cosine = hit.cosine.to_f64();
        let given = norm(case.direction);
        let squared = hit.point[0].squared() + hit.point[1].squared();
        // Without the cancellation of two near radii.
        let outwards_to = |r: f64| {
            let sum = Big::new(r) + squared.sqrt();
            if sum.is_zero() { 0.0 } else { ((Big::new(r).squared() - &squared) / sum).to_f64() }
        };
        Some(Self {
            case,
            status,
            local: Local::new(case, point)?,
            t: hit.t.to_f64(),
            point,
            to_rim: case.semi_diameter.map(outwards_to),
            to_obstruction: if case.obstruction > 0.0 { outwards_to(case.obstruction) } else { f64::NEG_INFINITY },
            direction: case.direction.map(|x| x / given),
            gradient: to_f64(&hit.normal).map(|x| x * length),
            slope: case.side * cosine * length,
            bend: hit.bend,
            cosine,
            radicand: hit.radicand.as_ref().map(|r| r.to_f64()),
        })
    }

    /// One change for each number of the case, by its unit in the last place.
    fn for_each_change(&self, precision: Precision, mut f: impl FnMut(&Change)) {
        let ulp = |x: f64| ulp_of(x, precision);
        let given = norm(self.case.direction);
        for (i, axis) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate() {
            let place = axis.map(|x| x * ulp(self.case.origin[i]));
            f(&Change { place, ..Change::default() });
            // Across the ray: its length does not count.
            let across = plus_times(axis, self.direction, -self.direction[i]);
            let direction = across.map(|x| x * ulp(self.case.direction[i]) / given);
            f(&Change { direction, place: direction.map(|x| x * self.t), ..Change::default() });
        }
        for number in &self.local.numbers {
            let step = ulp(number.number);
            let gradient = number.gradient.map(|x| x * step);
            let [x, y, z] = self.direction;
            let bend = dot(number.bend, [x * x, y * y, z * z]) * step;
            f(&Change { value: number.value * step, gradient, bend, ..Change::default() });
        }
        for n in [self.case.n1, self.case.n2] {
            f(&Change { ratio: ulp(n) / n, ..Change::default() });
        }
    }

    /// Change of the hit's distance from the axis by a move.
    fn outwards(&self, moved: Triple) -> f64 {
        let [x, y, _] = self.point;
        let sum = x.hypot(y) + (x + moved[0]).hypot(y + moved[1]);
        let squares = moved[0] * (2.0 * x + moved[0]) + moved[1] * (2.0 * y + moved[1]);
        if sum > 0.0 { squares / sum } else { 0.0 }
    }

    /// The movement of the result after `change`.
    #[expect(clippy::too_many_lines, reason = "one chain of formulas")]
    fn after(&self, change: &Change) -> Sensitivity {
        let side = self.case.side;
        // value + slope τ + bend τ² / 2 = 0 gives the shift τ of the crossing along the ray.
        let place = self.local.bend(change.place);
        let steepness = plus_times(plus_times(self.gradient, change.gradient, 1.0), place, 0.5);
        let value = change.value + dot(steepness, change.place);
        let bent = self.local.bend(self.direction);
        let bend = self.bend
            + change.bend
            + 2.0 * dot(bent, change.direction)
            + dot(change.direction, self.local.bend(change.direction));
        let turned =
            dot(self.gradient, change.direction) + dot(change.gradient, self.direction) + dot(place, self.direction);
        let slope = self.slope + turned;
        let squared = slope * slope - 2.0 * bend * value;
        // Of the two forms of the root the one whose terms do not cancel.
        let root = side * squared.max(0.0).sqrt();
        let is_lost = squared < 0.0 || (bend == 0.0 && slope * side <= 0.0);
        let shift = match (is_lost, slope * side > 0.0) {
            (false, true) => -2.0 * value / (slope + root),
            (true, _) if bend == 0.0 => 0.0,
            _ => (root - slope) / bend,
        };
        let moved = plus_times(change.place, self.direction, shift);
        let outwards = self.outwards(moved);
        let is_outside = self.to_rim.is_some_and(|gap| outwards > gap);
        let is_obstructed = outwards < self.to_obstruction;

        // The new normal and cosine less the old ones, without forming either.
        let gradient = plus_times(change.gradient, self.local.bend(moved), 1.0);
        let length = norm(self.gradient);
        let normal = self.gradient.map(|x| x / length);
        let new_length = norm(plus_times(self.gradient, gradient, 1.0));
        let longer = dot(plus_times(self.gradient.map(|x| 2.0 * x), gradient, 1.0), gradient) / (new_length + length);
        let tilt = plus_times(gradient, normal, -longer).map(|x| x / new_length);
        let c = self.cosine;
        let cosine = (side * (turned + bend * shift) - c * longer) / new_length;
        let sheet = self.gradient[2] + gradient[2];

        let mut status = match (is_lost, sheet < 0.0, is_outside, is_obstructed) {
            (true, ..) => Status::Missed,
            (_, true, ..) => Status::WrongSheet,
            (_, _, true, _) => Status::OutsideAperture,
            (.., true) => Status::Obstructed,
            _ => Status::Ok,
        };
        let tilted = |by: f64, along: f64, keep: f64| {
            let kept = change.direction.map(|x| x * keep);
            plus_times(plus_times(kept, normal, side * by), tilt, side * along)
        };
        let turn = match self.radicand {
            None => tilted(-2.0 * cosine, -2.0 * c, 1.0),
            Some(_) if self.case.n1 == self.case.n2 && change.ratio == 0.0 => change.direction,
            Some(radicand) => {
                let m = self.case.n1 / self.case.n2;
                let (dm, squares) = (m * change.ratio, m * m * change.ratio * (2.0 + change.ratio));
                let less = -squares * (1.0 - c * c) + (m * m + squares) * cosine * (2.0 * c + cosine);
                let root = radicand.max(0.0).sqrt();
                let is_total = radicand + less < 0.0;
                if status == Status::Ok && is_total {
                    status = Status::TotalInternalReflection;
                }
                let rise = if is_total { -root } else { less / ((radicand + less).sqrt() + root) };
                let bend = rise - dm * c - (m + dm) * cosine;
                plus_times(tilted(bend, root - m * c, m), self.direction, dm)
            }
        };
        let is_through = self.status == Status::Ok;
        Sensitivity {
            point: norm(moved),
            direction: if is_through { norm(turn) } else { 0.0 },
            status_flips: status != self.status,
        }
    }
}
