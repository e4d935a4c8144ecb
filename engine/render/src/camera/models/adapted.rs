//! A real lens of which something is taken out of the picture: its distortion, its aberrations, the blur of points out of
//! focus, or one of the two ways in which it parts colours.
//!
//! Something makes the rays: the lens itself, the middle of its pupil alone, or its Gaussian optics. The direction of each place
//! of the picture is known from the lens: that of its chief ray, at the line of the focus or at each
//! wavelength; without distortion that of Gaussian optics. Between the two stands a map, made once: at which place of its own
//! picture the maker of the rays sees the same. So distortion can be had without blur, and blur without distortion.
//!
//! Rays go from the film alone. Where light falls off is a matter of [`crate::camera::tools::shade`].

use super::gaussian::{Gaussian, Order};
use crate::camera::description::{CameraDescription, EnabledEffects};
use crate::camera::lens::beam;
use crate::camera::lens::mount::Mount;
use crate::camera::lens::real_lens::batch::LensBatch;
use crate::camera::lens::real_lens::packet::Request;
use crate::camera::lens::real_lens::{RealLens, film_spectrum};
use crate::camera::lens::setup::{D_LINE_NM, LensInfo};
use crate::camera::{CameraError, CameraRay};
use crate::spectrum::FilmSpectrum;
use glam::{DMat3, DVec2, DVec3, Vec2};
use petzval_optics::gaussian::GaussianLens;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::system::System;
use petzval_optics::trace::{Ray as LensRay, Tracer, Travel};

mod warp;

use warp::Warp;

/// Largest size of the film on which rays may start, as a multiple of the picture's: for places that a lens with distortion shows outside
/// of it.
const MOST_BEYOND: f64 = 1.5;
/// Rays whose mean is a chief ray.
const RAYS: usize = 32;
/// The point of the pupil through which everything is seen that is to be sharp: as near to its middle as there is an opening.
const MIDDLE: [f32; 2] = [0.5, 1e-4];
/// Nodes of a map across the picture: distortion is smooth.
const NODES: usize = 49;
/// Nodes of a map of the small difference between two wavelengths.
const COLOUR_NODES: usize = 17;
/// The distance that stands for infinity, mm.
const FAR_MM: f64 = 1e9;

/// The camera of a real lens of which some effects are taken out.
pub struct Adapted {
    maker: Maker,
    mount: Mount,
    spectrum: FilmSpectrum,
    /// True if the maker has one wavelength for all of the film's.
    is_grey: bool,
    /// True if all rays go through the middle of the pupil.
    is_sharp: bool,
    /// The part of the maker's picture that this one is, in width and height.
    part: f32,
    /// The map from each place to the place at which the maker sees the same subject; `None`: the identity.
    warp: Option<Warp>,
    /// The maps to the place of each wavelength of the film, applied after `warp`. Empty where all colours take one way.
    by_colour: Vec<Warp>,
}

enum Maker {
    Lens(Box<RealLens>),
    Gaussian(Box<Gaussian>),
}

