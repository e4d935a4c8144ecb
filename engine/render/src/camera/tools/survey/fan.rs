//! The rays of one place of the picture, and the angle of each from the direction in which the place looks.

use super::Survey;
use crate::camera::lens::beam;
use crate::camera::lens::mount::Mount;
use crate::camera::lens::steps::{Steps, inverse};
use glam::{DMat2, DVec2, DVec3, Vec2};
use petzval_optics::gaussian::GaussianLens;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::trace::{Bundle, Ray};
use std::f64::consts::TAU;

/// Rays of a fan: most at the pupil's edge, where all that grows with the opening is largest.
const RAYS: usize = 12;
/// Rays of a fan that are inside.
const INNER: usize = 4;
/// Parts of the pupil's area of a fan's rays, from inside: the very edge may lie outside.
const AREAS: [f64; 2] = [0.25, 0.96];
/// Numbers below this choose any place of the rear glass rather than one of the pupil.
const AFTER_DEFENSIVE: f64 = 0.05;
/// Distance of a place's neighbours, which give the derivatives of its direction, as parts of the picture.
const BESIDE: f32 = 1e-3;
/// Gaussian optics know planes alone: points at a larger angle from the axis than of this cosine count as far as that.
const LEAST_COSINE: f64 = 0.3;

/// The subject that a place sees, lens space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Subject {
    /// A point in lens space, mm.
    At(DVec3),
    /// No point: the subject is infinitely far.
    Far,
}

impl Subject {
    /// The point at which `ray` hits the plane through the subject at right angles to `mean`; for a subject infinitely far its direction.
    pub(super) fn met_by(self, ray: &Ray, mean: &Ray) -> Option<DVec3> {
        match self {
            Self::Far => Some(ray.direction),
            Self::At(point) => {
                let along = ray.direction.dot(mean.direction);
                let t = (point - ray.origin).dot(mean.direction) / along;
                (along > 1e-3).then(|| ray.origin + ray.direction * t)
            }
        }
    }

    /// Depth of the subject before the first vertex for Gaussian optics, mm; infinite for [`Self::Far`].
    fn depth_mm(self) -> f64 {
        match self {
            Self::Far => f64::INFINITY,
            Self::At(point) => (-point.z).max(LEAST_COSINE * point.length()),
        }
    }
}

/// The rays of a place.
pub(super) struct Fan {
    pub(super) place: Vec2,
    film: DVec3,
    /// Points of the plane of the pupil's map.
    targets: [DVec3; RAYS],
    out: [Option<Ray>; RAYS],
    mean: Option<Ray>,
    /// The neighbours to the right and above, or to the left and below: towards the picture's middle.
    beside: [Neighbour; 2],
}

/// Rays to a fan's targets from a little beside its place. Ray is compared with ray: the mean of those that get through jumps where a rim
/// cuts one more, by more than a small picture's places are apart.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    film: DVec3,
    /// Signed, part of the picture.
    step: f64,
    out: [Option<Ray>; RAYS],
}

impl Fan {
    /// A fan that is not traced yet.
    pub(super) fn new(mount: &Mount, map: &PupilMap, place: Vec2) -> Self {
        let film = mount.film_at(place).point;
        let targets = std::array::from_fn(|i| {
            let (ring, turn) = match i < INNER {
                true => (AREAS[0], (i as f64 + 0.25) / INNER as f64),
                false => (AREAS[1], (i - INNER) as f64 / (RAYS - INNER) as f64),
            };
            map.sample(film, [AFTER_DEFENSIVE + (1.0 - AFTER_DEFENSIVE) * turn, ring]).target
        });
        let beside = [Vec2::X, Vec2::Y].map(|axis| {
            let there = place - axis * BESIDE.copysign(place.dot(axis));
            let step = f64::from((there - place).dot(axis));
            Neighbour { film: mount.film_at(there).point, step, out: [None; RAYS] }
        });
        Self { place, film, targets, out: [None; RAYS], mean: None, beside }
    }

