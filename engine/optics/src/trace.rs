//! A ray through a lens, either way: the ray that leaves it, or the surface and reason that ended it.

mod packet;

use std::sync::Arc;

use glam::DVec3;

use crate::diaphragm::Diaphragm;
use crate::interface::{Interface, reflect};
use crate::surface::{Conic, Hit};
use crate::system::{Element, Surface, System};

pub use crate::surface::Failure;

/// A ray in lens space, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// A point on it.
    pub origin: DVec3,
    /// Where it goes: a unit vector.
    pub direction: DVec3,
}

/// A ray that did not get through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost {
    /// Index of the surface that ended it, counted from the scene.
    pub surface: usize,
    /// Why.
    pub reason: Failure,
}

/// What a surface does to the direction.
#[derive(Clone, Copy, Debug)]
enum Action {
    Refract(Interface),
    /// The same medium on both sides.
    Pass,
    Reflect,
}

/// One surface, ready for rays of one wavelength in one direction of travel.
#[derive(Clone, Copy, Debug)]
struct Step {
    shape: Conic,
    /// Added to z when the ray leaves the surface before: from its vertex to this one.
    to_here: f64,
    /// sign(N · D) of the crossing that is meant.
    side: f64,
    clear_squared: f64,
    obstruction_squared: f64,
    /// Square of the diaphragm's radius at the stop, infinite elsewhere.
    round_stop_squared: f64,
    action: Action,
    is_stop: bool,
    /// True if a ray from the surface before may start so far away, in radii, that it must be carried first.
    is_far: bool,
}

/// Beyond so many radii of curvature between surfaces, a ray is carried to its point nearest the vertex: larger
/// loses that many units in the last place, smaller costs time.
const FAR_RADII: f64 = 16.0;

/// A system at one wavelength, laid out for tracing. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Tracer {
    from_scene: Arc<[Step]>,
    from_film: Arc<[Step]>,
    diaphragm: Arc<Diaphragm>,
    wavelength_nm: f64,
    /// Vertex of the last surface.
    last_z: f64,
}

impl System {
    /// The tracer for rays of one vacuum wavelength in nm.
    pub fn at_wavelength(&self, wavelength_nm: f64) -> Tracer {
        let index = |i: usize| match &self.surfaces()[i].element {
            Element::Refract { from, to } => [from.index(wavelength_nm), to.index(wavelength_nm)],
            Element::Reflect { medium } => [medium.index(wavelength_nm); 2],
        };
        Tracer::new(self, wavelength_nm, index)
    }

    /// As [`Self::at_wavelength`], with the index after each surface given instead of taken from the media.
    ///
    /// For comparison with tables that state their indices. Missing ones count as 1.
    pub fn with_indices(&self, wavelength_nm: f64, after: &[f64]) -> Tracer {
        let at = |i: usize| after.get(i).copied().unwrap_or(1.0);
        let index = |i: usize| [if i == 0 { 1.0 } else { at(i - 1) }, at(i)];
        Tracer::new(self, wavelength_nm, index)
    }
}

impl Tracer {
    fn new(system: &System, wavelength_nm: f64, index: impl Fn(usize) -> [f64; 2]) -> Self {
        let surfaces = system.surfaces();
        let opening = system.diaphragm().radius_mm();
        let mut side = 1.0;
        let mut from_scene = Vec::with_capacity(surfaces.len());
        let mut from_film = Vec::with_capacity(surfaces.len());
        for (i, s) in surfaces.iter().enumerate() {
            let [n, n2] = index(i);
            let is_mirror = matches!(s.element, Element::Reflect { .. });
            let action = |from: f64, to: f64| match is_mirror {
                true => Action::Reflect,
                false if from == to => Action::Pass,
                false => Action::Refract(Interface::new(from, to)),
            };
            let side_after = if is_mirror { -side } else { side };
            let before = i.checked_sub(1).map(|j| &surfaces[j]);
            let after = surfaces.get(i + 1);
            let is_stop = i == system.stop();
            from_scene.push(Step {
                shape: s.shape,
                to_here: before.map_or(0.0, |b| -b.thickness_mm),
                side,
                clear_squared: s.semi_diameter_mm * s.semi_diameter_mm,
                obstruction_squared: s.obstruction_mm * s.obstruction_mm,
                round_stop_squared: if is_stop { opening * opening } else { f64::INFINITY },
                action: action(n, n2),
                is_stop,
                is_far: before.is_none_or(|b| is_far(b, s, b.thickness_mm)),
            });
            from_film.push(Step {
                to_here: after.map_or(0.0, |_| s.thickness_mm),
                side: -side_after,
                action: action(n2, n),
                is_far: after.is_none_or(|a| is_far(a, s, s.thickness_mm)),
                ..from_scene[i]
            });
            side = side_after;
        }
        from_film.reverse();
        Self {
            from_scene: from_scene.into(),
            from_film: from_film.into(),
            diaphragm: Arc::new(system.diaphragm().clone()),
            wavelength_nm,
            last_z: system.last_vertex_z_mm(),
        }
    }

