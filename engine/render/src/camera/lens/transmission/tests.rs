//! The fit agrees with the losses of exact rays, for every lens, and all pipelines and integrators have the same losses.

use super::*;
use crate::camera::lens::real_lens::packet::Request;
use crate::camera::lens::real_lens::precision::tests::camera as of_own_field;
use crate::camera::tests::with_lens;
use crate::camera::{Camera, CameraDescription, Model, Spectrum};
use crate::sampler::{
    PathSampler,
    raster::Raster,
    warp::{Filter, PixelFilter},
};
use petzval_optics::coating::Coating;

const SIZE: [u32; 2] = [300, 200];
/// A quarter of the error that a plan leaves out.
const TOLERANCE_STOPS: f64 = 0.02 / 4.0;

fn taken(lens: &str, coating: Option<&str>) -> CameraDescription {
    let coating = coating.map(|name| Coating::parse(name).unwrap());
    CameraDescription { transmission: true, ..with_lens(lens, 36.0, 24.0, 0.0) }.with(|c| c.lens.coating = coating)
}

/// The colour of a uniform world of radiance one at a place, by rays from the film.
fn white(camera: &Camera, place: Vec2) -> Rgb {
    const RAYS: u32 = 8192;
    let points = Evenly::<3>::default();
    let request = |i: u32| {
        let [u, v, w] = points.point(i).map(|u| u as f32);
        Request { place, u_lens: [u, v], u_wavelength: w, ..Request::default() }
    };
    let requests: Vec<Request> = (0..RAYS).map(request).collect();
    let mut rays = Vec::new();
    camera.sample_batch(&requests, camera.batch().as_mut(), &mut rays);
    rays.iter().flatten().map(|ray| ray.white()).sum::<Rgb>() / RAYS as f32
}

/// The fit's error over every third lens (all by `make test-all`), on their own film, is within the limit; those that are not are
/// known.
#[test]
fn every_lens_is_fitted() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses");
    let mut count = 0;
    for path in petzval_testkit::lenses::third(folder, 0) {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let camera = of_own_field(&path, SIZE, |d| (d.transmission, d.spectrum) = (true, Spectrum::Bands(8)));
        let lens = camera.traced_lens().unwrap();
        let error = lens.transmission_error_stops().unwrap();
        // Some light of fisheyes comes along surfaces rather than through them, and much of a ball's.
        let allowed = match name.as_str() {
            "ball-lens-10mm.lens" => 0.2,
            "laikin-fisheye-170.lens" | "fisheye-nikkor-16-f2.8.lens" => 2.0 * TOLERANCE_STOPS,
            _ => TOLERANCE_STOPS,
        };
        assert!(error < allowed, "{name} {error}");
        count += 1;
    }
    assert!(count > if petzval_testkit::is_thorough() { 50 } else { 15 }, "{count}");
}

/// Uncoated flint is yellowish by the product of its surfaces' transmittances, and the middle is as bright as ever; by the f-number it is
/// darker by that product.
#[test]
fn the_middle_has_the_lens_s_colour() {
    let file = std::env::temp_dir().join(format!("petzval-flint-{}.lens", std::process::id()));
    let rows = "200 3 N-SF66 20 0 0\n-200 1 air 20 0 0\n200 3 N-SF66 20 0 0\n-200 1 air 20 0 0\n0 30 air 6 0 1\n";
    std::fs::write(&file, format!("# coating: none\n{rows}")).unwrap();
    let mut d = taken("wide-angle-smith-f3.4.lens", None);
    (d.lens_path, d.lens.f_number) = (file.clone(), Some(11.0));
    let catalogue = petzval_optics::glass::Catalogue::shipped();
    let flint = catalogue.medium("N-SF66").unwrap();
    // Of each wavelength four times what one surface passes at right angles, and what 6 mm of glass do.
    let part = |nm: &f64| {
        let n = flint.index(*nm);
        (1.0 - ((n - 1.0) / (n + 1.0)).powi(2)).powi(4) * flint.internal_transmittance(*nm, 6.0).unwrap()
    };
    let expected = colour(&FilmSpectrum::visible(), |nms| Some(nms.iter().map(part).collect())).unwrap() * Rgb::ONE;
    let wavelengths = [None, Some(587.6)];
    for (wavelength_nm, model) in wavelengths.into_iter().zip([Model::Lens; 2]).chain([
        (None, Model::Paraxial),
        (None, Model::Thick),
        (None, Model::ImageBased),
    ]) {
        for (exposes_by_f_number, white_balance) in [(true, false), (false, false), (true, true), (false, true)] {
            let d = CameraDescription { wavelength_nm, model, exposes_by_f_number, white_balance, ..d.clone() };
            let found = white(&Camera::new(&d, SIZE[0], SIZE[1]).unwrap(), Vec2::ZERO);
            let colour = if white_balance { Rgb::splat(luminance(expected)) } else { expected };
            let expected = if exposes_by_f_number { colour } else { colour / luminance(expected) };
            let apart = (found / expected - Rgb::ONE).abs().max_element();
            let what = format!("{model:?} {wavelength_nm:?} {exposes_by_f_number} {white_balance}");
            assert!(apart < 4e-3, "{what}: {found} {expected}");
        }
    }
    std::fs::remove_file(file).unwrap();
    assert!(expected.z < 0.95 * expected.x && expected.y < 0.66, "{expected}");
}

