//! A point of a surface as a shader graph's program asks for it.

mod lanes;
mod tangent;

use super::around::SceneQueries;
use super::ball::{self, Ball};
use super::path_state::PathState;
use super::ray_cone::RayCone;
use super::strand::{self, Hair};
use crate::accel::Ray;
use crate::scene::corners::Corners;
use crate::scene::mesh::{GENERATED, Mesh};
use crate::scene::{Instance, Scene};
use crate::surface::{SurfacePoint, mesh_of};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A, Vec4};
use petzval_nodes::{
    Attribute, AttributeKind, Context, Direction, Field, Found, Occlusion, Raycast, Shift, Space, answers,
};

pub(super) use lanes::PointLanes;

/// The names by which a mesh keeps the attributes of its vertices that come from edges.
const POINTINESS: &str = ".pointiness";
const RANDOM_PER_ISLAND: &str = ".random_per_island";

/// The names by which a mesh whose vertices were moved keeps the normals and positions that it had.
pub(super) const UNDISPLACED_NORMAL: &str = ".undisplaced_normal";
pub(super) const UNDISPLACED_POSITION: &str = ".undisplaced_position";

/// The view of a point along a ray.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The direction of the ray that came to the point, unit.
    pub direction: Vec3A,
    /// Length of the ray, Blender units.
    pub distance: f32,
    /// The path state before the point.
    pub way: PathState,
    /// The moment, as in [`Ray::moment`].
    pub moment: u16,
    /// True if the path was scattered so widely before that edges look alike sharp and bevelled.
    pub is_blurry: bool,
    /// The cone about the ray.
    pub cone: RayCone,
}

impl View {
    /// Least probability density of a path's scattered directions, per steradian, at which the Bevel node still works: that of Cycles
    /// (`svm_bevel` in bevel.h).
    const SHARP: f32 = 8.0;

    /// The view along a ray, with a cone about it, of a hit at this distance. Where the densities of the path's directions are not known, a
    /// diffuse reflection makes it blurry.
    pub fn along(ray: &Ray, cone: RayCone, distance: f32, way: PathState) -> Self {
        Self { direction: ray.direction, distance, way, moment: ray.moment, is_blurry: way.diffuse > 0, cone }
    }

    /// This view of a path whose directions were chosen with at least this probability density, per steradian.
    #[must_use]
    pub fn with_least_pdf(self, least_pdf: f32) -> Self {
        Self { is_blurry: least_pdf < Self::SHARP, ..self }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Point<'a> {
    around: SceneQueries<'a>,
    scene: &'a Scene,
    instance: &'a Instance,
    mesh: &'a Mesh,
    attributes: &'a [Attribute],
    material_index: f32,
    view: View,
    surface: SurfacePoint,
    /// The axes of the footprint along the surface, render space.
    footprint: [Vec3A; 2],
    /// Derivatives of the weights of the second and third corner along the footprint's axes.
    along: [Vec2; 2],
    /// The shift of the place at which programs are evaluated.
    beside: Shift,
    is_bent: bool,
    /// True if the place is that of the mesh before its vertices were moved.
    is_undisplaced: bool,
}

impl<'a> Point<'a> {
    /// The point at a place of a surface that is seen in the view's direction. Without a footprint all places beside it are the point
    /// itself.
    pub(super) fn new(
        around: SceneQueries<'a>,
        surface: SurfacePoint,
        view: View,
        attributes: &'a [Attribute],
        material_index: f32,
        has_footprint: bool,
    ) -> Self {
        let scene = around.scene;
        let SurfacePoint { instance, triangle, .. } = surface;
        let mesh = mesh_of(scene, instance);
        let instance = &scene.instances[instance as usize];
        let (mut footprint, mut along) = ([Vec3A::ZERO; 2], [Vec2::ZERO; 2]);
        if has_footprint {
            let [x, y] = perpendicular(surface.geometric_normal);
            // Heights are asked that far apart for a bump; a cone without width sees none.
            let least = 1e-6 * view.cone.spread * surface.position.length();
            let size = view.cone.at(view.distance).max(least);
            footprint = [x * size, y * size];
            along = if !mesh.is_special {
                weights_along(instance, mesh.corners(triangle), &footprint)
            } else if let Some(curves) = &mesh.curves {
                strand::weights_along(instance, curves, &surface, &footprint)
            } else if mesh.points.is_some() {
                [Vec2::ZERO; 2]
            } else {
                weights_along(instance, instance.corners(mesh, triangle), &footprint)
            };
        }
        Self {
            around,
            scene,
            instance,
            mesh,
            attributes,
            material_index,
            view,
            surface,
            footprint,
            along,
            beside: Shift::NONE,
            is_bent: false,
            is_undisplaced: false,
        }
    }

