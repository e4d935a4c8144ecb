//! Memory that is free for a scene. Each system is asked in its own way, and needs nothing but its C library.

#[cfg(target_os = "linux")]
mod linux;
#[cfg(target_os = "macos")]
mod macos;
#[cfg(windows)]
mod windows;

#[cfg(target_os = "linux")]
use linux::free_bytes;
#[cfg(target_os = "macos")]
use macos::free_bytes;
#[cfg(windows)]
use windows::free_bytes;

use pyo3::prelude::*;

/// Bytes that this process may still take without swapping: the free memory of the machine or of its container (cgroups); `None` where
/// the system does not say.
#[pyfunction]
pub(crate) fn free_memory_bytes() -> Option<u64> {
    free_bytes()
}

#[cfg(not(any(target_os = "linux", target_os = "macos", windows)))]
fn free_bytes() -> Option<u64> {
    None
}
