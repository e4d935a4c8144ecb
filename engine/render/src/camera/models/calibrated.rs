//! A calibrated camera: the rays of a camera calibration, with depth of field as of a thin lens if wanted.

use super::thin::Aperture;
use crate::accel::Ray;
use crate::camera::{CalibrationSettings, CameraDescription, CameraError, CameraRay};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2};
use petzval_optics::calibration::{Calibration, Outside, Survey};
use petzval_optics::formats::calibration;
use petzval_pictures::channels;
use std::sync::Arc;

/// A camera whose rays are those of a calibration.
#[derive(Clone)]
pub struct Calibrated {
    axes: DMat3,
    calibration: Arc<Calibration>,
    size_px: DVec2,
    opening: Option<Opening>,
}

/// The opening of a camera with depth of field.
#[derive(Clone)]
struct Opening {
    aperture: Aperture,
    mm_per_unit: f64,
    /// Blender units; infinite for infinity.
    focus: f64,
    /// True if a plane across the axis is sharp, false if a sphere about the camera is.
    is_flat: bool,
}

/// The calibration of a camera for a picture of that many pixels.
///
/// # Errors
/// [`CameraError`]: the file is missing or wrong, or the picture has another shape than the calibrated one.
pub fn calibration_of(d: &CameraDescription, width: u32, height: u32) -> Result<Calibration, CameraError> {
    let settings = d.calibration.as_ref().filter(|settings| !settings.path.as_os_str().is_empty());
    let settings = settings.ok_or_else(|| d.error("a calibrated camera needs a calibration; choose its file"))?;
    let is_map = settings.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr"));
    let found = if is_map {
        st_map(d, settings, width, height)?
    } else {
        let file = calibration::read(&settings.path).map_err(|error| d.error(error.to_string()))?;
        file.camera(settings.camera.as_deref()).map_err(|error| d.error(error.to_string()))?.calibration.clone()
    };
    let [w, h] = found.size_px().map(f64::from);
    // Of the same shape as nearly as whole pixels allow.
    let own_height = f64::from(width) * h / w;
    let own_width = f64::from(height) * w / h;
    if (own_height - f64::from(height)).abs() >= 1.0 && (own_width - f64::from(width)).abs() >= 1.0 {
        return Err(d.error(format!(
            "the picture is {width} x {height} pixels and its calibration is of {w} x {h}, which has another shape; set a resolution of {} x {}",
            own_width.round().max(1.0),
            height
        )));
    }
    Ok(found)
}

/// An ST map on the pinhole of Blender's own camera.
fn st_map(
    d: &CameraDescription,
    settings: &CalibrationSettings,
    width: u32,
    height: u32,
) -> Result<Calibration, CameraError> {
    let file = settings.path.display();
    let picture = channels::read(&settings.path, &["R", "G"], "A").map_err(|error| d.error(error.to_string()))?;
    let pixel = |i: usize| {
        let is_there = picture.optional.as_ref().is_none_or(|alpha| alpha[i] > 0.0);
        is_there.then(|| [picture.needed[0][i], picture.needed[1][i]])
    };
    let [w, h] = picture.size;
    let places: Vec<_> = (0..w * h).map(pixel).collect();
    let focal = w as f64 * d.perspective.focal_length_mm / d.perspective.film_width_mm;
    // The shift of the picture moves the principal point the other way.
    let larger = f64::from(width).max(d.rows_high(height)) / f64::from(width) * w as f64;
    let [right, up] = d.perspective.shift.map(|shift| shift * larger);
    let parameters = [focal, focal, 0.5 * w as f64 - right, 0.5 * h as f64 + up];
    Calibration::of_st_map([w as u32, h as u32], &places, &parameters)
        .map_err(|error| d.error(format!("{file}: {error}; give the map that distorts a pinhole's picture")))
}

impl Calibrated {
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<Self, CameraError> {
        let calibration = calibration_of(d, width, height)?;
        let opening = d.lens.f_number.map(|f_number| Opening::new(d, &calibration, f_number)).transpose()?;
        let size_px = DVec2::from_array(calibration.size_px().map(f64::from));
        Ok(Self { axes, calibration: Arc::new(calibration), size_px, opening })
    }

