//! A lamp's nodes: the factor on its light from a place on it towards a lit point.

use super::images::Images;
use super::path_state::PathState;
use super::world::emitted;
use crate::Rgb;
use crate::scene::graph::Graph;
use crate::scene::texture::Texture;
use glam::{Affine3A, Mat3A, Vec2, Vec3A, Vec4};
use petzval_nodes::{Attribute, AttributeKind, Context, Direction, Field, Registers, Shift, Space, answers};
use std::cell::RefCell;
use std::sync::Arc;

/// A place on a lamp that something looks at.
#[derive(Clone, Copy, Debug)]
pub struct LampPoint {
    /// Position, in Blender's world space.
    pub position: Vec3A,
    /// Away from the lamp.
    pub normal: Vec3A,
    /// Direction of the ray that comes to the lamp, unit.
    pub direction: Vec3A,
    /// Length of the ray that comes to the lamp.
    pub distance: f32,
    /// Coordinates across an area lamp, in a spot's cone, or over the sphere of directions.
    pub uv: Vec2,
    /// The lamp's axes and place, in Blender's world.
    pub to_world: Affine3A,
    /// The state of the path that looks.
    pub way: PathState,
}

/// The fields that a program reads and no lamp has.
pub fn unknown(graph: &Graph) -> Vec<Field> {
    graph.program.reads().filter(|&field| !Asked::knows(field)).collect()
}

/// A place on a lamp as a program asks for it, with the program's attributes.
pub(super) struct Asked<'a>(pub(super) &'a LampPoint, pub(super) &'a [Attribute]);

impl Context for Asked<'_> {
    answers! {
        fn answer(&self, field: Field, _: Shift) -> Vec3A {
            let at = self.0;
            match field {
                Position => at.position,
                Normal | TrueNormal => at.normal,
                MeshNormal => at.to_world.matrix3.transpose() * at.normal,
                Incoming => -at.direction,
                Parametric => Vec3A::new(at.uv.x, at.uv.y, 0.0),
                Object => self.transform(Direction::Point, Space::World, Space::Object, at.position),
                ObjectLocation => at.to_world.translation,
                RayLength => Vec3A::splat(at.distance),
                _ => [PathState: at.way],
            }
        }
    }

    fn attribute(&self, index: usize, _: Shift) -> Vec4 {
        match self.1[index].kind {
            AttributeKind::Uv => Vec4::new(self.0.uv.x, self.0.uv.y, 0.0, 1.0),
            _ => Vec4::ZERO,
        }
    }

    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vec3A) -> Vec3A {
        let Affine3A { matrix3: axes, translation: center } = self.0.to_world;
        let shift = if direction == Direction::Point { center } else { Vec3A::ZERO };
        match (from, to) {
            (Space::World, Space::Object) => axes.transpose() * (vector - shift),
            (Space::Object, Space::World) => axes * vector + shift,
            _ => vector,
        }
    }
}

thread_local! {
    static REGISTERS: RefCell<Registers> = RefCell::default();
}

/// The factor that a lamp's nodes put on its own colour.
pub fn radiance(graph: &Graph, textures: &[Arc<Texture>], at: &LampPoint) -> Rgb {
    REGISTERS.with_borrow_mut(|registers| {
        graph.program.run(&Asked(at, &graph.program.attributes), &Images(textures), registers);
        emitted(graph, registers)
    })
}

/// The factor that a lamp's nodes put on its own colour, if it is constant; else `None`.
pub fn even_radiance(graph: &Graph) -> Option<Rgb> {
    let nowhere = LampPoint {
        position: Vec3A::ZERO,
        normal: Vec3A::Z,
        direction: Vec3A::Z,
        distance: 1.0,
        uv: Vec2::ZERO,
        to_world: Affine3A { matrix3: Mat3A::IDENTITY, translation: Vec3A::ZERO },
        way: PathState::LIGHT,
    };
    graph.emits_evenly().then(|| radiance(graph, &[], &nowhere))
}
