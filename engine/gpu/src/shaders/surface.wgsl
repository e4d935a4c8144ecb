// SPDX-License-Identifier: GPL-3.0-or-later
// One surface: where a ray meets it, the rims, the new direction. The formulas are those of the optics crate: surface/conic.rs,
// interface.rs and trace/step.rs, where they are explained. Lengths in mm, directions of unit length.
//
// Written so that no number that is none comes about: a device need not know any.

/// What became of a ray; the numbers are those of fate.rs in the optics crate.
const THROUGH = 0u;
const MISSED = 1u;
const WRONG_SHEET = 2u;
const OUTSIDE_APERTURE = 3u;
const OBSTRUCTED = 4u;
const BLADE_STOP = 5u;
const TOTAL_INTERNAL_REFLECTION = 6u;
const NOT_CONVERGED = 7u;

/// What a surface does to the direction.
const REFRACT = 0u;
const PASS = 1u;
const REFLECT = 2u;

/// Below this part of B², the discriminant is formed again without the rounding of its products.
const CANCELLED: real = 1e-2;
/// Conic constants of a larger size cost digits, which one step of Newton's method brings back.
const ECCENTRIC: real = 16.0;
/// Where w² is larger than this, w is good to a rounding or two from r.
const FAR_FROM_THE_END: real = 0.002;
/// Where cos² i is larger than this, N · D is good to some roundings.
const GRAZING: real = 1e-2;
/// Below this part of (m cos i)², the radicand of Snell's law is formed in factors.
const NEAR_CRITICAL: real = 1e-2;

/// Where a ray meets a surface, in its own coordinates.
struct Crossing {
    point: vec3<real>,
    /// Not of unit length.
    normal: vec3<real>,
    /// |N|².
    normal_squared: real,
    /// (N · D)².
    cosine_squared: real,
    /// |N · D|.
    cosine: real,
    /// Along the ray from its origin.
    t: real,
    /// THROUGH where the ray meets the surface, or why it does not.
    reason: u32,
}

/// A ray behind a surface, seen from the surface's vertex.
struct Passage {
    point: vec3<real>,
    direction: vec3<real>,
    /// THROUGH, or why it got no farther.
    reason: u32,
}

fn no_crossing(p: vec3<real>, d: vec3<real>, reason: u32) -> Crossing {
    return Crossing(p, d, real(1.0), real(1.0), real(1.0), real(0.0), reason);
}

/// a b − c d with the error of one rounding or two. Products of parts are exact, so that it matters not whether they are fused.
fn difference_of_products(a: real, b: real, c: real, d: real) -> real {
    let ah = leading(a);
    let bh = leading(b);
    let ch = leading(c);
    let dh = leading(d);
    let al = a - ah;
    let bl = b - bh;
    let cl = c - ch;
    let dl = d - dh;
    return (ah * bh - ch * dh) + ((ah * bl - ch * dl) + (al * bh - cl * dh)) + (al * bl - cl * dl);
}

/// A plane, sphere or conicoid of revolution of curvature c in 1/mm and conic constant k.
fn meet_conic(c: real, k: real, p: vec3<real>, d: vec3<real>, side: real) -> Crossing {
    var a = c;
    var along = dot(p, d);
    var across = dot(p, p);
    if (k != 0.0) {
        a = (d.z * d.z * k + 1.0) * c;
        along = along + p.z * d.z * k;
        across = across + p.z * p.z * k;
    }
    let b = along * c - d.z;
    let cc = across * c - (p.z + p.z);
    let b_squared = b * b;
    var q = b_squared - a * cc;
    var over = cc;
    var under: real = 1.0;
    var cosine: real = 0.0;
    if (q > b_squared * CANCELLED && b * side < 0.0) {
        cosine = root(q);
        under = cosine * side - b;
    } else {
        // Products or terms may cancel.
        if (q < b_squared * CANCELLED) {
            q = difference_of_products(b, b, a, cc);
        }
        if (!(q >= 0.0)) {
            return no_crossing(p, d, MISSED);
        }
        cosine = root(q);
        let root = cosine * side;
        // Where q is 0, perhaps because it is too small a number, C and B may be rounding alone: B / A is not.
        if (b * side < 0.0 && q > 0.0) {
            under = root - b;
        } else {
            over = -b - root;
            under = a;
        }
    }
    // A quotient that is too large is a miss.
    if (!(abs(over) < abs(under) * (LARGEST * EPSILON))) {
        return no_crossing(p, d, MISSED);
    }
    let t = quotient(over, under);
    let point = p + d * t;
    let normal = vec3<real>(point.x * -c, point.y * -c, -(point.z * (c + k * c) - 1.0));
    var normal_squared: real = 1.0;
    if (k != 0.0) {
        normal_squared = dot(normal, normal);
    }
    let crossing = Crossing(point, normal, normal_squared, q, cosine, t, select(WRONG_SHEET, THROUGH, normal.z >= 0.0));
    if (abs(k) > ECCENTRIC) {
        return polished(c, k, crossing, p, d, side);
    }
    return crossing;
}

