//! Cameras against closed forms and against the lens itself.

use super::*;
use glam::{DMat4, DVec3};
use petzval_optics::diaphragm::ApertureMask;
use petzval_optics::focus::Focusing;
use petzval_optics::transmission::Passages;
use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3A;
use petzval_optics::diaphragm::Diaphragm;
use std::path::Path;

/// A lens of the cabinet wide open, focused at three metres, before a film of that size.
pub(crate) fn with_lens(file: &str, width_mm: f64, height_mm: f64, tilt_rad: f64) -> CameraDescription {
    CameraDescription { lens_path: lens(file), wavelength_nm: None, ..description(Model::Lens) }.with(|c| {
        c.film.width_mm = width_mm;
        c.film.height_mm = height_mm;
        c.film.tilt_rad = tilt_rad;
        c.focus.distance = Some(3.0);
    })
}

fn description(model: Model) -> CameraDescription {
    CameraDescription {
        model,
        lens_path: lens("wide-angle-smith-f3.4.lens"),
        wavelength_nm: Some(587.5618),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.focus.distance = Some(2.0);
        c.film.width_mm = 120.0;
        c.film.height_mm = 80.0;
    })
}

fn lens(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses").join(name)
}

fn points(n: u32) -> impl Iterator<Item = [f32; 4]> {
    (0..n).map(|i| sobol_burley::sample_4d(i, 0, 11))
}

#[test]
fn pinhole_rays_are_blenders() {
    let camera = Camera::new(&description(Model::Pinhole).with(|c| c.perspective.shift = [0.1, 0.0]), 200, 100);
    let ray = camera.unwrap().sample(Vec2::new(0.5, -0.5), [0.0; 2], 0.0).unwrap().ray;
    // Right edge: half of 36 mm plus a tenth of it, over 50 mm.
    let expected = Vec3A::new(21.6, -9.0, -50.0).normalize();
    assert!((ray.direction - expected).length() < 1e-6);
}

#[test]
fn thin_rays_meet_in_the_focused_plane() {
    let camera = Camera::new(&description(Model::Thin).with(|c| c.lens.blades = 6), 200, 100).unwrap();
    for u in points(100) {
        let ray = camera.sample(Vec2::new(0.3, 0.2), [u[0], u[1]], 0.0).unwrap().ray;
        let p = ray.origin + ray.direction * (-2.0 / ray.direction.z);
        assert!((p - Vec3A::new(0.432, 0.144, -2.0)).length() < 1e-5, "{p}");
        assert!(ray.origin.length() <= 0.05 / 5.6 + 1e-6);
    }
}

#[test]
fn a_thin_lens_has_the_blades_of_a_real_one() {
    let bladed = |blades, blade_curvature| {
        let base = description(Model::Thin);
        let d = base.with(|c| {
            c.lens.blades = blades;
            c.lens.blade_curvature = blade_curvature;
            c.lens.blade_rotation_rad = 0.3;
            c.lens.f_number = Some(5.6);
        });
        Camera::new(&d, 200, 100)
    };
    // 50 mm at f/5.6, in Blender units.
    let shape = Diaphragm::bladed(0.05 / 11.2, 5, 0.5, 0.3);
    let camera = bladed(5, 0.5).unwrap();
    let (mut farthest, mut beyond_the_polygon) = (0.0f64, 0);
    for u in points(1000) {
        let [x, y, _] = camera.sample(Vec2::ZERO, [u[0], u[1]], 0.0).unwrap().ray.origin.to_array().map(f64::from);
        // The origin is rounded to f32.
        assert!(shape.is_open(x * (1.0 - 1e-6), y * (1.0 - 1e-6)), "{x} {y}");
        farthest = farthest.max(x.hypot(y));
        beyond_the_polygon += u32::from(!Diaphragm::polygon(0.05 / 11.2, 5, 0.3).is_open(x, y));
    }
    let part = f64::from(beyond_the_polygon) / 1000.0;
    let polygon = Diaphragm::polygon(0.05 / 11.2, 5, 0.3).area_mm2();
    assert!((part - (1.0 - polygon / shape.area_mm2())).abs() < 0.02, "{part}");
    assert!(farthest > 0.97 * 0.05 / 11.2);
    for (blades, curvature, word) in [(1000, 0.0, "blades"), (5, 1.5, "curvature"), (5, f64::NAN, "curvature")] {
        let message = bladed(blades, curvature).err().unwrap().to_string();
        assert!(message.contains(word) && message.contains("camera '"), "{message}");
    }
}

