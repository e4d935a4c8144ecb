//! Bakes: the light that the surface of one object sends up, or its data, pixel by pixel of a texture that Blender has laid out.
//!
//! Paths, film and parts of light are those of pictures; only where paths start differs ([`crate::pipeline::bake`]).

use super::{Job, OutputOptions, Settings};
use crate::camera::{CameraDescription, Model};
use crate::film::data::DataPass;
use crate::integrator::path::parts::{LightPass, LobeKind, Parts, Seen};
use crate::integrator::{Integrator, PreparedScene};
use crate::pipeline::Pipeline;
use crate::pipeline::bake::{BakePoint, BakePoints, ViewFrom};
use crate::scene::Scene;
use glam::Vec3A;
use serde::Deserialize;

/// The thing that is baked, as Blender names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum BakeKind {
    /// All light that leaves the surface.
    Combined,
    /// Ambient occlusion.
    Ao,
    /// The part of the light that other objects leave.
    Shadow,
    /// Position in world space.
    Position,
    /// Shading normal in world space.
    Normal,
    /// Texture coordinates of the first UV map.
    Uv,
    /// Roughness of the material.
    Roughness,
    /// Emission of the material.
    Emit,
    /// The sky in the direction of the surface's place.
    Environment,
    /// Light of diffuse lobes.
    Diffuse,
    /// Light of lobes of reflection.
    Glossy,
    /// Light of lobes of transmission.
    Transmission,
}

/// The settings of a bake. Which light counts is for [`BakeKind::Combined`] and the kinds of lobes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BakeSettings {
    /// Name of the Blender object, for errors.
    pub object_name: String,
    /// The thing that is baked.
    pub kind: BakeKind,
    /// True if the surface is seen from the camera, not from straight above.
    pub from_camera: bool,
    /// Light that comes straight from emitters.
    pub direct: bool,
    /// Light that was scattered before.
    pub indirect: bool,
    /// The colour of the lobes; without it light is divided by that.
    pub color: bool,
    /// Light of diffuse lobes, for [`BakeKind::Combined`].
    pub diffuse: bool,
    /// Light of lobes of reflection, likewise.
    pub glossy: bool,
    /// Light of lobes of transmission, likewise.
    pub transmission: bool,
    /// Emission of the surface, likewise.
    pub emission: bool,
}

/// The points of a bake, pixel by pixel, rows from below.
#[derive(Clone, Debug, Default)]
pub struct BakeTable {
    /// Triangle of the object's mesh; below 0: none.
    pub primitives: Vec<i32>,
    /// Barycentric weights of the first and second corner.
    pub weights: Vec<[f32; 2]>,
    /// Changes of the first weight from column to column and from row to row, then of the second.
    pub differentials: Vec<[f32; 4]>,
    /// Numbers by which pixels choose their random numbers; empty: each its own.
    pub seeds: Vec<u32>,
}

/// A bake as it is asked for.
pub struct BakeRequest {
    /// The settings.
    pub settings: BakeSettings,
    /// The points.
    pub table: BakeTable,
}

/// An error by which a bake does not start.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The object is not in the scene.
    #[error("object '{0}': nothing of it is rendered; enable it for rendering, and give it faces")]
    NoObject(String),
    /// A point names a triangle that the mesh does not have.
    #[error("object '{object}': triangle {triangle} is to be baked, and its mesh has {count}; apply its modifiers")]
    NoTriangle {
        /// Name of the object.
        object: String,
        /// Number of the triangle.
        triangle: i32,
        /// Number of triangles of the mesh.
        count: usize,
    },
    /// The arrays are not of one length.
    #[error("object '{0}': the arrays of its points differ in length from the texture")]
    Lengths(String),
    /// No light at all was asked for.
    #[error("object '{0}': no light is to be baked; choose direct or indirect light, color, or emission")]
    NoLight(String),
}

/// The bake of a job: its type, and the picture that is made of the light.
pub(super) struct Baked {
    kind: BakeKind,
    result: BakeResult,
}

