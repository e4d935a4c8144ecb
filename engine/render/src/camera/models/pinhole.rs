//! The pinhole: every ray through one point, as Blender's perspective camera without depth of field.

use crate::accel::Ray;
use crate::camera::{CameraDescription, CameraRay};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2, Vec3A};

/// A camera whose rays all go through one point, as Blender's perspective one.
#[derive(Clone)]
pub struct Pinhole {
    axes: DMat3,
    // At unit depth: width, height, and the picture's centre.
    width: f64,
    height: f64,
    centre: [f64; 2],
}

impl Pinhole {
    pub(in crate::camera) fn new(d: &CameraDescription, axes: DMat3, width: u32, height: u32) -> Self {
        let w = d.perspective.film_width_mm / d.perspective.focal_length_mm;
        let h = w * d.rows_high(height) / f64::from(width);
        let larger = w.max(h);
        let centre = d.perspective.shift.map(|s| s * larger);
        Self { axes, width: w, height: h, centre }
    }

    /// The ray of a picture point.
    #[inline]
    pub fn ray(&self, p: Vec2) -> CameraRay {
        let d = (self.axes * self.at_unit_depth(p)).normalize();
        CameraRay { ray: Ray::new(Vec3A::ZERO, d.as_vec3a()), weight: Mat3::IDENTITY }
    }

    /// The point of a picture point's ray at depth one, camera space.
    #[inline]
    pub(in crate::camera) fn at_unit_depth(&self, p: Vec2) -> DVec3 {
        let x = p.x as f64 * self.width + self.centre[0];
        let y = p.y as f64 * self.height + self.centre[1];
        DVec3::new(x, y, -1.0)
    }

    /// The picture point of a direction in camera space; `None` behind the camera.
    pub(in crate::camera) fn place(&self, d: DVec3) -> Option<DVec2> {
        let [x, y] = [d.x, d.y].map(|across| across / -d.z);
        (d.z < 0.0).then(|| DVec2::new((x - self.centre[0]) / self.width, (y - self.centre[1]) / self.height))
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        &self.axes
    }
}
