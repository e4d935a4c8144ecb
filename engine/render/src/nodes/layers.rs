//! Evaluating the layers of a material at a point of a surface.

use super::around::SceneQueries;
use super::images::Images;
use super::point::{Point, View};
use crate::accel::Hit;
use crate::scene::closure::Closure;
use crate::scene::graph::{Displacement, Graph};
use crate::scene::layer::{GraphLayer, MOST_LAYERS, Source};
use crate::scene::material::{Aovs, Material};
use crate::scene::plain::{Plain, PlainValues};
use crate::surface::SurfacePoint;
use crate::{Rgb, average, luminance};
use arrayvec::ArrayVec;
use glam::Vec3A;
use petzval_nodes::{Registers, Slice};
use std::cell::RefCell;

/// A closure at one point.
#[derive(Clone, Copy, Debug)]
pub struct EvaluatedLayer {
    /// Weight of the closure.
    pub weight: f32,
    /// The closure, its inputs evaluated at the point.
    pub closure: Closure<Rgb, f32>,
    /// Normal to use instead of the surface's own, unit.
    pub normal: Option<Vec3A>,
    /// Normal of the coat to use instead of the surface's own, unit.
    pub coat_normal: Option<Vec3A>,
    /// Tangent to use instead of the surface's own, unit.
    pub tangent: Option<Vec3A>,
}

/// The closures of a material that scatter light, at a point.
#[derive(Clone, Debug, Default)]
pub struct Layers {
    /// The closures that count.
    pub closures: ArrayVec<EvaluatedLayer, MOST_LAYERS>,
    /// The surface's normal where a displacement bends it, unit; `None` where it does not.
    pub bent_normal: Option<Vec3A>,
}

thread_local! {
    /// The registers that programs compute in.
    static REGISTERS: RefCell<Registers> = RefCell::default();
}

/// Runs a slice of a material's program at a point, and hands on the reader of its results, with the normal where the displacement bends
/// it. If nothing has to be run, the point is not asked for.
fn with_slice<T>(
    graph: &Graph,
    slice: &Slice,
    around: SceneQueries<'_>,
    point: impl FnOnce() -> SurfacePoint,
    view: &View,
    read: impl FnOnce(&dyn Fn(Source) -> Vec3A, Option<Vec3A>) -> T,
) -> T {
    let Graph { program, pass_index, .. } = graph;
    let bends = slice.needs_normal() && graph.bends_normals();
    REGISTERS.with_borrow_mut(|registers| {
        let mut bent = None;
        if bends || !slice.is_empty() {
            let has_footprint = bends || slice.needs_footprint();
            let mut point = Point::new(around, point(), *view, &program.attributes, *pass_index as f32, has_footprint);
            let images = Images(&around.scene.textures);
            if bends {
                bend(graph, &mut point, &images, registers);
                bent = point.bent_normal();
            }
            program.run_slice(slice, &point, &images, registers);
        }
        read(&|source| source.value(program, registers), bent)
    })
}

/// Part of the footprint between the heights by which a displacement bends normals: the default of the Bump node's Filter Width, which Cycles
/// takes there, too.
pub(super) const BUMP_FILTER: f32 = 0.1;

/// Bends a point's normal by the displacement.
fn bend(graph: &Graph, point: &mut Point<'_>, images: &Images<'_>, registers: &mut Registers) {
    let Graph { program, slices, .. } = graph;
    let Some(displacement) = program.displacement else { return };
    let before = if graph.displacement == Displacement::Both { point.undisplaced() } else { None };
    let (base, axes) = before.unwrap_or((*point, point.footprint()));
    let mut height_at = |x, y| {
        program.run_slice(&slices.displacement, &base.beside(x, y), images, registers);
        base.along_normal(program.value(displacement, registers))
    };
    let heights = [height_at(0.0, 0.0), height_at(BUMP_FILTER, 0.0), height_at(0.0, BUMP_FILTER)];
    point.bend(base.bent(heights, axes, BUMP_FILTER));
}

/// The point of a surface at a place of a triangle that is seen in the view's direction.
pub(super) fn surface_point(
    around: SceneQueries<'_>,
    [instance, triangle]: [u32; 2],
    [u, v]: [f32; 2],
    view: &View,
) -> SurfacePoint {
    let hit = Hit { t: view.distance, u, v, instance, triangle, moment: view.moment };
    SurfacePoint::new(around.scene, &hit, view.direction)
}

