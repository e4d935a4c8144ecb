//! The real lens: from a point of the film, every ray is traced exactly through every surface.
//!
//! Radiance is conserved along a ray, so a film point's exposure is the integral of radiance over the clear pupil
//! with the weight cos(film) cos(pupil) / distance^2; it is divided by the exposure of the middle of the film by a
//! uniform world of radiance one.

pub(in crate::camera) mod arrive;
pub mod batch;
pub(in crate::camera) mod outward;
pub mod packet;
pub mod precision;

use super::focal_surface::FocalSurface;
use super::lines::FilmLines;
use super::mount::Mount;
use super::setup::{D_LINE_NM, LensInfo};
use super::transmission::Transmission;
use crate::camera::{CameraDescription, CameraError, CameraRay, Spectrum};
use crate::spectrum::{FilmSpectrum, SPECTRAL_COUNT};
use arrive::ShortFilm;
use batch::Out;
use glam::{DMat3, Mat3, Vec2};
use outward::Outward;
use packet::Request;
use petzval_optics::entrance_map::EntranceMap;
use petzval_optics::pupil_map::{PupilMap, on_axis_throughput};
use petzval_optics::system::System;
use petzval_optics::trace::{Ray as LensRay, SpectralTracer, Traced, Tracer};
use precision::Chosen;
use std::sync::OnceLock;
use std::time::Instant;

/// The wavelengths that a film sees: all, three, or one: that which was asked for, or any if the lens treats all alike.
pub(in crate::camera) fn film_spectrum(d: &CameraDescription, system: &System) -> FilmSpectrum {
    match (d.wavelength_nm, d.spectrum) {
        (Some(nm), _) => FilmSpectrum::single(nm),
        (None, _) if !system.is_dispersive() => FilmSpectrum::single(D_LINE_NM),
        (None, Spectrum::Three) => FilmSpectrum::three(),
        (None, Spectrum::Visible) => d.visible_in(SPECTRAL_COUNT),
        (None, Spectrum::Bands(count)) => d.visible_in(count),
    }
}

/// The error of a lens through which no light arrives.
pub(in crate::camera) fn dark(d: &CameraDescription, lens_name: &str) -> CameraError {
    d.error(format!(
        "no light gets through '{lens_name}' to the middle of the film; open the diaphragm or change the focus"
    ))
}

/// A real lens before its film, ready to photograph.
pub struct RealLens {
    pub(in crate::camera) mount: Mount,
    pub(in crate::camera) spectrum: FilmSpectrum,
    /// The lens at each wavelength of the film.
    pub(in crate::camera) lines: Vec<FilmLine>,
    pub(in crate::camera) map: PupilMap,
    map_seconds: f64,
    pub(in crate::camera) film_lines: FilmLines,
    pub(in crate::camera) out: Out,
    precision: Chosen,
    /// The film for packets, if there are any and the film is flat.
    pub(in crate::camera) short_film: Option<ShortFilm>,
    /// The transmission of the lens; `None`: nothing is lost.
    pub(in crate::camera) transmission: Option<Transmission>,
    pub(in crate::camera) system: System,
    /// The surface that is sharp, made when rays first start in the scene.
    focal: OnceLock<FocalSurface>,
    entrance: OnceLock<EntranceMap>,
}

/// One wavelength of the film.
pub(in crate::camera) struct FilmLine {
    pub(in crate::camera) tracer: Tracer,
    /// The picture's value for the irradiance that radiance one makes: by default one over that of the film's middle.
    pub(in crate::camera) gain: f64,
    /// The index of the medium before the film, squared: a factor of etendue.
    pub(in crate::camera) index_squared: f64,
}

/// A ray from the film into the scene, at one wavelength.
pub(in crate::camera) struct LensSample {
    /// The ray in front of the lens, lens space.
    pub(in crate::camera) out: LensRay,
    /// The density of the choice of the ray, for each mm² sr of projected solid angle at the film point.
    pub(in crate::camera) density: f64,
    /// The part of the light that the lens lets through along it.
    pub(in crate::camera) part: f32,
}

