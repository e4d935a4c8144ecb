//! Numbers of 320 bits, and vectors of three of them.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use astro_float_num::{BigFloat, Consts, Radix, RoundingMode, Sign};

/// Bits of every result: 96 digits. The worst of the hard rays lose some 50 to cancellation.
pub const PRECISION_BITS: usize = 320;

const ROUNDING: RoundingMode = RoundingMode::ToEven;

/// A binary floating-point number of [`PRECISION_BITS`] bits.
///
/// + − × ÷ round to nearest; [`Big::sqrt`] is right to the last bit or two.
#[derive(Clone, Debug)]
pub struct Big(BigFloat);

impl Big {
    /// Exactly `x`, which must be finite.
    pub fn new(x: f64) -> Self {
        debug_assert!(x.is_finite());
        if x.is_subnormal() {
            // `BigFloat::from_f64` of astro-float-num 0.3.7 halves these.
            return Self(BigFloat::from_f64(x * 2f64.powi(200), PRECISION_BITS)).times_power_of_two(-200);
        }
        Self(BigFloat::from_f64(x, PRECISION_BITS))
    }

    /// The number nearest to a decimal such as `-1.25e-3`; `None` if `text` is none.
    pub fn parse(text: &str) -> Option<Self> {
        let mut constants = Consts::new().ok()?;
        let number = BigFloat::parse(text, Radix::Dec, PRECISION_BITS, ROUNDING, &mut constants);
        (!number.is_nan() && !number.is_inf()).then_some(Self(number))
    }

    /// The `f64` nearest to the number, infinite beyond their range. Subnormal results may be one unit off.
    pub fn to_f64(&self) -> f64 {
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else { return f64::NAN };
        let Some((&top, rest)) = words.split_last() else { return 0.0 };
        // A last bit that stands for all that follow makes the conversion of the top word round as the whole would.
        let sticky = u64::from(rest.iter().any(|word| *word != 0));
        let magnitude = times_power_of_two((top | sticky) as f64, exponent.saturating_sub(64));
        if sign == Sign::Neg { -magnitude } else { magnitude }
    }

    /// The exponent e with 2^(e − 1) ≤ |x| < 2^e; `None` for 0.
    pub fn exponent(&self) -> Option<i32> {
        if self.is_zero() { None } else { self.0.exponent() }
    }

    /// x 2^`power`, exactly.
    pub fn times_power_of_two(&self, power: i32) -> Self {
        let mut result = self.clone();
        if let Some(exponent) = self.exponent() {
            result.0.set_exponent(exponent.saturating_add(power));
        }
        result
    }

    /// The square root; 0 for numbers below 0.
    pub fn sqrt(&self) -> Self {
        let Some(exponent) = self.exponent().filter(|_| self.is_positive()) else { return Self::new(0.0) };
        // x = y 4^half with y in [1/4, 1).
        let half = exponent.div_euclid(2) + exponent.rem_euclid(2);
        let y = self.times_power_of_two(-2 * half);
        // Newton for 1 / √y doubles the digits of a machine number twice; the last step is that for √y itself.
        let mut inverse = Self::new(1.0 / y.to_f64().sqrt());
        let one = Self::new(1.0);
        for bits in [128, 256] {
            let square = inverse.0.mul(&inverse.0, bits, ROUNDING);
            let error = one.0.sub(&square.mul(&y.0, bits, ROUNDING), bits, ROUNDING);
            let step = Self(error.mul(&inverse.0, bits, ROUNDING)).times_power_of_two(-1);
            inverse = Self(inverse.0.add(&step.0, bits, ROUNDING));
        }
        let root = &y * &inverse;
        let step = ((&y - &root * &root) * &inverse).times_power_of_two(-1);
        (root + step).times_power_of_two(half)
    }

    /// |x|.
    pub fn abs(&self) -> Self {
        if self.is_negative() { -self } else { self.clone() }
    }

    /// x²
    pub fn squared(&self) -> Self {
        self * self
    }

    /// True for 0 alone.
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// True if x < 0.
    pub fn is_negative(&self) -> bool {
        self.0.is_negative() && !self.is_zero()
    }

    /// True if x > 0.
    pub fn is_positive(&self) -> bool {
        self.0.is_positive() && !self.is_zero()
    }
}

