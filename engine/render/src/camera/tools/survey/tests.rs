//! Measures of a survey against closed forms, and against rays in the other direction.

use super::*;
use crate::camera::tests::with_lens;

const SIZE: [u32; 2] = [1920, 1280];

fn measured(d: &CameraDescription, size: [u32; 2], depth: Option<f64>) -> LensMeasures {
    let survey = Survey::new(d, size[0], size[1]).unwrap();
    let fans = survey.fans();
    let seen: Vec<Option<DVec3>> = fans.rays().iter().map(|ray| on_plane(ray.as_ref()?, depth?)).collect();
    fans.measure(&seen)
}

/// The point at which a ray hits the plane at a depth before the camera.
fn on_plane(ray: &Ray, depth: f64) -> Option<DVec3> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let t = (depth + origin.z) / -direction.z;
    (t > 0.0).then(|| origin + direction * t)
}

/// A blur disc of a lens without thickness, by similar triangles.
#[test]
fn defocus_is_that_of_similar_triangles() {
    let d = with_lens("biconvex-50mm.lens", 36.0, 24.0, 0.0);
    let d = CameraDescription { wavelength_nm: Some(587.6), ..d }.with(|c| {
        c.lens.f_number = Some(8.0);
        c.focus.distance = Some(2.0);
    });
    let info = crate::camera::lens_info(&d, SIZE[0], SIZE[1]).unwrap();
    let (f, diameter) = (info.efl_mm.unwrap(), info.entrance_pupil_diameter_mm.unwrap());
    for depth_mm in [1000.0, 4000.0, 1e9] {
        let found = measured(&d, SIZE, (depth_mm < 1e8).then_some(depth_mm / 1000.0)).defocus.value;
        let away = if depth_mm < 1e8 { (depth_mm - 2000.0f64).abs() / depth_mm } else { 1.0 };
        let expected_mm = 0.5 * diameter * away * f / (2000.0 - f);
        let expected = expected_mm * f64::from(SIZE[0]) / 36.0;
        // The lens is some millimetres thick.
        assert!((found / expected - 1.0).abs() < 0.02, "{depth_mm}: {found} {expected}");
    }
}

/// Rays of a point of the scene land as far apart as the rays of a place look apart.
#[test]
fn aberrations_are_those_of_rays_from_the_scene() {
    for (file, f_number) in [("cooke-triplet-50mm.lens", 2.8), ("double-gauss-f2-tronnier.lens", 2.0)] {
        let d = CameraDescription { wavelength_nm: Some(587.6), ..with_lens(file, 36.0, 24.0, 0.0) }.with(|c| {
            c.lens.f_number = Some(f_number);
            c.focus.distance = None;
        });
        let survey = Survey::new(&d, SIZE[0], SIZE[1]).unwrap();
        let fans = survey.fans();
        let (found, place) = (fans.measure(&vec![None; fans.rays().len()]).aberration.value, Vec2::new(0.0, 0.0));
        // In the middle defocus is none, and what is left is spherical aberration.
        let middle = GRID[1] / 2 * GRID[0] + GRID[0] / 2;
        assert_eq!(Survey::place(GRID[0] / 2, GRID[1] / 2), place);
        let fan = &fans.fans[middle];
        let steps = fan.steps(Subject::Far).unwrap();
        let widest = fan.aside(&survey, Subject::Far, &steps).iter().flatten().map(|a| a.length()).fold(0.0, f64::max);
        // Parallel rays through a pupil as wide: the farthest from the axis on the film.
        let radius = 0.5 * survey.info().entrance_pupil_diameter_mm.unwrap();
        let lands = |height: f64| {
            let ray = LensRay { origin: DVec3::new(0.0, height, -50.0), direction: DVec3::Z };
            let out = survey.tracer.from_scene(ray).ok()?;
            Some(survey.mount.picture_point(&out)?.y.abs() * SIZE[1] as f32)
        };
        let scene = (0..=100).filter_map(|i| lands(radius * (0.99 * f64::from(i) / 100.0))).fold(0.0f32, f32::max);
        let ratio = widest / f64::from(scene);
        assert!((0.7..1.1).contains(&ratio), "{file}: {widest} {scene}");
        assert!(found >= 0.9 * widest, "{file}: {found} {widest}");
    }
}

