//! OSLO's lens file, `.len`: one command a line, surfaces from 0, the object, parted by `NXT`, to `END`.
//!
//! `RD` is a radius, `CV` a curvature, `TH` the distance to the next surface, `AP` half of the clear diameter (`CHK` if it stops light),
//! `AST` the stop, `EBR` the radius of the beam that enters. A glass has a name, or indices at the wavelengths of the line `WV`.
//! (Commands as in OSLO's Program Reference and in files that it saved.)

use crate::glass::{Catalogue, GlassError, Medium, line_nm};
use crate::prescription::{NextMedium, Place};

use super::beams::StatedBeam;
use super::draft::{Draft, FieldKind, FieldPoint, MOST_SURFACES};
use super::draft_row::DraftRow;
use super::glass_names::Glasses;
use super::problem::{LensFileError, Problem, at};
use super::remarks::Reading;
use super::text::{Token, finite, not_a_number, tokens};

/// Commands that say nothing of how light goes.
const SILENT: [&str; 27] = [
    "LEN", "DES", "DLRS", "WW", "SNO", "NOT", "SNO1", "SNO2", "SNO3", "SNO4", "SNO5", "LNO", "CBK", "EGR", "LME",
    "DRW", "AMO", "PTZ", "TCE", "DNT", "WVW", "XP", "SDAD", "FNB", "TMP", "PRE", "DRAY",
];

/// Reads the text of a file.
pub fn parse(text: &str, file: &str, catalogue: &Catalogue) -> Result<Reading, LensFileError> {
    let mut reader = OsloReader::new(file, catalogue);
    for (i, line) in text.lines().enumerate() {
        let line = line.split("//").next().unwrap_or("");
        let words = tokens(line);
        if let Some((key, rest)) = words.split_first()
            && !reader.ended
        {
            reader.line(i + 1, line, key, rest)?;
        }
    }
    reader.finish()
}

struct OsloReader<'a> {
    draft: Draft<'a>,
    glasses: Glasses<'a>,
    mm_per_unit: f64,
    row: DraftRow,
    /// The number of the surface that is read; 0 is the object.
    number: usize,
    wavelengths_um: Vec<f64>,
    /// The step of the power from `AS1` to `AS2`.
    asphere_step: Option<u32>,
    /// The last surface's distance is to be where the image is at first order.
    to_focus: Option<Place>,
    ended: bool,
}

impl<'a> OsloReader<'a> {
    fn new(file: &'a str, catalogue: &'a Catalogue) -> Self {
        Self {
            draft: Draft::new(file),
            glasses: Glasses::new(catalogue, None),
            mm_per_unit: 1.0,
            row: DraftRow::new(Place { line: 1, column: 1 }),
            number: 0,
            wavelengths_um: [line_nm::D, line_nm::F, line_nm::C].map(|nm| nm / 1000.0).to_vec(),
            asphere_step: None,
            to_focus: None,
            ended: false,
        }
    }

    fn value(&self, line: usize, words: &[Token<'_>], i: usize, what: &str) -> Result<f64, LensFileError> {
        let Some(word) = words.get(i) else {
            return Err(at(self.draft.file, line, words.last().map_or(1, |word| word.column), not_a_number(what, "")));
        };
        finite(word.text).ok_or_else(|| at(self.draft.file, line, word.column, not_a_number(what, word.text)))
    }

    fn line(&mut self, line: usize, text: &str, key: &Token<'_>, rest: &[Token<'_>]) -> Result<(), LensFileError> {
        let place = Place { line, column: key.column };
        let command = key.text.to_uppercase();
        let first = |reader: &Self| reader.value(line, rest, 0, &command);
        match command.as_str() {
            "LEN" => {
                let name = text.split('"').nth(1).unwrap_or("").trim();
                self.draft.name = (!name.is_empty()).then(|| name.to_owned());
            }
            "UNI" => {
                self.mm_per_unit = first(self)?;
                if !(self.mm_per_unit > 0.0) {
                    let expected = "millimetres for one unit, larger than 0,".to_owned();
                    return self
                        .draft
                        .fail(place, Problem::Malformed { found: self.mm_per_unit.to_string(), expected });
                }
            }
            "EBR" => self.draft.beam = Some(StatedBeam::EntrancePupil(2.0 * first(self)?)),
            "FNO" => self.draft.beam = Some(StatedBeam::FNumber(first(self)?)),
            "NAO" => self.draft.beam = Some(StatedBeam::ObjectNa(first(self)?)),
            "NAP" => self.draft.beam = Some(StatedBeam::FNumber(0.5 / first(self)?)),
            "ANG" => self.field(FieldKind::Degrees, first(self)?),
            "OBH" => self.field(FieldKind::ObjectHeight, first(self)?),
            "GIH" => self.field(FieldKind::ImageHeight, first(self)?),
            "WV" => {
                self.wavelengths_um =
                    (0..rest.len()).map(|i| self.value(line, rest, i, "wavelength")).collect::<Result<_, _>>()?;
            }
            "NXT" => self.next(place)?,
            "END" => {
                self.ended = true;
                self.draft.film_radius_mm = (self.row.curvature != 0.0).then(|| 1.0 / self.row.curvature);
            }
            known if SILENT.contains(&known) => {}
            _ => self.of_surface(line, &command, place, rest)?,
        }
        Ok(())
    }

