//! A kernel that looks alike in all directions, pixel by pixel, as a transfer function.

use super::spread::{self, Transfer};
use crate::Rgb;
use glam::Mat3;
use petzval_fourier::{Complex, Direction, complex_f32, real_f32};
use rayon::prelude::*;

/// The transfer function of a kernel, less the part that it takes from the light that is not spread.
pub(super) struct Sampled {
    sides: [usize; 2],
    /// Values by column of the spectrum, then by row.
    values: Vec<Rgb>,
    taken: Rgb,
}

impl Sampled {
    /// `kernel` gives the part of a pixel's light that arrives so many pixels to the right and up, or to the left and down; `taken` is all
    /// that it takes, also the light that arrives beyond the picture.
    pub(super) fn new(size: [usize; 2], taken: Rgb, kernel: impl Fn(usize, usize) -> Rgb + Sync) -> Self {
        let sides = spread::padded(size);
        let [width, height] = sides;
        let (columns, rows) = (width / 2 + 1, height / 2 + 1);
        let row_fft = real_f32(width);
        // Rows look alike to the left and right: their spectra are real.
        let mut spectra = vec![Rgb::ZERO; rows * columns];
        spectra.par_chunks_mut(columns).enumerate().for_each(|(y, spectra)| {
            let half: Vec<Rgb> = (0..columns).map(|x| kernel(x, y)).collect();
            let (mut row, mut spectrum) = (row_fft.make_input_vec(), row_fft.make_output_vec());
            for channel in 0..3 {
                for (x, value) in row.iter_mut().enumerate() {
                    *value = half[x.min(width - x)][channel];
                }
                let _ = row_fft.process(&mut row, &mut spectrum);
                spectra.iter_mut().zip(&spectrum).for_each(|(to, from)| to[channel] = from.re);
            }
        });
        let column_fft = complex_f32(height, Direction::Forward);
        let mut values = vec![Rgb::ZERO; columns * height];
        values.par_chunks_mut(height).enumerate().for_each(|(x, values)| {
            let mut column = vec![Complex::default(); height];
            for channel in 0..3 {
                for (y, value) in column.iter_mut().enumerate() {
                    *value = Complex::new(spectra[y.min(height - y) * columns + x][channel], 0.0);
                }
                column_fft.process(&mut column);
                values.iter_mut().zip(&column).for_each(|(to, from)| to[channel] = from.re);
            }
        });
        Self { sides, values, taken }
    }
}

impl Transfer for Sampled {
    fn change(&self, across: f32, up: &[f32], out: &mut [Mat3]) {
        let [width, height] = self.sides;
        let x = ((across * width as f32).round() as usize).min(width / 2);
        for (matrix, up) in out.iter_mut().zip(up) {
            let y = (up * height as f32).round().rem_euclid(height as f32) as usize;
            *matrix = Mat3::from_diagonal(self.values[x * height + y.min(height - 1)] - self.taken);
        }
    }
}
