//! A place to be lit, and the importances at the root of the light tree for it: computed once a place.

use glam::Vec3A;

/// Children of a node of the lights' tree.
pub(super) const WIDTH: usize = 8;

/// Stands for no instance.
pub(super) const NO_INSTANCE: u32 = u32::MAX;

/// A place that light may reach. Made by [`super::Lights::receiver`].
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    /// Position of the place in render space.
    pub position: Vec3A,
    /// The normal of a surface that light from behind does not matter to; `None` takes light from all sides.
    pub normal: Option<Vec3A>,
    /// The number of the place's light tree.
    pub(super) tree: u32,
    /// The instance that the place is on, if it emits there itself; [`NO_INSTANCE`] elsewhere.
    pub(super) emitter: u32,
    /// The light that each part under the tree's root may send to the place.
    pub(super) weights: [f32; WIDTH],
    /// The sum of the weights.
    pub(super) total: f32,
    /// The light that the sky may send to the place, in brightness.
    pub(super) sky: f32,
    /// Probability of choosing the sky rather than something within the scene.
    pub(crate) sky_chance: f32,
    /// The moment at which it is lit, as in [`crate::accel::Ray::moment`].
    pub moment: u16,
    /// True if samples of closures find all light of the sky that comes to the place: light samples may leave them the even part
    /// ([`super::sky`]).
    pub(super) is_compensated: bool,
}

impl LightSampleContext {
    /// This place at another moment.
    #[inline]
    pub fn at(self, moment: u16) -> Self {
        Self { moment, ..self }
    }

    /// This place where samples of closures find all light that light samples find, or not: where a normal leans away from the surface,
    /// each finds some that the other does not.
    #[inline]
    pub fn compensated(self, is_compensated: bool) -> Self {
        Self { is_compensated, ..self }
    }
}
