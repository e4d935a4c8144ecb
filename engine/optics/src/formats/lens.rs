//! The `.lens` file: the six-column table of Wu et al. 2011, with a header of `# key: text` lines.
//!
//! ```text
//! # name: Symmetric biconvex lens, R = 51.68 mm
//! #radius thickness glass diameter conic isstop
//! 51.68 5.0 1.5168/64.17 25.0 0.0 1
//! -51.68 48.0 air 25.0 0.0 0
//! ```
//!
//! Millimetres; scene side first. Radius 0 is a plane. The thickness is to the next surface, the last to the film.
//! The glass is the medium after the surface: a name of the catalogues, `air`, `vacuum`, `water`, `mirror`, `n/V`,
//! or a bare index.
//!
//! `isstop 1` stands in one row, that of the diaphragm: it opens and closes, and the entrance pupil is its image. Further stops are
//! fixed: a row with `isstop 0` and the same medium before and behind, whose diameter is the hole. A flat glass surface is a row of
//! radius 0 with glass before or behind, and may be the diaphragm's own.
//!
//! ```text
//! 40.0 4.0 1.5168/64.17 20.0 0.0 0
//! 0.0  0.0 air          19.0 0.0 0    flat glass
//! 0.0  3.0 air          12.0 0.0 1    the diaphragm, on it
//! 0.0  30.0 air         14.0 0.0 0    a fixed stop
//! 0.0  1.0 air          18.0 0.0 0    a field stop before the film
//! ```
//!
//! The header may say more of the lens. Numbers are the source's, or `not published`; the group is one of wide angle, normal, portrait,
//! macro, telephoto, zoom, fisheye, mirror, anamorphic, historical, eye, test.
//!
//! ```text
//! # group: normal
//! # first_choice: yes
//! # source: US 2,799,207 emb. I (Lange)
//! # focal_length: 80
//! # f_number: 2.8
//! # back_focus: not published
//! # half_field_deg: 28
//! # film: 56 x 56
//! # differs: f_number: why the surfaces give another
//! ```
//!
//! More columns may follow; they must be named in the header row:
//!
//! - `obstruction`: the diameter of a central obstruction.
//! - `a2` to `a20`: coefficients of an asphere, in mm^(1 − p) for the power p, added to the conicoid's sag.
//! - `radius_x`: the radius of curvature in the x-z plane. The surface is then a toroid: its profile in the y-z plane,
//!   by radius, conic and coefficients, turned about a line parallel to y. 0 is a cylinder.
//! - `decenter_x`, `decenter_y` (mm) and `tilt_x`, `tilt_y`, `tilt_z` (degrees): where the surface stands beside its
//!   place, right-handed about the axis named; the surfaces after it stay where they are.
//!
//! - `coating`: thin films, by the name of a recipe, with `@NM` behind it for another design wavelength, or layer by layer from the air
//!   to the glass as `FILM:THICKNESS` joined by `/`: `MgF2:100nm/ZrO2:0.5w@550/1.65:0.25w@550`, in nm or in waves inside of the film; a
//!   film is a name or an index, `2.3-0.01i` if it absorbs. `none` is bare, `-` says nothing. Mirrors: `protected-silver` and its like.
//!
//! `# coating: MgF2` in the header is that of all surfaces where glass meets air and of which no row says otherwise; where neither says
//! anything, a single layer of MgF2 is assumed there. Coatings do not grow with a lens that is scaled.
//!
//! An element moves as one by a line of the header, surfaces counted from 0, about the vertex of its first:
//! `# element: 2-3 decenter_x=0.05 tilt_y=0.1`.
//!
//! A glass that stands in no catalogue is defined before the rows, by the formula's name, the wavelengths in nm that it holds for and its
//! numbers, as `lenses/glass/README.md` has them; its transmittance may follow as wavelength in nm, part, and the thickness in mm for
//! that. Or a catalogue that lies beside the lens file is named: `.agf` of a maker, or `.yml` of refractiveindex.info, whose medium is then
//! called as its file. A radius may be written `1/C` by its curvature.
//!
//! ```text
//! # glass: MYCROWN sellmeier 350-2500 0 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653
//! # transmittance: MYCROWN 400:0.997@10 500:0.998@10 700:0.998@10
//! # catalogue: maker.agf
//! ```
//!
//! The index of such a glass may change from place to place: the gradient is a sum of terms, named by powers of z and even
//! powers of r, in mm. z is counted along the axis of the surface that the glass follows, from its vertex or from a place so
//! far behind it as `from` says.
//!
//! ```text
//! # gradient: MYCROWN from=0.5 z1=0.049 z2=-0.0154 r2=-0.00198 z1r2=0.0001
//! ```
//!
//! Gaps that change when the lens is zoomed, or focused by groups inside, are named in the header by the surfaces before
//! them, counted from 0, and given for each position that is known: nominal focal length, distance of the sharp plane from
//! the first vertex, gaps. A prime leaves `zoom` out; `focus=inf` may be left out. The rows hold any one of them.
//!
//! ```text
//! # moving: 4 9
//! # position: zoom=35 focus=inf 1.9 36.9
//! # position: zoom=35 focus=900 4.4 36.9
//! # position: zoom=70 focus=inf 48.7 1.5
//! # position: zoom=70 focus=900 51.2 1.5
//! ```
//!
//! The lens of an eye changes its shape instead. Radii, conic constants, clear diameters (`diameter`), and a shift of the
//! index of the medium behind a surface move in the same way, among the gaps in any order:
//!
//! ```text
//! # moving: 2 3 radius:3 conic:3 index_shift:3
//! # position: focus=inf 3.05 4.0 10.2 -3.13 0
//! # position: focus=250 2.97 4.16 7.38 -3.68 0.005
//! ```
//!
//! A diaphragm that opens with the focal length is the `diameter` of its row.

