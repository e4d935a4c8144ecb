//! The surroundings of a shaded point: the part of them that is open, and the mean normal of the object's surface there.

use crate::accel::{Accel, Hit, Ray, offset_origin};
use crate::sampler::warp::{frame, sample_cosine_hemisphere, to_world};
use crate::scene::Scene;
use crate::scene::visibility::Rays;
use crate::surface::{NO_STRAND, SurfacePoint};
use glam::Vec3A;
use petzval_nodes::{Occlusion, random_of};
use sobol_burley::sample_4d;
use std::f32::consts::TAU;

/// A scene, and the trees through which its surfaces may look for one another: where none are given, nodes that ask see
/// nothing, as in Cycles on the way to a light.
#[derive(Clone, Copy)]
pub struct SceneQueries<'a> {
    /// The scene whose surfaces are looked for.
    pub scene: &'a Scene,
    /// The scene's BVHs; `None`: nodes that look for other surfaces see none.
    pub accel: Option<&'a Accel>,
}

impl<'a> From<&'a Scene> for SceneQueries<'a> {
    fn from(scene: &'a Scene) -> Self {
        Self { scene, accel: None }
    }
}

/// The steps of an even sequence (Roberts' R2).
const STEPS: [f32; 2] = [0.754_877_7, 0.569_840_3];

