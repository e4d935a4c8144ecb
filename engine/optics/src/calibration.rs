//! Calibrated cameras: where in the picture a direction is seen, and back, by the models and numbers of camera calibrations.
//!
//! Camera space is OpenCV's: x right, y down, z ahead. Points are pixels from the picture's upper left corner, x right and y down, so that the
//! first pixel's middle is (0.5, 0.5). OpenCV, ROS and Kalibr count from that middle instead: their readers add 0.5, and their writers take it
//! off again.
//!
//! A direction becomes a point in three steps: a projection to a plane, a distortion of the plane, and a map that turns the plane
//! into pixels. A distortion is a formula one way and is solved the other way; it holds up to where it first folds back, which is found when a
//! calibration is made. Beyond there is no point and no direction, and a reason. See `docs/calibrated-cameras.md` for the equations.

mod chart;
mod error;
mod fit;
mod limit;
mod maps;
mod model;
pub mod photographic;
mod planar;
mod radial;
mod setup;
mod st_map;
mod survey;
mod warp;

pub use error::{CalibrationError, Outside};
pub use fit::{CameraToFit, FitError, FittedCalibration, SeenDirection, fit};
pub use maps::MapDirection;
pub use model::Model;
pub use photographic::PhotographicLens;
pub use survey::Survey;

use chart::Chart;
use glam::{DMat3, DVec2, DVec3};
use warp::Warp;

/// A camera as its calibration has it, checked.
#[derive(Clone, Debug)]
pub struct Calibration {
    model: Model,
    parameters: Vec<f64>,
    size_px: [u32; 2],
    chart: Chart,
    warp: Warp,
    /// True if the distortion's formula leads from the picture to the plane of the projection.
    is_from_picture: bool,
    /// The maps from the plane behind the distortion, as (x, y, 1), to pixels, and back.
    film: DMat3,
    film_inverse: DMat3,
}

impl Calibration {
    /// The camera of a model's parameters, in the order of [`Model::parameter_names`], for a picture of that many pixels. An ST map is made
    /// by [`Self::of_st_map`].
    ///
    /// # Errors
    /// [`CalibrationError`].
    pub fn new(model: Model, size_px: [u32; 2], parameters: &[f64]) -> Result<Self, CalibrationError> {
        setup::of_parameters(model, size_px, parameters)
    }

    /// The camera of an ST map: for each pixel of the picture, by row from the top, then column, the place in a pinhole's picture of the
    /// point that it shows, 0 to 1 from the lower left corner; `None`: nothing. `parameters`: the pinhole's focal lengths and principal
    /// point, pixels of a picture as large as the map.
    ///
    /// # Errors
    /// [`CalibrationError`].
    pub fn of_st_map(
        size_px: [u32; 2],
        places: &[Option<[f32; 2]>],
        parameters: &[f64],
    ) -> Result<Self, CalibrationError> {
        setup::of_st_map(size_px, places, parameters)
    }

    /// This camera with other parameters, of the same model and picture.
    ///
    /// # Errors
    /// [`CalibrationError`]; a table keeps its parameters.
    pub fn with_parameters(&self, parameters: &[f64]) -> Result<Self, CalibrationError> {
        Self::new(self.model, self.size_px, parameters)
    }

    /// The model.
    pub fn model(&self) -> Model {
        self.model
    }

    /// The parameters in the order of [`Model::parameter_names`].
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// A parameter by name; `None`: the model has none of that name.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        let place = self.model.parameter_names().iter().position(|known| *known == name)?;
        self.parameters.get(place).copied()
    }

    /// Width and height of the picture, pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// The point at which a direction is seen, pixels from the picture's upper left corner; it may lie outside of the picture.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn project(&self, direction: DVec3) -> Result<DVec2, Outside> {
        let largest = direction.abs().max_element();
        if !(largest > 0.0 && direction.is_finite()) {
            return Err(Outside::NotFinite);
        }
        let unit = (direction / largest).normalize();
        let plane = self.chart.point(unit).ok_or(Outside::Projection)?;
        let distorted = if self.is_from_picture { self.warp.back(plane) } else { self.warp.forth(plane) };
        let on_film = self.film * distorted.ok_or(Outside::Fold)?.extend(1.0);
        let point = on_film.truncate() / on_film.z;
        match on_film.z > 0.0 {
            true if point.is_finite() => Ok(point),
            true => Err(Outside::NotFinite),
            false => Err(Outside::Horizon),
        }
    }

    /// The unit direction that is seen at a point, pixels from the picture's upper left corner; the point may lie outside of the picture.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn unproject(&self, point: DVec2) -> Result<DVec3, Outside> {
        if !point.is_finite() {
            return Err(Outside::NotFinite);
        }
        let before_film = self.film_inverse * point.extend(1.0);
        if !(before_film.z > 0.0) {
            return Err(Outside::Horizon);
        }
        let distorted = before_film.truncate() / before_film.z;
        let plane = if self.is_from_picture { self.warp.forth(distorted) } else { self.warp.back(distorted) };
        self.chart.direction(plane.ok_or(Outside::Fold)?).ok_or(Outside::Projection)
    }

    /// True if the camera is a pinhole's but for its distortion, so that a plane across its axis is all sharp at once.
    pub fn is_flat(&self) -> bool {
        self.model.is_flat()
    }

    /// Focal lengths along x and y, pixels: the width and the height of a small angle about the axis over the angle in radians.
    ///
    /// `None`: straight ahead is not seen.
    pub fn focal_px(&self) -> Option<[f64; 2]> {
        let step = 1e-4;
        let at = |x: f64, y: f64| self.project(DVec3::new(x, y, 1.0)).ok();
        let [right, left, down, up] = [at(step, 0.0)?, at(-step, 0.0)?, at(0.0, step)?, at(0.0, -step)?];
        let focal = [(right - left).length() / (2.0 * step), (down - up).length() / (2.0 * step)];
        focal.iter().all(|f| f.is_finite()).then_some(focal)
    }
}

#[cfg(test)]
mod tests;
