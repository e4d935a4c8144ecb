//! The thin lens: a disk or polygon whose every point sends a picture point's light to one point of a plane.

use super::pinhole::Pinhole;
use super::{CameraDescription, CameraError, CameraRay};
use crate::accel::Ray;
use crate::sampler::warp::sample_disk;
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2};
use std::f64::consts::{FRAC_PI_4, TAU};

/// The aperture that Blender's own cameras start with, where none is given.
const DEFAULT_F_NUMBER: f64 = 2.8;

/// Blender's perspective camera with depth of field: framing does not change with focus.
pub struct Thin {
    pinhole: Pinhole,
    /// Blender units.
    radius: f64,
    /// Blender units; infinite for infinity.
    focus: f64,
    blades: u32,
    rotation_rad: f64,
    brightness: f32,
}

impl Thin {
    pub(super) fn new(d: &CameraDescription, axes: DMat3, width: u32, height: u32) -> Result<Self, CameraError> {
        let f_number = d.f_number.unwrap_or(DEFAULT_F_NUMBER);
        if !(f_number > 0.0 && f_number.is_finite()) {
            return Err(d.error(format!("the f-number is {f_number}; set it above zero")));
        }
        let radius_mm = d.pinhole_focal_length_mm / (2.0 * f_number);
        Ok(Self {
            pinhole: Pinhole::new(d, axes, width, height),
            radius: radius_mm / d.scale_mm_per_unit.x,
            focus: d.focus_depth()?.unwrap_or(f64::INFINITY),
            blades: d.blades,
            rotation_rad: d.blade_rotation_rad,
            // The irradiance behind a lens without aberration, focused far away.
            brightness: d.brightness(FRAC_PI_4 / (f_number * f_number)) as f32,
        })
    }

    pub(super) fn axes(&self) -> &DMat3 {
        self.pinhole.axes()
    }

    /// A ray of a picture point through the point of the aperture that `u` chooses.
    #[inline]
    pub fn sample(&self, p: Vec2, u: [f32; 2]) -> CameraRay {
        let lens = self.aperture(u) * self.radius;
        let start = DVec3::new(lens.x, lens.y, 0.0);
        let along = self.pinhole.at_unit_depth(p);
        let d = if self.focus.is_finite() { along * self.focus - start } else { along };
        let axes = self.pinhole.axes();
        let ray = Ray::new((*axes * start).as_vec3a(), (*axes * d).normalize().as_vec3a());
        CameraRay { ray, weight: Mat3::IDENTITY * self.brightness }
    }

    /// A point of the unit aperture, uniformly.
    fn aperture(&self, u: [f32; 2]) -> DVec2 {
        if self.blades < 3 {
            return sample_disk(u).as_dvec2();
        }
        // A sector of the polygon, then a point of its triangle.
        let n = self.blades as f64;
        let x = u[0] as f64 * n;
        let sector = x.floor().min(n - 1.0);
        let along = x - sector;
        let corner = |k: f64| DVec2::from_angle(self.rotation_rad + TAU * k / n);
        let out = (u[1] as f64).sqrt();
        (corner(sector) * (1.0 - along) + corner(sector + 1.0) * along) * out
    }
}
