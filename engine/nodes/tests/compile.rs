//! Compilation of a graph: folding, dropped nodes, conversions, weights, and graphs that are wrong.
//!
//! Values of single nodes are held against Cycles, in tests/parity/test_nodes.py.

use glam::Vec3A;
use petzval_nodes::{Column, Graph, Layer, LayerKind, Pixels, Points, Program, Registers, Report, compile};
use serde_json::{Value, json};

/// A graph of these nodes, the last of which is its surface.
fn program(nodes: &[Value]) -> (Program, Vec<Report>) {
    let socket = match nodes.last().and_then(|node| node["type"].as_str()) {
        Some("ShaderNodeEmission") => "Emission",
        Some("ShaderNodeMixShader" | "ShaderNodeAddShader") => "Shader",
        _ => "BSDF",
    };
    let graph = json!({"nodes": nodes, "surface": {"node": nodes.len() - 1, "socket": socket}});
    compile(&Graph::from_json(&graph.to_string()).expect("a graph"))
}

fn node(kind: &str, options: Value, inputs: Value) -> Value {
    json!({"type": format!("ShaderNode{kind}"), "name": format!("my {kind}"), "options": options, "inputs": inputs})
}

fn link(node: usize, socket: &str) -> Value {
    json!({"node": node, "socket": socket})
}

fn glow(colour: Value) -> Value {
    node("Emission", json!({}), json!({"Color": colour, "Strength": 1.0}))
}

/// Position (2, 3, 5), and nothing else.
fn points() -> Points {
    let mut points = Points::default();
    let values = vec![Vec3A::new(2.0, 3.0, 5.0).extend(1.0)];
    assert!(points.add("position", Column { values, ..Column::default() }));
    points
}

fn run(program: &Program) -> Registers {
    let mut registers = Registers::default();
    program.run(&points().point(0, &program.attributes), &Vec::<Pixels>::new(), &mut registers);
    registers
}

/// The colour that the only layer emits.
fn colour(program: &Program) -> Vec3A {
    let [layer] = &program.surface[..] else { panic!("one layer, not {:?}", program.surface) };
    program.value(layer.input("Color").expect("a colour"), &run(program))
}

fn weights(program: &Program) -> Vec<f32> {
    let registers = run(program);
    program.surface.iter().map(|layer| program.value(layer.weight, &registers).x).collect()
}

#[test]
fn what_stands_still_is_folded() {
    let sum = |a: Value, b: Value| node("Math", json!({"operation": "ADD"}), json!({"Value": a, "Value_001": b}));
    let (program, reports) =
        program(&[sum(json!(1.0), json!(2.0)), sum(link(0, "Value"), json!(4.0)), glow(link(1, "Value"))]);
    assert!(reports.is_empty());
    assert_eq!(program.instructions(), 0);
    assert_eq!(colour(&program), Vec3A::splat(7.0));
    assert_eq!(program.constant(program.surface[0].input("Color").unwrap()), Some(Vec3A::splat(7.0)));
}

/// Instructions are left out that a constant 0 or 1 makes needless: a noise times 0, a share of 0 of it, its sum with 0.
#[test]
fn what_is_switched_off_is_not_computed() {
    let math = |operation: &str, a: Value, b: Value| {
        node("Math", json!({"operation": operation}), json!({"Value": a, "Value_001": b}))
    };
    let noise = node("TexNoise", json!({}), json!({"Vector": link(0, "Position"), "Scale": 3.0}));
    let nodes = |last: Vec<Value>| {
        let mut nodes = vec![node("NewGeometry", json!({}), json!({})), noise.clone()];
        nodes.extend(last);
        nodes
    };
    let none = nodes(vec![math("MULTIPLY", link(1, "Fac"), json!(0.0)), glow(link(2, "Value"))]);
    let (program, reports) = program(&none);
    assert_eq!((reports, program.instructions()), (vec![], 0));
    assert_eq!(colour(&program), Vec3A::ZERO);
    let mixed = node(
        "Mix",
        json!({"data_type": "RGBA", "blend_type": "DIFFERENCE"}),
        json!({"Factor_Float": 0.0, "A_Color": [0.2, 0.4, 0.6], "B_Color": link(1, "Color")}),
    );
    let (program, _) = self::program(&nodes(vec![mixed, glow(link(2, "Result_Color"))]));
    assert_eq!((program.instructions(), colour(&program)), (0, Vec3A::new(0.2, 0.4, 0.6)));
    // What changes nothing goes, and what it changes stays.
    let kept = nodes(vec![
        math("ADD", json!(0.0), link(1, "Fac")),
        math("SUBTRACT", link(2, "Value"), json!(0.0)),
        math("DIVIDE", link(3, "Value"), json!(1.0)),
        math("POWER", link(4, "Value"), json!(1.0)),
        glow(link(5, "Value")),
    ]);
    let plain = nodes(vec![glow(link(1, "Fac"))]);
    let (kept, plain) = (self::program(&kept).0, self::program(&plain).0);
    assert_eq!(kept.instructions(), plain.instructions());
    assert_eq!(colour(&kept), colour(&plain));
    let (inverse, _) =
        self::program(&nodes(vec![math("SUBTRACT", json!(0.0), link(1, "Fac")), glow(link(2, "Value"))]));
    assert_eq!(colour(&inverse), -colour(&plain));
}

