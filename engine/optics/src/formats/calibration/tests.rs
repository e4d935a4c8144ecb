use super::{Format, parse, write};
use crate::calibration::{Calibration, Model};
use glam::{DVec2, DVec3};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn words(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

#[test]
fn points_are_where_colmap_sees_them() {
    let text = include_str!("../../../../../tests/reference/calibrations/points.json");
    let file: Value = serde_json::from_str(text).unwrap();
    let mut seen = 0;
    for case in file["cases"].as_array().unwrap().iter().filter(|case| case["program"] == "COLMAP") {
        let model = case["model"].as_str().unwrap();
        let line = format!("# a remark\n7 {model} 1280 960 {}\n", words(&numbers(&case["parameters"])));
        let read = parse(&line, "cameras.txt").unwrap();
        assert_eq!((read.format, read.cameras[0].name.as_str()), (Format::Colmap, "7"));
        let camera = &read.cameras[0].calibration;
        for (scene, at) in case["scene"].as_array().unwrap().iter().zip(case["seen"].as_array().unwrap()) {
            let (scene, at) = (DVec3::from_slice(&numbers(scene)), DVec2::from_slice(&numbers(at)));
            let point = camera.project(scene).unwrap();
            assert!((point - at).length() < 1e-9 * 1280.0, "{model}: {point} is not {at}");
            let back = camera.unproject(at).unwrap();
            assert!((back - scene.normalize()).length() < 1e-9, "{model}: {back} is not {scene}");
        }
        seen += 1;
        // Written again it is the same line, but for models that are others' with zeros.
        let again = write(&read.cameras, Format::Colmap).unwrap();
        assert_eq!(again.lines().last(), line.lines().last(), "{model}");
    }
    assert_eq!(seen, 18);
}

const YAML: &str = "%YAML:1.0
---
calibration_time: \"Sat 01 Jan 2022\"
image_width: 640
image_height: 480
board_width: 9
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3e+02, 0., 3.1950000000000000e+02, 0., 5.31e+02,
       2.395e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.8e-01, 6.e-02, 1.e-03, -2.e-04, 0. ]
";

#[test]
fn files_of_opencv_and_ros_are_read() {
    let read = parse(YAML, "camera.yml").unwrap();
    let camera = &read.cameras[0];
    assert_eq!((read.format, camera.name.as_str(), read.remarks.len()), (Format::OpenCvYaml, "camera", 0));
    assert_eq!(camera.calibration.size_px(), [640, 480]);
    let p = camera.calibration.parameters();
    // Half a pixel from the middle of the first to its corner.
    assert_eq!(&p[..9], &[530.0, 531.0, 320.0, 240.0, -0.28, 0.06, 0.001, -0.0002, 0.0]);

    let ros = "image_width: 640\nimage_height: 480\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [400, 0, 319.5, 0, 401, 239.5, 0, 0, 1]\ndistortion_model: equidistant\ndistortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [0.01, -0.02, 0.003, 0]\nnoise_model: none\n";
    let read = parse(ros, "head.yaml").unwrap();
    assert_eq!((read.format, read.cameras[0].calibration.model()), (Format::Ros, Model::Fisheye));
    assert_eq!(read.cameras[0].name, "head");
    assert_eq!(read.remarks, ["line 13: \"noise_model\" is left out"]);

    let message = "header: {seq: 1}\nheight: 480\nwidth: 640\ndistortion_model: rational_polynomial\nD: [0.1, 0.2, 0.0, 0.0, 0.01, 0.3, 0.1, 0.02]\nK: [400, 0, 319.5, 0, 401, 239.5, 0, 0, 1]\nbinning_x: 0\nroi: {x_offset: 0, y_offset: 0}\n";
    let camera = &parse(message, "info.yaml").unwrap().cameras[0];
    assert_eq!(camera.calibration.parameter("k6"), Some(0.02));

    let stereo = "%YAML:1.0\nimage_size: [ 640, 480 ]\nM1: [[530, 0, 319.5], [0, 531, 239.5], [0, 0, 1]]\nD1: [-0.1, 0.01, 0, 0]\nM2: [[530, 0, 319.5], [0, 531, 239.5], [0, 0, 1]]\nD2: [-0.2, 0.01, 0, 0]\n";
    let read = parse(stereo, "intrinsics.yml").unwrap();
    assert_eq!(read.camera(Some("2")).unwrap().calibration.parameter("k1"), Some(-0.2));
    assert!(read.camera(None).unwrap_err().to_string().ends_with("there are 2 cameras; choose one of 1, 2"));
    assert!(read.camera(Some("3")).unwrap_err().to_string().ends_with("there is no camera '3'; there is 1, 2"));
}

