//! The nodes of a tree: up to eight boxes on a grid of 256 steps each way (Ylitie, Karras and Laine 2017), all eight
//! tested in one go.

use super::bounds::Bounds;
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use glam::Vec3A;

/// Boxes of a node.
pub(super) const WIDTH: usize = 8;

/// The bit of a [`Child`] that marks a leaf.
const LEAF: u32 = 1 << 31;
/// Bits of an index; those above count children.
const INDEX_BITS: u32 = 28;
/// Number of nodes or leaves that a tree can have.
pub(super) const MOST: usize = 1 << INDEX_BITS;

/// Up to eight children: inner nodes first, then leaves, both consecutive. 80 bytes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Node {
    /// The corner from which the boxes are measured.
    origin: [f32; 3],
    /// One step of the grid along each axis: a power of two, so that multiplying by it is exact.
    step: [f32; 3],
    /// Index of the first inner child; in the upper bits the number of children that are inner nodes.
    nodes: u32,
    /// Index of the first leaf; in the upper bits the number of children.
    leaves: u32,
    /// The lower and the upper planes, by axis.
    planes: [[[u8; WIDTH]; 2]; 3],
}

/// A reference of a node to a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(pub(super) u32);

impl Child {
    /// The tree's first node.
    pub(super) const ROOT: Self = Self(0);

    #[inline(always)]
    pub(super) fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }

    #[inline(always)]
    pub(super) fn index(self) -> usize {
        (self.0 & !LEAF) as usize
    }
}

impl Node {
    /// A node around boxes, of which the first `inner` are inner nodes.
    pub(super) fn new(boxes: &[Bounds], inner: usize) -> Self {
        let all = boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(b));
        let (origin, top) = (all.low(), all.high());
        let step = Vec3A::from_array(std::array::from_fn(|axis| grid_step(origin[axis], top[axis])));
        let mut planes = [[[0; WIDTH]; 2]; 3];
        for (i, b) in boxes.iter().enumerate() {
            for axis in 0..3 {
                let [lower, upper] = on_grid(b.low()[axis], b.high()[axis], origin[axis], step[axis]);
                planes[axis][0][i] = lower;
                planes[axis][1][i] = upper;
            }
        }
        let count = |n: usize| (n as u32) << INDEX_BITS;
        Self {
            origin: origin.to_array(),
            step: step.to_array(),
            nodes: count(inner),
            leaves: count(boxes.len()),
            planes,
        }
    }

    /// This node with the indices of its first inner child and its first leaf.
    pub(super) fn pointing_to(self, first_node: usize, first_leaf: usize) -> Self {
        Self { nodes: self.nodes | first_node as u32, leaves: self.leaves | first_leaf as u32, ..self }
    }

    /// The box around all children.
    pub(super) fn bounds(&self) -> Bounds {
        self.boxes().fold(Bounds::EMPTY, |all, one| all.union(&one))
    }

    /// Number of children: inner nodes and leaves.
    #[inline(always)]
    fn count(&self) -> u32 {
        self.leaves >> INDEX_BITS
    }

    /// Number of children that are inner nodes: the first.
    pub(super) fn inner_count(&self) -> usize {
        (self.nodes >> INDEX_BITS) as usize
    }

    /// Indices of the first inner node and of the first leaf among its children.
    pub(super) fn first_children(&self) -> (usize, usize) {
        let index = |packed: u32| (packed & (MOST as u32 - 1)) as usize;
        (index(self.nodes), index(self.leaves))
    }

    /// The children in order.
    pub(super) fn children(&self) -> impl Iterator<Item = Child> + '_ {
        (0..self.count()).map(|i| self.child(i))
    }

    /// Boxes of the children, as the grid has them.
    pub(super) fn boxes(&self) -> impl Iterator<Item = Bounds> + '_ {
        (0..self.count() as usize).map(|i| {
            let corner = |side: usize| {
                let at = |axis: usize| on_axis(self.planes[axis][side][i], self.origin[axis], self.step[axis]) as f32;
                Vec3A::new(at(0), at(1), at(2)).extend(0.0)
            };
            Bounds { min: corner(0), max: corner(1) }
        })
    }

    /// Child number `i`, inner nodes first.
    #[inline(always)]
    pub(super) fn child(&self, i: u32) -> Child {
        let inner = self.nodes >> INDEX_BITS;
        let index = |packed: u32| packed & (MOST as u32 - 1);
        Child(if i < inner { index(self.nodes) + i } else { LEAF | (index(self.leaves) + i - inner) })
    }

    /// The boxes that the ray enters before `t_max`, as bits, and the distances at which it does.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, ray: &BoxRay, t_max: f32) -> (u32, f32x8<S>) {
        let mut enter = f32x8::splat(simd, 0.0);
        let mut leave = f32x8::splat(simd, t_max);
        for axis in 0..3 {
            let step = ray.inverse[axis] * self.step[axis];
            let near = (self.origin[axis] - ray.origin_near[axis]) * ray.inverse[axis];
            let far = (self.origin[axis] - ray.origin_far[axis]) * ray.inverse[axis];
            let side = ray.backward[axis] & 1;
            let step = f32x8::splat(simd, step);
            enter = numbers(simd, &self.planes[axis][side]).mul_add(step, f32x8::splat(simd, near)).max(enter);
            leave = numbers(simd, &self.planes[axis][side ^ 1]).mul_add(step, f32x8::splat(simd, far)).min(leave);
        }
        let there = (1 << self.count()) - 1;
        (enter.simd_le(leave).to_bitmask() as u32 & there, enter)
    }
}

