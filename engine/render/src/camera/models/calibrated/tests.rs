use super::*;
use crate::camera::models::pinhole::Pinhole;
use crate::camera::tools::imaging::{Imaging, SeenPlace};
use crate::camera::{Camera, Model, ReadFiles};

fn description(camera: &str) -> CameraDescription {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/calibrations/cameras.txt");
    CameraDescription {
        model: Model::Calibrated,
        calibration: Some(CalibrationSettings {
            path: path.into(),
            camera: Some(camera.to_owned()),
            ..CalibrationSettings::default()
        }),
        ..Default::default()
    }
}

fn camera(d: &CameraDescription) -> Calibrated {
    Calibrated::new(d, d.axes().unwrap(), 96, 64).unwrap()
}

const PLACES: [Vec2; 5] =
    [Vec2::new(0.0, 0.0), Vec2::new(-0.45, 0.4), Vec2::new(0.49, -0.49), Vec2::new(0.2, 0.1), Vec2::new(-0.1, -0.3)];

/// 100 pixels of focal length on 96 are 37.5 mm on 36.
#[test]
fn an_undistorted_calibration_is_a_pinhole() {
    let d = description("1");
    let framed = d.clone().with(|d| {
        d.perspective.focal_length_mm = 37.5;
        d.perspective.film_width_mm = 36.0;
    });
    let pinhole = Pinhole::new(&framed, d.axes().unwrap(), 96, 64);
    for p in PLACES {
        let (found, expected) = (camera(&d).sample(p, [0.0; 2], 0.5).unwrap(), pinhole.ray(p));
        assert!((found.ray.direction - expected.ray.direction).length() < 1e-6, "{p}");
        assert_eq!((found.ray.origin, found.weight), (expected.ray.origin, Mat3::IDENTITY));
    }
}

/// For passes and motion: the hit of a ray is found again at its place of the picture, by a camera anywhere.
#[test]
fn a_ray_comes_from_the_place_at_which_its_subject_is_found() {
    for name in ["1", "2", "3"] {
        let d = description(name).with(|d| {
            d.matrix_world = glam::DMat4::from_rotation_translation(
                glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.3, 2.0),
                DVec3::new(3.0, -2.0, 7.0),
            );
        });
        let made = Camera::new(&d, 96, 64).unwrap();
        let imaging = Imaging::new(&d, 96, 64, DVec3::new(1.0, 1.0, 1.0)).unwrap();
        for p in PLACES {
            let seen = made.sample(p, [0.5; 2], 0.5).unwrap().ray;
            let subject = DVec3::new(2.0, -3.0, 6.0) + (seen.origin + seen.direction * 5.0).as_dvec3();
            let through = imaging.through(&seen, SeenPlace::Point(subject));
            let again = imaging.picture_point(SeenPlace::Point(subject), through, 0.5).unwrap();
            // Rays are in single precision.
            assert!((again - p.as_dvec2()).length() < 1e-6, "{name}: {p} became {again}");
        }
    }
}

/// Rays through all of the opening converge at the focus distance: on a plane, or at a distance for a fisheye; and nowhere else.
#[test]
fn the_blur_is_that_of_a_thin_lens() {
    for (name, is_flat) in [("2", true), ("3", false)] {
        let sharp = camera(&description(name));
        let d = description(name).with(|d| {
            d.lens.f_number = Some(2.0);
            d.focus.distance = Some(4.0);
        });
        let blurred = camera(&d);
        for p in PLACES {
            let towards = sharp.sample(p, [0.0; 2], 0.5).unwrap().ray.direction;
            let reach = if is_flat { 4.0 / -towards.z } else { 4.0 };
            for u in [[0.1, 0.2], [0.9, 0.5], [0.5, 0.99]] {
                let ray = blurred.sample(p, u, 0.5).unwrap().ray;
                let off = towards * reach - ray.origin;
                assert!(off.cross(ray.direction).length() < 1e-5, "{name} {p}");
            }
        }
        // A subject beside the axis is focused on by its depth, or by its distance.
        let beside = d.clone().with(|d| {
            d.focus.point_world = Some(DVec3::new(3.0, 0.0, -4.0));
        });
        let reach = if is_flat { 4.0 } else { 5.0 };
        let (towards, ray) = (
            sharp.sample(Vec2::ZERO, [0.0; 2], 0.5).unwrap().ray.direction,
            camera(&beside).sample(Vec2::ZERO, [0.9, 0.5], 0.5).unwrap().ray,
        );
        let reach = if is_flat { reach / -towards.z } else { reach };
        assert!((towards * reach - ray.origin).cross(ray.direction).length() < 1e-5, "{name}");
        // Focal length over twice the f-number, on a sensor of 36 mm.
        let [focal_px, _] = calibration_of(&d, 96, 64).unwrap().focal_px().unwrap();
        let radius = focal_px / 96.0 * 36.0 / 4.0 / 1000.0;
        let far =
            (0..200).map(|i| blurred.sample(Vec2::ZERO, [i as f32 / 200.0, 0.7], 0.5).unwrap().ray.origin.length());
        let largest = far.fold(0.0, f32::max);
        assert!(
            (f64::from(largest) / radius - 1.0).abs() < 0.2 && f64::from(largest) <= radius * (1.0 + 1e-5),
            "{largest} {radius}"
        );
    }
}

