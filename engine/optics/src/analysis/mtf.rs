//! Modulation transfer: the contrast of fine lines that is left on the film, by diffraction and by rays alone.
//!
//! The light near a place of the film is a sum of plane waves over their direction cosines (α, β), of phase 2π W / λ
//! ([`super::wavefront`]). Its power spectrum at the frequency ν along α is the autocorrelation of that sum for the shift λ ν: Duffieux's
//! integral (Goodman, Introduction to Fourier Optics, 4th ed., section 7.3), here without the approximation of small angles and over the
//! pupil as rays find it. The waves are taken on a square lattice ([`super::waves`]) whose cell goes into λ ν a whole number of times.

use glam::DVec2;
use serde::Serialize;
use thiserror::Error;

use super::wavefront::Eikonal;
use super::waves::{ImageBeam, MESH, WaveLattice};
use super::{Analysis, centroid};

/// Cells of the lattice over the larger side of the beam: at least, and at most.
const LATTICE: [f64; 2] = [128.0, 2048.0];

/// An error by which there is no transfer function.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MtfError {
    /// The field is dark.
    #[error("nothing comes through the lens to the film from there")]
    Dark,
    /// The lattice would be too large.
    #[error(
        "frequencies {step_per_mm} lines/mm apart are too near each other for so wide a beam; give steps of {least_per_mm:.2} or more"
    )]
    TooFine {
        /// The step that was asked for.
        step_per_mm: f64,
        /// The finest possible step.
        least_per_mm: f64,
    },
}

/// Contrast left of line pairs, from 0 to 1, by frequency: 0, `step`, 2 `step`... All wavelengths together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mtf {
    /// Angle of the field from the axis, counted at the entrance pupil.
    pub angle_deg: f64,
    /// Height of the field's light on the film, from the middle: tangential, mm.
    pub height_mm: f64,
    /// The curve of lines that run tangentially: the frequency is sagittal.
    pub sagittal: Curve,
    /// The curve of lines that run sagittally.
    pub tangential: Curve,
}

/// The contrast in one direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Contrast with aberrations and diffraction.
    pub contrast: Vec<f64>,
    /// Contrast with aberrations alone, as rays have it.
    pub geometric: Vec<f64>,
    /// Contrast with diffraction alone: the same pupil without aberrations, colour by colour.
    pub limit: Vec<f64>,
}

/// A transfer function that is being summed: complex numbers.
#[derive(Clone, Debug)]
struct Sum {
    contrast: Vec<DVec2>,
    geometric: Vec<DVec2>,
    limit: Vec<DVec2>,
}

impl Analysis<'_> {
    /// The transfer function of a field, at `count` frequencies from 0 on, `step_per_mm` line pairs on a millimetre of film apart.
    ///
    /// # Errors
    /// [`MtfError`].
    pub fn mtf(&self, angle_deg: f64, step_per_mm: f64, count: usize) -> Result<Mtf, MtfError> {
        let view = self.view(angle_deg).ok_or(MtfError::Dark)?;
        let landings = (0..self.lines.len()).flat_map(|line| self.landings(line, &view, MESH));
        let (sum, middle) = centroid(landings.map(|landing| (landing.film, landing.weight)));
        if sum <= 0.0 {
            return Err(MtfError::Dark);
        }
        let none = Sum::new(count);
        let mut all = [none.clone(), none];
        for line in &self.lines {
            let eikonal = Eikonal::new(self.system, &line.tracer, self.touching(middle));
            let mesh = Eikonal::new(self.system, &line.probe.tracer, self.touching(middle));
            let beam = ImageBeam::new(&view, line, &eikonal, &mesh).ok_or(MtfError::Dark)?;
            let (width, shift) = (beam.width(), beam.wavelength_mm() * step_per_mm);
            let [least, most] = LATTICE;
            if width > shift * most {
                return Err(MtfError::TooFine { step_per_mm, least_per_mm: width / (most * beam.wavelength_mm()) });
            }
            let cells = (least * shift / width).ceil().max(1.0);
            let lattice = beam.waves(shift / cells);
            // Sagittal lattice neighbours lie side by side.
            for (of_axis, axis) in all.iter_mut().zip([DVec2::X, DVec2::Y]) {
                of_axis.add(&lattice, cells as usize, axis, step_per_mm);
            }
        }
        let [sagittal, tangential] = all.map(|sum| sum.curve());
        Ok(Mtf { angle_deg, height_mm: self.turned(middle).y, sagittal, tangential })
    }
}

impl Sum {
    fn new(count: usize) -> Self {
        let zeros = vec![DVec2::ZERO; count];
        Self { contrast: zeros.clone(), geometric: zeros.clone(), limit: zeros }
    }

    /// A wavelength, weighted by nothing but itself; a step of the frequency is so many cells of its lattice.
    fn add(&mut self, lattice: &WaveLattice, cells: usize, axis: DVec2, step_per_mm: f64) {
        let WaveLattice { columns, waves } = lattice;
        let light: f64 = waves.iter().map(|wave| wave.amplitude.length_squared()).sum();
        if light <= 0.0 {
            return;
        }
        for i in 0..self.contrast.len() {
            let shift = i * cells;
            // Two waves a shift apart in this direction, in the same row or column.
            let (ahead, within) = match axis == DVec2::X {
                true => (shift, columns.saturating_sub(shift)),
                false => (shift * columns, *columns),
            };
            let (mut with, mut without) = (DVec2::ZERO, 0.0);
            for (row, later) in waves.chunks(*columns).zip(waves.get(ahead..).unwrap_or_default().chunks(*columns)) {
                for (a, b) in row.iter().zip(later).take(within) {
                    let (a, b) = (a.amplitude, b.amplitude);
                    // b times the conjugate of a.
                    with += DVec2::new(a.dot(b), a.perp_dot(b));
                    without += a.length() * b.length();
                }
            }
            self.contrast[i] += with / light;
            self.limit[i].x += without / light;
        }
        for wave in waves.iter().filter(|wave| wave.amplitude != DVec2::ZERO) {
            let turn = DVec2::from_angle(-std::f64::consts::TAU * step_per_mm * wave.crossing.dot(axis));
            let mut phasor = DVec2::X * (wave.amplitude.length_squared() / light);
            for sum in &mut self.geometric {
                *sum += phasor;
                phasor = phasor.rotate(turn);
            }
        }
    }

    fn curve(self) -> Curve {
        let modulus = |sums: &[DVec2]| {
            let whole = sums.first().map_or(0.0, |sum| sum.length());
            sums.iter().map(|sum| if whole > 0.0 { sum.length() / whole } else { 0.0 }).collect()
        };
        Curve { contrast: modulus(&self.contrast), geometric: modulus(&self.geometric), limit: modulus(&self.limit) }
    }
}
