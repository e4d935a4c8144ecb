//! Lensfun's calibrations beside the results of lensfun's own library (`tests/reference/lensfun`), and names of lenses.

use std::path::Path;

use glam::{DVec2, DVec3};
use petzval_optics::calibration::PhotographicLens;
use petzval_optics::calibration::photographic::{PhotographicError, PhotographicSetting};
use petzval_optics::lensfun::lateral_colour::Channel;
use petzval_optics::lensfun::{Database, LensfunError, Projection};
use serde_json::Value;

const LENSES: &str = include_str!("../../../../tests/reference/lensfun/lenses.xml");
const REFERENCE: &str = include_str!("../../../../tests/reference/lensfun/lensfun.json");

/// Places in mm and light; lensfun was compiled with doubles, and counts in other units on the way.
const SAME: f64 = 1e-9;

fn database() -> Database {
    Database::parse(LENSES, "lenses.xml").unwrap()
}

fn point(value: &Value) -> Option<DVec2> {
    let [x, y] = value.as_array()?.as_slice() else { return None };
    Some(DVec2::new(x.as_f64()?, y.as_f64()?))
}

#[test]
fn calibrations_are_those_of_lensfun() {
    let database = database();
    let settings: Vec<Value> = serde_json::from_str(REFERENCE).unwrap();
    let (mut distortions, mut colours, mut lights) = (0, 0, 0);
    for setting in &settings {
        let number = |key: &str| setting[key].as_f64().unwrap();
        let (crop, focal_mm) = (number("crop"), number("focal_mm"));
        let lens = database.find(setting["model"].as_str().unwrap()).unwrap();
        let distortion = lens.distortion(crop, focal_mm).unwrap();
        let real_focal_mm = number("real_focal_mm");
        assert!((distortion.real_focal_mm - real_focal_mm).abs() < SAME, "{setting}");
        let colour = lens.lateral_colour(crop, focal_mm);
        let vignetting = lens.vignetting(crop, focal_mm, number("f_number"), number("distance_m"));
        for row in setting["points"].as_array().unwrap() {
            let at = point(&row["at_mm"]).unwrap();
            let near = |got: DVec2, key: &str| {
                let want = point(&row[key]).unwrap();
                assert!((got - want).length() < SAME, "{} {focal_mm} {key} at {at}: {got} {want}", lens.model);
            };
            near(distortion.distorted_mm(at), "distorted_mm");
            distortions += 1;
            // A formula that turns back has no way to the places beyond.
            if distortion.radius_mm(at.length()).0 < distortion.radius_mm(distortion.turning_mm().min(1e3)).0 {
                let back = distortion.straight_mm(distortion.distorted_mm(at)).unwrap();
                assert!((back - at).length() < SAME, "{} {focal_mm} back to {at}: {back}", lens.model);
            }
            if let Some(colour) = &colour {
                near(colour.place_mm(Channel::Red, at), "red_mm");
                near(colour.place_mm(Channel::Blue, at), "blue_mm");
                colours += 1;
            }
            // What lensfun multiplies by is one over the light.
            if let (Some(vignetting), Some(gain)) = (&vignetting, row["gain"].as_f64()) {
                let got = 1.0 / vignetting.illumination(at.length()).unwrap();
                assert!((got - gain).abs() < SAME * gain, "{} {focal_mm} light at {at}: {got} {gain}", lens.model);
                lights += 1;
            }
            assert_eq!((colour.is_some(), vignetting.is_some()), (!row["red_mm"].is_null(), !row["gain"].is_null()));
        }
    }
    assert!(distortions >= 75 && colours >= 70 && lights >= 50, "{distortions} {colours} {lights}");
}

/// The film of a crop factor, of 3000 pixels by 2000, so that its diagonal is the sensor's.
fn setting(crop: f64, focal_mm: f64, f_number: f64, distance_m: f64) -> PhotographicSetting {
    let width_mm = petzval_optics::lensfun::FULL_DIAGONAL_MM / crop * 3.0 / 13f64.sqrt();
    PhotographicSetting {
        size_px: [3000, 2000],
        film_mm: [width_mm, width_mm * 2.0 / 3.0],
        focal_mm,
        f_number,
        distance_m,
    }
}

