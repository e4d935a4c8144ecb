//! Focus found in a world, against the rays of the camera that is then made.

use super::*;
use crate::camera::{Camera, lens_info, tests::with_lens};
use petzval_optics::focus::Relation;
use petzval_optics::system::FocalLength;

const PIXELS: [u32; 2] = [300, 200];
const ANCHORS: [Anchor; 3] = [Anchor::EntrancePupil, Anchor::FrontVertex, Anchor::Film];

/// A camera somewhere in the world, not along its axes.
fn described(anchor: Anchor, tilt_rad: f64) -> CameraDescription {
    let matrix_world = glam::DMat4::from_translation(DVec3::new(5.0, -3.0, 1.0))
        * glam::DMat4::from_rotation_y(0.4)
        * glam::DMat4::from_rotation_x(-0.2);
    let focusing = Focusing { anchor, relation: Relation::Exact };
    CameraDescription { matrix_world, ..with_lens("double-gauss-f2-available.lens", 36.0, 24.0, tilt_rad) }
        .with(|c| c.focus.focusing = focusing)
}

/// A wall at that depth of the camera, not at right angles to it.
fn wall(d: &CameraDescription, depth: f64, lean: f64) -> impl Fn(&Ray) -> Option<f32> {
    let to_camera = glam::DMat3::from_mat4(d.matrix_world).transpose();
    move |ray| {
        let (o, r) = (to_camera * ray.origin.as_dvec3(), to_camera * ray.direction.as_dvec3());
        // z = lean x − depth.
        let t = (lean * o.x - depth - o.z) / (r.z - lean * r.x);
        (t > 0.0).then_some(t as f32)
    }
}

fn focused(d: &CameraDescription, f: &SharpFilm) -> CameraDescription {
    let film_distance_mm = Some(f.film_distance_mm);
    d.clone().with(|c| {
        c.focus.film_distance_mm = film_distance_mm;
        c.film.tilt_rad = f.tilt_rad;
        c.film.swing_rad = f.swing_rad;
    })
}

/// Mean square distance, in world units, by which a picture point's rays pass `subject`; and of the nearest picture point
/// where that is smallest.
fn blur(d: &CameraDescription, p: Vec2, subject: DVec3) -> f64 {
    let camera = Camera::new(d, PIXELS[0], PIXELS[1]).unwrap();
    let to = (subject - d.position()).as_vec3a();
    let passing: Vec<glam::DVec3> = (0..4096)
        .filter_map(|i| {
            let u = sobol_burley::sample_4d(i, 0, 5);
            let ray = camera.sample(p, [u[0], u[1]], u[2])?.ray;
            let from = to - ray.origin;
            Some((from - ray.direction * from.dot(ray.direction)).as_dvec3())
        })
        .collect();
    assert!(passing.len() > 2000);
    let middle = passing.iter().sum::<DVec3>() / passing.len() as f64;
    passing.iter().map(|q| (*q - middle).length_squared()).sum::<f64>() / passing.len() as f64
}

#[test]
fn what_a_picture_point_sees_is_sharpest() {
    for anchor in ANCHORS {
        for (p, tilt_rad) in [(Vec2::ZERO, 0.0), (Vec2::new(0.3, -0.2), 0.0), (Vec2::new(-0.3, 0.25), 0.1)] {
            // One wavelength: a film's colours have other weights than the eye's.
            let d = CameraDescription { wavelength_nm: Some(D_LINE_NM), ..described(anchor, tilt_rad) };
            let found = on_picture_point(&d, PIXELS, p, wall(&d, 2.5, 0.4)).unwrap();
            let subject = found.subject_world.unwrap();
            let at = |off: f64| {
                let moved = SharpFilm { film_distance_mm: found.film_distance_mm + off, ..found };
                blur(&focused(&d, &moved), p, subject)
            };
            // A step of the film by the spot's depth, at either side, blurs more; the vertex of the parabola is here but
            // for the noise of a few thousand rays and for what is sharp being seen, not cast.
            let step = 0.3;
            let [low, here, high] = [at(-step), at(0.0), at(step)];
            let off = 0.5 * step * (low - high) / (low - 2.0 * here + high);
            assert!(off.abs() < 0.02, "{anchor:?} {p} {tilt_rad}: {off}, {low} {here} {high}");
            // On the wall.
            let camera = d.matrix_world.inverse().transform_point3(subject);
            assert!((camera.z - 0.4 * camera.x + 2.5).abs() < 1e-5, "{camera}");
        }
    }
}

