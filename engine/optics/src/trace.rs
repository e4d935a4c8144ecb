//! A ray through a lens, either way: the ray that leaves it, or the surface and reason that ended it.

mod bundle;
mod fate;
mod gradient;
mod layout;
mod reflected;
mod spectral;
mod step;

use std::sync::Arc;

use glam::DVec3;

use crate::diaphragm::Diaphragm;
use crate::interface::Interface;
use crate::lane::Real;
use crate::system::{Element, System};
use crate::vector::Vector;

use gradient::{Gap, Gradients};
use step::{Intersection, is_far};

pub use crate::surface::Failure;
pub use bundle::{Bundle, LINES, Leaving, Traced};
pub use gradient::{GradientNumbers, GradientsBeside};
pub use reflected::{GhostRay, Incidence, ReflectedTracer, SurfaceCrossing, SurfaceEvent};
pub use spectral::{SpectralBundle, SpectralTracer};
pub use step::{Action, Step};

/// A ray in lens space, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// A point on the ray.
    pub origin: DVec3,
    /// The direction: a unit vector.
    pub direction: DVec3,
}

/// A ray that did not get through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost {
    /// Index of the surface that ended it, counted from the scene.
    pub surface: usize,
    /// The reason why the surface ended the ray.
    pub reason: Failure,
}

/// The direction in which rays go through a lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// The direction of the light, from the scene to the film.
    FromScene,
    /// Back, from the film to the scene.
    FromFilm,
}

/// The surfaces in the order of one way through the lens.
#[derive(Clone, Debug)]
struct SurfaceSequence<R> {
    steps: Arc<[Step<R>]>,
    /// Gradients beside the surface of each step; none in a lens without gradients. The indices of the step's `action` then do not
    /// count.
    gradients: Arc<[Option<Gradients<R>>]>,
    travel: Travel,
    /// Vertices of the first and the last surface on the way.
    start_z: f64,
    end_z: f64,
}

/// A system at one wavelength, laid out for tracing in numbers of one kind. Cheap to clone.
///
/// Rays go in and come out in f64; between the first and the last surface everything is done in `R`.
#[derive(Clone, Debug)]
pub struct Tracer<R = f64> {
    from_scene: SurfaceSequence<R>,
    from_film: SurfaceSequence<R>,
    diaphragm: Arc<Diaphragm<R>>,
    wavelength_nm: f64,
}

impl System {
    /// The tracer for rays of one vacuum wavelength in nm.
    pub fn at_wavelength(&self, wavelength_nm: f64) -> Tracer {
        let index = |i: usize| match &self.surfaces()[i].element {
            Element::Refract { from, to } => [from.base_index(wavelength_nm), to.base_index(wavelength_nm)],
            Element::Reflect { medium } => [medium.base_index(wavelength_nm); 2],
        };
        Tracer::new(self, wavelength_nm, index)
    }

    /// [`Self::at_wavelength`] with the index after each surface given instead of taken from the media; of a gradient, where its terms are
    /// 0.
    ///
    /// It serves for comparison with tables that state their indices. Missing ones count as 1.
    pub fn with_indices(&self, wavelength_nm: f64, after: &[f64]) -> Tracer {
        let at = |i: usize| after.get(i).copied().unwrap_or(1.0);
        let index = |i: usize| [if i == 0 { 1.0 } else { at(i - 1) }, at(i)];
        Tracer::new(self, wavelength_nm, index)
    }
}

