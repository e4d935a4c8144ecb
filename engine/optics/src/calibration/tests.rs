use super::{Calibration, CalibrationError, Model, Outside};
use glam::{DVec2, DVec3};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, PI};

const SIZE: [u32; 2] = [1280, 960];

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// A model with all that it has, by name, the rest as in a pinhole.
fn made(model: Model, given: &[(&str, f64)]) -> Result<Calibration, CalibrationError> {
    let mut p = model.undistorted([600.0, 610.0], [650.0, 470.0]).unwrap_or_else(|| match model {
        Model::StMap => vec![600.0, 610.0, 650.0, 470.0],
        Model::Equirectangular => vec![],
        Model::FThetaToAngle | Model::FThetaToPixels => {
            let mut p = vec![0.0; 13];
            p[..3].copy_from_slice(&[650.0, 470.0, 1.0]);
            p
        }
        Model::TdeRadial => vec![3.5, 3.6, 2.7, 0.01, -0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        _ => {
            let mut p = vec![0.0; 19];
            p[..6].copy_from_slice(&[5.0, 2.1, 1.76, 0.01, -0.02, 1.0]);
            p[17..].copy_from_slice(&[1.0, 1.0]);
            p
        }
    });
    for (name, value) in given {
        let place = model.parameter_names().iter().position(|known| known == name).unwrap();
        p[place] = *value;
    }
    Calibration::new(model, SIZE, &p)
}

/// The angle between two directions, which for small ones `angle_between` knows to 1e-8 only.
fn apart(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Random numbers that are the same each time.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        // Marsaglia 2003, xorshift.
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, half: f64) -> f64 {
        half * (2.0 * self.next() - 1.0)
    }
}

