//! Lens files: the good ones read as they stand, every bad one names its place.

use crate::common::{prescription, repository};
use petzval_optics::diaphragm::DiaphragmError;
use petzval_optics::formats::lens::{self, parse, parse_bytes};
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::prescription::NextMedium;
use petzval_optics::surface::{Pose, Section, Shape};
use petzval_optics::system::{FocalLength, LensSettings, System, SystemError};

/// File, line and column of the error, and a word that its message must hold.
const BAD: &[(&str, &str, &str)] = &[
    ("", "1:1", "no surface"),
    ("# name: nothing\n\n", "1:1", "no surface"),
    ("50 5 1.5 20 0 1\n-50 45 air 20 0\n", "2:1", "5 columns"),
    ("50 5 1.5 20 0 1 7\n", "1:17", "7 columns"),
    ("50 5 BK77 20 0 1\n", "1:6", "BK7"),
    ("50 5 schotty 20 0 1\n", "1:6", "unknown glass"),
    ("50 5 1.5/x 20 0 1\n", "1:6", "n/V"),
    ("50 5 -1.5 20 0 1\n", "1:6", "n/V"),
    ("# x\n  fifty 5 1.5 20 0 1\n", "2:3", "radius 'fifty'"),
    ("50 nan 1.5 20 0 1\n", "1:4", "thickness 'nan'"),
    ("inf 5 1.5 20 0 1\n", "1:1", "radius 'inf'"),
    ("50 1e999 1.5 20 0 1\n", "1:4", "thickness"),
    ("50 5 1.5 0 0 1\n", "1:10", "larger than 0"),
    ("50 5,5 1.5 20 0 1\n", "1:4", "write 5.5, with a point"),
    ("50 inf 1.5 20 0 1\n", "1:4", "0 for the radius of a plane"),
    ("radius thickness glass diameter conic isstop\n50 5 1.5 20 0 1\n", "1:1", "write # before it"),
    ("name: a lens\n50 5 1.5 20 0 1\n", "1:1", "write # before it"),
    ("# glass: Mine selmeier 350-2500 0 1.03\n50 5 MINE 20 0 1\n", "1:10", "is no glass"),
    ("# glass: Mine = N-BK77\n50 5 mine 20 0 1\n", "1:10", "did you mean"),
    ("50 5 1.5 -20 0 1\n", "1:10", "larger than 0"),
    ("50 5 1.5 20 k 1\n", "1:13", "conic 'k'"),
    ("50 5 1.5 20 0 yes\n", "1:15", "isstop"),
    ("50 5 1.5 20 0 2\n", "1:15", "isstop"),
    ("#c\n50 5 1.5 20 0 0\n-50 45 air 20 0 0\n", "2:15", "no surface is the stop"),
    ("50 5 1.5 20 0 1\n-50 45 air 20 0 1\n", "2:17", "line 1"),
    ("9 5 1.5 20 0 1\n", "1:9", "reaches only 9 mm"),
    ("1e-320 5 1.5 20 0 1\n", "1:1", "not finite"),
    ("#radius thickness glass diameter conic isstop a1\n50 5 1.5 20 0 1 0\n", "1:47", "'a1'"),
    ("#radius thickness glass diameter conic isstop a21\n50 5 1.5 20 0 1 0\n", "1:47", "'a21'"),
    ("#radius thickness glass diameter conic isstop a4 a6 a4\n50 5 1.5 20 0 1 0\n", "1:53", "second time"),
    ("#radius thickness glass diameter conic isstop a4 a6\n50 5 1.5 20 0 1 0 none\n", "2:19", "a6 'none'"),
    ("#radius thickness glass diameter conic isstop radius_x\n50 5 1.5 20 0 1 9\n", "2:10", "reaches only 9 mm"),
    ("# element: 0-1 decenter=2\n50 5 1.5 20 0 1\n", "1:12", "is no element"),
    ("# element: 1-0 tilt_x=2\n50 5 1.5 20 0 1\n", "1:12", "is no element"),
    ("# element: 0-1 tilt_x=2\n50 5 1.5 20 0 1\n", "1:12", "the last surface is 0"),
    ("#radius thickness diameter glass conic isstop\n", "1:19", "'glass'"),
    ("#radius thickness glass diameter conic isstop obstruction\n50 5 1.5 20 0 1 20\n", "2:17", "obstruction"),
    ("#radius thickness glass diameter conic isstop obstruction\n50 5 1.5 20 0 1\n", "2:1", "6 columns"),
    ("# film_radius: flat\n50 5 1.5 20 0 1\n", "1:16", "film_radius 'flat'"),
    ("# film_radius: 0\n50 5 1.5 20 0 1\n", "1:16", "film's radius"),
    ("# f_number: fast\n50 5 1.5 20 0 1\n", "1:13", "f_number 'fast'"),
    ("# back_focus: far\n50 5 1.5 20 0 1\n", "1:15", "back_focus 'far'"),
    ("# group: large\n50 5 1.5 20 0 1\n", "1:10", "write one of wide angle, normal"),
    ("# first_choice: maybe\n50 5 1.5 20 0 1\n", "1:17", "neither yes nor no"),
    ("# coating: magic\n50 5 1.5 20 0 1\n", "1:12", "unknown coating 'magic'"),
    (
        "#radius thickness glass diameter conic isstop coating\n50 5 1.5 20 0 1 glue:9nm\n",
        "2:17",
        "unknown film 'glue'",
    ),
    ("#radius thickness glass diameter conic isstop coating\n50 5 1.5 20 0 1 MgF2:9\n", "2:17", "write 100nm"),
    ("# film: 36xtall\n50 5 1.5 20 0 1\n", "1:9", "film 'tall'"),
];