#[test]
fn beyond_a_fold_there_is_no_ray_and_a_reason() {
    let d = description("4");
    // 1 - 1.5 r^2 = 0 at r = 0.816, which lies at 2/3 of it: 27 pixels from the middle.
    let made = camera(&d);
    assert!(made.sample(Vec2::new(27.0 / 96.0, 0.0), [0.0; 2], 0.5).is_some());
    assert!(made.sample(Vec2::new(27.5 / 96.0, 0.0), [0.0; 2], 0.5).is_none());
    let complaint = d.calibration_remarks([96, 64]).unwrap().join("\n");
    assert!(
        complaint.starts_with("Camera 'Camera': ")
            && complaint.contains("the distortion folds back before, valid to 39.2 degrees"),
        "{complaint}"
    );
    assert!(description("1").calibration_remarks([96, 64]).unwrap().is_empty());
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |d: &CameraDescription, width: u32, height: u32| match Camera::new(d, width, height) {
        Err(error) => error.to_string(),
        Ok(_) => String::new(),
    };
    assert!(refused(&description("1"), 128, 64).contains("has another shape; set a resolution of 96 x 64"));
    assert_eq!(refused(&description("1"), 192, 128), "");
    assert_eq!(refused(&description("1"), 100, 67), "", "as near as whole pixels allow");
    assert!(refused(&description("9"), 96, 64).contains("there is no camera '9'; there is 1, 2, 3, 4"));
    let none = description("1").with(|d| d.calibration = None);
    assert!(refused(&none, 96, 64).contains("needs a calibration"));
    let exposed = description("1").with(|d| {
        d.exposure =
            Some(crate::camera::exposure::PhysicalExposure { shutter_s: 1.0, iso: 100.0, lumens_per_watt: 683.0 });
    });
    assert!(refused(&exposed, 96, 64).contains("no f-number to expose by"));
}

/// The map of a calibration, as an ST map on a pinhole of the same middle, is that calibration.
#[test]
fn an_st_map_in_a_file_is_a_camera() {
    let d = description("2");
    let calibration = calibration_of(&d, 96, 64).unwrap();
    let map = calibration.st_map([96, 64], petzval_optics::calibration::MapDirection::Distort).unwrap();
    let folder = std::env::temp_dir().join(format!("petzval-st-map-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("map.exr");
    let channel = |i: usize, name: &str| (name.to_owned(), map.iter().map(|pixel| pixel[i]).collect::<Vec<f32>>());
    channels::write(&path, [96, 64], vec![channel(0, "R"), channel(1, "G")], "").unwrap();
    let [fx, fy, cx, cy] = calibration.pinhole_px().unwrap();
    let by_map = d.clone().with(|d| {
        d.calibration = Some(CalibrationSettings { path: path.clone(), ..CalibrationSettings::default() });
        d.perspective.focal_length_mm = fx / 96.0 * 36.0;
        d.perspective.film_width_mm = 36.0;
        d.perspective.shift = [(48.0 - cx) / 96.0, (cy - 32.0) / 96.0];
    });
    let (found, expected) = (camera(&by_map), camera(&d));
    for p in PLACES.iter().take(2).chain(&PLACES[3..]) {
        let (a, b) = (
            found.sample(*p, [0.0; 2], 0.5).unwrap().ray.direction,
            expected.sample(*p, [0.0; 2], 0.5).unwrap().ray.direction,
        );
        // The pinhole of Blender's camera has square pixels; this one's differ by a part in eighty.
        let square = (fy / fx) as f32;
        let b = glam::Vec3A::new(b.x, b.y * square, b.z).normalize();
        assert!((a - b).length() < 1e-5, "{p}: {a} is not {b}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
    let made = |d: &CameraDescription| Calibrated::new(d, d.axes().unwrap(), 96, 64).is_ok();
    assert!(made(&by_map), "a job reads its map once");
    assert!(!made(&by_map.with(|d| d.read_files = ReadFiles::default())), "the file is gone");
}
