//! The texts of decisions.

use super::unit::Unit;
use crate::camera::tools::survey::Worst;
use glam::Vec2;

/// A size with its unit, short.
pub(super) fn size(value: f64, unit: Unit) -> String {
    let number = match value {
        v if v.is_infinite() => return "without bound".into(),
        v if v >= 100.0 => format!("{v:.0}"),
        v if v >= 10.0 => format!("{v:.1}"),
        v if v >= 0.1 => format!("{v:.2}"),
        v if v >= 0.001 => format!("{v:.3}"),
        0.0 => "0".into(),
        v => format!("{v:.0e}"),
    };
    format!("{number} {}", unit.name())
}

/// The text of a place in the picture.
pub(super) fn place(at: Vec2) -> &'static str {
    const THIRD: f32 = 1.0 / 3.0;
    let side = |x: f32| x.abs() > THIRD;
    match (side(at.x), side(at.y)) {
        (true, true) => "in a corner",
        (true, false) => "at a side",
        (false, true) => "at the top or bottom",
        (false, false) => "in the middle",
    }
}

/// "3.2 px in a corner".
pub(super) fn worst(worst: Worst, unit: Unit) -> String {
    match worst.value {
        0.0 => format!("0 {}", unit.name()),
        value => format!("{} {}", size(value, unit), place(worst.place)),
    }
}
