//! Nanoseconds that typical graphs take at a point: `cargo run --release -p petzval-nodes --example speed`.

use glam::{Vec2, Vec3A, Vec4};
use petzval_nodes::{
    Context, Direction, Field, Graph, ImageReading, LANES, LaneRegisters, Pixels, Program, Registers, Shift, Space,
    Textures, compile,
};
use std::hint::black_box;
use std::time::Instant;

/// A surface about as cheap to ask as a renderer's.
struct Surface {
    position: Vec3A,
}

impl Context for Surface {
    fn knows(_: Field) -> bool {
        true
    }
    fn answer(&self, field: Field, shift: Shift) -> Option<Vec3A> {
        Some(match field {
            Field::Position | Field::Generated | Field::Object => {
                self.position + Vec3A::X * (0.01 * shift.x) + Vec3A::Y * (0.01 * shift.y)
            }
            Field::FootprintX => Vec3A::X * 0.01,
            Field::FootprintY => Vec3A::Y * 0.01,
            Field::Backfacing => Vec3A::ZERO,
            _ => Vec3A::Z,
        })
    }
    fn attribute(&self, _: usize, _: Shift) -> Vec4 {
        self.position.extend(1.0)
    }
    fn transform(&self, _: Direction, _: Space, _: Space, vector: Vec3A) -> Vec3A {
        vector
    }
}

/// No image at all, to see the time of the program itself.
struct White;

impl Textures for White {
    fn lookup(&self, _: usize, uv: Vec2, _: ImageReading) -> Vec4 {
        Vec4::new(uv.x, uv.y, 1.0, 1.0)
    }
}

const NOISE: &str =
    r#"{"type": "ShaderNodeTexNoise", "inputs": {"Scale": 5.0, "Detail": 2.0, "Roughness": 0.5, "Lacunarity": 2.0}}"#;
const MAPPING: &str = r#"{"type": "ShaderNodeMapping", "inputs": {"Vector": {"node": 0, "socket": "UV"},
    "Location": [0.1, 0.2, 0.0], "Rotation": [0.0, 0.0, 0.3], "Scale": [2.0, 2.0, 2.0]}}"#;

