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
//! More columns may follow; they must be named in the header row:
//!
//! - `obstruction`: the diameter of a central obstruction.
//! - `a2` to `a20`: coefficients of an asphere, in mm^(1 − p) for the power p, added to the conicoid's sag.
//! - `radius_x`: the radius of curvature in the x-z plane. The surface is then a toroid: its profile in the y-z plane,
//!   by radius, conic and coefficients, turned about a line parallel to y. 0 is a cylinder.
//! - `decenter_x`, `decenter_y` (mm) and `tilt_x`, `tilt_y`, `tilt_z` (degrees): where the surface stands beside its
//!   place, right-handed about the axis named; the surfaces after it stay where they are.
//!
//! An element moves as one by a line of the header, surfaces counted from 0, about the vertex of its first:
//! `# element: 2-3 decenter_x=0.05 tilt_y=0.1`.
//!
//! Gaps that change when the lens is zoomed, or focused by groups inside, are named in the header by the surfaces before
//! them, counted from 0, and given for each position that is known: nominal focal length, distance of what is sharp from
//! the first vertex, gaps. A prime leaves `zoom` out; `focus=inf` may be left out. The rows hold any one of them.
//!
//! ```text
//! # moving: 4 9
//! # position: zoom=35 focus=inf 1.9 36.9
//! # position: zoom=35 focus=900 4.4 36.9
//! # position: zoom=70 focus=inf 48.7 1.5
//! # position: zoom=70 focus=900 51.2 1.5
//! ```

mod columns;
mod moving;

use std::fmt;
use std::path::Path;

use thiserror::Error;

use crate::glass::{Catalogue, GlassError};
use crate::prescription::moving::MovingError;
use crate::prescription::{Behind, Column, Metadata, Place, Prescription, PrescriptionError, SurfaceRow};
use crate::surface::{Conic, Shape};

use moving::MovingLines;

use columns::{ElementLine, Misalignment, OBSTRUCTION, POSE, RADIUS_X, element, power};

/// A longer file is no lens: it would only cost memory.
const LARGEST_FILE: usize = 1 << 20;
/// Columns that every row has.
const COLUMNS: [&str; 6] = ["radius", "thickness", "glass", "diameter", "conic", "isstop"];
/// What is wrong in a lens file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Problem {
    /// The file cannot be opened or read.
    #[error("cannot be read ({0}); check the path")]
    Unreadable(String),
    /// Not text.
    #[error("this is not text; give a lens file")]
    NotText,
    /// Longer than a lens can be.
    #[error("the file is longer than {LARGEST_FILE} bytes; give a lens file")]
    TooLong,
    /// No row.
    #[error("there is no surface; give one row a surface: radius thickness glass diameter conic isstop")]
    Empty,
    /// A row is too short or too long.
    #[error("{found} columns where {expected} belong; write: radius thickness glass diameter conic isstop")]
    ColumnCount {
        /// Columns in the row.
        found: usize,
        /// Columns that the header row promises.
        expected: usize,
    },
    /// The header row names its columns in another order.
    #[error("column '{found}' where '{expected}' belongs; keep the order radius thickness glass diameter conic isstop")]
    HeaderOrder {
        /// The word found.
        found: String,
        /// The word that belongs there.
        expected: &'static str,
    },
    /// The header row names a column that is not supported.
    #[error(
        "column '{0}' is unknown; after isstop there may be obstruction, radius_x, a2 to a20, decenter_x, decenter_y, tilt_x, tilt_y, tilt_z"
    )]
    UnknownColumn(String),
    /// The header row names a column twice.
    #[error("column '{0}' stands here a second time; take one out")]
    SecondColumn(String),
    /// A line about an element cannot be understood.
    #[error("'{0}' is no element; write first and last surface, then moves: 2-3 decenter_x=0.05 tilt_y=0.1")]
    Element(String),
    /// A line about an element names a surface that is not there.
    #[error("the element goes to surface {last}, but the last surface is {surfaces}; count them from 0")]
    NoSuchSurface {
        /// The last surface of the element.
        last: usize,
        /// The last surface of the lens.
        surfaces: usize,
    },
    /// A line about moving gaps cannot be understood.
    #[error(
        "'{0}' is no list of surfaces; write the numbers of those before the gaps that move, counted from 0: 4 9 12"
    )]
    Moving(String),
    /// A line about a position of the groups cannot be understood.
    #[error("'{0}' is no position; write zoom and focus in mm, then the gaps: zoom=35 focus=inf 1.9 36.9")]
    Position(String),
    /// Gaps and positions do not fit together.
    #[error(transparent)]
    MovingGaps(#[from] MovingError),
    /// Not a finite number.
    #[error("{what} '{found}' is not a finite number; write one, as in 12.5")]
    NotANumber {
        /// The name of the value.
        what: String,
        /// The text found.
        found: String,
    },
    /// The glass is unknown.
    #[error(transparent)]
    Glass(#[from] GlassError),
    /// `isstop` is neither 0 nor 1.
    #[error("isstop is '{0}'; write 1 for the surface with the diaphragm and 0 for the others")]
    StopFlag(String),
    /// No surface is the stop.
    #[error("no surface is the stop; write isstop 1 in the row of the diaphragm")]
    NoStop,
    /// A second surface is the stop.
    #[error("a second stop, the first is in line {first_line}; write isstop 1 in one row only")]
    SecondStop {
        /// Line of the first.
        first_line: usize,
    },
    /// The numbers make no lens.
    #[error(transparent)]
    Prescription(#[from] PrescriptionError),
}

/// A problem, and where it is: one line, `FILE:LINE:COLUMN: what is wrong; what to do`.
#[derive(Clone, Debug, PartialEq)]
pub struct LensFileError {
    /// The file, as it was named.
    pub file: String,
    /// Where in it, counted from 1.
    pub place: Place,
    /// What is wrong.
    pub problem: Problem,
}

impl fmt::Display for LensFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Place { line, column } = self.place;
        write!(f, "{}:{line}:{column}: {}", self.file, self.problem)
    }
}