impl RealLens {
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<Self, CameraError> {
        let (mount, system) = Mount::new(d, axes, width, height)?;
        let Mount { info, film, .. } = &mount;
        let mut spectrum = film_spectrum(d, &system);
        let tracers: Vec<Tracer> = spectrum.wavelengths().iter().map(|w| system.at_wavelength(w.nm)).collect();
        let half = [0.5 * info.picture_width_mm, 0.5 * info.picture_height_mm];
        let middle = tracers.len() / 2;
        let representative: Vec<Tracer> = if tracers.len() == 1 {
            tracers.clone()
        } else {
            [0, middle, tracers.len() - 1].map(|i| tracers[i].clone()).to_vec()
        };
        let start = Instant::now();
        let map = PupilMap::for_tracers(&representative, &system, film, half[0], half[1]);
        let map_seconds = start.elapsed().as_secs_f64();
        let transmission = match d.transmission {
            true => {
                Some(Transmission::new(d, &mount, &system, &map, &spectrum).ok_or_else(|| dark(d, &info.lens_name))?)
            }
            false => None,
        };
        if let Some(lost) = &transmission {
            spectrum = lost.middle.tinted(spectrum);
        }
        let gains = gains(&tracers, &spectrum, &system, film.z_mm);
        if !gains.iter().all(|g| g.is_finite()) {
            return Err(dark(d, &info.lens_name));
        }
        let brightness = d.brightness_through(&tracers[middle], &system, film.z_mm);
        let film_lines = FilmLines::new(&tracers, &spectrum);
        let line = |(tracer, gain): (Tracer, f64)| {
            let index_squared = system.image_index(tracer.wavelength_nm()).powi(2);
            FilmLine { tracer, gain: gain * brightness, index_squared }
        };
        let lines: Vec<FilmLine> = tracers.into_iter().zip(gains).map(line).collect();
        let (sets, size) = (spectrum.sets(), spectrum.set_size());
        let short_film = ShortFilm::new(&mount, system.last_vertex_z_mm(), &lines, sets, size);
        let (focal, entrance) = (OnceLock::new(), OnceLock::new());
        let out = Out::Double(outward(&mount, &system, &spectrum, &lines));
        let precision = Chosen::double(d.precision);
        let mut lens = Self {
            mount,
            spectrum,
            lines,
            map,
            map_seconds,
            film_lines,
            out,
            precision,
            short_film,
            transmission,
            system,
            focal,
            entrance,
        };
        let single = lens.outward();
        lens.precision = Chosen::measure(d.precision, &lens, &single, [width, height]);
        if lens.precision.is_single {
            lens.out = Out::Single(single);
        }
        Ok(lens)
    }

    /// Data of the lens in this camera.
    pub fn info(&self) -> &LensInfo {
        &self.mount.info
    }

    /// The lens on the way out, in numbers of some kind.
    pub(in crate::camera) fn outward<R: Traced>(&self) -> Outward<R> {
        outward(&self.mount, &self.system, &self.spectrum, &self.lines)
    }

    /// The precision of rays that leave through the lens, and its reason.
    pub fn precision(&self) -> &Chosen {
        &self.precision
    }

    /// The largest error of the approximated transmittance along a ray, stops; `None` where nothing is lost.
    pub fn transmission_error_stops(&self) -> Option<f64> {
        self.transmission.as_ref().map(Transmission::error_stops)
    }

    /// Wall time that the map of the pupil took, s.
    pub fn map_seconds(&self) -> f64 {
        self.map_seconds
    }

    /// A ray for a picture point, or `None` where it is lost in the lens. Many are quicker in a batch.
    pub fn sample(&self, p: Vec2, u_lens: [f32; 2], u_wavelength: f32) -> Option<CameraRay> {
        let mut ray = Vec::with_capacity(1);
        let request = Request { place: p, u_lens, u_wavelength, ..Request::default() };
        self.sample_batch(&[request], &mut self.batch(), &mut ray);
        ray.pop().flatten()
    }

    /// The camera ray of a lead at the film's wavelength number `index`, with its weight.
    #[inline]
    pub(in crate::camera) fn weighted(&self, index: usize, lead: &LensSample) -> CameraRay {
        CameraRay { ray: self.mount.to_render(&lead.out), weight: self.weight(index, lead.density) * lead.part }
    }

