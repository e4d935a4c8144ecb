//! Strands against their definition, in double precision; and that nothing passes between their pieces.

use super::*;
use crate::scene::curves::{Controls, CurveShape, CurvesDescription};
use crate::scene::motion::Pose;
use crate::surface::SurfacePoint;
use glam::{DVec2, Quat, Vec4};

const RIBBON: CurveShape = CurveShape::Ribbon { pieces: 5 };
/// Steps of a segment in double precision.
const FINE: usize = 400;

/// A scene of one strand through these keys, so often.
fn strand(keys: &[Vec4], shape: CurveShape, places: &[DMat4]) -> Scene {
    changing(keys, &[], shape, places)
}

/// A scene of one strand through these keys, so often, and through others while the shutter is open.
fn changing(keys: &[Vec4], poses: &[Vec<Vec4>], shape: CurveShape, places: &[DMat4]) -> Scene {
    let mut builder = SceneBuilder::new();
    let curves = CurvesDescription {
        name: "hair".into(),
        keys: keys.to_vec(),
        first_keys: vec![0, keys.len() as u32],
        shape,
        first_number: 0,
        uv_maps: vec![],
        attributes: vec![],
        moved_keys: None,
        poses: poses.to_vec(),
    };
    let mesh = builder.add_curves(curves).unwrap();
    for &place in places {
        builder.add_instance("hair", mesh, place, &[], true, true).unwrap();
    }
    builder.build(DVec3::ZERO)
}

/// A strand that bends gently, about as long as there are keys, on its way along x.
fn bent(seed: u32, keys: usize, radius: f32) -> Vec<Vec4> {
    (0..keys)
        .map(|i| {
            let u = sobol_burley::sample_4d(i as u32, 0, seed);
            Vec4::new(i as f32, 0.5 * u[0], 0.5 * u[1], radius * (0.6 + 0.4 * u[2]))
        })
        .collect()
}

/// Places and radii along a strand, in double precision; the last of a segment is the first of the next.
fn finely(scene: &Scene) -> Vec<(DVec3, f64)> {
    let curves = scene.meshes[0].curves.as_ref().unwrap();
    let range = curves.keys_of(0);
    let mut out = vec![];
    for segment in range.start..range.end - 1 {
        let Controls(controls) = curves.controls(0, segment, Pose::default());
        let [p, a, b, q] = controls.map(Vec4::as_dvec4);
        for i in 0..FINE {
            let u = i as f64 / FINE as f64;
            let at =
                a + u * (0.5 * (b - p) + u * (p - 2.5 * a + 2.0 * b - 0.5 * q + u * (0.5 * (q - p) + 1.5 * (a - b))));
            out.push((at.truncate(), at.w));
        }
    }
    out
}

/// A ray from a distance at a place near a strand, in any direction.
fn ray_at(target: Vec3A, u: [f32; 4], distance: f32) -> Ray {
    let d = direction([u[0], u[1]]);
    Ray::new(target - d * distance, d)
}

/// Distance of a place outside of the round body of a curve, points and radii.
fn outside_of(curve: &[(DVec3, f64)], place: DVec3) -> f64 {
    curve.iter().map(|(p, r)| (place - *p).length() - r).fold(f64::INFINITY, f64::min)
}

