//! The choice of the lights that send rays to the lens, measured before a render.

use crate::camera::lens::real_lens::RealLens;
use crate::camera::lens::setup::LensInfo;
use crate::camera::shutter::Exposure;
use crate::camera::{CameraDescription, Model, clip::Clip, lens_info};
use crate::integrator::PreparedScene;
use crate::integrator::aimed::{AimedLights, StandingLens};
use crate::integrator::path::{Limits, NoAovs, Wavefront};
use crate::lights::SourceGroup;
use crate::luminance;
use crate::sampler::{PathSampler, mix, raster::Raster};
use crate::scene::motion::MIDDLE;
use glam::{DVec3, Vec2};
use serde::Serialize;
use std::f64::consts::{FRAC_PI_4, PI};
use std::sync::Arc;
use std::time::Instant;

/// Camera rays that hit a group, for each pixel that it lights and sample of the pixel, up to which the group is aimed from.
const FEW_HITS: f32 = 0.5;
/// Camera rays that hit a group, likewise, by geometry alone, up to which the group is measured at all.
const MAYBE_FEW_HITS: f64 = 1.0;
/// Angle between the axis and a corner's view from which on anything may be in the picture.
const WIDEST_RAD: f64 = 1.2;
/// Noise of a group in one sample of a pixel, scene-linear, below which nobody sees it.
const LEAST_NOISE: f32 = 0.02;
/// Pixels that a group has to light.
const LEAST_PIXELS: f32 = 4.0;
/// Rays from each group by which it is measured, and from all.
const MEASURED: [u32; 2] = [128, 1 << 14];
/// Groups that are measured, the largest first.
const MOST_GROUPS: usize = 512;
/// One in this many pairs of places where rays arrive counts as near.
const NEAR_PAIRS: usize = 64;
/// Least distance of places that is looked at, pixels.
const LEAST_DISTANCE_PX: f32 = 2.0;
/// Most rays from lights for each camera ray.
const MOST_RAYS: f32 = 0.5;
/// Most rays from lights for each pixel that they cover and sample.
const MOST_RAYS_A_PIXEL: f32 = 8.0;
/// Rays from lights for each camera ray, up to which pixels get more than one a sample: as many take an eighth of the time.
const CHEAP_RAYS: f32 = 0.1;
/// The seed of the rays that measure, apart from those of the picture.
const MEASURING_SEED: u32 = 0x2545_f491;

/// The decision on a scene's lights.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AimedReport {
    /// Lamps and objects that glow, as the camera could see them.
    pub lights: usize,
    /// The number of those lights that send rays to the lens.
    pub aimed: usize,
    /// Rays from them for each camera ray.
    pub rays_per_sample: f32,
    /// Camera rays that would hit the most seldom hit of them, for each pixel that it lights and sample.
    pub camera_hits: f32,
    /// Wall time of the decision, s.
    pub seconds: f64,
}

/// The measurement of a group.
struct Measured {
    /// Camera rays that hit it in a sample of every pixel.
    hits: f32,
    /// Pixels that it lights.
    pixels: f32,
    /// Luminance that it adds to each of them.
    light: f32,
}

impl Measured {
    fn hits_per_pixel(&self) -> f32 {
        self.hits / self.pixels
    }

    fn is_worth_it(&self, film_exposure: f32) -> bool {
        let hits = self.hits_per_pixel();
        // A pixel is hit with that probability: mean and variance of a sample.
        let noise = self.light * film_exposure / hits.max(f32::MIN_POSITIVE).sqrt();
        self.pixels >= LEAST_PIXELS && hits < FEW_HITS && noise > LEAST_NOISE
    }
}

/// The circumstances of a render in which lights may be aimed from.
pub struct AimingContext<'a> {
    /// The scene.
    pub stage: &'a PreparedScene,
    /// The one lens of the render.
    pub lens: &'a Arc<RealLens>,
    /// Places of the lens while the shutter is open.
    pub exposure: Option<&'a Exposure>,
    /// The clip planes of the camera.
    pub clip: Option<Clip>,
    /// The picture.
    pub raster: &'a Raster,
    /// Limits of light transport.
    pub limits: &'a Limits,
    /// Factor of the finished light.
    pub film_exposure: f32,
    /// The part of the picture's pixels that has samples.
    pub rendered: f32,
    /// Seed of all random choices.
    pub seed: u32,
}

