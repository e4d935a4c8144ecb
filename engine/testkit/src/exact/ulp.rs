//! Errors in units in the last place.

use super::big::{Big, Vector, norm, times_power_of_two};

/// The numbers that a tracer calculates in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Single: 24 bits.
    F32,
    /// Double: 53 bits.
    F64,
}

impl Precision {
    /// Bits of the significand.
    pub fn bits(self) -> i32 {
        match self {
            Self::F32 => f32::MANTISSA_DIGITS as i32,
            Self::F64 => f64::MANTISSA_DIGITS as i32,
        }
    }

    /// The exponent of the smallest number above 0, which is the least unit in the last place.
    fn least(self) -> i32 {
        match self {
            Self::F32 => f32::MIN_EXP - f32::MANTISSA_DIGITS as i32,
            Self::F64 => f64::MIN_EXP - f64::MANTISSA_DIGITS as i32,
        }
    }

    /// The exponent of the unit in the last place of numbers of `exponent` e, 2^(e − 1) ≤ |x| < 2^e.
    fn ulp_exponent(self, exponent: Option<i32>) -> i32 {
        exponent.map_or(self.least(), |e| (e - self.bits()).max(self.least()))
    }
}

/// The unit in the last place of x; 0 for x = 0, which no relative change moves.
pub fn ulp_of(x: f64, precision: Precision) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return 0.0;
    }
    times_power_of_two(1.0, precision.ulp_exponent(Big::new(x).exponent()))
}

/// |got − truth| in units in the last place of the truth as an `f64`; infinite if `got` is not finite.
pub fn ulp_error_f64(got: f64, truth: &Big) -> f64 {
    scalar(got, truth, Precision::F64)
}

/// |got − truth| in units in the last place of the truth as an `f32`; infinite if `got` is not finite.
pub fn ulp_error_f32(got: f32, truth: &Big) -> f64 {
    scalar(f64::from(got), truth, Precision::F32)
}

/// |got − truth| in units in the last place of the `f64` |truth|; infinite if a component is not finite.
///
/// The measure for directions and for points: a component near 0 need not be right to its own last place.
pub fn ulp_error_vector_f64(got: [f64; 3], truth: &Vector) -> f64 {
    difference(got, truth).map_or(f64::INFINITY, |error| in_ulps(&error, &norm(truth), Precision::F64))
}

/// [`ulp_error_vector_f64`] in units of the `f32` |truth|.
pub fn ulp_error_vector_f32(got: [f32; 3], truth: &Vector) -> f64 {
    let got = got.map(f64::from);
    difference(got, truth).map_or(f64::INFINITY, |error| in_ulps(&error, &norm(truth), Precision::F32))
}

/// |got − truth|, in the unit of the vectors; infinite if a component is not finite.
pub fn error_norm(got: [f64; 3], truth: &Vector) -> f64 {
    difference(got, truth).map_or(f64::INFINITY, |error| error.to_f64())
}

fn scalar(got: f64, truth: &Big, precision: Precision) -> f64 {
    if !got.is_finite() {
        return f64::INFINITY;
    }
    in_ulps(&(Big::new(got) - truth).abs(), truth, precision)
}

fn in_ulps(error: &Big, truth: &Big, precision: Precision) -> f64 {
    error.times_power_of_two(-precision.ulp_exponent(truth.exponent())).to_f64()
}

fn difference(got: [f64; 3], truth: &Vector) -> Option<Big> {
    let is_finite = got.iter().all(|x| x.is_finite());
    is_finite.then(|| norm(&[0, 1, 2].map(|i| Big::new(got[i]) - &truth[i])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_neighbour_is_one_ulp_off() {
        for x in [1.0, 1.75, -3e-5, 6e20, 1e-310] {
            assert_eq!(ulp_error_f64(x, &Big::new(x)), 0.0);
            assert_eq!(ulp_error_f64(x.next_up(), &Big::new(x)), 1.0);
            assert_eq!(ulp_of(x, Precision::F64), x.abs().next_up() - x.abs());
        }
        let third = Big::new(1.0) / Big::new(3.0);
        assert!(ulp_error_f64(1.0 / 3.0, &third) <= 0.5);
        assert!(ulp_error_f32(1.0 / 3.0, &third) <= 0.5);
        assert_eq!(ulp_error_f32(1.0f32.next_up(), &Big::new(1.0)), 1.0);
        assert_eq!(ulp_error_f64(f64::NAN, &third), f64::INFINITY);
    }

    #[test]
    fn vectors_are_measured_by_their_length() {
        let truth = [1e-30, 0.0, 1.0].map(Big::new);
        assert_eq!(ulp_error_vector_f64([0.0, 0.0, 1.0 + f64::EPSILON], &truth), 1.0);
        assert!(ulp_error_vector_f64([0.0, 0.0, 1.0], &truth) < 1e-13);
        assert!((error_norm([3.0, 4.0, 1.0], &truth) - 5.0).abs() < 1e-15);
        assert_eq!(ulp_error_vector_f32([f32::NAN, 0.0, 1.0], &truth), f64::INFINITY);
    }
}
