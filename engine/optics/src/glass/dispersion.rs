//! Dispersion, the dependence of the index of refraction on the wavelength: the formulas of the makers' catalogues.

/// The index as a function of the wavelength `l` in micrometres.
#[derive(Clone, Debug, PartialEq)]
pub enum Dispersion {
    /// An index that does not depend on the wavelength.
    Constant(f64),
    /// n² = 1 + a + Σ b l² / (l² − c), pairs (b, c).
    Sellmeier {
        /// The constant beside 1.
        a: f64,
        /// Pairs (b, c), c in µm².
        terms: Vec<[f64; 2]>,
    },
    /// n² = a + Σ b l^p, pairs (b, p).
    Polynomial {
        /// The constant term a of n².
        a: f64,
        /// Pairs (b, p), p a power of the wavelength in µm.
        terms: Vec<[f64; 2]>,
    },
    /// n² = a + Σ b l^p + Σ b l^p / (l² − c), pairs (b, p) and triples (b, p, c).
    Rational {
        /// The constant term a of n².
        a: f64,
        /// Pairs (b, p), p a power of the wavelength in µm.
        powers: Vec<[f64; 2]>,
        /// Triples (b, p, c), c in µm².
        poles: Vec<[f64; 3]>,
    },
    /// n = a + Σ b l^p, pairs (b, p).
    Cauchy {
        /// The constant term a of n.
        a: f64,
        /// Pairs (b, p), p a power of the wavelength in µm.
        terms: Vec<[f64; 2]>,
    },
    /// n = 1 + a + Σ b / (c − l⁻²), pairs (b, c).
    Gas {
        /// The constant beside 1.
        a: f64,
        /// (b, c in µm⁻²).
        terms: Vec<[f64; 2]>,
    },
    /// w = (l − l0) / (1 + alpha (l − l0)), n = n0 + v1 w + v2 w²: l0, alpha, n0, v1, v2.
    Buchdahl([f64; 5]),
    /// n = a + b L + c L² + d l² + e l⁴ + f l⁶ with L = 1 / (l² − 0.028) (Herzberger 1959).
    Herzberger([f64; 6]),
    /// (n² − 1) / (n² + 2) = a + b l² / (l² − c) + d l²: a, b, c, d.
    Retro([f64; 4]),
    /// n² = a + b / (l² − c) + d (l − e) / ((l − e)² + f).
    Exotic([f64; 6]),
    /// Measured indices, pairs (l, n) by rising l: between them a cubic in 1 / l² that turns only where they do.
    Table(Vec<[f64; 2]>),
    /// One over the index of the boxed formula: vacuum, relative to a gas.
    Reciprocal(Box<Dispersion>),
}

/// The constant in the denominator l² − 0.028 of Herzberger's formula, µm².
pub const HERZBERGER: f64 = 0.028;

impl Dispersion {
    /// The index at `l` µm.
    pub(crate) fn index(&self, l: f64) -> f64 {
        let squared = l * l;
        match self {
            Self::Constant(n) => *n,
            Self::Sellmeier { a, terms } => {
                let sum: f64 = terms.iter().map(|[b, c]| b * squared / (squared - c)).sum();
                (1.0 + a + sum).sqrt()
            }
            Self::Polynomial { a, terms } => (a + power_sum(terms, l)).sqrt(),
            Self::Rational { a, powers, poles } => {
                let sum: f64 = poles.iter().map(|&[b, p, c]| power_sum(&[[b, p]], l) / (squared - c)).sum();
                (a + power_sum(powers, l) + sum).sqrt()
            }
            Self::Cauchy { a, terms } => a + power_sum(terms, l),
            Self::Gas { a, terms } => {
                let sum: f64 = terms.iter().map(|[b, c]| b / (c - 1.0 / squared)).sum();
                1.0 + a + sum
            }
            Self::Buchdahl([l0, alpha, n0, v1, v2]) => {
                let w = (l - l0) / (1.0 + alpha * (l - l0));
                n0 + w * (v1 + v2 * w)
            }
            Self::Herzberger([a, b, c, d, e, f]) => {
                let x = 1.0 / (squared - HERZBERGER);
                a + x * (b + c * x) + squared * (d + squared * (e + squared * f))
            }
            Self::Retro([a, b, c, d]) => {
                let s = a + b * squared / (squared - c) + d * squared;
                ((1.0 + 2.0 * s) / (1.0 - s)).sqrt()
            }
            Self::Exotic([a, b, c, d, e, f]) => {
                let away = l - e;
                (a + b / (squared - c) + d * away / (away * away + f)).sqrt()
            }
            Self::Table(points) => interpolated(points, l),
            Self::Reciprocal(other) => 1.0 / other.index(l),
        }
    }

