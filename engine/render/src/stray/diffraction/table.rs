//! The transfer function of a pupil's shape in colour, by frequency: a table over directions and over the logarithm of the frequency.

use crate::spectrum::FilmSpectrum;
use crate::stray::spread;
use glam::Mat3;
use petzval_optics::diffraction::outline::Outline;
use petzval_optics::diffraction::overlap::{Shifts, loss_per_shift};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Frequencies to the double; between them the table is linear.
const PER_OCTAVE: f64 = 32.0;
/// Shifts of the pupil are so many times as dense: wavelengths average over details finer than the table.
const FINER: usize = 4;
/// Directions over half a turn: so many for each pixel of the picture's larger side, at least and at most so many. Spikes are
/// sharp as far out as the inverse of the step, in pixels.
const DIRECTIONS: [usize; 3] = [2, 512, 8192];

/// (1 − transfer) / frequency, as a matrix of colours.
pub(super) struct TransferTable {
    /// The first of the frequencies, per mm.
    first_per_mm: f32,
    count: usize,
    directions: usize,
    /// Width and height of a pixel, mm.
    pixel_mm: [f32; 2],
    /// Columns of the matrix by frequency, then by direction.
    values: Vec<[f32; 9]>,
}

/// The directions and frequencies of a table.
struct Extent {
    directions: usize,
    first_per_mm: f64,
    count: usize,
}

impl Extent {
    fn new(pixel_mm: [f64; 2], size: [usize; 2]) -> Self {
        let larger = size[0].max(size[1]);
        let directions = (DIRECTIONS[0] * larger).next_power_of_two().clamp(DIRECTIONS[1], DIRECTIONS[2]);
        // From half of the step of the transform, which has zeros beyond the picture, to all that folds.
        let [fine, coarse] = [pixel_mm[0].min(pixel_mm[1]), pixel_mm[0].max(pixel_mm[1])];
        let first_per_mm = 0.25 / (larger as f64 * coarse);
        let last_per_mm = 2f64.sqrt() / fine;
        let count = ((last_per_mm / first_per_mm).log2() * PER_OCTAVE).ceil() as usize + 2;
        Self { directions, first_per_mm, count }
    }
}

impl TransferTable {
    /// Number of values of a table, the measure of its cost.
    pub(super) fn work(pixel_mm: [f64; 2], size: [usize; 2]) -> f64 {
        let Extent { directions, count, .. } = Extent::new(pixel_mm, size);
        directions as f64 * count as f64
    }

    pub(super) fn new(outline: &Outline, spectrum: &FilmSpectrum, pixel_mm: [f64; 2], size: [usize; 2]) -> Self {
        let coarse = pixel_mm[0].max(pixel_mm[1]);
        let Extent { directions, first_per_mm, count } = Extent::new(pixel_mm, size);

        // A wavelength only moves along the logarithm.
        let lines = spectrum.wavelengths();
        let ends = lines.iter().fold([f64::INFINITY, 0.0f64], |[a, b], w| [a.min(w.nm * 1e-6), b.max(w.nm * 1e-6)]);
        let more = ((ends[1] / ends[0]).log2() * PER_OCTAVE).ceil() as usize + 2;
        let per_octave = PER_OCTAVE * FINER as f64;
        let shifts = Shifts { first: first_per_mm * ends[0], per_octave, count: (count + more) * FINER };
        let moved: Vec<(usize, f32, [f32; 9])> = lines
            .iter()
            .map(|line| {
                let mm = line.nm * 1e-6;
                let place = (mm / ends[0]).log2() * per_octave;
                let weight = line.response * (mm / lines.len() as f64) as f32;
                (place as usize, place.fract() as f32, weight.to_cols_array())
            })
            .collect();
        let mut by_direction = vec![[0.0; 9]; directions * count];
        by_direction.par_chunks_mut(count).enumerate().for_each(|(number, values)| {
            let loss = loss_per_shift(outline, [number, directions], &shifts);
            for (i, value) in values.iter_mut().enumerate() {
                for (place, part, weight) in &moved {
                    let place = i * FINER + place;
                    let at = loss[place] + (loss[place + 1] - loss[place]) * part;
                    value.iter_mut().zip(weight).for_each(|(value, weight)| *value += weight * at);
                }
            }
        });
        // The transform's step, as an angle at each frequency: what is finer would come in again at the other side of the picture.
        let step_per_mm = 1.0 / (spread::padded(size).into_iter().max().unwrap_or(1) as f64 * coarse);
        let mut values = vec![[0.0; 9]; directions * count];
        values.par_chunks_mut(directions).enumerate().for_each(|(i, values)| {
            let frequency = first_per_mm * (i as f64 / PER_OCTAVE).exp2();
            let angle = (step_per_mm / frequency).min(0.5);
            for (number, value) in values.iter_mut().enumerate() {
                *value = by_direction[number * count + i];
            }
            smooth(values, angle / std::f64::consts::PI * directions as f64);
        });
        Self { first_per_mm: first_per_mm as f32, count, directions, pixel_mm: pixel_mm.map(|x| x as f32), values }
    }

    /// Transfer less one, of frequencies in cycles a pixel, with all that folds onto them: Σ W(f + k) (transfer(f + k) − 1).
    pub(super) fn folded(&self, across: f32, up: &[f32], out: &mut [Mat3]) {
        for (matrix, &up) in out.iter_mut().zip(up) {
            let mut sum = [0.0; 9];
            for x in -1..=1 {
                let u = across + x as f32;
                let weight_x = weight(u);
                if weight_x <= 0.0 {
                    continue;
                }
                for y in -1..=1 {
                    let v = up + y as f32;
                    let weight = weight_x * weight(v);
                    if weight > 0.0 {
                        self.add([u / self.pixel_mm[0], v / self.pixel_mm[1]], weight, &mut sum);
                    }
                }
            }
            *matrix = Mat3::from_cols_array(&sum);
        }
    }

