//! Plain images in memory, for programs that run without a renderer.

use crate::context::{Extension, ImageReading, Interpolation, Textures};
use crate::image::unassociated;
use glam::{Vec2, Vec4};

/// An image of linear RGBA, alpha multiplied in, its lowest row first.
#[derive(Clone, Debug)]
pub struct Pixels {
    width: i32,
    height: i32,
    rgba: Vec<Vec4>,
}

impl Pixels {
    /// An image `width` wide; none where the number of pixels is not a whole number of rows.
    pub fn new(width: usize, rgba: Vec<Vec4>) -> Option<Self> {
        let height = rgba.len().checked_div(width)?;
        let whole = height > 0 && width * height == rgba.len();
        let size = (i32::try_from(width).ok()?, i32::try_from(height).ok()?);
        whole.then_some(Self { width: size.0, height: size.1, rgba })
    }

    /// A pixel anywhere on the plane.
    fn pixel(&self, x: i32, y: i32, extension: Extension) -> Vec4 {
        let inside = |i: i32, size: i32| match extension {
            Extension::Repeat => Some(i.rem_euclid(size)),
            Extension::Extend => Some(i.clamp(0, size - 1)),
            Extension::Clip => (0..size).contains(&i).then_some(i),
            Extension::Mirror => {
                let i = i.rem_euclid(2 * size);
                Some(if i < size { i } else { 2 * size - 1 - i })
            }
        };
        match (inside(x, self.width), inside(y, self.height)) {
            (Some(x), Some(y)) => self.rgba[(y * self.width + x) as usize],
            _ => Vec4::ZERO,
        }
    }

    /// The image's colour at a place.
    pub fn at(&self, uv: Vec2, interpolation: Interpolation, extension: Extension) -> Vec4 {
        if !uv.is_finite() {
            return Vec4::ZERO;
        }
        let p = uv * Vec2::new(self.width as f32, self.height as f32);
        match interpolation {
            Interpolation::Closest => self.pixel(p.x.floor() as i32, p.y.floor() as i32, extension),
            Interpolation::Linear => self.weighted(p, extension, |t| [0.0, 1.0 - t, t, 0.0]),
            Interpolation::Cubic => self.weighted(p, extension, cubic_weights),
        }
    }

    /// Four by four pixels about a place, weighted.
    fn weighted(&self, p: Vec2, extension: Extension, weights: impl Fn(f32) -> [f32; 4]) -> Vec4 {
        let corner = (p - 0.5).floor();
        let part = p - 0.5 - corner;
        let (across, up) = (weights(part.x), weights(part.y));
        let mut sum = Vec4::ZERO;
        for (j, row) in up.into_iter().enumerate() {
            for (i, column) in across.into_iter().enumerate() {
                if row * column != 0.0 {
                    let [x, y] =
                        [(corner.x, i), (corner.y, j)].map(|(low, step)| (low as i32).saturating_add(step as i32 - 1));
                    sum += self.pixel(x, y, extension) * (row * column);
                }
            }
        }
        sum
    }
}

/// Weights of the cubic B-spline at `t`.
fn cubic_weights(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
        t * t * t / 6.0,
    ]
}

impl Textures for Vec<Pixels> {
    fn lookup(&self, image: usize, uv: Vec2, read: ImageReading) -> Vec4 {
        let rgba = self.get(image).map_or(Vec4::ZERO, |pixels| pixels.at(uv, read.interpolation, read.extension));
        if read.unassociate { unassociated(rgba) } else { rgba }
    }
}
