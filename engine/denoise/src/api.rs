//! The C interface of Open Image Denoise 2 (`OpenImageDenoise/oidn.h`), as far as it is called here.
#![allow(unsafe_code, reason = "a C library is called")]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;

use crate::DenoiseError;

/// A handle of the library: to a device, a buffer or a filter.
pub(crate) type Handle = *mut c_void;
/// Called with the part that is done; false stops the filter.
pub(crate) type Monitor = extern "C" fn(*mut c_void, f64) -> bool;

/// `OIDN_DEVICE_TYPE_DEFAULT`, the fastest that there is, and `OIDN_DEVICE_TYPE_CPU`.
const FASTEST: c_int = 0;
const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;
/// `OIDN_ERROR_OUT_OF_MEMORY` and `OIDN_ERROR_CANCELLED`.
pub(crate) const OUT_OF_MEMORY: c_int = 4;
pub(crate) const CANCELLED: c_int = 6;

/// Opens a library, with those in its own folder that it needs: there Windows does not look by itself.
#[cfg(windows)]
unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
    // SAFETY: the caller answers for what the library does when it is loaded.
    unsafe { Library::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(libloading::Library::from)
}

/// Opens a library, with those that it needs.
#[cfg(not(windows))]
unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: the caller answers for what the library does when it is loaded.
    unsafe { libloading::Library::new(path) }
}

macro_rules! functions {
    ($($(#[$about:meta])* $name:ident = $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of a library that is loaded. They stay valid as long as it is.
        pub(crate) struct Functions {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            _library: libloading::Library,
        }

        impl Functions {
            /// Loads the library of a file, with those beside it that it needs.
            pub(crate) fn load(path: &Path) -> Result<Self, DenoiseError> {
                let fail = |error: libloading::Error| DenoiseError::NoLibrary { path: path.to_owned(), why: error.to_string() };
                // SAFETY: the file is Open Image Denoise's, which does nothing when it is loaded; its functions have these types in all
                // versions 2 (its headers 2.0 to 2.5).
                unsafe {
                    let library = open(path).map_err(fail)?;
                    Ok(Self { $($name: *library.get($symbol).map_err(fail)?,)* _library: library })
                }
            }
        }
    };
}

functions! {
    new_device = b"oidnNewDevice\0": fn(c_int) -> Handle;
    set_device_int = b"oidnSetDeviceInt\0": fn(Handle, *const c_char, c_int);
    set_device_bool = b"oidnSetDeviceBool\0": fn(Handle, *const c_char, bool);
    get_device_int = b"oidnGetDeviceInt\0": fn(Handle, *const c_char) -> c_int;
    commit_device = b"oidnCommitDevice\0": fn(Handle);
    get_device_error = b"oidnGetDeviceError\0": fn(Handle, *mut *const c_char) -> c_int;
    release_device = b"oidnReleaseDevice\0": fn(Handle);
    new_filter = b"oidnNewFilter\0": fn(Handle, *const c_char) -> Handle;
    new_buffer = b"oidnNewBuffer\0": fn(Handle, usize) -> Handle;
    read_buffer = b"oidnReadBuffer\0": fn(Handle, usize, usize, *mut c_void);
    write_buffer = b"oidnWriteBuffer\0": fn(Handle, usize, usize, *const c_void);
    release_buffer = b"oidnReleaseBuffer\0": fn(Handle);
    set_image = b"oidnSetFilterImage\0": fn(Handle, *const c_char, Handle, c_int, usize, usize, usize, usize, usize);
    set_filter_bool = b"oidnSetFilterBool\0": fn(Handle, *const c_char, bool);
    set_filter_int = b"oidnSetFilterInt\0": fn(Handle, *const c_char, c_int);
    set_monitor = b"oidnSetFilterProgressMonitorFunction\0": fn(Handle, Option<Monitor>, *mut c_void);
    commit_filter = b"oidnCommitFilter\0": fn(Handle);
    execute_filter = b"oidnExecuteFilter\0": fn(Handle);
    release_filter = b"oidnReleaseFilter\0": fn(Handle);
}

/// A device that computes.
pub(crate) struct Device {
    functions: &'static Functions,
    handle: Handle,
}

// SAFETY: all calls of the library may come from any thread; it serialises those that use one device (its manual, "Device").
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// The graphics card where it is asked for and there is one; else the processor, with so many threads.
    pub(crate) fn new(functions: &'static Functions, use_gpu: bool, threads: usize) -> Result<Self, DenoiseError> {
        // SAFETY: all handles are those that the library gave; names end in a zero.
        unsafe {
            let handle = (functions.new_device)(if use_gpu { FASTEST } else { CPU });
            let device = Self { functions, handle };
            if handle.is_null() {
                return Err(device
                    .error()
                    .unwrap_or(DenoiseError::Failed { code: 0, message: "no device".to_owned() }));
            }
            if device.is_cpu() {
                (functions.set_device_int)(handle, c"numThreads".as_ptr(), c_int::try_from(threads).unwrap_or(0));
                // Threads that are bound to cores would stay there while other programs run.
                (functions.set_device_bool)(handle, c"setAffinity".as_ptr(), false);
            }
            (functions.commit_device)(handle);
            device.check()?;
            Ok(device)
        }
    }

    /// True for the processor.
    pub(crate) fn is_cpu(&self) -> bool {
        self.property(c"type") == CPU
    }

    fn property(&self, name: &CStr) -> c_int {
        // SAFETY: as in `new`.
        unsafe { (self.functions.get_device_int)(self.handle, name.as_ptr()) }
    }

    /// Major, minor and patch version of the library.
    pub(crate) fn version(&self) -> [i32; 3] {
        [c"versionMajor", c"versionMinor", c"versionPatch"].map(|name| self.property(name))
    }

    /// The first error since the last call.
    fn error(&self) -> Option<DenoiseError> {
        let mut message = std::ptr::null();
        // SAFETY: the library writes the address of a text of its own, which stays until its next call.
        let (code, message) = unsafe {
            let code = (self.functions.get_device_error)(self.handle, &raw mut message);
            let text = if message.is_null() { "".into() } else { CStr::from_ptr(message).to_string_lossy() };
            (code, text.into_owned())
        };
        match code {
            0 => None,
            CANCELLED => Some(DenoiseError::Stopped),
            OUT_OF_MEMORY => Some(DenoiseError::OutOfMemory),
            _ => Some(DenoiseError::Failed { code, message }),
        }
    }

    fn check(&self) -> Result<(), DenoiseError> {
        self.error().map_or(Ok(()), Err)
    }

    /// Memory of the device for so many numbers.
    pub(crate) fn buffer(&self, numbers: usize) -> Result<Buffer<'_>, DenoiseError> {
        // SAFETY: as in `new`.
        let handle = unsafe { (self.functions.new_buffer)(self.handle, numbers * size_of::<f32>()) };
        self.check()?;
        Ok(Buffer { device: self, handle, numbers })
    }

    /// Memory of the device with these numbers.
    pub(crate) fn filled(&self, numbers: &[f32]) -> Result<Buffer<'_>, DenoiseError> {
        let buffer = self.buffer(numbers.len())?;
        // SAFETY: the buffer has as many bytes as are copied.
        unsafe { (self.functions.write_buffer)(buffer.handle, 0, size_of_val(numbers), numbers.as_ptr().cast()) };
        self.check()?;
        Ok(buffer)
    }

    /// The filter of ray-traced pictures.
    pub(crate) fn filter(&self) -> Result<Filter<'_>, DenoiseError> {
        // SAFETY: as in `new`.
        let handle = unsafe { (self.functions.new_filter)(self.handle, c"RT".as_ptr()) };
        self.check()?;
        Ok(Filter { device: self, handle })
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the handle is the library's, and is not used again.
            unsafe { (self.functions.release_device)(self.handle) }
        }
    }
}

