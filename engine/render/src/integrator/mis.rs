//! Weights of multiple importance sampling (Veach 1997, section 9.2).

/// Weight of a sample of density `a` where another technique has density `b` (exponent 2).
#[inline]
pub(super) fn power_heuristic(a: f32, b: f32) -> f32 {
    if b == 0.0 {
        return 1.0;
    }
    // As a ratio: squares of large densities overflow.
    let r = b / a;
    1.0 / (1.0 + r * r)
}
