//! Choosing one of many emitters by the light that it may send to a place: a tree whose nodes bound position,
//! power and direction (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", without the splitting), eight children a node, weighed at once in the lanes of a register.

use super::bounds::LightBounds;
use super::build::{Filling, Half};
use super::node::{Child, NONE, Node, PackedChild};
use super::receiver::{LightSampleContext, NO_INSTANCE, WIDTH};
use crate::scene::motion::MIDDLE;
use glam::Vec3A;

/// Emitters up to which a tree is as good as it gets, and no larger than a cache.
const FEW: usize = 1024;

/// The part of its weight that an emitter keeps where it would light another place of the instance that it is a part of, which emits itself:
/// the light there is at most a part of the place's emission, and where the instance bulges there is none.
const OWN_LIGHT: f32 = 0.02;

/// The tree over all emitters of a scene.
#[derive(Clone, Debug)]
pub struct LightTree {
    nodes: Vec<Node>,
    // By node, the one above and which of its children it is.
    parents: Vec<(u32, u32)>,
    // By emitter, its node and which child it is; `NONE` where it emits nothing.
    place_of: Vec<(u32, u32)>,
    // By node, the instances that its children are parts of; `NO_INSTANCE` of lamps and of what is of several. Apart from the nodes: only
    // places that emit themselves ask.
    owners: Vec<[u32; WIDTH]>,
    // Of the root's children those that are near are weighed by what is in them.
    looks_ahead: bool,
}

impl LightTree {
    /// The tree of these emitters, parts of instances by `owners`; `None` if none of them emits.
    pub fn new(emitters: &[LightBounds], owners: &[u32]) -> Option<Self> {
        let mut order: Vec<u32> = (0..emitters.len() as u32).filter(|&i| emitters[i as usize].power > 0.0).collect();
        if order.is_empty() {
            return None;
        }
        let is_many = order.len() > FEW;
        let filling = if is_many { Filling::Full } else { Filling::Loose };
        let (bounds, halves) = Half::new(emitters, &mut order, filling);
        let mut tree = Self {
            nodes: Vec::new(),
            parents: Vec::new(),
            place_of: vec![(NONE, 0); emitters.len()],
            owners: Vec::new(),
            looks_ahead: is_many,
        };
        tree.add(halves, bounds, (NONE, 0), filling);
        tree.owners = tree.owners_of_nodes(owners);
        Some(tree)
    }

    /// Adds a part of the tree; gives the number of its root.
    fn add(&mut self, part: Half, bounds: LightBounds, parent: (u32, u32), filling: Filling) -> u32 {
        let here = self.nodes.len() as u32;
        let (bounds, parts): (Vec<LightBounds>, Vec<Half>) = part.open(bounds, filling).into_iter().unzip();
        self.nodes.push(Node::new(&bounds));
        self.parents.push(parent);
        for (lane, (part, bounds)) in parts.into_iter().zip(bounds).enumerate() {
            let place = (here, lane as u32);
            self.nodes[here as usize].children[lane] = match part {
                Half::Leaf(emitter) => {
                    self.place_of[emitter as usize] = place;
                    PackedChild::emitter(emitter)
                }
                inner => PackedChild::node(self.add(inner, bounds, place, filling)),
            };
        }
        here
    }

    /// The instances that the children of each node are parts of.
    fn owners_of_nodes(&self, of_emitters: &[u32]) -> Vec<[u32; WIDTH]> {
        let mut all = vec![[NO_INSTANCE; WIDTH]; self.nodes.len()];
        // Nodes come before those under them.
        for number in (0..self.nodes.len()).rev() {
            for lane in 0..WIDTH {
                all[number][lane] = match self.nodes[number].children[lane].open() {
                    Child::Nothing => NO_INSTANCE,
                    Child::Emitter(emitter) => of_emitters[emitter as usize],
                    Child::Node(next) => {
                        let children = &self.nodes[next as usize].children;
                        let filled = children.iter().filter(|child| child.open() != Child::Nothing).count();
                        let first = all[next as usize][0];
                        let is_one = all[next as usize][..filled].iter().all(|owner| *owner == first);
                        if is_one { first } else { NO_INSTANCE }
                    }
                };
            }
        }
        all
    }

