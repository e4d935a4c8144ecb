//! Rays that leave a source in a direction that is chosen elsewhere: towards the lens.
//!
//! The direction is chosen for a place of the source: for the very point of a triangle or a flat lamp, for the centre of a ball, whose
//! rays of one direction fill a disk. The density of the ray, per unit of etendue, is that of the direction per steradian times a factor
//! of the source.

use super::lamp::LampExtent;
use super::lamp::shape::on_disk;
use super::triangle::LitTriangle;
use super::{Emitter, Lights, Source};
use crate::nodes::PathState;
use crate::sampler::warp;
use crate::scene::Scene;
use crate::scene::motion::MIDDLE;
use crate::scene::visibility::Rays;
use glam::Vec3A;
use std::collections::BTreeMap;
use std::f32::consts::PI;

/// The sources of one lamp or object which the camera sees.
#[derive(Clone, Debug)]
pub struct SourceGroup {
    /// The middle of the group, render space.
    pub center: Vec3A,
    /// Radius of a ball about the middle that holds the group, Blender units.
    pub radius: f32,
    /// Area of the group as it is seen from afar, Blender units squared: of a convex object a quarter of its surface.
    pub seen_area: f32,
    /// The sources, and the area of each, as it is seen once [`Lights::face`] is called.
    pub sources: Vec<(Source, f32)>,
}

/// The area of a lamp as it is seen from its front.
fn seen_area(extent: LampExtent) -> f32 {
    match extent {
        LampExtent::Ball { radius } => PI * radius * radius,
        LampExtent::Flat { area } => area,
    }
}

impl Lights {
    /// The sources within the scene that a ray from the camera can hit, by lamp and by object.
    pub fn seen_groups(&self) -> Vec<SourceGroup> {
        let mut groups = Vec::new();
        let mut objects: BTreeMap<u32, Vec<(usize, &LitTriangle)>> = BTreeMap::new();
        for (index, emitter) in self.local.iter().enumerate() {
            match emitter {
                Emitter::Lamp(lamp) => {
                    let lamp = &self.lamps[lamp as usize];
                    let Some(extent) = lamp.extent().filter(|_| lamp.is_found_by(PathState::CAMERA)) else { continue };
                    let bounds = lamp.bounds();
                    groups.push(SourceGroup {
                        center: lamp.center(),
                        radius: 0.5 * (bounds.max - bounds.min).length(),
                        seen_area: seen_area(extent),
                        sources: vec![(Source(index), 1.0)],
                    });
                }
                Emitter::Triangle(triangle) | Emitter::Moving(triangle, _) if triangle.is_seen_by_camera() => {
                    objects.entry(triangle.instance).or_default().push((index, triangle));
                }
                Emitter::Triangle(_) | Emitter::Moving(..) => {}
            }
        }
        groups.extend(objects.into_values().map(|triangles| {
            let bounds = triangles.iter().map(|(_, triangle)| triangle.bounds());
            let (low, high) = bounds
                .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), one| (low.min(one.min), high.max(one.max)));
            SourceGroup {
                center: 0.5 * (low + high),
                radius: 0.5 * (high - low).length(),
                seen_area: 0.25 * triangles.iter().map(|(_, triangle)| triangle.area).sum::<f32>(),
                sources: triangles.into_iter().map(|(index, triangle)| (Source(index), triangle.area)).collect(),
            }
        }));
        groups
    }

    /// Makes the areas of a group's sources those that are seen from a place in the direction `towards`; what is not seen has none.
    pub fn face(&self, scene: &Scene, group: &mut SourceGroup, towards: Vec3A) {
        for (source, area) in &mut group.sources {
            *area = if let Some(triangle) = self.triangle_at(scene, *source, MIDDLE) {
                let cos = triangle.normal().dot(towards);
                // Only the front of a closed surface is outside.
                triangle.area * if triangle.two_sided { cos.abs() } else { cos.max(0.0) }
            } else {
                match self.extended(*source) {
                    Some((lamp, LampExtent::Flat { area })) => area * lamp.axis().dot(towards).max(0.0),
                    Some((_, extent)) => seen_area(extent),
                    None => 0.0,
                }
            };
        }
    }

    /// The place of a source for which a direction is to be chosen, by two uniform numbers; `None` of a source without extent or at
    /// infinity.
    pub fn aim_place(&self, scene: &Scene, source: Source, u: [f32; 2], moment: u16) -> Option<Vec3A> {
        if let Some(triangle) = self.triangle_at(scene, source, moment) {
            return Some(triangle.point(warp::sample_triangle(u)));
        }
        self.extended(source).map(|(lamp, _)| lamp.place(u))
    }

    /// The origin of a ray that leaves a source along `d`, which was chosen for `place`, and the factor of its density; `u` are the
    /// numbers of [`Self::aim_place`].
    pub fn aimed_ray(
        &self,
        scene: &Scene,
        source: Source,
        (place, d): (Vec3A, Vec3A),
        u: [f32; 2],
        moment: u16,
    ) -> Option<(Vec3A, f32)> {
        let (_, factor) = self.aimed_hit(scene, source, (place, d), moment)?;
        let origin = match self.extended(source) {
            Some((_, LampExtent::Ball { radius })) => place + on_disk(d, radius, u),
            _ => place,
        };
        Some((origin, factor))
    }

    /// The place for which the direction `d` of a ray that left a source at `at` would have been chosen, and the factor of the ray's
    /// density; `None` where the source sends no such ray.
    pub fn aimed_hit(
        &self,
        scene: &Scene,
        source: Source,
        (at, d): (Vec3A, Vec3A),
        moment: u16,
    ) -> Option<(Vec3A, f32)> {
        let (place, per_etendue) = if let Some(triangle) = self.triangle_at(scene, source, moment) {
            (at, 1.0 / (triangle.area * triangle.normal().dot(d).abs()))
        } else {
            match self.extended(source)? {
                (lamp, LampExtent::Ball { radius }) => (lamp.center(), 1.0 / (PI * radius * radius)),
                (lamp, LampExtent::Flat { area }) => (at, 1.0 / (area * lamp.axis().dot(d).max(0.0))),
            }
        };
        per_etendue.is_finite().then_some((place, per_etendue))
    }

    /// A lamp with extent, if the source is one.
    fn extended(&self, source: Source) -> Option<(&super::lamp::PreparedLamp, LampExtent)> {
        self.lamp(source).and_then(|lamp| Some((lamp, lamp.extent()?)))
    }
}

impl Source {
    /// The number of the source: lamps and triangles first.
    pub fn index(self) -> usize {
        self.0
    }
}

impl LitTriangle {
    /// True if rays from the camera hit its object.
    fn is_seen_by_camera(&self) -> bool {
        self.reaches().any_of(Rays::CAMERA)
    }
}
