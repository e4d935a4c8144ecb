//! The trees of instances that move while the shutter is open, beside those of still ones: scenes without motion pay nothing.
//!
//! The shutter's time is parted into slices, each with a tree over the boxes that its instances sweep meanwhile; a ray asks the tree of its
//! moment's slice, and an instance where it stands at that moment.

use super::bounds::Bounds;
use super::build::build;
use super::node::Node;
use super::places::PlacedMesh;
use crate::scene::motion::{Moving, Pose};
use crate::scene::{Instance, Scene};
use glam::Affine3A;
use rayon::prelude::*;

/// Slices of the shutter's time, as bits: as many as an instance has moments at least.
const SLICE_BITS: u32 = 4;

/// Instances that move, and trees over the boxes that they sweep.
pub(super) struct MovingPlaces {
    slices: Vec<Slice>,
    items: Vec<Item>,
    /// Placements of all items, by moment.
    stands: Vec<PlacedTransform>,
}

/// A part of the shutter's time.
struct Slice {
    nodes: Vec<Node>,
    /// Indices into [`MovingPlaces::items`], in the order of the leaves.
    items: Vec<u32>,
}

/// An instance that moves.
struct Item {
    mesh: u32,
    /// The instance that stands for its first moment.
    instance: u32,
    shift: u32,
    /// Number of the first stand of the instance.
    stand: u32,
}

/// The placement of an instance at one moment.
#[derive(Clone, Copy)]
struct PlacedTransform {
    to_object: Affine3A,
    pose: Pose,
}

impl MovingPlaces {
    /// The trees over those instances that are wanted; `bounds` are in object space, of an instance's mesh in its pose. `None` where there
    /// are none.
    pub(super) fn new<'a>(
        scene: &'a Scene,
        wanted: impl Fn(&Moving) -> bool,
        bounds: impl Fn(&'a Instance) -> Option<Bounds> + Sync,
    ) -> Option<Self> {
        let (mut items, mut stands) = (Vec::new(), Vec::new());
        let moving: Vec<&Moving> = scene.moving.iter().filter(|one| wanted(one)).collect();
        for one in &moving {
            let mesh = scene.instances[one.instance as usize].mesh;
            items.push(Item { mesh, instance: one.first, shift: one.shift, stand: stands.len() as u32 });
            let own = &scene.instances[one.first as usize..][..one.count() as usize];
            stands.extend(own.iter().map(|now| PlacedTransform { to_object: now.to_object, pose: now.pose }));
        }
        let slice = |number: u32| {
            let swept = |(i, one): (usize, &&Moving)| {
                let count = one.count() >> SLICE_BITS;
                let own = &scene.instances[(one.first + number * count) as usize..][..count as usize];
                let boxes = own.iter().filter_map(|now| Some(bounds(now)?.transformed(&now.to_render)));
                Some(boxes.reduce(|a, b| a.union(&b))?.naming([i as u32, 0]))
            };
            let swept = moving.iter().enumerate().filter_map(swept);
            let mut boxes: Vec<Bounds> = swept.filter(Bounds::is_within_reach).collect();
            let built = build(&mut boxes, 1);
            let items = built.leaves.iter().map(|leaf| boxes[leaf.start].name()[0]).collect();
            Slice { nodes: built.nodes, items }
        };
        let slices = (0..1u32 << SLICE_BITS).into_par_iter().map(slice).collect();
        (!items.is_empty()).then_some(Self { slices, items, stands })
    }

    pub(super) fn bounds(&self) -> Option<Bounds> {
        self.slices.iter().filter_map(|slice| slice.nodes.first().map(Node::bounds)).reduce(|a, b| a.union(&b))
    }

    /// The nodes of the tree over the moving instances at a moment.
    #[inline(always)]
    pub(super) fn nodes(&self, moment: u16) -> &[Node] {
        &self.slice(moment).nodes
    }

    /// The mesh in a leaf of the moment's slice, placed at that moment, and its pose.
    #[inline(always)]
    pub(super) fn placed(&self, leaf: usize, moment: u16) -> (PlacedMesh, Pose) {
        let item = &self.items[self.slice(moment).items[leaf] as usize];
        let number = u32::from(moment) >> item.shift;
        let PlacedTransform { to_object, pose } = self.stands[(item.stand + number) as usize];
        (PlacedMesh { to_object, mesh: item.mesh, instance: item.instance + number }, pose)
    }

    #[inline(always)]
    fn slice(&self, moment: u16) -> &Slice {
        &self.slices[usize::from(moment >> (16 - SLICE_BITS))]
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Accel, Ray};
    use super::*;
    use crate::scene::SceneBuilder;
    use crate::scene::mesh::MeshDescription;
    use crate::scene::motion::Poses;
    use crate::scene::visibility::Rays;
    use glam::{DMat4, DVec3, Vec3, Vec3A};

