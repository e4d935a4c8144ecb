//! Many camera samples at a time: their rays go through the lens together, as many in step as the processor's registers
//! hold.

use super::CameraRay;
use super::packet::{Led, Request, backwards};
use super::real_lens::{Lead, RealLens};
use crate::accel::Ray;
use crate::sampler::raster::Raster;
use glam::{DMat3, DVec3, Vec3A};
use petzval_optics::trace::{LINES, SpectralBundle, Travel};

/// Memory for batches of one lens.
pub struct LensBatch {
    out: SpectralBundle,
    back: SpectralBundle<f32>,
    /// By request: the density of its choice.
    densities: Vec<f64>,
}

impl RealLens {
    /// For batches of this lens.
    pub fn batch(&self) -> LensBatch {
        let lines = &self.film_lines;
        LensBatch {
            out: lines.out.bundle(Travel::FromFilm, 1),
            back: lines.back_in_short.bundle(Travel::FromScene, LINES),
            densities: Vec::new(),
        }
    }

    /// [`Self::sample`] for each request, to the last bit (on a shifted film but for roundings).
    pub fn sample_batch(&self, requests: &[Request], batch: &mut LensBatch, rays: &mut Vec<Option<CameraRay>>) {
        self.lead_batch(requests, batch);
        if self.mount.scale().is_none() {
            rays.extend(requests.iter().enumerate().map(|(i, request)| {
                batch.lead(i).map(|lead| self.weighted(self.spectrum.sample(request.u_wavelength), &lead))
            }));
            return;
        }
        for (group, some) in requests.chunks(LINES).enumerate() {
            let first = group * LINES;
            let (out, through) = batch.out.results(first);
            let [x, y, z, dx, dy, dz] = self.mount.to_render_some(&out);
            for (i, request) in some.iter().enumerate() {
                let ray = Ray::new(Vec3A::new(x[i], y[i], z[i]), Vec3A::new(dx[i], dy[i], dz[i]));
                let line = self.spectrum.sample(request.u_wavelength);
                let is_through = through >> i & 1 != 0;
                rays.push(is_through.then(|| CameraRay { ray, weight: self.weight(line, batch.densities[first + i]) }));
            }
        }
    }

    /// [`Self::lead_all`] for each request; the wavelengths that do not lead in numbers of single precision.
    pub fn lead_all_batch(
        &self,
        requests: &[Request],
        raster: &Raster,
        batch: &mut LensBatch,
        led: &mut Vec<Option<Led>>,
    ) {
        self.lead_batch(requests, batch);
        batch.back.clear();
        for (i, request) in requests.iter().enumerate() {
            if let Some(lead) = batch.lead(i) {
                let (set, _) = self.leader(request.u_wavelength);
                batch.back.push(backwards(&lead), set * LINES);
            }
        }
        self.film_lines.back_in_short.trace(&mut batch.back);
        let mut group = 0;
        led.extend(requests.iter().enumerate().map(|(i, request)| {
            let lead = batch.lead(i)?;
            group += 1;
            Some(match &self.short_film {
                Some(film) => self.joined_in_short(film, request, &lead, &batch.back.leaving(group - 1), raster),
                None => {
                    let (set, _) = self.leader(request.u_wavelength);
                    let ray = |line| batch.back.result((group - 1) * LINES + line);
                    let arrivals = self.arrived(set, ray, raster, request.u_pixels);
                    self.joined(request, &lead, arrivals, raster)
                }
            })
        }));
    }

    fn lead_batch(&self, requests: &[Request], batch: &mut LensBatch) {
        let LensBatch { out, densities, .. } = batch;
        out.clear();
        densities.clear();
        let line = |request: &Request| self.spectrum.sample(request.u_wavelength);
        match self.mount.frame.flat() {
            Some((axes, middle)) => {
                for some in requests.chunks(LINES) {
                    let (rays, some_densities) = self.aim_some(&axes, middle, some);
                    out.push_some(&rays, some.iter().map(line));
                    densities.extend_from_slice(&some_densities[..some.len()]);
                }
            }
            None => {
                for request in requests {
                    let (ray, density) = self.aim_out(request.place, request.u_lens);
                    out.push(ray, line(request));
                    densities.push(density);
                }
            }
        }
        self.film_lines.out.trace(out);
    }

