//! Intersection of a ray with one segment of a curve.
//!
//! The segment is looked at along the ray and taken in pieces, eight at a time, a lane each. A piece lies between the planes
//! through its two joints at right angles to the curve; neighbours share a plane to the last bit, so that nothing passes between
//! them. Ribbons are even between joints and face the ray (Nakamaru and Ohno 2002; Woop, Benthin, Wald, Johnson and Tabellion
//! 2014, as Cycles has them); round strands are cones about the line between joints (in the manner of the phantom intersector of
//! Reshetov and Luebke 2018, with the planes instead of its iteration), hit on their way in and on their way out.

use super::LEANS_AWAY;
use crate::scene::curves::{Controls, CurveShape};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use glam::{Vec2, Vec3, Vec3A, Vec4};
use std::ops::Range;

const LANES: usize = 8;
/// Pieces of a round segment at most.
const MOST_PIECES: f32 = 64.0;
/// Even parts of the way from a shape to the next, between which its bends are looked at.
const ON_THE_WAY: u32 = 8;
/// Ribbons are hit from twice their radius away on, as in Embree: nearer ones of other strands would show cuts.
const RIBBON_ROOM: f32 = 2.0;

/// Round pieces reach so many radii over the joint before and the one behind them: two cones do not meet the plane between them in
/// quite the same line, which a ray along the strand passes at some distance. (One side is enough, and overlaps may count twice
/// for light that is let through.)
const OVERLAP: [f32; 2] = [0.005, 0.1];
/// Depth that is added to a hit past the end plane of its piece, as a share of its distance from that plane. Where two pieces overlap, the
/// hit of the piece that owns the place is nearer, in whatever order the pieces are tried.
const OVERLAP_DEPTH: f32 = 0.01;

/// A ray along whose direction curves are looked at.
pub(super) struct RayFrame {
    origin: Vec3A,
    axes: [Vec3A; 3],
}

impl RayFrame {
    /// `direction` has length one.
    pub(super) fn new(origin: Vec3A, direction: Vec3A) -> Self {
        let (x, y) = direction.any_orthonormal_pair();
        // Right-handed: x, y, along the ray.
        let x = if x.cross(y).dot(direction) < 0.0 { -x } else { x };
        Self { origin, axes: [x, y, direction] }
    }

    /// The origin of the ray.
    #[inline(always)]
    pub(super) fn origin(&self) -> Vec3A {
        self.origin
    }

    /// Unit vectors: two across the ray, and its direction.
    #[inline(always)]
    pub(super) fn axes(&self) -> [Vec3A; 3] {
        self.axes
    }

    /// The largest absolute coordinate of the origin.
    #[inline(always)]
    pub(super) fn reach(&self) -> f32 {
        self.origin.abs().max_element()
    }

    /// A key in this frame. (Arrays are not mapped here: their closures would not be inlined.)
    #[inline(always)]
    fn seen(&self, key: Vec4) -> Vec4 {
        let from = Vec3A::from_vec4(key) - self.origin;
        let [x, y, z] = self.axes;
        Vec4::new(x.dot(from), y.dot(from), z.dot(from), key.w)
    }
}

/// A hit on a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CurveMet {
    pub(super) t: f32,
    /// Place along the segment, 0 to 1; beyond that on a round end, by the part of the normal along the strand.
    pub(super) u: f32,
    /// Place across the segment, -1 to 1: the sine of the angle between the normal and the view, to the side of the cross product of the
    /// strand's direction and the view. [`LEANS_AWAY`] more where the normal leans as it does not of a cylinder.
    pub(super) v: f32,
}

/// The hits of a ray on a segment: on the way in, and on the way out.
pub(super) type BothMet = [Option<CurveMet>; 2];

/// The division of a segment into pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SegmentCut {
    Ribbon(u16),
    Round(u16),
    /// A straight cone with round ends.
    Straight,
}