impl Tracer {
    fn new(system: &System, wavelength_nm: f64, index: impl Fn(usize) -> [f64; 2]) -> Self {
        let surfaces = system.surfaces();
        let gaps = Gap::all(surfaces);
        let mut side = 1.0;
        let mut from_scene = Vec::with_capacity(surfaces.len());
        let mut from_film = Vec::with_capacity(surfaces.len());
        let (mut bent_from_scene, mut bent_from_film) = (Vec::new(), Vec::new());
        for (i, s) in surfaces.iter().enumerate() {
            let [n, n2] = index(i);
            let is_mirror = matches!(s.element, Element::Reflect { .. });
            let (gap_before, gap_behind) = (i.checked_sub(1).and_then(|j| gaps[j].as_ref()), gaps[i].as_ref());
            bent_from_scene.push(Gradients::at(gap_before, gap_behind, s.z_mm, [n, n2]));
            bent_from_film.push(Gradients::at(gap_behind, gap_before, s.z_mm, [n2, n]));
            let is_plain = gap_before.is_none() && gap_behind.is_none();
            let action = |from: f64, to: f64| match is_mirror {
                true => Action::Reflect,
                false if from == to && is_plain => Action::Pass,
                false => Action::Refract(Interface::new(from, to)),
            };
            let side_after = if is_mirror { -side } else { side };
            let before = i.checked_sub(1).map(|j| &surfaces[j]);
            let after = surfaces.get(i + 1);
            from_scene.push(Step {
                shape: s.shape,
                pose: Some(s.pose).filter(|pose| !pose.is_identity()),
                to_here: before.map_or(0.0, |b| -b.thickness_mm),
                side,
                clear_squared: s.semi_diameter_mm * s.semi_diameter_mm,
                obstruction_squared: s.obstruction_mm * s.obstruction_mm,
                action: action(n, n2),
                is_stop: i == system.stop(),
                is_far: before.is_some_and(|b| is_far(b, s, b.thickness_mm)),
            });
            from_film.push(Step {
                to_here: after.map_or(0.0, |_| s.thickness_mm),
                side: -side_after,
                action: action(n2, n),
                is_far: after.is_some_and(|a| is_far(a, s, s.thickness_mm)),
                ..from_scene[i]
            });
            side = side_after;
        }
        from_film.reverse();
        bent_from_film.reverse();
        let last_z = system.last_vertex_z_mm();
        let way = |steps: Vec<Step>, mut gradients: Vec<Option<Gradients<f64>>>, travel, start_z, end_z| {
            gradients.truncate(if gaps.iter().any(Option::is_some) { steps.len() } else { 0 });
            SurfaceSequence { steps: steps.into(), gradients: gradients.into(), travel, start_z, end_z }
        };
        Self {
            from_scene: way(from_scene, bent_from_scene, Travel::FromScene, 0.0, last_z),
            from_film: way(from_film, bent_from_film, Travel::FromFilm, last_z, 0.0),
            diaphragm: Arc::new(system.diaphragm().clone()),
            wavelength_nm,
        }
    }

    /// A copy of this lens without central obstructions.
    pub(crate) fn without_obstructions(&self) -> Self {
        let clear = |step: &Step| Step { obstruction_squared: 0.0, ..*step };
        Self { from_scene: self.from_scene.map(clear), from_film: self.from_film.map(clear), ..self.clone() }
    }

    /// A copy of this lens without the mask in its diaphragm.
    pub(crate) fn without_mask(&self) -> Self {
        Self { diaphragm: Arc::new(self.diaphragm.without_mask()), ..self.clone() }
    }

    /// A copy of this lens without rims, stop and obstructions: it passes all rays that its surfaces can carry.
    pub fn without_rims(&self) -> Self {
        let open = |step: &Step| Step {
            clear_squared: f64::INFINITY,
            obstruction_squared: 0.0,
            is_stop: false,
            // A ray may come from far outside of what the rims let through.
            is_far: true,
            ..*step
        };
        Self { from_scene: self.from_scene.map(open), from_film: self.from_film.map(open), ..self.clone() }
    }

    /// True if some surface has a central obstruction.
    pub(crate) fn has_obstructions(&self) -> bool {
        self.from_scene.steps.iter().any(|s| s.obstruction_squared > 0.0)
    }

    /// This lens traced in numbers of another kind.
    pub fn cast<R: Real>(&self) -> Tracer<R> {
        Tracer {
            from_scene: self.from_scene.map(Step::cast),
            from_film: self.from_film.map(Step::cast),
            diaphragm: Arc::new(self.diaphragm.cast()),
            wavelength_nm: self.wavelength_nm,
        }
    }
}

