//! Adaptive sampling: as many samples for each pixel as its error asks for.
//!
//! A block's error is looked at when its pixels have 16, 64, 256 ... samples (four times as many each time, from the first count in the
//! settings). Each half of its pixels then gets as many as the error of the *other* half asks for: those, if they are
//! fewer than at the next look; else it goes on to that look. A half whose count is settled is sampled on, for the error
//! alone, while the other waits for its word. So no count depends on the light that it divides: docs/design/
//! adaptive-sampling.md says why that matters.

use super::lock;
use super::settings::{MIN_SAMPLES, Settings};
use crate::film::{Film, KeptTile};
use serde::{Deserialize, Serialize};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Samples that a pixel has at a look, in those that it had at the look before. More looks come nearer to the count that is needed;
/// fewer cost less samples that only the other half's error needs.
const BETWEEN_LOOKS: u32 = 4;
/// Batches before the first look: the error is estimated from their differences.
const FIRST_BATCHES: u32 = 4;
/// Counts are rounded up to these, a whole set of the sampler's points.
const ROUND: u32 = 4;

/// Samples that all pixels take that have not enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pass {
    /// Number of the first sample.
    pub first: u32,
    /// Number of samples that a pixel takes in the pass.
    pub count: u32,
    /// The number of samples at the next look at the error, if it is looked at after this pass.
    pub next_look: Option<u32>,
}

/// The plan of a block.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct BlockPlan {
    /// Samples of each half's pixels, as far as is known.
    ends: [u32; 2],
    /// True for a half whose error will be looked at again.
    open: [bool; 2],
    /// Samples of the next look.
    look: u32,
}

/// The decisions so far.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct AdaptiveState {
    plans: Vec<BlockPlan>,
    done: u64,
    planned: u64,
}

/// The plans of a render.
pub(super) struct Adaptive {
    pub passes: Vec<Pass>,
    /// Square of the noise threshold of the settings.
    threshold: f32,
    most: u32,
    plans: Vec<Mutex<BlockPlan>>,
    /// Samples of all pixels together that are in the picture, and that will be, as far as is known.
    done: AtomicU64,
    planned: AtomicU64,
}

impl Adaptive {
    /// The decisions for a film in halves of which so many pixels are rendered.
    pub(super) fn new(settings: &Settings, tiles: usize, pixels: u64) -> Self {
        let most = settings.samples;
        let least = if settings.min_samples == 0 { MIN_SAMPLES } else { settings.min_samples }.max(FIRST_BATCHES);
        let has_looks = least < most;
        let first = least.min(most);
        let plan = BlockPlan { ends: [first; 2], open: [has_looks; 2], look: first };
        Self {
            passes: passes(least, most),
            threshold: settings.noise_threshold * settings.noise_threshold,
            most,
            plans: (0..tiles).map(|_| Mutex::new(plan)).collect(),
            done: AtomicU64::new(0),
            planned: AtomicU64::new(pixels * u64::from(most)),
        }
    }

    /// The samples of a half of a tile in a pass, first and count: for the picture, and for the error alone.
    pub(super) fn batch(&self, tile: usize, half: usize, pass: Pass) -> [Option<[u32; 2]>; 2] {
        let plan = *lock(&self.plans[tile]);
        let end = plan.ends[half];
        // The other half decides by what this one sees.
        let seen = if plan.open[1 - half] { end.max(plan.look) } else { end };
        let (first, last) = (pass.first, pass.first + pass.count);
        let part = |from: u32, to: u32| (from < to).then(|| [from, to - from]);
        [part(first, last.min(end)), part(first.max(end), last.min(seen))]
    }

    /// Notes so many samples of each pixel of a half as done.
    pub(super) fn count(&self, film: &Film, tile: usize, half: usize, samples: u32) {
        self.done.fetch_add(u64::from(samples) * film.rect(tile).count_of(half), Ordering::Relaxed);
    }

    /// True if it is decided how a tile goes on after a pass.
    pub(super) fn has_decided(&self, tile: usize, pass: Pass) -> bool {
        pass.next_look.is_none_or(|next| lock(&self.plans[tile]).look >= next)
    }

