//! A calibrated camera: the rays of a camera calibration, with depth of field as of a thin lens if wanted.

use super::thin::Aperture;
use crate::accel::Ray;
use crate::camera::models::photographic;
use crate::camera::{CalibrationSettings, CameraDescription, CameraError, CameraRay};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec2, Vec3};
use petzval_optics::calibration::{Calibration, Outside, PhotographicLens, Survey};
use petzval_optics::formats::calibration;
use petzval_optics::lensfun::lateral_colour::Channel;
use petzval_pictures::channels;
use std::sync::Arc;

/// A camera whose rays are those of a calibration.
#[derive(Clone)]
pub struct Calibrated {
    axes: DMat3,
    calibration: Arc<Calibration>,
    /// The lens of which vignetting or lateral colour are shown.
    lens: Option<Arc<PhotographicLens>>,
    is_darkened: bool,
    is_coloured: bool,
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

/// The rays of a calibrated camera, and the lens that was measured where a lensfun database has them.
type Found = (Calibration, Option<PhotographicLens>);

/// The calibration of a camera for a picture of that many pixels.
///
/// # Errors
/// [`CameraError`]: the file is missing or wrong, or the picture has another shape than the calibrated one.
pub fn calibration_of(d: &CameraDescription, width: u32, height: u32) -> Result<Calibration, CameraError> {
    found_of(d, width, height).map(|(calibration, _)| calibration)
}

fn found_of(d: &CameraDescription, width: u32, height: u32) -> Result<Found, CameraError> {
    let settings = d.calibration.as_ref().filter(|settings| !settings.path.as_os_str().is_empty());
    let settings = settings.ok_or_else(|| d.error("a calibrated camera needs a calibration; choose its file"))?;
    if settings.is_of_lensfun() {
        let lens = photographic::lens_of(d, settings, width, height)?;
        return Ok((lens.calibration.clone(), Some(lens)));
    }
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
    Ok((found, None))
}

/// An ST map on the pinhole of Blender's own camera.
fn st_map(
    d: &CameraDescription,
    settings: &CalibrationSettings,
    width: u32,
    height: u32,
) -> Result<Calibration, CameraError> {
    let file = settings.path.display();
    let picture = d.read_files.map.get(&settings.path, || channels::read(&settings.path, &["R", "G"], "A"));
    let picture = picture.map_err(|error| d.error(error.to_string()))?;
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
        let (calibration, lens) = found_of(d, width, height)?;
        let film_width_mm = lens.as_ref().map_or(d.perspective.film_width_mm, PhotographicLens::film_width_mm);
        let opening = |f_number| Opening::new(d, &calibration, film_width_mm, f_number);
        let opening = d.lens.f_number.map(opening).transpose()?;
        let size_px = DVec2::from_array(calibration.size_px().map(f64::from));
        let is_darkened = d.shown.vignetting && lens.as_ref().is_some_and(PhotographicLens::has_vignetting);
        let is_coloured = d.shown.lateral_colour && lens.as_ref().is_some_and(PhotographicLens::has_lateral_colour);
        let lens = lens.filter(|_| is_darkened || is_coloured).map(Arc::new);
        Ok(Self { axes, calibration: Arc::new(calibration), lens, is_darkened, is_coloured, size_px, opening })
    }

    /// True if red, green and blue light have rays of their own, of which `u_wavelength` of [`Self::sample`] chooses.
    pub(in crate::camera) fn is_coloured(&self) -> bool {
        self.is_coloured
    }

    /// A ray of a picture point through the point of the opening that `u` chooses; `None` where the calibration sees nothing.
    #[inline]
    pub fn sample(&self, p: Vec2, u: [f32; 2], u_wavelength: f32) -> Option<CameraRay> {
        let (towards, weight) = match &self.lens {
            None => (self.direction(p.as_dvec2()).ok()?, Mat3::IDENTITY),
            Some(lens) => self.through_lens(lens, self.pixel(p.as_dvec2()), u_wavelength)?,
        };
        let (start, towards) = match &self.opening {
            None => (DVec3::ZERO, towards),
            Some(opening) => opening.through(towards, u),
        };
        let ray = Ray::new((self.axes * start).as_vec3a(), (self.axes * towards).as_vec3a());
        Some(CameraRay { ray, weight })
    }

