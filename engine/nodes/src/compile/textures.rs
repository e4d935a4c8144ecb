//! The instructions of Blender's texture nodes.

use super::{At, Lowered, Outputs, colour, number, vector};
use crate::context::{Extension, Field, ImageReading, Interpolation, Shift};
use crate::gabor::GaborKind;
use crate::ies::Ies;
use crate::image::{EnvironmentProjection, ImageTexture, MISSING, Projection};
use crate::mix::Blend;
use crate::noise::{Dimensions, Fractal};
use crate::patterns::{GradientKind, WaveAxis, WaveKind, WaveProfile};
use crate::program::{Operand, Operation};
use crate::sky::Sky;
use crate::sky::atmosphere::{Atmosphere, AtmosphereSettings, ScatteringOrders};
use crate::sky::hosek::Hosek;
use crate::sky::preetham::Preetham;
use crate::voronoi::{CellHash, Feature, Metric};
use glam::Vec3A;

impl At<'_, '_> {
    /// A texture's coordinates: generated where nothing is linked.
    fn coordinates(&mut self) -> Operand {
        self.vector_or("Vector", |at| at.read(Field::Generated))
    }
}

pub(super) fn lower(at: &mut At<'_, '_>) -> Option<Lowered> {
    Some(match at.node.kind.as_str() {
        "ShaderNodeTexNoise" => noise(at),
        "ShaderNodeTexVoronoi" => voronoi(at),
        "ShaderNodeTexWave" => wave(at),
        "ShaderNodeTexMagic" => Ok(magic(at)),
        "ShaderNodeTexGradient" => gradient(at),
        "ShaderNodeTexChecker" => Ok(checker(at)),
        "ShaderNodeTexBrick" => Ok(brick(at)),
        "ShaderNodeTexWhiteNoise" => white_noise(at),
        "ShaderNodeTexGabor" => gabor(at),
        "ShaderNodeRadialTiling" => Ok(radial_tiling(at)),
        "ShaderNodeTexSky" => sky(at),
        "ShaderNodeTexIES" => luminaire(at),
        "ShaderNodeTexImage" => image(at),
        "ShaderNodeTexEnvironment" => environment(at),
        _ => return None,
    })
}

fn radial_tiling(at: &mut At<'_, '_>) -> Outputs {
    let normalize = at.node.truth("normalize", false);
    let operands = [at.vector("Vector"), at.number("Sides"), at.number("Roundness")];
    let (coordinates, [segment, width, rotation]) = at.emit_many(Operation::RadialTiling(normalize), &operands);
    vec![
        vector("Segment Coordinates", coordinates),
        number("Segment ID", segment),
        number("Segment Width", width),
        number("Segment Rotation", rotation),
    ]
}

fn luminaire(at: &mut At<'_, '_>) -> Lowered {
    let text = at.node.word("ies_text").ok_or("its file is missing, it is black")?;
    let luminaire = Ies::parse(text).map_err(|what| format!("{what}, it is black"))?;
    let luminaires = &mut at.compiler.program.luminaires;
    let place = luminaires.iter().position(|other| *other == luminaire).unwrap_or_else(|| {
        luminaires.push(luminaire);
        luminaires.len() - 1
    });
    let direction = at.vector_or("Vector", At::own_normal);
    let operands = [direction, at.number("Strength")];
    Ok(vec![number("Fac", at.emit(Operation::Luminaire(place as u16), &operands))])
}

fn noise(at: &mut At<'_, '_>) -> Lowered {
    let dimensions = at.node.choice("noise_dimensions", Dimensions::Three)?;
    let fractal = at.node.choice("noise_type", Fractal::Sum)?;
    let normalize = at.node.truth("normalize", true);
    let p = at.coordinates();
    let operands = [
        p,
        at.number("W"),
        at.number("Scale"),
        at.number("Detail"),
        at.number("Roughness"),
        at.number("Lacunarity"),
        at.number("Offset"),
        at.number("Gain"),
        at.number("Distortion"),
    ];
    let coloured = at.is_used("Color");
    let value = at.emit(Operation::Noise(dimensions, fractal, normalize, coloured), &operands);
    let first = if coloured { at.emit(Operation::Part(0), &[value]) } else { value };
    Ok(vec![number("Fac", first), colour("Color", value)])
}