#[test]
fn what_is_written_is_read_to_the_last_bit() {
    for used in 4..18 {
        let mut p = Model::OpenCv.undistorted([530.1, 531.7], [320.123_456_789, 240.25]).unwrap();
        for (i, value) in p.iter_mut().enumerate().take(used + 1).skip(4) {
            *value = 1e-3 / (i as f64 + 0.3);
        }
        let calibration = Calibration::new(Model::OpenCv, [640, 480], &p).unwrap();
        let camera = [super::CalibratedCamera { name: "a \"b\"".into(), calibration }];
        for format in [Format::OpenCvYaml, Format::OpenCvJson, Format::Ros] {
            let text = write(&camera, format).unwrap();
            let again = parse(&text, "x").unwrap();
            assert_eq!(again.format, format);
            let (a, b) = (again.cameras[0].calibration.parameters(), camera[0].calibration.parameters());
            // A principal point has half a pixel taken off and put on.
            let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-13 * b.abs();
            assert!(a.iter().zip(b).all(is_near), "{text}");
            assert!(format != Format::Ros || again.cameras[0].name == "a \"b\"");
            assert_eq!(write(&again.cameras, format).unwrap().lines().count(), text.lines().count());
        }
    }
    let fisheye = parse("1 OPENCV_FISHEYE 640 480 400 401 320 240 0.1 0.02 0 0", "c").unwrap().cameras;
    let ros = write(&fisheye, Format::Ros).unwrap();
    assert!(ros.contains("distortion_model: equidistant"));
    assert_eq!(parse(&ros, "x").unwrap().cameras[0].calibration.parameters(), fisheye[0].calibration.parameters());
    let fov = parse("1 FOV 640 480 400 401 320 240 0.9", "c").unwrap().cameras;
    let refused = write(&fov, Format::Ros).unwrap_err().to_string();
    assert_eq!(refused, "camera '1': ROS's YAML has no model like fov; write an ST map of it, or another format");
    let both = [fov[0].clone(), fisheye[0].clone()];
    assert!(write(&both, Format::OpenCvYaml).unwrap_err().to_string().contains("there are 2; choose one of 1, 1"));
    assert!(write(&fov, Format::Basalt).unwrap_err().to_string().contains("only read"));
}

