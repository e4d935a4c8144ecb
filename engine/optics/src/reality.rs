//! A lens by rays beside measurements of its product: distortion, vignetting and lateral colour of [`lensfun`](crate::lensfun)'s
//! calibrations.
//!
//! A calibration of distortion from pictures of straight lines does not know the scale of the picture: rays and measurement are laid over
//! each other with one free scale, which is the focal length by which the fields were measured.

use glam::DVec2;
use serde::Serialize;

use crate::analysis::Analysis;
use crate::lensfun::lateral_colour::Channel;
use crate::lensfun::{Distortion, LateralColour, Projection, Vignetting};
use crate::sensitivity::Sensitivities;

/// The most steps of a search for a field.
const HALVINGS: usize = 60;
/// A field is found where its height is right to this part.
const CLOSE: f64 = 1e-10;
/// Rays over the width of a beam whose middle is asked for.
const RAYS: usize = 21;
/// Steps by Newton's method for the scale.
const STEPS: usize = 30;

/// A field by its chief ray.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RayField {
    /// Angle from the axis, counted at the entrance pupil.
    pub angle_deg: f64,
    /// Height of the chief ray on the film, mm; above zero.
    pub height_mm: f64,
}

/// Fields whose chief rays come evenly from the axis to `corner_mm` on the film, or as far as there are any.
pub fn fields_to(analysis: &Analysis<'_>, corner_mm: f64, count: usize) -> Vec<RayField> {
    let height = |angle_deg: f64| analysis.chief_ray(angle_deg).map(|ray| ray.height_mm.abs());
    let focal_mm = analysis.height_by_slope_mm().abs();
    let Some(corner) = corner(&height, corner_mm, focal_mm) else { return Vec::new() };
    let mut fields = vec![RayField { angle_deg: 0.0, height_mm: height(0.0).unwrap_or(0.0) }];
    for i in 1..count {
        let wanted_mm = corner.height_mm * i as f64 / (count - 1) as f64;
        let last = fields[fields.len() - 1];
        let found = if i + 1 == count { Some(corner) } else { between(&height, last, corner, wanted_mm) };
        fields.extend(found);
    }
    fields
}

/// The field whose height is `corner_mm`, or the last that has a chief ray.
fn corner(height: &impl Fn(f64) -> Option<f64>, corner_mm: f64, focal_mm: f64) -> Option<RayField> {
    let field = |angle_deg: f64| Some(RayField { angle_deg, height_mm: height(angle_deg)? });
    let straight_deg = (corner_mm / focal_mm).atan().to_degrees();
    let mut inside = field(0.0)?;
    let (mut step, mut next) = (0.25 * straight_deg, 0.25 * straight_deg);
    // Outwards until the corner is passed; in smaller steps where light ends before.
    for _ in 0..HALVINGS {
        match field(next) {
            Some(found) if found.height_mm >= corner_mm => return between(height, inside, found, corner_mm),
            Some(found) if found.height_mm > inside.height_mm => inside = found,
            // No light, or heights that turn back.
            _ => step *= 0.5,
        }
        next = inside.angle_deg + step;
    }
    Some(inside)
}

/// The field between two others whose chief ray comes to a height: regula falsi with halved ends (Dowell and Jarratt 1971, "Illinois").
fn between(height: &impl Fn(f64) -> Option<f64>, low: RayField, high: RayField, wanted_mm: f64) -> Option<RayField> {
    let (mut a, mut b) = (low.angle_deg, high.angle_deg);
    let (mut off_a, mut off_b) = (low.height_mm - wanted_mm, high.height_mm - wanted_mm);
    for _ in 0..HALVINGS {
        let at = b - off_b * (b - a) / (off_b - off_a);
        let angle_deg = if at.is_finite() { at } else { 0.5 * (a + b) };
        let found = RayField { angle_deg, height_mm: height(angle_deg)? };
        let off = found.height_mm - wanted_mm;
        if off.abs() <= CLOSE * wanted_mm {
            return Some(found);
        }
        if (off > 0.0) == (off_b > 0.0) {
            off_a *= 0.5;
        } else {
            (a, off_a) = (b, off_b);
        }
        (b, off_b) = (angle_deg, off);
    }
    Some(RayField { angle_deg: b, height_mm: off_b + wanted_mm })
}

