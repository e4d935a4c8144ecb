//! Modulation transfer: how much of the contrast of fine lines is left on the film, by diffraction and by rays alone.
//!
//! The light near a place of the film is a sum of plane waves over their direction cosines (α, β), of phase 2π W / λ
//! ([`super::wavefront`]). Its power spectrum at the frequency ν along α is the autocorrelation of that sum for the shift λ ν: Duffieux's
//! integral (Goodman, Introduction to Fourier Optics, 4th ed., section 7.3), here without the approximation of small angles and over the pupil
//! as rays find it. The waves are taken on a square lattice whose cell goes into λ ν a whole number of times, so that no phase is interpolated: a
//! ray is found for each lattice point.

use glam::{DMat2, DVec2};
use thiserror::Error;

use super::wavefront::{Eikonal, Path};
use super::{Analysis, Line, View, centroid, weight};

/// Rays over the window by which those of the lattice are found, and by which the middle of the light is.
const MESH: usize = 41;
/// Cells of the lattice over the larger side of the beam: at least, and at most.
const LATTICE: [f64; 2] = [128.0, 2048.0];
/// Newton's steps in a cell of the mesh; each squares the error.
const STEPS: usize = 4;

/// Why there is no transfer function.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MtfError {
    /// The field is dark.
    #[error("nothing comes through the lens to the film from there")]
    Dark,
    /// The lattice would be too large.
    #[error(
        "frequencies {step_per_mm} lines/mm apart are too near each other for so wide a beam; give steps of {least_per_mm:.2} or more"
    )]
    TooFine {
        /// As asked for.
        step_per_mm: f64,
        /// The finest possible.
        least_per_mm: f64,
    },
}

/// Contrast left of line pairs, from 0 to 1, by frequency: 0, `step`, 2 `step`... All wavelengths together.
#[derive(Clone, Debug, PartialEq)]
pub struct Mtf {
    /// The field's angle.
    pub angle_deg: f64,
    /// Where its light is on the film, from the middle: tangential, mm.
    pub height_mm: f64,
    /// Of lines that run tangentially: the frequency is sagittal.
    pub sagittal: Curve,
    /// Of lines that run sagittally.
    pub tangential: Curve,
}

/// In one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// With aberrations and diffraction.
    pub contrast: Vec<f64>,
    /// With aberrations alone, as rays have it.
    pub geometric: Vec<f64>,
    /// With diffraction alone: the same pupil without aberrations, colour by colour.
    pub limit: Vec<f64>,
}

/// A wave of the lattice.
#[derive(Clone, Copy, Debug, Default)]
struct Wave {
    /// Amplitude, by real and imaginary part.
    amplitude: DVec2,
    /// Where its ray crosses the film: sagittal and tangential, mm.
    crossing: DVec2,
}

/// The waves of a wavelength, row by row.
struct Lattice {
    columns: usize,
    waves: Vec<Wave>,
    /// Cells that a step of the frequency is.
    cells: usize,
}

/// A transfer function that is being summed: complex numbers.
#[derive(Clone, Debug)]
struct Sum {
    contrast: Vec<DVec2>,
    geometric: Vec<DVec2>,
    limit: Vec<DVec2>,
}

impl Analysis<'_> {
    /// Of a field, at `count` frequencies from 0 on, `step_per_mm` line pairs on a millimetre of film apart.
    ///
    /// # Errors
    /// [`MtfError`].
    pub fn mtf(&self, angle_deg: f64, step_per_mm: f64, count: usize) -> Result<Mtf, MtfError> {
        let view = self.view(angle_deg).ok_or(MtfError::Dark)?;
        let landings = (0..self.lines.len()).flat_map(|line| self.landings(line, &view, MESH));
        let (sum, middle) = centroid(landings.map(|landing| (landing.film, landing.weight)));
        if sum <= 0.0 {
            return Err(MtfError::Dark);
        }
        let none = Sum::new(count);
        let mut all = [none.clone(), none];
        for line in &self.lines {
            let eikonal = Eikonal::new(self.system, &line.tracer, self.touching(middle));
            let mesh = Eikonal::new(self.system, &line.probe.tracer, self.touching(middle));
            let lattice = Lattice::new(&view, line, &eikonal, &mesh, step_per_mm)?;
            // Sagittal lattice neighbours lie side by side.
            for (of_axis, axis) in all.iter_mut().zip([DVec2::X, DVec2::Y]) {
                of_axis.add(&lattice, axis, step_per_mm);
            }
        }
        let [sagittal, tangential] = all.map(|sum| sum.curve());
        Ok(Mtf { angle_deg, height_mm: self.turned(middle).y, sagittal, tangential })
    }
}

