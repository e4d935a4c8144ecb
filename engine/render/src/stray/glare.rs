//! Veiling glare: light that surfaces scatter because they are not quite smooth or not quite clean, and light that the barrel and the
//! film reflect back.
//!
//! The scattered light of each surface of the lens, to first order ([`petzval_optics::scatter`]):
//!
//! - *Roughness* of σ rms sends the part (2π σ Δn / λ)² aside (Bennett and Porteus 1961, here in transmission), shaped as Harvey and
//!   Shack have it, (1 + (β / l)²)^(s / 2) of the sine β, with l = 0.01 at 550 nm and s = −1.5, as is usual of polished glass (Pfisterer,
//!   "Approximated scatter models for stray light analysis", Optics and Photonics News 22 (10), 2011); l grows with the wavelength, as
//!   gratings have it.
//! - *Dust* by the cleanliness level of IEST-STD-CC1246: log₁₀ N = 0.926 (log₁₀² L − log₁₀² d) particles of d µm or more on 0.1 m². Light
//!   on the area that a particle covers is diffracted around it (an Airy pattern of its size), and as much light is caught by it, of which half is
//!   scattered evenly in all directions (van de Hulst, Light Scattering by Small Particles, 1957, chapter 8).
//! - *Barrel and film*: the veiling glare index (ISO 9358, integral method), the part of the light in a world that is as bright
//!   everywhere that comes from elsewhere, laid evenly over the picture, in the light that falls on the lens's front from inside
//!   and outside of the picture. Reflections between surfaces of the glass are not in it: they are ghosts.
//!
//! Scattered light is taken from the direct light.

use super::sampled::Sampled;
use super::spread;
pub use crate::camera::scattering::Scattering;
use crate::camera::tools::survey::Survey;
use crate::camera::{CameraDescription, CameraError};
use crate::spectrum::FilmSpectrum;
use crate::{Rgb, luminance};
use petzval_optics::scatter::Scatterer;
use std::f64::consts::{PI, TAU};
use std::time::Instant;

/// Harvey and Shack's shape: the shoulder at 550 nm, and the slope.
const SHOULDER: f64 = 0.01;
const SLOPE: f64 = -1.5;
const AT_NM: f64 = 550.0;
/// The part of the light caught by a particle that it scatters.
const THROWN_ON: f64 = 0.5;
/// Sizes of particles to the double.
const SIZES_PER_OCTAVE: u32 = 8;
/// Distances on the film to the double.
const PER_OCTAVE: f64 = 12.0;
/// Pixels near the middle are taken in so many parts a side.
const PARTS: usize = 16;
const NEAR: usize = 3;
/// The part of the picture that is brightest does not count as its exposure.
const TRIMMED: f64 = 0.02;

/// The glare of a lens in a picture.
pub struct Glare {
    size: [usize; 2],
    pixel_mm: [f64; 2],
    scattering: Scattering,
    /// The halos of red, green and blue.
    colours: [Halo; 3],
}

/// The light of one wavelength that surfaces scatter.
struct Halo {
    /// The scattered light, as a part of all light.
    part: f64,
    /// The first distance, mm.
    first_mm: f64,
    /// Density on the film, per mm², at distances [`PER_OCTAVE`] to the double.
    density: Vec<f64>,
}

impl Glare {
    /// The glare of the lens of a camera, for a picture of that many pixels.
    ///
    /// # Errors
    /// As [`crate::camera::Camera::new`].
    pub fn new(d: &CameraDescription, [width, height]: [u32; 2]) -> Result<Self, CameraError> {
        let survey = Survey::new(d, width, height)?;
        Ok(Self::of_surfaces(&survey.scatterers(), d.scattering, survey.pixel_mm(), [width as usize, height as usize]))
    }

    /// The glare of surfaces. `pixel_mm` is a pixel's width and height.
    pub fn of_surfaces(surfaces: &[Scatterer], scattering: Scattering, pixel_mm: [f64; 2], size: [usize; 2]) -> Self {
        let three = FilmSpectrum::three();
        // From blue to red, as the film's wavelengths are.
        let nm = |channel: usize| three.wavelengths()[2 - channel].nm;
        let first_mm = pixel_mm[0].min(pixel_mm[1]) / (4 * PARTS) as f64;
        let farthest_mm = (2.0 * pixel_mm[0] * size[0] as f64).hypot(2.0 * pixel_mm[1] * size[1] as f64);
        let colours = [0, 1, 2].map(|c| Halo::new(surfaces, &scattering, nm(c), [first_mm, 2.0 * farthest_mm]));
        Self { size, pixel_mm, scattering, colours }
    }

    /// The part of the light that surfaces scatter, by red, green and blue.
    pub fn scattered(&self) -> [f64; 3] {
        [0, 1, 2].map(|c| self.colours[c].part)
    }

