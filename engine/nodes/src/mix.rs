//! Mix: one value over another, in nineteen ways.

use crate::choice::choices;
use crate::colour::{hsv_to_rgb, rgb_to_hsv};
use crate::lanes::{Number, Vector, least, most};
use glam::Vec3A;

choices! {
    pub(crate) Blend {
        Mix = "MIX",
        Darken = "DARKEN",
        Multiply = "MULTIPLY",
        Burn = "BURN",
        Lighten = "LIGHTEN",
        Screen = "SCREEN",
        Dodge = "DODGE",
        Add = "ADD",
        Overlay = "OVERLAY",
        SoftLight = "SOFT_LIGHT",
        LinearLight = "LINEAR_LIGHT",
        Difference = "DIFFERENCE",
        Exclusion = "EXCLUSION",
        Subtract = "SUBTRACT",
        Divide = "DIVIDE",
        Hue = "HUE",
        Saturation = "SATURATION",
        Colour = "COLOR",
        Value = "VALUE",
    }
}

fn each2(a: Vec3A, b: Vec3A, function: impl Fn(f32, f32) -> f32) -> Vec3A {
    Vec3A::new(function(a.x, b.x), function(a.y, b.y), function(a.z, b.z))
}

/// `t` of the second over `1 - t` of the first, for each part its own share.
#[inline(always)]
pub(crate) fn interpolate<V: Vector>(a: V, b: V, t: V) -> V {
    a * (V::splat(V::Number::of(1.0)) - t) + b * t
}

impl Blend {
    /// True of blends whose result at a share of 0 is the first value, but for rounding; the others bring it into range or convert it.
    pub(crate) fn is_first_at_0(self) -> bool {
        !matches!(self, Self::Exclusion | Self::Dodge | Self::Burn | Self::Saturation | Self::Value)
    }

    /// The result of a blend that adds, subtracts and multiplies alone; of the others `None`.
    #[inline(always)]
    pub(crate) fn sums<V: Vector>(self, t: V::Number, a: V, b: V) -> Option<V> {
        let one = V::splat(V::Number::of(1.0));
        let rest = V::Number::of(1.0) - t;
        let over = |result: V| a.times(rest) + result.times(t);
        Some(match self {
            Self::Mix => over(b),
            Self::Multiply => over(a * b),
            Self::Add => over(a + b),
            Self::Subtract => over(a - b),
            Self::Screen => one - (V::splat(rest) + (one - b).times(t)) * (one - a),
            Self::LinearLight => a + (b.times(V::Number::of(2.0)) - one).times(t),
            Self::SoftLight => {
                let screen = one - (one - b) * (one - a);
                over((one - a) * b * a + a * screen)
            }
            _ => return None,
        })
    }

    pub(crate) fn apply(self, t: f32, a: Vec3A, b: Vec3A) -> Vec3A {
        if let Some(sum) = self.sums(t, a, b) {
            return sum;
        }
        let rest = 1.0 - t;
        let over = |result: Vec3A| a * rest + result * t;
        match self {
            Self::Darken => over(least(a, b)),
            Self::Lighten => over(most(a, b)),
            Self::Difference => over((a - b).abs()),
            Self::Exclusion => most(over(a + b - a * b * 2.0), Vec3A::ZERO),
            Self::Overlay => each2(a, b, |a, b| {
                if a < 0.5 { a * (rest + 2.0 * t * b) } else { 1.0 - (rest + 2.0 * t * (1.0 - b)) * (1.0 - a) }
            }),
            Self::Divide => each2(a, b, |a, b| if b == 0.0 { a } else { rest * a + t * a / b }),
            Self::Dodge => each2(a, b, |a, b| {
                let divisor = 1.0 - t * b;
                if a == 0.0 {
                    0.0
                } else if divisor <= 0.0 {
                    1.0
                } else {
                    (a / divisor).min(1.0)
                }
            }),
            Self::Burn => each2(a, b, |a, b| {
                let divisor = rest + t * b;
                if divisor <= 0.0 { 0.0 } else { (1.0 - (1.0 - a) / divisor).clamp(0.0, 1.0) }
            }),
            _ => self.in_hsv(t, a, b),
        }
    }

    /// The four that exchange parts of hue, saturation and value. Grey has no hue to give or take.
    fn in_hsv(self, t: f32, a: Vec3A, b: Vec3A) -> Vec3A {
        let (mut first, second) = (rgb_to_hsv(a), rgb_to_hsv(b));
        let blended = |x: f32, y: f32| (1.0 - t) * x + t * y;
        match self {
            Self::Saturation if first.y != 0.0 => {
                first.y = blended(first.y, second.y);
                hsv_to_rgb(first)
            }
            Self::Value => {
                first.z = blended(first.z, second.z);
                hsv_to_rgb(first)
            }
            Self::Hue | Self::Colour if second.y != 0.0 => {
                first.x = second.x;
                if self == Self::Colour {
                    first.y = second.y;
                }
                a * (1.0 - t) + hsv_to_rgb(first) * t
            }
            _ => a,
        }
    }
}
