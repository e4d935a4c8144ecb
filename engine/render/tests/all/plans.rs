//! Plans of effects: each effect's trigger from both sides, the users' wishes, and that a picture is the same whatever was left out.

use crate::cameras::camera;
use crate::scenes;
use glam::{DMat4, DVec3};
use petzval_optics::coating::Coating;
use petzval_render::Rgb;
use petzval_render::camera::scattering::Scattering;
use petzval_render::camera::{Camera, CameraDescription, Model, Spectrum};
use petzval_render::integrator::PreparedScene;
use petzval_render::job::{Job, Settings};
use petzval_render::pipeline::Pipeline;
use petzval_render::plan::{CameraKind, Decision, Effect, EffectMode, LensNeed, Plan, PlanError, PlanOptions};
use petzval_render::scene::SceneBuilder;
use petzval_render::scene::lamp::LampKind;
use petzval_render::scene::world::World;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A wall at a depth before the camera, which stands at the origin.
fn wall(depth: f64) -> Arc<PreparedScene> {
    let mut room = scenes::Room { builder: SceneBuilder::new() };
    let place = DMat4::from_translation(DVec3::new(0.0, 0.0, -depth)) * DMat4::from_scale(DVec3::splat(10.0 * depth));
    room.put(scenes::square(), scenes::plain(0.7, 0.6, 0.5), place);
    room.finish()
}

fn lens(name: &str, film_mm: f64) -> CameraDescription {
    CameraDescription {
        lens_path: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses").join(format!("{name}.lens")),
        ..CameraDescription::default()
    }
    .with(|c| {
        c.film.width_mm = film_mm;
        c.film.height_mm = film_mm / 1.5;
        c.focus.distance = Some(3.0);
    })
}

fn triplet() -> CameraDescription {
    lens("cooke-triplet-50mm", 36.0)
}

/// A picture to be planned.
struct Shot {
    stage: Arc<PreparedScene>,
    d: CameraDescription,
    moving: Vec<CameraDescription>,
    size: [u32; 2],
}

impl Shot {
    fn plan(&self, wishes: &PlanOptions) -> Result<Plan, PlanError> {
        Plan::new(&self.stage, &self.d, &self.moving, self.size, wishes, LensNeed::None, None)
    }

    /// The decision on an effect by its own measure: the other error of colour is left out.
    fn decision(&self, effect: Effect) -> Decision {
        let mut own = PlanOptions::default();
        match effect {
            Effect::LateralColour => own.say(Effect::AxialColour, EffectMode::Off),
            Effect::AxialColour => own.say(Effect::LateralColour, EffectMode::Off),
            _ => {}
        }
        self.plan(&own).unwrap().decision(effect).clone()
    }
}

fn at_quality(quality: f64) -> PlanOptions {
    let mut wishes = PlanOptions::default();
    wishes.quality = quality;
    wishes
}

/// Lenses colour the light that they let through by more than pictures of some tens of pixels show of anything else.
fn no_colour_at_quality(quality: f64) -> PlanOptions {
    let mut wishes = at_quality(quality);
    wishes.say(Effect::Transmission, EffectMode::Off);
    wishes
}

fn wishes(words: &[(Effect, EffectMode)]) -> PlanOptions {
    let mut wishes = PlanOptions::default();
    words.iter().for_each(|(effect, word)| wishes.say(*effect, *word));
    wishes
}

fn shot(d: CameraDescription, depth: f64, width: u32) -> Shot {
    Shot { stage: wall(depth), d, moving: Vec::new(), size: [width, width * 2 / 3] }
}

