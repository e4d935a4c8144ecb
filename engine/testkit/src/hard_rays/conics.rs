//! Hard rays at planes and conics.

use super::aim::{Place, dot, plus_times, reach, unit};
use super::dice::Dice;
use crate::exact::{Case, Shape};

/// The smallest relative nearness to a border: a few roundings.
const NEAREST: f64 = 1e-15;

/// Offsets from a border, of both signs.
fn nearness(dice: &mut Dice, farthest: f64) -> f64 {
    dice.log_between(NEAREST, farthest) * dice.sign()
}

/// Air and a glass; out of the glass less often, as many of those rays are lost.
fn media(dice: &mut Dice, case: Case) -> Case {
    let glass = dice.between(1.4, 1.95);
    let (n1, n2) = if dice.one_in(3) { (glass, 1.0) } else { (1.0, glass) };
    Case { n1, n2, ..case }
}

/// Conic constants as lenses have them: spheres, every kind of conic, paraboloids.
fn usual_conic(dice: &mut Dice) -> f64 {
    match dice.below(4) {
        0 => 0.0,
        1 => -1.0,
        2 => dice.between(-1.0, 1.0),
        _ => dice.between(-4.0, 0.0),
    }
}

/// A conic of the size `radius_mm`, in either orientation, and a place within `part` of the radius where it is steep.
fn usual_place(dice: &mut Dice, radius_mm: f64, part: f64) -> Place {
    let (c, k) = (dice.sign() / radius_mm, usual_conic(dice));
    let widest = reach(c, k).min(radius_mm) * part;
    let r = widest * dice.part().sqrt();
    Place::on_conic(c, k, r, dice.angle())
}

pub(super) fn ordinary(dice: &mut Dice) -> Case {
    let radius = dice.log_between(10.0, 200.0);
    let (c, k) = (dice.sign() / radius, usual_conic(dice));
    let semi = reach(c, k).min(radius) * dice.between(0.2, 0.7);
    let r = semi * 1.05 * dice.part().sqrt();
    let place = Place::on_conic(c, k, r, dice.angle());
    let [x, y] = dice.in_disc().map(|x| 0.6 * x);
    let direction = [x, y, (1.0 - x * x - y * y).sqrt()];
    let distance = dice.log_between(0.1, 300.0);
    let case = media(dice, place.ray_along(direction, 1.0, distance));
    let obstruction = if dice.one_in(8) { 0.3 * semi } else { 0.0 };
    Case { semi_diameter: Some(semi), obstruction, ..case }
}

pub(super) fn near_critical(dice: &mut Dice) -> Case {
    let radius = dice.log_between(3.0, 1e4);
    let place = if dice.one_in(3) {
        let [x, y] = dice.in_disc().map(|x| x * radius);
        Place::on(Shape::Conic { curvature: 0.0, conic: 0.0 }, x, y).expect("a plane has no end")
    } else {
        usual_place(dice, radius, 0.9)
    };
    let n2 = if dice.one_in(2) { 1.0 } else { dice.between(1.0, 1.6) };
    let n1 = n2 * (1.0 + dice.log_between(1e-4, 0.9));
    // Clear of 1, beyond which there is no angle.
    let sine = (n2 / n1 * (1.0 + nearness(dice, 0.1))).min(1.0 - 1e-12);
    let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
    let side = dice.sign();
    let distance = dice.log_between(1e-3, 10.0) * radius.min(100.0);
    Case { n1, n2, ..place.ray(dice, cosine, side, distance) }
}

pub(super) fn tangent(dice: &mut Dice) -> Case {
    let radius = dice.log_between(1.0, 1e3);
    let k = if dice.one_in(2) { 0.0 } else { dice.between(-0.9, 2.0) };
    let c = dice.sign() / radius;
    let r = reach(c, k) * dice.between(0.2, 0.999);
    let mut place = Place::on_conic(c, k, r, dice.angle());
    let direction = place.tangent(dice);
    // Towards the centre the ray goes through, away from it the ray passes by.
    let inwards = nearness(dice, 0.1) * radius * c.signum();
    place.point = plus_times(place.point, place.normal, inwards);
    let side = dice.sign();
    let distance = dice.log_between(0.1, 100.0) * radius;
    media(dice, place.ray_along(direction, side, distance))
}

