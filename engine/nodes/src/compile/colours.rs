//! Colour nodes, ramps and curves.

use super::{At, Lowered, colour, number, vector};
use crate::colour::ColourModel;
use crate::mix::Blend;
use crate::program::{Operand, Operation};
use crate::table::Table;
use glam::Vec4;

#[expect(clippy::too_many_lines, reason = "an arm for each node")]
pub(super) fn lower(at: &mut At<'_, '_>) -> Option<Lowered> {
    Some(match at.node.kind.as_str() {
        "ShaderNodeMix" => mix(at),
        "ShaderNodeMixRGB" => mix_rgb(at),
        "ShaderNodeValToRGB" => ramp(at),
        "ShaderNodeRGBCurve" => curves(at, "Color"),
        "ShaderNodeVectorCurve" => curves(at, "Vector"),
        "ShaderNodeFloatCurve" => float_curve(at),
        "ShaderNodeHueSaturation" => {
            let operands =
                [at.number("Hue"), at.number("Saturation"), at.number("Value"), at.number("Fac"), at.vector("Color")];
            Ok(vec![colour("Color", at.emit(Operation::HueSaturation, &operands))])
        }
        "ShaderNodeBrightContrast" => {
            let operands = [at.vector("Color"), at.number("Bright"), at.number("Contrast")];
            Ok(vec![colour("Color", at.emit(Operation::BrightContrast, &operands))])
        }
        "ShaderNodeGamma" => {
            let operands = [at.vector("Color"), at.number("Gamma")];
            Ok(vec![colour("Color", at.emit(Operation::Gamma, &operands))])
        }
        "ShaderNodeInvert" => {
            let operands = [at.vector("Color"), at.number("Fac")];
            Ok(vec![colour("Color", at.emit(Operation::Invert, &operands))])
        }
        "ShaderNodeRGBToBW" => {
            let rgb = at.vector("Color");
            Ok(vec![number("Val", at.emit(Operation::Luminance, &[rgb]))])
        }
        "ShaderNodeSeparateColor" => at.node.choice("mode", ColourModel::Rgb).map(|model| {
            let rgb = at.vector("Color");
            let parts = if model == ColourModel::Rgb { rgb } else { at.emit(Operation::ToModel(model), &[rgb]) };
            split(at, parts, ["Red", "Green", "Blue"])
        }),
        "ShaderNodeCombineColor" => at.node.choice("mode", ColourModel::Rgb).map(|model| {
            let parts = join(at, ["Red", "Green", "Blue"]);
            let rgb = if model == ColourModel::Rgb { parts } else { at.emit(Operation::FromModel(model), &[parts]) };
            vec![colour("Color", rgb)]
        }),
        // Blender before 3.3 had a node for each model.
        "ShaderNodeSeparateRGB" => {
            let rgb = at.vector("Image");
            Ok(split(at, rgb, ["R", "G", "B"]))
        }
        "ShaderNodeSeparateHSV" => {
            let rgb = at.vector("Color");
            let parts = at.emit(Operation::ToModel(ColourModel::Hsv), &[rgb]);
            Ok(split(at, parts, ["H", "S", "V"]))
        }
        "ShaderNodeCombineRGB" => Ok(vec![colour("Image", join(at, ["R", "G", "B"]))]),
        "ShaderNodeCombineHSV" => {
            let parts = join(at, ["H", "S", "V"]);
            Ok(vec![colour("Color", at.emit(Operation::FromModel(ColourModel::Hsv), &[parts]))])
        }
        "ShaderNodeSeparateXYZ" => {
            let whole = at.vector("Vector");
            Ok(split(at, whole, ["X", "Y", "Z"]))
        }
        "ShaderNodeCombineXYZ" => Ok(vec![vector("Vector", join(at, ["X", "Y", "Z"]))]),
        "ShaderNodeBlackbody" => {
            let kelvin = at.number("Temperature");
            Ok(vec![colour("Color", at.emit(Operation::Blackbody, &[kelvin]))])
        }
        "ShaderNodeWavelength" => {
            let nm = at.number("Wavelength");
            Ok(vec![colour("Color", at.emit(Operation::Wavelength, &[nm]))])
        }
        _ => return None,
    })
}

