//! The settings of a camera, unchecked, their defaults, and the checks that every model needs.

use super::exposure::PhysicalExposure;
use super::lens::real_lens::precision::Precision;
use super::scattering::Scattering;
use super::stereo::SphericalStereo;
use super::{CameraError, ReadFiles};
use crate::projection::Panorama;
use crate::sensor::film::{self, FilmSensor};
use crate::spectrum::{FilmSpectrum, SPECTRAL_COUNT};
use glam::{DMat3, DMat4, DVec3};
use petzval_optics::focus::Focusing;
use petzval_optics::system::LensSettings;
use serde::{Deserialize, Deserializer};
use std::path::PathBuf;

/// The model by which a camera makes its rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Model {
    /// Every ray traced through the prescription.
    #[default]
    Lens,
    /// A point that all rays go through: everything is sharp.
    Pinhole,
    /// A plane that bends light without aberration.
    Thin,
    /// The lens's principal planes and pupils at one wavelength.
    Thick,
    /// The lens's principal planes and pupils at every wavelength.
    Paraxial,
    /// A table of the lens's rays at one wavelength.
    ImageBased,
    /// No lens at all: parallel rays.
    Orthographic,
    /// No lens at all: a panoramic projection.
    Panoramic,
    /// No lens at all: the rays of a camera calibration.
    Calibrated,
}

impl Model {
    /// True if the rays are those of a lens file.
    pub fn is_of_lens(self) -> bool {
        match self {
            Self::Lens | Self::Thick | Self::Paraxial | Self::ImageBased => true,
            Self::Pinhole | Self::Thin | Self::Orthographic | Self::Panoramic | Self::Calibrated => false,
        }
    }

    /// True if the camera stands for a thing that is made of glass and metal, which a matrix cannot shear.
    fn is_rigid(self) -> bool {
        self.is_of_lens() || self == Self::Calibrated
    }
}

/// The wavelengths into which the film divides the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Spectrum {
    /// The visible range in [`SPECTRAL_COUNT`] wavelengths.
    #[default]
    Visible,
    /// One wavelength for each of red, green and blue (Lee, Eisemann and Seidel 2010).
    Three,
    /// All visible wavelengths in so many bands: enough where the lens spreads colours little.
    Bands(usize),
}

impl Spectrum {
    /// Number of wavelengths of the film.
    pub fn count(self) -> usize {
        match self {
            Self::Visible => SPECTRAL_COUNT,
            Self::Three => 3,
            Self::Bands(count) => count,
        }
    }
}

/// The effects of a traced lens that the picture shows; by default all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnabledEffects {
    /// Blur of subjects out of focus; if false, all rays go through the middle of the pupil.
    pub defocus: bool,
    /// Aberrations; if false, Gaussian optics make the image, with all else of the lens.
    pub aberration: bool,
    /// Distortion; if false, straight lines are straight.
    pub distortion: bool,
    /// Vignetting; if false, the picture is as bright everywhere as in its middle. Blur keeps its shapes.
    pub vignetting: bool,
    /// Lateral colour: the size of the image depends on the wavelength.
    pub lateral_colour: bool,
    /// Axial colour: the focus depends on the wavelength.
    pub axial_colour: bool,
}

impl Default for EnabledEffects {
    fn default() -> Self {
        Self {
            defocus: true,
            aberration: true,
            distortion: true,
            vignetting: true,
            lateral_colour: true,
            axial_colour: true,
        }
    }
}

impl EnabledEffects {
    /// True if the rays are those of the lens: all effects but vignetting are shown.
    pub fn is_traced_plainly(&self) -> bool {
        self.defocus && self.aberration && self.distortion && self.lateral_colour && self.axial_colour
    }
}

/// The perspective of Blender's own camera, which a pinhole and a thin lens have.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Perspective {
    /// Focal length on Blender's sensor, mm.
    pub focal_length_mm: f64,
    /// Width of the whole picture on Blender's sensor, mm.
    pub film_width_mm: f64,
    /// Shift, in units of the picture's larger side.
    pub shift: [f64; 2],
    /// Height over width of blur discs, as behind an anamorphic lens; 1 is round.
    pub aperture_ratio: f64,
}