pub(super) fn no_leading_term(dice: &mut Dice) -> Case {
    let radius = dice.log_between(1.0, 1e4);
    let c = dice.sign() / radius;
    let off = if dice.one_in(16) { 0.0 } else { nearness(dice, 0.1) };
    let [cos, sin] = dice.angle();
    let up = dice.sign();
    let (k, direction) = match dice.below(3) {
        0 => (-1.0, [off * cos, off * sin, up]),
        1 => (-1.0 + off, [0.0, 0.0, up]),
        _ => {
            let k = -dice.log_between(1.1, 10.0);
            let z = (-1.0 / k).sqrt() * (1.0 + off);
            let across = (1.0 - z * z).max(0.0).sqrt();
            (k, [across * cos, across * sin, z * up])
        }
    };
    let widest = reach(c, k).min(radius);
    let r = widest * 0.9 * dice.part().sqrt();
    let place = Place::on_conic(c, k, r, dice.angle());
    let meant = if dot(place.normal, direction) < 0.0 { -1.0 } else { 1.0 };
    let side = if dice.one_in(4) { -meant } else { meant };
    let distance = dice.log_between(1e-2, 10.0) * radius;
    let case = place.ray_along(direction, side, distance);
    if dice.one_in(4) { Case { mirror: true, n2: 1.0, ..case } } else { media(dice, case) }
}

pub(super) fn far_sheet(dice: &mut Dice) -> Case {
    let radius = dice.log_between(1.0, 1e3);
    let c = dice.sign() / radius;
    let k = if dice.one_in(2) { -dice.log_between(1.05, 20.0) } else { dice.between(-0.9, 5.0) };
    let r = reach(c, k).min(3.0 * radius) * 0.95 * dice.part().sqrt();
    let mut place = Place::on_conic(c, k, r, dice.angle());
    // Mirrored in the conic's centre plane.
    place.point[2] = 2.0 / ((1.0 + k) * c) - place.point[2];
    place.normal[2] = -place.normal[2];
    if dice.one_in(8) {
        // Anywhere near, to miss it now and then.
        let away = dice.log_between(1e-2, 3.0) * radius;
        place.point = plus_times(place.point, dice.direction(), away);
    }
    let direction = dice.direction();
    let there = if dot(place.normal, direction) < 0.0 { -1.0 } else { 1.0 };
    // Half of them mean the other crossing, which may be the one on the vertex sheet.
    let side = there * dice.sign();
    let distance = dice.log_between(0.1, 10.0) * radius;
    media(dice, place.ray_along(direction, side, distance))
}

/// A usual ray to a place: any incidence but grazing, either way.
fn usual_ray(dice: &mut Dice, place: Place, size_mm: f64) -> Case {
    let (cosine, side) = (dice.between(0.15, 1.0), dice.sign());
    let distance = dice.log_between(1e-2, 10.0) * size_mm;
    let case = place.ray(dice, cosine, side, distance);
    media(dice, case)
}

pub(super) fn conic_constant(dice: &mut Dice) -> Case {
    let radius = dice.log_between(1.0, 1e4);
    let (c, k) = (dice.sign() / radius, dice.sign() * dice.log_between(1e-3, 1e6));
    let r = reach(c, k).min(radius) * dice.log_between(1e-3, 0.95);
    let place = Place::on_conic(c, k, r, dice.angle());
    usual_ray(dice, place, radius)
}

pub(super) fn radius(dice: &mut Dice) -> Case {
    let radius = dice.log_between(1e-3, 1e15);
    let (c, k) = (dice.sign() / radius, usual_conic(dice));
    let r = (reach(c, k) * 0.9).min(radius * 0.9).min(50.0) * dice.part().sqrt();
    let place = Place::on_conic(c, k, r, dice.angle());
    usual_ray(dice, place, radius.min(100.0))
}

pub(super) fn far_start(dice: &mut Dice) -> Case {
    let radius = dice.log_between(5.0, 500.0);
    let place = usual_place(dice, radius, 0.8);
    let (cosine, side) = (dice.between(0.2, 1.0), dice.sign());
    let distance = if dice.one_in(16) { 0.0 } else { dice.log_between(1e-3, 1e10) };
    let case = place.ray(dice, cosine, side, distance);
    media(dice, case)
}

pub(super) fn near_index(dice: &mut Dice) -> Case {
    let radius = dice.log_between(5.0, 500.0);
    let place = usual_place(dice, radius, 0.9);
    let (cosine, side) = (dice.log_between(1e-3, 1.0), dice.sign());
    let distance = dice.log_between(0.1, 10.0) * radius;
    let n1 = dice.between(1.0, 2.0);
    let n2 = n1 * (1.0 + nearness(dice, 0.1));
    Case { n1, n2, ..place.ray(dice, cosine, side, distance) }
}

/// A lens surface of a radius in this range, with a rim.
pub(super) fn of_size(dice: &mut Dice, smallest_mm: f64, largest_mm: f64) -> Case {
    let radius = dice.log_between(smallest_mm, largest_mm);
    let place = usual_place(dice, radius, 0.8);
    let case = usual_ray(dice, place, radius);
    let case = if dice.one_in(4) { Case { mirror: true, n2: case.n1, ..case } } else { case };
    Case { semi_diameter: Some(radius * 0.7), ..case }
}

