//! Cameras: weighted rays into the scene from points of the picture, by one of several models of a camera.
//!
//! The only place where lens millimetres meet world units. Picture coordinates are fractions of the picture's
//! width and height from its centre, right and up as one looks at the finished picture: -1/2 to 1/2.

pub mod clip;
mod description;
pub mod exposure;
pub mod lens;
pub mod models;
mod read_files;
pub mod scattering;
pub mod shutter;
pub mod stereo;
pub mod tools;

pub(crate) use description::unit_axes;
pub use description::{CalibrationSettings, CameraDescription, EnabledEffects, Model, Spectrum};
pub use models::calibrated::calibration_of;
pub use read_files::ReadFiles;

use crate::Rgb;
use crate::accel::Ray;
use glam::{DMat3, DVec3, Mat3, Vec2, Vec3};
use lens::real_lens::RealLens;
use lens::real_lens::batch::LensBatch;
use lens::real_lens::packet::Request;
use lens::setup::LensInfo;
use models::adapted::Adapted;
use models::calibrated::Calibrated;
use models::gaussian::{Gaussian, Order};
use models::image_based::ImageBased;
use models::orthographic::Orthographic;
use models::panoramic::Panoramic;
use models::pinhole::Pinhole;
use models::thin::Thin;
use petzval_optics::autofocus::{AutofocusError, SharpPlaneError};
use petzval_optics::axial_beam;
use petzval_optics::focus::FocusError;
use petzval_optics::formats::lens::LensFileError;
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::unobstructed_part;
use petzval_optics::system::{System, SystemError};
use std::sync::Arc;
use stereo::Eye;

/// An error by which a camera cannot photograph.
#[derive(Debug, thiserror::Error)]
pub enum CameraError {
    /// The lens file is missing or wrong.
    #[error(transparent)]
    Lens(#[from] LensFileError),
    /// The lens cannot be set as asked.
    #[error("lens '{lens}': {source}")]
    System {
        /// Name of the lens: that in its file, else that of the file.
        lens: String,
        /// The reason why the lens cannot be set so.
        source: SystemError,
    },
    /// The lens cannot be focused as asked.
    #[error("camera '{camera}': {source}")]
    Focus {
        /// Name of the camera's object in Blender.
        camera: String,
        /// The reason why the lens cannot be focused so.
        source: FocusError,
    },
    /// The autofocus point cannot be made sharp.
    #[error("camera '{camera}': the autofocus point: {source}")]
    Autofocus {
        /// Name of the camera's object in Blender.
        camera: String,
        /// The reason why the autofocus point cannot be sharp.
        source: AutofocusError,
    },
    /// Three points cannot be sharp at once.
    #[error("camera '{camera}': {source}")]
    SharpPlane {
        /// Name of the camera's object in Blender.
        camera: String,
        /// The reason why the three points cannot be sharp at once.
        source: SharpPlaneError,
    },
    /// A setting out of range.
    #[error("camera '{camera}': {what}")]
    Setting {
        /// Name of the camera's object in Blender.
        camera: String,
        /// The setting, and the remedy.
        what: String,
    },
}

/// A ray into the scene and the factor of its radiance in the picture's colour.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// The ray, render space.
    pub ray: Ray,
    /// Averages to the picture's brightness: to the identity in the middle of the film.
    pub weight: Mat3,
}

impl CameraRay {
    /// The light of a white world of radiance one.
    pub fn white(&self) -> Rgb {
        self.weight * Rgb::ONE
    }
}

/// A camera ready to photograph. A clone shares its tables.
#[derive(Clone)]
pub enum Camera {
    /// A point that all rays go through.
    Pinhole(Pinhole),
    /// A disk, polygon or mask that focuses without aberration.
    Thin(Thin),
    /// A lens whose every ray is traced through its surfaces.
    Lens(Arc<RealLens>),
    /// A real lens to first order.
    Gaussian(Arc<Gaussian>),
    /// A real lens as a table.
    ImageBased(Arc<ImageBased>),
    /// A real lens of which some effects are taken out.
    Adapted(Arc<Adapted>),
    /// No lens: parallel rays.
    Orthographic(Orthographic),
    /// No lens: a panoramic projection.
    Panoramic(Box<Panoramic>),
    /// No lens: the rays of a camera calibration.
    Calibrated(Box<Calibrated>),
    /// One eye of one without a lens file, in spherical stereo.
    Eye(Box<Eye>),
}