/// The focus of a lens; a film distance goes before a point, a point before a distance.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FocusSettings {
    /// Focus distance along the axis from the reference point of `focusing`, Blender units; `None` is infinity.
    pub distance: Option<f64>,
    /// The reference point of the focus distance, and the part of the lens that stands at the camera's origin.
    pub focusing: Focusing,
    /// A point whose depth is focused on, world space.
    pub point_world: Option<DVec3>,
    /// Distance from the last vertex to the film's middle, mm.
    pub film_distance_mm: Option<f64>,
    /// The picture point, 0 to 1 from the lower left, on whose subject [`super::tools::autofocus`] is to focus; a camera itself leaves it
    /// out of account.
    pub autofocus: Option<[f64; 2]>,
}

/// The film behind a lens.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilmSettings {
    /// Width of the whole picture on the film, mm.
    pub width_mm: f64,
    /// Height of the whole picture on the film, mm.
    pub height_mm: f64,
    /// Turn about the horizontal axis.
    pub tilt_rad: f64,
    /// Turn about the vertical axis.
    pub swing_rad: f64,
    /// Shift of the lens to the right and up against the film: the picture moves the same way over the scene.
    pub shift_mm: [f64; 2],
}

/// The calibration of a camera, and the place of its file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationSettings {
    /// The file of calibrations, an ST map (`.exr`), a lensfun database (`.xml` or a folder of such), or the word `lensfun` for the database
    /// that is installed.
    pub path: PathBuf,
    /// The camera's name in the file, or the lens's in a lensfun database; `None` is the only one.
    pub camera: Option<String>,
    /// The camera body in a lensfun database, whose sensor the picture's diagonal is; `None` is Blender's sensor.
    pub body: Option<String>,
    /// The f-number of a lens's vignetting in a lensfun database.
    pub f_number: f64,
}

impl Default for CalibrationSettings {
    /// No file, at the f-number of Blender's cameras.
    fn default() -> Self {
        Self { path: PathBuf::new(), camera: None, body: None, f_number: 2.8 }
    }
}

/// The settings of a camera, unchecked. Angles in radians; `None` leaves the lens's own value.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraDescription {
    /// The camera's object, for messages.
    pub object_name: String,
    /// The model by which the camera makes its rays.
    pub model: Model,
    /// Camera space (x right, y up, looking along -z) to world space; its scale does not count. Deserialized row by row.
    #[serde(deserialize_with = "by_rows")]
    pub matrix_world: DMat4,
    /// The perspective of Blender's own camera.
    pub perspective: Perspective,
    /// The height of a pixel over its width.
    pub pixel_aspect: f64,
    /// Path of the lens file; a pinhole, a thin lens, an orthographic and a panoramic camera need none.
    pub lens_path: PathBuf,
    /// The files of the camera as they were read first.
    #[serde(skip)]
    pub read_files: ReadFiles,
    /// The settings of the lens. A thin lens takes f-number and diaphragm.
    pub lens: LensSettings,
    /// The settings of the focus.
    pub focus: FocusSettings,
    /// Size and pose of the film behind the lens.
    pub film: FilmSettings,
    /// Millimetres in the lens's space for a Blender unit along the camera's axes.
    pub scale_mm_per_unit: DVec3,
    /// One wavelength, nm; `None` is all that `spectrum` says.
    pub wavelength_nm: Option<f64>,
    /// The wavelengths of the film, for lenses that treat wavelengths differently.
    pub spectrum: Spectrum,
    /// The sensor whose channels see the wavelengths, by its name; `None`: the observer sees them.
    #[serde(deserialize_with = "film::by_name")]
    pub film_sensor: Option<FilmSensor>,
    /// The effects of the real lens that are shown; a plan decides on them.
    #[serde(skip)]
    pub shown: EnabledEffects,
    /// Scattering in the lens.
    pub scattering: Scattering,
    /// True if light is lost by reflection and absorption at surfaces and in glasses; a plan decides on it.
    #[serde(skip)]
    pub transmission: bool,
    /// True if the losses of `transmission` make the picture darker; else it is exposed by the T-number, its middle as bright as if nothing
    /// were lost.
    pub exposes_by_f_number: bool,
    /// True if white is white in the middle of the picture, whatever colour glass and coatings have.
    pub white_balance: bool,
    /// Precision of the numbers in which rays are traced from the film through the lens.
    pub precision: Precision,
    /// Exposure by physical settings; `None`: a uniform world of radiance one makes the middle of the film one, whatever the f-number.
    pub exposure: Option<PhysicalExposure>,
    /// Width of an orthographic picture, Blender units.
    pub orthographic_width: f64,
    /// The picture of a panoramic camera.
    pub panorama: Option<Panorama>,
    /// The calibration of a calibrated camera.
    pub calibration: Option<CalibrationSettings>,
    /// The eye that sees the picture in spherical stereo, of a camera without a lens file; `None`: the camera itself does.
    pub spherical_stereo: Option<SphericalStereo>,
    /// Clipping range along the camera's axis, of a panoramic camera by distance, Blender units: camera rays see nothing nearer than the first
    /// or farther than the second.
    pub clip: [f64; 2],
}

