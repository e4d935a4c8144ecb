//! Shared parts of the tests of Petzval, on plain numbers: it knows nothing of the engine that it judges.
//!
//! [`sampling`] tests that samples follow the density that is said of them, by [`chi_square`], and means. [`exact`] traces a ray through one
//! surface in 320-bit numbers, and [`hard_rays`] generates the rays that are worth it. [`half_space`] knows the light of deep media. [`lenses`] lists
//! lens files, and [`is_thorough`] is true
//! if a test takes all of its cases.

// A comparison that NaN fails, written `!(x >= 0.0)`, is how a number that is none ends as a failure.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod chi_square;
pub mod exact;
pub mod half_space;
pub mod hard_rays;
pub mod lenses;
pub mod sampling;

/// True where tests take their full numbers of cases: the environment variable `PETZVAL_TEST_ALL` is set, as by `make test-all`.
pub fn is_thorough() -> bool {
    std::env::var_os("PETZVAL_TEST_ALL").is_some()
}
