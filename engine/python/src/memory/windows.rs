//! Windows: `GlobalMemoryStatusEx`.
#![allow(unsafe_code, reason = "a function of the system is called")]

/// `MEMORYSTATUSEX` of sysinfoapi.h.
#[repr(C)]
#[derive(Default)]
struct MemoryStatus {
    length: u32,
    load_percent: u32,
    total_physical: u64,
    available_physical: u64,
    total_page_file: u64,
    available_page_file: u64,
    total_virtual: u64,
    available_virtual: u64,
    available_extended_virtual: u64,
}

#[link(name = "kernel32", kind = "raw-dylib")]
unsafe extern "system" {
    fn GlobalMemoryStatusEx(status: *mut MemoryStatus) -> i32;
}

/// Free memory, bytes: physical memory that the machine has left.
pub(super) fn free_bytes() -> Option<u64> {
    let length = u32::try_from(size_of::<MemoryStatus>()).ok()?;
    let mut status = MemoryStatus { length, ..MemoryStatus::default() };
    // SAFETY: the function fills the struct, whose length it is told.
    let is_filled = unsafe { GlobalMemoryStatusEx(&raw mut status) } != 0;
    is_filled.then_some(status.available_physical)
}
