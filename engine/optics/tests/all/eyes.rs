//! The schematic eyes: their published powers, their accommodation, their sharpness off the axis.

use glam::{DVec2, DVec3};
use petzval_optics::focus::{FilmPlane, FocusError, Focusing, GroupsError};
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::Ray;

use crate::common::repository;

fn eye(name: &str) -> Prescription {
    lens::read(&repository("lenses").join(format!("{name}.lens")), Catalogue::shipped())
        .unwrap_or_else(|e| panic!("{e}"))
}

fn at_rest(lens: &Prescription) -> System {
    System::new(lens, &LensSettings::default()).unwrap()
}

fn power_dioptres(system: &System, wavelength_nm: f64) -> f64 {
    1000.0 * system.image_index(wavelength_nm) / Paraxial::new(system, wavelength_nm).efl_mm.unwrap()
}

/// `# published_power: 60.35 at 555 nm`, to the digits that are printed.
#[test]
fn eyes_have_their_published_powers() {
    let mut stated = 0;
    for entry in std::fs::read_dir(repository("lenses")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if !name.starts_with("eye-") {
            continue;
        }
        let lens = eye(&name);
        assert!(lens.film_radius_mm.is_some(), "{name} has no retina");
        let said =
            |key: &str| lens.metadata.all.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str());
        assert_eq!(said("group").or(said("category")), Some("eye"), "{name}");
        let system = at_rest(&lens);
        // One over the power, as the tables of eyes have it.
        let efl = 1000.0 / power_dioptres(&system, line_nm::D);
        // Focal lengths are named to the digits that they are printed with.
        let nominal: f64 = said("focal_length").unwrap().parse().unwrap();
        assert!((efl - nominal).abs() < 0.02, "{name}: {efl} {nominal}");
        let Some((power, wavelength)) = said("published_power").and_then(|text| text.split_once(" at ")) else {
            continue;
        };
        let wavelength_nm: f64 = wavelength.strip_suffix(" nm").unwrap().parse().unwrap();
        let digits = power.split_once('.').map_or(0, |(_, digits)| digits.len());
        let computed = power_dioptres(&system, wavelength_nm);
        // Half a unit of the last digit, and a little: Gullstrand's 70.57 is 70.5750 with the digits of his surfaces.
        let room = 0.51 * 0.1f64.powi(digits as i32);
        assert!((computed - power.parse::<f64>().unwrap()).abs() < room, "{name}: {computed}, not {power}");
        stated += 1;
    }
    assert!(stated >= 8, "{stated}");
}

/// The eye's lens bulges until the distance is sharp; the retina stays where it is.
#[test]
fn eyes_accommodate() {
    for name in ["eye-navarro", "eye-le-grand", "eye-gullstrand-exact", "eye-gullstrand-emsley"] {
        let lens = eye(name);
        let relaxed = at_rest(&lens);
        let film = Paraxial::new(&relaxed, line_nm::D).film_z_mm;
        let mut power = power_dioptres(&relaxed, line_nm::D);
        let mut front =
            1.0 / relaxed.surfaces()[relaxed.stop() + 1].shape.curvature_at_vertex(petzval_optics::surface::Section::Y);
        for distance_mm in [4000.0, 1000.0, 500.0, 250.0, 180.0] {
            let settings = LensSettings::default();
            let focused = Focusing::default().by_groups(&lens, &settings, line_nm::D, distance_mm).unwrap();
            assert!((focused.film_z_mm - film).abs() < 1e-4, "{name}: {} {film}", focused.film_z_mm);
            // A ray near the axis from that distance lands on the axis of the retina.
            let pupil_z = Paraxial::new(&focused.system, line_nm::D).entrance_pupil.z_mm.unwrap();
            let direction = DVec3::new(0.0, 1e-4 / distance_mm, 1.0).normalize();
            let origin = DVec3::new(0.0, 0.0, pupil_z - distance_mm);
            let out = focused.system.at_wavelength(line_nm::D).from_scene(Ray { origin, direction }).unwrap();
            let height = out.origin.y + out.direction.y / out.direction.z * (focused.film_z_mm - out.origin.z);
            assert!(height.abs() < 1e-9, "{name} at {distance_mm}: {height:e}");
            let now = power_dioptres(&focused.system, line_nm::D);
            let surface = &focused.system.surfaces()[focused.system.stop() + 1];
            let radius = 1.0 / surface.shape.curvature_at_vertex(petzval_optics::surface::Section::Y);
            assert!(now > power && radius < front, "{name} at {distance_mm}: {now} {radius}");
            (power, front) = (now, radius);
        }
        let too_near = Focusing::default().by_groups(&lens, &LensSettings::default(), line_nm::D, 60.0).unwrap_err();
        assert!(matches!(too_near, GroupsError::Focus(FocusError::TooClose { .. })), "{name}: {too_near}");
    }
}

