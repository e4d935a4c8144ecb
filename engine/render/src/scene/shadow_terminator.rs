//! Softening of the shadow terminator: the flat triangles of a coarse smooth mesh do not show at the edge of light.

/// The shadow terminator of an object's smooth faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadowTerminator {
    /// Shadows of light at a lesser cosine are asked for from above the triangle; 0: none are.
    pub lift_below: f32,
    /// The part of the right angle between light and normal in which nothing counts; 0 leaves all.
    dark: f32,
}

impl ShadowTerminator {
    /// The shadow terminator of Blender's two settings: Geometry Offset and Shading Offset, 0 to 1.
    pub fn new(geometry_offset: f32, shading_offset: f32) -> Self {
        Self { lift_below: geometry_offset.max(0.0), dark: (0.5 * shading_offset).clamp(0.0, 0.5) }
    }

    /// The settings with all shadow rays from the surface itself.
    #[must_use]
    pub fn without_lift(self) -> Self {
        Self { lift_below: 0.0, ..self }
    }

    /// True if the shadow terminator takes light away.
    #[inline]
    pub fn dims(&self) -> bool {
        self.dark > 0.0
    }

    /// The part of light that is left at a cosine to the normal: as if all angles were so much wider that none is in the dark part.
    pub fn left_at(&self, cos: f32) -> f32 {
        let angle = cos.min(1.0).acos() / (1.0 - self.dark);
        angle.min(std::f32::consts::FRAC_PI_2).cos() / cos
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dims_towards_the_edge_alone() {
        let half = ShadowTerminator::new(0.1, 1.0);
        assert!(half.dims() && !ShadowTerminator::new(0.1, 0.0).dims());
        // Rounding of an arc cosine and a cosine.
        assert!((half.left_at(1.0) - 1.0).abs() < 1e-6);
        assert!(half.left_at(0.9) > half.left_at(0.8));
        // Everything beyond half of the right angle.
        assert!(half.left_at(0.7) < 1e-6);
    }
}