/// A picture for each effect in which the effect grows with one number from 0 to 1.
#[expect(clippy::too_many_lines, reason = "a scene for each effect")]
fn growing(effect: Effect, x: f64) -> Shot {
    let between = |low: f64, high: f64| low * (high / low).powf(x);
    match effect {
        Effect::Defocus => shot(triplet().with(|c| c.lens.f_number = Some(8.0)), 3.0 + 3.0 * x, 900),
        Effect::Aberration => {
            let d = triplet().with(|c| {
                c.film.width_mm = 18.0;
                c.film.height_mm = 12.0;
            });
            shot(d.with(|c| c.lens.f_number = Some(between(22.0, 2.8))), 3.0, 600)
        }
        // The finer the pixels, the more of them between two places of the film.
        Effect::Distortion | Effect::LateralColour | Effect::AxialColour => {
            shot(lens("wide-angle-smith-f3.4", 120.0), 3.0, between(30.0, 4000.0) as u32)
        }
        Effect::Vignetting => {
            let film_width_mm = between(2.0, 36.0);
            let d = triplet().with(|c| {
                c.film.width_mm = film_width_mm;
                c.film.height_mm = film_width_mm / 1.5;
            });
            shot(d.with(|c| c.lens.f_number = Some(8.0)), 3.0, 300)
        }
        Effect::Diaphragm => {
            let d = triplet().with(|c| {
                c.lens.f_number = Some(5.6);
                c.lens.blades = 6;
            });
            shot(
                d.with(|c| {
                    c.film.width_mm = 12.0;
                    c.film.height_mm = 8.0;
                }),
                3.0 + 3.0 * x,
                1600,
            )
        }
        Effect::MotionBlur => {
            let at = |focus: f64| {
                triplet().with(|c| {
                    c.focus.distance = Some(focus);
                    c.lens.f_number = Some(8.0);
                })
            };
            Shot { moving: vec![at(3.0 - x), at(3.0), at(3.0 + x)], ..shot(at(3.0), 3.0, 900) }
        }
        Effect::Diffraction => shot(triplet().with(|c| c.lens.f_number = Some(between(5.0, 32.0))), 3.0, 1600),
        Effect::Glare => {
            let mut room = scenes::Room { builder: SceneBuilder::new() };
            room.builder.set_world(World { color: Rgb::ONE, ..World::default() }).unwrap();
            let scattering = Scattering { veiling_index: between(1e-4, 0.1), ..Scattering::NONE };
            let d = CameraDescription { scattering, ..triplet() };
            Shot { stage: room.finish(), d, moving: Vec::new(), size: [300, 200] }
        }
        // A film of a high index: the thicker, the more it reflects, and the less evenly.
        Effect::Transmission => {
            let coating = Some(Coating::parse(&format!("2.3:{:.6}nm", 60.0 * x)).unwrap());
            let d = lens("biconvex-50mm", 8.0).with(|c| c.lens.coating = coating);
            // White balance takes most of it.
            shot(CameraDescription { white_balance: false, ..d }, 3.0, 300)
        }
        // A sun in the picture, before an even sky.
        Effect::Ghosts => {
            let mut room = scenes::Room { builder: SceneBuilder::new() };
            room.builder.set_world(World { color: Rgb::ONE, ..World::default() }).unwrap();
            let sun = scenes::lamp(LampKind::Sun { half_angle_rad: 0.005 }, between(1e-3, 1e3) as f32);
            room.light(sun, DMat4::from_rotation_y(std::f64::consts::PI + 0.1));
            Shot { stage: room.finish(), d: triplet(), moving: Vec::new(), size: [300, 200] }
        }
        other => unreachable!("{other:?} cannot be simulated"),
    }
}

