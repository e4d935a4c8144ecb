//! A scene's images, as programs look them up.

use crate::scene::texture as own;
use glam::{Vec2, Vec4};
use petzval_nodes::{Extension, Interpolation, Textures};
use std::sync::Arc;

/// The scene's images, for nodes that look them up.
pub(super) struct Images<'a>(pub(super) &'a [Arc<own::Texture>]);

impl Textures for Images<'_> {
    fn lookup(&self, image: usize, uv: Vec2, interpolation: Interpolation, extension: Extension) -> Vec4 {
        let interpolation = match interpolation {
            Interpolation::Closest => own::Interpolation::Closest,
            Interpolation::Linear | Interpolation::Cubic => own::Interpolation::Linear,
        };
        let extension = match extension {
            Extension::Repeat => own::Extension::Repeat,
            Extension::Extend => own::Extension::Extend,
            Extension::Clip => own::Extension::Clip,
            Extension::Mirror => own::Extension::Mirror,
        };
        self.0.get(image).map_or(Vec4::ZERO, |texture| texture.lookup(uv, interpolation, extension))
    }
}
