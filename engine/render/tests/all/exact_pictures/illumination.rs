//! Brightness of a uniform world from the middle of the film to its corner: closed forms where there are some, else
//! exact rays counted.

use super::noise::photographs;
use super::studio::{D_LINE_NM, Exposure, in_three, lens, white_world};
use glam::{DVec2, Vec2};
use petzval_optics::focus::FilmPlane;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::system::System;
use petzval_optics::trace::{Ray, Tracer};
use petzval_render::camera::{Camera, CameraDescription, lens_info};
use petzval_render::pipeline::Pipeline;
use std::path::Path;

/// Rays along a side of the grid that finds the light, and of the one that counts it.
const SEARCH: i32 = 100;
const COUNT: i32 = 320;

/// Exposure by counting rays from the film.
struct Counter {
    tracer: Tracer,
    film: FilmPlane,
    picture_mm: DVec2,
    rear_z_mm: f64,
    rear_radius_mm: f64,
}

impl Counter {
    fn new(d: &CameraDescription, pixels: [u32; 2]) -> Self {
        let prescription = lens::read(&d.lens_path, Catalogue::shipped()).unwrap();
        let system = System::new(&prescription, &d.lens).unwrap();
        let info = lens_info(d, pixels[0], pixels[1]).unwrap();
        let film = FilmPlane {
            tilt_rad: d.film.tilt_rad,
            swing_rad: d.film.swing_rad,
            curvature_per_mm: system.film_radius_mm().map_or(0.0, f64::recip),
            ..FilmPlane::upright(info.film_z_mm)
        };
        Self {
            tracer: system.at_wavelength(D_LINE_NM),
            film,
            picture_mm: DVec2::new(info.picture_width_mm, info.picture_height_mm),
            rear_z_mm: system.last_vertex_z_mm(),
            rear_radius_mm: system.rear_radius_mm(),
        }
    }

    /// ∫ cos θ cos θ′ / d² over the part of the rear vertex's plane that lets light through, seen from a picture point.
    fn exposure(&self, p: DVec2) -> f64 {
        let film = self.film.frame().at(-p.x * self.picture_mm.x, -p.y * self.picture_mm.y);
        let seen = |at: DVec2| {
            let to = at.extend(self.rear_z_mm) - film.point;
            let direction = to.normalize();
            let passes = self.tracer.from_film(Ray { origin: film.point, direction }).is_ok();
            let cosines = (direction.z * direction.dot(film.normal)).abs();
            if passes { cosines / to.length_squared() } else { 0.0 }
        };
        // A bulging rear glass is hit beyond its rim's shadow on the plane.
        let mut bounds = [DVec2::splat(-1.3 * self.rear_radius_mm), DVec2::splat(1.3 * self.rear_radius_mm)];
        for side in [SEARCH, SEARCH, COUNT] {
            let size = bounds[1] - bounds[0];
            let place =
                |i: i32, j: i32| bounds[0] + size * (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(side);
            let (mut sum, mut low, mut high) = (0.0, DVec2::INFINITY, DVec2::NEG_INFINITY);
            for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
                let at = place(i, j);
                let light = seen(at);
                if light > 0.0 {
                    sum += light;
                    (low, high) = (low.min(at), high.max(at));
                }
            }
            if side == COUNT {
                return sum * size.x * size.y / f64::from(side * side);
            }
            assert!(sum > 0.0, "no light at {p}");
            let margin = 1.5 * size / f64::from(side);
            bounds = [low - margin, high + margin];
        }
        unreachable!("the last grid counts");
    }
}

/// The camera's brightness of a white world at a picture point.
fn by_camera(camera: &Camera, p: Vec2) -> f64 {
    let n = 16_384;
    let point = |i| sobol_burley::sample_4d(i, 0, 3);
    let white = |u: [f32; 4]| camera.sample(p, [u[0], u[1]], u[2]).map_or(0.0, |r| f64::from(r.white().y));
    (0..n).map(|i| white(point(i))).sum::<f64>() / f64::from(n)
}

/// A lens whose stop stands behind it in air: the film sees a lit disc and nothing else. Its light at the height h is
/// known (the view factor of a disc), and falls off as cos⁴ where the disc is small.
#[test]
fn behind_a_rear_stop_light_falls_off_by_the_closed_form() {
    let text = "#radius thickness glass diameter conic isstop\n\
                 60 8 N-BK7 64 0 0\n-60 14 air 64 0 0\n0 45 air 9 0 1\n";
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rear-stop.lens");
    std::fs::write(&path, text).unwrap();
    for diameter_mm in [9.0, 1.5] {
        let open = CameraDescription { lens_path: path.clone(), ..lens("biconvex-50mm") };
        let widest = lens_info(&open, 3, 2).unwrap().f_number;
        let d = open.with(|c| {
            c.lens.f_number = Some(widest * 9.0 / diameter_mm);
            c.focus.film_distance_mm = Some(45.0);
        });
        let camera = Camera::new(&d, 30, 20).unwrap();
        let radius = 0.5 * diameter_mm;
        let closed = |h: f64| {
            let sum = 45.0 * 45.0 + h * h + radius * radius;
            1.0 - (sum - 2.0 * radius * radius) / (sum * sum - 4.0 * h * h * radius * radius).sqrt()
        };
        for p in [Vec2::ZERO, Vec2::new(0.2, 0.1), Vec2::new(-0.5, 0.2), Vec2::new(0.5, -0.5)] {
            let h = (36.0 * f64::from(p.x)).hypot(24.0 * f64::from(p.y));
            let expected = closed(h) / closed(0.0);
            let found = by_camera(&camera, p);
            // The samples lie evenly: what is lost at the pupil's rim is known to some 1e-3.
            assert!((found / expected - 1.0).abs() < 2e-3, "{diameter_mm} {p}: {found} {expected}");
            let cos4 = (45.0 * 45.0 / (45.0 * 45.0 + h * h)).powi(2);
            if diameter_mm < 2.0 {
                assert!((found / cos4 - 1.0).abs() < 3e-3, "{p}: {found} {cos4}");
            }
        }
    }
}

