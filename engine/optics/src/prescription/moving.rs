//! Lenses that move inside: gaps that change when the lens is zoomed, or focused by some of its groups; and eyes, whose lens
//! changes its shape.
//!
//! Published tables give the gaps, and other numbers that change, at some positions. Between them each gap, curvature, conic constant
//! or index follows a smooth curve that never turns where the table does not (Fritsch and Butland 1984): over the logarithm of the
//! focal length from zoom position to zoom position, and over the nearness, one over the distance, from one focus to the next.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::glass::Medium;
use crate::prescription::{NextMedium, PrescriptionError, SurfaceRow};
use crate::surface::Conic;

/// A quantity of a surface that may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The thickness behind the surface, mm.
    Gap,
    /// The radius of curvature, mm; 0 is a plane. Between positions it is the curvature that changes evenly.
    Radius,
    /// The conic constant of the surface.
    Conic,
    /// The clear diameter, mm.
    Diameter,
    /// The number that is added at every wavelength to the index of the medium behind it.
    IndexShift,
}

/// The words for quantities in lens files; gaps go without.
const WORDS: [(&str, Quantity); 4] = [
    ("radius", Quantity::Radius),
    ("conic", Quantity::Conic),
    ("diameter", Quantity::Diameter),
    ("index_shift", Quantity::IndexShift),
];

/// A number of a lens that changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Index of the surface.
    pub surface: usize,
    /// The quantity of the surface.
    pub quantity: Quantity,
}

impl Part {
    /// The gap behind a surface.
    pub fn gap(surface: usize) -> Self {
        Self { surface, quantity: Quantity::Gap }
    }

    /// Puts a value in its place; the curvature for a radius.
    fn set(self, rows: &mut [SurfaceRow], value: f64) {
        let row = &mut rows[self.surface];
        let base = row.shape.profile().base;
        match self.quantity {
            Quantity::Gap => row.thickness_mm = value,
            Quantity::Radius => row.shape = row.shape.with_base(Conic { curvature: value, ..base }),
            Quantity::Conic => row.shape = row.shape.with_base(Conic { conic: value, ..base }),
            Quantity::Diameter => row.semi_diameter_mm = value / 2.0,
            Quantity::IndexShift => {
                if let NextMedium::Medium(medium) = &mut row.behind {
                    *medium = medium.with_index_shift(value);
                }
            }
        }
    }

    /// The number that changes evenly for a value of the table.
    fn even(self, value: f64) -> f64 {
        if self.quantity == Quantity::Radius { Conic::new(value, 0.0).curvature } else { value }
    }
}

/// The text in lens files: `4`, `radius:4`.
impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((word, _)) = WORDS.iter().find(|(_, quantity)| *quantity == self.quantity) {
            write!(f, "{word}:")?;
        }
        write!(f, "{}", self.surface)
    }
}

impl FromStr for Part {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let (quantity, surface) = match text.split_once(':') {
            None => (Quantity::Gap, text),
            Some((word, surface)) => (WORDS.iter().find(|(known, _)| *known == word).ok_or(())?.1, surface),
        };
        Ok(Self { surface: surface.parse().map_err(|_| ())?, quantity })
    }
}

/// The numbers at one position of the groups.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// Nominal focal length, mm; `None` for a lens that does not zoom.
    pub zoom_mm: Option<f64>,
    /// Distance of the sharp plane from the first vertex, mm; may be infinite.
    pub focus_mm: f64,
    /// Values of the moving parts.
    pub values: Vec<f64>,
}

/// An error by which gaps and positions do not fit together.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MovingError {
    /// A part is of no surface, or there twice.
    #[error("surface {} has no such part to move, or it is named twice: '{part}'; name surfaces from 0 to {last}, each part once", .part.surface)]
    Surface {
        /// The part that was named.
        part: Part,
        /// The last surface of the lens.
        last: usize,
    },
    /// The index behind a surface is to change where there is a mirror, or air.
    #[error("behind surface {surface} is a mirror, or air, whose index does not change; name another surface")]
    NoIndex {
        /// Index of the surface.
        surface: usize,
    },
    /// Too many or too few numbers.
    #[error("{found} numbers where {expected} parts move; give one for each that the line 'moving' names")]
    Gaps {
        /// Numbers in this position.
        found: usize,
        /// Number of moving parts.
        expected: usize,
    },
    /// Some positions have a zoom, others not.
    #[error("some positions have a zoom and others not; give it in all or in none")]
    ZoomMissing,
    /// A zoom or a distance that is none.
    #[error("zoom={zoom_mm} focus={focus_mm} is no position; write focal length and distance in mm, above zero")]
    Place {
        /// Focal length, mm; 1 of a prime.
        zoom_mm: f64,
        /// Distance from the first vertex, mm.
        focus_mm: f64,
    },
    /// A zoom has no position at infinity.
    #[error("no position has focus=inf at this zoom; give one for each zoom, to count the others from")]
    NoInfinity,
    /// A position is given twice.
    #[error("this zoom and focus were given before; take one out")]
    Twice,
    /// A position makes no lens.
    #[error(transparent)]
    Position(Box<PrescriptionError>),
    /// One of the lines `moving` and `position` without the other.
    #[error(
        "gaps that move need both lines, '# moving: SURFACES' and '# position: zoom=MM focus=MM GAPS'; add the other"
    )]
    Incomplete,
}

