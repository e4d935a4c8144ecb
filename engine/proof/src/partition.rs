//! The partition of the rays of a lens, made finer where the most is undecided, until little enough is.

use std::collections::HashMap;
use std::time::Instant;

use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use thiserror::Error;

use crate::chart::{Centre, Chart, Floor};
use crate::column::{CELL, Column, View};
use crate::index::{NoIndex, ends_nm, index};
use crate::passage::{Fate, Indices};
use crate::table::VARIABLES;
use crate::taylor::Taylor;
use petzval_optics::focus::FilmPlane;
use petzval_optics::pupil_map::glass_radius;
use petzval_optics::system::{Element, System};
use petzval_optics::trace::{Action, Step, Tracer, Travel};

/// The reason why nothing is proved about a lens.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProofError {
    /// Something about the lens is not covered.
    #[error("surface {surface} is not covered by proofs: {why}")]
    Surface {
        /// Index of the surface, counted from the scene.
        surface: usize,
        /// The kind of surface or glass that no proof covers.
        why: &'static str,
    },
    /// The diaphragm has blades or a mask.
    #[error("proofs cover round diaphragms; leave out blades and mask")]
    Diaphragm,
    /// A number is out of range.
    #[error("{0}")]
    OutOfRange(String),
}

/// The request of a proof.
#[derive(Clone, Copy, Debug)]
pub struct ProofOptions {
    /// Radius of the film's disc, mm.
    pub film_radius_mm: f64,
    /// The shortest and the longest wavelength, nm.
    pub wavelengths_nm: [f64; 2],
    /// Part of the volume that may be left undecided.
    pub undecided: f64,
    /// Time limit, s: the proof ends with the cells that are decided by then.
    pub seconds: f64,
    /// Number of threads, 0: one for each processor; the result depends on it only where the time ends it.
    pub threads: usize,
}

/// The proof about a lens: the partition and the fates of its cells.
#[derive(Clone, Debug)]
pub struct Proof {
    /// The rays.
    pub chart: Chart,
    /// Centres, by slab of film radius.
    pub centres: Vec<Centre>,
    /// The columns; their floors fill film radius, rim and wavelengths.
    pub columns: Vec<Column>,
    /// Part of the volume that is undecided.
    pub undecided: f64,
    /// Part of the volume that passes.
    pub passes: f64,
    /// Seconds taken.
    pub seconds: f64,
}

/// Slabs of film radius, each with its own centre.
const SLABS: usize = 8;
/// Parts of the rim, at first.
const RIM_PARTS: usize = 4;
/// Parts of the wavelengths, at first.
const WAVELENGTH_PARTS: usize = 2;
/// Columns that are halved together.
const BATCH: usize = 64;
/// Layers thinner than this part of the allowed undecided share are not cut again.
const THINNEST: f64 = 0.1;

struct Lens<'a> {
    system: &'a System,
    chart: Chart,
    centres: Vec<Centre>,
    steps: Vec<Step>,
    thinnest: f64,
    /// Tracers by the bits of their wavelengths.
    tracers: HashMap<u64, Tracer>,
}

/// Proves fates of the rays between a film at `film` (upright) and the lens, on their way to the scene.
///
/// # Errors
/// [`ProofError`]: the lens has something that proofs do not cover, or a number is out of range.
pub fn prove(system: &System, film: &FilmPlane, options: &ProofOptions) -> Result<Proof, ProofError> {
    let began = Instant::now();
    // There are never more columns to prove at a time.
    let threads = ThreadPoolBuilder::new().num_threads(options.threads.min(2 * BATCH)).build();
    let threads = threads.map_err(|error| ProofError::OutOfRange(format!("{} threads: {error}", options.threads)))?;
    let mut lens = Lens::new(system, film, options)?;
    let whole = lens.chart.whole_volume();
    let mut columns = threads.install(|| lens.all(&lens.floors()))?;
    loop {
        let left: f64 = columns.iter().map(|column| column.undecided).sum();
        if left <= options.undecided * whole || began.elapsed().as_secs_f64() > options.seconds {
            break;
        }
        // The largest first; equals by their place, so that the order is one.
        columns.sort_by(|a, b| b.undecided.total_cmp(&a.undecided));
        let worst: Vec<Column> = columns.drain(..BATCH.min(columns.len())).collect();
        let halves: Vec<(usize, Floor)> = worst
            .iter()
            .flat_map(|column| column.floor.halves(column.split).map(|floor| (column.slab, floor)))
            .collect();
        lens.prepare(&halves);
        columns.extend(threads.install(|| lens.all(&halves))?);
    }
    let volume = |counts: &dyn Fn(Fate) -> bool| {
        let of = |column: &Column| column.volume(&lens.chart, lens.centres[column.slab], counts);
        columns.iter().map(of).sum::<f64>() / whole
    };
    let (undecided, passes) = (volume(&|fate| fate == Fate::Undecided), volume(&|fate| fate == Fate::Passes));
    let Lens { chart, centres, .. } = lens;
    Ok(Proof { chart, centres, columns, undecided, passes, seconds: began.elapsed().as_secs_f64() })
}