/// A matrix of a sequence of rows.
fn by_rows<'de, D: Deserializer<'de>>(from: D) -> Result<DMat4, D::Error> {
    <[[f64; 4]; 4]>::deserialize(from).map(|rows| DMat4::from_cols_array_2d(&rows).transpose())
}

impl Default for CameraDescription {
    /// A camera at the world's origin, before full-frame film; everything is seen. A lens is still to be named.
    fn default() -> Self {
        Self {
            object_name: "Camera".into(),
            model: Model::default(),
            matrix_world: DMat4::IDENTITY,
            perspective: Perspective {
                focal_length_mm: 50.0,
                film_width_mm: 36.0,
                shift: [0.0; 2],
                aperture_ratio: 1.0,
            },
            pixel_aspect: 1.0,
            lens_path: PathBuf::new(),
            read_files: ReadFiles::default(),
            lens: LensSettings::default(),
            focus: FocusSettings::default(),
            film: FilmSettings { width_mm: 36.0, height_mm: 24.0, tilt_rad: 0.0, swing_rad: 0.0, shift_mm: [0.0; 2] },
            scale_mm_per_unit: DVec3::splat(1000.0),
            wavelength_nm: None,
            spectrum: Spectrum::default(),
            film_sensor: None,
            shown: EnabledEffects::default(),
            scattering: Scattering::default(),
            transmission: false,
            exposes_by_f_number: false,
            white_balance: true,
            precision: Precision::default(),
            exposure: None,
            orthographic_width: 1.0,
            panorama: None,
            calibration: None,
            spherical_stereo: None,
            clip: [0.0, f64::INFINITY],
        }
    }
}

impl CameraDescription {
    /// The settings after a change.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// All visible wavelengths in so many bands, as the camera's film sees them.
    pub(crate) fn visible_in(&self, count: usize) -> FilmSpectrum {
        match &self.film_sensor {
            Some(sensor) => sensor.visible_in(count),
            None => FilmSpectrum::visible_in(count),
        }
    }

    pub(super) fn error(&self, what: impl Into<String>) -> CameraError {
        CameraError::Setting { camera: self.object_name.clone(), what: what.into() }
    }

    /// The camera's place in the world: render space's origin.
    pub fn position(&self) -> DVec3 {
        self.matrix_world.w_axis.truncate()
    }

    /// Camera axes in world space, of length one. A mirrored camera object mirrors its picture, as in Cycles. A sheared one shears the
    /// picture of a camera without a lens file, as in Cycles; a lens and a calibration are rigid, so that their axes are perpendicular.
    pub(crate) fn axes(&self) -> Result<DMat3, CameraError> {
        let axes = unit_axes(&self.matrix_world).ok_or_else(|| {
            self.error("its matrix is not finite or has no scale along two axes; reset the camera object's scale")
        })?;
        if !self.model.is_rigid() {
            return Ok(axes);
        }
        let z = axes.z_axis;
        // Axes that lie in one plane have none.
        let x = (axes.x_axis - z * axes.x_axis.dot(z)).normalize();
        Ok(DMat3::from_cols(x, z.cross(x) * axes.determinant().signum(), z))
    }

    /// Distance of the plane to be sharp along the axis, Blender units; `None` is infinity.
    pub(super) fn focus_depth(&self) -> Result<Option<f64>, CameraError> {
        if let Some(p) = self.focus.point_world {
            let depth = -(p - self.position()).dot(self.axes()?.z_axis);
            if !(depth > 0.0 && depth.is_finite()) {
                return Err(self.error("the focus object lies behind the camera or in it; move one of them"));
            }
            return Ok(Some(depth));
        }
        match self.focus.distance {
            Some(d) if d.is_nan() || d <= 0.0 => Err(self.error("the focus distance is not positive; raise it")),
            Some(d) if d.is_infinite() => Ok(None),
            d => Ok(d),
        }
    }

