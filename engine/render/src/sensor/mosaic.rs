//! The pattern of colour filters on a sensor's photosites.

use serde::{Deserialize, Deserializer};

/// Fujifilm's pattern, 6 by 6, first row at the top.
const X_TRANS: [&str; 6] = ["GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG"];

/// The most columns or rows of a pattern.
const LARGEST: usize = 16;

/// The channels of a sensor's photosites.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mosaic {
    /// All three at each photosite: layers, three sensors behind a prism, or one sensor that is moved.
    None,
    /// One channel without a colour.
    Monochrome,
    /// One of red (0), green (1) and blue (2) at each photosite, in a pattern that repeats.
    Pattern {
        /// Columns of the pattern.
        width: usize,
        /// Filters by rows, the first at the top left.
        filters: Vec<u8>,
    },
}

impl Mosaic {
    /// The pattern by its word: `none`, `monochrome`, `x-trans`, or the four filters of a Bayer pattern by rows as `rggb`.
    ///
    /// # Errors
    /// The word names none.
    pub fn by_word(word: &str) -> Result<Self, String> {
        match word.to_ascii_lowercase().as_str() {
            "none" => Ok(Self::None),
            "monochrome" => Ok(Self::Monochrome),
            "x-trans" => Self::of_rows(&X_TRANS),
            bayer @ ("rggb" | "bggr" | "grbg" | "gbrg") => Self::of_rows(&[&bayer[..2], &bayer[2..]]),
            _ => Err(format!(
                "no such mosaic: {word}: give none, monochrome, rggb, bggr, grbg, gbrg, x-trans, or rows of R, G and B"
            )),
        }
    }

    /// A pattern by its rows of the letters R, G and B.
    ///
    /// # Errors
    /// The rows are not of one length, from 1 to 16, a letter is none of the three, or a colour is missing.
    pub fn of_rows(rows: &[impl AsRef<str>]) -> Result<Self, String> {
        let width = rows.first().map_or(0, |row| row.as_ref().len());
        if !(1..=LARGEST).contains(&width) || rows.len() > LARGEST || rows.iter().any(|row| row.as_ref().len() != width)
        {
            return Err(format!("mosaic: rows must be of one length, and 1 to {LARGEST} of 1 to {LARGEST} letters"));
        }
        let letters = rows.iter().flat_map(|row| row.as_ref().chars());
        let filter = |letter: char| {
            let place = "RGB".find(letter.to_ascii_uppercase());
            place.map(|place| place as u8).ok_or_else(|| format!("mosaic: '{letter}' is none of R, G and B"))
        };
        let filters: Vec<u8> = letters.map(filter).collect::<Result<_, _>>()?;
        if (0..3).any(|colour| !filters.contains(&colour)) {
            return Err("mosaic: one of R, G and B is missing".to_owned());
        }
        Ok(Self::Pattern { width, filters })
    }

    /// Numbers that each photosite gives.
    pub fn planes(&self) -> usize {
        if *self == Self::None { 3 } else { 1 }
    }

    /// The channel of a photosite's plane, counted from the left and from the top.
    #[inline]
    pub fn channel(&self, x: usize, y: usize, plane: usize) -> usize {
        match self {
            Self::None => plane,
            Self::Monochrome => 0,
            Self::Pattern { width, filters } => {
                let row = y % (filters.len() / width);
                usize::from(filters[row * width + x % width])
            }
        }
    }

    /// The pattern in a line.
    pub fn words(&self) -> String {
        match self {
            Self::None => "none".to_owned(),
            Self::Monochrome => "monochrome".to_owned(),
            Self::Pattern { width, filters } => {
                let letters: Vec<char> = filters.iter().map(|filter| ['R', 'G', 'B'][usize::from(*filter)]).collect();
                letters.chunks(*width).map(|row| row.iter().collect::<String>()).collect::<Vec<_>>().join(" ")
            }
        }
    }
}

impl<'de> Deserialize<'de> for Mosaic {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Word(String),
            Rows(Vec<String>),
        }
        let read = match Written::deserialize(from)? {
            Written::Word(word) => Self::by_word(&word),
            Written::Rows(rows) => Self::of_rows(&rows),
        };
        read.map_err(serde::de::Error::custom)
    }
}
