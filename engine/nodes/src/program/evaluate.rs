//! The computation of each instruction.

use super::{Instruction, Operation, Program, Registers};
use crate::context::{Context, Direction, Field, Found, Shift, Space, Textures};
use crate::gabor::Gabor;
use crate::image::{self, ImageTexture, Projection};
use crate::lanes::{Number, Vector};
use crate::math::{clamp_between, clamp_in_order, map_range};
use crate::mix::interpolate;
use crate::noise::{Octaves, noise_texture};
use crate::patterns::{Brick, Wave, checker, gradient, magic, white_noise, white_noise_colour};
use crate::surface::{self, Bump, NormalSpace};
use crate::tiling::RadialTiling;
use crate::vector::{mapping, rotate};
use crate::voronoi::Voronoi;
use crate::{colour, spectral};
use glam::{Vec2, Vec3A};

impl Program {
    #[inline]
    pub(crate) fn step<C: Context, T: Textures>(
        &self,
        instruction: &Instruction,
        context: &C,
        textures: &T,
        registers: &mut Registers,
    ) {
        let given = &*registers;
        let operand = |i: usize| self.value(instruction.operands[i], given);
        let (result, further) = match instruction.operation {
            Operation::Further(which) => (given.further[usize::from(which)], None),
            operation => self.compute(operation, operand, context, textures),
        };
        registers_write(registers, instruction.result, result, further);
    }

