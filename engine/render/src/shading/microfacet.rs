//! The GGX distribution of facets (Walter et al. 2007) with height-correlated masking (Heitz 2014), sampled by
//! the facets visible (Heitz 2018, in the form of Dupuy and Benyoub 2023).
//!
//! All directions in the frame of the shading normal, +z.

use glam::Vec3A;
use std::f32::consts::{PI, TAU};

/// Facets narrower than this are a mirror: their densities leave single precision.
pub(super) const MIRROR_BELOW: f32 = 1e-4;

/// Isotropic GGX of width alpha.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    alpha: f32,
}

impl Ggx {
    /// The distribution of Blender's perceptual roughness: alpha is its square.
    pub fn from_roughness(roughness: f32) -> Self {
        Self { alpha: roughness * roughness }
    }

    /// The distribution of a width.
    pub fn of_width(alpha: f32) -> Self {
        Self { alpha }
    }

    /// The width alpha, the square of the perceptual roughness.
    pub fn width(&self) -> f32 {
        self.alpha
    }

    /// True if the distribution is so narrow that it is treated as a perfect mirror.
    #[inline]
    pub fn is_mirror(&self) -> bool {
        self.alpha < MIRROR_BELOW
    }

    /// Density of facets about the half vector `h`, per steradian and unit area.
    #[inline]
    pub fn density(&self, h: Vec3A) -> f32 {
        let a2 = self.alpha * self.alpha;
        // cos^2 (a^2 - 1) + 1 = cos^2 a^2 + sin^2: no cancellation near the peak.
        let t = h.z * h.z * a2 + h.x * h.x + h.y * h.y;
        a2 / (PI * t * t)
    }

    /// Smith's lambda: the area of the facets that are hidden from `w` over that of the visible ones.
    #[inline]
    pub fn lambda(&self, w: Vec3A) -> f32 {
        let cos2 = w.z * w.z;
        if cos2 <= 0.0 {
            return f32::INFINITY;
        }
        let tan2 = (w.x * w.x + w.y * w.y) / cos2;
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// The part of facets seen from `w` that is not hidden.
    #[inline]
    pub fn masking(&self, w: Vec3A) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// The part seen from both directions, on either side of the surface.
    #[inline]
    pub fn masking_shadowing(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// A facet normal as seen from `wo` (z > 0).
    pub fn sample_visible(&self, wo: Vec3A, u: [f32; 2]) -> Vec3A {
        if self.is_mirror() {
            return Vec3A::Z;
        }
        let stretched = Vec3A::new(self.alpha * wo.x, self.alpha * wo.y, wo.z).normalize();
        // A spherical cap seen from the stretched direction.
        let phi = TAU * u[0];
        let z = (1.0 - u[1]) * (1.0 + stretched.z) - stretched.z;
        let r = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let (s, c) = phi.sin_cos();
        let h = Vec3A::new(r * c, r * s, z) + stretched;
        Vec3A::new(self.alpha * h.x, self.alpha * h.y, h.z.max(0.0)).normalize_or(Vec3A::Z)
    }

    /// Density of [`Ggx::sample_visible`] per steradian of `h`.
    #[inline]
    pub fn visible_pdf(&self, wo: Vec3A, h: Vec3A) -> f32 {
        self.density(h) * self.masking(wo) * wo.dot(h).max(0.0) / wo.z.max(1e-12)
    }
}

/// `w` mirrored at a facet.
#[inline]
pub fn reflect(w: Vec3A, h: Vec3A) -> Vec3A {
    2.0 * w.dot(h) * h - w
}

/// `w` bent through a facet on its side, into relative index `eta` (beyond over before); `None` at total
/// internal reflection.
#[inline]
pub fn refract(w: Vec3A, h: Vec3A, eta: f32) -> Option<Vec3A> {
    let cos_i = w.dot(h);
    let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return None;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    Some(-w / eta + (cos_i / eta - cos_t) * h)
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_testkit::sampling;

    /// The projected area of all facets is the surface's own, whatever the roughness; and the part that is visible from
    /// any direction is that direction's cosine.
    #[test]
    fn facet_areas_add_up() {
        for roughness in [0.3f32, 0.6, 1.0] {
            let ggx = Ggx::from_roughness(roughness);
            let n = 2000;
            let mut area = 0.0f64;
            for i in 0..n {
                // Even steps in the angle resolve the narrow peak.
                let theta = std::f32::consts::FRAC_PI_2 * (i as f32 + 0.5) / n as f32;
                let h = Vec3A::new(theta.sin(), 0.0, theta.cos());
                let ring = TAU * theta.sin() * std::f32::consts::FRAC_PI_2 / n as f32;
                area += (ggx.density(h) * h.z * ring) as f64;
            }
            assert!((area - 1.0).abs() < 1e-3, "{roughness}: {area}");
        }
    }

    /// The normals of sampled facets follow the density that is said of them.
    #[test]
    fn visible_facets_are_sampled_by_their_density() {
        for (roughness, wo) in [(0.7, [0.6, 0.1, 0.3]), (0.4, [0.9, 0.0, 0.1]), (1.0, [0.0, 0.1, 1.0])] {
            let (ggx, wo) = (Ggx::from_roughness(roughness), Vec3A::from_array(wo).normalize());
            sampling::directions(
                &format!("GGX's facets, {roughness} from {wo}"),
                1 << 18,
                |random| {
                    let h = ggx.sample_visible(wo, random.numbers());
                    assert!(h.z >= 0.0 && (h.length() - 1.0).abs() < 1e-5);
                    Some(h.to_array())
                },
                |h| {
                    let h = Vec3A::from_array(h);
                    if h.z > 0.0 && wo.dot(h) > 0.0 { ggx.visible_pdf(wo, h).into() } else { 0.0 }
                },
            );
        }
    }

    #[test]
    fn refraction_obeys_snell_and_reverses() {
        let w = Vec3A::new(0.5, -0.2, 0.7).normalize();
        let t = refract(w, Vec3A::Z, 1.5).unwrap();
        assert!((t.x.hypot(t.y) * 1.5 - w.x.hypot(w.y)).abs() < 1e-6 && t.z < 0.0);
        let back = refract(t, -Vec3A::Z, 1.0 / 1.5).unwrap();
        assert!((back - w).length() < 1e-6);
        assert!(refract(Vec3A::new(0.9, 0.0, 0.436), Vec3A::Z, 1.0 / 1.5).is_none());
    }
}