    /// Adds the rays to those to be traced.
    pub(super) fn push(&self, bundle: &mut Bundle) {
        self.push_from(self.film, bundle);
    }

    /// Adds those of both neighbours.
    pub(super) fn push_beside(&self, bundle: &mut Bundle) {
        self.beside.iter().for_each(|neighbour| self.push_from(neighbour.film, bundle));
    }

    fn push_from(&self, film: DVec3, bundle: &mut Bundle) {
        for target in self.targets {
            bundle.push(Ray { origin: film, direction: (target - film).normalize() });
        }
    }

    /// The fan with the results of its rays, which are number `number` of the fans in a bundle, and of its neighbours' in another.
    pub(super) fn traced(mut self, bundle: &Bundle, beside: &Bundle, number: usize) -> Self {
        self.out = Self::out_of(bundle, number);
        self.mean = beam::mean(self.out.iter().flatten());
        for (axis, neighbour) in self.beside.iter_mut().enumerate() {
            neighbour.out = Self::out_of(beside, 2 * number + axis);
        }
        self
    }

    /// The derivatives of the direction in which the place looks by the place, through the same points of the pupil; `None` where no light
    /// arrives.
    pub(super) fn steps(&self, subject: Subject) -> Option<Steps> {
        let mean = self.mean?;
        let slope = |neighbour: &Neighbour| {
            let way = |(here, there): (&Option<Ray>, &Option<Ray>)| {
                Some(subject.met_by(there.as_ref()?, &mean)? - subject.met_by(here.as_ref()?, &mean)?)
            };
            let ways: Vec<DVec3> = self.out.iter().zip(&neighbour.out).filter_map(way).collect();
            (!ways.is_empty()).then(|| ways.iter().sum::<DVec3>() / (ways.len() as f64 * neighbour.step))
        };
        Steps::new(slope(&self.beside[0])?, slope(&self.beside[1])?)
    }

    fn out_of(bundle: &Bundle, number: usize) -> [Option<Ray>; RAYS] {
        std::array::from_fn(|i| bundle.result(number * RAYS + i).ok())
    }

    /// The mean of the rays that get through.
    pub(super) fn mean(&self) -> Option<Ray> {
        self.mean
    }

    /// Distance aside of the mean of each ray, px.
    pub(super) fn aside(&self, survey: &Survey, subject: Subject, steps: &Steps) -> Vec<Option<DVec2>> {
        self.aside_of(&self.out, survey, subject, steps)
    }

    /// Distance aside of the mean of each ray of another wavelength, number `number` in their bundle, px.
    pub(super) fn coloured_aside(
        &self,
        survey: &Survey,
        bundle: &Bundle,
        number: usize,
        subject: Subject,
        steps: &Steps,
    ) -> Vec<Option<DVec2>> {
        self.aside_of(&Self::out_of(bundle, number), survey, subject, steps)
    }

    fn aside_of(
        &self,
        out: &[Option<Ray>; RAYS],
        survey: &Survey,
        subject: Subject,
        steps: &Steps,
    ) -> Vec<Option<DVec2>> {
        let Some(mean) = self.mean else { return vec![None; RAYS] };
        let Some(here) = subject.met_by(&mean, &mean) else { return vec![None; RAYS] };
        let aside = |ray: &Option<Ray>| {
            let there = subject.met_by(ray.as_ref()?, &mean)?;
            Some(steps.place(there - here) * survey.size_px)
        };
        out.iter().map(aside).collect()
    }

    /// Distances aside of the chief ray that Gaussian optics give the rays to the same targets, px.
    pub(super) fn ideal_aside(&self, survey: &Survey, subject: Subject) -> [DVec2; RAYS] {
        let slopes = self.targets.map(|target| slopes(self.film, target));
        let through: Vec<DVec2> = (0..RAYS).filter(|&i| self.out[i].is_some()).map(|i| slopes[i]).collect();
        let chief = through.iter().sum::<DVec2>() / through.len().max(1) as f64;
        let ideal = Ideal::new(survey, self, chief, subject);
        slopes.map(|one| ideal.aside(one) * survey.size_px)
    }

