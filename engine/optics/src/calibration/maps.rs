//! ST maps of calibrations, for compositors.

use super::Calibration;
use glam::{DVec2, DVec3};

/// The direction of an ST map: the picture that is made, and the one that it is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapDirection {
    /// The calibrated camera's, of a pinhole's.
    Distort,
    /// A pinhole's, of the calibrated camera's.
    Undistort,
}

impl Calibration {
    /// The pinhole with the same middle and the same scale there: focal lengths and principal point, pixels of the calibration's picture.
    ///
    /// `None`: straight ahead is not seen.
    pub fn pinhole_px(&self) -> Option<[f64; 4]> {
        let [fx, fy] = self.focal_px()?;
        let middle = self.project(DVec3::Z).ok()?;
        Some([fx, fy, middle.x, middle.y])
    }

    /// The map for a compositor at a picture's size: for each pixel, first row at the top, the place in the other picture to take it from,
    /// x and y from 0 to 1 with the origin at the lower left, then twice 1 where that place is in the other picture and 0 where it is not.
    /// Where there is no such place all four are 0. The pinhole is [`Self::pinhole_px`], its picture as large.
    ///
    /// `None`: straight ahead is not seen.
    pub fn st_map(&self, [width, height]: [u32; 2], direction: MapDirection) -> Option<Vec<[f32; 4]>> {
        let [fx, fy, cx, cy] = self.pinhole_px()?;
        let whole = DVec2::from_array(self.size_px.map(f64::from));
        let size = DVec2::new(f64::from(width), f64::from(height));
        let pixel = |x: u32, y: u32| {
            let point = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / size * whole;
            let source = match direction {
                MapDirection::Distort => {
                    let d = self.unproject(point).ok().filter(|d| d.z > 0.0);
                    d.map(|d| DVec2::new(fx * d.x / d.z + cx, fy * d.y / d.z + cy))
                }
                MapDirection::Undistort => self.project(DVec3::new((point.x - cx) / fx, (point.y - cy) / fy, 1.0)).ok(),
            };
            let Some(source) = source.filter(|source| source.is_finite()) else { return [0.0; 4] };
            let st = DVec2::new(source.x / whole.x, 1.0 - source.y / whole.y);
            let is_within = st.cmpge(DVec2::ZERO).all() && st.cmple(DVec2::ONE).all();
            let is_there = if is_within { 1.0 } else { 0.0 };
            [st.x as f32, st.y as f32, is_there, is_there]
        };
        Some((0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect())
    }
}
