//! Media whose index changes from place to place, against closed forms and against rays found in another way.

use glam::{DMat3, DVec3};
use petzval_optics::formats::lens::{self, parse};
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::seidel::Seidel;
use petzval_optics::surface::Pose;
use petzval_optics::system::{FocalLength, LensSettings, System};
use petzval_optics::trace::{Failure, Ray, Tracer, Travel};
use petzval_optics::vector::Vector;

use crate::common::{reference_json, repository};

fn system(text: &str) -> System {
    let lens = parse(text, "test.lens", Catalogue::shipped()).unwrap_or_else(|e| panic!("{e}"));
    System::new(&lens, &LensSettings::default()).unwrap()
}

fn ray(origin: [f64; 3], slopes: [f64; 2]) -> Ray {
    Ray { origin: origin.into(), direction: DVec3::new(slopes[0], slopes[1], 1.0).normalize() }
}

fn liou_brennan() -> System {
    let lens = lens::read(&repository("lenses/eye-liou-brennan.lens"), Catalogue::shipped()).unwrap();
    System::new(&lens, &LensSettings::default()).unwrap()
}

const ROD_INDEX: f64 = 1.6;
const ROD_G: f64 = 0.3;

/// The header of a rod with n² = n₀² (1 − g² r²), in powers of r to r²⁴: enough for (g r)²⁶, 1e-14 at 1 mm.
fn rod_header() -> String {
    let (mut coefficient, mut terms) = (ROD_INDEX, String::new());
    for k in 1..=12 {
        // The binomial series of √(1 − u).
        coefficient *= (f64::from(k) - 1.5) / f64::from(k) * ROD_G * ROD_G;
        terms += &format!(" r{}={coefficient:e}", 2 * k);
    }
    format!("# glass: ROD constant 0-inf {ROD_INDEX}\n# gradient: ROD{terms}\n")
}

/// Rays within 1 mm of the axis, askew.
fn rod_rays() -> impl Iterator<Item = Ray> {
    (0..60).map(|i| {
        let a = f64::from(i);
        let height = 0.55 * (0.1 * a).sin();
        ray([height * a.cos(), height * (1.3 * a).sin(), -0.5], [0.35 * (2.1 * a).sin(), 0.35 * (0.7 * a).cos()])
    })
}

/// A ray in such a rod is a spring in t, x = x₀ cos(n₀ g t) + p₀ sin(n₀ g t) / (n₀ g), and goes evenly along the axis.
#[test]
fn a_rod_bends_rays_as_a_spring() {
    for length in [0.7f64, 6.0, 25.0] {
        let rod = system(&format!(
            "{}#radius thickness glass diameter conic isstop\n0 {length} ROD 4 0 1\n0 5 air 4 0 0\n",
            rod_header()
        ));
        let tracer = rod.at_wavelength(550.0);
        for ray in rod_rays() {
            let at = ray.origin + ray.direction * (0.5 / ray.direction.z);
            let pace = ray.direction.truncate();
            let index = ROD_INDEX * (1.0 - ROD_G * ROD_G * at.truncate().length_squared()).sqrt();
            let along = (index * index - pace.length_squared()).sqrt();
            let (sin, cos) = (ROD_INDEX * ROD_G * length / along).sin_cos();
            let omega = ROD_INDEX * ROD_G;
            let expected = at.truncate() * cos + pace * (sin / omega);
            let out_pace = pace * cos - at.truncate() * (omega * sin);
            let out = tracer.from_scene(ray).unwrap();
            let tolerance = 1e-10 * length.max(10.0);
            assert!((out.origin.truncate() - expected).length() < tolerance, "{length}: {} {expected}", out.origin);
            assert!(
                (out.direction.truncate() - out_pace).length() < tolerance,
                "{length}: {} {out_pace}",
                out.direction
            );
            // The optical path ∫ n² dt, by the same springs.
            let mut lengths = Vec::new();
            tracer.from_scene_measuring(ray, &mut lengths).unwrap();
            let (t, double) = (length / along, (2.0 * omega * length / along).sin() / (4.0 * omega));
            let squares = at.truncate().length_squared() * (0.5 * t + double)
                + pace.length_squared() / (omega * omega) * (0.5 * t - double)
                + at.truncate().dot(pace) * (sin / omega).powi(2);
            let path = ROD_INDEX * ROD_INDEX * t - omega * omega * squares;
            assert!((lengths[1] * ROD_INDEX - path).abs() < tolerance, "{length}: {} {path}", lengths[1] * ROD_INDEX);
        }
    }
}

