//! CODE V's sequence file, `.seq`: commands of three letters, several a line with `;`, continued by `&`, remarks after `!`.
//!
//! `SO`, `S` and `SI` begin object, surface and film with radius (or, as saved files have it after `RDM N`, and as is usual without
//! `RDM`, curvature), thickness and glass; the commands after them are about that surface, unless a qualifier such as `S3` names
//! another. Glasses are NAME_MAKER without hyphens, a private catalogue's names in quotes, or numbers: `517.642` is nd 1.517 and Vd 64.2.
//! (Commands as in files that CODE V saved.)

mod zoom;

use std::collections::HashMap;

use glam::{DAffine3, DVec3};

use crate::glass::{Catalogue, Dispersion, GlassError, Medium};
use crate::prescription::{NextMedium, Place};

use super::beams::StatedBeam;
use super::draft::{Draft, FieldKind, FieldPoint, MOST_SURFACES};
use super::draft_row::DraftRow;
use super::frames;
use super::glass_names::Glasses;
use super::problem::{LensFileError, Problem};
use super::remarks::Reading;
use super::text::{finite, not_a_number};

/// An object that is this far away is at infinity, as CODE V writes it.
const ENDLESS_MM: f64 = 1e13;
/// Commands that say nothing of how light goes: weights, variables, derivatives, drawing, numbers for optimization.
const SILENT: [&str; 51] = [
    "LEN", "GO", "WTW", "INI", "XAN", "WTF", "CCY", "THC", "GLC", "KC", "AC", "BC", "CC", "DC", "EC", "FC", "GC", "HC",
    "JC", "SLB", "PIM", "DER", "CLS", "VER", "CUM", "THM", "CA", "POL", "RDY", "VUX", "VLX", "CUF", "CCX", "ADC",
    "BDC", "CDC", "XDC", "YDC", "ZDC", "TEM", "PRE", "CNT", "WTA", "CRV", "LBL", "DDA", "DDM", "AFC", "PFR", "FFO",
    "RFO",
];
/// Commands that move the frame of a surface, in the order of [`Frame::numbers`], and that choose the frame behind it.
const MOVES: [&str; 6] = ["XDE", "YDE", "ZDE", "ADE", "BDE", "CDE"];
const FRAMES: [(&str, FrameKind); 3] =
    [("DAR", FrameKind::Return), ("BEN", FrameKind::Bend), ("REV", FrameKind::Reverse)];
/// Commands that move a surface in a way that is not read, or make another surface of it.
const OTHER_SHAPES: [&str; 19] = [
    "RET", "GLB", "XOD", "YOD", "ZOD", "CYL", "YTO", "XTO", "AAS", "SPS", "DIF", "HOE", "GRT", "FRE", "THI1", "MOD",
    "SCO", "UDS", "QBF",
];

/// Reads the text of a file.
pub fn parse(text: &str, file: &str, catalogue: &Catalogue) -> Result<Reading, LensFileError> {
    let mut reader = SeqReader::new(file, catalogue);
    for command in commands(text) {
        if reader.ended {
            break;
        }
        reader.command(&command)?;
    }
    reader.finish()
}

/// The frame of the surfaces behind a decentred surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum FrameKind {
    /// It stays decentred and tilted.
    #[default]
    Stay,
    /// It returns to the frame before the surface.
    Return,
    /// It is tilted once more, as the axis is by a mirror.
    Bend,
    /// The surface stands undecentred, and behind it everything is taken back.
    Reverse,
}

/// The decentring and tilt of a surface or of the film: x, y and z in the file's units, alpha, beta and gamma in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Frame {
    numbers: [f64; 6],
    kind: FrameKind,
}

impl Frame {
    /// The changes of coordinates before and behind the surface.
    fn changes(&self) -> [DAffine3; 2] {
        let [x, y, z, alpha, beta, gamma] = self.numbers;
        let change = frames::change(DVec3::new(x, y, z), [alpha, beta, gamma]);
        let bend = frames::change(DVec3::ZERO, [alpha, beta, gamma]);
        match self.kind {
            FrameKind::Stay => [change, DAffine3::IDENTITY],
            FrameKind::Return => [change, change.inverse()],
            FrameKind::Bend => [change, bend],
            FrameKind::Reverse => [DAffine3::IDENTITY, change.inverse()],
        }
    }
}