/// Ten rays of a seed, from so far away, at a round strand: each hits the strand where the ray enters the round body about the curve.
fn is_round(seed: u32, far: f32) -> Result<(), TestCaseError> {
    let keys = bent(seed, 5, 0.2);
    let scene = strand(&keys, CurveShape::Thick, &[DMat4::IDENTITY]);
    let (accel, curve) = (Accel::new(&scene), finely(&scene));
    for i in 0..10 {
        let u = sobol_burley::sample_4d(i, 1, seed);
        let ray = ray_at(Vec3A::new(0.7 + 2.6 * u[2], 0.5 * u[3], 0.5 * u[0]), u, far);
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let outside = |t: f64| outside_of(&curve, o + d * t);
        // Follows the ray, never farther than the body is.
        let mut t = 0.0;
        let mut depth = f64::INFINITY;
        if outside(t) < 0.1 {
            continue;
        }
        while t < f64::from(far) + 5.0 {
            depth = depth.min(outside(t));
            if depth < 1e-4 {
                break;
            }
            t += outside(t).max(1e-4);
        }
        let hit = accel.closest(&ray, Rays::CAMERA);
        if let Some(hit) = hit.filter(|hit| hit.v <= 1.0) {
            prop_assert!(outside(f64::from(hit.t)).abs() < 0.006, "{hit:?} is {} outside", outside(f64::from(hit.t)));
            let point = SurfacePoint::new(&scene, &hit, ray.direction);
            let off = (point.position - ray.origin - ray.direction * hit.t).length();
            let at = ((hit.triangle as f64 + f64::from(hit.u)) * FINE as f64) as usize;
            let [before, here, after] = [at.saturating_sub(1), at, at + 1].map(|i| curve[i.min(curve.len() - 1)].0);
            // At its outline a small part of its radius is a long way along the ray. And where the ray goes along the strand,
            // what is across both turns a long way with a small bend: the place stays on the strand, not before the ray.
            let is_along = (after - before).normalize().dot(d).abs() > 0.98;
            let is_hard = hit.v.abs() > 0.95 || is_along;
            // The hit and the place are each within 0.006 of the surface, across it: along the ray that is more, where the ray
            // is oblique.
            let along_ray = 0.01 / point.shading_normal.dot(ray.direction).abs();
            prop_assert!(off < along_ray.max(0.02) || is_hard, "{off} {hit:?}");
            prop_assert!(point.shading_normal.dot(ray.direction) < 1e-3);
            prop_assert!(outside_of(&curve, point.position.as_dvec3()).abs() < 0.02, "{hit:?}");
            let out = (o + d * f64::from(hit.t) - here).normalize();
            prop_assert!(out.dot(point.shading_normal.as_dvec3()) > 0.98 || is_hard);
        }
        // Its ends are open: who looks in sees the inside, later.
        let met = o + d * t;
        if depth < 1e-4 && met.x > 0.3 && met.x < 3.7 {
            // Unless it only grazes.
            let deepest = (0..200).map(|i| outside(t + 0.002 * f64::from(i))).fold(f64::INFINITY, f64::min);
            if deepest < -0.02 {
                // Or before that, where the ray passes so close by that it is on the surface, as was found above of what is hit
                // from outside.
                let is_graze = |hit: &Hit| f64::from(hit.t) < t && hit.v <= 1.0;
                let is_it = |hit: &Hit| (f64::from(hit.t) - t).abs() < 0.05 || is_graze(hit);
                prop_assert!(hit.as_ref().is_some_and(is_it), "{t} {hit:?}");
            }
        } else if depth > 0.01 {
            prop_assert!(hit.is_none(), "met {depth} outside: {hit:?}");
        }
    }
    Ok(())
}

