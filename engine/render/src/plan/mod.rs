//! The plan of the effects that a picture calls for: the change by each effect of the lens in this frame is measured; visible effects are
//! simulated, invisible ones are left out, and the user's word goes before both.
//!
//! A plan is a value: made once before a render from the lens, the camera and a look at the scene, printed, kept with the
//! picture, and applied to the camera's description. After that nothing asks for the decisions again. No decision depends
//! on a clock, so the same scene has the same plan on every machine.

mod calibrated;
mod choice;
mod coincident;
mod decide;
mod effects;
mod light;
mod look;
mod measured;
mod model_effects;
mod motion;
mod price;
pub mod report;
mod spikes;
mod unit;
mod words;

use crate::Rgb;
use crate::camera::clip::Clip;
use crate::camera::shutter::Exposure;
use crate::camera::tools::straying::StrayLens;
use crate::camera::tools::survey::{GRID, LensMeasures, Survey, Worst};
use crate::camera::{Camera, CameraDescription, CameraError, Model};
use crate::integrator::PreparedScene;
use crate::pipeline::Pipeline;
use crate::stray::diffraction::Diffraction;
use crate::stray::glare::Glare;
use crate::stray::{Ghosts, Reflections, Strays, ghosts, sources::Source};
pub use choice::{CameraChoice, CameraKind};
pub use coincident::CoincidentFaces;
use decide::decide;
pub use effects::Effect;
pub use light::Brightest;
pub use look::SceneProbe;
use measured::Known;
use model_effects::ModelEffects;
use motion::scene_motion;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::time::Instant;
pub use unit::Unit;

/// The user's word on an effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EffectMode {
    /// The measure decides: an effect above its tolerance is simulated.
    #[default]
    Auto,
    /// Simulate the effect, whatever its measure.
    On,
    /// Leave the effect out, whatever its measure.
    Off,
}

impl EffectMode {
    /// Name of the word on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::On => "on",
            Self::Off => "off",
        }
    }
}

/// Number of the sources that send most light whose ghosts are looked for.
const GHOST_SOURCES: usize = 3;

/// The ghosts of the brightest sources before the lens.
struct GhostLook {
    /// Value of the brightest ghost, as a part of the exposure.
    value: f64,
    /// Cost of all sources' ghosts, s of one thread on the machine of [`price`].
    picture_s: f64,
}

/// Looks for the ghosts of the brightest sources before the lens; `None` if there are no sources.
fn ghosts_of(
    d: &CameraDescription,
    [width, height]: [u32; 2],
    look: &SceneProbe,
    wishes: &PlanOptions,
) -> Result<Option<GhostLook>, CameraError> {
    // What cannot photograph the camera itself says.
    let Ok(lens) = StrayLens::new(d, width, height) else { return Ok(None) };
    let is_before = |one: &&Brightest| one.towards.dot(lens.forwards()) > 0.0;
    let source = |one: &Brightest| {
        let irradiance = Rgb::splat(one.irradiance);
        let place = lens.source(one.towards, f64::INFINITY);
        Source { place, irradiance, radius_rad: 0.0, towards: one.towards, pixel: None }
    };
    let sources: Vec<Source> = look.brightest.iter().filter(is_before).map(source).collect();
    let exposure = lens.brightness() * f64::from(look.exposure);
    let tolerance = Unit::Exposure.tolerance(wishes.quality);
    let some = &sources[..sources.len().min(GHOST_SOURCES)];
    let found = ghosts::glimpse(&lens, some, wishes.ghost_reflections, (tolerance * exposure) as f32);
    let picture_s = price::ghosts_s(sources.len(), &found, f64::from(width) * f64::from(height));
    Ok((found.sources > 0).then(|| GhostLook { value: f64::from(found.brightest) / exposure, picture_s }))
}

