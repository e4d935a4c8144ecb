//! Rays that leave a source in a direction that is chosen elsewhere: towards the lens.
//!
//! The place is chosen first: on a triangle or a flat lamp by area; of a ball on the disk through its centre that faces the lens, which
//! holds nearly all of its rays to there. The density of the ray, per unit of etendue, is that of the place, per area at right angles to
//! the ray, times that of the direction per steradian.

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
    pub fn seen_groups(&self) -> &[SourceGroup] {
        self.seen_groups.get_or_init(|| self.find_seen_groups())
    }

    fn find_seen_groups(&self) -> Vec<SourceGroup> {
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

    /// Makes the areas of a group's sources those that are seen from a place in the direction `towards`; sources that are not seen have
    /// none.
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

    /// The place at which a ray leaves a source towards a lens at `lens_at`, by two uniform numbers; `None` of a source without extent or
    /// at infinity.
    pub fn aim_place(&self, scene: &Scene, source: Source, u: [f32; 2], lens_at: Vec3A, moment: u16) -> Option<Vec3A> {
        if let Some(triangle) = self.triangle_at(scene, source, moment) {
            return Some(triangle.point(warp::sample_triangle(u)));
        }
        match self.extended(source)? {
            (lamp, LampExtent::Ball { radius }) => {
                let axis = (lens_at - lamp.center()).try_normalize()?;
                Some(lamp.center() + on_disk(axis, radius, u))
            }
            (lamp, LampExtent::Flat { .. }) => Some(lamp.place(u)),
        }
    }

    /// The place at which a ray that comes through `at` along `d` would have left a source towards a lens at `lens_at`, and the density of
    /// [`Self::aim_place`] per unit of area at right angles to the ray; `None` where it sends no such ray.
    pub fn aimed_hit(
        &self,
        scene: &Scene,
        source: Source,
        (at, d): (Vec3A, Vec3A),
        lens_at: Vec3A,
        moment: u16,
    ) -> Option<(Vec3A, f32)> {
        let (place, per_area) = if let Some(triangle) = self.triangle_at(scene, source, moment) {
            (at, 1.0 / (triangle.area * triangle.normal().dot(d).abs()))
        } else {
            match self.extended(source)? {
                (lamp, LampExtent::Ball { radius }) => {
                    let axis = (lens_at - lamp.center()).try_normalize()?;
                    let cos = axis.dot(d);
                    let place = at + d * ((lamp.center() - at).dot(axis) / cos);
                    // A place that was chosen lies there but for rounding.
                    let is_inside = (place - lamp.center()).length() <= radius + lamp.rounding();
                    (place, if is_inside { 1.0 / (PI * radius * radius * cos) } else { 0.0 })
                }
                (lamp, LampExtent::Flat { area }) => (at, 1.0 / (area * lamp.axis().dot(d))),
            }
        };
        (per_area > 0.0 && per_area.is_finite()).then_some((place, per_area))
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
