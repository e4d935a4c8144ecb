//! Choosing one of many emitters by how much light it may send to a place: a tree whose nodes bound position,
//! power and direction (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", without the splitting), eight children a node, weighed at once in the lanes of a register.

use super::bounds::LightBounds;
use super::build::Half;
use super::receiver::{Receiver, WIDTH};
use crate::scene::motion::MIDDLE;
use glam::Vec3A;
use wide::f32x8;

/// No node, no emitter.
const NONE: u32 = u32::MAX;

/// A child of a node.
#[derive(Clone, Copy, Debug)]
enum Child {
    Nothing,
    Node(u32),
    Emitter(u32),
}

/// Up to eight parts of the scene's light, lane by lane.
#[derive(Clone, Debug)]
struct Node {
    center: [f32x8; 3],
    half_diagonal2: f32x8,
    power: f32x8,
    axis: [f32x8; 3],
    cos_normal_spread: f32x8,
    sin_normal_spread: f32x8,
    /// A little less than it, so that rounding takes no light away.
    cos_emission_spread: f32x8,
    /// All bits where light also leaves backwards.
    two_sided: f32x8,
    children: [Child; WIDTH],
    /// The node above, and which of its children this is.
    parent: (u32, u32),
}

impl Node {
    fn new(parts: &[LightBounds], parent: (u32, u32)) -> Self {
        let lanes = |of: &dyn Fn(&LightBounds) -> f32| {
            let mut values = [0.0; WIDTH];
            values.iter_mut().zip(parts).for_each(|(v, b)| *v = of(b));
            f32x8::from(values)
        };
        Self {
            center: [0, 1, 2].map(|i| lanes(&|b| b.center()[i])),
            half_diagonal2: lanes(&|b| 0.25 * (b.max - b.min).length_squared()),
            power: lanes(&|b| b.power),
            axis: [0, 1, 2].map(|i| lanes(&|b| b.axis[i])),
            cos_normal_spread: lanes(&|b| b.normal_spread_rad.cos()),
            sin_normal_spread: lanes(&|b| b.normal_spread_rad.sin()),
            cos_emission_spread: lanes(&|b| b.emission_spread_rad.cos() - 1e-6),
            two_sided: lanes(&|b| if b.two_sided { 1.0 } else { 0.0 }).simd_gt(f32x8::splat(0.5)),
            children: [Child::Nothing; WIDTH],
            parent,
        }
    }

    /// For each child a bound, nearly, of the light that it may send to a place.
    #[inline]
    fn importances(&self, p: Vec3A, normal: Option<Vec3A>) -> [f32; WIDTH] {
        let zero = f32x8::splat(0.0);
        let one = f32x8::splat(1.0);
        let offset = [
            f32x8::splat(p.x) - self.center[0],
            f32x8::splat(p.y) - self.center[1],
            f32x8::splat(p.z) - self.center[2],
        ];
        let d2 = dot(&offset, &offset);
        let base = self.power / d2.fast_max(self.half_diagonal2).fast_max(f32x8::splat(1e-20));
        // 1 from outside the sphere about the box on.
        let outside = (d2 / self.half_diagonal2.fast_max(f32x8::splat(1e-20))).fast_min(one);
        let inverse = one / d2.fast_max(f32x8::splat(1e-30)).sqrt();
        let away = [offset[0] * inverse, offset[1] * inverse, offset[2] * inverse];
        // The angle that the box fills, seen from the place.
        let sin2_box = (self.half_diagonal2 * inverse * inverse).fast_min(one);
        let (sin_box, cos_box) = (sin2_box.sqrt(), (one - sin2_box).sqrt());
        // The least angle between any normal and any direction to the place.
        let cos_axis = dot(&self.axis, &away).fast_max(-one).fast_min(one);
        let cos_axis = self.two_sided.select(cos_axis.abs(), cos_axis);
        let cos_x = cos_of_difference(sine(cos_axis), cos_axis, self.sin_normal_spread, self.cos_normal_spread);
        let cos_least = cos_of_difference(sine(cos_x), cos_x, sin_box, cos_box);
        let mut cosines = cos_least.simd_gt(self.cos_emission_spread).select(mean_cosine(cos_x, sin_box), zero);
        if let Some(n) = normal {
            let n = [f32x8::splat(-n.x), f32x8::splat(-n.y), f32x8::splat(-n.z)];
            let cos_i = dot(&away, &n).fast_max(-one).fast_min(one);
            cosines *= mean_cosine(cos_i, sin_box);
        }
        // From the middle of the box light may come from anywhere, at any slant.
        let far = outside * outside;
        (base * (one - far + cosines * far)).to_array()
    }
}

#[inline]
fn dot(a: &[f32x8; 3], b: &[f32x8; 3]) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Of an angle up to pi.
#[inline]
fn sine(cosine: f32x8) -> f32x8 {
    (f32x8::splat(1.0) - cosine * cosine).fast_max(f32x8::splat(0.0)).sqrt()
}

/// cos(max(0, a - b)) from sines and cosines.
#[inline]
fn cos_of_difference(sin_a: f32x8, cos_a: f32x8, sin_b: f32x8, cos_b: f32x8) -> f32x8 {
    cos_a.simd_gt(cos_b).select(f32x8::splat(1.0), cos_a * cos_b + sin_a * sin_b)
}