/// A word, in quotes or not.
#[derive(Clone, Debug)]
struct SeqWord {
    text: String,
    quoted: bool,
    place: Place,
}

impl SeqWord {
    fn upper(&self) -> String {
        self.text.to_uppercase()
    }
}

/// The commands of a text: words between line ends and semicolons.
fn commands(text: &str) -> Vec<Vec<SeqWord>> {
    let mut all = Vec::new();
    let mut words: Vec<SeqWord> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let mut chars = line.chars().enumerate().peekable();
        let mut continued = false;
        while let Some(&(column, c)) = chars.peek() {
            let place = Place { line: i + 1, column: column + 1 };
            match c {
                '!' => break,
                ';' => {
                    chars.next();
                    all.push(std::mem::take(&mut words));
                }
                '&' => {
                    chars.next();
                    continued = true;
                }
                '\'' | '"' => {
                    chars.next();
                    let text: String = chars.by_ref().map(|(_, c)| c).take_while(|other| *other != c).collect();
                    words.push(SeqWord { text, quoted: true, place });
                }
                c if c.is_whitespace() => {
                    chars.next();
                }
                _ => {
                    let mut text = String::new();
                    while let Some((_, c)) = chars.next_if(|(_, c)| !c.is_whitespace() && !";&!'\"".contains(*c)) {
                        text.push(c);
                    }
                    words.push(SeqWord { text, quoted: false, place });
                }
            }
        }
        if !continued {
            all.push(std::mem::take(&mut words));
        }
    }
    all.push(words);
    all.retain(|words| !words.is_empty());
    all
}

struct SeqReader<'a> {
    draft: Draft<'a>,
    glasses: Glasses<'a>,
    by_radius: bool,
    mm_per_unit: f64,
    /// The surface that commands are about: `None` before any, 0 the object.
    current: Option<usize>,
    has_film: bool,
    /// The decentring of surfaces, by their index; that of the film last.
    frames: HashMap<usize, Frame>,
    film_frame: Frame,
    /// Distance from the film's place to the intended one.
    defocus_mm: f64,
    wavelengths_nm: Vec<f64>,
    reference: usize,
    fields: Vec<f64>,
    cut: [Vec<f64>; 2],
    /// While a private catalogue is read: its wavelengths in nm.
    private: Option<Vec<f64>>,
    private_glasses: HashMap<String, Medium>,
    zoom: zoom::ZoomLines,
    ended: bool,
}

impl<'a> SeqReader<'a> {
    fn new(file: &'a str, catalogue: &'a Catalogue) -> Self {
        Self {
            draft: Draft::new(file),
            glasses: Glasses::new(catalogue, None),
            by_radius: false,
            mm_per_unit: 1.0,
            current: None,
            has_film: false,
            frames: HashMap::new(),
            film_frame: Frame::default(),
            defocus_mm: 0.0,
            wavelengths_nm: Vec::new(),
            reference: 1,
            fields: Vec::new(),
            cut: [Vec::new(), Vec::new()],
            private: None,
            private_glasses: HashMap::new(),
            zoom: zoom::ZoomLines::default(),
            ended: false,
        }
    }

    fn fail<T>(&self, word: &SeqWord, problem: Problem) -> Result<T, LensFileError> {
        self.draft.fail(word.place, problem)
    }

    fn number(&self, words: &[SeqWord], i: usize, what: &str) -> Result<f64, LensFileError> {
        let Some(word) = words.get(i) else {
            return self.fail(&words[words.len() - 1], not_a_number(what, ""));
        };
        // Fortran's exponents.
        let value = finite(&word.text).or_else(|| finite(&word.text.replace(['d', 'D'], "e")));
        // A distance to the object, as some programs write it.
        let value = value.or_else(|| word.text.eq_ignore_ascii_case("inf").then_some(ENDLESS_MM));
        value.map_or_else(|| self.fail(word, not_a_number(what, &word.text)), Ok)
    }

    fn numbers(&self, words: &[SeqWord], what: &str) -> Result<Vec<f64>, LensFileError> {
        (1..words.len()).map(|i| self.number(words, i, what)).collect()
    }

