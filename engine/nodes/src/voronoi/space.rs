//! Operations of Voronoi in one to four dimensions: cells, the point in each, distances.

use super::{CellHash, Metric};
use crate::hash::{cell2, cell3, cell4, cells3, colour1, colour2, colour3, colour4, unit1, unit2, unit3, unit4};
use glam::{IVec2, IVec3, IVec4, Vec2, Vec3A, Vec4};
use std::ops::{Add, Mul, Sub};
use wide::i32x8;

/// All steps of -1 to 1 in four dimensions, the first dimension fastest: the first 3, 9 and 27 serve fewer dimensions.
const NEAR: [[f32; 4]; 81] = steps(3);
/// All steps of -2 to 2 in four dimensions, in the order of [`steps`].
const WIDER: [[f32; 4]; 625] = steps(5);

/// The first 27 steps of -1 to 1 along x, y and z, for eight lanes at a time.
static NEAR_LANES: [[[i32; 8]; 3]; 4] = lanes(&NEAR, 27);
/// The first 125 steps of -2 to 2 along x, y and z, for eight lanes at a time.
static WIDER_LANES: [[[i32; 8]; 3]; 16] = lanes(&WIDER, 125);

const fn lanes<const GROUPS: usize>(steps: &[[f32; 4]], count: usize) -> [[[i32; 8]; 3]; GROUPS] {
    let mut all = [[[0; 8]; 3]; GROUPS];
    let mut number = 0;
    while number < count {
        let mut axis = 0;
        while axis < 3 {
            all[number / 8][axis][number % 8] = steps[number][axis] as i32;
            axis += 1;
        }
        number += 1;
    }
    all
}

/// The points of many cells about one, eight at a time; points that the last group has too many are left out.
#[inline]
fn points_of<const COUNT: usize>(cell: Vec3A, groups: &[[[i32; 8]; 3]], randomness: f32) -> [Vec3A; COUNT] {
    let middle = IVec3::new(cell.x as i32, cell.y as i32, cell.z as i32);
    let mut points = [Vec3A::ZERO; COUNT];
    for (points, cells) in points.chunks_mut(8).zip(groups) {
        let [x, y, z] = cells3([
            i32x8::splat(middle.x) + i32x8::new(cells[0]),
            i32x8::splat(middle.y) + i32x8::new(cells[1]),
            i32x8::splat(middle.z) + i32x8::new(cells[2]),
        ]);
        for (i, point) in points.iter_mut().enumerate() {
            let offset = Vec3A::new(cells[0][i] as f32, cells[1][i] as f32, cells[2][i] as f32);
            *point = offset + Vec3A::new(x[i], y[i], z[i]) * randomness;
        }
    }
    points
}

fn one_point<P: Space>(cell: P, offset: P, hash: CellHash, randomness: f32) -> P {
    offset + P::point(cell + offset, hash) * randomness
}

const fn steps<const COUNT: usize>(side: usize) -> [[f32; 4]; COUNT] {
    let mut all = [[0.0; 4]; COUNT];
    let reach = (side / 2) as f32;
    let mut number = 0;
    while number < COUNT {
        let (mut rest, mut axis) = (number, 0);
        while axis < 4 {
            all[number][axis] = (rest % side) as f32 - reach;
            rest /= side;
            axis += 1;
        }
        number += 1;
    }
    all
}

pub(super) trait Space:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self> + Sub<f32, Output = Self>
{
    const DIMENSIONS: u32;
    const ZERO: Self;
    /// One for each cell at most 1 away.
    type Near: AsRef<[Self]>;
    /// One for each cell at most 2 away.
    type Wider: AsRef<[Self]>;

    fn floor(self) -> Self;
    /// The place of a cell's point in the cell, from 0 to 1.
    fn point(cell: Self, hash: CellHash) -> Self;
    fn colour(cell: Self, hash: CellHash) -> Vec3A;
    fn dot(self, other: Self) -> f32;
    /// The sum over the axes of a function of each part.
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32;
    fn largest(self) -> f32;
    /// x, y, z and w as the node gives them out.
    fn outputs(self) -> Vec4;
    fn from_digits(digits: [f32; 4]) -> Self;