#[test]
fn textures_at_a_place_that_stands_still_are_folded_too() {
    let noise = node("TexNoise", json!({}), json!({"Vector": [0.3, 0.4, 0.5], "Scale": 3.0, "Detail": 2.0}));
    let (program, _) = program(&[noise, glow(link(0, "Fac"))]);
    assert_eq!(program.instructions(), 0);
}

#[test]
fn what_nobody_reads_is_dropped() {
    let unread = node("TexNoise", json!({}), json!({"Scale": 3.0}));
    let (program, _) = program(&[unread, node("NewGeometry", json!({}), json!({})), glow(link(1, "Position"))]);
    assert_eq!(program.instructions(), 1);
}

/// A slice has fewer instructions than the program, the same bits for the results that were asked for, and further results with their
/// instructions.
#[test]
fn a_slice_computes_what_was_asked() {
    let noise = |scale: f32| node("TexNoise", json!({}), json!({"Vector": link(0, "Position"), "Scale": scale}));
    let ramp = json!({"table": [[0.1, 0.2, 0.3, 0.4], [0.9, 0.7, 0.5, 1.0]]});
    let nodes = [
        node("NewGeometry", json!({}), json!({})),
        noise(3.0),
        noise(7.0),
        node("ValToRGB", ramp, json!({"Fac": link(2, "Fac")})),
        node("Emission", json!({}), json!({"Color": link(1, "Color"), "Strength": link(3, "Alpha")})),
        node("BsdfDiffuse", json!({}), json!({"Color": link(3, "Color")})),
        node(
            "MixShader",
            json!({}),
            json!({"Fac": link(1, "Fac"), "Shader": link(4, "Emission"), "Shader_001": link(5, "BSDF")}),
        ),
    ];
    let (program, reports) = program(&nodes);
    assert!(reports.is_empty(), "{reports:?}");
    let whole = run(&program);
    let layers = &program.surface;
    let asked: Vec<Vec<_>> = vec![
        layers.iter().map(|layer| layer.weight).collect(),
        vec![layers[0].input("Color").unwrap()],
        vec![layers[0].input("Strength").unwrap()],
        vec![layers[1].input("Color").unwrap(), layers[1].weight],
        layers.iter().flat_map(|layer| [layer.weight, layer.input("Color").unwrap()]).collect(),
    ];
    for (number, values) in asked.into_iter().enumerate() {
        let slice = program.slice(values.clone());
        assert!(!slice.is_empty() && slice.len() <= program.instructions());
        if number < 3 {
            assert!(slice.len() < program.instructions(), "{number}: {} instructions", slice.len());
        }
        // What other places have left is no help.
        let mut registers = Registers::default();
        program.run_slice(&slice, &points().point(0, &program.attributes), &Vec::<Pixels>::new(), &mut registers);
        for value in values {
            assert_eq!(program.value(value, &registers), program.value(value, &whole), "{number}");
        }
    }
    assert!(program.slice([]).is_empty());
}

