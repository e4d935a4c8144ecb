//! The materials of thin films.
//!
//! Indices of [`KNOWN`] are those of the bulk, by the source named; evaporated films are some per cent less dense, and are used as such
//! by the recipes' sources. Those of [`MEASURED`] are of films.

use num_complex::Complex64;

use super::CoatingError;
use crate::glass::Dispersion;

/// A material for films.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    name: String,
    dispersion: Dispersion,
    /// Extinction coefficient k, of n + ik: linear between pairs (nm, k) by rising nm, constant beyond; none: 0.
    extinction: Vec<[f64; 2]>,
}

/// A name, Sellmeier's b, and λ² of the poles in µm².
type Known = (&'static str, [[f64; 2]; 3]);

/// Sellmeier's terms, n² = 1 + Σ b λ² / (λ² − c).
const KNOWN: [Known; 4] = [
    // Ordinary ray. Dodge, Appl. Opt. 23, 1980 (1984).
    ("MgF2", [[0.487_551_08, 0.001_882_178_3], [0.398_750_31, 0.008_951_888_5], [2.312_035_3, 566.135_591_2]]),
    // Fused. Malitson, J. Opt. Soc. Am. 55, 1205 (1965).
    ("SiO2", [[0.696_166_3, 0.004_679_148_3], [0.407_942_6, 0.013_512_063_1], [0.897_479_4, 97.934_002_5]]),
    // Ordinary ray. Malitson and Dodge, J. Opt. Soc. Am. 62, 1405 (1972).
    ("Al2O3", [[1.431_349_3, 0.005_279_926_1], [0.650_547_13, 0.014_238_264_7], [5.341_402_1, 325.017_834]]),
    // Cubic, with 12 % yttria. Wood and Nassau, Appl. Opt. 21, 2978 (1982).
    ("ZrO2", [[1.347_091, 0.003_911_627], [2.117_788, 0.027_801_964], [9.452_943, 593.926_45]]),
];
/// n = a + b / λ² + c / λ⁴, λ in µm: evaporated. Al-Kuhaili, Opt. Mater. 27, 383 (2004).
const HFO2: [f64; 3] = [1.875, 6.28e-3, 5.80e-4];

/// A name, and (nm, n, k) by rising nm.
type Measured = (&'static str, &'static [[f64; 3]]);

/// Films that were measured as such.
#[rustfmt::skip]
const MEASURED: [Measured; 4] = [
    // 400 nm, by electron beam with ions. Gao, Lemarchand and Lequime, Opt. Express 20, 15734 (2012).
    ("Ta2O5", &[
        [350.0, 2.317048, 0.000655], [380.0, 2.270419, 0.000431], [400.0, 2.246896, 0.000327],
        [420.0, 2.227622, 0.000247], [450.0, 2.204562, 0.000158], [480.0, 2.186592, 0.0001],
        [500.0, 2.176708, 0.000067], [550.0, 2.157262, 0.000021], [600.0, 2.143086, 0.000002],
        [650.0, 2.132408, 0.0], [700.0, 2.124149, 0.0], [780.0, 2.114331, 0.0], [900.0, 2.104484, 0.0],
    ]),
    // 200 nm on glass. Sarkar et al., ACS Appl. Mater. Interfaces 11, 13752 (2019).
    ("TiO2", &[
        [370.0, 2.442075, 0.0], [380.0, 2.3993, 0.0], [400.0, 2.337928, 0.0], [420.0, 2.294437, 0.0],
        [450.0, 2.247783, 0.0], [480.0, 2.214461, 0.0], [500.0, 2.197043, 0.0], [550.0, 2.164358, 0.0],
        [600.0, 2.141661, 0.0], [650.0, 2.125097, 0.0], [700.0, 2.112561, 0.0], [760.0, 2.101118, 0.0],
    ]),
    // Evaporated. Rakić, Appl. Opt. 34, 4755 (1995).
    ("Al", &[
        [364.66, 0.39877, 4.3957], [413.28, 0.52135, 5.0008], [442.8, 0.6079, 5.3676], [476.87, 0.7278, 5.7781],
        [516.6, 0.8734, 6.2418], [563.57, 1.0728, 6.7839], [619.93, 1.366, 7.4052], [652.25, 1.5724, 7.7354],
        [688.81, 1.8301, 8.0601], [729.32, 2.1606, 8.3565], [774.91, 2.6154, 8.4914], [815.69, 2.7668, 8.2573],
    ]),
    // Evaporated. Johnson and Christy, Phys. Rev. B 6, 4370 (1972).
    ("Ag", &[
        [367.9, 0.07, 1.657], [381.5, 0.05, 1.864], [397.4, 0.05, 2.07], [413.3, 0.05, 2.275], [430.5, 0.04, 2.462],
        [450.9, 0.04, 2.657], [471.4, 0.05, 2.869], [495.9, 0.05, 3.093], [520.9, 0.05, 3.324], [548.6, 0.06, 3.586],
        [582.1, 0.05, 3.858], [616.8, 0.06, 4.152], [659.5, 0.05, 4.483], [704.5, 0.04, 4.838], [756.0, 0.03, 5.242],
        [821.1, 0.04, 5.727],
    ]),
];

/// The names of the films, for messages.
pub(super) fn names() -> String {
    let measured = MEASURED.iter().map(|(name, _)| *name);
    KNOWN.iter().map(|(name, _)| *name).chain(["HfO2"]).chain(measured).collect::<Vec<_>>().join(", ")
}

/// Indices of a film without a name, and extinction coefficients up to the end: none is known beyond, and products of such keep their digits.
const INDICES: std::ops::RangeInclusive<f64> = 0.01..=100.0;

impl Film {
    /// A film of an index n + ik that is constant over the wavelengths.
    pub fn constant(n: f64, k: f64) -> Self {
        let name = if k == 0.0 { format!("{n}") } else { format!("{n}-{k}i") };
        let extinction = if k == 0.0 { Vec::new() } else { vec![[0.0, k]] };
        Self { name, dispersion: Dispersion::Constant(n), extinction }
    }

    /// The known film of this name, in any case; `None` if there is none.
    pub fn named(name: &str) -> Option<Self> {
        if name.eq_ignore_ascii_case("HfO2") {
            let [a, b, c] = HFO2;
            let dispersion = Dispersion::Cauchy { a, terms: vec![[b, -2.0], [c, -4.0]] };
            return Some(Self { name: "HfO2".to_owned(), dispersion, extinction: Vec::new() });
        }
        if let Some((name, points)) = MEASURED.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) {
            let dispersion = Dispersion::Table(points.iter().map(|[nm, n, _]| [nm * 1e-3, *n]).collect());
            let extinction = points.iter().map(|[nm, _, k]| [*nm, *k]).collect();
            return Some(Self { name: (*name).to_owned(), dispersion, extinction });
        }
        let (name, terms) = KNOWN.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
        let dispersion = Dispersion::Sellmeier { a: 0.0, terms: terms.to_vec() };
        Some(Self { name: (*name).to_owned(), dispersion, extinction: Vec::new() })
    }

    /// A name, or an index: `1.38`, or `2.3-0.01i` of one that absorbs.
    pub(super) fn parse(text: &str) -> Result<Self, CoatingError> {
        if let Some(known) = Self::named(text) {
            return Ok(known);
        }
        let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite());
        let (n, k) = match text.strip_suffix('i').and_then(|both| both.rsplit_once('-')) {
            Some((n, k)) => (number(n), number(k)),
            None => (number(text), Some(0.0)),
        };
        match (n, k) {
            (Some(n), Some(k)) if INDICES.contains(&n) && (0.0..=*INDICES.end()).contains(&k) => {
                Ok(Self::constant(n, k))
            }
            _ => Err(CoatingError::Film(text.to_owned())),
        }
    }

    /// The text in a lens file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// n + ik at a vacuum wavelength.
    pub fn index(&self, wavelength_nm: f64) -> Complex64 {
        Complex64::new(self.dispersion.index(wavelength_nm * 1e-3), self.k(wavelength_nm))
    }

    fn k(&self, nm: f64) -> f64 {
        let after = self.extinction.partition_point(|point| point[0] <= nm);
        match (after.checked_sub(1).map(|i| self.extinction[i]), self.extinction.get(after)) {
            (Some([a, k]), Some([b, next])) => k + (next - k) * (nm - a) / (b - a),
            (Some([_, k]), None) | (None, Some(&[_, k])) => k,
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Indices agree with refractiveindex.info at 587.6 nm (MgF2, SiO2, Al2O3, ZrO2) and at 550 nm (HfO2).
    #[test]
    fn indices_are_the_sources() {
        for (name, nm, expected) in [
            ("MgF2", 587.6, 1.3777),
            ("SiO2", 587.6, 1.4585),
            ("Al2O3", 587.6, 1.7682),
            ("zro2", 587.6, 2.1588),
            ("HfO2", 550.0, 1.9021),
            ("Ta2O5", 532.0, 2.1635),
            ("TiO2", 588.0, 2.1464),
            ("Ag", 532.0, 0.0540),
        ] {
            let found = Film::named(name).unwrap().index(nm).re;
            assert!((found - expected).abs() < 2e-4, "{name}: {found}");
        }
        assert!(Film::named("glue").is_none());
        for none in ["-1", "0", "1e-9", "1e58", "2-101i", "2--1i", "nan"] {
            assert!(Film::parse(none).is_err(), "{none}");
        }
        // Between the table's points, refractiveindex.info has k = 0.000033 for Ta2O5.
        assert!((Film::named("Ta2O5").unwrap().index(532.0).im - 3.3e-5).abs() < 1e-5);
        assert!((Film::named("Al").unwrap().index(540.0).im - 6.51).abs() < 0.01);
        assert_eq!(Film::parse("2.3-0.01i").unwrap().index(500.0), Complex64::new(2.3, 0.01));
    }
}
