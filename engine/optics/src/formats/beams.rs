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
