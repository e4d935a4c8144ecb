//! Checks of questions in JSON: the keys that they may have, and directions of any length.

use glam::DVec3;
use serde_json::Value;

/// The complaint about a key of an object that is none of `keys`, which the command reads, nor of `notes`, which it passes over; `None` if
/// there is no such key.
pub(crate) fn unknown_key(value: &Value, keys: &[&str], notes: &[&str]) -> Option<String> {
    let known = |key: &&String| keys.iter().chain(notes).any(|known| known == key);
    let unknown = value.as_object()?.keys().find(|key| !known(key))?;
    let shown: String = unknown.chars().take(200).collect();
    Some(format!("{shown:?} is no key here; the keys are {}", keys.join(", ")))
}

/// A direction times a power of two that brings its largest component to between 1/2 and 1, so that its square fits: no bit of a component
/// changes but where it is lost beside the largest. `None` of a direction of no length, and of one that is not finite.
pub(crate) fn scaled(direction: DVec3) -> Option<DVec3> {
    let largest = direction.abs().max_element();
    if !(largest > 0.0 && direction.is_finite()) {
        return None;
    }
    // In two steps: the inverse of the smallest numbers is too large for one.
    let (_, exponent) = libm::frexp(largest);
    let half = exponent / 2;
    let factors = [half, exponent - half].map(|by| libm::ldexp(1.0, -by));
    Some(direction * factors[0] * factors[1])
}
