//! Many rays at a time, as many in step as the processor's registers hold.
//!
//! One ray waits at every surface for a square root and a division; several share the wait. The numbers lie in one
//! array a coordinate. A block of rays goes through one surface after the other, a register at a time: the registers
//! of a block do not depend on each other, so the processor works on several at once.

use glam::DVec3;

use super::fate::RayStatus;
use super::gradient::Gradients;
use super::step::{Action, Step};
use super::{Failure, Lost, Ray, SurfaceSequence, Tracer, Travel};
use crate::diaphragm::Diaphragm;
use crate::lane::{Lane, LaneKernel, Level, Mask, Real};
use crate::vector::Vector;

/// Rays in a block: they must fill several registers and stay in the nearest cache.
const BLOCK: usize = 256;

/// Lines in a group: a multiple of the numbers in the widest register of f64.
pub const LINES: usize = 8;

/// Rays of one wavelength on one way through a lens, in numbers of one kind.
///
/// Made by [`Tracer::bundle`], filled by [`Self::push`], traced by [`Tracer::trace`], then read by [`Self::result`].
#[derive(Clone, Debug)]
pub struct Bundle<R = f64> {
    way: SurfaceSequence<R>,
    /// x, y, z of the origins, seen from the vertex that the rays are at, then of the directions. There may be more than
    /// there are rays; to trace, the last register is filled up with rays along the axis.
    numbers: [Vec<R>; 6],
    fates: Vec<RayStatus>,
    is_traced: bool,
}

/// Rays of a group where they leave the lens.
pub struct Leaving<'a, R> {
    /// x, y, z from the last vertex on the way, then of the directions, whose length is 1 but for roundings.
    pub numbers: [&'a [R; LINES]; 6],
    pub(super) fates: &'a [RayStatus],
}

impl<R> Leaving<'_, R> {
    /// A bit for each that got through, the first the lowest. The numbers of the others are undefined.
    #[inline]
    pub fn through(&self) -> u32 {
        self.fates.iter().enumerate().fold(0, |bits, (i, fate)| bits | u32::from(fate.is_through()) << i)
    }
}

impl<R: Traced> Tracer<R> {
    /// An empty bundle of rays that go `travel`.
    pub fn bundle(&self, travel: Travel) -> Bundle<R> {
        Bundle::along(self.way(travel).clone())
    }

    /// Takes the rays of `bundle`, which this tracer or one of the same lens made, through the lens; the fates of
    /// them are those of [`Self::from_scene`] or [`Self::from_film`], to the last bit.
    pub fn trace(&self, bundle: &mut Bundle<R>) {
        self.trace_with(Level::new(), bundle);
    }

    /// [`Self::trace`] with the instructions of `level`, which may be fewer than the processor has.
    pub fn trace_with(&self, level: Level, bundle: &mut Bundle<R>) {
        bundle.begin();
        let way = self.way(bundle.way.travel);
        R::run(level, Trace { way, diaphragm: &self.diaphragm, bundle, lines: None });
    }
}

impl<R: Real> Bundle<R> {
    /// An empty one for rays along `way`.
    pub(super) fn along(way: SurfaceSequence<R>) -> Self {
        Self { way, numbers: Default::default(), fates: Vec::new(), is_traced: false }
    }

    /// Number of rays in the bundle.
    pub fn len(&self) -> usize {
        self.fates.len()
    }

    /// True if there is no ray.
    pub fn is_empty(&self) -> bool {
        self.fates.is_empty()
    }

    /// Takes all rays out, and keeps the memory.
    pub fn clear(&mut self) {
        self.fates.clear();
        self.is_traced = false;
    }

    /// Adds a ray in lens space.
    #[inline]
    pub fn push(&mut self, ray: Ray) {
        self.push_times(ray, 1);
    }

