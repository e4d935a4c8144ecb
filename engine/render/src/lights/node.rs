//! A node of the lights' tree: up to eight parts of the scene's light, weighed at once in the lanes of a register.

use super::bounds::LightBounds;
use super::receiver::WIDTH;
use glam::Vec3A;
use std::f32::consts::SQRT_2;
use wide::f32x8;

/// Least size and distance, Blender units: smaller ones are raised to it.
const LEAST_SIZE: f32 = 1e-8;

/// Times the square of its radius: how near is near.
const NEAR: f32 = 2.0;

/// No node, no emitter.
pub(super) const NONE: u32 = u32::MAX;

/// A child of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    Nothing,
    Node(u32),
    Emitter(u32),
}

/// A [`Child`] in four bytes: an emitter's has the uppermost bit.
#[derive(Clone, Copy, Debug)]
pub(super) struct PackedChild(u32);

impl PackedChild {
    const NOTHING: Self = Self(NONE);
    const EMITTER: u32 = 1 << 31;

    pub(super) fn node(number: u32) -> Self {
        debug_assert!(number < Self::EMITTER);
        Self(number)
    }

    pub(super) fn emitter(number: u32) -> Self {
        debug_assert!(number < NONE - Self::EMITTER);
        Self(number | Self::EMITTER)
    }

    #[inline]
    pub(super) fn open(self) -> Child {
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
pub(super) struct Node {
    center: [f32x8; 3],
    /// Radius of the sphere about the box.
    radius: f32x8,
    /// Power; negative where light also leaves backwards.
    power: f32x8,
    axis: [f32x8; 3],
    cos_normal_spread: f32x8,
    sin_normal_spread: f32x8,
    /// A little less than it, so that rounding takes no light away.
    cos_emission_spread: f32x8,
    pub(super) children: [PackedChild; WIDTH],
}

impl Node {
    pub(super) fn new(parts: &[LightBounds]) -> Self {
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

    /// A bit for each child whose box is near for its size: its importance by [`Node::importances`] may be off by a factor of two.
    #[inline]
    pub(super) fn near(&self, p: Vec3A) -> u32 {
        let to = [
            self.center[0] - f32x8::splat(p.x),
            self.center[1] - f32x8::splat(p.y),
            self.center[2] - f32x8::splat(p.z),
        ];
        dot(&to, &to).simd_lt(self.radius * self.radius * NEAR).to_bitmask()
    }

    /// An approximation, for each child, of the light that it may send to a place; 0 only where it sends none.
    #[inline]
    pub(super) fn importances(&self, p: Vec3A, normal: Option<Vec3A>) -> [f32; WIDTH] {
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
        let quarter = (both * d2 * d2 * inverse_d * self.radius * 0.25).fast_min(f32x8::splat(1e30));
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

#[inline]
fn dot(a: &[f32x8; 3], b: &[f32x8; 3]) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// An approximation of the mean of the cosines, where they are not negative, of directions in a cone of that sine about one of that cosine:
/// its own as long as all are above the horizon; 0 where none is. `quarter` is a quarter of the sine's inverse.
#[inline]
fn mean_cosine(cos: f32x8, sin_cone: f32x8, quarter: f32x8) -> f32x8 {
    let above = (cos + sin_cone).fast_max(f32x8::splat(0.0));
    cos.simd_gt(sin_cone).select(cos, above * above * quarter)
}
