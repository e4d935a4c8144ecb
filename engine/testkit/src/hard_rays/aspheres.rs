//! Rays at surfaces that only an iteration hits, aimed so that no crossing but one can be meant.

use super::aim::{Place, is_crossed_once};
use super::dice::Dice;
use crate::exact::{Case, Profile, Shape};

/// Draws before a ray along the axis is taken instead, which crosses everything once.
const DRAWS: u32 = 100;

/// An asphere whose terms add up to at most `departure` half diameters.
pub(super) fn asphere(dice: &mut Dice, departure: f64) -> Case {
    let semi = dice.log_between(1.0, 50.0);
    let profile = profile(dice, semi, departure);
    crossed_once(dice, Shape::Asphere(profile), semi)
}

pub(super) fn toroid(dice: &mut Dice) -> Case {
    let semi = dice.log_between(1.0, 50.0);
    let profile = cross_section(dice, semi);
    let curvature_x = dice.sign() / (semi * dice.log_between(1.5, 30.0));
    crossed_once(dice, Shape::Toroid { profile, curvature_x }, semi)
}

pub(super) fn cylinder(dice: &mut Dice) -> Case {
    let semi = dice.log_between(1.0, 50.0);
    let shape = if dice.one_in(2) {
        Shape::Toroid { profile: cross_section(dice, semi), curvature_x: 0.0 }
    } else {
        Shape::Toroid { profile: Profile::default(), curvature_x: dice.sign() / (semi * dice.log_between(1.5, 30.0)) }
    };
    crossed_once(dice, shape, semi)
}

/// One in three with terms.
fn cross_section(dice: &mut Dice, semi_mm: f64) -> Profile {
    let profile = profile(dice, semi_mm, 0.05);
    if dice.one_in(3) { profile } else { Profile { terms: Vec::new(), ..profile } }
}

fn profile(dice: &mut Dice, semi_mm: f64, departure: f64) -> Profile {
    let radius = semi_mm * dice.log_between(1.5, 30.0);
    let conic = if dice.one_in(3) { 0.0 } else { dice.between(-3.0, 0.4) };
    let last = 4 + 2 * dice.below(9) as u32;
    // Odd powers are rare in lenses, too.
    let step = if dice.one_in(8) { 1 } else { 2 };
    let powers = (if step == 1 { 3 } else { 4 }..=last).step_by(step);
    let count = powers.clone().count() as f64;
    let terms = powers
        .map(|power| {
            let height = dice.between(-1.0, 1.0) * departure * semi_mm / count;
            // A quotient a power is the same on every machine, as `powi` need not be.
            (power, (0..power).fold(height, |a, _| a / semi_mm))
        })
        .collect();
    let curvature = if dice.one_in(10) { 0.0 } else { dice.sign() / radius };
    Profile { curvature, conic, terms }
}

fn crossed_once(dice: &mut Dice, shape: Shape, semi_mm: f64) -> Case {
    let side = dice.sign();
    let glass = dice.between(1.4, 1.95);
    let (n1, n2) = if dice.one_in(3) { (glass, 1.0) } else { (1.0, glass) };
    let is_mirror = dice.one_in(8);
    let finish = |case: Case| Case {
        semi_diameter: Some(semi_mm),
        n1,
        n2: if is_mirror { n1 } else { n2 },
        mirror: is_mirror,
        ..case
    };
    for _ in 0..DRAWS {
        let [x, y] = dice.in_disc().map(|x| x * 1.05 * semi_mm);
        let Some(place) = Place::on(shape.clone(), x, y) else { continue };
        let distance = dice.log_between(1e-2, 10.0) * semi_mm;
        let cosine = dice.between(0.3, 1.0);
        let case = place.ray(dice, cosine, side, distance);
        if is_crossed_once(&case, distance, 1.3 * semi_mm, 3.0 * semi_mm) {
            return finish(case);
        }
    }
    let place = Place::on(shape, 0.0, 0.0).expect("every surface has a vertex");
    finish(place.ray_along([0.0, 0.0, side], side, semi_mm))
}
