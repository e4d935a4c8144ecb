//! Statistics of a few hundred paths before a picture is rendered. Only noise and time depend on it, never the mean.

use super::{CAMERA_SETS, Limits, leave, trace_all};
use crate::accel::Ray;
use crate::integrator::PreparedScene;
use crate::sampler::{PathSampler, warp};
use crate::scene::visibility::Rays;
use crate::surface::SurfacePoint;

/// Surfaces that light comes to one after the other.
const BOUNCES: u32 = 2;
/// The openness of a picture that sees no surface.
const UNKNOWN: f32 = 0.5;
/// Part of the paths that are not counted: the brightest would decide it all.
const TRIMMED: f32 = 0.02;

/// The part of cosine-distributed rays that hit nothing, from the surfaces that `rays` see and from those that these
/// see.
pub fn openness(stage: &PreparedScene, rays: &[Ray]) -> f32 {
    let (mut seen, mut open) = (0u32, 0u32);
    for (i, ray) in rays.iter().enumerate() {
        let mut ray = *ray;
        let mut sampler = PathSampler::new(i as u32, 0, 0, 0);
        for bounce in 0..=BOUNCES {
            let kind = if bounce == 0 { Rays::CAMERA } else { Rays::BOUNCE };
            let hit = stage.accel.closest(&ray, kind);
            if bounce > 0 {
                seen += 1;
                open += u32::from(hit.is_none());
            }
            let Some(hit) = hit else { break };
            let point = SurfacePoint::new(&stage.scene, &hit, ray.direction);
            let [u0, u1, ..] = sampler.next_4d();
            let frame = warp::frame(point.geometric_normal);
            let d = warp::to_world(&frame, warp::sample_cosine_hemisphere([u0, u1])).normalize();
            ray = point.leaving(leave(&point, d), d);
        }
    }
    if seen == 0 { UNKNOWN } else { open as f32 / seen as f32 }
}

/// The number of [`Limits::roulette`] for a picture: Russian roulette may end a path once its throughput is so many times less than after
/// its first scattering.
///
/// The best probability to go on is in proportion to the light of the rest of a path, over the noise that the pixel has anyhow, for its
/// cost (Rath et al. 2022, "EARS", equation 8). Where the rest is as bright and as costly as a whole path, that is its throughput, over
/// that of the first scattering, times sqrt(1 + 1 / v), where v is the relative variance of a path: the less noise a picture has, the less
/// it may be added to. 1.4 times as much measured best over scenes by others: the light left out is the light that a whole path finds by
/// its own light samples.
pub fn roulette(stage: &PreparedScene, limits: &Limits, rays: &[Ray]) -> f32 {
    let twice = rays.iter().enumerate().flat_map(|(i, ray)| {
        (0..2).map(move |index| {
            let mut sampler = PathSampler::new(i as u32, 1, index, 0);
            sampler.jump_to(CAMERA_SETS);
            (*ray, sampler)
        })
    });
    let mut light = Vec::with_capacity(2 * rays.len());
    trace_all(stage, twice, limits, |_, found| light.push(found.radiance.element_sum()));
    let mean = light.iter().sum::<f32>() / light.len().max(1) as f32;
    let mut variances: Vec<f32> = light
        .chunks_exact(2)
        .map(|two| 0.5 * (two[0] - two[1]).powi(2) / ((0.5 * (two[0] + two[1])).powi(2) + (0.01 * mean).powi(2)))
        .filter(|v| v.is_finite())
        .collect();
    variances.sort_by(f32::total_cmp);
    variances.truncate(((1.0 - TRIMMED) * variances.len() as f32) as usize);
    let v = variances.iter().sum::<f32>() / variances.len().max(1) as f32;
    // A picture without noise, or a single path in it, tells nothing: then no path ends by chance before it is faint.
    (1.4 * (1.0 + 1.0 / v.max(1e-3)).sqrt()).clamp(1.4, 32.0)
}
