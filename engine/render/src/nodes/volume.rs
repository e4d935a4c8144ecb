//! Participating media at a point: coefficients of extinction and scattering, and emission.

use super::images::Images;
use super::path_state::PathState;
use crate::sampler::phase::PhaseLobe;
use crate::scene::grid::Grid;
use crate::scene::layer::Source;
use crate::scene::mesh::Mesh;
use crate::scene::volume::{Phase, PrincipledVolume, Volume, VolumeClosure};
use crate::scene::{Instance, Scene};
use crate::surface::mesh_of;
use crate::{Rgb, luminance};
use arrayvec::ArrayVec;
use glam::{Affine3A, Vec3, Vec3A, Vec4};
use petzval_nodes::{Attribute, AttributeKind, Context, Direction, Field, Registers, Shift, Space, answers, blackbody};
use std::cell::RefCell;
use std::f32::consts::PI;

/// Closures that scatter in one place; the rest are taken together with the last.
const MOST_LOBES: usize = 8;
/// Coefficients above this are no longer told apart from a wall.
const DENSEST: f32 = 1e12;

/// The coefficients of a medium at a point, per Blender unit.
#[derive(Clone, Debug, Default)]
pub struct Medium {
    /// Extinction: absorption and scattering.
    pub extinction: Rgb,
    /// The part of the extinction that is scattering.
    pub scattering: Rgb,
    /// Radiance that a unit of length adds.
    pub emission: Rgb,
    /// The parts of `scattering`, and the target of each.
    pub lobes: ArrayVec<(Rgb, PhaseLobe), MOST_LOBES>,
}

impl Medium {
    /// Adds the coefficients of another medium in the same place.
    pub fn add(&mut self, other: &Self) {
        self.extinction += other.extinction;
        self.emission += other.emission;
        for &(scattering, lobe) in &other.lobes {
            self.scatter(scattering, lobe);
        }
    }

    /// The scattered light at a cosine to the direction of arrival, by channel, and the density with which
    /// [`Medium::sample`] chooses that direction.
    pub fn phase(&self, cos: f32, light: Rgb) -> (Rgb, f32) {
        let (mut value, mut pdf, mut total) = (Rgb::ZERO, 0.0, 0.0);
        for (scattering, lobe) in &self.lobes {
            let chance = luminance((light * *scattering).abs());
            let density = lobe.density(cos);
            value += *scattering * density;
            pdf += chance * density;
            total += chance;
        }
        (value, if total > 0.0 { pdf / total } else { 0.0 })
    }

    /// A cosine of the scattering angle, sampled for a path of throughput `light`; `None` where nothing of that is scattered.
    pub fn sample(&self, light: Rgb, u_lobe: f32, u: f32) -> Option<f32> {
        let chances = self.lobes.iter().map(|(scattering, _)| luminance((light * *scattering).abs()));
        let mut left = u_lobe * chances.clone().sum::<f32>();
        let mut last = None;
        for ((_, lobe), chance) in self.lobes.iter().zip(chances) {
            if chance > 0.0 {
                last = Some(lobe);
                left -= chance;
                if left < 0.0 {
                    break;
                }
            }
        }
        last.map(|lobe| lobe.sample(u))
    }

    fn scatter(&mut self, scattering: Rgb, lobe: PhaseLobe) {
        if scattering == Rgb::ZERO {
            return;
        }
        self.scattering += scattering;
        if let Some((known, _)) = self.lobes.iter_mut().find(|(_, other)| *other == lobe) {
            *known += scattering;
        } else if self.lobes.is_full() {
            self.lobes[MOST_LOBES - 1].0 += scattering;
        } else {
            self.lobes.push((scattering, lobe));
        }
    }
}

/// A point of space as a program asks for it.
pub(super) struct VolumePoint<'a> {
    pub(super) scene: &'a Scene,
    /// The object whose volume is evaluated; the world's belongs to none.
    pub(super) own: Option<(&'a Instance, &'a Mesh)>,
    pub(super) volume: &'a Volume,
    /// Position of the point in render space, Blender units.
    pub(super) position: Vec3A,
    pub(super) direction: Vec3A,
    pub(super) way: PathState,
}

