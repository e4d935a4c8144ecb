//! What there is to photograph: a plain description comes in piece by piece ([`SceneBuilder`]), is checked, and
//! becomes an immutable [`Scene`] in render space. Nothing here knows how light moves or what a camera is.

pub mod closure;
pub mod corners;
pub mod curves;
pub mod edges;
pub mod graph;
pub mod grid;
pub mod lamp;
pub mod layer;
pub mod material;
pub mod mesh;
pub mod motion;
pub mod softening;
pub mod texture;
pub mod viewport;
pub mod visibility;
pub mod volume;
pub mod world;

use crate::Rgb;
use curves::{Curves, CurvesDescription};
use glam::{Affine3A, DAffine3, DMat4, DVec3, Mat3A, Vec4};
use lamp::Lamp;
use material::Material;
use mesh::{Mesh, MeshDescription};
use motion::{Moving, Pose, Way};
use softening::Softening;
use texture::Texture;
use viewport::{Viewport, ViewportDescription};
use visibility::{Links, Rays};
use world::World;

/// What was wrong with a piece of the description.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Arrays of a mesh disagree in length or point outside of one another.
    #[error("mesh '{mesh}': {what}; export the mesh again or remove it")]
    BadMesh {
        /// The mesh's name.
        mesh: String,
        /// Which array, and how it is wrong.
        what: String,
    },
    /// Arrays of curves disagree in length.
    #[error("curves '{curves}': {what}; export them again or remove them")]
    BadCurves {
        /// Their name.
        curves: String,
        /// Which array, and how it is wrong.
        what: String,
    },
    /// An index to an earlier piece that was never added.
    #[error("object '{object}': {kind} number {index} does not exist; there are {count}")]
    NoSuchPiece {
        /// The object that asked.
        object: String,
        /// Mesh, material or image.
        kind: &'static str,
        /// What it asked for.
        index: usize,
        /// How many were added.
        count: usize,
    },
    /// A matrix with NaN, infinities, or no inverse.
    #[error("object '{object}': its matrix is not finite or flattens the object; reset its scale")]
    BadMatrix {
        /// The object's name.
        object: String,
    },
    /// An image whose pixel array has another size than its width and height say.
    #[error("image '{image}': {pixels} values for {width} x {height} RGBA pixels; reload the image")]
    BadImage {
        /// The image's name.
        image: String,
        /// Values given.
        pixels: usize,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
}

/// A mesh placed in the scene.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The Blender object it comes from.
    pub object_name: String,
    /// That object's topmost parent.
    pub asset_name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Object space to render space.
    pub to_render: Affine3A,
    /// Render space to object space.
    pub to_object: Affine3A,
    /// Object-space normals to render space (inverse transpose), unnormalised.
    pub normal_to_render: Mat3A,
    /// The matrix mirrors: front and back are exchanged.
    pub mirrored: bool,
    /// Material of each slot; never empty.
    pub materials: Vec<u32>,
    /// What it shows itself to.
    pub visible: Rays,
    /// Which lights light it, and in which it throws shadows.
    pub links: Links,
    /// The number of the light group of what it emits; 0 is none.
    pub light_group: u16,
    /// How its smooth faces are helped at the edge of light.
    pub softening: Softening,
    /// Object space to render space a frame before and a frame after; `None` where it stands still.
    pub moved: Option<Box<[DAffine3; 2]>>,
    /// What shader graphs may ask of the object.
    pub info: ObjectInfo,
    /// Which of its mesh's shapes it has, where that has several.
    pub pose: Pose,
    /// It stands for what the picture is to be laid over: its shadows alone are wanted.
    pub is_catcher: bool,
}

/// What Blender's Object Info node tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectInfo {
    /// In the viewport; with alpha.
    pub color: Vec4,
    /// Pass index.
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
    /// Puts it elsewhere: `to_world` takes object space to world space, `origin` is render space's.
    fn stand(&mut self, to_world: &DAffine3, origin: DVec3) {
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

    /// A triangle's corners, object space.
    #[inline]
    pub fn corners(&self, mesh: &Mesh, triangle: u32) -> [glam::Vec3; 3] {
        match &mesh.poses {
            None => mesh.corners(triangle),
            Some(poses) => poses.corners(mesh.triangles[triangle as usize], self.pose),
        }
    }

    /// The normals at a triangle's corners, object space; `None` of a mesh that has none.
    #[inline]
    pub fn corner_normals(&self, mesh: &Mesh, triangle: u32) -> Option<[glam::Vec3; 3]> {
        let posed = mesh.poses.as_ref().and_then(|poses| poses.normals(mesh.numbers(), triangle, self.pose));
        posed.or_else(|| mesh.normals(triangle))
    }

    /// The material of a mesh's slot; slots past the end take the last, as Blender does.
    #[inline]
    pub fn material(&self, slot: u32) -> u32 {
        self.materials[(slot as usize).min(self.materials.len() - 1)]
    }
}

/// Everything there is to photograph, in render space; immutable.
#[derive(Debug)]
pub struct Scene {
    /// Meshes in object space.
    pub meshes: Vec<Mesh>,
    /// Where they stand. Those of [`Self::placed`] come first, then what stands for moments of what moves.
    pub instances: Vec<Instance>,
    /// What moves while the shutter is open.
    pub moving: Vec<Moving>,
    /// Materials; the first is the default grey.
    pub materials: Vec<Material>,
    /// Images.
    pub textures: Vec<Texture>,
    /// Point, spot, sun and area lights.
    pub lamps: Vec<Lamp>,
    /// Light from everywhere else.
    pub world: World,
    /// World-space position of render space's origin.
    pub origin: DVec3,
    /// What Blender's own camera frames.
    pub viewport: Viewport,
    /// Whether any instance's [`Softening`] takes light away.
    pub dims: bool,
}

impl Scene {
    /// Triangles, each instance counted.
    pub fn triangle_count(&self) -> usize {
        self.placed().iter().map(|i| self.meshes[i.mesh as usize].triangles.len()).sum()
    }

    /// Segments of hair and other curves, each instance counted.
    pub fn segment_count(&self) -> usize {
        let of = |mesh: &Mesh| mesh.curves.as_ref().map_or(0, |curves| curves.segment_count());
        self.placed().iter().map(|i| of(&self.meshes[i.mesh as usize])).sum()
    }
}

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
                // Strands are round: nothing coarse would show.
                let is_hair = self.meshes[raw.mesh].curves.is_some();
                let softening = if is_hair { Softening::default() } else { raw.softening };
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
