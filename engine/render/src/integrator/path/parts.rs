//! What of a path's light came by which lobe of the first surface, and what that surface looks like: the passes of light and
//! colour, as Cycles parts them (its manual, "Render Passes"; what counts as which lobe is `Lobe::rays`).
//!
//! Light that the camera sees itself is emission or environment. All other light is shared out by the first scattering: in a
//! volume it is the volume's, at a surface each kind of lobe takes its share of what was scattered in that direction. It is
//! direct if the first surface scattered it straight from an emitter. What was passed unbent before is no first surface.

use crate::Rgb;
use crate::integrator::Stage;
use crate::nodes::{View, Way};
use crate::shading::{LobeShares, Parted};
use crate::surface::SurfacePoint;
use glam::{DMat4, Mat3A, Vec3A};

/// Something that is kept beside the light as a whole, three numbers a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Light that a lobe of the first surface scattered; direct if it came straight from an emitter.
    Light(LobeKind, bool),
    /// Light that a volume scattered first; direct or not.
    Volume(bool),
    /// Emitters that the camera sees, but for the sky.
    Emission,
    /// The sky that the camera sees.
    Environment,
    /// How much of white light the lobes of the first surface scatter in all directions.
    Colour(LobeKind),
    /// 1 for every path: what colours are relative to.
    White,
    /// For a denoiser, of the first surface that is no mirror: what it scatters in all.
    DenoisingAlbedo,
    /// Its normal; right, up and away from the camera.
    DenoisingNormal,
    /// The way to it along the rays, Blender units; it stands in all three numbers.
    DenoisingDepth,
    /// Output number so many of the shaders.
    Aov(u16),
    /// 1 where that is given out, three times.
    AovAlpha(u16),
    /// Light that the first surface scatters where it is to catch shadows.
    Caught,
    /// 1 for every path that found such a surface first, and for every one that found any, and once more.
    Catches,
    /// Texture coordinates and 1, of the first surface.
    Uv,
    /// 1 less what mist leaves, three times.
    Mist,
    /// 1 for every path that counts as data: what these are relative to.
    Ray,
}

/// A kind of lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LobeKind {
    /// Without a peak, on either side.
    Diffuse,
    /// Reflected about a peak.
    Glossy,
    /// Let through and bent, or scattered about a peak.
    Transmission,
}

impl Part {
    /// Whether it counts as data do: each ray alike, for the pixel that it was started for. Else as light, where it lands.
    pub fn is_data(self) -> bool {
        use Part::{Aov, AovAlpha, Catches, DenoisingAlbedo, DenoisingDepth, DenoisingNormal, Mist, Ray, Uv};
        matches!(
            self,
            DenoisingAlbedo | DenoisingNormal | DenoisingDepth | Aov(_) | AovAlpha(_) | Catches | Uv | Mist | Ray
        )
    }

    /// What it is divided by: light by the colour that scattered it, what is a mean by what it is of.
    pub fn relative_to(self) -> Option<Self> {
        match self {
            Self::Light(lobe, _) => Some(Self::Colour(lobe)),
            Self::Colour(_) => Some(Self::White),
            part if part.is_data() && part != Self::Ray => Some(Self::Ray),
            _ => None,
        }
    }
}

/// Axes and place of the camera, render space, for what is counted from it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    to_camera: Mat3A,
    place: Vec3A,
    /// Depth along the axis counts, not the distance.
    is_flat: bool,
    /// Where mist begins, one over how deep it is, and the power of its falloff.
    mist: [f32; 3],
}

impl Seen {
    /// By a camera of that matrix to the world, and the render space's origin there. `mist`: start, depth and the power by
    /// which it falls off.
    pub fn by(camera: DMat4, origin: glam::DVec3, is_flat: bool, mist: [f32; 3]) -> Self {
        let axes = [camera.x_axis, camera.y_axis, camera.z_axis].map(|axis| axis.truncate().normalize_or_zero());
        let rows = glam::DMat3::from_cols(axes[0], axes[1], axes[2]).transpose();
        let [start, depth, power] = mist;
        Self {
            to_camera: Mat3A::from(rows.as_mat3()),
            place: (camera.w_axis.truncate() - origin).as_vec3a(),
            is_flat,
            mist: [start, if depth > 0.0 { depth.recip() } else { 0.0 }, power],
        }
    }

