//! The lens's picture over that of a pinhole which frames the same, point by point, for a compositor to take the lens's
//! distortion out of a picture, or to put it in.
//!
//! A picture point of the lens stands for the mean of the rays from its film point through all of the clear pupil, at one
//! wavelength. Where it hits the plane that is sharp, the pinhole sees the same thing; a lens focused at infinity is
//! compared by direction. The pinhole is that of [`LensInfo::viewport_focal_length_mm`](crate::camera::lens::setup::LensInfo).

use crate::camera::lens::beam;
use crate::camera::lens::mount::Mount;
use crate::camera::lens::setup::D_LINE_NM;
use crate::camera::models::pinhole::Pinhole;
use crate::camera::{CameraDescription, CameraError};
use glam::{DMat2, DVec2, DVec3};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::pupil_map::PupilMap;
use petzval_optics::trace::Tracer;
use rayon::prelude::*;
use serde::Deserialize;

/// Rays whose mean is a picture point's.
const RAYS: u32 = 1024;
/// Cells over the picture's larger side. Distortion is smooth: cubics between so many are right to some 1e-6 of the picture.
const CELLS: usize = 64;
/// Cells beyond the picture's edge, for places just outside of the picture.
const BEYOND: usize = 4;
/// Newton's method is done or lost after so many steps, and done when so near, parts of the picture.
const MOST_STEPS: u32 = 30;
const FOUND: f64 = 1e-9;
/// Slopes are taken over this part of a cell.
const DIFFERENCE: f64 = 1e-2;

/// The direction of a distortion map: the picture that is made, and the one it is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Direction {
    /// The lens's, of a pinhole's.
    Distort,
    /// A pinhole's, of the lens's.
    Undistort,
}

/// The map, over the lens's picture, from each point to the point at which the pinhole shows the direction that the lens shows there.
/// Picture points as everywhere: from the middle, -1/2 to 1/2.
pub struct DistortionMap {
    mount: Mount,
    pinhole: Pinhole,
    tracer: Tracer,
    pupil: PupilMap,
    /// Lens space, mm; `None`: at infinity.
    sharp_z_mm: Option<f64>,
    cells: [usize; 2],
    /// The nodes, by row, then column.
    nodes: Vec<Option<DVec2>>,
}

