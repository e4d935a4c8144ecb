//! Long renders survive the end of their program: the work so far is written to a file again and again, and a render of the same
//! picture takes it up, to the same bits.
//!
//! Passes of a tile are added in order, and light that falls far away is added in whole quanta (`film/splats.rs`), so the
//! picture depends on which passes have been added alone. A checkpoint is the film between passes. The threads stand still
//! while it is copied, not while it is written; a new file takes the place of the old one when it is whole.

pub use super::film_file::check_file;
use super::film_file::{self, CheckpointBody, CheckpointHeader, KeptBody, Unusable};
use super::joining::may_come_to;
use super::share::Share;
use super::{Shared, lock};
use petzval_files::Identity;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

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
    /// The tiles that are rendered.
    share: Share,
    kept: Mutex<Kept>,
    /// The file as this render has last written it or taken it up.
    own: Mutex<Option<OwnFile>>,
    /// Wall time of the renders before, s.
    seconds: f64,
}

impl Keeper {
    /// Takes up the checkpoint of the same picture, before the first thread starts. A file that is no checkpoint ends the render: it
    /// is not to be replaced.
    pub(super) fn new(settings: Checkpoints, shared: &mut Shared) -> Self {
        let (kept, own) = (Mutex::default(), Mutex::default());
        let mut keeper = Self { settings, share: shared.share, kept, own, seconds: 0.0 };
        match keeper.read() {
            Ok(None) => {}
            Ok(Some(body)) => keeper.take_up(body, shared),
            Err(Unusable::Foreign) => keeper.fail(shared, &Unusable::Foreign),
            Err(why) => keeper.complain(format!("begun anew: {why}")),
        }
        keeper
    }

    fn read(&self) -> Result<Option<KeptBody>, Unusable> {
        let path = &self.settings.file;
        let Some((header, body, identity)) = film_file::read(path, &self.settings.fingerprint)? else {
            return Ok(None);
        };
        // A whole render takes up any part of its picture.
        if header.share != self.share && self.share != Share::default() {
            return Err(Unusable::Share);
        }
        *lock(&self.own) = Some(OwnFile { path: path.clone(), identity });
        Ok(Some(body))
    }

    fn fail(&self, shared: &Shared, why: &Unusable) {
        *lock(&shared.failure) = Some(format!("checkpoint {}: {why}", self.settings.file.display()));
        shared.stop.store(true, Ordering::Relaxed);
    }

    fn take_up(&mut self, whole: KeptBody, shared: &mut Shared) {
        let (whole, film) = (whole.progress, whole.film);
        let (passes, is_together) = (&shared.passes, shared.settings.denoising.is_some());
        let adaptive = shared.adaptive.as_ref().zip(whole.adaptive.as_ref());
        let is_state = |tile| may_come_to(tile, passes, adaptive, is_together);
        let fits = shared.film.restore(film, &is_state).is_ok()
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
        let (body, stop_s) = shared.body(self.seconds);
        {
            let mut kept = lock(&self.kept);
            kept.longest_stop_s = kept.longest_stop_s.max(stop_s);
        }
        match self.write_file(body) {
            Ok(()) => lock(&self.kept).written += 1,
            Err(error) => self.complain(format!("cannot be written: {error}")),
        }
    }

    fn write_file(&self, body: CheckpointBody) -> std::io::Result<()> {
        // Another program may have put a file of its own there.
        check_file(&self.settings.file).map_err(std::io::Error::other)?;
        let header = CheckpointHeader::new(&self.settings.fingerprint, self.share, false);
        film_file::write(&self.settings.file, &header, body, false)?;
        let identity = Identity::of(&self.settings.file)?;
        *lock(&self.own) = Some(OwnFile { path: self.settings.file.clone(), identity });
        Ok(())
    }
}

impl Shared {
    /// The state of the render, `before` s having passed before it, and the time that the threads stood still for it, s.
    pub(super) fn body(&self, before: f64) -> (CheckpointBody, f64) {
        let _alone = self.gate.write().unwrap_or_else(PoisonError::into_inner);
        let began = Instant::now();
        let body = CheckpointBody {
            seconds: before + self.started.elapsed().as_secs_f64(),
            counts: *lock(&self.counts),
            film: self.film.state(),
            adaptive: self.adaptive.as_ref().map(super::adaptive::Adaptive::state),
        };
        (body, began.elapsed().as_secs_f64())
    }

    /// The life of the thread that keeps the render: also the state at the end, if that came late enough.
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
