//! Every closure: samples follow their density, energy is conserved, and symmetric closures are so; and a Principled of the
//! common kind is the same as a mixture and by its own shorter way.

use super::*;
use crate::sampler::warp;
use crate::scene::closure::{Principled, ThinFilm};
use crate::scene::material::Material;
use crate::shading::principled::{Bsdf, PrincipledTables};
use petzval_testkit::sampling;

type Values = Closure<Rgb, f32>;

const NO_FILM: ThinFilm<f32> = ThinFilm { thickness_nm: 0.0, ior: 1.33 };
const BLUISH: Rgb = Rgb::new(0.3, 0.6, 0.9);

fn glossy(roughness: f32, anisotropy: f32, distribution: Distribution) -> Values {
    Closure::Glossy { color: Rgb::ONE, roughness, anisotropy, rotation: 0.1, distribution }
}

fn metal_of(kind: MetalKind, [base, edge]: [Rgb; 2], roughness: f32, anisotropy: f32) -> Values {
    let distribution = Distribution::MultiscatterGgx;
    Closure::Metal { base, edge, kind, roughness, anisotropy, rotation: 0.0, distribution, film: NO_FILM }
}

fn glass(roughness: f32, ior: f32, distribution: Distribution) -> Values {
    Closure::Glass { color: Rgb::ONE, roughness, ior, distribution, film: NO_FILM }
}

/// Principled as Blender's node starts, but white.
fn plain() -> Principled<Rgb, f32> {
    Principled { base_color: Rgb::ONE, subsurface_radius: Rgb::ONE, ..Principled::default() }
}

/// A white mixture: it gives back all light where `keeps` is set; `reverses` where light takes a path both ways alike.
struct Case {
    name: &'static str,
    closures: Vec<(f32, Values)>,
    keeps: bool,
    reverses: bool,
}

fn cases() -> Vec<Case> {
    use Distribution::{AshikhminShirley, Beckmann, Ggx, MultiscatterGgx};
    let one = |name, closure, keeps, reverses| Case { name, closures: vec![(1.0, closure)], keeps, reverses };
    let gold = [Rgb::new(0.14, 0.37, 1.44), Rgb::new(3.98, 2.39, 1.6)];
    vec![
        one("lambert", Closure::Diffuse { color: Rgb::ONE, roughness: 0.0 }, true, true),
        one("oren-nayar", Closure::Diffuse { color: Rgb::ONE, roughness: 0.8 }, true, true),
        one("translucent", Closure::Translucent { color: Rgb::ONE }, true, true),
        one("ggx", glossy(0.5, 0.0, Ggx), false, true),
        one("stretched ggx", glossy(0.6, 0.6, Ggx), false, true),
        one("ggx of many bounces", glossy(0.7, 0.0, MultiscatterGgx), true, false),
        one("beckmann", glossy(0.5, -0.4, Beckmann), false, true),
        one("ashikhmin-shirley", glossy(0.6, 0.4, AshikhminShirley), false, true),
        one("metal", metal_of(MetalKind::Tinted, [BLUISH, Rgb::ONE], 0.6, 0.7), false, false),
        one("white metal", metal_of(MetalKind::Tinted, [Rgb::ONE; 2], 0.8, 0.0), true, false),
        one("gold", metal_of(MetalKind::Conductor, gold, 0.5, 0.0), false, false),
        one("glass", glass(0.5, 1.5, Ggx), false, false),
        one("glass of many bounces", glass(0.6, 1.45, MultiscatterGgx), true, false),
        one("beckmann glass", glass(0.5, 1.3, Beckmann), false, false),
        one(
            "refraction",
            Closure::Refraction { color: Rgb::ONE, roughness: 0.5, ior: 1.4, distribution: Ggx },
            false,
            false,
        ),
        one("microfiber", Closure::Microfiber { color: Rgb::ONE, roughness: 0.4 }, false, false),
        one("velvet", Closure::Velvet { color: Rgb::ONE, sigma: 0.6 }, false, false),
        one("toon", Closure::Toon { color: Rgb::ONE, size: 0.5, smooth: 0.2, glossy: false }, false, false),
        one("glossy toon", Closure::Toon { color: Rgb::ONE, size: 0.3, smooth: 0.2, glossy: true }, false, false),
        one("principled", Closure::Principled(plain()), true, false),
        one(
            "all of principled",
            Closure::Principled(Principled {
                metallic: 0.2,
                transmission: 0.3,
                coat_weight: 0.7,
                coat_roughness: 0.3,
                coat_tint: BLUISH,
                sheen_weight: 0.5,
                anisotropic: 0.5,
                diffuse_roughness: 0.5,
                specular_tint: BLUISH,
                ..plain()
            }),
            false,
            false,
        ),
        Case {
            name: "diffuse, glossy and translucent",
            closures: vec![
                (0.5, Closure::Diffuse { color: BLUISH, roughness: 0.0 }),
                (0.3, glossy(0.4, 0.0, Ggx)),
                (0.2, Closure::Translucent { color: Rgb::ONE }),
            ],
            keeps: false,
            reverses: true,
        },
    ]
}

