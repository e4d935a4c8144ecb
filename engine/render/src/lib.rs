//! Light transport through a scene into a camera: from a described scene to finished pixels.
//!
//! Data goes one way, and a module uses only those above it in this list:
//! [`spectrum`] → [`sensor`] → [`sampler`] → [`projection`] → [`scene`] → [`accel`] → [`surface`] → [`nodes`] → [`shading`] → [`lights`] → [`camera`] →
//! [`reports`] → [`integrator`] → [`film`] → [`pipeline`] → [`stray`] → [`plan`] → [`job`].
//!
//! # Spaces and units
//! *World space* is Blender's, in Blender units. *Render space* has the world's axes and its origin at the
//! camera, so that single precision is fine near the camera however far it stands from the world's origin;
//! everything that a [`scene::Scene`] holds is in render space. *Lens space* (millimetres) belongs to
//! `petzval_optics`; [`camera`] alone converts between the two.
//!
//! Radiance and colour are scene-linear Rec.709 triples, [`Rgb`].

pub mod accel;
pub mod camera;
pub mod film;
pub mod integrator;
pub mod job;
pub mod lights;
pub mod nodes;
pub mod pipeline;
pub mod plan;
pub mod projection;
pub mod reports;
pub mod sampler;
pub mod scene;
pub mod sensor;
pub mod shading;
pub mod spectrum;
pub mod stray;
pub mod surface;

/// A scene-linear Rec.709 colour: radiance, reflectance or a weight by channel.
pub type Rgb = glam::Vec3;

/// Rec.709 relative luminance of a scene-linear colour.
#[inline]
pub fn luminance(c: Rgb) -> f32 {
    0.212_671 * c.x + 0.715_160 * c.y + 0.072_169 * c.z
}

/// Mean of a colour's channels: the weight of a closure where one of several is chosen, as in Cycles. Noise is judged by channel, and
/// luminance would seldom choose the only closure that gives red or blue.
#[inline]
pub fn average(c: Rgb) -> f32 {
    c.element_sum() / 3.0
}