/// The scale agrees with the film.
#[test]
fn the_film_and_the_scale_say_the_same() {
    for anchor in ANCHORS {
        for relation in [Relation::Exact, Relation::Thin] {
            let d = described(anchor, 0.0);
            let d = d.with(|c| {
                c.focus.focusing = Focusing { anchor, relation };
                c.lens.f_number = Some(11.0);
            });
            let found = on_picture_point(&d, PIXELS, Vec2::ZERO, wall(&d, 2.0, 0.0)).unwrap();
            let scale = found.focus_scale_mm.unwrap();
            let by_scale = d.clone().with(|c| c.focus.distance = Some(scale / 1000.0));
            let info = lens_info(&by_scale, PIXELS[0], PIXELS[1]).unwrap();
            assert!((info.film_distance_mm - found.film_distance_mm).abs() < 1e-9, "{anchor:?} {relation:?}");
            assert!((info.focus_scale_mm.unwrap() - scale).abs() < 1e-6);
            // Spherical aberration and the colours leave a part of the depth of field, which is some 5 % here.
            if relation == Relation::Exact {
                assert!((scale / 2000.0 - 1.0).abs() < 0.02, "{scale}");
            }
        }
    }
}

#[test]
fn the_sky_is_at_infinity() {
    let d = described(Anchor::EntrancePupil, 0.0);
    let found = on_picture_point(&d, PIXELS, Vec2::new(0.1, 0.4), |_| None).unwrap();
    assert_eq!(found.subject_world, None);
    let far = lens_info(&d.with(|c| c.focus.distance = None), PIXELS[0], PIXELS[1]).unwrap();
    // Field curvature and spherical aberration of this lens leave some tenths of a millimetre.
    assert!((found.film_distance_mm - far.film_distance_mm).abs() < 0.5, "{found:?} {}", far.film_distance_mm);
}

/// The focus to first order is the paraxial one of the subject, wherever in the picture it is and however the film turns.
#[test]
fn a_lens_of_first_order_is_focused_exactly() {
    for tilt_rad in [0.0, 0.1] {
        let d = CameraDescription { model: Model::Thick, ..described(Anchor::FrontVertex, tilt_rad) };
        let p = Vec2::new(0.3, -0.4);
        let found = on_picture_point(&d, PIXELS, p, wall(&d, 1.5, 0.0)).unwrap();
        let subject = found.subject_world.unwrap();
        // Chief rays are the real lens's, whose distortion moves the image: the wall is sharp over the whole picture while
        // the film is upright, and else along it.
        if tilt_rad == 0.0 {
            assert!(blur(&focused(&d, &found), p, subject).sqrt() < 1e-4, "{}", blur(&focused(&d, &found), p, subject));
            assert!((found.focus_scale_mm.unwrap() - 1500.0).abs() < 1e-3);
        } else {
            let near = (-40..=40).flat_map(|x| (-40..=40).map(move |y| Vec2::new(x as f32, y as f32) * 1e-4));
            let least =
                near.step_by(7).map(|off| blur(&focused(&d, &found), p + off, subject)).fold(f64::MAX, f64::min);
            assert!(least.sqrt() < 2e-4, "{}", least.sqrt());
        }
    }
}

