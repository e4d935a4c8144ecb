//! Each effect alone: an effect that is taken out is gone, and the others are the lens's.

use super::*;
use crate::camera::Camera;
use crate::camera::tests::with_lens;
use crate::camera::tools::shade;

const SIZE: [u32; 2] = [900, 600];

fn camera(shown: EnabledEffects, d: &CameraDescription) -> Camera {
    Camera::new(&CameraDescription { shown, ..d.clone() }, SIZE[0], SIZE[1]).unwrap()
}

fn wide() -> CameraDescription {
    with_lens("wide-angle-smith-f3.4.lens", 120.0, 80.0, 0.0)
}

/// The rays of a place at a wavelength, by the numbers that choose their points of the pupil.
fn rays(camera: &Camera, place: Vec2, u_wavelength: f32) -> Vec<CameraRay> {
    let u = |i: u32| [0.755, 0.57].map(|step: f64| (0.5 + step * f64::from(i)).fract() as f32);
    (0..256).filter_map(|i| camera.sample(place, u(i), u_wavelength)).collect()
}

/// The mean point at which a place's rays hit the sharp plane, at three metres; and their spread there.
fn spot(camera: &Camera, place: Vec2, u_wavelength: f32, depth: f32) -> (DVec2, f64) {
    let met: Vec<DVec2> = rays(camera, place, u_wavelength)
        .iter()
        .map(|one| {
            (one.ray.origin + one.ray.direction * ((depth + one.ray.origin.z) / -one.ray.direction.z))
                .as_dvec3()
                .truncate()
        })
        .collect();
    let mean = met.iter().sum::<DVec2>() / met.len() as f64;
    let square = met.iter().map(|p| (*p - mean).length_squared()).sum::<f64>() / met.len() as f64;
    (mean, square.sqrt())
}

const PLACES: [Vec2; 5] =
    [Vec2::new(0.0, 0.0), Vec2::new(0.3, 0.1), Vec2::new(-0.45, 0.0), Vec2::new(0.1, -0.45), Vec2::new(0.42, 0.42)];

/// The picture without distortion is in proportion to the scene; with distortion it is not. Stopped down: wide open the mean of a spot with
/// coma is no sharp measure.
#[test]
fn straight_lines_are_straight() {
    let d = CameraDescription { wavelength_nm: Some(587.6), ..wide() }.with(|c| c.lens.f_number = Some(11.0));
    for (shown, most) in [
        (EnabledEffects { distortion: false, ..EnabledEffects::default() }, 2e-4),
        (EnabledEffects { distortion: false, aberration: false, ..EnabledEffects::default() }, 1e-6),
    ] {
        let camera = camera(shown, &d);
        let per_width = spot(&camera, Vec2::new(0.01, 0.0), 0.5, 3.0).0.x / 0.01;
        for place in PLACES {
            let (seen, _) = spot(&camera, place, 0.5, 3.0);
            let ideal = place.as_dvec2() * DVec2::new(per_width, per_width / 1.5);
            assert!((seen - ideal).length() < most * per_width, "{place}: {seen} {ideal}");
        }
    }
    let whole = camera(EnabledEffects::default(), &d);
    let per_width = spot(&whole, Vec2::new(0.01, 0.0), 0.5, 3.0).0.x / 0.01;
    let corner = PLACES[4].as_dvec2() * DVec2::new(per_width, per_width / 1.5);
    assert!((spot(&whole, PLACES[4], 0.5, 3.0).0 - corner).length() > 1e-3 * per_width);
}

/// All rays of a place without aberrations hit the sharp plane in one point; distortion is unchanged.
#[test]
fn without_aberrations_points_are_points() {
    let d = CameraDescription { wavelength_nm: Some(587.6), ..wide() };
    let (ideal, whole) = (
        camera(EnabledEffects { aberration: false, ..EnabledEffects::default() }, &d),
        camera(EnabledEffects::default(), &d),
    );
    for place in PLACES {
        let ((a, spread), (b, exact_spread)) = (spot(&ideal, place, 0.5, 3.0), spot(&whole, place, 0.5, 3.0));
        assert!(spread < 1e-5 && spread < 0.1 * exact_spread, "{place}: {spread} {exact_spread}");
        // Of a beam with coma the mean lies aside of its chief ray.
        assert!((a - b).length() < exact_spread, "{place}: {a} {b}");
    }
    // Blur of what is not sharp is that of the lens, but for its aberrations.
    let (near, exact_near) = (spot(&ideal, Vec2::ZERO, 0.5, 1.5).1, spot(&whole, Vec2::ZERO, 0.5, 1.5).1);
    assert!((near / exact_near - 1.0).abs() < 0.1, "{near} {exact_near}");
}

