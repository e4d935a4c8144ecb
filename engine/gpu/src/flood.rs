// SPDX-License-Identifier: GPL-3.0-or-later
//! Rays without end, made and summed up on the device, for the number a second that goes through a lens.

use std::marker::PhantomData;
use std::time::Instant;

use glam::{DVec3, Vec3};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::System;
use petzval_optics::trace::{Ray, Tracer, Travel};

use crate::device::Gpu;
use crate::error::GpuError;
use crate::kernel::{Job, Loaded};
use crate::lens::LensTable;
use crate::number::Number;
use crate::shader::{self, Style};

/// Rays from a rectangle of film to a square in the exit pupil, each made of its number alone, alike on every device but for
/// roundings. Lengths in mm, z from the last vertex of the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Half of the film's width and of its height.
    pub half_film_mm: [f32; 2],
    /// z of the film.
    pub film_z_mm: f32,
    /// z of the exit pupil.
    pub pupil_z_mm: f32,
    /// Half of the side of the square.
    pub half_pupil_mm: f32,
}

/// Rays that are tried before a beam is made smaller.
const TRIED: u32 = 2000;
/// The part of the tried rays that must pass.
const ENOUGH: f64 = 0.97;

impl Beam {
    /// The widest of some beams of which 97 % get through the lens. Of a lens for which none is found, the narrowest.
    pub fn fitted(system: &System, tracer: &Tracer) -> Self {
        let info = Paraxial::new(system, tracer.wavelength_nm());
        let last_z = system.last_vertex_z_mm();
        let film_z = info.film_z_mm - last_z;
        let pupil_z = info.exit_pupil.z_mm.map_or(-100.0 * film_z.abs(), |z| z - last_z);
        let pupil = info.exit_pupil.diameter_mm.unwrap_or(system.rear_radius_mm());
        let field = system.half_field_deg().unwrap_or(20.0).min(40.0).to_radians().tan();
        let image = info.efl_mm.map_or(20.0, f64::abs) * field;
        let beam = |part: f64| Self {
            half_film_mm: [(0.8 * image * part) as f32, (0.6 * image * part) as f32],
            film_z_mm: film_z as f32,
            pupil_z_mm: pupil_z as f32,
            half_pupil_mm: (0.35 * pupil * part.sqrt()) as f32,
        };
        let passes = |beam: &Self| {
            let passed = (0..TRIED).filter(|&i| tracer.from_film(beam.ray(i, last_z)).is_ok()).count();
            passed as f64 >= ENOUGH * f64::from(TRIED)
        };
        let parts = (0..12).map(|i| 0.8f64.powi(i));
        let beams: Vec<Self> = parts.map(beam).collect();
        beams.iter().find(|beam| passes(beam)).or(beams.last()).copied().unwrap_or(beam(0.1))
    }

    /// Ray number `i` in lens space, the last vertex standing at `last_z_mm`: as flood.wgsl makes it.
    pub fn ray(&self, i: u32, last_z_mm: f64) -> Ray {
        let even = |bits: u32| (bits >> 8) as f32 * f32::EPSILON - 1.0;
        let a = mixed(i);
        let b = mixed(a);
        let c = mixed(b);
        let e = mixed(c);
        let [width, height] = self.half_film_mm;
        let film = Vec3::new(width * even(a), height * even(b), self.film_z_mm);
        let pupil = Vec3::new(self.half_pupil_mm * even(c), self.half_pupil_mm * even(e), self.pupil_z_mm);
        let onward = if self.pupil_z_mm < self.film_z_mm { 1.0 } else { -1.0 };
        let d = ((pupil - film) * onward).normalize();
        let p = film + d * (-film.z / d.z);
        let origin = DVec3::new(f64::from(p.x), f64::from(p.y), last_z_mm);
        Ray { origin, direction: d.as_dvec3().normalize() }
    }
}

/// PCG, as in flood.wgsl.
fn mixed(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The division of the work into dispatches, workgroups and threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Threads in a workgroup: a power of two.
    pub group: u32,
    /// Rays that each thread traces in turn.
    pub rays_each: u32,
    /// Workgroups of a dispatch, 65 535 at most.
    pub groups: u32,
    /// Number of dispatches, one after the other.
    pub dispatches: u32,
}

impl Cut {
    /// Number of rays of all dispatches.
    pub fn rays(&self) -> u64 {
        u64::from(self.group) * u64::from(self.rays_each) * u64::from(self.groups) * u64::from(self.dispatches)
    }
}

