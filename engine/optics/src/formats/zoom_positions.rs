//! Positions by zoom and focus from the configurations of a design program's file: a zoom's focal lengths, or the distances of a lens that
//! is focused inside.

use crate::first_order::between_vertices;
use crate::prescription::moving::{Part, Position, Quantity};

use super::configurations::Configurations;
use super::draft::{Draft, INFINITELY_FAR_MM};

/// Focal lengths that differ by less are the same, as a part.
const SAME_FOCAL_LENGTH: f64 = 1e-4;
/// Rounding of widths of the stop, as a part.
const SAME_WIDTH: f64 = 1e-9;

/// A lens in one configuration.
struct State {
    focal_mm: f64,
    object_mm: f64,
    /// The gaps behind the rows, mm.
    gaps_mm: Vec<f64>,
    stop_diameter_mm: f64,
}

/// The configuration at infinity of the same zoom as the one of a near object: the one that shares most gaps with it. Of several that do,
/// the one before it in the file, or, where those at infinity stand first, the one of the same order. `None` if neither tells.
fn zoom_of(i: usize, order: usize, near: usize, far: &[usize], states: &[State]) -> Option<usize> {
    let shared = |j: usize| states[i].gaps_mm.iter().zip(&states[j].gaps_mm).filter(|(a, b)| a == b).count();
    let most = far.iter().map(|j| shared(*j)).max()?;
    let mut alike = far.iter().copied().filter(|j| shared(*j) == most);
    if let (Some(only), None) = (alike.next(), alike.next()) {
        return Some(only);
    }
    let mut by_file = far.to_vec();
    by_file.sort_unstable();
    if by_file.iter().enumerate().all(|(place, j)| place == *j) {
        return near.is_multiple_of(far.len()).then(|| by_file[order % far.len()]);
    }
    by_file.into_iter().rev().find(|j| *j < i)
}

/// The remark on the positions that configurations became.
fn summary(positions: &[Position], left_out: usize) -> String {
    let count = positions.len();
    let zooms = || positions.iter().filter_map(|p| p.zoom_mm);
    let mut what = match zooms().reduce(f64::max) {
        Some(longest) => {
            let shortest = zooms().fold(f64::INFINITY, f64::min);
            format!("{count} configurations are positions of a zoom from {shortest} to {longest} mm")
        }
        None => format!("{count} configurations are positions of the focus"),
    };
    if left_out > 0 {
        what +=
            &format!("; {left_out} more are left out: they repeat a focal length, or are near ones of no known zoom");
    }
    what
}

