//! The monomials of four variables to the fourth degree, and where their products stand.

/// Number of variables.
pub const VARIABLES: usize = 4;
/// The highest degree of a monomial.
const HIGHEST: usize = 4;
/// Number of monomials of at most the highest degree.
const ALL: usize = 70;

/// Number of monomials of at most `degree`: 1, 5, 15, 35, 70.
pub const COUNTS: [usize; HIGHEST + 1] = [1, 5, 15, 35, ALL];

/// The monomials by rising degree: a polynomial of a lower order is the beginning of one of a higher.
pub(super) struct Monomials {
    /// Powers of the variables.
    pub(super) powers: [[u8; VARIABLES]; ALL],
    /// Sum of the powers.
    pub(super) degree: [u8; ALL],
    /// True if no power is odd: such a monomial lies in 0 to 1, another in −1 to 1.
    pub(super) is_even: [bool; ALL],
    /// Index of the product of two monomials whose degrees together are at most the highest.
    pub(super) product: [[u8; ALL]; ALL],
}

/// The one table.
pub(super) static MONOMIALS: Monomials = Monomials::new();

impl Monomials {
    const fn new() -> Self {
        let mut all =
            Self { powers: [[0; VARIABLES]; ALL], degree: [0; ALL], is_even: [true; ALL], product: [[0; ALL]; ALL] };
        let mut count = 0;
        let mut degree = 0;
        while degree <= HIGHEST {
            // All words of powers in base 5, the sum of which is the degree.
            let mut code = 5usize.pow(VARIABLES as u32);
            while code > 0 {
                code -= 1;
                let (mut rest, mut sum, mut powers, mut is_even) = (code, 0, [0; VARIABLES], true);
                let mut i = VARIABLES;
                while i > 0 {
                    i -= 1;
                    powers[i] = (rest % 5) as u8;
                    is_even = is_even && rest % 5 % 2 == 0;
                    sum += rest % 5;
                    rest /= 5;
                }
                if sum == degree {
                    all.powers[count] = powers;
                    all.degree[count] = degree as u8;
                    all.is_even[count] = is_even;
                    count += 1;
                }
            }
            degree += 1;
        }
        all.with_products()
    }

    const fn with_products(mut self) -> Self {
        let mut i = 0;
        while i < ALL {
            let mut j = 0;
            while j < ALL {
                if self.degree[i] as usize + self.degree[j] as usize <= HIGHEST {
                    let mut powers = self.powers[i];
                    let mut v = 0;
                    while v < VARIABLES {
                        powers[v] += self.powers[j][v];
                        v += 1;
                    }
                    self.product[i][j] = self.place(powers) as u8;
                }
                j += 1;
            }
            i += 1;
        }
        self
    }

    /// Index of the monomial with these powers, whose sum is at most the highest degree.
    pub(super) const fn place(&self, powers: [u8; VARIABLES]) -> usize {
        let mut i = 0;
        while i < ALL {
            let [a, b, c, d] = self.powers[i];
            if a == powers[0] && b == powers[1] && c == powers[2] && d == powers[3] {
                return i;
            }
            i += 1;
        }
        ALL
    }
}

/// The order of polynomials of `count` coefficients.
pub(super) const fn order(count: usize) -> usize {
    let mut order = 0;
    while order < HIGHEST && COUNTS[order] < count {
        order += 1;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_are_all_there_by_degree() {
        for (i, degree) in MONOMIALS.degree.iter().enumerate() {
            assert!(i == 0 || MONOMIALS.degree[i - 1] <= *degree);
            assert_eq!(MONOMIALS.place(MONOMIALS.powers[i]), i);
        }
        for (degree, count) in COUNTS.iter().enumerate() {
            assert_eq!(MONOMIALS.degree.iter().filter(|d| usize::from(**d) <= degree).count(), *count);
            assert_eq!(order(*count), degree);
        }
        // The variables, in their order, follow the constant.
        assert_eq!(MONOMIALS.powers[1..5], [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
    }
}
