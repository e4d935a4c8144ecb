//! Light of every pixel spread over the picture, by a kernel that is given as a transfer function: a convolution by FFT.
//!
//! The result is the *change* of the picture, so that the bits of a pixel which gives and gets nothing stay as they are, and a compositor
//! can weigh it. The transform has zeros beyond the picture, as wide and high as it: light that leaves on one side does not come in on the
//! other. Light beyond the picture's edge is not known; for each pixel it counts as equal to the pixel itself, so that an even picture
//! stays even up to its edges.
//!
//! Rows and columns are shared out among threads, each is summed in one order: the bits do not depend on how many there are.

use crate::Rgb;
use glam::Mat3;
use petzval_fourier::{Complex, ComplexToReal, Direction, Fft, RealToComplex, complex_f32, real_back_f32, real_f32};
use rayon::prelude::*;
use std::sync::Arc;

/// Columns or rows that go together: a line of the cache.
const BLOCK: usize = 8;
/// Channels of the picture: red, green, blue, and that of an even white one.
const CHANNELS: usize = 4;
/// Channels of the change: three colours of the picture's, and three of an even white one's.
const CHANGES: usize = 6;

/// The transfer function of a kernel.
pub trait Transfer: Sync {
    /// The change of the frequencies `across`, in cycles a pixel (0 to 1/2), and `up` (-1/2 to 1/2): the matrix by which the spectrum of
    /// red, green and blue is multiplied, less the identity. One for each of `up`. The kernel is real and looks alike after half a
    /// turn.
    fn change(&self, across: f32, up: &[f32], out: &mut [Mat3]);
}

/// A part of the picture and the kernel of its light.
pub struct Zone<'a> {
    /// The part of a pixel's light that is spread by this kernel, by column: the product of this and [`Self::rows`]. All zones' together
    /// are 1.
    pub columns: Vec<f32>,
    /// The part of a pixel's light that is spread by this kernel, by row.
    pub rows: Vec<f32>,
    /// The transfer function of the zone's kernel.
    pub transfer: &'a dyn Transfer,
}

/// A picture whose light is being spread, zone by zone.
pub struct Spreading<'a> {
    picture: &'a [Rgb],
    fft: Option<Transforms>,
    changes: Vec<Complex<f32>>,
}

impl<'a> Spreading<'a> {
    /// The spreading of a picture of `width` by `height` pixels, rows from below.
    pub fn new(picture: &'a [Rgb], [width, height]: [usize; 2]) -> Self {
        let fft = (width * height > 0 && picture.len() == width * height).then(|| Transforms::new(width, height));
        let count = fft.as_ref().map_or(0, |fft| fft.frequencies * CHANGES * height);
        Self { picture, fft, changes: vec![Complex::default(); count] }
    }

    /// Spreads a zone's light.
    pub fn add(&mut self, zone: &Zone<'_>) {
        if let Some(fft) = &self.fft {
            let rows = fft.rows(self.picture, zone);
            fft.columns(&rows, zone.transfer, &mut self.changes);
        }
    }

    /// The change of the picture by all zones.
    pub fn finish(self) -> Vec<Rgb> {
        self.fft.map_or_else(|| vec![Rgb::ZERO; self.picture.len()], |fft| fft.back(&self.changes, self.picture))
    }
}

/// The change of a picture by one kernel for the whole of it.
pub fn change(picture: &[Rgb], [width, height]: [usize; 2], transfer: &dyn Transfer) -> Vec<Rgb> {
    let mut spreading = Spreading::new(picture, [width, height]);
    spreading.add(&Zone { columns: vec![1.0; width], rows: vec![1.0; height], transfer });
    spreading.finish()
}

/// A size at least as large that transforms fast: no prime factor above 5.
fn good_size(least: usize) -> usize {
    let is_good = |n: &usize| {
        let mut rest = *n;
        for prime in [2, 3, 5] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        rest == 1
    };
    (least.next_multiple_of(2)..).step_by(2).find(is_good).unwrap_or(least)
}

/// Sides of the transform. Light that goes farther than they reach comes in at the other side: of a wide picture they are more than
/// twice as high, so that it comes from as far away.
pub(super) fn padded([width, height]: [usize; 2]) -> [usize; 2] {
    let side = |own: usize, other: usize| good_size((2 * own).max((2 * other).min(3 * own)));
    [side(width, height), side(height, width)]
}

/// Time of the transforms of a picture over that of another, by their sizes: that of n values takes about n log n.
pub(super) fn transform_growth(from: [usize; 2], to: [usize; 2]) -> f64 {
    let [from, to] = [from, to].map(|size| {
        let values = padded(size).iter().product::<usize>() as f64;
        values * values.max(2.0).ln()
    });
    to / from
}

struct Transforms {
    width: usize,
    height: usize,
    /// Sizes of rows and columns with their zeros.
    sides: [usize; 2],
    /// Number of frequencies of a row's spectrum.
    frequencies: usize,
    row: Arc<dyn RealToComplex<f32>>,
    row_back: Arc<dyn ComplexToReal<f32>>,
    column: Arc<dyn Fft<f32>>,
    column_back: Arc<dyn Fft<f32>>,
}

impl Transforms {
    fn new(width: usize, height: usize) -> Self {
        let sides = padded([width, height]);
        Self {
            width,
            height,
            sides,
            frequencies: sides[0] / 2 + 1,
            row: real_f32(sides[0]),
            row_back: real_back_f32(sides[0]),
            column: complex_f32(sides[1], Direction::Forward),
            column_back: complex_f32(sides[1], Direction::Back),
        }
    }