impl Adapted {
    /// The camera of a description of which `shown` is not all.
    pub(in crate::camera) fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
    ) -> Result<Self, CameraError> {
        let shown = d.shown;
        let plain = CameraDescription { shown: EnabledEffects::default(), ..d.clone() };
        let (mount, system) = Mount::new(&plain, axes, width, height)?;
        let spectrum = film_spectrum(&plain, &system);
        // Both ways in which colours part, or neither, are the lens's own way with its own wavelengths.
        let is_grey = spectrum.wavelengths().len() > 1 && !shown.axial_colour;
        let line_nm = d.wavelength_nm.unwrap_or(D_LINE_NM);

        // On a larger film, for what lies outside of the picture.
        let larger = |factor: f64| {
            plain.clone().with(|c| {
                c.film.width_mm = mount.info.picture_width_mm * factor;
                c.film.height_mm = mount.info.picture_height_mm * factor;
            })
        };
        // A retina may end before.
        let is_large_enough = Mount::new(&larger(MOST_BEYOND), axes, width, height).is_ok();
        let beyond = if is_large_enough { MOST_BEYOND } else { 1.0 };
        let wide = larger(beyond);
        let sight = Sight::new(&wide, axes, width, height, line_nm, beyond)?;
        let warp = sight.warp(shown, line_nm);
        let by_colour = if spectrum.wavelengths().len() > 1 && (is_grey || !shown.lateral_colour || !shown.aberration) {
            let lines = spectrum.wavelengths().iter();
            lines.map(|line| sight.colour_warp(shown, is_grey, line_nm, line.nm)).collect()
        } else {
            Vec::new()
        };

        let maker_d =
            CameraDescription { wavelength_nm: if is_grey { Some(line_nm) } else { plain.wavelength_nm }, ..wide };
        let maker = if shown.aberration {
            Maker::Lens(Box::new(RealLens::new(&maker_d, axes, width, height)?))
        } else {
            let order = if maker_d.wavelength_nm.is_some() { Order::Thick } else { Order::Paraxial };
            Maker::Gaussian(Box::new(Gaussian::new(order, &maker_d, axes, width, height)?))
        };
        let is_sharp = !shown.defocus;
        Ok(Self { maker, mount, spectrum, is_grey, is_sharp, part: (1.0 / beyond) as f32, warp, by_colour })
    }

    /// Data of the lens in this camera.
    pub fn info(&self) -> &LensInfo {
        &self.mount.info
    }

    pub(in crate::camera) fn axes(&self) -> &DMat3 {
        self.mount.axes()
    }

    /// A ray for a picture point, or `None` where it is lost in the lens. Many are quicker in a batch.
    pub fn sample(&self, p: Vec2, u_lens: [f32; 2], u_wavelength: f32) -> Option<CameraRay> {
        let place = self.place(p, u_wavelength)?;
        let ray = match &self.maker {
            Maker::Lens(lens) => lens.sample(place, self.aim(u_lens), u_wavelength)?,
            Maker::Gaussian(lens) if self.is_sharp => lens.chief(place, u_wavelength),
            Maker::Gaussian(lens) => lens.sample(place, u_lens, u_wavelength),
        };
        Some(self.coloured(ray, u_wavelength))
    }

    /// Memory for batches, where the lens makes the rays.
    pub(in crate::camera) fn batch(&self) -> Option<LensBatch> {
        match &self.maker {
            Maker::Lens(lens) => Some(lens.batch()),
            Maker::Gaussian(_) => None,
        }
    }

    /// [`Self::sample`] for each request, to the last bit; `batch` is one of this camera's.
    pub(in crate::camera) fn sample_batch(
        &self,
        requests: &[Request],
        batch: &mut LensBatch,
        rays: &mut Vec<Option<CameraRay>>,
    ) {
        let Maker::Lens(lens) = &self.maker else { return };
        let places: Vec<Option<Vec2>> = requests.iter().map(|r| self.place(r.place, r.u_wavelength)).collect();
        let moved = |(request, place): (&Request, &Option<Vec2>)| {
            Some(Request { place: (*place)?, u_lens: self.aim(request.u_lens), ..*request })
        };
        let there: Vec<Request> = requests.iter().zip(&places).filter_map(moved).collect();
        let mut made = Vec::with_capacity(there.len());
        lens.sample_batch(&there, batch, &mut made);
        let mut made = made.into_iter();
        rays.extend(requests.iter().zip(&places).map(|(request, place)| {
            let ray = place.and_then(|_| made.next().flatten())?;
            Some(self.coloured(ray, request.u_wavelength))
        }));
    }

    /// The numbers that choose the point of the pupil.
    fn aim(&self, u_lens: [f32; 2]) -> [f32; 2] {
        if self.is_sharp { MIDDLE } else { u_lens }
    }

    /// The place in the maker's picture where the ray of a place starts.
    fn place(&self, p: Vec2, u_wavelength: f32) -> Option<Vec2> {
        let mut place = p;
        if let Some(warp) = &self.warp {
            place = warp.at(place)?;
        }
        if let Some(warp) = self.by_colour.get(self.spectrum.sample(u_wavelength)) {
            place = warp.at(place)?;
        }
        Some(place * self.part)
    }

    /// The ray with the film's response at its wavelength, if its maker has none.
    fn coloured(&self, ray: CameraRay, u_wavelength: f32) -> CameraRay {
        if !self.is_grey {
            return ray;
        }
        let line = &self.spectrum.wavelengths()[self.spectrum.sample(u_wavelength)];
        CameraRay { weight: line.response * ray.weight, ..ray }
    }
}

/// The directions that places see through a lens, from the middle of the entrance pupil, at the distance of the focus.
struct Sight {
    mount: Mount,
    system: System,
    map: PupilMap,
    /// The size of the film as a multiple of the picture's; places are those of the picture.
    beyond: f64,
    pupil: DVec3,
    distance_mm: f64,
}