    /// All light that does not arrive where it should, as a part, in green.
    pub fn part(&self) -> f64 {
        self.colours[1].part + self.scattering.veiling_index
    }

    /// Wall time of [`Self::change`], s, by a small picture of the same view, `picture`, whose glare is `small`.
    pub fn expected_seconds(&self, small: &Self, picture: &[Rgb], front_light: Option<f64>) -> f64 {
        let start = Instant::now();
        small.change(picture, front_light);
        start.elapsed().as_secs_f64() * spread::transform_growth(small.size, self.size)
    }

    /// The change of a picture by glare, rows from below. `front_light` is the irradiance on the lens's front over that of a world as
    /// bright all over as the picture is without its brightest places (as the plan measures it); `None`: the picture's own light.
    pub fn change(&self, picture: &[Rgb], front_light: Option<f64>) -> Vec<Rgb> {
        let taken = Rgb::from([0, 1, 2].map(|c| self.colours[c].part as f32));
        let mut change = if taken.max_element() > 0.0 {
            let sampled = Sampled::new(self.size, taken, |right, up| self.of_pixel(right, up));
            spread::change(picture, self.size, &sampled)
        } else {
            vec![Rgb::ZERO; picture.len()]
        };
        let index = self.scattering.veiling_index as f32;
        if index > 0.0 {
            let veil = veil(picture, front_light) * index;
            for (change, pixel) in change.iter_mut().zip(picture) {
                *change += if pixel.is_finite() { veil - *pixel * index } else { veil };
            }
        }
        change
    }

    /// The part of a pixel's light that arrives so many pixels aside.
    fn of_pixel(&self, right: usize, up: usize) -> Rgb {
        let area = self.pixel_mm[0] * self.pixel_mm[1];
        let density = |x: f64, y: f64| {
            let mm = (x * self.pixel_mm[0]).hypot(y * self.pixel_mm[1]);
            Rgb::from([0, 1, 2].map(|c| self.colours[c].at(mm) as f32))
        };
        if right > NEAR || up > NEAR {
            return density(right as f64, up as f64) * area as f32;
        }
        let part = |i: usize| (i as f64 + 0.5) / PARTS as f64 - 0.5;
        let parts = (0..PARTS * PARTS).map(|i| density(right as f64 + part(i % PARTS), up as f64 + part(i / PARTS)));
        parts.sum::<Rgb>() * (area / (PARTS * PARTS) as f64) as f32
    }
}

/// The light of a world that is as bright all over as the light that falls on the front, in the picture's units and colours.
fn veil(picture: &[Rgb], front_light: Option<f64>) -> Rgb {
    let finite = picture.iter().filter(|c| c.is_finite());
    let (count, sum) = finite.clone().fold((0.0, glam::DVec3::ZERO), |(n, sum), c| (n + 1.0, sum + c.as_dvec3()));
    let mean = (sum / f64::max(count, 1.0)).as_vec3();
    let Some(front) = front_light else { return mean };
    let mut light: Vec<f32> = finite.map(|c| luminance(*c)).collect();
    light.sort_by(f32::total_cmp);
    light.truncate(((1.0 - TRIMMED) * light.len() as f64).ceil() as usize);
    let exposure = light.iter().map(|&l| f64::from(l)).sum::<f64>() / light.len().max(1) as f64;
    let of_mean = luminance(mean);
    if of_mean > 0.0 { mean * ((front * exposure) as f32 / of_mean) } else { Rgb::splat((front * exposure) as f32) }
}

impl Halo {
    fn new(surfaces: &[Scatterer], scattering: &Scattering, nm: f64, [first_mm, last_mm]: [f64; 2]) -> Self {
        let count = ((last_mm / first_mm).log2() * PER_OCTAVE).ceil() as usize + 2;
        let rough = ScatterProfile::harvey(SHOULDER * nm / AT_NM);
        let dust = ScatterProfile::dust(scattering.cleanliness, nm);
        let mut halo = Self { part: 0.0, first_mm, density: vec![0.0; count] };
        for surface in surfaces {
            let phase = TAU * scattering.roughness_nm * surface.path_per_height / nm;
            // What a rougher surface would scatter more than once is more than all.
            let of_roughness = -(-phase * phase).exp_m1();
            let shapes = [(of_roughness, Some(&rough)), (1.0, dust.as_ref().filter(|_| surface.is_open))];
            for (part, shape) in shapes.into_iter().filter_map(|(part, shape)| Some((part, shape?))) {
                halo.part += part * shape.whole;
                for (i, density) in halo.density.iter_mut().enumerate() {
                    let mm = first_mm * (i as f64 / PER_OCTAVE).exp2();
                    *density += part * shape.at(mm / surface.reach_mm) / surface.reach_mm.powi(2);
                }
            }
        }
        // No more than all light is scattered: what many dirty surfaces would is scattered again, alike.
        let all = -(-halo.part).exp_m1();
        if halo.part > 0.0 {
            halo.density.iter_mut().for_each(|density| *density *= all / halo.part);
        }
        halo.part = all;
        halo
    }

