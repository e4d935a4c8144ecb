//! One ray of the scene, carried to the film at several wavelengths: the place where each arrives, and its weight there.
//!
//! Etendue, n² dA cos θ dω, is the same on both sides of the lens and at every wavelength: densities and importances are
//! counted in it, divided by the area of a pixel, so that a ray which one wavelength chose can be used by all
//! (Veach 1995, the balance heuristic over which of them could have led to it).

use super::{LensSample, RealLens};
use crate::Rgb;
use crate::accel::Ray;
use crate::sampler::raster::Raster;
use crate::spectrum::SET_SIZE;
use glam::{Mat3, Vec2, Vec4};
use petzval_optics::trace::{LINES, Lost, Ray as LensRay};

/// The arrival of a ray at one wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Column of the pixel that gets its light.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Contribution of radiance along the ray to the pixel, for each unit of etendue and pixel area, before the film's response.
    pub importance: f32,
    /// The density with which film-first samples, one for each pixel and all at this wavelength, choose the ray.
    pub density: f64,
}

/// A ray's arrivals at the wavelengths of one set; `None` where it is lost or misses the picture.
pub type Arrivals = [Option<Arrival>; SET_SIZE];

/// The contribution of radiance to a pixel at one wavelength.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Splat {
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Number of the film's wavelength, for [`RealLens::response`].
    pub wavelength: u32,
    /// Factor of the radiance, before the film's response.
    pub weight: f32,
}

/// The splats of a ray: at most one for each wavelength of a set.
#[derive(Clone, Copy, Debug, Default)]
pub struct Splats {
    list: [Splat; SET_SIZE],
    count: u32,
}

impl Splats {
    /// A list of one splat.
    pub fn one(splat: Splat) -> Self {
        let mut all = Self::default();
        all.push(splat);
        all
    }

    /// The splats of `arrivals` at the wavelengths of `set`, their importance times `scale`.
    #[inline]
    pub(in crate::camera) fn new(arrivals: &Arrivals, set: usize, sets: usize, scale: f32) -> Self {
        let mut all = Self::default();
        for (i, arrival) in arrivals.iter().enumerate() {
            if let Some(a) = arrival {
                let wavelength = (set + i * sets) as u32;
                all.push(Splat { x: a.x, y: a.y, wavelength, weight: a.importance * scale });
            }
        }
        all
    }

    #[inline]
    pub(in crate::camera) fn push_at(&mut self, [x, y]: [u32; 2], wavelength: usize, weight: f32) {
        self.push(Splat { x, y, wavelength: wavelength as u32, weight });
    }

    #[inline]
    fn push(&mut self, splat: Splat) {
        self.list[self.count as usize] = splat;
        self.count += 1;
    }

    /// The splats with all weights times `factor`.
    pub fn scaled(mut self, factor: f32) -> Self {
        self.list.iter_mut().for_each(|splat| splat.weight *= factor);
        self
    }

    /// The splats in the order in which they were added.
    #[inline]
    pub fn as_slice(&self) -> &[Splat] {
        &self.list[..self.count as usize]
    }
}

impl RealLens {
    /// Number of wavelengths in a packet.
    pub fn packet_size(&self) -> usize {
        self.film_lines.size
    }

    /// The film's response to a scene colour at its wavelength of that number.
    #[inline]
    pub fn response(&self, wavelength: u32) -> Mat3 {
        self.spectrum.wavelengths()[wavelength as usize].response
    }

    /// Calls `add` with the light that radiance along a ray adds to the pixels where it arrives, neighbours in the list together if they
    /// fall into one pixel. The fourth numbers are 0.
    #[inline]
    pub fn expose(&self, splats: &Splats, radiance: Rgb, mut add: impl FnMut(u32, u32, Vec4)) {
        let [red, green, blue] = radiance.to_array();
        let colour = |splat: &Splat| {
            let [r, g, b] = self.film_lines.responses[splat.wavelength as usize];
            (r * red + g * green + b * blue) * splat.weight
        };
        let Some((first, others)) = splats.as_slice().split_first() else { return };
        let (mut x, mut y, mut sum) = (first.x, first.y, colour(first));
        for splat in others {
            if (splat.x, splat.y) != (x, y) {
                add(x, y, sum);
                (x, y, sum) = (splat.x, splat.y, Vec4::ZERO);
            }
            sum += colour(splat);
        }
        add(x, y, sum);
    }

    /// The wavelength that leads, chosen by `u`: its set and its place in the set.
    #[inline]
    pub(in crate::camera) fn leader(&self, u: f32) -> (usize, usize) {
        // Division of short numbers is quicker.
        let (index, sets) = (self.spectrum.sample(u) as u32, self.film_lines.sets as u32);
        ((index % sets) as usize, (index / sets) as usize)
    }

    /// Carries a ray that comes from the scene, in lens space, to the film. `u` chooses the pixels.
    pub(in crate::camera) fn arrivals(&self, set: usize, ray: LensRay, raster: &Raster, u: [f32; 2]) -> Arrivals {
        let rays = self.film_lines.back.from_scene(ray, set * LINES);
        self.arrived(set, |i| rays[i], raster, u)
    }

