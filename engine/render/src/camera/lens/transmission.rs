//! Transmission of a lens along each ray, fast enough for millions of rays: exact surfaces and glasses ([`petzval_optics::transmission`]),
//! fitted once for a camera.
//!
//! Light that passes depends smoothly on the ray: on where it crosses the plane at the last vertex and on its direction there, whatever
//! the film's place, turn and curvature. A lens that is symmetric about its axis knows only three numbers of both. A polynomial
//! of them over the transmittance of the lens in its middle is fitted at some wavelengths, and stands straight between them; the middle
//! itself is exact at each.

mod fit;

use super::mount::Mount;
use crate::camera::{CameraDescription, Rgb};
use crate::luminance;
use crate::sampler::evenly::Evenly;
use crate::spectrum::FilmSpectrum;
use fit::Polynomial;
use glam::{DVec2, Mat3, Vec2};
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::system::System;
use petzval_optics::trace::{LINES, Ray as LensRay};
use petzval_optics::transmission::{Passage, Passages};
use wide::f32x8;

/// Rays by which the polynomial is found, and others by which it is judged.
const RAYS: usize = 420;
const JUDGES: usize = 120;
/// Wavelengths at which the transmission is fitted, at most.
const NODES: usize = 7;
/// A quarter of the rays start at the edge of the picture, and rays reach so far beyond it.
const BEYOND: f32 = 1.04;
/// Wavelengths by which white light is known where the film has but one.
const BANDS: usize = 24;

/// The lens's transmission of white light in the film's middle.
#[derive(Clone, Debug)]
pub(in crate::camera) struct Middle {
    /// The part that passes, by the film's wavelength.
    pub(in crate::camera) parts: Vec<f64>,
    /// The transform of a scene colour in the picture, before exposure.
    pub(in crate::camera) colour: Mat3,
    /// Factor of the picture, so that it is exposed as it should be.
    pub(in crate::camera) gain: f64,
    /// Factors of the picture's channels by which white in the middle is white, as bright as it was; one without white balance.
    pub(in crate::camera) balance: Rgb,
}

impl Middle {
    /// The transmission in the middle of the film; `None` if no light arrives there at all.
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        passages: &Passages<'_>,
        film_z_mm: f64,
        spectrum: &FilmSpectrum,
    ) -> Option<Self> {
        let own = lines(spectrum);
        let parts = passages.in_the_middle(film_z_mm, &own)?;
        let colour = match own.len() {
            1 => colour(&d.visible_in(BANDS), |nms| passages.in_the_middle(film_z_mm, nms))?,
            _ => colour(spectrum, |_| Some(parts.clone()))?,
        };
        let passed = f64::from(luminance(colour * Rgb::ONE));
        // By the f-number what is lost is lost; by the T-number the middle stays as bright as if nothing were.
        let gain = if d.exposes_by_f_number { 1.0 } else { passed.recip() };
        let balance = if d.white_balance { white_balance(colour * Rgb::ONE) } else { Rgb::ONE };
        (passed > 0.0).then_some(Self { parts, colour, gain, balance })
    }

    /// The transform of a scene colour in the middle of the picture, where the film has one wavelength: that of all wavelengths together.
    pub(in crate::camera) fn tint(&self) -> Mat3 {
        self.balanced() * self.colour * self.gain as f32
    }

    /// The white balance as a transform of the picture's colours.
    pub(in crate::camera) fn balanced(&self) -> Mat3 {
        Mat3::from_diagonal(self.balance)
    }

    /// The spectrum of a film of that many wavelengths with the transform that they have in common: of one the whole tint.
    pub(in crate::camera) fn tinted(&self, spectrum: FilmSpectrum) -> FilmSpectrum {
        let tint = if spectrum.wavelengths().len() == 1 { self.tint() } else { self.balanced() };
        if tint == Mat3::IDENTITY { spectrum } else { spectrum.tinted(tint) }
    }

    /// Factor of the light of the film's wavelength of that number, where the film has several.
    pub(in crate::camera) fn gain_at(&self, index: usize) -> f64 {
        self.parts[index] * self.gain
    }
}

