//! Taylor models: a polynomial of four variables in −1 to 1, and a bound of the remainder.
//!
//! A model stands for a function f of the variables and says |f(ε) − P(ε)| ≤ `remainder` for all ε with |εᵢ| ≤ 1. With one
//! coefficient it is an interval by its middle and its half width. Numbers are rounded to nearest, so nothing depends on the
//! processor's rounding modes: the bound of the rounding error is added to `remainder`. Each bound below is proved in its comment, with
//! u = 2⁻⁵³, from |fl(a ∘ b) − a ∘ b| ≤ u |a ∘ b| where there is no underflow.
//!
//! A model that means nothing has a remainder that is infinite or NaN; every comparison is written so that it then proves nothing.

use std::ops::{Add, Mul, Neg, Sub};

use crate::table::{COUNTS, MONOMIALS, VARIABLES, order};

/// u = 2⁻⁵³, half of a unit in the last place of 1.
const ROUNDING: f64 = f64::EPSILON / 2.0;

/// Factor that makes a sum of less than 400 non-negative terms, each a product of a few factors, an upper bound of the exact sum: its
/// relative error is below 512 u.
const UPWARDS: f64 = 1.0 + 1024.0 * ROUNDING;

/// Added to every remainder: more than 10 000 products can lose by underflow, 2⁻¹⁰⁷⁵ each.
const UNDERFLOW: f64 = 1e-300;

/// A polynomial of `N` coefficients (1, 5, 15, 35 or 70: order 0 to 4) and the bound of the difference from it.
#[derive(Clone, Copy, Debug)]
pub struct Taylor<const N: usize> {
    coefficients: [f64; N],
    remainder: f64,
}

/// The bounds of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// No value is below it.
    pub low: f64,
    /// No value is above it.
    pub high: f64,
}

impl Bounds {
    /// True if all values are above `x`; not if a bound is NaN.
    pub fn is_above(&self, x: f64) -> bool {
        self.low > x
    }

    /// True if all values are below `x`; not if a bound is NaN.
    pub fn is_below(&self, x: f64) -> bool {
        self.high < x
    }

    /// True if `x` is not outside.
    pub fn holds(&self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }
}

impl<const N: usize> Taylor<N> {
    /// The highest degree of the polynomial.
    const ORDER: usize = order(N);

    /// Exactly `x`.
    pub fn constant(x: f64) -> Self {
        let mut coefficients = [0.0; N];
        coefficients[0] = x;
        Self { coefficients, remainder: 0.0 }
    }

    /// All numbers within `half` of `middle`, of which nothing more is known.
    pub fn within(middle: f64, half: f64) -> Self {
        Self { remainder: half, ..Self::constant(middle) }
    }

    /// `middle` + `half` εᵢ, i = `variable` below 4. Of order 0: an interval.
    pub fn variable(middle: f64, half: f64, variable: usize) -> Self {
        let mut all = Self::constant(middle);
        match N {
            1 => all.remainder = half.abs(),
            _ => all.coefficients[1 + variable.min(VARIABLES - 1)] = half,
        }
        all
    }

