//! Rays that leave lights bring the power that lights have, with the densities that are said of them.

use super::*;
use crate::lights::{LightSampleContext, Line};
use crate::scene::lamp::{Lamp, LampKind};
use crate::scene::material::Material;
use crate::scene::mesh::MeshDescription;
use crate::scene::texture::Texture;
use crate::scene::{SceneBuilder, world::World};
use glam::{DMat4, DVec3, Vec3};
use petzval_testkit::sampling::{self, Random};

const WATTS: Rgb = Rgb::new(10.0, 20.0, 30.0);
/// Half of the side of the cube about everything.
const HALF: f32 = 6.0;

/// A black box around the origin to catch the light.
fn shell(builder: &mut SceneBuilder) {
    let positions =
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - Vec3::ONE).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = MeshDescription { name: "cube".into(), positions, triangles, ..Default::default() };
    let mesh = builder.add_mesh(mesh).unwrap();
    let place = DMat4::from_scale(DVec3::splat(f64::from(HALF)));
    builder.add_instance("cube", mesh, place, &[], true, true).unwrap();
}

struct Lit {
    scene: Scene,
    lights: Lights,
    emission: Emission,
}

fn lit(mut builder: SceneBuilder) -> Lit {
    shell(&mut builder);
    let scene = builder.build(DVec3::ZERO);
    let lights = Lights::new(&scene);
    let emission = Emission::new(&scene, &lights, Some((Vec3A::splat(-HALF), Vec3A::splat(HALF))));
    Lit { scene, lights, emission }
}

fn with_lamp(kind: LampKind) -> Lit {
    let mut builder = SceneBuilder::new();
    let lamp = Lamp { object_name: "lamp".into(), kind, color: WATTS, ..Lamp::default() };
    let place = DMat4::from_translation(DVec3::new(0.3, -0.2, 0.5)) * DMat4::from_rotation_x(0.4);
    builder.add_lamp(lamp, place).unwrap();
    lit(builder)
}

