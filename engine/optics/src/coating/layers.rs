//! Light at a stack of thin films: waves that are reflected at each boundary, and interfere.
//!
//! Amplitudes are found from the last boundary to the first (Airy's summation, layer by layer; Born and Wolf, *Principles of Optics*,
//! §1.6.4; Macleod, *Thin-Film Optical Filters*, ch. 2): the factors of the phases only ever shrink, so that thick absorbing
//! layers overflow nothing.

use num_complex::Complex64;

use super::{CoatingError, Film};

/// One thin film of a coating.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The material of the layer, with its complex index.
    pub film: Film,
    /// Geometric thickness of the layer; a lens that is scaled keeps it.
    pub thickness_nm: f64,
}

impl Layer {
    /// Parses a layer such as `MgF2:100nm`, or `MgF2:0.25w@550`: a quarter of a wave of 550 nm inside the film.
    pub(super) fn parse(text: &str) -> Result<Self, CoatingError> {
        let (film, thickness) = text.split_once(':').ok_or_else(|| CoatingError::Thickness(text.to_owned()))?;
        let film = Film::parse(film)?;
        let bad = || CoatingError::Thickness(thickness.to_owned());
        let number = |text: &str| text.parse::<f64>().ok().filter(|x| *x >= 0.0 && x.is_finite());
        let thickness_nm = if let Some(nm) = thickness.strip_suffix("nm") {
            number(nm).ok_or_else(bad)?
        } else {
            let (waves, nm) = thickness.split_once("w@").ok_or_else(bad)?;
            let nm = number(nm).filter(|nm| *nm > 0.0).ok_or_else(bad)?;
            number(waves).ok_or_else(bad)? * nm / film.index(nm).re
        };
        if thickness_nm > THICKEST_NM {
            return Err(bad());
        }
        Ok(Self { film, thickness_nm })
    }

    /// A layer whose thickness is this number of waves of a vacuum wavelength inside the film.
    pub fn of_waves(film: Film, waves: f64, wavelength_nm: f64) -> Self {
        let thickness_nm = waves * wavelength_nm / film.index(wavelength_nm).re;
        Self { film, thickness_nm }
    }
}

/// Waves do not interfere across thicker layers.
const THICKEST_NM: f64 = 1e5;

/// The split of light at a surface, as parts of its power: \[s, p\]. The rest is absorbed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// The parts that are reflected.
    pub reflected: [f64; 2],
    /// The parts that are transmitted.
    pub transmitted: [f64; 2],
}

impl Split {
    /// All light is reflected.
    pub const MIRROR: Self = Self { reflected: [1.0; 2], transmitted: [0.0; 2] };
    /// All light is transmitted.
    pub const NOTHING: Self = Self { reflected: [0.0; 2], transmitted: [1.0; 2] };

    /// The reflected part of unpolarised light.
    pub fn mean_reflected(&self) -> f64 {
        0.5 * (self.reflected[0] + self.reflected[1])
    }

    /// The transmitted part of unpolarised light.
    pub fn mean_transmitted(&self) -> f64 {
        0.5 * (self.transmitted[0] + self.transmitted[1])
    }
}

/// A medium as waves of one direction see it.
#[derive(Clone, Copy)]
struct Side {
    index: Complex64,
    cos: Complex64,
}

impl Side {
    /// The amplitudes that a boundary to another medium reflects and lets through, s and p.
    fn to(&self, other: &Self) -> [[Complex64; 2]; 2] {
        let (n, c, n2, c2) = (self.index, self.cos, other.index, other.cos);
        let one = |a: Complex64, b: Complex64, through: Complex64| {
            let sum = a + b;
            // Along a boundary between equal media: there is none.
            if sum.norm_sqr() == 0.0 {
                return [Complex64::ZERO, Complex64::ONE];
            }
            [(a - b) / sum, through / sum]
        };
        let twice = 2.0 * n * c;
        [one(n * c, n2 * c2, twice), one(n2 * c, n * c2, twice)]
    }
}

/// Fresnel's equations (Born and Wolf, §1.5.3).
fn bare(from: f64, to: f64, cos: f64) -> Split {
    if from == to {
        return Split::NOTHING;
    }
    let other = 1.0 - (from / to).powi(2) * (1.0 - cos * cos);
    // Written so that NaN, too, turns round.
    if !(other > 0.0) {
        return Split::MIRROR;
    }
    let other = other.sqrt();
    let s = (from * cos - to * other) / (from * cos + to * other);
    let p = (to * cos - from * other) / (to * cos + from * other);
    let reflected = [s * s, p * p];
    Split { reflected, transmitted: reflected.map(|r| 1.0 - r) }
}

