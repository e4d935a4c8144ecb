//! The effects of a lens in a picture, measured by exact rays: the pixels by which each moves light, the stops of light that each takes
//! away.
//!
//! Fans of rays leave through the lens from places all over the picture. The point of the scene that one place sees, a ray of the fan sees
//! somewhat aside: how far, in pixels of this picture, is found by how the same rays move over the scene when the place moves a little. By
//! reciprocity a point of the scene is spread as far over the picture. Beside each exact fan goes that of Gaussian optics, which has
//! defocus and nothing else: the difference of the two are the aberrations.

use crate::Rgb;
use crate::accel::Ray;
use crate::camera::CameraError;
use crate::camera::description::CameraDescription;
use crate::camera::lens::mount::Mount;
use crate::camera::lens::real_lens::film_spectrum;
use crate::camera::lens::setup::LensInfo;
use crate::camera::lens::steps::Steps;
use crate::camera::lens::transmission;
use crate::luminance;
use crate::sampler::evenly::Evenly;
use glam::{DVec2, DVec3, Vec2};
use petzval_optics::diffraction::outline::Outline;
use petzval_optics::gaussian::GaussianLens;
use petzval_optics::ghosts;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::{PupilMap, on_axis_throughput};
use petzval_optics::scatter::{self, Scatterer};
use petzval_optics::surface::Shape;
use petzval_optics::system::System;
use petzval_optics::trace::{Ray as LensRay, Tracer, Travel};
use petzval_optics::transmission::Passages;
use std::f64::consts::PI;

mod fan;

use fan::Fan;
pub use fan::Subject;

/// Places across the picture and up, its edges among them: how the scene is looked at.
pub const GRID: [usize; 2] = [65, 37];
/// Colour and brightness change slowly over the picture: they are measured at each so many-th place.
const COARSE: usize = 4;
/// The part of the film's light that the two wavelengths farthest apart leave outside, at either end.
const TAIL: f64 = 0.05;
/// Rays for the brightness of a place: an error of some 0.3 %.
const BRIGHTNESS_RAYS: u32 = 256;
/// Ghosts that are smaller, as a part of the picture's diagonal, count as if they filled a disc of this radius: sources are
/// no points, and a dot is seen less than a disc.
const GHOST_PATCH: f64 = 0.01;
/// Largest angle, as a part of the field's, from which light reaches the lens: hoods and barrels keep that from farther outside away.
const BEYOND_FIELD: f64 = 1.25;
/// The wavelength at which diffraction is measured, nm.
const GREEN_NM: f64 = 550.0;

/// The largest value over the picture, and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// The value, pixels or stops.
    pub value: f64,
    /// Fractions of the picture's width and height from its centre.
    pub place: Vec2,
}

impl Worst {
    const NONE: Self = Self { value: 0.0, place: Vec2::ZERO };

    fn or(self, value: f64, place: Vec2) -> Self {
        if value > self.value { Self { value, place } } else { self }
    }
}

/// The effects of a lens in one picture.
#[derive(Clone, Copy, Debug)]
pub struct LensMeasures {
    /// Radius of the blur disc that Gaussian optics give the point farthest out of focus, px: the largest distance on the film
    /// between a ray of a point and its chief ray.
    pub defocus: Worst,
    /// The largest distance between a ray's hit on the film and that by Gaussian optics, both counted from their
    /// chief rays, px: spherical aberration, coma, astigmatism and field curvature together.
    pub aberration: Worst,
    /// The largest distance between a point's image and its place by Gaussian optics (a flat picture without distortion),
    /// px; infinite where these have no image.
    pub distortion: Worst,
    /// The largest distance between the images of a point at two wavelengths, px.
    pub lateral_colour: Worst,
    /// The largest difference between a ray's distance from its chief ray at one wavelength and at another, px.
    pub axial_colour: Worst,
    /// The light of a uniform world at the darkest place of the picture below that at its middle, stops.
    pub vignetting: Worst,
    /// Width by which rims narrow a blur disc, px.
    pub cats_eye: Worst,
    /// Largest distance between the opening's edge and that of a round one of its area, as a part of the radius.
    pub diaphragm_part: f64,
    /// Radius of the first dark ring of a point, 1.22 λ N at 550 nm for the light cone in the film's middle, px.
    pub airy_px: f64,
    /// Losses at surfaces and in glasses, stops: the largest difference of a channel of a white world, anywhere in the picture, from the
    /// middle's brightness, or from one where the camera is exposed by its f-number.
    pub transmission: Worst,
    /// The part of white light that arrives in the middle.
    pub luminous: f64,
    /// The part of the places that get no light.
    pub dark_part: f64,
}

