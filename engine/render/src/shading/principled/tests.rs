//! Every mixture: samples follow their density, energy is conserved, and known limits hold.

use super::*;
use crate::scene::closure::Principled;
use crate::scene::material::Material;
use petzval_testkit::sampling;

struct Case {
    metallic: f32,
    roughness: f32,
    transmission: f32,
    base: f32,
    backfacing: bool,
}

const fn case(metallic: f32, roughness: f32, transmission: f32, base: f32, backfacing: bool) -> Case {
    Case { metallic, roughness, transmission, base, backfacing }
}

const CASES: [Case; 8] = [
    case(0.0, 0.5, 0.0, 0.8, false),
    case(0.0, 1.0, 0.0, 1.0, false),
    case(1.0, 0.4, 0.0, 1.0, false),
    case(1.0, 1.0, 0.0, 1.0, false),
    case(0.0, 0.4, 1.0, 1.0, false),
    case(0.0, 0.4, 1.0, 1.0, true),
    case(0.0, 0.8, 1.0, 1.0, true),
    case(0.3, 0.6, 0.5, 0.7, false),
];

/// Values and tables of a material that is plain and spatially constant.
fn plain(material: Material) -> (PlainValues, PrincipledTables) {
    let plain = material.graph.plain.as_ref().unwrap();
    (plain.constants.unwrap(), PrincipledTables::new(plain, Arc::new(AlbedoTable::reflection())))
}

fn bsdf(c: &Case, wo: Vec3A) -> Bsdf {
    let (values, tables) = plain(Material::principled(
        "case",
        Principled {
            base_color: Rgb::splat(c.base),
            metallic: c.metallic,
            roughness: c.roughness,
            transmission: c.transmission,
            ..Principled::default()
        },
    ));
    let point = SurfacePoint {
        position: Vec3A::ZERO,
        position_error: 0.0,
        geometric_normal: Vec3A::Z,
        shading_normal: Vec3A::Z,
        backfacing: c.backfacing,
        instance: 0,
        triangle: 0,
        material: 0,
        barycentric: [0.3, 0.3],
        strand: crate::surface::NO_STRAND,
        moment: 0,
    };
    Bsdf::new(&tables, &values, &point, wo)
}

fn directions() -> [Vec3A; 3] {
    [[0.1, 0.0, 1.0], [0.7, -0.3, 0.6], [0.9, 0.2, 0.2]].map(|d| Vec3A::from_array(d).normalize())
}

fn points(n: u32, seed: u32) -> impl Iterator<Item = [f32; 4]> {
    (0..n).map(move |i| sobol_burley::sample_4d(i & 0xffff, 0, seed + 1000 * (i >> 16)))
}

/// The albedo by samples of the BSDF is the integral of its values: densities and values agree.
#[test]
fn sampled_albedos_are_integrals() {
    for (k, c) in CASES.iter().enumerate() {
        for wo in directions() {
            let b = bsdf(c, wo);
            sampling::mean_is(
                &format!("albedo of plain Principled {k} from {wo}"),
                1 << 17,
                |random| {
                    let [u_choice, u, v] = random.numbers();
                    b.sample(u_choice, [u, v]).map_or(0.0, |s| s.weight.x.into())
                },
                sampling::over_directions(|wi| b.evaluate(Vec3A::from_array(wi)).0.x.into()),
                // Of the integral.
                1e-4,
            );
        }
    }
}

/// White metal and white glass give back all light at any roughness (the multiple-scattering correction); a
/// white diffuse base under its coat nearly all.
#[test]
fn white_surfaces_keep_their_energy() {
    for (k, c) in CASES.iter().enumerate().filter(|(_, c)| c.base == 1.0) {
        for wo in directions() {
            let b = bsdf(c, wo);
            let n = 1 << 14;
            let albedo =
                points(n, 3).filter_map(|u| b.sample(u[0], [u[1], u[2]])).map(|s| s.weight.x as f64).sum::<f64>()
                    / n as f64;
            // Sixteen-step tables; a coat is not restored where light passes it twice.
            assert!((albedo - 1.0).abs() < 0.025, "case {k} from {wo}: {albedo}");
        }
    }
}

/// A surface without coat.
fn uncoated(wo: Vec3A) -> Bsdf {
    let (values, tables) = plain(Material::diffuse("uncoated", Rgb::splat(0.8), Rgb::ZERO));
    let point = SurfacePoint {
        position: Vec3A::ZERO,
        position_error: 0.0,
        geometric_normal: Vec3A::Z,
        shading_normal: Vec3A::new(0.2, -0.1, 1.0).normalize(),
        backfacing: false,
        instance: 0,
        triangle: 0,
        material: 0,
        barycentric: [0.3, 0.3],
        strand: crate::surface::NO_STRAND,
        moment: 0,
    };
    Bsdf::new(&tables, &values, &point, wo)
}

/// A plain Lambert surface is that, and its samples follow its density.
#[test]
fn without_coat_it_is_lambert() {
    let (n, wi) = (Vec3A::new(0.2, -0.1, 1.0).normalize(), Vec3A::new(0.6, 0.0, 0.8));
    let value = uncoated(Vec3A::Z).evaluate(wi).0.x;
    assert!((value - 0.8 * n.dot(wi) * FRAC_1_PI).abs() < 1e-6);
    let coated = bsdf(&case(0.0, 0.5, 0.0, 0.8, false), Vec3A::Z).evaluate(wi).0.x;
    assert!((coated - value).abs() > 1e-3);
    for wo in directions() {
        let b = uncoated(wo);
        // Below the triangle the light ends, though the interpolated normal still sees it.
        assert_eq!(b.evaluate(Vec3A::new(0.995, 0.0, -0.0998)), (Rgb::ZERO, 0.0));
        let samples: Vec<BsdfSample> = points(1000, 1).filter_map(|u| b.sample(u[0], [u[1], u[2]])).collect();
        assert!(samples.len() > 900);
        for s in samples {
            let (value, pdf) = b.evaluate(s.wi);
            // Roundings on the way to the world's axes and back.
            assert!((s.pdf - pdf).abs() < 1e-6 && (s.weight * s.pdf - value).abs().max_element() < 1e-6);
        }
    }
}

/// Smooth glass sends every ray where Snell and the mirror say, never below the wrong side.
#[test]
fn smooth_glass_is_a_mirror_lobe() {
    let b = bsdf(&case(0.0, 0.0, 1.0, 1.0, false), Vec3A::new(0.6, 0.0, 0.8));
    assert!(b.is_mirror());
    let mut through = 0;
    for u in points(1000, 1) {
        let s = b.sample(u[0], [u[1], u[2]]).unwrap();
        assert!(s.mirror && (s.weight.x - 1.0).abs() < 1e-3);
        if s.transmitted {
            through += 1;
            assert!((s.wi.x + 0.4).abs() < 1e-5 && s.wi.z < 0.0, "{}", s.wi);
        } else {
            assert!((s.wi - Vec3A::new(-0.6, 0.0, 0.8)).length() < 1e-5);
        }
    }
    let expected = 1.0 - fresnel::dielectric(0.8, 1.5);
    assert!((through as f32 / 1000.0 - expected).abs() < 0.01);
}

/// Directions of samples follow the density that is said of them.
#[test]
fn samples_follow_their_density() {
    for (k, c) in CASES.iter().enumerate() {
        for wo in directions() {
            let b = bsdf(c, wo);
            sampling::directions(
                &format!("plain Principled {k} from {wo}"),
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
