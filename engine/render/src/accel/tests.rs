//! Trees against brute force, and watertightness.

use super::*;
use crate::scene::{SceneBuilder, mesh::MeshDescription};
use glam::{DMat4, DVec3, Vec3};
use proptest::prelude::*;

fn sphere(rings: u32, segments: u32) -> MeshDescription {
    let mut positions = vec![];
    for i in 0..=rings {
        for j in 0..segments {
            let (st, ct) = (std::f32::consts::PI * i as f32 / rings as f32).sin_cos();
            let (sp, cp) = (std::f32::consts::TAU * j as f32 / segments as f32).sin_cos();
            // Poles as one point, so that neighbours share exact corners.
            let st = if i == 0 || i == rings { 0.0 } else { st };
            positions.push(Vec3::new(st * cp, st * sp, ct));
        }
    }
    let mut triangles = vec![];
    for i in 0..rings {
        for j in 0..segments {
            let at = |i: u32, j: u32| i * segments + j % segments;
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    MeshDescription { name: "sphere".into(), positions, triangles, ..Default::default() }
}

fn scene(matrices: &[DMat4]) -> Scene {
    let mut builder = SceneBuilder::new();
    let mesh = builder.add_mesh(sphere(24, 48)).unwrap();
    for (i, &m) in matrices.iter().enumerate() {
        builder.add_instance(&format!("sphere {i}"), mesh, m, &[], true, true).unwrap();
    }
    builder.build(DVec3::ZERO)
}

fn direction(u: [f32; 2]) -> Vec3A {
    crate::sampler::warp::sample_sphere(u)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// A ray that starts inside of a closed mesh hits it, whichever way it goes, edges and corners included.
    #[test]
    fn closed_meshes_have_no_gaps(u in [0f32..1.0, 0f32..1.0], edge in 0usize..2000, scale in -3f64..4.0) {
        let size = 10f64.powf(scale);
        let scene = scene(&[DMat4::from_scale(DVec3::splat(size))]);
        let accel = Accel::new(&scene);
        prop_assert!(accel.closest(&Ray::new(Vec3A::ZERO, direction(u)), Rays::CAMERA).is_some());
        // Straight at a corner and at the middle of an edge.
        let t = scene.meshes[0].triangles[edge % scene.meshes[0].triangles.len()];
        let [a, b, _] = t.map(|i| Vec3A::from(scene.meshes[0].positions[i as usize]));
        for target in [a, (a + b) * 0.5] {
            let hit = accel.closest(&Ray::new(Vec3A::ZERO, target.normalize()), Rays::CAMERA);
            prop_assert!(hit.is_some(), "no hit towards {target}");
        }
    }
}

/// The tree's answer is that of testing every triangle, in double precision.
#[test]
fn trees_agree_with_brute_force() {
    let matrices = [
        DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0)),
        DMat4::from_scale_rotation_translation(
            DVec3::new(0.3, 2.0, -1.0),
            glam::DQuat::from_rotation_x(0.7),
            DVec3::new(2.0, 1.0, -7.0),
        ),
        DMat4::from_scale_rotation_translation(
            DVec3::splat(1000.0),
            glam::DQuat::from_rotation_y(0.4),
            DVec3::new(-900.0, 0.0, -1500.0),
        ),
    ];
    let scene = scene(&matrices);
    let accel = Accel::new(&scene);
    let mut hits = 0;
    for i in 0..3000u32 {
        let u = sobol_burley::sample_4d(i, 0, 1);
        let d = (direction([u[0], u[1]]) + Vec3A::new(0.0, 0.0, -1.5)).normalize();
        let ray = Ray::new(Vec3A::new(u[2] - 0.5, u[3] - 0.5, 0.0), d);
        let mut best = f64::INFINITY;
        for instance in &scene.instances {
            let m = instance.to_render;
            for t in 0..scene.meshes[0].triangles.len() as u32 {
                let c = scene.meshes[0].corners(t).map(|p| m.transform_point3(p).as_dvec3());
                if let Some(t) = moller_trumbore(ray.origin.as_dvec3(), ray.direction.as_dvec3(), c) {
                    best = best.min(t);
                }
            }
        }
        match accel.closest(&ray, Rays::BOUNCE) {
            Some(hit) => {
                hits += 1;
                // Single precision over transforms of some thousand units.
                assert!((hit.t as f64 - best).abs() < 2e-4 * best.max(1.0), "{} {best}", hit.t);
            }
            None => assert!(best.is_infinite(), "missed at {best}"),
        }
    }
    assert!(hits > 1000, "{hits}");
}

fn moller_trumbore(o: DVec3, d: DVec3, c: [DVec3; 3]) -> Option<f64> {
    let (e1, e2) = (c[1] - c[0], c[2] - c[0]);
    let p = d.cross(e2);
    let det = e1.dot(p);
    let s = o - c[0];
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = d.dot(q) / det;
    let t = e2.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

#[test]
fn light_passes_by_the_share_that_surfaces_leave() {
    let scene = scene(&[DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0))]);
    let accel = Accel::new(&scene);
    let ray = Ray::new(Vec3A::ZERO, Vec3A::new(0.01, 0.02, -1.0).normalize());
    // Front and back of the sphere take a quarter each.
    assert!((accel.transmittance(&ray, |_| 0.25) - 0.5625).abs() < 1e-6);
    assert_eq!(accel.transmittance(&ray, |_| 1.0), 0.0);
    assert_eq!(accel.transmittance(&Ray { t_max: 3.0, ..ray }, |_| 1.0), 1.0);
    assert_eq!(accel.transmittance(&Ray::new(Vec3A::ZERO, Vec3A::Z), |_| 1.0), 1.0);
}

#[test]
fn an_empty_scene_is_empty() {
    let accel = Accel::new(&SceneBuilder::new().build(DVec3::ZERO));
    assert!(accel.closest(&Ray::new(Vec3A::ZERO, Vec3A::Z), Rays::CAMERA).is_none());
    assert!(accel.bounds().is_none());
}

/// Surfaces a hundredth of a millimetre away, in metres, are seen.
#[test]
fn near_surfaces_are_not_skipped() {
    let scene = scene(&[DMat4::IDENTITY]);
    let accel = Accel::new(&scene);
    for gap in [1e-3f32, 1e-4, 1e-5, 2e-6] {
        let ray = Ray::new(Vec3A::new(0.0, 0.0, 1.0 - gap), Vec3A::Z);
        let hit = accel.closest(&ray, Rays::BOUNCE).unwrap_or_else(|| panic!("missed at {gap}"));
        assert!((hit.t - gap).abs() < 3e-7, "{gap}: {}", hit.t);
    }
}

mod against_all;
mod capsules;
mod hair;
mod points;
mod surfaces;
mod two_levels;