impl VolumePoint<'_> {
    fn world(&self) -> Vec3A {
        self.position + self.scene.origin.as_vec3a()
    }

    fn object(&self) -> Vec3A {
        self.own.map_or_else(|| self.world(), |(instance, _)| instance.to_object.transform_point3a(self.position))
    }

    /// 0 to 1 through the mesh's box.
    fn generated(&self) -> Vec3A {
        let Some((_, mesh)) = self.own else { return self.world() };
        let [low, high] = mesh.bounds.map(Vec3A::from);
        let size = high - low;
        let size = Vec3A::select(size.cmpeq(Vec3A::ZERO), Vec3A::ONE, size);
        (self.object() - low) / size
    }

    /// Factor of all coefficients.
    fn density(&self) -> f32 {
        let Some((instance, _)) = self.own.filter(|(_, mesh)| mesh.keeps_opacity) else { return 1.0 };
        let length = instance.to_render.transform_vector3a(Vec3A::ONE.normalize()).length();
        if length > 0.0 { length.recip() } else { 1.0 }
    }

    fn in_camera(&self) -> Vec3A {
        self.scene.viewport.from_render.transform_point3a(self.position)
    }

    fn grid(&self, name: &str) -> Option<&Grid> {
        let (_, mesh) = self.own?;
        mesh.grids.iter().find(|grid| grid.name == name)
    }

    fn in_grid(&self, name: &str) -> Option<Vec4> {
        if name.is_empty() {
            return None;
        }
        self.grid(name).map(|grid| grid.lookup(self.object()))
    }
}

/// A point of space, asked for the fields that change along a ray.
struct AlongRay<'a>(&'a VolumePoint<'a>);

impl AlongRay<'_> {
    answers! {
        /// A field that may differ between two points of a ray.
        fn answer(&self, field: Field) -> Vec3A {
            let at = self.0;
            let number = Vec3A::splat;
            let of_grid = |name: &str| at.in_grid(name).map_or(Vec3A::ZERO, Vec3A::from_vec4);
            match field {
                Position => at.world(),
                Generated => at.generated(),
                Object => at.object(),
                Camera => at.in_camera(),
                Window => at.scene.viewport.window(at.in_camera()),
                ViewVector => at.in_camera().normalize_or_zero(),
                ViewDepth => number(at.in_camera().z),
                ViewDistance => number(at.in_camera().length()),
                VolumeColour => of_grid("color"),
                VolumeDensity => of_grid("density"),
                VolumeFlame => of_grid("flame"),
                VolumeTemperature => of_grid("temperature"),
                // Of surfaces, where they change.
                PixelWidth | RandomPerIsland => Vec3A::ZERO,
                _ => [],
            }
        }
    }
}

impl Context for VolumePoint<'_> {
    answers! {
        fn answer(&self, field: Field, _: Shift) -> Vec3A {
            let number = Vec3A::splat;
            let info = self.own.map(|(instance, _)| &instance.info);
            match field {
                Normal | TrueNormal | Incoming => -self.direction,
                // No sides are near.
                EdgeDistance => Vec3A::INFINITY,
                ObjectLocation => self.own.map_or(Vec3A::ZERO, |(instance, _)| {
                    instance.to_render.translation + self.scene.origin.as_vec3a()
                }),
                ObjectColour => info.map_or(Vec3A::ONE, |info| Vec3A::from_vec4(info.color)),
                ObjectAlpha => number(info.map_or(1.0, |info| info.color.w)),
                ObjectIndex => number(info.map_or(0.0, |info| info.pass_index as f32)),
                ObjectRandom => number(info.map_or(0.0, |info| info.random)),
                MaterialIndex => number(self.volume.pass_index as f32),
                // Of surfaces and of the ray that ends at one.
                MeshNormal | Parametric | Backfacing | Pointiness | Reflection | FootprintX | FootprintY => Vec3A::ZERO,
                RayLength => Vec3A::ZERO,
                // Of hair and of points.
                IsStrand | StrandIntercept | StrandLength | StrandThickness | StrandNormal | StrandRandom | StrandAxis
                | StrandOffset => Vec3A::ZERO,
                PointPosition | PointRadius | PointRandom => Vec3A::ZERO,
                _ => [AlongRay<'_>: AlongRay(self), PathState: self.way],
            }
        }
    }

    fn attribute(&self, index: usize, _: Shift) -> Vec4 {
        let Attribute { kind, name } = &self.volume.program.attributes[index];
        match kind {
            AttributeKind::Colour | AttributeKind::Geometry => self.in_grid(name).unwrap_or(Vec4::ZERO),
            _ => Vec4::ZERO,
        }
    }

    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vec3A) -> Vec3A {
        let origin = self.scene.origin.as_vec3a();
        let viewport = &self.scene.viewport;
        let to_world = self.own.map_or(Affine3A::IDENTITY, |(instance, _)| Affine3A {
            matrix3: instance.to_render.matrix3,
            translation: instance.to_render.translation + origin,
        });
        let map = match (from, to) {
            (Space::Object, Space::World) => to_world,
            (Space::World, Space::Object) => to_world.inverse(),
            (Space::World, Space::Camera) => viewport.from_world,
            (Space::Camera, Space::World) => viewport.from_world.inverse(),
            (Space::Object, Space::Camera) => viewport.from_world * to_world,
            (Space::Camera, Space::Object) => to_world.inverse() * viewport.from_world.inverse(),
            _ => Affine3A::IDENTITY,
        };
        match direction {
            Direction::Point => map.transform_point3a(vector),
            Direction::Vector => map.transform_vector3a(vector),
            Direction::Normal => (map.matrix3.inverse().transpose() * vector).normalize_or_zero(),
        }
    }
}

