//! Long renders survive the end of their program: what is done is written to a file again and again, and a render of the same
//! picture takes it up, to the same bits.
//!
//! Passes of a tile are added in order, and what light falls far away is added in whole quanta (`film/splats.rs`), so the
//! picture depends on which passes have been added alone. A checkpoint is the film between passes. The threads stand still
//! while it is copied, not while it is written; a new file takes the place of the old one when it is whole.

use super::adaptive::AdaptiveState;
use super::{Shared, lock};
use crate::film::FilmState;
use crate::pipeline::Counts;
use petzval_files::Identity;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The beginning of each file; another layout has another number. Then come the length of the header, the header, its checksum, the
/// [`CheckpointBody`], and the body's length and checksum. Numbers are little-endian.
const MAGIC: &[u8; 16] = b"Petzval film   3";
/// The part of [`MAGIC`] that all layouts share.
const MAGIC_STEM: &[u8] = b"Petzval film";
/// Length of the longest header, bytes; it has a version and a fingerprint.
const LONGEST_HEADER: u32 = 1 << 16;
/// The bytes after the body: its length and its checksum.
const TAIL_BYTES: u64 = 12;
/// Version of the engine, and true if products and sums are rounded together: besides the fingerprint, these decide the bits of a picture.
const MADE_BY: (&str, bool) = (env!("CARGO_PKG_VERSION"), cfg!(target_feature = "fma"));

/// The file in which a render is kept, and the interval.
#[derive(Clone, Debug)]
pub struct Checkpoints {
    /// The file, replaced each time.
    pub file: PathBuf,
    /// Fingerprint of all that decides the picture: only a render with the same one takes it up.
    pub fingerprint: String,
    /// Interval from the end of one writing to the next.
    pub every: Duration,
}

/// The results of keeping and resuming a render.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Kept {
    /// Mean samples a pixel that were there at the start.
    pub resumed_samples: f64,
    /// Wall time that these had taken, s.
    pub resumed_seconds: f64,
    /// Checkpoints written by this render.
    pub written: u32,
    /// Wall time of the longest stop of all threads for a checkpoint, s.
    pub longest_stop_s: f64,
    /// The reason why the kept render was not resumed, or why nothing can be written.
    pub problem: Option<String>,
}

/// The checkpoint that a render has written or taken up.
#[derive(Clone, Debug)]
pub struct OwnFile {
    /// Path of the checkpoint file.
    pub path: PathBuf,
    identity: Identity,
}

impl OwnFile {
    /// Removes the file, unless another render has replaced it meanwhile; true if it was removed.
    pub fn delete(&self) -> bool {
        Identity::of(&self.path).is_ok_and(|now| now == self.identity) && std::fs::remove_file(&self.path).is_ok()
    }
}

/// The keeper of a render's checkpoints.
pub(super) struct Keeper {
    settings: Checkpoints,
    kept: Mutex<Kept>,
    /// The file as this render has last written it or taken it up.
    own: Mutex<Option<OwnFile>>,
    /// Wall time of the renders before, s.
    seconds: f64,
}

/// The first part of a file: whose it is.
#[derive(Serialize, Deserialize)]
struct CheckpointHeader {
    made_by: (String, bool),
    fingerprint: String,
}

/// The second part of a file: the state of the render.
#[derive(Serialize, Deserialize)]
struct CheckpointBody {
    seconds: f64,
    counts: Counts,
    film: FilmState,
    adaptive: Option<AdaptiveState>,
}

#[derive(Debug, thiserror::Error)]
enum Unusable {
    #[error("{0}")]
    Io(#[from] std::io::Error),
    #[error("it is no checkpoint, and is left as it is: name another file")]
    Foreign,
    #[error("it is damaged")]
    Damaged,
    #[error("it is of another version of Petzval")]
    Version,
    #[error("it is of another picture: the scene or a setting is not the same")]
    Picture,
}

/// Checks that a file may be replaced by a checkpoint: there is none, or it is empty or a checkpoint of any version.
///
/// # Errors
/// One line that says what the file is.
pub fn check_file(file: &Path) -> Result<(), String> {
    begin(file).map(drop).map_err(|why| why.to_string())
}

/// The file behind its magic; `None` where there is nothing to take up.
fn begin(path: &Path) -> Result<Option<BufReader<File>>, Unusable> {
    match path.metadata() {
        // Opening a pipe would wait for its other end.
        Ok(metadata) if !metadata.is_file() => return Err(Unusable::Foreign),
        Ok(metadata) if metadata.len() == 0 => return Ok(None),
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error.into()),
    }
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut magic = [0; MAGIC.len()];
    match file.read_exact(&mut magic) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Err(Unusable::Foreign),
        read => read?,
    }
    if !magic.starts_with(MAGIC_STEM) {
        return Err(Unusable::Foreign);
    }
    Ok((magic == *MAGIC).then_some(file))
}

