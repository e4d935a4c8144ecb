//! Ghosts without looking for them: rays that split at every surface into a reflected and a refracted one, and die out
//! by chance. Slow, and the reference for whatever is quicker.

use glam::DVec2;
use std::f64::consts::TAU;

use super::beam::Beam;
use super::power;
use crate::focus::FilmFrame;
use crate::system::System;
use crate::trace::{Ray, SurfaceEvent, Tracer};

/// A ray that is reflected so often is given up: of glass without coatings less than 1e-8 of the light is left.
const MOST_TURNS: usize = 8;
/// Russian roulette: of rays that have less than this part of their power left only some go on, with that power.
const LEAST_POWER: f64 = 1e-6;

/// Light that arrives at the film, by its number of reflections.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrived {
    /// Light for irradiance one in the middle of the beam's disc, mm², by the number of reflections.
    pub light_mm2: [f64; MOST_TURNS + 1],
    /// Standard errors of [`Self::light_mm2`].
    pub error_mm2: [f64; MOST_TURNS + 1],
}

/// The light is found so many times over, each with other rays: how far the results lie apart is their error.
const REPEATS: usize = 8;
/// A point's coordinates are multiples of these, without the whole (Roberts' sequence: 1 over the plastic number and its square):
/// they lie evenly in the square.
const EVENLY: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);

/// Sends `rays` through the lens at one wavelength. `is_film` tells which points (u, v), mm, count; `random` makes numbers from
/// 0 to 1.
pub fn arrived(
    system: &System,
    tracer: &Tracer,
    beam: &Beam,
    film: &FilmFrame,
    is_film: impl Fn(DVec2) -> bool,
    rays: usize,
    mut random: impl FnMut() -> f64,
) -> Arrived {
    let (mut sums, mut squares) = ([0.0; MOST_TURNS + 1], [0.0; MOST_TURNS + 1]);
    let each = rays.div_ceil(REPEATS);
    for _ in 0..REPEATS {
        let shift = DVec2::new(random(), random());
        let mut light = [0.0; MOST_TURNS + 1];
        for i in 0..each {
            let [u, v] = (shift + EVENLY * i as f64).fract().to_array();
            let at = DVec2::from_angle(TAU * v) * u.sqrt();
            one(system, tracer, beam.ray(at), &mut random, &mut |ray, power, turned| {
                if film.meet(&ray).map(DVec2::from).is_some_and(&is_film) {
                    light[turned] += beam.light_mm2(at) * 0.5 * TAU * power / each as f64;
                }
            });
        }
        for ((sum, square), light) in sums.iter_mut().zip(&mut squares).zip(light) {
            *sum += light;
            *square += light * light;
        }
    }
    let n = REPEATS as f64;
    let error = |i: usize| ((squares[i] / n - (sums[i] / n).powi(2)).max(0.0) / (n - 1.0)).sqrt();
    Arrived { light_mm2: sums.map(|sum| sum / n), error_mm2: std::array::from_fn(error) }
}

/// Follows all parts of one ray; calls `each` with those that leave the lens towards the film, its power and how often it was
/// reflected.
fn one(
    system: &System,
    tracer: &Tracer,
    ray: Ray,
    random: &mut impl FnMut() -> f64,
    each: &mut impl FnMut(Ray, f64, usize),
) {
    let mut under_way = vec![(tracer.wander(ray), 1.0, 0)];
    while let Some((wanderer, power, turned)) = under_way.pop() {
        match wanderer.encounter() {
            SurfaceEvent::Surface(incidence) => {
                let [reflected, transmitted] = power::parts(system, tracer.wavelength_nm(), &incidence);
                let on_the_way = power::on_the_way(system, tracer.wavelength_nm(), &incidence);
                for (turns, part) in [(true, reflected), (false, transmitted)] {
                    let left = power * part * on_the_way;
                    let stays = (left / LEAST_POWER).min(1.0);
                    let turned = turned + usize::from(turns);
                    let mut next = wanderer.clone();
                    if turned <= MOST_TURNS && random() < stays && next.go(turns).is_ok() {
                        under_way.push((next, left / stays, turned));
                    }
                }
            }
            SurfaceEvent::Film(ray) => each(ray, power, turned),
            SurfaceEvent::Scene | SurfaceEvent::Lost(_) => {}
        }
    }
}