    /// A ray of a picture point through the point of the opening that `u` chooses; `None` where the calibration sees nothing.
    #[inline]
    pub fn sample(&self, p: Vec2, u: [f32; 2]) -> Option<CameraRay> {
        let towards = self.direction(p.as_dvec2()).ok()?;
        let (start, towards) = match &self.opening {
            None => (DVec3::ZERO, towards),
            Some(opening) => opening.through(towards, u),
        };
        let ray = Ray::new((self.axes * start).as_vec3a(), (self.axes * towards).as_vec3a());
        Some(CameraRay { ray, weight: Mat3::IDENTITY })
    }

    /// The unit direction of a picture point, camera space.
    fn direction(&self, p: DVec2) -> Result<DVec3, Outside> {
        let pixel = DVec2::new(p.x + 0.5, 0.5 - p.y) * self.size_px;
        // OpenCV's axes are right, down and ahead.
        self.calibration.unproject(pixel).map(|d| DVec3::new(d.x, -d.y, -d.z))
    }

    /// The picture point of a direction in camera space; `None` where the calibration has none.
    pub(in crate::camera) fn place(&self, d: DVec3) -> Option<DVec2> {
        let pixel = self.calibration.project(DVec3::new(d.x, -d.y, -d.z)).ok()?;
        let part = pixel / self.size_px;
        Some(DVec2::new(part.x - 0.5, 0.5 - part.y))
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        &self.axes
    }

    /// True if the camera is a pinhole's but for its distortion, so that it sees nothing beside or behind it.
    pub(in crate::camera) fn is_flat(&self) -> bool {
        self.calibration.is_flat()
    }
}

impl Opening {
    fn new(d: &CameraDescription, calibration: &Calibration, f_number: f64) -> Result<Self, CameraError> {
        let [focal_px, _] = calibration
            .focal_px()
            .ok_or_else(|| d.error("the calibration does not see straight ahead, where a lens for its blur would stand; switch depth of field off"))?;
        let focal_length_mm = focal_px / f64::from(calibration.size_px()[0]) * d.perspective.film_width_mm;
        let is_flat = calibration.is_flat();
        let focus = match d.focus.point_world.filter(|_| !is_flat) {
            // A sphere goes through the subject, wherever it is.
            Some(point) => Some((point - d.position()).length()).filter(|distance| *distance > 0.0),
            None => d.focus_depth()?,
        };
        let as_long = d.clone().with(|d| d.perspective.focal_length_mm = focal_length_mm);
        Ok(Self {
            aperture: Aperture::new(&as_long, f_number)?,
            mm_per_unit: d.scale_mm_per_unit.x,
            focus: focus.unwrap_or(f64::INFINITY),
            is_flat,
        })
    }

    /// Origin and unit direction of the ray through a point of the opening. That of a lens with a flat field lies across the axis, another's
    /// across the ray, its first axis turned to the camera's.
    fn through(&self, towards: DVec3, u: [f32; 2]) -> (DVec3, DVec3) {
        let [x, y] = self.aperture.sample(u);
        let (start, reach) = if self.is_flat {
            (DVec3::new(x, y, 0.0) / self.mm_per_unit, self.focus / -towards.z)
        } else {
            let ahead = DVec3::NEG_Z;
            let first = (ahead - towards * towards.dot(ahead)).try_normalize().unwrap_or(DVec3::X);
            ((first * x + towards.cross(first) * y) / self.mm_per_unit, self.focus)
        };
        let direction = if reach.is_finite() { (towards * reach - start).normalize() } else { towards };
        (start, direction)
    }
}

impl CameraDescription {
    /// A sentence on what of a calibrated camera's picture shows nothing, and why; `None` if all of it shows something.
    ///
    /// # Errors
    /// As [`calibration_of`].
    pub fn calibration_complaint(&self, [width, height]: [u32; 2]) -> Result<Option<String>, CameraError> {
        let Survey { covered, reason, fold_rad, .. } = calibration_of(self, width, height)?.survey();
        let Some(reason) = reason else { return Ok(None) };
        let valid = fold_rad
            .map_or_else(String::new, |angle| format!(", valid to {:.1} degrees from the axis", angle.to_degrees()));
        let dark = 100.0 * (1.0 - covered);
        Ok(Some(format!(
            "Camera '{}': {dark:.1} % of the picture is black, outside of its calibration: {reason}{valid}",
            self.object_name
        )))
    }
}

#[cfg(test)]
mod tests;
