//! Light in a half space of even scattering, by Chandrasekhar's H functions.

/// The part of the light straight into a half space of even scattering that comes back: 1 - H(1) sqrt(1 - albedo), with H by iterating its
/// integral equation (Chandrasekhar 1960, "Radiative Transfer", chapter V).
pub fn reflectance(albedo: f64) -> f64 {
    const PLACES: usize = 512;
    let at = |i: usize| (i as f64 + 0.5) / PLACES as f64;
    let least = (1.0 - albedo).sqrt();
    let of = |cos: f64, h: &[f64]| {
        let sum: f64 = h.iter().enumerate().map(|(i, h)| at(i) * h / (cos + at(i))).sum();
        1.0 / (least + 0.5 * albedo * sum / PLACES as f64)
    };
    let mut h = vec![1.0; PLACES];
    for _ in 0..60 {
        h = (0..PLACES).map(|i| 0.5 * (h[i] + of(at(i), &h))).collect();
    }
    1.0 - least * of(1.0, &h)
}
