//! A photographic lens by its measurement in a lensfun database, as the camera of a picture.

use super::{Calibration, CalibrationError, Model, Outside};
use crate::lensfun::lateral_colour::Channel;
use crate::lensfun::{CalibratedLens, Distortion, FULL_DIAGONAL_MM, LateralColour, Vignetting};
use glam::{DVec2, DVec3};
use thiserror::Error;

/// The setting of a photographic lens, and the picture behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotographicSetting {
    /// Width and height of the picture, pixels.
    pub size_px: [u32; 2],
    /// Width and height of the picture on the film, mm.
    pub film_mm: [f64; 2],
    /// The focal length that a zoom is set to, as it is marked, mm. A lens of one focal length has its own.
    pub focal_mm: f64,
    /// The f-number.
    pub f_number: f64,
    /// The distance of focus, m; infinite for infinity.
    pub distance_m: f64,
}

/// The reason why a lens of a lensfun database makes no camera.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PhotographicError {
    /// The pictures are panoramas that were joined.
    #[error("'{0}' makes panoramic pictures, of which lensfun has no projection; choose another lens")]
    Panoramic(String),
    /// A zoom does not reach the focal length.
    #[error("'{lens}' goes from {shortest} to {longest} mm, and {asked:.4} mm are asked for; change the focal length")]
    FocalLength {
        /// The lens.
        lens: String,
        /// The shortest focal length, mm.
        shortest: f64,
        /// The longest focal length, mm.
        longest: f64,
        /// The focal length that is asked for, mm.
        asked: f64,
    },
    /// The film is larger than the sensor with which the lens was measured.
    #[error(
        "'{lens}' was measured up to {measured_mm:.1} mm from the middle of the picture, and the film's corner lies at {corner_mm:.1} mm; set a smaller sensor, or the body that it was measured with"
    )]
    TooLarge {
        /// The lens.
        lens: String,
        /// Half of the diagonal of the largest sensor with which it was measured, mm.
        measured_mm: f64,
        /// Half of the diagonal of the film, mm.
        corner_mm: f64,
    },
    /// A setting is not a number above zero.
    #[error("the {what} is {value}; give a number above zero")]
    Setting {
        /// The setting.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// The measured numbers make no camera.
    #[error("'{lens}': {problem}")]
    Calibration {
        /// The lens.
        lens: String,
        /// The problem.
        problem: CalibrationError,
    },
}

/// A photographic lens on a camera: rays, vignetting and lateral colour, as they were measured.
#[derive(Clone, Debug)]
pub struct PhotographicLens {
    /// The rays of green light.
    pub calibration: Calibration,
    /// The name in the database, maker and model.
    pub name: String,
    /// The focal length that the lens is marked with at this setting, mm.
    pub marked_mm: f64,
    /// A line for each effect that was not measured for this setting.
    pub remarks: Vec<String>,
    vignetting: Option<Vignetting>,
    lateral_colour: Option<LateralColour>,
    centre_px: DVec2,
    mm_per_px: DVec2,
}

/// Part of a focal length by which a setting may lie beyond a zoom's ends: marks are rounded.
const ROUNDED: f64 = 0.02;
/// Lensfun's distance of infinity, m.
const FAR_M: f64 = 1000.0;

impl PhotographicLens {
    /// A lens at a setting.
    ///
    /// # Errors
    /// [`PhotographicError`].
    pub fn new(lens: &CalibratedLens, setting: &PhotographicSetting) -> Result<Self, PhotographicError> {
        let name = lens.name();
        check(setting)?;
        let projection = lens.projection.ok_or_else(|| PhotographicError::Panoramic(name.clone()))?;
        let marked_mm = marked_mm(lens, setting.focal_mm)?;
        let film_mm = DVec2::from_array(setting.film_mm);
        let crop_factor = FULL_DIAGONAL_MM / film_mm.length();
        let measured: Vec<f64> = lens
            .sets
            .iter()
            .filter(|set| !set.distortion.is_empty())
            .map(|set| set.sensor.half_diagonal_mm())
            .collect();
        let distortion = lens.distortion(crop_factor, marked_mm);
        if distortion.is_none() && !measured.is_empty() {
            let measured_mm = measured.into_iter().fold(0.0, f64::max);
            return Err(PhotographicError::TooLarge { lens: name, measured_mm, corner_mm: 0.5 * film_mm.length() });
        }
        let vignetting = lens.vignetting(crop_factor, marked_mm, setting.f_number, setting.distance_m.min(FAR_M));
        let lateral_colour = lens.lateral_colour(crop_factor, marked_mm);
        let mut remarks = Vec::new();
        let mut missing = |is_missing: bool, what: String| is_missing.then(|| remarks.push(format!("{name}: {what}")));
        missing(distortion.is_none(), "no distortion was measured: straight lines stay straight".to_owned());
        let near = format!("no vignetting was measured near F/{:.3} at {marked_mm:.4} mm", setting.f_number);
        missing(vignetting.is_none(), format!("{near}: the picture is as bright everywhere"));
        missing(lateral_colour.is_none(), "no lateral colour was measured".to_owned());
        let size = DVec2::from_array(setting.size_px.map(f64::from));
        let mm_per_px = film_mm / size;
        // Halves of the short side of the picture.
        let centre_mm = 0.5 * film_mm + DVec2::from_array(lens.centre) * 0.5 * film_mm.min_element();
        let centre_px = centre_mm / mm_per_px;
        let focal_mm = distortion.map_or(marked_mm, |distortion| distortion.real_focal_mm);
        let parameters = parameters(distortion.as_ref(), DVec2::splat(focal_mm) / mm_per_px, centre_px);
        let calibration = Calibration::new(Model::Lensfun(projection), setting.size_px, &parameters)
            .map_err(|problem| PhotographicError::Calibration { lens: name.clone(), problem })?;
        Ok(Self { calibration, name, marked_mm, remarks, vignetting, lateral_colour, centre_px, mm_per_px })
    }

