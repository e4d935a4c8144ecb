//! Following a ray through a tree, near boxes first.

use super::node::{BoxRay, Child, Node};
use arrayvec::ArrayVec;
use fearless_simd::{Simd, SimdBase};
use std::ops::ControlFlow;

/// No tree is deeper: see [`super::build`].
pub(super) const DEEPEST: usize = 72;
/// Each level leaves at most seven children for later.
const STACK: usize = DEEPEST * (super::node::WIDTH - 1);

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
