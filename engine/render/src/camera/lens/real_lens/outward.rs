//! Rays from points of the picture out through the lens, many at a time, in numbers of one kind.
//!
//! Between the picture and the scene nothing is ever wider than those numbers: in single precision twice as many rays share
//! every step.

use super::super::mount::Mount;
use super::packet::Request;
use super::{FilmLine, LensSample, RealLens};
use crate::accel::Ray;
use crate::camera::CameraRay;
use crate::spectrum::FilmSpectrum;
use glam::{DMat3, DVec3, Mat3, Vec3A};
use petzval_optics::lane::Real;
use petzval_optics::trace::{LINES, SpectralBundle, SpectralTracer, Traced, Travel};
use wide::f32x8;

/// The way out, ready for rays.
pub(in crate::camera) struct Outward<R: Traced> {
    tracer: SpectralTracer<R>,
    /// The film; `None` if it is curved.
    film: Option<FlatFilm<R>>,
    /// The world; `None` if its axes have different scales.
    world: Option<ToRender<R>>,
    /// The film's response at each wavelength in the picture's colours, and the gain.
    responses: Vec<Mat3>,
    gains: Vec<R>,
}

/// Memory for batches on the way out.
pub(in crate::camera) struct OutwardBatch<R: Traced> {
    rays: SpectralBundle<R>,
    /// Density of the choice of each request.
    densities: Vec<R>,
    /// The part of the light that the lens lets through along each request's ray; empty where nothing is lost.
    parts: Vec<f32>,
}

/// A flat film as it is seen from the vertex of the last surface.
struct FlatFilm<R> {
    /// The middle of the picture, and from there its whole width and height, on the film turned by half a turn.
    middle: [R; 3],
    width: [R; 3],
    height: [R; 3],
    /// The unit normal, away from the scene.
    away: [R; 3],
    /// The vertex in lens space.
    vertex_z: R,
}

/// The transform from the vertex of the first surface to render space.
struct ToRender<R> {
    /// Rows, of points and of directions.
    points: [[R; 3]; 3],
    directions: [[R; 3]; 3],
    /// The z in lens space, mm, of the point that stands at the camera's origin.
    origin_z: R,
}

fn numbers<R: Real>(v: DVec3) -> [R; 3] {
    v.to_array().map(R::from_f64)
}

/// The nearest number of this kind; exact.
#[inline(always)]
fn of_short<R: Real>(x: f32) -> R {
    R::from_f64(f64::from(x))
}

impl<R: Real> FlatFilm<R> {
    fn new(mount: &Mount, vertex_z_mm: f64) -> Option<Self> {
        let (axes, middle) = mount.frame.flat()?;
        Some(Self {
            middle: numbers(middle - DVec3::new(0.0, 0.0, vertex_z_mm)),
            width: numbers(axes.x_axis * -mount.info.picture_width_mm),
            height: numbers(axes.y_axis * -mount.info.picture_height_mm),
            away: numbers(axes.z_axis),
            vertex_z: R::from_f64(vertex_z_mm),
        })
    }

    /// Chooses a ray for each of at most as many requests as fill a register: where it crosses the plane of the pupil's map,
    /// its direction, and the density of the choice as [`LensSample`] has it.
    #[inline]
    fn aim(&self, lens: &RealLens, requests: &[Request]) -> ([[R; LINES]; 5], [R; LINES]) {
        let mut places = [[0.0f32; LINES]; 2];
        let mut u = [[0.5f32; LINES]; 2];
        for (i, request) in requests.iter().enumerate() {
            (places[0][i], places[1][i]) = (request.place.x, request.place.y);
            [u[0][i], u[1][i]] = request.u_lens;
        }
        let mut film = [[R::ZERO; LINES]; 3];
        let mut film_in_short = [[0.0f32; LINES]; 3];
        for (axis, (film, in_short)) in film.iter_mut().zip(&mut film_in_short).enumerate() {
            let (middle, width, height) = (self.middle[axis], self.width[axis], self.height[axis]);
            let to_lens_space = if axis == 2 { self.vertex_z } else { R::ZERO };
            for i in 0..LINES {
                film[i] = middle + width * of_short::<R>(places[0][i]) + height * of_short::<R>(places[1][i]);
                in_short[i] = (film[i] + to_lens_space).to_f64() as f32;
            }
        }
        let aims = lens.map.samples(&film_in_short, &u);
        let mut rays = [[R::ZERO; LINES]; 5];
        let mut densities = [R::ZERO; LINES];
        for i in 0..LINES {
            let [x, y] = [of_short::<R>(aims.target[0][i]), of_short::<R>(aims.target[1][i])];
            // The plane touches the vertex.
            let (along_x, along_y, along_z) = (x - film[0][i], y - film[1][i], -film[2][i]);
            let distance2 = along_x * along_x + along_y * along_y + along_z * along_z;
            let inverse = R::ONE / distance2.sqrt();
            // Cosines are those over the distance.
            let cosines = (dot(&self.away, along_x, along_y, along_z) * along_z).abs();
            (rays[0][i], rays[1][i]) = (x, y);
            (rays[2][i], rays[3][i], rays[4][i]) = (along_x * inverse, along_y * inverse, along_z * inverse);
            densities[i] = of_short::<R>(aims.pdf_per_mm2[i]) * distance2 * distance2 / cosines;
        }
        (rays, densities)
    }
}

