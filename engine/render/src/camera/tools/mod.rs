//! Tools for a camera with a lens: focus, framing, maps, measures.

pub mod autofocus;
pub mod coverage;
pub mod distortion_map;
pub mod framing;
pub mod imaging;
pub(super) mod osl;
pub mod picture_rays;
pub mod shade;
pub mod sharpness;
pub mod straying;
pub mod survey;
