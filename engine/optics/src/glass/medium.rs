//! One transparent medium: a dispersion formula and its name.

use std::fmt;

/// The name of the medium that surrounds every lens.
pub const AIR_NAME: &str = "air";

/// Vacuum wavelengths of the spectral lines that design tables are written for, in nm.
pub mod line_nm {
    /// Hydrogen F, blue.
    pub const F: f64 = 486.1327;
    /// Helium d, yellow: the design wavelength.
    pub const D: f64 = 587.5618;
    /// Hydrogen C, red.
    pub const C: f64 = 656.2725;
}

/// How the index follows from the wavelength `l` in micrometres.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Dispersion {
    /// The same at every wavelength.
    Constant(f64),
    /// n² = 1 + a + Σ b l² / (l² − c), pairs (b, c).
    Sellmeier { a: f64, terms: Vec<[f64; 2]> },
    /// n² = a + Σ b l^p, pairs (b, p).
    Polynomial { a: f64, terms: Vec<[f64; 2]> },
    /// n = a + Σ b l^p, pairs (b, p).
    Cauchy { a: f64, terms: Vec<[f64; 2]> },
    /// n = 1 + a + Σ b / (c − l⁻²), pairs (b, c).
    Gas { a: f64, terms: Vec<[f64; 2]> },
    /// w = (l − l0) / (1 + alpha (l − l0)), n = n0 + v1 w + v2 w².
    Buchdahl([f64; 5]),
    /// One over the index of the boxed formula: vacuum, relative to a gas.
    Reciprocal(Box<Dispersion>),
}

impl Dispersion {
    pub(super) fn index(&self, l: f64) -> f64 {
        let squared = l * l;
        match self {
            Self::Constant(n) => *n,
            Self::Sellmeier { a, terms } => {
                let sum: f64 = terms.iter().map(|[b, c]| b * squared / (squared - c)).sum();
                (1.0 + a + sum).sqrt()
            }
            Self::Polynomial { a, terms } => (a + power_sum(terms, l)).sqrt(),
            Self::Cauchy { a, terms } => a + power_sum(terms, l),
            Self::Gas { a, terms } => {
                let sum: f64 = terms.iter().map(|[b, c]| b / (c - 1.0 / squared)).sum();
                1.0 + a + sum
            }
            Self::Buchdahl([l0, alpha, n0, v1, v2]) => {
                let w = (l - l0) / (1.0 + alpha * (l - l0));
                n0 + w * (v1 + v2 * w)
            }
            Self::Reciprocal(other) => 1.0 / other.index(l),
        }
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

/// A transparent medium.
#[derive(Clone, PartialEq)]
pub struct Medium {
    name: String,
    dispersion: Dispersion,
    range_nm: [f64; 2],
    source: String,
}

impl Medium {
    pub(super) fn new(name: &str, dispersion: Dispersion, range_nm: [f64; 2], source: &str) -> Self {
        Self { name: name.to_owned(), dispersion, range_nm, source: source.to_owned() }
    }

    /// Air, n = 1 exactly: all other indices are relative to it.
    pub fn air() -> Self {
        Self::constant(AIR_NAME, 1.0)
    }

    /// A medium whose index is `index` at every wavelength.
    pub fn constant(name: &str, index: f64) -> Self {
        Self::new(name, Dispersion::Constant(index), [0.0, f64::INFINITY], "constant")
    }

    /// The glass `n/V`: n = A + B / l² with exactly the index `nd` at d and n_F − n_C = (nd − 1) / `abbe`.
    pub fn from_index_and_abbe(name: &str, nd: f64, abbe: f64) -> Self {
        let inverse_square_um = |nm: f64| (1000.0 / nm) * (1000.0 / nm);
        let spread = inverse_square_um(line_nm::F) - inverse_square_um(line_nm::C);
        let b = (nd - 1.0) / abbe / spread;
        let a = nd - b * inverse_square_um(line_nm::D);
        let dispersion = Dispersion::Cauchy { a, terms: vec![[b, -2.0]] };
        Self::new(name, dispersion, [0.0, f64::INFINITY], "two-term Cauchy")
    }

    pub(super) fn dispersion(&self) -> &Dispersion {
        &self.dispersion
    }

    /// The name as its catalogue writes it, or the token of the lens file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the numbers come from.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The wavelengths in nm that the formula was made for; outside it extrapolates.
    pub fn range_nm(&self) -> [f64; 2] {
        self.range_nm
    }

    /// Refractive index at a vacuum wavelength in nm, relative to air.
    pub fn index(&self, wavelength_nm: f64) -> f64 {
        self.dispersion.index(wavelength_nm / 1000.0)
    }

    /// Abbe number V_d = (n_d − 1) / (n_F − n_C); infinite without dispersion.
    pub fn abbe(&self) -> f64 {
        let spread = self.index(line_nm::F) - self.index(line_nm::C);
        if spread == 0.0 { f64::INFINITY } else { (self.index(line_nm::D) - 1.0) / spread }
    }
}

impl fmt::Debug for Medium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Medium({}, nd {:.6})", self.name, self.index(line_nm::D))
    }
}