    /// Adds a ray in lens space so many times.
    #[inline]
    pub(super) fn push_times(&mut self, ray: Ray, count: usize) {
        let (p, d) = self.way.enter(ray);
        let first = self.fates.len();
        let rays = first + count;
        if self.numbers[5].len() < rays {
            self.grow(rays);
        }
        let [x, y, z, dx, dy, dz] = &mut self.numbers;
        x[first..rays].fill(p.x);
        y[first..rays].fill(p.y);
        z[first..rays].fill(p.z);
        dx[first..rays].fill(d.x);
        dy[first..rays].fill(d.y);
        dz[first..rays].fill(d.z);
        self.fates.resize(rays, RayStatus::THROUGH);
    }

    /// Adds the first `count` of some rays by where they cross the plane that touches the vertex of the first surface on
    /// their way: x and y there, mm, then their directions. It takes no roundings.
    #[inline]
    pub(super) fn push_crossing<const N: usize>(&mut self, rays: &[[R; N]; 5], count: usize) {
        let first = self.fates.len();
        if self.numbers[5].len() < first + N {
            self.grow(first + N);
        }
        let [x, y, z, dx, dy, dz] = &mut self.numbers;
        let there = first..first + N;
        for (column, numbers) in [x, y, dx, dy, dz].into_iter().zip(rays) {
            column[there.clone()].copy_from_slice(numbers);
        }
        z[there].fill(R::ZERO);
        self.fates.resize(first + count, RayStatus::THROUGH);
    }

    /// Makes room for so many rays, and then some.
    #[cold]
    fn grow(&mut self, rays: usize) {
        let room = rays.next_power_of_two().max(BLOCK);
        self.numbers.iter_mut().for_each(|column| column.resize(room, R::ZERO));
    }

    /// Marks the bundle as traced, which is to be done once.
    pub(super) fn begin(&mut self) {
        assert!(!self.is_traced, "a bundle is traced once; clear it and fill it again");
        self.is_traced = true;
    }

    /// The direction in which the bundle's rays go.
    pub(super) fn travel(&self) -> Travel {
        self.way.travel
    }

    /// The result of ray `i`: that of [`Tracer::from_scene`] and [`Tracer::from_film`].
    #[inline]
    pub fn result(&self, i: usize) -> Result<Ray, Lost> {
        debug_assert!(self.is_traced, "trace the bundle first");
        if let Some(lost) = self.fates[i].lost() {
            return Err(lost);
        }
        let [x, y, z, dx, dy, dz] = &self.numbers;
        let origin = DVec3::new(x[i].to_f64(), y[i].to_f64(), z[i].to_f64());
        let direction = DVec3::new(dx[i].to_f64(), dy[i].to_f64(), dz[i].to_f64());
        Ok(self.way.leave(origin, direction))
    }

    /// The rays from `first` on where they left the lens: x, y and z from the last vertex on the way, then their
    /// directions, whose length is 1; and a bit for each that got through, the first the lowest. The numbers of the
    /// others are undefined.
    #[inline]
    pub(super) fn results<const N: usize>(&self, first: usize, rays: &mut [[R; N]; 6]) -> u32 {
        debug_assert!(self.is_traced, "trace the bundle first");
        const { assert!(N <= 32 && BLOCK.is_multiple_of(N)) };
        let fates = self.fates[first..].iter().take(N);
        let through = fates.enumerate().fold(0, |bits, (i, fate)| bits | u32::from(fate.is_through()) << i);
        for (column, numbers) in rays.iter_mut().zip(&self.numbers) {
            // The room is of whole blocks.
            column.copy_from_slice(&numbers[first..first + N]);
        }
        let [_, _, _, dx, dy, dz] = rays;
        let [half, more] = [R::from_f64(0.5), R::from_f64(1.5)];
        // As `SurfaceSequence::leave` does it, whose roundings those of R are.
        for _ in 0..2 {
            for i in 0..N {
                let factor = more - half * (dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]);
                (dx[i], dy[i], dz[i]) = (dx[i] * factor, dy[i] * factor, dz[i] * factor);
            }
        }
        through
    }

    /// The results of the [`LINES`] rays from `first` on.
    #[inline]
    pub(super) fn leaving(&self, first: usize) -> Leaving<'_, R> {
        debug_assert!(self.is_traced, "trace the bundle first");
        let [x, y, z, dx, dy, dz] = &self.numbers;
        Leaving {
            numbers: [
                group(x, first),
                group(y, first),
                group(z, first),
                group(dx, first),
                group(dy, first),
                group(dz, first),
            ],
            fates: &self.fates[first..first + LINES],
        }
    }

    /// True if ray `i` got through.
    #[inline]
    pub fn is_through(&self, i: usize) -> bool {
        debug_assert!(self.is_traced, "trace the bundle first");
        self.fates[i].is_through()
    }

    /// Number of rays that got through.
    pub fn passed(&self) -> usize {
        self.fates.iter().filter(|fate| fate.is_through()).count()
    }
}

