// SPDX-License-Identifier: GPL-3.0-or-later
//! A lens on a device: batches of rays in, their fates and exit rays out.

use std::marker::PhantomData;

use glam::DVec3;
use petzval_optics::surface::Failure;
use petzval_optics::trace::{Lost, Ray, Travel};

use crate::device::Gpu;
use crate::error::GpuError;
use crate::lens::{LensTable, bytes};
use crate::number::Number;
use crate::shader::{self, GROUP, Style};

/// Workgroups in a row of a dispatch: no device allows fewer.
const ROW: u32 = 32_768;

/// The settings of a dispatch: `Job` of bindings.wgsl, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Job {
    pub(crate) rays: u32,
    pub(crate) steps: u32,
    pub(crate) wavelengths: u32,
    pub(crate) blades: u32,
    pub(crate) seed: u32,
    pub(crate) rays_each: u32,
    pub(crate) is_curved: u32,
    pub(crate) mask_side: u32,
    pub(crate) film: [f32; 4],
    pub(crate) pupil: [f32; 4],
}

/// A lens in a device's memory and its compiled shader.
pub(crate) struct Loaded {
    pub(crate) pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    buffers: [wgpu::Buffer; 3],
    pub(crate) job: Job,
}

impl Loaded {
    /// Compiles the shader `text`, whose entry point is named, and uploads the lens. `is_timed`: with the sums of flood.wgsl.
    pub(crate) fn new<N: Number>(
        gpu: &Gpu,
        lens: &LensTable,
        text: String,
        entry: &str,
        is_timed: bool,
    ) -> Result<Self, GpuError> {
        if !gpu.has::<N>() {
            return Err(GpuError::NoSuchNumber { device: gpu.info().name.clone(), number: N::NAME });
        }
        let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
        let uniform = wgpu::BufferBindingType::Uniform;
        let mut kinds = vec![storage(true), storage(true), storage(true), uniform, storage(false)];
        if is_timed {
            kinds.push(storage(false));
        }
        let entry_of = |(binding, ty): (usize, &wgpu::BufferBindingType)| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty: *ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let entries: Vec<_> = kinds.iter().enumerate().map(entry_of).collect();
        let device = &gpu.device;
        let description = wgpu::BindGroupLayoutDescriptor { label: Some(entry), entries: &entries };
        let layout = device.create_bind_group_layout(&description);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(entry),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        gpu.check()?;
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        });
        gpu.check()?;
        let made = lens.buffers::<N>();
        let storage = wgpu::BufferUsages::STORAGE;
        let buffers = [
            gpu.filled("the surfaces", &made.steps, storage)?,
            gpu.filled("the surfaces' numbers", &made.numbers, storage)?,
            gpu.filled("the interfaces", &made.interfaces, storage)?,
        ];
        let job = Job {
            steps: lens.stages.len() as u32,
            wavelengths: lens.wavelengths as u32,
            blades: lens.opening.sides.len() as u32,
            is_curved: u32::from(lens.opening.bulge != 0.0),
            mask_side: lens.opening.mask.as_ref().map_or(0, |mask| mask.side as u32),
            ..Job::default()
        };
        Ok(Self { pipeline, layout, buffers, job })
    }

    /// The lens with a job, its rays and, for a timed run, its sums.
    pub(crate) fn bound(
        &self,
        gpu: &Gpu,
        job: &Job,
        rays: &wgpu::Buffer,
        sums: Option<&wgpu::Buffer>,
    ) -> Result<wgpu::BindGroup, GpuError> {
        let job = gpu.filled("a job", bytemuck::bytes_of(job), wgpu::BufferUsages::UNIFORM)?;
        let all = self.buffers.iter().chain([&job, rays]).chain(sums);
        let entry = |(binding, buffer): (usize, &wgpu::Buffer)| (binding as u32, buffer.clone());
        let bound: Vec<(u32, wgpu::Buffer)> = all.enumerate().map(entry).collect();
        let entries: Vec<_> = bound
            .iter()
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
            .collect();
        let description = wgpu::BindGroupDescriptor { label: None, layout: &self.layout, entries: &entries };
        let group = gpu.device.create_bind_group(&description);
        gpu.check()?;
        Ok(group)
    }
}

/// A lens on a device, ready for batches of rays.
pub struct LensKernel<N> {
    gpu: Gpu,
    lens: LensTable,
    loaded: Loaded,
    number: PhantomData<N>,
}

/// A ray and the number of its wavelength among those of the [`LensTable`].
pub type LineRay = (Ray, u32);

