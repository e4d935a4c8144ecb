//! The ellipse about a pupil, in units of which an outline is held.

use glam::DVec2;

/// An ellipse on the reference plane, with axes along and across the film point's meridian; along the lens's own if
/// that is not symmetric about its axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// The middle of the clear pupil, mm along and across the meridian.
    pub(super) centre: DVec2,
    /// Half of the clear chords through the centre, mm.
    pub(super) semi_axes: DVec2,
}

impl Ellipse {
    /// A circle about the axis.
    pub(super) fn circle(radius: f64) -> Self {
        Self { centre: DVec2::ZERO, semi_axes: DVec2::splat(radius) }
    }

    /// The ellipse in between, or beyond: `t` may lie outside of 0 to 1, but no axis shrinks below a part of the
    /// smaller one.
    #[inline]
    pub(super) fn lerp(self, other: Self, t: f64) -> Self {
        Self {
            centre: self.centre.lerp(other.centre, t),
            semi_axes: self.semi_axes.lerp(other.semi_axes, t.clamp(0.0, 1.0)),
        }
    }

    /// mm² for a unit of area.
    #[inline]
    pub(super) fn gain(&self) -> f64 {
        self.semi_axes.x * self.semi_axes.y
    }

    /// A point in mm, from units of the ellipse, both in axes in which the meridian and the ellipse's axes point along
    /// the unit vectors `meridian` and `axes`.
    #[inline]
    pub(super) fn in_mm(self, point: DVec2, meridian: DVec2, axes: DVec2) -> DVec2 {
        axes.rotate(conjugate_rotate(axes, point) * self.semi_axes) + meridian.rotate(self.centre)
    }

    /// The inverse of [`Self::in_mm`].
    #[inline]
    pub(super) fn in_units(self, point: DVec2, meridian: DVec2, axes: DVec2) -> DVec2 {
        axes.rotate(conjugate_rotate(axes, point - meridian.rotate(self.centre)) / self.semi_axes)
    }
}

/// An axis is at least this part of its neighbours' on the fine grid. Where a pupil shrinks to nothing a line between
/// two nodes would fall below it by any factor; so the outline shrinks in its ellipse instead.
const STEEPEST: f64 = 0.85;

/// The ellipses along a row of nodes: those that were not found taken from the one before, `first` before all.
pub(super) fn carried_on(row: &[Option<Ellipse>], first: Ellipse) -> Vec<Ellipse> {
    let mut last = first;
    let mut all: Vec<Ellipse> = row
        .iter()
        .map(|ellipse| {
            last = ellipse.unwrap_or(last);
            last
        })
        .collect();
    let hold = |all: &mut [Ellipse], i: usize, neighbour: usize| {
        all[i].semi_axes = all[i].semi_axes.max(all[neighbour].semi_axes * STEEPEST);
    };
    (1..all.len()).for_each(|i| hold(&mut all, i, i - 1));
    (1..all.len()).rev().for_each(|i| hold(&mut all, i - 1, i));
    all
}

/// The ellipse at the node (`a`, `r`) of the fine grid, interpolated from the even nodes about it.
pub(super) fn midway(ellipses: &[Vec<Ellipse>], a: usize, r: usize) -> Ellipse {
    let about = |i: usize, end: usize| if i.is_multiple_of(2) || i == end { [i, i] } else { [i - 1, i + 1] };
    let [first, second] = about(r, ellipses[0].len() - 1);
    let row = |a: usize| ellipses[a][first].lerp(ellipses[a][second], 0.5);
    let [one, other] = about(a, ellipses.len() - 1);
    row(one).lerp(row(other), 0.5)
}

/// `v` turned back by the angle of the unit vector `by`.
#[inline]
pub(super) fn conjugate_rotate(by: DVec2, v: DVec2) -> DVec2 {
    DVec2::new(by.x, -by.y).rotate(v)
}
