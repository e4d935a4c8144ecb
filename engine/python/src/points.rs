//! Point clouds from Python's arrays.

use crate::error::{Error, bad_scene};
use glam::{Vec3, Vec4};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use petzval_render::scene::points::PointsDescription;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The arguments of `SceneBuilder.add_points` beside points.
pub(crate) struct PointOptions<'py> {
    pub(crate) attributes: Option<Bound<'py, PyDict>>,
    pub(crate) moved_points: Option<[PyReadonlyArray2<'py, f32>; 2]>,
    pub(crate) poses: Option<Vec<PyReadonlyArray2<'py, f32>>>,
}

/// The engine's description of the points from Python.
pub(crate) fn description(
    name: &str,
    points: &PyReadonlyArray2<'_, f32>,
    more: PointOptions<'_>,
) -> Result<PointsDescription, Error> {
    let bad = |what: String| bad_scene(format!("points '{name}': {what}"));
    let rows = |array: &PyReadonlyArray2<'_, f32>, width: usize, what: &str| -> Result<Vec<f32>, Error> {
        if array.shape()[1] != width {
            return Err(bad(format!("{what} of shape {:?}; give {width} columns", array.shape())));
        }
        array.as_slice().map(<[f32]>::to_vec).map_err(|_| bad(format!("{what} are not contiguous")))
    };
    let fours = |array: &PyReadonlyArray2<'_, f32>, what: &str| -> Result<Vec<Vec4>, Error> {
        Ok(rows(array, 4, what)?.chunks_exact(4).map(Vec4::from_slice).collect())
    };
    let places = |array: &PyReadonlyArray2<'_, f32>| -> Result<Vec<Vec3>, Error> {
        Ok(rows(array, 3, "moved points")?.chunks_exact(3).map(Vec3::from_slice).collect())
    };
    let mut attributes = Vec::new();
    for (key, value) in more.attributes.iter().flatten() {
        attributes.push((key.extract()?, fours(&value.extract()?, "attributes")?));
    }
    Ok(PointsDescription {
        name: name.to_owned(),
        points: fours(points, "points")?,
        attributes,
        moved_points: match &more.moved_points {
            Some([before, after]) => Some([places(before)?, places(after)?]),
            None => None,
        },
        poses: more.poses.iter().flatten().map(|pose| fours(pose, "points over time")).collect::<Result<_, _>>()?,
    })
}
