//! A world of nodes: its radiance from a direction, and an image of all directions, by which lights are chosen.

use super::images::Images;
use super::path_state::{OF_BOUNCES, PathState};
use crate::sampler::warp::{frame, sample_disk, to_world};
use crate::scene::Scene;
use crate::scene::closure::Closure;
use crate::scene::graph::Graph;
use crate::scene::lamp::{Lamp, LampKind};
use crate::scene::material::Aovs;
use crate::scene::texture::Texture;
use crate::scene::viewport::Viewport;
use crate::scene::visibility::Rays;
use crate::scene::world::equirectangular_to_direction;
use crate::{Rgb, luminance};
use glam::{Affine3A, Mat3A, Vec2, Vec3A, Vec4};
use petzval_nodes::{Attribute, Context, Direction, Field, Registers, Shift, Space, SunDisc, answers, random_of_pair};
use rayon::prelude::*;
use std::cell::RefCell;
use std::f32::consts::PI;
use std::sync::Arc;

/// Columns and rows of the image: half a degree and less.
const SIZE: [usize; 2] = [1024, 512];
/// Places in each of its pixels, along each side: so that small bright suns of an image are not missed.
const WITHIN: usize = 2;

/// A direction as a program asks for it.
pub(super) struct Infinity<'a> {
    pub(super) direction: Vec3A,
    pub(super) way: PathState,
    pub(super) shows_sun: bool,
    pub(super) viewport: &'a Viewport,
    pub(super) attributes: &'a [Attribute],
}

impl Context for Infinity<'_> {
    fn shows_sun(&self) -> bool {
        self.shows_sun
    }

    answers! {
        fn answer(&self, field: Field, _: Shift) -> Vec3A {
            match field {
                Position | Generated | Object | MeshNormal | InstancerGenerated => self.direction,
                Normal | TrueNormal | Incoming | Reflection => -self.direction,
                Camera => self.ahead(),
                Window => self.viewport.window(self.ahead()),
                ViewVector => self.as_a_place().normalize_or_zero(),
                ViewDepth => Vec3A::splat(self.as_a_place().z),
                ViewDistance => Vec3A::splat(self.as_a_place().length()),
                // Nothing ends the ray.
                RayLength => Vec3A::splat(f32::MAX),
                // No sides are near, and no pixel is of use beside them.
                EdgeDistance => Vec3A::INFINITY,
                PixelWidth => Vec3A::ZERO,
                // As Cycles has them where there is no triangle,
                Parametric => Vec3A::X,
                Backfacing | Pointiness | RandomPerIsland | InstancerUv => Vec3A::ZERO,
                // no object and no material,
                ObjectLocation | ObjectColour | ObjectAlpha | ObjectIndex | ObjectRandom | MaterialIndex => Vec3A::ZERO,
                // no particle, whose random number is that of the first,
                ParticleRandom => Vec3A::splat(random_of_pair([0, 0])),
                ParticleIndex | ParticleAge | ParticleLifetime | ParticleSize => Vec3A::ZERO,
                ParticleLocation | ParticleVelocity | ParticleAngularVelocity => Vec3A::ZERO,
                // no hair, no point of a cloud and no grid.
                IsStrand | StrandIntercept | StrandLength | StrandThickness | StrandNormal | StrandRandom | StrandAxis
                | StrandOffset => Vec3A::ZERO,
                PointPosition | PointRadius | PointRandom => Vec3A::ZERO,
                VolumeColour | VolumeDensity | VolumeFlame | VolumeTemperature => Vec3A::ZERO,
                _ => [PathState: self.way],
            }
        }
    }

    fn attribute(&self, index: usize, _: Shift) -> Vec4 {
        debug_assert!(index < self.attributes.len());
        Vec4::ZERO
    }

    /// The vector in another space. The world has no object: its space is that of the world.
    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vec3A) -> Vec3A {
        let map = match (from, to) {
            (Space::World, Space::Camera) => self.viewport.from_world,
            (Space::Camera, Space::World) => self.viewport.from_world.inverse(),
            _ => Affine3A::IDENTITY,
        };
        match direction {
            Direction::Point => map.transform_point3a(vector),
            Direction::Vector => map.transform_vector3a(vector),
            Direction::Normal => map.transform_vector3a(vector).normalize_or_zero(),
        }
    }
}

