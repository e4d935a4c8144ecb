//! Numbers and vectors of one place, or of eight at once. Code over [`Number`] and [`Vector`] is one function for both, with the
//! same operations in the same order: each place has the same bits, whatever the other lanes hold.

use glam::Vec3A;
use std::ops::{Add, Div, Mul, Neg, Sub};
use wide::{f32x8, u32x8};

/// Number of places that are computed at once.
pub const LANES: usize = 8;

/// A number, or those of eight places.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A value for all places.
    fn of(value: f32) -> Self;
    /// The value without its sign.
    fn abs(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// One with the sign of this value.
    fn sign(self) -> Self;
    /// `then` where the value is below a bound, and `otherwise` elsewhere and where there is no number.
    fn if_below(self, bound: Self, then: Self, otherwise: Self) -> Self;

    /// The value between 0 and 1.
    #[inline(always)]
    fn saturated(self) -> Self {
        let (zero, one) = (Self::of(0.0), Self::of(1.0));
        let least = self.if_below(zero, zero, self);
        one.if_below(least, one, least)
    }
}

impl Number for f32 {
    #[inline(always)]
    fn of(value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        Self::copysign(1.0, self)
    }
    #[inline(always)]
    fn if_below(self, bound: Self, then: Self, otherwise: Self) -> Self {
        if self < bound { then } else { otherwise }
    }
}

impl Number for f32x8 {
    #[inline(always)]
    fn of(value: f32) -> Self {
        Self::splat(value)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn sign(self) -> Self {
        let bits: u32x8 = bytemuck::cast(self);
        let one: u32x8 = bytemuck::cast(Self::ONE);
        bytemuck::cast((bits & u32x8::splat(0x8000_0000)) | one)
    }
    #[inline(always)]
    fn if_below(self, bound: Self, then: Self, otherwise: Self) -> Self {
        self.simd_lt(bound).select(then, otherwise)
    }
}

/// A vector, or those of eight places.
pub trait Vector: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The numbers that its parts are.
    type Number: Number;

    /// The vector of three parts.
    fn of(parts: [Self::Number; 3]) -> Self;
    /// The three parts.
    fn parts(self) -> [Self::Number; 3];
    /// The product with a number.
    fn times(self, factor: Self::Number) -> Self;
    /// The sum of the products of the parts.
    fn inner(self, other: Self) -> Self::Number;
    /// The cross product.
    fn across(self, other: Self) -> Self;
    /// The vector at length 1; zero where it has no direction.
    fn unit(self) -> Self;
    /// Each part between 0 and 1; 0 where there is no number.
    fn saturated(self) -> Self;

    /// The vector of one number in all parts.
    #[inline(always)]
    fn splat(value: Self::Number) -> Self {
        Self::of([value; 3])
    }
}

/// The larger of each part; that of the second where one is no number, on every processor.
#[inline(always)]
pub(crate) fn most(a: Vec3A, b: Vec3A) -> Vec3A {
    // The instruction of x86-64 does that; that of ARM hands on what is no number.
    if cfg!(target_arch = "x86_64") { a.max(b) } else { Vec3A::select(a.cmpgt(b), a, b) }
}

/// The smaller of each part; that of the second where one is no number, on every processor.
#[inline(always)]
pub(crate) fn least(a: Vec3A, b: Vec3A) -> Vec3A {
    if cfg!(target_arch = "x86_64") { a.min(b) } else { Vec3A::select(a.cmplt(b), a, b) }
}

impl Vector for Vec3A {
    type Number = f32;

    #[inline(always)]
    fn of(parts: [f32; 3]) -> Self {
        Self::from_array(parts)
    }
    #[inline(always)]
    fn parts(self) -> [f32; 3] {
        self.to_array()
    }
    #[inline(always)]
    fn times(self, factor: f32) -> Self {
        self * factor
    }
    #[inline(always)]
    fn inner(self, other: Self) -> f32 {
        self.dot(other)
    }
    #[inline(always)]
    fn across(self, other: Self) -> Self {
        self.cross(other)
    }
    #[inline(always)]
    fn unit(self) -> Self {
        self.normalize_or_zero()
    }
    #[inline(always)]
    fn saturated(self) -> Self {
        least(most(self, Self::ZERO), Self::ONE)
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self::splat(value)
    }
}

/// Vectors of eight places.
#[derive(Clone, Copy, Debug)]
pub struct Vectors {
    /// The first parts.
    pub x: f32x8,
    /// The second parts.
    pub y: f32x8,
    /// The third parts.
    pub z: f32x8,
}

impl Vectors {
    /// Zero everywhere.
    pub const ZERO: Self = Self { x: f32x8::ZERO, y: f32x8::ZERO, z: f32x8::ZERO };

    /// One vector for all places.
    #[inline(always)]
    pub fn all(vector: Vec3A) -> Self {
        let [x, y, z] = vector.to_array().map(f32x8::splat);
        Self { x, y, z }
    }

    /// The vector of a place.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> Vec3A {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|part| bytemuck::cast_ref::<f32x8, [f32; LANES]>(part)[lane]);
        Vec3A::new(x, y, z)
    }

    /// Sets the vector of a place.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, vector: Vec3A) {
        for (part, value) in [&mut self.x, &mut self.y, &mut self.z].into_iter().zip(vector.to_array()) {
            bytemuck::cast_mut::<f32x8, [f32; LANES]>(part)[lane] = value;
        }
    }
}

impl Add for Vectors {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Vectors {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul for Vectors {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }
}

impl Vector for Vectors {
    type Number = f32x8;

    #[inline(always)]
    fn of([x, y, z]: [f32x8; 3]) -> Self {
        Self { x, y, z }
    }
    #[inline(always)]
    fn parts(self) -> [f32x8; 3] {
        [self.x, self.y, self.z]
    }
    #[inline(always)]
    fn times(self, factor: f32x8) -> Self {
        self * Self { x: factor, y: factor, z: factor }
    }
    #[inline(always)]
    fn inner(self, other: Self) -> f32x8 {
        let [x, y, z] = (self * other).parts();
        x + y + z
    }
    #[inline(always)]
    fn across(self, other: Self) -> Self {
        // Rounded as by glam, which fuses the second product with the difference where the processor can.
        let of = |a: f32x8, b: f32x8, c: f32x8, d: f32x8| c.mul_neg_add(d, a * b);
        Self {
            x: of(self.y, other.z, self.z, other.y),
            y: of(self.z, other.x, self.x, other.z),
            z: of(self.x, other.y, self.y, other.x),
        }
    }
    #[inline(always)]
    fn unit(self) -> Self {
        let over = f32x8::ONE / self.inner(self).sqrt();
        let is_finite = over.simd_lt(f32x8::splat(f32::INFINITY));
        let over = is_finite.select(over, f32x8::ZERO);
        let has = f32x8::ZERO.simd_lt(over);
        let of = |part: f32x8| has.select(part * over, f32x8::ZERO);
        Self { x: of(self.x), y: of(self.y), z: of(self.z) }
    }
    #[inline(always)]
    fn saturated(self) -> Self {
        let (zero, one) = (f32x8::ZERO, f32x8::ONE);
        Self::of(self.parts().map(|part| {
            let least = zero.if_below(part, part, zero);
            least.if_below(one, least, one)
        }))
    }
}
