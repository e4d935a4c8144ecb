//! The pixels of a picture as places where samples fall: their density, and the pixel that a place belongs to.
//!
//! Pixel j's value is the mean of the light weighted by the pixel filter f about its centre. Where each pixel has one
//! sample of density f, their places together have the density S = Σ f. Light that is known at any place is given to
//! one pixel j with the chance f / S, weighted by S: right in the mean for any filter, also one whose S is not constant,
//! and at the edge of the picture.

use super::warp::PixelFilter;
use glam::{Vec2, Vec4};

/// A picture's pixels and their filter.
pub struct Raster {
    width: u32,
    height: u32,
    filter: PixelFilter,
    /// True if each place belongs to one pixel.
    is_box: bool,
    columns: Columns,
    /// True if light of a ray is kept together.
    is_independent: bool,
}

/// The pixel that light falls on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Column of the pixel that gets it.
    pub x: u32,
    /// Row of the pixel that gets it.
    pub y: u32,
    /// Density of sample places there, in samples for each pixel's area, where every pixel has one.
    pub density: f32,
}

/// The pixels that several rays fall on: as [`Landing`], with density 0 where no pixel's filter reaches.
pub struct Landings<const N: usize> {
    /// Column of each ray's pixel.
    pub x: [u32; N],
    /// Row of each ray's pixel.
    pub y: [u32; N],
    /// Density of sample places at each, as [`Landing::density`].
    pub density: [f32; N],
}

/// The largest number below one.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Numbers for wavelength `i` of a ray, apart from those of the others.
#[inline]
fn turned(u: [f32; 2], i: usize) -> [f32; 2] {
    // Multiples of two irrational numbers with small terms (the plastic constant: Roberts 2018).
    // A cast takes the whole part off without a call.
    let part = |x: f32| x - (x as i32) as f32;
    [part(u[0] + 0.754_877_7 * i as f32), part(u[1] + 0.569_840_3 * i as f32)]
}

impl Raster {
    /// A picture of that size, at least one pixel.
    pub fn new(width: u32, height: u32, filter: PixelFilter) -> Self {
        let columns = Columns::new(&filter);
        let is_box = !filter.is_smooth() && filter.reach() == 0.5;
        Self { width, height, filter, is_box, columns, is_independent: false }
    }

    /// The raster for which the noise of neighbouring pixels is to be independent, as denoising needs: the light of one ray that arrives at
    /// one place goes to one pixel at all wavelengths. Else it is spread over the pixels whose filters reach the place: there
    /// is less noise in each, but neighbours share it.
    pub fn independent(self, is_independent: bool) -> Self {
        Self { is_independent, ..self }
    }

    /// The numbers that choose the pixel of wavelength `i` of a ray.
    #[inline]
    pub(crate) fn numbers(&self, u: [f32; 2], i: usize) -> [f32; 2] {
        if self.is_independent { u } else { turned(u, i) }
    }

    /// Width and height of the picture, pixels.
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

    /// [`Self::land`] for each wavelength of a ray.
    #[inline]
    pub fn land_many<const N: usize>(&self, place: &[[f32; N]; 2], u: [f32; 2]) -> Landings<N> {
        let mut all = Landings { x: [0; N], y: [0; N], density: [0.0; N] };
        let [mut us, mut vs] = [[u[0]; N], [u[1]; N]];
        if !self.is_independent {
            for (i, (across, up)) in us.iter_mut().zip(&mut vs).enumerate() {
                [*across, *up] = turned(u, i);
            }
        }
        let across = self.along_many(&place[0], self.width, &us, &mut all.x);
        let up = self.along_many(&place[1], self.height, &vs, &mut all.y);
        for i in 0..N {
            all.density[i] = across[i] * up[i];
        }
        all
    }

    /// [`Self::along`] for each of several places, fractions from the picture's middle: fills in pixels, returns densities.
    #[inline]
    fn along_many<const N: usize>(&self, place: &[f32; N], count: u32, u: &[f32; N], pixel: &mut [u32; N]) -> [f32; N] {
        let places = count as f32;
        let first = 0.5 + self.filter.reach();
        let [mut below, mut distance, mut density] = [[0.0f32; N]; 3];
        let mut are_inside = true;
        for i in 0..N {
            let low = (place[i] + 0.5) * places - first;
            are_inside &= low > 0.0 && low + self.columns.span < places;
            below[i] = low.trunc();
            distance[i] = 1.0 - (low - below[i]);
        }
        if are_inside {
            for i in 0..N {
                let (step, part) = self.columns.chosen(distance[i], u[i]);
                pixel[i] = below[i] as i32 as u32 + 1 + step;
                density[i] = part;
            }
        } else {
            for i in 0..N {
                let at = (place[i] + 0.5) * places;
                (pixel[i], density[i]) = self.along(at, count, u[i]).unwrap_or_default();
            }
        }
        density
    }