impl DistortionMap {
    /// The map for pictures of that many pixels, by light of that wavelength; the lens stays focused as the camera has it.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn new(d: &CameraDescription, [width, height]: [u32; 2], wavelength_nm: f64) -> Result<Self, CameraError> {
        if !d.model.is_of_lens() {
            return Err(d.error("only a lens distorts; choose a camera model that is made from a lens file"));
        }
        if !(100.0..=20_000.0).contains(&wavelength_nm) {
            return Err(d.error(format!("the wavelength is {wavelength_nm} nm; visible light is 380 to 780 nm")));
        }
        d.check(width, height)?;
        let axes = d.axes()?;
        let (mount, system) = Mount::new(d, axes, width, height)?;
        let info = &mount.info;
        let framing = d.clone().with(|c| {
            c.perspective.focal_length_mm = info.viewport_focal_length_mm;
            c.perspective.film_width_mm = info.picture_width_mm;
            c.perspective.shift = info.viewport_shift;
        });
        let pinhole = Pinhole::new(&framing, axes, width, height);
        let pupil_z = Paraxial::new(&system, d.wavelength_nm.unwrap_or(D_LINE_NM)).entrance_pupil.z_mm.unwrap_or(0.0);
        let sharp_z_mm = info.focus_distance_mm.filter(|d| *d > 0.0).map(|distance| pupil_z - distance);
        let tracer = system.at_wavelength(wavelength_nm);
        let part = 1.0 + 2.0 * BEYOND as f64 / CELLS as f64;
        let half = [0.5 * part * info.picture_width_mm, 0.5 * part * info.picture_height_mm];
        let pupil = PupilMap::new(&tracer, &system, &mount.film, half[0], half[1]);
        let larger = f64::from(width.max(height));
        let cells = [width, height].map(|side| ((CELLS as f64 * f64::from(side) / larger).ceil() as usize).max(4));
        let mut map = Self { mount, pinhole, tracer, pupil, sharp_z_mm, cells, nodes: Vec::new() };
        let [columns, rows] = map.counts();
        let node = |i: usize| map.look(map.node_place(i % columns, i / columns));
        map.nodes = (0..columns * rows).into_par_iter().map(node).collect();
        Ok(map)
    }

    fn counts(&self) -> [usize; 2] {
        self.cells.map(|cells| cells + 1 + 2 * BEYOND)
    }

    fn node_place(&self, column: usize, row: usize) -> DVec2 {
        let at = |i: usize, cells: usize| (i as f64 - BEYOND as f64) / cells as f64 - 0.5;
        DVec2::new(at(column, self.cells[0]), at(row, self.cells[1]))
    }

    /// The place in the pinhole's picture of the direction that the lens shows at a picture point, by rays; `None` where no light comes, or
    /// from behind.
    pub fn look(&self, place: DVec2) -> Option<DVec2> {
        let film = &self.mount.film;
        let (u, v) = (-place.x * self.mount.info.picture_width_mm, -place.y * self.mount.info.picture_height_mm);
        if !film.reaches(u, v) {
            return None;
        }
        let through = beam::through(&self.tracer, &self.pupil, self.mount.frame.at(u, v).point, RAYS);
        let mean = beam::mean(through.iter())?;
        let from_origin = match self.sharp_z_mm {
            Some(z) => {
                let steps = (z - mean.origin.z) / mean.direction.z;
                let origin = DVec3::new(0.0, 0.0, self.mount.origin_z_mm());
                (mean.direction.z < 0.0).then(|| mean.origin + mean.direction * steps - origin)?
            }
            None => mean.direction,
        };
        let seen = self.mount.axes().transpose() * (*self.mount.vectors() * from_origin);
        self.pinhole.place(seen).filter(|p| p.is_finite())
    }

    /// The place in the pinhole's picture of the direction that the lens shows at a picture point, by cubics between the rays of the nodes;
    /// where some of these are lost, by [`Self::look`]. `None` where no light comes, or from behind.
    pub fn at(&self, place: DVec2) -> Option<DVec2> {
        let within = |p: f64, cells: usize| {
            let at = (p + 0.5) * cells as f64 + BEYOND as f64;
            let last = (cells + 2 * BEYOND) as f64;
            (at >= 1.0 && at <= last - 1.0).then(|| {
                let cell = (at as usize).min(cells + 2 * BEYOND - 2);
                (cell - 1, cubic(at - cell as f64))
            })
        };
        let (column, across) = within(place.x, self.cells[0])?;
        let (row, up) = within(place.y, self.cells[1])?;
        let columns = self.counts()[0];
        let mut sum = DVec2::ZERO;
        for (j, &v) in up.iter().enumerate() {
            for (i, &u) in across.iter().enumerate() {
                match self.nodes[(row + j) * columns + column + i] {
                    Some(value) => sum += value * (u * v),
                    None => return self.look(place),
                }
            }
        }
        Some(sum)
    }

    /// The place in the lens's picture of the direction that the pinhole shows at a picture point; `None` where the lens does not show it,
    /// or far outside of its picture.
    pub fn back(&self, wanted: DVec2) -> Option<DVec2> {
        // From the middle outwards: the far side of a fold would be found else.
        let mut place = DVec2::ZERO;
        let mut off = self.at(place)? - wanted;
        let step = DIFFERENCE / self.cells[0].max(self.cells[1]) as f64;
        for _ in 0..MOST_STEPS {
            if off.length() < FOUND {
                return Some(place);
            }
            let slope =
                |axis: DVec2| Some((self.at(place + axis * step)? - self.at(place - axis * step)?) / (2.0 * step));
            let full = DMat2::from_cols(slope(DVec2::X)?, slope(DVec2::Y)?).inverse() * -off;
            if !full.is_finite() {
                return None;
            }
            let nearer = |halvings: i32| {
                let next = place + full * 0.5f64.powi(halvings);
                let missed = self.at(next)? - wanted;
                (missed.length() < off.length()).then_some((next, missed))
            };
            (place, off) = (0..8).find_map(nearer)?;
        }
        (off.length() < FOUND.sqrt() * 0.1).then_some(place)
    }

    /// The map for a compositor: for each pixel, first row below, the place in the other picture to take it from, x and y from 0 to
    /// 1 with the origin at the lower left, then twice 1 where that place is in the other picture and 0 where it is not: Blender's Map UV
    /// takes the third number for that, others the fourth. Where the lens sees nothing all four are 0.
    pub fn pixels(&self, [width, height]: [u32; 2], direction: Direction) -> Vec<[f32; 4]> {
        let pixel = |i: u32, side: u32| (f64::from(i) + 0.5) / f64::from(side) - 0.5;
        let of = |x: u32, y: u32| {
            let place = DVec2::new(pixel(x, width), pixel(y, height));
            let source = match direction {
                Direction::Distort => self.at(place),
                Direction::Undistort => self.back(place),
            };
            let Some(source) = source else { return [0.0; 4] };
            let st = source + 0.5;
            let is_within = st.cmpge(DVec2::ZERO).all() && st.cmple(DVec2::ONE).all();
            let is_there = if is_within { 1.0 } else { 0.0 };
            [st.x as f32, st.y as f32, is_there, is_there]
        };
        (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| of(x, y))).collect()
    }
}

/// Weights of four neighbours for a place between the middle two (Catmull and Rom 1974).
fn cubic(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t - t3), 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}

#[cfg(test)]
mod tests;
