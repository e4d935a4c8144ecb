//! The other way round (Wu et al. 2011, section 5.3 and figure 6): a ray between a point that is sharp and a point of the
//! entrance pupil; what it finds in the scene is carried through the lens for each wavelength, and counts where it lands.
//!
//! Each pixel starts the rays that its own film point would see sharp: where a lens is sharp they land there again.
//! Transparency is kept with the pixel that started the ray.

use super::Sample;
use crate::camera::real_lens::RealLens;
use crate::camera::scene_side::SceneNumbers;

/// One sample of one pixel.
pub(super) fn sample(lens: &RealLens, mut s: Sample<'_>) {
    let mut sampler = s.sampler();
    let [u0, u1, u2, u3] = sampler.next_4d();
    let [wavelength, u_column, u_row, beyond] = sampler.next_4d();
    let numbers = SceneNumbers { place: [u0, u1], lens: [u2, u3], wavelength, beyond, pixels: [u_column, u_row] };
    let led = lens.lead_from_scene([s.x, s.y], &numbers, s.shot.raster);
    s.count_camera(led.is_none());
    let Some(led) = led else { return s.lost() };
    if let Some(found) = s.follow(led.ray, &mut sampler) {
        s.splat(lens, &led.splats, found.radiance);
        s.note_alpha(&found);
        if !numbers.is_astray() {
            s.note_surface(&found, &led.ray, wavelength);
        }
    }
}
