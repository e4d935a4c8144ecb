//! The inputs of a material at up to eight points at once.

use super::around::SceneQueries;
use super::images::Images;
use super::layers::{BUMP_FILTER, Layers, of_graph};
use super::point::{Point, PointLanes, View};
use crate::scene::graph::{Displacement, Graph};
use crate::scene::layer::Source;
use crate::scene::material::Material;
use crate::scene::plain::{Plain, PlainValues};
use crate::surface::SurfacePoint;
use arrayvec::ArrayVec;
use glam::Vec3A;
use petzval_nodes::{LANES, LaneRegisters};

/// The results of a material's program at up to eight points, each the same bits as [`super::layers`] and [`super::plain_values`] have.
#[derive(Default)]
pub struct LaneValues {
    registers: LaneRegisters,
    bent_normals: [Option<Vec3A>; LANES],
}

impl LaneValues {
    /// Evaluates a material at points, 1 to [`LANES`].
    pub fn run<'p>(
        &mut self,
        material: &Material,
        around: SceneQueries<'_>,
        points: impl Iterator<Item = (&'p SurfacePoint, &'p View)>,
    ) {
        let graph = &*material.graph;
        let (program, slice, bends) = (&graph.program, &graph.slices.scattering, graph.bends_normals());
        let has_footprint = bends || slice.needs_footprint();
        let mut points: ArrayVec<Point<'_>, LANES> = points
            .take(LANES)
            .map(|(point, view)| {
                Point::new(around, *point, *view, &program.attributes, graph.pass_index as f32, has_footprint)
            })
            .collect();
        let images = Images(&around.scene.textures);
        self.bent_normals = [None; LANES];
        if bends {
            self.bend(graph, &mut points, &images);
        }
        if !slice.is_empty() {
            program.run_lanes(slice, &PointLanes::new(points), &images, &mut self.registers);
        }
    }

    /// Bends the points' normals by the displacement.
    fn bend(&mut self, graph: &Graph, points: &mut ArrayVec<Point<'_>, LANES>, images: &Images<'_>) {
        let Graph { program, slices, .. } = graph;
        let Some(displacement) = program.displacement else { return };
        let mut axes = [[Vec3A::ZERO; 2]; LANES];
        let bases = points.iter().zip(&mut axes).map(|(point, axes)| {
            let before = if graph.displacement == Displacement::Both { point.undisplaced() } else { None };
            let (base, along) = before.unwrap_or((*point, point.footprint()));
            *axes = along;
            base
        });
        let mut bases = PointLanes::new(bases.collect());
        let mut heights = [[0.0; 3]; LANES];
        for (place, (x, y)) in [(0.0, 0.0), (BUMP_FILTER, 0.0), (0.0, BUMP_FILTER)].into_iter().enumerate() {
            bases.set_beside(x, y);
            program.run_lanes(&slices.displacement, &bases, images, &mut self.registers);
            for (lane, base) in bases.points().iter().enumerate() {
                heights[lane][place] = base.along_normal(program.value_at(displacement, &self.registers, lane));
            }
        }
        for (lane, point) in points.iter_mut().enumerate() {
            point.bend(bases.points()[lane].bent(heights[lane], axes[lane], BUMP_FILTER));
            self.bent_normals[lane] = point.bent_normal();
        }
    }

    /// The closures that scatter light at the point of a lane.
    pub fn layers(&self, material: &Material, lane: usize, to: &mut Layers) {
        let graph = &*material.graph;
        to.closures.clear();
        to.bent_normal = self.bent_normals[lane];
        of_graph(graph, &|source: Source| source.value_at(&graph.program, &self.registers, lane), to);
    }

    /// The inputs of a plain surface at the point of a lane; `plain`: that of the material's graph.
    pub fn plain(&self, material: &Material, plain: &Plain, lane: usize) -> PlainValues {
        plain.values(&|source| source.value_at(&material.graph.program, &self.registers, lane))
    }
}

#[cfg(test)]
mod tests;
