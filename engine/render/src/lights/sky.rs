//! Light from infinity: the world's image sampled where it is bright, and suns.

use super::LightSample;
use super::lamp::PreparedLamp;
use super::receiver::LightSampleContext;
use crate::nodes::PathState;
use crate::sampler::distribution::Grid2d;
use crate::scene::{
    Scene,
    texture::Texture,
    visibility::LightSets,
    world::{direction_to_equirectangular, equirectangular_to_direction},
};
use crate::{Rgb, luminance, nodes};
use glam::{Vec2, Vec3A, Vec4Swizzles};
use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// The most columns of the table that the world's image is sampled by. Larger tables find smaller suns in the
/// image and take longer to build.
const TABLE_WIDTH: usize = 1024;
/// Columns of the table of a smaller image, whose pixels are split into cells: an image is interpolated, and samples by whole pixels have
/// the noise of their steps. A table of 1024 columns would not stay in a cache, and a picture took 8 to 18 % more time.
const SPLIT_WIDTH: usize = 256;
/// Part of a cell's own weight that the table keeps where the image is darker than its mean.
const LEAST_KEPT: f32 = 0.01;
/// Irradiance beyond which suns are chosen alike, so that sums stay finite.
const BRIGHTEST: f32 = 1e30;

/// The lights at infinity: the world and the suns.
pub(super) struct Sky {
    // `None` where the world has one colour: a surface's own scattering samples that better.
    image: Option<ImageTables>,
    /// The image that the table was made of, and its factor.
    made_of: Option<(Arc<Texture>, Rgb)>,
    /// Approximate irradiance by the world's image, by which the world is chosen.
    world: f32,
    suns: Vec<u32>,
    /// The suns again, as they are chosen.
    discs: Vec<Disc>,
    /// True if the world's nodes ask for the kind of bounce that sees them.
    tells_bounces_apart: bool,
}

/// The densities by which the world's image is sampled.
#[derive(Clone)]
struct ImageTables {
    /// The density by the brightness of the image.
    whole: Grid2d,
    /// The density by the brightness beyond the mean of the image: MIS compensation (Karlík et al. 2019, "MIS Compensation: Optimizing Sampling
    /// Techniques in Multiple Importance Sampling", section 5.2). Samples of closures find light from all sides, and light samples go to
    /// the parts that stand out.
    /// `None` where samples of closures do not find all light that light samples find.
    compensated: Option<Grid2d>,
}

impl ImageTables {
    /// The table for a place; `None`: for light paths.
    #[inline]
    fn of(&self, to: Option<&LightSampleContext>) -> &Grid2d {
        let compensated = self.compensated.as_ref().filter(|_| to.is_some_and(|to| to.is_compensated));
        compensated.unwrap_or(&self.whole)
    }
}

/// A sun as seen from everywhere.
struct Disc {
    /// Unit, to its middle.
    towards: Vec3A,
    /// Sine of half of its angle, at most 1.
    sin: f32,
    /// Irradiance on a surface that faces it.
    irradiance: f32,
}

impl Disc {
    /// Irradiance on a surface with this normal, nearly; without one, on a surface that faces it. 0 only where it sends no light.
    #[inline]
    fn on(&self, normal: Option<Vec3A>) -> f32 {
        normal.map_or(self.irradiance, |n| self.irradiance * mean_cosine(n.dot(self.towards), self.sin))
    }
}

/// An approximation of the mean of the cosines, where they are not negative, of directions in a cone of that sine about one of that cosine.
#[inline]
fn mean_cosine(cos: f32, sin_cone: f32) -> f32 {
    if cos >= sin_cone {
        return cos;
    }
    let above = (cos + sin_cone).max(0.0);
    above * above / (4.0 * sin_cone)
}