    /// The unit direction at a pixel, camera space, and the weight of its light, by a photographic lens; `None` where it is dark.
    fn through_lens(&self, lens: &PhotographicLens, pixel: DVec2, u_wavelength: f32) -> Option<(DVec3, Mat3)> {
        let illumination = if self.is_darkened { lens.illumination(pixel)? as f32 } else { 1.0 };
        if !self.is_coloured {
            return Some((to_camera_space(lens.calibration.unproject(pixel).ok()?), Mat3::IDENTITY * illumination));
        }
        // A third of the samples are red, a third green, a third blue.
        let (seen, channel) = match u_wavelength {
            u if u < 1.0 / 3.0 => (lens.unproject(pixel, Channel::Red), Vec3::X),
            u if u < 2.0 / 3.0 => (lens.calibration.unproject(pixel), Vec3::Y),
            _ => (lens.unproject(pixel, Channel::Blue), Vec3::Z),
        };
        Some((to_camera_space(seen.ok()?), Mat3::from_diagonal(channel * (3.0 * illumination))))
    }

    /// The measures of the lens's effects beside its rays, each the largest over the picture: vignetting in stops, lateral colour in
    /// pixels. `None`: it was not measured.
    pub fn beside_rays(&self) -> [Option<f64>; 2] {
        let Some(lens) = &self.lens else { return [None; 2] };
        let steps = [0.0, 0.25, 0.5, 0.75, 1.0];
        let points = || steps.iter().flat_map(|y| steps.iter().map(|x| DVec2::new(*x, *y) * self.size_px));
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let dark = |point| lens.illumination(point).map_or(f64::INFINITY, |light| light.log2().abs());
        let colour = |point| {
            let of = |channel| lens.lateral_px(point, channel);
            let (red, blue) = (of(Channel::Red), of(Channel::Blue));
            red.max(blue).max(0.0) - red.min(blue).min(0.0)
        };
        [
            lens.has_vignetting().then(|| largest(&mut points().map(dark))),
            lens.has_lateral_colour().then(|| largest(&mut points().map(colour))),
        ]
    }

    /// The unit direction of a picture point, camera space.
    fn direction(&self, p: DVec2) -> Result<DVec3, Outside> {
        self.calibration.unproject(self.pixel(p)).map(to_camera_space)
    }

    fn pixel(&self, p: DVec2) -> DVec2 {
        DVec2::new(p.x + 0.5, 0.5 - p.y) * self.size_px
    }

    /// The picture point of a direction in camera space; `None` where the calibration has none.
    pub(in crate::camera) fn place(&self, d: DVec3) -> Option<DVec2> {
        let pixel = self.calibration.project(to_camera_space(d)).ok()?;
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

/// The map from OpenCV's axes, which are right, down and ahead, to the camera's, or back.
fn to_camera_space(d: DVec3) -> DVec3 {
    DVec3::new(d.x, -d.y, -d.z)
}

impl Opening {
    fn new(
        d: &CameraDescription,
        calibration: &Calibration,
        film_width_mm: f64,
        f_number: f64,
    ) -> Result<Self, CameraError> {
        let [focal_px, _] = calibration
            .focal_px()
            .ok_or_else(|| d.error("the calibration does not see straight ahead, where a lens for its blur would stand; switch depth of field off"))?;
        let focal_length_mm = focal_px / f64::from(calibration.size_px()[0]) * film_width_mm;
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
    /// Sentences on a calibrated camera: the part of its picture that shows nothing and why, and the effects of its lens that were not
    /// measured.
    ///
    /// # Errors
    /// As [`calibration_of`].
    pub fn calibration_remarks(&self, [width, height]: [u32; 2]) -> Result<Vec<String>, CameraError> {
        let (calibration, lens) = found_of(self, width, height)?;
        let named = |what: &str| format!("Camera '{}': {what}", self.object_name);
        let mut remarks: Vec<String> = lens.iter().flat_map(|lens| &lens.remarks).map(|remark| named(remark)).collect();
        let Survey { covered, reason, fold_rad, .. } = calibration.survey();
        if let Some(reason) = reason {
            let valid = fold_rad.map_or_else(String::new, |angle| {
                format!(", valid to {:.1} degrees from the axis", angle.to_degrees())
            });
            let dark = 100.0 * (1.0 - covered);
            remarks.push(named(&format!(
                "{dark:.1} % of the picture is black, outside of its calibration: {reason}{valid}"
            )));
        }
        Ok(remarks)
    }

    /// The lens of a calibrated camera that a lensfun database has; `None` of other calibrations.
    ///
    /// # Errors
    /// As [`calibration_of`].
    pub fn photographic_lens(&self, [width, height]: [u32; 2]) -> Result<Option<PhotographicLens>, CameraError> {
        Ok(found_of(self, width, height)?.1)
    }
}

#[cfg(test)]
mod tests;
