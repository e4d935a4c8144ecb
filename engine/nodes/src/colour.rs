//! Colour models and the nodes that change one colour.

use crate::choice::choices;
use crate::lanes::{Number, Vector, most};
use crate::vector::each;
use glam::Vec3A;

choices! {
    /// The meaning of a colour's three numbers.
    pub(crate) ColourModel { Rgb = "RGB", Hsv = "HSV", Hsl = "HSL" }
}

/// Weights of luminance in Rec. 709.
const LUMINANCE: [f32; 3] = [0.212_639, 0.715_168_7, 0.072_192_3];

#[inline(always)]
pub(crate) fn luminance<V: Vector>(colour: V) -> V::Number {
    colour.inner(V::of(LUMINANCE.map(V::Number::of)))
}

/// The hue from 0 to 1, of a colour that is not grey.
fn hue(rgb: Vec3A, most: f32, range: f32) -> f32 {
    let away = (Vec3A::splat(most) - rgb) / range;
    let sixth = if rgb.x == most {
        away.z - away.y
    } else if rgb.y == most {
        2.0 + away.x - away.z
    } else {
        4.0 + away.y - away.x
    };
    let hue = sixth / 6.0;
    if hue < 0.0 { hue + 1.0 } else { hue }
}

pub(crate) fn rgb_to_hsv(rgb: Vec3A) -> Vec3A {
    let (most, least) = (rgb.max_element(), rgb.min_element());
    let range = most - least;
    let saturation = if most == 0.0 { 0.0 } else { range / most };
    let hue = if saturation == 0.0 { 0.0 } else { hue(rgb, most, range) };
    Vec3A::new(hue, saturation, most)
}

pub(crate) fn hsv_to_rgb(hsv: Vec3A) -> Vec3A {
    let [hue, saturation, value] = hsv.to_array();
    if saturation == 0.0 {
        return Vec3A::splat(value);
    }
    let sixth = if hue == 1.0 { 0.0 } else { hue * 6.0 };
    let sector = sixth.floor();
    let part = sixth - sector;
    let low = value * (1.0 - saturation);
    let falling = value * (1.0 - saturation * part);
    let rising = value * (1.0 - saturation * (1.0 - part));
    match sector as i32 {
        0 => Vec3A::new(value, rising, low),
        1 => Vec3A::new(falling, value, low),
        2 => Vec3A::new(low, value, rising),
        3 => Vec3A::new(low, falling, value),
        4 => Vec3A::new(rising, low, value),
        _ => Vec3A::new(value, low, falling),
    }
}

pub(crate) fn rgb_to_hsl(rgb: Vec3A) -> Vec3A {
    let (most, least) = (rgb.max_element(), rgb.min_element());
    let lightness = ((most + least) / 2.0).min(1.0);
    let range = most - least;
    if range == 0.0 {
        return Vec3A::new(0.0, 0.0, lightness);
    }
    let saturation = if lightness > 0.5 { range / (2.0 - most - least) } else { range / (most + least) };
    Vec3A::new(hue(rgb, most, range), saturation, lightness)
}

pub(crate) fn hsl_to_rgb(hsl: Vec3A) -> Vec3A {
    let [hue, saturation, lightness] = hsl.to_array();
    let pure = Vec3A::new((hue * 6.0 - 3.0).abs() - 1.0, 2.0 - (hue * 6.0 - 2.0).abs(), 2.0 - (hue * 6.0 - 4.0).abs());
    let chroma = (1.0 - (2.0 * lightness - 1.0).abs()) * saturation;
    (pure.saturated() - 0.5) * chroma + lightness
}

/// A model's numbers to RGB.
pub(crate) fn from_model(model: ColourModel, parts: Vec3A) -> Vec3A {
    match model {
        ColourModel::Rgb => parts,
        ColourModel::Hsv => hsv_to_rgb(parts),
        ColourModel::Hsl => hsl_to_rgb(parts),
    }
}

/// RGB to a model's numbers.
pub(crate) fn to_model(model: ColourModel, rgb: Vec3A) -> Vec3A {
    match model {
        ColourModel::Rgb => rgb,
        ColourModel::Hsv => rgb_to_hsv(rgb),
        ColourModel::Hsl => rgb_to_hsl(rgb),
    }
}

pub(crate) fn hue_saturation(colour: Vec3A, hue: f32, saturation: f32, value: f32, factor: f32) -> Vec3A {
    let mut hsv = rgb_to_hsv(colour);
    hsv.x = (hsv.x + hue + 0.5).fract();
    if hsv.x < 0.0 {
        hsv.x += 1.0;
    }
    hsv.y = (hsv.y * saturation).clamp(0.0, 1.0);
    hsv.z *= value;
    most(hsv_to_rgb(hsv) * factor + colour * (1.0 - factor), Vec3A::ZERO)
}

pub(crate) fn bright_contrast(colour: Vec3A, bright: f32, contrast: f32) -> Vec3A {
    most(colour * (1.0 + contrast) + (bright - contrast * 0.5), Vec3A::ZERO)
}

pub(crate) fn gamma(colour: Vec3A, gamma: f32) -> Vec3A {
    if gamma == 0.0 {
        return Vec3A::ONE;
    }
    each(colour, |part| if part > 0.0 { part.powf(gamma) } else { part })
}

#[inline(always)]
pub(crate) fn invert<V: Vector>(colour: V, factor: V::Number) -> V {
    let one = V::Number::of(1.0);
    (V::splat(one) - colour).times(factor) + colour.times(one - factor)
}