mod write;

use std::path::{Path, PathBuf};

use crate::coating::Coating;
use crate::glass::Catalogue;
use crate::prescription::{Column, Metadata, NextMedium, Place, Prescription, PrescriptionError, SurfaceRow};
use crate::surface::{Conic, Shape};

use super::draft::MOST_SURFACES;
use super::glass_names::Glasses;
use super::header::{self, Header};
use super::problem::at;
use super::remarks::{Reading, Remarks};
use super::text::{self, Token, finite, not_a_number, stem, tokens};

pub use super::problem::{LensFileError, Problem};

use super::columns::{COATING, ElementLine, Misalignment, NO_COATING_SAID, OBSTRUCTION, POSE, RADIUS_X, power};

pub use write::write;
pub(super) use write::{common_coating, header_lines, one_line, with_glasses_apart};

/// A longer file is no lens: it would only cost memory.
const LARGEST_FILE: usize = 1 << 20;
/// Columns that every row has.
const COLUMNS: [&str; 6] = ["radius", "thickness", "glass", "diameter", "conic", "isstop"];
/// Reads a lens file.
pub fn read(path: &Path, catalogue: &Catalogue) -> Result<Prescription, LensFileError> {
    let file = path.display().to_string();
    let bytes = text::bytes(path, &file, LARGEST_FILE)?;
    let folder = path.parent().map(Path::to_owned);
    reading(&bytes, &file, catalogue, folder).map(|reading| reading.prescription)
}

/// Parses the bytes of a lens file, which may be anything.
pub fn parse_bytes(bytes: &[u8], file_name: &str, catalogue: &Catalogue) -> Result<Prescription, LensFileError> {
    reading(bytes, file_name, catalogue, None).map(|reading| reading.prescription)
}

/// Parses the text of a lens file; `file_name` is its name in errors.
pub fn parse(text: &str, file_name: &str, catalogue: &Catalogue) -> Result<Prescription, LensFileError> {
    parse_bytes(text.as_bytes(), file_name, catalogue)
}

