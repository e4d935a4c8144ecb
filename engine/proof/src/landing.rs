//! Landing points of rays: an enclosure of the exact hit on the last surface of a ray, and of the direction behind that surface.

use glam::DVec3;
use petzval_optics::system::System;
use petzval_optics::trace::{Action, Ray, Step, Tracer, Travel};

use crate::passage::{Beam, Fate, Indices, pass};
use crate::taylor::{Bounds, Taylor};

/// An enclosure of one ray behind the lens.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Bounds of the hit on the last surface on the way, seen from its vertex, mm.
    pub point_mm: [Bounds; 3],
    /// Bounds of the unit direction behind it.
    pub direction: [Bounds; 3],
}

/// One ray in intervals: the fate of exactly this ray, in a lens of exactly these numbers.
pub struct LandingFinder {
    steps: Vec<Step>,
    indices: Vec<Option<Indices<1>>>,
    opening_mm: f64,
    tracer: Tracer,
    travel: Travel,
}

impl LandingFinder {
    /// For rays through `system` that go `travel`, with the indices of the media at `wavelength_nm` as f64 has them; `None` where the lens
    /// has something that proofs do not cover: gradients, poses, toroids, blades.
    pub fn new(system: &System, wavelength_nm: f64, travel: Travel) -> Option<Self> {
        let after: Vec<f64> =
            system.surfaces().iter().map(|surface| surface.element.behind().base_index(wavelength_nm)).collect();
        Self::with_indices(system, wavelength_nm, &after, travel)
    }

    /// [`Self::new`] with the index after each surface given, as [`System::with_indices`] takes it.
    pub fn with_indices(system: &System, wavelength_nm: f64, after: &[f64], travel: Travel) -> Option<Self> {
        let tracer = system.with_indices(wavelength_nm, after);
        let steps = tracer.steps(travel).to_vec();
        let is_covered = system.is_rotationally_symmetric() && !system.has_gradients();
        if !is_covered || system.diaphragm().blades() > 0 || system.diaphragm().is_masked() {
            return None;
        }
        let at = |i: usize| Taylor::constant(after.get(i).copied().unwrap_or(1.0));
        let index = |(i, step): (usize, &Step)| {
            let surface = if travel == Travel::FromScene { i } else { steps.len() - 1 - i };
            let before = if surface == 0 { Taylor::constant(1.0) } else { at(surface - 1) };
            let [from, to] = if travel == Travel::FromScene { [before, at(surface)] } else { [at(surface), before] };
            matches!(step.action, Action::Refract(_)).then(|| Indices::between(from, to))
        };
        let indices = steps.iter().enumerate().map(index).collect();
        Some(Self { indices, opening_mm: system.diaphragm().radius_mm(), steps, tracer, travel })
    }

    /// The fate of `ray`, whose direction is the exact one divided by its exact length; of a ray that passes, the landing point. Its origin may
    /// be anywhere.
    pub fn landing(&self, ray: Ray) -> (Fate, Option<Landing>) {
        let start_z = if self.travel == Travel::FromScene { 0.0 } else { self.last_z() };
        let exact = |v: DVec3| [v.x, v.y, v.z].map(Taylor::<1>::constant);
        let mut from = exact(ray.origin);
        from[2] = from[2].plus(-start_z);
        let along = exact(ray.direction);
        let squared = along[0].squared() + along[1].squared() + along[2].squared();
        let inverse = squared.sqrt().reciprocal();
        let direction = along.map(|x| x * inverse);
        // Carried to the point nearest the first vertex, as the tracer does.
        let carried = -(from[0] * direction[0] + from[1] * direction[1] + from[2] * direction[2]);
        let point = [0, 1, 2].map(|axis| from[axis] + direction[axis] * carried);
        let (fate, beam) = pass(&self.steps, &self.indices, self.opening_mm, Beam { point, direction });
        let landing =
            Landing { point_mm: beam.point.map(|x| x.bounds()), direction: beam.direction.map(|x| x.bounds()) };
        (fate, (fate == Fate::Passes).then_some(landing))
    }

    fn last_z(&self) -> f64 {
        self.tracer.leave(Travel::FromScene, DVec3::ZERO, DVec3::Z).origin.z
    }
}
