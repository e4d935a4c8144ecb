//! Media as the refractiveindex.info database has them: a `.yml` file a medium.
//!
//! Blocks `- type:` under `DATA:`: `formula 1` to `formula 9` with `wavelength_range` and `coefficients`, or `tabulated n`, `nk`, `k` with
//! `data: |` and rows of numbers; wavelengths in µm. (The database's document "Dispersion formulas".) Only this subset is read, not
//! YAML at large. Indices are as the file has them: most of glasses are relative to air, those of crystals and liquids often not.

use std::f64::consts::PI;

use crate::glass::{Dispersion, InternalTransmittance, Medium};
use crate::prescription::Place;

use super::problem::{LensFileError, Problem, at};
use super::text::{self, finite, not_a_number, tokens};

/// Thickness for which extinction is turned into transmittance, mm: any would do.
const PLATE_MM: f64 = 10.0;

/// A block of data.
#[derive(Default)]
struct DataBlock {
    kind: String,
    place: Place,
    range_um: Option<[f64; 2]>,
    numbers: Vec<f64>,
    rows: Vec<Vec<f64>>,
    in_rows: bool,
}

/// The medium of a file, by the name that it shall have.
pub fn parse_bytes(bytes: &[u8], file: &str, name: &str) -> Result<Medium, LensFileError> {
    parse(&text::any_encoding(bytes, file)?, file, name)
}

/// The medium in the text of a file, by the name that it shall have.
pub fn parse(text: &str, file: &str, name: &str) -> Result<Medium, LensFileError> {
    let mut medium: Option<Medium> = None;
    let mut transmittance = None;
    for block in blocks(text, file)? {
        let fail = |what: String| Err(at(file, block.place.line, block.place.column, Problem::Unsupported(what)));
        let column =
            |i: usize| block.rows.iter().filter_map(|row| Some([*row.first()?, *row.get(i)?])).collect::<Vec<_>>();
        let dispersion = match block.kind.split_once(' ') {
            Some(("formula", number)) => dispersion(number.trim(), &block.numbers),
            Some(("tabulated", "n" | "nk")) => Dispersion::through(column(1)),
            Some(("tabulated", "k")) => None,
            _ => return fail(format!("data of type '{}' are not known", block.kind)),
        };
        let extinction = match block.kind.as_str() {
            "tabulated nk" => column(2),
            "tabulated k" => column(1),
            _ => Vec::new(),
        };
        if !extinction.is_empty() {
            let after = |[um, k]: [f64; 2]| [um * 1000.0, (-4.0 * PI * k * PLATE_MM / (um / 1000.0)).exp(), PLATE_MM];
            transmittance = InternalTransmittance::new(extinction.into_iter().map(after).collect());
        }
        if block.kind == "tabulated k" || medium.is_some() {
            continue;
        }
        let Some(dispersion) = dispersion else {
            return fail(format!(
                "{} with {} numbers makes no index",
                block.kind,
                block.numbers.len() + block.rows.len()
            ));
        };
        let ends = || Some([block.rows.first()?.first()? * 1000.0, block.rows.last()?.first()? * 1000.0]);
        let range_nm = block.range_um.map(|range| range.map(|um| um * 1000.0)).or_else(ends);
        let found = Medium::new(name, dispersion, range_nm.unwrap_or([0.0, f64::INFINITY]), file);
        let middle = found.index(crate::glass::line_nm::D);
        if !(0.5..=6.0).contains(&middle) {
            return fail(format!("its numbers make an index of {middle:.4} at d"));
        }
        if let Some(nm) = found.hole_nm() {
            return fail(format!("its numbers make no index at {nm} nm"));
        }
        medium = Some(found);
    }
    let missing = || at(file, 1, 1, Problem::Unsupported("there is no index in DATA".to_owned()));
    let medium = medium.ok_or_else(missing)?;
    Ok(match transmittance {
        Some(known) => medium.with_transmittance(known),
        None => medium,
    })
}

fn blocks(text: &str, file: &str) -> Result<Vec<DataBlock>, LensFileError> {
    let mut blocks: Vec<DataBlock> = Vec::new();
    let mut in_data = false;
    for (i, line) in text.lines().enumerate() {
        let words = tokens(line);
        let Some(first) = words.first() else { continue };
        if !line.starts_with([' ', '\t', '-']) {
            in_data = first.text == "DATA:";
            continue;
        }
        let numbers = |from: usize| -> Result<Vec<f64>, LensFileError> {
            let number = |word: &text::Token<'_>| {
                finite(word.text).ok_or_else(|| at(file, i + 1, word.column, not_a_number("number", word.text)))
            };
            words.iter().skip(from).map(number).collect()
        };
        let trimmed = line.trim().trim_start_matches('-').trim_start();
        if !in_data {
            continue;
        }
        if let Some(kind) = trimmed.strip_prefix("type:") {
            let place = Place { line: i + 1, column: first.column };
            blocks.push(DataBlock { kind: kind.trim().trim_matches('"').to_owned(), place, ..DataBlock::default() });
            continue;
        }
        let Some(block) = blocks.last_mut() else { continue };
        match first.text {
            "wavelength_range:" | "range:" => {
                if let [from, to, ..] = numbers(1)?[..] {
                    block.range_um = Some([from, to]);
                }
            }
            "coefficients:" => block.numbers = numbers(1)?,
            "data:" => block.in_rows = true,
            _ if block.in_rows && finite(first.text).is_some() => block.rows.push(numbers(0)?),
            _ => block.in_rows = false,
        }
    }
    Ok(blocks)
}

/// Formula 1 to 9 of the database.
pub fn dispersion(number: &str, c: &[f64]) -> Option<Dispersion> {
    let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
    let (&a, rest) = c.split_first()?;
    let pairs =
        || -> Vec<[f64; 2]> { rest.chunks(2).map(|pair| [pair[0], pair.get(1).copied().unwrap_or(0.0)]).collect() };
    Some(match number {
        "1" => Dispersion::Sellmeier { a, terms: pairs().into_iter().map(|[b, root]| [b, root * root]).collect() },
        "2" => Dispersion::Sellmeier { a, terms: pairs() },
        "3" => Dispersion::Polynomial { a, terms: pairs() },
        "4" => {
            // Two poles of four numbers each, then powers.
            let (poles, powers) = rest.split_at(rest.len().min(8));
            let pole = |four: &[f64]| [four[0], four[1], four[2].powf(four[3])];
            let poles = poles.chunks_exact(4).map(pole).filter(|pole| pole[0] != 0.0).collect();
            Dispersion::Rational { a, powers: powers.as_chunks::<2>().0.to_vec(), poles }
        }
        "5" => Dispersion::Cauchy { a, terms: pairs() },
        "6" => Dispersion::Gas { a, terms: pairs() },
        "7" => Dispersion::Herzberger([a, at(1), at(2), at(3), at(4), at(5)]),
        "8" => Dispersion::Retro([a, at(1), at(2), at(3)]),
        "9" => Dispersion::Exotic([a, at(1), at(2), at(3), at(4), at(5)]),
        _ => return None,
    })
}