/// Counts of a lens's surfaces, for the cost of tracing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LensShape {
    /// Planes, spheres and conics.
    pub plain: usize,
    /// Surfaces that take several steps to hit.
    pub aspheres: usize,
}

/// A lens before a film, to be measured.
pub struct Survey {
    mount: Mount,
    system: System,
    map: PupilMap,
    tracer: Tracer,
    gaussian: GaussianLens,
    /// The middle of the entrance pupil by Gaussian optics; `None` at infinity.
    entrance_pupil: Option<DVec3>,
    /// The lens at the ends of the spectrum and between; empty where the film has one wavelength.
    colours: Vec<Tracer>,
    size_px: DVec2,
    /// Irradiance in the film's middle for a uniform world of radiance one.
    middle: f64,
    exposes_by_f_number: bool,
    white_balance: bool,
}

impl Survey {
    /// The survey of a lens, for a picture of that many pixels.
    ///
    /// # Errors
    /// As [`crate::camera::Camera::new`].
    pub fn new(d: &CameraDescription, width: u32, height: u32) -> Result<Self, CameraError> {
        d.check(width, height)?;
        let (mount, system) = Mount::new(d, d.axes()?, width, height)?;
        let line_nm = d.wavelength_nm.unwrap_or(crate::camera::lens::setup::D_LINE_NM);
        let tracer = system.at_wavelength(line_nm);
        let half = [0.5 * mount.info.picture_width_mm, 0.5 * mount.info.picture_height_mm];
        let map = PupilMap::new(&tracer, &system, &mount.film, half[0], half[1]);
        let spectrum = film_spectrum(d, &system);
        let lines = spectrum.wavelengths();
        let colours = match lines.len() {
            0 | 1 => Vec::new(),
            n => {
                let at = |part: f64| lines[((n as f64 * part) as usize).min(n - 1)].nm;
                [TAIL, 0.3, 0.7, 1.0 - TAIL].map(|part| system.at_wavelength(at(part))).to_vec()
            }
        };
        let middle = on_axis_throughput(&tracer, &system, mount.film.z_mm);
        Ok(Self {
            gaussian: GaussianLens::new(&system, line_nm),
            entrance_pupil: Paraxial::new(&system, line_nm).entrance_pupil.z_mm.map(|z| DVec3::new(0.0, 0.0, z)),
            size_px: DVec2::new(f64::from(width), f64::from(height)),
            mount,
            system,
            map,
            tracer,
            colours,
            middle,
            exposes_by_f_number: d.exposes_by_f_number,
            white_balance: d.white_balance,
        })
    }

    /// Data of the lens in this camera.
    pub fn info(&self) -> &LensInfo {
        &self.mount.info
    }

    /// Counts of the lens's surfaces, for the cost of tracing.
    pub fn shape(&self) -> LensShape {
        let surfaces = self.system.surfaces();
        let aspheres = surfaces.iter().filter(|surface| !matches!(surface.shape, Shape::Conic(_))).count();
        LensShape { plain: surfaces.len() - aspheres, aspheres }
    }

    /// True if the wavelengths take different ways.
    pub fn has_colours(&self) -> bool {
        !self.colours.is_empty()
    }