    /// The numbers that choose the pixels of the wavelengths which the one of a sample leads to, made of two random ones: where noise is to be
    /// independent, numbers with which [`Self::land`] gives the sample's place to the sample's own pixel. As places come from
    /// pixels by their filter, these numbers are uniform, too; so another wavelength's light falls on the pixels about its own place
    /// as it should, and on that of the sample wherever it can.
    #[inline]
    pub fn numbers_of(&self, pixel: [u32; 2], place: Vec2, u: [f32; 2]) -> [f32; 2] {
        if self.is_box || !self.is_independent {
            return u;
        }
        [
            self.number_along((place.x + 0.5) * self.width as f32, self.width, pixel[0], u[0]),
            self.number_along((place.y + 0.5) * self.height as f32, self.height, pixel[1], u[1]),
        ]
    }

    /// [`Self::numbers_of`] along one axis.
    #[inline]
    fn number_along(&self, at: f32, count: u32, pixel: u32, u: f32) -> f32 {
        let low = at - 0.5 - self.filter.reach();
        if !(low > 0.0 && low + self.columns.span < count as f32) {
            return self.number_at_the_edge(at, count, pixel, u);
        }
        let below = low as i32;
        let sums = self.columns.sums_at(1.0 - (low - below as f32));
        // Beyond the reach by rounding only.
        let step = pixel.wrapping_sub((below + 1) as u32).min(FEW as u32 - 1) as usize;
        let sums = sums.to_array();
        let before = if step == 0 { 0.0 } else { sums[step - 1] };
        ((before + u * (sums[step] - before)) / sums[FEW - 1]).min(BELOW_ONE)
    }

    /// [`Self::number_along`] at any place, for filters of any width.
    #[cold]
    fn number_at_the_edge(&self, at: f32, count: u32, pixel: u32, u: f32) -> f32 {
        let reach = self.filter.reach();
        let (low, high) = ((at - 0.5 - reach).ceil().max(0.0) as u32, (at - 0.5 + reach).max(0.0) as u32);
        let part = |i: u32| self.filter.density(at - i as f32 - 0.5);
        let sum = |to: u32| -> f32 { (low..to).map(part).sum() };
        let density = sum(high.min(count - 1) + 1);
        if density > 0.0 { ((sum(pixel) + u * part(pixel)) / density).min(BELOW_ONE) } else { u }
    }

    /// The density of [`Landing`] at a place.
    pub fn density(&self, place: Vec2) -> f32 {
        self.land(place, [0.0; 2]).map_or(0.0, |landing| landing.density)
    }

    /// A pixel along one axis, where pixel i's centre lies at i + 1/2, chosen by its filter's part of the density.
    #[inline]
    fn along(&self, at: f32, count: u32, u: f32) -> Option<(u32, f32)> {
        if self.is_box {
            let is_inside = at >= 0.0 && at < count as f32;
            return is_inside.then_some((at as i32 as u32, 1.0));
        }
        // From the first pixel that is reached, if the picture had no edge.
        let low = at - 0.5 - self.filter.reach();
        // Written so that no number is nowhere, too.
        let is_inside = low > 0.0 && low + self.columns.span < count as f32;
        if !is_inside {
            return self.along_the_edge(at, count, u);
        }
        let below = low as i32;
        let (step, density) = self.columns.chosen(1.0 - (low - below as f32), u);
        Some(((below + 1) as u32 + step, density))
    }

    /// [`Self::along`] at any place, for filters of any width.
    #[cold]
    fn along_the_edge(&self, at: f32, count: u32, u: f32) -> Option<(u32, f32)> {
        let reach = self.filter.reach();
        let (low, high) = (at - 0.5 - reach, at - 0.5 + reach);
        if !(high >= 0.0 && low <= count as f32 - 1.0) {
            return None;
        }
        // Casts take what is negative to 0, and cut off what is behind the point.
        let first = low as u32 + u32::from(low > (low as u32) as f32);
        let last = (high as u32).min(count - 1);
        let part = |i: u32| self.filter.density(at - i as f32 - 0.5);
        let density: f32 = (first..=last).map(part).sum();
        let mut left = u * density;
        let mut chosen = first;
        while chosen < last && left >= part(chosen) {
            left -= part(chosen);
            chosen += 1;
        }
        (density > 0.0).then_some((chosen, density))
    }
}

