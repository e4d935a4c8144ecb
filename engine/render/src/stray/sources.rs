//! Sources bright enough for stray light: those that the picture shows brightly (lamps, sky, surfaces that emit or reflect), and
//! those that it does not show, beside it or because Blender hides lamps from cameras.

use super::Straight;
use crate::accel::Ray;
use crate::camera::Camera;
use crate::camera::tools::straying::StrayLens;
use crate::integrator::PreparedScene;
use crate::nodes::PathState;
use crate::sampler::evenly::Evenly;
use crate::scene::visibility::Rays;
use crate::{Rgb, luminance};
use glam::{DVec3, Vec2, Vec3A};
use petzval_optics::ghosts::beam;

/// Light samples at the lens.
const SAMPLES: u32 = 4096;
/// Light within this angle comes from one source.
const TOGETHER_RAD: f32 = 0.01;
/// Most sources of each kind.
const MOST: usize = 64;
/// Pixels of the picture that are looked at.
const MOST_PIXELS: usize = 40_000;
/// Pixels within this part of the picture's diagonal are one source.
const TOGETHER: f32 = 0.006;
/// Rays of a place of the picture that find its hits.
const RAYS: u32 = 16;
/// A source that is hidden from the camera is in the picture's own light for less than this part of its irradiance.
const HIDDEN: f32 = 0.5;

/// A source of stray light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// The place of the source, lens space.
    pub place: beam::Source,
    /// Irradiance on the front glass, facing the source: radiance times steradians.
    pub irradiance: Rgb,
    /// Radius of an even disc as wide as the source, seen from the lens.
    pub radius_rad: f32,
    /// Direction towards the source, render space, unit.
    pub towards: DVec3,
    /// Place of the source in the picture, pixels from the lower left corner; `None` if the picture does not show it.
    pub pixel: Option<Vec2>,
}

/// All sources, the brightest first, at most [`MOST`] of each kind. `least` is the smallest irradiance that matters: light that has less from
/// each direction, as the sky's, is none of a source.
pub fn all(straight: &Straight<'_>, lens: &StrayLens, least: f32) -> Vec<Source> {
    let shown = in_picture(straight, lens, least);
    let is_shown = |one: &Source| {
        let near = |other: &&Source| one.towards.dot(other.towards) > f64::from(2.0 * TOGETHER_RAD).cos();
        let there: f32 = shown.iter().filter(near).map(|other| luminance(other.irradiance)).sum();
        there > HIDDEN * luminance(one.irradiance)
    };
    let mut found: Vec<Source> =
        of_lights(straight.stage, lens, least).into_iter().filter(|one| !is_shown(one)).collect();
    found.extend(&shown);
    found.sort_by(|a, b| luminance(b.irradiance).total_cmp(&luminance(a.irradiance)));
    found
}

/// Light from about one direction while it is gathered.
struct Cluster {
    /// Directions and inverse distances, weighed by luminance.
    towards: Vec3A,
    /// Squared distances of directions from the first.
    first: Vec3A,
    squares: f32,
    nearness: f32,
    irradiance: Rgb,
}

/// Lamps, emitting surfaces and bright places of the sky that light the lens from its front.
fn of_lights(stage: &PreparedScene, lens: &StrayLens, least: f32) -> Vec<Source> {
    let (front, forwards) = (lens.front().as_vec3a(), lens.forwards().as_vec3a());
    let to = stage.lights.receiver_between(front);
    let points = Evenly::<3>::default();
    let sample = |i: u32| {
        let [choice, u, v] = points.point(i).map(|u| u as f32);
        let sample = stage.lights.sample(&stage.scene, &to, choice, [u, v], PathState::CAMERA)?;
        let light = sample.radiance / (sample.pdf * SAMPLES as f32);
        if !(light.is_finite() && luminance(light) > 0.0 && sample.wi.dot(forwards) > 0.0) {
            return None;
        }
        let mut ray = Ray::new(front, sample.wi);
        ray.t_max = sample.reach(0.0);
        let through = stage.accel.transmittance_of(&ray, Rays::CAMERA, |_| 1.0);
        (through > 0.0).then_some((sample.wi, sample.distance.recip(), light))
    };
    let mut samples: Vec<(Vec3A, f32, Rgb)> = (0..SAMPLES).filter_map(sample).collect();
    samples.sort_by(|a, b| luminance(b.2).total_cmp(&luminance(a.2)));
    let mut clusters: Vec<Cluster> = Vec::new();
    for (wi, nearness, light) in samples {
        let weight = luminance(light);
        let near = clusters.iter_mut().find(|one| one.towards.normalize().dot(wi) > TOGETHER_RAD.cos());
        match near {
            Some(one) => {
                one.towards += wi * weight;
                one.squares += (wi - one.first).length_squared() * weight;
                one.nearness += nearness * weight;
                one.irradiance += light;
            }
            None => clusters.push(Cluster {
                towards: wi * weight,
                first: wi,
                squares: 0.0,
                nearness: nearness * weight,
                irradiance: light,
            }),
        }
    }
    clusters.retain(|one| luminance(one.irradiance) >= least);
    clusters.sort_by(|a, b| luminance(b.irradiance).total_cmp(&luminance(a.irradiance)));
    clusters.truncate(MOST);
    let source = |one: Cluster| {
        let towards = one.towards.as_dvec3().normalize_or(lens.forwards());
        let total = luminance(one.irradiance);
        let distance = f64::from(total / one.nearness);
        let off = (one.towards / total - one.first).length_squared();
        let radius_rad = (2.0 * (one.squares / total - off).max(0.0)).sqrt();
        Source { place: lens.source(towards, distance), irradiance: one.irradiance, radius_rad, towards, pixel: None }
    };
    clusters.into_iter().map(source).collect()
}

