//! Approximations of indirect light that Cycles makes: less noise or time, for a picture that is not quite the scene's.

use crate::nodes::PathState;
use serde::Deserialize;

/// The approximations that are made; by default none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Approximations {
    /// Filter Glossy of Cycles: surfaces are rougher where a path looks that was scattered with less than this density per
    /// steradian. 0 is off.
    pub filter_glossy: f32,
    /// The growth of footprints after a diffuse scattering, in widths per length: the footprint of a bump grows by it where a
    /// scattered path looks. 0 leaves the pixel's own. Cycles from 5.2 on has Filter Glossy, at most 1.
    pub widening: f32,
    /// A replacement of indirect light, or an addition to it.
    pub fast_gi: FastGi,
}

/// Fast GI Approximation of Cycles: ambient occlusion instead of indirect light, or besides it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE", deny_unknown_fields)]
pub enum FastGi {
    /// No approximation: indirect light is traced.
    #[default]
    Off,
    /// The last rays of a path find emitters within `distance`, and where nothing is within it the world, times `factor`.
    Replace {
        /// Number of the bounce with which a path ends; 0 is off. Bounces through a surface do not count, nor does the first that is
        /// glossy.
        bounces: u32,
        /// Length of the last rays.
        distance: f32,
        /// Factor of the world's light; 0 is off.
        factor: f32,
    },
    /// White light from wherever nothing is within `distance` falls on all that scatters diffusely.
    Add {
        /// Length of the occlusion rays.
        distance: f32,
        /// Radiance of that light.
        factor: f32,
    },
}

/// The last ray of a path, by fast global illumination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LastRay {
    /// Length of the ray.
    pub(super) distance: f32,
    /// Factor of the world's light.
    pub(super) factor: f32,
}

impl FastGi {
    /// The ray by which a path in this state goes on, if that is its last. As `path_state_ao_bounce` in path_state.h of Cycles.
    #[inline]
    pub(super) fn last_ray(self, way: PathState) -> Option<LastRay> {
        let Self::Replace { bounces, distance, factor } = self else { return None };
        let uncounted = u32::from(way.transmission) + u32::from(way.glossy > 0);
        let is_last = bounces > 0 && factor != 0.0 && u32::from(way.depth) + 1 > bounces + uncounted;
        is_last.then_some(LastRay { distance, factor })
    }
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

    /// Nothing is rougher without the setting, nor are surfaces that the camera sees.
    #[test]
    fn what_is_sharp_stays_so() {
        assert_eq!(Approximations::default().least_alpha(0.0), 0.0);
        let on = Approximations { filter_glossy: 1.0, ..Approximations::default() };
        assert_eq!(on.least_alpha(f32::INFINITY), 0.0);
        assert_eq!(on.least_alpha(1.0), 0.0);
    }

    /// The bounces that end a path, one by one.
    #[test]
    fn a_last_ray_follows_the_bounces_that_count() {
        let of = |bounces: u32| FastGi::Replace { bounces, distance: 2.0, factor: 0.5 };
        let is_last = |bounces: u32, way: PathState| of(bounces).last_ray(way).is_some();
        let [diffuse, glossy, through] = [(true, false), (false, false), (false, true)]
            .map(|(matte, through)| move |way: PathState| way.scattered(matte, false, through));
        let camera = PathState::CAMERA;
        assert!(!is_last(1, camera) && !is_last(0, diffuse(camera)));
        assert!(is_last(1, diffuse(camera)) && !is_last(2, diffuse(camera)));
        assert!(!is_last(1, glossy(camera)) && !is_last(1, through(through(camera))));
        assert!(is_last(1, glossy(glossy(camera))) && is_last(1, diffuse(glossy(through(camera)))));
        assert!(is_last(1, camera.scattered_in_volume()));
        assert_eq!(of(1).last_ray(diffuse(camera)), Some(LastRay { distance: 2.0, factor: 0.5 }));
        assert_eq!(FastGi::Off.last_ray(diffuse(camera)), None);
        assert_eq!(FastGi::Add { distance: 2.0, factor: 0.5 }.last_ray(diffuse(camera)), None);
    }

    /// The roughness at the density of a Lambertian surface along its normal, by hand: sqrt(1 - 1 / pi) / 2.
    #[test]
    fn a_diffuse_scattering_makes_facets_wide() {
        let on = Approximations { filter_glossy: 1.0, ..Approximations::default() };
        assert!((on.least_alpha(std::f32::consts::FRAC_1_PI) - 0.412_824).abs() < 1e-5);
        assert!((on.least_alpha(0.0) - 0.5).abs() < 1e-6);
    }
}
