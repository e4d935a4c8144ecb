//! Parts of a render's light as passes, each divided by its reference.

use super::{Job, Shared};
use crate::integrator::path::parts::LightPass;
use rayon::prelude::*;

impl Job {
    /// A part of the light so far, three numbers a pixel, rows from below: light as it is, any other part divided by its reference. `None`:
    /// the part was not asked for.
    pub fn part(&self, part: LightPass) -> Option<Vec<[f32; 3]>> {
        self.shared.part(part)
    }
}

impl Shared {
    /// See [`Job::part`].
    pub(super) fn part(&self, part: LightPass) -> Option<Vec<[f32; 3]>> {
        let place = self.parts.place(part)?;
        let whole = self.film.parts()[place].picture().into_par_iter().map(|[r, g, b, _]| [r, g, b]);
        let Some(base) = part.relative_to().and_then(|base| self.part(base)) else { return Some(whole.collect()) };
        let relative = whole.zip(base).map(|(of, base)| over(of, base));
        // Kept is what mist leaves: where a ray finds nothing, that is nothing.
        let mist = |clear: [f32; 3]| clear.map(|one| 1.0 - one);
        Some(if part == LightPass::Mist { relative.map(mist).collect() } else { relative.collect() })
    }
}

/// The quotient of two colours by channel; a channel whose base is 0 has the mean of the others, as in Cycles.
fn over(of: [f32; 3], base: [f32; 3]) -> [f32; 3] {
    let parts: [Option<f32>; 3] = std::array::from_fn(|c| (base[c] != 0.0).then(|| of[c] / base[c]));
    let count = parts.iter().flatten().count().max(1) as f32;
    let mean = parts.iter().flatten().sum::<f32>() / count;
    parts.map(|part| part.unwrap_or(mean))
}