#[test]
fn three_points_of_the_world_are_sharp() {
    for anchor in ANCHORS {
        let d = described(anchor, 0.0);
        let points = [[-0.3, -0.2, -1.8], [0.3, -0.1, -1.3], [0.0, 0.3, -2.4]].map(DVec3::from);
        let points = points.map(|p| d.matrix_world.transform_point3(p));
        let found = on_three_points(&d, PIXELS, points).unwrap();
        let camera = focused(&d, &found);
        for point in points {
            // The film that a point by itself asks for is this one.
            let mut finder = Finder::new(&camera, PIXELS[0], PIXELS[1]).unwrap();
            let z_mm = finder.system.last_vertex_z_mm() + found.film_distance_mm;
            finder.put(FilmPlane { z_mm, ..finder.mount.film });
            let (film, rms) = finder.sharpest(SubjectHit::Point(point - d.position())).unwrap();
            assert!((film.z_mm - z_mm).abs() < 1e-6, "{anchor:?}: {} {z_mm}", film.z_mm);
            assert!(rms <= found.rms_spot_mm * (1.0 + 1e-6));
        }
        assert!(found.swing_rad.abs() > 0.01 && found.tilt_rad.abs() > 0.001, "{found:?}");
    }
}

#[test]
fn what_cannot_be_focused_says_why() {
    let d = described(Anchor::EntrancePupil, 0.0);
    let text = |r: Result<SharpFilm, CameraError>| r.unwrap_err().to_string();
    let pinhole = CameraDescription { model: Model::Pinhole, ..d.clone() };
    assert!(text(on_picture_point(&pinhole, PIXELS, Vec2::ZERO, |_| None)).contains("camera model"));
    let close = text(on_picture_point(&d, PIXELS, Vec2::ZERO, wall(&d, 0.08, 0.0)));
    assert!(close.contains("autofocus point"), "{close}");
    let line = [1.0, 2.0, 3.0].map(|t| d.matrix_world.transform_point3(DVec3::new(0.1 * t, 0.05 * t, -t)));
    assert!(text(on_three_points(&d, PIXELS, line)).contains("one line"));
    let behind = [[0.0, 0.0, 1.0], [0.3, -0.1, -1.3], [0.0, 0.3, -2.4]].map(DVec3::from);
    let behind = text(on_three_points(&d, PIXELS, behind.map(|p| d.matrix_world.transform_point3(p))));
    assert!(behind.contains("sharp point 1 of 3"), "{behind}");
    let nowhere = on_three_points(&d, PIXELS, [DVec3::NAN, DVec3::X, DVec3::Y]);
    assert!(text(nowhere).contains("not finite"));
}

/// A lens that focuses inside: its groups move, the film stays, and a change of the distance either way blurs.
#[test]
fn groups_move_to_what_a_picture_point_sees() {
    let zoom = with_lens("zoom-nikon-57-143-f2.8.lens", 24.0, 16.0, 0.0);
    for (p, mm) in [(Vec2::ZERO, 100.0), (Vec2::new(0.3, -0.2), 60.0)] {
        let d = CameraDescription { wavelength_nm: Some(D_LINE_NM), ..zoom.clone() }.with(|c| {
            c.lens.focal_length = FocalLength::Millimetres(mm);
            c.focus.focusing = Focusing { anchor: Anchor::FrontVertex, relation: Relation::Exact };
        });
        let found = on_picture_point(&d, PIXELS, p, wall(&d, 3.0, 0.4)).unwrap();
        assert!(found.moves_groups);
        let subject = found.subject_world.unwrap();
        let at = |nearer: f64| {
            let metres = found.focus_scale_mm.unwrap() * 1e-3 / nearer;
            d.clone().with(|c| c.focus.distance = Some(metres))
        };
        let place = |d: &CameraDescription| lens_info(d, PIXELS[0], PIXELS[1]).unwrap();
        let far = d.clone().with(|c| c.focus.distance = None);
        assert!((place(&at(1.0)).film_distance_mm - place(&far).film_distance_mm).abs() < 1e-9);
        assert!((found.film_distance_mm - place(&far).film_distance_mm).abs() < 1e-9);
        let step = 0.04;
        let [low, here, high] = [1.0 - step, 1.0, 1.0 + step].map(|nearer| blur(&at(nearer), p, subject));
        let off = 0.5 * step * (low - high) / (low - 2.0 * here + high);
        assert!(off.abs() < 0.003, "{p} {mm}: {off}, {low} {here} {high}");
    }
}
