//! Instances: the placement of meshes, and the properties of each.

use super::mesh::Mesh;
use super::motion::Pose;
use super::shadow_terminator::ShadowTerminator;
use super::visibility::{LightLinking, Rays};
use glam::{Affine3A, DAffine3, DMat4, DVec3, Mat3A, Vec3, Vec4};

/// Axes whose squared lengths and products differ by less than this part are scaled alike.
const EVEN: f32 = 1e-4;

/// A mesh placed in the scene.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Name of the Blender object that the instance comes from.
    pub object_name: String,
    /// Name of the object's topmost parent.
    pub asset_name: String,
    /// Index of the mesh in [`Scene::meshes`].
    pub mesh: u32,
    /// Object space to render space.
    pub to_render: Affine3A,
    /// Render space to object space.
    pub to_object: Affine3A,
    /// Object-space normals to render space (inverse transpose), unnormalised.
    pub normal_to_render: Mat3A,
    /// True if the instance is the only user of its mesh, and its matrix does not scale all directions alike: normals are made unit in
    /// render space before they are interpolated, as by Cycles, which puts such a mesh into the world before it renders.
    pub is_stretched: bool,
    /// True if the matrix mirrors: front and back are exchanged.
    pub mirrored: bool,
    /// Material of each slot; never empty.
    pub materials: Vec<u32>,
    /// The kinds of ray that see it.
    pub visible: Rays,
    /// The instance's part in light linking.
    pub links: LightLinking,
    /// The number of the light group of its emission; 0 is none.
    pub light_group: u16,
    /// Softening of the shadow terminator on its smooth faces.
    pub shadow_terminator: ShadowTerminator,
    /// Length of the ambient occlusion rays that end a path and start on the instance; 0: that of all others.
    pub occlusion_distance: f32,
    /// Object space to render space a frame before and a frame after; `None` where it stands still.
    pub moved: Option<Box<[DAffine3; 2]>>,
    /// Properties of the object that shader graphs may read.
    pub info: ObjectInfo,
    /// The shape of its mesh at its moment, where the mesh has several.
    pub pose: Pose,
    /// True if the instance stands for an object in the photograph that the picture is laid over: only its shadows are wanted.
    pub is_catcher: bool,
    /// True if the instance's surface is the one that a bake shows.
    pub is_baked: bool,
}

/// The values of Blender's Object Info node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectInfo {
    /// Colour in the viewport; with alpha.
    pub color: Vec4,
    /// Pass index of the object.
    pub pass_index: i32,
    /// 0 to 1, another for each object and instance.
    pub random: f32,
}

impl Default for ObjectInfo {
    fn default() -> Self {
        Self { color: Vec4::ONE, pass_index: 0, random: 0.0 }
    }
}

impl Instance {
    /// Length of a ray from the instance that ends a path with ambient occlusion, if those of other instances have this length.
    #[inline]
    pub fn last_ray_distance(&self, of_others: f32) -> f32 {
        if self.occlusion_distance == 0.0 { of_others } else { self.occlusion_distance }
    }

    /// Puts the instance elsewhere: `to_world` takes object space to world space, `origin` is render space's.
    pub(super) fn stand(&mut self, to_world: &DAffine3, origin: DVec3) {
        let moved = DAffine3::from_translation(-origin) * *to_world;
        let single = |map: DAffine3| Affine3A::from_mat4(DMat4::from(map).as_mat4());
        let linear = to_world.matrix3;
        // Scaled by the determinant's size, so that single precision neither overflows nor vanishes.
        let normal = linear.inverse().transpose() * linear.determinant().abs().cbrt();
        self.to_render = single(moved);
        self.to_object = single(moved.inverse());
        self.normal_to_render = Mat3A::from(normal.as_mat3());
        self.mirrored = linear.determinant() < 0.0;
    }

    /// True if the instance's matrix scales directions differently, so that angles change.
    pub(super) fn changes_angles(&self) -> bool {
        let Mat3A { x_axis: x, y_axis: y, z_axis: z } = self.to_render.matrix3;
        let most = x.length_squared().max(y.length_squared()).max(z.length_squared());
        let off = [x.dot(y), y.dot(z), z.dot(x)].into_iter().chain([x, y, z].map(|axis| most - axis.length_squared()));
        off.fold(0.0, |worst: f32, one| worst.max(one.abs())) > EVEN * most
    }

    /// A triangle's corners, object space.
    #[inline]
    pub fn corners(&self, mesh: &Mesh, triangle: u32) -> [Vec3; 3] {
        match &mesh.poses {
            None => mesh.corners(triangle),
            Some(poses) => poses.corners(mesh.triangles[triangle as usize], self.pose),
        }
    }

    /// The normals at a triangle's corners, object space; `None` of a mesh that has none.
    #[inline]
    pub fn corner_normals(&self, mesh: &Mesh, triangle: u32) -> Option<[Vec3; 3]> {
        let posed = mesh.poses.as_ref().and_then(|poses| poses.normals(mesh.numbers(), triangle, self.pose));
        posed.or_else(|| mesh.normals(triangle))
    }

    /// The material of a mesh's slot; slots past the end take the last, as Blender does.
    #[inline]
    pub fn material(&self, slot: u32) -> u32 {
        self.materials[(slot as usize).min(self.materials.len() - 1)]
    }
}
