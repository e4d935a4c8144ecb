//! Crossings that no formula gives, by Newton's method in a bracket.

use super::big::{Big, PRECISION_BITS, Vector, dot, norm, plus_times};
use super::inputs::{BigConic, Inputs, Surface};
use super::trace::{Crossing, meet_conic};

/// A step as a part of the length that is searched: shorter takes longer, longer may step over two crossings.
const LONGEST_STEP: f64 = 1.0 / 32.0;
/// Each step that finds nothing may be this much longer than the one before.
const GROWTH: f64 = 1.3;
/// Hits of a toroid's starting conic so many half diameters from the axis are no place to start from.
const FAR_OUTSIDE: f64 = 1.3;
/// Number of sizes away from the start beyond which there is nothing left to be found.
const FARTHEST: f64 = 8.0;

/// The surface's function along the ray, mirrored and turned so that it is below 0 at u = 0 and the crossing that is
/// meant is the first u > 0 where it rises through 0.
struct Walk<'a> {
    inputs: &'a Inputs,
    start: Big,
    is_back: bool,
}

/// A place along the walk.
#[derive(Clone)]
struct Place {
    u: Big,
    value: Big,
    slope: Big,
}

/// See the module [`super`] for which crossing this is.
pub(super) fn meet(inputs: &Inputs) -> Crossing {
    let (origin, d) = (&inputs.origin, &inputs.direction);
    let foot = -dot(origin, d);
    let start = match meet_conic(&starting_conic(inputs), origin, d, inputs.case.side) {
        Crossing::Met { t, .. } if is_start(inputs, &plus_times(origin, d, &t)) => t,
        _ => foot.clone(),
    };
    let extent = match (inputs.case.semi_diameter, inputs.surface.base().c.to_f64()) {
        (Some(semi), _) => semi,
        (None, 0.0) => 1.0,
        (None, c) => 1.0 / c.abs(),
    };
    let distances = [&foot, &start].map(|t| norm(&plus_times(origin, d, t)).to_f64());
    let size = distances[0] + distances[1] + extent;

    let mut walk = Walk { inputs, start, is_back: false };
    let zero = Big::new(0.0);
    let Some(mut here) = walk.at(&zero) else { return Crossing::Missed { discriminant: None, nearest: None } };
    if here.value.is_zero() && here.slope.is_positive() {
        return walk.met(&here);
    }
    if here.value.is_positive() {
        walk.is_back = true;
        here.value = -here.value;
    }
    match walk.first_bracket(here, size) {
        Ok((low, high)) => walk.met(&walk.root(low, high, size)),
        Err(nearest) => Crossing::Missed { discriminant: None, nearest: Some(walk.t(&nearest.u)) },
    }
}

/// The conic whose hit is near: of a toroid, one as curved as it is on the average.
fn starting_conic(inputs: &Inputs) -> BigConic {
    let base = inputs.surface.base();
    match &inputs.surface {
        Surface::Toroid(_, across) => BigConic { c: (across + &base.c).times_power_of_two(-1), k: Big::new(0.0) },
        _ => base.clone(),
    }
}

/// True if the starting conic's hit says something of the surface: of an asphere, where that is on the vertex sheet; of a
/// toroid, not far outside of the rim, where a saddle may turn back and be crossed again.
fn is_start(inputs: &Inputs, p: &Vector) -> bool {
    let is_near = match &inputs.surface {
        Surface::Toroid(..) => {
            let from_axis = (p[0].squared() + p[1].squared()).to_f64().sqrt();
            inputs.case.semi_diameter.is_none_or(|semi| from_axis <= FAR_OUTSIDE * semi)
        }
        _ => !inputs.surface.base().gradient(p)[2].is_negative(),
    };
    is_near && inputs.surface.at(p).is_some()
}