/// The picture without defocus is sharp everywhere, near and far, at the places where the lens shows it.
#[test]
fn without_defocus_near_and_far_are_sharp() {
    let d = CameraDescription { wavelength_nm: Some(587.6), ..wide() };
    let (sharp, whole) = (
        camera(EnabledEffects { defocus: false, ..EnabledEffects::default() }, &d),
        camera(EnabledEffects::default(), &d),
    );
    for place in PLACES {
        for depth in [1.0, 30.0] {
            let (at, spread) = spot(&sharp, place, 0.5, depth);
            let (_, blurred) = spot(&whole, place, 0.5, depth);
            assert!(spread < 5e-3 * blurred, "{place} {depth}: {spread} {blurred}");
            assert!((at - spot(&whole, place, 0.5, depth).0).length() < 1.5 * blurred);
        }
    }
}

/// Each of the two colour errors can be taken out alone.
#[test]
fn colours_part_in_one_way_alone() {
    let d = with_lens("biconvex-50mm.lens", 36.0, 24.0, 0.0).with(|c| c.lens.f_number = Some(16.0));
    let corner = Vec2::new(0.4, 0.4);
    let apart = |camera: &Camera| {
        let ends = [0.05, 0.95].map(|u| spot(camera, corner, u, 3.0));
        let middles = [0.05, 0.95].map(|u| spot(camera, Vec2::ZERO, u, 3.0).1);
        ((ends[0].0 - ends[1].0).length(), (middles[0] - middles[1]).abs())
    };
    let whole = apart(&camera(EnabledEffects::default(), &d));
    let aligned = apart(&camera(EnabledEffects { lateral_colour: false, ..EnabledEffects::default() }, &d));
    let even = apart(&camera(EnabledEffects { axial_colour: false, ..EnabledEffects::default() }, &d));
    assert!(aligned.0 < 0.1 * whole.0, "{aligned:?} {whole:?}");
    assert!((aligned.1 / whole.1 - 1.0).abs() < 0.05, "{aligned:?} {whole:?}");
    assert!((even.0 / whole.0 - 1.0).abs() < 0.3, "{even:?} {whole:?}");
    assert!(even.1 < 0.05 * whole.1, "{even:?} {whole:?}");
}

/// A uniform world: even without vignetting, and as the lens has it with, whatever makes the rays.
#[test]
fn brightness_is_right_whatever_makes_the_rays() {
    let d = CameraDescription { wavelength_nm: Some(587.6), ..wide() };
    let white = |camera: &Camera, place: Vec2| {
        let sum: f64 = rays(camera, place, 0.5).iter().map(|ray| f64::from(ray.white().y)).sum();
        sum / 256.0
    };
    let whole = camera(EnabledEffects::default(), &d);
    let all = EnabledEffects::default();
    for shown in [
        EnabledEffects { vignetting: false, ..all },
        EnabledEffects { distortion: false, ..all },
        EnabledEffects { aberration: false, ..all },
        EnabledEffects { defocus: false, ..all },
        EnabledEffects { aberration: false, vignetting: false, ..all },
    ] {
        let d = CameraDescription { shown, ..d.clone() };
        let one = Camera::new(&d, SIZE[0], SIZE[1]).unwrap();
        let gains = shade::gains(&d, &one, SIZE[0], SIZE[1]).unwrap().unwrap();
        for place in PLACES {
            let at = (place + 0.5) * Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
            let gain = f64::from(gains[at.y as usize * SIZE[0] as usize + at.x as usize]);
            let expected = if shown.vignetting { white(&whole, place) } else { white(&whole, Vec2::ZERO) };
            let found = white(&one, place) * gain;
            // 256 rays a place, and what lies between the nodes of the map.
            assert!((found / expected - 1.0).abs() < 0.03, "{shown:?} {place}: {found} {expected}");
        }
    }
}

/// A ray of a batch equals the ray alone.
#[test]
fn a_sample_of_a_batch_is_the_sample_alone() {
    let shown = EnabledEffects { distortion: false, axial_colour: false, ..EnabledEffects::default() };
    let camera = camera(shown, &wide());
    let request = |i: u32| {
        let part = |step: f64| (0.5 + step * f64::from(i)).fract() as f32;
        Request {
            place: Vec2::new(part(0.881), part(0.777)) - 0.5,
            u_lens: [part(0.684), part(0.603)],
            u_wavelength: part(0.532),
            ..Request::default()
        }
    };
    let requests: Vec<Request> = (0..500).map(request).collect();
    let mut together = Vec::new();
    camera.sample_batch(&requests, camera.batch().as_mut(), &mut together);
    assert_eq!(together.len(), requests.len());
    for (r, ray) in requests.iter().zip(&together) {
        let alone = camera.sample(r.place, r.u_lens, r.u_wavelength);
        let parts = |ray: &CameraRay| (ray.ray.origin, ray.ray.direction, ray.weight);
        assert_eq!(ray.as_ref().map(parts), alone.as_ref().map(parts));
    }
    assert!(together.iter().flatten().count() > 400);
}