/// Film-first rays, packets and rays from the scene expose a white world alike, with the colour that exact rays have there.
#[test]
fn all_ways_take_the_same() {
    for coating in ["none", "triple"] {
        let d = taken("double-gauss-f2-available.lens", Some(coating));
        let camera = Camera::new(&d, SIZE[0], SIZE[1]).unwrap();
        let lens = camera.traced_lens().unwrap();
        let raster = Raster::new(SIZE[0], SIZE[1], PixelFilter::new(Filter::BlackmanHarris(1.5)));
        let place = Vec2::new(0.32, -0.3);
        let alone = white(&camera, place);
        // The same place by packets: all that is led from a patch about it, over what is sent.
        let plain = Camera::new(&CameraDescription { transmission: false, ..d.clone() }, SIZE[0], SIZE[1]).unwrap();
        let sums = [&camera, &plain].map(|camera| {
            let lens = camera.traced_lens().unwrap();
            let mut sum = [Rgb::ZERO; 2];
            let (mut batch, mut leads) = (lens.batch(), Vec::new());
            let requests: Vec<Request> = (0..4096)
                .map(|i| {
                    let pixel = [246 + i % 8, 156 + i / 8 % 8];
                    let mut sampler = PathSampler::new(pixel[0], pixel[1], i / 64, 1);
                    let ([a, b, c, e], [f, g, h, k]) = (sampler.next_4d(), sampler.next_4d());
                    let place = raster.place(pixel[0], pixel[1], [a, b]);
                    Request {
                        pixel,
                        place,
                        u_lens: [c, e],
                        u_wavelength: f,
                        u_pixels: [g, h],
                        u_place: [a, b],
                        u_beyond: k,
                    }
                })
                .collect();
            lens.lead_all_batch(&requests, &raster, &mut batch, &mut leads);
            let scene = requests.iter().map(|r| lens.lead_from_scene(r, &raster)).collect::<Vec<_>>();
            for (way, led) in [leads, scene].iter().enumerate() {
                for led in led.iter().flatten() {
                    lens.expose(&led.splats, Rgb::ONE, |_, _, light| sum[way] += light.truncate());
                }
            }
            sum
        });
        let expected = alone / white(&plain, place);
        let [with, without] = &sums;
        for (way, (with, without)) in with.iter().zip(without).enumerate() {
            let found = *with / *without;
            assert!((found / expected - Rgb::ONE).abs().max_element() < 0.01, "{coating} {way}: {found} {expected}");
        }
        // What exact rays of the same beam say.
        let map = &lens.map;
        let passages = Passages::new(&lens.system, 550.0);
        let exact = colour_at(&lens.mount, map, &passages, place.as_dvec2()).unwrap();
        let middle = colour_at(&lens.mount, map, &passages, DVec2::ZERO).unwrap();
        // Balanced for white in the middle.
        let exact = exact / middle;
        assert!((expected / exact - Rgb::ONE).abs().max_element() < 0.006, "{coating}: {expected} {exact}");
    }
}
