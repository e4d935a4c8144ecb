//! Blender's hashes: Jenkins' lookup3 over one to four words, and Jarzynski and Olano's PCG over cells.
//!
//! Which numbers they give is a fact of the file format: other hashes would draw other textures.

use glam::{IVec2, IVec3, IVec4, Vec2, Vec3A, Vec4};

const GOLDEN: u32 = 0xdead_beef;

#[inline(always)]
fn last_mix(mut a: u32, mut b: u32, mut c: u32) -> u32 {
    c = (c ^ b).wrapping_sub(b.rotate_left(14));
    a = (a ^ c).wrapping_sub(c.rotate_left(11));
    b = (b ^ a).wrapping_sub(a.rotate_left(25));
    c = (c ^ b).wrapping_sub(b.rotate_left(16));
    a = (a ^ c).wrapping_sub(c.rotate_left(4));
    b = (b ^ a).wrapping_sub(a.rotate_left(14));
    (c ^ b).wrapping_sub(b.rotate_left(24))
}

/// The start value of lookup3 for a number of words.
#[inline(always)]
const fn start(words: u32) -> u32 {
    GOLDEN.wrapping_add(words << 2).wrapping_add(13)
}

#[inline(always)]
pub(crate) fn hash1(x: u32) -> u32 {
    let s = start(1);
    last_mix(s.wrapping_add(x), s, s)
}

#[inline(always)]
pub(crate) fn hash2(x: u32, y: u32) -> u32 {
    let s = start(2);
    last_mix(s.wrapping_add(x), s.wrapping_add(y), s)
}

#[inline(always)]
pub(crate) fn hash3(x: u32, y: u32, z: u32) -> u32 {
    let s = start(3);
    last_mix(s.wrapping_add(x), s.wrapping_add(y), s.wrapping_add(z))
}

#[inline(always)]
pub(crate) fn hash4(x: u32, y: u32, z: u32, w: u32) -> u32 {
    let s = start(4);
    let (mut a, mut b, mut c) = (s.wrapping_add(x), s.wrapping_add(y), s.wrapping_add(z));
    a = a.wrapping_sub(c) ^ c.rotate_left(4);
    c = c.wrapping_add(b);
    b = b.wrapping_sub(a) ^ a.rotate_left(6);
    a = a.wrapping_add(c);
    c = c.wrapping_sub(b) ^ b.rotate_left(8);
    b = b.wrapping_add(a);
    a = a.wrapping_sub(c) ^ c.rotate_left(16);
    c = c.wrapping_add(b);
    b = b.wrapping_sub(a) ^ a.rotate_left(19);
    a = a.wrapping_add(c);
    c = c.wrapping_sub(b) ^ b.rotate_left(4);
    b = b.wrapping_add(a);
    last_mix(a.wrapping_add(w), b, c)
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
