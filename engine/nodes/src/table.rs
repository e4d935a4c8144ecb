//! Color Ramp and curves: rows that Blender has evaluated, as many as Cycles takes, read between them as Cycles does.

use glam::{Vec3A, Vec4};

/// A ramp or a set of curves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    pub(crate) rows: Vec<Vec4>,
    /// False for a ramp of constant steps.
    pub(crate) interpolate: bool,
    /// Positions of the first and last row.
    pub(crate) range: [f32; 2],
    /// True if curves go on straight beyond their ends.
    pub(crate) extrapolate: bool,
}

impl Table {
    /// The row at a place from 0, the first, to 1, the last.
    fn at(&self, place: f32) -> Vec4 {
        let last = self.rows.len() - 1;
        if self.extrapolate && !(0.0..=1.0).contains(&place) {
            let (end, before, beyond) = if place < 0.0 {
                (self.rows[0], self.rows[1.min(last)], -place)
            } else {
                (self.rows[last], self.rows[last.saturating_sub(1)], place - 1.0)
            };
            return end + (end - before) * (beyond * last as f32);
        }
        let place = place.clamp(0.0, 1.0) * last as f32;
        // What is no number becomes row 0.
        let row = (place as usize).min(last);
        let share = place - row as f32;
        if self.interpolate && share > 0.0 && row < last {
            self.rows[row] * (1.0 - share) + self.rows[row + 1] * share
        } else {
            self.rows[row]
        }
    }

    pub(crate) fn ramp(&self, place: f32) -> Vec4 {
        self.at(place)
    }

    fn scaled(&self, value: f32) -> f32 {
        (value - self.range[0]) / (self.range[1] - self.range[0])
    }

    /// Each part through its own curve, by a factor.
    pub(crate) fn curves(&self, factor: f32, value: Vec3A) -> Vec3A {
        let curved = Vec3A::new(
            self.at(self.scaled(value.x)).x,
            self.at(self.scaled(value.y)).y,
            self.at(self.scaled(value.z)).z,
        );
        value * (1.0 - factor) + curved * factor
    }

    pub(crate) fn float_curve(&self, factor: f32, value: f32) -> f32 {
        (1.0 - factor) * value + factor * self.at(self.scaled(value)).x
    }
}
