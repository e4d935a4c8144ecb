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
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The beginning of each file; another layout has another number.
const MAGIC: &[u8; 16] = b"Petzval film   1";
/// What else decides the bits of a picture: the engine, and whether products and sums are rounded together.
const MADE_BY: (&str, bool) = (env!("CARGO_PKG_VERSION"), cfg!(target_feature = "fma"));

/// Where and how often a render is kept.
#[derive(Clone, Debug)]
pub struct Checkpoints {
    /// Replaced each time.
    pub file: PathBuf,
    /// Of all that decides the picture: only a render with the same one takes it up.
    pub fingerprint: String,
    /// From the end of one writing to the next.
    pub every: Duration,
}

/// What became of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    /// Mean samples a pixel that were there at the start.
    pub resumed_samples: f64,
    /// Wall time that these had taken, s.
    pub resumed_seconds: f64,
    /// Checkpoints written by this render.
    pub written: u32,
    /// Wall time of the longest stop of all threads for it, s.
    pub longest_stop_s: f64,
    /// Why what was there was not taken up, or why nothing can be written.
    pub problem: Option<String>,
}

/// Keeps a render.
pub(super) struct Keeper {
    settings: Checkpoints,
    kept: Mutex<Kept>,
    /// From the renders before.
    seconds: f64,
}

/// What a file holds, after the magic.
#[derive(Serialize, Deserialize)]
struct Whole {
    made_by: (String, bool),
    fingerprint: String,
    seconds: f64,
    counts: Counts,
    film: FilmState,
    adaptive: Option<AdaptiveState>,
}

#[derive(Debug, thiserror::Error)]
enum Unusable {
    #[error("{0}")]
    Io(#[from] std::io::Error),
    #[error("it is no checkpoint, or damaged")]
    Damaged,
    #[error("it is of another version of Petzval")]
    Version,
    #[error("it is of another picture: the scene or a setting is not the same")]
    Picture,
}

impl Keeper {
    /// Takes up what was kept of the same picture, before the first thread starts.
    pub(super) fn new(settings: Checkpoints, shared: &mut Shared) -> Self {
        let mut keeper = Self { settings, kept: Mutex::default(), seconds: 0.0 };
        match keeper.read() {
            Ok(None) => {}
            Ok(Some(whole)) => keeper.take_up(whole, shared),
            Err(why) => keeper.complain(format!("begun anew: {why}")),
        }
        keeper
    }

    fn read(&self) -> Result<Option<Whole>, Unusable> {
        let file = match File::open(&self.settings.file) {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let mut bytes = Vec::new();
        BufReader::new(file).read_to_end(&mut bytes)?;
        let bytes = bytes.strip_prefix(MAGIC).ok_or(Unusable::Damaged)?;
        let whole: Whole = postcard::from_bytes(bytes).map_err(|_| Unusable::Damaged)?;
        if (whole.made_by.0.as_str(), whole.made_by.1) != MADE_BY {
            return Err(Unusable::Version);
        }
        if whole.fingerprint != self.settings.fingerprint {
            return Err(Unusable::Picture);
        }
        Ok(Some(whole))
    }

    fn take_up(&mut self, whole: Whole, shared: &mut Shared) {
        let fits = shared.film.restore(whole.film).is_ok()
            && match (&mut shared.adaptive, whole.adaptive) {
                (Some(adaptive), Some(state)) => adaptive.restore(state),
                (None, None) => true,
                _ => false,
            };
        if !fits {
            // The fingerprint says that it is the same picture: then it holds what it should, or was damaged.
            *lock(&shared.failure) =
                Some(format!("{}: {}; delete it", self.settings.file.display(), Unusable::Damaged));
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

    /// Of now.
    pub(super) fn kept(&self) -> Kept {
        lock(&self.kept).clone()
    }

    /// Nothing is kept any more.
    pub(super) fn delete(&self) {
        // If it cannot be deleted, the next render says what it is.
        let _ = std::fs::remove_file(&self.settings.file);
    }

    fn complain(&self, problem: String) {
        let problem = format!("checkpoint {}: {problem}", self.settings.file.display());
        lock(&self.kept).problem = Some(problem);
    }

    fn write(&self, shared: &Shared) {
        let whole = {
            let _alone = shared.gate.write().unwrap_or_else(PoisonError::into_inner);
            let began = Instant::now();
            let whole = Whole {
                made_by: (MADE_BY.0.to_owned(), MADE_BY.1),
                fingerprint: self.settings.fingerprint.clone(),
                seconds: self.seconds + shared.started.elapsed().as_secs_f64(),
                counts: *lock(&shared.counts),
                film: shared.film.state(),
                adaptive: shared.adaptive.as_ref().map(super::adaptive::Adaptive::state),
            };
            let mut kept = lock(&self.kept);
            kept.longest_stop_s = kept.longest_stop_s.max(began.elapsed().as_secs_f64());
            whole
        };
        match self.write_whole(&whole) {
            Ok(()) => lock(&self.kept).written += 1,
            Err(error) => self.complain(format!("cannot be written: {error}")),
        }
    }

    fn write_whole(&self, whole: &Whole) -> std::io::Result<()> {
        // Of its own for each process: two that render the same do not mix.
        let beside = self.settings.file.with_extension(format!("{}.new", std::process::id()));
        let write = || {
            let mut file = BufWriter::with_capacity(1 << 20, File::create(&beside)?);
            file.write_all(MAGIC)?;
            let file = postcard::to_io(whole, file).map_err(std::io::Error::other)?;
            let file = file.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            file.sync_all()?;
            std::fs::rename(&beside, &self.settings.file)
        };
        write().inspect_err(|_| {
            let _ = std::fs::remove_file(&beside);
        })
    }
}

impl Shared {
    /// The life of the thread that keeps the render: also what is there at the end, if that came late enough.
    pub(super) fn keep(&self) {
        let Some(keeper) = &self.keeper else { return };
        let began = Instant::now();
        loop {
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