impl<N: Number> LensKernel<N> {
    /// Compiles the shader for the lens and uploads it.
    pub fn new(gpu: &Gpu, lens: &LensTable, style: Style) -> Result<Self, GpuError> {
        let text = shader::trace::<N>(lens, style, GROUP);
        let loaded = Loaded::new::<N>(gpu, lens, text, "trace", false)?;
        Ok(Self { gpu: gpu.clone(), lens: lens.clone(), loaded, number: PhantomData })
    }

    /// As [`Self::new`] with another text in place of the shader's, for tests of the tests.
    #[doc(hidden)]
    pub fn with_text(gpu: &Gpu, lens: &LensTable, text: String) -> Result<Self, GpuError> {
        let loaded = Loaded::new::<N>(gpu, lens, text, "trace", false)?;
        Ok(Self { gpu: gpu.clone(), lens: lens.clone(), loaded, number: PhantomData })
    }

    /// The results of rays in lens space: those that leave the lens, or the surfaces and reasons that ended them, as
    /// `Tracer::from_scene` and `from_film` of the same wavelength say it.
    pub fn trace(&self, rays: &[LineRay]) -> Result<Vec<Result<Ray, Lost>>, GpuError> {
        let known = self.lens.wavelengths as u32;
        if let Some(&(_, asked)) = rays.iter().find(|(_, line)| *line >= known) {
            return Err(GpuError::NoSuchWavelength { asked, known });
        }
        let limits = self.gpu.device.limits();
        let room = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size) / Self::ray_bytes() as u64;
        let at_once = room.min(u64::from(ROW) * u64::from(GROUP) * 64).max(1) as usize;
        let mut results = Vec::with_capacity(rays.len());
        for part in rays.chunks(at_once) {
            self.trace_part(part, &mut results)?;
        }
        Ok(results)
    }

    fn ray_bytes() -> usize {
        6 * size_of::<N>() + 8
    }

    fn trace_part(&self, rays: &[LineRay], results: &mut Vec<Result<Ray, Lost>>) -> Result<(), GpuError> {
        let mut packed = Vec::with_capacity(rays.len() * Self::ray_bytes());
        let mut is_number = Vec::with_capacity(rays.len());
        for (ray, line) in rays {
            let (p, d) = self.lens.tracer.enter(self.lens.travel, *ray);
            let mut numbers = [p.x, p.y, p.z, d.x, d.y, d.z];
            // A device need not know numbers that are none.
            let finite = numbers.iter().all(|&x| N::from_f64(x).to_f64().is_finite());
            if !finite {
                numbers = [0.0; 6];
            }
            is_number.push(finite);
            packed.extend(bytes::<N>(&numbers));
            packed.extend_from_slice(bytemuck::cast_slice(&[*line, 0]));
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let buffer = self.gpu.filled("rays", &packed, usage)?;
        let job = Job { rays: rays.len() as u32, ..self.loaded.job };
        let group = self.loaded.bound(&self.gpu, &job, &buffer, None)?;
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.loaded.pipeline);
            pass.set_bind_group(0, &group, &[]);
            let groups = (rays.len() as u32).div_ceil(GROUP);
            pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
        let traced = self.gpu.read(&buffer, packed.len() as u64)?;
        for (ray, is_number) in traced.chunks_exact(Self::ray_bytes()).zip(is_number) {
            results.push(self.result(ray, is_number));
        }
        Ok(())
    }

    /// The result of a ray by its bytes.
    fn result(&self, ray: &[u8], is_number: bool) -> Result<Ray, Lost> {
        let number =
            |i: usize| bytemuck::pod_read_unaligned::<N>(&ray[i * size_of::<N>()..][..size_of::<N>()]).to_f64();
        let word = bytemuck::pod_read_unaligned::<u32>(&ray[6 * size_of::<N>()..][..4]);
        if !is_number {
            let surface = if self.lens.travel == Travel::FromScene { 0 } else { self.lens.stages.len() - 1 };
            return Err(Lost { surface, reason: Failure::Missed });
        }
        let reason = match word & 7 {
            0 => {
                let [point, direction] = [0, 3].map(|i| DVec3::new(number(i), number(i + 1), number(i + 2)));
                return Ok(self.lens.tracer.leave(self.lens.travel, point, direction));
            }
            1 => Failure::Missed,
            2 => Failure::WrongSheet,
            3 => Failure::OutsideAperture,
            4 => Failure::Obstructed,
            5 => Failure::BladeStop,
            6 => Failure::TotalInternalReflection,
            _ => Failure::NotConverged,
        };
        Err(Lost { surface: (word >> 3) as usize, reason })
    }
}
