//! The wavelengths that the film sees, and the contribution of the scene's light at each of them to the picture's colour.
//!
//! The scene is described in three colours, a dispersing lens wants wavelengths. A scene colour (r, g, b) is taken for
//! the spectrum (r b_r + g b_g + b b_b) D65, with the basis of Mallett and Yuksel 2019: it is linear, and white is D65
//! itself. The film answers as the CIE 1931 2-degree observer, turned from XYZ to linear Rec.709. So a wavelength's
//! light acts on a colour as a matrix; the mean of these over all wavelengths is the identity, and a lens without
//! dispersion changes no colour. Single wavelengths lie outside of Rec.709: their matrices have negative entries, and so
//! may the pixels of a fringe.

mod tables;

use glam::{DMat3, DVec3, Mat3};
use tables::{FIRST_NM, ROWS, STEP_NM};

/// Linear Rec.709 from XYZ (IEC 61966-2-1), rows.
const REC_709_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266_0, 1.876_010_8, 0.041_556_0],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// Number of wavelengths that a spectral film tells apart. More makes set-up slower (one lens, one set of indices each); fewer shows as
/// separate images of a bright point where the lens disperses by more pixels than this.
pub const SPECTRAL_COUNT: usize = 48;

/// Number of wavelengths that a path can carry at a time: a [`FilmSpectrum`] falls into sets of so many. Divides [`SPECTRAL_COUNT`].
pub const SET_SIZE: usize = 8;

/// Wavelengths of three indices that stand for the whole spectrum: the dominant wavelengths of the Rec.709 primaries, nm.
const PRIMARIES_NM: [f64; 3] = [464.2, 549.1, 611.4];

/// One wavelength that the film samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmWavelength {
    /// Wavelength in air, as glass catalogues count it, nm.
    pub nm: f64,
    /// Contribution of radiance of a scene colour to the picture's; averages to the identity over all wavelengths.
    pub response: Mat3,
}

/// The wavelengths of a film, each chosen with the same probability.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSpectrum {
    wavelengths: Vec<FilmWavelength>,
}

impl FilmSpectrum {
    /// Light of one wavelength drives all three channels alike: the picture keeps the scene's colours and
    /// shows the lens without its dispersion.
    pub fn single(nm: f64) -> Self {
        Self { wavelengths: vec![FilmWavelength { nm, response: Mat3::IDENTITY }] }
    }

    /// One wavelength for each channel, as Lee, Eisemann and Seidel 2010 have it.
    pub fn three() -> Self {
        let channel = |i: usize| {
            let mut diagonal = glam::Vec3::ZERO;
            diagonal[2 - i] = 3.0;
            FilmWavelength { nm: PRIMARIES_NM[i], response: Mat3::from_diagonal(diagonal) }
        };
        Self { wavelengths: [0, 1, 2].map(channel).to_vec() }
    }

    /// The visible spectrum in bands of equal importance to the film.
    pub fn visible() -> Self {
        Self::visible_in(SPECTRAL_COUNT)
    }

    /// The visible spectrum in `count` bands of equal importance to the film, a multiple of [`SET_SIZE`]: fewer do where the lens disperses
    /// little.
    pub fn visible_in(count: usize) -> Self {
        Self::seen_in(count, &film)
    }

