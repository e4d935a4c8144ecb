//! Trees of a scene that is edited: every mesh has one of its own, which stays while other meshes and all places change.

use super::Accel;
use super::members::Members;
use super::refit::Topology;
use super::source::{Parts, TriangleSource};
use super::tree::{Primitives, Tree};
use super::triangles::Triangles;
use super::two_level::TwoLevel;
use crate::scene::Scene;
use rayon::prelude::*;
use std::sync::Arc;

impl Accel {
    /// The trees of a scene with those of meshes that were in another, `previous`, at the same index. Rays are slower than in
    /// [`Self::new`]'s, which put meshes that stand there once together; where two surfaces are equally far to the last bit, the
    /// answers may differ.
    pub fn apart(previous: Option<(&Self, &Scene)>, scene: &Scene) -> Self {
        let parts = Parts::apart(scene);
        let members = Members::of::<Triangles>(scene, &parts);
        // The tree of a mesh that was there with the same triangles; and whether its vertices are the same still.
        let before = |i: usize| {
            let (accel, then) = previous?;
            let tree = accel.triangles.shared.get(i).filter(|tree| !tree.nodes.is_empty())?;
            let (old, now) = (then.meshes.get(i)?, &scene.meshes[i]);
            let is_same = Arc::ptr_eq(old, now);
            (is_same || old.triangles == now.triangles).then_some((tree, is_same))
        };
        let kept = |i: usize| match before(i)? {
            (tree, true) => Some(tree.clone()),
            // An edit that moves vertices alone.
            (tree, false) => Some(Arc::new(tree.refitted(&TriangleSource::Mesh(&scene.meshes[i]))?)),
        };
        let tree = |(i, &is_wanted): (usize, &bool)| match is_wanted.then(|| kept(i)).flatten() {
            Some(tree) => (tree, true),
            None if is_wanted => (Arc::new(Triangles::in_object_space(&scene.meshes[i])), false),
            None => (Arc::default(), false),
        };
        let (shared, kept): (Vec<Arc<Tree<Triangles>>>, Vec<bool>) =
            members.rigid.par_iter().enumerate().map(tree).unzip();
        let refitted = kept.into_iter().filter(|&kept| kept).count();
        let triangles = TwoLevel::over(scene, &members, Tree::default(), shared);
        Self { refitted, ..Self::over(scene, triangles, &parts, Topology::of(scene)) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Ray;
    use super::*;
    use crate::scene::SceneBuilder;
    use crate::scene::mesh::MeshDescription;
    use crate::scene::visibility::Rays;
    use glam::{DMat4, DVec3, Vec3, Vec3A};

    /// A bumpy sheet of 2 (`side` - 1)^2 triangles.
    fn sheet(side: u32, phase: f32) -> MeshDescription {
        let at = |i: u32| {
            let (x, y) = ((i % side) as f32, (i / side) as f32);
            Vec3::new(x, y, (x + phase).sin() * (0.7 * y).cos()) / side as f32
        };
        let cells = (0..side * (side - 1)).filter(|i| i % side != side - 1);
        let triangles = cells.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]).collect();
        MeshDescription {
            name: "sheet".into(),
            positions: (0..side * side).map(at).collect(),
            triangles,
            ..Default::default()
        }
    }

    /// Tells a builder where three meshes stand, one of them twice.
    fn place(builder: &mut SceneBuilder, meshes: [usize; 3], moved: f64) {
        for (i, mesh) in [meshes[0], meshes[1], meshes[2], meshes[2]].into_iter().enumerate() {
            let matrix = DMat4::from_translation(DVec3::new(0.3 * i as f64, 0.0, -0.2 * i as f64 - moved));
            builder.add_instance("sheet", mesh, matrix, &[], true, true).unwrap();
        }
    }

    /// Asserts that these trees find the distances that trees built for the scene find.
    fn assert_sees(accel: &Accel, scene: &Scene) {
        let truth = Accel::new(scene);
        let mut hits = 0;
        for i in 0..3000u32 {
            let u = |by: f64| (f64::from(i) * by).fract() as f32;
            let direction = Vec3A::new(0.2 * u(0.73) - 0.1, 0.2 * u(0.41) - 0.1, -1.0).normalize();
            let ray = Ray::new(Vec3A::new(2.0 * u(0.618) - 0.2, u(0.755), 2.0), direction);
            let [a, b] = [accel, &truth].map(|accel| accel.closest(&ray, Rays::CAMERA));
            // Trees in object space round otherwise.
            match (a, b) {
                (Some(a), Some(b)) => assert!((a.t - b.t).abs() < 1e-5, "{i}: {} {}", a.t, b.t),
                (a, b) => assert_eq!(a.is_some(), b.is_some(), "{i}"),
            }
            hits += usize::from(b.is_some());
        }
        assert!(hits > 1000, "{hits}");
    }

    #[test]
    fn only_what_changed_is_built() {
        let mut builder = SceneBuilder::new();
        let mut meshes = [10, 11, 12].map(|side| builder.add_mesh(sheet(side, 0.0)).unwrap());
        let next = |builder: &mut SceneBuilder, meshes, moved| {
            place(builder, meshes, moved);
            builder.build_keeping(DVec3::ZERO)
        };
        let first = next(&mut builder, meshes, 0.0);
        let trees = Accel::apart(None, &first);
        assert_eq!(trees.refitted(), 0);
        assert_sees(&trees, &first);
        // All moved: every tree stays.
        let second = next(&mut builder, meshes, 0.4);
        let trees = Accel::apart(Some((&trees, &first)), &second);
        assert_eq!(trees.refitted(), 3);
        assert_sees(&trees, &second);
        // One in another shape of as many triangles, at the same place of the list; another with more.
        builder.forget_mesh(meshes[0]);
        meshes[0] = builder.add_mesh(sheet(10, 0.3)).unwrap();
        assert_eq!(meshes[0], 0);
        let third = next(&mut builder, meshes, 0.4);
        let trees = Accel::apart(Some((&trees, &second)), &third);
        assert_eq!(trees.refitted(), 3);
        assert_sees(&trees, &third);
        builder.forget_mesh(meshes[1]);
        meshes[1] = builder.add_mesh(sheet(20, 0.0)).unwrap();
        let fourth = next(&mut builder, meshes, 0.1);
        let trees = Accel::apart(Some((&trees, &third)), &fourth);
        assert_eq!(trees.refitted(), 2);
        assert_sees(&trees, &fourth);
        // As many triangles of other corners are another mesh.
        let mut turned = sheet(12, 0.0);
        turned.triangles.reverse();
        builder.forget_mesh(meshes[2]);
        meshes[2] = builder.add_mesh(turned).unwrap();
        let other = next(&mut builder, meshes, 0.1);
        let trees = Accel::apart(Some((&trees, &fourth)), &other);
        assert_eq!(trees.refitted(), 2);
        assert_sees(&trees, &other);
        // Of another origin, and without one of them.
        builder.forget_mesh(meshes[1]);
        place(&mut builder, [meshes[0], meshes[2], meshes[0]], 0.2);
        let fifth = builder.build_keeping(DVec3::new(0.1, 0.0, -0.1));
        let trees = Accel::apart(Some((&trees, &other)), &fifth);
        assert_eq!(trees.refitted(), 2);
        assert_sees(&trees, &fifth);
    }
}
