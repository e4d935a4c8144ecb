//! The precision of the rays of a camera that leave through its lens: single, with twice as many in a register, where the difference is
//! invisible; decided for each camera by measuring.
//!
//! The ray that single precision finds is taken back through the lens in double precision, without rims: it is exactly the
//! ray of a film point somewhat aside, and how far aside, in pixels of this picture, is the error. It holds whatever the
//! scene and wherever in it things are, and knows the resolution, the size of the film and the focal length.

use super::RealLens;
use super::outward::Outward;
use super::packet::{Request, backwards};
use crate::sampler::evenly::Evenly;
use glam::{DVec2, Vec2};
use petzval_optics::trace::{Traced, Tracer};
use serde::Deserialize;

/// The precision that is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Precision {
    /// Single where the error of single precision is below [`TOLERANCE_PX`].
    #[default]
    Auto,
    /// Always `f32`, with twice as many rays in a register.
    #[serde(rename = "F32")]
    Single,
    /// Always `f64`.
    #[serde(rename = "F64")]
    Double,
}

impl Precision {
    /// The name by which it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Single => "f32",
            Self::Double => "f64",
        }
    }
}

/// The precision of a camera, and its reason.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// The precision that was asked for.
    pub asked: Precision,
    /// True for f32, false for f64.
    pub is_single: bool,
    /// Largest displacement of a ray by single precision, pixels; infinite where it loses rays that double precision has, finds some that
    /// it has not, or cannot hold their weights.
    pub error_px: f64,
}

/// A tenth of the displacement that can be told apart in the sharpest picture.
pub const TOLERANCE_PX: f64 = 0.01;
/// The worst of the rays that are tried is counted so many times: between them lie worse ones.
const MARGIN: f64 = 2.0;
/// Rays that are tried.
const RAYS: u32 = 2048;
/// Edges of the pupil are as sharp as this, in the numbers that choose its points.
const EDGE: f32 = 1e-4;

impl Chosen {
    /// Double precision, before single precision was tried.
    pub(in crate::camera) fn double(asked: Precision) -> Self {
        Self { asked, is_single: false, error_px: f64::INFINITY }
    }

    /// The precision for a lens as it is in this camera, of whose picture the size is given in pixels.
    pub(in crate::camera) fn measure(asked: Precision, lens: &RealLens, single: &Outward<f32>, size: [u32; 2]) -> Self {
        let points = Evenly::default();
        let error_px = MARGIN * worst_px(lens, single, &lens.outward(), size, |i| fan(&points, i));
        let is_single = match asked {
            Precision::Auto => error_px <= TOLERANCE_PX,
            Precision::Single => true,
            Precision::Double => false,
        };
        Self { asked, is_single, error_px }
    }

    /// The name of the precision that was chosen.
    pub fn name(&self) -> &'static str {
        if self.is_single { "f32" } else { "f64" }
    }
}

/// Ray `i` of those that are tried: all over picture, pupil and spectrum, a quarter of them at the picture's edge, where
/// rays are steepest, and half at the pupil's.
fn fan(points: &Evenly<5>, i: u32) -> Request {
    let [mut x, mut y, azimuth, radius, u_wavelength] = points.point(i + 1).map(|u| u as f32);
    if i.is_multiple_of(4) {
        let out = 0.5 / (x - 0.5).abs().max((y - 0.5).abs()).max(1e-3);
        (x, y) = (0.5 + (x - 0.5) * out, 0.5 + (y - 0.5) * out);
    }
    let radius = if i.is_multiple_of(2) { 1.0 - EDGE * radius } else { radius };
    Request { place: Vec2::new(x - 0.5, y - 0.5), u_lens: [azimuth, radius], u_wavelength, ..Request::default() }
}

/// The largest error of [`RAYS`] requests in pixels.
fn worst_px(
    lens: &RealLens,
    single: &Outward<f32>,
    double: &Outward<f64>,
    size: [u32; 2],
    request: impl Fn(u32) -> Request,
) -> f64 {
    let requests: Vec<Request> = (0..RAYS).map(request).collect();
    let tracers: Vec<Tracer> = lens.lines.iter().map(|line| line.tracer.without_rims()).collect();
    let (mut short, mut long) = (single.batch(), double.batch());
    single.trace(lens, &requests, &mut short);
    double.trace(lens, &requests, &mut long);
    let mut worst: f64 = 0.0;
    for (i, request) in requests.iter().enumerate() {
        let error = match (short.lead(i), long.lead(i)) {
            // Of a lens of light years, say.
            (Some(lead), _) if !(lead.density > 0.0 && lead.density.is_finite()) => f64::INFINITY,
            (Some(lead), Some(_)) => {
                let tracer = &tracers[lens.spectrum.sample(request.u_wavelength)];
                let back = tracer.from_scene(backwards(&lead)).ok();
                back.and_then(|ray| lens.mount.picture_point(&ray)).map_or(f64::INFINITY, |place| {
                    let away = (place - request.place).as_dvec2();
                    (away * DVec2::new(size[0].into(), size[1].into())).length()
                })
            }
            (None, None) => 0.0,
            _ if is_at_an_edge(lens, double, request) => 0.0,
            _ => f64::INFINITY,
        };
        worst = worst.max(error);
    }
    worst
}

/// True if some of a request's neighbours in the pupil get through the lens, and some do not.
fn is_at_an_edge<R: Traced>(lens: &RealLens, way: &Outward<R>, request: &Request) -> bool {
    let [u, v] = request.u_lens;
    let near = |u: f32, v: f32| Request { u_lens: [u.clamp(0.0, 1.0), v.clamp(0.0, 1.0)], ..*request };
    let all = [near(u, v), near(u - EDGE, v), near(u + EDGE, v), near(u, v - EDGE), near(u, v + EDGE)];
    let mut batch = way.batch();
    way.trace(lens, &all, &mut batch);
    let passed = (0..all.len()).filter(|&i| batch.lead(i).is_some()).count();
    passed > 0 && passed < all.len()
}

#[cfg(test)]
pub(in crate::camera) mod tests;
