//! Glass catalogues: every formula, catalogues beside a lens file, and the data of media.

use petzval_optics::formats::{self, agf, lens, rii};
use petzval_optics::glass::{Catalogue, Dispersion, Medium, line_nm};
use petzval_optics::prescription::NextMedium;

use super::there_and_back::{again, assert_same};
use super::{ZMX, parse};

/// Each formula of the format against an index worked out by hand from it.
#[test]
#[expect(clippy::too_many_lines, reason = "a case for each formula")]
fn every_formula_of_glass_catalogues() {
    let l2 = 0.5875618f64 * 0.5875618;
    let l = 0.5875618f64;
    let x = 1.0 / (l2 - 0.028);
    let cases: [(u32, &[f64], f64); 13] = [
        (
            1,
            &[2.27, -0.01, 0.011, 2e-4, -3e-6, 4e-7],
            (2.27 - 0.01 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3) + 4e-7 / l2.powi(4)).sqrt(),
        ),
        (
            2,
            &[1.0, 0.006, 0.2, 0.02, 1.0, 103.0],
            (1.0 + l2 / (l2 - 0.006) + 0.2 * l2 / (l2 - 0.02) + l2 / (l2 - 103.0)).sqrt(),
        ),
        (
            3,
            &[1.5, 0.003, -1e-5, -0.003, 1e-5, 1e-6],
            1.5 + 0.003 * x - 1e-5 * x * x - 0.003 * l2 + 1e-5 * l2 * l2 + 1e-6 * l2.powi(3),
        ),
        (4, &[0.2, 1.0, 0.1, -0.01, 9.0], (1.2 + l2 / (l2 - 0.01) - 0.01 / (l2 - 81.0)).sqrt()),
        (5, &[1.5, 0.006, 0.0005], 1.5 + 0.006 / l + 0.0005 / l.powf(3.5)),
        (
            6,
            &[1.0, 0.006, 0.2, 0.02, 1.0, 103.0, 0.1, 0.01],
            (1.0 + l2 / (l2 - 0.006) + 0.2 * l2 / (l2 - 0.02) + l2 / (l2 - 103.0) + 0.1 * l2 / (l2 - 0.01)).sqrt(),
        ),
        (7, &[2.2, 0.01, 0.02, 0.003], (2.2 + 0.01 / (l2 - 0.02) - 0.003 * l2).sqrt()),
        (8, &[1.2, 1.0, 0.02, 0.003], (1.2 + l2 / (l2 - 0.02) - 0.003 * l2).sqrt()),
        (9, &[1.2, 1.0, 0.02, 0.1, 80.0], (1.2 + l2 / (l2 - 0.02) + 0.1 * l2 / (l2 - 80.0)).sqrt()),
        (
            10,
            &[2.27, -0.01, 0.011, 2e-4, -3e-6, 4e-7, 1e-8, 2e-9],
            (2.27 - 0.01 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3)
                + 4e-7 / l2.powi(4)
                + 1e-8 / l2.powi(5)
                + 2e-9 / l2.powi(6))
            .sqrt(),
        ),
        (
            11,
            &[0.5, 0.006, 0.2, 0.02, 0.3, 103.0, 0.1, 0.01, 0.2, 0.03],
            (1.0 + 0.5 * l2 / (l2 - 0.006)
                + 0.2 * l2 / (l2 - 0.02)
                + 0.3 * l2 / (l2 - 103.0)
                + 0.1 * l2 / (l2 - 0.01)
                + 0.2 * l2 / (l2 - 0.03))
                .sqrt(),
        ),
        (
            12,
            &[2.27, -0.01, 0.011, 2e-4, -3e-6, 4e-7, 1e-5, 2e-6],
            (2.27 - 0.01 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3)
                + 4e-7 / l2.powi(4)
                + 1e-5 * l2.powi(2)
                + 2e-6 * l2.powi(3))
            .sqrt(),
        ),
        (
            13,
            &[2.27, -0.01, 1e-5, 0.011, 2e-4, -3e-6, 4e-7, 1e-8, 2e-9],
            (2.27 - 0.01 * l2 + 1e-5 * l2 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3)
                + 4e-7 / l2.powi(4)
                + 1e-8 / l2.powi(5)
                + 2e-9 / l2.powi(6))
            .sqrt(),
        ),
    ];
    for (formula, numbers, wanted) in cases {
        let numbers_text: Vec<String> = numbers.iter().map(f64::to_string).collect();
        let text = format!(
            "CC a catalogue\nNM X {formula} 0 {wanted} 50 0 1\nGC\nED 7 8 2.5 0 0\nCD {}\nLD 0.35 2.5\nIT 0.4 0.9 10.0\nIT 0.5 - -\n",
            numbers_text.join(" ")
        );
        let (media, said) = agf::parse(&text, "x.agf").unwrap();
        assert_eq!(said, [], "{formula}");
        let [glass] = media.as_slice() else { panic!("{formula}") };
        assert!((glass.index(line_nm::D) - wanted).abs() < 1e-14, "{formula}: {} {wanted}", glass.index(line_nm::D));
        assert_eq!(glass.range_nm(), [350.0, 2500.0]);
        assert_eq!(glass.index(300.0), glass.index(350.0), "beyond its range it stands still");
        assert!((glass.internal_transmittance(400.0, 20.0).unwrap() - 0.81).abs() < 1e-12);
    }
    let wrong = "NM X 2 0 1.6 50 0 1\nCD 1 0.006 0.2 0.02 1 103\nNM Y 77 0 1.5\nCD 1 2\nNM Z 2 0 1.5\nCD 0 0\n";
    let (media, said) = agf::parse(wrong, "x.agf").unwrap();
    let said: Vec<String> = said.iter().map(ToString::to_string).collect();
    assert_eq!(media.len(), 1);
    assert!(
        said[0].starts_with("x.agf:1:4: 'X': its coefficients make an index of 1.4") && said.len() == 3,
        "{said:?}"
    );
    assert!(said[1].starts_with("x.agf:3:4: 'Y' is left out: formula 77 with 2 coefficients"), "{said:?}");
    for bad in ["", "hello world\n", "NM\n", "NM X\n", "NM X 2\nCD a b\n"] {
        let error = agf::parse(bad, "x.agf").unwrap_err().to_string();
        assert!(error.starts_with("x.agf:"), "{error}");
    }
}

