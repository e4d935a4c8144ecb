// SPDX-License-Identifier: GPL-3.0-or-later
//! Devices: which there are, which is chosen, and the one that is open.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::GpuError;

/// The kind of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// A graphics card.
    Discrete,
    /// A graphics processor beside the CPU.
    Integrated,
    /// A part of a graphics card, lent to a virtual machine.
    Virtual,
    /// A driver that runs on the CPU, as lavapipe does.
    Software,
    /// Unknown.
    Other,
}

impl From<wgpu::DeviceType> for DeviceKind {
    fn from(kind: wgpu::DeviceType) -> Self {
        match kind {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::VirtualGpu => Self::Virtual,
            wgpu::DeviceType::Cpu => Self::Software,
            wgpu::DeviceType::Other => Self::Other,
        }
    }
}

/// A device that could be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Name of the device, as its driver gives it.
    pub name: String,
    /// The kind of the device.
    pub kind: DeviceKind,
    /// Name and version of the device's driver.
    pub driver: String,
}

impl DeviceInfo {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_owned();
        Self { name: info.name, kind: info.device_type.into(), driver }
    }
}

/// The device that a user asks for: `cpu`, `gpu`, `any` or a part of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceChoice {
    /// No device: the renderer's own tracer.
    Cpu,
    /// The first graphics card, or else another graphics processor; no software driver.
    Gpu,
    /// As [`Self::Gpu`], or else a software driver: for tests.
    Any,
    /// The first whose name has this in it, in any case of letters.
    Named(String),
}

impl FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text.trim().to_lowercase().as_str() {
            "cpu" => Self::Cpu,
            "gpu" => Self::Gpu,
            "any" => Self::Any,
            name => Self::Named(name.to_owned()),
        })
    }
}

impl DeviceChoice {
    /// The number of the device among those that there are; `None` for the CPU.
    pub fn among(&self, devices: &[DeviceInfo]) -> Result<Option<usize>, GpuError> {
        let first =
            |kinds: &[DeviceKind]| kinds.iter().find_map(|kind| devices.iter().position(|one| one.kind == *kind));
        let hardware =
            || first(&[DeviceKind::Discrete, DeviceKind::Integrated, DeviceKind::Virtual, DeviceKind::Other]);
        let known = || devices.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(", ");
        match self {
            Self::Cpu => Ok(None),
            _ if devices.is_empty() => Err(GpuError::NoDevice),
            Self::Gpu => hardware().map(Some).ok_or_else(|| GpuError::OnlySoftware { known: known() }),
            Self::Any => Ok(hardware().or_else(|| first(&[DeviceKind::Software]))),
            Self::Named(name) => {
                let found = devices.iter().position(|one| one.name.to_lowercase().contains(name));
                found.map(Some).ok_or_else(|| GpuError::UnknownDevice { asked: name.clone(), known: known() })
            }
        }
    }
}

/// Errors that a driver has reported and that have not been taken yet.
#[derive(Debug, Default)]
struct Faults {
    first: Mutex<Option<Fault>>,
}

#[derive(Clone, Debug)]
enum Fault {
    OutOfMemory,
    Lost(String),
    Rejected(String),
}

impl Faults {
    /// Keeps the first, but for the loss of the device, which explains all others.
    fn note(&self, fault: Fault) {
        let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        if first.is_none() || matches!(fault, Fault::Lost(_)) {
            *first = Some(fault);
        }
    }
}

/// An open device. Cheap to clone.
#[derive(Clone)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: DeviceInfo,
    faults: Arc<Faults>,
}

impl fmt::Debug for Gpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Gpu").field("info", &self.info).finish_non_exhaustive()
    }
}

fn adapters() -> Vec<wgpu::Adapter> {
    let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
    description.backends = wgpu::Backends::VULKAN;
    pollster::block_on(wgpu::Instance::new(description).enumerate_adapters(wgpu::Backends::VULKAN))
}

/// The devices that there are, in the order of the driver's list.
pub fn devices() -> Vec<DeviceInfo> {
    adapters().iter().map(DeviceInfo::of).collect()
}