    /// The word for the formula and its numbers, as glass files have them; `None` for formulas that stand in none.
    pub fn words(&self) -> Option<(&'static str, Vec<f64>)> {
        let led = |a: &f64, pairs: &[[f64; 2]]| [&[*a], pairs.as_flattened()].concat();
        Some(match self {
            Self::Constant(n) => ("constant", vec![*n]),
            Self::Sellmeier { a, terms } => ("sellmeier", led(a, terms)),
            Self::Polynomial { a, terms } => ("polynomial", led(a, terms)),
            Self::Rational { a, powers, poles } => {
                let count = powers.len() as f64;
                ("rational", [&[*a, count], powers.as_flattened(), poles.as_flattened()].concat())
            }
            Self::Cauchy { a, terms } => ("cauchy", led(a, terms)),
            Self::Gas { a, terms } => ("gas", led(a, terms)),
            Self::Buchdahl(all) => ("buchdahl", all.to_vec()),
            Self::Herzberger(all) => ("herzberger", all.to_vec()),
            Self::Retro(all) => ("retro", all.to_vec()),
            Self::Exotic(all) => ("exotic", all.to_vec()),
            Self::Table(points) => ("table", points.as_flattened().to_vec()),
            Self::Reciprocal(_) => return None,
        })
    }

    /// The words for the formulas.
    pub const WORDS: [&str; 11] = [
        "constant",
        "sellmeier",
        "polynomial",
        "rational",
        "cauchy",
        "gas",
        "buchdahl",
        "herzberger",
        "retro",
        "exotic",
        "table",
    ];

    /// The formula of a word and its numbers; `None` if there is no such, or their count is wrong.
    pub fn from_words(formula: &str, numbers: &[f64]) -> Option<Self> {
        let (&a, rest) = numbers.split_first()?;
        let pairs = || {
            let (pairs, left) = rest.as_chunks::<2>();
            left.is_empty().then(|| pairs.to_vec())
        };
        Some(match formula {
            "constant" if rest.is_empty() => Self::Constant(a),
            "sellmeier" => Self::Sellmeier { a, terms: pairs()? },
            "polynomial" => Self::Polynomial { a, terms: pairs()? },
            "rational" => {
                let (&count, rest) = rest.split_first()?;
                let (powers, poles) = rest.split_at_checked(2 * (count as usize).min(rest.len()))?;
                let (poles, left) = poles.as_chunks::<3>();
                if !left.is_empty() {
                    return None;
                }
                Self::Rational { a, powers: powers.as_chunks::<2>().0.to_vec(), poles: poles.to_vec() }
            }
            "cauchy" => Self::Cauchy { a, terms: pairs()? },
            "gas" => Self::Gas { a, terms: pairs()? },
            "buchdahl" => Self::Buchdahl(numbers.try_into().ok()?),
            "herzberger" => Self::Herzberger(numbers.try_into().ok()?),
            "retro" => Self::Retro(numbers.try_into().ok()?),
            "exotic" => Self::Exotic(numbers.try_into().ok()?),
            "table" => {
                let (points, left) = numbers.as_chunks::<2>();
                if !left.is_empty() {
                    return None;
                }
                Self::table(points.to_vec())?
            }
            _ => return None,
        })
    }

    /// Measured indices, (µm, n) in any order: a constant for one, Cauchy's formula with as many terms as points for two
    /// and Conrady's for three, a smooth curve through more. `None` without a point, with a wavelength twice or below 0.
    pub fn through(mut points: Vec<[f64; 2]>) -> Option<Self> {
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let first = *points.first()?;
        if !(first[0] > 0.0) || points.iter().flatten().any(|x| !x.is_finite()) {
            return None;
        }
        if points.windows(2).any(|pair| pair[0][0] >= pair[1][0]) {
            return None;
        }
        let powers: &[f64] = match points.len() {
            1 => return Some(Self::Constant(first[1])),
            2 => &[-2.0],
            3 => &[-1.0, -3.5],
            _ => return Self::table(points),
        };
        // Divided differences against the powers solve the two or three equations.
        let step = |i: usize, power: f64| points[i][0].powf(power) - points[0][0].powf(power);
        let rise = |i: usize| points[i][1] - first[1];
        let terms: Vec<[f64; 2]> = match powers {
            [p] => vec![[rise(1) / step(1, *p), *p]],
            [p, q, ..] => {
                let determinant = step(1, *p) * step(2, *q) - step(2, *p) * step(1, *q);
                let b = (rise(1) * step(2, *q) - rise(2) * step(1, *q)) / determinant;
                let c = (step(1, *p) * rise(2) - step(2, *p) * rise(1)) / determinant;
                vec![[b, *p], [c, *q]]
            }
            [] => Vec::new(),
        };
        let a = first[1] - power_sum(&terms, first[0]);
        terms.iter().flatten().all(|x| x.is_finite()).then_some(Self::Cauchy { a, terms })
    }

    /// A table as it stands in a file: by rising wavelength.
    fn table(points: Vec<[f64; 2]>) -> Option<Self> {
        let rises = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let good = points.len() > 1 && rises && points[0][0] > 0.0 && points.iter().flatten().all(|x| x.is_finite());
        good.then_some(Self::Table(points))
    }
}

/// Σ b l^p; whole powers, which is all that catalogues use, without `powf`'s detour.
fn power_sum(terms: &[[f64; 2]], l: f64) -> f64 {
    let one = |&[b, p]: &[f64; 2]| {
        let power = if p.fract() == 0.0 && p.abs() < 100.0 { l.powi(p as i32) } else { l.powf(p) };
        b * power
    };
    terms.iter().map(one).sum()
}

