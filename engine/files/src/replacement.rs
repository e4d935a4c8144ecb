//! A file that takes the place of another one when it is complete.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Names of temporary files begin and end so, whatever the replaced file is called: names have a limit of length.
const PREFIX: &str = ".petzval-";
const SUFFIX: &str = ".part";

/// A temporary file that is to replace another one. Dropped without [`Replacement::commit`], it is removed and the old file stays.
#[derive(Debug)]
pub struct Replacement {
    place: PathBuf,
    part: PathBuf,
    /// Open and locked as long as the replacement lives: a temporary file without a lock was left by a process that was killed.
    file: Option<File>,
    is_committed: bool,
}

impl Replacement {
    /// Makes the temporary file. A link is followed: the file that it leads to is replaced. Temporary files in the same folder that
    /// killed processes have left are removed.
    ///
    /// # Errors
    /// Nothing can be written there: see [`check_place`].
    pub fn new(place: &Path) -> io::Result<Self> {
        Self::with_signs(place, "")
    }

    /// As [`Replacement::new`], with characters that the temporary file's name holds.
    fn with_signs(place: &Path, signs: &str) -> io::Result<Self> {
        let place = resolved(place);
        check_kind(&place)?;
        let folder = folder_of(&place);
        remove_leftovers(folder);
        loop {
            let part = folder.join(part_name(signs));
            let file = match OpenOptions::new().read(true).write(true).create_new(true).open(&part) {
                Ok(file) => file,
                // Of a process of the same number on another machine or in a container.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            // Where a file system has no locks, nothing is ever taken for a leftover.
            let _ = file.try_lock();
            let made = Self { place: place.clone(), part, file: Some(file), is_committed: false };
            // Another process may have taken it for a leftover before it was locked.
            if made.part.exists() {
                return Ok(made);
            }
        }
    }

    /// The temporary file's path, for a program that writes files by name.
    #[must_use]
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Puts the temporary file into place: brings it to the disk, gives it the old file's permissions, renames it.
    ///
    /// # Errors
    /// The old file is whole then.
    pub fn commit(mut self) -> io::Result<()> {
        // A full disk may be told of only here. Whoever wrote by name may have made another file of that name.
        OpenOptions::new().write(true).open(&self.part)?.sync_all()?;
        if let Ok(old) = fs::metadata(&self.place) {
            fs::set_permissions(&self.part, old.permissions())?;
        }
        // Windows renames no file that is open.
        self.file = None;
        fs::rename(&self.part, &self.place)?;
        self.is_committed = true;
        // The name is on the disk when its folder is, where a system can be asked for that.
        if let Ok(folder) = File::open(folder_of(&self.place)) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        self.file = None;
        if !self.is_committed {
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// Writes a whole file by a function that is handed the temporary file, and replaces `place` by it.
///
/// # Errors
/// The function's, and those of [`Replacement`]; the old file is whole then.
pub fn write<E: From<io::Error>>(
    place: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    let replacement = Replacement::new(place)?;
    let file = OpenOptions::new().read(true).write(true).open(replacement.part())?;
    let mut writer = BufWriter::with_capacity(1 << 20, file);
    content(&mut writer)?;
    writer.flush()?;
    // A writer that is dropped tells nobody of an error.
    drop(writer.into_inner().map_err(io::IntoInnerError::into_error)?);
    Ok(replacement.commit()?)
}

/// Checks that a file can be replaced, or made. Nothing of it changes, and none is made there, not even for a moment: another process may
/// put a file of its own there meanwhile.
///
/// # Errors
/// It is a folder, a device or a pipe; its folder does not exist; its name is too long; the file or its folder cannot be written.
pub fn check_place(place: &Path) -> io::Result<()> {
    let place = resolved(place);
    check_kind(&place)?;
    if place.exists() {
        // Permission to change the folder would suffice, but a file that is protected is meant to stay.
        OpenOptions::new().append(true).open(&place)?;
    }
    // A name that is too long was refused with its kind; one with characters that the file system has not is refused here.
    Replacement::with_signs(&place, &signs_of(&place)).map(drop)
}

/// The characters of a file's name that some file systems refuse, each once.
fn signs_of(place: &Path) -> String {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let mut signs: Vec<char> = name.chars().filter(|sign| !sign.is_ascii_alphanumeric()).collect();
    signs.sort_unstable();
    signs.dedup();
    // The temporary file's own name has a limit too: 16 characters take at most 64 of 255 bytes.
    signs.truncate(16);
    signs.into_iter().collect()
}

fn check_kind(place: &Path) -> io::Result<()> {
    match fs::metadata(place) {
        Ok(found) if found.is_dir() => Err(io::Error::new(ErrorKind::IsADirectory, "it is a folder")),
        Ok(found) if !found.is_file() => {
            Err(io::Error::new(ErrorKind::InvalidInput, "it is a device or a pipe, not a file"))
        }
        Ok(_) => Ok(()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error),
    }
}

/// The path behind links; of a file that does not exist yet, its folder's.
fn resolved(place: &Path) -> PathBuf {
    fs::canonicalize(place).unwrap_or_else(|_| {
        let name = place.file_name().map_or_else(PathBuf::new, PathBuf::from);
        fs::canonicalize(folder_of(place)).map_or_else(|_| place.to_owned(), |folder| folder.join(name))
    })
}

fn folder_of(place: &Path) -> &Path {
    match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn part_name(signs: &str) -> String {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    format!("{PREFIX}{}-{}{signs}{SUFFIX}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed))
}

/// Removes temporary files that no process has locked: those of processes that were killed. Files that cannot be removed stay.
fn remove_leftovers(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_part = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if is_part
            && let Ok(file) = OpenOptions::new().read(true).write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests;
