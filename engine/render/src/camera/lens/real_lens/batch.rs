//! Many camera samples at a time: their rays go through the lens together, as many in step as the processor's registers
//! hold.

use super::outward::{Outward, OutwardBatch};
use super::packet::{HeroSample, Request, backwards};
use super::{LensSample, RealLens};
use crate::camera::CameraRay;
use crate::sampler::raster::Raster;
use crate::spectrum::SET_SIZE;
use petzval_optics::trace::{LINES, SpectralBundle, Travel};

/// The way out of the lens, in the numbers that were chosen for it.
pub(in crate::camera) enum Out {
    Single(Outward<f32>),
    Double(Outward<f64>),
}

enum OutBatch {
    Single(OutwardBatch<f32>),
    Double(OutwardBatch<f64>),
}

/// Memory for batches of one lens.
pub struct LensBatch {
    out: OutBatch,
    back: SpectralBundle<f32>,
}

/// Calls a method of the way out, and hands it its part of a batch.
macro_rules! on_the_way_out {
    ($lens:expr, $batch:expr, |$out:ident, $memory:ident| $call:expr) => {
        match (&$lens.out, $batch) {
            (Out::Single($out), OutBatch::Single($memory)) => $call,
            (Out::Double($out), OutBatch::Double($memory)) => $call,
            _ => unreachable!("a batch is for the lens that made it"),
        }
    };
}

impl RealLens {
    /// Memory for batches of this lens.
    pub fn batch(&self) -> LensBatch {
        let out = match &self.out {
            Out::Single(out) => OutBatch::Single(out.batch()),
            Out::Double(out) => OutBatch::Double(out.batch()),
        };
        LensBatch { out, back: self.film_lines.back_in_short.bundle(Travel::FromScene, LINES) }
    }

    /// [`Self::sample`] for each request, to the last bit.
    pub fn sample_batch(&self, requests: &[Request], batch: &mut LensBatch, rays: &mut Vec<Option<CameraRay>>) {
        on_the_way_out!(self, &mut batch.out, |out, memory| {
            out.trace(self, requests, memory);
            out.finish(self, requests, memory, rays);
        });
    }

    /// [`Self::lead_all`] for each request; the wavelengths that do not lead in numbers of single precision.
    pub fn lead_all_batch(
        &self,
        requests: &[Request],
        raster: &Raster,
        batch: &mut LensBatch,
        led: &mut Vec<Option<HeroSample>>,
    ) {
        on_the_way_out!(self, &mut batch.out, |out, memory| out.trace(self, requests, memory));
        if self.packet_size() == 1 {
            // The leader's own arrival is known.
            led.extend(requests.iter().enumerate().map(|(i, request)| {
                let lead = batch.lead(i)?;
                Some(self.joined(request, &lead, [None; SET_SIZE], raster))
            }));
            return;
        }
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
                    let arrivals = self.arrived(set, ray, raster, request.pixel_numbers(raster));
                    self.joined(request, &lead, arrivals, raster)
                }
            })
        }));
    }

    /// The ray of one request at the wavelength that it chooses.
    pub(in crate::camera) fn lead(&self, request: &Request) -> Option<LensSample> {
        let mut batch = self.batch();
        on_the_way_out!(self, &mut batch.out, |out, memory| out.trace(self, std::slice::from_ref(request), memory));
        batch.lead(0)
    }
}

impl LensBatch {
    /// The ray of request `i`.
    #[inline]
    fn lead(&self, i: usize) -> Option<LensSample> {
        match &self.out {
            OutBatch::Single(out) => out.lead(i),
            OutBatch::Double(out) => out.lead(i),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::camera::tests::with_lens;
    use crate::sampler::{
        PathSampler,
        warp::{Filter, PixelFilter},
    };

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
        let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(Filter::BlackmanHarris(1.5)));
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
        let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(Filter::BlackmanHarris(1.5)));
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
