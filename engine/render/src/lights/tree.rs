//! Choosing one of many emitters by how much light it may send to a place: a tree whose nodes bound position,
//! power and direction (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", without the splitting).

use glam::Vec3A;
use std::f32::consts::{FRAC_PI_2, PI};

/// Buckets on each axis that a split is tried at.
const BUCKETS: usize = 12;

/// Where light is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Render space.
    pub position: Vec3A,
    /// The normal of a surface that light from behind does not matter to; `None` takes light from all sides.
    pub normal: Option<Vec3A>,
}

/// What is known of an emitter, or of all emitters under a node.
#[derive(Clone, Copy, Debug)]
pub struct LightBounds {
    /// Least corner of the box.
    pub min: Vec3A,
    /// Greatest corner.
    pub max: Vec3A,
    /// Emitted power, any unit.
    pub power: f32,
    /// Middle of the emitters' normals.
    pub axis: Vec3A,
    /// Largest angle of a normal to the axis.
    pub normal_spread_rad: f32,
    /// Largest angle of light to its emitter's normal.
    pub emission_spread_rad: f32,
    /// Light also leaves backwards.
    pub two_sided: bool,
}

impl LightBounds {
    /// The smallest bounds around both.
    fn union(&self, other: &Self) -> Self {
        let (axis, normal_spread_rad) =
            join_cones((self.axis, self.normal_spread_rad), (other.axis, other.normal_spread_rad));
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            power: self.power + other.power,
            axis,
            normal_spread_rad,
            emission_spread_rad: self.emission_spread_rad.max(other.emission_spread_rad),
            two_sided: self.two_sided || other.two_sided,
        }
    }

    fn center(&self) -> Vec3A {
        0.5 * (self.min + self.max)
    }

    /// Cost of a node in a split: power times the measure of where it is and where it shines to.
    fn cost(&self) -> f32 {
        let d = self.max - self.min;
        let area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
        let (o, e) = (self.normal_spread_rad, (self.normal_spread_rad + self.emission_spread_rad).min(PI));
        // Solid angle of the cone of normals, and of the falling-off rim about it.
        let rim = 2.0 * e * o.sin() - (o - 2.0 * e).cos() - 2.0 * o * o.sin() + o.cos();
        let directions = 2.0 * PI * (1.0 - o.cos()) + FRAC_PI_2 * rim;
        // A flat or single-point node still has a cost: half of its diagonal squared is its least area.
        self.power * directions * area.max(0.5 * d.length_squared())
    }

    /// A bound, nearly, of the light that may reach a place.
    fn importance(&self, to: &Receiver) -> f32 {
        let center = self.center();
        let half_diagonal2 = 0.25 * (self.max - self.min).length_squared();
        let offset = to.position - center;
        let d2 = offset.length_squared();
        let away = offset.try_normalize();
        // Angle that the box fills, seen from the place: from inside, everything.
        let inside = d2 <= half_diagonal2;
        let (sin_b, cos_b) = if inside {
            (0.0, -1.0)
        } else {
            let sin2 = half_diagonal2 / d2;
            (sin2.sqrt(), (1.0 - sin2).max(0.0).sqrt())
        };
        let mut importance = self.power / d2.max(half_diagonal2).max(1e-20);
        let Some(away) = away else { return importance };
        if !inside {
            let mut cos_w = self.axis.dot(away).clamp(-1.0, 1.0);
            if self.two_sided {
                cos_w = cos_w.abs();
            }
            // Least angle between any normal and any direction to the place.
            let (sin_o, cos_o) = self.normal_spread_rad.sin_cos();
            let sin_w = (1.0 - cos_w * cos_w).max(0.0).sqrt();
            let cos_x = cos_of_difference(sin_w, cos_w, sin_o, cos_o);
            let sin_x = (1.0 - cos_x * cos_x).max(0.0).sqrt();
            let cos_least = cos_of_difference(sin_x, cos_x, sin_b, cos_b);
            if cos_least <= self.emission_spread_rad.cos() - 1e-6 {
                return 0.0;
            }
            importance *= cos_least.max(0.0);
            if let Some(n) = to.normal {
                let cos_i = (-away).dot(n).clamp(-1.0, 1.0);
                let sin_i = (1.0 - cos_i * cos_i).max(0.0).sqrt();
                importance *= cos_of_difference(sin_i, cos_i, sin_b, cos_b).max(0.0);
            }
        }
        importance
    }
}

/// cos(max(0, a - b)) from sines and cosines.
#[inline]
fn cos_of_difference(sin_a: f32, cos_a: f32, sin_b: f32, cos_b: f32) -> f32 {
    if cos_a > cos_b { 1.0 } else { cos_a * cos_b + sin_a * sin_b }
}

