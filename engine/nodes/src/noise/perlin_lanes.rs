//! Perlin noise of eight places at once: the lanes are places, where those of one place alone are corners of its cell.

use super::Perlin;
use super::perlin::{PERIOD, SCALES, folded, slopes3, slopes4, turned, where_set};
use crate::hash::{hash1, hash2, hash3, hash4};
use wide::{f32x8, i32x8, u32x8};

/// An axis of the cells of eight places: both corners' numbers, the ways from them, and the eased place.
struct Axis {
    cells: [u32x8; 2],
    ways: [f32x8; 2],
    eased: f32x8,
}

impl Axis {
    #[inline(always)]
    fn new(mut x: f32x8) -> Self {
        // No number is far away, too.
        if !x.abs().simd_lt(f32x8::splat(PERIOD)).all() {
            x = far(x);
        }
        let floor = x.floor();
        let t = x - floor;
        let cell: u32x8 = bytemuck::cast::<i32x8, _>(floor.fast_trunc_int());
        let eased = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        Self { cells: [cell, cell + u32x8::splat(1)], ways: [t, t - 1.0], eased }
    }
}

#[cold]
fn far(x: f32x8) -> f32x8 {
    f32x8::from(x.to_array().map(folded))
}

#[inline(always)]
fn lerp(a: f32x8, b: f32x8, t: f32x8) -> f32x8 {
    (f32x8::ONE - t) * a + t * b
}

/// Between the values of four corners, of which corner i lies at the bits of i.
#[inline(always)]
fn bilinear([a, b, c, d]: [f32x8; 4], x: &Axis, y: &Axis) -> f32x8 {
    lerp(lerp(a, b, x.eased), lerp(c, d, x.eased), y.eased)
}

/// The numbers, and 0 for NaN and infinity.
#[inline(always)]
fn finite(value: f32x8) -> f32x8 {
    value.abs().simd_lt(f32x8::splat(f32::INFINITY)).select(value, f32x8::ZERO)
}

/// The values of eight corners, between which the last axis is left out by its own weights first.
#[inline(always)]
fn trilinear(axes: [&Axis; 3], corner: impl Fn([usize; 3]) -> f32x8) -> f32x8 {
    let [x, y, z] = axes;
    let flat = [0, 1, 2, 3].map(|i: usize| {
        let of = |side: usize| corner([i & 1, i >> 1, side]);
        of(0) * (f32x8::ONE - z.eased) + of(1) * z.eased
    });
    bilinear(flat, x, y)
}

impl Perlin for f32x8 {
    fn noise1([x]: [f32x8; 1]) -> f32x8 {
        let x = Axis::new(x);
        let [near, far] = [0, 1].map(|side: usize| {
            let hash = hash1(x.cells[side]);
            let size = f32x8::from_i32x8(bytemuck::cast(hash & u32x8::splat(7)));
            turned(f32x8::ONE + size, hash, 3) * x.ways[side]
        });
        finite(lerp(near, far, x.eased) * SCALES[0])
    }

    fn noise2([x, y]: [f32x8; 2]) -> f32x8 {
        let (x, y) = (Axis::new(x), Axis::new(y));
        let corners = [0, 1, 2, 3].map(|i: usize| {
            let hash = hash2(x.cells[i & 1], y.cells[i >> 1]);
            let (fx, fy, four) = (x.ways[i & 1], y.ways[i >> 1], where_set(hash, 2));
            let (first, second) = (four.select(fy, fx), four.select(fx, fy));
            turned(first, hash, 0) + turned(second * 2.0, hash, 1)
        });
        finite(bilinear(corners, &x, &y) * SCALES[1])
    }

    fn noise3([x, y, z]: [f32x8; 3]) -> f32x8 {
        let (x, y, z) = (Axis::new(x), Axis::new(y), Axis::new(z));
        let corner = |[i, j, k]: [usize; 3]| {
            let hash = hash3(x.cells[i], y.cells[j], z.cells[k]);
            slopes3(hash, x.ways[i], y.ways[j], z.ways[k])
        };
        finite(trilinear([&x, &y, &z], corner) * SCALES[2])
    }

    fn noise4([x, y, z, w]: [f32x8; 4]) -> f32x8 {
        let (x, y, z, w) = (Axis::new(x), Axis::new(y), Axis::new(z), Axis::new(w));
        let [near, far] = [0, 1].map(|side: usize| {
            trilinear([&x, &y, &z], |[i, j, k]| {
                let hash = hash4(x.cells[i], y.cells[j], z.cells[k], w.cells[side]);
                slopes4(hash, [x.ways[i], y.ways[j], z.ways[k], w.ways[side]])
            })
        });
        finite(lerp(near, far, w.eased) * SCALES[3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::random_of_pair;

    /// A place about the origin, far away, or no number at all.
    fn coordinate(seed: u32) -> f32 {
        let unit = random_of_pair([seed, 1]) * 2.0 - 1.0;
        match seed % 41 {
            0 => unit * 1e6,
            1 => unit * 1e9,
            2 => [f32::NAN, f32::INFINITY, -0.0, 1.0, PERIOD][seed as usize / 41 % 5],
            _ => unit * 30.0,
        }
    }

    /// Eight places at once have the bits of each alone.
    fn hold<const D: usize>(at_once: impl Fn([f32x8; D]) -> f32x8, alone: impl Fn([f32; D]) -> f32) {
        let mut sum = 0.0;
        for round in 0..4000 {
            let places: [[f32; D]; 8] = std::array::from_fn(|lane| {
                std::array::from_fn(|axis| coordinate(round * 64 + lane as u32 * 8 + axis as u32))
            });
            let wide = std::array::from_fn(|axis| f32x8::from(places.map(|place| place[axis])));
            for (found, place) in at_once(wide).to_array().into_iter().zip(places) {
                assert_eq!(found.to_bits(), alone(place).to_bits(), "{place:?}: {found}");
                sum += found.abs();
            }
        }
        assert!(sum > 3000.0, "{sum}");
    }

    #[test]
    fn places_at_once_are_places_alone() {
        hold(f32x8::noise1, f32::noise1);
        hold(f32x8::noise2, f32::noise2);
        hold(f32x8::noise3, f32::noise3);
        hold(f32x8::noise4, f32::noise4);
    }
}
