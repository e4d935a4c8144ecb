//! Lens files of other programs: what is read of them is what those programs see, what is written reads back the same, and what
//! is wrong or missing is said in one line.

use std::path::{Path, PathBuf};

use glam::DVec3;
use petzval_optics::formats::{self, LensFileError, Reading, agf, lens, zmx};
use petzval_optics::glass::{Catalogue, Dispersion, Medium, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::{Behind, Prescription};
use petzval_optics::system::{FocalLength, System, SystemSettings};
use petzval_optics::trace::Ray;
use serde_json::Value;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn foreign(name: &str) -> Reading {
    let path = repository("tests/reference/foreign").join(name);
    formats::read(&path, Catalogue::shipped()).unwrap_or_else(|error| panic!("{error}"))
}

fn parse(name: &str, text: &str) -> Result<Reading, LensFileError> {
    formats::parse_bytes(text.as_bytes(), Path::new(name), Catalogue::shipped(), None)
}

fn refused(name: &str, text: &str) -> String {
    let error = parse(name, text).map(|reading| reading.prescription.name).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

fn remarks(reading: &Reading) -> String {
    reading.remarks.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

fn system(lens: &Prescription) -> System {
    System::new(lens, &SystemSettings::default()).unwrap()
}

// As other packages see it ----------------------------------------------------------------------------------------

fn figures() -> Value {
    serde_json::from_str(&std::fs::read_to_string(repository("tests/reference/foreign/figures.json")).unwrap()).unwrap()
}

fn vector(value: &Value) -> DVec3 {
    let at = |i: usize| value[i].as_f64().unwrap();
    DVec3::new(at(0), at(1), at(2))
}

/// Focal lengths and rays of rayoptics and optiland. Their catalogues print indices to six or seven digits, some of another
/// edition: that is what is allowed.
#[test]
fn other_packages_see_the_same_lens() {
    let figures = figures();
    let (mut files, mut rays) = (0, 0);
    for (name, of_file) in figures.as_object().unwrap() {
        if name.starts_with('_') {
            continue;
        }
        let lens = foreign(name).prescription;
        // Of plastics there are several sources.
        let allowed = if name == "eyepiece.zmx" { 5e-4 } else { 2e-5 };
        let unit_mm = if name == "questar35.seq" { 25.4 } else { 1.0 };
        let system = system(&lens);
        for package in ["rayoptics", "optiland"] {
            let Some(figure) = of_file.get(package) else { continue };
            // optiland takes CODE V's numbers for radii where RDM does not say.
            if package == "optiland" && name == "landscape_lens.seq" {
                continue;
            }
            let nm = figure["wavelength_nm"].as_f64().unwrap();
            let info = Paraxial::new(&system, nm);
            let (efl, wanted) = (info.efl_mm.unwrap().abs(), figure["efl"].as_f64().unwrap().abs() * unit_mm);
            assert!((efl / wanted - 1.0).abs() < allowed, "{name} {package}: {efl} {wanted}");
            let pupil = info.entrance_pupil.diameter_mm.unwrap() / 2.0;
            let wanted = figure["entrance_pupil_radius"].as_f64().unwrap() * unit_mm;
            assert!((pupil / wanted - 1.0).abs() < 1e-4, "{name} {package}: pupil {pupil} {wanted}");
            files += 1;
        }
        let Some(figure) = of_file.get("rayoptics") else { continue };
        let tracer = system.at_wavelength(figure["wavelength_nm"].as_f64().unwrap());
        for ray in figure["rays"].as_array().unwrap() {
            let (origin, direction) = (vector(&ray["origin"]) * unit_mm, vector(&ray["direction"]));
            let mut hits = Vec::new();
            // Behind its obstruction nothing arrives.
            let Ok(out) = tracer.from_scene_recording(Ray { origin, direction: direction.normalize() }, &mut hits) else { continue };
            let wanted: Vec<DVec3> = ray["hits"].as_array().unwrap().iter().map(|hit| vector(hit) * unit_mm).collect();
            // Planes that mean nothing are no surfaces here; a ray that slants starts elsewhere without them.
            assert!(hits.len() <= wanted.len());
            if hits.len() < wanted.len() && direction.y != 0.0 {
                continue;
            }
            if hits.len() == wanted.len() {
                for (i, (hit, wanted)) in hits.iter().zip(&wanted).enumerate() {
                    let local = *hit - DVec3::Z * system.vertex_z_mm(i);
                    assert!((local - *wanted).length() < allowed * wanted.length().max(1.0), "{name} {i}: {local} {wanted}");
                }
                rays += 1;
            }
            let slope = (out.direction - vector(&ray["out"])).length();
            assert!(slope < allowed, "{name}: {} {}", out.direction, ray["out"]);
        }
    }
    assert!(files >= 13 && rays >= 25, "{files} {rays}");
}

/// US 2015/0146085, example 1, as the Optical Bench tabulates it: focal length in each position as published, to the rounding of
/// its distances (0.01 mm), and light through the lens in all of them.
#[test]
fn a_published_zoom_has_its_focal_lengths() {
    let reading = foreign("canon-11-24.txt");
    let lens = &reading.prescription;
    let moving = lens.moving.as_ref().unwrap();
    assert_eq!(moving.zoom_range_mm(), Some([11.33, 23.28]));
    assert_eq!(moving.positions().len(), 3);
    assert_eq!(lens.surfaces.len(), 30);
    assert_eq!(lens.surfaces[3].shape.profile().terms()[1], (6, -6.27286e-8));
    assert_eq!(lens.metadata.half_field_deg, Some(62.36));
    for (zoom_mm, back_mm) in [(11.33, 39.88), (17.32, 52.64), (23.28, 65.40)] {
        let settings = SystemSettings { focal_length: FocalLength::Millimetres(zoom_mm), ..Default::default() };
        let system = System::new(lens, &settings).unwrap();
        let fixed = lens.at_position(zoom_mm, 0.0);
        let info = Paraxial::new(&self::system(&fixed), line_nm::D);
        assert!((info.efl_mm.unwrap() / zoom_mm - 1.0).abs() < 1e-3, "{zoom_mm}: {:?}", info.efl_mm);
        assert!((info.bfd_mm.unwrap() - back_mm).abs() < 0.06, "{zoom_mm}: {:?}", info.bfd_mm);
        let tracer = system.at_wavelength(line_nm::D);
        assert!(tracer.from_scene(Ray { origin: DVec3::new(0.0, 0.5, -10.0), direction: DVec3::Z }).is_ok());
    }
    assert!(remarks(&reading).contains("the stop opens with the zoom, to 18.91 mm"), "{}", remarks(&reading));
}

/// A prime that is focused by a group inside, three ways to write its distances.
#[test]
fn a_table_with_near_objects_moves_its_groups() {
    let table = "[descriptive data]\ntitle\tTest\n[constants]\nAsphericalA2\n[variable distances]\nFocal Length\t50\tundefined\n\
        F-Number\t4\t4\nMagnification\t0\t-0.1\nd0\tInfinity\t500\nd2\t2.0\t5.5\t+3.5\nBf\t40\t36.5\n[lens data]\n\
        1\t40\t5\t1.51680\t20\t64.2\tN-BK7\tschott\n2\t-60\td2\t\t20\n3AS\tAS\t1\t\t12\n4\t-45\t2\t1.62\t14\t36\n5\t90\tBf\t\t14\n\
        [aspherical data]\n2\t-60\t-1\t1e-5\t2e-7\n";
    let reading = parse("prime.txt", table).unwrap();
    let lens = &reading.prescription;
    let moving = lens.moving.as_ref().unwrap();
    assert_eq!((moving.surfaces(), moving.zoom_range_mm()), (&[1, 4][..], None));
    assert_eq!(moving.positions()[1].focus_mm, 500.0);
    assert_eq!(moving.positions()[1].gaps_mm, [5.5, 36.5]);
    assert_eq!(lens.surfaces[1].thickness_mm, 2.0);
    assert_eq!(lens.surfaces[1].shape.profile().terms(), [(2, 1e-5), (4, 2e-7)]);
    assert_eq!(lens.surfaces[1].shape.profile().base.conic, -1.0);
    assert_eq!(lens.stop, 2);
    let Behind::Medium(glass) = &lens.surfaces[0].behind else { panic!() };
    assert_eq!(glass.name(), "N-BK7");
    // Named lines, and a radius that is not that of its surface.
    let error = refused("x.txt", &table.replace("\t-60\td2", "\t-60\td3"));
    assert!(error.starts_with("x.txt:14:7: 'd3' where a number"), "{error}");
    let other = parse("x.txt", &table.replace("2\t-60\t-1", "2\t-61\t-1")).unwrap();
    assert!(remarks(&other).contains("radius -61 is not that of the surface"));
    let odd = parse("x.txt", &table.replace("AsphericalA2", "AsphericalOddCount\t1")).unwrap();
    assert_eq!(odd.prescription.surfaces[1].shape.profile().terms(), [(3, 1e-5), (4, 2e-7)]);
}

// There and back ---------------------------------------------------------------------------------------------------

/// All that a ray meets is the same, to the last bit.
fn assert_same(name: &str, a: &Prescription, b: &Prescription) {
    assert_eq!(a.surfaces.len(), b.surfaces.len(), "{name}");
    for (i, (a, b)) in a.surfaces.iter().zip(&b.surfaces).enumerate() {
        assert_eq!(a.shape, b.shape, "{name} {i}");
        assert_eq!(a.thickness_mm.to_bits(), b.thickness_mm.to_bits(), "{name} {i}");
        assert_eq!(a.semi_diameter_mm, b.semi_diameter_mm, "{name} {i}");
        assert_eq!(a.obstruction_mm, b.obstruction_mm, "{name} {i}");
        match (&a.behind, &b.behind) {
            (Behind::Mirror, Behind::Mirror) => {}
            (Behind::Medium(a), Behind::Medium(b)) => {
                for nm in [300.0, 365.0, 404.7, 486.1, 550.0, 587.6, 656.3, 780.0, 1014.0] {
                    assert_eq!(a.index(nm).to_bits(), b.index(nm).to_bits(), "{name} {i} {a:?} {b:?}");
                    assert_eq!(a.internal_transmittance(nm, 3.0), b.internal_transmittance(nm, 3.0));
                }
                assert_eq!(a.range_nm(), b.range_nm(), "{name} {i} {a:?}");
            }
            _ => panic!("{name} {i}"),
        }
    }
    assert_eq!((a.stop, a.film_radius_mm), (b.stop, b.film_radius_mm), "{name}");
    assert_eq!(a.moving, b.moving, "{name}");
    assert_eq!(a.name, b.name);
    let said = |lens: &Prescription| (lens.metadata.f_number, lens.metadata.half_field_deg, lens.metadata.film_mm);
    assert_eq!(said(a), said(b), "{name}");
}

fn shipped() -> Vec<(String, Prescription)> {
    let files = std::fs::read_dir(repository("lenses")).unwrap().map(|entry| entry.unwrap().path());
    let lenses: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|ending| ending == "lens"))
        .map(|path| (path.display().to_string(), lens::read(&path, Catalogue::shipped()).unwrap()))
        .collect();
    assert!(lenses.len() >= 40);
    lenses
}

fn again(lens: &Prescription, write: fn(&Prescription, &Catalogue) -> (String, Vec<String>), name: &str) -> Prescription {
    let (text, _) = write(lens, Catalogue::shipped());
    parse(name, &text).unwrap_or_else(|error| panic!("{error}\n{text}")).prescription
}

#[test]
fn lens_files_come_back() {
    for (name, lens) in shipped() {
        let (text, lost) = lens::write(&lens, Catalogue::shipped());
        assert_eq!(lost, [] as [String; 0], "{name}");
        let rows = text.lines().filter(|line| !line.starts_with('#'));
        assert!(rows.into_iter().all(|row| !row.starts_with("1/")), "{name}: a radius was not found again\n{text}");
        let back = again(&lens, lens::write, "x.lens");
        assert_same(&name, &lens, &back);
        for (a, b) in lens.surfaces.iter().zip(&back.surfaces) {
            assert_eq!(a.pose, b.pose);
            assert_eq!(a.behind, b.behind, "{name}: the glass keeps its name and maker");
        }
    }
}

#[test]
fn zemax_files_come_back() {
    for (name, lens) in shipped() {
        let back = again(&lens, zmx::write, "x.zmx");
        assert_same(&name, &lens, &back);
        // And once more through the other.
        assert_same(&name, &lens, &again(&back, lens::write, "x.lens"));
    }
}

#[test]
fn files_of_other_programs_come_back() {
    for name in ["ag_dblgauss.seq", "questar35.seq", "schmidt.seq", "eyepiece.zmx", "planar-1897.zmx", "cooke.len", "canon-11-24.txt"] {
        let lens = foreign(name).prescription;
        assert_same(name, &lens, &again(&lens, lens::write, "x.lens"));
        assert_same(name, &lens, &again(&lens, zmx::write, "x.zmx"));
    }
}

/// Curvatures that are one over no number, decentred elements, odd and high powers, private glasses.
#[test]
fn what_is_rare_comes_back_too() {
    let text = "# name: rare\n# glass: OWN rational 400-700 2.1 1 -0.01 2 0.3 2 0.01\n# transmittance: OWN 400:0.9@10 700:0.99@25\n\
        # glass: T table 350-800 0.35 1.6 0.5 1.58 0.6 1.57 0.8 1.56\n# element: 1-2 decenter_x=0.05 tilt_y=0.1\n\
        #radius thickness glass diameter conic isstop obstruction radius_x a3 a4 a20 tilt_z\n\
        1/0.0123456789012345 3 OWN 10 -0.5 0 1 0 1e-5 0 1e-25 0\n-33.3 2 T 10 0 1 0 -20 0 1e-6 0 3\n\
        -77.7 50 hikari:SF11 10 0 0 0 -77.7 0 0 0 0\n";
    let lens = parse("rare.lens", text).unwrap().prescription;
    let back = again(&lens, lens::write, "x.lens");
    assert_same("rare", &lens, &back);
    for (a, b) in lens.surfaces.iter().zip(&back.surfaces) {
        // Angles go through degrees.
        let (a, b) = (a.pose.parts(), b.pose.parts());
        let far = [a.0, a.1].as_flattened().iter().zip([b.0, b.1].as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(far < 1e-15, "{a:?} {b:?}");
    }
    let (_, lost) = zmx::write(&lens, Catalogue::shipped());
    assert!(lost.iter().any(|what| what.contains("surface 1 stands beside its place")), "{lost:?}");
    // All curvatures that a Zemax file may hold.
    for i in 0..500 {
        let curvature = 0.01 + f64::from(i) * 1.234_567_891e-5;
        let file = format!(
            "MODE SEQ\nUNIT MM\nENPD 5\nSURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  CURV {curvature}\n  DISZ 2\n  GLAS N-BK7\n  DIAM 5\n\
             SURF 2\n  DISZ 40\n  DIAM 5\nSURF 3\n"
        );
        let lens = parse("c.zmx", &file).unwrap().prescription;
        assert_same("curvature", &lens, &again(&lens, lens::write, "x.lens"));
    }
}

// Encodings, glasses, apertures ------------------------------------------------------------------------------------

const ZMX: &str = "VERS 1\nMODE SEQ\nNAME Täst\nUNIT MM X W X CM MR CPMM\nENPD 10\nGCAT HOYA SCHOTT\nFTYP 0 0 2 1 0 0 0\n\
    YFLN 0 10\nWAVM 1 0.5875618 1\nPWAV 1\nSURF 0\n  TYPE STANDARD\n  CURV 0 0 0 0 0 \"\"\n  DISZ INFINITY\n\
    SURF 1\n  STOP\n  TYPE STANDARD\n  CURV 2.0E-002 0 0 0 0 \"\"\n  DISZ 4\n  GLAS F2 0 0 1.5 40 0 0 0 0 0 0\n  DIAM 6 1 0 0 1 \"\"\n  MEMA 12.7 0 0 0 1 \"\"\n\
    SURF 2\n  TYPE EVENASPH\n  CURV -0.02 0\n  PARM 1 1e-4\n  PARM 2 2e-6\n  CONI -1.5\n  DISZ 45\n  DIAM 6.5 1 0 0 1 \"\"\nSURF 3\n  CURV -0.01\n  DISZ 0\n";

#[test]
fn zemax_files_in_every_encoding() {
    let plain = parse("a.zmx", ZMX).unwrap().prescription;
    assert_eq!(plain.name, "Täst");
    let units: Vec<u16> = ZMX.encode_utf16().collect();
    let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
    let latin: Vec<u8> = ZMX.chars().map(|c| c as u8).collect();
    let marked = |mark: [u8; 2], bytes: &[u8]| [&mark, bytes].concat();
    let windows = ZMX.replace('\n', "\r\n").into_bytes();
    for bytes in [marked([0xff, 0xfe], &little), marked([0xfe, 0xff], &big), little, big, latin, windows] {
        let read = formats::parse_bytes(&bytes, Path::new("a.zmx"), Catalogue::shipped(), None).unwrap().prescription;
        assert_eq!(read.surfaces, plain.surfaces);
        assert_eq!(read.name, "Täst");
    }
}

/// DIAM is the clear half diameter, MEMA that of the mount; the stop is as wide as the beam.
#[test]
fn zemax_numbers_are_where_they_belong() {
    let lens = parse("a.zmx", ZMX).unwrap().prescription;
    assert_eq!(lens.surfaces.len(), 2);
    assert_eq!(lens.surfaces[0].semi_diameter_mm, 5.0);
    assert_eq!(lens.surfaces[1].semi_diameter_mm, 6.5);
    assert_eq!(lens.surfaces[1].shape.profile().terms(), [(2, 1e-4), (4, 2e-6)]);
    assert_eq!(lens.surfaces[1].shape.profile().base.conic, -1.5);
    assert_eq!(lens.film_radius_mm, Some(-100.0));
    assert_eq!(lens.metadata.half_field_deg, Some(10.0));
    // Schott and Hikari have F2; the file lists Hoya, which has none, and Schott.
    let glass = |text: &str| {
        let reading = parse("a.zmx", text).unwrap();
        let Behind::Medium(medium) = reading.prescription.surfaces[0].behind.clone() else { panic!() };
        (medium, remarks(&reading))
    };
    let catalogue = Catalogue::shipped();
    let (f2, said) = glass(ZMX);
    assert_eq!((f2, said.as_str()), (catalogue.medium("schott:F2").unwrap(), ""));
    let sf11 = ZMX.replace("GLAS F2", "GLAS SF11");
    assert_eq!(glass(&sf11.replace("GCAT HOYA SCHOTT", "GCAT NIKON-HIKARI")).0, catalogue.medium("hikari:SF11").unwrap());
    let (_, said) = glass(&ZMX.replace("GCAT HOYA SCHOTT", "GCAT HOYA"));
    assert!(said.contains("a.zmx:20:8: 'F2' stands in none of the file's catalogues (HOYA); that of schott"), "{said}");
    let (_, said) = glass(&ZMX.replace("GCAT HOYA SCHOTT", "GCAT ../../etc/SCHOTT SCHOTT"));
    assert!(said.contains("'../../etc/SCHOTT' is not known"), "{said}");
    let (model, _) = glass(&ZMX.replace("GLAS F2 0 0 1.5 40", "GLAS ___BLANK 1 0 1.52 64.1"));
    assert!((model.index(line_nm::D) - 1.52).abs() < 1e-12 && (model.abbe() - 64.1).abs() < 1e-9);
    // In inches all lengths are larger, and so are the coefficients' units.
    let inches = parse("a.zmx", &ZMX.replace("UNIT MM", "UNIT IN")).unwrap().prescription;
    let [a, b] = [&lens, &inches].map(|lens| Paraxial::new(&system(lens), line_nm::D).efl_mm.unwrap());
    assert!((b / a - 25.4).abs() < 1e-9, "{a} {b}");
    assert_eq!(inches.surfaces[0].semi_diameter_mm, 127.0);
}

#[test]
fn what_zemax_files_have_and_lenses_have_not() {
    let coordinate = "SURF 2\n  TYPE COORDBRK\n  PARM 3 10\n  DISZ 0\nSURF 3\n";
    let cases = [
        (ZMX.replace("MODE SEQ", "MODE NSC"), "a.zmx:2:1: mode NSC: only sequential lenses"),
        (ZMX.replace("TYPE EVENASPH", "TYPE BINARY_2"), "a.zmx:24:3: surface type 'BINARY_2' is not supported"),
        (ZMX.replace("SURF 3\n", coordinate), "a.zmx:33:3: a coordinate break tilts or decentres what follows (PARM 3 = 10)"),
        (ZMX.replace("GLAS F2", "GLAS F2X9Q"), "a.zmx:20:8: unknown glass 'F2X9Q'"),
        (ZMX.replace("GLAS F2", "GLAS L-BAL35_MOLD"), "a.zmx:20:8: unknown glass 'L-BAL35_MOLD'; did you mean L-BAL35?"),
        (ZMX.replace("CURV 2.0E-002", "CURV nan"), "a.zmx:18:8: CURV 'nan' is not a finite number"),
        (ZMX.replace("DISZ 45", "DISZ 1e999"), "a.zmx:29:8: DISZ '1e999' is not a finite number"),
        (ZMX.replace("UNIT MM", "UNIT ELL"), "a.zmx:4:1: 'ELL' where MM, CM, IN or METER belongs"),
        ("MODE SEQ\nSURF 0\n".to_owned(), "a.zmx:1:1: there is no lens"),
        (String::new(), "a.zmx:1:1: there is no lens"),
    ];
    for (text, wanted) in cases {
        let error = refused("a.zmx", &text);
        assert!(error.starts_with(wanted), "{error}");
    }
    let said = remarks(&parse("a.zmx", &ZMX.replace("  STOP\n", "  STOP\n  QTYP 1\n  COAT AR\n")).unwrap());
    assert_eq!(said, "a.zmx:17:3: 'QTYP' is not understood and left out\na.zmx:18:3: coatings are left out");
}

#[test]
fn code_v_numbers_are_where_they_belong() {
    let text = "RDM;LEN \"VERSION\"\nTITLE 'Sample ! no remark'\nEPD 10.0; DIM M\nWL 656.3 587.6 486.1\nREF 2\nYAN 0.0 5.0 ! fields\n\
        PRV\n  PWL 656.3 587.6 486.1\n  'MINE' 1.6 1.605 1.615\nEND\n\
        SO 0.0 0.1e14\nS 50.0 4.0 517.642\n  CIR 6.0\n  CIR EDG 7.0\nS -50.0 1.0 'mine'\n  ASP\n  K -0.5; A 0.1D-5; B -0.2E-8&\n  ; C 1e-12\n\
        S 0.0 3.0\nSTO\nS -80 2 SF11_HIKARI\nS 0 40.0\nPIM\nSI 0.0 0.25\nCIR S1 6.5\nGO\nwhatever follows\n";
    let reading = parse("a.seq", text).unwrap();
    let lens = &reading.prescription;
    assert_eq!(lens.name, "Sample ! no remark");
    assert_eq!((lens.surfaces.len(), lens.stop), (5, 2));
    assert_eq!(lens.surfaces[0].semi_diameter_mm, 6.5);
    assert_eq!(lens.surfaces[4].thickness_mm, 40.25);
    let asphere = lens.surfaces[1].shape.profile();
    assert_eq!((asphere.base.conic, asphere.terms()), (-0.5, vec![(4, 1e-6), (6, -2e-9), (8, 1e-12)]));
    let index = |i: usize, nm: f64| match &lens.surfaces[i].behind {
        Behind::Medium(medium) => medium.index(nm),
        Behind::Mirror => panic!(),
    };
    assert!((index(0, line_nm::D) - 1.517).abs() < 1e-12);
    assert!((index(1, 656.3) - 1.6).abs() < 1e-12 && (index(1, 486.1) - 1.615).abs() < 1e-12);
    assert_eq!(index(3, 500.0), Catalogue::shipped().medium("hikari:SF11").unwrap().index(500.0));
    let cases = [
        (text.replace("SF11_HIKARI", "NBK7_OHARA"), "a.seq:21:9: unknown glass 'NBK7"),
        (text.replace("STO\n", "STO\nADE 5.0\n"), "a.seq:21:1: 'ADE' tilts, moves or reshapes"),
        (text.replace("S 50.0", "S fifty"), "a.seq:12:3: radius 'fifty' is not a finite number"),
        (text.replace("SI 0.0 0.25", "S 0.0 0.25"), "a.seq:12:1: there is no film"),
        (text.replace("1.6 1.605 1.615", "1.6 1.605"), "a.seq:9:3: '2' where 3 indices"),
    ];
    for (text, wanted) in cases {
        let error = refused("a.seq", &text);
        assert!(error.starts_with(wanted), "{error}");
    }
}

#[test]
fn oslo_numbers_are_where_they_belong() {
    let text = "// OSLO 6.6 1 0 0\nLEN NEW \"A lens\" 100 4\nEBR 5.0\nANG 10\nUNI 10.0\nTH 1.0e20\nNXT // SRF 1\nGLA N-BK7\nRD 50\nTH 4.0\nAP CHK 6\n\
        NXT // SRF 2\nAIR\nCV -0.02\nCC -0.5\nAD 1e-6\nAE -2e-9\nTH 3\nNXT\nAIR\nTH 1\nAST\nNXT\nWV 0.58756 0.48613 0.65627\n\
        GLA MOD M1 1.6 1.61 1.595\nRD -80\nASP ASR 2\nAS2 1e-7\nTH 2\nNXT\nRFL\nTH -30\nNXT\nEND 6\n";
    let reading = parse("a.len", text).unwrap();
    let lens = &reading.prescription;
    assert_eq!((lens.name.as_str(), lens.surfaces.len(), lens.stop), ("A lens", 5, 2));
    // A unit is a centimetre.
    assert_eq!(lens.surfaces[0].semi_diameter_mm, 60.0);
    assert_eq!(lens.surfaces[1].shape.profile().base.curvature, -0.002);
    let terms = lens.surfaces[1].shape.profile().terms();
    assert!((terms[0].1 / 1e-9 - 1.0).abs() < 1e-12 && (terms[1].1 / -2e-14 - 1.0).abs() < 1e-12, "{terms:?}");
    assert_eq!(lens.surfaces[3].shape.profile().terms()[0].0, 4);
    assert_eq!(lens.surfaces[4].behind, Behind::Mirror);
    let Behind::Medium(model) = &lens.surfaces[3].behind else { panic!() };
    assert!((model.index(486.13) - 1.61).abs() < 1e-12);
    let cases = [
        (text.replace("AST\n", "TLA 5\n"), "a.len:22:1: 'TLA 5' cannot be read from .len"),
        (text.replace("END 6", ""), "a.len:1:1: there is no line END"),
        (text.replace("RD -80", "RD x"), "a.len:26:4: RD 'x' is not a finite number"),
        (text.replace("GLA N-BK7", "GLA N-QQ7"), "a.len:8:5: unknown glass 'N-QQ7'"),
        (text.replace("ASP ASR 2", "ASP ZER 2"), "a.len:27:1: aspheres of kind 'ZER'"),
    ];
    for (text, wanted) in cases {
        let error = refused("a.len", &text);
        assert!(error.starts_with(wanted), "{error}");
    }
}

#[test]
fn tables_of_renderers() {
    let dat = "# A lens of pbrt\n# radius sep n aperture\n60 6 1.5168 30\n0 2 0 20\n-60 55 1 30\n";
    let lens = parse("a.dat", dat).unwrap().prescription;
    assert_eq!((lens.name.as_str(), lens.surfaces.len(), lens.stop), ("A lens of pbrt", 3, 1));
    assert_eq!(lens.surfaces[1].semi_diameter_mm, 10.0);
    let flare = "name: Flare\nfocal_length: 50\nsurfaces:\n60 6 1.5168 64.17 15 1\nstop 2 1.0 0 10 0\ninf 3 1.6 0 15 0\n-60 55 1 0 15 1\n";
    let reading = parse("a.lens", flare).unwrap();
    assert_eq!((reading.prescription.stop, reading.prescription.metadata.focal_length_mm), (1, Some(50.0)));
    assert_eq!(reading.prescription.surfaces[2].shape.profile().base.curvature, 0.0);
    assert_eq!(remarks(&reading), "a.lens:4:22: coatings are left out (and in 1 more lines)");
    let again = again(&reading.prescription, lens::write, "x.lens");
    assert_same("flare", &reading.prescription, &again);
    for (name, text, wanted) in [
        ("a.dat", "60 6 1.5\n", "a.dat:1:1: '60 6 1.5' where radius, thickness, index and diameter belongs"),
        ("a.dat", "60 6 1.5 30 1\n", "a.dat:1:13:"),
        ("a.dat", "60 6 x 30\n", "a.dat:1:6: index 'x' is not a finite number"),
        ("a.dat", "60 6 15.0 30\n", "a.dat:1:6: '15' is no glass"),
        ("a.lens", "surfaces:\n60 6\n", "a.lens:2:1:"),
        ("a.agf", "CC x\n", "a.agf:1:1: this is a glass catalogue"),
    ] {
        let error = refused(name, text);
        assert!(error.starts_with(wanted), "{error}");
    }
}

// Glass catalogues -------------------------------------------------------------------------------------------------

/// Each formula of the format against an index worked out by hand from it.
#[test]
fn every_formula_of_glass_catalogues() {
    let l2 = 0.5875618f64 * 0.5875618;
    let l = 0.5875618f64;
    let x = 1.0 / (l2 - 0.028);
    let cases: [(u32, &[f64], f64); 13] = [
        (1, &[2.27, -0.01, 0.011, 2e-4, -3e-6, 4e-7], (2.27 - 0.01 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3) + 4e-7 / l2.powi(4)).sqrt()),
        (2, &[1.0, 0.006, 0.2, 0.02, 1.0, 103.0], (1.0 + l2 / (l2 - 0.006) + 0.2 * l2 / (l2 - 0.02) + l2 / (l2 - 103.0)).sqrt()),
        (3, &[1.5, 0.003, -1e-5, -0.003, 1e-5, 1e-6], 1.5 + 0.003 * x - 1e-5 * x * x - 0.003 * l2 + 1e-5 * l2 * l2 + 1e-6 * l2.powi(3)),
        (4, &[0.2, 1.0, 0.1, -0.01, 9.0], (1.2 + l2 / (l2 - 0.01) - 0.01 / (l2 - 81.0)).sqrt()),
        (5, &[1.5, 0.006, 0.0005], 1.5 + 0.006 / l + 0.0005 / l.powf(3.5)),
        (6, &[1.0, 0.006, 0.2, 0.02, 1.0, 103.0, 0.1, 0.01], (1.0 + l2 / (l2 - 0.006) + 0.2 * l2 / (l2 - 0.02) + l2 / (l2 - 103.0) + 0.1 * l2 / (l2 - 0.01)).sqrt()),
        (7, &[2.2, 0.01, 0.02, 0.003], (2.2 + 0.01 / (l2 - 0.02) - 0.003 * l2).sqrt()),
        (8, &[1.2, 1.0, 0.02, 0.003], (1.2 + l2 / (l2 - 0.02) - 0.003 * l2).sqrt()),
        (9, &[1.2, 1.0, 0.02, 0.1, 80.0], (1.2 + l2 / (l2 - 0.02) + 0.1 * l2 / (l2 - 80.0)).sqrt()),
        (10, &[2.27, -0.01, 0.011, 2e-4, -3e-6, 4e-7, 1e-8, 2e-9], (2.27 - 0.01 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3) + 4e-7 / l2.powi(4) + 1e-8 / l2.powi(5) + 2e-9 / l2.powi(6)).sqrt()),
        (11, &[0.5, 0.006, 0.2, 0.02, 0.3, 103.0, 0.1, 0.01, 0.2, 0.03], (1.0 + 0.5 * l2 / (l2 - 0.006) + 0.2 * l2 / (l2 - 0.02) + 0.3 * l2 / (l2 - 103.0) + 0.1 * l2 / (l2 - 0.01) + 0.2 * l2 / (l2 - 0.03)).sqrt()),
        (12, &[2.27, -0.01, 0.011, 2e-4, -3e-6, 4e-7, 1e-5, 2e-6], (2.27 - 0.01 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3) + 4e-7 / l2.powi(4) + 1e-5 * l2.powi(2) + 2e-6 * l2.powi(3)).sqrt()),
        (13, &[2.27, -0.01, 1e-5, 0.011, 2e-4, -3e-6, 4e-7, 1e-8, 2e-9], (2.27 - 0.01 * l2 + 1e-5 * l2 * l2 + 0.011 / l2 + 2e-4 / l2.powi(2) - 3e-6 / l2.powi(3) + 4e-7 / l2.powi(4) + 1e-8 / l2.powi(5) + 2e-9 / l2.powi(6)).sqrt()),
    ];
    for (formula, numbers, wanted) in cases {
        let numbers_text: Vec<String> = numbers.iter().map(f64::to_string).collect();
        let text = format!("CC a catalogue\nNM X {formula} 0 {wanted} 50 0 1\nGC\nED 7 8 2.5 0 0\nCD {}\nLD 0.35 2.5\nIT 0.4 0.9 10.0\nIT 0.5 - -\n", numbers_text.join(" "));
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
    assert!(said[0].starts_with("x.agf:1:4: 'X': its coefficients make an index of 1.4") && said.len() == 3, "{said:?}");
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
    let Behind::Medium(medium) = &reading.prescription.surfaces[0].behind else { panic!() };
    assert_eq!((medium.name(), medium.index(line_nm::D)), ("MYGLASS", Catalogue::shipped().medium("N-BK7").unwrap().index(line_nm::D)));
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

/// A medium is asked for what is not known of it: named, once.
#[test]
fn media_say_what_they_are_known_for() {
    let lens = parse("a.lens", "60 6 robb1983:BAF5 30 0 1\n-60 5 robb1983:BAF5 30 0 0\n60 50 1.5/60 30 0 0\n").unwrap().prescription;
    let beyond: Vec<&str> = lens.media_beyond(380.0, 780.0).into_iter().map(Medium::name).collect();
    assert_eq!(beyond, ["BAF5"]);
    assert!(lens.media_beyond(486.1, 656.3).is_empty());
    let constant = Medium::new("x", Dispersion::Constant(1.5), [f64::NAN, 3.0], "");
    assert_eq!(constant.index(f64::NAN), 1.5);
}
