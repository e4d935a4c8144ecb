//! Every transform beside the sum that defines it.

use std::f64::consts::TAU;

use petzval_fourier::{Complex, Direction, complex_f32, complex_f64, real_back_f32, real_f32};

/// One frequency by the definition of the discrete Fourier transform.
fn sum(values: &[f64], k: usize, sign: f64) -> Complex<f64> {
    let turn = |n: usize| sign * TAU * (n * k % values.len()) as f64 / values.len() as f64;
    values.iter().enumerate().map(|(n, x)| Complex::from_polar(*x, turn(n))).sum()
}

fn values(length: usize) -> Vec<f64> {
    (0..length).map(|n| ((n * n * 7 + 3 * n) % 23) as f64 - 9.0).collect()
}

/// The tolerance is the rounding of 60 terms below 14, with a factor of 2 to 10 for the order of summation.
#[test]
fn each_is_the_sum_of_its_definition() {
    let values = values(60);
    for (direction, sign) in [(Direction::Forward, -1.0), (Direction::Back, 1.0)] {
        let mut exact: Vec<_> = values.iter().map(|x| Complex::new(*x, 0.0)).collect();
        complex_f64(60, direction).process(&mut exact);
        let mut single: Vec<_> = values.iter().map(|x| Complex::new(*x as f32, 0.0)).collect();
        complex_f32(60, direction).process(&mut single);
        for (k, (exact, single)) in exact.iter().zip(&single).enumerate() {
            let truth = sum(&values, k, sign);
            assert!((exact - truth).norm() < 1e-11, "{k}: {exact} is not {truth}");
            let single = Complex::new(f64::from(single.re), f64::from(single.im));
            assert!((single - truth).norm() < 1e-3, "{k}: {single} is not {truth}");
        }
    }
}

#[test]
fn real_values_give_half_of_the_same_and_come_back() {
    let values = values(60);
    let forward = real_f32(60);
    let mut row: Vec<f32> = values.iter().map(|x| *x as f32).collect();
    let mut spectrum = forward.make_output_vec();
    assert!(forward.process(&mut row, &mut spectrum).is_ok());
    assert_eq!(spectrum.len(), 31);
    for (k, found) in spectrum.iter().enumerate() {
        let truth = sum(&values, k, -1.0);
        assert!((f64::from(found.re) - truth.re).hypot(f64::from(found.im) - truth.im) < 1e-3, "{k}");
    }
    assert!(real_back_f32(60).process(&mut spectrum, &mut row).is_ok());
    for (found, value) in row.iter().zip(&values) {
        assert!((f64::from(*found) / 60.0 - value).abs() < 1e-5, "{found} is not 60 times {value}");
    }
}