    /// 1 less what mist leaves of a place.
    pub fn clear(&self, position: Vec3A) -> f32 {
        let from = self.to_camera * (position - self.place);
        let distance = if self.is_flat { -from.z } else { from.length() };
        let [start, per_depth, power] = self.mist;
        1.0 - ((distance - start) * per_depth).clamp(0.0, 1.0).powf(power)
    }
}

/// What is kept, and the numbers of its places.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    list: Vec<Part>,
    seen: Seen,
}

impl Parts {
    /// These, and what they are relative to.
    pub fn new(wanted: &[Part], seen: Seen) -> Self {
        let mut list: Vec<Part> = Vec::new();
        for part in wanted {
            let mut next = Some(*part);
            while let Some(part) = next {
                if !list.contains(&part) {
                    list.push(part);
                }
                next = part.relative_to();
            }
        }
        Self { list, seen }
    }

    /// All that is kept.
    pub fn list(&self) -> &[Part] {
        &self.list
    }

    /// Where a part stands among them.
    pub fn place(&self, part: Part) -> Option<usize> {
        self.list.iter().position(|one| *one == part)
    }

    /// By whom the scene is seen.
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    fn any(&self, which: impl Fn(&Part) -> bool) -> bool {
        self.list.iter().any(which)
    }
}

/// How a path's light is shared out.
#[derive(Clone, Copy, Debug)]
enum First {
    /// The camera sees it.
    None,
    /// By a surface: diffuse and glossy shares; the rest was let through.
    Surface([Rgb; 2]),
    /// By a volume.
    Volume,
}

/// What light belongs to.
#[derive(Clone, Copy, Debug)]
pub struct Belongs {
    first: First,
    /// Direct, or where the camera sees it, the sky.
    is_near: bool,
    /// The path's ray met it.
    is_met: bool,
}

/// A path's own.
#[derive(Clone, Copy, Debug)]
struct Path {
    first: First,
    /// What mirrors before the surface of the denoiser's passes left; `None` behind it.
    features: Option<Rgb>,
    is_caught: bool,
}

/// Notes parts of paths.
pub struct ByPart {
    parts: Parts,
    has_colours: bool,
    has_features: bool,
    has_aovs: bool,
    paths: Vec<Path>,
}

impl ByPart {
    /// For these.
    pub fn new(parts: Parts) -> Self {
        let has_colours = parts.any(|part| matches!(part, Part::Colour(_)));
        let has_features =
            parts.any(|part| matches!(part, Part::DenoisingAlbedo | Part::DenoisingNormal | Part::DenoisingDepth));
        let has_aovs = parts.any(|part| matches!(part, Part::Aov(_)));
        Self { parts, has_colours, has_features, has_aovs, paths: Vec::new() }
    }

    /// How many numbers of three a path has.
    pub fn count(&self) -> usize {
        self.parts.list.len()
    }

    pub(super) fn clear(&mut self) {
        self.paths.clear();
    }

    /// A path whose places are `sums`, all 0 so far.
    pub(super) fn start(&mut self, sums: &mut [Rgb]) {
        if self.parts.list.is_empty() {
            return;
        }
        self.paths.push(Path { first: First::None, features: Some(Rgb::ONE), is_caught: false });
        for one in [Part::White, Part::Ray] {
            self.add_to(sums, one, Rgb::ONE);
        }
    }

    fn add_to(&self, sums: &mut [Rgb], part: Part, value: Rgb) {
        if let Some(place) = self.parts.place(part).filter(|_| value.is_finite()) {
            sums[place] += value;
        }
    }

    /// Light that the path's ray meets.
    pub(super) fn met(&self, path: u32, way: Way, is_sky: bool) -> Belongs {
        match self.paths.get(path as usize).map_or(First::None, |path| path.first) {
            First::None => Belongs { first: First::None, is_near: is_sky, is_met: true },
            first => Belongs { first, is_near: way.depth == 1, is_met: true },
        }
    }

    /// Light that the path's surface scatters along it; `shares` are those of the lobes in this direction.
    pub(super) fn sampled(&self, path: u32, way: Way, shares: impl FnOnce() -> LobeShares) -> Belongs {
        let first = || First::Surface(shares().parts());
        self.scattered(path, way, first)
    }