    /// This point with the place at which programs are evaluated shifted.
    pub(super) fn beside(&self, x: f32, y: f32) -> Self {
        Self { beside: Shift { x, y }, ..*self }
    }

    /// This point with another shading normal, unit, render space.
    pub(super) fn with_normal(mut self, normal: Vec3A) -> Self {
        self.surface.shading_normal = normal;
        self
    }

    /// This point on the mesh before its vertices were moved, with the normal on the viewer's side, and the footprint's axes along that surface;
    /// `None` where the mesh keeps none. Places beside the point are as far away as these axes are long on average, but along the surface as it
    /// is: so Cycles has it (`svm_node_enter_bump_eval` in bump.h).
    pub(super) fn undisplaced(&self) -> Option<(Self, [Vec3A; 2])> {
        let normals = self.mesh.attribute(UNDISPLACED_NORMAL)?;
        let normal = Vec3A::from_vec4(self.interpolated(normals, Shift::NONE));
        let normal = (self.instance.normal_to_render * normal).try_normalize()?;
        let positions = self.mesh.attribute(UNDISPLACED_POSITION)?;
        let [a, b, c] = positions
            .at(self.mesh.numbers(), self.surface.triangle)
            .map(|p| self.instance.to_render.transform_point3a(Vec3A::from_vec4(p)));
        let [wa, wb, wc] = self.barycentric(Shift::NONE);
        let mut before = *self;
        before.surface.position = a * wa + b * wb + c * wc;
        before.surface.shading_normal = if normal.dot(self.surface.geometric_normal) < 0.0 { -normal } else { normal };
        before.is_undisplaced = true;
        let axes = self.along.map(|along| (b - a) * along.x + (c - a) * along.y);
        let size = 0.5 * (axes[0].length() + axes[1].length());
        before.footprint = perpendicular(self.surface.geometric_normal).map(|axis| axis * size);
        Some((before, axes))
    }

    /// The height by which a vector of the world lifts the surface.
    pub(super) fn along_normal(&self, vector: Vec3A) -> f32 {
        vector.dot(self.surface.shading_normal)
    }

    /// The axes of the footprint along the surface, render space.
    pub(super) fn footprint(&self) -> [Vec3A; 2] {
        self.footprint
    }

    /// The shading normal, bent as if the surface had these heights here and beside, along this part of the axes.
    pub(super) fn bent(&self, [here, in_x, in_y]: [f32; 3], [x, y]: [Vec3A; 2], part: f32) -> Vec3A {
        let n = self.surface.shading_normal;
        let (across_y, across_x) = (y.cross(n), n.cross(x));
        let determinant = x.dot(across_y);
        let slope = across_y * (in_x - here) + across_x * (in_y - here);
        let bent = n * (part * determinant.abs()) - slope * determinant.signum();
        bent.try_normalize().unwrap_or(n)
    }

    /// Sets the shading normal to one that is bent, unit.
    pub(super) fn bend(&mut self, normal: Vec3A) {
        self.surface.shading_normal = normal;
        self.is_bent = true;
    }

    /// The shading normal where it is bent.
    pub(super) fn bent_normal(&self) -> Option<Vec3A> {
        self.is_bent.then_some(self.surface.shading_normal)
    }

    fn shifted(&self, shift: Shift) -> Shift {
        Shift { x: shift.x + self.beside.x, y: shift.y + self.beside.y }
    }

    fn barycentric(&self, shift: Shift) -> [f32; 3] {
        let shift = self.shifted(shift);
        let [u, v] = self.surface.barycentric;
        let at = Vec2::new(u, v) + self.along[0] * shift.x + self.along[1] * shift.y;
        [1.0 - at.x - at.y, at.x, at.y]
    }

    fn interpolated<T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(
        &self,
        corners: &Corners<T>,
        shift: Shift,
    ) -> T {
        let [a, b, c] = corners.at(self.mesh.numbers(), self.surface.triangle);
        let [wa, wb, wc] = self.barycentric(shift);
        a * wa + b * wb + c * wc
    }

    /// Render space to Blender's world.
    fn world(&self, position: Vec3A) -> Vec3A {
        position + self.scene.origin.as_vec3a()
    }

