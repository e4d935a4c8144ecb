//! One ray of the scene, carried to the film at several wavelengths: where each arrives, and what light counts there.
//!
//! Etendue, n² dA cos θ dω, is the same on both sides of the lens and at every wavelength: densities and importances are
//! counted in it, divided by the area of a pixel, so that a ray which one wavelength chose can be used by all
//! (Veach 1995, the balance heuristic over which of them could have led to it).

use super::real_lens::RealLens;
use crate::accel::Ray;
use crate::sampler::raster::Raster;
use crate::spectrum::{FilmSpectrum, SET_SIZE};
use glam::{Mat3, Vec2};
use petzval_optics::trace::{LINES, Ray as LensRay, SpectralTracer, Tracer};

// A set goes through the lens in one packet.
const _: () = assert!(SET_SIZE == LINES);

/// The lens at each set of the film's wavelengths.
pub(super) struct Packets {
    tracers: Vec<SpectralTracer>,
    size: usize,
}

impl Packets {
    pub(super) fn new(tracers: &[Tracer], spectrum: &FilmSpectrum) -> Self {
        let (sets, size) = (spectrum.sets(), spectrum.set_size());
        // A small set is filled up with its last wavelength.
        let line = |set: usize, i: usize| &tracers[set + i.min(size - 1) * sets];
        let packet = |set: usize| SpectralTracer::new(std::array::from_fn(|i| line(set, i)));
        Self { tracers: (0..sets).map(packet).collect(), size }
    }
}

/// Where a ray arrives at one wavelength.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Column of the pixel that gets its light.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// What radiance along the ray adds to the pixel, for each unit of etendue and pixel area.
    pub importance: Mat3,
    /// The density with which film-first samples, one for each pixel and all at this wavelength, choose the ray.
    pub density: f64,
}

/// A ray's arrivals at the wavelengths of one set; `None` where it is lost or misses the picture.
pub type Arrivals = [Option<Arrival>; SET_SIZE];

impl RealLens {
    /// How many wavelengths a packet carries.
    pub fn packet_size(&self) -> usize {
        self.packets().size
    }

    /// Which wavelength leads, chosen by `u`: its set and its place in the set.
    #[inline]
    pub(super) fn leader(&self, u: f32) -> (usize, usize) {
        let index = self.spectrum.sample(u);
        let sets = self.spectrum.sets();
        (index % sets, index / sets)
    }

    /// Carries a ray that comes from the scene, in lens space, to the film. `u` chooses the pixels.
    pub(super) fn arrivals(&self, set: usize, ray: LensRay, raster: &Raster, u: [f32; 2]) -> Arrivals {
        let packets = self.packets();
        let rays = packets.tracers[set].from_scene(ray);
        let mut arrivals = [None; SET_SIZE];
        for (i, ray) in rays.iter().enumerate().take(packets.size) {
            let Ok(ray) = ray else { continue };
            let Some(place) = self.mount.picture_point(ray) else { continue };
            arrivals[i] = self.arrival(set + i * self.spectrum.sets(), place, raster, turned(u, i), |lens| {
                lens.lead_density(place, ray)
            });
        }
        arrivals
    }

    /// What arrives at a picture point at the film's wavelength number `index`, where film-first samples of that point
    /// have the density `lead_density`.
    #[inline]
    pub(super) fn arrival(
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
        let importance = self.spectrum.wavelengths()[index].response * (samples * line.gain) as f32;
        Some(Arrival { x: landing.x, y: landing.y, importance, density: samples * lead_density(self) })
    }
}

/// A ray that one wavelength led to, and what its radiance adds to which pixels.
#[derive(Clone, Copy, Debug)]
pub struct Led {
    /// Render space.
    pub ray: Ray,
    /// By wavelength: column and row of a pixel and the weight of the radiance there.
    pub splats: [Option<(u32, u32, Mat3)>; SET_SIZE],
    /// The number of the set.
    pub set: usize,
    /// The sum of the densities with which each wavelength would have led to it.
    pub density: f64,
}

impl RealLens {
    /// A ray for the place `p` of pixel (x, y), as [`Self::sample`] has it, with what all wavelengths of the set make of
    /// it. `u_pixels` chooses the pixels of those that arrive elsewhere.
    pub fn lead_all(
        &self,
        [x, y]: [u32; 2],
        p: Vec2,
        u_lens: [f32; 2],
        u_wavelength: f32,
        raster: &Raster,
        u_pixels: [f32; 2],
    ) -> Option<Led> {
        let (set, leader) = self.leader(u_wavelength);
        let index = set + leader * self.spectrum.sets();
        let lead = self.lead(index, p, u_lens)?;
        let back = LensRay { origin: lead.out.origin, direction: -lead.out.direction };
        let mut arrivals = self.arrivals(set, back, raster, u_pixels);
        // The leader's own place and density are known without the rounding of the way back.
        arrivals[leader] = self.arrival(index, p, raster, [0.0; 2], |_| lead.density).map(|a| Arrival { x, y, ..a });
        let total: f64 = arrivals.iter().flatten().map(|a| a.density).sum();
        let splats = arrivals.map(|arrival| arrival.map(|a| (a.x, a.y, a.importance * total.recip() as f32)));
        Some(Led { ray: self.mount.to_render(&lead.out), splats, set, density: total })
    }
}

/// Numbers for wavelength `i`, apart from those of the others.
#[inline]
fn turned(u: [f32; 2], i: usize) -> [f32; 2] {
    // Multiples of two irrational numbers with small terms (the plastic constant: Roberts 2018).
    [(u[0] + 0.754_877_7 * i as f32).fract(), (u[1] + 0.569_840_3 * i as f32).fract()]
}