#[inline(always)]
fn numbers<S: Simd>(simd: S, planes: &[u8; WIDTH]) -> f32x8<S> {
    let mut numbers = [0.0; WIDTH];
    for i in 0..WIDTH {
        numbers[i] = f32::from(planes[i]);
    }
    f32x8::load_array(simd, numbers)
}

/// The smallest power of two of which 255 steps reach from one end to the other.
fn grid_step(low: f32, high: f32) -> f32 {
    let mut step = ((high - low) / 255.0).max(f32::MIN_POSITIVE).log2().ceil().exp2();
    while on_axis(255, low, step) < f64::from(high) {
        step *= 2.0;
    }
    step
}

fn on_axis(plane: u8, origin: f32, step: f32) -> f64 {
    f64::from(origin) + f64::from(plane) * f64::from(step)
}

/// The planes of the grid just around a range.
fn on_grid(low: f32, high: f32, origin: f32, step: f32) -> [u8; 2] {
    let at = |x: f32| (f64::from(x) - f64::from(origin)) / f64::from(step);
    [at(low).floor() as u8, at(high).ceil() as u8]
}

/// A ray for testing boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxRay {
    // Two starts, a little ahead and a little behind, so that boxes are hit that rounding would miss.
    origin_near: [f32; 3],
    origin_far: [f32; 3],
    inverse: [f32; 3],
    backward: [usize; 3],
}

impl BoxRay {
    /// `direction` has length one.
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A) -> Self {
        // A ray along a plane keeps to it over any distance, and products with the inverse stay finite.
        const STRAIGHT: f32 = 1e-15;
        // -0.0 becomes +0.0: the sign must not depend on it.
        let direction = (direction + Vec3A::ZERO).to_array();
        let inverse = direction.map(|d| 1.0 / if d.abs() < STRAIGHT { STRAIGHT.copysign(d) } else { d });
        let slack = Bounds::SLACK * origin.abs().max_element();
        let shifted = |by: f32| std::array::from_fn(|axis| origin[axis] + by * 1f32.copysign(inverse[axis]));
        Self {
            origin_near: shifted(slack),
            origin_far: shifted(-slack),
            inverse,
            backward: inverse.map(|d| usize::from(d < 0.0)),
        }
    }
}
