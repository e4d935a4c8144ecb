//! A noisy picture and its denoised one, combined, and the error that is left.

/// Standard deviation of the window's weights, pixels: small enough to follow an edge, large enough to hold many samples of the noise.
const WINDOW: f32 = 1.5;
/// Pixels from the middle of the window to its edge.
const REACH: usize = 4;
/// Factor of the variance. Windows hold few pixels; where the clean picture is right, noise must not be left by chance.
const CAUTION: f32 = 1.25;
/// Times the mean square of the difference about it that a pixel's own may be.
const OUTLIER: f32 = 4.0;
/// Times its variance from which on a pixel's difference is no noise, however few batches told the variance.
const CERTAIN: f32 = 64.0;
/// Squares are limited to this, so that their sums stay finite.
const LARGEST: f32 = 1e30;

/// Restores the features in the clean picture that the denoiser has removed from the noisy one besides noise.
///
/// About each pixel the mean square difference of the pictures is the variance of the noise, v, and the square of the error of the
/// clean picture, b². With Σd² and Σv over a Gaussian window, the part 1 - Σv / Σd² of the noisy picture (here Σv counts 1.25 times) is about
/// the one of least mean square error (the positive-part estimator of James and Stein, "Estimation with quadratic loss", 1961; for a render and its denoised picture:
/// Gu, Iwasaki and Moon, "Neural James-Stein combiner for unbiased and biased renderings", 2022). So a picture with little noise keeps
/// its detail, and with more and more samples the result becomes the noisy picture. Single pixels that differ far more than those about
/// them count, and are taken, as if they differed less, unless their variance says that this is no noise.
///
/// `variance` is that of the noisy pixels, summed over the channels; where it is infinite, or a pixel not finite, the pixel stays as it
/// is clean. All are rows of `width` pixels.
pub fn combine(clean: &mut [[f32; 3]], noisy: &[[f32; 3]], variance: &[f32], width: usize) {
    if clean.len() != noisy.len() {
        return;
    }
    let parts = parts(clean, noisy, variance, width);
    for ((clean, noisy), part) in clean.iter_mut().zip(noisy).zip(parts).filter(|(_, part)| *part > 0.0) {
        clean.iter_mut().zip(noisy).for_each(|(c, n)| *c += part * (n - *c));
    }
}

/// The part of the noisy picture in each pixel of the combination; nothing where the pictures are of other sizes.
fn parts(clean: &[[f32; 3]], noisy: &[[f32; 3]], variance: &[f32], width: usize) -> Vec<f32> {
    if width == 0 || clean.len() != noisy.len() || clean.len() != variance.len() {
        return Vec::new();
    }
    let squares = |(clean, (noisy, variance)): (&[f32; 3], (&[f32; 3], &f32))| {
        let is_known = variance.is_finite() && noisy.iter().chain(clean).all(|part| part.is_finite());
        let square = square_of_difference(clean, noisy);
        if is_known { [square.min(LARGEST), variance.min(LARGEST)] } else { [f32::INFINITY; 2] }
    };
    let known: Vec<[f32; 2]> = clean.iter().zip(noisy.iter().zip(variance)).map(squares).collect();
    let factors = outlier_factors(&known, width);
    let limited: Vec<[f32; 2]> = known.iter().zip(&factors).map(|([d, v], factor)| [d * factor, *v]).collect();
    let part = |([difference, variance], (own, factor)): ([f32; 2], (&[f32; 2], &f32))| {
        // Where nothing differs the part is undefined, and nothing is to be taken.
        let is_known = own[0].is_finite() && difference > 0.0;
        if is_known { (1.0 - CAUTION * variance / difference).max(0.0) * factor.sqrt() } else { 0.0 }
    };
    blurred(&limited, width).into_iter().zip(known.iter().zip(&factors)).map(part).collect()
}