    /// The same in a volume.
    pub(super) fn sampled_in_volume(&self, path: u32, way: Way) -> Belongs {
        self.scattered(path, way, || First::Volume)
    }

    fn scattered(&self, path: u32, way: Way, here: impl FnOnce() -> First) -> Belongs {
        let is_near = way.depth == 0;
        let first = match self.paths.get(path as usize) {
            Some(_) if is_near => here(),
            Some(path) => path.first,
            None => First::None,
        };
        Belongs { first, is_near, is_met: false }
    }

    /// The path was scattered by a surface; `shares` are those of the lobes.
    pub(super) fn turned(&mut self, path: u32, way: Way, shares: impl FnOnce() -> LobeShares) {
        if let Some(path) = self.paths.get_mut(path as usize).filter(|_| way.depth == 0) {
            path.first = First::Surface(shares().parts());
        }
    }

    /// It was scattered in a volume.
    pub(super) fn turned_in_volume(&mut self, path: u32, way: Way) {
        if let Some(path) = self.paths.get_mut(path as usize) {
            // As in Cycles, what a denoiser is told ends there.
            path.features = None;
            if way.depth == 0 {
                path.first = First::Volume;
            }
        }
    }

    /// Shares out light that a path found.
    pub(super) fn add(&self, sums: &mut [Rgb], path: u32, of: Belongs, light: Rgb) {
        if self.parts.list.is_empty() {
            return;
        }
        let Belongs { first, is_near, is_met } = of;
        if self.paths[path as usize].is_caught {
            self.add_to(sums, Part::Caught, light);
        }
        if let Some(left) = self.paths[path as usize].features.filter(|_| self.has_features && is_met) {
            self.add_to(sums, Part::DenoisingAlbedo, light * left);
        }
        match first {
            First::None => self.add_to(sums, if is_near { Part::Environment } else { Part::Emission }, light),
            First::Volume => self.add_to(sums, Part::Volume(is_near), light),
            First::Surface([diffuse, glossy]) => {
                let [d, g] = [light * diffuse, light * glossy];
                self.add_to(sums, Part::Light(LobeKind::Diffuse, is_near), d);
                self.add_to(sums, Part::Light(LobeKind::Glossy, is_near), g);
                self.add_to(sums, Part::Light(LobeKind::Transmission, is_near), light * (Rgb::ONE - diffuse - glossy));
            }
        }
    }

    /// A surface that scatters the path and what comes to it by `throughput`.
    pub(super) fn looks_at(
        &mut self,
        sums: &mut [Rgb],
        path: u32,
        way: Way,
        throughput: Rgb,
        bsdf: &impl Parted,
        distance: f32,
    ) {
        let is_first = way.depth == 0;
        if is_first && self.has_colours {
            let [diffuse, glossy, transmission] = bsdf.albedos().map(|albedo| albedo * throughput);
            self.add_to(sums, Part::Colour(LobeKind::Diffuse), diffuse);
            self.add_to(sums, Part::Colour(LobeKind::Glossy), glossy);
            self.add_to(sums, Part::Colour(LobeKind::Transmission), transmission);
        }
        if !self.has_features {
            return;
        }
        let Some(left) = self.paths[path as usize].features else { return };
        let average = left.element_sum() / 3.0;
        self.add_to(sums, Part::DenoisingDepth, Rgb::splat(average * distance));
        let seen = bsdf.features();
        if seen.goes_on {
            self.paths[path as usize].features = Some(left * seen.mirrored);
            return;
        }
        self.add_to(sums, Part::DenoisingAlbedo, left * seen.albedo);
        // As in Cycles, whose camera looks along its z.
        let normal = self.parts.seen.to_camera * seen.normal * Vec3A::new(1.0, 1.0, -1.0);
        self.add_to(sums, Part::DenoisingNormal, Rgb::from(normal) * average);
        self.paths[path as usize].features = None;
    }

