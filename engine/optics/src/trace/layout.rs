//! Data of a lens for a tracer on another processor.

use glam::DVec3;

use super::gradient::{Gradients, GradientsBeside};
use super::step::Step;
use super::{Ray, Tracer, Travel};
use crate::lane::Real;

impl<R: Real> Tracer<R> {
    /// The surfaces in the order in which rays that go `travel` come to them. With [`Self::enter`], [`Self::leave`], the system's
    /// diaphragm and [`Tracer::gradients`] this is all that a tracer on another processor needs.
    pub fn steps(&self, travel: Travel) -> &[Step<R>] {
        &self.way(travel).steps
    }

    /// The point of `ray` nearest to the vertex of the first surface on the way, seen from there, in mm, and its direction: the input of
    /// the first of [`Self::steps`].
    pub fn enter(&self, travel: Travel, ray: Ray) -> (DVec3, DVec3) {
        (self.way(travel).nearest(ray), ray.direction)
    }

    /// The ray in lens space whose point and direction, the one seen from the vertex of the last surface on the way, in mm, are
    /// the result of the last of [`Self::steps`].
    pub fn leave(&self, travel: Travel, point: DVec3, direction: DVec3) -> Ray {
        self.way(travel).leave(point, direction)
    }
}

impl Tracer {
    /// The media beside a surface, by its place in [`Self::steps`], where one is a gradient. The indices of the step's action
    /// then do not count.
    pub fn gradients(&self, travel: Travel, step: usize) -> Option<GradientsBeside> {
        self.way(travel).gradients(step).map(Gradients::numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens::parse;
    use crate::glass::Catalogue;
    use crate::system::{LensSettings, System};
    use crate::trace::Action;
    use crate::vector::Vector;

    /// One surface after the other, by hand.
    fn by_hand(tracer: &Tracer, travel: Travel, ray: Ray) -> Option<Ray> {
        let (p, d) = tracer.enter(travel, ray);
        let (mut p, mut d) = (Vector::<f64>::from_f64(p), Vector::<f64>::from_f64(d));
        for step in tracer.steps(travel) {
            p.z += step.to_here;
            let at = step.shape.intersect(p, d, step.side).ok()?;
            if let Action::Refract(interface) = step.action {
                d = Some(interface.refract(d, &at, step.side)).filter(|(_, passes)| *passes)?.0;
            }
            p = at.point;
        }
        Some(tracer.leave(travel, p.of(0), d.of(0)))
    }

    #[test]
    fn the_steps_are_the_way_of_a_ray() {
        let text = "#radius thickness glass diameter conic isstop
                    50 6 1.6/50 20 -0.5 1\n -70 3 1.7/30 20 0 0\n 90 40 air 20 0 0";
        let prescription = parse(text, "test", Catalogue::shipped()).unwrap();
        let system = System::new(&prescription, &LensSettings::default()).unwrap();
        let tracer = system.at_wavelength(550.0);
        let ray = |z: f64, to: f64| {
            let origin = DVec3::new(1.0, -2.0, z);
            Ray { origin, direction: DVec3::new(0.03, 0.05, to).normalize() }
        };
        let near = |a: Ray, b: Ray| (a.origin - b.origin).length() + (a.direction - b.direction).length() < 1e-13;
        let (inward, outward) = (ray(-20.0, 1.0), ray(49.0, -1.0));
        assert!(near(by_hand(&tracer, Travel::FromScene, inward).unwrap(), tracer.from_scene(inward).unwrap()));
        assert!(near(by_hand(&tracer, Travel::FromFilm, outward).unwrap(), tracer.from_film(outward).unwrap()));
        assert!(tracer.gradients(Travel::FromScene, 0).is_none());
    }
}