pub(super) fn mirror(dice: &mut Dice) -> Case {
    let radius = dice.log_between(10.0, 1e4);
    let place = usual_place(dice, radius, 0.9);
    let (cosine, side) = (dice.log_between(1e-3, 1.0), dice.sign());
    let distance = dice.log_between(1e-2, 10.0) * radius;
    let n = if dice.one_in(4) { dice.between(1.4, 1.9) } else { 1.0 };
    let case = Case { mirror: true, n1: n, n2: n, ..place.ray(dice, cosine, side, distance) };
    let semi = radius * 0.8;
    let obstruction = if dice.one_in(2) { 0.2 * semi } else { 0.0 };
    Case { semi_diameter: Some(semi), obstruction, ..case }
}

pub(super) fn ball_rear(dice: &mut Dice) -> Case {
    let radius = dice.log_between(0.1, 100.0);
    // Seen from the film's side, the same ball turned about.
    let side = dice.sign();
    let c = -side / radius;
    let rear = Place::on_conic(c, 0.0, radius * 0.95 * dice.part().sqrt(), dice.angle());
    let front = Place::on_conic(c, 0.0, radius * 0.95 * dice.part().sqrt(), dice.angle()).point;
    let origin = [front[0], front[1], 2.0 / c - front[2]];
    let direction = unit(plus_times(rear.point, origin, -1.0));
    let n1 = dice.between(1.4, 1.9);
    let case = Case { origin, n1, n2: 1.0, ..rear.ray_along(direction, side, 0.0) };
    // Along a diameter the other form of the root is 0 / 0.
    if dice.one_in(8) { Case { origin: [0.0, 0.0, 2.0 / c], direction: [0.0, 0.0, side], ..case } } else { case }
}

pub(super) fn on_surface(dice: &mut Dice) -> Case {
    let radius = dice.log_between(1.0, 1e3);
    let place = usual_place(dice, radius, 0.9);
    let (cosine, side) = (dice.log_between(1e-2, 1.0), dice.sign());
    let distance = if dice.one_in(2) { 0.0 } else { nearness(dice, 1e-6) * radius };
    let case = place.ray(dice, cosine, side, distance);
    let case = media(dice, case);
    if dice.one_in(8) && case.direction[2] * side > 0.0 { Case { origin: [0.0; 3], ..case } } else { case }
}

pub(super) fn rim(dice: &mut Dice) -> Case {
    let radius = dice.log_between(5.0, 500.0);
    let off = dice.log_between(NEAREST, 1e-3);
    let near = 1.0 + off * dice.sign();
    match dice.below(4) {
        0 => {
            // The end of the conic itself, where it stands upright.
            let (c, k) = (dice.sign() / radius, dice.between(-0.9, 2.0));
            let place = Place::on_conic(c, k, reach(c, k) * (1.0 - off), dice.angle());
            usual_ray(dice, place, radius)
        }
        kind => {
            let place = usual_place(dice, radius, 0.9);
            let [x, y, _] = place.point;
            let r = (x * x + y * y).sqrt() * near;
            let case = usual_ray(dice, place, radius);
            if kind == 1 { Case { obstruction: r, ..case } } else { Case { semi_diameter: Some(r), ..case } }
        }
    }
}

pub(super) fn backward(dice: &mut Dice) -> Case {
    let radius = dice.log_between(5.0, 500.0);
    let place = usual_place(dice, radius, 0.6);
    let distance = dice.log_between(0.01, 10.0) * radius;
    let [x, y] = dice.in_disc().map(|x| 0.5 * x);
    let direction = [x, y, -(1.0 - x * x - y * y).sqrt()];
    let case = place.ray_along(direction, -1.0, distance);
    Case { semi_diameter: Some(radius * 0.55), ..media(dice, case) }
}

pub(super) fn beyond_right_angle(dice: &mut Dice) -> Case {
    let radius = dice.log_between(5.0, 500.0);
    let (c, k) = (1.0 / radius, dice.between(-0.5, 0.5));
    let r = reach(c, k) * dice.between(0.3, 0.98);
    let [cos, sin] = dice.angle();
    let place = Place::on_conic(c, k, r, [cos, sin]);
    // Inwards from the side; down to the slope of the surface there the right side is hit.
    let steepest = (1.0 - place.normal[2] * place.normal[2]).sqrt();
    let z = -steepest * dice.log_between(1e-6, 0.99);
    let across = (1.0 - z * z).sqrt();
    let turn = dice.between(-0.1, 0.1);
    let direction = [-across * (cos - turn * sin), -across * (sin + turn * cos), z];
    let distance = dice.log_between(0.1, 30.0) * radius;
    let case = place.ray_along(direction, 1.0, distance);
    Case { semi_diameter: Some(radius * 0.9), ..media(dice, case) }
}