    /// A sheet of hills; with `poses`, its hills wander.
    fn sheet(poses: Option<[f32; 3]>) -> MeshDescription {
        let at = |i: u32, j: u32, phase: f32| {
            let (x, y) = (i as f32 / 10.0, j as f32 / 10.0);
            Vec3::new(x - 0.5, y - 0.5, 0.1 * (9.0 * x + phase).sin() * (7.0 * y - phase).cos())
        };
        let shape = |phase: f32| (0..=10).flat_map(|i| (0..=10).map(move |j| at(i, j, phase))).collect::<Vec<_>>();
        let place = |i: u32, j: u32| i * 11 + j;
        let cells = (0..10).flat_map(|i| (0..10).map(move |j| (i, j)));
        MeshDescription {
            name: "sheet".into(),
            positions: shape(poses.map_or(0.0, |phases| phases[1])),
            triangles: cells
                .flat_map(|(i, j)| {
                    [
                        [place(i, j), place(i + 1, j), place(i + 1, j + 1)],
                        [place(i, j), place(i + 1, j + 1), place(i, j + 1)],
                    ]
                })
                .collect(),
            poses: poses.map(|phases| Poses { positions: phases.map(shape).to_vec(), corner_normals: None }),
            ..Default::default()
        }
    }

    fn matrices(number: usize) -> [DMat4; 3] {
        let by = number as f64;
        let at = |part: f64| {
            DMat4::from_translation(DVec3::new(by - 1.0 + part, 0.3 * part * by, -4.0 - 0.2 * by * part))
                * DMat4::from_rotation_y(1.3 * part * by)
                * DMat4::from_scale(DVec3::new(1.0 + 0.5 * part, 1.0, 1.0))
        };
        [-0.5, 0.0, 0.5].map(at)
    }

    /// Two bodies of one mesh that move, one that changes its shape, too, and one that stands still.
    fn scene() -> Scene {
        let mut builder = SceneBuilder::new();
        let stiff = builder.add_mesh(sheet(None)).unwrap();
        let soft = builder.add_mesh(sheet(Some([-1.0, 0.0, 2.0]))).unwrap();
        for (number, mesh) in [stiff, stiff, soft].into_iter().enumerate() {
            let keys = matrices(number);
            let index = builder.add_instance("moves", mesh, keys[1], &[], true, true).unwrap().unwrap();
            builder.set_keys(index, &keys);
        }
        let back = DMat4::from_translation(DVec3::new(0.0, 0.0, -6.0)) * DMat4::from_scale(DVec3::splat(9.0));
        builder.add_instance("still", stiff, back, &[], true, true).unwrap();
        let mut scene = builder.build(DVec3::ZERO);
        scene.set_in_motion();
        scene
    }

    /// The scene as it stands at a moment, without motion.
    fn at(scene: &Scene, moment: u16) -> Scene {
        let mut builder = SceneBuilder::new();
        let mut placed: Vec<u32> = (0..scene.placed().len() as u32).collect();
        scene.moving.iter().for_each(|one| placed[one.instance as usize] = one.at(moment));
        for i in placed {
            let instance = &scene.instances[i as usize];
            let mesh = &scene.meshes[instance.mesh as usize];
            let positions = match &mesh.poses {
                None => mesh.positions.clone(),
                Some(poses) => {
                    let [from, to] = [0, 1].map(|next| &poses.positions[instance.pose.key as usize + next]);
                    from.iter().zip(to).map(|(from, to)| from.lerp(*to, instance.pose.part)).collect()
                }
            };
            let shape = MeshDescription { positions, triangles: mesh.triangles.clone(), ..Default::default() };
            let mesh = builder.add_mesh(shape).unwrap();
            let matrix = glam::Mat4::from(instance.to_render).as_dmat4();
            builder.add_instance("", mesh, matrix, &[], true, true).unwrap();
        }
        builder.build(DVec3::ZERO)
    }

    #[test]
    fn rays_meet_what_stands_there_at_their_moment() {
        let scene = scene();
        assert_eq!(scene.moving.len(), 3);
        let accel = Accel::new(&scene);
        let (mut met_moving, mut all) = (0, 0);
        for moment in [0u16, 1, 12_345, 32_767, 32_768, 50_000, 65_535] {
            let still = at(&scene, moment);
            let truth = Accel::new(&still);
            for i in 0..2000u32 {
                let u = |by: f64| (f64::from(i) * by).fract() as f32;
                let target = Vec3A::new(4.0 * u(0.618) - 2.0, 2.0 * u(0.755) - 1.0, -4.0);
                let ray = Ray::new(Vec3A::new(0.3 * u(0.41), 0.0, 0.0), target.normalize()).at(moment);
                let [found, want] = [&accel, &truth].map(|one| one.closest(&ray, Rays::CAMERA));
                let (Some(found), Some(want)) = (found, want) else {
                    assert_eq!(found.is_some(), want.is_some(), "{ray:?}");
                    continue;
                };
                assert!((found.t - want.t).abs() < 1e-4 * want.t, "{found:?} {want:?}");
                all += 1;
                if (found.instance as usize) < scene.placed().len() {
                    continue;
                }
                met_moving += 1;
                let [own, other] = [(&scene, found), (&still, want)]
                    .map(|(scene, hit)| crate::surface::SurfacePoint::new(scene, &hit, ray.direction));
                assert!(own.position.distance(other.position) < 1e-4, "{own:?} {other:?}");
                // On an edge either triangle may answer.
                let is_same = own.triangle == other.triangle;
                let apart = own.geometric_normal.distance(other.geometric_normal);
                assert!(!is_same || apart < 2e-3, "{own:?} {other:?}");
                assert_eq!(own.moment, moment);
                let counted = |accel: &Accel| {
                    let mut count = 0;
                    accel.light_through(&ray, Rays::SHADOW, |_| {
                        count += 1;
                        crate::Rgb::ONE
                    });
                    count
                };
                assert_eq!(counted(&accel), counted(&truth));
            }
        }
        assert!(met_moving > 2000 && all > met_moving, "{met_moving} of {all}");
    }
}
