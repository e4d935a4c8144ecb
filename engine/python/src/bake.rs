//! The description of a bake, from Python.

use crate::described::Described;
use crate::error::{Error, invalid};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use petzval_render::job::bake::{BakeRequest, BakeSettings, BakeTable};

/// Settings; triangles, weights and differentials of the pixels; numbers by which pixels choose their random numbers.
pub(crate) type PyBake<'py> = (
    Described<BakeSettings>,
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray2<'py, f32>,
    PyReadonlyArray2<'py, f32>,
    Option<PyReadonlyArray1<'py, u32>>,
);

/// The engine's request.
pub(crate) fn request((settings, triangles, weights, differentials, seeds): PyBake<'_>) -> Result<BakeRequest, Error> {
    let bad = || invalid("the points of a bake: give contiguous arrays (pixels), (pixels, 2) and (pixels, 4)");
    let table = BakeTable {
        primitives: triangles.as_slice().map_err(|_| bad())?.to_vec(),
        weights: rows(&weights).ok_or_else(bad)?,
        differentials: rows(&differentials).ok_or_else(bad)?,
        seeds: match &seeds {
            Some(seeds) => seeds.as_slice().map_err(|_| bad())?.to_vec(),
            None => Vec::new(),
        },
    };
    Ok(BakeRequest { settings: settings.0, table })
}

fn rows<const N: usize>(array: &PyReadonlyArray2<'_, f32>) -> Option<Vec<[f32; N]>> {
    let (rows, rest) = array.as_slice().ok()?.as_chunks();
    (rest.is_empty() && array.as_array().ncols() == N).then(|| rows.to_vec())
}