/// Factors of the squares of the difference, at most 1: less for pixels that differ far more than those about them, as
/// long as that may be noise. Few batches of few bright paths tell the variance badly: two of them in different batches of one pixel look like
/// no noise at all. Such a pixel would come back as a speck, and bring the noise of its neighbours with it.
fn outlier_factors(known: &[[f32; 2]], width: usize) -> Vec<f32> {
    let counted: Vec<[f32; 2]> =
        known.iter().map(|own| if own[0].is_finite() { [own[0], 1.0] } else { [f32::INFINITY; 2] }).collect();
    let factor = |([sum, weight], [difference, variance]): ([f32; 2], &[f32; 2])| {
        let others = (sum - difference).max(0.0) / (weight - 1.0).max(1.0);
        let most = (OUTLIER * others).max(difference - CERTAIN * variance);
        if difference.is_finite() && *difference > most { most / difference } else { 1.0 }
    };
    blurred(&counted, width).into_iter().zip(known).map(factor).collect()
}

fn square_of_difference(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Part of the standard deviation by which [`moved`] moves pixels: small against changes that make the filter decide otherwise, large
/// against its rounding.
const STEP: f32 = 0.1;

/// 1 or -1, by the number of a pixel alone.
fn sign(pixel: usize) -> f32 {
    let mut state = pixel as u32 ^ 0x9E37_79B9;
    for factor in [0x85EB_CA6B, 0xC2B2_AE35] {
        state = (state ^ state >> 15).wrapping_mul(factor);
    }
    if state >> 31 == 0 { 1.0 } else { -1.0 }
}

/// The noisy picture with each pixel moved by a tenth of its standard deviation, up or down by chance: the filter's result tells
/// [`remaining`] the part of the noise that the filter lets pass. The variance is summed over the channels.
pub fn moved(noisy: &[[f32; 3]], variance: &[f32]) -> Vec<[f32; 3]> {
    let one = |(i, (pixel, variance)): (usize, (&[f32; 3], &f32))| {
        let step = STEP * (variance / 3.0).sqrt() * sign(i);
        if step.is_finite() { pixel.map(|part| part + step) } else { *pixel }
    };
    noisy.iter().zip(variance).enumerate().map(one).collect()
}

/// The estimated square error of each pixel of [`combine`]'s result, summed over the channels; `clean_moved` is the denoised [`moved`].
///
/// This is Stein's unbiased risk estimate with the divergence found by one perturbation (Ramani, Blu and Unser, "Monte-Carlo SURE", 2008;
/// for renders: Li, Wu and Chuang, "SURE-based optimization for adaptive sampling and reconstruction", 2012). With d the difference of noisy
/// and clean picture, v the variance, g the covariance of the clean pixel and its own noise, and m the noisy picture's part:
/// (1 - m)² d² - v + 2 ((1 - m) g + m v). It is right in the mean over many pixels alone, and may be negative in one; infinite where the
/// variance is.
pub fn remaining(
    noisy: &[[f32; 3]],
    clean: &[[f32; 3]],
    clean_moved: &[[f32; 3]],
    variance: &[f32],
    width: usize,
) -> Vec<f32> {
    let parts = parts(clean, noisy, variance, width);
    let one = |(i, m): (usize, f32)| {
        let v = variance[i];
        let change: f32 = clean_moved[i].iter().zip(&clean[i]).map(|(moved, clean)| moved - clean).sum();
        let covariance = sign(i) * (v / 3.0).sqrt() * change / STEP;
        let error = (1.0 - m) * (1.0 - m) * square_of_difference(&clean[i], &noisy[i]) - v
            + 2.0 * ((1.0 - m) * covariance + m * v);
        if error.is_finite() { error } else { f32::INFINITY }
    };
    parts.into_iter().enumerate().map(one).collect()
}

/// Sums over the window about each pixel; values that are infinite do not count.
fn blurred(values: &[[f32; 2]], width: usize) -> Vec<[f32; 2]> {
    let weights: [f32; 2 * REACH + 1] = std::array::from_fn(|k| {
        let distance = (k as f32 - REACH as f32) / WINDOW;
        (-0.5 * distance * distance).exp()
    });
    let sum = |values: &[[f32; 2]], at: usize, step: usize, place: usize, count: usize| {
        let near = place.saturating_sub(REACH)..(place + REACH + 1).min(count);
        near.fold([0.0; 2], |[a, b], k| {
            let weight = weights[k + REACH - place];
            let [x, y] = values[at + k * step];
            [a + weight * x, b + weight * y]
        })
    };
    let finite: Vec<[f32; 2]> = values.iter().map(|&v| if v[0].is_finite() { v } else { [0.0; 2] }).collect();
    let rows: Vec<[f32; 2]> = (0..finite.len()).map(|i| sum(&finite, i - i % width, 1, i % width, width)).collect();
    (0..rows.len()).map(|i| sum(&rows, i % width, width, i / width, rows.len() / width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of variance 1 that depend on their place alone: the sum of twelve even ones.
    fn noise(i: u32) -> f32 {
        let mut state = i.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
        let mut even = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1u32 << 24) as f32
        };
        (0..12).map(|_| even()).sum::<f32>() - 6.0
    }

    const SIDE: usize = 64;

    /// The mean square error of the combination, and of both pictures, where the clean picture is wrong by `bias`.
    fn errors(bias: f32, sigma: f32) -> [f32; 3] {
        let noisy: Vec<[f32; 3]> =
            (0..(SIDE * SIDE) as u32).map(|i| [0, 1, 2].map(|c| 1.0 + sigma * noise(3 * i + c))).collect();
        let clean = vec![[1.0 + bias; 3]; SIDE * SIDE];
        let mut mixed = clean.clone();
        combine(&mut mixed, &noisy, &vec![3.0 * sigma * sigma; SIDE * SIDE], SIDE);
        [&mixed, &noisy, &clean].map(|picture| {
            let squares = picture.as_flattened().iter().map(|x| (x - 1.0) * (x - 1.0));
            squares.sum::<f32>() / picture.as_flattened().len() as f32
        })
    }

    #[test]
    fn the_better_picture_wins() {
        // The least error of a sum of both is b² s² / (b² + s²).
        for (bias, sigma) in [(0.0, 0.1), (0.3, 0.03), (0.03, 0.3), (0.1, 0.1)] {
            let [mixed, _, clean] = errors(bias, sigma);
            let (b, s) = (bias * bias, sigma * sigma);
            let least = b * s / (b + s);
            assert!(mixed < 1.25 * least + 0.03 * s, "{bias} {sigma}: {mixed}, at least {least}");
            assert!(mixed < clean + 0.03 * s, "{mixed} {clean}");
        }
    }

    /// A linear filter, the mean of three pixels of a row, of a picture with and without structure: the error is known.
    #[test]
    fn the_error_that_is_left_is_known_in_the_mean() {
        let blur = |picture: &[[f32; 3]]| -> Vec<[f32; 3]> {
            let at = |i: usize, c: usize| picture[i.min(SIDE * SIDE - 1)][c];
            (0..SIDE * SIDE)
                .map(|i| [0, 1, 2].map(|c| (at(i.saturating_sub(1), c) + at(i, c) + at(i + 1, c)) / 3.0))
                .collect()
        };
        for (structure, sigma) in [(0.0f32, 0.1), (0.02, 0.1), (0.3, 0.05)] {
            // Stripes of two pixels: the filter takes some of them.
            let truth: Vec<[f32; 3]> =
                (0..SIDE * SIDE).map(|i| [1.0 + if i % 4 < 2 { structure } else { -structure }; 3]).collect();
            let noise_of = |i: usize, c: usize| sigma * noise((3 * i + c) as u32);
            let noisy: Vec<[f32; 3]> =
                truth.iter().enumerate().map(|(i, pixel)| [0, 1, 2].map(|c| pixel[c] + noise_of(i, c))).collect();
            let variance = vec![3.0 * sigma * sigma; SIDE * SIDE];
            let clean = blur(&noisy);
            let told = remaining(&noisy, &clean, &blur(&moved(&noisy, &variance)), &variance, SIDE);
            let mut mixed = clean.clone();
            combine(&mut mixed, &noisy, &variance, SIDE);
            let error: f32 = mixed.iter().zip(&truth).map(|(a, b)| square_of_difference(a, b)).sum();
            let told: f32 = told.iter().sum();
            // 4096 pixels of three channels know the variance to a percent; parts that follow the noise bend it a little.
            let noise = 3.0 * sigma * sigma * (SIDE * SIDE) as f32;
            assert!((told - error).abs() < 0.08 * noise, "{structure} {sigma}: {told} {error} of {noise}");
            assert!(error < 0.6 * noise || structure > 0.1, "{error} {noise}");
        }
        let unknown = remaining(&[[1.0; 3]; 9], &[[1.0; 3]; 9], &[[1.0; 3]; 9], &[f32::INFINITY; 9], 3);
        assert!(unknown.iter().all(|error| *error == f32::INFINITY));
    }

    #[test]
    fn a_spark_stays_out() {
        let mut noisy = vec![[1.0; 3]; SIDE * SIDE];
        let mut variance = vec![0.0; SIDE * SIDE];
        let at = 20 * SIDE + 30;
        // One sample in one of two batches: its part of the mean is known for its own variance.
        (noisy[at], variance[at]) = ([1001.0; 3], 3e6);
        let mut mixed = vec![[1.0; 3]; SIDE * SIDE];
        combine(&mut mixed, &noisy, &variance, SIDE);
        assert!(mixed.as_flattened().iter().all(|x| *x == 1.0));
    }

    /// Two bright paths in different batches of a pixel have no variance to be seen; the part that is surely there comes back.
    #[test]
    fn a_pair_of_sparks_stays_out() {
        let mut noisy: Vec<[f32; 3]> =
            (0..(SIDE * SIDE) as u32).map(|i| [0, 1, 2].map(|c| 1.0 + 0.1 * noise(3 * i + c))).collect();
        let mut variance = vec![0.03; SIDE * SIDE];
        let at = 20 * SIDE + 30;
        let mut with_spark = |told: f32| {
            (noisy[at], variance[at]) = ([1001.0; 3], told);
            let mut mixed = vec![[1.0; 3]; SIDE * SIDE];
            combine(&mut mixed, &noisy, &variance, SIDE);
            [mixed[at][0], mixed[at + 1][0]]
        };
        let [spark, beside] = with_spark(1e5);
        assert!(spark < 1.5 && (beside - 1.0).abs() < 0.05, "{spark} {beside}");
        let [star, _] = with_spark(0.03);
        assert!(star > 1000.0, "{star}");
    }

    #[test]
    fn what_is_not_known_stays_clean() {
        let clean = vec![[2.0; 3]; 9];
        let mut noisy = vec![[1.0; 3]; 9];
        let mut variance = vec![0.0; 9];
        (noisy[1], variance[2], noisy[3][2]) = ([f32::NAN; 3], f32::INFINITY, f32::INFINITY);
        let mut mixed = clean.clone();
        combine(&mut mixed, &noisy, &variance, 3);
        // Without noise all others are as they were.
        let expected: Vec<f32> = (0..9).map(|i| if (1..4).contains(&i) { 2.0 } else { 1.0 }).collect();
        assert_eq!(mixed.iter().map(|pixel| pixel[0]).collect::<Vec<_>>(), expected);
        // Of other sizes nothing is taken.
        combine(&mut mixed, &noisy[1..], &variance, 3);
        combine(&mut [], &[], &[], 0);
        // Extremely bright pixels overflow no sum.
        let mut mixed = vec![[f32::MAX; 3]; 9];
        combine(&mut mixed, &[[0.5; 3]; 9], &[1e-3; 9], 3);
        assert!(mixed.as_flattened().iter().all(|x| x.is_finite()));
    }
}
