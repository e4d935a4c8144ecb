//! A scene's images, as programs look them up.

use crate::scene::texture as own;
use glam::{Vec2, Vec4};
use petzval_nodes::{Extension, ImageReading, Interpolation, Textures};
use std::sync::Arc;

/// The scene's images, for nodes that look them up.
pub(super) struct Images<'a>(pub(super) &'a [Arc<own::Texture>]);

impl Textures for Images<'_> {
    fn lookup(&self, image: usize, uv: Vec2, read: ImageReading) -> Vec4 {
        let interpolation = match read.interpolation {
            Interpolation::Closest => own::Interpolation::Closest,
            Interpolation::Linear | Interpolation::Cubic => own::Interpolation::Linear,
        };
        let extension = match read.extension {
            Extension::Repeat => own::Extension::Repeat,
            Extension::Extend => own::Extension::Extend,
            Extension::Clip => own::Extension::Clip,
            Extension::Mirror => own::Extension::Mirror,
        };
        let Some(texture) = self.0.get(image) else { return Vec4::ZERO };
        if read.unassociate {
            texture.unassociated(uv, interpolation, extension)
        } else {
            texture.lookup(uv, interpolation, extension)
        }
    }
}
