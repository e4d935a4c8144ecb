//! Kinds of ray, to which objects are visible and which lights reach.

/// A set of kinds of ray, as Blender's ray visibility has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rays(u8);

impl Rays {
    /// Rays straight from the camera.
    pub const CAMERA: Self = Self(1);
    /// Rays that a surface reflected without a peak.
    pub const DIFFUSE: Self = Self(2);
    /// Rays that a surface reflected about a peak, or mirrored.
    pub const GLOSSY: Self = Self(4);
    /// Rays that were let through by the last surface that scattered them.
    pub const TRANSMISSION: Self = Self(8);
    /// Rays that ask whether anything hides a light.
    pub const SHADOW: Self = Self(16);
    /// Rays scattered in a volume.
    pub const VOLUME_SCATTER: Self = Self(32);
    /// No kind.
    pub const NONE: Self = Self(0);
    /// All that a surface scatters, whichever it is.
    pub const BOUNCE: Self = Self(2 | 4 | 8);
    /// Every kind.
    pub const ALL: Self = Self(63);

    /// The kind of this name in Blender.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "CAMERA" => Self::CAMERA,
            "DIFFUSE" => Self::DIFFUSE,
            "GLOSSY" => Self::GLOSSY,
            "TRANSMISSION" => Self::TRANSMISSION,
            "SHADOW" => Self::SHADOW,
            "VOLUME_SCATTER" => Self::VOLUME_SCATTER,
            _ => return None,
        })
    }

    /// The kinds of both sets together.
    #[inline(always)]
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The kinds that are in both sets.
    #[inline(always)]
    #[must_use]
    pub const fn common(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The kinds of `self` without those of `other`.
    #[inline(always)]
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// True if the sets have a kind in common.
    #[inline(always)]
    pub const fn any_of(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// True if all kinds of the other are in this set.
    #[inline(always)]
    pub const fn all_of(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl Default for Rays {
    fn default() -> Self {
        Self::ALL
    }
}

/// The sets of the scene's objects that an emitter lights, and that stand in its way. Set 0 is everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightSets {
    /// The set of objects that it lights; below 64.
    pub receivers: u8,
    /// The set of objects that cast shadows in its light; below 64.
    pub blockers: u8,
}

impl LightSets {
    /// The sets of lights without light linking.
    pub const EVERYTHING: Self = Self { receivers: 0, blockers: 0 };
}

/// An object's part in light linking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightLinking {
    /// The sets of receivers that it is in, a bit each.
    pub receives: u64,
    /// The sets of blockers that it is in, a bit each.
    pub blocks: u64,
    /// The sets of the object's own emission.
    pub sets: LightSets,
}

impl Default for LightLinking {
    fn default() -> Self {
        Self { receives: u64::MAX, blocks: u64::MAX, sets: LightSets::EVERYTHING }
    }
}

impl LightLinking {
    /// True if light of an emitter of these sets reaches the object.
    pub fn takes_light_of(&self, emitter: LightSets) -> bool {
        self.receives >> emitter.receivers & 1 == 1
    }

    /// True if the object casts shadows in the light of an emitter of these sets.
    pub fn blocks_light_of(&self, emitter: LightSets) -> bool {
        self.blocks >> emitter.blockers & 1 == 1
    }
}