fn voronoi(at: &mut At<'_, '_>) -> Lowered {
    let dimensions = at.node.choice("voronoi_dimensions", Dimensions::Three)?;
    let feature = at.node.choice("feature", Feature::First)?;
    let metric = at.node.choice("distance", Metric::Euclidean)?;
    let normalize = at.node.truth("normalize", false);
    let p = at.coordinates();
    let operands = [
        p,
        at.number("W"),
        at.number("Scale"),
        at.number("Detail"),
        at.number("Roughness"),
        at.number_or("Lacunarity", 2.0),
        at.number("Smoothness"),
        at.number("Exponent"),
        at.number("Randomness"),
    ];
    // The add-on says which, by the Blender that it runs in.
    let hash = at.node.choice("cell_hash", CellHash::Pcg)?;
    let operation = Operation::Voronoi(dimensions, feature, metric, hash, normalize);
    let (distance, [rgb, position, w]) = at.emit_many(operation, &operands);
    Ok(vec![
        number("Distance", distance),
        colour("Color", rgb),
        vector("Position", position),
        number("W", w),
        number("Radius", distance),
    ])
}

fn wave(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("wave_type", WaveKind::Bands)?;
    let direction = if kind == WaveKind::Bands { "bands_direction" } else { "rings_direction" };
    let axis = at.node.choice(direction, WaveAxis::X)?;
    let profile = at.node.choice("wave_profile", WaveProfile::Sine)?;
    let p = at.coordinates();
    let operands = [
        p,
        at.number("Scale"),
        at.number("Distortion"),
        at.number("Detail"),
        at.number("Detail Scale"),
        at.number("Detail Roughness"),
        at.number("Phase Offset"),
    ];
    let value = at.emit(Operation::Wave(kind, axis, profile), &operands);
    Ok(vec![colour("Color", value), number("Fac", value)])
}

fn magic(at: &mut At<'_, '_>) -> super::Outputs {
    let depth = at.node.count("turbulence_depth").unwrap_or(2).min(10) as u8;
    let operands = [at.coordinates(), at.number("Scale"), at.number("Distortion")];
    let value = at.emit(Operation::Magic(depth), &operands);
    vec![colour("Color", value), number("Fac", at.emit(Operation::Mean, &[value]))]
}

fn gradient(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("gradient_type", GradientKind::Linear)?;
    let p = at.coordinates();
    let value = at.emit(Operation::Gradient(kind), &[p]);
    Ok(vec![colour("Color", value), number("Fac", value)])
}

fn checker(at: &mut At<'_, '_>) -> super::Outputs {
    let operands = [at.coordinates(), at.number("Scale")];
    let first = at.emit(Operation::Checker, &operands);
    let (one, two) = (at.vector("Color1"), at.vector("Color2"));
    vec![colour("Color", at.emit(Operation::Mix(Blend::Mix), &[first, two, one])), number("Fac", first)]
}

fn brick(at: &mut At<'_, '_>) -> super::Outputs {
    let frequency = |name: &str| at.node.count(name).unwrap_or(1).min(99) as i16;
    let operation = Operation::Brick(frequency("offset_frequency"), frequency("squash_frequency"));
    let operands = [
        at.coordinates(),
        at.number("Scale"),
        at.number("Mortar Size"),
        at.number("Mortar Smooth"),
        at.number("Bias"),
        at.number("Brick Width"),
        at.number("Row Height"),
        at.constant(at.node.number("offset", 0.5)),
        at.constant(at.node.number("squash", 1.0)),
    ];
    let (mortar, [tint]) = at.emit_many(operation, &operands);
    let (one, two, between) = (at.vector("Color1"), at.vector("Color2"), at.vector("Mortar"));
    let brick = at.emit(Operation::Mix(Blend::Mix), &[tint, one, two]);
    vec![colour("Color", at.emit(Operation::Mix(Blend::Mix), &[mortar, brick, between])), number("Fac", mortar)]
}

fn white_noise(at: &mut At<'_, '_>) -> Lowered {
    let dimensions = at.node.choice("noise_dimensions", Dimensions::Three)?;
    // Blender takes a constant here, unlike other textures.
    let operands = [at.vector("Vector"), at.number("W")];
    let (value, [rgb]) = at.emit_many(Operation::WhiteNoise(dimensions), &operands);
    Ok(vec![number("Value", value), colour("Color", rgb)])
}

