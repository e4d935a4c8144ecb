//! Choosing one of many emitters by how much light it may send to a place: a tree whose nodes bound position,
//! power and direction (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", without the splitting), eight children a node, weighed at once in the lanes of a register.

use super::bounds::LightBounds;
use super::build::{Filling, Half};
use super::receiver::{Receiver, WIDTH};
use glam::Vec3A;
use std::f32::consts::SQRT_2;
use wide::f32x8;

/// What is smaller, or nearer, is taken to be so small and near: Blender units.
const LEAST_SIZE: f32 = 1e-8;

/// Emitters up to which the upper levels of the tree say enough of what is near.
const FEW: usize = 1024;

/// No node, no emitter.
const NONE: u32 = u32::MAX;

/// A child of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Child {
    Nothing,
    Node(u32),
    Emitter(u32),
}

/// The same in four bytes: an emitter's has the uppermost bit.
#[derive(Clone, Copy, Debug)]
struct PackedChild(u32);

impl PackedChild {
    const NOTHING: Self = Self(NONE);
    const EMITTER: u32 = 1 << 31;

    fn node(number: u32) -> Self {
        debug_assert!(number < Self::EMITTER);
        Self(number)
    }

    fn emitter(number: u32) -> Self {
        debug_assert!(number < NONE - Self::EMITTER);
        Self(number | Self::EMITTER)
    }

    #[inline]
    fn open(self) -> Child {
        match self.0 {
            NONE => Child::Nothing,
            emitter if emitter & Self::EMITTER != 0 => Child::Emitter(emitter & !Self::EMITTER),
            node => Child::Node(node),
        }
    }
}

/// Up to eight parts of the scene's light, lane by lane.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Node {
    center: [f32x8; 3],
    /// Of the sphere about the box.
    radius: f32x8,
    /// Negative where light also leaves backwards.
    power: f32x8,
    axis: [f32x8; 3],
    cos_normal_spread: f32x8,
    sin_normal_spread: f32x8,
    /// A little less than it, so that rounding takes no light away.
    cos_emission_spread: f32x8,
    children: [PackedChild; WIDTH],
}

impl Node {
    fn new(parts: &[LightBounds]) -> Self {
        let lanes = |of: &dyn Fn(&LightBounds) -> f32| {
            let mut values = [0.0; WIDTH];
            values.iter_mut().zip(parts).for_each(|(v, b)| *v = of(b));
            f32x8::from(values)
        };
        Self {
            center: [0, 1, 2].map(|i| lanes(&|b| b.center()[i])),
            radius: lanes(&|b| 0.5 * (b.max - b.min).length()).fast_max(f32x8::splat(LEAST_SIZE)),
            power: lanes(&|b| if b.two_sided { -b.power } else { b.power }),
            axis: [0, 1, 2].map(|i| lanes(&|b| b.axis[i])),
            cos_normal_spread: lanes(&|b| b.normal_spread_rad.cos()),
            sin_normal_spread: lanes(&|b| b.normal_spread_rad.sin()),
            cos_emission_spread: lanes(&|b| b.emission_spread_rad.cos() - 1e-6),
            children: [PackedChild::NOTHING; WIDTH],
        }
    }

    /// For each child about the light that it may send to a place; 0 only where it sends none.
    #[inline]
    fn importances(&self, p: Vec3A, normal: Option<Vec3A>) -> [f32; WIDTH] {
        let (zero, one) = (f32x8::splat(0.0), f32x8::splat(1.0));
        // The other way round than light goes.
        let to = [
            self.center[0] - f32x8::splat(p.x),
            self.center[1] - f32x8::splat(p.y),
            self.center[2] - f32x8::splat(p.z),
        ];
        let d2 = dot(&to, &to).fast_max(f32x8::splat(LEAST_SIZE * LEAST_SIZE));
        let radius2 = self.radius * self.radius;
        // Two quotients by one division.
        let both = one / (d2 * radius2);
        let inverse_d2 = both * radius2;
        // 1 from outside the sphere about the box on.
        let outside = (both * d2 * d2).fast_min(one);
        let inverse_d = inverse_d2.sqrt();
        // Of the angle that the box fills, seen from the place; the sine's inverse over four.
        let sin_box = (self.radius * inverse_d).fast_min(one);
        let quarter = both * d2 * d2 * inverse_d * self.radius * 0.25;
        let cos_axis = -dot(&self.axis, &to) * inverse_d;
        let cos_axis = self.power.is_sign_negative().select(cos_axis.abs(), cos_axis);
        // Of the least angle between any normal and the direction from the middle to the place.
        let sin_axis = (one - cos_axis * cos_axis).fast_max(zero).sqrt();
        let cos_normal = cos_axis * self.cos_normal_spread + sin_axis * self.sin_normal_spread;
        let cos_normal = cos_axis.simd_ge(self.cos_normal_spread).select(one, cos_normal);
        // cos(a - b) <= cos a + 2^0.5 sin b for all angles up to a right one.
        let reaches = (cos_normal + sin_box * SQRT_2).simd_gt(self.cos_emission_spread);
        let mut cosines = reaches.select(mean_cosine(cos_normal, sin_box, quarter), zero);
        if let Some(n) = normal {
            let n = [f32x8::splat(n.x), f32x8::splat(n.y), f32x8::splat(n.z)];
            cosines *= mean_cosine(dot(&to, &n) * inverse_d, sin_box, quarter);
        }
        // From the middle of the box light may come from anywhere, at any slant.
        let far = outside * outside;
        (self.power.abs() * inverse_d2 * outside * (one - far + cosines * far)).to_array()
    }
}

