// SPDX-License-Identifier: GPL-3.0-or-later
// The field of a medium whose index changes from place to place. It lies in `numbers` from f on: how many rows, how many numbers a row,
// the vertex of the surface that the medium follows, where z is 0 behind it, that surface's axes x, y, z and vertex, the length of a
// step in t, how many steps at most; then the rows, one for each power of r², each by powers of z.

const FIELD_POSE = 4u;
const FIELD_STEP = 16u;
const FIELD_MOST = 17u;
const FIELD_ROWS = 18u;

/// There is no ray where the index is less than this.
const LEAST_INDEX: real = 0.3;

/// The sum of a field's terms at a place, and its changes with z and with r².
struct FieldSums {
    value: real,
    by_z: real,
    by_square: real,
}

fn field_axis(f: u32, i: u32) -> vec3<real> {
    let at = f + FIELD_POSE + 3u * i;
    return vec3<real>(numbers[at], numbers[at + 1u], numbers[at + 2u]);
}

/// A place in the medium's own coordinates.
fn field_place(f: u32, place: vec3<real>) -> vec3<real> {
    let q = vec3<real>(place.x, place.y, place.z - numbers[f + 2u]) - field_axis(f, 3u);
    return vec3<real>(dot(q, field_axis(f, 0u)), dot(q, field_axis(f, 1u)), dot(q, field_axis(f, 2u)) - numbers[f + 3u]);
}

fn field_sums(f: u32, p: vec3<real>) -> FieldSums {
    let square = p.x * p.x + p.y * p.y;
    let length = u32(numbers[f + 1u]);
    var sums = FieldSums(real(0.0), real(0.0), real(0.0));
    for (var row = u32(numbers[f]); row > 0u; row = row - 1u) {
        let first = f + FIELD_ROWS + (row - 1u) * length;
        var value: real = 0.0;
        var by_z: real = 0.0;
        for (var i = length; i > 0u; i = i - 1u) {
            by_z = by_z * p.z + value;
            value = value * p.z + numbers[first + i - 1u];
        }
        sums.by_square = sums.by_square * square + sums.value;
        sums.value = sums.value * square + value;
        sums.by_z = sums.by_z * square + by_z;
    }
    return sums;
}

fn field_index(f: u32, place: vec3<real>, base: real) -> real {
    return max(base + field_sums(f, field_place(f, place)).value, LEAST_INDEX);
}

/// n ∇n.
fn field_pull(f: u32, place: vec3<real>, base: real) -> vec3<real> {
    let p = field_place(f, place);
    let sums = field_sums(f, p);
    let index = max(base + sums.value, LEAST_INDEX);
    let across = index * (sums.by_square + sums.by_square);
    let along = index * sums.by_z;
    return field_axis(f, 0u) * (p.x * across) + field_axis(f, 1u) * (p.y * across) + field_axis(f, 2u) * along;
}