impl Walk<'_> {
    fn t(&self, u: &Big) -> Big {
        if self.is_back { &self.start - u } else { &self.start + u }
    }

    /// The place at the distance `u` from the start; `None` where the profile has ended.
    fn at(&self, u: &Big) -> Option<Place> {
        let Inputs { origin, direction, surface, case, .. } = self.inputs;
        let at = surface.at(&plus_times(origin, direction, &self.t(u)))?;
        let slope = dot(&at.gradient, direction);
        let is_turned = (case.side < 0.0) != self.is_back;
        Some(Place {
            u: u.clone(),
            value: if is_turned { -at.value } else { at.value },
            slope: if case.side < 0.0 { -slope } else { slope },
        })
    }

    fn met(&self, at: &Place) -> Crossing {
        let slope = if self.inputs.case.side < 0.0 { -&at.slope } else { at.slope.clone() };
        Crossing::Met { t: self.t(&at.u), slope }
    }

    /// Two places with the first crossing between them, or the place that came nearest to one.
    fn first_bracket(&self, mut here: Place, size: f64) -> Result<(Place, Place), Place> {
        let mut longest = size * LONGEST_STEP;
        let mut nearest = here.clone();
        let farthest = Big::new(size * FARTHEST);
        while here.u < farthest {
            let mut step = Big::new(longest);
            if here.slope.is_positive() {
                let newton = -(&here.value / &here.slope);
                if newton < step {
                    step = newton;
                }
            }
            // Newton's step from before a crossing that curves away ends on it from one side.
            if step < smallest(size) {
                return Ok((here.clone(), here));
            }
            let Some(next) = self.step(&here, step) else { break };
            if !next.value.is_negative() {
                return Ok((here, next));
            }
            if here.slope.is_positive() && next.slope.is_negative() {
                let top = self.top(here, &next, size);
                if !top.1.value.is_negative() {
                    return Ok(top);
                }
                nearest = nearer(nearest, top.1);
            }
            nearest = nearer(nearest, next.clone());
            here = next;
            longest *= GROWTH;
        }
        Err(nearest)
    }

    /// A step ahead, shortened to end where there still is a surface.
    fn step(&self, here: &Place, mut step: Big) -> Option<Place> {
        for _ in 0..40 {
            if let Some(next) = self.at(&(&here.u + &step)) {
                return Some(next);
            }
            step = step.times_power_of_two(-1);
        }
        None
    }

    /// The greatest value between two places, by halving until it is above 0 or found; and the place before it.
    fn top(&self, mut low: Place, high: &Place, size: f64) -> (Place, Place) {
        let mut high = high.clone();
        // At a maximum an error of half the digits is none in the value.
        let width = Big::new(size).times_power_of_two(-(PRECISION_BITS as i32) / 2);
        while &high.u - &low.u > width {
            let Some(middle) = self.at(&(&low.u + &high.u).times_power_of_two(-1)) else { break };
            if !middle.value.is_negative() {
                return (low, middle);
            }
            if middle.slope.is_positive() { low = middle } else { high = middle }
        }
        (low.clone(), low)
    }

    /// The crossing between two places.
    fn root(&self, mut low: Place, mut high: Place, size: f64) -> Place {
        let smallest = smallest(size);
        let mut here = if low.value.abs() < high.value { low.clone() } else { high.clone() };
        while &high.u - &low.u > smallest {
            let newton = &here.u - &here.value / &here.slope;
            let is_inside = here.slope.is_positive() && low.u < newton && newton < high.u;
            // The width of the whole bracket is not what is left to go once Newton's method converges.
            if here.slope.is_positive() && (&newton - &here.u).abs() < smallest {
                return here;
            }
            let u = if is_inside { newton } else { (&low.u + &high.u).times_power_of_two(-1) };
            let Some(next) = self.at(&u) else { return here };
            if next.value.is_negative() {
                low = next.clone()
            } else {
                high = next.clone()
            }
            here = next;
        }
        here
    }
}

/// A distance that is none.
fn smallest(size: f64) -> Big {
    Big::new(size).times_power_of_two(24 - PRECISION_BITS as i32)
}

fn nearer(a: Place, b: Place) -> Place {
    if b.value.abs() < a.value.abs() { b } else { a }
}
