//! A table of the sky by direction, with most rows near the horizon.

use glam::Vec3A;
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, TAU};

pub(super) const COLUMNS: usize = 512;
const ROWS: usize = 256;

/// XYZ by azimuth, seen from the sun's opposite, and by elevation. As large as Blender's, and read as it reads its own:
/// the smoothing by a table near the horizon is part of the picture.
#[derive(Clone, Debug)]
pub(super) struct Panorama {
    pixels: Vec<Vec3A>,
}

/// The place at which a row's values are taken.
#[derive(Clone, Copy, Debug)]
pub(super) enum RowPlace {
    /// Values in the middle of each pixel.
    Middle,
    /// Values at the lower left corner of each pixel; values read between them are then half a pixel off.
    Corner,
    /// Values at the corners, with the highest row half a row above the zenith: Blender 4.
    CornerBeyond,
}

impl Panorama {
    /// A panorama of the light from an azimuth from the sun's opposite, and an elevation, radians. Both sides of the sun are alike.
    pub(super) fn new(place: RowPlace, shine: impl Fn(f32, f32) -> Vec3A + Sync) -> Self {
        let (shift, most_rad) = match place {
            RowPlace::Middle => (0.5, FRAC_PI_2),
            RowPlace::Corner => (0.0, FRAC_PI_2),
            RowPlace::CornerBeyond => (0.0, FRAC_PI_2 * (1.0 + 1.0 / ROWS as f32)),
        };
        let mut pixels = vec![Vec3A::ZERO; COLUMNS * ROWS];
        pixels.par_chunks_mut(COLUMNS).enumerate().for_each(|(row, pixels)| {
            let height = (row as f32 + shift) / (ROWS / 2) as f32 - 1.0;
            let elevation_rad = most_rad * height * height.abs();
            for column in 0..COLUMNS / 2 {
                let azimuth_rad = TAU * (column as f32 + shift) / COLUMNS as f32;
                pixels[column] = shine(azimuth_rad, elevation_rad);
                pixels[COLUMNS - 1 - column] = pixels[column];
            }
        });
        Self { pixels }
    }

    /// The light at an azimuth from the sun's opposite, any number of turns, and an elevation.
    pub(super) fn at(&self, azimuth_rad: f32, elevation_rad: f32) -> Vec3A {
        let height = (elevation_rad.abs() / FRAC_PI_2).sqrt().copysign(elevation_rad);
        self.at_row(azimuth_rad, 0.5 * height + 0.5)
    }

    /// The light at an azimuth, and a height in the table, 0 to 1.
    pub(super) fn at_row(&self, azimuth_rad: f32, height: f32) -> Vec3A {
        let x = (azimuth_rad / TAU).rem_euclid(1.0) * COLUMNS as f32 - 0.5;
        let y = (height * ROWS as f32 - 0.5).clamp(0.0, (ROWS - 1) as f32);
        let (left, low) = (x.floor(), y.floor());
        let row = |y: f32| {
            let y = (y as usize).min(ROWS - 1) * COLUMNS;
            let column = |x: f32| self.pixels[y + (x as isize).rem_euclid(COLUMNS as isize) as usize];
            column(left).lerp(column(left + 1.0), x - left)
        };
        row(low).lerp(row(low + 1.0), y - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_read_where_it_was_written() {
        // Linear in the table's own coordinates, away from the seams.
        let shine = |azimuth: f32, elevation: f32| Vec3A::new(azimuth, (elevation.abs() / FRAC_PI_2).sqrt(), 1.0);
        let table = Panorama::new(RowPlace::Middle, shine);
        for (azimuth, elevation) in [(0.5, 0.7), (2.9, 0.01), (1.0, -0.3), (3.0, 1.5)] {
            let error = table.at(azimuth, elevation) - shine(azimuth, elevation);
            assert!(error.abs().max_element() < 1e-4, "{azimuth} {elevation} {error}");
            assert!(table.at(TAU - azimuth, elevation).abs_diff_eq(table.at(azimuth, elevation), 1e-5));
            assert!(table.at(azimuth - TAU, elevation).abs_diff_eq(table.at(azimuth, elevation), 1e-4));
        }
    }
}