    /// Adds `weight` times transfer less one at a frequency, per mm.
    #[inline]
    fn add(&self, [x, y]: [f32; 2], weight: f32, sum: &mut [f32; 9]) {
        let squared = x * x + y * y;
        let frequency = squared.sqrt();
        if frequency < self.first_per_mm {
            // Only 0 is so small: nothing is lost there.
            return;
        }
        let place = (0.5 * PER_OCTAVE as f32) * log2(squared) - PER_OCTAVE as f32 * log2(self.first_per_mm);
        let place = place.clamp(0.0, (self.count - 2) as f32);
        let (i, part) = (place as usize, place.fract());
        let turn = half_turn(x, y) * self.directions as f32;
        let a = (turn as usize).min(self.directions - 1);
        let across = (turn - a as f32).clamp(0.0, 1.0);
        let b = if a + 1 == self.directions { 0 } else { a + 1 };
        let [near, far] = [i, i + 1].map(|i| &self.values[i * self.directions..][..self.directions]);
        let scale = -weight * frequency;
        let [w00, w01] = [scale * (1.0 - across) * (1.0 - part), scale * (1.0 - across) * part];
        let [w10, w11] = [scale * across * (1.0 - part), scale * across * part];
        for c in 0..9 {
            sum[c] += w00 * near[a][c] + w01 * far[a][c] + w10 * near[b][c] + w11 * far[b][c];
        }
    }
}

/// Averages over directions, by a triangle as wide on both sides as so many of them: a box twice. The last direction is next to the first.
fn smooth(values: &mut [[f32; 9]], width: f64) {
    let half = ((width - 1.0) * 0.5).round() as usize;
    let (n, side) = (values.len(), 2 * half + 1);
    if half == 0 || side > n {
        return;
    }
    let mut column = vec![0.0; n];
    for c in 0..9 {
        for _ in 0..2 {
            column.iter_mut().zip(values.iter()).for_each(|(to, value)| *to = f64::from(value[c]));
            let at = |i: usize| column[i % n];
            let mut sum: f64 = (0..side).map(|i| at(i + n - half)).sum();
            for (i, value) in values.iter_mut().enumerate() {
                value[c] = (sum / side as f64) as f32;
                sum += at(i + half + 1) - at(i + n - half);
            }
        }
    }
}

/// The weight of a frequency in sampling rates, 1 − 3 f² + 2 |f|³: its copies around all multiples of the rate sum to one, and it is zero
/// at all of them but 0. Its transform, a pixel's light, so has the integral one, is zero at all other pixels' middles, falls as the fourth
/// power of the distance, and is nowhere below −2.2 %.
fn weight(frequency: f32) -> f32 {
    let x = frequency.abs().min(1.0);
    1.0 - x * x * (3.0 - 2.0 * x)
}

/// Binary logarithm of a positive number to 2e-6: by the series of artanh about 1.
#[inline]
fn log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let mut exponent = (bits >> 23) as i32 - 127;
    let mut mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    if mantissa > std::f32::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1;
    }
    let z = (mantissa - 1.0) / (mantissa + 1.0);
    let z2 = z * z;
    let series = z * (2.0 + z2 * (2.0 / 3.0 + z2 * (0.4 + z2 * (2.0 / 7.0))));
    exponent as f32 + series * std::f32::consts::LOG2_E
}

/// The angle of a direction as a part of half a turn, 0 to 1: directions that are opposite count as one. To 3e-6.
#[inline]
fn half_turn(x: f32, y: f32) -> f32 {
    let (x, y) = if y < 0.0 { (-x, -y) } else { (x, y) };
    let (least, most) = (x.abs().min(y), x.abs().max(y));
    let t = least / most.max(f32::MIN_POSITIVE);
    // The arc tangent from 0 to 1: half of it by (√(1 + t²) − 1) / t, then its series.
    let h = t / (1.0 + (1.0 + t * t).sqrt());
    let h2 = h * h;
    let series = h * (1.0 - h2 * (1.0 / 3.0 - h2 * (0.2 - h2 * (1.0 / 7.0 - h2 * (1.0 / 9.0 - h2 * (1.0 / 11.0))))));
    let mut angle = 2.0 * series;
    if y > x.abs() {
        angle = FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    angle / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_all_copies_sum_to_one() {
        for i in 0..=200 {
            let f = i as f32 / 200.0 - 0.5;
            let sum: f32 = (-2..=2).map(|k| weight(f + k as f32)).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{f} {sum}");
        }
        assert!(weight(0.0) == 1.0 && weight(1.0) == 0.0 && weight(1.5) == 0.0);
    }

    #[test]
    fn logarithms_and_angles_are_near_enough() {
        for i in 1..4000 {
            let x = (i as f32 * 0.013).exp2() * 1e-7;
            assert!((log2(x) - x.log2()).abs() < 1e-5, "{x}");
            let angle = PI * i as f32 / 4000.0;
            let found = half_turn(angle.cos() * x, angle.sin() * x);
            assert!((found - i as f32 / 4000.0).abs() < 5e-6, "{i} {found}");
            assert!((half_turn(-angle.cos(), -angle.sin()) - found).abs() < 5e-6);
        }
    }
}
