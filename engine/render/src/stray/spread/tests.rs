use super::*;

/// A Gaussian of that many pixels, of each colour.
struct Gaussian([f32; 3]);

impl Transfer for Gaussian {
    fn change(&self, across: f32, up: &[f32], out: &mut [Mat3]) {
        for (matrix, up) in out.iter_mut().zip(up) {
            let part = |sigma: f32| (-2.0 * (std::f32::consts::PI * sigma).powi(2) * (across * across + up * up)).exp();
            *matrix = Mat3::from_diagonal(Rgb::from(self.0.map(|sigma| part(sigma) - 1.0)));
        }
    }
}

#[test]
fn a_point_becomes_the_kernel() {
    let size = [97, 64];
    let mut picture = vec![Rgb::ZERO; 97 * 64];
    picture[30 * 97 + 40] = Rgb::new(100.0, 50.0, 10.0);
    let sigma = 2.0f32;
    let change = change(&picture, size, &Gaussian([sigma; 3]));
    for y in 0..64 {
        for x in 0..97 {
            let r2 = (x as f32 - 40.0).powi(2) + (y as f32 - 30.0).powi(2);
            let kernel = (-r2 / (2.0 * sigma * sigma)).exp() / (std::f32::consts::TAU * sigma * sigma);
            let found = picture[y * 97 + x] + change[y * 97 + x];
            let truth = kernel * Rgb::new(100.0, 50.0, 10.0);
            // Rounding of sums of f32.
            assert!((found - truth).abs().max_element() < 3e-5, "{x} {y}: {found} {truth}");
        }
    }
}

#[test]
fn an_even_picture_stays_as_it_is_and_an_edge_does_not_come_round() {
    let size = [40, 30];
    let even = vec![Rgb::new(0.25, 0.5, 2.0); 1200];
    for change in change(&even, size, &Gaussian([3.0, 2.0, 1.0])) {
        assert!(change.abs().max_element() < 2e-6, "{change}");
    }
    let mut corner = vec![Rgb::ZERO; 1200];
    corner[0] = Rgb::splat(1e5);
    let change = change(&corner, size, &Gaussian([2.0; 3]));
    assert!(change[39].abs().max_element() < 0.01 && change[29 * 40].abs().max_element() < 0.01);
    assert!(change[1].min_element() > 100.0);
}

#[test]
fn zones_together_are_the_whole() {
    let size = [64, 48];
    let picture: Vec<Rgb> = (0..64 * 48).map(|i| Rgb::splat(((i * 7919) % 97) as f32)).collect();
    let kernel = Gaussian([1.5; 3]);
    let one = change(&picture, size, &kernel);
    let ramp = |i: usize, n: usize| i as f32 / (n - 1) as f32;
    let mut spreading = Spreading::new(&picture, size);
    for k in 0..4 {
        let side = |n: usize, end: bool| (0..n).map(|i| if end { ramp(i, n) } else { 1.0 - ramp(i, n) }).collect();
        spreading.add(&Zone { columns: side(64, k % 2 == 1), rows: side(48, k / 2 == 1), transfer: &kernel });
    }
    let four = spreading.finish();
    assert!(one.iter().zip(&four).all(|(a, b)| (*a - *b).abs().max_element() < 2e-4));
}

/// Pixels that are NaN or infinite change nothing around them.
#[test]
fn one_bad_pixel_stays_one() {
    let size = [16, 16];
    let mut picture = vec![Rgb::ONE; 256];
    picture[100] = Rgb::new(f32::INFINITY, f32::NAN, 1.0);
    let change = change(&picture, size, &Gaussian([1.0; 3]));
    assert!(change.iter().all(|c| c.is_finite()));
}

#[test]
fn as_many_threads_as_you_like_give_the_same_bits() {
    let size = [120, 70];
    let picture: Vec<Rgb> = (0..120 * 70).map(|i| Rgb::splat(((i * 104_729) % 1009) as f32)).collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| change(&picture, size, &Gaussian([1.5, 1.0, 0.5])))
    };
    assert_eq!(with(1), with(3));
}