/// True if a group may be small beside its blur and in the picture, as a thin lens in the entrance pupil would have it: this costs nothing,
/// while measuring needs the map of the entrance pupil. `at` is the middle of the group in lens space, mm.
fn may_be_small(group: &SourceGroup, info: &LensInfo, scale_mm: f64, at: DVec3) -> bool {
    let Some(pupil_mm) = info.entrance_pupil_diameter_mm else { return true };
    let distance_mm = -at.z;
    let radius_mm = f64::from(group.radius) * scale_mm;
    let sharp = info.focus_distance_mm.map_or(0.0, f64::recip);
    let blur_mm = pupil_mm * (1.0 - distance_mm * sharp).abs();
    let reach_mm = radius_mm + 0.5 * blur_mm;
    match info.widest_angle_rad {
        // A group that is so near may be anywhere.
        Some(widest) if widest < WIDEST_RAD && at.length() > 2.0 * reach_mm => {
            let off_axis = at.truncate().length().atan2(distance_mm);
            if off_axis - (reach_mm / at.length()).asin() > widest {
                return false;
            }
        }
        _ => {}
    }
    let disc = FRAC_PI_4 * blur_mm * blur_mm;
    // As far apart as they can be: the discs of all sources beside each other, but within the group's own bounds.
    let spread = (disc * group.sources.len() as f64).min(PI * reach_mm * reach_mm).max(disc);
    f64::from(group.seen_area) * scale_mm * scale_mm < MAYBE_FEW_HITS * spread
}

/// True if a group may be worth aiming from, by its size and place alone.
fn may_be_worth_it_from(lens: StandingLens<'_>, group: &SourceGroup) -> bool {
    may_be_small(group, lens.lens.info(), lens.lens.scale_mm(), lens.lens.in_lens_space(lens.place(group.center)))
}

/// True if any light of a scene may be worth aiming from in a picture of that size, by its size and place alone.
pub fn may_be_worth_it_through(stage: &PreparedScene, d: &CameraDescription, [width, height]: [u32; 2]) -> bool {
    let scale = d.scale_mm_per_unit;
    if d.model != Model::Lens || scale.x != scale.y || scale.y != scale.z {
        return false;
    }
    let groups = stage.lights.seen_groups();
    // What is wrong with the lens is told by who makes the camera.
    if groups.is_empty() {
        return false;
    }
    let (Ok(info), Ok(axes)) = (lens_info(d, width, height), d.axes()) else { return false };
    let scaled = |p: DVec3| axes.transpose() * (p + stage.scene.origin - d.position()) * scale.x;
    groups.iter().any(|group| may_be_small(group, &info, scale.x, scaled(group.center.as_dvec3())))
}

/// True if any light of a scene may be worth aiming from, by its size and place alone.
pub fn may_be_worth_it(stage: &PreparedScene, lens: &RealLens, exposure: Option<&Exposure>) -> bool {
    let lens = StandingLens::at_moment(lens, exposure, MIDDLE);
    stage.lights.seen_groups().iter().any(|group| may_be_worth_it_from(lens, group))
}