impl Sky {
    /// `previous`: of another frame or edit, whose table is kept where the world's image is the same.
    pub(super) fn new(previous: Option<&Self>, scene: &Scene, lamps: &[PreparedLamp]) -> Self {
        let suns: Vec<u32> = (0..lamps.len() as u32).filter(|&i| lamps[i as usize].is_at_infinity()).collect();
        let made_of = scene.world.texture.map(|t| (scene.textures[t as usize].clone(), scene.world.color));
        let is_kept = |previous: &&Self| {
            let is_compensated = previous.image.as_ref().is_some_and(|tables| tables.compensated.is_some());
            is_same_image(&previous.made_of, &made_of) && is_compensated == nodes::world::finds_alike(scene)
        };
        let (image, world) = match previous.filter(is_kept) {
            Some(previous) => (previous.image.clone(), previous.world),
            None => {
                let image = image_table(scene);
                let average =
                    |(texture, color): &(Arc<Texture>, Rgb)| luminance((*color * texture.average()).abs()) * PI;
                let world = made_of.as_ref().filter(|_| image.is_some()).map_or(0.0, average);
                let world = if image.is_some() { world.max(1e-6) } else { 0.0 };
                (image, world)
            }
        };
        let disc = |&i: &u32| {
            let lamp = &lamps[i as usize];
            let (towards, half_angle_rad) = lamp.as_sun().expect("only suns are in the list");
            Disc { towards, sin: half_angle_rad.min(FRAC_PI_2).sin(), irradiance: lamp.power().clamp(0.0, BRIGHTEST) }
        };
        let discs = suns.iter().map(disc).collect();
        let tells_bounces_apart = scene.world.graph.as_ref().is_some_and(|graph| graph.reads_any(&nodes::OF_BOUNCES));
        Self { image, made_of, world, suns, discs, tells_bounces_apart }
    }

    /// Light that may arrive from the sky at a surface with this normal, in brightness, where nothing stands in the way; without one, from
    /// all sides. Sources are chosen by this. A world of one colour is not counted: it is not sampled.
    #[inline]
    pub(super) fn irradiance(&self, normal: Option<Vec3A>) -> f32 {
        self.discs.iter().fold(self.world, |sum, disc| sum + disc.on(normal))
    }

    /// Light from infinity and which it is: 0 the world, then the suns.
    pub(super) fn sample(
        &self,
        scene: &Scene,
        lamps: &[PreparedLamp],
        to: &LightSampleContext,
        (u_choice, u): (f32, [f32; 2]),
        way: PathState,
    ) -> Option<(LightSample, usize)> {
        let (index, chance) = self.choose(to, u_choice)?;
        let mut sample = match index {
            0 if u32::from(way.depth) > scene.world.max_bounces => return None,
            0 => self.sample_image(scene, Some(to), u)?,
            i => lamps[self.suns[i - 1] as usize].light(scene, Vec3A::ZERO, u, way)?,
        };
        sample.pdf *= chance;
        Some((sample, index))
    }

    /// Number of a source, chosen in proportion to the light that it may send, and the probability of that choice.
    #[inline]
    fn choose(&self, to: &LightSampleContext, u: f32) -> Option<(usize, f32)> {
        let mut left = u * to.sky;
        // Rounding may go past the last that has any.
        let mut last = None;
        let weights = std::iter::once(self.world).chain(self.discs.iter().map(|disc| disc.on(to.normal)));
        for (index, weight) in weights.enumerate() {
            if weight > 0.0 {
                last = Some((index, weight / to.sky));
                if left < weight {
                    break;
                }
                left -= weight;
            }
        }
        last
    }