/// Lenses as cameras: directions by the projection's own formula, everything else as lensfun's library has it.
#[test]
fn cameras_are_those_of_lensfun() {
    let database = database();
    let settings: Vec<Value> = serde_json::from_str(REFERENCE).unwrap();
    let (mut seen, mut coloured, mut lit) = (0, 0, 0);
    for value in &settings {
        let number = |key: &str| value[key].as_f64().unwrap();
        let lens = database.find(value["model"].as_str().unwrap()).unwrap();
        let [shortest, longest] = lens.focal_range_mm;
        // Beyond its ends a zoom is no camera.
        if number("focal_mm") < shortest || number("focal_mm") > longest {
            continue;
        }
        let setting = setting(number("crop"), number("focal_mm"), number("f_number"), number("distance_m"));
        let camera = PhotographicLens::new(&lens, &setting).unwrap();
        let mm_per_px = setting.film_mm[0] / 3000.0;
        let centre = DVec2::new(1500.0, 1000.0) + DVec2::from_array(lens.centre) * 1000.0;
        let pixel = |mm: DVec2| mm / mm_per_px + centre;
        // 1e-9 of the picture, as every calibration.
        let near = |got: DVec2, want: DVec2| assert!((got - want).length() < 3e-6, "{} {got} {want}", lens.model);
        for row in value["points"].as_array().unwrap() {
            let straight = point(&row["at_mm"]).unwrap();
            let Some(angle) = lens.projection.unwrap().angle_rad(straight.length() / number("real_focal_mm")) else {
                continue;
            };
            let direction = (straight.normalize_or_zero() * angle.sin()).extend(angle.cos());
            let distorted = point(&row["distorted_mm"]).unwrap();
            if let Ok(found) = camera.calibration.project(direction) {
                near(found, pixel(distorted));
                near(camera.calibration.project(camera.calibration.unproject(found).unwrap()).unwrap(), found);
                seen += 1;
            }
            // The place in red of a point of green.
            for (channel, key) in [(Channel::Red, "red_mm"), (Channel::Blue, "blue_mm")] {
                let (Some(place), Ok(green)) = (point(&row[key]), camera.calibration.unproject(pixel(straight))) else {
                    continue;
                };
                let found = camera.unproject(pixel(place), channel).unwrap();
                assert!((found - green).length() < 1e-8, "{} {found} {green}", lens.model);
                coloured += 1;
            }
            if let Some(gain) = row["gain"].as_f64() {
                let light = camera.illumination(pixel(straight)).unwrap();
                assert!((light * gain - 1.0).abs() < SAME, "{} {light} {gain}", lens.model);
                lit += 1;
            }
        }
    }
    assert!(seen >= 50 && coloured >= 80 && lit >= 30, "{seen} {coloured} {lit}");
}