    fn command(&mut self, words: &[SeqWord]) -> Result<(), LensFileError> {
        let key = words[0].upper();
        if self.private.is_some() {
            return self.private_line(&key, words);
        }
        match key.as_str() {
            "RDM" => self.by_radius = words.get(1).is_none_or(|word| !word.upper().starts_with('N')),
            // The title of a zoom position is no name of the lens.
            "TIT" | "TITLE" if words.len() > 2 && zoom::position_of(&words[1]).is_some() => {}
            "TIT" | "TITLE" => self.draft.name = words.get(1).map(|word| word.text.clone()),
            "DIM" => {
                self.mm_per_unit = match words.get(1).map(SeqWord::upper).as_deref() {
                    Some("M" | "MM") => 1.0,
                    Some("C" | "CM") => 10.0,
                    Some("I" | "IN") => 25.4,
                    other => {
                        let expected = "M, C or I (millimetres, centimetres, inches)".to_owned();
                        return self
                            .fail(&words[0], Problem::Malformed { found: other.unwrap_or("").to_owned(), expected });
                    }
                };
                if !self.draft.rows.is_empty() {
                    let what = "DIM after the surfaces; their lengths are taken in these units";
                    self.draft.remarks.say(words[0].place, what);
                }
            }
            "EPD" => self.draft.beam = Some(StatedBeam::EntrancePupil(self.number(words, 1, "EPD")?)),
            "FNO" => self.draft.beam = Some(StatedBeam::FNumber(self.number(words, 1, "FNO")?)),
            "NA" => self.draft.beam = Some(StatedBeam::FNumber(0.5 / self.number(words, 1, "NA")?)),
            "NAO" => self.draft.beam = Some(StatedBeam::ObjectNa(self.number(words, 1, "NAO")?)),
            "WL" => self.wavelengths_nm = self.numbers(words, "wavelength")?,
            "REF" => self.reference = self.number(words, 1, "REF")?.clamp(1.0, 1000.0) as usize,
            "YAN" => self.fields(words, FieldKind::Degrees)?,
            "YOB" => self.fields(words, FieldKind::ObjectHeight)?,
            "YIM" | "YRI" => self.fields(words, FieldKind::ImageHeight)?,
            "VUY" => self.cut[1] = self.numbers(words, "VUY")?,
            "VLY" => self.cut[0] = self.numbers(words, "VLY")?,
            "PRV" => self.private = Some(Vec::new()),
            "ZOO" => self.zoom_line(words)?,
            "GO" => self.ended = true,
            "SO" | "SI" | "S" => self.surface(&key, words)?,
            // S3 as a command begins with the surface's number.
            _ if key.starts_with('S') && key.len() > 1 && key[1..].chars().all(|c| c.is_ascii_digit()) => {
                self.surface(&key, words)?;
            }
            _ => self.of_surface(&key, words)?,
        }
        Ok(())
    }

    fn fields(&mut self, words: &[SeqWord], kind: FieldKind) -> Result<(), LensFileError> {
        self.draft.field_kind = kind;
        self.fields = self.numbers(words, "field")?;
        Ok(())
    }

    /// `PWL` and the glasses of a private catalogue, to `END`.
    fn private_line(&mut self, key: &str, words: &[SeqWord]) -> Result<(), LensFileError> {
        match key {
            "END" => self.private = None,
            "PWL" => self.private = Some(self.numbers(words, "wavelength")?),
            _ if words.get(1).is_some_and(|word| word.upper() == "LAU") => self.laurent(words)?,
            _ => {
                let indices = self.numbers(words, "index")?;
                let wavelengths = self.private.clone().unwrap_or_default();
                if indices.len() != wavelengths.len() {
                    let expected = format!("{} indices, one for each wavelength of PWL", wavelengths.len());
                    return self.fail(&words[0], Problem::Malformed { found: indices.len().to_string(), expected });
                }
                let points = wavelengths.iter().zip(&indices).map(|(nm, n)| [nm / 1000.0, *n]).collect();
                match Glasses::measured(&words[0].text, points) {
                    Some(medium) => {
                        self.private_glasses.insert(words[0].upper(), medium);
                    }
                    None => {
                        let what = format!("the indices of the private glass '{}' make no curve", words[0].text);
                        return self.fail(&words[0], Problem::Unsupported(what));
                    }
                }
            }
        }
        Ok(())
    }

