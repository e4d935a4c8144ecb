//! Images and their lookup: interpolation, and extension outside of the picture.

use super::SceneError;
use crate::Rgb;
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use petzval_nodes::{MISSING, unassociated};
use std::sync::{Arc, LazyLock};

/// The continuation of an image outside of the unit square (Blender's Image Texture node).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extension {
    /// Repeats the image.
    #[default]
    Repeat,
    /// Continues its edge pixels.
    Extend,
    /// Transparent black outside of the image.
    Clip,
    /// Tiles, every other one mirrored.
    Mirror,
}

/// The interpolation between pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Bilinear between the four nearest pixels.
    #[default]
    Linear,
    /// The value of the nearest pixel.
    Closest,
}

#[derive(Clone, Debug)]
enum TexturePixels {
    // Eight bits a channel stay eight bits.
    Bytes { rgba: Vec<[u8; 4]>, srgb: bool },
    Floats(Vec<Vec4>),
}

/// The largest value of a pixel: differences of such are numbers, too.
const BRIGHTEST: f32 = 1e30;

/// An image, first row at the bottom as Blender stores it; or the tiles of one (UDIM). Lookups give scene-linear values.
#[derive(Clone, Debug)]
pub struct Texture {
    name: String,
    width: usize,
    height: usize,
    pixels: TexturePixels,
    /// The tiles by their numbers, which grow: 1001 + column + 10 row. The pixels are then those of a place without a tile. Empty of an image that
    /// has no tiles.
    tiles: Vec<(u32, Arc<Texture>)>,
}

/// The number of the first tile, at column 0 and row 0.
const FIRST_TILE: u32 = 1001;

/// Number of columns of tiles.
const TILE_COLUMNS: i32 = 10;

impl Texture {
    /// A texture of eight-bit RGBA.
    ///
    /// # Errors
    /// [`SceneError::BadImage`] where the number of values is not `width * height * 4`.
    pub fn from_bytes(name: &str, width: usize, height: usize, rgba: &[u8], srgb: bool) -> Result<Self, SceneError> {
        check(name, width, height, rgba.len())?;
        let rgba = rgba.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
        Ok(Self::of_pixels(name, width, height, TexturePixels::Bytes { rgba, srgb }))
    }

    /// A texture of floating-point RGBA; values that are not finite become 0.
    ///
    /// # Errors
    /// As [`Texture::from_bytes`].
    pub fn from_floats(name: &str, width: usize, height: usize, rgba: &[f32], srgb: bool) -> Result<Self, SceneError> {
        check(name, width, height, rgba.len())?;
        let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
        let bounded = |x: f32| x.clamp(-BRIGHTEST, BRIGHTEST);
        let decode = |x: f32| bounded(if srgb { srgb_to_linear(finite(x)) } else { finite(x) });
        let texels = rgba
            .chunks_exact(4)
            .map(|p| Vec4::new(decode(p[0]), decode(p[1]), decode(p[2]), bounded(finite(p[3]))))
            .collect();
        Ok(Self::of_pixels(name, width, height, TexturePixels::Floats(texels)))
    }

    /// A black pixel, where there is no image.
    pub fn empty() -> Self {
        Self::of_pixels("", 1, 1, TexturePixels::Floats(vec![Vec4::ZERO]))
    }

    /// An image of tiles (UDIM) by their numbers, 1001 + column + 10 row, each a unit square of UV space with its own size. Where there is
    /// no tile it shows the colour of missing images, alpha 1.
    ///
    /// # Errors
    /// [`SceneError::BadTiles`] where two tiles have one number, or a number is below 1001.
    pub fn from_tiles(name: &str, mut tiles: Vec<(u32, Arc<Self>)>) -> Result<Self, SceneError> {
        tiles.sort_by_key(|(number, _)| *number);
        let is_twice = tiles.windows(2).find(|pair| pair[0].0 == pair[1].0).map(|pair| pair[0].0);
        if let Some(number) = tiles.first().map(|tile| tile.0).filter(|first| *first < FIRST_TILE).or(is_twice) {
            return Err(SceneError::BadTiles { image: name.into(), number });
        }
        let missing = TexturePixels::Floats(vec![Vec3::from(MISSING).extend(1.0)]);
        Ok(Self { tiles, ..Self::of_pixels(name, 1, 1, missing) })
    }