/// Monotone cubic through the points (Fritsch and Butland 1984), in x = 1 / l², in which the index of glass is nearly straight.
/// Beyond its ends the table stands still.
fn interpolated(points: &[[f64; 2]], l: f64) -> f64 {
    let last = points.len() - 1;
    let x = |i: usize| points[i][0].powi(-2);
    let rise = |i: usize| (points[i + 1][1] - points[i][1]) / (x(i + 1) - x(i));
    let slope = |i: usize| {
        if i == 0 || i == last {
            return rise(i.min(last - 1));
        }
        let (a, b) = (rise(i - 1), rise(i));
        let (before, after) = (x(i) - x(i - 1), x(i + 1) - x(i));
        let (wa, wb) = (2.0 * after + before, after + 2.0 * before);
        if a * b > 0.0 { (wa + wb) / (wa / a + wb / b) } else { 0.0 }
    };
    if !(l > points[0][0]) {
        return points[0][1];
    }
    if l >= points[last][0] {
        return points[last][1];
    }
    let i = points.partition_point(|p| p[0] <= l).clamp(1, last) - 1;
    let h = x(i + 1) - x(i);
    let t = (l.powi(-2) - x(i)) / h;
    let (a, b, da, db) = (points[i][1], points[i + 1][1], slope(i) * h, slope(i + 1) * h);
    let (c2, c3) = (3.0 * (b - a) - 2.0 * da - db, da + db - 2.0 * (b - a));
    a + t * (da + t * (c2 + t * c3))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of a Sellmeier glass come back: exactly where they were taken, nearly between them.
    #[test]
    fn measured_indices_are_kept() {
        // Schott's N-BK7.
        let bk7 = Dispersion::from_words(
            "sellmeier",
            &[0.0, 1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653],
        )
        .unwrap();
        for count in 1..=20usize {
            let at = |i: f64| 0.4 + 0.4 * i / 19.0;
            let points: Vec<[f64; 2]> = (0..count)
                .map(|i| at(19.0 * i as f64 / (count.max(2) - 1) as f64))
                .map(|l| [l, bk7.index(l)])
                .collect();
            let again = Dispersion::through(points.iter().rev().copied().collect()).unwrap();
            for [l, n] in &points {
                assert!((again.index(*l) - n).abs() < 1e-12, "{count} {l}");
            }
            // What 3 samples and Conrady's formula, or 20 and a cubic, leave over the whole of visible light.
            let allowed = [1.0, 0.03, 2e-3, 1e-4][count.min(3)];
            for i in 0..190 {
                let l = at(f64::from(i) / 10.0);
                let error = (again.index(l) - bk7.index(l)).abs();
                assert!(
                    error
                        < if count == 20 {
                            5e-6
                        } else if count > 3 {
                            1e-3
                        } else {
                            allowed
                        },
                    "{count} {l} {error:e}"
                );
            }
        }
        assert_eq!(Dispersion::through(vec![]), None);
        assert_eq!(Dispersion::through(vec![[0.5, 1.5], [0.5, 1.6]]), None);
        assert_eq!(Dispersion::through(vec![[-0.5, 1.5], [0.5, 1.6]]), None);
        assert_eq!(Dispersion::through(vec![[0.5, f64::NAN]]), None);
    }

    #[test]
    fn words_are_the_formula() {
        let all: [(&str, &[f64]); 11] = [
            ("constant", &[1.5]),
            ("sellmeier", &[0.0, 1.0, 0.01, 0.2, 0.02]),
            ("polynomial", &[2.2, -0.01, 2.0, 0.01, -2.0]),
            ("rational", &[2.0, 1.0, -0.01, 2.0, 0.3, 2.0, 0.01, 0.01, 0.0, 0.02]),
            ("cauchy", &[1.5, 0.01, -1.0, 0.001, -3.5]),
            ("gas", &[0.0, 0.05, 200.0]),
            ("buchdahl", &[0.5876, 2.5, 1.5, -0.04, 0.01]),
            ("herzberger", &[1.5, 0.003, 0.00001, -0.003, 0.0, 0.0]),
            ("retro", &[0.2, 0.06, 0.05, -0.001]),
            ("exotic", &[2.0, 0.01, 0.02, 0.001, 0.2, 0.1]),
            ("table", &[0.4, 1.53, 0.5, 1.52, 0.6, 1.515, 0.7, 1.51]),
        ];
        for (word, numbers) in all {
            let formula = Dispersion::from_words(word, numbers).unwrap();
            assert_eq!(formula.words(), Some((word, numbers.to_vec())));
            assert!((1.0..2.0).contains(&formula.index(0.55)), "{word} {}", formula.index(0.55));
        }
        for (word, numbers) in [
            ("constant", &[][..]),
            ("sellmeier", &[0.0, 1.0]),
            ("table", &[0.5, 1.5]),
            ("x", &[1.0]),
            ("retro", &[1.0]),
        ] {
            assert_eq!(Dispersion::from_words(word, numbers), None, "{word}");
        }
    }
}