    /// Calls `found(index, radiance, pdf)`: 0 is the world, the suns follow.
    pub(super) fn along(
        &self,
        scene: &Scene,
        lamps: &[PreparedLamp],
        d: Vec3A,
        way: PathState,
        to: Option<&LightSampleContext>,
        mut found: impl FnMut(usize, Rgb, f32),
    ) {
        if scene.world.visible.all_of(way.finds()) {
            let graph = scene.world.graph.as_ref().filter(|_| way.is_camera() || self.tells_bounces_apart);
            let (mut radiance, mut pdf) = (Rgb::ZERO, 0.0);
            if to.is_some() {
                (radiance, pdf) = self.image_along(scene, to, d);
                pdf *= self.chance(to, 0);
            } else if graph.is_none() {
                radiance = scene.world.radiance(d, &scene.textures);
            }
            if let Some(graph) = graph {
                // Blender counts what shines from infinity as one scattering farther.
                radiance = nodes::world::radiance(graph, scene, d, way.at_depth(u32::from(way.depth) + 1));
            }
            found(0, radiance, pdf);
        }
        for (i, &sun) in self.suns.iter().enumerate() {
            let lamp = &lamps[sun as usize];
            if !lamp.is_found_by(way) {
                continue;
            }
            if let Some((radiance, pdf)) = lamp.hit_sun(d) {
                let radiance = radiance * lamp.shine(scene, Vec3A::ZERO, d, f32::INFINITY, way.light());
                found(i + 1, radiance, pdf * self.chance(to, i + 1));
            }
        }
    }

    /// The probability with which [`Sky::sample`] chooses number `index` for a receiver; 0 without one.
    #[inline]
    pub(super) fn chance(&self, to: Option<&LightSampleContext>, index: usize) -> f32 {
        let Some(to) = to.filter(|to| to.sky > 0.0) else { return 0.0 };
        let weight = if index == 0 { self.world } else { self.discs[index - 1].on(to.normal) };
        weight / to.sky
    }

    /// The lamps that are suns.
    pub(super) fn suns(&self) -> &[u32] {
        &self.suns
    }

    /// True if the world has an image to be sampled by.
    pub(super) fn has_image(&self) -> bool {
        self.image.is_some()
    }

    /// Light of the world's image, for a place or for light paths.
    pub(super) fn sample_image(
        &self,
        scene: &Scene,
        to: Option<&LightSampleContext>,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let (p, pdf) = self.image.as_ref()?.of(to).sample(u);
        let uv = Vec2::from_array(p);
        let local = equirectangular_to_direction(uv);
        let wi = (scene.world.rotation.transpose() * local).normalize();
        let pdf = per_steradian(pdf, local)?;
        Some(LightSample {
            wi,
            distance: f32::INFINITY,
            radiance: scene.world.radiance_at(uv, &scene.textures),
            pdf,
            point_like: false,
            cast_shadow: scene.world.cast_shadow,
            reaches: scene.world.visible,
            sets: LightSets::EVERYTHING,
            leaves: None,
        })
    }

    /// The density of [`Sky::sample_image`] for light paths.
    pub(super) fn image_pdf(&self, scene: &Scene, d: Vec3A) -> f32 {
        if self.image.is_none() { 0.0 } else { self.image_along(scene, None, d).1 }
    }

    /// The world's radiance from a direction, and the density of [`Sky::sample_image`].
    fn image_along(&self, scene: &Scene, to: Option<&LightSampleContext>, d: Vec3A) -> (Rgb, f32) {
        let Some(tables) = &self.image else { return (scene.world.radiance(d, &scene.textures), 0.0) };
        let table = tables.of(to);
        let local = scene.world.rotation * d;
        let uv = direction_to_equirectangular(local);
        let pdf = table.pdf(uv.clamp(Vec2::ZERO, Vec2::ONE).to_array());
        (scene.world.radiance_at(uv, &scene.textures), per_steradian(pdf, local).unwrap_or(0.0))
    }
}

/// True if both are of the very same image, with the same factor.
fn is_same_image(a: &Option<(Arc<Texture>, Rgb)>, b: &Option<(Arc<Texture>, Rgb)>) -> bool {
    matches!((a, b), (Some((a, by)), Some((b, with))) if Arc::ptr_eq(a, b) && by == with)
}

