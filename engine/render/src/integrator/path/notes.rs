//! Notes on a path beside its light as a whole: the light of light groups, and parts ([`super::parts`]).
//!
//! A kind rather than a value: where nothing of it is asked for, nothing is left in the code that follows paths.

use super::by_part::{ByPart, LightOrigin};
use super::parts::Parts;
use crate::Rgb;
use crate::integrator::PreparedScene;
use crate::nodes::{PathState, View};
use crate::shading::{LobeDecomposition, LobeShares};
use crate::surface::SurfacePoint;
use glam::Vec3A;

/// Notes on the light that paths found, beside its sum.
pub trait AovSink {
    /// The origin of light, as far as it is known.
    type Of: Copy;

    /// Light that a path's ray hits: of the sky, or of anything else; `number` is its emitter's group, 0 is none.
    fn met(&self, path: u32, way: PathState, is_sky: bool, number: impl FnOnce() -> u16) -> Self::Of;

    /// Light that a path's surface scatters, with the shares of its lobes.
    fn sampled(
        &self,
        path: u32,
        way: PathState,
        shares: impl FnOnce() -> LobeShares,
        number: impl FnOnce() -> u16,
    ) -> Self::Of;

    /// Light that a volume scatters along a path.
    fn sampled_in_volume(&self, path: u32, way: PathState, number: impl FnOnce() -> u16) -> Self::Of;

    /// Light that counts for the picture and in no group or part.
    fn outside_of_passes(&self) -> Self::Of;

    /// Length of the ambient occlusion ray that a path's surface sends, Blender units, and the origin of its result; `None`: it sends
    /// none.
    fn occlusion(&self, way: PathState) -> Option<(f32, Self::Of)>;

    /// True if it counts for the picture.
    fn is_light(&self, of: Self::Of) -> bool;

    /// Forgets the notes on all paths.
    fn clear(&mut self);

    /// Adds a path, whose number is the count of those before it.
    fn start(&mut self);

    /// Adds light that a path found.
    fn add(&mut self, path: u32, of: Self::Of, light: Rgb);

    /// The first surface that a path did not pass.
    fn finds(&mut self, path: u32, stage: &PreparedScene, point: &SurfacePoint, view: &View);

    /// The world at the end of a camera ray that no surface stopped.
    fn finds_world(&mut self, path: u32, stage: &PreparedScene, direction: Vec3A, way: PathState);

    /// A surface that is to scatter a path, with the path's throughput up to it and its distance from the ray's origin.
    fn looks_at(&mut self, path: u32, way: PathState, throughput: Rgb, bsdf: &impl LobeDecomposition, distance: f32);

    /// A surface that a path comes to and may be scattered by.
    fn evaluates(&mut self, path: u32, way: PathState, bsdf: &impl LobeDecomposition);

    /// True if something is noted of surfaces that scatter nothing.
    fn looks(&self) -> bool;

    /// True if the sky is noted behind a transparent film, too, where it is no part of the picture.
    fn keeps_sky(&self) -> bool;

    /// A path was scattered by a surface, with the shares of its lobes.
    fn turned(&mut self, path: u32, way: PathState, shares: impl FnOnce() -> LobeShares);

    /// A path was scattered in a volume.
    fn turned_in_volume(&mut self, path: u32, way: PathState);

    /// The light that a path found: group by group, then part by part.
    fn found(&self, path: usize) -> &[Rgb];
}

/// A sink that keeps no notes, for renders without light groups and parts.
#[derive(Default)]
pub struct NoAovs;

impl AovSink for NoAovs {
    type Of = ();

    #[inline(always)]
    fn met(&self, _: u32, _: PathState, _: bool, _: impl FnOnce() -> u16) {}

    #[inline(always)]
    fn sampled(&self, _: u32, _: PathState, _: impl FnOnce() -> LobeShares, _: impl FnOnce() -> u16) {}

    #[inline(always)]
    fn sampled_in_volume(&self, _: u32, _: PathState, _: impl FnOnce() -> u16) {}

    #[inline(always)]
    fn outside_of_passes(&self) {}

    #[inline(always)]
    fn occlusion(&self, _: PathState) -> Option<(f32, ())> {
        None
    }

    #[inline(always)]
    fn is_light(&self, (): ()) -> bool {
        true
    }

    #[inline(always)]
    fn clear(&mut self) {}

    #[inline(always)]
    fn start(&mut self) {}

    #[inline(always)]
    fn add(&mut self, _: u32, (): (), _: Rgb) {}

    #[inline(always)]
    fn finds(&mut self, _: u32, _: &PreparedScene, _: &SurfacePoint, _: &View) {}

    #[inline(always)]
    fn finds_world(&mut self, _: u32, _: &PreparedScene, _: Vec3A, _: PathState) {}

    #[inline(always)]
    fn looks_at(&mut self, _: u32, _: PathState, _: Rgb, _: &impl LobeDecomposition, _: f32) {}

    #[inline(always)]
    fn evaluates(&mut self, _: u32, _: PathState, _: &impl LobeDecomposition) {}