/// Layers across the axis, n = n₀ + b z: n sin i stays, and x = (S / b) (arcosh(n / S) at both ends).
#[test]
fn snells_law_holds_through_layers() {
    let (n, b, length) = (1.4, 0.05, 4.0);
    let plate = system(&format!(
        "# glass: LAYERS constant 0-inf {}\n# gradient: LAYERS from=-2 z1={b}\n\
         #radius thickness glass diameter conic isstop\n0 {length} LAYERS 20 0 1\n0 5 air 20 0 0\n",
        n - 2.0 * b
    ));
    let tracer = plate.at_wavelength(550.0);
    for slope in [0.05, 0.3, 1.0, 2.5] {
        let ray = ray([0.2, -1.0, 0.0], [0.0, slope]);
        let s = ray.direction.y;
        let run = |index: f64| s / b * (index / s).acosh();
        let expected = DVec3::new(0.2, -1.0 + run(n + b * length) - run(n), length);
        let out = tracer.from_scene(ray).unwrap();
        assert!((out.origin - expected).length() < 1e-9, "{slope}: {} {expected}", out.origin);
        assert!((out.direction - ray.direction).length() < 1e-11, "{slope}");
    }
}

/// Rays through the Liou-Brennan eye by the canonical equations with z as the parameter (tools/reference-gradients.py).
#[test]
fn rays_land_where_another_method_has_them() {
    let eye = liou_brennan();
    let document = reference_json("gradient-rays.json");
    let vector =
        |value: &serde_json::Value| DVec3::from_slice(&serde_json::from_value::<Vec<f64>>(value.clone()).unwrap());
    let mut worst = 0.0f64;
    let rays = document["rays"].as_array().unwrap();
    for ray in rays {
        let tracer = eye.at_wavelength(ray["um"].as_f64().unwrap() * 1000.0).without_rims();
        let start = Ray { origin: vector(&ray["from"]), direction: vector(&ray["along"]) };
        let mut hits = Vec::new();
        let out = tracer.from_scene_recording(start, &mut hits).unwrap();
        let places = hits.iter().enumerate().filter(|(i, _)| *i != eye.stop());
        for ((i, hit), expected) in places.zip(ray["hits"].as_array().unwrap()) {
            worst = worst.max((*hit - DVec3::Z * eye.vertex_z_mm(i) - vector(expected)).length());
        }
        worst = worst.max((out.direction - vector(&ray["direction"])).length());
    }
    assert_eq!(rays.len(), 48);
    assert!(worst < 1e-9, "{worst:e}");
}

/// n (x dy − y dx) is the same before and behind a lens whose surfaces stand on one axis, and so it is back.
#[test]
fn askew_rays_keep_their_turn_and_come_back() {
    let eye = liou_brennan();
    let tracer = eye.at_wavelength(line_nm::D);
    let index = eye.image_index(line_nm::D);
    let mut count = 0;
    for i in 0..200 {
        let a = f64::from(i);
        let start =
            ray([0.2 + 1.4 * a.cos(), 1.6 * (1.7 * a).sin(), -1.0], [0.3 * (0.3 * a).sin(), 0.3 * (0.9 * a).cos()]);
        let Ok(out) = tracer.from_scene(start) else { continue };
        let turn = |ray: &Ray| ray.origin.x * ray.direction.y - ray.origin.y * ray.direction.x;
        assert!((turn(&start) - index * turn(&out)).abs() < 1e-11, "{i}");
        let back = tracer.from_film(Ray { origin: out.origin, direction: -out.direction }).unwrap();
        assert!((back.direction + start.direction).length() < 1e-9, "{i}");
        let miss = (back.origin - start.origin).cross(start.direction).length();
        assert!(miss < 1e-9, "{i}: {miss:e}");
        count += 1;
    }
    assert!(count > 60, "{count}");
}