    /// A private glass by Laurent's series, the wavelength in µm: n² = A + B λ² + C λ⁻² + D λ⁻⁴ + E λ⁻⁶ + F λ⁻⁸.
    fn laurent(&mut self, words: &[SeqWord]) -> Result<(), LensFileError> {
        const POWERS: [f64; 6] = [0.0, 2.0, -2.0, -4.0, -6.0, -8.0];
        let numbers =
            (2..words.len()).map(|i| self.number(words, i, "coefficient")).collect::<Result<Vec<f64>, _>>()?;
        let terms = numbers.iter().zip(POWERS).skip(1).map(|(a, power)| [*a, power]).collect();
        let a = numbers.first().copied().unwrap_or(0.0);
        let medium =
            Medium::new(&words[0].text, Dispersion::Polynomial { a, terms }, [0.0, f64::INFINITY], "the lens file");
        if numbers.len() > POWERS.len() || !(0.5..=6.0).contains(&medium.index(self.draft.wavelength_nm)) {
            let what = format!("the coefficients of the private glass '{}' make no curve", words[0].text);
            return self.fail(&words[0], Problem::Unsupported(what));
        }
        self.private_glasses.insert(words[0].upper(), medium);
        Ok(())
    }

    /// `SO`, `S` and `SI`: radius or curvature, thickness, glass.
    fn surface(&mut self, key: &str, words: &[SeqWord]) -> Result<(), LensFileError> {
        let mut row = DraftRow::new(words[0].place);
        if words.len() > 1 {
            let value = self.number(words, 1, if self.by_radius { "radius" } else { "curvature" })?;
            row.curvature = if self.by_radius && value != 0.0 { 1.0 / value } else { value };
        }
        if words.len() > 2 {
            row.thickness_mm = self.number(words, 2, "thickness")?;
        }
        match key {
            "SO" => {
                self.draft.object_mm = row.thickness_mm;
                self.current = Some(0);
                return Ok(());
            }
            "SI" => {
                self.has_film = true;
                self.defocus_mm = row.thickness_mm;
                self.draft.film_radius_mm = (row.curvature != 0.0).then(|| 1.0 / row.curvature);
                self.current = None;
                return Ok(());
            }
            _ => {}
        }
        if let Some(glass) = words.get(3) {
            row.behind = self.glass(glass)?;
        }
        if self.draft.rows.len() >= MOST_SURFACES {
            return self.fail(&words[0], Problem::Unsupported("a lens has no more than 1000 surfaces".to_owned()));
        }
        self.draft.rows.push(row);
        self.current = Some(self.draft.rows.len());
        Ok(())
    }

    fn glass(&mut self, word: &SeqWord) -> Result<NextMedium, LensFileError> {
        let name = word.upper();
        if matches!(name.as_str(), "REFL" | "REF" | "REFLECT") && !word.quoted {
            return Ok(NextMedium::Mirror);
        }
        if name == "AIR" {
            return Ok(NextMedium::Medium(Medium::air()));
        }
        if let Some(medium) = self.private_glasses.get(&name) {
            return Ok(NextMedium::Medium(medium.clone()));
        }
        let by_numbers = fictitious(&name).map(|(nd, abbe)| self.glasses.by_numbers(nd, abbe));
        let medium = by_numbers.unwrap_or_else(|| {
            if word.quoted {
                return Err(GlassError::Unknown { name: word.text.clone(), near: Vec::new() });
            }
            let (bare, maker) =
                name.rsplit_once('_').map_or((name.as_str(), None), |(bare, maker)| (bare, Some(maker)));
            self.glasses.squeezed(bare, maker, word.place, &mut self.draft.remarks)
        });
        medium.map(NextMedium::Medium).or_else(|error| self.fail(word, error.into()))
    }

