// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces beside a medium whose index changes from place to place: rays bend on their way to them. The formulas are those of the
// optics crate: trace/gradient.rs.
//
// Names that end in _any are written anew for each surface where a lens has a shader of its own.

/// A ray on its way: where it is, and dR/dt of length n.
struct Bending_any {
    at: vec3<real>,
    pace: vec3<real>,
}

/// The ray before a surface, which it hits going straight on; or a ray that does not come so far.
struct Arrival_any {
    at: vec3<real>,
    direction: vec3<real>,
    arrives: bool,
}

/// Each mends the last step as Newton's method does.
const LANDINGS_any = 4u;

/// A step of `length` in t.
fn after_any(f: u32, base: real, from_here: Bending_any, length: real) -> Bending_any {
    let at = from_here.at;
    let pace = from_here.pace;
    let a = field_pull(f, at, base) * length;
    let b = field_pull(f, at + pace * (length * 0.5) + a * (length * 0.125), base) * length;
    let c = field_pull(f, at + pace * length + b * (length * 0.5), base) * length;
    let sixth: real = 0.16666666666666666;
    return Bending_any(at + (pace + (a + b * 2.0) * sixth) * length, pace + (a + b * 4.0 + c) * sixth);
}

fn arrive_any(s: u32, f: u32, base: real, p: vec3<real>, d: vec3<real>) -> Arrival_any {
    let length = numbers[f + FIELD_STEP];
    let most = u32(numbers[f + FIELD_MOST]);
    var here = Bending_any(p, d * field_index(f, p, base));
    // Where the last step begins, how long it is, and how often it was mended.
    var begin = here;
    var t: real = 0.0;
    var landings = 0u;
    var is_near = false;
    for (var step = 0u; step < most && landings < LANDINGS_any; step = step + 1u) {
        let at = meet_any(s, here.at, here.pace * quotient(real(1.0), root(dot(here.pace, here.pace))));
        let index = field_index(f, here.at, base);
        if (!is_near) {
            begin = here;
            t = real(0.0);
            is_near = at.reason == THROUGH && at.t <= length * index;
        }
        if (is_near) {
            t = t + quotient(at.t, index);
            landings = landings + 1u;
        } else {
            t = length;
        }
        here = after_any(f, base, begin, t);
    }
    let direction = here.pace * quotient(real(1.0), root(dot(here.pace, here.pace)));
    return Arrival_any(here.at, direction, landings == LANDINGS_any);
}

/// A ray at a surface beside a gradient: the crossing in the surface's coordinates, the ray's direction in those of its place on the
/// axis, and the interface there.
struct Beside_any {
    at: Crossing,
    direction: vec3<real>,
    ratio: real,
    excess: real,
}

/// `before` and `behind` are where the media's fields begin in `numbers`, 0 where they are none; `bases` the indices without them.
fn beside_any(s: u32, before: u32, behind: u32, bases: vec2<real>, p: vec3<real>, d: vec3<real>) -> Beside_any {
    var arrival = Arrival_any(p, d, true);
    if (before != 0u) {
        arrival = arrive_any(s, before, bases.x, p, d);
    }
    var at = meet_any(s, arrival.at, arrival.direction);
    if (!arrival.arrives && at.reason == THROUGH) {
        at.reason = MISSED;
    }
    let place = outside_any(s, at.point);
    var from_index = bases.x;
    var to_index = bases.y;
    if (before != 0u) {
        from_index = field_index(before, place, bases.x);
    }
    if (behind != 0u) {
        to_index = field_index(behind, place, bases.y);
    }
    let excess = quotient((from_index - to_index) * (from_index + to_index), to_index * to_index);
    return Beside_any(at, arrival.direction, quotient(from_index, to_index), excess);
}
