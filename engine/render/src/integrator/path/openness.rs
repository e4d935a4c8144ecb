//! How much of the sky the surfaces of a picture see.

use super::leave;
use crate::accel::{Ray, RayKind};
use crate::integrator::Stage;
use crate::sampler::{PathSampler, warp};
use crate::surface::SurfacePoint;

/// Surfaces that light comes to one after the other.
const BOUNCES: u32 = 2;
/// Told of a picture that sees no surface, and where nothing was learned.
const UNKNOWN: f32 = 0.5;

/// The part of cosine-distributed rays that meet nothing, from the surfaces that `rays` see and from those that these
/// see. It chooses between the sky and other lights, so that a rough number is enough: a few hundred rays.
pub fn openness(stage: &Stage, rays: impl Iterator<Item = Ray>) -> f32 {
    let (mut seen, mut open) = (0u32, 0u32);
    for (i, mut ray) in rays.enumerate() {
        let mut sampler = PathSampler::new(i as u32, 0, 0, 0);
        for bounce in 0..=BOUNCES {
            let kind = if bounce == 0 { RayKind::Camera } else { RayKind::Bounce };
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
            ray = Ray::new(leave(&point, d), d);
        }
    }
    if seen == 0 { UNKNOWN } else { open as f32 / seen as f32 }
}