/// The user's settings of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    words: [EffectMode; Effect::ALL.len()],
    /// The quality, by which all tolerances are divided.
    pub quality: f64,
    /// The way that light is followed, if the user has chosen.
    pub pipeline: Pipeline,
    /// Number of reflections of a ghost's path at most.
    pub ghost_reflections: Reflections,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self { words: Default::default(), quality: 1.0, pipeline: Pipeline::Auto, ghost_reflections: Reflections::Two }
    }
}

impl PlanOptions {
    /// The options with the user's words on some effects.
    pub fn new(words: &BTreeMap<Effect, EffectMode>) -> Self {
        let mut options = Self::default();
        for (&effect, &word) in words {
            options.say(effect, word);
        }
        options
    }

    /// The user's word on one effect.
    pub fn word(&self, effect: Effect) -> EffectMode {
        self.words[effect as usize]
    }

    /// Sets the user's word on one effect.
    pub fn say(&mut self, effect: Effect, word: EffectMode) {
        self.words[effect as usize] = word;
    }
}

/// An error by which there is no plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The camera cannot photograph.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// An effect was asked for that cannot be simulated yet, or that a setting of the camera decides on.
    #[error("effect {}=on: {}; set it to auto or off", .0.name(), .0.why_not())]
    NotYet(Effect),
    /// Two wishes are against each other.
    #[error("effects: {0}")]
    Conflict(String),
    /// The quality is no factor of tolerances.
    #[error("quality {0}: set it from 0.01 to 1000; 1 is the default, more is finer")]
    Quality(f64),
}

/// The decision on an effect, and its reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The effect that is decided on.
    pub effect: Effect,
    /// Measure of the effect's change of the picture; infinite where it has no bound, `None` where it is not measured.
    pub measure: Option<f64>,
    /// The largest measure that may be left out.
    pub tolerance: f64,
    /// The user's word: auto, on or off.
    pub word: EffectMode,
    /// True if the effect is simulated.
    pub is_on: bool,
    /// True if the measure may be too small, and was taken for larger than it is.
    pub is_uncertain: bool,
    /// The reason, in a sentence.
    pub why: String,
    /// Cost of the simulation, ns for a sample of the camera on the machine of [`price`]; 0 if it comes along with another.
    pub cost_ns: f64,
    /// Cost once a picture, after its samples: seconds on the machine of [`price`], one thread.
    pub picture_s: f64,
}

/// Everything that a picture's measures and wishes decide.
#[derive(Clone, Debug)]
pub struct Plan {
    /// One for each effect, in the order of [`Effect::ALL`].
    pub decisions: Vec<Decision>,
    /// The simulation of the camera.
    pub camera: CameraChoice,
    /// The measures of the lens; `None` for a camera without a lens.
    pub lens: Option<LensMeasures>,
    /// The view of the camera.
    pub look: SceneProbe,
    /// Cost of the camera for a sample, ns, by [`price`].
    pub camera_ns: f64,
    /// Number of reflections of ghosts at most.
    pub ghost_reflections: Reflections,
    /// The quality, by which all tolerances are divided.
    pub quality: f64,
    /// Wall time that the plan took, s.
    pub seconds: f64,
}

/// The need for a lens that is traced, for rays that go from lights to the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LensNeed {
    /// All rays start at the camera.
    #[default]
    None,
    /// Small lights would have less noise: the lens is traced unless the user's wishes leave out a part of it.
    Wanted,
    /// Light paths end in the lens.
    Required,
}