    /// Spectra of the rows of a zone: by row, by channel.
    fn rows(&self, picture: &[Rgb], zone: &Zone<'_>) -> Vec<Complex<f32>> {
        let mut spectra = vec![Complex::default(); self.height * CHANNELS * self.frequencies];
        let one = |(y, spectra): (usize, &mut [Complex<f32>])| {
            let (mut values, mut scratch) = (self.row.make_input_vec(), self.row.make_scratch_vec());
            let pixels = &picture[y * self.width..(y + 1) * self.width];
            for (channel, spectrum) in spectra.chunks_exact_mut(self.frequencies).enumerate() {
                values.fill(0.0);
                for ((value, pixel), part) in values.iter_mut().zip(pixels).zip(&zone.columns) {
                    let light = if channel < 3 { pixel[channel] } else { 1.0 };
                    // What is no number stays where it is.
                    *value = if light.is_finite() { light * part * zone.rows[y] } else { 0.0 };
                }
                // The lengths are the plan's own.
                let _ = self.row.process_with_scratch(&mut values, spectrum, &mut scratch);
            }
        };
        spectra.par_chunks_exact_mut(CHANNELS * self.frequencies).enumerate().for_each(one);
        spectra
    }

    /// Adds a zone's change: by column of the spectrum, by channel of the change, by row of the picture.
    fn columns(&self, rows: &[Complex<f32>], transfer: &dyn Transfer, changes: &mut [Complex<f32>]) {
        let (height, side) = (self.height, self.sides[1]);
        let up: Vec<f32> =
            (0..side).map(|i| if 2 * i <= side { i as f32 } else { i as f32 - side as f32 } / side as f32).collect();
        let block = |(first, changes): (usize, &mut [Complex<f32>])| {
            let first = first * BLOCK;
            let count = changes.len() / (CHANGES * height);
            let mut spectra = vec![Complex::default(); CHANNELS * count * side];
            for y in 0..height {
                for channel in 0..CHANNELS {
                    let from = (y * CHANNELS + channel) * self.frequencies + first;
                    for (k, value) in rows[from..from + count].iter().enumerate() {
                        spectra[(channel * count + k) * side + y] = *value;
                    }
                }
            }
            let mut scratch = vec![Complex::default(); self.column.get_inplace_scratch_len()];
            self.column.process_with_scratch(&mut spectra, &mut scratch);
            let mut matrices = vec![Mat3::ZERO; side];
            let mut changed = vec![Complex::default(); CHANGES * side];
            scratch.resize(self.column_back.get_inplace_scratch_len(), Complex::default());
            for k in 0..count {
                transfer.change((first + k) as f32 / self.sides[0] as f32, &up, &mut matrices);
                let of = |channel: usize| &spectra[(channel * count + k) * side..][..side];
                let (red, green, blue, white) = (of(0), of(1), of(2), of(3));
                for (i, m) in matrices.iter().enumerate() {
                    for c in 0..3 {
                        let [r, g, b] = [m.x_axis[c], m.y_axis[c], m.z_axis[c]];
                        changed[c * side + i] = red[i] * r + green[i] * g + blue[i] * b;
                        changed[(c + 3) * side + i] = white[i] * (r + g + b);
                    }
                }
                self.column_back.process_with_scratch(&mut changed, &mut scratch);
                let into = &mut changes[k * CHANGES * height..(k + 1) * CHANGES * height];
                for (to, from) in into.chunks_exact_mut(height).zip(changed.chunks_exact(side)) {
                    to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
                }
            }
        };
        changes.par_chunks_mut(BLOCK * CHANGES * height).enumerate().for_each(block);
    }

    /// The change of the picture.
    fn back(&self, changes: &[Complex<f32>], picture: &[Rgb]) -> Vec<Rgb> {
        let scale = 1.0 / (self.sides[0] as f32 * self.sides[1] as f32);
        let mut found = vec![Rgb::ZERO; self.width * self.height];
        let block = |(first, found): (usize, &mut [Rgb])| {
            let first = first * BLOCK;
            let count = found.len() / self.width;
            let mut spectra = vec![Complex::default(); CHANGES * count * self.frequencies];
            for x in 0..self.frequencies {
                for channel in 0..CHANGES {
                    let from = (x * CHANGES + channel) * self.height + first;
                    for (k, value) in changes[from..from + count].iter().enumerate() {
                        spectra[(channel * count + k) * self.frequencies + x] = *value;
                    }
                }
            }
            let mut values = vec![0.0; CHANGES * self.sides[0]];
            let mut scratch = self.row_back.make_scratch_vec();
            for k in 0..count {
                for channel in 0..CHANGES {
                    let spectrum = &mut spectra[(channel * count + k) * self.frequencies..][..self.frequencies];
                    // Of a real row both ends are real.
                    spectrum[0].im = 0.0;
                    spectrum[self.frequencies - 1].im = 0.0;
                    let row = &mut values[channel * self.sides[0]..][..self.sides[0]];
                    let _ = self.row_back.process_with_scratch(spectrum, row, &mut scratch);
                }
                let of = |channel: usize, x: usize| values[channel * self.sides[0] + x] * scale;
                for x in 0..self.width {
                    let [change, white] = [0, 3].map(|c| Rgb::new(of(c, x), of(c + 1, x), of(c + 2, x)));
                    let pixel = picture[(first + k) * self.width + x];
                    let own = if pixel.is_finite() { pixel } else { Rgb::ZERO };
                    found[k * self.width + x] = change - white * own;
                }
            }
        };
        found.par_chunks_mut(BLOCK * self.width).enumerate().for_each(block);
        found
    }
}

#[cfg(test)]
mod tests;