    /// An f-number at which a round opening has the area of the one that is.
    pub fn f_number_by_area(&self) -> f64 {
        let diaphragm = self.system.diaphragm();
        self.system.f_number() * diaphragm.radius_mm() / (diaphragm.area_mm2() / PI).sqrt()
    }

    /// True if a pinhole can frame the same picture: the film stands upright and is flat, the lens shows both directions alike, and the
    /// world has one scale.
    pub fn is_upright(&self) -> bool {
        !self.mount.film.is_uneven() && self.system.is_rotationally_symmetric() && self.mount.scale().is_some()
    }

    /// The scene's depth is counted along this, render space: from the scene to the film.
    pub fn backwards(&self) -> DVec3 {
        self.mount.axes().z_axis
    }

    /// Width and height of a pixel, mm of film.
    pub(crate) fn pixel_mm(&self) -> [f64; 2] {
        let info = &self.mount.info;
        [info.picture_width_mm / self.size_px.x, info.picture_height_mm / self.size_px.y]
    }

    /// The clear pupil as a place of the picture sees it, in direction cosines to the right and up the film; its edge is held to
    /// `tolerance`. `None` where no light arrives.
    pub(crate) fn outline(&self, place: Vec2, tolerance: f64) -> Option<Outline> {
        let info = &self.mount.info;
        let film =
            DVec2::new(-f64::from(place.x) * info.picture_width_mm, -f64::from(place.y) * info.picture_height_mm);
        let index = self.system.image_index(self.tracer.wavelength_nm());
        Outline::seen_from(&self.tracer, &self.map, &self.mount.frame, film, index, tolerance)
    }

    /// The surfaces that scatter, as the film sees them.
    pub(crate) fn scatterers(&self) -> Vec<Scatterer> {
        scatter::scatterers(&self.system, self.tracer.wavelength_nm(), self.mount.film.z_mm)
    }

    /// The value in the picture of the brightest disc of light that is reflected twice, uncoated, for a far source whose light has the
    /// irradiance one before the lens; 0 where nothing reflects twice.
    pub fn ghost_value(&self) -> f64 {
        let patch_mm = GHOST_PATCH * self.mount.info.picture_width_mm.hypot(self.mount.info.picture_height_mm);
        let ghosts = ghosts::all(&self.system, self.tracer.wavelength_nm(), self.mount.film.z_mm, patch_mm);
        ghosts.first().map_or(0.0, |ghost| ghost.irradiance / self.middle)
    }

    /// A place of the grid, rows from below.
    pub fn place(column: usize, row: usize) -> Vec2 {
        Vec2::new(column as f32 / (GRID[0] - 1) as f32 - 0.5, row as f32 / (GRID[1] - 1) as f32 - 0.5)
    }

