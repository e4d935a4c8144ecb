//! Motion while the shutter is open: places of instances and shapes of meshes at keys that lie evenly over that time, interpolated at each
//! moment of it.
//!
//! The shutter's time is cut into moments, and a moving instance stands once in the scene for each of its own: a ray of some
//! moment hits one of these, and whatever asks for that instance afterwards finds it where the ray hit it. How many moments an
//! instance has goes by how far it moves over the picture.

use super::corners::{Corners, Numbers};
use super::{Instance, Scene};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec3};

/// The middle of the time that the shutter is open, as rays have it: from 0, when it opens, to 65535, when it is closed.
pub const MIDDLE: u16 = 1 << 15;
/// Moments of an instance at least and at most, powers of two: as bits.
const FEWEST_BITS: u32 = 4;
const MOST_BITS: u32 = 12;
/// Moments for each pixel that an instance moves.
const PER_PIXEL: f64 = 4.0;
/// Moments of all instances together, beyond which each has fewer.
const MOST_IN_ALL: usize = 1 << 20;
/// Times at which the distance that an instance moves is looked up.
const LOOKS: usize = 32;

/// The moment of a part of the time that the shutter is open, 0 to 1.
#[inline]
pub fn moment(part: f32) -> u16 {
    (part * 65536.0) as u16
}

/// An affine map taken apart, so that a map between two of them turns rather than shrinks (Shoemake and Duff 1992, "Matrix
/// Animation and Polar Decomposition").
#[derive(Clone, Copy, Debug)]
struct AffineParts {
    rotation: DQuat,
    stretch: DMat3,
    translation: DVec3,
}

impl AffineParts {
    fn of(map: &DAffine3) -> Self {
        let mut rotation = map.matrix3;
        for _ in 0..100 {
            let next = (rotation + rotation.inverse().transpose()) * 0.5;
            let change = (next - rotation).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
            rotation = next;
            // Also ends where it is no number.
            if change.is_nan() || change <= 1e-12 {
                break;
            }
        }
        // A mirror is of the stretch.
        if rotation.determinant() < 0.0 {
            rotation *= -1.0;
        }
        let stretch = rotation.inverse() * map.matrix3;
        Self { rotation: DQuat::from_mat3(&rotation), stretch, translation: map.translation }
    }

    fn between(&self, other: &Self, part: f64) -> DAffine3 {
        // The shorter way round, which `slerp` takes.
        let rotation = self.rotation.slerp(other.rotation, part);
        let stretch = self.stretch * (1.0 - part) + other.stretch * part;
        let translation = self.translation.lerp(other.translation, part);
        DAffine3 { matrix3: DMat3::from_quat(rotation) * stretch, translation }
    }
}

/// Transforms of an instance at keys that lie evenly over the time that the shutter is open.
#[derive(Clone, Debug)]
pub struct AnimatedTransform(Vec<AffineParts>);

impl AnimatedTransform {
    /// The transforms of these matrices; `None` of less than two, or where one is not finite or flattens.
    pub fn new(keys: &[DMat4]) -> Option<Self> {
        let is_fine = |m: &DMat4| m.is_finite() && m.inverse().is_finite() && m.determinant().abs() >= 1e-30;
        (keys.len() > 1 && keys.iter().all(is_fine))
            .then(|| Self(keys.iter().map(|m| AffineParts::of(&DAffine3::from_mat4(*m))).collect()))
    }

    /// The transform after a part of the shutter's time, 0 to 1.
    pub fn at(&self, part: f64) -> DAffine3 {
        let (key, between) = key_at(self.0.len(), part);
        self.0[key].between(&self.0[key + 1], between)
    }
}

/// The key before a part of the time, and the part of the way to the next, 0 to 1.
fn key_at(count: usize, part: f64) -> (usize, f64) {
    let along = part.clamp(0.0, 1.0) * (count - 1) as f64;
    let key = (along as usize).min(count - 2);
    (key, along - key as f64)
}

/// The shapes of a mesh at keys that lie evenly over the time that the shutter is open, the middle one its own.
#[derive(Clone, Debug, Default)]
pub struct Poses {
    /// Vertices by key, object space.
    pub positions: Vec<Vec<Vec3>>,
    /// Normals at the triangles' corners by key, object space; `None` as in the mesh.
    pub corner_normals: Option<Vec<Corners<Vec3>>>,
}

/// The two shapes of its mesh between which an instance is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// The number of the key before.
    pub key: u32,
    /// The part of the way to the next key, 0 to 1.
    pub part: f32,
}

impl Poses {
    /// Number of keys, evenly over the time that the shutter is open.
    pub fn key_count(&self) -> usize {
        self.positions.len()
    }

    fn at(&self, part: f64) -> Pose {
        let (key, part) = key_at(self.key_count(), part);
        Pose { key: key as u32, part: part as f32 }
    }

    /// The pose of the mesh itself.
    pub(super) fn middle(&self) -> Pose {
        self.at(0.5)
    }