/// An image on a box needs the normal, a flat one does not; a bump looks beside the point.
#[test]
fn a_slice_tells_what_it_needs() {
    let needed = |texture: Value| {
        let geometry = node("NewGeometry", json!({}), json!({}));
        let bump = node("Bump", json!({}), json!({"Height": link(1, "Color"), "Strength": 1.0, "Distance": 1.0}));
        let bent = node("BsdfDiffuse", json!({}), json!({"Color": link(1, "Color"), "Normal": link(2, "Normal")}));
        let (program, _) = program(&[geometry, texture, bump, bent]);
        let [colour, normal] = ["Color", "Normal"].map(|name| program.slice(program.surface[0].input(name)));
        [colour.needs_normal(), colour.needs_footprint(), normal.needs_normal(), normal.needs_footprint()]
    };
    let image = |projection: &str| {
        let place = json!({"Vector": link(0, "Position")});
        node("TexImage", json!({"image": 0, "projection": projection}), place)
    };
    assert_eq!(needed(image("FLAT")), [false, false, true, true]);
    assert_eq!(needed(image("BOX")), [true, false, true, true]);
}

#[test]
fn attributes_that_nobody_reads_are_dropped() {
    let uv = |name: &str| node("UVMap", json!({"uv_map": name}), json!({}));
    // The coordinates' own UV is not read, only their normal.
    let both = node(
        "VectorMath",
        json!({"operation": "ADD"}),
        json!({"Vector": link(0, "Normal"), "Vector_001": link(1, "UV")}),
    );
    let (program, _) = program(&[node("TexCoord", json!({}), json!({})), uv("second"), both, glow(link(2, "Vector"))]);
    let names: Vec<_> = program.attributes.iter().map(|attribute| attribute.name.as_str()).collect();
    assert_eq!(names, ["second"]);
}

#[test]
fn the_same_instruction_stands_once() {
    let noise = || node("TexNoise", json!({}), json!({"Scale": 3.0, "Detail": 2.0}));
    let both = node(
        "VectorMath",
        json!({"operation": "ADD"}),
        json!({"Vector": link(0, "Fac"), "Vector_001": link(1, "Fac")}),
    );
    let (program, _) = program(&[noise(), noise(), both, glow(link(2, "Vector"))]);
    // Where to look, the noise, the sum.
    assert_eq!(program.instructions(), 3);
}

#[test]
fn values_become_what_their_reader_wants() {
    let geometry = node("NewGeometry", json!({}), json!({}));
    let to_number = |from: Value| node("Math", json!({"operation": "ADD"}), json!({"Value": from, "Value_001": 0.0}));
    // A vector to a number: the mean of its parts; a number to a colour: the same in each.
    let (mean, _) = program(&[geometry.clone(), to_number(link(0, "Position")), glow(link(1, "Value"))]);
    assert!((colour(&mean) - Vec3A::splat(10.0 / 3.0)).abs().max_element() < 1e-6);
    // A colour to a number: its luminance.
    let tint = node("Gamma", json!({}), json!({"Color": link(0, "Position"), "Gamma": 1.0}));
    let (luminance, _) = program(&[geometry, tint, to_number(link(1, "Color")), glow(link(2, "Value"))]);
    let expected = 0.2126 * 2.0 + 0.7152 * 3.0 + 0.0722 * 5.0;
    // The weights above have four digits.
    assert!((colour(&luminance) - Vec3A::splat(expected)).abs().max_element() < 1e-3);
}

#[test]
fn mixed_shaders_share_the_light() {
    let position = node("NewGeometry", json!({}), json!({}));
    let share =
        node("Math", json!({"operation": "MULTIPLY"}), json!({"Value": link(0, "Position"), "Value_001": 0.09}));
    let mix = |share: Value, a: Value, b: Value| {
        node("MixShader", json!({}), json!({"Fac": share, "Shader": a, "Shader_001": b}))
    };
    let end = |kind: &str| node(kind, json!({}), json!({"Color": [1.0, 1.0, 1.0]}));
    let nodes = [
        position,
        share,
        end("BsdfDiffuse"),
        end("BsdfGlossy"),
        end("BsdfTransparent"),
        mix(link(1, "Value"), link(2, "BSDF"), link(3, "BSDF")),
        mix(json!(0.25), link(5, "Shader"), link(4, "BSDF")),
    ];
    let (program, reports) = program(&nodes);
    assert!(reports.is_empty());
    let kinds: Vec<_> = program.surface.iter().map(|layer| layer.kind).collect();
    assert_eq!(kinds, [LayerKind::Diffuse, LayerKind::Glossy, LayerKind::Transparent]);
    // The inner share is 0.09 of the mean of 2, 3 and 5.
    for (weight, expected) in weights(&program).into_iter().zip([0.75 * 0.7, 0.75 * 0.3, 0.25]) {
        assert!((weight - expected).abs() < 1e-6, "{weight} is not {expected}");
    }
}

