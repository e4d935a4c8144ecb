//! Meshes from Python's arrays, each copied once.

use crate::camera::Matrix4;
use crate::error::{Error, bad_scene};
use glam::{Affine3A, DMat4, Vec2, Vec3, Vec4};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray4, PyUntypedArrayMethods};
use petzval_render::scene::corners::{Corners, Named};
use petzval_render::scene::grid::Grid;
use petzval_render::scene::motion::Poses;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The domain of values ("POINT", "CORNER": of faces, "TRIANGLE"), and these, one a row.
pub(crate) type PyCorners<'py> = (String, PyReadonlyArray2<'py, f32>);

/// A mesh's vertices at a key, and the normals of its corners, if they are given.
pub(crate) type PyPose<'py> = (PyReadonlyArray2<'py, f32>, Option<PyCorners<'py>>);

/// A grid's name; its values by z, y, x and channel; and the matrix from its voxels to the object's space.
pub(crate) type PyGrid<'py> = (String, PyReadonlyArray4<'py, f32>, Matrix4);

/// A row of numbers.
pub(crate) trait Row: Copy {
    const LENGTH: usize;
    fn of(row: &[f32]) -> Self;
}

macro_rules! row {
    ($vector:ty, $length:literal) => {
        impl Row for $vector {
            const LENGTH: usize = $length;
            fn of(row: &[f32]) -> Self {
                Self::from_slice(row)
            }
        }
    };
}
row!(Vec2, 2);
row!(Vec3, 3);
row!(Vec4, 4);

/// Reads one vector from each row; `None` where the rows have another length, or do not lie one after the other.
pub(crate) fn vectors<T: Row>(array: &PyReadonlyArray2<'_, f32>) -> Option<Vec<T>> {
    let values = array.as_slice().ok().filter(|_| array.shape()[1] == T::LENGTH)?;
    Some(values.chunks_exact(T::LENGTH).map(T::of).collect())
}

/// Reads vertex indices, three for each triangle.
pub(crate) fn indices(array: &Bound<'_, PyAny>) -> Result<Vec<[u32; 3]>, &'static str> {
    const NOT_CONTIGUOUS: &str = "not contiguous";
    fn threes<T: Copy>(list: &[T], of: impl Fn(T) -> u32) -> Vec<[u32; 3]> {
        list.chunks_exact(3).map(|t| [of(t[0]), of(t[1]), of(t[2])]).collect()
    }
    if let Ok(a) = array.cast::<PyArrayDyn<u32>>() {
        Ok(threes(a.readonly().as_slice().map_err(|_| NOT_CONTIGUOUS)?, |i| i))
    } else if let Ok(a) = array.cast::<PyArrayDyn<i32>>() {
        // A negative index becomes one past every vertex, which a mesh's own check names.
        Ok(threes(a.readonly().as_slice().map_err(|_| NOT_CONTIGUOUS)?, |i| i as u32))
    } else {
        Err("give an int32 or uint32 array")
    }
}

/// The values of an array by the domain that they belong to.
pub(crate) fn corners<T: Row>((domain, array): &PyCorners<'_>) -> Result<Corners<T>, String> {
    let values = vectors(array)
        .ok_or_else(|| format!("give contiguous rows of {} numbers, not {:?}", T::LENGTH, array.shape()))?;
    match domain.as_str() {
        "POINT" => Ok(Corners::Vertices(values)),
        "CORNER" => Ok(Corners::Loops(values)),
        "TRIANGLE" => Ok(Corners::Triangles(values)),
        other => Err(format!("belong to '{other}', not to POINT, CORNER or TRIANGLE")),
    }
}

/// The arrays of a dictionary by name.
pub(crate) fn named<T: Row>(dict: Option<&Bound<'_, PyDict>>) -> Result<Vec<Named<T>>, String> {
    let mut found = Vec::new();
    for (key, value) in dict.into_iter().flatten() {
        let name: String = key.extract().map_err(|_| "names are strings".to_owned())?;
        let values: PyCorners<'_> = value.extract().map_err(|error| format!("'{name}': {error}"))?;
        let values = corners(&values).map_err(|why| format!("'{name}': {why}"))?;
        found.push((name, values));
    }
    Ok(found)
}

pub(crate) fn read_poses(keys: &[PyPose<'_>]) -> Result<Poses, String> {
    let positions = keys.iter().map(|(positions, _)| vectors(positions)).collect::<Option<_>>();
    let normals = keys.iter().map(|(_, normals)| normals.as_ref().map(corners)).collect::<Option<Result<_, _>>>();
    Ok(Poses { positions: positions.ok_or("positions are not contiguous")?, corner_normals: normals.transpose()? })
}

pub(crate) fn read_grid((grid, values, to_object): PyGrid<'_>, mesh: &str) -> Result<Grid, Error> {
    let bad = |what: &str| bad_scene(format!("mesh '{mesh}': grid '{grid}': {what}"));
    let to_object: DMat4 = to_object.into();
    let to_voxels = to_object.inverse();
    if !to_voxels.is_finite() {
        return Err(bad("its matrix is not finite or has no inverse"));
    }
    let &[z, y, x, channels] = values.shape() else { return Err(bad("give four axes: z, y, x and channel")) };
    let values = values.as_slice().map_err(|_| bad("its values are not contiguous"))?.to_vec();
    let to_voxels = Affine3A::from_mat4(to_voxels.as_mat4());
    Ok(Grid { name: grid.clone(), size: [x, y, z], channels, values, to_voxels })
}