impl SegmentCut {
    /// The division of a segment that has these shapes one after the other: fine enough for each.
    pub(super) fn new(shape: CurveShape, shapes: &[Controls]) -> Self {
        match shape {
            CurveShape::Ribbon { pieces } => Self::Ribbon(pieces.max(1)),
            CurveShape::Thick => {
                // A strand may bend most on its way from one shape to the next.
                let on_the_way = shapes
                    .windows(2)
                    .flat_map(|pair| (1..ON_THE_WAY).map(|i| pair[0].towards(&pair[1], i as f32 / ON_THE_WAY as f32)));
                let pieces = shapes.iter().copied().chain(on_the_way).map(|controls| round_pieces(&controls)).max();
                Self::Round(pieces.unwrap_or(LANES as u16))
            }
            CurveShape::ThickLinear => Self::Straight,
        }
    }

    /// Pieces of a segment.
    pub(super) fn pieces(self) -> u16 {
        match self {
            Self::Ribbon(pieces) | Self::Round(pieces) => pieces,
            Self::Straight => 1,
        }
    }

    /// Adds to `balls` the balls about the joints of some pieces, in their order, each with the room around it that the pieces may need:
    /// they lie between neighbouring balls, and the curve does.
    pub(super) fn add_balls(self, controls: &Controls, part: Range<u16>, balls: &mut Vec<Vec4>) {
        let pieces = self.pieces();
        // The edges between round pieces stick out.
        let reach = if matches!(self, Self::Round(_)) { 1.04 } else { 1.0 };
        // As far as a curve is from the chord of a piece: an eighth of the second difference. A ribbon's pieces end at right angles to the curve
        // and not to their chords: at the part s of a piece the ray is s (1 - s) ΔP·ΔT / |T| past the chord's place there, along the curve's
        // direction T; up to a quarter of the second difference, and within the radius across it.
        let [_, _, c, d] = if self == Self::Straight { [Vec4::ZERO; 4] } else { controls.coefficients() };
        let second = (2.0 * c).truncate().length().max((2.0 * c + 6.0 * d).truncate().length());
        let bend = second / (8.0 * f32::from(pieces) * f32::from(pieces));
        balls.extend((part.start..=part.end).map(|joint| {
            let ball = match joint {
                0 => controls.0[1],
                joint if joint == pieces => controls.0[2],
                joint => controls.at(f32::from(joint) / f32::from(pieces)),
            };
            let radius = ball.w.abs();
            let across_and_along = if matches!(self, Self::Ribbon(_)) { radius.hypot(2.0 * bend) } else { 0.0 };
            ball.with_w((radius * reach + bend).max(across_and_along))
        }));
    }
}

/// Number of pieces of a round segment: no chord is a fiftieth of the radius from the curve, nor are two more than a quarter of a radian
/// apart.
fn round_pieces(controls: &Controls) -> u16 {
    let [_, b, c, d] = controls.coefficients();
    let bend = (2.0 * c).truncate().length().max((2.0 * c + 6.0 * d).truncate().length());
    let radius = controls.0[1].w.max(controls.0[2].w).max(f32::MIN_POSITIVE);
    let length = b.truncate().length().min((b + 2.0 * c + 3.0 * d).truncate().length()).max(f32::MIN_POSITIVE);
    let pieces = (bend / (8.0 * 0.02 * radius)).sqrt().max(4.0 * bend / length).ceil();
    // What is not a number becomes the least.
    pieces.clamp(LANES as f32, MOST_PIECES) as u16
}

