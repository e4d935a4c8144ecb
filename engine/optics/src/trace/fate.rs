//! The fate of a ray, in four bytes: many are searched quickly.

use super::{Failure, Lost};

/// The reasons of losses, by number from 1.
const REASONS: [Failure; 7] = [
    Failure::Missed,
    Failure::WrongSheet,
    Failure::OutsideAperture,
    Failure::Obstructed,
    Failure::BladeStop,
    Failure::TotalInternalReflection,
    Failure::NotConverged,
];

/// The fate of a ray: through, or lost somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RayStatus(u32);

impl RayStatus {
    /// The fate of a ray that is not lost so far.
    pub(super) const THROUGH: Self = Self(0);

    #[inline]
    pub(super) fn is_through(self) -> bool {
        self == Self::THROUGH
    }

    /// The reason and the surface of the ray's loss.
    #[inline]
    pub(super) fn lost(self) -> Option<Lost> {
        let reason = REASONS[((self.0 & 7) as usize).checked_sub(1)?];
        Some(Lost { surface: (self.0 >> 3) as usize, reason })
    }
}

impl From<Lost> for RayStatus {
    #[inline]
    fn from(Lost { surface, reason }: Lost) -> Self {
        let number = match reason {
            Failure::Missed => 1,
            Failure::WrongSheet => 2,
            Failure::OutsideAperture => 3,
            Failure::Obstructed => 4,
            Failure::BladeStop => 5,
            Failure::TotalInternalReflection => 6,
            Failure::NotConverged => 7,
        };
        Self((surface as u32) << 3 | number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loss_comes_back_as_it_was() {
        assert_eq!(RayStatus::THROUGH.lost(), None);
        for reason in REASONS {
            for surface in [0, 1, 40] {
                let lost = Lost { surface, reason };
                assert_eq!(RayStatus::from(lost).lost(), Some(lost));
            }
        }
    }
}