impl AimingContext<'_> {
    /// The lights that are worth it: small beside the blur that the lens makes of them, and bright enough for their noise to be seen.
    /// `None` where there are none.
    pub fn choose(&self) -> (Option<AimedLights>, AimedReport) {
        let start = Instant::now();
        let groups = self.stage.lights.seen_groups();
        let lights = groups.len();
        let mut groups: Vec<SourceGroup> =
            groups.iter().filter(|group| may_be_worth_it_from(self.standing(), group)).cloned().collect();
        groups.sort_by(|a, b| b.seen_area.total_cmp(&a.seen_area));
        groups.truncate(MOST_GROUPS);
        let (width, height) = self.raster.size();
        let pixels = width as f32 * height as f32;
        let mut chosen = Vec::new();
        let mut camera_hits = f32::INFINITY;
        let rays = MEASURED[0].min(MEASURED[1] / groups.len().max(1) as u32).max(16);
        for group in &mut groups {
            let towards = (self.standing().at() - group.center).normalize_or_zero();
            // A closed surface may be turned inside out.
            let measured = [towards, -towards].into_iter().find_map(|towards| {
                self.stage.lights.face(&self.stage.scene, group, towards);
                self.measure(group, rays)
            });
            let Some(measured) = measured else { continue };
            if measured.is_worth_it(self.film_exposure) {
                camera_hits = camera_hits.min(measured.hits_per_pixel());
                chosen.push((&*group, measured.pixels / pixels));
            }
        }
        let mut report = AimedReport { lights, ..AimedReport::default() };
        let wanted: f32 = chosen.iter().map(|(_, rays)| rays).sum();
        let aimed = (wanted > 0.0).then(|| {
            let rays = rays_per_sample(wanted / self.rendered);
            let parts = chosen.iter().map(|&(group, rays)| (group, rays / wanted));
            let mut aimed = AimedLights::new(self.lens, self.exposure, rays, self.seed);
            aimed.share_out(parts, self.rendered);
            aimed
        });
        if let Some(aimed) = &aimed {
            report.aimed = chosen.len();
            report.rays_per_sample = aimed.rays_per_sample();
            report.camera_hits = camera_hits;
        }
        report.seconds = start.elapsed().as_secs_f64();
        (aimed, report)
    }

    fn standing(&self) -> StandingLens<'_> {
        StandingLens::at_moment(self.lens, self.exposure, MIDDLE)
    }

    /// Measures a group by rays from it; `None` where none of them is seen.
    fn measure(&self, group: &SourceGroup, rays: u32) -> Option<Measured> {
        match self.stage.media.is_empty() {
            true => self.measure_by(Wavefront::<NoAovs, false>::noting(NoAovs), group, rays),
            false => self.measure_by(Wavefront::<NoAovs, true>::noting(NoAovs), group, rays),
        }
    }

    fn measure_by<const VOLUMES: bool>(
        &self,
        mut wave: Wavefront<NoAovs, VOLUMES>,
        group: &SourceGroup,
        rays: u32,
    ) -> Option<Measured> {
        let lens = self.standing();
        let area: f32 = group.sources.iter().map(|(_, area)| area).sum();
        if area <= 0.0 {
            return None;
        }
        let mut flights = Vec::new();
        for i in 0..rays {
            // Independent of each other: what is stratified has fewer near pairs. The same for each group: the decision on one does not
            // depend on its place among the others, which rounding changes where two are as large.
            let mut sampler = PathSampler::numbered(0, i ^ mix(MEASURING_SEED));
            let [u_source, u0, u1, u2] = sampler.next_4d();
            let [u3, u_column, u_row, u_set] = sampler.next_4d();
            let mut rest = u_source * area;
            let place = group.sources.iter().position(|(_, its)| {
                rest -= its;
                rest < 0.0
            });
            let (source, its) = group.sources[place.unwrap_or(group.sources.len() - 1)];
            let numbers = [[u0, u1], [u2, u3], [u_column, u_row]];
            let Some(flight) = lens.fly(self.stage, self.raster, source, numbers, u_set, MIDDLE) else { continue };
            let ray = self.clip.map_or(flight.ray, |clip| clip.cut(flight.ray));
            let ray = self.exposure.map_or(ray, |exposure| exposure.sent(ray, MIDDLE));
            wave.start_aimed(ray, sampler, source);
            flights.push((flight, its / area));
        }
        wave.follow(self.stage, self.limits);
        let (width, height) = self.raster.size();
        let pixels = width as f32 * height as f32;
        let per_ray = pixels / rays as f32;
        let (mut hits, mut light) = (0.0, 0.0);
        let mut places = Vec::new();
        for (i, (flight, chance)) in flights.iter().enumerate() {
            let radiance = wave.found(i).radiance;
            let Some(splat) = flight.splats.as_slice().first() else { continue };
            if !(radiance.is_finite() && luminance(radiance.abs()) > 0.0) {
                continue;
            }
            let density = flight.density * chance;
            hits += per_ray * flight.camera_density / density;
            self.lens.expose(&flight.splats, radiance.abs(), |_, _, added| {
                light += per_ray * luminance(added.truncate()) / density;
            });
            places.push(Vec2::new(splat.x as f32, splat.y as f32));
        }
        let lit = covered(&places)?;
        Some(Measured { hits, pixels: lit.min(pixels), light: light / lit })
    }
}

