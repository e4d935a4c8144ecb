//! Blender's hashes: Jenkins' lookup3 over one to four words, and Jarzynski and Olano's PCG over cells.
//!
//! The numbers of these hashes are a fact of the file format: other hashes would draw other textures.

use glam::{IVec2, IVec3, IVec4, Vec2, Vec3A, Vec4};
use std::ops::BitXor;
use wide::{i32x8, u32x8};

const GOLDEN: u32 = 0xdead_beef;

/// A word of 32 bits, or eight at once. Sums wrap around.
pub(crate) trait Word: Copy + BitXor<Output = Self> {
    fn splat(word: u32) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn turned<const BITS: u32>(self) -> Self;
}

impl Word for u32 {
    #[inline(always)]
    fn splat(word: u32) -> Self {
        word
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }
    #[inline(always)]
    fn turned<const BITS: u32>(self) -> Self {
        self.rotate_left(BITS)
    }
}

impl Word for u32x8 {
    #[inline(always)]
    fn splat(word: u32) -> Self {
        Self::splat(word)
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn turned<const BITS: u32>(self) -> Self {
        // By lane: one count for all goes through a copy, which builds with debug assertions check each time.
        (self << Self::splat(BITS)) | (self >> Self::splat(32 - BITS))
    }
}

#[inline(always)]
fn last_mix<W: Word>(mut a: W, mut b: W, mut c: W) -> W {
    c = (c ^ b).minus(b.turned::<14>());
    a = (a ^ c).minus(c.turned::<11>());
    b = (b ^ a).minus(a.turned::<25>());
    c = (c ^ b).minus(b.turned::<16>());
    a = (a ^ c).minus(c.turned::<4>());
    b = (b ^ a).minus(a.turned::<14>());
    (c ^ b).minus(b.turned::<24>())
}

/// The start value of lookup3 for a number of words.
#[inline(always)]
fn start<W: Word>(words: u32) -> W {
    W::splat(GOLDEN.wrapping_add(words << 2).wrapping_add(13))
}

#[inline(always)]
pub(crate) fn hash1<W: Word>(x: W) -> W {
    let s: W = start(1);
    last_mix(s.plus(x), s, s)
}

/// The number from 0 to 1 that Blender gives things by their number.
pub fn random_of(number: u32) -> f32 {
    unit(hash1(number))
}

/// The number from 0 to 1 that Blender gives things by two numbers.
pub fn random_of_pair([first, second]: [u32; 2]) -> f32 {
    unit(hash2(first, second))
}

#[inline(always)]
pub(crate) fn hash2<W: Word>(x: W, y: W) -> W {
    let s: W = start(2);
    last_mix(s.plus(x), s.plus(y), s)
}

#[inline(always)]
pub(crate) fn hash3<W: Word>(x: W, y: W, z: W) -> W {
    let s: W = start(3);
    last_mix(s.plus(x), s.plus(y), s.plus(z))
}

#[inline(always)]
pub(crate) fn hash4<W: Word>(x: W, y: W, z: W, w: W) -> W {
    let s: W = start(4);
    let (mut a, mut b, mut c) = (s.plus(x), s.plus(y), s.plus(z));
    a = a.minus(c) ^ c.turned::<4>();
    c = c.plus(b);
    b = b.minus(a) ^ a.turned::<6>();
    a = a.plus(c);
    c = c.minus(b) ^ b.turned::<8>();
    b = b.plus(a);
    a = a.minus(c) ^ c.turned::<16>();
    c = c.plus(b);
    b = b.minus(a) ^ a.turned::<19>();
    a = a.plus(c);
    c = c.minus(b) ^ b.turned::<4>();
    b = b.plus(a);
    last_mix(a.plus(w), b, c)
}

/// A hash as a number from 0 to 1, both reached.
fn unit(hash: u32) -> f32 {
    hash as f32 * (1.0 / u32::MAX as f32)
}

pub(crate) fn unit1(x: f32) -> f32 {
    unit(hash1(x.to_bits()))
}

pub(crate) fn unit2(x: f32, y: f32) -> f32 {
    unit(hash2(x.to_bits(), y.to_bits()))
}

pub(crate) fn unit3(x: f32, y: f32, z: f32) -> f32 {
    unit(hash3(x.to_bits(), y.to_bits(), z.to_bits()))
}

pub(crate) fn unit4(x: f32, y: f32, z: f32, w: f32) -> f32 {
    unit(hash4(x.to_bits(), y.to_bits(), z.to_bits(), w.to_bits()))
}

/// A colour from one number.
pub(crate) fn colour1(x: f32) -> Vec3A {
    Vec3A::new(unit1(x), unit2(x, 1.0), unit2(x, 2.0))
}

pub(crate) fn colour2(p: Vec2) -> Vec3A {
    Vec3A::new(unit2(p.x, p.y), unit3(p.x, p.y, 1.0), unit3(p.x, p.y, 2.0))
}

pub(crate) fn colour3(p: Vec3A) -> Vec3A {
    Vec3A::new(unit3(p.x, p.y, p.z), unit4(p.x, p.y, p.z, 1.0), unit4(p.x, p.y, p.z, 2.0))
}

pub(crate) fn colour4(p: Vec4) -> Vec3A {
    Vec3A::new(unit4(p.x, p.y, p.z, p.w), unit4(p.z, p.x, p.w, p.y), unit4(p.w, p.z, p.y, p.x))
}

// Cells of Voronoi: PCG in signed words, so shifts keep the sign.

const FACTOR: i32 = 1_664_525;
const ADDEND: i32 = 1_013_904_223;
const POSITIVE: i32 = i32::MAX;

fn positive_unit(word: i32) -> f32 {
    (word & POSITIVE) as f32 * (1.0 / POSITIVE as f32)
}

#[inline]
pub(crate) fn cell2(cell: IVec2) -> Vec2 {
    let [mut x, mut y] = cell.to_array().map(|k| k.wrapping_mul(FACTOR).wrapping_add(ADDEND));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(FACTOR));
        y = y.wrapping_add(x.wrapping_mul(FACTOR));
        if round == 0 {
            (x, y) = (x ^ (x >> 16), y ^ (y >> 16));
        }
    }
    Vec2::new(positive_unit(x), positive_unit(y))
}

