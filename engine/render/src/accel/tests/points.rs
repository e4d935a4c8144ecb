//! Balls against their definition, in double precision.

use super::*;
use crate::scene::points::PointsDescription;
use crate::surface::SurfacePoint;
use glam::Vec4;

/// A scene of one cloud in these places; of points that go somewhere while the shutter is open, if `goes` says so.
fn cloud(points: &[Vec4], places: &[DMat4], goes: Option<Vec3>) -> Scene {
    let mut builder = SceneBuilder::new();
    let at =
        |part: f32| points.iter().map(|p| *p + (goes.unwrap_or(Vec3::ZERO) * part).extend(0.2 * p.w * part)).collect();
    let poses = if goes.is_some() { vec![at(-1.0), at(0.0), at(1.0)] } else { vec![] };
    let description = PointsDescription { name: "cloud".into(), points: points.to_vec(), poses, ..Default::default() };
    let mesh = builder.add_points(description).unwrap();
    for &place in places {
        builder.add_instance("cloud", mesh, place, &[], true, true).unwrap();
    }
    let mut scene = builder.build(DVec3::ZERO);
    scene.set_in_motion();
    scene
}

/// Random balls in a box, up to a radius.
fn balls(seed: u32, count: u32, radius: f32) -> Vec<Vec4> {
    let ball = |i: u32| {
        let u = sobol_burley::sample_4d(i, 0, seed);
        Vec4::new(2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0, 2.0 * u[2] - 1.0, radius * (0.2 + 0.8 * u[3]))
    };
    (0..count).map(ball).collect()
}

/// The distance at which a ray enters a placed ball, in double precision.
fn entered(ray: &Ray, ball: Vec4, place: &DMat4) -> Option<f64> {
    let to = place.inverse();
    let origin = to.transform_point3(ray.origin.as_dvec3());
    let direction = to.transform_vector3(ray.direction.as_dvec3());
    let from = origin - ball.truncate().as_dvec3();
    let a = direction.length_squared();
    let b = from.dot(direction);
    let c = from.length_squared() - f64::from(ball.w).powi(2);
    let inside = b * b - a * c;
    (inside >= 0.0).then(|| (-b - inside.sqrt()) / a).filter(|t| *t > 0.0)
}

fn places() -> [DMat4; 3] {
    let at = |x: f64| DMat4::from_translation(DVec3::new(x, 0.3, -0.2));
    let turned = at(-2.5) * DMat4::from_rotation_y(0.7) * DMat4::from_scale(DVec3::new(1.4, 0.6, -1.0));
    [at(0.0) * DMat4::from_rotation_x(0.4), turned, at(2.6) * DMat4::from_scale(DVec3::splat(-0.8))]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// One that stands alone, evenly large or stretched, and several: the nearest ball from outside, and all of them.
    #[test]
    fn balls_are_round(seed in 0u32..60000, which in 0usize..4) {
        let points = balls(seed, 60, 0.25);
        let all = places();
        let own = if which == 3 { &all[..] } else { &all[which..=which] };
        let scene = cloud(&points, own, None);
        let accel = Accel::new(&scene);
        for i in 0..30 {
            let u = sobol_burley::sample_4d(i, 1, seed);
            let v = sobol_burley::sample_4d(i, 2, seed);
            let from = Vec3A::new(8.0 * u[0] - 4.0, 2.0 * u[1] - 1.0, 2.0 * u[2] - 1.0);
            let ray = Ray::new(from, direction([v[0], v[1]]));
            let mut want: Vec<(f64, u32, u32)> = own.iter().enumerate().flat_map(|(instance, place)| {
                points.iter().enumerate().filter_map(move |(point, ball)| Some((entered(&ray, *ball, place)?, instance as u32, point as u32)))
            }).collect();
            want.sort_by(|a, b| a.0.total_cmp(&b.0));
            let found = accel.closest(&ray, Rays::CAMERA);
            let Some(hit) = found else {
                // At its rim either may be right.
                prop_assert!(want.len() <= 1, "{want:?}");
                continue;
            };
            prop_assert!(!want.is_empty());
            prop_assert!((f64::from(hit.t) - want[0].0).abs() < 2e-3, "{hit:?} {:?}", want[0]);
            let mut count = 0;
            accel.transmittance(&ray, |_| { count += 1; 0.0 });
            prop_assert!((count as i64 - want.len() as i64).abs() <= 1, "{count} of {}", want.len());
            // The point is where the ray is, its normal leads away from the middle, and it does not hit itself.
            let point = SurfacePoint::new(&scene, &hit, ray.direction);
            let off = (point.position - ray.origin - ray.direction * hit.t).length();
            let ball = points[hit.triangle as usize];
            let middle = scene.instances[hit.instance as usize].to_render.transform_point3(ball.truncate());
            let outward = (point.position - Vec3A::from(middle)).normalize();
            prop_assert!(off < 2e-3, "{off} {hit:?}");
            prop_assert!(outward.dot(point.geometric_normal).abs() > 0.9999);
            prop_assert!(point.geometric_normal.dot(ray.direction) <= 1e-6);
            let on = point.leaving(point.position, ray.direction);
            prop_assert!(accel.closest(&on, Rays::CAMERA).is_none_or(|next| (next.instance, next.triangle) != (hit.instance, hit.triangle)));
        }
    }

    /// Balls far away, and rays that graze them: hits lie on the ball.
    #[test]
    fn far_balls_are_met_where_they_are(seed in 0u32..60000, far in 1f32..4.0) {
        let far = 10f32.powf(far);
        let middle = direction([0.3, 0.6]) * far;
        let ball = middle.extend(0.02 * far);
        let scene = cloud(&[ball], &[DMat4::IDENTITY], None);
        let accel = Accel::new(&scene);
        for i in 0..50 {
            let u = sobol_burley::sample_4d(i, 1, seed);
            let (x, y) = middle.normalize().any_orthonormal_pair();
            // Up to a little beyond the rim.
            let off = (x * u[0].cos() + y * u[0].sin()) * ball.w * (0.95 + 0.06 * u[1]);
            let ray = Ray::new(Vec3A::ZERO, (middle + off).normalize());
            let aside = middle.as_dvec3().reject_from(ray.direction.as_dvec3()).length() / f64::from(ball.w);
            let hit = accel.closest(&ray, Rays::CAMERA);
            if aside < 0.9999 {
                prop_assert!(hit.is_some(), "missed at {aside}");
            } else if aside > 1.0001 {
                prop_assert!(hit.is_none(), "met at {aside}");
            }
            if let Some(hit) = hit {
                let point = SurfacePoint::new(&scene, &hit, ray.direction);
                let away = (point.position - middle).length() / ball.w;
                prop_assert!((away - 1.0).abs() < 1e-4, "{away}");
                prop_assert!(ray.direction.cross(point.position).length() < 3e-5 * far, "{hit:?}");
            }
        }
    }
}