/// The closures of a graph that scatter, those that count nothing left out.
pub(super) fn of_graph(graph: &Graph, value: &dyn Fn(Source) -> Vec3A, to: &mut Layers) {
    for layer in &graph.scattering {
        let weight = value(layer.weight).x;
        if weight > 0.0 {
            // Most inputs are the same everywhere: they are finite, and nothing is called for them.
            let colour = |source: &Source| match source {
                Source::Always(value) => (*value).into(),
                source => finite(value(*source)),
            };
            let number = |source: &Source| colour(source).x;
            let direction = |source: Option<Source>| source.and_then(|source| value(source).try_normalize());
            to.closures.push(EvaluatedLayer {
                weight,
                closure: layer.closure.map(colour, number),
                normal: direction(layer.normal),
                coat_normal: direction(layer.coat_normal),
                tangent: direction(layer.tangent),
            });
        }
    }
}

fn finite(value: Vec3A) -> Rgb {
    if value.is_finite() { value.into() } else { Rgb::ZERO }
}

/// Evaluates the closures of a material that scatter light at a point. Those of weight 0 are left out.
pub fn layers(material: &Material, around: SceneQueries<'_>, point: &SurfacePoint, view: &View, to: &mut Layers) {
    let graph = &*material.graph;
    to.closures.clear();
    to.bent_normal = None;
    with_slice(
        graph,
        &graph.slices.scattering,
        around,
        || *point,
        view,
        |value, bent| {
            to.bent_normal = bent;
            of_graph(graph, value, to);
        },
    );
}

/// Evaluates the inputs of a plain surface at a point; `plain`: that of the material's graph.
pub fn plain_values(
    material: &Material,
    plain: &Plain,
    around: SceneQueries<'_>,
    point: &SurfacePoint,
    view: &View,
) -> PlainValues {
    let graph = &*material.graph;
    with_slice(graph, &graph.slices.scattering, around, || *point, view, |value, _| plain.values(&value))
}

/// The opening of a surface: the light that it lets through unbent, and the probabilities of passing and scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transparency {
    /// Transmittance by channel of light that goes on unbent.
    pub light: Rgb,
    /// The probability with which a path goes through; it then carries `light` over this.
    pub chance: f32,
    /// Weight of the rest of the surface for a path that does not go through.
    pub kept: f32,
    /// Weight of the closures that are not transparent, before the choice between passing and scattering; `kept` is that weight over the
    /// probability of scattering, 1 - `chance`.
    pub rest: f32,
    /// Probability of scattering where emission is added to every path, so that it takes no part in the choice. Closures count by their
    /// brightness, as in Cycles: a path seldom ends on a dark one.
    pub share: f32,
}

impl Transparency {
    /// The opening of a surface that lets nothing through.
    pub const NONE: Self = Self { light: Rgb::ZERO, chance: 0.0, kept: 1.0, rest: 1.0, share: 1.0 };

    fn of(ClosureSums { light, rest, glowing, scattering }: ClosureSums) -> Self {
        let through = average(light);
        if through <= 0.0 {
            return Self::NONE;
        }
        let chance = through / (through + rest + glowing);
        let kept = if rest + glowing > 0.0 { 1.0 / (1.0 - chance) } else { 0.0 };
        Self { light, chance, kept, rest: 1.0, share: scattering / (average(light) + scattering) }
    }
}

/// Sums over the closures of a surface, by their effect on light.
#[derive(Default)]
struct ClosureSums {
    /// Transmittance of the closures that let light through unbent.
    light: Rgb,
    /// Weight of the closures that scatter.
    rest: f32,
    /// Weight of the closures that only emit.
    glowing: f32,
    /// Weight of the closures that scatter, each times about the part of the light that it scatters.
    scattering: f32,
}

/// Transmittance of a closure for light that goes on unbent.
fn passed<C, N>(closure: &Closure<C, N>, color: impl Fn(&C) -> Rgb, number: impl Fn(&N) -> f32) -> Rgb {
    match closure {
        Closure::Transparent { color: tint } => color(tint).max(Rgb::ZERO),
        Closure::Principled(p) => Rgb::splat(1.0 - number(&p.alpha).clamp(0.0, 1.0)),
        _ => Rgb::ZERO,
    }
}

/// Albedo, about, of a Principled surface whose base is black.
const LEAST_PRINCIPLED: f32 = 0.1;

impl ClosureSums {
    fn add<C, N>(
        &mut self,
        weight: f32,
        closure: &Closure<C, N>,
        color: impl Fn(&C) -> Rgb,
        number: impl Fn(&N) -> f32,
    ) {
        self.light += passed(closure, &color, &number) * weight;
        let (mut weight, mut least) = (weight, 0.0);
        match closure {
            Closure::Transparent { .. } => return,
            Closure::Emission { .. } => {
                self.glowing += weight;
                return;
            }
            Closure::Principled(p) => {
                weight *= number(&p.alpha).clamp(0.0, 1.0);
                least = LEAST_PRINCIPLED;
            }
            _ => {}
        }
        self.rest += weight;
        self.scattering +=
            weight * closure.tint().map_or(1.0, |tint| (average(color(tint).max(Rgb::ZERO)) + least).min(1.0));
    }
}

