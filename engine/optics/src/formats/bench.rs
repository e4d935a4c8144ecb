//! The text tables of the Optical Bench (photonstophotos.net), in which many published patents are collected.
//!
//! Sections in brackets; columns are separated by tabs, and an empty one counts. `[lens data]`: number of the surface, radius (`AS`:
//! the stop, `FS`: a field stop, `CG`: a plane of the cover glass), thickness or the name of one, index, diameter, Abbe number, glass and
//! its maker. `[variable distances]`: by position of the groups the values of `d5`, `Bf` and others, and the focal length; distances `d0`
//! are from the object to the first surface. `[aspherical data]`: number, radius, conic constant, and the coefficients of r⁴, r⁶ …;
//! with the constant `AsphericalA2` those of r², r⁴ …, with `AsphericalOddCount` those of r³, r⁴, r⁵ …

use std::collections::HashMap;

use crate::glass::{Catalogue, Medium};
use crate::prescription::moving::{Part, Position, Quantity};
use crate::prescription::{NextMedium, Place};

use super::draft::{Draft, MOST_SURFACES};
use super::draft_row::DraftRow;
use super::glass_names::Glasses;
use super::problem::{LensFileError, Problem, at};
use super::remarks::Reading;
use super::text::{Token, finite, not_a_number};

/// Radii of the two tables that differ by more, relative, are of different surfaces.
const SAME_RADIUS: f64 = 1e-3;
/// The line that gives the diameter of the diaphragm.
const STOP: &str = "Aperture Diameter";
/// A table of more positions is none.
const MOST_POSITIONS: usize = 100;

/// Reads the text of a table.
pub fn parse(text: &str, file: &str, catalogue: &Catalogue) -> Result<Reading, LensFileError> {
    let mut reader = BenchReader::new(file, catalogue);
    let mut section = String::new();
    for (i, line) in text.lines().enumerate() {
        let cells = cells(line);
        let Some(first) = cells.first() else { continue };
        if first.text.starts_with('[') {
            section = first.text.to_lowercase();
            continue;
        }
        match section.as_str() {
            "[descriptive data]" => reader.descriptive(&cells),
            "[constants]" => reader.constants.push(first.text.to_owned()),
            "[variable distances]" => reader.variable(i + 1, &cells)?,
            "[lens data]" => reader.surface(i + 1, &cells)?,
            "[aspherical data]" => reader.asphere(i + 1, &cells)?,
            // Pictures, focal lengths of groups, remarks of who typed it.
            "[figure]" | "[notes]" | "[group data]" | "[patent info]" | "[report data]" => {}
            other => {
                let place = Place { line: i + 1, column: 1 };
                reader.draft.remarks.once(other, place, format!("section '{other}' is left out"));
            }
        }
    }
    reader.finish()
}

/// The cells of a line, between tabs; trailing empty ones are none. Without any tab, the words.
fn cells(line: &str) -> Vec<Token<'_>> {
    if !line.contains('\t') {
        let words = super::text::tokens(line);
        let is_row = words.first().is_some_and(|word| word.text.starts_with(|c: char| c.is_ascii_digit()));
        if is_row || words.is_empty() {
            return words;
        }
        return vec![Token { text: line.trim(), column: words[0].column }];
    }
    let mut column = 1;
    let mut cells = Vec::new();
    for cell in line.split('\t') {
        let blank = cell.chars().take_while(|c| c.is_whitespace()).count();
        cells.push(Token { text: cell.trim(), column: column + blank });
        column += cell.chars().count() + 1;
    }
    while cells.last().is_some_and(|cell| cell.text.is_empty()) {
        cells.pop();
    }
    cells
}

/// A line of the positions: its values, `None` where nothing is known.
struct Variable {
    values: Vec<Option<f64>>,
    place: Place,
}

