//! Light that turns back at surfaces which are meant to let it through: a path with given reflections, laid out as steps of its
//! own so that rays go along it as along any lens; and one surface at a time, for callers that decide at each whether a ray is reflected or
//! refracted.

use std::sync::Arc;

use glam::DVec3;

use crate::surface::Failure;
use crate::system::System;
use crate::vector::Vector;

use super::step::{Action, Intersection, Step};
use super::{Lost, Ray, SurfaceSequence, Tracer, Travel, bent};

/// A surface as a path comes to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceCrossing {
    /// Index of the surface, counted from the scene.
    pub surface: usize,
    /// True if the ray comes from the scene's side of the lens.
    pub towards_film: bool,
    /// True if the path turns round here by a reflection that the lens was not made for.
    pub turns: bool,
}

/// The incidence of a path on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incidence {
    /// The surface, and the direction of travel.
    pub meeting: SurfaceCrossing,
    /// Cosine of the angle to the normal, 0 to 1.
    pub cos: f64,
    /// Distance from the surface before, mm along the ray; the first from where the ray was nearest to the first vertex. In a gradient it
    /// is that of the straight line.
    pub length_mm: f64,
}

/// A path with reflections at surfaces that refract, at one wavelength.
#[derive(Clone, Debug)]
pub struct ReflectedTracer {
    tracer: Tracer,
    meetings: Arc<[SurfaceCrossing]>,
}

impl Tracer {
    /// The path from the scene to the film that turns round at these surfaces one after the other: the first is hit on the way to the
    /// film, the next on the way back, nearer to the scene, and so on. Rims and diaphragm are asked each time the path
    /// comes by. `None` if the turns are an odd number or not in that order.
    pub fn reflected(&self, turns: &[usize]) -> Option<ReflectedTracer> {
        let meetings = meetings(self.surface_count(), turns)?;
        let (steps, gradients): (Vec<Step>, Vec<_>) = meetings
            .iter()
            .map(|meeting| {
                let (step, gradients) = self.step_at(*meeting);
                (step, gradients.cloned())
            })
            .unzip();
        let has_gradients = gradients.iter().any(Option::is_some);
        let SurfaceSequence { start_z, end_z, .. } = self.from_scene;
        let from_scene = SurfaceSequence {
            steps: steps.into(),
            gradients: if has_gradients { gradients.into() } else { Arc::default() },
            travel: Travel::FromScene,
            start_z,
            end_z,
        };
        let tracer = Self { from_scene, ..self.clone() };
        Some(ReflectedTracer { tracer, meetings: meetings.into() })
    }

    /// The step of a ray at the surface of a meeting, and the gradients of the direction of travel.
    fn step_at(&self, meeting: SurfaceCrossing) -> (Step, Option<&super::Gradients<f64>>) {
        let (way, i) = match meeting.towards_film {
            true => (&self.from_scene, meeting.surface),
            false => (&self.from_film, self.surface_count() - 1 - meeting.surface),
        };
        let step = way.steps[i];
        (if meeting.turns { Step { action: Action::Reflect, ..step } } else { step }, way.gradients(i))
    }

    /// A ray that comes from the scene, before the first surface.
    pub fn wander(&self, ray: Ray) -> GhostRay<'_> {
        let (p, d) = self.from_scene.enter(ray);
        GhostRay { tracer: self, p, d, next: Some(0), towards_film: true }
    }
}

/// Surfaces in the order of travel.
fn meetings(count: usize, turns: &[usize]) -> Option<Vec<SurfaceCrossing>> {
    if !turns.len().is_multiple_of(2) {
        return None;
    }
    let (mut found, mut at, mut towards_film, mut left) = (Vec::new(), 0, true, turns.iter().copied().peekable());
    loop {
        if at >= count {
            return left.next().is_none().then_some(found);
        }
        let turns = left.peek() == Some(&at);
        found.push(SurfaceCrossing { surface: at, towards_film, turns });
        if turns {
            left.next();
            towards_film = !towards_film;
        }
        // Back to the scene.
        at = if towards_film { at + 1 } else { at.checked_sub(1)? };
    }
}

impl ReflectedTracer {
    /// The tracer of the path, for bundles, and for the ray that leaves the last surface: only [`Travel::FromScene`] is the path, and a
    /// loss names the number of a meeting instead of a surface.
    pub fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// The surfaces that the path hits, in the order of travel.
    pub fn meetings(&self) -> &[SurfaceCrossing] {
        &self.meetings
    }