/// Factors of the channels that make grey of this white, as bright as it is; one where a channel has nothing.
pub(in crate::camera) fn white_balance(white: Rgb) -> Rgb {
    if white.min_element() > 0.0 { Rgb::splat(luminance(white)) / white } else { Rgb::ONE }
}

/// The part of white light, weighted as the eye does, that a lens passes to the middle of its film; `None` where that is dark.
pub(in crate::camera) fn luminous(system: &System, wavelength_nm: f64, film_z_mm: f64) -> Option<f64> {
    let passages = Passages::new(system, wavelength_nm);
    let colour = colour(&FilmSpectrum::visible_in(BANDS), |nms| passages.in_the_middle(film_z_mm, nms))?;
    Some(f64::from(luminance(colour * Rgb::ONE)))
}

fn lines(spectrum: &FilmSpectrum) -> Vec<f64> {
    spectrum.wavelengths().iter().map(|w| w.nm).collect()
}

/// The transform of a scene colour whose light passes in these parts.
pub(in crate::camera) fn colour(spectrum: &FilmSpectrum, parts: impl Fn(&[f64]) -> Option<Vec<f64>>) -> Option<Mat3> {
    let parts = parts(&lines(spectrum))?;
    let sum = spectrum.wavelengths().iter().zip(&parts).fold(Mat3::ZERO, |sum, (w, p)| sum + w.response * *p as f32);
    Some(sum * (parts.len() as f32).recip())
}

/// The transmission of the lens along rays.
pub(in crate::camera) struct Transmission {
    pub(in crate::camera) middle: Middle,
    /// The plane whose crossing points describe rays, lens space.
    plane_z_mm: f64,
    shape: Polynomial,
    /// Coefficients by the film's wavelength, then by term, the middle's part and the exposure included. The middle's colour, where the
    /// film has one wavelength, is not: that is [`Middle::tint`].
    lines: Vec<Vec<f32>>,
    /// The coefficients of [`Self::lines`] by set of wavelengths, then by term: a register for the set.
    sets: Vec<Vec<f32x8>>,
    /// The largest error on rays that it was not fitted to, stops.
    error_stops: f64,
}

impl Transmission {
    /// The transmission over the picture; `None` if the middle of the film is dark.
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        mount: &Mount,
        system: &System,
        map: &PupilMap,
        spectrum: &FilmSpectrum,
    ) -> Option<Self> {
        let own = lines(spectrum);
        let passages = Passages::new(system, own[own.len() / 2]);
        let middle = Middle::new(d, &passages, mount.film.z_mm, spectrum)?;
        let count = own.len().min(NODES);
        let nodes: Vec<f64> =
            (0..count).map(|i| own[if count == 1 { 0 } else { i * (own.len() - 1) / (count - 1) }]).collect();
        let at_nodes = passages.in_the_middle(mount.film.z_mm, &nodes)?;
        let plane_z_mm = map.reference_plane_z();
        let rays = rays(mount, map, &passages);
        let places: Vec<[f64; 4]> = rays.iter().map(|(ray, _)| crossing(ray, plane_z_mm)).collect();
        let values: Vec<Vec<f64>> = nodes
            .iter()
            .zip(&at_nodes)
            .map(|(nm, part)| rays.iter().map(|(_, passage)| passages.part(passage, *nm) / part).collect())
            .collect();
        let (shape, fitted, worst) = Polynomial::fit(system.is_rotationally_symmetric(), &places, &values, JUDGES);
        let line = |i: usize| -> Vec<f32> {
            let after = nodes.partition_point(|nm| *nm < own[i]).clamp(usize::from(count > 1), count - 1);
            let before = after.saturating_sub(1);
            let t = if after == before { 0.0 } else { (own[i] - nodes[before]) / (nodes[after] - nodes[before]) };
            let gain = if own.len() == 1 { 1.0 } else { middle.gain_at(i) };
            let term = |k: usize| (gain * (fitted[before][k] * (1.0 - t) + fitted[after][k] * t)) as f32;
            (0..shape.terms()).map(term).collect()
        };
        let lines: Vec<Vec<f32>> = (0..own.len()).map(line).collect();
        let (count, size) = (spectrum.sets(), spectrum.set_size());
        let register =
            |set: usize, term: usize| f32x8::new(std::array::from_fn(|i| lines[set + i.min(size - 1) * count][term]));
        let sets = (0..count).map(|set| (0..shape.terms()).map(|term| register(set, term)).collect()).collect();
        Some(Self { lines, sets, middle, plane_z_mm, shape, error_stops: (1.0 + worst).log2() })
    }

    /// The largest error of the fit on rays that it was not made for, stops.
    pub(in crate::camera) fn error_stops(&self) -> f64 {
        self.error_stops
    }

    /// The weight of light of the film's wavelength of that number along a ray, which may go either way.
    #[inline]
    pub(in crate::camera) fn at(&self, index: usize, ray: &LensRay) -> f32 {
        let numbers = crossing(ray, self.plane_z_mm).map(|n| f32x8::splat(n as f32));
        self.shape.values(numbers, |term| f32x8::splat(self.lines[index][term])).to_array()[0]
    }

    /// [`Self::at`] for as many rays as fill a register, by where they cross the plane and by their direction, each at a wavelength of its
    /// own.
    #[inline]
    pub(in crate::camera) fn at_each(&self, rays: [f32x8; 4], index: impl Fn(usize) -> usize) -> f32x8 {
        let terms = self.shape.terms();
        let lines: [&[f32]; LINES] = std::array::from_fn(|i| &self.lines[index(i)][..terms]);
        self.shape.values(rays, |term| f32x8::new(lines.map(|line| line[term])))
    }

    /// [`Self::at_each`] at the wavelengths of a set.
    #[inline]
    pub(in crate::camera) fn at_set(&self, set: usize, rays: [f32x8; 4]) -> f32x8 {
        let terms = &self.sets[set];
        self.shape.values(rays, |term| terms[term])
    }
}