#[test]
fn every_bad_file_names_its_place() {
    for (text, place, word) in BAD {
        let error = parse(text, "some.lens", Catalogue::shipped()).expect_err(text).to_string();
        assert!(error.starts_with(&format!("some.lens:{place}: ")), "{text:?}: {error}");
        assert!(error.contains(word), "{text:?}: {error}");
        assert!(!error.contains('\n') && error.contains([';', '?']), "{error}");
    }
}

#[test]
fn files_that_are_no_text_name_their_first_bad_byte() {
    let error = |bytes: &[u8]| parse_bytes(bytes, "x", Catalogue::shipped()).unwrap_err().to_string();
    assert!(error(b"\x7fELF\x02\x01").starts_with("x:1:1: "));
    assert!(error(b"# ok\n50 5 \xff").starts_with("x:2:6: "));
    assert!(error(b"50 5 1.5\0").starts_with("x:1:9: "));
    assert!(error(&vec![b'#'; 2 << 20]).contains("longer"));
    let missing = lens::read("no/such.lens".as_ref(), Catalogue::shipped()).unwrap_err().to_string();
    assert!(missing.starts_with("no/such.lens:1:1: cannot be read"), "{missing}");
}

#[test]
fn what_surrounds_the_table_does_not_matter() {
    let text = "\u{feff}# name: Doublet\r\n# film: 36 x 24\r\n#Radius Thickness Glass Diameter Conic IsStop\r\n\r\n\
                \t50.5  5 n-bk7 20 0.0 1 # crown\r\n-50 -45 MIRROR 20 -1 0";
    let lens = parse(text, "d.lens", Catalogue::shipped()).unwrap();
    assert_eq!(lens.name, "Doublet");
    assert_eq!(lens.metadata.film_mm, Some([36.0, 24.0]));
    assert_eq!(lens.surfaces.len(), 2);
    assert_eq!((lens.surfaces[0].place.line, lens.surfaces[0].place.column), (5, 2));
    assert_eq!(lens.surfaces[1].behind, NextMedium::Mirror);
    assert_eq!(parse("0 5 1.5 20 0 1", "dir/Flat one.lens", Catalogue::shipped()).unwrap().name, "Flat one");
}

#[test]
fn the_header_says_what_the_source_states() {
    use petzval_optics::prescription::LensGroup;
    let text = "# group: Wide Angle\n# first_choice: yes\n# focal_length: not published\n# f_number: 2.8\n# back_focus: 40.1\n\
        # differs: f_number: the rims are modelled\n# differs: zoom: rounded\n50 5 1.5 20 0 1";
    let metadata = parse(text, "header", Catalogue::shipped()).unwrap().metadata;
    assert_eq!((metadata.group, metadata.is_first_choice), (Some(LensGroup::WideAngle), true));
    assert_eq!((metadata.focal_length_mm, metadata.f_number, metadata.back_focus_mm), (None, Some(2.8), Some(40.1)));
    assert_eq!(metadata.text("focal_length"), Some("not published"));
    assert_eq!(metadata.difference("f_number"), Some("the rims are modelled"));
    assert_eq!((metadata.difference("zoom"), metadata.difference("back_focus")), (Some("rounded"), None));
}