    fn of_pixels(name: &str, width: usize, height: usize, pixels: TexturePixels) -> Self {
        Self { name: name.into(), width, height, pixels, tiles: Vec::new() }
    }

    /// Name of the image in Blender.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width and height of the image, pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// One pixel, linear RGBA.
    pub fn texel(&self, x: usize, y: usize) -> Vec4 {
        self.decoded(self.stored(x, y))
    }

    /// One pixel as it is stored.
    #[inline]
    fn stored(&self, x: usize, y: usize) -> Vec4 {
        let i = y * self.width + x;
        match &self.pixels {
            TexturePixels::Floats(p) => p[i],
            TexturePixels::Bytes { rgba, .. } => Vec4::from(rgba[i].map(f32::from)) * (1.0 / 255.0),
        }
    }

    /// A stored value, or one between stored values, made linear.
    #[inline]
    fn decoded(&self, v: Vec4) -> Vec4 {
        match self.pixels {
            TexturePixels::Bytes { srgb: true, .. } => {
                let table = &*SRGB;
                let linear = |v: f32| {
                    let place = v.clamp(0.0, 1.0) * SRGB_STEPS as f32;
                    let before = (place as usize).min(SRGB_STEPS - 1);
                    table[before] + (table[before + 1] - table[before]) * (place - before as f32)
                };
                Vec4::new(linear(v.x), linear(v.y), linear(v.z), v.w)
            }
            _ => v,
        }
    }

    /// The value at `uv`, linear RGBA. Between pixels, eight-bit sRGB is interpolated as it is stored and decoded
    /// after, as Cycles does. Of tiles each is looked up by itself: nothing is interpolated from one to the next.
    pub fn lookup(&self, uv: Vec2, interpolation: Interpolation, extension: Extension) -> Vec4 {
        self.decoded_at(uv, interpolation, extension, |stored| stored)
    }

    /// The value as by [`Self::lookup`], its colours divided by alpha before they are decoded (Cycles, `svm_image_texture`): the colour of
    /// pixels of alpha 0 does not count, and where all is transparent it is black.
    pub fn unassociated(&self, uv: Vec2, interpolation: Interpolation, extension: Extension) -> Vec4 {
        self.decoded_at(uv, interpolation, extension, unassociated)
    }

    #[inline(always)]
    fn decoded_at(
        &self,
        uv: Vec2,
        interpolation: Interpolation,
        extension: Extension,
        change: impl Fn(Vec4) -> Vec4,
    ) -> Vec4 {
        let (image, uv) = if self.tiles.is_empty() {
            (self, uv)
        } else if let Some(found) = self.tile_at(uv) {
            found
        } else {
            return self.texel(0, 0);
        };
        image.decoded(change(image.interpolated(uv, interpolation, extension)))
    }

    /// The tile at a place, and the place on it. As in Cycles the tiles of the first column and row reach to -1, where the place on them is
    /// negative and the extension counts.
    fn tile_at(&self, uv: Vec2) -> Option<(&Self, Vec2)> {
        let (column, row) = (uv.x as i32, uv.y as i32);
        if !(0..TILE_COLUMNS).contains(&column) || row < 0 {
            return None;
        }
        let number = (row as u32).saturating_mul(TILE_COLUMNS as u32).saturating_add(FIRST_TILE + column as u32);
        let found = self.tiles.binary_search_by_key(&number, |(number, _)| *number).ok()?;
        Some((&self.tiles[found].1, uv - Vec2::new(column as f32, row as f32)))
    }