    /// The arrivals of the rays that left the lens at the wavelengths of a set.
    #[inline]
    pub(in crate::camera) fn arrived(
        &self,
        set: usize,
        ray: impl Fn(usize) -> Result<LensRay, Lost>,
        raster: &Raster,
        u: [f32; 2],
    ) -> Arrivals {
        let mut arrivals = [None; SET_SIZE];
        for (i, arrival) in arrivals.iter_mut().enumerate().take(self.film_lines.size) {
            let Ok(ray) = ray(i) else { continue };
            let Some(place) = self.mount.picture_point(&ray) else { continue };
            *arrival = self.arrival(set + i * self.spectrum.sets(), place, raster, raster.numbers(u, i), |lens| {
                lens.lead_density(place, &ray)
            });
            let index = set + i * self.spectrum.sets();
            if let (Some(lost), Some(arrival)) = (&self.transmission, arrival) {
                arrival.importance *= lost.at(index, &ray);
            }
        }
        arrivals
    }

    /// The arrival at a picture point at the film's wavelength number `index`, where film-first samples of that point have the density
    /// `lead_density`.
    #[inline]
    pub(in crate::camera) fn arrival(
        &self,
        index: usize,
        place: Vec2,
        raster: &Raster,
        u: [f32; 2],
        lead_density: impl Fn(&Self) -> f64,
    ) -> Option<Arrival> {
        let landing = raster.land(place, u)?;
        let line = &self.lines[index];
        let samples = f64::from(landing.density) / (line.index_squared * self.mount.film_at(place).area);
        let importance = (samples * line.gain) as f32;
        Some(Arrival { x: landing.x, y: landing.y, importance, density: samples * lead_density(self) })
    }
}

/// A ray that one wavelength led to, and the light that its radiance adds, by pixel.
#[derive(Clone, Copy, Debug)]
pub struct HeroSample {
    /// The ray, render space.
    pub ray: Ray,
    /// The contributions of the ray's radiance to pixels.
    pub splats: Splats,
    /// The number of the set.
    pub set: usize,
    /// The sum of the densities with which each wavelength would have led to this ray.
    pub density: f64,
}

/// A wish for a ray through the lens.
#[derive(Clone, Copy, Debug, Default)]
pub struct Request {
    /// Column and row of the pixel that asks.
    pub pixel: [u32; 2],
    /// The place in the picture.
    pub place: Vec2,
    /// Chooses the point of the pupil.
    pub u_lens: [f32; 2],
    /// Chooses the wavelength that leads.
    pub u_wavelength: f32,
    /// Choose the pixels of the wavelengths that arrive elsewhere.
    pub u_pixels: [f32; 2],
    /// The numbers that chose the place in the pixel.
    pub u_place: [f32; 2],
    /// The number that chooses whether a ray that starts in the scene looks beyond the picture.
    pub u_beyond: f32,
}

impl Request {
    /// The numbers that choose the pixels of the wavelengths which the sample's own leads to.
    #[inline]
    pub(in crate::camera) fn pixel_numbers(&self, raster: &Raster) -> [f32; 2] {
        raster.numbers_of(self.pixel, self.place, self.u_pixels)
    }
}

impl RealLens {
    /// A ray as [`Self::sample`] has it, with the contributions of all wavelengths of its set.
    pub fn lead_all(&self, request: &Request, raster: &Raster) -> Option<HeroSample> {
        let (set, _) = self.leader(request.u_wavelength);
        let lead = self.lead(request)?;
        let arrivals = self.arrivals(set, backwards(&lead), raster, request.pixel_numbers(raster));
        Some(self.joined(request, &lead, arrivals, raster))
    }

    /// The result of a ray that one wavelength led to, when all others of its set have arrived.
    #[inline]
    pub(in crate::camera) fn joined(
        &self,
        request: &Request,
        lead: &LensSample,
        mut arrivals: Arrivals,
        raster: &Raster,
    ) -> HeroSample {
        let (set, leader) = self.leader(request.u_wavelength);
        let sets = self.spectrum.sets();
        // The leader's own place and density are known without the rounding of the way back.
        let own = self.arrival(set + leader * sets, request.place, raster, [0.0; 2], |_| lead.density);
        let [x, y] = request.pixel;
        arrivals[leader] = own.map(|a| Arrival { x, y, importance: a.importance * lead.part, ..a });
        let density: f64 = arrivals.iter().flatten().map(|a| a.density).sum();
        let splats = Splats::new(&arrivals, set, sets, density.recip() as f32);
        HeroSample { ray: self.mount.to_render(&lead.out), splats, set, density }
    }
}

/// The ray of a lead as light takes it.
#[inline]
pub(in crate::camera) fn backwards(lead: &LensSample) -> LensRay {
    LensRay { origin: lead.out.origin, direction: -lead.out.direction }
}