/// The opening of a material at a point.
pub fn opening(material: &Material, around: SceneQueries<'_>, point: &SurfacePoint, view: &View) -> Transparency {
    let graph = &*material.graph;
    with_slice(
        graph,
        &graph.slices.opening,
        around,
        || *point,
        view,
        |value, _| {
            let mut parts = ClosureSums::default();
            for layer in &graph.layers {
                let (color, number) =
                    (|source: &Source| finite(value(*source)), |source: &Source| finite(value(*source)).x);
                parts.add(value(layer.weight).x, &layer.closure, color, number);
            }
            Transparency::of(parts)
        },
    )
}

/// Transmittance of a material at a point of a triangle for shadow rays: [`Transparency::light`].
pub fn transmittance(
    material: &Material,
    around: SceneQueries<'_>,
    [instance, triangle]: [u32; 2],
    barycentric: [f32; 2],
    view: &View,
) -> Rgb {
    let graph = &*material.graph;
    let point = || surface_point(around, [instance, triangle], barycentric, view);
    let light = with_slice(graph, &graph.slices.transmittance, around, point, view, |value, _| {
        let clear = graph.layers.iter().filter(|layer| match &layer.closure {
            Closure::Transparent { .. } => true,
            Closure::Principled(p) => p.is_clear(&graph.program),
            _ => false,
        });
        clear.fold(Rgb::ZERO, |light, GraphLayer { weight, closure, .. }| {
            light + passed(closure, |c| finite(value(*c)), |n| finite(value(*n)).x) * value(*weight).x
        })
    });
    if luminance(light) > 0.0 { light } else { Rgb::ZERO }
}

/// The part of the surface seen at a point that is a hole to the camera.
#[cold]
pub fn holdout(
    material: &Material,
    around: SceneQueries<'_>,
    [instance, triangle]: [u32; 2],
    barycentric: [f32; 2],
    view: &View,
) -> f32 {
    if material.holds_out {
        return 1.0;
    }
    let graph = &*material.graph;
    let point = || surface_point(around, [instance, triangle], barycentric, view);
    with_slice(graph, &graph.slices.holdout, around, point, view, |value, _| {
        let holes = graph.layers.iter().filter(|layer| matches!(layer.closure, Closure::Holdout));
        holes.map(|layer| value(layer.weight).x).sum()
    })
}

/// Calls `found(number, value)` with the AOVs of a material's nodes at a point.
pub fn aovs(around: SceneQueries<'_>, point: &SurfacePoint, view: &View, mut found: impl FnMut(u16, Rgb)) {
    let Some(Aovs { graph, numbers }) = &around.scene.materials[point.material as usize].aovs else { return };
    with_slice(
        graph,
        &graph.slices.emission,
        around,
        || *point,
        view,
        |value, _| {
            for (layer, &number) in graph.layers.iter().zip(numbers) {
                if let Closure::Emission { color, strength } = &layer.closure {
                    found(number, finite(value(*color) * value(*strength).x));
                }
            }
        },
    );
}

/// Emitted radiance of a point of a triangle, the same on both sides; negative where it takes light away, as in Cycles. Absorption by sheen
/// and coat is left out.
pub fn emission(
    material: &Material,
    around: SceneQueries<'_>,
    place: [u32; 2],
    barycentric: [f32; 2],
    view: &View,
) -> Rgb {
    emitted(material, around, || surface_point(around, place, barycentric, view), view)
}

/// [`emission`] of a point that is known.
pub fn emission_at(material: &Material, around: SceneQueries<'_>, point: &SurfacePoint, view: &View) -> Rgb {
    emitted(material, around, || *point, view)
}

fn emitted(material: &Material, around: SceneQueries<'_>, point: impl FnOnce() -> SurfacePoint, view: &View) -> Rgb {
    if !material.emits() {
        return Rgb::ZERO;
    }
    let graph = &*material.graph;
    with_slice(graph, &graph.slices.emission, around, point, view, |value, _| {
        let mut sum = Rgb::ZERO;
        for layer in &graph.layers {
            let radiance = match &layer.closure {
                Closure::Emission { color, strength } => value(*color) * value(*strength).x,
                Closure::Principled(p) if p.shines(&graph.program) => {
                    value(p.emission_color) * (value(p.emission_strength).x * value(p.alpha).x.clamp(0.0, 1.0))
                }
                _ => continue,
            };
            sum += finite(radiance) * value(layer.weight).x;
        }
        sum
    })
}