    fn interpolated(&self, uv: Vec2, interpolation: Interpolation, extension: Extension) -> Vec4 {
        // Tiles are looked up in the first one: what is outside of it is then a pixel outside at most, and needs no division.
        let uv = if extension == Extension::Repeat { uv - uv.floor() } else { uv };
        let x = uv.x * self.width as f32;
        let y = uv.y * self.height as f32;
        if !(x.is_finite() && y.is_finite()) {
            return Vec4::ZERO;
        }
        let column = |x: i64| folded(x, self.width as i64, extension);
        let row = |y: i64| folded(y, self.height as i64, extension);
        let at = |x: Option<usize>, y: Option<usize>| match (x, y) {
            (Some(x), Some(y)) => self.stored(x, y),
            _ => Vec4::ZERO,
        };
        match interpolation {
            Interpolation::Closest => at(column(x.floor() as i64), row(y.floor() as i64)),
            Interpolation::Linear => {
                let (fx, fy) = ((x - 0.5).floor(), (y - 0.5).floor());
                let (ix, iy) = (fx as i64, fy as i64);
                let (tx, ty) = (x - 0.5 - fx, y - 0.5 - fy);
                let columns = [column(ix), column(ix.saturating_add(1))];
                let between = |y: Option<usize>| {
                    let a = at(columns[0], y);
                    a + (at(columns[1], y) - a) * tx
                };
                let (a, b) = (between(row(iy)), between(row(iy.saturating_add(1))));
                a + (b - a) * ty
            }
        }
    }

    /// The average colour, for choosing lights.
    pub fn average(&self) -> Rgb {
        // Every 16th row and column of a large image is enough to choose by.
        let step = (self.width.min(self.height) / 64).max(1);
        let mut sum = Rgb::ZERO;
        let mut count = 0.0;
        for y in (0..self.height).step_by(step) {
            for x in (0..self.width).step_by(step) {
                sum += self.texel(x, y).xyz();
                count += 1.0;
            }
        }
        sum / count
    }
}

/// The column or row, of `n`, that stands at a place outside of the image; `None` where nothing does. Of a place that repeats it is
/// at most one beyond the edge.
#[inline]
fn folded(i: i64, n: i64, extension: Extension) -> Option<usize> {
    if (0..n).contains(&i) {
        return Some(i as usize);
    }
    let i = match extension {
        Extension::Repeat if i < 0 => n - 1,
        Extension::Repeat => 0,
        Extension::Extend => i.clamp(0, n - 1),
        Extension::Clip => return None,
        Extension::Mirror => mirror(i, n),
    };
    Some(i as usize)
}

fn mirror(x: i64, n: i64) -> i64 {
    let m = x.rem_euclid(2 * n);
    if m < n { m } else { 2 * n - 1 - m }
}

fn check(name: &str, width: usize, height: usize, values: usize) -> Result<(), SceneError> {
    if width > 0 && height > 0 && width.checked_mul(height).and_then(|n| n.checked_mul(4)) == Some(values) {
        return Ok(());
    }
    Err(SceneError::BadImage { image: name.into(), pixels: values, width, height })
}

/// Steps of [`SRGB`]: between two of them the function is right to a ten-thousandth, where a byte is one part in 255.
const SRGB_STEPS: usize = 2040;

/// [`srgb_to_linear`] from 0 to 1, eight steps for each of a byte's: of these every eighth is exact.
static SRGB: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=SRGB_STEPS).map(|i| srgb_to_linear(i as f32 / SRGB_STEPS as f32)).collect());

