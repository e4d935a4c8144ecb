//! The thin lens: a disk, polygon or mask whose every point sends a picture point's light to one point of a plane.

use super::pinhole::Pinhole;
use crate::accel::Ray;
use crate::camera::{CameraDescription, CameraError, CameraRay};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2};
use petzval_optics::diaphragm::Diaphragm;
use std::f64::consts::FRAC_PI_4;

/// The aperture that Blender's own cameras start with, where none is given.
const DEFAULT_F_NUMBER: f64 = 2.8;

/// Blender's perspective camera with depth of field: framing does not change with focus.
#[derive(Clone)]
pub struct Thin {
    pinhole: Pinhole,
    aperture: Aperture,
    mm_per_unit: f64,
    /// Blender units; infinite for infinity.
    focus: f64,
    brightness: f32,
}

/// The opening of a lens of Blender's focal length, narrower across than it is high as Blender's anamorphic bokeh has it.
#[derive(Clone)]
pub(super) struct Aperture {
    diaphragm: Diaphragm,
    /// Factor of distances to the side.
    across: f64,
}

impl Aperture {
    pub(super) fn new(d: &CameraDescription, f_number: f64) -> Result<Self, CameraError> {
        if !(f_number > 0.0 && f_number.is_finite()) {
            return Err(d.error(format!("the f-number is {f_number}; set it above zero")));
        }
        let radius_mm = d.perspective.focal_length_mm / (2.0 * f_number);
        let plain = Diaphragm::checked(radius_mm, d.lens.blades, d.lens.blade_curvature, d.lens.blade_rotation_rad)
            .map_err(|e| d.error(e.to_string()))?;
        let diaphragm = match &d.lens.aperture_mask {
            Some(mask) => Diaphragm::masked(radius_mm, mask.clone(), d.lens.blade_rotation_rad),
            None => plain,
        };
        Ok(Self { diaphragm, across: d.perspective.aperture_ratio.recip() })
    }

    /// The point that `u` chooses evenly, mm to the right and up.
    #[inline]
    pub(super) fn sample(&self, u: [f32; 2]) -> [f64; 2] {
        let [x, y] = self.diaphragm.sample(u.map(f64::from));
        [x * self.across, y]
    }
}

impl Thin {
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<Self, CameraError> {
        let f_number = d.lens.f_number.unwrap_or(DEFAULT_F_NUMBER);
        Ok(Self {
            pinhole: Pinhole::new(d, axes, width, height),
            aperture: Aperture::new(d, f_number)?,
            mm_per_unit: d.scale_mm_per_unit.x,
            focus: d.focus_depth()?.unwrap_or(f64::INFINITY),
            // The irradiance behind a lens without aberration, focused far away.
            brightness: d.brightness(FRAC_PI_4 / (f_number * f_number)) as f32,
        })
    }

    /// Radius of the opening, half of its height, Blender units.
    pub(in crate::camera) fn radius(&self) -> f64 {
        self.aperture.diaphragm.radius_mm() / self.mm_per_unit
    }

    /// The picture point of a subject along `d` from the point `start` of the opening, both in camera space; `None` behind the camera.
    pub(in crate::camera) fn place(&self, start: DVec3, d: DVec3) -> Option<DVec2> {
        let along = if self.focus.is_finite() { start + d * (self.focus / -d.z) } else { d };
        (d.z < 0.0).then(|| self.pinhole.place(along)).flatten()
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        self.pinhole.axes()
    }

    /// A ray of a picture point through the point of the aperture that `u` chooses.
    #[inline]
    pub fn sample(&self, p: Vec2, u: [f32; 2]) -> CameraRay {
        let [x, y] = self.aperture.sample(u);
        let start = DVec3::new(x, y, 0.0) / self.mm_per_unit;
        let along = self.pinhole.at_unit_depth(p);
        let d = if self.focus.is_finite() { along * self.focus - start } else { along };
        let axes = self.pinhole.axes();
        let ray = Ray::new((*axes * start).as_vec3a(), (*axes * d).normalize().as_vec3a());
        CameraRay { ray, weight: Mat3::IDENTITY * self.brightness }
    }
}
