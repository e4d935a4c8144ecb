//! Every way to take a picture, through lenses of every kind: by each pipeline, and from both ends.

use super::{FIGURE_3, HEIGHT, WIDTH, description, render, scenes, settings};
use petzval_optics::system::FocalLength;
use petzval_render::camera::CameraDescription;
use petzval_render::integrator::Integrator;
use petzval_render::job::Settings;
use petzval_render::pipeline::Pipeline;
use petzval_render::sampler::warp::Filter;

/// Side of a block whose mean is compared, and of the parts that tell its noise, pixels.
const BLOCK: usize = 16;
const PART: usize = 4;

/// The paper's wide angle, a double Gauss wide open, a fisheye to the edge of its field, a mirror lens whose points
/// out of focus are rings, an eye with its retina, an anamorphic, and the wide angle before a film swung by 20 degrees.
fn lenses() -> [(&'static str, CameraDescription); 7] {
    let lens = |name: &str, focal_length_mm: Option<f64>, film_mm: f64| {
        description(name).with(|c| {
            c.lens.focal_length = focal_length_mm.map_or(FocalLength::AsPublished, FocalLength::Millimetres);
            c.film.width_mm = film_mm;
            c.film.height_mm = film_mm / 1.5;
        })
    };
    let figure_3 = lens(FIGURE_3, Some(80.0), 48.0);
    [
        ("wide angle", figure_3.clone()),
        ("double Gauss", lens("double-gauss-f1.35", Some(70.0), 40.0)),
        ("fisheye", lens("laikin-fisheye-170", None, 10.0)),
        ("mirror lens", lens("reflex-nikkor-500-f8", Some(90.0), 36.0).with(|c| c.focus.distance = Some(4.5))),
        ("eye", lens("eye-navarro", None, 10.0).with(|c| c.focus.distance = None)),
        ("anamorphic", lens("anamorphic-2x-double-gauss", None, 22.0)),
        ("swing", figure_3.with(|c| c.film.swing_rad = 20f64.to_radians())),
    ]
}

/// The difference of two pictures, in standard errors: by block and channel, and over the whole picture. Both show the same in every pixel
/// but for noise, so that the spread of the differences over parts of a block is noise alone.
struct Difference {
    blocks: Vec<f64>,
    whole: [f64; 3],
    /// Standard error of the whole picture's mean over that mean, green.
    noise: f64,
}

fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> Difference {
    let (width, height) = (WIDTH as usize, HEIGHT as usize);
    let columns = width / PART;
    let mut parts = vec![[0.0; 3]; columns * (height / PART)];
    let (mut light, mut all) = (0.0, 0.0);
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        let part = &mut parts[i / width / PART * columns + i % width / PART];
        (0..3).for_each(|c| part[c] += f64::from(a[c]) - f64::from(b[c]));
        light += f64::from(a[1]);
        all += 1.0;
    }
    let score = |list: Vec<f64>| {
        let n = list.len() as f64;
        let mean = list.iter().sum::<f64>() / n;
        let error = (list.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
        (mean, error)
    };
    let mut blocks = Vec::new();
    let side = BLOCK / PART;
    for (x, y, c) in
        (0..height / BLOCK).flat_map(|y| (0..width / BLOCK).flat_map(move |x| (0..3).map(move |c| (x, y, c))))
    {
        let inside = (0..side * side).map(|k| parts[(y * side + k / side) * columns + x * side + k % side][c]);
        let (mean, error) = score(inside.collect());
        // Nothing is where the lens sees nothing.
        if error > 0.0 {
            blocks.push(mean / error);
        }
    }
    let whole = [0, 1, 2].map(|c| score(parts.iter().map(|p| p[c]).collect()));
    let noise = whole[1].1 / (light / all * (PART * PART) as f64);
    Difference { blocks, whole: whole.map(|(mean, error)| mean / error), noise }
}

/// Seven lenses, each with three of five scenes (all five in `make test-all`), whose light comes from lamps, glowing meshes and the sky.
/// Hero is the measure.
///
/// A comparison's noise is 1 to 10 % of the picture's mean, about 2 % for half of them: a pipeline that is wrong by 2.5 %
/// through every lens is told by all 19 together, and through a single one by 10 %; one that is wrong by half in one
/// block, there.
#[test]
fn every_way_through_every_lens_takes_the_same_picture() {
    let scenes = [
        ("box", scenes::box_under_a_lamp()),
        ("emissive", scenes::emissive()),
        ("sky", scenes::image_sky()),
        ("lamps", scenes::many_lamps()),
        ("triangles", scenes::triangles()),
    ];
    let ways = [
        ("film-first", Integrator::Path, Pipeline::FilmFirst, 24),
        ("scene-first", Integrator::Path, Pipeline::SceneFirst, 16),
        ("both ends", Integrator::Bidirectional, Pipeline::Hero, 8),
    ];
    let mut by_way = ways.map(|(name, ..)| (name, Vec::new(), Vec::new()));
    // No two pictures have the same random numbers: what they got wrong would add up.
    let mut seeds = 1..;
    for (i_scene, (scene, stage)) in scenes.iter().enumerate() {
        for (i_lens, (lens, d)) in lenses().iter().enumerate() {
            // A map of the pupil takes long where no symmetry helps: one scene will do. The others have three each, or all.
            let is_one_of_three = petzval_testkit::is_thorough() || (i_scene + i_lens) % 5 < 3;
            let is_wanted = if *lens == "anamorphic" { *scene == "triangles" } else { is_one_of_three };
            if !is_wanted {
                continue;
            }
            let mut shoot = |integrator, pipeline, samples| {
                let (filter, seed) = (Filter::Box, seeds.next().unwrap());
                let s = Settings { pipeline, filter, max_bounces: 3, ..settings(integrator, samples, seed) };
                render(stage, d, s)
            };
            let measure = shoot(Integrator::Path, Pipeline::Hero, 24);
            for (i, (name, integrator, pipeline, samples)) in ways.into_iter().enumerate() {
                let other = shoot(integrator, pipeline, samples);
                let d = difference(&measure, &other);
                println!("{scene} {lens} {name}: {:.2?} noise {:.4}", d.whole, d.noise);
                assert!(d.whole.iter().all(|z| z.abs() < 4.5), "{scene} {lens} {name}: {:?}", d.whole);
                by_way[i].1.extend(d.blocks);
                by_way[i].2.push(d.whole[1]);
            }
        }
    }
    for (name, blocks, wholes) in by_way {
        let n = blocks.len() as f64;
        let mean2 = blocks.iter().map(|z| z * z).sum::<f64>() / n;
        let beyond = blocks.iter().filter(|z| z.abs() > 3.0).count() as f64 / n;
        let worst = blocks.iter().fold(0.0f64, |w, z| w.max(z.abs()));
        let bias = wholes.iter().sum::<f64>() / (wholes.len() as f64).sqrt();
        println!("{name}: {n} scores, mean square {mean2:.2}, {beyond:.4} beyond 3, worst {worst:.1}, bias {bias:.2}");
        // Sixteen parts know their spread to a fifth: Student's t of 15 degrees has a mean square of 1.15 and 0.9 %
        // beyond 3.
        assert!(n > 300.0 && mean2 < 1.5 && beyond < 0.025 && worst < 6.5, "{name}: {mean2} {beyond} {worst}");
        // All have the same measure and the same lenses.
        assert!(bias.abs() < 4.0, "{name}: {bias}");
    }
}