/// The accommodated ends of the tables are the accommodated eyes, and have their published powers and near points.
#[test]
fn accommodated_eyes_are_the_ends_of_the_tables() {
    for (name, power, near_mm) in [("eye-le-grand", 67.677, 141.8), ("eye-gullstrand-exact", 70.575, 92.0)] {
        let lens = eye(name);
        let end = System::with_travel(&lens, &LensSettings::default(), 1.0).unwrap();
        let alone = at_rest(&eye(&format!("{name}-accommodated")));
        for system in [&end, &alone] {
            assert!((power_dioptres(system, line_nm::D) - power).abs() < 5e-4, "{name}");
        }
        let film = Paraxial::new(&at_rest(&lens), line_nm::D).film_z_mm;
        let front = Focusing { anchor: petzval_optics::focus::Anchor::FrontVertex, ..Focusing::default() };
        let found = front.distance_mm(&end, line_nm::D, film);
        assert!((found - near_mm).abs() < 0.1, "{name}: {found}");
    }
    // Navarro's laws at A = 8, a place of the table, and between its places.
    let lens = eye("eye-navarro");
    let positions = lens.moving.as_ref().unwrap().positions();
    let nearest = positions[positions.len() - 1].focus_mm;
    let travel = nearest / positions[positions.len() - 2].focus_mm;
    let at = System::with_travel(&lens, &LensSettings::default(), travel).unwrap();
    let alone = at_rest(&eye("eye-navarro-accommodated"));
    assert!((power_dioptres(&at, line_nm::D) - power_dioptres(&alone, line_nm::D)).abs() < 1e-4);
    for travel in [0.07, 0.3, 0.55, 0.9] {
        let between = lens.at_position(1.0, travel);
        let lens_front = &between.surfaces[3];
        let radius = 1.0 / lens_front.shape.profile().base.curvature;
        // ln(A + 1) from the radius; the others have it, too.
        let log = (10.2 - radius) / 1.75;
        assert!((lens_front.thickness_mm - (4.0 + 0.1 * log)).abs() < 1e-3, "{travel}");
        assert!((lens_front.shape.profile().base.conic - (-3.1316 - 0.34 * log)).abs() < 4e-3, "{travel}");
        let a = log.exp_m1();
        let petzval_optics::prescription::NextMedium::Medium(medium) = &lens_front.behind else { panic!() };
        let shift = medium.index(line_nm::D) - medium.as_defined().index(line_nm::D);
        assert!((shift - 9e-5 * (10.0 * a + a * a)).abs() < 1.5e-4, "{travel}: {shift} {a}");
    }
}

/// Distances of the tables are sharp where they say, on the retina of the relaxed eye.
#[test]
fn positions_are_sharp_where_they_say() {
    for name in ["eye-navarro", "eye-le-grand", "eye-gullstrand-exact", "eye-gullstrand-emsley"] {
        let lens = eye(name);
        let film = Paraxial::new(&at_rest(&lens), line_nm::D).film_z_mm;
        let front = Focusing { anchor: petzval_optics::focus::Anchor::FrontVertex, ..Focusing::default() };
        for position in lens.moving.as_ref().unwrap().positions().iter().skip(1) {
            let system = at_rest(&lens.with_parts(&position.values));
            let found = front.distance_mm(&system, line_nm::D, film);
            assert!((found / position.focus_mm - 1.0).abs() < 2e-3, "{name}: {found} {}", position.focus_mm);
        }
    }
}

/// Root mean square distance on the retina from the middle of the spot, mm, of a far point beside the axis, pupil of 4 mm.
fn spot_mm(name: &str, angle_deg: f64) -> f64 {
    let system = at_rest(&eye(name));
    let info = Paraxial::new(&system, line_nm::D);
    let film =
        FilmPlane { curvature_per_mm: 1.0 / system.film_radius_mm().unwrap(), ..FilmPlane::upright(info.film_z_mm) };
    let frame = film.frame();
    let tracer = system.at_wavelength(line_nm::D);
    let direction = DVec3::new(0.0, angle_deg.to_radians().sin(), angle_deg.to_radians().cos());
    let (pupil_z, radius) = (info.entrance_pupil.z_mm.unwrap(), info.entrance_pupil.diameter_mm.unwrap() / 2.0);
    let mut places = Vec::new();
    for i in -20..=20 {
        for j in -20..=20 {
            let at = DVec2::new(f64::from(i), f64::from(j)) * (radius * 1.3 / 20.0);
            let through = at.extend(pupil_z);
            if let Ok(out) = tracer.from_scene(Ray { origin: through - direction * 20.0, direction })
                && let Some([u, v]) = frame.meet(&out)
            {
                places.push(film.point(u, v));
            }
        }
    }
    assert!(places.len() > 300, "{name} {angle_deg}: {}", places.len());
    let middle = places.iter().sum::<DVec3>() / places.len() as f64;
    (places.iter().map(|p| (*p - middle).length_squared()).sum::<f64>() / places.len() as f64).sqrt()
}

/// Conicoids and a retina of the right curvature: Kooijman's eye is sharper beside the axis than Gullstrand's spheres.
#[test]
fn kooijmans_eye_is_sharper_beside_the_axis() {
    for angle_deg in [15.0, 20.0, 25.0, 30.0] {
        let (kooijman, gullstrand) = (spot_mm("eye-kooijman", angle_deg), spot_mm("eye-gullstrand-exact", angle_deg));
        println!(
            "{angle_deg}: Kooijman {kooijman:.4} mm, Gullstrand {gullstrand:.4} mm, Navarro {:.4} mm, Liou-Brennan {:.4} mm",
            spot_mm("eye-navarro", angle_deg),
            spot_mm("eye-liou-brennan", angle_deg)
        );
        assert!(kooijman < 0.9 * gullstrand, "{angle_deg}: {kooijman} {gullstrand}");
    }
}
