//! Trees against testing every triangle, one at a time and without boxes, in scenes of all kinds and sizes.

use super::*;
use glam::{DQuat, Vec3};

/// The tree's intersection test on one triangle by itself: distances agree to the last bits.
fn meets(ray: &Ray, corners: [Vec3; 3], t_max: f32) -> Option<f32> {
    let d = ray.direction.to_array();
    let a = ray.direction.abs();
    let kz = [a.x > a.y && a.x > a.z, a.y > a.z, true].iter().position(|&largest| largest).unwrap();
    let (kx, ky) = if d[kz] < 0.0 { ((kz + 2) % 3, (kz + 1) % 3) } else { ((kz + 1) % 3, (kz + 2) % 3) };
    let seen = corners.map(|p| {
        let p = (Vec3A::from(p) - ray.origin).to_array();
        [p[kx] - p[kz] * (d[kx] / d[kz]), p[ky] - p[kz] * (d[ky] / d[kz]), p[kz]]
    });
    let edge = |p: [f32; 3], q: [f32; 3]| p[0] * q[1] - p[1] * q[0];
    let exact = |p: [f32; 3], q: [f32; 3]| (p[0] as f64 * q[1] as f64 - p[1] as f64 * q[0] as f64) as f32;
    let pairs = [(seen[2], seen[1]), (seen[0], seen[2]), (seen[1], seen[0])];
    let mut weights = pairs.map(|(p, q)| edge(p, q));
    if weights.contains(&0.0) {
        weights = pairs.map(|(p, q)| exact(p, q));
    }
    let [u, v, w] = weights;
    if weights.iter().any(|&x| x < 0.0) && weights.iter().any(|&x| x > 0.0) {
        return None;
    }
    let t = (u * seen[0][2] + v * seen[1][2] + w * seen[2][2]) * (1.0 / d[kz]) / (u + v + w);
    (t > 0.0 && t < t_max).then_some(t)
}

/// Every distance at which the ray hits something that shows.
fn all_hits(scene: &Scene, ray: &Ray, kind: Rays) -> Vec<f32> {
    let mut found = vec![];
    for instance in &scene.instances {
        let shows = instance.visible.any_of(kind);
        let mesh = &scene.meshes[instance.mesh as usize];
        let corners = (0..mesh.triangles.len() as u32).map(|i| mesh.corners(i));
        let alone = scene.instances.iter().filter(|other| other.mesh == instance.mesh).count() == 1;
        if !shows {
        } else if alone {
            let moved = |p: Vec3| instance.to_render.transform_point3(p);
            found.extend(corners.filter_map(|c| meets(ray, c.map(moved), ray.t_max)));
        } else {
            let origin = instance.to_object.transform_point3a(ray.origin);
            let direction = instance.to_object.transform_vector3a(ray.direction);
            let scale = direction.length();
            let local = Ray::new(origin, direction / scale);
            found.extend(corners.filter_map(|c| meets(&local, c, ray.t_max * scale)).map(|t| t / scale));
        }
    }
    found
}

fn levels() -> Vec<Level> {
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    let others =
        [best.as_avx2().map(Level::Avx2), best.as_sse4_2().map(Level::Sse4_2), best.as_sse2().map(Level::Sse2)];
    #[cfg(not(target_arch = "x86_64"))]
    let others: [Option<Level>; 0] = [];
    others.into_iter().flatten().chain([best]).collect()
}

/// Numbers in [0, 1).
pub(super) struct Dice(pub(super) u32);

impl Dice {
    pub(super) fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(1);
        f64::from(sobol_burley::sample(self.0 & 0xffff, 0, self.0 >> 16))
    }

    pub(super) fn pick(&mut self, n: usize) -> usize {
        (self.roll() * n as f64) as usize
    }

    pub(super) fn vector(&mut self) -> DVec3 {
        2.0 * DVec3::new(self.roll(), self.roll(), self.roll()) - DVec3::ONE
    }
}

fn mesh(dice: &mut Dice) -> MeshDescription {
    let n = 1 + dice.pick(60);
    let mut positions = vec![];
    match dice.pick(4) {
        0 => return sphere(6, 8),
        // Anywhere.
        1 => (0..n).for_each(|_| (0..3).for_each(|_| positions.push(dice.vector()))),
        // Small or long ones.
        2 => (0..n).for_each(|_| {
            let (p, along) = (dice.vector(), dice.vector() * 0.3);
            positions.extend([p, p + along, p + along * dice.roll() + dice.vector() * 1e-4]);
        }),
        // In planes across the axes, with corners on a grid, so that boxes are flat and touch.
        _ => (0..n).for_each(|_| {
            let (axis, corner) = (dice.pick(3), (dice.vector() * 4.0).round() / 4.0);
            let mut step = |i: usize| {
                let mut p = corner;
                p[(axis + i) % 3] += 0.25 * (1.0 + dice.pick(2) as f64);
                p
            };
            positions.extend([corner, step(1), step(2)]);
        }),
    }
    let positions: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    MeshDescription { positions, triangles, ..Default::default() }
}

