//! Balls, eight at a time. As in Cycles they are hit from outside alone: a ray that has gone into one does not hit it again.

use super::block::LANES;
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use glam::{Vec3A, Vec4};

/// A leaf's balls, a lane each.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct Balls {
    /// Middle and radius; NaN in lanes without a ball.
    parts: [[f32; LANES]; 4],
    /// Index into the scene's instances; of no meaning in trees of one cloud.
    pub(super) instance: [u32; LANES],
    /// The point's number in its cloud.
    pub(super) point: [u32; LANES],
}

/// A ray as balls want it: `direction` has length one.
pub(super) struct Beam {
    pub(super) origin: Vec3A,
    pub(super) direction: Vec3A,
}

/// The hits of a ray in the lanes of a leaf.
pub(super) struct Met {
    /// Lanes that the ray hits, as bits.
    pub(super) lanes: u32,
    /// Distances of the hits.
    pub(super) t: [f32; LANES],
    /// Vectors from the balls' middles to the hits.
    out: [[f32; LANES]; 3],
}

impl Met {
    /// The vector from the middle of a lane's ball to the hit; its length is undefined.
    #[inline(always)]
    pub(super) fn outward(&self, lane: usize) -> Vec3A {
        Vec3A::from_array(self.out.map(|axis| axis[lane]))
    }
}

impl Balls {
    /// A leaf without balls.
    pub(super) const EMPTY: Self = Self { parts: [[f32::NAN; LANES]; 4], instance: [0; LANES], point: [0; LANES] };

    /// Puts a ball into a lane.
    pub(super) fn set(&mut self, lane: usize, ball: Vec4, [instance, point]: [u32; 2]) {
        (0..4).for_each(|part| self.parts[part][lane] = ball[part]);
        self.instance[lane] = instance;
        self.point[lane] = point;
    }

    /// These balls moved by a part of the way to their places in another leaf.
    #[inline(always)]
    pub(super) fn towards(&self, to: &Self, part: f32) -> Self {
        let mut now = self.clone();
        for (now, to) in now.parts.as_flattened_mut().iter_mut().zip(to.parts.as_flattened()) {
            *now += (*to - *now) * part;
        }
        now
    }

    /// The balls that a ray enters before `t_max`.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, ray: &Beam, t_max: f32) -> Option<Met> {
        let all = |x: f32| f32x8::splat(simd, x);
        let [x, y, z] = ray.origin.to_array();
        let [dx, dy, dz] = ray.direction.to_array();
        let x = f32x8::load_array_ref(simd, &self.parts[0]) - x;
        let y = f32x8::load_array_ref(simd, &self.parts[1]) - y;
        let z = f32x8::load_array_ref(simd, &self.parts[2]) - z;
        let radius = f32x8::load_array_ref(simd, &self.parts[3]);
        // From the middle to where the ray passes it: distances from there lose nothing however far the ray comes.
        let along = x * dx + y * dy + z * dz;
        let (px, py, pz) = (along * dx - x, along * dy - y, along * dz - z);
        let inside = radius * radius - (px * px + py * py + pz * pz);
        // Also refuses NaN.
        let crosses = inside.simd_ge(0.0) & radius.simd_gt(0.0);
        if !crosses.any_true() {
            return None;
        }
        let back = inside.max(0.0).sqrt();
        let t = along - back;
        let lanes = (crosses & t.simd_gt(0.0) & t.simd_lt(all(t_max))).to_bitmask() as u32;
        if lanes == 0 {
            return None;
        }
        let out = [px - back * dx, py - back * dy, pz - back * dz].map(|axis| axis.to_array());
        Some(Met { lanes, t: t.to_array(), out })
    }
}
