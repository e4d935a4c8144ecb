//! A map of the picture on itself: for each place, the one that looks in the same direction in another mapping.

use crate::camera::lens::steps::Steps;
use glam::{DVec3, Vec2};

/// Newton's steps; the first is nearly there.
const STEPS: usize = 5;
/// Step for slopes, as a part of the picture.
const STEP: f32 = 1e-3;
/// Angle within which a place is found.
const NEAR: f64 = 1e-9;
/// The map reaches beyond the picture's edges by the width of a pixel filter, at least.
const MARGIN: f32 = 0.02;

/// A map of places by an even grid of nodes; linear between them.
pub(super) struct Warp {
    nodes: usize,
    /// The displacement of each node's place; NaN where no place looks in the node's wanted direction.
    moved: Vec<Vec2>,
}

impl Warp {
    /// `wanted` gives the wanted directions of places, unit vectors; `made` their directions in the other mapping, which knows places up to
    /// `most` from the middle.
    pub(super) fn new(
        nodes: usize,
        most: f32,
        wanted: impl Fn(&[Vec2]) -> Vec<Option<DVec3>>,
        made: impl Fn(&[Vec2]) -> Vec<Option<DVec3>>,
    ) -> Self {
        let size = 1.0 + 2.0 * MARGIN;
        let place =
            |i: usize| Vec2::new((i % nodes) as f32, (i / nodes) as f32) * (size / (nodes - 1) as f32) - 0.5 * size;
        let starts: Vec<Vec2> = (0..nodes * nodes).map(place).collect();
        let targets = wanted(&starts);
        let mut places = starts.clone();
        let mut lost: Vec<bool> = targets.iter().map(Option::is_none).collect();
        for _ in 0..STEPS {
            let side = |by: Vec2| -> Vec<Vec2> { places.iter().map(|p| *p + by).collect() };
            let sights = [Vec2::ZERO, Vec2::new(STEP, 0.0), Vec2::new(0.0, STEP)].map(|by| made(&side(by)));
            let mut farthest: f64 = 0.0;
            for i in 0..places.len() {
                let (Some(target), false) = (targets[i], lost[i]) else { continue };
                let (Some(here), Some(across), Some(up)) = (sights[0][i], sights[1][i], sights[2][i]) else {
                    // Half the way back: what is to be seen lies nearer to the middle for most lenses.
                    let back = places[i] * 0.9;
                    lost[i] = back.length() < 0.1;
                    places[i] = back;
                    farthest = 1.0;
                    continue;
                };
                let off = target - here;
                let [across, up] = [across - here, up - here].map(|way| way / f64::from(STEP));
                let Some(step) = Steps::new(across, up).map(|steps| steps.place(off)) else {
                    lost[i] = true;
                    continue;
                };
                farthest = farthest.max(off.length());
                let next = places[i].as_dvec2() + step.clamp_length_max(0.5);
                places[i] = next.as_vec2().clamp(Vec2::splat(-most), Vec2::splat(most));
            }
            if farthest < NEAR {
                break;
            }
        }
        // What stands at the edge of what is known has not been found.
        let at_edge = |p: Vec2| p.abs().max_element() >= most;
        let moved = (0..places.len())
            .map(|i| if lost[i] || at_edge(places[i]) { Vec2::NAN } else { places[i] - starts[i] })
            .collect();
        Self { nodes, moved }
    }

    /// The place that looks in the wanted direction of `p`.
    pub(super) fn at(&self, p: Vec2) -> Option<Vec2> {
        let cells = (self.nodes - 1) as f32;
        let at = ((p + 0.5 + MARGIN) / (1.0 + 2.0 * MARGIN) * cells).clamp(Vec2::ZERO, Vec2::splat(cells));
        let cell = at.min(Vec2::splat(cells - 1.0)).floor();
        let inside = at - cell;
        let first = cell.y as usize * self.nodes + cell.x as usize;
        let row = |first: usize| self.moved[first].lerp(self.moved[first + 1], inside.x);
        let moved = row(first).lerp(row(first + self.nodes), inside.y);
        moved.is_finite().then(|| p + moved)
    }
}
