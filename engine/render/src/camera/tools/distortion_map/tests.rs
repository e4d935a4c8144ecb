//! The map against the rays of the camera itself, and against itself backwards.

use super::*;
use crate::camera::Camera;
use crate::camera::tests::with_lens;
use glam::Vec2;

const PIXELS: [u32; 2] = [300, 200];
const PLACES: [[f64; 2]; 5] = [[0.0, 0.0], [0.21, -0.13], [-0.47, 0.31], [0.499, 0.499], [-0.33, -0.49]];

fn wide_angle() -> CameraDescription {
    with_lens("wide-angle-smith-f3.4.lens", 90.0, 60.0, 0.0)
}

/// The point of the pinhole's picture at which the mean of the camera's rays for a picture point hits the sharp plane.
fn by_rays(d: &CameraDescription, map: &DistortionMap, p: DVec2) -> DVec2 {
    let camera = Camera::new(d, PIXELS[0], PIXELS[1]).unwrap();
    let depth = d.focus.distance.unwrap();
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for u in (0..20_000).map(|i| sobol_burley::sample_4d(i, 0, 3)) {
        let Some(sample) = camera.sample(Vec2::new(p.x as f32, p.y as f32), [u[0], u[1]], 0.0) else { continue };
        let (o, r) = (sample.ray.origin.as_dvec3(), sample.ray.direction.as_dvec3());
        sum += o + r * ((-depth - o.z) / r.z);
        weight += 1.0;
    }
    map.pinhole.place(sum / weight).unwrap()
}

#[test]
fn it_says_where_the_camera_rays_go() {
    let d = CameraDescription { wavelength_nm: Some(D_LINE_NM), ..wide_angle() }.with(|c| c.lens.f_number = Some(11.0));
    let map = DistortionMap::new(&d, PIXELS, D_LINE_NM).unwrap();
    for p in PLACES.map(DVec2::from) {
        // At f/11 the weights of the rays, which count here and not there, are nearly alike: what is left is a part of the spot.
        let (found, rays) = (map.at(p).unwrap(), by_rays(&d, &map, p));
        assert!((found - rays).length() < 1e-4, "{p}: {found} {rays}");
        assert!((found - map.look(p).unwrap()).length() < 3e-6, "{p}");
    }
    // It is no pinhole.
    assert!((map.at(DVec2::splat(0.49)).unwrap() - 0.49).length() > 1e-3);
}

#[test]
fn the_middle_is_framed_alike_and_turned_and_shifted_films_too() {
    for d in [
        wide_angle().with(|c| c.focus.distance = None),
        wide_angle().with(|c| c.film.shift_mm = [7.0, -3.0]),
        CameraDescription { scale_mm_per_unit: DVec3::new(500.0, 500.0, 1000.0), ..wide_angle() },
    ] {
        let map = DistortionMap::new(&d, PIXELS, D_LINE_NM).unwrap();
        // The optical axis' place: there the lens is a pinhole to first order.
        let axis = DVec2::new(-d.film.shift_mm[0] / 90.0, -d.film.shift_mm[1] / 60.0);
        let slope = (map.look(axis + 0.004).unwrap() - map.look(axis - 0.004).unwrap()) / 0.008;
        let stretch = d.scale_mm_per_unit.z / d.scale_mm_per_unit.x;
        if stretch == 1.0 {
            assert!((map.look(axis).unwrap() - axis).length() < 1e-5);
            assert!((slope - 1.0).length() < 2e-3, "{slope}");
        }
        assert!(map.at(DVec2::ZERO).is_some());
    }
}

#[test]
fn back_is_the_way_back() {
    for d in [wide_angle(), wide_angle().with(|c| c.film.tilt_rad = 0.1)] {
        let map = DistortionMap::new(&d, PIXELS, D_LINE_NM).unwrap();
        for p in PLACES.map(DVec2::from) {
            let there = map.at(p).unwrap();
            assert!((map.back(there).unwrap() - p).length() < 1e-6, "{p}");
        }
        assert!(map.back(DVec2::splat(5.0)).is_none());
    }
}

#[test]
fn what_the_lens_does_not_see_is_marked() {
    // Far more film than the lens covers.
    let d = wide_angle().with(|c| {
        c.film.width_mm = 400.0;
        c.film.height_mm = 300.0;
    });
    let map = DistortionMap::new(&d, [40, 30], D_LINE_NM).unwrap();
    let pixels = map.pixels([40, 30], Direction::Distort);
    assert_eq!(pixels[0], [0.0; 4]);
    let middle = pixels[15 * 40 + 20];
    assert_eq!(middle[3], 1.0);
    assert!((middle[0] - 0.5).abs() < 0.03 && (middle[1] - 0.5).abs() < 0.03);
    assert!(pixels.iter().flatten().all(|value| value.is_finite()));
}

#[test]
fn wavelengths_differ_while_the_focus_stays() {
    let d = wide_angle();
    let at = |nm: f64| DistortionMap::new(&d, PIXELS, nm).unwrap().at(DVec2::new(0.45, 0.4)).unwrap();
    let (blue, red) = (at(450.0), at(620.0));
    let apart_px = (blue - red).length() * 300.0;
    assert!(apart_px > 0.05 && apart_px < 5.0, "{apart_px}");
}