/// x 2^power, which one factor could not do at the ends of the range.
pub(super) fn times_power_of_two(x: f64, power: i32) -> f64 {
    let power = power.clamp(-2200, 2200);
    let third = power / 3;
    x * 2f64.powi(third) * 2f64.powi(third) * 2f64.powi(power - 2 * third)
}

impl PartialEq for Big {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Big {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.0.cmp(&other.0).map(|order| order.cmp(&0))
    }
}

impl From<f64> for Big {
    fn from(x: f64) -> Self {
        Self::new(x)
    }
}

impl Neg for &Big {
    type Output = Big;
    fn neg(self) -> Big {
        -self.clone()
    }
}

impl Neg for Big {
    type Output = Big;
    fn neg(mut self) -> Big {
        self.0.inv_sign();
        self
    }
}

/// Operators for values and references in every pairing: formulae stay readable.
macro_rules! operator {
    ($operation:ident, $name:ident) => {
        impl $operation<&Big> for &Big {
            type Output = Big;
            fn $name(self, other: &Big) -> Big {
                Big(self.0.$name(&other.0, PRECISION_BITS, ROUNDING))
            }
        }
        impl $operation<Big> for &Big {
            type Output = Big;
            fn $name(self, other: Big) -> Big {
                self.$name(&other)
            }
        }
        impl $operation<&Big> for Big {
            type Output = Big;
            fn $name(self, other: &Big) -> Big {
                (&self).$name(other)
            }
        }
        impl $operation<Big> for Big {
            type Output = Big;
            fn $name(self, other: Big) -> Big {
                (&self).$name(&other)
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

/// Three numbers: a point in mm, or a direction.
pub type Vector = [Big; 3];

/// a · b.
pub fn dot(a: &Vector, b: &Vector) -> Big {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// |v|.
pub fn norm(v: &Vector) -> Big {
    dot(v, v).sqrt()
}

/// The nearest `f64` of each number.
pub fn to_f64(v: &Vector) -> [f64; 3] {
    [v[0].to_f64(), v[1].to_f64(), v[2].to_f64()]
}

/// Exactly the vector of `f64`s.
pub(super) fn vector(v: [f64; 3]) -> Vector {
    v.map(Big::new)
}

/// v + w x.
pub(super) fn plus_times(v: &Vector, w: &Vector, x: &Big) -> Vector {
    [&v[0] + &w[0] * x, &v[1] + &w[1] * x, &v[2] + &w[2] * x]
}

/// v x.
pub(super) fn times(v: &Vector, x: &Big) -> Vector {
    [&v[0] * x, &v[1] * x, &v[2] * x]
}

/// v / |v|.
pub(super) fn unit(v: &Vector) -> Vector {
    let length = norm(v);
    [&v[0] / &length, &v[1] / &length, &v[2] / &length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_squared_give_the_number_back() {
        for x in [2.0, 3.0, 0.1, 1e-300, 7e250, 0.25, 0.5, 1.0 - 1e-16] {
            let x = Big::new(x);
            let error = (x.sqrt().squared() - &x).abs() / &x;
            assert!(error < Big::new(2f64.powi(-317)), "{x:?}");
        }
        for whole in [0.0, 1.0, 4.0, 9.0, 1e100] {
            assert_eq!(Big::new(whole).squared().sqrt(), Big::new(whole));
        }
    }

    #[test]
    fn decimals_and_machine_numbers_come_through() {
        for x in [0.0, 1.0, -1.5, 1e-300, -4e307, 0.1, f64::MAX, f64::MIN_POSITIVE, 3e-310, 5e-324] {
            assert_eq!(Big::new(x).to_f64(), x);
            assert_eq!(Big::parse(&format!("{x:e}")).unwrap().to_f64(), x);
        }
        // Half-way between two machine numbers, and a little above it.
        let tie = Big::new(1.0) + Big::new(2f64.powi(-53));
        assert_eq!(tie.to_f64(), 1.0);
        assert_eq!((tie + Big::new(2f64.powi(-250))).to_f64(), 1.0 + f64::EPSILON);
        assert!(Big::parse("none").is_none());
    }

    #[test]
    fn numbers_are_ordered() {
        assert!(Big::new(-1.0) < Big::new(0.0) && Big::new(2.0) > Big::new(1.5));
        assert!(!Big::new(0.0).is_negative() && !Big::new(-0.0).is_negative() && !Big::new(0.0).is_positive());
    }
}
