//! Glass catalogues as design programs write them: `.agf`.
//!
//! A line starts with two letters: `NM` name, formula, nd and Vd of a new glass; `CD` its coefficients, `LD` the wavelengths in
//! µm that they hold for, `IT` wavelength, transmittance and thickness in mm. Indices are relative to air at the
//! catalogue's temperature, as ours are. The formulas, by number, wavelengths in µm (OpticStudio's manual, "Glass dispersion
//! formulas"):
//!
//! | number | formula |
//! |---|---|
//! | 1 Schott | n² = a0 + a1 l² + a2 l⁻² + a3 l⁻⁴ + a4 l⁻⁶ + a5 l⁻⁸ |
//! | 2, 6, 11 Sellmeier 1, 3, 5 | n² = 1 + Σ K l² / (l² − L), three, four, five terms |
//! | 3 Herzberger | n = A + B L + C L² + D l² + E l⁴ + F l⁶, L = 1 / (l² − 0.028) |
//! | 4 Sellmeier 2 | n² = 1 + A + B1 l² / (l² − l1²) + B2 / (l² − l2²) |
//! | 5 Conrady | n = n0 + A / l + B / l^3.5 |
//! | 7, 8 Handbook of Optics | n² = A + B / (l² − C) − D l², n² = A + B l² / (l² − C) − D l² |
//! | 9 Sellmeier 4 | n² = A + B l² / (l² − C) + D l² / (l² − E) |
//! | 10, 12, 13 extended | 1 with further powers |

use crate::glass::{Dispersion, InternalTransmittance, Medium, line_nm};
use crate::prescription::Place;

use super::problem::{LensFileError, Problem, at};
use super::remarks::{Remark, Remarks};
use super::text::{self, Token, finite, not_a_number, tokens};

/// Largest difference of the index at d from the one that the file states: catalogues print five or six digits.
const PRINTED: f64 = 2e-5;
/// A catalogue of more glasses is none.
const MOST_GLASSES: usize = 20_000;

/// A glass while its lines are read.
struct GlassLines {
    name: String,
    place: Place,
    formula: u32,
    /// The index at d, as printed.
    nd: Option<f64>,
    numbers: Vec<f64>,
    range_um: Option<[f64; 2]>,
    transmittance: Vec<[f64; 3]>,
}

impl GlassLines {
    /// A glass of which only the first line is read.
    fn new(name: &str, place: Place, formula: u32, nd: Option<f64>) -> Self {
        let (numbers, transmittance) = (Vec::new(), Vec::new());
        Self { name: name.to_owned(), place, formula, nd, numbers, range_um: None, transmittance }
    }
}

/// The glasses of a catalogue, with remarks on those that could not be used and are left out.
pub fn parse_bytes(bytes: &[u8], file: &str) -> Result<(Vec<Medium>, Vec<Remark>), LensFileError> {
    parse(&text::any_encoding(bytes, file)?, file)
}

/// The glasses in the text of a catalogue, with remarks on those that could not be used and are left out.
pub fn parse(text: &str, file: &str) -> Result<(Vec<Medium>, Vec<Remark>), LensFileError> {
    let mut remarks = Remarks::default();
    let mut media = Vec::new();
    let mut entry: Option<GlassLines> = None;
    for (i, line) in text.lines().enumerate() {
        let words = tokens(line);
        let Some((key, rest)) = words.split_first() else { continue };
        let place = |word: &Token<'_>| Place { line: i + 1, column: word.column };
        let number = |word: &Token<'_>, what: &str| {
            finite(word.text).ok_or_else(|| at(file, i + 1, word.column, not_a_number(what, word.text)))
        };
        match key.text.to_uppercase().as_str() {
            "NM" => {
                media.extend(entry.take().and_then(|entry| finished(entry, file, &mut remarks)));
                let [name, formula, ..] = rest else {
                    let expected = "name, formula, number, nd and Vd of the glass".to_owned();
                    let problem = Problem::Malformed { found: line.trim().to_owned(), expected };
                    return Err(at(file, i + 1, key.column, problem));
                };
                // Some programs write the number of the formula as 2.000000.
                let formula = number(formula, "number of the formula")?.clamp(0.0, 99.0) as u32;
                let nd = rest.get(3).and_then(|word| finite(word.text)).filter(|nd| *nd > 0.5);
                entry = Some(GlassLines::new(name.text, place(name), formula, nd));
                if media.len() > MOST_GLASSES {
                    return Err(at(file, i + 1, 1, Problem::TooLong { largest: bytes_of(text) }));
                }
            }
            "CD" => {
                if let Some(entry) = &mut entry {
                    entry.numbers = rest.iter().map(|word| number(word, "coefficient")).collect::<Result<_, _>>()?;
                }
            }
            "LD" => {
                if let (Some(entry), [from, to, ..]) = (&mut entry, rest) {
                    entry.range_um = Some([number(from, "wavelength")?, number(to, "wavelength")?]);
                }
            }
            // Where nothing is known, makers put signs of many kinds.
            "IT" => {
                if let (Some(entry), [nm, part, mm, ..]) = (&mut entry, rest) {
                    let all = [nm, part, mm].map(|word| finite(word.text).unwrap_or(-1.0));
                    entry.transmittance.push([all[0] * 1000.0, all[1], all[2]]);
                }
            }
            // Comments, thermal and chemical data, prices.
            "CC" | "GC" | "ED" | "TD" | "OD" | "MD" | "BD" => {}
            other if entry.is_none() && media.is_empty() => {
                let expected = "CC or NM of a glass catalogue".to_owned();
                return Err(at(file, i + 1, key.column, Problem::Malformed { found: other.to_owned(), expected }));
            }
            other => remarks.once(other, place(key), format!("'{other}' is not understood and left out")),
        }
    }
    media.extend(entry.take().and_then(|entry| finished(entry, file, &mut remarks)));
    if media.is_empty() {
        return Err(at(file, 1, 1, Problem::Unsupported("no glass of this catalogue can be used".to_owned())));
    }
    Ok((media, remarks.finish(file)))
}

