//! The part of the picture that a calibration covers.

use super::{Calibration, Outside};
use glam::{DVec2, DVec3};

/// Points looked at over the larger side of the picture.
const POINTS: u32 = 64;

/// The part of the picture that a calibration covers, and its largest angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    /// The part of the picture that shows something.
    pub covered: f64,
    /// The reason why most of the rest shows nothing; `None`: there is no rest.
    pub reason: Option<Outside>,
    /// The largest angle from the axis that the picture shows.
    pub largest_angle_rad: f64,
    /// Angles from the middle of the picture's edges, left to right and top to bottom; `None`: one of the edges shows nothing.
    pub field_rad: [Option<f64>; 2],
    /// The angle from the axis up to which the model is valid all around; `None`: as far as its projection goes.
    pub fold_rad: Option<f64>,
}

impl Calibration {
    /// The part of the picture that the calibration covers.
    pub fn survey(&self) -> Survey {
        let [width, height] = self.size_px.map(f64::from);
        let larger = self.size_px[0].max(self.size_px[1]);
        let counts = self.size_px.map(|side| (POINTS * side).div_ceil(larger).max(2));
        let mut lost: Vec<(Outside, u32)> = Vec::new();
        let mut largest_angle_rad: f64 = 0.0;
        let angle = |d: DVec3| d.truncate().length().atan2(d.z);
        for row in 0..counts[1] {
            for column in 0..counts[0] {
                // The corners are looked at, too, as the middles of the last pixels have them.
                let at = |i: u32, n: u32, side: f64| 0.5 + (side - 1.0) * f64::from(i) / f64::from(n - 1);
                let point = DVec2::new(at(column, counts[0], width), at(row, counts[1], height));
                match self.unproject(point) {
                    Ok(d) => largest_angle_rad = largest_angle_rad.max(angle(d)),
                    Err(reason) => match lost.iter_mut().find(|(known, _)| *known == reason) {
                        Some((_, count)) => *count += 1,
                        None => lost.push((reason, 1)),
                    },
                }
            }
        }
        let all = f64::from(counts[0] * counts[1]);
        let missing: u32 = lost.iter().map(|(_, count)| count).sum();
        let edge = |a: [f64; 2], b: [f64; 2]| {
            let [a, b] = [a, b].map(|[x, y]| self.unproject(DVec2::new(x * width, y * height)).ok());
            let (a, b) = (a?, b?);
            Some(a.cross(b).length().atan2(a.dot(b)))
        };
        // Beyond half a turn the edges are nearer behind the camera; the two parts do not meet there.
        let through_middle = |a: [f64; 2], b: [f64; 2]| {
            let middle = [0.5, 0.5];
            Some(edge(a, middle)? + edge(middle, b)?)
        };
        Survey {
            covered: 1.0 - f64::from(missing) / all,
            reason: lost.iter().max_by_key(|(_, count)| *count).map(|(reason, _)| *reason),
            largest_angle_rad,
            field_rad: [through_middle([0.0, 0.5], [1.0, 0.5]), through_middle([0.5, 0.0], [0.5, 1.0])],
            fold_rad: self.fold_rad(),
        }
    }

    fn fold_rad(&self) -> Option<f64> {
        let limit = self.warp.limit();
        let least = limit.least();
        let is_table = self.model == super::Model::StMap;
        if is_table || !least.is_finite() || (!self.is_from_picture && !limit.is_fold(self.chart.reach())) {
            return None;
        }
        let on_plane = if self.is_from_picture {
            self.warp.forth(DVec2::new(least * (1.0 - 1e-9), 0.0))?
        } else {
            DVec2::new(least, 0.0)
        };
        let d = self.chart.direction(on_plane)?;
        Some(d.truncate().length().atan2(d.z))
    }
}
