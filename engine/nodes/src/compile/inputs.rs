//! Nodes that read the surface, the object or the path: no inputs of their own.

use super::{At, Lowered, Outputs, colour, number, vector};
use crate::context::{AttributeKind, Direction, Field, Occlusion, Raycast, Shift, Space};
use crate::graph::Input;
use crate::program::{Operand, Operation};
use crate::surface::Axis;
use crate::vector::VectorMathKind;
use glam::{Affine3A, Vec3A};

impl At<'_, '_> {
    pub(super) fn read(&mut self, field: Field) -> Operand {
        self.emit(Operation::Read(field, self.shift), &[])
    }

    /// Reads a field that is constant within a footprint.
    pub(super) fn read_once(&mut self, field: Field) -> Operand {
        self.emit(Operation::Read(field, Shift::NONE), &[])
    }

    pub(super) fn normal(&mut self) -> Operand {
        self.read_once(Field::Normal)
    }

    /// The normal in the object's space.
    pub(super) fn own_normal(&mut self) -> Operand {
        let normal = self.normal();
        self.emit(Operation::Transform(Direction::Normal, Space::World, Space::Object), &[normal])
    }

    pub(super) fn attribute(&mut self, kind: AttributeKind, name: &str) -> (Operand, Operand) {
        let index = self.compiler.attribute(kind, name);
        let (vector, [fourth]) = self.emit_many(Operation::Attribute(index, self.shift), &[]);
        (vector, fourth)
    }

    pub(super) fn uv(&mut self, name: &str) -> Operand {
        self.attribute(AttributeKind::Uv, name).0
    }
}