    /// Radius of the blur disc by Gaussian optics through the whole opening, px.
    pub(super) fn blur_radius(&self, survey: &Survey, subject: Subject) -> f64 {
        let gaussian = &survey.gaussian;
        let ideal = Ideal::new(survey, self, gaussian.slopes(self.film, DVec2::ZERO), subject);
        let radius = survey.system.diaphragm().radius_mm();
        let edge = |turn: usize| DVec2::from_angle(TAU * turn as f64 / 8.0) * radius;
        let aside = |turn: usize| (ideal.aside(gaussian.slopes(self.film, edge(turn))) * survey.size_px).length();
        (0..8).map(aside).fold(0.0, f64::max)
    }

    /// Distance of the place from that at which Gaussian optics would show the same subject, px.
    pub(super) fn distortion(&self, survey: &Survey, subject: Subject) -> f64 {
        let (Some(mean), Some(pupil)) = (self.mean, survey.entrance_pupil) else { return f64::INFINITY };
        // The ray from what is seen to the middle of the entrance pupil.
        let direction = match subject {
            Subject::Far => -mean.direction,
            Subject::At(_) => match subject.met_by(&mean, &mean) {
                Some(point) => (pupil - point).normalize_or(-mean.direction),
                None => return f64::INFINITY,
            },
        };
        if direction.z <= 1e-3 {
            return f64::INFINITY;
        }
        let before_film = survey.gaussian.from_scene(&Ray { origin: pupil, direction });
        match survey.mount.picture_point(&before_film) {
            Some(place) => ((place - self.place).as_dvec2() * survey.size_px).length(),
            None => f64::INFINITY,
        }
    }
}

/// Gaussian optics at one place: rays by their slopes before the film.
struct Ideal<'a> {
    gaussian: &'a GaussianLens,
    film: DVec3,
    depth_mm: f64,
    chief: DVec2,
    /// The matrix from the subject's plane to parts of the picture.
    inverse: DMat2,
}

impl<'a> Ideal<'a> {
    /// The ideal image for the place of a fan, beside the ray with these slopes.
    fn new(survey: &'a Survey, fan: &Fan, slopes: DVec2, subject: Subject) -> Self {
        let (gaussian, film) = (&survey.gaussian, fan.film);
        let mut ideal = Self { gaussian, film, depth_mm: subject.depth_mm(), chief: DVec2::ZERO, inverse: DMat2::ZERO };
        // It is linear: any step will do. The neighbour looks through the same point of the stop.
        const STEP: f32 = 1e-2;
        let stop = gaussian.stop_point(film, slopes);
        ideal.chief = ideal.seen(film, slopes);
        let moved = |by: Vec2| {
            let there = survey.mount.film_at(fan.place + by).point;
            (ideal.seen(there, gaussian.slopes(there, stop)) - ideal.chief) / f64::from(STEP)
        };
        let columns = DMat2::from_cols(moved(Vec2::new(STEP, 0.0)), moved(Vec2::new(0.0, STEP)));
        ideal.inverse = inverse(columns).unwrap_or(DMat2::ZERO);
        ideal
    }

    /// The point at which a ray hits the subject's plane; for a far subject the ray's slopes.
    fn seen(&self, film: DVec3, slopes: DVec2) -> DVec2 {
        let ray = self.gaussian.into_scene(film, slopes);
        let along = ray.direction.truncate() / -ray.direction.z;
        if self.depth_mm.is_finite() { ray.origin.truncate() + along * self.depth_mm } else { along }
    }

    fn aside(&self, slopes: DVec2) -> DVec2 {
        self.inverse * (self.seen(self.film, slopes) - self.chief)
    }
}

fn slopes(film: DVec3, target: DVec3) -> DVec2 {
    let to = target - film;
    to.truncate() / to.z
}
