//! Vertex data from a mesh's edges.

use crate::error::{Error, bad_scene};
use crate::gil::without_gil;
use glam::Vec3;
use numpy::{PyArray1, PyReadonlyArray2};
use petzval_render::scene::edges;
use pyo3::prelude::*;

/// A number from 0 to 1 by vertex, the same for all that hang together.
#[pyfunction]
pub(crate) fn random_per_island<'py>(
    py: Python<'py>,
    vertices: usize,
    edges: PyReadonlyArray2<'py, i32>,
) -> Result<Bound<'py, PyArray1<f32>>, Error> {
    let edges = pairs(&edges, vertices)?;
    Ok(PyArray1::from_vec(py, without_gil(py, || edges::random_per_island(vertices, &edges))?))
}

/// Pointiness of a mesh at each vertex.
#[pyfunction]
pub(crate) fn pointiness<'py>(
    py: Python<'py>,
    positions: PyReadonlyArray2<'py, f32>,
    normals: PyReadonlyArray2<'py, f32>,
    edges: PyReadonlyArray2<'py, i32>,
) -> Result<Bound<'py, PyArray1<f32>>, Error> {
    let (positions, normals) = (vectors(&positions)?, vectors(&normals)?);
    if positions.len() != normals.len() {
        return Err(bad_scene(format!("{} positions, but {} normals", positions.len(), normals.len())));
    }
    let edges = pairs(&edges, positions.len())?;
    Ok(PyArray1::from_vec(py, without_gil(py, || edges::pointiness(&positions, &normals, &edges))?))
}

fn vectors(values: &PyReadonlyArray2<'_, f32>) -> Result<Vec<Vec3>, Error> {
    let values = values.as_slice().map_err(|_| bad_scene("vectors are not contiguous".to_owned()))?;
    Ok(values.chunks_exact(3).map(Vec3::from_slice).collect())
}

/// The vertices of each edge, as far as there are such.
fn pairs(edges: &PyReadonlyArray2<'_, i32>, vertices: usize) -> Result<Vec<[u32; 2]>, Error> {
    let values = edges.as_slice().map_err(|_| bad_scene("edges are not contiguous".to_owned()))?;
    // A negative index becomes one past every vertex.
    let edges: Vec<[u32; 2]> = values.chunks_exact(2).map(|pair| [pair[0] as u32, pair[1] as u32]).collect();
    match edges.iter().flatten().find(|&&vertex| vertex as usize >= vertices) {
        Some(vertex) => Err(bad_scene(format!("an edge leads to vertex {vertex}; there are {vertices}"))),
        None => Ok(edges),
    }
}
