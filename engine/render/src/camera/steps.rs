//! How what is seen moves with the place of the picture, ready to be turned round: from a way in the scene to places.

use glam::{DMat2, DVec2, DVec3};

/// Two slopes and the inverse of their normal equations.
pub(super) struct Steps {
    across: DVec3,
    up: DVec3,
    inverse: DMat2,
}

impl Steps {
    /// What is seen moves by `across` for the picture's width, by `up` for its height; `None` if these lie along each other.
    pub(super) fn new(across: DVec3, up: DVec3) -> Option<Self> {
        let mixed = across.dot(up);
        let squares =
            DMat2::from_cols(DVec2::new(across.length_squared(), mixed), DVec2::new(mixed, up.length_squared()));
        Some(Self { across, up, inverse: inverse(squares)? })
    }

    /// By how much of the picture's width and height a way in the scene is aside: least squares.
    pub(super) fn place(&self, way: DVec3) -> DVec2 {
        self.inverse * DVec2::new(self.across.dot(way), self.up.dot(way))
    }
}

/// Two by two, inverted; `None` where it has no inverse.
pub(super) fn inverse(m: DMat2) -> Option<DMat2> {
    let inverse = m.inverse();
    inverse.is_finite().then_some(inverse)
}
