//! The lines of a lens file about gaps that move.

use crate::prescription::Place;
use crate::prescription::moving::{MovingError, MovingGaps, Position};

use super::{Problem, finite};

/// What they say, with their places.
#[derive(Clone, Default)]
pub(super) struct MovingLines {
    surfaces: Option<(Vec<usize>, Place)>,
    positions: Vec<(Position, Place)>,
}

impl MovingLines {
    /// `4 9 12`: the surfaces before the gaps.
    pub(super) fn surfaces(&mut self, text: &str, place: Place) -> Result<(), Problem> {
        let list: Result<Vec<usize>, _> = text.split_whitespace().map(str::parse).collect();
        match list {
            Ok(list) if !list.is_empty() => {
                self.surfaces = Some((list, place));
                Ok(())
            }
            _ => Err(Problem::Moving(text.to_owned())),
        }
    }

    /// `zoom=35 focus=inf 1.9 36.9`: where the groups are, then the gaps.
    pub(super) fn position(&mut self, text: &str, place: Place) -> Result<(), Problem> {
        let position = position(text).ok_or_else(|| Problem::Position(text.to_owned()))?;
        self.positions.push((position, place));
        Ok(())
    }

    /// Surfaces and positions as they stand in the file, if any do.
    pub(super) fn parts(self) -> Option<(Vec<usize>, Vec<Position>, Vec<Place>)> {
        let (surfaces, _) = self.surfaces?;
        let (positions, places) = self.positions.into_iter().unzip();
        Some((surfaces, positions, places))
    }

    /// The gaps of a lens with so many surfaces; `None` if none moves.
    pub(super) fn gaps(self, count: usize) -> Result<Option<MovingGaps>, (Place, MovingError)> {
        let (surfaces, place) = match (self.surfaces, self.positions.first()) {
            (None, None) => return Ok(None),
            (None, Some((_, place))) => return Err((*place, MovingError::Incomplete)),
            (Some((surfaces, place)), _) => (surfaces, place),
        };
        let (positions, places): (Vec<Position>, Vec<Place>) = self.positions.into_iter().unzip();
        let gaps = MovingGaps::new(surfaces, &positions, count);
        gaps.map(Some).map_err(|(about, error)| (about.map_or(place, |i| places[i]), error))
    }
}

fn position(text: &str) -> Option<Position> {
    let mut found = Position { zoom_mm: None, focus_mm: f64::INFINITY, gaps_mm: Vec::new() };
    let positive = |text: &str| finite(text).filter(|x| *x > 0.0);
    for word in text.split_whitespace() {
        match word.split_once('=') {
            Some(("zoom", value)) => found.zoom_mm = Some(positive(value)?),
            Some(("focus", "inf")) => found.focus_mm = f64::INFINITY,
            Some(("focus", value)) => found.focus_mm = positive(value)?,
            Some(_) => return None,
            None => found.gaps_mm.push(finite(word)?),
        }
    }
    Some(found)
}