impl Baked {
    /// True if the image has the film's alpha; other bakes are opaque, as in Cycles.
    fn has_alpha(&self) -> bool {
        matches!(self.kind, BakeKind::Combined | BakeKind::Diffuse | BakeKind::Glossy | BakeKind::Transmission)
    }
}

/// The result of a bake, by the data that the film keeps.
#[derive(Clone, Debug, PartialEq)]
enum BakeResult {
    /// The picture as it is.
    Picture,
    /// The sum of parts of light.
    Light(Vec<LightPass>),
    /// The sum of parts, each divided by its reference.
    Relative(Vec<LightPass>),
    Position,
    /// The shading normals; of surfaces that scatter nothing those of the mesh.
    Normal,
    /// The picture over that of the object alone.
    Shadow,
}

impl BakeSettings {
    /// The parts of light of a kind of lobe that count.
    fn of_lobe(&self, lobe: LobeKind) -> impl Iterator<Item = LightPass> {
        let both = [(true, self.direct), (false, self.indirect)];
        both.into_iter().filter(|(_, is_wanted)| *is_wanted).map(move |(near, _)| LightPass::Light(lobe, near))
    }

    fn result(&self) -> BakeResult {
        let lobe = |lobe: LobeKind| match (self.direct || self.indirect, self.color) {
            (false, _) => BakeResult::Relative(vec![LightPass::Colour(lobe)]),
            (true, true) => BakeResult::Light(self.of_lobe(lobe).collect()),
            (true, false) => BakeResult::Relative(self.of_lobe(lobe).collect()),
        };
        match self.kind {
            BakeKind::Combined => self.combined(),
            BakeKind::Ao => BakeResult::Relative(vec![LightPass::Occlusion]),
            BakeKind::Shadow => BakeResult::Shadow,
            BakeKind::Position => BakeResult::Position,
            BakeKind::Normal => BakeResult::Normal,
            BakeKind::Uv => BakeResult::Relative(vec![LightPass::Uv]),
            BakeKind::Roughness => BakeResult::Relative(vec![LightPass::Roughness]),
            BakeKind::Emit => BakeResult::Light(vec![LightPass::Emission]),
            BakeKind::Environment => BakeResult::Light(vec![LightPass::Environment]),
            BakeKind::Diffuse => lobe(LobeKind::Diffuse),
            BakeKind::Glossy => lobe(LobeKind::Glossy),
            BakeKind::Transmission => lobe(LobeKind::Transmission),
        }
    }

    fn combined(&self) -> BakeResult {
        let wanted = [self.direct, self.indirect, self.diffuse, self.glossy, self.transmission, self.emission];
        if wanted == [true; 6] {
            return BakeResult::Picture;
        }
        let lobes = [
            (LobeKind::Diffuse, self.diffuse),
            (LobeKind::Glossy, self.glossy),
            (LobeKind::Transmission, self.transmission),
        ];
        let mut parts: Vec<LightPass> =
            lobes.into_iter().filter(|(_, is_wanted)| *is_wanted).flat_map(|(lobe, _)| self.of_lobe(lobe)).collect();
        parts.extend(
            [(true, self.direct), (false, self.indirect)]
                .iter()
                .filter_map(|&(near, is_wanted)| is_wanted.then_some(LightPass::Volume(near))),
        );
        parts.extend(self.emission.then_some(LightPass::Emission));
        BakeResult::Light(parts)
    }

    /// The render's settings as the bake needs them.
    fn applied(&self, mut settings: Settings) -> Settings {
        settings.integrator = Integrator::Path;
        settings.pipeline = Pipeline::FilmFirst;
        settings.light_tracing = false;
        settings.window = None;
        // What lies behind a transparent surface is no part of it.
        settings.transparent_film = self.kind != BakeKind::Environment;
        settings.with_data = matches!(self.kind, BakeKind::Position | BakeKind::Normal);
        let is_light = match self.kind {
            BakeKind::Combined | BakeKind::Shadow => true,
            BakeKind::Diffuse | BakeKind::Glossy | BakeKind::Transmission => self.direct || self.indirect,
            _ => false,
        };
        if !is_light {
            settings.noise_threshold = 0.0;
        }
        if !is_light || (!self.indirect && self.kind != BakeKind::Shadow) {
            settings.max_bounces = 0;
        }
        settings
    }