    #[inline]
    fn splat(value: f32) -> Self {
        Self::from_digits([value; 4])
    }

    #[inline]
    fn length(self) -> f32 {
        self.dot(self).sqrt()
    }

    /// The cells at most 1 away from a cell, itself among them.
    fn near() -> impl Iterator<Item = Self> {
        NEAR[..3_usize.pow(Self::DIMENSIONS)].iter().map(|digits| Self::from_digits(*digits))
    }

    /// The points of those cells, from the corner of the cell in the middle.
    fn near_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Near;

    /// The points of the cells at most 2 away.
    fn wider_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Wider;

    /// The cells at most 2 away.
    fn wider() -> impl Iterator<Item = Self> {
        WIDER[..5_usize.pow(Self::DIMENSIONS)].iter().map(|digits| Self::from_digits(*digits))
    }

    #[inline]
    fn distance(self, other: Self, metric: Metric, exponent: f32) -> f32 {
        let between = self - other;
        // In one dimension all metrics are the same.
        if Self::DIMENSIONS == 1 {
            return between.length();
        }
        match metric {
            Metric::Euclidean => between.length(),
            Metric::Manhattan => between.each_sum(f32::abs),
            Metric::Chebychev => between.largest(),
            Metric::Minkowski => between.each_sum(|part| part.abs().powf(exponent)).powf(1.0 / exponent),
        }
    }
}

impl Space for f32 {
    const DIMENSIONS: u32 = 1;
    const ZERO: Self = 0.0;
    type Near = [Self; 3];
    type Wider = [Self; 5];

    #[inline]
    fn near_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Near {
        std::array::from_fn(|i| one_point(cell, Self::from_digits(NEAR[i]), hash, randomness))
    }

    #[inline]
    fn wider_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Wider {
        std::array::from_fn(|i| one_point(cell, Self::from_digits(WIDER[i]), hash, randomness))
    }

    #[inline]
    fn floor(self) -> Self {
        f32::floor(self)
    }
    #[inline]
    fn point(cell: Self, _: CellHash) -> Self {
        unit1(cell)
    }
    #[inline]
    fn colour(cell: Self, _: CellHash) -> Vec3A {
        colour1(cell)
    }
    #[inline]
    fn dot(self, other: Self) -> f32 {
        self * other
    }
    #[inline]
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self)
    }
    #[inline]
    fn largest(self) -> f32 {
        self.abs()
    }
    #[inline]
    fn outputs(self) -> Vec4 {
        Vec4::new(0.0, 0.0, 0.0, self)
    }
    #[inline]
    fn from_digits(digits: [f32; 4]) -> Self {
        digits[0]
    }
}

impl Space for Vec2 {
    const DIMENSIONS: u32 = 2;
    const ZERO: Self = Vec2::ZERO;
    type Near = [Self; 9];
    type Wider = [Self; 25];

    #[inline]
    fn near_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Near {
        std::array::from_fn(|i| one_point(cell, Self::from_digits(NEAR[i]), hash, randomness))
    }

    #[inline]
    fn wider_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Wider {
        std::array::from_fn(|i| one_point(cell, Self::from_digits(WIDER[i]), hash, randomness))
    }

    #[inline]
    fn floor(self) -> Self {
        Vec2::floor(self)
    }
    #[inline]
    fn point(cell: Self, hash: CellHash) -> Self {
        match hash {
            CellHash::Pcg => cell2(IVec2::new(cell.x as i32, cell.y as i32)),
            CellHash::Lookup3 => Vec2::new(unit2(cell.x, cell.y), unit3(cell.x, cell.y, 1.0)),
        }
    }
    #[inline]
    fn colour(cell: Self, hash: CellHash) -> Vec3A {
        match hash {
            CellHash::Pcg => cell3(IVec3::new(cell.x as i32, cell.y as i32, 0)),
            CellHash::Lookup3 => colour2(cell),
        }
    }
    #[inline]
    fn dot(self, other: Self) -> f32 {
        Vec2::dot(self, other)
    }
    #[inline]
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self.x) + function(self.y)
    }
    #[inline]
    fn largest(self) -> f32 {
        self.abs().max_element()
    }
    #[inline]
    fn outputs(self) -> Vec4 {
        Vec4::new(self.x, self.y, 0.0, 0.0)
    }
    #[inline]
    fn from_digits([x, y, _, _]: [f32; 4]) -> Self {
        Vec2::new(x, y)
    }
}