    /// Fans from all places of the grid.
    pub fn fans(&self) -> Fans<'_> {
        let places = (0..GRID[1]).flat_map(|row| (0..GRID[0]).map(move |column| Self::place(column, row)));
        let fans = places.map(|place| Fan::new(&self.mount, &self.map, place)).collect::<Vec<_>>();
        let [mut bundle, mut beside] = [(); 2].map(|()| self.tracer.bundle(Travel::FromFilm));
        for fan in &fans {
            fan.push(&mut bundle);
            fan.push_beside(&mut beside);
        }
        self.tracer.trace(&mut bundle);
        self.tracer.trace(&mut beside);
        let fans = fans.into_iter().enumerate().map(|(i, fan)| fan.traced(&bundle, &beside, i)).collect();
        Fans { survey: self, fans }
    }

    /// Irradiance of a place for a uniform world, over that of the film's middle.
    fn brightness(&self, places: &[Vec2]) -> Vec<f64> {
        let mut bundle = self.tracer.bundle(Travel::FromFilm);
        let points = Evenly::<2>::default();
        let mut inverse = Vec::with_capacity(places.len() * BRIGHTNESS_RAYS as usize);
        for &place in places {
            let film = self.mount.film_at(place);
            for i in 0..BRIGHTNESS_RAYS {
                let aim = self.map.sample(film.point, points.point(i));
                let to = aim.target - film.point;
                let distance2 = to.length_squared();
                bundle.push(LensRay { origin: film.point, direction: to / distance2.sqrt() });
                let cosines = (film.normal.dot(to) * to.z).abs();
                inverse.push(cosines / (aim.pdf_per_mm2 * distance2 * distance2));
            }
        }
        self.tracer.trace(&mut bundle);
        let rays = BRIGHTNESS_RAYS as usize;
        let arrived = |i: usize| if bundle.result(i).is_ok() { inverse[i] } else { 0.0 };
        let sum = |place: usize| (place * rays..(place + 1) * rays).map(arrived).sum::<f64>();
        (0..places.len()).map(|place| sum(place) / (rays as f64 * self.middle)).collect()
    }

    /// Radius of the Airy disc in pixels.
    fn airy_px(&self) -> f64 {
        // Irradiance is π n² sin² θ' for radiance one, and the working f-number 1 / (2 n sin θ').
        let working_f_number = 0.5 * (PI / self.middle).sqrt();
        let radius_mm = 1.22 * GREEN_NM * 1e-6 * working_f_number;
        radius_mm * self.size_px.x / self.mount.info.picture_width_mm
    }
}

/// The fans of a lens, before the scene is known.
pub struct Fans<'a> {
    survey: &'a Survey,
    fans: Vec<Fan>,
}

