//! Scenes from Python's arrays.

use crate::camera::Matrix4;
use crate::compiled::Graphs;
use crate::curves::{CurveOptions, description};
use crate::described::Described;
use crate::error::{Error, bad_scene, invalid};
use crate::gil::without_gil;
use crate::material::{PyLight, PyMaterial, PyWorld, visible};
use crate::mesh::{PyCorners, PyGrid, PyPose, corners, indices, named, read_grid, read_poses, vectors};
use crate::points;
use glam::{DMat4, DVec3};
use numpy::ndarray::ArrayView2;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use petzval_render::integrator::PreparedScene;
use petzval_render::projection::Panorama;
use petzval_render::scene::mesh::{Dicing, EdgeLength, MeshDescription};
use petzval_render::scene::shadow_terminator::ShadowTerminator;
use petzval_render::scene::texture::Texture;
use petzval_render::scene::viewport::{ViewportDescription, ViewportProjection};
use petzval_render::scene::visibility::{LightLinking, LightSets};
use petzval_render::scene::{self as engine, ObjectInfo};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::array;
use std::sync::Arc;

/// Colour, pass index, random number.
type PyObjectInfo = ((f32, f32, f32, f32), i32, f32);

/// Matrices, row by row, and random numbers of instances.
type PyPlaces<'py> = (PyReadonlyArray3<'py, f64>, PyReadonlyArray1<'py, f32>);

/// Takes a scene apart from Python, piece by piece.
#[pyclass]
#[derive(Default)]
pub(crate) struct SceneBuilder {
    builder: engine::SceneBuilder,
    graphs: Graphs,
}

/// A built scene; cheap to share between renders.
#[pyclass(frozen)]
pub(crate) struct Scene {
    pub(crate) stage: Arc<PreparedScene>,
}

/// A scene without its trees.
#[pyclass]
pub(crate) struct SceneDraft {
    scene: Option<engine::Scene>,
}

#[pymethods]
impl SceneBuilder {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    #[pyo3(signature = (name, pixels, *, srgb))]
    fn add_image(&mut self, py: Python<'_>, name: &str, pixels: &Bound<'_, PyAny>, srgb: bool) -> Result<usize, Error> {
        let shape = |s: &[usize]| match s {
            [h, w, 4] => Ok((*w, *h)),
            other => Err(bad_scene(format!("image '{name}': pixels of shape {other:?}; give (height, width, 4)"))),
        };
        let not_contiguous = |_| bad_scene(format!("image '{name}': its pixel array is not contiguous"));
        let texture = if let Ok(array) = pixels.cast::<PyArrayDyn<f32>>() {
            let (w, h) = shape(array.shape())?;
            let array = array.readonly();
            let values = array.as_slice().map_err(not_contiguous)?;
            without_gil(py, || Texture::from_floats(name, w, h, values, srgb))??
        } else if let Ok(array) = pixels.cast::<PyArrayDyn<u8>>() {
            let (w, h) = shape(array.shape())?;
            let array = array.readonly();
            let values = array.as_slice().map_err(not_contiguous)?;
            without_gil(py, || Texture::from_bytes(name, w, h, values, srgb))??
        } else {
            return Err(bad_scene(format!("image '{name}': give its pixels as a float32 or uint8 array")));
        };
        Ok(self.builder.add_texture(texture))
    }

    fn add_tiles(&mut self, name: &str, tiles: Vec<(u32, usize)>) -> Result<usize, Error> {
        Ok(self.builder.add_tiles(name, &tiles)?)
    }

    fn add_material(&mut self, material: PyMaterial) -> Result<usize, Error> {
        let (material, reports) = material.material(&mut self.graphs)?;
        reports.into_iter().for_each(|report| self.builder.warn(report));
        Ok(self.builder.add_material(material))
    }

