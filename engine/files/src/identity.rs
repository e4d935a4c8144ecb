//! The identity of a file's content: a file that was replaced has another.

use std::fs::Metadata;
use std::io;
use std::path::Path;
use std::time::SystemTime;

/// The identity of the content of a file, as far as the file system tells: which file it is, its length and the time of its last
/// change. A file that was replaced has another identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    length: u64,
    modified: Option<SystemTime>,
    /// Device and inode, where the system has them.
    place: Option<(u64, u64)>,
}

impl Identity {
    /// The identity of the file at a path; links are followed.
    ///
    /// # Errors
    /// The file cannot be asked for.
    pub fn of(path: &Path) -> io::Result<Self> {
        path.metadata().map(|metadata| Self::of_metadata(&metadata))
    }

    /// The identity of the file that has this metadata.
    #[must_use]
    pub fn of_metadata(metadata: &Metadata) -> Self {
        #[cfg(unix)]
        let place = {
            use std::os::unix::fs::MetadataExt;
            Some((metadata.dev(), metadata.ino()))
        };
        #[cfg(not(unix))]
        let place = None;
        Self { length: metadata.len(), modified: metadata.modified().ok(), place }
    }
}
