//! The quick method for all ghosts against rays that are reflected at random.

use super::beam::{Beam, Source};
use super::brute;
use super::packet::{GhostTracer, Grid};
use super::power;
use crate::coating::Coating;
use crate::focus::{FilmFrame, FilmPlane};
use crate::formats::lens;
use crate::glass::Catalogue;
use crate::system::{LensSettings, System};
use glam::{DVec2, DVec3};

const TRIPLET: &str = "40.1 6 SK4 34 0 0\n-537 10 air 34 0 0\n-47 1 SF2 26 0 0\n40 1 air 26 0 0\n0 9.8 air 25 0 1\n234.5 6 SK4 28 0 0\n-37.9 85 air 28 0 0";
const LINE_NM: f64 = 550.0;

fn system(coating: &str, settings: &LensSettings) -> System {
    let lens = lens::parse(TRIPLET, "test.lens", Catalogue::shipped()).unwrap();
    System::new(&lens, settings).unwrap().coated(&Coating::parse(coating).unwrap())
}

/// Numbers from 0 to 1 by Weyl's sequences, hashed (splitmix64).
fn randoms(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn film(system: &System) -> FilmFrame {
    FilmPlane::upright(system.film_z_published_mm()).frame()
}

fn is_film(at: DVec2) -> bool {
    at.x.abs() <= 18.0 && at.y.abs() <= 12.0
}

/// The light on the film that was reflected so often, by pieces.
fn by_pieces(system: &System, beam: &Beam, reflections: usize, side: usize) -> f64 {
    let (tracer, film) = (system.at_wavelength(LINE_NM), film(system));
    let mut sum = 0.0;
    for turns in system.reflecting_paths(LINE_NM, reflections) {
        let path = GhostTracer::new(&tracer, &turns).unwrap();
        let mut bundle = path.bundle();
        let Some(window) = path.window(beam, &film, 0.2, &mut bundle) else { continue };
        path.pieces(
            system,
            (beam, &film),
            Grid { window: &window, side, is_coarse: false },
            &mut bundle,
            &mut |piece| {
                // Pieces are small: by their middles.
                let middle = piece.corners.iter().sum::<DVec2>() / 3.0;
                sum += if is_film(middle) { piece.light_mm2 } else { 0.0 };
            },
        );
    }
    sum
}

fn agree(system: &System, source: Source) {
    let beam = Beam::new(system, source).unwrap();
    let tracer = system.at_wavelength(LINE_NM);
    let found = brute::arrived(system, &tracer, &beam, &film(system), is_film, 50_000, randoms(1));
    // A hundredth, and what chance may do; four reflections have a hundredth of the light of two.
    for (reflections, side, part) in [(2, 64, 0.01), (4, 24, 0.03)] {
        let (expected, error) = (found.light_mm2[reflections], found.error_mm2[reflections]);
        let quick = by_pieces(system, &beam, reflections, side);
        println!("{source:?}, {reflections}: {quick}, by brute force {expected} ± {error}");
        assert!(expected > 0.0 && error < 0.5 * part * expected, "{expected} ± {error}");
        assert!((quick - expected).abs() < part * expected + 2.0 * error, "{quick} {expected} ± {error}");
    }
}

fn towards(angle_deg: f64, azimuth_deg: f64) -> Source {
    let across = DVec2::from_angle(azimuth_deg.to_radians()) * angle_deg.to_radians().sin();
    Source::Far(across.extend(-angle_deg.to_radians().cos()))
}

#[test]
fn a_far_source_in_the_field_and_beside_it() {
    let triplet = system("none", &LensSettings::default());
    // In between, a coated lens and one with a lamp near it are below.
    let angles = if petzval_testkit::is_thorough() { &[0.0, 9.0, 26.0][..] } else { &[0.0, 26.0] };
    for &angle in angles {
        agree(&triplet, towards(angle, 30.0));
    }
}

/// Two reflections alone: of four nothing is left.
#[test]
fn a_coated_lens() {
    let triplet = system("MgF2", &LensSettings::default());
    let (beam, tracer) = (Beam::new(&triplet, towards(9.0, 30.0)).unwrap(), triplet.at_wavelength(LINE_NM));
    let found = brute::arrived(&triplet, &tracer, &beam, &film(&triplet), is_film, 50_000, randoms(2));
    let (expected, error) = (found.light_mm2[2], found.error_mm2[2]);
    let quick = by_pieces(&triplet, &beam, 2, 64);
    assert!(
        error < 0.005 * expected && (quick - expected).abs() < 0.01 * expected + 2.0 * error,
        "{quick} {expected} ± {error}"
    );
}

#[test]
fn a_lamp_near_the_lens_and_five_blades() {
    let settings = LensSettings { f_number: Some(8.0), blades: 5, ..LensSettings::default() };
    let triplet = system("none", &settings);
    agree(&triplet, towards(12.0, 75.0));
    agree(&triplet, Source::Near(DVec3::new(60.0, -40.0, -400.0)));
}

/// Pair by pair of a fisheye: the pieces against the sequential trace of rays all over the front glass. In its narrow gaps light comes
/// to be reflected as a whole within a beam.
#[test]
fn pairs_have_the_light_of_the_sequential_trace() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../lenses/fisheye-nikkor-16-f2.8.lens");
    let lens = lens::read(path.as_ref(), Catalogue::shipped()).unwrap();
    let settings = LensSettings { f_number: Some(4.0), ..LensSettings::default() };
    let system = System::new(&lens, &settings).unwrap();
    let beam = Beam::new(&system, towards(10.0, 90.0)).unwrap();
    let (tracer, film) = (system.at_wavelength(LINE_NM), film(&system));
    let (mut all, mut off) = (0.0, 0.0);
    for turns in system.reflecting_paths(LINE_NM, 2) {
        let reflected = tracer.reflected(&turns).unwrap();
        let rays = 60_000;
        let step = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
        let on_film = |i: i32| {
            let at = (step * f64::from(i)).fract() * 2.0 - 1.0;
            let (ray, power) = power::along(&system, &reflected, beam.ray(at))?;
            film.meet(&ray).map(DVec2::from).filter(|at| is_film(*at))?;
            Some(beam.light_mm2(at) * 4.0 * power / f64::from(rays))
        };
        let exact: f64 = (0..rays).filter_map(on_film).sum();
        let path = GhostTracer::new(&tracer, &turns).unwrap();
        let mut bundle = path.bundle();
        let mut sum = 0.0;
        if let Some(window) = path.window(&beam, &film, 0.08, &mut bundle) {
            path.pieces(
                &system,
                (&beam, &film),
                Grid { window: &window, side: 32, is_coarse: false },
                &mut bundle,
                &mut |piece| {
                    let middle = piece.corners.iter().sum::<DVec2>() / 3.0;
                    sum += if is_film(middle) { piece.light_mm2 } else { 0.0 };
                },
            );
        }
        // Of a narrow beam some hundred rays get through: their count is off by a few per cent. The narrowest are not found: 1e-3 of all.
        assert!((sum - exact).abs() < 0.06 * exact + 1e-5, "{turns:?}: {sum} {exact}");
        (all, off) = (all + exact, off + sum - exact);
    }
    assert!(off.abs() < 0.01 * all, "{off} of {all}");
}