fn point(backfacing: bool) -> SurfacePoint {
    SurfacePoint {
        position: Vec3A::ZERO,
        position_error: 0.0,
        geometric_normal: Vec3A::Z,
        shading_normal: Vec3A::Z,
        backfacing,
        instance: 0,
        triangle: 0,
        material: 0,
        barycentric: [0.3, 0.3],
        strand: crate::surface::NO_STRAND,
        moment: 0,
    }
}

fn mixture(case: &Case, wo: Vec3A) -> Mixture {
    let mut mixture = Mixture::new(&point(false), wo, Vec3A::X, true);
    for (weight, closure) in &case.closures {
        mixture.add(*weight, closure, Vec3A::Z);
    }
    mixture.finish(1.0);
    mixture
}

fn directions() -> [Vec3A; 3] {
    [[0.1, 0.0, 1.0], [0.7, -0.3, 0.6], [0.9, 0.2, 0.3]].map(|d| Vec3A::from_array(d).normalize())
}

fn points(n: u32, seed: u32) -> impl Iterator<Item = [f32; 4]> {
    (0..n).map(move |i| sobol_burley::sample_4d(i & 0xffff, 0, seed + 1000 * (i >> 16)))
}

/// The albedo by the mixture's own samples.
fn albedo(mixture: &Mixture) -> f64 {
    let n = 1 << 14;
    let sum: f64 = points(n, 3)
        .filter_map(|u| mixture.sample(u[0], [u[1], u[2]]))
        .map(|s| f64::from(s.weight.element_sum() / 3.0))
        .sum();
    sum / f64::from(n)
}

/// Directions of samples follow the density that is said of them.
#[test]
fn samples_follow_their_density() {
    for case in cases() {
        for wo in directions() {
            let b = mixture(&case, wo);
            sampling::directions(
                &format!("{} from {wo}", case.name),
                1 << 17,
                |random| {
                    let [u_choice, u, v] = random.numbers();
                    b.sample(u_choice, [u, v]).map(|s| s.wi.to_array())
                },
                |wi| b.evaluate(Vec3A::from_array(wi)).1.into(),
            );
        }
    }
}

/// The albedo by the mixture's own samples is the integral of its values: values and densities belong together.
#[test]
fn sampled_albedos_are_integrals() {
    for case in cases() {
        for wo in directions() {
            let b = mixture(&case, wo);
            let mean = |light: Rgb| f64::from(light.element_sum() / 3.0);
            sampling::mean_is(
                &format!("albedo of {} from {wo}", case.name),
                1 << 17,
                |random| {
                    let [u_choice, u, v] = random.numbers();
                    b.sample(u_choice, [u, v]).map_or(0.0, |s| mean(s.weight))
                },
                sampling::over_directions(|wi| mean(b.evaluate(Vec3A::from_array(wi)).0)),
                // Of the integral, where a lobe is cut off.
                1e-3,
            );
        }
    }
}

