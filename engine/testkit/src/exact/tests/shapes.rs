//! Shapes that coincide, and the invariants of every ray that passes.

use super::super::big::{dot, times};
use super::super::inputs::Inputs;
use super::super::{Big, Case, Profile, Shape, Status, Truth, Vector, norm, trace, trace_from};
use crate::hard_rays::Category;

fn is_zero(x: &Big, scale: f64) -> bool {
    x.abs() < Big::new(scale * 1e-80)
}

fn is_same(a: &Truth, b: &Truth) -> bool {
    let is_near = |a: &Vector, b: &Vector| (0..3).all(|i| is_zero(&(&a[i] - &b[i]), 1e3));
    a.status == b.status
        && match (&a.hit, &b.hit) {
            (Some(a), Some(b)) => is_zero(&(&a.t - &b.t), 1e3) && is_near(&a.normal, &b.normal),
            (None, None) => true,
            _ => false,
        }
        && match (&a.direction, &b.direction) {
            (Some(a), Some(b)) => is_near(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
}

/// Ordinary conic rays, and the profile of the conic.
fn conics() -> impl Iterator<Item = (Case, Profile)> {
    (0..60).map(|i| Category::Ordinary.case(3, i)).map(|case| (case.clone(), case.shape.profile()))
}

#[test]
fn an_asphere_without_terms_is_a_conic() {
    for (case, profile) in conics() {
        let asphere = Case { shape: Shape::Asphere(profile), ..case.clone() };
        assert!(is_same(&trace(&asphere), &trace(&case)), "{case:?}");
    }
}

#[test]
fn a_square_term_is_a_paraboloid() {
    for (case, Profile { curvature, .. }) in conics() {
        let paraboloid = Case { shape: Shape::Conic { curvature, conic: -1.0 }, ..case.clone() };
        let terms = vec![(2, curvature / 2.0)];
        let profile = Profile { curvature: 0.0, conic: 0.0, terms };
        let asphere = Case { shape: Shape::Asphere(profile), ..case };
        assert!(is_same(&trace(&asphere), &trace(&paraboloid)), "{asphere:?}");
    }
}

#[test]
fn a_circle_turned_about_its_centre_is_a_sphere() {
    for (case, Profile { curvature, .. }) in conics() {
        let sphere = Case { shape: Shape::Conic { curvature, conic: 0.0 }, ..case.clone() };
        let profile = Profile { curvature, ..Profile::default() };
        let toroid = Case { shape: Shape::Toroid { profile, curvature_x: curvature }, ..case };
        assert!(is_same(&trace(&toroid), &trace(&sphere)), "{toroid:?}");
    }
}

#[test]
fn a_cylinder_is_a_sphere_in_its_section() {
    for (case, Profile { curvature, .. }) in conics() {
        for across in [0, 1] {
            let mut case = case.clone();
            case.origin[across] = 0.0;
            case.direction[across] = 0.0;
            let profile = Profile { curvature: if across == 0 { curvature } else { 0.0 }, ..Profile::default() };
            let curvature_x = if across == 0 { 0.0 } else { curvature };
            let cylinder = Case { shape: Shape::Toroid { profile, curvature_x }, ..case.clone() };
            let sphere = Case { shape: Shape::Conic { curvature, conic: 0.0 }, ..case };
            let (found, expected) = (trace(&cylinder), trace(&sphere));
            // Where a sphere has an end, a cylinder along x has one, too, but another may be none.
            if expected.hit.is_some() {
                assert!(is_same(&found, &expected), "{cylinder:?}");
            }
        }
    }
}

#[test]
fn the_gradient_is_the_change_of_the_function() {
    let step = Big::new(1e-30);
    for category in Category::ALL {
        for index in 0..10 {
            let inputs = Inputs::new(&category.case(5, index));
            let Some(hit) = trace(&inputs.case).hit else { continue };
            let size = norm(&hit.point).to_f64() + 1.0;
            let at = inputs.surface.at(&hit.point).unwrap();
            assert!(is_zero(&at.value, size * size), "{} {index}", category.name());
            // At a hit so far away that nothing is left of the digits, or at the end of a profile, this says nothing.
            if size > 1e6 {
                continue;
            }
            for i in 0..3 {
                let value = |step: &Big| {
                    let mut point = hit.point.clone();
                    point[i] = &point[i] + step;
                    inputs.surface.at(&point).map(|at| at.value)
                };
                let (Some(above), Some(below)) = (value(&step), value(&-&step)) else { continue };
                let change = (above - below) / step.times_power_of_two(1);
                let error = (change - &at.gradient[i]).abs();
                assert!(error < Big::new(1e-40) * norm(&at.gradient), "{} {index}", category.name());
            }
        }
    }
}

#[test]
fn what_passes_obeys_the_law() {
    for category in Category::ALL {
        for index in 0..100 {
            let inputs = Inputs::new(&category.case(6, index));
            let truth = trace(&inputs.case);
            let (Some(out), Some(hit)) = (&truth.direction, &truth.hit) else { continue };
            let context = || format!("{} {index}", category.name());
            assert_eq!(truth.status, Status::Ok);
            assert!(is_zero(&(dot(out, out) - Big::new(1.0)), 1.0), "{}", context());
            // n D × N stays, and so does the side, but for mirrors.
            let along = |d: &Vector| dot(d, &hit.normal);
            let tangential = |d: &Vector, n: &Big| {
                let normal = times(&hit.normal, &along(d));
                times(&[0, 1, 2].map(|i| &d[i] - &normal[i]), n)
            };
            let is_mirror = inputs.case.mirror;
            let before = tangential(&inputs.direction, &inputs.n1);
            let after = tangential(out, if is_mirror { &inputs.n1 } else { &inputs.n2 });
            assert!((0..3).all(|i| is_zero(&(&before[i] - &after[i]), 10.0)), "{}", context());
            let side = if is_mirror { -inputs.case.side } else { inputs.case.side };
            assert!(!(along(out) * Big::new(side)).is_negative(), "{}", context());
        }
    }
}

#[test]
fn what_is_aimed_at_is_met() {
    for category in [Category::Asphere, Category::StrongAsphere, Category::Toroid, Category::Cylinder] {
        for index in 0..200 {
            let case = category.case(8, index);
            let truth = trace(&case);
            let hit = truth.hit.unwrap();
            let point = super::super::to_f64(&hit.point);
            let inside = case.semi_diameter.unwrap() * 1.06;
            assert!(point[0].hypot(point[1]) < inside, "{} {index}: {point:?}", category.name());
        }
    }
}

/// A ray from a place that is no machine number starts there, and not at the nearest that is one.
#[test]
fn a_ray_from_elsewhere_starts_there() {
    let shape = Shape::Conic { curvature: 0.0, conic: 0.0 };
    let case = Case {
        shape,
        origin: [0.25, -1.0, -3.0],
        direction: [0.0, 0.0, 1.0],
        side: 1.0,
        n1: 1.0,
        n2: 1.5,
        mirror: false,
        semi_diameter: None,
        obstruction: 0.0,
    };
    let (origin, direction) = (case.origin.map(Big::new), case.direction.map(Big::new));
    assert!(is_same(&trace_from(&case, &origin, &direction), &trace(&case)));
    let little = Big::new(2f64.powi(-200));
    let beside = [&origin[0] + &little, origin[1].clone(), origin[2].clone()];
    let twice = times(&direction, &Big::new(2.0));
    let hit = trace_from(&case, &beside, &twice).hit.expect("a plane is met");
    assert_eq!(hit.point, [Big::new(0.25) + little, Big::new(-1.0), Big::new(0.0)]);
    assert_eq!(hit.t, Big::new(3.0));
}
