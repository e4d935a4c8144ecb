//! The lens to first order, without aberration and vignetting: its planes and pupils at one wavelength (thick), or at
//! each (paraxial), so that colours have their own focus and size.
//!
//! The film is exposed through the opening of the diaphragm, sampled evenly: with slopes u before the film,
//! cos(film) cos³ du² is the projected solid angle. As for a real lens, it is divided by the exposure of the middle of the film
//! by a uniform world of radiance one through that opening.

use crate::camera::lens::mount::Mount;
use crate::camera::lens::real_lens::{dark, film_spectrum};
use crate::camera::lens::setup::LensInfo;
use crate::camera::lens::transmission::Middle;
use crate::camera::{CameraDescription, CameraError, CameraRay};
use crate::spectrum::FilmSpectrum;
use glam::{DMat3, DVec2, DVec3, Vec2};
use petzval_optics::diaphragm::Diaphragm;
use petzval_optics::gaussian::GaussianLens;
use petzval_optics::glass::line_nm;
use petzval_optics::transmission::Passages;

/// The part of a lens that a model keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::camera) enum Order {
    /// Principal planes and pupils at the d line (Kolb, Mitchell and Hanrahan 1995, §3.4).
    Thick,
    /// Principal planes and pupils at every wavelength.
    Paraxial,
}

/// A lens of first order before its film.
pub struct Gaussian {
    mount: Mount,
    spectrum: FilmSpectrum,
    diaphragm: Diaphragm,
    /// The lens and its gain at each wavelength of the film.
    lines: Vec<(GaussianLens, f64)>,
}

impl Gaussian {
    pub(in crate::camera) fn new(
        order: Order,
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<Self, CameraError> {
        let (mount, system) = Mount::new(d, axes, width, height)?;
        let mut spectrum = match order {
            Order::Thick => FilmSpectrum::single(d.wavelength_nm.unwrap_or(line_nm::D)),
            Order::Paraxial => film_spectrum(d, &system),
        };
        let diaphragm = system.diaphragm().clone();
        let line = |nm: f64| {
            let lens = GaussianLens::new(&system, nm);
            let middle = exposure_of_the_middle(&lens, &diaphragm, mount.film.z_mm);
            let gain = d.brightness(middle) / middle;
            (lens, gain)
        };
        let lines: Vec<_> = spectrum.wavelengths().iter().map(|w| line(w.nm)).collect();
        let mut lines = lines;
        if d.transmission {
            let nm = spectrum.wavelengths()[lines.len() / 2].nm;
            let middle = Middle::new(d, &Passages::new(&system, nm), mount.film.z_mm, &spectrum);
            let middle = middle.ok_or_else(|| dark(d, &mount.info.lens_name))?;
            if lines.len() > 1 {
                lines.iter_mut().enumerate().for_each(|(i, (_, gain))| *gain *= middle.gain_at(i));
            }
            spectrum = middle.tinted(spectrum);
        }
        if !lines.iter().all(|(_, gain)| gain.is_finite()) {
            return Err(dark(d, &mount.info.lens_name));
        }
        Ok(Self { mount, spectrum, diaphragm, lines })
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        self.mount.axes()
    }

    /// Data of the lens in this camera.
    pub fn info(&self) -> &LensInfo {
        &self.mount.info
    }

    /// A ray for a picture point.
    #[inline]
    pub fn sample(&self, p: Vec2, u_lens: [f32; 2], u_wavelength: f32) -> CameraRay {
        self.through(p, DVec2::from(self.diaphragm.sample(u_lens.map(f64::from))), u_wavelength)
    }

    /// The ray through the middle of the opening, as bright.
    pub(in crate::camera) fn chief(&self, p: Vec2, u_wavelength: f32) -> CameraRay {
        self.through(p, DVec2::ZERO, u_wavelength)
    }

    #[inline]
    fn through(&self, p: Vec2, stop: DVec2, u_wavelength: f32) -> CameraRay {
        let index = self.spectrum.sample(u_wavelength);
        let (lens, gain) = &self.lines[index];
        let film = self.mount.film_at(p);
        let slopes = lens.slopes(film.point, stop);
        let out = lens.into_scene(film.point, slopes);
        let towards = slopes.extend(1.0);
        let cosine = towards.length().recip();
        let cosines = (film.normal.dot(towards) * cosine).abs() * cosine.powi(3);
        let area = self.diaphragm.area_mm2() * lens.slopes_per_mm2(film.point.z);
        let weight = self.spectrum.wavelengths()[index].response * (cosines * area * gain) as f32;
        CameraRay { ray: self.mount.to_render(&out), weight }
    }
}

/// ∫ cos⁴ du² over the opening, for the middle of an upright film: by the midpoints of an even grid of its samples.
fn exposure_of_the_middle(lens: &GaussianLens, diaphragm: &Diaphragm, film_z_mm: f64) -> f64 {
    // Smooth along both numbers within a blade, so the error falls with the square: below 1e-5.
    const ACROSS: u32 = 64;
    let around = 24 * diaphragm.blades().max(8);
    let middle = DVec3::new(0.0, 0.0, film_z_mm);
    let mut sum = 0.0;
    for i in 0..around {
        for j in 0..ACROSS {
            let u = [(f64::from(i) + 0.5) / f64::from(around), (f64::from(j) + 0.5) / f64::from(ACROSS)];
            let slopes = lens.slopes(middle, DVec2::from(diaphragm.sample(u)));
            sum += (1.0 + slopes.length_squared()).powi(-2);
        }
    }
    sum / f64::from(around * ACROSS) * diaphragm.area_mm2() * lens.slopes_per_mm2(film_z_mm)
}