/// A mask that is open on the right half: every model sees half of the beam, on that side, as bright as the whole.
#[test]
fn a_mask_shapes_the_beam_of_every_model() {
    let mask = Arc::new(ApertureMask::new(2, &[0.0, 1.0, 0.0, 1.0]).unwrap());
    for model in [Model::Thin, Model::Thick, Model::Paraxial, Model::Lens, Model::ImageBased] {
        let d = description(model).with(|c| {
            c.lens.aperture_mask = Some(mask.clone());
            c.lens.f_number = Some(8.0);
            c.film.width_mm = 3.0;
            c.film.height_mm = 2.0;
        });
        let camera = Camera::new(&d, 30, 20).unwrap();
        let n = 8192;
        let rays: Vec<CameraRay> = points(n).filter_map(|u| camera.sample(Vec2::ZERO, [u[0], u[1]], u[2])).collect();
        let mean = rays.iter().map(|r| f64::from(r.white().x)).sum::<f64>() / f64::from(n);
        // Of the real lens half of the samples are lost: their number errs by 1 / sqrt(8192) at most; the table by 2 %.
        assert!((mean - 1.0).abs() < 0.03, "{model:?}: {mean}");
        // The stop is seen upright from the scene: rays leave on the right, where x is.
        let at_entrance = |r: &CameraRay| r.ray.origin.x - r.ray.direction.x / r.ray.direction.z * r.ray.origin.z;
        let wrong = rays.iter().filter(|&r| at_entrance(r) < -1e-5).count();
        assert!(wrong * 100 < rays.len(), "{model:?}: {wrong} of {}", rays.len());
    }
}

/// A uniform white world is 1 in the middle of the film, for every third shipped lens, open and with curved blades; `make test-all` has all
/// lenses and other openings, and `tests/lens/test_white_world.py` has all lenses in every run. This tests the pupil map, its densities, and the
/// measure of the axis together.
#[test]
fn a_white_world_is_one_on_axis() {
    let mut seen = 0;
    for path in petzval_testkit::lenses::third(lens(""), 1) {
        let openings = [(None, 0, 0.0), (Some(8.0), 5, 0.6), (Some(11.0), 0, 0.0), (Some(8.0), 5, 0.0)];
        let count = if petzval_testkit::is_thorough() { 4 } else { 2 };
        for (f_number, blades, blade_curvature) in openings.into_iter().take(count) {
            let d = CameraDescription { lens_path: path.clone(), ..description(Model::Lens) }.with(|c| {
                c.lens.f_number = f_number;
                c.lens.blades = blades;
                c.lens.blade_curvature = blade_curvature;
                c.focus.distance = None;
                c.film.width_mm = 3.0;
                c.film.height_mm = 2.0;
            });
            let camera = match Camera::new(&d, 30, 20) {
                Ok(camera) => camera,
                // Lenses that focus nothing on their own film say so.
                Err(CameraError::Focus { .. }) => continue,
                Err(e) => panic!("{}: {e}", path.display()),
            };
            let n = 4096;
            let sum: f64 = points(n)
                .filter_map(|u| camera.sample(Vec2::ZERO, [u[0], u[1]], u[2]))
                .map(|r| r.white().x as f64)
                .sum();
            let mean = sum / n as f64;
            // 4096 stratified samples of a nearly constant weight, some of them lost at the rim.
            assert!((mean - 1.0).abs() < 0.01, "{}: {f_number:?} {blades}: {mean}", path.display());
            seen += 1;
        }
    }
    assert!(seen > if petzval_testkit::is_thorough() { 60 } else { 25 }, "{seen}");
}

