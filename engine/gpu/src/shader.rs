// SPDX-License-Identifier: GPL-3.0-or-later
//! The text of shaders: the parts in shaders/*.wgsl put together, and the part that is written for one lens.

use crate::lens::{Bend, Form, LensTable, Opening, Stage};
use crate::number::Number;

const SURFACE: &str = include_str!("shaders/surface.wgsl");
const ITERATED: &str = include_str!("shaders/iterated.wgsl");
const BINDINGS: &str = include_str!("shaders/bindings.wgsl");
const BENT: &str = include_str!("shaders/bent.wgsl");
const STRAIGHT: &str = include_str!("shaders/straight.wgsl");
const FIELD: &str = include_str!("shaders/field.wgsl");
const LOADED: &str = include_str!("shaders/loaded.wgsl");
const TRACE: &str = include_str!("shaders/trace.wgsl");
const FLOOD: &str = include_str!("shaders/flood.wgsl");

/// Rays in a workgroup, unless another number is measured to be better.
pub const GROUP: u32 = 128;

/// The form in which a lens comes to the shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// One shader for all lenses, but for those with gradients, which have another: it reads surfaces from memory.
    Loaded,
    /// A shader for this lens, a surface after the other with its numbers in the text: faster, and compiled anew for each lens.
    Written,
}

/// The shader that traces the rays of a buffer.
pub fn trace<N: Number>(lens: &LensTable, style: Style, group: u32) -> String {
    assembled::<N>(lens, style, group, TRACE)
}

/// The shader that makes rays, traces them and adds up the results.
pub fn flood<N: Number>(lens: &LensTable, style: Style, group: u32) -> String {
    assembled::<N>(lens, style, group, FLOOD)
}

fn assembled<N: Number>(lens: &LensTable, style: Style, group: u32, entry: &str) -> String {
    let lens = match style {
        Style::Loaded if lens.has_gradients() => format!("{ITERATED}\n{FIELD}\n{BENT}\n{LOADED}"),
        Style::Loaded => format!("{ITERATED}\n{STRAIGHT}\n{LOADED}"),
        Style::Written => written::<N>(lens),
    };
    format!("{}\n{SURFACE}\n{BINDINGS}\n{lens}\nconst GROUP = {group}u;\n{entry}", N::WGSL)
}

/// A number that a shader reads as it is, to the last bit.
struct Exact<N>(N);

impl<N: Number> std::fmt::Display for Exact<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let x = self.0.to_f64();
        let x = if x.is_finite() { x } else { N::LARGEST.to_f64().copysign(x) };
        if x < 0.0 { write!(f, "({x:e})") } else { write!(f, "{x:e}") }
    }
}

fn exact<N: Number>(x: f64) -> Exact<N> {
    Exact(N::from_f64(x))
}

/// The part of the shader that is loaded.wgsl for any lens, written for this one.
fn written<N: Number>(lens: &LensTable) -> String {
    let mut text = opening::<N>(&lens.opening);
    let fields = lens.field_places();
    if lens.has_gradients() {
        text += FIELD;
    }
    for (s, stage) in lens.stages.iter().enumerate().filter(|(_, stage)| stage.form != Form::Conic) {
        text += &profile::<N>(s, stage);
        text += &ITERATED.replace("_any", &format!("_{s}"));
    }
    for (s, stage) in lens.stages.iter().enumerate() {
        if stage.is_beside_gradient() {
            text += &BENT.replace("_any", &format!("_{s}"));
        }
        text += &pass::<N>(s, stage, fields[s], lens.wavelengths);
    }
    text += "fn trace_lens(start: vec3<real>, along: vec3<real>, wavelength: u32) -> Flight {\n";
    text += "    var at = Passage(start, along, THROUGH);\n";
    for (s, stage) in lens.stages.iter().enumerate() {
        let fate = stage.surface << 3;
        text += &format!("    at = pass_{s}(at.point, at.direction, wavelength);\n");
        text += "    if (at.reason != THROUGH) {\n";
        text += &format!("        return Flight(at.point, at.direction, {fate}u | at.reason);\n    }}\n");
    }
    text + "    return Flight(at.point, at.direction, 0u);\n}\n"
}

fn opening<N: Number>(opening: &Opening) -> String {
    let number = |x: f64| exact::<N>(x);
    let mut text = "fn is_open(x: real, y: real, squared: real) -> bool {\n".to_owned();
    let radius_squared = number(opening.radius_squared);
    if let Some(mask) = &opening.mask {
        let (cos, sin) = (number(mask.cos), number(mask.sin));
        return format!("{text}    return squared <= {radius_squared} && mask_value(x, y, {cos}, {sin}) > 0.0;\n}}\n");
    }
    if opening.sides.is_empty() {
        return format!("{text}    return squared <= {radius_squared};\n}}\n");
    }
    let inside = number(opening.apothem * opening.apothem);
    text += &format!("    if (squared <= {inside}) {{\n        return true;\n    }}\n");
    text += &format!("    var open = squared <= {radius_squared};\n");
    for [x, y] in &opening.sides {
        let along = format!("x * {} + y * {}", number(*x), number(*y));
        let (bulge, slope, bound) = (number(opening.bulge), number(opening.slope), number(opening.bound));
        text += &match opening.bulge {
            0.0 => format!("    open = open && {along} <= {};\n", number(opening.apothem)),
            _ => format!("    open = open && squared * {bulge} + ({along}) * {slope} <= {bound};\n"),
        };
    }
    text + "    return open;\n}\n"
}

