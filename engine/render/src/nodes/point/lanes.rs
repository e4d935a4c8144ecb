//! Up to eight points of one material, for programs over lanes.

use super::{Point, tangent};
use arrayvec::ArrayVec;
use glam::{Mat3A, Vec2, Vec3A, Vec4};
use petzval_nodes::{AttributeKind, Context, Direction, Field, LANES, Places, Shift, Space, Vector, Vectors};
use std::cell::Cell;
use wide::f32x8;

/// Up to eight points that are shaded at once. Their programs and attributes are the same.
pub(in crate::nodes) struct PointLanes<'a> {
    points: ArrayVec<Point<'a>, LANES>,
    /// The meshes' own normals, once something has asked for them.
    mesh_normals: Cell<Option<Vectors>>,
    /// True if all points lie on the same object.
    is_one_object: bool,
}

impl<'a> PointLanes<'a> {
    /// At least one point.
    pub(in crate::nodes) fn new(points: ArrayVec<Point<'a>, LANES>) -> Self {
        let is_one_object = points.iter().all(|point| std::ptr::eq(point.instance, points[0].instance));
        Self { points, mesh_normals: Cell::new(None), is_one_object }
    }

    /// These points with the place at which programs are evaluated shifted.
    pub(in crate::nodes) fn set_beside(&mut self, x: f32, y: f32) {
        self.points.iter_mut().for_each(|point| point.beside = Shift { x, y });
        self.mesh_normals.set(None);
    }

    /// Each point by itself.
    pub(in crate::nodes) fn points(&self) -> &[Point<'a>] {
        &self.points
    }

    /// The query of each point, in its lane.
    fn each(&self, of: impl Fn(&Point<'a>) -> Vec3A) -> Vectors {
        let mut all = Vectors::ZERO;
        self.points.iter().enumerate().for_each(|(lane, point)| all.put(lane, of(point)));
        all
    }

    fn mesh_normals(&self) -> Vectors {
        let normals = self.mesh_normals.get().unwrap_or_else(|| self.each(|point| point.mesh_normal(Shift::NONE)));
        self.mesh_normals.set(Some(normals));
        normals
    }

    /// A matrix of each point's object, column by column.
    fn matrices(&self, of: impl Fn(&Point<'a>) -> Mat3A) -> [Vectors; 3] {
        let columns = |point: &Point<'a>| {
            let matrix = of(point);
            [matrix.x_axis, matrix.y_axis, matrix.z_axis]
        };
        if self.is_one_object {
            return columns(&self.points[0]).map(Vectors::all);
        }
        let mut all = [Vectors::ZERO; 3];
        for (lane, point) in self.points.iter().enumerate() {
            all.iter_mut().zip(columns(point)).for_each(|(all, column)| all.put(lane, column));
        }
        all
    }

    /// The points, each with the UV map of a name: it is looked up again where the mesh is another.
    fn maps(&self, name: &str) -> impl Iterator<Item = (&Point<'a>, Option<usize>)> {
        let mut known = None;
        self.points.iter().map(move |point| {
            let map = match known {
                Some((mesh, map)) if std::ptr::eq(mesh, point.mesh) => map,
                _ => Point::map_named(point.mesh, name),
            };
            known = Some((point.mesh, map));
            (point, map)
        })
    }

    /// The tangents along a UV map by its name; `None` where they are not all those of triangles.
    fn tangents(&self, name: &str) -> Option<(Vectors, f32x8)> {
        if self.points.iter().any(|point| !point.mesh.is_of_triangles()) {
            return None;
        }
        let mut corners = [Vectors::ZERO; 3];
        let mut uv = [[[0.0; LANES]; 2]; 3];
        let mut has_none = [false; LANES];
        for (lane, (point, map)) in self.maps(name).enumerate() {
            has_none[lane] = map.is_none() && !name.is_empty();
            let (places, mapped): ([Vec3A; 3], [Vec2; 3]) = point.mapped_corners(map);
            for corner in 0..3 {
                corners[corner].put(lane, places[corner]);
                [uv[corner][0][lane], uv[corner][1][lane]] = mapped[corner].to_array();
            }
        }
        let (mut tangents, mut sides) =
            tangent::along_map(corners, uv.map(|uv| uv.map(f32x8::from)), self.mesh_normals());
        if has_none.contains(&true) {
            let kept = f32x8::from(has_none.map(|has_none| if has_none { 0.0 } else { 1.0 }));
            (tangents, sides) = (tangents.times(kept), sides * kept);
        }
        Some((tangents, sides))
    }
}

impl<'a> Places for PointLanes<'a> {
    type Point = Point<'a>;

    #[inline]
    fn count(&self) -> usize {
        self.points.len()
    }
    #[inline]
    fn point(&self, lane: usize) -> &Point<'a> {
        &self.points[lane]
    }

    fn read(&self, field: Field, shift: Shift) -> Vectors {
        match field {
            Field::MeshNormal if shift == Shift::NONE => self.mesh_normals(),
            Field::Normal => self.each(|point| point.surface.shading_normal),
            _ => self.each(|point| point.read(field, shift)),
        }
    }

    fn attribute(&self, index: usize, shift: Shift) -> (Vectors, f32x8) {
        let asked = &self.points[0].attributes[index];
        if asked.kind == AttributeKind::Tangent
            && let Some(found) = self.tangents(&asked.name)
        {
            return found;
        }
        if asked.kind == AttributeKind::Uv && self.points.iter().all(|point| point.mesh.is_of_triangles()) {
            let mut all = Vectors::ZERO;
            let mut fourth = [0.0; LANES];
            for (lane, (point, map)) in self.maps(&asked.name).enumerate() {
                let uv = map.map_or(Vec4::ZERO, |map| point.uv(map, shift));
                all.put(lane, Vec3A::from_vec4(uv));
                fourth[lane] = uv.w;
            }
            return (all, fourth.into());
        }
        let mut fourth = [0.0; LANES];
        let mut all = Vectors::ZERO;
        for (lane, point) in self.points.iter().enumerate() {
            let value = point.attribute(index, shift);
            all.put(lane, Vec3A::from_vec4(value));
            fourth[lane] = value.w;
        }
        (all, fourth.into())
    }

    fn transform(&self, direction: Direction, from: Space, to: Space, vectors: Vectors) -> Vectors {
        let [x, y, z] = match (direction, from, to) {
            (Direction::Normal, Space::Object, Space::World) => self.matrices(|point| point.instance.normal_to_render),
            (Direction::Normal, Space::World, Space::Object) => {
                self.matrices(|point| point.instance.to_render.matrix3.transpose())
            }
            _ => {
                let mut all = Vectors::ZERO;
                for (lane, point) in self.points.iter().enumerate() {
                    all.put(lane, point.transform(direction, from, to, vectors.at(lane)));
                }
                return all;
            }
        };
        (x.times(vectors.x) + y.times(vectors.y) + z.times(vectors.z)).unit()
    }
}
