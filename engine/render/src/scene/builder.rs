//! A scene from its pieces, as they come.

use super::curves::{Curves, CurvesDescription};
use super::lamp::Lamp;
use super::material::Material;
use super::mesh::{Mesh, MeshDescription};
use super::motion::{Moving, Pose, Way};
use super::points::{Points, PointsDescription};
use super::softening::Softening;
use super::texture::Texture;
use super::viewport::{Viewport, ViewportDescription};
use super::visibility::{Links, Rays};
use super::world::World;
use super::{Instance, ObjectInfo, Scene, SceneError};
use crate::Rgb;
use glam::{Affine3A, DAffine3, DMat4, DVec3, Mat3A};

struct RawInstance {
    object_name: String,
    asset_name: Option<String>,
    moved: Option<[DMat4; 2]>,
    way: Option<Way>,
    info: ObjectInfo,
    mesh: usize,
    matrix: DMat4,
    materials: Vec<u32>,
    visible: Rays,
    links: Links,
    light_group: u16,
    softening: Softening,
    is_catcher: bool,
}

/// Collects a scene's pieces in any order in which each piece comes after those that it names.
#[derive(Default)]
pub struct SceneBuilder {
    meshes: Vec<Mesh>,
    instances: Vec<RawInstance>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    lamps: Vec<(Lamp, DMat4)>,
    world: World,
    viewport: ViewportDescription,
    warnings: Vec<String>,
}

impl SceneBuilder {
    /// An empty scene: nothing in a black world.
    pub fn new() -> Self {
        Self::default()
    }

    /// What was left out or repaired so far, a line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Adds an image; gives its index.
    pub fn add_texture(&mut self, texture: Texture) -> usize {
        self.textures.push(texture);
        self.textures.len() - 1
    }

    /// Notes what could not be done as described.
    pub fn warn(&mut self, what: String) {
        if !self.warnings.contains(&what) {
            self.warnings.push(what);
        }
    }

    /// Adds a material; gives its index. Values out of range are brought into range.
    ///
    /// # Errors
    /// [`SceneError::NoSuchPiece`] where it names an image that was not added.
    pub fn add_material(&mut self, mut material: Material) -> Result<usize, SceneError> {
        let missing = material.textures().find(|&t| t as usize >= self.textures.len());
        if let Some(index) = missing {
            return Err(SceneError::NoSuchPiece {
                object: material.name,
                kind: "image",
                index: index as usize,
                count: self.textures.len(),
            });
        }
        material.sanitise();
        self.materials.push(material);
        Ok(self.materials.len() - 1)
    }

    /// Adds a mesh; gives its index. Triangles with a corner that is not finite, or without area, are left out
    /// with a warning.
    ///
    /// # Errors
    /// [`SceneError::BadMesh`] where its arrays do not fit together.
    pub fn add_mesh(&mut self, description: MeshDescription) -> Result<usize, SceneError> {
        let (mesh, warning) = Mesh::new(description)?;
        self.warnings.extend(warning);
        self.meshes.push(mesh);
        Ok(self.meshes.len() - 1)
    }

    /// Adds curves, which are placed as meshes are; gives their index among these. Strands with a key that is not finite are left
    /// out with a warning.
    ///
    /// # Errors
    /// [`SceneError::BadCurves`] where their arrays do not fit together.
    pub fn add_curves(&mut self, description: CurvesDescription) -> Result<usize, SceneError> {
        let name = description.name.clone();
        let (curves, warning) = Curves::new(description)?;
        self.warnings.extend(warning);
        self.meshes.push(curves.into_mesh(name));
        Ok(self.meshes.len() - 1)
    }

    /// Adds a point cloud, as [`Self::add_curves`]. Points that are not finite are left out with a warning.
    ///
    /// # Errors
    /// [`SceneError::BadPoints`] where its arrays do not fit together.
    pub fn add_points(&mut self, description: PointsDescription) -> Result<usize, SceneError> {
        let name = description.name.clone();
        let (points, warning) = Points::new(description)?;
        self.warnings.extend(warning);
        self.meshes.push(points.into_mesh(name));
        Ok(self.meshes.len() - 1)
    }

