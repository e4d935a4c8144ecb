use std::collections::HashMap;

use super::*;
use crate::exact::{Shape, Status, trace};

/// FNV-1a over every number of the first rays of each category. Changes with any change of a generator: then tables
/// made with the old rays are no longer of these.
const CHECKSUM: u64 = 0x57e9_a80b_2212_0c56;

#[test]
fn the_rays_are_the_same_everywhere() {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut add = |bits: u64| {
        for byte in bits.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for category in Category::ALL {
        for index in 0..200 {
            let mut case = category.case(1, index);
            case.for_each_number(|x| add(x.to_bits()));
            add(u64::from(case.mirror));
            case.shape.profile().terms.iter().for_each(|(power, _)| add(u64::from(*power)));
        }
    }
    assert_eq!(hash, CHECKSUM, "{hash:#x}");
}

#[test]
fn every_number_is_finite_and_every_direction_of_unit_length() {
    for category in Category::ALL {
        for index in 0..3000 {
            let case = category.case(2, index);
            assert!(case.is_finite(), "{} {index}: {case:?}", category.name());
            let squared: f64 = case.direction.iter().map(|x| x * x).sum();
            assert!((squared - 1.0).abs() < 1e-15, "{} {index}", category.name());
            assert!(case.side.abs() == 1.0 && case.n1 > 0.5 && case.n2 > 0.5);
            let mut single = case.as_f32();
            assert!(single.is_finite());
            assert_eq!(single, single.as_f32());
            single.for_each_number(|x| assert_eq!(*x, f64::from(*x as f32)));
        }
    }
}

#[test]
fn names_are_distinct() {
    let names: std::collections::HashSet<_> = Category::ALL.iter().map(|c| c.name()).collect();
    assert_eq!(names.len(), Category::ALL.len());
}

/// The statuses that must occur among the rays of a category, beside rays that pass.
fn expected(category: Category) -> &'static [Status] {
    use Status::{Missed, Obstructed, OutsideAperture, TotalInternalReflection as Total, WrongSheet};
    match category {
        Category::Ordinary | Category::Rim => &[OutsideAperture, Obstructed, Total],
        Category::NearCritical | Category::NearIndex | Category::BallRear | Category::OnSurface => &[Total],
        Category::ConicConstant | Category::Radius | Category::FarStart => &[Total],
        Category::Tangent | Category::FarSheet | Category::NoLeadingTerm => &[Missed, WrongSheet, Total],
        Category::Mirror => &[OutsideAperture, Obstructed],
        Category::MicroLens | Category::MetreLens | Category::Backward | Category::BeyondRightAngle => {
            &[OutsideAperture, Total]
        }
        Category::Asphere | Category::StrongAsphere | Category::Toroid | Category::Cylinder => {
            &[OutsideAperture, Total]
        }
    }
}

#[test]
fn every_category_has_a_mix_of_outcomes() {
    const RAYS: u64 = 2000;
    for category in Category::ALL {
        let mut counts: HashMap<Status, u64> = HashMap::new();
        for index in 0..RAYS {
            *counts.entry(trace(&category.case(7, index)).status).or_default() += 1;
        }
        let of = |status: &Status| counts.get(status).copied().unwrap_or(0);
        let passing = of(&Status::Ok) as f64 / RAYS as f64;
        assert!((0.1..0.95).contains(&passing), "{}: {counts:?}", category.name());
        assert!(expected(category).iter().all(|status| of(status) > 0), "{}: {counts:?}", category.name());
        // Half of what nears a border lies on either side of it.
        let half = match category {
            Category::NearCritical => Some(Status::TotalInternalReflection),
            Category::Tangent => Some(Status::Missed),
            _ => None,
        };
        if let Some(status) = half {
            let share = of(&status) as f64 / RAYS as f64;
            assert!((0.4..0.6).contains(&share), "{}: {counts:?}", category.name());
        }
    }
}

/// The nearest and the farthest of `size` over some rays lie beyond these.
fn spans(category: Category, nearest: f64, farthest: f64, size: impl Fn(&Case) -> f64) {
    let sizes: Vec<f64> = (0..2000).map(|i| size(&category.case(9, i))).collect();
    let least = sizes.iter().copied().fold(f64::INFINITY, f64::min);
    let most = sizes.iter().copied().fold(0.0, f64::max);
    assert!(least < nearest && most > farthest, "{}: {least:e} to {most:e}", category.name());
}

#[test]
fn categories_span_what_they_say() {
    let conic = |case: &Case| match case.shape {
        Shape::Conic { curvature, conic } => (curvature, conic),
        _ => panic!("not a conic: {case:?}"),
    };
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    spans(Category::ConicConstant, 3e-3, 3e5, |case| conic(case).1.abs());
    spans(Category::Radius, 3e-3, 3e14, |case| 1.0 / conic(case).0.abs());
    spans(Category::MicroLens, 1.1e-4, 0.9e-2, |case| 1.0 / conic(case).0.abs());
    spans(Category::MetreLens, 1.1e3, 0.9e5, |case| 1.0 / conic(case).0.abs());
    spans(Category::FarStart, 1.0, 3e9, |case| length(case.origin));
    spans(Category::NearIndex, 3e-15, 3e-2, |case| (case.n2 / case.n1 - 1.0).abs());
    // Distances from a border, as the truth has them.
    let critical = |case: &Case| trace(case).hit.map_or(1.0, |hit| hit.radicand.map_or(1.0, |r| r.to_f64().abs()));
    spans(Category::NearCritical, 1e-14, 1e-2, critical);
    let tangent = |case: &Case| trace(case).discriminant.map_or(1.0, |q| q.to_f64().abs());
    spans(Category::Tangent, 1e-14, 1e-2, tangent);
    let rim = |case: &Case| trace(case).margins.aperture.abs().min(1.0);
    spans(Category::Rim, 1e-14, 1e-5, rim);
    for index in 0..500 {
        let backward = Category::Backward.case(9, index);
        assert!(backward.side < 0.0 && backward.direction[2] < 0.0);
        let beyond = Category::BeyondRightAngle.case(9, index);
        assert!(beyond.side > 0.0 && beyond.direction[2] < 0.0);
    }
}
