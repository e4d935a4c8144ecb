//! The lines of a lens file about gaps that move.

use crate::prescription::moving::{MovingError, MovingParts, Part, Position};
use crate::prescription::{Place, SurfaceRow};

use super::problem::Problem;
use super::text::finite;

/// The contents of the lines, with their places.
#[derive(Clone, Default)]
pub(super) struct MovingLines {
    parts: Option<(Vec<Part>, Place)>,
    positions: Vec<(Position, Place)>,
}

impl MovingLines {
    /// `4 9 radius:3`: the surfaces before the gaps, and the other numbers that change.
    pub(super) fn moved(&mut self, text: &str, place: Place) -> Result<(), Problem> {
        let list: Result<Vec<Part>, _> = text.split_whitespace().map(str::parse).collect();
        match list {
            Ok(list) if !list.is_empty() => {
                self.parts = Some((list, place));
                Ok(())
            }
            _ => Err(Problem::MovingLine(text.to_owned())),
        }
    }

    /// `zoom=35 focus=inf 1.9 36.9`: where the groups are, then the gaps.
    pub(super) fn position(&mut self, text: &str, place: Place) -> Result<(), Problem> {
        let position = position(text).ok_or_else(|| Problem::Position(text.to_owned()))?;
        self.positions.push((position, place));
        Ok(())
    }

    /// True if the file has no such line.
    pub(super) fn is_empty(&self) -> bool {
        self.parts.is_none() && self.positions.is_empty()
    }

    /// The moving parts and positions, as they stand in the file, if there are any.
    pub(super) fn parts(self) -> Option<(Vec<Part>, Vec<Position>, Vec<Place>)> {
        let (parts, _) = self.parts?;
        let (positions, places) = self.positions.into_iter().unzip();
        Some((parts, positions, places))
    }

    /// The moving parts of a lens with these rows; `None` if nothing moves.
    pub(super) fn of(self, rows: &[SurfaceRow]) -> Result<Option<MovingParts>, (Place, MovingError)> {
        let (parts, place) = match (self.parts, self.positions.first()) {
            (None, None) => return Ok(None),
            (None, Some((_, place))) => return Err((*place, MovingError::Incomplete)),
            (Some((parts, place)), _) => (parts, place),
        };
        let (positions, places): (Vec<Position>, Vec<Place>) = self.positions.into_iter().unzip();
        let placed = |(about, error): (Option<usize>, MovingError)| (about.map_or(place, |i| places[i]), error);
        let moving = MovingParts::new(parts, &positions, rows.len()).map_err(placed)?;
        moving.check(rows, &positions).map_err(placed)?;
        Ok(Some(moving))
    }
}

fn position(text: &str) -> Option<Position> {
    let mut found = Position { zoom_mm: None, focus_mm: f64::INFINITY, values: Vec::new() };
    let positive = |text: &str| finite(text).filter(|x| *x > 0.0);
    for word in text.split_whitespace() {
        match word.split_once('=') {
            Some(("zoom", value)) => found.zoom_mm = Some(positive(value)?),
            Some(("focus", "inf")) => found.focus_mm = f64::INFINITY,
            Some(("focus", value)) => found.focus_mm = positive(value)?,
            Some(_) => return None,
            None => found.values.push(finite(word)?),
        }
    }
    Some(found)
}
