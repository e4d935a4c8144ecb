//! Calibrations of cameras: files of programs, ST maps, lensfun databases.

use glam::{DVec2, DVec3};
use petzval_optics::calibration::photographic::PhotographicSetting;
use petzval_optics::calibration::{Calibration, MapDirection, PhotographicLens};
use petzval_optics::formats::calibration::{self, Format};
use petzval_optics::lensfun::lateral_colour::Channel;
use petzval_optics::lensfun::{CalibratedLens, Database};

use super::bytes::Bytes;
use super::one_line;

/// The most cameras or lenses of a file that are looked into.
const MOST_CAMERAS: usize = 4;

/// Asserts that rays of a calibration are finite unit vectors, its places finite, and that a place leads back to itself.
fn rays(calibration: &Calibration, what: &str) {
    let size = DVec2::from_array(calibration.size_px().map(f64::from));
    for place in [[0.5, 0.5], [0.0, 0.0], [1.0, 1.0], [0.3, 0.8], [1.5, -0.4]] {
        let point = size * DVec2::from_array(place);
        if let Ok(direction) = calibration.unproject(point) {
            assert!(direction.is_finite() && (direction.length() - 1.0).abs() < 1e-9, "{what}: {point} {direction}");
            if let Ok(back) = calibration.project(direction) {
                assert!(back.is_finite(), "{what}: {point} {back}");
            }
        }
    }
    for direction in [DVec3::Z, DVec3::new(0.3, -0.2, 1.0), DVec3::X, -DVec3::Z, DVec3::new(1e-200, 0.0, 1e-200)] {
        if let Ok(point) = calibration.project(direction) {
            assert!(point.is_finite(), "{what}: {direction} {point}");
        }
    }
    if let Some(focal) = calibration.focal_px() {
        assert!(focal.iter().all(|f| f.is_finite()), "{what}: {focal:?}");
    }
    for direction in [MapDirection::Distort, MapDirection::Undistort] {
        for pixel in calibration.st_map([5, 4], direction).iter().flatten() {
            assert!(pixel.iter().all(|value| !value.is_nan()), "{what}: {pixel:?}");
        }
    }
}

/// A file of calibrations is read or refused in one line; its cameras' rays are finite; cameras that are written are read again.
pub fn calibration(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let file = match calibration::parse(text, "x") {
        Ok(file) => file,
        Err(error) => return one_line(&error),
    };
    for camera in file.cameras.iter().take(MOST_CAMERAS) {
        rays(&camera.calibration, &camera.name);
        for format in [Format::OpenCvYaml, Format::OpenCvJson, Format::Ros, Format::Colmap] {
            match calibration::write(std::slice::from_ref(camera), format) {
                Ok(written) => {
                    let back = calibration::parse(&written, "y").unwrap_or_else(|error| panic!("{error}\n{written}"));
                    let back = &back.cameras[0].calibration;
                    assert_eq!(back.size_px(), camera.calibration.size_px(), "{written}");
                }
                Err(error) => one_line(&error),
            }
        }
    }
}

/// An ST map of any numbers is a camera or refused in one line; its rays are finite.
pub fn st_map(bytes: &[u8]) {
    let mut bytes = Bytes::new(bytes);
    let size = [bytes.below(9) as u32, bytes.below(9) as u32];
    let is_true = bytes.once_in(192);
    let count = if bytes.once_in(8) { bytes.below(90) } else { (size[0] * size[1]) as usize };
    let parameters: Vec<f64> = if is_true {
        vec![6.0, 6.0, 0.5 * f64::from(size[0]), 0.5 * f64::from(size[1])]
    } else {
        (0..if bytes.once_in(8) { 3 } else { 4 }).map(|_| f64::from(bytes.any_f32())).collect()
    };
    let places: Vec<Option<[f32; 2]>> = (0..count)
        .map(|i| {
            if bytes.once_in(24) {
                return None;
            }
            if !is_true {
                return Some([bytes.any_f32(), bytes.any_f32()]);
            }
            // Where a map without distortion has it, and a little off.
            let [x, y] = [i as u32 % size[0].max(1), i as u32 / size[0].max(1)];
            let at = |i: u32, of: u32| (f64::from(i) + 0.5) / f64::from(of.max(1));
            let mut off = || 0.1 * bytes.part();
            Some([(at(x, size[0]) + off()) as f32, (1.0 - at(y, size[1]) + off()) as f32])
        })
        .collect();
    match Calibration::of_st_map(size, &places, &parameters) {
        Ok(calibration) => rays(&calibration, "ST map"),
        Err(error) => one_line(&error),
    }
}

/// A lensfun database is read or refused in one line; its lenses make cameras of finite rays, or are refused in one line.
pub fn lensfun(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Database::parse(text, "x.xml") {
        Ok(database) => {
            database.lenses().iter().take(MOST_CAMERAS).for_each(photographic);
            for body in database.bodies().iter().take(MOST_CAMERAS) {
                assert!(body.crop_factor.is_finite(), "{body:?}");
                if let Err(error) = database.body(&body.name()) {
                    one_line(&error);
                }
            }
            for lens in database.lenses().iter().take(MOST_CAMERAS) {
                if let Err(error) = database.find(&lens.name()) {
                    one_line(&error);
                }
            }
        }
        Err(error) => one_line(&error),
    }
}

fn photographic(lens: &CalibratedLens) {
    let shortest = lens.focal_range_mm[0];
    for focal_mm in [shortest, lens.nearest_marked_mm(shortest), 50.0] {
        let setting = PhotographicSetting {
            size_px: [60, 40],
            film_mm: [36.0 / 1.6, 24.0 / 1.6],
            focal_mm,
            f_number: 4.0,
            distance_m: 10.0,
        };
        let camera = match PhotographicLens::new(lens, &setting) {
            Ok(camera) => camera,
            Err(error) => {
                one_line(&error);
                continue;
            }
        };
        rays(&camera.calibration, &camera.name);
        for point in [DVec2::new(30.0, 20.0), DVec2::ZERO, DVec2::new(55.0, 3.0)] {
            for channel in [Channel::Red, Channel::Blue] {
                if let Ok(direction) = camera.unproject(point, channel) {
                    assert!(direction.is_finite(), "{}: {point} {direction}", camera.name);
                }
                assert!(!camera.lateral_px(point, channel).is_nan(), "{}: {point}", camera.name);
            }
            if let Some(light) = camera.illumination(point) {
                assert!(!light.is_nan() && light >= 0.0, "{}: {point} {light}", camera.name);
            }
        }
    }
}
