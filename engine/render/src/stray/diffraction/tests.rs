use super::*;
use std::f64::consts::PI;

/// A picture with one bright pixel in its middle, spread.
fn starburst(outline: &Outline, spectrum: &FilmSpectrum, pixel_mm: f64, size: [usize; 2]) -> Vec<Rgb> {
    let mut picture = vec![Rgb::ZERO; size[0] * size[1]];
    picture[size[1] / 2 * size[0] + size[0] / 2] = Rgb::ONE;
    let diffraction = Diffraction::of_outlines(vec![outline.clone()], spectrum.clone(), [pixel_mm; 2], size);
    let change = diffraction.change(&picture);
    picture.iter().zip(change).map(|(a, b)| *a + b).collect()
}

fn one(polygon: Vec<glam::DVec2>) -> Outline {
    Outline { polygons: vec![polygon] }
}

/// Pixels an eighth of λ N wide see Airy's pattern, but for the blur by a pixel.
#[test]
fn fine_pixels_see_airys_pattern() {
    let (n, nm) = (16.0, 550.0);
    let lambda_n = nm * 1e-6 * n;
    let size = [129, 129];
    let pixel_mm = lambda_n / 8.0;
    let found = starburst(&one(Outline::regular(0.5 / n, 3000, 0.0)), &FilmSpectrum::single(nm), pixel_mm, size);
    let at = |x: usize| f64::from(found[64 * 129 + 64 + x].y);
    // Density of Airy's pattern: π / 4 (λN)² in its middle.
    let middle = PI / 4.0 / 64.0;
    // The middle pixel keeps what is thrown beyond the picture's edge.
    for x in 1..40 {
        let v = PI * x as f64 / 8.0;
        let bessel =
            (0..400).map(|i| PI * (f64::from(i) + 0.5) / 400.0).map(|t| (t - v * t.sin()).cos()).sum::<f64>() / 400.0;
        let truth = (2.0 * bessel / v).powi(2);
        // The pixel blurs by (π / 8)² / 12 of the curve's bend.
        assert!((at(x) / middle - truth).abs() < 0.02, "{x}: {} {truth}", at(x) / middle);
    }
    // Its first zero: where the amplitude's line through both sides crosses it.
    let dark = (8..12).min_by(|&a, &b| at(a).total_cmp(&at(b))).unwrap() as f64;
    assert!((dark / 8.0 - 1.22).abs() < 0.0625, "{dark}");
    // All light is there, and none is negative.
    let sum: f64 = found.iter().map(|c| f64::from(c.y)).sum();
    assert!((sum - 1.0).abs() < 0.01, "{sum}");
    let least = found.iter().map(|c| c.y).fold(0.0, f32::min);
    assert!(least > -1e-6 * found[64 * 129 + 64].y, "{least}");
}

/// Pixels much larger than the pattern show only its tails: the geometric picture.
#[test]
fn coarse_pixels_see_no_diffraction() {
    let size = [129, 97];
    let lens = one(Outline::regular(0.5 / 1.4, 3000, 0.0));
    let found = starburst(&lens, &FilmSpectrum::visible(), 0.2, size);
    let middle = found[48 * 129 + 64];
    assert!((middle - Rgb::ONE).abs().max_element() < 0.01, "{middle}");
    let nothing = Outline { polygons: vec![Outline::regular(1e3, 64, 0.0)] };
    let same = starburst(&nothing, &FilmSpectrum::visible(), 0.2, size);
    assert!((same[48 * 129 + 64] - Rgb::ONE).abs().max_element() < 1e-5);
}

/// Spikes at right angles to the blades, as many as blades if they are even, else twice as many; thin, and long.
#[test]
fn blades_make_spikes_across_the_frame() {
    let size = [513, 513];
    for blades in [5, 6, 7, 8, 9] {
        let rotation = 0.3;
        let lens = one(Outline::regular(0.5 / 16.0, blades, rotation));
        let found = starburst(&lens, &FilmSpectrum::visible(), 0.0188, size);
        let light = |angle: f64, radius: f64| {
            let [x, y] = [angle.cos(), angle.sin()].map(|c| 256.0 + c * radius);
            f64::from(found[y.round() as usize * 513 + x.round() as usize].y)
        };
        let around: Vec<f64> = (0..1440)
            .map(|i| (100..240).map(|r| light(f64::from(i) * PI / 720.0, f64::from(r))).sum::<f64>())
            .collect();
        let mean = around.iter().sum::<f64>() / 1440.0;
        let peaks: Vec<usize> = (0..1440)
            .filter(|&i| {
                around[i] > 3.0 * mean
                    && (1..20).all(|k| around[i] >= around[(i + k) % 1440] && around[i] > around[(i + 1440 - k) % 1440])
            })
            .collect();
        let expected = if blades % 2 == 0 { blades } else { 2 * blades };
        assert_eq!(peaks.len(), expected, "{blades}: {peaks:?}");
        let (step, edge) = (1440.0 / expected as f64, (rotation + PI / blades as f64) / PI * 720.0);
        for peak in peaks {
            let off = (peak as f64 - edge).rem_euclid(step);
            assert!(off.min(step - off) <= 2.0, "{blades}: {peak} {edge}");
        }
    }
}

/// The spectrum's parts lie at their own distances: a white point's rings are not white, all of its light is.
#[test]
fn red_is_spread_farther_than_blue() {
    let size = [257, 257];
    let found = starburst(&one(Outline::regular(0.5 / 32.0, 6, 0.0)), &FilmSpectrum::visible(), 0.006, size);
    let sum = found.iter().fold(Rgb::ZERO, |a, b| a + *b);
    assert!((sum - Rgb::ONE).abs().max_element() < 0.02, "{sum}");
    let far: Rgb = (0..257 * 257)
        .filter(|i| ((i % 257) as f32 - 128.0).hypot((i / 257) as f32 - 128.0) > 20.0)
        .map(|i| found[i])
        .sum();
    assert!(far.x > 1.2 * far.z && far.z > 0.0, "{far}");
}
