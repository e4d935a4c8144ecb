//! Time of a whole sample, by camera: `cargo bench -p petzval-benches --bench path`.

mod stage;

use criterion::{Criterion, criterion_group, criterion_main};
use petzval_render::camera::Model;
use petzval_render::film::Film;
use petzval_render::integrator::path::{Approximations, KindLimits, Limits};
use petzval_render::pipeline::{Pipeline, RenderContext, render_tile};
use petzval_render::sampler::{
    pattern::Pattern,
    raster::Raster,
    warp::{Filter, PixelFilter},
};
use std::hint::black_box;

const SIZE: [u32; 2] = [480, 270];
const SAMPLES: u32 = 4;

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("path sample");
    group.sample_size(20);
    let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(Filter::Box));
    let limits = Limits {
        max_bounces: 8,
        kinds: KindLimits::default(),
        clamp_direct: f32::INFINITY,
        clamp_indirect: f32::INFINITY,
        approximations: Approximations::default(),
        hide_sky: false,
        film_glass: None,
        openness: 0.4,
        roulette: 4.0,
    };
    for (size, bodies) in [("small", stage::SMALL), ("large", stage::LARGE)] {
        let stage = stage::stage(bodies);
        for (name, model, wavelength_nm) in [
            ("pinhole", Model::Pinhole, None),
            ("thin", Model::Thin, None),
            ("exact, one wavelength", Model::Lens, Some(587.5618)),
            ("exact, spectrum", Model::Lens, None),
        ] {
            let cameras = [stage::camera(model, wavelength_nm, SIZE)];
            let pipeline = Pipeline::Auto.with(&cameras[0]);
            let shot = RenderContext {
                stage: &stage,
                cameras: &cameras,
                clip: None,
                pipeline,
                light_paths: None,
                raster: &raster,
                limits,
                pattern: Pattern::independent(1),
                motion: None,
                exposure: None,
                parts: &Default::default(),
                aimed: None,
                bake: None,
            };
            let film = Film::new(SIZE[0], SIZE[1], pipeline != Pipeline::FilmFirst, false);
            // Tiles from all over the picture, near its centre first.
            let tiles: Vec<usize> = (0..film.tile_count()).step_by(7).collect();
            let pixels: u32 = tiles.iter().map(|&t| film.rect(t).width * film.rect(t).height).sum();
            group.throughput(criterion::Throughput::Elements(u64::from(pixels * SAMPLES)));
            group.bench_function(format!("{name}/{size}"), |b| {
                b.iter(|| {
                    for &tile in &tiles {
                        let mut light = film.patch(tile);
                        black_box(render_tile(&shot, film.rect(tile), [0, SAMPLES], &mut light, &|| false));
                    }
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
