//! Approximations of indirect light that Cycles makes: less noise or time, for a picture that is not quite the scene's.

/// Which of them are made; by default none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Approximations {
    /// Filter Glossy of Cycles: surfaces are rougher where a path looks that was scattered with less than this density per
    /// steradian. 0 is off.
    pub filter_glossy: f32,
}

impl Approximations {
    /// The least width alpha of facets where a path looks whose directions so far had this density at the least. Formula of
    /// Cycles (`surface_shader_prepare_closures` in surface_shader.h, where `filter_glossy` is the inverse of the setting).
    #[inline]
    pub(super) fn least_alpha(&self, least_pdf: f32) -> f32 {
        if least_pdf < self.filter_glossy { 0.5 * (1.0 - least_pdf / self.filter_glossy).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing is rougher without the setting, nor what the camera sees.
    #[test]
    fn what_is_sharp_stays_so() {
        assert_eq!(Approximations::default().least_alpha(0.0), 0.0);
        let on = Approximations { filter_glossy: 1.0 };
        assert_eq!(on.least_alpha(f32::INFINITY), 0.0);
        assert_eq!(on.least_alpha(1.0), 0.0);
    }

    /// At the density of a Lambertian surface along its normal, by hand: sqrt(1 - 1 / pi) / 2.
    #[test]
    fn a_diffuse_scattering_makes_facets_wide() {
        let on = Approximations { filter_glossy: 1.0 };
        assert!((on.least_alpha(std::f32::consts::FRAC_1_PI) - 0.412_824).abs() < 1e-5);
        assert!((on.least_alpha(0.0) - 0.5).abs() < 1e-6);
    }
}
