//! Fourier transforms by rustfft and realfft, for the number types that the engine uses.
//!
//! The planners of both libraries are generic: every crate that calls one compiles all kernels again, which takes longer than the
//! whole lens tracer. The functions of this crate are not generic, so the kernels are compiled once.

use std::sync::Arc;

pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::Fft;
pub use rustfft::num_complex::Complex;

/// A transform of `length` complex f32 values. Nothing is normalised: forward and back together multiply by `length`.
pub fn complex_f32(length: usize, direction: Direction) -> Arc<dyn Fft<f32>> {
    rustfft::FftPlanner::new().plan_fft(length, direction.into())
}

/// A transform of `length` complex f64 values. Nothing is normalised: forward and back together multiply by `length`.
pub fn complex_f64(length: usize, direction: Direction) -> Arc<dyn Fft<f64>> {
    rustfft::FftPlanner::new().plan_fft(length, direction.into())
}

/// A forward transform of `length` real values into the `length / 2 + 1` frequencies from zero to the Nyquist frequency; the others are
/// their conjugates.
pub fn real_f32(length: usize) -> Arc<dyn RealToComplex<f32>> {
    realfft::RealFftPlanner::new().plan_fft_forward(length)
}

/// The inverse transform of [`real_f32`]. Nothing is normalised: the two together multiply by `length`.
pub fn real_back_f32(length: usize) -> Arc<dyn ComplexToReal<f32>> {
    realfft::RealFftPlanner::new().plan_fft_inverse(length)
}

/// Direction of a transform: the sign of the exponent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The transform to frequencies: exp(−2πi j k / n).
    Forward,
    /// Back from frequencies: exp(2πi j k / n), not divided by n.
    Back,
}

impl From<Direction> for rustfft::FftDirection {
    fn from(direction: Direction) -> Self {
        match direction {
            Direction::Forward => Self::Forward,
            Direction::Back => Self::Inverse,
        }
    }
}
