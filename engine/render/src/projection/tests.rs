use super::*;
use std::f64::consts::PI;

const SENSOR_MM: [f64; 2] = [36.0, 24.0];

fn panorama(projection: Projection) -> Panorama {
    Panorama { projection, shift: [0.0; 2] }
}

fn all() -> [Projection; 8] {
    [
        Projection::Equirectangular { longitude_rad: [-PI, PI], latitude_rad: [-FRAC_PI_2, FRAC_PI_2] },
        Projection::Equirectangular { longitude_rad: [-0.5, 1.0], latitude_rad: [0.1, 0.7] },
        Projection::EquiangularCubemapFace,
        Projection::MirrorBall,
        Projection::FisheyeEquidistant { field_rad: 1.2 * PI },
        Projection::FisheyeEquisolid { focal_length_mm: 10.5, field_rad: PI, sensor_mm: SENSOR_MM },
        Projection::FisheyeLensPolynomial {
            coefficients: [-1.1735e-5, -0.019_988_7, -3.352_5e-6, 3.099_7e-6, -2.606_4e-8],
            field_rad: PI,
            sensor_mm: SENSOR_MM,
        },
        Projection::CentralCylindrical { longitude_rad: [-PI, PI], height: [-1.0, 0.5] },
    ]
}

#[test]
fn a_direction_lies_where_the_picture_shows_it() {
    for projection in all() {
        for shift in [[0.0, 0.0], [0.1, -0.05]] {
            let panorama = Panorama { projection, shift };
            let mut seen = 0;
            for (i, j) in (1..20).flat_map(|i| (1..20).map(move |j| (i, j))) {
                // The seams of a whole turn stay outside.
                let p = DVec2::new(0.045 * f64::from(i) - 0.44, 0.045 * f64::from(j) - 0.44) - DVec2::from(shift);
                let Some(d) = panorama.direction(p) else { continue };
                assert!((d.length() - 1.0).abs() < 1e-12, "{projection:?} {p}");
                let place = panorama.place(3.0 * d).unwrap();
                assert!(place.distance(p) < 1e-9, "{projection:?} {shift:?} {p}: {place}");
                seen += 1;
            }
            assert!(seen > 200, "{projection:?}: {seen}");
        }
    }
}

/// The angles that photographers know each projection by.
#[test]
fn angles_are_those_of_the_formulas() {
    let seen = |projection, x: f64, y: f64| panorama(projection).direction(DVec2::new(x, y)).unwrap();
    let [whole, part, cube, ball, equidistant, equisolid, _, cylinder] = all();
    let near = |a: DVec3, b: DVec3| assert!(a.distance(b) < 1e-12, "{a} {b}");
    near(seen(whole, 0.0, 0.0), DVec3::NEG_Z);
    near(seen(whole, 0.25, 0.0), DVec3::X);
    near(seen(whole, 0.1, 0.5), DVec3::Y);
    near(
        seen(part, -0.5, -0.5),
        DVec3::new(-0.1_f64.cos() * 0.5_f64.sin(), 0.1_f64.sin(), -0.1_f64.cos() * 0.5_f64.cos()),
    );
    near(seen(cube, 0.5, 0.0), DVec3::new(1.0, 0.0, -1.0).normalize());
    // Half of the ball's radius: twice the normal's angle from the axis.
    near(seen(ball, 0.25, 0.0), DVec3::new((PI / 3.0).sin(), 0.0, -(PI / 3.0).cos()));
    near(seen(equidistant, 0.0, 0.25), DVec3::new(0.0, (0.3 * PI).sin(), -(0.3 * PI).cos()));
    // 2 f sin(angle / 2) from the centre.
    let angle: f64 = 0.9;
    near(seen(equisolid, 21.0 * (0.5 * angle).sin() / 36.0, 0.0), DVec3::new(angle.sin(), 0.0, -angle.cos()));
    near(seen(cylinder, 0.25, 0.5), DVec3::new(1.0, 0.5, 0.0).normalize());
}

#[test]
fn nothing_is_seen_beyond_a_circle() {
    let [.., ball, equidistant, equisolid, polynomial, _] = all();
    for projection in [ball, equidistant, equisolid] {
        assert_eq!(panorama(projection).direction(DVec2::splat(0.49)), None, "{projection:?}");
    }
    let Projection::FisheyeLensPolynomial { coefficients, sensor_mm, .. } = polynomial else { unreachable!() };
    let narrow = Projection::FisheyeLensPolynomial { coefficients, field_rad: 0.2, sensor_mm };
    assert_eq!(panorama(narrow).direction(DVec2::new(0.4, 0.0)), None);
}

/// Poles, the way back and polynomials without an inverse: a place or none, never NaN.
#[test]
fn no_direction_has_an_undefined_place() {
    let flat = Projection::FisheyeLensPolynomial { coefficients: [0.0; 5], field_rad: PI, sensor_mm: SENSOR_MM };
    let none = Projection::Equirectangular { longitude_rad: [1.0, 1.0], latitude_rad: [0.0, 0.0] };
    for projection in all().into_iter().chain([flat, none]) {
        for d in [DVec3::X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z, DVec3::ZERO, DVec3::splat(1e-300)] {
            assert!(panorama(projection).place(d).is_none_or(DVec2::is_finite), "{projection:?} {d}");
        }
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let field = |field_rad| panorama(Projection::FisheyeEquidistant { field_rad }).check();
    assert!(field(PI).is_ok());
    assert!(field(0.0).unwrap_err().contains("field of view"));
    assert!(field(f64::NAN).unwrap_err().contains("field of view"));
    let shifted = Panorama { projection: Projection::MirrorBall, shift: [f64::NAN, 0.0] };
    assert!(shifted.check().unwrap_err().contains("shift"));
}

/// A pixel of 360 columns is a degree wide.
#[test]
fn a_pixel_subtends_its_angle() {
    let [whole, ..] = all();
    let [x, y] = panorama(whole).step_rad(DVec2::new(1.0 / 360.0, 1.0 / 180.0));
    assert!((x.to_degrees() - 1.0).abs() < 1e-9 && (y.to_degrees() - 1.0).abs() < 1e-9, "{x} {y}");
}