/// Parses a lens file like [`parse_bytes`] and returns the remarks, too, those on glass files in `folder` that the lens file names
/// included.
pub(super) fn reading(
    bytes: &[u8],
    file: &str,
    catalogue: &Catalogue,
    folder: Option<PathBuf>,
) -> Result<Reading, LensFileError> {
    if bytes.len() > LARGEST_FILE {
        return Err(at(file, 1, 1, Problem::TooLong { largest: LARGEST_FILE }));
    }
    let text = text::utf8(bytes, file)?;
    let mut reader = LensReader::new(file, catalogue, folder);
    for (i, line) in text.lines().enumerate() {
        match line.find('#') {
            Some(0) => reader.header(i + 1, line)?,
            hash => reader.row(i + 1, &line[..hash.unwrap_or(line.len())])?,
        }
    }
    let remarks = std::mem::take(&mut reader.remarks).finish(file);
    Ok(Reading { prescription: reader.finish()?, remarks })
}

struct LensReader<'a> {
    file: &'a str,
    glasses: Glasses<'a>,
    remarks: Remarks,
    /// Names of the columns after the usual ones.
    extra: Vec<String>,
    header: Header,
    rows: Vec<SurfaceRow>,
    /// Index, line and column of the stop.
    stop: Option<(usize, usize)>,
    /// The place at which the first row says if it is the stop.
    first_flag: Place,
    metadata: Metadata,
}

impl<'a> LensReader<'a> {
    fn new(file: &'a str, catalogue: &'a Catalogue, folder: Option<PathBuf>) -> Self {
        Self {
            file,
            glasses: Glasses::new(catalogue, folder),
            remarks: Remarks::default(),
            extra: Vec::new(),
            header: Header::default(),
            rows: Vec::new(),
            stop: None,
            first_flag: Place { line: 1, column: 1 },
            metadata: Metadata::default(),
        }
    }

    fn fail<T>(&self, line: usize, column: usize, problem: Problem) -> Result<T, LensFileError> {
        Err(at(self.file, line, column, problem))
    }

    /// A line that starts with `#`: the row of column names, `key: text`, or a remark.
    fn header(&mut self, line: usize, text: &str) -> Result<(), LensFileError> {
        let words = tokens(text.trim_start_matches('#'));
        let shift = text.chars().take_while(|&c| c == '#').count();
        if words.first().is_some_and(|word| word.text.eq_ignore_ascii_case(COLUMNS[0])) {
            return self.column_names(line, shift, &words);
        }
        let place = Place { line, column: shift + 1 };
        header::line(&mut self.header, &mut self.metadata, text.trim_start_matches('#'), place, self.file)?;
        self.catalogues()
    }

