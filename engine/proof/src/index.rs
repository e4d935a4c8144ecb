//! The index of a medium over a cell of wavelengths.

use crate::taylor::Taylor;
use petzval_optics::glass::{Dispersion, HERZBERGER, Medium};

/// The reason why the index of a medium cannot be enclosed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoIndex {
    /// A table of measured indices.
    Table,
    /// A power of the wavelength that is neither a whole nor a half.
    Power,
    /// An index that changes from place to place.
    Gradient,
}

impl NoIndex {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Table => "its index is a table",
            Self::Power => "its formula has a power that is neither a whole nor a half",
            Self::Gradient => "its index changes from place to place",
        }
    }
}

/// The index at wavelengths `nm`, nanometres, all of which lie on one side of each end of the medium's range ([`ends_nm`]).
pub(super) fn index<const N: usize>(medium: &Medium, nm: Taylor<N>) -> Result<Taylor<N>, NoIndex> {
    if medium.gradient().is_some() {
        return Err(NoIndex::Gradient);
    }
    let [shortest, longest] = medium.range_nm();
    let at = match nm.middle() {
        below if below < shortest => Taylor::constant(shortest),
        above if above > longest => Taylor::constant(longest),
        _ => nm,
    };
    Ok(formula(medium.dispersion(), at * Taylor::constant(1000.0).reciprocal())?.plus(medium.index_shift()))
}

/// The ends of the range of wavelengths of a medium's formula, nm.
pub(super) fn ends_nm(medium: &Medium) -> [f64; 2] {
    medium.range_nm()
}

/// l^p
fn power<const N: usize>(l: Taylor<N>, p: f64) -> Result<Taylor<N>, NoIndex> {
    let doubled = 2.0 * p;
    if doubled.fract() != 0.0 || doubled.abs() > 80.0 {
        return Err(NoIndex::Power);
    }
    let base = if p < 0.0 { l.reciprocal() } else { l };
    let mut product = if p.fract() == 0.0 { Taylor::constant(1.0) } else { base.sqrt() };
    for _ in 0..p.abs().floor() as u32 {
        product = product * base;
    }
    Ok(product)
}

fn power_sum<const N: usize>(terms: &[[f64; 2]], l: Taylor<N>) -> Result<Taylor<N>, NoIndex> {
    let mut sum = Taylor::constant(0.0);
    for [b, p] in terms {
        sum = sum + power(l, *p)?.times(*b);
    }
    Ok(sum)
}

/// [`Dispersion::index`] at `l` µm.
fn formula<const N: usize>(dispersion: &Dispersion, l: Taylor<N>) -> Result<Taylor<N>, NoIndex> {
    let squared = l.squared();
    Ok(match dispersion {
        Dispersion::Constant(n) => Taylor::constant(*n),
        Dispersion::Sellmeier { a, terms } => {
            let mut sum = Taylor::constant(1.0).plus(*a);
            for [b, c] in terms {
                sum = sum + squared.times(*b) / squared.plus(-c);
            }
            sum.sqrt()
        }
        Dispersion::Polynomial { a, terms } => power_sum(terms, l)?.plus(*a).sqrt(),
        Dispersion::Rational { a, powers, poles } => {
            let mut sum = power_sum(powers, l)?.plus(*a);
            for [b, p, c] in poles {
                sum = sum + power(l, *p)?.times(*b) / squared.plus(-c);
            }
            sum.sqrt()
        }
        Dispersion::Cauchy { a, terms } => power_sum(terms, l)?.plus(*a),
        Dispersion::Gas { a, terms } => {
            let mut sum = Taylor::constant(1.0).plus(*a);
            for [b, c] in terms {
                sum = sum + (-squared.reciprocal()).plus(*c).reciprocal().times(*b);
            }
            sum
        }
        Dispersion::Buchdahl([l0, alpha, n0, v1, v2]) => {
            let away = l.plus(-l0);
            let w = away / away.times(*alpha).plus(1.0);
            (w * w.times(*v2).plus(*v1)).plus(*n0)
        }
        Dispersion::Herzberger([a, b, c, d, e, f]) => {
            let x = squared.plus(-HERZBERGER).reciprocal();
            let near = x * x.times(*c).plus(*b);
            let far = squared * (squared * squared.times(*f).plus(*e)).plus(*d);
            (near + far).plus(*a)
        }
        Dispersion::Retro([a, b, c, d]) => {
            let s = (squared.times(*b) / squared.plus(-c) + squared.times(*d)).plus(*a);
            (s.times(2.0).plus(1.0) / (-s).plus(1.0)).sqrt()
        }
        Dispersion::Exotic([a, b, c, d, e, f]) => {
            let away = l.plus(-e);
            let pole = squared.plus(-c).reciprocal().times(*b);
            (pole + away.times(*d) / away.squared().plus(*f)).plus(*a).sqrt()
        }
        Dispersion::Table(_) => return Err(NoIndex::Table),
        Dispersion::Reciprocal(other) => formula(other, l)?.reciprocal(),
    })
}
