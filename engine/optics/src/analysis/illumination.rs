//! Illumination of the film off the axis: the light of a scene that is equally bright everywhere.

use glam::{DVec2, DVec3};

use serde::Serialize;

use super::{Analysis, Touching, centroid};
use crate::trace::{Ray, Travel};

/// Rays of the beam by which its directions are known, and rays from the film, along a side.
const MESH: usize = 41;
const SIDE: usize = 256;
/// Directions from the film are looked at with so much about them, of their extent: again if light comes from the edge, or from less than
/// a part of them.
const MARGIN: f64 = 0.08;
const CLOSE: f64 = 0.7;
const TRIES: usize = 40;
/// The beam of a field may have one direction alone, where the film is far from sharp.
const LEAST: f64 = 1e-4;

/// Light at a place of the film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Illumination {
    /// Angle of the field.
    pub angle_deg: f64,
    /// Tangential height of the field's light on the film, mm from the axis.
    pub height_mm: f64,
    /// Irradiance over that on the axis. `None` where the axis is dark: a mirror in front hides it.
    pub relative: Option<f64>,
    /// Projected solid angle of the light, sr.
    pub projected_sr: f64,
}

impl Analysis<'_> {
    /// Illumination of the film by these fields, at the main wavelength; fields from which nothing comes are left out.
    pub fn illumination(&self, angles_deg: &[f64]) -> Vec<Illumination> {
        let axis = self.lit(0.0).map(|found| found.projected_sr).filter(|sr| *sr > 0.0);
        let relative = |found: Illumination| Illumination { relative: axis.map(|sr| found.projected_sr / sr), ..found };
        angles_deg.iter().filter_map(|&angle| self.lit(angle)).map(relative).collect()
    }

    fn lit(&self, angle_deg: f64) -> Option<Illumination> {
        let view = self.view(angle_deg)?;
        let landings = self.landings(self.main, &view, MESH);
        let (sum, film) = centroid(landings.iter().map(|landing| (landing.film, landing.weight)));
        if sum <= 0.0 {
            return None;
        }
        let touching = self.touching(film);
        let normal = touching.sagittal.cross(touching.tangential);
        let towards_film = normal * normal.dot(landings.first()?.out.direction).signum();
        let from = landings.iter().map(|landing| touching.cosines(landing.out.direction));
        let mut seen = Directions::about(from)?.grown(MARGIN);
        for _ in 0..TRIES {
            let cell = (seen.high - seen.low) / SIDE as f64;
            let through = self.through(&touching, towards_film, &seen, cell);
            let Some(lit) = Directions::about(through.iter().copied()) else {
                seen = seen.grown(1.0);
                continue;
            };
            let is_whole = (lit.low - seen.low).cmpge(cell).all() && (seen.high - lit.high).cmpge(cell).all();
            let is_close = (lit.high - lit.low).cmpge((seen.high - seen.low) * CLOSE).all();
            if is_whole && is_close {
                let projected_sr = through.len() as f64 * cell.x * cell.y;
                let height_mm = self.turned(film).y;
                return Some(Illumination { angle_deg, height_mm, relative: None, projected_sr });
            }
            seen = if is_whole { lit.grown(MARGIN) } else { seen.grown(0.5) };
        }
        None
    }

    /// The directions in the middles of the cells whose light comes to the film's place.
    fn through(&self, touching: &Touching, towards_film: DVec3, seen: &Directions, cell: DVec2) -> Vec<DVec2> {
        let tracer = &self.lines[self.main].tracer;
        let mut bundle = tracer.bundle(Travel::FromFilm);
        let mut cosines = Vec::with_capacity(SIDE * SIDE);
        for i in 0..SIDE * SIDE {
            let c = seen.low + cell * DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5);
            let along = 1.0 - c.length_squared();
            if along > 0.0 {
                let direction = touching.sagittal * c.x + touching.tangential * c.y + towards_film * along.sqrt();
                bundle.push(Ray { origin: touching.point, direction: -direction });
                cosines.push(c);
            }
        }
        tracer.trace(&mut bundle);
        cosines.iter().enumerate().filter(|(i, _)| bundle.result(*i).is_ok()).map(|(_, c)| *c).collect()
    }
}

/// Directions of light at a place of the film: cosines to the sagittal and the tangential direction.
#[derive(Clone, Copy)]
struct Directions {
    low: DVec2,
    high: DVec2,
}

impl Directions {
    /// The range of the given direction cosines; `None` if there are none.
    fn about(cosines: impl Iterator<Item = DVec2>) -> Option<Self> {
        let ends = cosines.map(|c| Self { low: c, high: c });
        ends.reduce(|a, b| Self { low: a.low.min(b.low), high: a.high.max(b.high) })
    }

    /// Wider on each side by a part of the extent.
    fn grown(self, part: f64) -> Self {
        let extent = self.high - self.low;
        let room = (extent * part).max(DVec2::splat(extent.max_element().max(LEAST) * 0.1 * part));
        Self { low: self.low - room, high: self.high + room }
    }
}
