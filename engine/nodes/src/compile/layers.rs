//! The shader nodes above an output, flattened to closures that add up.

use super::{At, Compiler, DEEPEST, ValueKind};
use crate::context::{Field, Shift};
use crate::graph::{Input, Link};
use crate::math::MathKind;
use crate::program::{Layer, LayerKind, Operand, Operation};
use crate::vector::VectorMathKind;
use glam::Vec3A;

/// Ways through Mix and Add Shaders double where one leads to another twice.
const MOST_WAYS: usize = 10_000;

/// Limit of closures: more than any material has that a person made.
const MOST_LAYERS: usize = 128;

/// The kind of a closure's input: of three parts, or a number.
fn kind_of_input(layer: LayerKind, identifier: &str) -> ValueKind {
    const PARTS: [&str; 9] = [
        "Color",
        "Tint",
        "Normal",
        "Tangent",
        "Coefficient",
        "Extinction",
        "Subsurface Radius",
        "Position",
        "Direction",
    ];
    let whole = (layer == LayerKind::Metallic && identifier == "IOR")
        || (layer == LayerKind::Subsurface && identifier == "Radius");
    if whole || PARTS.iter().any(|part| identifier.contains(part)) { ValueKind::Vector } else { ValueKind::Number }
}

/// The inputs and the options of a [`Layer`].
type LayerParts = (Vec<(String, Operand)>, Vec<(String, String)>);

/// Shader nodes that have been walked through to reach a closure, and its share.
#[derive(Default)]
struct LayerWalk {
    layers: Vec<(usize, Layer)>,
    ways: usize,
}

impl Compiler<'_> {
    pub(super) fn layers(&mut self, start: Option<&Link>) -> Vec<Layer> {
        let mut walk = LayerWalk::default();
        if let Some(link) = start {
            let whole = self.constant(Vec3A::ONE);
            self.walk(link, whole, &mut walk);
        }
        walk.layers.into_iter().map(|(_, layer)| layer).collect()
    }

    fn walk(&mut self, link: &Link, weight: Operand, walk: &mut LayerWalk) {
        if self.known(weight) == Some(Vec3A::ZERO) {
            return;
        }
        let index = link.node;
        let node = &self.graph.nodes[index];
        if self.open.contains(&index) {
            return self.report(index, "its output leads back into itself, it is black");
        }
        walk.ways += 1;
        if self.open.len() >= DEEPEST || walk.ways > MOST_WAYS {
            return self.report(index, "too many shaders in a row, this one is left out");
        }
        if walk.layers.len() >= MOST_LAYERS {
            return self.report(index, "the material has too many shaders, this one is left out");
        }
        self.open.push(index);
        match node.kind.as_str() {
            "ShaderNodeMixShader" => {
                let mut at = At { compiler: self, index, node, shift: Shift::NONE };
                let share = at.number_or("Fac", 0.5);
                let share = at.emit(Operation::Saturate, &[share]);
                let one = at.constant(1.0);
                let zero = at.constant(0.0);
                let rest = at.emit(Operation::Math(MathKind::Subtract, false), &[one, share, zero]);
                for (socket, part) in [("Shader", rest), ("Shader_001", share)] {
                    let part = self.emit(Operation::Math(MathKind::Multiply, false), &[weight, part, zero]);
                    self.walk_input(index, socket, part, walk);
                }
            }
            "ShaderNodeAddShader" => {
                for socket in ["Shader", "Shader_001"] {
                    self.walk_input(index, socket, weight, walk);
                }
            }
            node => match LayerKind::of_node(node) {
                Some(kind) => self.add_closure(index, kind, weight, walk),
                None => {
                    self.open.pop();
                    return self.bare_colour(link, weight, walk);
                }
            },
        }
        self.open.pop();
    }

    fn walk_input(&mut self, index: usize, socket: &str, weight: Operand, walk: &mut LayerWalk) {
        // An empty shader socket is black.
        if let Some(Input::Link(link)) = self.graph.nodes[index].input(socket) {
            self.walk(link, weight, walk);
        }
    }

    fn add_closure(&mut self, index: usize, kind: LayerKind, weight: Operand, walk: &mut LayerWalk) {
        let node = &self.graph.nodes[index];
        let covered = (kind == LayerKind::PrincipledHair && node.word("model") == Some("HUANG"))
            .then(|| At { compiler: self, index, node, shift: Shift::NONE }.covered_by_fibre())
            .flatten();
        let one = self.constant(Vec3A::ONE);
        let zero = self.constant(Vec3A::ZERO);
        if let Some(covered) = covered {
            let beside = self.emit(Operation::Math(MathKind::Subtract, false), &[one, covered, zero]);
            let beside = self.emit(Operation::Math(MathKind::Multiply, false), &[weight, beside, zero]);
            self.add_layer(index, LayerKind::Transparent, beside, walk, |_| {
                (vec![("Color".to_owned(), one)], Vec::new())
            });
        }
        let weight = match covered {
            Some(covered) => self.emit(Operation::Math(MathKind::Multiply, false), &[weight, covered, zero]),
            None => weight,
        };
        self.add_layer(index, kind, weight, walk, |compiler| compiler.inputs_of(index, kind, covered.is_some()));
    }

    /// Adds a closure of a node, or more of it where the node has been reached before.
    fn add_layer(
        &mut self,
        index: usize,
        kind: LayerKind,
        weight: Operand,
        walk: &mut LayerWalk,
        parts: impl FnOnce(&mut Self) -> LayerParts,
    ) {
        let is_same = |(other, layer): &&mut (usize, Layer)| *other == index && layer.kind == kind;
        if let Some((_, same)) = walk.layers.iter_mut().find(is_same) {
            let zero = self.constant(Vec3A::ZERO);
            same.weight = self.emit(Operation::Math(MathKind::Add, false), &[same.weight, weight, zero]);
            return;
        }
        let (inputs, options) = parts(self);
        walk.layers.push((index, Layer { kind, weight, inputs, options, is_bare_colour: false }));
    }

    /// The inputs and the options of a closure.
    fn inputs_of(&mut self, index: usize, kind: LayerKind, is_elliptical: bool) -> LayerParts {
        let node = &self.graph.nodes[index];
        let mut at = At { compiler: self, index, node, shift: Shift::NONE };
        let mut inputs = Vec::new();
        for (identifier, _) in &node.inputs {
            let operand = at.input(identifier, kind_of_input(kind, identifier), Shift::NONE);
            inputs.extend(operand.map(|operand| (identifier.clone(), operand)));
        }
        if is_elliptical {
            inputs.push(("Tangent".to_owned(), at.read_once(Field::StrandAxis)));
        }
        let options = node.words().map(|(name, word)| (name.clone(), word.to_owned())).collect();
        (inputs, options)
    }

    /// A colour where a shader belongs emits that colour.
    fn bare_colour(&mut self, link: &Link, weight: Operand, walk: &mut LayerWalk) {
        let Some(colour) = self.linked(link, ValueKind::Colour, Shift::NONE) else { return };
        let one = self.constant(Vec3A::ONE);
        let inputs = vec![("Color".to_owned(), colour), ("Strength".to_owned(), one)];
        // Each place where a bare colour enters is a closure of its own.
        let (kind, options) = (LayerKind::Emission, Vec::new());
        walk.layers.push((usize::MAX, Layer { kind, weight, inputs, options, is_bare_colour: true }));
    }
}

