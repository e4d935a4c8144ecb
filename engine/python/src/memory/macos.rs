//! macOS: the counts of pages of the Mach kernel.
#![allow(unsafe_code, reason = "functions of the system are called")]

use std::ffi::c_int;

/// `HOST_VM_INFO64` of mach/host_info.h.
const HOST_VM_INFO64: c_int = 4;

/// `vm_statistics64` of mach/vm_statistics.h, as all systems since 10.9 fill it.
#[repr(C)]
#[derive(Default)]
struct PageCounts {
    free: u32,
    active: u32,
    inactive: u32,
    wired: u32,
    events: [u64; 9],
    purgeable: u32,
    speculative: u32,
    compression: [u64; 4],
    compressor: u32,
    throttled: u32,
    of_files: u32,
    anonymous: u32,
    uncompressed_in_compressor: u64,
}

// All of it is in the C library, libSystem.
unsafe extern "C" {
    fn mach_host_self() -> u32;
    fn host_page_size(host: u32, bytes: *mut usize) -> c_int;
    fn host_statistics64(host: u32, kind: c_int, counts: *mut PageCounts, length: *mut u32) -> c_int;
}

/// Free memory, bytes: pages that are free, hold only content of files, or may be dropped.
pub(super) fn free_bytes() -> Option<u64> {
    let mut counts = PageCounts::default();
    // Counted in integers of 32 bits.
    let mut length = u32::try_from(size_of::<PageCounts>() / size_of::<u32>()).ok()?;
    let mut page_bytes = 0usize;
    // SAFETY: the functions fill what they are given the addresses of; the length is that of the counts.
    let is_filled = unsafe {
        let host = mach_host_self();
        host_page_size(host, &raw mut page_bytes) == 0
            && host_statistics64(host, HOST_VM_INFO64, &raw mut counts, &raw mut length) == 0
    };
    let pages = u64::from(counts.free) + u64::from(counts.of_files) + u64::from(counts.purgeable);
    is_filled.then(|| pages.saturating_mul(u64::try_from(page_bytes).unwrap_or(0)))
}
