//! Finds the outline of the clear pupil by tracing.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::trace::{Ray, Tracer};

/// Corners of an outline. More follow the tips of a cat's eye closer and take longer to trace.
pub(super) const ANGLES: usize = 96;
/// The outline is traced to this part of its radius.
const PRECISION: f64 = 1e-3;
/// Points across the rear glass that are tried where no light was found near its last place.
const SCAN: usize = 1024;
/// Rows and columns of points that are tried where the pupil need not lie on the meridian.
const SCAN_ACROSS: usize = 64;

/// Radii in mm of the clear pupil about its centre, at equal angles from the film point's meridian.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub(super) outer: [f64; ANGLES],
    pub(super) inner: [f64; ANGLES],
}

impl Outline {
    /// Grows until it holds `other`.
    pub(super) fn join(&mut self, other: &Self) {
        for i in 0..ANGLES {
            self.outer[i] = self.outer[i].max(other.outer[i]);
            self.inner[i] = self.inner[i].min(other.inner[i]);
        }
    }
}

/// Asks tracers which targets are clear.
pub(super) struct Probe {
    /// With every obstruction taken away: the pupil's hole is found apart.
    open: Vec<Tracer>,
    /// As they are, if anything obstructs them.
    obstructed: Vec<Tracer>,
    reference_z: f64,
    glass_radius: f64,
}

fn passes(tracers: &[Tracer], film: DVec3, target: DVec3) -> bool {
    let towards = target - film;
    let direction = towards / towards.length();
    tracers.iter().any(|t| t.from_film(Ray { origin: film, direction }).is_ok())
}

impl Probe {
    pub(super) fn new(tracers: &[Tracer], reference_z: f64, glass_radius: f64) -> Self {
        let is_obstructed = tracers.iter().any(Tracer::has_obstructions);
        Self {
            open: tracers.iter().map(Tracer::without_obstructions).collect(),
            obstructed: if is_obstructed { tracers.to_vec() } else { Vec::new() },
            reference_z,
            glass_radius,
        }
    }

    fn is_open(&self, film: DVec3, target: DVec2) -> bool {
        passes(&self.open, film, target.extend(self.reference_z))
    }

    /// The middle of the clear pupil for film points at (radius, azimuth) and `film_z`, each near the one before; in
    /// axes along and across the film point's meridian. `None` where no light arrives.
    ///
    /// For a lens that is symmetric about its axis the middle lies on the meridian; else it `is_sought_across`, too.
    pub(super) fn centres(
        &self,
        film_z: f64,
        films: impl Iterator<Item = (f64, f64)>,
        is_sought_across: bool,
    ) -> Vec<Option<DVec2>> {
        let mut last: Option<(DVec2, f64)> = None;
        let mut drift = DVec2::ZERO;
        films
            .map(|(radius, azimuth)| {
                let meridian = DVec2::from_angle(azimuth);
                let film = (meridian * radius).extend(film_z);
                let is_clear = |v: DVec2| self.is_open(film, meridian.rotate(v));
                let guess = last.map_or(DVec2::ZERO, |(centre, _)| centre + drift);
                let width = last.map_or(self.glass_radius, |(_, half)| 2.0 * half);
                let start = self.clear_point(guess, width, is_sought_across, is_clear)?;
                let (mut centre, mut half) = self.middle(start, DVec2::X, width, is_clear);
                if is_sought_across {
                    for axis in [DVec2::Y, DVec2::X, DVec2::Y] {
                        (centre, half) = self.middle(centre, axis, width, is_clear);
                    }
                }
                drift = last.map_or(DVec2::ZERO, |(before, _)| centre - before);
                last = Some((centre, half));
                Some(centre)
            })
            .collect()
    }

    /// A clear point near `guess`, or anywhere, on the meridian or, if it is sought across, too, beside it.
    fn clear_point(
        &self,
        guess: DVec2,
        width: f64,
        is_sought_across: bool,
        is_clear: impl Fn(DVec2) -> bool,
    ) -> Option<DVec2> {
        let glass = self.glass_radius;
        let near = (0..=32).map(|i| guess + DVec2::X * (width * alternating(i) / 16.0));
        let along = (0..=SCAN).flat_map(|i| {
            let x = guess.x.clamp(-glass, glass) + 2.0 * glass / SCAN as f64 * alternating(i);
            [x, x - x.signum() * 2.0 * glass].map(|x| DVec2::new(x, guess.y))
        });
        let rows = if is_sought_across { SCAN_ACROSS } else { 0 };
        let across = (0..rows * rows).map(|i| {
            let place = |i: usize| glass * ((2 * i + 1) as f64 / rows as f64 - 1.0);
            DVec2::new(place(i % rows), place(i / rows))
        });
        near.chain(along).chain(across).find(|&v| is_clear(v))
    }