/// A uniform white world is 1 in the middle of the film in every channel through the whole spectrum.
#[test]
fn a_white_world_is_white() {
    let camera = Camera::new(&CameraDescription { wavelength_nm: None, ..description(Model::Lens) }, 300, 200).unwrap();
    let n = 16384;
    let sum: glam::DVec3 =
        points(n).filter_map(|u| camera.sample(Vec2::ZERO, [u[0], u[1]], u[2])).map(|r| r.white().as_dvec3()).sum();
    let mean = sum / n as f64;
    assert!((mean - glam::DVec3::ONE).abs().max_element() < 0.01, "{mean}");
}

/// Rays of one film point converge at the focus, upright: the right of the picture looks to the right.
#[test]
fn the_lens_looks_where_the_picture_says() {
    let d = description(Model::Lens);
    let camera = Camera::new(&d, 300, 200).unwrap();
    let info = lens_info(&d, 300, 200).unwrap();
    assert!((info.focus_distance_mm.unwrap() - 2000.0).abs() < 1e-6, "{info:?}");
    let p = Vec2::new(0.02, 0.01);
    let mut n = 0;
    for u in points(256) {
        let Some(r) = camera.sample(p, [u[0], u[1]], u[2]) else { continue };
        let at = r.ray.origin + r.ray.direction * ((-2.0 - r.ray.origin.z) / r.ray.direction.z);
        let expected = Vec2::new(0.02 * 120.0, 0.01 * 80.0) / info.magnification.abs() as f32 / 1000.0;
        // Wide open the lens has some spherical aberration: within 3 mm at two metres.
        assert!((Vec2::new(at.x, at.y) - expected).length() < 3e-3, "{at} {expected}");
        n += 1;
    }
    assert!(n > 200, "only {n} of 256 rays got through");
    let viewport = 120.0 / info.viewport_focal_length_mm / 2.0;
    let paraxial = 60.0 / info.magnification.abs() / 2000.0;
    assert!((viewport - paraxial).abs() < 1e-9);
}

/// Objects at the focus distance from the camera's origin are sharp, whichever point of the lens stands there; and a pinhole there frames
/// it as the viewport is told.
#[test]
fn what_is_at_the_distance_is_sharp_from_each_anchor() {
    use petzval_optics::focus::{Anchor, Relation};
    for anchor in [Anchor::EntrancePupil, Anchor::FrontVertex, Anchor::Film] {
        let focusing = Focusing { anchor, relation: Relation::Exact };
        let d = description(Model::Lens).with(|c| {
            c.focus.focusing = focusing;
            c.lens.f_number = Some(45.0);
            c.focus.distance = Some(0.9);
        });
        let camera = Camera::new(&d, 300, 200).unwrap();
        let info = lens_info(&d, 300, 200).unwrap();
        assert!((info.focus_scale_mm.unwrap() - 900.0).abs() < 1e-6, "{anchor:?} {info:?}");
        let near = Vec2::new(0.01, 0.0);
        // Of a pinhole at the origin.
        let expected = 0.01 * info.picture_width_mm / info.viewport_focal_length_mm * 0.9;
        for u in points(100) {
            let Some(r) = camera.sample(near, [u[0], u[1]], u[2]) else { continue };
            let at = r.ray.origin + r.ray.direction * ((-0.9 - r.ray.origin.z) / r.ray.direction.z);
            // The beam is 2 mm wide: off by a lens's thickness of some 30 mm, the point would be blurred to 60 µm. The
            // distance of the rays from each other is spherical aberration of the third order: below 10 µm here.
            assert!((at.x - expected as f32).abs() < 1e-5 && at.y.abs() < 1e-5, "{anchor:?}: {at} {expected}");
        }
    }
}

