//! The hinge rule (Merklinger 1992): the plane that a turned film shows sharp goes through the line in which the object
//! focal plane intersects the plane that is parallel to the film and goes through the object principal point. Held against
//! exact rays near the axis.

use crate::common::system;
use glam::{DVec2, DVec3};
use petzval_optics::focus::{FilmPlane, Focus};
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::System;
use petzval_optics::trace::{Ray, Tracer};

/// A point of the hinge, the hinge's direction, and the point of the axis that is focused on; lens space.
fn hinge(system: &System, film: &FilmPlane, object_z_mm: f64) -> [DVec3; 3] {
    let info = Paraxial::new(system, line_nm::D);
    let focal_z = info.object_focal_plane_mm.unwrap();
    let height = focal_z - info.object_principal_plane_mm.unwrap();
    let normal = film.normal();
    let flat = DVec2::new(normal.x, normal.y);
    // On the hinge normal · (x, y, height) = 0.
    let nearest = flat * (-normal.z * height / flat.length_squared());
    [nearest.extend(focal_z), DVec3::new(-flat.y, flat.x, 0.0), DVec3::new(0.0, 0.0, object_z_mm)]
}

/// The point at which two rays from one point of the film, close to each other, come nearest in the scene.
fn image(tracer: &Tracer, from: DVec3, towards: DVec3, apart: f64) -> DVec3 {
    let ray = |x: f64| {
        let to = towards + DVec3::new(x, x, 0.0);
        let out = tracer.from_film(Ray { origin: from, direction: (to - from).normalize() }).unwrap();
        (out.origin, out.direction)
    };
    let ((p, d), (q, e)) = (ray(-apart), ray(apart));
    let (w, de) = (p - q, d.dot(e));
    let t = (de * e.dot(w) - d.dot(w)) / (1.0 - de * de);
    let s = (e.dot(w) - de * d.dot(w)) / (1.0 - de * de);
    0.5 * ((p + d * t) + (q + e * s))
}

#[test]
fn the_plane_of_sharp_focus_goes_through_the_hinge() {
    let lenses =
        ["double-gauss-f2-tronnier", "tessar-brendel", "seed-wide-angle", "pbrt-telephoto-250mm", "planar-80-f2.8"];
    let turns = [[5.0, 0.0], [0.0, -12.0], [20.0, 0.0], [0.0, 20.0], [-8.0, 15.0], [30.0, -25.0]];
    for name in lenses {
        let system = system(name);
        let tracer = system.at_wavelength(line_nm::D);
        let info = Paraxial::new(&system, line_nm::D);
        let size = info.efl_mm.unwrap();
        for (distance, [tilt, swing]) in [8.0, 30.0].into_iter().flat_map(|f| turns.map(|t| (f * size, t))) {
            let focus = Focus::at_distance(&system, line_nm::D, distance).unwrap();
            let film = FilmPlane {
                tilt_rad: f64::to_radians(tilt),
                swing_rad: f64::to_radians(swing),
                ..FilmPlane::upright(focus.film_z_mm)
            };
            let [hinge, along, axis] = hinge(&system, &film, focus.object_plane_mm.unwrap());
            let normal = along.cross(hinge - axis).normalize();
            let exit = DVec3::new(0.0, 0.0, info.exit_pupil.z_mm.unwrap());
            // How far from the plane the image of a film point lies, over how far it lies from the middle's, and from
            // the plane that an upright film would see.
            let error = |step: f64| {
                let (mut worst, mut leaning) = (0.0f64, 0.0f64);
                let seen = |u: f64, v: f64| image(&tracer, film.point(u, v), exit, 5e-4 * size);
                let middle = seen(0.0, 0.0);
                assert!((middle - axis).length() < 1e-4 * distance, "{name}: {middle} {axis}");
                for [u, v] in [[step, 0.0], [0.0, step], [-step, step]] {
                    let at = seen(u, v);
                    let far = (at - middle).length();
                    worst = worst.max((at - middle).dot(normal).abs() / far);
                    leaning = leaning.max((at.z - middle.z).abs() / far);
                }
                [worst, leaning]
            };
            let [[coarse, leaning], [fine, _]] = [error(4e-3 * size), error(2e-3 * size)];
            // Field curvature and astigmatism are of the second order in the height on the film: half the step, half
            // the angle.
            assert!(leaning > 0.3, "{name} {tilt} {swing}: {leaning}");
            assert!(coarse < 0.03 && fine < 0.6 * coarse + 1e-6, "{name} {distance} {tilt} {swing}: {coarse} {fine}");
            // To first order nothing is left.
            assert!((2.0 * fine - coarse).abs() < 2e-3, "{name} {distance} {tilt} {swing}: {coarse} {fine}");
        }
    }
}