/// A ray of the mesh: its place in the field's plane, and its direction cosines behind the lens times the index.
#[derive(Clone, Copy)]
struct Node {
    at: DVec2,
    cosines: DVec2,
}

impl Lattice {
    fn new(
        view: &View,
        line: &Line<'_>,
        eikonal: &Eikonal<'_>,
        mesh: &Eikonal<'_>,
        step_per_mm: f64,
    ) -> Result<Self, MtfError> {
        let cosines = |path: &Path| eikonal.touching().cosines(path.out.direction) * eikonal.image_index();
        let node = |i: usize| {
            let at = view.corner([i % MESH, i / MESH], MESH);
            let path = mesh.of(line.probe.origin.ray(&view.field, at))?;
            Some(Node { at, cosines: cosines(&path) })
        };
        let nodes: Vec<Option<Node>> = (0..MESH * MESH).map(node).collect();
        // The beam's own, and its neighbours: others may go far aside.
        let is_lit: Vec<bool> = nodes
            .iter()
            .map(|node| node.is_some_and(|n| eikonal.of(line.probe.origin.ray(&view.field, n.at)).is_some()))
            .collect();
        let near = |i: usize, by: usize| i.saturating_sub(by)..(i + by + 1).min(MESH);
        let is_near_lit = |i: &usize| near(i / MESH, 1).any(|y| near(i % MESH, 1).any(|x| is_lit[y * MESH + x]));
        let of_beam = (0..MESH * MESH).filter(is_near_lit).filter_map(|i| nodes[i]);
        let ends = of_beam.map(|node| (node.cosines, node.cosines));
        let (low, high) = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).ok_or(MtfError::Dark)?;
        let wavelength_mm = line.wavelength_nm * 1e-6;
        let shift = wavelength_mm * step_per_mm;
        let width = (high - low).max_element();
        let [least, most] = LATTICE;
        if width > shift * most {
            return Err(MtfError::TooFine { step_per_mm, least_per_mm: width / (most * wavelength_mm) });
        }
        let cells = (least * shift / width).ceil().max(1.0);
        let cell = shift / cells;
        let [columns, rows] = ((high - low) / cell).ceil().to_array().map(|n| n as usize + 1);
        let mut lattice = Self { columns, waves: vec![Wave::default(); columns * rows], cells: cells as usize };
        let mut start_mm = None;
        for i in 0..(MESH - 1) * (MESH - 1) {
            let [column, row] = [i % (MESH - 1), i / (MESH - 1)];
            let corner = |dx: usize, dy: usize| nodes[(row + dy) * MESH + column + dx];
            let (Some(a), Some(b), Some(c), Some(d)) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)) else {
                continue;
            };
            let quad = [a, b, c, d];
            let [from, to] = [DVec2::min, DVec2::max].map(|end: fn(DVec2, DVec2) -> DVec2| {
                let of_all = quad.iter().map(|node| node.cosines).reduce(end).unwrap_or(low);
                (of_all - low) / cell
            });
            // Below 0 and above the end lies what is not the beam's.
            for y in from.y.ceil() as usize..((to.y + 1.0).floor().max(0.0) as usize).min(rows) {
                for x in from.x.ceil() as usize..((to.x + 1.0).floor().max(0.0) as usize).min(columns) {
                    let target = low + DVec2::new(x as f64, y as f64) * cell;
                    let Some((at, area)) = find(&quad, target) else { continue };
                    let ray = line.probe.origin.ray(&view.field, at);
                    let Some(path) = eikonal.of(ray) else { continue };
                    // From the ray that was found to that of the lattice, by the slope of the path.
                    let path_mm = path.path_mm - path.crossing.dot(target - cosines(&path));
                    let phase = std::f64::consts::TAU * (path_mm - *start_mm.get_or_insert(path_mm)) / wavelength_mm;
                    let light = weight(&line.probe.origin, &view.field, &ray) * area;
                    lattice.waves[y * columns + x] =
                        Wave { amplitude: DVec2::from_angle(phase) * light.sqrt(), crossing: path.crossing };
                }
            }
        }
        Ok(lattice)
    }
}

