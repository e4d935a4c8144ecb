//! Stray light: the light that reflections between surfaces, scattering and the wave nature of light add to a picture that rays alone have
//! made.
//!
//! Stray light is computed once, after the last sample, from the picture and the scene's sources, and kept apart from it: the shown picture
//! is the sum. Each part is a difference that may be weighed by itself.

pub mod diffraction;
pub mod ghosts;
pub mod glare;
mod sampled;
pub mod sources;
pub mod spread;

use crate::Rgb;
use crate::camera::Camera;
use crate::camera::tools::straying::StrayLens;
use crate::integrator::PreparedScene;
use diffraction::Diffraction;
use glare::Glare;
use std::time::Instant;

/// The callbacks of a long computation: one stops it, the other takes its progress.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// True once the computation is to end without a result.
    pub stopped: &'a (dyn Fn() -> bool + Sync),
    /// Takes the part that is done, 0 to 1.
    pub tell: &'a (dyn Fn(f64) + Sync),
}

impl Watch<'_> {
    /// Nobody watches.
    pub const NONE: Watch<'static> = Watch { stopped: &|| false, tell: &|_| {} };

    /// True once the computation is to end without a result.
    pub fn is_stopped(&self) -> bool {
        (self.stopped)()
    }
}

/// A picture as the film has it: linear, rows from below.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width of the picture, pixels.
    pub width: u32,
    /// Height of the picture, pixels.
    pub height: u32,
    /// Light by pixel, row by row.
    pub light: Vec<Rgb>,
}

/// The kinds of stray light that are computed.
#[derive(Default)]
pub struct Strays {
    /// Ghosts: light reflected between surfaces of the lens.
    pub ghosts: Option<Ghosts>,
    /// The wave nature of light.
    pub diffraction: Option<Diffraction>,
    /// Light scattered by surfaces, dust, barrel and film.
    pub glare: Option<Glare>,
    /// Light on the front, for glare: see [`Glare::change`].
    pub front_light: Option<f64>,
}

/// Number of reflections of a ghost's path at most. Paths of four are a hundred times as many as those of two, and each takes from its
/// light the reflectance of a surface twice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reflections {
    /// Two, as most visible ghosts have.
    #[default]
    Two,
    /// Two or four: for lenses without coatings, and the sun.
    Four,
}

impl Reflections {
    /// The numbers of reflections that there are.
    fn counts(self) -> &'static [usize] {
        match self {
            Self::Two => &[2],
            Self::Four => &[2, 4],
        }
    }

    /// The variant of that number, if there is one.
    pub fn of(count: usize) -> Option<Self> {
        [Self::Two, Self::Four].into_iter().find(|one| one.counts().last() == Some(&count))
    }
}

/// Settings of the simulation of ghosts.
pub struct Ghosts {
    /// The lens, whatever camera made the picture.
    pub lens: StrayLens,
    /// Light that may be left out, as a radiance of the scene.
    pub tolerance: f32,
    /// Number of reflections of a path at most.
    pub reflections: Reflections,
}

/// A part of the stray light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrayPass {
    /// Ghosts: light reflected between surfaces of the lens.
    Ghosts,
    /// Light scattered by surfaces, dust, barrel and film; negative where it takes light away.
    Glare,
    /// The wave nature of light; negative where it takes light away.
    Diffraction,
}

impl StrayPass {
    /// All passes of stray light.
    pub const ALL: [Self; 3] = [Self::Ghosts, Self::Glare, Self::Diffraction];

    /// Name of the pass for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ghosts => "GHOSTS",
            Self::Glare => "GLARE",
            Self::Diffraction => "DIFFRACTION",
        }
    }
}

/// The stray light that was found.
#[derive(Clone, Debug, Default)]
pub struct StrayLight {
    parts: Vec<StrayPart>,
    /// The report on ghosts.
    pub ghosts: Option<ghosts::GhostReport>,
}

/// One kind of stray light.
#[derive(Clone, Debug)]
struct StrayPart {
    pass: StrayPass,
    light: Vec<Rgb>,
    seconds: f64,
}

impl StrayLight {
    /// The kinds of stray light that were computed, and the wall time that each took, s.
    pub fn times(&self) -> impl Iterator<Item = (StrayPass, f64)> {
        self.parts.iter().map(|part| (part.pass, part.seconds))
    }

    /// A part; `None` if it was not looked for.
    pub fn part(&self, pass: StrayPass) -> Option<&[Rgb]> {
        self.parts.iter().find(|part| part.pass == pass).map(|part| part.light.as_slice())
    }

