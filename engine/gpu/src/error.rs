// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors of a device, each one line with the remedy.

use thiserror::Error;

/// The reason why a device, or a lens on it, cannot be used. The renderer falls back to the CPU.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GpuError {
    /// No driver was found.
    #[error(
        "no graphics device: no Vulkan driver was found; install the driver of the graphics card and libvulkan1, or choose cpu"
    )]
    NoDevice,
    /// Only drivers that run on the processor were found.
    #[error(
        "no graphics device: {known} runs on the processor; install the driver of the graphics card, or choose cpu"
    )]
    OnlySoftware {
        /// The drivers that were found.
        known: String,
    },
    /// No device has this name.
    #[error("no graphics device is named {asked:?}; choose cpu, gpu or one of: {known}")]
    UnknownDevice {
        /// The name that was asked for.
        asked: String,
        /// The devices that there are.
        known: String,
    },
    /// The driver does not open the device.
    #[error("{device} does not open ({why}); update its driver, or choose cpu")]
    Refused {
        /// The device's name.
        device: String,
        /// The reason that the driver states.
        why: String,
    },
    /// The device lacks a kind of number.
    #[error("{device} does not compute in {number}; choose f32")]
    NoSuchNumber {
        /// The device's name.
        device: String,
        /// The kind of number.
        number: &'static str,
    },
    /// The device has no room.
    #[error("{device} is out of memory; close other programs that use it, or choose cpu")]
    OutOfMemory {
        /// The device's name.
        device: String,
    },
    /// A buffer is larger than the device allows.
    #[error("{what} of {bytes} bytes is more than {device} takes at once ({limit}); choose cpu")]
    TooLarge {
        /// The device's name.
        device: String,
        /// The contents of the buffer.
        what: &'static str,
        /// Size of the buffer, bytes.
        bytes: u64,
        /// Largest size that the device takes at once, bytes.
        limit: u64,
    },
    /// The device is gone: reset, unplugged or suspended.
    #[error("{device} was lost ({why}); start again, or choose cpu")]
    Lost {
        /// The device's name.
        device: String,
        /// The reason that the driver states.
        why: String,
    },
    /// A shader or a command was refused: a fault of this program or of the driver.
    #[error("{device} refused a shader or command ({why}); choose cpu, and report this line")]
    Rejected {
        /// The device's name.
        device: String,
        /// The reason that the driver states.
        why: String,
    },
    /// A ray names a wavelength that the lens was not laid out for.
    #[error("wavelength {asked} of {known} was asked for; give a number below {known}")]
    NoSuchWavelength {
        /// Index of the wavelength, from 0.
        asked: u32,
        /// Number of wavelengths that the lens was laid out for.
        known: u32,
    },
    /// A lens was to be laid out for no wavelength.
    #[error("a lens is laid out for 1 wavelength at least, and none was given")]
    NoWavelength,
}