/// A small film where another has its corner or its side shows as much: rims there cut the beam, and of a small film the
/// places lie nearer to each other than the beam's mean jumps when they take one ray more.
#[test]
fn a_part_of_the_film_is_measured_like_the_whole() {
    const PART: f64 = 0.05;
    for file in ["anamorphic-2x-front-focus.lens", "double-gauss-f2-tronnier.lens", "wide-angle-smith-f3.4.lens"] {
        let whole = CameraDescription { wavelength_nm: Some(587.6), ..with_lens(file, 22.0, 18.6, 0.0) }
            .with(|c| c.focus.distance = Some(4.0));
        for (column, row) in [(4, 4), (GRID[0] - 1, GRID[1] / 2)] {
            let place = Survey::place(column, row).as_dvec2();
            let part = whole.clone().with(|c| {
                c.film.width_mm = 22.0 * PART;
                c.film.height_mm = 18.6 * PART;
                c.film.shift_mm = [place.x * 22.0, place.y * 18.6];
            });
            let size = SIZE.map(|pixels| (f64::from(pixels) * PART) as u32);
            let surveys =
                [Survey::new(&whole, SIZE[0], SIZE[1]), Survey::new(&part, size[0], size[1])].map(Result::unwrap);
            let number = [row * GRID[0] + column, GRID[1] / 2 * GRID[0] + GRID[0] / 2];
            for depth in [None, Some(1.5), Some(20.0)] {
                // The largest of the exact blur and of what aberrations add to Gaussian optics', px.
                let [there, here] = [0, 1].map(|i| {
                    let fans = surveys[i].fans();
                    let fan = &fans.fans[number[i]];
                    let ray = surveys[i].mount.to_render(&fan.mean().unwrap());
                    let subject = fans.subject(depth.map(|depth| on_plane(&ray, depth).unwrap()));
                    let exact = fan.aside(&surveys[i], subject, &fan.steps(subject).unwrap());
                    let apart = exact.iter().zip(fan.ideal_aside(&surveys[i], subject));
                    let apart = apart.filter_map(|(a, b)| Some(((*a)? - b).length())).fold(0.0, f64::max);
                    let exact = exact.iter().flatten().map(|a| a.length()).fold(0.0, f64::max);
                    [exact, apart]
                });
                for (there, here) in there.into_iter().zip(here) {
                    // The two have pupil maps of their own, so that other rays are sent and other ones are cut.
                    let most = there.max(here);
                    assert!((there - here).abs() < 0.25 * most + 0.5, "{file} {place} {depth:?}: {there} {here} px");
                }
            }
        }
    }
}

/// Distortion of an infinitely far subject: f tan θ against the exact chief ray on the film.
#[test]
fn distortion_is_the_way_from_f_tan_theta() {
    let d =
        CameraDescription { wavelength_nm: Some(587.6), ..with_lens("wide-angle-smith-f3.4.lens", 120.0, 80.0, 0.0) }
            .with(|c| {
                c.focus.distance = None;
                c.lens.f_number = Some(16.0);
            });
    let survey = Survey::new(&d, SIZE[0], SIZE[1]).unwrap();
    let found = measured(&d, SIZE, None).distortion;
    let f = survey.info().efl_mm.unwrap();
    let corner = survey.fans().fans[0].mean().unwrap().direction;
    let ideal_mm = f * corner.truncate().length() / -corner.z;
    let film_mm = 0.5 * 120.0f64.hypot(80.0);
    let expected = (film_mm - ideal_mm).abs() * f64::from(SIZE[0]) / 120.0;
    assert!(found.place.abs().min_element() > 0.49, "{found:?}");
    assert!((found.value / expected - 1.0).abs() < 0.02, "{} {expected}", found.value);
}

/// A fisheye has directions that no flat picture can show.
#[test]
fn a_fisheye_is_without_bound() {
    let found = measured(&with_lens("laikin-fisheye-170.lens", 24.0, 16.0, 0.0), SIZE, None);
    assert!(found.distortion.value > 100.0);
    assert!(found.dark_part >= 0.0 && found.defocus.value.is_finite());
}

