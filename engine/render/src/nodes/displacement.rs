//! Displacement that moves vertices: the program of a material is run at each vertex of its meshes, and the mesh takes a new
//! shape before trees are built.

use super::images::Images;
use super::layers::surface_point;
use super::point::{Point, UNDISPLACED_NORMAL, UNDISPLACED_POSITION, View};
use crate::nodes::{PathState, RayCone};
use crate::scene::Scene;
use crate::scene::corners::Corners;
use crate::scene::graph::{Displacement, Graph};
use crate::scene::mesh::{Mesh, MeshDescription};
use crate::scene::motion::{MIDDLE, Poses};
use glam::{Vec3, Vec3A};
use petzval_nodes::Registers;
use rayon::prelude::*;
use std::sync::Arc;

/// Moves the vertices of every mesh whose material says so; of a mesh that several objects share, as the first has it. Returns
/// warnings of the parts that were left out.
pub fn displace(scene: &mut Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    if !scene.materials.iter().any(|material| material.graph.moves_vertices()) {
        return warnings;
    }
    let mut first = vec![None; scene.meshes.len()];
    for (instance, one) in scene.instances.iter().enumerate() {
        first[one.mesh as usize].get_or_insert(instance);
    }
    for (mesh, instance) in first.into_iter().enumerate() {
        let Some(instance) = instance else { continue };
        let Some(offsets) = offsets(scene, instance) else { continue };
        let owner = &scene.instances[instance];
        let graphs = owner.materials.iter().map(|&i| &*scene.materials[i as usize].graph);
        let bends = graphs.filter(|graph| graph.moves_vertices()).any(|graph| graph.displacement == Displacement::Both);
        let by_vertices = |slot: u32| {
            let graph = &scene.materials[owner.material(slot) as usize].graph;
            graph.moves_vertices() && graph.displacement == Displacement::Vertices
        };
        match Mesh::new(moved(&scene.meshes[mesh], &offsets, by_vertices, bends)) {
            Ok((moved, warning)) => {
                scene.meshes[mesh] = Arc::new(moved);
                // Cycles does not put such a mesh into the world.
                scene.instances[instance].is_stretched = false;
                warnings.extend(warning);
            }
            Err(error) => warnings.push(format!("{error}; it keeps its shape")),
        }
    }
    warnings
}

/// The displacement of each vertex of an instance's mesh, object space; `None` if none is displaced.
fn offsets(scene: &Scene, instance: usize) -> Option<Vec<Vec3>> {
    let owner = &scene.instances[instance];
    let mesh = &scene.meshes[owner.mesh as usize];
    if !mesh.is_of_triangles() {
        return None;
    }
    let graph_of = |slot: u32| -> Option<&Graph> {
        Some(&*scene.materials[owner.material(slot) as usize].graph).filter(|graph| graph.moves_vertices())
    };
    let slots = mesh.material_slots.as_ref().map_or(1, |slots| slots.iter().max().map_or(1, |most| most + 1));
    if !(0..slots).any(|slot| graph_of(slot).is_some()) {
        return None;
    }
    // A vertex between materials or at a seam is moved as the first triangle that has it says, as in Cycles.
    let mut first = vec![None; mesh.positions.len()];
    for (i, corners) in mesh.triangles.iter().enumerate() {
        if graph_of(mesh.slot(i as u32)).is_some() {
            for (corner, &vertex) in corners.iter().enumerate() {
                first[vertex as usize].get_or_insert((i as u32, corner));
            }
        }
    }
    let offset = |registers: &mut Registers, vertex: usize| -> Vec3 {
        let Some((triangle, corner)) = first[vertex] else { return Vec3::ZERO };
        let Some(graph) = graph_of(mesh.slot(triangle)) else { return Vec3::ZERO };
        let Some(displacement) = graph.program.displacement else { return Vec3::ZERO };
        // That of the smooth mesh, as Blender weights it, or of the flat triangle.
        let normal = mesh.normals(triangle).map_or_else(|| face_normal(mesh.corners(triangle)), |all| all[corner]);
        let normal = (owner.normal_to_render * Vec3A::from(normal)).normalize_or(Vec3A::Z);
        // Looked at from above, from about as far as the triangle is wide.
        let [a, b, c] = mesh.corners(triangle);
        let width = owner.to_render.transform_vector3((b - a).abs().max((c - a).abs())).length();
        let cone = RayCone::pixel(&scene.viewport);
        let view =
            View { direction: -normal, distance: width, way: PathState::BOUNCE, moment: MIDDLE, is_blurry: true, cone };
        let barycentric = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][corner];
        let Graph { program, slices, pass_index, .. } = graph;
        let surface = surface_point(scene.into(), [instance as u32, triangle], barycentric, &view);
        let point = Point::new(scene.into(), surface, view, &program.attributes, *pass_index as f32, true);
        program.run_slice(&slices.displacement, &point.with_normal(normal), &Images(&scene.textures), registers);
        let moved = owner.to_object.matrix3 * program.value(displacement, registers);
        if moved.is_finite() { moved.into() } else { Vec3::ZERO }
    };
    Some((0..mesh.positions.len()).into_par_iter().map_init(Registers::default, offset).collect())
}

