//! A star-shaped polygon, sampled evenly.

use std::f64::consts::TAU;

use glam::DVec2;

use super::outline::{ANGLES, Outline};

/// Outlines are widened by this part of their radius, for what they do between the points where they were traced.
/// Larger wastes twice as many samples; smaller leaves light to the defensive samples, which are noisy.
const MARGIN: f64 = 0.004;

/// The part of the reference plane that film points of one cell aim at, about the outline's centre, mm.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    area: f64,
    /// Corners at equal angles; the first again at the end. Empty if no light arrives.
    corners: Vec<DVec2>,
    /// Share of the area in the sectors before each.
    cumulative: Vec<f64>,
    /// Where each sector begins, as a part of the way to its outer edge: more than 0 behind an obstruction.
    inner: Vec<f64>,
    /// Squared radii between which every direction is inside.
    surely: [f64; 2],
}

impl Cell {
    /// No light arrives.
    pub(super) fn dark() -> Self {
        Self { area: 0.0, corners: Vec::new(), cumulative: Vec::new(), inner: Vec::new(), surely: [0.0; 2] }
    }

    pub(super) fn new(outline: &Outline) -> Self {
        let outer = widened(&outline.outer);
        let corner = |i: usize| DVec2::from_angle(i as f64 * TAU / ANGLES as f64) * outer[i % ANGLES];
        let corners: Vec<DVec2> = (0..=ANGLES).map(corner).collect();
        let mut cumulative = Vec::with_capacity(ANGLES);
        let mut inner = Vec::with_capacity(ANGLES);
        let mut area = 0.0;
        for i in 0..ANGLES {
            let next = (i + 1) % ANGLES;
            let hole = outline.inner[i].min(outline.inner[next]) * (1.0 - 2.0 * MARGIN);
            let begin = (hole / outer[i].max(outer[next])).clamp(0.0, 0.99);
            cumulative.push(area);
            inner.push(begin);
            area += 0.5 * corners[i].perp_dot(corners[i + 1]) * (1.0 - begin * begin);
        }
        if !(area > 0.0 && area.is_finite()) {
            return Self::dark();
        }
        cumulative.iter_mut().for_each(|c| *c /= area);
        // An edge is nowhere nearer than its foot or its ends.
        let nearest = |i: usize| {
            let (a, b) = (corners[i], corners[i + 1]);
            let along = (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            a.lerp(b, along).length_squared()
        };
        let farthest_hole = |i: usize| (inner[i] * outer[i].max(outer[(i + 1) % ANGLES])).powi(2);
        let surely = [
            (0..ANGLES).map(farthest_hole).fold(0.0, f64::max),
            (0..ANGLES).map(nearest).fold(f64::INFINITY, f64::min),
        ];
        Self { area, corners, cumulative, inner, surely }
    }

    pub(super) fn area(&self) -> f64 {
        self.area
    }

    /// Corners about the centre, the first again at the end.
    pub(super) fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// A point chosen evenly by two numbers in [0, 1).
    pub(super) fn sample(&self, [u, v]: [f64; 2]) -> DVec2 {
        let i = self.cumulative.partition_point(|&c| c <= u).saturating_sub(1);
        let end = self.cumulative.get(i + 1).copied().unwrap_or(1.0);
        let across = ((u - self.cumulative[i]) / (end - self.cumulative[i])).clamp(0.0, 1.0);
        let begin = self.inner[i] * self.inner[i];
        let out = (begin + v * (1.0 - begin)).sqrt();
        self.corners[i].lerp(self.corners[i + 1], across) * out
    }

    /// True if [`Self::sample`] can return `point`.
    pub(super) fn contains(&self, point: DVec2) -> bool {
        let squared = point.length_squared();
        if squared > self.surely[0] && squared < self.surely[1] {
            return true;
        }
        let turn = (point.y.atan2(point.x) / TAU).rem_euclid(1.0);
        let i = ((turn * ANGLES as f64) as usize).min(ANGLES - 1);
        let edge = self.corners[i + 1] - self.corners[i];
        let out = point.perp_dot(edge) / self.corners[i].perp_dot(edge);
        // Rounding must not put a sample outside of its own sector.
        (self.inner[i] - 1e-12..=1.0 + 1e-12).contains(&out)
    }
}

/// Moves the corners out until the polygon holds what the outline does between them, and by the margin.
///
/// Between two corners a convex outline stays inside of the triangle that the edges on both sides make when they are
/// drawn on: at the tips of a cat's eye the chord would cut it off.
fn widened(radii: &[f64; ANGLES]) -> [f64; ANGLES] {
    let angle = TAU / ANGLES as f64;
    let corner = |i: usize| DVec2::from_angle(i as f64 * angle) * radii[i % ANGLES];
    let mut factor = [1.0f64; ANGLES];
    for i in 0..ANGLES {
        let [before, a, b, after] = [i + ANGLES - 1, i, i + 1, i + 2].map(corner);
        let (edge_a, edge_b) = (a - before, after - b);
        let turn = edge_a.perp_dot(edge_b);
        let chord = b - a;
        // Where the two edges, drawn on, meet: a + edge_a s.
        let s = chord.perp_dot(edge_b) / turn;
        let apex = a + edge_a * s;
        let is_between = turn > 0.0 && s > 0.0 && a.perp_dot(apex) >= 0.0 && apex.perp_dot(b) >= 0.0;
        if is_between {
            let beyond = (apex.perp_dot(chord) / a.perp_dot(chord)).clamp(1.0, LARGEST_WIDENING);
            factor[i] = factor[i].max(beyond);
            factor[(i + 1) % ANGLES] = factor[(i + 1) % ANGLES].max(beyond);
        }
    }
    let mean = radii.iter().sum::<f64>() / ANGLES as f64;
    std::array::from_fn(|i| radii[i] * factor[i] + MARGIN * mean)
}

/// A corner that would have to move farther than this is noise of the outline, not its shape.
const LARGEST_WIDENING: f64 = 1.1;
