//! A camera seen from the scene: where in the picture it shows a point, looked at through a given point of its pupil.
//!
//! It serves to find motion over the picture: a camera that stands, looks and is focused as it will be a frame later,
//! and of which no rays are asked, so that nothing has to be prepared for choosing them well.

use crate::accel::Ray;
use crate::camera::lens::mount::Mount;
use crate::camera::lens::real_lens::film_spectrum;
use crate::camera::lens::setup::D_LINE_NM;
use crate::camera::models::calibrated::Calibrated;
use crate::camera::models::gaussian::Order;
use crate::camera::models::orthographic::Orthographic;
use crate::camera::models::panoramic::Panoramic;
use crate::camera::models::pinhole::Pinhole;
use crate::camera::models::thin::Thin;
use crate::camera::{CameraDescription, CameraError, Model};
use crate::spectrum::FilmSpectrum;
use glam::{DMat3, DQuat, DVec2, DVec3};
use petzval_optics::entrance_map::EntranceMap;
use petzval_optics::gaussian::GaussianLens;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::trace::{Ray as LensRay, Tracer};

/// A subject of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeenPlace {
    /// A point, render space.
    Point(DVec3),
    /// A subject infinitely far in a direction.
    Direction(DVec3),
}

impl SeenPlace {
    /// The subject a part of the way from this one to another of its kind.
    pub fn towards(self, other: Self, part: f64) -> Self {
        match (self, other) {
            (Self::Point(a), Self::Point(b)) => Self::Point(a.lerp(b, part)),
            (Self::Direction(a), Self::Direction(b)) => Self::Direction(a.lerp(b, part)),
            _ => other,
        }
    }
}

/// A point of the pupil, so that cameras with different lenses can have the same: from the pupil's middle, its radius
/// being one, in axes that turn with the pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilPoint(DVec3);

/// A camera that shows where things lie in its picture.
pub struct Imaging {
    /// The camera's place in render space.
    place: DVec3,
    /// Directions of render space in camera space.
    to_camera: DMat3,
    eye: Eye,
}

enum Eye {
    Pinhole(Pinhole),
    Orthographic(Orthographic),
    Panoramic(Box<Panoramic>),
    Calibrated(Box<Calibrated>),
    Thin(Thin),
    Lens(Box<LensEye>),
}

/// A lens before a film.
struct LensEye {
    mount: Mount,
    spectrum: FilmSpectrum,
    /// The lens at each wavelength of the film.
    lines: Vec<ImagedLine>,
    /// The entrance pupil's middle near the axis and its radius, lens space, mm.
    pupil_middle: DVec3,
    pupil_radius: f64,
    /// The pupil by direction, where rays are traced.
    entrance: Option<EntranceMap>,
}

/// The entrance pupil as a point sees it: a fisheye's turns and moves towards the point.
struct SeenPupil {
    middle: DVec3,
    /// Direction to the point that sees it.
    towards: DVec3,
    /// Shortest turn from the axis' direction there.
    turn: DQuat,
}

enum ImagedLine {
    Traced(Tracer),
    Gaussian(GaussianLens),
}

impl ImagedLine {
    fn to_film(&self, ray: LensRay) -> Option<LensRay> {
        match self {
            Self::Traced(tracer) => tracer.from_scene(ray).ok(),
            Self::Gaussian(lens) => Some(lens.from_scene(&ray)),
        }
    }
}

impl Imaging {
    /// A camera in a render space with its origin at `origin` (world space), for a picture of that many pixels.
    ///
    /// # Errors
    /// As [`crate::camera::Camera::new`].
    pub fn new(d: &CameraDescription, width: u32, height: u32, origin: DVec3) -> Result<Self, CameraError> {
        d.check(width, height)?;
        let axes = d.axes()?;
        let lens = |order: Option<Order>| -> Result<Eye, CameraError> {
            Ok(Eye::Lens(Box::new(LensEye::new(order, d, axes, width, height)?)))
        };
        let eye = match d.model {
            Model::Pinhole => Eye::Pinhole(Pinhole::new(d, axes, width, height)),
            Model::Orthographic => Eye::Orthographic(Orthographic::new(d, axes, width, height)),
            Model::Panoramic => Eye::Panoramic(Box::new(Panoramic::new(d, axes)?)),
            Model::Calibrated => Eye::Calibrated(Box::new(Calibrated::new(d, axes, width, height)?)),
            Model::Thin => Eye::Thin(Thin::new(d, axes, width, height)?),
            // The table differs from the lens by far less than things move.
            Model::Lens | Model::ImageBased => lens(None)?,
            Model::Thick => lens(Some(Order::Thick))?,
            Model::Paraxial => lens(Some(Order::Paraxial))?,
        };
        Ok(Self { place: d.position() - origin, to_camera: axes.inverse(), eye })
    }

