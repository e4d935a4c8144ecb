//! The pixels of a picture as places where samples fall: by what density, and to which pixel a place belongs.
//!
//! Pixel j's value is the mean of the light weighted by the pixel filter f about its centre. Where each pixel has one
//! sample of density f, their places together have the density S = Σ f. Light that is known at any place is given to
//! one pixel j with the chance f / S, weighted by S: right in the mean for any filter, also one whose S is not constant,
//! and at the edge of the picture.

use super::warp::PixelFilter;
use glam::Vec2;

/// A picture's pixels and their filter.
pub struct Raster {
    width: u32,
    height: u32,
    filter: PixelFilter,
}

/// Where light falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Column of the pixel that gets it.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Density of sample places there, in samples for each pixel's area, where every pixel has one.
    pub density: f32,
}

impl Raster {
    /// A picture of that size, at least one pixel.
    pub fn new(width: u32, height: u32, filter: PixelFilter) -> Self {
        Self { width, height, filter }
    }

    /// Columns and rows.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// A place for a sample of a pixel: fractions of the picture from its centre.
    #[inline]
    pub fn place(&self, x: u32, y: u32, u: [f32; 2]) -> Vec2 {
        Vec2::new(
            (x as f32 + 0.5 + self.filter.sample(u[0])) / self.width as f32 - 0.5,
            (y as f32 + 0.5 + self.filter.sample(u[1])) / self.height as f32 - 0.5,
        )
    }

    /// The pixel that gets the light of a place, chosen by `u`; `None` where no pixel's filter reaches.
    #[inline]
    pub fn land(&self, place: Vec2, u: [f32; 2]) -> Option<Landing> {
        let (x, across) = self.along((place.x + 0.5) * self.width as f32, self.width, u[0])?;
        let (y, up) = self.along((place.y + 0.5) * self.height as f32, self.height, u[1])?;
        Some(Landing { x, y, density: across * up })
    }

    /// The density of [`Landing`] at a place.
    #[inline]
    pub fn density(&self, place: Vec2) -> f32 {
        self.land(place, [0.0; 2]).map_or(0.0, |landing| landing.density)
    }

    /// Along one axis, where pixel i's centre lies at i + 1/2: a pixel, chosen by its filter's part of the density.
    #[inline]
    fn along(&self, at: f32, count: u32, u: f32) -> Option<(u32, f32)> {
        let reach = self.filter.reach();
        // Casts take what is negative, or no number, to 0.
        let first = (at - 0.5 - reach).ceil().max(0.0) as u32;
        let last = (at - 0.5 + reach).floor().min(count as f32 - 1.0);
        if !(last >= first as f32) {
            return None;
        }
        let last = last as u32;
        let part = |i: u32| self.filter.density(at - i as f32 - 0.5);
        let density: f32 = (first..=last).map(part).sum();
        let mut left = u * density;
        for i in first..last {
            left -= part(i);
            if left < 0.0 {
                return Some((i, density));
            }
        }
        (density > 0.0).then_some((last, density))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light of the same amount at every place of the plane makes every pixel one, to the edge, whatever the filter.
    #[test]
    fn an_even_light_is_even() {
        for width_px in [0.0, 0.7, 1.0, 1.5, 2.3] {
            let raster = Raster::new(5, 4, PixelFilter::new(width_px));
            let mut sums = [0.0f64; 20];
            let n = 1600;
            let side = 12.0 / n as f32;
            for i in 0..n * n {
                let at = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) * side - Vec2::splat(3.5);
                // A fine grid of numbers that does not beat with the grid of places.
                let u = [(i as f32 * 0.618_034).fract(), (i as f64 * 0.754_877_666).fract() as f32];
                let place = at / Vec2::new(5.0, 4.0) - Vec2::splat(0.5);
                if let Some(l) = raster.land(place, u) {
                    sums[(l.y * 5 + l.x) as usize] += f64::from(l.density * side * side);
                }
            }
            for sum in sums {
                // The numbers' own noise.
                assert!((sum - 1.0).abs() < 0.01, "{width_px}: {sum}");
            }
        }
    }

    /// Places of samples have the density that is said.
    #[test]
    fn places_have_their_density() {
        let raster = Raster::new(3, 1, PixelFilter::new(1.5));
        let n = 300_000;
        let mut counts = [0u32; 30];
        for i in 0..n {
            let place = raster.place(i % 3, 0, [(i as f64 * 0.618_033_988_7).fract() as f32, 0.5]);
            let bin = (place.x + 0.5) * 30.0;
            if (0.0..30.0).contains(&bin) {
                counts[bin as usize] += 1;
            }
        }
        for (bin, count) in counts.iter().enumerate() {
            let across = |part: f32| raster.along((bin as f32 + part) * 0.1, 3, 0.0).unwrap().1;
            let expected = (across(0.17) + across(0.5) + across(0.83)) / 3.0 * 0.1;
            let seen = *count as f32 / (n / 3) as f32;
            assert!((seen - expected).abs() < 2e-3, "{bin}: {seen} {expected}");
        }
    }

    #[test]
    fn far_away_nothing_lands() {
        let raster = Raster::new(10, 10, PixelFilter::new(1.5));
        for place in [Vec2::new(9.0, 0.0), Vec2::new(0.0, -9.0), Vec2::NAN, Vec2::INFINITY] {
            assert_eq!(raster.land(place, [0.5; 2]), None);
            assert_eq!(raster.density(place), 0.0);
        }
    }
}