/// The camera's place and direction, and the scale of the world, change no brightness.
#[test]
fn world_scale_and_place_do_not_matter() {
    let base = description(Model::Lens);
    let scaled = CameraDescription {
        matrix_world: DMat4::from_rotation_y(0.3) * DMat4::from_scale(DVec3::new(2.0, 2.0, -2.0)),
        scale_mm_per_unit: DVec3::splat(10.0),
        ..base.clone()
    }
    .with(|c| c.focus.distance = Some(200.0));
    let (a, b) = (Camera::new(&base, 300, 200).unwrap(), Camera::new(&scaled, 300, 200).unwrap());
    for u in points(64) {
        let ray = |c: &Camera| c.sample(Vec2::new(0.2, -0.3), [u[0], u[1]], u[2]);
        match (ray(&a), ray(&b)) {
            (Some(a), Some(b)) => {
                assert!((a.ray.origin * 100.0).length() - b.ray.origin.length() < 1e-3);
                assert!(a.weight.abs_diff_eq(b.weight, 1e-5));
            }
            (None, None) => {}
            _ => panic!("lost in one world only"),
        }
    }
}

/// The ray of a picture point of a camera with this matrix.
fn ray_of(model: Model, matrix_world: DMat4, p: Vec2) -> Ray {
    let description = CameraDescription { matrix_world, ..description(model) };
    Camera::new(&description, 300, 200).unwrap().sample(p, [0.3, 0.6], 0.4).unwrap().ray
}

/// As in Cycles: the picture of a mirrored camera object is mirrored, along the axis that has the negative scale.
#[test]
fn a_mirrored_object_mirrors_the_picture() {
    let place = DMat4::from_rotation_y(0.3) * DMat4::from_rotation_x(-0.4);
    let p = Vec2::new(0.2, -0.3);
    for model in [Model::Pinhole, Model::Thin, Model::Orthographic, Model::Lens, Model::Thick] {
        for scale in [DVec3::new(-2.0, 1.0, 3.0), DVec3::new(1.0, -0.5, 1.0), DVec3::NEG_ONE] {
            let ray = ray_of(model, place * DMat4::from_scale(scale), p);
            let plain = ray_of(model, DMat4::IDENTITY, p);
            let mirror = DMat3::from_mat4(place) * DMat3::from_diagonal(scale.signum());
            let expected = [plain.origin, plain.direction].map(|v| (mirror * v.as_dvec3()).as_vec3a());
            assert!(ray.origin.abs_diff_eq(expected[0], 1e-5), "{model:?} {scale}");
            assert!(ray.direction.abs_diff_eq(expected[1], 1e-6), "{model:?} {scale}");
        }
    }
}