    /// The height of so many rows, in widths of a pixel.
    pub(super) fn rows_high(&self, rows: u32) -> f64 {
        f64::from(rows) * self.pixel_aspect
    }

    /// Checks the settings that every model needs.
    pub(super) fn check(&self, width: u32, height: u32) -> Result<(), CameraError> {
        if width == 0 || height == 0 {
            return Err(self.error("the picture has no pixels; raise the resolution"));
        }
        let positive = |value: f64, name: &str| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(self.error(format!("{name} is {value}; set it above zero")))
            }
        };
        let finite = [
            ("the rotation of its blades", self.lens.blade_rotation_rad),
            ("the curvature of its blades", self.lens.blade_curvature),
            ("the film's tilt", self.film.tilt_rad),
            ("the film's swing", self.film.swing_rad),
            ("the lens's shift to the right", self.film.shift_mm[0]),
            ("the lens's shift up", self.film.shift_mm[1]),
            ("the picture's shift to the right", self.perspective.shift[0]),
            ("the picture's shift up", self.perspective.shift[1]),
        ];
        if let Some((name, value)) = finite.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(self.error(format!("{name} is {value}; give a number, or look at its driver")));
        }
        if let Some(e) = self.exposure {
            positive(e.shutter_s, "the shutter time")?;
            positive(e.iso, "the film speed")?;
            positive(e.lumens_per_watt, "the lumens of a watt")?;
            if matches!(self.model, Model::Pinhole | Model::Orthographic | Model::Panoramic | Model::Calibrated) {
                return Err(
                    self.error("a camera without a lens has no f-number to expose by; switch physical exposure off")
                );
            }
        }
        if let Some(stereo) = self.spherical_stereo {
            stereo.check().map_err(|what| self.error(what))?;
            if self.model.is_of_lens() || matches!(self.model, Model::Orthographic | Model::Calibrated) {
                return Err(self
                    .error("spherical stereo is of perspective and panoramic cameras without a lens; switch it off"));
            }
        }
        self.scattering.check().map_err(|what| self.error(what))?;
        positive(self.perspective.aperture_ratio, "the height of what is out of focus over its width")?;
        positive(self.pixel_aspect, "the height of a pixel over its width")?;
        for value in self.scale_mm_per_unit.to_array() {
            positive(value, "a world-to-lens scale")?;
        }
        match self.model {
            Model::Lens | Model::Thick | Model::Paraxial | Model::ImageBased => {
                positive(self.film.width_mm, "the film width")?;
                positive(self.film.height_mm, "the film height")
            }
            Model::Orthographic => positive(self.orthographic_width, "the orthographic scale"),
            Model::Panoramic => {
                self.panorama.map_or(Ok(()), |panorama| panorama.check().map_err(|what| self.error(what)))
            }
            Model::Pinhole | Model::Thin | Model::Calibrated => {
                positive(self.perspective.focal_length_mm, "the focal length")?;
                positive(self.perspective.film_width_mm, "the sensor width")
            }
        }
    }
}

/// The determinant of axes of length one at which they count as lying in one plane.
const FLAT: f64 = 1e-6;

/// The axes of a matrix, of length one: what is left of it without its scale. One axis without length is perpendicular to the other two, as
/// if nothing were mirrored. `None` for axes in one plane, and where they are not finite.
pub(crate) fn unit_axes(matrix: &DMat4) -> Option<DMat3> {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().try_normalize());
    let [x, y, z] = match [x, y, z] {
        [None, Some(y), Some(z)] => [y.cross(z).try_normalize()?, y, z],
        [Some(x), None, Some(z)] => [x, z.cross(x).try_normalize()?, z],
        [Some(x), Some(y), None] => [x, y, x.cross(y).try_normalize()?],
        [x, y, z] => [x?, y?, z?],
    };
    let axes = DMat3::from_cols(x, y, z);
    (matrix.is_finite() && axes.determinant().abs() > FLAT).then_some(axes)
}