/// True of a field that may differ between two points of a ray through a volume.
pub(super) fn varies(field: Field) -> bool {
    AlongRay::knows(field)
}

thread_local! {
    static REGISTERS: RefCell<Registers> = RefCell::default();
}

/// The medium of a volume at a place of render space, for light that goes along `direction`. `instance` is the object
/// that it fills; the world's fills none.
pub fn medium(
    volume: &Volume,
    scene: &Scene,
    instance: Option<u32>,
    position: Vec3A,
    direction: Vec3A,
    way: PathState,
) -> Medium {
    let own = instance.map(|index| (&scene.instances[index as usize], mesh_of(scene, index)));
    let place = VolumePoint { scene, own, volume, position, direction, way };
    REGISTERS.with_borrow_mut(|registers| {
        volume.program.run(&place, &Images(&scene.textures), registers);
        let program = &volume.program;
        let value = |source: Source| {
            let value = source.value(program, registers);
            if value.is_finite() { value } else { Vec3A::ZERO }
        };
        let mut sum = Medium::default();
        let density = place.density();
        for layer in &volume.layers {
            let weight = value(layer.weight).x * density;
            if weight > 0.0 {
                add(&mut sum, &layer.closure, weight, &value, &place);
            }
        }
        sum.extinction = sum.extinction.min(Rgb::splat(DENSEST));
        sum
    })
}

/// Adds a closure, as Cycles means it.
fn add(
    sum: &mut Medium,
    closure: &VolumeClosure,
    weight: f32,
    value: &dyn Fn(Source) -> Vec3A,
    place: &VolumePoint<'_>,
) {
    let positive = |value: Vec3A| Rgb::from(value).max(Rgb::ZERO).min(Rgb::splat(DENSEST));
    let per_unit = |density: Source| value(density).x.max(0.0) * weight;
    match closure {
        VolumeClosure::Absorption { color, density } => {
            sum.extinction += positive((Vec3A::ONE - value(*color)) * per_unit(*density));
        }
        VolumeClosure::Scatter { color, density, phase } => {
            let scattering = positive(value(*color) * per_unit(*density));
            sum.extinction += scattering;
            spread(sum, scattering, phase, value);
        }
        VolumeClosure::Coefficients { absorption, scattering, emission, phase } => {
            let [absorption, scattering, emission] =
                [absorption, scattering, emission].map(|source| positive(value(*source) * weight));
            sum.extinction += absorption + scattering;
            sum.emission += emission;
            spread(sum, scattering, phase, value);
        }
        VolumeClosure::Principled(p) => principled(sum, p, weight, value, place),
        VolumeClosure::Emission { color, strength } => {
            sum.emission += positive(value(*color) * value(*strength).x * weight);
        }
    }
}

