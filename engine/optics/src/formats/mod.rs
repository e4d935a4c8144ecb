//! File formats of lenses, one a file, and of camera calibrations ([`calibration`]).
//!
//! [`read`] takes any of them, by ending and content. [`lens`] is the engine's own; it and [`zmx`] are written, too.

pub mod agf;
mod beams;
pub mod bench;
pub mod calibration;
mod columns;
mod configurations;
mod draft;
mod draft_row;
mod forbes;
mod frames;
mod glass_names;
mod header;
pub mod lens;
mod moving;
pub mod oslo;
mod problem;
mod remarks;
pub mod rii;
pub mod seq;
pub mod table;
mod text;
pub mod zmx;
mod zoom_positions;

use std::path::{Path, PathBuf};

use crate::glass::{Catalogue, Medium};

pub use problem::{LensFileError, Problem};
pub use remarks::{Reading, Remark};

/// Longer files are no lenses; `.zmx` of zooms with their merit functions come to a megabyte.
const LARGEST_FILE: usize = 8 << 20;

/// The kinds of lens files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The engine's own `.lens`.
    Lens,
    /// Zemax OpticStudio's `.zmx`.
    Zmx,
    /// CODE V's `.seq`.
    Seq,
    /// OSLO's `.len`.
    Oslo,
    /// pbrt's `.dat`.
    Pbrt,
    /// FlareSim's `.lens`.
    FlareSim,
    /// A table of the Optical Bench.
    Bench,
    /// A glass catalogue, `.agf`: no lens.
    GlassCatalogue,
}

impl Kind {
    /// The kind of a file, by its ending, else by the beginning of its text. A file like none is taken for the engine's own format.
    pub fn of(path: &Path, text: &str) -> Self {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        let has_line = |wanted: &dyn Fn(&str) -> bool| text.lines().take(5000).any(|line| wanted(line.trim()));
        match ending.as_str() {
            "zmx" => return Self::Zmx,
            "seq" => return Self::Seq,
            "len" => return Self::Oslo,
            "dat" => return Self::Pbrt,
            "agf" => return Self::GlassCatalogue,
            _ => {}
        }
        if has_line(&|line| line.eq_ignore_ascii_case("[lens data]")) {
            Self::Bench
        } else if has_line(&|line| line.to_lowercase().starts_with("surfaces:")) {
            Self::FlareSim
        } else if ending == "lens" {
            Self::Lens
        } else if has_line(&|line| line == "SURF 0") {
            Self::Zmx
        } else if has_line(&|line| line.to_uppercase().starts_with("LEN NEW")) {
            Self::Oslo
        } else if has_line(&|line| line.to_uppercase().starts_with("SO ")) {
            Self::Seq
        } else {
            Self::Lens
        }
    }
}

/// Reads a lens file of any kind, with glass catalogues that lie beside it where it names them.
///
/// # Errors
/// [`LensFileError`], one line with file, line and column.
pub fn read(path: &Path, catalogue: &Catalogue) -> Result<Reading, LensFileError> {
    let file = path.display().to_string();
    let bytes = text::bytes(path, &file, LARGEST_FILE)?;
    parse_bytes(&bytes, path, catalogue, path.parent().map(Path::to_owned))
}

/// Reads the glasses of a maker's `.agf`, or the one of a `.yml` of refractiveindex.info, which is called as the file; and the parts of
/// them that could not be used.
///
/// # Errors
/// [`LensFileError`], one line with file, line and column.
pub fn read_glasses(path: &Path) -> Result<(Vec<Medium>, Vec<Remark>), LensFileError> {
    let file = path.display().to_string();
    let bytes = text::bytes(path, &file, LARGEST_FILE)?;
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("yml" | "yaml") => Ok((vec![rii::parse_bytes(&bytes, &file, &text::stem(&file))?], Vec::new())),
        _ => agf::parse_bytes(&bytes, &file),
    }
}

/// Parses the bytes of a lens file of any kind, which may be anything; `path` gives its kind and its name in errors.
pub fn parse_bytes(
    bytes: &[u8],
    path: &Path,
    catalogue: &Catalogue,
    folder: Option<PathBuf>,
) -> Result<Reading, LensFileError> {
    let file = path.display().to_string();
    if bytes.len() > LARGEST_FILE {
        return Err(problem::at(&file, 1, 1, Problem::TooLong { largest: LARGEST_FILE }));
    }
    let text = text::any_encoding(bytes, &file);
    match Kind::of(path, text.as_deref().unwrap_or("")) {
        // Its own reader says more of what is wrong with its bytes.
        Kind::Lens => lens::reading(bytes, &file, catalogue, folder),
        Kind::Zmx => zmx::parse(&text?, &file, catalogue, folder),
        Kind::Seq => seq::parse(&text?, &file, catalogue),
        Kind::Oslo => oslo::parse(&text?, &file, catalogue),
        Kind::Pbrt => table::parse_pbrt(&text?, &file, catalogue),
        Kind::FlareSim => table::parse_flaresim(&text?, &file, catalogue),
        Kind::Bench => bench::parse(&text?, &file, catalogue),
        Kind::GlassCatalogue => Err(problem::at(&file, 1, 1, Problem::GlassCatalogue)),
    }
}