    #[pyo3(signature = (
        name, positions, triangles, *, loops = None, corner_normals = None, uv_maps = None, attributes = None,
        material_slots = None, moved_positions = None, poses = None, grids = None, keeps_opacity = false,
        dicing = None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn add_mesh<'py>(
        &mut self,
        py: Python<'py>,
        name: &str,
        positions: PyReadonlyArray2<'py, f32>,
        triangles: &Bound<'py, PyAny>,
        loops: Option<&Bound<'py, PyAny>>,
        corner_normals: Option<PyCorners<'py>>,
        uv_maps: Option<&Bound<'py, PyDict>>,
        attributes: Option<&Bound<'py, PyDict>>,
        material_slots: Option<PyReadonlyArray1<'py, i32>>,
        moved_positions: Option<[PyReadonlyArray2<'py, f32>; 2]>,
        poses: Option<Vec<PyPose<'py>>>,
        grids: Option<Vec<PyGrid<'py>>>,
        keeps_opacity: bool,
        dicing: Option<(bool, f32, f32, u32, u32)>,
    ) -> Result<usize, Error> {
        let bad = |what: &str| bad_scene(format!("mesh '{name}': {what}"));
        let description = MeshDescription {
            name: name.to_owned(),
            positions: vectors(&positions).ok_or_else(|| bad("positions are not contiguous (vertices, 3)"))?,
            triangles: indices(triangles).map_err(|why| bad(&format!("its triangles: {why}")))?,
            loops: match loops {
                Some(loops) => indices(loops).map_err(|why| bad(&format!("the corners of its faces: {why}")))?,
                None => Vec::new(),
            },
            corner_normals: match &corner_normals {
                Some(values) => Some(corners(values).map_err(|why| bad(&format!("corner normals: {why}")))?),
                None => None,
            },
            uv_maps: named(uv_maps).map_err(|why| bad(&format!("UV map {why}")))?,
            attributes: named(attributes).map_err(|why| bad(&format!("attribute {why}")))?,
            material_slots: match &material_slots {
                Some(a) => {
                    let list = a.as_slice().map_err(|_| bad("material slots are not contiguous"))?;
                    Some(list.iter().map(|&s| s.max(0) as u32).collect())
                }
                None => None,
            },
            moved_positions: match &moved_positions {
                Some([before, after]) => {
                    let read = |a| vectors(a).ok_or_else(|| bad("moved positions are not contiguous"));
                    Some([read(before)?, read(after)?])
                }
                None => None,
            },
            poses: match &poses {
                Some(keys) => Some(read_poses(keys).map_err(|why| bad(&format!("its shapes over time: {why}")))?),
                None => None,
            },
            grids: grids.into_iter().flatten().map(|grid| read_grid(grid, name)).collect::<Result<_, _>>()?,
            keeps_opacity,
            dicing: dicing.map(|(is_pixels, length, off_screen, halvings, room)| Dicing {
                edge: if is_pixels { EdgeLength::Pixels(length) } else { EdgeLength::Units(length) },
                off_screen,
                halvings,
                room: room as usize,
            }),
        };
        let builder = &mut self.builder;
        Ok(without_gil(py, || builder.add_mesh(description))??)
    }

    #[pyo3(signature = (
        name, keys, first_keys, shape, *, pieces = 1, first_number = 0, uv_maps = None, attributes = None, moved_keys = None,
        poses = None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn add_curves<'py>(
        &mut self,
        py: Python<'py>,
        name: &str,
        keys: PyReadonlyArray2<'py, f32>,
        first_keys: PyReadonlyArray1<'py, i32>,
        shape: String,
        pieces: u16,
        first_number: u32,
        uv_maps: Option<Bound<'py, PyDict>>,
        attributes: Option<Bound<'py, PyDict>>,
        moved_keys: Option<[PyReadonlyArray2<'py, f32>; 2]>,
        poses: Option<Vec<PyReadonlyArray2<'py, f32>>>,
    ) -> Result<usize, Error> {
        let more = CurveOptions { shape, pieces, first_number, uv_maps, attributes, moved_keys, poses };
        let description = description(name, &keys, &first_keys, more)?;
        let builder = &mut self.builder;
        Ok(without_gil(py, || builder.add_curves(description))??)
    }

    #[pyo3(signature = (name, points, *, attributes = None, moved_points = None, poses = None))]
    fn add_points<'py>(
        &mut self,
        py: Python<'py>,
        name: &str,
        points: PyReadonlyArray2<'py, f32>,
        attributes: Option<Bound<'py, PyDict>>,
        moved_points: Option<[PyReadonlyArray2<'py, f32>; 2]>,
        poses: Option<Vec<PyReadonlyArray2<'py, f32>>>,
    ) -> Result<usize, Error> {
        let description = points::description(name, &points, points::PointOptions { attributes, moved_points, poses })?;
        let builder = &mut self.builder;
        Ok(without_gil(py, || builder.add_points(description))??)
    }

