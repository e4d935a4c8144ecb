//! Times rays against a ball of hair: as ribbons, round and straight strands, and as triangles of the same tubes.
//!
//! `cargo run --release -p petzval-render --example hair -- [STRANDS]`

use glam::{DMat4, DVec3, Vec3, Vec3A, Vec4};
use petzval_render::accel::{Accel, Ray};
use petzval_render::scene::curves::{CurveShape, CurvesDescription};
use petzval_render::scene::mesh::MeshDescription;
use petzval_render::scene::motion::Pose;
use petzval_render::scene::visibility::Rays;
use petzval_render::scene::{Scene, SceneBuilder};
use std::time::Instant;

const KEYS: u32 = 8;
const RADIUS: f32 = 0.004;
const RAYS: u32 = 400_000;
/// Sides of a tube, and pieces of a segment, for the triangles.
const SIDES: u32 = 6;
const PIECES: u32 = 4;

/// A sequence has 65536 samples.
fn sample(i: u32, set: u32, seed: u32) -> [f32; 4] {
    sobol_burley::sample_4d(i % 65536, set, seed + i / 65536)
}

/// Place and radius of a key.
fn key(strand: u32, key: u32) -> Vec4 {
    let u = |set: u32| sample(strand, set, 7);
    let [a, b, c, d] = u(0);
    let (z, turn) = (2.0 * a - 1.0, std::f32::consts::TAU * b);
    let flat = (1.0 - z * z).sqrt();
    let out = Vec3::new(flat * turn.cos(), flat * turn.sin(), z);
    let side = Vec3::from(u(1).first_chunk::<3>().copied().unwrap_or_default()) - 0.5;
    let along = key as f32 / (KEYS - 1) as f32;
    let place = out * (1.0 + (0.3 + 0.2 * c) * along) + side * along * along * 0.5 + 0.03 * (9.0 * along + d) * side;
    place.extend(RADIUS * (1.0 - 0.7 * along))
}

fn hair(strands: u32, shape: CurveShape) -> Scene {
    let mut builder = SceneBuilder::new();
    let curves = CurvesDescription {
        name: "hair".into(),
        keys: (0..strands).flat_map(|strand| (0..KEYS).map(move |i| key(strand, i))).collect(),
        first_keys: (0..=strands).map(|strand| strand * KEYS).collect(),
        shape,
        first_number: 0,
        uv_maps: vec![],
        attributes: vec![],
        moved_keys: None,
        poses: vec![],
    };
    let index = builder.add_curves(curves).expect("sound curves");
    builder.add_instance("hair", index, DMat4::IDENTITY, &[], true, true).expect("sound matrix");
    builder.build(DVec3::ZERO)
}

/// The strands of [`hair`] as tubes of triangles.
fn tubes(of: &Scene, strands: u32) -> Scene {
    let curves = of.meshes[0].curves.as_ref().expect("hair");
    let (mut positions, mut triangles) = (vec![], vec![]);
    for strand in 0..strands {
        let first = positions.len() as u32;
        let rings = (KEYS - 1) * PIECES;
        for ring in 0..=rings {
            let segment = (ring / PIECES).min(KEYS - 2);
            let u = (ring - segment * PIECES) as f32 / PIECES as f32;
            let controls = curves.controls(strand, strand * KEYS + segment, Pose::default());
            let (middle, along) = (controls.at(u), controls.slope(u).truncate().normalize());
            let x = along.any_orthonormal_vector();
            let y = along.cross(x);
            for side in 0..SIDES {
                let (sin, cos) = (std::f32::consts::TAU * side as f32 / SIDES as f32).sin_cos();
                positions.push(middle.truncate() + (x * cos + y * sin) * middle.w);
            }
        }
        for ring in 0..rings {
            for side in 0..SIDES {
                let at = |ring: u32, side: u32| first + ring * SIDES + side % SIDES;
                triangles.push([at(ring, side), at(ring, side + 1), at(ring + 1, side + 1)]);
                triangles.push([at(ring, side), at(ring + 1, side + 1), at(ring + 1, side)]);
            }
        }
    }
    let mut builder = SceneBuilder::new();
    let mesh = MeshDescription { name: "tubes".into(), positions, triangles, ..Default::default() };
    let index = builder.add_mesh(mesh).expect("a sound mesh");
    builder.add_instance("tubes", index, DMat4::IDENTITY, &[], true, true).expect("sound matrix");
    builder.build(DVec3::ZERO)
}

/// Resident memory, bytes.
fn memory() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    statm.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).map_or(0, |pages| pages * 4096)
}

fn time(name: &str, scene: &Scene, segments: u32) {
    let before = memory();
    let start = Instant::now();
    let accel = Accel::new(scene);
    let built = start.elapsed().as_secs_f64();
    let bytes = memory().saturating_sub(before) as f64 / f64::from(segments);
    let mut met = 0;
    let start = Instant::now();
    for i in 0..RAYS {
        let u = sample(i, 0, 1);
        let origin = Vec3A::new(4.0, 4.0 * u[0] - 2.0, 4.0 * u[1] - 2.0);
        let aim = Vec3A::new(0.0, 3.0 * u[2] - 1.5, 3.0 * u[3] - 1.5);
        met += u32::from(accel.closest(&Ray::new(origin, (aim - origin).normalize()), Rays::CAMERA).is_some());
    }
    let ns = start.elapsed().as_secs_f64() * 1e9 / f64::from(RAYS);
    let share = f64::from(met) / f64::from(RAYS);
    println!(
        "{name:>10}: {ns:6.0} ns a ray, {:.1} % meet, built in {built:.2} s, {bytes:.0} bytes a segment",
        100.0 * share
    );
}

fn main() {
    let strands: u32 = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(10_000);
    let segments = strands * (KEYS - 1);
    println!("{strands} strands, {segments} segments; tubes of {} triangles a segment", SIDES * PIECES * 2);
    let ribbons = hair(strands, CurveShape::Ribbon { pieces: 5 });
    time("ribbons", &ribbons, segments);
    time("thick", &hair(strands, CurveShape::Thick), segments);
    time("straight", &hair(strands, CurveShape::ThickLinear), segments);
    time("triangles", &tubes(&ribbons, strands), segments);
}
