// SPDX-License-Identifier: GPL-3.0-or-later
// What the host uploads, and what the shape of an iterated surface is given as.

/// One surface on the way of the rays.
struct Step {
    curvature: real,
    conic: real,
    /// Added to z when the ray leaves the surface before.
    to_here: real,
    /// sign(N · D) of the crossing that is meant.
    side: real,
    clear_squared: real,
    obstruction_squared: real,
    /// Curvature of a toroid in the x-z plane.
    across: real,
    /// 0: conicoid, 1: asphere, 2: toroid.
    shape: u32,
    action: u32,
    /// IS_STOP, IS_FAR, IS_POSED, IS_BENT.
    flags: u32,
    /// Its number from the scene.
    surface: u32,
    /// Offset in `numbers` of the terms of its polynomial: even powers, then odd.
    terms: u32,
    even: u32,
    odd: u32,
    /// Offset in `numbers` of its pose: axes x, y, z, then the vertex.
    pose: u32,
    /// Offsets in `numbers` of the gradients before and behind it (field.wgsl); 0 for a medium without one.
    before: u32,
    behind: u32,
}

const IS_STOP = 1u;
const IS_FAR = 2u;
const IS_POSED = 4u;
/// A medium beside it is a gradient.
const IS_BENT = 8u;

/// A ray: before, seen from the first vertex on its way; after, from the last.
struct Ray {
    x: real,
    y: real,
    z: real,
    dx: real,
    dy: real,
    dz: real,
    /// Before: the number of its wavelength. After: 0, or 8 times the number of the surface that ended it and the reason.
    word: u32,
    spare: u32,
}

struct Job {
    rays: u32,
    steps: u32,
    wavelengths: u32,
    /// Blades of the diaphragm.
    blades: u32,
    /// Seed of the rays of a timed run.
    seed: u32,
    rays_each: u32,
    /// 1 if the blades are curved.
    is_curved: u32,
    /// Values a side of the mask in the diaphragm; 0 without one.
    mask_side: u32,
    /// Of a timed run: half width and half height of the film, the film's z and the pupil's z from the first vertex on the way.
    film: vec4<f32>,
    /// Half of the side of the square on the pupil, and the wavelength's number.
    pupil: vec4<f32>,
}

@group(0) @binding(0) var<storage, read> steps: array<Step>;
/// The diaphragm (see `is_open`), its blades or mask, then terms and poses.
@group(0) @binding(1) var<storage, read> numbers: array<real>;
/// Ratio and excess by surface and wavelength; beside a gradient the indices before and behind without it.
@group(0) @binding(2) var<storage, read> interfaces: array<real>;
@group(0) @binding(3) var<uniform> job: Job;
@group(0) @binding(4) var<storage, read_write> rays: array<Ray>;

/// The value of the mask between the middles of its values, brightness less a half, at a point in mm.
fn mask_value(x: real, y: real, cosine: real, sine: real) -> real {
    let side = real(f32(job.mask_side));
    let last = side - 1.0;
    let across = clamp(0.5 * (cosine * x + sine * y + 1.0) * side - 0.5, real(0.0), last);
    let up = clamp(0.5 * (cosine * y - sine * x + 1.0) * side - 0.5, real(0.0), last);
    let left = min(u32(across), job.mask_side - 1u);
    let below = min(u32(up), job.mask_side - 1u);
    let right = min(left + 1u, job.mask_side - 1u);
    let above = min(below + 1u, job.mask_side - 1u);
    let u = across - real(left);
    let v = up - real(below);
    let low = numbers[MASK + below * job.mask_side + left] * (1.0 - u) + numbers[MASK + below * job.mask_side + right] * u;
    let high = numbers[MASK + above * job.mask_side + left] * (1.0 - u) + numbers[MASK + above * job.mask_side + right] * u;
    return low * (1.0 - v) + high * v;
}

/// Where in `numbers` the mask's values begin.
const MASK = 8u;

/// The profile of an asphere or toroid at the square of the distance from the axis.
struct Profile {
    sag: real,
    /// Cosine of the conicoid's slope; 0 where it has ended.
    weight: real,
    /// 2 w dz/du.
    slope: real,
}

/// The plain numbers of an asphere or toroid.
struct Form {
    curvature: real,
    conic: real,
    across: real,
    is_toroid: bool,
}

/// A ray behind the lens, or where it ended.
struct Flight {
    point: vec3<real>,
    direction: vec3<real>,
    /// 0, or 8 times the number of the surface that ended it and the reason.
    fate: u32,
}