/// Vignetting from the middle to the corner, for a wide angle, telephoto, double Gauss, fisheye, mirror lens, a retina
/// and a film that is turned.
#[test]
fn vignetting_is_that_of_counted_rays() {
    let film = |name: &str, width: f64, f_number: Option<f64>| {
        lens(name).with(|c| {
            c.film.width_mm = width;
            c.film.height_mm = width / 1.5;
            c.lens.f_number = f_number;
        })
    };
    let turned = film("double-gauss-f2-tronnier", 60.0, None).with(|c| {
        c.film.tilt_rad = 0.2;
        c.film.swing_rad = -0.15;
    });
    let cases = [
        film("wide-angle-smith-f3.4", 120.0, None),
        film("wide-angle-smith-f3.4", 120.0, Some(8.0)),
        film("biogon-21-f4.5", 34.0, Some(8.0)).with(|c| c.lens.blades = 5),
        film("pbrt-telephoto-250mm", 12.0, None),
        film("double-gauss-f1.35", 43.0, None),
        film("laikin-fisheye-170", 10.0, None),
        film("reflex-nikkor-500-f8", 36.0, None),
        film("eye-navarro", 14.0, None),
        turned,
    ];
    for d in cases {
        let camera = Camera::new(&d, 300, 200).unwrap();
        let counter = Counter::new(&d, [300, 200]);
        let name = camera.name();
        // Turning the film leaves the middle's film point on the axis, but looks at the pupil from aside.
        let upright = Counter::new(
            &d.clone().with(|c| {
                c.film.tilt_rad = 0.0;
                c.film.swing_rad = 0.0;
            }),
            [300, 200],
        );
        let axis = upright.exposure(DVec2::ZERO);
        let places = [[0.0, 0.0], [0.25, 0.15], [0.36, -0.34], [-0.42, -0.42], [0.5, 0.5]];
        for p in places {
            let expected = counter.exposure(DVec2::from(p)) / axis;
            let found = by_camera(&camera, DVec2::from(p).as_vec2());
            assert!((found / expected - 1.0).abs() < 2e-3, "{name} {:?} {p:?}: {found} {expected}", d.lens.f_number);
        }
    }
}

/// Pictures of a white world by every pipeline fall off as counted rays do: middle, edge and corner of two lenses.
#[test]
fn pictures_of_a_white_world_fall_off_as_counted() {
    const PIXELS: [u32; 2] = [12, 8];
    let stage = white_world();
    // The fisheye's corner is the noisiest.
    let wide = if petzval_testkit::is_thorough() { 6144 } else { 3072 };
    for (name, width, of_scene) in [("wide-angle-smith-f3.4", 120.0, wide), ("laikin-fisheye-170", 9.0, 6144)] {
        let d = lens(name).with(|c| {
            c.film.width_mm = width;
            c.film.height_mm = width / 1.5;
        });
        let counter = Counter::new(&d, PIXELS);
        let axis = counter.exposure(DVec2::ZERO);
        let places = [[6, 4], [1, 3], [11, 7]];
        let expected = places.map(|[x, y]| {
            // Gauss's points of the third order: vignetting is smooth inside of a pixel.
            let part = 0.5 / 3f64.sqrt();
            let at = |i: u32, n: u32, side: f64| (f64::from(i) + 0.5 + side * part) / f64::from(n) - 0.5;
            let points = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];
            let light = |[a, b]: [f64; 2]| counter.exposure(DVec2::new(at(x, PIXELS[0], a), at(y, PIXELS[1], b)));
            points.map(light).iter().sum::<f64>() / 4.0 / axis
        });
        for (pipeline, d, samples) in [
            (Pipeline::FilmFirst, d.clone(), 512),
            (Pipeline::SceneFirst, d.clone(), of_scene),
            (Pipeline::Hero, in_three(&d), 512),
        ] {
            let mean = photographs(&stage, &d, &Exposure { pixels: PIXELS, pipeline, samples });
            for ([x, y], expected) in places.into_iter().zip(expected) {
                // Green is near enough to the d line that its vignetting is the same to 0.1 %.
                let [found, error2] = mean.pixels[(y * PIXELS[0] + x) as usize][1];
                let noise = error2.sqrt() / expected;
                println!("{name} {pipeline:?} {x} {y}: {expected:.4} {:+.4} ± {noise:.4}", found / expected - 1.0);
                // Half a per cent, and the noise.
                assert!(
                    (found / expected - 1.0).abs() < 5e-3 + 3.0 * noise,
                    "{name} {pipeline:?} {x} {y}: {found} {expected}"
                );
                assert!(noise < 1e-2, "{name} {pipeline:?}: {noise}");
            }
        }
    }
}
