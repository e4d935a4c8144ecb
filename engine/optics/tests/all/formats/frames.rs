//! Tilted and decentred frames of other programs: elements beside the axis as a lens file poses them, and folds undone.

use glam::DVec3;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::prescription::Prescription;
use petzval_optics::trace::Ray;

use super::{parse, refused, remarks, system};

/// A singlet as a lens file, with lines of a header before it.
fn own(header: &str) -> Prescription {
    let text = format!(
        "{header}#radius thickness glass diameter conic isstop\n0 5 air 10 0 1\n50 4 N-BK7 20 0 0\n-60 40 air 20 0 0\n"
    );
    lens::parse(&text, "own.lens", Catalogue::shipped()).unwrap()
}

/// The lens as a file of CODE V; `first` and `second` are commands after the surfaces of the singlet, `end` before the film.
fn code_v(first: &str, second: &str, end: &str) -> String {
    format!(
        "RDM;LEN\nDIM M\nEPD 10;WL 587.6\nYAN 0\nSO 0 1e13\nS 0 5\nSTO\nS 50 4 NBK7_SCHOTT\nCIR 10\n{first}\nS -60 40\nCIR 10\n{second}\n{end}SI 0 0\nGO\n"
    )
}

/// The lens as a file of Zemax; `before` and `behind` are the parameters of coordinate breaks about the singlet.
fn zemax(before: &str, behind: &str) -> String {
    let parameters = |text: &str| -> String {
        text.split_whitespace().enumerate().map(|(i, value)| format!("  PARM {} {value}\n", i + 1)).collect()
    };
    format!(
        "MODE SEQ\nUNIT MM\nENPD 10\nGCAT SCHOTT\nFTYP 0 0 1 1\nYFLN 0\nWAVM 1 0.5875618 1\nPWAV 1\nSURF 0\n  DISZ INFINITY\n\
         SURF 1\n  STOP\n  DISZ 5\n  DIAM 5\nSURF 2\n  TYPE COORDBRK\n{}  DISZ 0\n\
         SURF 3\n  CURV 0.02\n  DISZ 4\n  GLAS N-BK7\n  CLAP 0 10\nSURF 4\n  CURV {}\n  DISZ 0\n  CLAP 0 10\n\
         SURF 5\n  TYPE COORDBRK\n{}  DISZ 40\nSURF 6\n  DISZ 0\n",
        parameters(before),
        -1.0 / 60.0,
        parameters(behind)
    )
}

/// Origin and direction of some rays behind the lens.
fn rays(lens: &Prescription) -> Vec<[DVec3; 2]> {
    let tracer = system(lens).at_wavelength(587.5618);
    let rays = [(0.0, 0.0), (3.0, 0.0), (0.0, 4.0), (-2.0, -3.0)];
    rays.iter()
        .map(|&(x, y)| {
            let direction = DVec3::new(0.02, -0.03, 1.0).normalize();
            let out = tracer.from_scene(Ray { origin: DVec3::new(x, y, -1.0), direction }).unwrap();
            // Where it crosses the film, 49 mm behind the stop.
            let at = out.origin + out.direction * ((49.0 - out.origin.z) / out.direction.z);
            [at, out.direction]
        })
        .collect()
}

fn assert_alike(name: &str, a: &Prescription, b: &Prescription) {
    for ([at, along], [expected, towards]) in rays(a).into_iter().zip(rays(b)) {
        assert!(at.distance(expected) < 1e-9 && along.distance(towards) < 1e-12, "{name}: {at} {expected}");
    }
}

/// Both programs turn left-handed about x and y: their 3 degrees about x are -3 here.
#[test]
fn elements_beside_the_axis_are_posed_there() {
    let posed = own("# element: 1-2 decenter_x=0.3 decenter_y=-0.5 tilt_x=-3 tilt_y=2 tilt_z=10\n");
    let frame = "XDE 0.3;YDE -0.5;ADE 3;BDE -2;CDE 10";
    // Both surfaces stand in the frame of the first, and the film in that before.
    let stays = code_v(frame, "", "S 0 0\nREV\nXDE 0.3;YDE -0.5;ADE 3;BDE -2;CDE 10\n");
    assert!(parse("a.seq", &stays).is_ok());
    // The frame is taken back at the last vertex of the element, 4 mm along its own axis.
    let before = "0.3 -0.5 3 -2 10 0";
    let back = "0 0 0 0 0 0";
    let turned = parse("a.zmx", &zemax(before, back)).unwrap();
    assert!(remarks(&turned).contains("the file's film is turned by"), "{}", remarks(&turned));
    assert_alike("zemax", &turned.prescription, &posed);
    // A surface alone that returns to the axis.
    let one = own("# element: 1-1 decenter_y=0.5 tilt_x=-3\n");
    let alone = parse("a.seq", &code_v("YDE 0.5;ADE 3;DAR", "", "")).unwrap();
    assert!(!remarks(&alone).contains("film"), "{}", remarks(&alone));
    assert_alike("code v", &alone.prescription, &one);
}

