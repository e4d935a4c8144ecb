//! Perlin's gradient noise in one to four dimensions, with Blender's hash and gradients; about -1 to 1.

use crate::hash::{hash1, hash2, hash3, hash4};
use glam::{Vec2, Vec3A, Vec4};

/// Blender repeats noise beyond this, where single precision has no fractions worth the name.
const PERIOD: f32 = 100_000.0;

/// A coordinate folded into the period. The remainder is slow, and nearly never needed.
#[inline(always)]
fn folded(x: f32) -> f32 {
    if x.abs() < PERIOD { x } else { x % PERIOD + if x.abs() >= 1e6 { 0.5 } else { 0.0 } }
}

/// The cell, the place in it, and the eased place.
#[inline(always)]
fn place(x: f32) -> (i32, f32, f32) {
    let x = folded(x);
    let floor = x.floor();
    let t = x - floor;
    (floor as i32, t, t * t * t * (t * (t * 6.0 - 15.0) + 10.0))
}

#[inline(always)]
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    (1.0 - t) * a + t * b
}

#[inline(always)]
fn negated(value: f32, bit: u32) -> f32 {
    f32::from_bits(value.to_bits() ^ if bit != 0 { 0x8000_0000 } else { 0 })
}

pub(crate) fn noise1(p: f32) -> f32 {
    let (cell, t, eased) = place(p);
    let gradient = |hash: u32, x: f32| negated(1.0 + (hash & 7) as f32, hash & 8) * x;
    let near = gradient(hash1(cell as u32), t);
    let far = gradient(hash1(cell.wrapping_add(1) as u32), t - 1.0);
    finite(lerp(near, far, eased) * 0.25)
}

pub(crate) fn noise2(p: Vec2) -> f32 {
    let ((cx, x, u), (cy, y, v)) = (place(p.x), place(p.y));
    let mut corner = [0.0; 4];
    for (i, value) in corner.iter_mut().enumerate() {
        let (dx, dy) = ((i & 1) as i32, (i >> 1) as i32);
        let (fx, fy) = (x - dx as f32, y - dy as f32);
        let hash = hash2(cx.wrapping_add(dx) as u32, cy.wrapping_add(dy) as u32) & 7;
        let (first, second) = if hash < 4 { (fx, fy) } else { (fy, fx) };
        *value = negated(first, hash & 1) + negated(2.0 * second, hash & 2);
    }
    finite(bilinear(&corner, u, v) * 0.6616)
}

#[inline]
pub(crate) fn noise3(p: Vec3A) -> f32 {
    let ((cx, x, u), (cy, y, v), (cz, z, w)) = (place(p.x), place(p.y), place(p.z));
    let mut corner = [0.0; 8];
    // A loop without branches: the eight corners go through vector registers.
    for (i, value) in corner.iter_mut().enumerate() {
        let (dx, dy, dz) = ((i & 1) as i32, ((i >> 1) & 1) as i32, (i >> 2) as i32);
        let (fx, fy, fz) = (x - dx as f32, y - dy as f32, z - dz as f32);
        let hash = hash3(cx.wrapping_add(dx) as u32, cy.wrapping_add(dy) as u32, cz.wrapping_add(dz) as u32) & 15;
        let first = if hash < 8 { fx } else { fy };
        let other = if (hash == 12) | (hash == 14) { fx } else { fz };
        let second = if hash < 4 { fy } else { other };
        *value = negated(first, hash & 1) + negated(second, hash & 2);
    }
    finite(trilinear(&corner, u, v, w) * 0.982)
}

pub(crate) fn noise4(p: Vec4) -> f32 {
    let ((cx, x, u), (cy, y, v), (cz, z, w), (cw, h, s)) = (place(p.x), place(p.y), place(p.z), place(p.w));
    let mut corner = [0.0; 16];
    for (i, value) in corner.iter_mut().enumerate() {
        let (dx, dy, dz, dw) = ((i & 1) as i32, ((i >> 1) & 1) as i32, ((i >> 2) & 1) as i32, (i >> 3) as i32);
        let (fx, fy, fz, fw) = (x - dx as f32, y - dy as f32, z - dz as f32, h - dw as f32);
        let hash = hash4(
            cx.wrapping_add(dx) as u32,
            cy.wrapping_add(dy) as u32,
            cz.wrapping_add(dz) as u32,
            cw.wrapping_add(dw) as u32,
        ) & 31;
        let first = if hash < 24 { fx } else { fy };
        let second = if hash < 16 { fy } else { fz };
        let third = if hash < 8 { fz } else { fw };
        *value = negated(first, hash & 1) + negated(second, hash & 2) + negated(third, hash & 4);
    }
    let (near, far) = corner.split_at(8);
    let side = |half: &[f32]| trilinear(half.try_into().expect("eight corners"), u, v, w);
    finite(lerp(side(near), side(far), s) * 0.8344)
}

#[inline(always)]
fn bilinear(corner: &[f32; 4], u: f32, v: f32) -> f32 {
    lerp(lerp(corner[0], corner[1], u), lerp(corner[2], corner[3], u), v)
}

#[inline(always)]
fn trilinear(corner: &[f32; 8], u: f32, v: f32, w: f32) -> f32 {
    let [a, b, c, d, e, f, g, h] = *corner;
    lerp(bilinear(&[a, b, c, d], u, v), bilinear(&[e, f, g, h], u, v), w)
}

/// Coordinates that are no numbers give no noise.
#[inline(always)]
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