/// Memory of a device.
pub(crate) struct Buffer<'a> {
    device: &'a Device,
    handle: Handle,
    numbers: usize,
}

impl Buffer<'_> {
    /// The numbers that lie there.
    pub(crate) fn read(&self) -> Result<Vec<f32>, DenoiseError> {
        let mut found = vec![0.0f32; self.numbers];
        // SAFETY: the buffer has as many bytes as are copied.
        unsafe {
            let bytes = size_of_val(found.as_slice());
            (self.device.functions.read_buffer)(self.handle, 0, bytes, found.as_mut_ptr().cast());
        }
        self.device.check()?;
        Ok(found)
    }
}

impl Drop for Buffer<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is the library's, and is not used again.
        unsafe { (self.device.functions.release_buffer)(self.handle) }
    }
}

/// The filter of ray-traced pictures.
pub(crate) struct Filter<'a> {
    device: &'a Device,
    handle: Handle,
}

impl Filter<'_> {
    /// Gives the filter an image of three numbers a pixel to read or to write: `color`, `albedo`, `normal`, `output`. The library counts
    /// its uses of the memory.
    pub(crate) fn set_image(&self, name: &CStr, pixels: &Buffer<'_>, [width, height]: [usize; 2]) {
        assert_eq!(pixels.numbers, width * height * 3, "three numbers a pixel");
        // SAFETY: the length is that of the image.
        unsafe {
            (self.device.functions.set_image)(self.handle, name.as_ptr(), pixels.handle, FLOAT3, width, height, 0, 0, 0)
        }
    }

    pub(crate) fn set_bool(&self, name: &CStr, value: bool) {
        // SAFETY: as in `Device::new`.
        unsafe { (self.device.functions.set_filter_bool)(self.handle, name.as_ptr(), value) }
    }

    pub(crate) fn set_int(&self, name: &CStr, value: i32) {
        // SAFETY: as in `Device::new`.
        unsafe { (self.device.functions.set_filter_int)(self.handle, name.as_ptr(), value) }
    }

    /// Runs the filter; `watch` is called with the part that is done, and returns false to stop.
    pub(crate) fn execute(&self, watch: &dyn Fn(f64) -> bool) -> Result<(), DenoiseError> {
        extern "C" fn monitor(watch: *mut c_void, part: f64) -> bool {
            // SAFETY: the address of `watch` below, which outlives the execution.
            let watch = unsafe { &*watch.cast::<&dyn Fn(f64) -> bool>() };
            watch(part)
        }
        let address: *const &dyn Fn(f64) -> bool = &raw const watch;
        // SAFETY: as in `Device::new`; the filter runs to its end before this returns.
        unsafe {
            (self.device.functions.set_monitor)(self.handle, Some(monitor), address.cast_mut().cast());
            (self.device.functions.commit_filter)(self.handle);
            self.device.check()?;
            (self.device.functions.execute_filter)(self.handle);
            (self.device.functions.set_monitor)(self.handle, None, std::ptr::null_mut());
        }
        self.device.check()
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is the library's, and is not used again.
        unsafe { (self.device.functions.release_filter)(self.handle) }
    }
}
