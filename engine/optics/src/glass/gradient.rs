//! A medium whose index changes from place to place: a polynomial of the way along the axis and the distance from it.

use crate::first_order::Matrix;

/// The highest power of z, and of r, that a term may have.
pub const LAST_GRADIENT_POWER: u32 = 24;
/// Places at which the paraxial way through is first taken; doubled until the matrix stands still.
const FIRST_STEPS: u32 = 64;
const MOST_STEPS: u32 = 1 << 16;
/// The matrix stands still when its parts change by less than this, relative to their size.
const STILL: f64 = 1e-14;

/// One term of a [`Gradient`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientTerm {
    /// Power of z, the way along the axis.
    pub z: u32,
    /// Power of r, the distance from the axis; even.
    pub r: u32,
    /// The coefficient in mm^−(z + r).
    pub coefficient: f64,
}

/// The index gradient of a medium, which is added to its index at a place: Σ a z^i r^2j, lengths in mm.
///
/// r is the distance from the axis of the surface that the medium follows, z the way along that axis from the place where
/// z is 0. Every wavelength is given the same: of Liou and Brennan's eye (J. Opt. Soc. Am. A 14, 1684, 1997) all media
/// have one dispersion.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    terms: Vec<GradientTerm>,
    from_mm: f64,
}

impl Gradient {
    /// The gradient of terms, none of power 0 in both, z being 0 at `from_mm` behind the vertex of the surface that the medium follows.
    /// `None` if a number is not finite, a power of r odd, a power too high or there twice, or there is no term.
    pub fn new(mut terms: Vec<GradientTerm>, from_mm: f64) -> Option<Self> {
        terms.sort_by_key(|term| (term.r, term.z));
        let powers = |term: &GradientTerm| (term.z, term.r);
        let is_term = |term: &GradientTerm| {
            let is_power = term.z <= LAST_GRADIENT_POWER && term.r <= LAST_GRADIENT_POWER && term.r.is_multiple_of(2);
            is_power && term.z + term.r > 0 && term.coefficient.is_finite()
        };
        let is_good = !terms.is_empty() && from_mm.is_finite() && terms.iter().all(is_term);
        let is_twice = terms.windows(2).any(|two| powers(&two[0]) == powers(&two[1]));
        (is_good && !is_twice).then_some(Self { terms, from_mm })
    }

    /// The terms, by rising powers of r and then of z.
    pub fn terms(&self) -> &[GradientTerm] {
        &self.terms
    }

    /// Distance of the place where z is 0 behind the vertex that the medium is seen from.
    pub fn from_mm(&self) -> f64 {
        self.from_mm
    }

    /// The gradient of this medium in a lens `factor` times as large.
    pub fn scaled(&self, factor: f64) -> Self {
        let smaller = |term: &GradientTerm| GradientTerm {
            coefficient: term.coefficient / factor.powi((term.z + term.r) as i32),
            ..*term
        };
        Self { terms: self.terms.iter().map(smaller).collect(), from_mm: self.from_mm * factor }
    }

    /// The gradient of this medium seen from a vertex `behind_mm` farther along the axis.
    pub fn seen_from(&self, behind_mm: f64) -> Self {
        Self { terms: self.terms.clone(), from_mm: self.from_mm - behind_mm }
    }

    /// The addition to the index on the axis, `z_mm` behind the vertex, and the coefficient of r² in mm⁻².
    pub fn on_axis(&self, z_mm: f64) -> [f64; 2] {
        let z = z_mm - self.from_mm;
        let of_power = |r: u32| -> f64 {
            let these = self.terms.iter().filter(|term| term.r == r);
            these.map(|term| term.coefficient * z.powi(term.z as i32)).sum()
        };
        [of_power(0), of_power(2)]
    }

    /// Coefficients by powers of r², each by powers of z, as far as there are some.
    pub(crate) fn rows(&self) -> Vec<Vec<f64>> {
        let count = self.terms.iter().map(|term| term.r / 2 + 1).max().unwrap_or(0);
        let mut rows = vec![Vec::new(); count as usize];
        for term in &self.terms {
            let row: &mut Vec<f64> = &mut rows[term.r as usize / 2];
            row.resize(row.len().max(term.z as usize + 1), 0.0);
            row[term.z as usize] = term.coefficient;
        }
        rows
    }

