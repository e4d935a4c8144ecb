//! The shares of a path's light by lobe of the first surface, and the features of that surface: the values of [`super::parts`] (which
//! closures count as which lobe is `Lobe::rays`).
//!
//! Light that the camera sees itself is emission or environment. All other light is shared out by the first scattering: in a
//! volume it is the volume's, at a surface each kind of lobe takes its share of the light that was scattered in that direction. It is
//! direct if the first surface scattered it straight from an emitter. A surface that was passed unbent before is no first surface.

use super::parts::{LightPass, LobeKind, Parts};
use crate::Rgb;
use crate::integrator::PreparedScene;
use crate::nodes::{PathState, View};
use crate::shading::{LobeDecomposition, LobeShares};
use crate::surface::SurfacePoint;
use glam::Vec3A;

/// The lobes of the first scattering, by which a path's light is shared out.
#[derive(Clone, Copy, Debug)]
enum First {
    /// The camera sees the light.
    None,
    /// A surface: diffuse and glossy shares; the rest is transmission.
    Surface([Rgb; 2]),
    /// A volume, whose light has parts of its own.
    Volume,
    /// No origin that counts: the light is in no part.
    Nowhere,
    /// No light, but the part that ambient occlusion leaves.
    Occlusion,
}

/// The parts that light belongs to.
#[derive(Clone, Copy, Debug)]
pub struct LightOrigin {
    first: First,
    /// True if the light is direct, or where the camera sees it, the sky.
    is_near: bool,
    /// True if the path's ray hit the light.
    is_met: bool,
}

impl LightOrigin {
    /// Light that is in no part.
    pub(super) fn nowhere() -> Self {
        Self { first: First::Nowhere, is_near: false, is_met: false }
    }

    /// The share that ambient occlusion leaves, which is no light.
    pub(super) fn occlusion() -> Self {
        Self { first: First::Occlusion, is_near: false, is_met: false }
    }

    /// True if it counts for the picture.
    pub(super) fn is_light(self) -> bool {
        !matches!(self.first, First::Occlusion)
    }
}

/// The part of a path's light, and its features.
#[derive(Clone, Copy, Debug)]
struct PathPart {
    first: First,
    /// Reflectance of the mirrors before the surface of the denoiser's passes; `None` behind it.
    features: Option<Rgb>,
    is_caught: bool,
}

/// Notes parts of paths.
pub(super) struct ByPart {
    parts: Parts,
    has_colours: bool,
    has_features: bool,
    has_aovs: bool,
    has_occlusion: bool,
    has_means: bool,
    paths: Vec<PathPart>,
}

impl ByPart {
    /// Notes that keep these parts, of no path yet.
    pub(super) fn new(parts: Parts) -> Self {
        let has_colours = parts.any(|part| matches!(part, LightPass::Colour(_)));
        let has_features = parts.any(|part| {
            matches!(part, LightPass::DenoisingAlbedo | LightPass::DenoisingNormal | LightPass::DenoisingDepth)
        });
        let has_aovs = parts.any(|part| matches!(part, LightPass::Aov(_)));
        let has_occlusion = parts.any(|part| *part == LightPass::Occlusion);
        let has_means = parts.any(|part| matches!(part, LightPass::ShadingNormal | LightPass::Roughness));
        Self { parts, has_colours, has_features, has_aovs, has_occlusion, has_means, paths: Vec::new() }
    }

    /// Number of colours that a path has.
    pub(super) fn count(&self) -> usize {
        self.parts.list().len()
    }

    pub(super) fn clear(&mut self) {
        self.paths.clear();
    }

    /// A path whose places are `sums`, all 0 so far.
    pub(super) fn start(&mut self, sums: &mut [Rgb]) {
        if self.parts.list().is_empty() {
            return;
        }
        self.paths.push(PathPart { first: First::None, features: Some(Rgb::ONE), is_caught: false });
        for one in [LightPass::White, LightPass::Ray] {
            self.add_to(sums, one, Rgb::ONE);
        }
    }

    fn add_to(&self, sums: &mut [Rgb], part: LightPass, value: Rgb) {
        if let Some(place) = self.parts.place(part).filter(|_| value.is_finite()) {
            sums[place] += value;
        }
    }

    /// Light that the path's ray hits.
    pub(super) fn met(&self, path: u32, way: PathState, is_sky: bool) -> LightOrigin {
        match self.paths.get(path as usize).map_or(First::None, |path| path.first) {
            First::None => LightOrigin { first: First::None, is_near: is_sky, is_met: true },
            first => LightOrigin { first, is_near: way.depth == 1, is_met: true },
        }
    }

    /// Light that the path's surface scatters along it; `shares` are those of the lobes in this direction.
    pub(super) fn sampled(&self, path: u32, way: PathState, shares: impl FnOnce() -> LobeShares) -> LightOrigin {
        let first = || First::Surface(shares().parts());
        self.scattered(path, way, first)
    }