    /// A command about a surface: the current one, or that of a qualifier.
    #[expect(clippy::too_many_lines, reason = "an arm for each command")]
    fn of_surface(&mut self, key: &str, words: &[SeqWord]) -> Result<(), LensFileError> {
        let place = words[0].place;
        if SILENT.contains(&key) {
            return Ok(());
        }
        let named = words.get(1).filter(|word| !word.quoted).map(SeqWord::upper);
        let number_of = |text: &str| text.strip_prefix('S').and_then(|digits| digits.parse::<usize>().ok());
        let film = named.as_deref() == Some("SI") || (named.as_deref().and_then(number_of).is_none() && self.has_film);
        let qualified = named.as_deref().and_then(number_of);
        let at_surface = qualified.or(self.current).filter(|_| !(film && qualified.is_none()));
        let words: Vec<SeqWord> = match named.as_deref() {
            Some(text) if qualified.is_some() || text == "SI" || text == "SO" => {
                words.iter().enumerate().filter(|(i, _)| *i != 1).map(|(_, word)| word.clone()).collect()
            }
            _ => words.to_vec(),
        };
        if MOVES.contains(&key) || FRAMES.iter().any(|(name, _)| *name == key) {
            let index = at_surface.and_then(|number| number.checked_sub(1)).filter(|i| *i < self.draft.rows.len());
            return self.moved(key, &words, index, film);
        }
        if OTHER_SHAPES.contains(&key) {
            let moves = key != "RET" && words.iter().skip(1).all(|word| finite(&word.text) == Some(0.0));
            if film || (moves && words.len() > 1) {
                let what = format!("'{key}' of the film is left out");
                if film {
                    self.draft.remarks.once(key, place, what);
                }
                return Ok(());
            }
            let what = format!("'{key}' tilts, moves or reshapes a surface in a way that cannot be read from .seq");
            return self.draft.fail(place, Problem::Unsupported(what));
        }
        let Some(index) = at_surface.and_then(|number| number.checked_sub(1)).filter(|i| *i < self.draft.rows.len())
        else {
            let what = if at_surface == Some(0) || film { "is about object or film" } else { "is not understood" };
            self.draft.remarks.once(key, place, format!("'{key}' {what} and left out"));
            return Ok(());
        };
        let value = |reader: &Self| reader.number(&words, 1, key);
        match key {
            "STO" | "STOP" => self.draft.stop = Some(index),
            "K" => self.draft.rows[index].conic = value(self)?,
            "CON" | "ASP" | "SPH" => {}
            "THI" if words.get(1).and_then(zoom::position_of).is_some() => {
                self.zoom_value(index + 1, zoom::position_of(&words[1]), self.number(&words, 2, key)?);
            }
            // A solve, such as THI HMY 0: what it gave stands in the surface.
            "THI" | "CUY"
                if words.get(1).is_some_and(|word| !word.quoted && word.text.starts_with(char::is_alphabetic)) =>
            {
                let what =
                    format!("'{key} {}' is left out; the surface keeps the numbers that the file has", words[1].text);
                self.draft.remarks.once("solve", place, what);
            }
            "THI" => self.draft.rows[index].thickness_mm = value(self)?,
            "CUY" => self.draft.rows[index].curvature = value(self)?,
            "GLA" => {
                if let Some(word) = words.get(1) {
                    self.draft.rows[index].behind = self.glass(word)?;
                }
            }
            "CIR" => self.aperture(index, &words)?,
            "REX" | "REY" | "ELX" | "ELY" | "ADX" | "ADY" | "ARO" => {
                let what = "an aperture that is not round and centred is left out; the surface is opened for its beams";
                self.draft.remarks.once("aperture", place, what);
            }
            "PIK" | "HLD" => {
                let what = format!("'{key}' is left out; the surface keeps the numbers that the file has");
                self.draft.remarks.once(key, place, what);
            }
            _ => match "ABCDEFGHJ".find(key).filter(|_| key.len() == 1) {
                Some(i) => {
                    let term = (4 + 2 * i as u32, value(self)?);
                    self.draft.rows[index].terms.push(term);
                }
                None => self.draft.remarks.once(key, place, format!("'{key}' is not understood and left out")),
            },
        }
        Ok(())
    }

