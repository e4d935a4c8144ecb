//! Perlin's gradient noise in one to four dimensions, with Blender's hash and gradients; about -1 to 1.

use super::Perlin;
use crate::hash::{hash1, hash2, hash3, hash4};
use wide::{f32x4, f32x8, i32x8, u32x8};

/// Blender repeats noise beyond this, where single precision has no fractions worth the name.
pub(super) const PERIOD: f32 = 100_000.0;

/// A coordinate folded into the period. The remainder is slow, and nearly never needed.
#[inline(always)]
pub(super) fn folded(x: f32) -> f32 {
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

/// An axis of a lattice cell: its two corners' numbers, and the way from each to the place.
struct Sides {
    cells: [u32; 2],
    ways: [u32; 2],
}

impl Sides {
    #[inline(always)]
    fn new(cell: i32, place: f32) -> Self {
        let ways = [place.to_bits(), (place - 1.0).to_bits()];
        Self { cells: [cell as u32, cell.wrapping_add(1) as u32], ways }
    }
}

/// Eight corners, of which corner i lies at the bits of i: one of two values for each, by a bit.
#[inline(always)]
fn by_bit<const BIT: usize>([near, far]: [u32; 2]) -> u32x8 {
    const ALL: u32 = u32::MAX;
    // Constants: built out of memory, the corners would wait for it.
    let mask = match BIT {
        0 => u32x8::new([0, ALL, 0, ALL, 0, ALL, 0, ALL]),
        1 => u32x8::new([0, 0, ALL, ALL, 0, 0, ALL, ALL]),
        _ => u32x8::new([0, 0, 0, 0, ALL, ALL, ALL, ALL]),
    };
    let (near, far) = (u32x8::splat(near), u32x8::splat(far));
    near ^ (mask & (far ^ near))
}

/// All bits set where one bit of a hash is.
#[inline(always)]
pub(super) fn where_set(hash: u32x8, bit: u32) -> f32x8 {
    let lifted: i32x8 = bytemuck::cast(hash << u32x8::splat(31 - bit));
    bytemuck::cast(lifted >> i32x8::splat(31))
}

/// The sign turned where one bit of a hash is set.
#[inline(always)]
pub(super) fn turned(value: f32x8, hash: u32x8, bit: u32) -> f32x8 {
    let bits: u32x8 = bytemuck::cast(value);
    bytemuck::cast(bits ^ ((hash << u32x8::splat(31 - bit)) & u32x8::splat(0x8000_0000)))
}

/// The gradients of eight corners of cells times the ways from them.
#[inline(always)]
pub(super) fn slopes3(hash: u32x8, x: f32x8, y: f32x8, z: f32x8) -> f32x8 {
    // The four low bits choose a gradient: below 8 x leads, else y; with it y below 4, x at 12 and 14, else z.
    let (eight, four) = (where_set(hash, 3), where_set(hash, 2));
    let leads = eight & four & !where_set(hash, 0);
    let (first, rest) = (eight.select(y, x), leads.select(x, z));
    let second = (eight | four).select(rest, y);
    turned(first, hash, 0) + turned(second, hash, 1)
}

/// [`slopes3`] with a fourth axis.
#[inline(always)]
pub(super) fn slopes4(hash: u32x8, [x, y, z, w]: [f32x8; 4]) -> f32x8 {
    // The five low bits: below 24 x leads, else y; then y below 16, else z; then z below 8, else w.
    let (sixteen, eight) = (where_set(hash, 4), where_set(hash, 3));
    let first = (sixteen & eight).select(y, x);
    let second = sixteen.select(z, y);
    let third = (sixteen | eight).select(w, z);
    turned(first, hash, 0) + turned(second, hash, 1) + turned(third, hash, 2)
}

impl Perlin for f32 {
    fn noise1([p]: [f32; 1]) -> f32 {
        let (cell, t, eased) = place(p);
        let gradient = |hash: u32, x: f32| negated(1.0 + (hash & 7) as f32, hash & 8) * x;
        let near = gradient(hash1(cell as u32), t);
        let far = gradient(hash1(cell.wrapping_add(1) as u32), t - 1.0);
        finite(lerp(near, far, eased) * SCALES[0])
    }

    fn noise2([x, y]: [f32; 2]) -> f32 {
        let ((cx, x, u), (cy, y, v)) = (place(x), place(y));
        let mut corner = [0.0; 4];
        for (i, value) in corner.iter_mut().enumerate() {
            let (dx, dy) = ((i & 1) as i32, (i >> 1) as i32);
            let (fx, fy) = (x - dx as f32, y - dy as f32);
            let hash = hash2(cx.wrapping_add(dx) as u32, cy.wrapping_add(dy) as u32) & 7;
            let (first, second) = if hash < 4 { (fx, fy) } else { (fy, fx) };
            *value = negated(first, hash & 1) + negated(2.0 * second, hash & 2);
        }
        finite(bilinear(&corner, u, v) * SCALES[1])
    }

    fn noise3([x, y, z]: [f32; 3]) -> f32 {
        let ((cx, x, u), (cy, y, v), (cz, z, w)) = (place(x), place(y), place(z));
        let (sx, sy, sz) = (Sides::new(cx, x), Sides::new(cy, y), Sides::new(cz, z));
        let hash = hash3(by_bit::<0>(sx.cells), by_bit::<1>(sy.cells), by_bit::<2>(sz.cells));
        let (x, y, z) = (by_bit::<0>(sx.ways), by_bit::<1>(sy.ways), by_bit::<2>(sz.ways));
        let (x, y, z) = (bytemuck::cast(x), bytemuck::cast(y), bytemuck::cast(z));
        finite(trilinear(&slopes3(hash, x, y, z).to_array(), u, v, w) * SCALES[2])
    }

    fn noise4([x, y, z, w]: [f32; 4]) -> f32 {
        let ((cx, x, u), (cy, y, v), (cz, z, w), (cw, h, s)) = (place(x), place(y), place(z), place(w));
        let (sx, sy, sz, sw) = (Sides::new(cx, x), Sides::new(cy, y), Sides::new(cz, z), Sides::new(cw, h));
        let (x, y, z) = (by_bit::<0>(sx.ways), by_bit::<1>(sy.ways), by_bit::<2>(sz.ways));
        let (x, y, z) = (bytemuck::cast(x), bytemuck::cast(y), bytemuck::cast(z));
        let side = |number: usize| {
            let (h, cell) = (u32x8::splat(sw.ways[number]), u32x8::splat(sw.cells[number]));
            let hash = hash4(by_bit::<0>(sx.cells), by_bit::<1>(sy.cells), by_bit::<2>(sz.cells), cell);
            trilinear(&slopes4(hash, [x, y, z, bytemuck::cast(h)]).to_array(), u, v, w)
        };
        finite(lerp(side(0), side(1), s) * SCALES[3])
    }
}

/// Factors by the number of dimensions that bring noise into about -1 to 1.
pub(super) const SCALES: [f32; 4] = [0.25, 0.6616, 0.982, 0.8344];

#[inline(always)]
fn bilinear(corner: &[f32; 4], u: f32, v: f32) -> f32 {
    lerp(lerp(corner[0], corner[1], u), lerp(corner[2], corner[3], u), v)
}

#[inline(always)]
fn trilinear(corner: &[f32; 8], u: f32, v: f32, w: f32) -> f32 {
    // Along the last axis first: four corners at once.
    let [a, b, c, d, e, f, g, h] = *corner;
    let flat = f32x4::new([a, b, c, d]) * (1.0 - w) + f32x4::new([e, f, g, h]) * w;
    bilinear(&flat.to_array(), u, v)
}

/// The coordinate, or 0 for NaN and infinity, which give no noise.
#[inline(always)]
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
