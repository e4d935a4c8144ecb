//! Emitters that a ray hits, and the densities with which a light sample would have found them.

use super::receiver::LightSampleContext;
use super::{Lights, Source};
use crate::Rgb;
use crate::nodes::PathState;
use crate::scene::Scene;
use glam::Vec3A;

/// A stretch of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Origin of the line, render space.
    pub from: Vec3A,
    /// Direction of the line, unit.
    pub towards: Vec3A,
    /// Length of the line, Blender units.
    pub t_max: f32,
}

/// Light that a ray hits.
#[derive(Clone, Copy, Debug)]
pub struct LightHit {
    /// The source of the light.
    pub source: Source,
    /// Radiance along the ray.
    pub radiance: Rgb,
    /// The density per steradian with which a light sample would have found it.
    pub pdf: f32,
    /// Distance of the source, Blender units; infinite for suns and the world.
    pub distance: f32,
}

impl Lights {
    /// Passes `found` each lamp with extent that a ray hits; `to` is the receiver of a light sample that would have been taken. Lamps hide
    /// nothing behind them, as in Cycles.
    #[inline(always)]
    pub fn lamps_along(
        &self,
        scene: &Scene,
        line: Line,
        way: PathState,
        to: Option<&LightSampleContext>,
        mut found: impl FnMut(LightHit),
    ) {
        if !self.met.is_found_by(way) {
            return;
        }
        let Line { from, towards, t_max } = line;
        self.met.along(from, towards, t_max, |place| {
            let index = place as usize;
            let lamp = &self.lamps[self.local.lamps[index] as usize];
            if !lamp.is_found_by(way) {
                return;
            }
            if let Some((radiance, pdf, distance)) = lamp.hit(from, towards, t_max) {
                let radiance = radiance * lamp.shine(scene, from, towards, distance, way.light());
                let chance = to.map_or(0.0, |to| {
                    self.tree(to).map_or(0.0, |tree| tree.probability(to, index) * (1.0 - to.sky_chance))
                });
                found(LightHit { source: Source(index), radiance, pdf: pdf * chance, distance });
            }
        });
    }

    /// Passes `found` each emitter at infinity along a ray: the world, and suns with extent. `to` is the receiver of a light sample that
    /// would have been taken.
    pub fn sky_along(
        &self,
        scene: &Scene,
        towards: Vec3A,
        way: PathState,
        to: Option<&LightSampleContext>,
        mut found: impl FnMut(LightHit),
    ) {
        let chance = to.map_or(0.0, |to| to.sky_chance);
        self.sky.along(scene, &self.lamps, towards, way, to, |index, radiance, pdf| {
            found(LightHit { source: self.sky_source(index), radiance, pdf: pdf * chance, distance: f32::INFINITY });
        });
    }
}