    /// Light that a volume scatters along the path.
    pub(super) fn sampled_in_volume(&self, path: u32, way: PathState) -> LightOrigin {
        self.scattered(path, way, || First::Volume)
    }

    fn scattered(&self, path: u32, way: PathState, here: impl FnOnce() -> First) -> LightOrigin {
        let is_near = way.depth == 0;
        let first = match self.paths.get(path as usize) {
            Some(_) if is_near => here(),
            Some(path) => path.first,
            None => First::None,
        };
        LightOrigin { first, is_near, is_met: false }
    }

    /// The path was scattered by a surface; `shares` are those of the lobes.
    pub(super) fn turned(&mut self, path: u32, way: PathState, shares: impl FnOnce() -> LobeShares) {
        if let Some(path) = self.paths.get_mut(path as usize).filter(|_| way.depth == 0) {
            path.first = First::Surface(shares().parts());
        }
    }

    /// The path was scattered in a volume.
    pub(super) fn turned_in_volume(&mut self, path: u32, way: PathState) {
        if let Some(path) = self.paths.get_mut(path as usize) {
            // As in Cycles, what a denoiser is told ends there.
            path.features = None;
            if way.depth == 0 {
                path.first = First::Volume;
            }
        }
    }

    /// Shares out light that a path found.
    pub(super) fn add(&self, sums: &mut [Rgb], path: u32, of: LightOrigin, light: Rgb) {
        if self.parts.list().is_empty() {
            return;
        }
        let LightOrigin { first, is_near, is_met } = of;
        if !of.is_light() {
            return self.add_to(sums, LightPass::Occlusion, light);
        }
        if self.paths[path as usize].is_caught {
            self.add_to(sums, LightPass::Caught, light);
        }
        if let Some(left) = self.paths[path as usize].features.filter(|_| self.has_features && is_met) {
            self.add_to(sums, LightPass::DenoisingAlbedo, light * left);
        }
        match first {
            First::None => self.add_to(sums, if is_near { LightPass::Environment } else { LightPass::Emission }, light),
            First::Volume => self.add_to(sums, LightPass::Volume(is_near), light),
            First::Nowhere | First::Occlusion => {}
            First::Surface([diffuse, glossy]) => {
                let [d, g] = [light * diffuse, light * glossy];
                self.add_to(sums, LightPass::Light(LobeKind::Diffuse, is_near), d);
                self.add_to(sums, LightPass::Light(LobeKind::Glossy, is_near), g);
                self.add_to(
                    sums,
                    LightPass::Light(LobeKind::Transmission, is_near),
                    light * (Rgb::ONE - diffuse - glossy),
                );
            }
        }
    }

    /// True if something is noted of surfaces that scatter nothing.
    pub(super) fn looks(&self) -> bool {
        self.has_features || self.has_occlusion || self.has_means
    }

    /// True if the light of the sky that the camera sees is noted.
    pub(super) fn keeps_sky(&self) -> bool {
        self.parts.place(LightPass::Environment).is_some()
    }

    /// Length of the ambient occlusion ray of a path's surface, Blender units; `None`: there is none.
    pub(super) fn occlusion_distance(&self, way: PathState) -> Option<f32> {
        (self.has_occlusion && way.depth == 0).then(|| self.parts.occlusion_distance())
    }

    /// The surface that the path's first ray comes to, whether it is passed or not.
    pub(super) fn evaluates(&self, sums: &mut [Rgb], way: PathState, bsdf: &impl LobeDecomposition) {
        if !self.has_means || way.depth > 0 || way.transparent > 0 {
            return;
        }
        let means = bsdf.means();
        self.add_to(sums, LightPass::ShadingNormal, means.normal.into());
        self.add_to(sums, LightPass::Roughness, Rgb::splat(means.roughness));
        self.add_to(sums, LightPass::Evaluated, Rgb::ONE);
    }

    /// A surface that scatters the path, and the `throughput` up to it.
    pub(super) fn looks_at(
        &mut self,
        sums: &mut [Rgb],
        path: u32,
        way: PathState,
        throughput: Rgb,
        bsdf: &impl LobeDecomposition,
        distance: f32,
    ) {
        let is_first = way.depth == 0;
        if is_first && self.has_colours {
            let [diffuse, glossy, transmission] = bsdf.albedos().map(|albedo| albedo * throughput);
            self.add_to(sums, LightPass::Colour(LobeKind::Diffuse), diffuse);
            self.add_to(sums, LightPass::Colour(LobeKind::Glossy), glossy);
            self.add_to(sums, LightPass::Colour(LobeKind::Transmission), transmission);
        }
        if !self.has_features {
            return;
        }
        let Some(left) = self.paths[path as usize].features else { return };
        let average = left.element_sum() / 3.0;
        self.add_to(sums, LightPass::DenoisingDepth, Rgb::splat(average * distance));
        let seen = bsdf.features();
        if seen.goes_on {
            self.paths[path as usize].features = Some(left * seen.mirrored);
            return;
        }
        self.add_to(sums, LightPass::DenoisingAlbedo, left * seen.albedo);
        let normal = self.parts.seen().turned(seen.normal);
        self.add_to(sums, LightPass::DenoisingNormal, Rgb::from(normal) * average);
        self.paths[path as usize].features = None;
    }