/// The nearest places before `t_max` where a part of a segment is hit, some of its pieces.
#[inline(always)]
pub(super) fn meet<S: Simd>(
    simd: S,
    gaze: &RayFrame,
    controls: [Vec4; 4],
    (cut, part): (SegmentCut, &Range<u16>),
    t_max: f32,
) -> BothMet {
    let [a, b, c, d] = controls;
    let seen = Controls([gaze.seen(a), gaze.seen(b), gaze.seen(c), gaze.seen(d)]);
    // The capsule of a part is tighter than the segment's polygon.
    let is_whole = part.len() == usize::from(cut.pieces());
    if is_whole && !matches!(cut, SegmentCut::Straight) && passes_by(&seen) {
        return [None; 2];
    }
    match cut {
        SegmentCut::Ribbon(pieces) => in_pieces::<S, false>(simd, &seen, usize::from(pieces), part, t_max),
        SegmentCut::Round(pieces) => in_pieces::<S, true>(simd, &seen, usize::from(pieces), part, t_max),
        SegmentCut::Straight => straight(&seen, t_max),
    }
}

/// True if the ray is farther from the line between the segment's ends, as seen along the ray, than the curve bends away from that line.
#[inline(always)]
fn passes_by(seen: &Controls) -> bool {
    let [start, first, second, end] = seen.hull();
    let chord = (end - start).truncate().truncate();
    let aside = |place: Vec4| chord.perp_dot((place - start).truncate().truncate());
    let ray = aside(Vec4::ZERO);
    let (first_aside, second_aside) = (aside(first), aside(second));
    let radius = start.w.abs().max(first.w.abs()).max(second.w.abs()).max(end.w.abs());
    // With room for where round pieces meet, and for rounding.
    let room = chord.length() * (1.05 * radius + 1e-6 * (start.abs() + end.abs()).truncate().max_element());
    ray > first_aside.max(second_aside).max(0.0) + room || ray < first_aside.min(second_aside).min(0.0) - room
}

/// Joints at one end of eight pieces: place, radius, and the curve's direction.
struct Joints<S: Simd> {
    place: [f32x8<S>; 4],
    direction: [f32x8<S>; 3],
}

#[inline(always)]
fn in_pieces<S: Simd, const ROUND: bool>(
    simd: S,
    seen: &Controls,
    pieces: usize,
    part: &Range<u16>,
    t_max: f32,
) -> BothMet {
    let part = usize::from(part.start)..usize::from(part.end);
    let coefficients = seen.coefficients();
    let step = 1.0 / pieces as f32;
    let mut both = [None; 2];
    for first in part.clone().step_by(LANES) {
        let which = (first, (part.end - first).min(LANES), step);
        let before = Joints::new(simd, seen, &coefficients, pieces, first);
        let behind = Joints::new(simd, seen, &coefficients, pieces, first + 1);
        if ROUND {
            round(simd, (&before, &behind), t_max, which, &mut both);
        } else {
            flat(simd, (&before, &behind), t_max, which, &mut both[0]);
        }
    }
    if ROUND { both.map(|met| met.map(|met| on_curve(&coefficients, met))) } else { both }
}

/// The place of the curve that is nearest to the hit of a piece, instead of that of the chord.
fn on_curve([a, b, c, d]: &[Vec4; 4], met: CurveMet) -> CurveMet {
    let at = |u: f32| *a + u * (*b + u * (*c + u * *d));
    let slope = |u: f32| (*b + u * (2.0 * *c + 3.0 * u * *d)).truncate();
    let from = |u: f32| Vec3::new(0.0, 0.0, met.t) - at(u).truncate();
    let along = slope(met.u);
    let u = (met.u + from(met.u).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let (along, radius) = (slope(u), at(u).w);
    let v = (from(u).y * along.x - from(u).x * along.y) / (along.truncate().length() * radius);
    if (u + v).is_finite() { CurveMet { u, v: v.clamp(-1.0, 1.0), ..met } } else { met }
}

/// The hits in the lanes.
struct Lanes<S: Simd> {
    hit: u32,
    t: f32x8<S>,
    /// Place along the piece.
    s: f32x8<S>,
    v: f32x8<S>,
}

impl<S: Simd> Lanes<S> {
    /// Keeps a hit that is nearer than `nearest`; arguments: the first piece's number, their count, and the part of the segment that each
    /// is.
    #[inline(always)]
    fn keep_nearest(self, (first, count, step): (usize, usize, f32), nearest: &mut Option<CurveMet>) {
        let mut lanes = self.hit & ((1 << count) - 1);
        if lanes == 0 {
            return;
        }
        let (t, s, v) = (self.t.to_array(), self.s.to_array(), self.v.to_array());
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & (LANES - 1);
            lanes &= lanes - 1;
            let is_sound = (s[lane] + v[lane]).is_finite();
            if is_sound && nearest.is_none_or(|met| t[lane] < met.t) {
                let u = ((first + lane) as f32 + s[lane].clamp(0.0, 1.0)) * step;
                *nearest = Some(CurveMet { t: t[lane], u: u.min(1.0), v: v[lane].clamp(-1.0, 1.0) });
            }
        }
    }
}