    /// The polynomial with these coefficients of monomials, given by their powers; exact. Monomials above the order go to the remainder.
    pub fn polynomial<'a>(terms: impl IntoIterator<Item = (&'a [u8; VARIABLES], f64)>) -> Self {
        let mut all = Self::constant(0.0);
        for (powers, value) in terms {
            let place = MONOMIALS.place(*powers);
            match all.coefficients.get_mut(place) {
                Some(coefficient) => *coefficient = value,
                None => all.remainder = (all.remainder + value.abs()) * UPWARDS,
            }
        }
        all
    }

    /// The polynomial's constant term: the value at ε = 0 but for the remainder.
    pub fn middle(&self) -> f64 {
        self.coefficients[0]
    }

    /// The polynomial's terms: powers of the variables and coefficient.
    pub fn terms(&self) -> impl Iterator<Item = ([u8; VARIABLES], f64)> {
        self.coefficients.iter().zip(&MONOMIALS.powers).map(|(c, powers)| (*powers, *c))
    }

    /// The coefficients, by rising degree.
    pub(super) fn coefficients(&self) -> &[f64; N] {
        &self.coefficients
    }

    /// The bound of the difference between the function and the polynomial.
    pub fn remainder(&self) -> f64 {
        self.remainder
    }

    /// The value of the polynomial at `at`, in f64; the rounding error is below [`Self::evaluation_error`].
    pub fn value(&self, at: &[f64; VARIABLES]) -> f64 {
        let mut powers = [1.0; N];
        let mut sum = 0.0;
        for i in 0..N {
            if i > 0 {
                // Each monomial is one of a lower degree times a variable.
                let word = MONOMIALS.powers[i];
                let v = word.iter().position(|p| *p > 0).unwrap_or(0);
                let mut below = word;
                below[v] -= 1;
                powers[i] = powers[MONOMIALS.place(below)] * at[v];
            }
            sum += self.coefficients[i] * powers[i];
        }
        sum
    }

    /// Bound of the rounding of [`Self::value`]: each of N terms has at most 4 + 1 products, and N sums; (N + 5) u Σ|c| and some more.
    pub fn evaluation_error(&self) -> f64 {
        (N as f64 + 8.0) * ROUNDING * self.size() + UNDERFLOW
    }

    /// An upper bound of |f|.
    pub fn size(&self) -> f64 {
        (self.coefficients.iter().map(|c| c.abs()).sum::<f64>() + self.remainder) * UPWARDS
    }

    /// Sums of |coefficients| by degree.
    fn by_degree(&self) -> [f64; COUNTS.len()] {
        let mut sums = [0.0; COUNTS.len()];
        for (c, degree) in self.coefficients.iter().zip(&MONOMIALS.degree) {
            sums[usize::from(*degree)] += c.abs();
        }
        sums
    }

    /// Bounds of f: of each monomial alone, in 0 to 1 if all of its powers are even. The sums of one sign are rounded by 512 u of themselves,
    /// the two that lead to a bound by u of theirs.
    #[inline(never)]
    pub fn bounds(&self) -> Bounds {
        let (mut low, mut high) = (0.0, 0.0);
        for (c, is_even) in self.coefficients.iter().zip(&MONOMIALS.is_even).skip(1) {
            if *is_even {
                low += c.min(0.0);
                high += c.max(0.0);
            } else {
                low -= c.abs();
                high += c.abs();
            }
        }
        let slack = self.coefficients[0].abs() * 4.0 * ROUNDING
            + (high - low) * (UPWARDS - 1.0)
            + self.remainder * UPWARDS
            + UNDERFLOW;
        Bounds { low: self.coefficients[0] + low - slack, high: self.coefficients[0] + high + slack }
    }

    /// This model with `more` added to its remainder.
    pub fn widened(self, more: f64) -> Self {
        Self { remainder: (self.remainder + more) * UPWARDS, ..self }
    }

    /// The polynomial alone.
    fn without_rest(self) -> Self {
        Self { remainder: 0.0, ..self }
    }

    /// Rounding of a sum: each coefficient is off by u of itself at most.
    fn summed(coefficients: [f64; N], remainder: f64) -> Self {
        let rounded = coefficients.iter().map(|c| c.abs()).sum::<f64>() * ROUNDING;
        Self { coefficients, remainder: (remainder + rounded) * UPWARDS + UNDERFLOW }
    }

    /// f times 2^k or another number, each coefficient rounded once.
    pub fn times(&self, factor: f64) -> Self {
        Self::summed(self.coefficients.map(|c| c * factor), self.remainder * factor.abs())
    }

    /// f plus an exact number.
    pub fn plus(&self, x: f64) -> Self {
        let mut coefficients = self.coefficients;
        coefficients[0] += x;
        Self { coefficients, remainder: (self.remainder + coefficients[0].abs() * ROUNDING) * UPWARDS + UNDERFLOW }
    }

    /// f²
    pub fn squared(&self) -> Self {
        *self * *self
    }

    /// The product of two polynomials, cut off above the order and rounded as it comes.
    #[inline(never)]
    fn cut_product(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
        let mut product = [0.0; N];
        for (i, x) in a.iter().enumerate() {
            if *x == 0.0 {
                continue;
            }
            let left = Self::ORDER - usize::from(MONOMIALS.degree[i]);
            let row = &MONOMIALS.product[i];
            for (y, place) in b[..COUNTS[left]].iter().zip(&row[..COUNTS[left]]) {
                product[usize::from(*place)] += x * y;
            }
        }
        product
    }

    /// 1 / f; no number unless f is away from 0.
    ///
    /// P, by Newton's method on polynomials, may be any: with E ≥ |1 − f P| < 1, |1/f − P| = |P| |1 − f P| / |f P| ≤ |P| E / (1 − E).
    #[inline(never)]
    pub fn reciprocal(&self) -> Self {
        let mut inverse = [0.0; N];
        inverse[0] = 1.0 / self.coefficients[0];
        for _ in 0..Self::newton_steps() {
            let mut error = Self::cut_product(&self.coefficients, &inverse).map(|c| -c);
            error[0] += 2.0;
            inverse = Self::cut_product(&inverse, &error);
        }
        let guess = Self { coefficients: inverse, remainder: 0.0 };
        let error = (Self::constant(1.0) - *self * guess).size();
        // `1 - error` is rounded by u; UPWARDS and another factor take that.
        let remainder =
            if error < 0.5 { guess.size() * error / (1.0 - error) * UPWARDS * UPWARDS } else { f64::INFINITY };
        guess.widened(remainder)
    }

    /// √f; no number unless f is above 0.
    ///
    /// P may be any with P > 0: |√f − P| = |f − P²| / (√f + P).
    #[inline(never)]
    pub fn sqrt(&self) -> Self {
        let low = self.bounds().low;
        if !(low > 0.0) || !(self.coefficients[0] > 0.0) {
            return Self::within(0.0, f64::INFINITY);
        }
        let mut inverse = [0.0; N];
        inverse[0] = 1.0 / self.coefficients[0].sqrt();
        for _ in 0..Self::newton_steps() {
            let square = Self::cut_product(&inverse, &inverse);
            let mut error = Self::cut_product(&self.coefficients, &square).map(|c| -0.5 * c);
            error[0] += 1.5;
            inverse = Self::cut_product(&inverse, &error);
        }
        let guess = Self { coefficients: Self::cut_product(&self.coefficients, &inverse), remainder: 0.0 };
        let error = (*self - guess.squared()).size();
        let least = low.sqrt() * (1.0 - 4.0 * ROUNDING) + guess.bounds().low;
        if !(guess.bounds().low > 0.0) {
            return Self::within(0.0, f64::INFINITY);
        }
        guess.widened(error / least * UPWARDS * UPWARDS)
    }

    /// Steps of Newton's method that reach the order: each doubles the number of degrees that are right.
    fn newton_steps() -> usize {
        [0, 1, 2, 2, 3][Self::ORDER]
    }

    /// The model with the smaller remainder of two of the same function.
    pub fn or(self, other: Self) -> Self {
        if other.remainder < self.remainder || self.remainder.is_nan() { other } else { self }
    }
}

