//! The parts of a path's light that are kept beside the whole, and features of the first surface: the passes of light and colour, as Cycles
//! parts them (its manual, "Render Passes"). [`super::by_part`] puts light into the parts.

use crate::camera::unit_axes;
use glam::{DMat4, Mat3A, Vec3A};

/// Something that is kept beside the light as a whole, three numbers a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPass {
    /// Light that a lobe of the first surface scattered; direct if it came straight from an emitter.
    Light(LobeKind, bool),
    /// Light that a volume scattered first; direct or not.
    Volume(bool),
    /// Emitters that the camera sees, but for the sky.
    Emission,
    /// The sky that the camera sees.
    Environment,
    /// The part of white light that the lobes of the first surface scatter in all directions.
    Colour(LobeKind),
    /// 1 for every path: the divisor of colours.
    White,
    /// A denoiser's guide: albedo of the first surface that is no mirror.
    DenoisingAlbedo,
    /// A denoiser's guide: normal of the first surface that is no mirror; right, up and away from the camera.
    DenoisingNormal,
    /// A denoiser's guide: path length to the first surface that is no mirror, Blender units; in all three numbers.
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
    /// Mist: 1 less its transmittance, three times.
    Mist,
    /// 1 for every path that counts as data: the base of data.
    Ray,
    /// Ambient occlusion: the part of rays, spread by the cosine about the first surface's diffuse normal, that nothing near stops.
    Occlusion,
    /// Shading normal of the first surface, world space: the mean of its closures'.
    ShadingNormal,
    /// Roughness of the first surface, three times: the mean of its closures'.
    Roughness,
    /// 1 for every path whose first surface has closures that were evaluated: the divisor of normal and roughness.
    Evaluated,
}

/// A kind of lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LobeKind {
    /// Lobes without a peak, on either side.
    Diffuse,
    /// Lobes of reflection about a peak.
    Glossy,
    /// Lobes of light that is let through and bent, or scattered about a peak.
    Transmission,
}

impl LightPass {
    /// The number of the part, a different one for each.
    fn number(self) -> usize {
        match self {
            Self::Light(lobe, is_direct) => 2 * lobe as usize + usize::from(is_direct),
            Self::Volume(is_direct) => 6 + usize::from(is_direct),
            Self::Colour(lobe) => 8 + lobe as usize,
            Self::Emission => 11,
            Self::Environment => 12,
            Self::White => 13,
            Self::DenoisingAlbedo => 14,
            Self::DenoisingNormal => 15,
            Self::DenoisingDepth => 16,
            Self::Caught => 17,
            Self::Catches => 18,
            Self::Uv => 19,
            Self::Mist => 20,
            Self::Ray => 21,
            Self::Occlusion => 22,
            Self::ShadingNormal => 23,
            Self::Roughness => 24,
            Self::Evaluated => 25,
            Self::Aov(output) => 26 + 2 * usize::from(output),
            Self::AovAlpha(output) => 27 + 2 * usize::from(output),
        }
    }

    /// True if the part counts as data do: each ray alike, for the pixel that it was started for. Else it counts as light, where it lands.
    pub fn is_data(self) -> bool {
        use LightPass::{Aov, AovAlpha, Catches, DenoisingAlbedo, DenoisingDepth, DenoisingNormal, Mist, Ray, Uv};
        use LightPass::{Evaluated, Roughness, ShadingNormal};
        matches!(
            self,
            DenoisingAlbedo | DenoisingNormal | DenoisingDepth | Aov(_) | AovAlpha(_) | Catches | Uv | Mist | Ray
        ) || matches!(self, ShadingNormal | Roughness | Evaluated)
    }

    /// The divisor of a part: the colour for the light that it scattered, the number of rays for a mean.
    pub fn relative_to(self) -> Option<Self> {
        match self {
            Self::Light(lobe, _) => Some(Self::Colour(lobe)),
            Self::Colour(_) | Self::Occlusion => Some(Self::White),
            Self::ShadingNormal | Self::Roughness => Some(Self::Evaluated),
            Self::Evaluated => None,
            part if part.is_data() && part != Self::Ray => Some(Self::Ray),
            _ => None,
        }
    }
}

/// Axes and place of the camera, render space, for values that are counted from it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    to_camera: Mat3A,
    place: Vec3A,
    /// True if depth is counted along the axis, not as distance.
    is_flat: bool,
    /// Start of the mist, the reciprocal of its depth, and the power of its falloff.
    mist: [f32; 3],
}

impl Seen {
    /// The view of a camera of that matrix to the world, and of render space's origin there. `mist`: start, depth and the power by which it
    /// falls off.
    pub fn by(camera: DMat4, origin: glam::DVec3, is_flat: bool, mist: [f32; 3]) -> Self {
        // What has no axes is told by who makes the camera.
        let to_camera = unit_axes(&camera).unwrap_or_default().inverse();
        let [start, depth, power] = mist;
        Self {
            to_camera: Mat3A::from(to_camera.as_mat3()),
            place: (camera.w_axis.truncate() - origin).as_vec3a(),
            is_flat,
            mist: [start, if depth > 0.0 { depth.recip() } else { 0.0 }, power],
        }
    }