    /// Factor of radiance at the film's wavelength number `index` along a ray that was chosen with this density.
    #[inline]
    pub(in crate::camera) fn weight(&self, index: usize, density: f64) -> Mat3 {
        self.spectrum.wavelengths()[index].response * (self.lines[index].gain / density) as f32
    }

    /// A ray from a picture point to the lens, lens space, and the density of its choice as [`LensSample`] has it.
    #[inline]
    pub(in crate::camera) fn aim_out(&self, p: Vec2, u_lens: [f32; 2]) -> (LensRay, f64) {
        let film = self.mount.film_at(p);
        let aim = self.map.sample(film.point, [f64::from(u_lens[0]), f64::from(u_lens[1])]);
        let to = aim.target - film.point;
        let distance2 = to.length_squared();
        let direction = to * distance2.sqrt().recip();
        // Cosines are those of `to` over its length.
        let cosines = (film.normal.dot(to) * to.z).abs();
        (LensRay { origin: film.point, direction }, aim.pdf_per_mm2 * distance2 * distance2 / cosines)
    }

    /// The density of [`Self::lead`] for the picture point `p` and a ray that comes to it from the lens.
    #[inline]
    pub(in crate::camera) fn lead_density(&self, p: Vec2, ray: &LensRay) -> f64 {
        let film = self.mount.film_at(p);
        let to_plane = (self.map.reference_plane_z() - film.point.z) / ray.direction.z;
        let target = film.point + ray.direction * to_plane;
        let cosines = (film.normal.dot(ray.direction) * ray.direction.z).abs();
        self.map.pdf(film.point, target) * to_plane * to_plane / cosines
    }

    /// The surface that is sharp, for rays that start in the scene.
    pub(in crate::camera) fn focal_surface(&self) -> &FocalSurface {
        self.focal.get_or_init(|| {
            let middle = &self.lines[self.lines.len() / 2].tracer;
            FocalSurface::new(&self.mount, &self.system, middle, &self.map, self.entrance().middle())
        })
    }

    /// The entrance pupil at which rays from the scene aim, for all wavelengths; made when first asked for.
    pub(in crate::camera) fn entrance(&self) -> &EntranceMap {
        self.entrance.get_or_init(|| {
            let middle = self.lines.len() / 2;
            let mut picked = vec![0, middle, self.lines.len() - 1];
            picked.dedup();
            let tracers: Vec<Tracer> = picked.into_iter().map(|i| self.lines[i].tracer.clone()).collect();
            EntranceMap::new(&tracers, &self.system)
        })
    }
}

/// The way out in numbers of some kind.
fn outward<R: Traced>(mount: &Mount, system: &System, spectrum: &FilmSpectrum, lines: &[FilmLine]) -> Outward<R> {
    let tracers: Vec<&Tracer> = lines.iter().map(|line| &line.tracer).collect();
    Outward::new(mount, system.last_vertex_z_mm(), SpectralTracer::new(&tracers).cast(), spectrum, lines)
}

/// One over the exposure of the film's middle at each wavelength. It changes smoothly, so a parabola through
/// three wavelengths serves for all.
fn gains(tracers: &[Tracer], spectrum: &FilmSpectrum, system: &System, film_z_mm: f64) -> Vec<f64> {
    let exact = |i: usize| on_axis_throughput(&tracers[i], system, film_z_mm);
    if tracers.len() < 3 {
        return (0..tracers.len()).map(|i| 1.0 / exact(i)).collect();
    }
    let nodes = [0, tracers.len() / 2, tracers.len() - 1];
    let lines = spectrum.wavelengths();
    let x = nodes.map(|i| lines[i].nm);
    let y = nodes.map(exact);
    lines
        .iter()
        .map(|line| {
            let at = line.nm;
            let term =
                |i: usize, j: usize, k: usize| y[i] * (at - x[j]) * (at - x[k]) / ((x[i] - x[j]) * (x[i] - x[k]));
            1.0 / (term(0, 1, 2) + term(1, 2, 0) + term(2, 0, 1))
        })
        .collect()
}