    /// First-order optics between the vertex that the medium is seen from and a plane `thickness_mm` (signed) behind it: the matrix, and
    /// the part of the Petzval sum. `base` is the signed index where all terms are 0.
    ///
    /// There n = n₀(z) + n₂(z) r², and y′ = ν / n₀, ν′ = 2 n₂ y (Sands, J. Opt. Soc. Am. 60, 1436, 1970). A layer has the
    /// power −2 n₂ dz and adds it over n₀² to the sum.
    pub(crate) fn paraxial(&self, base: f64, thickness_mm: f64) -> (Matrix, f64) {
        let mut found = self.stepped(base, thickness_mm, FIRST_STEPS);
        let mut steps = FIRST_STEPS;
        while steps < MOST_STEPS {
            steps *= 2;
            let finer = self.stepped(base, thickness_mm, steps);
            let (a, b) = (parts(&found), parts(&finer));
            let is_still = a.iter().zip(b).all(|(a, b)| (a - b).abs() <= STILL * b.abs().max(1.0));
            found = finer;
            if is_still {
                break;
            }
        }
        found
    }

    /// Runge and Kutta's method for both rays that the matrix is made of; Simpson's rule for the sum.
    fn stepped(&self, base: f64, thickness_mm: f64, steps: u32) -> (Matrix, f64) {
        let sign = base.signum();
        let at = |z: f64| self.on_axis(z).map(|part| part * sign);
        let h = thickness_mm / f64::from(steps);
        let rate = |[n, n2]: [f64; 2], [y, nu]: [f64; 2]| [nu / (base + n), 2.0 * n2 * y];
        let petzval = |[n, n2]: [f64; 2]| -2.0 * n2 / (base + n).powi(2);
        let mut rays = [[1.0, 0.0], [0.0, 1.0]];
        let mut sum = 0.0;
        let mut here = at(0.0);
        for i in 0..steps {
            let z = h * f64::from(i);
            let (middle, there) = (at(z + 0.5 * h), at(z + h));
            sum += h / 6.0 * (petzval(here) + 4.0 * petzval(middle) + petzval(there));
            for ray in &mut rays {
                let moved = |by: [f64; 2], h: f64| [ray[0] + h * by[0], ray[1] + h * by[1]];
                let k1 = rate(here, *ray);
                let k2 = rate(middle, moved(k1, 0.5 * h));
                let k3 = rate(middle, moved(k2, 0.5 * h));
                let k4 = rate(there, moved(k3, h));
                let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
                *ray = moved([mean(0), mean(1)], h);
            }
            here = there;
        }
        let [[a, c], [b, d]] = rays;
        (Matrix { a, b, c, d }, sum)
    }
}

fn parts((matrix, petzval): &(Matrix, f64)) -> [f64; 5] {
    [matrix.a, matrix.b, matrix.c, matrix.d, *petzval]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn term(z: u32, r: u32, coefficient: f64) -> GradientTerm {
        GradientTerm { z, r, coefficient }
    }

    /// A rod n₀ − a r²: with g² = 2 a / n₀ the matrix is that of a spring, cos and sin of g L.
    #[test]
    fn a_rod_is_a_spring() {
        let (n, g) = (1.6, 0.3f64);
        let rod = Gradient::new(vec![term(0, 2, -0.5 * n * g * g)], 0.0).unwrap();
        for length in [0.1, 2.0, 40.0] {
            let (matrix, petzval) = rod.paraxial(n, length);
            let (sin, cos) = (g * length).sin_cos();
            let expected = [cos, sin / (n * g), -n * g * sin, cos, g * g * length / n];
            for (found, expected) in parts(&(matrix, petzval)).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0), "{length}: {found} {expected}");
            }
        }
    }

    /// An index that only rises along the axis: y′ = ∫ dz / n, ν as it was.
    #[test]
    fn layers_across_the_axis_only_shift() {
        let layers = Gradient::new(vec![term(1, 0, 0.1)], -0.5).unwrap();
        let (matrix, petzval) = layers.paraxial(1.4, 3.0);
        let expected = ((1.4 + 0.35) / (1.4 + 0.05f64)).ln() / 0.1;
        assert!((matrix.b - expected).abs() < 1e-12 && matrix.c == 0.0 && petzval == 0.0, "{matrix:?} {expected}");
        // Seen from elsewhere it is the same medium.
        assert_eq!(layers.seen_from(1.0).on_axis(1.0), layers.on_axis(2.0));
        let doubled = layers.scaled(2.0).on_axis(2.0)[0];
        assert!((doubled - layers.on_axis(1.0)[0]).abs() < 1e-15);
    }

    #[test]
    fn terms_that_make_no_gradient() {
        assert!(Gradient::new(vec![], 0.0).is_none());
        assert!(Gradient::new(vec![term(0, 0, 1.0)], 0.0).is_none());
        assert!(Gradient::new(vec![term(0, 3, 1.0)], 0.0).is_none());
        assert!(Gradient::new(vec![term(1, 0, 1.0), term(1, 0, 2.0)], 0.0).is_none());
        assert!(Gradient::new(vec![term(1, 0, f64::NAN)], 0.0).is_none());
        assert!(Gradient::new(vec![term(30, 0, 1.0)], 0.0).is_none());
    }
}
