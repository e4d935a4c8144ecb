use super::*;

/// Points of a picture with the directions of a camera.
fn seen_by(camera: &Calibration) -> Vec<SeenDirection> {
    let [w, h] = camera.size_px().map(f64::from);
    let point = |i: u32| DVec2::new(w * f64::from(i % 17) / 16.0, h * f64::from(i / 17) / 11.0);
    let of = |point_px: DVec2| {
        let direction = camera.unproject(point_px).unwrap_or_else(|why| panic!("{:?}: {why}", camera.model())) * 3.0;
        SeenDirection { point_px, direction, weight: 1.0 / 204.0 }
    };
    (0..204).map(|i| of(point(i))).collect()
}

fn to_fit(model: Model, focal_px: f64, is_symmetric: bool) -> CameraToFit {
    let (size_px, centre_px) = ([480, 320], [240.0, 160.0]);
    CameraToFit { model, size_px, focal_px: [focal_px; 2], centre_px, is_symmetric, coefficients: None }
}

/// Each model's own directions give its parameters back, from a start without distortion and a focal length that is 3 % off.
#[test]
fn a_model_is_found_again() {
    let cases: [(Model, &[f64]); 10] = [
        (Model::OpenCv, &[420.0, 420.0, 240.0, 160.0, -0.3, 0.15, 0.0, 0.0, 0.02]),
        (Model::Fisheye, &[210.0, 210.0, 240.0, 160.0, 0.05, -0.02, 0.012, -0.003]),
        (Model::ThinPrismFisheye, &[300.0, 300.0, 240.0, 160.0, 0.05, -0.02, 0.0, 0.0, 0.012, -0.003]),
        (Model::RadTanThinPrismFisheye, &[300.0, 300.0, 240.0, 160.0, 0.05, -0.02, 0.01, -0.003, 1e-3, -1e-4]),
        (Model::Fov, &[300.0, 300.0, 240.0, 160.0, 0.9]),
        (Model::Division, &[300.0, 300.0, 240.0, 160.0, -0.2]),
        (Model::DoubleSphere, &[300.0, 300.0, 240.0, 160.0, -0.2, 0.6]),
        (Model::Eucm, &[300.0, 300.0, 240.0, 160.0, 0.6, 1.1]),
        (Model::FThetaToPixels, &[240.0, 160.0, 1.0, 0.0, 0.0, 200.0, 0.0, -8.0, 0.0, 0.5]),
        (Model::FThetaToAngle, &[240.0, 160.0, 1.0, 0.0, 0.0, 5e-3, 0.0, 1e-9]),
    ];
    for (model, given) in cases {
        let mut parameters = given.to_vec();
        parameters.resize(model.parameter_names().len(), 0.0);
        let camera = Calibration::new(model, [480, 320], &parameters).unwrap();
        let seen = seen_by(&camera);
        let focal = camera.focal_px().unwrap()[0] * 1.03;
        let found = fit(&to_fit(model, focal, true), &seen).unwrap();
        let off = seen.iter().map(|one| (found.calibration.project(one.direction).unwrap() - one.point_px).length());
        // Coefficients of several powers make up for each other: what counts is where they put the points.
        let worst = off.fold(0.0, f64::max);
        assert!(worst < 1e-5, "{}: {worst} px, {:?}", model.name(), found.calibration.parameters());
        let apart = found.calibration.parameters().iter().zip(&parameters).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 2e-3 * focal, "{}", model.name());
    }
}

/// A camera without symmetry: each focal length, the principal point and the decentring coefficients are found.
#[test]
fn a_decentred_camera_is_found_again() {
    let mut parameters = vec![420.0, 423.0, 243.7, 156.2, -0.3, 0.15, 0.006, -0.005, 0.0];
    parameters.resize(18, 0.0);
    let camera = Calibration::new(Model::OpenCv, [480, 320], &parameters).unwrap();
    let found = fit(&to_fit(Model::OpenCv, 400.0, false), &seen_by(&camera)).unwrap();
    let apart = found.calibration.parameters().iter().zip(&parameters).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-4, "{:?}", found.calibration.parameters());
    assert_eq!(found.free, ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "p1", "p2"]);
}

/// Directions of a fisheye of 140 degrees, to which a polynomial of the tangent is fitted: the fitted model does not fold in the picture.
#[test]
fn what_is_found_does_not_fold() {
    let camera =
        Calibration::new(Model::Fisheye, [480, 320], &[230.0, 230.0, 240.0, 160.0, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    let found = fit(&to_fit(Model::OpenCv, 230.0, true), &seen_by(&camera)).unwrap();
    assert_eq!(found.calibration.survey().covered, 1.0, "{:?}", found.calibration.parameters());
}

/// A fisheye of 75 degrees in the corner, where the best polynomial of the tangent folds: a cost on flat slopes leads nearer than a search that
/// only stops at the fold, which is left with 26 pixels.
#[test]
fn a_fold_is_gone_round() {
    let parameters = [220.0, 220.0, 240.0, 160.0, 0.05, -0.02, 0.0, 0.0, 0.0];
    let seen = seen_by(&Calibration::new(Model::Fisheye, [480, 320], &parameters).unwrap());
    let found = fit(&to_fit(Model::OpenCv, 220.0, true), &seen).unwrap();
    let off = seen.iter().map(|one| found.calibration.project(one.direction).unwrap() - one.point_px);
    let rms_px = (off.map(|off| off.length_squared()).sum::<f64>() / seen.len() as f64).sqrt();
    assert!(rms_px < 13.0, "{rms_px}");
}

#[test]
fn what_cannot_be_fitted_is_named() {
    let fisheye = |focal: f64| {
        let parameters = [focal, focal, 240.0, 160.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        seen_by(&Calibration::new(Model::Fisheye, [480, 320], &parameters).unwrap())
    };
    let wrong = |camera: &CameraToFit, seen: &[SeenDirection]| fit(camera, seen).unwrap_err();
    let opencv = to_fit(Model::OpenCv, 150.0, true);
    // The corners are 288 pixels from the middle.
    assert!(
        matches!(wrong(&opencv, &fisheye(150.0)), FitError::NotSeen { largest_deg, .. } if (largest_deg - 110.2).abs() < 0.1)
    );
    let seen = fisheye(400.0);
    assert!(matches!(wrong(&to_fit(Model::StMap, 400.0, true), &seen), FitError::Model(_)));
    assert_eq!(wrong(&opencv, &seen[..1]), FitError::TooFew { seen: 1, parameters: 4 });
    let asked = CameraToFit { coefficients: Some(vec!["k9".into()]), ..opencv };
    let text = wrong(&asked, &seen).to_string();
    assert!(text.starts_with("the model opencv has no coefficient 'k9'; it has k1, k2, p1"), "{text}");
}