#[expect(clippy::too_many_lines, reason = "an arm for each node")]
pub(super) fn lower(at: &mut At<'_, '_>) -> Option<Lowered> {
    Some(match at.node.kind.as_str() {
        "ShaderNodeValue" => {
            let value = at.node.number("value", 0.0);
            Ok(vec![number("Value", at.constant(value))])
        }
        "ShaderNodeRGB" => {
            let parts = at.node.numbers("value").unwrap_or_default();
            let part = |i: usize| parts.get(i).copied().unwrap_or(0.0);
            Ok(vec![colour("Color", at.compiler.constant(Vec3A::new(part(0), part(1), part(2))))])
        }
        "ShaderNodeTexCoord" => texture_coordinates(at),
        "ShaderNodeUVMap" => {
            let name = at.node.word("uv_map").unwrap_or_default();
            let uv =
                if at.node.truth("from_instancer", false) { at.read_once(Field::InstancerUv) } else { at.uv(name) };
            Ok(vec![vector("UV", uv)])
        }
        "ShaderNodeAttribute" => Ok(attribute(at)),
        "ShaderNodeVertexColor" => {
            let (rgb, alpha) = at.attribute(AttributeKind::Colour, at.node.word("layer_name").unwrap_or_default());
            Ok(vec![colour("Color", rgb), number("Alpha", alpha)])
        }
        "ShaderNodeNewGeometry" => {
            let tangent = radial_tangent(at, Axis::Z);
            Ok(vec![
                vector("Position", at.read(Field::Position)),
                vector("Normal", at.normal()),
                vector("Tangent", tangent),
                vector("True Normal", at.read_once(Field::TrueNormal)),
                vector("Incoming", at.read_once(Field::Incoming)),
                vector("Parametric", at.read(Field::Parametric)),
                number("Backfacing", at.read_once(Field::Backfacing)),
                number("Pointiness", at.read(Field::Pointiness)),
                number("Random Per Island", at.read_once(Field::RandomPerIsland)),
            ])
        }
        "ShaderNodeTangent" => tangent(at),
        "ShaderNodeObjectInfo" => Ok(vec![
            vector("Location", at.read_once(Field::ObjectLocation)),
            colour("Color", at.read_once(Field::ObjectColour)),
            number("Alpha", at.read_once(Field::ObjectAlpha)),
            number("Object Index", at.read_once(Field::ObjectIndex)),
            number("Material Index", at.read_once(Field::MaterialIndex)),
            number("Random", at.read_once(Field::ObjectRandom)),
        ]),
        "ShaderNodeParticleInfo" => Ok(vec![
            number("Index", at.read_once(Field::ParticleIndex)),
            number("Random", at.read_once(Field::ParticleRandom)),
            number("Age", at.read_once(Field::ParticleAge)),
            number("Lifetime", at.read_once(Field::ParticleLifetime)),
            vector("Location", at.read_once(Field::ParticleLocation)),
            number("Size", at.read_once(Field::ParticleSize)),
            vector("Velocity", at.read_once(Field::ParticleVelocity)),
            vector("Angular Velocity", at.read_once(Field::ParticleAngularVelocity)),
        ]),
        "ShaderNodeHairInfo" => Ok(vec![
            number("Is Strand", at.read_once(Field::IsStrand)),
            number("Intercept", at.read(Field::StrandIntercept)),
            number("Length", at.read_once(Field::StrandLength)),
            number("Thickness", at.read_once(Field::StrandThickness)),
            vector("Tangent Normal", at.read_once(Field::StrandNormal)),
            number("Random", at.read_once(Field::StrandRandom)),
        ]),
        "ShaderNodePointInfo" => Ok(vec![
            vector("Position", at.read_once(Field::PointPosition)),
            number("Radius", at.read_once(Field::PointRadius)),
            number("Random", at.read_once(Field::PointRandom)),
        ]),
        "ShaderNodeVolumeInfo" => Ok(vec![
            colour("Color", at.read(Field::VolumeColour)),
            number("Density", at.read(Field::VolumeDensity)),
            number("Flame", at.read(Field::VolumeFlame)),
            number("Temperature", at.read(Field::VolumeTemperature)),
        ]),
        "ShaderNodeLightPath" => {
            let outputs = [
                ("Is Camera Ray", Field::IsCameraRay),
                ("Is Shadow Ray", Field::IsShadowRay),
                ("Is Diffuse Ray", Field::IsDiffuseRay),
                ("Is Glossy Ray", Field::IsGlossyRay),
                ("Is Singular Ray", Field::IsSingularRay),
                ("Is Reflection Ray", Field::IsReflectionRay),
                ("Is Transmission Ray", Field::IsTransmissionRay),
                ("Is Volume Scatter Ray", Field::IsVolumeScatterRay),
                ("Ray Length", Field::RayLength),
                ("Ray Depth", Field::RayDepth),
                ("Diffuse Depth", Field::DiffuseDepth),
                ("Glossy Depth", Field::GlossyDepth),
                ("Transparent Depth", Field::TransparentDepth),
                ("Transmission Depth", Field::TransmissionDepth),
                ("Portal Depth", Field::PortalDepth),
            ];
            Ok(outputs.map(|(name, field)| number(name, at.read_once(field))).into())
        }
        "ShaderNodeCameraData" => Ok(vec![
            vector("View Vector", at.read(Field::ViewVector)),
            number("View Z Depth", at.read(Field::ViewDepth)),
            number("View Distance", at.read(Field::ViewDistance)),
        ]),
        "ShaderNodeAmbientOcclusion" => {
            let asked = Occlusion {
                samples: at.node.count("samples").map_or(16, |count| count.clamp(1, 255) as u8),
                inside: at.node.truth("inside", false),
                only_local: at.node.truth("only_local", false),
            };
            let (normal, mut distance) = (at.vector_or("Normal", At::normal), at.number_or("Distance", 1.0));
            let is_linked = matches!(at.node.input("Distance"), Some(Input::Link(_)));
            if !is_linked && at.compiler.known(distance) == Some(Vec3A::ZERO) {
                at.report("without a distance Blender takes the world's; here it is unlimited");
                distance = at.constant(f32::INFINITY);
            }
            let open = at.emit(Operation::Occlusion(asked), &[normal, distance]);
            let (tint, zero) = (at.vector("Color"), at.constant(0.0));
            let tinted = at.emit(Operation::VectorMath(VectorMathKind::Multiply), &[tint, open, zero, zero]);
            Ok(vec![colour("Color", tinted), number("AO", open)])
        }
        "ShaderNodeBevel" => {
            let samples = at.node.count("samples").map_or(4, |count| count.clamp(1, 255) as u8);
            let (normal, radius) = (at.vector_or("Normal", At::normal), at.number_or("Radius", 0.05));
            Ok(vec![vector("Normal", at.emit(Operation::Bevel(samples), &[normal, radius]))])
        }
        "ShaderNodeRaycast" => Ok(raycast(at)),
        _ => return None,
    })
}

/// The outputs of Raycast that show attributes, in the order in which its list has them.
const RAYCAST_ATTRIBUTES: [&str; 8] = [
    "Attribute_0",
    "Attribute_1",
    "Attribute_2",
    "Attribute_3",
    "Attribute_4",
    "Attribute_5",
    "Attribute_6",
    "Attribute_7",
];