    #[pyo3(signature = (
        object_name, mesh, matrix_world, materials, *, hidden_from = Vec::new(), links = None, asset_name = None,
        moved = None, keys = None, info = None, light_group = 0, shadow_terminator = (0.0, 0.0), is_holdout = false,
        is_catcher = false, is_baked = false, occlusion_distance = 0.0, others = None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn add_instance(
        &mut self,
        object_name: &str,
        mesh: usize,
        matrix_world: Matrix4,
        materials: Vec<usize>,
        hidden_from: Vec<String>,
        links: Option<(u64, u64, u8, u8)>,
        asset_name: Option<&str>,
        moved: Option<[Matrix4; 2]>,
        keys: Option<Vec<Matrix4>>,
        info: Option<PyObjectInfo>,
        light_group: u16,
        shadow_terminator: (f32, f32),
        is_holdout: bool,
        is_catcher: bool,
        is_baked: bool,
        occlusion_distance: f32,
        others: Option<PyPlaces<'_>>,
    ) -> Result<(), Error> {
        let mut places = vec![(matrix_world.into(), info.map_or(0.0, |(_, _, random)| random))];
        if let Some((matrices, randoms)) = others {
            let (matrices, randoms) = (matrices.as_array(), randoms.as_array());
            if matrices.shape() != [randoms.len(), 4, 4] {
                return Err(invalid(format!(
                    "object '{object_name}': {} random numbers for matrices of shape {:?}",
                    randoms.len(),
                    matrices.shape()
                )));
            }
            let placed = matrices.outer_iter().zip(&randoms);
            let by_rows =
                |m: ArrayView2<'_, f64>| DMat4::from_cols_array_2d(&array::from_fn(|c| array::from_fn(|r| m[[r, c]])));
            places.extend(placed.map(|(matrix, &random)| (by_rows(matrix), random)));
        }
        let (visible, moved) = (visible(&hidden_from, object_name)?, moved.map(|both| both.map(Into::into)));
        let keys: Option<Vec<DMat4>> = keys.map(|keys| keys.into_iter().map(Into::into).collect());
        for (matrix, random) in places {
            let Some(instance) = self.builder.add_instance(object_name, mesh, matrix, &materials, true, true)? else {
                continue;
            };
            self.builder.set_visible(instance, visible);
            if let Some((receives, blocks, receivers, blockers)) = links {
                let sets = LightSets { receivers: receivers & 63, blockers: blockers & 63 };
                self.builder.set_links(instance, LightLinking { receives, blocks, sets });
            }
            self.builder.set_light_group(instance, light_group);
            self.builder.set_occlusion_distance(instance, occlusion_distance);
            if is_catcher {
                self.builder.catch_shadows(instance);
            }
            if is_baked {
                self.builder.bake(instance);
            }
            if is_holdout {
                self.builder.hold_out(instance);
            }
            let (geometry, shading) = shadow_terminator;
            self.builder.set_shadow_terminator(instance, ShadowTerminator::new(geometry, shading));
            if let Some((color, pass_index, _)) = info {
                self.builder.set_info(instance, ObjectInfo { color: color.into(), pass_index, random });
            }
            if let Some(name) = asset_name {
                self.builder.set_asset(instance, name);
            }
            if let Some(moved) = moved {
                self.builder.set_moved(instance, moved)?;
            }
            if let Some(keys) = &keys {
                self.builder.set_keys(instance, keys);
            }
        }
        Ok(())
    }

    fn add_light(&mut self, light: PyLight) -> Result<(), Error> {
        let (lamp, matrix, reports) = light.lamp(&mut self.graphs)?;
        reports.into_iter().for_each(|report| self.builder.warn(report));
        Ok(self.builder.add_lamp(lamp, matrix)?)
    }

    fn set_world(&mut self, world: PyWorld) -> Result<(), Error> {
        let (world, reports) = world.world(&mut self.graphs)?;
        reports.into_iter().for_each(|report| self.builder.warn(report));
        Ok(self.builder.set_world(world)?)
    }

