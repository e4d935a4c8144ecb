//! Math, Clamp and the float Map Range.

use crate::choice::choices;

choices! {
    pub(crate) MathKind {
        Add = "ADD",
        Subtract = "SUBTRACT",
        Multiply = "MULTIPLY",
        Divide = "DIVIDE",
        MultiplyAdd = "MULTIPLY_ADD",
        Power = "POWER",
        Logarithm = "LOGARITHM",
        SquareRoot = "SQRT",
        InverseSquareRoot = "INVERSE_SQRT",
        Absolute = "ABSOLUTE",
        Exponent = "EXPONENT",
        Minimum = "MINIMUM",
        Maximum = "MAXIMUM",
        LessThan = "LESS_THAN",
        GreaterThan = "GREATER_THAN",
        Sign = "SIGN",
        Compare = "COMPARE",
        SmoothMinimum = "SMOOTH_MIN",
        SmoothMaximum = "SMOOTH_MAX",
        Round = "ROUND",
        Floor = "FLOOR",
        Ceiling = "CEIL",
        Truncate = "TRUNC",
        Fraction = "FRACT",
        Modulo = "MODULO",
        FlooredModulo = "FLOORED_MODULO",
        Wrap = "WRAP",
        Snap = "SNAP",
        PingPong = "PINGPONG",
        Sine = "SINE",
        Cosine = "COSINE",
        Tangent = "TANGENT",
        Arcsine = "ARCSINE",
        Arccosine = "ARCCOSINE",
        Arctangent = "ARCTANGENT",
        Arctangent2 = "ARCTAN2",
        HyperbolicSine = "SINH",
        HyperbolicCosine = "COSH",
        HyperbolicTangent = "TANH",
        Radians = "RADIANS",
        Degrees = "DEGREES",
    }
}

choices! {
    pub(crate) RangeKind {
        Linear = "LINEAR",
        Stepped = "STEPPED",
        Smooth = "SMOOTHSTEP",
        Smoother = "SMOOTHERSTEP",
    }
}

/// Zero where the divisor is.
#[inline]
pub(crate) fn safe_divide(a: f32, b: f32) -> f32 {
    if b == 0.0 { 0.0 } else { a / b }
}

/// Negative bases to whole powers only; else zero.
pub(crate) fn safe_power(base: f32, exponent: f32) -> f32 {
    if base < 0.0 && exponent != exponent.trunc() { 0.0 } else { base.powf(exponent) }
}

pub(crate) fn safe_modulo(a: f32, b: f32) -> f32 {
    if b == 0.0 { 0.0 } else { a % b }
}

fn floored_modulo(a: f32, b: f32) -> f32 {
    if b == 0.0 { 0.0 } else { a - (a / b).floor() * b }
}

pub(crate) fn wrap(value: f32, most: f32, least: f32) -> f32 {
    let range = most - least;
    if range == 0.0 { least } else { value - range * ((value - least) / range).floor() }
}

/// 1 or -1, or 0 for zero.
pub(crate) fn sign(value: f32) -> f32 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

fn smooth_minimum(a: f32, b: f32, distance: f32) -> f32 {
    if distance == 0.0 {
        return a.min(b);
    }
    let h = (distance - (a - b).abs()).max(0.0) / distance;
    a.min(b) - h * h * h * distance * (1.0 / 6.0)
}

fn ping_pong(value: f32, scale: f32) -> f32 {
    if scale == 0.0 {
        return 0.0;
    }
    let part = (value - scale) / (2.0 * scale);
    ((part - part.floor()) * scale * 2.0 - scale).abs()
}

impl MathKind {
    #[inline(always)]
    pub(crate) fn apply(self, a: f32, b: f32, c: f32) -> f32 {
        let truth = |is: bool| if is { 1.0 } else { 0.0 };
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => safe_divide(a, b),
            Self::MultiplyAdd => a * b + c,
            Self::Power => safe_power(a, b),
            Self::Logarithm if a <= 0.0 || b <= 0.0 => 0.0,
            Self::Logarithm => safe_divide(a.ln(), b.ln()),
            Self::SquareRoot => a.max(0.0).sqrt(),
            Self::InverseSquareRoot if a > 0.0 => 1.0 / a.sqrt(),
            Self::InverseSquareRoot => 0.0,
            Self::Absolute => a.abs(),
            Self::Exponent => a.exp(),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::LessThan => truth(a < b),
            Self::GreaterThan => truth(a > b),
            Self::Sign => sign(a),
            Self::Compare => truth(a == b || (a - b).abs() <= c.max(f32::EPSILON)),
            Self::SmoothMinimum => smooth_minimum(a, b, c),
            Self::SmoothMaximum => -smooth_minimum(-a, -b, c),
            Self::Round => (a + 0.5).floor(),
            Self::Floor => a.floor(),
            Self::Ceiling => a.ceil(),
            Self::Truncate => a.trunc(),
            Self::Fraction => a - a.floor(),
            Self::Modulo => safe_modulo(a, b),
            Self::FlooredModulo => floored_modulo(a, b),
            Self::Wrap => wrap(a, b, c),
            Self::Snap => safe_divide(a, b).floor() * b,
            Self::PingPong => ping_pong(a, b),
            Self::Sine => a.sin(),
            Self::Cosine => a.cos(),
            Self::Tangent => a.tan(),
            Self::Arcsine => a.clamp(-1.0, 1.0).asin(),
            Self::Arccosine => a.clamp(-1.0, 1.0).acos(),
            Self::Arctangent => a.atan(),
            Self::Arctangent2 => a.atan2(b),
            Self::HyperbolicSine => a.sinh(),
            Self::HyperbolicCosine => a.cosh(),
            Self::HyperbolicTangent => a.tanh(),
            Self::Radians => a.to_radians(),
            Self::Degrees => a.to_degrees(),
        }
    }
}

fn smooth(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}

fn smoother(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// A value from one range into another. A range without width gives `none`.
#[inline(always)]
pub(crate) fn map_range(kind: RangeKind, value: f32, from: [f32; 2], to: [f32; 2], steps: f32, none: f32) -> f32 {
    let width = from[1] - from[0];
    if width == 0.0 {
        return none;
    }
    let share = (value - from[0]) / width;
    let share = match kind {
        RangeKind::Linear => share,
        RangeKind::Stepped if steps > 0.0 => (share * (steps + 1.0)).floor() / steps,
        RangeKind::Stepped => 0.0,
        RangeKind::Smooth => smooth(share.clamp(0.0, 1.0)),
        RangeKind::Smoother => smoother(share.clamp(0.0, 1.0)),
    };
    to[0] + share * (to[1] - to[0])
}

/// Returns `value` clamped between two bounds, given in either order.
#[inline(always)]
pub(crate) fn clamp_between(value: f32, a: f32, b: f32) -> f32 {
    if a > b { value.max(b).min(a) } else { value.max(a).min(b) }
}

/// Returns `value` clamped between two bounds: never below the first unless the second is.
#[inline(always)]
pub(crate) fn clamp_in_order(value: f32, least: f32, most: f32) -> f32 {
    value.max(least).min(most)
}
