//! Zemax OpticStudio's lens file, `.zmx`: text in UTF-16, older ones in a code page; one keyword a line.
//!
//! Sequential lenses of planes, spheres, conicoids, aspheres, toroids and mirrors. `SURF 0` is the object, the last surface the
//! film. `CURV` is a curvature, `DISZ` the distance to the next surface, `DIAM` half of the clear diameter; `MEMA` is the mechanical
//! one, of the mount, and stops no light. How wide the stop is follows from the system's aperture. A glass is looked up in the
//! catalogues of the line `GCAT`, in their order. Merit functions, tolerances, drawing and analysis settings are no part of a
//! lens. (Keywords as in files of OpticStudio, and the manual's list of surface types.)

mod surface;
mod write;

use std::path::PathBuf;

use crate::glass::Catalogue;
use crate::prescription::Place;

use super::beams::StatedBeam;
use super::configurations::{self, Configurations};
use super::draft::{Draft, FieldKind, FieldPoint};
use super::glass_names::Glasses;
use super::header::{self, Header};
use super::problem::{LensFileError, Problem, at};
use super::remarks::Reading;
use super::text::{Token, finite, not_a_number, tokens};

use surface::{SurfaceLines, ThicknessSolve};

pub use write::write;

/// Keywords before the surfaces that say nothing of how light goes.
const SILENT: [&str; 44] = [
    "VERS", "PFIL", "LANG", "GFAC", "RAIM", "PUSH", "SDMA", "OMMA", "ROPD", "HYPR", "PICB", "FWGN", "FWGT", "VDXN",
    "VANN", "VCXN", "XFLN", "XFLD", "WWGT", "POLS", "GLRS", "GSTD", "NSCD", "COFN", "AUTH", "NOTE", "EFFL", "TOTR",
    "FCOM", "DBDT", "PZUP", "RCMF", "OEMA", "WFNO", "MAZH", "HCLR", "XTRA", "VDSX", "VCXD", "FWGD", "APOD", "SSGX",
    "GRPX", "MFOB",
];

/// Operands by which configurations may differ (OpticStudio's manual, multi-configuration operands), and of these the ones that are no
/// matter of the lens itself: titles, weights, fields and wavelengths.
const CONFIGURED: [&str; 44] = [
    "THIC", "APER", "CRVT", "CONN", "COTN", "GLSS", "GCRS", "PRAM", "PAR1", "PAR2", "PAR3", "SDIA", "STPS", "IGNR",
    "IGNM", "TEMP", "PRES", "MIND", "MABB", "MDPG", "APMN", "APMX", "APDX", "APDY", "APTP", "SATP", "TELE", "HOLD",
    "MOFF", "LTTL", "MCOM", "FLWT", "WLWT", "CWGT", "SDRW", "CHZN", "FLTP", "XFIE", "YFIE", "WAVE", "PRWV", "FVAN",
    "FVCX", "FVCY",
];
const CONFIGURED_SILENT: [&str; 14] =
    ["MOFF", "LTTL", "MCOM", "FLWT", "WLWT", "CWGT", "SDRW", "CHZN", "FLTP", "XFIE", "YFIE", "WAVE", "PRWV", "HOLD"];

/// Reads the text of a file. `folder` is that of catalogues beside it.
pub fn parse(text: &str, file: &str, catalogue: &Catalogue, folder: Option<PathBuf>) -> Result<Reading, LensFileError> {
    let mut reader = ZmxReader::new(file, catalogue, folder);
    for (i, line) in text.lines().enumerate() {
        let words = tokens(line);
        if let Some((key, rest)) = words.split_first() {
            reader.line(i + 1, line, key, rest)?;
        }
    }
    reader.finish()
}

struct ZmxReader<'a> {
    draft: Draft<'a>,
    glasses: Glasses<'a>,
    blocks: Vec<SurfaceLines>,
    mm_per_unit: f64,
    wavelengths_um: Vec<(usize, f64)>,
    primary: usize,
    /// `FTYP`'s count of fields, their heights, and the parts that `VCYN` and `VDYN` cut off.
    field_count: usize,
    fields: Vec<f64>,
    compressed: Vec<f64>,
    decentred: Vec<f64>,
    header: Header,
    /// Number of configurations, the active one counted from 1, and the place that says so.
    configurations: Option<(usize, usize, Place)>,
    /// Gaps by configuration: surface, configuration from 0, length in the file's units.
    gaps: Vec<(usize, usize, f64)>,
    /// Solves for thicknesses, by surface.
    solves: Vec<Option<ThicknessSolve>>,
    /// Thicknesses by surface, in the file's units.
    thicknesses: Vec<f64>,
    /// True if the film stands at the image of first order in each configuration.
    image_follows: bool,
    /// The width of the beam by configuration, as the file measures that.
    beams: Vec<(usize, f64)>,
    /// True behind the surfaces, from the first line that stands to the left: other parts of the file.
    after_surfaces: bool,
}