    /// As [`Self::visible_in`], for a film whose answer to even light is `film`, linear Rec.709 per nm: in the mean over all wavelengths it sees
    /// the scene's colours as they are.
    pub fn seen_in(count: usize, film: &dyn Fn(f64) -> DVec3) -> Self {
        // The chance of a wavelength is the size of the film's answer to white: no sample outweighs the others.
        let fine = 20;
        let step_nm = STEP_NM / f64::from(fine);
        let steps = fine as usize * (ROWS.len() - 1);
        let at = |i: f64| FIRST_NM + i * step_nm;
        let response = |nm: f64| answer(film(nm), nm);
        let importance = |nm: f64| (response(nm) * DVec3::ONE).length();
        let mut cumulative = vec![0.0];
        for i in 0..steps {
            cumulative.push(cumulative[i] + importance(at(i as f64 + 0.5)));
        }
        let total = cumulative[steps];
        let one = |k: usize| {
            let target = (k as f64 + 0.5) / count as f64 * total;
            let i = cumulative.partition_point(|&c| c < target).clamp(1, steps);
            let part = (target - cumulative[i - 1]) / (cumulative[i] - cumulative[i - 1]);
            let nm = at(i as f64 - 1.0 + part);
            (nm, response(nm) * importance(nm).recip())
        };
        let mut list: Vec<(f64, DMat3)> = (0..count).map(one).collect();
        // What the bands' middles miss of the integral, some 1e-3, is made up on the film's side.
        let mean = list.iter().fold(DMat3::ZERO, |sum, (_, m)| sum + *m) * (count as f64).recip();
        let correct = mean.inverse();
        let wavelengths =
            list.drain(..).map(|(nm, m)| FilmWavelength { nm, response: (correct * m).as_mat3() }).collect();
        Self { wavelengths }
    }

    /// This spectrum behind something that makes `tint` of each scene colour.
    pub fn tinted(mut self, tint: Mat3) -> Self {
        for line in &mut self.wavelengths {
            line.response = tint * line.response;
        }
        self
    }

    /// All wavelengths, in rising order.
    pub fn wavelengths(&self) -> &[FilmWavelength] {
        &self.wavelengths
    }

    /// The index of the wavelength that the uniform number `u` in [0, 1) chooses.
    #[inline]
    pub fn sample(&self, u: f32) -> usize {
        ((u * self.wavelengths.len() as f32) as usize).min(self.wavelengths.len() - 1)
    }

    /// Number of sets of wavelengths, each spread evenly over the spectrum: set s holds the numbers s, s + sets, s + 2 sets, ...
    pub fn sets(&self) -> usize {
        self.wavelengths.len().div_ceil(SET_SIZE)
    }

    /// Number of wavelengths in each set: at most [`SET_SIZE`].
    pub fn set_size(&self) -> usize {
        self.wavelengths.len() / self.sets()
    }
}

/// The film's answer to even light, linear Rec.709 per nm.
pub fn film(nm: f64) -> DVec3 {
    rec_709_from_xyz() * observer(nm)
}

/// The CIE 1931 2-degree observer's x, y and z at a wavelength, nm.
pub fn observer(nm: f64) -> DVec3 {
    let [x, y, z, ..] = row(nm);
    DVec3::new(x, y, z)
}

/// Linear Rec.709 from CIE XYZ.
pub fn rec_709_from_xyz() -> DMat3 {
    DMat3::from_cols_array_2d(&REC_709_FROM_XYZ).transpose()
}

/// The wavelengths of the tables, nm, in steps of `step_nm`, and the power there of the lights that a scene's red, green and blue stand for;
/// all three together are D65, relative, as its table has it.
pub fn scene_lights(step_nm: f64) -> impl Iterator<Item = (f64, DVec3)> {
    let steps = ((ROWS.len() - 1) as f64 * STEP_NM / step_nm).round() as usize;
    (0..=steps).map(move |i| {
        let nm = FIRST_NM + step_nm * i as f64;
        (nm, light(nm))
    })
}

/// The power at `nm` of the lights that a scene's red, green and blue stand for.
fn light(nm: f64) -> DVec3 {
    let [.., white, red, green, blue] = row(nm);
    DVec3::new(red, green, blue) * white
}

/// The tables' columns at a wavelength.
fn row(nm: f64) -> [f64; 7] {
    let place = ((nm - FIRST_NM) / STEP_NM).clamp(0.0, (ROWS.len() - 1) as f64);
    let i = (place as usize).min(ROWS.len() - 2);
    std::array::from_fn(|c| ROWS[i][c] + (ROWS[i + 1][c] - ROWS[i][c]) * (place - i as f64))
}