impl Space for Vec3A {
    const DIMENSIONS: u32 = 3;
    const ZERO: Self = Vec3A::ZERO;
    type Near = [Self; 27];
    type Wider = [Self; 125];

    #[inline]
    fn near_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Near {
        if hash == CellHash::Lookup3 {
            return std::array::from_fn(|i| one_point(cell, Self::from_digits(NEAR[i]), hash, randomness));
        }
        points_of(cell, &NEAR_LANES, randomness)
    }

    #[inline]
    fn wider_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Wider {
        if hash == CellHash::Lookup3 {
            return std::array::from_fn(|i| one_point(cell, Self::from_digits(WIDER[i]), hash, randomness));
        }
        points_of(cell, &WIDER_LANES, randomness)
    }

    #[inline]
    fn floor(self) -> Self {
        Vec3A::floor(self)
    }
    #[inline]
    fn point(cell: Self, hash: CellHash) -> Self {
        match hash {
            CellHash::Pcg => cell3(IVec3::new(cell.x as i32, cell.y as i32, cell.z as i32)),
            CellHash::Lookup3 => colour3(cell),
        }
    }
    #[inline]
    fn colour(cell: Self, hash: CellHash) -> Vec3A {
        Self::point(cell, hash)
    }
    #[inline]
    fn dot(self, other: Self) -> f32 {
        Vec3A::dot(self, other)
    }
    #[inline]
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self.x) + function(self.y) + function(self.z)
    }
    #[inline]
    fn largest(self) -> f32 {
        self.abs().max_element()
    }
    #[inline]
    fn outputs(self) -> Vec4 {
        self.extend(0.0)
    }
    #[inline]
    fn from_digits([x, y, z, _]: [f32; 4]) -> Self {
        Vec3A::new(x, y, z)
    }
}

impl Space for Vec4 {
    const DIMENSIONS: u32 = 4;
    const ZERO: Self = Vec4::ZERO;
    type Near = [Self; 81];
    type Wider = [Self; 625];

    #[inline]
    fn near_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Near {
        std::array::from_fn(|i| one_point(cell, Self::from_digits(NEAR[i]), hash, randomness))
    }

    #[inline]
    fn wider_points(cell: Self, hash: CellHash, randomness: f32) -> Self::Wider {
        std::array::from_fn(|i| one_point(cell, Self::from_digits(WIDER[i]), hash, randomness))
    }

    #[inline]
    fn floor(self) -> Self {
        Vec4::floor(self)
    }
    #[inline]
    fn point(cell: Self, hash: CellHash) -> Self {
        match hash {
            CellHash::Pcg => cell4(IVec4::new(cell.x as i32, cell.y as i32, cell.z as i32, cell.w as i32)),
            CellHash::Lookup3 => {
                let [x, y, z, w] = cell.to_array();
                Vec4::new(unit4(x, y, z, w), unit4(w, x, y, z), unit4(z, w, x, y), unit4(y, z, w, x))
            }
        }
    }
    #[inline]
    fn colour(cell: Self, hash: CellHash) -> Vec3A {
        match hash {
            CellHash::Pcg => Vec3A::from_vec4(Self::point(cell, hash)),
            CellHash::Lookup3 => colour4(cell),
        }
    }
    #[inline]
    fn dot(self, other: Self) -> f32 {
        Vec4::dot(self, other)
    }
    #[inline]
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self.x) + function(self.y) + function(self.z) + function(self.w)
    }
    #[inline]
    fn largest(self) -> f32 {
        self.abs().max_element()
    }
    #[inline]
    fn outputs(self) -> Vec4 {
        self
    }
    #[inline]
    fn from_digits(digits: [f32; 4]) -> Self {
        Vec4::from_array(digits)
    }
}
