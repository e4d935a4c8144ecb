//! Rendered pictures in OpenEXR files, with passes named as Blender names them.

mod mattes;
pub mod merge;
mod part;