/// The mean of the unit normals of the triangles at each vertex that count; zero where none does.
fn vertex_normals(mesh: &Mesh, counts: impl Fn(u32) -> bool) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for (i, corners) in mesh.triangles.iter().enumerate().filter(|(i, _)| counts(*i as u32)) {
        let normal = face_normal(mesh.corners(i as u32));
        corners.iter().for_each(|&vertex| sums[vertex as usize] += normal);
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}

fn face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The mesh with its vertices moved. Triangles that were flat are flat again. At vertices of triangles that are displaced and not bumped,
/// by the material of their slot, smooth triangles get the means of the new normals; elsewhere they keep the old ones, as in Cycles. The
/// old normals and positions of all are kept where a bump, which is of the whole displacement, is to bend them.
fn moved(mesh: &Mesh, offsets: &[Vec3], by_vertices: impl Fn(u32) -> bool, bends: bool) -> MeshDescription {
    let shift = |positions: &[Vec3]| positions.iter().zip(offsets).map(|(p, offset)| *p + *offset).collect();
    let positions: Vec<Vec3> = shift(&mesh.positions);
    let shape = Mesh { positions, ..mesh.clone() };
    let new = vertex_normals(&shape, |i| by_vertices(mesh.slot(i)));
    // Blender keeps normals by vertex where all faces are smooth.
    let is_smooth = matches!(mesh.corner_normals, Some(Corners::Vertices(_)));
    let corner_normals = mesh.corner_normals.as_ref().map(|old| {
        let of = |i: u32| {
            let (old, before) = (old.at(mesh.numbers(), i), face_normal(mesh.corners(i)));
            if !is_smooth && old.iter().all(|normal| normal.distance_squared(before) < 1e-8) {
                return [face_normal(shape.corners(i)); 3];
            }
            let corners = shape.triangles[i as usize];
            std::array::from_fn(|corner| match new[corners[corner] as usize] {
                Vec3::ZERO => old[corner],
                normal => normal,
            })
        };
        Corners::Each((0..mesh.triangles.len() as u32).map(of).collect())
    });
    let Mesh {
        name,
        positions,
        triangles,
        loops,
        uv_maps,
        mut attributes,
        material_slots,
        moved_positions,
        poses,
        grids,
        keeps_opacity,
        dicing,
        ..
    } = shape;
    if bends {
        let old = |i: u32| mesh.normals(i).unwrap_or_else(|| [face_normal(mesh.corners(i)); 3]);
        let old = (0..triangles.len() as u32).map(|i| old(i).map(|normal| normal.extend(0.0))).collect();
        attributes.push((UNDISPLACED_NORMAL.to_owned(), Corners::Each(old)));
        let old = mesh.positions.iter().map(|position| position.extend(1.0)).collect();
        attributes.push((UNDISPLACED_POSITION.to_owned(), Corners::Vertices(old)));
    }
    let moved_positions = moved_positions.map(|moved| moved.map(|positions| shift(&positions)));
    MeshDescription {
        name,
        positions,
        triangles,
        loops,
        corner_normals,
        uv_maps,
        attributes,
        material_slots,
        moved_positions,
        // Each shape is moved as the middle one is; normals that were given for them no longer hold.
        poses: poses.map(|poses| Poses {
            positions: poses.positions.iter().map(|positions| shift(positions)).collect(),
            corner_normals: None,
        }),
        grids,
        keeps_opacity,
        dicing,
    }
}
