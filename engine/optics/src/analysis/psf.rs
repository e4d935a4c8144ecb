//! Point spread: the light of a point on the film, as waves have it.
//!
//! The light near a place of the film is the sum of the plane waves exp 2πi (W + α x + β y) / λ over their direction cosines
//! ([`super::waves`]): a Fourier transform of the pupil's complex amplitude, here by FFT with zeros around the pupil, at a place whose
//! waves are the exact ones (Goodman, Introduction to Fourier Optics, 4th ed., section 6.2). The lattice's step grows with the
//! wavelength, so that all wavelengths have one grid on the film and can be added.

use std::f64::consts::TAU;

use glam::DVec2;
use petzval_fourier::{Complex, Direction, complex_f64};
use serde::Serialize;
use thiserror::Error;

use super::wavefront::Eikonal;
use super::waves::{ImageBeam, MESH, WaveLattice};
use super::{Analysis, centroid};

/// Cells of the lattice over the beam at the longest wavelength: at least, and at most.
const CELLS: [f64; 2] = [256.0, 768.0];
/// Samples of the film over λ N at the shortest wavelength: two sample the light without loss.
const SAMPLES: f64 = 4.0;
/// The field of the transform is so many times as wide as the spot of rays: light beyond it comes in at the other side.
const ROOM: f64 = 4.0;
/// The picture reaches as far as so many λ N, or as this part of the farthest ray.
const AROUND: [f64; 2] = [16.0, 1.25];
/// Values a side of the picture, at most; finer ones are averaged.
const SIDE: usize = 257;
/// Radii for which the encircled light is counted.
const RADII: usize = 128;

/// An error by which there is no point spread function.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PsfError {
    /// The field is dark.
    #[error("nothing comes through the lens to the film from there")]
    Dark,
    /// The lattice would be too large.
    #[error(
        "a point of {angle_deg:.4} degrees is spread over {spread_mm:.3} mm, {times:.0} times what diffraction spreads it: its rays say all (`spots`)"
    )]
    TooWide {
        /// Angle of the field from the axis.
        angle_deg: f64,
        /// Twice the distance of the farthest ray from the middle.
        spread_mm: f64,
        /// The spread over λ N.
        times: f64,
    },
}

/// The light of a point. Places are [sagittal, tangential] from the middle of all rays' light, mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Psf {
    /// Angle of the field from the axis, counted at the entrance pupil.
    pub angle_deg: f64,
    /// Height of the field's light on the film, from the middle: tangential, mm.
    pub height_mm: f64,
    /// The brightest value over that of the same pupil without aberrations, by wavelength.
    pub strehl: Vec<f64>,
    /// Values a side of the picture; odd, the middle one at the place (0, 0).
    pub side: usize,
    /// Step from value to value, mm.
    pub step_mm: f64,
    /// Rows from below, each from left to right: irradiance, all wavelengths alike, in units of the largest that this pupil would
    /// make without aberrations.
    pub values: Vec<f64>,
    /// Radii about (0, 0), mm.
    pub radii_mm: Vec<f64>,
    /// The part of the light within each.
    pub encircled: Vec<f64>,
}

