//! Configurations of other programs' files: zooms and lenses focused inside.

use petzval_optics::formats::{lens, zmx};
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::prescription::moving::Part;

use super::{parse, refused, remarks, system};
use crate::common::repository;

/// A front lens and a rear one, and gaps of 10 mm, 5 mm and 60 mm behind surfaces 2, 3 (the stop) and 5, in Zemax's words.
fn zemax(solve: &str, after: &str) -> String {
    format!(
        "MODE SEQ\nUNIT MM\nENPD 5\nGCAT SCHOTT\nFTYP 0 0 1 1\nYFLN 0\nWAVM 1 0.5875618 1\nPWAV 1\nSURF 0\n  DISZ INFINITY\n\
         SURF 1\n  CURV 0.01\n  DISZ 4\n  GLAS N-BK7\n  DIAM 15 1\nSURF 2\n  CURV -0.012\n  DISZ 10\n  DIAM 15 1\n\
         SURF 3\n  STOP\n  DISZ 5\n  DIAM 5\nSURF 4\n  CURV 0.015\n  DISZ 3\n  GLAS N-BK7\n  DIAM 12 1\n\
         SURF 5\n  CURV -0.01\n  DISZ 60\n{solve}  DIAM 12 1\nSURF 6\n  DISZ 0\nBLNK \n{after}"
    )
}

/// The lens of [`zemax`] as a CODE V file; `after` are commands behind its surfaces.
fn code_v(after: &str) -> String {
    format!(
        "RDM N;LEN\nDIM M\nEPD 5;WL 587.5618\nYAN 0\nSO 0 1e13\nS 0.01 4 NBK7_SCHOTT\nCIR 15\nS -0.012 10\nCIR 15\nS 0 5\nSTO\n\
         S 0.015 3 NBK7_SCHOTT\nCIR 12\nS -0.01 60\nCIR 12\nSI 0 0\n{after}GO\n"
    )
}

/// `THIC` of a surface in each configuration.
fn thickness(surface: usize, values: &[f64]) -> String {
    let line = |(i, value): (usize, &f64)| format!("THIC {surface} {} {value} 0 0 0 1 1 1 0 0 \"\" 0\n", i + 1);
    values.iter().enumerate().map(line).collect()
}

/// Zoom, focus and values of each position.
fn positions(lens: &Prescription) -> Vec<(Option<f64>, f64, Vec<f64>)> {
    let moving = lens.moving.as_ref().unwrap();
    moving.positions().into_iter().map(|p| (p.zoom_mm, p.focus_mm, p.values)).collect()
}

/// Every configuration of a published zoom, as OpticStudio writes them, has the focal length and the gaps of the zoom.
#[test]
fn a_zoom_of_zemax_has_its_focal_lengths() {
    let path = repository("lenses").join("zoom-nikon-57-143-f2.8.lens");
    let published = lens::read(&path, Catalogue::shipped()).unwrap();
    let (text, _) = zmx::write(&published, Catalogue::shipped());
    // Without our own notes only configurations say what moves.
    let foreign: String =
        text.lines().filter(|line| !line.starts_with("NOTE")).map(|line| format!("{line}\n")).collect();
    assert_ne!(foreign, text);
    let reading = parse("a.zmx", &foreign).unwrap();
    let said = remarks(&reading);
    assert!(said.contains("configurations are positions of a zoom from"), "{said}");
    let [short, long] = reading.prescription.moving.as_ref().unwrap().zoom_range_mm().unwrap();
    assert!((short / 57.21 - 1.0).abs() < 2e-3 && (long / 143.07 - 1.0).abs() < 2e-3, "{short} to {long}");
    let expected = published.moving.as_ref().unwrap().positions();
    let found = positions(&reading.prescription);
    assert_eq!(found.len(), expected.len());
    for ((zoom_mm, focus_mm, values), expected) in found.iter().zip(&expected) {
        assert!((zoom_mm.unwrap() / expected.zoom_mm.unwrap() - 1.0).abs() < 2e-3);
        assert_eq!((focus_mm, values), (&expected.focus_mm, &expected.values));
        let placed = reading.prescription.at_position(zoom_mm.unwrap(), 0.0);
        let efl_mm = Paraxial::new(&system(&placed), line_nm::D).efl_mm.unwrap();
        assert!((efl_mm - zoom_mm.unwrap()).abs() < 1e-4, "{efl_mm} for {zoom_mm:?}");
    }
}

