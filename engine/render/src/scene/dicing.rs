//! Meshes divided until their edges are about as long as a pixel is wide, so that displacement has vertices enough.
//!
//! Edges are halved, not faces diced: an edge that is too long is so for the triangles on both of its sides, and no cracks open. A triangle
//! with one, two or three such edges becomes two, three or four. (Cycles splits patches until their sides have as many parts as pixels:
//! Fisher, Fatahalian et al. 2009, "DiagSplit: Parallel, Crack-free, Adaptive Tessellation for Micropolygon Rendering".)

use super::Scene;
use super::corners::{Corners, Numbers};
use super::mesh::{EdgeLength, Mesh, MeshDescription};
use super::motion::Poses;
use glam::{Affine3A, Vec2, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f32::consts::SQRT_2;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::{Add, Mul};
use std::sync::Arc;

/// Triangles of a scene beyond which none are divided: about 3 GB with their tree.
const MOST_TRIANGLES: usize = 12_000_000;

/// Divides the meshes that are to be diced and displaced; of a mesh that several objects share, as finely as the nearest needs it. Gives
/// warnings on those that stay too coarse.
pub fn dice(scene: &mut Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    if scene.meshes.iter().all(|mesh| mesh.dicing.is_none()) {
        return warnings;
    }
    let mut spent = 0;
    let room = MOST_TRIANGLES.saturating_sub(scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum());
    for index in 0..scene.meshes.len() {
        let mesh = &scene.meshes[index];
        let Some(dicing) = mesh.dicing.filter(|_| mesh.is_of_triangles()) else { continue };
        let users = scene.placed().iter().filter(|one| one.mesh as usize == index);
        let (places, moves): (Vec<Affine3A>, Vec<bool>) = users
            .map(|one| {
                let moves = |&slot: &u32| scene.materials[slot as usize].graph.moves_vertices();
                (one.to_render, one.materials.iter().any(moves))
            })
            .unzip();
        if !moves.contains(&true) {
            continue;
        }
        let viewport = scene.dicing_viewport.as_ref().unwrap_or(&scene.viewport);
        // The edges that are left are between 0.7 and 1.4 times as long as they are to be.
        let is_long = |a: Vec3, b: Vec3| match dicing.edge {
            EdgeLength::Units(units) => a.distance(b) > SQRT_2 * units,
            EdgeLength::Pixels(pixels) => places.iter().any(|to_render| {
                let [a, b] =
                    [a, b].map(|end| viewport.from_render.transform_point3a(to_render.transform_point3a(end.into())));
                a.distance(b) > SQRT_2 * pixels * viewport.diced_width(0.5 * (a + b), dicing.off_screen)
            }),
        };
        let before = mesh.triangles.len();
        let most = before + room.min(dicing.room).saturating_sub(spent);
        let mut pieces = Pieces::of(mesh);
        let is_whole = pieces.divide(is_long, dicing.halvings, most);
        spent += pieces.list.len() - before;
        if !is_whole {
            warnings.push(format!(
                "mesh '{}': its adaptive subdivision ends at {} triangles, coarser than the dicing rate asks for; a larger dicing rate or \
                 off-screen scale needs fewer",
                mesh.name,
                pieces.list.len()
            ));
        }
        match Mesh::new(pieces.mesh(mesh)) {
            Ok((diced, warning)) => {
                scene.meshes[index] = Arc::new(diced);
                warnings.extend(warning);
            }
            Err(error) => warnings.push(format!("{error}; it is not divided")),
        }
    }
    warnings
}

/// A corner of a piece.
#[derive(Clone, Copy)]
struct Corner {
    vertex: u32,
    /// Weights of the second and third corner of the triangle that the piece is of.
    at: Vec2,
}

/// A part of a triangle.
#[derive(Clone, Copy)]
struct Piece {
    of: u32,
    corners: [Corner; 3],
}

/// A mesh in pieces.
struct Pieces {
    list: Vec<Piece>,
    /// Positions of all vertices, those in the middle of edges included.
    positions: Vec<Vec3>,
    /// The two ends of the edge of each vertex in the middle of one.
    ends: Vec<[u32; 2]>,
}

impl Pieces {
    /// Each triangle in one piece.
    fn of(mesh: &Mesh) -> Self {
        let piece = |(of, vertices): (u32, &[u32; 3])| {
            let corner = |i: usize| Corner { vertex: vertices[i], at: [Vec2::ZERO, Vec2::X, Vec2::Y][i] };
            Piece { of, corners: [0, 1, 2].map(corner) }
        };
        let list = (0..).zip(&mesh.triangles).map(piece).collect();
        Self { list, positions: mesh.positions.clone(), ends: Vec::new() }
    }

    /// Halves edges as long as they are too long, up to so many times and pieces; false if some are too long still for the latter.
    fn divide(&mut self, is_long: impl Fn(Vec3, Vec3) -> bool + Sync, halvings: u32, most: usize) -> bool {
        for _ in 0..halvings {
            // From both sides an edge is asked in the same direction.
            let is_split = |[a, b]: [Corner; 2]| {
                let [a, b] = [a.vertex.min(b.vertex), a.vertex.max(b.vertex)].map(|i| self.positions[i as usize]);
                is_long(a, b)
            };
            let splits: Vec<[bool; 3]> =
                self.list.par_iter().map(|piece| edges(&piece.corners).map(is_split)).collect();
            let more = splits.as_flattened().iter().filter(|split| **split).count();
            if more == 0 {
                break;
            }
            if self.list.len() + more > most {
                return false;
            }
            self.split(&splits, more);
        }
        true
    }

    /// Halves these edges of each piece: `more` in all.
    fn split(&mut self, splits: &[[bool; 3]], more: usize) {
        let mut middles: HashMap<[u32; 2], u32, BuildHasherDefault<EdgeHasher>> = HashMap::default();
        middles.reserve(more / 2);
        let before = std::mem::replace(&mut self.list, Vec::with_capacity(splits.len() + more));
        for (piece, splits) in before.into_iter().zip(splits) {
            let ends = edges(&piece.corners);
            let middle = [0, 1, 2].map(|i| {
                splits[i].then(|| {
                    let [a, b] = ends[i];
                    let key = [a.vertex.min(b.vertex), a.vertex.max(b.vertex)];
                    let vertex = *middles.entry(key).or_insert_with(|| {
                        let [a, b] = key.map(|i| self.positions[i as usize]);
                        self.positions.push(0.5 * (a + b));
                        self.ends.push(key);
                        self.positions.len() as u32 - 1
                    });
                    Corner { vertex, at: 0.5 * (a.at + b.at) }
                })
            });
            let mut add = |corners: [Corner; 3]| self.list.push(Piece { of: piece.of, corners });
            let [a, b, c] = piece.corners;
            match middle {
                [None, None, None] => add([a, b, c]),
                [Some(ab), Some(bc), Some(ca)] => {
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().for_each(add);
                }
                [Some(ab), None, None] => [[a, ab, c], [ab, b, c]].into_iter().for_each(add),
                [None, Some(bc), None] => [[a, b, bc], [a, bc, c]].into_iter().for_each(add),
                [None, None, Some(ca)] => [[a, b, ca], [ca, b, c]].into_iter().for_each(add),
                [Some(ab), Some(bc), None] => {
                    split_twice([a, b, c], [ab, bc], &self.positions).into_iter().for_each(add)
                }
                [None, Some(bc), Some(ca)] => {
                    split_twice([b, c, a], [bc, ca], &self.positions).into_iter().for_each(add)
                }
                [Some(ab), None, Some(ca)] => {
                    split_twice([c, a, b], [ca, ab], &self.positions).into_iter().for_each(add)
                }
            }
        }
    }

    /// The description of the mesh in these pieces.
    fn mesh(self, mesh: &Mesh) -> MeshDescription {
        let numbers = mesh.numbers();
        let grown = |list: &[Vec3]| self.grown(list, |a, b| 0.5 * (a + b));
        MeshDescription {
            name: mesh.name.clone(),
            triangles: self.list.iter().map(|piece| piece.corners.map(|corner| corner.vertex)).collect(),
            loops: Vec::new(),
            corner_normals: mesh.corner_normals.as_ref().map(|values| self.spread(values, numbers)),
            uv_maps: mesh.uv_maps.iter().map(|(name, values)| (name.clone(), self.spread(values, numbers))).collect(),
            attributes: mesh
                .attributes
                .iter()
                .map(|(name, values)| (name.clone(), self.spread(values, numbers)))
                .collect(),
            material_slots: mesh
                .material_slots
                .as_ref()
                .map(|slots| self.list.iter().map(|piece| slots[piece.of as usize]).collect()),
            moved_positions: mesh.moved_positions.as_ref().map(|moved| [0, 1].map(|i| grown(&moved[i]))),
            poses: mesh.poses.as_ref().map(|poses| Poses {
                positions: poses.positions.iter().map(|positions| grown(positions)).collect(),
                corner_normals: poses
                    .corner_normals
                    .as_ref()
                    .map(|keys| keys.iter().map(|values| self.spread(values, numbers)).collect()),
            }),
            grids: mesh.grids.clone(),
            keeps_opacity: mesh.keeps_opacity,
            dicing: None,
            positions: self.positions,
        }
    }

    /// Values of vertices, with those between edges.
    fn grown<T: Copy>(&self, values: &[T], mean: impl Fn(T, T) -> T) -> Vec<T> {
        let mut all = Vec::with_capacity(values.len() + self.ends.len());
        all.extend_from_slice(values);
        for [a, b] in &self.ends {
            all.push(mean(all[*a as usize], all[*b as usize]));
        }
        all
    }

    /// Values at the corners of the pieces, linear over each triangle.
    fn spread<T>(&self, values: &Corners<T>, numbers: Numbers<'_>) -> Corners<T>
    where
        T: Copy + Send + Sync + Add<Output = T> + Mul<f32, Output = T>,
    {
        match values {
            Corners::Vertices(values) => Corners::Vertices(self.grown(values, |a, b| (a + b) * 0.5)),
            Corners::Triangles(values) => {
                Corners::Triangles(self.list.iter().map(|piece| values[piece.of as usize]).collect())
            }
            Corners::Loops(_) | Corners::Each(_) => {
                let of = |piece: &Piece| {
                    let [a, b, c] = values.at(numbers, piece.of);
                    piece.corners.map(|Corner { at, .. }| a * (1.0 - at.x - at.y) + b * at.x + c * at.y)
                };
                Corners::Each(self.list.par_iter().map(of).collect())
            }
        }
    }
}

/// The ends of a triangle's edges.
fn edges([a, b, c]: &[Corner; 3]) -> [[Corner; 2]; 3] {
    [[*a, *b], [*b, *c], [*c, *a]]
}

/// A triangle whose first two edges are halved, in three; the rest of it is cut along its shorter diagonal.
fn split_twice([a, b, c]: [Corner; 3], [ab, bc]: [Corner; 2], positions: &[Vec3]) -> [[Corner; 3]; 3] {
    let length =
        |from: Corner, to: Corner| positions[from.vertex as usize].distance_squared(positions[to.vertex as usize]);
    if length(a, bc) <= length(ab, c) {
        [[ab, b, bc], [a, ab, bc], [a, bc, c]]
    } else {
        [[ab, b, bc], [a, ab, c], [ab, bc, c]]
    }
}

/// A hash of an edge by a product: millions are looked up.
#[derive(Default)]
struct EdgeHasher(u64);

impl Hasher for EdgeHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u32(u32::from(*byte)));
    }

    fn write_u32(&mut self, number: u32) {
        let mixed = (self.0 ^ u64::from(number)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = mixed ^ (mixed >> 32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// Two triangles of a square, with UVs that are its coordinates, by corner, and normals by vertex.
    fn square() -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let uvs = [[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| t.map(|i| Vec2::new(positions[i].x, positions[i].y)));
        Mesh::new(MeshDescription {
            corner_normals: Some(Corners::Vertices(vec![Vec3::Z; 4])),
            uv_maps: vec![("UV".to_owned(), Corners::Each(uvs.to_vec()))],
            material_slots: Some(vec![0, 3]),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            positions,
            ..MeshDescription::default()
        })
        .unwrap()
        .0
    }

    /// Edges are short only about one corner, so that pieces of all sizes are neighbours.
    fn is_long(a: Vec3, b: Vec3) -> bool {
        a.distance(b) > 0.02 + 0.3 * (0.5 * (a + b)).length()
    }

    #[test]
    fn pieces_cover_the_mesh_without_cracks_and_keep_its_values() {
        let mesh = square();
        let mut pieces = Pieces::of(&mesh);
        assert!(pieces.divide(is_long, 12, 100_000));
        let (diced, warning) = Mesh::new(pieces.mesh(&mesh)).unwrap();
        assert!(warning.is_none() && diced.triangles.len() > 50);
        let mut area = 0.0;
        let mut open = HashSet::new();
        for (i, t) in (0..).zip(&diced.triangles) {
            let corners = diced.corners(i);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            assert!(normal.z > 0.0, "{corners:?}");
            area += 0.5 * normal.z;
            let uvs = diced.uv_maps[0].1.at(diced.numbers(), i);
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                assert!(!is_long(corners[k], corners[(k + 1) % 3]));
                assert!(uvs[k].extend(0.0).distance(corners[k]) < 1e-6);
                if !open.remove(&(b, a)) {
                    open.insert((a, b));
                }
            }
            // Each side of the diagonal keeps its material.
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            assert_eq!(diced.slot(i), if middle.x > middle.y { 0 } else { 3 });
        }
        assert!((area - 1.0).abs() < 1e-5, "{area}");
        // What has one side only lies on the rim, and there are no two vertices at one place.
        let on_rim = |p: Vec3| p.x == 0.0 || p.x == 1.0 || p.y == 0.0 || p.y == 1.0;
        assert!(open.iter().all(|&(a, b)| on_rim(diced.positions[a as usize]) && on_rim(diced.positions[b as usize])));
        let places: HashSet<_> = diced.positions.iter().map(|p| p.to_array().map(f32::to_bits)).collect();
        assert_eq!(places.len(), diced.positions.len());
    }

    #[test]
    fn it_ends_at_the_most_pieces_and_halvings() {
        let mesh = square();
        let mut pieces = Pieces::of(&mesh);
        assert!(!pieces.divide(|_, _| true, 12, 100));
        assert_eq!(pieces.list.len(), 32);
        let mut pieces = Pieces::of(&mesh);
        assert!(pieces.divide(|_, _| true, 2, 100_000));
        assert_eq!(pieces.list.len(), 32);
    }
}
