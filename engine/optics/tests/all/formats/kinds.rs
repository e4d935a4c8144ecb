//! Each kind of file: its numbers are where they belong, and content that cannot be read is refused or noted by line.

use std::path::Path;

use glam::DVec3;
use petzval_optics::formats::{self, lens};
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::NextMedium;
use petzval_optics::trace::Ray;

use super::there_and_back::{again, assert_same};
use super::{ZMX, parse, refused, remarks, system};

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

/// Thorlabs's asphere ASL5040-UV (numbers of its public file) is made for 405 nm: all rays converge where the file has the film.
#[test]
fn a_q_type_asphere_focuses_as_its_maker_says() {
    let coefficients = [-0.8148370167576, -0.32311, 0.10591, -0.05058, 0.00987, -0.0022];
    let data: String = coefficients.iter().enumerate().map(|(i, a)| format!("  XDAT {} {a} 0\n", i + 4)).collect();
    let text = |kind: i32| {
        format!(
            "MODE SEQ\nUNIT MM\nENPD 45.72\nFTYP 0 0 1 1\nYFLN 0\nWAVM 1 0.405 1\nPWAV 1\nSURF 0\n  DISZ INFINITY\n\
             SURF 1\n  STOP\n  TYPE QED_TYPE\n  CURV 5.756078762782423225E-02\n  XDAT 1 {kind} 0\n  XDAT 2 6 0\n  XDAT 3 27 0\n{data}  DISZ 29.85\n\
             GLAS C79-80 0 0\n  CONI -0.67609120640407927\n  DIAM 22.86 0\nSURF 2\n  DISZ 19.687453064998852\n  DIAM 17.6 1\nSURF 3\n  DISZ 0\n"
        )
    };
    let blur = |text: &str| {
        let reading = parse("a.zmx", text).unwrap();
        let system = system(&reading.prescription);
        let tracer = system.at_wavelength(405.0);
        let height = |y: f64| {
            let ray = Ray { origin: DVec3::new(0.0, y, -1.0), direction: DVec3::Z };
            let out = tracer.from_scene(ray).unwrap();
            (out.origin + out.direction * ((29.85 + 19.687453064998852 - out.origin.z) / out.direction.z)).y.abs()
        };
        ([4.0, 9.0, 14.0, 18.0, 22.0].map(height).into_iter().fold(0.0, f64::max), remarks(&reading))
    };
    let (slope_orthogonal_mm, said) = blur(&text(0));
    assert!(slope_orthogonal_mm < 4e-3, "{slope_orthogonal_mm}");
    assert!(said.contains("powers to r^20, which follow its sag within"), "{said}");
    // The other kind is another surface.
    assert!(blur(&text(1)).0 > 0.1);
    assert!(refused("a.zmx", &text(2)).contains("not 2"));
    assert!(refused("a.zmx", &text(0).replace("XDAT 3 27", "XDAT 3 0")).contains("normalization radius is 0"));
    assert!(refused("a.zmx", &text(0).replace("CONI -0.676", "CONI 0.676")).contains("before its clear radius"));
}

