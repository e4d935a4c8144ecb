//! Light that a path's ray hits: of lamps, of the sky, and of the surface at its end.

use super::super::choice::LensStrategy;
use super::super::notes::AovSink;
use super::super::{Limits, PathResult};
use super::Path;
use crate::Rgb;
use crate::accel::Hit;
use crate::integrator::PreparedScene;
use crate::integrator::aimed::AimedLights;
use crate::lights::{LightHit, Line, Source};
use crate::nodes::{self, View};
use crate::scene::visibility::LightSets;
use crate::surface::SurfacePoint;
use glam::Vec3A;

/// The result and the notes of one path, to add light to.
pub(super) struct Found<'a, N> {
    /// The number of the path.
    pub(super) path: u32,
    pub(super) result: &'a mut PathResult,
    pub(super) notes: &'a mut N,
}

impl<N: AovSink> Found<'_, N> {
    /// Adds light of an emitter of that group.
    #[inline(always)]
    pub(super) fn add(&mut self, of: N::Of, light: Rgb) {
        if self.notes.is_light(of) {
            self.result.radiance += light;
        }
        self.notes.add(self.path, of, light);
    }
}

impl Path {
    /// The view along the path's ray at the hit at this distance.
    pub(super) fn view(&self, distance: f32) -> View {
        View::along(&self.ray, self.cone, distance, self.way).with_least_pdf(self.least_pdf)
    }

    /// True if light that the ray found counts: not where light linking excludes the object that the ray comes from
    /// from its emitter's receivers, nor where the emitter has blockers of its own, of which the ray knows nothing.
    #[inline(always)]
    pub(super) fn finds(&self, stage: &PreparedScene, sets: impl FnOnce() -> LightSets) -> bool {
        if !stage.lights.is_linked() || self.way.is_camera() {
            return true;
        }
        let sets = sets();
        let is_alone = self.chosen.receiver().is_none();
        stage.scene.instances[self.from as usize].links.takes_light_of(sets) && (is_alone || sets.blockers == 0)
    }

    /// The weight of light of a source that the camera sees at a point, beside rays that the source sends to the lens.
    #[inline(always)]
    pub(super) fn lens_weight(
        &self,
        stage: &PreparedScene,
        aimed: Option<&AimedLights>,
        at: Vec3A,
        source: impl FnOnce() -> Option<Source>,
    ) -> f32 {
        match (self.strategy, aimed) {
            (LensStrategy::Camera { density }, Some(aimed)) if self.way.is_camera() => {
                source().map_or(1.0, |source| aimed.weight(stage, source, &self.ray, at, density))
            }
            (LensStrategy::Aimed(target), _) => f32::from(u8::from(source() == Some(target))),
            _ => 1.0,
        }
    }

    /// Adds the light of lamps that the ray hits within `t_max` of its last scattering: from there a light sample
    /// would have been taken, whatever surfaces it passed since.
    #[inline(always)]
    pub(super) fn lamps_before<N: AovSink>(
        &self,
        stage: &PreparedScene,
        limits: &Limits,
        aimed: Option<&AimedLights>,
        t_max: f32,
        found: &mut Found<'_, N>,
    ) {
        if stage.scene.lamps.is_empty() {
            return;
        }
        let to = self.chosen.receiver();
        let PreparedScene { scene, lights, .. } = stage;
        let line = Line { from: self.start, towards: self.ray.direction, t_max };
        lights.lamps_along(scene, line, self.way, to, |LightHit { source, radiance, pdf, distance }| {
            if !self.finds(stage, || lights.sets(source)) {
                return;
            }
            let light = self.throughput * radiance * self.chosen.weight(pdf);
            let counts = self.lens_weight(stage, aimed, self.start + self.ray.direction * distance, || Some(source));
            let of = found.notes.met(found.path, self.way, false, || lights.group(scene, source));
            found.add(of, limits.clamp_met(light, u32::from(self.way.depth)) * counts);
            found.result.hit = true;
        });
    }

