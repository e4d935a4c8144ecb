//! Bounds of how dense a medium is: cells over an object's box, found by trying points in each.

use super::StackedMedium;
use crate::accel::Ray;
use crate::nodes::volume::{Medium, within_box};
use crate::nodes::{OF_BOUNCES, PathState};
use crate::scene::{Instance, Scene};
use crate::surface::mesh_of;
use arrayvec::ArrayVec;
use glam::{Affine3A, Vec3, Vec3A};
use petzval_nodes::{Field, random_of};
use rayon::prelude::*;
use std::sync::Arc;

/// Cells along each side.
const SIDE: usize = 16;
/// Points tried in a cell, along each side.
const TRIED: usize = 3;
/// Points tried in a cell, along each side, by a program of more than [`LONG`] instructions: else bounds alone took half a minute.
const TRIED_IF_LONG: usize = 2;
/// Instructions of a program that is long.
const LONG: usize = 200;
/// Factor by which a medium may be denser than the samples found before weights turn negative.
const MARGIN: f32 = 1.25;
/// Least rate of a cell, as a part of the densest cell's: every place is sampled.
const LEAST: f32 = 0.01;
/// Least number of points over its box at which an emitting medium is sampled.
pub(super) const LOOKS: f32 = 8.0;
/// Part of [`LOOKS`] where no emission was found: emission that was missed would be found so rarely that its light were specks.
const LOOKS_IN_THE_DARK: f32 = 0.25;
/// The largest factor of the rate in the cells behind one whose bound was too low.
const MOST_RAISE: f32 = 16.0;
/// Tentative particles up to the end of a cell whose rate was raised, at most on average.
const MOST_IN_CELL: f32 = 512.0;
/// Points tried for all space.
const TRIED_IN_WORLD: u32 = 8192;

/// A bound of a medium's density, found before the render.
pub(super) enum Bound {
    /// The medium is constant along a ray.
    Even,
    /// Cells over a box.
    Cells {
        /// Render space to cells.
        to_cells: Affine3A,
        /// The rate of each, x runs fastest.
        rates: Arc<Vec<f32>>,
    },
    /// One rate for all space: that of the world's medium.
    Everywhere(f32),
}

impl Bound {
    /// The bound of an object's medium.
    pub(super) fn of_object(scene: &Scene, entry: StackedMedium) -> Self {
        let mesh = mesh_of(scene, entry.instance);
        let Some(volume) = entry.volume(scene) else { return Self::Even };
        let has = |name: &str| mesh.grids.iter().any(|grid| grid.name == name);
        if volume.is_even && !volume.grids().any(has) {
            return Self::Even;
        }
        let [low, high] = mesh.bounds;
        let size = (high - low).max(Vec3::splat(1e-12));
        let diagonal =
            (within_box(scene, entry.instance, [1.0; 3]) - within_box(scene, entry.instance, [0.0; 3])).length();
        let to_box = Affine3A::from_scale(SIDE as f32 / size) * Affine3A::from_translation(-low);
        let ways = ways(volume.program.reads());
        let tries = if volume.program.instructions() > LONG { TRIED_IF_LONG } else { TRIED };
        let if_it_shines = LOOKS / diagonal;
        let rate = |cell: usize| {
            let corner = [cell % SIDE, cell / SIDE % SIDE, cell / SIDE / SIDE];
            let tried = (0..tries.pow(3)).map(|point| {
                let within = [point % tries, point / tries % tries, point / tries / tries];
                let part = std::array::from_fn(|axis| {
                    let jitter = random_of((cell * 97 + point * 3 + axis) as u32);
                    (corner[axis] as f32 + (within[axis] as f32 + jitter) / tries as f32) / SIDE as f32
                });
                let position = within_box(scene, entry.instance, part);
                tried_at(&ways, |way| entry.medium(scene, position, Vec3A::Z, way), if_it_shines)
            });
            tried.fold((0.0, false), either)
        };
        let found: Vec<(f32, bool)> = (0..SIDE.pow(3)).into_par_iter().map(rate).collect();
        let (densest, shines) = found.iter().copied().fold((0.0, false), either);
        let in_the_dark = if shines && if_it_shines.is_finite() { LOOKS_IN_THE_DARK * if_it_shines } else { 0.0 };
        let least = MARGIN * in_the_dark.max(LEAST * densest);
        let mut rates: Vec<f32> = found.into_iter().map(|(rate, _)| MARGIN * rate).collect();
        rates.iter_mut().for_each(|rate| *rate = rate.max(least));
        Self::Cells { to_cells: to_box * scene.instances[entry.instance as usize].to_object, rates: Arc::new(rates) }
    }