    #[expect(clippy::too_many_arguments, reason = "Python's keywords")]
    #[pyo3(signature = (object_name, matrix_world, frame, pixels, panorama = None, is_orthographic = false, dices = false))]
    fn set_viewport(
        &mut self,
        object_name: &str,
        matrix_world: Matrix4,
        frame: ((f64, f64), (f64, f64)),
        pixels: (u32, u32),
        panorama: Option<Described<Panorama>>,
        is_orthographic: bool,
        dices: bool,
    ) -> Result<(), Error> {
        let projection = match panorama {
            Some(panorama) => ViewportProjection::Panoramic(panorama.0),
            None if is_orthographic => ViewportProjection::Orthographic,
            None => ViewportProjection::Perspective,
        };
        let viewport = ViewportDescription {
            matrix: matrix_world.into(),
            focal: frame.0.into(),
            center: frame.1.into(),
            pixels: [pixels.0.max(1), pixels.1.max(1)],
            projection,
        };
        if dices {
            return Ok(self.builder.set_dicing_viewport(object_name, viewport)?);
        }
        Ok(self.builder.set_viewport(object_name, viewport)?)
    }

    fn warnings(&self) -> Vec<String> {
        self.builder.warnings().to_vec()
    }

    fn forget_image(&mut self, index: usize) {
        self.builder.forget_texture(index);
    }

    fn forget_material(&mut self, index: usize) {
        self.builder.forget_material(index);
    }

    fn forget_mesh(&mut self, index: usize) {
        self.builder.forget_mesh(index);
    }

    #[pyo3(signature = (camera_position, threads = 0, previous = None))]
    fn build(
        &mut self,
        py: Python<'_>,
        camera_position: (f64, f64, f64),
        threads: usize,
        previous: Option<Py<Scene>>,
    ) -> Result<Scene, Error> {
        let origin = finite(camera_position)?;
        let Self { builder, .. } = std::mem::take(self);
        staged(py, threads, previous, |previous| PreparedScene::after(previous, builder.build(origin)))
    }

    fn draft(&mut self, origin: (f64, f64, f64)) -> Result<SceneDraft, Error> {
        let scene = self.builder.build_keeping(finite(origin)?);
        self.graphs.forget_unused();
        Ok(SceneDraft { scene: Some(scene) })
    }
}

#[pymethods]
impl SceneDraft {
    #[pyo3(signature = (threads = 0, previous = None, *, is_final = false))]
    fn build(
        &mut self,
        py: Python<'_>,
        threads: usize,
        previous: Option<Py<Scene>>,
        is_final: bool,
    ) -> Result<Scene, Error> {
        let scene = self.scene.take().ok_or_else(|| invalid("this draft was built before"))?;
        let make = if is_final { PreparedScene::after } else { PreparedScene::edited };
        staged(py, threads, previous, |previous| make(previous, scene))
    }
}

fn finite(place: (f64, f64, f64)) -> Result<DVec3, Error> {
    let origin = DVec3::from(place);
    let refusal = || invalid("the camera's position is not finite; reset its location");
    origin.is_finite().then_some(origin).ok_or_else(refusal)
}

/// A stage, made away from Python in so many threads.
fn staged(
    py: Python<'_>,
    threads: usize,
    previous: Option<Py<Scene>>,
    make: impl FnOnce(Option<&PreparedScene>) -> PreparedScene + Send,
) -> Result<Scene, Error> {
    let previous = previous.map(|scene| scene.get().stage.clone());
    let stage = without_gil(py, || -> Result<PreparedScene, Error> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| invalid(format!("no threads to be had: {e}")))?;
        Ok(pool.install(|| make(previous.as_deref())))
    })??;
    Ok(Scene { stage: Arc::new(stage) })
}

#[pymethods]
impl Scene {
    #[getter]
    fn triangle_count(&self) -> usize {
        self.stage.scene.triangle_count()
    }

    #[getter]
    fn segment_count(&self) -> usize {
        self.stage.scene.segment_count()
    }

    #[getter]
    fn point_count(&self) -> usize {
        self.stage.scene.point_count()
    }

    #[getter]
    fn instance_count(&self) -> usize {
        self.stage.scene.placed().len()
    }

    /// Instances that move or change their shape while the shutter is open.
    #[getter]
    fn moving_count(&self) -> usize {
        self.stage.scene.moving.len()
    }

    fn warnings(&self) -> Vec<String> {
        self.stage.warnings.iter().cloned().chain(self.stage.media.report()).collect()
    }

    #[getter]
    fn bvh_seconds(&self) -> f64 {
        self.stage.build_seconds
    }
}