impl Fans<'_> {
    /// The mean ray of each place, render space; `None` where no light arrives.
    pub fn rays(&self) -> Vec<Option<Ray>> {
        self.fans.iter().map(|fan| fan.mean().map(|ray| self.survey.mount.to_render(&ray))).collect()
    }

    /// The difference of the lens at another time, with the same scene before it, px.
    pub fn moved(&self, other: &Fans<'_>, seen: &[Option<DVec3>]) -> Worst {
        let mut worst = Worst::NONE;
        for i in Self::coarse() {
            let subject = self.subject(seen[i]);
            let (Some(steps), Some(here), Some(then)) =
                (self.fans[i].steps(subject), self.fans[i].mean(), other.fans[i].mean())
            else {
                continue;
            };
            let way = subject.met_by(&then, &here).zip(subject.met_by(&here, &here)).map(|(then, here)| then - here);
            let moved = way.map_or(0.0, |way| (steps.place(way) * self.survey.size_px).length());
            let blur =
                self.fans[i].blur_radius(self.survey, subject) - other.fans[i].blur_radius(other.survey, subject);
            worst = worst.or(moved + blur.abs(), self.fans[i].place);
        }
        worst
    }

    fn subject(&self, seen: Option<DVec3>) -> Subject {
        seen.map_or(Subject::Far, |point| Subject::At(self.survey.mount.to_lens(point)))
    }

    /// The place in the picture at which a direction of render space is seen, to about a place of the grid; `None` outside.
    pub fn place_of(&self, towards: DVec3) -> Option<Vec2> {
        let direction = |i: usize| Some(self.survey.mount.to_render(&self.fans[i].mean()?).direction.as_dvec3());
        let seen = (0..self.fans.len()).filter_map(|i| Some((i, direction(i)?.angle_between(towards))));
        let (nearest, angle) = seen.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let column = nearest % GRID[0];
        let beside = if column + 1 < GRID[0] { nearest + 1 } else { nearest - 1 };
        let step = direction(beside)?.angle_between(direction(nearest)?);
        (angle <= step).then(|| self.fans[nearest].place)
    }

    /// True if light from a direction of render space comes near enough to the picture's field to be reflected into it.
    pub fn nearly_sees(&self, towards: DVec3) -> bool {
        let axis = -self.survey.backwards();
        let angle = |d: DVec3| d.angle_between(axis);
        let rays = self.rays();
        let widest = rays.iter().flatten().map(|ray| angle(ray.direction.as_dvec3())).fold(0.0, f64::max);
        angle(towards) < BEYOND_FIELD * widest
    }

    /// The effects on the subject of each place: a point of render space, or nothing.
    pub fn measure(&self, seen: &[Option<DVec3>]) -> LensMeasures {
        let s = self.survey;
        let subjects: Vec<Subject> =
            seen.iter().map(|point| point.map_or(Subject::Far, |point| Subject::At(s.mount.to_lens(point)))).collect();
        let steps: Vec<Option<Steps>> =
            self.fans.iter().zip(&subjects).map(|(fan, subject)| fan.steps(*subject)).collect();
        let mut found = LensMeasures {
            defocus: Worst::NONE,
            aberration: Worst::NONE,
            distortion: Worst::NONE,
            lateral_colour: Worst::NONE,
            axial_colour: Worst::NONE,
            vignetting: Worst::NONE,
            cats_eye: Worst::NONE,
            diaphragm_part: diaphragm_part(&s.system),
            airy_px: s.airy_px(),
            transmission: Worst::NONE,
            luminous: 1.0,
            dark_part: self.fans.iter().filter(|fan| fan.mean().is_none()).count() as f64 / self.fans.len() as f64,
        };
        let mut blur = vec![0.0; self.fans.len()];
        for (i, fan) in self.fans.iter().enumerate() {
            let Some(steps) = &steps[i] else { continue };
            let exact = fan.aside(s, subjects[i], steps);
            let ideal = fan.ideal_aside(s, subjects[i]);
            blur[i] = fan.blur_radius(s, subjects[i]);
            found.defocus = found.defocus.or(blur[i], fan.place);
            let apart = exact.iter().zip(&ideal).filter_map(|(a, b)| Some((*a.as_ref()? - *b).length()));
            found.aberration = found.aberration.or(apart.fold(0.0, f64::max), fan.place);
            found.distortion = found.distortion.or(fan.distortion(s, subjects[i]), fan.place);
        }
        let coarse = Self::coarse();
        self.measure_colours(&coarse, &subjects, &steps, &mut found);
        self.measure_brightness(&coarse, &blur, &mut found);
        self.measure_transmission(&mut found);
        found
    }

    fn coarse() -> Vec<usize> {
        let rows = (0..GRID[1]).step_by(COARSE);
        rows.flat_map(|row| (0..GRID[0]).step_by(COARSE).map(move |column| row * GRID[0] + column)).collect()
    }

    fn measure_colours(
        &self,
        coarse: &[usize],
        subjects: &[Subject],
        steps: &[Option<Steps>],
        found: &mut LensMeasures,
    ) {
        let s = self.survey;
        // By colour, by place: where each ray of the fan lands aside of the d line's mean.
        let by_colour: Vec<Vec<Vec<Option<DVec2>>>> = s
            .colours
            .iter()
            .map(|tracer| {
                let mut bundle = tracer.bundle(Travel::FromFilm);
                coarse.iter().for_each(|&i| self.fans[i].push(&mut bundle));
                tracer.trace(&mut bundle);
                let place = |(k, &i): (usize, &usize)| match &steps[i] {
                    Some(steps) => self.fans[i].coloured_aside(s, &bundle, k, subjects[i], steps),
                    None => Vec::new(),
                };
                coarse.iter().enumerate().map(place).collect()
            })
            .collect();
        for (k, &i) in coarse.iter().enumerate() {
            let Some(steps) = &steps[i] else { continue };
            let base = self.fans[i].aside(s, subjects[i], steps);
            // Of each colour: how far its mean lies aside, and how much wider or narrower its fan is.
            let apart: Vec<(DVec2, Vec<Option<DVec2>>)> = by_colour
                .iter()
                .filter_map(|places| {
                    let moved: Vec<Option<DVec2>> =
                        places[k].iter().zip(&base).map(|(a, b)| Some((*a)? - (*b)?)).collect();
                    let count = moved.iter().flatten().count();
                    let mean = moved.iter().flatten().sum::<DVec2>() / count.max(1) as f64;
                    (count > 0).then(|| (mean, moved.iter().map(|m| Some((*m)? - mean)).collect()))
                })
                .collect();
            for (a, (mean_a, rays_a)) in apart.iter().enumerate() {
                let alone = rays_a.iter().flatten().map(|r| r.length()).fold(0.0, f64::max);
                found.lateral_colour = found.lateral_colour.or(mean_a.length(), self.fans[i].place);
                found.axial_colour = found.axial_colour.or(alone, self.fans[i].place);
                for (mean_b, rays_b) in &apart[..a] {
                    let wider = rays_a.iter().zip(rays_b).filter_map(|(a, b)| Some(((*a)? - (*b)?).length()));
                    found.lateral_colour = found.lateral_colour.or((*mean_a - *mean_b).length(), self.fans[i].place);
                    found.axial_colour = found.axial_colour.or(wider.fold(0.0, f64::max), self.fans[i].place);
                }
            }
        }
    }

    fn measure_brightness(&self, coarse: &[usize], blur: &[f64], found: &mut LensMeasures) {
        let s = self.survey;
        let places: Vec<Vec2> = coarse.iter().map(|&i| self.fans[i].place).collect();
        let full = s.map.pupil_area_mm2(s.mount.film_at(Vec2::ZERO).point);
        for ((bright, &i), place) in s.brightness(&places).into_iter().zip(coarse).zip(&places) {
            let stops = if bright > 0.0 { -bright.log2() } else { f64::INFINITY };
            found.vignetting = found.vignetting.or(stops, *place);
            let open = (s.map.pupil_area_mm2(s.mount.film_at(*place).point) / full).clamp(0.0, 1.0);
            found.cats_eye = found.cats_eye.or(blur[i] * (1.0 - open.sqrt()), *place);
        }
    }

    fn measure_transmission(&self, found: &mut LensMeasures) {
        let s = self.survey;
        let passages = Passages::new(&s.system, s.tracer.wavelength_nm());
        let seen = |place: DVec2| transmission::colour_at(&s.mount, &s.map, &passages, place);
        // A lens whose middle is dark has no exposure.
        let Some(white) = seen(DVec2::ZERO).filter(|white| luminance(*white) > 0.0) else { return };
        let middle = luminance(white);
        let balance = if s.white_balance { transmission::white_balance(white) } else { Rgb::ONE };
        found.luminous = f64::from(middle);
        let exposed = if s.exposes_by_f_number { 1.0 } else { middle };
        let halves: &[f64] = if s.is_upright() { &[0.0, 0.5] } else { &[-0.5, 0.0, 0.5] };
        for place in halves.iter().flat_map(|x| halves.iter().map(|y| DVec2::new(*x, *y))) {
            let Some(colour) = seen(place) else { continue };
            let stops =
                (colour * balance / exposed).to_array().map(|c| f64::from(c.max(f32::MIN_POSITIVE)).log2().abs());
            found.transmission = found.transmission.or(stops.into_iter().fold(0.0, f64::max), place.as_vec2());
        }
    }
}

/// Largest distance between an opening's edge and the round one of its area, as a part of that one's radius.
fn diaphragm_part(system: &System) -> f64 {
    let diaphragm = system.diaphragm();
    if diaphragm.is_masked() {
        return 1.0;
    }
    if diaphragm.blades() == 0 {
        return 0.0;
    }
    let round = (diaphragm.area_mm2() / PI).sqrt();
    // Corners lie on the circle of the radius; the middles of the sides are nearest to the axis.
    let outer = diaphragm.radius_mm() / round - 1.0;
    let inner = 1.0 - diaphragm.inner_radius_mm() / round;
    outer.max(inner)
}

#[cfg(test)]
mod tests;