    fn view(&self, camera: &CameraDescription, scene: &Scene) -> ViewFrom {
        // Normals are those of the surface, wherever it is seen from.
        let is_seen = self.from_camera && self.kind != BakeKind::Normal;
        match self.kind {
            BakeKind::Environment => ViewFrom::Sky((-scene.origin).as_vec3a()),
            _ if !is_seen => ViewFrom::Above,
            _ if camera.model == Model::Orthographic => {
                ViewFrom::Far(camera.axes().map_or(Vec3A::ZERO, |axes| axes.z_axis.as_vec3a()))
            }
            _ => ViewFrom::Place((camera.position() - scene.origin).as_vec3a()),
        }
    }
}

impl BakeTable {
    /// The points of an image of this size, on a mesh of `count` triangles.
    fn points(self, object: &str, size: [u32; 2], count: usize) -> Result<Vec<Option<BakePoint>>, BakeError> {
        let pixels = size[0] as usize * size[1] as usize;
        let lengths = [self.primitives.len(), self.weights.len(), self.differentials.len()];
        if lengths != [pixels; 3] || !(self.seeds.is_empty() || self.seeds.len() == pixels) {
            return Err(BakeError::Lengths(object.to_owned()));
        }
        let point = |i: usize| {
            let triangle = self.primitives[i];
            if triangle < 0 {
                return Ok(None);
            }
            if triangle as usize >= count {
                return Err(BakeError::NoTriangle { object: object.to_owned(), triangle, count });
            }
            let [along_u, up_u, along_v, up_v] = self.differentials[i];
            let own = [i as u32 % size[0], i as u32 / size[0]];
            let numbers_of = self.seeds.get(i).map_or(own, |seed| [seed & 0xffff, seed >> 16]);
            let steps = [[along_u, up_u], [along_v, up_v]];
            Ok(Some(BakePoint { triangle: triangle as u32, weights: self.weights[i], steps, numbers_of }))
        };
        (0..pixels).map(point).collect()
    }
}

/// A bake as a job takes it.
pub(super) struct Prepared {
    pub(super) settings: Settings,
    pub(super) output: OutputOptions,
    pub(super) baked: Baked,
}

impl BakeRequest {
    /// Checks the points and makes of them the arguments of a job. `guides`: the parts by which a denoiser is guided; `occlusion_distance`:
    /// length of the rays of ambient occlusion, Blender units, `None` without end.
    ///
    /// # Errors
    /// [`BakeError`].
    pub(super) fn prepared(
        self,
        stage: &PreparedScene,
        camera: &CameraDescription,
        settings: Settings,
        guides: Vec<LightPass>,
        occlusion_distance: Option<f32>,
    ) -> Result<Prepared, BakeError> {
        let Self { settings: bake, table } = self;
        let settings = bake.applied(settings);
        let result = bake.result();
        let wanted = match &result {
            BakeResult::Picture | BakeResult::Position | BakeResult::Shadow => Vec::new(),
            BakeResult::Light(parts) | BakeResult::Relative(parts) if !parts.is_empty() => parts.clone(),
            BakeResult::Light(_) | BakeResult::Relative(_) => return Err(BakeError::NoLight(bake.object_name)),
            BakeResult::Normal => vec![LightPass::ShadingNormal],
        };
        let scene = &stage.scene;
        let instance = scene.placed().iter().position(|instance| instance.is_baked);
        let instance = instance.ok_or_else(|| BakeError::NoObject(bake.object_name.clone()))?;
        let count = scene.meshes[scene.instances[instance].mesh as usize].triangles.len();
        let points = BakePoints {
            width: settings.width,
            instance: instance as u32,
            points: table.points(&bake.object_name, [settings.width, settings.height], count)?,
            view: bake.view(camera, scene),
        };
        let parts = Parts::new(&[wanted, guides].concat(), Seen::default()).occluded_within(occlusion_distance);
        let output = OutputOptions { parts, bake: Some(points), ..OutputOptions::default() };
        Ok(Prepared { settings, output, baked: Baked { kind: bake.kind, result } })
    }
}