    fn field(&mut self, kind: FieldKind, y: f64) {
        self.draft.field_kind = kind;
        self.draft.fields = vec![FieldPoint { y, cut: [0.0; 2] }];
    }

    fn next(&mut self, place: Place) -> Result<(), LensFileError> {
        let mut row = std::mem::replace(&mut self.row, DraftRow::new(Place { line: place.line + 1, column: 1 }));
        row.terms.retain(|(_, a)| *a != 0.0);
        if self.number == 0 {
            self.draft.object_mm = row.thickness_mm;
        } else {
            if self.draft.rows.len() >= MOST_SURFACES {
                return self
                    .draft
                    .fail(place, Problem::Unsupported("a lens has no more than 1000 surfaces".to_owned()));
            }
            self.draft.rows.push(row);
        }
        self.number += 1;
        Ok(())
    }

    fn of_surface(
        &mut self,
        line: usize,
        command: &str,
        place: Place,
        rest: &[Token<'_>],
    ) -> Result<(), LensFileError> {
        let first = |reader: &Self| reader.value(line, rest, 0, command);
        match command {
            "AIR" | "AIF" => self.row.behind = NextMedium::Medium(Medium::air()),
            "RFL" | "RFH" => self.row.behind = NextMedium::Mirror,
            "GLA" => self.row.behind = NextMedium::Medium(self.glass(line, place, rest)?),
            "RD" => {
                let radius = first(self)?;
                self.row.curvature = if radius == 0.0 { 0.0 } else { 1.0 / radius };
            }
            "CV" => self.row.curvature = first(self)?,
            "CC" => self.row.conic = first(self)?,
            "TH" => self.row.thickness_mm = first(self)?,
            "AST" => self.draft.stop = self.number.checked_sub(1),
            "AP" => {
                let checked = rest.first().is_some_and(|word| word.text.eq_ignore_ascii_case("CHK"));
                let named = rest.first().is_some_and(|word| word.text.chars().all(char::is_alphabetic));
                let radius = self.value(line, rest, usize::from(named), "AP")?;
                self.row.semi_diameter_mm = Some(radius).filter(|radius| *radius > 0.0);
                self.row.has_rim = checked && radius > 0.0;
            }
            "AD" | "AE" | "AF" | "AG" => {
                let power = 4 + 2 * (u32::from(command.as_bytes()[1]) - u32::from(b'D'));
                let a = first(self)?;
                self.row.terms.push((power, a));
            }
            "ASP" => {
                let kind = rest.first().map_or("", |word| word.text).to_uppercase();
                self.asphere(&kind, place)?;
            }
            "PY" | "PYC" if rest.first().and_then(|word| finite(word.text)) == Some(0.0) => self.to_focus = Some(place),
            // Pictures and centring at 0 change nothing.
            "DCX" | "DCY" | "DCZ" | "TLA" | "TLB" | "TLC" if first(self)? == 0.0 => {}
            "DT" | "RCO" | "GC" | "BEN" if rest.first().is_none_or(|word| word.text == "0") && command == "DT" => {}
            "APCK" | "APN" | "ATP" | "AX1" | "AX2" | "AY1" | "AY2" | "AAN" | "AAC" | "APF" | "GTO" => {
                let what = format!("'{command}' is left out: only round apertures are read");
                self.draft.remarks.once(command, place, what);
            }
            _ if command.strip_prefix("AS").is_some_and(|digits| digits.parse::<u32>().is_ok()) => {
                let power: u32 = command[2..].parse().unwrap_or(0);
                let a = first(self)?;
                let power = power.saturating_mul(self.asphere_step.unwrap_or(2));
                if a != 0.0 {
                    self.row.terms.push((power, a));
                }
            }
            "PK" | "PFL" | "CVX" | "RDX" | "CVY" | "DCX" | "DCY" | "DCZ" | "TLA" | "TLB" | "TLC" | "DT" | "RCO"
            | "GC" | "BEN" | "DOE" | "GSP" | "GOR" | "GRZ" | "GIA" | "LMO" | "TDM" | "PU" | "PUC" | "PY" | "PYC"
            | "EC" | "CHV" | "ASI" | "SPL" | "ZER" | "HOE" | "GRD" => {
                let words: Vec<&str> = rest.iter().map(|word| word.text).collect();
                let what = format!(
                    "'{command} {}' cannot be read from .len, and without it the lens would be another",
                    words.join(" ")
                );
                return self.draft.fail(place, Problem::Unsupported(what));
            }
            other => self.draft.remarks.once(other, place, format!("'{other}' is not understood and left out")),
        }
        Ok(())
    }

    /// `ASP ASR`: even powers, AS1 of r²; `ASP ARA`: all, AS1 of r.
    fn asphere(&mut self, kind: &str, place: Place) -> Result<(), LensFileError> {
        self.asphere_step = match kind {
            "ASR" | "1" => Some(2),
            "ARA" => Some(1),
            "ADO" | "0" => None,
            other => {
                let what = format!("aspheres of kind '{other}' are not supported; ASR, ARA and the usual AD to AG are");
                return self.draft.fail(place, Problem::Unsupported(what));
            }
        };
        Ok(())
    }

    /// `NAME`, `n n n` at the wavelengths, or `MOD NAME n n n`.
    fn glass(&mut self, line: usize, place: Place, rest: &[Token<'_>]) -> Result<Medium, LensFileError> {
        let is_model = rest.first().is_some_and(|word| word.text.eq_ignore_ascii_case("MOD"));
        let rest = if is_model { &rest[1..] } else { rest };
        let Some(first) = rest.first() else {
            let expected = "the name of a glass, or indices".to_owned();
            return self.draft.fail(place, Problem::Malformed { found: String::new(), expected });
        };
        let named = finite(first.text).is_none();
        let indices: Vec<f64> =
            (usize::from(named)..rest.len()).map(|i| self.value(line, rest, i, "index")).collect::<Result<_, _>>()?;
        let wrong = |error: GlassError| at(self.draft.file, line, first.column, error.into());
        match indices.as_slice() {
            [] => {
                let place = Place { line, column: first.column };
                self.glasses.squeezed(first.text, None, place, &mut self.draft.remarks).map_err(wrong)
            }
            // Index and Abbe number.
            [nd, abbe] if is_model && *abbe > 10.0 => self.glasses.by_numbers(*nd, *abbe).map_err(wrong),
            [n] => self.glasses.by_numbers(*n, 0.0).map_err(wrong),
            all => {
                let points = self.wavelengths_um.iter().zip(all).map(|(um, n)| [*um, *n]).collect();
                let name = if named { first.text.to_owned() } else { format!("glass-{line}") };
                let measured = Glasses::measured(&name, points);
                measured.map_or_else(
                    || {
                        let expected = "indices, one for each wavelength of WV,".to_owned();
                        self.draft.fail(place, Problem::Malformed { found: first.text.to_owned(), expected })
                    },
                    Ok,
                )
            }
        }
    }

    fn finish(mut self) -> Result<Reading, LensFileError> {
        if !self.ended {
            let place = Place { line: 1, column: 1 };
            return self.draft.fail(
                place,
                Problem::Unsupported("there is no line END; the file is cut off, or no lens of OSLO".to_owned()),
            );
        }
        if let Some(um) = self.wavelengths_um.first().filter(|um| (0.1..=20.0).contains(*um)) {
            self.draft.wavelength_nm = um * 1000.0;
        }
        if let Some(place) = self.to_focus
            && self.draft.rows.last().is_some_and(|row| row.thickness_mm == 0.0)
        {
            self.draft.film_at_focus(place);
        }
        self.draft.scale(self.mm_per_unit);
        self.draft.finish()
    }
}