fn principled(
    sum: &mut Medium,
    p: &PrincipledVolume,
    weight: f32,
    value: &dyn Fn(Source) -> Vec3A,
    place: &VolumePoint<'_>,
) {
    let positive = |value: Vec3A| Rgb::from(value).max(Rgb::ZERO).min(Rgb::splat(DENSEST));
    let mut density = value(p.density).x.max(0.0) * weight;
    if density > 0.0
        && let Some(given) = place.in_grid(&p.density_grid)
    {
        density *= given.x.max(0.0);
    }
    if density > 0.0 {
        let given = place.in_grid(&p.color_grid).map_or(Vec3A::ONE, Vec3A::from_vec4);
        let color = positive(value(p.color) * given);
        let through = positive(value(p.absorption_color)).map(f32::sqrt);
        let absorption = (Rgb::ONE - color).max(Rgb::ZERO) * (Rgb::ONE - through).max(Rgb::ZERO);
        sum.extinction += (color + absorption) * density;
        sum.scatter(color * density, PhaseLobe::henyey_greenstein(value(p.anisotropy).x));
    }
    let strength = value(p.emission_strength).x;
    if strength > 0.0 {
        sum.emission += positive(value(p.emission_color)) * (strength * weight);
    }
    let share = value(p.blackbody).x;
    if share > 0.0 {
        let kelvin = value(p.temperature).x * place.in_grid(&p.temperature_grid).map_or(1.0, |given| given.x.max(0.0));
        let kelvin = kelvin.max(0.0);
        // Stefan and Boltzmann's law in Cycles' units: radiance is a millionth of the emitted power over pi.
        const SIGMA: f32 = 5.670_373e-8 * 1e-6 / PI;
        let intensity = SIGMA * (1.0 + (kelvin.powi(4) - 1.0) * share);
        if intensity > 0.0 {
            let color = positive(value(p.blackbody_tint) * blackbody(kelvin));
            sum.emission += color * (intensity * weight);
        }
    }
}

/// Notes where scattered light goes.
fn spread(sum: &mut Medium, scattering: Rgb, phase: &Phase, value: &dyn Fn(Source) -> Vec3A) {
    let number = |source: &Source| value(*source).x;
    match phase {
        Phase::HenyeyGreenstein { anisotropy } => {
            sum.scatter(scattering, PhaseLobe::henyey_greenstein(number(anisotropy)));
        }
        Phase::Draine { anisotropy, alpha } => {
            sum.scatter(scattering, PhaseLobe::draine(number(anisotropy), number(alpha)));
        }
        Phase::Rayleigh => sum.scatter(scattering, PhaseLobe::RAYLEIGH),
        Phase::FournierForand { ior, backscatter } => {
            sum.scatter(scattering, PhaseLobe::fournier_forand(number(ior), number(backscatter)));
        }
        Phase::Mie { diameter_um } => {
            for (share, lobe) in PhaseLobe::mie(number(diameter_um)) {
                sum.scatter(scattering * share, lobe);
            }
        }
    }
}

/// The place in render space of a place in a mesh's box; each of `part` from 0 to 1.
pub fn within_box(scene: &Scene, instance: u32, part: [f32; 3]) -> Vec3A {
    let [low, high] = mesh_of(scene, instance).bounds;
    let at = low + (high - low) * Vec3::from(part);
    scene.instances[instance as usize].to_render.transform_point3a(at.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    /// Cosines of samples follow the density of all lobes together, for light of a colour that one lobe scatters more than the others.
    #[test]
    fn cosines_follow_their_density() {
        let mut medium = Medium::default();
        medium.scatter(Rgb::new(0.7, 0.2, 0.1), PhaseLobe::henyey_greenstein(0.7));
        medium.scatter(Rgb::new(0.1, 0.2, 0.7), PhaseLobe::henyey_greenstein(-0.4));
        medium.scatter(Rgb::splat(0.2), PhaseLobe::RAYLEIGH);
        for light in [Rgb::ONE, Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.1, 2.0)] {
            sampling::values(
                &format!("medium of three lobes in {light}"),
                1 << 16,
                [-1.0, 1.0],
                |random| {
                    let [u_lobe, u] = random.numbers();
                    medium.sample(light, u_lobe, u).map(f64::from)
                },
                |cos| std::f64::consts::TAU * f64::from(medium.phase(cos as f32, light).1),
            );
        }
    }
}
