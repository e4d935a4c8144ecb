//! Integrators: the radiance along camera rays.

pub mod aimed;
pub mod bidirectional;
pub mod media;
mod mis;
pub mod path;
mod subsurface;

use crate::accel::Accel;
use crate::lights::{Lights, emission::Emission};
use crate::nodes;
use crate::scene::plain::Plain;
use crate::scene::{Scene, dicing};
use crate::shading::{energy, principled::PrincipledTables};
use media::Media;
use rayon::prelude::*;
use serde::Deserialize;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

/// A light transport algorithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Integrator {
    /// [`path`]: from the camera.
    #[default]
    Path,
    /// [`bidirectional`]: from the camera and from the lights.
    Bidirectional,
}

impl Integrator {
    /// Name of the integrator in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Bidirectional => "bdpt",
        }
    }
}

/// A scene with everything that is worked out once before light is followed through it. Cameras and settings
/// change without it.
pub struct PreparedScene {
    /// The scene in render space, displaced and with its moments of motion.
    pub scene: Scene,
    /// The BVHs over everything that rays can hit.
    pub accel: Accel,
    /// Every emitter of the scene, ready to be sampled.
    pub lights: Lights,
    /// Distributions from which light paths start.
    pub emission: Emission,
    /// The participating media of the objects and of the world.
    pub media: Media,
    /// Tables of the plain surfaces, by material.
    pub plain_tables: Vec<Option<Arc<PrincipledTables>>>,
    /// True if a material of the scene depends on the footprints of rays.
    pub needs_cones: bool,
    /// Warnings on parts of the scene that were left out.
    pub warnings: Vec<String>,
    /// Wall time that the preparation took, s.
    pub build_seconds: f64,
}

impl PreparedScene {
    /// The surroundings that shader graphs of surfaces may query.
    pub fn around(&self) -> nodes::SceneQueries<'_> {
        nodes::SceneQueries { scene: &self.scene, accel: Some(&self.accel) }
    }

    /// Builds trees and tables, in parallel on the current rayon pool.
    pub fn new(scene: Scene) -> Self {
        Self::after(None, scene)
    }

    /// Builds a stage like [`Self::new`]; parts of the stage of another frame that are still valid are reused.
    pub fn after(previous: Option<&Self>, scene: Scene) -> Self {
        Self::with(previous, scene, |scene| match previous {
            Some(previous) => Accel::new_after(&previous.accel, scene),
            None => Accel::new(scene),
        })
    }

    /// Builds a stage of a scene that is edited: unedited parts are taken from the stage before, at the price of slower
    /// rays.
    pub fn edited(previous: Option<&Self>, scene: Scene) -> Self {
        let before = previous.map(|previous| (&previous.accel, &previous.scene));
        Self::with(previous, scene, |scene| Accel::apart(before, scene))
    }

    fn with(previous: Option<&Self>, mut scene: Scene, trees: impl FnOnce(&Scene) -> Accel) -> Self {
        let start = Instant::now();
        nodes::world::bake(&mut scene, previous.map(|previous| &previous.scene));
        let mut warnings = dicing::dice(&mut scene);
        warnings.extend(nodes::displacement::displace(&mut scene));
        scene.set_in_motion();
        let accel = trees(&scene);
        let lights = Lights::after(previous.map(|previous| &previous.lights), &scene);
        let emission = Emission::new(&scene, &lights, accel.bounds());
        let media = Media::new(&scene, accel.bounds());
        let reflection = energy::reflection().clone();
        // One set of tables for each that differs, made in parallel.
        let before = previous.map_or_else(HashMap::new, |previous| {
            let tables = |(key, tables): (_, &Option<Arc<PrincipledTables>>)| Some((key?, tables.clone()?));
            keys(&previous.scene).zip(&previous.plain_tables).filter_map(tables).collect::<HashMap<_, _>>()
        });
        let plains = scene.materials.iter().filter_map(|material| material.graph.plain.as_ref());
        let representative: HashMap<_, &Plain> = plains.map(|plain| (PrincipledTables::key(plain), plain)).collect();
        let made = |plain: &Plain| Arc::new(PrincipledTables::new(plain, reflection.clone()));
        let known: HashMap<_, _> = representative
            .into_par_iter()
            .map(|(key, plain)| (key, before.get(&key).cloned().unwrap_or_else(|| made(plain))))
            .collect();
        let plain_tables = keys(&scene).map(|key| Some(known[&key?].clone())).collect();
        let build_seconds = start.elapsed().as_secs_f64();
        let needs_cones = scene.materials.iter().any(|material| material.graph.needs_footprint());
        Self { scene, accel, lights, emission, media, plain_tables, needs_cones, warnings, build_seconds }
    }
}

/// The keys of the tables of plain surfaces, by material; `None` for other materials.
fn keys(scene: &Scene) -> impl Iterator<Item = Option<(u32, u32, bool, bool)>> {
    scene.materials.iter().map(|material| material.graph.plain.as_ref().map(PrincipledTables::key))
}