/// A known fault: about one ray in some 100,000 near a round strand passes the joint of two pieces, and hits the strand from within.
#[test]
#[ignore = "a ray passes the joint of two pieces: not mended yet"]
fn no_ray_passes_a_joint() {
    is_round(24_529, 3.0).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// A ribbon is hit where the ray passes the curve, as it is seen along the ray, at less than the radius; across the axes, too, where
    /// its segments are divided.
    #[test]
    fn ribbons_are_as_wide_as_they_should_be(seed in 0u32..60000, far in 3f32..30.0, is_across in any::<bool>()) {
        let turn = if is_across { Quat::from_rotation_arc(Vec3::X, Vec3::ONE.normalize()) } else { Quat::IDENTITY };
        let turned = |key: Vec4| (turn * key.truncate()).extend(key.w);
        let keys: Vec<Vec4> = bent(seed, 5, 0.05).into_iter().map(turned).collect();
        let scene = strand(&keys, CurveShape::Ribbon { pieces: 16 }, &[DMat4::IDENTITY]);
        let (accel, curve) = (Accel::new(&scene), finely(&scene));
        for i in 0..20 {
            let u = sobol_burley::sample_4d(i, 1, seed);
            let target = turn * Vec3A::new(0.5 + 3.0 * u[2], 0.5 * u[3], 0.5 * u[0]);
            let ray = ray_at(target, u, far);
            // Seen along it, a strand folds up within less than its width, where ribbons are no good reference.
            if ray.direction.dot(turn * Vec3A::X).abs() > 0.7 {
                continue;
            }
            let (x, y) = ray.direction.any_orthonormal_pair();
            let flat = |p: DVec3| {
                let from = p - ray.origin.as_dvec3();
                DVec2::new(from.dot(x.as_dvec3()), from.dot(y.as_dvec3()))
            };
            let (nearest, _) = curve.iter().enumerate().map(|(i, (p, r))| (i, flat(*p).length() / r)).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let share = flat(curve[nearest].0).length() / curve[nearest].1;
            let hit = accel.closest(&ray, Rays::CAMERA);
            // Near its edge its pieces may differ.
            if share < 0.97 {
                prop_assert!(hit.is_some(), "missed at {share}");
                let hit = hit.unwrap();
                let at = hit.triangle as f64 + f64::from(hit.u);
                prop_assert!((at - nearest as f64 / FINE as f64).abs() < 0.03, "{at} {nearest}");
                prop_assert!((f64::from(hit.v.abs()) - share).abs() < 0.05, "{} {share}", hit.v);
                // The point is where the ray is.
                let point = SurfacePoint::new(&scene, &hit, ray.direction);
                prop_assert!((point.position - ray.origin - ray.direction * hit.t).length() < 0.01);
            } else if share > 1.03 && nearest > 8 && nearest < curve.len() - 8 {
                prop_assert!(hit.is_none(), "met at {share}: {hit:?}");
            }
        }
    }

    /// A round strand is hit where the ray first comes as near to the curve as its radius.
    #[test]
    fn round_strands_are_round(seed in 0u32..60000, far in 3f32..30.0) {
        is_round(seed, far)?;
    }

    /// Straight thick strands are the body that a ball sweeps, ends and corners included.
    #[test]
    fn straight_strands_are_swept_by_balls(seed in 0u32..60000, far in 3f32..30.0) {
        let keys = bent(seed, 4, 0.4);
        let scene = strand(&keys, CurveShape::ThickLinear, &[DMat4::IDENTITY]);
        let accel = Accel::new(&scene);
        for i in 0..20 {
            let u = sobol_burley::sample_4d(i, 1, seed);
            let ray = ray_at(Vec3A::new(4.0 * u[2] - 0.5, 0.5 * u[3], 0.5 * u[0]), u, far);
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let outside = |t: f64| {
                let balls = keys.windows(2).flat_map(|pair| {
                    let (a, b) = (pair[0].as_dvec4(), pair[1].as_dvec4());
                    (0..=FINE).map(move |i| a.lerp(b, i as f64 / FINE as f64))
                });
                balls.map(|ball| (o + d * t - ball.truncate()).length() - ball.w).fold(f64::INFINITY, f64::min)
            };
            let mut t = 0.0;
            if outside(t) < 0.1 {
                continue;
            }
            while t < f64::from(far) + 5.0 && outside(t) > 1e-4 {
                t += outside(t);
            }
            match accel.closest(&ray, Rays::CAMERA) {
                Some(hit) => {
                    prop_assert!((f64::from(hit.t) - t).abs() < 0.02 || outside(f64::from(hit.t)).abs() < 1e-3, "{t} {hit:?}");
                    let point = SurfacePoint::new(&scene, &hit, ray.direction);
                    // Where the strand gets thinner, its cone is a little more than its radius from the axis; at its outline that
                    // is a long way along the ray.
                    let off = (point.position - ray.origin - ray.direction * hit.t).length();
                    prop_assert!(off < 0.015 || Across::of(hit.v).sine.abs() > 0.9, "{off} {hit:?}");
                }
                None => {
                    let deepest = (0..400).map(|i| outside(t + 0.005 * f64::from(i))).fold(f64::INFINITY, f64::min);
                    prop_assert!(deepest > -1e-3, "missed at {t}, {deepest} deep");
                }
            }
        }
    }

    /// Rays to the middle of a strand, at its keys and between pieces, hit it, wherever it stands and however thin it is.
    #[test]
    fn nothing_passes_between_pieces(
        seed in 0u32..60000, number in 1usize..3, radius in -4f32..-0.7, far in prop::sample::select(vec![0.0, 1.0, 100.0]),
        shape in prop::sample::select(vec![RIBBON, CurveShape::Thick, CurveShape::ThickLinear]),
    ) {
        let keys = bent(seed, 6, 10f32.powf(radius));
        let at = |k: usize| DMat4::from_translation(DVec3::new(far, -far, 3.0 * k as f64));
        let scene = strand(&keys, shape, &(0..number).map(at).collect::<Vec<_>>());
        let accel = Accel::new(&scene);
        let curves = scene.meshes[0].curves.as_ref().unwrap();
        let m = &scene.instances[0].to_render;
        for i in 0..10 {
            let u = sobol_burley::sample_4d(i, 1, seed);
            // Where pieces meet, and anywhere; the chords of a ribbon keep away from its curve.
            let anywhere = if shape == RIBBON { 0.6 } else { u[2] };
            for along in [0.0, 0.2, if shape == RIBBON { 0.4 } else { 0.125 }, anywhere] {
                let segment = 1 + (u[3] * 3.0) as u32;
                let middle = m.transform_point3a(Vec3A::from_vec4(curves.controls(0, segment, Pose::default()).at(along)));
                let ray = ray_at(middle, u, 2.0);
                // Rounding moves it by less than a thin strand is wide.
                let moved = 1e-6 * (middle.length() + 2.0);
                if ray.direction.x.abs() < 0.8 && moved < 0.2 * 10f32.powf(radius) {
                    prop_assert!(accel.closest(&ray, Rays::CAMERA).is_some(), "{segment} {along} {ray:?}");
                    prop_assert_eq!(accel.transmittance(&ray, |_| 1.0), 0.0);
                }
            }
        }
    }

    /// At any moment a strand that changes its shape is hit where a strand of that moment's shape is, and looks the same there.
    #[test]
    fn strands_have_the_shape_of_the_moment(
        seed in 0u32..60000, radius in -2f32..-0.7, moment in any::<u16>(),
        shape in prop::sample::select(vec![RIBBON, CurveShape::Thick, CurveShape::ThickLinear]),
    ) {
        let poses: Vec<Vec<Vec4>> = (0..3).map(|key| {
            let away = Vec4::new(0.0, 0.7 * key as f32, 0.0, 0.0);
            bent(seed + key, 6, 10f32.powf(radius)).into_iter().map(|ball| ball + away).collect()
        }).collect();
        let place = DMat4::from_rotation_z(0.4) * DMat4::from_scale(DVec3::splat(1.3));
        let mut scene = changing(&poses[1], &poses, shape, &[place]);
        scene.set_in_motion();
        let accel = Accel::new(&scene);
        let now = &scene.instances[scene.moving[0].at(moment) as usize];
        let Pose { key, part } = now.pose;
        prop_assert!((key, part) != (0, 0.0) && scene.moving[0].count() >= 16);
        let keys: Vec<Vec4> = std::iter::zip(&poses[key as usize], &poses[key as usize + 1])
            .map(|(from, to)| from.lerp(*to, part)).collect();
        let still = strand(&keys, shape, &[place]);
        let truth = Accel::new(&still);
        let curves = still.meshes[0].curves.as_ref().unwrap();
        // Rounding: a fortieth of the strand's way from moment to moment. Chords of round pieces, of which there may be more than the moment's
        // shape needs, lie within a fiftieth of the radius of the curve, in both scenes, and are hit at a slant.
        let room = if shape == CurveShape::Thick { (0.2 * 10f32.powf(radius)).max(1e-3) } else { 1e-3 };
        let mut met = 0;
        for i in 0..30 {
            let u = sobol_burley::sample_4d(i, 1, seed);
            let along = curves.controls(0, 1 + (u[3] * 3.0) as u32, Pose::default()).at(u[2]);
            let middle = now.to_render.transform_point3a(Vec3A::from_vec4(along));
            let ray = ray_at(middle, u, 2.0).at(moment);
            let [found, want] = [&accel, &truth].map(|one| one.closest(&ray, Rays::CAMERA));
            let (Some(found), Some(want)) = (found, want) else {
                // Past its edge by rounding.
                continue;
            };
            // Near its edge, and by rays along the strand, all errors are larger.
            let is_plain = found.v.abs() < 0.9 && want.v.abs() < 0.9 && ray.direction.x.abs() < 0.7;
            if !is_plain {
                continue;
            }
            met += 1;
            prop_assert!((found.t - want.t).abs() < room, "{found:?} {want:?}");
            let [own, other] = [(&scene, found), (&still, want)]
                .map(|(scene, hit)| SurfacePoint::new(scene, &hit, ray.direction));
            prop_assert!(own.position.distance(other.position) < room, "{own:?} {other:?}");
            prop_assert!(own.triangle != other.triangle || own.shading_normal.distance(other.shading_normal) < 0.05, "{own:?} {other:?}");
        }
        prop_assert!(met >= 5, "{met}");
    }

    /// Any keys give answers that are numbers.
    #[test]
    fn anything_goes(
        values in prop::collection::vec(prop::array::uniform4(prop::num::f32::ANY), 2..7), seed in 0u32..60000,
        shape in prop::sample::select(vec![RIBBON, CurveShape::Thick, CurveShape::ThickLinear]),
    ) {
        let keys: Vec<Vec4> = values.into_iter().map(Vec4::from_array).collect();
        let scene = strand(&keys, shape, &[DMat4::IDENTITY]);
        let accel = Accel::new(&scene);
        for i in 0..10 {
            let u = sobol_burley::sample_4d(i, 1, seed);
            let target = if keys[0].is_finite() { Vec3A::from_vec4(keys[0]) } else { Vec3A::ZERO };
            let ray = ray_at(target, u, 1.0);
            if ray.origin.is_finite() && let Some(hit) = accel.closest(&ray, Rays::CAMERA) {
                prop_assert!(hit.t > 0.0 && hit.u.is_finite() && hit.v >= -1.0 && hit.v <= 1.0 + FROM_WITHIN + LEANS_AWAY, "{hit:?}");
                let point = SurfacePoint::new(&scene, &hit, ray.direction);
                prop_assert!(point.shading_normal.is_finite() && point.position.is_finite(), "{point:?}");
            }
        }
    }
}