/// White closures give back all light, by quadrature.
#[test]
fn white_closures_keep_all_light() {
    for case in cases().iter().filter(|case| case.keeps) {
        for wo in directions() {
            let b = mixture(case, wo);
            let light = sampling::over_directions(|wi| b.evaluate(Vec3A::from_array(wi)).0.y.into());
            // What is no formula but a table of albedos has the table's steps: 6e-4 here at most.
            let most = if ["lambert", "oren-nayar", "translucent"].contains(&case.name) { 1e-4 } else { 1e-3 };
            assert!((light - 1.0).abs() < most, "{} from {wo}: {light}", case.name);
        }
    }
}

/// Albedos of metals, for the passes of colour, agree with the light that they scatter.
#[test]
fn metals_know_their_albedo() {
    let (gold, edge) = (Rgb::new(0.9, 0.6, 0.3), Rgb::new(0.5, 0.8, 1.0));
    let (n, k) = (Rgb::new(0.18, 0.42, 1.37), Rgb::new(3.4, 2.4, 1.8));
    for (kind, base, edge) in
        [(MetalKind::Tinted, gold, Rgb::ONE), (MetalKind::Tinted, gold, edge), (MetalKind::Conductor, n, k)]
    {
        for roughness in [0.2, 0.5, 0.9] {
            for wo in directions() {
                let mut b = Mixture::new(&point(false), wo, Vec3A::X, true);
                b.add(1.0, &metal_of(kind, [base, edge], roughness, 0.0), Vec3A::Z);
                b.finish(1.0);
                let n = 1 << 14;
                let scattered =
                    points(n, 3).filter_map(|u| b.sample(u[0], [u[1], u[2]])).fold(Rgb::ZERO, |sum, s| sum + s.weight)
                        / n as f32;
                let [_, said, _] = b.albedos();
                // The steps of the tables.
                assert!((said - scattered).abs().max_element() < 0.01, "{kind:?} {roughness} {wo}: {said} {scattered}");
            }
        }
    }
}

/// Nothing gives back more light than it gets; a white closure with multiple scattering between facets gives back all.
#[test]
fn no_closure_makes_light() {
    for case in cases() {
        for wo in directions() {
            let found = albedo(&mixture(&case, wo));
            // The tables' steps, and what is lost where light passes a dielectric twice.
            assert!(found < 1.012, "{} from {wo}: {found}", case.name);
            if case.keeps {
                assert!(found > 0.975, "{} from {wo}: {found}", case.name);
            }
        }
    }
}

/// Light takes a path both ways alike, wherever the closure is symmetric.
#[test]
fn symmetric_closures_reverse() {
    for case in cases().iter().filter(|case| case.reverses) {
        let mut seen = 0;
        for u in points(256, 8) {
            let wo = warp::sample_cosine_hemisphere([u[0], u[1]]);
            let wi = warp::sample_cosine_hemisphere([u[2], u[3]]);
            let one = mixture(case, wo).evaluate(wi).0 / wi.z;
            let other = mixture(case, wi).evaluate(wo).0 / wo.z;
            // A few roundings, of terms that cancel where both directions graze.
            let apart = (one - other).abs().max_element() / one.max_element().max(1e-3);
            assert!(apart < 2e-3, "{}: {one} {other} along {wo} {wi}", case.name);
            seen += u32::from(one != Rgb::ZERO);
        }
        assert!(seen > 100 || case.name == "translucent", "{}: {seen}", case.name);
    }
}

/// A surface that has a shorter way in [`crate::shading::principled`] is the same surface as a mixture.
#[test]
fn plain_principled_is_the_same_both_ways() {
    for (metallic, transmission, roughness) in
        [(0.0, 0.0, 0.5), (1.0, 0.0, 0.3), (0.4, 0.0, 0.7), (0.0, 1.0, 0.4), (0.0, 0.6, 0.6)]
    {
        let base_color = Rgb::new(0.9, 0.6, 0.3);
        let principled = Principled { base_color, metallic, transmission, roughness, ..plain() };
        let material = Material::principled("plain", principled);
        let plain = material.graph.plain.as_ref().unwrap();
        let (tables, values) = (PrincipledTables::new(plain, energy::reflection().clone()), plain.constants.unwrap());
        let views = directions().into_iter().flat_map(|d| [(d, false, 0.0), (d, true, 0.0), (d, false, 0.4)]);
        for (wo, backfacing, least_alpha) in views {
            let mut short = Bsdf::new(&tables, &values, &point(backfacing), wo);
            let mut long = Mixture::new(&point(backfacing), wo, Vec3A::X, true);
            long.add(1.0, &Closure::Principled(principled), Vec3A::Z);
            long.finish(1.0);
            if least_alpha > 0.0 {
                short.widen(least_alpha);
                long.widen(least_alpha);
            }
            for u in points(64, 2) {
                let wi = warp::sample_sphere([u[0], u[1]]);
                let (a, b) = (short.evaluate(wi).0, long.evaluate(wi).0);
                // Tables between steps of the index, and steps of roughness between two tables.
                assert!(
                    (a - b).abs().max_element() <= 0.01 * a.max_element() + 1e-4,
                    "{principled:?} {wo} {wi}: {a} {b}"
                );
            }
        }
    }
}

