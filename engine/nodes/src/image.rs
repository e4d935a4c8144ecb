//! The place of a direction or point on an image.

use crate::choice::choices;
use crate::context::{ImageReading, Textures};
use glam::{Vec2, Vec3A, Vec4};
use std::f32::consts::{PI, TAU};

choices! {
    pub(crate) Projection { Flat = "FLAT", Box = "BOX", Sphere = "SPHERE", Tube = "TUBE" }
}
choices! {
    pub(crate) EnvironmentProjection { Equirectangular = "EQUIRECTANGULAR", MirrorBall = "MIRROR_BALL" }
}

/// The colour of a missing image, linear, as Cycles shows it; its alpha is 1.
pub const MISSING: [f32; 3] = [1.0, 0.0, 1.0];

/// One image and the settings of its lookup.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ImageTexture {
    pub(crate) image: u16,
    pub(crate) reading: ImageReading,
}

impl ImageTexture {
    pub(crate) fn at(self, textures: &impl Textures, uv: Vec2) -> Vec4 {
        textures.lookup(usize::from(self.image), uv, self.reading)
    }

    /// Three sides of a box, blended where a normal leans between them; the normal is in object space.
    pub(crate) fn on_box(self, textures: &impl Textures, p: Vec3A, normal: Vec3A, blend: f32) -> Vec4 {
        let weights = box_weights(normal.abs(), blend);
        let mirrored = |facing: bool, x: f32| if facing { 1.0 - x } else { x };
        let sides = [
            Vec2::new(mirrored(normal.x < 0.0, p.y), p.z),
            Vec2::new(mirrored(normal.y > 0.0, p.x), p.z),
            Vec2::new(mirrored(normal.z > 0.0, p.y), p.x),
        ];
        let mut sum = Vec4::ZERO;
        for (weight, uv) in weights.into_iter().zip(sides) {
            if weight > 0.0 {
                sum += self.at(textures, uv) * weight;
            }
        }
        sum
    }
}

/// Weights of the image along x, y and z.
fn box_weights(normal: Vec3A, blend: f32) -> [f32; 3] {
    let sum = normal.element_sum();
    let [x, y, z] = (if sum > 0.0 { normal / sum } else { normal }).to_array();
    // Beyond this share of two axes' sum, one axis has all.
    let limit = 0.5 * (1.0 + blend);
    if x > limit * (x + y) && x > limit * (x + z) {
        return [1.0, 0.0, 0.0];
    }
    if y > limit * (x + y) && y > limit * (y + z) {
        return [0.0, 1.0, 0.0];
    }
    if z > limit * (x + z) && z > limit * (y + z) {
        return [0.0, 0.0, 1.0];
    }
    if blend <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let pair = |a: f32, b: f32| ((a / (a + b) - 0.5 * (1.0 - blend)) / blend).clamp(0.0, 1.0);
    if z < (1.0 - limit) * (x + y) {
        let share = pair(x, y);
        [share, 1.0 - share, 0.0]
    } else if x < (1.0 - limit) * (y + z) {
        let share = pair(y, z);
        [0.0, share, 1.0 - share]
    } else if y < (1.0 - limit) * (x + z) {
        let share = pair(x, z);
        [share, 0.0, 1.0 - share]
    } else {
        [x, y, z].map(|part| ((2.0 - limit) * part + (limit - 1.0)) / (2.0 * limit - 1.0))
    }
}

/// The place of a point of the cube of 0 to 1 on a sphere about its centre.
pub(crate) fn sphere(p: Vec3A) -> Vec2 {
    let p = (p - 0.5) * 2.0;
    let length = p.length();
    if length == 0.0 {
        return Vec2::ZERO;
    }
    let u = if p.x == 0.0 && p.y == 0.0 { 0.0 } else { (1.0 - p.x.atan2(p.y) / PI) / 2.0 };
    Vec2::new(u, 1.0 - (p.z / length).clamp(-1.0, 1.0).acos() / PI)
}

pub(crate) fn tube(p: Vec3A) -> Vec2 {
    let p = (p - 0.5) * 2.0;
    let u = if p.x == 0.0 && p.y == 0.0 { 0.0 } else { (1.0 - p.x.atan2(p.y) / PI) / 2.0 };
    Vec2::new(u, (p.z + 1.0) / 2.0)
}

pub(crate) fn environment(projection: EnvironmentProjection, direction: Vec3A) -> Vec2 {
    let [x, y, z] = direction.normalize_or_zero().to_array();
    match projection {
        EnvironmentProjection::Equirectangular => Vec2::new(-y.atan2(x) / TAU + 0.5, z.atan2(x.hypot(y)) / PI + 0.5),
        EnvironmentProjection::MirrorBall => {
            let half = 2.0 * (-0.5 * (y - 1.0)).max(0.0).sqrt();
            let across = if half > 0.0 { Vec2::new(x, z) / half } else { Vec2::ZERO };
            (across + 1.0) * 0.5
        }
    }
}

/// Colours divided by alpha, where it is neither 0 nor 1 (Cycles, `svm_image_texture`).
#[inline]
pub fn unassociated(rgba: Vec4) -> Vec4 {
    if rgba.w == 1.0 || rgba.w == 0.0 { rgba } else { (rgba.truncate() / rgba.w).extend(rgba.w) }
}
