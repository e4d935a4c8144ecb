//! A path from the camera and one from a light for each sample: the camera's ray is led to by one wavelength and counts
//! at all of its set, as in [`super::hero`]; light that ends in the lens is carried through it at the wavelengths of a
//! set of its own, and falls where it falls.

use super::Sample;
use crate::camera::lens::real_lens::RealLens;
use crate::camera::lens::real_lens::packet::Request;
use crate::integrator::bidirectional::{self, CameraEnd, FilmEnd, LightPath, Techniques};

/// The seed that separates the light path's random numbers from the camera's.
const LIGHT_SEED: u32 = 0x51ab_73c9;

/// One sample of one pixel.
pub(super) fn sample(lens: &RealLens, techniques: Techniques, path: &mut LightPath, mut s: Sample<'_>) {
    let shot = s.shot;
    let (stage, limits, raster) = (shot.stage, &shot.limits, shot.raster);
    let light_sampler = shot.pattern.apart(LIGHT_SEED).pixel(s.x, s.y).sampler(s.index);
    s.counts.rays += u64::from(path.trace(stage, limits, light_sampler.clone()));
    let way = shot.exposure.and_then(|exposure| exposure.way(path.moment()));
    let (mut non_finite, light) = (0, &mut *s.light);
    let rays = path.splat(
        stage,
        &FilmEnd { lens, raster, clip: shot.clip, techniques, way },
        limits,
        light_sampler,
        |x, y, colour| {
            if colour.is_finite() {
                light.add_anywhere(x, y, colour);
            } else {
                non_finite += 1;
            }
        },
    );
    s.counts.rays += u64::from(rays);
    s.counts.non_finite += non_finite;
    if techniques == Techniques::All {
        add_aimed(lens, path.moment(), &mut s);
    }
    let mut sampler = s.sampler();
    let [u0, u1, u2, u3] = sampler.next_4d();
    let [u_wavelength, u_column, u_row, _] = sampler.next_4d();
    let place = raster.place(s.x, s.y, [u0, u1]);
    let pixel = [s.x, s.y];
    let u_pixels = [u_column, u_row];
    let request = Request { pixel, place, u_lens: [u2, u3], u_wavelength, u_pixels, ..Request::default() };
    let led = lens.lead_all(&request, raster);
    s.count_camera(led.is_none());
    let Some(led) = led else { return s.lost() };
    let ray = shot.seen(led.ray).at(path.moment());
    let ray = shot.exposure.map_or(ray, |exposure| exposure.sent(ray, path.moment()));
    let aimed = shot.aimed.as_deref();
    let camera = CameraEnd { lens, ray, density: lens.led_density(&led), way, aimed };
    let found = path.join(stage, &camera, limits, sampler);
    if !s.count_path(&found) {
        return;
    }
    if techniques == Techniques::All {
        s.splat(lens, &led.splats, found.radiance);
    }
    s.note(&found, &led.ray, u_wavelength);
}

/// Adds the light of the ray that a source sends straight to the lens, if one belongs to the sample.
fn add_aimed(lens: &RealLens, moment: u16, s: &mut Sample<'_>) {
    let shot = s.shot;
    let Some(aimed) = &shot.aimed else { return };
    let Some((sent, sampler)) = aimed.ray(shot.stage, shot.raster, shot.number([s.x, s.y], s.index), moment) else {
        return;
    };
    let ray = shot.seen(sent.ray).at(moment);
    let ray = shot.exposure.map_or(ray, |exposure| exposure.sent(ray, moment));
    let found = bidirectional::see(shot.stage, ray, sent.source, &shot.limits, sampler);
    if s.count_path(&found) {
        lens.expose(&sent.splats, found.radiance, |x, y, colour| s.light.add_aimed(x, y, colour.truncate()));
    }
}