/// A catalogue beside the lens file that names it is read; one elsewhere is not.
#[test]
fn catalogues_beside_the_file() {
    let folder = std::env::temp_dir().join(format!("petzval-formats-{}", std::process::id()));
    let lenses = folder.join("lenses");
    std::fs::create_dir_all(&lenses).unwrap();
    let catalogue = "CC mine\nNM MYGLASS 2 0 1.5168 64.17 0 1\nCD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\nLD 0.3 2.5\n";
    std::fs::write(lenses.join("MINE.AGF"), catalogue).unwrap();
    std::fs::write(folder.join("OUTSIDE.AGF"), catalogue).unwrap();
    let file = ZMX.replace("GLAS F2", "GLAS MYGLASS").replace("GCAT HOYA SCHOTT", "GCAT SCHOTT MINE");
    std::fs::write(lenses.join("a.zmx"), &file).unwrap();
    let reading = formats::read(&lenses.join("a.zmx"), Catalogue::shipped()).unwrap();
    let NextMedium::Medium(medium) = &reading.prescription.surfaces[0].behind else { panic!() };
    assert_eq!(
        (medium.name(), medium.index(line_nm::D)),
        ("MYGLASS", Catalogue::shipped().medium("N-BK7").unwrap().index(line_nm::D))
    );
    assert_same("beside", &reading.prescription, &again(&reading.prescription, lens::write, "x.lens"));
    for elsewhere in ["../OUTSIDE", "..", "/etc/passwd", "OUTSIDE"] {
        std::fs::write(lenses.join("b.zmx"), file.replace(" MINE", &format!(" {elsewhere}"))).unwrap();
        let error = formats::read(&lenses.join("b.zmx"), Catalogue::shipped()).unwrap_err().to_string();
        assert!(error.contains("unknown glass 'MYGLASS'"), "{error}");
    }
    let rows = "60 6 MYGLASS 30 0 1\n-60 50 air 30 0 0\n";
    std::fs::write(lenses.join("c.lens"), format!("# catalogue: mine.agf\n{rows}")).unwrap();
    assert!(formats::read(&lenses.join("c.lens"), Catalogue::shipped()).is_ok());
    std::fs::write(lenses.join("d.lens"), format!("# catalogue: ../OUTSIDE.AGF\n{rows}")).unwrap();
    let error = formats::read(&lenses.join("d.lens"), Catalogue::shipped()).unwrap_err().to_string();
    assert!(error.contains("d.lens:1:14: '../OUTSIDE.AGF' cannot be read"), "{error}");
    std::fs::remove_dir_all(&folder).unwrap();
}

/// A medium is asked for data that are not known: named, once.
#[test]
fn media_say_what_they_are_known_for() {
    let lens = parse("a.lens", "60 6 robb1983:BAF5 30 0 1\n-60 5 robb1983:BAF5 30 0 0\n60 50 1.5/60 30 0 0\n")
        .unwrap()
        .prescription;
    let beyond: Vec<&str> = lens.media_beyond(380.0, 780.0).into_iter().map(Medium::name).collect();
    assert_eq!(beyond, ["BAF5"]);
    assert!(lens.media_beyond(486.1, 656.3).is_empty());
    let constant = Medium::new("x", Dispersion::Constant(1.5), [f64::NAN, 3.0], "");
    assert_eq!(constant.index(f64::NAN), 1.5);
}