/// Parameters of every model, distorted as real lenses are.
#[expect(clippy::too_many_lines, reason = "an arm for each model")]
fn at_random(chance: &mut Chance) -> Vec<Calibration> {
    let mut found = Vec::new();
    for model in Model::ALL {
        let mut set = |pairs: &[(&'static str, f64, f64)]| {
            let given: Vec<_> =
                pairs.iter().map(|(name, middle, half)| (*name, middle + chance.within(*half))).collect();
            found.push(made(model, &given).unwrap());
        };
        match model {
            Model::OpenCv => {
                set(&[("k1", -0.2, 0.2), ("k2", 0.05, 0.1), ("p1", 0.0, 2e-3), ("p2", 0.0, 2e-3), ("k3", 0.0, 0.02)]);
                set(&[("k1", 1.0, 0.4), ("k4", 1.2, 0.4), ("k5", 0.3, 0.2), ("tau_x", 0.0, 0.1), ("tau_y", 0.0, 0.1)]);
                set(&[("k1", -0.2, 0.2), ("s1", 0.0, 5e-3), ("s3", 0.0, 5e-3), ("s4", 0.0, 1e-3)]);
                set(&[("k1", -0.3, 0.2)]);
            }
            Model::Fisheye => set(&[("k1", 0.0, 0.05), ("k2", 0.0, 0.02), ("k3", 0.0, 5e-3), ("alpha", 0.0, 0.01)]),
            Model::ThinPrismFisheye => {
                set(&[("k1", 0.0, 0.05), ("k2", 0.0, 0.02), ("p1", 0.0, 2e-3), ("p2", 0.0, 2e-3), ("sx1", 0.0, 2e-3)]);
            }
            Model::RadTanThinPrismFisheye => {
                set(&[("k0", 0.0, 0.05), ("k3", 0.0, 2e-3), ("p0", 0.0, 2e-3), ("s0", 0.0, 2e-3), ("s3", 0.0, 1e-3)]);
            }
            Model::Fov => set(&[("omega", 0.8, 0.5)]),
            Model::Division => set(&[("k", -0.1, 0.3)]),
            Model::DoubleSphere => set(&[("xi", -0.2, 0.3), ("alpha", 0.55, 0.3)]),
            Model::Eucm => set(&[("alpha", 0.55, 0.3), ("beta", 1.1, 0.4)]),
            Model::Omni => set(&[("xi", 1.0, 0.8), ("k1", -0.1, 0.1), ("p1", 0.0, 1e-3), ("p2", 0.0, 1e-3)]),
            Model::FThetaToAngle => {
                set(&[("k1", 1.6e-3, 1e-4), ("k2", 0.0, 1e-7), ("k3", 0.0, 1e-10), ("d", 0.0, 1e-3), ("e", 0.0, 1e-3)]);
            }
            Model::FThetaToPixels => set(&[("k1", 610.0, 50.0), ("k3", 0.0, 20.0), ("k4", 0.0, 4.0)]),
            Model::TdeRadial => {
                set(&[
                    ("distortion_2", 0.05, 0.1),
                    ("u_2", 0.0, 0.01),
                    ("v_2", 0.0, 0.01),
                    ("distortion_4", 0.0, 0.02),
                    ("u_4", 0.0, 2e-3),
                    ("v_4", 0.0, 2e-3),
                    ("phi_deg", 0.0, 90.0),
                    ("bending", 0.0, 0.05),
                ]);
            }
            Model::TdeAnamorphic => {
                set(&[
                    ("cx02", 0.05, 0.05),
                    ("cy02", 0.05, 0.05),
                    ("cx22", 0.0, 0.03),
                    ("cy22", 0.0, 0.03),
                    ("cx44", 0.0, 0.01),
                    ("cy24", 0.0, 0.01),
                    ("pixel_aspect", 1.5, 0.5),
                    ("rotation_deg", 0.0, 2.0),
                    ("squeeze_x", 1.0, 0.1),
                ]);
            }
            Model::Lensfun(_) => {
                set(&[("c2", 0.0, 0.02), ("c3", -0.1, 0.1), ("c4", 0.0, 0.03), ("p1", 0.0, 2e-3), ("p2", 0.0, 2e-3)]);
                set(&[("c3", -0.1, 0.1), ("c5", 0.0, 0.02), ("c7", 0.0, 5e-3)]);
            }
            Model::Equirectangular => set(&[]),
            Model::StMap => {}
        }
    }
    found
}

#[test]
fn points_are_where_opencv_sees_them() {
    let text = include_str!("../../../../tests/reference/calibrations/points.json");
    let file: Value = serde_json::from_str(text).unwrap();
    let mut seen = 0;
    for case in file["cases"].as_array().unwrap().iter().filter(|case| case["program"] == "OpenCV") {
        let given = numbers(&case["parameters"]);
        let is_fisheye = case["model"] == "fisheye";
        let model = if is_fisheye { Model::Fisheye } else { Model::OpenCv };
        let mut p = given.clone();
        p.resize(model.parameter_names().len(), 0.0);
        // OpenCV counts from the middle of the first pixel.
        p[2] += 0.5;
        p[3] += 0.5;
        let camera = Calibration::new(model, SIZE, &p).unwrap();
        for (scene, at) in case["scene"].as_array().unwrap().iter().zip(case["seen"].as_array().unwrap()) {
            let (scene, at) = (DVec3::from_slice(&numbers(scene)), DVec2::from_slice(&numbers(at)) + 0.5);
            let point = camera.project(scene).unwrap();
            // A picture is some 1000 pixels: 1e-9 of it.
            assert!((point - at).length() < 1e-9 * 1280.0, "{given:?}: {point} is not {at}");
            let back = camera.unproject(at).unwrap();
            assert!(apart(back, scene) < 2e-9, "{given:?}: {back} is not {scene}");
            seen += 1;
        }
    }
    assert_eq!(seen, 9 * 24);
}

#[test]
fn every_point_with_a_direction_is_seen_there() {
    let mut chance = Chance(20_261_129);
    let (mut both, mut all) = (0, 0);
    for _ in 0..40 {
        for camera in at_random(&mut chance) {
            for _ in 0..40 {
                let point = DVec2::new(1280.0 * chance.next(), 960.0 * chance.next());
                all += 1;
                let Ok(direction) = camera.unproject(point) else { continue };
                assert!((direction.length() - 1.0).abs() < 1e-14, "{camera:?}");
                let again = camera.project(direction);
                let off = again.map(|again| (again - point).length());
                assert!(
                    off.is_ok_and(|off| off < 1e-9 * 1280.0),
                    "{camera:?}: {point} becomes {again:?} by {direction}"
                );
                both += 1;
            }
        }
    }
    assert!(both * 10 > all * 9, "{both} of {all}");
}

#[test]
fn every_direction_with_a_point_is_seen_from_there() {
    let mut chance = Chance(41);
    for _ in 0..20 {
        for camera in at_random(&mut chance) {
            for _ in 0..60 {
                let d = DVec3::new(chance.within(1.0), chance.within(1.0), chance.within(1.0)).normalize();
                let Ok(point) = camera.project(d) else { continue };
                let within = (point / DVec2::new(1280.0, 960.0) - 0.5).abs().max_element() <= 0.5;
                let back = camera.unproject(point);
                if within {
                    assert!(
                        back.is_ok_and(|back| apart(back, d) < 1e-9),
                        "{camera:?}: {d} is seen at {point}, there is {back:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn closed_forms_hold() {
    let camera = made(Model::DoubleSphere, &[("xi", -0.2), ("alpha", 0.6)]).unwrap();
    let d = DVec3::new(0.3, -0.4, 0.7);
    // Usenko, Demmel and Cremers 2018, eqs. 40 to 42, by hand.
    let (xi, alpha): (f64, f64) = (-0.2, 0.6);
    let d1 = (0.09f64 + 0.16 + 0.49).sqrt();
    let z = xi * d1 + 0.7;
    let d2 = (0.09 + 0.16 + z * z).sqrt();
    let below = alpha * d2 + (1.0 - alpha) * z;
    let expected = DVec2::new(600.0 * 0.3 / below + 650.0, 610.0 * -0.4 / below + 470.0);
    assert!((camera.project(d).unwrap() - expected).length() < 1e-10);

    // With xi 0 it is the unified model, which the enhanced one is with beta 1; alpha is xi / (1 + xi) of Mei's, and f is by (1 + xi) larger.
    let same = [
        made(Model::DoubleSphere, &[("xi", 0.0), ("alpha", 0.6)]).unwrap(),
        made(Model::Eucm, &[("alpha", 0.6)]).unwrap(),
        made(Model::Omni, &[("xi", 1.5), ("fx", 1500.0), ("fy", 1525.0)]).unwrap(),
    ];
    for d in [d, DVec3::new(0.9, 0.1, -0.2), DVec3::new(0.0, 0.0, 3.0)] {
        let points = same.each_ref().map(|camera| camera.project(d).unwrap());
        assert!((points[0] - points[1]).length() < 1e-10 && (points[0] - points[2]).length() < 1e-10, "{points:?}");
    }

    // An equidistant fisheye at 90 degrees; the same by NVIDIA's polynomial, either way.
    let sideways = DVec3::X;
    let fisheye = made(Model::Fisheye, &[]).unwrap();
    assert!((fisheye.project(sideways).unwrap() - DVec2::new(650.0 + 600.0 * FRAC_PI_2, 470.0)).length() < 1e-10);
    let to_angle = made(Model::FThetaToAngle, &[("k1", 1.0 / 600.0)]).unwrap();
    let to_pixels = made(Model::FThetaToPixels, &[("k1", 600.0)]).unwrap();
    for camera in [to_angle, to_pixels] {
        assert!((camera.project(sideways).unwrap() - fisheye.project(sideways).unwrap()).length() < 1e-9);
    }
    // All of an equirectangular picture is seen, to its corners.
    let sphere = made(Model::Equirectangular, &[]).unwrap();
    assert_eq!(sphere.survey().covered, 1.0);
    let behind = sphere.unproject(DVec2::new(1279.5, 0.5)).unwrap();
    assert!(behind.y < -0.99 && behind.z < 0.0, "{behind}");
    // c, d and e: x = c x' + d y', y = e x' + y'
    let skewed = made(Model::FThetaToPixels, &[("k1", 600.0), ("c", 1.1), ("d", 0.01), ("e", 0.02)]).unwrap();
    let [x, y] = [600.0 * FRAC_PI_2 * 0.6, 600.0 * FRAC_PI_2 * 0.8];
    let at = skewed.project(DVec3::new(0.6, 0.8, 0.0)).unwrap();
    assert!((at - DVec2::new(650.0 + 1.1 * x + 0.01 * y, 470.0 + 0.02 * x + y)).length() < 1e-9);
}

/// 3DEqualizer's formulas, from its own diagonally normalized coordinates, y up, to the undistorted ones, written down term by term.
fn undistorted(camera: &Calibration, p: DVec2) -> DVec2 {
    let v = |name: &str| camera.parameter(name).unwrap();
    if camera.model() == Model::TdeRadial {
        let (x, y, r2) = (p.x, p.y, p.length_squared());
        let (r4, q) = (r2 * r2, (1.0 + v("bending")).sqrt());
        let (s, c) = v("phi_deg").to_radians().sin_cos();
        let xr = x * (1.0 + v("distortion_2") * r2 + v("distortion_4") * r4)
            + (r2 + 2.0 * x * x) * (v("u_2") + v("u_4") * r2)
            + 2.0 * x * y * (v("v_2") + v("v_4") * r2);
        let yr = y * (1.0 + v("distortion_2") * r2 + v("distortion_4") * r4)
            + (r2 + 2.0 * y * y) * (v("v_2") + v("v_4") * r2)
            + 2.0 * x * y * (v("u_2") + v("u_4") * r2);
        let across = (q - 1.0 / q) * c * s;
        return DVec2::new((c * c * q + s * s / q) * xr + across * yr, across * xr + (c * c / q + s * s * q) * yr);
    }
    let (s, c) = v("rotation_deg").to_radians().sin_cos();
    // The pixels' shape is undone first, then the rotation.
    let p = DVec2::new(p.x / v("pixel_aspect"), p.y);
    let p = DVec2::new(c * p.x + s * p.y, -s * p.x + c * p.y);
    let (r2, phi) = (p.length_squared(), p.y.atan2(p.x));
    let factor = |axis: &str| {
        let k = |power: &str| v(&format!("c{axis}{power}"));
        1.0 + (k("02") + k("22") * (2.0 * phi).cos()) * r2
            + (k("04") + k("24") * (2.0 * phi).cos() + k("44") * (4.0 * phi).cos()) * r2 * r2
    };
    let q = DVec2::new(p.x * factor("x") * v("pixel_aspect") * v("squeeze_x"), p.y * factor("y") * v("squeeze_y"));
    DVec2::new(c * q.x - s * q.y, s * q.x + c * q.y)
}

#[test]
fn the_models_of_3dequalizer_are_their_formulas() {
    let mut chance = Chance(7);
    let tde = |camera: &Calibration| matches!(camera.model(), Model::TdeRadial | Model::TdeAnamorphic);
    for _ in 0..20 {
        for camera in at_random(&mut chance).iter().filter(|camera| tde(camera)) {
            let v = |name: &str| camera.parameter(name).unwrap();
            let half_cm = 0.5 * v("film_width_cm").hypot(v("film_height_cm"));
            let point = DVec2::new(1280.0 * chance.next(), 960.0 * chance.next());
            let unit = DVec2::new(point.x / 1280.0, 1.0 - point.y / 960.0);
            let film_cm = (unit - 0.5) * DVec2::new(v("film_width_cm"), v("film_height_cm"));
            let p = (film_cm - DVec2::new(v("centre_x_cm"), v("centre_y_cm"))) / half_cm;
            let q = undistorted(camera, p) * half_cm / v("focal_cm");
            let expected = DVec3::new(q.x, -q.y, 1.0).normalize();
            let found = camera.unproject(point).unwrap();
            assert!((found - expected).length() < 1e-13, "{camera:?}: {found} is not {expected}");
        }
    }
}

#[test]
fn a_fold_ends_a_calibration_where_its_derivative_does() {
    // r (1 - r^2 / 3) turns round at 1: at 45 degrees.
    let camera = made(Model::OpenCv, &[("k1", -1.0 / 3.0)]).unwrap();
    let at = |tan: f64| camera.project(DVec3::new(tan, 0.0, 1.0));
    assert!(at(1.0 - 1e-9).is_ok());
    assert_eq!(at(1.0 + 1e-9), Err(Outside::Fold));
    // What lies farther out than the fold's own radius, 2 / 3, is nowhere; beyond OpenCV's formula comes back to it.
    assert!(camera.unproject(DVec2::new(650.0 + 600.0 * (2.0 / 3.0 - 1e-9), 470.0)).is_ok());
    assert_eq!(camera.unproject(DVec2::new(650.0 + 600.0 * (2.0 / 3.0 + 1e-9), 470.0)), Err(Outside::Fold));
    assert!((camera.survey().fold_rad.unwrap() - PI / 4.0).abs() < 1e-9);

    // A fisheye's: 1 - theta^2 = 0.
    let camera = made(Model::Fisheye, &[("k1", -1.0 / 3.0)]).unwrap();
    let at = |angle: f64| camera.project(DVec3::new(angle.sin(), 0.0, angle.cos()));
    assert!(at(1.0 - 1e-9).is_ok());
    assert_eq!(at(1.0 + 1e-9), Err(Outside::Fold));

    // A short fold between two long rising parts: the slope 1 + 3 k1 r^2 + 5 k2 r^4 has two zeros close to r^2 = 0.4.
    let (k1, k2) = (-5.0 / 3.0 * (1.0 + 1e-8), 1.25);
    let camera = made(Model::OpenCv, &[("k1", k1), ("k2", k2)]).unwrap();
    let root = (9.0 * k1 * k1 - 20.0 * k2).sqrt();
    let [first, last] = [-root, root].map(|root| ((-3.0 * k1 + root) / (10.0 * k2)).sqrt());
    assert!(last - first < 1e-4, "the fold is short");
    assert!((camera.survey().fold_rad.unwrap() - first.atan()).abs() < 1e-8);

    // With decentring the fold lies elsewhere all around: the determinant of differences says where.
    let camera = made(Model::OpenCv, &[("k1", -1.0 / 3.0), ("p1", 0.01), ("p2", -0.02)]).unwrap();
    let raw = |q: DVec2| {
        let (r2, x, y) = (q.length_squared(), q.x, q.y);
        let radial = 1.0 - r2 / 3.0;
        DVec2::new(
            x * radial + 0.02 * x * y - 0.02 * (r2 + 2.0 * x * x),
            y * radial + 0.01 * (r2 + 2.0 * y * y) - 0.04 * x * y,
        )
    };
    let determinant = |q: DVec2| {
        let step = 1e-6;
        let by_x = (raw(q + DVec2::X * step) - raw(q - DVec2::X * step)) / (2.0 * step);
        let by_y = (raw(q + DVec2::Y * step) - raw(q - DVec2::Y * step)) / (2.0 * step);
        by_x.perp_dot(by_y)
    };
    let mut chance = Chance(3);
    let mut counts = [0, 0];
    for _ in 0..2000 {
        let q = DVec2::from_angle(2.0 * PI * chance.next()) * (0.8 + 0.4 * chance.next());
        let size = determinant(q);
        if size.abs() > 1e-6 {
            assert_eq!(camera.project(q.extend(1.0)).is_ok(), size > 0.0, "{q}: {size}");
            counts[usize::from(size > 0.0)] += 1;
        }
    }
    assert!(counts[0] > 500 && counts[1] > 500, "{counts:?}");
}

#[test]
fn directions_and_points_outside_have_a_reason() {
    let pinhole = made(Model::OpenCv, &[]).unwrap();
    assert_eq!(pinhole.project(DVec3::new(1.0, 0.0, -1e-9)), Err(Outside::Projection));
    assert_eq!(pinhole.project(DVec3::ZERO), Err(Outside::NotFinite));
    assert_eq!(pinhole.project(DVec3::new(f64::NAN, 0.0, 1.0)), Err(Outside::NotFinite));
    assert_eq!(pinhole.unproject(DVec2::new(f64::INFINITY, 0.0)), Err(Outside::NotFinite));
    assert!(pinhole.project(DVec3::new(1e-300, 0.0, 1e-300)).is_ok());
    let tilted = made(Model::OpenCv, &[("tau_y", 1.2)]).unwrap();
    let mut lost = (-400..400).filter_map(|x| tilted.unproject(DVec2::new(f64::from(x) * 100.0, 0.0)).err());
    assert_eq!(lost.next_back(), Some(Outside::Horizon));
    let sphere = made(Model::Fisheye, &[]).unwrap();
    assert_eq!(sphere.unproject(DVec2::new(650.0 + 600.0 * 3.2, 470.0)), Err(Outside::Fold));
    assert_eq!(sphere.project(DVec3::NEG_Z), Err(Outside::Projection));
    let double = made(Model::DoubleSphere, &[("alpha", 0.7)]).unwrap();
    assert!(double.unproject(DVec2::new(650.0 + 601.0 * 0.4f64.sqrt().recip(), 470.0)).is_err());
}

#[test]
fn wrong_numbers_are_named() {
    let message = |model: Model, given: &[(&str, f64)]| made(model, given).unwrap_err().to_string();
    assert_eq!(message(Model::OpenCv, &[("fx", 0.0)]), "fx is 0; it must be above zero");
    assert_eq!(message(Model::OpenCv, &[("fy", -600.0)]), "fy is -600; it must be above zero");
    assert_eq!(message(Model::OpenCv, &[("k1", f64::NAN)]), "k1 is NaN, no finite number");
    assert_eq!(
        message(Model::OpenCv, &[("fx", 1.2)]),
        "fx is 1.2 in a picture 1280 pixels wide or high: it counts pixels, not parts of the picture or millimetres"
    );
    assert!(message(Model::OpenCv, &[("cy", 0.51)]).starts_with("cy is 0.51 in a picture 960 pixels"));
    assert!(message(Model::OpenCv, &[("tau_x", FRAC_PI_2)]).starts_with("the sensor is tilted by 1.57"));
    assert!(message(Model::FThetaToAngle, &[("k1", -0.001)]).starts_with("the distortion folds already in the middle"));
    assert!(message(Model::FThetaToPixels, &[]).starts_with("the distortion folds already in the middle"));
    assert!(message(Model::DoubleSphere, &[("alpha", 1.5)]).starts_with("alpha is 1.5; it is between 0 and 1"));
    assert!(message(Model::Fov, &[("omega", 4.0)]).starts_with("omega is 4; it is an angle"));
    assert!(message(Model::TdeRadial, &[("bending", -1.0)]).starts_with("bending is -1"));
    let few = Calibration::new(Model::Fov, SIZE, &[1.0, 2.0]).unwrap_err().to_string();
    assert_eq!(few, "2 parameters where the model fov has 5");
    let none = Calibration::new(Model::Equirectangular, [0, 5], &[]).unwrap_err().to_string();
    assert_eq!(none, "the picture is 0 x 5 pixels; both must be above zero");
}

#[test]
fn an_st_map_is_the_distortion_that_it_was_made_of() {
    let size = [320, 240];
    let p = Model::OpenCv.undistorted([300.0, 300.0], [165.0, 118.0]).unwrap();
    let mut p = p;
    p[4] = -0.15;
    p[6] = 0.002;
    let camera = Calibration::new(Model::OpenCv, size, &p).unwrap();
    let places: Vec<_> = (0..240 * 320)
        .map(|i| {
            let at = DVec2::new(f64::from(i % 320) + 0.5, f64::from(i / 320) + 0.5);
            let d = camera.unproject(at).ok()?;
            let seen = DVec2::new(300.0 * d.x / d.z + 165.0, 300.0 * d.y / d.z + 118.0);
            Some([(seen.x / 320.0) as f32, (1.0 - seen.y / 240.0) as f32])
        })
        .collect();
    let map = Calibration::of_st_map(size, &places, &[300.0, 300.0, 165.0, 118.0]).unwrap();
    let mut chance = Chance(5);
    for _ in 0..500 {
        let point = DVec2::new(320.0 * chance.next(), 240.0 * chance.next());
        let (by_map, by_model) = (map.unproject(point).unwrap(), camera.unproject(point).unwrap());
        // Single precision in the file is 6e-8 of the picture; between pixels cubics differ by as much, and beyond the middles of the last
        // ones, where the map has no numbers, by a hundredth of a pixel.
        let is_within = (point - DVec2::new(160.0, 120.0)).abs().cmplt(DVec2::new(158.0, 118.0)).all();
        let most = if is_within { 1e-6 } else { 3e-5 };
        assert!(apart(by_map, by_model) < most, "{point}: {by_map} is not {by_model}");
        let again = map.project(by_map).unwrap();
        assert!((again - point).length() < 1e-9 * 320.0, "{point} became {again}");
    }
    assert_eq!(map.unproject(DVec2::new(-2.0, 100.0)), Err(Outside::Fold));
    let empty = Calibration::of_st_map(size, &vec![None; 320 * 240], &p[..4]).unwrap_err();
    assert!(empty.to_string().contains("has no place"), "{empty}");
}

#[test]
fn a_survey_says_what_the_picture_shows() {
    let camera = made(Model::OpenCv, &[("cx", 640.0), ("cy", 480.0)]).unwrap();
    let survey = camera.survey();
    assert_eq!((survey.covered, survey.reason, survey.fold_rad), (1.0, None, None));
    assert!((survey.field_rad[0].unwrap() - 2.0 * (640.0f64 / 600.0).atan()).abs() < 1e-12);
    // A circle about the middle, the corners dark: up to where 1 + 3 k1 theta^2 = 0, which lies at a distance of 2/3 theta.
    let k1 = -1.0 / (3.0 * 1.44);
    let camera = made(Model::Fisheye, &[("fy", 600.0), ("cx", 640.0), ("cy", 480.0), ("k1", k1)]).unwrap();
    let survey = camera.survey();
    assert!((survey.fold_rad.unwrap() - 1.2).abs() < 1e-9);
    let circle = PI * (600.0f64 * 0.8).powi(2) / (1280.0 * 960.0);
    // As far as some 64 points over the width can tell.
    assert!((survey.covered - circle).abs() < 0.03, "{survey:?} {circle}");
    assert!((survey.largest_angle_rad - 1.2).abs() < 0.1 && survey.reason == Some(Outside::Fold), "{survey:?}");
}

/// A place beyond the largest number is none.
#[test]
fn places_are_finite() {
    let calibration =
        Calibration::new(Model::OpenCv, SIZE, &Model::OpenCv.undistorted([1e308, 1e308], [650.0, 470.0]).unwrap());
    let calibration = calibration.unwrap();
    assert_eq!(calibration.project(DVec3::new(1.0, 0.0, 1e-3)), Err(Outside::NotFinite));
    assert!(calibration.project(DVec3::Z).is_ok());
    assert!(calibration.focal_px().is_none_or(|focal| focal.iter().all(|f| f.is_finite())));
}