impl At<'_, '_> {
    /// 1 where a strand's elliptical fibre is hit, 0 beside it: strands are as wide as its major axis. `None` where the fibre is round.
    ///
    /// As in Cycles (`bsdf_principled_hair_huang.h`): with the cosine d of the view across the strand to the major axis, half of the width that is
    /// seen is the root of 1 - (1 - minor²) d².
    fn covered_by_fibre(mut self) -> Option<Operand> {
        use MathKind::{Add, Divide, GreaterThan, LessThan, Minimum, Multiply, Subtract};
        let aspect = self.number_or("Aspect Ratio", 1.0);
        let (zero, one) = (self.constant(0.0), self.constant(1.0));
        if aspect == one {
            return None;
        }
        let [view, axis, offset] =
            [Field::StrandNormal, Field::StrandAxis, Field::StrandOffset].map(|field| self.read_once(field));
        let cos = self.emit(Operation::VectorMath(VectorMathKind::Dot), &[view, axis, zero, zero]);
        let mut math = |kind, a, b| self.emit(Operation::Math(kind, false), &[a, b, zero]);
        let to_axis = math(Multiply, cos, cos);
        // Above an aspect of 1 the axis is the minor one.
        let is_minor = math(GreaterThan, aspect, one);
        let is_major = math(Subtract, one, is_minor);
        let across_axis = math(Subtract, one, to_axis);
        let (of_minor, of_major) = (math(Multiply, is_minor, across_axis), math(Multiply, is_major, to_axis));
        let to_major = math(Add, of_minor, of_major);
        let inverse = math(Divide, one, aspect);
        let minor = math(Minimum, aspect, inverse);
        let squared_minor = math(Multiply, minor, minor);
        let squared_eccentricity = math(Subtract, one, squared_minor);
        let lost = math(Multiply, squared_eccentricity, to_major);
        let squared_radius = math(Subtract, one, lost);
        let squared_offset = math(Multiply, offset, offset);
        Some(math(LessThan, squared_offset, squared_radius))
    }
}
