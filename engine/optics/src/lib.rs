//! Exact and paraxial optics of real lenses.

// A comparison that NaN fails, written `!(x >= 0.0)`, is how a number that is none ends as a named reason.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod diaphragm;
pub mod first_order;
pub mod focus;
pub mod formats;
pub mod glass;
pub mod interface;
pub mod paraxial;
pub mod prescription;
pub mod pupil_map;
pub mod surface;
pub mod system;
pub mod trace;
