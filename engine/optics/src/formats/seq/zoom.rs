//! The zoom positions of a `.seq` file: `ZOO 3` is their number, `ZOO THI S5 1.2 3.4 5.6` the values of a quantity in each; `THI S5 Z2 3.4` is
//! one of them.

use super::super::beams::StatedBeam;
use super::super::configurations::{self, Configurations};
use super::super::problem::{LensFileError, Problem};
use super::{SeqReader, SeqWord};
use crate::prescription::Place;

/// Quantities that are no matter of the lens itself: weights, variables, fields, their vignetting, titles.
const SILENT: [&str; 24] = [
    "THC", "CCY", "GLC", "WTF", "WTW", "WTA", "XAN", "YAN", "XOB", "YOB", "XIM", "YIM", "XRI", "YRI", "VUX", "VLX",
    "VUY", "VLY", "WL", "REF", "TIT", "PIM", "POS", "CUM",
];

/// Zoom positions as a file states them. Lengths in the file's units.
#[derive(Default)]
pub(super) struct ZoomLines {
    count: usize,
    place: Option<Place>,
    /// The gap behind a surface, counted from 1; 0 is the object.
    gaps: Vec<(usize, Vec<f64>)>,
    /// Single ones: surface, position from 0, gap.
    single: Vec<(usize, usize, f64)>,
    /// The film's distance from its place.
    defocus: Option<Vec<f64>>,
    beams: Vec<StatedBeam>,
}

/// The position of `Z3`, counted from 0.
pub(super) fn position_of(word: &SeqWord) -> Option<usize> {
    let number: usize = word.upper().strip_prefix('Z')?.parse().ok()?;
    number.checked_sub(1).filter(|_| !word.quoted)
}

impl SeqReader<'_> {
    /// The gap behind a surface, counted from 1, in one position.
    pub(super) fn zoom_value(&mut self, surface: usize, position: Option<usize>, gap: f64) {
        if let Some(position) = position.filter(|_| self.zoom.single.len() < configurations::MOST * 1000) {
            self.zoom.single.push((surface, position, gap));
        }
    }

    /// A command `ZOO`.
    pub(super) fn zoom_line(&mut self, words: &[SeqWord]) -> Result<(), LensFileError> {
        let place = words[0].place;
        let quantity = words.get(1).map(SeqWord::upper).unwrap_or_default();
        if quantity.starts_with(|c: char| c.is_ascii_digit()) || words.len() < 2 {
            let count = self.number(words, 1, "ZOO")?;
            if !(1.0..=configurations::MOST as f64).contains(&count) {
                let expected = format!("a number of zoom positions from 1 to {}", configurations::MOST);
                return self.fail(&words[1], Problem::Malformed { found: words[1].text.clone(), expected });
            }
            (self.zoom.count, self.zoom.place) = (count as usize, Some(place));
            return Ok(());
        }
        if SILENT.contains(&quantity.as_str()) {
            return Ok(());
        }
        let surface = words.get(2).map(SeqWord::upper).unwrap_or_default();
        match quantity.as_str() {
            "THI" => {
                let Some(values) = self.zoomed(words, 3)? else { return Ok(()) };
                match surface.as_str() {
                    "SI" => self.zoom.defocus = Some(values),
                    "SO" => self.zoom.gaps.push((0, values)),
                    _ => match surface.strip_prefix('S').and_then(|digits| digits.parse().ok()) {
                        Some(number) => self.zoom.gaps.push((number, values)),
                        None => {
                            let expected = "a surface such as S5, SO or SI".to_owned();
                            let word = words.get(2).unwrap_or(&words[1]);
                            return self.fail(word, Problem::Malformed { found: word.text.clone(), expected });
                        }
                    },
                }
            }
            "EPD" | "FNO" | "NA" | "NAO" => {
                let beam = |value: f64| match quantity.as_str() {
                    "EPD" => StatedBeam::EntrancePupil(value),
                    "FNO" => StatedBeam::FNumber(value),
                    "NA" => StatedBeam::FNumber(0.5 / value),
                    _ => StatedBeam::ObjectNa(value),
                };
                self.zoom.beams = self.zoomed(words, 2)?.into_iter().flatten().map(beam).collect();
            }
            other => {
                let what = format!("'{other}' changes with the zoom; it is kept as in the first position");
                self.draft.remarks.once(&format!("ZOO {other}"), place, what);
            }
        }
        Ok(())
    }

    /// The values in all positions; those that a line does not have are the last that it has. `None` for a line that has none.
    fn zoomed(&self, words: &[SeqWord], first: usize) -> Result<Option<Vec<f64>>, LensFileError> {
        if words.len() <= first {
            return Ok(None);
        }
        let mut values = vec![self.number(words, first, "value in the first zoom position")?];
        for i in first + 1..words.len().min(first + self.zoom.count.max(1)) {
            values.push(self.number(words, i, "value in a zoom position")?);
        }
        let last = values[values.len() - 1];
        values.resize(self.zoom.count.max(1), last);
        Ok(Some(values))
    }

    /// Tells the draft of the zoom positions; its surfaces stand in the first, the film out of focus as there.
    pub(super) fn configure(&mut self) {
        let zoom = std::mem::take(&mut self.zoom);
        let Some(place) = zoom.place.filter(|_| zoom.count > 1) else { return };
        let mut configurations = Configurations::new(zoom.count, 0, place);
        let last = self.draft.rows.len();
        let mut back: Option<Vec<f64>> = None;
        for (number, values) in zoom.gaps {
            if number > last {
                let what = format!("'ZOO THI S{number}' is of no surface between object and film and left out");
                self.draft.remarks.once("ZOO THI", place, what);
            } else if number == last {
                back = Some(values);
            } else {
                for (i, value) in values.into_iter().enumerate() {
                    match number.checked_sub(1) {
                        Some(row) => configurations.gap(row, i, value),
                        None => configurations.object(i, value),
                    }
                }
            }
        }
        for (number, position, gap) in zoom.single {
            match number.cmp(&last) {
                std::cmp::Ordering::Less => configurations.gap(number - 1, position, gap),
                std::cmp::Ordering::Equal if position < zoom.count => {
                    back.get_or_insert_with(|| vec![self.draft.rows[last - 1].thickness_mm; zoom.count])[position] =
                        gap;
                }
                _ => {}
            }
        }
        if let Some(row) = self.draft.rows.len().checked_sub(1)
            && (back.is_some() || zoom.defocus.is_some())
        {
            for i in 0..zoom.count {
                let gap = back.as_ref().map_or(self.draft.rows[row].thickness_mm, |values| values[i]);
                configurations.gap(row, i, gap + zoom.defocus.as_ref().map_or(self.defocus_mm, |values| values[i]));
            }
        }
        for (i, beam) in zoom.beams.into_iter().enumerate() {
            configurations.beam(i, beam);
        }
        self.draft.configurations = Some(configurations);
    }
}
