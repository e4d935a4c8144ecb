//! Triangles of light on a picture: each spreads its light evenly over the pixels that it covers.

use super::super::Picture;
use crate::Rgb;
use glam::Vec2;
use rayon::prelude::*;

/// A triangle in pixels from the picture's lower left corner, with its light, as it would be on one pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) corners: [Vec2; 3],
    pub(super) light: Rgb,
}

/// Rows that one thread fills.
const STRIPE: usize = 32;
/// A triangle smaller than this, px², lies about its middle: its pixels' centres would miss it.
const SMALL_PX2: f32 = 2.0;

/// Adds triangles to a picture, in their order in every pixel: the same bits whoever does it.
pub(super) fn lay(triangles: &[Vec<Triangle>], picture: &mut Picture) {
    let width = picture.width as usize;
    picture.light.par_chunks_mut(width * STRIPE).enumerate().for_each(|(stripe, light)| {
        let mut rows = Rows { light, width, first: (stripe * STRIPE) as i64 };
        triangles.iter().flatten().for_each(|one| rows.add(one));
    });
}

/// Some rows of a picture.
struct Rows<'a> {
    light: &'a mut [Rgb],
    width: usize,
    /// The first row, in the picture.
    first: i64,
}

impl Rows<'_> {
    fn add(&mut self, triangle: &Triangle) {
        let [a, b, c] = triangle.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let rows = (self.light.len() / self.width) as i64;
        // With what a small one gives to its neighbours.
        if high.y < (self.first - 1) as f32 || low.y > (self.first + rows + 1) as f32 {
            return;
        }
        let doubled = (b - a).perp_dot(c - a);
        let area = 0.5 * doubled.abs();
        if area.is_nan() || area < SMALL_PX2 {
            self.splat((a + b + c) / 3.0, triangle.light);
            return;
        }
        // Counted against the clock.
        let [a, b, c] = if doubled > 0.0 { [a, b, c] } else { [a, c, b] };
        let edges = [[a, b], [b, c], [c, a]];
        let light = triangle.light / area;
        let from = ((low.y - 0.5).ceil() as i64).max(self.first);
        let to = ((high.y - 0.5).floor() as i64).min(self.first + rows - 1);
        for y in from..=to {
            let at = y as f32 + 0.5;
            // The part of the row's line inside all three edges.
            let (mut left, mut right) = (low.x, high.x);
            for [p, q] in edges {
                let way = q - p;
                if way.y == 0.0 {
                    if (at - p.y) * way.x < 0.0 {
                        right = f32::NEG_INFINITY;
                    }
                    continue;
                }
                let x = p.x + (at - p.y) / way.y * way.x;
                if way.y < 0.0 { left = left.max(x) } else { right = right.min(x) }
            }
            // Centres from the left end up to, but not on, the right end: neighbours share none.
            let begin = ((left - 0.5).ceil() as i64).max(0);
            let end = ((right - 0.5).ceil() as i64).min(self.width as i64);
            let start = (y - self.first) as usize * self.width;
            for x in begin..end {
                self.light[start + x as usize] += light;
            }
        }
    }

    /// Spreads light over the four pixels about a point.
    fn splat(&mut self, at: Vec2, light: Rgb) {
        let corner = (at - 0.5).floor();
        let part = at - 0.5 - corner;
        let (x, y) = (corner.x as i64, corner.y as i64);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let share = (if dx == 0 { 1.0 - part.x } else { part.x }) * (if dy == 0 { 1.0 - part.y } else { part.y });
            let (x, row) = (x + dx, y + dy - self.first);
            if x >= 0 && x < self.width as i64 && row >= 0 && (row as usize) < self.light.len() / self.width {
                self.light[row as usize * self.width + x as usize] += light * share;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn empty(width: u32, height: u32) -> Picture {
        Picture { width, height, light: vec![Rgb::ZERO; (width * height) as usize] }
    }

    /// A square in two triangles fills its pixels once, however it is turned; none is missed, none has twice.
    #[test]
    fn neighbours_share_no_pixel() {
        for angle in [0.0f32, 0.3, 1.0, 2.4] {
            let turn = |x: f32, y: f32| Vec2::from_angle(angle).rotate(Vec2::new(x, y)) + 50.0;
            let [a, b, c, d] = [turn(-20.0, -20.0), turn(20.0, -20.0), turn(20.0, 20.0), turn(-20.0, 20.0)];
            let half = |corners| Triangle { corners, light: Rgb::splat(800.0) };
            let mut picture = empty(100, 100);
            lay(&[vec![half([a, b, c]), half([c, a, d])]], &mut picture);
            let lit: Vec<f32> = picture.light.iter().map(|l| l.x).filter(|l| *l > 0.0).collect();
            assert!(lit.iter().all(|l| (l - 1.0).abs() < 1e-4), "{angle}");
            // 1600 px², and what the edges' pixels leave open: a part of a pixel for each along them.
            assert!((lit.len() as f32 - 1600.0).abs() < 30.0, "{angle}: {}", lit.len());
        }
    }

    /// All light of small and of large triangles arrives.
    #[test]
    fn light_is_kept() {
        let mut picture = empty(200, 200);
        let triangles: Vec<Triangle> = (0..400)
            .map(|i| {
                let (i, size) = (i as f32, 0.3 + (i as f32 * 0.37).fract() * 9.0);
                let at = Vec2::new(20.0 + (i * 0.618).fract() * 150.0, 20.0 + (i * 0.754).fract() * 150.0);
                let corner = |k: f32| at + Vec2::from_angle(i + k * 2.1) * size;
                Triangle { corners: [corner(0.0), corner(1.0), corner(2.0)], light: Rgb::ONE }
            })
            .collect();
        lay(&[triangles], &mut picture);
        let sum: f32 = picture.light.iter().map(|l| l.x).sum();
        // The centres' count of each is off by chance; that averages out.
        assert!((sum / 400.0 - 1.0).abs() < 0.03, "{sum}");
    }

    /// Rows are filled alike whoever fills them.
    #[test]
    fn stripes_meet() {
        let corners = [Vec2::new(5.0, 20.3), Vec2::new(60.0, 25.0), Vec2::new(30.0, 75.7)];
        let mut picture = empty(64, 96);
        lay(&[vec![Triangle { corners, light: Rgb::ONE }]], &mut picture);
        let sum: f32 = picture.light.iter().map(|l| l.x).sum();
        assert!((sum - 1.0).abs() < 0.01, "{sum}");
    }
}
