// SPDX-License-Identifier: GPL-3.0-or-later
// Stands in for bent.wgsl and field.wgsl in the shader of lenses in which no ray bends.

struct Beside_any {
    at: Crossing,
    direction: vec3<real>,
    ratio: real,
    excess: real,
}

fn beside_any(s: u32, before: u32, behind: u32, bases: vec2<real>, p: vec3<real>, d: vec3<real>) -> Beside_any {
    return Beside_any(no_crossing(p, d, MISSED), d, bases.x, bases.y);
}