/// An effect a little too small is left out or only comes along, one a little larger is called for, and the measure tells them apart.
#[test]
fn each_effect_is_called_for_where_it_begins_to_matter() {
    for effect in Effect::ALL.into_iter().filter(|effect| effect.is_available()) {
        let decision = |x: f64| growing(effect, x).decision(effect);
        let measure = |decision: &Decision| decision.measure.unwrap();
        let (mut low, mut high) = (0.0, 1.0);
        let (mut below, mut above) = (decision(low), decision(high));
        // The place at which the measure with its margin of a quarter is the tolerance.
        let at_limit = above.tolerance / 1.25;
        assert!(measure(&below) < at_limit && measure(&above) > at_limit, "{effect:?}: {below:?} {above:?}");
        // Until the measures on both sides are close enough to be told from the limit.
        let is_close = |below: &Decision, above: &Decision| measure(above) / measure(below) - 1.0 < 0.1;
        for _ in 0..9 {
            if is_close(&below, &above) {
                break;
            }
            let middle = 0.5 * (low + high);
            let found = decision(middle);
            if measure(&found) < at_limit { (low, below) = (middle, found) } else { (high, above) = (middle, found) }
        }
        let is_called_for = |d: &Decision| d.is_on && d.why.ends_with(": simulated");
        assert!(!is_called_for(&below) && is_called_for(&above), "{effect:?}: {below:?} {above:?}");
        assert!(above.is_uncertain && !below.is_uncertain, "{effect:?}");
        assert!(is_close(&below, &above), "{effect:?}: {below:?} {above:?}");
    }
}

/// Effects that are left out of a picture are not prepared, either: the plan's camera is the smaller one.
#[test]
fn what_is_left_out_is_not_made() {
    let limit = |effect: Effect, x: f64| {
        let shot = growing(effect, x);
        let plan = shot.plan(&PlanOptions::default()).unwrap();
        let d = plan.applied(&shot.d);
        (Camera::new(&d, shot.size[0], shot.size[1]).unwrap(), plan, d)
    };
    let packet = |camera: &Camera| camera.traced_lens().map_or(0, |lens| lens.packet_size());
    let ((grey, plan, d), (colours, ..)) = (limit(Effect::LateralColour, 0.0), limit(Effect::LateralColour, 1.0));
    assert!(packet(&grey) <= 1 && packet(&colours) == 8);
    assert!(d.wavelength_nm.is_some() && plan.camera.wavelengths() == 1);
    let (_, _, round) = limit(Effect::Diaphragm, 0.0);
    assert_eq!(round.lens.blades, 0);
    // As much light as through the six blades.
    assert!(
        (round.lens.f_number.unwrap() / 5.6 - (std::f64::consts::PI / (3.0 * 3f64.sqrt() / 2.0)).sqrt()).abs() < 1e-3
    );
    assert_eq!(limit(Effect::Diaphragm, 1.0).2.lens.blades, 6);
    assert!(!limit(Effect::MotionBlur, 0.0).1.camera.is_moving && limit(Effect::MotionBlur, 1.0).1.camera.is_moving);
}

/// Two errors of colour, each too small to be seen, are simulated where both together are not; not where one is left out by the
/// user's word, or both together are small, too.
#[test]
fn errors_of_colour_add_up() {
    let colours = [Effect::LateralColour, Effect::AxialColour];
    let small = || shot(triplet().with(|c| c.lens.f_number = Some(8.0)), 3.0, 100);
    let plan = small().plan(&PlanOptions::default()).unwrap();
    let [lateral, axial] = colours.map(|effect| plan.decision(effect).measure.unwrap());
    let (larger, smaller) = if lateral >= axial { (colours[0], colours[1]) } else { (colours[1], colours[0]) };
    let (one, both) = (lateral.max(axial), lateral + axial);
    assert!(lateral.min(axial) > 0.1 * one, "{lateral} and {axial}");
    // Of the tolerance at quality 1, half a pixel; an effect counts a quarter more than what was measured of it.
    let limited = |size: f64| at_quality(0.5 / (1.25 * size));
    let mut alone = limited(1.02 * one);
    alone.say(smaller, EffectMode::Off);
    for (wishes, is_on) in
        [(limited(0.98 * both), true), (limited(1.02 * one), true), (limited(1.02 * both), false), (alone, false)]
    {
        let plan = small().plan(&wishes).unwrap();
        assert_eq!(plan.camera.wavelengths() > 1, is_on, "{:?}", plan.decision(larger));
        let word = smaller.name().replace('_', " ");
        assert_eq!(plan.decision(larger).why.contains(&word), is_on, "{:?}", plan.decision(larger));
    }
}

