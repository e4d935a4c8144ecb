//! Reflectance of smooth boundaries.

use crate::Rgb;

/// Reflectance of unpolarised light at a dielectric boundary. `cos_i` is that of the angle to the normal,
/// positive; `eta` is the index beyond the boundary over the index before it. 1 at total internal reflection.
#[inline]
pub fn dielectric(cos_i: f32, eta: f32) -> f32 {
    let cos_i = cos_i.clamp(0.0, 1.0);
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Reflectance at normal incidence of relative index `eta`.
#[inline]
pub fn f0_from_ior(eta: f32) -> f32 {
    ((eta - 1.0) / (eta + 1.0)).powi(2)
}

/// The relative index (>= 1) whose reflectance at normal incidence is `f0`.
#[inline]
pub fn ior_from_f0(f0: f32) -> f32 {
    let root = f0.clamp(0.0, 0.99).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// The rise of the dielectric curve from its value at normal incidence (0) to 1 at grazing: the weight by which
/// Principled interpolates between a tinted `f0` and white.
#[inline]
pub fn dielectric_rise(cos_i: f32, eta: f32) -> f32 {
    let f0 = f0_from_ior(eta);
    ((dielectric(cos_i, eta) - f0) / (1.0 - f0)).clamp(0.0, 1.0)
}

/// Metal by the F82-tint model (Kutz, Hasan and Edmondson 2021, "Novel aspects of the Adobe Standard Material"):
/// Schlick's curve from `f0`, dipping so that at about 82 degrees it is `tint` times Schlick's value.
#[derive(Clone, Copy, Debug, Default)]
pub struct F82Tint {
    f0: Rgb,
    dip: Rgb,
}

impl F82Tint {
    /// The curve of reflectance at normal incidence and the tint near grazing.
    pub fn new(f0: Rgb, tint: Rgb) -> Self {
        Self::new_unbounded(f0, tint.min(Rgb::ONE))
    }

    /// The curve of reflectance at normal incidence and a tint near grazing that may be brighter than white.
    pub fn new_unbounded(f0: Rgb, tint: Rgb) -> Self {
        // The dip term (1 - c) ^ 6 c is greatest at c = 1/7.
        const SIX_SEVENTHS: f32 = 6.0 / 7.0;
        let schlick = f0 + (Rgb::ONE - f0) * SIX_SEVENTHS.powi(5);
        let dip = schlick * (Rgb::ONE - tint) * (7.0 / SIX_SEVENTHS.powi(6));
        Self { f0, dip }
    }

    /// Reflectance at that cosine.
    #[inline]
    pub fn at(&self, cos_i: f32) -> Rgb {
        self.of(Self::terms(cos_i))
    }

    /// The terms at a cosine in which reflectance is linear: the rise, and the dip near grazing.
    #[inline]
    pub fn terms(cos_i: f32) -> [f32; 2] {
        let m = (1.0 - cos_i).clamp(0.0, 1.0);
        let m5 = (m * m) * (m * m) * m;
        [m5, cos_i * m5 * m]
    }

    /// Reflectance of these terms, or the mean one of their means.
    #[inline]
    pub fn of(&self, [rise, dip]: [f32; 2]) -> Rgb {
        (self.f0 + (Rgb::ONE - self.f0) * rise - self.dip * dip).clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// The cosine-weighted average over the hemisphere.
    pub fn average(&self) -> Rgb {
        // 2 ∫ (1-c)^5 c dc = 1/21, 2 ∫ (1-c)^6 c^2 dc = 1/126.
        self.f0 + (Rgb::ONE - self.f0) / 21.0 - self.dip / 126.0
    }
}

/// Reflectance of unpolarised light at a metal of index of refraction `n` and extinction coefficient `k`.
pub fn conductor(cos_i: f32, n: Rgb, k: Rgb) -> Rgb {
    let (cos2, sin2) = (cos_i * cos_i, 1.0 - cos_i * cos_i);
    let root = |v: Rgb| Rgb::from(v.max(Rgb::ZERO).to_array().map(f32::sqrt));
    let t = n * n - k * k - sin2;
    let size = root(t * t + 4.0 * n * n * k * k);
    let twice = 2.0 * cos_i * root(0.5 * (size + t));
    let perpendicular = (size - twice + cos2) / (size + twice + cos2);
    let both = size * cos2 + sin2 * sin2;
    let parallel = perpendicular * (both - twice * sin2) / (both + twice * sin2);
    0.5 * (parallel + perpendicular)
}

/// The metal of [`F82Tint`] that agrees with [`conductor`] at normal incidence and at 82 degrees.
pub fn conductor_as_tinted(n: Rgb, k: Rgb) -> F82Tint {
    let f0 = conductor(1.0, n, k);
    let plain = F82Tint::new(f0, Rgb::ONE);
    let tint = conductor(1.0 / 7.0, n, k) / plain.at(1.0 / 7.0);
    F82Tint::new_unbounded(f0, tint)
}

/// An approximation of the cosine-weighted average of [`conductor`].
pub fn conductor_average(n: Rgb, k: Rgb) -> Rgb {
    conductor_as_tinted(n, k).average().clamp(Rgb::ZERO, Rgb::ONE)
}

/// The cosine-weighted average of [`dielectric`] for `eta` >= 1 and below: Kulla and Conty's fit (2017,
/// "Revisiting Physically Based Shading at Imageworks").
pub fn dielectric_average(eta: f32) -> f32 {
    if eta >= 1.0 {
        (eta - 1.0) / (4.08567 + 1.00071 * eta)
    } else {
        let e = eta.max(0.0);
        (0.997_118 + 0.1014 * e - 0.965_241 * e * e - 0.130_607 * e * e * e).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        assert!((dielectric(1.0, 1.5) - 0.04).abs() < 1e-7);
        assert_eq!(dielectric(0.0, 1.5), 1.0);
        // From glass into air beyond the critical angle (41.8 degrees).
        assert_eq!(dielectric(0.7, 1.0 / 1.5), 1.0);
        // Brewster's angle: only perpendicular light, ((n^2-1)/(n^2+1))^2 / 2.
        let brewster = (1.5f32.atan()).cos();
        assert!((dielectric(brewster, 1.5) - 0.5 * (1.25f32 / 3.25).powi(2)).abs() < 1e-6);
        assert!((ior_from_f0(f0_from_ior(1.7)) - 1.7).abs() < 1e-5);
    }

    #[test]
    fn metal_averages_and_tint_are_what_they_say() {
        let metal = F82Tint::new(Rgb::new(0.9, 0.5, 0.1), Rgb::new(1.0, 0.8, 0.5));
        let n = 4000;
        let mut sum = Rgb::ZERO;
        for i in 0..n {
            let c = (i as f32 + 0.5) / n as f32;
            sum += metal.at(c) * 2.0 * c / n as f32;
        }
        assert!((sum - metal.average()).abs().max_element() < 1e-3, "{sum} {}", metal.average());
        let plain = F82Tint::new(Rgb::new(0.9, 0.5, 0.1), Rgb::ONE);
        let ratio = metal.at(1.0 / 7.0) / plain.at(1.0 / 7.0);
        assert!((ratio - Rgb::new(1.0, 0.8, 0.5)).abs().max_element() < 1e-5);
    }

    #[test]
    fn the_dielectric_average_is_near_its_integral() {
        for eta in [1.1f32, 1.33, 1.5, 2.0, 0.7] {
            let n = 4000;
            let sum: f32 = (0..n)
                .map(|i| {
                    let c = (i as f32 + 0.5) / n as f32;
                    dielectric(c, eta) * 2.0 * c / n as f32
                })
                .sum();
            // The fit's own accuracy.
            assert!((sum - dielectric_average(eta)).abs() < 0.01, "{eta}: {sum}");
        }
    }
}