    /// Adds all parts to a picture.
    pub fn add_to(&self, picture: &mut [[f32; 4]]) {
        for part in &self.parts {
            for (pixel, light) in picture.iter_mut().zip(&part.light) {
                pixel[..3].iter_mut().zip(light.to_array()).for_each(|(sum, part)| *sum += part);
            }
        }
    }
}

/// A picture without its stray light, with its scene and cameras.
pub struct Straight<'a> {
    /// The prepared scene of the picture.
    pub stage: &'a PreparedScene,
    /// The camera in the middle of the exposure.
    pub camera: &'a Camera,
    /// The picture that the camera took.
    pub picture: &'a Picture,
    /// Factor of the camera's light in the picture.
    pub exposure: f32,
    /// A further factor of the camera's light by pixel; without these, one.
    pub gains: &'a [f32],
}

impl Straight<'_> {
    /// Factor of the camera's light at a pixel.
    pub fn scale(&self, pixel: usize) -> f32 {
        self.exposure * self.gains.get(pixel).copied().unwrap_or(1.0)
    }
}

/// The part of the progress that glare and diffraction have each, where there are ghosts: their time does not grow with the sources.
const OTHERS: f64 = 0.05;

impl Strays {
    /// The sources of ghosts, and the light that may be left out, in the picture's units.
    fn sources(straight: &Straight<'_>, Ghosts { lens, tolerance, .. }: &Ghosts) -> (Vec<sources::Source>, f32) {
        let least = tolerance / (lens.brightest_ghost() as f32).max(f32::MIN_POSITIVE);
        (sources::all(straight, lens, least), tolerance * lens.brightness() as f32)
    }

    /// Wall time that each kind will take of the whole picture, s, by a small one of the same view, `small`, whose stray light has the
    /// settings `of_small`.
    pub fn expected_times(&self, of_small: &Self, small: &Straight<'_>) -> Vec<(StrayPass, f64)> {
        let mut times = Vec::new();
        if let Some(settings) = &self.ghosts {
            let (sources, tolerance) = Self::sources(small, settings);
            let seconds = ghosts::expected_seconds(&settings.lens, &sources, settings.reflections, tolerance);
            times.push((StrayPass::Ghosts, seconds));
        }
        let light = &small.picture.light;
        if let (Some(glare), Some(of_small)) = (&self.glare, &of_small.glare) {
            times.push((StrayPass::Glare, glare.expected_seconds(of_small, light, self.front_light)));
        }
        if let (Some(diffraction), Some(of_small)) = (&self.diffraction, &of_small.diffraction) {
            times.push((StrayPass::Diffraction, diffraction.expected_seconds(of_small, light)));
        }
        times
    }

    /// Finds the stray light; `None` where `watch` stopped it.
    pub fn find(&self, straight: &Straight<'_>, watch: &Watch<'_>) -> Option<StrayLight> {
        let mut found = StrayLight::default();
        let mut start = Instant::now();
        let mut keep = |pass: StrayPass, light: Vec<Rgb>| {
            let seconds = std::mem::replace(&mut start, Instant::now()).elapsed().as_secs_f64();
            found.parts.push(StrayPart { pass, light, seconds });
        };
        let mut ghost_report = None;
        if let Some(settings) = &self.ghosts {
            let Ghosts { lens, reflections, .. } = settings;
            let (sources, tolerance) = Self::sources(straight, settings);
            let others = u8::from(self.glare.is_some()) + u8::from(self.diffraction.is_some());
            let part = 1.0 - OTHERS * f64::from(others);
            let tell = |done: f64| (watch.tell)(part * done);
            let own = Watch { tell: &tell, ..*watch };
            let (mut ghosts, report) = ghosts::ghosts(lens, &sources, *reflections, tolerance, &own)?;
            ghosts.light.iter_mut().enumerate().for_each(|(pixel, light)| *light *= straight.scale(pixel));
            keep(StrayPass::Ghosts, ghosts.light);
            ghost_report = Some(report);
        }
        if watch.is_stopped() {
            return None;
        }
        if let Some(glare) = &self.glare {
            keep(StrayPass::Glare, glare.change(&straight.picture.light, self.front_light));
        }
        if watch.is_stopped() {
            return None;
        }
        if self.diffraction.is_some() {
            (watch.tell)(1.0 - OTHERS);
        }
        if let Some(diffraction) = &self.diffraction {
            keep(StrayPass::Diffraction, diffraction.change(&straight.picture.light));
        }
        found.ghosts = ghost_report;
        Some(found)
    }
}