/// The result of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flooded {
    /// Rays that were traced.
    pub rays: u64,
    /// Rays that got through.
    pub passed: u64,
    /// The sum of their results: the same again if nothing changed.
    pub sum: f64,
    /// Time from the submission to the end, s.
    pub wall_s: f64,
    /// Seconds by the device's own clock, if it has one.
    pub device_s: Option<f64>,
}

/// A lens on a device and the rays that it is timed with. Compiled for a cut.
pub struct Flood<N> {
    gpu: Gpu,
    loaded: Loaded,
    cut: Cut,
    number: PhantomData<N>,
}

impl<N: Number> Flood<N> {
    /// Compiles the shader for the lens, which must be laid out for rays from the film.
    pub fn new(gpu: &Gpu, lens: &LensTable, style: Style, cut: Cut, beam: &Beam) -> Result<Self, GpuError> {
        debug_assert!(lens.travel() == Travel::FromFilm);
        let text = shader::flood::<N>(lens, style, cut.group);
        let mut loaded = Loaded::new::<N>(gpu, lens, text, "flood", true)?;
        let [width, height] = beam.half_film_mm;
        loaded.job.film = [width, height, beam.film_z_mm, beam.pupil_z_mm];
        loaded.job.pupil = [beam.half_pupil_mm, 0.0, 0.0, 0.0];
        loaded.job.rays_each = cut.rays_each;
        Ok(Self { gpu: gpu.clone(), loaded, cut, number: PhantomData })
    }

    /// Traces all rays once.
    pub fn run(&self) -> Result<Flooded, GpuError> {
        let Cut { group, rays_each, groups, dispatches } = self.cut;
        let device = &self.gpu.device;
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let bytes = u64::from(groups) * 8;
        // Zeros, as every new buffer.
        let sums = self.gpu.buffer("sums", bytes, storage)?;
        let rays = self.gpu.buffer("rays", 256, storage)?;
        let in_one = group.wrapping_mul(rays_each).wrapping_mul(groups);
        let jobs = (0..dispatches).map(|i| {
            let job = Job { seed: in_one.wrapping_mul(i), ..self.loaded.job };
            self.loaded.bound(&self.gpu, &job, &rays, Some(&sums))
        });
        let jobs: Vec<wgpu::BindGroup> = jobs.collect::<Result<_, _>>()?;
        // What was uploaded is there before the clock starts.
        self.gpu.queue.submit([]);
        self.gpu.wait()?;
        let clock = self.gpu.has_timestamps().then(|| {
            let description = wgpu::QuerySetDescriptor { label: None, ty: wgpu::QueryType::Timestamp, count: 2 };
            device.create_query_set(&description)
        });
        let times = self.gpu.buffer("times", 256, wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC)?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let timestamp_writes = clock.as_ref().map(|query_set| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            });
            let description = wgpu::ComputePassDescriptor { label: None, timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&description);
            pass.set_pipeline(&self.loaded.pipeline);
            for job in &jobs {
                pass.set_bind_group(0, job, &[]);
                pass.dispatch_workgroups(groups, 1, 1);
            }
        }
        if let Some(clock) = &clock {
            encoder.resolve_query_set(clock, 0..2, &times, 0);
        }
        let commands = encoder.finish();
        let start = Instant::now();
        self.gpu.queue.submit([commands]);
        self.gpu.wait()?;
        let wall_s = start.elapsed().as_secs_f64();
        let device_s = match clock {
            None => None,
            Some(_) => {
                let bytes = self.gpu.read(&times, 16)?;
                let [begin, end] = [0, 8].map(|at| bytemuck::pod_read_unaligned::<u64>(&bytes[at..at + 8]));
                let ticks = end.saturating_sub(begin);
                (ticks > 0).then(|| ticks as f64 * f64::from(self.gpu.queue.get_timestamp_period()) * 1e-9)
            }
        };
        let summed = self.gpu.read(&sums, bytes)?;
        let (mut passed, mut sum) = (0u64, 0.0);
        for pair in summed.chunks_exact(8) {
            let [count, total] = [0, 4].map(|at| bytemuck::pod_read_unaligned::<u32>(&pair[at..at + 4]));
            passed += u64::from(count);
            sum += f64::from(f32::from_bits(total));
        }
        Ok(Flooded { rays: self.cut.rays(), passed, sum, wall_s, device_s })
    }
}
