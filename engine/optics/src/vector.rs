//! Points and directions whose coordinates are lanes.

use std::ops::{Add, Mul, Sub};

use glam::DVec3;

use crate::lane::{Lane, Real};

/// Three coordinates, each a lane: one vector or several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector<L> {
    /// Component to the right.
    pub x: L,
    /// Component upwards.
    pub y: L,
    /// Component along the axis.
    pub z: L,
}

impl<L: Lane> Vector<L> {
    /// x x′ + y y′ + z z′.
    #[inline(always)]
    pub fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The square of the length.
    #[inline(always)]
    pub fn length_squared(self) -> L {
        self.dot(self)
    }

    /// `yes` where `mask` is true, else `no`.
    #[inline(always)]
    pub fn select(mask: L::Mask, yes: Self, no: Self) -> Self {
        Self { x: L::select(mask, yes.x, no.x), y: L::select(mask, yes.y, no.y), z: L::select(mask, yes.z, no.z) }
    }

    /// Vector `i` of the lanes.
    #[inline(always)]
    pub fn of(self, i: usize) -> DVec3 {
        DVec3::new(self.x.of(i).to_f64(), self.y.of(i).to_f64(), self.z.of(i).to_f64())
    }
}

impl<R: Real> Vector<R> {
    /// The nearest vector of this kind of number.
    #[inline(always)]
    pub fn from_f64(v: DVec3) -> Self {
        Self { x: R::from_f64(v.x), y: R::from_f64(v.y), z: R::from_f64(v.z) }
    }
}

impl<L: Lane> Add for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<L: Lane> Sub for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<L: Lane> Mul<L> for Vector<L> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: L) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}
