//! The lens that is traced: set, focused, before its film; its rays both ways, and their transmission.

pub(super) mod beam;
pub(super) mod focal_surface;
pub mod from_scene;
pub(super) mod lines;
pub(super) mod mount;
pub mod real_lens;
pub mod scene_side;
pub mod setup;
pub(super) mod steps;
pub(super) mod transmission;
