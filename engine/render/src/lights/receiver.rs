//! Where light is wanted, and what the lights' tree says of it at its root: asked once a place.

use glam::Vec3A;

/// Children of a node of the lights' tree.
pub(super) const WIDTH: usize = 8;

/// A place that light may reach. Made by [`super::Lights::receiver`].
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Render space.
    pub position: Vec3A,
    /// The normal of a surface that light from behind does not matter to; `None` takes light from all sides.
    pub normal: Option<Vec3A>,
    /// Which of the lights' trees is asked.
    pub(super) tree: u32,
    /// What each part under the tree's root may send here.
    pub(super) weights: [f32; WIDTH],
    /// Their sum.
    pub(super) total: f32,
    /// What the sky may send here, in brightness.
    pub(super) sky: f32,
    /// Chance of choosing the sky rather than something within the scene.
    pub(crate) sky_chance: f32,
    /// When light is wanted, as in [`crate::accel::Ray::moment`].
    pub moment: u16,
}

impl Receiver {
    /// At another moment.
    #[inline]
    pub fn at(self, moment: u16) -> Self {
        Self { moment, ..self }
    }
}