/// A density over the image as one over directions; `None` at the poles, where it has none.
fn per_steradian(pdf: f32, local: Vec3A) -> Option<f32> {
    let sin = (local.x * local.x + local.y * local.y).sqrt();
    (sin > 0.0).then(|| pdf / (2.0 * PI * PI * sin))
}

/// Brightness times solid angle of the image's pixels, blocks of large images taken together. Each cell takes
/// its neighbours' brightness into account, since the image is interpolated: no lit direction has density 0.
fn image_table(scene: &Scene) -> Option<ImageTables> {
    let texture = &scene.textures[scene.world.texture? as usize];
    let (w, h) = texture.size();
    let block = w.div_ceil(TABLE_WIDTH).max(h.div_ceil(TABLE_WIDTH)).max(1);
    let (columns, rows) = (w.div_ceil(block), h.div_ceil(block));
    if columns * block != w || rows * block != h {
        // Sizes that do not divide: one cell a pixel keeps cells and pixels aligned.
        return table_of(scene, w, h, 1);
    }
    let split = SPLIT_WIDTH / columns.max(rows);
    if split > 1 { fine_table_of(scene, columns * split, rows * split) } else { table_of(scene, columns, rows, block) }
}

/// The table of cells smaller than the pixels of the image.
fn fine_table_of(scene: &Scene, columns: usize, rows: usize) -> Option<ImageTables> {
    let brightness = (0..columns * rows).map(|i| {
        let place = Vec2::new((i % columns) as f32 + 0.5, (i / columns) as f32 + 0.5);
        let uv = place / Vec2::new(columns as f32, rows as f32);
        luminance(scene.world.radiance_at(uv, &scene.textures).abs())
    });
    table_by(scene, brightness.collect(), columns, rows)
}

fn table_of(scene: &Scene, columns: usize, rows: usize, block: usize) -> Option<ImageTables> {
    let texture = &scene.textures[scene.world.texture? as usize];
    let brightness = (0..columns * rows)
        .map(|i| {
            let (x0, y0) = ((i % columns) * block, (i / columns) * block);
            let mut sum = 0.0;
            for y in y0..y0 + block {
                for x in x0..x0 + block {
                    sum += luminance((scene.world.color * texture.texel(x, y).xyz()).abs());
                }
            }
            sum / (block * block) as f32
        })
        .collect();
    table_by(scene, brightness, columns, rows)
}

/// The tables of cells of that brightness.
fn table_by(scene: &Scene, brightness: Vec<f32>, columns: usize, rows: usize) -> Option<ImageTables> {
    let cosines: Vec<f32> = (0..rows).map(|y| (((y as f32 + 0.5) / rows as f32 - 0.5) * PI).cos()).collect();
    let weights: Vec<f32> = (0..columns * rows)
        .map(|i| {
            let (x, y) = (i % columns, i / columns);
            let at = |dx: usize, dy: usize| {
                let yy = (y + dy).saturating_sub(1).min(rows - 1);
                brightness[yy * columns + (x + dx + columns - 1) % columns]
            };
            let mut around = 0.0f32;
            for dy in 0..3 {
                for dx in 0..3 {
                    around += at(dx, dy);
                }
            }
            (0.75 * brightness[i] + 0.25 * around / 9.0) * cosines[y]
        })
        .collect();
    let sum = |numbers: &[f32]| numbers.iter().map(|&number| f64::from(number)).sum::<f64>();
    let mean = (sum(&weights) / (sum(&cosines) * columns as f64)) as f32;
    let whole = Grid2d::new(&weights, columns, rows)?;
    let beyond = |(i, &weight): (usize, &f32)| (weight - mean * cosines[i / columns]).max(LEAST_KEPT * weight);
    let beyond: Vec<f32> = weights.iter().enumerate().map(beyond).collect();
    let compensated = if nodes::world::finds_alike(scene) { Grid2d::new(&beyond, columns, rows) } else { None };
    Some(ImageTables { whole, compensated })
}

#[cfg(test)]
mod tests;