    /// The corners of a triangle, by its vertices.
    pub fn corners(&self, triangle: [u32; 3], pose: Pose) -> [Vec3; 3] {
        let [from, to] = [0, 1].map(|next| &self.positions[pose.key as usize + next]);
        triangle.map(|i| from[i as usize].lerp(to[i as usize], pose.part))
    }

    /// The normals at the corners of a triangle, by its number; of no certain length.
    pub fn normals(&self, numbers: Numbers<'_>, triangle: u32, pose: Pose) -> Option<[Vec3; 3]> {
        let keys = self.corner_normals.as_ref()?;
        let [from, to] = [0, 1].map(|next| keys[pose.key as usize + next].at(numbers, triangle));
        Some([0, 1, 2].map(|corner: usize| from[corner].lerp(to[corner], pose.part)))
    }
}

/// An instance that moves or changes its shape.
#[derive(Clone, Debug)]
pub struct Moving {
    /// Number of the moving instance among the instances.
    pub instance: u32,
    /// The number of the instance that stands for its first moment; the others follow.
    pub first: u32,
    /// Number of bits by which a ray's moment is finer than the instance's.
    pub shift: u32,
    /// Transforms of the instance; `None` where it changes its shape alone.
    pub way: Option<AnimatedTransform>,
}

impl Moving {
    /// The number of the instance that stands for a ray's moment.
    #[inline]
    pub fn at(&self, moment: u16) -> u32 {
        self.first + (u32::from(moment) >> self.shift)
    }

    /// Number of moments that it has.
    pub fn count(&self) -> u32 {
        1 << (16 - self.shift)
    }
}

impl Scene {
    /// Lets an instance stand in the scene for each of its moments. To be called once, when meshes have their shapes.
    pub(crate) fn set_in_motion(&mut self) {
        let bits: Vec<u32> = self.moving.iter().map(|one| self.bits_for(one)).collect();
        let mut fewer = 0;
        let with = |fewer: u32| bits.iter().map(move |bits| bits.saturating_sub(fewer).max(FEWEST_BITS));
        while with(fewer).map(|bits| 1usize << bits).sum::<usize>() > MOST_IN_ALL && fewer < MOST_BITS {
            fewer += 1;
        }
        let bits: Vec<u32> = with(fewer).collect();
        let mut moving = std::mem::take(&mut self.moving);
        for (one, bits) in moving.iter_mut().zip(bits) {
            one.first = self.instances.len() as u32;
            one.shift = 16 - bits;
            let count = one.count();
            for i in 0..count {
                let now = self.instance_at(one, (f64::from(i) + 0.5) / f64::from(count));
                self.instances.push(now);
            }
        }
        self.moving = moving;
    }

    /// An instance after a part of the time that the shutter is open.
    fn instance_at(&self, moving: &Moving, part: f64) -> Instance {
        let mut now = self.instances[moving.instance as usize].clone();
        // It is known by its owner.
        now.object_name = String::new();
        now.asset_name = String::new();
        if let Some(way) = &moving.way {
            now.stand(&way.at(part), self.origin);
        }
        if let Some(poses) = &self.meshes[now.mesh as usize].poses {
            now.pose = poses.at(part);
        }
        now
    }

    /// Number of moments for an instance, as a power of two.
    fn bits_for(&self, moving: &Moving) -> u32 {
        let pixels = self.pixels_moved(moving);
        let bits = (PER_PIXEL * pixels).max(1.0).log2().ceil();
        (bits as u32).clamp(FEWEST_BITS, MOST_BITS)
    }

    /// The length, in pixels, of the paths of the corners of an instance's box over the picture, as seen from the camera's place: that of
    /// the longest.
    pub fn pixels_moved(&self, moving: &Moving) -> f64 {
        let instance = &self.instances[moving.instance as usize];
        let mesh = &self.meshes[instance.mesh as usize];
        let boxes: Vec<[Vec3; 2]> = match &mesh.poses {
            None => vec![mesh.bounds],
            Some(poses) => poses.positions.iter().map(|positions| bounds_of(positions)).collect(),
        };
        let corners = |part: f64| -> [DVec3; 8] {
            let (key, between) = if boxes.len() > 1 { key_at(boxes.len(), part) } else { (0, 0.0) };
            let next = boxes[(key + 1).min(boxes.len() - 1)];
            let [low, high] = [0, 1].map(|i| boxes[key][i].as_dvec3().lerp(next[i].as_dvec3(), between));
            let place = moving.way.as_ref().map_or_else(
                || DAffine3::from_mat4(glam::Mat4::from(instance.to_render).as_dmat4()),
                |way| DAffine3::from_translation(-self.origin) * way.at(part),
            );
            std::array::from_fn(|i| {
                let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
                place.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
            })
        };
        let angle = f64::from(self.viewport.pixel_angle_rad()).max(1e-9);
        let (mut before, mut ways) = (corners(0.0), [0.0; 8]);
        for look in 1..=LOOKS {
            let now = corners(look as f64 / LOOKS as f64);
            for (i, way) in ways.iter_mut().enumerate() {
                let near = now[i].length().min(before[i].length()).max(1e-9);
                *way += (now[i].distance(before[i]) / near).min(std::f64::consts::PI) / angle;
            }
            before = now;
        }
        ways.into_iter().fold(0.0, f64::max)
    }