    /// True if red and blue light have other rays than green.
    pub fn has_lateral_colour(&self) -> bool {
        self.lateral_colour.is_some()
    }

    /// True if the picture darkens towards its edges.
    pub fn has_vignetting(&self) -> bool {
        self.vignetting.is_some()
    }

    /// Width of the picture on the film, mm.
    pub fn film_width_mm(&self) -> f64 {
        self.mm_per_px.x * f64::from(self.calibration.size_px()[0])
    }

    /// Illumination at a point of the picture, pixels, over that in its middle; `None` where the formula leaves none.
    pub fn illumination(&self, point_px: DVec2) -> Option<f64> {
        let radius_mm = ((point_px - self.centre_px) * self.mm_per_px).length();
        self.vignetting.map_or(Some(1.0), |vignetting| vignetting.illumination(radius_mm))
    }

    /// The unit direction that is seen at a point of the picture, pixels, in red or blue light; camera space as of [`Calibration`].
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn unproject(&self, point_px: DVec2, channel: Channel) -> Result<DVec3, Outside> {
        let Some(colour) = &self.lateral_colour else { return self.calibration.unproject(point_px) };
        let place_mm = (point_px - self.centre_px) * self.mm_per_px;
        let green_mm = colour.green_mm(channel, place_mm).ok_or(Outside::Fold)?;
        self.calibration.unproject(green_mm / self.mm_per_px + self.centre_px)
    }

    /// The distance between a point in green light and its place in red or blue, pixels, along the radius; positive: farther out. 0 where no
    /// lateral colour was measured.
    pub fn lateral_px(&self, point_px: DVec2, channel: Channel) -> f64 {
        let Some(colour) = &self.lateral_colour else { return 0.0 };
        let green_mm = (point_px - self.centre_px) * self.mm_per_px;
        let off_px = (colour.place_mm(channel, green_mm) - green_mm) / self.mm_per_px;
        off_px.dot((point_px - self.centre_px).normalize_or_zero())
    }
}

fn check(setting: &PhotographicSetting) -> Result<(), PhotographicError> {
    let values = [
        ("focal length", setting.focal_mm),
        ("f-number", setting.f_number),
        ("distance of focus", setting.distance_m.min(FAR_M)),
        ("width of the film", setting.film_mm[0]),
        ("height of the film", setting.film_mm[1]),
    ];
    let bad = values.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite()));
    bad.map_or(Ok(()), |(what, value)| Err(PhotographicError::Setting { what, value }))
}

/// The marked focal length of a lens at a wanted one, mm: a lens of one focal length has its own.
fn marked_mm(lens: &CalibratedLens, focal_mm: f64) -> Result<f64, PhotographicError> {
    let [shortest, longest] = lens.focal_range_mm;
    if shortest == longest {
        return Ok(shortest);
    }
    if focal_mm < shortest * (1.0 - ROUNDED) || focal_mm > longest * (1.0 + ROUNDED) {
        return Err(PhotographicError::FocalLength { lens: lens.name(), shortest, longest, asked: focal_mm });
    }
    Ok(focal_mm.clamp(shortest, longest))
}

/// The parameters of [`Model::Lensfun`].
fn parameters(distortion: Option<&Distortion>, focal_px: DVec2, centre_px: DVec2) -> Vec<f64> {
    let mut parameters = vec![focal_px.x, focal_px.y, centre_px.x, centre_px.y];
    let (powers, tangential) = distortion.map_or(([0.0; 6], [0.0; 2]), Distortion::in_focal_lengths);
    parameters.extend(powers.into_iter().chain(tangential));
    parameters
}