/// A cone around two cones.
fn join_cones(a: (Vec3A, f32), b: (Vec3A, f32)) -> (Vec3A, f32) {
    let (a, b) = if a.1 >= b.1 { (a, b) } else { (b, a) };
    let between = a.0.dot(b.0).clamp(-1.0, 1.0).acos();
    if (between + b.1).min(PI) <= a.1 {
        return a;
    }
    let spread = 0.5 * (a.1 + between + b.1);
    if spread >= PI {
        return (a.0, PI);
    }
    let turn = spread - a.1;
    let Some(side) = (b.0 - a.0 * a.0.dot(b.0)).try_normalize() else { return (a.0, PI) };
    let (s, c) = turn.sin_cos();
    ((a.0 * c + side * s).normalize(), spread)
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: LightBounds,
    parent: u32,
    /// Of an inner node, its second child (the first follows it); of a leaf, its emitter.
    link: u32,
    leaf: bool,
}

/// The tree over all emitters of a scene.
#[derive(Clone, Debug)]
pub struct LightTree {
    nodes: Vec<Node>,
    // By emitter, its leaf; `u32::MAX` where it emits nothing.
    leaf_of: Vec<u32>,
}

impl LightTree {
    /// `None` where nothing emits.
    pub fn new(emitters: &[LightBounds]) -> Option<Self> {
        let mut order: Vec<u32> = (0..emitters.len() as u32).filter(|&i| emitters[i as usize].power > 0.0).collect();
        if order.is_empty() {
            return None;
        }
        let mut tree = Self { nodes: Vec::with_capacity(2 * order.len()), leaf_of: vec![u32::MAX; emitters.len()] };
        tree.build(emitters, &mut order, u32::MAX);
        Some(tree)
    }

    /// Builds a subtree; gives the index of its root.
    fn build(&mut self, emitters: &[LightBounds], order: &mut [u32], parent: u32) -> u32 {
        let here = self.nodes.len() as u32;
        let bounds = |i: u32| emitters[i as usize];
        if let [only] = *order {
            self.leaf_of[only as usize] = here;
            self.nodes.push(Node { bounds: bounds(only), parent, link: only, leaf: true });
            return here;
        }
        let whole = order[1..].iter().fold(bounds(order[0]), |b, &i| b.union(&bounds(i)));
        self.nodes.push(Node { bounds: whole, parent, link: 0, leaf: false });
        let middle = split(emitters, order);
        let (left, right) = order.split_at_mut(middle);
        self.build(emitters, left, here);
        let second = self.build(emitters, right, here);
        self.nodes[here as usize].link = second;
        here
    }

    /// Chance of going to the first child; `None` where neither may send light.
    fn first_chance(&self, node: usize, to: &Receiver) -> Option<f32> {
        let first = self.nodes[node + 1].bounds.importance(to);
        let second = self.nodes[self.nodes[node].link as usize].bounds.importance(to);
        let sum = first + second;
        (sum > 0.0 && sum.is_finite()).then(|| first / sum)
    }

    /// An emitter and the probability of its choice; `None` where none may send light.
    pub fn sample(&self, to: &Receiver, mut u: f32) -> Option<(usize, f32)> {
        let mut node = 0;
        let mut probability = 1.0;
        while !self.nodes[node].leaf {
            let first = self.first_chance(node, to)?;
            if u < first {
                u /= first;
                probability *= first;
                node += 1;
            } else {
                u = (u - first) / (1.0 - first);
                probability *= 1.0 - first;
                node = self.nodes[node].link as usize;
            }
            u = u.clamp(0.0, 1.0 - f32::EPSILON);
        }
        (probability > 0.0).then_some((self.nodes[node].link as usize, probability))
    }

    /// The probability of [`LightTree::sample`] choosing an emitter.
    pub fn probability(&self, to: &Receiver, emitter: usize) -> f32 {
        let mut node = self.leaf_of[emitter];
        if node == u32::MAX {
            return 0.0;
        }
        let mut probability = 1.0;
        while self.nodes[node as usize].parent != u32::MAX {
            let parent = self.nodes[node as usize].parent;
            let Some(first) = self.first_chance(parent as usize, to) else { return 0.0 };
            probability *= if node == parent + 1 { first } else { 1.0 - first };
            node = parent;
        }
        probability
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::warp::sample_sphere;

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

    fn receivers() -> impl Iterator<Item = Receiver> {
        (0..50).map(|i| {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let v = sobol_burley::sample_4d(i, 0, 4);
            Receiver {
                position: Vec3A::new(u[0], u[1], u[2]) * 14.0 - Vec3A::splat(7.0),
                normal: (i % 2 == 0).then(|| sample_sphere([v[0], v[1]])),
            }
        })
    }

    /// Probabilities add to one, and choices follow them.
    #[test]
    fn choices_follow_their_probabilities() {
        for n in [1, 2, 3, 100] {
            let list = emitters(n);
            let Some(tree) = LightTree::new(&list) else { continue };
            for to in receivers() {
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
            }
        }
    }

    /// Whatever can send light has a chance: no bound may rule out what its emitters can do.
    #[test]
    fn nothing_that_shines_is_ruled_out() {
        let list = emitters(100);
        let tree = LightTree::new(&list).unwrap();
        for to in receivers() {
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

    #[test]
    fn a_dark_scene_has_no_tree() {
        assert!(LightTree::new(&[]).is_none());
        assert!(LightTree::new(&[LightBounds { power: 0.0, ..emitters(2)[1] }]).is_none());
    }
}