    /// Places a mesh; gives the index of the instance. `matrix` takes object space to world space.
    ///
    /// # Errors
    /// [`SceneError::NoSuchPiece`], [`SceneError::BadMatrix`]. A matrix that flattens the object entirely (a
    /// scale of zero, which Blender allows) leaves the instance out with a warning.
    pub fn add_instance(
        &mut self,
        object_name: &str,
        mesh: usize,
        matrix: DMat4,
        materials: &[usize],
        visible_camera: bool,
        visible_shadow: bool,
    ) -> Result<Option<usize>, SceneError> {
        let missing = |kind, index, count| SceneError::NoSuchPiece { object: object_name.into(), kind, index, count };
        if mesh >= self.meshes.len() {
            return Err(missing("mesh", mesh, self.meshes.len()));
        }
        if let Some(&index) = materials.iter().find(|&&m| m >= self.materials.len()) {
            return Err(missing("material", index, self.materials.len()));
        }
        if !matrix.is_finite() {
            return Err(SceneError::BadMatrix { object: object_name.into() });
        }
        let flat = !matrix.inverse().is_finite() || matrix.determinant().abs() < 1e-30;
        if flat {
            self.warnings.push(format!("object '{object_name}': its scale is zero; left out"));
            return Ok(None);
        }
        self.instances.push(RawInstance {
            object_name: object_name.into(),
            asset_name: None,
            moved: None,
            way: None,
            info: ObjectInfo::default(),
            mesh,
            matrix,
            materials: materials.iter().map(|&m| m as u32 + 1).collect(),
            visible: Rays::ALL
                .without(if visible_camera { Rays::NONE } else { Rays::CAMERA })
                .without(if visible_shadow { Rays::NONE } else { Rays::SHADOW }),
            links: Links::default(),
            light_group: 0,
            softening: Softening::default(),
            is_catcher: false,
        });
        Ok(Some(self.instances.len() - 1))
    }

    /// Says whose part an instance is, other than its own.
    pub fn set_asset(&mut self, instance: usize, name: &str) {
        self.instances[instance].asset_name = Some(name.into());
    }

    /// Says what an instance shows itself to.
    pub fn set_visible(&mut self, instance: usize, to: Rays) {
        self.instances[instance].visible = to;
    }

    /// Says which lights light an instance, and in which it throws shadows.
    pub fn set_links(&mut self, instance: usize, links: Links) {
        self.instances[instance].links = links;
    }

    /// Says that the shadows on an instance alone are wanted.
    pub fn catch_shadows(&mut self, instance: usize) {
        self.instances[instance].is_catcher = true;
    }

    /// Lets the camera see a hole instead of an instance; all else sees it as it is.
    pub fn hold_out(&mut self, instance: usize) {
        let of_slots = std::mem::take(&mut self.instances[instance].materials);
        // Counted from 1; 0 is what an empty slot has.
        let slots = if of_slots.is_empty() { vec![0] } else { of_slots };
        self.instances[instance].materials = slots.into_iter().map(|slot| self.holding(slot)).collect();
    }

    /// A material of a slot, made to hold out.
    fn holding(&mut self, slot: u32) -> u32 {
        let grey = Material::default_grey();
        let own = slot.checked_sub(1).map_or(&grey, |index| &self.materials[index as usize]);
        let holding = Material { holds_out: true, speaks: true, ..own.clone() };
        let known = self.materials.iter().position(|other| *other == holding);
        let index = known.unwrap_or_else(|| {
            self.materials.push(holding);
            self.materials.len() - 1
        });
        index as u32 + 1
    }

    /// Says which light group what an instance emits is in; 0 is none.
    pub fn set_light_group(&mut self, instance: usize, group: u16) {
        self.instances[instance].light_group = group;
    }

    /// Says how an instance's smooth faces are helped at the edge of light.
    pub fn set_softening(&mut self, instance: usize, softening: Softening) {
        self.instances[instance].softening = softening;
    }

    /// Says what shader graphs may ask of an instance's object.
    pub fn set_info(&mut self, instance: usize, info: ObjectInfo) {
        self.instances[instance].info = info;
    }

    /// Says where an instance stands a frame before and a frame after, for the pass of motion.
    ///
    /// # Errors
    /// [`SceneError::BadMatrix`].
    pub fn set_moved(&mut self, instance: usize, matrices: [DMat4; 2]) -> Result<(), SceneError> {
        let raw = &mut self.instances[instance];
        if !matrices.iter().all(|m| m.is_finite()) {
            return Err(SceneError::BadMatrix { object: raw.object_name.clone() });
        }
        raw.moved = matrices.iter().any(|m| *m != raw.matrix).then_some(matrices);
        Ok(())
    }

