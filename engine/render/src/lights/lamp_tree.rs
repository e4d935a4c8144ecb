//! Finding the lamps that a ray meets: a tree of boxes, so that a thousand lamps cost a ray little more than ten.

use super::lamp::PreparedLamp;
use glam::Vec3A;

/// Lamps that are tried one after the other.
const FEW: usize = 4;
/// Deeper than any tree of halves over 2^32 lamps.
const STACK: usize = 64;

/// A box, and what is in it: two nodes from `first` on where `count` is 0, else so many lamps.
#[derive(Clone, Copy, Debug)]
struct Node {
    min: Vec3A,
    max: Vec3A,
    first: u32,
    count: u32,
}

/// The tree over lamps that have extent and stand within the scene.
#[derive(Debug, Default)]
pub(super) struct LampTree {
    nodes: Vec<Node>,
    /// Places in the list of emitters, in the order of the leaves.
    emitters: Vec<u32>,
}

struct Item {
    min: Vec3A,
    max: Vec3A,
    emitter: u32,
}

impl LampTree {
    /// Of lamps, each with its place in the list of emitters.
    pub(super) fn new<'a>(lamps: impl Iterator<Item = (u32, &'a PreparedLamp)>) -> Self {
        let item = |(emitter, lamp): (u32, &PreparedLamp)| {
            let bounds = lamp.bounds();
            // Flat boxes are met, too, and rounding takes none away.
            let size = bounds.min.abs().max(bounds.max.abs()).max_element();
            let margin = Vec3A::splat(1e-5 * size);
            Item { min: bounds.min - margin, max: bounds.max + margin, emitter }
        };
        let mut items: Vec<Item> = lamps.filter(|(_, lamp)| !lamp.is_point_like()).map(item).collect();
        let mut tree = Self::default();
        if !items.is_empty() {
            tree.nodes.push(Node { min: Vec3A::ZERO, max: Vec3A::ZERO, first: 0, count: 0 });
            tree.fill(0, &mut items);
        }
        tree
    }

    fn fill(&mut self, node: usize, items: &mut [Item]) {
        let join = |(a, b): (Vec3A, Vec3A), item: &Item| (a.min(item.min), b.max(item.max));
        let (min, max) = items.iter().fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), join);
        if items.len() <= FEW {
            let (first, count) = (self.emitters.len() as u32, items.len() as u32);
            self.emitters.extend(items.iter().map(|item| item.emitter));
            self.nodes[node] = Node { min, max, first, count };
            return;
        }
        let extent = (max - min).to_array();
        let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| {
            let place = |item: &Item| item.min[axis] + item.max[axis];
            place(a).total_cmp(&place(b)).then(a.emitter.cmp(&b.emitter))
        });
        let first = self.nodes.len();
        self.nodes[node] = Node { min, max, first: first as u32, count: 0 };
        self.nodes.extend([self.nodes[node]; 2]);
        let (low, high) = items.split_at_mut(middle);
        self.fill(first, low);
        self.fill(first + 1, high);
    }

    /// Calls `tried` for each emitter that the ray may meet before `t_max`.
    #[inline]
    pub(super) fn along(&self, from: Vec3A, d: Vec3A, t_max: f32, mut tried: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let inverse = d.recip();
        let mut stack = [0u32; STACK];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            let (a, b) = ((node.min - from) * inverse, (node.max - from) * inverse);
            // A ray within a box's side gives NaN there: min and max then take the other.
            let enter = a.min(b).max_element().max(0.0);
            let leave = a.max(b).min_element();
            if enter > leave.min(t_max) {
                continue;
            }
            if node.count == 0 {
                stack[depth] = node.first;
                stack[depth + 1] = node.first + 1;
                depth += 2;
                continue;
            }
            for &emitter in &self.emitters[node.first as usize..(node.first + node.count) as usize] {
                tried(emitter);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::warp::sample_sphere;
    use crate::scene::lamp::{Lamp, LampKind};
    use glam::Affine3A;

    /// A ray meets the same lamps by the tree as by trying all.
    #[test]
    fn no_lamp_is_missed() {
        let lamps: Vec<PreparedLamp> = (0..300)
            .map(|i| {
                let u = sobol_burley::sample_4d(i, 0, 1);
                let place = Vec3A::new(u[0], u[1], u[2]) * 10.0;
                let kind = match i % 3 {
                    0 => LampKind::Point { radius: u[3], soft: false },
                    1 => LampKind::Point { radius: u[3], soft: true },
                    _ => LampKind::Area { size: [2.0 * u[3], u[3]], ellipse: i % 2 == 0, half_spread_rad: 1.5 },
                };
                let mut to_render = Affine3A::from_rotation_x(u[0] * 6.0) * Affine3A::from_rotation_y(u[1] * 6.0);
                to_render.translation = place;
                PreparedLamp::new(&Lamp { kind, to_render, ..Lamp::default() }, Vec3A::ZERO)
            })
            .collect();
        let tree = LampTree::new(lamps.iter().enumerate().map(|(i, lamp)| (i as u32, lamp)));
        let mut met = 0;
        for i in 0..2000 {
            let u = sobol_burley::sample_4d(i, 0, 2);
            let v = sobol_burley::sample_4d(i, 0, 3);
            let (from, t_max) = (Vec3A::new(u[0], u[1], u[2]) * 12.0 - 1.0, 10.0 * u[3]);
            let d = if i % 5 == 0 { Vec3A::AXES[i as usize % 3] } else { sample_sphere([v[0], v[1]]) };
            let hits = |i: u32| lamps[i as usize].hit(from, d, t_max).is_some();
            let mut found = Vec::new();
            tree.along(from, d, t_max, |i| found.extend(hits(i).then_some(i)));
            found.sort_unstable();
            let all: Vec<u32> = (0..300).filter(|&i| hits(i)).collect();
            assert_eq!(found, all);
            met += all.len();
        }
        assert!(met > 500, "{met}");
    }
}