impl Camera {
    /// Checks a description and prepares its model for a picture of that many pixels.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn new(d: &CameraDescription, width: u32, height: u32) -> Result<Self, CameraError> {
        d.check(width, height)?;
        let axes = d.axes()?;
        let camera = match d.model {
            Model::Pinhole => Self::Pinhole(Pinhole::new(d, axes, width, height)),
            Model::Thin => Self::Thin(Thin::new(d, axes, width, height)?),
            Model::Lens if !d.shown.is_traced_plainly() => {
                Self::Adapted(Arc::new(Adapted::new(d, axes, width, height)?))
            }
            Model::Lens => Self::Lens(Arc::new(RealLens::new(d, axes, width, height)?)),
            Model::Thick => Self::Gaussian(Arc::new(Gaussian::new(Order::Thick, d, axes, width, height)?)),
            Model::Paraxial => Self::Gaussian(Arc::new(Gaussian::new(Order::Paraxial, d, axes, width, height)?)),
            Model::ImageBased => Self::ImageBased(Arc::new(ImageBased::new(d, axes, width, height)?)),
            Model::Orthographic => Self::Orthographic(Orthographic::new(d, axes, width, height)),
            Model::Panoramic => Self::Panoramic(Box::new(Panoramic::new(d, axes)?)),
            Model::Calibrated => Self::Calibrated(Box::new(Calibrated::new(d, axes, width, height)?)),
        };
        Ok(match d.spherical_stereo {
            Some(stereo) => Self::Eye(Box::new(Eye::new(camera, stereo))),
            None => camera,
        })
    }

    /// A ray for the picture point `p`, or `None` where it is lost in the lens or where a panoramic projection or a calibration shows nothing. `u_lens`
    /// chooses the point of the pupil, `u_wavelength` the wavelength.
    #[inline]
    pub fn sample(&self, p: Vec2, u_lens: [f32; 2], u_wavelength: f32) -> Option<CameraRay> {
        match self {
            Self::Pinhole(c) => Some(c.ray(p)),
            Self::Thin(c) => Some(c.sample(p, u_lens)),
            Self::Lens(c) => c.sample(p, u_lens, u_wavelength),
            Self::Gaussian(c) => Some(c.sample(p, u_lens, u_wavelength)),
            Self::ImageBased(c) => c.sample(p, u_lens),
            Self::Adapted(c) => c.sample(p, u_lens, u_wavelength),
            Self::Orthographic(c) => Some(c.ray(p)),
            Self::Panoramic(c) => c.sample(p, u_lens),
            Self::Calibrated(c) => c.sample(p, u_lens, u_wavelength),
            Self::Eye(c) => c.sample(p, u_lens, u_wavelength),
        }
    }

    /// True if a sample depends on its wavelength or is carried back to the film: if not, [`Request`] needs no numbers for that.
    pub fn has_wavelengths(&self) -> bool {
        match self {
            Self::Pinhole(_) | Self::Thin(_) | Self::Orthographic(_) | Self::Panoramic(_) | Self::Eye(_) => false,
            Self::Calibrated(c) => c.is_coloured(),
            Self::Lens(_) | Self::Gaussian(_) | Self::ImageBased(_) | Self::Adapted(_) => true,
        }
    }

    /// Memory for batches, where there are any.
    pub fn batch(&self) -> Option<LensBatch> {
        match self {
            Self::Lens(lens) => Some(lens.batch()),
            Self::Adapted(lens) => lens.batch(),
            _ => None,
        }
    }

    /// Appends [`Self::sample`] for each request, to the last bit; `batch` is one of this camera's.
    pub fn sample_batch(&self, requests: &[Request], batch: Option<&mut LensBatch>, rays: &mut Vec<Option<CameraRay>>) {
        match (self, batch) {
            (Self::Lens(lens), Some(batch)) => lens.sample_batch(requests, batch, rays),
            (Self::Adapted(lens), Some(batch)) => lens.sample_batch(requests, batch, rays),
            (Self::Pinhole(pinhole), _) => rays.extend(requests.iter().map(|r| Some(pinhole.ray(r.place)))),
            _ => rays.extend(requests.iter().map(|r| self.sample(r.place, r.u_lens, r.u_wavelength))),
        }
    }

    /// The lens, if it is one that is traced both ways.
    pub fn traced_lens(&self) -> Option<&RealLens> {
        match self {
            Self::Lens(lens) => Some(lens),
            _ => None,
        }
    }

    /// Camera space (x right, y up, looking along -z) to render space.
    pub fn axes(&self) -> &DMat3 {
        match self {
            Self::Pinhole(c) => c.axes(),
            Self::Thin(c) => c.axes(),
            Self::Lens(c) => c.mount.axes(),
            Self::Gaussian(c) => c.axes(),
            Self::ImageBased(c) => c.axes(),
            Self::Adapted(c) => c.axes(),
            Self::Orthographic(c) => c.axes(),
            Self::Panoramic(c) => c.axes(),
            Self::Calibrated(c) => c.axes(),
            Self::Eye(c) => c.camera.axes(),
        }
    }

    /// Minus the gradient of depth over places, render space: the axis backwards; of a sheared camera it leans from it.
    pub(crate) fn backwards(&self) -> DVec3 {
        let axes = self.axes();
        axes.x_axis.cross(axes.y_axis) / axes.determinant()
    }

    /// True if depth is the distance from the camera: of a panoramic one as in Blender, and of a calibrated one that may see to its side.
    pub fn depth_is_distance(&self) -> bool {
        match self {
            Self::Panoramic(_) => true,
            Self::Calibrated(c) => !c.is_flat(),
            Self::Eye(eye) => eye.camera.depth_is_distance(),
            _ => false,
        }
    }

    /// Depth of a place in render space, Blender units: along the axis, or the distance ([`Self::depth_is_distance`]).
    pub fn depth(&self, position: Vec3) -> f32 {
        if self.depth_is_distance() { position.length() } else { -position.dot(self.backwards().as_vec3()) }
    }

    /// Name of the camera model in reports.
    pub fn name(&self) -> &str {
        match self {
            Self::Pinhole(_) => "pinhole",
            Self::Thin(_) => "thin lens",
            Self::Lens(lens) => &lens.info().lens_name,
            Self::Gaussian(lens) => &lens.info().lens_name,
            Self::ImageBased(lens) => &lens.info().lens_name,
            Self::Adapted(lens) => &lens.info().lens_name,
            Self::Orthographic(_) => "orthographic",
            Self::Panoramic(_) => "panoramic",
            Self::Calibrated(_) => "calibrated",
            Self::Eye(eye) => eye.camera.name(),
        }
    }
}

