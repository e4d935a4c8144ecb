//! A scene from its pieces, as they come.

use super::curves::{Curves, CurvesDescription};
use super::lamp::Lamp;
use super::material::Material;
use super::mesh::{Mesh, MeshDescription};
use super::motion::{AnimatedTransform, Moving, Pose};
use super::points::{Points, PointsDescription};
use super::shadow_terminator::ShadowTerminator;
use super::slots::Slots;
use super::texture::Texture;
use super::viewport::{Viewport, ViewportDescription};
use super::visibility::{LightLinking, Rays};
use super::world::World;
use super::{Instance, ObjectInfo, Scene, SceneError};
use crate::Rgb;
use glam::{Affine3A, DAffine3, DMat4, DVec3, Mat3A};
use std::sync::Arc;

struct RawInstance {
    object_name: String,
    asset_name: Option<String>,
    moved: Option<[DMat4; 2]>,
    way: Option<AnimatedTransform>,
    info: ObjectInfo,
    mesh: usize,
    matrix: DMat4,
    materials: Vec<u32>,
    holds_out: bool,
    visible: Rays,
    links: LightLinking,
    light_group: u16,
    shadow_terminator: ShadowTerminator,
    occlusion_distance: f32,
    is_catcher: bool,
    is_baked: bool,
}

/// Collects a scene's pieces in any order in which each piece comes after those that it names.
#[derive(Default)]
pub struct SceneBuilder {
    meshes: Slots<Arc<Mesh>>,
    instances: Vec<RawInstance>,
    materials: Slots<Material>,
    textures: Slots<Arc<Texture>>,
    lamps: Vec<(Lamp, DMat4)>,
    world: World,
    viewport: ViewportDescription,
    dicing_viewport: Option<ViewportDescription>,
    warnings: Vec<String>,
}

impl SceneBuilder {
    /// An empty scene: nothing in a black world.
    pub fn new() -> Self {
        Self::default()
    }

    /// Warnings on parts that were left out or repaired so far, a line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Adds an image; gives its index.
    pub fn add_texture(&mut self, texture: Texture) -> usize {
        self.textures.add(Arc::new(texture))
    }

    /// Adds an image of tiles (UDIM): numbers, 1001 + column + 10 row, and indices of images that were added. Gives its index. These images
    /// stay with it where they are forgotten.
    ///
    /// # Errors
    /// [`SceneError::NoSuchPiece`], [`SceneError::BadTiles`].
    pub fn add_tiles(&mut self, name: &str, tiles: &[(u32, usize)]) -> Result<usize, SceneError> {
        let known = self.textures.all();
        let missing = |index| SceneError::NoSuchPiece { object: name.into(), kind: "image", index, count: known.len() };
        let found =
            tiles.iter().map(|&(number, index)| Ok((number, known.get(index).ok_or_else(|| missing(index))?.clone())));
        let texture = Texture::from_tiles(name, found.collect::<Result<_, SceneError>>()?)?;
        Ok(self.add_texture(texture))
    }

    /// Notes a part of the scene that could not be rendered as described.
    pub fn warn(&mut self, what: String) {
        if !self.warnings.contains(&what) {
            self.warnings.push(what);
        }
    }

    /// Adds a material; gives its index.
    pub fn add_material(&mut self, mut material: Material) -> usize {
        material.prepare();
        self.materials.add(material)
    }

    /// Adds a mesh; gives its index. Triangles with a corner that is not finite, or without area, are left out
    /// with a warning.
    ///
    /// # Errors
    /// [`SceneError::BadMesh`] where its arrays do not fit together.
    pub fn add_mesh(&mut self, description: MeshDescription) -> Result<usize, SceneError> {
        let (mesh, warning) = Mesh::new(description)?;
        self.warnings.extend(warning);
        Ok(self.meshes.add(Arc::new(mesh)))
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
        Ok(self.meshes.add(Arc::new(curves.into_mesh(name))))
    }