/// A cylinder is a strand of even radius through keys of a line.
#[test]
fn a_straight_strand_is_a_cylinder() {
    let keys: Vec<Vec4> = (0..4).map(|i| Vec4::new(i as f32, 0.0, 0.0, 0.25)).collect();
    for shape in [CurveShape::Thick, CurveShape::ThickLinear] {
        let scene = strand(&keys, shape, &[DMat4::IDENTITY]);
        let accel = Accel::new(&scene);
        for i in 0..1000 {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let ray = ray_at(Vec3A::new(1.0 + u[2], 0.6 * u[3] - 0.3, 0.0), u, 4.0);
            let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let (a, b, c) = (d.y * d.y + d.z * d.z, o.y * d.y + o.z * d.z, o.y * o.y + o.z * o.z - 0.0625);
            let met = (-b - (b * b - a * c).sqrt()) / a;
            let x = o.x + d.x * met;
            // Towards its ends a curve's keys are not run through evenly.
            if a < 0.2 || !(1.0..2.0).contains(&x) {
                continue;
            }
            let hit = accel.closest(&ray, Rays::CAMERA).unwrap_or_else(|| panic!("missed {met}"));
            assert!((f64::from(hit.t) - met).abs() < 1e-5, "{} {met}", hit.t);
            assert!(
                (hit.triangle as f64 + f64::from(hit.u) - x).abs()
                    < if shape == CurveShape::Thick { 0.05 } else { 1e-4 }
            );
            let normal = SurfacePoint::new(&scene, &hit, ray.direction).shading_normal.as_dvec3();
            let place = o + d * met;
            assert!(normal.dot(DVec3::new(0.0, place.y, place.z) / 0.25) > 0.9999);
            // In and out again, but at its open ends and where round pieces overlap.
            let far = o.x + d.x * (-b + (b * b - a * c).sqrt()) / a;
            let is_clear = (0.3..2.7).contains(&far) && [far, x].iter().all(|x| (x - x.round()).abs() > 0.03);
            assert!(!is_clear || (accel.transmittance(&ray, |_| 0.5) - 0.25).abs() < 1e-6, "{x} {far}");
            let axis = Vec3A::new(x as f32, 0.0, 0.0);
            let away = ray.direction.with_x(0.0).normalize();
            let out = accel.closest(&Ray::new(axis, away), Rays::CAMERA).unwrap();
            assert!((out.t - 0.25).abs() < 1e-5, "{out:?}");
            let within = SurfacePoint::new(&scene, &out, away);
            assert!(within.backfacing && within.shading_normal.dot(away) < -0.9999);
            assert!((within.position - axis - away * 0.25).length() < 1e-5);
        }
    }
}