/// Facets that are made wide scatter as those that are so by themselves, mirrors among them; wider ones stay as they are.
#[test]
fn facets_are_made_wide() {
    use Distribution::{AshikhminShirley, Beckmann, Ggx};
    let refraction = |roughness, distribution| Closure::Refraction { color: BLUISH, roughness, ior: 1.4, distribution };
    let of = |roughness: f32| {
        [
            glossy(roughness, 0.0, Ggx),
            glossy(roughness, 0.0, Beckmann),
            glossy(roughness, 0.0, AshikhminShirley),
            glass(roughness, 1.5, Ggx),
            refraction(roughness, Ggx),
            refraction(roughness, Beckmann),
        ]
    };
    let made = |closure: &Values, wo: Vec3A| {
        let mut mixture = Mixture::new(&point(false), wo, Vec3A::X, true);
        mixture.add(1.0, closure, Vec3A::Z);
        mixture.finish(1.0);
        mixture
    };
    for (own, expected) in [(0.0, 0.6), (0.3, 0.6), (0.7, 0.7)] {
        for (narrow, wide) in of(own).iter().zip(&of(expected)) {
            for wo in directions() {
                let (mut widened, wide) = (made(narrow, wo), made(wide, wo));
                widened.widen(0.36);
                assert!(!widened.is_mirror());
                for u in points(64, 2) {
                    let wi = warp::sample_sphere([u[0], u[1]]);
                    let ((a, p), (b, q)) = (widened.evaluate(wi), wide.evaluate(wi));
                    let apart = (a - b).abs().max_element().max((p - q).abs());
                    assert!(apart <= 1e-4 * p.max(1.0), "{narrow:?} {wo} {wi}: {a} {b}, {p} {q}");
                }
            }
        }
    }
}

/// Smooth glass and mirrors send light in single directions, and a path from the light is told the same of them.
#[test]
fn mirrors_are_single_directions() {
    let case = Case {
        name: "",
        closures: vec![(0.7, glass(0.0, 1.5, Distribution::Ggx)), (0.3, glossy(0.0, 0.0, Distribution::Ggx))],
        keeps: true,
        reverses: false,
    };
    let wo = Vec3A::new(0.6, 0.0, 0.8);
    let b = mixture(&case, wo);
    assert!(b.is_mirror() && b.evaluate(Vec3A::new(-0.6, 0.0, 0.8)) == (Rgb::ZERO, 0.0));
    let (mut through, mut total) = (0.0, 0.0);
    for u in points(4096, 1) {
        let s = b.sample(u[0], [u[1], u[2]]).unwrap();
        assert!(s.mirror);
        let expected =
            if s.transmitted { Vec3A::new(-0.4, 0.0, -(1.0f32 - 0.16).sqrt()) } else { Vec3A::new(-0.6, 0.0, 0.8) };
        assert!((s.wi - expected).length() < 1e-5);
        let (value, chance) = b.mirror(s.transmitted, s.wi);
        assert!(value.x > 0.0 && chance > 0.0);
        total += s.weight.x / 4096.0;
        through += if s.transmitted { s.weight.x / 4096.0 } else { 0.0 };
    }
    let passes = 1.0 - fresnel::dielectric(0.8, 1.5);
    assert!((total - 1.0).abs() < 1e-3 && (through - 0.7 * passes).abs() < 0.01, "{total} {through}");
}
