//! Vertex data from a mesh's edges: islands of connected vertices, and pointiness. Both are Blender's own, step by step, for the numbers
//! are facts of its files.

use glam::Vec3;
use petzval_nodes::random_of;
use std::collections::HashSet;

/// A number from 0 to 1 by vertex, the same for all that edges join. Edges must name vertices that exist.
///
/// The number is the hash of one of the vertices; of which depends on the order of the edges, for the higher of two trees stays.
pub fn random_per_island(vertices: usize, edges: &[[u32; 2]]) -> Vec<f32> {
    let mut parents: Vec<u32> = (0..vertices as u32).collect();
    let mut heights = vec![0u8; vertices];
    for &[a, b] in edges {
        let (mut upper, mut lower) = (root(&mut parents, a), root(&mut parents, b));
        if upper == lower {
            continue;
        }
        if heights[upper as usize] < heights[lower as usize] {
            std::mem::swap(&mut upper, &mut lower);
        }
        parents[lower as usize] = upper;
        if heights[upper as usize] == heights[lower as usize] {
            heights[upper as usize] += 1;
        }
    }
    (0..vertices as u32).map(|vertex| random_of(root(&mut parents, vertex))).collect()
}

fn root(parents: &mut [u32], vertex: u32) -> u32 {
    let mut top = vertex;
    while parents[top as usize] != top {
        top = parents[top as usize];
    }
    let mut at = vertex;
    while parents[at as usize] != top {
        at = std::mem::replace(&mut parents[at as usize], top);
    }
    top
}

/// Pointiness by vertex, from 0 (a hollow) to 1 (a spike), one half where the surface is flat: the angle between the normal and the mean
/// direction of the edges, averaged with that of the neighbours. Vertices at one place count as one.
pub fn pointiness(positions: &[Vec3], normals: &[Vec3], edges: &[[u32; 2]]) -> Vec<f32> {
    let count = positions.len();
    let first = welded(positions);
    let mut sums = vec![Vec3::ZERO; count];
    for (vertex, normal) in normals.iter().enumerate() {
        sums[first[vertex] as usize] += *normal;
    }
    let mut seen = HashSet::new();
    let edges: Vec<[usize; 2]> = edges
        .iter()
        .map(|edge| edge.map(|vertex| first[vertex as usize]))
        .filter(|&[a, b]| seen.insert([a.min(b), a.max(b)]))
        .map(|edge| edge.map(|vertex| vertex as usize))
        .collect();
    let (mut directions, mut neighbours) = (vec![Vec3::ZERO; count], vec![0.0f32; count]);
    for &[a, b] in &edges {
        let along = (positions[b] - positions[a]).normalize_or_zero();
        directions[a] += along;
        directions[b] -= along;
        neighbours[a] += 1.0;
        neighbours[b] += 1.0;
    }
    let angle = |vertex: usize| {
        let cosine = sums[vertex].normalize_or_zero().dot(directions[vertex] / neighbours[vertex]);
        cosine.clamp(-1.0, 1.0).acos() / std::f32::consts::PI
    };
    let own: Vec<f32> = (0..count).map(|vertex| if neighbours[vertex] > 0.0 { angle(vertex) } else { 0.0 }).collect();
    let mut smooth = own.clone();
    for &[a, b] in &edges {
        smooth[a] += own[b];
        smooth[b] += own[a];
    }
    (0..count).map(|vertex| first[vertex] as usize).map(|at| smooth[at] / (neighbours[at] + 1.0)).collect()
}

/// The vertex, for each vertex, that stands for all at its place.
fn welded(positions: &[Vec3]) -> Vec<u32> {
    let sum = |vertex: u32| positions[vertex as usize].element_sum();
    let mut sorted: Vec<u32> = (0..positions.len() as u32).collect();
    sorted.sort_by(|&a, &b| sum(a).total_cmp(&sum(b)));
    let mut next: Vec<u32> = (0..positions.len() as u32).collect();
    for (place, &vertex) in sorted.iter().enumerate() {
        let here = positions[vertex as usize];
        let near = sorted[place + 1..].iter().take_while(|&&other| sum(other) - sum(vertex) <= 3.0 * f32::EPSILON);
        let same = near.copied().find(|&other| positions[other as usize].distance_squared(here) < f32::EPSILON);
        next[vertex as usize] = same.unwrap_or(vertex);
    }
    // From the last of the order to the first, so that what is pointed at is settled already.
    for &vertex in sorted.iter().rev() {
        next[vertex as usize] = next[next[vertex as usize] as usize];
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_hangs_together_has_one_number() {
        let numbers = random_per_island(6, &[[0, 3], [4, 5], [3, 2]]);
        assert_eq!(numbers[0], numbers[2]);
        assert_eq!(numbers[0], numbers[3]);
        assert_eq!(numbers[4], numbers[5]);
        let apart = [numbers[0], numbers[1], numbers[4]];
        assert!((0..3).all(|i| (0..i).all(|j| apart[i] != apart[j])), "{apart:?}");
    }

    /// A pyramid's top points outward, its faces' borders less; the same when every face has vertices of its own.
    #[test]
    fn a_top_is_pointed_however_its_faces_are_joined() {
        let ring = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y];
        let joined = [ring[0], ring[1], ring[2], ring[3], Vec3::Z];
        let around = [[0, 1], [1, 2], [2, 3], [3, 0]];
        let edges: Vec<[u32; 2]> = around.iter().copied().chain((0..4).map(|i| [i, 4])).collect();
        let normals = [ring[0], ring[1], ring[2], ring[3], Vec3::Z];
        let whole = pointiness(&joined, &normals, &edges);
        // Edges down from the top at 45 degrees: 135 from its normal; with the mean of what is beside it.
        assert!(whole[4] > 0.6, "{whole:?}");
        let (mut places, mut own_normals, mut own_edges) = (vec![], vec![], vec![]);
        for (face, [a, b]) in around.into_iter().enumerate() {
            for vertex in [a, b, 4] {
                places.push(joined[vertex as usize]);
                own_normals.push(normals[vertex as usize]);
            }
            let start = 3 * face as u32;
            own_edges.extend([[start, start + 1], [start + 1, start + 2], [start + 2, start]]);
        }
        let split = pointiness(&places, &own_normals, &own_edges);
        assert!((split[2] - whole[4]).abs() < 1e-6 && (split[0] - whole[0]).abs() < 1e-6, "{split:?} {whole:?}");
    }
}
