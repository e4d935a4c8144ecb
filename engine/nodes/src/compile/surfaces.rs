//! Nodes about the surface: Fresnel, bumps, normal maps, displacement, Light Falloff.

use super::{At, Lowered, ValueKind, number, vector};
use crate::context::{AttributeKind, Field, Shift, Space};
use crate::graph::Input;
use crate::math::MathKind;
use crate::program::Operation;
use crate::surface::NormalSpace;
use crate::vector::VectorMathKind;
use glam::Vec3A;

pub(super) fn lower(at: &mut At<'_, '_>) -> Option<Lowered> {
    Some(match at.node.kind.as_str() {
        "ShaderNodeFresnel" => {
            let operands = [at.number("IOR"), at.vector_or("Normal", At::normal)];
            Ok(vec![number("Fac", at.emit(Operation::Fresnel, &operands))])
        }
        "ShaderNodeLayerWeight" => {
            let operands = [at.number("Blend"), at.vector_or("Normal", At::normal)];
            Ok(vec![
                number("Fresnel", at.emit(Operation::LayerFresnel, &operands)),
                number("Facing", at.emit(Operation::Facing, &operands)),
            ])
        }
        "ShaderNodeLightFalloff" => {
            let operands = [at.number("Strength"), at.number("Smooth")];
            let outputs = [("Quadratic", 0), ("Linear", 1), ("Constant", 2)];
            Ok(outputs.map(|(name, power)| number(name, at.emit(Operation::Falloff(power), &operands))).into())
        }
        "ShaderNodeWireframe" => {
            let operands = [at.number("Size"), at.read(Field::EdgeDistance)];
            let in_pixels = at.node.truth("use_pixel_size", false);
            Ok(vec![number("Fac", at.emit(Operation::Wireframe(in_pixels), &operands))])
        }
        "ShaderNodeBump" => Ok(bump(at)),
        "ShaderNodeNormalMap" => normal_map(at),
        "ShaderNodeDisplacement" => at.node.choice("space", Space::Object).map(|space| {
            let operands =
                [at.number("Height"), at.number("Midlevel"), at.number("Scale"), at.vector_or("Normal", At::normal)];
            vec![vector("Displacement", at.emit(Operation::Displacement(space), &operands))]
        }),
        "ShaderNodeVectorDisplacement" => at.node.choice("space", NormalSpace::Tangent).map(|space| {
            let (tangent, sign) = at.attribute(AttributeKind::Tangent, "");
            let operands = [at.vector("Vector"), at.number("Midlevel"), at.number("Scale"), tangent, sign];
            vec![vector("Displacement", at.emit(Operation::VectorDisplacement(space), &operands))]
        }),
        _ => return None,
    })
}

fn bump(at: &mut At<'_, '_>) -> super::Outputs {
    let normal = at.vector_or("Normal", At::normal);
    // A height that stands still raises nothing.
    if !matches!(at.node.input("Height"), Some(Input::Link(_))) {
        return vec![vector("Normal", normal)];
    }
    let filter_width = at.number_or("Filter Width", 1.0);
    let width = match at.compiler.known(filter_width) {
        Some(width) => width.x,
        None => {
            at.report("a Filter Width that varies is not supported, it is 1");
            1.0
        }
    };
    let shifts = [Shift::NONE, Shift { x: width, y: 0.0 }, Shift { x: 0.0, y: width }];
    let heights = shifts.map(|shift| {
        let height = at.input("Height", ValueKind::Number, shift);
        height.unwrap_or_else(|| at.constant(0.0))
    });
    let zero = at.constant(0.0);
    let strength = at.number("Strength");
    let distance = at.number("Distance");
    let distance = if at.node.truth("invert", false) {
        at.emit(Operation::Math(MathKind::Subtract, false), &[zero, distance, zero])
    } else {
        distance
    };
    let operands = [heights[0], heights[1], heights[2], normal, strength, distance];
    vec![vector("Normal", at.emit(Operation::Bump(width), &operands))]
}

fn normal_map(at: &mut At<'_, '_>) -> Lowered {
    let space = at.node.choice("space", NormalSpace::Tangent)?;
    let (tangent, sign) = if space == NormalSpace::Tangent {
        at.attribute(AttributeKind::Tangent, at.node.word("uv_map").unwrap_or_default())
    } else {
        let zero = at.constant(0.0);
        (zero, zero)
    };
    let mut colour = at.vector("Color");
    if at.node.word("convention") == Some("DIRECTX") {
        // Green down instead of up.
        let turned = [Vec3A::new(1.0, -1.0, 1.0), Vec3A::Y, Vec3A::ZERO].map(|parts| at.compiler.constant(parts));
        let operation = Operation::VectorMath(VectorMathKind::MultiplyAdd);
        colour = at.emit(operation, &[colour, turned[0], turned[1], turned[2]]);
    }
    let operands = [colour, at.number("Strength"), tangent, sign];
    Ok(vec![vector("Normal", at.emit(Operation::NormalMap(space), &operands))])
}
