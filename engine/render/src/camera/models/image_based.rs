//! The image-based lens of Heidrich, Slusallek and Seidel 1997: the rays of a real lens from a table that was traced
//! before, so that the time of a ray does not grow with the number of surfaces.
//!
//! Kept, at one wavelength: defocus, distortion, field curvature, the other aberrations as finely as the
//! [table](petzval_optics::ray_table), vignetting, blades, exposure, turned and shifted film. Lost: colour, for which the
//! table has one wavelength, and the last digits. The original aims a picture for each point of the pupil and
//! lets graphics hardware interpolate; here each camera ray is interpolated by itself, by cubics.
//!
//! Points of the pupil are chosen and weighted as for the real lens.

use crate::camera::lens::mount::Mount;
use crate::camera::lens::real_lens::dark;
use crate::camera::lens::setup::LensInfo;
use crate::camera::lens::transmission::Middle;
use crate::camera::{CameraDescription, CameraError, CameraRay};
use crate::spectrum::FilmSpectrum;
use glam::{DMat3, Mat3, Vec2};
use petzval_optics::focus::FilmPoint;
use petzval_optics::glass::line_nm;
use petzval_optics::pupil_map::{PupilMap, on_axis_throughput};
use petzval_optics::ray_table::{Grid, RayTable};
use petzval_optics::transmission::Passages;

/// A lens as a table before its film.
pub struct ImageBased {
    mount: Mount,
    map: PupilMap,
    table: RayTable,
    /// One over the exposure of the film's middle.
    gain: f64,
    /// The lens's transform of a scene colour on the axis.
    tint: Mat3,
}

impl ImageBased {
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<Self, CameraError> {
        let (mount, system) = Mount::new(d, axes, width, height)?;
        let Mount { info, film, .. } = &mount;
        let nm = d.wavelength_nm.unwrap_or(line_nm::D);
        let tracer = system.at_wavelength(nm);
        let half = [0.5 * info.picture_width_mm, 0.5 * info.picture_height_mm];
        let map = PupilMap::new(&tracer, &system, film, half[0], half[1]);
        let middle = on_axis_throughput(&tracer, &system, film.z_mm);
        let gain = d.brightness_through(&tracer, &system, film.z_mm) / middle;
        if !gain.is_finite() {
            return Err(dark(d, &info.lens_name));
        }
        let table = RayTable::new(&system, nm, &map, film, half, Grid::default());
        let tint = match d.transmission {
            true => {
                let middle = Middle::new(d, &Passages::new(&system, nm), mount.film.z_mm, &FilmSpectrum::single(nm));
                middle.ok_or_else(|| dark(d, &mount.info.lens_name))?.tint()
            }
            false => Mat3::IDENTITY,
        };
        Ok(Self { mount, map, table, gain, tint })
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        self.mount.axes()
    }

    /// Data of the lens in this camera.
    pub fn info(&self) -> &LensInfo {
        &self.mount.info
    }

    /// A ray for a picture point, or `None` where it is lost in the lens.
    #[inline]
    pub fn sample(&self, p: Vec2, u_lens: [f32; 2]) -> Option<CameraRay> {
        let FilmPoint { point: film_point, normal, .. } = self.mount.film_at(p);
        let aim = self.map.sample(film_point, u_lens.map(f64::from));
        let out = self.table.from_film(film_point, aim.target)?;
        let to = aim.target - film_point;
        let distance2 = to.length_squared();
        let direction = to / distance2.sqrt();
        let cosines = normal.dot(direction).abs() * direction.z.abs();
        let exposure = cosines / (distance2 * aim.pdf_per_mm2) * self.gain;
        Some(CameraRay { ray: self.mount.to_render(&out), weight: self.tint * exposure as f32 })
    }
}

#[cfg(test)]
mod tests;
