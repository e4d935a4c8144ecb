//! The plane waves of which the light near a place of the film is made, on a square lattice of their direction cosines.
//!
//! A ray is found for each lattice point, so that no phase is interpolated.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};

use super::wavefront::{Eikonal, ImageRay};
use super::{AnalysedWavelength, FieldView, weight};

/// Rays over the window by which those of the lattice are found, and by which the middle of the light is.
pub(super) const MESH: usize = 41;
/// Newton's steps in a cell of the mesh; each squares the error.
const STEPS: usize = 4;
/// Rays over the side of a cell on the pupil's edge.
const SOFT: usize = 5;

/// A wave of the lattice.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LatticeWave {
    /// Amplitude, by real and imaginary part.
    pub(super) amplitude: DVec2,
    /// The point at which its ray crosses the film: sagittal and tangential, mm.
    pub(super) crossing: DVec2,
}

/// The waves of a wavelength, row by row.
pub(super) struct WaveLattice {
    pub(super) columns: usize,
    pub(super) waves: Vec<LatticeWave>,
}

/// A ray of the mesh: its place in the field's plane, and its direction cosines behind the lens times the index.
#[derive(Clone, Copy)]
struct MeshRay {
    at: DVec2,
    cosines: DVec2,
}

/// A beam of one wavelength behind the lens.
pub(super) struct ImageBeam<'a> {
    view: &'a FieldView,
    line: &'a AnalysedWavelength<'a>,
    eikonal: &'a Eikonal<'a>,
    nodes: Vec<Option<MeshRay>>,
    low: DVec2,
    high: DVec2,
}

impl<'a> ImageBeam<'a> {
    /// The beam of a field; `eikonal` is that of the lens, `mesh` that of the lens without rims. `None`: the field is dark.
    pub(super) fn new(
        view: &'a FieldView,
        line: &'a AnalysedWavelength<'_>,
        eikonal: &'a Eikonal<'_>,
        mesh: &Eikonal<'_>,
    ) -> Option<Self> {
        let node = |i: usize| {
            let at = view.corner([i % MESH, i / MESH], MESH);
            let path = mesh.of(line.probe.origin.ray(&view.field, at))?;
            Some(MeshRay { at, cosines: cosines(eikonal, &path) })
        };
        let nodes: Vec<Option<MeshRay>> = (0..MESH * MESH).map(node).collect();
        // The beam's own, and its neighbours: others may go far aside.
        let is_lit: Vec<bool> = nodes
            .iter()
            .map(|node| node.is_some_and(|n| eikonal.of(line.probe.origin.ray(&view.field, n.at)).is_some()))
            .collect();
        let near = |i: usize, by: usize| i.saturating_sub(by)..(i + by + 1).min(MESH);
        let is_near_lit = |i: &usize| near(i / MESH, 1).any(|y| near(i % MESH, 1).any(|x| is_lit[y * MESH + x]));
        let of_beam = (0..MESH * MESH).filter(is_near_lit).filter_map(|i| nodes[i]);
        let ends = of_beam.map(|node| (node.cosines, node.cosines));
        let (low, high) = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        Some(Self { view, line, eikonal, nodes, low, high })
    }

    /// Vacuum wavelength of the line, mm.
    pub(super) fn wavelength_mm(&self) -> f64 {
        self.line.wavelength_nm * 1e-6
    }

    /// The larger side of the beam, in direction cosines times the index.
    pub(super) fn width(&self) -> f64 {
        (self.high - self.low).max_element()
    }

    /// The waves on a lattice with this step of the direction cosines.
    pub(super) fn waves(&self, cell: f64) -> WaveLattice {
        self.lattice(cell).0
    }

    /// The waves on a lattice with this step of the direction cosines, those on the pupil's edge averaged over their cells: a pupil with
    /// steps would scatter light.
    pub(super) fn waves_with_soft_edge(&self, cell: f64) -> WaveLattice {
        let (lattice, mut found) = self.lattice(cell);
        let columns = lattice.columns;
        let rows = lattice.waves.len() / columns;
        let is_lit = |x: usize, y: usize| lattice.waves[y * columns + x].amplitude != DVec2::ZERO;
        let mut soft = lattice.waves.clone();
        for y in 0..rows {
            for x in 0..columns {
                let around = |i: usize, end: usize| i.saturating_sub(1)..(i + 2).min(end);
                let mut near = around(y, rows).flat_map(|y| around(x, columns).map(move |x| (x, y)));
                let here = is_lit(x, y);
                if near.all(|(x, y)| is_lit(x, y) == here) {
                    continue;
                }
                let part = |i: usize| (i as f64 + 0.5) / SOFT as f64 - 0.5;
                let places = (0..SOFT * SOFT).map(|i| DVec2::new(x as f64 + part(i % SOFT), y as f64 + part(i / SOFT)));
                let waves = places
                    .filter_map(|place| self.wave(self.low + place * cell, found.quad_at(x, y), &mut found.start_mm));
                let sum: DVec2 = waves.map(|wave| wave.amplitude).sum();
                soft[y * columns + x].amplitude = sum / (SOFT * SOFT) as f64;
            }
        }
        WaveLattice { columns, waves: soft }
    }

