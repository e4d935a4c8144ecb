//! Points out of focus: round in the middle, cat's eyes towards the corner, rings behind mirrors, before and behind the
//! plane that is sharp.

use super::exact::Exact;
use super::noise::photographs;
use super::studio::{Exposure, Lamp, in_three, lamps, lens};
use glam::DVec3;
use petzval_optics::system::FocalLength;
use petzval_render::camera::{CameraDescription, lens_info};
use petzval_render::pipeline::Pipeline;

const PIXELS: [u32; 2] = [96, 64];
/// Middle, edge and corner, as parts of the picture's half width and height.
const PLACES: [[f64; 2]; 3] = [[0.02, -0.03], [-0.62, 0.1], [0.7, 0.66]];
/// Rays of the truth for each lamp.
const RAYS: u32 = 100_000;

struct Case {
    name: &'static str,
    focal_length_mm: Option<f64>,
    film_mm: f64,
    focus: f64,
    depth: f64,
}

const CASES: [Case; 4] = [
    Case { name: "double-gauss-f1.35", focal_length_mm: Some(50.0), film_mm: 36.0, focus: 1.0, depth: 0.35 },
    Case { name: "double-gauss-f1.35", focal_length_mm: Some(50.0), film_mm: 36.0, focus: 0.4, depth: 10.0 },
    Case { name: "wide-angle-smith-f3.4", focal_length_mm: None, film_mm: 120.0, focus: 0.35, depth: 20.0 },
    Case { name: "reflex-nikkor-500-f8", focal_length_mm: None, film_mm: 36.0, focus: 10.0, depth: 5.0 },
];
/// Half of a lamp's side in pixels, by first order.
const HALF_SIDE_PX: f64 = 2.0;

impl Case {
    fn camera(&self) -> CameraDescription {
        lens(self.name).with(|c| {
            c.lens.focal_length = self.focal_length_mm.map_or(FocalLength::AsPublished, FocalLength::Millimetres);
            c.film.width_mm = self.film_mm;
            c.film.height_mm = self.film_mm / 1.5;
            c.focus.distance = Some(self.focus);
        })
    }

    fn lamps(&self, d: &CameraDescription) -> Vec<Lamp> {
        let info = lens_info(d, PIXELS[0], PIXELS[1]).unwrap();
        // The width at the lamp's depth that a pinhole in the entrance pupil shows on the whole picture.
        let seen = info.picture_width_mm / info.viewport_focal_length_mm * self.depth;
        let lamp = |[x, y]: [f64; 2]| Lamp {
            at: DVec3::new(0.5 * x * seen, y * seen / 3.0, -self.depth),
            half_side: HALF_SIDE_PX * seen / f64::from(PIXELS[0]),
        };
        PLACES.map(lamp).to_vec()
    }
}

#[test]
fn points_out_of_focus_have_the_shapes_of_exact_rays() {
    for (number, case) in CASES.into_iter().enumerate() {
        let in_one = case.camera();
        let list = case.lamps(&in_one);
        let stage = lamps(&list);
        let mut ways = vec![(in_one.clone(), &[Pipeline::FilmFirst, Pipeline::SceneFirst][..])];
        // Before and behind the plane that is sharp; through the others in `make test-all`.
        if number < 2 || petzval_testkit::is_thorough() {
            ways.push((in_three(&in_one), &[Pipeline::Hero]));
        }
        for (d, pipelines) in ways {
            let exact = Exact::new(&d, PIXELS);
            let truths: Vec<_> = list.iter().map(|lamp| exact.picture_of(lamp, RAYS)).collect();
            for &pipeline in pipelines {
                let mean = photographs(&stage, &d, &Exposure { pixels: PIXELS, pipeline, samples: 32 });
                for (truth, place) in truths.iter().zip(PLACES) {
                    let reach = 3.0 * truth.spread_px + 2.0;
                    for channel in if pipeline == Pipeline::Hero { 0..3 } else { 1..2 } {
                        let what = format!("{} at {} {place:?} {pipeline:?} {channel}", case.name, case.depth);
                        mean.fit(truth, channel, reach).check(&what);
                    }
                }
            }
        }
    }
}

/// The comparison tells a lamp half a pixel aside, and a lens closed by a third of a stop, from the true ones.
#[test]
fn other_shapes_would_be_told() {
    let case = &CASES[1];
    let d = case.camera();
    let list = case.lamps(&d);
    let mean = photographs(&lamps(&list), &d, &Exposure { pixels: PIXELS, pipeline: Pipeline::FilmFirst, samples: 64 });
    let [middle, _, corner] = [0, 1, 2].map(|i| list[i]);
    let reach = 20.0;
    let exact = Exact::new(&d, PIXELS);
    mean.fit(&exact.picture_of(&corner, RAYS), 1, reach).check("corner");
    let aside = Lamp { at: corner.at + DVec3::X * 0.5 * corner.half_side / HALF_SIDE_PX, ..corner };
    mean.fit(&exact.picture_of(&aside, RAYS), 1, reach).check_not("half a pixel aside");
    let closed = Exact::new(&d.with(|c| c.lens.f_number = Some(1.5)), PIXELS).picture_of(&middle, RAYS);
    mean.fit(&closed, 1, reach).check_not("a smaller opening");
}
