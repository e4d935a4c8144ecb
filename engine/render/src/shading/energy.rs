//! Albedos of facets for any index of refraction, from tables that are part of the program: `data/albedos.bin`, written by the example
//! `albedos`. They would take half a second of a processor's time at the start of a render.

use super::albedo::{AlbedoTable, Entry, NUMBERS};
use super::fresnel::{self, F82Tint};
use std::sync::{Arc, LazyLock};

/// Steps of the index, even in [`place`]: between them the part of the way from the reflectance at normal incidence to 1
/// is off by less than 0.002.
const STEPS: usize = 32;
/// The numbers of all tables in the order of [`compute`], little-endian.
const DATA: &[u8; 4 * NUMBERS * (3 + 3 * STEPS)] = include_bytes!("../../data/albedos.bin");

/// The tables of one index (above 1).
struct Dielectric {
    reflection: AlbedoTable,
    // Entering and leaving.
    boundary: [AlbedoTable; 2],
    eta: f32,
}

/// All tables.
struct Tables {
    reflection: Arc<AlbedoTable>,
    metal: [AlbedoTable; 2],
    dielectrics: Box<[Dielectric]>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let mut left = DATA.as_chunks::<4>().0.as_chunks::<NUMBERS>().0.iter();
    let mut next = || AlbedoTable::of(&left.next().map_or([0.0; NUMBERS], |bytes| bytes.map(f32::from_le_bytes)));
    Tables {
        reflection: Arc::new(next()),
        metal: [next(), next()],
        dielectrics: (0..STEPS)
            .map(|step| Dielectric { reflection: next(), boundary: [next(), next()], eta: eta_of(step) })
            .collect(),
    }
});

/// Computes the tables anew, which takes seconds: of facets that reflect everything, of the terms of metals, and for each step of the index
/// of reflection and of the boundary, entering and leaving.
pub fn compute() -> impl Iterator<Item = AlbedoTable> {
    let first = [AlbedoTable::reflection(), metal_table(0), metal_table(1)];
    first.into_iter().chain((0..STEPS).flat_map(|step| {
        let eta = eta_of(step);
        let [enters, leaves] = [eta, 1.0 / eta].map(AlbedoTable::dielectric_boundary);
        [AlbedoTable::dielectric_reflection(eta), enters, leaves]
    }))
}

/// The means of one of [`F82Tint::terms`] over the light that facets mirror.
fn metal_table(term: usize) -> AlbedoTable {
    AlbedoTable::reflecting(|cos| F82Tint::terms(cos)[term])
}

/// Albedo of facets that reflect everything, by roughness and cosine; one for all scenes.
pub fn reflection() -> &'static Arc<AlbedoTable> {
    &TABLES.reflection
}

/// The rise of a dielectric's mean reflectance at an angle, from 0 at normal incidence to 1; as in Cycles an index below 1 has that of its
/// inverse.
pub fn rise(eta: f32, roughness: f32, cos: f32) -> f32 {
    Seen::new(roughness, cos).rise(eta)
}

/// Facets of a roughness, seen at an angle.
pub struct Seen {
    entry: Entry,
    /// The part of the light that single scattering keeps where facets reflect everything.
    pub kept: f32,
}

impl Seen {
    /// Facets of that roughness, seen at that cosine.
    #[inline]
    pub fn new(roughness: f32, cos: f32) -> Self {
        let entry = Entry::new(roughness, cos);
        Self { entry, kept: TABLES.reflection.at_entry(&entry) }
    }

    /// The mean of [`Self::kept`] over all angles.
    #[inline]
    pub fn average(&self) -> f32 {
        TABLES.reflection.average_at(&self.entry)
    }

    /// [`rise`] at this angle.
    #[inline]
    pub fn rise(&self, eta: f32) -> f32 {
        let single = self.kept.max(1e-3);
        let at = |d: &Dielectric| {
            let f0 = fresnel::f0_from_ior(d.eta);
            ((d.reflection.at_entry(&self.entry) / single - f0) / (1.0 - f0)).clamp(0.0, 1.0)
        };
        between(eta, at)
    }
}

/// The means of [`F82Tint::terms`] over the facets of that roughness that mirror towards that cosine.
pub fn metal_terms(roughness: f32, cos: f32) -> [f32; 2] {
    let Tables { reflection, metal, .. } = &*TABLES;
    let single = reflection.at(roughness, cos).max(1e-3);
    [0, 1].map(|term| metal[term].at(roughness, cos) / single)
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
    let dielectrics = &TABLES.dielectrics;
    value(&dielectrics[step]) * (1.0 - part) + value(&dielectrics[step + 1]) * part
}

/// The step below an index, and the part of the way to the next.
fn place(eta: f32) -> (usize, f32) {
    let eta = if eta < 1.0 { 1.0 / eta.max(1e-5) } else { eta };
    // The fourth root of the reflectance: most indices lie near 1.
    let z = fresnel::f0_from_ior(eta).sqrt().sqrt() * STEPS as f32;
    let step = (z as usize).min(STEPS - 2);
    (step, (z - step as f32).clamp(0.0, 1.0))
}

/// The index of a step.
fn eta_of(step: usize) -> f32 {
    let root = (step as f32 / STEPS as f32).powi(2);
    // An index of exactly 1 has no reflectance to be in proportion to.
    ((1.0 + root) / (1.0 - root)).max(1.0001)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tables of the program have the values of their integrals. Roundings of another processor put a point of the 1024 here and there
    /// on the other side of a limit.
    #[test]
    fn tables_are_those_that_are_computed() {
        let stored = |of: &AlbedoTable, table: &AlbedoTable| {
            table.numbers().zip(of.numbers()).all(|(a, b)| (a - b).abs() < 2.0 / 1024.0)
        };
        assert!(stored(reflection(), &AlbedoTable::reflection()));
        assert!(stored(&TABLES.metal[1], &metal_table(1)));
        for step in [0, 14, STEPS - 1] {
            let Dielectric { reflection, boundary, eta } = &TABLES.dielectrics[step];
            assert!(stored(reflection, &AlbedoTable::dielectric_reflection(*eta)), "{step}");
            assert!(stored(&boundary[0], &AlbedoTable::dielectric_boundary(*eta)), "{step}");
            assert!(stored(&boundary[1], &AlbedoTable::dielectric_boundary(1.0 / eta)), "{step}");
        }
    }

    /// Between steps the tables have the values of a table of that very index.
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