#[expect(clippy::too_many_lines, reason = "a program for each kind of node")]
fn main() {
    let table: Vec<String> = (0..257).map(|i| format!("[{0}, {0}, {0}, 1]", i as f32 / 256.0)).collect();
    let ramp = format!(
        r#"{{"type": "ShaderNodeValToRGB", "options": {{"table": [{}]}}, "inputs": {{"Fac": {{"node": 0, "socket": "Fac"}}}}}}"#,
        table.join(",")
    );
    let principled =
        |inputs: &str| format!(r#"{{"type": "ShaderNodeBsdfPrincipled", "inputs": {{{inputs}, "Roughness": 0.5}}}}"#);
    let graphs = [
        ("constants alone", vec![principled(r#""Base Color": [0.8, 0.8, 0.8]"#)]),
        (
            "image x mapping",
            vec![
                r#"{"type": "ShaderNodeTexCoord"}"#.to_owned(),
                MAPPING.to_owned(),
                r#"{"type": "ShaderNodeTexImage", "options": {"image": 0}, "inputs": {"Vector": {"node": 1, "socket": "Vector"}}}"#
                    .to_owned(),
                principled(r#""Base Color": {"node": 2, "socket": "Color"}"#),
            ],
        ),
        (
            "noise, ramp",
            vec![NOISE.to_owned(), ramp.clone(), principled(r#""Base Color": {"node": 1, "socket": "Color"}"#)],
        ),
        (
            "noise, ramp, bump",
            vec![
                NOISE.to_owned(),
                ramp,
                r#"{"type": "ShaderNodeBump", "inputs": {"Height": {"node": 0, "socket": "Fac"}, "Strength": 1.0, "Distance": 0.1}}"#
                    .to_owned(),
                principled(r#""Base Color": {"node": 1, "socket": "Color"}, "Normal": {"node": 2, "socket": "Normal"}"#),
            ],
        ),
        (
            "voronoi",
            vec![
                r#"{"type": "ShaderNodeTexVoronoi", "inputs": {"Scale": 5.0, "Randomness": 1.0}}"#.to_owned(),
                principled(r#""Base Color": {"node": 0, "socket": "Color"}"#),
            ],
        ),
        (
            "voronoi, smooth",
            vec![
                r#"{"type": "ShaderNodeTexVoronoi", "options": {"feature": "SMOOTH_F1"},
                    "inputs": {"Scale": 5.0, "Randomness": 1.0, "Smoothness": 1.0}}"#
                    .to_owned(),
                principled(r#""Base Color": {"node": 0, "socket": "Color"}"#),
            ],
        ),
        (
            "voronoi, edges",
            vec![
                r#"{"type": "ShaderNodeTexVoronoi", "options": {"feature": "DISTANCE_TO_EDGE"},
                    "inputs": {"Scale": 5.0, "Randomness": 1.0}}"#
                    .to_owned(),
                principled(r#""IOR": {"node": 0, "socket": "Distance"}"#),
            ],
        ),
    ];
    for (name, nodes) in graphs {
        let text = format!(
            r#"{{"nodes": [{}], "surface": {{"node": {}, "socket": "BSDF"}}}}"#,
            nodes.join(","),
            nodes.len() - 1
        );
        let graph = Graph::from_json(&text).expect("the graphs above are well formed");
        let start = Instant::now();
        let (program, reports) = compile(&graph);
        let compiling_us = start.elapsed().as_secs_f64() * 1e6;
        assert!(reports.is_empty(), "{reports:?}");
        let pixels = Pixels::new(64, vec![Vec4::ONE; 64 * 64]).expect("a whole number of rows");
        println!(
            "{name:18} {:3} instructions, {:7.1} ns, in lanes {:7.1} ns, with an image {:7.1} ns; compiled in {compiling_us:.0} us",
            program.instructions(),
            nanoseconds(&program, &White),
            in_lanes(&program, &White),
            nanoseconds(&program, &vec![pixels]),
        );
    }
}

const RUNS: u32 = 100_000;

fn surface(i: u32) -> Surface {
    Surface { position: Vec3A::new(i as f32 * 0.013, i as f32 * 0.007, 0.5) }
}

fn nanoseconds(program: &Program, textures: &impl Textures) -> f64 {
    let mut registers = Registers::default();
    median_ns(|| {
        for i in 0..RUNS {
            program.run(&surface(i), textures, &mut registers);
            for (_, operand) in &program.surface[0].inputs {
                black_box(program.value(*operand, &registers));
            }
        }
    })
}

/// Eight points at once.
fn in_lanes(program: &Program, textures: &impl Textures) -> f64 {
    let mut registers = LaneRegisters::default();
    let slice = program.slice(program.surface[0].inputs.iter().map(|(_, operand)| *operand));
    median_ns(|| {
        for i in (0..RUNS).step_by(LANES) {
            let points: [Surface; LANES] = std::array::from_fn(|lane| surface(i + lane as u32));
            program.run_lanes(&slice, &points[..], textures, &mut registers);
            for (lane, (_, operand)) in
                (0..LANES).flat_map(|lane| program.surface[0].inputs.iter().map(move |input| (lane, input)))
            {
                black_box(program.value_at(*operand, &registers, lane));
            }
        }
    })
}

/// The median of some rounds, a point.
fn median_ns(mut round: impl FnMut()) -> f64 {
    let mut rounds: Vec<f64> = (0..9)
        .map(|_| {
            let start = Instant::now();
            round();
            start.elapsed().as_secs_f64() * 1e9 / f64::from(RUNS)
        })
        .collect();
    rounds.sort_by(f64::total_cmp);
    rounds[rounds.len() / 2]
}