#[inline]
fn group<R>(column: &[R], first: usize) -> &[R; LINES] {
    column[first..].first_chunk().expect("groups are added whole")
}

/// A lens's interfaces at several spectral lines, and the lines of a bundle's rays.
pub(super) struct Lines<'a, R> {
    /// Ratios, then excesses, by step and line; beside a gradient the indices before and behind.
    pub(super) tables: &'a [[Box<[R]>; 2]],
    /// The first line of each group of rays; the others of a group have those that follow.
    pub(super) first: &'a [u32],
    /// Rays in a group: 1 or [`LINES`].
    pub(super) group: usize,
}

impl<R: Real> Lines<'_, R> {
    /// The numbers at step `step` of the rays from `ray` on.
    #[inline(always)]
    fn fill(&self, step: usize, ray: usize, [ratios, excesses]: &mut [[R; BLOCK]; 2]) {
        let [all_ratios, all_excesses] = &self.tables[step];
        let first = &self.first[ray / self.group..];
        if self.group == 1 {
            for ((&line, ratio), excess) in first.iter().zip(ratios).zip(excesses) {
                (*ratio, *excess) = (all_ratios[line as usize], all_excesses[line as usize]);
            }
        } else {
            let (ratios, _) = ratios.as_chunks_mut::<LINES>();
            let (excesses, _) = excesses.as_chunks_mut::<LINES>();
            for ((&line, ratios), excesses) in first.iter().zip(ratios).zip(excesses) {
                (*ratios, *excesses) = (*group(all_ratios, line as usize), *group(all_excesses, line as usize));
            }
        }
    }
}

/// Numbers in which bundles are traced.
///
/// The code for each kind of them, in all instructions that a processor may have, is made here and nowhere else: a generic
/// function would have it made anew in every program that calls it, which takes minutes.
pub trait Traced: Real {
    /// Traces the rays of a bundle.
    #[doc(hidden)]
    fn run(level: Level, work: Trace<'_, Self>);
}

impl Traced for f32 {
    #[inline(never)]
    fn run(level: Level, work: Trace<'_, Self>) {
        Self::run_wide(level, work);
    }
}

impl Traced for f64 {
    #[inline(never)]
    fn run(level: Level, work: Trace<'_, Self>) {
        Self::run_wide(level, work);
    }
}

/// The work of one [`Bundle`].
pub struct Trace<'a, R> {
    pub(super) way: &'a SurfaceSequence<R>,
    pub(super) diaphragm: &'a Diaphragm<R>,
    pub(super) bundle: &'a mut Bundle<R>,
    pub(super) lines: Option<Lines<'a, R>>,
}