#[test]
fn shares_beyond_one_are_clamped_and_layers_without_light_dropped() {
    let end = |kind: &str| node(kind, json!({}), json!({"Color": [1.0, 1.0, 1.0]}));
    let mix =
        node("MixShader", json!({}), json!({"Fac": 3.0, "Shader": link(0, "BSDF"), "Shader_001": link(1, "BSDF")}));
    let (program, _) = program(&[end("BsdfDiffuse"), end("BsdfGlossy"), mix]);
    assert_eq!(program.surface.len(), 1);
    assert_eq!(program.surface[0].kind, LayerKind::Glossy);
    assert_eq!(weights(&program), [1.0]);
}

#[test]
fn a_shader_that_comes_in_twice_counts_twice() {
    let diffuse = node("BsdfDiffuse", json!({}), json!({"Color": [1.0, 1.0, 1.0]}));
    let add = node("AddShader", json!({}), json!({"Shader": link(0, "BSDF"), "Shader_001": link(0, "BSDF")}));
    let (program, _) = program(&[diffuse, add]);
    assert_eq!(program.surface.len(), 1);
    assert_eq!(weights(&program), [2.0]);
}

#[test]
fn a_colour_where_a_shader_belongs_glows() {
    let add = node("AddShader", json!({}), json!({"Shader": link(0, "Position")}));
    let (program, _) = program(&[node("NewGeometry", json!({}), json!({})), add]);
    assert_eq!(program.surface[0].kind, LayerKind::Emission);
    assert_eq!(colour(&program), Vec3A::new(2.0, 3.0, 5.0));
}

#[test]
fn a_normal_that_is_not_linked_is_the_surface_s_own() {
    let (program, _) = program(&[node("BsdfDiffuse", json!({}), json!({"Color": [1.0, 1.0, 1.0]}))]);
    assert_eq!(program.surface[0].input("Normal"), None);
}

#[test]
fn options_that_are_words_stay_with_their_layer() {
    let (program, _) = program(&[node("BsdfGlossy", json!({"distribution": "GGX"}), json!({}))]);
    assert_eq!(program.surface[0].option("distribution"), Some("GGX"));
}

fn assert_reported(reports: &[Report], node: &str, kind: &str) {
    assert!(reports.iter().any(|report| report.node == node && report.kind == kind), "{node} is not in {reports:?}");
}

#[test]
fn unknown_nodes_are_named_and_their_links_do_not_count() {
    let future = || node("TexFuture", json!({}), json!({}));
    let own = json!({"node": 0, "socket": "Color", "unlinked": [0.2, 0.3, 0.4]});
    let (glowing, reports) = program(&[future(), glow(own)]);
    assert_reported(&reports, "my TexFuture", "ShaderNodeTexFuture");
    assert_eq!(colour(&glowing), Vec3A::new(0.2, 0.3, 0.4));
    // A normal has no value of its own, and what should be a shader adds nothing.
    let diffuse = node("BsdfDiffuse", json!({}), json!({"Color": [1.0, 1.0, 1.0], "Normal": link(0, "Normal")}));
    let sum = node("AddShader", json!({}), json!({"Shader": link(0, "Shader"), "Shader_001": link(1, "BSDF")}));
    let (matte, _) = program(&[future(), diffuse, sum]);
    let [layer] = &matte.surface[..] else { panic!("one layer, not {:?}", matte.surface) };
    assert_eq!(layer.input("Normal"), None);
}

