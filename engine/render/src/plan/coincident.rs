//! Faces that lie on each other where a camera sees them: which of them is seen is decided by rounding, and programs whose shadow rays
//! meet the other one draw them dark.

use crate::accel::{Hit, Ray};
use crate::integrator::PreparedScene;
use crate::scene::visibility::Rays;
use crate::surface::SurfacePoint;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The smallest part of the picture that is worth a line.
const LEAST_PART: f64 = 0.002;
/// Faces whose normals have a cosine below this cross each other.
const PARALLEL: f32 = 0.9999;
/// The least cosine between a ray and a normal that the length of the search allows for.
const GRAZING: f32 = 0.01;

/// Two objects, or one, with faces that lie on each other.
#[derive(Clone, Debug, PartialEq)]
pub struct CoincidentFaces {
    /// Names of the objects, in alphabetical order; one name twice where the faces are of one object.
    pub objects: [String; 2],
    /// The part of the picture that shows such faces.
    pub part: f64,
}

impl CoincidentFaces {
    /// The coincident faces that rays of places all over the picture hit first, those of the largest part of the picture first.
    pub(super) fn along(stage: &PreparedScene, rays: &[Option<Ray>]) -> Vec<Self> {
        let found: Vec<[u32; 2]> = rays.par_iter().flatten().filter_map(|ray| instances(stage, ray)).collect();
        let mut counts = BTreeMap::<[&str; 2], usize>::new();
        for pair in found {
            let mut names = pair.map(|instance| stage.scene.instances[instance as usize].object_name.as_str());
            names.sort_unstable();
            *counts.entry(names).or_default() += 1;
        }
        let part = |count: usize| count as f64 / rays.len() as f64;
        let worth = counts.into_iter().filter(|&(_, count)| part(count) >= LEAST_PART);
        let mut all: Vec<Self> =
            worth.map(|(names, count)| Self { objects: names.map(str::to_owned), part: part(count) }).collect();
        all.sort_by(|a, b| b.part.total_cmp(&a.part));
        all
    }

    /// The line for a user.
    pub fn text(&self) -> String {
        let [one, other] = &self.objects;
        let faces = if one == other { "faces of it".to_owned() } else { format!("faces of it and of '{other}'") };
        let percent = 100.0 * self.part;
        format!(
            "object '{one}': {faces} lie on each other in {percent:.1} % of the picture, where Cycles draws parts of them dark; delete \
             one of each two"
        )
    }
}

/// True if a hit on a triangle is not at its edge, where its neighbour may be hit, too.
fn is_within(hit: &Hit) -> bool {
    const EDGE: f32 = 1e-3;
    hit.u.min(hit.v).min(1.0 - hit.u - hit.v) > EDGE
}

/// The instances of two coincident faces at a ray's first hit; `None` where there is one face alone.
fn instances(stage: &PreparedScene, ray: &Ray) -> Option<[u32; 2]> {
    let first = stage.accel.closest(ray, Rays::CAMERA).filter(is_within)?;
    let surface = |hit: &Hit| {
        let instance = &stage.scene.instances[hit.instance as usize];
        let is_flat = stage.scene.meshes[instance.mesh as usize].is_of_triangles();
        is_flat.then(|| SurfacePoint::new(&stage.scene, hit, ray.direction))
    };
    let here = surface(&first)?;
    let cosine = here.geometric_normal.dot(ray.direction).abs().max(GRAZING);
    let reach = here.position_error / cosine;
    let around =
        Ray { t_max: 2.0 * reach, ..Ray::new(here.position - ray.direction * reach, ray.direction).at(ray.moment) };
    let mut found = None;
    let mut is_there = |hit: &Hit| {
        let is_other = (hit.instance, hit.triangle) != (first.instance, first.triangle);
        if is_other
            && is_within(hit)
            && surface(hit).is_some_and(|s| s.geometric_normal.dot(here.geometric_normal).abs() > PARALLEL)
        {
            found = Some([first.instance, hit.instance]);
        }
        // Goes on until one is found.
        f32::from(u8::from(found.is_some()))
    };
    stage.accel.transmittance_of(&around, Rays::CAMERA, &mut is_there);
    found
}