impl Plan {
    /// Measures and decides for a picture of that many pixels. `moving` is the camera at times over which the shutter is
    /// open, if the lens changes meanwhile, and `exposure` is that time, where it matters; `lens_need` says whether rays from lights
    /// are to end in a lens that is traced.
    ///
    /// # Errors
    /// [`PlanError`].
    pub fn new(
        stage: &PreparedScene,
        d: &CameraDescription,
        moving: &[CameraDescription],
        [width, height]: [u32; 2],
        wishes: &PlanOptions,
        lens_need: LensNeed,
        exposure: Option<&Exposure>,
    ) -> Result<Self, PlanError> {
        let start = Instant::now();
        if !(0.01..=1000.0).contains(&wishes.quality) {
            return Err(PlanError::Quality(wishes.quality));
        }
        if d.model != Model::Lens {
            return Self::without_lens(stage, d, (moving, exposure), [width, height], wishes, start);
        }
        let survey = Survey::new(d, width, height)?;
        let fans = survey.fans();
        let clip = Clip::along(d, survey.backwards());
        let (mut look, seen) = SceneProbe::along(stage, &fans.rays(), clip, survey.backwards(), true);
        for one in &mut look.brightest {
            one.place = fans.place_of(one.towards);
        }
        let lens = fans.measure(&seen);
        let mut motion: Option<Worst> = None;
        if let [first, .., last] = moving {
            for then in [first, last] {
                let other = Survey::new(then, width, height)?;
                let one = fans.moved(&other.fans(), &seen);
                motion = Some(motion.filter(|worst| worst.value >= one.value).unwrap_or(one));
            }
        }
        let ghosts = if look.exposure > 0.0 { ghosts_of(d, [width, height], &look, wishes)? } else { None };
        let front_light = look.front_light();
        let scene_motion = scene_motion(&stage.scene, exposure, &fans.rays(), &seen);
        let seen_px = spikes::seen_px(&survey, &look, lens.airy_px);
        let glare = Glare::of_surfaces(&survey.scatterers(), d.scattering, survey.pixel_mm(), [1, 1]).part();
        let pixels = f64::from(width) * f64::from(height);
        let known = Known {
            d,
            survey: &survey,
            lens,
            motion,
            scene_motion,
            ghosts,
            front_light,
            glare,
            seen_px,
            pixels,
            lens_need,
        };
        let (decisions, camera, camera_ns) = decide(&known, wishes)?;
        let PlanOptions { ghost_reflections, quality, .. } = *wishes;
        let seconds = start.elapsed().as_secs_f64();
        Ok(Self { decisions, camera, camera_ns, lens: Some(lens), look, ghost_reflections, quality, seconds })
    }

    /// The stray light that this plan computes beside the rays that make the picture of a camera, of that many pixels; `None` if none.
    ///
    /// # Errors
    /// As [`Camera::new`].
    pub fn strays(&self, d: &CameraDescription, [width, height]: [u32; 2]) -> Result<Option<Strays>, CameraError> {
        let CameraChoice { ghosts, diffraction, glare, .. } = self.camera;
        if !(ghosts || diffraction || glare) {
            return Ok(None);
        }
        let ghosts = match ghosts {
            true => Some(Ghosts {
                lens: StrayLens::new(d, width, height)?,
                tolerance: self.decision(Effect::Ghosts).tolerance as f32 * self.look.exposure,
                reflections: self.ghost_reflections,
            }),
            false => None,
        };
        let diffraction = diffraction.then(|| Diffraction::new(d, [width, height])).transpose()?;
        let glare = glare.then(|| Glare::new(d, [width, height])).transpose()?;
        Ok(Some(Strays { ghosts, diffraction, glare, front_light: self.look.front_light() }))
    }