/// The numbers at one zoom.
#[derive(Clone, Debug, PartialEq)]
struct Zoom {
    mm: f64,
    /// One over the distances, from 0.
    nearness_per_mm: Vec<f64>,
    /// The distances as the table has them.
    focus_mm: Vec<f64>,
    /// Values by distance, then by part.
    values: Vec<Vec<f64>>,
}

/// The moving parts of a lens, by zoom and focus.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingParts {
    parts: Vec<Part>,
    zooms_in: bool,
    first_zoom_mm: f64,
    /// The zoom positions, by rising focal length.
    zooms: Vec<Zoom>,
}

impl MovingParts {
    /// The moving `parts` of a lens of `count` surfaces, at each position; the first is the one the lens is published in.
    ///
    /// # Errors
    /// [`MovingError`], with the number of the position that it is about.
    pub fn new(parts: Vec<Part>, positions: &[Position], count: usize) -> Result<Self, (Option<usize>, MovingError)> {
        for (i, &part) in parts.iter().enumerate() {
            if part.surface >= count || parts[..i].contains(&part) {
                return Err((None, MovingError::Surface { part, last: count.saturating_sub(1) }));
            }
        }
        let Some(first) = positions.first().filter(|_| !parts.is_empty()) else {
            return Err((None, MovingError::Incomplete));
        };
        // A prime is a zoom with one place.
        let zoom = |p: &Position| p.zoom_mm.unwrap_or(1.0);
        let mut order: Vec<usize> = (0..positions.len()).collect();
        order.sort_by(|&a, &b| {
            let (a, b) = (&positions[a], &positions[b]);
            zoom(a).total_cmp(&zoom(b)).then(b.focus_mm.total_cmp(&a.focus_mm))
        });
        let mut zooms: Vec<Zoom> = Vec::new();
        for i in order {
            let p = &positions[i];
            let fail = |error| Err((Some(i), error));
            if p.values.len() != parts.len() {
                return fail(MovingError::Gaps { found: p.values.len(), expected: parts.len() });
            }
            if p.zoom_mm.is_some() != first.zoom_mm.is_some() {
                return fail(MovingError::ZoomMissing);
            }
            if !(zoom(p) > 0.0 && zoom(p).is_finite() && p.focus_mm > 0.0) {
                return fail(MovingError::Place { zoom_mm: zoom(p), focus_mm: p.focus_mm });
            }
            let nearness = p.focus_mm.recip();
            match zooms.last_mut().filter(|last| last.mm == zoom(p)) {
                Some(last) if last.nearness_per_mm.contains(&nearness) => return fail(MovingError::Twice),
                Some(last) => {
                    last.nearness_per_mm.push(nearness);
                    last.focus_mm.push(p.focus_mm);
                    last.values.push(p.values.clone());
                }
                None if nearness != 0.0 => return fail(MovingError::NoInfinity),
                None => {
                    let values = vec![p.values.clone()];
                    let (nearness_per_mm, focus_mm) = (vec![0.0], vec![f64::INFINITY]);
                    zooms.push(Zoom { mm: zoom(p), nearness_per_mm, focus_mm, values });
                }
            }
        }
        Ok(Self { parts, zooms_in: zooms.len() > 1, first_zoom_mm: zoom(first), zooms })
    }