/// Bright places of the picture.
fn in_picture(straight: &Straight<'_>, lens: &StrayLens, least: f32) -> Vec<Source> {
    let Straight { stage, camera, picture, .. } = *straight;
    let light_at = |i: usize| picture.light[i] / straight.scale(i);
    let size = Vec2::new(picture.width as f32, picture.height as f32);
    // In the middle of the picture a pixel's solid angle is largest for most lenses; by four times for the others.
    let per_radiance = view(camera, size, 0.5 * size).map_or(0.0, |view| 4.0 * view.solid_angle_sr);
    let bound = least / (per_radiance * MOST as f32).max(f32::MIN_POSITIVE);
    let mut pixels: Vec<(usize, f32)> = (0..picture.light.len()).map(|i| (i, luminance(light_at(i)))).collect();
    pixels.retain(|(_, light)| *light > bound && light.is_finite());
    pixels.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    pixels.truncate(MOST_PIXELS);
    let mut clusters: Vec<BrightSpot> = Vec::new();
    let together = TOGETHER * size.length();
    for (i, light) in pixels {
        let at = Vec2::new((i % picture.width as usize) as f32 + 0.5, (i / picture.width as usize) as f32 + 0.5);
        let near = clusters.iter().position(|one| (one.first + one.places / one.weight).distance(at) < together);
        match near {
            Some(number) => {
                let one = &mut clusters[number];
                one.places += (at - one.first) * light;
                one.squares += (at - one.first).length_squared() * light;
                one.weight += light;
                one.light += light_at(i);
            }
            None if clusters.len() < 4 * MOST => clusters.push(BrightSpot {
                first: at,
                places: Vec2::ZERO,
                squares: 0.0,
                weight: light,
                light: light_at(i),
            }),
            None => {}
        }
    }
    clusters.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    clusters.truncate(MOST);
    let source = |spot: BrightSpot| {
        let from_first = spot.places / spot.weight;
        let pixel = spot.first + from_first;
        let view = view(camera, size, pixel)?;
        let irradiance = spot.light * (view.solid_angle_sr / view.white);
        let radius_px = (2.0 * (spot.squares / spot.weight - from_first.length_squared()).max(0.0)).sqrt();
        let radius_rad = radius_px * view.solid_angle_sr.sqrt();
        let met = stage.accel.closest(&view.ray, Rays::CAMERA);
        let front = lens.front().as_vec3a();
        let (towards, distance) = match met {
            Some(hit) => {
                let to = view.ray.origin + view.ray.direction * hit.t - front;
                (to.normalize(), f64::from(to.length()))
            }
            None => (view.ray.direction, f64::INFINITY),
        };
        let towards = towards.as_dvec3();
        let place = lens.source(towards, distance);
        let source = Source { place, irradiance, radius_rad, towards, pixel: Some(pixel) };
        (irradiance.is_finite() && luminance(irradiance) >= least).then_some(source)
    };
    clusters.into_iter().filter_map(source).collect()
}

/// Bright pixels that lie together.
struct BrightSpot {
    /// The brightest's place, pixels.
    first: Vec2,
    /// Sums by luminance of the offsets of the others from there, and of these distances squared.
    places: Vec2,
    squares: f32,
    /// Sums of luminance, and of light.
    weight: f32,
    light: Rgb,
}

/// The ray that a pixel looks along.
struct PixelView {
    /// The ray, near the middle of the rays that come to the pixel.
    ray: Ray,
    /// Solid angle of a pixel, seen from the lens.
    solid_angle_sr: f32,
    /// The camera's light there of a white world of radiance one.
    white: f32,
}

fn view(camera: &Camera, size: Vec2, pixel: Vec2) -> Option<PixelView> {
    // Differences over some pixels: rays are known to single precision.
    const STEP_PX: f32 = 4.0;
    let middle = mean_ray(camera, size, pixel)?;
    let [left, right, below, above] = [-Vec2::X, Vec2::X, -Vec2::Y, Vec2::Y].map(|side| {
        mean_ray(camera, size, pixel + side * STEP_PX).map_or(middle.0.direction, |found| found.0.direction)
    });
    let (across, up) = ((right - left) / (2.0 * STEP_PX), (above - below) / (2.0 * STEP_PX));
    let solid_angle_sr = across.cross(up).length();
    (middle.1 > 0.0).then_some(PixelView { ray: middle.0, solid_angle_sr, white: middle.1 })
}

/// The mean of the rays that come to a place of the picture, and its exposure by a white world.
fn mean_ray(camera: &Camera, size: Vec2, pixel: Vec2) -> Option<(Ray, f32)> {
    let points = Evenly::<3>::default();
    let (mut origin, mut direction, mut white, mut weight) = (Vec3A::ZERO, Vec3A::ZERO, 0.0, 0.0);
    for i in 0..RAYS {
        let [u, v, w] = points.point(i).map(|u| u as f32);
        let Some(found) = camera.sample(pixel / size - 0.5, [u, v], w) else { continue };
        // Single wavelengths may count negative in a colour; their sum does not.
        let light = luminance(found.white());
        white += light / RAYS as f32;
        let share = light.max(0.0);
        origin += found.ray.origin * share;
        direction += found.ray.direction * share;
        weight += share;
    }
    (weight > 0.0).then(|| (Ray::new(origin / weight, direction.normalize()), white))
}