/// Data of a real lens in this camera, without preparing to render; quick enough for a panel.
///
/// # Errors
/// As [`Camera::new`].
pub fn lens_info(d: &CameraDescription, width: u32, height: u32) -> Result<LensInfo, CameraError> {
    d.check(width, height)?;
    lens::setup::Setup::new(d, width, height).map(|setup| setup.info)
}

/// The T-number of a lens before a film at `film_z_mm`, lens space: the f-number of one that loses nothing, has nothing in its middle,
/// and is as bright in the film's middle, for white light. As f-numbers are, it is that of the lens at infinity, whatever its groups are
/// focused on. `None`: that is dark, or the lens has no focal length.
pub fn t_number(system: &System, wavelength_nm: f64, film_z_mm: f64) -> Option<f64> {
    let clear = unobstructed_part(&system.at_wavelength(wavelength_nm), system, film_z_mm);
    let part = clear * lens::transmission::luminous(system, wavelength_nm, film_z_mm)?;
    let at_infinity = f_number_at_infinity(system, axial_beam::f_number(system, wavelength_nm)?);
    Some(at_infinity / part.sqrt()).filter(|n| n.is_finite())
}

/// An f-number of the lens as its groups stand, counted at infinity, as f-numbers are called: groups that focus change focal length and
/// pupil.
pub(crate) fn f_number_at_infinity(system: &System, f_number: f64) -> f64 {
    let now = Paraxial::new(system, line_nm::D).f_number;
    f_number * now.map_or(1.0, |now| system.f_number() / now)
}

#[cfg(test)]
pub(crate) mod tests;
