//! What Voronoi needs of one to four dimensions: cells, the point in each, distances.

use super::{CellHash, Metric};
use crate::hash::{cell2, cell3, cell4, colour1, colour2, colour3, colour4, unit1, unit2, unit3, unit4};
use glam::{IVec2, IVec3, IVec4, Vec2, Vec3A, Vec4};
use std::ops::{Add, Mul, Sub};

pub(super) trait Space:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self> + Sub<f32, Output = Self>
{
    const DIMENSIONS: u32;
    const ZERO: Self;

    fn floor(self) -> Self;
    /// Where the point of a cell lies in it, from 0 to 1.
    fn point(cell: Self, hash: CellHash) -> Self;
    fn colour(cell: Self, hash: CellHash) -> Vec3A;
    fn dot(self, other: Self) -> f32;
    /// The sum over the axes of a function of each part.
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32;
    fn largest(self) -> f32;
    /// x, y, z and w as the node gives them out.
    fn outputs(self) -> Vec4;
    fn from_digits(digits: [f32; 4]) -> Self;

    fn splat(value: f32) -> Self {
        Self::from_digits([value; 4])
    }

    fn length(self) -> f32 {
        self.dot(self).sqrt()
    }

    /// The cells at most `reach` away from a cell, itself among them.
    fn around(reach: i32) -> impl Iterator<Item = Self> {
        let side = 2 * reach + 1;
        (0..side.pow(Self::DIMENSIONS)).map(move |number| {
            let mut rest = number;
            Self::from_digits(std::array::from_fn(|_| {
                let digit = rest % side - reach;
                rest /= side;
                digit as f32
            }))
        })
    }

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

    fn floor(self) -> Self {
        f32::floor(self)
    }
    fn point(cell: Self, _: CellHash) -> Self {
        unit1(cell)
    }
    fn colour(cell: Self, _: CellHash) -> Vec3A {
        colour1(cell)
    }
    fn dot(self, other: Self) -> f32 {
        self * other
    }
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self)
    }
    fn largest(self) -> f32 {
        self.abs()
    }
    fn outputs(self) -> Vec4 {
        Vec4::new(0.0, 0.0, 0.0, self)
    }
    fn from_digits(digits: [f32; 4]) -> Self {
        digits[0]
    }
}

impl Space for Vec2 {
    const DIMENSIONS: u32 = 2;
    const ZERO: Self = Vec2::ZERO;

    fn floor(self) -> Self {
        Vec2::floor(self)
    }
    fn point(cell: Self, hash: CellHash) -> Self {
        match hash {
            CellHash::Pcg => cell2(IVec2::new(cell.x as i32, cell.y as i32)),
            CellHash::Lookup3 => Vec2::new(unit2(cell.x, cell.y), unit3(cell.x, cell.y, 1.0)),
        }
    }
    fn colour(cell: Self, hash: CellHash) -> Vec3A {
        match hash {
            CellHash::Pcg => cell3(IVec3::new(cell.x as i32, cell.y as i32, 0)),
            CellHash::Lookup3 => colour2(cell),
        }
    }
    fn dot(self, other: Self) -> f32 {
        Vec2::dot(self, other)
    }
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self.x) + function(self.y)
    }
    fn largest(self) -> f32 {
        self.abs().max_element()
    }
    fn outputs(self) -> Vec4 {
        Vec4::new(self.x, self.y, 0.0, 0.0)
    }
    fn from_digits([x, y, _, _]: [f32; 4]) -> Self {
        Vec2::new(x, y)
    }
}

impl Space for Vec3A {
    const DIMENSIONS: u32 = 3;
    const ZERO: Self = Vec3A::ZERO;

    fn floor(self) -> Self {
        Vec3A::floor(self)
    }
    fn point(cell: Self, hash: CellHash) -> Self {
        match hash {
            CellHash::Pcg => cell3(IVec3::new(cell.x as i32, cell.y as i32, cell.z as i32)),
            CellHash::Lookup3 => colour3(cell),
        }
    }
    fn colour(cell: Self, hash: CellHash) -> Vec3A {
        Self::point(cell, hash)
    }
    fn dot(self, other: Self) -> f32 {
        Vec3A::dot(self, other)
    }
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self.x) + function(self.y) + function(self.z)
    }
    fn largest(self) -> f32 {
        self.abs().max_element()
    }
    fn outputs(self) -> Vec4 {
        self.extend(0.0)
    }
    fn from_digits([x, y, z, _]: [f32; 4]) -> Self {
        Vec3A::new(x, y, z)
    }
}

impl Space for Vec4 {
    const DIMENSIONS: u32 = 4;
    const ZERO: Self = Vec4::ZERO;

    fn floor(self) -> Self {
        Vec4::floor(self)
    }
    fn point(cell: Self, hash: CellHash) -> Self {
        match hash {
            CellHash::Pcg => cell4(IVec4::new(cell.x as i32, cell.y as i32, cell.z as i32, cell.w as i32)),
            CellHash::Lookup3 => {
                let [x, y, z, w] = cell.to_array();
                Vec4::new(unit4(x, y, z, w), unit4(w, x, y, z), unit4(z, w, x, y), unit4(y, z, w, x))
            }
        }
    }
    fn colour(cell: Self, hash: CellHash) -> Vec3A {
        match hash {
            CellHash::Pcg => Vec3A::from_vec4(Self::point(cell, hash)),
            CellHash::Lookup3 => colour4(cell),
        }
    }
    fn dot(self, other: Self) -> f32 {
        Vec4::dot(self, other)
    }
    fn each_sum(self, function: impl Fn(f32) -> f32) -> f32 {
        function(self.x) + function(self.y) + function(self.z) + function(self.w)
    }
    fn largest(self) -> f32 {
        self.abs().max_element()
    }
    fn outputs(self) -> Vec4 {
        self
    }
    fn from_digits(digits: [f32; 4]) -> Self {
        Vec4::from_array(digits)
    }
}