impl Infinity<'_> {
    /// The direction in the camera's space.
    fn ahead(&self) -> Vec3A {
        self.viewport.from_world.transform_vector3a(self.direction)
    }

    /// The direction taken for a place of the world, in the camera's space: so Blender's Camera Data has it.
    fn as_a_place(&self) -> Vec3A {
        self.viewport.from_world.transform_point3a(self.direction)
    }
}

thread_local! {
    static REGISTERS: RefCell<Registers> = RefCell::default();
}

/// The radiance that arrives from a direction (unit, pointing away from the scene), that of suns included.
pub fn radiance(graph: &Graph, scene: &Scene, direction: Vec3A, way: PathState) -> Rgb {
    radiance_of(graph, scene, direction, way, true)
}

fn radiance_of(graph: &Graph, scene: &Scene, direction: Vec3A, way: PathState, shows_sun: bool) -> Rgb {
    let program = &graph.program;
    let place = Infinity { direction, way, shows_sun, viewport: &scene.viewport, attributes: &program.attributes };
    REGISTERS.with_borrow_mut(|registers| {
        program.run(&place, &Images(&scene.textures), registers);
        emitted(graph, registers)
    })
}

/// Calls `found(number, value)` with the shader AOVs of a world in a direction (unit, pointing away from the scene).
pub fn aovs(aovs: &Aovs, scene: &Scene, direction: Vec3A, way: PathState, mut found: impl FnMut(u16, Rgb)) {
    let Aovs { graph, numbers } = aovs;
    let program = &graph.program;
    let place =
        Infinity { direction, way, shows_sun: true, viewport: &scene.viewport, attributes: &program.attributes };
    REGISTERS.with_borrow_mut(|registers| {
        program.run(&place, &Images(&scene.textures), registers);
        for (layer, &number) in graph.layers.iter().zip(numbers) {
            if let Closure::Emission { color, strength } = &layer.closure {
                let [color, strength] = [*color, *strength].map(|source| source.value(program, registers));
                let value = color * strength.x;
                found(number, if value.is_finite() { value.into() } else { Rgb::ZERO });
            }
        }
    });
}

/// Radiance emitted by the closures of a program that has run; negative where they take light away.
pub(super) fn emitted(graph: &Graph, registers: &Registers) -> Rgb {
    let mut sum = Vec3A::ZERO;
    for layer in &graph.layers {
        if let Closure::Emission { color, strength } = &layer.closure {
            let [color, strength, weight] =
                [*color, *strength, layer.weight].map(|source| source.value(&graph.program, registers));
            sum += color * strength.x * weight.x;
        }
    }
    if sum.is_finite() { sum.into() } else { Rgb::ZERO }
}

/// Gives a world of nodes the image, or the one colour, that surfaces see of it; and lamps for the suns of its skies, which
/// are too small for the image. That of an earlier scene is taken where it is the same.
pub fn bake(scene: &mut Scene, previous: Option<&Scene>) {
    let Some(graph) = scene.world.graph.clone() else { return };
    let graph: &Arc<Graph> = &graph;
    let suns = graph.program.suns().filter_map(|disc| sun(graph, scene, disc));
    let suns: Vec<Lamp> = suns.collect();
    scene.lamps.extend(suns);
    if let Some(previous) = previous.filter(|previous| is_same(scene, previous)) {
        let world = &mut scene.world;
        (world.rotation, world.color) = (previous.world.rotation, previous.world.color);
        world.texture = previous.world.texture.map(|_| scene.textures.len() as u32);
        scene.textures.extend(previous.world.texture.map(|at| previous.textures[at as usize].clone()));
        return;
    }
    let [columns, rows] = SIZE;
    let within = &*scene;
    let pixel = |i: usize| {
        let place = |k: usize| (k as f32 + 0.5) / WITHIN as f32;
        let mut sum = Rgb::ZERO;
        for k in 0..WITHIN * WITHIN {
            let x = ((i % columns) as f32 + place(k % WITHIN)) / columns as f32;
            let y = ((i / columns) as f32 + place(k / WITHIN)) / rows as f32;
            let direction = equirectangular_to_direction(Vec2::new(x, y));
            sum += radiance_of(graph, within, direction, PathState::LIGHT, false);
        }
        sum / (WITHIN * WITHIN) as f32
    };
    let pixels: Vec<Rgb> = (0..columns * rows).into_par_iter().map(pixel).collect();
    // One colour is sampled well by closures, but where light samples find what these do not, they count: Cycles samples each world that
    // has an image.
    let is_sampled = scene.world.has_image && !finds_alike(scene);
    let world = &mut scene.world;
    world.rotation = Mat3A::IDENTITY;
    let is_one_colour = pixels.iter().all(|pixel| *pixel == pixels[0]);
    if is_one_colour && !is_sampled {
        (world.color, world.texture) = (pixels[0], None);
        return;
    }
    let (columns, rows) = if is_one_colour { (2, 1) } else { (columns, rows) };
    let values: Vec<f32> = pixels[..columns * rows].iter().flat_map(|p| [p.x, p.y, p.z, 1.0]).collect();
    let Ok(texture) = Texture::from_floats("world", columns, rows, &values, false) else { return };
    (world.color, world.texture) = (Rgb::ONE, Some(scene.textures.len() as u32));
    scene.textures.push(Arc::new(texture));
}

