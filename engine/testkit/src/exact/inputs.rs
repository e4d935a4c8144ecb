//! A case in exact numbers, and the function of its surface: z − sag, and the like, with its gradient.

use super::big::{Big, Vector, dot, times, unit, vector};
use super::case::{Case, Profile, Shape};

/// A case in exact numbers, its direction of unit length.
#[derive(Clone)]
pub(super) struct Inputs {
    pub(super) surface: Surface,
    pub(super) origin: Vector,
    pub(super) direction: Vector,
    pub(super) n1: Big,
    pub(super) n2: Big,
    /// The case, from which all other numbers are read.
    pub(super) case: Case,
}

/// A shape in exact numbers.
#[derive(Clone)]
pub(super) enum Surface {
    Conic(BigConic),
    Asphere(BigProfile),
    Toroid(BigProfile, Big),
}

/// Curvature and conic constant.
#[derive(Clone)]
pub(super) struct BigConic {
    pub(super) c: Big,
    pub(super) k: Big,
}

/// A conic and its polynomial, one coefficient a power: a₂, a₄ … and a₃, a₅ …
#[derive(Clone)]
pub(super) struct BigProfile {
    pub(super) base: BigConic,
    /// (1 + k) c².
    ending: Big,
    /// aₚ and p aₚ.
    even: Vec<[Big; 2]>,
    odd: Vec<[Big; 2]>,
}

/// A surface's function at a point: rising towards +z, 0 on the surface.
pub(super) struct At {
    pub(super) value: Big,
    /// The gradient N, not of unit length.
    pub(super) gradient: Vector,
}

impl Inputs {
    /// # Panics
    /// If a number is not finite or the direction is 0.
    pub(super) fn new(case: &Case) -> Self {
        assert!(case.is_finite(), "a number of the case is not finite: {case:?}");
        assert!(case.direction != [0.0; 3], "the ray has no direction: {case:?}");
        let surface = match &case.shape {
            Shape::Conic { curvature, conic } => Surface::Conic(BigConic::new(*curvature, *conic)),
            Shape::Asphere(profile) => Surface::Asphere(BigProfile::new(profile)),
            Shape::Toroid { profile, curvature_x } => Surface::Toroid(BigProfile::new(profile), Big::new(*curvature_x)),
        };
        Self {
            surface,
            origin: vector(case.origin),
            direction: unit(&vector(case.direction)),
            n1: Big::new(case.n1),
            n2: Big::new(case.n2),
            case: case.clone(),
        }
    }
}

impl BigConic {
    pub(super) fn new(curvature: f64, conic: f64) -> Self {
        Self { c: Big::new(curvature), k: Big::new(conic) }
    }

    /// N at a point: (−c x, −c y, 1 − (1 + k) c z).
    pub(super) fn gradient(&self, p: &Vector) -> Vector {
        let z = Big::new(1.0) - (Big::new(1.0) + &self.k) * &self.c * &p[2];
        let [x, y, _] = times(p, &-&self.c);
        [x, y, z]
    }
}

impl BigProfile {
    fn new(profile: &Profile) -> Self {
        let (mut even, mut odd) = (Vec::new(), Vec::new());
        for &(power, coefficient) in &profile.terms {
            assert!((2..=20).contains(&power), "a term of power {power}");
            let (list, place) = if power % 2 == 0 { (&mut even, power / 2 - 1) } else { (&mut odd, (power - 3) / 2) };
            let place = place as usize;
            if list.len() <= place {
                list.resize(place + 1, [Big::new(0.0), Big::new(0.0)]);
            }
            let [value, weighted] = &list[place];
            let a = Big::new(coefficient);
            list[place] = [value + &a, weighted + a * Big::new(f64::from(power))];
        }
        let base = BigConic::new(profile.curvature, profile.conic);
        let ending = (Big::new(1.0) + &base.k) * base.c.squared();
        Self { base, ending, even, odd }
    }

    /// Sag and its derivative divided by r, at r² = `u`; `None` beyond the end of the conic.
    fn at(&self, u: &Big) -> Option<(Big, Big)> {
        let one = Big::new(1.0);
        let c = &self.base.c;
        let inside = &one - &self.ending * u;
        if !inside.is_positive() {
            return None;
        }
        let w = inside.sqrt();
        let mut sag = c * u / (&one + &w);
        let mut slope = c / &w;
        // Σ a rᵖ and Σ p a rᵖ⁻², the odd ones times r.
        let (even, even_slope) = polynomial(&self.even, u);
        sag = sag + even * u;
        slope = slope + even_slope;
        if !self.odd.is_empty() {
            let r = u.sqrt();
            let (odd, odd_slope) = polynomial(&self.odd, u);
            sag = sag + odd * u * &r;
            slope = slope + odd_slope * r;
        }
        Some((sag, slope))
    }
}

/// Σ uʲ of the first and of the second of each pair.
fn polynomial(terms: &[[Big; 2]], u: &Big) -> (Big, Big) {
    terms.iter().rev().fold((Big::new(0.0), Big::new(0.0)), |(first, second), [a, b]| (first * u + a, second * u + b))
}

impl Surface {
    /// The conic that the shape is built on.
    pub(super) fn base(&self) -> &BigConic {
        match self {
            Self::Conic(conic) => conic,
            Self::Asphere(profile) | Self::Toroid(profile, _) => &profile.base,
        }
    }

    /// The function at `p`; `None` where the profile has ended.
    pub(super) fn at(&self, p: &Vector) -> Option<At> {
        let [x, y, z] = p;
        match self {
            Self::Conic(conic) => {
                let stretched = [x.clone(), y.clone(), z + &conic.k * z];
                let value = z - (&conic.c * dot(p, &stretched)).times_power_of_two(-1);
                Some(At { value, gradient: conic.gradient(p) })
            }
            Self::Asphere(profile) => {
                let (sag, slope) = profile.at(&(x.squared() + y.squared()))?;
                Some(At { value: z - sag, gradient: [-(x * &slope), -(y * &slope), Big::new(1.0)] })
            }
            Self::Toroid(profile, across) => {
                let (sag, slope) = profile.at(&y.squared())?;
                let bent = (across * (x.squared() + z.squared() - sag.squared())).times_power_of_two(-1);
                let one = Big::new(1.0);
                let gradient = [-(across * x), -(slope * y * (&one - across * &sag)), one - across * z];
                Some(At { value: z - &sag - bent, gradient })
            }
        }
    }
}