/// More wavelengths are used where colours are farther apart, so that neighbours' images touch.
#[test]
fn wavelengths_are_as_many_as_their_images_need() {
    let mut last = 0;
    for width in [200, 1000, 3000, 8000] {
        let plan = shot(triplet(), 3.0, width).plan(&PlanOptions::default()).unwrap();
        let spread = plan.lens.unwrap().lateral_colour.value.max(plan.lens.unwrap().axial_colour.value);
        let count = plan.camera.wavelengths();
        assert!(count >= last && (count == 1 || count.is_multiple_of(8)));
        assert!(spread / count as f64 <= 0.5 || count == 48, "{width}: {spread} {count}");
        last = count;
    }
    assert!(last > 8);
    // What the user chose to part the light into stays.
    let three = CameraDescription { spectrum: Spectrum::Three, ..triplet() };
    assert_eq!(shot(three, 3.0, 3000).plan(&PlanOptions::default()).unwrap().camera.wavelengths(), 3);
}

/// The user's word goes before every measure, and quality before every tolerance.
#[test]
fn the_user_has_the_last_word() {
    let small = || shot(triplet().with(|c| c.lens.f_number = Some(16.0)), 3.0, 90);
    let large = || shot(triplet(), 3.0, 2000);
    for effect in Effect::ALL.into_iter().filter(|effect| effect.is_available()) {
        // Nothing of the camera moves, and the opening is round.
        if matches!(effect, Effect::MotionBlur | Effect::Diaphragm) {
            continue;
        }
        let on = small().plan(&wishes(&[(effect, EffectMode::On)])).unwrap();
        assert!(on.decision(effect).is_on, "{effect:?}");
        let off = large().plan(&wishes(&[(effect, EffectMode::Off)])).unwrap();
        assert!(!off.decision(effect).is_on, "{effect:?}: {:?}", off.decision(effect));
        assert!(off.decision(effect).why.contains("as asked"));
    }
    let fine = at_quality(100.0);
    assert!(small().plan(&fine).unwrap().camera.wavelengths() > 1);
    assert_eq!(small().plan(&PlanOptions::default()).unwrap().camera.wavelengths(), 1);
    for quality in [0.0, -1.0, f64::NAN, 1e9] {
        let error = small().plan(&at_quality(quality)).unwrap_err();
        assert!(matches!(error, PlanError::Quality(_)), "{error}");
    }
    for effect in Effect::ALL.into_iter().filter(|effect| !effect.is_available()) {
        let error = large().plan(&wishes(&[(effect, EffectMode::On)])).unwrap_err();
        assert!(matches!(error, PlanError::NotYet(e) if e == effect), "{error}");
    }
    // Light that comes from the other end needs the lens as it is.
    let shot = large();
    let two_way = |words: &[(Effect, EffectMode)]| {
        Plan::new(&shot.stage, &shot.d, &[], shot.size, &wishes(words), LensNeed::Required, None)
    };
    assert!(matches!(two_way(&[(Effect::Distortion, EffectMode::Off)]), Err(PlanError::Conflict(_))));
    assert_eq!(two_way(&[(Effect::Vignetting, EffectMode::Off)]).unwrap().camera.way, CameraKind::Exact);
    let pinhole = Shot { d: CameraDescription { model: Model::Pinhole, ..triplet() }, ..large() };
    assert_eq!(pinhole.plan(&PlanOptions::default()).unwrap().camera.way, CameraKind::Given);
    assert!(matches!(pinhole.plan(&wishes(&[(Effect::Distortion, EffectMode::On)])), Err(PlanError::Conflict(_))));
}