#[test]
fn what_is_no_camera_says_why() {
    let database = database();
    let zoom = database.find("Nikon Nikkor Z 24-70mm f/4 S").unwrap();
    let error = |setting: PhotographicSetting| PhotographicLens::new(&zoom, &setting).unwrap_err();
    let good = setting(1.0, 35.0, 8.0, f64::INFINITY);
    assert!(PhotographicLens::new(&zoom, &good).is_ok());
    assert!(matches!(error(setting(1.0, 80.0, 8.0, 10.0)), PhotographicError::FocalLength { longest: 70.0, .. }));
    let large = error(setting(0.79, 35.0, 8.0, 10.0)).to_string();
    assert!(large.contains("measured up to 21.6 mm") && large.contains("corner lies at 27.4 mm"), "{large}");
    for (bad, what) in [
        (PhotographicSetting { focal_mm: f64::NAN, ..good }, "focal length"),
        (PhotographicSetting { f_number: 0.0, ..good }, "f-number"),
        (PhotographicSetting { distance_m: -1.0, ..good }, "distance"),
        (PhotographicSetting { film_mm: [f64::INFINITY, 24.0], ..good }, "width"),
    ] {
        assert!(error(bad).to_string().contains(what), "{}", error(bad));
    }
    let panoramic = petzval_optics::lensfun::CalibratedLens { projection: None, ..zoom.clone() };
    assert!(matches!(PhotographicLens::new(&panoramic, &good), Err(PhotographicError::Panoramic(_))));
    // A lens without measurements is a pinhole, and says so.
    let bare = petzval_optics::lensfun::CalibratedLens { sets: Vec::new(), ..zoom };
    let camera = PhotographicLens::new(&bare, &good).unwrap();
    assert_eq!(camera.remarks.len(), 3);
    let direction = camera.calibration.unproject(DVec2::new(2500.0, 1000.0)).unwrap();
    let width_mm = good.film_mm[0];
    assert!((direction - DVec3::new(width_mm / 3.0, 0.0, 35.0).normalize()).length() < 1e-12);
}

#[test]
fn bodies_are_found_as_lenses_are() {
    let text = "<lensdatabase><camera><maker>Nikon Corporation</maker><maker lang=\"en\">Nikon</maker><model>Nikon Z 6</model>\
                <model lang=\"en\">Z 6</model><mount>Nikon Z</mount><cropfactor>1.0</cropfactor></camera>\
                <camera><maker>Nikon</maker><model>Z 50</model><cropfactor>1.529</cropfactor></camera></lensdatabase>";
    let database = Database::parse(text, "my.xml").unwrap();
    assert_eq!(database.body("nikon z 50").unwrap().crop_factor, 1.529);
    assert_eq!(database.body("Z 6").unwrap().name(), "Nikon Z 6");
    let message = |name: &str| database.body(name).unwrap_err().to_string();
    assert_eq!(
        message("Z"),
        "'Z' may be 2 camera bodies of the lensfun database: Nikon Z 50, Nikon Z 6; give more of the name"
    );
    assert!(message("Canon").starts_with("no camera body in the lensfun database is called 'Canon'"));
    let broken = Database::parse("<lensdatabase><camera><cropfactor>0</cropfactor></camera></lensdatabase>", "my.xml");
    assert_eq!(broken.unwrap_err().to_string(), "my.xml:1:15: cropfactor '0' is not a number above zero; write one");
}

#[test]
fn lenses_have_what_the_file_says() {
    let database = database();
    let lens = database.find("sigma 8mm").unwrap();
    assert_eq!(
        (lens.name().as_str(), lens.projection),
        ("Sigma 8mm f/3.5 EX DG Circular", Some(Projection::Equisolid))
    );
    let lens = database.find("PowerShot G12").unwrap();
    let sensor = lens.sets[0].sensor;
    assert!((sensor.aspect_ratio - 4.0 / 3.0).abs() < 1e-15 && sensor.crop_factor == 4.63);
    let zoom = database.find("Nikon Nikkor Z 24-70mm f/4 S").unwrap();
    assert_eq!((zoom.focal_range_mm, zoom.mounts.as_slice()), ([24.0, 70.0], ["Nikon Z".to_owned()].as_slice()));
    assert_eq!((zoom.nearest_marked_mm(24.7), zoom.nearest_marked_mm(60.5)), (24.0, 70.0));
    // Beyond the ends of the zoom the calibration of the end holds; on a larger sensor there is none.
    assert_eq!(zoom.distortion(1.0, 12.0).unwrap().focal_mm, 24.0);
    assert_eq!(zoom.distortion(0.79, 24.0), None);
    assert_eq!(zoom.distortion(1.5, 24.0), zoom.distortion(1.0, 24.0));
}

