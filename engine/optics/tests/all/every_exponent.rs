//! Single surfaces given numbers of every exponent, and no numbers: a finite result or a named reason, and no panic.

use glam::DVec3;
use petzval_optics::single_surface::SingleSurface;
use petzval_optics::surface::{Asphere, Conic, Shape, Toroid};
use proptest::prelude::*;

/// The numbers of a ray and a surface: origin, direction, curvature, conic constant, indices before and after, semi-diameter,
/// obstruction, an aspheric coefficient, curvature in the x-z plane.
type Inputs = [f64; 14];

const BASES: [Inputs; 5] = [
    // A sphere, a plane out of the denser medium, a paraboloid, an eccentric hyperboloid from behind, an ellipsoid grazed.
    [1.0, -2.0, -3.0, 0.1, 0.2, 0.97, 0.02, 0.0, 1.0, 1.5, 30.0, 0.0, 1e-7, 0.02],
    [1.0, -2.0, -3.0, 0.5, 0.0, 0.85, 0.0, 0.0, 1.9, 1.0, 30.0, 0.0, 0.0, 0.0],
    [4.0, 1.0, -8.0, 0.0, 0.0, 1.0, -0.05, -1.0, 1.3, 1.6, 30.0, 1.0, 1e-5, 0.03],
    [0.5, 0.5, 9.0, 0.1, -0.1, -0.98, 0.1, -40.0, 1.6, 1.5, 9.0, 0.0, 1e-4, -0.1],
    [0.0, 0.0, 10.0, 0.0, 1.0, 0.01, 0.1, 0.7, 1.0, 1.8, 12.0, 0.0, 0.0, 0.1],
];

/// The trace of the inputs by every shape, from both sides, refracted and reflected, in f64 and in f32: an error names the first result that
/// is neither finite nor a reason.
fn trace_all(inputs: &Inputs) -> Result<(), String> {
    let [x, y, z, dx, dy, dz, curvature, conic, from, to, semi_diameter_mm, obstruction_mm, term, across] = *inputs;
    let (origin, direction) = (DVec3::new(x, y, z), DVec3::new(dx, dy, dz));
    let base = Conic { curvature, conic };
    let profile = Asphere::new(base, &[(4, term), (6, term * term)]);
    for shape in [Shape::Conic(base), Shape::Asphere(profile), Shape::Toroid(Toroid { profile, across })] {
        for (side, is_mirror) in [(1.0, false), (-1.0, false), (1.0, true), (-1.0, true)] {
            let surface = SingleSurface { shape, side, from, to, is_mirror, semi_diameter_mm, obstruction_mm };
            for outcome in [surface.trace::<f64>(origin, direction), surface.trace::<f32>(origin, direction)] {
                let is_hit_finite = outcome
                    .hit
                    .is_none_or(|hit| hit.t_mm.is_finite() && hit.point.is_finite() && hit.normal.is_finite());
                let is_direction_finite = outcome.direction.is_err() || outcome.direction.is_ok_and(DVec3::is_finite);
                // A direction has its hit.
                let is_whole = outcome.direction.is_err() || outcome.hit.is_some();
                if !(is_hit_finite && is_direction_finite && is_whole) {
                    return Err(format!("{surface:?} {origin} {direction}: {outcome:?}"));
                }
            }
        }
    }
    Ok(())
}

/// The numbers of one exponent of f64 (from -1074: subnormals have the lowest ones) of both signs: the power of two and one near the next.
fn of_exponent(exponent: i32) -> [f64; 4] {
    let power = 2f64.powi(exponent.max(-1000)) * 2f64.powi(exponent.min(-1000) + 1000);
    let below_the_next = power * (2.0 - f64::EPSILON);
    let largest = if below_the_next.is_finite() { below_the_next } else { f64::MAX };
    [power, -power, largest, -largest]
}

const SPECIAL: [f64; 9] =
    [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324];

/// A direction's numbers are tried with the direction as it is, so of all lengths.
#[test]
fn every_exponent_of_every_number() {
    // The exponents of f32 are among those of f64; a number beyond them is infinite or 0 there.
    for base in BASES {
        for place in 0..base.len() {
            for number in (-1074..=1023).flat_map(of_exponent).chain(SPECIAL) {
                let mut inputs = base;
                inputs[place] = number;
                if let Err(why) = trace_all(&inputs) {
                    panic!("number {place} = {number:e}: {why}");
                }
            }
        }
    }
}

/// Every number of f32 by its bits, and every number of f64.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        any::<u32>().prop_map(|bits| f64::from(f32::from_bits(bits))),
        prop::sample::select(&SPECIAL[..]),
        -10.0..10.0f64,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    /// All numbers at once.
    #[test]
    fn any_bits_at_all(inputs in prop::array::uniform14(any_number())) {
        prop_assert!(trace_all(&inputs).is_ok(), "{}", trace_all(&inputs).unwrap_err());
    }

    /// Two of a sound case's numbers.
    #[test]
    fn any_two_numbers(
        base in prop::sample::select(&BASES[..]),
        first in (0usize..14, any_number()),
        second in (0usize..14, any_number()),
    ) {
        let mut inputs = base;
        (inputs[first.0], inputs[second.0]) = (first.1, second.1);
        prop_assert!(trace_all(&inputs).is_ok(), "{}", trace_all(&inputs).unwrap_err());
    }
}
