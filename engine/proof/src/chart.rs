//! The rays of a lens by four numbers: film radius, place on the rim of the disc that is aimed at, wavelength, part of the way to that rim.
//!
//! A film point lies at (0, r). The disc touches the last vertex and is wide enough for every ray to the rear glass. With (x, y) = ((1 −
//! u²) / (1 + u²), 2 u / (1 + u²)), u from −1 to 1, the half of its rim with x ≥ 0, rays are aimed at s R (x, y) + (1 − s) (0, c), where
//! c = k₀ + k₁ r is a place within the disc. All is algebraic, so no sine need be enclosed.
//!
//! All rays of a lens that looks the same from all azimuths are these, turned about the axis and mirrored in the meridian.

use glam::DVec3;

use crate::passage::{Beam, aimed};
use crate::taylor::Taylor;
use petzval_optics::trace::Ray;

/// The film and the disc.
#[derive(Clone, Copy, Debug)]
pub struct Chart {
    /// Radius of the film's disc, mm.
    pub film_radius_mm: f64,
    /// The film's middle from the last vertex, mm.
    pub film_z_mm: f64,
    /// Curvature of the film, 1/mm; 0: flat.
    pub film_curvature_per_mm: f64,
    /// Radius of the disc at the last vertex, mm.
    pub disc_radius_mm: f64,
    /// z of the last vertex in lens space, mm.
    pub last_z_mm: f64,
    /// The shortest and the longest wavelength, nm.
    pub wavelengths_nm: [f64; 2],
}

/// The centre from which the way to the rim is counted, for film points from one radius to another: y = k₀ + k₁ r, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centre {
    /// k₀, mm.
    pub at_axis_mm: f64,
    /// k₁.
    pub slope: f64,
}

/// Bounds of film radius (mm), u, and wavelength (nm): the floor of a column of rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Lower bounds.
    pub low: [f64; 3],
    /// Upper bounds.
    pub high: [f64; 3],
}

impl Floor {
    /// The point at ε, each in −1 to 1.
    pub fn at(&self, epsilon: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.middle(i) + self.half(i) * epsilon[i])
    }

    fn middle(&self, i: usize) -> f64 {
        0.5 * (self.low[i] + self.high[i])
    }

    fn half(&self, i: usize) -> f64 {
        0.5 * (self.high[i] - self.low[i])
    }

    /// The two halves across dimension `i`.
    pub fn halves(&self, i: usize) -> [Self; 2] {
        let (mut below, mut above) = (*self, *self);
        below.high[i] = self.middle(i);
        above.low[i] = self.middle(i);
        [below, above]
    }

    /// The i-th number over the floor; the ends are covered whatever the rounding of the middle.
    pub(super) fn number<const N: usize>(&self, i: usize) -> Taylor<N> {
        let slack = (self.low[i].abs() + self.high[i].abs()) * 4.0 * f64::EPSILON;
        Taylor::variable(self.middle(i), self.half(i), i).widened(slack)
    }
}

impl Chart {
    /// The ray of film radius `r_mm`, rim place `u` and part `s`, in lens space.
    pub fn ray(&self, centre: Centre, r_mm: f64, u: f64, s: f64) -> Ray {
        let [x, y] = rim(u);
        let c = centre.at_axis_mm + centre.slope * r_mm;
        let disc = self.disc_radius_mm;
        let target = DVec3::new(s * disc * x, s * disc * y + (1.0 - s) * c, self.last_z_mm);
        let k = self.film_curvature_per_mm;
        let sag = k * r_mm * r_mm / (1.0 + (1.0 - k * k * r_mm * r_mm).max(0.0).sqrt());
        let film = DVec3::new(0.0, r_mm, self.last_z_mm + self.film_z_mm + sag);
        Ray { origin: film, direction: (target - film).normalize() }
    }

    /// The rays over a floor, `s` given, seen from the last vertex.
    pub(super) fn beam<const N: usize>(&self, centre: Centre, floor: &Floor, s: Taylor<N>) -> Beam<N> {
        let r: Taylor<N> = floor.number(0);
        let u: Taylor<N> = floor.number(1);
        let over = u.squared().plus(1.0).reciprocal();
        let x = (-u.squared()).plus(1.0) * over;
        let y = u.times(2.0) * over;
        let c = r.times(centre.slope).plus(centre.at_axis_mm);
        let out = s.times(self.disc_radius_mm);
        let target = [out * x, out * y + (-s).plus(1.0) * c, Taylor::constant(0.0)];
        let k = self.film_curvature_per_mm;
        let mut depth = Taylor::constant(self.film_z_mm);
        if k != 0.0 {
            let squared = r.squared();
            let cosine = (-squared.times(k).times(k)).plus(1.0).sqrt();
            depth = depth + squared.times(k) / cosine.plus(1.0);
        }
        aimed(&[Taylor::constant(0.0), r, depth], &target)
    }

    /// Four-dimensional volume, area of the film times area of the disc times wavelengths, mm⁴ nm, of both mirrored halves, between
    /// the parts `low` and `high` over a floor. By Gauss's rule with three points a dimension.
    pub fn volume(&self, centre: Centre, floor: &Floor, part: impl Fn([f64; 3]) -> [f64; 2]) -> f64 {
        const PLACE: f64 = 0.774_596_669_241_483_4;
        const NODES: [(f64, f64); 3] = [(-PLACE, 5.0 / 18.0), (0.0, 8.0 / 18.0), (PLACE, 5.0 / 18.0)];
        let mut sum = 0.0;
        for (a, wa) in NODES {
            for (b, wb) in NODES {
                for (c, wc) in NODES {
                    let epsilon = [a, b, c];
                    let [low, high] = part(epsilon).map(|s| s.clamp(0.0, 1.0));
                    let [r, u, _] = floor.at(epsilon);
                    let disc = self.disc_radius_mm;
                    let [_, y] = rim(u);
                    let middle = centre.at_axis_mm + centre.slope * r;
                    // s R (R − c · e) ds dφ, dφ = 2 du / (1 + u²).
                    let area =
                        0.5 * (high * high - low * low).max(0.0) * disc * (disc - middle * y) * 2.0 / (1.0 + u * u);
                    sum += wa * wb * wc * area * std::f64::consts::TAU * r;
                }
            }
        }
        let size: f64 = [0, 1, 2].map(|i| floor.high[i] - floor.low[i]).iter().product();
        2.0 * sum * size
    }

    /// [`Self::volume`] of all rays.
    pub fn whole_volume(&self) -> f64 {
        let area = |radius: f64| std::f64::consts::PI * radius * radius;
        let [shortest, longest] = self.wavelengths_nm;
        area(self.film_radius_mm) * area(self.disc_radius_mm) * (longest - shortest)
    }
}

fn rim(u: f64) -> [f64; 2] {
    [(1.0 - u * u) / (1.0 + u * u), 2.0 * u / (1.0 + u * u)]
}