#[test]
fn unknown_options_are_named_and_black() {
    let (program, reports) =
        program(&[node("Math", json!({"operation": "FUTURE"}), json!({"Value": 1.0})), glow(link(0, "Value"))]);
    assert_reported(&reports, "my Math", "ShaderNodeMath");
    assert_eq!(colour(&program), Vec3A::ZERO);
}

#[test]
fn circles_are_named_and_end() {
    let sum = |from: usize| {
        node("Math", json!({"operation": "ADD"}), json!({"Value": link(from, "Value"), "Value_001": 1.0}))
    };
    let (values, reports) = program(&[sum(1), sum(0), glow(link(0, "Value"))]);
    assert_reported(&reports, "my Math", "ShaderNodeMath");
    assert!(colour(&values).is_finite());
    let shaders = node("AddShader", json!({}), json!({"Shader": link(0, "Shader"), "Shader_001": link(0, "Shader")}));
    let (program, reports) = program(&[shaders]);
    assert_reported(&reports, "my AddShader", "ShaderNodeAddShader");
    assert!(program.surface.is_empty());
}

#[test]
fn endless_rows_of_nodes_end() {
    let sum = |from: usize| {
        node("Math", json!({"operation": "ADD"}), json!({"Value": link(from, "Value"), "Value_001": 1.0}))
    };
    let mut nodes = vec![node("NewGeometry", json!({}), json!({}))];
    nodes.extend((0..3000).map(sum));
    nodes.push(glow(link(3000, "Value")));
    let (_, reports) = program(&nodes);
    assert!(!reports.is_empty());
}

#[test]
fn endless_rows_of_shaders_end() {
    let add = |from: usize, socket: &str| {
        node("AddShader", json!({}), json!({"Shader": link(from, socket), "Shader_001": link(from, socket)}))
    };
    // Each doubles the ways to the one below: 2 to the 60th.
    let mut nodes = vec![node("BsdfDiffuse", json!({}), json!({})), add(0, "BSDF")];
    nodes.extend((1..60).map(|i| add(i, "Shader")));
    let (_, reports) = program(&nodes);
    assert!(!reports.is_empty());
    let single = |from: usize, socket: &str| node("AddShader", json!({}), json!({"Shader": link(from, socket)}));
    let mut nodes = vec![node("BsdfDiffuse", json!({}), json!({})), single(0, "BSDF")];
    nodes.extend((1..3000).map(|i| single(i, "Shader")));
    let (_, reports) = program(&nodes);
    assert!(!reports.is_empty());
}

/// A tree of sums over (2 + 3 + 4 + ...) times x: far more results than there are registers.
fn tree_of_sums(count: usize) -> (Program, Vec<Report>) {
    let mut nodes = vec![
        node("SeparateXYZ", json!({}), json!({"Vector": link(1, "Position")})),
        node("NewGeometry", json!({}), json!({})),
    ];
    let math = |operation: &str, a: Value, b: Value| {
        node("Math", json!({"operation": operation}), json!({"Value": a, "Value_001": b}))
    };
    for i in 0..count {
        nodes.push(math("MULTIPLY", link(0, "X"), json!(i + 2)));
    }
    let mut level: Vec<usize> = (2..count + 2).collect();
    while level.len() > 1 {
        let half = level.len() / 2;
        let next: Vec<usize> = (0..half)
            .map(|i| {
                nodes.push(math("ADD", link(level[i], "Value"), link(level[i + half], "Value")));
                nodes.len() - 1
            })
            .collect();
        level = next;
    }
    nodes.push(glow(link(level[0], "Value")));
    program(&nodes)
}

#[test]
fn registers_are_used_again() {
    let (program, reports) = tree_of_sums(512);
    assert!(reports.is_empty(), "{reports:?}");
    let expected = 2.0 * (2..514).sum::<i32>() as f32;
    assert_eq!(colour(&program), Vec3A::splat(expected));
}