    /// A command about the frame of a surface, or of the film.
    fn moved(&mut self, key: &str, words: &[SeqWord], index: Option<usize>, film: bool) -> Result<(), LensFileError> {
        let number = MOVES.iter().position(|name| *name == key);
        let value = number.map(|_| self.number(words, 1, key)).transpose()?;
        let frame = match index {
            Some(index) => self.frames.entry(index).or_default(),
            None if film => &mut self.film_frame,
            None => {
                let what = format!("'{key}' is about the object and left out");
                self.draft.remarks.once(key, words[0].place, what);
                return Ok(());
            }
        };
        if let (Some(number), Some(value)) = (number, value) {
            frame.numbers[number] = value;
        } else if let Some((_, kind)) = FRAMES.iter().find(|(name, _)| *name == key) {
            frame.kind = *kind;
        }
        Ok(())
    }

    /// `CIR`, with `EDG` for the mount, `OBS` for an obstruction and `HOL` for a hole.
    fn aperture(&mut self, index: usize, words: &[SeqWord]) -> Result<(), LensFileError> {
        let mut kind = "";
        for (i, word) in words.iter().enumerate().skip(1) {
            match word.upper().as_str() {
                "EDG" => kind = "EDG",
                "OBS" => kind = "OBS",
                // What a hole lets through goes on behind the mirror, not to the film.
                "HOL" => kind = "HOL",
                // A label: L'name', of two words here.
                "L" | "CLR" => {}
                _ if word.quoted => {}
                _ => {
                    let radius = self.number(words, i, "radius of the aperture")?;
                    let row = &mut self.draft.rows[index];
                    match kind {
                        "EDG" => {}
                        "" => {
                            row.semi_diameter_mm = Some(radius);
                            row.has_rim = true;
                        }
                        _ => row.obstruction_mm = radius,
                    }
                }
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Reading, LensFileError> {
        if !self.has_film && !self.draft.rows.is_empty() {
            let place = self.draft.rows[0].place;
            return self
                .draft
                .fail(place, Problem::Unsupported("there is no film; end the surfaces with SI".to_owned()));
        }
        self.configure();
        if let Some(last) = self.draft.rows.last_mut() {
            last.thickness_mm += self.defocus_mm;
        }
        for (index, frame) in &self.frames {
            let row = &mut self.draft.rows[*index];
            [row.before, row.after] = frame.changes();
        }
        self.draft.film_frame = self.film_frame.changes()[0];
        if let Some(&nm) = self.wavelengths_nm.get(self.reference - 1).filter(|nm| (100.0..=20_000.0).contains(*nm)) {
            self.draft.wavelength_nm = nm;
        }
        let cut = |list: &Vec<f64>, i: usize| list.get(i).copied().unwrap_or(0.0);
        let [below, above] = &self.cut;
        self.draft.fields = self
            .fields
            .iter()
            .enumerate()
            .map(|(i, y)| FieldPoint { y: *y, cut: [cut(below, i), cut(above, i)] })
            .collect();
        self.draft.scale(self.mm_per_unit);
        self.draft.finish()
    }
}

/// nd and Vd of `517.642`, `517642`, or `516800.641673`.
fn fictitious(name: &str) -> Option<(f64, f64)> {
    // As optiland writes a glass by its numbers.
    if let Some((nd, abbe)) = name.split_once(':') {
        return Some((finite(nd)?, finite(abbe)?)).filter(|(nd, abbe)| *nd > 0.5 && *abbe > 0.0);
    }
    if !name.chars().all(|c| c.is_ascii_digit() || c == '.') {
        return None;
    }
    let (index, abbe) = match name.split_once('.') {
        Some((index, abbe)) if index.len() >= 3 => (index, abbe),
        None if name.len() == 6 => name.split_at(3),
        _ => return None,
    };
    let number = |text: &str, whole: usize| -> Option<f64> {
        let (before, after) = text.split_at_checked(whole).unwrap_or((text, ""));
        format!("{before}.{after}").parse().ok()
    };
    let nd = 1.0 + number(&format!("0{index}"), 1)?;
    let abbe = number(abbe, 2)?;
    (abbe > 0.0).then_some((round(nd), abbe))
}

/// The index without the digits that adding 1 left beyond those that were written.
fn round(nd: f64) -> f64 {
    format!("{nd:.10}").parse().unwrap_or(nd)
}
