//! Rendered pictures in OpenEXR files, with passes named as Blender names them.
//!
//! A module uses only those that stand before it here: [`error`] → [`channels`] → [`complete`] → [`part`] → [`mattes`] → [`merge`].

pub mod channels;
pub mod complete;
pub mod error;
mod mattes;
pub mod merge;
mod part;
