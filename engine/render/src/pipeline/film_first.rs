//! The traditional pipeline (Kolb, Mitchell and Hanrahan 1995; Wu et al. 2011, section 5.3 and figure 5): a point
//! of the film, a point of the pupil, out through the lens, into the scene.

use crate::camera::Camera;
use crate::film::{TileRect, contribution};
use crate::integrator::{
    Stage,
    path::{self, Limits, PathResult},
};
use crate::sampler::{PathSampler, warp::PixelFilter};
use glam::Vec2;
use std::time::{Duration, Instant};

/// One sample in this many is timed, to know the lens' share of the time without spending any.
const TIMED_EVERY: u64 = 61;

/// What a render does the same for every sample.
pub struct Shot<'a> {
    /// The scene.
    pub stage: &'a Stage,
    /// The camera.
    pub camera: &'a Camera,
    /// Where in a pixel samples fall.
    pub filter: &'a PixelFilter,
    /// Columns of the picture.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How far light is followed.
    pub limits: Limits,
    /// Of all random choices.
    pub seed: u32,
}

/// Counts of what was done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Samples asked of the camera.
    pub camera_rays: u64,
    /// Of those, lost in the lens.
    pub camera_rays_lost: u64,
    /// Rays traced through the scene.
    pub rays: u64,
    /// Samples that were dropped because they were not finite.
    pub non_finite: u64,
    /// Of the timed samples: time in the camera.
    pub camera_time: Duration,
    /// Of the timed samples: all of their time.
    pub sample_time: Duration,
}

impl Counts {
    /// Adds another's.
    pub fn add(&mut self, other: &Self) {
        self.camera_rays += other.camera_rays;
        self.camera_rays_lost += other.camera_rays_lost;
        self.rays += other.rays;
        self.non_finite += other.non_finite;
        self.camera_time += other.camera_time;
        self.sample_time += other.sample_time;
    }
}

/// Sums over samples `first..first + count` of every pixel of a tile; `None` where `stopped` said so.
pub fn render_tile(
    shot: &Shot<'_>,
    rect: TileRect,
    first: u32,
    count: u32,
    stopped: &dyn Fn() -> bool,
) -> Option<(Vec<[f32; 4]>, Counts)> {
    let mut sums = Vec::with_capacity((rect.width * rect.height) as usize);
    let mut counts = Counts::default();
    for y in rect.y..rect.y + rect.height {
        for x in rect.x..rect.x + rect.width {
            if stopped() {
                return None;
            }
            let mut sum = [0.0f32; 4];
            for index in first..first + count {
                let one = sample(shot, x, y, index, &mut counts);
                if one.iter().all(|v| v.is_finite()) {
                    for (s, v) in sum.iter_mut().zip(one) {
                        *s += v;
                    }
                } else {
                    counts.non_finite += 1;
                }
            }
            sums.push(sum);
        }
    }
    Some((sums, counts))
}

/// One sample of one pixel.
fn sample(shot: &Shot<'_>, x: u32, y: u32, index: u32, counts: &mut Counts) -> [f32; 4] {
    let timed = counts.camera_rays.is_multiple_of(TIMED_EVERY);
    let start = timed.then(Instant::now);
    let mut sampler = PathSampler::new(x, y, index, shot.seed);
    let [u0, u1, u2, u3] = sampler.next_4d();
    let [u_wavelength, ..] = sampler.next_4d();
    let place = Vec2::new(
        (x as f32 + 0.5 + shot.filter.sample(u0)) / shot.width as f32 - 0.5,
        (y as f32 + 0.5 + shot.filter.sample(u1)) / shot.height as f32 - 0.5,
    );
    counts.camera_rays += 1;
    let ray = shot.camera.sample(place, [u2, u3], u_wavelength);
    if let Some(start) = start {
        counts.camera_time += start.elapsed();
    }
    let value = match ray {
        None => {
            counts.camera_rays_lost += 1;
            // Lost light is black, not transparent: the lens is in the way.
            [0.0, 0.0, 0.0, if shot.limits.hide_sky { 0.0 } else { 1.0 }]
        }
        Some(ray) => {
            let found = path::trace(shot.stage, ray.ray, &shot.limits, &mut sampler);
            counts.rays += u64::from(found.rays);
            let PathResult { radiance, hit, .. } = found;
            let alpha = if shot.limits.hide_sky && !hit { 0.0 } else { 1.0 };
            contribution(ray.weight * radiance, alpha)
        }
    };
    if let Some(start) = start {
        counts.sample_time += start.elapsed();
    }
    value
}