/// A gradient that adds nothing is a glass like another, to the roundings of its steps.
#[test]
fn no_gradient_is_a_plain_glass() {
    let lens = |header: &str| {
        system(&format!(
            "# glass: G cauchy 0-inf 1.5 0.004 -2\n{header}#radius thickness glass diameter conic isstop\n\
             20 4 G 12 -0.5 1\n-35 9 G 11 0.7 0\n0 -9 mirror 30 0 0\n0 -5 G 22 0 0\n70 -12 air 22 0 0\n"
        ))
    };
    let (plain, graded) = (lens(""), lens("# gradient: G z1=0 r2=0\n"));
    assert!(graded.has_gradients() && !plain.has_gradients());
    for nm in [450.0, 650.0] {
        let [a, b] = [&plain, &graded].map(|lens| lens.at_wavelength(nm));
        for i in 0..50 {
            let t = f64::from(i);
            let start = ray([4.0 * t.cos(), 4.0 * (2.0 * t).sin(), -3.0], [0.1 * (3.0 * t).sin(), 0.05]);
            match (a.from_scene(start), b.from_scene(start)) {
                (Ok(a), Ok(b)) => {
                    assert!((a.origin - b.origin).length() < 1e-12, "{i}: {} {}", a.origin, b.origin);
                    assert!((a.direction - b.direction).length() < 1e-13, "{i}");
                }
                (a, b) => assert_eq!(a, b),
            }
        }
        assert_eq!(Paraxial::new(&plain, nm).petzval_radius_mm, Paraxial::new(&graded, nm).petzval_radius_mm);
    }
}

/// A flat mirror at the end of a rod sends light back through it: as a rod twice as long, seen in the mirror.
#[test]
fn a_rod_is_met_again_behind_a_mirror() {
    let rows = "#radius thickness glass diameter conic isstop\n";
    let folded = system(&format!("{}{rows}0 4 ROD 4 0 1\n0 -4 mirror 4 0 0\n0 -5 air 4 0 0\n", rod_header()));
    let straight = system(&format!("{}{rows}0 8 ROD 4 0 1\n0 5 air 4 0 0\n", rod_header()));
    let [folded_tracer, tracer] = [&folded, &straight].map(|rod| rod.at_wavelength(550.0));
    for ray in rod_rays() {
        let (a, b) = (folded_tracer.from_scene(ray).unwrap(), tracer.from_scene(ray).unwrap());
        assert!((a.origin.truncate() - b.origin.truncate()).length() < 1e-9, "{} {}", a.origin, b.origin);
        assert!((a.direction - b.direction.with_z(-b.direction.z)).length() < 1e-9);
    }
    let [a, b] = [&folded, &straight].map(|rod| Paraxial::new(rod, 550.0));
    assert!((a.efl_mm.unwrap() - b.efl_mm.unwrap()).abs() < 1e-10);
    assert!((a.bfd_mm.unwrap() + b.bfd_mm.unwrap()).abs() < 1e-10);
}

/// The gradient stands as the surface does that it follows: an element beside its place carries it along.
#[test]
fn a_gradient_goes_with_its_element() {
    let text = |element: &str| {
        format!(
            "# glass: G constant 0-inf 1.5\n# gradient: G z1=0.02 r2=-0.004 z1r2=0.0003\n{element}\
             #radius thickness glass diameter conic isstop\n15 5 G 16 -0.4 1\n-22 20 air 16 0 0\n"
        )
    };
    let straight = system(&text("")).at_wavelength(550.0).without_rims();
    let beside = system(&text("# element: 0-1 decenter_x=0.4 decenter_y=-0.2 tilt_x=3 tilt_y=-5\n"));
    let beside = beside.at_wavelength(550.0).without_rims();
    let pose = Pose::misaligned([0.4, -0.2], [3f64.to_radians(), -5f64.to_radians(), 0.0]);
    let turn = DMat3::from_cols(
        pose.direction_out(Vector::<f64>::from_f64(DVec3::X)).of(0),
        pose.direction_out(Vector::<f64>::from_f64(DVec3::Y)).of(0),
        pose.direction_out(Vector::<f64>::from_f64(DVec3::Z)).of(0),
    );
    for i in 0..40 {
        let a = f64::from(i);
        let own = ray([3.0 * a.cos(), 3.0 * (1.1 * a).sin(), -2.0], [0.2 * (0.7 * a).sin(), 0.2 * a.cos()]);
        let origin = pose.point_out(Vector::<f64>::from_f64(own.origin)).of(0);
        let out = beside.from_scene(Ray { origin, direction: turn * own.direction }).unwrap();
        let expected = straight.from_scene(own).unwrap();
        let place = pose.point_out(Vector::<f64>::from_f64(expected.origin)).of(0);
        assert!((out.direction - turn * expected.direction).length() < 1e-10, "{i}");
        // Along their ray the places may differ.
        assert!((out.origin - place).cross(out.direction).length() < 1e-10, "{i}: {} {place}", out.origin);
    }
}

