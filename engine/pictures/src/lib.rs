//! Rendered pictures in OpenEXR files, with passes named as Blender names them.
//!
//! A module uses only those that stand before it here: [`error`] → [`mod@write`] → [`part`] → [`mattes`] → [`merge`].

pub mod error;
mod mattes;
pub mod merge;
mod part;
pub mod write;