impl Draft<'_> {
    /// Makes moving parts of the configurations. Returns the widths of the beams on each surface in the widest of them, mm; 0 without any.
    pub(super) fn configure(&mut self, stop: usize) -> Vec<f64> {
        let mut widest_mm = vec![0.0f64; self.rows.len()];
        let Some(configurations) = self.configurations.take() else { return widest_mm };
        let states: Vec<State> =
            (0..configurations.count).map(|i| self.state(&configurations, i, stop, &mut widest_mm)).collect();
        if let Err(why) = self.positions_of(&configurations, &states, stop) {
            let (count, place) = (configurations.count, configurations.place);
            let what = format!(
                "the file has {count} configurations, and {why}: the lens is read as it stands in the surfaces"
            );
            self.remarks.say(place, what);
            return vec![0.0; self.rows.len()];
        }
        widest_mm
    }

    /// The lens in a configuration, its beams added to the widest. The draft is as before.
    fn state(&mut self, configurations: &Configurations, i: usize, stop: usize, widest_mm: &mut [f64]) -> State {
        let before = (self.rows.clone(), self.object_mm, self.beam);
        for (row, gaps_mm) in &configurations.gaps_mm {
            self.rows[*row].thickness_mm = gaps_mm[i].unwrap_or(self.rows[*row].thickness_mm);
        }
        self.object_mm = configurations.objects_mm[i].unwrap_or(self.object_mm);
        if self.object_mm.abs() > INFINITELY_FAR_MM {
            self.object_mm = f64::INFINITY;
        }
        if let (Some(last), Some(mm)) =
            (self.rows.len().checked_sub(1), self.image_distance_mm().filter(|_| configurations.image_follows))
        {
            self.rows[last].thickness_mm = mm;
        }
        self.beam = configurations.beams[i].or(self.beam);
        self.open_stop(stop);
        for (widest, beam) in widest_mm.iter_mut().zip(self.beams(stop)) {
            *widest = widest.max(beam);
        }
        let state = State {
            focal_mm: between_vertices(&self.thin()).c.recip().abs(),
            object_mm: self.object_mm,
            gaps_mm: self.rows.iter().map(|row| row.thickness_mm).collect(),
            stop_diameter_mm: 2.0 * self.rows[stop].semi_diameter_mm.unwrap_or(0.0),
        };
        (self.rows, self.object_mm, self.beam) = before;
        state
    }

    /// Puts the states into the draft as positions by zoom and focus, the active one first; the error says why they are none.
    fn positions_of(
        &mut self,
        configurations: &Configurations,
        states: &[State],
        stop: usize,
    ) -> Result<(), &'static str> {
        if states.iter().any(|state| !(state.focal_mm.is_finite() && state.focal_mm > 0.0)) {
            return Err("one of them has no focal length");
        }
        let is_same = |a: f64, b: f64| (a - b).abs() <= SAME_FOCAL_LENGTH * a.abs();
        // Those with their object at infinity, one of each focal length; the active one first.
        let mut far: Vec<usize> = Vec::new();
        let first = configurations.active.min(states.len() - 1);
        for i in std::iter::once(first).chain((0..states.len()).filter(|i| *i != first)) {
            let is_new = !far.iter().any(|j| is_same(states[*j].focal_mm, states[i].focal_mm));
            if states[i].object_mm.is_infinite() && is_new {
                far.push(i);
            }
        }
        if far.is_empty() {
            return Err("none has its object at infinity");
        }
        let zooms = far.len() > 1;
        let near: Vec<usize> = (0..states.len()).filter(|i| states[*i].object_mm.is_finite()).collect();
        let near_ones =
            near.iter().enumerate().filter_map(|(order, i)| Some((*i, zoom_of(*i, order, near.len(), &far, states)?)));
        let all: Vec<(usize, usize)> = far.iter().map(|i| (*i, *i)).chain(near_ones).collect();

        let changes = |of: &dyn Fn(&State) -> f64, same: f64| {
            let value = of(&states[all[0].0]);
            all.iter().any(|(i, _)| (of(&states[*i]) - value).abs() > same * value.abs())
        };
        let last = self.rows.len() - 1;
        // The film follows the lens by itself; with it a lens would not be focused.
        let gaps: Vec<usize> =
            (0..=last).filter(|row| (zooms || *row != last) && changes(&|state| state.gaps_mm[*row], 0.0)).collect();
        let opens = changes(&|state| state.stop_diameter_mm, SAME_WIDTH);
        if gaps.is_empty() {
            return Err("no gap changes between them");
        }
        let position = |&(i, zoom): &(usize, usize)| Position {
            zoom_mm: zooms.then(|| (states[zoom].focal_mm * 1e4).round() / 1e4),
            focus_mm: states[i].object_mm,
            values: (gaps.iter().map(|row| states[i].gaps_mm[*row]))
                .chain(opens.then_some(states[i].stop_diameter_mm))
                .collect(),
        };
        let mut positions: Vec<Position> = Vec::new();
        for place in all.iter().map(position) {
            if !positions.iter().any(|p| p.zoom_mm == place.zoom_mm && p.focus_mm == place.focus_mm) {
                positions.push(place);
            }
        }
        let what = summary(&positions, states.len() - positions.len());
        self.remarks.say(configurations.place, what);
        let diameter = opens.then_some(Part { surface: stop, quantity: Quantity::Diameter });
        let parts = gaps.into_iter().map(Part::gap).chain(diameter).collect();
        self.moving = Some((parts, positions.clone(), vec![configurations.place; positions.len()]));
        Ok(())
    }
}