#[test]
fn more_layers_than_registers_are_refused_by_name() {
    let mut nodes = vec![node("NewGeometry", json!({}), json!({}))];
    let mut before: Option<usize> = None;
    for i in 0..120 {
        let scaled = |by: i32| {
            node("VectorMath", json!({"operation": "SCALE"}), json!({"Vector": link(0, "Position"), "Scale": by}))
        };
        nodes.extend([scaled(3 * i + 2), scaled(3 * i + 3), scaled(3 * i + 4)]);
        let last = nodes.len();
        let inputs = json!({"Color": link(last - 3, "Vector"), "Roughness": link(last - 2, "Vector"), "Normal": link(last - 1, "Vector")});
        nodes.push(node("BsdfDiffuse", json!({}), inputs));
        if let Some(before) = before {
            let shader = if nodes[before]["type"] == "ShaderNodeAddShader" { "Shader" } else { "BSDF" };
            nodes.push(node(
                "AddShader",
                json!({}),
                json!({"Shader": link(before, shader), "Shader_001": link(last, "BSDF")}),
            ));
        }
        before = Some(nodes.len() - 1);
    }
    let (program, reports) = program(&nodes);
    assert!(reports.iter().any(|report| report.what.contains("too many values")), "{reports:?}");
    assert!(program.surface.is_empty());
}