    /// The wave with these cosines, if a ray finds it in or beside that cell of the mesh. The first that is found has no phase.
    fn wave(&self, target: DVec2, quad: Option<usize>, start_mm: &mut Option<f64>) -> Option<LatticeWave> {
        let quad = quad?;
        let [column, row] = [quad % (MESH - 1), quad / (MESH - 1)];
        let around = |i: usize| [i, i.saturating_sub(1), (i + 1).min(MESH - 2)];
        let mut cells = around(row).into_iter().flat_map(|row| around(column).map(|column| [column, row]));
        let (at, area) = cells.find_map(|cell| find(&self.quad(cell)?, target))?;
        self.ray(target, at, area, start_mm)
    }

    /// The wave of a ray that was found near the cosines.
    fn ray(&self, target: DVec2, at: DVec2, area: f64, start_mm: &mut Option<f64>) -> Option<LatticeWave> {
        let Self { view, line, eikonal, .. } = self;
        let ray = line.probe.origin.ray(&view.field, at);
        let path = eikonal.of(ray)?;
        // From the ray that was found to that of the lattice, by the slope of the path.
        let path_mm = path.path_mm - path.crossing.dot(target - cosines(eikonal, &path));
        let phase = TAU * (path_mm - *start_mm.get_or_insert(path_mm)) / self.wavelength_mm();
        let light = weight(&line.probe.origin, &view.field, &ray) * area;
        Some(LatticeWave { amplitude: DVec2::from_angle(phase) * light.sqrt(), crossing: path.crossing })
    }

    /// The corners of a cell of the mesh.
    fn quad(&self, [column, row]: [usize; 2]) -> Option<[MeshRay; 4]> {
        let corner = |dx: usize, dy: usize| self.nodes[(row + dy) * MESH + column + dx];
        Some([corner(0, 0)?, corner(1, 0)?, corner(0, 1)?, corner(1, 1)?])
    }

    fn lattice(&self, cell: f64) -> (WaveLattice, MeshCells) {
        let low = self.low;
        let [columns, rows] = ((self.high - low) / cell).ceil().to_array().map(|n| n as usize + 1);
        let mut lattice = WaveLattice { columns, waves: vec![LatticeWave::default(); columns * rows] };
        let mut found = MeshCells { columns, quads: vec![None; columns * rows], start_mm: None };
        for i in 0..(MESH - 1) * (MESH - 1) {
            let Some(quad) = self.quad([i % (MESH - 1), i / (MESH - 1)]) else { continue };
            let [from, to] = [DVec2::min, DVec2::max].map(|end: fn(DVec2, DVec2) -> DVec2| {
                let of_all = quad.iter().map(|node| node.cosines).reduce(end).unwrap_or(low);
                (of_all - low) / cell
            });
            // Below 0 and above the end lies what is not the beam's.
            for y in from.y.ceil() as usize..((to.y + 1.0).floor().max(0.0) as usize).min(rows) {
                for x in from.x.ceil() as usize..((to.x + 1.0).floor().max(0.0) as usize).min(columns) {
                    let target = low + DVec2::new(x as f64, y as f64) * cell;
                    let Some((at, area)) = find(&quad, target) else { continue };
                    found.quads[y * columns + x] = Some(i);
                    if let Some(wave) = self.ray(target, at, area, &mut found.start_mm) {
                        lattice.waves[y * columns + x] = wave;
                    }
                }
            }
        }
        (lattice, found)
    }
}

/// The cells of the mesh in which the points of a lattice were found, and the path that counts as none.
struct MeshCells {
    columns: usize,
    quads: Vec<Option<usize>>,
    start_mm: Option<f64>,
}

impl MeshCells {
    /// The quad of a point, or else of a neighbour.
    fn quad_at(&self, x: usize, y: usize) -> Option<usize> {
        let rows = self.quads.len() / self.columns;
        let around = |i: usize, end: usize| i.saturating_sub(1)..(i + 2).min(end);
        let near = around(y, rows).flat_map(|y| around(x, self.columns).map(move |x| (x, y)));
        self.quads[y * self.columns + x].or_else(|| near.filter_map(|(x, y)| self.quads[y * self.columns + x]).next())
    }
}

/// Direction cosines in the plane at the film, times the index.
fn cosines(eikonal: &Eikonal<'_>, path: &ImageRay) -> DVec2 {
    eikonal.touching().cosines(path.out.direction) * eikonal.image_index()
}

/// The place of the field's plane whose ray has these cosines, if it lies in a cell of the mesh, and the plane's area for an area of
/// cosines.
fn find([a, b, c, d]: &[MeshRay; 4], target: DVec2) -> Option<(DVec2, f64)> {
    let blend = |of: fn(&MeshRay) -> DVec2, s: DVec2| {
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

impl FieldView {
    /// A place of the window, `side` by `side` from corner to corner.
    fn corner(&self, [x, y]: [usize; 2], side: usize) -> DVec2 {
        let unit = |i: usize| 2.0 * i as f64 / (side - 1) as f64 - 1.0;
        self.window.centre + self.window.half * DVec2::new(unit(x), unit(y))
    }
}
