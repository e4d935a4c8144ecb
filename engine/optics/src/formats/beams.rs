//! Extents of the beams of a lens on its surfaces, by exact rays in the y-z plane that only the stop limits: design programs open surfaces
//! without a rim of their own by these.

use glam::DVec3;

use crate::interface::{Interface, reflect};
use crate::prescription::NextMedium;
use crate::surface::{Conic, Shape};
use crate::vector::Vector;

use super::draft_row::DraftRow;

/// A file's statement of the width of the beam on the axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum StatedBeam {
    /// Diameter of the entrance pupil, mm.
    EntrancePupil(f64),
    /// Focal length over the diameter of the entrance pupil.
    FNumber(f64),
    /// Sine of the angle to the axis at which its rim leaves the object.
    ObjectNa(f64),
}

/// Rays of one beam. Heights are good to about one in a hundred of the beam.
const RAYS: usize = 200;
/// Half width of the fan of rays before the lens, in half widths of the beam at first order.
const REACH: f64 = 3.0;

/// Rays from one point of the field.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldBeam {
    /// (z, y) of where they come from, or `None`: parallel.
    pub(super) origin: Option<[f64; 2]>,
    /// Slope of the chief ray, at first order.
    pub(super) slope: f64,
    /// The height at which the chief ray hits the first vertex plane, and the beam's half width there.
    pub(super) middle: f64,
    pub(super) half_width: f64,
    /// Parts of the stop's radius that are left below and above.
    pub(super) left: [f64; 2],
}

/// The largest heights on the surfaces, mm, of the rays of `sheaf` that pass the stop; `None` if none does.
pub(super) fn heights(rows: &[DraftRow], stop: usize, wavelength_nm: f64, sheaf: &FieldBeam) -> Option<Vec<f64>> {
    let mut largest = vec![0.0f64; rows.len()];
    let mut any = false;
    let semi = rows[stop].semi_diameter_mm.unwrap_or(0.0);
    let [below, above] = sheaf.left;
    for i in 0..=RAYS {
        let y = sheaf.middle + sheaf.half_width * REACH * (2.0 * i as f64 / RAYS as f64 - 1.0);
        let start = DVec3::new(0.0, y, 0.0);
        let direction = match sheaf.origin {
            None => DVec3::new(0.0, sheaf.slope, 1.0),
            Some([z, from]) => DVec3::new(0.0, y - from, -z),
        };
        let Some(direction) = direction.try_normalize() else { continue };
        let Some(hits) = follow(rows, wavelength_nm, start, direction) else { continue };
        if (-below * semi..=above * semi).contains(&hits[stop]) {
            any = true;
            for (largest, height) in largest.iter_mut().zip(&hits) {
                *largest = largest.max(height.abs());
            }
        }
    }
    any.then_some(largest)
}

/// The height on the stop, mm, of the widest ray from the middle of an object at `object_mm` before the first vertex that passes all other rims
/// that are known; `None` if no rim is known or none limits the beam.
pub(super) fn widest_through_rims(rows: &[DraftRow], stop: usize, wavelength_nm: f64, object_mm: f64) -> Option<f64> {
    /// Steps of the search from the axis outwards, and halvings of the last one.
    const STEPS: [usize; 2] = [300, 40];
    let known = |i: usize| rows[i].semi_diameter_mm.filter(|semi| i != stop && semi.is_finite() && *semi > 0.0);
    let rims: Vec<Option<f64>> = (0..rows.len()).map(known).collect();
    let largest = rims.iter().flatten().copied().fold(0.0, f64::max);
    let on_stop = |y: f64| {
        let towards = if object_mm.is_finite() { DVec3::new(0.0, y, object_mm) } else { DVec3::Z };
        let hits = follow(rows, wavelength_nm, DVec3::new(0.0, y, 0.0), towards.try_normalize()?)?;
        let passes = hits.iter().zip(&rims).all(|(hit, rim)| rim.is_none_or(|rim| hit.abs() <= rim));
        passes.then(|| hits[stop].abs())
    };
    let step = REACH * largest / STEPS[0] as f64;
    let blocked = (1..=STEPS[0]).find(|i| on_stop(*i as f64 * step).is_none())?;
    let [mut low, mut high] = [blocked - 1, blocked].map(|i| i as f64 * step);
    for _ in 0..STEPS[1] {
        let middle = 0.5 * (low + high);
        *(if on_stop(middle).is_some() { &mut low } else { &mut high }) = middle;
    }
    on_stop(low).filter(|semi| *semi > 0.0)
}

/// Heights at the surfaces of a ray that is stopped by no rim; `None` if it misses one or is reflected totally.
fn follow(rows: &[DraftRow], wavelength_nm: f64, start: DVec3, direction: DVec3) -> Option<Vec<f64>> {
    let (mut origin, mut direction) = (Vector::from_f64(start), Vector::from_f64(direction));
    let (mut side, mut medium) = (1.0, 1.0);
    let mut hits = Vec::with_capacity(rows.len());
    for row in rows {
        let base = Conic { curvature: row.curvature, conic: row.conic };
        let shape = Shape::from_numbers(base, &row.terms, row.radius_x_mm);
        let crossing = shape.intersect(origin, direction, side).ok()?;
        hits.push(crossing.point.of(0).y);
        match &row.behind {
            NextMedium::Mirror => {
                direction = reflect(direction, &crossing, side);
                side = -side;
            }
            NextMedium::Medium(to) => {
                let to = to.index(wavelength_nm);
                let (bent, passes) = Interface::new(medium, to).refract(direction, &crossing, side);
                if !passes {
                    return None;
                }
                (direction, medium) = (bent, to);
            }
        }
        origin = Vector::from_f64(crossing.point.of(0) - DVec3::Z * row.thickness_mm);
    }
    hits.iter().all(|y| y.is_finite()).then_some(hits)
}
