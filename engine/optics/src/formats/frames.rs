//! Coordinates that design programs tilt and decentre: from the frames of a file to surfaces posed beside one straight axis.
//!
//! A file says of each surface how its frame follows from that of the surface before: by a change before the surface, the surface's
//! thickness along z, and a change after it. Plane mirrors that fold the axis are unfolded: everything behind one is mirrored in its plane,
//! and the mirror is left out. Surfaces that then stand beside the axis of the first one are posed there ([`crate::surface::Pose`]).

use glam::{DAffine3, DMat3, DVec3};

use super::draft::Draft;
use super::problem::{LensFileError, Problem};
use crate::prescription::NextMedium;
use crate::surface::Pose;

/// Turns beyond this make a plane mirror one that folds the axis, rad.
const FOLD_RAD: f64 = 0.02;
/// A film that is turned farther than this is not seen by the lens on its axis.
const FILM_DEG: f64 = 60.0;
/// Rounding of a file's angles, rad, and places, mm.
const NO_TURN: f64 = 1e-9;
const NO_MOVE_MM: f64 = 1e-9;

/// A change of coordinates as CODE V and Zemax count it: moved in the frame before, then turned about its new x, y and z by angles in
/// degrees, those about x and y left-handed (Hayford, ray-optics, `misc_math.euler2opt`, follows both programs).
pub(super) fn change(moved_mm: DVec3, [alpha_deg, beta_deg, gamma_deg]: [f64; 3]) -> DAffine3 {
    DAffine3::from_mat3_translation(turn([alpha_deg, beta_deg, gamma_deg]), moved_mm)
}

/// The change of frame with the turns first, about z, y and x, and the move in the turned frame: Zemax's order flag 1.
pub(super) fn change_turned_first(moved_mm: DVec3, [alpha_deg, beta_deg, gamma_deg]: [f64; 3]) -> DAffine3 {
    let [x, y, z] = [-alpha_deg, -beta_deg, gamma_deg].map(f64::to_radians);
    let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
    DAffine3::from_mat3(turn) * DAffine3::from_translation(moved_mm)
}

fn turn([alpha_deg, beta_deg, gamma_deg]: [f64; 3]) -> DMat3 {
    let [x, y, z] = [-alpha_deg, -beta_deg, gamma_deg].map(f64::to_radians);
    DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z)
}

/// A mirroring in the plane z = 0 of a frame.
fn mirroring(frame: DAffine3) -> DAffine3 {
    let flip = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)));
    frame * flip * frame.inverse()
}

/// A frame with its z along the light that runs towards +z: left-handed ones, which a mirroring leaves, are turned round.
fn right_handed(frame: DAffine3) -> (DAffine3, bool) {
    if frame.matrix3.determinant() > 0.0 {
        return (frame, false);
    }
    let mut turned = frame;
    turned.matrix3.z_axis = -turned.matrix3.z_axis;
    (turned, true)
}

