use super::*;

const SIZE: [usize; 2] = [192, 108];

fn surfaces() -> Vec<Scatterer> {
    [50.0, 48.0, 30.0, 20.0]
        .into_iter()
        .enumerate()
        .map(|(surface, reach_mm)| Scatterer { surface, path_per_height: 0.5, reach_mm, is_open: true })
        .collect()
}

fn glare(scattering: Scattering) -> Glare {
    Glare::of_surfaces(&surfaces(), scattering, [0.1875; 2], SIZE)
}

/// The integrals of the shapes: Harvey's is one, an Airy pattern's is the area that its particle covers.
#[test]
fn shapes_hold_their_light() {
    for l in [0.003, 0.01, 0.02] {
        // ∫ 2π β (1 + (β/l)²)^(−3/4) dβ = 4π l² ((1 + 1/l²)^(1/4) − 1).
        let whole = 4.0 * PI * l * l * ((1.0f64 + 1.0 / (l * l)).powf(0.25) - 1.0);
        let shape = ScatterProfile::harvey(l);
        assert!((shape.at(1e-6) * whole - 1.0).abs() < 2e-3, "{l}: {}", shape.at(1e-6) * whole);
    }
    let d = 20.0;
    let one = ScatterProfile::of(|sine| 0.25 * PI * (d / 0.55f64).powi(2) * airy(PI * d * sine / 0.55));
    assert!((one.whole - 1.0).abs() < 0.02, "{}", one.whole);
}

/// TIS = (2π σ Δn / λ)² of each surface (549.1 nm): four of 2 nm.
#[test]
fn roughness_scatters_what_bennett_and_porteus_say() {
    let found = glare(Scattering { roughness_nm: 2.0, ..Scattering::NONE });
    let truth = 4.0 * (TAU * 2.0 * 0.5 / 549.1f64).powi(2);
    assert!((found.scattered()[1] / truth - 1.0).abs() < 1e-3, "{:?} {truth}", found.scattered());
    // Blue more than red, by the squares of their wavelengths.
    let [red, _, blue] = found.scattered();
    assert!((blue / red / (611.4f64 / 464.2).powi(2) - 1.0).abs() < 1e-3);
}

/// A cleaner lens scatters less; level 500 covers several hundredths of a per cent.
#[test]
fn dust_grows_with_its_level() {
    let part = |cleanliness| glare(Scattering { cleanliness, ..Scattering::NONE }).scattered()[1];
    assert_eq!(part(0.0), 0.0);
    assert!(part(100.0) > 0.0 && part(300.0) > 5.0 * part(100.0) && part(1000.0) > 5.0 * part(300.0));
    assert!(part(1000.0) < 1.0 && part(1e5) <= 1.0);
}

/// An even picture stays as it is; a point spreads the light that it loses, and black gets the index's part of an even world with a small
/// black hole.
#[test]
fn light_is_kept_and_the_index_is_that_of_iso_9358() {
    let scattering = Scattering::default();
    let glare = glare(scattering);
    let even = vec![Rgb::new(1.0, 0.5, 0.25); SIZE[0] * SIZE[1]];
    assert!(glare.change(&even, None).iter().all(|c| c.abs().max_element() < 1e-5));
    let mut hole = vec![Rgb::ONE; SIZE[0] * SIZE[1]];
    let middle = SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2;
    hole[middle] = Rgb::ZERO;
    let got = glare.change(&hole, None)[middle];
    let part = glare.part() as f32;
    assert!(got.y > 0.9 * scattering.veiling_index as f32 && got.y < 1.01 * part, "{got} {part}");
    // Twice the light on the front is twice the veil.
    let bare = Scattering { veiling_index: 0.01, ..Scattering::NONE };
    let bare = Glare::of_surfaces(&surfaces(), bare, [0.1875; 2], SIZE);
    let veil = |front| bare.change(&hole, Some(front))[middle].y;
    assert!((veil(2.0) / veil(1.0) - 2.0).abs() < 1e-5 && (veil(1.0) - 0.01).abs() < 1e-4);
    let mut point = vec![Rgb::ZERO; SIZE[0] * SIZE[1]];
    point[middle] = Rgb::splat(1e5);
    let bright = Scattering { veiling_index: 0.0, ..Scattering::default() };
    let change = Glare::of_surfaces(&surfaces(), bright, [0.1875; 2], SIZE).change(&point, None);
    let sum: f64 = change.iter().map(|c| f64::from(c.y)).sum();
    assert!(sum.abs() < 1.0 && change[middle].y < 0.0 && change[middle + 5].y > change[middle + 50].y);
    assert!(change.iter().enumerate().all(|(i, c)| i == middle || c.min_element() > -1e-4));
}
