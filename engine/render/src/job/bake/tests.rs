//! Tests of the light that types of bakes keep, and of points that are refused.

use super::*;

fn settings(kind: BakeKind) -> BakeSettings {
    BakeSettings {
        object_name: "Tile".into(),
        kind,
        from_camera: false,
        direct: true,
        indirect: true,
        color: true,
        diffuse: true,
        glossy: true,
        transmission: true,
        emission: true,
    }
}

#[test]
fn light_is_divided_by_its_colour_where_that_is_not_wanted() {
    let [near, far] = [true, false].map(|near| LightPass::Light(LobeKind::Glossy, near));
    let bake = settings(BakeKind::Glossy);
    assert_eq!(bake.result(), BakeResult::Light(vec![near, far]));
    let bake = BakeSettings { color: false, indirect: false, ..bake };
    assert_eq!(bake.result(), BakeResult::Relative(vec![near]));
    let bake = BakeSettings { color: true, direct: false, ..bake };
    assert_eq!(bake.result(), BakeResult::Relative(vec![LightPass::Colour(LobeKind::Glossy)]));
}

#[test]
fn all_light_is_the_picture_and_some_of_it_a_sum() {
    let bake = settings(BakeKind::Combined);
    assert_eq!(bake.result(), BakeResult::Picture);
    let bake = BakeSettings { indirect: false, diffuse: false, transmission: false, ..bake };
    let parts = vec![LightPass::Light(LobeKind::Glossy, true), LightPass::Volume(true), LightPass::Emission];
    assert_eq!(bake.result(), BakeResult::Light(parts));
    // Light that comes straight from emitters needs no bounces.
    assert_eq!(bake.applied(Settings::default()).max_bounces, 0);
}

#[test]
fn points_that_are_not_the_meshes_are_refused() {
    let table = BakeTable {
        primitives: vec![-1, 3],
        weights: vec![[0.0; 2]; 2],
        differentials: vec![[0.0; 4]; 2],
        seeds: Vec::new(),
    };
    assert!(matches!(table.clone().points("Tile", [2, 2], 4), Err(BakeError::Lengths(_))));
    let refused = table.clone().points("Tile", [2, 1], 3);
    assert!(matches!(refused, Err(BakeError::NoTriangle { triangle: 3, count: 3, .. })));
    let points = table.points("Tile", [2, 1], 4).unwrap();
    assert!(points[0].is_none() && points[1].is_some_and(|point| point.numbers_of == [1, 0]));
}
