//! Tables of other renderers: pbrt's four columns, and FlareSim's six under a line `surfaces:`.

use crate::glass::{Catalogue, Medium};
use crate::prescription::{NextMedium, Place};

use super::draft::{Draft, MOST_SURFACES};
use super::draft_row::DraftRow;
use super::glass_names::Glasses;
use super::problem::{LensFileError, Problem, at};
use super::remarks::Reading;
use super::text::{Token, finite, not_a_number, tokens};

/// pbrt's: radius, thickness, index behind the surface and diameter, mm, object side first; radius 0 is the stop, and 0 the index
/// there. (Pharr, Jakob and Humphreys, *Physically Based Rendering*, third edition, §6.4.1.)
///
/// A flat glass surface cannot be written by pbrt. Here a row of radius 0 is the stop where nothing is refracted: the medium is the same
/// before and behind. Further ones are fixed stops; where the medium changes, the surface is taken for a flat one. Both are said. If the
/// medium changes at every one of them, the first is the stop, on its glass.
pub fn parse_pbrt(text: &str, file: &str, catalogue: &Catalogue) -> Result<Reading, LensFileError> {
    let mut table = ColumnTable::new(file, catalogue);
    // Rows of radius 0 where the medium changes.
    let mut flat: Vec<(usize, Place)> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if let Some(comment) = line.trim_start().strip_prefix('#') {
            // The first remark names the lens, as in the files that come with pbrt.
            let comment = comment.trim();
            if table.draft.name.is_none() && table.draft.rows.is_empty() && !comment.is_empty() {
                table.draft.name = Some(comment.to_owned());
            }
            continue;
        }
        let words = tokens(line.split('#').next().unwrap_or(""));
        if words.is_empty() {
            continue;
        }
        if words.len() != 4 {
            let column = words.get(4).unwrap_or(&words[0]).column;
            let expected = "radius, thickness, index and diameter".to_owned();
            return Err(at(file, i + 1, column, Problem::Malformed { found: line.trim().to_owned(), expected }));
        }
        let [radius, thickness] = [table.number(i, &words[0], "radius")?, table.number(i, &words[1], "thickness")?];
        let diameter = table.number(i, &words[3], "diameter")?;
        let index = table.number(i, &words[2], "index")?;
        let medium = if index == 0.0 { Ok(Medium::air()) } else { table.medium(i, &words[2], index, 0.0) }?;
        let before = match table.draft.rows.last().map(|row| &row.behind) {
            Some(NextMedium::Medium(before)) => before.clone(),
            _ => Medium::air(),
        };
        let is_stop = radius == 0.0 && medium == before;
        if radius == 0.0 && !is_stop {
            flat.push((table.draft.rows.len(), Place { line: i + 1, column: words[0].column }));
        }
        table.row(i, &words[0], is_stop, [radius, thickness, diameter / 2.0], medium)?;
    }
    if table.draft.stop.is_none() && !flat.is_empty() {
        table.draft.stop = Some(flat.remove(0).0);
    }
    for (_, place) in flat {
        table
            .draft
            .remarks
            .say(place, "radius 0 where the medium changes; it is taken for flat glass, where pbrt has a stop");
    }
    table.draft.finish()
}

/// FlareSim's: lines `key: text`, then after `surfaces:` rows of radius (or `stop`, `inf`), thickness, index and Abbe number behind the
/// surface, half of the clear diameter, and the number of layers of its coating. (As its sample lenses have it.)
pub fn parse_flaresim(text: &str, file: &str, catalogue: &Catalogue) -> Result<Reading, LensFileError> {
    let mut table = ColumnTable::new(file, catalogue);
    let mut in_rows = false;
    for (i, line) in text.lines().enumerate() {
        let words = tokens(line.split('#').next().unwrap_or(""));
        let Some(first) = words.first() else { continue };
        if !in_rows {
            let (key, value) = line.split_once(':').unwrap_or((line, ""));
            let (key, value) = (key.trim().to_lowercase(), value.trim());
            match key.as_str() {
                "surfaces" => in_rows = true,
                "name" => table.draft.name = Some(value.to_owned()),
                "focal_length" => {
                    let mm = finite(value)
                        .ok_or_else(|| at(file, i + 1, first.column, not_a_number("focal_length", value)))?;
                    table.draft.metadata.focal_length_mm = Some(mm);
                    table.draft.header("focal_length", mm);
                }
                _ => table.draft.header(&key, value),
            }
            continue;
        }
        if !(5..=6).contains(&words.len()) {
            let expected = "radius, thickness, index, Abbe number, half diameter and coating".to_owned();
            return Err(at(file, i + 1, first.column, Problem::Malformed { found: line.trim().to_owned(), expected }));
        }
        let is_stop = first.text.eq_ignore_ascii_case("stop");
        let flat = is_stop || first.text.eq_ignore_ascii_case("inf");
        let radius = if flat { 0.0 } else { table.number(i, first, "radius")? };
        let thickness = table.number(i, &words[1], "thickness")?;
        let [index, abbe] = [table.number(i, &words[2], "index")?, table.number(i, &words[3], "Abbe number")?];
        let semi = table.number(i, &words[4], "half diameter")?;
        let medium = table.medium(i, &words[2], index, abbe)?;
        if words.get(5).is_some_and(|word| word.text != "0") {
            let place = Place { line: i + 1, column: words[5].column };
            table.draft.remarks.once("coating", place, "coatings are left out");
        }
        table.row(i, first, is_stop, [radius, thickness, semi], medium)?;
    }
    table.draft.finish()
}

struct ColumnTable<'a> {
    draft: Draft<'a>,
    glasses: Glasses<'a>,
}

impl<'a> ColumnTable<'a> {
    fn new(file: &'a str, catalogue: &'a Catalogue) -> Self {
        Self { draft: Draft::new(file), glasses: Glasses::new(catalogue, None) }
    }

    fn number(&self, line: usize, word: &Token<'_>, what: &str) -> Result<f64, LensFileError> {
        finite(word.text).ok_or_else(|| at(self.draft.file, line + 1, word.column, not_a_number(what, word.text)))
    }

    /// A medium by its numbers; index 1 is air.
    fn medium(&self, line: usize, word: &Token<'_>, index: f64, abbe: f64) -> Result<Medium, LensFileError> {
        if index == 1.0 {
            return Ok(Medium::air());
        }
        let medium = self.glasses.by_numbers(index, abbe);
        medium.map_err(|error| at(self.draft.file, line + 1, word.column, error.into()))
    }

    /// A surface by radius, thickness and half of its diameter.
    fn row(
        &mut self,
        line: usize,
        word: &Token<'_>,
        is_stop: bool,
        [radius, thickness, semi]: [f64; 3],
        medium: Medium,
    ) -> Result<(), LensFileError> {
        let place = Place { line: line + 1, column: word.column };
        if self.draft.rows.len() >= MOST_SURFACES {
            return self.draft.fail(place, Problem::Unsupported("a lens has no more than 1000 surfaces".to_owned()));
        }
        if is_stop {
            match self.draft.stop {
                None => self.draft.stop = Some(self.draft.rows.len()),
                Some(_) => self.draft.remarks.say(place, "a second stop; it is taken for a fixed one"),
            }
        }
        let mut row = DraftRow::new(place);
        row.curvature = if radius == 0.0 { 0.0 } else { 1.0 / radius };
        row.thickness_mm = thickness;
        row.behind = NextMedium::Medium(medium);
        row.semi_diameter_mm = Some(semi);
        row.has_rim = true;
        self.draft.rows.push(row);
        Ok(())
    }
}