impl<'a> ZmxReader<'a> {
    fn new(file: &'a str, catalogue: &'a Catalogue, folder: Option<PathBuf>) -> Self {
        Self {
            draft: Draft::new(file),
            glasses: Glasses::new(catalogue, folder),
            blocks: Vec::new(),
            mm_per_unit: 1.0,
            wavelengths_um: Vec::new(),
            primary: 1,
            field_count: 1,
            fields: Vec::new(),
            compressed: Vec::new(),
            decentred: Vec::new(),
            header: Header::default(),
            configurations: None,
            gaps: Vec::new(),
            solves: Vec::new(),
            thicknesses: Vec::new(),
            image_follows: false,
            beams: Vec::new(),
            after_surfaces: false,
        }
    }

    fn number(&self, line: usize, words: &[Token<'_>], i: usize, what: &str) -> Result<f64, LensFileError> {
        let Some(word) = words.get(i) else {
            let column = words.last().map_or(1, |word| word.column);
            return Err(at(self.draft.file, line, column, not_a_number(what, "")));
        };
        finite(word.text).ok_or_else(|| at(self.draft.file, line, word.column, not_a_number(what, word.text)))
    }

    fn numbers(&self, line: usize, words: &[Token<'_>], what: &str) -> Result<Vec<f64>, LensFileError> {
        (0..words.len()).map(|i| self.number(line, words, i, what)).collect()
    }

    fn line(&mut self, line: usize, text: &str, key: &Token<'_>, rest: &[Token<'_>]) -> Result<(), LensFileError> {
        let place = Place { line, column: key.column };
        if key.text == "SURF" {
            self.after_surfaces = false;
            if self.blocks.len() > super::draft::MOST_SURFACES {
                return self
                    .draft
                    .fail(place, Problem::Unsupported("a lens has no more than 1000 surfaces".to_owned()));
            }
            self.blocks.push(SurfaceLines::new(place));
            return Ok(());
        }
        if self.blocks.is_empty() {
            return self.system(line, text, key, rest);
        }
        if !text.starts_with([' ', '\t']) && (self.after_surfaces || !surface::knows(key.text)) {
            self.after_surfaces = true;
            if key.text != "BLNK" && !self.configuration_line(line, key, rest)? {
                let what = "merit function and tolerances are no part of a lens and left out";
                self.draft.remarks.once("after the surfaces", place, what);
            }
            return Ok(());
        }
        self.surface_line(line, key, rest)
    }

    /// A line before the surfaces.
    #[expect(clippy::too_many_lines, reason = "an arm for each keyword")]
    fn system(&mut self, line: usize, text: &str, key: &Token<'_>, rest: &[Token<'_>]) -> Result<(), LensFileError> {
        let place = Place { line, column: key.column };
        let value = text.trim_start()[key.text.len()..].trim();
        match key.text {
            "NAME" => self.draft.name = Some(value.trim_matches('"').to_owned()),
            // Our own lines of a header travel in notes: `NOTE 0 # key: text`.
            "NOTE" => {
                if let Some(ours) = value.strip_prefix("0 #") {
                    let column = text.chars().count() - ours.trim_start().chars().count() + 1;
                    header::line(
                        &mut self.header,
                        &mut self.draft.metadata,
                        ours,
                        Place { line, column },
                        self.draft.file,
                    )?;
                    self.glasses.define_new(&mut self.header);
                }
            }
            "MODE" if value != "SEQ" => {
                return self.draft.fail(
                    place,
                    Problem::Unsupported(format!("mode {value}: only sequential lenses (SEQ) can be read")),
                );
            }
            "MODE" => {}
            "UNIT" => {
                self.mm_per_unit = match rest.first().map_or("", |word| word.text) {
                    "MM" => 1.0,
                    "CM" => 10.0,
                    "IN" | "INCH" => 25.4,
                    "M" | "METER" => 1000.0,
                    other => {
                        let expected = "MM, CM, IN or METER".to_owned();
                        return self.draft.fail(place, Problem::Malformed { found: other.to_owned(), expected });
                    }
                };
            }
            // In lens units, which UNIT says before.
            "ENPD" => {
                self.draft.beam =
                    Some(StatedBeam::EntrancePupil(self.number(line, rest, 0, "ENPD")? * self.mm_per_unit))
            }
            "FNUM" => self.draft.beam = Some(StatedBeam::FNumber(self.number(line, rest, 0, "FNUM")?)),
            "OBNA" => {
                let value = self.number(line, rest, 0, "OBNA")?;
                let is_angle = rest.get(1).is_some_and(|word| word.text == "1");
                self.draft.beam = Some(StatedBeam::ObjectNa(if is_angle { value.to_radians().sin() } else { value }));
            }
            "FLOA" => self.draft.beam = None,
            "ENVD" => {
                let values = self.numbers(line, rest, "ENVD")?;
                let usual = |i: usize, usual: f64| values.get(i).is_none_or(|x| (x - usual).abs() < 1e-6);
                if !(usual(0, 20.0) && usual(1, 1.0)) {
                    self.draft.remarks.say(
                        place,
                        "temperature and pressure are left out: indices are those at 20 degrees and one atmosphere",
                    );
                }
            }
            "GCAT" => {
                let names: Vec<&str> = rest.iter().map(|word| word.text).collect();
                self.glasses.list(&names, place, self.draft.file, &mut self.draft.remarks)?;
            }
            "FTYP" => {
                self.draft.field_kind = match self.number(line, rest, 0, "FTYP")? as i64 {
                    0 => FieldKind::Degrees,
                    1 => FieldKind::ObjectHeight,
                    2 | 3 => FieldKind::ImageHeight,
                    other => {
                        self.draft.remarks.say(place, format!("fields of kind {other} are left out"));
                        FieldKind::Degrees
                    }
                };
                let count = if rest.len() > 2 { self.number(line, rest, 2, "FTYP")? } else { 12.0 };
                self.field_count = count.clamp(0.0, 1000.0) as usize;
                if rest.get(1).is_some_and(|word| word.text != "0") {
                    self.draft
                        .remarks
                        .say(place, "the beam is telecentric towards the object; the stop's place is kept instead");
                }
            }
            "YFLN" | "YFLD" => self.fields = self.numbers(line, rest, "YFLN")?,
            "VCYN" | "VCYD" => self.compressed = self.numbers(line, rest, "VCYN")?,
            "VDYN" | "VDYD" => self.decentred = self.numbers(line, rest, "VDYN")?,
            "WAVM" => {
                let number = self.number(line, rest, 0, "WAVM")? as usize;
                self.wavelengths_um.push((number, self.number(line, rest, 1, "wavelength")?));
            }
            "WAVN" | "WAVL" => {
                let all = self.numbers(line, rest, "wavelength")?;
                self.wavelengths_um.extend(all.into_iter().enumerate().map(|(i, um)| (i + 1, um)));
            }
            "PWAV" => self.primary = self.number(line, rest, 0, "PWAV")? as usize,
            "MNUM" => {
                self.configuration_line(line, key, rest)?;
            }
            known if SILENT.contains(&known) => {}
            other => {
                self.draft.remarks.once(other, place, format!("'{other}' is not understood and left out"));
            }
        }
        Ok(())
    }

