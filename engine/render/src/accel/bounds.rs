//! Boxes with the axes' directions.

use glam::{Affine3A, Vec3, Vec3A, Vec4};

/// A box, and the index of its content: the bits of the fourth components, which mean nothing in a union.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) min: Vec4,
    pub(super) max: Vec4,
}

impl Bounds {
    /// The box around nothing.
    pub(super) const EMPTY: Self = Self { min: Vec4::INFINITY, max: Vec4::NEG_INFINITY };

    /// Bound of the rounding error of a ray against a triangle, as a share of their distances from the origin: six half
    /// units in the triangle test's shear, three in the box test, four where the node is coarse; rounded up.
    pub(super) const SLACK: f32 = 8.0 * f32::EPSILON;

    /// The box of a triangle, grown by a bound on rounding errors.
    pub(super) fn of(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners.map(|p| p.extend(0.0));
        Self { min: a.min(b).min(c), max: a.max(b).max(c) }.grown()
    }

    /// The box around balls, whose radii are the fourth parts.
    pub(super) fn around(balls: &[Vec4]) -> Self {
        let of = |ball: &Vec4| {
            let (place, radius) = (ball.with_w(0.0), Vec4::splat(ball.w.abs()).with_w(0.0));
            Self { min: place - radius, max: place + radius }
        };
        balls.iter().map(of).fold(Self::EMPTY, |all, one| all.union(&one)).grown()
    }

    /// This box with two numbers in its fourth components.
    pub(super) fn naming(self, [a, b]: [u32; 2]) -> Self {
        let [a, b] = [a, b].map(f32::from_bits);
        Self { min: self.min.with_w(a), max: self.max.with_w(b) }
    }

    /// The two numbers in its fourth components.
    pub(super) fn name(&self) -> [u32; 2] {
        [self.min.w, self.max.w].map(f32::to_bits)
    }

    /// True if the box is near enough to the origin for products of three distances to be numbers of single precision.
    pub(super) fn is_within_reach(&self) -> bool {
        const REACH: f32 = 1e12;
        self.low().abs().max(self.high().abs()).cmple(Vec3A::splat(REACH)).all()
    }

    /// The box grown by a bound on rounding errors at its distance from the origin.
    fn grown(self) -> Self {
        let reach = self.min.abs().max(self.max.abs()).truncate().max_element();
        let grow = Vec4::splat(Self::SLACK * reach);
        Self { min: self.min - grow, max: self.max + grow }
    }

    /// The box around this box transformed.
    pub(super) fn transformed(&self, m: &Affine3A) -> Self {
        let mut out = Self::EMPTY;
        for i in 0..8 {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            let corner = m.transform_point3a(Vec3A::new(pick(0), pick(1), pick(2))).extend(0.0);
            out = out.union(&Self { min: corner, max: corner });
        }
        // The move's own rounding is relative to what is added up, which may be more than the sum.
        let m3 = &m.matrix3;
        let reach = self.low().abs().max(self.high().abs()).max_element();
        let added = (m3.x_axis.abs() + m3.y_axis.abs() + m3.z_axis.abs()) * reach + m.translation.abs();
        let shift = Vec4::splat(Self::SLACK * added.max_element());
        Self { min: out.min - shift, max: out.max + shift }.grown()
    }

    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// This box grown to hold another point.
    #[inline(always)]
    pub(super) fn with(&self, p: Vec4) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }

    /// Half the surface; 0 of nothing.
    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let d = (self.max - self.min).max(Vec4::ZERO);
        d.x * (d.y + d.z) + d.y * d.z
    }

    /// Twice the middle of the box.
    #[inline(always)]
    pub(super) fn middle(&self) -> Vec4 {
        self.min + self.max
    }

    #[inline(always)]
    pub(super) fn low(&self) -> Vec3A {
        Vec3A::from_vec4(self.min)
    }

    #[inline(always)]
    pub(super) fn high(&self) -> Vec3A {
        Vec3A::from_vec4(self.max)
    }
}
