//! Crossings that no formula gives: Newton's method inside of a bracket.

use crate::lane::{Lane, Mask, Real};

/// A surface's function along a ray: negative before the surface, positive behind it, as light goes from scene to film.
#[derive(Clone, Copy)]
pub(super) struct Along<L> {
    /// Value, times any positive weight.
    pub(super) value: L,
    /// The derivative of the value by t, times the same weight.
    pub(super) slope: L,
    /// The size of the terms that the value is the sum of, times the same weight: its rounding is a part of it.
    pub(super) terms: L,
}

/// A surface seen along rays, one in each lane.
pub(super) trait Profiled<L: Lane> {
    /// The surface's function at t. (A trait and no closure: it must be inlined where the wide instructions are.)
    fn along(&self, t: L) -> Along<L>;
}

/// The result of an iteration.
#[derive(Clone, Copy)]
pub(super) struct Root<L: Lane> {
    pub(super) t: L,
    pub(super) converged: L::Mask,
    /// A root lies between two places that were tried, but was not found: not that there is none.
    pub(super) not_converged: L::Mask,
}

/// Largest number of steps: more find nothing, for with a bracket each halves it at least.
const MOST_STEPS: usize = 60;
/// The last step may be this many roundings of t. Larger throws tangents about, smaller leaves digits.
const LAST_STEP: f64 = 1e4;
/// Values below this many roundings of their terms are 0. Larger leaves error, smaller waits for luck.
const ROUNDINGS: f64 = 2.0;

/// The t near `start` where `side` times the function rises through 0.
///
/// Newton's step, with the slope taken as rising, always goes towards such a root. The first is no longer than `size`,
/// the length of the searched interval, and each may be twice as long as the one before. Once a root lies between two
/// places that were tried, steps that leave their interval are replaced by halving it.
#[inline(always)]
pub(super) fn rising_root<L: Lane>(start: L, side: L::Real, size: L, surface: &impl Profiled<L>) -> Root<L> {
    let rounding = L::Real::from_f64(ROUNDINGS) * L::Real::EPSILON;
    let zero = start.like(L::Real::ZERO);
    let half = L::Real::from_f64(0.5);
    let (mut low, mut high) = (start.like(-L::Real::LARGEST), start.like(L::Real::LARGEST));
    let mut t = start;
    let mut longest = size;
    let mut converged = zero.less(zero);
    // Numbers that are none end at once, as lanes that found nothing.
    let mut ended = !start.is_finite();
    for _ in 0..MOST_STEPS {
        let Along { value, slope, terms } = surface.along(t);
        let value = value * side;
        let is_below = value.less(zero);
        low = L::select(is_below, low.most(t), low);
        high = L::select(is_below, high, high.least(t));
        let newton = -value / slope.abs();
        // A number that is none (0 / 0) takes the longest step, the comparison being false.
        let bounded = L::select(newton.abs().less(longest), newton, L::select(is_below, longest, -longest));
        longest = longest + longest;
        let next = t + bounded;
        let is_inside = low.less(next) & next.less(high);
        let is_bracketed = is_bracketed(low, high);
        let next = L::select(is_inside | !is_bracketed, next, low * half + high * half);
        let smallest = (t.abs() + size) * L::Real::EPSILON;
        let is_found = (value.abs().at_most(terms * rounding)
            | newton.abs().at_most(smallest)
            | (high - low).abs().at_most(smallest))
            & !ended;
        // The last step takes the error below the rounding, but makes no sense at a tangent.
        let is_moving = !ended & (!is_found | newton.abs().at_most(smallest * L::Real::from_f64(LAST_STEP)));
        t = L::select(is_moving, L::select(is_found, t + newton, next), t);
        converged = converged | is_found;
        ended = ended | is_found | !value.is_finite();
        if ended.all() {
            break;
        }
    }
    Root { t, converged, not_converged: is_bracketed(low, high) & !converged }
}

/// True once both ends have been moved.
#[inline(always)]
fn is_bracketed<L: Lane>(low: L, high: L) -> L::Mask {
    low.greater(low.like(-L::Real::LARGEST)) & high.less(low.like(L::Real::LARGEST))
}
