//! Many rays at a time, each at a wavelength of its own.
//!
//! A path along a ray holds for every wavelength: a group of neighbouring lines, one in each lane, says where each of them leaves the lens.

use std::sync::Arc;

use glam::DVec3;

use super::bundle::{Bundle, LINES, Leaving, Lines, Losses, RayLanes, Trace, Traced};
use super::fate::RayStatus;
use super::step::Action;
use super::{Lost, Ray, SurfaceSequence, Tracer, Travel};
use crate::diaphragm::Diaphragm;
use crate::lane::{Lane, LaneKernel, Level, Real};

/// Ratios and excesses of the interfaces, by step and line; beside a gradient the indices before and behind without it.
type Tables<R> = Arc<[[Box<[R]>; 2]]>;

/// A lens at several wavelengths: its lines, in the order in which they were given.
#[derive(Clone, Debug)]
pub struct SpectralTracer<R = f64> {
    from_scene: (SurfaceSequence<R>, Tables<R>),
    from_film: (SurfaceSequence<R>, Tables<R>),
    diaphragm: Arc<Diaphragm<R>>,
    lines: usize,
}

/// Rays on one way through a lens, each at one of its lines.
///
/// Made by [`SpectralTracer::bundle`] and used like a [`Bundle`].
#[derive(Clone, Debug)]
pub struct SpectralBundle<R = f64> {
    rays: Bundle<R>,
    first: Vec<u32>,
    group: usize,
}

impl SpectralTracer {
    /// The tracer of one lens at several lines: at least one.
    pub fn new(lines: &[&Tracer]) -> Self {
        Self {
            from_scene: along(&lines.iter().map(|line| &line.from_scene).collect::<Vec<_>>()),
            from_film: along(&lines.iter().map(|line| &line.from_film).collect::<Vec<_>>()),
            diaphragm: lines[0].diaphragm.clone(),
            lines: lines.len(),
        }
    }

    /// This lens traced in numbers of another kind.
    pub fn cast<R: Real>(&self) -> SpectralTracer<R> {
        let number = |numbers: &[f64]| -> Box<[R]> { numbers.iter().map(|&n| R::from_f64(n)).collect() };
        let along = |(way, tables): &(SurfaceSequence<f64>, Tables<f64>)| {
            let tables: Tables<R> =
                tables.iter().map(|table| table.each_ref().map(|numbers| number(numbers))).collect();
            (way.map(|step| step.cast()), tables)
        };
        SpectralTracer {
            from_scene: along(&self.from_scene),
            from_film: along(&self.from_film),
            diaphragm: Arc::new(self.diaphragm.cast()),
            lines: self.lines,
        }
    }

    /// [`Tracer::from_scene`] at each of the [`LINES`] lines from `first` on, to the last bit.
    // Not inline: its code for all instructions would be made in every program.
    pub fn from_scene(&self, ray: Ray, first: usize) -> [Result<Ray, Lost>; LINES] {
        f64::run_wide(Level::new(), Packet { tracer: self, ray, first })
    }
}

/// One ray at one group of lines, without a bundle to fill.
struct Packet<'a> {
    tracer: &'a SpectralTracer,
    ray: Ray,
    first: usize,
}

impl LaneKernel<f64> for Packet<'_> {
    type Output = [Result<Ray, Lost>; LINES];

    #[inline(always)]
    fn run<L: Lane<Real = f64>>(self, zero: L) -> Self::Output {
        let (way, tables) = &self.tracer.from_scene;
        let (p, d) = way.enter(self.ray);
        let [mut x, mut y, mut z, mut dx, mut dy, mut dz] = [p.x, p.y, p.z, d.x, d.y, d.z].map(|n| [n; LINES]);
        let mut block = RayLanes { x: &mut x, y: &mut y, z: &mut z, dx: &mut dx, dy: &mut dy, dz: &mut dz };
        let mut fates = [RayStatus::THROUGH; LINES];
        let mut lost = Losses { left: fates.len(), fates: &mut fates, surface: 0 };
        for (i, (step, table)) in way.steps.iter().zip(tables.iter()).enumerate() {
            lost.surface = i;
            let interfaces = table.each_ref().map(|numbers| &numbers[self.first..self.first + LINES]);
            block.step(zero, step, way.gradients(i), Some(interfaces), &self.tracer.diaphragm, &mut lost);
        }
        std::array::from_fn(|i| match fates[i].lost() {
            Some(lost) => Err(lost),
            None => Ok(way.leave(DVec3::new(x[i], y[i], z[i]), DVec3::new(dx[i], dy[i], dz[i]))),
        })
    }
}

