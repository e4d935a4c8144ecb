//! Time of a ray in the BVH, and of building the BVH: `cargo bench -p petzval-benches --bench tree`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3A;
use petzval_render::accel::{Accel, Ray, offset_origin};
use petzval_render::sampler::warp::sample_sphere;
use petzval_render::scene::Scene;
use petzval_render::scene::visibility::Rays;
use petzval_render::surface::SurfacePoint;
use stage::Dice;
use std::hint::black_box;
use std::time::Duration;

mod stage;

/// Enough that the tree's parts come from memory as they do in a render.
const RAYS: usize = 1 << 17;

/// Camera rays from the pinhole through random places of the picture, in random order: 50 mm on 36 x 20.25 mm along +y.
fn primary() -> Vec<Ray> {
    let mut dice = Dice::new(1);
    let mut place = |width: f32| width * (dice.roll() - 0.5) / 50.0;
    (0..RAYS).map(|_| Ray::new(Vec3A::ZERO, Vec3A::new(place(36.0), 1.0, place(20.25)).normalize())).collect()
}

/// Rays from the hits of the camera rays, spread by the cosine.
fn bounce(scene: &Scene, accel: &Accel, primary: &[Ray]) -> Vec<Ray> {
    let mut dice = Dice::new(2);
    let from = |ray: &Ray| {
        let hit = accel.closest(ray, Rays::CAMERA)?;
        let point = SurfacePoint::new(scene, &hit, ray.direction);
        let n = point.geometric_normal;
        let direction = (n + sample_sphere([dice.roll(), dice.roll()])).normalize_or(n);
        Some(Ray::new(offset_origin(point.position, n, point.position_error), direction))
    };
    primary.iter().filter_map(from).collect()
}

fn rays(c: &mut Criterion) {
    let mut group = c.benchmark_group("tree");
    group.sample_size(20).measurement_time(Duration::from_secs(5));
    for (size, prefix) in [(stage::LARGE, ""), (stage::SMALL, "small/")] {
        let scene = stage::scene(size);
        let accel = Accel::new(&scene);
        let primary = primary();
        let bounce = bounce(&scene, &accel, &primary);
        for (rays, name) in [(&primary, "closest/primary"), (&bounce, "closest/bounce")] {
            group.throughput(Throughput::Elements(rays.len() as u64));
            group.bench_function(format!("{prefix}{name}"), |b| {
                b.iter(|| rays.iter().filter(|ray| accel.closest(black_box(ray), Rays::BOUNCE).is_some()).count());
            });
        }
        group.bench_function(format!("{prefix}shadow/bounce"), |b| {
            b.iter(|| bounce.iter().map(|ray| accel.transmittance(black_box(ray), |_| 1.0)).sum::<f32>());
        });
        group.throughput(Throughput::Elements(scene.triangle_count() as u64));
        group.bench_function(format!("{prefix}build"), |b| b.iter(|| Accel::new(black_box(&scene))));
        group.bench_function(format!("{prefix}refit"), |b| b.iter(|| Accel::new_after(black_box(&accel), &scene)));
    }
    group.finish();
}

criterion_group!(benches, rays);
criterion_main!(benches);