    /// This bound for the instance at another place.
    pub(super) fn standing(&self, from: &Instance, to: &Instance) -> Self {
        match self {
            Self::Even => Self::Even,
            Self::Everywhere(rate) => Self::Everywhere(*rate),
            Self::Cells { to_cells, rates } => {
                Self::Cells { to_cells: *to_cells * from.to_render * to.to_object, rates: rates.clone() }
            }
        }
    }

    /// The bound of the world's medium, in a scene that fills these bounds.
    pub(super) fn of_world(scene: &Scene, around: Option<(Vec3A, Vec3A)>) -> Self {
        let entry = StackedMedium::WORLD;
        let Some(volume) = entry.volume(scene) else { return Self::Even };
        if volume.is_even {
            return Self::Even;
        }
        let (low, high) = around.unwrap_or((Vec3A::splat(-1.0), Vec3A::ONE));
        // The camera stands at render space's origin.
        let (low, high) = (low.min(Vec3A::ZERO), high.max(Vec3A::ZERO));
        let diagonal = (high - low).length().max(1e-6);
        let ways = ways(volume.program.reads());
        let tried = (0..TRIED_IN_WORLD).into_par_iter().map(|point| {
            let part = |axis: u32| 1.5 * random_of(3 * point + axis) - 0.25;
            let position = low + (high - low) * Vec3A::new(part(0), part(1), part(2));
            tried_at(&ways, |way| entry.medium(scene, position, Vec3A::Z, way), LOOKS / diagonal)
        });
        Self::Everywhere(tried.reduce(|| (0.0, false), either).0 * MARGIN)
    }

    #[cfg(test)]
    pub(super) fn loosen(&mut self, part: f32) {
        if let Self::Cells { rates, .. } = self {
            Arc::make_mut(rates).iter_mut().for_each(|rate| *rate *= part);
        }
    }

    pub(super) fn is_even(&self) -> bool {
        matches!(self, Self::Even)
    }
}

/// The kinds of path that a medium may tell apart.
fn ways(reads: impl Iterator<Item = Field>) -> Vec<PathState> {
    let is_of_path =
        |field: Field| OF_BOUNCES.contains(&field) || matches!(field, Field::IsCameraRay | Field::IsShadowRay);
    let mut reads = reads;
    if reads.any(is_of_path) {
        vec![PathState::CAMERA, PathState::BOUNCE, PathState::CAMERA.shadow()]
    } else {
        vec![PathState::CAMERA]
    }
}

/// The rate that a place needs, and true if the medium emits there.
fn tried_at(ways: &[PathState], medium: impl Fn(PathState) -> Medium, if_it_shines: f32) -> (f32, bool) {
    let of = |way: &PathState| {
        let found = medium(*way);
        let shines = found.emission.max_element() > 0.0;
        let rate = if shines && if_it_shines.is_finite() { if_it_shines } else { 0.0 };
        (found.extinction.max_element().max(rate), shines)
    };
    ways.iter().map(of).fold((0.0, false), either)
}

/// The larger rate of two places, and true if the medium emits at one of them.
fn either(a: (f32, bool), b: (f32, bool)) -> (f32, bool) {
    (a.0.max(b.0), a.1 || b.1)
}

/// A ray through the cells of a bound.
struct ThroughCells<'a> {
    /// Origin of the ray, in cells.
    origin: Vec3A,
    direction: Vec3A,
    rates: &'a [f32],
}

