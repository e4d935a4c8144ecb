//! Compilation of a graph to a program: nodes become instructions, constants are folded, results that are not read are dropped.

mod allocate;
mod colours;
mod emit;
mod inputs;
mod layers;
mod maths;
mod surfaces;
mod textures;

use crate::context::Shift;
use crate::graph::{Graph, Input, Link, Node};
use crate::program::{Instruction, Operand, Operation, Program, Registers};
use glam::{Affine3A, Vec3A};
use std::collections::{HashMap, HashSet};

/// A report of a node that could not be evaluated as Blender does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// The user's name of the node.
    pub node: String,
    /// The `bl_idname` of the node in Blender.
    pub kind: String,
    /// The problem, in words for a message.
    pub what: String,
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "node {} ({}): {}", self.node, self.kind, self.what)
    }
}

/// The kind of value of an output, which decides the conversions from and to a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValueKind {
    Number,
    Vector,
    Colour,
}

/// The value of a node's output in a program.
#[derive(Clone, Copy, Debug)]
struct Value {
    kind: ValueKind,
    operand: Operand,
}

/// A node's outputs by identifier.
type Outputs = Vec<(&'static str, Value)>;

/// The output that a link leads to.
enum LinkedOutput {
    Value(Value),
    /// No value, which is black.
    Nothing,
    /// A node that is not known.
    Unknown,
}

/// The outputs of a lowered node; the error says why it cannot be lowered.
type Lowered = Result<Outputs, String>;

/// Chains longer than this are no longer followed: they would not fit on the stack.
const DEEPEST: usize = 1000;

/// A program for a graph, and reports on its parts that had to be left out.
pub fn compile(graph: &Graph) -> (Program, Vec<Report>) {
    let mut compiler = Compiler::new(graph);
    let surface = compiler.layers(graph.surface.as_ref());
    let volume = compiler.layers(graph.volume.as_ref());
    let displacement =
        graph.displacement.as_ref().and_then(|link| compiler.linked(link, ValueKind::Vector, Shift::NONE));
    compiler.finish(surface, volume, displacement)
}

struct Compiler<'g> {
    graph: &'g Graph,
    used: HashSet<(usize, &'g str)>,
    /// Results are virtual registers still.
    code: Vec<Instruction>,
    program: Program,
    constants: HashMap<[u32; 3], Operand>,
    /// Results of the nodes that have been lowered; `None` for nodes that are not known.
    lowered: HashMap<(usize, [u32; 2]), Option<Outputs>>,
    /// Nodes that are being lowered, outermost first.
    open: Vec<usize>,
    reports: Vec<Report>,
    scratch: Box<Registers>,
}

impl<'g> Compiler<'g> {
    fn new(graph: &'g Graph) -> Self {
        Self {
            graph,
            used: graph.used_outputs(),
            code: Vec::new(),
            program: Program::default(),
            constants: HashMap::new(),
            lowered: HashMap::new(),
            open: Vec::new(),
            reports: Vec::new(),
            scratch: Box::default(),
        }
    }

    fn report(&mut self, node: usize, what: impl Into<String>) {
        let node = &self.graph.nodes[node];
        let report = Report { node: node.name.clone(), kind: node.kind.clone(), what: what.into() };
        if !self.reports.contains(&report) {
            self.reports.push(report);
        }
    }

    /// The value of a link, converted to the kind that its reader wants. As in Cycles, a link from a node that is not known does not count:
    /// `None` where its reader has no value of its own.
    fn linked(&mut self, link: &Link, wanted: ValueKind, shift: Shift) -> Option<Operand> {
        let value = match self.output(link, shift) {
            LinkedOutput::Value(value) => value,
            LinkedOutput::Nothing => return Some(self.constant(Vec3A::ZERO)),
            LinkedOutput::Unknown => return link.unlinked.map(|parts| self.constant(Vec3A::from_array(parts))),
        };
        Some(match (value.kind, wanted) {
            (ValueKind::Colour, ValueKind::Number) => self.emit(Operation::Luminance, &[value.operand]),
            (ValueKind::Vector, ValueKind::Number) => self.emit(Operation::Mean, &[value.operand]),
            // Numbers stand in all three parts already.
            _ => value.operand,
        })
    }

    fn output(&mut self, link: &Link, shift: Shift) -> LinkedOutput {
        let key = (link.node, [shift.x.to_bits(), shift.y.to_bits()]);
        if !self.lowered.contains_key(&key) {
            if self.open.contains(&link.node) {
                self.report(link.node, "its output leads back into itself, it is black");
                return LinkedOutput::Nothing;
            }
            if self.open.len() >= DEEPEST {
                self.report(link.node, "too many nodes in a row, it is black");
                return LinkedOutput::Nothing;
            }
            self.open.push(link.node);
            let outputs = self.lower(link.node, shift);
            self.open.pop();
            self.lowered.insert(key, outputs);
        }
        let Some(outputs) = &self.lowered[&key] else { return LinkedOutput::Unknown };
        let found = outputs.iter().find(|(name, _)| *name == link.socket);
        found.map_or(LinkedOutput::Nothing, |(_, value)| LinkedOutput::Value(*value))
    }

    fn lower(&mut self, index: usize, shift: Shift) -> Option<Outputs> {
        let node = &self.graph.nodes[index];
        let mut at = At { compiler: self, index, node, shift };
        let lowered = inputs::lower(&mut at)
            .or_else(|| textures::lower(&mut at))
            .or_else(|| colours::lower(&mut at))
            .or_else(|| maths::lower(&mut at))
            .or_else(|| surfaces::lower(&mut at));
        let Some(lowered) = lowered else {
            self.report(index, "it is not supported, its links do not count");
            return None;
        };
        Some(lowered.unwrap_or_else(|what| {
            self.report(index, what);
            Outputs::new()
        }))
    }
}

/// A node while it is lowered: reads its inputs and emits its instructions.
struct At<'c, 'g> {
    compiler: &'c mut Compiler<'g>,
    index: usize,
    node: &'g Node,
    shift: Shift,
}

impl At<'_, '_> {
    fn input(&mut self, identifier: &str, wanted: ValueKind, shift: Shift) -> Option<Operand> {
        match self.node.input(identifier)? {
            Input::Constant(parts) => Some(self.compiler.constant(Vec3A::from_array(*parts))),
            Input::Link(link) => self.compiler.linked(link, wanted, shift),
        }
    }

    /// An input that is a number; 0 where Blender hides it.
    fn number(&mut self, identifier: &str) -> Operand {
        self.number_or(identifier, 0.0)
    }

    fn number_or(&mut self, identifier: &str, default: f32) -> Operand {
        match self.input(identifier, ValueKind::Number, self.shift) {
            Some(operand) => operand,
            None => self.constant(default),
        }
    }

    /// An input that is a vector or colour; 0 where Blender hides it.
    fn vector(&mut self, identifier: &str) -> Operand {
        match self.input(identifier, ValueKind::Vector, self.shift) {
            Some(operand) => operand,
            None => self.constant(0.0),
        }
    }

    /// A vector; where none is given, the one that the node takes from the surface.
    fn vector_or(&mut self, identifier: &str, default: impl FnOnce(&mut Self) -> Operand) -> Operand {
        match self.input(identifier, ValueKind::Vector, self.shift) {
            Some(operand) => operand,
            None => default(self),
        }
    }

    fn constant(&mut self, value: f32) -> Operand {
        self.compiler.constant(Vec3A::splat(value))
    }

    fn emit(&mut self, operation: Operation, operands: &[Operand]) -> Operand {
        self.compiler.emit(operation, operands)
    }

    fn emit_many<const N: usize>(&mut self, operation: Operation, operands: &[Operand]) -> (Operand, [Operand; N]) {
        self.compiler.emit_many(operation, operands)
    }

    /// A point through a matrix that the program keeps.
    fn affine(&mut self, map: Affine3A, point: Operand) -> Operand {
        let maps = &mut self.compiler.program.maps;
        let place = maps.iter().position(|other| *other == map).unwrap_or_else(|| {
            maps.push(map);
            maps.len() - 1
        });
        self.emit(Operation::Affine(place as u16), &[point])
    }

    /// True if something reads an output.
    fn is_used(&self, identifier: &str) -> bool {
        self.compiler.used.contains(&(self.index, identifier))
    }

    fn report(&mut self, what: &str) {
        self.compiler.report(self.index, what);
    }
}

fn number(identifier: &'static str, operand: Operand) -> (&'static str, Value) {
    (identifier, Value { kind: ValueKind::Number, operand })
}

fn vector(identifier: &'static str, operand: Operand) -> (&'static str, Value) {
    (identifier, Value { kind: ValueKind::Vector, operand })
}

fn colour(identifier: &'static str, operand: Operand) -> (&'static str, Value) {
    (identifier, Value { kind: ValueKind::Colour, operand })
}