impl Tracer {
    /// [`Self::from_scene`] with the places in lens space that the ray comes by: its hits, and between them some more in media in which it
    /// bends.
    pub fn path_from_scene(&self, ray: Ray) -> Result<(Ray, Vec<DVec3>), Lost> {
        self.from_scene.path(ray, &self.diaphragm)
    }
}

impl<R: Real> Tracer<R> {
    /// The vacuum wavelength in nm.
    pub fn wavelength_nm(&self) -> f64 {
        self.wavelength_nm
    }

    /// Number of surfaces that a ray comes to between scene and film.
    pub fn surface_count(&self) -> usize {
        self.from_scene.steps.len()
    }

    /// Traces a ray from the scene to the film: the ray that leaves the last surface, its origin on that surface.
    #[inline(never)]
    pub fn from_scene(&self, ray: Ray) -> Result<Ray, Lost> {
        self.from_scene.run(ray, &self.diaphragm, &mut |_| {})
    }

    /// Traces a ray from the film to the scene: the ray that leaves the first surface, its origin on that surface.
    #[inline(never)]
    pub fn from_film(&self, ray: Ray) -> Result<Ray, Lost> {
        self.from_film.run(ray, &self.diaphragm, &mut |_| {})
    }

    /// [`Self::from_scene`] that appends the hits in lens space to `hits`, in the order of travel, the last on the surface that ended the
    /// ray if it was reached.
    pub fn from_scene_recording(&self, ray: Ray, hits: &mut Vec<DVec3>) -> Result<Ray, Lost> {
        self.from_scene.run_recording(ray, &self.diaphragm, hits)
    }

    /// [`Self::from_scene`] that appends the length of the way to each surface from the one before, the first from the ray's origin, to
    /// `lengths_mm`. A length is negative where the ray hits a surface before it has left the one in front of that. In a gradient it is
    /// the optical path over the index on the axis just before the next surface.
    pub fn from_scene_measuring(&self, ray: Ray, lengths_mm: &mut Vec<f64>) -> Result<Ray, Lost> {
        self.from_scene.run_measuring(ray, &self.diaphragm, lengths_mm)
    }

    /// [`Self::from_film`] that appends the hits in lens space to `hits`, last surface first.
    pub fn from_film_recording(&self, ray: Ray, hits: &mut Vec<DVec3>) -> Result<Ray, Lost> {
        self.from_film.run_recording(ray, &self.diaphragm, hits)
    }

    fn way(&self, travel: Travel) -> &SurfaceSequence<R> {
        match travel {
            Travel::FromScene => &self.from_scene,
            Travel::FromFilm => &self.from_film,
        }
    }
}

/// [`Step::pass_gradients`] for one ray.
#[cold]
#[inline(never)]
fn bent<R: Real>(
    step: &Step<R>,
    gradients: &Gradients<R>,
    p: Vector<R>,
    d: Vector<R>,
    diaphragm: &Diaphragm<R>,
) -> Intersection<R> {
    step.pass_gradients(p, d, diaphragm, None, gradients)
}

impl SurfaceSequence<f64> {
    /// [`Self::run`] with the places in lens space that the ray comes by: its hits, and some between them where it bends.
    #[inline(never)]
    fn path(&self, ray: Ray, diaphragm: &Diaphragm) -> Result<(Ray, Vec<DVec3>), Lost> {
        let (mut p, mut d) = self.enter(ray);
        let (mut z, mut places) = (self.start_z, Vec::new());
        for (i, step) in self.steps.iter().enumerate() {
            z -= step.to_here;
            let passage = match self.gradients(i) {
                None => step.pass(p, d, diaphragm, None),
                Some(gradients) => {
                    let here = Vector { z: p.z + step.to_here, ..p };
                    places.extend(gradients.places(step, here, d).iter().map(|place| place.with_z(place.z + z)));
                    bent(step, gradients, p, d, diaphragm)
                }
            };
            if let Some(reason) = passage.fates().failure(0) {
                return Err(Lost { surface: self.surface(i), reason });
            }
            (p, d) = (passage.point, passage.direction);
            let hit = p.of(0);
            places.push(hit.with_z(hit.z + z));
        }
        Ok((self.leave(p.of(0), d.of(0)), places))
    }

