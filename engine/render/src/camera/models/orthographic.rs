//! Parallel rays, as Blender's orthographic camera has them: no lens takes such a picture of more than its own size.

use crate::accel::Ray;
use crate::camera::{CameraDescription, CameraRay};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2};

/// A camera of parallel rays, as Blender's orthographic one.
#[derive(Clone)]
pub struct Orthographic {
    axes: DMat3,
    /// Width and height of the view, Blender units.
    size: DVec2,
    /// The picture's middle from the axis, Blender units.
    middle: DVec2,
}

impl Orthographic {
    pub(in crate::camera) fn new(d: &CameraDescription, axes: DMat3, width: u32, height: u32) -> Self {
        let size = DVec2::new(1.0, d.rows_high(height) / f64::from(width)) * d.orthographic_width;
        Self { axes, size, middle: DVec2::from(d.perspective.shift) * size.max_element() }
    }

    /// The ray of a picture point.
    #[inline]
    pub fn ray(&self, p: Vec2) -> CameraRay {
        let place = p.as_dvec2() * self.size + self.middle;
        let origin = self.axes * place.extend(0.0);
        let ray = Ray::new(origin.as_vec3a(), (-self.axes.z_axis).as_vec3a());
        CameraRay { ray, weight: Mat3::IDENTITY }
    }

    /// The picture point of a point, camera space.
    pub(in crate::camera) fn place(&self, p: DVec3) -> DVec2 {
        (p.truncate() - self.middle) / self.size
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        &self.axes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    #[test]
    fn rays_are_parallel_and_their_points_lie_where_they_came_from() {
        let d = CameraDescription { orthographic_width: 4.0, ..Default::default() }
            .with(|c| c.perspective.shift = [0.1, -0.2]);
        let camera = Orthographic::new(&d, DMat3::IDENTITY, 200, 100);
        for p in [Vec2::new(-0.5, 0.25), Vec2::new(0.1, -0.4)] {
            let CameraRay { ray, .. } = camera.ray(p);
            assert_eq!(ray.direction, Vec3A::NEG_Z);
            let far = ray.origin + 7.0 * ray.direction;
            assert!(camera.place(far.as_dvec3()).abs_diff_eq(p.as_dvec2(), 1e-6));
        }
        // Four units wide and two high, a tenth and two tenths of the larger side aside.
        assert!(camera.ray(Vec2::new(0.5, 0.5)).ray.origin.abs_diff_eq(Vec3A::new(2.4, 0.2, 0.0), 1e-6));
    }
}