fn raycast(at: &mut At<'_, '_>) -> Outputs {
    let position = at.vector_or("Position", |at| at.read(Field::Position));
    let shift = at.compiler.constant(Vec3A::new(at.shift.x, at.shift.y, 0.0));
    let operands = [position, at.vector_or("Direction", At::normal), at.number_or("Length", 1.0), shift];
    let mut asked = Raycast { only_local: at.node.truth("only_local", false), attribute: None };
    let mut outputs = Vec::new();
    for (index, output) in RAYCAST_ATTRIBUTES.into_iter().enumerate() {
        let Some(name) = at.node.word(&format!("attribute_{index}")) else { break };
        if !at.is_used(output) {
            continue;
        }
        // Each has a ray of its own; that of the last one tells the rest, too.
        asked.attribute = Some(at.compiler.attribute(AttributeKind::Geometry, name));
        let (_, [_, _, value]) = at.emit_many(Operation::Raycast(asked), &operands);
        outputs.push(match at.node.word(&format!("attribute_{index}_kind")) {
            Some("RGBA") => colour(output, value),
            Some("VECTOR") => vector(output, value),
            _ => number(output, at.emit(Operation::Mean, &[value])),
        });
    }
    if at.node.word(&format!("attribute_{}", RAYCAST_ATTRIBUTES.len())).is_some() {
        at.report("only its first eight attributes are known, the others are black");
    }
    let (told, [place, normal]) = at.emit_many(Operation::Raycast(asked), &operands);
    let [is_hit, is_self, distance] = [0, 1, 2].map(|part| at.emit(Operation::Part(part), &[told]));
    outputs.extend([
        number("Is Hit", is_hit),
        number("Self Hit", is_self),
        number("Hit Distance", distance),
        vector("Hit Position", place),
        vector("Hit Normal", normal),
    ]);
    outputs
}

fn texture_coordinates(at: &mut At<'_, '_>) -> Lowered {
    let from_instancer = at.node.truth("from_instancer", false);
    let object = match at.node.numbers("object_matrix") {
        // Another object's space: its matrix from the world, row by row.
        Some(rows) if rows.len() >= 12 => {
            let row = |i: usize| Vec3A::new(rows[4 * i], rows[4 * i + 1], rows[4 * i + 2]);
            let turn = glam::Mat3A::from_cols(row(0), row(1), row(2)).transpose();
            let shift = Vec3A::new(rows[3], rows[7], rows[11]);
            let position = at.read(Field::Position);
            at.affine(Affine3A { matrix3: turn, translation: shift }, position)
        }
        Some(_) => return Err("its object's matrix is too short".to_owned()),
        None => at.read(Field::Object),
    };
    Ok(vec![
        vector("Generated", at.read(if from_instancer { Field::InstancerGenerated } else { Field::Generated })),
        vector("Normal", at.own_normal()),
        vector("UV", if from_instancer { at.read(Field::InstancerUv) } else { at.uv("") }),
        vector("Object", object),
        vector("Camera", at.read(Field::Camera)),
        vector("Window", at.read(Field::Window)),
        vector("Reflection", at.read_once(Field::Reflection)),
    ])
}

fn attribute(at: &mut At<'_, '_>) -> Outputs {
    let kind = match at.node.word("attribute_type") {
        Some("OBJECT") => AttributeKind::Object,
        Some("INSTANCER") => AttributeKind::Instancer,
        Some("VIEW_LAYER") => AttributeKind::ViewLayer,
        _ => AttributeKind::Geometry,
    };
    let (value, fourth) = at.attribute(kind, at.node.word("attribute_name").unwrap_or_default());
    let mean = at.emit(Operation::Mean, &[value]);
    vec![colour("Color", value), vector("Vector", value), number("Fac", mean), number("Alpha", fourth)]
}

pub(super) fn radial_tangent(at: &mut At<'_, '_>, axis: Axis) -> Operand {
    let generated = at.read(Field::Generated);
    let normal = at.normal();
    at.emit(Operation::RadialTangent(axis), &[generated, normal])
}

fn tangent(at: &mut At<'_, '_>) -> Lowered {
    let tangent = if at.node.word("direction_type") == Some("UV_MAP") {
        let tangent = at.attribute(AttributeKind::Tangent, at.node.word("uv_map").unwrap_or_default()).0;
        let tangent = at.emit(Operation::Transform(Direction::Normal, Space::Object, Space::World), &[tangent]);
        let normal = at.normal();
        // Square to the normal.
        let zero = at.constant(0.0);
        let cross = Operation::VectorMath(VectorMathKind::Cross);
        let across = at.emit(cross, &[tangent, normal, zero, zero]);
        let back = at.emit(cross, &[normal, across, zero, zero]);
        at.emit(Operation::VectorMath(VectorMathKind::Normalize), &[back, zero, zero, zero])
    } else {
        let axis = at.node.choice("axis", Axis::Z)?;
        radial_tangent(at, axis)
    };
    Ok(vec![vector("Tangent", tangent)])
}