#[test]
fn descriptions_that_are_no_graphs_are_refused() {
    for (text, part) in [
        ("", "JSON"),
        ("{}", "nodes"),
        (r#"{"nodes": [{}]}"#, "no type"),
        (r#"{"nodes": [{"type": "ShaderNodeMath", "inputs": {"Value": "one"}}]}"#, "Value"),
        (r#"{"nodes": [], "surface": {"node": 0, "socket": "BSDF"}}"#, "node 0"),
        (r#"{"nodes": [], "surface": 7}"#, "surface"),
    ] {
        let error = Graph::from_json(text).expect_err(text).to_string();
        assert!(error.contains(part), "{error:?} does not say {part:?}");
    }
}

#[test]
fn places_that_are_no_numbers_do_no_harm() {
    let textures = [
        ("TexNoise", json!({"noise_dimensions": "3D"}), "Color"),
        ("TexNoise", json!({"noise_dimensions": "4D", "noise_type": "RIDGED_MULTIFRACTAL"}), "Fac"),
        ("TexNoise", json!({"noise_dimensions": "1D"}), "Fac"),
        ("TexNoise", json!({"noise_dimensions": "2D"}), "Fac"),
        ("TexVoronoi", json!({}), "Color"),
        ("TexVoronoi", json!({"feature": "SMOOTH_F1", "voronoi_dimensions": "4D"}), "Color"),
        ("TexVoronoi", json!({"feature": "DISTANCE_TO_EDGE", "voronoi_dimensions": "2D"}), "Distance"),
        ("TexVoronoi", json!({"feature": "N_SPHERE_RADIUS", "cell_hash": "LOOKUP3"}), "Radius"),
        ("TexWave", json!({}), "Color"),
        ("TexMagic", json!({"turbulence_depth": 5}), "Color"),
        ("TexGradient", json!({"gradient_type": "RADIAL"}), "Color"),
        ("TexChecker", json!({}), "Color"),
        ("TexBrick", json!({}), "Color"),
        ("TexWhiteNoise", json!({}), "Color"),
        ("TexGabor", json!({"gabor_type": "3D"}), "Value"),
        ("TexImage", json!({"image": 0, "extension": "MIRROR"}), "Color"),
        ("TexImage", json!({"image": 0, "interpolation": "Cubic", "projection": "BOX"}), "Color"),
        ("TexEnvironment", json!({"image": 0}), "Color"),
        ("ValToRGB", json!({"table": [[0, 0, 0, 1], [1, 1, 1, 1]]}), "Color"),
        ("RGBCurve", json!({"table": [[0, 0, 0, 1], [1, 1, 1, 1]]}), "Color"),
        ("Blackbody", json!({}), "Color"),
        ("Wavelength", json!({}), "Color"),
    ];
    let images = vec![Pixels::new(2, vec![Vec3A::ONE.extend(1.0); 4]).expect("two rows")];
    for (kind, options, output) in textures {
        let names =
            ["Vector", "W", "Scale", "Detail", "Roughness", "Fac", "Color", "Temperature", "Wavelength", "Brick Width"];
        let inputs: serde_json::Map<_, _> = names.iter().map(|name| (name.to_string(), link(0, "Position"))).collect();
        let nodes =
            [node("NewGeometry", json!({}), json!({})), node(kind, options, inputs.into()), glow(link(1, output))];
        let (program, reports) = program(&nodes);
        assert!(reports.is_empty(), "{reports:?}");
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e10, -1e10, 0.0] {
            let mut points = Points::default();
            let column = Column { values: vec![Vec3A::splat(value).extend(1.0)], ..Column::default() };
            assert!(points.add("position", column));
            let mut registers = Registers::default();
            program.run(&points.point(0, &program.attributes), &images, &mut registers);
            // A texture of 0 is none of its kind's limits.
            if value == 0.0 {
                let colour = program.value(program.surface[0].input("Color").expect("a colour"), &registers);
                assert!(colour.is_finite() || kind == "TexBrick", "{kind} {output}: {colour}");
            }
        }
    }
}

#[test]
fn bump_looks_at_three_places() {
    let position = node("NewGeometry", json!({}), json!({}));
    let height = node("TexNoise", json!({}), json!({"Vector": link(0, "Position"), "Scale": 1.0}));
    let bump = node("Bump", json!({}), json!({"Height": link(1, "Fac"), "Strength": 1.0, "Distance": 1.0}));
    let diffuse = node("BsdfDiffuse", json!({}), json!({"Normal": link(2, "Normal")}));
    let (program, reports) = program(&[position, height, bump, diffuse]);
    assert!(reports.is_empty());
    // The normal; three times a place and the noise there; the bump.
    assert_eq!(program.instructions(), 8);
    let input = |layer: &Layer| layer.input("Normal").is_some();
    assert!(input(&program.surface[0]));
}

/// A strand is as wide as the major axis of its fibre: the fibre covers a part of it, and beside that the strand is transparent.
#[test]
fn elliptical_hair_is_transparent_beside_the_fibre() {
    let hair =
        |model: &str, aspect: f32| node("BsdfHairPrincipled", json!({"model": model}), json!({"Aspect Ratio": aspect}));
    for round in [hair("HUANG", 1.0), hair("CHIANG", 0.5)] {
        assert_eq!(program(&[round]).0.surface.len(), 1);
    }
    let add = node("AddShader", json!({}), json!({"Shader": link(0, "BSDF"), "Shader_001": link(0, "BSDF")}));
    // The view at 60 degrees to the axis: half of the width that is seen is the root of 1 - (1 - 0.25) 0.25 = 0.8125, and of
    // 1 - (1 - 0.25) 0.75 = 0.4375 where the axis is the minor one.
    for (aspect, offset, covered) in [(0.5, 0.9, 1.0), (0.5, -0.91, 0.0), (2.0, 0.66, 1.0), (2.0, 0.67, 0.0)] {
        let (program, reports) = program(&[hair("HUANG", aspect), add.clone()]);
        assert!(reports.is_empty(), "{reports:?}");
        let mut points = points();
        for (field, value) in [
            ("strand_normal", Vec3A::new(0.5, 0.75f32.sqrt(), 0.0)),
            ("strand_axis", Vec3A::X),
            ("strand_offset", Vec3A::splat(offset)),
        ] {
            assert!(points.add(field, Column { values: vec![value.extend(1.0)], ..Column::default() }), "{field}");
        }
        let mut registers = Registers::default();
        program.run(&points.point(0, &program.attributes), &Vec::<Pixels>::new(), &mut registers);
        let layers = program.surface.iter().map(|layer| (layer.kind, program.value(layer.weight, &registers).x));
        let expected = [(LayerKind::Transparent, 2.0 * (1.0 - covered)), (LayerKind::PrincipledHair, 2.0 * covered)];
        assert_eq!(layers.collect::<Vec<_>>(), expected, "{aspect} {offset}");
    }
}

/// Names of nodes and sockets may hold line ends; a message has one line.
#[test]
fn a_message_about_a_graph_has_one_line() {
    for node in [json!({"type": "x", "name": "a\nb", "inputs": {"c\nd": "e"}}), json!({"name": "a\nb"})] {
        let error = Graph::from_json(&json!({"nodes": [node]}).to_string()).unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
    }
}