    /// The vacuum wavelength in nm.
    pub fn wavelength_nm(&self) -> f64 {
        self.wavelength_nm
    }

    /// Number of surfaces.
    pub fn surface_count(&self) -> usize {
        self.from_scene.len()
    }

    /// The same lens without central obstructions.
    pub(crate) fn without_obstructions(&self) -> Self {
        let clear = |steps: &[Step]| steps.iter().map(|s| Step { obstruction_squared: 0.0, ..*s }).collect();
        Self { from_scene: clear(&self.from_scene), from_film: clear(&self.from_film), ..self.clone() }
    }

    /// True if some surface has a central obstruction.
    pub(crate) fn has_obstructions(&self) -> bool {
        self.from_scene.iter().any(|s| s.obstruction_squared > 0.0)
    }

    /// From the scene to the film: the ray that leaves the last surface, its origin on that surface.
    pub fn from_scene(&self, ray: Ray) -> Result<Ray, Lost> {
        self.scene_to_film(ray, &mut |_| {})
    }

    /// From the film to the scene: the ray that leaves the first surface, its origin on that surface.
    #[inline]
    pub fn from_film(&self, ray: Ray) -> Result<Ray, Lost> {
        self.film_to_scene(ray, &mut |_| {})
    }

    /// As [`Self::from_scene`]; appends the hits in lens space to `hits`, in the order of travel, the last on the
    /// surface that ended the ray if it was reached.
    pub fn from_scene_recording(&self, ray: Ray, hits: &mut Vec<DVec3>) -> Result<Ray, Lost> {
        let mut z = 0.0;
        let first = hits.len();
        let result = self.scene_to_film(ray, &mut |p| hits.push(p));
        for (step, hit) in self.from_scene.iter().zip(&mut hits[first..]) {
            z -= step.to_here;
            hit.z += z;
        }
        result
    }

    /// As [`Self::from_film`]; appends the hits in lens space to `hits`, last surface first.
    pub fn from_film_recording(&self, ray: Ray, hits: &mut Vec<DVec3>) -> Result<Ray, Lost> {
        let mut z = self.last_z;
        let first = hits.len();
        let result = self.film_to_scene(ray, &mut |p| hits.push(p));
        for (step, hit) in self.from_film.iter().zip(&mut hits[first..]) {
            z -= step.to_here;
            hit.z += z;
        }
        result
    }

    #[inline(always)]
    fn scene_to_film(&self, ray: Ray, record: &mut impl FnMut(DVec3)) -> Result<Ray, Lost> {
        let result = self.run(&self.from_scene, ray, record);
        let mut out = result.map_err(|(surface, reason)| Lost { surface, reason })?;
        out.origin.z += self.last_z;
        Ok(out)
    }

    #[inline(always)]
    fn film_to_scene(&self, mut ray: Ray, record: &mut impl FnMut(DVec3)) -> Result<Ray, Lost> {
        ray.origin.z -= self.last_z;
        let last = self.from_film.len() - 1;
        self.run(&self.from_film, ray, record).map_err(|(step, reason)| Lost { surface: last - step, reason })
    }

