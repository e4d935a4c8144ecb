//! Values at the points of a lattice in an object's space, of which smoke and clouds are made.

use super::SceneError;
use glam::{Affine3A, Vec3A, Vec4};

/// One or three numbers at each voxel of a box; 0 outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// The name by which shaders read it: "density", "temperature".
    pub name: String,
    /// Voxels along x, y and z.
    pub size: [usize; 3],
    /// Numbers a voxel: 1, 3 or 4.
    pub channels: usize,
    /// Voxel by voxel, x runs fastest.
    pub values: Vec<f32>,
    /// Object space to voxels: the middle of the first is at 0, of the next at 1.
    pub to_voxels: Affine3A,
}

impl Grid {
    /// Checks that the numbers are as many as the size says. Values that are not finite become 0.
    ///
    /// # Errors
    /// [`SceneError::BadMesh`], which names the mesh that the grid came with.
    pub fn checked(mut self, mesh: &str) -> Result<Self, SceneError> {
        let bad = |what: String| SceneError::BadMesh { mesh: mesh.into(), what };
        let [x, y, z] = self.size;
        let wanted = x.checked_mul(y).and_then(|xy| xy.checked_mul(z)).and_then(|xyz| xyz.checked_mul(self.channels));
        if !matches!(self.channels, 1 | 3 | 4) || wanted != Some(self.values.len()) || self.values.is_empty() {
            let (name, given, channels) = (&self.name, self.values.len(), self.channels);
            return Err(bad(format!("grid '{name}': {given} values for {x} x {y} x {z} voxels of {channels} numbers")));
        }
        if !self.to_voxels.is_finite() {
            return Err(bad(format!("grid '{}': its matrix is not finite", self.name)));
        }
        self.values.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = 0.0);
        Ok(self)
    }

    /// The value at a place of the object's space, linear between the middles of voxels. A single number stands in the
    /// first three parts.
    pub fn lookup(&self, position: Vec3A) -> Vec4 {
        let at = self.to_voxels.transform_point3a(position).to_array();
        let mut low = [0isize; 3];
        let mut part = [0.0f32; 3];
        for axis in 0..3 {
            let limit = self.size[axis] as f32 + 1.0;
            if !(at[axis] > -1.0 && at[axis] < limit) {
                return Vec4::ZERO;
            }
            low[axis] = at[axis].floor() as isize;
            part[axis] = at[axis] - low[axis] as f32;
        }
        let mut sum = Vec4::ZERO;
        for corner in 0..8 {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let share: f32 = (0..3).map(|axis| if step[axis] == 1 { part[axis] } else { 1.0 - part[axis] }).product();
            let place: [isize; 3] = std::array::from_fn(|axis| low[axis] + step[axis]);
            if share > 0.0 && (0..3).all(|axis| (0..self.size[axis] as isize).contains(&place[axis])) {
                sum += self.voxel(place.map(|p| p as usize)) * share;
            }
        }
        sum
    }

    fn voxel(&self, [x, y, z]: [usize; 3]) -> Vec4 {
        let at = ((z * self.size[1] + y) * self.size[0] + x) * self.channels;
        let value = |i: usize| self.values[at + i];
        match self.channels {
            1 => Vec4::new(value(0), value(0), value(0), 1.0),
            3 => Vec4::new(value(0), value(1), value(2), 1.0),
            _ => Vec4::new(value(0), value(1), value(2), value(3)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn grid() -> Grid {
        let values = (0..24).map(|i| i as f32).collect();
        let to_voxels = Affine3A::from_scale(Vec3::splat(2.0));
        Grid { name: "density".into(), size: [2, 3, 4], channels: 1, values, to_voxels }
    }

    /// A linear function of the place is given back between voxels; half of it at the border's middle, nothing beyond.
    #[test]
    fn values_lie_between_voxels() {
        let grid = grid().checked("smoke").unwrap();
        let at = |x, y, z| grid.lookup(Vec3A::new(x, y, z) / 2.0).x;
        assert_eq!(at(0.0, 0.0, 0.0), 0.0);
        assert_eq!(at(1.0, 2.0, 3.0), 23.0);
        assert!((at(0.25, 1.5, 2.5) - (0.25 + 2.0 * 1.5 + 6.0 * 2.5)).abs() < 1e-5);
        assert!((at(1.5, 2.0, 3.0) - 11.5).abs() < 1e-5);
        assert_eq!(at(2.0, 2.0, 3.0), 0.0);
        assert_eq!(at(-1.0, 0.0, 0.0), 0.0);
        assert_eq!(grid.lookup(Vec3A::splat(f32::NAN)), Vec4::ZERO);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let error = Grid { size: [2, 3, 5], ..grid() }.checked("smoke").unwrap_err();
        assert!(error.to_string().contains("'smoke'") && error.to_string().contains("2 x 3 x 5"), "{error}");
        assert!(Grid { channels: 2, ..grid() }.checked("smoke").is_err());
    }
}