    /// Tells the draft of the configurations. `rows` has the row of each `SURF`, if it is one.
    fn configure(&mut self, rows: &[Option<usize>]) {
        // What our own header says of moving gaps says all of them.
        let Some((count, active, place)) = self.configurations.filter(|_| self.header.moving.is_empty()) else {
            return;
        };
        let scale = self.mm_per_unit;
        self.solve_gaps(count);
        let mut configurations = Configurations::new(count, active - 1, place);
        for &(surface, configuration, value) in &self.gaps {
            match rows.get(surface).copied().flatten() {
                _ if surface == 0 => configurations.object(configuration, value * scale),
                Some(row) if value.is_finite() => configurations.gap(row, configuration, value * scale),
                _ => {
                    let what = format!("the thickness of surface {surface} changes by configuration and is left out");
                    self.draft.remarks.once(&format!("THIC {surface}"), place, what);
                }
            }
        }
        for &(configuration, value) in &self.beams {
            let beam = match self.draft.beam {
                Some(StatedBeam::EntrancePupil(_)) => StatedBeam::EntrancePupil(value * scale),
                Some(StatedBeam::FNumber(_)) => StatedBeam::FNumber(value),
                Some(StatedBeam::ObjectNa(_)) => StatedBeam::ObjectNa(value),
                None => continue,
            };
            configurations.beam(configuration, beam);
        }
        configurations.image_follows = self.image_follows;
        self.draft.configurations = Some(configurations);
    }