struct BenchReader<'a> {
    draft: Draft<'a>,
    glasses: Glasses<'a>,
    constants: Vec<String>,
    variables: HashMap<String, Variable>,
    /// Index of the surface, by its number in the file.
    numbers: HashMap<String, usize>,
    /// Surfaces whose thickness has a name.
    named: Vec<(usize, String, Place)>,
}

impl<'a> BenchReader<'a> {
    fn new(file: &'a str, catalogue: &'a Catalogue) -> Self {
        Self {
            draft: Draft::new(file),
            glasses: Glasses::new(catalogue, None),
            constants: Vec::new(),
            variables: HashMap::new(),
            numbers: HashMap::new(),
            named: Vec::new(),
        }
    }

    fn number(&self, line: usize, cell: &Token<'_>, what: &str) -> Result<f64, LensFileError> {
        finite(cell.text).ok_or_else(|| at(self.draft.file, line, cell.column, not_a_number(what, cell.text)))
    }

    fn descriptive(&mut self, cells: &[Token<'_>]) {
        if let [key, value, ..] = cells {
            if key.text.eq_ignore_ascii_case("title") {
                self.draft.name = Some(value.text.to_owned());
            } else {
                self.draft.header(&key.text.to_lowercase(), value.text);
            }
        }
    }

    fn variable(&mut self, line: usize, cells: &[Token<'_>]) -> Result<(), LensFileError> {
        let Some((name, values)) = cells.split_first() else { return Ok(()) };
        let value = |cell: &Token<'_>| match cell.text {
            "" | "undefined" => Ok(None),
            "Infinity" => Ok(Some(f64::INFINITY)),
            // A difference to the position before, for the reader's eye.
            text if text.starts_with('+') => Ok(None),
            _ => self.number(line, cell, name.text).map(Some),
        };
        let values = values.iter().take(MOST_POSITIONS).map(value).collect::<Result<Vec<_>, _>>();
        // Names of pictures and other words stand in this section, too.
        let is_distance = name.text.starts_with('d') || name.text == "Bf" || name.text == "Focal Length";
        match values {
            Ok(values) => {
                let place = Place { line, column: name.column };
                self.variables.insert(name.text.to_owned(), Variable { values, place });
                Ok(())
            }
            Err(error) if is_distance => Err(error),
            Err(_) => Ok(()),
        }
    }

    fn surface(&mut self, line: usize, cells: &[Token<'_>]) -> Result<(), LensFileError> {
        let empty = Token { text: "", column: 1 };
        let cell = |i: usize| cells.get(i).copied().unwrap_or(empty);
        let place = Place { line, column: cell(0).column };
        if cells.len() < 3 {
            let expected = "number, radius, thickness, index, diameter and Abbe number".to_owned();
            let found = cells.iter().map(|cell| cell.text).collect::<Vec<_>>().join(" ");
            return self.draft.fail(place, Problem::Malformed { found, expected });
        }
        if self.draft.rows.len() >= MOST_SURFACES {
            return self.draft.fail(place, Problem::Unsupported("a lens has no more than 1000 surfaces".to_owned()));
        }
        let mut row = DraftRow::new(place);
        row.has_rim = true;
        let index = self.draft.rows.len();
        match cell(1).text {
            "AS" => {
                if let Some(first) = self.draft.stop {
                    let what = format!("a second stop beside surface {first}; it is taken for a fixed one");
                    self.draft.remarks.say(place, what);
                } else {
                    self.draft.stop = Some(index);
                }
            }
            "FS" | "CG" | "Infinity" | "-Infinity" | "" => {}
            "M" | "Mirror" => {
                let what = "mirrors of the Optical Bench are not supported".to_owned();
                return self.draft.fail(place, Problem::Unsupported(what));
            }
            _ => {
                let radius = self.number(line, &cell(1), "radius")?;
                row.curvature = if radius == 0.0 { 0.0 } else { 1.0 / radius };
            }
        }
        match finite(cell(2).text) {
            Some(thickness) => row.thickness_mm = thickness,
            None if cell(2).text.is_empty() => {}
            None => self.named.push((index, cell(2).text.to_owned(), Place { line, column: cell(2).column })),
        }
        row.behind = NextMedium::Medium(self.medium(line, &[cell(3), cell(5), cell(6), cell(7)])?);
        if !cell(4).text.is_empty() {
            row.semi_diameter_mm = Some(self.number(line, &cell(4), "diameter")? / 2.0);
        }
        self.numbers.insert(cell(0).text.to_owned(), index);
        self.draft.rows.push(row);
        Ok(())
    }

    /// The medium of an index, an Abbe number, and the glass's name and maker, if they are known here and have that index.
    fn medium(&mut self, line: usize, [nd, abbe, name, maker]: &[Token<'_>; 4]) -> Result<Medium, LensFileError> {
        if nd.text.is_empty() {
            return Ok(Medium::air());
        }
        let index = self.number(line, nd, "index")?;
        if index == 1.0 {
            return Ok(Medium::air());
        }
        let abbe = if abbe.text.is_empty() { 0.0 } else { self.number(line, abbe, "Abbe number")? };
        if !name.text.is_empty() {
            let place = Place { line, column: name.column };
            let maker = Some(maker.text).filter(|maker| !maker.is_empty());
            let mut unsaid = super::remarks::Remarks::default();
            match self.glasses.squeezed(name.text, maker, place, &mut unsaid) {
                // Whoever typed the table found the glass by its numbers: one that has others is another.
                Ok(medium) if (medium.index(crate::glass::line_nm::D) - index).abs() < 1e-3 => return Ok(medium),
                _ => {
                    let what =
                        format!("glass '{}' is not known with that index; index and Abbe number are taken", name.text);
                    self.draft.remarks.say(place, what);
                }
            }
        } else if abbe == 0.0 {
            let place = Place { line, column: nd.column };
            self.draft.remarks.once("no Abbe number", place, "a glass without an Abbe number does not disperse");
        }
        let medium = self.glasses.by_numbers(index, abbe);
        medium.map_err(|error| at(self.draft.file, line, nd.column, error.into()))
    }

    fn asphere(&mut self, line: usize, cells: &[Token<'_>]) -> Result<(), LensFileError> {
        let [number, radius, rest @ ..] = cells else {
            let place = Place { line, column: 1 };
            let expected = "number, radius, conic constant and coefficients of an asphere".to_owned();
            let found = cells.first().map_or("", |cell| cell.text).to_owned();
            return self.draft.fail(place, Problem::Malformed { found, expected });
        };
        let place = Place { line, column: number.column };
        let Some(&index) = self.numbers.get(number.text) else {
            let expected = "the number of a surface in [lens data]".to_owned();
            return self.draft.fail(place, Problem::Malformed { found: number.text.to_owned(), expected });
        };
        let radius_mm = if matches!(radius.text, "Infinity" | "-Infinity" | "") {
            0.0
        } else {
            self.number(line, radius, "radius")?
        };
        let curvature = if radius_mm == 0.0 { 0.0 } else { 1.0 / radius_mm };
        let of_surface = self.draft.rows[index].curvature;
        if (curvature - of_surface).abs() > SAME_RADIUS * of_surface.abs() {
            let what = format!("radius {} is not that of the surface in [lens data], which is kept", radius.text);
            self.draft.remarks.say(Place { line, column: radius.column }, what);
        }
        let value =
            |cell: &Token<'_>| if cell.text.is_empty() { Ok(0.0) } else { self.number(line, cell, "coefficient") };
        let values: Vec<f64> = rest.iter().map(value).collect::<Result<_, _>>()?;
        let Some((&conic, coefficients)) = values.split_first() else { return Ok(()) };
        let has = |name: &str| self.constants.iter().any(|constant| constant == name);
        let (first, step) = if has("AsphericalOddCount") {
            (3, 1)
        } else if has("AsphericalA2") {
            (2, 2)
        } else {
            (4, 2)
        };
        let terms = coefficients.iter().zip((first..).step_by(step)).filter(|(a, _)| **a != 0.0);
        let terms = terms.map(|(a, power)| (power, *a)).collect();
        let row = &mut self.draft.rows[index];
        row.conic = conic;
        row.terms = terms;
        Ok(())
    }

    /// The value of a variable in a position.
    fn value(&self, name: &str, position: usize) -> Option<f64> {
        self.variables.get(name).and_then(|variable| variable.values.get(position).copied().flatten())
    }

    fn finish(mut self) -> Result<Reading, LensFileError> {
        for (surface, name, place) in &self.named {
            let Some(first) = self.value(name, 0).filter(|x| x.is_finite()) else {
                let expected = "a number, or the name of a line in [variable distances]".to_owned();
                return self.draft.fail(*place, Problem::Malformed { found: name.clone(), expected });
            };
            self.draft.rows[*surface].thickness_mm = first;
        }
        self.film_behind();
        if let Some(angle) = self.value("Angle of View", 0).filter(|x| *x > 0.0 && *x < 360.0) {
            self.draft.metadata.half_field_deg = Some(angle / 2.0);
            self.draft.header("half_field_deg", angle / 2.0);
        }
        for (name, key) in
            [("F-Number", "f_number"), ("Focal Length", "focal_length"), ("Image Height", "image_diagonal")]
        {
            if let Some(value) = self.value(name, 0).filter(|x| x.is_finite()) {
                self.draft.header(key, value);
            }
        }
        self.draft.metadata.f_number = self.value("F-Number", 0).filter(|x| x.is_finite());
        self.draft.metadata.focal_length_mm = self.value("Focal Length", 0).filter(|x| x.is_finite());
        self.positions();
        self.note_other_stops();
        self.draft.finish()
    }

    /// The film stands `Bf` behind the last surface, unless that has a distance of its own.
    fn film_behind(&mut self) {
        let back = self.value("Bf", 0).filter(|x| x.is_finite() && *x != 0.0);
        let last = self.draft.rows.len().checked_sub(1);
        if let (Some(last), Some(back)) = (last, back)
            && self.draft.rows[last].thickness_mm == 0.0
        {
            self.draft.rows[last].thickness_mm = back;
            if !self.named.iter().any(|(surface, ..)| *surface == last) {
                self.named.push((last, "Bf".to_owned(), self.draft.rows[last].place));
            }
        }
    }

    /// The gaps that move, by zoom and focus.
    fn positions(&mut self) {
        let count = self.named.iter().filter_map(|(_, name, _)| self.variables.get(name)).map(|v| v.values.len()).max();
        let Some(count) = count.filter(|count| *count > 1) else { return };
        let changes = |(_, name, _): &&(usize, String, Place)| {
            let first = self.value(name, 0);
            (1..count).any(|i| self.value(name, i).is_some_and(|x| Some(x) != first))
        };
        let mut moving: Vec<&(usize, String, Place)> = self.named.iter().filter(changes).collect();
        moving.sort_by_key(|(surface, ..)| *surface);
        // The film follows the lens by itself; with it a lens would not be focused.
        let last = self.draft.rows.len() - 1;
        moving.retain(|(surface, ..)| *surface != last || self.zooms() < 2);
        if moving.is_empty() {
            return;
        }
        let zooms = self.zooms();
        // How wide the diaphragm is, where that changes and every position says it.
        let opening = |i: usize| self.value(STOP, i).or_else(|| self.value(STOP, i % zooms.max(1)));
        let opens = self.stop_opens() && (0..count).all(|i| opening(i).is_some_and(|x| x.is_finite() && x > 0.0));
        let stop = self.draft.stop.filter(|_| opens);
        let mut positions: Vec<Position> = Vec::new();
        let mut left_out = 0;
        for i in 0..count {
            // Positions of near objects say no focal length: they repeat the zooms in their order.
            let focal = self.value("Focal Length", i).or_else(|| self.value("Focal Length", i % zooms.max(1)));
            let focal = focal.filter(|mm| mm.is_finite() && *mm > 0.0);
            let object = self.value("d0", i).unwrap_or(if i < zooms.max(1) { f64::INFINITY } else { f64::NAN });
            let gaps = moving.iter().map(|(_, name, _)| self.value(name, i).filter(|x| x.is_finite()));
            let gaps: Option<Vec<f64>> = gaps.chain(stop.map(|_| opening(i))).collect();
            let is_new = |position: &Position| {
                !positions.iter().any(|p| p.zoom_mm == position.zoom_mm && p.focus_mm == position.focus_mm)
            };
            let position = gaps.filter(|_| object > 0.0).map(|values| Position {
                zoom_mm: focal.filter(|_| zooms > 1),
                focus_mm: object,
                values,
            });
            match position.filter(is_new) {
                Some(position) => positions.push(position),
                None => left_out += 1,
            }
        }
        // A zoom that is not known at infinity cannot be counted from there.
        let at_infinity: Vec<Option<f64>> =
            positions.iter().filter(|p| p.focus_mm.is_infinite()).map(|p| p.zoom_mm).collect();
        let before = positions.len();
        positions.retain(|p| at_infinity.contains(&p.zoom_mm) && (zooms < 2 || p.zoom_mm.is_some()));
        left_out += before - positions.len();
        let place = self.variables.get("Focal Length").map_or(self.named[0].2, |variable| variable.place);
        if left_out > 0 {
            let what = format!(
                "{left_out} of {count} positions are left out: their gaps, zoom or distance are not known, or were given"
            );
            self.draft.remarks.say(place, what);
        }
        if positions.len() > 1 {
            let places = vec![place; positions.len()];
            let gaps = moving.iter().map(|(surface, ..)| Part::gap(*surface));
            let diaphragm = stop.map(|surface| Part { surface, quantity: Quantity::Diameter });
            self.draft.moving = Some((gaps.chain(diaphragm).collect(), positions, places));
        }
    }

    /// Number of focal lengths that the lens is given for.
    fn zooms(&self) -> usize {
        let Some(focal) = self.variables.get("Focal Length") else { return 0 };
        let known = focal.values.iter().take_while(|value| value.is_some()).count();
        let at_infinity = |i: &usize| self.value("d0", *i).is_none_or(f64::is_infinite);
        let distinct = (0..known).filter(at_infinity).count();
        // A prime repeats its focal length for every distance.
        if focal.values.iter().take(known).all(|value| *value == focal.values[0]) { 1 } else { distinct }
    }

    /// True if the table has the diaphragm more than one diameter wide.
    fn stop_opens(&self) -> bool {
        let Some(diameter) = self.variables.get(STOP) else { return false };
        let mut known = diameter.values.iter().flatten();
        known.next().is_some_and(|first| known.any(|x| x != first))
    }

    /// A diaphragm whose diameters are not known at every position is as wide as the widest of them.
    fn note_other_stops(&mut self) {
        let Some(diameter) = self.variables.get(STOP).filter(|_| self.stop_opens()) else { return };
        let is_moved = |part: &Part| part.quantity == Quantity::Diameter;
        if self.draft.moving.as_ref().is_some_and(|(parts, ..)| parts.iter().any(is_moved)) {
            return;
        }
        let known = diameter.values.iter().flatten().copied().filter(|x| x.is_finite() && *x > 0.0);
        let widest = known.fold(0.0, f64::max);
        let what = format!("the stop opens with the zoom, to {widest} mm; it is kept that wide");
        self.draft.remarks.say(diameter.place, what);
        if let Some(stop) = self.draft.stop.filter(|_| widest > 0.0) {
            self.draft.rows[stop].semi_diameter_mm = Some(widest / 2.0);
        }
    }
}
