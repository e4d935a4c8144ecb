//! Point spread and the transfer of a pupil's shape against closed forms.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use petzval_optics::analysis::Analysis;
use petzval_optics::analysis::psf::{Psf, PsfError};
use petzval_optics::focus::Focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::{Catalogue, line_nm};
use petzval_optics::system::{LensSettings, System};

use crate::common::{prescription, system};

const UP: f64 = FRAC_PI_2;

fn stopped(name: &str, settings: LensSettings) -> System {
    System::new(&prescription(name), &settings).unwrap()
}

fn at_f(name: &str, f_number: f64) -> System {
    stopped(name, LensSettings { f_number: Some(f_number), ..LensSettings::default() })
}

fn at_infinity(system: &System) -> Focus {
    Focus::at_infinity(system, line_nm::D)
}

fn psf(system: &System, defocus_mm: f64) -> Psf {
    let focus = at_infinity(system);
    let film_z_mm = focus.film_z_mm + defocus_mm;
    Analysis::new(system, focus, &[line_nm::D], 0, UP).unwrap().with_film_at(film_z_mm).psf(0.0).unwrap()
}

/// The value along a direction from the middle, by cubics between places (Catmull and Rom).
fn along(psf: &Psf, angle: f64, radius_mm: f64) -> f64 {
    let half = (psf.side / 2) as f64;
    let [x, y] = [angle.cos(), angle.sin()].map(|c| half + c * radius_mm / psf.step_mm);
    let weights = |t: f64| {
        let (t2, t3) = (t * t, t * t * t);
        [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, 0.5 * (t3 - t2)]
    };
    let (wx, wy) = (weights(x.fract()), weights(y.fract()));
    let at = |i: usize, j: usize| psf.values[(y as usize + j - 1) * psf.side + x as usize + i - 1];
    (0..16).map(|k| wx[k % 4] * wy[k / 4] * at(k % 4, k / 4)).sum()
}

/// Bessel's function of the first kind and first order, as its integral: the trapezoid's rule is exact for periodic functions.
fn bessel_j1(x: f64) -> f64 {
    let steps = 400;
    (0..steps).map(|i| PI * (f64::from(i) + 0.5) / f64::from(steps)).map(|t| (t - x * t.sin()).cos()).sum::<f64>()
        / f64::from(steps)
}

/// 2 J₁(x) / x.
fn jinc(x: f64) -> f64 {
    if x.abs() < 1e-9 { 1.0 } else { 2.0 * bessel_j1(x) / x }
}

const STIGMATIC: [(&str, f64); 4] =
    [("newtonian-f5", 5.0), ("newtonian-f5", 22.0), ("plano-hyperbolic-50mm", 8.0), ("plano-hyperbolic-50mm", 22.0)];

#[test]
fn a_stigmatic_lens_has_a_strehl_ratio_of_one_and_airys_pattern() {
    for (name, f_number) in STIGMATIC {
        let system = at_f(name, f_number);
        let found = psf(&system, 0.0);
        assert!((found.strehl[0] - 1.0).abs() < 1e-3, "{name}: {}", found.strehl[0]);
        // sin u' of the beam's edge, where the f-number is that of the tangent or of the sine by 1 / 8 N².
        let airy_mm = 1.219_669_9 * line_nm::D * 1e-6 * system.f_number();
        // The first dark ring, where the line through the amplitudes on both of its sides crosses zero; as Airy's own does.
        let mean = |radius: f64| (0..64).map(|i| along(&found, TAU * f64::from(i) / 64.0, radius)).sum::<f64>() / 64.0;
        let crossing = |[inside, outside]: [f64; 2]| 0.9 + 0.2 * inside / (inside + outside);
        let dark = crossing([0.9, 1.1].map(|part| mean(part * airy_mm).sqrt()));
        let truth = crossing([0.9, 1.1].map(|part| jinc(part * 1.219_669_9 * PI).abs()));
        assert!((dark / truth - 1.0).abs() < 0.01, "{name} at {f_number}: {dark} {truth}");
        // Where the light is: 83.8 % in the first dark ring, 91.0 % in the second (Born and Wolf, section 8.5.2).
        let within = |radius: f64| {
            let i = found.radii_mm.partition_point(|&r| r < radius).min(found.radii_mm.len() - 1);
            let part = (radius - found.radii_mm[i - 1]) / (found.radii_mm[i] - found.radii_mm[i - 1]);
            found.encircled[i - 1] + (found.encircled[i] - found.encircled[i - 1]) * part
        };
        for (rings, truth) in [(1.0, 0.838), (2.233 / 1.2197, 0.910), (3.238 / 1.2197, 0.938)] {
            let got = within(rings * airy_mm);
            assert!((got - truth).abs() < 4e-3, "{name} at {f_number}, {rings}: {got} {truth}");
        }
        // The pattern itself.
        for i in 0..40 {
            let radius = f64::from(i) * 0.05 * airy_mm;
            let truth = jinc(PI * radius / (line_nm::D * 1e-6 * system.f_number())).powi(2);
            // Cubics between places a quarter of λ N apart.
            assert!((mean(radius) - truth).abs() < 0.015, "{name} {i}: {} {truth}", mean(radius));
        }
    }
}

