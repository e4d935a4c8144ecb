//! The shader graphs of a scene, each compiled once, however many materials and lamps show it.

use crate::error::Error;
use petzval_nodes::Graph as ShaderGraph;
use petzval_render::scene::graph::{Displacement, Graph};
use std::collections::HashMap;
use std::sync::Arc;

/// A graph, and what of it the engine does otherwise than Blender.
type Compiled = (Arc<Graph>, Vec<String>);

/// Compiled graphs by a graph's text, and the pass index and displacement of its material.
#[derive(Default)]
pub(crate) struct Graphs {
    known: HashMap<(String, i32, Displacement), Compiled>,
}

impl Graphs {
    /// The graph of a text, and what to say of it to `owner`.
    pub(crate) fn read(
        &mut self,
        json: String,
        pass_index: i32,
        displacement: Displacement,
        owner: &str,
    ) -> Result<(Arc<Graph>, Vec<String>), Error> {
        let key = (json, pass_index, displacement);
        let (graph, reports) = match self.known.get(&key) {
            Some(known) => known,
            None => {
                let made = compiled(&key.0, pass_index, displacement)?;
                self.known.entry(key).or_insert(made)
            }
        };
        Ok((graph.clone(), reports.iter().map(|what| format!("{owner}: {what}")).collect()))
    }

    /// [`Self::read`] of the text of a lamp or a world, if there is one.
    pub(crate) fn read_some(
        &mut self,
        json: Option<String>,
        owner: &str,
    ) -> Result<(Option<Arc<Graph>>, Vec<String>), Error> {
        let Some(json) = json else { return Ok((None, Vec::new())) };
        let (graph, reports) = self.read(json, 0, Displacement::default(), owner)?;
        Ok((Some(graph), reports))
    }

    /// Drops those that nothing shows any more.
    pub(crate) fn forget_unused(&mut self) {
        self.known.retain(|_, (graph, _)| Arc::strong_count(graph) > 1);
    }
}

fn compiled(json: &str, pass_index: i32, displacement: Displacement) -> Result<Compiled, Error> {
    let (mut graph, reports) = Graph::of(&ShaderGraph::from_json(json)?, pass_index);
    graph.displacement = displacement;
    Ok((Arc::new(graph), reports))
}