#[test]
fn a_name_that_is_no_lens_or_several_says_so() {
    let database = database();
    let message = |name: &str| database.find(name).unwrap_err().to_string();
    assert_eq!(
        message("Nikkor Z 24-70mm f/2.8 S"),
        "no lens in the lensfun database is called 'Nikkor Z 24-70mm f/2.8 S'; did you mean Nikon Nikkor Z 24-70mm f/4 S, \
         Nikon AF-S DX Nikkor 35mm f/1.8G, Nikon AF-S VR Zoom-Nikkor 70-300mm f/4.5-5.6G IF-ED?"
    );
    assert!(
        message("nikkor").starts_with("'nikkor' may be 3 lenses of the lensfun database: Nikon "),
        "{}",
        message("nikkor")
    );
    assert!(matches!(database.find("Xyz"), Err(LensfunError::Unknown { .. })));
    assert!(matches!(database.find(""), Err(LensfunError::Unknown { .. })));
}

#[test]
fn what_is_no_database_is_told_with_its_place() {
    let message = |text: &str| Database::parse(text, "my.xml").unwrap_err().to_string();
    assert_eq!(message("<a/>"), "my.xml:1:1: <a> where <lensdatabase> belongs; give a lensfun database");
    assert!(message("not xml").starts_with("my.xml:1:1: this is no XML"), "{}", message("not xml"));
    let lens = |rows: &str| {
        format!("<lensdatabase>\n<lens><model>M</model><calibration>\n{rows}</calibration></lens></lensdatabase>")
    };
    assert_eq!(
        message(&lens("<distortion model=\"ptlens\" focal=\"35\" a=\"abc\"/>")),
        "my.xml:3:1: a=\"abc\" of <distortion> is not a finite number up to 1e9; write one"
    );
    assert_eq!(
        message(&lens("<vignetting model=\"pa\" focal=\"35\" aperture=\"0\" distance=\"1\"/>")),
        "my.xml:3:1: <vignetting> needs aperture above zero"
    );
    assert_eq!(
        message(&lens("<tca model=\"cubic\" focal=\"35\"/>")),
        "my.xml:3:1: the model 'cubic' of <tca> is none that is known of lensfun"
    );
    let nowhere = Database::read(Path::new("/nowhere/at/all")).unwrap_err().to_string();
    assert!(nowhere.starts_with("/nowhere/at/all: cannot be read"), "{nowhere}");
}

/// Names have single blanks, however the file breaks its lines, and a message has one line.
#[test]
fn line_ends_are_blanks() {
    let lens = |inside: &str| {
        let text =
            format!("<lensdatabase><lens><maker>A\n  B</maker><model>\n C\n D </model>{inside}</lens></lensdatabase>");
        Database::parse(&text, "x.xml")
    };
    assert_eq!(lens("").unwrap().lenses()[0].name(), "A B C D");
    for wrong in [
        "<type>fish\neye</type>",
        "<cropfactor>1\n2</cropfactor>",
        "<cropfactor>1e300:1e-300</cropfactor>",
        "<center x=\"1&#10;2\"/>",
        "<a\n",
    ] {
        let message = lens(wrong).unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
    }
}

/// Numbers whose powers are none are refused: a picture's places would be.
#[test]
fn numbers_have_bounds() {
    let row = |row: &str| {
        let text =
            format!("<lensdatabase><lens><model>x</model><calibration>{row}</calibration></lens></lensdatabase>");
        Database::parse(&text, "x.xml").map(|_| ())
    };
    assert!(row("<tca model=\"poly3\" focal=\"35\" br=\"1e-5\"/>").is_ok());
    for wrong in [
        "<tca model=\"poly3\" focal=\"35\" br=\"1e308\"/>",
        "<tca model=\"linear\" focal=\"1e-300\"/>",
        "<distortion model=\"poly3\" focal=\"35\" k1=\"-1e300\"/>",
        "<vignetting model=\"pa\" focal=\"35\" aperture=\"1e-200\" distance=\"1\"/>",
    ] {
        assert!(row(wrong).is_err(), "{wrong}");
    }
}