impl Draft<'_> {
    /// Poses the surfaces of a file whose frames are tilted or decentred beside one straight axis, folds undone.
    pub(super) fn unfold(&mut self) -> Result<(), LensFileError> {
        let is_straight = self.film_frame == DAffine3::IDENTITY
            && self.rows.iter().all(|row| row.before == DAffine3::IDENTITY && row.after == DAffine3::IDENTITY);
        if is_straight {
            return Ok(());
        }
        // Unfolded, the axis goes straight on along z, however the file's coordinates are turned between its mirrors.
        let (mut here, mut unfolded) = (DAffine3::IDENTITY, DAffine3::IDENTITY);
        let mut frames: Vec<(DAffine3, bool)> = Vec::with_capacity(self.rows.len());
        let mut folds = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            let own = here * row.before;
            let frame = unfolded * own;
            let is_plane =
                row.curvature == 0.0 && row.terms.iter().all(|(_, a)| *a == 0.0) && row.radius_x_mm.is_none();
            let is_fold = is_plane
                && matches!(row.behind, NextMedium::Mirror)
                && frame.matrix3.z_axis.cross(DVec3::Z).length() > FOLD_RAD;
            if is_fold {
                if self.stop == Some(i) {
                    let what = "the stop is a mirror that folds the axis; put the stop on a plane beside it".to_owned();
                    return self.fail(row.place, Problem::Unsupported(what));
                }
                unfolded = mirroring(frame) * unfolded;
                folds.push(i);
            }
            frames.push(right_handed(frame));
            here = own * row.after * DAffine3::from_translation(DVec3::Z * row.thickness_mm);
        }
        if let Some(configurations) = self.configurations.take() {
            let what = "the lens is tilted or folded: its configurations are left out, and it is read as it stands in the surfaces";
            self.remarks.say(configurations.place, what);
        }
        let (film, _) = right_handed(unfolded * here * self.film_frame);
        self.check_film(&film)?;
        self.pose(&frames, &film);
        self.leave_out(&folds);
        Ok(())
    }

    /// Gives each row the place of its frame on the axis, and its pose beside that.
    fn pose(&mut self, frames: &[(DAffine3, bool)], film: &DAffine3) {
        let places: Vec<f64> = frames.iter().map(|(frame, _)| frame.translation.z).collect();
        if let Some(first) = places.first() {
            self.object_mm += first;
        }
        for (i, row) in self.rows.iter_mut().enumerate() {
            let (frame, is_turned_round) = frames[i];
            row.thickness_mm = places.get(i + 1).copied().unwrap_or(film.translation.z) - places[i];
            let beside = frame.translation - DVec3::Z * places[i];
            let is_on_axis = beside.length() < NO_MOVE_MM && !is_turned(&frame.matrix3);
            row.pose = if is_on_axis { Pose::identity() } else { Pose::new(beside, frame.matrix3) };
            if is_turned_round {
                row.curvature = -row.curvature;
                row.radius_x_mm = row.radius_x_mm.map(|radius| -radius);
                row.terms.iter_mut().for_each(|(_, a)| *a = -*a);
            }
        }
    }

    /// Takes out the mirrors that were unfolded.
    fn leave_out(&mut self, folds: &[usize]) {
        if folds.is_empty() {
            return;
        }
        let place = self.rows[folds[0]].place;
        let count = folds.len();
        let mirrors = if count == 1 { "a plane mirror is".to_owned() } else { format!("{count} plane mirrors are") };
        self.remarks.say(place, format!("{mirrors} unfolded: the light goes straight on, and their rims are left out"));
        for &fold in folds.iter().rev() {
            let row = self.rows.remove(fold);
            match fold.checked_sub(1) {
                Some(before) => self.rows[before].thickness_mm += row.thickness_mm,
                None => self.object_mm += row.thickness_mm,
            }
            if let Some(stop) = &mut self.stop {
                *stop -= usize::from(*stop > fold);
            }
        }
    }

    /// Says how the file's film stands beside the axis, where the film of a lens is that is not turned.
    fn check_film(&mut self, film: &DAffine3) -> Result<(), LensFileError> {
        let place = self.rows.last().map_or(crate::prescription::Place { line: 1, column: 1 }, |row| row.place);
        let normal = film.matrix3.z_axis;
        let turned_deg = normal.cross(DVec3::Z).length().atan2(normal.z.abs()).to_degrees();
        if turned_deg > FILM_DEG {
            let what = format!(
                "the film stands at {turned_deg:.1} degrees to the axis of the first surface; only plane mirrors are unfolded: bend the \
                 axis at no other surface"
            );
            return self.fail(place, Problem::Unsupported(what));
        }
        let [x, y] = [film.translation.x, film.translation.y];
        if turned_deg.to_radians() > NO_TURN || x.hypot(y) > NO_MOVE_MM {
            self.remarks.say(
                place,
                format!(
                    "the file's film is turned by {turned_deg:.4} degrees and stands ({x:.4}, {y:.4}) mm beside the axis; here it stands \
                     upright on it: tilt and shift it in the camera"
                ),
            );
        }
        Ok(())
    }
}

/// True if a rotation turns anything.
fn is_turned(rotation: &DMat3) -> bool {
    (*rotation - DMat3::IDENTITY).to_cols_array().iter().any(|x| x.abs() > NO_TURN)
}
