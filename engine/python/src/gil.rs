//! The one way into long calls: the interpreter's lock is free meanwhile, and a panic becomes an exception.

use crate::error::{Error, invalid};
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `work` with the interpreter's lock free.
pub(crate) fn without_gil<T, F>(py: Python<'_>, work: F) -> Result<T, Error>
where
    F: FnOnce() -> T + Send,
    T: Send,
{
    py.detach(|| catch_panic(work))
}

/// Runs `work`, short or with calls of Python in it, without letting go of the lock.
pub(crate) fn catch_panic<T>(work: impl FnOnce() -> T) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let text = panic
            .downcast_ref::<String>()
            .cloned()
            .or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()))
            .unwrap_or_default();
        invalid(format!("the engine failed: {text}: please report this with the scene"))
    })
}