impl<R: Real> LaneKernel<R> for Trace<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lane<Real = R>>(self, zero: L) {
        let Bundle { numbers, fates, .. } = self.bundle;
        let axis = [R::ZERO, R::ZERO, R::ZERO, R::ZERO, R::ZERO, self.way.steps[0].side];
        let rays = fates.len().next_multiple_of(L::WIDTH);
        for (column, number) in numbers.iter_mut().zip(axis) {
            // The room is a power of two: of whole registers.
            column[fates.len()..rays].fill(number);
        }
        // Rays that only fill a register up have the numbers of those before them, or these: no interface.
        let mut at_lines = [[R::ONE; BLOCK], [R::ZERO; BLOCK]];
        for first in (0..rays).step_by(BLOCK) {
            let block = first..(first + BLOCK).min(rays);
            let [x, y, z, dx, dy, dz] = &mut *numbers;
            let mut block = RayLanes {
                x: &mut x[block.clone()],
                y: &mut y[block.clone()],
                z: &mut z[block.clone()],
                dx: &mut dx[block.clone()],
                dy: &mut dy[block.clone()],
                dz: &mut dz[block],
            };
            let left = (fates.len() - first).min(BLOCK);
            let mut lost = Losses { fates: &mut fates[first..], left, surface: 0 };
            for (i, step) in self.way.steps.iter().enumerate() {
                if lost.left == 0 {
                    break;
                }
                lost.surface = self.way.surface(i);
                let gradients = self.way.gradients(i);
                match &self.lines {
                    Some(lines) if matches!(step.action, Action::Refract(_)) || gradients.is_some() => {
                        if gradients.is_some() {
                            // Rays that only fill a register up go through a medium, too.
                            at_lines = [[R::ONE; BLOCK]; 2];
                        }
                        lines.fill(i, first, &mut at_lines);
                        let [ratios, excesses] = &at_lines;
                        block.step(zero, step, gradients, Some([ratios, excesses]), self.diaphragm, &mut lost);
                    }
                    _ => block.step(zero, step, gradients, None, self.diaphragm, &mut lost),
                }
            }
        }
    }
}

/// The list in which lost rays are noted.
pub(super) struct Losses<'a> {
    /// Fates of the rays of a block.
    pub(super) fates: &'a mut [RayStatus],
    /// Number of the block's rays that are not lost.
    pub(super) left: usize,
    /// The surface that the rays are at.
    pub(super) surface: usize,
}

impl Losses<'_> {
    /// Notes the loss of the ray at `place`, if it is the first: a ray that is lost goes on beside the others.
    fn note(&mut self, place: usize, reason: Failure) {
        // The last register may be wider than what is left of the rays.
        if let Some(fate) = self.fates.get_mut(place).filter(|fate| fate.is_through()) {
            *fate = Lost { surface: self.surface, reason }.into();
            self.left -= 1;
        }
    }
}

/// Rays that go through all surfaces together: their coordinates.
pub(super) struct RayLanes<'a, R> {
    pub(super) x: &'a mut [R],
    pub(super) y: &'a mut [R],
    pub(super) z: &'a mut [R],
    pub(super) dx: &'a mut [R],
    pub(super) dy: &'a mut [R],
    pub(super) dz: &'a mut [R],
}