#[test]
fn more_columns_say_more_of_a_surface() {
    let text = "# element: 2-3 decenter_x=0.5 tilt_y=90\n\
        #radius thickness glass diameter conic isstop radius_x A4 a20 a3 tilt_x decenter_y obstruction\n\
        50 5 1.5 20 -1 0  50 1e-6 0 2e-5 0 0 3\n\
        50 5 1.5 20  0 0  50 0 0 0 90 -1 0\n\
        50 5 1.5 20  0 1  0 0 0 0 0 0 0\n\
        0 5 air 20  0 0  -80 0 1e-30 0 0 0 0";
    let lens = parse(text, "columns", Catalogue::shipped()).unwrap();
    let [first, second, third, fourth] = &lens.surfaces[..] else { panic!() };
    let Shape::Toroid(toroid) = first.shape else { panic!("{:?}", first.shape) };
    assert_eq!((toroid.across, toroid.profile.terms()), (0.02, vec![(3, 2e-5), (4, 1e-6)]));
    assert_eq!(first.obstruction_mm, 1.5);
    assert_eq!(second.shape, Shape::conic(50.0, 0.0), "both radii alike: a sphere");
    assert_eq!(second.pose, Pose::misaligned([0.0, -1.0], [std::f64::consts::FRAC_PI_2, 0.0, 0.0]));
    let Shape::Toroid(cylinder) = third.shape else { panic!("{:?}", third.shape) };
    assert_eq!((cylinder.across, cylinder.profile.base.curvature), (0.0, 0.02));
    assert_eq!(fourth.shape.curvature_at_vertex(Section::X), -1.0 / 80.0);
    assert_eq!(fourth.shape.profile().terms(), [(20, 1e-30)]);
    assert_eq!(third.pose, Pose::misaligned([0.5, 0.0], [0.0, std::f64::consts::FRAC_PI_2, 0.0]));
    assert_ne!(fourth.pose, third.pose, "it turns about the element's first vertex");
}

#[test]
fn every_shipped_lens_reads_and_names_its_source() {
    let mut count = 0;
    for entry in std::fs::read_dir(repository("lenses")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "lens") {
            let lens = lens::read(&path, Catalogue::shipped()).unwrap_or_else(|e| panic!("{e}"));
            assert!(lens.metadata.source.is_some(), "{}", path.display());
            System::new(&lens, &LensSettings::default()).unwrap();
            count += 1;
        }
    }
    assert!(count >= 50, "{count}");
}

#[test]
fn the_wide_angle_is_the_one_of_figure_3() {
    let shipped = lens::read(&repository("lenses/wide-angle-smith-f3.4.lens"), Catalogue::shipped()).unwrap();
    let reference = prescription("seed-wide-angle");
    let numbers = |p: &petzval_optics::prescription::Prescription| -> Vec<_> {
        p.surfaces.iter().map(|s| (s.shape, s.thickness_mm, s.behind.clone(), s.semi_diameter_mm)).collect()
    };
    assert_eq!(numbers(&shipped), numbers(&reference));
    assert_eq!(shipped.name, "Wide angle f/3.4 (Smith), 100 mm");
}

