// SPDX-License-Identifier: GPL-3.0-or-later
//! Tests of the lens on a device. Where there is no Vulkan driver, those that need a device say so and pass.

mod against_cpu;
mod common;
mod compare;
mod devices;
mod shaders;