    fn position(&self, shift: Shift) -> Vec3A {
        self.world(self.in_render(shift))
    }

    fn in_render(&self, shift: Shift) -> Vec3A {
        let shift = self.shifted(shift);
        self.surface.position + self.footprint[0] * shift.x + self.footprint[1] * shift.y
    }

    fn in_camera(&self, shift: Shift) -> Vec3A {
        self.scene.viewport.from_render.transform_point3a(self.in_render(shift))
    }

    /// Distance to the nearest of the lines along the triangle's sides.
    fn edge_distance(&self, shift: Shift) -> f32 {
        if !self.mesh.is_of_triangles() {
            return f32::INFINITY;
        }
        let at = self.in_render(shift);
        let to_render = |p: Vec3| self.instance.to_render.transform_point3a(p.into());
        let [a, b, c] = self.instance.corners(self.mesh, self.surface.triangle).map(to_render);
        let away = |[from, to]: [Vec3A; 2]| {
            let along = to - from;
            (along.cross(at - from).length_squared() / along.length_squared().max(f32::MIN_POSITIVE)).sqrt()
        };
        [[a, b], [b, c], [c, a]].map(away).into_iter().fold(f32::INFINITY, f32::min)
    }

    /// The pixel's width across the line of sight: the mean over both axes of the footprint, as they are seen along the ray: as Cycles has
    /// it.
    fn pixel_width(&self) -> f32 {
        let seen = self.footprint.map(|axis| axis.reject_from_normalized(self.view.direction).length());
        0.5 * (seen[0] + seen[1])
    }

    fn object_position(&self, shift: Shift) -> Vec3A {
        if !self.mesh.is_of_triangles() || self.is_undisplaced {
            return self.instance.to_object.transform_point3a(self.in_render(shift));
        }
        let [a, b, c] = self.instance.corners(self.mesh, self.surface.triangle);
        let [wa, wb, wc] = self.barycentric(shift);
        Vec3A::from(a * wa + b * wb + c * wc)
    }

    fn mesh_normal(&self, shift: Shift) -> Vec3A {
        if !self.mesh.is_of_triangles() {
            return (self.instance.to_render.matrix3.transpose() * self.surface.shading_normal).normalize_or_zero();
        }
        if self.mesh.poses.is_some()
            && let Some([a, b, c]) = self.instance.corner_normals(self.mesh, self.surface.triangle)
        {
            let [wa, wb, wc] = self.barycentric(shift);
            return (a * wa + b * wb + c * wc).into();
        }
        match &self.mesh.corner_normals {
            Some(normals) => self.interpolated(normals, shift).into(),
            None => {
                let [a, b, c] = self.instance.corners(self.mesh, self.surface.triangle);
                (b - a).cross(c - a).normalize_or_zero().into()
            }
        }
    }

    fn parametric(&self, shift: Shift) -> Vec3A {
        if self.mesh.points.is_some() {
            return Vec3A::X;
        }
        let [_, u, v] = self.barycentric(shift);
        Vec3A::new(u, v, 0.0)
    }

    fn pointiness(&self, shift: Shift) -> f32 {
        if self.mesh.points.is_some() {
            return 0.0;
        }
        self.named(POINTINESS, shift).map_or(0.5, |value| value.x)
    }

    /// The mirrored direction to the viewer.
    fn reflection(&self) -> Vec3A {
        let (n, i) = (self.surface.shading_normal, -self.view.direction);
        n * (2.0 * n.dot(i)) - i
    }

    fn hair(&self, shift: Shift) -> Hair<'_> {
        let Self { mesh, instance, surface, view, .. } = self;
        let (curves, u) = (mesh.curves.as_deref(), self.barycentric(shift)[1]);
        Hair { curves, instance, surface, u, direction: view.direction }
    }