fn bytes_of(text: &str) -> usize {
    text.len()
}

/// The glass of an entry; `None`, with a remark, if there is none.
fn finished(entry: GlassLines, file: &str, remarks: &mut Remarks) -> Option<Medium> {
    let mut left_out = |why: &str| remarks.say(entry.place, format!("'{}' is left out: {why}", entry.name));
    let Some(dispersion) = dispersion(entry.formula, &entry.numbers) else {
        left_out(&format!("formula {} with {} coefficients is not known", entry.formula, entry.numbers.len()));
        return None;
    };
    let range_nm = entry.range_um.map_or([0.0, f64::INFINITY], |range| range.map(|um| um * 1000.0));
    let mut medium = Medium::new(&entry.name, dispersion, range_nm, file);
    let index = medium.index(line_nm::D);
    // A glass for the infrared has a range without d.
    let has_d = medium.is_known_between(line_nm::D, line_nm::D);
    if !(0.9..=6.0).contains(&index) {
        left_out(&format!("its coefficients make an index of {index:.4} at d"));
        return None;
    }
    if let Some(nm) = medium.hole_nm() {
        left_out(&format!("its coefficients make no index at {nm} nm"));
        return None;
    }
    if let Some(nd) = entry.nd.filter(|nd| has_d && (nd - index).abs() > PRINTED) {
        let text = format!("'{}': its coefficients make an index of {index:.6} at d, the file says {nd}", entry.name);
        remarks.say(entry.place, text);
    }
    if let Some(known) = InternalTransmittance::new(entry.transmittance) {
        medium = medium.with_transmittance(known);
    }
    Some(medium)
}

/// The formula of a number; trailing coefficients that are 0 may be there or not.
pub fn dispersion(formula: u32, numbers: &[f64]) -> Option<Dispersion> {
    let c = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
    if !numbers.iter().any(|x| *x != 0.0) {
        return None;
    }
    let power_series = |powers: &[f64]| {
        let used = numbers.iter().skip(powers.len() + 1).all(|x| *x == 0.0);
        let terms = powers.iter().enumerate().map(|(i, power)| [c(i + 1), *power]).collect();
        used.then(|| Dispersion::Polynomial { a: c(0), terms })
    };
    let sellmeier = |count: usize| {
        let used = numbers.iter().skip(2 * count).all(|x| *x == 0.0);
        let terms = (0..count).map(|i| [c(2 * i), c(2 * i + 1)]).collect();
        used.then_some(Dispersion::Sellmeier { a: 0.0, terms })
    };
    match formula {
        1 => power_series(&[2.0, -2.0, -4.0, -6.0, -8.0]),
        2 => sellmeier(3),
        3 => Some(Dispersion::Herzberger([c(0), c(1), c(2), c(3), c(4), c(5)])),
        4 => {
            let poles = vec![[c(1), 2.0, c(2) * c(2)], [c(3), 0.0, c(4) * c(4)]];
            Some(Dispersion::Rational { a: 1.0 + c(0), powers: Vec::new(), poles })
        }
        5 => Some(Dispersion::Cauchy { a: c(0), terms: vec![[c(1), -1.0], [c(2), -3.5]] }),
        6 => sellmeier(4),
        7 | 8 => {
            let power = if formula == 7 { 0.0 } else { 2.0 };
            Some(Dispersion::Rational { a: c(0), powers: vec![[-c(3), 2.0]], poles: vec![[c(1), power, c(2)]] })
        }
        9 => {
            let poles = vec![[c(1), 2.0, c(2)], [c(3), 2.0, c(4)]];
            Some(Dispersion::Rational { a: c(0), powers: Vec::new(), poles })
        }
        10 => power_series(&[2.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0]),
        11 => sellmeier(5),
        12 => power_series(&[2.0, -2.0, -4.0, -6.0, -8.0, 4.0, 6.0]),
        13 => power_series(&[2.0, 4.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0]),
        _ => None,
    }
}
