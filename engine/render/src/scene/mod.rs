//! The scene: a plain description comes in piece by piece ([`SceneBuilder`]), is checked, and becomes an immutable
//! [`Scene`] in render space. Nothing here knows of light transport or cameras.

mod builder;
pub mod closure;
pub mod corners;
pub mod curves;
pub mod dicing;
pub mod edges;
pub mod graph;
pub mod grid;
mod instance;
pub mod lamp;
pub mod layer;
pub mod material;
pub mod mesh;
pub mod motion;
pub mod plain;
pub mod points;
pub mod shadow_terminator;
mod slots;
pub mod texture;
pub mod viewport;
pub mod visibility;
pub mod volume;
pub mod world;

pub use builder::SceneBuilder;
use glam::DVec3;
pub use instance::{Instance, ObjectInfo};
use lamp::Lamp;
use material::Material;
use mesh::Mesh;
use motion::Moving;
use std::sync::Arc;
use texture::Texture;
use viewport::Viewport;
use world::World;

/// An error in a piece of the description.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Arrays of a mesh disagree in length or point outside of one another.
    #[error("mesh '{mesh}': {what}; export the mesh again or remove it")]
    BadMesh {
        /// The mesh's name.
        mesh: String,
        /// The array, and its error.
        what: String,
    },
    /// Arrays of curves disagree in length.
    #[error("curves '{curves}': {what}; export them again or remove them")]
    BadCurves {
        /// The name of the curves.
        curves: String,
        /// The array, and its error.
        what: String,
    },
    /// Arrays of a point cloud disagree in length.
    #[error("points '{points}': {what}; export them again or remove them")]
    BadPoints {
        /// The name of the point cloud.
        points: String,
        /// The array, and its error.
        what: String,
    },
    /// An index to an earlier piece that was never added.
    #[error("object '{object}': {kind} number {index} does not exist; there are {count}")]
    NoSuchPiece {
        /// The object that asked.
        object: String,
        /// Mesh, material or image.
        kind: &'static str,
        /// The index that it asked for.
        index: usize,
        /// Number of items that were added.
        count: usize,
    },
    /// A matrix with NaN, infinities, or no inverse.
    #[error("object '{object}': its matrix is not finite or flattens the object; reset its scale")]
    BadMatrix {
        /// The object's name.
        object: String,
    },
    /// A light whose colour times its power is NaN or infinite.
    #[error("light '{object}': its power or colour is infinite or NaN; give numbers, or look at its drivers")]
    BadLight {
        /// The object's name.
        object: String,
    },
    /// A light whose size or angle is none.
    #[error("light '{object}': its {what} is {value}; give a number of zero or more, or look at its drivers")]
    BadLightSize {
        /// The object's name.
        object: String,
        /// The size or angle.
        what: &'static str,
        /// Its value.
        value: f32,
    },
    /// An image whose pixel array has another size than its width and height say.
    #[error("image '{image}': {pixels} values for {width} x {height} RGBA pixels; reload the image")]
    BadImage {
        /// The image's name.
        image: String,
        /// Number of values that were given.
        pixels: usize,
        /// Width of the image, pixels.
        width: usize,
        /// Height of the image, pixels.
        height: usize,
    },
    /// An image with two tiles of one number, or with a number that no tile has.
    #[error("image '{image}': tile {number} is there twice, or no tile's number: they are 1001 and more, each once")]
    BadTiles {
        /// The image's name.
        image: String,
        /// The tile's number.
        number: u32,
    },
}

/// Everything there is to photograph, in render space; immutable.
#[derive(Debug)]
pub struct Scene {
    /// Meshes in object space.
    pub meshes: Vec<Arc<Mesh>>,
    /// The instances. Those of [`Self::placed`] come first, then those that stand for the moments of moving ones.
    pub instances: Vec<Instance>,
    /// The instances that move while the shutter is open.
    pub moving: Vec<Moving>,
    /// Materials; the first is the default grey.
    pub materials: Vec<Material>,
    /// Images that shader graphs and the world look up.
    pub textures: Vec<Arc<Texture>>,
    /// Point, spot, sun and area lights.
    pub lamps: Vec<Lamp>,
    /// Light from everywhere else.
    pub world: World,
    /// World-space position of render space's origin.
    pub origin: DVec3,
    /// The picture of Blender's own camera.
    pub viewport: Viewport,
    /// The picture by whose pixels meshes are diced, where that is not Blender's own camera's.
    pub dicing_viewport: Option<Viewport>,
    /// True if any instance's [`ShadowTerminator`] takes light away.
    pub dims: bool,
}

impl Scene {
    /// Triangles, each instance counted.
    pub fn triangle_count(&self) -> usize {
        self.placed().iter().map(|i| self.meshes[i.mesh as usize].triangles.len()).sum()
    }

    /// Points of clouds, each instance counted.
    pub fn point_count(&self) -> usize {
        let of = |mesh: &Mesh| mesh.points.as_ref().map_or(0, |points| points.points.len());
        self.placed().iter().map(|i| of(&self.meshes[i.mesh as usize])).sum()
    }

    /// Segments of hair and other curves, each instance counted.
    pub fn segment_count(&self) -> usize {
        let of = |mesh: &Mesh| mesh.curves.as_ref().map_or(0, |curves| curves.segment_count());
        self.placed().iter().map(|i| of(&self.meshes[i.mesh as usize])).sum()
    }
}