/// The numbers that `form_any` and `profile_any` of loaded.wgsl read from memory.
fn profile<N: Number>(s: usize, stage: &Stage) -> String {
    let number = |x: f64| exact::<N>(x);
    let (c, k, across) = (number(stage.curvature), number(stage.conic), number(stage.across));
    let is_toroid = stage.form == Form::Toroid;
    let mut text = format!("fn form_{s}(s: u32) -> Form {{\n    return Form({c}, {k}, {across}, {is_toroid});\n}}\n");
    text += &format!("fn profile_{s}(s: u32, u: real) -> Profile {{\n");
    text += &format!("    let c: real = {c};\n    let k: real = {k};\n");
    text += "    let weight = root(max(-(u * ((1.0 + k) * c * c) - 1.0), real(0.0)));\n";
    text += "    let base = quotient(u * c, weight + 1.0);\n    var value: real = 0.0;\n    var change: real = 0.0;\n";
    let horner = |terms: &[f64]| -> String {
        let step = |a: &f64| format!("    change = change * u + value;\n    value = value * u + {};\n", number(*a));
        terms.iter().rev().map(step).collect()
    };
    text += &horner(&stage.even);
    text += "    var polynomial = value * u;\n    var slope = value + change * u;\n";
    if !stage.odd.is_empty() {
        text += "    value = real(0.0);\n    change = real(0.0);\n";
        text += &horner(&stage.odd);
        text += "    let radius = root(u);\n    polynomial = polynomial + radius * u * value;\n";
        text += "    slope = slope + radius * (value * 1.5 + change * u);\n";
    }
    text + "    return Profile(base + polynomial, weight, (slope + slope) * weight + c);\n}\n"
}

/// One round of the loop in `trace_lens` of loaded.wgsl.
fn pass<N: Number>(s: usize, stage: &Stage, [before, behind]: [u32; 2], wavelengths: usize) -> String {
    let number = |x: f64| exact::<N>(x);
    let vector = |[x, y, z]: [f64; 3]| format!("vec3<real>({}, {}, {})", number(x), number(y), number(z));
    let side = number(stage.side);
    let mut text = String::new();
    // In the surface's own coordinates.
    let mut inside = String::new();
    if let Some([x, y, z, vertex]) = stage.pose {
        let (x, y, z) = (vector(x), vector(y), vector(z));
        inside += &format!("    let q = p - {};\n", vector(vertex));
        for (to, v) in [("p", "q"), ("d", "d")] {
            inside += &format!("    {to} = vec3<real>(dot({v}, {x}), dot({v}, {y}), dot({v}, {z}));\n");
        }
    }
    let meet = match stage.form {
        Form::Conic => format!("meet_conic({}, {}, p, d, {side})", number(stage.curvature), number(stage.conic)),
        Form::Asphere | Form::Toroid => format!("meet_iterated_{s}({s}u, p, d, {side})"),
    };
    let outside = |v: &str, moved: bool| match stage.pose {
        None => v.to_owned(),
        Some([x, y, z, vertex]) => {
            let (x, y, z) = (vector(x), vector(y), vector(z));
            let moved = if moved { format!(" + {}", vector(vertex)) } else { String::new() };
            format!("{x} * {v}.x + {y} * {v}.y + {z} * {v}.z{moved}")
        }
    };
    let i = format!("2u * ({s}u * job.wavelengths + wavelength)");
    let head = format!("fn pass_{s}(start: vec3<real>, along: vec3<real>, wavelength: u32) -> Passage {{\n");
    let to_here = format!("    p.z = p.z + {};\n", number(stage.to_here));
    let interface = if stage.is_beside_gradient() {
        text += &format!("fn meet_{s}(s: u32, from_here: vec3<real>, along: vec3<real>) -> Crossing {{\n");
        text += &format!("    var p = from_here;\n    var d = along;\n{inside}");
        text += if stage.is_far { "    let far = -dot(p, d);\n" } else { "    let far: real = 0.0;\n" };
        text += if stage.is_far { "    p = p + d * far;\n" } else { "" };
        text += &format!("    var at = {meet};\n    at.t = at.t + far;\n    return at;\n}}\n");
        text += &format!("fn outside_{s}(s: u32, place: vec3<real>) -> vec3<real> {{\n");
        text += &format!("    return {};\n}}\n{head}", outside("place", true));
        text += &format!("    var p = start;\n    var d = along;\n{to_here}    let i = {i};\n");
        text += "    let bases = vec2<real>(interfaces[i], interfaces[i + 1u]);\n";
        text += &format!("    let beside = beside_{s}({s}u, {before}u, {behind}u, bases, p, d);\n");
        text += &format!("    let at = beside.at;\n    d = beside.direction;\n{inside}");
        "beside.ratio, beside.excess".to_owned()
    } else {
        text += &format!("{head}    var p = start;\n    var d = along;\n{to_here}{inside}");
        text += if stage.is_far { "    p = carried(p, d);\n" } else { "" };
        text += &format!("    let at = {meet};\n");
        if wavelengths > 1 && stage.bend == Bend::Refract {
            text += &format!("    let i = {i};\n");
            "interfaces[i], interfaces[i + 1u]".to_owned()
        } else {
            let [ratio, excess] = stage.interfaces[0];
            format!("{}, {}", number(ratio), number(excess))
        }
    };
    let action = match stage.bend {
        Bend::Refract => "REFRACT",
        Bend::Pass => "PASS",
        Bend::Reflect => "REFLECT",
    };
    let (clear, obstruction) = (number(stage.clear_squared), number(stage.obstruction_squared));
    let is_stop = stage.is_stop;
    text +=
        &format!("    let passage = act(d, at, {side}, {clear}, {obstruction}, {is_stop}, {action}, {interface});\n");
    let (point, direction) = (outside("passage.point", true), outside("passage.direction", false));
    text + &format!("    return Passage({point}, {direction}, passage.reason);\n}}\n")
}
