//! The path state: the fields of Blender's Light Path node, and the counts of bounces.

use crate::scene::visibility::Rays;
use glam::Vec3A;
use petzval_nodes::{Field, answers};

/// The path state: the kind of the last scattering, and the number of scatterings of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
// Moved about as one word.
#[repr(C, align(8))]
pub struct PathState {
    is: u8,
    /// Diffuse reflections; at most 255 are counted.
    pub diffuse: u8,
    /// Number of glossy reflections.
    pub glossy: u8,
    /// Number of transmissions with scattering.
    pub transmission: u8,
    /// Scatterings of all kinds.
    pub depth: u16,
    /// Number of surfaces passed unbent.
    pub transparent: u16,
}

const CAMERA: u8 = 1;
const SHADOW: u8 = 2;
const DIFFUSE: u8 = 4;
const GLOSSY: u8 = 8;
const SINGULAR: u8 = 16;
const REFLECTED: u8 = 32;
const TRANSMITTED: u8 = 64;
const IN_VOLUME: u8 = 128;

impl PathState {
    const START: Self = Self { is: 0, depth: 0, diffuse: 0, glossy: 0, transmission: 0, transparent: 0 };
    /// The state of a camera ray.
    pub const CAMERA: Self = Self { is: CAMERA, ..Self::START };
    /// The state after one diffuse reflection: the default where nothing else is known.
    pub const BOUNCE: Self = Self { is: DIFFUSE | REFLECTED, depth: 1, diffuse: 1, ..Self::START };
    /// The state for a light that is evaluated at the first surface.
    pub const LIGHT: Self = Self { depth: 1, ..Self::START };

    /// The path state after a scattering at a surface. `is_matte`: by a diffuse lobe; `is_mirror`: by a lobe of a single direction.
    #[inline]
    #[must_use]
    pub fn scattered(self, is_matte: bool, is_mirror: bool, is_transmitted: bool) -> Self {
        let lobe = if is_matte {
            DIFFUSE
        } else if is_mirror {
            GLOSSY | SINGULAR
        } else {
            GLOSSY
        };
        Self {
            is: lobe | if is_transmitted { TRANSMITTED } else { REFLECTED },
            depth: self.depth + 1,
            diffuse: self.diffuse.saturating_add(u8::from(is_matte && !is_transmitted)),
            glossy: self.glossy.saturating_add(u8::from(!is_matte && !is_transmitted)),
            transmission: self.transmission.saturating_add(u8::from(is_transmitted)),
            transparent: self.transparent,
        }
    }

    /// The path state after a scattering in a volume.
    #[inline]
    #[must_use]
    pub fn scattered_in_volume(self) -> Self {
        Self { is: IN_VOLUME, depth: self.depth + 1, ..self }
    }

    /// This path state with a depth of so many scatterings.
    #[must_use]
    pub fn at_depth(self, depth: u32) -> Self {
        Self { depth: depth as u16, ..self }
    }

    /// The path state behind a surface that was passed unbent.
    #[inline]
    #[must_use]
    pub fn passed(self) -> Self {
        Self { transparent: self.transparent.saturating_add(1), ..self }
    }

    /// The state of a shadow ray from the place that this path has reached.
    #[inline]
    #[must_use]
    pub fn shadow(self) -> Self {
        Self { is: SHADOW, depth: self.depth + 1, ..self }
    }

    /// The state for a light that is evaluated at that place: Blender counts this as one scattering more, and as no kind of ray.
    #[inline]
    #[must_use]
    pub fn light(self) -> Self {
        Self { is: 0, depth: self.depth + 1, ..self }
    }

    /// True if nothing scattered the path yet.
    #[inline]
    pub fn is_camera(self) -> bool {
        self.is & CAMERA != 0
    }

    /// True of a shadow ray.
    #[inline]
    pub fn is_shadow(self) -> bool {
        self.is & SHADOW != 0
    }

    /// True if the path's last scattering was diffuse.
    #[inline]
    pub fn is_diffuse(self) -> bool {
        self.is & DIFFUSE != 0
    }

    /// The kind that objects may hide from: a ray that was let through keeps its kind.
    #[inline]
    pub fn rays(self) -> Rays {
        if self.is & CAMERA != 0 {
            Rays::CAMERA
        } else if self.is & TRANSMITTED != 0 {
            Rays::TRANSMISSION
        } else if self.is & DIFFUSE != 0 {
            Rays::DIFFUSE
        } else {
            Rays::GLOSSY
        }
    }

    /// The kind of ray that objects may hide from, scattering in volumes included; see [`Self::rays`].
    #[inline]
    pub fn rays_with_volumes(self) -> Rays {
        if self.is & IN_VOLUME != 0 { Rays::VOLUME_SCATTER } else { self.rays() }
    }

    /// The kinds that a light must reach to be found by this way, all of them.
    #[inline]
    pub fn finds(self) -> Rays {
        let of = |bit: u8, rays: Rays| if self.is & bit == bit { rays } else { Rays::NONE };
        of(CAMERA, Rays::CAMERA)
            .and(of(DIFFUSE, Rays::DIFFUSE))
            .and(of(GLOSSY | REFLECTED, Rays::GLOSSY))
            .and(of(TRANSMITTED, Rays::TRANSMISSION))
            .and(of(IN_VOLUME, Rays::VOLUME_SCATTER))
    }

    answers! {
        /// The value of a Light Path field for node programs.
        pub(super) fn answer(self, field: Field) -> Vec3A {
            let is = |bit: u8| Vec3A::splat(f32::from(u8::from(self.is & bit != 0)));
            let number = |count: u16| Vec3A::splat(f32::from(count));
            match field {
                IsCameraRay => is(CAMERA),
                IsShadowRay => is(SHADOW),
                IsDiffuseRay => is(DIFFUSE),
                IsGlossyRay => is(GLOSSY),
                IsSingularRay => is(SINGULAR),
                IsReflectionRay => is(REFLECTED),
                IsTransmissionRay => is(TRANSMITTED),
                IsVolumeScatterRay => is(IN_VOLUME),
                RayDepth => number(self.depth),
                DiffuseDepth => number(self.diffuse.into()),
                GlossyDepth => number(self.glossy.into()),
                TransmissionDepth => number(self.transmission.into()),
                TransparentDepth => number(self.transparent),
                // No path goes through a portal.
                PortalDepth => Vec3A::ZERO,
                _ => [],
            }
        }
    }
}

/// The fields that tell kinds of bounces apart: a world that reads any of these differs for each kind.
pub const OF_BOUNCES: [Field; 11] = [
    Field::IsDiffuseRay,
    Field::IsGlossyRay,
    Field::IsSingularRay,
    Field::IsReflectionRay,
    Field::IsTransmissionRay,
    Field::IsVolumeScatterRay,
    Field::RayDepth,
    Field::DiffuseDepth,
    Field::GlossyDepth,
    Field::TransmissionDepth,
    Field::TransparentDepth,
];
