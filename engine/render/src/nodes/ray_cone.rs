//! The cone about a ray.

use crate::accel::Ray;
use crate::scene::viewport::Viewport;

/// The cone about a ray: the part of the scene that one pixel sees along it (Amanatides 1984, "Ray Tracing with Cones"). Bumps and pixel
/// widths of node programs depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayCone {
    /// Width where the ray begins, Blender units.
    pub width: f32,
    /// Growth of the width over a length of 1.
    pub spread: f32,
}

impl RayCone {
    /// The cone of a pixel in the middle of Blender's own camera's picture, which begins at the ray's start.
    pub fn pixel(viewport: &Viewport) -> Self {
        Self { width: 0.0, spread: viewport.pixel_angle_rad() }
    }

    /// The cone of the pixel that a camera ray goes through. The ray may begin before the camera, where the picture is clipped.
    pub fn camera(viewport: &Viewport, ray: &Ray) -> Self {
        let width = viewport.pixel_width(viewport.from_render.matrix3 * ray.direction);
        if viewport.is_orthographic() {
            return Self { width, spread: 0.0 };
        }
        Self { width: width * viewport.from_render.transform_point3a(ray.origin).length(), spread: width }
    }

    /// Width at a distance along the ray: the footprint there.
    #[inline]
    pub fn at(&self, distance: f32) -> f32 {
        self.width + self.spread * distance
    }

    /// The cone after a scattering at a distance along the ray, by lobes of that mean square of the width alpha: at least `widening` times
    /// that width of growth. As `bsdf_widen_dD` in bsdf.h of Cycles 5.2.
    #[inline]
    #[must_use]
    pub fn scattered(&self, distance: f32, widening: f32, alpha_squared: f32) -> Self {
        Self { width: self.at(distance), spread: self.spread.max(widening * alpha_squared.sqrt()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Widths add up along a path; a scattering of width 0.25 with half the widening grows by an eighth of the length.
    #[test]
    fn a_cone_grows_along_the_path() {
        let first = RayCone { width: 0.0, spread: 0.01 };
        assert_eq!(first.at(3.0), 0.03);
        assert_eq!(first.scattered(3.0, 0.0, 1.0), RayCone { width: 0.03, spread: 0.01 });
        let wide = first.scattered(3.0, 0.5, 0.0625);
        assert_eq!(wide, RayCone { width: 0.03, spread: 0.125 });
        assert_eq!(wide.scattered(2.0, 0.5, 0.0).spread, 0.125);
    }
}