impl Gpu {
    /// Opens the device that was chosen; `None` for the CPU.
    pub fn open(choice: &DeviceChoice) -> Result<Option<Self>, GpuError> {
        if *choice == DeviceChoice::Cpu {
            return Ok(None);
        }
        let adapters = adapters();
        let devices: Vec<DeviceInfo> = adapters.iter().map(DeviceInfo::of).collect();
        let Some(number) = choice.among(&devices)? else { return Ok(None) };
        let (adapter, info) = (&adapters[number], devices[number].clone());
        let wanted = wgpu::Features::SHADER_F64 | wgpu::Features::TIMESTAMP_QUERY;
        let description = wgpu::DeviceDescriptor {
            label: Some("petzval"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&description))
            .map_err(|error| GpuError::Refused { device: info.name.clone(), why: one_line(&error.to_string()) })?;
        let faults = Arc::new(Faults::default());
        let noted = faults.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            noted.note(match error {
                wgpu::Error::OutOfMemory { .. } => Fault::OutOfMemory,
                other => Fault::Rejected(one_line(&other.to_string())),
            });
        }));
        let noted = faults.clone();
        device.set_device_lost_callback(move |reason, message| {
            noted.note(Fault::Lost(one_line(&format!("{reason:?} {message}"))));
        });
        Ok(Some(Self { device, queue, info, faults }))
    }

    /// The device's name, kind and driver.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// True if shaders can compute in numbers of a kind.
    pub fn has<N: crate::number::Number>(&self) -> bool {
        self.device.features().contains(N::FEATURES)
    }

    /// True if the device says how long its work took.
    pub fn has_timestamps(&self) -> bool {
        self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Gives the device back: whatever it is asked from now on says that it was lost.
    pub fn close(&self) {
        self.device.destroy();
        self.faults.note(Fault::Lost("closed".to_owned()));
    }

    /// Returns the first error that the driver has reported since the last call. A lost device stays lost.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let mut first = self.faults.first.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(fault) = first.clone() else { return Ok(()) };
        let device = self.info.name.clone();
        if !matches!(fault, Fault::Lost(_)) {
            *first = None;
        }
        Err(match fault {
            Fault::OutOfMemory => GpuError::OutOfMemory { device },
            Fault::Lost(why) => GpuError::Lost { device, why },
            Fault::Rejected(why) => GpuError::Rejected { device, why },
        })
    }

    /// Waits for all that was submitted.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        self.check()?;
        // wgpu panics where the device is lost while it waits.
        let waited = catch_unwind(AssertUnwindSafe(|| self.device.poll(wgpu::PollType::wait_indefinitely())));
        match waited {
            Ok(Ok(_)) => {}
            Ok(Err(error)) => self.faults.note(Fault::Rejected(one_line(&error.to_string()))),
            Err(_) => self.faults.note(Fault::Lost("while it computed".to_owned())),
        }
        self.check()
    }

    /// A buffer of `bytes`, at least 4.
    pub(crate) fn buffer(
        &self,
        what: &'static str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let limits = self.device.limits();
        let limit = match usage.contains(wgpu::BufferUsages::STORAGE) {
            true => limits.max_buffer_size.min(limits.max_storage_buffer_binding_size),
            false => limits.max_buffer_size,
        };
        if bytes > limit {
            return Err(GpuError::TooLarge { device: self.info.name.clone(), what, bytes, limit });
        }
        let size = bytes.next_multiple_of(4).max(4);
        let description = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
        let buffer = self.device.create_buffer(&description);
        self.check()?;
        Ok(buffer)
    }

    /// A buffer that holds these bytes.
    pub(crate) fn filled(
        &self,
        what: &'static str,
        bytes: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let buffer = self.buffer(what, bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST)?;
        if !bytes.is_empty() {
            self.queue.write_buffer(&buffer, 0, bytes);
        }
        self.check()?;
        Ok(buffer)
    }

    /// The first `bytes` of a buffer, once all that was submitted before is done.
    pub(crate) fn read(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let copy = self.buffer("results", bytes, usage)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let noted = self.faults.clone();
        copy.map_async(wgpu::MapMode::Read, .., move |mapped| {
            if let Err(error) = mapped {
                noted.note(Fault::Rejected(one_line(&error.to_string())));
            }
        });
        self.wait()?;
        let view = copy.get_mapped_range(..).map_err(|error| GpuError::Rejected {
            device: self.info.name.clone(),
            why: one_line(&error.to_string()),
        })?;
        Ok(view[..bytes as usize].to_vec())
    }
}

/// A driver's words in one line, as errors are told.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(name: &str, kind: DeviceKind) -> DeviceInfo {
        DeviceInfo { name: name.to_owned(), kind, driver: String::new() }
    }

    fn choose(text: &str, devices: &[DeviceInfo]) -> Result<Option<usize>, GpuError> {
        text.parse::<DeviceChoice>().unwrap().among(devices)
    }

    #[test]
    fn a_card_comes_before_other_devices() {
        let devices = [
            device("llvmpipe", DeviceKind::Software),
            device("Arc", DeviceKind::Integrated),
            device("H100", DeviceKind::Discrete),
        ];
        assert_eq!(choose("gpu", &devices), Ok(Some(2)));
        assert_eq!(choose("any", &devices[..2]), Ok(Some(1)));
        assert_eq!(choose("any", &devices[..1]), Ok(Some(0)));
        assert_eq!(choose("cpu", &devices), Ok(None));
        assert_eq!(choose("h10", &devices), Ok(Some(2)));
    }

    #[test]
    fn what_is_not_there_is_said_in_a_line() {
        let software = [device("llvmpipe", DeviceKind::Software)];
        assert_eq!(choose("gpu", &[]), Err(GpuError::NoDevice));
        for (asked, devices) in [("gpu", &software[..]), ("RTX", &software[..]), ("any", &[])] {
            let said = choose(asked, devices).unwrap_err().to_string();
            assert!(!said.contains('\n') && said.contains("cpu"), "{said}");
        }
    }
}
