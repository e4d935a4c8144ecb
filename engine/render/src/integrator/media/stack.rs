//! The media that a path is in: a short list, as objects with volumes may stand in one another.

use crate::accel::{Accel, Hit, Ray};
use crate::integrator::PreparedScene;
use crate::nodes::PathState;
use crate::nodes::volume::{Medium, medium};
use crate::scene::Scene;
use crate::scene::visibility::Rays;
use crate::scene::volume::Volume;
use crate::surface::SurfacePoint;
use arrayvec::ArrayVec;
use glam::Vec3A;

/// Media that a path may be in at once; further ones are not entered.
const MOST_MEDIA: usize = 8;

/// The medium with which a material fills an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct StackedMedium {
    /// Index of the instance.
    pub(crate) instance: u32,
    /// Index of the material.
    pub(crate) material: u32,
}

impl StackedMedium {
    /// The entry of the medium that fills all space.
    pub(crate) const WORLD: Self = Self { instance: u32::MAX, material: u32::MAX };

    pub(super) fn volume(self, scene: &Scene) -> Option<&Volume> {
        if self == Self::WORLD {
            return scene.world.graph.as_ref()?.volume.as_ref();
        }
        scene.materials[self.material as usize].volume()
    }

    pub(super) fn medium(self, scene: &Scene, position: Vec3A, direction: Vec3A, way: PathState) -> Medium {
        let own = (self != Self::WORLD).then_some(self.instance);
        self.volume(scene).map_or_else(Medium::default, |volume| medium(volume, scene, own, position, direction, way))
    }
}

/// The media that a path is in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stack(ArrayVec<StackedMedium, MOST_MEDIA>);

impl Stack {
    /// The media at the start of a path's ray, at a place of which nothing is known.
    pub(crate) fn around(stage: &PreparedScene, ray: &Ray) -> Self {
        let (media, position) = (&stage.media, ray.origin);
        let mut stack = Self(media.world.into_iter().collect());
        let is_in = |[low, high]: &[Vec3A; 2]| position.cmpge(*low).all() && position.cmple(*high).all();
        if media.objects.iter().any(|(_, bounds)| is_in(bounds)) {
            stack.enclose(&stage.scene, &stage.accel, ray);
        }
        stack
    }

    /// Adds the objects that are left, but not entered, on a straight way out.
    fn enclose(&mut self, scene: &Scene, accel: &Accel, ray: &Ray) {
        let ray = Ray::new(ray.origin, Vec3A::Z).at(ray.moment);
        let mut entered = Self::default();
        for (_, point) in crossings(scene, accel, &ray, Rays::ALL) {
            let entry = StackedMedium { instance: point.instance, material: point.material };
            if !point.backfacing {
                entered.enter(entry);
            } else if !entered.leave(entry) {
                self.enter(entry);
            }
        }
    }

    /// Crosses a surface, from the side that the point was hit on.
    pub(crate) fn cross(&mut self, scene: &Scene, point: &SurfacePoint) {
        if scene.materials[point.material as usize].volume().is_none() {
            return;
        }
        let entry = StackedMedium { instance: point.instance, material: point.material };
        if point.backfacing {
            self.leave(entry);
        } else {
            self.enter(entry);
        }
    }

    /// The media that dim a shadow ray which starts here: it would never hit the borders of objects that are hidden from shadow rays.
    pub(crate) fn shadowing(&self, scene: &Scene) -> Self {
        let shades = |entry: &StackedMedium| {
            *entry == StackedMedium::WORLD || scene.instances[entry.instance as usize].visible.any_of(Rays::SHADOW)
        };
        Self(self.0.iter().copied().filter(shades).collect())
    }

    /// Leaves all objects: a ray that hits nothing more is in none.
    pub(crate) fn leave_objects(&mut self) {
        self.0.retain(|entry| *entry == StackedMedium::WORLD);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn iter(&self) -> std::slice::Iter<'_, StackedMedium> {
        self.0.iter()
    }

    /// The object that was entered last.
    pub(crate) fn innermost(&self) -> Option<u32> {
        self.0.iter().rev().find(|entry| **entry != StackedMedium::WORLD).map(|entry| entry.instance)
    }

    fn enter(&mut self, entry: StackedMedium) {
        if !self.0.contains(&entry) {
            // One too many is not entered.
            let _ = self.0.try_push(entry);
        }
    }

    fn leave(&mut self, entry: StackedMedium) -> bool {
        let place = self.0.iter().position(|known| *known == entry);
        if let Some(place) = place {
            self.0.remove(place);
        }
        place.is_some()
    }
}

/// The borders of media that a ray hits, nearest first, with their distances.
pub(crate) fn crossings(scene: &Scene, accel: &Accel, ray: &Ray, kind: Rays) -> Vec<(f32, SurfacePoint)> {
    let mut found: Vec<(f32, SurfacePoint)> = Vec::new();
    let mut note = |hit: &Hit| {
        let point = SurfacePoint::new(scene, hit, ray.direction);
        if scene.materials[point.material as usize].volume().is_some() {
            found.push((hit.t, point));
        }
        0.0
    };
    accel.transmittance_of(ray, kind, &mut note);
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1.instance, a.1.triangle).cmp(&(b.1.instance, b.1.triangle))));
    found
}
