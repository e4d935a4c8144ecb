//! Which wavelengths the film sees, and with what weight in each colour channel.
//!
//! The scene is described in three colours, a dispersing lens wants wavelengths. Each channel of the scene's
//! light is taken to be spread over one band of the spectrum, and the film's channel answers to that same band
//! with area one. A lens without dispersion therefore changes no colour, exactly; one with dispersion smears
//! each band as its indices say.

use crate::Rgb;

/// Centre and standard deviation, nm, of the red, green and blue bands: Gaussians laid over the main positive
/// lobes that the CIE 1931 2-degree observer has after conversion to Rec.709 primaries.
const BANDS_NM: [(f64, f64); 3] = [(604.0, 33.0), (543.0, 36.0), (450.0, 23.0)];

/// Ends of the sampled spectrum, nm. Old glass catalogues are fitted for 400 to 700 nm only, and the bands
/// hold less than 2 % of their light outside.
const RANGE_NM: (f64, f64) = (400.0, 700.0);

/// How many wavelengths a spectral film tells apart. More makes set-up slower (one lens, one set of indices
/// each); fewer shows as separate images of a bright point where the lens disperses by more pixels than this.
const SPECTRAL_COUNT: usize = 48;

/// One wavelength that the film samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmWavelength {
    /// In air, as glass catalogues count it, nm.
    pub nm: f64,
    /// What a unit of radiance adds to each channel; averages to one over all wavelengths.
    pub weight: Rgb,
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
        Self { wavelengths: vec![FilmWavelength { nm, weight: Rgb::ONE }] }
    }

    /// The visible spectrum in bands of equal importance to the film.
    pub fn visible() -> Self {
        // The chance of a wavelength is the mean of the three bands: no channel's weight exceeds three.
        let steps = 3000;
        let step_nm = (RANGE_NM.1 - RANGE_NM.0) / steps as f64;
        let mean_band = |nm: f64| BANDS_NM.iter().map(|&band| gaussian(nm, band)).sum::<f64>() / 3.0;
        let mut cumulative = Vec::with_capacity(steps + 1);
        let mut total = 0.0;
        cumulative.push(0.0);
        for i in 0..steps {
            total += mean_band(RANGE_NM.0 + (i as f64 + 0.5) * step_nm) * step_nm;
            cumulative.push(total);
        }
        let mut wavelengths: Vec<FilmWavelength> = (0..SPECTRAL_COUNT)
            .map(|k| {
                let target = (k as f64 + 0.5) / SPECTRAL_COUNT as f64 * total;
                let i = cumulative.partition_point(|&c| c < target).clamp(1, steps);
                let part = (target - cumulative[i - 1]) / (cumulative[i] - cumulative[i - 1]);
                let nm = RANGE_NM.0 + (i as f64 - 1.0 + part) * step_nm;
                let p = mean_band(nm);
                let weight = BANDS_NM.map(|band| (gaussian(nm, band) / p) as f32);
                FilmWavelength { nm, weight: Rgb::from_array(weight) }
            })
            .collect();
        let mean = wavelengths.iter().map(|w| w.weight).sum::<Rgb>() / SPECTRAL_COUNT as f32;
        for w in &mut wavelengths {
            w.weight /= mean;
        }
        Self { wavelengths }
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
}

/// The normal distribution of `(mean, deviation)` at `x`, area one.
fn gaussian(x: f64, (mean, deviation): (f64, f64)) -> f64 {
    let z = (x - mean) / deviation;
    (-0.5 * z * z).exp() / (deviation * (2.0 * std::f64::consts::PI).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_card_stays_white() {
        for spectrum in [FilmSpectrum::single(587.5618), FilmSpectrum::visible()] {
            let list = spectrum.wavelengths();
            let mean = list.iter().map(|w| w.weight).sum::<Rgb>() / list.len() as f32;
            assert!((mean - Rgb::ONE).abs().max_element() < 1e-5, "{mean}");
        }
    }

    #[test]
    fn bands_come_in_the_order_of_the_rainbow() {
        let spectrum = FilmSpectrum::visible();
        let list = spectrum.wavelengths();
        assert!(list.windows(2).all(|w| w[0].nm < w[1].nm));
        assert!(list[0].weight.z > list[0].weight.x);
        assert!(list[list.len() - 1].weight.x > list[list.len() - 1].weight.z);
        assert!(list.iter().all(|w| w.weight.min_element() >= 0.0 && w.weight.max_element() < 3.2));
        assert_eq!(spectrum.sample(0.0), 0);
        assert_eq!(spectrum.sample(1.0), list.len() - 1);
    }
}