impl<'a> Lens<'a> {
    fn new(system: &'a System, film: &FilmPlane, options: &ProofOptions) -> Result<Self, ProofError> {
        let ProofOptions { film_radius_mm, wavelengths_nm: [shortest, longest], .. } = *options;
        let reach = 0.999 / film.curvature_per_mm.abs();
        if !(film_radius_mm > 0.0 && film_radius_mm < reach.min(1e6)) {
            return Err(ProofError::OutOfRange(format!(
                "a film of radius {film_radius_mm} mm: give more than 0 and less than the retina's radius"
            )));
        }
        if !(shortest < longest && shortest >= 100.0 && longest <= 20_000.0) {
            return Err(ProofError::OutOfRange(format!(
                "wavelengths from {shortest} to {longest} nm: give two that rise, in nanometres"
            )));
        }
        let last_z_mm = system.last_vertex_z_mm();
        let edge = film.frame().at(0.0, film_radius_mm).point.z;
        let chart = Chart {
            film_radius_mm,
            film_z_mm: film.z_mm - last_z_mm,
            film_curvature_per_mm: film.curvature_per_mm,
            disc_radius_mm: glass_radius(system, film_radius_mm, film.z_mm, edge),
            last_z_mm,
            wavelengths_nm: [shortest, longest],
        };
        let middle = system.at_wavelength(0.5 * (shortest + longest));
        let steps = middle.steps(Travel::FromFilm).to_vec();
        check(system, &steps)?;
        let mut lens = Self {
            system,
            chart,
            centres: Vec::new(),
            steps,
            thinnest: THINNEST * options.undecided,
            tracers: HashMap::new(),
        };
        lens.centres = (0..SLABS).map(|slab| lens.centre(slab, &middle)).collect();
        let floors = lens.floors();
        lens.prepare(&floors);
        Ok(lens)
    }

    fn slab_mm(&self, slab: usize) -> [f64; 2] {
        [slab, slab + 1].map(|i| self.chart.film_radius_mm * i as f64 / SLABS as f64)
    }

    /// The middle of the part of the pupil along the meridian that is seen from the film points at both ends of a slab.
    fn centre(&self, slab: usize, tracer: &Tracer) -> Centre {
        const TRIALS: i32 = 400;
        let from_axis = Centre { at_axis_mm: 0.0, slope: 0.0 };
        let ends = self.slab_mm(slab).map(|r| {
            let passes = |part: f64| {
                let (u, s) = (part.signum(), part.abs());
                tracer.from_film(self.chart.ray(from_axis, r, u, s)).is_ok()
            };
            let parts: Vec<f64> =
                (-TRIALS..=TRIALS).map(|i| f64::from(i) / f64::from(TRIALS)).filter(|part| passes(*part)).collect();
            let middle = parts.first().zip(parts.last()).map(|(first, last)| 0.5 * (first + last));
            middle.map(|part| part * self.chart.disc_radius_mm)
        });
        let limit = 0.98 * self.chart.disc_radius_mm;
        let [first, second] = match ends {
            [Some(a), Some(b)] => [a, b],
            [Some(a), None] | [None, Some(a)] => [a, a],
            [None, None] => [0.0, 0.0],
        }
        .map(|c| c.clamp(-limit, limit));
        let [r0, r1] = self.slab_mm(slab);
        let slope = (second - first) / (r1 - r0);
        Centre { at_axis_mm: first - slope * r0, slope }
    }

