//! The files that a camera is made from, each read once.

use super::CameraDescription;
use petzval_optics::formats::lens::LensFileError;
use petzval_optics::formats::{self, Reading};
use petzval_optics::glass::Catalogue;
use petzval_optics::lensfun::Database;
use petzval_pictures::channels::Channels;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// The files of a camera as they were read first. Clones of a camera share them, so that a job reads each file once, and has one lens even if
/// its file is replaced meanwhile.
#[derive(Clone, Debug, Default)]
pub struct ReadFiles {
    lens: ReadFile<Reading>,
    pub(super) database: ReadFile<Database>,
    pub(super) map: ReadFile<Channels>,
}

/// The content of a file as it was read first, which clones share.
#[derive(Debug)]
pub(super) struct ReadFile<T>(Arc<OnceLock<(PathBuf, Arc<T>)>>);

impl<T> Clone for ReadFile<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> Default for ReadFile<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T> ReadFile<T> {
    /// The content of the file at a path; `read` is called where it is not known.
    ///
    /// # Errors
    /// Those of `read`.
    pub(super) fn get<E>(&self, path: &Path, read: impl Fn() -> Result<T, E>) -> Result<Arc<T>, E> {
        match self.0.get() {
            Some((known, content)) if known == path => Ok(content.clone()),
            // The settings were changed to another file.
            Some(_) => read().map(Arc::new),
            None => {
                let content = read().map(Arc::new)?;
                let (known, first) = self.0.get_or_init(|| (path.to_owned(), content.clone()));
                Ok(if known == path { first.clone() } else { content })
            }
        }
    }
}

impl CameraDescription {
    /// The lens, and the remarks on its file.
    ///
    /// # Errors
    /// [`LensFileError`].
    pub fn lens_file(&self) -> Result<Arc<Reading>, LensFileError> {
        self.read_files.lens.get(&self.lens_path, || formats::read(&self.lens_path, Catalogue::shipped()))
    }

    /// These settings, their files read together with those of `other`.
    #[must_use]
    pub fn reading_with(mut self, other: &Self) -> Self {
        self.read_files = other.read_files.clone();
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: &str = "#radius thickness glass diameter conic isstop\n60 6 N-BK7 30 0 1\n-60 55 air 30 0 0\n";

    #[test]
    fn what_failed_is_read_again_and_what_was_read_is_not() {
        let (file, reads) = (ReadFile::default(), std::cell::Cell::new(0));
        let read = |found: Result<u32, ()>| {
            reads.set(reads.get() + 1);
            found
        };
        let [one, other] = ["one", "other"].map(Path::new);
        assert!(file.get(one, || read(Err(()))).is_err());
        assert_eq!(file.get(one, || read(Ok(1))).as_deref(), Ok(&1));
        assert_eq!(file.clone().get(one, || read(Ok(2))).as_deref(), Ok(&1));
        assert_eq!(file.get(other, || read(Ok(3))).as_deref(), Ok(&3));
        assert_eq!(reads.get(), 3);
    }

    #[test]
    fn clones_read_one_file_once() {
        let path = std::env::temp_dir().join(format!("petzval-reads-once-{}.lens", std::process::id()));
        std::fs::write(&path, format!("# name: first\n{LENS}")).unwrap();
        let d = CameraDescription { lens_path: path.clone(), ..CameraDescription::default() };
        let name = |d: &CameraDescription| d.lens_file().unwrap().prescription.name.clone();
        assert_eq!(name(&d), "first");
        std::fs::write(&path, format!("# name: second\n{LENS}")).unwrap();
        assert_eq!(name(&d.clone()), "first");
        let other = CameraDescription { lens_path: path.clone(), ..CameraDescription::default() };
        assert_eq!(name(&other), "second");
        assert_eq!(name(&other.reading_with(&d)), "first");
        // Another lens in a copy of the settings is read.
        let moved = path.with_extension("moved.lens");
        std::fs::rename(&path, &moved).unwrap();
        let elsewhere = CameraDescription { lens_path: moved.clone(), ..d.clone() };
        assert_eq!(name(&elsewhere), "second");
        assert_eq!(name(&d), "first");
        std::fs::remove_file(&moved).unwrap();
    }
}
