//! Diffraction in a picture: softness at small openings, and the spikes of bright points.
//!
//! The picture has the lens's aberrations and its defocus already, by rays. Diffraction multiplies its contrast at the frequency ν by the
//! overlap of the pupil with itself for the shift λν ([`petzval_optics::diffraction`]); docs/diffraction.md holds that product against
//! exact waves. Light of a pixel acts on the picture's colour at each wavelength as [`FilmSpectrum`] has it, so a matrix belongs to
//! each frequency: Σ response(λ) overlap(λν). These sum to the identity at frequency 0: no light is lost.
//!
//! A pixel's light is taken to lie over about a pixel, by a weight W of the frequency whose copies around all multiples of the sampling
//! rate sum to one and which is zero at all of these but 0. Frequencies above those of the picture fold as they must, no light is
//! lost, tails are not cut, and where diffraction is finer than the pixels the picture stays as it is, exactly.

mod table;

use super::spread::{Spreading, Transfer, Zone, transform_growth};
use crate::Rgb;
use crate::camera::tools::survey::Survey;
use crate::camera::{CameraDescription, CameraError};
use crate::spectrum::{FilmSpectrum, SPECTRAL_COUNT};
use glam::{Mat3, Vec2};
use petzval_optics::diffraction::outline::Outline;
use petzval_optics::diffraction::overlap::{Shifts, loss_per_shift};
use std::time::Instant;
use table::TransferTable;

/// Pupils whose breadths, over their areas, differ by less than this part from that of the middle are taken for the same.
const ALIKE: f64 = 0.1;
/// Directions in which the pupils are compared.
const COMPARED: usize = 16;
/// Places of the kernels of a picture whose pupil changes, fractions of its width or height.
const PLACES: [f32; 3] = [-0.5, 0.0, 0.5];

/// The diffraction of a lens in a picture.
pub struct Diffraction {
    size: [usize; 2],
    /// Width and height of a pixel, mm.
    pixel: [f64; 2],
    spectrum: FilmSpectrum,
    /// Pupils by row and column of [`PLACES`], from below; or one for all of the picture.
    pupils: Vec<Outline>,
}

impl Diffraction {
    /// The diffraction of the lens of a camera, for a picture of that many pixels. Blades are the description's: that blur was made with a
    /// round opening does not keep them from throwing light aside.
    ///
    /// # Errors
    /// As [`crate::camera::Camera::new`].
    pub fn new(d: &CameraDescription, [width, height]: [u32; 2]) -> Result<Self, CameraError> {
        let survey = Survey::new(d, width, height)?;
        let spectrum = d.wavelength_nm.map_or_else(|| d.visible_in(SPECTRAL_COUNT), FilmSpectrum::single);
        let pixel = survey.pixel_mm();
        let diagonal_mm = (pixel[0] * f64::from(width)).hypot(pixel[1] * f64::from(height));
        // An eighth of a wavelength where the light is farthest aside.
        let shortest_mm = spectrum.wavelengths().iter().map(|w| w.nm).fold(f64::INFINITY, f64::min) * 1e-6;
        let tolerance = shortest_mm / (8.0 * diagonal_mm);
        let outline = |x: f32, y: f32| survey.outline(Vec2::new(x, y), tolerance);
        let size = [width as usize, height as usize];
        let Some(middle) = outline(0.0, 0.0) else {
            return Ok(Self { size, pixel, spectrum, pupils: Vec::new() });
        };
        let places = PLACES.iter().flat_map(|&y| PLACES.map(|x| (x, y)));
        let mut pupils: Vec<Outline> = places.map(|(x, y)| outline(x, y).unwrap_or_else(|| middle.clone())).collect();
        if pupils.iter().all(|one| is_alike(one, &middle)) {
            pupils = vec![middle];
        }
        Ok(Self { size, pixel, spectrum, pupils })
    }

    /// The diffraction of pupils: one for all of the picture, or nine, of the places [`PLACES`] by rows from below. `pixel_mm` is a pixel's
    /// width and height.
    pub fn of_outlines(pupils: Vec<Outline>, spectrum: FilmSpectrum, pixel_mm: [f64; 2], size: [usize; 2]) -> Self {
        Self { size, pixel: pixel_mm, spectrum, pupils }
    }

    /// Number of kernels of the picture.
    pub fn zones(&self) -> usize {
        self.pupils.len()
    }

    /// The change of a picture by diffraction, rows from below: the picture spread, less the picture.
    pub fn change(&self, picture: &[Rgb]) -> Vec<Rgb> {
        let [width, height] = self.size;
        let mut spreading = Spreading::new(picture, self.size);
        for (i, pupil) in self.pupils.iter().enumerate() {
            let part = |n: usize, place: usize| match self.pupils.len() {
                1 => vec![1.0; n],
                _ => (0..n).map(|i| share((i as f32 + 0.5) / n as f32 - 0.5, place)).collect(),
            };
            let (columns, rows) = (part(width, i % PLACES.len()), part(height, i / PLACES.len()));
            let table = TransferTable::new(pupil, &self.spectrum, self.pixel, self.size);
            spreading.add(&Zone { columns, rows, transfer: &table });
        }
        spreading.finish()
    }
}

impl Diffraction {
    /// Wall time of [`Self::change`], s, by a small picture of the same view, `picture`, whose diffraction is `small`.
    pub fn expected_seconds(&self, small: &Self, picture: &[Rgb]) -> f64 {
        let Some(pupil) = small.pupils.first() else { return 0.0 };
        let start = Instant::now();
        small.change(picture);
        let all_s = start.elapsed().as_secs_f64();
        let start = Instant::now();
        TransferTable::new(pupil, &small.spectrum, small.pixel, small.size);
        let tables_s = (start.elapsed().as_secs_f64() * small.pupils.len() as f64).min(all_s);
        let work = |of: &Self| of.pupils.len() as f64 * TransferTable::work(of.pixel, of.size);
        tables_s * work(self) / work(small) + (all_s - tables_s) * transform_growth(small.size, self.size)
    }
}

/// The part of a place's light that belongs to one of [`PLACES`]: linear between them.
fn share(at: f32, place: usize) -> f32 {
    let step = PLACES[1] - PLACES[0];
    (1.0 - (at - PLACES[place]).abs() / step).max(0.0)
}

/// True if two pupils diffract light alike.
fn is_alike(one: &Outline, other: &Outline) -> bool {
    let shifts = |outline: &Outline| Shifts { first: 1e-4 * outline.width(), per_octave: 1.0, count: 8 };
    (0..COMPARED).all(|i| {
        let shifts = shifts(other);
        let [a, b] = [one, other].map(|outline| loss_per_shift(outline, [i, COMPARED], &shifts));
        // Near the edges of the pupil, and of a good part of it.
        [0, 7].iter().all(|&k| f64::from((a[k] / b[k] - 1.0).abs()) < ALIKE)
    })
}

impl Transfer for TransferTable {
    fn change(&self, across: f32, up: &[f32], out: &mut [Mat3]) {
        self.folded(across, up, out);
    }
}

#[cfg(test)]
mod tests;
