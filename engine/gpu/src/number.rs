// SPDX-License-Identifier: GPL-3.0-or-later
//! Kinds of numbers that shaders compute in.

use petzval_optics::lane::Real;

/// A kind of number on the device: `f32`, or `f64` where the device has it.
pub trait Number: Real + bytemuck::Pod {
    /// Name of the number type in shaders and messages.
    const NAME: &'static str;
    /// The shader's first part: the definition of `real`.
    const WGSL: &'static str;
    /// Features that a device must have.
    const FEATURES: wgpu::Features;
}

impl Number for f32 {
    const NAME: &'static str = "f32";
    const WGSL: &'static str = include_str!("shaders/real32.wgsl");
    const FEATURES: wgpu::Features = wgpu::Features::empty();
}

impl Number for f64 {
    const NAME: &'static str = "f64";
    const WGSL: &'static str = include_str!("shaders/real64.wgsl");
    const FEATURES: wgpu::Features = wgpu::Features::SHADER_F64;
}