/// A break and its opposite with the other order are none: Zemax's order flag.
#[test]
fn a_break_is_taken_back_by_its_opposite() {
    let text = zemax("0.3 -0.5 3 -2 10 0", "-0.3 0.5 -3 2 -10 1");
    let reading = parse("a.zmx", &text).unwrap();
    // At the vertex behind the element the frame is 4 mm along the tilted axis, so that the film stands a little aside.
    let said = remarks(&reading);
    let straight = parse("a.zmx", &zemax("0 0 0 0 0 0", "0 0 0 0 0 0")).unwrap();
    assert_alike("straight", &straight.prescription, &own(""));
    assert!(said.contains("turned by 0.0000 degrees"), "{said}");
}

/// A mirror at 45 degrees before the lens, and one behind it: light goes straight on.
#[test]
fn plane_mirrors_are_unfolded() {
    let folded = "RDM;LEN\nDIM M\nEPD 10;WL 587.6\nYAN 0\nSO 0 1e13\nS 0 5\nSTO\nS 0 -7 REFL\nADE 45\nBEN\nS -50 -4 NBK7_SCHOTT\nCIR 10\n\
                  S 60 -15\nCIR 10\nS 0 25 REFL\nADE -45\nBEN\nSI 0 0\nGO\n";
    let reading = parse("a.seq", folded).unwrap();
    let lens = &reading.prescription;
    assert!(remarks(&reading).contains("2 plane mirrors are unfolded"), "{}", remarks(&reading));
    assert_eq!(lens.surfaces.len(), 3);
    let numbers: Vec<f64> = lens.surfaces.iter().map(|row| row.thickness_mm).collect();
    assert!(numbers.iter().zip([12.0, 4.0, 40.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{numbers:?}");
    let radii: Vec<f64> = lens.surfaces[1..].iter().map(|row| 1.0 / row.shape.profile().base.curvature).collect();
    assert!((radii[0] - 50.0).abs() < 1e-9 && (radii[1] + 60.0).abs() < 1e-9, "{radii:?}");
}

/// A periscope as Zemax has it: two mirrors at 45 degrees, coordinates turned between them, a lens behind.
#[test]
fn coordinates_turned_between_mirrors_do_not_matter() {
    let turned = |deg: i32, behind: f64| format!("  TYPE COORDBRK\n  PARM 3 {deg}\n  DISZ {behind}\n");
    let mirror = "  GLAS MIRROR\n  DISZ 0\n";
    let text = format!(
        "MODE SEQ\nUNIT MM\nENPD 10\nGCAT SCHOTT\nFTYP 0 0 1 1\nYFLN 0\nWAVM 1 0.5875618 1\nPWAV 1\nSURF 0\n  DISZ INFINITY\n\
         SURF 1\n  STOP\n  DISZ 5\n  DIAM 5\nSURF 2\n{}SURF 3\n{mirror}SURF 4\n{}SURF 5\n{}SURF 6\n{mirror}SURF 7\n{}\
         SURF 8\n  CURV 0.02\n  DISZ 4\n  GLAS N-BK7\n  CLAP 0 10\nSURF 9\n  CURV {}\n  DISZ 40\n  CLAP 0 10\nSURF 10\n  DISZ 0\n",
        turned(45, 0.0),
        turned(45, -30.0),
        turned(-45, 0.0),
        turned(-45, 2.0),
        -1.0 / 60.0
    );
    let reading = parse("a.zmx", &text).unwrap();
    assert!(remarks(&reading).contains("2 plane mirrors are unfolded"), "{}", remarks(&reading));
    let gaps: Vec<f64> = reading.prescription.surfaces.iter().map(|row| row.thickness_mm).collect();
    assert!(gaps.iter().zip([37.0, 4.0, 40.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{gaps:?}");
}

#[test]
fn what_cannot_be_unfolded_is_said() {
    // A concave mirror that bends the axis.
    let bent =
        "RDM;LEN\nDIM M\nEPD 10;WL 587.6\nYAN 0\nSO 0 1e13\nS 0 50\nSTO\nS -200 -90 REFL\nADE 40\nBEN\nSI 0 0\nGO\n";
    let said = refused("a.seq", bent);
    assert!(said.contains("the film stands at 80.0 degrees"), "{said}");
    let stop =
        "RDM;LEN\nDIM M\nEPD 10;WL 587.6\nYAN 0\nSO 0 1e13\nS 0 -50 REFL\nSTO\nADE 45\nBEN\nS -50 -90\nSI 0 0\nGO\n";
    assert!(refused("a.seq", stop).contains("the stop is a mirror that folds"), "{}", refused("a.seq", stop));
    let returned = code_v("RET S1", "", "");
    assert!(refused("a.seq", &returned).contains("'RET' tilts, moves or reshapes"));
}