#[test]
fn chains_and_rigs_are_read() {
    let kalibr = "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.76e-05]\n  distortion_model: radtan\n  intrinsics: [458.654, 457.296, 367.215, 248.375]\n  resolution: [752, 480]\ncam1:\n  camera_model: ds\n  intrinsics: [-0.2, 0.59, 180.0, 181.0, 376.0, 240.0]\n  distortion_model: none\n  distortion_coeffs: []\n  resolution: [752, 480]\ncam2:\n  camera_model: omni\n  intrinsics: [1.1, 500.0, 501.0, 376.0, 240.0]\n  distortion_model: radtan\n  distortion_coeffs: [-0.1, 0.0, 0.0, 0.0]\n  resolution: [752, 480]\n";
    let read = parse(kalibr, "camchain.yaml").unwrap();
    let models: Vec<_> = read.cameras.iter().map(|c| (c.name.as_str(), c.calibration.model())).collect();
    assert_eq!(models, [("cam0", Model::OpenCv), ("cam1", Model::DoubleSphere), ("cam2", Model::Omni)]);
    let value = |i: usize, name: &str| read.cameras[i].calibration.parameter(name).unwrap();
    assert_eq!((value(0, "k2"), value(0, "cx"), value(1, "xi"), value(1, "alpha")), (0.07, 367.715, -0.2, 0.59));
    assert_eq!((value(2, "xi"), value(2, "fy"), value(2, "k1")), (1.1, 501.0, -0.1));

    let basalt = r#"{"value0": {"intrinsics": [
	{"camera_type": "ds", "intrinsics": {"fx": 158.2, "fy": 158.3, "cx": 254.9, "cy": 256.8, "xi": -0.17, "alpha": 0.59}},
	{"camera_type": "kb4", "intrinsics": {"fx": 190.0, "fy": 190.1, "cx": 255, "cy": 257, "k1": 0.003, "k2": 0.0007, "k3": -0.002, "k4": 0.0002}}],
	"resolution": [[512, 512], [512, 512]], "vignette": []}}"#;
    let read = parse(basalt, "calibration.json").unwrap();
    assert_eq!((read.format, read.cameras.len(), read.remarks.len()), (Format::Basalt, 2, 0));
    assert_eq!(read.cameras[1].calibration.parameter("k3"), Some(-0.002));

    let rig = r#"{"rig": {"sensors": [{"name": "camera:front", "properties": {"Model": "ftheta", "bw-poly": "0.0 5.35e-4 -1.6e-9 4.7e-12 -4.4e-16 ", "cx": "960.15", "cy": "605.47", "height": "1208", "width": "1920"}},
        {"name": "lidar"}, {"name": "old", "properties": {"Model": "ocam"}}]}}"#;
    let read = parse(rig, "rig.json").unwrap();
    assert_eq!(read.remarks, ["sensor \"old\" is left out: its model is \"ocam\", not ftheta"]);
    let camera = &read.cameras[0];
    assert_eq!((camera.name.as_str(), camera.calibration.model()), ("camera:front", Model::FThetaToAngle));
    // The polynomial by hand, 700 pixels to the right of the middle.
    let angle: f64 = 700.0 * (5.35e-4 + 700.0 * (-1.6e-9 + 700.0 * (4.7e-12 - 700.0 * 4.4e-16)));
    let d = camera.calibration.unproject(DVec2::new(960.15 + 0.5 + 700.0, 605.97)).unwrap();
    assert!((d - DVec3::new(angle.sin(), 0.0, angle.cos())).length() < 1e-12);
}

#[test]
fn nodes_of_3dequalizer_are_read() {
    let node = "Root {\n format \"1920 1080 0 0 1920 1080 1 HD\"\n}\nLD_3DE4_Anamorphic_Standard_Degree_4 {\n direction undistort\n tde4_focal_length_cm 5.0\n tde4_filmback_width_cm 2.1\n tde4_filmback_height_cm 1.76\n tde4_lens_center_offset_x_cm 0.01\n tde4_lens_center_offset_y_cm 0\n tde4_pixel_aspect 2\n field_of_view_xa_unit 0\n field_of_view_xb_unit 1\n Cx02_Degree_2 0.03\n Cy44_Degree_4 -0.004\n Lens_Rotation 0.7\n Squeeze_X 1.02\n name A001\n}\n";
    let read = parse(node, "lens.nk").unwrap();
    let camera = &read.cameras[0];
    assert_eq!((camera.name.as_str(), camera.calibration.model()), ("A001", Model::TdeAnamorphic));
    let value = |name: &str| camera.calibration.parameter(name).unwrap();
    assert_eq!(
        (value("cx02"), value("cy44"), value("rotation_deg"), value("squeeze_x"), value("squeeze_y")),
        (0.03, -0.004, 0.7, 1.02, 1.0)
    );
    assert_eq!((camera.calibration.size_px(), value("pixel_aspect")), ([1920, 1080], 2.0));
    let message = |from: &str, to: &str| parse(&node.replace(from, to), "lens.nk").unwrap_err().to_string();
    assert!(
        message("field_of_view_xb_unit 1", "field_of_view_xb_unit 0.9")
            .contains("lens.nk:13:24: field_of_view_xb_unit is not 1")
    );
    assert!(message("tde4_focal_length_cm 5.0\n", "").contains("has no tde4_focal_length_cm"));
    assert!(message("Anamorphic_Standard", "Anamorphic_Rescaled").contains("is not known; export"));
    assert!(message("Cx02_Degree_2 0.03", "Cx02_Degree_2 {{curve x1 0.03}}").contains("'curve' where a number"));
}

