//! Rendered pictures in OpenEXR files, with passes named as Blender names them; raw pictures of sensors in DNG and PNG files.
//!
//! A module uses only those that stand before it here: [`error`] → [`channels`] → [`dng`] → [`png`] → [`complete`] → [`part`] → [`mattes`] → [`merge`].

pub mod channels;
pub mod complete;
pub mod dng;
pub mod error;
mod mattes;
pub mod merge;
mod part;
pub mod png;
