//! The lens and its film for stray light: from the scene to lens space, from the film to
//! pixels, and the weight of the light there.

use crate::camera::lens::mount::Mount;
use crate::camera::lens::real_lens::{dark, film_spectrum};
use crate::camera::lens::transmission::Middle;
use crate::camera::{CameraDescription, CameraError, Spectrum};
use crate::spectrum::FilmSpectrum;
use crate::{Rgb, luminance};
use glam::{DVec2, DVec3, Mat3};
use petzval_optics::focus::FilmFrame;
use petzval_optics::ghosts::{self, beam::Source};
use petzval_optics::pupil_map::on_axis_throughput;
use petzval_optics::system::System;
use petzval_optics::transmission::Passages;

/// Bands of the spectrum by which the light of a ghost is estimated.
pub const COLOURS: usize = 6;
/// The radius of the smallest ghost that is told apart from a point, pixels.
const LEAST_PX: f64 = 2.0;

/// A part of the spectrum that takes one way.
#[derive(Clone, Copy, Debug)]
pub struct Band {
    /// The middle of the band, nm.
    pub nm: f64,
    /// The contribution of light of a scene colour to the picture, its part of all light included: the bands' responses add up to the
    /// identity.
    pub response: Mat3,
}

/// A lens, its film, and the picture on it.
pub struct StrayLens {
    mount: Mount,
    system: System,
    spectrum: FilmSpectrum,
    /// The picture's value for the irradiance that radiance one makes.
    gain: f64,
    /// The picture's value for radiance one in the middle of the film.
    brightness: f64,
    size_px: DVec2,
    /// The width of the entrance pupil as a part of the front glass's.
    pupil_part: f64,
}

impl StrayLens {
    /// The lens for a picture of that many pixels.
    ///
    /// # Errors
    /// As [`crate::camera::Camera::new`].
    pub fn new(d: &CameraDescription, width: u32, height: u32) -> Result<Self, CameraError> {
        d.check(width, height)?;
        // Rays that stray part into colours of their own: all of them count, whatever the picture's path does.
        let d = CameraDescription { spectrum: Spectrum::Visible, ..d.clone() };
        let (mount, system) = Mount::new(&d, d.axes()?, width, height)?;
        let spectrum = film_spectrum(&d, &system);
        let middle_nm = spectrum.wavelengths()[spectrum.wavelengths().len() / 2].nm;
        let tracer = system.at_wavelength(middle_nm);
        let middle = on_axis_throughput(&tracer, &system, mount.film.z_mm);
        if middle.is_nan() || middle <= 0.0 {
            return Err(dark(&d, &mount.info.lens_name));
        }
        let brightness = d.brightness_through(&tracer, &system, mount.film.z_mm);
        // What the lens takes of the light is made up for, unless the picture is exposed by the f-number: then ghosts are as much
        // brighter, beside light that is.
        let passages = Passages::new(&system, middle_nm);
        let passes = match d.exposes_by_f_number {
            true => None,
            false => passages.in_the_middle(mount.film.z_mm, &[middle_nm]),
        };
        let lost = if d.transmission { Middle::new(&d, &passages, mount.film.z_mm, &spectrum) } else { None };
        let spectrum = lost.map_or(spectrum.clone(), |middle| spectrum.tinted(middle.balanced()));
        let passes = passes.and_then(|by_line| by_line.first().copied()).filter(|part| *part > 0.0).unwrap_or(1.0);
        let gain = brightness / (middle * passes);
        let front_mm = 2.0 * system.surfaces()[0].semi_diameter_mm;
        let pupil_mm = mount.info.entrance_pupil_diameter_mm.unwrap_or(front_mm);
        let pupil_part = (pupil_mm / front_mm).min(1.0);
        let size_px = DVec2::new(f64::from(width), f64::from(height));
        Ok(Self { mount, system, spectrum, gain, brightness, size_px, pupil_part })
    }

    /// The lens as it is set, in lens space.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The film in lens space, as the lens is focused.
    pub fn film(&self) -> &FilmFrame {
        &self.mount.frame
    }

    /// The picture's value for the irradiance that radiance one makes on the film.
    pub fn gain(&self) -> f64 {
        self.gain
    }

    /// The picture's value in the middle of the film for radiance one.
    pub fn brightness(&self) -> f64 {
        self.brightness
    }

    /// The radiance of the brightest ghost of a far source on the axis, to first order, for an irradiance of its light before the lens of
    /// one.
    pub fn brightest_ghost(&self) -> f64 {
        let least_mm = LEAST_PX / self.px2_per_mm2().sqrt();
        // Coatings reflect least in the middle of the spectrum.
        let in_band = |band: &Band| {
            let ghosts = ghosts::all(&self.system, band.nm, self.mount.film.z_mm, least_mm);
            let weight = f64::from(luminance(band.response * Rgb::ONE)).max(0.0);
            weight * ghosts.first().map_or(0.0, |ghost| ghost.irradiance)
        };
        self.bands(COLOURS).iter().map(in_band).sum::<f64>() * self.gain / self.brightness
    }

    /// Width and height of the picture, pixels.
    pub fn size_px(&self) -> DVec2 {
        self.size_px
    }

    /// Pixels in a square millimetre of the film.
    pub fn px2_per_mm2(&self) -> f64 {
        self.per_mm().element_product().abs()
    }

    /// Pixels in a millimetre of the film; the picture on it is turned by half a turn.
    fn per_mm(&self) -> DVec2 {
        -self.size_px / DVec2::new(self.mount.info.picture_width_mm, self.mount.info.picture_height_mm)
    }

    /// The width of the entrance pupil as a part of the front glass's, at most one.
    pub fn pupil_part(&self) -> f64 {
        self.pupil_part
    }

    /// The place in the picture of a point (u, v) of the film, mm: pixels from its lower left corner.
    #[inline]
    pub fn pixel(&self, film: DVec2) -> DVec2 {
        film * self.per_mm() + 0.5 * self.size_px
    }

    /// The middle of the front glass, render space.
    pub fn front(&self) -> DVec3 {
        self.mount.vectors() * DVec3::new(0.0, 0.0, -self.mount.origin_z_mm())
    }

    /// Direction along the camera's axis to the scene, render space.
    pub fn forwards(&self) -> DVec3 {
        -self.mount.axes().z_axis
    }

    /// A source at that distance from the front glass in a direction, render space and Blender units.
    pub fn source(&self, towards: DVec3, distance: f64) -> Source {
        let point = self.front() + towards * distance;
        if distance.is_finite() {
            let near = self.mount.to_lens(point);
            // Where digits would be lost a source is as good as infinitely far.
            if near.length() < 1e9 {
                return Source::Near(near);
            }
        }
        // Also where the axes have different scales.
        let towards = self.mount.to_lens(self.front() + towards) - self.mount.to_lens(self.front());
        Source::Far(towards.normalize())
    }

    /// The spectrum in so many bands, at most as many as the film tells apart.
    pub fn bands(&self, count: usize) -> Vec<Band> {
        let lines = self.spectrum.wavelengths();
        let count = count.clamp(1, lines.len());
        let band = |i: usize| {
            let of = &lines[i * lines.len() / count..(i + 1) * lines.len() / count];
            let response = of.iter().fold(Mat3::ZERO, |sum, line| sum + line.response) * (lines.len() as f32).recip();
            Band { nm: of[of.len() / 2].nm, response }
        };
        (0..count).map(band).collect()
    }
}