#[inline]
pub(crate) fn cell3(cell: IVec3) -> Vec3A {
    let [mut x, mut y, mut z] = cell.to_array().map(|k| k.wrapping_mul(FACTOR).wrapping_add(ADDEND));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        if round == 0 {
            (x, y, z) = (x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16));
        }
    }
    Vec3A::new(positive_unit(x), positive_unit(y), positive_unit(z))
}

/// Eight cells at once.
#[inline(always)]
pub(crate) fn cells3([x, y, z]: [i32x8; 3]) -> [[f32; 8]; 3] {
    let seeded = |k: i32x8| k * i32x8::splat(FACTOR) + i32x8::splat(ADDEND);
    let (mut x, mut y, mut z) = (seeded(x), seeded(y), seeded(z));
    for round in 0..2 {
        x += y * z;
        y += z * x;
        z += x * y;
        if round == 0 {
            (x, y, z) = (x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16));
        }
    }
    let unit = |k: i32x8| ((k & i32x8::splat(POSITIVE)).round_float() * (1.0 / POSITIVE as f32)).to_array();
    [unit(x), unit(y), unit(z)]
}

#[inline]
pub(crate) fn cell4(cell: IVec4) -> Vec4 {
    let [mut x, mut y, mut z, mut w] = cell.to_array().map(|k| k.wrapping_mul(FACTOR).wrapping_add(ADDEND));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        if round == 0 {
            (x, y, z, w) = (x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16), w ^ (w >> 16));
        }
    }
    Vec4::new(positive_unit(x), positive_unit(y), positive_unit(z), positive_unit(w))
}
