//! Building a tree: boxes are parted by the surface area heuristic over bins (Wald 2007), and opened until a node has
//! eight children. The result does not depend on the number of threads.

use super::bounds::Bounds;
use super::node::{MOST, Node, WIDTH};
use arrayvec::ArrayVec;
use glam::Vec4;
use rayon::prelude::*;
use std::ops::Range;

/// Bins along each axis; a power of two.
const BINS: usize = 16;
/// The depth below which boxes are parted by number alone: 2^32 of them need 32 levels more.
const DEEP: usize = super::traverse::DEEPEST - 32;
/// The number of boxes from which on another thread pays.
const PARALLEL: usize = 4096;
/// Number of boxes that a thread sorts into bins at a time, where a span is so long that threads share it.
const STRETCH: usize = 1 << 14;

/// The contents of one leaf are parted into two if the areas of these come to less than this share of the leaf's: one
/// large triangle apart from small ones. Above 0.9 leaves are half empty and take more memory than rays save.
const WORTH_PARTING: f32 = 0.8;

/// A tree's nodes, and which of the boxes, in their new order, each leaf holds.
pub(super) struct Built {
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<Range<usize>>,
}

/// Builds a tree over boxes, which are brought into the order of its leaves, `most` in each at most.
pub(super) fn build(items: &mut [Bounds], most: usize) -> Built {
    let mut built = Built { nodes: vec![], leaves: vec![] };
    if items.is_empty() {
        return built;
    }
    let span = Span::new(items, 0);
    let root = Branch::new(span, most, 0);
    built.nodes.push(root.node);
    root.write(0, &mut built);
    assert!(built.nodes.len() < MOST && built.leaves.len() < MOST, "a tree of {} leaves", built.leaves.len());
    built
}

/// A tree whose leaves are lists of names.
pub(super) struct NamedLeaves {
    pub(super) nodes: Vec<Node>,
    names: Vec<[u32; 2]>,
    leaves: Vec<Range<usize>>,
}

impl NamedLeaves {
    /// Builds a tree over those boxes that are within reach, known by their index, `most` in each leaf at most.
    pub(super) fn new(mut boxes: Vec<Bounds>, most: usize) -> Self {
        boxes.retain(Bounds::is_within_reach);
        let Built { nodes, leaves } = build(&mut boxes, most);
        // The boxes take four times the memory of their names, and what leaves hold is yet to come.
        let names = boxes.iter().map(Bounds::name).collect();
        Self { nodes, names, leaves }
    }

    /// The results of a function of the names in each leaf, in the order of the leaves.
    pub(super) fn leaves<T: Send>(&self, make: impl Fn(&[[u32; 2]]) -> T + Sync) -> Vec<T> {
        self.leaves.par_iter().map(|leaf| make(&self.names[leaf.clone()])).collect()
    }
}

/// A node before it is known where its children will be.
struct Branch {
    node: Node,
    inner: Vec<Branch>,
    leaves: ArrayVec<Range<usize>, WIDTH>,
}

impl Branch {
    fn new(span: Span, most: usize, depth: usize) -> Self {
        let large = span.items.len() > PARALLEL;
        let parts = open(span, most, depth >= DEEP);
        let boxes: ArrayVec<Bounds, WIDTH> = parts.iter().map(|part| part.bounds).collect();
        let count = parts.iter().take_while(|part| part.items.len() > most).count();
        let leaves = parts[count..].iter().map(|part| part.first..part.first + part.items.len()).collect();
        let go_on = |part| Self::new(part, most, depth + 1);
        let parts: Vec<Span> = parts.into_iter().take(count).collect();
        let inner =
            if large { parts.into_par_iter().map(go_on).collect() } else { parts.into_iter().map(go_on).collect() };
        Self { node: Node::new(&boxes, count), inner, leaves }
    }

    fn write(self, at: usize, built: &mut Built) {
        let first = built.nodes.len();
        built.nodes[at] = self.node.pointing_to(first, built.leaves.len());
        built.leaves.extend(self.leaves);
        built.nodes.extend(self.inner.iter().map(|branch| branch.node));
        for (i, branch) in self.inner.into_iter().enumerate() {
            branch.write(first + i, built);
        }
    }
}

/// A run of boxes that stand one after the other, of which a subtree is built.
struct Span<'a> {
    items: &'a mut [Bounds],
    first: usize,
    bounds: Bounds,
    /// The box around the middles of the items.
    middles: Bounds,
}

impl<'a> Span<'a> {
    fn new(items: &'a mut [Bounds], first: usize) -> Self {
        let (mut bounds, mut middles) = (Bounds::EMPTY, Bounds::EMPTY);
        for item in items.iter() {
            bounds = bounds.union(item);
            middles = middles.with(item.middle());
        }
        Self { items, first, bounds, middles }
    }

    /// Divides the span into two parts; gives it back where that does not pay.
    fn split(self, most: usize, by_number: bool) -> Result<[Self; 2], Self> {
        let must = self.items.len() > most;
        let best = if by_number { None } else { Bins::new(&self).best(most) };
        match best {
            Some(cut) if must || cut.cost < WORTH_PARTING * self.bounds.half_area() => Ok(self.cut(&cut)),
            None if must => {
                let half = self.items.len() / 2;
                let (a, b) = self.items.split_at_mut(half);
                Ok([Self::new(a, self.first), Self::new(b, self.first + half)])
            }
            _ => Err(self),
        }
    }

