//! Operations on a lane of numbers: one number, or as many as the processor works on at once.
//!
//! The tracer is written once, over [`Lane`]. `f64` and `f32` are lanes of one; [`Doubles`] and [`Singles`] are vector
//! registers of them, as wide as the processor at hand has them (2 to 8 of `f64`, 4 to 16 of `f32`, chosen while the
//! program runs: [`Real::run_wide`]). All lanes do the same operations in the same order without fusing any, so that a number in a register
//! comes out as it does alone, to the last bit, on every processor.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch};

pub use fearless_simd::Level;

/// Yes or no for each number of a lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// True if any is.
    fn any(self) -> bool;
    /// True if all are.
    fn all(self) -> bool;
    /// The answers as bits, the first the lowest.
    fn bits(self) -> u64;
}

/// A real number: `f32` or `f64`.
pub trait Real: Lane<Real = Self, Mask = bool> + PartialOrd + Debug + Default + Send + Sync + 'static {
    /// The distance from 1 to the next number.
    const EPSILON: Self;
    /// The largest finite number of this kind.
    const LARGEST: Self;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// The nearest number of this kind.
    fn from_f64(x: f64) -> Self;
    /// The value in f64, exactly.
    fn to_f64(self) -> f64;
    /// a b − c d with the error of one rounding or two.
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self;
    /// Runs `kernel` with the lanes that the instructions of `level` have; `Level::new()` is the best of this processor.
    fn run_wide<K: LaneKernel<Self>>(level: Level, kernel: K) -> K::Output;
}

/// A computation that is written for every kind of lane.
pub trait LaneKernel<R: Real> {
    /// The result of the kernel, of one type for all kinds of lane.
    type Output;
    /// Runs the kernel. `zero` is a lane of zeros, from which others are made; mark the function `#[inline(always)]`.
    fn run<L: Lane<Real = R>>(self, zero: L) -> Self::Output;
}

/// One number or several, on which every operation works alike.
pub trait Lane:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<Self::Real, Output = Self>
    + Sub<Self::Real, Output = Self>
    + Mul<Self::Real, Output = Self>
{
    /// The kind of number.
    type Real: Real;
    /// The answer to a comparison.
    type Mask: Mask;
    /// Number of numbers in the lane.
    const WIDTH: usize;
    /// Runs `work` with the instructions of this lane, where it is not inlined into a kernel, which has them.
    fn within<T>(self, work: impl FnOnce() -> T) -> T;
    /// A lane like this one that holds `x` throughout.
    fn like(self, x: Self::Real) -> Self;
    /// A lane like this one that holds `numbers`, of which there must be [`Self::WIDTH`].
    fn load(self, numbers: &[Self::Real]) -> Self;
    /// Writes the numbers to `to`, which must hold [`Self::WIDTH`].
    fn store(self, to: &mut [Self::Real]);
    /// The number in lane `i`.
    fn of(self, i: usize) -> Self::Real;
    /// Square root; NaN of a negative number.
    fn sqrt(self) -> Self;
    /// The absolute value of each number.
    fn abs(self) -> Self;
    /// `self` ≤ `other`; false if either is NaN, as are the other comparisons.
    fn at_most(self, other: Self) -> Self::Mask;
    /// True in the lanes where `self` < `other`.
    fn less(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// a b − c d, see [`Real::difference_of_products`]. For the rare place where the products cancel.
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self;

    /// True in the lanes where `other` ≤ `self`.
    #[inline(always)]
    fn at_least(self, other: Self) -> Self::Mask {
        other.at_most(self)
    }

    /// True in the lanes where `other` < `self`.
    #[inline(always)]
    fn greater(self, other: Self) -> Self::Mask {
        other.less(self)
    }

    /// The smaller; `other` if either is NaN.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self::select(self.less(other), self, other)
    }

    /// The larger; `other` if either is NaN.
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        Self::select(other.less(self), self, other)
    }

    /// True in the lanes whose number is finite.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.abs().at_most(self.like(Self::Real::LARGEST))
    }
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }

    #[inline(always)]
    fn all(self) -> bool {
        self
    }

    #[inline(always)]
    fn bits(self) -> u64 {
        u64::from(self)
    }
}

macro_rules! one_number {
    ($number:ty) => {
        impl Lane for $number {
            type Real = Self;
            type Mask = bool;
            const WIDTH: usize = 1;

            #[inline(always)]
            fn within<T>(self, work: impl FnOnce() -> T) -> T {
                work()
            }

            #[inline(always)]
            fn like(self, x: Self) -> Self {
                x
            }

            #[inline(always)]
            fn load(self, numbers: &[Self]) -> Self {
                numbers[0]
            }

            #[inline(always)]
            fn store(self, to: &mut [Self]) {
                to[0] = self;
            }

            #[inline(always)]
            fn of(self, _: usize) -> Self {
                self
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn at_most(self, other: Self) -> bool {
                self <= other
            }

            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }

            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }

            #[inline(always)]
            fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self {
                <$number as Real>::difference_of_products(a, b, c, d)
            }
        }
    };
}

