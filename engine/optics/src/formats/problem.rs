//! Errors in lens files, and their places.

use std::fmt;

use petzval_files::one_line;
use thiserror::Error;

use crate::coating::CoatingError;
use crate::glass::GlassError;
use crate::prescription::moving::MovingError;
use crate::prescription::{LensGroup, Place, PrescriptionError};

/// An error in a lens file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Problem {
    /// The file cannot be opened or read.
    #[error("cannot be read ({0}); check the path")]
    Unreadable(String),
    /// The file is not text.
    #[error("this is not text; give a lens file")]
    NotText,
    /// The encoding is none of those that lens files come in.
    #[error("this is neither UTF-8 nor UTF-16; save the file as UTF-8")]
    Encoding,
    /// The file is longer than that of a lens can be.
    #[error("the file is longer than {largest} bytes; give a lens file")]
    TooLong {
        /// The most that is read.
        largest: usize,
    },
    /// Glasses, not a lens.
    #[error("this is a glass catalogue; name it in a lens file: # catalogue: FILE.agf")]
    GlassCatalogue,
    /// A keyword is followed by something else than it needs.
    #[error("'{found}' where {expected} belongs")]
    Malformed {
        /// The text that the file has there.
        found: String,
        /// The text that was expected.
        expected: String,
    },
    /// Something that the engine has no means for, without which the lens would be another.
    #[error("{0}")]
    Unsupported(String),
    /// A file beside the lens file, named in it.
    #[error("'{name}' cannot be read ({why}); put the file beside the lens file")]
    Beside {
        /// The name in the lens file.
        name: String,
        /// The reason why the file cannot be read.
        why: String,
    },
    /// The file has no row of a surface.
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
        /// The word in the header row.
        found: String,
        /// The word that was expected.
        expected: &'static str,
    },
    /// The header row names a column that is not supported.
    #[error(
        "column '{0}' is unknown; after isstop there may be obstruction, radius_x, a2 to a20, decenter_x, decenter_y, decenter_z, tilt_x, tilt_y, tilt_z, coating"
    )]
    UnknownColumn(String),
    /// The header row names a column twice.
    #[error("column '{0}' stands here a second time; take one out")]
    SecondColumn(String),
    /// The group of lenses does not exist.
    #[error("'{0}' is no group of lenses; write one of {words}", words = LensGroup::ALL.map(LensGroup::word).join(", "))]
    Group(String),
    /// The word is neither yes nor no.
    #[error("'{0}' is neither yes nor no; write one of them")]
    YesOrNo(String),
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
        "'{0}' is no list of surfaces; write the numbers of those before the gaps that move, counted from 0, and what else changes: 4 9 radius:5 conic:5 index_shift:5"
    )]
    MovingLine(String),
    /// A line about a position of the groups cannot be understood.
    #[error("'{0}' is no position; write zoom and focus in mm, then the gaps: zoom=35 focus=inf 1.9 36.9")]
    Position(String),
    /// A line about a glass cannot be understood.
    #[error(
        "'{0}' is no glass; write name, formula, range in nm and the formula's numbers: MYGLASS cauchy 400-700 1.5 0.004 -2"
    )]
    GlassLine(String),
    /// A line about a gradient cannot be understood.
    #[error(
        "'{0}' makes no gradient; write a glass defined above, then coefficients by powers of z and even ones of r, and where z is 0: MYGLASS from=1.5 z1=0.05 r2=-0.002 z1r2=0.001"
    )]
    GradientLine(String),
    /// A line about a glass's transmittance cannot be understood.
    #[error(
        "'{0}' is no transmittance; write a glass defined above, then nm:part@mm: MYGLASS 400:0.997@10 500:0.998@10"
    )]
    TransmittanceLine(String),
    /// A coating is none.
    #[error(transparent)]
    Coating(#[from] CoatingError),
    /// Gaps and positions do not fit together.
    #[error(transparent)]
    Moving(#[from] MovingError),
    /// A word is not a finite number.
    #[error("{what} '{found}' is not a finite number; write {}", number_for(found))]
    NotANumber {
        /// The name of the value.
        what: String,
        /// The text in the file that is no such number.
        found: String,
    },
    /// A line of the header has no `#`.
    #[error("this is no surface but a line of the header; write # before it")]
    HeaderWithoutMark,
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
    #[error(
        "a second stop, the first is in line {first_line}; write isstop 1 in the row of the diaphragm only: a fixed stop is a row with isstop 0 and the same medium before and behind"
    )]
    SecondStop {
        /// Line of the first.
        first_line: usize,
    },
    /// The numbers make no lens.
    #[error(transparent)]
    Prescription(#[from] PrescriptionError),
}

/// The advice for a word that is no number.
fn number_for(found: &str) -> String {
    let with_point = found.replace(',', ".");
    let word = found.trim_start_matches(['+', '-']).to_lowercase();
    if found.matches(',').count() == 1 && with_point.parse::<f64>().is_ok_and(f64::is_finite) {
        format!("{with_point}, with a point")
    } else if word.starts_with("inf") || word == "plano" || word == "plane" || word == "flat" {
        "0 for the radius of a plane, and another distance in mm".to_owned()
    } else {
        "one, as in 12.5".to_owned()
    }
}

/// A problem, and its place: one line, `FILE:LINE:COLUMN: fault; remedy`.
#[derive(Clone, Debug, PartialEq)]
pub struct LensFileError {
    /// The file, as it was named.
    pub file: String,
    /// The place in the file, counted from 1.
    pub place: Place,
    /// The problem itself, without its place.
    pub problem: Problem,
}

impl fmt::Display for LensFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_placed(f, &self.file, self.place, &self.problem)
    }
}

impl std::error::Error for LensFileError {}

/// Largest number of characters of a problem in a message.
const LONGEST_PROBLEM: usize = 300;

/// Writes a problem with its place as one line, `FILE:LINE:COLUMN: problem`. A file may repeat itself in its error, and a line of a file may be a
/// million letters long: a long text is cut, and its line ends are blanks.
pub(super) fn write_placed(
    f: &mut fmt::Formatter<'_>,
    file: &str,
    Place { line, column }: Place,
    problem: &dyn fmt::Display,
) -> fmt::Result {
    let problem = one_line(&problem.to_string());
    match problem.char_indices().nth(LONGEST_PROBLEM) {
        None => write!(f, "{file}:{line}:{column}: {problem}"),
        Some((end, _)) => write!(f, "{file}:{line}:{column}: {}…", &problem[..end]),
    }
}

pub(super) fn at(file: &str, line: usize, column: usize, problem: Problem) -> LensFileError {
    LensFileError { file: file.to_owned(), place: Place { line, column }, problem }
}
