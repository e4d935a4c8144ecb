//! The picture of a lamp by exact rays: from places all over the lamp to places all over the front of the lens, each
//! ray followed to the film and counted in the pixel where it arrives. It knows no pupil map, no camera and no
//! pipeline.
//!
//! Light is flux: a ray stands for its part of the lamp's area, times the cosine there, times its solid angle. A
//! pixel's value is its flux over its area, over the exposure of the middle of the film by a world of radiance one.

use super::studio::{D_LINE_NM, Lamp};
use glam::{DVec2, DVec3};
use petzval_optics::focus::FilmPlane;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::on_axis_throughput;
use petzval_optics::system::System;
use petzval_optics::trace::{Ray, Tracer};
use petzval_render::Rgb;
use petzval_render::camera::{CameraDescription, Spectrum, lens_info};
use petzval_render::spectrum::FilmSpectrum;

/// Rays along a side of the grid that looks for the beam first, and then closes in on it.
const SEARCH: i32 = 160;

/// Number of wavelengths of a spectrum above which each ray has one; of others all.
const FEW: usize = 3;

/// A lens before its film.
pub(crate) struct Exact {
    pub(crate) system: System,
    pub(crate) film: FilmPlane,
    lines: Vec<Line>,
    picture_mm: DVec2,
    pixels: [u32; 2],
    /// The z of the camera's origin, lens space, mm.
    pub(crate) pupil_z_mm: f64,
    mm_per_unit: f64,
}

/// A wavelength.
struct Line {
    tracer: Tracer,
    /// Exposure of the middle of the film by a world of radiance one.
    exposure: f64,
    /// Contribution of white light to the channels.
    white: [f64; 3],
}

/// The picture of a lamp by exact rays.
pub(crate) struct Truth {
    /// Colours, rows from below.
    pub(crate) pixels: Vec<[f64; 3]>,
    /// Sums of the squares of each ray's light.
    pub(crate) squares: Vec<[f64; 3]>,
    /// Rays that arrived, by pixel and channel.
    pub(crate) counts: Vec<[u32; 3]>,
    /// The centroid of the light in the picture, pixels, by channel.
    pub(crate) centroids: [DVec2; 3],
    /// The root of the mean squared distance from the centroid, pixels.
    pub(crate) spread_px: f64,
}

/// Directions from a point to a rectangle of a plane at right angles to the way to the entrance pupil.
struct Beam {
    towards: DVec3,
    axes: [DVec3; 2],
    distance: f64,
    low: DVec2,
    high: DVec2,
}

impl Beam {
    /// The way to a place of the rectangle (0 to 1 across and up) from a lamp's place, not of unit length.
    fn way(&self, from_centre: DVec3, u: DVec2) -> DVec3 {
        let at = self.low + (self.high - self.low) * u;
        self.towards * self.distance + self.axes[0] * at.x + self.axes[1] * at.y - from_centre
    }

    fn area(&self) -> f64 {
        let size = self.high - self.low;
        size.x * size.y
    }
}

impl Exact {
    pub(crate) fn new(d: &CameraDescription, pixels: [u32; 2]) -> Self {
        let prescription = lens::read(&d.lens_path, Catalogue::shipped()).unwrap();
        let system = System::new(&prescription, &d.lens).unwrap();
        let focused_nm = d.wavelength_nm.unwrap_or(D_LINE_NM);
        // Where the film stands the panel says, too; tests of the focus hold that against first-order optics.
        let info = lens_info(d, pixels[0], pixels[1]).unwrap();
        let film = FilmPlane {
            tilt_rad: d.film.tilt_rad,
            swing_rad: d.film.swing_rad,
            // The lens moved right is the film moved left.
            shift_mm: d.film.shift_mm.map(|s| -s),
            curvature_per_mm: system.film_radius_mm().map_or(0.0, f64::recip),
            ..FilmPlane::upright(info.film_z_mm)
        };
        let spectrum = match (d.wavelength_nm, d.spectrum) {
            (Some(nm), _) => FilmSpectrum::single(nm),
            (None, Spectrum::Three) => FilmSpectrum::three(),
            (None, Spectrum::Visible) => FilmSpectrum::visible(),
            (None, Spectrum::Bands(count)) => FilmSpectrum::visible_in(count),
        };
        let lines = spectrum.wavelengths().iter().map(|line| {
            let tracer = system.at_wavelength(line.nm);
            let exposure = on_axis_throughput(&tracer, &system, film.z_mm) * system.image_index(line.nm).powi(2);
            Line { tracer, exposure, white: (line.response * Rgb::ONE).to_array().map(f64::from) }
        });
        let lines = lines.collect();
        let pupil_z_mm = Paraxial::new(&system, focused_nm).entrance_pupil.z_mm.unwrap();
        let picture_mm = DVec2::new(info.picture_width_mm, info.picture_height_mm);
        let mm_per_unit = d.scale_mm_per_unit.x;
        Self { system, film, lines, picture_mm, pixels, pupil_z_mm, mm_per_unit }
    }

    /// A place of camera space, Blender units, in lens space, mm.
    pub(crate) fn to_lens(&self, at: DVec3) -> DVec3 {
        at * self.mm_per_unit + DVec3::new(0.0, 0.0, self.pupil_z_mm)
    }

    /// The place at which a ray behind the lens arrives: pixels from the lower left corner of the picture, which is the
    /// film turned by half a turn.
    fn arrive(&self, ray: &Ray) -> Option<DVec2> {
        let at = DVec2::from(self.film.frame().meet(ray)?);
        Some((DVec2::splat(0.5) - at / self.picture_mm) * self.pixels_f64())
    }