/// Pixels along one axis that a filter of usual width reaches.
const FEW: usize = 4;
const _: () = assert!(size_of::<Vec4>() == FEW * size_of::<f32>());

/// The sums of the filter over the pixels that it reaches, by the distance of the first of them.
struct Columns {
    /// The sums at equal steps of the distance from the beginning of the reach to the first pixel's centre, 0 to 1.
    sums: Vec<Vec4>,
    /// Pixels that must be there; infinite for a filter that has no table.
    span: f32,
}

impl Columns {
    const STEPS: usize = 512;

    fn new(filter: &PixelFilter) -> Self {
        let reach = filter.reach();
        let sums = |k: usize| {
            let first = k as f32 / Self::STEPS as f32 - reach;
            let mut sum = 0.0;
            Vec4::from_array(std::array::from_fn(|i| {
                sum += filter.density(first + i as f32);
                sum
            }))
        };
        // The box jumps: its table would be wrong between two steps. Of a filter within a few steps it would be coarse.
        let has_table = filter.is_smooth() && reach >= 0.5 && 2.0 * reach + 1.0 <= FEW as f32;
        let span = if has_table { FEW as f32 + 1.0 } else { f32::INFINITY };
        Self { sums: (0..=Self::STEPS).map(sums).collect(), span }
    }

    /// The sums at a distance of the first pixel.
    #[inline]
    fn sums_at(&self, distance: f32) -> Vec4 {
        let at = distance * Self::STEPS as f32;
        let i = (at as i32 as usize).min(Self::STEPS - 1);
        let [a, b] = self.sums[i..].first_chunk().expect("there is one more");
        *a + (*b - *a) * (at - i as f32)
    }

    /// Number of pixels behind the first of the one that `u` chooses, and its density, at a distance of the first.
    #[inline]
    fn chosen(&self, distance: f32, u: f32) -> (u32, f32) {
        let sums = self.sums_at(distance);
        let density = sums.w;
        // Without branches, for which of them it is nobody can foresee.
        let steps = Vec4::splat(u * density).cmpge(sums).bitmask() & 0b111;
        (steps.count_ones(), density)
    }
}

#[cfg(test)]
mod tests {
    use super::super::warp::Filter;
    use super::*;
    use petzval_testkit::sampling;