/// A part of a file of so many bytes.
fn part(file: &mut impl Read, bytes: u64) -> Result<Vec<u8>, Unusable> {
    let mut part = Vec::new();
    file.take(bytes).read_to_end(&mut part)?;
    if part.len() as u64 == bytes { Ok(part) } else { Err(Unusable::Damaged) }
}

fn number<const N: usize>(file: &mut impl Read) -> Result<[u8; N], Unusable> {
    part(file, N as u64)?.try_into().map_err(|_| Unusable::Damaged)
}

/// A writer that counts and sums up its bytes.
struct Summed<W> {
    inner: W,
    length: u64,
    checksum: crc32fast::Hasher,
    /// The first error of the inner writer.
    failed: Option<std::io::Error>,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(bytes).inspect_err(|error| {
            let same = error.raw_os_error().map_or_else(|| error.kind().into(), std::io::Error::from_raw_os_error);
            self.failed.get_or_insert(same);
        })?;
        self.length += written as u64;
        self.checksum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

impl Keeper {
    /// Takes up what was kept of the same picture, before the first thread starts. A file that is no checkpoint ends the render: it
    /// is not to be replaced.
    pub(super) fn new(settings: Checkpoints, shared: &mut Shared) -> Self {
        let mut keeper = Self { settings, kept: Mutex::default(), own: Mutex::default(), seconds: 0.0 };
        match keeper.read() {
            Ok(None) => {}
            Ok(Some(body)) => keeper.take_up(body, shared),
            Err(Unusable::Foreign) => keeper.fail(shared, &Unusable::Foreign),
            Err(why) => keeper.complain(format!("begun anew: {why}")),
        }
        keeper
    }

    fn read(&self) -> Result<Option<CheckpointBody>, Unusable> {
        let path = &self.settings.file;
        let Some(mut file) = begin(path)? else {
            // Another version's, unless there is none.
            return if path.metadata().is_ok_and(|m| m.len() > 0) { Err(Unusable::Version) } else { Ok(None) };
        };
        let metadata = file.get_ref().metadata()?;
        let header_bytes = u32::from_le_bytes(number(&mut file)?);
        if header_bytes > LONGEST_HEADER {
            return Err(Unusable::Damaged);
        }
        let header = part(&mut file, header_bytes.into())?;
        if crc32fast::hash(&header) != u32::from_le_bytes(number(&mut file)?) {
            return Err(Unusable::Damaged);
        }
        let header: CheckpointHeader = postcard::from_bytes(&header).map_err(|_| Unusable::Damaged)?;
        if (header.made_by.0.as_str(), header.made_by.1) != MADE_BY {
            return Err(Unusable::Version);
        }
        if header.fingerprint != self.settings.fingerprint {
            return Err(Unusable::Picture);
        }
        let before = MAGIC.len() as u64 + 4 + u64::from(header_bytes) + 4;
        let length = metadata.len().checked_sub(before + TAIL_BYTES).ok_or(Unusable::Damaged)?;
        let body = part(&mut file, length)?;
        let told = (u64::from_le_bytes(number(&mut file)?), u32::from_le_bytes(number(&mut file)?));
        if told != (length, crc32fast::hash(&body)) {
            return Err(Unusable::Damaged);
        }
        let (body, rest) = postcard::take_from_bytes::<CheckpointBody>(&body).map_err(|_| Unusable::Damaged)?;
        if !rest.is_empty() {
            return Err(Unusable::Damaged);
        }
        let identity = Identity::of_metadata(&metadata);
        *lock(&self.own) = Some(OwnFile { path: path.clone(), identity });
        Ok(Some(body))
    }

    fn fail(&self, shared: &Shared, why: &Unusable) {
        *lock(&shared.failure) = Some(format!("checkpoint {}: {why}", self.settings.file.display()));
        shared.stop.store(true, Ordering::Relaxed);
    }