impl<S: Simd> Joints<S> {
    /// The eight joints from number `first` on. One joint has the same bits whichever eight it is among, and at either side of the
    /// key between two segments.
    #[inline(always)]
    fn new(simd: S, seen: &Controls, [a, b, c, d]: &[Vec4; 4], pieces: usize, first: usize) -> Self {
        let [_, before_end, end, behind_end] = seen.0;
        let end_slope = 0.5 * (behind_end - before_end);
        let number = f32x8::load_array(simd, std::array::from_fn(|lane| lane as f32)) + first as f32;
        let is_end = number.simd_ge(pieces as f32);
        let u = number * (1.0 / pieces as f32);
        let all = |x: f32| f32x8::splat(simd, x);
        let mut place = [all(0.0); 4];
        for axis in 0..4 {
            let within = u * (u * (u * d[axis] + c[axis]) + b[axis]) + a[axis];
            place[axis] = is_end.select(all(end[axis]), within);
        }
        let mut direction = [all(0.0); 3];
        for axis in 0..3 {
            let within = u * (u * (3.0 * d[axis]) + 2.0 * c[axis]) + b[axis];
            direction[axis] = is_end.select(all(end_slope[axis]), within);
        }
        Self { place, direction }
    }
}

/// Ribbons that face the ray.
#[inline(always)]
fn flat<S: Simd>(
    simd: S,
    (before, behind): (&Joints<S>, &Joints<S>),
    t_max: f32,
    which: (usize, usize, f32),
    nearest: &mut Option<CurveMet>,
) {
    let ([x0, y0, z0, r0], [tx0, ty0, _]) = (before.place, before.direction);
    let ([x1, y1, z1, r1], [tx1, ty1, _]) = (behind.place, behind.direction);
    let all = |x: f32| f32x8::splat(simd, x);
    // How far ahead of the joint the ray passes, along the curve there.
    let ahead0 = all(0.0) - (x0 * tx0 + y0 * ty0);
    let ahead1 = all(0.0) - (x1 * tx1 + y1 * ty1);
    let between = ahead0.simd_ge(0.0) & ahead1.simd_lt(0.0);
    if !between.any_true() {
        return;
    }
    let s = ahead0 / (ahead0 - ahead1);
    let (x, y, z, r) = (x0 + (x1 - x0) * s, y0 + (y1 - y0) * s, z0 + (z1 - z0) * s, r0 + (r1 - r0) * s);
    let (tx, ty) = (tx0 + (tx1 - tx0) * s, ty0 + (ty1 - ty0) * s);
    let aside = x * ty - y * tx;
    let wide = r * (tx * tx + ty * ty).sqrt();
    let within = aside.simd_le(wide) & aside.simd_ge(all(0.0) - wide) & wide.simd_gt(0.0);
    let hit = between & within & z.simd_gt(r * RIBBON_ROOM) & z.simd_lt(t_max);
    Lanes { hit: hit.to_bitmask() as u32, t: z, s, v: aside / wide }.keep_nearest(which, nearest);
}

