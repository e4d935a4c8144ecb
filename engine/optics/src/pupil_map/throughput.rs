//! The light of a uniform world that reaches the middle of the film.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::system::System;
use crate::trace::{Ray, Tracer};

/// Points along a meridian at which the pupil is tried before its edges are narrowed down: a lens whose clear pupil
/// has narrower rings than a part in so many of the rear glass loses them.
const SCAN: usize = 1024;
/// Parts of half a blade, with two azimuths each (Gauss): the error is below 1e-6 even for a triangle.
const PARTS: usize = 16;

/// Meridians of a lens that is not symmetric about its axis. The sum over a smooth outline converges faster than any
/// power; corners of blades leave an error below 1e-4, the details of a mask the area that they
/// cover between two meridians.
const AZIMUTHS: u32 = 256;

/// ∫ cos θ_film cos θ_plane / d² dA over the clear pupil on the reference plane, seen from the point (0, 0,
/// `film_z_mm`) of a film at right angles to the axis: the irradiance there under a uniform world of radiance 1, without
/// transmission losses.
///
/// On the axis the pupil is a set of rings, and a ring between the angles a and b from the axis gives
/// π (sin² b − sin² a): only the edges need to be found, to rounding. With blades the edges depend on the azimuth,
/// evenly over half a blade by symmetry.
pub fn on_axis_throughput(tracer: &Tracer, system: &System, film_z_mm: f64) -> f64 {
    let diaphragm = system.diaphragm();
    let blades = diaphragm.blades();
    if !system.is_rotationally_symmetric() || diaphragm.is_masked() {
        let angle = |i: u32| TAU * (f64::from(i) + 0.5) / f64::from(AZIMUTHS);
        let all = (0..AZIMUTHS).map(|i| along_meridian(tracer, system, film_z_mm, DVec2::from_angle(angle(i))));
        return PI * all.sum::<f64>() / f64::from(AZIMUTHS);
    }
    if blades == 0 {
        return PI * along_meridian(tracer, system, film_z_mm, DVec2::X);
    }
    let half_blade = PI / f64::from(blades);
    let across = |place: f64| diaphragm.rotation_rad() + half_blade * place / PARTS as f64;
    let gauss = 0.5 / 3f64.sqrt();
    let places = (0..PARTS).map(|i| i as f64 + 0.5).flat_map(|middle| [middle - gauss, middle + gauss]);
    let sum: f64 =
        places.map(|place| along_meridian(tracer, system, film_z_mm, DVec2::from_angle(across(place)))).sum();
    PI * sum / (2 * PARTS) as f64
}

/// [`on_axis_throughput`] if no surface had an obstruction.
pub fn on_axis_throughput_without_obstructions(tracer: &Tracer, system: &System, film_z_mm: f64) -> f64 {
    on_axis_throughput(&tracer.without_obstructions(), system, film_z_mm)
}

/// The part of [`on_axis_throughput`] that central obstructions leave: 1 without them.
pub fn unobstructed_part(tracer: &Tracer, system: &System, film_z_mm: f64) -> f64 {
    if !tracer.has_obstructions() {
        return 1.0;
    }
    on_axis_throughput(tracer, system, film_z_mm) / on_axis_throughput_without_obstructions(tracer, system, film_z_mm)
}

/// Σ sin² b − sin² a over the clear rings [a, b] along one meridian.
fn along_meridian(tracer: &Tracer, system: &System, film_z_mm: f64, meridian: DVec2) -> f64 {
    let rear = &system.surfaces()[system.surface_count() - 1];
    let towards = (rear.z_mm - film_z_mm).signum();
    let origin = DVec3::new(0.0, 0.0, film_z_mm);
    let is_clear = |angle: f64| {
        let direction = (meridian * angle.sin()).extend(towards * angle.cos());
        tracer.from_film(Ray { origin, direction }).is_ok()
    };
    let widest = widest_angle(system, film_z_mm);
    let place = |i: usize| widest * i as f64 / SCAN as f64;
    let mut sum = 0.0;
    let mut was_clear = is_clear(0.0);
    for i in 1..=SCAN {
        let now_clear = is_clear(place(i));
        if now_clear != was_clear {
            let edge = edge_between(place(i - 1), place(i), |x| is_clear(x) == was_clear);
            sum += edge.sin().powi(2) * if was_clear { 1.0 } else { -1.0 };
        }
        was_clear = now_clear;
    }
    if was_clear { sum + widest.sin().powi(2) } else { sum }
}

/// No ray to the rear glass leaves the film at a larger angle from the axis.
fn widest_angle(system: &System, film_z_mm: f64) -> f64 {
    let rear = &system.surfaces()[system.surface_count() - 1];
    let semi = rear.semi_diameter_mm;
    let sag = rear.shape.rim_sag_mm(semi).unwrap_or(0.0);
    let distance = (rear.z_mm - film_z_mm).abs();
    let rim = (rear.z_mm + sag - film_z_mm).abs();
    (semi.atan2(rim.min(distance)) * 1.01).min(0.5 * PI)
}

fn edge_between(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