    /// Light of the same amount at every place of the plane makes every pixel one, to the edge, whatever the filter.
    #[test]
    fn an_even_light_is_even() {
        use Filter::{BlackmanHarris, Gaussian};
        for filter in [
            Filter::Box,
            BlackmanHarris(0.7),
            BlackmanHarris(1.0),
            BlackmanHarris(1.5),
            BlackmanHarris(2.3),
            Gaussian(0.8),
            Gaussian(1.5),
        ] {
            let raster = Raster::new(5, 4, PixelFilter::new(filter));
            let mut sums = [0.0f64; 20];
            // A whole number of places in a pixel: the box's edges then cut none.
            let n = 1440;
            let side = 12.0 / n as f32;
            for i in 0..n * n {
                let at = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) * side - Vec2::splat(3.5);
                // A fine grid of numbers that does not beat with the grid of places.
                let u = [(i as f64 * 0.618_033_988_75).fract() as f32, (i as f64 * 0.754_877_666).fract() as f32];
                let place = at / Vec2::new(5.0, 4.0) - Vec2::splat(0.5);
                if let Some(l) = raster.land(place, u) {
                    sums[(l.y * 5 + l.x) as usize] += f64::from(l.density * side * side);
                }
            }
            for sum in sums {
                // The numbers' own noise.
                assert!((sum - 1.0).abs() < 0.01, "{filter:?}: {sum}");
            }
        }
    }

    /// A sample's numbers lead from its place back to its pixel where noise is to be independent, and from nearby as a rule; of all samples of
    /// a place they are uniform.
    #[test]
    fn numbers_lead_back_to_the_pixel() {
        for filter in [Filter::BlackmanHarris(1.5), Filter::Gaussian(0.9), Filter::BlackmanHarris(3.1)] {
            let raster = Raster::new(9, 1, PixelFilter::new(filter)).independent(true);
            let (n, mut strays, mut moved, mut counts) = (450_000, 0, 0, [[0u32; 10]; 90]);
            for i in 0..n {
                let part = |x: f64| (f64::from(i) * x).fract() as f32;
                let place = raster.place(i % 9, 0, [part(0.618_033_988_7), 0.5]);
                let u = raster.numbers_of([i % 9, 0], place, [part(0.754_877_666), 0.5]);
                assert!(u.iter().all(|u| (0.0..1.0).contains(u)), "{u:?}");
                let Some(landing) = raster.land(place, u) else { continue };
                // On a boundary rounding decides.
                strays += u32::from(landing.x != i % 9);
                let bin = (place.x + 0.5) * 90.0;
                if (0.0..90.0).contains(&bin) {
                    counts[bin as usize][(u[0] * 10.0) as usize] += 1;
                }
                let near = raster.land(place + Vec2::new(0.01 / 9.0, 0.0), u);
                moved += u32::from(near.is_some_and(|near| near.x != landing.x));
            }
            // A hundredth of a pixel away one in a hundred boundaries is crossed, or a few more.
            assert!(strays < 20 && moved < n / 50, "{filter:?}: {strays} {moved}");
            for counts in counts {
                let mean = counts.iter().sum::<u32>() as f32 / 10.0;
                // Points in a low-discrepancy sequence are far more even than random ones.
                assert!(counts.iter().all(|&count| (count as f32 - mean).abs() < 0.12 * mean), "{filter:?} {counts:?}");
            }
        }
        let apart = Raster::new(9, 1, PixelFilter::new(Filter::BlackmanHarris(1.5)));
        assert_eq!(apart.numbers_of([3, 0], Vec2::ZERO, [0.25, 0.75]), [0.25, 0.75]);
    }

    /// Places of samples have the density that is said.
    #[test]
    fn places_have_their_density() {
        for filter in [Filter::Box, Filter::Gaussian(0.9), Filter::BlackmanHarris(1.5)] {
            let raster = Raster::new(3, 1, PixelFilter::new(filter));
            sampling::values(
                &format!("places of {filter:?}"),
                1 << 20,
                [0.0, 3.0],
                |random| {
                    let [pixel, u] = random.numbers();
                    let place = raster.place((pixel * 3.0) as u32, 0, [u, 0.5]).x;
                    let at = f64::from(place + 0.5) * 3.0;
                    (0.0..3.0).contains(&at).then_some(at)
                },
                |at| f64::from(raster.along_the_edge(at as f32, 3, 0.0).unwrap().1) / 3.0,
            );
        }
    }

    /// Inside, the table has the filter's values.
    #[test]
    fn the_table_is_the_filter() {
        use Filter::{BlackmanHarris, Gaussian};
        for filter in [Filter::Box, BlackmanHarris(0.8), BlackmanHarris(1.5), BlackmanHarris(4.0), Gaussian(0.9)] {
            let raster = Raster::new(40, 1, PixelFilter::new(filter));
            for i in 0..2000 {
                // Not on the edge of a box, which closed boxes on both sides hold.
                let at = 10.003 + i as f32 * 0.0103;
                let u = (i as f32 * 0.618).fract();
                let (fast, exact) = (raster.along(at, 40, u).unwrap(), raster.along_the_edge(at, 40, u).unwrap());
                assert!((fast.1 / exact.1 - 1.0).abs() < 1e-4, "{filter:?} {at}: {fast:?} {exact:?}");
                // At a boundary rounding decides.
                let near = |du: f32| raster.along_the_edge(at, 40, (u + du).clamp(0.0, 0.999_999)).unwrap().0;
                assert!(fast.0 == near(1e-4) || fast.0 == near(-1e-4), "{filter:?} {at} {u}: {fast:?} {exact:?}");
            }
        }
    }

    #[test]
    fn far_away_nothing_lands() {
        let raster = Raster::new(10, 10, PixelFilter::new(Filter::BlackmanHarris(1.5)));
        for place in [Vec2::new(9.0, 0.0), Vec2::new(0.0, -9.0), Vec2::NAN, Vec2::INFINITY] {
            assert_eq!(raster.land(place, [0.5; 2]), None);
        }
    }
}