#[test]
fn single_precision_and_scale_change_little() {
    let eye = liou_brennan();
    let lens = lens::read(&repository("lenses/eye-liou-brennan.lens"), Catalogue::shipped()).unwrap();
    let thrice = LensSettings { focal_length: FocalLength::Scale(3.0), ..LensSettings::default() };
    let large = System::new(&lens, &thrice).unwrap().at_wavelength(550.0);
    let double = eye.at_wavelength(550.0);
    let single: Tracer<f32> = double.cast();
    for i in 0..60 {
        let a = f64::from(i);
        let start = ray([0.2 + 1.3 * a.cos(), 1.3 * (1.7 * a).sin(), -1.0], [0.2 * (0.3 * a).sin(), 0.2 * a.cos()]);
        let (Ok(a), Ok(b)) = (double.from_scene(start), single.from_scene(start)) else { continue };
        // Places of some mm, directions of 1: about ten roundings of 6e-8.
        assert!((a.origin - b.origin).length() < 4e-6 && (a.direction - b.direction).length() < 1e-6, "{i}");
        let c = large.from_scene(Ray { origin: start.origin * 3.0, ..start }).unwrap();
        assert!((c.origin / 3.0 - a.origin).length() < 1e-11 && (c.direction - a.direction).length() < 1e-11);
    }
}

/// Bundles have the same bits, for a rod that needs many steps and rays that turn back in it.
#[test]
fn bundles_have_the_same_bits() {
    let rod = system(&format!(
        "{}#radius thickness glass diameter conic isstop\n3 30 ROD 2.4 -0.5 1\n-4 5 air 2.4 0.3 0\n",
        rod_header()
    ));
    let tracer = rod.at_wavelength(550.0);
    for travel in [Travel::FromScene, Travel::FromFilm] {
        let rays: Vec<Ray> = (0..301)
            .map(|i| {
                let a = f64::from(i);
                let mut start =
                    ray([1.3 * a.cos(), 1.3 * (1.7 * a).sin(), -1.0], [1.5 * (0.3 * a).sin(), 0.8 * a.cos()]);
                if travel == Travel::FromFilm {
                    start.origin.z = 31.0;
                    start.direction = -start.direction;
                }
                start
            })
            .collect();
        let mut bundle = tracer.bundle(travel);
        rays.iter().for_each(|ray| bundle.push(*ray));
        tracer.trace(&mut bundle);
        let mut passed = 0;
        for (i, ray) in rays.iter().enumerate() {
            let alone = if travel == Travel::FromScene { tracer.from_scene(*ray) } else { tracer.from_film(*ray) };
            assert_eq!(bundle.result(i), alone, "{travel:?} {i}");
            passed += usize::from(alone.is_ok());
        }
        assert!(passed > 20 && passed < 280, "{passed}");
    }
}

/// Close to the axis rays go as the matrix says; the eye has the power and the length that its authors state.
#[test]
fn the_first_order_is_that_of_the_rays() {
    let eye = liou_brennan();
    let info = Paraxial::new(&eye, 555.0);
    let power = 1000.0 * eye.image_index(555.0) / info.efl_mm.unwrap();
    assert!((power - 60.35).abs() < 0.005, "{power}");
    // The axial length is 23.95 mm.
    assert!((info.film_z_mm - 23.95).abs() < 0.005, "{}", info.film_z_mm);
    assert!(Seidel::new(&eye, 555.0, None).is_none());
    let tracer = eye.at_wavelength(555.0).without_rims();
    let height = 1e-4;
    let out = tracer.from_scene(ray([0.0, height, -1.0], [0.0; 2])).unwrap();
    let focus = out.origin.z - out.origin.y * out.direction.z / out.direction.y;
    // Spherical aberration of about 0.1 mm at 1 mm goes with the square: 1e-9. The matrix has 12 digits.
    assert!((focus - info.film_z_mm).abs() < 1e-8, "{focus} {}", info.film_z_mm);
    // Field curvature of a rod: P = g² L / n₀ (Sands 1970).
    let rod = system(&format!(
        "{}#radius thickness glass diameter conic isstop\n0 5 ROD 2 0 1\n0 5 air 2 0 0\n",
        rod_header()
    ));
    let expected = -ROD_INDEX / (ROD_G * ROD_G * 5.0);
    assert!((Paraxial::new(&rod, 550.0).petzval_radius_mm.unwrap() / expected - 1.0).abs() < 1e-12);
}

