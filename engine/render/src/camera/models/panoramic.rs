//! The panoramic camera, as Blender's: all rays of its picture through one point or one opening that turns with them.

use super::thin::Aperture;
use crate::accel::Ray;
use crate::camera::{CameraDescription, CameraError, CameraRay};
use crate::projection::Panorama;
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2};

/// A camera whose picture is a panoramic projection.
#[derive(Clone)]
pub struct Panoramic {
    axes: DMat3,
    panorama: Panorama,
    opening: Option<Opening>,
}

/// The opening of a camera with depth of field. Everything at the focus distance is sharp, whatever its direction.
#[derive(Clone)]
struct Opening {
    aperture: Aperture,
    mm_per_unit: f64,
    /// Blender units; infinite for infinity.
    focus: f64,
}

impl Panoramic {
    /// The camera of a description with a panorama; without an f-number everything is sharp.
    pub(in crate::camera) fn new(d: &CameraDescription, axes: DMat3) -> Result<Self, CameraError> {
        let panorama = d.panorama.ok_or_else(|| d.error("a panoramic camera needs a projection"))?;
        let opening = |f_number: f64| -> Result<Opening, CameraError> {
            Ok(Opening {
                aperture: Aperture::new(d, f_number)?,
                mm_per_unit: d.scale_mm_per_unit.x,
                focus: d.focus_depth()?.unwrap_or(f64::INFINITY),
            })
        };
        let opening = d.lens.f_number.map(opening).transpose()?;
        Ok(Self { axes, panorama, opening })
    }

    /// A ray of a picture point through the point of the opening that `u` chooses; `None` where the projection shows nothing.
    #[inline]
    pub fn sample(&self, p: Vec2, u: [f32; 2]) -> Option<CameraRay> {
        let towards = self.panorama.direction(p.as_dvec2())?;
        let (start, towards) = match &self.opening {
            None => (DVec3::ZERO, towards),
            Some(opening) => opening.through(towards, u),
        };
        let ray = Ray::new((self.axes * start).as_vec3a(), (self.axes * towards).normalize().as_vec3a());
        Some(CameraRay { ray, weight: Mat3::IDENTITY })
    }

    /// The picture point of a direction in camera space.
    pub(in crate::camera) fn place(&self, d: DVec3) -> Option<DVec2> {
        self.panorama.place(d)
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        &self.axes
    }
}

impl Opening {
    /// Origin and unit direction of the ray through a point of the opening, which lies across `towards`, its first axis turned to the
    /// camera's.
    fn through(&self, towards: DVec3, u: [f32; 2]) -> (DVec3, DVec3) {
        let [x, y] = self.aperture.sample(u);
        let ahead = DVec3::NEG_Z;
        let first = (ahead - towards * towards.dot(ahead)).try_normalize().unwrap_or(DVec3::X);
        let start = (first * x + towards.cross(first) * y) / self.mm_per_unit;
        let direction = if self.focus.is_finite() { (towards * self.focus - start).normalize() } else { towards };
        (start, direction)
    }
}