    #[inline(always)]
    fn looks(&self) -> bool {
        false
    }

    #[inline(always)]
    fn keeps_sky(&self) -> bool {
        false
    }

    #[inline(always)]
    fn turned(&mut self, _: u32, _: PathState, _: impl FnOnce() -> LobeShares) {}

    #[inline(always)]
    fn turned_in_volume(&mut self, _: u32, _: PathState) {}

    #[inline(always)]
    fn found(&self, _: usize) -> &[Rgb] {
        &[]
    }
}

/// Notes the light of groups number 1 and on, and parts.
pub struct AovBuffers {
    groups: u16,
    parts: ByPart,
    /// Sums of light, path by path.
    sums: Vec<Rgb>,
}

impl AovBuffers {
    /// Notes of that many groups, and of parts.
    pub fn new(groups: u16, parts: Parts) -> Self {
        Self { groups, parts: ByPart::new(parts), sums: Vec::new() }
    }

    fn count(&self) -> usize {
        usize::from(self.groups) + self.parts.count()
    }

    fn group(&self, number: impl FnOnce() -> u16) -> u16 {
        let number = if self.groups == 0 { 0 } else { number() };
        if number <= self.groups { number } else { 0 }
    }
}

/// The sums of a path's parts.
fn of_parts(sums: &mut [Rgb], path: usize, groups: usize, count: usize) -> &mut [Rgb] {
    &mut sums[path * count + groups..(path + 1) * count]
}

impl AovSink for AovBuffers {
    type Of = (u16, LightOrigin);

    fn met(&self, path: u32, way: PathState, is_sky: bool, number: impl FnOnce() -> u16) -> Self::Of {
        (self.group(number), self.parts.met(path, way, is_sky))
    }

    fn sampled(
        &self,
        path: u32,
        way: PathState,
        shares: impl FnOnce() -> LobeShares,
        number: impl FnOnce() -> u16,
    ) -> Self::Of {
        (self.group(number), self.parts.sampled(path, way, shares))
    }

    fn sampled_in_volume(&self, path: u32, way: PathState, number: impl FnOnce() -> u16) -> Self::Of {
        (self.group(number), self.parts.sampled_in_volume(path, way))
    }

    fn outside_of_passes(&self) -> Self::Of {
        (0, LightOrigin::nowhere())
    }

    fn occlusion(&self, way: PathState) -> Option<(f32, Self::Of)> {
        Some((self.parts.occlusion_distance(way)?, (0, LightOrigin::occlusion())))
    }

    fn is_light(&self, (_, belongs): Self::Of) -> bool {
        belongs.is_light()
    }

    fn clear(&mut self) {
        self.sums.clear();
        self.parts.clear();
    }

    fn start(&mut self) {
        let (from, groups) = (self.sums.len(), usize::from(self.groups));
        self.sums.resize(from + self.count(), Rgb::ZERO);
        self.parts.start(&mut self.sums[from + groups..]);
    }

    fn add(&mut self, path: u32, (group, belongs): Self::Of, light: Rgb) {
        let (count, groups) = (self.count(), usize::from(self.groups));
        if group != 0 {
            self.sums[path as usize * count + usize::from(group) - 1] += light;
        }
        self.parts.add(of_parts(&mut self.sums, path as usize, groups, count), path, belongs, light);
    }

    fn finds(&mut self, path: u32, stage: &PreparedScene, point: &SurfacePoint, view: &View) {
        let (count, groups) = (self.count(), usize::from(self.groups));
        self.parts.finds(of_parts(&mut self.sums, path as usize, groups, count), path, stage, point, view);
    }

    fn finds_world(&mut self, path: u32, stage: &PreparedScene, direction: Vec3A, way: PathState) {
        let (count, groups) = (self.count(), usize::from(self.groups));
        self.parts.finds_world(of_parts(&mut self.sums, path as usize, groups, count), stage, direction, way);
    }

    fn looks_at(&mut self, path: u32, way: PathState, throughput: Rgb, bsdf: &impl LobeDecomposition, distance: f32) {
        let (count, groups) = (self.count(), usize::from(self.groups));
        let sums = of_parts(&mut self.sums, path as usize, groups, count);
        self.parts.looks_at(sums, path, way, throughput, bsdf, distance);
    }

    fn evaluates(&mut self, path: u32, way: PathState, bsdf: &impl LobeDecomposition) {
        let (count, groups) = (self.count(), usize::from(self.groups));
        self.parts.evaluates(of_parts(&mut self.sums, path as usize, groups, count), way, bsdf);
    }

    fn looks(&self) -> bool {
        self.parts.looks()
    }

    fn keeps_sky(&self) -> bool {
        self.parts.keeps_sky()
    }

    fn turned(&mut self, path: u32, way: PathState, shares: impl FnOnce() -> LobeShares) {
        self.parts.turned(path, way, shares);
    }

    fn turned_in_volume(&mut self, path: u32, way: PathState) {
        self.parts.turned_in_volume(path, way);
    }

    fn found(&self, path: usize) -> &[Rgb] {
        let count = self.count();
        &self.sums[path * count..][..count]
    }
}
