//! Building a tree over emitters: halves first, then nodes of eight.

use super::bounds::LightBounds;
use glam::Vec3A;

/// Buckets on each axis that a split is tried at.
const BUCKETS: usize = 12;

/// Emitters that are worth the work of several cores.
const LARGE: usize = 4096;

/// Part of a tree of halves.
pub(super) enum Half {
    /// An emitter.
    Leaf(u32),
    /// Two parts, with the bounds of each.
    Inner(Box<[(LightBounds, Half); 2]>),
}

impl Half {
    /// The tree over the emitters of `order`, at least one.
    pub(super) fn new(emitters: &[LightBounds], order: &mut [u32]) -> (LightBounds, Self) {
        if let [only] = *order {
            return (emitters[only as usize], Self::Leaf(only));
        }
        let is_large = order.len() > LARGE;
        let middle = split(emitters, order);
        let (left, right) = order.split_at_mut(middle);
        let parts = if is_large {
            let both = rayon::join(|| Self::new(emitters, left), || Self::new(emitters, right));
            [both.0, both.1]
        } else {
            [Self::new(emitters, left), Self::new(emitters, right)]
        };
        (parts[0].0.union(&parts[1].0), Self::Inner(Box::new(parts)))
    }

    /// Up to `most` parts of it, by opening again and again the one that is costliest to leave closed.
    pub(super) fn open(self, whole: LightBounds, most: usize) -> Vec<(LightBounds, Self)> {
        let mut parts = vec![(whole, self)];
        while parts.len() < most {
            let costly = (0..parts.len())
                .filter(|&i| matches!(parts[i].1, Self::Inner(_)))
                .max_by(|&a, &b| parts[a].0.cost().total_cmp(&parts[b].0.cost()));
            let Some(i) = costly else { break };
            if let (_, Self::Inner(two)) = parts.remove(i) {
                parts.extend(*two);
            }
        }
        parts
    }
}

/// Orders emitters so that a good split lies at the returned place, which leaves some on either side.
fn split(emitters: &[LightBounds], order: &mut [u32]) -> usize {
    let center = |i: u32| emitters[i as usize].center();
    let (low, high) =
        order.iter().fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(l, h), &i| (l.min(center(i)), h.max(center(i))));
    let extent = high - low;
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        for &i in order.iter() {
            let b = &mut buckets[bucket(center(i)[axis], low[axis], extent[axis])];
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
    let Some((_, axis, cut)) = best else { return order.len() / 2 };
    order.sort_by_key(|&i| bucket(center(i)[axis], low[axis], extent[axis]) >= cut);
    order.iter().take_while(|&&i| bucket(center(i)[axis], low[axis], extent[axis]) < cut).count()
}

fn bucket(x: f32, low: f32, extent: f32) -> usize {
    (((x - low) / extent * BUCKETS as f32) as usize).min(BUCKETS - 1)
}