    fn ball(&self) -> Ball<'_> {
        let (points, number) = (self.mesh.points.as_deref(), self.surface.triangle);
        Ball { points, instance: self.instance, number, scene: self.scene }
    }

    fn named(&self, name: &str, shift: Shift) -> Option<Vec4> {
        if let Some(curves) = &self.mesh.curves {
            return strand::named(curves, name, self.surface.triangle, self.barycentric(shift)[1]);
        }
        if let Some(points) = &self.mesh.points {
            return points.attribute(name, self.surface.triangle);
        }
        if let Some(values) = self.mesh.attribute(name) {
            return Some(self.interpolated(values, shift));
        }
        self.mesh.uv_map(Some(name)).map(|map| self.uv(map, shift))
    }

    fn uv(&self, map: usize, shift: Shift) -> Vec4 {
        let uv: Vec2 = self.interpolated(&self.mesh.uv_maps[map].1, shift);
        Vec4::new(uv.x, uv.y, 0.0, 1.0)
    }

    /// The tangent: the direction in which u of a UV map grows, object space, at right angles to the mesh's normal; the fourth part is the
    /// side on which v grows. A mesh without a map is mapped as a sphere, as in Cycles.
    fn tangent(&self, map: Option<usize>) -> Vec4 {
        let (corners, uv) = self.mapped_corners(map);
        let (tangent, side) = tangent::along_map(corners, uv.map(|uv| uv.to_array()), self.mesh_normal(Shift::NONE));
        Vec3::from(tangent).extend(side)
    }

    /// The triangle's corners, object space, and their places on a UV map.
    fn mapped_corners(&self, map: Option<usize>) -> ([Vec3A; 3], [Vec2; 3]) {
        let corners = self.instance.corners(self.mesh, self.surface.triangle);
        let uv = match map {
            Some(map) => self.mesh.uv_maps[map].1.at(self.mesh.numbers(), self.surface.triangle),
            None => corners.map(tangent::around_the_origin),
        };
        (corners.map(Vec3A::from), uv)
    }

    /// The UV map that an attribute's name asks for; the first where it has no name.
    fn map_named(mesh: &Mesh, name: &str) -> Option<usize> {
        mesh.uv_map((!name.is_empty()).then_some(name))
    }

    fn generated(&self, shift: Shift) -> Vec3A {
        if let Some(values) = self.mesh.attribute(GENERATED) {
            return Vec3A::from_vec4(self.interpolated(values, shift));
        }
        if let Some(value) =
            self.mesh.curves.as_ref().and_then(|curves| curves.attribute(GENERATED, self.surface.triangle, 0.0))
        {
            return Vec3A::from_vec4(value);
        }
        self.object_position(shift)
    }
}