/// The answer at `nm` of a film, which answers so to even light, to the spectra that a scene's red, green and blue stand for.
fn answer(film: DVec3, nm: f64) -> DMat3 {
    let light = light(nm);
    DMat3::from_cols(film * light.x, film * light.y, film * light.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rgb;

    fn mean(spectrum: &FilmSpectrum) -> Mat3 {
        let list = spectrum.wavelengths();
        list.iter().fold(Mat3::ZERO, |sum, w| sum + w.response) * (list.len() as f32).recip()
    }

    #[test]
    fn no_colour_shifts_without_dispersion() {
        for spectrum in [FilmSpectrum::single(587.5618), FilmSpectrum::three(), FilmSpectrum::visible()] {
            assert!(mean(&spectrum).abs_diff_eq(Mat3::IDENTITY, 2e-6), "{:?}", mean(&spectrum));
        }
    }

    /// The tables belong together: each primary's spectrum under D65, seen by the observer, is that primary. Mallett
    /// and Yuksel state 1e-4 or so for their rounded data.
    #[test]
    fn the_basis_reproduces_the_primaries() {
        let sum = |f: &dyn Fn(&[f64; 7]) -> f64| ROWS.iter().map(f).sum::<f64>();
        let white = sum(&|row| row[1] * row[3]);
        let all = (0..ROWS.len())
            .fold(DMat3::ZERO, |m, i| m + answer(film(FIRST_NM + STEP_NM * i as f64), FIRST_NM + STEP_NM * i as f64));
        assert!((all * white.recip()).abs_diff_eq(DMat3::IDENTITY, 2e-4), "{all:?}");
        assert!(ROWS.iter().all(|row| (row[4] + row[5] + row[6] - 1.0).abs() < 2e-5));
        // D65's chromaticity.
        let xyz = [0, 1, 2].map(|c| sum(&|row| row[c] * row[3]));
        let total: f64 = xyz.iter().sum();
        assert!((xyz[0] / total - 0.3127).abs() < 1e-4 && (xyz[1] / total - 0.3290).abs() < 1e-4);
    }

    #[test]
    fn wavelengths_come_in_the_order_of_the_rainbow() {
        let spectrum = FilmSpectrum::visible();
        let list = spectrum.wavelengths();
        assert!(list.windows(2).all(|w| w[0].nm < w[1].nm));
        let white = |i: usize| list[i].response * Rgb::ONE;
        assert!(white(0).z > white(0).x);
        assert!(white(list.len() - 1).x > white(list.len() - 1).z);
        // All answers to white are of one size: that is what their chance is for.
        let size = white(0).length();
        assert!((0..list.len()).all(|i| (white(i).length() / size - 1.0).abs() < 0.02), "{size}");
        assert_eq!(spectrum.sample(0.0), 0);
        assert_eq!(spectrum.sample(1.0), list.len() - 1);
        assert_eq!(spectrum.sets(), SPECTRAL_COUNT / SET_SIZE);
        let three = FilmSpectrum::three();
        assert!(three.wavelengths()[2].response.x_axis.x == 3.0 && three.wavelengths()[2].nm > 600.0);
    }

    /// Eight wavelengths of one set hold nearly the whole spectrum: white through a set is white to a few per cent.
    #[test]
    fn a_set_spans_the_spectrum() {
        let spectrum = FilmSpectrum::visible();
        let sets = spectrum.sets();
        for set in 0..sets {
            let picked = (0..SET_SIZE).map(|i| spectrum.wavelengths()[set + i * sets].response);
            let white = picked.fold(Mat3::ZERO, |sum, m| sum + m) * (SET_SIZE as f32).recip() * Rgb::ONE;
            assert!((white - Rgb::ONE).abs().max_element() < 0.25, "{set}: {white}");
        }
    }
}
