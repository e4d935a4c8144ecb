//! One surface and one ray in 320-bit numbers: the truth that a tracer in machine numbers is held against.
//!
//! A [`Case`] is plain `f64` data and exact as it stands; [`trace()`] gives the fate of the ray; [`Sensitivity`] says
//! how much of an error the data themselves allow, and [`Margins`] how near the outcome was to being another one. The
//! frame is that of the surface: the origin at its vertex, z along its axis, mm.
//!
//! The crossing that is meant is the one with sign(N · D) = side, N towards +z at the vertex, on the vertex sheet. A conic has one at most.
//! If an asphere or a toroid has several, it is the one nearest to the ray's hit on the base conic, in the direction in which a
//! crossing of that sign must lie: ahead if that place is still before the surface, else behind. The base of a toroid is a sphere of its
//! mean curvature. A ray that does not hit the base starts at its point nearest the vertex. Rays with several such crossings are none to
//! test with; [`crate::hard_rays`] avoids them.

mod big;
mod case;
mod inputs;
mod local;
mod margins;
mod search;
mod sensitivity;
mod trace;
mod ulp;

#[cfg(test)]
mod tests;

pub use big::{Big, PRECISION_BITS, Vector, dot, norm, to_f64};
pub use case::{Case, Profile, Shape};
pub use margins::Margins;
pub use sensitivity::{Sensitivity, sensitivity};
pub use trace::{Hit, Status, Truth, trace, trace_from};
pub use ulp::{
    Precision, error_norm, ulp_error_f32, ulp_error_f64, ulp_error_vector_f32, ulp_error_vector_f64, ulp_of,
};

pub(crate) use local::{ProfileAt, profile_at};