    /// The first floors: parts of the rim, slabs, and wavelengths cut where a glass's formula ends.
    fn floors(&self) -> Vec<(usize, Floor)> {
        let [shortest, longest] = self.chart.wavelengths_nm;
        let mut cuts: Vec<f64> = (0..=WAVELENGTH_PARTS)
            .map(|i| shortest + (longest - shortest) * i as f64 / WAVELENGTH_PARTS as f64)
            .collect();
        let media = self.system.surfaces().iter().map(|surface| surface.element.behind());
        cuts.extend(media.flat_map(ends_nm).filter(|nm| shortest < *nm && *nm < longest));
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let mut floors = Vec::new();
        for slab in 0..SLABS {
            let [r0, r1] = self.slab_mm(slab);
            for part in 0..RIM_PARTS {
                let [u0, u1] = [part, part + 1].map(|i| 2.0 * i as f64 / RIM_PARTS as f64 - 1.0);
                floors.extend(cuts.windows(2).map(|nm| (slab, Floor { low: [r0, u0, nm[0]], high: [r1, u1, nm[1]] })));
            }
        }
        floors
    }

    /// Makes the tracers for floors.
    fn prepare(&mut self, floors: &[(usize, Floor)]) {
        for (_, floor) in floors {
            for nm in wavelengths(floor) {
                self.tracers.entry(nm.to_bits()).or_insert_with(|| self.system.at_wavelength(nm));
            }
        }
    }

    /// The columns over floors, in their order.
    fn all(&self, floors: &[(usize, Floor)]) -> Result<Vec<Column>, ProofError> {
        floors.par_iter().map(|(slab, floor)| self.column(*slab, *floor)).collect()
    }

    fn column(&self, slab: usize, floor: Floor) -> Result<Column, ProofError> {
        let indices = indices(self.system, &self.steps, &floor)?;
        let tracers = wavelengths(&floor).map(|nm| &self.tracers[&nm.to_bits()]);
        let view = View {
            chart: &self.chart,
            steps: &self.steps,
            opening_mm: self.system.diaphragm().radius_mm(),
            indices: &indices,
            tracers,
            thinnest: self.thinnest,
        };
        Ok(Column::prove(&view, slab, self.centres[slab], floor))
    }
}

fn wavelengths(floor: &Floor) -> [f64; 3] {
    [-1.0, 0.0, 1.0].map(|epsilon| floor.at([0.0, 0.0, epsilon])[2])
}

/// Refuses surfaces and glasses that no proof covers.
fn check(system: &System, steps: &[Step]) -> Result<(), ProofError> {
    let last = steps.len() - 1;
    for (i, step) in steps.iter().enumerate() {
        let surface = last - i;
        let refuse = |why| Err(ProofError::Surface { surface, why });
        if step.pose.is_some() {
            return refuse("it is decentred or tilted");
        }
        if !step.shape.is_rotationally_symmetric() {
            return refuse("it is a toroid or cylinder");
        }
        if let (Action::Pass, Element::Refract { from, to }) = (step.action, &system.surfaces()[surface].element)
            && from.dispersion() != to.dispersion()
        {
            return refuse("its media have one index at one wavelength, and not at another");
        }
    }
    let diaphragm = system.diaphragm();
    if diaphragm.blades() > 0 || diaphragm.is_masked() {
        return Err(ProofError::Diaphragm);
    }
    indices(system, steps, &Floor { low: [0.0, 0.0, 550.0], high: [0.0, 0.0, 550.0] }).map(|_| ())
}

/// Ratios of the indices at each step over the wavelengths of a floor.
fn indices(system: &System, steps: &[Step], floor: &Floor) -> Result<Vec<Option<Indices<CELL>>>, ProofError> {
    let nm: Taylor<CELL> = floor.number(VARIABLES - 2);
    let last = steps.len() - 1;
    let one = |(i, step): (usize, &Step)| {
        let surface = last - i;
        let refuse = |why: NoIndex| ProofError::Surface { surface, why: why.words() };
        let (Action::Refract(_), Element::Refract { from, to }) = (step.action, &system.surfaces()[surface].element)
        else {
            return Ok(None);
        };
        // On the way from the film the ray comes out of the medium behind the surface.
        let [from, to] = [index(to, nm).map_err(refuse)?, index(from, nm).map_err(refuse)?];
        Ok(Some(Indices::between(from, to)))
    };
    steps.iter().enumerate().map(one).collect()
}