    /// The result of an operation on operands, and the further results if it has any.
    #[inline(always)]
    #[expect(clippy::too_many_lines, reason = "an arm for each operation")]
    pub(super) fn compute<C: Context, T: Textures>(
        &self,
        operation: Operation,
        vector: impl Fn(usize) -> Vec3A,
        context: &C,
        textures: &T,
    ) -> (Vec3A, Option<[Vec3A; 3]>) {
        let number = |i: usize| vector(i).x;
        let splat = Vec3A::splat;
        let mut further = None;
        let result = match operation {
            // Those of the instruction before.
            Operation::Further(_) => Vec3A::ZERO,
            Operation::Read(field, shift) => context.read(field, shift),
            Operation::Attribute(index, shift) => {
                let value = context.attribute(usize::from(index), shift);
                further = Some([splat(value.w), Vec3A::ZERO, Vec3A::ZERO]);
                Vec3A::from_vec4(value)
            }
            Operation::Affine(map) => self.maps[usize::from(map)].transform_point3a(vector(0)),
            Operation::Transform(direction, from, to) => context.transform(direction, from, to, vector(0)),
            Operation::Luminance => splat(colour::luminance(vector(0))),
            Operation::Mean => splat(vector(0).element_sum() * (1.0 / 3.0)),
            Operation::Part(0) => splat(vector(0).x),
            Operation::Part(1) => splat(vector(0).y),
            Operation::Part(_) => splat(vector(0).z),
            Operation::Combine => Vec3A::new(number(0), number(1), number(2)),
            Operation::ToModel(model) => colour::to_model(model, vector(0)),
            Operation::FromModel(model) => colour::from_model(model, vector(0)),
            Operation::Math(kind, clamped) => {
                let value = kind.apply(number(0), number(1), number(2));
                splat(if clamped { value.clamp(0.0, 1.0) } else { value })
            }
            Operation::VectorMath(kind) => kind.apply(vector(0), vector(1), vector(2), number(3)),
            Operation::MapRange(kind) => {
                splat(map_range(kind, number(0), [number(1), number(2)], [number(3), number(4)], number(5), 0.0))
            }
            Operation::MapRangeVector(kind) => {
                let v = [0, 1, 2, 3, 4, 5].map(vector);
                Vec3A::from_array(std::array::from_fn(|i| {
                    map_range(kind, v[0][i], [v[1][i], v[2][i]], [v[3][i], v[4][i]], v[5][i], v[3][i])
                }))
            }
            Operation::Clamp(true) => splat(clamp_between(number(0), number(1), number(2))),
            Operation::Clamp(false) => splat(clamp_in_order(number(0), number(1), number(2))),
            Operation::ClampVector => {
                let v = [0, 1, 2].map(vector);
                Vec3A::from_array(std::array::from_fn(|i| clamp_between(v[0][i], v[1][i], v[2][i])))
            }
            Operation::Mix(blend) => blend.apply(number(0), vector(1), vector(2)),
            Operation::MixParts => interpolate(vector(1), vector(2), vector(0)),
            Operation::Saturate => vector(0).saturated(),
            Operation::Invert => colour::invert(vector(0), number(1)),
            Operation::Gamma => colour::gamma(vector(0), number(1)),
            Operation::BrightContrast => colour::bright_contrast(vector(0), number(1), number(2)),
            Operation::HueSaturation => colour::hue_saturation(vector(4), number(0), number(1), number(2), number(3)),
            Operation::Ramp(table) => {
                let row = self.tables[usize::from(table)].ramp(number(0));
                further = Some([splat(row.w), Vec3A::ZERO, Vec3A::ZERO]);
                Vec3A::from_vec4(row)
            }
            Operation::Curves(table) => self.tables[usize::from(table)].curves(number(0), vector(1)),
            Operation::FloatCurve(table) => splat(self.tables[usize::from(table)].float_curve(number(0), number(1))),
            Operation::Blackbody => spectral::blackbody(number(0)),
            Operation::Wavelength => spectral::wavelength(number(0)),
            Operation::Fresnel => splat(surface::fresnel(number(0), cosine(context, vector(1)), backfacing(context))),
            Operation::LayerFresnel => {
                splat(surface::layer_fresnel(number(0), cosine(context, vector(1)), backfacing(context)))
            }
            Operation::Facing => splat(surface::facing(number(0), cosine(context, vector(1)))),
            Operation::Falloff(power) => {
                let length = context.read(Field::RayLength, Shift::NONE).x;
                splat(surface::falloff(number(0), number(1), length, i32::from(power)))
            }
            Operation::Occlusion(asked) => splat(context.open(asked, vector(0), number(1))),
            Operation::Bevel(samples) => {
                let shading = context.read(Field::Normal, Shift::NONE);
                (vector(0) + (context.bevelled(samples, number(1)) - shading)).normalize_or(shading)
            }
            Operation::Raycast(asked) => {
                let shift = Shift { x: vector(3).x, y: vector(3).y };
                let found = context.raycast(asked, vector(0), vector(1), number(2), shift);
                let found = found.unwrap_or(Found { distance: number(2), ..Found::default() });
                further = Some([found.position, found.normal, Vec3A::from_vec4(found.attribute)]);
                let answer = |yes: bool| if yes { 1.0 } else { 0.0 };
                Vec3A::new(answer(found.is_hit), answer(found.is_self), found.distance)
            }
            Operation::Wireframe(in_pixels) => {
                let pixel = if in_pixels { context.read(Field::PixelWidth, Shift::NONE).x } else { 1.0 };
                // The triangle beside draws the other half.
                splat(if number(1) < 0.5 * number(0) * pixel { 1.0 } else { 0.0 })
            }
            Operation::Noise(dimensions, fractal, normalize, coloured) => {
                let (scale, p) = (number(2), vector(0));
                let octaves = Octaves {
                    fractal,
                    normalize,
                    detail: number(3),
                    roughness: number(4),
                    lacunarity: number(5),
                    offset: number(6),
                    gain: number(7),
                };
                let p = (p * scale).to_array();
                Vec3A::from_array(noise_texture(dimensions, octaves, p, number(1) * scale, number(8), coloured))
            }
            Operation::Voronoi(dimensions, feature, metric, hash, normalize) => {
                let voronoi = Voronoi {
                    hash,
                    feature,
                    metric,
                    normalize,
                    scale: number(2),
                    detail: number(3),
                    roughness: number(4),
                    lacunarity: number(5),
                    smoothness: number(6),
                    exponent: number(7),
                    randomness: number(8),
                };
                let nearest = voronoi.at(dimensions, vector(0), number(1));
                let position = Vec3A::from_vec4(nearest.position);
                further = Some([nearest.colour, position, splat(nearest.position.w)]);
                splat(nearest.distance)
            }
            Operation::Wave(kind, axis, profile) => {
                let wave = Wave {
                    kind,
                    axis,
                    profile,
                    distortion: number(2),
                    detail: number(3),
                    detail_scale: number(4),
                    detail_roughness: number(5),
                    phase: number(6),
                };
                splat(wave.at(vector(0) * number(1)))
            }
            Operation::Magic(depth) => magic(vector(0) * number(1), number(2), depth),
            Operation::Gradient(kind) => splat(gradient(kind, vector(0))),
            Operation::Checker => splat(if checker(vector(0) * number(1)) { 1.0 } else { 0.0 }),
            Operation::Brick(offset_frequency, squash_frequency) => {
                let brick = Brick {
                    mortar_size: number(2),
                    mortar_smooth: number(3),
                    bias: number(4),
                    width: number(5),
                    row_height: number(6),
                    offset: number(7),
                    squash: number(8),
                    offset_frequency: i32::from(offset_frequency),
                    squash_frequency: i32::from(squash_frequency),
                };
                let (tint, mortar) = brick.at(vector(0) * number(1));
                further = Some([splat(tint), Vec3A::ZERO, Vec3A::ZERO]);
                splat(mortar)
            }
            Operation::WhiteNoise(dimensions) => {
                further = Some([white_noise_colour(dimensions, vector(0), number(1)), Vec3A::ZERO, Vec3A::ZERO]);
                splat(white_noise(dimensions, vector(0), number(1)))
            }
            Operation::RadialTiling(normalize) => {
                let tile = RadialTiling::new(number(1), number(2), normalize).at(vector(0));
                further = Some([tile.segment, tile.width, tile.rotation].map(splat));
                tile.coordinates
            }
            Operation::Gabor(kind) => {
                let gabor = Gabor {
                    frequency: number(2),
                    anisotropy: number(3),
                    orientation_rad: number(4),
                    direction: vector(5),
                };
                let waves = gabor.at(kind, vector(0) * number(1));
                further = Some([splat(waves.phase), splat(waves.intensity), Vec3A::ZERO]);
                splat(waves.value)
            }
            Operation::Luminaire(luminaire) => {
                let d = vector(0).normalize_or_zero();
                let vertical = (-d.z).clamp(-1.0, 1.0).acos();
                let horizontal = d.x.atan2(d.y) + std::f32::consts::PI;
                splat(number(1) * self.luminaires[usize::from(luminaire)].at(horizontal, vertical))
            }
            Operation::Sky(sky) => self.skies[usize::from(sky)].at(vector(0), context.shows_sun()),
            Operation::Image(picture, projection) => {
                let (colour, alpha) = image_texture(picture, projection, vector(0), number(1), context, textures);
                further = Some([splat(alpha), Vec3A::ZERO, Vec3A::ZERO]);
                colour
            }
            Operation::Environment(picture, projection) => {
                Vec3A::from_vec4(picture.at(textures, image::environment(projection, vector(0))))
            }
            Operation::Mapping(kind) => mapping(kind, vector(0), vector(1), vector(2), vector(3)),
            Operation::Rotate(kind, inverted) => {
                rotate(kind, inverted, vector(0), vector(1), vector(2), number(3), vector(4))
            }
            Operation::RadialTangent(axis) => {
                let around = surface::around(axis, vector(0));
                let around = context.transform(Direction::Normal, Space::Object, Space::World, around);
                let normal = vector(1);
                normal.cross(around.cross(normal).normalize_or_zero()).normalize_or_zero()
            }
            Operation::Bump(width) => {
                let axes = [Field::FootprintX, Field::FootprintY];
                let bump = Bump {
                    heights: [number(0), number(1), number(2)],
                    axes: axes.map(|axis| context.read(axis, Shift::NONE) * width),
                    strength: number(4),
                    distance: number(5),
                };
                bump.normal(vector(3))
            }
            Operation::NormalMap(space) => normal_map(space, vector(0), number(1), vector(2), number(3), context),
            Operation::Displacement(space) => {
                let height = (number(0) - number(1)) * number(2);
                match space {
                    Space::Object => {
                        let normal = context.transform(Direction::Normal, Space::World, Space::Object, vector(3));
                        let moved = normal.normalize_or_zero() * height;
                        context.transform(Direction::Vector, Space::Object, Space::World, moved)
                    }
                    Space::World | Space::Camera => vector(3).normalize_or_zero() * height,
                }
            }
            Operation::VectorDisplacement(space) => {
                let moved = (vector(0) - number(1)) * number(2);
                match space {
                    NormalSpace::World | NormalSpace::BlenderWorld => moved,
                    NormalSpace::Object | NormalSpace::BlenderObject => {
                        context.transform(Direction::Vector, Space::Object, Space::World, moved)
                    }
                    NormalSpace::Tangent => {
                        let normal = context.read(Field::Normal, Shift::NONE);
                        let normal = context.transform(Direction::Normal, Space::World, Space::Object, normal);
                        let tangent = vector(3);
                        let across = normal.cross(tangent).normalize_or_zero() * number(4);
                        let moved = tangent * moved.x + normal * moved.y + across * moved.z;
                        context.transform(Direction::Vector, Space::Object, Space::World, moved)
                    }
                }
            }
        };
        (result, further)
    }
}