    /// Through all steps, each in the coordinates of its own vertex: no digits are lost to the length of the lens.
    #[inline(always)]
    fn run(&self, steps: &[Step], ray: Ray, record: &mut impl FnMut(DVec3)) -> Result<Ray, (usize, Failure)> {
        let Ray { origin: mut p, direction: mut d } = ray;
        for (i, step) in steps.iter().enumerate() {
            p.z += step.to_here;
            let hit = step.meet(p, d).map_err(|reason| (i, reason))?;
            record(hit.point);
            step.let_through(&hit, &self.diaphragm).map_err(|reason| (i, reason))?;
            d = match &step.action {
                Action::Refract(interface) => interface.refract(d, &hit, step.side).map_err(|reason| (i, reason))?,
                Action::Pass => d,
                Action::Reflect => reflect(d, &hit, step.side),
            };
            p = hit.point;
        }
        // One step of Newton: each surface leaves the length off by a rounding or two.
        let direction = d * (1.5 - 0.5 * d.length_squared());
        Ok(Ray { origin: p, direction })
    }
}

impl Step {
    #[inline(always)]
    fn meet(&self, p: DVec3, d: DVec3) -> Result<Hit, Failure> {
        if self.is_far { self.shape.intersect(p, d, self.side) } else { self.shape.intersect_near(p, d, self.side) }
    }

    /// Checks the clear aperture, the obstruction and, at the stop, the diaphragm. Points on a rim pass.
    #[inline(always)]
    fn let_through(&self, hit: &Hit, diaphragm: &Diaphragm) -> Result<(), Failure> {
        let (x, y) = (hit.point.x, hit.point.y);
        let squared = x * x + y * y;
        // Written so that NaN, too, is outside.
        if !(squared <= self.clear_squared) {
            return Err(Failure::OutsideAperture);
        }
        if squared < self.obstruction_squared {
            return Err(Failure::Obstructed);
        }
        if self.is_stop && !diaphragm.is_open(x, y) {
            return Err(Failure::BladeStop);
        }
        Ok(())
    }
}

/// True if a ray from `from` may start many radii of `to` away from its vertex.
fn is_far(from: &Surface, to: &Surface, thickness_mm: f64) -> bool {
    let sag = |s: &Surface| s.shape.sag_mm(s.semi_diameter_mm).map_or(s.semi_diameter_mm, f64::abs);
    let along = thickness_mm.abs() + sag(from) + sag(to);
    let across = from.semi_diameter_mm + to.semi_diameter_mm;
    let radii = along.hypot(across) * to.shape.curvature.abs() * (1.0 + to.shape.conic.abs());
    // Written so that NaN, too, is far.
    !(radii <= FAR_RADII)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens::parse;
    use crate::glass::Catalogue;
    use crate::system::SystemSettings;

    /// A hemisphere of glass with an obstruction, its flat rear side the stop, five blades.
    fn tracer() -> Tracer {
        let text = "#radius thickness glass diameter conic isstop obstruction
                    10 10 1.5 19.9 -0.0 0 2\n 0 5 air 10 0 1 0\n 2 2 1.8 4.0 -4 0 0";
        let settings = SystemSettings { f_number: Some(4.0), blades: 5, ..SystemSettings::default() };
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
        let tracer = System::new(&parse(text, "test", Catalogue::shipped()).unwrap(), &SystemSettings::default());
        let tracer = tracer.unwrap().at_wavelength(550.0);
        let at = |x: f64| tracer.from_scene(Ray { origin: DVec3::new(x, 4.0, -1.0), direction: DVec3::Z });
        assert!(at(3.0).is_ok());
        assert_eq!(at(3.0f64.next_up()).unwrap_err().reason, Failure::OutsideAperture);
    }

    #[test]
    fn a_ray_into_the_thinner_medium_can_turn_back() {
        let text = "0 5 1.5 100 0 1\n 0 5 air 100 0 0";
        let tracer = System::new(&parse(text, "test", Catalogue::shipped()).unwrap(), &SystemSettings::default());
        let tracer = tracer.unwrap().with_indices(550.0, &[1.0, 0.7]);
        let ray = Ray { origin: DVec3::new(0.0, 0.0, -1.0), direction: DVec3::new(0.9, 0.0, 0.5).normalize() };
        let expected = Lost { surface: 1, reason: Failure::TotalInternalReflection };
        assert_eq!(tracer.from_scene(ray).unwrap_err(), expected);
    }
}