impl ThroughCells<'_> {
    /// The rate at a distance, and up to which distance it holds.
    fn at(&self, distance: f32) -> (f32, f32) {
        let at = (self.origin + self.direction * distance).to_array();
        let direction = self.direction.to_array();
        let mut end = f32::INFINITY;
        let mut cell = [0usize; 3];
        for axis in 0..3 {
            let here = at[axis].floor().clamp(0.0, (SIDE - 1) as f32);
            cell[axis] = here as usize;
            let side = if direction[axis] > 0.0 { here + 1.0 } else { here };
            let away = (side - at[axis]) / direction[axis];
            // Outside of the box the nearest cell goes on for ever.
            let leaves = if direction[axis] > 0.0 { cell[axis] + 1 < SIDE } else { cell[axis] > 0 };
            if direction[axis] != 0.0 && leaves && away < end {
                end = away.max(0.0);
            }
        }
        let rate = self.rates[(cell[2] * SIDE + cell[1]) * SIDE + cell[0]];
        // A little into the next cell, lest rounding keep it in this one.
        let step = 1e-4 / self.direction.abs().max_element().max(1e-20);
        (rate, distance + end + step)
    }
}

/// Tentative particles along a ray.
pub(super) struct Bounded<'a> {
    cells: ArrayVec<ThroughCells<'a>, 8>,
    /// The rate of the media without cells.
    rate: f32,
    at: f32,
    t_max: f32,
    /// The end of the cell of the last particle.
    cell_end: f32,
    /// The least rate up to a distance, where a place was found to be denser than its bound.
    dense: (f32, f32),
    /// The factor of the bounds behind such a place; 1 before.
    raised: f32,
}

impl<'a> Bounded<'a> {
    /// Tentative particles along a ray through media of these bounds, with the rates of those that are constant.
    pub(super) fn new(ray: &Ray, bounds: impl Iterator<Item = (&'a Bound, f32)>) -> Self {
        let mut walk = Self {
            cells: ArrayVec::new(),
            rate: 0.0,
            at: 0.0,
            t_max: ray.t_max,
            cell_end: 0.0,
            dense: (0.0, 0.0),
            raised: 1.0,
        };
        for (bound, even) in bounds {
            match bound {
                Bound::Even => walk.rate += even,
                Bound::Everywhere(rate) => walk.rate += rate,
                Bound::Cells { to_cells, rates } => {
                    let origin = to_cells.transform_point3a(ray.origin);
                    let direction = to_cells.transform_vector3a(ray.direction);
                    let _ = walk.cells.try_push(ThroughCells { origin, direction, rates });
                }
            }
        }
        walk
    }

    /// Raises the rate of the rest of the ray after a particle at which the medium was so much denser than the rate there.
    ///
    /// A rate may depend on all that lies before it on the ray: the mean stays right. Without this each further particle in a dense
    /// place multiplies the weight by how often the bound is exceeded, and the weight grows beyond all numbers.
    pub(super) fn raise(&mut self, density: f32, rate: f32) {
        let length = (self.cell_end.min(self.t_max) - self.at).max(f32::MIN_POSITIVE);
        self.dense = ((MARGIN * density).min(MOST_IN_CELL / length).max(rate), self.cell_end);
        self.raised = (self.raised * density / rate).min(MOST_RAISE);
    }

    /// The distance of the next tentative particle, and the rate there; `None` beyond the ray's end.
    pub(super) fn next(&mut self, u: f32) -> Option<(f32, f32)> {
        let mut depth = -(1.0 - u).ln();
        while self.at < self.t_max {
            let (mut rate, mut end) = (self.rate, f32::INFINITY);
            for cells in &self.cells {
                let (own, until) = cells.at(self.at);
                rate += own;
                end = end.min(until);
            }
            rate *= self.raised;
            if self.at < self.dense.1 {
                rate = rate.max(self.dense.0);
                end = end.min(self.dense.1);
            }
            let end = end.min(self.t_max).max(self.at.next_up());
            self.cell_end = end;
            let distance = self.at + depth / rate;
            if rate > 0.0 && distance < end {
                self.at = distance;
                return Some((distance, rate));
            }
            if !end.is_finite() {
                return None;
            }
            depth -= rate * (end - self.at);
            depth = depth.max(0.0);
            self.at = end;
        }
        None
    }
}
