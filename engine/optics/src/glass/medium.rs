//! One transparent medium: a dispersion formula and its name.

use std::fmt;
use std::sync::Arc;

use super::dispersion::Dispersion;
use super::gradient::Gradient;
use super::transmittance::InternalTransmittance;

/// The name of the medium that surrounds every lens.
pub const AIR_NAME: &str = "air";

/// Vacuum wavelengths of the spectral lines that design tables are written for, in nm.
pub mod line_nm {
    /// Hydrogen F, blue: with C it makes the Abbe number's n_F − n_C.
    pub const F: f64 = 486.1327;
    /// Helium d, yellow: the design wavelength.
    pub const D: f64 = 587.5618;
    /// Hydrogen C, red: with F it makes the Abbe number's n_F − n_C.
    pub const C: f64 = 656.2725;
}

/// The shortest and the longest wave that the eye sees, nm: between them the index of a lens's glasses should be known.
pub const VISIBLE_NM: [f64; 2] = [380.0, 780.0];

/// Indices that a medium may have at a visible wavelength.
const PLAUSIBLE_INDEX: std::ops::RangeInclusive<f64> = 0.5..=6.0;

/// A transparent medium: its index by wavelength and, where it has them, its internal transmittance and its index gradient.
#[derive(Clone, PartialEq)]
pub struct Medium {
    name: String,
    dispersion: Dispersion,
    range_nm: [f64; 2],
    source: String,
    transmittance: Option<Arc<InternalTransmittance>>,
    gradient: Option<Arc<Gradient>>,
    /// The number that is added to the formula's index, at every wavelength.
    shift: f64,
}

impl Medium {
    /// A medium by its formula, which was made for the wavelengths of `range_nm`; outside of them the index is that at the
    /// nearer end. A range that is none is all wavelengths.
    pub fn new(name: &str, dispersion: Dispersion, range_nm: [f64; 2], source: &str) -> Self {
        let is_range = range_nm[0] <= range_nm[1];
        let range_nm = if is_range { range_nm } else { [0.0, f64::INFINITY] };
        Self {
            name: name.to_owned(),
            dispersion,
            range_nm,
            source: source.to_owned(),
            transmittance: None,
            gradient: None,
            shift: 0.0,
        }
    }

    /// This medium with an internal transmittance.
    pub fn with_transmittance(mut self, transmittance: InternalTransmittance) -> Self {
        self.transmittance = Some(Arc::new(transmittance));
        self
    }

    /// This medium with an index that changes from place to place.
    pub fn with_gradient(mut self, gradient: Gradient) -> Self {
        self.gradient = Some(Arc::new(gradient));
        self
    }

    /// The gradient of the medium's index; `None`: the index is spatially constant.
    pub fn gradient(&self) -> Option<&Gradient> {
        self.gradient.as_deref()
    }

    /// This medium in a lens `factor` times as large.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { gradient: self.gradient.as_ref().map(|gradient| Arc::new(gradient.scaled(factor))), ..self.clone() }
    }

    /// This medium seen from a vertex `behind_mm` farther along the axis.
    pub fn seen_from(&self, behind_mm: f64) -> Self {
        Self {
            gradient: self.gradient.as_ref().map(|gradient| Arc::new(gradient.seen_from(behind_mm))),
            ..self.clone()
        }
    }

    /// This medium with `shift` added to its index at every wavelength.
    pub fn with_index_shift(&self, shift: f64) -> Self {
        Self { shift, ..self.clone() }
    }

    /// The medium by its formula alone, without the shift by [`Self::with_index_shift`].
    pub fn as_defined(&self) -> Self {
        Self { shift: 0.0, ..self.clone() }
    }

    /// The medium by another name.
    pub fn with_name(&self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self.clone() }
    }

    /// The part of the light of a wavelength that is left after `thickness_mm` of the medium; `None` if that is not known.
    pub fn internal_transmittance(&self, wavelength_nm: f64, thickness_mm: f64) -> Option<f64> {
        self.transmittance.as_ref().map(|known| known.at(wavelength_nm, thickness_mm))
    }

    /// The internal transmittance, if known.
    pub fn transmittance(&self) -> Option<&InternalTransmittance> {
        self.transmittance.as_deref()
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

    /// The dispersion formula, without [`Self::with_index_shift`] and the gradient.
    pub fn dispersion(&self) -> &Dispersion {
        &self.dispersion
    }

    /// The number that [`Self::with_index_shift`] has added to the formula's index.
    pub fn index_shift(&self) -> f64 {
        self.shift
    }

    /// The name as its catalogue writes it, or the token of the lens file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The source of the numbers.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The wavelengths in nm that the formula was made for; outside of them the index stands still.
    pub fn range_nm(&self) -> [f64; 2] {
        self.range_nm
    }

    /// Refractive index at a vacuum wavelength in nm, relative to air. Of a gradient, at the vertex that it is seen from.
    pub fn index(&self, wavelength_nm: f64) -> f64 {
        let there = self.gradient.as_ref().map_or(0.0, |gradient| gradient.on_axis(0.0)[0]);
        self.base_index(wavelength_nm) + there
    }

    /// The index without the gradient.
    pub fn base_index(&self, wavelength_nm: f64) -> f64 {
        let [shortest, longest] = self.range_nm;
        self.dispersion.index(wavelength_nm.max(shortest).min(longest) / 1000.0) + self.shift
    }

    /// The first visible wavelength in nm, looked for at every nanometre, at which the formula gives no index of a glass: it is NaN,
    /// infinite, or out of [`PLAUSIBLE_INDEX`], as near a pole. `None`: there is none.
    pub fn hole_nm(&self) -> Option<f64> {
        let [shortest, longest] = VISIBLE_NM;
        let all = (0..=(longest - shortest) as u32).map(|i| shortest + f64::from(i));
        all.into_iter().find(|&nm| !PLAUSIBLE_INDEX.contains(&self.base_index(nm)))
    }

    /// True if the index is one of [`PLAUSIBLE_INDEX`] at all visible wavelengths, and at the ends of its range: of a range without an end,
    /// at 200 nm and 20 µm.
    pub(crate) fn is_plausible(&self) -> bool {
        let ends = self.range_nm.map(|nm| nm.clamp(200.0, 20_000.0));
        ends.into_iter().all(|nm| PLAUSIBLE_INDEX.contains(&self.index(nm))) && self.hole_nm().is_none()
    }

    /// True if the formula was made for all wavelengths between these, but for a nanometre.
    pub fn is_known_between(&self, shortest_nm: f64, longest_nm: f64) -> bool {
        const ROUNDING_NM: f64 = 1.0;
        shortest_nm >= self.range_nm[0] - ROUNDING_NM && longest_nm <= self.range_nm[1] + ROUNDING_NM
    }

    /// The remark on an index outside of the range of wavelengths.
    pub fn range_note(&self) -> String {
        let Self { name, range_nm: [start, end], .. } = self;
        format!("glass {name}: its index is known from {start:.0} to {end:.0} nm, beyond it is kept as at the end")
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