impl<const N: usize> Add for Taylor<N> {
    type Output = Self;
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        let mut coefficients = self.coefficients;
        for (a, b) in coefficients.iter_mut().zip(&other.coefficients) {
            *a += b;
        }
        Self::summed(coefficients, self.remainder + other.remainder)
    }
}

impl<const N: usize> Sub for Taylor<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Neg for Taylor<N> {
    type Output = Self;
    #[inline(never)]
    fn neg(self) -> Self {
        Self { coefficients: self.coefficients.map(|c| -c), remainder: self.remainder }
    }
}

/// The product.
///
/// With A, B the polynomials and a, b the remainders: |f g − A B| ≤ |A| b + |B| a + a b. Of A B the terms above the order go to the remainder by
/// their sizes. A coefficient of degree d is a sum of at most 2^d products, for a monomial of degree d has no more divisors, so
/// rounding takes at most 2^d u (1 + 2^d u) of the sum of their sizes.
impl<const N: usize> Mul for Taylor<N> {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let coefficients = Self::cut_product(&self.coefficients, &other.coefficients);
        let (a, b) = (self.by_degree(), other.by_degree());
        let (mut cut, mut rounded) = (0.0, 0.0);
        for (i, x) in a.iter().enumerate().take(Self::ORDER + 1) {
            for (j, y) in b.iter().enumerate().take(Self::ORDER + 1) {
                let size = x * y;
                if i + j > Self::ORDER { cut += size } else { rounded += size * f64::from(1u32 << (i + j)) }
            }
        }
        let (a, b) = (a.iter().sum::<f64>(), b.iter().sum::<f64>());
        let remainder =
            a * other.remainder + b * self.remainder + self.remainder * other.remainder + cut + rounded * ROUNDING;
        Self { coefficients, remainder: remainder * UPWARDS + UNDERFLOW }
    }
}

/// The quotient, by [`Taylor::reciprocal`].
impl<const N: usize> std::ops::Div for Taylor<N> {
    type Output = Self;
    #[inline]
    #[expect(clippy::suspicious_arithmetic_impl, reason = "a quotient is a product with the reciprocal")]
    fn div(self, other: Self) -> Self {
        self * other.reciprocal()
    }
}

impl<const N: usize> Taylor<N> {
    /// The polynomial near a root of `function`, by Newton's method on polynomials from `start`: nothing is proved of it.
    pub(super) fn near_root(start: Self, function: impl Fn(Self) -> (Self, Self), steps: usize) -> Self {
        let mut at = start.without_rest();
        for _ in 0..steps {
            let (value, slope) = function(at);
            at = (at - value / slope).without_rest();
        }
        at
    }
}
