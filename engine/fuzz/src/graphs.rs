//! Shader graphs as the add-on sends them, and IES files, which come in one.

#[rustfmt::skip]
mod words;

use glam::{Vec3A, Vec4};
use petzval_nodes::{Column, Graph, Operand, Pixels, Points, Program, Registers, compile};
use petzval_render::nodes::{OF_MATERIALS, OF_WORLDS};
use petzval_render::scene::graph::Graph as Closures;
use serde_json::{Map, Value, json};

use self::words::{INPUTS, KINDS, NUMBERS, OPTIONS, OUTPUTS};
use super::bytes::Bytes;
use super::one_line;

/// A graph is read or refused in one line; its program runs; a material and a world can be made of it.
pub fn graph(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let graph = match Graph::from_json(text) {
        Ok(graph) => graph,
        Err(error) => return one_line(&error),
    };
    let (program, _) = compile(&graph);
    run(&program);
    for answered in [OF_MATERIALS, OF_WORLDS] {
        let (closures, reports) = Closures::of(&graph, 3, answered);
        let _ = (closures.emits(), closures.may_be_transparent(), closures.needs_footprint(), closures.brightness());
        drop(reports);
    }
}

/// The values of all that a program computes, at a few points.
fn run(program: &Program) -> Vec<Vec3A> {
    let mut table = Points::default();
    let three = |values: [[f32; 3]; 3]| values.map(|[x, y, z]| Vec4::new(x, y, z, 1.0)).to_vec();
    let places = three([[0.3, -1.7, 2.5], [0.0, 0.0, 0.0], [1e6, -1e-3, 40.0]]);
    let along = |by: f32| three([[by, 0.0, 0.0], [0.0, by, 0.0], [0.0, 0.0, by]]);
    for name in ["position", "generated", "object", "uv:UVMap", "parametric", "window"] {
        table.add(name, Column { values: places.clone(), along_x: along(0.01), along_y: along(0.02) });
    }
    let up = three([[0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [0.0, 0.0, -1.0]]);
    for name in ["normal", "true_normal", "incoming", "mesh_normal"] {
        table.add(name, Column { values: up.clone(), ..Column::default() });
    }
    let pixel = |i: u8| Vec4::new(f32::from(i) / 6.0, 0.5, 1.0 - f32::from(i) / 6.0, 1.0);
    let images: Vec<Pixels> = Pixels::new(3, (0..6).map(pixel).collect()).into_iter().collect();
    let mut registers = Registers::default();
    let layers = program.surface.iter().chain(&program.volume);
    let operands: Vec<Operand> = layers
        .flat_map(|layer| layer.inputs.iter().map(|(_, operand)| *operand).chain([layer.weight]))
        .chain(program.displacement)
        .collect();
    let mut values = Vec::new();
    for number in 0..3 {
        program.run(&table.point(number, &program.attributes), &images, &mut registers);
        values.extend(operands.iter().map(|operand| program.value(*operand, &registers)));
    }
    values
}

/// An IES file is read, or named as black; the light that it gives in any direction is no less than none, and a number.
pub fn ies(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let link = |node: usize, socket: &str| json!({"node": node, "socket": socket});
    let nodes = json!([
        {"type": "ShaderNodeTexCoord", "name": "at", "options": {}, "inputs": {}},
        {"type": "ShaderNodeTexIES", "name": "lamp", "options": {"ies_text": text},
            "inputs": {"Vector": link(0, "Generated"), "Strength": 1.0}},
        {"type": "ShaderNodeEmission", "name": "glow", "options": {},
            "inputs": {"Color": [1.0, 1.0, 1.0], "Strength": link(1, "Fac")}},
    ]);
    let whole = json!({"nodes": nodes, "surface": link(2, "Emission")}).to_string();
    let graph = Graph::from_json(&whole).unwrap_or_else(|error| panic!("{error}"));
    let (program, reports) = compile(&graph);
    for report in &reports {
        one_line(report);
    }
    for value in run(&program) {
        assert!(!value.is_nan() && value.x >= 0.0, "{value}");
    }
}

/// A number that says all of a node that its bytes do not: the same for the same words.
fn mixed(seed: u32, what: usize) -> u32 {
    let mut x = seed ^ (what as u32).wrapping_mul(0x9e37_79b9);
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

/// A number such as people type, or one at an edge.
fn typed(seed: u32) -> f64 {
    const EDGES: [f64; 10] = [0.0, 1.0, -1.0, 0.5, 1e-30, 1e30, -1e10, 1e300, 3.0, 0.001];
    match seed % 4 {
        0 => EDGES[seed as usize / 4 % EDGES.len()],
        _ => f64::from(seed as i16) / 8192.0,
    }
}

/// The description of a graph whose nodes have all sockets and options that any node has: each reads those that it knows.
pub fn description(bytes: &[u8]) -> String {
    let mut bytes = Bytes::new(bytes);
    let count = 1 + bytes.below(12);
    let nodes: Vec<Value> = (0..count)
        .map(|i| {
            let kind = KINDS[bytes.below(KINDS.len())];
            let (seed, links) = (bytes.word(), bytes.byte());
            let chosen = |list: &[&'static str], what: usize| list[mixed(seed, what) as usize % list.len()];
            let input = |what: usize| {
                let by = mixed(seed, 1000 + what);
                if (by >> 8) as u8 <= links {
                    // Mostly of a node before, so that most graphs have no circles.
                    let node = if i > 0 && !by.is_multiple_of(16) { by as usize / 16 % i } else { by as usize / 16 % count };
                    return json!({"node": node, "socket": chosen(&OUTPUTS, 2000 + what), "unlinked": typed(by)});
                }
                if by.is_multiple_of(2) { json!(typed(by / 2)) } else { json!([typed(by / 2), typed(by / 3), typed(by / 5)]) }
            };
            let has = |what: usize| !mixed(seed, 3000 + what).is_multiple_of(8);
            let inputs: Map<String, Value> = INPUTS
                .iter()
                .enumerate()
                .filter(|(what, _)| has(*what))
                .map(|(what, name)| ((*name).to_owned(), input(what)))
                .collect();
            let mut options = Map::new();
            for (what, (name, words)) in OPTIONS.iter().enumerate().filter(|(what, _)| has(1000 + what)) {
                let word = chosen(words, 4000 + what);
                let value = match word {
                    "true" | "false" => json!(word == "true"),
                    word => json!(word),
                };
                options.insert((*name).to_owned(), value);
            }
            for (what, name) in NUMBERS.iter().enumerate().filter(|(what, _)| has(2000 + what)) {
                let by = mixed(seed, 5000 + what);
                let list: Vec<f64> = (0..by % 20).map(|k| typed(mixed(by, k as usize))).collect();
                let value = if by.is_multiple_of(3) { json!(list) } else { json!(typed(by)) };
                options.insert((*name).to_owned(), value);
            }
            json!({"type": format!("ShaderNode{kind}"), "name": format!("node {i}"), "options": options, "inputs": inputs})
        })
        .collect();
    let last = |what: u8| {
        let link = json!({"node": count - 1, "socket": OUTPUTS[usize::from(what) % OUTPUTS.len()]});
        if what == 0 { Value::Null } else { link }
    };
    json!({"nodes": nodes, "surface": last(1 + bytes.byte() / 2), "volume": last(bytes.byte()), "displacement": last(bytes.byte())})
        .to_string()
}

/// A graph of nodes of all kinds: [`graph`] of its description.
pub fn nodes(bytes: &[u8]) {
    graph(description(bytes).as_bytes());
}