/// The sRGB transfer function (IEC 61966-2-1), continued linearly below zero.
pub fn srgb_to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Texture {
        // Red is the column, green the row.
        let rgba: Vec<f32> = (0..4).flat_map(|y| (0..4).flat_map(move |x| [x as f32, y as f32, 0.0, 1.0])).collect();
        Texture::from_floats("ramp", 4, 4, &rgba, false).unwrap()
    }

    #[test]
    fn pixel_centres_are_exact_and_between_is_linear() {
        let t = ramp();
        let at = |u: f32, v: f32| t.lookup(Vec2::new(u, v), Interpolation::Linear, Extension::Extend);
        assert_eq!(at(0.375, 0.625), Vec4::new(1.0, 2.0, 0.0, 1.0));
        assert_eq!(at(0.5, 0.625).x, 1.5);
        let closest = t.lookup(Vec2::new(0.49, 0.51), Interpolation::Closest, Extension::Extend);
        assert_eq!((closest.x, closest.y), (1.0, 2.0));
    }

    /// No number of an image is none, nor one between two pixels, whatever its values are.
    #[test]
    fn values_are_numbers() {
        let rgba = [f32::MAX, f32::NAN, f32::NEG_INFINITY, 1.0, -f32::MAX, 0.0, f32::MIN, 1.0].repeat(2);
        for srgb in [false, true] {
            let texture = Texture::from_floats("x", 2, 2, &rgba, srgb).unwrap();
            let value = texture.lookup(Vec2::new(0.4, 0.6), Interpolation::Linear, Extension::Repeat);
            assert!(value.is_finite(), "{srgb}: {value}");
        }
    }

    #[test]
    fn outside_is_as_asked() {
        let t = ramp();
        let at = |u: f32, e| t.lookup(Vec2::new(u, 0.5), Interpolation::Closest, e).x;
        assert_eq!(at(1.1, Extension::Repeat), 0.0);
        assert_eq!(at(-0.1, Extension::Repeat), 3.0);
        assert_eq!(at(1.1, Extension::Extend), 3.0);
        assert_eq!(at(1.1, Extension::Mirror), 3.0);
        assert_eq!(at(1.9, Extension::Mirror), 0.0);
        assert_eq!(at(1.1, Extension::Clip), 0.0);
        assert_eq!(at(f32::NAN, Extension::Repeat), 0.0);
        assert_eq!(at(1e30, Extension::Extend), 3.0);
    }

    #[test]
    fn tiles_meet() {
        let t = ramp();
        let at = |u: f32, v: f32| t.lookup(Vec2::new(u, v), Interpolation::Linear, Extension::Repeat);
        // Half way between the last column and the first one of the next tile; on both edges of both ways.
        for whole in [-3.0, -1.0, 0.0, 1.0, 7.0] {
            assert_eq!(at(whole, 0.375), Vec4::new(1.5, 1.0, 0.0, 1.0));
            assert_eq!(at(0.375, whole), Vec4::new(1.0, 1.5, 0.0, 1.0));
            assert_eq!(at(whole + 0.625, 0.5), at(0.625, 0.5));
        }
        let pixel = Texture::from_floats("pixel", 1, 1, &[0.25, 0.5, 0.75, 1.0], false).unwrap();
        for u in [-1e30, -1e-9, 0.0, 0.49, 0.51, 1.0, 1e9] {
            for interpolation in [Interpolation::Linear, Interpolation::Closest] {
                assert_eq!(pixel.lookup(Vec2::new(u, -u), interpolation, Extension::Repeat).x, 0.25, "{u}");
            }
        }
    }

    #[test]
    fn each_tile_is_looked_up_by_itself() {
        let wide = Texture::from_floats("wide", 2, 1, &[1.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 1.0], false).unwrap();
        let tiles = vec![(1012, Arc::new(wide)), (1001, Arc::new(ramp()))];
        let t = Texture::from_tiles("tiles", tiles.clone()).unwrap();
        let at = |u: f32, v: f32, e| t.lookup(Vec2::new(u, v), Interpolation::Closest, e);
        let missing = Vec4::new(1.0, 0.0, 1.0, 1.0);
        for extension in [Extension::Repeat, Extension::Extend, Extension::Clip, Extension::Mirror] {
            assert_eq!(at(0.9, 0.1, extension), Vec4::new(3.0, 0.0, 0.0, 1.0));
            assert_eq!(at(1.1, 1.9, extension).x, 1.0);
            assert_eq!(at(1.9, 1.1, extension).x, 2.0);
            // Without a tile, beyond the ten columns, below, above; and far beyond what a tile's number holds.
            for (u, v) in [(1.5, 0.5), (0.5, 1.5), (10.5, 0.5), (-1.5, 0.5), (0.5, -1.5), (0.5, 1e30), (-1e30, 0.5)] {
                assert_eq!(at(u, v, extension), missing, "{u} {v}");
            }
            assert!(at(f32::NAN, 0.5, extension).is_finite());
        }
        // From -1 to 0 the first tiles go on as the extension says.
        assert_eq!(at(-0.1, 0.1, Extension::Repeat).x, 3.0);
        assert_eq!(at(-0.1, 0.1, Extension::Extend).x, 0.0);
        assert_eq!(at(-0.1, 0.1, Extension::Clip), Vec4::ZERO);
        // At the edge of a tile the interpolation is with its own other edge, whatever stands beside it.
        let edge = t.lookup(Vec2::new(1.999_999, 1.5), Interpolation::Linear, Extension::Repeat);
        assert!((edge.x - 1.5).abs() < 1e-4, "{edge}");
        assert!(Texture::from_tiles("twice", vec![tiles[0].clone(), tiles[0].clone()]).is_err());
        assert!(Texture::from_tiles("low", vec![(1000, tiles[0].1.clone())]).is_err());
    }

    #[test]
    fn the_table_of_srgb_is_its_function() {
        let t = Texture::from_bytes("b", 2, 1, &[0, 0, 0, 255, 255, 255, 255, 255], true).unwrap();
        for i in 0..=100_000 {
            let v = i as f32 / 100_000.0;
            let found = t.lookup(Vec2::new(0.25 + 0.5 * v, 0.5), Interpolation::Linear, Extension::Extend).x;
            assert!((found - srgb_to_linear(v)).abs() <= 1e-4 * srgb_to_linear(v) + 1e-7, "{v}: {found}");
        }
    }

    /// Half way from a pixel of alpha 0 to an opaque one of half the light: its colour, and not a mixture; and black where all is transparent.
    #[test]
    fn colours_are_divided_by_alpha_before_they_are_decoded() {
        let t = Texture::from_bytes("b", 2, 1, &[0, 0, 0, 0, 188, 188, 188, 255], true).unwrap();
        let at = |u: f32| t.unassociated(Vec2::new(u, 0.5), Interpolation::Linear, Extension::Extend);
        for (u, alpha) in [(0.5, 0.5), (0.3, 0.1), (0.7, 0.9), (1.0, 1.0)] {
            assert!((at(u).x - 0.5029).abs() < 1e-3 && (at(u).w - alpha).abs() < 1e-5, "{u}: {}", at(u));
        }
        assert_eq!(at(0.0), Vec4::ZERO);
        let mixed = t.lookup(Vec2::new(0.5, 0.5), Interpolation::Linear, Extension::Extend);
        assert!((mixed.x - srgb_to_linear(0.5 * 188.0 / 255.0)).abs() < 1e-4);
        let tiles = Texture::from_tiles("tiles", vec![(1002, Arc::new(t.clone()))]).unwrap();
        let on_tile = tiles.unassociated(Vec2::new(1.5, 0.5), Interpolation::Linear, Extension::Extend);
        assert_eq!(on_tile, at(0.5));
    }

    #[test]
    fn srgb_bytes_are_decoded() {
        let t = Texture::from_bytes("b", 1, 1, &[255, 188, 0, 128], true).unwrap();
        let p = t.texel(0, 0);
        // 188/255 is close to half the light: (0.7373 + 0.055)/1.055 to the power 2.4.
        assert!((p.y - 0.5029).abs() < 1e-3 && p.x == 1.0 && (p.w - 0.50196).abs() < 1e-4);
        assert!(Texture::from_bytes("b", 2, 1, &[0; 4], true).is_err());
        // Half way between black and white: half the code, a fifth of the light.
        let t = Texture::from_bytes("b", 2, 1, &[0, 0, 0, 255, 255, 255, 255, 255], true).unwrap();
        let between = t.lookup(Vec2::new(0.5, 0.5), Interpolation::Linear, Extension::Extend);
        assert!((between.x - 0.2140).abs() < 1e-3, "{between}");
    }
}
