//! Finding the lamps that a ray hits: a tree of boxes, so that a thousand lamps cost a ray little more than ten. Eight boxes
//! a node, tried at once in the lanes of a register.

use super::lamp::PreparedLamp;
use crate::nodes::PathState;
use crate::scene::visibility::Rays;
use arrayvec::ArrayVec;
use glam::Vec3A;
use wide::f32x8;

/// Boxes in a node.
const WIDTH: usize = 8;
/// Size of the stack: more than the nodes that can wait in any tree of eighths over 2^32 lamps.
const STACK: usize = 96;

/// Boxes, lane by lane, and their contents.
#[derive(Clone, Debug)]
struct Node {
    min: [f32x8; 3],
    max: [f32x8; 3],
    /// A node, or a lamp's place in the list of emitters.
    inside: [u32; WIDTH],
    /// A bit for each lane that holds anything.
    used: u32,
    /// A bit for each lane that holds a lamp.
    lamps: u32,
}

/// The tree over lamps that have extent and stand within the scene.
#[derive(Debug)]
pub(super) struct LampTree {
    nodes: Vec<Node>,
    /// The kinds of ray that any of the lamps reaches.
    reaches: Rays,
}

struct Item {
    min: Vec3A,
    max: Vec3A,
    emitter: u32,
}

impl LampTree {
    /// The tree of lamps, each with its place in the list of emitters.
    pub(super) fn new<'a>(lamps: impl Iterator<Item = (u32, &'a PreparedLamp)>) -> Self {
        let item = |(emitter, lamp): (u32, &PreparedLamp)| {
            let bounds = lamp.bounds();
            // Flat boxes are hit, too, and rounding takes none away.
            let size = bounds.min.abs().max(bounds.max.abs()).max_element();
            let margin = Vec3A::splat(1e-5 * size);
            Item { min: bounds.min - margin, max: bounds.max + margin, emitter }
        };
        let mut reaches = Rays::NONE;
        let lamps = lamps.filter(|(_, lamp)| !lamp.is_point_like());
        let mut items: Vec<Item> = lamps.inspect(|(_, lamp)| reaches = reaches.and(lamp.reaches())).map(item).collect();
        let mut tree = Self { nodes: Vec::new(), reaches };
        if !items.is_empty() {
            tree.add(&mut items);
        }
        tree
    }

    /// Adds a node over lamps; gives its number.
    fn add(&mut self, items: &mut [Item]) -> u32 {
        let here = self.nodes.len();
        let mut parts = vec![items];
        while parts.len() < WIDTH {
            // The largest, as long as any holds more than one lamp.
            let Some(largest) = (0..parts.len()).max_by_key(|&i| parts[i].len()).filter(|&i| parts[i].len() > 1) else {
                break;
            };
            let (low, high) = halves(parts.swap_remove(largest));
            parts.extend([low, high]);
        }
        let boxes: Vec<(Vec3A, Vec3A)> = parts.iter().map(|part| bounds(part)).collect();
        let lanes = |of: &dyn Fn(&(Vec3A, Vec3A)) -> f32| {
            let mut values = [0.0; WIDTH];
            values.iter_mut().zip(&boxes).for_each(|(value, bounds)| *value = of(bounds));
            f32x8::from(values)
        };
        self.nodes.push(Node {
            min: [0, 1, 2].map(|axis| lanes(&|bounds| bounds.0[axis])),
            max: [0, 1, 2].map(|axis| lanes(&|bounds| bounds.1[axis])),
            inside: [0; WIDTH],
            used: (1 << parts.len()) - 1,
            lamps: 0,
        });
        for (lane, part) in parts.into_iter().enumerate() {
            if let [lamp] = part {
                self.nodes[here].inside[lane] = lamp.emitter;
                self.nodes[here].lamps |= 1 << lane;
            } else {
                self.nodes[here].inside[lane] = self.add(part);
            }
        }
        here as u32
    }

    /// True if a ray of a path in this state may find any of the lamps: as in most scenes none shows to the camera.
    #[inline]
    pub(super) fn is_found_by(&self, way: PathState) -> bool {
        self.reaches.all_of(way.finds())
    }

    /// Calls `tried` for each emitter that the ray may hit before `t_max`.
    #[inline]
    pub(super) fn along(&self, from: Vec3A, d: Vec3A, t_max: f32, mut tried: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let inverse = d.recip().to_array().map(f32x8::splat);
        let from = from.to_array().map(f32x8::splat);
        let t_max = f32x8::splat(t_max);
        let mut stack = ArrayVec::<u32, STACK>::new();
        stack.push(0);
        while let Some(number) = stack.pop() {
            let node = &self.nodes[number as usize];
            let (mut enter, mut leave) = (f32x8::splat(0.0), t_max);
            for axis in 0..3 {
                let a = (node.min[axis] - from[axis]) * inverse[axis];
                let b = (node.max[axis] - from[axis]) * inverse[axis];
                enter = a.fast_min(b).fast_max(enter);
                leave = a.fast_max(b).fast_min(leave);
            }
            let met = enter.simd_le(leave).to_bitmask() & node.used;
            let mut nodes = met & !node.lamps;
            while nodes != 0 {
                stack.push(node.inside[nodes.trailing_zeros() as usize]);
                nodes &= nodes - 1;
            }
            let mut lamps = met & node.lamps;
            while lamps != 0 {
                tried(node.inside[lamps.trailing_zeros() as usize]);
                lamps &= lamps - 1;
            }
        }
    }
}

fn bounds(items: &[Item]) -> (Vec3A, Vec3A) {
    let join = |(a, b): (Vec3A, Vec3A), item: &Item| (a.min(item.min), b.max(item.max));
    items.iter().fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), join)
}

/// Two halves of more than one lamp, along the axis on which they spread most.
fn halves(items: &mut [Item]) -> (&mut [Item], &mut [Item]) {
    let (min, max) = bounds(items);
    let extent = (max - min).to_array();
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        let place = |item: &Item| item.min[axis] + item.max[axis];
        place(a).total_cmp(&place(b)).then(a.emitter.cmp(&b.emitter))
    });
    items.split_at_mut(middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::warp::sample_sphere;
    use crate::scene::lamp::{Lamp, LampKind};
    use glam::Affine3A;

    /// A ray hits the same lamps by the tree as by trying all.
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