    fn map<R: Real>(&self, change: impl Fn(&Step) -> Step<R>) -> SurfaceSequence<R> {
        let Self { travel, start_z, end_z, .. } = *self;
        let gradients = self.gradients.iter().map(|beside| beside.as_ref().map(Gradients::cast)).collect();
        SurfaceSequence { steps: self.steps.iter().map(change).collect(), gradients, travel, start_z, end_z }
    }
}

impl<R: Real> SurfaceSequence<R> {
    /// The media beside a step's surface, where one is a gradient.
    #[inline(always)]
    fn gradients(&self, step: usize) -> Option<&Gradients<R>> {
        self.gradients.get(step)?.as_ref()
    }

    /// Index of a step's surface, counted from the scene.
    fn surface(&self, step: usize) -> usize {
        match self.travel {
            Travel::FromScene => step,
            Travel::FromFilm => self.steps.len() - 1 - step,
        }
    }

    /// The ray seen from the first vertex on the way, its origin carried to the point nearest to that: done in f64,
    /// so that a source far away keeps its digits.
    #[inline(always)]
    fn enter(&self, ray: Ray) -> (Vector<R>, Vector<R>) {
        (Vector::from_f64(self.nearest(ray)), Vector::from_f64(ray.direction))
    }

    /// The point of the ray nearest to the first vertex on the way, seen from there.
    #[inline(always)]
    fn nearest(&self, ray: Ray) -> DVec3 {
        let mut origin = ray.origin;
        origin.z -= self.start_z;
        origin - ray.direction * origin.dot(ray.direction)
    }

    /// The ray in lens space that leaves the last surface on the way at `p` of its vertex.
    #[inline(always)]
    fn leave(&self, p: DVec3, d: DVec3) -> Ray {
        // Each surface leaves the length off by a rounding or two, a grazed one by more. Two steps of Newton: from the
        // roundings of f32 to those of f64.
        let nearly = d * (1.5 - 0.5 * d.length_squared());
        let direction = nearly * (1.5 - 0.5 * nearly.length_squared());
        Ray { origin: p.with_z(p.z + self.end_z), direction }
    }

    /// Traces a ray through all steps, each in the coordinates of its own vertex: no digits are lost to the length of the lens.
    #[inline(always)]
    fn run(&self, ray: Ray, diaphragm: &Diaphragm<R>, record: &mut impl FnMut(DVec3)) -> Result<Ray, Lost> {
        let (mut p, mut d) = self.enter(ray);
        for (i, step) in self.steps.iter().enumerate() {
            let passage = match self.gradients(i) {
                None => step.pass(p, d, diaphragm, None),
                Some(gradients) => bent(step, gradients, p, d, diaphragm),
            };
            if passage.crossing.met {
                record(passage.point.of(0));
            }
            if let Some(reason) = passage.fates().failure(0) {
                return Err(Lost { surface: self.surface(i), reason });
            }
            (p, d) = (passage.point, passage.direction);
        }
        Ok(self.leave(p.of(0), d.of(0)))
    }

    #[inline(never)]
    fn run_measuring(&self, ray: Ray, diaphragm: &Diaphragm<R>, lengths_mm: &mut Vec<f64>) -> Result<Ray, Lost> {
        let (mut before, mut z) = (ray.origin, self.start_z);
        let (mut p, mut d) = self.enter(ray);
        for (i, step) in self.steps.iter().enumerate() {
            let along: DVec3 = d.of(0);
            z -= step.to_here.to_f64();
            let gradients = self.gradients(i);
            let in_gradient = gradients
                .and_then(|gradients| gradients.reduced_length(step, Vector { z: p.z + step.to_here, ..p }, d));
            let passage = match gradients {
                None => step.pass(p, d, diaphragm, None),
                Some(gradients) => bent(step, gradients, p, d, diaphragm),
            };
            if let Some(reason) = passage.fates().failure(0) {
                return Err(Lost { surface: self.surface(i), reason });
            }
            let hit = passage.point.of(0) + DVec3::Z * z;
            lengths_mm.push(in_gradient.map_or_else(|| (hit - before).dot(along), R::to_f64));
            before = hit;
            (p, d) = (passage.point, passage.direction);
        }
        Ok(self.leave(p.of(0), d.of(0)))
    }

