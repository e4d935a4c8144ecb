//! An axis of the map's table.

/// An interval in equal cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellAxis {
    start: f64,
    pub(super) cells_per_unit: f64,
    pub(super) cells: usize,
}

impl CellAxis {
    pub(super) fn new(start: f64, end: f64, cells: usize) -> Self {
        let length = end - start;
        let cells_per_unit = if length > 0.0 { cells as f64 / length } else { 0.0 };
        Self { start, cells_per_unit, cells }
    }

    /// The cell of `x`, of the nearest end if outside, and the place in the cell, which may lie outside of 0 to 1.
    #[inline]
    pub(super) fn locate(&self, x: f64) -> (usize, f64) {
        let place = (x - self.start) * self.cells_per_unit;
        // Negative numbers and those that are none become 0, whole numbers too large for a cast the last.
        let cell = (place.max(0.0) as i32 as usize).min(self.cells - 1);
        (cell, place - cell as f64)
    }

    /// The value at `node`, counted in cells.
    pub(super) fn at(&self, node: f64) -> f64 {
        if self.cells_per_unit > 0.0 { self.start + node / self.cells_per_unit } else { self.start }
    }
}