/// An offset of a glass is added to its index.
#[test]
fn offsets_of_glasses_are_added() {
    let index = |text: &str| {
        let NextMedium::Medium(medium) = parse("a.zmx", text).unwrap().prescription.surfaces[0].behind.clone() else {
            panic!()
        };
        medium.index(line_nm::D)
    };
    let shifted = ZMX.replace("GLAS F2 0 0 1.5 40 0 0 0 0 0 0", "GLAS F2 4 0 1.5 40 0 0 0 0 0.0007 -0.05");
    assert!((index(&shifted) - index(ZMX) - 0.0007).abs() < 1e-12);
    assert!(remarks(&parse("a.zmx", &shifted).unwrap()).contains("offset of its Abbe number by -0.05"));
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
        let NextMedium::Medium(medium) = reading.prescription.surfaces[0].behind.clone() else { panic!() };
        (medium, remarks(&reading))
    };
    let catalogue = Catalogue::shipped();
    let (f2, said) = glass(ZMX);
    assert_eq!((f2, said.as_str()), (catalogue.medium("schott:F2").unwrap(), ""));
    let sf11 = ZMX.replace("GLAS F2", "GLAS SF11");
    assert_eq!(
        glass(&sf11.replace("GCAT HOYA SCHOTT", "GCAT NIKON-HIKARI")).0,
        catalogue.medium("hikari:SF11").unwrap()
    );
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
    let coordinate = "SURF 2\n  TYPE COORDBRK\n  PARM 3 70\n  DISZ 0\nSURF 3\n";
    let cases = [
        (ZMX.replace("MODE SEQ", "MODE NSC"), "a.zmx:2:1: mode NSC: only sequential lenses"),
        (ZMX.replace("TYPE EVENASPH", "TYPE BINARY_2"), "a.zmx:24:3: surface type 'BINARY_2' is not supported"),
        (
            ZMX.replace("SURF 3\n", coordinate),
            "a.zmx:23:1: the film stands at 70.0 degrees to the axis of the first surface",
        ),
        (ZMX.replace("GLAS F2", "GLAS F2X9Q"), "a.zmx:20:8: unknown glass 'F2X9Q'"),
        (ZMX.replace("GLAS F2", "GLAS L-BAL35Q"), "a.zmx:20:8: unknown glass 'L-BAL35Q'; did you mean L-BAL35"),
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
        NextMedium::Medium(medium) => medium.index(nm),
        NextMedium::Mirror => panic!(),
    };
    assert!((index(0, line_nm::D) - 1.517).abs() < 1e-12);
    assert!((index(1, 656.3) - 1.6).abs() < 1e-12 && (index(1, 486.1) - 1.615).abs() < 1e-12);
    assert_eq!(index(3, 500.0), Catalogue::shipped().medium("hikari:SF11").unwrap().index(500.0));
    let spaced = text.replace("'MINE'", "'MY #1 GLASS'").replace("'mine'", "'my #1 glass'");
    let spaced = parse("a.seq", &spaced).unwrap().prescription;
    assert_same("spaced", &spaced, &again(&spaced, lens::write, "x.lens"));
    let cases = [
        (text.replace("SF11_HIKARI", "NBK7_OHARA"), "a.seq:21:9: unknown glass 'NBK7"),
        (text.replace("STO\n", "STO\nRET S1\n"), "a.seq:21:1: 'RET' tilts, moves or reshapes"),
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
    assert_eq!(lens.surfaces[4].behind, NextMedium::Mirror);
    let NextMedium::Medium(model) = &lens.surfaces[3].behind else { panic!() };
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
    // Flat glass beside the stop, and a second, fixed stop: nothing is refracted at either stop.
    let dat = "60 6 1.5168 30\n0 2 1 30\n0 3 0 20\n0 4 1.6 24\n-60 5 1 30\n0 50 0 18\n";
    let reading = parse("a.dat", dat).unwrap();
    assert_eq!((reading.prescription.surfaces.len(), reading.prescription.stop), (6, 2));
    let said = remarks(&reading);
    assert!(said.contains("a.dat:2:1: radius 0 where the medium changes") && said.contains("a.dat:4:1:"), "{said}");
    assert!(said.contains("a.dat:6:1: a second stop; it is taken for a fixed one"), "{said}");
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

/// A stop without a width, of a file that states no beam either, lets through all light that the other rims do: between two plates, of
/// light from a point 100 mm before the first, whose rim has 10 mm, it is passed at 15 mm.
#[test]
fn a_stop_without_a_width_is_as_wide_as_the_other_rims_let_light_through() {
    let text = |object: &str, last_mm: f64| {
        format!(
            "VERS 1\nUNIT MM\nFLOA\nGCAT SCHOTT\nWAVM 1 0.5875618 1\nSURF 0\n  DISZ {object}\nSURF 1\n  CURV 0\n  DISZ 50\n  CLAP 0 10 0\n\
            SURF 2\n  STOP\n  CURV 0\n  DISZ 50\nSURF 3\n  CURV -0.02\n  DISZ 1e-9\n  GLAS N-BK7\n  DIAM {last_mm}\n\
            SURF 4\n  CURV 0\n  DISZ 10\n  DIAM 40\nSURF 5\n  DISZ 0\n"
        )
    };
    let stop_mm = |text: &str| {
        let read = parse("bare.zmx", text).unwrap();
        assert!(remarks(&read).contains("the stop has no clear aperture in the file"), "{}", remarks(&read));
        let lens = read.prescription;
        lens.surfaces[lens.stop].semi_diameter_mm
    };
    // From a point, from far away, and where the surface behind limits the beam: at 8 mm, to which it bulges by 0.645 mm.
    let sag_mm = 50.0 - (50.0f64 * 50.0 - 64.0).sqrt();
    for (object, last_mm, expected_mm) in
        [("100", 30.0, 15.0), ("INFINITY", 30.0, 10.0), ("100", 8.0, 8.0 * 150.0 / (200.0 - sag_mm))]
    {
        let found_mm = stop_mm(&text(object, last_mm));
        assert!((found_mm - expected_mm).abs() < 1e-9, "{object}, {last_mm}: {found_mm} is not {expected_mm}");
    }
}
