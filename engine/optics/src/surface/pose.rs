//! A surface that does not stand where its lens's axis wants it: decentred, tilted.

use std::ops::Mul;

use glam::{DMat3, DVec3};

use crate::lane::{Lane, Real};
use crate::vector::Vector;

/// The pose of the surface's own axes in those of its vertex on the lens's axis: turned, then moved. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<R = f64> {
    /// Columns: the surface's x, y and z.
    axes: [Vector<R>; 3],
    /// Vector from the vertex's place on the lens's axis to the vertex itself.
    moved: Vector<R>,
}

impl Pose {
    /// The pose of a surface that stands where it should.
    pub fn identity() -> Self {
        Self::new(DVec3::ZERO, DMat3::IDENTITY)
    }

    /// The pose of a surface moved by `moved` mm and turned by `turn`, a rotation.
    pub fn new(moved: DVec3, turn: DMat3) -> Self {
        Self { axes: [turn.x_axis, turn.y_axis, turn.z_axis].map(Vector::from_f64), moved: Vector::from_f64(moved) }
    }

    /// The pose of a surface moved across the axis by `decenter_mm` (x, y), then turned about its vertex by `tilt_rad`: right-handed about
    /// x, then about its own y, then about its own z.
    pub fn misaligned(decenter_mm: [f64; 2], tilt_rad: [f64; 3]) -> Self {
        let [x, y, z] = tilt_rad;
        let turn = DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z);
        Self::new(DVec3::new(decenter_mm[0], decenter_mm[1], 0.0), turn)
    }

    /// The displacement of the vertex, mm, and the tilts about x, y and z, in radians, in the order of [`Self::misaligned`].
    pub fn parts(&self) -> ([f64; 3], [f64; 3]) {
        let turn = self.turn();
        let [x, y, z] = [turn.x_axis, turn.y_axis, turn.z_axis];
        let tilts = [(-z.y).atan2(z.z), z.x.clamp(-1.0, 1.0).asin(), (-y.x).atan2(x.x)];
        (self.moved.of(0).to_array(), tilts)
    }

    /// The pose of a surface `behind_mm` behind the vertex about which a whole element is posed by `self`.
    pub fn of_element(&self, behind_mm: f64) -> Self {
        let along = DVec3::new(0.0, 0.0, behind_mm);
        Self::new(self.turn() * along - along + self.moved.of(0), self.turn())
    }

    fn turn(&self) -> DMat3 {
        let [x, y, z] = self.axes.map(|axis| axis.of(0));
        DMat3::from_cols(x, y, z)
    }

    /// True if the pose changes nothing.
    pub fn is_identity(&self) -> bool {
        *self == Self::identity()
    }

    /// The pose in a lens `factor` times as large.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { moved: self.moved * factor, ..*self }
    }

    /// True if all numbers of the pose are finite.
    pub fn is_finite(&self) -> bool {
        self.moved.of(0).is_finite() && self.turn().is_finite()
    }

    /// This pose in numbers of another kind.
    pub fn cast<R: Real>(&self) -> Pose<R> {
        Pose { axes: self.axes.map(|axis| Vector::from_f64(axis.of(0))), moved: Vector::from_f64(self.moved.of(0)) }
    }
}

/// The pose `inner` of a surface in an element that is itself posed by `self`.
impl Mul<Pose> for Pose {
    type Output = Self;

    fn mul(self, inner: Self) -> Self {
        Self::new(self.turn() * inner.moved.of(0) + self.moved.of(0), self.turn() * inner.turn())
    }
}

impl<R: Real> Pose<R> {
    /// A point in the surface's own coordinates.
    #[inline(always)]
    pub fn point_in<L: Lane<Real = R>>(&self, p: Vector<L>) -> Vector<L> {
        let Vector { x, y, z } = self.moved;
        self.direction_in(Vector { x: p.x - x, y: p.y - y, z: p.z - z })
    }

    /// A direction in the surface's own coordinates.
    #[inline(always)]
    pub fn direction_in<L: Lane<Real = R>>(&self, d: Vector<L>) -> Vector<L> {
        let [ex, ey, ez] = self.axes;
        Vector {
            x: d.x * ex.x + d.y * ex.y + d.z * ex.z,
            y: d.x * ey.x + d.y * ey.y + d.z * ey.z,
            z: d.x * ez.x + d.y * ez.y + d.z * ez.z,
        }
    }

    /// A point in the coordinates of the vertex on the axis.
    #[inline(always)]
    pub fn point_out<L: Lane<Real = R>>(&self, p: Vector<L>) -> Vector<L> {
        let Vector { x, y, z } = self.moved;
        let turned = self.direction_out(p);
        Vector { x: turned.x + x, y: turned.y + y, z: turned.z + z }
    }

    /// A direction in the coordinates of the vertex on the axis.
    #[inline(always)]
    pub fn direction_out<L: Lane<Real = R>>(&self, d: Vector<L>) -> Vector<L> {
        let [ex, ey, ez] = self.axes;
        Vector {
            x: d.x * ex.x + d.y * ey.x + d.z * ez.x,
            y: d.x * ex.y + d.y * ey.y + d.z * ez.y,
            z: d.x * ex.z + d.y * ey.z + d.z * ez.z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_and_out_undo_each_other() {
        let pose = Pose::misaligned([0.3, -2.0], [0.1, -0.7, 1.2]);
        let v = Vector::<f64>::from_f64(DVec3::new(1.0, -2.0, 3.5));
        assert!((pose.point_out(pose.point_in(v)).of(0) - v.of(0)).length() < 1e-14);
        assert!((pose.direction_out(pose.direction_in(v)).of(0) - v.of(0)).length() < 1e-14);
    }

    #[test]
    fn an_element_turns_as_one() {
        // A surface 10 mm behind the pivot, the element turned by 90 degrees about x: z goes to -y.
        let element = Pose::misaligned([1.0, 0.0], [std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
        let vertex = element.of_element(10.0).point_out(Vector::<f64>::from_f64(DVec3::ZERO)).of(0);
        assert!((vertex - DVec3::new(1.0, -10.0, -10.0)).length() < 1e-14);
        assert!(Pose::misaligned([0.0; 2], [0.0; 3]).is_identity());
    }
}