#[inline(always)]
fn registers_write(registers: &mut Registers, place: u16, result: Vec3A, further: Option<[Vec3A; 3]>) {
    // Results lie below FIRST_CONSTANT, so nothing is cut off.
    registers.values[usize::from(place as u8)] = result;
    if let Some(further) = further {
        registers.further = further;
    }
}

fn cosine(context: &impl Context, normal: Vec3A) -> f32 {
    context.read(Field::Incoming, Shift::NONE).dot(normal)
}

fn backfacing(context: &impl Context) -> bool {
    context.read(Field::Backfacing, Shift::NONE).x != 0.0
}

fn image_texture<C: Context, T: Textures>(
    picture: ImageTexture,
    projection: Projection,
    p: Vec3A,
    blend: f32,
    context: &C,
    textures: &T,
) -> (Vec3A, f32) {
    let rgba = match projection {
        Projection::Flat => picture.at(textures, Vec2::new(p.x, p.y)),
        Projection::Sphere => picture.at(textures, image::sphere(p)),
        Projection::Tube => picture.at(textures, image::tube(p)),
        Projection::Box => {
            let normal = context.read(Field::Normal, Shift::NONE);
            let normal = context.transform(Direction::Normal, Space::World, Space::Object, normal);
            picture.on_box(textures, p, normal, blend)
        }
    };
    (Vec3A::from_vec4(rgba), rgba.w)
}