/// About the mean of the cosines, where they are not negative, of directions in a cone of that sine about one of that cosine:
/// its own as long as all are above the horizon; 0 where none is.
#[inline]
fn mean_cosine(cos: f32x8, sin_cone: f32x8) -> f32x8 {
    let above = (cos + sin_cone).fast_max(f32x8::splat(0.0));
    let partly = above * above / (sin_cone * 4.0).fast_max(f32x8::splat(1e-20));
    cos.simd_gt(sin_cone).select(cos, partly)
}

/// The tree over all emitters of a scene.
#[derive(Clone, Debug)]
pub struct LightTree {
    nodes: Vec<Node>,
    // By emitter, its node and which child it is; `NONE` where it emits nothing.
    place_of: Vec<(u32, u32)>,
}

impl LightTree {
    /// `None` where nothing emits.
    pub fn new(emitters: &[LightBounds]) -> Option<Self> {
        let mut order: Vec<u32> = (0..emitters.len() as u32).filter(|&i| emitters[i as usize].power > 0.0).collect();
        if order.is_empty() {
            return None;
        }
        let (bounds, halves) = Half::new(emitters, &mut order);
        let mut tree = Self { nodes: Vec::new(), place_of: vec![(NONE, 0); emitters.len()] };
        tree.add(halves, bounds, (NONE, 0));
        Some(tree)
    }

    /// Adds a part of the tree; gives the number of its root.
    fn add(&mut self, part: Half, bounds: LightBounds, parent: (u32, u32)) -> u32 {
        let here = self.nodes.len() as u32;
        let (bounds, parts): (Vec<LightBounds>, Vec<Half>) = part.open(bounds, WIDTH).into_iter().unzip();
        self.nodes.push(Node::new(&bounds, parent));
        for (lane, (part, bounds)) in parts.into_iter().zip(bounds).enumerate() {
            let place = (here, lane as u32);
            self.nodes[here as usize].children[lane] = match part {
                Half::Leaf(emitter) => {
                    self.place_of[emitter as usize] = place;
                    Child::Emitter(emitter)
                }
                inner => Child::Node(self.add(inner, bounds, place)),
            };
        }
        here
    }

    /// A place, and what the parts under the root may send there. The sky has no chance yet.
    pub(super) fn receiver(&self, position: Vec3A, normal: Option<Vec3A>) -> Receiver {
        let weights = self.nodes[0].importances(position, normal);
        Receiver { position, normal, tree: 0, total: sum(&weights), weights, sky_chance: 0.0, moment: MIDDLE }
    }

    /// An emitter and the probability of its choice; `None` where none may send light.
    pub fn sample(&self, to: &Receiver, mut u: f32) -> Option<(usize, f32)> {
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
            match self.nodes[node].children[lane] {
                Child::Nothing => return None,
                Child::Node(next) => node = next as usize,
                Child::Emitter(emitter) => return (probability > 0.0).then_some((emitter as usize, probability)),
            }
            weights = self.nodes[node].importances(to.position, to.normal);
            total = sum(&weights);
        }
    }

    /// The probability of [`LightTree::sample`] choosing an emitter.
    pub fn probability(&self, to: &Receiver, emitter: usize) -> f32 {
        let mut place = self.place_of[emitter];
        if place.0 == NONE {
            return 0.0;
        }
        let mut probability = 1.0;
        loop {
            let node = &self.nodes[place.0 as usize];
            let is_root = node.parent.0 == NONE;
            let weights = if is_root { to.weights } else { node.importances(to.position, to.normal) };
            let total = if is_root { to.total } else { sum(&weights) };
            if !(total > 0.0 && total.is_finite()) {
                return 0.0;
            }
            probability *= weights[place.1 as usize] / total;
            if is_root {
                return probability;
            }
            place = node.parent;
        }
    }
}

/// In one order everywhere, so that choosing and asking agree.
#[inline]
fn sum(weights: &[f32; WIDTH]) -> f32 {
    let [a, b, c, d, e, f, g, h] = *weights;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::warp::sample_sphere;
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

    fn receivers(tree: &LightTree) -> impl Iterator<Item = Receiver> {
        (0..50).map(|i| {
            let u = sobol_burley::sample_4d(i, 0, 3);
            let v = sobol_burley::sample_4d(i, 0, 4);
            let position = Vec3A::new(u[0], u[1], u[2]) * 14.0 - Vec3A::splat(7.0);
            tree.receiver(position, (i % 2 == 0).then(|| sample_sphere([v[0], v[1]])))
        })
    }

    /// Probabilities add to one, and choices follow them.
    #[test]
    fn choices_follow_their_probabilities() {
        for n in [1, 2, 3, 100] {
            let list = emitters(n);
            let Some(tree) = LightTree::new(&list) else { continue };
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
            }
        }
    }

    /// Whatever can send light has a chance: no bound may rule out what its emitters can do.
    #[test]
    fn nothing_that_shines_is_ruled_out() {
        let list = emitters(100);
        let tree = LightTree::new(&list).unwrap();
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

    #[test]
    fn a_dark_scene_has_no_tree() {
        assert!(LightTree::new(&[]).is_none());
        assert!(LightTree::new(&[LightBounds { power: 0.0, ..emitters(2)[1] }]).is_none());
    }
}
