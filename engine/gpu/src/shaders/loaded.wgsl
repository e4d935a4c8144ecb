// SPDX-License-Identifier: GPL-3.0-or-later
// The tracer of any lens: surfaces are read from memory. A shader that is written for one lens has this part in other words.

fn form_any(s: u32) -> Form {
    return Form(steps[s].curvature, steps[s].conic, steps[s].across, steps[s].shape == 2u);
}

/// Beyond the rim of the conicoid the sag goes on as c u, so that an iteration may look there and come back.
fn profile_any(s: u32, u: real) -> Profile {
    let c = steps[s].curvature;
    let k = steps[s].conic;
    let even = steps[s].terms;
    let odd = even + steps[s].even;
    let end = odd + steps[s].odd;
    let weight = root(max(-(u * ((1.0 + k) * c * c) - 1.0), real(0.0)));
    let base = quotient(u * c, weight + 1.0);
    var value: real = 0.0;
    var change: real = 0.0;
    for (var i = odd; i > even; i = i - 1u) {
        change = change * u + value;
        value = value * u + numbers[i - 1u];
    }
    var polynomial = value * u;
    var slope = value + change * u;
    if (end > odd) {
        value = real(0.0);
        change = real(0.0);
        for (var i = end; i > odd; i = i - 1u) {
            change = change * u + value;
            value = value * u + numbers[i - 1u];
        }
        let radius = root(u);
        polynomial = polynomial + radius * u * value;
        slope = slope + radius * (value * 1.5 + change * u);
    }
    return Profile(base + polynomial, weight, (slope + slope) * weight + c);
}

/// True if the point lies in the diaphragm's opening. Of `numbers` 0 to 5 are the square of its radius, the square of the
/// apothem, the apothem, the bulge of its blades, and slope and bound of curved blades; the blades follow from 6 on, or cosine and
/// sine of the mask's turn over the radius, and its values.
fn is_open(x: real, y: real, squared: real) -> bool {
    var open = squared <= numbers[0];
    if (job.mask_side != 0u) {
        return open && mask_value(x, y, numbers[6], numbers[7]) > 0.0;
    }
    if (job.blades == 0u || squared <= numbers[1]) {
        return open;
    }
    for (var i = 0u; i < job.blades; i = i + 1u) {
        let along = x * numbers[6u + 2u * i] + y * numbers[7u + 2u * i];
        if (job.is_curved != 0u) {
            open = open && squared * numbers[3] + along * numbers[4] <= numbers[5];
        } else {
            open = open && along <= numbers[2];
        }
    }
    return open;
}

fn axis(s: u32, i: u32) -> vec3<real> {
    let at = steps[s].pose + 3u * i;
    return vec3<real>(numbers[at], numbers[at + 1u], numbers[at + 2u]);
}

/// A place of the surface, or a direction (`moved` 0), in the coordinates of its place on the axis.
fn turned_out(s: u32, v: vec3<real>, moved: real) -> vec3<real> {
    return axis(s, 0u) * v.x + axis(s, 1u) * v.y + axis(s, 2u) * v.z + axis(s, 3u) * moved;
}

/// The same way back.
fn turned_in(s: u32, v: vec3<real>, moved: real) -> vec3<real> {
    let q = v - axis(s, 3u) * moved;
    return vec3<real>(dot(q, axis(s, 0u)), dot(q, axis(s, 1u)), dot(q, axis(s, 2u)));
}

/// Where a ray meets surface s, in its own coordinates, as are the ray's.
fn meet_own(s: u32, p: vec3<real>, d: vec3<real>) -> Crossing {
    if (steps[s].shape == 0u) {
        return meet_conic(steps[s].curvature, steps[s].conic, p, d, steps[s].side);
    }
    return meet_iterated_any(s, p, d, steps[s].side);
}

/// The same of a ray in the coordinates of the surface's place on the axis.
fn meet_any(s: u32, p: vec3<real>, d: vec3<real>) -> Crossing {
    var q = p;
    var e = d;
    if ((steps[s].flags & IS_POSED) != 0u) {
        q = turned_in(s, p, real(1.0));
        e = turned_in(s, d, real(0.0));
    }
    var along: real = 0.0;
    if ((steps[s].flags & IS_FAR) != 0u) {
        along = -dot(q, e);
        q = q + e * along;
    }
    var at = meet_own(s, q, e);
    at.t = at.t + along;
    return at;
}

fn outside_any(s: u32, place: vec3<real>) -> vec3<real> {
    if ((steps[s].flags & IS_POSED) != 0u) {
        return turned_out(s, place, real(1.0));
    }
    return place;
}

fn trace_lens(start: vec3<real>, along: vec3<real>, wavelength: u32) -> Flight {
    var p = start;
    var d = along;
    for (var s = 0u; s < job.steps; s = s + 1u) {
        p.z = p.z + steps[s].to_here;
        let flags = steps[s].flags;
        let is_posed = (flags & IS_POSED) != 0u;
        let i = 2u * (s * job.wavelengths + wavelength);
        var ratio = interfaces[i];
        var excess = interfaces[i + 1u];
        var at: Crossing;
        if ((flags & IS_BENT) != 0u) {
            let beside = beside_any(s, steps[s].before, steps[s].behind, vec2<real>(ratio, excess), p, d);
            at = beside.at;
            d = beside.direction;
            if (is_posed) {
                d = turned_in(s, d, real(0.0));
            }
            ratio = beside.ratio;
            excess = beside.excess;
        } else {
            if (is_posed) {
                p = turned_in(s, p, real(1.0));
                d = turned_in(s, d, real(0.0));
            }
            if ((flags & IS_FAR) != 0u) {
                p = carried(p, d);
            }
            at = meet_own(s, p, d);
        }
        let passage = act(
            d,
            at,
            steps[s].side,
            steps[s].clear_squared,
            steps[s].obstruction_squared,
            (flags & IS_STOP) != 0u,
            steps[s].action,
            ratio,
            excess,
        );
        p = passage.point;
        d = passage.direction;
        if (passage.reason != THROUGH) {
            return Flight(p, d, (steps[s].surface << 3u) | passage.reason);
        }
        if (is_posed) {
            p = turned_out(s, p, real(1.0));
            d = turned_out(s, d, real(0.0));
        }
    }
    return Flight(p, d, 0u);
}