    fn take_up(&mut self, whole: CheckpointBody, shared: &mut Shared) {
        let fits = shared.film.restore(whole.film).is_ok()
            && match (&mut shared.adaptive, whole.adaptive) {
                (Some(adaptive), Some(state)) => adaptive.restore(state),
                (None, None) => true,
                _ => false,
            };
        if !fits {
            // The fingerprint says that it is the same picture: then it holds what it should, or was damaged.
            *lock(&shared.failure) =
                Some(format!("checkpoint {}: {}; delete it", self.settings.file.display(), Unusable::Damaged));
            shared.stop.store(true, Ordering::Relaxed);
            return;
        }
        self.seconds = whole.seconds;
        shared.counts = Mutex::new(whole.counts);
        let counts = shared.film.sample_counts();
        let mut kept = lock(&self.kept);
        kept.resumed_seconds = whole.seconds;
        kept.resumed_samples = counts.iter().copied().map(f64::from).sum::<f64>() / counts.len() as f64;
    }

    /// The results of keeping and resuming the render, so far.
    pub(super) fn kept(&self) -> Kept {
        lock(&self.kept).clone()
    }

    /// The file that this render has written or taken up.
    pub(super) fn own_file(&self) -> Option<OwnFile> {
        lock(&self.own).clone()
    }

    fn complain(&self, problem: String) {
        let problem = format!("checkpoint {}: {problem}", self.settings.file.display());
        lock(&self.kept).problem = Some(problem);
    }

    fn write(&self, shared: &Shared) {
        let body = {
            let _alone = shared.gate.write().unwrap_or_else(PoisonError::into_inner);
            let began = Instant::now();
            let body = CheckpointBody {
                seconds: self.seconds + shared.started.elapsed().as_secs_f64(),
                counts: *lock(&shared.counts),
                film: shared.film.state(),
                adaptive: shared.adaptive.as_ref().map(super::adaptive::Adaptive::state),
            };
            let mut kept = lock(&self.kept);
            kept.longest_stop_s = kept.longest_stop_s.max(began.elapsed().as_secs_f64());
            body
        };
        match self.write_file(&body) {
            Ok(()) => lock(&self.kept).written += 1,
            Err(error) => self.complain(format!("cannot be written: {error}")),
        }
    }

    fn write_file(&self, body: &CheckpointBody) -> std::io::Result<()> {
        // Another program may have put a file of its own there.
        check_file(&self.settings.file).map_err(std::io::Error::other)?;
        let header = CheckpointHeader {
            made_by: (MADE_BY.0.to_owned(), MADE_BY.1),
            fingerprint: self.settings.fingerprint.clone(),
        };
        let header = postcard::to_stdvec(&header).map_err(std::io::Error::other)?;
        petzval_files::write(&self.settings.file, |file| {
            file.write_all(MAGIC)?;
            file.write_all(&(header.len() as u32).to_le_bytes())?;
            file.write_all(&header)?;
            file.write_all(&crc32fast::hash(&header).to_le_bytes())?;
            let mut summed = Summed { inner: &mut *file, length: 0, checksum: crc32fast::Hasher::new(), failed: None };
            // The serialiser forgets why its writer failed.
            if let Err(error) = postcard::to_io(body, &mut summed) {
                return Err(summed.failed.unwrap_or_else(|| std::io::Error::other(error)));
            }
            let (length, checksum) = (summed.length, summed.checksum.finalize());
            file.write_all(&length.to_le_bytes())?;
            file.write_all(&checksum.to_le_bytes())
        })?;
        let identity = Identity::of(&self.settings.file)?;
        *lock(&self.own) = Some(OwnFile { path: self.settings.file.clone(), identity });
        Ok(())
    }
}

impl Shared {
    /// The life of the thread that keeps the render: also what is there at the end, if that came late enough.
    pub(super) fn keep(&self) {
        let Some(keeper) = &self.keeper else { return };
        let began = Instant::now();
        // A film that could not be restored is nothing to keep.
        while lock(&self.failure).is_none() {
            let running = lock(&self.running);
            let every = keeper.settings.every;
            let (running, _) =
                self.ended.wait_timeout_while(running, every, |n| *n > 0).unwrap_or_else(PoisonError::into_inner);
            let is_over = *running == 0;
            drop(running);
            if !is_over || began.elapsed() >= every {
                keeper.write(self);
            }
            if is_over {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests;