impl Analysis<'_> {
    /// The point spread function of a field.
    ///
    /// # Errors
    /// [`PsfError`].
    pub fn psf(&self, angle_deg: f64) -> Result<Psf, PsfError> {
        let view = self.view(angle_deg).ok_or(PsfError::Dark)?;
        let landings = (0..self.lines.len()).flat_map(|line| self.landings(line, &view, MESH));
        let landings: Vec<(DVec2, f64)> = landings.map(|landing| (landing.film, landing.weight)).collect();
        let (sum, middle) = centroid(landings.iter().copied());
        if sum <= 0.0 {
            return Err(PsfError::Dark);
        }
        let farthest_mm = landings.iter().map(|(at, _)| (*at - middle).length()).fold(0.0, f64::max);
        let touching = self.touching(middle);
        let eikonals: Vec<[Eikonal<'_>; 2]> = self
            .lines
            .iter()
            .map(|line| [&line.tracer, &line.probe.tracer].map(|tracer| Eikonal::new(self.system, tracer, touching)))
            .collect();
        let beams: Option<Vec<ImageBeam<'_>>> = self
            .lines
            .iter()
            .zip(&eikonals)
            .map(|(line, [eikonal, mesh])| ImageBeam::new(&view, line, eikonal, mesh))
            .collect();
        let beams = beams.ok_or(PsfError::Dark)?;
        let times_n = |beam: &ImageBeam<'_>| beam.wavelength_mm() / beam.width();
        let (least, most) = beams.iter().map(times_n).fold((f64::INFINITY, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
        let field_mm = (CELLS[0] * most).max(2.0 * ROOM * farthest_mm);
        if field_mm > CELLS[1] * most {
            let spread_mm = 2.0 * farthest_mm;
            return Err(PsfError::TooWide { angle_deg, spread_mm, times: spread_mm / most });
        }
        let side = ((SAMPLES * field_mm / least).ceil() as usize).next_power_of_two();
        let mut light = vec![0.0; side * side];
        let mut strehl = Vec::with_capacity(beams.len());
        for beam in &beams {
            let waves = beam.waves_with_soft_edge(beam.wavelength_mm() / field_mm);
            let whole: f64 = waves.waves.iter().map(|wave| wave.amplitude.length()).sum();
            if whole <= 0.0 {
                return Err(PsfError::Dark);
            }
            let scale = 1.0 / (whole * whole * beams.len() as f64);
            let amplitudes = transformed(&waves, side);
            strehl.push(peak(&waves, &amplitudes, side) / (whole * whole));
            for (sum, amplitude) in light.iter_mut().zip(&amplitudes) {
                *sum += amplitude.norm_sqr() * scale;
            }
        }
        let step_mm = field_mm / side as f64;
        let grid = LightGrid { side, step_mm, light };
        let reach_mm = (AROUND[0] * most).max(AROUND[1] * farthest_mm).min(0.5 * field_mm);
        let (radii_mm, encircled) = grid.encircled(reach_mm);
        let (side, step_mm, values) = grid.picture(reach_mm);
        Ok(Psf { angle_deg, height_mm: self.turned(middle).y, strehl, side, step_mm, values, radii_mm, encircled })
    }
}

/// Amplitudes on the film, of `side` by `side` places; the first is (0, 0), and the second half of rows and columns lies before it.
fn transformed(waves: &WaveLattice, side: usize) -> Vec<Complex<f64>> {
    let fft = complex_f64(side, Direction::Back);
    let mut columns = vec![Complex::default(); side * side];
    // Rows of the pupil, then turned, so that the second transform, too, goes along rows.
    let mut row = vec![Complex::default(); side];
    for (y, line) in waves.waves.chunks(waves.columns).enumerate() {
        row.fill(Complex::default());
        for (to, wave) in row.iter_mut().zip(line) {
            *to = Complex::new(wave.amplitude.x, wave.amplitude.y);
        }
        fft.process(&mut row);
        for (x, value) in row.iter().enumerate() {
            columns[x * side + y] = *value;
        }
    }
    fft.process(&mut columns);
    let mut amplitudes = vec![Complex::default(); side * side];
    for (x, column) in columns.chunks(side).enumerate() {
        for (y, value) in column.iter().enumerate() {
            amplitudes[y * side + x] = *value;
        }
    }
    amplitudes
}

/// The largest |amplitude|²: from the brightest place of the grid uphill, by the waves themselves.
fn peak(waves: &WaveLattice, amplitudes: &[Complex<f64>], side: usize) -> f64 {
    let brightest =
        (0..amplitudes.len()).max_by(|&a, &b| amplitudes[a].norm_sqr().total_cmp(&amplitudes[b].norm_sqr()));
    let Some(start) = brightest else { return 0.0 };
    let turn = TAU / side as f64;
    let at = |place: DVec2| {
        let mut sum = Complex::default();
        for (y, line) in waves.waves.chunks(waves.columns).enumerate() {
            let mut phasor = Complex::from_polar(1.0, turn * place.y * y as f64);
            let step = Complex::from_polar(1.0, turn * place.x);
            for wave in line {
                sum += Complex::new(wave.amplitude.x, wave.amplitude.y) * phasor;
                phasor *= step;
            }
        }
        sum.norm_sqr()
    };
    let mut here = DVec2::new((start % side) as f64, (start / side) as f64);
    let mut best = at(here);
    // Parabolas through neighbours; three are enough for rounding.
    for step in [0.5f64, 0.1, 0.02] {
        let mut next = here;
        for axis in [DVec2::X, DVec2::Y] {
            let (before, after) = (at(here - axis * step), at(here + axis * step));
            let bend: f64 = before - 2.0 * best + after;
            if bend < 0.0 {
                let by: f64 = 0.5 * step * (before - after) / bend;
                next += axis * by.clamp(-1.0, 1.0);
            }
        }
        let value = at(next);
        if value > best {
            (here, best) = (next, value);
        }
    }
    best
}

/// Light by place; the first is (0, 0), and the second half of rows and columns lies before it.
struct LightGrid {
    side: usize,
    step_mm: f64,
    light: Vec<f64>,
}

impl LightGrid {
    /// The value in column x and row y, counted from (0, 0), to both sides.
    fn at(&self, x: i64, y: i64) -> f64 {
        let wrap = |i: i64| i.rem_euclid(self.side as i64) as usize;
        self.light[wrap(y) * self.side + wrap(x)]
    }

    /// Values a side, their step and themselves, out to `reach_mm`.
    fn picture(&self, reach_mm: f64) -> (usize, f64, Vec<f64>) {
        let fine = (2.0 * reach_mm / self.step_mm) as usize + 1;
        // An odd block, so that its middle is a place of the grid.
        let block = fine.div_ceil(SIDE) | 1;
        let half = ((fine / block) / 2) as i64;
        let (b, reach) = (block as i64, (block / 2) as i64);
        let mean = |x: i64, y: i64| {
            let sum: f64 =
                (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| self.at(x + dx, y + dy))).sum();
            sum / (block * block) as f64
        };
        let values = (-half..=half).flat_map(|y| (-half..=half).map(move |x| mean(x * b, y * b))).collect();
        (2 * half as usize + 1, self.step_mm * block as f64, values)
    }

    /// Radii and the part of the light within.
    fn encircled(&self, reach_mm: f64) -> (Vec<f64>, Vec<f64>) {
        let total: f64 = self.light.iter().sum();
        let radii: Vec<f64> = (0..=RADII).map(|i| i as f64 * reach_mm / RADII as f64).collect();
        let encircled = radii.iter().map(|&radius| self.within(radius) / total).collect();
        (radii, encircled)
    }

    /// A place stands for its square: it comes in over as much of the radius as the square is wide.
    fn within(&self, radius_mm: f64) -> f64 {
        let reach = (radius_mm / self.step_mm + 1.0) as i64;
        let mut sum = 0.0;
        for y in -reach..=reach {
            for x in -reach..=reach {
                let from = (x as f64).hypot(y as f64) * self.step_mm;
                sum += self.at(x, y) * ((radius_mm - from) / self.step_mm + 0.5).clamp(0.0, 1.0);
            }
        }
        sum
    }
}