    /// Decides how a tile goes on after a pass, where that is to be decided now, by the squared relative errors that its halves have seen.
    pub(super) fn look(&self, film: &Film, tile: usize, pass: Pass, errors: [Option<f32>; 2]) {
        let Some(next) = pass.next_look else { return };
        let mut plan = lock(&self.plans[tile]);
        let before = *plan;
        for half in [0, 1].into_iter().filter(|&half| before.open[half]) {
            // A word that is missing is a picture's corner: it gets all.
            let word = errors[1 - half].map_or(f32::INFINITY, |e| e / self.threshold * before.look as f32);
            // No number, where light is beyond all bounds, asks for all too.
            let enough = if word < next as f32 { (word.max(0.0).ceil() as u32).next_multiple_of(ROUND) } else { next };
            plan.ends[half] = enough.clamp(before.look, next);
            plan.open[half] = enough >= next && next < self.most;
            if !plan.open[half] {
                let saved = u64::from(self.most - plan.ends[half]) * film.rect(tile).count_of(half);
                self.planned.fetch_sub(saved, Ordering::Relaxed);
            }
        }
        plan.look = next;
    }

    /// The present decisions; no other thread may decide meanwhile.
    pub(super) fn state(&self) -> AdaptiveState {
        AdaptiveState {
            plans: self.plans.iter().map(|plan| *lock(plan)).collect(),
            done: self.done.load(Ordering::Relaxed),
            planned: self.planned.load(Ordering::Relaxed),
        }
    }

    /// True if a render comes to these passes and samples of a tile with the decisions of `state`; `is_together`: it decides all tiles at once,
    /// after they have ended their passes.
    pub(super) fn may_come_to(&self, state: &AdaptiveState, kept: KeptTile, is_together: bool) -> bool {
        let (Some(plan), passes) = (state.plans.get(kept.tile), kept.passes as usize) else { return false };
        let Some(last) = passes.checked_sub(1).and_then(|last| self.passes.get(last)) else { return false };
        let first = self.passes.iter().find_map(|pass| pass.next_look.map(|_| pass.first + pass.count));
        let look_after = |passes: usize| {
            let looks = self.passes[..passes].iter().rev();
            looks.filter_map(|pass| pass.next_look).next().or(first).unwrap_or(self.most)
        };
        let is_look = plan.look == look_after(passes) || (is_together && plan.look == look_after(passes - 1));
        let done = last.first + last.count;
        let is_plan = |half: usize| {
            let (end, is_open) = (plan.ends[half], plan.open[half]);
            end <= plan.look && (!is_open || end == plan.look) && kept.samples[half] == done.min(end)
        };
        is_look && is_plan(0) && is_plan(1)
    }

    /// Continues from `state`; false if that is of another picture.
    pub(super) fn restore(&mut self, state: AdaptiveState) -> bool {
        let fits = state.plans.len() == self.plans.len();
        self.plans = state.plans.into_iter().map(Mutex::new).collect();
        (self.done, self.planned) = (AtomicU64::new(state.done), AtomicU64::new(state.planned));
        fits
    }

    /// Takes over the decisions on some of the tiles; false, with nothing changed, if that is of another picture.
    pub(super) fn join(&self, state: &AdaptiveState, tiles: &[usize]) -> bool {
        let fits = state.plans.len() == self.plans.len();
        for &tile in tiles.iter().filter(|_| fits) {
            *lock(&self.plans[tile]) = state.plans[tile];
        }
        fits
    }

    /// The part of the work that is done, 0 to 1.
    pub(super) fn progress(&self) -> f32 {
        let planned = self.planned.load(Ordering::Relaxed).max(1);
        (self.done.load(Ordering::Relaxed) as f64 / planned as f64) as f32
    }
}

/// All passes: those before the first look are batches of one size.
fn passes(least: u32, most: u32) -> Vec<Pass> {
    let mut list = Vec::new();
    let (mut look, mut first) = (least.min(most), 0);
    let mut batch = least.div_ceil(FIRST_BATCHES).min(super::MOST_PER_PASS);
    while first < most {
        let count = batch.min(look - first);
        first += count;
        let is_look = first == look && look < most;
        if is_look {
            look = look.saturating_mul(BETWEEN_LOOKS).min(most);
            batch = least.min(super::MOST_PER_PASS);
        }
        list.push(Pass { first: first - count, count, next_look: is_look.then_some(look) });
    }
    list
}

#[cfg(test)]
mod tests;