/// True if surfaces that let shadow rays through let rays of closures through, too. Else each kind of sample finds light that the other
/// does not, and the picture depends on the weights of both: as in Cycles, they are those of the whole image.
pub fn finds_alike(scene: &Scene) -> bool {
    const INDIRECT: Rays = Rays::BOUNCE.and(Rays::SHADOW).and(Rays::VOLUME_SCATTER);
    /// Blender's default, which no path reaches.
    const UNLIMITED: u32 = 1024;
    let is_alike = |visible: Rays| visible.all_of(INDIRECT) || !visible.any_of(INDIRECT);
    let depends = |graph: &Graph| {
        graph.transmittance_reads_any(&OF_BOUNCES) || graph.transmittance_reads_any(&[Field::IsShadowRay])
    };
    // The limits of a world hold for light samples alone.
    scene.world.cast_shadow
        && scene.world.max_bounces >= UNLIMITED
        && scene.instances.iter().all(|instance| is_alike(instance.visible))
        && !scene.materials.iter().any(|material| material.shades_fully || depends(&material.graph))
}

/// True if the sky of a scene that is not baked yet equals that of a baked one: its nodes, and all that these may read.
fn is_same(scene: &Scene, baked: &Scene) -> bool {
    let is_one = |a: &Option<Arc<Graph>>, b: &Option<Arc<Graph>>| match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        _ => false,
    };
    let own = baked.world.texture.map_or(baked.textures.len(), |at| at as usize);
    let images =
        own == scene.textures.len() && baked.textures.iter().zip(&scene.textures).all(|(a, b)| Arc::ptr_eq(a, b));
    is_one(&scene.world.graph, &baked.world.graph)
        && images
        && scene.viewport == baked.viewport
        && scene.world.has_image == baked.world.has_image
        && finds_alike(scene) == finds_alike(baked)
}

/// The lamp that stands for a sky's sun: as bright all over as the disc is on average, the other nodes included. For a disc that the
/// horizon hides in part it is a smaller one, in the middle of the visible part.
fn sun(graph: &Graph, scene: &Scene, disc: SunDisc) -> Option<Lamp> {
    /// Places in the disc, along each side of the square that is bent into it.
    const SIDE: usize = 32;
    let sin_most = (0.5 * disc.diameter_rad).sin();
    let axes = frame(disc.direction);
    let (mut mean, mut middle, mut seen) = (Rgb::ZERO, Vec3A::ZERO, 0.0);
    for i in 0..SIDE * SIDE {
        let u = [i % SIDE, i / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32);
        let p = sample_disk(u) * sin_most;
        let direction = to_world(&axes, p.extend((1.0 - p.length_squared()).max(0.0).sqrt()).into());
        let shine = |shows_sun| radiance_of(graph, scene, direction, PathState::LIGHT, shows_sun);
        let light = shine(true) - shine(false);
        mean += light / (SIDE * SIDE) as f32;
        if luminance(light) > 0.0 {
            middle += direction;
            seen += 1.0 / (SIDE * SIDE) as f32;
        }
    }
    let axes = frame(middle.normalize_or(disc.direction));
    let is_there = sin_most > 0.0 && mean.is_finite() && mean.max_element() > 0.0;
    is_there.then(|| Lamp {
        object_name: "the world's sun".to_owned(),
        kind: LampKind::Sun { half_angle_rad: 0.5 * disc.diameter_rad * f32::sqrt(seen) },
        // Across the beam, as a sun's strength counts.
        color: mean.max(Rgb::ZERO) * (PI * sin_most * sin_most),
        // The camera sees the disc itself.
        reaches: scene.world.visible.without(Rays::CAMERA),
        to_render: Affine3A { matrix3: Mat3A::from_cols(axes[0], axes[1], axes[2]), translation: Vec3A::ZERO },
        ..Lamp::default()
    })
}
