//! Following a ray through a tree, near boxes first.

use super::node::{BoxRay, Child, Node};
use super::triangles::{Block, Met, Shear};
use arrayvec::ArrayVec;
use fearless_simd::{Simd, SimdBase};
use glam::Vec3A;
use std::ops::ControlFlow;

/// No tree is deeper: see [`super::build`].
pub(super) const DEEPEST: usize = 72;
/// Each level leaves at most seven children for later.
const STACK: usize = DEEPEST * (super::node::WIDTH - 1);

/// A ray as one tree's tests want it.
pub(super) struct TreeRay {
    pub(super) boxes: BoxRay,
    pub(super) shear: Shear,
}

impl TreeRay {
    /// `direction` has length one.
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A) -> Self {
        Self { boxes: BoxRay::new(origin, direction), shear: Shear::new(origin, direction) }
    }
}

/// Triangles and the nodes above them.
#[derive(Debug, Default)]
pub(super) struct TriangleTree {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<Block>,
    /// Sum of half of the surface of all boxes when the tree was built.
    pub(super) surface: f32,
}

/// A triangle that a ray hits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) t: f32,
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) instance: u32,
    pub(super) triangle: u32,
}

impl TriangleTree {
    /// The nearest triangle before `t_max` that is wanted, by its instance and number.
    #[inline(always)]
    pub(super) fn closest<S: Simd>(
        &self,
        simd: S,
        ray: &TreeRay,
        t_max: f32,
        wanted: impl Fn(u32, u32) -> bool,
    ) -> Option<Found> {
        let mut nearest = None;
        let _ = traverse(
            simd,
            &self.nodes,
            &ray.boxes,
            t_max,
            #[inline(always)]
            |leaf, mut t_max| {
                let block = &self.blocks[leaf];
                if let Some(met) = block.meet(simd, &ray.shear, t_max) {
                    for lane in lanes(met.lanes) {
                        if met.t[lane] < t_max && wanted(block.instance[lane], block.triangle[lane]) {
                            t_max = met.t[lane];
                            nearest = Some(found(block, &met, lane));
                        }
                    }
                }
                ControlFlow::Continue(t_max)
            },
        );
        nearest
    }

    /// Every triangle before `t_max`, in no order, until `on_hit` breaks off.
    #[inline(always)]
    pub(super) fn visit<S: Simd>(
        &self,
        simd: S,
        ray: &TreeRay,
        t_max: f32,
        mut on_hit: impl FnMut(Found) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        traverse(
            simd,
            &self.nodes,
            &ray.boxes,
            t_max,
            #[inline(always)]
            |leaf, t_max| {
                let block = &self.blocks[leaf];
                if let Some(met) = block.meet(simd, &ray.shear, t_max) {
                    for lane in lanes(met.lanes) {
                        on_hit(found(block, &met, lane))?;
                    }
                }
                ControlFlow::Continue(t_max)
            },
        )
    }
}

#[inline(always)]
fn found(block: &Block, met: &Met, lane: usize) -> Found {
    Found {
        t: met.t[lane],
        u: met.u[lane],
        v: met.v[lane],
        instance: block.instance[lane],
        triangle: block.triangle[lane],
    }
}

/// The numbers of the bits that are set, below eight.
#[inline(always)]
pub(super) fn lanes(bits: u32) -> impl Iterator<Item = usize> {
    let mut left = bits;
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let next = (left != 0).then(|| left.trailing_zeros() as usize & 7);
            left &= left.wrapping_sub(1);
            next
        },
    )
}

/// Offers the leaves whose boxes the ray hits before `t_max` to `leaf`, roughly near ones first; it gives the end of
/// the ray from then on.
#[inline(always)]
pub(super) fn traverse<S: Simd>(
    simd: S,
    nodes: &[Node],
    ray: &BoxRay,
    mut t_max: f32,
    mut leaf: impl FnMut(usize, f32) -> ControlFlow<(), f32>,
) -> ControlFlow<()> {
    if nodes.is_empty() {
        return ControlFlow::Continue(());
    }
    // Distances in the upper half, children in the lower: positive floats are ordered as their bits are. The
    // nearest is on top.
    let mut stack = ArrayVec::<u64, STACK>::new();
    let mut child = Child::ROOT;
    loop {
        if child.is_leaf() {
            t_max = leaf(child.index(), t_max)?;
        } else {
            let node = &nodes[child.index()];
            let (mut hits, enter) = node.meet(simd, ray, t_max);
            if hits != 0 {
                let first = hits.trailing_zeros();
                hits &= hits - 1;
                if hits == 0 {
                    child = node.child(first);
                    continue;
                }
                let enter = enter.to_array();
                let entry = |i: u32| u64::from(enter[i as usize & 7].to_bits()) << 32 | u64::from(node.child(i).0);
                let mut nearest = entry(first);
                let below = stack.len();
                while hits != 0 {
                    let next = entry(hits.trailing_zeros());
                    hits &= hits - 1;
                    let farther = nearest.max(next);
                    nearest = nearest.min(next);
                    stack.push(farther);
                    let mut i = stack.len() - 1;
                    while i > below && stack[i - 1] < farther {
                        stack[i] = stack[i - 1];
                        i -= 1;
                    }
                    stack[i] = farther;
                }
                child = Child(nearest as u32);
                continue;
            }
        }
        child = loop {
            let Some(next) = stack.pop() else { return ControlFlow::Continue(()) };
            if f32::from_bits((next >> 32) as u32) <= t_max {
                break Child(next as u32);
            }
        };
    }
}