/// Instances of one strand are as strands of their own would be, larger ones too.
#[test]
fn instances_of_hair_are_hair() {
    let keys = bent(5, 5, 0.1);
    let place = DMat4::from_scale_rotation_translation(
        DVec3::splat(2.0),
        glam::DQuat::from_rotation_y(0.4),
        DVec3::new(1.0, 2.0, -6.0),
    );
    let away = DMat4::from_translation(DVec3::new(0.0, 500.0, 0.0));
    for shape in [RIBBON, CurveShape::Thick, CurveShape::ThickLinear] {
        let (alone, shared) = (strand(&keys, shape, &[place]), strand(&keys, shape, &[place, away]));
        let [one, two] = [&alone, &shared].map(Accel::new);
        let mut met = 0;
        for i in 0..4000 {
            let u = sobol_burley::sample_4d(i, 0, 9);
            let target = alone.instances[0].to_render.transform_point3a(Vec3A::new(4.0 * u[2], 0.6 * u[3], 0.3));
            let ray = ray_at(target, u, 4.0);
            let [a, b] = [&one, &two].map(|accel| accel.closest(&ray, Rays::CAMERA));
            if let (Some(a), Some(b)) = (a, b) {
                met += 1;
                assert!((a.t - b.t).abs() < 2e-3, "{a:?} {b:?}");
            }
        }
        assert!(met > 500, "{met}");
    }
}

/// A ray that leaves a strand does not hit that strand, but hits others.
#[test]
fn a_strand_that_is_left_is_not_met() {
    let keys = bent(5, 5, 0.1);
    let scene = strand(&keys, RIBBON, &[DMat4::IDENTITY]);
    let accel = Accel::new(&scene);
    let middle = Vec3A::from_vec4(keys[2]);
    let ray = Ray::new(middle - Vec3A::Z, Vec3A::Z);
    let hit = accel.closest(&ray, Rays::CAMERA).unwrap();
    let point = SurfacePoint::new(&scene, &hit, ray.direction);
    assert!(accel.closest(&point.leaving(ray.origin, ray.direction), Rays::CAMERA).is_none());
    assert_eq!(accel.transmittance(&point.leaving(ray.origin, ray.direction), |_| 1.0), 1.0);
    let other = SurfacePoint { strand: 1, ..point };
    assert!(accel.closest(&other.leaving(ray.origin, ray.direction), Rays::CAMERA).is_some());
}