    /// The light that the children of a node may send to a place.
    #[inline(always)]
    fn weights(&self, node: usize, position: Vec3A, normal: Option<Vec3A>, emitter: u32) -> [f32; WIDTH] {
        let mut weights = self.nodes[node].importances(position, normal);
        if emitter != NO_INSTANCE {
            for (weight, owner) in weights.iter_mut().zip(self.owners[node]) {
                *weight *= if owner == emitter { OWN_LIGHT } else { 1.0 };
            }
        }
        weights
    }

    /// A place, and the light that the parts under the root may send there. The sky has no probability yet.
    pub(super) fn receiver(&self, position: Vec3A, normal: Option<Vec3A>, emitter: u32) -> LightSampleContext {
        let weights = if self.looks_ahead {
            self.ahead(position, normal, emitter)
        } else {
            self.weights(0, position, normal, emitter)
        };
        LightSampleContext {
            position,
            normal,
            tree: 0,
            emitter,
            total: sum(&weights),
            weights,
            sky: 0.0,
            sky_chance: 0.0,
            moment: MIDDLE,
            is_compensated: false,
        }
    }

    /// The light that the root's children may send somewhere, by their own children where they are near: with many emitters nearly all of
    /// the uncertainty is there.
    #[inline]
    fn ahead(&self, position: Vec3A, normal: Option<Vec3A>, emitter: u32) -> [f32; WIDTH] {
        let root = &self.nodes[0];
        let mut weights = self.weights(0, position, normal, emitter);
        let mut near = root.near(position);
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            if let Child::Node(node) = root.children[lane].open() {
                weights[lane] = sum(&self.weights(node as usize, position, normal, emitter));
            }
        }
        weights
    }

    /// An emitter and the probability of its choice; `None` where none may send light.
    pub fn sample(&self, to: &LightSampleContext, mut u: f32) -> Option<(usize, f32)> {
        let mut node = 0;
        let mut probability = 1.0;
        let (mut weights, mut total) = (to.weights, to.total);
        loop {
            if !(total > 0.0 && total.is_finite()) {
                return None;
            }
            let mut left = u * total;
            let mut lane = 0;
            while lane < WIDTH - 1 && left >= weights[lane] {
                left -= weights[lane];
                lane += 1;
            }
            // Rounding may have gone past the last that has any.
            while weights[lane] <= 0.0 {
                lane = lane.checked_sub(1)?;
                left = weights[lane];
            }
            probability *= weights[lane] / total;
            u = (left / weights[lane]).clamp(0.0, 1.0 - f32::EPSILON);
            match self.nodes[node].children[lane].open() {
                Child::Nothing => return None,
                Child::Node(next) => node = next as usize,
                Child::Emitter(emitter) => return (probability > 0.0).then_some((emitter as usize, probability)),
            }
            weights = self.weights(node, to.position, to.normal, to.emitter);
            total = sum(&weights);
        }
    }

    /// The probability of [`LightTree::sample`] choosing an emitter.
    pub fn probability(&self, to: &LightSampleContext, emitter: usize) -> f32 {
        let mut place = self.place_of[emitter];
        if place.0 == NONE {
            return 0.0;
        }
        let mut probability = 1.0;
        loop {
            let is_root = place.0 == 0;
            let weights = || self.weights(place.0 as usize, to.position, to.normal, to.emitter);
            let weights = if is_root { to.weights } else { weights() };
            let total = if is_root { to.total } else { sum(&weights) };
            if !(total > 0.0 && total.is_finite()) {
                return 0.0;
            }
            probability *= weights[place.1 as usize] / total;
            if is_root {
                return probability;
            }
            place = self.parents[place.0 as usize];
        }
    }
}

