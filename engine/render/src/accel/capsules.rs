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

/// The axis of a capsule around balls.
struct Axis {
    ends: [Vec3A; 2],
    /// The largest distance from the axis to the far side of a ball.
    reach: f32,
}

impl Axis {
    /// The axis of the thinnest capsule, about, whose direction is that of the line from the first ball to the last.
    fn of(balls: &[Vec4]) -> Self {
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
        Self { ends, reach: thinnest }
    }

    /// The part of the axis at which a ball is nearest to it, 0 to 1.
    fn place(&self, ball: Vec4) -> f32 {
        let [start, end] = self.ends;
        let axis = end - start;
        let along = (Vec3A::from_vec4(ball) - start).dot(axis) / axis.length_squared().max(f32::MIN_POSITIVE);
        along.clamp(0.0, 1.0)
    }
}

impl Capsules {
    /// A leaf without capsules.
    pub(super) const NONE: Self =
        Self { ends: [[[0.0; LANES]; 3]; 2], radius: [f32::NAN; LANES], controls: [0; LANES] };

    /// Puts a capsule into a lane, for the segment of the keys from `controls` on, around all that is between each two neighbours of some
    /// balls. Its axis has the direction of the line from the first to the last, and lies beside that line where the balls do.
    pub(super) fn set(&mut self, lane: usize, balls: &[Vec4], controls: u32) {
        let Axis { ends, reach } = Axis::of(balls);
        self.put(lane, ends, reach, controls);
    }

    /// Puts capsules into a lane of two leaves, for a segment that changes from the first balls to as many others. The capsules of
    /// [`Self::towards`] are around all that is between each two neighbours of the balls, these as far on their way.
    pub(super) fn set_both(leaves: [&mut Self; 2], lane: usize, balls: [&[Vec4]; 2], controls: u32) {
        let axes = balls.map(Axis::of);
        // Each ball keeps a place along the axis. Its distance from that place is a convex function of the part of the way, so that it is
        // nowhere larger than what is between the distances at both ends.
        let places: Vec<f32> = std::iter::zip(balls[0], balls[1])
            .map(|(from, to)| 0.5 * (axes[0].place(*from) + axes[1].place(*to)))
            .collect();
        for ((leaf, Axis { ends, .. }), balls) in leaves.into_iter().zip(axes).zip(balls) {
            let away =
                |(ball, place): (&Vec4, &f32)| Vec3A::from_vec4(*ball).distance(ends[0].lerp(ends[1], *place)) + ball.w;
            leaf.put(lane, ends, balls.iter().zip(&places).map(away).fold(0.0, f32::max), controls);
        }
    }

    /// These capsules a part of the way to those of another leaf.
    #[inline(always)]
    pub(super) fn towards(&self, to: &Self, part: f32) -> Self {
        let mut now = self.clone();
        let ends = now.ends.as_flattened_mut().as_flattened_mut();
        let goals = to.ends.as_flattened().as_flattened();
        for (now, goal) in ends.iter_mut().zip(goals).chain(now.radius.iter_mut().zip(&to.radius)) {
            *now += (*goal - *now) * part;
        }
        now
    }

    /// Puts a capsule of this radius, and room for rounding, into a lane.
    fn put(&mut self, lane: usize, ends: [Vec3A; 2], reach: f32, controls: u32) {
        for (columns, end) in self.ends.iter_mut().zip(ends) {
            for (column, coordinate) in columns.iter_mut().zip(end.to_array()) {
                column[lane] = coordinate;
            }
        }
        let rounding = ROUNDING * ends[0].abs().max(ends[1].abs()).max_element();
        self.radius[lane] = reach * (1.0 + ROUNDING) + rounding;
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