impl<R: Real> RayLanes<'_, R> {
    /// The rays from `at` on, as many as a lane like `zero` holds.
    #[inline(always)]
    fn load<L: Lane<Real = R>>(&self, zero: L, at: usize) -> (Vector<L>, Vector<L>) {
        let load = |column: &[R]| zero.load(&column[at..at + L::WIDTH]);
        (
            Vector { x: load(self.x), y: load(self.y), z: load(self.z) },
            Vector { x: load(self.dx), y: load(self.dy), z: load(self.dz) },
        )
    }

    #[inline(always)]
    fn store<L: Lane<Real = R>>(&mut self, p: Vector<L>, d: Vector<L>, at: usize) {
        p.x.store(&mut self.x[at..at + L::WIDTH]);
        p.y.store(&mut self.y[at..at + L::WIDTH]);
        p.z.store(&mut self.z[at..at + L::WIDTH]);
        d.x.store(&mut self.dx[at..at + L::WIDTH]);
        d.y.store(&mut self.dy[at..at + L::WIDTH]);
        d.z.store(&mut self.dz[at..at + L::WIDTH]);
    }

    /// Takes all rays through a surface; each by its own interface, if `interfaces` has them (ratios and excesses, or beside a
    /// gradient the indices before and behind).
    #[inline(always)]
    pub(super) fn step<L: Lane<Real = R>>(
        &mut self,
        zero: L,
        step: &Step<R>,
        gradients: Option<&Gradients<R>>,
        interfaces: Option<[&[R]; 2]>,
        diaphragm: &Diaphragm<R>,
        lost: &mut Losses,
    ) {
        if gradients.is_some() {
            self.pass_beside_gradient(zero, step, gradients, interfaces, diaphragm, lost);
        } else if step.plain(false).is_some() {
            self.pass_plain::<L, false>(zero, step, interfaces, diaphragm, lost);
        } else if step.plain(true).is_some() {
            self.pass_plain::<L, true>(zero, step, interfaces, diaphragm, lost);
        } else {
            self.pass_any(zero, step, interfaces, diaphragm, lost);
        }
    }

    /// [`Self::step`] for [`Step::plain`] surfaces. It, [`Self::pass_any`] and [`Self::pass_beside_gradient`] are functions of their own:
    /// the kernels share them, and the time of the compiler grows faster than a function does.
    #[inline(never)]
    fn pass_plain<L: Lane<Real = R>, const IS_FAR: bool>(
        &mut self,
        zero: L,
        step: &Step<R>,
        interfaces: Option<[&[R]; 2]>,
        diaphragm: &Diaphragm<R>,
        lost: &mut Losses,
    ) {
        zero.within(
            #[inline(always)]
            || {
                let Some(plain) = step.plain(IS_FAR) else { return };
                match interfaces {
                    None => self.pass(zero, &plain, None, None, diaphragm, lost),
                    Some(_) => self.pass(zero, &plain, None, interfaces, diaphragm, lost),
                }
            },
        );
    }

    /// [`Self::step`] for surfaces of any shape, pose and action.
    #[inline(never)]
    fn pass_any<L: Lane<Real = R>>(
        &mut self,
        zero: L,
        step: &Step<R>,
        interfaces: Option<[&[R]; 2]>,
        diaphragm: &Diaphragm<R>,
        lost: &mut Losses,
    ) {
        zero.within(
            #[inline(always)]
            || match interfaces {
                None => self.pass(zero, step, None, None, diaphragm, lost),
                Some(_) => self.pass(zero, step, None, interfaces, diaphragm, lost),
            },
        );
    }

    /// [`Self::step`] for surfaces beside a gradient.
    #[inline(never)]
    fn pass_beside_gradient<L: Lane<Real = R>>(
        &mut self,
        zero: L,
        step: &Step<R>,
        gradients: Option<&Gradients<R>>,
        interfaces: Option<[&[R]; 2]>,
        diaphragm: &Diaphragm<R>,
        lost: &mut Losses,
    ) {
        zero.within(
            #[inline(always)]
            || self.pass(zero, step, gradients, interfaces, diaphragm, lost),
        );
    }

    /// [`Self::step`] for one kind of surface.
    #[inline(always)]
    fn pass<L: Lane<Real = R>>(
        &mut self,
        zero: L,
        step: &Step<R>,
        gradients: Option<&Gradients<R>>,
        interfaces: Option<[&[R]; 2]>,
        diaphragm: &Diaphragm<R>,
        lost: &mut Losses,
    ) {
        for at in (0..self.x.len()).step_by(L::WIDTH) {
            let (p, d) = self.load(zero, at);
            let numbers = match interfaces {
                None => None,
                Some([first, second]) => {
                    let lanes = at..at + L::WIDTH;
                    Some([zero.load(&first[lanes.clone()]), zero.load(&second[lanes])])
                }
            };
            let passage = match gradients {
                None => step.pass(p, d, diaphragm, numbers),
                Some(gradients) => step.pass_gradients(p, d, diaphragm, numbers, gradients),
            };
            self.store(passage.point, passage.direction, at);
            if !passage.passed().all() {
                let fates = passage.fates();
                for lane in 0..L::WIDTH {
                    if let Some(reason) = fates.failure(lane) {
                        self.lose(at + lane, step.side_after());
                        lost.note(at + lane, reason);
                    }
                }
            }
        }
    }

    /// Lets a lost ray go on along the axis, where nothing is rare, so that the others need not wait for it.
    #[cold]
    fn lose(&mut self, place: usize, side: R) {
        (self.x[place], self.y[place], self.z[place]) = Default::default();
        (self.dx[place], self.dy[place], self.dz[place]) = (R::ZERO, R::ZERO, side);
    }
}

#[cfg(test)]
mod tests;