/// A ring: (J(x) − ε² J(ε x))² / (1 − ε²)², J = 2 J₁(x) / x.
#[test]
fn a_mirror_with_an_obstruction_makes_the_rings_of_an_annulus() {
    let text = "#radius thickness glass diameter conic isstop obstruction\n-2000 -1000 mirror 100 -1 1 50";
    let system =
        System::new(&lens::parse(text, "test", Catalogue::shipped()).unwrap(), &LensSettings::default()).unwrap();
    let found = psf(&system, 0.0);
    assert!((found.strehl[0] - 1.0).abs() < 1e-3);
    let lambda_n = line_nm::D * 1e-6 * system.f_number();
    for i in 0..60 {
        let radius = f64::from(i) * 0.05 * lambda_n;
        let x = PI * radius / lambda_n;
        let truth = ((jinc(x) - 0.25 * jinc(0.5 * x)) / 0.75).powi(2);
        let mean = (0..64).map(|i| along(&found, TAU * f64::from(i) / 64.0, radius)).sum::<f64>() / 64.0;
        assert!((mean - truth).abs() < 0.015, "{i}: {mean} {truth}");
    }
}

/// Defocus by W₂₀ waves leaves (sin πW / πW)² in the middle (Born and Wolf, section 8.8.2).
#[test]
fn strehl_ratios_out_of_focus_are_those_of_born_and_wolf() {
    let n = 8.0;
    let system = at_f("newtonian-f5", n);
    for waves in [0.1, 0.25, 0.4] {
        let found = psf(&system, 8.0 * n * n * waves * line_nm::D * 1e-6);
        let truth = ((PI * waves).sin() / (PI * waves)).powi(2);
        // The path goes by the sine, not by the tangent: (1 / 2N)² of it.
        assert!((found.strehl[0] - truth).abs() < 5e-3, "{waves}: {} {truth}", found.strehl[0]);
    }
}

/// The modulus of the point spread's spectrum is the transfer function.
#[test]
fn point_spread_and_transfer_function_are_one() {
    for (name, f_number) in [("double-gauss-f2-available", 5.6), ("cooke-triplet-50mm", 22.0)] {
        let system = at_f(name, f_number);
        let analysis = Analysis::new(&system, at_infinity(&system), &[line_nm::D], 0, UP).unwrap();
        let field = 5.0;
        let psf = analysis.psf(field).unwrap();
        let step = 0.1 / (line_nm::D * 1e-6 * f_number);
        let mtf = analysis.mtf(field, step, 9).unwrap();
        let spectrum = |along_y: bool, frequency: f64| {
            let (mut re, mut im, mut sum) = (0.0, 0.0, 0.0);
            for (i, value) in psf.values.iter().enumerate() {
                let at = if along_y { i / psf.side } else { i % psf.side } as f64 * psf.step_mm;
                let (s, c) = (TAU * frequency * at).sin_cos();
                (re, im, sum) = (re + value * c, im + value * s, sum + value);
            }
            f64::hypot(re, im) / sum
        };
        for i in 1..9 {
            let frequency = step * f64::from(i);
            // The picture ends where a few per cent of the light lie outside.
            let [x, y] = [spectrum(false, frequency), spectrum(true, frequency)];
            let i = i as usize;
            assert!((x - mtf.sagittal.contrast[i]).abs() < 0.04, "{name} {i}: {x} {}", mtf.sagittal.contrast[i]);
            assert!((y - mtf.tangential.contrast[i]).abs() < 0.04, "{name} {i}: {y} {}", mtf.tangential.contrast[i]);
        }
    }
}

/// Straight blades diffract light at right angles to their edges, to both sides: as many spikes as blades if these are even, else twice as
/// many.
#[test]
fn blades_make_spikes_at_right_angles_to_their_edges() {
    for blades in [5, 6, 7, 8] {
        let rotation = 0.2;
        let settings =
            LensSettings { f_number: Some(22.0), blades, blade_rotation_rad: rotation, ..LensSettings::default() };
        let system = stopped("plano-hyperbolic-50mm", settings);
        let found = psf(&system, 0.0);
        let lambda_n = line_nm::D * 1e-6 * system.f_number();
        // Light at 11 to 15.5 λ N by angle, in half degrees.
        let light: Vec<f64> = (0..720)
            .map(|i| {
                let angle = f64::from(i) * 0.5f64.to_radians();
                (0..60).map(|k| along(&found, angle, (11.0 + 4.5 * f64::from(k) / 60.0) * lambda_n)).sum()
            })
            .collect();
        let mean = light.iter().sum::<f64>() / 720.0;
        let largest =
            |i: usize| (0..=10).all(|k| light[i] >= light[(i + k) % 720] && light[i] >= light[(i + 720 - k) % 720]);
        let spikes: Vec<f64> =
            (0..720).filter(|&i| light[i] > 2.0 * mean && largest(i)).map(|i| i as f64 * 0.5).collect();
        let expected = if blades % 2 == 0 { blades } else { 2 * blades };
        assert_eq!(spikes.len(), expected as usize, "{blades}: {spikes:?}");
        // The reference's film is looked at from behind: sagittal is right, tangential up, and the stop's corner lies at the rotation.
        let step = 360.0 / f64::from(expected);
        let edge = (rotation + PI / f64::from(blades)).to_degrees();
        for spike in &spikes {
            let off = (spike - edge).rem_euclid(step);
            assert!(off.min(step - off) < 1.0, "{blades}: {spikes:?} {edge}");
        }
    }
}

#[test]
fn what_is_dark_or_spread_too_far_is_named() {
    let system = system("double-gauss-f1.35");
    let analysis = Analysis::new(&system, at_infinity(&system), &[line_nm::D], 0, UP).unwrap();
    assert_eq!(analysis.psf(70.0), Err(PsfError::Dark));
    let film_z_mm = analysis.film().z_mm + 2.0;
    assert!(matches!(analysis.with_film_at(film_z_mm).psf(0.0), Err(PsfError::TooWide { .. })));
}
