// SPDX-License-Identifier: GPL-3.0-or-later
//! The exact lens on a graphics processor: rays traced surface by surface in compute shaders, by the formulas of `petzval_optics`.
//!
//! Lengths are in millimetres, wavelengths in nanometres, directions unit vectors, in the lens space of `petzval_optics`.
//!
//! A [`device::Gpu`] is a device that has been opened; a [`lens::LensTable`] is a lens for one way of travel, laid out for the
//! device; a [`kernel::LensKernel`] is both together, and traces batches of rays in [`number::Number`]s of one kind. The shader
//! ([`shader`]) serves any lens, or is written for one with its numbers in it. Nothing panics: every fault is an
//! [`error::GpuError`], of one line with the remedy.
//!
//! A module uses only those that stand before it here: [`error`] → [`number`] → [`device`] → [`lens`] → [`shader`] → [`kernel`] →
//! [`flood`].

pub mod device;
pub mod error;
pub mod flood;
pub mod kernel;
pub mod lens;
pub mod number;
pub mod shader;
