//! The spot of a far point through a lens: its shape, pixel by pixel, by every pipeline.

use super::exact::{Exact, Truth};
use super::noise::photographs;
use super::studio::{Exposure, Lamp, in_three, lamps, lens};
use glam::DVec3;
use petzval_render::camera::{CameraDescription, Spectrum};
use petzval_render::pipeline::Pipeline;

/// Far, Blender units: a thousandth of the depth of field of any of these lenses is nearer.
const FAR: f64 = 1000.0;
/// Side of the picture, pixels: six times the spot's spread.
const SIDE: u32 = 32;
const RAYS: u32 = 100_000;

/// A far lamp at an angle from the axis, towards the upper right, as wide as `angle_rad`.
fn far_lamp(field_deg: f64, angle_rad: f64) -> Lamp {
    let tan = field_deg.to_radians().tan();
    let at = FAR * DVec3::new(0.8 * tan, 0.6 * tan, -1.0);
    Lamp { at, half_side: 0.5 * angle_rad * FAR }
}

/// The camera with a small film where the spot is, and the lamp as large as two of its pixels.
fn close_up(d: &CameraDescription, field_deg: f64) -> (CameraDescription, Lamp) {
    let wide = d.clone().with(|c| {
        c.film.width_mm = 10.0;
        c.film.height_mm = 10.0;
    });
    let exact = Exact::new(&wide, [1, 1]);
    let Truth { centroids, spread_px, .. } = exact.picture_of(&far_lamp(field_deg, 1e-6), 20_000);
    let middle = exact.on_film(centroids[1]);
    let film_mm = 6.0 * spread_px * 10.0;
    // The film moved is the lens moved the other way.
    let shift_mm = [-middle.x, -middle.y];
    let pixel_rad = film_mm / f64::from(SIDE) / middle.length() * field_deg.to_radians().tan();
    let d = wide.with(|c| {
        c.film.width_mm = film_mm;
        c.film.height_mm = film_mm;
        c.film.shift_mm = shift_mm;
    });
    (d, far_lamp(field_deg, 2.0 * pixel_rad))
}

#[test]
fn spots_of_far_points_have_the_shapes_of_exact_rays() {
    // Coma and astigmatism; spherical aberration and field curvature; a spot cut by rims; a mirror lens's coma; a
    // retina.
    let cases = [
        ("wide-angle-smith-f3.4", 22.0),
        ("biconvex-50mm", 5.0),
        ("double-gauss-f1.35", 12.0),
        ("newtonian-f5", 0.5),
        ("eye-navarro", 15.0),
    ];
    for (name, field_deg) in cases {
        let d = lens(name);
        for (pipeline, d) in [
            (Pipeline::FilmFirst, d.clone()),
            (Pipeline::SceneFirst, d.clone()),
            (Pipeline::Hero, in_three(&d)),
            (Pipeline::Hero, CameraDescription { wavelength_nm: None, ..d }),
        ] {
            let is_mirror = name == "newtonian-f5";
            if pipeline == Pipeline::Hero && is_mirror {
                continue;
            }
            // The whole spectrum has more to go wrong; points out of focus are taken in three wavelengths, too.
            if pipeline == Pipeline::Hero
                && d.wavelength_nm.is_none()
                && d.spectrum == Spectrum::Three
                && !petzval_testkit::is_thorough()
            {
                continue;
            }
            let (d, lamp) = close_up(&d, field_deg);
            let truth = Exact::new(&d, [SIDE; 2]).picture_of(&lamp, RAYS);
            let mean = photographs(&lamps(&[lamp]), &d, &Exposure { pixels: [SIDE; 2], pipeline, samples: 100 });
            for channel in if d.wavelength_nm.is_some() { 1..2 } else { 0..3 } {
                let what = format!("{name} {field_deg} {pipeline:?} {:?} {channel}", d.spectrum);
                mean.fit(&truth, channel, f64::from(SIDE)).check(&what);
            }
        }
    }
}
