//! A shader graph as the add-on sends it: a flat list of nodes, groups and reroutes already followed.

use crate::choice::Choice;
use serde_json::{Map, Value};
use std::collections::HashSet;

/// An error by which a graph's description could not be read at all.
#[derive(Debug, thiserror::Error)]
pub enum Parsing {
    /// The text is no JSON.
    #[error("the graph is not JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A part of the graph is missing or has another type than it must.
    #[error("the graph's {0}")]
    Shape(String),
}

/// The output of a node that an input reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Index of the node in [`Graph::nodes`].
    pub node: usize,
    /// The output socket's identifier.
    pub socket: String,
    /// The value if the node is not known: the reading socket's own value, or none, as where nothing is linked.
    pub unlinked: Option<[f32; 3]>,
}

/// The value of an input.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// A value that stands still; a number stands in all three parts.
    Constant([f32; 3]),
    /// The output of another node.
    Link(Link),
}

/// One node of a material, as Blender describes it.
#[derive(Clone, Debug)]
pub struct Node {
    /// Blender's `bl_idname`, such as `ShaderNodeTexNoise`.
    pub kind: String,
    /// The user's name for the node, for messages.
    pub name: String,
    /// Inputs by socket identifier. One that is absent has the node's own default, such as the surface's normal.
    pub inputs: Vec<(String, Input)>,
    options: Map<String, Value>,
}

/// All nodes of a material, and the links of its outputs.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// The nodes, in any order.
    pub nodes: Vec<Node>,
    /// Link to the surface's closure.
    pub surface: Option<Link>,
    /// Link to the volume's closure.
    pub volume: Option<Link>,
    /// Link to the displacement of the surface.
    pub displacement: Option<Link>,
}

fn shape(what: impl Into<String>) -> Parsing {
    // Names of nodes and sockets may hold line ends; a message has one line.
    Parsing::Shape(what.into().chars().map(|c| if c.is_control() { ' ' } else { c }).collect())
}

impl Graph {
    /// Reads the add-on's description:
    /// `{"nodes": [{"type", "name", "options": {...}, "inputs": {identifier: number | [numbers] | link}}],
    /// "surface": link | null, "volume": ..., "displacement": ...}`, a link being `{"node", "socket", "unlinked": number | [numbers]}`,
    /// the last where there is one.
    pub fn from_json(text: &str) -> Result<Self, Parsing> {
        let document: Value = serde_json::from_str(text)?;
        let nodes = document["nodes"].as_array().ok_or_else(|| shape("\"nodes\" are no list"))?;
        let nodes = nodes.iter().enumerate().map(|(i, node)| Node::read(i, node)).collect::<Result<Vec<_>, _>>()?;
        let end = |name: &str| match &document[name] {
            Value::Null => Ok(None),
            link => read_link(link).map(Some).ok_or_else(|| shape(format!("\"{name}\" is no link"))),
        };
        let graph =
            Self { surface: end("surface")?, volume: end("volume")?, displacement: end("displacement")?, nodes };
        let stray = graph.links().map(|link| link.node).find(|node| *node >= graph.nodes.len());
        stray.map_or(Ok(graph), |node| Err(shape(format!("node {node} does not exist"))))
    }

    fn links(&self) -> impl Iterator<Item = &Link> {
        let inside = self.nodes.iter().flat_map(|node| &node.inputs).filter_map(|(_, input)| match input {
            Input::Link(link) => Some(link),
            Input::Constant(_) => None,
        });
        inside.chain(&self.surface).chain(&self.volume).chain(&self.displacement)
    }

    /// The outputs that something reads.
    pub(crate) fn used_outputs(&self) -> HashSet<(usize, &str)> {
        self.links().map(|link| (link.node, link.socket.as_str())).collect()
    }
}

fn read_link(value: &Value) -> Option<Link> {
    let node = usize::try_from(value["node"].as_u64()?).ok()?;
    Some(Link { node, socket: value["socket"].as_str()?.to_owned(), unlinked: read_constant(&value["unlinked"]) })
}

fn read_constant(value: &Value) -> Option<[f32; 3]> {
    if let Some(truth) = value.as_bool() {
        return Some([f32::from(u8::from(truth)); 3]);
    }
    if let Some(number) = value.as_f64() {
        return Some([number as f32; 3]);
    }
    let parts = value.as_array()?;
    let part = |i: usize| parts.get(i).map_or(Some(0.0), Value::as_f64).map(|number| number as f32);
    Some([part(0)?, part(1)?, part(2)?])
}

impl Node {
    fn read(number: usize, node: &Value) -> Result<Self, Parsing> {
        let kind = node["type"].as_str().ok_or_else(|| shape(format!("node {number} has no type")))?.to_owned();
        let name = node["name"].as_str().unwrap_or(&kind).to_owned();
        let options = node["options"].as_object().cloned().unwrap_or_default();
        let mut inputs = Vec::new();
        for (identifier, value) in node["inputs"].as_object().into_iter().flatten() {
            let input = match read_link(value) {
                Some(link) => Input::Link(link),
                None => Input::Constant(read_constant(value).ok_or_else(|| {
                    shape(format!("node {name}: {identifier} is neither a number, a list of them, nor a link"))
                })?),
            };
            inputs.push((identifier.clone(), input));
        }
        Ok(Self { kind, name, inputs, options })
    }

    /// An input by its socket's identifier.
    pub fn input(&self, identifier: &str) -> Option<&Input> {
        self.inputs.iter().find(|(name, _)| name == identifier).map(|(_, input)| input)
    }

    /// An option that is a word.
    pub fn word(&self, option: &str) -> Option<&str> {
        self.options.get(option)?.as_str()
    }

    /// The options that are words.
    pub(crate) fn words(&self) -> impl Iterator<Item = (&String, &str)> {
        self.options.iter().filter_map(|(name, value)| Some((name, value.as_str()?)))
    }

    /// An option that is one of a list; absent, the one that Blender gives a new node.
    pub(crate) fn choice<C: Choice>(&self, option: &str, default: C) -> Result<C, String> {
        match self.options.get(option) {
            None | Some(Value::Null) => Ok(default),
            Some(value) => {
                value.as_str().and_then(C::named).ok_or_else(|| format!("{option} {value} is not supported"))
            }
        }
    }

    pub(crate) fn truth(&self, option: &str, default: bool) -> bool {
        self.options.get(option).and_then(Value::as_bool).unwrap_or(default)
    }

    pub(crate) fn number(&self, option: &str, default: f32) -> f32 {
        self.options.get(option).and_then(Value::as_f64).map_or(default, |number| number as f32)
    }

    pub(crate) fn count(&self, option: &str) -> Option<u16> {
        u16::try_from(self.options.get(option)?.as_u64()?).ok()
    }

    /// A list of numbers, lists within it laid end to end.
    pub(crate) fn numbers(&self, option: &str) -> Option<Vec<f32>> {
        fn gather(value: &Value, into: &mut Vec<f32>) -> Option<()> {
            match value.as_array() {
                Some(parts) => parts.iter().try_for_each(|part| gather(part, into)),
                None => {
                    into.push(value.as_f64()? as f32);
                    Some(())
                }
            }
        }
        let mut numbers = Vec::new();
        gather(self.options.get(option)?, &mut numbers)?;
        Some(numbers)
    }
}
