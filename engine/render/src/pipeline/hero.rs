//! Film-first for one wavelength, which leads; the light found along its ray is carried back through the lens for the
//! other wavelengths of its set, and counts where each of them arrives.
//!
//! A ray could have been led to by any of them: each is weighted by the balance heuristic over all, which keeps the
//! edges right where some are vignetted. So a wavelength costs a trace through the lens, not a path.

use super::Sample;
use crate::camera::real_lens::RealLens;

/// One sample of one pixel.
pub(super) fn sample(lens: &RealLens, mut s: Sample<'_>) {
    let mut sampler = s.sampler();
    let [u0, u1, u2, u3] = sampler.next_4d();
    let [u_wavelength, u_column, u_row, _] = sampler.next_4d();
    let raster = s.shot.raster;
    let place = raster.place(s.x, s.y, [u0, u1]);
    let led = lens.lead_all([s.x, s.y], place, [u2, u3], u_wavelength, raster, [u_column, u_row]);
    s.count_camera(led.is_none());
    let Some(led) = led else { return s.lost() };
    if let Some(found) = s.follow(led.ray, &mut sampler) {
        for (x, y, weight) in led.splats.into_iter().flatten() {
            s.light.add(x, y, weight * found.radiance);
        }
        s.note(&found);
    }
}