fn any_scene(dice: &mut Dice, size: f64) -> Scene {
    let mut builder = SceneBuilder::new();
    for _ in 0..=dice.pick(3) {
        let mesh = builder.add_mesh(mesh(dice)).unwrap();
        for _ in 0..=dice.pick(3) {
            let sign = DVec3::new(1.0, 1.0, if dice.pick(2) == 0 { 1.0 } else { -1.0 });
            let stretch = if dice.pick(2) == 0 { DVec3::ONE } else { DVec3::splat(1.2) + dice.vector() };
            let turn = if dice.pick(2) == 0 { DQuat::IDENTITY } else { DQuat::from_axis_angle(DVec3::Y, dice.roll()) };
            let shear = DMat4::from_cols(
                glam::DVec4::X,
                glam::DVec4::new([0.0, 0.4][dice.pick(2)], 1.0, 0.0, 0.0),
                glam::DVec4::Z,
                glam::DVec4::W,
            );
            let to = dice.vector() * [0.0, 1.0, 100.0][dice.pick(3)] * size;
            let own = size * [1.0, 1.0, 1e-3][dice.pick(3)];
            let m = DMat4::from_scale_rotation_translation(sign * stretch * own, turn, to) * shear;
            let (camera, shadow) = (dice.pick(6) != 0, dice.pick(6) != 0);
            builder.add_instance("any", mesh, m, &[], camera, shadow).unwrap();
        }
    }
    builder.build(DVec3::ZERO)
}

/// A random ray from anywhere, a corner included, to anywhere, along the axes or to a corner or an edge.
fn any_ray(dice: &mut Dice, scene: &Scene, size: f64) -> Ray {
    let i = &scene.instances[dice.pick(scene.instances.len())];
    let mesh = &scene.meshes[i.mesh as usize];
    let corners = mesh.corners(dice.pick(mesh.triangles.len()) as u32);
    let [a, b, _] = corners.map(|p| i.to_render.transform_point3a(Vec3A::from(p)));
    let target = [a, (a + b) * 0.5, a + (dice.vector() * size * 0.1).as_vec3a()][dice.pick(3)];
    let mut axis = [0.0, -0.0][dice.pick(2)] * Vec3A::ONE;
    axis[dice.pick(3)] = [1.0, -1.0][dice.pick(2)];
    let away = (dice.vector() * size * [1.0, 1e-3, 1e3][dice.pick(3)]).as_vec3a();
    let (origin, direction) = match dice.pick(4) {
        0 => (target - axis * size as f32 * [2.0, 1e-3][dice.pick(2)], axis),
        1 => (away, axis),
        2 => (away, away),
        _ => (target + away, -away),
    };
    let t_max = if dice.pick(3) == 0 { (size * dice.roll() * 3.0) as f32 } else { f32::INFINITY };
    Ray { t_max, ..Ray::new(origin, direction.normalize_or(axis)) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn trees_find_what_testing_all_finds(seed in 0u32..1 << 30, scale in -6f64..6.0) {
        let (mut dice, size) = (Dice(seed), 10f64.powf(scale));
        let scene = any_scene(&mut dice, size);
        let mut accel = Accel::new(&scene);
        let all: Vec<(Ray, Rays, Vec<f32>)> = (0..100)
            .map(|i| {
                let kind = [Rays::CAMERA, Rays::BOUNCE, Rays::SHADOW][i % 3];
                let ray = any_ray(&mut dice, &scene, size);
                (ray, kind, all_hits(&scene, &ray, kind))
            })
            .collect();
        for level in levels() {
            accel.level = level;
            for (ray, kind, expected) in &all {
                let nearest = expected.iter().copied().reduce(f32::min);
                let found = accel.closest(ray, *kind).map(|hit| hit.t);
                // A triangle seen edge-on may be told apart from one a rounding behind it either way.
                let same = match (found, nearest) {
                    (Some(a), Some(b)) => (a - b).abs() <= 1e-6 * b,
                    (a, b) => a == b,
                };
                prop_assert!(same, "{level:?} {ray:?}: {found:?}, but {nearest:?}");
                let mut met = vec![];
                accel.transmittance_of(ray, *kind, |hit| { met.push(hit.t); 0.0 });
                prop_assert_eq!(met.len(), expected.len(), "{:?} {:?}: {:?}, but {:?}", level, ray, met, expected);
                prop_assert_eq!(accel.transmittance_of(ray, *kind, |_| 1.0) == 0.0, !expected.is_empty());
            }
        }
    }
}