    /// The parts of a lens `factor` times as large; the nominal focal lengths of a zoom are so, too.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let zoom_mm = |mm: f64| if self.zooms_in { mm * factor } else { mm };
        let value = |(part, value): (&Part, &f64)| match part.quantity {
            Quantity::Gap | Quantity::Radius | Quantity::Diameter => value * factor,
            Quantity::Conic | Quantity::IndexShift => *value,
        };
        let zoom = |zoom: &Zoom| Zoom {
            mm: zoom_mm(zoom.mm),
            nearness_per_mm: zoom.nearness_per_mm.iter().map(|nearness| nearness / factor).collect(),
            focus_mm: zoom.focus_mm.iter().map(|mm| mm * factor).collect(),
            values: zoom.values.iter().map(|values| self.parts.iter().zip(values).map(value).collect()).collect(),
        };
        Self {
            parts: self.parts.clone(),
            zooms_in: self.zooms_in,
            first_zoom_mm: zoom_mm(self.first_zoom_mm),
            zooms: self.zooms.iter().map(zoom).collect(),
        }
    }

    /// Nominal focal lengths of the shortest and the longest zoom, mm; `None` if the lens does not zoom.
    pub fn zoom_range_mm(&self) -> Option<[f64; 2]> {
        self.zooms_in.then(|| [self.zooms[0].mm, self.zooms[self.zooms.len() - 1].mm])
    }

    /// True if groups inside move to focus the lens at every zoom: else the film or the whole lens does.
    pub fn focuses(&self) -> bool {
        self.zooms.iter().all(|zoom| zoom.nearness_per_mm.len() > 1)
    }

    /// The quantities that change with zoom or focus, each of one surface.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Checks the parts: the error names one of them that is the index shift of no medium of its own, or the fault of the lens in
    /// one of the positions, as they were given, and in which.
    pub fn check(&self, rows: &[SurfaceRow], given: &[Position]) -> Result<(), (Option<usize>, MovingError)> {
        let is_medium =
            |row: &SurfaceRow| matches!(&row.behind, NextMedium::Medium(medium) if *medium != Medium::air());
        let bad = |part: &&Part| part.quantity == Quantity::IndexShift && !is_medium(&rows[part.surface]);
        if let Some(part) = self.parts.iter().find(bad) {
            return Err((None, MovingError::NoIndex { surface: part.surface }));
        }
        for (i, position) in given.iter().enumerate() {
            let mut rows = rows.to_vec();
            self.set(&mut rows, &position.values);
            for part in &self.parts {
                let checked = rows[part.surface].check(part.surface);
                checked.map_err(|error| (Some(i), MovingError::Position(Box::new(error))))?;
            }
        }
        Ok(())
    }

    /// Puts all parts where a position of the table has them.
    pub(super) fn set(&self, rows: &mut [SurfaceRow], values: &[f64]) {
        for (part, value) in self.parts.iter().zip(values) {
            part.set(rows, part.even(*value));
        }
    }

    /// Puts all parts where they are at a zoom and a travel of the focus, as [`Self::values`] has them.
    pub(super) fn place(&self, rows: &mut [SurfaceRow], zoom_mm: f64, travel: f64) {
        for (part, value) in self.parts.iter().zip(self.values(zoom_mm, travel)) {
            part.set(rows, value);
        }
    }

    /// The positions of the table, the published one first.
    pub fn positions(&self) -> Vec<Position> {
        let of_zoom = |zoom: &Zoom| {
            let zoom_mm = self.zooms_in.then_some(zoom.mm);
            let focuses = zoom.focus_mm.iter().zip(&zoom.values);
            let position =
                |(&focus_mm, values): (&f64, &Vec<f64>)| Position { zoom_mm, focus_mm, values: values.clone() };
            focuses.map(position).collect::<Vec<_>>()
        };
        let (first, others): (Vec<&Zoom>, Vec<&Zoom>) =
            self.zooms.iter().partition(|zoom| zoom.mm == self.first_zoom_mm);
        first.into_iter().chain(others).flat_map(of_zoom).collect()
    }

    /// The zoom that the lens is published in, mm; 1 if it does not zoom.
    pub fn first_zoom_mm(&self) -> f64 {
        self.first_zoom_mm
    }

    /// The parts at a zoom and a travel of the focus: 0 at infinity, 1 at the nearest distance of the table. Somewhat
    /// beyond both they go on straight. Curvatures, in 1/mm, for radii.
    pub fn values(&self, zoom_mm: f64, travel: f64) -> Vec<f64> {
        let at_zoom = |zoom: &Zoom, part: usize| {
            let nearest = zoom.nearness_per_mm[zoom.nearness_per_mm.len() - 1];
            let values: Vec<f64> = zoom.values.iter().map(|values| self.parts[part].even(values[part])).collect();
            smooth(&zoom.nearness_per_mm, &values, travel * nearest)
        };
        let places: Vec<f64> = self.zooms.iter().map(|zoom| zoom.mm.ln()).collect();
        let part = |part: usize| {
            let values: Vec<f64> = self.zooms.iter().map(|zoom| at_zoom(zoom, part)).collect();
            smooth(&places, &values, zoom_mm.ln())
        };
        (0..self.parts.len()).map(part).collect()
    }
}