    fn cut(self, cut: &SplitPlane) -> [Self; 2] {
        let grid = BinGrid::new(&self.middles);
        let (mut low, mut high) = (Bounds::EMPTY, Bounds::EMPTY);
        let (mut i, mut end) = (0, self.items.len());
        while i < end {
            let middle = self.items[i].middle();
            if grid.bins(middle)[cut.axis] < cut.bin {
                low = low.with(middle);
                i += 1;
            } else {
                high = high.with(middle);
                end -= 1;
                self.items.swap(i, end);
            }
        }
        let (a, b) = self.items.split_at_mut(i);
        [
            Self { items: a, first: self.first, bounds: cut.bounds[0], middles: low },
            Self { items: b, first: self.first + i, bounds: cut.bounds[1], middles: high },
        ]
    }
}

/// Up to eight parts of a span, those with more than `most` boxes first.
fn open(span: Span, most: usize, by_number: bool) -> ArrayVec<Span, WIDTH> {
    let mut open = ArrayVec::<Span, WIDTH>::new();
    let mut closed = ArrayVec::<Span, WIDTH>::new();
    open.push(span);
    while open.len() + closed.len() < WIDTH {
        // The one that rays meet most often; those that can stay leaves come last.
        let rank = |span: &Span| (span.items.len() > most, span.bounds.half_area());
        let Some(i) = (0..open.len()).max_by(|&i, &j| {
            let (a, b) = (rank(&open[i]), rank(&open[j]));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        }) else {
            break;
        };
        match open.remove(i).split(most, by_number) {
            Ok(parts) => open.extend(parts),
            Err(whole) => closed.push(whole),
        }
    }
    let (large, small): (Vec<Span>, Vec<Span>) = open.into_iter().chain(closed).partition(|s| s.items.len() > most);
    large.into_iter().chain(small).collect()
}

/// The bins by which the middles of boxes are sorted.
struct BinGrid {
    low: Vec4,
    scale: Vec4,
}

impl BinGrid {
    fn new(middles: &Bounds) -> Self {
        let size = middles.max - middles.min;
        let scale = Vec4::select(size.cmpgt(Vec4::ZERO), Vec4::splat((BINS - 1) as f32) / size, Vec4::ZERO);
        // So small a size that its inverse is infinite tells no middles apart.
        let scale = Vec4::select(scale.cmplt(Vec4::splat(f32::MAX)), scale, Vec4::ZERO);
        Self { low: middles.min, scale }
    }

    #[inline(always)]
    fn bins(&self, middle: Vec4) -> [usize; 4] {
        // Added to this, a small number's whole part is the lowest bits.
        const WHOLE: f32 = 8_388_608.0;
        let at = (middle - self.low) * self.scale + Vec4::splat(WHOLE);
        at.to_array().map(|x| x.to_bits() as usize & (BINS - 1))
    }
}

struct Bins {
    bounds: [[Bounds; BINS]; 3],
    count: [[u32; BINS]; 3],
}

/// A plane between two bins.
struct SplitPlane {
    axis: usize,
    /// The first bin above it.
    bin: usize,
    /// Sum over both sides of area and number of leaves.
    cost: f32,
    bounds: [Bounds; 2],
}

impl Bins {
    const EMPTY: Self = Self { bounds: [[Bounds::EMPTY; BINS]; 3], count: [[0; BINS]; 3] };

    fn new(span: &Span) -> Self {
        let grid = BinGrid::new(&span.middles);
        if span.items.len() <= 2 * STRETCH {
            return Self::of(&grid, span.items);
        }
        // The first cuts of a large tree, of which there are too few for the threads.
        let stretches = span.items.par_chunks(STRETCH).map(|items| Self::of(&grid, items));
        stretches.reduce(|| Self::EMPTY, Self::with)
    }

    fn of(grid: &BinGrid, items: &[Bounds]) -> Self {
        let mut out = Self::EMPTY;
        for item in items {
            let bins = grid.bins(item.middle());
            for (axis, &bin) in bins[..3].iter().enumerate() {
                out.bounds[axis][bin] = out.bounds[axis][bin].union(item);
                out.count[axis][bin] += 1;
            }
        }
        out
    }

    /// These bins with the boxes of others: the same in whatever order.
    fn with(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(&other.bounds[axis][bin]);
                self.count[axis][bin] += other.count[axis][bin];
            }
        }
        self
    }

    /// The cheapest cut with something on either side.
    fn best(&self, most: usize) -> Option<SplitPlane> {
        let mut best: Option<SplitPlane> = None;
        let leaves = |count: u32| (count as usize).div_ceil(most) as f32;
        for axis in 0..3 {
            let mut above = [(Bounds::EMPTY, 0); BINS];
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for bin in (1..BINS).rev() {
                bounds = bounds.union(&self.bounds[axis][bin]);
                count += self.count[axis][bin];
                above[bin] = (bounds, count);
            }
            (bounds, count) = (Bounds::EMPTY, 0);
            for (bin, above) in above.iter().enumerate().skip(1) {
                bounds = bounds.union(&self.bounds[axis][bin - 1]);
                count += self.count[axis][bin - 1];
                if count == 0 || above.1 == 0 {
                    continue;
                }
                let cost = bounds.half_area() * leaves(count) + above.0.half_area() * leaves(above.1);
                if best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(SplitPlane { axis, bin, cost, bounds: [bounds, above.0] });
                }
            }
        }
        best
    }
}
