//! The traditional pipeline (Kolb, Mitchell and Hanrahan 1995; Wu et al. 2011, section 5.3 and figure 5): a point
//! of the film, a point of the pupil, out through the lens, into the scene. One wavelength a path.

use super::Sample;

/// One sample of one pixel.
pub(super) fn sample(mut s: Sample<'_>) {
    let mut sampler = s.sampler();
    let [u0, u1, u2, u3] = sampler.next_4d();
    let [u_wavelength, ..] = sampler.next_4d();
    let place = s.shot.raster.place(s.x, s.y, [u0, u1]);
    let ray = s.camera.sample(place, [u2, u3], u_wavelength);
    s.count_camera(ray.is_none());
    let Some(ray) = ray else { return s.lost() };
    if let Some(found) = s.follow(ray.ray, &mut sampler) {
        s.light.add(s.x, s.y, ray.weight * found.radiance);
        s.note(&found);
    }
}