#[test]
fn wrong_files_are_told_by_line_and_column() {
    let message = |from: &str, to: &str| {
        assert!(YAML.contains(from), "{from}");
        parse(&YAML.replace(from, to), "c.yml").unwrap_err().to_string()
    };
    assert_eq!(message("5.3e+02", "5.3x"), "c.yml:11:12: '5.3x' where a number belongs");
    assert_eq!(message("5.3e+02", ".nan"), "c.yml:11:12: '.nan' where a number belongs");
    assert_eq!(
        message("5.3e+02", "0.83"),
        "c.yml:7:16: camera 'camera': fx is 0.83 in a picture 640 pixels wide or high: it counts pixels, not parts of the picture or millimetres"
    );
    assert_eq!(message("-2.8e-01, ", ""), "c.yml:17:10: 4 numbers where 5 x 1 belong");
    let six = YAML.replace("rows: 5", "rows: 6").replace("-2.8e-01, ", "-2.8e-01, 0., ");
    assert_eq!(
        parse(&six, "c.yml").unwrap_err().to_string(),
        "c.yml:13:26: 6 numbers where one of 0, 4, 5, 8, 12 or 14 belong"
    );
    assert!(
        message("image_width: 640\n", "")
            .contains("camera 'camera' has no size of its picture (image_width and image_height); add it")
    );
    assert!(
        message("image_width: 640", "image_width: 640.5")
            .contains("c.yml:4:14: '640.5' where a number of pixels belongs")
    );
    assert!(message("5.3e+02, 0.,", "5.3e+02, 2.,").contains("has a skew of 2"));
    assert!(message("0., 0., 1. ]", "0., 0., 2. ]").contains("is not [fx s cx; 0 fy cy; 0 0 1]"));
    // Broken off before a value it is an error, and before a key at least said.
    let at = YAML.find("distortion_coefficients").unwrap();
    let error = parse(&YAML[..at + 42], "c.yml").unwrap_err().to_string();
    assert!(error.starts_with("c.yml:13:") && error.ends_with("'nothing' where a list of numbers belongs"), "{error}");
    let pinhole = parse(&YAML[..at], "c.yml").unwrap();
    assert_eq!(pinhole.remarks, ["camera 'camera' has no distortion coefficients: it is taken for a pinhole"]);
    // Broken off anywhere, it is named, never read halfway.
    let end = YAML.len() - "-2.8e-01, 6.e-02, 1.e-03, -2.e-04, 0. ]\n".len();
    for cut in (20..YAML.len() - 3).step_by(7) {
        if let Ok(read) = parse(&YAML[..cut], "c.yml") {
            panic!("{cut} of {end}: {:?}", read.cameras[0].calibration.parameters());
        }
    }
    for text in ["", "hello", "[1, 2", "{\"a\": 1}", "- 1\n- 2\n", "cam0: {camera_model: pinhole}", "\u{0}\u{1}"] {
        let error = parse(text, "c").unwrap_err().to_string();
        assert!(error.starts_with("c:") && !error.contains('\n'), "{error}");
    }
    let deep = "[".repeat(100_000);
    assert!(parse(&deep, "c").is_err());
    let colmap = |line: &str| parse(line, "cameras.txt").unwrap_err().to_string();
    assert!(
        colmap("1 PINHOLE 640 480 500 500 320")
            .contains("cameras.txt:1:30: 3 numbers where 4 of PINHOLE (fx fy cx cy) belong")
    );
    assert!(
        colmap("1 PINHOL 640 480 500 500 320 240").starts_with("cameras.txt:1:3: 'PINHOL' where a model of COLMAP")
    );
    assert!(colmap("1 PINHOLE 640 480 500 x 320 240").contains(":1:23: 'x' where a number belongs"));
    assert!(colmap("1 EQUIRECTANGULAR 640 480 640 320").contains("the picture's own size"));
}

/// A name may hold line ends; a message and a written file have their own.
#[test]
fn names_are_of_one_line() {
    let ros = |fx: &str| {
        format!(
            "image_width: 640\nimage_height: 480\ncamera_name: \"a\\nb\"\ncamera_matrix: {{rows: 3, cols: 3, data: [{fx}, 0, 319.5, 0, 401, 239.5, 0, 0, 1]}}\ndistortion_model: plumb_bob\ndistortion_coefficients: {{rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}}\n"
        )
    };
    let read = parse(&ros("400"), "x.yaml").unwrap();
    assert_eq!(read.cameras[0].name, "a b");
    assert_eq!(parse(&write(&read.cameras, Format::Ros).unwrap(), "y.yaml").unwrap().cameras[0].name, "a b");
    for fx in ["-400", "\"4\\n5\""] {
        let message = parse(&ros(fx), "x.yaml").unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
    }
}