/// The parts of light that comes from a medium of real index `from` through layers, in the order that it hits them, to one of index
/// `to`.
pub(super) fn split<'a>(
    layers: impl Iterator<Item = &'a Layer>,
    from: f64,
    to: f64,
    wavelength_nm: f64,
    cos_incidence: f64,
) -> Split {
    let cos = cos_incidence.abs().clamp(0.0, 1.0);
    let mut layers = layers.peekable();
    if layers.peek().is_none() {
        return bare(from, to, cos);
    }
    let along = from * (1.0 - cos * cos).max(0.0).sqrt();
    let side = |index: Complex64| {
        let square = Complex64::ONE - (along / index).powi(2);
        let cos = square.sqrt();
        // Waves fade on their way, or go on; they never grow.
        let forward = index * cos;
        let is_forward = if forward.im.abs() > 1e-12 * forward.re.abs() { forward.im > 0.0 } else { forward.re >= 0.0 };
        Side { index, cos: if is_forward { cos } else { -cos } }
    };
    let (first, last) = (Side { index: from.into(), cos: cos.into() }, side(to.into()));
    let films: Vec<(Side, f64)> =
        layers.map(|layer| (side(layer.film.index(wavelength_nm)), layer.thickness_nm)).collect();
    let mut result = Split::NOTHING;
    for polarisation in 0..2 {
        let mut behind = last;
        // Reflected by, and let through, all that lies behind the boundary under way.
        let (mut r, mut t) = (Complex64::ZERO, Complex64::ONE);
        let mut onward = Complex64::ONE;
        for (here, thickness_nm) in films.iter().rev().copied().chain([(first, 0.0)]) {
            let [own_r, own_t] = here.to(&behind)[polarisation];
            let round = r * onward * onward;
            let sum = Complex64::ONE + own_r * round;
            (r, t) = ((own_r + round) / sum, own_t * onward * t / sum);
            let phase = std::f64::consts::TAU / wavelength_nm * thickness_nm * here.index * here.cos;
            onward = (Complex64::I * phase).exp();
            behind = here;
        }
        // A field's power along the normal: n cos θ, and for p its conjugate.
        let flow = |side: &Side| match polarisation {
            0 => (side.index * side.cos).re,
            _ => (side.index * side.cos.conj()).re,
        };
        let arriving = flow(&first);
        let reflected = if arriving > 0.0 { r.norm_sqr().min(1.0) } else { f64::from(u8::from(from != to)) };
        let transmitted = if arriving > 0.0 { t.norm_sqr() * flow(&last).max(0.0) / arriving } else { 1.0 - reflected };
        result.reflected[polarisation] = reflected;
        result.transmitted[polarisation] = transmitted.clamp(0.0, 1.0 - reflected);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::super::Coating;
    use super::*;
    use proptest::prelude::*;

    fn film(index: f64) -> Film {
        Film::constant(index, 0.0)
    }

    fn uncoated(from: f64, to: f64, cos: f64) -> Split {
        Coating::BARE.split(from, to, 550.0, cos)
    }

    /// Fresnel's equations in sines and tangents of the angles.
    #[test]
    fn a_bare_surface_is_fresnels() {
        for (from, to) in [(1.0, 1.5f64), (1.5, 1.0), (1.5, 1.9)] {
            for angle in [0.1, 0.4, 0.7f64] {
                let sine = angle.sin() * from / to;
                let found = uncoated(from, to, angle.cos());
                if sine >= 1.0 {
                    assert_eq!(found, Split::MIRROR);
                    continue;
                }
                let other = sine.asin();
                let s = ((angle - other).sin() / (angle + other).sin()).powi(2);
                let p = ((angle - other).tan() / (angle + other).tan()).powi(2);
                assert!((found.reflected[0] - s).abs() < 1e-14 && (found.reflected[1] - p).abs() < 1e-14);
            }
        }
        let brewster = 1.5f64.atan();
        assert!(uncoated(1.0, 1.5, brewster.cos()).reflected[1] < 1e-30);
    }

    /// ((n₀ nₛ − n₁²) / (n₀ nₛ + n₁²))² for a quarter of a wave; half a wave is not there.
    #[test]
    fn quarter_and_half_waves() {
        for (layer, glass) in [(1.38, 1.52), (1.38, 1.9), (2.3, 1.52)] {
            let coated = |waves| Coating::of("test", vec![Layer::of_waves(film(layer), waves, 550.0)]);
            let expected = ((glass - layer * layer) / (glass + layer * layer)).powi(2);
            let found = coated(0.25).split(1.0, glass, 550.0, 1.0).mean_reflected();
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
            let found = coated(0.5).split(1.0, glass, 550.0, 1.0).mean_reflected();
            assert!((found - uncoated(1.0, glass, 1.0).mean_reflected()).abs() < 1e-14);
        }
    }

    /// Two quarter waves: ((n₀ n₂² − nₛ n₁²) / (n₀ n₂² + nₛ n₁²))².
    #[test]
    fn two_quarter_waves() {
        let (outer, inner, glass) = (1.38, 1.7, 1.52f64);
        let layers = [outer, inner].map(|n| Layer::of_waves(film(n), 0.25, 550.0));
        let found = Coating::of("test", layers.to_vec()).split(1.0, glass, 550.0, 1.0).mean_reflected();
        let (a, b) = (inner * inner, glass * outer * outer);
        assert!((found - ((a - b) / (a + b)).powi(2)).abs() < 1e-14);
    }

    /// A thick film of metal lets nothing through and reflects as its bulk: ((n − 1)² + k²) / ((n + 1)² + k²).
    #[test]
    fn a_metal_is_a_mirror() {
        let metal = Film::constant(0.06, 3.6);
        let found = Coating::of("metal", vec![Layer { film: metal, thickness_nm: 5e4 }]).split(1.0, 1.5, 550.0, 1.0);
        let bulk = (0.94f64.powi(2) + 3.6f64.powi(2)) / (1.06f64.powi(2) + 3.6f64.powi(2));
        assert!((found.mean_reflected() - bulk).abs() < 1e-12);
        assert_eq!(found.mean_transmitted(), 0.0);
    }

    #[test]
    fn along_the_surface_everything_turns() {
        let quarter = Coating::of("test", vec![Layer::of_waves(film(1.38), 0.25, 550.0)]);
        for split in [uncoated(1.0, 1.5, 0.0), quarter.split(1.0, 1.5, 550.0, 0.0)] {
            assert_eq!((split.reflected, split.transmitted), ([1.0; 2], [0.0; 2]));
        }
        assert_eq!(uncoated(1.5, 1.5, 0.0), Split::NOTHING);
        assert_eq!(uncoated(1.5, 1.5, 0.3), Split::NOTHING);
    }

    fn any_layer(absorbs: bool) -> impl Strategy<Value = Layer> {
        let k = if absorbs { 0.0..4.0 } else { 0.0..f64::MIN_POSITIVE };
        (1.2..2.6f64, k, 0.0..900.0f64).prop_map(move |(n, k, thickness_nm)| {
            let k = if absorbs { k } else { 0.0 };
            Layer { film: Film::constant(n, k), thickness_nm }
        })
    }

    fn any_stack(absorbs: bool) -> impl Strategy<Value = Vec<Layer>> {
        prop::collection::vec(any_layer(absorbs), 0..12)
    }

    proptest! {
        /// Nothing is lost in layers that absorb nothing: |R + T − 1| < 1e-12.
        #[test]
        fn energy_is_kept(
            layers in any_stack(false), from in 1.0..2.0f64, to in 1.0..2.0f64, cos in 0.0..=1.0f64, nm in 350.0..900.0f64
        ) {
            let found = split(layers.iter(), from, to, nm, cos);
            for polarisation in 0..2 {
                let [r, t] = [found.reflected[polarisation], found.transmitted[polarisation]];
                prop_assert!((r + t - 1.0).abs() < 1e-12, "{r} {t}");
            }
        }

        /// Absorption by layers is never negative, and is equal for light from either side that gets through.
        #[test]
        fn absorption_is_positive(
            layers in any_stack(true), from in 1.0..2.0f64, to in 1.0..2.0f64, cos in 0.01..=1.0f64, nm in 350.0..900.0f64
        ) {
            let there = split(layers.iter(), from, to, nm, cos);
            let sine = from / to * (1.0 - cos * cos).sqrt();
            for polarisation in 0..2 {
                let [r, t] = [there.reflected[polarisation], there.transmitted[polarisation]];
                prop_assert!(r.is_finite() && t.is_finite() && r >= 0.0 && t >= 0.0 && r + t <= 1.0 + 1e-12);
                if sine < 0.9999 {
                    let back = split(layers.iter().rev(), to, from, nm, (1.0 - sine * sine).sqrt());
                    prop_assert!((back.transmitted[polarisation] - t).abs() < 1e-9, "{t} {}", back.transmitted[polarisation]);
                }
            }
        }
    }
}