    #[inline(never)]
    fn run_recording(&self, ray: Ray, diaphragm: &Diaphragm<R>, hits: &mut Vec<DVec3>) -> Result<Ray, Lost> {
        let first = hits.len();
        let result = self.run(ray, diaphragm, &mut |p| hits.push(p));
        let mut z = self.start_z;
        for (step, hit) in self.steps.iter().zip(&mut hits[first..]) {
            z -= step.to_here.to_f64();
            hit.z += z;
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens::parse;
    use crate::glass::Catalogue;
    use crate::system::LensSettings;

    /// A hemisphere of glass with an obstruction, its flat rear side the stop, five blades.
    fn tracer() -> Tracer {
        let text = "#radius thickness glass diameter conic isstop obstruction
                    10 10 1.5 19.9 -0.0 0 2\n 0 5 air 10 0 1 0\n 2 2 1.8 4.0 -4 0 0";
        let settings = LensSettings { f_number: Some(4.0), blades: 5, ..LensSettings::default() };
        let prescription = parse(text, "test", Catalogue::shipped()).unwrap();
        System::new(&prescription, &settings).unwrap().at_wavelength(550.0)
    }

    fn lost(origin: [f64; 3], direction: [f64; 3]) -> Lost {
        let direction = DVec3::from(direction).normalize();
        tracer().from_scene(Ray { origin: origin.into(), direction }).unwrap_err()
    }

    #[test]
    fn every_reason_names_its_surface() {
        let along = [0.0, 0.0, 1.0];
        assert_eq!(lost([11.0, 0.0, -5.0], along), Lost { surface: 0, reason: Failure::Missed });
        assert_eq!(lost([9.96, 0.0, -5.0], along), Lost { surface: 0, reason: Failure::OutsideAperture });
        assert_eq!(lost([0.99, 0.0, -5.0], along), Lost { surface: 0, reason: Failure::Obstructed });
        assert_eq!(lost([5.0, 0.0, -5.0], along), Lost { surface: 1, reason: Failure::BladeStop });
        assert_eq!(lost([20.0, 0.0, 12.0], [-1.0, 0.0, 0.01]), Lost { surface: 0, reason: Failure::WrongSheet });
    }

    #[test]
    fn points_on_a_rim_pass() {
        let text = "0 5 1.5 10 0 1";
        let tracer = System::new(&parse(text, "test", Catalogue::shipped()).unwrap(), &LensSettings::default());
        let tracer = tracer.unwrap().at_wavelength(550.0);
        let at = |x: f64| tracer.from_scene(Ray { origin: DVec3::new(x, 4.0, -1.0), direction: DVec3::Z });
        assert!(at(3.0).is_ok());
        assert_eq!(at(3.0f64.next_up()).unwrap_err().reason, Failure::OutsideAperture);
    }

    #[test]
    fn a_ray_into_the_thinner_medium_can_turn_back() {
        let text = "0 5 1.5 100 0 1\n 0 5 air 100 0 0";
        let tracer = System::new(&parse(text, "test", Catalogue::shipped()).unwrap(), &LensSettings::default());
        let tracer = tracer.unwrap().with_indices(550.0, &[1.0, 0.7]);
        let ray = Ray { origin: DVec3::new(0.0, 0.0, -1.0), direction: DVec3::new(0.9, 0.0, 0.5).normalize() };
        let expected = Lost { surface: 1, reason: Failure::TotalInternalReflection };
        assert_eq!(tracer.from_scene(ray).unwrap_err(), expected);
    }
}