/// The stop's width follows the focal length at one f-number; gaps that solves state follow the configurations too.
#[test]
fn gaps_and_widths_follow_configurations() {
    let zoom =
        zemax("", &format!("MNUM 3 1\n{}{}", thickness(2, &[10.0, 20.0, 30.0]), thickness(5, &[60.0, 55.0, 50.0])));
    let plain = parse("a.zmx", &zoom).unwrap();
    let at: Vec<Vec<f64>> = positions(&plain.prescription).into_iter().map(|p| p.2).collect();
    // The entrance pupil is 5 mm wide throughout, the stop is not: how wide, is told by the marginal ray of first order.
    assert_eq!(at.len(), 3);
    for (values, gap) in at.iter().zip([10.0, 20.0, 30.0]) {
        let n = Catalogue::shipped().medium("schott:N-BK7").unwrap().index(line_nm::D);
        let (y, nu) = (2.5, -0.01 * (n - 1.0) * 2.5);
        let y = y + 4.0 * nu / n;
        let nu = nu - 0.012 * (n - 1.0) * y;
        let expected = 2.0 * (y + gap * nu);
        assert!((values[2] - expected).abs() < 1e-9, "{values:?} {expected}");
    }
    let total = zemax("  TCOM 2 70 0 0\n", &format!("MNUM 3 1\n{}", thickness(2, &[10.0, 20.0, 5.0])));
    let solved = parse("a.zmx", &total).unwrap().prescription;
    assert_eq!(solved.moving.as_ref().unwrap().parts()[..2], [1, 4].map(Part::gap));
    let gaps = |lens: &Prescription| positions(lens).iter().map(|p| [p.2[0], p.2[1]]).collect::<Vec<_>>();
    // The one that the file was saved in, then by rising focal length.
    assert_eq!(gaps(&solved), [[10.0, 60.0], [5.0, 65.0], [20.0, 50.0]]);
    // From the second surface on: 10 + 5 + 3 + 60 mm.
    let span = zemax("  TOLE 2 78 0 0\n", &format!("MNUM 2 1\n{}", thickness(2, &[10.0, 12.0])));
    assert_eq!(gaps(&parse("a.zmx", &span).unwrap().prescription), [[10.0, 60.0], [12.0, 58.0]]);
    // A film that stands at the image of first order does so in every configuration.
    let image = zemax("  MAZH 0 0\n", &format!("MNUM 2 1\n{}", thickness(2, &[10.0, 25.0])));
    let lens = parse("a.zmx", &image).unwrap().prescription;
    for (zoom_mm, _, values) in positions(&lens) {
        let placed = lens.at_position(zoom_mm.unwrap(), 0.0);
        let bfd_mm = Paraxial::new(&system(&placed), line_nm::D).bfd_mm.unwrap();
        assert!((values[1] - bfd_mm).abs() < 1e-4, "{values:?} {bfd_mm}");
    }
}

#[test]
fn code_v_says_the_same_as_zemax() {
    let zoom =
        zemax("", &format!("MNUM 3 1\n{}{}", thickness(2, &[10.0, 20.0, 30.0]), thickness(5, &[60.0, 55.0, 50.0])));
    let expected = positions(&parse("a.zmx", &zoom).unwrap().prescription);
    let lines = [
        "ZOO 3\nZOO TIT\nTIT Z1 'WIDE'\nZOO THI S2 10 20 30\nZOO THC S2 100 100 100\nZOO THI S5 60 55 50\n",
        "ZOO 3\nZOO THI S2\nTHI S2 Z1 10\nTHI S2 Z2 20;THI S2 Z3 30\nZOO THI SI 0 -5 -10\n",
    ];
    for line in lines {
        let reading = parse("a.seq", &code_v(line)).unwrap();
        assert_ne!(reading.prescription.name, "Z1");
        let found = positions(&reading.prescription);
        assert_eq!(found.len(), 3, "{}", remarks(&reading));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found.0.unwrap() - expected.0.unwrap()).abs() < 2e-4, "{found:?} {expected:?}");
            assert!(found.2.iter().zip(&expected.2).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
        }
    }
}

/// One focal length, several distances: the groups move, and the film follows the lens by itself.
#[test]
fn a_lens_that_is_focused_inside() {
    let near = format!("MNUM 2 1\n{}{}", thickness(0, &[1e10, 500.0]), thickness(3, &[5.0, 2.0]));
    let reading = parse("a.zmx", &zemax("", &near)).unwrap();
    assert!(remarks(&reading).contains("2 configurations are positions of the focus"), "{}", remarks(&reading));
    let found: Vec<(Option<f64>, f64, f64)> =
        positions(&reading.prescription).into_iter().map(|p| (p.0, p.1, p.2[0])).collect();
    assert_eq!(found, [(None, f64::INFINITY, 5.0), (None, 500.0, 2.0)]);
    let code = code_v("ZOO 2\nZOO THI SO 1e13 500\nZOO THI S3 5 2\n");
    assert_eq!(positions(&parse("a.seq", &code).unwrap().prescription)[1].1, 500.0);
}

#[test]
fn what_configurations_do_not_tell_is_said() {
    let all_near = format!("MNUM 2 1\n{}", thickness(0, &[300.0, 500.0]));
    let reading = parse("a.zmx", &zemax("", &all_near)).unwrap();
    assert!(remarks(&reading).contains("none has its object at infinity"), "{}", remarks(&reading));
    assert!(reading.prescription.moving.is_none());
    let glass = format!("MNUM 2 1\n{}GLSS 1 1 \"N-BK7\" 0\n", thickness(2, &[10.0, 20.0]));
    let reading = parse("a.zmx", &zemax("", &glass)).unwrap();
    assert!(remarks(&reading).contains("'GLSS' changes by configuration"), "{}", remarks(&reading));
    let beyond = format!("MNUM 2 1\n{}", thickness(2, &[10.0, 20.0, 30.0]));
    assert!(refused("a.zmx", &zemax("", &beyond)).contains("a configuration from 1 to 2"));
    assert!(refused("a.seq", &code_v("ZOO 0\n")).contains("number of zoom positions"));
    assert!(refused("a.seq", &code_v("ZOO 3\nZOO THI 5 1 2 3\n")).contains("a surface such as S5"));
    let one = parse("a.zmx", &zemax("", "MNUM 1 1\nTOL TOFF 0 0\n")).unwrap();
    assert!(one.prescription.moving.is_none() && remarks(&one).contains("merit function and tolerances"));
}
