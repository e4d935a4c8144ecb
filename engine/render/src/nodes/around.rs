//! The surroundings of a shaded point, and the part of them that is open.

use crate::accel::{Accel, Ray, offset_origin};
use crate::sampler::warp::{frame, sample_cosine_hemisphere, to_world};
use crate::scene::Scene;
use crate::surface::SurfacePoint;
use glam::Vec3A;
use petzval_nodes::{Occlusion, random_of};

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
        // No two paths hit a surface at the same place: it is as good as a random number.
        let [x, y, z] = point.position.to_array().map(f32::to_bits);
        let seed = x ^ y.rotate_left(11) ^ z.rotate_left(22);
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
}
