//! Curves from Python's arrays.

use crate::error::{Error, bad_scene};
use glam::{Vec2, Vec3, Vec4};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use petzval_render::scene::curves::{CurveShape, CurvesDescription, StrandValues};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The arguments of `SceneBuilder.add_curves` beside keys and strands.
pub(crate) struct CurveOptions<'py> {
    pub(crate) shape: String,
    pub(crate) pieces: u16,
    pub(crate) first_number: u32,
    pub(crate) uv_maps: Option<Bound<'py, PyDict>>,
    pub(crate) attributes: Option<Bound<'py, PyDict>>,
    pub(crate) moved_keys: Option<[PyReadonlyArray2<'py, f32>; 2]>,
    pub(crate) poses: Option<Vec<PyReadonlyArray2<'py, f32>>>,
}

/// The engine's description of the curves from Python.
pub(crate) fn description(
    name: &str,
    keys: &PyReadonlyArray2<'_, f32>,
    first_keys: &PyReadonlyArray1<'_, i32>,
    more: CurveOptions<'_>,
) -> Result<CurvesDescription, Error> {
    let bad = |what: String| bad_scene(format!("curves '{name}': {what}"));
    let shape = match more.shape.as_str() {
        "RIBBON" => CurveShape::Ribbon { pieces: more.pieces },
        "THICK" => CurveShape::Thick,
        "THICK_LINEAR" => CurveShape::ThickLinear,
        other => return Err(bad(format!("shape '{other}'; give RIBBON, THICK or THICK_LINEAR"))),
    };
    let rows = |array: &PyReadonlyArray2<'_, f32>, width: usize, what: &str| -> Result<Vec<f32>, Error> {
        if array.shape()[1] != width {
            return Err(bad(format!("{what} of shape {:?}; give {width} columns", array.shape())));
        }
        array.as_slice().map(<[f32]>::to_vec).map_err(|_| bad(format!("{what} are not contiguous")))
    };
    let fours = |array: &PyReadonlyArray2<'_, f32>, what: &str| -> Result<Vec<Vec4>, Error> {
        Ok(rows(array, 4, what)?.chunks_exact(4).map(Vec4::from_slice).collect())
    };
    let first_keys = first_keys.as_slice().map_err(|_| bad("strands are not contiguous".into()))?;
    let mut uv_maps = Vec::new();
    for (key, value) in more.uv_maps.iter().flatten() {
        let values = rows(&value.extract()?, 2, "UV maps")?;
        uv_maps.push((key.extract()?, values.chunks_exact(2).map(Vec2::from_slice).collect()));
    }
    let mut attributes = Vec::new();
    for (key, value) in more.attributes.iter().flatten() {
        let (is_by_key, values): (bool, PyReadonlyArray2<'_, f32>) = value.extract()?;
        let values = fours(&values, "attributes")?;
        let values = if is_by_key { StrandValues::ByKey(values) } else { StrandValues::ByStrand(values) };
        attributes.push((key.extract()?, values));
    }
    let moved_keys = match &more.moved_keys {
        Some([before, after]) => {
            let places = |array: &PyReadonlyArray2<'_, f32>| -> Result<Vec<Vec3>, Error> {
                Ok(rows(array, 3, "moved keys")?.chunks_exact(3).map(Vec3::from_slice).collect())
            };
            Some([places(before)?, places(after)?])
        }
        None => None,
    };
    Ok(CurvesDescription {
        name: name.to_owned(),
        keys: fours(keys, "keys")?,
        // A negative index becomes one past every key, which the engine names.
        first_keys: first_keys.iter().map(|&key| key as u32).collect(),
        shape,
        first_number: more.first_number,
        uv_maps,
        attributes,
        moved_keys,
        poses: more.poses.iter().flatten().map(|pose| fours(pose, "keys over time")).collect::<Result<_, _>>()?,
    })
}