    /// A direction by the camera's axes: right, up and, as in Cycles, the way that it looks.
    pub fn turned(&self, direction: Vec3A) -> Vec3A {
        self.to_camera * direction * Vec3A::new(1.0, 1.0, -1.0)
    }

    /// The transmittance of the mist from the camera to a place.
    pub fn clear(&self, position: Vec3A) -> f32 {
        let from = self.to_camera * (position - self.place);
        let distance = if self.is_flat { -from.z } else { from.length() };
        let [start, per_depth, power] = self.mist;
        1.0 - ((distance - start) * per_depth).clamp(0.0, 1.0).powf(power)
    }
}

/// The parts that are kept, and their places in the list.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    list: Vec<LightPass>,
    /// Places in the list, by [`LightPass::number`].
    places: Vec<Option<u16>>,
    seen: Seen,
    /// Length of the rays of [`LightPass::Occlusion`], Blender units; `None`: without end.
    occlusion_distance: Option<f32>,
}

impl Parts {
    /// The parts that are wanted, and those that they are relative to.
    pub fn new(wanted: &[LightPass], seen: Seen) -> Self {
        let mut list: Vec<LightPass> = Vec::new();
        for part in wanted {
            let mut next = Some(*part);
            while let Some(part) = next {
                if !list.contains(&part) {
                    list.push(part);
                }
                next = part.relative_to();
            }
        }
        let mut places = Vec::new();
        for (place, part) in list.iter().enumerate() {
            let number = part.number();
            places.resize(places.len().max(number + 1), None);
            places[number] = Some(place as u16);
        }
        Self { list, places, seen, occlusion_distance: None }
    }

    /// These parts with ambient occlusion by rays of this length, Blender units; `None`: without end.
    #[must_use]
    pub fn occluded_within(self, occlusion_distance: Option<f32>) -> Self {
        Self { occlusion_distance, ..self }
    }

    /// Length of the rays of ambient occlusion, Blender units.
    pub fn occlusion_distance(&self) -> f32 {
        self.occlusion_distance.unwrap_or(f32::INFINITY)
    }

    /// All that is kept.
    pub fn list(&self) -> &[LightPass] {
        &self.list
    }

    /// The place of a part in the list.
    pub fn place(&self, part: LightPass) -> Option<usize> {
        self.places.get(part.number()).copied().flatten().map(usize::from)
    }

    /// The camera from which the scene is seen.
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    /// True if any of the parts satisfies `which`.
    pub fn any(&self, which: impl Fn(&LightPass) -> bool) -> bool {
        self.list.iter().any(which)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each requested part is kept once, with all its divisors.
    #[test]
    fn what_parts_are_relative_to_is_kept() {
        let direct = LightPass::Light(LobeKind::Glossy, true);
        let parts = Parts::new(&[direct, LightPass::Light(LobeKind::Glossy, false), LightPass::Mist], Seen::default());
        let colour = LightPass::Colour(LobeKind::Glossy);
        let expected = [
            direct,
            colour,
            LightPass::White,
            LightPass::Light(LobeKind::Glossy, false),
            LightPass::Mist,
            LightPass::Ray,
        ];
        assert_eq!(parts.list(), expected);
        assert_eq!(parts.place(LightPass::Emission), None);
    }

    /// However many there are, each has a place of its own.
    #[test]
    fn all_parts_have_places() {
        let lobes = [LobeKind::Diffuse, LobeKind::Glossy, LobeKind::Transmission];
        let mut wanted: Vec<LightPass> =
            lobes.iter().flat_map(|&lobe| [LightPass::Light(lobe, true), LightPass::Light(lobe, false)]).collect();
        wanted.extend([
            LightPass::Volume(true),
            LightPass::Volume(false),
            LightPass::Emission,
            LightPass::Environment,
            LightPass::DenoisingAlbedo,
        ]);
        wanted.extend([
            LightPass::DenoisingNormal,
            LightPass::DenoisingDepth,
            LightPass::Caught,
            LightPass::Catches,
            LightPass::Uv,
            LightPass::Mist,
        ]);
        wanted.extend([LightPass::Occlusion, LightPass::ShadingNormal, LightPass::Roughness]);
        wanted.extend((0..40).flat_map(|output| [LightPass::Aov(output), LightPass::AovAlpha(output)]));
        let parts = Parts::new(&wanted, Seen::default());
        assert_eq!(parts.list().len(), wanted.len() + 6, "three colours, white, ray and evaluated");
        for (place, &part) in parts.list().iter().enumerate() {
            assert_eq!(parts.place(part), Some(place), "{part:?}");
        }
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
