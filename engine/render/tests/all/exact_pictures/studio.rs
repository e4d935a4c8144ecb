//! A dark room with lamps, and the camera before it.

use crate::cameras::camera;
use glam::{DMat4, DVec3, Vec3};
use petzval_render::Rgb;
use petzval_render::camera::{CameraDescription, Model, Spectrum};
use petzval_render::integrator::PreparedScene;
use petzval_render::job::{Job, Settings};
use petzval_render::pipeline::Pipeline;
use petzval_render::sampler::warp::Filter;
use petzval_render::scene::material::Material;
use petzval_render::scene::{SceneBuilder, mesh::MeshDescription, world::World};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Yellow helium line, nm.
pub(crate) const D_LINE_NM: f64 = 587.5618;

/// A lens of the cabinet at the origin, looking along -z, wide open and focused at infinity, before a film of 36 x 24
/// mm, in the light of the d line.
pub(crate) fn lens(name: &str) -> CameraDescription {
    CameraDescription {
        model: Model::Lens,
        lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../lenses/{name}.lens")),
        wavelength_nm: Some(D_LINE_NM),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.film.width_mm = 36.0;
        c.film.height_mm = 24.0;
    })
}

/// The camera in three wavelengths, one for each channel.
pub(crate) fn in_three(d: &CameraDescription) -> CameraDescription {
    CameraDescription { wavelength_nm: None, spectrum: Spectrum::Three, ..d.clone() }
}

/// A square that emits radiance one, upright before the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    /// Camera space, Blender units.
    pub(crate) at: DVec3,
    /// Half of its side, Blender units.
    pub(crate) half_side: f64,
}

/// Lamps in the dark.
pub(crate) fn lamps(list: &[Lamp]) -> Arc<PreparedScene> {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let square = MeshDescription {
        name: "lamp".into(),
        positions: corners.map(Vec3::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    };
    let glow = Material::diffuse("glow", Rgb::ZERO, Rgb::ONE);
    let mut builder = SceneBuilder::new();
    let mesh = builder.add_mesh(square).unwrap();
    let material = builder.add_material(glow);
    for lamp in list {
        let place = DMat4::from_translation(lamp.at) * DMat4::from_scale(DVec3::splat(lamp.half_side));
        builder.add_instance("lamp", mesh, place, &[material], true, true).unwrap();
    }
    Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)))
}

/// A world of radiance one and nothing else.
pub(crate) fn white_world() -> Arc<PreparedScene> {
    let mut builder = SceneBuilder::new();
    builder.set_world(World { color: Rgb::ONE, ..Default::default() }).unwrap();
    Arc::new(PreparedScene::new(builder.build(DVec3::ZERO)))
}

/// The settings of a picture. Pixels are squares without overlap, so that no filter is between them and the truth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposure {
    pub(crate) pixels: [u32; 2],
    pub(crate) pipeline: Pipeline,
    pub(crate) samples: u32,
}

/// One photograph: colours, rows from below.
pub(crate) fn shoot(stage: &Arc<PreparedScene>, d: &CameraDescription, e: &Exposure, seed: u32) -> Vec<[f64; 3]> {
    let [width, height] = e.pixels;
    let settings = Settings {
        width,
        height,
        samples: e.samples,
        seed,
        threads: 2,
        max_bounces: 0,
        filter: Filter::Box,
        pipeline: e.pipeline,
        ..Settings::default()
    };
    let job = Job::start(stage.clone(), camera(d, width, height), settings).unwrap();
    assert!(job.wait(Duration::from_secs(300)));
    assert_eq!(job.pipeline(), e.pipeline);
    let done = job.statistics();
    assert!(done.failure.is_none() && done.counts.non_finite == 0, "{done:?}");
    job.film().picture().iter().map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}
