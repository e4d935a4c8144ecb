//! Shader graphs as compact programs.
//!
//! A [`Graph`](graph::Graph) is Blender's node tree; [`compile`](compile::compile) makes of it a [`Program`] that
//! runs at each point of a surface, without allocating. Its questions about the point go through
//! [`Context`], images through [`Textures`]; scenes, meshes and lights are unknown here.
//!
//! Every value is three numbers in one register; a number stands in all three, so that it is a vector or a colour at
//! once, as Blender converts it.
//!
//! Dependencies of the modules: [`choice`] → [`hash`] → [`lanes`] → [`noise`] → [`voronoi`] → [`patterns`] → [`gabor`] → [`tiling`] → [`math`] → [`vector`] →
//! [`spectral`] → [`sky`] → [`ies`] → [`colour`] → [`mix`] → [`table`] → [`context`] → [`image`] → [`surface`] → [`graph`] → [`program`] →
//! [`compile`] → [`pixels`] → [`points`]. Each uses only those before it.

mod choice;
mod colour;
mod compile;
mod context;
mod gabor;
mod graph;
mod hash;
mod ies;
mod image;
mod lanes;
mod math;
mod mix;
mod noise;
mod patterns;
mod pixels;
mod points;
mod program;
mod sky;
mod spectral;
mod surface;
mod table;
mod tiling;
mod vector;
mod voronoi;

pub use compile::{Report, compile};
pub use context::{
    Attribute, AttributeKind, Context, Direction, Extension, Field, Found, ImageReading, Interpolation, Occlusion,
    Places, Raycast, Shift, Space, Textures,
};
pub use graph::{Graph, Input, Link, Node, Parsing};
pub use hash::{random_of, random_of_pair};
pub use image::{MISSING, unassociated};
pub use lanes::{LANES, Number, Vector, Vectors};
pub use pixels::Pixels;
pub use points::{Column, Points};
pub use program::{LaneRegisters, Layer, LayerKind, Operand, Program, Registers, Slice};
pub use sky::SunDisc;
pub use spectral::blackbody;
