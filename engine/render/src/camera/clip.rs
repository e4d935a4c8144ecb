//! Clipping of camera rays by depth as in Blender, or by distance where a camera's depth is one.

use super::{Camera, CameraDescription};
use crate::accel::Ray;
use glam::{DVec3, Vec3A};

/// Two planes at right angles to a camera's axis, or two spheres about a camera whose depth is a distance.
#[derive(Clone, Copy, Debug)]
pub struct Clip {
    is_by_distance: bool,
    /// Direction along the axis, render space: depth is its product with a place.
    forward: Vec3A,
    near: f32,
    far: f32,
}

impl Clip {
    /// The clip planes of a camera whose place is render space's origin; `None` if they leave nothing out.
    pub fn new(d: &CameraDescription, camera: &Camera) -> Option<Self> {
        let planes = Self::along(d, camera.backwards())?;
        Some(Self { is_by_distance: camera.depth_is_distance(), ..planes })
    }

    /// The clip planes of a lens that is not made yet; `None` if they leave nothing out. `backwards` is its axis from
    /// the scene to the film, render space.
    pub fn along(d: &CameraDescription, backwards: DVec3) -> Option<Self> {
        let [near, far] = d.clip;
        let leaves_out = near > 0.0 || far < f64::INFINITY;
        let is_by_distance = false;
        let (forward, near, far) = (-backwards.as_vec3a(), near as f32, far as f32);
        leaves_out.then_some(Self { is_by_distance, forward, near, far })
    }

    /// The part of a camera ray between the planes.
    #[inline]
    pub fn cut(&self, ray: Ray) -> Ray {
        if self.is_by_distance {
            let t_max = (self.far - self.near).max(0.0);
            return Ray { origin: ray.origin + ray.direction * self.near, t_max, ..ray };
        }
        let (along, depth) = (self.forward.dot(ray.direction), self.forward.dot(ray.origin));
        // A fisheye looks sideways and back, where depth says nothing.
        if along <= 1e-6 {
            return ray;
        }
        let begin = ((self.near - depth) / along).max(0.0);
        let end = (self.far - depth) / along;
        Ray { origin: ray.origin + ray.direction * begin, t_max: (end - begin).max(0.0), ..ray }
    }

    /// The distance along a ray of light towards the camera up to which surfaces may occlude it; `None` if the light
    /// comes from beyond the clip planes.
    pub fn way_to_camera(&self, ray: &Ray) -> Option<f32> {
        if self.is_by_distance {
            let distance = ray.origin.length();
            return (self.near..=self.far).contains(&distance).then(|| ray.t_max.min(distance - self.near));
        }
        let (along, depth) = (-self.forward.dot(ray.direction), self.forward.dot(ray.origin));
        if along <= 1e-6 {
            return Some(ray.t_max);
        }
        (self.near..=self.far).contains(&depth).then(|| ray.t_max.min((depth - self.near) / along))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Model;
    use crate::projection::{Panorama, Projection};

    /// Behind a panoramic camera as before it.
    #[test]
    fn distance_counts_of_a_panoramic_camera() {
        let panorama = Some(Panorama { projection: Projection::MirrorBall, shift: [0.0; 2] });
        let d = CameraDescription { model: Model::Panoramic, panorama, clip: [1.0, 10.0], ..Default::default() };
        let camera = Camera::new(&d, 100, 50).unwrap();
        let clip = Clip::new(&d, &camera).unwrap();
        for direction in [Vec3A::NEG_Z, Vec3A::Z, Vec3A::X] {
            let cut = clip.cut(Ray::new(Vec3A::ZERO, direction));
            assert_eq!((cut.origin, cut.t_max), (direction, 9.0));
        }
        let back = |distance: f32| clip.way_to_camera(&Ray::new(Vec3A::Z * distance, Vec3A::NEG_Z));
        assert_eq!([back(0.5), back(3.0), back(11.0)], [None, Some(2.0), None]);
    }

    #[test]
    fn depth_counts_along_the_axis() {
        let d = CameraDescription { model: Model::Pinhole, clip: [1.0, 10.0], ..Default::default() };
        let camera = Camera::new(&d, 100, 100).unwrap();
        let clip = Clip::new(&d, &camera).unwrap();
        for direction in [Vec3A::NEG_Z, Vec3A::new(0.6, 0.0, -0.8)] {
            let cut = clip.cut(Ray::new(Vec3A::ZERO, direction));
            assert!((cut.origin.z + 1.0).abs() < 1e-6);
            assert!((cut.origin + cut.direction * cut.t_max).z + 10.0 < 1e-5);
        }
        // The way back ends at the near plane; from outside there is none.
        let back = |depth: f32| clip.way_to_camera(&Ray::new(Vec3A::NEG_Z * depth, Vec3A::Z));
        assert_eq!([back(0.5), back(3.0), back(11.0)], [None, Some(2.0), None]);
        let sideways = Ray::new(Vec3A::ZERO, Vec3A::X);
        assert_eq!(clip.cut(sideways).t_max, f32::INFINITY);
        assert!(Clip::new(&CameraDescription { clip: [0.0, f64::INFINITY], ..d }, &camera).is_none());
    }
}