fn picture(stage: &Arc<PreparedScene>, d: &CameraDescription, size: [u32; 2], samples: u32) -> Vec<[f32; 4]> {
    let settings =
        Settings { width: size[0], height: size[1], samples, pipeline: Pipeline::Auto, ..Settings::default() };
    let job = Job::start(stage.clone(), camera(d, size[0], size[1]), settings).unwrap();
    assert!(job.wait(Duration::from_secs(300)));
    assert_eq!(job.statistics().counts.non_finite, 0);
    job.film().picture()
}

/// A pinhole stands for a lens of which nothing can be seen: the same picture, shifted film and all.
#[test]
fn a_pinhole_stands_for_a_lens_of_which_nothing_is_seen() {
    let d = lens("cooke-triplet-50mm", 8.0).with(|c| {
        c.lens.f_number = Some(22.0);
        c.focus.distance = Some(4.0);
        c.film.shift_mm = [0.5, -0.3];
    });
    let stage = scenes::box_under_a_lamp();
    let shot = Shot { stage: stage.clone(), d: d.clone(), moving: Vec::new(), size: [48, 32] };
    let plan = shot.plan(&no_colour_at_quality(0.4)).unwrap();
    let told: Vec<&str> = plan.decisions.iter().map(|d| d.why.as_str()).collect();
    assert!(matches!(plan.camera.way, CameraKind::Pinhole { .. }), "{told:#?}");
    let simple = picture(&stage, &plan.applied(&d), shot.size, 256);
    let exact = picture(&stage, &d, shot.size, 256);
    let block = |picture: &[[f32; 4]], i: usize| -> f64 {
        let (x, y) = (i % 6 * 8, i / 6 * 8);
        let all = (0..64).map(|k| picture[(y + k / 8) * 48 + x + k % 8]);
        all.map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>() / 64.0
    };
    for i in 0..24 {
        let (a, b) = (block(&simple, i), block(&exact, i));
        // A quarter of a pixel at the edges of things, a twentieth of a stop, and noise.
        assert!((a / b - 1.0).abs() < 0.06, "{i}: {a} {b}");
    }
}

/// A pinhole shows width and height alike: a lens that squeezes one of them, or a film that leans, needs its lens.
#[test]
fn no_pinhole_stands_for_a_lens_that_squeezes() {
    let small = |d: CameraDescription| Shot {
        stage: wall(3.0),
        d: d.with(|c| {
            c.lens.f_number = Some(22.0);
            c.film.width_mm = 2.0;
            c.film.height_mm = 2.0 / 1.5;
        }),
        moving: Vec::new(),
        size: [48, 32],
    };
    let way = |d: CameraDescription| small(d).plan(&no_colour_at_quality(0.3)).unwrap().camera.way;
    assert!(matches!(way(triplet()), CameraKind::Pinhole { .. }));
    assert_eq!(way(lens("anamorphic-2x-double-gauss", 2.0)), CameraKind::Exact);
    assert_eq!(way(triplet().with(|c| c.film.tilt_rad = 0.1)), CameraKind::Exact);
    assert_eq!(
        way(CameraDescription { scale_mm_per_unit: DVec3::new(1000.0, 1000.0, 900.0), ..triplet() }),
        CameraKind::Exact
    );
}