impl Sight {
    fn new(
        d: &CameraDescription,
        axes: DMat3,
        width: u32,
        height: u32,
        line_nm: f64,
        beyond: f64,
    ) -> Result<Self, CameraError> {
        let (mount, system) = Mount::new(d, axes, width, height)?;
        let half = [0.5 * mount.info.picture_width_mm, 0.5 * mount.info.picture_height_mm];
        let map = PupilMap::new(&system.at_wavelength(line_nm), &system, &mount.film, half[0], half[1]);
        let pupil = Paraxial::new(&system, line_nm).entrance_pupil.z_mm.unwrap_or(0.0);
        let distance_mm = mount.info.focus_distance_mm.filter(|d| *d > 0.0).unwrap_or(FAR_MM).min(FAR_MM);
        Ok(Self { mount, system, map, beyond, pupil: DVec3::new(0.0, 0.0, pupil), distance_mm })
    }

    fn film_at(&self, place: Vec2) -> DVec3 {
        self.mount.film_at(place / self.beyond as f32).point
    }

    fn seen(&self, ray: &LensRay) -> DVec3 {
        (ray.origin + ray.direction * self.distance_mm - self.pupil).normalize_or(ray.direction)
    }

    /// The directions that places see by exact rays of one wavelength; `None` where no light arrives.
    fn exact(&self, places: &[Vec2], tracer: &Tracer) -> Vec<Option<DVec3>> {
        let mut bundle = tracer.bundle(Travel::FromFilm);
        for &place in places {
            beam::push(&mut bundle, &self.map, self.film_at(place), RAYS as u32);
        }
        tracer.trace(&mut bundle);
        let mean = |i: usize| {
            let through: Vec<LensRay> = (i * RAYS..(i + 1) * RAYS).filter_map(|k| bundle.result(k).ok()).collect();
            // Of a beam that is nearly all cut away the middle is no chief ray.
            beam::mean(through.iter()).filter(|_| through.len() * 4 >= RAYS).map(|ray| self.seen(&ray))
        };
        (0..places.len()).map(mean).collect()
    }

    /// The direction that a place sees by Gaussian optics.
    fn gaussian(&self, place: Vec2, lens: &GaussianLens) -> Option<DVec3> {
        let film = self.film_at(place);
        Some(self.seen(&lens.into_scene(film, lens.slopes(film, DVec2::ZERO))))
    }

    /// The map from each place to the place at which the maker of the rays sees the same subject; `None`: the identity.
    fn warp(&self, shown: EnabledEffects, line_nm: f64) -> Option<Warp> {
        // What makes the rays has distortion itself, or none.
        if shown.distortion == shown.aberration {
            return None;
        }
        let (tracer, gaussian) = (self.system.at_wavelength(line_nm), GaussianLens::new(&self.system, line_nm));
        let exact = |places: &[Vec2]| self.exact(places, &tracer);
        let ideal = |places: &[Vec2]| places.iter().map(|p| self.gaussian(*p, &gaussian)).collect();
        Some(match shown.distortion {
            true => Warp::new(NODES, self.most(), exact, ideal),
            false => Warp::new(NODES, self.most(), ideal, exact),
        })
    }

    /// The map from a place at the wavelength of the focus to the place at which the maker of the rays shows the same subject at the
    /// wavelength `nm`, as far as colours are to part; if `is_grey`, the maker has the line of the focus alone.
    fn colour_warp(&self, shown: EnabledEffects, is_grey: bool, line_nm: f64, nm: f64) -> Warp {
        let [line, here] = [line_nm, nm].map(|nm| self.system.at_wavelength(nm));
        let [line_g, here_g] = [line_nm, nm].map(|nm| GaussianLens::new(&self.system, nm));
        let wanted = if shown.lateral_colour { &here } else { &line };
        let (made, made_g) = if is_grey { (&line, &line_g) } else { (&here, &here_g) };
        let wanted = |places: &[Vec2]| self.exact(places, wanted);
        match shown.aberration {
            true => Warp::new(COLOUR_NODES, self.most(), wanted, |places| self.exact(places, made)),
            // Of Gaussian optics the place is that of their own line: what is wanted is how far colours are apart.
            false => {
                let apart = |places: &[Vec2]| -> Vec<Option<DVec3>> {
                    let at_line = self.exact(places, &line);
                    let there = wanted(places);
                    let own = places.iter().map(|p| self.gaussian(*p, &line_g));
                    let all = own.zip(at_line).zip(there);
                    all.map(|((own, at_line), there)| Some((own? + (there? - at_line?)).normalize())).collect()
                };
                let made = |places: &[Vec2]| places.iter().map(|p| self.gaussian(*p, made_g)).collect();
                Warp::new(COLOUR_NODES, self.most(), apart, made)
            }
        }
    }

    /// Half of the widest and highest place that its film has.
    fn most(&self) -> f32 {
        (0.5 * self.beyond) as f32
    }
}

#[cfg(test)]
mod tests;