    /// Adds the gaps that follow from others in each configuration.
    fn solve_gaps(&mut self, count: usize) {
        for (j, solve) in std::mem::take(&mut self.solves).into_iter().enumerate() {
            let (first, total, is_all) = match solve {
                Some(ThicknessSolve::Compensator { surface, total }) => (surface, total, false),
                Some(ThicknessSolve::Position { surface, total }) => (surface, total, true),
                Some(ThicknessSolve::Image) if j + 2 == self.thicknesses.len() => {
                    self.image_follows = true;
                    continue;
                }
                _ => continue,
            };
            if first == 0 || first >= j {
                continue;
            }
            for configuration in 0..count {
                let gap = |surface: usize| {
                    let stated = self.gaps.iter().rev().find(|gap| (gap.0, gap.1) == (surface, configuration));
                    stated.map_or(self.thicknesses[surface], |gap| gap.2)
                };
                let others: f64 = if is_all { (first..j).map(gap).sum() } else { gap(first) };
                self.gaps.push((j, configuration, total - others));
            }
        }
    }

    /// A line of the editor of configurations: `MNUM` has their number and the active one, every other operand, surface, configuration and
    /// value. False for lines of other parts of the file.
    fn configuration_line(&mut self, line: usize, key: &Token<'_>, rest: &[Token<'_>]) -> Result<bool, LensFileError> {
        let place = Place { line, column: key.column };
        if key.text == "MNUM" {
            let count = self.number(line, rest, 0, "MNUM")?;
            let active = if rest.len() > 1 { self.number(line, rest, 1, "MNUM")? } else { 1.0 };
            if count > configurations::MOST as f64 {
                let what =
                    format!("the file has {count} configurations; the lens is read as it stands in the surfaces");
                self.draft.remarks.say(place, what);
            } else if count > 1.0 {
                self.configurations = Some((count as usize, active.clamp(1.0, count) as usize, place));
            }
            return Ok(true);
        }
        let Some((count, ..)) = self.configurations.filter(|_| CONFIGURED.contains(&key.text)) else {
            return Ok(CONFIGURED.contains(&key.text));
        };
        if CONFIGURED_SILENT.contains(&key.text) {
            return Ok(true);
        }
        let configuration = self.number(line, rest, 1, key.text)?;
        if !(1.0..=count as f64).contains(&configuration) {
            let expected = format!("a configuration from 1 to {count}");
            return self.draft.fail(place, Problem::Malformed { found: configuration.to_string(), expected });
        }
        let configuration = configuration as usize - 1;
        match key.text {
            "THIC" => {
                let surface = self.number(line, rest, 0, "THIC")?.clamp(0.0, 1e6) as usize;
                let is_endless = rest.get(2).is_some_and(|word| word.text.eq_ignore_ascii_case("INFINITY"));
                let value = if is_endless { f64::INFINITY } else { self.number(line, rest, 2, "THIC")? };
                self.gaps.push((surface, configuration, value));
            }
            "APER" => self.beams.push((configuration, self.number(line, rest, 2, "APER")?)),
            other => {
                let what = format!("'{other}' changes by configuration; it is kept as it stands in the surfaces");
                self.draft.remarks.once(other, place, what);
            }
        }
        Ok(true)
    }

    fn finish(mut self) -> Result<Reading, LensFileError> {
        let primary = self.wavelengths_um.iter().find(|(number, _)| *number == self.primary);
        if let Some(&(_, um)) = primary.filter(|(_, um)| (0.1..=20.0).contains(um)) {
            self.draft.wavelength_nm = um * 1000.0;
        }
        let cut = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
        let scale = if self.draft.field_kind == FieldKind::Degrees { 1.0 } else { self.mm_per_unit };
        let count = self.field_count.min(self.fields.len());
        self.draft.fields = (0..count)
            .map(|i| {
                let (shrunk, moved) = (cut(&self.compressed, i), cut(&self.decentred, i));
                FieldPoint { y: self.fields[i] * scale, cut: [shrunk + moved, shrunk - moved] }
            })
            .collect();
        let rows = self.surfaces()?;
        self.configure(&rows);
        self.header.clone().apply(&mut self.draft)?;
        self.draft.finish()
    }
}