impl SceneQueries<'_> {
    /// The share of rays from a point, about a normal and in proportion to the cosine, that hit nothing so far.
    pub(super) fn open(&self, point: &SurfacePoint, asked: Occlusion, normal: Vec3A, distance: f32) -> f32 {
        let (Some(accel), Some(normal)) = (self.accel, normal.try_normalize()) else { return 1.0 };
        if distance.is_nan() || distance <= 0.0 {
            return 1.0;
        }
        let axes = frame(if asked.inside { -normal } else { normal });
        let seed = seed(point);
        let start = [random_of(seed), random_of(!seed)];
        let is_open = |number: u8| {
            let u = [0, 1].map(|axis: usize| (start[axis] + f32::from(number) * STEPS[axis]).fract());
            let direction = to_world(&axes, sample_cosine_hemisphere(u));
            let side = point.geometric_normal * 1f32.copysign(point.geometric_normal.dot(direction));
            let origin = offset_origin(point.position, side, point.position_error);
            let ray = Ray { t_max: distance, ..point.leaving(origin, direction) };
            let blocks = |instance: u32| !asked.only_local || instance == point.instance;
            accel.transmittance(&ray, |hit| f32::from(u8::from(blocks(hit.instance)))) > 0.0
        };
        let open = (0..asked.samples).filter(|&number| is_open(number)).count();
        open as f32 / f32::from(asked.samples.max(1))
    }

    /// The nearest hit of a ray from a place in render space, as Cycles has it (`svm_raycast` in raycast.h), and its distance in lengths of the
    /// direction. A ray from the point itself does not hit its own triangle; one from `beside` it passes surfaces that are not farther.
    #[inline(never)]
    pub(super) fn nearest(
        &self,
        point: &SurfacePoint,
        origin: Vec3A,
        beside: f32,
        direction: Vec3A,
        length: f32,
        only_local: bool,
    ) -> Option<(Hit, f32)> {
        /// Start of a ray of a bump's places over their distance from the point.
        const FARTHER: f32 = 1.1;
        let accel = self.accel?;
        let (step, unit) = (direction.length(), direction.try_normalize()?);
        if !(origin.is_finite() && length > 0.0) {
            return None;
        }
        let leaves_point = beside == 0.0 && (origin - point.position).length() <= point.position_error;
        let (begin, ray) = if beside > 0.0 {
            // As in Cycles, in lengths of the direction.
            let begin = FARTHER * beside * step;
            (begin, Ray { moment: point.moment, ..Ray::new(origin + unit * begin, unit) })
        } else if leaves_point {
            let side = point.geometric_normal * 1f32.copysign(point.geometric_normal.dot(unit));
            (0.0, point.leaving(offset_origin(point.position, side, point.position_error), unit))
        } else {
            (0.0, Ray { moment: point.moment, ..Ray::new(origin, unit) })
        };
        let ray = Ray { t_max: (length * step).min(f32::MAX) - begin, ..ray };
        let hit = if only_local {
            let mut nearest: Option<Hit> = None;
            accel.transmittance_of(&ray, Rays::ALL, |hit| {
                if hit.instance == point.instance && nearest.is_none_or(|before| hit.t < before.t) {
                    nearest = Some(*hit);
                }
                0.0
            });
            nearest
        } else {
            accel.closest(&ray, Rays::ALL)
        }?;
        Some((hit, (begin + hit.t) / step))
    }

    /// The mean normal of an object's surface around a point as far as a radius, towards the viewer; `None` where there is nothing to find.
    ///
    /// Rays along the normal or a tangent pass through disks about the point, and the normals of the hits are weighted as in Cycles (`svm_bevel` in
    /// bevel.h): by the falloff at the real distance over that in the disk, and by the power heuristic over the three axes (King et al. 2013,
    /// BSSRDF Importance Sampling).
    #[inline(never)]
    pub(super) fn bevelled(&self, point: &SurfacePoint, samples: u8, radius: f32) -> Option<Vec3A> {
        let accel = self.accel.filter(|_| point.strand == NO_STRAND && radius > 0.0 && radius.is_finite())?;
        let axes = frame(point.geometric_normal);
        let seed = seed(point);
        let mut sum = Vec3A::ZERO;
        for number in 0..samples {
            // The first two, four and so on are stratified, as in Cycles: the mean of the direction of a sum of few depends on it.
            let [u, v, ..] = sample_4d(number.into(), 0, seed);
            // The normal half of the time, each tangent a quarter.
            let (axis, u) = match u {
                u if u < 0.5 => (2, 2.0 * u),
                u if u < 0.75 => (0, 4.0 * u - 2.0),
                u => (1, 4.0 * u - 3.0),
            };
            let (along, across) = (axes[axis], [axes[(axis + 1) % 3], axes[(axis + 2) % 3]]);
            let in_disk = falloff_radius(v);
            let (sine, cosine) = (TAU * u).sin_cos();
            let place = (across[0] * cosine + across[1] * sine) * (in_disk * radius);
            let height = radius * (1.0 - in_disk * in_disk).max(0.0).sqrt();
            let origin = point.position + along * height + place;
            let ray = Ray { t_max: 2.0 * height, moment: point.moment, ..Ray::new(origin, -along) };
            accel.transmittance_of(&ray, Rays::ALL, |hit: &Hit| {
                if hit.instance == point.instance {
                    let found = SurfacePoint::new(self.scene, hit, ray.direction);
                    let distance = (found.position - point.position).length() / radius;
                    let cosines = axes.map(|axis| axis.dot(found.geometric_normal).abs());
                    let densities: [f32; 3] = std::array::from_fn(|i| cosines[i] * if i == 2 { 0.5 } else { 0.25 });
                    let weight = densities[axis] / densities.map(|density| density * density).iter().sum::<f32>();
                    let normal = if found.backfacing { -found.shading_normal } else { found.shading_normal };
                    sum += normal * (weight * falloff(distance) / falloff(in_disk));
                }
                0.0
            });
        }
        let normal = sum.try_normalize()?;
        Some(if point.backfacing { -normal } else { normal })
    }
}

/// The seed of the samples at a point. No two paths hit a surface at the same place: it is as good as a random number.
fn seed(point: &SurfacePoint) -> u32 {
    let [x, y, z] = point.position.to_array().map(f32::to_bits);
    x ^ y.rotate_left(11) ^ z.rotate_left(22)
}

/// The falloff of a bevel over the distance, in radii, up to a factor: a cubic.
fn falloff(distance: f32) -> f32 {
    (1.0 - distance).max(0.0).powi(3)
}

/// The distance, in radii, within which this part of a disk of the falloff lies: the root of 10 r² - 20 r³ + 15 r⁴ - 4 r⁵ = `part`. The part grows
/// with the distance, so that bisection finds it.
fn falloff_radius(part: f32) -> f32 {
    let (mut low, mut high) = (0.0f32, 1.0);
    for _ in 0..16 {
        let r = 0.5 * (low + high);
        if r * r * (10.0 + r * (-20.0 + r * (15.0 - 4.0 * r))) < part { low = r } else { high = r }
    }
    0.5 * (low + high)
}
