//! What a sample costs before its path begins: `cargo bench -p petzval-render --bench camera`.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{DMat4, DVec3, Vec2};
use petzval_render::camera::{Camera, CameraDescription, Model, Spectrum};
use petzval_render::sampler::{PathSampler, raster::Raster, warp::PixelFilter};
use std::hint::black_box;

const SIZE: [u32; 2] = [480, 270];

fn camera(model: Model, lens: &str, spectrum: Option<Spectrum>) -> Camera {
    let d = CameraDescription {
        object_name: "Camera".into(),
        model,
        matrix_world: DMat4::IDENTITY,
        pinhole_focal_length_mm: 50.0,
        pinhole_film_width_mm: 36.0,
        pinhole_shift: [0.0; 2],
        lens_path: format!("{}/../../lenses/{lens}.lens", env!("CARGO_MANIFEST_DIR")).into(),
        focal_length_mm: None,
        focal_scale: None,
        f_number: None,
        blades: 0,
        blade_rotation_rad: 0.0,
        blade_curvature: 0.0,
        aperture_mask: None,
        focus_distance: Some(3.0),
        focusing: Default::default(),
        focus_point_world: None,
        film_distance_mm: None,
        film_width_mm: 36.0,
        film_height_mm: 20.25,
        tilt_rad: 0.0,
        swing_rad: 0.0,
        shift_mm: [0.0; 2],
        scale_mm_per_unit: DVec3::splat(1000.0),
        wavelength_nm: if spectrum.is_none() { Some(587.5618) } else { None },
        spectrum: spectrum.unwrap_or_default(),
        exposure: None,
    };
    Camera::new(&d, SIZE[0], SIZE[1]).unwrap()
}

/// Pixel after pixel, as a tile is rendered.
fn samples(mut one: impl FnMut([u32; 2], PathSampler)) {
    for i in 0..32 * 32 {
        let pixel = [200 + i % 32, 100 + i / 32];
        one(pixel, PathSampler::new(pixel[0], pixel[1], 3, 0));
    }
}

fn bench(c: &mut Criterion) {
    let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(1.5));
    let mut group = c.benchmark_group("camera sample");
    group.throughput(criterion::Throughput::Elements(32 * 32));
    let mut film_first = |name: &str, camera: &Camera| {
        group.bench_function(name, |b| {
            b.iter(|| {
                samples(|[x, y], mut sampler| {
                    let [u0, u1, u2, u3] = sampler.next_4d();
                    let [u4, ..] = sampler.next_4d();
                    let place: Vec2 = raster.place(x, y, [u0, u1]);
                    black_box(camera.sample(place, [u2, u3], u4));
                });
            });
        });
    };
    film_first("pinhole", &camera(Model::Pinhole, "", None));
    for lens in ["wide-angle-smith-f3.4", "double-gauss-f1.35", "laikin-fisheye-170"] {
        film_first(&format!("{lens}/one wavelength"), &camera(Model::Lens, lens, None));
        film_first(&format!("{lens}/film first"), &camera(Model::Lens, lens, Some(Spectrum::Visible)));
    }
    for lens in ["wide-angle-smith-f3.4", "double-gauss-f1.35", "laikin-fisheye-170"] {
        let camera = camera(Model::Lens, lens, Some(Spectrum::Visible));
        let lens_ready = camera.traced_lens().unwrap();
        group.bench_function(format!("{lens}/hero"), |b| {
            b.iter(|| {
                samples(|pixel, mut sampler| {
                    let [u0, u1, u2, u3] = sampler.next_4d();
                    let [u4, u5, u6, _] = sampler.next_4d();
                    let place = raster.place(pixel[0], pixel[1], [u0, u1]);
                    black_box(lens_ready.lead_all(pixel, place, [u2, u3], u4, &raster, [u5, u6]));
                });
            });
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
