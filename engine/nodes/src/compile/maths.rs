//! Nodes that calculate with numbers and vectors.

use super::{At, Lowered, number, vector};
use crate::context::{Direction, Space};
use crate::math::{MathKind, RangeKind};
use crate::program::Operation;
use crate::vector::{MappingKind, RotationKind, VectorMathKind, affine_mapping};
use glam::Vec3A;

pub(super) fn lower(at: &mut At<'_, '_>) -> Option<Lowered> {
    Some(match at.node.kind.as_str() {
        "ShaderNodeMath" => math(at),
        "ShaderNodeVectorMath" => vector_math(at),
        "ShaderNodeMapRange" => map_range(at),
        "ShaderNodeClamp" => {
            let either_order = at.node.word("clamp_type") == Some("RANGE");
            let operands = [at.number("Value"), at.number("Min"), at.number("Max")];
            Ok(vec![number("Result", at.emit(Operation::Clamp(either_order), &operands))])
        }
        "ShaderNodeMapping" => mapping(at),
        "ShaderNodeVectorRotate" => rotate(at),
        "ShaderNodeVectorTransform" => transform(at),
        "ShaderNodeNormal" => Ok(normal(at)),
        _ => return None,
    })
}

fn math(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("operation", MathKind::Add)?;
    let operands = [at.number("Value"), at.number("Value_001"), at.number("Value_002")];
    let clamped = at.node.truth("use_clamp", false);
    Ok(vec![number("Value", at.emit(Operation::Math(kind, clamped), &operands))])
}

fn vector_math(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("operation", VectorMathKind::Add)?;
    let operands = [at.vector("Vector"), at.vector("Vector_001"), at.vector("Vector_002"), at.number("Scale")];
    let result = at.emit(Operation::VectorMath(kind), &operands);
    let zero = at.constant(0.0);
    Ok(if kind.gives_value() {
        vec![number("Value", result), vector("Vector", zero)]
    } else {
        vec![vector("Vector", result), number("Value", zero)]
    })
}

fn map_range(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("interpolation_type", RangeKind::Linear)?;
    // The smooth ones stay in range by themselves.
    let clamped = at.node.truth("clamp", true) && matches!(kind, RangeKind::Linear | RangeKind::Stepped);
    if at.node.word("data_type") == Some("FLOAT_VECTOR") {
        let operands =
            ["Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Steps_FLOAT3"]
                .map(|name| at.vector(name));
        let mapped = at.emit(Operation::MapRangeVector(kind), &operands);
        let bounded = [mapped, operands[3], operands[4]];
        return Ok(vec![vector("Vector", if clamped { at.emit(Operation::ClampVector, &bounded) } else { mapped })]);
    }
    let operands = ["Value", "From Min", "From Max", "To Min", "To Max", "Steps"].map(|name| at.number(name));
    let mapped = at.emit(Operation::MapRange(kind), &operands);
    let bounded = [mapped, operands[3], operands[4]];
    Ok(vec![number("Result", if clamped { at.emit(Operation::Clamp(true), &bounded) } else { mapped })])
}

fn mapping(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("vector_type", MappingKind::Point)?;
    let operands = [at.vector("Vector"), at.vector("Location"), at.vector("Rotation"), at.vector("Scale")];
    let known = operands.map(|operand| at.compiler.known(operand));
    // What stands still is made a matrix here: no sines at each point. Normals are no affine map.
    let mapped = match known {
        [None, Some(location), Some(rotation), Some(scale)] if kind != MappingKind::Normal => {
            at.affine(affine_mapping(kind, location, rotation, scale), operands[0])
        }
        _ => at.emit(Operation::Mapping(kind), &operands),
    };
    Ok(vec![vector("Vector", mapped)])
}

fn rotate(at: &mut At<'_, '_>) -> Lowered {
    let kind = at.node.choice("rotation_type", RotationKind::Axis)?;
    let inverted = at.node.truth("invert", false);
    let operands =
        [at.vector("Vector"), at.vector("Center"), at.vector("Axis"), at.number("Angle"), at.vector("Rotation")];
    Ok(vec![vector("Vector", at.emit(Operation::Rotate(kind, inverted), &operands))])
}

fn transform(at: &mut At<'_, '_>) -> Lowered {
    let direction = at.node.choice("vector_type", Direction::Vector)?;
    let from = at.node.choice("convert_from", Space::World)?;
    let to = at.node.choice("convert_to", Space::Object)?;
    let given = at.vector("Vector");
    let moved = if from == to { given } else { at.emit(Operation::Transform(direction, from, to), &[given]) };
    let moved = if direction == Direction::Normal {
        let zero = at.constant(0.0);
        at.emit(Operation::VectorMath(VectorMathKind::Normalize), &[moved, zero, zero, zero])
    } else {
        moved
    };
    Ok(vec![vector("Vector", moved)])
}

/// A direction set by hand, and how much the input agrees with it.
fn normal(at: &mut At<'_, '_>) -> super::Outputs {
    let own = at.node.numbers("value").unwrap_or_default();
    let own = if let [x, y, z] = own[..] { Vec3A::new(x, y, z) } else { Vec3A::Z };
    let own = at.compiler.constant(own.normalize_or_zero());
    let given = at.vector("Normal");
    let zero = at.constant(0.0);
    let given = at.emit(Operation::VectorMath(VectorMathKind::Normalize), &[given, zero, zero, zero]);
    let dot = at.emit(Operation::VectorMath(VectorMathKind::Dot), &[own, given, zero, zero]);
    vec![vector("Normal", own), number("Dot", dot)]
}
