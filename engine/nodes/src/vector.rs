//! Vector Math, Mapping, Vector Rotate and the other turns of vectors.

use crate::choice::choices;
use crate::math::{safe_divide, safe_modulo, safe_power, sign, wrap};
use glam::{Affine3A, EulerRot, Mat3A, Quat, Vec3A};

choices! {
    pub(crate) VectorMathKind {
        Add = "ADD",
        Subtract = "SUBTRACT",
        Multiply = "MULTIPLY",
        Divide = "DIVIDE",
        MultiplyAdd = "MULTIPLY_ADD",
        Cross = "CROSS_PRODUCT",
        Project = "PROJECT",
        Reflect = "REFLECT",
        Refract = "REFRACT",
        FaceForward = "FACEFORWARD",
        Dot = "DOT_PRODUCT",
        Distance = "DISTANCE",
        Length = "LENGTH",
        Scale = "SCALE",
        Normalize = "NORMALIZE",
        Absolute = "ABSOLUTE",
        Power = "POWER",
        Sign = "SIGN",
        Minimum = "MINIMUM",
        Maximum = "MAXIMUM",
        Round = "ROUND",
        Floor = "FLOOR",
        Ceiling = "CEIL",
        Fraction = "FRACTION",
        Modulo = "MODULO",
        Wrap = "WRAP",
        Snap = "SNAP",
        Sine = "SINE",
        Cosine = "COSINE",
        Tangent = "TANGENT",
    }
}

choices! { pub(crate) MappingKind { Point = "POINT", Texture = "TEXTURE", Vector = "VECTOR", Normal = "NORMAL" } }
choices! {
    pub(crate) RotationKind { Axis = "AXIS_ANGLE", X = "X_AXIS", Y = "Y_AXIS", Z = "Z_AXIS", Euler = "EULER_XYZ" }
}

fn each2(a: Vec3A, b: Vec3A, function: impl Fn(f32, f32) -> f32) -> Vec3A {
    Vec3A::new(function(a.x, b.x), function(a.y, b.y), function(a.z, b.z))
}

pub(crate) fn each(a: Vec3A, function: impl Fn(f32) -> f32) -> Vec3A {
    Vec3A::new(function(a.x), function(a.y), function(a.z))
}

pub(crate) fn divide(a: Vec3A, b: Vec3A) -> Vec3A {
    each2(a, b, safe_divide)
}

impl VectorMathKind {
    /// True if the node's result is its Value, not its Vector.
    pub(crate) fn gives_value(self) -> bool {
        matches!(self, Self::Dot | Self::Distance | Self::Length)
    }

    /// The result; of a number, in every part.
    pub(crate) fn apply(self, a: Vec3A, b: Vec3A, c: Vec3A, scale: f32) -> Vec3A {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divide(a, b),
            Self::MultiplyAdd => a * b + c,
            Self::Cross => a.cross(b),
            Self::Project => {
                let square = b.length_squared();
                if square == 0.0 { Vec3A::ZERO } else { b * (a.dot(b) / square) }
            }
            Self::Reflect => {
                let axis = b.normalize_or_zero();
                a - axis * (2.0 * axis.dot(a))
            }
            Self::Refract => refract(a, b.normalize_or_zero(), scale),
            Self::FaceForward => {
                if c.dot(b) < 0.0 {
                    a
                } else {
                    -a
                }
            }
            Self::Dot => Vec3A::splat(a.dot(b)),
            Self::Distance => Vec3A::splat(a.distance(b)),
            Self::Length => Vec3A::splat(a.length()),
            Self::Scale => a * scale,
            Self::Normalize => a.normalize_or_zero(),
            Self::Absolute => a.abs(),
            Self::Power => each2(a, b, safe_power),
            Self::Sign => each(a, sign),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Round => each(a, |part| (part + 0.5).floor()),
            Self::Floor => a.floor(),
            Self::Ceiling => a.ceil(),
            Self::Fraction => a - a.floor(),
            Self::Modulo => each2(a, b, safe_modulo),
            Self::Wrap => Vec3A::new(wrap(a.x, b.x, c.x), wrap(a.y, b.y, c.y), wrap(a.z, b.z, c.z)),
            Self::Snap => divide(a, b).floor() * b,
            Self::Sine => each(a, f32::sin),
            Self::Cosine => each(a, f32::cos),
            Self::Tangent => each(a, f32::tan),
        }
    }
}

/// A direction bent at a surface; zero where all is reflected. `eta` is the index ratio, before over behind.
fn refract(incident: Vec3A, normal: Vec3A, eta: f32) -> Vec3A {
    let cosine = normal.dot(incident);
    let k = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if k < 0.0 { Vec3A::ZERO } else { incident * eta - normal * (eta * cosine + k.sqrt()) }
}

/// Blender's XYZ order: about x first.
pub(crate) fn euler_matrix(angles_rad: Vec3A) -> Mat3A {
    Mat3A::from_euler(EulerRot::ZYX, angles_rad.z, angles_rad.y, angles_rad.x)
}

pub(crate) fn mapping(kind: MappingKind, p: Vec3A, location: Vec3A, rotation_rad: Vec3A, scale: Vec3A) -> Vec3A {
    let turn = euler_matrix(rotation_rad);
    match kind {
        MappingKind::Point => turn * (p * scale) + location,
        MappingKind::Texture => divide(turn.transpose() * (p - location), scale),
        MappingKind::Vector => turn * (p * scale),
        MappingKind::Normal => (turn * divide(p, scale)).normalize_or_zero(),
    }
}

/// The matrix of [`mapping`], for all kinds but normals.
pub(crate) fn affine_mapping(kind: MappingKind, location: Vec3A, rotation_rad: Vec3A, scale: Vec3A) -> Affine3A {
    let turn = euler_matrix(rotation_rad);
    match kind {
        MappingKind::Texture => {
            let matrix3 = Mat3A::from_diagonal(divide(Vec3A::ONE, scale).into()) * turn.transpose();
            Affine3A { matrix3, translation: -(matrix3 * location) }
        }
        _ => {
            let translation = if kind == MappingKind::Point { location } else { Vec3A::ZERO };
            Affine3A { matrix3: turn * Mat3A::from_diagonal(scale.into()), translation }
        }
    }
}

pub(crate) fn rotate(
    kind: RotationKind,
    inverted: bool,
    p: Vec3A,
    center: Vec3A,
    axis: Vec3A,
    angle_rad: f32,
    euler_rad: Vec3A,
) -> Vec3A {
    let axis = match kind {
        RotationKind::Euler => {
            let turn = euler_matrix(euler_rad);
            return if inverted { turn.transpose() } else { turn } * (p - center) + center;
        }
        RotationKind::Axis => axis.normalize_or_zero(),
        RotationKind::X => Vec3A::X,
        RotationKind::Y => Vec3A::Y,
        RotationKind::Z => Vec3A::Z,
    };
    if axis == Vec3A::ZERO {
        return p;
    }
    let angle_rad = if inverted { -angle_rad } else { angle_rad };
    Quat::from_axis_angle(axis.into(), angle_rad) * (p - center) + center
}