    /// The middle of the clear part of the line through the clear point `start` along `axis`, and half its length.
    fn middle(&self, start: DVec2, axis: DVec2, width: f64, is_clear: impl Fn(DVec2) -> bool) -> (DVec2, f64) {
        let edge = |sign: f64| {
            let is_clear = |x: f64| is_clear(start + axis * (sign * x));
            let mut clear = 0.0;
            let mut step = width * 1e-3;
            while is_clear(clear + step) && clear < 4.0 * self.glass_radius {
                clear += step;
                step *= 2.0;
            }
            sign * bisect(clear, clear + step, PRECISION * step, is_clear).0
        };
        let (low, high) = (edge(-1.0), edge(1.0));
        (start + axis * (0.5 * (low + high)), 0.5 * (high - low))
    }

    /// The outline about `centre`, in axes along and across the meridian of the film point (radius, z, azimuth).
    ///
    /// `is_symmetric` spares the half below the meridian; `hint` is the outline of a neighbour.
    pub(super) fn outline(
        &self,
        (film_radius, film_z, azimuth): (f64, f64, f64),
        centre: DVec2,
        is_symmetric: bool,
        hint: Option<&Outline>,
    ) -> Outline {
        let meridian = DVec2::from_angle(azimuth);
        let film = (meridian * film_radius).extend(film_z);
        let centre = meridian.rotate(centre);
        let mut outline = Outline { outer: [0.0; ANGLES], inner: [0.0; ANGLES] };
        let mut previous = self.glass_radius * 0.5;
        for i in 0..ANGLES {
            if is_symmetric && i > ANGLES / 2 {
                outline.outer[i] = outline.outer[ANGLES - i];
                outline.inner[i] = outline.inner[ANGLES - i];
                continue;
            }
            let along = DVec2::from_angle(i as f64 * TAU / ANGLES as f64);
            let is_clear = |x: f64| self.is_open(film, centre + along * x);
            let guess = hint.map_or(previous, |h| h.outer[i]);
            outline.outer[i] = edge_near(guess, 2.0 * self.glass_radius, is_clear);
            previous = outline.outer[i].max(1e-6 * self.glass_radius);
            outline.inner[i] = self.hole(film, centre, along, outline.outer[i]);
        }
        outline
    }

    /// How far from the centre an obstruction reaches.
    fn hole(&self, film: DVec3, centre: DVec2, along: DVec2, outer: f64) -> f64 {
        const STEPS: i32 = 64;
        if self.obstructed.is_empty() {
            return 0.0;
        }
        let is_dark = |x: f64| !passes(&self.obstructed, film, (centre + along * x).extend(self.reference_z));
        let place = |i: i32| outer * f64::from(i) / f64::from(STEPS);
        match (0..=STEPS).find(|&i| !is_dark(place(i))) {
            None => outer,
            Some(0) => 0.0,
            Some(i) => bisect(place(i - 1), place(i), PRECISION * outer, is_dark).0,
        }
    }
}

/// 0, 1, −1, 2, −2, ...
fn alternating(i: usize) -> f64 {
    let half = i.div_ceil(2) as f64;
    if i % 2 == 1 { half } else { -half }
}

/// The last radius that `is_clear`, searched about `guess` up to `limit`; rounded up.
fn edge_near(guess: f64, limit: f64, is_clear: impl Fn(f64) -> bool) -> f64 {
    let mut low = 0.0;
    let mut high = guess.max(1e-9 * limit) * 1.02;
    while high < limit && is_clear(high) {
        low = high;
        high *= 1.25;
    }
    if low == 0.0 {
        let below = high * 0.96;
        if is_clear(below) {
            low = below;
        } else {
            high = below;
        }
    }
    bisect(low, high, PRECISION * high, is_clear).1
}

/// Narrows [low, high], where `holds` at low and not at high, to `precision`; for a high end of at most the precision
/// above 0 it goes on until the ends agree in size.
fn bisect(mut low: f64, mut high: f64, precision: f64, holds: impl Fn(f64) -> bool) -> (f64, f64) {
    let mut steps = 0;
    while high - low > precision && steps < 60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
        steps += 1;
    }
    (low, high)
}