fn with_triangles(closed: bool) -> Lit {
    let mut builder = SceneBuilder::new();
    let m = builder.add_material(Material::diffuse("glow", Rgb::ONE, WATTS * 0.1));
    let mut triangles = vec![[0, 2, 1]];
    if closed {
        triangles.extend([[0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    }
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let mesh = MeshDescription { name: "glow".into(), positions, triangles, ..Default::default() };
    let mesh = builder.add_mesh(mesh).unwrap();
    builder.add_instance("glow", mesh, DMat4::IDENTITY, &[m], true, true).unwrap();
    lit(builder)
}

fn with_world(image: bool) -> Lit {
    let mut builder = SceneBuilder::new();
    let texture = image.then(|| {
        let pixels: Vec<f32> =
            (0..32 * 16).flat_map(|i| [if i % 37 == 5 { 20.0 } else { 0.3 }, 0.5, 0.2, 1.0]).collect();
        builder.add_texture(Texture::from_floats("sky", 32, 16, &pixels, false).unwrap()) as u32
    });
    builder.set_world(World { color: WATTS * 0.1, texture, ..Default::default() }).unwrap();
    lit(builder)
}

/// The lights of [`all_kinds`] that no ray can hit.
const POINT_LIKE: &[&str] = &["point", "spot", "sun"];

fn all_kinds() -> Vec<(&'static str, Lit)> {
    let point = |radius, soft| LampKind::Point { radius, soft };
    let spot = |radius, soft| LampKind::Spot { radius, half_angle_rad: 0.7, blend: 0.4, soft };
    let area = |ellipse, half_spread_rad| LampKind::Area { size: [0.8, 0.5], ellipse, half_spread_rad };
    vec![
        ("point", with_lamp(point(0.0, false))),
        ("ball", with_lamp(point(0.3, false))),
        ("soft ball", with_lamp(point(0.3, true))),
        ("spot", with_lamp(spot(0.0, false))),
        ("wide spot", with_lamp(spot(0.2, false))),
        ("soft spot", with_lamp(spot(0.2, true))),
        ("area", with_lamp(area(false, 1.6))),
        ("narrow area", with_lamp(area(false, 0.5))),
        ("ellipse", with_lamp(area(true, 1.2))),
        ("sun", with_lamp(LampKind::Sun { half_angle_rad: 0.0 })),
        ("wide sun", with_lamp(LampKind::Sun { half_angle_rad: 0.2 })),
        ("triangle", with_triangles(false)),
        ("tetrahedron", with_triangles(true)),
        ("even sky", with_world(false)),
        ("image sky", with_world(true)),
    ]
}

/// The first point at which a ray hits a sphere about the origin that holds all lamps: distance and place.
fn at_sphere(ray: &Ray, radius: f32) -> Option<(f32, Vec3A)> {
    let b = ray.origin.dot(ray.direction);
    let c = ray.origin.length_squared() - radius * radius;
    let root = (b * b - c).max(0.0).sqrt();
    if b * b < c {
        return None;
    }
    let t = if c > 0.0 { -b - root } else { -b + root };
    (t > 0.0).then(|| (t, ray.origin + ray.direction * t))
}

/// Irradiance of a sphere about the lights, as a mean over its surface by light samples there, against the light that
/// light paths bring to it. Inside out for lights within, outside in for the sky.
#[test]
fn light_paths_bring_what_light_samples_find() {
    for (name, Lit { scene, lights, emission }) in &all_kinds() {
        if *name == "tetrahedron" {
            // It hides its own far side, which nothing does here.
            continue;
        }
        let from_afar = ["sun", "wide sun", "even sky", "image sky"].contains(name);
        // Most of the sky's rays are to hit it.
        let radius = if from_afar { 9.0 } else { 3.0 };
        // Weighted with the height, so that a wrong direction shows, and the channels unequally, so that a wrong colour does.
        let seen =
            |light: Rgb, p: Vec3A| f64::from(light.dot(Rgb::new(1.0, 2.0, 0.5)) * (1.0 + (p.z + 0.5 * p.x) / radius));
        let by_paths = |random: &mut Random| {
            let [u_light, a, b, c, d] = random.numbers();
            let brought = || {
                let e = emission.sample(scene, lights, u_light, [a, b], [c, d], MIDDLE)?;
                let (t, p) = at_sphere(&e.ray, radius)?;
                let light = emission.arrive(scene, lights, &e, p, t)?;
                Some(seen(light.radiance / light.density, p))
            };
            brought().unwrap_or(0.0)
        };
        let by_samples = |random: &mut Random| {
            let [x, y, u_light, a, b] = random.numbers();
            let p = warp::sample_sphere([x, y]) * radius;
            let (wi, light) = if *name == "even sky" {
                (warp::sample_sphere([a, b]), scene.world.color / warp::SPHERE_PDF)
            } else {
                let to = lights.receiver_between(p);
                match lights.sample(scene, &to, u_light, [a, b], PathState::CAMERA) {
                    Some(s) => (s.wi, s.radiance / s.pdf),
                    None => return 0.0,
                }
            };
            let cos = wi.dot(p / radius) * if from_afar { 1.0 } else { -1.0 };
            seen(light * (cos.max(0.0) * 4.0 * PI * radius * radius), p)
        };
        sampling::means_agree(&format!("light of {name}"), 1 << 18, by_paths, by_samples, 0.0);
    }
}

/// The flux of a lamp through a sphere about it is its power in watts; a triangle's is pi times radiance times area, for either side.
#[test]
fn power_is_that_of_the_lamp() {
    for (name, Lit { scene, lights, emission }) in all_kinds() {
        let expected = match name {
            "point" | "ball" | "area" => WATTS,
            "triangle" => WATTS * (0.1 * PI * 0.5 * 2.0),
            "tetrahedron" => WATTS * (0.1 * PI * (1.5 + 0.75f32.sqrt())),
            _ => continue,
        };
        let n = 1 << 14;
        let mut sum = Rgb::ZERO;
        for i in 0..n {
            let (u, v) = (sobol_burley::sample_4d(i, 0, 5), sobol_burley::sample_4d(i, 0, 6));
            let e = emission.sample(&scene, &lights, u[0], [u[1], u[2]], [u[3], v[0]], MIDDLE).unwrap();
            let (t, p) = at_sphere(&e.ray, 4.0).unwrap();
            let light = emission.arrive(&scene, &lights, &e, p, t).unwrap();
            sum += light.radiance / light.density / n as f32;
        }
        // Every ray brings the same share of the power.
        assert!((sum / expected - Rgb::ONE).abs().max_element() < 5e-3, "{name}: {}", sum / expected);
    }
}

/// The densities of an emitted ray agree with those of a light sample, and of a ray that hits the light, in that direction.
#[test]
fn densities_agree_from_both_ends() {
    for (name, Lit { scene, lights, emission }) in all_kinds() {
        let mut compared = 0;
        for i in 0..2000 {
            let (u, v) = (sobol_burley::sample_4d(i, 0, 7), sobol_burley::sample_4d(i, 0, 8));
            let Some(e) = emission.sample(&scene, &lights, u[0], [u[1], u[2]], [u[3], v[0]], MIDDLE) else { continue };
            let Some((t, p)) = at_sphere(&e.ray, 3.0) else { continue };
            let Some(light) = emission.arrive(&scene, &lights, &e, p, t) else { continue };
            assert!(light.point_like == POINT_LIKE.contains(&name));
            if light.point_like {
                continue;
            }
            let to = lights.receiver_between(p);
            let wi = -e.ray.direction;
            let mut met = None;
            let line = Line { from: p, towards: wi, t_max: f32::INFINITY };
            lights.lamps_along(&scene, line, PathState::BOUNCE, Some(&to), |one| {
                met = Some((one.source, one.radiance, one.pdf))
            });
            if met.is_none() && lights.local.len() == 0 || name.contains("sun") {
                lights.sky_along(&scene, wi, PathState::BOUNCE, Some(&to), |one| {
                    if one.source == e.source {
                        met = Some((one.source, one.radiance, one.pdf));
                    }
                });
            }
            if let Some(Emitter::Triangle(&LitTriangle { instance, triangle, .. })) = lights.local.get(e.source.0) {
                let pdf = lights.triangle_pdf(&scene, &to, (instance, triangle), t, e.cos);
                met = Some((lights.triangle_source(instance, triangle).unwrap(), e.strength, pdf));
            }
            // A ray on a lamp's very rim may pass it.
            let Some((source, radiance, pdf)) = met else { continue };
            compared += 1;
            assert!(source == e.source, "{name}");
            assert!((radiance - light.radiance).abs().max_element() < 0.02 * radiance.max_element(), "{name}");
            assert!((pdf - light.sample_pdf).abs() <= 2e-3 * pdf, "{name}: {pdf} {}", light.sample_pdf);
            let density = emission.density(&scene, &lights, source, wi, t, MIDDLE);
            assert!((density / light.density - 1.0).abs() < 1e-4, "{name}: {density} {}", light.density);
        }
        assert!(POINT_LIKE.contains(&name) || compared > 60, "{name}: {compared}");
    }
}

/// The density with which light samples of `to` take this direction, by the lights that a ray hits.
fn light_sample_pdf(lit: &Lit, to: &LightSampleContext, from: Vec3A, wi: Vec3A) -> f64 {
    let Lit { scene, lights, .. } = lit;
    let mut pdf = 0.0;
    let line = Line { from, towards: wi, t_max: f32::INFINITY };
    lights.lamps_along(scene, line, PathState::BOUNCE, Some(to), |one| pdf += f64::from(one.pdf));
    lights.sky_along(scene, wi, PathState::BOUNCE, Some(to), |one| pdf += f64::from(one.pdf));
    for emitter in lights.local.iter() {
        let Emitter::Triangle(&LitTriangle { instance, triangle, .. }) = emitter else { continue };
        let [a, b, c] = crate::lights::triangle::placed_corners(scene, instance, triangle);
        let area = (b - a).cross(c - a);
        let t = (a - from).dot(area) / wi.dot(area);
        let q = from + wi * t;
        let is_inside = [(a, b), (b, c), (c, a)].iter().all(|(p, q1)| (*q1 - *p).cross(q - *p).dot(area) >= 0.0);
        if t > 0.0 && is_inside {
            let cos = wi.dot(area.normalize()).abs();
            pdf += f64::from(lights.triangle_pdf(scene, to, (instance, triangle), t, cos));
        }
    }
    pdf
}

/// Directions of light samples, of every kind of light, follow the density that rays which hit it are told.
#[test]
fn light_samples_follow_their_density() {
    for (name, lit) in all_kinds().iter().filter(|(name, _)| !POINT_LIKE.contains(name)) {
        for (from, normal) in [
            (Vec3A::new(1.5, -1.0, 2.2), None),
            (Vec3A::new(-0.4, 0.3, -1.5), Some(Vec3A::Z)),
            (Vec3A::new(0.6, 0.9, -0.8), Some(Vec3A::new(0.0, 0.6, 0.8))),
        ] {
            let to = match normal {
                Some(normal) => lit.lights.receiver(from, Some(normal), 0.5),
                None => lit.lights.receiver_between(from),
            };
            sampling::directions(
                &format!("{name} from {from}"),
                1 << 16,
                |random| {
                    let [u_choice, u, v] = random.numbers();
                    let s = lit.lights.sample(&lit.scene, &to, u_choice, [u, v], PathState::CAMERA)?;
                    Some(s.wi.to_array())
                },
                |wi| light_sample_pdf(lit, &to, from, Vec3A::from_array(wi)),
            );
        }
    }
}

/// The density of rays integrates to one: rays of an even density over all etendue that crosses the sphere, weighted.
#[test]
fn densities_integrate_to_one() {
    let radius = 3.0f32;
    for (name, Lit { scene, lights, emission }) in &all_kinds() {
        if !["ball", "area", "ellipse", "triangle", "even sky"].contains(name) {
            continue;
        }
        let estimate = |random: &mut Random| {
            let [a, b, c, d] = random.numbers();
            // A point of the sphere and a cosine-distributed direction inwards: etendue 4 pi r² pi in all.
            let p = warp::sample_sphere([a, b]) * radius;
            let wi = warp::to_world(&warp::frame(-p / radius), warp::sample_cosine_hemisphere([c, d]));
            let density = |source, wi, t| emission.density(scene, lights, source, wi, t, MIDDLE);
            let mut sum = 0.0;
            if *name == "even sky" {
                sum = density(Source(0), -wi, 1.0);
            } else if *name == "triangle" {
                let [a, b, c] = crate::lights::triangle::placed_corners(scene, 0, 0);
                let normal = (b - a).cross(c - a);
                let t = (a - p).dot(normal) / wi.dot(normal);
                let q = p + wi * t;
                if q.x >= 0.0 && q.y >= 0.0 && q.x + q.y <= 1.0 && t > 0.0 {
                    sum = density(Source(0), wi, t);
                }
            } else {
                let line = Line { from: p, towards: wi, t_max: f32::INFINITY };
                lights.lamps_along(scene, line, PathState::BOUNCE, None, |one| {
                    // Beyond its spread a lamp is dark, and no ray is chosen.
                    if one.radiance != Rgb::ZERO {
                        sum += density(one.source, wi, 1.0);
                    }
                });
            }
            f64::from(sum * 4.0 * PI * PI * radius * radius)
        };
        // The sky's disk is that of the whole scene's ball: the sphere's share of it.
        let expected = if *name == "even sky" { f64::from((radius / emission.radius).powi(2)) } else { 1.0 };
        sampling::mean_is(&format!("density of rays of {name}"), 1 << 20, estimate, expected, 1e-6 * expected);
    }
}