    /// [`Self::aim_out`] for at most as many requests as fill a register, from a flat film with these axes and this middle:
    /// x, y, z of the origins, then of the directions, and the densities.
    #[inline]
    fn aim_some(&self, axes: &DMat3, middle: DVec3, requests: &[Request]) -> ([[f64; LINES]; 6], [f64; LINES]) {
        let mut places = [[0.0f64; LINES]; 2];
        let mut u = [[0.5f64; LINES]; 2];
        for (i, request) in requests.iter().enumerate() {
            (places[0][i], places[1][i]) = (f64::from(request.place.x), f64::from(request.place.y));
            (u[0][i], u[1][i]) = (f64::from(request.u_lens[0]), f64::from(request.u_lens[1]));
        }
        let info = &self.mount.info;
        let (right, up, away) = (axes.x_axis, axes.y_axis, axes.z_axis);
        let mut film = [[0.0f64; LINES]; 3];
        for i in 0..LINES {
            let (u_mm, v_mm) = (-places[0][i] * info.picture_width_mm, -places[1][i] * info.picture_height_mm);
            film[0][i] = middle.x + right.x * u_mm + up.x * v_mm;
            film[1][i] = middle.y + right.y * u_mm + up.y * v_mm;
            film[2][i] = middle.z + right.z * u_mm + up.z * v_mm;
        }
        let aims = self.map.samples(&film, &u);
        let plane_z = self.map.reference_plane_z();
        let [mut dx, mut dy, mut dz, mut density] = [[0.0f64; LINES]; 4];
        for i in 0..LINES {
            let (x, y, z) = (aims.target[0][i] - film[0][i], aims.target[1][i] - film[1][i], plane_z - film[2][i]);
            let distance2 = x * x + y * y + z * z;
            let inverse = distance2.sqrt().recip();
            let cosines = ((away.x * x + away.y * y + away.z * z) * z).abs();
            (dx[i], dy[i], dz[i]) = (x * inverse, y * inverse, z * inverse);
            density[i] = aims.pdf_per_mm2[i] * distance2 * distance2 / cosines;
        }
        let [x, y, z] = film;
        ([x, y, z, dx, dy, dz], density)
    }
}

impl LensBatch {
    /// What became of request `i`.
    #[inline]
    fn lead(&self, i: usize) -> Option<Lead> {
        self.out.result(i).ok().map(|out| Lead { out, density: self.densities[i] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::camera::tests::with_lens;
    use crate::sampler::{PathSampler, warp::PixelFilter};

    const SIZE: [u32; 2] = [3840, 2160];

    fn requests(raster: &Raster) -> Vec<Request> {
        let request = |i: u32| {
            // All over the picture.
            let pixel = [i * 7919 % SIZE[0], i * 104_729 % SIZE[1]];
            let mut sampler = PathSampler::new(pixel[0], pixel[1], 0, 1);
            let ([u0, u1, u2, u3], [u4, u5, u6, _]) = (sampler.next_4d(), sampler.next_4d());
            let place = raster.place(pixel[0], pixel[1], [u0, u1]);
            Request { pixel, place, u_lens: [u2, u3], u_wavelength: u4, u_pixels: [u5, u6], ..Request::default() }
        };
        (0..1000).map(request).collect()
    }

    fn cameras() -> impl Iterator<Item = Camera> {
        let cases = [
            ("wide-angle-smith-f3.4", 32.0, 18.0, 0.0),
            ("laikin-fisheye-170", 24.0, 13.5, 0.0),
            ("angenieux-f1.1", 36.0, 20.25, 0.15),
            ("eye-navarro", 8.0, 4.5, 0.0),
        ];
        cases.into_iter().map(|(lens, width, height, tilt)| {
            Camera::new(&with_lens(&format!("{lens}.lens"), width, height, tilt), SIZE[0], SIZE[1]).unwrap()
        })
    }

    #[test]
    fn a_sample_of_a_batch_is_the_sample_alone() {
        let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(1.5));
        let requests = requests(&raster);
        let mut passed = 0;
        for camera in cameras() {
            let lens = camera.traced_lens().unwrap();
            let (mut batch, mut rays) = (lens.batch(), Vec::new());
            // The second time as many fewer.
            for requests in [&requests[..], &requests[..77]] {
                rays.clear();
                lens.sample_batch(requests, &mut batch, &mut rays);
                assert_eq!(rays.len(), requests.len());
                for (r, ray) in requests.iter().zip(&rays) {
                    let alone = camera.sample(r.place, r.u_lens, r.u_wavelength);
                    let parts = |ray: &CameraRay| (ray.ray.origin, ray.ray.direction, ray.weight);
                    assert_eq!(ray.as_ref().map(parts), alone.as_ref().map(parts), "{}", camera.name());
                    passed += usize::from(alone.is_some());
                }
            }
        }
        assert!(passed > 3000, "{passed}");
    }

    /// Single precision moves the wavelengths that do not lead by so little that hardly one goes to another pixel, even
    /// in 4K.
    #[test]
    fn short_numbers_land_in_the_same_pixels() {
        let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(1.5));
        let requests = requests(&raster);
        let (mut same, mut other) = (0, 0);
        for camera in cameras() {
            let lens = camera.traced_lens().unwrap();
            let (mut batch, mut leads) = (lens.batch(), Vec::new());
            lens.lead_all_batch(&requests, &raster, &mut batch, &mut leads);
            for (r, led) in requests.iter().zip(&leads) {
                let alone = lens.lead_all(r, &raster);
                assert_eq!(led.is_some(), alone.is_some());
                let (Some(led), Some(alone)) = (led, alone) else { continue };
                for splat in alone.splats.as_slice() {
                    // A hundredth of a pixel changes the density of places by some 1e-4; where the density of the choice
                    // jumps, at the edge of the pupil's map, so does the weight.
                    let is_same = led.splats.as_slice().iter().any(|s| {
                        let near = (s.weight / splat.weight - 1.0).abs() < 2e-3;
                        (s.x, s.y, s.wavelength) == (splat.x, splat.y, splat.wavelength) && near
                    });
                    if is_same { same += 1 } else { other += 1 }
                }
            }
        }
        assert!(same > 20_000 && other * 200 < same, "{same} {other}");
    }
}