/// Distortion by rays beside a measured one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DistortionBeside {
    /// The focal length that lays one over the other, mm.
    pub scale_mm: f64,
    /// Root mean square of the residual on the film, over its area, mm.
    pub rms_mm: f64,
    /// The largest residual, mm.
    pub worst_mm: f64,
    /// The lens's own distortion: the largest distance, by rays, from the picture without distortion that has the scale of the axis, mm.
    pub own_mm: f64,
    /// The fields.
    pub rows: Vec<DistortionRow>,
}

/// A field of [`DistortionBeside`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DistortionRow {
    /// The field by rays.
    #[serde(flatten)]
    pub field: RayField,
    /// The height on the film by the measurement, mm.
    pub measured_mm: f64,
    /// Distortion by rays, parts of the height without it at the free scale.
    pub rays_part: f64,
    /// Distortion by the measurement, likewise.
    pub measured_part: f64,
}

/// Lays fields over a measured distortion. `focal_mm` is the focal length by rays. `None`: fewer than three fields, or the projection does
/// not show them.
pub fn distortion_beside(
    fields: &[RayField],
    focal_mm: f64,
    measured: &Distortion,
    projection: Projection,
) -> Option<DistortionBeside> {
    let heights = fields.iter().map(|field| projection.height(field.angle_deg.to_radians()));
    let heights = heights.collect::<Option<Vec<f64>>>()?;
    if fields.len() < 3 {
        return None;
    }
    // Least squares over the film's area: each field stands for a ring.
    let mut scale_mm = focal_mm;
    for _ in 0..STEPS {
        let (mut above, mut below) = (0.0, 0.0);
        for (field, height) in fields.iter().zip(&heights) {
            let (value, slope) = measured.radius_mm(scale_mm * height);
            let slope = slope * height;
            above += field.height_mm * slope * (field.height_mm - value);
            below += field.height_mm * slope * slope;
        }
        let step = above / below;
        if !step.is_finite() {
            return None;
        }
        scale_mm += step;
        if step.abs() < 1e-12 * focal_mm {
            break;
        }
    }
    let row = |(field, height): (&RayField, &f64)| {
        let straight_mm = scale_mm * height;
        let measured_mm = measured.radius_mm(straight_mm).0;
        let part = |at_mm: f64| if straight_mm > 0.0 { at_mm / straight_mm - 1.0 } else { 0.0 };
        let (rays_part, measured_part) = (part(field.height_mm), part(measured_mm));
        DistortionRow { field: *field, measured_mm, rays_part, measured_part }
    };
    let rows: Vec<DistortionRow> = fields.iter().zip(&heights).map(row).collect();
    let left = |row: &DistortionRow| row.measured_mm - row.field.height_mm;
    let (sum, squares) = rows.iter().fold((0.0, 0.0), |(sum, squares), row| {
        let w = row.field.height_mm;
        (sum + w, squares + w * left(row).powi(2))
    });
    let own = fields.iter().zip(&heights).map(|(field, height)| (field.height_mm - focal_mm * height).abs());
    Some(DistortionBeside {
        scale_mm,
        rms_mm: if sum > 0.0 { (squares / sum).sqrt() } else { 0.0 },
        worst_mm: rows.iter().map(|row| left(row).abs()).fold(0.0, f64::max),
        own_mm: own.fold(0.0, f64::max),
        rows,
    })
}

/// A place of the film, and its light in stops below that in the middle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VignettingRow {
    /// Angle of the field.
    pub angle_deg: f64,
    /// Height on the film, mm.
    pub height_mm: f64,
    /// Vignetting by rays, stops; below zero.
    pub rays_stops: f64,
    /// Vignetting by the measurement, stops; `None`: its formula leaves no light.
    pub measured_stops: Option<f64>,
}

/// Illumination at these fields beside a measured vignetting.
pub fn vignetting_beside(analysis: &Analysis<'_>, angles_deg: &[f64], measured: &Vignetting) -> Vec<VignettingRow> {
    let row = |found: crate::analysis::illumination::Illumination| {
        let rays_stops = found.relative.filter(|part| *part > 0.0)?.log2();
        let height_mm = found.height_mm.abs();
        let measured_stops = measured.illumination(height_mm).map(f64::log2);
        Some(VignettingRow { angle_deg: found.angle_deg, height_mm, rays_stops, measured_stops })
    };
    analysis.illumination(angles_deg).into_iter().filter_map(row).collect()
}