/// A ray from within a ball leaves it unseen, as in Cycles.
#[test]
fn balls_are_met_from_outside_alone() {
    let scene = cloud(&[Vec4::new(0.0, 0.0, 0.0, 1.0)], &[DMat4::IDENTITY], None);
    let accel = Accel::new(&scene);
    assert!(accel.closest(&Ray::new(Vec3A::ZERO, Vec3A::X), Rays::CAMERA).is_none());
    let mut count = 0;
    accel.transmittance(&Ray::new(Vec3A::X * -3.0, Vec3A::X), |_| {
        count += 1;
        0.5
    });
    assert_eq!(count, 1);
}

/// Points that part and grow while the shutter is open are where they are at the ray's moment.
#[test]
fn moving_balls_are_met_at_their_moment() {
    let points = balls(7, 40, 0.2);
    let goes = Vec3::new(0.6, 0.0, 0.3);
    let scene = cloud(&points, &places()[..2], Some(goes));
    assert_eq!(scene.moving.len(), 2);
    let accel = Accel::new(&scene);
    let mut met = 0;
    for moment in [0u16, 9_000, 32_767, 50_000, 65_535] {
        for i in 0..400 {
            let u = sobol_burley::sample_4d(i, 1, 3);
            let target = Vec3A::new(5.0 * u[0] - 3.5, 2.0 * u[1] - 0.7, 0.0);
            let from = Vec3A::new(0.0, 0.5, 6.0);
            let ray = Ray::new(from, (target - from).normalize()).at(moment);
            let Some(hit) = accel.closest(&ray, Rays::CAMERA) else { continue };
            met += 1;
            let instance = &scene.instances[hit.instance as usize];
            // The instance stands for the middle of its sixteenth of the time, or less.
            let part = 2.0 * (f32::from(moment) / 65536.0) - 1.0;
            let own = points[hit.triangle as usize];
            let want = own + (goes * part).extend(0.2 * own.w * part);
            let found = scene.meshes[0].points.as_ref().unwrap().at(hit.triangle, instance.pose);
            assert!((found - want).length() < 0.08, "{found} {want}");
            let point = SurfacePoint::new(&scene, &hit, ray.direction);
            assert!((point.position - ray.origin - ray.direction * hit.t).length() < 2e-3);
            let local = instance.to_object.transform_point3a(point.position);
            assert!((local.distance(Vec3A::from_vec4(found)) / found.w - 1.0).abs() < 1e-3);
        }
    }
    assert!(met > 300, "{met}");
}

/// The two numbers of a hit hold any direction.
#[test]
fn directions_are_folded_and_unfolded() {
    use super::super::points::{folded, unfolded};
    let axes = [Vec3A::X, Vec3A::Y, Vec3A::Z, -Vec3A::X, -Vec3A::Y, -Vec3A::Z];
    let others = (0..1000).map(|i| {
        let u = sobol_burley::sample_4d(i, 0, 5);
        direction([u[0], u[1]])
    });
    for d in axes.into_iter().chain(others) {
        assert!(folded(unfolded(d)).distance(d) < 3e-7, "{d}");
    }
}
