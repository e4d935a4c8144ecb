//! Surfaces neither leak nor shadow themselves, wherever they stand.

use super::*;
use crate::surface::SurfacePoint;
use glam::DQuat;

/// Spheres of that size somewhere: one is in the common tree, several have their own.
fn placed(size: f64, to: DVec3, turn: f64, number: usize) -> Scene {
    let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), turn);
    let at = |k: usize| {
        let to = (to + DVec3::X * 4.0 * k as f64) * size;
        DMat4::from_scale_rotation_translation(DVec3::new(size, 1.3 * size, -size), turn, to)
    };
    scene(&(0..number).map(at).collect::<Vec<_>>())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// A ray from inside to a corner, to an edge, along an axis or anywhere ends at the surface.
    #[test]
    fn placed_meshes_have_no_gaps(
        scale in -6f64..6.0,
        to in prop::array::uniform3(-1f64..1.0), far in prop::sample::select(vec![0.0, 1.0, 100.0, 3000.0]),
        turn in 0f64..3.0, number in 1usize..3, seed in 0u32..60000,
    ) {
        let scene = placed(10f64.powf(scale), DVec3::from(to) * far, turn, number);
        let accel = Accel::new(&scene);
        let m = &scene.instances[0].to_render;
        for i in 0..20 {
            let u = sobol_burley::sample_4d(seed + i, 0, 3);
            let origin = m.transform_point3a(direction([u[0], u[1]]) * 0.7 * u[2]);
            let triangle = (u[3] * scene.meshes[0].triangles.len() as f32) as u32;
            let [a, b, _] = scene.meshes[0].corners(triangle).map(|p| m.transform_point3a(Vec3A::from(p)));
            for d in [a - origin, (a + b) * 0.5 - origin, Vec3A::X, -Vec3A::Y, Vec3A::new(-0.0, -0.0, 1.0)] {
                let ray = Ray::new(origin, d.normalize());
                prop_assert!(accel.closest(&ray, Rays::BOUNCE).is_some(), "{ray:?}");
                prop_assert_eq!(accel.transmittance(&ray, |_| 1.0), 0.0);
            }
        }
    }

    /// A ray from a point of a convex body hits nothing of it outside, and always something inside.
    #[test]
    fn surfaces_do_not_shadow_themselves(
        scale in -6f64..6.0,
        to in prop::array::uniform3(-1f64..1.0), far in prop::sample::select(vec![0.0, 1.0, 100.0]),
        turn in 0f64..3.0, number in 1usize..3, seed in 0u32..60000,
    ) {
        let scene = placed(10f64.powf(scale), DVec3::from(to) * far, turn, number);
        let accel = Accel::new(&scene);
        let m = &scene.instances[0].to_render;
        for i in 0..20 {
            let u = sobol_burley::sample_4d(seed + i, 0, 4);
            let ray = Ray::new(m.transform_point3a(Vec3A::ZERO), direction([u[0], u[1]]));
            let hit = accel.closest(&ray, Rays::BOUNCE).unwrap();
            let p = SurfacePoint::new(&scene, &hit, ray.direction);
            let n = p.geometric_normal;
            let spread = (n + direction([u[2], u[3]])).normalize_or(n);
            let inside = Ray::new(offset_origin(p.position, n, p.position_error), spread);
            prop_assert!(accel.closest(&inside, Rays::BOUNCE).is_some(), "{inside:?}");
            // The body is convex up to rounding; its neighbour stands where this cannot see it.
            let outside = Ray::new(offset_origin(p.position, -n, p.position_error), -spread);
            let own = accel.closest(&outside, Rays::BOUNCE).filter(|hit| hit.instance == 0);
            prop_assert!(own.is_none(), "{outside:?}: {own:?}");
        }
    }
}

fn triangles(corners: &[[Vec3; 3]]) -> Accel {
    let mut builder = SceneBuilder::new();
    let positions = corners.iter().flatten().copied().collect();
    let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = builder.add_mesh(MeshDescription { positions, triangles, ..Default::default() }).unwrap();
    builder.add_instance("triangles", mesh, DMat4::IDENTITY, &[], true, true).unwrap();
    Accel::new(&builder.build(DVec3::ZERO))
}

/// Nothing tells these apart, so that they can only be parted by number.
#[test]
fn equal_triangles_are_all_found() {
    let one = [Vec3::new(-1.0, -1.0, 2.0), Vec3::new(1.0, -1.0, 2.0), Vec3::new(0.0, 1.0, 2.0)];
    let accel = triangles(&[one; 5000]);
    let mut count = 0;
    accel.transmittance(&Ray::new(Vec3A::ZERO, Vec3A::Z), |_| {
        count += 1;
        0.0
    });
    assert_eq!(count, 5000);
}

/// Each half as far and as large as the one before: parted by bins, few leave at a time. (The cube of the smallest is
/// still a number of single precision, which the distance needs.)
#[test]
fn triangles_of_all_sizes_are_all_found() {
    let sizes: Vec<f32> = (0..75).map(|k| 0.5f32.powi(k - 35)).collect();
    let at = |s: f32| [Vec3::new(s, -s, s), Vec3::new(s, s, s), Vec3::new(s, 0.0, -s)];
    let accel = triangles(&sizes.iter().map(|&s| at(s)).collect::<Vec<_>>());
    let mut count = 0;
    accel.transmittance(&Ray::new(Vec3A::ZERO, Vec3A::X), |_| {
        count += 1;
        0.0
    });
    assert_eq!(count, sizes.len());
}