one_number!(f64);
one_number!(f32);

impl Real for f64 {
    const EPSILON: Self = Self::EPSILON;
    const LARGEST: Self = Self::MAX;
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    /// Kahan's algorithm: two fused multiplications, so that little is lost where the products cancel.
    #[cold]
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self {
        let product = c * d;
        let lost = (-c).mul_add(d, product);
        a.mul_add(b, -product) + lost
    }

    fn run_wide<K: LaneKernel<Self>>(level: Level, kernel: K) -> K::Output {
        dispatch!(level, simd => kernel.run(Doubles::zero(simd)))
    }
}

impl Real for f32 {
    const EPSILON: Self = Self::EPSILON;
    const LARGEST: Self = Self::MAX;
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as Self
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    /// The products are exact in f64.
    #[cold]
    fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self {
        (f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d)) as Self
    }

    fn run_wide<K: LaneKernel<Self>>(level: Level, kernel: K) -> K::Output {
        dispatch!(level, simd => kernel.run(Singles::zero(simd)))
    }
}

/// A register of `f32` of the instructions `S`.
#[derive(Clone, Copy)]
pub struct Singles<S: Simd>(S::f32s);

/// A register of `f64` of the instructions `S`.
#[derive(Clone, Copy)]
pub struct Doubles<S: Simd>(S::f64s);

/// The answers for a [`Singles`].
#[derive(Clone, Copy)]
pub struct SinglesMask<S: Simd>(S::mask32s);

/// The answers for a [`Doubles`].
#[derive(Clone, Copy)]
pub struct DoublesMask<S: Simd>(S::mask64s);

/// Most numbers in a register: 512 bits of f32.
const WIDEST: usize = 16;

macro_rules! operation {
    ($wide:ident, $other:ty, |$o:ident| $inner:expr, $($trait:ident $method:ident)*) => {$(
        impl<S: Simd> $trait<$other> for $wide<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, $o: $other) -> Self {
                Self(self.0.$method($inner))
            }
        }
    )*};
}

macro_rules! register {
    ($wide:ident, $mask:ident, $number:ty, $vector:ident) => {
        operation!($wide, Self, |other| other.0, Add add Sub sub Mul mul Div div);
        operation!($wide, $number, |other| other, Add add Sub sub Mul mul);

        impl<S: Simd> $wide<S> {
            #[inline(always)]
            fn zero(instructions: S) -> Self {
                Self(S::$vector::splat(instructions, 0.0))
            }
        }

        impl<S: Simd> Neg for $wide<S> {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl<S: Simd> Lane for $wide<S> {
            type Real = $number;
            type Mask = $mask<S>;
            const WIDTH: usize = S::$vector::LEN;

            #[inline(always)]
            fn within<T>(self, work: impl FnOnce() -> T) -> T {
                self.0.token().vectorize(work)
            }

            #[inline(always)]
            fn like(self, x: $number) -> Self {
                Self(S::$vector::splat(self.0.token(), x))
            }

            #[inline(always)]
            fn load(self, numbers: &[$number]) -> Self {
                Self(S::$vector::from_slice(self.0.token(), numbers))
            }

            #[inline(always)]
            fn store(self, to: &mut [$number]) {
                self.0.store_slice(to);
            }

            #[inline(always)]
            fn of(self, i: usize) -> $number {
                self.0[i]
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.sqrt())
            }

            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs())
            }

            #[inline(always)]
            fn at_most(self, other: Self) -> Self::Mask {
                $mask(self.0.simd_le(other.0))
            }

            #[inline(always)]
            fn less(self, other: Self) -> Self::Mask {
                $mask(self.0.simd_lt(other.0))
            }

            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                Self(mask.0.select(yes.0, no.0))
            }

            #[cold]
            fn difference_of_products(a: Self, b: Self, c: Self, d: Self) -> Self {
                let mut numbers = [0.0; WIDEST];
                for (i, number) in numbers[..Self::WIDTH].iter_mut().enumerate() {
                    *number = <$number as Real>::difference_of_products(a.of(i), b.of(i), c.of(i), d.of(i));
                }
                a.load(&numbers[..Self::WIDTH])
            }
        }

        impl<S: Simd> BitAnd for $mask<S> {
            type Output = Self;

            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                Self(self.0 & other.0)
            }
        }

        impl<S: Simd> BitOr for $mask<S> {
            type Output = Self;

            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }

        impl<S: Simd> Not for $mask<S> {
            type Output = Self;

            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }

        impl<S: Simd> Mask for $mask<S> {
            #[inline(always)]
            fn any(self) -> bool {
                self.0.any_true()
            }

            #[inline(always)]
            fn all(self) -> bool {
                self.0.all_true()
            }

            #[inline(always)]
            fn bits(self) -> u64 {
                self.0.to_bitmask()
            }
        }
    };
}

register!(Singles, SinglesMask, f32, f32s);
register!(Doubles, DoublesMask, f64, f64s);