    /// Adds the light of the world and of suns; adds the part of a transparent film that is seen through glass.
    #[inline(always)]
    pub(super) fn sky<N: AovSink>(&self, stage: &PreparedScene, limits: &Limits, found: &mut Found<'_, N>) {
        let to = self.chosen.receiver();
        let is_hidden = limits.hide_sky && self.way.is_camera();
        if is_hidden && !found.notes.keeps_sky() || self.way.is_camera() && self.strategy.is_aimed() {
            return;
        }
        if self.way.is_camera() && !is_hidden {
            found.notes.finds_world(found.path, stage, self.ray.direction, self.way);
        }
        let is_film = limits.hide_sky && self.is_on_film;
        if is_film && !is_hidden {
            found.result.hole += self.throughput.element_sum() / 3.0;
        }
        let world = limits.approximations.fast_gi.last_ray(self.way).map_or(1.0, |last| last.factor);
        stage.lights.sky_along(
            &stage.scene,
            self.ray.direction,
            self.way,
            to,
            |LightHit { source, radiance, pdf, .. }| {
                if !self.finds(stage, || stage.lights.sets(source)) {
                    return;
                }
                let is_world = stage.lights.is_world(source);
                let is_left_out = is_hidden || is_world && is_film;
                if is_left_out && !(is_world && found.notes.keeps_sky()) {
                    return;
                }
                let counts = self.chosen.weight(pdf) * if is_world { world } else { 1.0 };
                let light = limits.clamp_met(self.throughput * radiance * counts, u32::from(self.way.depth));
                let group = || stage.lights.group(&stage.scene, source);
                let of = found.notes.met(found.path, self.way, is_world, group);
                if is_left_out {
                    // As in Cycles, light groups and passes have the sky all the same.
                    found.notes.add(found.path, of, light);
                } else {
                    found.add(of, light);
                }
            },
        );
    }

    /// Adds the part of a surface seen by the camera that is a hole (holdout); true if all of it is.
    #[cold]
    #[inline(never)]
    fn falls_into(
        &self,
        stage: &PreparedScene,
        hit: &Hit,
        point: &SurfacePoint,
        kept: f32,
        result: &mut PathResult,
    ) -> bool {
        let material = &stage.scene.materials[point.material as usize];
        let view = self.view(self.travelled + hit.t);
        let place = [hit.instance, hit.triangle];
        let hole = nodes::holdout(material, stage.around(), place, point.barycentric, &view) * kept;
        result.hole += hole * self.throughput.element_sum() / 3.0;
        hole >= 1.0
    }

    /// Adds the light of the surface that the ray hits; true if the path ends, in a hole.
    pub(super) fn emission<N: AovSink>(
        &self,
        stage: &PreparedScene,
        limits: &Limits,
        aimed: Option<&AimedLights>,
        (hit, point, kept): (&Hit, &SurfacePoint, f32),
        found: &mut Found<'_, N>,
    ) -> bool {
        let material = &stage.scene.materials[point.material as usize];
        if !material.emits_or_holds_out {
            return false;
        }
        if self.is_on_film && material.may_hold_out() && self.falls_into(stage, hit, point, kept, found.result) {
            return true;
        }
        if !material.emits() || !self.finds(stage, || stage.scene.instances[hit.instance as usize].links.sets) {
            return false;
        }
        let view = self.view(self.travelled + hit.t);
        let radiance = nodes::emission_at(material, stage.around(), point, &view) * kept;
        let cos = -point.geometric_normal.dot(self.ray.direction);
        let pdf = self.chosen.receiver().map_or(0.0, |to| {
            stage.lights.triangle_pdf(&stage.scene, to, (hit.instance, hit.triangle), self.travelled + hit.t, cos)
        });
        let light = self.throughput * radiance * self.chosen.weight(pdf);
        let group = || stage.scene.instances[hit.instance as usize].light_group;
        let counts =
            self.lens_weight(stage, aimed, point.position, || stage.lights.triangle_source(hit.instance, hit.triangle));
        let of = found.notes.met(found.path, self.way, false, group);
        found.add(of, limits.clamp_met(light, u32::from(self.way.depth)) * counts);
        false
    }
}
