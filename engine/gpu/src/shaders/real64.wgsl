// SPDX-License-Identifier: GPL-3.0-or-later
// The kind of number: f64, for devices that have it. See real32.wgsl.

alias real = f64;

/// The distance from 1 to the next number.
const EPSILON: real = 2.220446049250313e-16;
/// The largest finite number.
const LARGEST: real = 1.7976931348623157e308;

/// The leading 24 bits of a number: products of two such parts are exact.
fn leading(x: real) -> real {
    return f64(f32(x));
}

fn root(x: real) -> real {
    return sqrt(x);
}

fn quotient(a: real, b: real) -> real {
    return a / b;
}
