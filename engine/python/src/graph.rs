//! Shader graphs at points given by hand.

use crate::error::{Error, bad_scene};
use crate::gil::without_gil;
use glam::{Affine3A, Mat3A, Vec3A, Vec4};
use numpy::{PyArray2, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods, ndarray::Array2};
use petzval_nodes::{Column, Graph, Layer, Operand, Pixels, Points, Program, Registers, compile};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// The values of a graph at each point.
#[pyfunction]
#[pyo3(signature = (graph_json, points, *, images = Vec::new(), world_to_object = None, world_to_camera = None))]
pub(crate) fn evaluate_graph<'py>(
    py: Python<'py>,
    graph_json: &str,
    points: BTreeMap<String, PyReadonlyArray2<'py, f32>>,
    images: Vec<PyReadonlyArray3<'py, f32>>,
    world_to_object: Option<PyReadonlyArray2<'py, f64>>,
    world_to_camera: Option<PyReadonlyArray2<'py, f64>>,
) -> Result<Bound<'py, PyDict>, Error> {
    let graph = Graph::from_json(graph_json)?;
    let (table, count) = read_points(&points, world_to_object.as_ref(), world_to_camera.as_ref())?;
    let images = images.iter().map(read_image).collect::<Result<Vec<_>, Error>>()?;
    let (program, reports, values) = without_gil(py, || {
        let (program, reports) = compile(&graph);
        let values = run(&program, &table, count, &images);
        (program, reports, values)
    })?;
    let answer = PyDict::new(py);
    let mut columns = values.into_iter();
    let mut next = || columns.next().map(|column| array(py, &column));
    for (name, layers) in [("surface", &program.surface), ("volume", &program.volume)] {
        let mut list = Vec::new();
        for layer in layers {
            let described = PyDict::new(py);
            described.set_item("kind", format!("{:?}", layer.kind))?;
            described.set_item("weight", next())?;
            let inputs = PyDict::new(py);
            for (identifier, _) in &layer.inputs {
                inputs.set_item(identifier, next())?;
            }
            described.set_item("inputs", inputs)?;
            described.set_item("options", layer.options.iter().cloned().collect::<BTreeMap<_, _>>())?;
            list.push(described);
        }
        answer.set_item(name, list)?;
    }
    answer.set_item("displacement", program.displacement.and_then(|_| next()))?;
    answer.set_item("reports", reports.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    answer.set_item("instructions", program.instructions())?;
    Ok(answer)
}

/// Everything that can be read after a run, in the order of the answer.
fn operands(program: &Program) -> Vec<Operand> {
    let of = |layer: &Layer| {
        let inputs = layer.inputs.iter().map(|(_, operand)| *operand);
        std::iter::once(layer.weight).chain(inputs).collect::<Vec<_>>()
    };
    program.surface.iter().chain(&program.volume).flat_map(of).chain(program.displacement).collect()
}

fn run(program: &Program, table: &Points, count: usize, images: &Vec<Pixels>) -> Vec<Vec<Vec3A>> {
    let operands = operands(program);
    let mut columns = vec![Vec::with_capacity(count); operands.len()];
    let mut registers = Registers::default();
    for number in 0..count {
        program.run(&table.point(number, &program.attributes), images, &mut registers);
        for (column, operand) in columns.iter_mut().zip(&operands) {
            column.push(program.value(*operand, &registers));
        }
    }
    columns
}

fn array<'py>(py: Python<'py>, values: &[Vec3A]) -> Bound<'py, PyArray2<f32>> {
    let array = Array2::from_shape_fn((values.len(), 3), |(row, column)| values[row][column]);
    PyArray2::from_owned_array(py, array)
}

fn read_points(
    given: &BTreeMap<String, PyReadonlyArray2<'_, f32>>,
    world_to_object: Option<&PyReadonlyArray2<'_, f64>>,
    world_to_camera: Option<&PyReadonlyArray2<'_, f64>>,
) -> Result<(Points, usize), Error> {
    let mut table = Points::default();
    let count = given.values().next().map_or(0, |values| values.shape()[0]);
    for (name, values) in given {
        if name.ends_with("/x") || name.ends_with("/y") {
            continue;
        }
        let along = |axis: &str| given.get(&format!("{name}/{axis}")).map_or(Ok(Vec::new()), |v| rows(name, v, count));
        let column = Column { values: rows(name, values, count)?, along_x: along("x")?, along_y: along("y")? };
        if !table.add(name, column) {
            return Err(bad_scene(format!("points: there is no field {name}")));
        }
    }
    table.world_to_object = world_to_object.map_or(Ok(Affine3A::IDENTITY), matrix)?;
    table.world_to_camera = world_to_camera.map_or(Ok(Affine3A::IDENTITY), matrix)?;
    Ok((table, count))
}

/// Rows of three or four numbers.
fn rows(name: &str, values: &PyReadonlyArray2<'_, f32>, count: usize) -> Result<Vec<Vec4>, Error> {
    let array = values.as_array();
    if array.nrows() != count || !matches!(array.ncols(), 3 | 4) {
        let shape = array.shape();
        return Err(bad_scene(format!("points: {name} has the shape {shape:?}; give ({count}, 3) or ({count}, 4)")));
    }
    let fourth = |row: usize| array.get((row, 3)).copied().unwrap_or(1.0);
    Ok((0..count).map(|row| Vec4::new(array[(row, 0)], array[(row, 1)], array[(row, 2)], fourth(row))).collect())
}

fn matrix(values: &PyReadonlyArray2<'_, f64>) -> Result<Affine3A, Error> {
    let array = values.as_array();
    if array.shape() != [4, 4] {
        return Err(bad_scene(format!("a matrix of shape {:?}; give (4, 4)", array.shape())));
    }
    let column = |j: usize| Vec3A::new(array[(0, j)] as f32, array[(1, j)] as f32, array[(2, j)] as f32);
    Ok(Affine3A { matrix3: Mat3A::from_cols(column(0), column(1), column(2)), translation: column(3) })
}

fn read_image(pixels: &PyReadonlyArray3<'_, f32>) -> Result<Pixels, Error> {
    let array = pixels.as_array();
    let invalid = || bad_scene(format!("an image of shape {:?}; give (height, width, 4)", pixels.shape()));
    let (height, width, 4) = array.dim() else { return Err(invalid()) };
    let pixel = |i: usize| Vec4::from_array(std::array::from_fn(|channel| array[(i / width, i % width, channel)]));
    Pixels::new(width, (0..width * height).map(pixel).collect()).ok_or_else(invalid)
}