/// A smooth curve through the points (x, y), x rising, that rises and falls only where they do; straight beyond them.
fn smooth(x: &[f64], y: &[f64], at: f64) -> f64 {
    let last = x.len() - 1;
    if last == 0 {
        return y[0];
    }
    let rise = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
    let slope = |i: usize| {
        if i == 0 || i == last {
            return rise(i.min(last - 1));
        }
        let (a, b) = (rise(i - 1), rise(i));
        // A harmonic mean, weighted by the lengths on both sides.
        let (before, after) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let (wa, wb) = (2.0 * after + before, after + 2.0 * before);
        if a * b > 0.0 { (wa + wb) / (wa / a + wb / b) } else { 0.0 }
    };
    if at <= x[0] {
        return y[0] + slope(0) * (at - x[0]);
    }
    if at >= x[last] {
        return y[last] + slope(last) * (at - x[last]);
    }
    let i = x.partition_point(|&x| x <= at).clamp(1, last) - 1;
    let h = x[i + 1] - x[i];
    let t = (at - x[i]) / h;
    let (a, b, da, db) = (y[i], y[i + 1], slope(i) * h, slope(i + 1) * h);
    let (c2, c3) = (3.0 * (b - a) - 2.0 * da - db, da + db - 2.0 * (b - a));
    a + t * (da + t * (c2 + t * c3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaps(surfaces: &[usize]) -> Vec<Part> {
        surfaces.iter().map(|&surface| Part::gap(surface)).collect()
    }

    fn position(zoom_mm: Option<f64>, focus_mm: f64, values: &[f64]) -> Position {
        Position { zoom_mm, focus_mm, values: values.to_vec() }
    }

    #[test]
    fn the_table_is_kept_and_nothing_overshoots() {
        let inf = f64::INFINITY;
        let positions = [
            position(Some(50.0), inf, &[1.0, 9.0]),
            position(Some(20.0), 500.0, &[8.0, 3.0]),
            position(Some(20.0), inf, &[7.0, 2.0]),
            position(Some(50.0), 1000.0, &[1.5, 9.5]),
            position(Some(50.0), 2000.0, &[1.5, 9.1]),
        ];
        let moving = MovingParts::new(gaps(&[3, 7]), &positions, 8).unwrap();
        assert_eq!(moving.zoom_range_mm(), Some([20.0, 50.0]));
        assert_eq!(moving.first_zoom_mm(), 50.0);
        assert!(moving.focuses());
        let close = |found: Vec<f64>, expected: [f64; 2]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {expected:?}");
        };
        close(moving.values(20.0, 0.0), [7.0, 2.0]);
        close(moving.values(20.0, 1.0), [8.0, 3.0]);
        close(moving.values(50.0, 0.5), [1.5, 9.1]);
        close(moving.values(50.0, 1.0), [1.5, 9.5]);
        let mut last = moving.values(20.0, 0.0);
        for i in 1..=100 {
            let now = moving.values(20.0 + 0.3 * f64::from(i), 0.0);
            assert!(now[0] < last[0] && now[1] > last[1], "{i}: {last:?} {now:?}");
            last = now;
        }
        // Where the table stands still, so does the gap.
        for i in 50..=100 {
            assert!((moving.values(50.0, f64::from(i) / 100.0)[0] - 1.5).abs() < 1e-12);
        }
    }

    #[test]
    fn tables_that_do_not_fit_are_named() {
        let inf = f64::INFINITY;
        let new =
            |surfaces: &[usize], positions: &[Position]| MovingParts::new(gaps(surfaces), positions, 5).unwrap_err();
        let one = position(None, inf, &[1.0]);
        assert_eq!(new(&[5], std::slice::from_ref(&one)), (None, MovingError::Surface { part: Part::gap(5), last: 4 }));
        assert_eq!(
            new(&[2, 2], std::slice::from_ref(&one)),
            (None, MovingError::Surface { part: Part::gap(2), last: 4 })
        );
        for (zoom_mm, focus_mm) in [(-1.0, inf), (0.0, inf), (inf, inf), (f64::NAN, inf), (1.0, 0.0), (1.0, f64::NAN)] {
            let (which, why) = new(&[2], &[position(Some(zoom_mm), focus_mm, &[1.0])]);
            assert!(which == Some(0) && matches!(why, MovingError::Place { .. }), "{zoom_mm} {focus_mm}: {why}");
        }
        assert_eq!(new(&[2], &[]), (None, MovingError::Incomplete));
        assert_eq!(new(&[], std::slice::from_ref(&one)), (None, MovingError::Incomplete));
        let too_few = MovingError::Gaps { found: 1, expected: 2 };
        assert_eq!(new(&[2, 3], std::slice::from_ref(&one)), (Some(0), too_few));
        assert_eq!(new(&[2], &[one.clone(), position(Some(3.0), inf, &[1.0])]), (Some(1), MovingError::ZoomMissing));
        assert_eq!(new(&[2], &[one.clone(), one.clone()]), (Some(1), MovingError::Twice));
        assert_eq!(new(&[2], &[position(None, 100.0, &[1.0])]), (Some(0), MovingError::NoInfinity));
    }
}
