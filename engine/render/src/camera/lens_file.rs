//! The lens file of a camera, read once.

use super::CameraDescription;
use petzval_optics::formats::lens::LensFileError;
use petzval_optics::formats::{self, Reading};
use petzval_optics::glass::Catalogue;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// The lens file as it was read first. Clones of a camera share it, so that a job reads the file once, and has one lens even if the file
/// is replaced meanwhile.
#[derive(Clone, Debug, Default)]
pub struct LensFile(Arc<OnceLock<(PathBuf, Arc<Reading>)>>);

impl CameraDescription {
    /// The lens, and the remarks on its file.
    ///
    /// # Errors
    /// [`LensFileError`].
    pub fn lens_file(&self) -> Result<Arc<Reading>, LensFileError> {
        let read = || formats::read(&self.lens_path, Catalogue::shipped()).map(Arc::new);
        match self.read_lens.0.get() {
            Some((path, reading)) if *path == self.lens_path => Ok(reading.clone()),
            // The settings were changed to another lens.
            Some(_) => read(),
            None => {
                let reading = read()?;
                let (path, first) = self.read_lens.0.get_or_init(|| (self.lens_path.clone(), reading.clone()));
                Ok(if *path == self.lens_path { first.clone() } else { reading })
            }
        }
    }

    /// These settings, their lens file read together with that of `other`.
    #[must_use]
    pub fn reading_with(mut self, other: &Self) -> Self {
        self.read_lens = other.read_lens.clone();
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: &str = "#radius thickness glass diameter conic isstop\n60 6 N-BK7 30 0 1\n-60 55 air 30 0 0\n";

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