/// A field, and the distances of red and blue of a camera from green, outwards, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ColourRow {
    /// Angle of the field.
    pub angle_deg: f64,
    /// Height of green on the film, mm.
    pub height_mm: f64,
    /// Red by rays.
    pub red_mm: f64,
    /// Blue by rays.
    pub blue_mm: f64,
    /// Red by the measurement.
    pub measured_red_mm: f64,
    /// Blue by the measurement.
    pub measured_blue_mm: f64,
}

/// Middles of the image of a point in each channel of a camera beside a measured lateral colour.
///
/// The analysis must have the wavelengths of `camera`, in their order. Its light is white of one energy at every wavelength.
pub fn colour_beside(
    analysis: &Analysis<'_>,
    angles_deg: &[f64],
    camera: &Sensitivities,
    measured: &LateralColour,
) -> Vec<ColourRow> {
    let row = |&angle_deg: &f64| {
        let spot = analysis.spot(angle_deg, RAYS)?;
        let (mut sums, mut weights) = ([0.0; 3], [0.0; 3]);
        for (line, (_, sees)) in spot.lines.iter().zip(camera.samples()) {
            // A wavelength of which nothing comes says nothing of its place.
            for i in (0..3).filter(|_| !line.points_mm.is_empty()) {
                sums[i] += sees[i] * (spot.centroid_mm[1] + line.centroid_mm[1]);
                weights[i] += sees[i];
            }
        }
        let [red, green, blue]: [f64; 3] = std::array::from_fn(|i| sums[i] / weights[i]);
        // Outwards, whichever side of the axis the image is on.
        let outwards = if green < 0.0 { -1.0 } else { 1.0 };
        let height_mm = green.abs();
        let from = |channel: Channel| measured.place_mm(channel, DVec2::new(height_mm, 0.0)).x - height_mm;
        let found = ColourRow {
            angle_deg,
            height_mm,
            red_mm: outwards * (red - green),
            blue_mm: outwards * (blue - green),
            measured_red_mm: from(Channel::Red),
            measured_blue_mm: from(Channel::Blue),
        };
        (found.red_mm + found.blue_mm).is_finite().then_some(found)
    };
    angles_deg.iter().filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::{RayField, distortion_beside};
    use crate::lensfun::distortion::DistortionModel;
    use crate::lensfun::{Distortion, Projection, Sensor};

    fn measured() -> Distortion {
        let sensor = Sensor { crop_factor: 1.0, aspect_ratio: 1.5 };
        let model = DistortionModel::PtLens([0.01, -0.04, 0.02]);
        Distortion { model, focal_mm: 24.0, real_focal_mm: 24.0, sensor }
    }

    fn field(angle_deg: f64, focal_mm: f64, beyond: f64) -> RayField {
        let height_mm = measured().radius_mm(focal_mm * angle_deg.to_radians().tan()).0 + beyond;
        RayField { angle_deg, height_mm }
    }

    /// Fields that lie by the formula at another scale leave nothing over, and the scale is found.
    #[test]
    fn the_scale_is_free() {
        let fields: Vec<RayField> = (0..20).map(|i| field(2.0 * f64::from(i), 25.3, 0.0)).collect();
        let found = distortion_beside(&fields, 24.7, &measured(), Projection::Rectilinear).unwrap();
        assert!((found.scale_mm - 25.3).abs() < 1e-9 && found.worst_mm < 1e-9, "{found:?}");
        assert!(found.rows.iter().all(|row| (row.rays_part - row.measured_part).abs() < 1e-9));
        // No picture without distortion has the scale of the axis here: what is its own is more than the free scale could take up.
        assert!(found.own_mm > 0.1, "{}", found.own_mm);
    }

    /// One field that lies 50 um off is the worst, but for the part that the scale takes of it.
    #[test]
    fn what_is_off_is_told() {
        let off = |i: i32| if i == 10 { 0.05 } else { 0.0 };
        let fields: Vec<RayField> = (0..20).map(|i| field(2.0 * f64::from(i), 24.0, off(i))).collect();
        let found = distortion_beside(&fields, 24.0, &measured(), Projection::Rectilinear).unwrap();
        assert!((0.045..0.05).contains(&found.worst_mm) && found.rms_mm < 0.02, "{found:?}");
        assert_eq!(distortion_beside(&fields[..2], 24.0, &measured(), Projection::Rectilinear), None);
    }
}
