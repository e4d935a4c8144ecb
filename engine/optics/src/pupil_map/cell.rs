//! A star-shaped polygon, sampled evenly.

use std::f64::consts::TAU;

use glam::DVec2;

use super::outline::{ANGLES, PupilOutline};

/// Outlines are widened by this part of their radius, for their course between the traced points.
/// Larger wastes twice as many samples; smaller leaves light to the defensive samples, which are noisy.
const MARGIN: f64 = 0.003;

/// The targets of the film points of one cell, in units of their ellipses.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    area: f64,
    /// One over the area; 0 if no light arrives.
    density: f64,
    /// Sectors at equal angles. Empty if no light arrives.
    sectors: Vec<Sector>,
    /// The sector in which each of as many equal parts of the area begins: to look there first (Chen and Asau 1974).
    guide: Vec<u8>,
    /// Squared radii between which every direction is inside.
    surely: [f64; 2],
}

/// The sector between two neighbouring corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sector {
    pub(super) corner: DVec2,
    /// Vector to the next corner.
    pub(super) edge: DVec2,
    /// Share of the area in the sectors before it.
    pub(super) start: f64,
    /// One over the share of the sector.
    pub(super) inverse_share: f64,
    /// The sector's beginning, as a part of the way to its outer edge: more than 0 behind an obstruction.
    pub(super) inner: f64,
}

/// Entries of the guide: more find the sector at once more often and take more of the cache.
pub(super) const GUIDE: usize = 256;
// Numbers of sectors fit the guide.
const _: () = assert!(ANGLES <= 1 << u8::BITS);

impl Cell {
    /// A cell at which no light arrives.
    pub(super) fn dark() -> Self {
        Self { area: 0.0, density: 0.0, sectors: Vec::new(), guide: Vec::new(), surely: [0.0; 2] }
    }

    pub(super) fn new(outline: &PupilOutline) -> Self {
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
        let guide = |part: usize| {
            let u = part as f64 / GUIDE as f64;
            (cumulative.partition_point(|&c| c <= u).max(1) - 1) as u8
        };
        let guide = (0..GUIDE).map(guide).collect();
        let sector = |i: usize| {
            let end = cumulative.get(i + 1).copied().unwrap_or(1.0);
            Sector {
                corner: corners[i],
                edge: corners[i + 1] - corners[i],
                start: cumulative[i],
                // Finite also where there is nothing to choose.
                inverse_share: (end - cumulative[i]).recip().min(f64::MAX),
                inner: inner[i],
            }
        };
        let sectors = (0..ANGLES).map(sector).collect();
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
        Self { area, density: area.recip(), sectors, guide, surely }
    }

    pub(super) fn area(&self) -> f64 {
        self.area
    }

    /// Density of [`Self::sample`]; 0 if no light arrives.
    #[inline]
    pub(super) fn density(&self) -> f64 {
        self.density
    }

    /// Corners about the centre, the first again at the end; none if no light arrives.
    pub(super) fn corners(&self) -> impl Iterator<Item = DVec2> + use<'_> {
        self.sectors.iter().chain(self.sectors.first()).map(|sector| sector.corner)
    }

    /// Sectors at equal angles; none if no light arrives.
    pub(super) fn sectors(&self) -> &[Sector] {
        &self.sectors
    }

    /// The sector in which each of [`GUIDE`] equal parts of the area begins; none if no light arrives.
    pub(super) fn guide(&self) -> &[u8] {
        &self.guide
    }

    /// Squared radii between which every direction is inside.
    pub(super) fn surely(&self) -> [f64; 2] {
        self.surely
    }

    /// A point chosen evenly by two numbers in [0, 1).
    #[inline]
    pub(super) fn sample(&self, [u, v]: [f64; 2]) -> DVec2 {
        let (sector, across) = self.sector(u);
        let begin = sector.inner * sector.inner;
        let out = (begin + v * (1.0 - begin)).sqrt();
        (sector.corner + sector.edge * across) * out
    }

    /// The sector that `u` chooses, and the part of its edge.
    #[inline]
    fn sector(&self, u: f64) -> (&Sector, f64) {
        let part = ((u * GUIDE as f64) as i32 as usize).min(GUIDE - 1);
        let mut i = usize::from(self.guide[part]);
        let mut sector = &self.sectors[i];
        let mut across = (u - sector.start) * sector.inverse_share;
        while across >= 1.0 && i + 1 < ANGLES {
            i += 1;
            sector = &self.sectors[i];
            across = (u - sector.start) * sector.inverse_share;
        }
        (sector, across.clamp(0.0, 1.0))
    }

    /// True if [`Self::sample`] can return `point`.
    #[inline]
    pub(super) fn contains(&self, point: DVec2) -> bool {
        let squared = point.length_squared();
        squared > self.surely[0] && squared < self.surely[1] || self.contains_by_sector(point)
    }

    /// [`Self::contains`] where the distance alone does not decide it; not for a dark cell.
    pub(super) fn contains_by_sector(&self, point: DVec2) -> bool {
        let guess = nearly_sector(point);
        let next = |i: usize| if i + 1 < ANGLES { i + 1 } else { 0 };
        let is_before = self.sectors[guess].corner.perp_dot(point) < 0.0;
        let is_behind = self.sectors[next(guess)].corner.perp_dot(point) >= 0.0;
        let sector = &self.sectors[match (is_before, is_behind) {
            (true, _) => guess.checked_sub(1).unwrap_or(ANGLES - 1),
            (_, true) => next(guess),
            _ => guess,
        }];
        let out = point.perp_dot(sector.edge) / sector.corner.perp_dot(sector.edge);
        // Rounding must not put a sample outside of its own sector, nor that of single precision.
        (sector.inner - ROUNDINGS..=1.0 + ROUNDINGS).contains(&out)
    }
}

/// Bound of the rounding error of a sample in single precision, in units of the way to the edge: 8 roundings.
const ROUNDINGS: f64 = 4.0 * f32::EPSILON as f64;

/// The sector of a point, or a neighbour of it.
#[inline]
fn nearly_sector(point: DVec2) -> usize {
    let DVec2 { x, y } = point.abs();
    let t = x.min(y) / x.max(y).max(f64::MIN_POSITIVE);
    let t2 = t * t;
    // 4/pi arctan t; the error, below 0.001, is a hundredth of a sector.
    let eighths = t * (1.267_324 + t2 * (-0.367_558 + t2 * 0.101_008));
    let quarter = if y > x { 2.0 - eighths } else { eighths };
    let half = if point.x < 0.0 { 4.0 - quarter } else { quarter };
    let turn = if point.y < 0.0 { 8.0 - half } else { half };
    ((turn * (ANGLES as f64 / 8.0)) as i32 as usize).min(ANGLES - 1)
}

/// Moves the corners out until the polygon holds the outline between them, and by the margin.
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
