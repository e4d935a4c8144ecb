//! The part of the stop that is filled from one field.

use glam::DVec2;

use crate::field::Field;

use super::beam::{LOST, RimlessLens};

/// Rays along one side of a window. More see smaller beams and measure their area better.
const SIDE: usize = 33;
/// A window is taken this many times as large as the beam.
const MARGIN: f64 = 1.4;
/// A window that the beam fills by less than this part is made smaller.
const TOO_LARGE: f64 = 0.4;
/// Windows tried until one fits.
const MOST_WINDOWS: u32 = 16;
/// Halvings between two rays of the grid.
const EDGE_HALVINGS: u32 = 6;

/// A rectangle of the plane of a field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FieldWindow {
    pub(crate) centre: DVec2,
    pub(crate) half: DVec2,
}

/// The beam that is seen through a window.
pub(crate) struct BeamSurvey {
    /// The window that fits the beam.
    pub(crate) window: FieldWindow,
    /// The area of the stop that is filled, in squares of its radius.
    pub(super) area: f64,
}

/// A ray that comes to the stop.
#[derive(Clone, Copy)]
struct StopRay {
    /// The point at which it crosses the plane of its field.
    at: DVec2,
    /// The point at which it hits the stop.
    stop: DVec2,
    /// Distance by which the ray goes outside of the worst rim, in its radii; not above 0: it passes.
    excess: f64,
}

impl StopRay {
    fn passes(&self) -> bool {
        self.excess <= 0.0
    }
}

impl FieldWindow {
    /// The window about these places, with a margin.
    pub(crate) fn about(places: impl Iterator<Item = DVec2>) -> Option<Self> {
        let corners = places.map(|place| (place, place)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        corners.map(|(low, high)| Self { centre: 0.5 * (low + high), half: 0.5 * MARGIN * (high - low) })
    }

    fn place(&self, i: usize) -> DVec2 {
        let unit = |step: usize| 2.0 * step as f64 / (SIDE - 1) as f64 - 1.0;
        self.centre + self.half * DVec2::new(unit(i % SIDE), unit(i / SIDE))
    }

    /// The beam of `field` near this window; `None` if there is none.
    ///
    /// If no ray of the grid passes, the neighbourhood of the best is looked at more closely.
    pub(crate) fn find(&self, probe: &RimlessLens, field: &Field) -> Option<BeamSurvey> {
        let mut window = *self;
        for _ in 0..MOST_WINDOWS {
            let grid = WindowRays::new(&window, probe, field);
            let spacing = window.half * (2.0 / (SIDE - 1) as f64);
            let Some(beam) = Self::about(grid.nodes.iter().flatten().filter(|node| node.passes()).map(|node| node.at))
            else {
                let best = grid.nodes.iter().flatten().min_by(|a, b| a.excess.total_cmp(&b.excess))?;
                window = Self { centre: best.at, half: spacing * 2.0 };
                continue;
            };
            // A beam of one row of rays has no extent.
            let beam = Self { half: beam.half + spacing, ..beam };
            let reach = (beam.centre - window.centre).abs() + beam.half / MARGIN;
            let fits = reach.cmple(window.half).all() && beam.half.cmpge(window.half * TOO_LARGE).all();
            if fits {
                return Some(BeamSurvey { window: beam, area: grid.area() });
            }
            window = beam;
        }
        None
    }
}

/// The rays of a window, row by row.
struct WindowRays<'a> {
    probe: &'a RimlessLens<'a>,
    field: &'a Field,
    nodes: Vec<Option<StopRay>>,
    window: FieldWindow,
}

impl<'a> WindowRays<'a> {
    fn new(window: &FieldWindow, probe: &'a RimlessLens, field: &'a Field) -> Self {
        let mut grid = Self { probe, field, nodes: Vec::new(), window: *window };
        grid.nodes = (0..SIDE * SIDE).map(|i| grid.node(window.place(i))).collect();
        grid
    }

    /// The ray through a place; `None` if it does not come to the stop.
    fn node(&self, at: DVec2) -> Option<StopRay> {
        let passage = self.probe.pass(self.field, at).ok()?;
        let excess = passage.stop.length().max(passage.reach).min(LOST) - 1.0;
        Some(StopRay { at, stop: passage.stop, excess })
    }

    /// The area of the stop where rays pass; between those of the grid as on flat triangles.
    fn area(&self) -> f64 {
        let mut sum = 0.0;
        for row in 0..SIDE - 1 {
            for column in 0..SIDE - 1 {
                let i = row * SIDE + column;
                sum += self.passing_area([i, i + 1, i + SIDE]);
                sum += self.passing_area([i + SIDE + 1, i + SIDE, i + 1]);
            }
        }
        sum
    }

    /// The area of the part of a triangle where rays pass.
    fn passing_area(&self, corners: [usize; 3]) -> f64 {
        let mut polygon: Vec<DVec2> = Vec::with_capacity(4);
        let passing = |i: usize| self.nodes[i].filter(StopRay::passes);
        for (i, a) in corners.into_iter().enumerate() {
            let b = corners[(i + 1) % 3];
            polygon.extend(passing(a).map(|node| node.stop));
            match (passing(a), passing(b)) {
                (Some(inside), None) => polygon.push(self.edge(inside, b)),
                (None, Some(inside)) => polygon.push(self.edge(inside, a)),
                _ => {}
            }
        }
        let next = polygon.iter().cycle().skip(1);
        0.5 * polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs()
    }

    /// The edge of the beam between a ray that passes and one that does not: as if the excess were linear, or, where
    /// rays do not come through at all, by halving.
    fn edge(&self, mut inside: StopRay, outside: usize) -> DVec2 {
        let is_through = |node: &StopRay| node.excess < LOST - 1.0;
        if let Some(outside) = self.nodes[outside].filter(is_through) {
            return inside.stop.lerp(outside.stop, inside.excess / (inside.excess - outside.excess));
        }
        let mut beyond = self.window.place(outside);
        for _ in 0..EDGE_HALVINGS {
            let middle = 0.5 * (inside.at + beyond);
            match self.node(middle).filter(StopRay::passes) {
                Some(node) => inside = node,
                None => beyond = middle,
            }
        }
        inside.stop
    }
}