/// Cones about the lines between joints.
#[inline(always)]
fn round<S: Simd>(
    simd: S,
    (before, behind): (&Joints<S>, &Joints<S>),
    t_max: f32,
    which: (usize, usize, f32),
    both: &mut BothMet,
) {
    let ([x0, y0, z0, r0], [tx0, ty0, tz0]) = (before.place, before.direction);
    let ([x1, y1, z1, r1], [tx1, ty1, tz1]) = (behind.place, behind.direction);
    let all = |x: f32| f32x8::splat(simd, x);
    let (ax, ay, az, ar) = (x1 - x0, y1 - y0, z1 - z0, r1 - r0);
    let flat2 = ax * ax + ay * ay;
    let length2 = flat2 + az * az;
    // From where the ray and the axis are nearest: nothing large cancels.
    let s = all(0.0) - (x0 * ax + y0 * ay) / flat2;
    let (z, r) = (z0 + az * s, r0 + ar * s);
    let aside = x0 * ay - y0 * ax;
    let wider = ar * az / length2;
    let a = flat2 / length2 - wider * wider;
    let b = all(0.0) - r * wider;
    let c = aside * aside / flat2 - r * r;
    let inside = b * b - a * c;
    let crosses = inside.simd_ge(0.0);
    if !crosses.any_true() {
        return;
    }
    let root = inside.max(0.0).sqrt();
    let plane0 = x0 * tx0 + y0 * ty0;
    let plane1 = x1 * tx1 + y1 * ty1;
    let length0 = (tx0 * tx0 + ty0 * ty0 + tz0 * tz0).sqrt();
    let length1 = (tx1 * tx1 + ty1 * ty1 + tz1 * tz1).sqrt();
    let (room0, room1) = (length0 * r0 * OVERLAP[0], length1 * r1 * OVERLAP[1]);
    for (root, nearest) in [all(0.0) - root, root].into_iter().zip(both) {
        let tau = (root - b) / a;
        let t = z + tau;
        let s = s + az * tau / length2;
        let radius = r0 + ar * s;
        let before = plane0 - (t - z0) * tz0;
        let behind = (t - z1) * tz1 - plane1;
        let hit = crosses
            & before.simd_le(room0)
            & behind.simd_lt(room1)
            & radius.simd_gt(0.0)
            & t.simd_gt(0.0)
            & t.simd_lt(t_max);
        let v = aside / (flat2.sqrt() * radius);
        let t = t + (before.max(0.0) / length0 + behind.max(0.0) / length1) * OVERLAP_DEPTH;
        Lanes { hit: hit.to_bitmask() as u32, t, s, v }.keep_nearest(which, nearest);
    }
}