    /// The point of the pupil through which a camera ray sees something.
    pub fn through(&self, ray: &Ray, seen: SeenPlace) -> PupilPoint {
        let origin = ray.origin.as_dvec3() - self.place;
        PupilPoint(match &self.eye {
            // Depth of field moves nothing that is in focus.
            Eye::Pinhole(_) | Eye::Orthographic(_) | Eye::Panoramic(_) | Eye::Calibrated(_) => DVec3::ZERO,
            Eye::Thin(lens) => self.to_camera * origin / lens.radius(),
            Eye::Lens(lens) => {
                let pupil = lens.pupil(self.relative(seen));
                let from = lens.mount.to_lens(origin) - pupil.middle;
                let along = lens.direction(ray.direction.as_dvec3());
                let met = from - along * (from.dot(pupil.towards) / along.dot(pupil.towards));
                pupil.turn.inverse() * met / lens.pupil_radius
            }
        })
    }

    fn relative(&self, seen: SeenPlace) -> SeenPlace {
        match seen {
            SeenPlace::Point(p) => SeenPlace::Point(p - self.place),
            other => other,
        }
    }

    /// The picture point of a subject seen through a point of the pupil, by light of the wavelength that `u_wavelength` chooses; `None`
    /// where the light is lost.
    pub fn picture_point(&self, seen: SeenPlace, through: PupilPoint, u_wavelength: f32) -> Option<DVec2> {
        let seen = self.relative(seen);
        let along = |start: DVec3| match seen {
            SeenPlace::Point(p) => self.to_camera * p - start,
            SeenPlace::Direction(d) => self.to_camera * d,
        };
        match &self.eye {
            Eye::Pinhole(camera) => camera.place(along(DVec3::ZERO)),
            Eye::Panoramic(camera) => camera.place(along(DVec3::ZERO)),
            Eye::Calibrated(camera) => camera.place(along(DVec3::ZERO)),
            // What is infinitely far is seen nowhere in particular.
            Eye::Orthographic(camera) => match seen {
                SeenPlace::Point(p) => Some(camera.place(self.to_camera * p)),
                SeenPlace::Direction(_) => None,
            },
            Eye::Thin(lens) => {
                let start = through.0 * lens.radius();
                lens.place(start, along(start))
            }
            Eye::Lens(lens) => {
                let pupil = lens.pupil(seen);
                let target = pupil.middle + pupil.turn * through.0 * lens.pupil_radius;
                let (origin, direction) = match seen {
                    SeenPlace::Point(p) => {
                        let from = lens.mount.to_lens(p);
                        (from, (target - from).normalize())
                    }
                    SeenPlace::Direction(d) => (target, -lens.direction(d)),
                };
                let line = &lens.lines[lens.spectrum.sample(u_wavelength)];
                lens.mount.picture_point(&line.to_film(LensRay { origin, direction })?).map(|p| p.as_dvec2())
            }
        }
    }
}

impl LensEye {
    fn new(
        order: Option<Order>,
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<Self, CameraError> {
        let (mount, system) = Mount::new(d, axes, width, height)?;
        let spectrum = match (order, d.model) {
            (Some(Order::Thick), _) | (None, Model::ImageBased) => {
                FilmSpectrum::single(d.wavelength_nm.unwrap_or(D_LINE_NM))
            }
            _ => film_spectrum(d, &system),
        };
        let line = |nm: f64| match order {
            None => ImagedLine::Traced(system.at_wavelength(nm)),
            Some(_) => ImagedLine::Gaussian(GaussianLens::new(&system, nm)),
        };
        let lines = spectrum.wavelengths().iter().map(|w| line(w.nm)).collect();
        let pupil = Paraxial::new(&system, d.wavelength_nm.unwrap_or(D_LINE_NM)).entrance_pupil;
        // A telecentric entrance has its pupil at infinity: the front glass stands for it.
        let (z, diameter) = match (pupil.z_mm, pupil.diameter_mm) {
            (Some(z), Some(diameter)) if diameter > 0.0 => (z, diameter),
            _ => (0.0, 2.0 * system.surfaces()[0].semi_diameter_mm),
        };
        let (pupil_middle, pupil_radius) = (DVec3::new(0.0, 0.0, z), 0.5 * diameter);
        let entrance = order.is_none().then(|| EntranceMap::new(&[system.at_wavelength(D_LINE_NM)], &system));
        Ok(Self { mount, spectrum, lines, pupil_middle, pupil_radius, entrance })
    }

    /// The pupil as something sees it that lies, in render space, as seen from the camera.
    fn pupil(&self, seen: SeenPlace) -> SeenPupil {
        let near_axis = self.entrance.as_ref().map_or(self.pupil_middle, EntranceMap::middle);
        let towards = match seen {
            SeenPlace::Point(p) => (self.mount.to_lens(p) - near_axis).normalize_or(DVec3::NEG_Z),
            SeenPlace::Direction(d) => self.direction(d),
        };
        let middle = self.entrance.as_ref().map_or(near_axis, |map| map.centre(towards));
        SeenPupil { middle, towards, turn: DQuat::from_rotation_arc(DVec3::NEG_Z, towards) }
    }

    /// A direction of render space in lens space.
    fn direction(&self, d: DVec3) -> DVec3 {
        (self.mount.to_lens(d) - self.mount.to_lens(DVec3::ZERO)).normalize()
    }
}