/// w² at the distance r from the axis, w = √(1 − (1 + k) c² r²) being N's z there.
fn end_squared(c: real, k: real, at: vec3<real>) -> real {
    return -((at.x * at.x + at.y * at.y) * ((c + k * c) * c) - 1.0);
}

/// A crossing of a strongly eccentric conicoid with the digits that its terms of size |k| have taken.
fn polished(c: real, k: real, at: Crossing, p: vec3<real>, d: vec3<real>, side: real) -> Crossing {
    let w_squared = end_squared(c, k, at.point);
    if (at.reason != THROUGH || !(w_squared > FAR_FROM_THE_END)) {
        return at;
    }
    let w = root(w_squared);
    let normal = vec3<real>(at.point.x * -c, at.point.y * -c, w);
    let slope = dot(normal, d);
    if (!(slope * slope > dot(normal, normal) * GRAZING)) {
        return at;
    }
    let sag = quotient((at.point.x * at.point.x + at.point.y * at.point.y) * c, w + 1.0);
    let t = at.t - quotient((at.point.z - sag) * w, slope);
    let on_ray = p + d * t;
    let new_w = root(max(end_squared(c, k, on_ray), real(0.0)));
    let new_sag = quotient((on_ray.x * on_ray.x + on_ray.y * on_ray.y) * c, new_w + 1.0);
    let point = vec3<real>(on_ray.x, on_ray.y, new_sag);
    let new_normal = vec3<real>(point.x * -c, point.y * -c, new_w);
    let cosine = dot(new_normal, d) * side;
    return Crossing(point, new_normal, dot(new_normal, new_normal), cosine * cosine, cosine, t, THROUGH);
}

/// The ray's point nearest to the vertex: where sources are far away this keeps their digits.
fn carried(p: vec3<real>, d: vec3<real>) -> vec3<real> {
    return p + d * -dot(p, d);
}

/// What a surface does to a ray that has come to it along d, in its own coordinates. Points on a rim pass.
fn act(
    d: vec3<real>,
    at: Crossing,
    side: real,
    clear_squared: real,
    obstruction_squared: real,
    is_stop: bool,
    action: u32,
    ratio: real,
    excess: real,
) -> Passage {
    if (at.reason != THROUGH) {
        return Passage(at.point, d, at.reason);
    }
    let squared = at.point.x * at.point.x + at.point.y * at.point.y;
    if (!(squared <= clear_squared)) {
        return Passage(at.point, d, OUTSIDE_APERTURE);
    }
    if (!(squared >= obstruction_squared)) {
        return Passage(at.point, d, OBSTRUCTED);
    }
    if (is_stop) {
        if (!is_open(at.point.x, at.point.y, squared)) {
            return Passage(at.point, d, BLADE_STOP);
        }
    }
    if (action == REFRACT) {
        let incident_squared = at.cosine_squared * (ratio * ratio);
        let incident = at.cosine * ratio;
        var radicand = incident_squared - at.normal_squared * excess;
        // Into the denser medium nothing is critical.
        if (excess > 0.0 && radicand < incident_squared * NEAR_CRITICAL) {
            let critical = root(at.normal_squared * excess);
            radicand = (incident - critical) * (incident + critical);
        }
        if (!(radicand >= 0.0)) {
            return Passage(at.point, d, TOTAL_INTERNAL_REFLECTION);
        }
        let bend = quotient(excess * side, max(root(radicand) + incident, real(1e-30)));
        return Passage(at.point, d * ratio - at.normal * bend, THROUGH);
    }
    if (action == REFLECT) {
        let twice = quotient(at.cosine * (side + side), at.normal_squared);
        return Passage(at.point, d - at.normal * twice, THROUGH);
    }
    return Passage(at.point, d, THROUGH);
}