    /// Adds a point cloud, as [`Self::add_curves`]. Points that are not finite are left out with a warning.
    ///
    /// # Errors
    /// [`SceneError::BadPoints`] where its arrays do not fit together.
    pub fn add_points(&mut self, description: PointsDescription) -> Result<usize, SceneError> {
        let name = description.name.clone();
        let (points, warning) = Points::new(description)?;
        self.warnings.extend(warning);
        Ok(self.meshes.add(Arc::new(points.into_mesh(name))))
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
        let (meshes, known) = (self.meshes.all().len(), self.materials.all().len());
        if mesh >= meshes {
            return Err(missing("mesh", mesh, meshes));
        }
        if let Some(&index) = materials.iter().find(|&&m| m >= known) {
            return Err(missing("material", index, known));
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
            holds_out: false,
            visible: Rays::ALL
                .without(if visible_camera { Rays::NONE } else { Rays::CAMERA })
                .without(if visible_shadow { Rays::NONE } else { Rays::SHADOW }),
            links: LightLinking::default(),
            light_group: 0,
            shadow_terminator: ShadowTerminator::default(),
            occlusion_distance: 0.0,
            is_catcher: false,
            is_baked: false,
        });
        Ok(Some(self.instances.len() - 1))
    }

    /// Sets the name of the asset that an instance belongs to, if not its own.
    pub fn set_asset(&mut self, instance: usize, name: &str) {
        self.instances[instance].asset_name = Some(name.into());
    }

    /// Sets the kinds of ray that see an instance.
    pub fn set_visible(&mut self, instance: usize, to: Rays) {
        self.instances[instance].visible = to;
    }

    /// Sets the lights that light an instance, and those in which it casts shadows.
    pub fn set_links(&mut self, instance: usize, links: LightLinking) {
        self.instances[instance].links = links;
    }

    /// Gives an instance a distance of its own for ambient occlusion instead of indirect light; 0 is none.
    pub fn set_occlusion_distance(&mut self, instance: usize, distance: f32) {
        self.instances[instance].occlusion_distance = distance;
    }

    /// Makes an instance a shadow catcher: the shadows on it alone are wanted.
    pub fn catch_shadows(&mut self, instance: usize) {
        self.instances[instance].is_catcher = true;
    }

    /// Makes an instance the one whose surface is baked.
    pub fn bake(&mut self, instance: usize) {
        self.instances[instance].is_baked = true;
    }

    /// Lets the camera see a hole instead of an instance; all else sees it as it is.
    pub fn hold_out(&mut self, instance: usize) {
        self.instances[instance].holds_out = true;
    }

    /// Sets the light group of an instance's emission; 0 is none.
    pub fn set_light_group(&mut self, instance: usize, group: u16) {
        self.instances[instance].light_group = group;
    }

    /// Sets the shadow terminator of an instance's smooth faces.
    pub fn set_shadow_terminator(&mut self, instance: usize, shadow_terminator: ShadowTerminator) {
        self.instances[instance].shadow_terminator = shadow_terminator;
    }

    /// Sets the data that shader graphs may ask of an instance's object.
    pub fn set_info(&mut self, instance: usize, info: ObjectInfo) {
        self.instances[instance].info = info;
    }

    /// Sets the places of an instance a frame before and a frame after, for the pass of motion.
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

    /// Sets the places of an instance at keys that lie evenly over the time that the shutter is open, the middle one where it was added.
    /// One that cannot be taken between stands still, with a warning.
    pub fn set_keys(&mut self, instance: usize, matrices: &[DMat4]) {
        let raw = &mut self.instances[instance];
        if matrices.iter().all(|m| *m == raw.matrix) {
            return;
        }
        raw.way = AnimatedTransform::new(matrices);
        if raw.way.is_none() {
            let what = "its scale is zero or not finite while the shutter is open; it stands still";
            self.warnings.push(format!("object '{}': {what}", raw.object_name));
        }
    }

    /// Adds a lamp. `matrix` takes its axes to world space; it emits along its -z.
    ///
    /// # Errors
    /// [`SceneError::BadMatrix`], [`SceneError::BadLight`], [`SceneError::BadLightSize`].
    pub fn add_lamp(&mut self, lamp: Lamp, matrix: DMat4) -> Result<(), SceneError> {
        if !matrix.is_finite() {
            return Err(SceneError::BadMatrix { object: lamp.object_name });
        }
        if !lamp.color.is_finite() {
            return Err(SceneError::BadLight { object: lamp.object_name });
        }
        if let Some((what, value)) = lamp.kind.wrong_number() {
            return Err(SceneError::BadLightSize { object: lamp.object_name, what, value });
        }
        if lamp.color == Rgb::ZERO {
            return Ok(());
        }
        self.lamps.push((lamp, matrix));
        Ok(())
    }

    /// Sets the frame of Blender's own camera.
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

    /// Sets the frame of a camera by whose pixels meshes are diced, instead of Blender's own.
    ///
    /// # Errors
    /// [`SceneError::BadMatrix`].
    pub fn set_dicing_viewport(&mut self, object_name: &str, viewport: ViewportDescription) -> Result<(), SceneError> {
        if !viewport.matrix.is_finite() {
            return Err(SceneError::BadMatrix { object: object_name.into() });
        }
        self.dicing_viewport = Some(viewport);
        Ok(())
    }

    /// Sets the world.
    ///
    /// # Errors
    /// [`SceneError::NoSuchPiece`] where it names an image that was not added.
    pub fn set_world(&mut self, world: World) -> Result<(), SceneError> {
        if let Some(index) = world.texture.filter(|&t| t as usize >= self.textures.all().len()) {
            return Err(SceneError::NoSuchPiece {
                object: "world".into(),
                kind: "image",
                index: index as usize,
                count: self.textures.all().len(),
            });
        }
        self.world = world;
        Ok(())
    }

    /// Empties the slot of an image; the next image gets its index. Everything that names the index must be forgotten, too, before the next
    /// scene.
    pub fn forget_texture(&mut self, index: usize) {
        self.textures.forget(index, Arc::new(Texture::empty()));
    }

    /// Empties the slot of a material; the next material gets its index. Everything that names the index must be forgotten, too, before the
    /// next scene.
    pub fn forget_material(&mut self, index: usize) {
        self.materials.forget(index, Material::default_grey());
    }

    /// Empties the slot of a mesh that [`Self::add_mesh`], [`Self::add_curves`] or [`Self::add_points`] added; the next one gets its index.
    /// Everything that names the index must be forgotten, too, before the next scene.
    pub fn forget_mesh(&mut self, index: usize) {
        self.meshes.forget(index, Arc::default());
    }

    /// The finished scene, with render space's origin at `origin` (world space; the camera's place).
    pub fn build(mut self, origin: DVec3) -> Scene {
        self.build_keeping(origin)
    }

    /// The finished scene, with render space's origin at `origin` (world space); images, materials and meshes stay for the next scene, at
    /// their indices. Instances, lamps and the world go, and so do the warnings.
    #[expect(clippy::too_many_lines, reason = "an instance has many fields")]
    pub fn build_keeping(&mut self, origin: DVec3) -> Scene {
        let place = |m: DMat4| -> Affine3A {
            let moved = DMat4::from_translation(-origin) * m;
            Affine3A::from_mat4(moved.as_mat4())
        };
        let mut materials = vec![Material::default_grey()];
        materials.extend_from_slice(self.materials.all());
        let (mut dims, mut moving) = (false, Vec::new());
        let meshes = self.meshes.all().to_vec();
        self.warnings.clear();
        let mut users = vec![0u32; meshes.len()];
        self.instances.iter().for_each(|raw| users[raw.mesh] += 1);
        let instances = std::mem::take(&mut self.instances)
            .into_iter()
            .enumerate()
            .map(|(number, raw)| {
                // Strands and points are round: nothing coarse would be lifted.
                let mesh = &meshes[raw.mesh];
                let is_coarse = mesh.is_of_triangles();
                let shadow_terminator =
                    if is_coarse { raw.shadow_terminator } else { raw.shadow_terminator.without_lift() };
                dims |= shadow_terminator.dims();
                // 0 is what an empty slot has.
                let mut of_slots = if raw.materials.is_empty() { vec![0] } else { raw.materials };
                if raw.holds_out {
                    of_slots.iter_mut().for_each(|slot| *slot = holding(&mut materials, *slot));
                }
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
                    is_stretched: false,
                    mirrored: false,
                    pose: mesh.poses.as_ref().map_or_else(Pose::default, |poses| poses.middle()),
                    materials: of_slots,
                    visible: raw.visible,
                    links: raw.links,
                    light_group: raw.light_group,
                    shadow_terminator,
                    occlusion_distance: raw.occlusion_distance,
                    is_catcher: raw.is_catcher,
                    is_baked: raw.is_baked,
                };
                instance.stand(&DAffine3::from_mat4(raw.matrix), origin);
                instance.is_stretched = users[raw.mesh] == 1 && instance.changes_angles();
                if raw.way.is_some() || mesh.poses.is_some() {
                    moving.push(Moving::new(number as u32, raw.way));
                }
                instance
            })
            .collect();
        let lamps = std::mem::take(&mut self.lamps);
        let lamps = lamps.into_iter().map(|(lamp, matrix)| lamp.placed(place(matrix))).collect();
        Scene {
            meshes,
            instances,
            moving,
            materials,
            textures: self.textures.all().to_vec(),
            lamps,
            world: std::mem::take(&mut self.world),
            origin,
            viewport: Viewport::new(&self.viewport, origin),
            dicing_viewport: self.dicing_viewport.take().map(|viewport| Viewport::new(&viewport, origin)),
            dims,
        }
    }
}

/// The index of a material that is one of these made to hold out.
fn holding(materials: &mut Vec<Material>, slot: u32) -> u32 {
    let holding = Material { holds_out: true, emits_or_holds_out: true, ..materials[slot as usize].clone() };
    let known = materials.iter().position(|other| *other == holding);
    known.unwrap_or_else(|| {
        materials.push(holding);
        materials.len() - 1
    }) as u32
}