/// Lamps in the picture are found at their places, and those behind the camera are not.
#[test]
fn sources_are_found_in_the_picture() {
    let lamp = |z: f64, power: f32| {
        let mut room = scenes::Room { builder: SceneBuilder::new() };
        room.put(scenes::square(), scenes::plain(0.5, 0.5, 0.5), DMat4::from_translation(DVec3::new(0.0, 0.0, -9.0)));
        let kind = LampKind::Point { radius: 0.05, soft: false };
        room.light(scenes::lamp(kind, power), DMat4::from_translation(DVec3::new(0.6, 0.4, z)));
        Shot { stage: room.finish(), d: triplet(), moving: Vec::new(), size: [300, 200] }
    };
    let plan = |z: f64| lamp(z, 100.0).plan(&PlanOptions::default()).unwrap();
    let (before, behind) = (plan(-4.0), plan(4.0));
    let place = before.look.brightest[0].place.unwrap();
    // 50 mm before 36 mm of film, to a place of the grid: 1/64 and 1/36 of the picture.
    let expected = [0.6 / 4.0 * 50.0 / 36.0, 0.4 / 4.0 * 50.0 / 24.0];
    assert!(
        (f64::from(place.x) - expected[0]).abs() < 0.02 && (f64::from(place.y) - expected[1]).abs() < 0.03,
        "{place}"
    );
    assert_eq!(behind.look.brightest[0].place, None);
    assert!(before.decision(Effect::Ghosts).measure.unwrap() > 0.0);
    assert_eq!(behind.decision(Effect::Ghosts).measure, Some(0.0));
}

/// Veiling glare is a hundredth in an even world, and follows the light on the lens's front elsewhere: before a grey square that
/// fills the picture the world around the square counts, too, by its form factor (Howell, "Radiation Heat Transfer
/// Configuration Factors", B-3: four times that of a corner).
#[test]
fn glare_is_the_lenss_part_of_the_light_on_the_front() {
    let measure = |albedo: Option<f32>, lamp_at: Option<DVec3>| {
        let mut room = scenes::Room { builder: SceneBuilder::new() };
        room.builder.set_world(World { color: Rgb::ONE, ..World::default() }).unwrap();
        if let Some(albedo) = albedo {
            let place = DMat4::from_translation(DVec3::new(0.0, 0.0, -1.0));
            room.put(scenes::square(), scenes::plain(albedo, albedo, albedo), place);
        }
        if let Some(at) = lamp_at {
            room.light(
                scenes::lamp(LampKind::Point { radius: 0.05, soft: false }, 1000.0),
                DMat4::from_translation(at),
            );
        }
        let scattering = Scattering { veiling_index: 0.01, ..Scattering::NONE };
        let d = CameraDescription { scattering, ..triplet() };
        let shot = Shot { stage: room.finish(), d, moving: Vec::new(), size: [300, 200] };
        shot.decision(Effect::Glare).measure.unwrap()
    };
    let form_factor = 4.0 / std::f64::consts::TAU * 2.0f64.sqrt() * (0.5f64.sqrt()).atan();
    // 512 evenly spread samples of a step in the hemisphere: 2 %.
    for (albedo, expected) in
        [(None, 1.0), (Some(0.5f32), (1.0 - 0.5 * form_factor) / 0.5), (Some(0.1), (1.0 - 0.9 * form_factor) / 0.1)]
    {
        let found = measure(albedo, None);
        assert!((found / (0.01 * expected) - 1.0).abs() < 0.02, "{albedo:?}: {found} {expected}");
    }
    // A lamp outside of the picture veils it; behind the camera it does not.
    let [none, aside, behind] =
        [None, Some(DVec3::new(2.0, 0.0, -2.0)), Some(DVec3::new(2.0, 0.0, 2.0))].map(|at| measure(None, at));
    assert!(aside > 2.0 * none && (behind / none - 1.0).abs() < 0.02, "{none} {aside} {behind}");
}

/// A plan does not depend on the number of threads and on how often it is made.
#[test]
fn plans_are_repeated_to_the_bit() {
    let shot = || Shot { stage: scenes::box_under_a_lamp(), d: triplet(), moving: Vec::new(), size: [640, 427] };
    let told = |plan: &Plan| format!("{:?} {:?} {:?} {:?}", plan.decisions, plan.camera, plan.lens, plan.look);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let first = one.install(|| told(&shot().plan(&PlanOptions::default()).unwrap()));
    assert_eq!(first, told(&shot().plan(&PlanOptions::default()).unwrap()));
}