/// The sum in one fixed order, so that choices and their probabilities agree.
#[inline]
fn sum(weights: &[f32; WIDTH]) -> f32 {
    let [a, b, c, d, e, f, g, h] = *weights;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::warp::sample_sphere;
    use petzval_testkit::sampling;
    use std::f32::consts::{FRAC_PI_2, PI};

    fn emitters(n: u32) -> Vec<LightBounds> {
        (0..n)
            .map(|i| {
                let u = sobol_burley::sample_4d(i, 0, 1);
                let v = sobol_burley::sample_4d(i, 0, 2);
                let p = Vec3A::new(u[0], u[1], u[2]) * 10.0 - Vec3A::splat(5.0);
                let point = i % 5 == 0;
                LightBounds {
                    min: p,
                    max: p + Vec3A::splat(if point { 0.0 } else { 0.1 * v[3] }),
                    power: if i % 7 == 0 { 0.0 } else { u[3] },
                    axis: sample_sphere([v[0], v[1]]),
                    normal_spread_rad: if point { PI } else { 0.0 },
                    emission_spread_rad: FRAC_PI_2,
                    two_sided: i % 3 == 0,
                }
            })
            .collect()
    }

    fn receivers(tree: &LightTree) -> impl Iterator<Item = LightSampleContext> {
        (0..50).map(|i| {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let v = sobol_burley::sample_4d(i, 0, 4);
            let position = Vec3A::new(u[0], u[1], u[2]) * 14.0 - Vec3A::splat(7.0);
            // Some of the places are on what emits.
            let emitter = if i % 3 == 0 { i % 5 } else { NO_INSTANCE };
            tree.receiver(position, (i % 2 == 0).then(|| sample_sphere([v[0], v[1]])), emitter)
        })
    }

    /// Probabilities add to one, and choices follow them.
    #[test]
    fn choices_follow_their_probabilities() {
        for n in [1, 2, 3, 100, 3000] {
            let list = emitters(n);
            let owners: Vec<u32> = (0..list.len() as u32).map(|i| i / 40).collect();
            let Some(tree) = LightTree::new(&list, &owners) else { continue };
            for to in receivers(&tree) {
                let p: Vec<f32> = (0..list.len()).map(|i| tree.probability(&to, i)).collect();
                let mut counts = vec![0u64; list.len()];
                let samples = 4000;
                let mut refused = 0;
                for k in 0..samples {
                    match tree.sample(&to, (k as f32 + 0.5) / samples as f32) {
                        Some((i, probability)) => {
                            counts[i] += 1;
                            assert!((probability / p[i] - 1.0).abs() < 1e-3);
                        }
                        None => refused += 1,
                    }
                }
                let total: f32 = p.iter().sum();
                assert!(total < 1.0 + 1e-4);
                // Stratified numbers: each count is within a piece or so of its share.
                for (c, p) in counts.iter().zip(&p) {
                    assert!((*c as f32 / samples as f32 - p).abs() < 2e-3, "{c} {p}");
                }
                assert!((total + refused as f32 / samples as f32 - 1.0).abs() < 2e-3);
                let probabilities: Vec<f64> = p.iter().copied().map(f64::from).collect();
                sampling::choices(&format!("light tree of {n}, {to:?}"), 1 << 14, &probabilities, |random| {
                    Some(tree.sample(&to, random.numbers::<1>()[0])?.0)
                });
            }
        }
    }

    /// Every emitter that can send light has a probability: no bound may rule it out.
    #[test]
    fn nothing_that_shines_is_ruled_out() {
        for list in [emitters(100), emitters(3000)] {
            let tree = LightTree::new(&list, &vec![NO_INSTANCE; list.len()]).unwrap();
            for to in receivers(&tree) {
                for (i, e) in list.iter().enumerate().filter(|(_, e)| e.power > 0.0) {
                    let d = (to.position - e.center()).normalize();
                    let mut cos = e.axis.dot(d);
                    if e.two_sided {
                        cos = cos.abs();
                    }
                    let reaches = e.normal_spread_rad >= PI || cos > 0.0;
                    let seen = to.normal.is_none_or(|n| n.dot(-d) > 0.0);
                    if reaches && seen {
                        assert!(tree.probability(&to, i) > 0.0, "{i} from {to:?}");
                    }
                }
            }
        }
    }

    /// Lamps with narrow cones downwards are found from all places within their cones, and many of them from few places.
    #[test]
    fn narrow_cones_rule_out_what_is_beside_them() {
        let mut list = emitters(3000);
        for e in &mut list {
            (e.power, e.axis, e.normal_spread_rad, e.emission_spread_rad) = (1.0, Vec3A::NEG_Z, 0.0, 0.3);
            (e.max, e.two_sided) = (e.min, false);
        }
        let tree = LightTree::new(&list, &vec![NO_INSTANCE; list.len()]).unwrap();
        let floor = |u: f32, v: f32| Vec3A::new(u * 8.0 - 4.0, v * 8.0 - 4.0, -5.5);
        for k in 0..20 {
            let u = sobol_burley::sample_4d(k, 0, 5);
            let to = tree.receiver(floor(u[0], u[1]), Some(Vec3A::Z), NO_INSTANCE);
            let mut chance_of_dark = 0.0;
            for (i, e) in list.iter().enumerate() {
                let d = (to.position - e.min).normalize();
                let chance = tree.probability(&to, i);
                if d.dot(e.axis) > 0.3f32.cos() {
                    assert!(chance > 0.0);
                } else {
                    chance_of_dark += chance;
                }
            }
            // Without cones nine tenths of them were dark.
            assert!(chance_of_dark < 0.3, "{chance_of_dark}");
        }
    }

    /// A place that emits leaves its light samples to emitters of other instances, but not all of them.
    #[test]
    fn own_light_is_chosen_seldom() {
        // Around the place the emitters of instance 7, far away strong ones.
        let near = |one: LightBounds| LightBounds { min: one.min * 0.05, max: one.max * 0.05, power: 1.0, ..one };
        let away = Vec3A::splat(20.0);
        let far = |one: LightBounds| LightBounds { min: one.min + away, max: one.max + away, power: 1000.0, ..one };
        let list: Vec<LightBounds> =
            emitters(500).into_iter().map(near).chain(emitters(500).into_iter().map(far)).collect();
        let owners = [[7; 500], [NO_INSTANCE; 500]].concat();
        let tree = LightTree::new(&list, &owners).unwrap();
        let own = |emitter: u32| -> f32 {
            let to = tree.receiver(Vec3A::ZERO, None, emitter);
            (0..500).map(|i| tree.probability(&to, i)).sum()
        };
        let (elsewhere, here) = (own(NO_INSTANCE), own(7));
        assert!(elsewhere > 0.5 && here > 0.0 && here < 0.3, "{elsewhere} {here}");
    }

    /// A tree over many emitters has few nodes, and those over emitters are nearly full.
    #[test]
    fn nodes_over_many_are_full() {
        let tree = LightTree::new(&emitters(10_000), &[NO_INSTANCE; 10_000]).unwrap();
        let shining = tree.place_of.iter().filter(|place| place.0 != NONE).count();
        // At the least a seventh: each node but the root takes a lane of another.
        assert!(tree.nodes.len() < shining / 4, "{} over {shining}", tree.nodes.len());
        assert_eq!(tree.nodes.len(), tree.parents.len());
    }

    #[test]
    fn a_dark_scene_has_no_tree() {
        assert!(LightTree::new(&[], &[]).is_none());
        assert!(LightTree::new(&[LightBounds { power: 0.0, ..emitters(2)[1] }], &[NO_INSTANCE]).is_none());
    }
}