impl<R: Real> ToRender<R> {
    /// Transforms rays to render space: x, y and z of origins, then of directions.
    ///
    /// A call, not inlined: with arrays in memory the compiler works on whole registers.
    #[inline(never)]
    fn place(&self, [x, y, z, dx, dy, dz]: &[[R; LINES]; 6], there: &mut [[f32; LINES]; 6]) {
        let (points, directions) = there.split_at_mut(3);
        for axis in 0..3 {
            for i in 0..LINES {
                points[axis][i] = dot(&self.points[axis], x[i], y[i], z[i] - self.origin_z).to_f64() as f32;
                directions[axis][i] = dot(&self.directions[axis], dx[i], dy[i], dz[i]).to_f64() as f32;
            }
        }
    }

    fn new(mount: &Mount) -> Option<Self> {
        let rows = |m: &DMat3| [0, 1, 2].map(|i| numbers(m.row(i)));
        mount.scale()?;
        Some(Self {
            points: rows(mount.vectors()),
            directions: rows(mount.axes()),
            origin_z: R::from_f64(mount.origin_z_mm()),
        })
    }
}

/// The product of a row and a column.
#[inline(always)]
fn dot<R: Real>(row: &[R; 3], x: R, y: R, z: R) -> R {
    row[0] * x + row[1] * y + row[2] * z
}

impl<R: Traced> Outward<R> {
    /// The lens on the way out, at the film's wavelengths.
    pub(in crate::camera) fn new(
        mount: &Mount,
        vertex_z_mm: f64,
        tracer: SpectralTracer<R>,
        spectrum: &FilmSpectrum,
        lines: &[FilmLine],
    ) -> Self {
        Self {
            tracer,
            film: FlatFilm::new(mount, vertex_z_mm),
            world: ToRender::new(mount),
            responses: spectrum.wavelengths().iter().map(|w| w.response).collect(),
            gains: lines.iter().map(|line| R::from_f64(line.gain)).collect(),
        }
    }

    /// An empty batch for [`Self::trace`].
    pub(in crate::camera) fn batch(&self) -> OutwardBatch<R> {
        OutwardBatch { rays: self.tracer.bundle(Travel::FromFilm, 1), densities: Vec::new(), parts: Vec::new() }
    }

    /// Sends a ray for each request through the lens.
    pub(in crate::camera) fn trace(&self, lens: &RealLens, requests: &[Request], batch: &mut OutwardBatch<R>) {
        let OutwardBatch { rays, densities, parts } = batch;
        rays.clear();
        densities.clear();
        parts.clear();
        let line = |request: &Request| lens.spectrum.sample(request.u_wavelength);
        match &self.film {
            Some(film) => {
                for some in requests.chunks(LINES) {
                    let (aimed, some_densities) = film.aim(lens, some);
                    rays.push_crossing(&aimed, some.iter().map(line));
                    densities.extend_from_slice(&some_densities[..some.len()]);
                    if let Some(lost) = &lens.transmission {
                        let numbers = [0, 1, 2, 3].map(|n| f32x8::new(aimed[n].map(|x| x.to_f64() as f32)));
                        let through = lost.at_each(numbers, |i| some.get(i).map_or(0, line)).to_array();
                        parts.extend_from_slice(&through[..some.len()]);
                    }
                }
            }
            None => {
                for request in requests {
                    let (ray, density) = lens.aim_out(request.place, request.u_lens);
                    rays.push(ray, line(request));
                    densities.push(R::from_f64(density));
                    if let Some(lost) = &lens.transmission {
                        parts.push(lost.at(line(request), &ray));
                    }
                }
            }
        }
        self.tracer.trace(rays);
    }

    /// Appends the traced rays in the scene, and the weights of their light.
    pub(in crate::camera) fn finish(
        &self,
        lens: &RealLens,
        requests: &[Request],
        batch: &OutwardBatch<R>,
        rays: &mut Vec<Option<CameraRay>>,
    ) {
        let Some(world) = &self.world else {
            rays.extend(requests.iter().enumerate().map(|(i, request)| {
                let index = lens.spectrum.sample(request.u_wavelength);
                batch.lead(i).map(|lead| lens.weighted(index, &lead))
            }));
            return;
        };
        let (mut out, mut there) = ([[R::ZERO; LINES]; 6], [[0.0; LINES]; 6]);
        for (group, some) in requests.chunks(LINES).enumerate() {
            let first = group * LINES;
            let through = batch.rays.results(first, &mut out);
            world.place(&out, &mut there);
            let [x, y, z, dx, dy, dz] = &there;
            let mut lines = [0; LINES];
            let mut weights = [0.0f32; LINES];
            for (i, request) in some.iter().enumerate() {
                lines[i] = lens.spectrum.sample(request.u_wavelength);
                weights[i] = (self.gains[lines[i]] / batch.densities[first + i]).to_f64() as f32;
            }
            // None where nothing is lost.
            for (weight, part) in weights.iter_mut().zip(batch.parts.iter().skip(first)) {
                *weight *= part;
            }
            rays.extend((0..some.len()).map(|i| {
                let ray = Ray::new(Vec3A::new(x[i], y[i], z[i]), Vec3A::new(dx[i], dy[i], dz[i]));
                let is_through = through >> i & 1 != 0;
                is_through.then(|| CameraRay { ray, weight: self.responses[lines[i]] * weights[i] })
            }));
        }
    }
}

impl<R: Traced> OutwardBatch<R> {
    /// The ray of request `i`.
    #[inline]
    pub(in crate::camera) fn lead(&self, i: usize) -> Option<LensSample> {
        self.rays.result(i).ok().map(|out| LensSample {
            out,
            density: self.densities[i].to_f64(),
            part: self.parts.get(i).copied().unwrap_or(1.0),
        })
    }
}