/// The hits on the body that a ball sweeps from one key to the other, its radius changing evenly: a cone that touches two balls, and the
/// parts of them outside of it.
#[expect(clippy::too_many_lines, reason = "a kernel")]
fn straight(Controls([before, start, end, behind]): &Controls, t_max: f32) -> BothMet {
    let (start, end) = (*start, *end);
    let axis = (end - start).truncate();
    let length = axis.length();
    let along = axis / length;
    // The view is opposite to the ray, which runs along z: its cross product with the axis, and what is left of it.
    let across = Vec2::new(-along.y, along.x).normalize_or_zero().extend(0.0);
    let up = across.cross(along);
    let mut both: BothMet = [None; 2];
    // By which key the place is, and the normal there.
    let mut offer = |way: usize, t: f32, key: f32, ball: Vec4| {
        if !(t > 0.0 && t < both[way].map_or(t_max, |nearest: CurveMet| nearest.t)) {
            return;
        }
        let place = Vec3::new(0.0, 0.0, t);
        let mut normal = (place - ball.truncate()) / ball.w;
        let mut lengthwise = normal.dot(along);
        let within = key + lengthwise * ball.w / length;
        if !(0.0..=1.0).contains(&within) {
            // Past a key: as its ball has it.
            normal = (place - if within > 0.5 { end } else { start }.truncate()).normalize_or_zero();
            lengthwise = normal.dot(along);
        }
        let key = f32::from(u8::from(within > 0.5));
        let leans_away = (normal.dot(up) < 0.0) != (way == 1);
        let u = if (0.0..=1.0).contains(&within) { within } else { key + lengthwise.clamp(-1.0, 1.0) };
        // Between the keys the normal is taken to be at right angles to the axis, as in Cycles.
        let radial = if (0.0..=1.0).contains(&within) { (1.0 - lengthwise * lengthwise).max(0.0).sqrt() } else { 1.0 };
        let lean = if leans_away { LEANS_AWAY } else { 0.0 };
        let met = CurveMet { t, u, v: (normal.dot(across) / radial).clamp(-1.0, 1.0) + lean };
        if (met.u + met.v).is_finite() {
            both[way] = Some(met);
        }
    };
    // How the balls' radii change along the axis: from 1 on one lies in the other.
    let narrows = (start.w - end.w) / length;
    if narrows.abs() < 1.0 {
        let ring = |ball: Vec4| {
            let along = axis * (ball.w * narrows / length);
            (ball + along.extend(0.0)).with_w(ball.w * (1.0 - narrows * narrows).sqrt())
        };
        for (way, t, s) in cone_between(ring(start), ring(end)).into_iter().enumerate().filter_map(|(way, met)| {
            let (t, s) = met?;
            Some((way, t, s))
        }) {
            // The ball that touches the cone there.
            let ball = start.lerp(end, s);
            offer(way, t, s * (1.0 - f32::EPSILON), ball);
        }
    }
    let next = *behind - end;
    let next_holds = |t: f32| {
        let out = (Vec3::new(0.0, 0.0, t) - end.truncate()).dot(next.truncate());
        next != Vec4::ZERO && out > -next.w * end.w
    };
    for (ball, is_end) in [(start, false), (end, true)] {
        let high = ball.w * ball.w - ball.truncate().truncate().length_squared();
        if high < 0.0 || ball.w <= 0.0 {
            continue;
        }
        for (way, t) in [ball.z - high.sqrt(), ball.z + high.sqrt()].into_iter().enumerate() {
            let outwards = (Vec3::new(0.0, 0.0, t) - ball.truncate()).dot(along) / ball.w;
            // What is within the cone, or the next one, is not on the outside; a ball between two is the first one's.
            let is_outside =
                if is_end { outwards >= narrows && !next_holds(t) } else { outwards <= narrows && *before == start };
            if is_outside {
                offer(way, t, f32::from(u8::from(is_end)), ball);
            }
        }
    }
    both
}

/// Entry and exit of a ray through a cone between two rings: distance, and place between the rings, as [`round`] gives them.
fn cone_between(start: Vec4, end: Vec4) -> [Option<(f32, f32)>; 2] {
    let axis = end - start;
    let flat2 = axis.x * axis.x + axis.y * axis.y;
    let length2 = flat2 + axis.z * axis.z;
    let s = -(start.x * axis.x + start.y * axis.y) / flat2;
    let (z, r) = (start.z + axis.z * s, start.w + axis.w * s);
    let aside = start.x * axis.y - start.y * axis.x;
    let wider = axis.w * axis.z / length2;
    let a = flat2 / length2 - wider * wider;
    let (b, c) = (-r * wider, aside * aside / flat2 - r * r);
    let inside = b * b - a * c;
    [-1.0, 1.0].map(|way| {
        let tau = (way * inside.sqrt() - b) / a;
        let s = s + axis.z * tau / length2;
        let is_there = (0.0..=1.0).contains(&s) && start.w + axis.w * s > 0.0;
        is_there.then_some((z + tau, s))
    })
}
