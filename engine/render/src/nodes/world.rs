//! A world of nodes: what shines from a direction, and an image of it all, which lights are chosen by.

use super::point::Images;
use super::way::Way;
use crate::Rgb;
use crate::scene::Scene;
use crate::scene::closure::Closure;
use crate::scene::graph::Graph;
use crate::scene::texture::Texture;
use crate::scene::world::equirectangular_to_direction;
use glam::{Mat3A, Vec2, Vec3A, Vec4};
use petzval_nodes::{Attribute, Context, Direction, Field, Registers, Shift, Space};
use rayon::prelude::*;
use std::cell::RefCell;
use std::sync::Arc;

/// Columns and rows of the image: half a degree and less.
const SIZE: [usize; 2] = [1024, 512];
/// Places in each of its pixels, along each side: so that small bright suns of an image are not missed.
const WITHIN: usize = 2;

/// A direction as a program asks for it.
struct Infinity<'a> {
    direction: Vec3A,
    way: Way,
    attributes: &'a [Attribute],
}

impl Context for Infinity<'_> {
    fn read(&self, field: Field, _: Shift) -> Vec3A {
        match field {
            Field::Position | Field::Generated | Field::Object | Field::Reflection | Field::MeshNormal => {
                self.direction
            }
            Field::Normal | Field::TrueNormal | Field::Incoming => -self.direction,
            Field::ObjectColour | Field::ObjectAlpha => Vec3A::ONE,
            _ => self.way.read(field).map_or(Vec3A::ZERO, Vec3A::splat),
        }
    }

    fn attribute(&self, index: usize, _: Shift) -> Vec4 {
        debug_assert!(index < self.attributes.len());
        Vec4::ZERO
    }

    fn transform(&self, _: Direction, _: Space, _: Space, vector: Vec3A) -> Vec3A {
        vector
    }
}

thread_local! {
    static REGISTERS: RefCell<Registers> = RefCell::default();
}

/// The radiance that arrives from a direction (unit, pointing away from the scene).
pub fn radiance(graph: &Graph, textures: &[Texture], direction: Vec3A, way: Way) -> Rgb {
    let program = &graph.program;
    let place = Infinity { direction, way, attributes: &program.attributes };
    REGISTERS.with_borrow_mut(|registers| {
        program.run(&place, &Images(textures), registers);
        emitted(graph, registers)
    })
}

/// What the closures of a program that has run shine.
pub(super) fn emitted(graph: &Graph, registers: &Registers) -> Rgb {
    let mut sum = Vec3A::ZERO;
    for layer in &graph.layers {
        if let Closure::Emission { color, strength } = &layer.closure {
            let [color, strength, weight] =
                [*color, *strength, layer.weight].map(|source| source.value(&graph.program, registers));
            sum += (color * strength.x).max(Vec3A::ZERO) * weight.x;
        }
    }
    if sum.is_finite() { sum.into() } else { Rgb::ZERO }
}

/// Gives a world of nodes the image, or the one colour, that surfaces see of it.
pub fn bake(scene: &mut Scene) {
    let Some(graph) = scene.world.graph.clone() else { return };
    let graph: &Arc<Graph> = &graph;
    let [columns, rows] = SIZE;
    let textures = &scene.textures;
    let pixel = |i: usize| {
        let place = |k: usize| (k as f32 + 0.5) / WITHIN as f32;
        let mut sum = Rgb::ZERO;
        for k in 0..WITHIN * WITHIN {
            let x = ((i % columns) as f32 + place(k % WITHIN)) / columns as f32;
            let y = ((i / columns) as f32 + place(k / WITHIN)) / rows as f32;
            sum += radiance(graph, textures, equirectangular_to_direction(Vec2::new(x, y)), Way::LIGHT);
        }
        sum / (WITHIN * WITHIN) as f32
    };
    let pixels: Vec<Rgb> = (0..columns * rows).into_par_iter().map(pixel).collect();
    let world = &mut scene.world;
    world.rotation = Mat3A::IDENTITY;
    if pixels.iter().all(|pixel| *pixel == pixels[0]) {
        (world.color, world.texture) = (pixels[0], None);
        return;
    }
    let values: Vec<f32> = pixels.iter().flat_map(|p| [p.x, p.y, p.z, 1.0]).collect();
    let Ok(texture) = Texture::from_floats("world", columns, rows, &values, false) else { return };
    (world.color, world.texture) = (Rgb::ONE, Some(scene.textures.len() as u32));
    scene.textures.push(texture);
}
