//! Albedos of facets for any index of refraction, from tables that are made when first asked for.

use super::albedo::AlbedoTable;
use super::fresnel::{self, F82Tint};
use std::sync::{Arc, LazyLock, OnceLock};

/// Steps of the index, even in [`place`]: between them the part of the way from the reflectance at normal incidence to 1
/// is off by less than 0.002.
const STEPS: usize = 32;

/// The tables of one index (above 1).
struct Dielectric {
    reflection: AlbedoTable,
    // Entering and leaving.
    boundary: [AlbedoTable; 2],
    eta: f32,
}

/// Albedo of facets that reflect everything, by roughness and cosine; one for all scenes.
pub fn reflection() -> &'static Arc<AlbedoTable> {
    static REFLECTION: LazyLock<Arc<AlbedoTable>> = LazyLock::new(|| Arc::new(AlbedoTable::reflection()));
    &REFLECTION
}

/// Makes the tables for an index ahead of time.
pub fn prepare(eta: f32) {
    let (step, _) = place(eta);
    step_at(step);
    step_at(step + 1);
}

/// The rise of a dielectric's mean reflectance at an angle, from 0 at normal incidence to 1; as in Cycles an index below 1 has that of its
/// inverse.
pub fn rise(eta: f32, roughness: f32, cos: f32) -> f32 {
    let single = reflection().at(roughness, cos).max(1e-3);
    let at = |d: &Dielectric| {
        let f0 = fresnel::f0_from_ior(d.eta);
        ((d.reflection.at(roughness, cos) / single - f0) / (1.0 - f0)).clamp(0.0, 1.0)
    };
    between(eta, at)
}

/// The means of [`F82Tint::terms`] over what facets of that roughness mirror towards that cosine.
pub fn metal_terms(roughness: f32, cos: f32) -> [f32; 2] {
    static TERMS: LazyLock<[AlbedoTable; 2]> =
        LazyLock::new(|| [0, 1].map(|term| AlbedoTable::reflecting(|cos| F82Tint::terms(cos)[term])));
    let single = reflection().at(roughness, cos).max(1e-3);
    [0, 1].map(|term| TERMS[term].at(roughness, cos) / single)
}

/// The part of the light that single scattering at a dielectric boundary keeps, reflection and transmission together: at an angle, and on
/// average over all angles.
pub fn boundary(eta: f32, roughness: f32, cos: f32) -> (f32, f32) {
    let side = usize::from(eta < 1.0);
    let kept = between(eta, |d| d.boundary[side].at(roughness, cos));
    (kept, between(eta, |d| d.boundary[side].average(roughness)))
}

fn between(eta: f32, value: impl Fn(&Dielectric) -> f32) -> f32 {
    let (step, part) = place(eta);
    value(step_at(step)) * (1.0 - part) + value(step_at(step + 1)) * part
}

/// The step below an index, and how far it is to the next.
fn place(eta: f32) -> (usize, f32) {
    let eta = if eta < 1.0 { 1.0 / eta.max(1e-5) } else { eta };
    // The fourth root of the reflectance: most indices lie near 1.
    let z = fresnel::f0_from_ior(eta).sqrt().sqrt() * STEPS as f32;
    let step = (z as usize).min(STEPS - 2);
    (step, (z - step as f32).clamp(0.0, 1.0))
}

fn step_at(step: usize) -> &'static Dielectric {
    static TABLES: [OnceLock<Box<Dielectric>>; STEPS] = [const { OnceLock::new() }; STEPS];
    TABLES[step].get_or_init(|| {
        let root = (step as f32 / STEPS as f32).powi(2);
        // An index of exactly 1 has no reflectance to be in proportion to.
        let eta = ((1.0 + root) / (1.0 - root)).max(1.0001);
        Box::new(Dielectric {
            reflection: AlbedoTable::dielectric_reflection(eta),
            boundary: [eta, 1.0 / eta].map(AlbedoTable::dielectric_boundary),
            eta,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between steps the tables say what a table of that very index says.
    #[test]
    fn any_index_is_as_its_own_table() {
        for eta in [1.2f32, 1.45, 2.1] {
            let own = AlbedoTable::dielectric_reflection(eta);
            let whole = [eta, 1.0 / eta].map(AlbedoTable::dielectric_boundary);
            for (roughness, cos) in [(0.1, 0.9), (0.5, 0.5), (0.9, 0.2)] {
                let f0 = fresnel::f0_from_ior(eta);
                let mean = f0 + (1.0 - f0) * rise(eta, roughness, cos);
                let found = mean * reflection().at(roughness, cos);
                // Linear between the steps of the index.
                assert!((found - own.at(roughness, cos)).abs() < 0.003, "{eta} {roughness} {cos}");
                for (side, eta) in [eta, 1.0 / eta].into_iter().enumerate() {
                    let (kept, _) = boundary(eta, roughness, cos);
                    assert!((kept - whole[side].at(roughness, cos)).abs() < 0.003, "{eta} {roughness} {cos}");
                }
            }
        }
    }
}