/// The point at which a ray crosses a plane across the axis, mm, and the cosines of its direction towards the scene.
fn crossing(ray: &LensRay, plane_z_mm: f64) -> [f64; 4] {
    let (p, d) = (ray.origin, ray.direction);
    let at = p + d * ((plane_z_mm - p.z) / d.z);
    let [dx, dy] = [d.x, d.y].map(|c| -c * d.z.signum());
    [at.x, at.y, dx, dy]
}

/// Rays all over the picture and the pupil, a quarter of them from the picture's edge, that come through.
fn rays(mount: &Mount, map: &PupilMap, passages: &Passages<'_>) -> Vec<(LensRay, Passage)> {
    let points = Evenly::<4>::default();
    let ray = |i: u32| {
        let [x, y, u, v] = points.point(i + 1);
        let mut place = Vec2::new(x as f32 - 0.5, y as f32 - 0.5);
        if i.is_multiple_of(4) {
            place *= 0.5 / place.abs().max_element().max(1e-3);
        }
        let film = mount.film_at(place * BEYOND);
        let v = if i.is_multiple_of(3) { 1.0 - 0.02 * v } else { v };
        let aim = map.sample(film.point, [u, v]);
        let direction = (aim.target - film.point).normalize_or_zero();
        let ray = LensRay { origin: film.point, direction };
        Some((ray, passages.from_film(ray)?))
    };
    (0..4 * (RAYS + JUDGES) as u32).filter_map(ray).take(RAYS + JUDGES).collect()
}

/// The colour of a uniform white world of radiance one at a place of the picture, over its brightness there: by some rays of its beam.
pub(in crate::camera) fn colour_at(
    mount: &Mount,
    map: &PupilMap,
    passages: &Passages<'_>,
    place: DVec2,
) -> Option<Rgb> {
    const BEAM: u32 = 16;
    let film = mount.film_at(place.as_vec2());
    let points = Evenly::<2>::default();
    let beam: Vec<Passage> = (0..BEAM)
        .filter_map(|i| {
            let aim = map.sample(film.point, points.point(i + 1));
            passages.from_film(LensRay { origin: film.point, direction: (aim.target - film.point).normalize_or_zero() })
        })
        .collect();
    let mean = |nm: &f64| beam.iter().map(|one| passages.part(one, *nm)).sum::<f64>() / beam.len() as f64;
    let seen = colour(&FilmSpectrum::visible_in(BANDS), |nms| Some(nms.iter().map(mean).collect()));
    seen.filter(|_| !beam.is_empty()).map(|seen| seen * Rgb::ONE)
}

#[cfg(test)]
mod tests;
