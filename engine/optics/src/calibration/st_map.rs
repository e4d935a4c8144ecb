//! A distortion as a table over the picture: an ST map.

use glam::{DMat2, DVec2};

/// An ST map: the place in a pinhole's picture that each pixel of a distorted picture shows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StMap {
    size: [usize; 2],
    /// The places by row from the top, then column: pixels of the pinhole's picture from its upper left corner; `None` where nothing is
    /// shown.
    places: Vec<Option<DVec2>>,
    /// The focal lengths: from a place in the pinhole's picture to its plane at unit distance.
    focal: DVec2,
    middle: DVec2,
}

impl StMap {
    /// A map of places by row from the top, then column, pixels of the pinhole's picture from its upper left corner. `focal` and `middle`:
    /// the pinhole's focal length and principal point, pixels.
    pub(super) fn new(size: [usize; 2], places: Vec<Option<DVec2>>, focal: DVec2, middle: DVec2) -> Self {
        Self { size, places, focal, middle }
    }

    /// The point at unit distance from the pinhole that the picture shows at `from_middle`, pixels from its middle, and the derivative,
    /// by cubics between pixels (Catmull and Rom 1974).
    pub(super) fn at(&self, from_middle: DVec2) -> (DVec2, DMat2) {
        let nowhere = (DVec2::ZERO, DMat2::ZERO);
        let [width, height] = self.size;
        let half = DVec2::new(width as f64, height as f64) * 0.5;
        let cell = |at: f64, side: usize| {
            // Pixels have their value in their middle; half a pixel beyond the last ones counts as theirs.
            let at = at - 0.5;
            (at >= -0.5 - 1e-9 && at <= side as f64 - 0.5 + 1e-9).then(|| {
                let first = (at.floor().max(0.0) as usize).min(side.saturating_sub(2));
                (first, at - first as f64)
            })
        };
        let at = from_middle + half;
        let (Some((column, across)), Some((row, down))) = (cell(at.x, width), cell(at.y, height)) else {
            return nowhere;
        };
        let mut rows = [(DVec2::ZERO, DVec2::ZERO); 4];
        for (j, into) in rows.iter_mut().enumerate() {
            let Some(four) = self.four(|i| self.place([column as i64 + i, row as i64 + j as i64 - 1])) else {
                return nowhere;
            };
            *into = cubic(four, across);
        }
        let (value, by_y) = cubic(rows.map(|row| row.0), down);
        let (by_x, _) = cubic(rows.map(|row| row.1), down);
        ((value - self.middle) / self.focal, DMat2::from_cols(by_x / self.focal, by_y / self.focal))
    }

    fn four(&self, place: impl Fn(i64) -> Option<DVec2>) -> Option<[DVec2; 4]> {
        Some([place(-1)?, place(0)?, place(1)?, place(2)?])
    }

    /// A pixel's place; beyond the edges extrapolated from its neighbours.
    fn place(&self, [column, row]: [i64; 2]) -> Option<DVec2> {
        let [width, height] = self.size.map(|side| side as i64);
        let beyond = |i: i64, side: i64| if i < 0 { Some((0, 1)) } else { (i >= side).then_some((side - 1, side - 2)) };
        if let Some((last, before)) = beyond(column, width) {
            return Some(self.place([last, row])? * 2.0 - self.place([before, row])?);
        }
        if let Some((last, before)) = beyond(row, height) {
            return Some(self.place([column, last])? * 2.0 - self.place([column, before])?);
        }
        self.places[row as usize * self.size[0] + column as usize]
    }
}

/// The cubic between the middle two of four values, and its derivative.
fn cubic([a, b, c, d]: [DVec2; 4], t: f64) -> (DVec2, DVec2) {
    let (p, q, r) = ((c - a) * 0.5, a - b * 2.5 + c * 2.0 - d * 0.5, (b - c) * 1.5 + (d - a) * 0.5);
    (b + (p + (q + r * t) * t) * t, p + (q * 2.0 + r * (3.0 * t)) * t)
}