/// The queries that instructions make of a point, or of all points of the lanes.
pub(super) trait Asked {
    type Vector: Vector;
    fn read(&self, field: Field) -> Self::Vector;
    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Self::Vector) -> Self::Vector;
}

/// A point by itself.
struct One<'a, C>(&'a C);

impl<C: Context> Asked for One<'_, C> {
    type Vector = Vec3A;
    #[inline(always)]
    fn read(&self, field: Field) -> Vec3A {
        self.0.read(field, Shift::NONE)
    }
    #[inline(always)]
    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vec3A) -> Vec3A {
        self.0.transform(direction, from, to, vector)
    }
}

/// A normal by the colour of a map in tangent space; where there is no tangent, the shading normal.
#[inline(always)]
pub(super) fn tangent_map<A: Asked<Vector: Vector<Number = N>>, N: Number>(
    point: &A,
    colour: A::Vector,
    strength: N,
    tangent: A::Vector,
    sign: N,
) -> A::Vector {
    let mapped = colour.times(N::of(2.0)) - A::Vector::splat(N::of(1.0));
    // Unit, as in Cycles 5: between normals that differ much it would be shorter, and the map the stronger.
    let normal = point.read(Field::MeshNormal).unit();
    let mapped = surface::tangent_space(mapped, strength, tangent, sign, normal);
    let [is_behind, ..] = point.read(Field::Backfacing).parts();
    let turned = N::of(1.0) - (is_behind + is_behind);
    let mapped = point.transform(Direction::Normal, Space::Object, Space::World, mapped).times(turned).parts();
    let (size, otherwise) = (tangent.inner(tangent), point.read(Field::Normal).parts());
    let part = |i: usize| size.if_below(N::of(f32::MIN_POSITIVE), otherwise[i], mapped[i]);
    A::Vector::of([part(0), part(1), part(2)])
}

fn normal_map<C: Context>(
    space: NormalSpace,
    colour: Vec3A,
    strength: f32,
    tangent: Vec3A,
    sign: f32,
    context: &C,
) -> Vec3A {
    if space == NormalSpace::Tangent {
        return tangent_map(&One(context), colour, strength, tangent, sign);
    }
    let mut mapped = colour * 2.0 - Vec3A::ONE;
    let turned = if backfacing(context) { -1.0 } else { 1.0 };
    if matches!(space, NormalSpace::BlenderObject | NormalSpace::BlenderWorld) {
        mapped *= Vec3A::new(1.0, -1.0, -1.0);
    }
    if matches!(space, NormalSpace::Object | NormalSpace::BlenderObject) {
        mapped = context.transform(Direction::Normal, Space::Object, Space::World, mapped);
    }
    let mapped = mapped.normalize_or_zero() * turned;
    surface::strengthened(mapped, context.read(Field::Normal, Shift::NONE), strength)
}