    /// The first surface that the path did not pass.
    pub(super) fn finds(&mut self, sums: &mut [Rgb], path: u32, stage: &Stage, point: &SurfacePoint, view: &View) {
        let scene = &stage.scene;
        if let Some(place) = self.parts.place(Part::Catches) {
            let is_caught = scene.instances[point.instance as usize].is_catcher;
            self.paths[path as usize].is_caught = is_caught;
            sums[place] = Rgb::new(f32::from(u8::from(is_caught)), 1.0, 1.0);
        }
        if let Some(place) = self.parts.place(Part::Uv) {
            let uv = crate::surface::uv(
                crate::surface::mesh_of(scene, point.instance),
                point.triangle,
                point.barycentric,
                None,
            );
            sums[place] = Rgb::new(uv.x, uv.y, 1.0);
        }
        if let Some(place) = self.parts.place(Part::Mist) {
            sums[place] = Rgb::splat(self.parts.seen.clear(point.position));
        }
        if self.has_aovs {
            crate::nodes::aovs(stage.around(), point, view, |number, value| {
                if let Some(place) = self.parts.place(Part::Aov(number)).filter(|_| value.is_finite()) {
                    sums[place] = value;
                }
                if let Some(place) = self.parts.place(Part::AovAlpha(number)) {
                    sums[place] = Rgb::ONE;
                }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is asked for comes once, with all that it is divided by.
    #[test]
    fn what_parts_are_relative_to_is_kept() {
        let direct = Part::Light(LobeKind::Glossy, true);
        let parts = Parts::new(&[direct, Part::Light(LobeKind::Glossy, false), Part::Mist], Seen::default());
        let colour = Part::Colour(LobeKind::Glossy);
        let expected = [direct, colour, Part::White, Part::Light(LobeKind::Glossy, false), Part::Mist, Part::Ray];
        assert_eq!(parts.list(), expected);
        assert_eq!(parts.place(Part::Emission), None);
    }

    /// Of light the shares are all of it, whichever way it comes.
    #[test]
    fn all_light_is_shared_out() {
        let lobes = [LobeKind::Diffuse, LobeKind::Glossy, LobeKind::Transmission];
        let light = lobes.iter().flat_map(|&lobe| [Part::Light(lobe, true), Part::Light(lobe, false)]);
        let rest = [Part::Volume(true), Part::Volume(false), Part::Emission, Part::Environment];
        let wanted: Vec<Part> = light.chain(rest).collect();
        let mut by_part = ByPart::new(Parts::new(&wanted, Seen::default()));
        let mut sums = vec![Rgb::ZERO; by_part.count()];
        by_part.start(&mut sums);
        let shares =
            || LobeShares { diffuse: Rgb::new(1.0, 0.0, 2.0), glossy: Rgb::splat(1.0), transmission: Rgb::splat(2.0) };
        let light = Rgb::new(1.0, 2.0, 3.0);
        let seen = by_part.met(0, Way::CAMERA, true);
        by_part.add(&mut sums, 0, seen, light);
        let sampled = by_part.sampled(0, Way::CAMERA, shares);
        by_part.add(&mut sums, 0, sampled, light);
        by_part.turned(0, Way::CAMERA, shares);
        let after = Way::CAMERA.scattered(true, false, false);
        for way in [after, after.scattered(false, true, false)] {
            let met = by_part.met(0, way, false);
            by_part.add(&mut sums, 0, met, light);
        }
        let of = |part| sums[by_part.parts.place(part).unwrap()];
        assert_eq!(of(Part::Environment), light);
        // By a light sample and by the path.
        assert!((of(Part::Light(LobeKind::Diffuse, true)) - 2.0 * light * Rgb::new(0.25, 0.0, 0.4)).length() < 1e-6);
        assert!((of(Part::Light(LobeKind::Glossy, false)) - light * Rgb::new(0.25, 1.0 / 3.0, 0.2)).length() < 1e-6);
        let all: Rgb = wanted.iter().map(|&part| of(part)).sum();
        assert!((all - 4.0 * light).length() < 1e-5, "{all}");
    }

    /// Between its ends mist grows by its power; before and behind them it does not.
    #[test]
    fn mist_grows_with_distance() {
        let seen = Seen::by(DMat4::IDENTITY, glam::DVec3::ZERO, false, [1.0, 2.0, 2.0]);
        for (z, clear) in [(0.5, 1.0), (2.0, 0.75), (3.0, 0.0), (9.0, 0.0)] {
            assert!((seen.clear(Vec3A::new(0.0, 0.0, -z)) - clear).abs() < 1e-6);
        }
    }
}