/// As in Cycles, whose matrix from the camera to the world has columns of length one. A lens is rigid and looks the same way.
#[test]
fn a_sheared_object_shears_the_picture_of_a_camera_without_a_lens() {
    let columns = [DVec3::X, DVec3::new(0.6, 1.0, 0.0), DVec3::new(0.0, 0.3, 1.0)];
    let [x, y, z] = columns;
    let sheared = DMat4::from_mat3(DMat3::from_cols(2.0 * x, y, 0.5 * z));
    let p = Vec2::new(0.2, -0.3);
    let across = DVec3::new(0.72 * 0.2, 0.72 * -0.3 * 2.0 / 3.0, -1.0);
    let expected = (DMat3::from_cols(x, y.normalize(), z.normalize()) * across).normalize();
    let ray = ray_of(Model::Pinhole, sheared, p);
    assert!(ray.direction.abs_diff_eq(expected.as_vec3a(), 1e-6));
    // Depth is what it would be without the shear.
    let camera = CameraDescription { matrix_world: sheared, ..description(Model::Pinhole) };
    let depth = Camera::new(&camera, 300, 200).unwrap().depth((expected * 7.0).as_vec3());
    let unscaled = DMat3::from_cols(x, y.normalize(), z.normalize()).inverse() * expected;
    assert!((f64::from(depth) + 7.0 * unscaled.z).abs() < 1e-5);
    let lens = Camera::new(&CameraDescription { matrix_world: sheared, ..description(Model::Lens) }, 300, 200).unwrap();
    assert!(lens.axes().z_axis.abs_diff_eq(z.normalize(), 1e-12));
    assert!((*lens.axes() * lens.axes().transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
}

/// Scale counts nothing. What an axis without one was is told by the others; of one axis alone nothing is known.
#[test]
fn an_axis_without_scale_is_perpendicular_to_the_others() {
    let place = DMat4::from_rotation_y(0.3) * DMat4::from_rotation_x(-0.4);
    let p = Vec2::new(0.2, -0.3);
    for model in [Model::Pinhole, Model::Orthographic, Model::Lens] {
        let plain = ray_of(model, place, p);
        for scale in [DVec3::new(0.0, 2.0, 2.0), DVec3::new(2.0, 0.0, 1.0), DVec3::new(1.0, 3.0, 0.0)] {
            let ray = ray_of(model, place * DMat4::from_scale(scale), p);
            assert!(ray.origin.abs_diff_eq(plain.origin, 1e-6) && ray.direction.abs_diff_eq(plain.direction, 1e-6));
        }
        for scale in [DVec3::X, DVec3::Z, DVec3::ZERO, DVec3::NAN] {
            let matrix_world = place * DMat4::from_scale(scale);
            let Err(error) = Camera::new(&CameraDescription { matrix_world, ..description(model) }, 300, 200) else {
                panic!("{scale}")
            };
            assert!(error.to_string().contains("reset the camera object's scale"));
        }
    }
}

#[test]
fn errors_say_what_to_do() {
    let bad = |change: &dyn Fn(&mut CameraDescription)| {
        let mut d = description(Model::Lens);
        change(&mut d);
        Camera::new(&d, 30, 20).map(|_| ()).unwrap_err().to_string()
    };
    assert!(bad(&|d| d.lens_path = "nowhere.lens".into()).contains("nowhere.lens"));
    assert!(bad(&|d| d.focus.distance = Some(1e-6)).contains("Camera"));
    assert!(bad(&|d| d.focus.distance = Some(f64::NAN)).contains("focus distance"));
    assert!(bad(&|d| d.wavelength_nm = Some(5.0)).contains("wavelength"));
    assert!(bad(&|d| d.film.width_mm = 0.0).contains("film width"));
    assert!(bad(&|d| d.focus.film_distance_mm = Some(-1.0)).contains("behind the lens"));
    assert!(bad(&|d| d.matrix_world = DMat4::ZERO).contains("matrix"));
    assert!(bad(&|d| d.focus.point_world = Some(DVec3::Z)).contains("behind the camera"));
}

const FIRST_ORDER: [Model; 2] = [Model::Thick, Model::Paraxial];

#[test]
fn first_order_images_are_perfect() {
    for model in FIRST_ORDER {
        let d = description(model);
        let camera = Camera::new(&d, 300, 200).unwrap();
        let info = lens_info(&d, 300, 200).unwrap();
        for p in [Vec2::ZERO, Vec2::new(0.3, -0.2), Vec2::new(-0.45, 0.45)] {
            // The object is the image over the magnification, in the plane 2 m before the entrance pupil.
            let film = -p.as_dvec2() * glam::DVec2::new(info.picture_width_mm, info.picture_height_mm);
            let object = (film / info.magnification / 1000.0).extend(-2.0).as_vec3a();
            for u in points(200) {
                let ray = camera.sample(p, [u[0], u[1]], 0.0).unwrap().ray;
                let at = ray.origin + ray.direction * ((-2.0 - ray.origin.z) / ray.direction.z);
                assert!((at - object).length() < 2e-5, "{model:?} {p}: {at} {object}");
            }
        }
    }
}

#[test]
fn close_to_the_axis_every_lens_is_of_first_order() {
    for file in ["wide-angle-smith-f3.4.lens", "tessar-brendel.lens", "cassegrain-f12.lens"] {
        let far = |model| {
            CameraDescription { lens_path: lens(file), ..description(model) }.with(|c| {
                c.lens.f_number = Some(64.0);
                c.focus.distance = None;
                c.film.width_mm = 0.3;
                c.film.height_mm = 0.2;
            })
        };
        let exact = Camera::new(&far(Model::Lens), 300, 200).unwrap();
        let Camera::Lens(exact) = exact else { unreachable!() };
        for model in FIRST_ORDER {
            let camera = Camera::new(&far(model), 300, 200).unwrap();
            for u in points(100) {
                let p = Vec2::new(u[2] - 0.5, u[3] - 0.5);
                let ray = camera.sample(p, [u[0], u[1]], 0.0).unwrap().ray;
                let Some(CameraRay { ray: true_ray, .. }) = exact.sample(p, [u[0], u[1]], 0.0) else { continue };
                // All rays of a point are parallel before a lens focused at infinity; aberrations are of third order.
                assert!((ray.direction - true_ray.direction).length() < 1e-5, "{file} {model:?} {p}");
            }
        }
    }
}

#[test]
fn a_white_world_is_one_in_the_middle_by_first_order_too() {
    for file in
        ["wide-angle-smith-f3.4.lens", "anamorphic-2x-double-gauss.lens", "newtonian-f5.lens", "eye-navarro.lens"]
    {
        let shapes =
            [(Model::Thick, 0, 0.0), (Model::Thick, 5, 0.0), (Model::Thick, 5, 0.7), (Model::Paraxial, 0, 0.0)];
        for (model, blades, blade_curvature) in shapes {
            let d = CameraDescription { lens_path: lens(file), wavelength_nm: None, ..description(model) }.with(|c| {
                c.lens.f_number = Some(8.0);
                c.lens.blades = blades;
                c.lens.blade_curvature = blade_curvature;
                c.focus.distance = None;
                c.film.width_mm = 1.0;
                c.film.height_mm = 1.0;
            });
            let camera = Camera::new(&d, 100, 100).unwrap();
            let n = 20_000;
            let all: Vec<CameraRay> =
                points(n).map(|u| camera.sample(Vec2::ZERO, [u[0], u[1]], u[2]).unwrap()).collect();
            let mean = all.iter().map(CameraRay::white).sum::<Rgb>() / n as f32;
            assert!((mean - Rgb::ONE).abs().max_element() < 5e-3, "{file} {model:?} {blades}: {mean}");
        }
    }
}

/// The focal length of a single glass grows towards red: by the paraxial model alone each colour has its own focus.
#[test]
fn colours_part_by_the_paraxial_model() {
    let spread = |model| {
        let d = CameraDescription { lens_path: lens("biconvex-50mm.lens"), wavelength_nm: None, ..description(model) }
            .with(|c| {
                c.focus.distance = None;
                c.film.width_mm = 20.0;
                c.film.height_mm = 20.0;
            });
        let camera = Camera::new(&d, 100, 100).unwrap();
        let slope = |u: f32| {
            let direction = camera.sample(Vec2::ZERO, [0.0, 0.9], u).unwrap().ray.direction;
            direction.x / direction.z
        };
        (slope(0.01) - slope(0.99)).abs()
    };
    assert!(spread(Model::Paraxial) > 1e-3 && spread(Model::Thick) == 0.0);
}

/// The photographer's rule: an even card of luminance L saturates a film of speed S behind f-number N after
/// t = 78 N² 4 / (π S L).
#[test]
fn a_card_is_exposed_as_the_light_meter_says() {
    let value = |model, n: f64, shutter_s: f64, iso: f64| {
        let exposure = Some(exposure::PhysicalExposure { shutter_s, iso, lumens_per_watt: 683.0 });
        let d = CameraDescription { exposure, ..description(model) }.with(|c| {
            c.lens.f_number = Some(n);
            c.focus.distance = None;
            c.film.width_mm = 1.0;
            c.film.height_mm = 1.0;
        });
        let camera = Camera::new(&d, 100, 100).unwrap();
        let count = 4096;
        let all = points(count).filter_map(|u| camera.sample(Vec2::ZERO, [u[0], u[1]], u[2]));
        all.map(|ray| f64::from(ray.white().x)).sum::<f64>() / count as f64
    };
    let rule = |n: f64, t: f64, iso: f64| 683.0 * std::f64::consts::FRAC_PI_4 / (n * n) * t * iso / 78.0;
    for model in [Model::Lens, Model::Thick, Model::Paraxial, Model::ImageBased, Model::Thin] {
        for (n, t, iso) in [(8.0, 1.0 / 125.0, 100.0), (16.0, 1.0 / 30.0, 400.0), (5.6, 2.0, 50.0)] {
            // The pupil of a real lens lies on a plane, not on a ball about the film: cos⁴, 1 % at f/5.6.
            let part = value(model, n, t, iso) / rule(n, t, iso);
            assert!((part - 1.0).abs() < 0.015, "{model:?} {n} {t} {iso}: {part}");
        }
    }
    let d = CameraDescription {
        exposure: Some(exposure::PhysicalExposure { shutter_s: 0.0, iso: 100.0, lumens_per_watt: 683.0 }),
        ..description(Model::Lens)
    };
    assert!(Camera::new(&d, 10, 10).err().unwrap().to_string().contains("shutter"));
}

/// The mirror in the middle of a mirror lens takes light as glass does: its T-number counts it, and a physical exposure by the f-number
/// shows it. By areas of the patent's diameters, the hole is 41 / 80 of the rim.
#[test]
fn what_stands_in_the_middle_counts_for_the_t_number() {
    let physical = exposure::PhysicalExposure { shutter_s: 0.01, iso: 100.0, lumens_per_watt: 683.0 };
    let value = |exposes_by_f_number, model| {
        let d = CameraDescription {
            exposure: Some(physical),
            exposes_by_f_number,
            transmission: false,
            model,
            ..with_lens("reflex-nikkor-500-f8.lens", 1.0, 1.0, 0.0)
        }
        .with(|c| {
            c.focus.distance = None;
            c.film.width_mm = 1.0;
            c.film.height_mm = 1.0;
        });
        let camera = Camera::new(&d, 100, 100).unwrap();
        let all = points(4096).filter_map(|u| camera.sample(Vec2::ZERO, [u[0], u[1]], u[2]));
        all.map(|ray| f64::from(ray.white().x)).sum::<f64>()
    };
    let expected = 1.0 - (41.0f64 / 80.0).powi(2);
    for model in [Model::Lens, Model::ImageBased] {
        let part = value(true, model) / value(false, model);
        // The hole stands 10 mm behind the rim, where the beam has widened by a hundredth.
        assert!((part / expected - 1.0).abs() < 0.02, "{part} {expected}");
    }
    let d = with_lens("reflex-nikkor-500-f8.lens", 36.0, 24.0, 0.0);
    let info = lens_info(&d, 30, 20).unwrap();
    let system = lens::setup::Setup::new(&d, 30, 20).unwrap().system;
    let middle = Passages::new(&system, 550.0).in_the_middle(info.film_z_mm, &[550.0]).unwrap()[0];
    // As fast as its rim allows: the diaphragm is wider.
    let t = axial_beam::f_number(&system, 550.0).unwrap() / (expected * middle).sqrt();
    assert!((info.t_number.unwrap() / t - 1.0).abs() < 0.02, "{:?} {t}", info.t_number);
}
