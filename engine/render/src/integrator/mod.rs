//! From a camera ray to the radiance along it.

pub mod bidirectional;
pub mod path;

use crate::accel::Accel;
use crate::lights::{Lights, emission::Emission};
use crate::scene::Scene;
use crate::shading::{albedo::AlbedoTable, principled::PrincipledTables};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock};
use std::time::Instant;

/// How light is looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// [`path`]: from the camera.
    #[default]
    Path,
    /// [`bidirectional`]: from the camera and from the lights.
    Bidirectional,
}

impl Integrator {
    /// What it is called in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Bidirectional => "bdpt",
        }
    }
}

/// A scene with everything that is worked out once before light is followed through it. Cameras and settings
/// change without it.
pub struct Stage {
    /// What there is.
    pub scene: Scene,
    /// Its trees.
    pub accel: Accel,
    /// Its emitters.
    pub lights: Lights,
    /// What leaves them.
    pub emission: Emission,
    /// By material.
    pub tables: Vec<Arc<PrincipledTables>>,
    /// Wall time that it took, s.
    pub build_seconds: f64,
}

impl Stage {
    /// Builds trees and tables, in parallel on the current rayon pool.
    pub fn new(scene: Scene) -> Self {
        Self::after(None, scene)
    }

    /// The same; what is left of the stage of another frame makes it quicker.
    pub fn after(previous: Option<&Self>, scene: Scene) -> Self {
        let start = Instant::now();
        let accel = match previous {
            Some(previous) => Accel::new_after(&previous.accel, &scene),
            None => Accel::new(&scene),
        };
        let lights = Lights::new(&scene);
        let emission = Emission::new(&scene, &lights, accel.bounds());
        // The same for every scene.
        static REFLECTION: LazyLock<Arc<AlbedoTable>> = LazyLock::new(|| Arc::new(AlbedoTable::reflection()));
        let reflection = REFLECTION.clone();
        // One set of tables for each that differs, made in parallel.
        let mut representative: HashMap<_, usize> = HashMap::new();
        for (i, m) in scene.materials.iter().enumerate() {
            representative.entry(PrincipledTables::key(m)).or_insert(i);
        }
        let known: HashMap<_, _> = representative
            .into_par_iter()
            .map(|(key, i)| (key, Arc::new(PrincipledTables::new(&scene.materials[i], reflection.clone()))))
            .collect();
        let tables = scene.materials.iter().map(|m| known[&PrincipledTables::key(m)].clone()).collect();
        let build_seconds = start.elapsed().as_secs_f64();
        Self { scene, accel, lights, emission, tables, build_seconds }
    }
}