impl Node {
    /// A bit for each child whose box is large or near: within so many times.
    #[inline]
    fn near(&self, p: Vec3A, times: f32) -> u32 {
        let to = [
            self.center[0] - f32x8::splat(p.x),
            self.center[1] - f32x8::splat(p.y),
            self.center[2] - f32x8::splat(p.z),
        ];
        dot(&to, &to).simd_lt(self.radius * self.radius * times).to_bitmask()
    }
}

#[inline]
fn dot(a: &[f32x8; 3], b: &[f32x8; 3]) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// About the mean of the cosines, where they are not negative, of directions in a cone of that sine about one of that cosine:
/// its own as long as all are above the horizon; 0 where none is. `quarter` is a quarter of the sine's inverse.
#[inline]
fn mean_cosine(cos: f32x8, sin_cone: f32x8, quarter: f32x8) -> f32x8 {
    let above = (cos + sin_cone).fast_max(f32x8::splat(0.0));
    cos.simd_gt(sin_cone).select(cos, above * above * quarter)
}

/// The tree over all emitters of a scene.
#[derive(Clone, Debug)]
pub struct LightTree {
    nodes: Vec<Node>,
    // By node, the one above and which of its children it is.
    parents: Vec<(u32, u32)>,
    // By emitter, its node and which child it is; `NONE` where it emits nothing.
    place_of: Vec<(u32, u32)>,
    // The root's children are weighed by what is in them.
    looks_ahead: bool,
    near: f32,
}

impl LightTree {
    /// `None` where nothing emits.
    pub fn new(emitters: &[LightBounds]) -> Option<Self> {
        let mut order: Vec<u32> = (0..emitters.len() as u32).filter(|&i| emitters[i as usize].power > 0.0).collect();
        if order.is_empty() {
            return None;
        }
        let filling = if order.len() > FEW { Filling::Full } else { Filling::Loose };
        let (bounds, halves) = Half::new(emitters, &mut order, filling);
        let looks_ahead = order.len() > FEW;
        let mut tree = Self {
            nodes: Vec::new(),
            parents: Vec::new(),
            place_of: vec![(NONE, 0); emitters.len()],
            looks_ahead,
            near: std::env::var("NEAR").map_or(2.0, |v| v.parse().unwrap()),
        };
        tree.add(halves, bounds, (NONE, 0), filling);
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

    /// A place, and what the parts under the root may send there. The sky has no chance yet.
    pub(super) fn receiver(&self, position: Vec3A, normal: Option<Vec3A>) -> Receiver {
        let weights =
            if self.looks_ahead { self.ahead(position, normal) } else { self.nodes[0].importances(position, normal) };
        Receiver { position, normal, tree: 0, total: sum(&weights), weights, sky_chance: 0.0 }
    }

    /// The root's children weighed by what is in them, those that are near.
    #[inline]
    fn ahead(&self, position: Vec3A, normal: Option<Vec3A>) -> [f32; WIDTH] {
        let root = &self.nodes[0];
        let mut weights = root.importances(position, normal);
        let mut near = root.near(position, self.near);
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            if let Child::Node(node) = root.children[lane].open() {
                weights[lane] = sum(&self.nodes[node as usize].importances(position, normal));
            }
        }
        weights
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
            match self.nodes[node].children[lane].open() {
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
            let is_root = place.0 == 0;
            let weights = if is_root { to.weights } else { node.importances(to.position, to.normal) };
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