    /// The instances that were added, without those that stand for moments of others.
    pub fn placed(&self) -> &[Instance] {
        &self.instances[..self.placed_count()]
    }

    fn placed_count(&self) -> usize {
        let first = self.moving.first().filter(|one| one.first > 0);
        first.map_or(self.instances.len(), |one| one.first as usize)
    }

    /// The number of the instance that was added, by instance: itself, but for those that stand for moments.
    pub fn owners(&self) -> Vec<u32> {
        let mut owners: Vec<u32> = (0..self.placed_count() as u32).collect();
        let stand_in = |one: &Moving| std::iter::repeat_n(one.instance, one.count() as usize);
        owners.extend(self.moving.iter().filter(|one| one.first > 0).flat_map(stand_in));
        owners
    }
}

impl Moving {
    /// A moving instance with its way, before it has moments.
    pub(super) fn new(instance: u32, way: Option<AnimatedTransform>) -> Self {
        Self { instance, first: 0, shift: 0, way }
    }
}

/// The lowest and the highest corner of the box about all points that are finite.
pub(super) fn bounds_of(points: &[Vec3]) -> [Vec3; 2] {
    let finite = || points.iter().filter(|p| p.is_finite());
    [finite().fold(Vec3::MAX, |a, b| a.min(*b)), finite().fold(Vec3::MIN, |a, b| a.max(*b))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SceneBuilder, mesh::MeshDescription};
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    /// A turn stays a turn: half way between two it is half of it, and nothing shrinks.
    #[test]
    fn what_turns_keeps_its_size() {
        let scale = DMat4::from_scale(DVec3::new(2.0, 3.0, 0.5));
        let keys = [0.0, FRAC_PI_2].map(|angle| DMat4::from_rotation_z(angle) * scale);
        let way = AnimatedTransform::new(&keys).unwrap();
        let half = way.at(0.5);
        let want = DAffine3::from_mat4(DMat4::from_rotation_z(FRAC_PI_4) * scale);
        assert!(half.abs_diff_eq(want, 1e-9), "{half} {want}");
        assert!(way.at(1.0).abs_diff_eq(DAffine3::from_mat4(keys[1]), 1e-9));
        // A mirrored one, too.
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let keys = [0.0, FRAC_PI_2].map(|angle| DMat4::from_rotation_z(angle) * mirror);
        let half = AnimatedTransform::new(&keys).unwrap().at(0.5);
        assert!(half.abs_diff_eq(DAffine3::from_mat4(DMat4::from_rotation_z(FRAC_PI_4) * mirror), 1e-9), "{half}");
    }

    #[test]
    fn keys_are_met_and_bad_ones_refused() {
        let at = |x: f64| DMat4::from_translation(DVec3::new(x, 0.0, 0.0));
        let way = AnimatedTransform::new(&[at(0.0), at(1.0), at(4.0)]).unwrap();
        for (part, x) in [(0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (0.75, 2.5), (1.0, 4.0)] {
            assert!((way.at(part).translation.x - x).abs() < 1e-12, "{part}");
        }
        assert!(AnimatedTransform::new(&[at(0.0)]).is_none());
        assert!(AnimatedTransform::new(&[at(0.0), DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0))]).is_none());
        assert!(AnimatedTransform::new(&[at(0.0), at(f64::NAN)]).is_none());
    }

    /// An instance has as many moments as its motion in pixels needs; each knows its owner and stands in the middle of its time.
    #[test]
    fn an_instance_stands_for_each_of_its_moments() {
        let mut builder = SceneBuilder::new();
        let mesh = MeshDescription {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        let mesh = builder.add_mesh(mesh).unwrap();
        let at = |x: f64| DMat4::from_translation(DVec3::new(x, 0.0, -10.0));
        builder.add_instance("still", mesh, at(0.0), &[], true, true).unwrap();
        for far in [1e-4, 5.0] {
            let index = builder.add_instance("moves", mesh, at(0.0), &[], true, true).unwrap().unwrap();
            builder.set_keys(index, &[at(-far), at(0.0), at(far)]);
        }
        let mut scene = builder.build(DVec3::ZERO);
        assert_eq!(scene.moving.len(), 2);
        scene.set_in_motion();
        let counts: Vec<u32> = scene.moving.iter().map(Moving::count).collect();
        // 10 units at a distance of 10 and a thousandth a pixel: over a thousand pixels.
        assert_eq!(counts, [16, 4096]);
        assert_eq!(scene.placed().len(), 3);
        assert_eq!(scene.owners().len(), scene.instances.len());
        let fast = &scene.moving[1];
        let place = |moment| scene.instances[fast.at(moment) as usize].to_render.translation.x;
        assert!((place(0) + 5.0).abs() < 2e-3 && (place(65535) - 5.0).abs() < 2e-3);
        assert!(place(MIDDLE).abs() < 2e-3);
        assert_eq!(scene.owners()[fast.at(MIDDLE) as usize], 2);
    }
}