/// A point at infinity, looked at through the whole lens at two wavelengths from the scene.
#[test]
fn colours_part_as_for_rays_from_the_scene() {
    let d = with_lens("cooke-triplet-50mm.lens", 36.0, 24.0, 0.0).with(|c| c.focus.distance = None);
    let d = d.with(|c| c.lens.f_number = Some(8.0));
    let survey = Survey::new(&d, SIZE[0], SIZE[1]).unwrap();
    let found = measured(&d, SIZE, None).lateral_colour;
    let corner = survey.fans().fans[0].mean().unwrap();
    let landing = |tracer: &Tracer| {
        let radius = 0.5 * survey.info().entrance_pupil_diameter_mm.unwrap();
        let start = corner.origin + corner.direction * 30.0;
        let side = corner.direction.cross(DVec3::X).normalize();
        let rays = (0..64).filter_map(|i| {
            let turn = DVec2::from_angle(2.399_963 * f64::from(i)) * radius * (f64::from(i) / 64.0).sqrt();
            let origin = start + side * turn.x + side.cross(corner.direction) * turn.y;
            let out = tracer.from_scene(LensRay { origin, direction: -corner.direction }).ok()?;
            survey.mount.picture_point(&out).map(|p| p.as_dvec2())
        });
        let all: Vec<DVec2> = rays.collect();
        all.iter().sum::<DVec2>() / all.len() as f64 * survey.size_px
    };
    let ends = [0, 3].map(|i| landing(&survey.colours[i]));
    let expected = (ends[0] - ends[1]).length();
    // Which rays pass near the rims differs a little between the two ways; between the ends a colour may lie farther out.
    assert!(found.value > 0.8 * expected && found.value < 1.6 * expected + 0.1, "{} {expected}", found.value);
}

/// A small stop at a distance from the film, without glass: cos⁴.
#[test]
fn vignetting_of_a_bare_stop_is_cos_to_the_fourth() {
    let file = std::env::temp_dir().join(format!("petzval-survey-{}.lens", std::process::id()));
    std::fs::write(&file, "0 0 air 0.2 0 1\n1e6 50 1.0000001 30 0 0\n-1e6 50 air 30 0 0\n").unwrap();
    let d = CameraDescription { lens_path: file.clone(), wavelength_nm: Some(587.6), ..CameraDescription::default() }
        .with(|c| {
            c.focus.film_distance_mm = Some(50.0);
            c.film.width_mm = 36.0;
            c.film.height_mm = 24.0;
        });
    let found = measured(&d, SIZE, None).vignetting;
    std::fs::remove_file(file).unwrap();
    let cos = 100.0 / (100.0f64.powi(2) + 18.0 * 18.0 + 12.0 * 12.0).sqrt();
    let expected = -4.0 * cos.log2();
    assert!((found.value / expected - 1.0).abs() < 0.02, "{} {expected}", found.value);
}

/// No measure is ever NaN, whatever the lens (every third; all by `make test-all`) and the film; mirrors, eyes, films that are turned (for
/// every second lens; for all by `make test-all`) and light paths that end.
#[test]
fn all_lenses_are_measured() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
    let mut count = 0;
    for (number, path) in petzval_testkit::lenses::third(folder, 2).into_iter().enumerate() {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let tilts = if petzval_testkit::is_thorough() { &[0.0, 0.1][..] } else { &[[0.0], [0.1]][number % 2][..] };
        for &tilt in tilts {
            let small = if name.starts_with("eye") { 4.0 } else { 12.0 };
            let d = with_lens(&name, small, small / 1.5, tilt);
            let Ok(survey) = Survey::new(&d, 640, 427) else { continue };
            let fans = survey.fans();
            let rays = fans.rays();
            for depth in [None, Some(1.0), Some(1e5)] {
                let seen: Vec<Option<DVec3>> = rays.iter().map(|ray| on_plane(ray.as_ref()?, depth?)).collect();
                let m = fans.measure(&seen);
                let all =
                    [m.defocus, m.aberration, m.distortion, m.lateral_colour, m.axial_colour, m.vignetting, m.cats_eye];
                assert!(all.iter().all(|one| one.value >= 0.0), "{name} {depth:?}: {m:?}");
                assert!(
                    m.airy_px > 0.0 && m.transmission.value.is_finite() && m.luminous > 0.2 && m.luminous <= 1.0,
                    "{name}: {m:?}"
                );
                assert!(survey.ghost_value() >= 0.0 && survey.f_number_by_area() > 0.0);
                count += 1;
            }
        }
    }
    assert!(count > if petzval_testkit::is_thorough() { 70 } else { 35 }, "{count}");
}