    /// A camera without a lens, or with a simpler model of one, is taken as it is.
    fn without_lens(
        stage: &PreparedScene,
        d: &CameraDescription,
        (moving, exposure): (&[CameraDescription], Option<&Exposure>),
        [width, height]: [u32; 2],
        wishes: &PlanOptions,
        start: Instant,
    ) -> Result<Self, PlanError> {
        let camera = Camera::new(d, width, height)?;
        let calibrated = calibrated::decisions(&camera, wishes);
        let model = ModelEffects::new(d.model, &calibrated, wishes)?;
        let ray = |i: usize| {
            let place = Survey::place(i % GRID[0], i / GRID[0]);
            camera.sample(place, [0.5; 2], 0.5).map(|found| found.ray)
        };
        let rays: Vec<_> = (0..GRID[0] * GRID[1]).map(ray).collect();
        let clip = Clip::new(d, &camera);
        let (look, seen) = SceneProbe::along(stage, &rays, clip, camera.axes().z_axis, false);
        let motion = scene_motion(&stage.scene, exposure, &rays, &seen);
        let blur = decide::motion_without_lens(motion, moving.len() > 1, wishes);
        let is_moving = blur.is_on;
        let decision = |effect: Effect| {
            if let Some(one) = [&blur].into_iter().chain(&calibrated).find(|one| one.effect == effect) {
                return one.clone();
            }
            Decision {
                effect,
                measure: None,
                tolerance: effect.unit().tolerance(wishes.quality),
                word: wishes.word(effect),
                is_on: model.has(effect),
                is_uncertain: false,
                why: "decided by the camera's model".to_owned(),
                cost_ns: 0.0,
                picture_s: 0.0,
            }
        };
        Ok(Self {
            decisions: Effect::ALL.into_iter().map(decision).collect(),
            camera: CameraChoice {
                shown: calibrated::shown(&calibrated),
                ..CameraChoice::given(wishes, is_moving, model.colours, model.transmission)
            },
            camera_ns: 0.0,
            ghost_reflections: wishes.ghost_reflections,
            quality: wishes.quality,
            lens: None,
            look,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// The decision on an effect.
    pub fn decision(&self, effect: Effect) -> &Decision {
        &self.decisions[effect as usize]
    }

    /// The cost of an effect, as a part of the time of a render without it; `camera_part` is the part of a sample's time that the camera
    /// takes with it, `samples_s` the time of all samples on so many threads.
    pub fn cost(&self, effect: Effect, camera_part: f64, samples_s: f64, threads: usize) -> f64 {
        let once = self.decision(effect).picture_s / threads.max(1) as f64;
        let of_camera = self.decision(effect).cost_ns / self.camera_ns.max(f64::MIN_POSITIVE);
        let part = (of_camera * camera_part).clamp(-0.99, 0.99);
        part / (1.0 - part) + once / samples_s.max(f64::MIN_POSITIVE)
    }

    /// Time of the work once a picture, after its samples, s on so many threads.
    pub fn seconds_after(&self, threads: usize) -> f64 {
        self.decisions.iter().map(|one| one.picture_s).sum::<f64>() / threads.max(1) as f64
    }

    /// The camera with the plan's decisions applied.
    pub fn applied(&self, d: &CameraDescription) -> CameraDescription {
        self.camera.applied(d)
    }

    /// The part of a picture (left, bottom, width, height, pixels) to render for a border of it, within which no light of the rest belongs:
    /// larger by how far colours are apart. `None`: all, as stray light, or light led to the film, comes from anywhere.
    pub fn window(&self, [left, bottom, width, height]: [u32; 4], size: [u32; 2]) -> Option<[u32; 4]> {
        let camera = &self.camera;
        if camera.ghosts || camera.glare || camera.diffraction || camera.pipeline == Pipeline::SceneFirst {
            return None;
        }
        let spread = if camera.wavelengths() > 1 {
            [Effect::LateralColour, Effect::AxialColour].into_iter().try_fold(0.0, |sum, effect| {
                let measure = self.decision(effect).measure.filter(|px| px.is_finite())?;
                Some(sum + measure * decide::MARGIN)
            })?
        } else {
            0.0
        };
        let margin = spread.ceil() as u32;
        let begin = [left, bottom].map(|side| side.saturating_sub(margin));
        let end = [(left, width, size[0]), (bottom, height, size[1])]
            .map(|(from, length, most)| from.saturating_add(length).saturating_add(margin).min(most));
        (begin[0] < end[0] && begin[1] < end[1]).then(|| [begin[0], begin[1], end[0] - begin[0], end[1] - begin[1]])
    }

    /// The way that light is followed.
    pub fn pipeline(&self) -> Pipeline {
        self.camera.pipeline
    }
}