    fn column_names(&mut self, line: usize, shift: usize, words: &[Token<'_>]) -> Result<(), LensFileError> {
        for (i, word) in words.iter().enumerate() {
            let column = word.column + shift;
            let found = word.text.to_lowercase();
            match COLUMNS.get(i) {
                Some(&expected) if expected != found => {
                    return self.fail(line, column, Problem::HeaderOrder { found, expected });
                }
                Some(_) => {}
                None if self.extra.contains(&found) => return self.fail(line, column, Problem::SecondColumn(found)),
                None => {
                    let is_known =
                        found == OBSTRUCTION || found == COATING || found == RADIUS_X || POSE.contains(&found.as_str());
                    if !is_known && power(&found).is_none() {
                        return self.fail(line, column, Problem::UnknownColumn(found));
                    }
                    self.extra.push(found);
                }
            }
        }
        Ok(())
    }

    /// Reads the glass files that the header names.
    fn catalogues(&mut self) -> Result<(), LensFileError> {
        for (name, place) in std::mem::take(&mut self.header.catalogues) {
            let found = self.glasses.beside(&name, place, self.file, &mut self.remarks)?;
            if !found {
                let why = "there is no such file, or its name has more than letters, digits and - _ .".to_owned();
                return Err(at(self.file, place.line, place.column, Problem::Beside { name, why }));
            }
        }
        self.glasses.define_new(&mut self.header);
        Ok(())
    }

    fn row(&mut self, line: usize, text: &str) -> Result<(), LensFileError> {
        let words = tokens(text);
        if words.is_empty() {
            return Ok(());
        }
        self.check_words(line, &words)?;
        let number = |i: usize| {
            let what = COLUMNS.get(i).copied().unwrap_or_else(|| &self.extra[i - COLUMNS.len()]);
            finite(words[i].text).ok_or_else(|| at(self.file, line, words[i].column, not_a_number(what, words[i].text)))
        };
        let semi_diameter_mm = number(3)? / 2.0;
        let (mut obstruction_mm, mut radius_x, mut terms) = (0.0, None, Vec::new());
        let (mut misalignment, mut coating) = (Misalignment::default(), None);
        for (name, i) in self.extra.iter().zip(COLUMNS.len()..) {
            if name == COATING {
                coating = self.coating(line, &words[i])?;
                continue;
            }
            let value = number(i)?;
            if let Some(power) = power(name) {
                terms.push((power, value));
            } else if let Some(part) = misalignment.part(name) {
                *part = value;
            } else if name == RADIUS_X {
                radius_x = Some(value);
            } else {
                obstruction_mm = value / 2.0;
            }
        }
        let row = SurfaceRow {
            shape: Shape::from_numbers(
                Conic { curvature: self.curvature(line, &words[0])?, conic: number(4)? },
                &terms,
                radius_x,
            ),
            pose: misalignment.pose(),
            thickness_mm: number(1)?,
            behind: self.behind(line, &words[2])?,
            semi_diameter_mm,
            obstruction_mm,
            coating,
            place: Place { line, column: words[0].column },
        };
        let surface = self.rows.len();
        if let Err(error) = row.check(surface) {
            let column = error.cell().map_or(0, |(_, column)| self.column_index(column));
            return self.fail(line, words[column].column, error.into());
        }
        self.flag(line, &words[5])?;
        self.rows.push(row);
        Ok(())
    }

    /// Checks that a line is a row of as many columns as the heading has.
    fn check_words(&self, line: usize, words: &[Token<'_>]) -> Result<(), LensFileError> {
        if self.rows.len() >= MOST_SURFACES {
            let problem = Problem::Unsupported(format!("a lens has no more than {MOST_SURFACES} surfaces"));
            return self.fail(line, words[0].column, problem);
        }
        let expected = COLUMNS.len() + self.extra.len();
        if words[0].text.eq_ignore_ascii_case(COLUMNS[0]) || words[0].text.ends_with(':') {
            return self.fail(line, words[0].column, Problem::HeaderWithoutMark);
        }
        if words.len() != expected {
            let column = words.get(expected).unwrap_or(&words[0]).column;
            return self.fail(line, column, Problem::ColumnCount { found: words.len(), expected });
        }
        Ok(())
    }

    /// The curvature that a radius of curvature states, or `1/C` itself: not every curvature is one over a number.
    fn curvature(&self, line: usize, word: &Token<'_>) -> Result<f64, LensFileError> {
        let curvature = word
            .text
            .strip_prefix("1/")
            .map_or_else(|| finite(word.text).map(|radius| Conic::new(radius, 0.0).curvature), finite);
        curvature.ok_or_else(|| at(self.file, line, word.column, not_a_number(COLUMNS[0], word.text)))
    }

    fn behind(&self, line: usize, word: &Token<'_>) -> Result<NextMedium, LensFileError> {
        if word.text.eq_ignore_ascii_case("mirror") {
            return Ok(NextMedium::Mirror);
        }
        if let Some(medium) = self.glasses.own(word.text) {
            return Ok(NextMedium::Medium(medium.clone()));
        }
        let medium = self.glasses.catalogue().medium(word.text);
        medium.map(NextMedium::Medium).map_err(|error| match self.header.undefined(word.text) {
            // What is wrong is the line that was to define it.
            Some((place, problem)) => at(self.file, place.line, place.column, problem),
            None => at(self.file, line, word.column, error.into()),
        })
    }

    fn coating(&self, line: usize, word: &Token<'_>) -> Result<Option<Coating>, LensFileError> {
        if word.text == NO_COATING_SAID {
            return Ok(None);
        }
        Coating::parse(word.text).map(Some).map_err(|error| at(self.file, line, word.column, error.into()))
    }

    fn flag(&mut self, line: usize, word: &Token<'_>) -> Result<(), LensFileError> {
        if self.rows.is_empty() {
            self.first_flag = Place { line, column: word.column };
        }
        match (word.text, self.stop) {
            ("0", _) => Ok(()),
            ("1", None) => {
                self.stop = Some((self.rows.len(), line));
                Ok(())
            }
            ("1", Some((_, first_line))) => self.fail(line, word.column, Problem::SecondStop { first_line }),
            (other, _) => self.fail(line, word.column, Problem::StopFlag(other.to_owned())),
        }
    }

    /// The index of a column in a row.
    fn column_index(&self, column: Column) -> usize {
        let extra = |is_it: &dyn Fn(&str) -> bool| {
            self.extra.iter().position(|name| is_it(name)).map_or(0, |i| COLUMNS.len() + i)
        };
        match column {
            Column::Radius => 0,
            Column::Thickness => 1,
            Column::Glass => 2,
            Column::Diameter => 3,
            Column::Conic => 4,
            Column::Obstruction => extra(&|name| name == OBSTRUCTION),
            Column::RadiusX => extra(&|name| name == RADIUS_X),
            Column::Term(p) => extra(&|name| power(name) == Some(p)),
            Column::Pose => extra(&|name| POSE.contains(&name)),
        }
    }

    /// Poses the surfaces of elements that stand beside their place.
    fn pose_elements(&mut self) -> Result<(), LensFileError> {
        for ElementLine { place, first, last, pose } in &self.header.elements {
            let surfaces = self.rows.len().saturating_sub(1);
            if *last > surfaces {
                let problem = Problem::NoSuchSurface { last: *last, surfaces };
                return Err(at(self.file, place.line, place.column, problem));
            }
            let mut behind_mm = 0.0;
            for row in &mut self.rows[*first..=*last] {
                row.pose = pose.of_element(behind_mm) * row.pose;
                behind_mm += row.thickness_mm;
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Prescription, LensFileError> {
        if self.rows.is_empty() {
            return self.fail(1, 1, Problem::Empty);
        }
        self.pose_elements()?;
        let Some((stop, _)) = self.stop else {
            return self.fail(self.first_flag.line, self.first_flag.column, Problem::NoStop);
        };
        let moving = self.header.moving.of(&self.rows);
        let moving = moving.map_err(|(place, error)| at(self.file, place.line, place.column, error.into()))?;
        let prescription = Prescription {
            name: self.header.name.unwrap_or_else(|| stem(self.file)),
            surfaces: self.rows,
            stop,
            metadata: self.metadata,
            film_radius_mm: self.header.film_radius_mm,
            moving,
            source_file: self.file.to_owned(),
        };
        let mut prescription = prescription.in_first_position();
        if let Some(coating) = &self.header.coating {
            prescription.coat(coating);
        }
        if let Err(error @ PrescriptionError::GradientAtFilm { surface }) = prescription.check() {
            let place = prescription.surfaces[surface].place;
            return Err(at(self.file, place.line, place.column, error.into()));
        }
        Ok(prescription)
    }
}