    /// The ray that leaves the last surface, and the events at each on the way.
    pub fn from_scene(&self, ray: Ray, each: &mut impl FnMut(Incidence)) -> Result<Ray, Lost> {
        let way = &self.tracer.from_scene;
        let (mut p, mut d) = way.enter(ray);
        for (i, (step, meeting)) in way.steps.iter().zip(self.meetings.iter()).enumerate() {
            let passage = pass(&self.tracer, step, way.gradients(i), p, d);
            if let Some(reason) = passage.fates().failure(0) {
                return Err(Lost { surface: meeting.surface, reason });
            }
            each(Incidence { meeting: *meeting, cos: cosine(&passage), length_mm: length_mm(step, p, &passage) });
            (p, d) = (passage.point, passage.direction);
        }
        Ok(way.leave(p.of(0), d.of(0)))
    }
}

fn pass(
    tracer: &Tracer,
    step: &Step,
    gradients: Option<&super::Gradients<f64>>,
    p: Vector<f64>,
    d: Vector<f64>,
) -> Intersection<f64> {
    match gradients {
        None => step.pass(p, d, &tracer.diaphragm, None),
        Some(gradients) => bent(step, gradients, p, d, &tracer.diaphragm),
    }
}

/// Cosine of the angle of incidence.
fn cosine(passage: &Intersection<f64>) -> f64 {
    (passage.crossing.cosine_squared / passage.crossing.normal_squared).sqrt().min(1.0)
}

/// Distance from the ray's place, seen from the vertex before, to its hit on the surface.
fn length_mm(step: &Step, p: Vector<f64>, passage: &Intersection<f64>) -> f64 {
    let before: DVec3 = Vector { z: p.z + step.to_here, ..p }.of(0);
    let met: DVec3 = passage.point.of(0);
    met.distance(before)
}

/// A ray among the surfaces of a lens, which may turn round at any of them.
#[derive(Clone)]
pub struct GhostRay<'a> {
    tracer: &'a Tracer,
    p: Vector<f64>,
    d: Vector<f64>,
    /// The surface that the ray comes to; `None` once the ray is out on the film's side.
    next: Option<usize>,
    towards_film: bool,
}

/// The next event of a wanderer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceEvent {
    /// A surface that the ray may go on through or turn round at, by [`GhostRay::go`].
    Surface(Incidence),
    /// The end of the path: it has left the lens towards the film.
    Film(Ray),
    /// The end of the path: it has left the lens towards the scene.
    Scene,
    /// A rim, or no surface at all.
    Lost(Lost),
}

impl GhostRay<'_> {
    /// The next event of the ray.
    pub fn encounter(&self) -> SurfaceEvent {
        let Some(surface) = self.next else { return SurfaceEvent::Scene };
        if surface >= self.tracer.surface_count() {
            return SurfaceEvent::Film(self.tracer.from_scene.leave(self.p.of(0), self.d.of(0)));
        }
        let meeting = SurfaceCrossing { surface, towards_film: self.towards_film, turns: true };
        let (step, gradients) = self.tracer.step_at(meeting);
        // To turn round is always possible where there is a surface.
        let passage = pass(self.tracer, &step, gradients, self.p, self.d);
        match passage.fates().failure(0) {
            Some(reason) => SurfaceEvent::Lost(Lost { surface, reason }),
            None => SurfaceEvent::Surface(Incidence {
                meeting,
                cos: cosine(&passage),
                length_mm: length_mm(&step, self.p, &passage),
            }),
        }
    }

    /// Goes on through the surface that it came to, or turns round there. Where it cannot go through, it is lost.
    pub fn go(&mut self, turns: bool) -> Result<(), Failure> {
        let Some(surface) = self.next else { return Err(Failure::Missed) };
        let meeting = SurfaceCrossing { surface, towards_film: self.towards_film, turns };
        let (step, gradients) = self.tracer.step_at(meeting);
        let passage = pass(self.tracer, &step, gradients, self.p, self.d);
        if let Some(reason) = passage.fates().failure(0) {
            return Err(reason);
        }
        (self.p, self.d) = (passage.point, passage.direction);
        self.towards_film ^= turns;
        self.next = if self.towards_film { Some(surface + 1) } else { surface.checked_sub(1) };
        Ok(())
    }
}