impl Context for Point<'_> {
    fn open(&self, asked: Occlusion, normal: Vec3A, distance: f32) -> f32 {
        self.around.open(&self.surface, asked, normal, distance)
    }

    fn bevelled(&self, samples: u8, radius: f32) -> Vec3A {
        let normal = if self.view.is_blurry { None } else { self.around.bevelled(&self.surface, samples, radius) };
        normal.unwrap_or(self.surface.shading_normal)
    }

    fn raycast(&self, asked: Raycast, position: Vec3A, direction: Vec3A, length: f32, shift: Shift) -> Option<Found> {
        // A place that a bump looks from may lie below the surface.
        let [x, y] = self.footprint.map(Vec3A::length);
        let beside = (x * shift.x.abs()).max(y * shift.y.abs());
        let origin = position - self.scene.origin.as_vec3a();
        let (hit, steps) = self.around.nearest(&self.surface, origin, beside, direction, length, asked.only_local)?;
        let found = SurfacePoint::new(self.scene, &hit, direction.normalize());
        let attribute = asked.attribute.map_or(Vec4::ZERO, |index| {
            Self::new(self.around, found, self.view, self.attributes, 0.0, false).attribute(index.into(), Shift::NONE)
        });
        Some(Found {
            is_hit: true,
            is_self: hit.instance == self.surface.instance,
            distance: steps,
            position: position + direction * steps,
            normal: found.shading_normal,
            attribute,
        })
    }

    answers! {
        fn answer(&self, field: Field, shift: Shift) -> Vec3A {
            let number = Vec3A::splat;
            let info = &self.instance.info;
            match field {
                Position => self.position(shift),
                Normal => self.surface.shading_normal,
                TrueNormal => match &self.mesh.curves {
                    Some(curves) if curves.is_flat() => -self.view.direction,
                    _ => self.surface.geometric_normal,
                },
                MeshNormal => self.mesh_normal(shift),
                Incoming => -self.view.direction,
                Parametric => self.parametric(shift),
                Backfacing => number(f32::from(u8::from(self.surface.backfacing))),
                Pointiness => number(self.pointiness(shift)),
                RandomPerIsland => number(self.named(RANDOM_PER_ISLAND, Shift::NONE).map_or(0.0, |value| value.x)),
                EdgeDistance => number(self.edge_distance(shift)),
                PixelWidth => number(self.pixel_width()),
                Camera => self.in_camera(shift),
                Window => self.scene.viewport.window(self.in_camera(shift)),
                ViewVector => self.in_camera(shift).normalize_or_zero(),
                ViewDepth => number(self.in_camera(shift).z),
                ViewDistance => number(self.in_camera(shift).length()),
                Generated => self.generated(shift),
                Object => self.object_position(shift),
                Reflection => self.reflection(),
                FootprintX => self.footprint[0],
                FootprintY => self.footprint[1],
                ObjectLocation => self.world(self.instance.to_render.translation),
                ObjectColour => Vec3A::from_vec4(info.color),
                ObjectAlpha => number(info.color.w),
                ObjectIndex => number(info.pass_index as f32),
                ObjectRandom => number(info.random),
                MaterialIndex => number(self.material_index),
                RayLength => number(self.view.distance),
                _ => [PathState: self.view.way, Hair<'_>: self.hair(shift), Ball<'_>: self.ball()],
            }
        }
    }

    fn attribute(&self, index: usize, shift: Shift) -> Vec4 {
        let Attribute { kind, name } = &self.attributes[index];
        if let Some(curves) = &self.mesh.curves {
            return strand::attribute(curves, kind, name, self.surface.triangle, self.barycentric(shift)[1]);
        }
        if let Some(points) = &self.mesh.points {
            return ball::attribute(points, kind, name, self.surface.triangle);
        }
        match kind {
            AttributeKind::Uv => Self::map_named(self.mesh, name).map_or(Vec4::ZERO, |map| self.uv(map, shift)),
            AttributeKind::Tangent => match Self::map_named(self.mesh, name) {
                None if !name.is_empty() => Vec4::ZERO,
                map => self.tangent(map),
            },
            AttributeKind::Colour | AttributeKind::Geometry => self.named(name, shift).unwrap_or(Vec4::ZERO),
            AttributeKind::Object | AttributeKind::Instancer | AttributeKind::ViewLayer => Vec4::ZERO,
        }
    }

    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vec3A) -> Vec3A {
        // Of normals these two are by far the most frequent, and need no inverse.
        match (direction, from, to) {
            (Direction::Normal, Space::Object, Space::World) => {
                return (self.instance.normal_to_render * vector).normalize_or_zero();
            }
            (Direction::Normal, Space::World, Space::Object) => {
                return (self.instance.to_render.matrix3.transpose() * vector).normalize_or_zero();
            }
            _ => {}
        }
        let origin = self.scene.origin.as_vec3a();
        let viewport = &self.scene.viewport;
        let map = match (from, to) {
            (Space::Object, Space::World) => Affine3A {
                matrix3: self.instance.to_render.matrix3,
                translation: self.instance.to_render.translation + origin,
            },
            (Space::World, Space::Object) => self.instance.to_object * Affine3A::from_translation((-origin).into()),
            (Space::World, Space::Camera) => viewport.from_world,
            (Space::Camera, Space::World) => viewport.from_world.inverse(),
            (Space::Object, Space::Camera) => viewport.from_render * self.instance.to_render,
            (Space::Camera, Space::Object) => self.instance.to_object * viewport.from_render.inverse(),
            _ => Affine3A::IDENTITY,
        };
        match direction {
            Direction::Point => map.transform_point3a(vector),
            Direction::Vector => map.transform_vector3a(vector),
            Direction::Normal => (inverse_transposed(&map.matrix3) * vector).normalize_or_zero(),
        }
    }
}

fn inverse_transposed(m: &Mat3A) -> Mat3A {
    m.inverse().transpose()
}

/// Two unit vectors at right angles to a unit vector and to each other: those along which Cycles asks for heights.
fn perpendicular(n: Vec3A) -> [Vec3A; 2] {
    let first = Vec3A::new(n.z - n.y, n.x - n.z, n.y - n.x);
    let first = first.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
    [first, n.cross(first)]
}

/// The derivatives of a triangle's barycentric weights along two vectors of its plane, render space.
fn weights_along(instance: &Instance, corners: [Vec3; 3], vectors: &[Vec3A; 2]) -> [Vec2; 2] {
    let [a, b, c] = corners.map(|p| instance.to_render.transform_point3a(p.into()));
    let (e, f) = (b - a, c - a);
    let (ee, ef, ff) = (e.dot(e), e.dot(f), f.dot(f));
    let determinant = ee * ff - ef * ef;
    vectors.map(|v| {
        if determinant <= 0.0 {
            return Vec2::ZERO;
        }
        let (ve, vf) = (v.dot(e), v.dot(f));
        Vec2::new(ff * ve - ef * vf, ee * vf - ef * ve) / determinant
    })
}
