//! Building a tree over emitters: halves first, then nodes of eight.

use super::bounds::LightBounds;
use super::receiver::WIDTH;
use glam::Vec3A;

/// Buckets on each axis that a split is tried at.
const BUCKETS: usize = 12;

/// Emitters that are worth the work of several cores.
const LARGE: usize = 4096;

/// Emitters up to which parts are cut so that all but one of the nodes over them are full.
const FULL: usize = 512;

/// Factor by which the cost of a cut that fills nodes may exceed the best.
const WORTH_FULL: f32 = 1.3;

/// The method by which nodes of eight are made of halves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filling {
    /// Each node is opened as far as it goes: the best estimates.
    Loose,
    /// Nodes are few and full: of many, less memory is faster.
    Full,
}

/// Part of a tree of halves.
pub(super) enum Half {
    /// One emitter, by its index.
    Leaf(u32),
    /// The number of emitters in two parts, and these, with the bounds of each.
    Inner(usize, Box<[(LightBounds, Half); 2]>),
}

impl Half {
    /// The tree over the emitters of `order`, at least one.
    pub(super) fn new(emitters: &[LightBounds], order: &mut [u32], filling: Filling) -> (LightBounds, Self) {
        if let [only] = *order {
            return (emitters[only as usize], Self::Leaf(only));
        }
        let is_large = order.len() > LARGE;
        let middle = split(emitters, order, filling);
        let (left, right) = order.split_at_mut(middle);
        let parts = if is_large {
            let both = rayon::join(|| Self::new(emitters, left, filling), || Self::new(emitters, right, filling));
            [both.0, both.1]
        } else {
            [Self::new(emitters, left, filling), Self::new(emitters, right, filling)]
        };
        (parts[0].0.union(&parts[1].0), Self::Inner(order.len(), Box::new(parts)))
    }

    /// Up to eight parts of it: the one that is costliest to leave closed is opened again and again. Full nodes leave closed the parts that
    /// fit into a node of their own; where room is left, parts are put in whole, smallest first, which saves nodes.
    pub(super) fn open(self, whole: LightBounds, filling: Filling) -> Vec<(LightBounds, Self)> {
        let closed = match filling {
            Filling::Loose => 1,
            Filling::Full => WIDTH,
        };
        let mut parts = vec![(whole, self)];
        while parts.len() < WIDTH {
            let room = WIDTH - parts.len();
            let costly = (0..parts.len())
                .filter(|&i| parts[i].1.count() > closed)
                .max_by(|&a, &b| parts[a].0.cost().total_cmp(&parts[b].0.cost()));
            let fitting = || {
                let fits = |i: &usize| (2..=room + 1).contains(&parts[*i].1.count());
                (0..parts.len()).filter(fits).min_by_key(|&i| parts[i].1.count())
            };
            let Some(i) = costly.or_else(fitting) else { break };
            if let (_, Self::Inner(_, two)) = parts.remove(i) {
                parts.extend(*two);
            }
        }
        parts
    }

    /// Number of emitters in the half.
    fn count(&self) -> usize {
        match self {
            Self::Leaf(_) => 1,
            Self::Inner(count, _) => *count,
        }
    }
}

/// Orders emitters so that a good split lies at the returned place, which leaves some on either side.
fn split(emitters: &[LightBounds], order: &mut [u32], filling: Filling) -> usize {
    let center = |i: u32| emitters[i as usize].center();
    let (low, high) =
        order.iter().fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(l, h), &i| (l.min(center(i)), h.max(center(i))));
    let extent = high - low;
    let best = by_buckets(emitters, order, low, extent);
    if filling == Filling::Full && (WIDTH + 1..=FULL).contains(&order.len()) {
        let limit = best.map_or(f32::INFINITY, |(cost, ..)| cost * WORTH_FULL);
        if let Some((_, axis, cut)) = into_full(emitters, order, extent).filter(|found| found.0 <= limit) {
            sort_along(emitters, order, axis);
            return cut;
        }
    }
    let Some((_, axis, cut)) = best else { return order.len() / 2 };
    order.sort_by_key(|&i| bucket(center(i)[axis], low[axis], extent[axis]) >= cut);
    order.iter().take_while(|&&i| bucket(center(i)[axis], low[axis], extent[axis]) < cut).count()
}

/// The cost of the cheapest split between buckets, its axis and the bucket that it lies before.
fn by_buckets(emitters: &[LightBounds], order: &[u32], low: Vec3A, extent: Vec3A) -> Option<(f32, usize, usize)> {
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        for &i in order {
            let b = &mut buckets[bucket(emitters[i as usize].center()[axis], low[axis], extent[axis])];
            *b = Some(b.map_or(emitters[i as usize], |have| have.union(&emitters[i as usize])));
        }
        let join =
            |list: &[Option<LightBounds>]| list.iter().flatten().copied().reduce(|a, b| a.union(&b)).map(|b| b.cost());
        for cut in 1..BUCKETS {
            if let (Some(a), Some(b)) = (join(&buckets[..cut]), join(&buckets[cut..])) {
                // Long boxes are cut across.
                let cost = (a + b) * extent.max_element() / extent[axis];
                if best.is_none_or(|(c, ..)| cost < c) {
                    best = Some((cost, axis, cut));
                }
            }
        }
    }
    best
}

/// The cost, axis and place of the cheapest split that leaves on one side as many emitters as some full nodes hold.
fn into_full(emitters: &[LightBounds], order: &mut [u32], extent: Vec3A) -> Option<(f32, usize, usize)> {
    let full = if order.len() <= WIDTH * WIDTH { WIDTH } else { WIDTH * WIDTH };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        sort_along(emitters, order, axis);
        let join = |list: &[u32]| list.iter().map(|&i| emitters[i as usize]).reduce(|a, b| a.union(&b));
        let parts: Vec<LightBounds> = order.chunks(full).filter_map(join).collect();
        let join = |list: &[LightBounds]| list.iter().copied().reduce(|a, b| a.union(&b)).map(|b| b.cost());
        for cut in 1..parts.len() {
            let (Some(a), Some(b)) = (join(&parts[..cut]), join(&parts[cut..])) else { continue };
            let cost = (a + b) * extent.max_element() / extent[axis];
            if best.is_none_or(|(c, ..)| cost < c) {
                best = Some((cost, axis, cut * full));
            }
        }
    }
    best
}

fn sort_along(emitters: &[LightBounds], order: &mut [u32], axis: usize) {
    let center = |i: u32| emitters[i as usize].center()[axis];
    order.sort_unstable_by(|&a, &b| center(a).total_cmp(&center(b)).then(a.cmp(&b)));
}

fn bucket(x: f32, low: f32, extent: f32) -> usize {
    (((x - low) / extent * BUCKETS as f32) as usize).min(BUCKETS - 1)
}
