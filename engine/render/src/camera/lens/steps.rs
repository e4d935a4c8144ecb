//! Derivatives of the seen point by the place in the picture, and their inverse: from a displacement in the scene to places.

use glam::{DMat2, DVec2, DVec3};

/// Two slopes and the inverse of their normal equations.
pub(in crate::camera) struct Steps {
    across: DVec3,
    up: DVec3,
    inverse: DMat2,
}

impl Steps {
    /// The derivatives of a seen point: `across` for the picture's width, `up` for its height; `None` if these are parallel.
    pub(in crate::camera) fn new(across: DVec3, up: DVec3) -> Option<Self> {
        let mixed = across.dot(up);
        let squares =
            DMat2::from_cols(DVec2::new(across.length_squared(), mixed), DVec2::new(mixed, up.length_squared()));
        Some(Self { across, up, inverse: inverse(squares)? })
    }

    /// The displacement in the picture, in parts of its width and height, of a displacement in the scene: by least squares.
    pub(in crate::camera) fn place(&self, way: DVec3) -> DVec2 {
        self.inverse * DVec2::new(self.across.dot(way), self.up.dot(way))
    }
}

/// Two by two, inverted; `None` where it has no inverse.
pub(in crate::camera) fn inverse(m: DMat2) -> Option<DMat2> {
    let inverse = m.inverse();
    inverse.is_finite().then_some(inverse)
}
