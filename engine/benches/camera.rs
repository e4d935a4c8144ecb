//! Time of a camera sample, up to where its path begins: `cargo bench -p petzval-benches --bench camera`.

use criterion::{Criterion, criterion_group, criterion_main};
use petzval_render::camera::lens::real_lens::packet::Request;
use petzval_render::camera::{Camera, CameraDescription, Model, Spectrum};
use petzval_render::sampler::{
    PathSampler,
    raster::Raster,
    warp::{Filter, PixelFilter},
};
use std::hint::black_box;

const SIZE: [u32; 2] = [480, 270];

fn camera(model: Model, lens: &str, spectrum: Option<Spectrum>) -> Camera {
    let d = CameraDescription {
        model,
        lens_path: format!("{}/../../lenses/{lens}.lens", env!("CARGO_MANIFEST_DIR")).into(),
        wavelength_nm: if spectrum.is_none() { Some(587.5618) } else { None },
        spectrum: spectrum.unwrap_or_default(),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.focus.distance = Some(3.0);
        c.film.width_mm = 36.0;
        c.film.height_mm = 20.25;
    });
    Camera::new(&d, SIZE[0], SIZE[1]).unwrap()
}

/// Pixel after pixel, as a tile is rendered, in as many stretches.
fn stretches(raster: &Raster, mut one: impl FnMut(&[Request])) {
    let mut requests = Vec::with_capacity(64);
    for i in 0..32 * 32 {
        let pixel = [200 + i % 32, 100 + i / 32];
        let mut sampler = PathSampler::new(pixel[0], pixel[1], 3, 0);
        let [u0, u1, u2, u3] = sampler.next_4d();
        let [u_wavelength, u4, u5, _] = sampler.next_4d();
        let place = raster.place(pixel[0], pixel[1], [u0, u1]);
        requests.push(Request {
            pixel,
            place,
            u_lens: [u2, u3],
            u_wavelength,
            u_pixels: [u4, u5],
            ..Request::default()
        });
        if requests.len() == 64 {
            one(&requests);
            requests.clear();
        }
    }
}

fn bench(c: &mut Criterion) {
    let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(Filter::BlackmanHarris(1.5)));
    let mut group = c.benchmark_group("camera sample");
    group.throughput(criterion::Throughput::Elements(32 * 32));
    let mut alone = |name: &str, camera: &Camera| {
        group.bench_function(name, |b| {
            b.iter(|| {
                stretches(&raster, |requests| {
                    for r in requests {
                        black_box(camera.sample(r.place, r.u_lens, r.u_wavelength));
                    }
                });
            });
        });
    };
    alone("pinhole", &camera(Model::Pinhole, "", None));
    for name in ["wide-angle-smith-f3.4", "double-gauss-f1.35", "laikin-fisheye-170"] {
        for (kind, spectrum) in [("one wavelength", None), ("film first", Some(Spectrum::Visible))] {
            let camera = camera(Model::Lens, name, spectrum);
            let lens = camera.traced_lens().unwrap();
            let (mut batch, mut rays) = (lens.batch(), Vec::new());
            group.bench_function(format!("{name}/{kind}"), |b| {
                b.iter(|| {
                    stretches(&raster, |requests| {
                        rays.clear();
                        lens.sample_batch(requests, &mut batch, &mut rays);
                        black_box(&rays);
                    });
                });
            });
        }
        let camera = camera(Model::Lens, name, Some(Spectrum::Visible));
        let lens = camera.traced_lens().unwrap();
        let (mut batch, mut leads) = (lens.batch(), Vec::new());
        group.bench_function(format!("{name}/hero"), |b| {
            b.iter(|| {
                stretches(&raster, |requests| {
                    leads.clear();
                    lens.lead_all_batch(requests, &raster, &mut batch, &mut leads);
                    black_box(&leads);
                });
            });
        });
        group.bench_function(format!("{name}/hero alone"), |b| {
            b.iter(|| {
                stretches(&raster, |requests| {
                    for r in requests {
                        black_box(lens.lead_all(r, &raster));
                    }
                });
            });
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