impl<R: Traced> SpectralTracer<R> {
    /// An empty bundle of rays that go `travel`, each of which counts as `group` rays: 1 or [`LINES`].
    pub fn bundle(&self, travel: Travel, group: usize) -> SpectralBundle<R> {
        assert!(group == 1 || group == LINES, "a group is one line or {LINES}");
        SpectralBundle { rays: Bundle::along(self.way(travel).0.clone()), first: Vec::new(), group }
    }

    /// Takes the rays of a bundle, which this tracer made, through the lens; their fates are those that
    /// [`Tracer::from_scene`] or [`Tracer::from_film`] of their lines say, to the last bit.
    pub fn trace(&self, bundle: &mut SpectralBundle<R>) {
        let SpectralBundle { rays, first, group } = bundle;
        rays.begin();
        let (way, tables) = self.way(rays.travel());
        // One line alone needs no table.
        let lines = (self.lines > 1).then_some(Lines { tables, first, group: *group });
        R::run(Level::new(), Trace { way, diaphragm: &self.diaphragm, bundle: rays, lines });
    }

    fn way(&self, travel: Travel) -> &(SurfaceSequence<R>, Tables<R>) {
        match travel {
            Travel::FromScene => &self.from_scene,
            Travel::FromFilm => &self.from_film,
        }
    }
}

impl<R: Real> SpectralBundle<R> {
    /// Number of rays, those of a group counted each.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    /// True if there is no ray.
    pub fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// Takes all rays out, and keeps the memory.
    pub fn clear(&mut self) {
        self.rays.clear();
        self.first.clear();
    }

    /// Adds a ray in lens space: at one line, or once at each of a group that begins there.
    #[inline]
    pub fn push(&mut self, ray: Ray, line: usize) {
        self.rays.push_times(ray, self.group);
        self.first.push(line as u32);
    }

    /// Adds the first of some rays, as many as there are `lines`, by where they cross the plane that touches the vertex of
    /// the first surface on their way: x and y there, mm, then their directions. For bundles of one line a ray.
    #[inline]
    pub fn push_crossing<const N: usize>(&mut self, rays: &[[R; N]; 5], lines: impl ExactSizeIterator<Item = usize>) {
        assert!(self.group == 1 && lines.len() <= N, "each ray has one line");
        self.rays.push_crossing(rays, lines.len());
        self.first.extend(lines.map(|line| line as u32));
    }

    /// The results of the group that was added as number `i`, of [`LINES`] rays.
    #[inline]
    pub fn leaving(&self, i: usize) -> Leaving<'_, R> {
        assert!(self.group == LINES, "rays of one line are read one by one");
        self.rays.leaving(i * LINES)
    }

    /// The [`LINES`] rays from `first` on where they left the lens, as far as there are so many: x, y and z from the last
    /// vertex on the way, then their directions, whose length is 1; and a bit for each that got through, the first the
    /// lowest.
    ///
    /// A call, not inlined: with arrays in memory the compiler works on whole registers.
    #[inline(never)]
    pub fn results(&self, first: usize, rays: &mut [[R; LINES]; 6]) -> u32 {
        self.rays.results(first, rays)
    }

    /// The result of ray `i`.
    #[inline]
    pub fn result(&self, i: usize) -> Result<Ray, Lost> {
        self.rays.result(i)
    }
}