/// A ray that leaves the side of a rod before its end does not arrive.
#[test]
fn rays_that_do_not_arrive_are_lost() {
    let rod = system(
        "# glass: G constant 0-inf 1.5\n# gradient: G r2=0.05\n#radius thickness glass diameter conic isstop\n\
         0 40 G 4 0 1\n0 5 air 4 0 0\n",
    );
    let lost = rod.at_wavelength(550.0).from_scene(ray([0.0, 0.9, -1.0], [0.0, 0.8])).unwrap_err();
    assert!(matches!(lost.reason, Failure::Missed | Failure::OutsideAperture) && lost.surface == 1, "{lost:?}");
}

#[test]
fn lines_that_make_no_gradient_are_named_with_their_place() {
    let rows = "#radius thickness glass diameter conic isstop\n50 4 G 20 0 1\n0 40 air 20 0 0\n";
    let cases = [
        ("# gradient: G z1=1\n", "1:13: 'G' makes no gradient"),
        ("# glass: G constant 0-inf 1.5\n# gradient: G\n", "2:13: 'G' makes no gradient"),
        ("# glass: G constant 0-inf 1.5\n# gradient: G r3=1\n", "2:13: 'G r3=1' makes no gradient"),
        ("# glass: G constant 0-inf 1.5\n# gradient: G z1=x\n", "2:13: 'z1=x' makes no gradient"),
        ("# glass: G constant 0-inf 1.5\n# gradient: G q1=1\n", "2:13: 'q1=1' makes no gradient"),
        ("# glass: G constant 0-inf 1.5\n# gradient: G z0=1\n", "2:13: 'G z0=1' makes no gradient"),
        ("# glass: G constant 0-inf 1.5\n# gradient: G z1=1 z1=2\n", "2:13: 'G z1=1 z1=2' makes no gradient"),
    ];
    for (lines, expected) in cases {
        let error = parse(&format!("{lines}{rows}"), "x.lens", Catalogue::shipped()).unwrap_err().to_string();
        assert!(error.starts_with("x.lens:") && error.contains(expected), "{lines:?}: {error}");
    }
    let at_film = "# glass: G constant 0-inf 1.5\n# gradient: G r2=-0.01\n#radius thickness glass diameter conic isstop\n\
                   50 4 1.6 20 0 1\n0 40 G 20 0 0\n";
    let error = parse(at_film, "x.lens", Catalogue::shipped()).unwrap_err().to_string();
    assert!(
        error.starts_with("x.lens:5:") && error.contains("before the film, behind surface 1, has a gradient"),
        "{error}"
    );
}

#[test]
fn gradients_are_written_as_they_were_read() {
    let text = "# glass: G cauchy 400-700 1.5 0.004 -2\n# gradient: G from=0.25 z1=0.02 z3=-0.0001 r2=-0.004 z1r2=0.0003\n\
                #radius thickness glass diameter conic isstop\n15 5 G 16 -0.4 1\n-22 20 air 16 0 0\n";
    let lens = parse(text, "x.lens", Catalogue::shipped()).unwrap();
    let (written, lost) = lens::write(&lens, Catalogue::shipped());
    assert!(lost.is_empty(), "{lost:?}");
    assert!(written.contains("# gradient: G from=0.25 z1=0.02 z3=-0.0001 r2=-0.004 z1r2=0.0003\n"), "{written}");
    assert_eq!(parse(&written, "x.lens", Catalogue::shipped()).unwrap().surfaces[0].behind, lens.surfaces[0].behind);
}
