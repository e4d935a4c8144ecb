//! Bounding capsules of curve segments, eight at a time: a ray must hit one before the keys of its segment are read.
//!
//! A box along the axes is mostly empty where a strand runs across them, and eight such boxes overlap; a capsule about the chord fits a
//! strand whichever way it runs. Oriented boxes serve the same purpose in the BVH of Woop, Benthin, Wald, Johnson and Tabellion (2014,
//! "Exploiting Local Orientation Similarity for Efficient Ray Traversal of Hair and Fur"); here the leaves alone are oriented.

use super::block::LANES;
use super::bounds::Bounds;
use super::segment::RayFrame;
use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use glam::{Vec3A, Vec4};

/// Rounding of an end of an axis as it is seen along a ray, and of its distance, as a share of the coordinates of both.
const ROUNDING: f32 = 4.0 * Bounds::SLACK;

/// A leaf's capsules, a lane each: four lines of a cache.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Capsules {
    /// Ends of the axes, then coordinates.
    ends: [[[f32; LANES]; 3]; 2],
    /// NaN in lanes without a capsule.
    radius: [f32; LANES],
    /// The first of the four keys of each lane's segment.
    pub(super) controls: [u32; LANES],
}

/// The capsules of a leaf that a ray hits.
pub(super) struct Candidates {
    /// The lanes that are hit, as bits.
    pub(super) lanes: u32,
    /// Distances before which the lanes' segments are not hit.
    pub(super) near: [f32; LANES],
}

impl Capsules {
    /// A leaf without capsules.
    pub(super) const NONE: Self =
        Self { ends: [[[0.0; LANES]; 3]; 2], radius: [f32::NAN; LANES], controls: [0; LANES] };

    /// Puts a capsule into a lane, for the segment of the keys from `controls` on, around all that is between each two neighbours of some
    /// balls. Its axis has the direction of the line from the first to the last, and lies beside that line where the balls do.
    pub(super) fn set(&mut self, lane: usize, balls: &[Vec4], controls: u32) {
        /// Steps towards the axis of the thinnest capsule: the first is the last one of a plain bend, an S takes some.
        const STEPS: usize = 6;
        let [start, end] = [balls.first(), balls.last()].map(|ball| Vec3A::from_vec4(*ball.expect("at least one")));
        let direction = (end - start).normalize_or_zero();
        let from = |ball: &Vec4| Vec3A::from_vec4(*ball) - start;
        let aside = |ball: &Vec4| from(ball).reject_from_normalized(direction);
        // How far balls reach is a convex function of where they are and of their radii: the largest value is at one of them. The centre of
        // the smallest ball around others is found by going towards the farthest, ever less far (Badoiu and Clarkson 2003, "Smaller
        // Core-Sets for Balls").
        let (mut shift, mut best, mut thinnest) = (Vec3A::ZERO, Vec3A::ZERO, f32::INFINITY);
        for step in 0..=STEPS {
            let (mut reach, mut farthest) = (0.0f32, Vec3A::ZERO);
            for ball in balls {
                let aside = aside(ball);
                let so_far = (aside - shift).length() + ball.w;
                if so_far > reach {
                    (reach, farthest) = (so_far, aside);
                }
            }
            if reach < thinnest {
                (best, thinnest) = (shift, reach);
            }
            shift += (farthest - shift) / (step + 2) as f32;
        }
        let along = balls.iter().map(|ball| from(ball).dot(direction));
        let [low, high] = along.fold([0.0f32; 2], |[low, high], along| [low.min(along), high.max(along)]);
        let ends = [low, high].map(|along| start + best + along * direction);
        for (columns, end) in self.ends.iter_mut().zip(ends) {
            for (column, coordinate) in columns.iter_mut().zip(end.to_array()) {
                column[lane] = coordinate;
            }
        }
        let rounding = ROUNDING * start.abs().max(end.abs()).max_element();
        self.radius[lane] = thinnest * (1.0 + ROUNDING) + rounding;
        self.controls[lane] = controls;
    }

    /// The capsules that a ray hits before `t_max`, or may hit.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, gaze: &RayFrame, t_max: f32) -> Option<Candidates> {
        let [ax, ay, az] = self.seen(simd, gaze, 0);
        let [bx, by, bz] = self.seen(simd, gaze, 1);
        let room = f32x8::load_array_ref(simd, &self.radius) + ROUNDING * gaze.reach();
        let (ex, ey) = (bx - ax, by - ay);
        let length2 = (ex * ex + ey * ey).max(f32::MIN_POSITIVE);
        let nearest = (f32x8::splat(simd, 0.0) - (ax * ex + ay * ey)) / length2;
        let nearest = nearest.max(0.0).min(1.0);
        let (x, y) = (nearest.mul_add(ex, ax), nearest.mul_add(ey, ay));
        let near = az.min(bz) - room;
        // Also refuses NaN.
        let is_near = (x * x + y * y).simd_le(room * room);
        let lanes = is_near & near.simd_lt(t_max) & (az.max(bz) + room).simd_gt(0.0);
        let lanes = lanes.to_bitmask() as u32;
        (lanes != 0).then(|| Candidates { lanes, near: near.to_array() })
    }

    /// One end of each axis as it is seen along a ray. (A function, since closures are not inlined.)
    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S, gaze: &RayFrame, end: usize) -> [f32x8<S>; 3] {
        let from = gaze.origin();
        let x = f32x8::load_array_ref(simd, &self.ends[end][0]) - from.x;
        let y = f32x8::load_array_ref(simd, &self.ends[end][1]) - from.y;
        let z = f32x8::load_array_ref(simd, &self.ends[end][2]) - from.z;
        let [a, b, c] = gaze.axes();
        [x * a.x + y * a.y + z * a.z, x * b.x + y * b.y + z * b.z, x * c.x + y * c.y + z * c.z]
    }
}