/// The surface sequence that all wavelengths share, and the tables of their indices.
fn along(lines: &[&SurfaceSequence<f64>]) -> (SurfaceSequence<f64>, Tables<f64>) {
    let at = |i: usize| {
        let numbers = |line: &&SurfaceSequence<f64>| match (line.gradients(i), line.steps[i].action) {
            (Some(gradients), _) => gradients.indices,
            (None, Action::Refract(interface)) => [interface.ratio, interface.excess],
            (None, Action::Pass | Action::Reflect) => [1.0, 0.0],
        };
        let numbers: Vec<[f64; 2]> = lines.iter().map(numbers).collect();
        [0, 1].map(|which| numbers.iter().map(|at| at[which]).collect())
    };
    let tables = (0..lines[0].steps.len()).map(at).collect();
    let mut steps = lines[0].steps.to_vec();
    for (i, step) in steps.iter_mut().enumerate() {
        // Two media may agree at one wavelength.
        let bends = lines.iter().map(|line| line.steps[i].action);
        if let Some(action) = { bends }.find(|action| matches!(action, Action::Refract(_))) {
            step.action = action;
        }
    }
    (SurfaceSequence { steps: steps.into(), ..lines[0].clone() }, tables)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::lens;
    use crate::glass::Catalogue;
    use crate::system::{LensSettings, System};

    /// All shipped lenses, with spheres, aspheres, toroids, mirrors and blades.
    fn systems() -> impl Iterator<Item = System> {
        let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses"));
        petzval_testkit::lenses::shipped(folder).into_iter().filter_map(|path| {
            let prescription = lens::read(&path, Catalogue::shipped()).ok()?;
            let settings = LensSettings { blades: 6, ..LensSettings::default() };
            Some(System::new(&prescription, &settings).unwrap())
        })
    }

    /// Rays to all places of the glass that they hit first, some beyond the rims.
    fn rays(system: &System, travel: Travel) -> Vec<Ray> {
        let surfaces = system.surfaces();
        let (semi, z, start) = match travel {
            Travel::FromScene => (surfaces[0].semi_diameter_mm, 0.0, -500.0),
            Travel::FromFilm => (
                surfaces[surfaces.len() - 1].semi_diameter_mm,
                system.last_vertex_z_mm(),
                system.film_z_published_mm() - system.last_vertex_z_mm(),
            ),
        };
        let ray = |i: u32| {
            let (a, b) = (f64::from(i) * 0.618_034, f64::from(i) / 200.0);
            let at = DVec3::new((a * 6.3).cos(), (a * 6.3).sin(), 0.0) * semi * b.sqrt();
            let tilt = DVec3::new((a * 1.7).sin() * 0.3, (a * 2.9).cos() * 0.3, -start.signum()).normalize();
            Ray { origin: at + DVec3::Z * z + tilt * (start / tilt.z), direction: tilt }
        };
        (0..200).map(ray).collect()
    }

    fn check<R: Traced>(system: &System, travel: Travel, group: usize) -> usize {
        let lines: Vec<Tracer> = (0..24).map(|i| system.at_wavelength(400.0 + 12.0 * f64::from(i))).collect();
        let together = SpectralTracer::new(&lines.iter().collect::<Vec<_>>()).cast::<R>();
        let alone: Vec<Tracer<R>> = lines.iter().map(Tracer::cast).collect();
        let first = |i: usize| if group == 1 { i * 7 % 24 } else { i % 3 * LINES };
        let rays = rays(system, travel);
        let mut bundle = together.bundle(travel, group);
        let mut passed = 0;
        for round in 0..2 {
            // Not a whole number of registers, and less the second time.
            let count = 199 - 50 * round;
            rays[..count].iter().enumerate().for_each(|(i, ray)| bundle.push(*ray, first(i)));
            together.trace(&mut bundle);
            assert_eq!(bundle.len(), count * group);
            for i in 0..bundle.len() {
                let tracer = &alone[first(i / group) + i % group];
                let expected = match travel {
                    Travel::FromScene => tracer.from_scene(rays[i / group]),
                    Travel::FromFilm => tracer.from_film(rays[i / group]),
                };
                assert_eq!(bundle.result(i), expected, "{} {travel:?} {i}", system.name());
                passed += usize::from(expected.is_ok());
            }
            bundle.clear();
        }
        passed
    }

    #[test]
    fn each_wavelength_is_traced_as_alone() {
        let mut passed = [0; 2];
        for system in systems() {
            for (passed, travel) in passed.iter_mut().zip([Travel::FromScene, Travel::FromFilm]) {
                *passed += check::<f64>(&system, travel, 1) + check::<f64>(&system, travel, LINES);
                *passed += check::<f32>(&system, travel, 1) + check::<f32>(&system, travel, LINES);
            }
        }
        assert!(passed.iter().all(|&n| n > 5000), "{passed:?}");
    }

    /// A single ray at a group of lines.
    #[test]
    fn a_packet_is_traced_as_alone() {
        for system in systems() {
            let lines: [Tracer; LINES] = std::array::from_fn(|i| system.at_wavelength(400.0 + 40.0 * i as f64));
            let together = SpectralTracer::new(&lines.iter().collect::<Vec<_>>());
            for ray in rays(&system, Travel::FromScene).into_iter().step_by(10) {
                for (line, result) in lines.iter().zip(together.from_scene(ray, 0)) {
                    assert_eq!(result, line.from_scene(ray), "{}", system.name());
                }
            }
        }
    }
}
