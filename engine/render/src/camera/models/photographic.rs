//! A camera's lens of a lensfun database, at the camera's settings.

use crate::camera::{CalibrationSettings, CameraDescription, CameraError};
use petzval_optics::calibration::PhotographicLens;
use petzval_optics::calibration::photographic::PhotographicSetting;
use petzval_optics::lensfun::{CalibratedLens, Database, FULL_DIAGONAL_MM, LensfunError};

/// The word for the installed database.
const INSTALLED: &str = "lensfun";

impl CalibrationSettings {
    /// True if the calibration is a lens of a lensfun database.
    pub fn is_of_lensfun(&self) -> bool {
        let is_xml = self.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml"));
        is_xml || self.path.as_os_str() == INSTALLED || self.path.is_dir()
    }

    /// The lensfun database that the settings name.
    ///
    /// # Errors
    /// [`LensfunError`].
    pub fn database(&self) -> Result<Database, LensfunError> {
        if self.path.as_os_str() == INSTALLED { Database::installed() } else { Database::read(&self.path) }
    }

    /// The lens of the settings in their database.
    fn lens(&self, database: &Database) -> Result<CalibratedLens, LensfunError> {
        match (&self.camera, database.lenses()) {
            (Some(name), _) => database.find(name),
            (None, [only]) => Ok(only.clone()),
            (None, several) => Err(LensfunError::NotChosen { count: several.len() }),
        }
    }
}

/// The lens of a camera for a picture of that many pixels.
///
/// # Errors
/// [`CameraError`]: the database or a name in it is missing, or the lens makes no camera at this setting.
pub(super) fn lens_of(
    d: &CameraDescription,
    settings: &CalibrationSettings,
    width: u32,
    height: u32,
) -> Result<PhotographicLens, CameraError> {
    let database = d
        .read_files
        .database
        .get(&settings.path, || settings.database())
        .map_err(|error| d.error(error.to_string()))?;
    let lens = settings.lens(&database).map_err(|error| d.error(error.to_string()))?;
    let body = settings.body.as_deref().map(|name| database.body(name)).transpose();
    let body = body.map_err(|error| d.error(error.to_string()))?;
    let [across, up] = [f64::from(width), d.rows_high(height)];
    let width_mm = match body {
        // The picture's diagonal is the sensor's, as lensfun takes it.
        Some(body) => FULL_DIAGONAL_MM / body.crop_factor * across / across.hypot(up),
        None => d.perspective.film_width_mm,
    };
    let setting = PhotographicSetting {
        size_px: [width, height],
        film_mm: [width_mm, width_mm * up / across],
        focal_mm: d.perspective.focal_length_mm,
        f_number: settings.f_number,
        distance_m: d.focus_depth()?.map_or(f64::INFINITY, |units| units * d.scale_mm_per_unit.z * 1e-3),
    };
    PhotographicLens::new(&lens, &setting).map_err(|error| d.error(error.to_string()))
}
