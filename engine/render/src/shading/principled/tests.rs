//! Every mixture: samples follow their density, energy is conserved, and known limits hold.

use super::*;
use crate::scene::closure::Principled;
use crate::scene::material::Material;

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

/// The albedo by sampling the BSDF equals the albedo by uniform directions: densities and values agree.
#[test]
fn sampled_and_uniform_albedos_agree() {
    for (k, c) in CASES.iter().enumerate() {
        for wo in directions() {
            let b = bsdf(c, wo);
            let n = 1 << 15;
            let sampled: f64 =
                points(n, 3).filter_map(|u| b.sample(u[0], [u[1], u[2]])).map(|s| s.weight.x as f64).sum::<f64>()
                    / n as f64;
            let m = 1 << 20;
            let uniform: f64 = points(m, 5)
                .map(|u| b.evaluate(warp::sample_sphere([u[0], u[1]])).0.x as f64 / warp::SPHERE_PDF as f64)
                .sum::<f64>()
                / m as f64;
            // Uniform directions resolve a lobe of alpha 0.16 to about a percent with 131072 points.
            assert!((sampled - uniform).abs() < 0.02, "case {k} from {wo}: {sampled} {uniform}");
        }
    }
}

/// The density integrates to one over the sphere, less the samples below the horizon.
#[test]
fn densities_do_not_exceed_one() {
    for (k, c) in CASES.iter().enumerate() {
        for wo in directions() {
            let b = bsdf(c, wo);
            let m = 1 << 20;
            let total: f64 = points(m, 9)
                .map(|u| b.evaluate(warp::sample_sphere([u[0], u[1]])).1 as f64 / warp::SPHERE_PDF as f64)
                .sum::<f64>()
                / m as f64;
            let kept = points(1 << 14, 3).filter(|u| b.sample(u[0], [u[1], u[2]]).is_some()).count();
            let expected = kept as f64 / (1 << 14) as f64;
            assert!((total - expected).abs() < 0.02, "case {k} from {wo}: {total} {expected}");
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

/// Pearson's test of every mixture: counts of samples by cell of the sphere against the density's integrals.
#[test]
fn samples_follow_their_density() {
    const ROWS: usize = 12;
    const COLUMNS: usize = 24;
    const FINE: usize = 24;
    let n = 1 << 16;
    for (k, c) in CASES.iter().enumerate() {
        for wo in directions() {
            let b = bsdf(c, wo);
            let mut observed = vec![0u64; ROWS * COLUMNS];
            for u in points(n, 21) {
                if let Some(s) = b.sample(u[0], [u[1], u[2]]) {
                    let row = ((0.5 - 0.5 * s.wi.z) * ROWS as f32) as usize;
                    let turn = s.wi.y.atan2(s.wi.x) / std::f32::consts::TAU + 0.5;
                    let column = (turn * COLUMNS as f32) as usize;
                    observed[row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)] += 1;
                }
            }
            // Even steps of the polar angle resolve lobes at the poles, where even steps of z do not.
            let cell_pdf = |row: usize, column: usize| {
                let theta_of = |row: usize| (1.0 - 2.0 * row as f64 / ROWS as f64).acos();
                let (start, step) = (theta_of(row), (theta_of(row + 1) - theta_of(row)) / FINE as f64);
                let turn = std::f64::consts::TAU / (COLUMNS * FINE) as f64;
                let mut sum = 0.0f64;
                for i in 0..FINE * FINE {
                    let theta = start + ((i / FINE) as f64 + 0.5) * step;
                    let phi = ((column * FINE + i % FINE) as f64 + 0.5) * turn - std::f64::consts::PI;
                    let d = glam::DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                    sum += b.evaluate(d.as_vec3a()).1 as f64 * theta.sin() * step * turn;
                }
                sum
            };
            let expected: Vec<f64> =
                (0..ROWS * COLUMNS).map(|i| cell_pdf(i / COLUMNS, i % COLUMNS) * n as f64).collect();
            // Stratified points scatter less than independent ones, which only raises the value.
            let p = petzval_testkit::chi_square::p_value(&observed, &expected);
            assert!(p > 0.01 / 24.0, "case {k} from {wo}: p = {p}");
        }
    }
}