    /// The bounds of the rays that get through from a point in lens space.
    fn beam(&self, source: DVec3) -> Beam {
        let to_pupil = DVec3::new(0.0, 0.0, self.pupil_z_mm) - source;
        let (distance, towards) = (to_pupil.length(), to_pupil.normalize());
        let across = DVec3::Y.cross(towards).try_normalize().unwrap_or(DVec3::X);
        // The front of the lens, from wherever it is seen.
        let size = 1.5 * self.system.surfaces().iter().fold(0.0f64, |r, s| r.max(s.semi_diameter_mm));
        let mut beam = Beam {
            towards,
            axes: [across, towards.cross(across)],
            distance,
            low: DVec2::splat(-size),
            high: DVec2::splat(size),
        };
        // The spectrum's ends and two between; what the others see beyond them is in the margin.
        let step = (self.lines.len() / FEW).max(1);
        for _ in 0..3 {
            let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for (i, j) in (0..SEARCH).flat_map(|i| (0..SEARCH).map(move |j| (i, j))) {
                let u = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(SEARCH);
                let direction = beam.way(DVec3::ZERO, u).normalize();
                let ray = Ray { origin: source, direction };
                if self.lines.iter().step_by(step).any(|line| line.tracer.from_scene(ray).is_ok()) {
                    (low, high) = (low.min(u), high.max(u));
                }
            }
            assert!(low.x <= high.x, "no ray gets through the lens");
            // What lies between two rays of the grid, and what a lamp's edges see beyond its middle.
            let margin = DVec2::splat(1.5 / f64::from(SEARCH)) + 0.04 * (high - low);
            let size = beam.high - beam.low;
            (beam.low, beam.high) = (beam.low + (low - margin) * size, beam.low + (high + margin) * size);
        }
        beam
    }

    /// The picture of a lamp by so many rays.
    pub(crate) fn picture_of(&self, lamp: &Lamp, rays: u32) -> Truth {
        let count = (self.pixels[0] * self.pixels[1]) as usize;
        let mut truth = Truth {
            pixels: vec![[0.0; 3]; count],
            squares: vec![[0.0; 3]; count],
            counts: vec![[0; 3]; count],
            centroids: [DVec2::ZERO; 3],
            spread_px: 0.0,
        };
        let centre = self.to_lens(lamp.at);
        let half_mm = lamp.half_side * self.mm_per_unit;
        let beam = self.beam(centre);
        let pixel_mm2 = self.picture_mm.x * self.picture_mm.y / count as f64;
        let part = 4.0 * half_mm * half_mm * beam.area() / f64::from(rays);
        let per_ray = if self.lines.len() > FEW { 1 } else { self.lines.len() };
        let frame = self.film.frame();
        let (mut sums, mut squares, mut light, mut middle) = ([0.0; 3], 0.0, 0.0, DVec2::ZERO);
        for i in 0..rays {
            let [a, b, c, d, e] = spread(i);
            let on_lamp = DVec3::new(half_mm * (2.0 * a - 1.0), half_mm * (2.0 * b - 1.0), 0.0);
            let way = beam.way(on_lamp, DVec2::new(c, d));
            let distance = way.length();
            let direction = way / distance;
            let solid = direction.z.abs() * direction.dot(beam.towards) / (distance * distance);
            let flux = part * solid / per_ray as f64;
            let first = (e * self.lines.len() as f64) as usize;
            for k in 0..per_ray {
                let line = &self.lines[(first + k) % self.lines.len()];
                let ray = Ray { origin: centre + on_lamp, direction };
                let Some(out) = line.tracer.from_scene(ray).ok() else { continue };
                let (Some(at), Some([u, v])) = (self.arrive(&out), frame.meet(&out)) else { continue };
                let edge = DVec2::new(c, d).min(DVec2::new(1.0 - c, 1.0 - d)).min_element();
                assert!(edge > 2e-3, "the beam is wider than its bounds");
                let value = line.white.map(|white| white * flux / line.exposure);
                light += flux;
                squares += flux * at.length_squared();
                middle += flux * at;
                for (channel, value) in value.into_iter().enumerate() {
                    sums[channel] += value;
                    truth.centroids[channel] += value * at;
                }
                let Some(pixel) = self.pixel(at) else { continue };
                let area = pixel_mm2 * frame.at(u, v).area;
                for (channel, value) in value.into_iter().enumerate().filter(|(_, value)| *value != 0.0) {
                    truth.pixels[pixel][channel] += value / area;
                    truth.squares[pixel][channel] += (value / area).powi(2);
                    truth.counts[pixel][channel] += 1;
                }
            }
        }
        for (centroid, sum) in truth.centroids.iter_mut().zip(sums) {
            *centroid /= sum;
        }
        truth.spread_px = (squares / light - (middle / light).length_squared()).sqrt();
        truth
    }

    fn pixel(&self, at: DVec2) -> Option<usize> {
        let [width, height] = self.pixels.map(f64::from);
        let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < width && at.y < height;
        is_inside.then(|| at.y as usize * self.pixels[0] as usize + at.x as usize)
    }

    /// The coordinates on the film, mm, of a place in the picture, pixels.
    pub(crate) fn on_film(&self, at: DVec2) -> DVec2 {
        (DVec2::splat(0.5) - at / self.pixels_f64()) * self.picture_mm
    }

    fn pixels_f64(&self) -> DVec2 {
        DVec2::new(f64::from(self.pixels[0]), f64::from(self.pixels[1]))
    }
}

/// Five numbers that fill their cube evenly: multiples of powers of the root of x⁶ = x + 1 (Roberts 2018).
fn spread(i: u32) -> [f64; 5] {
    const ROOT: f64 = 1.134_724_138_401_519_4;
    let inverse = ROOT.recip();
    [1, 2, 3, 4, 5].map(|k| (0.5 + f64::from(i) * inverse.powi(k)).fract())
}