    /// The first surface that the path did not pass.
    pub(super) fn finds(
        &mut self,
        sums: &mut [Rgb],
        path: u32,
        stage: &PreparedScene,
        point: &SurfacePoint,
        view: &View,
    ) {
        let scene = &stage.scene;
        if let Some(place) = self.parts.place(LightPass::Catches) {
            let is_caught = scene.instances[point.instance as usize].is_catcher;
            self.paths[path as usize].is_caught = is_caught;
            sums[place] = Rgb::new(f32::from(u8::from(is_caught)), 1.0, 1.0);
        }
        if let Some(place) = self.parts.place(LightPass::Uv) {
            let uv = crate::surface::uv(
                crate::surface::mesh_of(scene, point.instance),
                point.triangle,
                point.barycentric,
                None,
            );
            sums[place] = Rgb::new(uv.x, uv.y, 1.0);
        }
        if let Some(place) = self.parts.place(LightPass::Mist) {
            sums[place] = Rgb::splat(self.parts.seen().clear(point.position));
        }
        if self.has_aovs {
            crate::nodes::aovs(stage.around(), point, view, |number, value| self.set_aov(sums, number, value));
        }
    }

    /// The world at the end of a camera ray, whose places are `sums`.
    pub(super) fn finds_world(&self, sums: &mut [Rgb], stage: &PreparedScene, direction: Vec3A, way: PathState) {
        let scene = &stage.scene;
        if let Some(aovs) =
            scene.world.aovs.as_ref().filter(|_| self.has_aovs && scene.world.visible.all_of(way.finds()))
        {
            crate::nodes::world::aovs(aovs, scene, direction, way, |number, value| self.set_aov(sums, number, value));
        }
    }

    fn set_aov(&self, sums: &mut [Rgb], number: u16, value: Rgb) {
        if let Some(place) = self.parts.place(LightPass::Aov(number)).filter(|_| value.is_finite()) {
            sums[place] = value;
        }
        if let Some(place) = self.parts.place(LightPass::AovAlpha(number)) {
            sums[place] = Rgb::ONE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parts::Seen;
    use super::*;

    /// The shares of light add up to all of it, in all directions.
    #[test]
    fn all_light_is_shared_out() {
        let lobes = [LobeKind::Diffuse, LobeKind::Glossy, LobeKind::Transmission];
        let light = lobes.iter().flat_map(|&lobe| [LightPass::Light(lobe, true), LightPass::Light(lobe, false)]);
        let rest = [LightPass::Volume(true), LightPass::Volume(false), LightPass::Emission, LightPass::Environment];
        let wanted: Vec<LightPass> = light.chain(rest).collect();
        let mut by_part = ByPart::new(Parts::new(&wanted, Seen::default()));
        let mut sums = vec![Rgb::ZERO; by_part.count()];
        by_part.start(&mut sums);
        let shares =
            || LobeShares { diffuse: Rgb::new(1.0, 0.0, 2.0), glossy: Rgb::splat(1.0), transmission: Rgb::splat(2.0) };
        let light = Rgb::new(1.0, 2.0, 3.0);
        let seen = by_part.met(0, PathState::CAMERA, true);
        by_part.add(&mut sums, 0, seen, light);
        let sampled = by_part.sampled(0, PathState::CAMERA, shares);
        by_part.add(&mut sums, 0, sampled, light);
        by_part.turned(0, PathState::CAMERA, shares);
        let after = PathState::CAMERA.scattered(true, false, false);
        for way in [after, after.scattered(false, true, false)] {
            let met = by_part.met(0, way, false);
            by_part.add(&mut sums, 0, met, light);
        }
        let of = |part| sums[by_part.parts.place(part).unwrap()];
        assert_eq!(of(LightPass::Environment), light);
        // By a light sample and by the path.
        assert!(
            (of(LightPass::Light(LobeKind::Diffuse, true)) - 2.0 * light * Rgb::new(0.25, 0.0, 0.4)).length() < 1e-6
        );
        assert!(
            (of(LightPass::Light(LobeKind::Glossy, false)) - light * Rgb::new(0.25, 1.0 / 3.0, 0.2)).length() < 1e-6
        );
        let all: Rgb = wanted.iter().map(|&part| of(part)).sum();
        assert!((all - 4.0 * light).length() < 1e-5, "{all}");
    }
}
