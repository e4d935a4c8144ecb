//! Files of sensors, descriptions of cameras and settings of renders, as the wall takes them from Python's dictionaries.

use std::path::PathBuf;
use std::time::Duration;

use glam::Vec2;
use petzval_render::camera::{Camera, CameraDescription, Model};
use petzval_render::job::{Job, Settings};
use petzval_render::sensor::exposure::ExposureRequest;
use petzval_render::sensor::file::SensorFile;
use petzval_render::sensor::report::report;
use petzval_render::sensor::response::Response;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::{films, one_line};

/// A sensor's file is read or refused in one line; all numbers of its report are finite.
pub fn sensor(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let file = match SensorFile::parse(text, "x.json") {
        Ok(file) => file,
        Err(error) => return one_line(&error),
    };
    for request in
        [ExposureRequest::default(), ExposureRequest { iso: Some(400.0), shutter_s: 0.01, ..Default::default() }]
    {
        if let Err(error) = request.checked(&file) {
            one_line(&error);
        }
    }
    let response = Response::new(file);
    for iso in [None, Some(400.0)] {
        match report(&response, iso) {
            Ok(found) => {
                let numbers = [
                    found.base_iso,
                    found.saturation_iso,
                    found.peak_quantum_efficiency,
                    found.gain_dn_per_e,
                    found.saturation_e,
                    found.read_noise_e,
                    found.dynamic_range_stops,
                ];
                assert!(numbers.iter().all(|number| number.is_finite()), "{found:?}");
            }
            Err(error) => one_line(&error),
        }
    }
}

/// A description with the values of another laid over it, dictionaries within it too.
fn laid_over(under: Value, over: Value) -> Value {
    match (under, over) {
        (Value::Object(mut under), Value::Object(over)) => {
            for (name, value) in over {
                let before = under.remove(&name).unwrap_or(Value::Null);
                under.insert(name, laid_over(before, value));
            }
            Value::Object(under)
        }
        (_, over) => over,
    }
}

/// The defaults of a description with an input's values, read; `None` where the input is no JSON or no such description.
fn described<T: DeserializeOwned>(defaults: &str, bytes: &[u8]) -> Option<T> {
    let over: Value = serde_json::from_slice(bytes).ok()?;
    let under = serde_json::from_str(defaults).unwrap_or_else(|error| panic!("{error}"));
    serde_json::from_value(laid_over(under, over)).ok()
}

/// A description of a camera is read or refused; a camera without a lens file is made or refused in one line, and asked for rays.
pub fn camera(bytes: &[u8]) {
    let Some(mut description) = described::<CameraDescription>(CAMERA, bytes) else { return };
    // No file of this computer is an input.
    description.lens_path = PathBuf::new();
    description.calibration = None;
    let camera = match Camera::new(&description, 16, 9) {
        Ok(camera) => camera,
        Err(error) => return one_line(&error),
    };
    for place in [[8.0, 4.5], [0.0, 0.0], [16.0, 9.0], [3.3, 7.7]] {
        for lens in [[0.5, 0.5], [0.0, 0.999]] {
            // Settings near the ends of what numbers can be may have rays that are none, which a render drops.
            let _ = camera.sample(Vec2::from_array(place), lens, 0.4);
        }
    }
}

/// Settings of a render are read or refused; a render of a few pixels by them ends, and is finite.
pub fn settings(bytes: &[u8]) {
    let Some(mut settings) = described::<Settings>(SETTINGS, bytes) else { return };
    settings.width = settings.width.min(6);
    settings.height = settings.height.min(4);
    settings.samples = settings.samples.min(4);
    settings.max_bounces = settings.max_bounces.min(4);
    settings.threads = 1;
    let stage = films::stage();
    let description = CameraDescription { model: Model::Pinhole, ..CameraDescription::default() };
    let camera = Camera::new(&description, 6, 4).unwrap_or_else(|error| panic!("{error}"));
    match Job::start(stage, camera, settings) {
        Ok(job) => {
            assert!(job.wait(Duration::from_secs(20)), "the render does not end");
            assert_eq!(job.statistics().failure, None);
            assert!(job.film().picture().iter().flatten().all(|value| !value.is_nan()));
        }
        Err(error) => one_line(&error),
    }
}

/// The dictionary of a camera as `petzval/description.py` makes it, with no values of its own.
const CAMERA: &str = r#"{"object_name": "Camera", "matrix_world": [[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]],
"model": "PINHOLE", "perspective": {"focal_length_mm": 50.0, "film_width_mm": 36.0, "shift": [0.0, 0.0],
"aperture_ratio": 1.0}, "pixel_aspect": 1.0, "lens_path": "", "lens": {"focal_length": "AS_PUBLISHED",
"f_number": null, "pupil_diameter_mm": null, "blades": 0, "blade_rotation_rad": 0.0, "blade_curvature": 0.0,
"aperture_mask": null, "coating": null}, "focus": {"distance": null, "focusing": {"anchor": "ENTRANCE_PUPIL",
"relation": "EXACT"}, "point_world": null, "film_distance_mm": null, "autofocus": null},
"film": {"width_mm": 36.0, "height_mm": 24.0, "tilt_rad": 0.0, "swing_rad": 0.0, "shift_mm": [0.0, 0.0]},
"scale_mm_per_unit": [1000.0, 1000.0, 1000.0], "wavelength_nm": null, "spectrum": "VISIBLE", "film_sensor": null,
"scattering": {"roughness_nm": 2.0, "cleanliness": 300.0, "veiling_index": 0.01}, "exposes_by_f_number": false,
"white_balance": true, "precision": "AUTO", "exposure": null, "orthographic_width": 1.0, "panorama": null,
"calibration": null, "spherical_stereo": null, "clip": [0.1, 1000.0]}"#;

/// The dictionary of a render's settings.
const SETTINGS: &str = r#"{"width": 6, "height": 4, "samples": 2, "noise_threshold": 0.0, "denoising": null, "min_samples": 0, "seed": 0,
"blue_noise": false, "independent_pixels": false, "film_exposure": 1.0, "window": null, "sample_offset": 0,
"threads": 0, "max_bounces": 12, "kinds": {"diffuse": 4294967295, "glossy": 4294967295,
"transmission": 4294967295, "volume": 4294967295, "transparent": 4294967295, "transparent_shadows": 4294967295,
"caustics": {"reflective": true, "refractive": true}}, "clamp_direct": 0.0, "clamp_indirect": 0.0,
"approximations": {"filter_glossy": 0.0, "widening": 0.0, "fast_gi": "OFF"}, "filter": {"BLACKMAN_HARRIS": 1.5},
"transparent_film": false, "transparent_glass": null, "pipeline": "AUTO", "with_data": false,
"integrator": "PATH", "light_tracing": true}"#;