impl Job {
    /// The result of a bake so far, RGBA, rows from below; `None` of a picture, and of shadows without a bake of the same object `alone`.
    pub fn baked(&self, alone: Option<&Self>) -> Option<Vec<[f32; 4]>> {
        let baked = self.baked.as_ref()?;
        let pixels: Vec<[f32; 3]> = match &baked.result {
            _ if baked.kind == BakeKind::Combined && self.is_denoised() => {
                self.picture().into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
            }
            BakeResult::Picture => self.picture().into_iter().map(|[r, g, b, _]| [r, g, b]).collect(),
            BakeResult::Light(parts) => sum(parts.iter().map(|&part| self.light_of(part)))?,
            BakeResult::Relative(parts) => sum(parts.iter().map(|&part| self.part(part)))?,
            BakeResult::Position => self.data(DataPass::Position).as_chunks().0.to_vec(),
            BakeResult::Normal => {
                let evaluated = self.part(LightPass::Evaluated)?;
                let own = self.data(DataPass::Normal);
                let shading = self.part(LightPass::ShadingNormal)?;
                let pixels = shading.into_iter().zip(own.as_chunks().0).zip(evaluated);
                pixels.map(|((shading, own), [count, ..])| if count > 0.0 { shading } else { *own }).collect()
            }
            BakeResult::Shadow => {
                let lit = alone?.picture();
                self.picture().into_iter().zip(lit).map(|(light, lit)| left(light, lit)).collect()
            }
        };
        let has_alpha = baked.has_alpha();
        let alphas = self.picture().into_iter().map(|[.., alpha]| if has_alpha { alpha } else { 1.0 });
        Some(pixels.into_iter().zip(alphas).map(|([r, g, b], alpha)| [r, g, b, alpha]).collect())
    }

    /// The light of a combined bake that holds not all of it; `None` of all else.
    pub(super) fn some_light(&self) -> Option<Vec<[f32; 3]>> {
        match self.baked.as_ref()? {
            Baked { kind: BakeKind::Combined, result: BakeResult::Light(parts) } => {
                sum(parts.iter().map(|&part| self.light_of(part)))
            }
            _ => None,
        }
    }

    /// A part as it is kept, not divided by its reference.
    fn light_of(&self, part: LightPass) -> Option<Vec<[f32; 3]>> {
        let place = self.shared.parts.place(part)?;
        Some(self.shared.film.parts()[place].picture().into_iter().map(|[r, g, b, _]| [r, g, b]).collect())
    }
}

/// The part of the light that is left; all of it where there is none, and of light through the surface.
fn left(light: [f32; 4], lit: [f32; 4]) -> [f32; 3] {
    let alpha = light[3];
    std::array::from_fn(|c| 1.0 - alpha + alpha * if lit[c] == 0.0 { 1.0 } else { light[c] / lit[c] })
}

/// The sum of pictures; `None` where there are none, or one is not kept.
fn sum(films: impl Iterator<Item = Option<Vec<[f32; 3]>>>) -> Option<Vec<[f32; 3]>> {
    let add = |[a, b]: [[f32; 3]; 2]| std::array::from_fn(|c| a[c] + b[c]);
    films.reduce(|a, b| Some(a?.into_iter().zip(b?).map(|(a, b)| add([a, b])).collect())).flatten()
}

#[cfg(test)]
mod tests;
