// SPDX-License-Identifier: GPL-3.0-or-later
// The kind of number: f32. Everything after this file is written over `real`; real64.wgsl is the same in f64.

alias real = f32;

/// The distance from 1 to the next number.
const EPSILON: real = 1.1920928955078125e-7;
/// The largest finite number.
const LARGEST: real = 3.4028234663852886e38;

/// The leading 12 bits of a number: products of two such parts are exact.
fn leading(x: real) -> real {
    return bitcast<f32>(bitcast<u32>(x) & 0xfffff000u);
}

fn root(x: real) -> real {
    return sqrt(x);
}

fn quotient(a: real, b: real) -> real {
    return a / b;
}