    /// Density at a distance, per mm².
    fn at(&self, mm: f64) -> f64 {
        let place = ((mm / self.first_mm).log2() * PER_OCTAVE).clamp(0.0, (self.density.len() - 2) as f64);
        let (i, part) = (place as usize, place.fract());
        self.density[i] + (self.density[i + 1] - self.density[i]) * part
    }
}

/// Scattered light by the sine of the angle, up to 1, per unit of solid angle (of sines).
struct ScatterProfile {
    /// Values by logarithm of the sine.
    values: Vec<f64>,
    whole: f64,
}

impl ScatterProfile {
    const FIRST: f64 = 1e-7;
    const PER_OCTAVE: f64 = 12.0;

    fn sine(i: usize) -> f64 {
        Self::FIRST * (i as f64 / Self::PER_OCTAVE).exp2()
    }

    fn of(density: impl Fn(f64) -> f64) -> Self {
        let count = ((1.0 / Self::FIRST).log2() * Self::PER_OCTAVE) as usize + 1;
        let values: Vec<f64> = (0..count).map(|i| density(Self::sine(i))).collect();
        // By rings, the density as a power of the sine between two.
        let mut whole = PI * Self::FIRST.powi(2) * values[0];
        for (i, pair) in values.windows(2).enumerate() {
            let (a, b) = (Self::sine(i), Self::sine(i + 1));
            whole += 0.5 * TAU * (pair[0] * a * a + pair[1] * b * b) * (b / a).ln();
        }
        Self { values, whole }
    }

    /// Harvey's shape with this shoulder, whose integral is 1.
    fn harvey(shoulder: f64) -> Self {
        let mut shape = Self::of(|sine| (1.0 + (sine / shoulder).powi(2)).powf(0.5 * SLOPE));
        shape.values.iter_mut().for_each(|value| *value /= shape.whole);
        shape.whole = 1.0;
        shape
    }

    /// The shape of the dust on a surface of that level; `None`: there is none.
    fn dust(level: f64, nm: f64) -> Option<Self> {
        if level.is_nan() || level <= 1.0 {
            return None;
        }
        // Particles of 1 µm up to the level, by their diameters in µm; what a size covers of the surface.
        let number = |um: f64| 10f64.powf(0.926 * (level.log10().powi(2) - um.log10().powi(2))) / 1e11;
        let steps = (level.log2() * f64::from(SIZES_PER_OCTAVE)).ceil() as i32;
        let size = |i: i32| (f64::from(i) / f64::from(steps) * level.log2()).exp2();
        let sizes: Vec<(f64, f64)> = (0..steps)
            .map(|i| {
                let (small, large) = (size(i), size(i + 1));
                let um = (small * large).sqrt();
                (um, (number(small) - number(large)) * 0.25 * PI * um * um)
            })
            .collect();
        let um = nm * 1e-3;
        let density = |sine: f64| {
            let around = |&(d, covered): &(f64, f64)| covered * 0.25 * PI * (d / um).powi(2) * airy(PI * d * sine / um);
            let evenly = |&(_, covered): &(f64, f64)| covered * THROWN_ON / PI;
            sizes.iter().map(|one| around(one) + evenly(one)).sum::<f64>()
        };
        let mut shape = Self::of(density);
        // What is caught and not thrown on is lost to the picture, but is no scattered light.
        shape.whole = shape.whole.max(0.0);
        Some(shape)
    }

    fn at(&self, sine: f64) -> f64 {
        let place = ((sine / Self::FIRST).log2() * Self::PER_OCTAVE).max(0.0);
        let i = place as usize;
        match self.values.get(i + 1) {
            Some(next) => self.values[i] + (next - self.values[i]) * place.fract(),
            None => 0.0,
        }
    }
}

/// (2 J₁(x) / x)², its rings averaged out beyond the second: 4 / (π x³) (1 + 3 / 8 x²).
fn airy(x: f64) -> f64 {
    if x > 7.0 {
        return 4.0 / (PI * x.powi(3)) * (1.0 + 0.375 / (x * x));
    }
    // The power series of 2 J₁(x) / x.
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..24 {
        term *= -0.25 * x * x / (f64::from(k) * f64::from(k + 1));
        sum += term;
    }
    sum * sum
}

#[cfg(test)]
mod tests;