    /// Says where an instance stands at keys that lie evenly over the time that the shutter is open, the middle one where it was
    /// added. One that cannot be taken between stands still, with a warning.
    pub fn set_keys(&mut self, instance: usize, matrices: &[DMat4]) {
        let raw = &mut self.instances[instance];
        if matrices.iter().all(|m| *m == raw.matrix) {
            return;
        }
        raw.way = Way::new(matrices);
        if raw.way.is_none() {
            let what = "its scale is zero or not finite while the shutter is open; it stands still";
            self.warnings.push(format!("object '{}': {what}", raw.object_name));
        }
    }

    /// Adds a lamp. `matrix` takes its axes to world space; it shines along its -z.
    ///
    /// # Errors
    /// [`SceneError::BadMatrix`].
    pub fn add_lamp(&mut self, lamp: Lamp, matrix: DMat4) -> Result<(), SceneError> {
        if !matrix.is_finite() {
            return Err(SceneError::BadMatrix { object: lamp.object_name });
        }
        if !lamp.color.is_finite() || lamp.color == Rgb::ZERO {
            return Ok(());
        }
        self.lamps.push((lamp, matrix));
        Ok(())
    }

    /// Says what Blender's own camera frames.
    ///
    /// # Errors
    /// [`SceneError::BadMatrix`].
    pub fn set_viewport(&mut self, object_name: &str, viewport: ViewportDescription) -> Result<(), SceneError> {
        if !viewport.matrix.is_finite() {
            return Err(SceneError::BadMatrix { object: object_name.into() });
        }
        self.viewport = viewport;
        Ok(())
    }

    /// Sets the world.
    ///
    /// # Errors
    /// [`SceneError::NoSuchPiece`] where it names an image that was not added.
    pub fn set_world(&mut self, world: World) -> Result<(), SceneError> {
        if let Some(index) = world.texture.filter(|&t| t as usize >= self.textures.len()) {
            return Err(SceneError::NoSuchPiece {
                object: "world".into(),
                kind: "image",
                index: index as usize,
                count: self.textures.len(),
            });
        }
        self.world = world;
        Ok(())
    }

    /// The finished scene, with render space's origin at `origin` (world space; the camera's place).
    pub fn build(self, origin: DVec3) -> Scene {
        let place = |m: DMat4| -> Affine3A {
            let moved = DMat4::from_translation(-origin) * m;
            Affine3A::from_mat4(moved.as_mat4())
        };
        let mut materials = vec![Material::default_grey()];
        materials.extend(self.materials);
        let (mut dims, mut moving) = (false, Vec::new());
        let instances = self
            .instances
            .into_iter()
            .enumerate()
            .map(|(number, raw)| {
                // Strands and points are round: nothing coarse would show.
                let is_coarse = self.meshes[raw.mesh].is_of_triangles();
                let softening = if is_coarse { raw.softening } else { Softening::default() };
                dims |= softening.dims();
                let from_origin = |m: DMat4| DAffine3::from_mat4(DMat4::from_translation(-origin) * m);
                let mut instance = Instance {
                    asset_name: raw.asset_name.unwrap_or_else(|| raw.object_name.clone()),
                    object_name: raw.object_name,
                    info: raw.info,
                    moved: raw.moved.map(|matrices| Box::new(matrices.map(from_origin))),
                    mesh: raw.mesh as u32,
                    to_render: Affine3A::IDENTITY,
                    to_object: Affine3A::IDENTITY,
                    normal_to_render: Mat3A::IDENTITY,
                    mirrored: false,
                    pose: self.meshes[raw.mesh].poses.as_ref().map_or_else(Pose::default, |poses| poses.middle()),
                    materials: if raw.materials.is_empty() { vec![0] } else { raw.materials },
                    visible: raw.visible,
                    links: raw.links,
                    light_group: raw.light_group,
                    softening,
                    is_catcher: raw.is_catcher,
                };
                instance.stand(&DAffine3::from_mat4(raw.matrix), origin);
                if raw.way.is_some() || self.meshes[raw.mesh].poses.is_some() {
                    moving.push(Moving::new(number as u32, raw.way));
                }
                instance
            })
            .collect();
        let lamps = self.lamps.into_iter().map(|(lamp, matrix)| lamp.placed(place(matrix))).collect();
        Scene {
            meshes: self.meshes,
            instances,
            moving,
            materials,
            textures: self.textures,
            lamps,
            world: self.world,
            origin,
            viewport: Viewport::new(&self.viewport, origin),
            dims,
        }
    }
}