/// The place of the field's plane whose ray has these cosines, if it lies in a cell of the mesh, and the plane's area for an area of cosines.
fn find([a, b, c, d]: &[Node; 4], target: DVec2) -> Option<(DVec2, f64)> {
    let blend = |of: fn(&Node) -> DVec2, s: DVec2| {
        let [a, b, c, d] = [a, b, c, d].map(of);
        let value = a + (b - a) * s.x + (c - a) * s.y + (a - b - c + d) * (s.x * s.y);
        let slope = DMat2::from_cols(b - a + (a - b - c + d) * s.y, c - a + (a - b - c + d) * s.x);
        (value, slope)
    };
    let mut s = DVec2::splat(0.5);
    for _ in 0..STEPS {
        let (value, slope) = blend(|node| node.cosines, s);
        s += slope.inverse() * (target - value);
    }
    // Each place of a mesh belongs to one cell.
    let is_inside = s.cmpge(DVec2::ZERO).all() && s.cmplt(DVec2::ONE).all();
    let (at, by_place) = blend(|node| node.at, s);
    let (_, by_cosines) = blend(|node| node.cosines, s);
    let area = (by_place.determinant() / by_cosines.determinant()).abs();
    (is_inside && area.is_finite()).then_some((at, area))
}

impl Sum {
    fn new(count: usize) -> Self {
        let zeros = vec![DVec2::ZERO; count];
        Self { contrast: zeros.clone(), geometric: zeros.clone(), limit: zeros }
    }

    /// A wavelength, weighted by nothing but itself.
    fn add(&mut self, lattice: &Lattice, axis: DVec2, step_per_mm: f64) {
        let Lattice { columns, waves, cells } = lattice;
        let light: f64 = waves.iter().map(|wave| wave.amplitude.length_squared()).sum();
        if light <= 0.0 {
            return;
        }
        for i in 0..self.contrast.len() {
            let shift = i * cells;
            // Two waves a shift apart in this direction, in the same row or column.
            let (ahead, within) = match axis == DVec2::X {
                true => (shift, columns.saturating_sub(shift)),
                false => (shift * columns, *columns),
            };
            let (mut with, mut without) = (DVec2::ZERO, 0.0);
            for (row, later) in waves.chunks(*columns).zip(waves.get(ahead..).unwrap_or_default().chunks(*columns)) {
                for (a, b) in row.iter().zip(later).take(within) {
                    let (a, b) = (a.amplitude, b.amplitude);
                    // b times the conjugate of a.
                    with += DVec2::new(a.dot(b), a.perp_dot(b));
                    without += a.length() * b.length();
                }
            }
            self.contrast[i] += with / light;
            self.limit[i].x += without / light;
        }
        for wave in waves.iter().filter(|wave| wave.amplitude != DVec2::ZERO) {
            let turn = DVec2::from_angle(-std::f64::consts::TAU * step_per_mm * wave.crossing.dot(axis));
            let mut phasor = DVec2::X * (wave.amplitude.length_squared() / light);
            for sum in &mut self.geometric {
                *sum += phasor;
                phasor = phasor.rotate(turn);
            }
        }
    }

    fn curve(self) -> Curve {
        let modulus = |sums: &[DVec2]| {
            let whole = sums.first().map_or(0.0, |sum| sum.length());
            sums.iter().map(|sum| if whole > 0.0 { sum.length() / whole } else { 0.0 }).collect()
        };
        Curve { contrast: modulus(&self.contrast), geometric: modulus(&self.geometric), limit: modulus(&self.limit) }
    }
}

impl View {
    /// A place of the window, `side` by `side` from corner to corner.
    fn corner(&self, [x, y]: [usize; 2], side: usize) -> DVec2 {
        let unit = |i: usize| 2.0 * i as f64 / (side - 1) as f64 - 1.0;
        self.window.centre + self.window.half * DVec2::new(unit(x), unit(y))
    }
}