#[test]
fn settings_that_make_no_lens_say_so() {
    let lens = prescription("biconvex-50mm");
    let with = |settings| System::new(&lens, &settings).unwrap_err();
    let default = LensSettings::default;
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let scale = with(LensSettings { focal_length: FocalLength::Scale(bad), ..default() });
        assert!(matches!(scale, SystemError::NotPositive { .. }));
        let millimetres = with(LensSettings { focal_length: FocalLength::Millimetres(bad), ..default() });
        assert!(matches!(millimetres, SystemError::NotPositive { .. }));
        let f_number = with(LensSettings { f_number: Some(bad), ..default() });
        assert!(matches!(f_number, SystemError::NotPositive { .. }));
    }
    assert_eq!(with(LensSettings { blades: 1000, ..default() }), DiaphragmError::Blades(1000).into());
    for curvature in [-0.1, 1.1, f64::INFINITY] {
        let bent = LensSettings { blade_curvature: curvature, ..default() };
        assert_eq!(with(bent), DiaphragmError::Curvature(curvature).into());
    }
    let window = parse("0 5 1.5 20 0 1\n0 50 air 20 0 0", "window", Catalogue::shipped()).unwrap();
    assert_eq!(
        System::new(&window, &LensSettings { f_number: Some(4.0), ..default() }).unwrap_err(),
        SystemError::Afocal
    );
    assert!(System::new(&window, &default()).unwrap().f_number().is_infinite());
}

#[test]
fn focal_length_and_f_number_are_what_was_asked() {
    use petzval_optics::paraxial::Paraxial;
    for name in ["seed-wide-angle", "newtonian-f5", "eye-navarro"] {
        let settings = LensSettings {
            focal_length: FocalLength::Millimetres(35.0),
            f_number: Some(11.0),
            ..LensSettings::default()
        };
        let system = System::new(&prescription(name), &settings).unwrap();
        let info = Paraxial::new(&system, line_nm::D);
        assert!((info.efl_mm.unwrap() - 35.0).abs() < 1e-12, "{name}");
        assert!((info.f_number.unwrap() - 11.0).abs() < 1e-12, "{name}");
        assert!(!system.f_number_was_clamped());
    }
    let settings = LensSettings { f_number: Some(0.5), ..LensSettings::default() };
    let system = System::new(&prescription("seed-wide-angle"), &settings).unwrap();
    assert!(system.f_number_was_clamped());
    assert_eq!(system.f_number(), system.widest_f_number());
    assert_eq!(system.stop_semi_diameter_mm(), 18.8);
}

/// The header's word is for glass in air, a row's for its own surface; where neither speaks, a single layer is assumed, but not on eyes.
#[test]
fn coatings_are_those_of_the_file() {
    let read = |text: &str| parse(text, "some.lens", Catalogue::shipped()).unwrap();
    let names = |text: &str| -> Vec<String> {
        let system = System::new(&read(text), &LensSettings::default()).unwrap();
        system.surfaces().iter().map(|surface| surface.coating.name().to_owned()).collect()
    };
    let rows = "50 5 1.5 20 0 1\n40 5 1.7 20 0 0\n0 2 air 20 0 0\n0 3 air 20 0 0\n50 5 1.5 20 0 0\n-50 45 air 20 0 0\n";
    assert_eq!(names(rows), ["MgF2", "none", "MgF2", "none", "MgF2", "MgF2"]);
    assert!(read(rows).assumes_coatings());
    let triple = format!("# coating: triple@500\n{rows}");
    assert_eq!(names(&triple), ["triple@500", "none", "triple@500", "none", "triple@500", "triple@500"]);
    assert!(!read(&triple).assumes_coatings());
    assert_eq!(names(&format!("# group: eye\n{rows}")), ["none"; 6]);
    let columns = "# coating: none\n#radius thickness glass diameter conic isstop coating\n50 5 1.5 20 0 1 MgF2:100nm/1.65:0.25w@550\n-50 45 air 20 0 0 -\n";
    assert_eq!(names(columns), ["MgF2:100nm/1.65:0.25w@550", "none"]);
    // Written down they are the same again.
    for text in [rows, &triple, columns] {
        let lens = read(text);
        let (written, lost) = lens::write(&lens, Catalogue::shipped());
        assert!(lost.is_empty() && names(&written) == names(text), "{written}");
        assert_eq!(read(&written).assumes_coatings(), lens.assumes_coatings());
    }
    // A lens that is scaled keeps them.
    let settings = LensSettings { focal_length: FocalLength::Scale(3.0), ..LensSettings::default() };
    let scaled = System::new(&read(columns), &settings).unwrap();
    assert_eq!(
        scaled.surfaces()[0].coating,
        System::new(&read(columns), &LensSettings::default()).unwrap().surfaces()[0].coating
    );
}