fn split(at: &mut At<'_, '_>, whole: Operand, names: [&'static str; 3]) -> super::Outputs {
    let mut part = 0;
    names
        .map(|name| {
            part += 1;
            number(name, at.emit(Operation::Part(part - 1), &[whole]))
        })
        .into()
}

fn join(at: &mut At<'_, '_>, names: [&str; 3]) -> Operand {
    let parts = names.map(|name| at.number(name));
    at.emit(Operation::Combine, &parts)
}

fn mix(at: &mut At<'_, '_>) -> Lowered {
    let data = at.node.word("data_type").unwrap_or("FLOAT");
    let by_parts = data == "VECTOR" && at.node.word("factor_mode") == Some("NON_UNIFORM");
    let factor = if by_parts { at.vector("Factor_Vector") } else { at.number("Factor_Float") };
    let factor = if at.node.truth("clamp_factor", true) { at.emit(Operation::Saturate, &[factor]) } else { factor };
    let plain = Operation::Mix(Blend::Mix);
    Ok(match data {
        "FLOAT" => {
            let operands = [factor, at.number("A_Float"), at.number("B_Float")];
            vec![number("Result_Float", at.emit(plain, &operands))]
        }
        "VECTOR" => {
            let operands = [factor, at.vector("A_Vector"), at.vector("B_Vector")];
            vec![vector("Result_Vector", at.emit(if by_parts { Operation::MixParts } else { plain }, &operands))]
        }
        "RGBA" => {
            let blend = at.node.choice("blend_type", Blend::Mix)?;
            let operands = [factor, at.vector("A_Color"), at.vector("B_Color")];
            let mixed = at.emit(Operation::Mix(blend), &operands);
            let clamped = at.node.truth("clamp_result", false);
            vec![colour("Result_Color", if clamped { at.emit(Operation::Saturate, &[mixed]) } else { mixed })]
        }
        _ => return Err(format!("data_type {data} is not supported, it is black")),
    })
}

fn mix_rgb(at: &mut At<'_, '_>) -> Lowered {
    let blend = at.node.choice("blend_type", Blend::Mix)?;
    let factor = at.number("Fac");
    let operands = [at.emit(Operation::Saturate, &[factor]), at.vector("Color1"), at.vector("Color2")];
    let mixed = at.emit(Operation::Mix(blend), &operands);
    let clamped = at.node.truth("use_clamp", false);
    Ok(vec![colour("Color", if clamped { at.emit(Operation::Saturate, &[mixed]) } else { mixed })])
}

/// The node's rows of four numbers as a table; its place in the program.
fn table(at: &mut At<'_, '_>, interpolate: bool, extrapolate: bool) -> Result<u16, String> {
    let numbers = at.node.numbers("table").unwrap_or_default();
    let rows: Vec<Vec4> = numbers.chunks_exact(4).map(Vec4::from_slice).collect();
    if rows.is_empty() {
        return Err("it came without its table, it is black".to_owned());
    }
    let range = match at.node.numbers("range").as_deref() {
        Some([low, high]) if low < high => [*low, *high],
        _ => [0.0, 1.0],
    };
    let table = Table { rows, interpolate, range, extrapolate };
    let tables = &mut at.compiler.program.tables;
    let place = tables.iter().position(|other| *other == table).unwrap_or_else(|| {
        tables.push(table);
        tables.len() - 1
    });
    Ok(place as u16)
}

fn ramp(at: &mut At<'_, '_>) -> Lowered {
    let interpolate = at.node.truth("interpolate", true);
    let table = table(at, interpolate, false)?;
    let place = at.number("Fac");
    let (rgb, [alpha]) = at.emit_many(Operation::Ramp(table), &[place]);
    Ok(vec![colour("Color", rgb), number("Alpha", alpha)])
}

fn curves(at: &mut At<'_, '_>, socket: &'static str) -> Lowered {
    let extrapolate = at.node.truth("extrapolate", true);
    let table = table(at, true, extrapolate)?;
    let operands = [at.number("Fac"), at.vector(socket)];
    let curved = at.emit(Operation::Curves(table), &operands);
    Ok(vec![if socket == "Color" { colour(socket, curved) } else { vector(socket, curved) }])
}

fn float_curve(at: &mut At<'_, '_>) -> Lowered {
    let extrapolate = at.node.truth("extrapolate", true);
    let table = table(at, true, extrapolate)?;
    let operands = [at.number("Factor"), at.number("Value")];
    Ok(vec![number("Value", at.emit(Operation::FloatCurve(table), &operands))])
}
