//! The shader graphs of a scene, each compiled once, however many materials and lamps show it.

use crate::error::Error;
use petzval_nodes::Graph as ShaderGraph;
use petzval_render::nodes::{OF_MATERIALS, OF_WORLDS};
use petzval_render::scene::graph::{Displacement, Graph};
use std::collections::HashMap;
use std::sync::Arc;

/// A graph, and warnings of parts that the engine does otherwise than Blender.
type Compiled = (Arc<Graph>, Vec<String>);

/// A graph's text, and the other inputs of its compiled form.
#[derive(PartialEq, Eq, Hash)]
struct CompiledFrom {
    json: String,
    pass_index: i32,
    displacement: Displacement,
    /// True of a world, which answers other fields than a material does.
    is_world: bool,
}

/// Compiled graphs by their sources.
#[derive(Default)]
pub(crate) struct Graphs {
    known: HashMap<CompiledFrom, Compiled>,
}

impl Graphs {
    /// The graph of a material's text, and its warnings, which name `owner`.
    pub(crate) fn read(
        &mut self,
        json: String,
        pass_index: i32,
        displacement: Displacement,
        owner: &str,
    ) -> Result<(Arc<Graph>, Vec<String>), Error> {
        self.compiled(CompiledFrom { json, pass_index, displacement, is_world: false }, owner)
    }

    /// The graph of a lamp's text, if there is one, and its warnings, which name `owner`.
    pub(crate) fn of_lamp(
        &mut self,
        json: Option<String>,
        owner: &str,
    ) -> Result<(Option<Arc<Graph>>, Vec<String>), Error> {
        let Some(json) = json else { return Ok((None, Vec::new())) };
        let (graph, reports) = self.read(json, 0, Displacement::default(), owner)?;
        Ok((Some(graph), reports))
    }

    /// The graph of a world's text, if there is one, and its warnings.
    pub(crate) fn of_world(&mut self, json: Option<String>) -> Result<(Option<Arc<Graph>>, Vec<String>), Error> {
        let Some(json) = json else { return Ok((None, Vec::new())) };
        let from = CompiledFrom { json, pass_index: 0, displacement: Displacement::default(), is_world: true };
        let (graph, reports) = self.compiled(from, "World")?;
        Ok((Some(graph), reports))
    }

    fn compiled(&mut self, from: CompiledFrom, owner: &str) -> Result<(Arc<Graph>, Vec<String>), Error> {
        let (graph, reports) = match self.known.get(&from) {
            Some(known) => known,
            None => {
                let made = compiled(&from)?;
                self.known.entry(from).or_insert(made)
            }
        };
        Ok((graph.clone(), reports.iter().map(|what| format!("{owner}: {what}")).collect()))
    }

    /// Drops those that nothing shows any more.
    pub(crate) fn forget_unused(&mut self) {
        self.known.retain(|_, (graph, _)| Arc::strong_count(graph) > 1);
    }
}

fn compiled(from: &CompiledFrom) -> Result<Compiled, Error> {
    let answered = if from.is_world { OF_WORLDS } else { OF_MATERIALS };
    let (mut graph, reports) = Graph::of(&ShaderGraph::from_json(&from.json)?, from.pass_index, answered);
    graph.displacement = from.displacement;
    Ok((Arc::new(graph), reports))
}