impl std::error::Error for LensFileError {}

/// Reads a lens file.
pub fn read(path: &Path, catalogue: &Catalogue) -> Result<Prescription, LensFileError> {
    let file = path.display().to_string();
    match std::fs::read(path) {
        Ok(bytes) => parse_bytes(&bytes, &file, catalogue),
        Err(error) => Err(at(&file, 1, 1, Problem::Unreadable(error.to_string()))),
    }
}

/// Parses the bytes of a lens file, which may be anything.
pub fn parse_bytes(bytes: &[u8], file_name: &str, catalogue: &Catalogue) -> Result<Prescription, LensFileError> {
    if bytes.len() > LARGEST_FILE {
        return Err(at(file_name, 1, 1, Problem::TooLong));
    }
    let (valid, whole) = match std::str::from_utf8(bytes) {
        Ok(text) => (text, true),
        Err(error) => (std::str::from_utf8(&bytes[..error.valid_up_to()]).unwrap_or(""), false),
    };
    let control = valid.find(|c: char| c.is_control() && !c.is_ascii_whitespace());
    match control.or((!whole).then_some(valid.len())) {
        None => parse(valid, file_name, catalogue),
        Some(offset) => {
            let before = &valid[..offset];
            let line = before.matches('\n').count() + 1;
            let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
            Err(at(file_name, line, column, Problem::NotText))
        }
    }
}

/// Parses the text of a lens file; `file_name` is what errors call it.
pub fn parse(text: &str, file_name: &str, catalogue: &Catalogue) -> Result<Prescription, LensFileError> {
    if text.len() > LARGEST_FILE {
        return Err(at(file_name, 1, 1, Problem::TooLong));
    }
    let mut reader = Reader::new(file_name, catalogue);
    for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        match line.find('#') {
            Some(0) => reader.header(i + 1, line)?,
            hash => reader.row(i + 1, &line[..hash.unwrap_or(line.len())])?,
        }
    }
    reader.finish()
}

fn at(file: &str, line: usize, column: usize, problem: Problem) -> LensFileError {
    LensFileError { file: file.to_owned(), place: Place { line, column }, problem }
}

/// A word of a line and the column it starts in.
struct Token<'a> {
    text: &'a str,
    column: usize,
}

fn tokens(line: &str) -> Vec<Token<'_>> {
    let column_of = |text: &str| {
        let offset = text.as_ptr() as usize - line.as_ptr() as usize;
        line[..offset].chars().count() + 1
    };
    line.split_whitespace().map(|text| Token { text, column: column_of(text) }).collect()
}

struct Reader<'a> {
    file: &'a str,
    catalogue: &'a Catalogue,
    /// Names of the columns after the usual ones.
    extra: Vec<String>,
    elements: Vec<ElementLine>,
    moving: MovingLines,
    rows: Vec<SurfaceRow>,
    /// Index, line and column of the stop.
    stop: Option<(usize, usize)>,
    /// Where the first row says whether it is the stop.
    first_flag: Place,
    metadata: Metadata,
    name: Option<String>,
    film_radius_mm: Option<f64>,
}

