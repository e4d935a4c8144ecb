// SPDX-License-Identifier: GPL-3.0-or-later
// Aspheres, cylinders and toroids: Newton's method inside of a bracket. The formulas are those of the optics crate:
// surface/asphere.rs, toroid.rs and iterate.rs.
//
// Names that end in _any are written anew for each surface where a lens has a shader of its own.

/// More steps find nothing that these do not.
const MOST_STEPS_any = 60u;
/// The last step may be this many roundings of t.
const LAST_STEP_any: real = 1e4;
/// Values below this many roundings of their terms are 0.
const ROUNDINGS_any: real = 2.0;

/// The surface's function along a ray.
struct Along_any {
    value: real,
    slope: real,
    /// The size of the terms that the value is the sum of.
    terms: real,
}

/// A gradient of the surface's function.
fn gradient_any(s: u32, at: vec3<real>) -> vec3<real> {
    let form = form_any(s);
    if (form.is_toroid) {
        let g = profile_any(s, at.y * at.y);
        let c = form.across;
        return vec3<real>(-(at.x * c * g.weight), at.y * g.slope * (g.sag * c - 1.0), -((at.z * c - 1.0) * g.weight));
    }
    let g = profile_any(s, at.x * at.x + at.y * at.y);
    return vec3<real>(-(at.x * g.slope), -(at.y * g.slope), g.weight);
}

fn along_any(s: u32, p: vec3<real>, d: vec3<real>, t: real) -> Along_any {
    let form = form_any(s);
    let at = p + d * t;
    if (form.is_toroid) {
        let c = form.across;
        let g = profile_any(s, at.y * at.y);
        let half = 0.5 * c;
        let bent = (at.x * at.x + at.z * at.z) * half;
        let normal =
            vec3<real>(-(at.x * c * g.weight), at.y * g.slope * (g.sag * c - 1.0), -((at.z * c - 1.0) * g.weight));
        return Along_any(
            (at.z - g.sag - (bent - g.sag * g.sag * half)) * g.weight,
            dot(normal, d),
            (abs(at.z) + abs(g.sag) + abs(bent)) * g.weight,
        );
    }
    let g = profile_any(s, at.x * at.x + at.y * at.y);
    return Along_any(
        (at.z - g.sag) * g.weight,
        d.z * g.weight - (at.x * d.x + at.y * d.y) * g.slope,
        (abs(at.z) + abs(g.sag)) * g.weight,
    );
}

/// t where the ray crosses the quadric of a toroid's curvatures at the vertex; 0 where it does not.
fn hit_of_quadric_any(s: u32, p: vec3<real>, d: vec3<real>, side: real) -> real {
    let form = form_any(s);
    let cx = form.across;
    let cy = form.curvature;
    let is_plain = cx == 0.0 || cy == 0.0;
    let cz = (cx + (cy + cy * form.conic)) * select(real(0.5), real(1.0), is_plain);
    let curved = vec3<real>(d.x * cx, d.y * cy, d.z * cz);
    let a = dot(curved, d);
    let b = dot(curved, p) - d.z;
    let c = p.x * p.x * cx + p.y * p.y * cy + p.z * p.z * cz - (p.z + p.z);
    let q = b * b - a * c;
    if (!(q >= 0.0)) {
        return real(0.0);
    }
    let under = root(q) * side - b;
    if (!(abs(c) < abs(under) * (LARGEST * EPSILON))) {
        return real(0.0);
    }
    return quotient(c, under);
}

/// Where a ray meets an asphere, a cylinder or a toroid.
fn meet_iterated_any(s: u32, p: vec3<real>, d: vec3<real>, side: real) -> Crossing {
    let form = form_any(s);
    var start: real = 0.0;
    var is_base_wrong_sheet = false;
    if (form.is_toroid) {
        start = hit_of_quadric_any(s, p, d, side);
    } else {
        let base = meet_conic(form.curvature, form.conic, p, d, side);
        if (base.reason == THROUGH) {
            start = base.t;
        }
        is_base_wrong_sheet = base.reason == WRONG_SHEET;
    }
    let half_size = root(dot(p, p)) + abs(start);
    let size = half_size + half_size;
    var low = -LARGEST;
    var high = LARGEST;
    var t = start;
    var longest = size;
    var converged = false;
    for (var step = 0u; step < MOST_STEPS_any; step = step + 1u) {
        let here = along_any(s, p, d, t);
        let value = here.value * side;
        let steepness = abs(here.slope);
        let is_below = value < 0.0;
        if (is_below) {
            low = max(low, t);
        } else {
            high = min(high, t);
        }
        // A slope of 0 takes the longest step.
        var newton = select(-LARGEST, LARGEST, is_below);
        if (abs(value) < steepness * (LARGEST * EPSILON)) {
            newton = quotient(-value, steepness);
        }
        let bounded = select(select(-longest, longest, is_below), newton, abs(newton) < longest);
        longest = longest + longest;
        var next = t + bounded;
        let is_bracketed = low > -LARGEST && high < LARGEST;
        if (is_bracketed && !(low < next && next < high)) {
            next = low * 0.5 + high * 0.5;
        }
        let smallest = (abs(t) + size) * EPSILON;
        let is_found = abs(value) <= here.terms * (ROUNDINGS_any * EPSILON)
            || abs(newton) <= smallest
            || (is_bracketed && high - low <= smallest);
        if (is_found) {
            converged = true;
            // The last step takes the error below the rounding, but makes no sense at a tangent.
            if (abs(newton) <= smallest * LAST_STEP_any) {
                t = t + newton;
            }
            break;
        }
        if (!(abs(value) <= LARGEST)) {
            break;
        }
        t = next;
    }
    let point = p + d * t;
    let normal = gradient_any(s, point);
    let cosine = dot(normal, d) * side;
    var reason = MISSED;
    if (converged && cosine >= 0.0 && normal.z > 0.0 && abs(t) <= LARGEST) {
        reason = THROUGH;
    } else if (form.is_toroid && converged && normal.z < 0.0) {
        reason = WRONG_SHEET;
    } else if (!form.is_toroid && is_base_wrong_sheet) {
        reason = WRONG_SHEET;
    } else if (!converged && low > -LARGEST && high < LARGEST) {
        reason = NOT_CONVERGED;
    }
    return Crossing(point, normal, dot(normal, normal), cosine * cosine, cosine, t, reason);
}