/// Rays from lights for each camera ray, where `one_a_pixel` are one for each pixel that they cover and sample.
fn rays_per_sample(one_a_pixel: f32) -> f32 {
    (one_a_pixel * (CHEAP_RAYS / one_a_pixel).clamp(1.0, MOST_RAYS_A_PIXEL)).min(MOST_RAYS)
}

/// Pixels that light of this distribution covers, as it would if it were even: one over the integral of the squared density; `None` of no
/// light.
fn covered(places: &[Vec2]) -> Option<f32> {
    let mut distances: Vec<f32> = Vec::new();
    for (i, a) in places.iter().enumerate() {
        distances.extend(places[..i].iter().map(|b| a.distance_squared(*b)));
    }
    if distances.is_empty() {
        return (!places.is_empty()).then_some(1.0);
    }
    // Two places are as near as this by chance: the area about one over all of it. Of whole pixels nothing nearer is told apart.
    let near = (distances.len() / NEAR_PAIRS).min(distances.len() - 1);
    let (_, nearest2, _) = distances.select_nth_unstable_by(near, f32::total_cmp);
    let within2 = nearest2.max(LEAST_DISTANCE_PX * LEAST_DISTANCE_PX);
    let count = distances.iter().filter(|distance2| **distance2 <= within2).count();
    Some((std::f32::consts::PI * within2 * distances.len() as f32 / count.max(1) as f32).max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::warp;

    /// Places at random on discs of a radius, in whole pixels.
    fn on_discs(middles: &[Vec2], radius: f32) -> Vec<Vec2> {
        let place = |i: u32| {
            let [u0, u1, u2, _] = PathSampler::numbered(0, i).next_4d();
            let disc = middles[(u0 * middles.len() as f32) as usize];
            (disc + warp::sample_disk([u1, u2]) * radius).floor()
        };
        (0..MEASURED[0]).map(place).collect()
    }

    #[test]
    fn few_pixels_get_many_rays_and_many_pixels_one() {
        for (one_a_pixel, rays) in [(0.001, 0.008), (0.0125, 0.1), (0.05, 0.1), (0.3, 0.3), (0.9, 0.5)] {
            assert!((rays_per_sample(one_a_pixel) / rays - 1.0).abs() < 1e-6, "{one_a_pixel}");
        }
    }

    /// By 128 places, of which a 64th of the pairs is near, to a tenth; and places at the edge of a disc have fewer near them, which makes a
    /// sixth for the smallest.
    #[test]
    fn covered_pixels_are_those_of_discs_however_far_apart() {
        for radius in [5.0f32, 10.0, 40.0] {
            let area = std::f32::consts::PI * radius * radius;
            let one = covered(&on_discs(&[Vec2::ZERO], radius)).unwrap();
            assert!((one / area - 1.0).abs() < 0.3, "{radius}: {one} {area}");
            let apart: Vec<Vec2> = (0..5).map(|i| Vec2::new(i as f32 * 200.0, (i * i) as f32 * 50.0)).collect();
            let five = covered(&on_discs(&apart, radius)).unwrap();
            assert!((five / (5.0 * area) - 1.0).abs() < 0.3, "{radius}: {five} {area}");
        }
        assert_eq!(covered(&[]), None);
        assert_eq!(covered(&[Vec2::ONE]), Some(1.0));
    }
}