impl<'a> Reader<'a> {
    fn new(file: &'a str, catalogue: &'a Catalogue) -> Self {
        Self {
            file,
            catalogue,
            extra: Vec::new(),
            elements: Vec::new(),
            moving: MovingLines::default(),
            rows: Vec::new(),
            stop: None,
            first_flag: Place { line: 1, column: 1 },
            metadata: Metadata::default(),
            name: None,
            film_radius_mm: None,
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
        let Some((key, value)) = text.trim_start_matches('#').split_once(':') else { return Ok(()) };
        let (key, value) = (key.trim().to_lowercase(), value.trim());
        let column = value.as_ptr() as usize - text.as_ptr() as usize;
        let column = text[..column].chars().count() + 1;
        self.metadata(line, column, &key, value)?;
        self.metadata.all.push((key, value.to_owned()));
        Ok(())
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
                    let is_known = found == OBSTRUCTION || found == RADIUS_X || POSE.contains(&found.as_str());
                    if !is_known && power(&found).is_none() {
                        return self.fail(line, column, Problem::UnknownColumn(found));
                    }
                    self.extra.push(found);
                }
            }
        }
        Ok(())
    }

    fn metadata(&mut self, line: usize, column: usize, key: &str, value: &str) -> Result<(), LensFileError> {
        let number = |text: &str| finite(text).ok_or_else(|| not_a_number(key, text));
        let place = |problem| at(self.file, line, column, problem);
        match key {
            "name" => self.name = Some(value.to_owned()),
            "source" => self.metadata.source = Some(value.to_owned()),
            "focal_length" => self.metadata.focal_length_mm = Some(number(value).map_err(place)?),
            "f_number" => self.metadata.f_number = Some(number(value).map_err(place)?),
            "half_field_deg" => self.metadata.half_field_deg = Some(number(value).map_err(place)?),
            "element" => {
                let element = element(value, Place { line, column });
                self.elements.push(element.ok_or_else(|| place(Problem::Element(value.to_owned())))?);
            }
            "moving" => self.moving.surfaces(value, Place { line, column }).map_err(place)?,
            "position" => self.moving.position(value, Place { line, column }).map_err(place)?,
            "film_radius" => self.film_radius_mm = Some(number(value).map_err(place)?),
            "film" => {
                let (width, height) = value.split_once('x').unwrap_or((value, value));
                let side = |text: &str| number(text.trim()).map_err(place);
                self.metadata.film_mm = Some([side(width)?, side(height)?]);
            }
            _ => {}
        }
        if self.film_radius_mm == Some(0.0) {
            return Err(place(PrescriptionError::FilmRadius { radius_mm: 0.0 }.into()));
        }
        Ok(())
    }

    fn row(&mut self, line: usize, text: &str) -> Result<(), LensFileError> {
        let words = tokens(text);
        if words.is_empty() {
            return Ok(());
        }
        let expected = COLUMNS.len() + self.extra.len();
        if words.len() != expected {
            let column = words.get(expected).unwrap_or(&words[0]).column;
            return self.fail(line, column, Problem::ColumnCount { found: words.len(), expected });
        }
        let number = |i: usize| {
            let what = COLUMNS.get(i).copied().unwrap_or_else(|| &self.extra[i - COLUMNS.len()]);
            finite(words[i].text).ok_or_else(|| at(self.file, line, words[i].column, not_a_number(what, words[i].text)))
        };
        let semi_diameter_mm = number(3)? / 2.0;
        let (mut obstruction_mm, mut radius_x, mut terms) = (0.0, None, Vec::new());
        let mut misalignment = Misalignment::default();
        for (name, i) in self.extra.iter().zip(COLUMNS.len()..) {
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
            shape: Shape::from_numbers(Conic::new(number(0)?, number(4)?), &terms, radius_x),
            pose: misalignment.pose(),
            thickness_mm: number(1)?,
            behind: self.behind(line, &words[2])?,
            semi_diameter_mm,
            obstruction_mm,
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

    fn behind(&self, line: usize, word: &Token<'_>) -> Result<Behind, LensFileError> {
        if word.text.eq_ignore_ascii_case("mirror") {
            return Ok(Behind::Mirror);
        }
        let medium = self.catalogue.medium(word.text);
        medium.map(Behind::Medium).map_err(|error| at(self.file, line, word.column, error.into()))
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

    /// Where a column stands in a row.
    fn column_index(&self, column: Column) -> usize {
        let extra = |is_it: &dyn Fn(&str) -> bool| {
            self.extra.iter().position(|name| is_it(name)).map_or(0, |i| COLUMNS.len() + i)
        };
        match column {
            Column::Radius => 0,
            Column::Thickness => 1,
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
        for ElementLine { place, first, last, pose } in &self.elements {
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
        let gaps = self.moving.gaps(self.rows.len());
        let moving = gaps.map_err(|(place, error)| at(self.file, place.line, place.column, error.into()))?;
        let prescription = Prescription {
            name: self.name.unwrap_or_else(|| stem(self.file)),
            surfaces: self.rows,
            stop,
            metadata: self.metadata,
            film_radius_mm: self.film_radius_mm,
            moving,
            source_file: self.file.to_owned(),
        };
        // Groups stand where the first position has them.
        let published = prescription.moving.as_ref().map(|moving| moving.first_zoom_mm());
        let surfaces = published.map(|zoom_mm| prescription.at_position(zoom_mm, 0.0).surfaces);
        Ok(Prescription { surfaces: surfaces.unwrap_or_else(|| prescription.surfaces.clone()), ..prescription })
    }
}

fn finite(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|x| x.is_finite())
}

fn not_a_number(what: &str, found: &str) -> Problem {
    Problem::NotANumber { what: what.to_owned(), found: found.to_owned() }
}

/// The file's name without folders and ending: the name of a lens that has none.
fn stem(file: &str) -> String {
    Path::new(file).file_stem().map_or_else(|| file.to_owned(), |stem| stem.to_string_lossy().into_owned())
}
