//! Spherical stereo: an eye that stands aside of every ray of a camera, so that each direction of a panorama has its own pair of eyes.

use super::{Camera, CameraRay};
use crate::accel::Ray;
use glam::{Vec2, Vec3A};
use serde::Deserialize;
use std::f32::consts::FRAC_PI_2;

/// One eye of a pair that turns with the ray about an upright axis, as in Cycles (`spherical_stereo_transform` in
/// kernel/camera/projection.h).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphericalStereo {
    /// The way of the eye to the right of the ray, Blender units; a left eye has it negative.
    pub offset: f64,
    /// Distance at which both eyes see the same in one place of their pictures, Blender units; `None`: their rays are parallel.
    pub convergence: Option<f64>,
    /// Angles above or below the horizon from which the eyes draw together, and at which they are one; `None`: they keep their distance.
    pub pole_merge_rad: Option<[f64; 2]>,
}

impl SphericalStereo {
    /// Checks that the settings are numbers and that eyes converge before the camera.
    ///
    /// # Errors
    /// The first wrong setting, and the remedy.
    pub(super) fn check(&self) -> Result<(), String> {
        if !self.offset.is_finite() {
            return Err(format!("the interocular distance is {}; give a number, or look at its driver", self.offset));
        }
        if let Some(angle) = self.pole_merge_rad.into_iter().flatten().find(|angle| !angle.is_finite()) {
            return Err(format!("an angle of the pole merge is {angle}; give a number, or look at its driver"));
        }
        match self.convergence {
            Some(distance) if distance.is_nan() || distance <= 0.0 => {
                Err(format!("the distance of the convergence plane is {distance}; set it above zero"))
            }
            _ => Ok(()),
        }
    }

    /// The eye's ray for a ray of the camera; `up` is the upright axis.
    #[inline]
    fn of_eye(&self, ray: Ray, up: Vec3A) -> Ray {
        // Straight up there is no right.
        let Some(right) = ray.direction.cross(up).try_normalize() else { return ray };
        let aside = right * self.offset_at(ray.direction.dot(up).clamp(-1.0, 1.0).asin().abs());
        let direction = match self.convergence {
            Some(distance) => (ray.direction * distance as f32 - aside).normalize_or(ray.direction),
            None => ray.direction,
        };
        Ray { origin: ray.origin + aside, direction, ..ray }
    }

    /// The offset of a ray at an angle above or below the horizon.
    fn offset_at(&self, altitude_rad: f32) -> f32 {
        let offset = self.offset as f32;
        match self.pole_merge_rad.map(|angles| angles.map(|angle| angle as f32)) {
            Some([_, to]) if altitude_rad > to => 0.0,
            Some([from, to]) if altitude_rad > from => offset * ((altitude_rad - from) / (to - from) * FRAC_PI_2).cos(),
            _ => offset,
        }
    }
}

/// One eye of a camera in spherical stereo.
#[derive(Clone)]
pub struct Eye {
    pub(super) camera: Camera,
    stereo: SphericalStereo,
    /// Render space.
    up: Vec3A,
}

impl Eye {
    pub(super) fn new(camera: Camera, stereo: SphericalStereo) -> Self {
        // As in Cycles: a panorama's pole is where its camera's is; the eyes of a perspective camera stand level in the world.
        let up = match &camera {
            Camera::Panoramic(camera) => camera.axes().y_axis.as_vec3a(),
            _ => Vec3A::Z,
        };
        Self { camera, stereo, up }
    }

    /// [`Camera::sample`] of the eye.
    #[inline]
    pub(super) fn sample(&self, p: Vec2, u_lens: [f32; 2], u_wavelength: f32) -> Option<CameraRay> {
        let seen = self.camera.sample(p, u_lens, u_wavelength)?;
        Some(CameraRay { ray: self.stereo.of_eye(seen.ray, self.up), ..seen })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEFT: SphericalStereo = SphericalStereo { offset: -0.5, convergence: None, pole_merge_rad: None };

    fn eye(stereo: SphericalStereo, direction: Vec3A) -> Ray {
        stereo.of_eye(Ray::new(Vec3A::ZERO, direction), Vec3A::Z)
    }

    /// Whichever way it looks, the left eye stands to the left of it, level.
    #[test]
    fn eyes_turn_with_their_rays() {
        for (direction, left) in [(Vec3A::Y, Vec3A::NEG_X), (Vec3A::X, Vec3A::Y), (Vec3A::NEG_Y, Vec3A::X)] {
            let ray = eye(LEFT, direction);
            assert_eq!((ray.origin, ray.direction), (0.5 * left, direction));
        }
    }

    #[test]
    fn rays_of_both_eyes_meet_at_the_convergence_distance() {
        let stereo = SphericalStereo { convergence: Some(3.0), ..LEFT };
        let direction = Vec3A::new(0.48, 0.64, 0.6);
        let rays = [stereo, SphericalStereo { offset: 0.5, ..stereo }].map(|one| eye(one, direction));
        for ray in rays {
            let to_there = 3.0 * direction - ray.origin;
            assert!((to_there.normalize() - ray.direction).length() < 1e-6, "{to_there} {}", ray.direction);
        }
        assert!(rays[0].origin.distance(rays[1].origin) > 0.999);
    }

    #[test]
    fn eyes_merge_towards_the_poles() {
        let stereo = SphericalStereo { pole_merge_rad: Some([1.0, 1.2]), ..LEFT };
        let at = |altitude: f32| eye(stereo, Vec3A::new(altitude.cos(), 0.0, -altitude.sin())).origin.length();
        assert!((at(0.9) - 0.5).abs() < 1e-6 && at(1.3) == 0.0);
        assert!((at(1.1) - 0.5 * (0.25 * std::f32::consts::PI).cos()).abs() < 1e-4);
        assert_eq!(eye(LEFT, Vec3A::Z).origin, Vec3A::ZERO);
    }
}