fn gabor(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("gabor_type", GaborKind::Flat)?;
    let operands = [
        at.coordinates(),
        at.number("Scale"),
        at.number("Frequency"),
        at.number("Anisotropy"),
        at.number("Orientation 2D"),
        at.vector("Orientation 3D"),
    ];
    let (value, [phase, intensity]) = at.emit_many(Operation::Gabor(kind), &operands);
    Ok(vec![number("Value", value), number("Phase", phase), number("Intensity", intensity)])
}

fn sky(at: &mut At<'_, '_>) -> Lowered {
    let node = at.node;
    let sun = || match node.numbers("sun_direction").unwrap_or_default()[..] {
        [x, y, z] => Ok(Vec3A::new(x, y, z)),
        _ => Err("it came without its sun, it is black".to_owned()),
    };
    let turbidity = node.number("turbidity", 2.2);
    let made = match node.word("sky_type").unwrap_or_default() {
        "PREETHAM" => Sky::Preetham(Preetham::new(sun()?, turbidity)),
        "HOSEK_WILKIE" => Sky::Hosek(Box::new(Hosek::new(sun()?, turbidity, node.number("ground_albedo", 0.3)))),
        kind @ ("NISHITA" | "SINGLE_SCATTERING" | "MULTIPLE_SCATTERING") => {
            Sky::Atmosphere(Box::new(Atmosphere::new(AtmosphereSettings {
                scattering: match kind {
                    "MULTIPLE_SCATTERING" => ScatteringOrders::Multiple,
                    _ => ScatteringOrders::Once { older: kind == "NISHITA" },
                },
                sun_disc: node.truth("sun_disc", true),
                sun_diameter_rad: node.number("sun_size", 0.009_512),
                sun_intensity: node.number("sun_intensity", 1.0),
                sun_elevation_rad: node.number("sun_elevation", 0.261_8),
                sun_rotation_rad: node.number("sun_rotation", 0.0),
                altitude_m: node.number("altitude", 0.0),
                // Blender 4 calls aerosols dust.
                densities: [
                    node.number("air_density", 1.0),
                    node.number("aerosol_density", node.number("dust_density", 1.0)),
                    node.number("ozone_density", 1.0),
                ],
            })))
        }
        kind => return Err(format!("sky_type {kind} is not supported, it is black")),
    };
    let skies = &mut at.compiler.program.skies;
    skies.push(made);
    let operation = Operation::Sky((skies.len() - 1) as u16);
    let direction = at.coordinates();
    Ok(vec![colour("Color", at.emit(operation, &[direction]))])
}

fn image(at: &mut At<'_, '_>) -> Lowered {
    let Some(image) = at.node.count("image") else {
        let pink = at.compiler.constant(MISSING.into());
        return Ok(vec![colour("Color", pink), number("Alpha", at.constant(1.0))]);
    };
    let reading = ImageReading {
        interpolation: at.node.choice("interpolation", Interpolation::Linear)?,
        extension: at.node.choice("extension", Extension::Repeat)?,
        // Cycles divides where the node's alpha is used.
        unassociate: at.node.truth("alpha_is_transparency", true) && at.is_used("Alpha"),
    };
    let picture = ImageTexture { image, reading };
    let projection = at.node.choice("projection", Projection::Flat)?;
    let p = at.vector_or("Vector", |at| at.uv(""));
    let blend = at.constant(at.node.number("projection_blend", 0.0));
    let (rgb, [alpha]) = at.emit_many(Operation::Image(picture, projection), &[p, blend]);
    Ok(vec![colour("Color", rgb), number("Alpha", alpha)])
}

fn environment(at: &mut At<'_, '_>) -> Lowered {
    let Some(image) = at.node.count("image") else {
        let pink = at.compiler.constant(MISSING.into());
        return Ok(vec![colour("Color", pink)]);
    };
    let reading = ImageReading {
        interpolation: at.node.choice("interpolation", Interpolation::Linear)?,
        extension: Extension::Repeat,
        unassociate: false,
    };
    let picture = ImageTexture { image, reading };
    let projection = at.node.choice("projection", EnvironmentProjection::Equirectangular)?;
    let direction = at.vector_or("Vector", |at| at.emit(Operation::Read(Field::Position, Shift::NONE), &[]));
    Ok(vec![colour("Color", at.emit(Operation::Environment(picture, projection), &[direction]))])
}
