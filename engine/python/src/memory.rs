//! Memory that is free for a scene.

use pyo3::prelude::*;
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Bytes that this process may still take without swapping: what the machine has left, or its container (cgroups); `None` where
/// the system does not say.
#[pyfunction]
pub(crate) fn free_memory_bytes() -> Option<u64> {
    if !sysinfo::IS_SUPPORTED_SYSTEM {
        return None;
    }
    let memory = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(memory);
    let of_machine = system.available_memory();
    Some(system.cgroup_limits().map_or(of_machine, |limits| limits.free_memory.min(of_machine)))
}