impl System {
    /// The surfaces at which light may be reflected so many times, 2 or 4, and still get to the film, for [`Tracer::reflected`]: those
    /// that part two media at this wavelength. A mirror is no ghost.
    pub fn reflecting_paths(&self, wavelength_nm: f64, reflections: usize) -> Vec<Vec<usize>> {
        let reflects = |i: &usize| match &self.surfaces()[*i].element {
            crate::system::Element::Refract { from, to } => from.index(wavelength_nm) != to.index(wavelength_nm),
            crate::system::Element::Reflect { .. } => false,
        };
        let those: Vec<usize> = (0..self.surface_count()).filter(reflects).collect();
        let mut paths = vec![Vec::new()];
        for turn in 0..reflections {
            // To and fro: from a turn towards the scene only surfaces behind it come next, and the other way round.
            let next = |path: &Vec<usize>| {
                let is_next = |i: &usize| match path.last() {
                    Some(last) if turn % 2 == 0 => i > last,
                    Some(last) => i < last,
                    None => true,
                };
                those.iter().copied().filter(is_next).map(|i| [path.as_slice(), &[i]].concat()).collect::<Vec<_>>()
            };
            paths = paths.iter().flat_map(next).collect();
        }
        paths
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::ghosts;
    use crate::glass::Catalogue;
    use crate::system::LensSettings;

    fn system(text: &str) -> System {
        System::new(&lens::parse(text, "test.lens", Catalogue::shipped()).unwrap(), &LensSettings::default()).unwrap()
    }

    const TRIPLET: &str = "40.1 6 SK4 34 0 0\n-537 10 air 34 0 0\n-47 1 SF2 26 0 0\n40 1 air 26 0 0\n0 9.8 air 25 0 1\n234.5 6 SK4 28 0 0\n-37.9 85 air 28 0 0";

    /// Down the lens, back, and down again: each surface in its turn.
    #[test]
    fn a_path_goes_to_and_fro() {
        let order = |turns: &[usize]| {
            let all = meetings(4, turns)?;
            Some(all.iter().map(|m| (m.surface, m.towards_film, m.turns)).collect::<Vec<_>>())
        };
        let expected = [
            (0, true, false),
            (1, true, false),
            (2, true, true),
            (1, false, false),
            (0, false, true),
            (1, true, false),
        ];
        assert_eq!(order(&[2, 0]).unwrap()[..6], expected);
        assert_eq!(order(&[2, 0]).unwrap().len(), 8);
        assert_eq!(order(&[3, 1, 2, 0]).unwrap().len(), 12);
        assert_eq!((order(&[1]), order(&[0, 1]), order(&[1, 3])), (None, None, None));
        assert_eq!(order(&[]).unwrap().len(), 4);
    }

    /// A ray close to the axis lands where the path's matrix has it, for all pairs of a triplet.
    #[test]
    fn rays_near_the_axis_follow_first_order() {
        let triplet = system(TRIPLET);
        let film = 110.0;
        let tracer = triplet.at_wavelength(587.6);
        let first_order = ghosts::all(&triplet, 587.6, film, 1e-9);
        assert_eq!(first_order.len(), triplet.reflecting_paths(587.6, 2).len());
        for ghost in first_order {
            let [earlier, later] = ghost.surfaces;
            let path = tracer.reflected(&[later, earlier]).unwrap();
            let height = 1e-4;
            let ray = Ray { origin: DVec3::new(0.0, height, -1.0), direction: DVec3::Z };
            let out = path.tracer().from_scene(ray).unwrap();
            let at_film = out.origin.y + out.direction.y / out.direction.z * (film - out.origin.z);
            // The disc is that of the beam that all rims let through.
            let beam = (ghost.irradiance / ghost.reflectance).sqrt() * ghost.radius_mm;
            let expected = ghost.radius_mm / beam * height;
            assert!((at_film.abs() / expected - 1.0).abs() < 1e-5, "{:?} {at_film} {expected}", ghost.surfaces);
        }
    }

    /// One surface at a time is the path as a whole.
    #[test]
    fn a_wanderer_comes_along_the_path() {
        let triplet = system(TRIPLET);
        let tracer = triplet.at_wavelength(550.0);
        let ray = Ray { origin: DVec3::new(2.0, 3.0, -5.0), direction: DVec3::new(0.02, -0.03, 1.0).normalize() };
        let twice = triplet.reflecting_paths(550.0, 2);
        assert_eq!((twice.len(), triplet.reflecting_paths(550.0, 4).len()), (15, 190));
        for turns in twice.iter().chain(&triplet.reflecting_paths(550.0, 4)) {
            let path = tracer.reflected(turns).unwrap();
            let mut met = Vec::new();
            let expected = path.from_scene(ray, &mut |incidence| met.push(incidence));
            let mut wanderer = tracer.wander(ray);
            let mut own = Vec::new();
            let ended = loop {
                match wanderer.encounter() {
                    SurfaceEvent::Surface(incidence) => {
                        let turns = path.meetings().get(own.len()).is_some_and(|meeting| meeting.turns);
                        let meeting = SurfaceCrossing { turns, ..incidence.meeting };
                        own.push(Incidence { meeting, ..incidence });
                        if let Err(reason) = wanderer.go(turns) {
                            // It hit the surface, and the path as a whole did not say so.
                            own.pop();
                            break Err(Lost { surface: meeting.surface, reason });
                        }
                    }
                    SurfaceEvent::Film(ray) => break Ok(ray),
                    SurfaceEvent::Lost(lost) => break Err(lost),
                    SurfaceEvent::Scene => panic!("back to the scene"),
                }
            };
            assert_eq!(ended, expected);
            assert_eq!(own, met);
        }
    }
}