/// Each formula of refractiveindex.info against an index worked out by hand, and its tables.
#[test]
fn every_formula_of_refractiveindex_info() {
    let l = 0.5875618f64;
    let l2 = l * l;
    let x = 1.0 / (l2 - 0.028);
    let retro = 0.2 + 0.06 * l2 / (l2 - 0.01) - 0.001 * l2;
    let cases: [(u32, &[f64], f64); 9] = [
        (1, &[0.1, 1.0, 0.1, 0.3, 9.0], (1.1 + l2 / (l2 - 0.01) + 0.3 * l2 / (l2 - 81.0)).sqrt()),
        (2, &[0.1, 1.0, 0.01, 0.3, 81.0], (1.1 + l2 / (l2 - 0.01) + 0.3 * l2 / (l2 - 81.0)).sqrt()),
        (3, &[2.2, -0.01, 2.0, 0.01, -2.0], (2.2 - 0.01 * l2 + 0.01 / l2).sqrt()),
        (
            4,
            &[2.2, 0.01, 0.0, 0.1, 2.0, 0.02, 2.0, 0.2, 2.0, -0.01, 2.0],
            (2.2 + 0.01 / (l2 - 0.01) + 0.02 * l2 / (l2 - 0.04) - 0.01 * l2).sqrt(),
        ),
        (5, &[1.5, 0.005, -2.0, 0.0001, -4.0], 1.5 + 0.005 / l2 + 0.0001 / l2.powi(2)),
        (
            6,
            &[0.0, 0.05792105, 238.0185, 0.00167917, 57.362],
            1.0 + 0.05792105 / (238.0185 - 1.0 / l2) + 0.00167917 / (57.362 - 1.0 / l2),
        ),
        (
            7,
            &[1.5, 0.003, -1e-5, -0.003, 1e-5, 1e-6],
            1.5 + 0.003 * x - 1e-5 * x * x - 0.003 * l2 + 1e-5 * l2 * l2 + 1e-6 * l2.powi(3),
        ),
        (8, &[0.2, 0.06, 0.01, -0.001], ((1.0 + 2.0 * retro) / (1.0 - retro)).sqrt()),
        (
            9,
            &[2.2, 0.01, 0.02, 0.001, 0.2, 0.1],
            (2.2 + 0.01 / (l2 - 0.02) + 0.001 * (l - 0.2) / ((l - 0.2).powi(2) + 0.1)).sqrt(),
        ),
    ];
    for (formula, numbers, wanted) in cases {
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        let text = format!(
            "REFERENCES: \"x\"\nDATA:\n  - type: formula {formula}\n    wavelength_range: 0.4 0.8\n    coefficients: {}\n  - type: tabulated k\n    data: |\n        0.4 1e-8\n        0.8 2e-8\nSPECS:\n  nd: 1.5\n",
            numbers.join(" ")
        );
        let medium = rii::parse(&text, "X.yml", "X").unwrap();
        assert!((medium.index(line_nm::D) - wanted).abs() < 1e-14, "{formula}: {} {wanted}", medium.index(line_nm::D));
        assert_eq!(medium.range_nm(), [400.0, 800.0]);
        // exp(-4 pi k t / l), k in step with l: the same at both ends.
        let passed = (-4.0 * std::f64::consts::PI * 1e-8 * 5.0 / 0.4e-3f64).exp();
        for nm in [400.0, 800.0] {
            assert!((medium.internal_transmittance(nm, 5.0).unwrap() - passed).abs() < 1e-12);
        }
    }
    let table = "DATA:\n  - type: tabulated nk\n    data: |\n      0.4 1.53 0\n      0.5 1.52 0\n      0.6 1.515 0\n      0.7 1.512 1e-7\n";
    let medium = rii::parse(table, "X.yml", "X").unwrap();
    assert!((medium.index(500.0) - 1.52).abs() < 1e-12 && medium.range_nm() == [400.0, 700.0]);
    assert!(medium.internal_transmittance(700.0, 1.0).unwrap() < 1.0);
    for bad in [
        "",
        "DATA:\n",
        "DATA:\n  - type: formula 12\n    coefficients: 1 2\n",
        "DATA:\n  - type: formula 2\n    coefficients: 1 x\n",
    ] {
        assert!(rii::parse(bad, "X.yml", "X").unwrap_err().to_string().starts_with("X.yml:"));
    }
}
